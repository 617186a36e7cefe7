//! What is odd on a line: said once, as a hint. A hint hides no event and changes nothing.
//!
//! | file | holds |
//! | --- | --- |
//! | here | [`LineHint`]: what is odd, in words; who is asked, and by whom |
//! | `addresses` | [`Addresses`]: a set of them |
//! | `start_up` | what leads to no data exchange, or nowhere |
//! | `owned` | whose the stations are, and what Global_Control holds in them |

mod addresses;
mod owned;
mod start_up;

use core::fmt;
use core::time::Duration;

pub use self::addresses::Addresses;
pub(super) use self::owned::Owned;
use self::start_up::StartUp;
use crate::face::hint::is_due;
use crate::host::bus::Presence;
use crate::host::ranges::Ranges;
use crate::profibus::dp::{self, ControlBit, PrmBit};
use crate::profibus::fdl::foreign::Foreign;
use crate::profibus::fdl::{Address, DataTelegram, Function, Sap, Service, Telegram};
use crate::time::{BaudRate, Instant};

/// So many runs of octets that are no telegram, and no telegram between them, are noise.
const NOISE: u32 = 20;

/// While the rate is searched for, so many.
const NOISE_OF_SEARCH: u32 = 200;

/// Octets of noise that are looked at.
const OVERHEARD: usize = 512;

/// So many requests to service access points that DP does not have, and none that it has, are another protocol.
const NOT_DP: u8 = 20;

/// So many times the same request is no retry: masters repeat one 15 times at most.
const NO_RETRY: u8 = 30;

/// So many requests in vain to one address are no look-around.
const IN_VAIN: u8 = 3;

/// So many addresses are followed at a time; a master that asks more of them looks around.
const FOLLOWED: usize = 4;

/// Two masters that were both heard in this time are on the line at the same time.
const TOGETHER: Duration = Duration::from_secs(1);

/// Something odd about a line. `Display` is one line of plain English: what, where, and what to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LineHint {
    /// Many octets, and no telegram among them.
    OnlyNoise {
        /// The rate listened at; `None`: every rate was tried.
        rate: Option<BaudRate>,
        /// What it is, if it is known.
        foreign: Option<Foreign>,
    },
    /// Masters speak FDL, and none of them DP.
    NotDp {
        /// One of them.
        master: Address,
        /// A service access point that it asks.
        sap: Sap,
    },
    /// A master asks an address where nobody is.
    NobodyThere {
        /// The master.
        master: Address,
        /// Whom it asks.
        asked: Address,
        /// Who is there.
        there: Addresses,
    },
    /// A master has the address of a station of ours.
    MasterAtStation {
        /// The address.
        address: Address,
    },
    /// Another master is on the line.
    SecondMaster {
        /// Who was heard first.
        first: Address,
        /// Who came.
        second: Address,
    },
    /// A master reads the diagnosis of a station again and again, and asks nothing else.
    OnlyDiagnosis {
        /// The master.
        master: Address,
        /// Whose diagnosis.
        station: Address,
    },
    /// A Set_Prm has Lock_Req and Unlock_Req.
    LockAndUnlock {
        /// Who sent it.
        master: Address,
        /// To whom.
        station: Address,
    },
    /// A Global_Control is for groups in which no station is.
    NoSuchGroup {
        /// Who sent it.
        master: Address,
        /// Group_Select: one bit for each group.
        groups: u8,
    },
    /// A Global_Control of a wrong length: no slave takes it.
    ControlLength {
        /// Who sent it.
        master: Address,
        /// Octets found.
        got: usize,
    },
    /// A Global_Control with reserved bits: a slave need not take it.
    ControlReserved {
        /// Who sent it.
        master: Address,
        /// Control_Command.
        command: u8,
    },
    /// A token for a slave.
    TokenToSlave {
        /// Who passed it.
        master: Address,
        /// To whom.
        station: Address,
    },
    /// A Global_Control of a master that has parameterised no station.
    ControlOfOther {
        /// Who sent it.
        master: Address,
    },
    /// Sync or Freeze holds for a long time, and the master goes on with Data_Exchange.
    Held {
        /// The owner.
        master: Address,
        /// Of which station.
        station: Address,
        /// Sync or Freeze.
        bit: ControlBit,
        /// For so long.
        time: Duration,
    },
    /// A master sends a station the same request with the same frame count bit, far more often than a retry.
    SameFrameCount {
        /// The master.
        master: Address,
        /// Whom it asks.
        station: Address,
    },
    /// A request that wants an answer is for all stations.
    ToAll {
        /// Who sends it.
        master: Address,
        /// Which service of DP it asks.
        service: Option<dp::Service>,
    },
    /// A station is asked with a service of layer 2 that DP does not use.
    NotOfDp {
        /// Who asks.
        master: Address,
        /// Whom.
        station: Address,
        /// With which service.
        service: Service,
    },
}

impl LineHint {
    /// The station it is about; `None`: the line.
    pub(crate) const fn station(&self) -> Option<Address> {
        match self {
            Self::MasterAtStation { address: station }
            | Self::OnlyDiagnosis { station, .. }
            | Self::LockAndUnlock { station, .. }
            | Self::TokenToSlave { station, .. }
            | Self::Held { station, .. }
            | Self::SameFrameCount { station, .. }
            | Self::NotOfDp { station, .. } => Some(*station),
            Self::OnlyNoise { .. }
            | Self::NotDp { .. }
            | Self::NobodyThere { .. }
            | Self::SecondMaster { .. }
            | Self::NoSuchGroup { .. }
            | Self::ControlLength { .. }
            | Self::ControlReserved { .. }
            | Self::ControlOfOther { .. }
            | Self::ToAll { .. } => None,
        }
    }
}

/// What was heard on the line, and what was said of it. Where nothing is odd, each look costs a comparison.
#[derive(Debug)]
pub(super) struct Watch {
    /// Refused octets since the last telegram.
    noise: u32,
    noise_said: Option<Instant>,
    /// The newest of these octets.
    overheard: Vec<u8>,
    /// Requests of masters that are none of DP, since one was.
    not_dp: u8,
    not_dp_said: Option<Instant>,
    /// Who has replied.
    heard: Addresses,
    /// The addresses that were asked in vain last, and how often.
    in_vain: [Option<(Address, u8)>; FOLLOWED],
    /// Whose place the next one takes.
    next: usize,
    /// The addresses for which that was said, and when the last time.
    missed: (Addresses, Option<Instant>),
    /// The master heard last, and when.
    master: Option<(Address, Instant)>,
    second_said: Option<Instant>,
    same_address_said: Option<Instant>,
    /// A token was heard: FDL_Status may be the look-around of the GAP.
    has_token: bool,
    /// Who passes the token to others, and who gets it.
    ring: Addresses,
    token_said: Option<Instant>,
    service_said: Option<Instant>,
    again_said: Option<Instant>,
    start_up: StartUp,
}

impl Watch {
    pub(super) const fn new() -> Self {
        Self {
            noise: 0,
            noise_said: None,
            overheard: Vec::new(),
            not_dp: 0,
            not_dp_said: None,
            heard: Addresses::NONE,
            in_vain: [None; FOLLOWED],
            next: 0,
            missed: (Addresses::NONE, None),
            master: None,
            second_said: None,
            same_address_said: None,
            has_token: false,
            ring: Addresses::NONE,
            token_said: None,
            service_said: None,
            again_said: None,
            start_up: StartUp::new(),
        }
    }

    /// Octets that are no telegram. `rate`: while it is searched for `None`.
    pub(super) fn refused(&mut self, now: Instant, rate: Option<BaudRate>) -> Option<LineHint> {
        self.noise = self.noise.saturating_add(1);
        let many = if rate.is_some() { NOISE } else { NOISE_OF_SEARCH };
        if self.noise < many {
            return None;
        }
        // Counts again, so that it is said again while it goes on.
        self.noise = 1;
        let hint = is_due(&mut self.noise_said, now)
            .then(|| LineHint::OnlyNoise { rate, foreign: Foreign::in_noise(&self.overheard) });
        self.overheard.clear();
        hint
    }

    /// A request to a station of ours came for the `times`th time without another one between.
    #[cold]
    pub(super) fn asked_again(
        &mut self,
        now: Instant,
        request: &DataTelegram<'_>,
        times: u8,
    ) -> Option<LineHint> {
        let is_told = times >= NO_RETRY && is_due(&mut self.again_said, now);
        is_told.then_some(LineHint::SameFrameCount { master: request.sa, station: request.da })
    }

    /// Whether the octets before were no telegram: [`overhear`](Self::overhear) wants the next ones.
    #[inline]
    pub(super) const fn hears_noise(&self) -> bool {
        self.noise > 0
    }

    /// Octets behind others that were no telegram.
    #[cold]
    pub(super) fn overhear(&mut self, octets: &[u8]) {
        let room = OVERHEARD.saturating_sub(self.overheard.len());
        self.overheard.extend(octets.iter().take(room));
    }

    /// A telegram. `presence`: of a station of ours; `there`: all of them.
    #[inline]
    pub(super) fn heard(
        &mut self,
        now: Instant,
        telegram: &Telegram<'_>,
        presence: impl Fn(Address) -> Option<Presence>,
        there: impl FnOnce() -> Addresses,
        owned: &mut Owned,
    ) -> Option<LineHint> {
        let is_there = |address| presence(address).is_some();
        self.noise = 0;
        let data = match telegram {
            Telegram::Data(data) => data,
            Telegram::Token { da, sa } => {
                self.has_token = true;
                if da != sa && !da.is_broadcast() && !sa.is_broadcast() {
                    self.ring.add(*da);
                    self.ring.add(*sa);
                }
                // Whose address a station has that is not active yet may be a master.
                let to_slave = presence(*da) == Some(Presence::Active) && is_due(&mut self.token_said, now);
                return to_slave.then_some(LineHint::TokenToSlave { master: *sa, station: *da });
            }
            Telegram::ShortAcknowledge => return None,
        };
        let (service, asks) = match data.fc.function() {
            // Who passes no token does not look around.
            Function::Request(service @ Service::FdlStatus, _) => (service, !self.has_token),
            Function::Request(service, _) => (service, is_for_data(service)),
            Function::Response(..) | Function::Reserved => {
                self.heard.add(data.sa);
                return None;
            }
        };
        match &mut self.master {
            Some((master, at)) if *master == data.sa => *at = now,
            Some(_) | None => {
                if is_there(data.sa) && is_due(&mut self.same_address_said, now) {
                    self.master = Some((data.sa, now));
                    return Some(LineHint::MasterAtStation { address: data.sa });
                }
                if let Some(hint) = self.another_master(now, data.sa) {
                    return Some(hint);
                }
            }
        }
        if data.da.is_broadcast() || is_there(data.da) {
            if data.da.is_broadcast() && matches!(service, Service::SrdLow | Service::SrdHigh) {
                let what = dp::Service::of(data.dsap, data.ssap);
                let hint = LineHint::ToAll { master: data.sa, service: what };
                return is_due(&mut self.service_said, now).then_some(hint);
            }
            if !is_of_dp(service, data) && is_due(&mut self.service_said, now) {
                return Some(LineHint::NotOfDp { master: data.sa, station: data.da, service });
            }
            let alone = self.heard == Addresses::NONE;
            self.not_dp = 0;
            self.start_up.asked(now, data, alone, owned)
        } else if asks && data.dsap.is_some_and(|sap| !(50..=63).contains(&sap.number())) {
            self.not_of_dp(now, data)
        } else if asks {
            self.not_dp = 0;
            self.asked_in_vain(now, data, there)
        } else {
            None
        }
    }

    /// A request to others at a service access point that DP does not have: whether all of them are so.
    fn not_of_dp(&mut self, now: Instant, request: &DataTelegram<'_>) -> Option<LineHint> {
        self.not_dp = self.not_dp.saturating_add(1);
        let hint = LineHint::NotDp { master: request.sa, sap: request.dsap? };
        (self.not_dp >= NOT_DP && is_due(&mut self.not_dp_said, now)).then_some(hint)
    }

    fn another_master(&mut self, now: Instant, second: Address) -> Option<LineHint> {
        let before = self.master.replace((second, now));
        let (first, at) = before?;
        // Masters that pass the token to each other are meant to be there.
        let is_ring = self.ring.contains(first) && self.ring.contains(second);
        let together = now.saturating_since(at) < TOGETHER && !is_ring;
        (together && is_due(&mut self.second_said, now)).then_some(LineHint::SecondMaster { first, second })
    }

    fn asked_in_vain(
        &mut self,
        now: Instant,
        request: &DataTelegram<'_>,
        there: impl FnOnce() -> Addresses,
    ) -> Option<LineHint> {
        let (asked, master) = (request.da, request.sa);
        // A broadcast is for nobody in particular, and others may be on the line.
        if asked.is_broadcast() || self.heard.contains(asked) {
            return None;
        }
        if self.times_asked(asked) < IN_VAIN {
            return None;
        }
        let (said, at) = &mut self.missed;
        if is_due(at, now) {
            *said = Addresses::NONE;
        } else if said.contains(asked) {
            return None;
        }
        said.add(asked);
        Some(LineHint::NobodyThere { master, asked, there: there() })
    }
}

impl Watch {
    /// How often this address was asked, this time included, since it is followed.
    fn times_asked(&mut self, asked: Address) -> u8 {
        let known = self.in_vain.iter_mut().flatten().find(|(address, _)| *address == asked);
        if let Some((_, times)) = known {
            *times = times.saturating_add(1);
            return *times;
        }
        if let Some(place) = self.in_vain.get_mut(self.next) {
            *place = Some((asked, 1));
        }
        self.next = (self.next + 1) % FOLLOWED;
        1
    }
}

/// Whether a request carries or wants data; a master looks for others with FDL_Status.
const fn is_for_data(service: Service) -> bool {
    match service {
        Service::SrdLow | Service::SrdHigh | Service::SdaLow | Service::SdaHigh => true,
        Service::TimeEvent
        | Service::SdnLow
        | Service::SdnHigh
        | Service::Msrd
        | Service::FdlStatus
        | Service::Ident
        | Service::LsapStatus => false,
    }
}

/// Whether masters of DP ask a slave so. What looks for stations asks for FDL_Status.
const fn is_of_dp(service: Service, request: &DataTelegram<'_>) -> bool {
    match service {
        Service::SrdLow | Service::SrdHigh | Service::FdlStatus => true,
        Service::SdnLow | Service::SdnHigh | Service::TimeEvent => {
            request.da.is_broadcast() || request.dsap.is_some()
        }
        Service::SdaLow | Service::SdaHigh | Service::Msrd | Service::Ident | Service::LsapStatus => false,
    }
}

impl fmt::Display for LineHint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OnlyNoise { rate, foreign } => {
                f.write_str("hint: only octets that are no telegram are heard")?;
                match rate {
                    Some(rate) => write!(f, " at {rate}")?,
                    None => f.write_str(", the rate is not found")?,
                }
                match foreign {
                    Some(foreign) => write!(f, ": {foreign}; {}", foreign.cure()),
                    None => f.write_str(
                        "; set the rate of the master, and check whether A and B are exchanged and the line is terminated at \
                         both ends",
                    ),
                }
            }
            &Self::NotDp { master, sap } => {
                let foreign = Foreign::NotDp { master, sap };
                write!(f, "hint: {foreign}; {}", foreign.cure())
            }
            Self::NobodyThere { master, asked, there: Addresses(0) } => {
                write!(f, "hint: master {master} asks for station {asked}, and no station is on the line")
            }
            Self::NobodyThere { master, asked, there } => write!(
                f,
                "hint: master {master} asks for station {asked}, which is not on the line; on the line: {there}; change the \
                 address in the master's project or that of the station"
            ),
            Self::MasterAtStation { address } => write!(
                f,
                "hint: a master has address {address}, which is that of a station on the line; give one of the two another \
                 address"
            ),
            Self::SecondMaster { first, second } => write!(
                f,
                "hint: master {second} is on the line with master {first}; only the master that locked a slave controls \
                 it"
            ),
            Self::OnlyDiagnosis { master, station } => {
                write!(
                    f,
                    "hint: master {master} only reads the diagnosis of station {station}; for data exchange send "
                )?;
                let steps = [dp::Service::SetPrm, dp::Service::ChkCfg];
                steps
                    .into_iter()
                    .filter_map(|step| Some((step.name(), step.sap()?.number())))
                    .try_for_each(|(name, sap)| write!(f, "{name} (SAP {sap}), "))?;
                write!(f, "then {}", dp::Service::DataExchange.name())
            }
            Self::LockAndUnlock { master, station } => {
                let (lock, unlock) = (PrmBit::LockReq, PrmBit::UnlockReq);
                write!(
                    f,
                    "hint: Set_Prm of master {master} to station {station} has {} and {} (octet 1 bits {} and {}): {1} counts, \
                     the slave takes no parameters; clear {1}",
                    lock.name(),
                    unlock.name(),
                    lock.number(),
                    unlock.number()
                )
            }
            Self::NoSuchGroup { master, groups } => write!(
                f,
                "hint: Global_Control of master {master} is for group {}, in which no station of the line is: Group_Ident \
                 (Set_Prm octet 7) of none has it; put the slaves into the group in the master's project",
                Ranges(u128::from(*groups) << 1)
            ),
            Self::ControlLength { master, got } => write!(
                f,
                "hint: Global_Control of master {master} has {got} octets, expected 2 (Control_Command, Group_Select); the \
                 slaves ignore it"
            ),
            Self::ControlReserved { master, command } => write!(
                f,
                "hint: Global_Control of master {master} has Control_Command {command:02X} with reserved bits, expected 0 in \
                 bits 0, 6 and 7; the slaves ignore it"
            ),
            Self::TokenToSlave { master, station } => write!(
                f,
                "hint: master {master} passes the token to station {station}, which is a slave and takes none; a master \
                 passes it to masters only, which answer FDL_Status as such"
            ),
            Self::ControlOfOther { master } => write!(
                f,
                "hint: Global_Control of master {master} has no effect: it has parameterised no station of the line, and each \
                 obeys the master that did; send it by that one"
            ),
            Self::Held { master, station, bit, time } => {
                let (what, then, undo) = if *bit == ControlBit::Freeze {
                    ("inputs", "the master sees old inputs", ControlBit::Unfreeze)
                } else {
                    ("outputs", "new control words and setpoints do not reach the device", ControlBit::Unsync)
                };
                write!(
                    f,
                    "hint: {} of master {master} holds the {what} of station {station} for {time:?} now: {then}; next: \
                     Global_Control with {} again, or with {}",
                    bit.name(),
                    bit.name(),
                    undo.name()
                )
            }
            Self::SameFrameCount { master, station } => write!(
                f,
                "hint: master {master} has sent station {station} the same request {NO_RETRY} times with the same frame count bit \
                 (FCB, octet FC bit 5): the station takes that for a retry and sends its old reply, so inputs do not change; \
                 change the bit with each new request"
            ),
            Self::ToAll { master, service } => write!(
                f,
                "hint: master {master} sends {} to address 127, all stations, from which nobody answers; send it to each station \
                 by its own address",
                service.map_or("a request that wants an answer", dp::Service::name)
            ),
            Self::NotOfDp { master, station, service } => write!(
                f,
                "hint: master {master} sends station {station} a request that DP does not use ({}; octet FC, code {:X}); send \
                 requests with SRD (codes C and D), and Global_Control with SDN (codes 4 and 6)",
                service.name(),
                *service as u8
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_listed_in_ranges() {
        let listed = |numbers: &[u8]| {
            let addresses = numbers.iter().map(|number| Address::station(*number).unwrap());
            Addresses::of(addresses).to_string()
        };
        for (numbers, text) in [
            (&[][..], ""),
            (&[5], "5"),
            (&[3, 5, 6], "3, 5, 6"),
            (&[1, 2, 3, 4, 126], "1 to 4, 126"),
            (&[0, 124, 125, 126], "0, 124 to 126"),
        ] {
            assert_eq!(listed(numbers), text);
        }
    }
}
