//! What the slave tells the application and its user.

use core::fmt;
use core::time::Duration;

use super::global_control::Latch;
use super::{
    AddressFault, CfgFault, CfgTicket, DiagBit, GlobalControl, IoLengths, MASTER_SAP, PrmBit, PrmFault,
    Reason, Service, StoredAddress,
};
use crate::profibus::fdl::station::DEFAULT_MIN_TSDR;
use crate::profibus::fdl::{Address, Sap};

/// max T_SDR of the lower rates, in bit times: what is not above it is below that of each rate.
const LOWEST_MAX_TSDR: u8 = 60;

/// What the slave tells the application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event {
    /// Set_Prm was accepted: the slave has an owner and waits for Chk_Cfg.
    Parameterised {
        /// The new owner.
        master: Address,
        /// The watchdog time, `None` = off.
        watchdog: Option<Duration>,
        /// The min T_SDR in T_bit; `None`: Set_Prm left it as it was.
        min_tsdr: Option<u8>,
        /// Group_Ident: one bit per group, 0 = none.
        groups: u8,
        /// Set_Prm asks for Sync or Freeze, which the slave lacks: Not_Supported in Slave_Diag.
        not_supported: bool,
    },
    /// Set_Prm was refused: the slave waits for another one.
    PrmRejected {
        /// Who sent it.
        master: Address,
        /// What is wrong with it.
        fault: PrmFault,
    },
    /// Set_Prm of a master that is not the owner: no effect.
    PrmForeign {
        /// Who sent it.
        master: Address,
        /// Who owns the slave.
        owner: Address,
    },
    /// Set_Prm without Lock_Req and Unlock_Req: only its min T_SDR counts, the owner stays as it was.
    MinTsdrOnly {
        /// Who sent it.
        master: Address,
        /// The min T_SDR in T_bit; `None`: Set_Prm left it as it was.
        min_tsdr: Option<u8>,
    },
    /// The owner released the slave.
    Released {
        /// Who owned it.
        master: Address,
    },
    /// Chk_Cfg was accepted: Data_Exchange begins.
    DataExchange {
        /// The owner.
        master: Address,
        /// The configuration.
        configuration: Configuration,
    },
    /// Chk_Cfg was refused: the slave waits for Set_Prm.
    CfgRejected {
        /// Who sent it.
        master: Address,
        /// What is wrong with it.
        fault: CfgFault,
    },
    /// Chk_Cfg brought a configuration that the slave accepts and the application has yet to judge
    /// ([`Station::judge_cfg`](super::Station::judge_cfg)).
    CfgToJudge {
        /// The owner.
        master: Address,
        /// What to judge it by.
        ticket: CfgTicket,
    },
    /// Data_Exchange with a wrong number of outputs: the slave waits for Set_Prm.
    WrongOutputLength {
        /// The owner.
        master: Address,
        /// Octets configured.
        expected: u8,
        /// Octets found.
        got: usize,
    },
    /// The owner was silent for the watchdog time: the slave waits for Set_Prm.
    WatchdogExpired {
        /// Who owned the slave.
        master: Address,
        /// The watchdog time.
        after: Duration,
    },
    /// Global_Control was carried out: Clear_Data, Sync, Freeze, or the end of one.
    Controlled {
        /// The owner.
        master: Address,
        /// What it asked for.
        command: GlobalControl,
        /// Outputs were cleared that were not 0, or Sync or Freeze began or ended: not a mere repetition.
        changed: bool,
    },
    /// Global_Control asked for Sync or Freeze, which Set_Prm did not: without effect. Said once, until the state or the
    /// owner of the slave changes.
    LatchClosed {
        /// The owner.
        master: Address,
        /// Which bit of Set_Prm opens it.
        bit: PrmBit,
        /// The slave has this mode.
        supported: bool,
    },
    /// A request that is not served here or now, without effect. Each service is said once, until the state or the
    /// owner of the slave changes.
    NotServed {
        /// Who asked.
        master: Address,
        /// For which service; `None`: nothing listens where it asked.
        service: Option<Service>,
        /// Why not.
        why: NotServed,
    },
    /// Data_Exchange without outputs: the slave has taken its safe state. Said once, until outputs come again.
    SafeState {
        /// The owner.
        master: Address,
    },
    /// The application did not say that it is alive for the user watchdog time: the slave waits for Set_Prm.
    ApplicationSilent {
        /// Who owned the slave.
        master: Address,
        /// The user watchdog time.
        after: Duration,
    },
    /// The application gave up: the slave waits for Set_Prm.
    ApplicationAborted {
        /// Who owned the slave.
        master: Address,
    },
    /// A master has read: Get_Cfg, RD_Inp or RD_Outp.
    Read {
        /// Who.
        master: Address,
        /// With which service.
        service: Service,
    },
    /// Set_Slave_Add gave the slave another address. To be stored by the host, with
    /// [`Slave::rem_slave_data`](super::Slave::rem_slave_data).
    AddressSet {
        /// Who sent it.
        master: Address,
        /// The new address and whether it may be changed again.
        stored: StoredAddress,
    },
    /// Set_Slave_Add was refused.
    AddressRefused {
        /// Who sent it.
        master: Address,
        /// What is wrong with it.
        fault: AddressFault,
    },
}

/// Why a request is not served.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum NotServed {
    /// The slave waits for Set_Prm.
    WaitsForPrm,
    /// The slave waits for Chk_Cfg.
    WaitsForCfg,
    /// It is another master's.
    Locked {
        /// Who owns the slave.
        owner: Address,
    },
    /// The service is only there while nobody owns the slave.
    Owned {
        /// Who owns the slave.
        owner: Address,
    },
    /// The slave has no such service.
    NotOffered,
    /// The slave has no address of its own yet.
    NoAddress,
    /// It came from another SAP of the master than 62.
    MasterSap {
        /// The SAP found.
        got: Option<Sap>,
    },
    /// No service of DP-V0 listens at this SAP.
    NoSuchSap {
        /// The SAP asked for.
        got: Option<Sap>,
    },
    /// It asks for a reply; the service has none.
    NoReply,
    /// A service that only reads came with data.
    WithData {
        /// Octets found.
        got: usize,
    },
}

/// A configuration that was accepted, as far as it is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Configuration {
    /// The first identifiers, the rest 0.
    identifiers: [u8; Self::TOLD],
    /// How many identifier octets there are, 1..=244.
    len: u8,
    /// How many octets are exchanged.
    pub lengths: IoLengths,
}

impl Configuration {
    const TOLD: usize = 8;

    pub(super) fn new(configuration: &[u8], lengths: IoLengths) -> Self {
        let mut identifiers = [0; Self::TOLD];
        for (told, octet) in identifiers.iter_mut().zip(configuration) {
            *told = *octet;
        }
        Self { identifiers, len: configuration.len().try_into().unwrap_or(u8::MAX), lengths }
    }

    /// The identifier octets, at most the first eight.
    pub(crate) fn identifiers(&self) -> &[u8] {
        self.identifiers.get(..self.len.into()).unwrap_or(&self.identifiers)
    }
}

impl fmt::Display for Configuration {
    /// `F3 F2: 14 octets out, 14 in`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, identifier) in self.identifiers().iter().enumerate() {
            write!(f, "{}{identifier:02X}", if place == 0 { "" } else { " " })?;
        }
        let more = if usize::from(self.len) > Self::TOLD { " ..." } else { "" };
        let octets = if self.lengths.outputs == 1 { "octet" } else { "octets" };
        write!(f, "{more}: {} {octets} out, {} in", self.lengths.outputs, self.lengths.inputs)
    }
}

impl Event {
    /// The number of what the application refused, whose words it has ([`Application::words`](super::Application::words)).
    pub(crate) const fn refused_number(&self) -> Option<u16> {
        if let Self::PrmRejected { fault: PrmFault::UserPrm(refusal), .. }
        | Self::CfgRejected { fault: CfgFault::Refused(refusal), .. } = self
            && let Reason::Numbered(number) = refusal.reason
        {
            return Some(number);
        }
        None
    }

    /// Whether it is cyclic detail: a log leaves it out unless asked for more.
    pub(crate) const fn is_detail(&self) -> bool {
        matches!(self, Self::Controlled { changed: false, .. } | Self::Read { .. })
    }
}

impl fmt::Display for Event {
    /// One line of plain English, with the reason where something was refused.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Parameterised { master, watchdog, min_tsdr, groups, not_supported } => {
                write!(f, "parameterised by master {master}, ")?;
                match watchdog {
                    Some(time) => write!(f, "watchdog {time:?}")?,
                    None => {
                        f.write_str("watchdog off: nothing stops the outputs when the master is silent")?
                    }
                }
                if let Some(bits) = min_tsdr {
                    write!(f, ", min T_SDR {bits} T_bit")?;
                    if *bits > LOWEST_MAX_TSDR {
                        f.write_str(
                            " (more than max T_SDR, which is 60 up to 187.5 kbit/s, 100 at 500 kbit/s, 150 at 1.5 Mbit/s: lower it, \
                             or masters do not wait for the reply)",
                        )?;
                    }
                    if *bits < DEFAULT_MIN_TSDR {
                        write!(f, " (taken as {DEFAULT_MIN_TSDR})")?;
                    }
                }
                let mut groups = (0..8).filter(|group| groups >> group & 1 == 1);
                if let Some(first) = groups.next() {
                    write!(f, ", groups {}", first + 1)?;
                    groups.try_for_each(|group| write!(f, " {}", group + 1))?;
                }
                if *not_supported {
                    let bit = DiagBit::NotSupported;
                    write!(
                        f,
                        ", Sync or Freeze (Set_Prm octet 1 bits {} and {}) is not supported: Slave_Diag {} is set, take the slave out of their groups in the master's project",
                        PrmBit::SyncReq.number(),
                        PrmBit::FreezeReq.number(),
                        bit.name()
                    )?;
                }
                Ok(())
            }
            Self::PrmRejected { master, fault } => {
                write!(f, "refused the parameters of master {master}: {fault}")
            }
            Self::PrmForeign { master, owner } => {
                write!(
                    f,
                    "ignored the parameters of master {master}: locked by master {owner}; stop master {owner}, or let it \
                     unlock the slave (Set_Prm with Unlock_Req), or switch the slave off and on"
                )
            }
            Self::MinTsdrOnly { master, min_tsdr } => {
                f.write_str("took ")?;
                match min_tsdr {
                    Some(bits) => write!(f, "only min T_SDR {bits} T_bit")?,
                    None => f.write_str("nothing")?,
                }
                write!(
                    f,
                    " from Set_Prm of master {master}: octet 1 bit {} ({}) is 0; set it, or the slave is not parameterised",
                    PrmBit::LockReq.number(),
                    PrmBit::LockReq.name()
                )
            }
            Self::Released { master } => {
                write!(f, "unlocked by master {master} (Unlock_Req), waits for Set_Prm")
            }
            Self::DataExchange { master, configuration } => {
                write!(f, "in Data_Exchange with master {master}, configuration {configuration}")
            }
            Self::CfgRejected { master, fault } => {
                write!(f, "refused the configuration of master {master}: {fault}")
            }
            Self::WrongOutputLength { master, expected, got } => {
                write!(
                    f,
                    "left Data_Exchange: master {master} sent {got} output octets, expected {expected}: use the configuration that \
                     it checked with Chk_Cfg"
                )
            }
            Self::WatchdogExpired { master, after } => {
                write!(
                    f,
                    "watchdog expired: nothing from master {master} for {after:?}, waits for Set_Prm; if the master \
                     is only slow, raise its watchdog time above its longest cycle"
                )
            }
            Self::CfgToJudge { master, .. } => {
                write!(f, "the application judges the configuration of master {master}")
            }
            Self::Controlled { master, command, .. } => {
                write!(f, "Global_Control of master {master}:")?;
                let said = [
                    (command.clear_data, " outputs cleared"),
                    (command.sync == Latch::Set, " Sync"),
                    (command.sync == Latch::Release, " Unsync"),
                    (command.freeze == Latch::Set, " Freeze"),
                    (command.freeze == Latch::Release, " Unfreeze"),
                ];
                said.into_iter().filter(|(does, _)| *does).try_for_each(|(_, what)| f.write_str(what))
            }
            Self::LatchClosed { master, bit, supported } => {
                let latch = if *bit == PrmBit::SyncReq { "Sync" } else { "Freeze" };
                write!(f, "{latch} of master {master} has no effect: ")?;
                if *supported {
                    write!(
                        f,
                        "Set_Prm octet 1 bit {} ({}) was 0; put the slave into a {latch} group in the master's project",
                        bit.number(),
                        bit.name()
                    )
                } else {
                    write!(
                        f,
                        "the slave has no {latch}; take it out of the {latch} groups of the master's project"
                    )
                }
            }
            Self::NotServed { master, service, why } => match service {
                Some(service) => write!(f, "refused {} of master {master}: {why}", service.name()),
                None => write!(f, "refused a request of master {master}: {why}"),
            },
            Self::SafeState { master } => write!(f, "safe state: master {master} sends no outputs"),
            Self::ApplicationSilent { master, after } => {
                write!(f, "left master {master}: nothing from the application for {after:?}")
            }
            Self::ApplicationAborted { master } => {
                write!(f, "left master {master}: the application ended the data exchange")
            }
            Self::Read { master, service } => write!(f, "{} by master {master}", service.name()),
            Self::AddressSet { master, stored: StoredAddress { address, no_add_chg } } => {
                let change = if *no_add_chg { ", not to be changed again" } else { "" };
                write!(f, "address {address} given by master {master}{change}")
            }
            Self::AddressRefused { master, fault } => {
                write!(f, "refused another address by master {master}: {fault}")
            }
        }
    }
}

impl fmt::Display for NotServed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::WaitsForPrm => f.write_str("the slave waits for Set_Prm; send Set_Prm, then Chk_Cfg"),
            Self::WaitsForCfg => f.write_str("the slave waits for Chk_Cfg; send Chk_Cfg first"),
            Self::Locked { owner } => write!(f, "locked by master {owner}, only that one may do this"),
            Self::Owned { owner } => {
                write!(f, "locked by master {owner}; let it unlock the slave first (Set_Prm with Unlock_Req)")
            }
            Self::NotOffered => f.write_str("the slave has no such service"),
            Self::NoAddress => write!(
                f,
                "address {} is for stations that have none yet; give it another address first",
                StoredAddress::DELIVERED.address
            ),
            Self::MasterSap { got } => {
                write!(f, "it comes from {}, expected {}", Place(*got), Place(MASTER_SAP))
            }
            Self::NoSuchSap { got } => match got.map(Sap::number) {
                Some(sap @ 50..=51) => write!(
                    f,
                    "nothing listens at SAP {sap} now: it is for DP-V1, if the slave has it, in data exchange, for its owner, \
                     with DPV1_Enable in octet 8 of Set_Prm"
                ),
                Some(sap @ ..=49) => write!(
                    f,
                    "nothing listens at SAP {sap}: it is for connections of DP-V1 (SAP 49 opens one), if the slave has them"
                ),
                Some(_) | None => {
                    write!(f, "no service listens at {}; those of DP-V0 have SAP 55 to 62", Place(*got))
                }
            },
            Self::NoReply => f.write_str("it asks for a reply, expected a request without one (SDN)"),
            Self::WithData { got } => {
                let octets = if *got == 1 { "octet" } else { "octets" };
                write!(f, "it has {got} {octets} of data, expected none")
            }
        }
    }
}

/// `SAP 51`.
struct Place(Option<Sap>);

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(sap) => write!(f, "SAP {}", sap.number()),
            None => f.write_str("no SAP"),
        }
    }
}
