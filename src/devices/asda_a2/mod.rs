//! The servo drive Delta ASDA-A2 with its motor, without a bus (CANopen Technical Guide ASDA-A2, V2.01).
//!
//! ```text
//!  control ──▶ machine ──▶ motion: position │ velocity │ torque │ homing │ interpolation ──▶ Demand ──▶ plant
//!  set ──▶ settings ─────────┘                                                                 │
//!  status, actual values ◀── status ◀──────────────────────────────────────────────────────────┘
//! ```
//!
//! Positions within are increments of the encoder since the drive was made; PUU of the user, counted from home, exist
//! only at the border (`Servo::puu`). Time advances in steps of 1 ms.
//!
//! | file | holds |
//! | --- | --- |
//! | `alarm` | alarms: numbers, error codes, texts |
//! | `settings` | every value that can be set, with its names on CANopen |
//! | `on_canopen` | how a setting looks there |
//! | `stored` | parameters without effect |
//! | `interpolation` | positions from SYNC to SYNC |
//! | `servo` beside it | load, plant, profiles, set-points, homing of any servo drive |
//! | `machine` | states, alarms and what they do to the motion |
//! | `motion` | what each mode demands in a step |
//! | `keypad` | the keys and digits of the front |
//! | [`status`] | statusword and actual values |

pub(crate) mod alarm;
pub mod canopen;
mod interpolation;
mod keypad;
mod machine;
mod motion;
mod on_canopen;
pub(crate) mod settings;
pub mod status;
mod stored;

use heapless::Vec;

pub use super::servo::{inputs, plant};
pub use alarm::{Alarm, Clearing, Effect};
pub use inputs::{Axis, Closed, Inputs, Switches};
pub use plant::Constants;
pub(crate) use settings::Digit;
pub use settings::{Setting, Settings};

use super::servo::news::{News, NewsUntold, Targets};
use super::servo::pace::{Pace, STEP_SECONDS};
use super::servo::stopping::Stopping;
use super::servo::{homing, position, profile, smooth};
use crate::can_bus::cia402::{Controlword, Mode, State};
use crate::time::Instant;
use crate::untold::Untold;
use alarm::InWords;
use motion::Motion;
use plant::Plant;
use profile::Demand;

/// Alarms at a time; more are not taken.
const MAX_ALARMS: usize = 8;
/// Events that wait; the oldest make room.
const MAX_EVENTS: usize = 16;

/// How the drive is bought and set up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// P1-01: half (0Bh) or full (0Ch) CANopen.
    pub level: Level,
    /// P3-00, 1 to 127; other numbers become the nearest.
    pub node: u8,
    /// What no manual states about the plant.
    pub constants: Constants,
    /// AL302 where a SYNC comes too early for P3-09.E. Off by default: masters on a PC are not punctual.
    pub early_sync_alarm: bool,
    /// What P3-10.Y = 0 ("free run") means for an error of the bus (CN-224): the servo goes off and the motor coasts. Off
    /// by default: the motor keeps running under the last command.
    pub bus_error_coasts: bool,
}

impl Config {
    /// A drive with full CANopen.
    pub const fn new(node: u8) -> Self {
        Self {
            level: Level::Full,
            node,
            constants: Constants::DEFAULT,
            early_sync_alarm: false,
            bus_error_coasts: false,
        }
    }
}

/// How much of CiA 402 the drive follows, chosen by P1-01 at the start (CN-223).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Level {
    /// P1-01 = 0Bh: one controlword switches the servo on.
    Half,
    /// P1-01 = 0Ch, and all that is no CANopen mode: state by state.
    Full,
}

impl Level {
    /// The level of a P1-01, whose digits B and A count.
    pub(crate) const fn of(control_mode: i64) -> Self {
        if control_mode & 0xFF == Self::Half.control_mode() { Self::Half } else { Self::Full }
    }

    /// P1-01 of this level.
    pub(crate) const fn control_mode(self) -> i64 {
        match self {
            Self::Half => 0x0B,
            Self::Full => 0x0C,
        }
    }

    /// The controlword after a start.
    pub(crate) const fn controlword(self) -> Controlword {
        match self {
            Self::Half => Controlword(0),
            Self::Full => Controlword::QUICK_STOP,
        }
    }
}

/// What happened in the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event {
    /// An alarm began.
    Raised(Alarm),
    /// Alarms ended; these bits of the error register are left.
    Cleared(u8),
    /// The drive started: nothing is wrong yet.
    Restarted,
}

/// The drive.
#[derive(Clone, Debug)]
pub struct Servo {
    config: Config,
    inputs: Inputs,
    settings: Settings,
    kept: Settings,
    level: Level,
    state: State,
    control: Controlword,
    mode: Option<Mode>,
    motion: Motion,
    stopping: Option<Stopping>,
    demand: Demand,
    /// The linear motion behind a demand without corners.
    smooth: Option<smooth::Smooth>,
    /// Torque demanded, in parts of the rated one.
    torque_demand: f64,
    plant: Plant,
    /// Where the user's zero is, increments.
    origin: f64,
    /// The switches of a homing of a motor without an axis.
    homing_axis: Option<Axis>,
    alarms: Vec<Alarm, MAX_ALARMS>,
    error_code: u16,
    /// Warnings whose cause is present.
    causes: machine::Causes,
    following_error: bool,
    /// For how long position or velocity have been in their window, ms.
    in_window: u32,
    /// 60C1h was written since the mode was entered.
    has_point: bool,
    pace: Pace,
    events: Untold<Event, MAX_EVENTS>,
    news: NewsUntold<InWords>,
    targets: Targets,
}

impl Servo {
    /// A drive that was just switched on at `now`.
    pub(crate) fn new(config: Config, now: Instant) -> Self {
        let mut kept = Settings::new();
        kept.set(Setting::ControlMode, config.level.control_mode());
        kept.set(Setting::NodeNumber, config.node.into());
        let mut servo = Self {
            config,
            inputs: Inputs::NOMINAL,
            settings: kept.clone(),
            kept,
            level: config.level,
            state: State::SwitchOnDisabled,
            control: Controlword(0),
            mode: None,
            motion: Motion::Hold,
            stopping: None,
            demand: Demand::default(),
            smooth: None,
            torque_demand: 0.0,
            plant: Plant::new(config.constants),
            origin: 0.0,
            homing_axis: None,
            alarms: Vec::new(),
            error_code: 0,
            causes: machine::Causes::default(),
            following_error: false,
            in_window: 0,
            has_point: false,
            pace: Pace::resting(now),
            events: Untold::new(),
            news: NewsUntold::new(),
            targets: Targets::default(),
        };
        servo.power_on();
        servo
    }

    /// A reset of the node: as power-on, but a servo that was on goes off with AL401.
    pub(crate) fn restart(&mut self) {
        let was_on = self.is_on();
        self.power_on();
        if was_on {
            self.raise(Alarm::NmtWhileOn);
        }
    }

    /// Power-on: kept values come back, nothing is wrong. The shaft and the encoder stay.
    pub(crate) fn power_on(&mut self) {
        self.settings.start(&self.kept);
        self.level = Level::of(self.settings.of(Setting::ControlMode));
        self.control = self.level.controlword();
        self.alarms.clear();
        self.causes = machine::Causes::default();
        self.error_code = 0;
        self.following_error = false;
        self.state = State::SwitchOnDisabled;
        self.stopping = None;
        self.mode = None;
        self.motion = Motion::Hold;
        self.torque_demand = 0.0;
        self.homing_axis = None;
        self.enter_mode();
        self.tell(Event::Restarted);
        self.pace.wake();
    }

    /// The level in force since the last start.
    pub(crate) const fn level(&self) -> Level {
        self.level
    }

    /// The values in effect.
    pub(crate) const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The values that come back with a start.
    pub(crate) const fn kept(&self) -> &Settings {
        &self.kept
    }

    /// Sets a value that comes back with a start, as read from a memory.
    pub(crate) fn recall(&mut self, setting: Setting, value: i64) {
        self.kept.set(setting, value);
    }

    /// Stores all values.
    pub(crate) fn store(&mut self) {
        self.kept.keep(&self.settings);
    }

    /// The next start brings the defaults. Mode, node number and rate (P1-01, P3-00, P3-01) stay.
    pub(crate) fn restore(&mut self) {
        self.kept.restore();
    }

    /// Sets a value, with all that follows from it.
    pub(crate) fn set(&mut self, setting: Setting, value: i64) {
        let before = self.settings.of(setting);
        self.settings.set(setting, value);
        self.pace.wake();
        if setting == Setting::Mode {
            self.enter_mode();
        }
        if setting == Setting::InterpolationPosition {
            self.has_point = true;
        }
        if setting == Setting::SpecialWrite {
            self.special_write(before, value);
        }
    }

    /// Sets a parameter without effect.
    pub(crate) fn set_stored(&mut self, place: usize, value: i32) {
        self.settings.set_stored(place, value);
    }

    /// Sets a parameter without effect that comes back with a start, as read from a memory.
    pub(crate) fn recall_stored(&mut self, place: usize, value: i32) {
        self.kept.set_stored(place, value);
    }

    /// What surrounds the drive.
    pub(crate) const fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// Changes what surrounds the drive. A torque that is no number is no load.
    pub(crate) fn set_inputs(&mut self, inputs: Inputs) {
        self.inputs = inputs.finite();
        self.pace.wake();
    }

    /// The next event.
    pub(crate) fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    /// When [`advance`](Self::advance) is due, `None` while nothing moves.
    pub(crate) fn poll_timeout(&self) -> Option<Instant> {
        self.pace.poll_timeout()
    }

    /// Lets time pass up to `now`.
    pub(crate) fn advance(&mut self, now: Instant) {
        while self.pace.begin_step(now) {
            self.step();
        }
    }

    fn step(&mut self) {
        self.watch();
        let drive = self.demand_of_step();
        self.plant.advance(STEP_SECONDS, drive, &self.inputs);
        self.watch_plant();
        if self.rests() {
            self.pace.rest();
        }
    }

    /// What happened, in words.
    pub(crate) fn poll_news(&mut self) -> Option<News<InWords>> {
        self.news.pop()
    }

    /// A control word was taken: whether it misses a target. `at_once`: it came alone, by SDO.
    pub(crate) fn look_at_target(&mut self, at_once: bool) {
        let target = self.settings.of(Setting::TargetPosition);
        if let Motion::Position(_) = self.motion
            && self.state == State::OperationEnabled
            && let Some(news) = self.targets.kept(self.control, target, at_once)
        {
            self.news.push(news);
        }
    }

    fn tell(&mut self, event: Event) {
        self.events.push(event);
    }
}
