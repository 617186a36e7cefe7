//! The loop that runs drives on a link.

use super::{Bus, Clock, Error, Link, Received, Stop};
use crate::device::{Event, MAX_TELEGRAM_LEN};

/// Octets taken from the link at most before they are answered: about eight of the longest telegrams, so that a
/// master that never pauses cannot keep deadlines and the stop request waiting.
const BATCH: usize = 2048;

/// Runs the drives of `bus` on `link` until `stop` is requested. `on_event` gets their news with their addresses.
///
/// The loop sleeps in [`Link::wait`] until octets arrive or a drive has something to do, and uses no time otherwise.
/// It takes everything that has arrived before it answers: after a delay the drives see the newest request, and
/// reply to that one.
///
/// # Errors
/// [`Error::Link`] when the link no longer works.
pub fn run(
    link: &mut dyn Link,
    bus: &mut Bus,
    clock: &dyn Clock,
    stop: &Stop,
    on_event: &mut dyn FnMut(u8, Event),
) -> Result<(), Error> {
    let mut batch = [0; BATCH];
    loop {
        let (heard, reset) = listen(link, bus, &mut batch)?;
        if let Some(octets) = batch.get(..heard).filter(|octets| !octets.is_empty()) {
            bus.handle_bytes(clock.now(), octets);
            drain(link, bus, clock, on_event)?;
        }
        if reset {
            bus.handle_reset();
        }
        let now = clock.now();
        if bus.poll_timeout().is_some_and(|deadline| deadline <= now) {
            bus.handle_timeout(now);
            drain(link, bus, clock, on_event)?;
        }
        if stop.is_requested() {
            return Ok(());
        }
        // More may lie behind a reset or a full batch, and a new deadline may already be past: look again at once.
        let now = clock.now();
        let timeout = bus.poll_timeout().map(|deadline| deadline.saturating_since(now));
        if !reset && heard < batch.len() && timeout.is_none_or(|timeout| !timeout.is_zero()) {
            link.wait(timeout, stop).map_err(link_failed)?;
        }
    }
}

/// Collects what has arrived at the front of `batch`, up to a reset: how many octets, and whether a reset follows.
fn listen(link: &mut dyn Link, bus: &mut Bus, batch: &mut [u8]) -> Result<(usize, bool), Error> {
    let mut heard = 0;
    while let Some(free) = batch.get_mut(heard..).filter(|free| !free.is_empty()) {
        match link.receive(free).map_err(link_failed)? {
            Received::Octets(count) => heard += count,
            Received::Reset => return Ok((heard, true)),
            Received::Rate(rate) => bus.set_baud(rate),
            Received::Nothing => break,
        }
    }
    Ok((heard, false))
}

/// Sends what is to be sent now and passes on the news.
fn drain(
    link: &mut dyn Link,
    bus: &mut Bus,
    clock: &dyn Clock,
    on_event: &mut dyn FnMut(u8, Event),
) -> Result<(), Error> {
    let mut buf = [0; MAX_TELEGRAM_LEN];
    while let Some(telegram) = bus.poll_transmit(clock.now(), &mut buf) {
        link.send(telegram).map_err(link_failed)?;
    }
    while let Some((address, event)) = bus.poll_event() {
        on_event(address, event);
    }
    Ok(())
}

fn link_failed(source: std::io::Error) -> Error {
    Error::Link { source }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::device::{Config, Device};
    use crate::host::ManualClock;
    use crate::host::link::memory::{End, Wire};
    use crate::param::{Gear, Model};
    use crate::time::{BaudRate, Instant};
    use core::time::Duration;
    use std::collections::VecDeque;
    use std::{io, vec, vec::Vec};

    /// The drives' end of an in-memory line on which sleeping moves the clock instead of taking time. What the
    /// script holds happens in one sleep each; the sleep after the last requests the stop.
    struct Scripted {
        end: End,
        master: End,
        clock: ManualClock,
        script: VecDeque<Vec<u8>>,
        sleeps: Vec<Option<Duration>>,
        news: VecDeque<Received>,
    }

    impl Link for Scripted {
        fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
            match self.news.pop_front() {
                Some(news) => Ok(news),
                None => self.end.receive(buf),
            }
        }

        fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
            self.end.send(telegram)
        }

        fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
            self.sleeps.push(timeout);
            self.clock.advance(
                timeout
                    .unwrap_or(Duration::from_millis(10))
                    .min(Duration::from_millis(10)),
            );
            match self.script.pop_front() {
                Some(octets) => self.master.send(&octets),
                None => {
                    stop.request();
                    Ok(())
                }
            }
        }
    }

    fn scripted(script: &[&[u8]]) -> (Scripted, Bus, ManualClock) {
        let wire = Wire::new();
        let clock = ManualClock::new();
        let mut bus = Bus::new();
        let config = Config {
            address: 5,
            model: Model::Ag03_1,
            gear: Gear::Ratio48,
            baud: BaudRate::K500,
            application_cycle: Duration::from_millis(1),
        };
        bus.add(Device::new(config, clock.now())).unwrap();
        let link = Scripted {
            end: wire.end(),
            master: wire.end(),
            clock: clock.clone(),
            script: script.iter().map(|octets| octets.to_vec()).collect(),
            sleeps: Vec::new(),
            news: VecDeque::new(),
        };
        (link, bus, clock)
    }

    #[test]
    fn the_loop_takes_what_arrives_and_ends_on_request() {
        let (mut link, mut bus, clock) = scripted(&[&[0x10, 0x05], &[0xFF; 300]]);
        let stop = Stop::new().unwrap();
        run(&mut link, &mut bus, &clock, &stop, &mut |_, _| {}).unwrap();
        assert_eq!(
            link.end.receive(&mut [0; 1]).unwrap(),
            Received::Nothing,
            "everything was taken"
        );
        assert_eq!(link.end.lost(), 0);
        assert!(
            link.sleeps.len() >= 3,
            "one sleep before each arrival, one before the stop"
        );
        assert!(clock.now() > Instant::ZERO);
    }

    #[test]
    fn a_stop_requested_before_the_start_ends_the_loop_without_sleep() {
        let (mut link, mut bus, clock) = scripted(&[&[0x10]]);
        let stop = Stop::new().unwrap();
        stop.request();
        run(&mut link, &mut bus, &clock, &stop, &mut |_, _| {}).unwrap();
        assert_eq!(link.sleeps, vec![]);
    }

    #[test]
    fn no_sleep_is_longer_than_the_next_deadline() {
        let (mut link, mut bus, clock) = scripted(&[&[0x10, 0x05, 0x02, 0x49, 0x50, 0x16]]);
        let stop = Stop::new().unwrap();
        let before = bus.poll_timeout();
        run(&mut link, &mut bus, &clock, &stop, &mut |_, _| {}).unwrap();
        assert_eq!(
            link.sleeps.first().copied(),
            Some(before.map(|at| at.saturating_since(Instant::ZERO)))
        );
    }

    #[test]
    fn octets_before_and_after_a_reset_are_told_apart() {
        let (mut link, mut bus, _) = scripted(&[]);
        let mut batch = [0; 8];
        link.master.send(&[1, 2, 3]).unwrap();
        link.news
            .extend([Received::Rate(BaudRate::K1500), Received::Reset]);
        assert_eq!(listen(&mut link, &mut bus, &mut batch).unwrap(), (0, true));
        assert_eq!(listen(&mut link, &mut bus, &mut batch).unwrap(), (3, false));
        assert_eq!(batch[..3], [1, 2, 3]);
    }

    #[test]
    fn a_flood_is_taken_in_bounded_batches() {
        let (mut link, mut bus, _) = scripted(&[]);
        link.master.send(&[0x55; BATCH + 1]).unwrap();
        let mut batch = [0; BATCH];
        assert_eq!(listen(&mut link, &mut bus, &mut batch).unwrap(), (BATCH, false));
        assert_eq!(listen(&mut link, &mut bus, &mut batch).unwrap(), (1, false));
    }

    #[test]
    fn a_dead_link_ends_the_loop_with_its_cause() {
        struct Dead;
        impl Link for Dead {
            fn receive(&mut self, _: &mut [u8]) -> io::Result<Received> {
                Err(io::ErrorKind::BrokenPipe.into())
            }
            fn send(&mut self, _: &[u8]) -> io::Result<()> {
                Ok(())
            }
            fn wait(&mut self, _: Option<Duration>, _: &Stop) -> io::Result<()> {
                Ok(())
            }
        }
        let stop = Stop::new().unwrap();
        let error = run(
            &mut Dead,
            &mut Bus::new(),
            &ManualClock::new(),
            &stop,
            &mut |_, _| {},
        )
        .unwrap_err();
        assert!(matches!(error, Error::Link { source } if source.kind() == io::ErrorKind::BrokenPipe));
    }
}
