//! The complete state of a drive as JSON.

use std::format;
use std::prelude::v1::*;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::inputs::PlantInputs;
use super::parameters::ParameterState;
use super::switches::Switches;
use super::words::{self, Ppo, Words};
use crate::device::{Device, EepromState, Power};
use crate::dp;
use crate::drive::{self, Fault, Mode, Motor, StatusLed, leds};
use crate::fdl::StationCounters;
use crate::host::Presence;
use crate::param::{Gear, Model, Parameter};
use crate::time::Instant;

/// Increments per revolution of the output shaft (manual chapter 2.6).
const INCREMENTS_PER_REVOLUTION: f64 = 1600.0;

/// What is to be known about a drive at a glance.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct DriveSummary {
    /// Station address.
    #[schema(minimum = 0, maximum = 126)]
    pub(super) address: u8,
    model: ModelName,
    /// 24 or 48: turns of the motor per turn of the shaft.
    gear_ratio: u16,
    power: PowerState,
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
    /// Actual position in user units: increments, or 0.01 mm with a spindle pitch.
    position_user_units: i32,
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
    /// What stands against a start now.
    start: Start,
    /// The newest request of the master that the drive refused, and why.
    pub(super) last_refusal: Option<LastRefusal>,
    switches: Switches,
    keys: super::inputs::Keys,
    inputs: PlantInputs,
    eeprom: EepromName,
    pub(super) counters: Counters,
    /// Every parameter of the model. Not in the live stream.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) parameters: Option<Vec<ParameterState>>,
}

/// A model as it is named in JSON and on the command line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub(super) enum ModelName {
    #[serde(rename = "ag03")]
    Ag03,
    #[default]
    #[serde(rename = "ag03-1")]
    Ag03_1,
}

/// Whether it has control supply.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum PowerState {
    Off,
    On,
    /// Switched on with the DIP switches of a factory reset: only the LEDs work.
    FactoryReset,
}

/// Whether the station takes part on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum PresenceState {
    Active,
    /// Listens whether somebody else has its address.
    Joining,
    /// Somebody else has its address.
    Refused,
}

/// The state of the DP slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(super) enum DpState {
    #[serde(rename = "WAIT-PRM")]
    WaitPrm,
    #[serde(rename = "WAIT-CFG")]
    WaitCfg,
    #[serde(rename = "DATA-EXCH")]
    DataExch,
}

/// The operating mode, PNU 930.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum ModeName {
    Positioning,
    Velocity,
}

/// A fault by its letter; H and I exist only on CANopen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub(super) enum FaultName {
    A,
    B,
    C,
    D,
    E,
    F,
    G,
    J,
}

/// One LED, now and over time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Led {
    /// Lit now.
    lit: bool,
    pattern: LedPattern,
    /// How often it blinks before the pause; 0 unless it blinks.
    blinks: u8,
    on_milliseconds: u32,
    off_milliseconds: u32,
    /// Dark after the last blink, in addition to `off_milliseconds`.
    pause_milliseconds: u32,
    /// How long ago the sequence of blinks began that runs now; 0 unless it blinks.
    phase_milliseconds: u32,
}

/// What an LED does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum LedPattern {
    Off,
    On,
    /// A number of blinks, then a pause: the code of a fault.
    Blinking,
    /// Both LEDs in turn: a factory reset.
    Alternating,
}

/// The DP slave.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct Dp {
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

/// Where the shaft is and what moves it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct Motion {
    position_user_units: i32,
    /// `increments`, or `hundredth_millimetres` with a spindle pitch (PNU 1012).
    user_unit: &'static str,
    /// The angle of the output shaft since its encoder is 0; counter-clockwise counts positive with sense of rotation i.
    shaft_revolutions: f64,
    velocity_rpm: i32,
    /// HSW of the master: user units, or rpm in velocity mode.
    setpoint: i32,
    upper_limit_user_units: i32,
    lower_limit_user_units: i32,
    motor: MotorName,
    /// Turns with 2 rpm or more.
    travelling: bool,
    /// Turns at all.
    moving: bool,
    job_active: bool,
    in_window: bool,
    target_reached: bool,
}

/// What the output stage does with the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum MotorName {
    Released,
    InControl,
    Shorted,
}

/// What the drive measures.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct Measured {
    current_milliamperes: i16,
    stage_temperature_celsius: f64,
    control_supply_volts: f64,
    output_supply_volts: f64,
    battery_volts: f64,
    dc_link_volts: f64,
}

/// Warnings: they vanish by themselves (manual chapter 5.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
struct Warnings {
    battery_low: bool,
    current_out_of_range: bool,
    lag_error: bool,
}

/// Faults, latched and remembered.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct Faults {
    /// The latched fault, of several the latest.
    latched: Option<FaultText>,
    /// The causes that are present now: they must go before a fault can be acknowledged.
    causes: Vec<FaultText>,
    /// PNU 945: the last ten, in the order the drive lists them.
    buffer: Vec<FaultText>,
    /// PNU 952.
    count: u16,
}

/// A fault in words.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct FaultText {
    code: FaultName,
    text: String,
    /// How often the status LED blinks for it.
    blinks: u8,
}

/// What stands against a start (an edge of STW.6, in velocity mode its level).
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct Start {
    /// A start with the newest outputs would be carried out.
    possible: bool,
    reasons: Vec<ReasonText>,
}

/// One condition that is not met.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct ReasonText {
    /// A name that stays, for programs.
    reason: String,
    /// A sentence with numbers.
    text: String,
}

/// A request that was refused.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct LastRefusal {
    pub(super) time_seconds: f64,
    /// One line: the request and every unmet condition.
    text: String,
    reasons: Vec<ReasonText>,
}

/// How safe what the EEPROM holds is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum EepromName {
    /// Without a state directory: kept as long as the process runs.
    InMemory,
    /// The newest values are being written.
    Writing,
    /// Everything is in the file.
    Stored,
    /// The file could not be written.
    Failed,
}

/// What the station was asked and answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub(super) struct Counters {
    requests: u64,
    retries: u64,
    replies: u64,
    replies_too_late: u64,
    watchdog_expiries: u64,
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
            owner_address: device.slave().owner().map(crate::fdl::Address::number),
            mode: status.mode.into(),
            state: words::state(status.state),
            stw: words::outputs(device).stw().raw(),
            zsw: config.words.zsw(status).raw(),
            position_user_units: status.position,
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
}

impl DriveSummary {
    /// Without what changes though nothing happens.
    pub(super) fn timeless(&self) -> Self {
        let mut summary = self.clone();
        summary.status_led.phase_milliseconds = 0;
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
            warnings: Warnings {
                battery_low: status.battery_low,
                current_out_of_range: status.current_out_of_range,
                lag_error: status.lag_error,
            },
            faults: Faults::of(device.drive()),
            start: Start::of(device),
            last_refusal: None,
            switches: Switches::of(device),
            keys: device.inputs().into(),
            inputs: device.inputs().into(),
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
            state.dp.watchdog_remaining_milliseconds = None;
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

impl Dp {
    fn of(device: &Device, now: Instant) -> Self {
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
}

impl Motion {
    fn of(device: &Device) -> Self {
        let status = device.status();
        let store = device.parameters();
        let limits = [store.value(Parameter::Limit1), store.value(Parameter::Limit2)];
        let [low, high] = if limits.is_sorted() { limits } else { [limits[1], limits[0]] };
        Self {
            position_user_units: status.position,
            user_unit: match store.value(Parameter::SpindlePitch) {
                0 => "increments",
                _pitch => "hundredth_millimetres",
            },
            shaft_revolutions: device.drive().shaft() / INCREMENTS_PER_REVOLUTION,
            velocity_rpm: status.velocity,
            setpoint: words::outputs(device).hsw(),
            upper_limit_user_units: high,
            lower_limit_user_units: low,
            motor: status.motor.into(),
            travelling: status.travelling,
            moving: status.moving,
            job_active: status.job_active,
            in_window: status.in_window,
            target_reached: status.target_reached,
        }
    }
}

impl Measured {
    fn of(measured: &drive::Measured) -> Self {
        Self {
            current_milliamperes: measured.current,
            stage_temperature_celsius: f64::from(measured.temperature) / 10.0,
            control_supply_volts: f64::from(measured.control_supply) / 10.0,
            output_supply_volts: f64::from(measured.output_supply) / 10.0,
            battery_volts: f64::from(measured.battery) / 100.0,
            dc_link_volts: f64::from(measured.dc_link) / 10.0,
        }
    }
}

impl Faults {
    fn of(drive: &drive::Drive) -> Self {
        let of_code = |code: u8| Fault::ALL.into_iter().find(|fault| fault.code() == code);
        Self {
            latched: drive.status().fault.map(FaultText::from),
            causes: drive.causes().iter().map(FaultText::from).collect(),
            buffer: drive.fault_codes().into_iter().filter_map(of_code).map(FaultText::from).collect(),
            count: drive.faults().count(),
        }
    }
}

impl Start {
    fn of(device: &Device) -> Self {
        let mut reasons: Vec<_> = device.start_refusal().as_ref().map(reasons_of).unwrap_or_default();
        if device.dp_state() != dp::State::DataExch {
            let text = "no master exchanges data with the drive".into();
            reasons.insert(0, ReasonText { reason: "NoDataExchange".into(), text });
        }
        Self { possible: reasons.is_empty(), reasons }
    }
}

impl LastRefusal {
    pub(super) fn of(refusal: &drive::Refusal, at: Instant) -> Self {
        Self { time_seconds: seconds(at), text: refusal.to_string(), reasons: reasons_of(refusal) }
    }
}

pub(super) fn reasons_of(refusal: &drive::Refusal) -> Vec<ReasonText> {
    let text = |reason| ReasonText { reason: format!("{reason:?}"), text: refusal.text(reason).to_string() };
    refusal.reasons().map(text).collect()
}

impl Led {
    fn status(device: &Device, now: Instant) -> Self {
        let leds = device.leds(now);
        let steady = |pattern| Self::steady(leds.status, pattern);
        match (device.power(), leds.pattern) {
            (Power::FactoryReset(_), _) => steady(LedPattern::Alternating),
            (Power::Off | Power::On, StatusLed::Off) => steady(LedPattern::Off),
            (Power::Off | Power::On, StatusLed::On) => steady(LedPattern::On),
            (Power::Off | Power::On, StatusLed::Blinking(fault)) => {
                let blinks = fault.blinks();
                let sequence = (leds::BLINK_ON + leds::BLINK_OFF) * u32::from(blinks) + leds::BLINK_PAUSE;
                let phase = device.blink_time(now).as_nanos().checked_rem(sequence.as_nanos()).unwrap_or(0);
                Self {
                    blinks,
                    phase_milliseconds: u32::try_from(phase / 1_000_000).unwrap_or(0),
                    ..steady(LedPattern::Blinking)
                }
            }
        }
    }

    fn bus(device: &Device, now: Instant) -> Self {
        let lit = device.leds(now).bus;
        Self::steady(
            lit,
            match (device.power(), lit) {
                (Power::FactoryReset(_), _) => LedPattern::Alternating,
                (Power::Off | Power::On, true) => LedPattern::On,
                (Power::Off | Power::On, false) => LedPattern::Off,
            },
        )
    }

    fn steady(lit: bool, pattern: LedPattern) -> Self {
        let milliseconds = |time: core::time::Duration| u32::try_from(time.as_millis()).unwrap_or(u32::MAX);
        Self {
            lit,
            pattern,
            blinks: 0,
            on_milliseconds: milliseconds(leds::BLINK_ON),
            off_milliseconds: milliseconds(leds::BLINK_OFF),
            pause_milliseconds: milliseconds(leds::BLINK_PAUSE),
            phase_milliseconds: 0,
        }
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

impl From<Fault> for FaultText {
    fn from(fault: Fault) -> Self {
        Self { code: fault.into(), text: fault.to_string(), blinks: fault.blinks() }
    }
}

impl From<Fault> for FaultName {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::A => Self::A,
            Fault::B => Self::B,
            Fault::C => Self::C,
            Fault::D => Self::D,
            Fault::E => Self::E,
            Fault::F => Self::F,
            Fault::G => Self::G,
            Fault::J => Self::J,
        }
    }
}

impl From<FaultName> for Fault {
    fn from(name: FaultName) -> Self {
        match name {
            FaultName::A => Self::A,
            FaultName::B => Self::B,
            FaultName::C => Self::C,
            FaultName::D => Self::D,
            FaultName::E => Self::E,
            FaultName::F => Self::F,
            FaultName::G => Self::G,
            FaultName::J => Self::J,
        }
    }
}

impl From<Model> for ModelName {
    fn from(model: Model) -> Self {
        match model {
            Model::Ag03 => Self::Ag03,
            Model::Ag03_1 => Self::Ag03_1,
        }
    }
}

impl From<ModelName> for Model {
    fn from(name: ModelName) -> Self {
        match name {
            ModelName::Ag03 => Self::Ag03,
            ModelName::Ag03_1 => Self::Ag03_1,
        }
    }
}

/// The gear of a ratio.
pub(super) fn gear(ratio: u16) -> Option<Gear> {
    Gear::ALL.into_iter().find(|gear| gear.ratio() == ratio)
}

impl From<Power> for PowerState {
    fn from(power: Power) -> Self {
        match power {
            Power::Off => Self::Off,
            Power::On => Self::On,
            Power::FactoryReset(_) => Self::FactoryReset,
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

impl From<Mode> for ModeName {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Positioning => Self::Positioning,
            Mode::Velocity => Self::Velocity,
        }
    }
}

impl From<Motor> for MotorName {
    fn from(motor: Motor) -> Self {
        match motor {
            Motor::Released => Self::Released,
            Motor::InControl => Self::InControl,
            Motor::Shorted => Self::Shorted,
        }
    }
}

impl From<EepromState> for EepromName {
    fn from(state: EepromState) -> Self {
        match state {
            EepromState::Internal => Self::InMemory,
            EepromState::Writing => Self::Writing,
            EepromState::Safe => Self::Stored,
            EepromState::Failed => Self::Failed,
        }
    }
}
