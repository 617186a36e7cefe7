//! The station on the line and its DP slave.

use serde::Serialize;
use utoipa::ToSchema;

use crate::devices::ag03::profibus::Device;
use crate::host::Presence;
use crate::profibus::dp;
use crate::profibus::fdl::StationCounters;
use crate::time::Instant;

/// Whether the station takes part on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::panel) enum PresenceState {
    Active,
    /// Listens whether somebody else has its address.
    Joining,
    /// Somebody else has its address.
    Refused,
}

/// The state of the DP slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(in crate::panel) enum DpState {
    #[serde(rename = "WAIT-PRM")]
    WaitPrm,
    #[serde(rename = "WAIT-CFG")]
    WaitCfg,
    #[serde(rename = "DATA-EXCH")]
    DataExch,
}

/// The DP slave.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Dp {
    /// The watchdog time that Set_Prm asked for; `null`: no watchdog runs.
    watchdog_milliseconds: Option<u64>,
    /// Until it expires if the master stays silent.
    watchdog_remaining_milliseconds: Option<u64>,
    /// The min T_SDR that Set_Prm asked for, in bit times.
    min_tsdr_bit_times: Option<u8>,
    ident_number: u16,
    /// The octets of the accepted configuration.
    configuration: Vec<u8>,
    /// The six octets of Slave_Diag.
    diagnosis: Vec<u8>,
    station_not_ready: bool,
    prm_fault: bool,
    cfg_fault: bool,
    not_supported: bool,
    sync_mode: bool,
    freeze_mode: bool,
}

/// What the station was asked and answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub(in crate::panel) struct Counters {
    requests: u64,
    retries: u64,
    replies: u64,
    replies_too_late: u64,
    watchdog_expiries: u64,
}

impl Dp {
    pub(super) fn of(device: &Device, now: Instant) -> Self {
        let slave = device.slave();
        let diagnosis = slave.diagnosis();
        let milliseconds = |time: core::time::Duration| u64::try_from(time.as_millis()).unwrap_or(u64::MAX);
        let watchdog = slave.watchdog();
        Self {
            watchdog_milliseconds: watchdog.map(|(time, _)| milliseconds(time)),
            watchdog_remaining_milliseconds: watchdog
                .map(|(_, expires)| milliseconds(expires.saturating_since(now))),
            min_tsdr_bit_times: slave.min_tsdr(),
            ident_number: slave.description().ident,
            configuration: slave.configuration().to_vec(),
            diagnosis: diagnosis.octets().to_vec(),
            station_not_ready: diagnosis.station_not_ready,
            prm_fault: diagnosis.prm_fault,
            cfg_fault: diagnosis.cfg_fault,
            not_supported: diagnosis.not_supported,
            sync_mode: diagnosis.sync_mode,
            freeze_mode: diagnosis.freeze_mode,
        }
    }

    /// Without what changes though nothing happens.
    pub(super) fn timeless(self) -> Self {
        Self { watchdog_remaining_milliseconds: None, ..self }
    }
}

impl From<&StationCounters> for Counters {
    fn from(counters: &StationCounters) -> Self {
        Self {
            requests: counters.requests.total(),
            retries: counters.retries,
            replies: counters.replies,
            replies_too_late: counters.too_late,
            watchdog_expiries: counters.watchdog_expiries,
        }
    }
}

impl From<Option<Presence>> for PresenceState {
    fn from(presence: Option<Presence>) -> Self {
        match presence {
            Some(Presence::Active) => Self::Active,
            Some(Presence::Joining) => Self::Joining,
            Some(Presence::Refused) | None => Self::Refused,
        }
    }
}

impl From<dp::State> for DpState {
    fn from(state: dp::State) -> Self {
        match state {
            dp::State::WaitPrm => Self::WaitPrm,
            dp::State::WaitCfg => Self::WaitCfg,
            dp::State::DataExch => Self::DataExch,
        }
    }
}
