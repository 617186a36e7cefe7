//! The plant: motor, gear, load, output stage and intermediate circuit, advanced in the drive's fixed steps.
//!
//! The profile (`motion`) is what the drive commands. The shaft is exactly on it as long as the motor has the
//! torque; otherwise it is slower, with all the current the motor can take, and the profile begins anew where the
//! shaft is. So the speed and the accelerations of the profile are never exceeded, whatever the load does (manual
//! chapter 6, nos. 4 to 6, 8 and 9: v-Pos and v-Inch are maximum speeds):
//!
//! ```text
//! torque   = friction + load + inertia * acceleration                  at the output shaft, Nm
//! current  = idle current + torque / torque per ampere                 A
//! possible = min(peak current, (supply - back EMF) / resistance)       A
//! current <= possible: on the profile      current > possible: slower, towards the speed where both are equal
//! ```
//!
//! What no manual states is in [`Constants`]; the limits of the manual's tables 1 and 2 are fixed. The model is made
//! so that every warning and fault can be reached by what causes it, not measured on a drive. It assumes that the
//! gear holds a load at standstill and in braking: a load never turns or accelerates the shaft by itself.

mod provocation;

use core::time::Duration;

use crate::devices::ag03::param::{Gear, Model};
use crate::time::nanos;

use super::faults::{Fault, FaultSet};
use super::inputs::Inputs;
use super::lapse::Lapse;
use super::motion::{rpm, sign};
use super::scale::INCREMENTS_PER_REVOLUTION;
use super::states::Motor;
use super::status::STANDSTILL_RPM;
use super::supplies::Supplies;

/// Fault A: a supply below this many V, manual Table 2.
pub(super) const LOW_SUPPLY: f64 = 18.0;
/// Fault A: and a motor current above this many A.
const LOW_SUPPLY_CURRENT: f64 = 0.2;
/// Fault C: a motor current above this many A; also the warning (`ag03.md` C-33).
const OVERCURRENT: f64 = 2.4;
/// Fault C: for more than this time, ns.
const OVERCURRENT_TIME: u64 = 4_000_000_000;
/// Fault D: an output stage above this many degC.
const HOT_STAGE: f64 = 90.0;
/// Fault G: an intermediate circuit above this many V.
const HIGH_DC_LINK: f64 = 35.0;
/// Fault J: a battery below this many V.
pub(super) const EMPTY_BATTERY: f64 = 2.2;
/// Temperatures and voltages this close (K, V) to where they go are there.
const SETTLED: f64 = 0.01;

/// What no manual states about the plant. All above zero; smaller values count as almost zero.
///
/// The torques and speeds of the motor are seen through the gear: 48:1 gives twice the torque and half the speed of
/// 24:1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// Torque per ampere at the motor in Nm/A, losses of motor and gear taken off. Default 2/48: 2 Nm per ampere at
    /// the shaft of a 48:1 gear.
    pub torque_per_ampere: f64,
    /// Voltage that each rpm of the motor takes, V/rpm. Default 24 V at 14400 rpm: 300 rpm at the shaft of 48:1,
    /// without load.
    pub back_emf: f64,
    /// Resistance of the winding in ohm; how much a load slows the motor. Default 8.
    pub resistance: f64,
    /// What the output stage gives at most, A. Default 3.
    pub peak_current: f64,
    /// Current of 100 % torque, for the torque deactivation (PNU 1032, C-13), A. Default 2: 4 Nm with 48:1.
    pub rated_current: f64,
    /// Current of a shaft that turns without load, A. Default 0.1.
    pub idle_current: f64,
    /// Inertia at the motor in kg m^2. Default such that 100 % acceleration takes 0.5 A with 48:1.
    pub inertia: f64,
    /// Deceleration called maximum, rev/s^2 of the shaft. Default 4: the most that can be programmed.
    pub maximum_deceleration: f64,
    /// Deceleration of a released shaft that runs out, rev/s^2. Default 1.
    pub coast_deceleration: f64,
    /// A shaft that cannot follow for longer than this has a lag error, s. Default 0.1.
    pub lag_time: f64,
    /// Fault B comes when speed below 2 rpm and lag error last longer than this, s. Default 0.5.
    pub blocked_time: f64,
    /// Heating of the output stage in K/A^2. Default 10: 40 K at 2 A.
    pub heating: f64,
    /// Time constant of warming and cooling in s; shorter than a real one, so that it can be watched. Default 5.
    pub thermal_time: f64,
    /// By how much power fed back raises the intermediate circuit, V/W. Default 0.25.
    pub regeneration: f64,
    /// Time constant of the intermediate circuit in s. Default 0.2.
    pub dc_link_time: f64,
    /// A supply below this many V is missing. Default 10.
    pub supply_present: f64,
    /// A battery below this many V is low. Default 2.6, from the manual of SIKO's AG05 (C-33).
    pub battery_low: f64,
    /// Revolutions of the output shaft the absolute encoder tells apart; beyond them the position jumps. Default
    /// 65536.
    pub encoder_revolutions: f64,
}

impl Constants {
    /// The defaults named with each field.
    pub(crate) const DEFAULT: Self = Self {
        torque_per_ampere: 2.0 / 48.0,
        back_emf: 24.0 / 14_400.0,
        resistance: 8.0,
        peak_current: 3.0,
        rated_current: 2.0,
        idle_current: 0.1,
        // 1 Nm at the shaft of 48:1 for 4 rev/s^2 = 25.1 rad/s^2
        inertia: 1.0 / (4.0 * core::f64::consts::TAU) / (48.0 * 48.0),
        maximum_deceleration: 4.0,
        coast_deceleration: 1.0,
        lag_time: 0.1,
        blocked_time: 0.5,
        heating: 10.0,
        thermal_time: 5.0,
        regeneration: 0.25,
        dc_link_time: 0.2,
        supply_present: 10.0,
        battery_low: 2.6,
        encoder_revolutions: 65_536.0,
    };

    /// Every field a number above zero.
    #[expect(clippy::manual_clamp, reason = "what is no number shall be the smallest one")]
    fn positive(self) -> Self {
        let positive = |value: f64| value.max(1e-9).min(1e9);
        Self {
            torque_per_ampere: positive(self.torque_per_ampere),
            back_emf: positive(self.back_emf),
            resistance: positive(self.resistance),
            peak_current: positive(self.peak_current),
            rated_current: positive(self.rated_current),
            idle_current: positive(self.idle_current),
            inertia: positive(self.inertia),
            maximum_deceleration: positive(self.maximum_deceleration),
            coast_deceleration: positive(self.coast_deceleration),
            lag_time: positive(self.lag_time),
            blocked_time: positive(self.blocked_time),
            heating: positive(self.heating),
            thermal_time: positive(self.thermal_time),
            regeneration: positive(self.regeneration),
            dc_link_time: positive(self.dc_link_time),
            supply_present: positive(self.supply_present),
            battery_low: positive(self.battery_low),
            encoder_revolutions: positive(self.encoder_revolutions),
        }
    }
}

impl Default for Constants {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What the drive commands during one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Commanded {
    /// Way of the profile, increments.
    pub(super) way: f64,
    /// Velocity of the profile at the beginning and at the end, increments/s.
    pub(super) velocity_before: f64,
    pub(super) velocity: f64,
    /// What the output stage does.
    pub(super) motor: Motor,
}

/// What a shaft does that cannot follow the profile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hindered {
    /// Its way, increments.
    pub(super) way: f64,
    /// Its velocity at the end, increments/s.
    pub(super) velocity: f64,
}

/// The plant of one drive.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plant {
    model: Model,
    constants: Constants,
    /// At the output shaft: Nm/A, V per increment/s, Nm per increment/s^2.
    torque_per_ampere: f64,
    back_emf: f64,
    inertia: f64,
    /// Half the range of the encoder, increments.
    encoder_half: f64,
    /// In ns.
    lag_time: u64,
    blocked_time: u64,
    /// Torque of the motor in the direction of the motion, Nm; below zero it brakes.
    torque: f64,
    current: f64,
    temperature: f64,
    dc_link: f64,
    /// In ns.
    hindered_for: u64,
    blocked_for: u64,
    overcurrent_for: u64,
}

impl Plant {
    /// A shaft at rest, everything as warm as the air.
    pub(super) fn new(model: Model, gear: Gear, constants: Constants, inputs: &Inputs) -> Self {
        let constants = constants.positive();
        let ratio = f64::from(gear.ratio());
        Self {
            model,
            constants,
            torque_per_ampere: constants.torque_per_ampere * ratio,
            back_emf: constants.back_emf * ratio * rpm(1.0),
            inertia: constants.inertia * ratio * ratio * core::f64::consts::TAU / INCREMENTS_PER_REVOLUTION,
            encoder_half: 0.5 * constants.encoder_revolutions * INCREMENTS_PER_REVOLUTION,
            lag_time: in_nanos(constants.lag_time),
            blocked_time: in_nanos(constants.blocked_time),
            torque: 0.0,
            current: 0.0,
            temperature: inputs.ambient,
            dc_link: inputs.motor_supply(model),
            hindered_for: 0,
            blocked_for: 0,
            overcurrent_for: 0,
        }
    }

    /// The maximum deceleration, increments/s^2.
    pub(super) fn maximum_deceleration(&self) -> f64 {
        self.constants.maximum_deceleration * INCREMENTS_PER_REVOLUTION
    }

    /// How a released shaft runs out, increments/s^2.
    pub(super) fn coast_deceleration(&self) -> f64 {
        self.constants.coast_deceleration * INCREMENTS_PER_REVOLUTION
    }

    /// Half the range of the encoder, increments.
    pub(super) fn encoder_half(&self) -> f64 {
        self.encoder_half
    }

    /// Whether `volts` are a supply.
    pub(super) fn supplies(&self, volts: f64) -> bool {
        volts >= self.constants.supply_present
    }

    /// Motor current in A, without sign.
    pub(super) fn current(&self) -> f64 {
        self.current
    }

    /// Torque in % of the rated one.
    pub(super) fn torque_percent(&self) -> f64 {
        self.torque.abs() / self.torque_per_ampere / self.constants.rated_current * 100.0
    }

    /// Temperature of the output stage in degC.
    pub(super) fn temperature(&self, inputs: &Inputs) -> f64 {
        inputs.stage_temperature.unwrap_or(self.temperature)
    }

    /// Voltage of the intermediate circuit in V.
    pub(super) fn dc_link(&self, inputs: &Inputs) -> f64 {
        inputs.dc_link.unwrap_or(self.dc_link)
    }

    /// The shaft cannot follow (SSW.15).
    pub(super) fn lag_error(&self) -> bool {
        self.hindered_for > self.lag_time
    }

    /// The motor current is out of range (SSW.13).
    pub(super) fn overcurrent(&self) -> bool {
        self.current > OVERCURRENT
    }

    /// The battery is low (SSW.12).
    pub(super) fn battery_low(&self, inputs: &Inputs) -> bool {
        inputs.battery < self.constants.battery_low
    }

    /// The causes of faults that are present, manual Table 2.
    pub(super) fn causes(&self, inputs: &Inputs, supplies: &Supplies) -> FaultSet {
        let causes = supplies.causes
            | Fault::A.when(supplies.low && self.current > LOW_SUPPLY_CURRENT)
            | Fault::B.when(self.blocked_for > self.blocked_time)
            | Fault::C.when(self.overcurrent_for > OVERCURRENT_TIME)
            | Fault::D.when(self.temperature(inputs) > HOT_STAGE)
            | Fault::G.when(self.dc_link(inputs) > HIGH_DC_LINK);
        if causes.is_empty() {
            return causes;
        }
        causes.iter().filter(|fault| fault.exists_on(self.model)).collect()
    }

    /// Lets `lapse` pass. Returns what a shaft did that cannot follow the profile.
    pub(super) fn advance(
        &mut self,
        lapse: Lapse,
        commanded: Commanded,
        inputs: &Inputs,
    ) -> Option<Hindered> {
        let time = lapse.seconds();
        if time <= 0.0 {
            return None;
        }
        let hindered = match commanded.motor {
            Motor::InControl => self.follow(time, commanded, inputs),
            Motor::Released | Motor::Shorted => {
                (self.torque, self.current) = (0.0, 0.0);
                None
            }
        };
        self.warm(time, inputs);
        self.charge(time, commanded, inputs);
        let overcurrent = self.overcurrent();
        let slow = hindered.is_some_and(|shaft| rpm(shaft.velocity).abs() < STANDSTILL_RPM);
        let blocked = self.lag_error() && slow;
        count(&mut self.hindered_for, hindered.is_some(), lapse);
        count(&mut self.blocked_for, blocked, lapse);
        count(&mut self.overcurrent_for, overcurrent, lapse);
        hindered
    }

    /// The shaft under torque, on the profile or as fast as it gets.
    fn follow(&mut self, time: f64, commanded: Commanded, inputs: &Inputs) -> Option<Hindered> {
        let Commanded { way, velocity_before, velocity, .. } = commanded;
        if way == 0.0 && velocity == 0.0 {
            self.hold(inputs);
            return None;
        }
        let direction = sign(if way == 0.0 { velocity } else { way });
        let hindrance = inputs.friction_torque + direction * inputs.load_torque;
        let acceleration = (velocity - velocity_before) / time * direction;
        let torque = hindrance + self.inertia * acceleration;
        let supply = inputs.motor_supply(self.model);
        let possible = self.possible_current(supply, velocity.abs());
        let needed = self.constants.idle_current + torque / self.torque_per_ampere;
        if !inputs.blocked && needed <= possible {
            self.push(torque);
            return None;
        }

        let before = (velocity_before * direction).max(0.0);
        let reachable = self.reachable_speed(supply, hindrance);
        let rise = time / (self.mechanical_time() + time);
        let wanted = (velocity * direction).max(0.0);
        let speed = if inputs.blocked { 0.0 } else { (before + (reachable - before) * rise).min(wanted) };
        let most = if inputs.blocked { 0.0 } else { way.abs() };
        let way = (0.5 * (before + speed) * time).min(most);
        self.current = self.possible_current(supply, speed);
        self.torque = (self.current - self.constants.idle_current).max(0.0) * self.torque_per_ampere;
        Some(Hindered { way: direction * way, velocity: direction * speed })
    }

    /// Position control at standstill: the motor holds the load, as far as it can.
    fn hold(&mut self, inputs: &Inputs) {
        let most = self.possible_current(inputs.motor_supply(self.model), 0.0);
        self.current = (inputs.load_torque.abs() / self.torque_per_ampere).min(most);
        self.torque = self.current * self.torque_per_ampere;
    }

    /// The motor gives `torque` to a turning shaft.
    fn push(&mut self, torque: f64) {
        self.torque = torque;
        self.current = if torque < 0.0 {
            -torque / self.torque_per_ampere
        } else {
            self.constants.idle_current + torque / self.torque_per_ampere
        };
    }

    /// The most current the motor takes at `speed` in increments/s, A.
    fn possible_current(&self, supply: f64, speed: f64) -> f64 {
        let free = (supply - self.back_emf * speed) / self.constants.resistance;
        free.min(self.constants.peak_current).max(0.0)
    }

    /// The speed at which the motor has just the torque against `hindrance`, increments/s.
    fn reachable_speed(&self, supply: f64, hindrance: f64) -> f64 {
        let current = self.constants.idle_current + hindrance / self.torque_per_ampere;
        if current >= self.possible_current(supply, 0.0) {
            return 0.0;
        }
        (supply - self.constants.resistance * current).max(0.0) / self.back_emf
    }

    /// How quickly motor and load change their speed, s.
    fn mechanical_time(&self) -> f64 {
        self.inertia * self.constants.resistance / (self.torque_per_ampere * self.back_emf)
    }

    fn warm(&mut self, time: f64, inputs: &Inputs) {
        let end = inputs.ambient + self.constants.heating * self.current * self.current;
        settle(&mut self.temperature, end, time, self.constants.thermal_time);
    }

    /// Braking feeds power back into the intermediate circuit.
    fn charge(&mut self, time: f64, commanded: Commanded, inputs: &Inputs) {
        let speed = commanded.velocity.abs() * core::f64::consts::TAU / INCREMENTS_PER_REVOLUTION;
        let fed_back = (-self.torque).max(0.0) * speed;
        let end = inputs.motor_supply(self.model) + self.constants.regeneration * fed_back;
        settle(&mut self.dc_link, end, time, self.constants.dc_link_time);
    }
}

/// `value` goes to `end`, ever slower, and arrives.
fn settle(value: &mut f64, end: f64, time: f64, time_constant: f64) {
    let left = end - *value;
    *value = if left.abs() < SETTLED { end } else { *value + left * (time / (time_constant + time)) };
}

/// How long `holds` has been true without a break.
fn count(timer: &mut u64, holds: bool, lapse: Lapse) {
    *timer = if holds { timer.saturating_add(lapse.nanos()) } else { 0 };
}

fn in_nanos(seconds: f64) -> u64 {
    nanos(Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX))
}
