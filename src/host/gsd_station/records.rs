//! The records of a station from a GSD, by slot and index, and its identification and maintenance.

use crate::map::Map;
use core::time::Duration;
use std::collections::BTreeSet;

use super::storing::{Before, Step, Storing};
use crate::host::station_file::KeptRecord;
use crate::profibus::dpv1::identification::LEN;
use crate::profibus::dpv1::{ErrorCode, Failure, Identification, Job, MAX_DATA, NotDone, Records};

/// One record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationRecord {
    /// What is in it, 1..=240 octets; a master writes as many.
    pub data: Vec<u8>,
    /// A master can read it.
    pub read: bool,
    /// A master can write it.
    pub write: bool,
    /// How long a job takes.
    pub delay: Duration,
}

/// The records of a station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationRecords {
    pub(crate) records: Map<(u8, u8), StationRecord>,
    /// I&M0 of slot 0, if there is identification.
    pub(crate) identification: Option<Identification>,
    /// I&M1 to I&M4 that can be written, and what is in them.
    pub(crate) blocks: Map<u16, [u8; LEN]>,
    /// The least Send_Timeout of a connection, times 10 ms.
    pub(crate) min_send_timeout: u16,
    /// The slots of the configuration.
    pub(super) slots: BTreeSet<u8>,
    /// What the disk does not have yet.
    pub(super) storing: Storing,
}

impl Default for StationRecords {
    fn default() -> Self {
        Self {
            records: Map::new(),
            identification: None,
            blocks: Map::new(),
            min_send_timeout: 100,
            slots: BTreeSet::new(),
            storing: Storing::default(),
        }
    }
}

impl StationRecords {
    /// The records by slot and index.
    pub fn iter(&self) -> impl Iterator<Item = ((u8, u8), &StationRecord)> {
        self.records.iter().map(|(place, record)| (*place, record))
    }

    /// What is in a record; `None` if there is none.
    pub fn record(&self, slot: u8, index: u8) -> Option<&StationRecord> {
        self.records.get(&(slot, index))
    }

    /// The device changes what is in a record, also in one that a master cannot write. Whether it has as many octets.
    pub fn change(&mut self, slot: u8, index: u8, data: &[u8]) -> bool {
        let Some(record) = self.records.get_mut(&(slot, index)) else { return false };
        let fits = record.data.len() == data.len();
        if fits {
            record.data = data.to_vec();
            self.storing.change((slot, index), data);
        }
        fits
    }

    /// What a disk keeps: the records that a master can write, and I&M1 to I&M4.
    pub(super) fn kept(&self) -> Vec<KeptRecord> {
        let written = self.records.iter().filter(|(_, record)| record.write);
        let records =
            written.map(|((slot, index), record)| KeptRecord::Record((*slot, *index), record.data.clone()));
        let blocks = self.blocks.iter().map(|(block, octets)| KeptRecord::Block(*block, *octets));
        records.chain(blocks).collect()
    }

    /// What a disk has kept. What the records of the file have no place for is forgotten.
    pub(super) fn recall(&mut self, kept: Vec<KeptRecord>) {
        for kept in kept {
            match kept {
                KeptRecord::Record(place, data) => {
                    let record = self.records.get_mut(&place);
                    if let Some(record) = record.filter(|own| own.write && own.data.len() == data.len()) {
                        record.data = data;
                    }
                }
                KeptRecord::Block(block, octets) => {
                    if let Some(own) = self.blocks.get_mut(&block) {
                        *own = octets;
                    }
                }
            }
        }
    }

    /// The disk has what was written, or refused it: then everything is as before.
    pub(super) fn settle(&mut self, stored: bool) {
        for before in self.storing.settle(stored) {
            match before {
                Before::Record { place, data } => {
                    if let Some(record) = self.records.get_mut(&place) {
                        record.data = data;
                    }
                }
                Before::Block { block, octets } => {
                    self.blocks.insert(block, octets);
                }
            }
        }
    }

    /// What a job that writes is told now; `None`: it is to be carried out.
    fn told(&mut self, job: &Job) -> Option<Result<(), NotDone>> {
        match self.storing.step(job) {
            Step::New => None,
            Step::Waits => Some(Err(NotDone::Yet)),
            Step::Stored => Some(Ok(())),
            Step::Failed => Some(Err(NotDone::refused(ErrorCode::WRITE_ERROR))),
        }
    }

    /// A job was carried out.
    fn wrote(&mut self, job: &Job, before: Before) -> Result<(), NotDone> {
        if self.storing.wrote(job, before) { Err(NotDone::Yet) } else { Ok(()) }
    }

    /// Adds a record at a slot and an index, in place of another one.
    pub fn insert(&mut self, place: (u8, u8), record: StationRecord) {
        self.records.insert(place, record);
    }

    fn has(&self, slot: u8) -> bool {
        slot == 0 || self.slots.contains(&slot) || self.records.keys().any(|(of, _)| *of == slot)
    }

    fn find(&mut self, job: &Job) -> Result<&mut StationRecord, NotDone> {
        if !self.has(job.slot) {
            return Err(NotDone::refused(ErrorCode::INVALID_SLOT));
        }
        let record = self.records.get_mut(&(job.slot, job.index));
        record.ok_or(NotDone::refused(ErrorCode::INVALID_INDEX))
    }
}

impl StationRecord {
    fn wait(&self, job: &Job) -> Result<(), NotDone> {
        if job.now.saturating_since(job.since) < self.delay { Err(NotDone::Yet) } else { Ok(()) }
    }
}

impl Records for StationRecords {
    fn read(&mut self, job: &Job, out: &mut [u8]) -> Result<usize, NotDone> {
        let record = self.find(job)?;
        if !record.read {
            return Err(NotDone::refused(ErrorCode::ACCESS_DENIED));
        }
        record.wait(job)?;
        for (place, octet) in out.iter_mut().zip(&record.data) {
            *place = *octet;
        }
        Ok(record.data.len().min(MAX_DATA.into()))
    }

    fn write(&mut self, job: &Job, data: &[u8]) -> Result<(), NotDone> {
        if let Some(told) = self.told(job) {
            return told;
        }
        let record = self.find(job)?;
        if !record.write {
            return Err(NotDone::refused(ErrorCode::ACCESS_DENIED));
        }
        if record.data.len() != data.len() {
            return Err(NotDone::refused(ErrorCode::WRITE_LENGTH));
        }
        record.wait(job)?;
        let before = core::mem::replace(&mut record.data, data.to_vec());
        self.wrote(job, Before::Record { place: (job.slot, job.index), data: before })
    }

    fn identification(&mut self, slot: u8, block: u16) -> Result<[u8; LEN], Failure> {
        if !self.has(slot) {
            return Err(Failure::of(ErrorCode::INVALID_SLOT));
        }
        let missing = Failure::of(ErrorCode::INVALID_INDEX);
        let identification = self.identification.filter(|_| slot == 0).ok_or(missing)?;
        match block {
            0 => Ok(identification.octets()),
            _ => self.blocks.get(&block).copied().ok_or(missing),
        }
    }

    fn keep_identification(&mut self, job: &Job, block: u16, octets: &[u8; LEN]) -> Result<(), NotDone> {
        if let Some(told) = self.told(job) {
            return told;
        }
        let before = self.identification(job.slot, block).map_err(NotDone::Refused)?;
        self.blocks.insert(block, *octets);
        self.wrote(job, Before::Block { block, octets: before })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profibus::dpv1::Channel;
    use crate::profibus::fdl::Address;
    use crate::time::Instant;

    #[test]
    fn a_record_says_what_it_allows_and_when() {
        let job = |slot, index, now| Job {
            master: Address::station(2).unwrap(),
            channel: Channel::Ms1,
            slot,
            index,
            since: Instant::ZERO,
            now: Instant::from_millis(now),
        };
        let record = |read, write, delay| StationRecord {
            data: vec![1, 2],
            read,
            write,
            delay: Duration::from_millis(delay),
        };
        let mut records = StationRecords { slots: [1].into(), ..StationRecords::default() };
        records.records.insert((1, 1), record(true, false, 0));
        records.records.insert((5, 1), record(false, true, 20));
        let mut out = [0; 240];
        assert_eq!(records.read(&job(1, 1, 0), &mut out), Ok(2));
        assert_eq!(records.read(&job(1, 2, 0), &mut out), Err(NotDone::refused(ErrorCode::INVALID_INDEX)));
        assert_eq!(records.read(&job(0, 1, 0), &mut out), Err(NotDone::refused(ErrorCode::INVALID_INDEX)));
        assert_eq!(records.read(&job(2, 1, 0), &mut out), Err(NotDone::refused(ErrorCode::INVALID_SLOT)));
        assert_eq!(records.read(&job(5, 1, 0), &mut out), Err(NotDone::refused(ErrorCode::ACCESS_DENIED)));
        assert_eq!(records.write(&job(1, 1, 0), &[1, 2]), Err(NotDone::refused(ErrorCode::ACCESS_DENIED)));
        assert_eq!(records.write(&job(5, 1, 0), &[1]), Err(NotDone::refused(ErrorCode::WRITE_LENGTH)));
        assert_eq!(records.write(&job(5, 1, 19), &[3, 4]), Err(NotDone::Yet));
        assert_eq!(records.write(&job(5, 1, 20), &[3, 4]), Ok(()));
        assert_eq!(records.record(5, 1).unwrap().data, [3, 4]);
        assert!(records.change(1, 1, &[9, 9]) && !records.change(1, 1, &[9]) && !records.change(7, 7, &[9]));
        assert_eq!(records.identification(0, 0), Err(Failure::of(ErrorCode::INVALID_INDEX)));
        records.identification = Some(Identification::PLAIN);
        records.blocks.insert(1, [0; LEN]);
        assert_eq!(records.identification(0, 0), Ok(Identification::PLAIN.octets()));
        assert_eq!(records.keep_identification(&job(0, 255, 0), 1, &[7; LEN]), Ok(()));
        assert_eq!(records.identification(0, 1), Ok([7; LEN]));
        assert!(records.keep_identification(&job(0, 255, 0), 2, &[7; LEN]).is_err());
        assert_eq!(records.identification(9, 0), Err(Failure::of(ErrorCode::INVALID_SLOT)));
    }

    /// A writable record 1 of slot 1 with a disk behind it, and a job of the owner or of a connection.
    fn kept() -> (StationRecords, impl Fn(Channel, u64) -> Job) {
        let mut records = StationRecords { slots: [1].into(), ..StationRecords::default() };
        let data = vec![1, 2];
        records.insert((1, 1), StationRecord { data, read: true, write: true, delay: Duration::ZERO });
        records.storing.on = true;
        let job = |channel, since| Job {
            master: Address::station(2).unwrap(),
            channel,
            slot: 1,
            index: 1,
            since: Instant::from_millis(since),
            now: Instant::from_millis(since),
        };
        (records, job)
    }

    #[test]
    fn what_a_disk_refuses_is_taken_back_and_the_master_is_told() {
        let (mut records, job) = kept();
        let (owner, other) = (job(Channel::Ms1, 1), job(Channel::Ms2 { sap: 48 }, 2));
        assert_eq!(records.write(&owner, &[3, 4]), Err(NotDone::Yet));
        assert_eq!(records.write(&other, &[5, 6]), Err(NotDone::Yet));
        assert_eq!(records.storing.take(), Some(true));
        records.settle(false);
        assert_eq!(records.record(1, 1).unwrap().data, [1, 2]);
        let refused = Err(NotDone::refused(ErrorCode::WRITE_ERROR));
        assert_eq!((records.write(&owner, &[3, 4]), records.write(&other, &[5, 6])), (refused, refused));
        // Asked again it is a job of its own.
        assert_eq!(records.write(&job(Channel::Ms1, 9), &[3, 4]), Err(NotDone::Yet));
        records.settle(true);
        assert_eq!(records.write(&job(Channel::Ms1, 9), &[3, 4]), Ok(()));
        assert_eq!(records.record(1, 1).unwrap().data, [3, 4]);
    }

    #[test]
    fn what_the_device_changed_meanwhile_stays_when_the_disk_refuses_what_a_master_wrote() {
        let (mut records, job) = kept();
        assert_eq!(records.write(&job(Channel::Ms1, 1), &[3, 4]), Err(NotDone::Yet));
        assert!(records.change(1, 1, &[8, 8]));
        assert_eq!(records.write(&job(Channel::Ms2 { sap: 48 }, 2), &[5, 6]), Err(NotDone::Yet));
        records.settle(false);
        assert_eq!(records.record(1, 1).unwrap().data, [8, 8]);
    }
}
