//! What goes wrong at a station, by kind.

use strum::{IntoStaticStr, VariantArray};

use super::ag03::profibus::Event;
use super::ppo_drive::profibus as profile;
use crate::devices::ag03::unit;
use crate::devices::ppo_drive;
use crate::profibus::dp;

/// A kind of error that a station tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
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
    pub(crate) const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// Its name for programs, as `prm_refused`.
    pub(crate) fn name(self) -> &'static str {
        self.into()
    }
}

impl Event {
    /// Which error it tells; `None`: it tells none.
    pub(crate) const fn error(&self) -> Option<ErrorKind> {
        Some(match self {
            Self::Dp(event) => return of_slave(event),
            Self::Fault(_)
            | Self::Unit(unit::Event::Fault(_))
            | Self::PpoDrive(profile::Event::Drive(ppo_drive::Event::Fault(_))) => ErrorKind::Fault,
            Self::JobRefused(_) | Self::PpoDrive(profile::Event::JobRefused(_)) => ErrorKind::JobRefused,
            Self::CommandRefused(_)
            | Self::Unit(unit::Event::CommandRefused(_))
            | Self::PpoDrive(
                profile::Event::NotSet { .. } | profile::Event::Drive(ppo_drive::Event::InchingRefused),
            ) => ErrorKind::CommandRefused,
            Self::Unit(unit::Event::NotStored { .. }) => ErrorKind::NotStored,
            Self::PpoDrive(profile::Event::Drive(
                ppo_drive::Event::State(_)
                | ppo_drive::Event::Acknowledged
                | ppo_drive::Event::Warning(_)
                | ppo_drive::Event::Load { .. },
            ))
            | Self::Drive { .. }
            | Self::Unit(
                unit::Event::FaultCauseGone(_)
                | unit::Event::Drive(_)
                | unit::Event::Written { .. }
                | unit::Event::Stored
                | unit::Event::Input(_)
                | unit::Event::SwitchesSet(_)
                | unit::Event::SwitchedOff
                | unit::Event::SwitchedOn(_)
                | unit::Event::FactoryReset(_)
                | unit::Event::Lost { .. },
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
    use crate::devices::ag03::drive::Fault;
    use crate::profibus::fdl::Address;

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
            (Event::Unit(unit::Event::NotStored { undone: true }), Some(ErrorKind::NotStored)),
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
