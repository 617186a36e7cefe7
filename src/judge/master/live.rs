//! A judgement on a link of the operating system.

use core::cell::{Cell, RefCell};
use core::time::Duration;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;

use super::Report;
use super::play::Judge;
use crate::devices::ag03::profibus::Timing;
use crate::host::link::fault::Faulty;
use crate::host::link::tap::{Batch, Direction, Tap};
use crate::host::{Bus, Clock, Error, Link, Received, Stop};
use crate::judge::Progress;
use crate::judge::moment::{Moment, Side};
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::time::{BaudRate, Instant};

/// Octets taken from the link at most before they are answered.
const BATCH: usize = 2048;
/// While a reply is held back the judge looks so often, to know that it was awake.
const HEARTBEAT: Duration = Duration::from_millis(3);
/// Longer than this after the time it wanted to look: it was not awake.
const ASLEEP: Duration = Duration::from_millis(4);

type Queue = Rc<RefCell<VecDeque<Moment>>>;

/// Somebody who operates the master under test.
pub trait Operator {
    /// Begins an action: `operate`, `clear`, `stop`, `restart`, `outputs ADDRESS HEX`, `sync GROUPS` and the like.
    fn begin(&mut self, action: &str);

    /// Whether it is done: `None` not yet, `Some(false)` it could not be.
    fn poll(&mut self) -> Option<bool>;
}

/// While an action is under way its end is looked for so often.
const ASK_PULSE: Duration = Duration::from_millis(20);

/// Runs `judge` with its stations on `link` until it is over or `stop` is requested. `rate` is that of the line, as far
/// as there is one; `told` gets what is being tried.
///
/// # Errors
/// [`Error::Link`] when the link no longer works.
pub fn live<L: Link, C: Clock + Clone>(
    mut judge: Judge,
    link: L,
    clock: &C,
    rate: BaudRate,
    stop: &Stop,
    mut operator: Option<&mut dyn Operator>,
    told: &mut dyn FnMut(&Progress),
) -> Result<Report, Error> {
    let queue = Queue::default();
    let heard = Rc::clone(&queue);
    let tap = Tap::new(link, clock.clone(), move |batch: &Batch| {
        let mut heard = heard.borrow_mut();
        // What is sent the recorder writes down, whole.
        for seen in batch.iter().filter(|seen| seen.direction == Direction::Heard) {
            heard.push_back(Moment::new(seen.at, Side::Master, seen.octets));
        }
    });
    let speaker = Rc::new(Cell::new(Side::Station(None)));
    let (named, clock_of_it) = (Rc::clone(&speaker), clock.clone());
    let recorder = Recorder { link: tap, clock: clock_of_it, queue: Rc::clone(&queue), speaker: named };
    let mut link = Faulty::new(recorder, clock.clone(), &[]);
    let mut bus = Bus::on(rate, Timing::Untrue);
    let origin = clock.now();
    judge.begin(origin, &mut bus, link.faults_mut());
    let mut expected: Option<Instant> = None;
    while judge.ending().is_none() {
        turn(&mut link, &mut bus, clock)?;
        if judge.has_second() {
            // The tap shows what was heard before a sleep; a second master answers before it.
            link.wait(Some(Duration::ZERO), stop).map_err(failed)?;
        }
        let now = clock.now();
        if expected.is_some_and(|expected| now.saturating_since(expected) > ASLEEP) {
            judge.paused();
        }
        while let Some(moment) = queue.borrow_mut().pop_front() {
            judge.hear(moment);
        }
        judge.step(now, &mut bus, link.faults_mut());
        while let Some(octets) = judge.speak(clock.now()) {
            speaker.set(judge.second_address().map_or(Side::Station(None), Side::Other));
            link.send(&octets).map_err(failed)?;
            speaker.set(Side::Station(None));
            while let Some(moment) = queue.borrow_mut().pop_front() {
                judge.hear(moment);
            }
            // The stations hear it, too, and whose replies come next is known.
            let _ = link.faults_mut().request(clock.now(), octets.clone());
            bus.handle_bytes(clock.now(), &octets);
            drain(&mut link, &mut bus, clock)?;
        }
        if let Some(progress) = judge.poll_progress() {
            told(&progress);
        }
        if let Some(operator) = &mut operator {
            if let Some(action) = judge.poll_ask() {
                operator.begin(&action);
            }
            if judge.is_asking()
                && let Some(done) = operator.poll()
            {
                judge.asked(now, done);
            }
        }
        if stop.is_requested() {
            judge.stop();
        }
        // It has no next time: a master that says nothing would never wake the judge.
        if judge.ending().is_some() {
            break;
        }
        let now = clock.now();
        let due = Instant::first_of(bus.poll_timeout(), judge.poll_timeout());
        let due = Instant::first_of(due, judge.second_due());
        let pulse = judge.is_waiting().then(|| now + HEARTBEAT);
        let pulse = pulse.or(judge.is_asking().then(|| now + ASK_PULSE));
        let due = Instant::first_of(due, pulse);
        let timeout = due.map(|due| due.saturating_since(now));
        expected = due.map(|due| due.max(now));
        if timeout.is_none_or(|timeout| !timeout.is_zero()) {
            link.wait(timeout, stop).map_err(failed)?;
        }
    }
    Ok(judge.report(origin))
}

/// Hears, answers, and does what is due.
fn turn<L: Link, C: Clock>(link: &mut L, bus: &mut Bus, clock: &C) -> Result<(), Error> {
    let mut batch = [0; BATCH];
    let mut heard = 0;
    let mut reset = false;
    while let Some(free) = batch.get_mut(heard..).filter(|free| !free.is_empty()) {
        match link.receive(free).map_err(failed)? {
            Received::Octets(count) | Received::BrokenOff(count) => heard += count,
            Received::Reset => {
                reset = true;
                break;
            }
            Received::Rate(rate) => bus.set_baud(rate),
            Received::Nothing => break,
        }
    }
    if let Some(octets) = batch.get(..heard).filter(|octets| !octets.is_empty()) {
        bus.handle_bytes(clock.now(), octets);
        drain(link, bus, clock)?;
    }
    if reset {
        bus.handle_reset();
    }
    let now = clock.now();
    if bus.poll_timeout().is_some_and(|due| due <= now) {
        bus.handle_timeout(now);
        drain(link, bus, clock)?;
    }
    Ok(())
}

fn drain<L: Link, C: Clock>(link: &mut L, bus: &mut Bus, clock: &C) -> Result<(), Error> {
    let mut buf = [0; MAX_TELEGRAM_LEN];
    while let Some(telegram) = bus.poll_transmit(clock.now(), &mut buf) {
        link.send(telegram).map_err(failed)?;
    }
    while bus.poll_event().is_some() {}
    Ok(())
}

const fn failed(source: io::Error) -> Error {
    Error::Link { source }
}

/// Writes down what is sent, each sending whole: what is broken on purpose must not be taken apart.
struct Recorder<L, C> {
    link: L,
    clock: C,
    queue: Queue,
    /// Who sends now.
    speaker: Rc<Cell<Side>>,
}

impl<L: Link, C: Clock> Link for Recorder<L, C> {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        self.link.receive(buf)
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        let sent = self.link.send(telegram);
        // Behind what was heard before it, which the tap has shown by now.
        self.queue.borrow_mut().push_back(Moment::new(self.clock.now(), self.speaker.get(), telegram));
        sent
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        self.link.wait(timeout, stop)
    }

    fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
        self.link.set_rate(rate)
    }

    fn resolution(&self) -> Duration {
        self.link.resolution()
    }
}
