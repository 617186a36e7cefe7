//! What keeps the drive behind a node from moving now, in words of CANopen.

use core::fmt;

use super::AsdaA2;
use crate::can_bus::canopen::NmtState;
use crate::can_bus::cia402::{Controlword, State};
use crate::devices::asda_a2::{Alarm, Level};

/// One thing that keeps the drive from moving. `Display` is a sentence: what, where, and what to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Hindrance {
    /// Without supply.
    SwitchedOff,
    /// PDOs are not carried out in this NMT state.
    Nmt(NmtState),
    /// An alarm that is present.
    Alarm(Alarm),
    /// The main circuit is not supplied.
    MainCircuit,
    /// 6060h chooses no mode.
    NoMode,
    /// Not operation enabled.
    State(State, Level),
    /// Bit 8 of the controlword.
    Halt,
    /// The shaft cannot turn.
    Blocked,
}

impl AsdaA2 {
    /// What keeps the drive from moving now, the most important first. None: it moves, or waits for a start.
    pub(crate) fn why(&self) -> impl Iterator<Item = Hindrance> {
        let (servo, nmt) = (self.servo(), self.node().state());
        let on = nmt.is_some();
        let state = servo.state();
        let enabled = state == State::OperationEnabled;
        let when = |holds: bool, hindrance| (on && holds).then_some(hindrance);
        let behind = [
            when(!servo.inputs().main_circuit, Hindrance::MainCircuit),
            when(servo.mode().is_none(), Hindrance::NoMode),
            when(!enabled, Hindrance::State(state, servo.level())),
            when(enabled && servo.controlword().has(Controlword::HALT), Hindrance::Halt),
            when(servo.inputs().blocked, Hindrance::Blocked),
        ];
        let before = match nmt {
            None => Some(Hindrance::SwitchedOff),
            Some(NmtState::Operational) => None,
            Some(nmt @ (NmtState::PreOperational | NmtState::Stopped)) => Some(Hindrance::Nmt(nmt)),
        };
        let alarms = servo.alarms().iter().copied().filter(move |_| on).map(Hindrance::Alarm);
        before.into_iter().chain(alarms).chain(behind.into_iter().flatten())
    }
}

impl fmt::Display for Hindrance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SwitchedOff => f.write_str("the drive is switched off: switch its supply on"),
            Self::Nmt(state) => {
                write!(f, "NMT state {state}, PDOs are not carried out: send NMT start (01h)")
            }
            Self::Alarm(alarm) => write!(f, "alarm {alarm}: {}", alarm.text()),
            Self::MainCircuit => f.write_str("the main circuit has no supply"),
            Self::NoMode => f.write_str("no mode of operation is chosen: write 6060h"),
            Self::State(state, level) => {
                write!(f, "drive state '{state}': ")?;
                match (level, state) {
                    (_, State::OperationEnabled) => f.write_str("operation is enabled"),
                    (_, State::Fault | State::FaultReactionActive) => f.write_str(
                        "remove the cause of the alarm, then send 6040h = 0080h (bit 7 from 0 to 1)",
                    ),
                    (_, State::QuickStopActive) => f.write_str("send 6040h = 0000h, then 0006h"),
                    (
                        Level::Half,
                        State::NotReadyToSwitchOn
                        | State::SwitchOnDisabled
                        | State::ReadyToSwitchOn
                        | State::SwitchedOn,
                    ) => f.write_str("send 6040h = 000Fh"),
                    (Level::Full, State::NotReadyToSwitchOn | State::SwitchOnDisabled) => {
                        f.write_str("send 6040h = 0006h, then 0007h, then 000Fh")
                    }
                    (Level::Full, State::ReadyToSwitchOn) => f.write_str("send 6040h = 0007h, then 000Fh"),
                    (Level::Full, State::SwitchedOn) => f.write_str("send 6040h = 000Fh"),
                }
            }
            Self::Halt => f.write_str("bit 8 of 6040h is 1: halt"),
            Self::Blocked => f.write_str("the shaft is blocked"),
        }
    }
}
