//! A station from a device file with what is beside it, behind a framer: octets in, octets out.

use std::time::Duration;

use profidrive::gsd::{self, Gsd};
use profidrive::host::{StationRecord, StationRecords};
use profidrive::profibus::dp::{ExtDiag, Station};
use profidrive::profibus::dpv1::{Acyclic, Offer};
use profidrive::profibus::fdl::{Framer, Resync};
use profidrive::time::Instant;

use crate::record_table::{Record, Table};

/// The least Send_Timeout of a connection, times 10 ms.
const MIN_SEND_TIMEOUT: u16 = 10;

pub(crate) struct Whole {
    framer: Framer,
    pub(crate) station: Station<gsd::Station>,
    pub(crate) acyclic: Acyclic<4, 8>,
    pub(crate) records: Table,
}

impl Whole {
    pub(crate) fn new(resync: Resync, station: Station<gsd::Station>, gsd: &Gsd, records: Table) -> Self {
        let offer = if gsd.flags.dpv1 { gsd.acyclic.offer(MIN_SEND_TIMEOUT) } else { Offer::NONE };
        let acyclic = Acyclic::new(offer);
        let acyclic = if gsd.flags.prm_blocks { acyclic.with_ext_prm() } else { acyclic };
        Self { framer: Framer::new(resync), station, acyclic, records }
    }

    pub(crate) fn station(&self) -> &Station<gsd::Station> {
        &self.station
    }

    pub(crate) fn station_mut(&mut self) -> &mut Station<gsd::Station> {
        &mut self.station
    }

    pub(crate) fn handle_bytes(&mut self, now: Instant, octets: &[u8]) {
        let Self { framer, station, acyclic, records } = self;
        framer.handle_bytes(now, octets, |at, result| {
            if let Ok(telegram) = result {
                acyclic.handle_telegram(station, records, at, &telegram);
            }
        });
    }

    pub(crate) fn handle_timeout(&mut self, now: Instant) {
        let Self { framer, station, acyclic, records } = self;
        acyclic.handle_timeout(station, now);
        framer.handle_timeout(now, |at, result| {
            if let Ok(telegram) = result {
                acyclic.handle_telegram(station, records, at, &telegram);
            }
        });
    }

    pub(crate) fn poll_transmit<'b>(&mut self, now: Instant, buf: &'b mut [u8; 255]) -> Option<&'b [u8]> {
        let octets = self.station.poll_transmit(now).ok()??;
        buf[..octets.len()].copy_from_slice(octets);
        Some(&buf[..octets.len()])
    }

    pub(crate) fn poll_timeout(&self) -> Option<Instant> {
        [self.station.poll_timeout(), self.acyclic.poll_timeout(), self.framer.poll_timeout()]
            .into_iter()
            .flatten()
            .min()
    }

    pub(crate) fn file_diagnosis(&mut self, diagnosis: &ExtDiag) {
        self.acyclic.file_diagnosis(&mut self.station, diagnosis);
    }
}

/// What the records are: index in slot 1, octets, access, delay in milliseconds.
const RECORDS: [(u8, usize, &str, u64); 5] =
    [(10, 4, "rw", 0), (11, 3, "r", 0), (12, 2, "w", 0), (13, 240, "rw", 0), (14, 5, "rw", 150)];

/// The records of the slave.
pub(crate) fn records() -> Table {
    let mut table = Table::default();
    for (index, len, access, delay) in RECORDS {
        let record = Record {
            data: (1..=len as u8).collect(),
            read_only: access == "r",
            write_only: access == "w",
            delay: Duration::from_millis(delay),
        };
        table.records.insert((1, index), record);
    }
    table
}

/// What the judge knows of them.
pub(crate) fn known() -> StationRecords {
    let mut records = StationRecords::default();
    for (index, len, access, delay) in RECORDS {
        let record = StationRecord {
            data: vec![0; len],
            read: access.contains('r'),
            write: access.contains('w'),
            delay: Duration::from_millis(delay),
        };
        records.insert((1, index), record);
    }
    records
}
