//! The table of a drive as the parameter channel reaches it, its descriptions included (`profidrive-v2.md` 6).

use super::memory::Memory;
use crate::devices::ppo_drive::table::{Channel, Row, Table, Tie};
use crate::devices::ppo_drive::{Drive, SetError};
use crate::profibus::fdl::Address;
use crate::profibus::pkw::{JobError, Parameters, Value, Width, Written};
use crate::profibus::ppo::{PpoType, Stw, Zsw};

/// What the channel knows and the drive does not.
#[derive(Clone, Copy)]
pub(super) struct Known {
    pub(super) address: Address,
    pub(super) ppo: Option<PpoType>,
    pub(super) stw: Stw,
    pub(super) zsw: Zsw,
}

/// The parameters to be read.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) table: &'a Table,
    pub(super) drive: &'a Drive,
    pub(super) known: Known,
}

/// The parameters to be read and written.
pub(super) struct Access<'a> {
    pub(super) table: &'a mut Table,
    pub(super) drive: &'a mut Drive,
    pub(super) known: Known,
    /// What keeps that which is written.
    pub(super) memory: Option<&'a mut Memory>,
}

impl Access<'_> {
    const fn view(&self) -> View<'_> {
        View { table: self.table, drive: self.drive, known: self.known }
    }
}

impl View<'_> {
    fn row(&self, pnu: u16) -> Result<&Row, JobError> {
        self.table.row(pnu).ok_or(JobError::UnknownParameter { got: pnu })
    }

    /// The value of a parameter, or of one element of an array, from 1.
    pub(super) fn read(&self, pnu: u16, element: Option<u8>) -> Result<Value, JobError> {
        let row = self.row(pnu)?;
        let place = Self::place(row, element)?;
        Ok(value_of(row, self.bits(row, place, element)))
    }

    /// The place of an element, which counts from 1, of a parameter.
    fn place(row: &Row, element: Option<u8>) -> Result<usize, JobError> {
        match (row.elements, element) {
            (None, None) => Ok(0),
            // G110D: an array access to a single value is accepted for index 0 or 1; this drive wants none.
            (None, Some(_)) => Err(JobError::NotAnArray),
            (Some(count), None) => Err(JobError::IsArray { count }),
            (Some(count), Some(got)) if (1..=count).contains(&got) => Ok(usize::from(got) - 1),
            (Some(count), Some(got)) => Err(JobError::NoElement { count, got }),
        }
    }

    fn bits(&self, row: &Row, place: usize, element: Option<u8>) -> u32 {
        match row.tie {
            Tie::None => self.table.kept(row.pnu, place).unwrap_or(0),
            Tie::Drive(quantity) => {
                row.kind.bits(self.drive.quantity(quantity, row.shown_element(element)) / row.scale)
            }
            Tie::Channel(channel) => match channel {
                Channel::ControlWord => self.known.stw.raw().into(),
                Channel::StatusWord => self.known.zsw.raw().into(),
                Channel::Address => self.known.address.number().into(),
                Channel::Store => 0,
                Channel::PpoType => self.known.ppo.map_or(0, number),
                Channel::PzdSetpoint | Channel::PzdActual => self.table.kept(row.pnu, place).unwrap_or(0),
                Channel::List => self.table.rows().nth(place).map_or(0, |row| row.pnu.into()),
            },
        }
    }
}

/// The number of a PPO of the profile; that of the AG03 has none.
const fn number(kind: PpoType) -> u32 {
    match kind {
        PpoType::Ppo1 => 1,
        PpoType::Ppo2 => 2,
        PpoType::Ppo3 => 3,
        PpoType::Ppo4 => 4,
        PpoType::Ppo5 => 5,
        PpoType::SevenWords => 0,
    }
}

fn value_of(row: &Row, bits: u32) -> Value {
    let [_, _, high, low] = bits.to_be_bytes();
    if row.kind.is_double() { Value::Double(bits) } else { Value::Word(u16::from_be_bytes([high, low])) }
}

impl Parameters for Access<'_> {
    fn elements(&self, pnu: u16) -> Result<Option<u8>, JobError> {
        self.view().row(pnu).map(|row| row.elements)
    }

    fn read(&self, pnu: u16, element: Option<u8>) -> Result<Value, JobError> {
        self.view().read(pnu, element)
    }

    fn write(&mut self, pnu: u16, element: Option<u8>, value: Value) -> Result<Written, JobError> {
        let view = self.view();
        let row = view.row(pnu)?;
        let place = View::place(row, element)?;
        if !row.writable {
            return Err(JobError::ReadOnly);
        }
        let (expected, got) = (if row.kind.is_double() { Width::Double } else { Width::Word }, value.width());
        if expected != got {
            return Err(JobError::WrongWidth { expected, got });
        }
        let (kind, tie, scale) = (row.kind, row.tie, row.scale);
        let before = view.bits(row, place, element);
        let number = kind.value(value.bits());
        let outside = JobError::outside(row.low, row.high, number);
        // Also what is no number.
        if !(row.low..=row.high).contains(&number) {
            return Err(outside);
        }
        match tie {
            Tie::Drive(quantity) => {
                self.drive.set_quantity(quantity, number * scale).map_err(|error| match error {
                    SetError::ReadOnly => JobError::ReadOnly,
                    SetError::Value => JobError::NotNow("the drive cannot be set to this value"),
                })?;
            }
            Tie::Channel(Channel::Store) => return Ok(Written { shown: Value::Word(0), waits: false }),
            Tie::Channel(Channel::PzdSetpoint | Channel::PzdActual)
                if number != 0.0 && self.table.rows().all(|row| f64::from(row.pnu) != number) =>
            {
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a word")]
                return Err(JobError::NamesNone { got: number as u16 });
            }
            Tie::None | Tie::Channel(_) => _ = self.table.keep(pnu, place, value.bits()),
        }
        let waits = match &mut self.memory {
            Some(memory) if tie.is_kept() => memory.note((pnu, element), before, value.bits()),
            Some(_) | None => false,
        };
        Ok(Written { shown: value, waits })
    }

    fn describe(&self, pnu: u16, element: u8) -> Result<u32, JobError> {
        let view = self.view();
        let row = view.row(pnu)?;
        match element {
            1 => Ok(row.identifier().into()),
            2 => Ok(row.elements.unwrap_or(0).into()),
            #[expect(
                clippy::cast_possible_truncation,
                reason = "a factor of single precision is what the profile has"
            )]
            3 => Ok((row.scale as f32).to_bits()),
            // Variable and conversion index: none. Reserved. Extended identifier: none.
            4 | 5 | 9 | 10 => Ok(0),
            6 => Err(JobError::NameTooLong),
            7 => Ok(row.kind.bits(row.low)),
            8 => Ok(row.kind.bits(row.high)),
            0 => Err(JobError::DescriptionTooLong),
            11.. => Err(JobError::NoElement { count: 10, got: element }),
        }
    }
}
