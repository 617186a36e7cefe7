//! Why a master does not reach or keep a drive.

use core::time::Duration;
use std::io;

use thiserror::Error;

use crate::devices::ag03::profibus::IDENT_NUMBER;
use crate::profibus::fdl::Address;

/// What went wrong between a [`Session`](super::Session) and its drive. `Display` says what to do about it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SessionError {
    /// The end was requested.
    #[error("interrupted")]
    Stopped,
    /// The link no longer works.
    #[error("the connection is lost: {0}")]
    Link(#[source] io::Error),
    /// profirust has given up: nothing can be done with this session any more.
    #[error(
        "the DP master (profirust) has failed: {0}; give the command again, and report it with a capture of the line"
    )]
    Library(String),
    /// The master never got the token.
    #[error(
        "the other masters on the line did not pass the token to master {master} in time; end them, or choose a free \
         --master-address not above their highest station address (HSA)"
    )]
    NoToken {
        /// The address of this master.
        master: Address,
    },
    /// Another master has the address of this one.
    #[error("another master on the line has address {master} too; choose another --master-address")]
    AddressTaken {
        /// The address of both.
        master: Address,
    },
    /// Nobody answers at the drive's address.
    #[error(
        "no answer from station {address}; check that it is switched on, its address (DIP switches), the cable and \
         the rate, or search the line with 'scan'"
    )]
    NoAnswer {
        /// The address asked.
        address: Address,
    },
    /// A master answers at the drive's address.
    #[error("station {address} is a master, not a drive; search for the drive with 'scan'")]
    Master {
        /// The address asked.
        address: Address,
    },
    /// What answers has no diagnosis.
    #[error(
        "station {address} answers, but is no DP slave: it refuses Slave_Diag; search for the drive with 'scan'"
    )]
    NoSlave {
        /// The address asked.
        address: Address,
    },
    /// The slave is another device.
    #[error(
        "station {address} is another device: its ident number is {got:04X}, expected {expected:04X}{}; look for the \
         drive with 'scan'", if *.expected == IDENT_NUMBER { " (SIKO AG03 and AG03/1)" } else { "" }
    )]
    Ident {
        /// The address asked.
        address: Address,
        /// Its ident number.
        got: u16,
        /// That of the drives.
        expected: u16,
    },
    /// Another master has parameterised the drive and keeps it.
    #[error(
        "drive {address} belongs to master {owner}; stop that master first, or give its address with \
         --master-address if it is this program"
    )]
    Locked {
        /// The drive.
        address: Address,
        /// Its owner.
        owner: Address,
    },
    /// The drive does not accept Set_Prm.
    #[error(
        "drive {address} refuses its parameters (Set_Prm): it is not what its GSD says (an AG03: gsd/SIKO0AC5.GSD); see 'diag'"
    )]
    PrmRefused {
        /// The drive.
        address: Address,
    },
    /// The drive does not accept Chk_Cfg.
    #[error(
        "drive {address} refuses its configuration (Chk_Cfg): it is not what its GSD says (an AG03: F3 F2, gsd/SIKO0AC5.GSD); see \
         'diag'"
    )]
    CfgRefused {
        /// The drive.
        address: Address,
    },
    /// Data_Exchange does not begin.
    #[error(
        "drive {address} answers, but does not begin to exchange data within {:.1} s; see 'diag'",
        waited.as_secs_f64()
    )]
    NotReady {
        /// The drive.
        address: Address,
        /// How long was waited.
        waited: Duration,
    },
    /// Nothing can be exchanged with a drive that was not taken over.
    #[error("no drive was taken over: call Session::start first")]
    NotStarted,
    /// The drive no longer answers.
    #[error("lost the connection: drive {address} no longer answers")]
    Silent {
        /// The drive.
        address: Address,
    },
    /// The drive answers, but has left Data_Exchange.
    #[error("lost the connection: drive {address} was switched off and on, or its watchdog expired")]
    Restarted {
        /// The drive.
        address: Address,
    },
    /// Another master has taken the drive.
    #[error("lost the connection: master {owner} has taken drive {address}")]
    Taken {
        /// The drive.
        address: Address,
        /// Its new owner.
        owner: Address,
    },
}

impl SessionError {
    /// Whether the drive can no longer be reached. Its own watchdog stops it then.
    pub(crate) const fn is_loss(&self) -> bool {
        match self {
            Self::Link(_)
            | Self::Library(_)
            | Self::NoToken { .. }
            | Self::AddressTaken { .. }
            | Self::Silent { .. }
            | Self::Restarted { .. }
            | Self::Taken { .. } => true,
            Self::Stopped
            | Self::NoAnswer { .. }
            | Self::Master { .. }
            | Self::NoSlave { .. }
            | Self::Ident { .. }
            | Self::Locked { .. }
            | Self::PrmRefused { .. }
            | Self::CfgRefused { .. }
            | Self::NotReady { .. }
            | Self::NotStarted => false,
        }
    }
}
