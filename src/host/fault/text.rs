//! How a fault is read and written.

use core::fmt;
use core::str::FromStr;
use core::time::Duration;

use thiserror::Error;

use super::parameter::{Parameter as _, Time, decimal, digits, duration, in_micros, number, station};
use super::{BusKind, Id, Kind, NodeId, Row, Rule, Service, State, Way, When, While, Whom};
use crate::gsd::did_you_mean;

/// Why a text is no fault.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RuleError {
    /// There is no such fault on this bus.
    #[error("'{got}' is no fault{}; {}expected {}", if *bus == BusKind::Can { " of a node" } else { "" }, near(got, *bus), all(*bus))]
    Unknown {
        /// The name found.
        got: String,
        /// Where it was to act.
        bus: BusKind,
    },
    /// There is no such condition.
    #[error("'{got}' is unknown; expected {}", bus.form())]
    UnknownKey {
        /// The name found.
        got: String,
        /// Where the fault acts.
        bus: BusKind,
    },
    /// A value is missing, wrong, or one too many.
    #[error("{}; expected {expected}", misfit(key, got))]
    Value {
        /// Whose value.
        key: String,
        /// What fits.
        expected: &'static str,
        /// The value found.
        got: String,
    },
    /// A condition is given twice.
    #[error("'{key}' is given twice; expected {}", bus.form())]
    Twice {
        /// Which.
        key: String,
        /// Where the fault acts.
        bus: BusKind,
    },
    /// `id` is for faults of frames.
    #[error("id is only for faults of frames (frame-lost, ...); leave it out")]
    IdOfNode,
    /// It would never act.
    #[error("until must be later than from")]
    NoTime,
}

/// Every service and every state as it is written.
const SERVICES: &str = "Set_Slave_Add, RD_Inp, RD_Outp, Global_Control, Get_Cfg, Slave_Diag, Set_Prm, Chk_Cfg or \
    Data_Exchange";
const STATES: &str = "WAIT-PRM, WAIT-CFG or DATA-EXCH";

const AN_INPUT: &str = "an input of a station and its value, such as 7/1/0/bit0=1 or 7/2/0/unsigned16>1000";

impl FromStr for Rule {
    type Err = RuleError;

    /// A fault of either bus.
    fn from_str(text: &str) -> Result<Self, RuleError> {
        let name = text.split([',', '=']).next().unwrap_or_default();
        let row = Row::named(name);
        Self::on(row.map_or(BusKind::Profibus, |row| row.way.bus()), text)
    }
}

impl Rule {
    /// Reads a fault of this bus.
    ///
    /// # Errors
    /// [`RuleError`].
    pub(crate) fn on(bus: BusKind, text: &str) -> Result<Self, RuleError> {
        let mut parts = text.split(',');
        let first = parts.next().unwrap_or_default();
        let (name, value) = match first.split_once('=') {
            Some((name, value)) => (name, Some(value)),
            None => (first, None),
        };
        let row = Row::named(name).filter(|row| row.way.bus() == bus);
        let row = row.ok_or_else(|| RuleError::Unknown { got: name.into(), bus })?;
        let wrong = || RuleError::Value {
            key: name.into(),
            expected: row.expected,
            got: value.unwrap_or_default().into(),
        };
        let kind = (row.read)(value).ok_or_else(wrong)?;
        let mut conditions = Conditions::default();
        for part in parts {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            match conditions.take(bus, key, value) {
                Ok(false) => {}
                Ok(true) => return Err(RuleError::Twice { key: key.into(), bus }),
                Err(None) => return Err(RuleError::UnknownKey { got: part.into(), bus }),
                Err(Some(expected)) => {
                    return Err(RuleError::Value { key: key.into(), expected, got: value.into() });
                }
            }
        }
        conditions.of(kind)?.timed()
    }

    /// Whether there is a time in which it acts.
    ///
    /// # Errors
    /// [`RuleError::NoTime`] if there is none.
    pub(crate) fn timed(self) -> Result<Self, RuleError> {
        let ends = self.when.until.is_some_and(|until| until <= self.when.from);
        if ends { Err(RuleError::NoTime) } else { Ok(self) }
    }
}

/// Conditions while they are read, one after the other.
#[derive(Default)]
struct Conditions {
    rate: Option<f64>,
    count: Option<u32>,
    at: Option<u32>,
    seed: Option<u64>,
    from: Option<Duration>,
    until: Option<Duration>,
    while_input: Option<While>,
    whom: Whom,
}

impl Conditions {
    /// Takes a condition, and says whether it was there already.
    ///
    /// # Errors
    /// What its value must be; `None`: there is no such condition on this bus.
    fn take(&mut self, bus: BusKind, key: &str, value: &str) -> Result<bool, Option<&'static str>> {
        let positive = || number(value).ok_or(Some("a number, 1 or more"));
        let time = || duration(value).ok_or(Some(Time::EXPECTED));
        let whom = &mut self.whom;
        let again = match (bus, key) {
            (_, "rate") => {
                let rate = decimal(value).filter(|rate| *rate > 0.0 && *rate <= 1.0);
                self.rate.replace(rate.ok_or(Some("a probability above 0 and up to 1"))?).is_some()
            }
            (_, "count") => self.count.replace(positive()?).is_some(),
            (_, "at") => self.at.replace(positive()?).is_some(),
            (_, "seed") => self.seed.replace(whole(value).ok_or(Some("a number"))?).is_some(),
            (_, "from") => self.from.replace(time()?).is_some(),
            (_, "until") => self.until.replace(time()?).is_some(),
            // Either word of either bus.
            (_, "station" | "node") => whom.station.replace(address(bus, value)?).is_some(),
            (BusKind::Profibus, "while") => {
                self.while_input.replace(value.parse().map_err(|()| Some(AN_INPUT))?).is_some()
            }
            (BusKind::Profibus, "service") => {
                let named = Service::ALL.iter().find(|one| one.name().eq_ignore_ascii_case(value));
                whom.service.replace(*named.ok_or(Some(SERVICES))?).is_some()
            }
            (BusKind::Profibus, "state") => {
                let named = State::ALL.into_iter().find(|one| one.name().eq_ignore_ascii_case(value));
                whom.state.replace(named.ok_or(Some(STATES))?).is_some()
            }
            (BusKind::Profibus, "retry") => {
                whom.retry.replace(whole(value).ok_or(Some("a number, 0 for the request itself"))?).is_some()
            }
            (BusKind::Can, "id") => {
                let id = identifier(value).ok_or(Some("three hexadecimal digits, or eight with 29 bits"))?;
                whom.id.replace(id).is_some()
            }
            (BusKind::Profibus | BusKind::Can, _) => return Err(None),
        };
        Ok(again)
    }

    /// The fault with all of them.
    fn of(self, kind: Kind) -> Result<Rule, RuleError> {
        let Self { rate, count, at, seed, from, until, while_input, whom } = self;
        if whom.id.is_some() && kind.way() != Way::Frame {
            return Err(RuleError::IdOfNode);
        }
        // "At the hundredth" means that one; "at random from the hundredth on" does not.
        let once = at.is_some() && rate.is_none();
        let always = When::ALWAYS;
        let when = When {
            at: at.unwrap_or(always.at),
            count: count.or(once.then_some(1)),
            rate: rate.unwrap_or(always.rate),
            seed: seed.unwrap_or(always.seed),
            from: from.unwrap_or(always.from),
            until,
        };
        Ok(Rule { kind, when, while_input, whom })
    }
}

/// An address, or a node number.
fn address(bus: BusKind, text: &str) -> Result<u8, Option<&'static str>> {
    match bus {
        BusKind::Profibus => {
            station(text).map(|address| address.number()).ok_or(Some("an address, 0 to 126"))
        }
        BusKind::Can => {
            let node =
                digits(text).and_then(|text| text.parse().ok()).and_then(|number| NodeId::new(number).ok());
            node.map(|node| node.number()).ok_or(Some("a node number, 1 to 127"))
        }
    }
}

/// A number from 0 on.
fn whole<N: FromStr>(text: &str) -> Option<N> {
    digits(text)?.parse().ok()
}

fn identifier(text: &str) -> Option<Id> {
    if !text.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let number = u32::from_str_radix(text, 16).ok()?;
    match text.len() {
        3 => Id::base(u16::try_from(number).ok()?).ok(),
        8 => Id::extended(number).ok(),
        _ => None,
    }
}

impl fmt::Display for Rule {
    /// As it is written, with everything that differs from "always".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, when: When { at, count, rate, seed, from, until }, while_input, whom } = self;
        write!(f, "{kind}")?;
        if *rate < 1.0 {
            write!(f, ",rate={rate}")?;
        }
        // A lone `at` would mean that one only.
        let unlimited = (*at > 1 && *rate >= 1.0).then_some(u32::MAX);
        optional(f, "count", count.or(unlimited))?;
        optional(f, "at", Some(at).filter(|at| **at > When::ALWAYS.at))?;
        optional(f, "seed", Some(seed).filter(|seed| **seed != When::ALWAYS.seed))?;
        let [station, _] = self.bus().words();
        optional(f, station, whom.station)?;
        optional(f, "service", whom.service.map(Service::name))?;
        optional(f, "state", whom.state.map(State::name))?;
        optional(f, "retry", whom.retry)?;
        optional(f, "id", whom.id)?;
        optional(f, "from", Some(*from).filter(|from| !from.is_zero()).map(in_micros))?;
        optional(f, "until", until.map(in_micros))?;
        optional(f, "while", while_input.as_ref())
    }
}

fn optional(f: &mut fmt::Formatter<'_>, key: &str, value: Option<impl fmt::Display>) -> fmt::Result {
    value.map_or(Ok(()), |value| write!(f, ",{key}={value}"))
}

/// What is wrong with a value: it is missing, or another one is expected.
fn misfit(key: &str, got: &str) -> String {
    if got.is_empty() {
        std::format!("{key} has no value")
    } else {
        std::format!("'{got}' does not fit {key}")
    }
}

/// Every fault of a bus with its form: `no-reply, late=TIME or diag=OCTETS`.
fn all(bus: BusKind) -> String {
    let forms: Vec<String> = Row::of(bus).map(ToString::to_string).collect();
    match &forms[..] {
        [front @ .., last] if !front.is_empty() => std::format!("{} or {last}", front.join(", ")),
        [..] => forms.concat(),
    }
}

/// `did you mean no-reply? ` if a fault is near to this name, else nothing.
fn near(name: &str, bus: BusKind) -> String {
    let near = did_you_mean(name, Row::of(bus).map(|row| row.name));
    near.map(|near| std::format!("did you mean {near}? ")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lists_of_the_messages_name_everything() {
        assert!(Service::ALL.iter().all(|service| SERVICES.contains(service.name())));
        assert!(State::ALL.into_iter().all(|state| STATES.contains(state.name())));
    }
}
