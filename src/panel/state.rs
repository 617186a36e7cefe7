//! The complete state of a drive as JSON.

mod fault;
mod led;
mod motion;
mod names;
mod slave;

use serde::Serialize;
use utoipa::ToSchema;

use super::inputs::{self, InputRange, InputValues, PowerName};
use super::parameters::ParameterState;
use super::switches::Switches;
use super::words::{self, Ppo, Words};
use crate::devices::ag03::profibus::Device;
use crate::host::Presence;
use crate::profibus::fdl::{Address, StationCounters};
use crate::time::Instant;
use fault::{Faults, Start, Warnings};
use led::Led;
use motion::Measured;
use names::{EepromName, ModeName};
use slave::Dp;

pub(super) use fault::{FaultName, LastRefusal, ReasonText, next_of, reasons_of};
pub(super) use motion::{Motion, lengths};
pub(super) use names::{ModelName, gear};
pub(super) use slave::{Counters, DpState, PresenceState};

/// What is to be known about a drive at a glance.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct DriveSummary {
    /// Station address.
    #[schema(minimum = 0, maximum = 126)]
    pub(super) address: u8,
    model: ModelName,
    /// 24 or 48: turns of the motor per turn of the shaft.
    gear_ratio: u16,
    power: PowerName,
    presence: PresenceState,
    dp_state: DpState,
    /// The master that owns the slave.
    owner_address: Option<u8>,
    mode: ModeName,
    /// The state of the drive, `ag03.md` section 8.
    state: &'static str,
    /// STW as the drive has seen it last.
    #[schema(minimum = 0, maximum = 65535)]
    stw: u16,
    #[schema(minimum = 0, maximum = 65535)]
    zsw: u16,
    /// The system status word, PNU 1020; says which warning there is.
    #[schema(minimum = 0, maximum = 65535)]
    ssw: u16,
    /// Actual position in user units.
    position_user_units: i32,
    /// `increments`, or `hundredth_millimetres` with a spindle pitch (PNU 1012).
    user_unit: &'static str,
    velocity_rpm: i32,
    current_milliamperes: i16,
    operation_enabled: bool,
    travelling: bool,
    warning: bool,
    fault: Option<FaultName>,
    status_led: Led,
    bus_led: Led,
}

/// The complete state of a drive.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct DriveState {
    /// When this was so, since the bus was started.
    pub(super) time_seconds: f64,
    #[serde(flatten)]
    pub(super) summary: DriveSummary,
    dp: Dp,
    ppo: Ppo,
    words: Words,
    motion: Motion,
    measured: Measured,
    warnings: Warnings,
    faults: Faults,
    /// The reasons why a start is not possible now.
    start: Start,
    /// The newest request of the master that the drive refused, and why.
    pub(super) last_refusal: Option<LastRefusal>,
    switches: Switches,
    keys: HeldKeys,
    inputs: InputValues,
    input_ranges: Vec<InputRange>,
    eeprom: EepromName,
    pub(super) counters: Counters,
    /// Every parameter of the model. Not in the live stream.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) parameters: Option<Vec<ParameterState>>,
}

/// The keys of the manual setup mode (manual chapter 2.2.1.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
struct HeldKeys {
    /// Key 1, on an AG03 "right": clockwise.
    key_1_pressed: bool,
    /// Key 2, on an AG03 "left": counter-clockwise.
    key_2_pressed: bool,
}

impl HeldKeys {
    fn of(device: &Device) -> Self {
        let inputs = device.inputs();
        Self { key_1_pressed: inputs.key_clockwise, key_2_pressed: inputs.key_counter_clockwise }
    }
}

impl DriveSummary {
    pub(super) fn of(device: &Device, presence: Option<Presence>, now: Instant) -> Self {
        let status = device.status();
        let config = device.config();
        Self {
            address: device.address().number(),
            model: config.model.into(),
            gear_ratio: config.gear.ratio(),
            power: device.power().into(),
            presence: presence.into(),
            dp_state: device.dp_state().into(),
            owner_address: device.slave().owner().map(Address::number),
            mode: status.mode.into(),
            state: words::state(status.state),
            stw: words::outputs(device).stw().raw(),
            zsw: device.zsw().raw(),
            ssw: device.system_status(),
            position_user_units: status.position,
            user_unit: motion::user_unit(device),
            velocity_rpm: status.velocity,
            current_milliamperes: device.drive().measured().current,
            operation_enabled: status.operation_enabled,
            travelling: status.travelling,
            warning: status.warning,
            fault: status.fault.map(FaultName::from),
            status_led: Led::status(device, now),
            bus_led: Led::bus(device, now),
        }
    }

    /// Without what changes though nothing happens.
    pub(super) fn timeless(&self) -> Self {
        let mut summary = self.clone();
        summary.status_led = summary.status_led.timeless();
        summary
    }
}

impl DriveState {
    /// Without parameters and the last refusal, which the device does not remember.
    pub(super) fn of(
        device: &Device,
        presence: Option<Presence>,
        counters: Option<&StationCounters>,
        now: Instant,
    ) -> Self {
        let status = device.status();
        Self {
            time_seconds: seconds(now),
            summary: DriveSummary::of(device, presence, now),
            dp: Dp::of(device, now),
            ppo: Ppo::of(device),
            words: Words::of(device),
            motion: Motion::of(device),
            measured: Measured::of(&device.drive().measured()),
            warnings: Warnings::of(status),
            faults: Faults::of(device),
            start: Start::of(device),
            last_refusal: None,
            switches: Switches::of(device),
            keys: HeldKeys::of(device),
            inputs: InputValues::of(device),
            input_ranges: inputs::ranges(device),
            eeprom: device.eeprom_state().into(),
            counters: counters.map(Counters::from).unwrap_or_default(),
            parameters: None,
        }
    }

    /// Whether nothing has changed but time.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let timeless = |state: &Self| {
            let mut state = state.clone();
            state.time_seconds = 0.0;
            state.counters = Counters::default();
            state.dp = state.dp.timeless();
            state.summary = state.summary.timeless();
            state
        };
        timeless(self) == timeless(other)
    }

    /// The same with every parameter.
    pub(super) fn with_parameters(self, device: &Device) -> Self {
        Self { parameters: Some(super::parameters::all(device)), ..self }
    }
}

/// The time on the clock of the bus.
pub(super) fn seconds(now: Instant) -> f64 {
    // Of nanoseconds a reader has nothing, and digits that are none.
    (now.as_nanos() / 1000) as f64 / 1e6
}
