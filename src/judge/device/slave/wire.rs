//! The line to the slave: octets out at a time, octets in until a time.

use core::time::Duration;
use std::io::ErrorKind;

use super::{Live, Setup};
use crate::bench;
use crate::host::{Clock, Link, Received, Stop};
use crate::judge::device::Ending;
use crate::judge::device::course::{Course, Halt};
use crate::judge::moment::{Moment, Side};
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, MAX_TELEGRAM_LEN};
use crate::time::{BaudRate, Instant, SYN_BITS};

/// How far the times of octets can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// To the bit time: virtual time.
    Exact,
    /// A real line, seen through an operating system.
    Measured,
    /// Octets arrive some time: a terminal, TCP.
    Untimed,
}

/// On a line without times, a pause before a request.
const PAUSE: Duration = Duration::from_millis(1);
/// Octets of one sending that are further apart are two, where no times are seen.
const GAP: Duration = Duration::from_millis(50);
/// A slave that sees no times has given up half a telegram after so long.
const FORGOTTEN: Duration = Duration::from_millis(60);
/// An operating system brings octets so much later than they were on the line.
const LATENCY: Duration = Duration::from_millis(30);
/// T_SL where there is none.
const UNTIMED_SLOT: Duration = Duration::from_millis(200);
/// A reply that comes late is waited for so many slot times.
const LATE: u32 = 4;
/// So many sendings that nobody asked for, one after the other, never end.
const MOST_UNASKED: u32 = 32;
/// The longest sending that is listened to.
const MOST: usize = 4 * MAX_TELEGRAM_LEN;

/// A line, and what passed on it.
pub(super) struct Wire {
    link: Box<dyn Link>,
    clock: Box<dyn Clock>,
    stop: Stop,
    /// The judgement ends then.
    end: Option<Instant>,
    pub(super) baud: BaudRate,
    pub(super) sight: Sight,
    slot: Duration,
    /// Somebody has said it: it is the same at every rate.
    slot_is_given: bool,
    /// When the last octet ended.
    idle_since: Instant,
    /// What passed since somebody took it.
    passed: Vec<Moment>,
    /// What was sent although nobody had asked for it.
    unasked: Vec<Moment>,
    /// The longest time until a reply.
    longest: Duration,
}

impl core::fmt::Debug for Wire {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Wire").field("baud", &self.baud).field("sight", &self.sight).finish_non_exhaustive()
    }
}

/// What came within the time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Heard {
    pub(super) octets: Vec<u8>,
    /// From the end of the request to the beginning of the reply.
    pub(super) after: Duration,
}

impl Wire {
    /// A line of the operating system.
    pub(super) fn live(line: Live, setup: &Setup) -> Self {
        let Live { link, clock, sight, rate: baud, stop } = line;
        let (slot, begun) = (setup.slot, clock.now());
        let customary = customary_slot(sight, baud);
        Self {
            link,
            clock,
            stop,
            end: setup.limit.map(|limit| begun.saturating_add(limit)),
            baud,
            sight,
            slot: slot.unwrap_or(customary),
            slot_is_given: slot.is_some(),
            idle_since: begun,
            passed: Vec::new(),
            unasked: Vec::new(),
            longest: Duration::ZERO,
        }
    }

    /// A line in virtual time.
    pub(super) fn simulated(port: &bench::Port, setup: &Setup, stop: Stop) -> Self {
        let (baud, slot) = port.line(|line| (line.baud(), line.slot_time()));
        let (link, clock) = (Box::new(port.clone()), Box::new(port.clone()));
        let line = Live { link, clock, sight: Sight::Exact, rate: baud, stop };
        let slot = Some(slot).filter(|slot| *slot != customary_slot(Sight::Exact, baud));
        Self::live(line, &Setup { slot, ..setup.clone() })
    }

    pub(super) fn now(&self) -> Instant {
        self.clock.now()
    }

    /// Why nothing more may be tried.
    pub(super) fn must_end(&self) -> Option<Ending> {
        if self.stop.is_requested() {
            return Some(Ending::Stopped);
        }
        self.end.filter(|end| self.now() >= *end).map(|_| Ending::TimeOver)
    }

    /// Sets the line to another rate, with its T_SL. `false`: the link has no rate, or not this one.
    pub(super) fn set_rate(&mut self, rate: BaudRate) -> Course<bool> {
        match self.link.set_rate(rate) {
            Ok(()) => {}
            Err(error) if matches!(error.kind(), ErrorKind::Unsupported | ErrorKind::InvalidInput) => {
                return Ok(false);
            }
            Err(error) => return Err(failed(error)),
        }
        if !self.slot_is_given {
            self.slot = customary_slot(self.sight, rate);
        }
        self.baud = rate;
        Ok(true)
    }

    /// T_SL.
    pub(super) const fn slot(&self) -> Duration {
        self.slot
    }

    pub(super) fn take_passed(&mut self) -> Vec<Moment> {
        core::mem::take(&mut self.passed)
    }

    /// The last so many sendings, which stay.
    pub(super) fn last_passed(&self, count: usize) -> Vec<Moment> {
        self.passed.get(self.passed.len().saturating_sub(count)..).unwrap_or_default().to_vec()
    }

    pub(super) fn take_unasked(&mut self) -> Vec<Moment> {
        core::mem::take(&mut self.unasked)
    }

    /// Sends these octets after a pause, as `side`.
    pub(super) fn send(&mut self, octets: &[u8], side: Side) -> Course<Instant> {
        let pause = match self.sight {
            Sight::Untimed => PAUSE,
            Sight::Exact | Sight::Measured => self.baud.bit_times(SYN_BITS),
        };
        self.pass(self.idle_since.saturating_add(pause))?;
        self.send_at_once(octets, side)
    }

    /// Sends these octets whatever is on the line.
    pub(super) fn send_at_once(&mut self, octets: &[u8], side: Side) -> Course<Instant> {
        let at = self.now();
        self.link.send(octets).map_err(failed)?;
        let end = match self.sight {
            Sight::Untimed => at,
            Sight::Exact | Sight::Measured => {
                let count = u32::try_from(octets.len()).unwrap_or(u32::MAX);
                at.saturating_add(self.baud.octet_times(count))
            }
        };
        self.passed.push(Moment { at, end, side, octets: octets.to_vec() });
        self.idle_since = end;
        // Elsewhere the reply may be there at once: when the sending ended is a guess.
        if self.sight == Sight::Exact {
            self.pass(end)?;
        }
        Ok(end)
    }

    /// Lets time pass; what is heard meanwhile nobody has asked for.
    pub(super) fn pass(&mut self, until: Instant) -> Course {
        let mut sendings = 0;
        while let Some(heard) = self.hear(until)? {
            self.unasked.push(heard);
            sendings += 1;
            if sendings > MOST_UNASKED {
                return Err(Halt::Over(Ending::Babbles { during: "" }));
            }
        }
        Ok(())
    }

    /// Lets so much time pass since the last octet that octets that are no telegram are forgotten.
    pub(super) fn recover(&mut self) -> Course {
        let time = match self.sight {
            Sight::Exact => self.baud.bit_times(2 * SYN_BITS),
            Sight::Measured => self.baud.bit_times(2 * SYN_BITS) + LATENCY,
            Sight::Untimed => FORGOTTEN,
        };
        self.pass(self.idle_since.saturating_add(time))
    }

    /// Waits until nobody has said anything for a while.
    pub(super) fn calm(&mut self) -> Course {
        let mut sendings = 0;
        while let Some(heard) = self.hear(self.now().saturating_add(self.slot * LATE))? {
            self.unasked.push(heard);
            sendings += 1;
            if sendings > MOST_UNASKED {
                return Err(Halt::Over(Ending::Babbles { during: "" }));
            }
        }
        Ok(())
    }

    /// What comes within the slot time, or late.
    pub(super) fn reply(&mut self) -> Course<Option<Heard>> {
        let end = self.idle_since;
        let octet = match self.sight {
            Sight::Untimed => Duration::ZERO,
            Sight::Exact | Sight::Measured => self.baud.octet_times(1),
        };
        let slot = end.saturating_add(self.slot + octet);
        let heard = match self.hear(slot)? {
            Some(heard) => Some(heard),
            None => self.hear(slot.saturating_add(self.slot * LATE))?,
        };
        Ok(heard.map(|heard| {
            let after = heard.at.saturating_since(end);
            self.longest = self.longest.max(after);
            Heard { octets: heard.octets, after }
        }))
    }

    /// Whether somebody answers what nobody may answer.
    pub(super) fn silence(&mut self) -> Course<Option<Vec<u8>>> {
        let time = match self.sight {
            Sight::Untimed => self.slot.min(Duration::from_millis(40).max(self.longest * 3)),
            Sight::Measured => self.slot,
            // A few octets may be seen at the end of the last one.
            Sight::Exact => self.slot * 2,
        };
        let until = self.idle_since.saturating_add(time);
        Ok(self.hear(until)?.map(|heard| heard.octets))
    }

    /// One sending of somebody else, if its first octet comes before `until`.
    fn hear(&mut self, until: Instant) -> Course<Option<Moment>> {
        let mut octets = Vec::new();
        let (mut at, mut last) = (Instant::ZERO, Instant::ZERO);
        loop {
            let now = self.now();
            let mut buf = [0; MAX_TELEGRAM_LEN];
            let count = match self.link.receive(&mut buf).map_err(failed)? {
                Received::Octets(count) | Received::BrokenOff(count) => count,
                Received::Reset | Received::Rate(_) | Received::Nothing => 0,
            };
            if count > 0 {
                let took = self.octet_times(count);
                if octets.is_empty() {
                    let begin = now.as_nanos().saturating_sub(u64::try_from(took.as_nanos()).unwrap_or(0));
                    at = Instant::from_nanos(begin).max(self.idle_since);
                }
                octets.extend(buf.get(..count).unwrap_or_default());
                last = now;
                let whole = matches!(decode(&octets), Decoded::Telegram { .. });
                if whole || octets.len() > MOST {
                    break;
                }
                continue;
            }
            let end = if octets.is_empty() { until } else { last.saturating_add(self.gap()) };
            if let Some(ending) = self.must_end() {
                return Err(Halt::Over(ending));
            }
            if now >= end {
                break;
            }
            self.link.wait(Some(end.saturating_since(now)), &self.stop).map_err(failed)?;
        }
        if octets.is_empty() {
            return Ok(None);
        }
        // Whole before its request can have been sent: nothing on this line lasts as long as it does on a wire.
        if self.sight == Sight::Measured && last < self.idle_since {
            self.sight = Sight::Untimed;
            self.slot = self.slot.max(UNTIMED_SLOT);
            at = last;
        }
        self.idle_since = self.now();
        let moment = Moment { at, end: last, side: Side::Station(self.sender(&octets)), octets };
        self.passed.push(moment.clone());
        Ok(Some(moment))
    }

    fn octet_times(&self, count: usize) -> Duration {
        match self.sight {
            Sight::Untimed => Duration::ZERO,
            Sight::Exact | Sight::Measured => self.baud.octet_times(u32::try_from(count).unwrap_or(u32::MAX)),
        }
    }

    /// Octets that are further apart are no longer of one telegram.
    fn gap(&self) -> Duration {
        match self.sight {
            // Up to eight octets come at once.
            Sight::Exact => self.baud.octet_times(9),
            Sight::Measured => self.baud.octet_times(3) + LATENCY,
            Sight::Untimed => GAP,
        }
    }

    fn sender(&self, octets: &[u8]) -> Option<Address> {
        let asked = self.passed.iter().rev().find_map(|moment| match moment.side {
            Side::Master | Side::Other(_) => Some(destination(&moment.octets)),
            Side::Station(_) => None,
        });
        destination_source(octets).or(asked.flatten())
    }
}

/// T_SL that nobody has said.
fn customary_slot(sight: Sight, baud: BaudRate) -> Duration {
    let bits = baud.bit_times(baud.slot_bits().into());
    match sight {
        Sight::Untimed => UNTIMED_SLOT,
        Sight::Exact => bits,
        Sight::Measured => bits + LATENCY,
    }
}

/// Whom a telegram is for.
fn destination(octets: &[u8]) -> Option<Address> {
    match decode(octets) {
        Decoded::Telegram { telegram: crate::profibus::fdl::Telegram::Data(data), .. } => Some(data.da),
        Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. } => None,
    }
}

/// Who says that he has sent it.
fn destination_source(octets: &[u8]) -> Option<Address> {
    match decode(octets) {
        Decoded::Telegram { telegram: crate::profibus::fdl::Telegram::Data(data), .. } => Some(data.sa),
        Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. } => None,
    }
}

fn failed(error: std::io::Error) -> Halt {
    Halt::Over(Ending::Broken { why: error.to_string() })
}
