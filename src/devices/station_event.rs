//! News of a station on PROFIBUS, whichever device it is.

use core::fmt;

use super::ag03;
#[cfg(feature = "std")]
use super::ppo_drive;
use crate::face::{ErrorKind, EventKind, Reason};
use crate::profibus::dp;
use crate::profibus::dpv1;
use crate::profibus::fdl::FrameError;
use crate::profibus::fdl::station::TooLate;

/// Something a user may want to read. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StationEvent {
    /// The DP slave: parameters, configuration, data exchange, watchdog.
    Dp(dp::Event),
    /// Services of DP-V1: records, alarms, connections.
    Acyclic(dpv1::Event),
    /// Octets on the line were no telegram.
    TelegramRefused(FrameError),
    /// A reply was dropped because its time was over.
    ReplyTooLate(TooLate),
    /// An AG03 or AG03/1 behind the slave, which names its bits and parameters.
    Ag03(ag03::profibus::Event),
    /// A drive of the profile behind the slave.
    #[cfg(feature = "std")]
    PpoDrive(ppo_drive::profibus::Event),
    /// Events were lost because nobody took them in time.
    Lost {
        /// How many.
        events: u32,
    },
}

impl StationEvent {
    /// What it is about, for filters.
    pub const fn kind(&self) -> EventKind {
        match self {
            Self::Dp(_) | Self::Acyclic(_) => EventKind::Dp,
            Self::TelegramRefused(_) | Self::ReplyTooLate(_) | Self::Lost { .. } => EventKind::Line,
            Self::Ag03(event) => event.kind(),
            #[cfg(feature = "std")]
            Self::PpoDrive(event) => event.kind(),
        }
    }

    /// Which error it tells, for counters; `None`: it tells none.
    pub const fn error(&self) -> Option<ErrorKind> {
        match self {
            Self::Dp(event) => of_slave(event),
            Self::Ag03(event) => event.error(),
            #[cfg(feature = "std")]
            Self::PpoDrive(event) => event.kind().error(),
            Self::Acyclic(_) | Self::TelegramRefused(_) | Self::ReplyTooLate(_) | Self::Lost { .. } => None,
        }
    }

    /// Each reason of a refused command.
    pub(crate) fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        if let Self::Ag03(ag03::profibus::Event::CommandRefused(refusal)) = self {
            refusal.each_reason(tell);
        }
    }

    /// Whether it is cyclic detail: a log leaves it out unless asked for more.
    pub const fn is_detail(&self) -> bool {
        match self {
            Self::Dp(event) => event.is_detail(),
            Self::Acyclic(event) => event.is_detail(),
            Self::Ag03(event) => event.is_detail(),
            #[cfg(feature = "std")]
            Self::PpoDrive(_) => false,
            Self::TelegramRefused(_) | Self::ReplyTooLate(_) | Self::Lost { .. } => false,
        }
    }
}

impl fmt::Display for StationEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dp(event) => event.fmt(f),
            Self::Acyclic(event) => event.fmt(f),
            Self::TelegramRefused(error) => write!(f, "ignored octets: {error}"),
            Self::ReplyTooLate(TooLate { after, limit }) => {
                write!(f, "dropped a reply {after:?} after its request, expected at most {limit:?}")
            }
            Self::Ag03(event) => event.fmt(f),
            #[cfg(feature = "std")]
            Self::PpoDrive(event) => event.fmt(f),
            Self::Lost { events } => write!(f, "{events} more events were lost"),
        }
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
    use crate::devices::ag03::unit;
    use crate::profibus::fdl::Address;

    #[test]
    fn what_is_no_error_is_none() {
        let master = Address::station(2).unwrap();
        let of_unit = |event| StationEvent::Ag03(ag03::profibus::Event::Unit { event, stw: None });
        for (event, kind) in [
            (of_unit(unit::Event::Fault(Fault::B)), Some(ErrorKind::Fault)),
            #[cfg(feature = "std")]
            (
                StationEvent::PpoDrive(ppo_drive::profibus::Event::Drive(ppo_drive::Event::Fault(
                    ppo_drive::Fault::Overload,
                ))),
                Some(ErrorKind::Fault),
            ),
            (StationEvent::Dp(dp::Event::PrmForeign { master, owner: master }), Some(ErrorKind::PrmRefused)),
            (
                StationEvent::Dp(dp::Event::WrongOutputLength { master, expected: 14, got: 1 }),
                Some(ErrorKind::OutputLength),
            ),
            (StationEvent::Dp(dp::Event::ApplicationAborted { master }), Some(ErrorKind::Application)),
            (of_unit(unit::Event::NotStored { undone: true }), Some(ErrorKind::NotStored)),
            (StationEvent::Dp(dp::Event::Released { master }), None),
            (of_unit(unit::Event::SwitchedOff), None),
        ] {
            assert_eq!(event.error(), kind, "{event}");
        }
    }
}
