//! One adapter: a seat on the bus, the slcan machine, and a stream to its master.

use core::time::Duration;
use std::collections::VecDeque;
use std::io;

use super::stream::{Arrival, Stream};
use crate::can_bus::can::ErrorState;
use crate::can_bus::can::slcan;
use crate::can_bus::can::slcan::{Channel, Effect, Flags};
use crate::host::can::line::{AdapterNews, News};
use crate::host::can::{Bus, Seat};
use crate::host::link::Sleep;
use crate::time::Instant;

/// Octets taken from a master at once.
const INBOX: usize = 4096;

/// Octets that wait for a master at most, beside what the kernel keeps: 0.2 s of a full bus at 1 Mbit/s.
const MAX_OUTBOX: usize = 64 * 1024;

/// How long the acknowledgement of a frame waits for an answer on the bus at most.
const HOLD: Duration = Duration::from_millis(1);

pub(super) struct Adapter {
    name: String,
    /// `None`: the master is gone for good, and frames it was told are sent wait for the bus.
    stream: Option<Stream>,
    machine: slcan::Adapter,
    seat: Seat,
    /// Octets of the master that wait for room on the bus.
    inbox: VecDeque<u8>,
    /// Whole lines, the first one perhaps begun.
    outbox: VecDeque<u8>,
    /// The first line is.
    begun: bool,
    /// Lines of frames were written since the master's output was last thrown away.
    told: bool,
    /// All that waits are acknowledgements of frames. They wait for the answer that is on its way, no longer than this:
    /// one call hands out both.
    held: Option<Instant>,
    /// Frames that the master had no room for.
    dropped: u64,
    loss_reported: bool,
}

impl Adapter {
    pub(super) fn new<E: 'static>(stream: Stream, name: String, bus: &mut Bus<E>, now: Instant) -> Self {
        let seat = bus.connect(now);
        bus.listen(seat, false);
        Self {
            name,
            stream: Some(stream),
            machine: slcan::Adapter::new(),
            seat,
            inbox: VecDeque::new(),
            outbox: VecDeque::new(),
            begun: false,
            told: false,
            held: None,
            dropped: 0,
            loss_reported: false,
        }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) const fn seat(&self) -> Seat {
        self.seat
    }

    pub(super) const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Whether the master is gone and nothing of it waits.
    pub(super) fn is_gone<E: 'static>(&self, bus: &Bus<E>) -> bool {
        self.stream.is_none() && self.inbox.is_empty() && bus.is_idle(self.seat)
    }

    /// Takes what the master has sent, as far as the bus has room. True if there may be more at once.
    pub(super) fn read<E: 'static>(
        &mut self,
        bus: &mut Bus<E>,
        now: Instant,
        on_news: &mut dyn FnMut(News<E>),
    ) -> io::Result<bool> {
        let mut full = false;
        if self.inbox.is_empty()
            && let Some(stream) = &mut self.stream
        {
            let mut buf = [0; INBOX];
            match stream.read(&mut buf)? {
                Arrival::Octets(count) => {
                    self.inbox.extend(buf.iter().take(count));
                    full = count == buf.len();
                }
                Arrival::Nothing => {}
                Arrival::Another => {
                    self.machine.break_line();
                    self.outbox.clear();
                    self.told = false;
                    self.loss_reported = false;
                    full = true;
                }
                Arrival::Gone => {
                    self.stream = None;
                    bus.listen(self.seat, false);
                }
            }
        }
        while self.may_go_on(bus)
            && let Some(octet) = self.inbox.pop_front()
        {
            self.take(octet, bus, now, on_news)?;
        }
        Ok(full && self.inbox.is_empty())
    }

    /// Whether the next line can be answered: a frame waits until the bus has room, unless the adapter is bus off.
    fn may_go_on<E: 'static>(&self, bus: &Bus<E>) -> bool {
        let bus_off =
            bus.confinement(self.seat).is_none_or(|counters| counters.state() == ErrorState::BusOff);
        self.machine.channel() != Channel::Open || bus_off || bus.has_room(self.seat)
    }

    fn take<E: 'static>(
        &mut self,
        octet: u8,
        bus: &mut Bus<E>,
        now: Instant,
        on_news: &mut dyn FnMut(News<E>),
    ) -> io::Result<()> {
        if octet == slcan::CR {
            self.note(bus);
        }
        let Some(reaction) = self.machine.handle_octet(octet, bus.has_room(self.seat)) else {
            return Ok(());
        };
        let name = &self.name;
        let mut tell = |news| on_news(News::Adapter { name: name.clone(), news });
        match reaction.effect {
            // There was room, and nothing has come in between.
            Some(Effect::Transmit(frame)) => drop(bus.send(now, self.seat, frame)),
            Some(Effect::Rate(timing)) => {
                let outcome = bus.change_over(now, timing.rates());
                tell(AdapterNews::Rate { timing, bus: bus.rate(), outcome });
            }
            Some(Effect::Channel(channel)) => {
                bus.listen(self.seat, channel != Channel::Closed);
                tell(AdapterNews::Channel(channel));
            }
            None => {}
        }
        if let Some(refusal) = reaction.refusal {
            tell(AdapterNews::Refused(refusal));
        }
        if let Some(Effect::Channel(_)) = reaction.effect {
            self.forget_frames()?;
        }
        if !matches!(reaction.effect, Some(Effect::Transmit(_))) {
            self.held = None;
        } else if self.outbox.is_empty() {
            self.held = Some(now.saturating_add(HOLD));
        }
        self.push(reaction.answer.as_octets());
        Ok(())
    }

    /// What the next `F` tells of the bus.
    fn note<E: 'static>(&mut self, bus: &mut Bus<E>) {
        let notes = bus.take_notes(self.seat);
        let counters = bus.confinement(self.seat).unwrap_or_default();
        for (is_so, flag) in [
            (notes.arbitration_lost, Flags::ARBITRATION_LOST),
            (notes.bus_error, Flags::BUS_ERROR),
            (notes.overruns > 0, Flags::OVERRUN),
            (counters.is_warning(), Flags::WARNING),
            (counters.state() != ErrorState::Active, Flags::PASSIVE),
        ] {
            if is_so {
                self.machine.raise(flag);
            }
        }
    }

    /// Throws away frames that the master has not read: they are stale. Answers it has not read go with them only if
    /// there were frames, since the kernel cannot tell the two apart.
    fn forget_frames(&mut self) -> io::Result<()> {
        if !core::mem::take(&mut self.told) {
            return Ok(());
        }
        let begun = core::mem::take(&mut self.begun);
        let rest = self.outbox.iter().position(|octet| ends_line(*octet)).filter(|_| begun);
        self.outbox.truncate(rest.map_or(0, |last| last + 1));
        match &self.stream {
            Some(stream) => stream.discard_output(),
            None => Ok(()),
        }
    }

    /// Puts a line behind the others. False if there is no room.
    fn push(&mut self, line: &[u8]) -> bool {
        let fits = self.outbox.len() + line.len() <= MAX_OUTBOX;
        if fits {
            self.outbox.extend(line);
        }
        fits
    }

    /// Hands out what the bus has for the master, as far as it reads.
    pub(super) fn write<E: 'static>(&mut self, bus: &mut Bus<E>, now: Instant) -> io::Result<()> {
        while let Some(heard) = bus.poll_heard(self.seat) {
            self.held = None;
            let Some(line) = self.machine.frame(heard.at, &heard.frame) else { continue };
            self.told = true;
            if !self.push(line.as_octets()) {
                self.lose();
            }
        }
        if self.held.is_some_and(|held| now < held) && !bus.is_quiet() {
            return Ok(());
        }
        self.held = None;
        let Some(stream) = &mut self.stream else {
            self.outbox.clear();
            return Ok(());
        };
        while !self.outbox.is_empty() {
            let (front, _) = self.outbox.as_slices();
            match stream.write(front)? {
                Some(0) => break,
                Some(count) => {
                    let last = self.outbox.drain(..count).next_back();
                    self.begun = last.is_some_and(|octet| !ends_line(octet));
                }
                None => {
                    let lines = self.outbox.iter().filter(|octet| **octet == slcan::CR).count();
                    self.dropped = self.dropped.saturating_add(lines as u64);
                    self.outbox.clear();
                }
            }
        }
        Ok(())
    }

    fn lose(&mut self) {
        self.dropped = self.dropped.saturating_add(1);
        self.machine.raise(Flags::RECEIVE_FULL.with(Flags::OVERRUN));
        if !self.loss_reported {
            self.loss_reported = true;
            tracing::warn!("slcan: the master at {} does not read: frames are lost", self.name);
        }
    }

    /// What to sleep on.
    pub(super) fn watch<'a, E: 'static>(&'a self, bus: &Bus<E>, sleep: &mut Sleep<'a>) {
        if let Some(stream) = &self.stream {
            let reads = self.inbox.is_empty() || self.may_go_on(bus);
            stream.watch(reads, self.held.is_none() && !self.outbox.is_empty(), sleep);
        }
    }

    /// Until when acknowledgements wait.
    pub(super) const fn held_until(&self) -> Option<Instant> {
        self.held
    }

    /// How long a sleep may last at most; `None`: for ever.
    pub(super) fn patience(&mut self) -> Option<Duration> {
        self.stream.as_mut().and_then(Stream::patience)
    }
}

/// Whether an answer or the line of a frame ends with this octet.
const fn ends_line(octet: u8) -> bool {
    octet == slcan::CR || octet == slcan::BEL
}

#[cfg(test)]
mod tests {
    use std::io::{ErrorKind, Read, Write};
    use std::net::{TcpListener, TcpStream};

    use super::*;
    use crate::can_bus::can::BitRate;

    /// An adapter whose channel is open, and its master.
    fn open(bus: &mut Bus<()>) -> (Adapter, TcpStream) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut master = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let stream = Stream::tcp(listener.accept().unwrap().0).unwrap();
        let mut adapter = Adapter::new(stream, "master".into(), bus, Instant::ZERO);
        master.write_all(b"O\r").unwrap();
        while adapter.machine.channel() != Channel::Open {
            adapter.read(bus, Instant::ZERO, &mut |_| {}).unwrap();
        }
        adapter.write(bus, Instant::ZERO).unwrap();
        assert_eq!(read(&mut master), b"\r");
        (adapter, master)
    }

    /// The adapter takes lines of the master, the first of which is a frame.
    fn send(adapter: &mut Adapter, master: &mut TcpStream, bus: &mut Bus<()>, octets: &[u8], now: Instant) {
        master.write_all(octets).unwrap();
        while bus.is_quiet() {
            adapter.read(bus, now, &mut |_| {}).unwrap();
        }
    }

    fn read(master: &mut TcpStream) -> Vec<u8> {
        master.set_nonblocking(true).unwrap();
        let mut octets = [0; 256];
        match master.read(&mut octets) {
            Ok(count) => octets[..count].to_vec(),
            Err(error) => {
                assert_eq!(error.kind(), ErrorKind::WouldBlock);
                Vec::new()
            }
        }
    }

    #[test]
    fn acknowledgements_wait_while_the_bus_is_busy_and_no_longer_than_a_millisecond() {
        let mut bus = Bus::new(BitRate::K1000);
        let (mut adapter, mut master) = open(&mut bus);
        send(&mut adapter, &mut master, &mut bus, &b"t0800\r".repeat(30), Instant::ZERO);
        let (early, late) = (Instant::from_micros(999), Instant::from_millis(1));
        bus.handle_timeout(early);
        adapter.write(&mut bus, early).unwrap();
        assert_eq!((read(&mut master), adapter.held_until()), (Vec::new(), Some(late)));
        bus.handle_timeout(late);
        assert!(!bus.is_quiet());
        adapter.write(&mut bus, late).unwrap();
        assert_eq!((read(&mut master), adapter.held_until()), (b"z\r".repeat(30), None));
    }

    #[test]
    fn an_acknowledgement_does_not_wait_for_an_idle_bus_nor_when_another_answer_waits() {
        let mut bus = Bus::new(BitRate::K1000);
        let (mut adapter, mut master) = open(&mut bus);
        send(&mut adapter, &mut master, &mut bus, b"t0800\r", Instant::ZERO);
        let end = bus.poll_timeout().unwrap();
        bus.handle_timeout(end);
        adapter.write(&mut bus, end).unwrap();
        assert_eq!(read(&mut master), b"z\r", "the frame has ended, and nobody answers");
        send(&mut adapter, &mut master, &mut bus, b"t0800\rV\r", end);
        adapter.write(&mut bus, end).unwrap();
        assert!(read(&mut master).starts_with(b"z\rV"));
    }
}
