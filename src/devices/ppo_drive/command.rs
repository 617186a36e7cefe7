//! What a master commands, without bits.

/// The control word and the main setpoint of one application cycle, as flags. `default()` commands nothing: OFF1, OFF2 and
/// OFF3 together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Command {
    /// ON; `false`: OFF1, brake on the ramp and switch off.
    pub on: bool,
    /// `false`: OFF2, release the motor and inhibit switching on.
    pub no_off2: bool,
    /// `false`: OFF3, brake with the quick-stop time and inhibit switching on.
    pub no_off3: bool,
    /// Enable operation; `false`: release the motor.
    pub enable_operation: bool,
    /// Enable the ramp generator; `false`: its output is 0 at once.
    pub enable_ramp: bool,
    /// Let the ramp generator run; `false`: its output holds.
    pub run_ramp: bool,
    /// Release the setpoint; `false`: the input of the ramp generator is 0.
    pub enable_setpoint: bool,
    /// Acknowledge a fault; the change from `false` to `true` counts.
    pub acknowledge: bool,
    /// Turn with inching speed 1.
    pub inching_1: bool,
    /// Turn with inching speed 2.
    pub inching_2: bool,
    /// The main setpoint: 4000h is 100 % of the reference speed.
    pub setpoint: i16,
}

impl Command {
    /// Everything released, standing: what a drive in operation follows with this setpoint.
    pub const fn run(setpoint: i16) -> Self {
        Self {
            on: true,
            no_off2: true,
            no_off3: true,
            enable_operation: true,
            enable_ramp: true,
            run_ramp: true,
            enable_setpoint: true,
            acknowledge: false,
            inching_1: false,
            inching_2: false,
            setpoint,
        }
    }

    /// The inching speed that is asked for. Both at once are none.
    pub(crate) const fn inching(&self) -> Option<Inching> {
        match (self.inching_1, self.inching_2) {
            (true, false) => Some(Inching::One),
            (false, true) => Some(Inching::Two),
            (true, true) | (false, false) => None,
        }
    }

    /// None of the bits that let the setpoint through: inching wants that.
    pub(crate) const fn setpoint_is_locked(&self) -> bool {
        !self.enable_ramp && !self.run_ramp && !self.enable_setpoint
    }
}

/// Which inching speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inching {
    /// Inching 1.
    One,
    /// Inching 2.
    Two,
}
