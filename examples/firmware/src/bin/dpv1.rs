//! An I/O station of DP-V1 at address 7, `dpv1.gsd`: records over MS1 and two connections, a process alarm, I&M0.
//!
//! Record 1 of slot 0 is a name that a master writes, record 2 of slot 1 counts milliseconds and takes 20 ms to read. Output 8 raises
//! an alarm when it becomes 1.
#![no_std]
#![no_main]

use core::time::Duration;

use cortex_m_rt::entry;
use profidrive::embedded::Slave;
use profidrive::profibus::dp::{Description, Fixed, Rates, Station};
use profidrive::profibus::dpv1::identification::LEN;
use profidrive::profibus::dpv1::{
    Acyclic, AlarmOffer, AlarmType, ErrorCode, Failure, Identification, Job, Ms2Offer, NotDone, Offer,
    Records, Specifier, Text,
};
use profidrive::profibus::fdl::{Address, FrameError, Framer, MAX_TELEGRAM_LEN, Resync, Telegram};
use profidrive::time::{BaudRate, Instant};
use profidrive_firmware::board::{Board, TIMING};
use profidrive_firmware::say;

const BAUD: BaudRate = BaudRate::K1500;

const DESCRIPTION: Description = Description {
    ident: 0x4976,
    rates: Rates::CUSTOMARY
        .without(BaudRate::K45_45)
        .without(BaudRate::K3000)
        .without(BaudRate::K6000)
        .without(BaudRate::K12000),
    // DP-V1 and a watchdog of 1 ms; process alarms; any Alarm_Mode: a slave takes the nearest that it has.
    dpv1_status: Some([0x84, 0x40, 0x07]),
    max_diag_len: 12,
    ..Description::PLAIN
};

const APPLICATION: Fixed<'static> = Fixed { configurations: &[&[0x20, 0x10]], ..Fixed::PLAIN };

const OFFER: Offer = Offer {
    ms1: Some(240),
    ms2: Some(Ms2Offer { connections: 2, max_data: 240, max_initiate: 52, min_send_timeout: 100 }),
    alarms: AlarmOffer { types: 0x40, sequence: 0, extra_sap: false },
};

/// How long the counter takes to read.
const SLOW: Duration = Duration::from_millis(20);

/// What is in the records.
struct Memory {
    name: [u8; 16],
}

impl Records for Memory {
    fn read(&mut self, job: &Job, out: &mut [u8]) -> Result<usize, NotDone> {
        match (job.slot, job.index) {
            (0, 1) => put(&self.name, out),
            (1, 2) if job.now.saturating_since(job.since) < SLOW => Err(NotDone::Yet),
            (1, 2) => {
                let [.., a, b, c, d] = (job.now.as_nanos() / 1_000_000).to_be_bytes();
                put(&[a, b, c, d], out)
            }
            (0 | 1, _) => Err(NotDone::refused(ErrorCode::INVALID_INDEX)),
            _ => Err(NotDone::refused(ErrorCode::INVALID_SLOT)),
        }
    }

    fn write(&mut self, job: &Job, data: &[u8]) -> Result<(), NotDone> {
        match (job.slot, job.index, data.try_into()) {
            (0, 1, Ok(name)) => {
                self.name = name;
                Ok(())
            }
            (0, 1, Err(_)) => Err(NotDone::refused(ErrorCode::WRITE_LENGTH)),
            (1, 2, _) => Err(NotDone::refused(ErrorCode::ACCESS_DENIED)),
            (0 | 1, ..) => Err(NotDone::refused(ErrorCode::INVALID_INDEX)),
            _ => Err(NotDone::refused(ErrorCode::INVALID_SLOT)),
        }
    }

    fn identification(&mut self, slot: u8, block: u16) -> Result<[u8; LEN], Failure> {
        match (slot, block) {
            (0, 0) => {
                Ok(Identification { order_id: Text::of("IO 8/8 DP-V1"), ..Identification::PLAIN }.octets())
            }
            _ => Err(Failure::of(ErrorCode::INVALID_INDEX)),
        }
    }
}

fn put(octets: &[u8], out: &mut [u8]) -> Result<usize, NotDone> {
    for (place, octet) in out.iter_mut().zip(octets) {
        *place = *octet;
    }
    Ok(octets.len())
}

/// Everything behind the framer.
struct Part {
    station: Station<Fixed<'static>>,
    acyclic: Acyclic<2, 4>,
    records: Memory,
}

impl Part {
    fn hear(&mut self, at: Instant, heard: Result<Telegram<'_>, FrameError>) {
        if let Ok(telegram) = heard {
            self.acyclic.handle_telegram(&mut self.station, &mut self.records, at, &telegram);
        }
        // A log would take them.
        while self.acyclic.poll_event().is_some() {}
    }

    /// Inputs from outputs; the alarm.
    fn application(&mut self, was: &mut u8) {
        let outputs = self.station.slave().outputs().first().copied().unwrap_or(0);
        self.station.set_inputs(&[outputs]);
        if outputs & !*was & 0x80 != 0 {
            let whose = (1, Specifier::Appears, false);
            // Without data exchange, or with one that waits, there is none.
            let _raised = self.acyclic.raise(&mut self.station, AlarmType::Process, whose, &[outputs]);
        }
        *was = outputs;
    }
}

/// The station on its UART.
struct OnLine {
    framer: Framer,
    part: Part,
}

impl Slave for OnLine {
    fn handle_bytes(&mut self, now: Instant, octets: &[u8]) -> bool {
        let Self { framer, part } = self;
        let mut heard = false;
        framer.handle_bytes(now, octets, |at, result| {
            heard = true;
            part.hear(at, result);
        });
        heard
    }

    fn handle_damaged(&mut self, now: Instant) -> bool {
        let Self { framer, part } = self;
        let mut heard = false;
        framer.handle_damaged(now, |at, result| {
            heard = true;
            part.hear(at, result);
        });
        heard
    }

    fn handle_timeout(&mut self, now: Instant) {
        let Self { framer, part } = self;
        part.acyclic.handle_timeout(&mut part.station, now);
        framer.handle_timeout(now, |at, result| part.hear(at, result));
    }

    fn poll_transmit<'b>(&mut self, now: Instant, buf: &'b mut [u8; MAX_TELEGRAM_LEN]) -> Option<&'b [u8]> {
        let octets = self.part.station.poll_transmit(now).ok().flatten()?;
        let out = buf.get_mut(..octets.len())?;
        out.copy_from_slice(octets);
        Some(out)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        let Part { station, acyclic, .. } = &self.part;
        [station.poll_timeout(), acyclic.poll_timeout(), self.framer.poll_timeout()]
            .into_iter()
            .flatten()
            .min()
    }
}

#[entry]
fn main() -> ! {
    let mut board = Board::start();
    let resync = TIMING.resync(BAUD);
    let max_tsdr = match resync {
        Resync::Idle(_) => Some(BAUD.max_tsdr_bits()),
        Resync::Scan(_) => None,
    };
    let station = Station::new(Address::from_octet(7), BAUD, max_tsdr, DESCRIPTION, APPLICATION);
    let part = Part { station, acyclic: Acyclic::new(OFFER), records: Memory { name: [b' '; 16] } };
    // It lies in this frame, which is never left.
    let mut slave = OnLine { framer: Framer::new(resync), part };
    let mut outputs = 0;
    say("ready\n");
    board.serve(&mut slave, |_, slave| slave.part.application(&mut outputs))
}
