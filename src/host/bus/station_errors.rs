//! What went wrong at a station, by kind.

use crate::device::{Event, UnitEvent, ppo_drive as profile};
use crate::{dp, ppo_drive};

/// What went wrong at a station, beside what [`StationCounters`](crate::fdl::StationCounters) have: plain numbers that
/// only grow. They begin at 0 when the station is connected, and a power cycle leaves them as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StationErrors {
    /// Its drive went to fault, or another fault came while one was latched.
    pub faults: u64,
    /// Set_Prm refused, also that of a master that is not the owner.
    pub prm_refused: u64,
    /// Chk_Cfg refused.
    pub cfg_refused: u64,
    /// Data_Exchange with a wrong number of outputs.
    pub output_length: u64,
    /// Set_Slave_Add refused.
    pub address_refused: u64,
    /// The application of the slave was silent or gave up.
    pub application: u64,
    /// Jobs of the parameter channel answered with an error number.
    pub job_refused: u64,
    /// Control words and process data that the drive did not follow.
    pub command_refused: u64,
    /// The image of its EEPROM could not be kept.
    pub not_stored: u64,
}

impl StationErrors {
    /// Every kind but the faults, with a name and how often.
    pub const fn kinds(&self) -> [(&'static str, u64); 8] {
        [
            ("Set_Prm refused", self.prm_refused),
            ("Chk_Cfg refused", self.cfg_refused),
            ("output length", self.output_length),
            ("Set_Slave_Add refused", self.address_refused),
            ("application", self.application),
            ("job refused", self.job_refused),
            ("command refused", self.command_refused),
            ("not stored", self.not_stored),
        ]
    }

    /// Counts what a station tells, if it is an error.
    pub(super) const fn count(&mut self, event: &Event) {
        let kind = match event {
            Event::Dp(event) => match self.of_slave(event) {
                Some(kind) => kind,
                None => return,
            },
            Event::Fault(_)
            | Event::Unit(UnitEvent::Fault(_))
            | Event::PpoDrive(profile::Event::Drive(ppo_drive::Event::Fault(_))) => &mut self.faults,
            Event::JobRefused(_) | Event::PpoDrive(profile::Event::JobRefused(_)) => &mut self.job_refused,
            Event::CommandRefused(_)
            | Event::Unit(UnitEvent::CommandRefused(_))
            | Event::PpoDrive(
                profile::Event::NotSet { .. } | profile::Event::Drive(ppo_drive::Event::InchingRefused),
            ) => &mut self.command_refused,
            Event::Unit(UnitEvent::NotStored { .. }) => &mut self.not_stored,
            Event::PpoDrive(profile::Event::Drive(
                ppo_drive::Event::State(_) | ppo_drive::Event::Acknowledged | ppo_drive::Event::Warning(_),
            ))
            | Event::Drive { .. }
            | Event::Unit(
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
            | Event::SwitchedOff
            | Event::SwitchedOn(_)
            | Event::FactoryReset(_)
            | Event::TelegramRefused(_)
            | Event::ReplyTooLate(_)
            | Event::Hint(_)
            | Event::Lost { .. } => return,
        };
        *kind = kind.saturating_add(1);
    }

    const fn of_slave(&mut self, event: &dp::Event) -> Option<&mut u64> {
        Some(match event {
            dp::Event::PrmRejected { .. } | dp::Event::PrmForeign { .. } => &mut self.prm_refused,
            dp::Event::CfgRejected { .. } => &mut self.cfg_refused,
            dp::Event::WrongOutputLength { .. } => &mut self.output_length,
            dp::Event::AddressRefused { .. } => &mut self.address_refused,
            dp::Event::ApplicationSilent { .. } | dp::Event::ApplicationAborted { .. } => {
                &mut self.application
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Fault;
    use crate::fdl::Address;

    #[test]
    fn what_is_no_error_is_not_counted_and_each_error_once() {
        let master = Address::station(2).unwrap();
        let mut errors = StationErrors::default();
        errors.count(&Event::Dp(dp::Event::Released { master }));
        errors.count(&Event::SwitchedOff);
        assert_eq!(errors, StationErrors::default());
        for event in [
            Event::Fault(Fault::B),
            Event::PpoDrive(profile::Event::Drive(ppo_drive::Event::Fault(ppo_drive::Fault::Overload))),
            Event::Dp(dp::Event::PrmForeign { master, owner: master }),
            Event::Dp(dp::Event::WrongOutputLength { master, expected: 14, got: 1 }),
            Event::Dp(dp::Event::ApplicationAborted { master }),
            Event::Unit(UnitEvent::NotStored { undone: true }),
        ] {
            errors.count(&event);
        }
        let expected = StationErrors {
            faults: 2,
            prm_refused: 1,
            output_length: 1,
            application: 1,
            not_stored: 1,
            ..StationErrors::default()
        };
        assert_eq!(errors, expected);
        let counted: u64 = errors.kinds().iter().map(|(_, times)| times).sum();
        assert_eq!(counted, 4, "all but the faults");
    }
}
