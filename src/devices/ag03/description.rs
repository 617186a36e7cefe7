//! What a drive tells of itself on either bus: its values, its state in words, its switches.

use core::fmt;

use super::drive::{Drive, Fault, INCREMENTS_PER_REVOLUTION, Motor, State, Status};
use super::param::{Lengths, Model};
use super::unit::dip::{ResetPatterns, Terminator};
use super::unit::{DipSwitches, EepromState};
use crate::face::description::{Amount, Curve, Group, Past, Switches, Value};

/// A drive as it is now, on either bus.
#[derive(Clone, Copy)]
pub(super) struct Observed<'a> {
    pub(super) model: Model,
    pub(super) drive: &'a Drive,
    pub(super) status: &'a Status,
    /// The setpoint of velocity mode while it is released.
    pub(super) released_rpm: Option<i32>,
}

/// A length as people read it, with its unit: the drive counts increments, or hundredths of a millimetre.
pub(super) fn length(lengths: Lengths, number: Option<i64>) -> (Amount<'static>, &'static str, u8) {
    #[expect(clippy::cast_precision_loss, reason = "no position has more than 32 bits")]
    let number = number.map(|number| number as f64);
    match lengths {
        Lengths::HundredthMillimetres => (number.map(|number| number / 100.0).into(), "mm", 2),
        Lengths::Increments | Lengths::Unknown => (number.into(), "inc", 0),
    }
}

fn tenths(number: impl Into<f64>) -> Amount<'static> {
    Amount::Number(number.into() / 10.0)
}

impl Observed<'_> {
    /// Each value, the most important first.
    pub(super) fn each_value(&self, tell: &mut dyn FnMut(Value<'_>)) {
        self.each_of_motion(tell);
        self.each_measured(tell);
    }

    fn length(&self, key: &'static str, name: &'static str, number: Option<i64>) -> Value<'static> {
        let (amount, unit, digits) = length(self.drive.lengths(), number);
        Value::new(key, name, Group::Motion, amount).unit(unit).digits(digits)
    }

    fn each_of_motion(&self, tell: &mut dyn FnMut(Value<'_>)) {
        let Self { drive, status, .. } = self;
        let (position, target) = (i64::from(status.position), drive.target().map(i64::from));
        let rpm = |key, name, rpm| Value::new(key, name, Group::Motion, rpm).unit("rpm");
        tell(self.length("position", "Position", Some(position)).curve(Curve::Own).headline());
        tell(rpm("speed", "Speed", Amount::Number(status.velocity.into())).curve(Curve::Own).headline());
        // Of the job in progress: what HSW is meanwhile is a number on the bus and no target.
        tell(self.length("target", "Target", target).curve(Curve::SetpointOf("position")));
        tell(self.length("to_go", "To go", target.map(|target| target - position)));
        let released = self.released_rpm.map(f64::from);
        tell(rpm("speed_setpoint", "Speed setpoint", released.into()).curve(Curve::SetpointOf("speed")));
        // Counter-clockwise counts positive there, clockwise here.
        let turns = Amount::Number(-drive.shaft() / INCREMENTS_PER_REVOLUTION);
        tell(Value::new("shaft", "Shaft", Group::Motion, turns).unit("turns").digits(2));
    }

    fn each_measured(&self, tell: &mut dyn FnMut(Value<'_>)) {
        let measured = self.drive.measured();
        let value = |key, name, amount| Value::new(key, name, Group::Measured, amount);
        let current = value("current", "Current", Amount::Number(measured.current.into())).unit("mA");
        tell(current.curve(Curve::Own).headline());
        tell(value("stage", "Output stage", tenths(measured.temperature)).unit("°C").digits(1));
        tell(value("dc_link", "Intermediate circuit", tenths(measured.dc_link)).unit("V").digits(1));
        if self.model == Model::Ag03_1 {
            tell(value("output_supply", "Output supply", tenths(measured.output_supply)).unit("V").digits(1));
        }
        tell(value("control_supply", "Control supply", tenths(measured.control_supply)).unit("V").digits(1));
        let battery = Amount::Number(f64::from(measured.battery) / 100.0);
        tell(value("battery", "Battery", battery).unit("V").digits(2));
        let motor = match self.status.motor {
            Motor::Released => "released",
            Motor::InControl => "in control",
            Motor::Shorted => "shorted",
        };
        tell(value("motor", "Motor", Amount::Text(&motor)));
        let faults = Amount::Number(self.drive.faults().count().into());
        tell(Value::new("faults", "faults", Group::Counter, faults));
    }

    /// The fault that is latched: its letter and what it means.
    pub(super) fn tell_fault(&self, tell: &mut dyn FnMut(&dyn fmt::Display, &dyn fmt::Display)) {
        if let Some(fault) = self.status.fault {
            tell(&char::from(fault.code()), &fault);
        }
    }

    /// What it warns of.
    pub(super) fn say_warning(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        let warnings = [
            (self.status.battery_low, "battery low"),
            (self.status.current_out_of_range, "current"),
            (self.status.lag_error, "lag error"),
        ];
        if let Some((_, warning)) = warnings.iter().find(|(stands, _)| *stands) {
            say(warning);
        }
    }
}

/// Each fault that the buffer remembers.
pub(super) fn each_past(codes: impl IntoIterator<Item = u8>, tell: &mut dyn FnMut(Past<'_>)) {
    for code in codes {
        if let Some(fault) = Fault::ALL.into_iter().find(|fault| fault.code() == code) {
            tell(Past { code: &char::from(code), text: &fault, when: None });
        }
    }
}

/// The state of the drive in words (`ag03.md` 8).
pub(super) const fn state(state: State) -> &'static str {
    match state {
        State::Off => "off",
        State::NotReady => "not ready: a supply is missing",
        State::ReadyToRun(_) => "ready-to-run",
        State::OperationEnabled(_) => "operation enabled",
        State::Disabling => "operation disabled, the shaft still brakes",
        State::TravelActive => "travel job active",
        State::Pausing { torque_tripped: false } => "travel job paused, brakes",
        State::Pausing { torque_tripped: true } => {
            "travel job interrupted by the torque deactivation, brakes"
        }
        State::Paused { torque_tripped: false } => "travel job paused",
        State::Paused { torque_tripped: true } => "travel job interrupted by the torque deactivation",
        State::Stopping => "travel job stopped, the shaft still brakes",
        State::Inching(_) => "inching",
        State::VelocityTravelling => "travelling with velocity",
        State::KeyInching(_) => "inching by key",
        State::KeyInchingEnding => "inching by key ends",
        State::Fault => "fault",
        State::TurnOnDisabled => "turn-on disabled",
    }
}

/// What the switches set (chapters 2.4, 7.8 and 7.10).
const SWITCHES: &[&str] = &[
    "SW1, address 1",
    "SW2, address 2",
    "SW3, address 4",
    "SW4, address 8",
    "SW5, address 16",
    "SW6, address 32",
    "SW7, address 64",
    "SW8, factory reset",
    "SW9, bus terminator",
    "SW10, bus terminator",
];

/// Tells the switches. `number` is what the bus calls SW1 to SW7 without a factory reset, what they say and what is in
/// force.
pub(super) fn tell_switches(
    switches: DipSwitches,
    patterns: ResetPatterns,
    number: (&str, u8, u8),
    tell: &mut dyn FnMut(Switches<'_>),
) {
    let (reset, (name, wanted, in_force)) = (patterns.requested(switches), number);
    let waits = if reset.is_some() || wanted != in_force { " from the next power-on" } else { "" };
    let terminator = match switches.terminator() {
        Terminator::Inactive => "off",
        Terminator::Active => "on",
        Terminator::Half => "half on: set SW9 and SW10 alike",
    };
    let mut tell_with = |meaning: &dyn fmt::Display| {
        tell(Switches {
            positions: switches.bits(),
            names: SWITCHES,
            text: &format_args!("{switches}: {meaning}{waits}, terminator {terminator}"),
        });
    };
    match reset {
        Some(set) => tell_with(&format_args!("factory reset of {} parameters", set.name())),
        None => tell_with(&format_args!("{name} {wanted}")),
    }
}

/// How safe what the EEPROM holds is.
pub(super) const fn memory(state: EepromState) -> &'static str {
    match state {
        EepromState::Internal => "in memory",
        EepromState::Writing => "is being written",
        EepromState::Safe => "in its file",
        EepromState::Failed => "NOT written, see the log",
    }
}
