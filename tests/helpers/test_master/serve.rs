//! The test master on a link of the operating system.

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;

use profidrive::bench::Master;
use profidrive::host::{Clock, Link, Received, Stop, SystemClock};
use profidrive::profibus::fdl::MAX_TELEGRAM_LEN;
use profidrive::time::Instant;

use super::TestMaster;

/// How long it sleeps at most.
const LOOK: Duration = Duration::from_millis(5);

/// Lets the master work on a link until `end`, or until the link is gone. `each` is called again and again, to do
/// something to the master.
pub(crate) fn serve(
    mut master: TestMaster,
    link: &mut dyn Link,
    end: &AtomicBool,
    mut each: impl FnMut(&mut TestMaster, Instant),
) {
    let (clock, stop) = (SystemClock::new(), Stop::new().unwrap());
    let mut buf = [0; MAX_TELEGRAM_LEN];
    while !end.load(Ordering::Relaxed) {
        each(&mut master, clock.now());
        loop {
            match link.receive(&mut buf) {
                Ok(Received::Octets(count) | Received::BrokenOff(count)) => {
                    master.handle_bytes(clock.now(), &buf[..count]);
                }
                Ok(Received::Nothing) => break,
                Ok(Received::Reset | Received::Rate(_)) => {}
                Err(_) => return,
            }
        }
        master.handle_timeout(clock.now());
        while let Some(len) = master.poll_transmit(clock.now(), &mut buf) {
            if link.send(&buf[..len]).is_err() {
                return;
            }
            master.handle_sent(clock.now());
        }
        let now = clock.now();
        let due = master.poll_timeout().map_or(LOOK, |due| due.saturating_since(now));
        if link.wait(Some(due.min(LOOK)), &stop).is_err() {
            return;
        }
    }
}
