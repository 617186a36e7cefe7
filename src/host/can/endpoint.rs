//! A bus of CAN from a master's end: frames out, frames in.
//!
//! | implementation | over |
//! | --- | --- |
//! | [`SlcanEndpoint`] | an slcan adapter behind any [`Link`], emulated or real |
//! | `SocketCanEndpoint` | an interface of Linux (feature `socketcan`) |

use core::time::Duration;
use std::collections::VecDeque;
use std::io;

use crate::can_bus::can::slcan::{BEL, CR, FrameLine, LF, parse_frame};
use crate::can_bus::can::{BitRate, Frame};
use crate::host::{Link, Received, Stop};

/// A bus of CAN from a master's end.
pub trait CanEndpoint {
    /// Sends a frame.
    ///
    /// # Errors
    /// The bus can no longer be reached.
    fn send(&mut self, frame: &Frame) -> io::Result<()>;

    /// The next frame that has arrived, without waiting.
    ///
    /// # Errors
    /// The bus can no longer be reached.
    fn receive(&mut self) -> io::Result<Option<Frame>>;

    /// Sleeps until something may have arrived, `timeout` has passed (`None`: never) or `stop` is requested. May return
    /// early for no reason.
    ///
    /// # Errors
    /// The bus can no longer be reached.
    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()>;
}

impl<E: CanEndpoint + ?Sized> CanEndpoint for std::boxed::Box<E> {
    fn send(&mut self, frame: &Frame) -> io::Result<()> {
        (**self).send(frame)
    }

    fn receive(&mut self) -> io::Result<Option<Frame>> {
        (**self).receive()
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        (**self).wait(timeout, stop)
    }
}

/// The longest line of an adapter that is looked at.
const LONGEST: usize = 64;

/// An slcan adapter as its master uses it. The channel is closed when this is dropped.
#[derive(Debug)]
pub struct SlcanEndpoint<L: Link> {
    link: L,
    line: Vec<u8>,
    frames: VecDeque<Frame>,
    refused: u64,
}

impl<L: Link> SlcanEndpoint<L> {
    /// Opens the channel of the adapter behind `link` at `rate`, one of those that slcan has a number for.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidInput`]: slcan has no number for this rate. Others: the link does not work.
    pub(crate) fn open(mut link: L, rate: BitRate) -> io::Result<Self> {
        let code = code(rate).ok_or(io::ErrorKind::InvalidInput)?;
        // A channel that another left open refuses the rate; a line that another left half done ends first.
        link.send(&[CR, CR, b'C', CR, b'S', code, CR, b'O', CR])?;
        Ok(Self { link, line: Vec::new(), frames: VecDeque::new(), refused: 0 })
    }

    /// How many lines the adapter has refused; the first may be the closing of a channel that was not open.
    pub const fn refused(&self) -> u64 {
        self.refused
    }

    fn take(&mut self, octets: &[u8]) {
        for octet in octets {
            match *octet {
                CR => {
                    if let Some(Ok(frame)) = parse_frame(&self.line) {
                        self.frames.push_back(frame);
                    }
                    self.line.clear();
                }
                BEL => {
                    self.refused += 1;
                    self.line.clear();
                }
                LF => {}
                other if self.line.len() < LONGEST => self.line.push(other),
                _ => {}
            }
        }
    }
}

impl<L: Link> CanEndpoint for SlcanEndpoint<L> {
    fn send(&mut self, frame: &Frame) -> io::Result<()> {
        self.link.send(FrameLine::new(frame, None).as_octets())
    }

    fn receive(&mut self) -> io::Result<Option<Frame>> {
        let mut octets = [0; 1024];
        while self.frames.is_empty() {
            match self.link.receive(&mut octets)? {
                Received::Octets(count) | Received::BrokenOff(count) => {
                    self.take(octets.get(..count).unwrap_or_default());
                }
                Received::Reset => self.line.clear(),
                Received::Rate(_) => {}
                Received::Nothing => break,
            }
        }
        Ok(self.frames.pop_front())
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        if self.frames.is_empty() { self.link.wait(timeout, stop) } else { Ok(()) }
    }
}

impl<L: Link> Drop for SlcanEndpoint<L> {
    fn drop(&mut self) {
        let _ = self.link.send(&[b'C', CR]);
    }
}

/// The digit behind `S`.
fn code(rate: BitRate) -> Option<u8> {
    const RATES: [u32; 9] = [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];
    let place = RATES.iter().position(|bits| *bits == rate.bits_per_second())?;
    u8::try_from(place).ok().map(|place| b'0' + place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can_bus::can::Id;
    use crate::host::link::memory::Wire;

    fn everything(link: &mut impl Link) -> Vec<u8> {
        let mut octets = [0; 256];
        let Received::Octets(count) = link.receive(&mut octets).unwrap() else { panic!("nothing came") };
        octets[..count].to_vec()
    }

    #[test]
    fn the_channel_is_opened_frames_pass_and_it_is_closed() {
        let wire = Wire::new();
        let mut adapter = wire.end();
        let mut bus = SlcanEndpoint::open(wire.end(), BitRate::K500).unwrap();
        assert_eq!(everything(&mut adapter), b"\r\rC\rS6\rO\r");
        let frame = Frame::with(Id::base(0x605).unwrap(), [0x40, 0, 0x10, 0, 0, 0, 0, 0]);
        bus.send(&frame).unwrap();
        assert_eq!(everything(&mut adapter), b"t60584000100000000000\r");
        adapter.send(b"\x07\r\rz\rt58584300").unwrap();
        assert_eq!(bus.receive().unwrap(), None);
        adapter.send(b"100092010000\r\nr7051\rt12\x07t0800\r").unwrap();
        let frames: Vec<_> =
            core::iter::from_fn(|| bus.receive().unwrap()).map(|frame| frame.id().number()).collect();
        assert_eq!((frames, bus.refused()), ([0x585, 0x705, 0x080].into(), 2));
        drop(bus);
        assert_eq!(everything(&mut adapter), b"C\r");
    }

    #[test]
    fn a_line_without_an_end_takes_no_memory() {
        let wire = Wire::new();
        let mut adapter = wire.end();
        let mut bus = SlcanEndpoint::open(wire.end(), BitRate::K1000).unwrap();
        for _ in 0..100 {
            adapter.send(&[b't'; 200]).unwrap();
            assert_eq!(bus.receive().unwrap(), None);
        }
        assert!(bus.line.len() <= LONGEST);
        adapter.send(b"\rt0800\r").unwrap();
        assert!(bus.receive().unwrap().is_some());
    }
}
