//! What is in the records of a slave: whoever knows it implements [`Records`].

use super::{ErrorCode, Failure, Job};
use crate::profibus::dpv1::identification;

/// The application behind the services of DP-V1.
pub trait Records {
    /// Reads a record: writes its octets to the front of `out` and returns how many it has. Of these the master gets as many
    /// as it asked for.
    ///
    /// # Errors
    /// [`NotDone`]
    fn read(&mut self, job: &Job, out: &mut [u8]) -> Result<usize, NotDone>;

    /// Writes a record.
    ///
    /// # Errors
    /// [`NotDone`]
    fn write(&mut self, job: &Job, data: &[u8]) -> Result<(), NotDone>;

    /// Takes octets and answers with others: writes them to the front of `out` and returns how many.
    ///
    /// # Errors
    /// [`NotDone`]; by default the service is not supported.
    fn transport(&mut self, _job: &Job, _data: &[u8], _out: &mut [u8]) -> Result<usize, NotDone> {
        Err(NotDone::refused(ErrorCode::NOT_SUPPORTED))
    }

    /// A block of identification and maintenance of a slot, 0 for I&M0.
    ///
    /// # Errors
    /// Why the slot has none, by default for every slot.
    fn identification(&mut self, _slot: u8, _block: u16) -> Result<[u8; identification::LEN], Failure> {
        Err(Failure::of(ErrorCode::INVALID_INDEX))
    }

    /// Keeps a block of identification and maintenance of a slot, 1 or more.
    ///
    /// # Errors
    /// [`NotDone`]; by default none can be written.
    fn keep_identification(
        &mut self,
        _job: &Job,
        _block: u16,
        _octets: &[u8; identification::LEN],
    ) -> Result<(), NotDone> {
        Err(NotDone::refused(ErrorCode::ACCESS_DENIED))
    }
}

/// Why a job has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotDone {
    /// Not yet: the job is asked for again with the next poll of the master.
    Yet,
    /// It is refused.
    Refused(Failure),
}

impl NotDone {
    /// Refused with this code.
    pub const fn refused(code: ErrorCode) -> Self {
        Self::Refused(Failure::of(code))
    }
}

/// No slot has a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoRecords;

impl Records for NoRecords {
    fn read(&mut self, _: &Job, _: &mut [u8]) -> Result<usize, NotDone> {
        Err(NotDone::refused(ErrorCode::INVALID_INDEX))
    }

    fn write(&mut self, _: &Job, _: &[u8]) -> Result<(), NotDone> {
        Err(NotDone::refused(ErrorCode::INVALID_INDEX))
    }
}
