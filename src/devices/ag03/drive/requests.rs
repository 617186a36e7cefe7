//! From the command to what is asked: edges against the previous command, and the conditions of each request.

use super::motion::{Dynamics, acceleration, velocity};
use super::refusal::{Reason, Refusal, Request};
use super::scale::round;
use super::settings::{Mode, PosType, Settings};
use super::states::{Asked, Direction, DirectionChange, Inching, Key, State};
use super::{Command, Drive, Operation};
use crate::devices::ag03::param::Parameter;

/// A travel job, or the latched accelerations of an inching.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Job {
    /// Target in user units.
    pub(super) setpoint: i32,
    /// Target of the shaft in increments.
    pub(super) target: f64,
    /// The loop point in increments, while the shaft has not been there.
    pub(super) via: Option<f64>,
    /// a, v, d as they were when the job started.
    pub(super) dynamics: Dynamics,
}

impl Job {
    /// Before the first one.
    pub(super) const NONE: Self = Self {
        setpoint: 0,
        target: 0.0,
        via: None,
        dynamics: Dynamics { speed: 1.0, acceleration: 1.0, deceleration: 1.0 },
    };
}

impl Drive {
    /// What stands now against a start with everything else as the last command has it; `None`: nothing.
    ///
    /// A job that is active stands against a travel job, too.
    pub(crate) fn start_refusal(&self, settings: &Settings) -> Option<Refusal> {
        let mut refusal = match self.frame.mode {
            Mode::Positioning => self.travel_refusal(&self.previous, settings),
            Mode::Velocity => self.velocity_refusal(&self.previous),
        };
        refusal.note(Reason::StartHeld, !self.start_armed);
        (!refusal.is_empty()).then_some(refusal)
    }

    /// What `command` asks for, compared with the previous one. Leaves a [`Refusal`] for each request that is refused;
    /// of several in one step the last.
    pub(super) fn asked(&mut self, command: &Command, settings: &Settings) -> Asked {
        let before = self.previous;
        let travel = command.travel && self.asks_travel(command, settings);
        let inch_1 = command.inch_1 && !before.inch_1;
        let inch_2 = command.inch_2.is_some() && before.inch_2.is_none();
        let inch_2_direction = command.inch_2.unwrap_or(Direction::Positive);
        let inch_1_direction = Direction::of(settings.number(Parameter::DeltaInch));

        if command.turn && !before.turn && self.frame.mode == Mode::Velocity {
            self.asks_velocity(command);
        }
        // C-23, C-24: what brakes first ends like a disabled operation, whose motor row 5 then releases.
        let brakes = self.state.operation_enabled() || self.state == State::Disabling;
        let key_held = if command.keys { self.inputs.key() } else { None };
        if command.enable {
            self.asks_enable(command);
        }
        let key_pressed = key_held.filter(|_| self.previous_key.is_none());
        let asked = Asked {
            release: match command.operation {
                Operation::Release => true,
                Operation::BrakeAndRelease => !brakes,
                Operation::BrakeAndHold | Operation::Run => false,
            },
            enable: command.operation == Operation::Run,
            turn_on_again: command.rearm,
            output_stage: self.supplies.output_stage,
            stop: command.stop,
            intermediate_stop: command.pause,
            resume: before.pause && !command.pause,
            travel,
            inch_1: inch_1
                && self.asks_inching(Request::Inching1(inch_1_direction), inch_1_direction, command, travel),
            inch_1_held: command.inch_1,
            inch_2: inch_2
                && self.asks_inching(Request::Inching2(inch_2_direction), inch_2_direction, command, travel),
            inch_2_held: command.inch_2.is_some(),
            inch_2_direction,
            inch_2_change: self.inch_2_change(inch_2_direction, command),
            velocity: self.frame.mode == Mode::Velocity
                && command.turn
                && self.start_armed
                && self.supplies.output_stage,
            acknowledge: command.acknowledge && !before.acknowledge && self.asks_acknowledge(),
            key: key_pressed.filter(|&key| self.key_allowed(key)),
            key_held,
        };
        self.previous_key = self.inputs.key();
        asked
    }

    /// Rows 20, 21, 22, 25b.
    fn asks_travel(&mut self, command: &Command, settings: &Settings) -> bool {
        if self.frame.mode == Mode::Velocity {
            return false;
        }
        let refusal = self.travel_refusal(command, settings);
        self.accepts(refusal)
    }

    /// What stands against a travel job.
    fn travel_refusal(&self, command: &Command, settings: &Settings) -> Refusal {
        let job = self.job_to(command.setpoint, settings);
        let limits = self.frame.limits;
        let mut refusal = self.refusal_of(Request::Travel { setpoint: command.setpoint });
        self.note_state(&mut refusal, command);
        refusal.note(
            Reason::JobPaused,
            matches!(
                self.state,
                State::Pausing { torque_tripped: false } | State::Paused { torque_tripped: false }
            ),
        );
        // A coasting shaft that was caught, or one that the torque deactivation stops: no travel begins in motion.
        let turns = matches!(self.state, State::OperationEnabled(_)) && !self.stands();
        refusal.note(Reason::ShaftTurns, turns || self.state == State::Pausing { torque_tripped: true });
        refusal.note(Reason::NoOutputStage, !self.supplies.output_stage);
        refusal.note(Reason::Stop, command.stop);
        refusal.note(Reason::IntermediateStop, command.pause);
        refusal.note(Reason::StartHeld, !self.start_armed);
        refusal.note(Reason::AboveUpperLimit, limits.is_above(refusal.position));
        refusal.note(Reason::BelowLowerLimit, limits.is_below(refusal.position));
        refusal.note(Reason::SetpointAboveUpperLimit, limits.is_above(command.setpoint));
        refusal.note(Reason::SetpointBelowLowerLimit, limits.is_below(command.setpoint));
        refusal.note(Reason::BeyondEncoder, self.is_beyond_encoder(job.target));
        refusal.loop_point = command.setpoint;
        if let Some(via) = job.via {
            refusal.loop_point = self.units_at(via);
            refusal.note(Reason::LoopPointAboveUpperLimit, limits.is_above(refusal.loop_point));
            refusal.note(Reason::BeyondEncoder, self.is_beyond_encoder(via));
            refusal.note(Reason::LoopPointBelowLowerLimit, limits.is_below(refusal.loop_point));
        }
        refusal
    }

    /// Rows 28, 31, 35, 36. `travel`: a travel job starts with the same command.
    fn asks_inching(
        &mut self,
        request: Request,
        direction: Direction,
        command: &Command,
        travel: bool,
    ) -> bool {
        let mut refusal = self.refusal_of(request);
        self.note_state(&mut refusal, command);
        refusal.note(Reason::JobPaused, matches!(self.state, State::Pausing { .. } | State::Paused { .. }));
        refusal.note(Reason::ShaftTurns, !self.stands() && matches!(self.state, State::OperationEnabled(_)));
        refusal.note(Reason::JobActive, travel);
        refusal.note(Reason::VelocityMode, self.frame.mode == Mode::Velocity);
        refusal.note(Reason::NoOutputStage, !self.supplies.output_stage);
        refusal.note(Reason::BothInching, command.inch_1 && command.inch_2.is_some());
        refusal.note_outward(direction, self.frame.limits);
        self.accepts(refusal)
    }

    /// Row 33: what a change of the direction does to inching 2. Outward beyond a limit it ends.
    fn inch_2_change(&mut self, direction: Direction, command: &Command) -> DirectionChange {
        let change = self.quirks.inch_2_direction_change;
        let State::Inching(Inching::Two(before)) = self.state else {
            return change;
        };
        if change != DirectionChange::Reverses || direction == before || command.inch_2.is_none() {
            return change;
        }
        let mut refusal = self.refusal_of(Request::Inching2(direction));
        refusal.note_outward(direction, self.frame.limits);
        if self.accepts(refusal) { change } else { DirectionChange::Ends }
    }

    /// Row 40: the setpoint is a level, a refusal is reported once per rising edge.
    fn asks_velocity(&mut self, command: &Command) {
        let refusal = self.velocity_refusal(command);
        self.accepts(refusal);
    }

    /// What stands against turning with the setpoint.
    fn velocity_refusal(&self, command: &Command) -> Refusal {
        let mut refusal = self.refusal_of(Request::Velocity { setpoint: command.setpoint });
        match self.state {
            // enabled by this very command, and turning with the next step
            State::ReadyToRun(_) if command.operation == Operation::Run => {}
            State::Off
            | State::NotReady
            | State::ReadyToRun(_)
            | State::OperationEnabled(_)
            | State::Disabling
            | State::TravelActive
            | State::Pausing { .. }
            | State::Paused { .. }
            | State::Stopping
            | State::Inching(_)
            | State::VelocityTravelling
            | State::KeyInching(_)
            | State::KeyInchingEnding
            | State::Fault
            | State::TurnOnDisabled => self.note_state(&mut refusal, command),
        }
        refusal.note(Reason::NoOutputStage, !self.supplies.output_stage);
        refusal
    }

    /// Rows 4, 5, 14. A drive that still brakes is enabled as soon as it stands.
    fn asks_enable(&mut self, command: &Command) {
        let mut refusal = self.refusal_of(Request::Enable);
        refusal.note(Reason::NoSupply, self.state == State::NotReady);
        refusal.note(Reason::FaultLatched, self.state == State::Fault);
        refusal.note(Reason::TurnOnDisabled, self.state == State::TurnOnDisabled);
        refusal.note(Reason::NotAsked, command.operation != Operation::Run);
        self.accepts(refusal);
    }

    /// Rows 10, 11.
    fn asks_acknowledge(&mut self) -> bool {
        if self.state != State::Fault {
            return false;
        }
        let mut refusal = self.refusal_of(Request::Acknowledge);
        if let Some(cause) = self.causes().iter().next() {
            refusal.fault = Some(cause);
            refusal.note(Reason::FaultCause, true);
        }
        self.accepts(refusal)
    }

    /// Row 52: ready-to-run while the keys are free, and not outward beyond a limit. Manual setup mode is inching, so
    /// it needs the positioning mode (manual 2.2.1.2).
    fn key_allowed(&self, key: Key) -> bool {
        let outward = match self.key_direction(key) {
            Direction::Positive => self.frame.limits.is_above(self.position()),
            Direction::Negative => self.frame.limits.is_below(self.position()),
        };
        self.frame.mode == Mode::Positioning && self.supplies.output_stage && !outward
    }

    /// What the state itself has against a request.
    fn note_state(&self, refusal: &mut Refusal, command: &Command) {
        refusal.note(Reason::NotAsked, command.operation != Operation::Run);
        match self.state {
            State::NotReady => refusal.note(Reason::NoSupply, true),
            State::ReadyToRun(_) => refusal.note(Reason::NotEnabled, true),
            State::Disabling | State::KeyInching(_) | State::KeyInchingEnding => {
                refusal.note(Reason::NotEnabled, true);
                refusal.note(Reason::ShaftTurns, true);
            }
            State::Stopping | State::Inching(Inching::Ending) => refusal.note(Reason::ShaftTurns, true),
            State::TravelActive => refusal.note(Reason::JobActive, true),
            State::Inching(Inching::One | Inching::Two(_)) => refusal.note(Reason::InchingActive, true),
            State::Fault => refusal.note(Reason::FaultLatched, true),
            State::TurnOnDisabled => refusal.note(Reason::TurnOnDisabled, true),
            State::Off
            | State::OperationEnabled(_)
            | State::Pausing { .. }
            | State::Paused { .. }
            | State::VelocityTravelling => {}
        }
    }

    /// The encoder could not tell that the shaft is there.
    fn is_beyond_encoder(&self, target: f64) -> bool {
        target.abs() > self.plant.encoder_half()
    }

    fn refusal_of(&self, request: Request) -> Refusal {
        let mut refusal = Refusal::new(request, self.model);
        refusal.note(Reason::SwitchedOff, self.state == State::Off);
        refusal.lengths = self.frame.lengths;
        refusal.position = self.position();
        refusal.upper_limit = self.frame.limits.upper();
        refusal.lower_limit = self.frame.limits.lower();
        refusal.fault = self.latched;
        refusal
    }

    fn accepts(&mut self, refusal: Refusal) -> bool {
        if !refusal.is_empty() {
            self.refusal = Some(refusal);
        }
        refusal.is_empty()
    }

    /// The job to `setpoint`, direct or by a loop point (`ag03.md` 9, "loop+").
    pub(super) fn job_to(&self, setpoint: i32, settings: &Settings) -> Job {
        let target = self.increments_at(setpoint);
        let position = self.position();
        let loop_length = f64::from(settings.word(Parameter::LoopLength)) * self.frame.scale.sign();
        let via = match settings.pos_type() {
            PosType::LoopPlus if setpoint < position => Some(target - loop_length),
            PosType::LoopMinus if setpoint > position => Some(target + loop_length),
            PosType::Direct | PosType::LoopPlus | PosType::LoopMinus => None,
        };
        let dynamics = Dynamics {
            speed: self.speed(settings.word(Parameter::VPos)),
            acceleration: acceleration(settings.word(Parameter::APos)),
            deceleration: acceleration(settings.d_pos().unwrap_or(settings.word(Parameter::APos))),
        };
        Job { setpoint, target, via, dynamics }
    }

    /// The way of inching 1. Also carries a-Inch for inching 2 and the keys.
    pub(super) fn inching_job(&self, settings: &Settings) -> Job {
        let delta = self.frame.scale.increments(f64::from(settings.number(Parameter::DeltaInch)));
        let end = self.shaft_position() + delta;
        let limit = self.limit_to_stop_at(Direction::of(settings.number(Parameter::DeltaInch)));
        let target = limit.filter(|limit| (limit - self.shaft_position()).abs() < delta.abs()).unwrap_or(end);
        let ramp = acceleration(settings.word(Parameter::AInch));
        Job {
            setpoint: self.units_at(end),
            target,
            via: None,
            dynamics: Dynamics {
                speed: self.speed(settings.word(Parameter::VInch)),
                acceleration: ramp,
                deceleration: ramp,
            },
        }
    }

    /// Where inching stands at the latest, angle of the shaft in increments (C-42); `None`: it goes on.
    pub(super) fn limit_to_stop_at(&self, direction: Direction) -> Option<f64> {
        let limits = self.frame.limits;
        let limit = match direction {
            Direction::Positive => limits.upper(),
            Direction::Negative => limits.lower(),
        };
        (self.quirks.inching_stops_at_limit && limits.are_monitored()).then(|| self.increments_at(limit))
    }

    /// The speed of inching 2 and the keys in increments/s: v-Inch times offset, rounded half up (C-12), at least 1
    /// rpm (manual 2.2.1.2).
    pub(super) fn inching_2_speed(&self, settings: &Settings) -> f64 {
        let percent_rpm =
            u32::from(settings.word(Parameter::VInch)) * u32::from(settings.word(Parameter::OffsetInch2));
        let rounding = if self.quirks.inching_rounds_up { 99 } else { 50 };
        self.speed(u16::try_from((percent_rpm + rounding) / 100).unwrap_or(u16::MAX))
    }

    /// `rpm` in increments/s, limited to what the gear allows.
    fn speed(&self, rpm: u16) -> f64 {
        velocity(i32::from(rpm).clamp(1, self.maximum_rpm()))
    }

    /// The velocity setpoint in effect, rpm: 0 while it is not released, and limited to what the gear allows.
    pub(super) fn velocity_setpoint(&self, command: &Command) -> i32 {
        let maximum = self.maximum_rpm();
        if command.turn { command.setpoint.clamp(-maximum, maximum) } else { 0 }
    }

    /// Manual chapter 6, nos. 5, 9, 24.
    pub(crate) fn maximum_rpm(&self) -> i32 {
        self.gear.max_rpm().into()
    }

    /// Where a key turns to in user units: counter-clockwise counts positive with sense of rotation i.
    pub(super) fn key_direction(&self, key: Key) -> Direction {
        match key {
            Key::Clockwise => Direction::negative_if(self.frame.scale.sign() > 0.0),
            Key::CounterClockwise => Direction::negative_if(self.frame.scale.sign() < 0.0),
        }
    }

    pub(super) fn increments_at(&self, units: i32) -> f64 {
        self.zero + self.frame.scale.increments(f64::from(units))
    }

    pub(super) fn units_at(&self, increments: f64) -> i32 {
        round(self.frame.scale.units(increments - self.zero))
    }

    pub(super) fn position(&self) -> i32 {
        self.units_at(self.shaft_position())
    }
}
