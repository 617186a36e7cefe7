//! The servo ASDA-A2 on a CAN bus for masters that speak slcan: `tests/canopen/asda_402.py` drives it.
//!
//! ```text
//! cargo run --example asda_a2_node -- slcan-tcp:127.0.0.1:5000 [NODE [SHEET.eds]]
//! ```
//!
//! NODE is 1 to 127, default 5. With SHEET.eds the electronic data sheet of the drive is written there first.

use core::error::Error;
use std::env;
use std::fs;
use std::io::Write as _;

use profidrive::can_bus::can::{BitRate, ErrorState, Frame};
use profidrive::can_bus::canopen::eds;
use profidrive::devices::asda_a2::Config;
use profidrive::devices::asda_a2::canopen::{AsdaA2, Quirks, SHEET};
use profidrive::devices::{CanopenDevice, CanopenEvent};
use profidrive::host::can::{CanParticipant, Line};
use profidrive::host::{Reach, Stop};
use profidrive::time::Instant;

struct Station {
    drive: AsdaA2,
    is_on: bool,
}

impl CanParticipant for Station {
    type Event = CanopenEvent;

    fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        self.drive.handle_frame(now, frame);
    }

    fn handle_timeout(&mut self, now: Instant) {
        if !self.is_on {
            self.is_on = true;
            self.drive.power_on(now);
        }
        self.drive.handle_timeout(now);
    }

    fn set_error_state(&mut self, _: Instant, state: ErrorState) {
        eprintln!("{state}");
    }

    fn poll_transmit(&mut self, now: Instant) -> Option<Frame> {
        self.drive.poll_transmit(now)
    }

    fn poll_event(&mut self) -> Option<CanopenEvent> {
        self.drive.poll_event()
    }

    fn poll_timeout(&self) -> Option<Instant> {
        if self.is_on { self.drive.poll_timeout() } else { Some(Instant::ZERO) }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = env::args().skip(1);
    let link = arguments.next().unwrap_or_else(|| "slcan-pty".into());
    let config = Config::new(arguments.next().map_or(Ok(5), |node| node.parse())?);
    if let Some(path) = arguments.next() {
        let mut text = String::new();
        eds::write(&SHEET, AsdaA2::objects(config.level), &mut text)?;
        fs::write(path, text)?;
    }
    let mut line: Line<CanopenEvent> = Line::open(&link.parse()?, BitRate::K500, Reach::ThisMachine)?;
    let drive = AsdaA2::new(config, Quirks::default(), Instant::ZERO);
    line.add(Box::new(Station { drive, is_on: false }));
    println!("ready link={}", line.name());
    std::io::stdout().flush()?;
    line.run(&Stop::new()?, &mut |news| eprintln!("{news:?}"))?;
    Ok(())
}
