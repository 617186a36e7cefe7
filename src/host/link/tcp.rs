//! A TCP port: one line, to which several programs connect, with raw octets in both directions.
//!
//! Every client hears every octet of the drives and of the other clients, not its own. A client can be a master, a
//! slave or a monitor. What a shared line needs and TCP does not have is added here:
//!
//! - **Telegrams are not mixed.** TCP cuts a stream anywhere, so the octets of each client are collected until a
//!   telegram is whole, and only then is it heard, at the same place in the order by everybody. An
//!   incomplete telegram is dropped after 50 ms without a further octet: it is noise then. Noise is heard as it is, except
//!   what could begin a telegram at its end: another client would take the next telegram, of somebody else, for its
//!   rest. That is heard by the drives alone, as [`Received::BrokenOff`].
//! - **A request is followed by its reply.** While a request waits for its reply, for one slot time at most (300 T_bit
//!   and 1 ms), other clients wait with all they send but that reply: with requests, tokens and noise. SC does not say
//!   who sends it: it counts as the reply if its sender says nothing else, and no noise in the second before. Then the
//!   next client in turn is heard, with everything it has sent, 4096 octets at most.
//! - **A client has bounds.** One that does not read is dropped when 512 KiB wait for it; one that
//!   sends more than a line of 12 Mbit/s carries is dropped once it is 256 KiB ahead; clients beyond the
//!   32nd are turned away. Each is a warning in the log.
//! - **When the last client has left**, [`Link::receive`] says [`Received::Reset`].
//!
//! [`Tcp`] is the port, with the drives; a [`Connection`] is the end of one master.
//!
//! Two masters that do not pass the token to each other get replies to their own requests this way, but each hears the
//! replies to the other too, and SC does not say to whom it is addressed.
//!
//! Whoever can connect can command the drives. So the port is bound to this machine unless set otherwise, see
//! [`Reach`].

use core::net::SocketAddr;
use core::time::Duration;
use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::net::{TcpListener, TcpStream};

use rustix::event::{PollFd, PollFlags};

use super::pieces::{Piece, settled};
use super::{Look, Sleep};
use crate::host::reach::{ListenError, listen};
use crate::host::{Clock, Error, Link, Received, Stop, SystemClock, UNTRUE_RESOLUTION};
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, Function, Service, Telegram};
use crate::time::{BaudRate, Instant};

mod client;
mod connection;

pub use connection::Connection;

pub use crate::host::Reach;
use client::{Client, Leave};

/// How many clients there can be at a time.
pub const MAX_CLIENTS: usize = 32;

/// Octets that wait for a client at most.
pub const MAX_BACKLOG: usize = 512 * 1024;

/// Octets by which a client can be ahead of a line of 12 Mbit/s. Less than [`MAX_BACKLOG`], so that a burst of one
/// client drops nobody else.
pub const MAX_BURST: u32 = 256 * 1024;

/// The time of a request for its reply: in T_bit, longer than any min T_SDR, and what a scheduler may take.
const SLOT_BITS: u32 = 300;
const SLOT_MARGIN: Duration = Duration::from_millis(1);

/// A loop asks twice in a turn: for what has come, and whether that was all.
const IN_TURN: u8 = 2;

/// Connections taken at most before the clients are served again.
const MOST_ACCEPTED: usize = 8;

/// After the operating system could not accept a connection (no descriptor is left, say).
const ACCEPT_PAUSE: Duration = Duration::from_secs(1);

/// A listening port and its clients.
#[derive(Debug)]
pub struct Tcp<C = SystemClock> {
    listener: TcpListener,
    knocks: Look,
    address: SocketAddr,
    clock: C,
    slot_time: Duration,
    clients: Vec<Client>,
    /// The index of the client whose turn is next.
    turn: usize,
    /// A request waits for its reply.
    busy: Option<Busy>,
    /// What the drives hear next.
    heard: VecDeque<u8>,
    /// What broke off behind that: octets that must not meet those of another client.
    broken_off: VecDeque<u8>,
    /// The last client has left, and the drives have not been told.
    deserted: bool,
    /// No connection is accepted until then.
    pause: Option<Instant>,
    /// Turning clients away was logged.
    full: bool,
}

/// A request that waits for its reply.
#[derive(Clone, Copy, Debug)]
struct Busy {
    /// Who asked.
    master: SocketAddr,
    /// Who was asked.
    station: Address,
    /// `None` before the first sleep: the drives have not acted on it yet.
    until: Option<Instant>,
    /// The time was over when somebody last looked. The drives get one more look: this process may have been late.
    over: bool,
}

impl Tcp {
    /// Listens at `place`, `HOST:PORT`. Port 0 is a free one, see [`Tcp::address`]. `rate` is that of the drives: it says
    /// how long a request waits for its reply.
    ///
    /// # Errors
    /// [`Error::TcpReach`] if others than this machine could connect and were not invited, [`Error::Tcp`].
    pub fn bind(place: &str, rate: BaudRate, reach: Reach) -> Result<Self, Error> {
        Self::bind_with(place, rate, reach, SystemClock::new())
    }
}

impl<C: Clock> Tcp<C> {
    /// [`Tcp::bind`] with another clock: it says how long a request has waited, and how much a client may have sent.
    ///
    /// # Errors
    /// As [`Tcp::bind`].
    pub fn bind_with(place: &str, rate: BaudRate, reach: Reach, clock: C) -> Result<Self, Error> {
        let (listener, address) = listen(place, reach).map_err(|error| match error {
            ListenError::Failed(source) => Error::Tcp { place: place.into(), source },
            ListenError::TooFar(address) => Error::TcpReach { place: place.into(), address },
        })?;
        Ok(Self {
            listener,
            knocks: Look::new(IN_TURN),
            address,
            clock,
            slot_time: rate.bit_times(SLOT_BITS).saturating_add(SLOT_MARGIN),
            clients: Vec::new(),
            turn: 0,
            busy: None,
            heard: VecDeque::new(),
            broken_off: VecDeque::new(),
            deserted: false,
            pause: None,
            full: false,
        })
    }

    /// Where clients connect.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// How many clients there are.
    pub fn clients(&self) -> usize {
        self.clients.len()
    }

    /// Takes in who wants to connect.
    fn accept(&mut self, now: Instant) {
        if self.pause.is_some_and(|pause| now < pause) {
            return;
        }
        self.pause = None;
        if !self.knocks.asks() {
            return;
        }
        for _ in 0..MOST_ACCEPTED {
            match self.listener.accept() {
                Ok((stream, peer)) => self.welcome(stream, peer, now),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    self.knocks.is_empty();
                    return;
                }
                // That client has gone again.
                Err(error)
                    if matches!(error.kind(), ErrorKind::ConnectionAborted | ErrorKind::Interrupted) => {}
                Err(error) => {
                    tracing::warn!("tcp: cannot accept a connection: {error}");
                    self.pause = Some(now.saturating_add(ACCEPT_PAUSE));
                    return;
                }
            }
        }
    }

    fn welcome(&mut self, stream: TcpStream, peer: SocketAddr, now: Instant) {
        if self.clients.len() >= MAX_CLIENTS {
            if !self.full {
                tracing::warn!("tcp: {peer} and further clients are refused: {MAX_CLIENTS} are connected");
            }
            self.full = true;
            return;
        }
        match Client::new(stream, peer, now) {
            Ok(client) => self.clients.push(client),
            Err(error) => {
                tracing::warn!("tcp: {peer} is refused: {error}");
                return;
            }
        }
        tracing::info!("tcp: {peer} connected, {} of {MAX_CLIENTS}", self.clients.len());
    }

    /// Lets go of clients that have left, once the line is free: a reply may still be on its way to them.
    fn dismiss(&mut self) {
        let busy = self.busy.is_some();
        let before = self.clients.len();
        self.clients.retain(|client| match &client.left {
            None | Some(Leave::Closed) if busy || !client.is_done() => true,
            None => true,
            Some(leave @ (Leave::Closed | Leave::Broken)) => {
                tracing::info!("tcp: {} {leave}", client.peer);
                false
            }
            Some(leave @ (Leave::Stalled | Leave::Flooding)) => {
                tracing::warn!("tcp: {} {leave}", client.peer);
                false
            }
        });
        if self.clients.len() < before {
            self.full = false;
            self.deserted |= self.clients.is_empty();
        }
    }

    /// Whether a request may be heard.
    fn is_free(&mut self, now: Instant) -> bool {
        match &mut self.busy {
            Some(busy) if busy.until.is_some_and(|until| now >= until) => {
                let over = busy.over;
                busy.over = true;
                if over {
                    self.busy = None;
                }
                over
            }
            Some(_) => false,
            None => true,
        }
    }

    /// Lets the next client in turn that may be heard be heard. False if there is none.
    fn hear_next(&mut self, now: Instant, free: bool) -> bool {
        for step in 0..self.clients.len() {
            let index = (self.turn + step) % self.clients.len();
            if self.hear(index, now, free) {
                self.turn = index + 1;
                return true;
            }
        }
        false
    }

    /// Lets one client be heard. False if there is nothing of it, or nothing yet.
    fn hear(&mut self, index: usize, now: Instant, mut free: bool) -> bool {
        let Some(client) = self.clients.get_mut(index) else {
            return false;
        };
        let mut octets = Vec::new();
        while let Some(piece) = client.blocked.take().or_else(|| client.pieces.pop(now)) {
            let meaning = Meaning::of(&piece);
            if !client.may_say(meaning, now, self.busy.filter(|_| !free)) {
                client.blocked = Some(piece);
                break;
            }
            match &piece {
                Piece::Telegram(telegram) => octets.extend_from_slice(telegram),
                Piece::Noise(noise, _) => {
                    client.last_noise = Some(now);
                    let (whole, rest) = noise.split_at(settled(noise).len());
                    octets.extend_from_slice(whole);
                    self.broken_off.extend(rest);
                    if !rest.is_empty() {
                        break;
                    }
                }
            }
            match meaning {
                Meaning::Request(station) => {
                    self.busy = Some(Busy { master: client.peer, station, until: None, over: false });
                    free = false;
                }
                Meaning::Reply(_) | Meaning::ShortAcknowledge => {
                    self.busy = None;
                    free = true;
                }
                Meaning::Neither => {}
            }
        }
        self.heard.extend(&octets);
        for (other, client) in self.clients.iter_mut().enumerate() {
            if other != index {
                client.tell(&octets);
            }
        }
        self.has_octets()
    }

    fn has_octets(&self) -> bool {
        !self.heard.is_empty() || !self.broken_off.is_empty()
    }

    /// Octets for the drives, if there are some.
    fn take(&mut self, buf: &mut [u8]) -> Option<Received> {
        let whole = !self.heard.is_empty();
        let from = if whole { &mut self.heard } else { &mut self.broken_off };
        let count = buf.len().min(from.len());
        for (to, octet) in buf.iter_mut().zip(from.drain(..count)) {
            *to = octet;
        }
        let received = if whole { Received::Octets(count) } else { Received::BrokenOff(count) };
        (count > 0).then_some(received)
    }
}

impl<C: Clock> Link for Tcp<C> {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        if let Some(received) = self.take(buf) {
            return Ok(received);
        }
        let now = self.clock.now();
        self.accept(now);
        for client in &mut self.clients {
            client.read(now);
            client.write();
        }
        let free = self.is_free(now);
        while !self.has_octets() && self.hear_next(now, free && self.busy.is_none()) {}
        self.dismiss();
        if let Some(received) = self.take(buf) {
            return Ok(received);
        }
        Ok(if core::mem::take(&mut self.deserted) { Received::Reset } else { Received::Nothing })
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        self.busy = None;
        for client in &mut self.clients {
            client.tell(telegram);
        }
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        let now = self.clock.now();
        let waits = self.clients.iter().any(|client| client.blocked.is_some() || client.left.is_some());
        if let Some(busy) = &mut self.busy {
            busy.until.get_or_insert(now.saturating_add(self.slot_time));
        }
        let looks = self.busy.filter(|_| waits).and_then(|busy| busy.until);
        if self.deserted || self.has_octets() || waits && self.busy.is_none_or(|busy| busy.over) {
            return Ok(());
        }
        let unblocked = self.clients.iter().filter(|client| client.blocked.is_none());
        let pieces = unblocked.filter_map(|client| client.pieces.poll_timeout()).min();
        let timeout = [looks, pieces, self.pause]
            .into_iter()
            .flatten()
            .map(|due| due.saturating_since(now))
            .chain(timeout)
            .min();
        let mut sleep = Sleep::until(stop);
        if self.pause.is_none() {
            sleep.or(PollFd::new(&self.listener, PollFlags::IN), &self.knocks);
        }
        for client in &self.clients {
            let mut flags = PollFlags::empty();
            flags.set(PollFlags::IN, client.room() > 0);
            flags.set(PollFlags::OUT, !client.backlog.is_empty());
            if !flags.is_empty() {
                sleep.or(PollFd::new(&client.stream, flags), &client.look);
            }
        }
        sleep.sleep(timeout)
    }

    fn resolution(&self) -> Duration {
        UNTRUE_RESOLUTION
    }
}

/// What a piece is to the order on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meaning {
    /// This station will reply to it.
    Request(Address),
    /// It ends the time of a request to this station.
    Reply(Address),
    /// SC: a reply of whoever was asked.
    ShortAcknowledge,
    /// A token, a broadcast, noise.
    Neither,
}

impl Meaning {
    fn of(piece: &Piece) -> Self {
        let Piece::Telegram(octets) = piece else {
            return Self::Neither;
        };
        let Decoded::Telegram { telegram, .. } = decode(octets) else {
            return Self::Neither;
        };
        let telegram = match telegram {
            Telegram::Data(telegram) => telegram,
            Telegram::ShortAcknowledge => return Self::ShortAcknowledge,
            Telegram::Token { .. } => return Self::Neither,
        };
        match telegram.fc.function() {
            Function::Response(..) => Self::Reply(telegram.sa),
            Function::Request(Service::SdnLow | Service::SdnHigh | Service::TimeEvent, _)
            | Function::Reserved => Self::Neither,
            Function::Request(
                Service::SdaLow
                | Service::SdaHigh
                | Service::Msrd
                | Service::FdlStatus
                | Service::SrdLow
                | Service::SrdHigh
                | Service::Ident
                | Service::LsapStatus,
                _,
            ) if telegram.da.is_broadcast() => Self::Neither,
            Function::Request(..) => Self::Request(telegram.da),
        }
    }
}
