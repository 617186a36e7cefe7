//! What keeps a master from the services of DP-V1 now, and what waits for a master.

use core::fmt;

use super::{AlarmHead, Event};
use crate::profibus::dp::State;

/// Something that a master has to do first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Obstacle {
    /// Records and alarms of the owner need data exchange.
    NoExchange(State),
    /// Set_Prm of the owner did not enable DP-V1.
    NotEnabled,
    /// The owner has not read an alarm.
    AlarmNotRead(AlarmHead),
    /// The owner has read an alarm and not acknowledged it.
    AlarmNotAcknowledged(AlarmHead),
}

impl Obstacle {
    /// A name that stays, for programs.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::NoExchange(_) => "Ms1NoExchange",
            Self::NotEnabled => "Ms1NotEnabled",
            Self::AlarmNotRead(_) => "AlarmNotRead",
            Self::AlarmNotAcknowledged(_) => "AlarmNotAcknowledged",
        }
    }
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoExchange(state) => {
                let waits = match state {
                    State::WaitPrm => "waits for Set_Prm",
                    State::WaitCfg => "waits for Chk_Cfg",
                    State::DataExch => "is in data exchange",
                };
                write!(
                    f,
                    "MS1 (SAP 51) is closed, the slave {waits}: records of the owner and alarms need data exchange; start the \
                     master of class 1, or open a connection (SAP 49)"
                )
            }
            Self::NotEnabled => f.write_str(
                "MS1 (SAP 51) is closed, DPV1_Enable in octet 8 of Set_Prm is 0: set the slave to DP-V1 in the master's project, \
                 or open a connection (SAP 49)",
            ),
            Self::AlarmNotRead(alarm) => {
                write!(f, "the {alarm} waits until the owner reads Slave_Diag")
            }
            Self::AlarmNotAcknowledged(alarm) => write!(
                f,
                "the {alarm} waits for its acknowledgement: the owner sends Alarm_Ack with its slot, type and sequence number to \
                 SAP 51"
            ),
        }
    }
}

/// The last service that was refused, until its master has another one carried out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LastRefused(Option<Event>);

impl LastRefused {
    /// Looks at what happened.
    pub fn notice(&mut self, event: &Event) {
        match (event, self.0) {
            (Event::Refused { .. }, _) => self.0 = Some(*event),
            (
                Event::Read { master, .. } | Event::Written { master, .. } | Event::Identified { master, .. },
                Some(Event::Refused { master: of, .. }),
            ) if of == *master => self.0 = None,
            (
                Event::Read { .. }
                | Event::Written { .. }
                | Event::Identified { .. }
                | Event::AlarmDelivered { .. }
                | Event::AlarmAcknowledged { .. }
                | Event::Opened { .. }
                | Event::Ended { .. }
                | Event::ExtPrm { .. }
                | Event::NoConnection { .. },
                _,
            ) => {}
        }
    }

    /// What was refused.
    pub(crate) const fn event(&self) -> Option<&Event> {
        self.0.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profibus::dpv1::{Channel, ErrorCode, Failure, Function};
    use crate::profibus::fdl::Address;

    #[test]
    fn a_refusal_stays_until_its_master_has_a_service_carried_out() {
        let (one, other) = (Address::from_octet(2), Address::from_octet(3));
        let refused = Event::Refused {
            master: one,
            channel: Channel::Ms1,
            function: Function::Read.number(),
            place: Some((1, 99)),
            failure: Failure::of(ErrorCode::INVALID_INDEX),
        };
        let read = |master| Event::Read { master, channel: Channel::Ms1, slot: 1, index: 10, len: 4 };
        let mut last = LastRefused::default();
        last.notice(&read(one));
        assert_eq!(last.event(), None);
        last.notice(&refused);
        last.notice(&read(other));
        assert_eq!(last.event(), Some(&refused));
        last.notice(&read(one));
        assert_eq!(last.event(), None);
    }
}
