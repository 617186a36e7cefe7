//! What goes wrong at a station, by kind.

use super::{Event, ppo_drive as profile};
use crate::unit::Event as UnitEvent;
use crate::{dp, ppo_drive};

/// A kind of error that a station tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorKind {
    /// Its drive went to fault, or another fault came while one was latched.
    Fault,
    /// Set_Prm refused, also that of a master that is not the owner.
    PrmRefused,
    /// Chk_Cfg refused.
    CfgRefused,
    /// Data_Exchange with a wrong number of outputs.
    OutputLength,
    /// Set_Slave_Add refused.
    AddressRefused,
    /// The application of the slave was silent or gave up.
    Application,
    /// A job of the parameter channel answered with an error number.
    JobRefused,
    /// A control word or process data that the drive did not follow.
    CommandRefused,
    /// The image of its EEPROM could not be kept.
    NotStored,
}

impl ErrorKind {
    /// Every kind.
    pub const ALL: [Self; 9] = [
        Self::Fault,
        Self::PrmRefused,
        Self::CfgRefused,
        Self::OutputLength,
        Self::AddressRefused,
        Self::Application,
        Self::JobRefused,
        Self::CommandRefused,
        Self::NotStored,
    ];

    /// Its name for programs, as `prm_refused`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fault => "fault",
            Self::PrmRefused => "prm_refused",
            Self::CfgRefused => "cfg_refused",
            Self::OutputLength => "output_length",
            Self::AddressRefused => "address_refused",
            Self::Application => "application",
            Self::JobRefused => "job_refused",
            Self::CommandRefused => "command_refused",
            Self::NotStored => "not_stored",
        }
    }
}

impl Event {
    /// Which error it tells; `None`: it tells none.
    pub const fn error(&self) -> Option<ErrorKind> {
        Some(match self {
            Self::Dp(event) => return of_slave(event),
            Self::Fault(_)
            | Self::Unit(UnitEvent::Fault(_))
            | Self::PpoDrive(profile::Event::Drive(ppo_drive::Event::Fault(_))) => ErrorKind::Fault,
            Self::JobRefused(_) | Self::PpoDrive(profile::Event::JobRefused(_)) => ErrorKind::JobRefused,
            Self::CommandRefused(_)
            | Self::Unit(UnitEvent::CommandRefused(_))
            | Self::PpoDrive(
                profile::Event::NotSet { .. } | profile::Event::Drive(ppo_drive::Event::InchingRefused),
            ) => ErrorKind::CommandRefused,
            Self::Unit(UnitEvent::NotStored { .. }) => ErrorKind::NotStored,
            Self::PpoDrive(profile::Event::Drive(
                ppo_drive::Event::State(_)
                | ppo_drive::Event::Acknowledged
                | ppo_drive::Event::Warning(_)
                | ppo_drive::Event::Load { .. },
            ))
            | Self::Drive { .. }
            | Self::Unit(
                UnitEvent::FaultCauseGone(_)
                | UnitEvent::Drive(_)
                | UnitEvent::Written { .. }
                | UnitEvent::Stored
                | UnitEvent::Input(_)
                | UnitEvent::SwitchesSet(_)
                | UnitEvent::SwitchedOff
                | UnitEvent::SwitchedOn(_)
                | UnitEvent::FactoryReset(_)
                | UnitEvent::Lost { .. },
            )
            | Self::SwitchedOff
            | Self::SwitchedOn(_)
            | Self::FactoryReset(_)
            | Self::TelegramRefused(_)
            | Self::ReplyTooLate(_)
            | Self::Hint(_)
            | Self::Lost { .. } => return None,
        })
    }
}

const fn of_slave(event: &dp::Event) -> Option<ErrorKind> {
    Some(match event {
        dp::Event::PrmRejected { .. } | dp::Event::PrmForeign { .. } => ErrorKind::PrmRefused,
        dp::Event::CfgRejected { .. } => ErrorKind::CfgRefused,
        dp::Event::WrongOutputLength { .. } => ErrorKind::OutputLength,
        dp::Event::AddressRefused { .. } => ErrorKind::AddressRefused,
        dp::Event::ApplicationSilent { .. } | dp::Event::ApplicationAborted { .. } => ErrorKind::Application,
        // Told once in each state, so that counting them means nothing.
        dp::Event::NotServed { .. } | dp::Event::LatchClosed { .. } | dp::Event::MinTsdrOnly { .. } => {
            return None;
        }
        dp::Event::Parameterised { .. }
        | dp::Event::Released { .. }
        | dp::Event::DataExchange { .. }
        | dp::Event::CfgToJudge { .. }
        | dp::Event::WatchdogExpired { .. }
        | dp::Event::Controlled { .. }
        | dp::Event::SafeState { .. }
        | dp::Event::Read { .. }
        | dp::Event::AddressSet { .. } => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Fault;
    use crate::fdl::Address;

    #[test]
    fn what_is_no_error_is_none() {
        let master = Address::station(2).unwrap();
        for (event, kind) in [
            (Event::Fault(Fault::B), Some(ErrorKind::Fault)),
            (
                Event::PpoDrive(profile::Event::Drive(ppo_drive::Event::Fault(ppo_drive::Fault::Overload))),
                Some(ErrorKind::Fault),
            ),
            (Event::Dp(dp::Event::PrmForeign { master, owner: master }), Some(ErrorKind::PrmRefused)),
            (
                Event::Dp(dp::Event::WrongOutputLength { master, expected: 14, got: 1 }),
                Some(ErrorKind::OutputLength),
            ),
            (Event::Dp(dp::Event::ApplicationAborted { master }), Some(ErrorKind::Application)),
            (Event::Unit(UnitEvent::NotStored { undone: true }), Some(ErrorKind::NotStored)),
            (Event::Dp(dp::Event::Released { master }), None),
            (Event::SwitchedOff, None),
        ] {
            assert_eq!(event.error(), kind, "{event}");
        }
    }

    #[test]
    fn each_kind_has_its_place_in_the_list() {
        for (place, kind) in ErrorKind::ALL.iter().enumerate() {
            assert_eq!(*kind as usize, place, "{}", kind.name());
        }
    }
}
