//! Faults on purpose, to test masters: a wrapper around any link that corrupts telegrams.
//!
//! ```text
//! master ──octets──▶ link ──▶ Faulty: requests dropped or changed ──▶ drives
//!        ◀──────────      ◀── Faulty: replies lost, late, corrupted  ◀──
//! ```
//!
//! The drives are as they always are and know nothing of it. A refused Set_Prm is a Set_Prm that the wrapper changed on
//! its way, so that the slave refuses it by its own rules; a diagnosis is announced by a reply in which DH is set. What is injected
//! and when is a [`Rule`]; several act one after the other, in the order given. Everything is deterministic: the same
//! telegrams at the same times are corrupted in the same way.
//!
//! Without faults every octet passes untouched. With faults the octets of the master are collected until a telegram is
//! whole, or for 50 ms, and then pass as they are unless a fault says otherwise.
//!
//! ```
//! use profidrive::host::link::fault::Faulty;
//! use profidrive::host::link::memory::Wire;
//! use profidrive::host::{Link, ManualClock, Received};
//!
//! let wire = Wire::new();
//! let mut master = wire.end();
//! let mut drives = Faulty::new(wire.end(), ManualClock::new(), &["wrong-fcs,at=2".parse()?]);
//!
//! let mut buf = [0; 16];
//! for expected in [0x07, 0x08, 0x07] {
//!     drives.send(&[0x10, 0x02, 0x05, 0x00, 0x07, 0x16])?;
//!     assert_eq!(master.receive(&mut buf)?, Received::Octets(6));
//!     assert_eq!(buf[4], expected);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::map::Map;
use core::time::Duration;
use std::collections::VecDeque;
use std::io;

use super::pieces::{Piece, Pieces};
use crate::host::fault::{List, Listed, Rule, Switch};
use crate::host::{Clock, Link, Received, Stop, fault};
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, DataTelegram, Function, MAX_TELEGRAM_LEN, Telegram};
use crate::profibus::ppo::Pkw;
use crate::time::{BaudRate, Instant};

mod observed;
mod reply;
mod request;
mod shape;

use observed::{Observed, Occasion};
pub(crate) use reply::{PkwFault, ReplyFault};
pub(crate) use request::RequestFault;
pub(crate) use shape::ShapeFault;

/// Late telegrams kept at most; more are lost.
const MAX_LATE: usize = 256;

/// A link that corrupts telegrams.
#[derive(Debug)]
pub struct Faulty<L, C> {
    link: L,
    clock: C,
    faults: Faults,
    pieces: Pieces,
    /// What the drives hear next.
    heard: VecDeque<u8>,
    late: Vec<Late>,
}

/// Octets to be sent later.
#[derive(Debug)]
struct Late {
    due: Instant,
    octets: Vec<u8>,
}

impl<L: Link, C: Clock> Faulty<L, C> {
    /// Wraps `link`. `clock` is that of the drives.
    pub fn new(link: L, clock: C, faults: &[Rule]) -> Self {
        let mut list = Faults::default();
        for rule in faults {
            list.add(clock.now(), *rule);
        }
        Self {
            link,
            clock,
            faults: list,
            pieces: Pieces::default(),
            heard: VecDeque::new(),
            late: Vec::new(),
        }
    }

    /// How often each fault was injected, in the order given.
    pub fn injected(&self) -> impl Iterator<Item = (Rule, u32)> + '_ {
        self.faults.list.iter().map(|listed| (listed.rule, listed.injected))
    }

    /// The faults, to change them while the drives run.
    pub const fn faults_mut(&mut self) -> &mut Faults {
        &mut self.faults
    }

    /// Whether octets pass as they come: there is no fault, and nothing is left of one that was.
    fn is_transparent(&self) -> bool {
        self.faults.is_empty() && self.heard.is_empty() && self.pieces.len() == 0 && self.late.is_empty()
    }

    /// When to call [`Link::receive`] again although nothing arrived: something held back is due then, or a
    /// fault may act from then on or no longer.
    pub(crate) fn poll_timeout(&self) -> Option<Instant> {
        let own = [self.next_late(), self.pieces.poll_timeout(), self.faults.list.next_change()];
        own.into_iter().flatten().min()
    }

    /// Sends what was held back until now.
    fn send_late(&mut self, now: Instant) -> io::Result<()> {
        while let Some(next) = self.next_late().filter(|due| *due <= now) {
            let Some(index) = self.late.iter().position(|late| late.due == next) else {
                return Ok(());
            };
            let late = self.late.remove(index);
            self.link.send(&late.octets)?;
        }
        Ok(())
    }

    fn next_late(&self) -> Option<Instant> {
        self.late.iter().map(|late| late.due).min()
    }

    /// Hands whole telegrams to the drives, as far as the faults let them pass.
    fn sort(&mut self, now: Instant) {
        while let Some(piece) = self.pieces.pop(now) {
            let octets = match piece {
                Piece::Telegram(telegram) => self.faults.request(now, telegram),
                Piece::Noise(noise, _) => noise,
            };
            self.heard.extend(octets);
        }
    }

    /// Octets for the drives, 0 if there are none.
    fn take(&mut self, buf: &mut [u8]) -> usize {
        let count = buf.len().min(self.heard.len());
        for (to, octet) in buf.iter_mut().zip(self.heard.drain(..count)) {
            *to = octet;
        }
        count
    }
}

/// Faults without a link, in the order in which they act: telegrams and time in, what becomes of them out.
///
/// A [`Faulty`] link has them, and so has the simulated line of a bench.
#[derive(Debug, Default)]
pub struct Faults {
    list: List<Seen>,
    observed: Observed,
    /// Only requests of this master, and the replies to them.
    only: Option<Address>,
}

impl Faults {
    /// Each fault with its number and how often it was injected.
    pub fn iter(&self) -> impl Iterator<Item = (u32, Rule, u32)> + '_ {
        self.list.iter().map(|listed| (listed.number, listed.rule, listed.injected))
    }

    /// Each fault with what has become of it, as far as the line has come.
    pub(crate) fn listed(&self) -> impl Iterator<Item = Listed> + '_ {
        self.list.iter()
    }

    /// Adds a fault behind the others. Returns its number, by which it is removed.
    pub fn add(&mut self, now: Instant, rule: Rule) -> u32 {
        let open = rule.when.from.is_zero() && rule.while_input.is_none();
        let switch = Switch::default();
        self.list.add(now, rule, Seen { open, switch, stations: Map::new() })
    }

    /// What a fault waits for beside its occasions, and the switch to turn on while that holds
    /// ([`GsdStation::watch`](crate::host::GsdStation::watch)).
    pub(crate) fn watches(&self, number: u32) -> Option<(fault::While, Switch)> {
        let active = self.list.active.iter().find(|active| active.number == number)?;
        Some((active.rule.while_input?, active.seen.switch.clone()))
    }

    /// Ends a fault. `None`: there is none of this number.
    pub fn remove(&mut self, number: u32) -> Option<Rule> {
        self.list.remove(number)
    }

    /// Ends every fault.
    pub fn clear(&mut self) {
        self.list.clear();
    }

    /// From now on they act on the requests of this master only, and on the replies to them; `None`: of all.
    pub(crate) const fn only_of(&mut self, master: Option<Address>) {
        self.only = master;
    }

    /// Whether there is none.
    pub(crate) const fn is_empty(&self) -> bool {
        self.list.active.is_empty()
    }

    /// What the stations hear at `now` instead of a telegram of a master: nothing, another one, or several.
    pub(crate) fn request(&mut self, now: Instant, telegram: Vec<u8>) -> Vec<u8> {
        let Some(occasion) = self.observed.request(&telegram) else {
            return telegram;
        };
        if self.only.is_some() && self.only != occasion.master {
            return telegram;
        }
        self.list.active.iter_mut().fold(telegram, |octets, active| {
            active.seen.open = active.is_open(now);
            active.corrupt_request(octets, occasion, now)
        })
    }

    /// What the line hears instead of what a station sends.
    pub(crate) fn reply(&mut self, telegram: &[u8]) -> Outgoing {
        let occasion = self.observed.reply(telegram);
        let mut reply = Outgoing::new(telegram);
        if self.only.is_some() && self.only != occasion.master {
            return reply;
        }
        for active in &mut self.list.active {
            active.corrupt_reply(&mut reply, occasion);
        }
        reply
    }
}

impl<L: Link, C: Clock> Link for Faulty<L, C> {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        if self.is_transparent() {
            return self.link.receive(buf);
        }
        let now = self.clock.now();
        self.faults.list.look(now, Active::holds);
        self.send_late(now)?;
        loop {
            let count = self.take(buf);
            if count > 0 {
                return Ok(Received::Octets(count));
            }
            let received = self.link.receive(buf)?;
            match received {
                Received::Octets(count) => self.pieces.push(now, buf.get(..count).unwrap_or_default()),
                Received::Reset => {
                    self.pieces.clear();
                    self.late.clear();
                    return Ok(received);
                }
                // There is no telegram in them to corrupt.
                Received::BrokenOff(_) | Received::Rate(_) => return Ok(received),
                Received::Nothing => {}
            }
            self.sort(now);
            if received == Received::Nothing && self.heard.is_empty() {
                return Ok(received);
            }
        }
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        if self.is_transparent() {
            return self.link.send(telegram);
        }
        let now = self.clock.now();
        let reply = self.faults.reply(telegram);
        for octets in reply.telegrams() {
            if reply.delay.is_zero() {
                self.link.send(octets)?;
            } else if self.late.len() < MAX_LATE {
                self.late.push(Late { due: now.saturating_add(reply.delay), octets: octets.to_vec() });
            }
        }
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        if !self.heard.is_empty() {
            return Ok(());
        }
        let now = self.clock.now();
        let own = self.poll_timeout().map(|due| due.saturating_since(now));
        let timeout = own.into_iter().chain(timeout).min();
        self.link.wait(timeout, stop)
    }

    fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
        self.link.set_rate(rate)
    }

    fn resolution(&self) -> Duration {
        self.link.resolution()
    }
}

/// A reply on its way to the master, after the faults.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Outgoing {
    octets: Vec<u8>,
    /// Noise in front of it.
    noise: Vec<u8>,
    /// How often it is sent.
    copies: usize,
    delay: Duration,
}

impl Outgoing {
    fn new(telegram: &[u8]) -> Self {
        Self { octets: telegram.to_vec(), noise: Vec::new(), copies: 1, delay: Duration::ZERO }
    }

    /// Whether anything is not as the station sent it.
    pub(crate) fn is_changed(&self, telegram: &[u8]) -> bool {
        *self != Self::new(telegram)
    }

    /// How much later than the station meant.
    pub(crate) const fn delay(&self) -> Duration {
        self.delay
    }

    /// What is sent, in this order.
    pub(crate) fn telegrams(&self) -> impl Iterator<Item = &[u8]> {
        let copies = core::iter::repeat_n(&self.octets[..], self.copies);
        core::iter::once(&self.noise[..]).chain(copies).filter(|octets| !octets.is_empty())
    }
}

/// A fault of a line.
type Active = fault::Active<Seen>;

/// What a fault has seen.
#[derive(Debug)]
struct Seen {
    /// Whether its times and its condition allowed it at the last request: that holds for the reply, too. A reply that
    /// nobody asked for comes before any request.
    open: bool,
    /// Turned on by the station whose input the fault waits for.
    switch: Switch,
    stations: Map<u8, Station>,
}

/// What a fault remembers of a station.
#[derive(Clone, Debug, Default)]
struct Station {
    /// The Chk_Cfg that the station has not heard yet: it is not ready.
    not_ready: Option<HeldCfg>,
    /// The PKW words the station has sent last.
    sent: Pkw,
    /// Those the master has got last.
    shown: Pkw,
    /// That answer is corrupted.
    corrupted: bool,
    /// In how many exchanges that answer was sent.
    exchanges: u32,
}

/// A Chk_Cfg that is kept from its station.
#[derive(Clone, Debug)]
struct HeldCfg {
    /// Whose it is.
    master: Address,
    /// The station may hear it then.
    until: Instant,
    octets: Vec<u8>,
}

impl Active {
    /// Whether it may act now.
    fn is_open(&mut self, now: Instant) -> bool {
        let holds = self.holds();
        self.may_act(now, holds)
    }

    /// Whether what it waits for is there.
    fn holds(&self) -> bool {
        self.rule.while_input.is_none() || self.seen.switch.is_on()
    }

    /// Whether it is for this station, service, state and repetition.
    fn concerns(&self, occasion: Occasion) -> bool {
        let fault::Whom { station, service, state, retry, .. } = self.rule.whom;
        (station.is_none() || station == occasion.station.map(Address::number))
            && (service.is_none() || service == occasion.service)
            && state.is_none_or(|state| state == occasion.state)
            && retry.is_none_or(|retry| retry == occasion.retry)
    }

    /// Counts an occasion while it may act and says whether the fault is injected now.
    fn is_due(&mut self) -> bool {
        self.seen.open && self.strikes()
    }
}

/// The telegram with a function code that these octets are.
fn data_telegram(octets: &[u8]) -> Option<DataTelegram<'_>> {
    match decode(octets) {
        Decoded::Telegram { telegram: Telegram::Data(telegram), len } if len == octets.len() => {
            Some(telegram)
        }
        Decoded::Telegram { .. } | Decoded::Invalid { .. } | Decoded::Incomplete => None,
    }
}

fn is_request(telegram: &DataTelegram<'_>) -> bool {
    matches!(telegram.fc.function(), Function::Request(..))
}

/// The octets of a telegram; empty if it cannot be, which no change here brings about.
fn encoded(telegram: &DataTelegram<'_>) -> Vec<u8> {
    let mut buf = [0; MAX_TELEGRAM_LEN];
    telegram.encode(&mut buf).map(<[u8]>::to_vec).unwrap_or_default()
}
