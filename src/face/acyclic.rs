//! What a master reaches beside the cyclic exchange: records by slot and index, alarms, identification, connections.

use super::Reason;
use super::description::Denied;
use crate::profibus::dpv1::{AlarmHead, AlarmState, AlarmType, Link, NotRaised, Specifier, StatusType};
use crate::time::Instant;

/// A record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record<'a> {
    /// Its slot: 0 the station, from 1 its modules.
    pub slot: u8,
    /// Its index.
    pub index: u8,
    /// What is in it.
    pub data: &'a [u8],
    /// A master can read it.
    pub read: bool,
    /// A master can write it.
    pub write: bool,
}

/// An alarm that is to be raised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NewAlarm<'a> {
    /// What kind.
    pub kind: AlarmType,
    /// Of which slot.
    pub slot: u8,
    /// Whether it begins or ends.
    pub specifier: Specifier,
    /// Add_Ack: the user of the master shall acknowledge it, too.
    pub additional_ack: bool,
    /// What the manufacturer says about it, at most 59 octets.
    pub data: &'a [u8],
}

/// A status message that is to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NewStatus<'a> {
    /// What kind.
    pub kind: StatusType,
    /// Of which slot.
    pub slot: u8,
    /// Whether it begins or ends.
    pub specifier: Specifier,
    /// What it says, at most 59 octets.
    pub data: &'a [u8],
}

/// The name of the last service that was refused, among what keeps a master from services.
pub(crate) const SERVICE_REFUSED: &str = "ServiceRefused";

/// The channel of the owner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OwnersChannel {
    /// The owner can use it now.
    pub open: bool,
    /// A request of the owner is being carried out.
    pub busy: bool,
}

/// What a device has beside its cyclic exchange. What is not said otherwise, it does not have.
pub trait Acyclic {
    /// The channel of the owner.
    fn channel(&self) -> OwnersChannel;

    /// What keeps masters from its services now, or waits for a master.
    fn each_obstacle(&self, _tell: &mut dyn FnMut(Reason<'_>)) {}

    /// Each connection of a master of class 2.
    fn each_link(&self, _tell: &mut dyn FnMut(Link)) {}

    /// How many connections there can be.
    fn most_links(&self) -> u8 {
        0
    }

    /// Each record, by slot and index.
    fn each_record(&self, _tell: &mut dyn FnMut(Record<'_>)) {}

    /// The device changes what is in a record, also in one that a master cannot write.
    ///
    /// # Errors
    /// [`Denied::Unknown`] if there is none, [`Denied::Value`] if it has another number of octets; nothing is changed then.
    fn change_record(
        &mut self,
        _now: Instant,
        (_slot, _index): (u8, u8),
        _data: &[u8],
    ) -> Result<(), Denied> {
        Err(Denied::Unknown)
    }

    /// Each block of identification and maintenance: its number, 0 for I&M0, its octets, and whether a master can write it.
    fn each_identification(&self, _tell: &mut dyn FnMut(u16, &[u8; 64], bool)) {}

    /// Each type of alarm that the device has.
    fn each_alarm_type(&self, _tell: &mut dyn FnMut(AlarmType)) {}

    /// Each alarm that is not acknowledged, the oldest first, with what the manufacturer says about it.
    fn each_alarm(&self, _tell: &mut dyn FnMut(AlarmHead, &[u8], AlarmState)) {}

    /// Raises an alarm.
    ///
    /// # Errors
    /// [`NotRaised`]
    fn raise_alarm(&mut self, _now: Instant, alarm: &NewAlarm<'_>) -> Result<AlarmHead, NotRaised> {
        Err(NotRaised::NotOffered(alarm.kind))
    }

    /// Forgets every alarm, as if none had been raised.
    fn forget_alarms(&mut self, _now: Instant) {}

    /// Sends a status message, which nobody acknowledges.
    ///
    /// # Errors
    /// [`NotRaised`]
    fn send_status(&mut self, _now: Instant, _status: &NewStatus<'_>) -> Result<(), NotRaised> {
        Err(NotRaised::NotEnabled)
    }
}
