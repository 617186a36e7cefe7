//! Any drive of CiA 402, without a bus: what its objects say is what it does.
//!
//! ```text
//!  write ──▶ settings ──▶ machine ──▶ motion: pp │ pv │ vl │ tq │ hm │ ip │ csp │ csv │ cst ──▶ Demand ──▶ plant
//!  read ◀── status ◀──────────────────────────────────────────────────────────────────────────────────┘
//! ```
//!
//! What a drive does not have, it has as the profile says; what a file leaves at 0 and would keep it from any motion is a
//! sensible number. Positions within are increments of the plant; units of the user exist only at the border.
//!
//! | file | holds |
//! | --- | --- |
//! | `settings` | the objects of the profile |
//! | `units` | units of the user |
//! | `machine` | states, option codes, faults |
//! | `motion` | what each mode demands in a step |
//! | `cyclic` | positions from cycle to cycle |
//! | `probe` | touch probe |
//! | `status` | statusword, windows, actual values |
//! | `fault` | faults with their codes |

mod cyclic;
mod fault;
mod machine;
mod motion;
mod probe;
mod settings;
mod status;
mod units;

pub(crate) use fault::Fault;
pub(crate) use settings::{Actual, Setting};

use super::servo::inputs::{Axis, Inputs};
use super::servo::news::{News, NewsUntold, Targets};
use super::servo::pace::{Pace, STEP_SECONDS};
use super::servo::plant::{Constants, Plant};
use super::servo::profile::Demand;
use super::servo::stopping::Stopping;
use crate::can_bus::cia402::{Controlword, Mode, State};
use crate::face::surroundings::{Input, Level};
use crate::time::Instant;
use crate::untold::Untold;
use cyclic::Cyclic;
use motion::Motion;
use probe::Probes;
use settings::Settings;
use status::Windows;
use units::Units;

/// Events that wait; the oldest make room.
const MAX_EVENTS: usize = 16;

/// What happened in the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    /// A fault began.
    Raised(Fault),
    /// It was reset.
    Cleared,
}

/// The drive.
#[derive(Clone, Debug)]
pub(crate) struct Drive {
    /// 6502h: bit n is mode n + 1.
    modes: u32,
    has_probe: bool,
    inputs: Inputs,
    settings: Settings,
    units: Units,
    state: State,
    control: Controlword,
    mode: Option<Mode>,
    motion: Motion,
    stopping: Option<Stopping>,
    demand: Demand,
    /// Torque demanded, in parts of the rated one.
    torque_demand: f64,
    plant: Plant,
    /// Where the user's zero is, increments.
    origin: f64,
    /// The switches of a homing of a motor without an axis.
    homing_axis: Option<Axis>,
    fault: Option<Fault>,
    /// A limit holds the motion back.
    limited: bool,
    cyclic: Cyclic,
    windows: Windows,
    probes: Probes,
    pace: Pace,
    events: Untold<Event, MAX_EVENTS>,
    news: NewsUntold<Fault>,
    targets: Targets,
}

impl Drive {
    /// Homing methods that it has.
    pub(crate) const METHODS: [u8; 32] = [
        1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29,
        30, 33, 34, 35, 37,
    ];

    /// A drive with these modes of 6502h, that was just switched on.
    pub(crate) fn new(modes: u32, has_probe: bool) -> Self {
        let settings = Settings::new();
        Self {
            modes,
            has_probe,
            inputs: Inputs::NOMINAL,
            units: Units::of(&settings),
            settings,
            state: State::SwitchOnDisabled,
            control: Controlword(0),
            mode: None,
            motion: Motion::Hold,
            stopping: None,
            demand: Demand::default(),
            torque_demand: 0.0,
            plant: Plant::new(Constants::DEFAULT),
            origin: 0.0,
            homing_axis: None,
            fault: None,
            limited: false,
            cyclic: Cyclic::default(),
            windows: Windows::default(),
            probes: Probes::default(),
            pace: Pace::resting(Instant::ZERO),
            events: Untold::new(),
            news: NewsUntold::new(),
            targets: Targets::default(),
        }
    }

    /// Power-on or a reset of the node: nothing is wrong, the shaft stays. The settings follow.
    pub(crate) fn restart(&mut self) {
        self.state = State::SwitchOnDisabled;
        self.control = Controlword(0);
        self.mode = None;
        self.fault = None;
        self.limited = false;
        self.cyclic = Cyclic::default();
        self.windows = Windows::default();
        self.probes = Probes::default();
        self.settings = Settings::new();
        self.units = Units::of(&self.settings);
        self.release();
        self.events.clear();
        self.pace.wake();
    }

    /// The supply is switched off: the shaft runs out.
    pub(crate) fn power_off(&mut self) {
        self.state = State::SwitchOnDisabled;
        self.release();
        self.plant.velocity = 0.0;
        self.pace.rest();
    }

    /// Whether a master may set that.
    #[expect(clippy::wildcard_enum_match_arm, reason = "the others take every number")]
    pub(crate) fn accepts(&self, setting: Setting, value: i64) -> bool {
        use crate::can_bus::cia402::{Disabling, FaultReaction, Halt, QuickStop};
        use crate::devices::servo::homing::Method;
        let code = i16::try_from(value).unwrap_or(i16::MAX);
        match setting {
            Setting::Mode => value == 0 || self.offers(value),
            // Codes below zero are of the device, 0 of 605Dh is of older versions of the profile.
            Setting::QuickStopOption => code < 0 || QuickStop::of(code).is_some(),
            Setting::ShutdownOption | Setting::DisableOption => code < 0 || Disabling::of(code).is_some(),
            Setting::HaltOption => code <= 0 || Halt::of(code).is_some(),
            Setting::FaultOption => code < 0 || FaultReaction::of(code).is_some(),
            Setting::HomingMethod => matches!(value, i64::MIN..=0 | 35 | 37) || Method::of(value).is_some(),
            _ => true,
        }
    }

    /// Whether it has the mode of this code.
    pub(crate) fn offers(&self, code: i64) -> bool {
        let mode = i8::try_from(code).ok().and_then(Mode::of);
        mode.is_some_and(|mode| self.modes >> (mode.code() - 1) & 1 == 1)
    }

    /// Sets a value, with all that follows from it.
    #[expect(clippy::wildcard_enum_match_arm, reason = "the others act when they are used")]
    pub(crate) fn set(&mut self, setting: Setting, value: i64) {
        self.settings.set(setting, value);
        self.pace.wake();
        match setting {
            Setting::Controlword => {
                self.control(Controlword(u16::try_from(value).unwrap_or_default()));
            }
            Setting::Mode => self.enter_mode(),
            Setting::TargetPosition | Setting::IpTarget => self.cyclic_written(),
            Setting::ProbeFunction => self.probes.choose(value),
            _ => self.units = Units::of(&self.settings),
        }
    }

    /// What surrounds the drive.
    pub(crate) const fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// Each input with its level.
    pub(crate) fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        self.inputs.each_level(tell);
        if self.has_probe {
            self.probes.each_level(tell);
        }
    }

    /// Changes an input; says whether there is one of that name.
    pub(crate) fn set_input(&mut self, name: &str, level: Level) -> bool {
        let changed = self.inputs.change(name, level);
        let position = self.user_position(self.plant.position);
        let changed = changed || self.has_probe && self.probes.change(name, level, position);
        if changed {
            self.pace.wake();
        }
        changed
    }

    /// What an input is when everything is as it should be.
    pub(crate) fn nominal(name: &str) -> Option<Level> {
        Inputs::NOMINAL.level(name).or_else(|| Probes::default().level(name))
    }

    /// Every input is as it should be.
    pub(crate) fn make_nominal(&mut self) {
        self.inputs = Inputs { switches: self.inputs.switches, ..Inputs::NOMINAL };
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
        self.limited = false;
        let drive = self.demand_of_step();
        self.plant.limit = self.torque_limit();
        self.plant.advance(STEP_SECONDS, drive, &self.inputs);
        self.watch_plant();
        if self.rests() {
            self.pace.rest();
        }
    }

    /// What happened, in words.
    pub(crate) fn poll_news(&mut self) -> Option<News<Fault>> {
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
