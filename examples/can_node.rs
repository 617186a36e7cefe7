//! A CAN bus with one station of your own on it, for masters that speak slcan.
//!
//! ```text
//! cargo run --example can_node -- slcan-tcp:127.0.0.1:5000
//! python3 -c 'import can; b = can.Bus("socket://127.0.0.1:5000", interface="slcan", sleep_after_open=0); print(b.recv(2))'
//! ```
//!
//! The station sends a heartbeat (705h) twenty times a second and answers each frame on 605h with the same octets on
//! 585h. A whole CANopen node is put on the bus in the same way.

use core::error::Error;
use core::time::Duration;
use std::env;
use std::io::Write;

use profidrive::can_bus::can::{BaseId, BitRate, ErrorState, Frame};
use profidrive::host::can::{CanParticipant, Line};
use profidrive::host::{Reach, Stop};
use profidrive::time::Instant;

const HEARTBEAT: Duration = Duration::from_millis(50);

struct Station {
    heartbeat: BaseId,
    request: BaseId,
    answer: BaseId,
    due: Instant,
    waiting: Option<Frame>,
}

impl CanParticipant for Station {
    type Event = Frame;

    fn handle_frame(&mut self, _: Instant, frame: &Frame) {
        if frame.id() == self.request.into() && !frame.is_remote() {
            self.waiting = Frame::data(self.answer, frame.octets()).ok();
        }
    }

    fn handle_timeout(&mut self, now: Instant) {
        if now >= self.due {
            self.due = now.saturating_add(HEARTBEAT);
            self.waiting.get_or_insert(Frame::with(self.heartbeat, [0x7F]));
        }
    }

    fn set_error_state(&mut self, _: Instant, state: ErrorState) {
        eprintln!("{state}");
    }

    fn poll_transmit(&mut self, _: Instant) -> Option<Frame> {
        self.waiting.take()
    }

    fn poll_event(&mut self) -> Option<Frame> {
        None
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Some(self.due)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let link = env::args().nth(1).unwrap_or_else(|| "slcan-pty".into());
    let mut line: Line<Frame> = Line::open(&link.parse()?, BitRate::K500, Reach::ThisMachine)?;
    line.add(Box::new(Station {
        heartbeat: BaseId::new(0x705)?,
        request: BaseId::new(0x605)?,
        answer: BaseId::new(0x585)?,
        due: Instant::ZERO,
        waiting: None,
    }));
    println!("ready link={}", line.name());
    std::io::stdout().flush()?;
    line.run(&Stop::new()?, &mut |news| eprintln!("{news:?}"))?;
    Ok(())
}
