//! The loop that runs drives on a link.

use std::io::ErrorKind;

use super::{Bus, BusEvent, Clock, Error, Link, Received, Stop};
use crate::devices::ag03::profibus::MAX_TELEGRAM_LEN;
use crate::profibus::fdl::RateChange;
use crate::time::{BaudRate, Instant};

/// Octets taken from the link at most before they are answered: about eight of the longest telegrams, so that a
/// master that never pauses cannot keep deadlines and the stop request waiting.
const BATCH: usize = 2048;

/// Runs the stations of `bus` on `link` until `stop` is requested. `on_event` gets their news.
///
/// The loop sleeps in [`Link::wait`] until octets arrive or a station has something to do, and uses no time otherwise.
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
    on_event: &mut dyn FnMut(BusEvent),
) -> Result<(), Error> {
    let mut batch = [0; BATCH];
    // News from before the loop: the first rate to try.
    drain(link, bus, clock, on_event)?;
    loop {
        let (heard, then) = listen(link, bus, &mut batch)?;
        if let Some(octets) = batch.get(..heard).filter(|octets| !octets.is_empty()) {
            bus.handle_bytes(clock.now(), octets);
            drain(link, bus, clock, on_event)?;
        }
        match then {
            Then::Silence => {}
            Then::BrokenOff => {
                bus.handle_broken_off(clock.now());
                drain(link, bus, clock, on_event)?;
            }
            Then::Reset => bus.handle_reset(),
        }
        let now = clock.now();
        if bus.poll_timeout().is_some_and(|deadline| deadline <= now) {
            bus.handle_timeout(now);
            drain(link, bus, clock, on_event)?;
        }
        if stop.is_requested() {
            return Ok(());
        }
        // More may lie behind a break or a full batch, and a new deadline may already be past: look again at once.
        let now = clock.now();
        let timeout = bus.poll_timeout().map(|deadline| deadline.saturating_since(now));
        if then == Then::Silence && heard < batch.len() && timeout.is_none_or(|timeout| !timeout.is_zero()) {
            link.wait(timeout, stop).map_err(link_failed)?;
        }
    }
}

/// What follows some octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Then {
    Silence,
    /// They broke off.
    BrokenOff,
    Reset,
}

/// Collects what has arrived at the front of `batch`, up to a break: how many octets, and what follows.
fn listen(link: &mut dyn Link, bus: &mut Bus, batch: &mut [u8]) -> Result<(usize, Then), Error> {
    let mut heard = 0;
    while let Some(free) = batch.get_mut(heard..).filter(|free| !free.is_empty()) {
        match link.receive(free).map_err(link_failed)? {
            Received::Octets(count) => heard += count,
            Received::BrokenOff(count) => return Ok((heard + count, Then::BrokenOff)),
            Received::Reset => return Ok((heard, Then::Reset)),
            Received::Rate(rate) => bus.set_baud(rate),
            Received::Nothing => break,
        }
    }
    Ok((heard, Then::Silence))
}

/// Sends what is to be sent now and passes on the news.
fn drain(
    link: &mut dyn Link,
    bus: &mut Bus,
    clock: &dyn Clock,
    on_event: &mut dyn FnMut(BusEvent),
) -> Result<(), Error> {
    let mut buf = [0; MAX_TELEGRAM_LEN];
    while let Some(telegram) = bus.poll_transmit(sending_time(link, bus, clock), &mut buf) {
        link.send(telegram).map_err(link_failed)?;
    }
    let mut refused = 0;
    while let Some(event) = bus.poll_event() {
        if let BusEvent::Rate(RateChange::Try(rate)) = event {
            match link.set_rate(rate) {
                Ok(()) => {}
                // Not this one: the next. Not any: the search makes no sense.
                Err(error) if error.kind() == ErrorKind::InvalidInput && refused < BaudRate::ALL.len() => {
                    refused += 1;
                    bus.skip_rate(clock.now());
                    continue;
                }
                Err(error) => return Err(link_failed(error)),
            }
        }
        on_event(event);
    }
    Ok(())
}

/// The time of what is sent now: that of the next deadline, if the link cannot show the difference.
fn sending_time(link: &dyn Link, bus: &Bus, clock: &dyn Clock) -> Instant {
    let now = clock.now();
    let latest = now.saturating_add(link.resolution());
    bus.poll_timeout().filter(|due| *due <= latest).map_or(now, |due| due.max(now))
}

fn link_failed(source: std::io::Error) -> Error {
    Error::Link { source }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::host::ManualClock;
    use crate::host::link::memory::{End, Wire};
    use core::time::Duration;
    use std::io;

    /// A link that says `news` once before the octets of `end`.
    struct WithNews {
        end: End,
        news: Option<Received>,
    }

    impl Link for WithNews {
        fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
            match self.news.take() {
                Some(news) => Ok(news),
                None => self.end.receive(buf),
            }
        }
        fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
            self.end.send(telegram)
        }
        fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
            self.end.wait(timeout, stop)
        }
    }

    #[test]
    fn octets_before_and_after_a_reset_are_told_apart() {
        let wire = Wire::new();
        let mut link = WithNews { end: wire.end(), news: Some(Received::Reset) };
        let mut batch = [0; 8];
        wire.end().send(&[1, 2, 3]).unwrap();
        assert_eq!(listen(&mut link, &mut Bus::new(), &mut batch).unwrap(), (0, Then::Reset));
        link.news = Some(Received::Rate(BaudRate::K1500));
        assert_eq!(listen(&mut link, &mut Bus::new(), &mut batch).unwrap(), (3, Then::Silence));
        assert_eq!(batch[..3], [1, 2, 3]);
    }

    #[test]
    fn a_flood_is_taken_in_bounded_batches() {
        let wire = Wire::new();
        let mut end = wire.end();
        wire.end().send(&[0x55; BATCH + 1]).unwrap();
        let mut batch = [0; BATCH];
        assert_eq!(listen(&mut end, &mut Bus::new(), &mut batch).unwrap(), (BATCH, Then::Silence));
        assert_eq!(listen(&mut end, &mut Bus::new(), &mut batch).unwrap(), (1, Then::Silence));
    }

    /// A link of which only some rates can be set, silent for ever.
    struct Rates {
        possible: fn(BaudRate) -> io::Result<()>,
        set: std::vec::Vec<BaudRate>,
        clock: ManualClock,
    }

    impl Link for Rates {
        fn receive(&mut self, _: &mut [u8]) -> io::Result<Received> {
            Ok(Received::Nothing)
        }
        fn send(&mut self, _: &[u8]) -> io::Result<()> {
            panic!("nothing is sent while the rate is unknown")
        }
        fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
            self.clock.advance(timeout.unwrap_or_default());
            if self.set.len() >= 4 {
                stop.request();
            }
            Ok(())
        }
        fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
            (self.possible)(rate)?;
            self.set.push(rate);
            Ok(())
        }
    }

    fn searched(possible: fn(BaudRate) -> io::Result<()>) -> (Result<(), Error>, std::vec::Vec<BaudRate>) {
        let stop = Stop::new().expect("a socket");
        let clock = ManualClock::new();
        let mut link = Rates { possible, set: std::vec![], clock: clock.clone() };
        let mut bus = Bus::new();
        bus.search_baud(clock.now());
        let outcome = run(&mut link, &mut bus, &clock, &stop, &mut |_| {});
        (outcome, link.set)
    }

    #[test]
    fn the_link_is_set_to_each_rate_to_try_and_those_it_cannot_are_skipped() {
        let (outcome, set) = searched(|_| Ok(()));
        assert!(outcome.is_ok());
        assert_eq!(set[..4], [BaudRate::K12000, BaudRate::K6000, BaudRate::K3000, BaudRate::K1500]);
        let (outcome, set) =
            searched(
                |rate| {
                    if rate > BaudRate::K93_75 { Err(io::ErrorKind::InvalidInput.into()) } else { Ok(()) }
                },
            );
        assert!(outcome.is_ok());
        assert_eq!(set[..4], [BaudRate::K93_75, BaudRate::K45_45, BaudRate::K19_2, BaudRate::K9_6]);
    }

    #[test]
    fn a_link_without_any_rate_to_set_ends_the_loop() {
        let none: fn(BaudRate) -> io::Result<()> = |_| Err(io::ErrorKind::InvalidInput.into());
        for refuses in [none, |_| Err(io::ErrorKind::Unsupported.into())] {
            let (outcome, set) = searched(refuses);
            let kind = refuses(BaudRate::K500).unwrap_err().kind();
            assert!(matches!(outcome, Err(Error::Link { source }) if source.kind() == kind));
            assert_eq!(set, []);
        }
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
        let error = run(&mut Dead, &mut Bus::new(), &ManualClock::new(), &stop, &mut |_| {}).unwrap_err();
        assert!(matches!(error, Error::Link { source } if source.kind() == io::ErrorKind::BrokenPipe));
    }
}
