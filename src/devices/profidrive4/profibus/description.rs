//! What acts on the drive, and what it tells of itself.

use core::fmt;

use super::application::TelegramOnly;
use super::signal::Signal;
use super::table::Entry;
use super::telegram::Telegram;
use super::{ProfidriveDevice, bits, value};
use crate::devices::ppo_drive::profile::ZswBit;
use crate::devices::profidrive4::{Fault, Setpoint, Setting, Warnings};
use crate::devices::servo::inputs::Inputs;
use crate::face::description::{
    Amount, Bit, Curve, Denied, Exchange, ExchangeEntry, Group, Parameter, ParameterAccess, ParameterPlace,
    Past, Value, Word,
};
use crate::face::surroundings::{Declined, Input, InputKind, Level, Provocable};
use crate::face::{Acyclic, Description, DriveState, Surroundings, Why};
use crate::profibus::dp::Application;
use crate::profibus::dpv1::base_mode::ParameterError;
use crate::time::Instant;

const fn number(name: &'static str, about: &'static str) -> Input {
    Input { name, about, kind: InputKind::Number { low: 0.0, high: 65_535.0, own: false } }
}

const FAULT: Input = number("fault_number", "raises the fault of this number");
const PROBES: [Input; 2] = [
    Input { name: "probe_1", about: "measuring probe 1 is closed", kind: InputKind::Switch },
    Input { name: "probe_2", about: "measuring probe 2 is closed", kind: InputKind::Switch },
];
const WARNING: Input = number("warning_number", "the warning that stands, 0: none");

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "float to integer saturates")]
const fn whole(number: f64) -> u16 {
    number as u16
}

/// Digits that say nothing are left out.
fn tenths(value: f64) -> f64 {
    libm::round(value * 10.0) / 10.0
}

impl<A: Application> ProfidriveDevice<TelegramOnly<A>> {
    fn first_fault(&self) -> Option<Fault> {
        self.drive().standing_faults().next().map(|fault| Fault::numbered(fault.number))
    }

    fn first_warning(&self) -> Option<u16> {
        self.drive().warnings().standing().first().copied()
    }

    /// The value of an element, if there is one.
    fn read(&self, pnu: u16, element: Option<u8>) -> Result<f64, ParameterError> {
        let known = self.known();
        let missing = ParameterError(0);
        let entry = self.parameters.table.entry(pnu).ok_or(missing)?;
        let element = u16::from(element.unwrap_or(0));
        let there = self.parameters.check_elements(entry, &known, (element, 1));
        there.map_err(|(error, _)| error)?;
        Ok(self.parameters.value(entry, &known, element))
    }
}

impl<A: Application> Surroundings for ProfidriveDevice<TelegramOnly<A>> {
    fn each_fault(&self, tell: &mut dyn FnMut(Provocable<'_>)) {
        for fault in Fault::ALL {
            let mut standing = self.drive().standing_faults();
            let present = standing.any(|standing| standing.number == fault.number());
            let inputs = self.drive().inputs();
            let provoked = match fault {
                Fault::MainCircuit => !inputs.main_circuit,
                Fault::Blocked => inputs.blocked,
                Fault::LimitSwitch => inputs.pressed.negative_limit || inputs.pressed.positive_limit,
                Fault::Communication
                | Fault::Overload
                | Fault::SignOfLife
                | Fault::FollowingError
                | Fault::Homing
                | Fault::Block
                | Fault::Raised(_) => false,
            };
            tell(Provocable { name: &fault.name(), text: &fault.words(), present, provoked });
        }
    }

    fn provoke(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let fault = Fault::ALL.iter().find(|known| known.name() == fault).ok_or(Declined::Unknown)?;
        self.raise_fault(now, *fault);
        Ok(())
    }

    fn take_back(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let fault = Fault::ALL.iter().find(|known| known.name() == fault).ok_or(Declined::Unknown)?;
        let inputs = self.parameters.drive.inputs_mut();
        match fault {
            Fault::MainCircuit => inputs.main_circuit = true,
            Fault::Blocked => inputs.blocked = false,
            // They have no cause that stays.
            Fault::LimitSwitch => inputs.pressed = Inputs::NOMINAL.pressed,
            Fault::Communication
            | Fault::Overload
            | Fault::SignOfLife
            | Fault::FollowingError
            | Fault::Homing
            | Fault::Block
            | Fault::Raised(_) => {}
        }
        self.cycles.wake(now);
        Ok(())
    }

    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        let first = |number: Option<u16>| Level::Number(number.unwrap_or(0).into());
        tell(&FAULT, first(self.first_fault().map(Fault::number)));
        tell(&WARNING, first(self.first_warning()));
        self.drive().inputs().each_level(tell);
        for (probe, closed) in PROBES.iter().zip(self.drive().probes()) {
            tell(probe, Level::Switch(closed));
        }
    }

    fn set_input(&mut self, now: Instant, name: &str, level: Level) {
        match level {
            Level::Number(number) if name == FAULT.name => {
                self.raise_fault(now, Fault::numbered(whole(number)));
            }
            Level::Number(number) if name == WARNING.name => {
                self.parameters.drive.end_raised_warnings();
                if number >= 1.0 {
                    self.parameters.drive.warn(whole(number), true);
                }
            }
            Level::Switch(on) if PROBES.iter().any(|probe| probe.name == name) => {
                let drive = &mut self.parameters.drive;
                let mut probes = drive.probes();
                let own = probes.iter_mut().zip(&PROBES).filter(|(_, probe)| probe.name == name);
                own.for_each(|(closed, _)| *closed = on);
                drive.set_probes(probes);
            }
            Level::Number(_) | Level::Switch(_) | Level::Own => {
                self.parameters.drive.inputs_mut().change(name, level);
            }
        }
        self.cycles.wake(now);
    }

    fn nominal(&self, name: &str) -> Option<Level> {
        let is_number = name == FAULT.name || name == WARNING.name;
        let is_probe = PROBES.iter().any(|probe| probe.name == name);
        match () {
            () if is_number => Some(Level::Number(0.0)),
            () if is_probe => Some(Level::Switch(false)),
            () => Inputs::NOMINAL.level(name),
        }
    }

    fn make_nominal(&mut self, now: Instant) {
        self.parameters.drive.end_raised_warnings();
        *self.parameters.drive.inputs_mut() = Inputs::NOMINAL;
        self.parameters.drive.set_probes([false; 2]);
        self.cycles.wake(now);
    }

    fn is_drive(&self) -> bool {
        true
    }

    fn why(&self) -> Option<&dyn Why> {
        Some(self)
    }

    fn drive_state(&self) -> Option<DriveState> {
        let status = self.drive().status();
        Some(if status.fault { DriveState::Fault } else { status.state.into() })
    }
}

impl<A: Application + 'static> Description for ProfidriveDevice<TelegramOnly<A>> {
    fn acyclic(&self) -> Option<&dyn Acyclic> {
        Some(self)
    }

    fn acyclic_mut(&mut self) -> Option<&mut dyn Acyclic> {
        Some(self)
    }

    fn say_state(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        let status = self.drive().status();
        match status.fault {
            true => say(&format_args!("{}, fault", status.state)),
            false => say(&status.state),
        }
    }

    fn tell_fault(&self, tell: &mut dyn FnMut(&dyn fmt::Display, &dyn fmt::Display)) {
        if let Some(fault) = self.first_fault() {
            tell(&fault.number(), &fault.words());
        }
    }

    fn say_warning(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        if let Some(number) = self.first_warning() {
            say(&format_args!("warning {number}: {}", Warnings::words(number)));
        }
    }

    fn each_value(&self, tell: &mut dyn FnMut(Value<'_>)) {
        let (status, settings) = (self.drive().status(), self.drive().settings());
        let value = |key, name, unit, number| {
            Value::new(key, name, Group::Motion, Amount::Number(tenths(number))).unit(unit)
        };
        let reference = settings.of(Setting::ReferenceSpeed);
        tell(value("speed", "Speed", "rpm", status.speed).digits(0).curve(Curve::Own).headline());
        match self.drive().command().setpoint {
            Setpoint::Speed(setpoint) => {
                let setpoint = value("setpoint", "Setpoint", "rpm", setpoint * reference).digits(0);
                tell(setpoint.curve(Curve::SetpointOf("speed")).headline());
            }
            Setpoint::Position(_) => {
                let axis = self.drive().axis();
                tell(
                    value("position", "Position", "LU", axis.position).digits(0).curve(Curve::Own).headline(),
                );
                let target = Value::new("target", "Target", Group::Motion, Amount::from(axis.target));
                tell(target.unit("LU").digits(0).curve(Curve::SetpointOf("position")));
                let referenced = Amount::Flag(axis.referenced);
                tell(Value::new("referenced", "Position has a reference", Group::Motion, referenced));
            }
        }
        tell(value("ramp", "Ramp generator", "rpm", status.demand).digits(0));
        tell(value("reference", "Reference speed", "rpm", reference).digits(0));
        let turns = self.drive().shaft() / crate::devices::servo::plant::INCREMENTS_PER_REVOLUTION;
        tell(value("shaft", "Shaft", "turns", turns).digits(1).curve(Curve::Own));
        let torque = Value::new("torque", "Torque", Group::Measured, Amount::Number(status.torque));
        tell(torque.unit("Nm").digits(2).curve(Curve::Own));
        let current = Value::new("current", "Current", Group::Measured, Amount::Number(status.current));
        tell(current.unit("A").digits(1).curve(Curve::Own));
        let number = self.telegram().map(|telegram| telegram.number.into());
        tell(Value::new("telegram", "Telegram", Group::Slave, Amount::from(number)).digits(0));
    }

    fn each_word(&self, tell: &mut dyn FnMut(Word<'_>)) {
        let usual = Telegram::numbered(1);
        let Some(telegram) = &self.telegram().or(usual.cloned()) else { return };
        let (outputs, inputs) = (self.slave().outputs(), self.slave().inputs());
        let setpoints = telegram.setpoints.iter().map(|signal| (signal, telegram.setpoint(outputs, *signal)));
        let actual =
            telegram.actual_values.iter().map(|signal| (signal, telegram.actual_value(inputs, *signal)));
        for (signal, value) in setpoints.chain(actual) {
            let name = |number| bits::bit_name(telegram, *signal, number);
            if (0..16).all(|number| name(number).is_none()) {
                continue;
            }
            let value = if *signal == Signal::Stw1 {
                self.stw1()
            } else if *signal == Signal::Zsw1 {
                // Also without a master.
                self.zsw1()
            } else {
                value.and_then(|value| u16::try_from(value).ok()).unwrap_or_default()
            };
            let needs_somebody = |number: u8| {
                let alarms = [ZswBit::Fault, ZswBit::Warning];
                *signal == Signal::Zsw1
                    && alarms.iter().any(|bit| bit.number() == number && bit.is_set(value))
            };
            let bit = |number: u8| {
                let bit = |name| Bit { name, used: true, alarm: needs_somebody(number), ..Bit::default() };
                name(number).map_or_else(Bit::default, bit)
            };
            tell(Word { key: &signal.key(), name: &signal.about(), value, bit: &bit });
        }
    }

    fn each_exchange(&self, tell: &mut dyn FnMut(Exchange<'_>)) {
        let telegram = self.telegram();
        let (outputs, inputs) = (self.slave().outputs(), self.slave().inputs());
        let telegram = telegram.as_ref();
        let signals = |from_master: bool| match telegram {
            Some(telegram) if from_master => &*telegram.setpoints,
            Some(telegram) => &*telegram.actual_values,
            None => &[],
        };
        for (key, name, from_master, octets) in
            [("outputs", "Setpoints", true, outputs), ("inputs", "Actual values", false, inputs)]
        {
            tell(Exchange {
                key: &key,
                name: &name,
                from_master,
                octets,
                forced: None,
                details: None,
                each_entry: &|tell| each_signal(signals(from_master), octets, tell),
            });
        }
    }

    fn each_past(&self, tell: &mut dyn FnMut(Past<'_>)) {
        for place in 0..64 {
            let Some(fault) = self.drive().faults().noted(place).filter(|fault| fault.number != 0) else {
                continue;
            };
            let words = Fault::numbered(fault.number).words();
            let state = if place < 8 { "not acknowledged" } else { "acknowledged" };
            let seconds = f64::from(fault.millis) / 1000.0;
            tell(Past {
                code: &fault.number,
                text: &format_args!("{words}, {state}"),
                when: Some(&format_args!("{seconds:.1} s after switching on")),
            });
        }
        for number in (0..8).map(|before| self.drive().warnings().last(before)).filter(|number| *number != 0)
        {
            tell(Past {
                code: &number,
                text: &format_args!("warning: {}", Warnings::words(number)),
                when: None,
            });
        }
    }

    fn each_parameter(&self, tell: &mut dyn FnMut(Parameter<'_>)) {
        let known = self.known();
        for (pnu, entry) in self.parameters.table.entries() {
            let value = |element: Option<u8>| {
                let element = u16::from(element.unwrap_or(0));
                Some(self.parameters.value(entry, &known, element)).filter(|value| value.is_finite())
            };
            let count = self.parameters.count(entry, &known);
            let (low, high) = entry.limits;
            tell(Parameter {
                number: pnu,
                name: &entry.name,
                unit: &entry.unit,
                elements: count.map(|count| (0, u8::try_from(count).unwrap_or(u8::MAX))),
                value: &value,
                say: &|element, say| say_value(entry, value(element), say),
                choices: &[],
                access: if entry.is_writable(&known) {
                    ParameterAccess::ReadWrite
                } else {
                    ParameterAccess::ReadOnly
                },
                low: Some(low),
                high: Some(high),
                usual: None,
                kept: entry.is_kept() || entry.way().is_some(),
                writable_when: "",
            });
        }
    }

    fn check_parameter(
        &self,
        ParameterPlace { number, element }: ParameterPlace,
        say: &mut dyn FnMut(&dyn fmt::Display),
    ) -> Result<(), Denied> {
        self.read(number, element).map(drop).map_err(|error| refuse(number, error, say))
    }

    fn write_parameter(
        &mut self,
        now: Instant,
        ParameterPlace { number, element }: ParameterPlace,
        value: f64,
        say: &mut dyn FnMut(&dyn fmt::Display),
    ) -> Result<(), Denied> {
        let known = self.known();
        let place = u16::from(element.unwrap_or(0));
        let checked = self.parameters.table.entry(number).ok_or((ParameterError(0), 0)).and_then(|entry| {
            self.parameters.check_elements(entry, &known, (place, 1))?;
            self.parameters.check_writable(entry, &known, place)?;
            self.parameters.check_value(entry, place, value)?;
            // As it would come by the bus.
            Ok(value::of_bits(entry.format, value::bits(entry.format, value)))
        });
        let value = checked.map_err(|(error, _)| refuse(number, error, say))?;
        self.parameters.set(number, place, value);
        self.carry_out(now);
        self.cycles.wake(now);
        Ok(())
    }
}

/// The signals in the octets of one direction.
fn each_signal(signals: &[Signal], octets: &[u8], tell: &mut dyn FnMut(ExchangeEntry<'_>)) {
    let mut at = 0;
    for signal in signals {
        let end = at + 2 * signal.words();
        let value = octets
            .get(at..end)
            .map(|octets| octets.iter().fold(0_u32, |value, octet| value << 8 | u32::from(*octet)));
        tell(ExchangeEntry {
            name: signal.name(),
            place: &format_args!("octets {at} to {}, {}", end - 1, signal.about()),
            amount: Amount::from(value.map(f64::from)),
            unit: "",
        });
        at = end;
    }
}

fn refuse(number: u16, error: ParameterError, say: &mut dyn FnMut(&dyn fmt::Display)) -> Denied {
    say(&format_args!("PNU {number}: error {:02X}h, {}", error.0, error.words()));
    match error.0 {
        0x00 | 0x03 | 0x04 => Denied::Unknown,
        0x01 | 0x0B | 0x11 => Denied::NotNow,
        _ => Denied::Value,
    }
}

/// The number on the bus, its unit, and what it stands for.
fn say_value(entry: &Entry, number: Option<f64>, say: &mut dyn FnMut(&dyn fmt::Display)) {
    let Some(number) = number else { return say(&"?") };
    let gap = if entry.unit.is_empty() { "" } else { " " };
    let text = entry.texts.get(usize::from(whole(number))).filter(|text| !text.is_empty());
    match text {
        Some(text) => say(&format_args!("{number} ({text})")),
        None if (entry.scale - 1.0).abs() < f64::EPSILON => say(&format_args!("{number}{gap}{}", entry.unit)),
        None => {
            let shown = libm::round(number * entry.scale * 1e6) / 1e6;
            say(&format_args!("{number} ({shown}){gap}{}", entry.unit));
        }
    }
}
