//! The alarms of a slave: which wait for the owner, which for its acknowledgement.
//!
//! Source: `dp-v1.md` 6.2.

use core::fmt;

use heapless::Vec;
use thiserror::Error;

use super::alarm::MAX_BLOCK_DATA;
use super::{AlarmHead, AlarmOffer, AlarmType, Specifier, TypedBlock};
use crate::profibus::dp::dpv1_status::{Status1, Status2, alarm_limit};

/// An alarm that is not acknowledged yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Alarm {
    /// What names it.
    pub head: AlarmHead,
    /// What the manufacturer says about it.
    pub data: Vec<u8, MAX_BLOCK_DATA>,
    /// How far it is.
    pub state: AlarmState,
}

/// How far an alarm is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AlarmState {
    /// The owner has not read it.
    Pending,
    /// The owner has read it and not acknowledged it.
    Delivered,
}

/// Why an alarm is not raised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NotRaised {
    /// The slave exchanges no data.
    #[error("the slave is not in data exchange: start the master first")]
    NoExchange,
    /// Set_Prm did not enable DP-V1.
    #[error("the master did not enable DP-V1: DPV1_Enable in octet 8 of Set_Prm is 0")]
    NotEnabled,
    /// Set_Prm did not enable the type.
    #[error("the master did not enable this alarm: {} in octet 9 of Set_Prm is 0", .0.enabled_by().map_or("its bit", Status2::name))]
    TypeNotEnabled(AlarmType),
    /// The slave has no alarms of the type.
    #[error("the slave has no {0}: its GSD says so")]
    NotOffered(AlarmType),
    /// As many as allowed wait for an acknowledgement.
    #[error("{0} not acknowledged yet: the master takes no more")]
    Limit(Many),
    /// More octets than a block or Slave_Diag has room for.
    #[error("{got} octets of data, expected at most {most}")]
    TooLong {
        /// Octets.
        got: usize,
        /// The most.
        most: usize,
    },
}

/// `1 alarm is`, `2 alarms are`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Many(pub usize);

impl fmt::Display for Many {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 == 1 { f.write_str("1 alarm is") } else { write!(f, "{} alarms are", self.0) }
    }
}

/// The alarms, oldest first.
#[derive(Clone, Debug, Default)]
pub(super) struct Queue<const N: usize> {
    alarms: Vec<Alarm, N>,
    next: u8,
}

/// Seq_Nr counts to here.
const LAST_SEQUENCE: u8 = 31;

impl<const N: usize> Queue<N> {
    pub(super) const NONE: Self = Self { alarms: Vec::new(), next: 0 };

    pub(super) fn alarms(&self) -> &[Alarm] {
        &self.alarms
    }

    /// Takes an alarm, numbered, if the master of these DPV1_Status octets takes it.
    pub(super) fn raise(
        &mut self,
        offer: &AlarmOffer,
        status: [u8; 3],
        (kind, slot, specifier, additional_ack): (AlarmType, u8, Specifier, bool),
        data: &[u8],
    ) -> Result<AlarmHead, NotRaised> {
        let [one, two, three] = status;
        if !Status1::Enable.is_set(one) {
            return Err(NotRaised::NotEnabled);
        }
        if !offer.has(kind) {
            return Err(NotRaised::NotOffered(kind));
        }
        if kind.enabled_by().is_none_or(|bit| !bit.is_set(two)) {
            return Err(NotRaised::TypeNotEnabled(kind));
        }
        let sequence = match alarm_limit(three).filter(|_| offer.sequence >= 2) {
            Some(limit) => {
                let limit = usize::from(limit.min(offer.sequence)).min(N);
                if self.alarms.len() >= limit {
                    return Err(NotRaised::Limit(Many(limit)));
                }
                self.number()
            }
            // Pull and plug are one type.
            None if self.alarms.iter().any(|alarm| alarm.head.kind.enabled_by() == kind.enabled_by()) => {
                return Err(NotRaised::Limit(Many(1)));
            }
            None => 0,
        };
        let too_long = NotRaised::TooLong { got: data.len(), most: MAX_BLOCK_DATA };
        let data = Vec::from_slice(data).map_err(|_| too_long)?;
        let head = AlarmHead { kind, slot, sequence, additional_ack, specifier };
        let alarm = Alarm { head, data, state: AlarmState::Pending };
        self.alarms.push(alarm).map_err(|_| NotRaised::Limit(Many(N)))?;
        Ok(head)
    }

    /// A number that no alarm has.
    fn number(&mut self) -> u8 {
        while self.alarms.iter().any(|alarm| alarm.head.sequence == self.next) {
            self.next = if self.next < LAST_SEQUENCE { self.next + 1 } else { 0 };
        }
        let number = self.next;
        self.next = if number < LAST_SEQUENCE { number + 1 } else { 0 };
        number
    }

    /// The alarm that the owner reads next.
    pub(super) fn pending(&self) -> Option<(AlarmHead, TypedBlock<'_>)> {
        let alarm = self.alarms.iter().find(|alarm| alarm.state == AlarmState::Pending)?;
        Some((alarm.head, TypedBlock::Alarm { head: alarm.head, data: &alarm.data }))
    }

    /// The owner has read it.
    pub(super) fn deliver(&mut self) -> Option<AlarmHead> {
        let alarm = self.alarms.iter_mut().find(|alarm| alarm.state == AlarmState::Pending)?;
        alarm.state = AlarmState::Delivered;
        Some(alarm.head)
    }

    /// The owner acknowledges an alarm; `None` if it has read none that is meant.
    pub(super) fn acknowledge(&mut self, ack: AlarmHead) -> Option<AlarmHead> {
        let means = |alarm: &Alarm| alarm.state == AlarmState::Delivered && ack.means(alarm.head);
        let at = self.alarms.iter().position(means)?;
        Some(self.alarms.remove(at).head)
    }

    pub(super) fn forget(&mut self) {
        self.alarms.clear();
        self.next = 0;
    }
}
