//! News of a station on PROFIBUS, whichever device it is.

use core::fmt;

use crate::face::{AnyDeviceEvent, DeviceEvent, ErrorKind, EventKind, Reason};
use crate::profibus::dp;
use crate::profibus::dpv1;
use crate::profibus::fdl::FrameError;
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::profibus::fdl::station::TooLate;

/// Something a user may want to read. `Display` is one line of plain English. `D` is an event of the device behind the slave.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StationEvent<D = AnyDeviceEvent> {
    /// The DP slave: parameters, configuration, data exchange, watchdog.
    Dp(dp::Event),
    /// Services of DP-V1: records, alarms, connections.
    Acyclic(dpv1::Event),
    /// Octets on the line were no telegram.
    TelegramRefused(FrameError),
    /// A reply was dropped because its time was over.
    ReplyTooLate(TooLate),
    /// The device behind the slave, which names its bits and parameters.
    Device(D),
    /// Events were lost because nobody took them in time.
    Lost {
        /// How many.
        events: u32,
    },
}

impl<D: DeviceEvent> StationEvent<D> {
    /// What it is about, for filters.
    pub fn kind(&self) -> EventKind {
        match self {
            Self::Dp(_) | Self::Acyclic(_) => EventKind::Dp,
            Self::TelegramRefused(_) | Self::ReplyTooLate(_) | Self::Lost { .. } => EventKind::Line,
            Self::Device(event) => event.kind(),
        }
    }

    /// Which error it tells, for counters; `None`: it tells none.
    pub fn error(&self) -> Option<ErrorKind> {
        match self {
            Self::Dp(event) => of_slave(event),
            Self::Device(event) => event.error(),
            Self::Acyclic(_) | Self::TelegramRefused(_) | Self::ReplyTooLate(_) | Self::Lost { .. } => None,
        }
    }

    /// Each reason of a refused command.
    pub(crate) fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        if let Self::Device(event) = self {
            event.each_reason(tell);
        }
    }

    /// Whether it is cyclic detail: a log leaves it out unless asked for more.
    pub fn is_detail(&self) -> bool {
        match self {
            Self::Dp(event) => event.is_detail(),
            Self::Acyclic(event) => event.is_detail(),
            Self::Device(event) => event.is_detail(),
            Self::TelegramRefused(_) | Self::ReplyTooLate(_) | Self::Lost { .. } => false,
        }
    }
}

#[cfg(feature = "std")]
impl<D: DeviceEvent + PartialEq> StationEvent<D> {
    /// The same for those who do not know the device.
    pub(crate) fn of_any(self) -> StationEvent {
        match self {
            Self::Dp(event) => StationEvent::Dp(event),
            Self::Acyclic(event) => StationEvent::Acyclic(event),
            Self::TelegramRefused(error) => StationEvent::TelegramRefused(error),
            Self::ReplyTooLate(too_late) => StationEvent::ReplyTooLate(too_late),
            Self::Device(event) => StationEvent::Device(AnyDeviceEvent::new(event)),
            Self::Lost { events } => StationEvent::Lost { events },
        }
    }
}

/// Writes the reply of a station to `buf`, if there is one: how many octets it has. That one is too late is news.
pub(crate) fn write_reply(
    reply: Result<Option<&[u8]>, TooLate>,
    buf: &mut [u8; MAX_TELEGRAM_LEN],
    news: &mut dyn FnMut(StationEvent),
) -> Option<usize> {
    match reply {
        Ok(octets) => {
            let octets = octets?;
            buf.get_mut(..octets.len())?.copy_from_slice(octets);
            Some(octets.len())
        }
        Err(too_late) => {
            news(StationEvent::ReplyTooLate(too_late));
            None
        }
    }
}

impl<D: fmt::Display> fmt::Display for StationEvent<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dp(event) => event.fmt(f),
            Self::Acyclic(event) => event.fmt(f),
            Self::TelegramRefused(error) => write!(f, "ignored octets: {error}"),
            Self::ReplyTooLate(TooLate { after, limit }) => {
                write!(f, "dropped a reply {after:?} after its request, expected at most {limit:?}")
            }
            Self::Device(event) => event.fmt(f),
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

#[cfg(all(test, feature = "std"))]
mod tests {
    use super::*;
    use crate::devices::ag03::drive::Fault;
    use crate::devices::ag03::{profibus, unit};
    use crate::devices::ppo_drive;
    use crate::profibus::fdl::Address;

    #[test]
    fn what_is_no_error_is_none() {
        let master = Address::station(2).unwrap();
        let of_unit = |event| StationEvent::Device(profibus::Event::Unit { event, stw: None }).of_any();
        let overload = ppo_drive::Event::Fault(ppo_drive::Fault::Overload);
        for (event, kind) in [
            (of_unit(unit::Event::Fault(Fault::B)), Some(ErrorKind::Fault)),
            (
                StationEvent::Device(ppo_drive::profibus::Event::Drive(overload)).of_any(),
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
