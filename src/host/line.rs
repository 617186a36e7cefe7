//! An RS-485 line in simulated time that checks the rules of the bus.
//!
//! Octets last as long as they do on a wire, at any of the ten rates. Time jumps from one thing that happens to the
//! next, so hours pass in seconds, and the same calls give the same telegrams at the same nanoseconds everywhere.
//! Whoever breaks a rule ends the simulation with a [`Breach`]:
//!
//! - two senders at the same time;
//! - a request or token without T_SYN (33 T_bit) of silence before it;
//! - a reply that nobody asked for, from somebody else than was asked, before min T_SDR or after max T_SDR;
//! - a station that sends at another rate than that of the line.
//!
//! A master under test sends with [`Line::send`] or [`Line::send_at`] and hears with [`Line::listen`]; [`Master`]
//! builds the telegrams of a scripted one.
//!
//! ```
//! use profidrive::device::{Config, Device, Timing};
//! use profidrive::fdl::Address;
//! use profidrive::host::{Bus, line::Line};
//! use profidrive::time::{BaudRate, Instant};
//!
//! let mut bus = Bus::on(BaudRate::K1500, Timing::True);
//! bus.add(Device::new(Config::new(Address::station(5)?), Instant::ZERO))?;
//! let mut line = Line::new(BaudRate::K1500);
//! line.connect(bus);
//! // FDL status of master 2 to station 5.
//! let reply = line.request(&[0x10, 0x05, 0x02, 0x49, 0x50, 0x16])?;
//! assert_eq!(reply, Some(&[0x10, 0x02, 0x05, 0x00, 0x07, 0x16][..]));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

use core::time::Duration;
use std::boxed::Box;
use std::vec::Vec;

use super::Bus;
use crate::device::MAX_TELEGRAM_LEN;
use crate::fdl::station::DEFAULT_MIN_TSDR;
use crate::fdl::telegram::{Decoded, decode};
use crate::fdl::{Address, Function, Telegram};
use crate::time::{BaudRate, Instant, SYN_BITS};

mod breach;
mod master;

pub use breach::Breach;
pub use master::{Answer, Master};

/// How the line treats octets on their way. Called once for each sending, with the time of its end and its octets,
/// which it may change; says which octet, if any, the receivers get with wrong parity.
pub type Disturbance = Box<dyn FnMut(Instant, &mut Vec<u8>) -> Option<usize> + Send>;

/// A line, the stations on it, and its clock.
pub struct Line {
    baud: BaudRate,
    now: Instant,
    buses: Vec<Bus>,
    /// When the last octet on the line ended.
    idle_since: Instant,
    speaking: Option<Speaking>,
    asked: Option<Asked>,
    disturbance: Option<Disturbance>,
    /// What is being said, as receivers hear it.
    octets: Vec<u8>,
}

/// Somebody sends.
#[derive(Clone, Copy, Debug)]
struct Speaking {
    /// Which bus; `None`: a master.
    bus: Option<usize>,
    end: Instant,
    /// The octet that receivers get with wrong parity.
    parity_error: Option<usize>,
}

/// A request that wants a reply.
#[derive(Clone, Copy, Debug)]
struct Asked {
    station: Address,
    master: Address,
    end: Instant,
}

impl Line {
    /// A silent line at `baud`, nobody on it, at [`Instant::ZERO`].
    pub fn new(baud: BaudRate) -> Self {
        Self {
            baud,
            now: Instant::ZERO,
            buses: Vec::new(),
            idle_since: Instant::ZERO,
            speaking: None,
            asked: None,
            disturbance: None,
            octets: Vec::with_capacity(MAX_TELEGRAM_LEN),
        }
    }

    /// Connects stations and returns the number of their bus, which counts from 0. Several buses are several devices:
    /// nothing keeps them from having the same addresses.
    pub fn connect(&mut self, bus: Bus) -> usize {
        self.buses.push(bus);
        self.buses.len() - 1
    }

    /// The bus of that number.
    pub fn bus(&self, number: usize) -> Option<&Bus> {
        self.buses.get(number)
    }

    /// The bus of that number, to take its news, or to add, change and remove stations.
    pub fn bus_mut(&mut self, number: usize) -> Option<&mut Bus> {
        self.buses.get_mut(number)
    }

    /// The time now.
    pub const fn now(&self) -> Instant {
        self.now
    }

    /// The rate of the masters.
    pub const fn baud(&self) -> BaudRate {
        self.baud
    }

    /// The masters have another rate from now on. A bus keeps its own, and at another rate hears damaged octets.
    pub const fn set_baud(&mut self, baud: BaudRate) {
        self.baud = baud;
    }

    /// Disturbs what is sent from now on; `None` ends it.
    pub fn disturb(&mut self, disturbance: Option<Disturbance>) {
        self.disturbance = disturbance;
    }

    /// A master sends `octets` as soon as the rules allow, T_SYN after the last octet; returns when they have been
    /// heard, with the time of their end.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn send(&mut self, octets: &[u8]) -> Result<Instant, Breach> {
        self.let_finish()?;
        let earliest = self.idle_since.saturating_add(self.baud.bit_times(SYN_BITS));
        self.send_at(self.now.max(earliest), octets)
    }

    /// A master sends `octets` from `at` on, or from now if that is later, whether the rules allow it or not; returns
    /// when they have been heard, with the time of their end.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn send_at(&mut self, at: Instant, octets: &[u8]) -> Result<Instant, Breach> {
        while self.step(at)?.is_some() {}
        self.begin(None, octets)?;
        let end = self.speaking.map_or(self.now, |speaking| speaking.end);
        self.let_finish()?;
        Ok(end)
    }

    /// Lets time pass until somebody at this line has said something, or until `until`: the octets, as they are heard.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn listen(&mut self, until: Instant) -> Result<Option<&[u8]>, Breach> {
        Ok(self.step(until)?.map(|()| self.octets.as_slice()))
    }

    /// Lets time pass.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn wait(&mut self, time: Duration) -> Result<(), Breach> {
        let until = self.now.saturating_add(time);
        while self.step(until)?.is_some() {}
        Ok(())
    }

    /// [`Line::send`], and what comes back within the slot time: `None` if nothing does. What comes back may be
    /// damaged if the line is disturbed.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn request(&mut self, octets: &[u8]) -> Result<Option<&[u8]>, Breach> {
        let end = self.send(octets)?;
        // A reply must have begun within the slot time; then it is heard to its end.
        let mut until = end.saturating_add(self.slot_time());
        loop {
            if self.step(until)?.is_some() {
                return Ok(Some(self.octets.as_slice()));
            }
            match self.speaking {
                Some(speaking) => until = speaking.end,
                None => return Ok(None),
            }
        }
    }

    /// How long a master waits for the first octet of a reply, T_SL, by the customary table (`dp-v0.md` 1.1).
    pub const fn slot_time(&self) -> Duration {
        self.baud.bit_times(match self.baud {
            BaudRate::K9_6 | BaudRate::K19_2 | BaudRate::K45_45 | BaudRate::K93_75 | BaudRate::K187_5 => 100,
            BaudRate::K500 => 200,
            BaudRate::K1500 => 300,
            BaudRate::K3000 => 400,
            BaudRate::K6000 => 600,
            BaudRate::K12000 => 1000,
        })
    }

    /// Lets whoever sends come to an end.
    fn let_finish(&mut self) -> Result<(), Breach> {
        while let Some(speaking) = self.speaking {
            self.step(speaking.end)?;
        }
        Ok(())
    }

    /// Jumps from event to event until a sending has ended or `until` has come; whether a sending has ended.
    fn step(&mut self, until: Instant) -> Result<Option<()>, Breach> {
        loop {
            let end = self.speaking.map(|speaking| speaking.end);
            let deadline = self.buses.iter().filter_map(Bus::poll_timeout).min();
            // The end of what is said comes before what a station does at the same time: it has heard it.
            let next = Instant::first_of(end, deadline).map(|next| next.max(self.now));
            match next.filter(|next| *next <= until) {
                None => {
                    self.now = self.now.max(until);
                    return Ok(None);
                }
                Some(next) => self.now = next,
            }
            if let Some(speaking) = self.speaking.filter(|speaking| speaking.end <= self.now) {
                self.finish(speaking)?;
                return Ok(Some(()));
            }
            for number in 0..self.buses.len() {
                let due = self
                    .buses
                    .get_mut(number)
                    .filter(|bus| bus.poll_timeout().is_some_and(|deadline| deadline <= self.now));
                if let Some(bus) = due {
                    bus.handle_timeout(self.now);
                    self.drain(number)?;
                }
            }
        }
    }

    /// Lets a bus send what it has to send now.
    fn drain(&mut self, number: usize) -> Result<(), Breach> {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        while let Some(octets) =
            self.buses.get_mut(number).and_then(|bus| bus.poll_transmit(self.now, &mut buf))
        {
            self.begin(Some(number), octets)?;
        }
        Ok(())
    }

    /// Somebody begins to send now.
    fn begin(&mut self, bus: Option<usize>, octets: &[u8]) -> Result<(), Breach> {
        let at = self.now;
        if self.speaking.is_some() {
            return Err(Breach::Collision { at });
        }
        match bus {
            None => self.check_request(octets)?,
            Some(number) => self.check_reply(number, octets)?,
        }
        let len = u32::try_from(octets.len()).unwrap_or(u32::MAX);
        let end = at.saturating_add(self.baud.octet_times(len));
        self.octets.clear();
        self.octets.extend_from_slice(octets);
        let parity_error = match &mut self.disturbance {
            Some(disturbance) => disturbance(end, &mut self.octets).filter(|at| *at < self.octets.len()),
            None => None,
        };
        self.speaking = Some(Speaking { bus, end, parity_error });
        Ok(())
    }

    /// What a master sends: T_SYN before requests and tokens. Noise may come at any time.
    fn check_request(&self, octets: &[u8]) -> Result<(), Breach> {
        let is_request = match decode(octets) {
            Decoded::Telegram { telegram: Telegram::Data(data), .. } => {
                matches!(data.fc.function(), Function::Request(..))
            }
            Decoded::Telegram { telegram: Telegram::Token { .. }, .. } => true,
            Decoded::Telegram { telegram: Telegram::ShortAcknowledge, .. }
            | Decoded::Incomplete
            | Decoded::Invalid { .. } => false,
        };
        let (idle, expected) = (self.now.saturating_since(self.idle_since), self.baud.bit_times(SYN_BITS));
        // The line was silent before the simulation began.
        if is_request && idle < expected && self.idle_since > Instant::ZERO {
            return Err(Breach::NoSyn { at: self.now, idle, expected });
        }
        Ok(())
    }

    /// What a station sends: the reply to the last request, once, in time.
    fn check_reply(&mut self, number: usize, octets: &[u8]) -> Result<(), Breach> {
        let at = self.now;
        let rate = self.buses.get(number).map_or(self.baud, Bus::baud);
        if rate != self.baud {
            return Err(Breach::WrongRate { at, got: rate, expected: self.baud });
        }
        let telegram = match decode(octets) {
            Decoded::Telegram { telegram, len } if len == octets.len() => telegram,
            Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. } => {
                return Err(Breach::NoTelegram { at });
            }
        };
        let Some(asked) = self.asked.take() else {
            return Err(Breach::Unasked { at });
        };
        let after = at.saturating_since(asked.end);
        let (earliest, latest) = (
            self.baud.bit_times(DEFAULT_MIN_TSDR.into()),
            self.baud.bit_times(self.baud.max_tsdr_bits().into()),
        );
        if after < earliest {
            return Err(Breach::TooEarly { at, after, expected: earliest });
        }
        if after > latest {
            return Err(Breach::TooLate { at, after, expected: latest });
        }
        match telegram {
            // SC names nobody.
            Telegram::ShortAcknowledge => Ok(()),
            Telegram::Data(data)
                if data.sa == asked.station
                    && data.da == asked.master
                    && matches!(data.fc.function(), Function::Response(..)) =>
            {
                Ok(())
            }
            Telegram::Data(data) => Err(Breach::WrongStation { at, got: data.sa, expected: asked.station }),
            Telegram::Token { .. } => Err(Breach::Unasked { at }),
        }
    }

    /// A sending has ended: everybody else has heard it.
    fn finish(&mut self, speaking: Speaking) -> Result<(), Breach> {
        self.speaking = None;
        self.idle_since = speaking.end;
        if speaking.bus.is_none() {
            self.asked = self.asked(speaking);
        }
        for number in 0..self.buses.len() {
            if speaking.bus == Some(number) {
                continue;
            }
            if let Some(bus) = self.buses.get_mut(number) {
                hear(bus, self.baud, speaking, &self.octets);
            }
            self.drain(number)?;
        }
        Ok(())
    }

    /// Who must reply to what was heard: the last of several requests, octets behind it notwithstanding.
    fn asked(&self, speaking: Speaking) -> Option<Asked> {
        let whole = self.octets.get(..speaking.parity_error.unwrap_or(self.octets.len()))?;
        let (mut rest, mut asked) = (whole, None);
        while let Decoded::Telegram { telegram, len } = decode(rest) {
            asked = match telegram {
                Telegram::Data(data) => match data.fc.function() {
                    Function::Request(service, _) if service.wants_reply() && !data.da.is_broadcast() => {
                        Some(Asked { station: data.da, master: data.sa, end: speaking.end })
                    }
                    Function::Request(..) => None,
                    Function::Response(..) | Function::Reserved => asked,
                },
                Telegram::Token { .. } => None,
                Telegram::ShortAcknowledge => asked,
            };
            rest = rest.get(len..).unwrap_or_default();
        }
        asked
    }
}

/// Lets a bus hear octets that ended now.
fn hear(bus: &mut Bus, baud: BaudRate, speaking: Speaking, octets: &[u8]) {
    if bus.baud() != baud {
        // Bits of another length: no octet has its stop bit where it belongs.
        return bus.handle_damaged(speaking.end);
    }
    let damaged = speaking.parity_error.and_then(|at| Some((octets.get(..at)?, octets.get(at + 1..)?)));
    match damaged {
        None => bus.handle_bytes(speaking.end, octets),
        Some((before, behind)) => {
            // Backwards from the end: how long the octets behind last.
            let back = |octets: usize| {
                let time = baud.octet_times(u32::try_from(octets).unwrap_or(u32::MAX));
                Instant::from_nanos(speaking.end.as_nanos().saturating_sub(crate::time::nanos(time)))
            };
            bus.handle_bytes(back(behind.len() + 1), before);
            bus.handle_damaged(back(behind.len()));
            bus.handle_bytes(speaking.end, behind);
        }
    }
}
