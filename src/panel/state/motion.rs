//! Where the shaft is, what moves it, and what the drive measures.

use serde::Serialize;
use utoipa::ToSchema;

use super::super::words;
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::{INCREMENTS_PER_REVOLUTION, Mode, Motor, State};
use crate::devices::ag03::param::Parameter;
use crate::devices::ag03::profibus::Device;
use crate::explain::value::Lengths;

/// Where the shaft is and what moves it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct Motion {
    position_user_units: i32,
    /// `increments`, or `hundredth_millimetres` with a spindle pitch (PNU 1012).
    user_unit: &'static str,
    /// The angle of the output shaft since its encoder is 0; counter-clockwise counts positive with sense of rotation i.
    shaft_revolutions: f64,
    velocity_rpm: i32,
    /// HSW of the master in positioning mode.
    setpoint_user_units: Option<i32>,
    /// HSW of the master in velocity mode.
    setpoint_rpm: Option<i32>,
    /// The target of the job in progress or paused, whatever HSW is meanwhile; `null`: there is none.
    target_user_units: Option<i32>,
    /// From the position to that target, with its sign.
    distance_to_go_user_units: Option<i64>,
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
pub(super) enum MotorName {
    Released,
    InControl,
    Shorted,
}

/// What the drive measures.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Measured {
    current_milliamperes: i16,
    stage_temperature_celsius: f64,
    control_supply_volts: f64,
    output_supply_volts: f64,
    battery_volts: f64,
    dc_link_volts: f64,
}

impl Motion {
    pub(super) fn of(device: &Device) -> Self {
        let status = device.status();
        let store = device.parameters();
        let limits = [store.value(Parameter::Limit1), store.value(Parameter::Limit2)];
        let setpoint = words::outputs(device).hsw();
        let (setpoint_user_units, setpoint_rpm) = match status.mode {
            Mode::Positioning => (Some(setpoint), None),
            Mode::Velocity => (None, Some(setpoint)),
        };
        let target = device.drive().target();
        let [low, high] = if limits.is_sorted() { limits } else { [limits[1], limits[0]] };
        Self {
            position_user_units: status.position,
            user_unit: user_unit(device),
            shaft_revolutions: device.drive().shaft() / INCREMENTS_PER_REVOLUTION,
            velocity_rpm: status.velocity,
            setpoint_user_units,
            setpoint_rpm,
            target_user_units: target,
            distance_to_go_user_units: target.map(|target| i64::from(target) - i64::from(status.position)),
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

    /// What the drive counts positions in, for programs.
    pub(in crate::panel) fn unit_of(device: &Device) -> &'static str {
        user_unit(device)
    }

    /// The setpoint of velocity mode while it is released.
    pub(in crate::panel) fn released_rpm(device: &Device) -> Option<i32> {
        let released = device.status().state == State::VelocityTravelling;
        released.then(|| words::outputs(device).hsw())
    }
}

/// What the drive counts positions in.
pub(in crate::panel) fn lengths(device: &Device) -> Lengths {
    Lengths::of_spindle_pitch(device.parameters().value(Parameter::SpindlePitch).cast_unsigned())
}

/// What the drive counts positions in, for programs.
pub(super) fn user_unit(device: &Device) -> &'static str {
    match lengths(device) {
        Lengths::Unknown | Lengths::Increments => "increments",
        Lengths::HundredthMillimetres => "hundredth_millimetres",
    }
}

impl Measured {
    pub(super) fn of(measured: &drive::Measured) -> Self {
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

impl From<Motor> for MotorName {
    fn from(motor: Motor) -> Self {
        match motor {
            Motor::Released => Self::Released,
            Motor::InControl => Self::InControl,
            Motor::Shorted => Self::Shorted,
        }
    }
}
