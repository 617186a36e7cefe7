//! A drive with variable speed as PROFIDRIVE version 2 describes one, without a bus (`profidrive-v2.md`).
//!
//! The control word is a [`Command`] here, the status word a [`Status`]; `device::ppo_drive` has their bits. Where the
//! profile leaves something to the manufacturer, `docs/ppo-drive.md` says what this drive does.
//!
//! | file | holds |
//! | --- | --- |
//! | `command` | [`Command`]: what a master commands |
//! | `states` | [`State`]: the state machine of the profile |
//! | `motion` | ramp generator and plant |
//! | `faults` | [`Fault`], [`FaultBuffer`], [`Warnings`] |
//! | `settings` | [`Settings`]: times and speeds |
//! | `quantity` | [`Quantity`]: what a parameter can be tied to |
//! | `table` | [`table::Table`]: the parameters that a user gives (feature `std`) |
//!
//! ```
//! use core::time::Duration;
//! use profidrive::devices::ppo_drive::{Command, Drive, Settings, State};
//!
//! let mut drive = Drive::new(Settings { ramp_up: 1.0, ..Settings::DEFAULT });
//! let cycle = Duration::from_millis(1);
//! drive.step(cycle, Some(&Command { on: false, ..Command::run(0) }));
//! assert_eq!(drive.status().state, State::ReadyToSwitchOn);
//! for _ in 0..2000 {
//!     drive.step(cycle, Some(&Command::run(0x2000)));
//! }
//! assert_eq!((drive.status().state, drive.status().actual), (State::Operation, 0x2000));
//! ```

mod command;
mod faults;
mod motion;
#[cfg(feature = "std")]
pub mod profibus;
pub mod profile;
mod quantity;
mod settings;
mod states;
#[cfg(feature = "std")]
pub mod table;

use core::fmt;
use core::time::Duration;

pub use command::{Command, Inching};
pub use faults::{Fault, FaultBuffer, Noted, Warnings};
pub use quantity::{Quantity, SetError};
pub use settings::Settings;
pub use states::{Off, State};

use crate::untold::Untold;
use motion::{Demand, Motion};

/// The torque is at its limit for so long: a warning, in s.
const WARNS_AFTER: f64 = 0.5;
/// And a fault, in s.
const FAULT_AFTER: f64 = 5.0;
/// Setpoint and actual speed agree within this part of the reference speed.
const TOLERANCE: f64 = 0.03;
/// Events that wait.
const MAX_EVENTS: usize = 16;

/// A drive of the profile. It owns no clock: [`Drive::step`] is one application cycle.
#[derive(Clone, Debug)]
pub struct Drive {
    settings: Settings,
    state: State,
    motion: Motion,
    faults: FaultBuffer,
    warnings: Warnings,
    /// The command of the last cycle.
    command: Command,
    /// Inching was begun and is still asked for.
    inching: Option<Inching>,
    /// How long the torque is at its limit, s.
    overloaded: f64,
    events: Untold<Event, MAX_EVENTS>,
    /// The last step changed nothing.
    at_rest: bool,
}

/// What a drive shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// Its state.
    pub state: State,
    /// No OFF2 is commanded.
    pub no_off2: bool,
    /// No OFF3 is commanded.
    pub no_off3: bool,
    /// A warning stands.
    pub warning: bool,
    /// Setpoint and actual speed agree.
    pub in_tolerance: bool,
    /// The comparison speed is reached.
    pub speed_reached: bool,
    /// The actual speed: 4000h is 100 % of the reference speed.
    pub actual: i16,
}

/// News of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The state is another one.
    State(State),
    /// A fault came.
    Fault(Fault),
    /// The faults were acknowledged.
    Acknowledged,
    /// A warning came.
    Warning(u16),
    /// The machine takes another torque, in % of the rated torque.
    Load {
        /// Before.
        from: f64,
        /// Now.
        to: f64,
    },
    /// ON came while the drive brakes with OFF1.
    OnWhileSwitchingOff,
    /// Inching was asked for and is not begun: the shaft turns, or the setpoint is not locked.
    InchingRefused,
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::State(state) => write!(f, "state: {state}"),
            Self::Fault(fault) => {
                write!(f, "fault {fault}; next: acknowledge it (STW bit 7 from 0 to 1), then OFF1")
            }
            Self::Acknowledged => f.write_str("faults acknowledged; next: OFF1 (STW bit 0 = 0), then ON"),
            Self::Warning(number) => write!(f, "warning {number}"),
            Self::Load { from, to } => write!(f, "load changed from {from} % to {to} % of the rated torque"),
            Self::OnWhileSwitchingOff => f.write_str(
                "ON came while the drive switches off (OFF1): it switches on again when the shaft stands; next: OFF1 (STW bit \
                 0 = 0) if it shall stay off",
            ),
            Self::InchingRefused => {
                f.write_str("inching is not begun: the shaft must stand and STW bits 4, 5, 6 must be 0")
            }
        }
    }
}

impl Drive {
    /// A drive that is switched on now, its shaft at rest.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            state: State::default(),
            motion: Motion::default(),
            faults: FaultBuffer::default(),
            warnings: Warnings::default(),
            command: Command::default(),
            inching: None,
            overloaded: 0.0,
            events: Untold::new(),
            at_rest: false,
        }
    }

    /// What it shows.
    pub fn status(&self) -> Status {
        let Self { settings, state, motion, command, .. } = self;
        Status {
            state: *state,
            no_off2: command.no_off2,
            no_off3: command.no_off3,
            warning: self.warnings.is_present(),
            in_tolerance: (motion.ramp - motion.speed).abs() <= TOLERANCE * settings.reference_speed,
            speed_reached: motion.speed.abs() >= settings.comparison_speed,
            actual: settings.shown(motion.speed),
        }
    }

    /// Its settings.
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Its fault buffer.
    pub const fn faults(&self) -> &FaultBuffer {
        &self.faults
    }

    /// Its warnings.
    pub(crate) const fn warnings(&self) -> &Warnings {
        &self.warnings
    }

    /// One application cycle of this time; `None`: no master exchanges data.
    pub fn step(&mut self, time: Duration, command: Option<&Command>) {
        if command.is_none() && self.state.is_switched_on() {
            self.raise(Fault::Communication);
        }
        let command = command.copied().unwrap_or_default();
        let acknowledged = command.acknowledge && !self.command.acknowledge;
        let news = command != self.command;
        let before = self.state;
        if self.state == State::SwitchingOff(Off::Off1) && command.on && !self.command.on {
            self.tell(Event::OnWhileSwitchingOff);
        }
        if acknowledged && self.state == State::Fault {
            self.faults.acknowledge();
            self.tell(Event::Acknowledged);
            self.change(State::SwitchingOnInhibited);
        } else {
            self.change(self.state.next(&command, self.motion.stands(&self.settings)));
        }
        let demand = self.demand(&command);
        self.command = command;
        self.motion.step(time.as_secs_f64().max(f64::MIN_POSITIVE), demand, &self.settings);
        self.watch_torque(time.as_secs_f64());
        self.at_rest = !news && before == self.state && !self.state.is_supplied() && self.motion.is_still();
    }

    /// Whether another step under the same command changes nothing.
    pub(crate) const fn is_at_rest(&self) -> bool {
        self.at_rest
    }

    /// A fault comes: the motor is released.
    pub(crate) fn raise(&mut self, fault: Fault) {
        self.faults.note(fault.number());
        self.tell(Event::Fault(fault));
        self.change(State::Fault);
        self.at_rest = false;
    }

    /// The oldest event not taken yet.
    pub(crate) fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn change(&mut self, state: State) {
        if state != self.state {
            self.state = state;
            self.tell(Event::State(state));
        }
    }

    fn tell(&mut self, event: Event) {
        self.events.push(event);
    }

    fn demand(&mut self, command: &Command) -> Demand {
        match self.state {
            State::Operation => self.follow(command),
            State::SwitchingOff(off) => {
                self.inching = None;
                match off {
                    Off::Off1 => Demand::Off1,
                    Off::Off3 => Demand::Off3,
                }
            }
            State::SwitchingOnInhibited | State::ReadyToSwitchOn | State::Ready | State::Fault => {
                self.inching = None;
                Demand::Released
            }
        }
    }

    /// What the command asks of a motor in operation.
    fn follow(&mut self, command: &Command) -> Demand {
        let asked = command.inching();
        let begins = asked.is_some() && asked != self.command.inching();
        self.inching = match (self.inching, asked) {
            // Also from one inching speed to the other: on the ramp.
            (Some(_), Some(asked)) if command.setpoint_is_locked() => Some(asked),
            (_, Some(asked)) if begins => {
                if command.setpoint_is_locked() && self.motion.stands(&self.settings) {
                    Some(asked)
                } else {
                    self.tell(Event::InchingRefused);
                    None
                }
            }
            (_, Some(_) | None) => None,
        };
        match (self.inching, command) {
            (Some(inching), _) => Demand::Inch(inching),
            // Inching ends on the ramp.
            (None, _)
                if command.setpoint_is_locked() && !self.command.enable_ramp && self.motion.ramp != 0.0 =>
            {
                Demand::Ramp(0.0)
            }
            (None, Command { enable_ramp: false, .. }) => Demand::Zero,
            (None, Command { run_ramp: false, .. }) => Demand::Hold,
            (None, Command { enable_setpoint: false, .. }) => Demand::Ramp(0.0),
            (None, Command { setpoint, .. }) => Demand::Ramp(self.settings.speed_of(*setpoint)),
        }
    }

    /// A torque that is at its limit is a warning at first, and a fault later.
    fn watch_torque(&mut self, seconds: f64) {
        self.overloaded = if self.motion.limited { self.overloaded + seconds } else { 0.0 };
        let overload = self.overloaded >= WARNS_AFTER;
        if overload && !self.warnings.overload {
            self.warnings.note(Warnings::OVERLOAD);
            self.tell(Event::Warning(Warnings::OVERLOAD));
        }
        self.warnings.overload = overload;
        if self.overloaded >= FAULT_AFTER {
            self.overloaded = 0.0;
            self.raise(Fault::Overload);
        }
    }

    /// A warning stands from now on; 0: none does.
    fn raise_warning(&mut self, number: u16) {
        self.warnings.raised = number;
        if number != 0 {
            self.warnings.note(number);
            self.tell(Event::Warning(number));
        }
    }
}

#[cfg(test)]
mod tests;
