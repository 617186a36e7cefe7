//! A travel, a homing, a stop: from status word to status word.

use super::guarding::Preparation;
use super::{
    ENABLE, Errand, LOOK, NodeClient, NodeOutcome, NodeTrouble, SHUTDOWN, START, SWITCH_ON, TARGET, Task,
};
use crate::can_bus::canopen::NmtState;
use crate::can_bus::cia402::{State, Statusword};
use crate::time::Instant;

impl NodeClient {
    /// To OPERATIONAL: the state tells whether the node has followed.
    pub(super) fn enter(&mut self, now: Instant, errand: Errand) {
        match self.nmt {
            Some(NmtState::Operational) => {
                self.guard.nmt.get_or_insert(NmtState::Operational);
                match errand {
                    Errand::MoveTo(_) | Errand::Home => self.prepare(now, errand, Preparation::ReadHeartbeat),
                    Errand::Acknowledge => {
                        self.go(now, Task::Clear, self.limits.reaction);
                        self.control(now, 0);
                    }
                }
                return;
            }
            Some(other @ (NmtState::PreOperational | NmtState::Stopped)) => {
                self.guard.nmt.get_or_insert(other);
                self.nmt_to(NmtState::Operational);
            }
            // With heartbeats the request is not answered; some nodes answer neither.
            None => self.nmt_to(NmtState::Operational),
        }
        if now >= self.due {
            return self.fail(NodeTrouble::NotOperational);
        }
        self.ask_state();
        self.look_at = Some(now.saturating_add(LOOK * 4));
    }

    /// One step on the way to operation enabled; an answer of no octets is that of a control word.
    pub(super) fn enable(&mut self, now: Instant, errand: Errand, len: usize, word: u16) {
        let look = |this: &mut Self| this.look_at = Some(now.saturating_add(LOOK));
        if len == 0 {
            return look(self);
        }
        self.status = Some(Statusword(word));
        let state = State::of(Statusword(word)).unwrap_or(State::NotReadyToSwitchOn);
        let command = match state {
            State::Fault | State::FaultReactionActive => {
                return self.fail(NodeTrouble::Fault { status: word });
            }
            State::OperationEnabled => {
                return match errand {
                    Errand::MoveTo(target) => {
                        self.go(now, Task::Target, self.limits.reaction);
                        self.put(now, TARGET, &target.to_le_bytes());
                    }
                    Errand::Home => {
                        self.go(now, Task::StartHoming, self.limits.reaction);
                        self.control(now, START);
                    }
                    Errand::Acknowledge => self.end(NodeOutcome::Done),
                };
            }
            State::NotReadyToSwitchOn => None,
            State::SwitchOnDisabled => Some(SHUTDOWN),
            State::ReadyToSwitchOn => Some(SWITCH_ON),
            State::SwitchedOn => Some(ENABLE),
            State::QuickStopActive => Some(0),
        };
        if now >= self.due {
            return self.fail(NodeTrouble::Stays { state, status: word });
        }
        match command {
            Some(command) => self.control(now, command),
            None => look(self),
        }
    }

    /// A status word of a travel or a stop.
    pub(super) fn seen(&mut self, now: Instant, status: Statusword) {
        self.status = Some(status);
        let word = status.0;
        let late = now >= self.due;
        let state = State::of(status).unwrap_or(State::NotReadyToSwitchOn);
        let enabled = state == State::OperationEnabled;
        match self.task {
            Task::Acknowledged | Task::Travel | Task::Homing if !enabled => {
                return self.fail(match state {
                    State::Fault | State::FaultReactionActive => NodeTrouble::Fault { status: word },
                    State::NotReadyToSwitchOn
                    | State::SwitchOnDisabled
                    | State::ReadyToSwitchOn
                    | State::SwitchedOn
                    | State::OperationEnabled
                    | State::QuickStopActive => NodeTrouble::Ended { state, status: word },
                });
            }
            Task::Acknowledged if status.has(Statusword::SET_POINT_ACKNOWLEDGE) => {
                self.go(now, Task::Release, self.limits.reaction);
                return self.control(now, ENABLE);
            }
            Task::Acknowledged if late => return self.fail(NodeTrouble::NotAcknowledged { status: word }),
            Task::Travel
                if status.has(Statusword::TARGET_REACHED)
                    && !status.has(Statusword::SET_POINT_ACKNOWLEDGE) =>
            {
                return self.end(NodeOutcome::Done);
            }
            Task::Travel if late => return self.fail(NodeTrouble::NotReached { status: word }),
            Task::Homing if status.has(Statusword::HOMING_ERROR) => {
                return self.fail(NodeTrouble::Homing { status: word });
            }
            Task::Homing if status.has(Statusword::HOMING_ATTAINED) => return self.end(NodeOutcome::Done),
            Task::Homing if late => return self.fail(NodeTrouble::NotReached { status: word }),
            Task::Acknowledging if !matches!(state, State::Fault | State::FaultReactionActive) => {
                return self.end(NodeOutcome::Done);
            }
            Task::Acknowledging if late => return self.fail(NodeTrouble::Fault { status: word }),
            // Standing or no longer in quick stop: nothing holds it there but this client.
            Task::Halting
                if state != State::QuickStopActive || status.has(Statusword::TARGET_REACHED) || late =>
            {
                self.go(now, Task::Coast, self.limits.reaction);
                return self.control(now, 0);
            }
            Task::Idle
            | Task::Read(_)
            | Task::Write(_)
            | Task::Enter(_)
            | Task::Prepare(..)
            | Task::Enable(_)
            | Task::Target
            | Task::Start
            | Task::Acknowledged
            | Task::Release
            | Task::Travel
            | Task::StartHoming
            | Task::Homing
            | Task::Clear
            | Task::Acknowledge
            | Task::Acknowledging
            | Task::Halt
            | Task::Halting
            | Task::Coast
            | Task::Leave(_) => {}
        }
        self.look_at = Some(now.saturating_add(LOOK));
    }
}
