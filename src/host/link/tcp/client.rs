//! One program at a TCP port: what it sent and has not been heard, what it has not read, and when it must go.

use core::net::SocketAddr;
use core::time::Duration;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;

use super::{Busy, IN_TURN, MAX_BACKLOG, MAX_BURST, Meaning};
use crate::host::link::Look;
use crate::host::link::pieces::{Piece, Pieces};
use crate::time::{BITS_PER_OCTET, BaudRate, Instant};

/// Octets in a second on a line of 12 Mbit/s.
const FASTEST: u32 = BaudRate::K12000.bits_per_second() / BITS_PER_OCTET;

/// Octets of a client that are collected at most before they are heard.
const INBOX: usize = 4096;

/// Octets the kernel keeps for a client at least; it takes twice as many. Fixed, so that it does not grow to megabytes.
const KERNEL_BUFFER: usize = 64 * 1024;

/// A client that said no noise for so long is believed an SC.
const QUIET: Duration = Duration::from_secs(1);

/// Why a client leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Leave {
    /// It sends no more.
    Closed,
    /// The connection broke.
    Broken,
    /// It does not read.
    Stalled,
    /// It sends more than a line carries.
    Flooding,
}

impl core::fmt::Display for Leave {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Closed => f.write_str("has closed its connection"),
            Self::Broken => f.write_str("has lost its connection"),
            Self::Stalled => write!(f, "is dropped: it does not read, and {MAX_BACKLOG} octets wait for it"),
            Self::Flooding => f.write_str("is dropped: it sends more than a line of 12 Mbit/s carries"),
        }
    }
}

/// A program at the line.
#[derive(Debug)]
pub(super) struct Client {
    pub(super) stream: TcpStream,
    pub(super) look: Look,
    pub(super) peer: SocketAddr,
    /// What it sent and nobody has heard yet.
    pub(super) pieces: Pieces,
    /// What is before those and waits for the line.
    pub(super) blocked: Option<Piece>,
    /// When it was last heard saying what is no telegram.
    pub(super) last_noise: Option<Instant>,
    /// What it has not read yet, behind what the kernel keeps for it.
    pub(super) backlog: VecDeque<u8>,
    allowance: Allowance,
    pub(super) left: Option<Leave>,
}

impl Client {
    /// A program that has just connected.
    pub(super) fn new(stream: TcpStream, peer: SocketAddr, now: Instant) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        rustix::net::sockopt::set_socket_send_buffer_size(&stream, KERNEL_BUFFER)?;
        Ok(Self {
            stream,
            look: Look::new(IN_TURN),
            peer,
            pieces: Pieces::default(),
            blocked: None,
            last_noise: None,
            backlog: VecDeque::new(),
            allowance: Allowance::new(now),
            left: None,
        })
    }

    /// How many octets of it can be taken.
    pub(super) fn room(&self) -> usize {
        if self.left.is_some() { 0 } else { INBOX.saturating_sub(self.pieces.len()) }
    }

    /// Whether it may be heard with a piece of this meaning, while a request waits for its reply (`busy`) or not.
    pub(super) fn may_say(&self, meaning: Meaning, now: Instant, busy: Option<Busy>) -> bool {
        let Some(busy) = busy else { return true };
        match meaning {
            Meaning::Request(_) => false,
            Meaning::Reply(station) => station == busy.station,
            // From one who says other things as well it is a chance octet of noise.
            Meaning::ShortAcknowledge => {
                let noise = self.last_noise.is_some_and(|last| now.saturating_since(last) < QUIET);
                !noise && self.pieces.len() == 0
            }
            Meaning::Neither => busy.master == self.peer,
        }
    }

    /// Everything it sent was heard, as far as it was whole.
    pub(super) fn is_done(&self) -> bool {
        self.blocked.is_none() && self.pieces.poll_timeout().is_none()
    }

    /// Takes what has come.
    pub(super) fn read(&mut self, now: Instant) {
        let mut buf = [0; INBOX];
        let room = self.room();
        let Some(buf) = buf.get_mut(..room).filter(|buf| !buf.is_empty()) else {
            return;
        };
        if !self.look.asks() {
            return;
        }
        match (&self.stream).read(buf) {
            Ok(0) => {
                self.left = Some(Leave::Closed);
                self.pieces.end();
            }
            Ok(count) => {
                if count < buf.len() {
                    self.look.is_empty();
                }
                let octets = buf.get(..count).unwrap_or_default();
                self.pieces.push(now, octets);
                if !self.allowance.spend(now, u32::try_from(count).unwrap_or(u32::MAX)) {
                    self.drop_for(Leave::Flooding);
                }
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => self.look.is_empty(),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(_) => self.drop_for(Leave::Broken),
        }
    }

    /// Sends octets to it, or keeps them until it reads.
    pub(super) fn tell(&mut self, octets: &[u8]) {
        if matches!(self.left, None | Some(Leave::Closed)) {
            self.backlog.extend(octets);
            self.write();
        }
    }

    /// Sends what waits for it, as far as it reads.
    pub(super) fn write(&mut self) {
        while !self.backlog.is_empty() {
            let (front, _) = self.backlog.as_slices();
            match (&self.stream).write(front) {
                Ok(count) => drop(self.backlog.drain(..count)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => {
                    self.drop_for(Leave::Broken);
                    return;
                }
            }
        }
        if self.backlog.len() > MAX_BACKLOG {
            self.drop_for(Leave::Stalled);
        }
    }

    /// Nothing more is heard of it, and nothing said to it.
    fn drop_for(&mut self, leave: Leave) {
        self.left = Some(leave);
        self.pieces.clear();
        self.blocked = None;
        self.backlog = VecDeque::new();
    }
}

/// How much a client may send: what a line of 12 Mbit/s carries, and [`MAX_BURST`] more.
#[derive(Debug)]
struct Allowance {
    /// Octets it may send at once.
    octets: u32,
    /// Up to when they were refilled.
    refilled: Instant,
}

impl Allowance {
    const fn new(now: Instant) -> Self {
        Self { octets: MAX_BURST, refilled: now }
    }

    /// Whether it may have sent so many octets.
    fn spend(&mut self, now: Instant, octets: u32) -> bool {
        let millis = u32::try_from(now.saturating_since(self.refilled).as_millis()).unwrap_or(u32::MAX);
        // The rest of a millisecond counts the next time.
        self.refilled = self.refilled.saturating_add(Duration::from_millis(millis.into()));
        let refill = millis.saturating_mul(FASTEST / 1000);
        self.octets = self.octets.saturating_add(refill).min(MAX_BURST);
        let enough = octets <= self.octets;
        self.octets = self.octets.saturating_sub(octets);
        enough
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a client may send `octets` every 1.9 ms for ten seconds.
    fn may_send(octets: u32) -> bool {
        let mut allowance = Allowance::new(Instant::ZERO);
        (1..=10_000_000 / 1900).all(|turn| allowance.spend(Instant::from_micros(turn * 1900), octets))
    }

    #[test]
    fn what_a_line_of_12_mbit_carries_may_be_sent_however_often_it_is_read() {
        assert!(may_send(FASTEST / 1000 * 19 / 10));
        assert!(!may_send(FASTEST / 1000 * 2), "5 % more");
    }
}
