//! Positioning: jogging, referencing, MDI and traversing blocks, with the limits of the axis.
//!
//! Positions are LU of the master, increments of the shaft inside.

use super::block::Continuation;
use super::{Drive, Event, Fault, Mdi, Setpoint, Setting, Task};
use crate::devices::ppo_drive::{self, Inching};
use crate::devices::servo::homing::{Homing, Method, Progress, Speeds};
use crate::devices::servo::inputs::{self, Closed, Switches};
use crate::devices::servo::pace::STEP_SECONDS;
use crate::devices::servo::plant::INCREMENTS_PER_REVOLUTION;
use crate::devices::servo::profile::Ramp;

mod blocks;
mod flying;

/// Blocks that follow each other without motion in one step: more are an endless loop.
const MOST_AT_ONCE: usize = 64;

/// Who asked for a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Jogging.
    Jog,
    /// The master's own target.
    Mdi,
    /// A traversing block of this number.
    Block(u8),
}

/// What the axis does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Activity {
    #[default]
    Idle,
    Travel {
        by: Origin,
        target: f64,
        ramp: Ramp,
    },
    Endless {
        by: Origin,
        velocity: f64,
        ramp: Ramp,
    },
    Homing(Homing),
    /// Of a block: so many ms are left.
    Waiting {
        number: u8,
        left: u32,
    },
    /// Of a block: until the master says go on.
    Held {
        number: u8,
    },
}

/// The axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Axis {
    /// Where position 0 is, increments.
    zero: f64,
    referenced: bool,
    activity: Activity,
    /// Where the last motion leads; `None`: nowhere, or it was given up.
    target: Option<f64>,
    /// The last task was accepted and is still commanded.
    accepted: bool,
    outputs: u8,
    velocity_limited: bool,
    flying: flying::Flying,
    /// The switches of a homing.
    homing_axis: Option<inputs::Axis>,
    /// Speed of the step before.
    before: f64,
    accelerates: bool,
    decelerates: bool,
}

/// What a positioning drive shows besides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisStatus {
    /// LU.
    pub position: f64,
    /// Where the motion leads, LU; `None`: there is none.
    pub target: Option<f64>,
    /// The position has a reference.
    pub referenced: bool,
    /// The target is reached.
    pub target_reached: bool,
    /// The task was accepted.
    pub accepted: bool,
    /// The shaft follows within the limit.
    pub follows: bool,
    /// The setpoint stands.
    pub setpoint_stands: bool,
    /// It gets faster.
    pub accelerates: bool,
    /// It gets slower.
    pub decelerates: bool,
    /// 1 forward, -1 backward, 0 at rest.
    pub direction: i8,
    /// The velocity is that of the limit.
    pub velocity_limited: bool,
    /// At the software limits: minus, plus.
    pub at_software_limits: (bool, bool),
    /// The limit switches that hold and are reached: minus, plus.
    pub limit_switches: (bool, bool),
    /// The setpoint follows the shaft.
    pub tracks: bool,
    /// Referencing runs.
    pub homing: bool,
    /// Flying referencing waits for its probe.
    pub flying: bool,
    /// The last edge of the probe was outside of the outer window.
    pub mark_outside: bool,
    /// Whose motion runs.
    pub by: Option<Origin>,
    /// It goes on and on, without a target.
    pub endless: bool,
    /// The direct outputs, bit 0 for the first.
    pub outputs: u8,
}

impl Drive {
    /// Increments of an LU.
    fn unit(&self) -> f64 {
        INCREMENTS_PER_REVOLUTION / self.settings.of(Setting::LuPerRevolution)
    }

    /// Increments/s of 1000 LU/min.
    fn velocity_of(&self, velocity: f64) -> f64 {
        velocity * 1000.0 / 60.0 * self.unit()
    }

    /// Increments of a position in LU.
    fn place(&self, position: f64) -> f64 {
        self.axis.zero + position * self.unit()
    }

    /// LU of increments.
    fn position(&self, place: f64) -> f64 {
        (place - self.axis.zero) / self.unit()
    }

    /// Increments/s and increments/s^2 of 1000 LU/min and of parts of the most acceleration and deceleration.
    fn ramp(&self, velocity: f64, acceleration: f64, deceleration: f64) -> Ramp {
        let most = |setting| self.settings.of(setting) * 1000.0 * self.unit();
        let part = |part: f64| part.clamp(0.01, 1.0);
        Ramp {
            velocity: self.velocity_of(velocity.abs()),
            acceleration: most(Setting::MaxAcceleration) * part(acceleration),
            deceleration: most(Setting::MaxDeceleration) * part(deceleration),
        }
    }

    /// What a positioning drive shows besides.
    pub fn axis(&self) -> AxisStatus {
        let Self { axis, demand, plant, settings, .. } = self;
        let window = settings.of(Setting::Window) * self.unit();
        let most = settings.of(Setting::FollowingError) * self.unit();
        let target = axis.target;
        let is_there = |target: f64| demand.position == target && (plant.position - target).abs() <= window;
        let position = self.position(plant.position);
        let (low, high) = self.software_limits();
        let near = 0.5 * self.unit();
        let (by, endless) = match axis.activity {
            Activity::Travel { by, .. } => (Some(by), false),
            Activity::Endless { by, .. } => (Some(by), true),
            Activity::Waiting { number, .. } | Activity::Held { number } => {
                (Some(Origin::Block(number)), false)
            }
            Activity::Homing(_) | Activity::Idle => (None, false),
        };
        AxisStatus {
            position,
            target: target.map(|target| self.position(target)),
            referenced: axis.referenced,
            target_reached: by.is_none() && target.is_some_and(is_there),
            accepted: axis.accepted,
            follows: most == 0.0 || (demand.position - plant.position).abs() <= most,
            setpoint_stands: demand.velocity == 0.0,
            accelerates: axis.accelerates,
            decelerates: axis.decelerates,
            direction: if demand.velocity > 0.0 {
                1
            } else if demand.velocity < 0.0 {
                -1
            } else {
                0
            },
            velocity_limited: axis.velocity_limited,
            at_software_limits: (plant.position <= low + near, plant.position >= high - near),
            limit_switches: self.limit_switches(),
            tracks: self.task().track && axis.activity == Activity::Idle,
            homing: matches!(axis.activity, Activity::Homing(_)),
            flying: axis.flying.runs,
            mark_outside: axis.flying.outside,
            by,
            endless,
            outputs: axis.outputs,
        }
    }

    fn task(&self) -> Task {
        match self.command.setpoint {
            Setpoint::Position(task) => task,
            Setpoint::Speed(_) => Task::default(),
        }
    }

    fn switches(&self) -> Closed {
        let cam = Closed { home: self.task().cam, ..Closed::default() };
        self.inputs.closed(self.plant.position, self.axis.homing_axis).or(cam)
    }

    /// The limit switches that are reached, if they hold: minus, plus.
    fn limit_switches(&self) -> (bool, bool) {
        let on = self.settings.of(Setting::SwitchesOn) != 0.0 || self.task().limit_switches;
        let closed = self.switches();
        (on && closed.negative_limit, on && closed.positive_limit)
    }

    /// Increments; none while they are not switched on or the position has no reference.
    fn software_limits(&self) -> (f64, f64) {
        let on = self.settings.of(Setting::LimitsOn) != 0.0 || self.task().software_limits;
        if on && self.axis.referenced {
            (
                self.place(self.settings.of(Setting::LimitMinus)),
                self.place(self.settings.of(Setting::LimitPlus)),
            )
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        }
    }

    /// The axis is out of operation: what it did is given up.
    pub(super) const fn give_up(&mut self) {
        if !matches!(self.axis.activity, Activity::Idle) {
            self.axis.target = None;
        }
        self.axis.activity = Activity::Idle;
        self.axis.accepted = false;
        self.axis.homing_axis = None;
        (self.axis.accelerates, self.axis.decelerates) = (false, false);
    }

    /// A step in operation under these switches and this task.
    pub(super) fn follow_task(&mut self, control: &ppo_drive::Command, task: &Task) {
        let was = (self.command.control, self.task());
        // From a speed setpoint it begins at rest.
        let (before, last) = was;
        let rises = |now: bool, then: bool| now && !then;
        if task.track && self.axis.activity == Activity::Idle {
            self.demand.position = self.plant.position;
        }
        if rises(task.set_reference, last.set_reference) {
            self.set_reference();
        }
        if !control.enable_ramp {
            self.give_up();
        }
        self.choose_jog_of_axis(control, &before, task);
        self.choose_homing(task, &last);
        self.step_flying(task);
        if !control.enable_setpoint {
            self.axis.accepted = false;
        }
        if control.enable_ramp && rises(control.enable_setpoint, before.enable_setpoint) {
            self.begin(task);
        }
        self.follow_mdi(task);
        if rises(task.change_block, last.change_block) {
            self.change_block();
        }
        self.move_axis(control.run_ramp, task);
        let speed = self.demand.velocity.abs();
        (self.axis.accelerates, self.axis.decelerates) = (speed > self.axis.before, speed < self.axis.before);
        self.axis.before = speed;
        self.watch_axis();
    }

    fn set_reference(&mut self) {
        if self.axis.activity != Activity::Idle || self.demand.velocity != 0.0 {
            self.tell(Event::ReferenceRefused);
            return;
        }
        self.reference_at(self.demand.position);
    }

    /// This place is the reference position from now on.
    fn reference_at(&mut self, place: f64) {
        self.axis.zero = place - self.settings.of(Setting::ReferencePosition) * self.unit();
        self.axis.referenced = true;
        self.axis.homing_axis = None;
        self.tell(Event::Referenced);
    }

    fn choose_jog_of_axis(&mut self, control: &ppo_drive::Command, before: &ppo_drive::Command, task: &Task) {
        let asked = control.inching().filter(|_| control.enable_ramp);
        let jogs = matches!(
            self.axis.activity,
            Activity::Endless { by: Origin::Jog, .. } | Activity::Travel { by: Origin::Jog, .. }
        );
        let Some(asked) = asked else {
            if jogs {
                self.give_up();
            }
            return;
        };
        if asked_before(before) == Some(asked) {
            return;
        }
        if !(jogs || self.axis.activity == Activity::Idle) {
            self.tell(Event::JogRefused);
            return;
        }
        let (velocity, way) = match asked {
            Inching::One => (Setting::JogVelocity1, Setting::JogWay1),
            Inching::Two => (Setting::JogVelocity2, Setting::JogWay2),
        };
        let velocity = self.settings.of(velocity);
        let ramp = self.ramp(velocity, 1.0, 1.0);
        self.axis.activity = if task.incremental {
            let way = self.settings.of(way).copysign(velocity) * self.unit();
            let target = self.demand.position + way;
            self.axis.target = Some(target);
            Activity::Travel { by: Origin::Jog, target, ramp }
        } else {
            self.axis.target = None;
            Activity::Endless { by: Origin::Jog, velocity: self.velocity_of(velocity), ramp }
        };
    }

    /// Referencing begins with the edge, and ends where the command goes.
    fn choose_homing(&mut self, task: &Task, last: &Task) {
        match self.axis.activity {
            Activity::Homing(_) if !task.home => self.give_up(),
            Activity::Idle if task.home && !last.home && !task.fly => self.begin_homing(task.home_backward),
            Activity::Idle
            | Activity::Homing(_)
            | Activity::Travel { .. }
            | Activity::Endless { .. }
            | Activity::Waiting { .. }
            | Activity::Held { .. } => {}
        }
    }

    /// To the cam, and from there the other way round to the first zero mark behind it.
    fn begin_homing(&mut self, backward: bool) {
        let backward = backward || self.settings.of(Setting::HomingBackward) != 0.0;
        let number = match (self.settings.of(Setting::HomingCam) != 0.0, backward) {
            (true, false) => 7,
            (true, true) => 11,
            (false, false) => 34,
            (false, true) => 33,
        };
        let Some(method) = Method::of(number) else { return };
        let velocity = |setting| self.velocity_of(self.settings.of(setting));
        let ramp = self.ramp(1.0, 1.0, 1.0);
        let speeds = Speeds {
            switch: velocity(Setting::HomingVelocity),
            zero: velocity(Setting::ZeroMarkVelocity),
            ramp: ramp.acceleration,
        };
        if self.inputs.switches == Switches::WhileHoming {
            self.axis.homing_axis = Some(inputs::Axis::around(self.plant.position, method.home_switch()));
        }
        let homing = Homing::begin(method, speeds, self.demand.position, self.switches());
        (self.axis.activity, self.axis.target) = (Activity::Homing(homing), None);
        self.axis.referenced = false;
        self.tell(Event::Homing);
    }

    /// The edge of STW1 bit 6.
    fn begin(&mut self, task: &Task) {
        if matches!(self.axis.activity, Activity::Homing(_) | Activity::Endless { by: Origin::Jog, .. }) {
            self.tell(Event::TaskRefused);
            return;
        }
        match task.mdi {
            Some(mdi) => self.begin_mdi(&mdi),
            None => self.begin_block(task.block.into()),
        }
    }

    fn begin_mdi(&mut self, mdi: &Mdi) {
        let ramp = self.ramp(mdi.velocity, mdi.acceleration, mdi.deceleration);
        if mdi.set_up {
            let velocity = match (mdi.forward, mdi.backward) {
                (true, false) => ramp.velocity,
                (false, true) => -ramp.velocity,
                (true, true) | (false, false) => 0.0,
            };
            (self.axis.activity, self.axis.target) =
                (Activity::Endless { by: Origin::Mdi, velocity, ramp }, None);
            self.axis.accepted = true;
            return;
        }
        let from = match self.axis.activity {
            Activity::Travel { target, .. } => target,
            Activity::Idle
            | Activity::Endless { .. }
            | Activity::Homing(_)
            | Activity::Waiting { .. }
            | Activity::Held { .. } => self.demand.position,
        };
        let target = match mdi.absolute {
            true => self.place(mdi.target.into()),
            false => from + f64::from(mdi.target) * self.unit(),
        };
        self.travel(Origin::Mdi, target, ramp, mdi.absolute);
    }

    /// Begins a travel if the axis may go there.
    fn travel(&mut self, by: Origin, target: f64, ramp: Ramp, absolute: bool) {
        if absolute && !self.axis.referenced {
            self.tell(Event::NotReferenced);
            return;
        }
        let (low, high) = self.software_limits();
        if !(low..=high).contains(&target) {
            self.tell(Event::BeyondLimit);
            return;
        }
        (self.axis.activity, self.axis.target) = (Activity::Travel { by, target, ramp }, Some(target));
        self.axis.accepted = true;
        self.tell(Event::Travel { by });
    }

    /// What the master's own target does while it is commanded.
    fn follow_mdi(&mut self, task: &Task) {
        let runs = matches!(
            self.axis.activity,
            Activity::Travel { by: Origin::Mdi, .. } | Activity::Endless { by: Origin::Mdi, .. }
        );
        let Some(mdi) = task.mdi else {
            if runs {
                self.give_up();
            }
            return;
        };
        let changed = self.task().mdi != Some(mdi);
        let can =
            !matches!(self.axis.activity, Activity::Homing(_) | Activity::Endless { by: Origin::Jog, .. });
        // Setting up follows velocity and direction; a target only if it is taken over continuously.
        if runs && mdi.set_up || mdi.continuous && mdi.absolute && changed && can && self.axis.accepted {
            self.begin_mdi(&mdi);
        }
    }

    /// One step of what the axis does; `goes`: no intermediate stop is commanded.
    fn move_axis(&mut self, goes: bool, task: &Task) {
        let held = self.ramp(1.0, 1.0, 1.0);
        let most = self.velocity_of(self.settings.of(Setting::MaxVelocity));
        let part = task.velocity_part.max(0.0);
        let overridden =
            |ramp: Ramp| Ramp { velocity: (ramp.velocity * part).min(most).max(f64::MIN_POSITIVE), ..ramp };
        self.axis.velocity_limited = false;
        match self.axis.activity {
            Activity::Idle | Activity::Waiting { .. } | Activity::Held { .. } => {
                self.demand.step_velocity(0.0, held.deceleration, held.deceleration, STEP_SECONDS);
            }
            Activity::Travel { ramp, .. } | Activity::Endless { ramp, .. } if !goes || part == 0.0 => {
                self.demand.step_velocity(0.0, ramp.deceleration, ramp.deceleration, STEP_SECONDS);
            }
            Activity::Travel { by, target, ramp } => {
                self.axis.velocity_limited = ramp.velocity * part > most;
                self.step_travel(by, target, overridden(ramp));
            }
            Activity::Endless { velocity, ramp, .. } => {
                self.axis.velocity_limited = ramp.velocity * part > most;
                let speed = overridden(ramp).velocity;
                let target = if velocity == 0.0 { 0.0 } else { speed.copysign(velocity) };
                let (limits, ramps) = (self.software_limits(), (ramp.acceleration, ramp.deceleration));
                self.demand.step_velocity_within(limits, target, ramps, STEP_SECONDS);
            }
            Activity::Homing(homing) => self.step_homing(homing),
        }
        if let Activity::Waiting { number, left } = self.axis.activity {
            match left.checked_sub(1) {
                Some(left) => self.axis.activity = Activity::Waiting { number, left },
                None => self.block_done(number),
            }
        }
    }

    fn step_travel(&mut self, by: Origin, target: f64, ramp: Ramp) {
        let number = if let Origin::Block(number) = by { Some(number) } else { None };
        let block = number.and_then(|number| self.blocks.numbered(number.into()));
        let follows = |number: u8| self.blocks.after(number.into()).is_some();
        let flies =
            block.is_some_and(|block| block.then() == Continuation::Flying) && number.is_some_and(follows);
        let ahead = target - self.demand.position;
        if flies && ahead != 0.0 && self.demand.velocity * ahead >= 0.0 {
            self.demand.step_velocity(
                ramp.velocity.copysign(ahead),
                ramp.acceleration,
                ramp.deceleration,
                STEP_SECONDS,
            );
            let passed = (target - self.demand.position) * ahead <= 0.0;
            if let (true, Some(number)) = (passed, number) {
                self.block_done(number);
            }
            return;
        }
        if !self.demand.step_to(target, ramp, STEP_SECONDS) {
            return;
        }
        match number {
            Some(number) => self.block_done(number),
            None => self.axis.activity = Activity::Idle,
        }
        if self.axis.activity == Activity::Idle {
            self.tell(Event::Arrived);
        }
    }

    fn step_homing(&mut self, mut homing: Homing) {
        let closed = self.switches();
        match homing.step(&mut self.demand, self.plant.position, closed, STEP_SECONDS) {
            Progress::Running => self.axis.activity = Activity::Homing(homing),
            Progress::Done(home) => {
                self.axis.activity = Activity::Idle;
                self.reference_at(home);
            }
            Progress::Failed => {
                self.give_up();
                self.raise(Fault::Homing, 0);
            }
        }
    }

    /// Following error and limit switches.
    fn watch_axis(&mut self) {
        if !self.axis().follows {
            self.raise(Fault::FollowingError, 0);
        }
        let (minus, plus) = self.limit_switches();
        let velocity = self.demand.velocity;
        let runs_into = velocity > 0.0 && plus || velocity < 0.0 && minus;
        if runs_into && !matches!(self.axis.activity, Activity::Homing(_)) {
            self.raise(Fault::LimitSwitch, if velocity > 0.0 { 1 } else { -1 });
        }
    }

    /// Whether the axis has nothing to do.
    pub(super) fn axis_rests(&self) -> bool {
        match self.axis.activity {
            Activity::Idle | Activity::Held { .. } => true,
            Activity::Travel { .. }
            | Activity::Endless { .. }
            | Activity::Homing(_)
            | Activity::Waiting { .. } => false,
        }
    }

    /// Whether the axis has a reference.
    pub fn is_referenced(&self) -> bool {
        self.axis.referenced
    }
}

const fn asked_before(control: &ppo_drive::Command) -> Option<Inching> {
    control.inching()
}
