//! What acts on the drive, and what it tells of itself.

use core::fmt;

use super::PpoDrive;
use crate::devices::ppo_drive::profile::{StwBit, ZswBit};
use crate::devices::ppo_drive::table::Row;
use crate::devices::ppo_drive::{Quantity, Settings, State};
use crate::face::description::{
    Amount, Bit, Curve, Denied, Exchange, Group, Parameter, ParameterAccess, ParameterPlace, Past, Value,
    Word,
};
use crate::face::surroundings::{Input, InputKind, Level};
use crate::face::{Description, DriveState, Surroundings, Why};
use crate::profibus::dp::Application;
use crate::profibus::pkw;
use crate::profibus::pkw::JobError;
use crate::profibus::ppo::{JobId, Pkw, ReplyId};
use crate::time::Instant;

/// The most load, in % of the rated torque.
const MOST_LOAD: f64 = 1000.0;

const fn number(name: &'static str, about: &'static str, high: f64) -> Input {
    Input { name, about, kind: InputKind::Number { low: 0.0, high, own: false } }
}

const FAULT: Input = number("fault_number", "raises the fault of this number", 65_535.0);
const WARNING: Input = number("warning_number", "the warning that stands, 0: none", 65_535.0);
const LOAD: Input = number("load_percent", "load, of the rated torque", MOST_LOAD);

/// Faults that stand, and those that were acknowledged, by their places in the buffer.
const STANDING: core::ops::RangeInclusive<u8> = 1..=8;
const ACKNOWLEDGED: core::ops::RangeInclusive<u8> = 9..=64;
const WARNINGS: core::ops::Range<u8> = 0..8;

/// Digits that say nothing are left out.
fn tenths(value: f64) -> f64 {
    libm::round(value * 10.0) / 10.0
}

/// 4000h is 100 %.
fn percent(value: i16) -> f64 {
    tenths(f64::from(value) / 163.84)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "float to integer saturates")]
const fn whole(number: f64) -> u16 {
    number as u16
}

impl<A: Application> PpoDrive<A> {
    fn faults(&self, places: core::ops::RangeInclusive<u8>) -> impl Iterator<Item = u16> {
        places.filter_map(|place| self.drive().faults().number(place)).filter(|number| *number != 0)
    }

    fn warnings(&self) -> impl Iterator<Item = u16> {
        WARNINGS.filter_map(|place| self.drive().warnings().number(place)).filter(|number| *number != 0)
    }

    fn shown(&self, quantity: Quantity) -> Amount<'static> {
        Amount::Number(tenths(self.drive().quantity(quantity, 1)))
    }
}

impl<A: Application> Surroundings for PpoDrive<A> {
    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        let first = |number: Option<u16>| Level::Number(number.unwrap_or(0).into());
        let warning = self.drive().status().warning.then(|| self.warnings().next()).flatten();
        tell(&FAULT, first(self.faults(STANDING).next()));
        tell(&WARNING, first(warning));
        tell(&LOAD, Level::Number(self.drive().quantity(Quantity::Load, 1)));
    }

    fn set_input(&mut self, now: Instant, name: &str, level: Level) {
        let Level::Number(number) = level else { return };
        if name == FAULT.name {
            self.raise_fault(now, whole(number));
        } else if name == WARNING.name {
            self.raise_warning(now, whole(number));
        } else if name == LOAD.name {
            // A load from 0 on is one.
            let _set = self.set_load(now, number.clamp(0.0, MOST_LOAD));
        }
    }

    fn nominal(&self, name: &str) -> Option<Level> {
        let usual = if name == LOAD.name { Settings::DEFAULT.load } else { 0.0 };
        Some(Level::Number(usual))
    }

    fn make_nominal(&mut self, now: Instant) {
        self.raise_warning(now, 0);
        let _set = self.set_load(now, Settings::DEFAULT.load);
    }

    fn is_drive(&self) -> bool {
        true
    }

    fn why(&self) -> Option<&dyn Why> {
        Some(self)
    }

    fn drive_state(&self) -> Option<DriveState> {
        Some(self.drive().status().state.into())
    }
}

impl<A: Application + 'static> Description for PpoDrive<A> {
    fn say_state(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        say(&self.drive().status().state);
    }

    fn tell_fault(&self, tell: &mut dyn FnMut(&dyn fmt::Display, &dyn fmt::Display)) {
        if self.drive().status().state == State::Fault {
            match self.faults(STANDING).next() {
                Some(number) => tell(&number, &"not acknowledged (947)"),
                None => tell(&"active", &""),
            }
        }
    }

    fn say_warning(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        if self.drive().status().warning {
            match self.warnings().next() {
                Some(number) => say(&format_args!("warning {number}")),
                None => say(&"warning"),
            }
        }
    }

    fn each_value(&self, tell: &mut dyn FnMut(Value<'_>)) {
        let value = |key, name, unit, amount| Value::new(key, name, Group::Motion, amount).unit(unit);
        let shown = |quantity| self.shown(quantity);
        let (actual, setpoint) = (percent(self.drive().status().actual), percent(self.command().setpoint));
        let speed = value("speed", "Speed", "rpm", shown(Quantity::ActualSpeed)).digits(0);
        tell(speed.curve(Curve::Own).headline());
        let actual = value("actual", "Actual value", "%", Amount::Number(actual)).digits(1);
        tell(actual.curve(Curve::Own).headline());
        let setpoint = value("setpoint", "Setpoint", "%", Amount::Number(setpoint)).digits(1);
        tell(setpoint.curve(Curve::SetpointOf("actual")));
        tell(value("reference", "Reference speed", "rpm", shown(Quantity::ReferenceSpeed)).digits(0));
        tell(value("ramp", "Ramp generator", "rpm", shown(Quantity::SetpointSpeed)).digits(0));
        tell(value("torque", "Torque", "%", shown(Quantity::Torque)).digits(0));
        tell(value("current", "Current", "A", shown(Quantity::Current)).digits(1).curve(Curve::Own));
    }

    fn each_word(&self, tell: &mut dyn FnMut(Word<'_>)) {
        let (stw, zsw) = (self.stw(), self.zsw());
        let of_stw = |number: u8| {
            let bit = StwBit::ALL.iter().find(|bit| bit.number() == number);
            bit.map_or_else(Bit::default, |bit| Bit { name: bit.name(), used: true, ..Bit::default() })
        };
        let of_zsw = |number: u8| {
            let bit = ZswBit::ALL.iter().find(|bit| bit.number() == number);
            bit.map_or_else(Bit::default, |bit| {
                let alarm = matches!(bit, ZswBit::Fault | ZswBit::Warning) && bit.is_set(zsw);
                Bit { name: bit.name(), used: true, alarm, ..Bit::default() }
            })
        };
        tell(Word { key: &"stw", name: &"Control word", value: stw.raw(), bit: &of_stw });
        tell(Word { key: &"zsw", name: &"Status word", value: zsw.raw(), bit: &of_zsw });
    }

    fn each_exchange(&self, tell: &mut dyn FnMut(Exchange<'_>)) {
        let (job, reply) = self.channel();
        let asked = (job.pke.job() != JobId::NoJob).then(|| job.pke.job());
        let asked =
            asked.map(|asked| Dialogue { pkw: job, what: asked, row: self.table().row(job.pke.pnu()) });
        let answered = (reply.pke.reply() != ReplyId::NoReply).then(|| reply.pke.reply());
        let answered =
            answered.map(|what| Dialogue { pkw: reply, what, row: self.table().row(reply.pke.pnu()) });
        tell(Exchange {
            key: &"outputs",
            name: &"Parameter channel and STW, setpoint",
            from_master: true,
            octets: self.slave().outputs(),
            forced: None,
            details: asked.as_ref().map(|asked| asked as &dyn fmt::Display),
            each_entry: &|_| {},
        });
        tell(Exchange {
            key: &"inputs",
            name: &"Parameter channel and ZSW, actual value",
            from_master: false,
            octets: self.slave().inputs(),
            forced: None,
            details: answered.as_ref().map(|answered| answered as &dyn fmt::Display),
            each_entry: &|_| {},
        });
    }

    fn each_past(&self, tell: &mut dyn FnMut(Past<'_>)) {
        let mut past =
            |number: u16, text: &'static str| tell(Past { code: &number, text: &text, when: None });
        self.faults(STANDING).for_each(|number| past(number, "not acknowledged (947)"));
        self.faults(ACKNOWLEDGED).for_each(|number| past(number, "acknowledged"));
        self.warnings().for_each(|number| past(number, "warning (953)"));
    }

    fn each_parameter(&self, tell: &mut dyn FnMut(Parameter<'_>)) {
        for row in self.table().rows() {
            let value = |element| {
                let value = self.read_parameter(row.pnu, element).map_or(0, pkw::Value::bits);
                Some(row.kind.value(value)).filter(|value| value.is_finite())
            };
            tell(Parameter {
                number: row.pnu,
                name: &row.name,
                unit: &row.unit,
                elements: row.elements.map(|count| (1, count)),
                value: &value,
                say: &|element, say| say_value(row, value(element), say),
                choices: &[],
                access: if row.writable { ParameterAccess::ReadWrite } else { ParameterAccess::ReadOnly },
                low: Some(row.low),
                high: Some(row.high),
                usual: row.default.as_ref().and_then(|all| all.first().copied()),
                kept: row.writable,
                writable_when: "",
            });
        }
    }

    fn check_parameter(
        &self,
        ParameterPlace { number, element }: ParameterPlace,
        say: &mut dyn FnMut(&dyn fmt::Display),
    ) -> Result<(), Denied> {
        let read = self.read_parameter(number, element);
        read.map(drop).map_err(|error| refuse(number, error, say))
    }

    fn write_parameter(
        &mut self,
        now: Instant,
        ParameterPlace { number, element }: ParameterPlace,
        value: f64,
        say: &mut dyn FnMut(&dyn fmt::Display),
    ) -> Result<(), Denied> {
        let Some(row) = self.table().row(number) else {
            return Err(refuse(number, JobError::UnknownParameter { got: number }, say));
        };
        let bits = row.kind.bits(value);
        let fits = (row.low..=row.high).contains(&value) && (bits != 0 || value.abs() < 1.0);
        if !fits {
            return Err(refuse(number, JobError::outside(row.low, row.high, value), say));
        }
        let [_, _, high, low] = bits.to_be_bytes();
        let value = match row.kind.is_double() {
            true => pkw::Value::Double(bits),
            false => pkw::Value::Word(u16::from_be_bytes([high, low])),
        };
        let written = Self::write_parameter(self, now, number, element, value);
        written.map_err(|error| refuse(number, error, say))
    }
}

fn refuse(number: u16, error: JobError, say: &mut dyn FnMut(&dyn fmt::Display)) -> Denied {
    say(&format_args!("PNU {number}: {error}"));
    match error {
        JobError::UnknownParameter { .. } => Denied::Unknown,
        JobError::ReadOnly => Denied::NotNow,
        JobError::NoElement { .. } | _ => Denied::Value,
    }
}

/// The number on the bus, and what it is in its unit.
fn say_value(row: &Row, number: Option<f64>, say: &mut dyn FnMut(&dyn fmt::Display)) {
    let gap = if row.unit.is_empty() { "" } else { " " };
    match number {
        None => say(&"?"),
        Some(number) if (row.scale - 1.0).abs() < f64::EPSILON => {
            say(&format_args!("{number}{gap}{}", row.unit));
        }
        Some(number) => {
            // A scale such as 0.1 is no whole number of halves.
            let shown = libm::round(number * row.scale * 1e6) / 1e6;
            say(&format_args!("{number} ({shown}){gap}{}", row.unit));
        }
    }
}

/// A job or a reply of the parameter channel in words.
struct Dialogue<'a, W> {
    pkw: Pkw,
    what: W,
    row: Option<&'a Row>,
}

impl<W: fmt::Display> fmt::Display for Dialogue<'_, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pkw, what, row } = self;
        write!(f, "{pkw}  {what}, PNU {}", pkw.pke.pnu())?;
        match pkw.ind.high_octet() {
            0 => {}
            element => write!(f, ".{element}")?,
        }
        if let Some(row) = row {
            write!(f, " {}", row.name)?;
        }
        write!(f, ", value {}", pkw.double_word())
    }
}
