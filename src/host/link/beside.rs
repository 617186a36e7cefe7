//! A link with a line in memory beside it: who is there hears what comes from the link, and is heard there.

use core::time::Duration;
use std::io;

use super::memory::{End, Wire};
use crate::host::{Link, Received, Stop};
use crate::time::BaudRate;

/// A link, and others in this process on the same line.
pub(crate) struct Beside<L> {
    link: L,
    wire: Wire,
    end: End,
}

/// An end of the line beside. What it sends ends the sleep of the link.
pub(crate) struct Neighbour {
    end: End,
    wake: Stop,
}

/// Where neighbours come from.
#[derive(Clone, Debug)]
pub(crate) struct Door {
    wire: Wire,
    wake: Stop,
}

impl Door {
    /// A new neighbour, who hears the line from now on.
    pub(crate) fn neighbour(&self) -> Neighbour {
        Neighbour { end: self.wire.end(), wake: self.wake.clone() }
    }
}

impl<L: Link> Beside<L> {
    /// With nobody beside it.
    pub(crate) fn new(link: L) -> Self {
        let wire = Wire::new();
        Self { link, end: wire.end(), wire }
    }

    /// Where others come on the line. `wake` ends a sleep of this link.
    pub(crate) fn door(&self, wake: Stop) -> Door {
        Door { wire: self.wire.clone(), wake }
    }
}

impl<L: Link> Link for Beside<L> {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        let received = self.link.receive(buf)?;
        match received {
            Received::Octets(count) | Received::BrokenOff(count) => {
                self.end.send(buf.get(..count).unwrap_or_default())?;
                Ok(received)
            }
            Received::Reset | Received::Rate(_) => Ok(received),
            Received::Nothing => {
                let received = self.end.receive(buf)?;
                if let Received::Octets(count) = received {
                    self.link.send(buf.get(..count).unwrap_or_default())?;
                }
                Ok(received)
            }
        }
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        self.end.send(telegram)?;
        self.link.send(telegram)
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

impl Link for Neighbour {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        self.end.receive(buf)
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        self.end.send(telegram)?;
        self.wake.request();
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        self.end.wait(timeout, stop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(link: &mut impl Link) -> Vec<u8> {
        let mut octets = [0; 64];
        match link.receive(&mut octets).unwrap() {
            Received::Octets(count) => octets[..count].to_vec(),
            Received::BrokenOff(_) | Received::Reset | Received::Rate(_) | Received::Nothing => Vec::new(),
        }
    }

    #[test]
    fn everybody_hears_everybody_else_once() {
        let (outside, wake) = (Wire::new(), Stop::new().unwrap());
        let (mut line, mut master) = (Beside::new(outside.end()), outside.end());
        let mut neighbour = line.door(wake.clone()).neighbour();
        master.send(&[1, 2]).unwrap();
        assert_eq!(heard(&mut line), [1, 2]);
        assert_eq!(heard(&mut neighbour), [1, 2]);
        neighbour.send(&[3]).unwrap();
        assert!(wake.is_requested());
        assert_eq!(heard(&mut line), [3]);
        assert_eq!(heard(&mut master), [3]);
        line.send(&[4]).unwrap();
        assert_eq!((heard(&mut master), heard(&mut neighbour)), (vec![4], vec![4]));
        assert_eq!((heard(&mut line), heard(&mut master)), (Vec::new(), Vec::new()));
    }
}
