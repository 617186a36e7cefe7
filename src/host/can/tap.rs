//! A tap: shows each frame that a master's end sends and hears, and changes nothing.

use core::time::Duration;
use std::io;

use super::CanEndpoint;
use crate::can_bus::can::Frame;
use crate::host::link::tap::Direction;
use crate::host::{Clock, Stop, SystemClock};
use crate::time::Instant;

/// An endpoint that shows what passes, a frame that is sent before it is sent.
pub(crate) struct CanTap<F> {
    endpoint: Box<dyn CanEndpoint>,
    clock: SystemClock,
    observer: F,
}

impl<F: FnMut(Instant, Direction, &Frame)> CanTap<F> {
    /// Shows what passes at `endpoint` to `observer`, with the times of `clock`.
    pub(crate) fn new(endpoint: Box<dyn CanEndpoint>, clock: SystemClock, observer: F) -> Self {
        Self { endpoint, clock, observer }
    }
}

impl<F: FnMut(Instant, Direction, &Frame)> CanEndpoint for CanTap<F> {
    fn send(&mut self, frame: &Frame) -> io::Result<()> {
        (self.observer)(self.clock.now(), Direction::Sent, frame);
        self.endpoint.send(frame)
    }

    fn receive(&mut self) -> io::Result<Option<Frame>> {
        let frame = self.endpoint.receive()?;
        if let Some(frame) = &frame {
            (self.observer)(self.clock.now(), Direction::Heard, frame);
        }
        Ok(frame)
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        self.endpoint.wait(timeout, stop)
    }
}
