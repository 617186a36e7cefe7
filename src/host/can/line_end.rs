//! A bus of this process as one of its masters has it: for who plays the master and offers adapters to the rest.

use core::time::Duration;
use std::io;

use super::line::{AdapterNews, News, Stay};
use super::{CanEndpoint, Line, LinkSpec, Seat};
use crate::can_bus::can::slcan::Channel;
use crate::can_bus::can::{BitRate, Frame};
use crate::host::{Clock, Error, Reach, Stop, SystemClock};

/// How long a full bus is left alone.
const FULL: Duration = Duration::from_micros(200);

/// A bus with adapters, and a port of it.
pub(crate) struct LineEnd {
    line: Line<()>,
    seat: Seat,
    clock: SystemClock,
    /// Nobody requests this one.
    stop: Stop,
}

impl LineEnd {
    /// Opens the link and a bus without nodes.
    ///
    /// # Errors
    /// As [`Line::open`].
    pub(crate) fn open(spec: &LinkSpec, rate: BitRate, reach: Reach) -> Result<Self, Error> {
        let mut line = Line::open(spec, rate, reach)?;
        let clock = line.clock();
        let seat = line.connect_own();
        let stop = Stop::new().map_err(|source| Error::Link { source })?;
        Ok(Self { line, seat, clock, stop })
    }

    /// What the others open.
    pub(crate) fn name(&self) -> &str {
        self.line.name()
    }

    /// Waits until somebody has opened an adapter. False: nobody has within `limit`.
    ///
    /// # Errors
    /// The adapters no longer work.
    pub(crate) fn wait_for_somebody(&mut self, limit: Duration, stop: &Stop) -> Result<bool, Error> {
        let until = self.clock.now().saturating_add(limit);
        let mut open = false;
        while !open && !stop.is_requested() && self.clock.now() < until {
            let mut hear = |news| {
                open |= matches!(news, News::Adapter { news: AdapterNews::Channel(Channel::Open), .. });
            };
            self.line.turn_until(Stay::Sleep, Some(until), stop, &mut hear)?;
        }
        Ok(open)
    }
}

impl CanEndpoint for LineEnd {
    fn send(&mut self, frame: &Frame) -> io::Result<()> {
        // Each frame has its time on the bus.
        while !self.line.bus().has_room(self.seat) {
            let turned = self.line.turn_until(Stay::Awake, None, &self.stop, &mut |_| {});
            turned.map_err(|error| io::Error::other(error.to_string()))?;
            std::thread::sleep(FULL);
        }
        let bus = self.line.bus_mut();
        bus.send(self.clock.now(), self.seat, *frame).map_err(|_full| io::ErrorKind::WouldBlock.into())
    }

    fn receive(&mut self) -> io::Result<Option<Frame>> {
        Ok(self.line.bus_mut().poll_heard(self.seat).map(|heard| heard.frame))
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        let latest = timeout.map(|timeout| self.clock.now().saturating_add(timeout));
        let turned = self.line.turn_until(Stay::Sleep, latest, stop, &mut |_| {});
        turned.map_err(|error| io::Error::other(error.to_string()))
    }
}
