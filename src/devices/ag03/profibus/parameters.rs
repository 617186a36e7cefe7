//! The parameters of an AG03 as its parameter channel reaches them: numbers and values of PKW, errors with their numbers.

use super::words::{self, Words};
use crate::devices::ag03::drive::FaultBuffer;
use crate::devices::ag03::param;
use crate::devices::ag03::param::{
    Access, Model, NotNow, ParamError, Pnu, Store, Subindex, Write, WriteContext,
};
use crate::devices::ag03::unit::{OfBus, Unit};
use crate::profibus::fdl::Address;
use crate::profibus::pkw;
use crate::profibus::pkw::{JobError, Parameters};

/// How the drives answer jobs where the manuals leave it open. The default is the proposal of `ag03.md`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct JobQuirks {
    /// C-17: reading a parameter that is a command, PNU 970, is refused instead of answered with 0.
    pub refuse_command_read: bool,
    /// C-15: an AG03/1 confirms a write of PNU 970 as a word, as an AG03 does, instead of a double word.
    pub confirm_load_as_word: bool,
}

/// A unit on PROFIBUS: what its parameter channel reads and writes.
pub(super) struct Channel<'a> {
    pub(super) unit: &'a mut Unit,
    pub(super) quirks: JobQuirks,
    /// The values that only the bus knows.
    pub(super) shown: &'a Shown,
}

/// What the bus adds to the parameters that are only read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shown {
    /// PNU 918.
    pub(super) address: Address,
    pub(super) words: Words,
}

impl Shown {
    /// What only the bus shows, as PROFIBUS does.
    pub(super) fn show(&self, unit: &Unit, shown: OfBus, element: Subindex) -> i32 {
        match shown {
            OfBus::Address => self.address.number().into(),
            OfBus::FaultBuffer => {
                self.fault_codes(unit).get(usize::from(element.0)).copied().unwrap_or_default().into()
            }
            OfBus::SystemStatus => self.words.system_status(unit.status()).into(),
            OfBus::GeneralStatus => words::general_status(unit.status()).into(),
        }
    }
}

impl Shown {
    /// PNU 945: newest first unless the quirk says otherwise (C-18).
    pub(super) fn fault_codes(&self, unit: &Unit) -> [u8; FaultBuffer::LEN] {
        let faults = unit.drive().faults();
        if self.words.oldest_fault_first() { faults.codes_oldest_first() } else { faults.codes() }
    }
}

impl Parameters for Channel<'_> {
    fn read(&self, pnu: u16, element: Option<u8>) -> Result<pkw::Value, JobError> {
        let pnu = Pnu::from_low_bits(pnu);
        let show = |shown, element| self.shown.show(self.unit, shown, element);
        let value = self.unit.read(pnu, element.map(Subindex), show)?;
        self.quirks.check_read(self.unit.parameters(), pnu)?;
        Ok(value.into())
    }

    fn write(&mut self, pnu: u16, element: Option<u8>, value: pkw::Value) -> Result<pkw::Written, JobError> {
        let store = self.unit.parameters();
        let write = store.meaning(Pnu::from_low_bits(pnu), element.map(Subindex), value.into())?;
        let shown = self.quirks.confirmation(store.model(), write, value);
        let waits = self.unit.write_safely(write)?.waits;
        Ok(pkw::Written { shown, waits })
    }

    fn elements(&self, pnu: u16) -> Result<Option<u8>, JobError> {
        self.unit.parameters().elements(pnu)
    }
}

/// The parameters of a drive at rest that measures nothing: what it only shows is 0.
impl Parameters for Store {
    fn read(&self, pnu: u16, element: Option<u8>) -> Result<pkw::Value, JobError> {
        Ok(Self::read(self, Pnu::from_low_bits(pnu), element.map(Subindex), |_, _| 0)?.into())
    }

    fn write(&mut self, pnu: u16, element: Option<u8>, value: pkw::Value) -> Result<pkw::Written, JobError> {
        let write = self.meaning(Pnu::from_low_bits(pnu), element.map(Subindex), value.into())?;
        let _effect = self.apply(write, &WriteContext::default())?;
        Ok(pkw::Written::at_once(JobQuirks::default().confirmation(self.model(), write, value)))
    }

    fn elements(&self, pnu: u16) -> Result<Option<u8>, JobError> {
        Ok(self.entry(Pnu::from_low_bits(pnu))?.elements)
    }
}

impl JobQuirks {
    /// C-17.
    fn check_read(self, store: &Store, pnu: Pnu) -> Result<(), JobError> {
        let only_written = store.entry(pnu)?.access() == Access::WriteOnly;
        if self.refuse_command_read && only_written { Err(JobError::WriteOnly) } else { Ok(()) }
    }

    /// What the reply to a write shows: the value. A command is 0 after it was executed; the AG03/1 confirms it as a
    /// double word (C-15).
    const fn confirmation(self, model: Model, write: Write, value: pkw::Value) -> pkw::Value {
        match (write, model) {
            (Write::Set(..), _) => value,
            (Write::Load(_) | Write::ClearFaults | Write::Calibrate, Model::Ag03_1)
                if !self.confirm_load_as_word =>
            {
                pkw::Value::Double(0)
            }
            (Write::Load(_) | Write::ClearFaults | Write::Calibrate, Model::Ag03 | Model::Ag03_1) => {
                pkw::Value::Word(0)
            }
        }
    }
}

impl From<param::Value> for pkw::Value {
    fn from(value: param::Value) -> Self {
        match value {
            param::Value::Word(word) => Self::Word(word),
            param::Value::Double(double) => Self::Double(double),
        }
    }
}

impl From<pkw::Value> for param::Value {
    fn from(value: pkw::Value) -> Self {
        match value {
            pkw::Value::Word(word) => Self::Word(word),
            pkw::Value::Double(double) => Self::Double(double),
        }
    }
}

impl From<param::Width> for pkw::Width {
    fn from(width: param::Width) -> Self {
        match width {
            param::Width::Word => Self::Word,
            param::Width::Double => Self::Double,
        }
    }
}

impl From<ParamError> for JobError {
    fn from(error: ParamError) -> Self {
        match error {
            ParamError::UnknownParameter { got } => Self::UnknownParameter { got: got.number() },
            ParamError::ReadOnly => Self::ReadOnly,
            ParamError::OutOfRange { low, high, got } => Self::OutOfRange { low, high, got },
            ParamError::SubindexOutOfRange { count, got } => Self::SubindexOutOfRange { count, got: got.0 },
            ParamError::NotAnArray => Self::NotAnArray,
            ParamError::IsArray { count } => Self::IsArray { count },
            ParamError::WrongWidth { expected, got } => {
                Self::WrongWidth { expected: expected.into(), got: got.into() }
            }
            ParamError::NotNow(NotNow::Moving) => Self::NotNow("the shaft is moving"),
            ParamError::NotNow(NotNow::JobActive) => Self::NotNow("a travel job is active"),
        }
    }
}

#[cfg(test)]
mod tests;
