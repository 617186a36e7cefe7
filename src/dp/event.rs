//! What the slave tells the application and its user.

use core::fmt;
use core::time::Duration;

use super::{CfgFault, PrmFault};
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
            Self::OutputsCleared { master } => write!(f, "outputs cleared by master {master}"),
        }
    }
}
