//! What a transition does to the shaft, and where the shaft is then: profile first, plant behind.

use super::faults::FaultSet;
use super::lapse::Lapse;
use super::motion::{Dynamics, acceleration, velocity};
use super::plant::Commanded;
use super::settings::{Settings, StopMode};
use super::states::{Action, Direction, Motor, State};
use super::{Command, Drive};
use crate::devices::ag03::param::Parameter;

impl Drive {
    /// Goes to a state and does what belongs to the transition.
    #[inline(always)]
    pub(super) fn enact(&mut self, next: State, action: Action, command: &Command, settings: &Settings) {
        if next != State::Fault {
            self.entered = FaultSet::empty();
            self.latched = None;
        }
        self.state = next;
        if action != Action::None {
            self.act(action, command, settings);
        }
    }

    #[inline(never)]
    fn act(&mut self, action: Action, command: &Command, settings: &Settings) {
        match action {
            Action::None => {}
            Action::PowerOn => {
                self.setpoint = 0;
                self.setpoint_programmed = false;
                self.jobs = 0;
                self.torque_tripped = false;
                self.previous = Command::default();
                self.start_armed = true;
            }
            Action::Release => self.motion.brake(self.plant.coast_deceleration()),
            Action::TakeControl | Action::BrakeMaximum => self.brake_maximum(),
            Action::TorqueBrake => {
                self.torque_tripped = true;
                self.brake_maximum();
            }
            Action::BrakeProgrammed => self.motion.brake(self.job.dynamics.deceleration),
            Action::BrakeStopMode => match settings.stop_mode_inch_2() {
                StopMode::Maximum => self.brake_maximum(),
                StopMode::Ramp => self.motion.brake(self.job.dynamics.deceleration),
            },
            Action::StartTravel => {
                self.job = self.job_to(command.setpoint, settings);
                self.setpoint = self.job.setpoint;
                self.setpoint_programmed = true;
                self.torque_tripped = false;
                self.limits_changed = false;
                self.jobs = self.jobs.wrapping_add(1);
                self.start_leg();
            }
            Action::ResumeTravel => {
                self.torque_tripped = false;
                self.start_leg();
            }
            Action::StartInching1 => {
                self.job = self.inching_job(settings);
                self.setpoint = self.job.setpoint;
                self.setpoint_programmed = true;
                self.torque_tripped = false;
                self.start_leg();
            }
            Action::StartInching2(direction) => {
                self.job = self.inching_job(settings);
                self.torque_tripped = false;
                self.follow_inching_2(direction, settings);
            }
            Action::FollowInching2(direction) => self.follow_inching_2(direction, settings),
            Action::StartKey(key) => {
                self.job = self.inching_job(settings);
                self.torque_tripped = false;
                self.follow_inching_2(self.key_direction(key), settings);
            }
            Action::FollowKey(key) => self.follow_inching_2(self.key_direction(key), settings),
            Action::FollowVelocity => {
                let target = velocity(self.velocity_setpoint(command)) * self.frame.scale.sign();
                self.follow(target, acceleration(settings.word(Parameter::ARot)));
            }
        }
    }

    #[inline]
    pub(super) fn advance(&mut self, lapse: Lapse) {
        let (position, velocity) = (self.motion.position(), self.motion.velocity());
        let left = self.motion.advance(lapse);
        let commanded = Commanded {
            way: self.motion.position() - position,
            velocity_before: velocity,
            velocity: self.motion.velocity(),
            motor: self.state.motor(),
        };
        if self.inputs.blocked && commanded.motor != Motor::InControl && !self.motion.at_rest() {
            // What stops a released shaft stops it for good.
            self.motion.begin_anew(position, 0.0);
        }
        if let Some(shaft) = self.plant.advance(lapse, commanded, &self.inputs) {
            self.motion.begin_anew(position + shaft.way, shaft.velocity);
        }
        if self.stands() && self.state == State::TravelActive && self.job.via.take().is_some() {
            self.start_leg();
            self.motion.skip(left.unwrap_or_default());
        }
        self.pass_end_of_encoder();
    }

    /// Beyond the range of the absolute encoder the position jumps to the other end (manual chapter 6, nos. 15, 16).
    #[inline]
    fn pass_end_of_encoder(&mut self) {
        let half = self.plant.encoder_half();
        let position = self.shaft_position();
        let jump = match position {
            above if above > half => -2.0 * half,
            below if below < -half => 2.0 * half,
            _within => return,
        };
        self.motion.shift(jump);
        self.job.target += jump;
        self.job.via = self.job.via.map(|via| via + jump);
        if matches!(self.state, State::Inching(_)) {
            self.setpoint = self.units_at(self.job.target);
        }
    }

    fn brake_maximum(&mut self) {
        self.motion.brake(self.plant.maximum_deceleration());
    }

    /// Travels to the loop point, or if there is none or the shaft is there, to the target.
    fn start_leg(&mut self) {
        if let Some(via) = self.job.via {
            self.motion.travel_to(via, self.job.dynamics);
            if !self.motion.at_rest() {
                return;
            }
            self.job.via = None;
        }
        self.motion.travel_to(self.job.target, self.job.dynamics);
    }

    fn follow_inching_2(&mut self, direction: Direction, settings: &Settings) {
        let speed = self.inching_2_speed(settings) * self.frame.scale.sign();
        let target = match direction {
            Direction::Positive => speed,
            Direction::Negative => -speed,
        };
        let acceleration = self.job.dynamics.acceleration;
        match self.limit_to_stop_at(direction) {
            None => self.follow(target, acceleration),
            Some(limit) => {
                let deceleration = self.plant.maximum_deceleration();
                let dynamics = Dynamics { speed: speed.abs(), acceleration, deceleration };
                if !self.motion.leads_to(limit, dynamics) {
                    self.motion.travel_to(limit, dynamics);
                }
            }
        }
    }

    /// Lays a new ramp only if the target is new.
    fn follow(&mut self, target: f64, acceleration: f64) {
        if target != self.motion.final_velocity() {
            self.motion.ramp_to(target, acceleration);
        }
    }
}
