//! What a slave offers of DP-V1: for a station from a GSD, what its keywords promise.

use super::{AlarmType, MAX_DATA};
use crate::profibus::dp::dpv1_status::Status2;

/// What a slave offers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Offer {
    /// C1_Read_Write_supp with C1_Max_Data_Len: the owner reads and writes records of up to so many octets.
    pub ms1: Option<u8>,
    /// C2_Read_Write_supp: connections.
    pub ms2: Option<Ms2Offer>,
    /// Which alarms there are.
    pub alarms: AlarmOffer,
}

/// What connections a slave offers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ms2Offer {
    /// C2_Max_Count_Channels: how many at once.
    pub connections: u8,
    /// C2_Max_Data_Len: the most octets of a record.
    pub max_data: u8,
    /// Max_Initiate_PDU_Length.
    pub max_initiate: u8,
    /// The least Send_Timeout, times 10 ms. A connection that was offered is kept three times as long for the master that
    /// asked for it: with 0 no master gets one.
    pub min_send_timeout: u16,
}

/// Which alarms a slave has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AlarmOffer {
    /// The types, as bits of DPV1_Status_2: `*_Alarm_supp`.
    pub types: u8,
    /// Alarm_Sequence_Mode_Count: how many at once in sequence mode; less than 2: it has none.
    pub sequence: u8,
    /// Extra_Alarm_SAP_supp: acknowledged at SAP 50, too.
    pub extra_sap: bool,
}

impl Offer {
    /// Nothing: a slave of DP-V0.
    pub const NONE: Self = Self { ms1: None, ms2: None, alarms: AlarmOffer::NONE };

    /// Whether the slave offers anything.
    pub const fn is_none(&self) -> bool {
        self.ms1.is_none() && self.ms2.is_none()
    }
}

impl Ms2Offer {
    /// One connection, records of any length, a Send_Timeout of a second.
    pub const PLAIN: Self =
        Self { connections: 1, max_data: MAX_DATA, max_initiate: 52, min_send_timeout: 100 };
}

impl AlarmOffer {
    /// No alarms.
    pub const NONE: Self = Self { types: 0, sequence: 0, extra_sap: false };

    /// Whether alarms of this type are among them.
    pub fn has(&self, kind: AlarmType) -> bool {
        kind.enabled_by().is_some_and(|bit: Status2| bit.is_set(self.types))
    }
}
