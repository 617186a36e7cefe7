//! What the drive tells of itself.

use core::fmt;

use super::bits::{Role, bits};
use super::job::Values;
use super::{Device, DipSwitches, Power, bits, words};
use crate::devices::ag03::description::{Observed, each_past, length, memory, state, tell_switches};
use crate::devices::ag03::drive::{Fault, Mode, State};
use crate::devices::ag03::param::{
    self, Access, Entry, Kind, Lengths, ParamError, Pnu, Subindex, Unit, Width, WritableWhen,
};
use crate::face::Description;
use crate::face::description::{
    Amount, Bit, Denied, Exchange, ExchangeEntry, Parameter, ParameterAccess, ParameterPlace, Past, Supply,
    Switches, Value, Word,
};
use crate::profibus::ppo::{Inputs, Outputs, PPO_LEN};
use crate::time::Instant;

/// Words of bits: key, name, which, and the bits whose 1 needs somebody.
const WORDS: [(&str, &str, bits::Word, u16); 4] = [
    ("stw", "Control word", bits::Word::Stw, 0),
    ("zsw", "Status word", bits::Word::Zsw, 0x40C8),
    ("ssw", "System status word", bits::Word::Ssw, 0xB560),
    ("general_status", "General status register", bits::Word::GeneralStatus, 0),
];

const NO_OUTPUTS: &[u8; PPO_LEN] = &[0; PPO_LEN];

impl Device {
    /// What a parameter counts positions in: a setting as the spindle pitch is programmed, a reading as the drive moves.
    fn lengths_of(&self, entry: &Entry) -> Lengths {
        match entry.kind {
            Kind::Setting(_) | Kind::LoadParameterSet => {
                let pitch = self.parameters().value(param::Parameter::SpindlePitch);
                Lengths::of_spindle_pitch(pitch.cast_unsigned())
            }
            Kind::Reading(_) => self.drive().lengths(),
        }
    }

    /// The outputs as the slave passes them; all zero if they are no PPO.
    fn outputs(&self) -> Outputs<'_> {
        Outputs::new(self.slave().outputs().first_chunk().unwrap_or(NO_OUTPUTS))
    }

    fn observed(&self) -> Observed<'_> {
        let released = self.status().state == State::VelocityTravelling;
        Observed {
            model: self.config().model,
            drive: self.drive(),
            status: self.status(),
            released_rpm: released.then(|| self.outputs().hsw()),
        }
    }

    fn word(&self, word: bits::Word) -> u16 {
        match word {
            bits::Word::Stw => self.outputs().stw().raw(),
            bits::Word::Zsw => self.zsw().raw(),
            bits::Word::Ssw => self.system_status(),
            bits::Word::GeneralStatus => words::general_status(self.status()),
        }
    }

    fn read_place(&self, entry: &Entry, element: Option<u8>) -> param::Value {
        // What cannot be read, as a command, is 0.
        let read = self.read_parameter(entry.pnu, element.map(Subindex));
        read.unwrap_or_else(|_| param::Value::of(entry.width, 0))
    }

    fn tell_parameter(&self, entry: &'static Entry, tell: &mut dyn FnMut(Parameter<'_>)) {
        let range = self.parameters().range_of(entry);
        let setting = match entry.kind {
            Kind::Setting(setting) => Some(setting),
            Kind::Reading(_) | Kind::LoadParameterSet => None,
        };
        tell(Parameter {
            number: entry.pnu.number(),
            name: entry.name,
            unit: &entry.unit,
            elements: entry.elements.map(|count| (0, count)),
            value: &|element| {
                #[expect(clippy::cast_precision_loss, reason = "no parameter has more than 32 bits")]
                let number = entry.number(self.read_place(entry, element)) as f64;
                Some(number)
            },
            say: &|element, say| {
                let value = self.read_place(entry, element);
                if let Unit::Ascii = entry.unit {
                    say_fault(value.bits(), say);
                } else {
                    say(&entry.in_words(entry.number(value), self.lengths_of(entry)));
                }
            },
            choices: if let Unit::Choice(choices) = entry.unit { choices } else { &[] },
            access: match entry.access() {
                Access::ReadOnly => ParameterAccess::ReadOnly,
                Access::ReadWrite => ParameterAccess::ReadWrite,
                Access::WriteOnly => ParameterAccess::WriteOnly,
            },
            low: range.map(|range| range.low.into()),
            high: range.map(|range| range.high.into()),
            usual: setting.map(|setting| setting.default.into()),
            kept: entry.persistent,
            writable_when: match setting.map(|setting| setting.writable) {
                Some(WritableWhen::Standstill) => "standstill",
                Some(WritableWhen::NoJob) => "no_job",
                Some(WritableWhen::Always) | None => "",
            },
        });
    }

    fn refuse(&self, number: u16, error: ParamError, say: &mut dyn FnMut(&dyn fmt::Display)) -> Denied {
        let entry = Pnu::new(number).ok().and_then(|pnu| self.parameters().entry(pnu).ok());
        match entry {
            Some(entry) if matches!(error, ParamError::OutOfRange { .. }) => {
                say(&format_args!("PNU {number} ({}): {error}{}", entry.name, Values(entry)));
            }
            Some(entry) => say(&format_args!("PNU {number} ({}): {error}", entry.name)),
            None => say(&format_args!("PNU {number}: {error}")),
        }
        match error {
            ParamError::UnknownParameter { .. } => Denied::Unknown,
            ParamError::ReadOnly | ParamError::NotNow(_) => Denied::NotNow,
            ParamError::OutOfRange { .. }
            | ParamError::SubindexOutOfRange { .. }
            | ParamError::NotAnArray
            | ParamError::IsArray { .. }
            | ParamError::WrongWidth { .. } => Denied::Value,
        }
    }

    fn pnu(number: u16) -> Result<Pnu, ParamError> {
        Pnu::new(number).map_err(|_| ParamError::UnknownParameter { got: Pnu::from_low_bits(number) })
    }
}

/// An element of the fault buffer, PNU 945.
fn say_fault(code: u32, say: &mut dyn FnMut(&dyn fmt::Display)) {
    match Fault::ALL.into_iter().find(|fault| u32::from(fault.code()) == code) {
        Some(fault) => say(&format_args!("fault {fault}")),
        None if code == 0 => say(&"no fault"),
        None if matches!(code, 0x48 | 0x49) => {
            say(&format_args!("{code:02X}h (a fault of the CANopen drive)"));
        }
        None => say(&format_args!("{code:02X}h (no fault code)")),
    }
}

/// The value that a parameter of this width takes.
fn written(entry: &Entry, number: u16, value: f64, say: &mut dyn FnMut(&dyn fmt::Display)) -> Option<i32> {
    if (value - libm::trunc(value)).abs() > 0.0 {
        say(&format_args!("PNU {number} takes whole numbers; got {value}"));
        return None;
    }
    let (low, high) = match entry.width {
        Width::Word => (0.0, 65_535.0),
        Width::Double => (f64::from(i32::MIN), f64::from(i32::MAX)),
    };
    if !(low..=high).contains(&value) {
        match entry.width {
            Width::Word => say(&format_args!("PNU {number} is a word, 0 to 65535; got {value}")),
            Width::Double => say(&format_args!("the value must be within 32 bits, got {value}")),
        }
        return None;
    }
    #[expect(clippy::cast_possible_truncation, reason = "whole and within 32 bits")]
    let whole = value as i32;
    Some(whole)
}

impl Description for Device {
    fn supply(&self) -> Option<Supply> {
        Some(match self.power() {
            Power::Off => Supply::Off,
            Power::On => Supply::On,
            Power::FactoryReset(_) => Supply::FactoryReset,
        })
    }

    fn switch_supply(&mut self, now: Instant, on: bool) {
        if on {
            self.power_on(now);
        } else {
            self.power_off(now);
        }
    }

    fn say_state(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        say(&state(self.status().state));
    }

    fn tell_fault(&self, tell: &mut dyn FnMut(&dyn fmt::Display, &dyn fmt::Display)) {
        self.observed().tell_fault(tell);
    }

    fn say_warning(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        self.observed().say_warning(say);
    }

    fn each_value(&self, tell: &mut dyn FnMut(Value<'_>)) {
        self.observed().each_value(tell);
    }

    fn each_word(&self, tell: &mut dyn FnMut(Word<'_>)) {
        let (mode, model) = (self.status().mode, self.config().model);
        for (key, name, word, alarms) in WORDS {
            let (value, rows) = (self.word(word), bits(word, mode, Some(model)));
            let bit = |bit: u8| {
                let (Some(row), set) = (rows.get(usize::from(bit)), value >> bit & 1 != 0) else {
                    return Bit::default();
                };
                let used = match row.role {
                    Role::Level | Role::Edge => true,
                    Role::Fixed(_) | Role::Unused => false,
                };
                let alarm = used && set && alarms >> bit & 1 != 0;
                Bit { key: row.key, name: row.name, meaning: row.meaning(set), note: row.note, used, alarm }
            };
            tell(Word { key: &key, name: &name, value, bit: &bit });
        }
    }

    fn each_exchange(&self, tell: &mut dyn FnMut(Exchange<'_>)) {
        let entry = |name: &'static str, number: i32| {
            let (amount, unit) = match self.status().mode {
                Mode::Velocity => (Amount::Number(number.into()), "rpm"),
                Mode::Positioning => {
                    let (amount, unit, _) = length(self.drive().lengths(), Some(number.into()));
                    (amount, unit)
                }
            };
            move |tell: &mut dyn FnMut(ExchangeEntry<'_>)| {
                tell(ExchangeEntry { name, place: &"octets 11 to 14", amount, unit });
            }
        };
        let inputs: [u8; PPO_LEN] = self.slave().inputs().first_chunk().copied().unwrap_or_default();
        let exchange = Exchange {
            key: &"outputs",
            name: &"PPO outputs",
            from_master: true,
            octets: self.slave().outputs(),
            forced: None,
            details: None,
            each_entry: &entry("HSW", self.outputs().hsw()),
        };
        tell(exchange);
        let each_entry = &entry("HIW", Inputs::new(&inputs).hiw());
        let of_drive = Exchange { key: &"inputs", name: &"PPO inputs", from_master: false, ..exchange };
        tell(Exchange { octets: &inputs, each_entry, ..of_drive });
    }

    fn each_past(&self, tell: &mut dyn FnMut(Past<'_>)) {
        each_past(self.fault_codes(), tell);
    }

    fn tell_switches(&self, tell: &mut dyn FnMut(Switches<'_>)) {
        let config = self.config();
        let (wanted, in_force) = (config.switches.address().number(), self.address().number());
        tell_switches(config.switches, config.reset_patterns, ("address", wanted, in_force), tell);
    }

    fn set_switches(&mut self, positions: u16) {
        Self::set_switches(self, DipSwitches::from_bits(positions));
    }

    fn each_parameter(&self, tell: &mut dyn FnMut(Parameter<'_>)) {
        for entry in param::parameters(self.config().model) {
            self.tell_parameter(entry, tell);
        }
    }

    fn each_meaning(&self, tell: &mut dyn FnMut(u16, Option<u16>)) {
        let (mode, pitch) = (param::Parameter::OperatingMode.entry(), param::Parameter::SpindlePitch.entry());
        // Which of the two models it is.
        for entry in [mode, pitch, param::Reading::BatteryVoltage.entry()] {
            let word = match self.read_parameter(entry.pnu, None) {
                Ok(param::Value::Word(word)) => Some(word),
                Ok(param::Value::Double(_)) | Err(_) => None,
            };
            tell(entry.pnu.number(), word);
        }
    }

    fn check_parameter(
        &self,
        ParameterPlace { number, element }: ParameterPlace,
        say: &mut dyn FnMut(&dyn fmt::Display),
    ) -> Result<(), Denied> {
        let read = Self::pnu(number).and_then(|pnu| self.read_parameter(pnu, element.map(Subindex)));
        read.map(drop).map_err(|error| self.refuse(number, error, say))
    }

    fn write_parameter(
        &mut self,
        now: Instant,
        ParameterPlace { number, element }: ParameterPlace,
        value: f64,
        say: &mut dyn FnMut(&dyn fmt::Display),
    ) -> Result<(), Denied> {
        if self.power() != Power::On {
            say(&"the drive is switched off, or in a factory reset; switch it on");
            return Err(Denied::NotNow);
        }
        let known = Self::pnu(number).and_then(|pnu| self.parameters().entry(pnu));
        let entry = known.map_err(|error| self.refuse(number, error, say))?;
        let value = written(entry, number, value, say).ok_or(Denied::Value)?;
        let value = param::Value::of(entry.width, value);
        let done = Self::write_parameter(self, now, entry.pnu, element.map(Subindex), value);
        done.map(drop).map_err(|error| self.refuse(number, error, say))
    }

    fn memory(&self) -> Option<&'static str> {
        Some(memory(self.eeprom_state()))
    }
}
