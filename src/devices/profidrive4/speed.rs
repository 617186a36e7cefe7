//! What a speed setpoint asks of the motor: ramp generator, jogging, braking.

use super::{Drive, Event, Setpoint, Setting};
use crate::devices::ppo_drive::{self, Inching};
use crate::devices::servo::pace::STEP_SECONDS;
use crate::devices::servo::plant::rpm;

impl Drive {
    /// The speed of this part of the reference speed, as far as the drive goes; increments/s.
    fn speed_of(&self, part: f64) -> f64 {
        self.limited(part * self.settings.of(Setting::ReferenceSpeed))
    }

    /// A speed in rpm as far as the drive goes; increments/s.
    fn limited(&self, speed: f64) -> f64 {
        let most = self.settings.of(Setting::MaxSpeed);
        rpm(if speed.is_nan() { 0.0 } else { speed.clamp(-most, most) })
    }

    /// The slope of a ramp time, increments/s^2; a time of 0 has none.
    fn slope(&self, time: Setting) -> f64 {
        let seconds = self.settings.of(time);
        let reference = rpm(self.settings.of(Setting::ReferenceSpeed));
        if seconds > 0.0 { reference / seconds } else { f64::MAX }
    }

    /// The ramp generator goes to a speed; increments/s.
    fn ramp_to(&mut self, speed: f64) {
        let (up, down) = (self.slope(Setting::RampUp), self.slope(Setting::RampDown));
        self.demand.step_velocity(speed, up, down, STEP_SECONDS);
    }

    /// The drive brakes with a ramp time.
    pub(super) fn brake(&mut self, time: Setting) {
        self.demand.forget_lost_way(self.plant.position);
        let slope = self.slope(time);
        self.demand.step_velocity(0.0, slope, slope, STEP_SECONDS);
    }

    /// A step in operation under these switches and this part of the reference speed.
    pub(super) fn follow_speed(&mut self, control: &ppo_drive::Command, part: f64) {
        self.demand.forget_lost_way(self.plant.position);
        self.choose_jog(control);
        match (self.jog, control) {
            (Some(jog), _) => self.ramp_to(self.jog_speed(jog)),
            // Jogging ends on the ramp.
            (None, _)
                if control.setpoint_is_locked()
                    && !self.command.control.enable_ramp
                    && self.demand.velocity != 0.0 =>
            {
                self.ramp_to(0.0);
            }
            (None, ppo_drive::Command { enable_ramp: false, .. }) => {
                self.demand.velocity = 0.0;
            }
            (None, ppo_drive::Command { run_ramp: false, .. }) => {
                self.demand.position += self.demand.velocity * STEP_SECONDS;
            }
            (None, ppo_drive::Command { enable_setpoint: false, .. }) => self.ramp_to(0.0),
            (None, _) => self.ramp_to(self.speed_of(part)),
        }
    }

    fn jog_speed(&self, jog: Inching) -> f64 {
        let setting = match jog {
            Inching::One => Setting::Jog1,
            Inching::Two => Setting::Jog2,
        };
        self.limited(self.settings.of(setting))
    }

    /// Jogging begins at standstill with the setpoint locked, and goes on while it is asked for.
    fn choose_jog(&mut self, control: &ppo_drive::Command) {
        let asked = control.inching();
        let begins = asked.is_some() && asked != self.command.control.inching();
        self.jog = match (self.jog, asked) {
            // Also from one speed to the other: on the ramp.
            (Some(_), Some(asked)) if control.setpoint_is_locked() => Some(asked),
            (_, Some(asked)) if begins => {
                if control.setpoint_is_locked() && self.stands() {
                    Some(asked)
                } else {
                    self.tell(Event::JogRefused);
                    None
                }
            }
            (_, Some(_) | None) => None,
        };
    }

    /// Whether the ramp generator has nothing to do.
    pub(super) fn ramp_is_done(&self) -> bool {
        let Setpoint::Speed(part) = self.command.setpoint else { return self.axis_rests() };
        let control = &self.command.control;
        if !self.state.is_supplied() {
            return true;
        }
        let target = match self.jog {
            Some(jog) => self.jog_speed(jog),
            None if !control.enable_ramp || !control.enable_setpoint => 0.0,
            None if !control.run_ramp => self.demand.velocity,
            None => self.speed_of(part),
        };
        self.demand.velocity == target
    }
}
