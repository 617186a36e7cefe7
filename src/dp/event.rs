//! What the slave tells the application and its user.

use core::fmt;
use core::time::Duration;

use super::{AddressFault, CfgFault, CfgTicket, PrmFault, StoredAddress};
use crate::fdl::Address;

/// What the slave tells the application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Set_Prm was accepted: the slave has an owner and waits for Chk_Cfg.
    Parameterised {
        /// The new owner.
        master: Address,
        /// The watchdog time, `None` = off.
        watchdog: Option<Duration>,
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
    /// The owner released the slave.
    Released {
        /// Who owned it.
        master: Address,
    },
    /// Chk_Cfg was accepted: Data_Exchange begins.
    DataExchange {
        /// The owner.
        master: Address,
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
    /// Global_Control cleared the outputs.
    OutputsCleared {
        /// The owner.
        master: Address,
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

impl fmt::Display for Event {
    /// One line of plain English, with the reason where something was refused.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Parameterised { master, watchdog: Some(time) } => {
                write!(f, "parameterised by master {master}, watchdog {time:?}")
            }
            Self::Parameterised { master, watchdog: None } => {
                write!(f, "parameterised by master {master}, watchdog off")
            }
            Self::PrmRejected { master, fault } => {
                write!(f, "refused the parameters of master {master}: {fault}")
            }
            Self::PrmForeign { master, owner } => {
                write!(f, "ignored the parameters of master {master}: locked by master {owner}")
            }
            Self::Released { master } => write!(f, "released by master {master}"),
            Self::DataExchange { master } => write!(f, "in Data_Exchange with master {master}"),
            Self::CfgRejected { master, fault } => {
                write!(f, "refused the configuration of master {master}: {fault}")
            }
            Self::WrongOutputLength { master, expected, got } => {
                write!(f, "left Data_Exchange: master {master} sent {got} output octets, expected {expected}")
            }
            Self::WatchdogExpired { master, after } => {
                write!(f, "watchdog expired: nothing from master {master} for {after:?}")
            }
            Self::CfgToJudge { master, .. } => {
                write!(f, "the application judges the configuration of master {master}")
            }
            Self::OutputsCleared { master } => write!(f, "outputs cleared by master {master}"),
            Self::SafeState { master } => write!(f, "safe state: master {master} sends no outputs"),
            Self::ApplicationSilent { master, after } => {
                write!(f, "left master {master}: nothing from the application for {after:?}")
            }
            Self::ApplicationAborted { master } => write!(f, "left master {master}: the application gave up"),
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
