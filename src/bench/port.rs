//! The line as a [`Link`] and a [`Clock`], for masters that wait by themselves.

use core::cell::RefCell;
use core::time::Duration;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;

use super::{Line, Master};
use crate::host::{Clock, Link, Received, Stop};
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::time::{BaudRate, Instant};

/// A master behind a [`Port`]: what it sends and what it has heard.
#[derive(Debug, Default)]
pub struct Attached {
    outgoing: VecDeque<Vec<u8>>,
    heard: VecDeque<u8>,
}

impl Master for Attached {
    fn handle_bytes(&mut self, _: Instant, octets: &[u8]) {
        self.heard.extend(octets);
    }

    fn handle_sent(&mut self, _: Instant) {}

    fn handle_timeout(&mut self, _: Instant) {}

    fn poll_transmit(&mut self, _: Instant, buf: &mut [u8; MAX_TELEGRAM_LEN]) -> Option<usize> {
        let octets = self.outgoing.pop_front()?;
        buf.get_mut(..octets.len())?.copy_from_slice(&octets);
        Some(octets.len())
    }

    fn poll_timeout(&self) -> Option<Instant> {
        None
    }
}

/// The end of a simulated line that a blocking master opens, and its clock: waiting lets virtual time pass.
///
/// Clones are the same port. A `master::Session` runs on it, and any program that takes a [`Link`] and a [`Clock`].
#[derive(Clone, Debug)]
pub struct Port(Rc<RefCell<Line<Attached>>>);

impl Port {
    /// A line at `baud` without stations, and its port.
    pub fn new(baud: BaudRate) -> Self {
        Self(Rc::new(RefCell::new(Line::with(baud, Attached::default()))))
    }

    /// Does something to the line: adds stations, injects faults, asserts.
    ///
    /// # Panics
    /// Within another call of the same function.
    pub fn line<R>(&self, act: impl FnOnce(&mut Line<Attached>) -> R) -> R {
        act(&mut self.0.borrow_mut())
    }
}

impl Clock for Port {
    fn now(&self) -> Instant {
        self.line(|line| line.now())
    }
}

impl Link for Port {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        self.line(|line| {
            let heard = &mut line.master.heard;
            let count = buf.len().min(heard.len());
            for (to, octet) in buf.iter_mut().zip(heard.drain(..count)) {
                *to = octet;
            }
            Ok(if count == 0 { Received::Nothing } else { Received::Octets(count) })
        })
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        if telegram.len() > MAX_TELEGRAM_LEN {
            return Err(io::ErrorKind::InvalidInput.into());
        }
        self.line(|line| {
            line.master.outgoing.push_back(telegram.to_vec());
            // It begins now, not when somebody waits next.
            line.run_for(Duration::ZERO);
        });
        Ok(())
    }

    /// The masters have this rate from now on.
    fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
        self.line(|line| line.set_baud(rate));
        Ok(())
    }

    /// Lets virtual time pass until octets have come or `timeout` is over.
    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        self.line(|line| {
            if !stop.is_requested() && line.master.heard.is_empty() {
                // In vain is no error.
                let _ =
                    line.run_until(timeout.unwrap_or(Duration::MAX), |line| !line.master.heard.is_empty());
            }
        });
        Ok(())
    }
}
