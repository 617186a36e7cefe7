//! The records of the station: 47 of parameters, 255 of identification.

use super::event::Event;
use super::parameters::{Known, Parameters};
use super::requests::{self, Outcome};
use crate::profibus::dpv1::identification::LEN;
use crate::profibus::dpv1::{
    self, Channel, ErrorCode, Failure, Identification, Job, NotDone, PARAMETER_INDEX,
};

/// The slots of the drive: the station, and its one module.
const SLOTS: u8 = 2;

/// Where a request names its axis.
const AXIS: usize = 2;

/// What was answered and not fetched, one answer for each way.
#[derive(Clone, Debug, Default)]
pub(super) struct Pending(Vec<(Channel, Vec<u8>)>);

impl Pending {
    fn put(&mut self, channel: Channel, response: Vec<u8>) {
        self.forget(channel);
        self.0.push((channel, response));
    }

    fn take(&mut self, channel: Channel) -> Option<Vec<u8>> {
        let place = self.0.iter().position(|(own, _)| *own == channel)?;
        Some(self.0.swap_remove(place).1)
    }

    fn forget(&mut self, channel: Channel) {
        self.0.retain(|(own, _)| *own != channel);
    }

    /// The owner is gone.
    pub(super) fn forget_owner(&mut self) {
        self.forget(Channel::Ms1);
    }

    /// A connection that ends fetches nothing more.
    pub(super) fn notice(&mut self, event: &dpv1::Event) {
        if let dpv1::Event::Ended { sap, .. } = event {
            self.forget(Channel::Ms2 { sap: *sap });
        }
    }
}

/// The records, while a telegram is handled.
pub(super) struct Records<'a> {
    pub(super) parameters: &'a mut Parameters,
    pub(super) pending: &'a mut Pending,
    pub(super) known: Known,
    pub(super) identification: &'a Identification,
    pub(super) told: &'a mut Vec<Event>,
}

/// Whether the record is that of parameters of a slot that there is.
fn check(job: &Job) -> Result<(), NotDone> {
    match (job.slot, job.index) {
        (SLOTS.., _) => Err(NotDone::refused(ErrorCode::INVALID_SLOT)),
        (_, PARAMETER_INDEX) => Ok(()),
        (_, _) => Err(NotDone::refused(ErrorCode::INVALID_INDEX)),
    }
}

impl dpv1::Records for Records<'_> {
    fn read(&mut self, job: &Job, out: &mut [u8]) -> Result<usize, NotDone> {
        check(job)?;
        let response = self.pending.take(job.channel).ok_or(NotDone::refused(ErrorCode::STATE_CONFLICT))?;
        for (place, octet) in out.iter_mut().zip(&response) {
            *place = *octet;
        }
        Ok(response.len())
    }

    fn write(&mut self, job: &Job, data: &[u8]) -> Result<(), NotDone> {
        check(job)?;
        let Self { parameters, known, told, .. } = self;
        let (slot, axis) = (job.slot, data.get(AXIS).copied().unwrap_or_default());
        let response = requests::respond(parameters, known, data, &mut |outcome| {
            told.push(match outcome {
                Outcome::Changed { address } => Event::Changed { address },
                Outcome::Failed { service, address, error, info } => {
                    Event::Refused { slot, axis, service, address, error, info }
                }
                Outcome::Whole { head, error } => Event::RequestRefused { slot, head, error },
            });
        });
        let response = response.ok_or(NotDone::refused(ErrorCode::INVALID_RANGE))?;
        self.pending.put(job.channel, response);
        Ok(())
    }

    fn identification(&mut self, slot: u8, block: u16) -> Result<[u8; LEN], Failure> {
        match (slot, block) {
            (SLOTS.., _) => Err(Failure::of(ErrorCode::INVALID_SLOT)),
            (0, 0) => Ok(self.identification.octets()),
            (_, _) => Err(Failure::of(ErrorCode::INVALID_INDEX)),
        }
    }
}
