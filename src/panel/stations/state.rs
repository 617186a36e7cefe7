//! A station from a GSD as JSON.

use serde::Serialize;
use utoipa::ToSchema;

use super::super::bus_access::BusAccess;
use super::super::state::{Counters, DpState, PresenceState, seconds};
use super::diagnosis::{Diagnosis, Possible};
use crate::gsd::Placed;
use crate::host::{GsdStation, OutputsAre};
use crate::profibus::fdl::Address;

/// The stations from GSDs of a bus.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct GsdStations {
    /// When this was so, since the bus was started.
    time_seconds: f64,
    stations: Vec<GsdStationSummary>,
}

/// What is to be known about a station at a glance.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct GsdStationSummary {
    /// Station address.
    #[schema(minimum = 0, maximum = 126)]
    address: u8,
    /// Vendor_Name.
    vendor: String,
    /// Model_Name.
    model: String,
    ident_number: u16,
    presence: PresenceState,
    dp_state: DpState,
    /// The master that owns the slave.
    owner_address: Option<u8>,
    outputs_are: OutputsName,
    /// A diagnosis is raised.
    faulty: bool,
}

/// The complete state of a station.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct GsdStationState {
    /// When this was so, since the bus was started.
    time_seconds: f64,
    #[serde(flatten)]
    summary: GsdStationSummary,
    /// The watchdog time that Set_Prm asked for; `null`: no watchdog runs.
    watchdog_milliseconds: Option<u64>,
    /// The octets of the configuration in force, else of the one that Get_Cfg reports.
    configuration: Vec<u8>,
    /// The user parameters of the last Set_Prm that was accepted.
    user_parameters: Vec<u8>,
    /// The modules of the configuration, slot by slot.
    modules: Vec<ModuleState>,
    diagnosis: Diagnosis,
    /// The newest request of a master that the station refused, and why.
    last_refusal: Option<String>,
    counters: Counters,
}

/// A module in its slot.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct ModuleState {
    /// The number of the slot.
    slot: u16,
    /// The name of the module in the GSD.
    name: String,
    /// Its octets in the configuration.
    identifiers: Vec<u8>,
    /// What the master gets, forced ones as they are forced.
    inputs: Vec<u8>,
    /// The bits of the inputs that are forced.
    forced: Vec<u8>,
    /// What the master sent; zeros in the safe state.
    outputs: Vec<u8>,
}

/// Why the outputs are what they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum OutputsName {
    /// No master exchanges data: zeros.
    Unowned,
    /// What the master sends.
    Live,
    /// The master cleared them: Global_Control with Clear_Data.
    Cleared,
    /// The master sends no outputs: Fail_Safe.
    FailSafe,
    /// The watchdog expired: zeros.
    WatchdogExpired,
}

impl From<OutputsAre> for OutputsName {
    fn from(outputs: OutputsAre) -> Self {
        match outputs {
            OutputsAre::Unowned => Self::Unowned,
            OutputsAre::Live => Self::Live,
            OutputsAre::Cleared => Self::Cleared,
            OutputsAre::FailSafe => Self::FailSafe,
            OutputsAre::WatchdogExpired => Self::WatchdogExpired,
        }
    }
}

impl GsdStations {
    pub(in crate::panel) fn of(bench: &BusAccess<'_>) -> Self {
        let summary = |address| Some(GsdStationSummary::of(bench, address, bench.bus.station(address)?));
        let stations = bench.bus.addresses().filter_map(summary).collect();
        Self { time_seconds: seconds(bench.now), stations }
    }
}

impl GsdStationSummary {
    fn of(bench: &BusAccess<'_>, address: Address, station: &GsdStation) -> Self {
        let (gsd, slave) = (station.gsd(), station.slave());
        Self {
            address: address.number(),
            vendor: gsd.vendor.clone(),
            model: gsd.model.clone(),
            ident_number: gsd.ident,
            presence: bench.bus.presence(address).into(),
            dp_state: slave.state().into(),
            owner_address: slave.owner().map(Address::number),
            outputs_are: station.outputs_are().into(),
            faulty: !station.raised().is_empty(),
        }
    }
}

impl GsdStationState {
    pub(in crate::panel) fn of(bench: &BusAccess<'_>, address: Address, station: &GsdStation) -> Self {
        let slave = station.slave();
        let watchdog = slave.watchdog().map(|(time, _)| time.as_millis());
        Self {
            time_seconds: seconds(bench.now),
            summary: GsdStationSummary::of(bench, address, station),
            watchdog_milliseconds: watchdog.map(|time| u64::try_from(time).unwrap_or(u64::MAX)),
            configuration: slave.configuration().to_vec(),
            user_parameters: slave.user_prm().to_vec(),
            modules: station.layout().iter().map(|placed| ModuleState::of(station, placed)).collect(),
            diagnosis: Diagnosis::of(station),
            last_refusal: None,
            counters: bench.bus.station_counters(address).map(Counters::from).unwrap_or_default(),
        }
    }

    /// With the newest refusal, which the station does not remember.
    pub(in crate::panel) fn with_refusal(self, last_refusal: Option<String>) -> Self {
        Self { last_refusal, ..self }
    }

    /// Whether nothing has changed but time.
    pub(in crate::panel) fn is_same(&self, other: &Self) -> bool {
        let timeless =
            |state: &Self| Self { time_seconds: 0.0, counters: Counters::default(), ..state.clone() };
        timeless(self) == timeless(other)
    }
}

impl ModuleState {
    fn of(station: &GsdStation, placed: &Placed) -> Self {
        let octets = station.slave().configuration().get(placed.octets.clone()).unwrap_or_default();
        Self {
            slot: placed.slot.number,
            name: placed.name(station.gsd()).into(),
            identifiers: octets.to_vec(),
            inputs: station.inputs(&placed.slot),
            forced: station.forced(&placed.slot).to_vec(),
            outputs: station.outputs(&placed.slot).to_vec(),
        }
    }
}

/// What a diagnosis may say, by the texts of the GSD.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct GsdTexts {
    #[serde(flatten)]
    possible: Possible,
    /// The modules of the GSD by name.
    modules: Vec<String>,
}

impl GsdTexts {
    pub(super) fn of(station: &GsdStation) -> Self {
        let modules = station.gsd().modules.iter().map(|module| module.name.clone()).collect();
        Self { possible: Possible::of(station.gsd()), modules }
    }
}
