//! A bus in virtual time, with a port for the judge: waiting lets time pass.

use core::cell::RefCell;
use core::fmt;
use core::time::Duration;
use std::io;
use std::rc::Rc;

use crate::can_bus::can::{BitRate, Frame};
use crate::host::can::{Bus, CanEndpoint, Seat};
use crate::host::{Clock, Stop};
use crate::time::Instant;

/// A bus in memory and the port of the judge. Clones are the same port.
pub struct Port<E>(Rc<RefCell<Attached<E>>>);

struct Attached<E> {
    bus: Bus<E>,
    seat: Seat,
    now: Instant,
    /// The oldest frame that the bus has handed out and nobody has taken yet.
    heard: Option<Frame>,
}

impl<E: 'static> Port<E> {
    /// A bus without stations but the judge.
    pub fn new(rate: BitRate) -> Self {
        let mut bus = Bus::new(rate);
        let seat = bus.connect(Instant::ZERO);
        Self(Rc::new(RefCell::new(Attached { bus, seat, now: Instant::ZERO, heard: None })))
    }

    /// Does something to the bus now: adds the node, switches it off.
    ///
    /// # Panics
    /// Within another call of the same function.
    pub fn bus<R>(&self, act: impl FnOnce(&mut Bus<E>, Instant) -> R) -> R {
        let Attached { bus, now, .. } = &mut *self.0.borrow_mut();
        act(bus, *now)
    }
}

impl<E> Clone for Port<E> {
    fn clone(&self) -> Self {
        Self(Rc::clone(&self.0))
    }
}

impl<E> fmt::Debug for Port<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Port").finish_non_exhaustive()
    }
}

impl<E: 'static> Attached<E> {
    fn look(&mut self) {
        if self.heard.is_none() {
            self.heard = self.bus.poll_heard(self.seat).map(|heard| heard.frame);
        }
    }

    /// Lets time pass until a frame is heard, or until `end`.
    fn pass(&mut self, end: Instant) {
        self.look();
        while self.heard.is_none() && self.now < end {
            self.now = self.bus.poll_timeout().map_or(end, |due| due.min(end)).max(self.now);
            self.bus.handle_timeout(self.now);
            while self.bus.poll_event().is_some() {}
            self.look();
        }
    }
}

impl<E: 'static> Clock for Port<E> {
    fn now(&self) -> Instant {
        self.0.borrow().now
    }
}

impl<E: 'static> CanEndpoint for Port<E> {
    fn send(&mut self, frame: &Frame) -> io::Result<()> {
        let Attached { bus, seat, now, .. } = &mut *self.0.borrow_mut();
        while !bus.has_room(*seat) {
            let Some(due) = bus.poll_timeout() else { return Err(io::ErrorKind::WouldBlock.into()) };
            *now = due.max(*now);
            bus.handle_timeout(*now);
        }
        bus.send(*now, *seat, *frame).map_err(|_full| io::ErrorKind::WouldBlock.into())
    }

    fn receive(&mut self) -> io::Result<Option<Frame>> {
        let mut attached = self.0.borrow_mut();
        attached.look();
        Ok(attached.heard.take())
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        if !stop.is_requested() {
            let mut attached = self.0.borrow_mut();
            let end = attached.now.saturating_add(timeout.unwrap_or(Duration::from_secs(1)));
            attached.pass(end);
        }
        Ok(())
    }
}
