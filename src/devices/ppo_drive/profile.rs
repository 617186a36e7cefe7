//! The bits of STW and ZSW as PROFIDRIVE version 2 has them for a speed drive (`profidrive-v2.md` 8), once.
//!
//! The AG03 departs from them in places; its words are in [`bits`](crate::devices::ag03::profibus::bits). [`reasons()`]
//! says what the words of a drive say against turning.

#[cfg(feature = "std")]
mod drive_state;
#[cfg(feature = "std")]
mod not_followed;
mod reasons;

#[cfg(feature = "std")]
pub use not_followed::NotFollowed;
pub use reasons::reasons;
#[cfg(feature = "std")]
pub(super) use reasons::reasons_of_drive;

use crate::devices::ppo_drive::{Command, State, Status};
use crate::face::bits_of_word;
use crate::profibus::ppo::{Stw, Zsw};

bits_of_word! {
    /// A bit of the control word.
    StwBit {
        /// ON; 0: OFF1.
        On = 0: "ON";
        /// 0: OFF2.
        NoOff2 = 1: "no OFF2";
        /// 0: OFF3.
        NoOff3 = 2: "no OFF3";
        /// 0: the motor is released.
        EnableOperation = 3: "enable operation";
        /// 0: the output of the ramp generator is 0.
        EnableRamp = 4: "enable ramp generator";
        /// 0: the output of the ramp generator holds.
        RunRamp = 5: "unfreeze ramp generator";
        /// 0: the input of the ramp generator is 0.
        EnableSetpoint = 6: "enable setpoint";
        /// From 0 to 1: acknowledge.
        Acknowledge = 7: "acknowledge fault";
        /// Inching 1.
        Inching1 = 8: "inching 1";
        /// Inching 2.
        Inching2 = 9: "inching 2";
        /// 0: the word is not looked at.
        ByPlc = 10: "control by PLC";
    }
}

bits_of_word! {
    /// A bit of the status word.
    ZswBit {
        /// S2 to S5.
        ReadyToSwitchOn = 0: "ready to switch on";
        /// S3 to S5.
        Ready = 1: "ready";
        /// S4.
        OperationEnabled = 2: "operation enabled";
        /// A fault is not acknowledged.
        Fault = 3: "fault";
        /// No OFF2 is commanded.
        NoOff2 = 4: "no OFF2";
        /// No OFF3 is commanded.
        NoOff3 = 5: "no OFF3";
        /// S1.
        SwitchingOnInhibited = 6: "switching on inhibited";
        /// A warning stands.
        Warning = 7: "warning";
        /// Setpoint and actual value agree.
        InTolerance = 8: "setpoint and actual value within tolerance";
        /// The drive wants its commands from the master.
        ControlRequested = 9: "control requested";
        /// The comparison speed is reached.
        SpeedReached = 10: "speed reached";
    }
}

/// What a control word and a main setpoint command; `None` with bit 10 = 0: what was commanded before holds.
pub(crate) fn command(stw: Stw, setpoint: i16) -> Option<Command> {
    StwBit::ByPlc.is_set(stw).then_some(Command {
        on: StwBit::On.is_set(stw),
        no_off2: StwBit::NoOff2.is_set(stw),
        no_off3: StwBit::NoOff3.is_set(stw),
        enable_operation: StwBit::EnableOperation.is_set(stw),
        enable_ramp: StwBit::EnableRamp.is_set(stw),
        run_ramp: StwBit::RunRamp.is_set(stw),
        enable_setpoint: StwBit::EnableSetpoint.is_set(stw),
        acknowledge: StwBit::Acknowledge.is_set(stw),
        inching_1: StwBit::Inching1.is_set(stw),
        inching_2: StwBit::Inching2.is_set(stw),
        setpoint,
    })
}

/// The status word of a drive.
pub(crate) fn zsw(status: &Status) -> Zsw {
    let (to_switch_on, ready, operation) = match status.state {
        State::SwitchingOnInhibited | State::Fault => (false, false, false),
        State::ReadyToSwitchOn => (true, false, false),
        State::Ready | State::SwitchingOff(_) => (true, true, false),
        State::Operation => (true, true, true),
    };
    let bits = [
        (ZswBit::ReadyToSwitchOn, to_switch_on),
        (ZswBit::Ready, ready),
        (ZswBit::OperationEnabled, operation),
        (ZswBit::Fault, status.state == State::Fault),
        (ZswBit::NoOff2, status.no_off2),
        (ZswBit::NoOff3, status.no_off3),
        (ZswBit::SwitchingOnInhibited, status.state == State::SwitchingOnInhibited),
        (ZswBit::Warning, status.warning),
        (ZswBit::InTolerance, status.in_tolerance),
        (ZswBit::ControlRequested, true),
        (ZswBit::SpeedReached, status.speed_reached),
    ];
    bits.into_iter().fold(Zsw::default(), |zsw, (bit, set)| zsw.with_bit(bit.number(), set))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::ppo_drive::Off;

    #[test]
    fn the_states_show_the_bits_of_the_reference() {
        // Bits 6, 3, 2, 1, 0 of `profidrive-v2.md` 8.
        for (state, bits) in [
            (State::SwitchingOnInhibited, 0x40),
            (State::ReadyToSwitchOn, 0x01),
            (State::Ready, 0x03),
            (State::Operation, 0x07),
            (State::SwitchingOff(Off::Off1), 0x03),
            (State::SwitchingOff(Off::Off3), 0x03),
            (State::Fault, 0x08),
        ] {
            let status = Status {
                state,
                no_off2: false,
                no_off3: false,
                warning: false,
                in_tolerance: false,
                speed_reached: false,
                actual: 0,
            };
            assert_eq!(zsw(&status).raw(), 0x0200 | bits, "{state}");
            let all = Status {
                no_off2: true,
                no_off3: true,
                warning: true,
                in_tolerance: true,
                speed_reached: true,
                ..status
            };
            assert_eq!(zsw(&all).raw(), 0x07B0 | bits, "{state}");
        }
    }

    #[test]
    fn the_control_word_047f_runs_and_bit_10_lets_it_through() {
        assert_eq!(command(Stw::from_raw(0x047F), 5), Some(Command::run(5)));
        assert_eq!(command(Stw::from_raw(0x007F), 5), None);
        for bit in StwBit::ALL.iter().filter(|bit| **bit != StwBit::ByPlc) {
            let one = command(Stw::from_raw(0x0400).with_bit(bit.number(), true), 0).unwrap();
            assert_ne!(one, Command::default(), "{}", bit.name());
        }
    }
}
