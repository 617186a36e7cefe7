//! Records of a slave of DP-V1 in memory, with I&M0 to I&M3.
#![allow(dead_code, reason = "each test file uses its part")]

use std::collections::BTreeMap;
use std::time::Duration;

use profidrive::profibus::dpv1::{ErrorCode, Failure, Identification, Job, NotDone, Records, Text};

/// What a record is.
#[derive(Clone, Debug, Default)]
pub(crate) struct Record {
    pub(crate) data: Vec<u8>,
    pub(crate) read_only: bool,
    pub(crate) write_only: bool,
    pub(crate) delay: Duration,
}

/// Records by slot and index. Slots 0 to 2 are there.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    pub(crate) records: BTreeMap<(u8, u8), Record>,
    pub(crate) kept: BTreeMap<u16, [u8; 64]>,
    pub(crate) runs: usize,
}

impl Table {
    fn find(&mut self, job: &Job) -> Result<&mut Record, NotDone> {
        if job.slot > 2 {
            return Err(NotDone::refused(ErrorCode::INVALID_SLOT));
        }
        let record = self.records.get_mut(&(job.slot, job.index));
        let record = record.ok_or(NotDone::refused(ErrorCode::INVALID_INDEX))?;
        if job.now.saturating_since(job.since) < record.delay {
            return Err(NotDone::Yet);
        }
        self.runs += 1;
        Ok(record)
    }
}

impl Records for Table {
    fn read(&mut self, job: &Job, out: &mut [u8]) -> Result<usize, NotDone> {
        let record = self.find(job)?;
        if record.write_only {
            return Err(NotDone::refused(ErrorCode::ACCESS_DENIED));
        }
        out[..record.data.len()].copy_from_slice(&record.data);
        Ok(record.data.len())
    }

    fn write(&mut self, job: &Job, data: &[u8]) -> Result<(), NotDone> {
        let record = self.find(job)?;
        if record.read_only {
            return Err(NotDone::refused(ErrorCode::ACCESS_DENIED));
        }
        if record.data.len() != data.len() {
            return Err(NotDone::refused(ErrorCode::WRITE_LENGTH));
        }
        record.data = data.to_vec();
        Ok(())
    }

    fn identification(&mut self, slot: u8, block: u16) -> Result<[u8; 64], Failure> {
        match (slot, block) {
            (0, 0) => {
                let order_id = Text::of("6ES7 000-0AA00");
                let supported = 0x0E;
                Ok(Identification { manufacturer_id: 42, order_id, supported, ..Identification::PLAIN }
                    .octets())
            }
            (0, 1..=3) => Ok(self.kept.get(&block).copied().unwrap_or([b' '; 64])),
            _ => Err(Failure::of(ErrorCode::INVALID_INDEX)),
        }
    }

    fn keep_identification(&mut self, job: &Job, block: u16, octets: &[u8; 64]) -> Result<(), NotDone> {
        if (job.slot, block) != (0, 1) {
            return Err(NotDone::refused(ErrorCode::ACCESS_DENIED));
        }
        self.kept.insert(block, *octets);
        Ok(())
    }
}
