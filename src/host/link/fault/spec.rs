//! Which fault, when, and of which station; and how a person writes it.

use core::fmt;
use core::str::FromStr;
use core::time::Duration;
use std::string::{String, ToString};
use std::vec::Vec;

use thiserror::Error;

use crate::gsd::did_you_mean;
use crate::host::occasions::{Occasions, Reading, Wrong, digits, duration, in_micros, misfit, number};
use crate::profibus::dp::{Service, State};
use crate::profibus::fdl::Address;

/// How a fault is written, see [`Fault`].
pub const FORM: &str = "FAULT[=VALUE][,rate=P][,count=N][,at=N][,seed=N][,station=ADDRESS]\
    [,service=NAME][,state=NAME][,retry=N]";

/// One fault and when it is injected.
///
/// Written as `FAULT[=VALUE]` and conditions, [`FORM`]:
///
/// | FAULT | counts | what the master gets |
/// | --- | --- | --- |
/// | `no-reply` | replies | nothing |
/// | `late=TIME` | replies | the reply so much later; other telegrams may come first |
/// | `duplicate` | replies | the reply twice |
/// | `truncated` | replies | the reply without some octets at its end |
/// | `bit-errors[=N]` | replies | the reply with N bits (1) the other way round |
/// | `wrong-fcs` | replies with FCS | a wrong frame check sequence |
/// | `wrong-length` | SD2 replies | LE and LEr one too high (249: one too low) |
/// | `wrong-source[=ADDRESS]` | replies with SA | the reply of another station (the next one), with a right FCS |
/// | `noise[=N]` | replies | N octets (4) of noise between request and reply |
/// | `drop-request` | requests | nothing: no station hears the request |
/// | `diag-storm` | Data_Exchange replies | a diagnosis announced (DH) each time |
/// | `not-ready=TIME` | Chk_Cfg requests | Station_Not_Ready, and RS to Data_Exchange, for so long |
/// | `refuse-prm` | Set_Prm requests | Prm_Fault: the slave sees another ident number |
/// | `refuse-cfg` | Chk_Cfg requests | Cfg_Fault: the slave sees another configuration |
/// | `lose-prm` | Data_Exchange requests | RS: the slave is released right before, and waits for Set_Prm |
/// | `reject` | SRD requests | RS: the station hears a request for a service that is closed |
/// | `function-code=HH` | replies | the reply with this FC octet, without data if it is one of a status; in place of SC, too |
/// | `short-ack` | replies | SC in place of the reply |
/// | `input-length=N` | Data_Exchange replies | N octets of inputs, cut off or filled with zeros |
/// | `wrong-destination[=ADDRESS]` | replies with DA | the reply to another master (the next address), with a right FCS |
/// | `no-saps` | replies with SAPs | the reply without its SAPs |
/// | `wrong-saps` | replies with SAPs | the reply from the next SAP |
/// | `broken-frame=PART` | SD2 replies | one part wrong: `length` (LE and LEr 3), `repeated` (LEr), `start` (second 68), `end` (ED) |
/// | `sd3` | replies with 8 octets and no SAPs | the reply as SD3 |
/// | `diag=OCTETS` | Slave_Diag replies | these first octets in hex, `..` for one that stays: `diag=..0D` |
/// | `diag-length=N` | Slave_Diag replies | N octets, cut off or filled with device-related blocks |
/// | `pkw-delay=N` | PKW answers | the answer N exchanges later |
/// | `pkw-wrong-ak` | PKW answers | 1 for 2, 4 for 5, 7 for 8 and the other way round; of others the lowest bit |
/// | `pkw-wrong-pnu` | PKW answers | the PNU with its lowest bit the other way round |
/// | `pkw-torn` | PKW answers | for one exchange, PKE and IND of the answer before with the PWE of this one |
///
/// A *reply* is any telegram a drive sends. A *PKW answer* is a change of PKE or IND in the inputs to a reply
/// identification other than 0; it is corrupted for as long as it stands, except `pkw-torn`. TIME is a whole number of
/// `us`, `ms` or `s`, at most an hour.
///
/// Of what a fault counts, it is injected from number `at` on (from 1, or 1 itself if `at` is given without `count` and
/// `rate`), with probability `rate` (1), at most `count` times (no limit), at `station` only (at all). The same `seed` (1)
/// injects the same faults.
///
/// `service` counts only requests of that service and the replies to them, `state` only what happens while the station
/// is in that state as its replies show it, `retry=N` only the Nth repetition of a request and the replies to it, 0 the
/// request itself. So `late=3ms,station=6,service=Chk_Cfg,retry=2` is late once the second retry of Chk_Cfg of station 6
/// was heard.
///
/// ```
/// use profidrive::host::link::fault::{Fault, Kind};
///
/// let fault: Fault = "late=20ms,at=100".parse()?;
/// assert_eq!(fault.kind, Kind::Late(core::time::Duration::from_millis(20)));
/// assert_eq!((fault.at, fault.count), (100, Some(1)));
/// # Ok::<(), profidrive::host::link::fault::SpecError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// What happens.
    pub kind: Kind,
    /// From which occasion on, counted from 1.
    pub at: u32,
    /// How often at most; `None`: without limit.
    pub count: Option<u32>,
    /// With which probability at each occasion, above 0 and at most 1.
    pub rate: f64,
    /// What the random choices of this fault begin with.
    pub seed: u64,
    /// At which station; `None`: at all.
    pub station: Option<Address>,
    /// At requests of which service and their replies; `None`: at all.
    pub service: Option<Service>,
    /// In which state of the station; `None`: in each.
    pub state: Option<State>,
    /// At which repetition of a request and its reply, 0 the request itself; `None`: at all.
    pub retry: Option<u32>,
}

impl Fault {
    /// This fault at every occasion.
    pub const fn always(kind: Kind) -> Self {
        let Occasions { at, count, rate, seed } = Occasions::ALWAYS;
        Self { kind, at, count, rate, seed, station: None, service: None, state: None, retry: None }
    }

    /// Whether the station that this fault is for is one of `stations`.
    ///
    /// # Errors
    /// [`NoStation`] if it is not: the fault would never act.
    pub fn check(&self, stations: impl IntoIterator<Item = Address>) -> Result<(), NoStation> {
        let Some(station) = self.station else {
            return Ok(());
        };
        let there: Vec<Address> = stations.into_iter().collect();
        if there.contains(&station) { Ok(()) } else { Err(NoStation { fault: *self, station, there }) }
    }

    /// This fault at one occasion, counted from 1.
    pub const fn once(kind: Kind, at: u32) -> Self {
        Self { at, count: Some(1), ..Self::always(kind) }
    }
}

/// A fault is for a station that is not on the line.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("fault '{fault}' is for station {station}, which is not on the line; expected {}", Stations(there))]
pub struct NoStation {
    /// The fault.
    pub fault: Fault,
    /// Its station.
    pub station: Address,
    /// The stations on the line.
    pub there: Vec<Address>,
}

/// `one of 5, 6`
struct Stations<'a>(&'a [Address]);

impl fmt::Display for Stations<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let addresses: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        match &addresses[..] {
            [] => f.write_str("no station condition: the line has no stations"),
            [only] => write!(f, "station {only}"),
            [..] => write!(f, "one of {}", addresses.join(", ")),
        }
    }
}

/// What can go wrong. [`Fault`] has the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the table of `Fault` describes them")]
pub enum Kind {
    NoReply,
    Late(Duration),
    Duplicate,
    Truncated,
    /// How many bits.
    BitErrors(u32),
    WrongFcs,
    WrongLength,
    /// Of which station; `None`: of the next one.
    WrongSource(Option<Address>),
    /// How many octets.
    Noise(u32),
    DropRequest,
    DiagStorm,
    NotReady(Duration),
    RefusePrm,
    RefuseCfg,
    LosePrm,
    Reject,
    /// The octet.
    FunctionCode(u8),
    ShortAck,
    /// How many octets.
    InputLength(u8),
    /// Which master; `None`: the next address.
    WrongDestination(Option<Address>),
    NoSaps,
    WrongSaps,
    BrokenFrame(FramePart),
    Sd3,
    Diagnosis(DiagOctets),
    /// How many octets.
    DiagLength(u8),
    Pkw(PkwFault),
}

/// Which part of an SD2 telegram is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the table of `Fault` describes them")]
pub enum FramePart {
    Length,
    Repeated,
    Start,
    End,
}

impl FramePart {
    const ALL: [(Self, &'static str); 4] =
        [(Self::Length, "length"), (Self::Repeated, "repeated"), (Self::Start, "start"), (Self::End, "end")];
}

/// The first octets of a diagnosis: `None` stays.
pub type DiagOctets = [Option<u8>; crate::profibus::dp::slave_diag::LEN];

/// What can go wrong with an answer of the parameter channel. [`Fault`] has the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the table of `Fault` describes them")]
pub enum PkwFault {
    /// By how many exchanges.
    Delay(u32),
    WrongAk,
    WrongPnu,
    Torn,
}

/// Every fault as it is written, with its form.
const KINDS: &str = "no-reply, late=TIME, duplicate, truncated, bit-errors[=N], wrong-fcs, wrong-length, wrong-source[=ADDRESS], \
    noise[=N], drop-request, diag-storm, not-ready=TIME, refuse-prm, refuse-cfg, lose-prm, reject, function-code=HH, \
    short-ack, input-length=N, wrong-destination[=ADDRESS], no-saps, wrong-saps, broken-frame=PART, sd3, diag=OCTETS, \
    diag-length=N, pkw-delay=N, pkw-wrong-ak, pkw-wrong-pnu or pkw-torn";

/// Every service and every state as it is written.
const SERVICES: &str = "Set_Slave_Add, RD_Inp, RD_Outp, Global_Control, Get_Cfg, Slave_Diag, Set_Prm, Chk_Cfg or \
    Data_Exchange";
const STATES: &str = "WAIT-PRM, WAIT-CFG or DATA-EXCH";

/// Bits and octets that can be asked for at most: those of a telegram.
const MOST: u32 = 255;

impl Kind {
    fn parse(text: &str) -> Result<Self, SpecError> {
        let (name, value) = match text.split_once('=') {
            Some((name, value)) => (name, Some(value)),
            None => (text, None),
        };
        let wrong =
            |expected| SpecError::Value { key: name.into(), expected, got: value.unwrap_or_default().into() };
        let plain = |kind| if value.is_none() { Ok(kind) } else { Err(wrong("no value")) };
        let time = || {
            value.and_then(duration).ok_or_else(|| wrong("a time such as 20ms, 500us or 1s, at most 3600s"))
        };
        let few = |default| {
            let number = value.map_or(Some(default), |value| number(value).filter(|number| *number <= MOST));
            number.ok_or_else(|| wrong("a number, 1 to 255"))
        };
        match name {
            "no-reply" => plain(Self::NoReply),
            "late" => time().map(Self::Late),
            "duplicate" => plain(Self::Duplicate),
            "truncated" => plain(Self::Truncated),
            "bit-errors" => few(1).map(Self::BitErrors),
            "wrong-fcs" => plain(Self::WrongFcs),
            "wrong-length" => plain(Self::WrongLength),
            "wrong-source" => match value {
                None => Ok(Self::WrongSource(None)),
                Some(value) => station(value)
                    .map(|station| Self::WrongSource(Some(station)))
                    .ok_or_else(|| wrong("an address, 0 to 126")),
            },
            "noise" => few(4).map(Self::Noise),
            "drop-request" => plain(Self::DropRequest),
            "diag-storm" => plain(Self::DiagStorm),
            "not-ready" => time().map(Self::NotReady),
            "refuse-prm" => plain(Self::RefusePrm),
            "refuse-cfg" => plain(Self::RefuseCfg),
            "lose-prm" => plain(Self::LosePrm),
            "reject" => plain(Self::Reject),
            "function-code" => value
                .and_then(hex_octet)
                .map(Self::FunctionCode)
                .ok_or_else(|| wrong("an octet in hex, 00 to FF")),
            "short-ack" => plain(Self::ShortAck),
            "input-length" => value
                .and_then(octets)
                .map(Self::InputLength)
                .ok_or_else(|| wrong("a number of octets, 0 to 244")),
            "wrong-destination" => match value {
                None => Ok(Self::WrongDestination(None)),
                Some(value) => station(value)
                    .map(|master| Self::WrongDestination(Some(master)))
                    .ok_or_else(|| wrong("an address, 0 to 126")),
            },
            "no-saps" => plain(Self::NoSaps),
            "wrong-saps" => plain(Self::WrongSaps),
            "broken-frame" => FramePart::ALL
                .into_iter()
                .find(|(_, name)| Some(*name) == value)
                .map(|(part, _)| Self::BrokenFrame(part))
                .ok_or_else(|| wrong("length, repeated, start or end")),
            "sd3" => plain(Self::Sd3),
            "diag" => value
                .and_then(diag_octets)
                .map(Self::Diagnosis)
                .ok_or_else(|| wrong("1 to 6 octets in hex, such as 020C or ..0D")),
            "diag-length" => value
                .and_then(octets)
                .map(Self::DiagLength)
                .ok_or_else(|| wrong("a number of octets, 0 to 244")),
            "pkw-delay" => value
                .and_then(number)
                .map(|exchanges| Self::Pkw(PkwFault::Delay(exchanges)))
                .ok_or_else(|| wrong("a number of exchanges, 1 or more")),
            "pkw-wrong-ak" => plain(Self::Pkw(PkwFault::WrongAk)),
            "pkw-wrong-pnu" => plain(Self::Pkw(PkwFault::WrongPnu)),
            "pkw-torn" => plain(Self::Pkw(PkwFault::Torn)),
            _ => Err(SpecError::Unknown { got: name.into() }),
        }
    }
}

impl FromStr for Fault {
    type Err = SpecError;

    fn from_str(spec: &str) -> Result<Self, SpecError> {
        let mut parts = spec.split(',');
        let kind = Kind::parse(parts.next().unwrap_or_default())?;
        let mut occasions = Reading::default();
        let (mut of, mut service, mut state, mut retry) = (None, None, None, None);
        for part in parts {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let wrong = |expected| SpecError::Value { key: key.into(), expected, got: value.into() };
            match occasions.take(key, value) {
                Some(Ok(())) => continue,
                Some(Err(Wrong::Value(expected))) => return Err(wrong(expected)),
                Some(Err(Wrong::Twice)) => return Err(SpecError::Twice { key: key.into() }),
                None => {}
            }
            let again = match key {
                "station" => {
                    of.replace(station(value).ok_or_else(|| wrong("an address, 0 to 126"))?).is_some()
                }
                "service" => {
                    let named =
                        Service::ALL.iter().copied().find(|one| one.name().eq_ignore_ascii_case(value));
                    service.replace(named.ok_or_else(|| wrong(SERVICES))?).is_some()
                }
                "state" => {
                    let named = State::ALL.into_iter().find(|one| one.name().eq_ignore_ascii_case(value));
                    state.replace(named.ok_or_else(|| wrong(STATES))?).is_some()
                }
                "retry" => {
                    let number = digits(value).and_then(|value| value.parse().ok());
                    retry
                        .replace(number.ok_or_else(|| wrong("a number, 0 for the request itself"))?)
                        .is_some()
                }
                _ => return Err(SpecError::UnknownKey { got: key.into() }),
            };
            if again {
                return Err(SpecError::Twice { key: key.into() });
            }
        }
        let Occasions { at, count, rate, seed } = occasions.occasions();
        Ok(Self { kind, at, count, rate, seed, station: of, service, state, retry })
    }
}

impl fmt::Display for Fault {
    /// As it is written, with everything that differs from "always".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, at, count, rate, seed, station, service, state, retry } = self;
        let (at, count, rate, seed) = (*at, *count, *rate, *seed);
        write!(f, "{kind}{}", Occasions { at, count, rate, seed })?;
        if let Some(station) = station {
            write!(f, ",station={station}")?;
        }
        if let Some(service) = service {
            write!(f, ",service={}", service.name())?;
        }
        if let Some(state) = state {
            write!(f, ",state={}", state.name())?;
        }
        match retry {
            Some(retry) => write!(f, ",retry={retry}"),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, value) = match *self {
            Self::NoReply => ("no-reply", None),
            Self::Late(time) => ("late", Some(in_micros(time))),
            Self::Duplicate => ("duplicate", None),
            Self::Truncated => ("truncated", None),
            Self::BitErrors(bits) => ("bit-errors", Some(bits.to_string())),
            Self::WrongFcs => ("wrong-fcs", None),
            Self::WrongLength => ("wrong-length", None),
            Self::WrongSource(of) => ("wrong-source", of.map(|station| station.to_string())),
            Self::Noise(octets) => ("noise", Some(octets.to_string())),
            Self::DropRequest => ("drop-request", None),
            Self::DiagStorm => ("diag-storm", None),
            Self::NotReady(time) => ("not-ready", Some(in_micros(time))),
            Self::RefusePrm => ("refuse-prm", None),
            Self::RefuseCfg => ("refuse-cfg", None),
            Self::LosePrm => ("lose-prm", None),
            Self::Reject => ("reject", None),
            Self::FunctionCode(octet) => ("function-code", Some(std::format!("{octet:02X}"))),
            Self::ShortAck => ("short-ack", None),
            Self::InputLength(octets) => ("input-length", Some(octets.to_string())),
            Self::WrongDestination(of) => ("wrong-destination", of.map(|master| master.to_string())),
            Self::NoSaps => ("no-saps", None),
            Self::WrongSaps => ("wrong-saps", None),
            Self::BrokenFrame(part) => {
                let name = FramePart::ALL.into_iter().find(|(one, _)| *one == part).map(|(_, name)| name);
                ("broken-frame", name.map(ToString::to_string))
            }
            Self::Sd3 => ("sd3", None),
            Self::Diagnosis(octets) => ("diag", Some(in_hex(octets))),
            Self::DiagLength(octets) => ("diag-length", Some(octets.to_string())),
            Self::Pkw(PkwFault::Delay(exchanges)) => ("pkw-delay", Some(exchanges.to_string())),
            Self::Pkw(PkwFault::WrongAk) => ("pkw-wrong-ak", None),
            Self::Pkw(PkwFault::WrongPnu) => ("pkw-wrong-pnu", None),
            Self::Pkw(PkwFault::Torn) => ("pkw-torn", None),
        };
        match value {
            Some(value) => write!(f, "{name}={value}"),
            None => f.write_str(name),
        }
    }
}

/// Why a text is no fault.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SpecError {
    /// There is no such fault.
    #[error("'{got}' is no fault; {}expected {KINDS}", near(got))]
    Unknown {
        /// The name found.
        got: String,
    },
    /// There is no such condition.
    #[error("'{got}' is unknown; expected {FORM}")]
    UnknownKey {
        /// The name found.
        got: String,
    },
    /// A value does not fit.
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
    #[error("'{key}' is given twice; expected {FORM}")]
    Twice {
        /// Which.
        key: String,
    },
}

/// `did you mean no-reply? ` if a fault is near to this name, else nothing.
fn near(name: &str) -> String {
    let names = KINDS.split(", ").flat_map(|kinds| kinds.split(" or "));
    let names = names.map(|kind| kind.split(['=', '[']).next().unwrap_or(kind));
    did_you_mean(name, names).map(|near| std::format!("did you mean {near}? ")).unwrap_or_default()
}

fn hex_octet(text: &str) -> Option<u8> {
    let hex = text.len() == 2 && text.bytes().all(|digit| digit.is_ascii_hexdigit());
    u8::from_str_radix(text, 16).ok().filter(|_| hex)
}

/// A number of octets that one telegram carries.
fn octets(text: &str) -> Option<u8> {
    digits(text)?
        .parse()
        .ok()
        .filter(|octets| usize::from(*octets) <= crate::profibus::fdl::station::MAX_USER_DATA)
}

fn diag_octets(text: &str) -> Option<DiagOctets> {
    let mut octets = DiagOctets::default();
    let mut places = octets.iter_mut();
    let mut rest = text;
    while !rest.is_empty() {
        let (octet, behind) = rest.split_at_checked(2)?;
        *places.next()? = if octet == ".." { None } else { Some(hex_octet(octet)?) };
        rest = behind;
    }
    octets.iter().any(Option::is_some).then_some(octets)
}

fn in_hex(octets: DiagOctets) -> String {
    let used = octets.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
    let octet = |octet: &Option<u8>| octet.map_or("..".into(), |octet| std::format!("{octet:02X}"));
    octets.iter().take(used).map(octet).collect()
}

fn station(text: &str) -> Option<Address> {
    digits(text)?.parse().ok().and_then(|number| Address::station(number).ok())
}

#[cfg(test)]
mod tests;
