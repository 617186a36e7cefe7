//! A goal under way: each step with its SDO, its NMT command, its status words.

use super::course::{Act, ENABLE, HALT, Kept, MODE, Or, SHUTDOWN, STATUSWORD, SWITCH_ON, TARGET};
use super::{LOOK, NodeClient, NodeGoal, NodeOutcome, NodeTrouble, Pursuit, Task};
use crate::can_bus::canopen::{Abort, Address, NmtState};
use crate::can_bus::cia402::{Mode, State, Statusword};
use crate::client::course::{Shown, Time};
use crate::time::Instant;

/// What was before a goal, to be put back.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Before {
    /// When the node is asked next; `None` while it is not guarded.
    pub(super) next: Option<Instant>,
    /// 1017h, 100Ch, 100Dh.
    guarding: Option<[u16; 3]>,
    reading: [u16; 3],
    /// 6060h, if this client changed it.
    mode: Option<i8>,
    /// The mode in which this client turns it without a target.
    pub(super) turns: Option<i8>,
    /// The NMT state, if this client started the node.
    pub(super) nmt: Option<NmtState>,
}

/// The life time factor: so many guard times.
const FACTOR: u8 = 2;
const NO_MODE: i8 = 0;
/// The mode of inching.
const INCHING: i8 = Mode::ProfilePosition.code();
/// vl target velocity, of 16 bits.
const VL_TARGET: Address = Address::new(0x6042, 0);

impl Before {
    fn keep(&mut self, kept: Kept, value: u16) {
        let [heartbeat, guard_time, life_factor] = &mut self.reading;
        match kept {
            Kept::Heartbeat => *heartbeat = value,
            Kept::GuardTime => *guard_time = value,
            Kept::LifeFactor => {
                *life_factor = value;
                self.guarding.get_or_insert(self.reading);
            }
        }
    }
}

impl NodeClient {
    /// Begins the present step; behind the last the goal is reached.
    pub(super) fn step(&mut self, now: Instant, pursuit: Pursuit) {
        let Some(step) = pursuit.course.step() else { return self.end(NodeOutcome::Done) };
        self.task = Task::Pursuing(pursuit);
        self.due = now.saturating_add(self.limits.reaction);
        match step.act {
            Act::Start => {
                self.ask_state();
                self.look_at = Some(now.saturating_add(LOOK));
            }
            Act::Keep(kept) => self.ask(now, kept.at()),
            Act::Guard(kept) => {
                let time = self.limits.life.as_millis() / u128::from(FACTOR);
                self.put_kept(now, kept, [0, u16::try_from(time).unwrap_or(u16::MAX), FACTOR.into()]);
            }
            Act::Ask => {
                self.before.next = Some(now);
                self.step(now, pursuit.next());
            }
            Act::Mode => self.ask(now, MODE),
            Act::Enable => self.look_at = Some(now.saturating_add(LOOK)),
            Act::Halt => match self.before.turns {
                // From velocity to velocity it does not stand.
                Some(mode) if mode != INCHING && pursuit.goal.mode().code() != mode => {
                    self.before.turns = None;
                    self.control(now, HALT);
                }
                Some(_) | None => self.step(now, pursuit.next()),
            },
            Act::EndInching if self.before.turns == Some(INCHING) => {
                self.before.turns = None;
                self.control(now, ENABLE);
            }
            Act::EndInching => self.step(now, pursuit.next()),
            Act::Velocity => self.velocity(now, pursuit.goal),
            Act::Inch => {
                self.before.turns = Some(INCHING);
                self.control(now, pursuit.goal.word());
            }
            Act::Target => self.put(now, TARGET, &pursuit.goal.target().to_le_bytes()),
            Act::Word(word) => {
                if word & ENABLE != ENABLE {
                    self.before.turns = None;
                }
                self.control(now, word);
            }
            Act::PutBack(kept) => match self.before.guarding {
                Some(before) => self.put_kept(now, kept, before),
                None => self.step(now, pursuit.next()),
            },
            Act::ModeBack => match self.before.mode.take() {
                Some(mode) => self.put(now, MODE, &mode.to_le_bytes()),
                None => self.step(now, pursuit.next()),
            },
            Act::NmtBack => {
                if let Some(state) = self.before.nmt.filter(|state| *state != NmtState::Operational) {
                    self.nmt_to(state);
                    self.nmt = Some(state);
                }
                self.before = Before::default();
                self.step(now, pursuit.next());
            }
        }
    }

    fn velocity(&mut self, now: Instant, goal: NodeGoal) {
        let NodeGoal::Turn { mode, target, velocity } = goal else { return };
        self.before.turns = Some(mode.code());
        match i16::try_from(velocity) {
            Ok(velocity) if target == VL_TARGET => self.put(now, target, &velocity.to_le_bytes()),
            Ok(_) | Err(_) => self.put(now, target, &velocity.to_le_bytes()),
        }
    }

    fn put_kept(&mut self, now: Instant, kept: Kept, [heartbeat, guard_time, life_factor]: [u16; 3]) {
        let [factor, _] = life_factor.to_le_bytes();
        match kept {
            Kept::Heartbeat => self.put(now, kept.at(), &heartbeat.to_le_bytes()),
            Kept::GuardTime => self.put(now, kept.at(), &guard_time.to_le_bytes()),
            Kept::LifeFactor => self.put(now, kept.at(), &[factor]),
        }
    }

    /// The drive has confirmed a write.
    pub(super) fn confirmed(&mut self, now: Instant, pursuit: Pursuit) {
        let Some(step) = pursuit.course.step() else { return };
        if step.act == Act::Enable {
            self.look_at = Some(now.saturating_add(LOOK));
        } else if step.until.is_empty() {
            self.step(now, pursuit.next());
        } else {
            let limit = match step.time {
                Time::Reaction => self.limits.reaction,
                Time::Motion => self.limits.motion,
            };
            self.due = now.saturating_add(limit);
            self.look_at = Some(now.saturating_add(LOOK));
        }
    }

    /// A value was read for the present step.
    pub(super) fn value_read(&mut self, now: Instant, pursuit: Pursuit, word: u16) {
        let Some(step) = pursuit.course.step() else { return };
        match step.act {
            Act::Keep(kept) => {
                self.before.keep(kept, word);
                self.step(now, pursuit.next());
            }
            Act::Mode => self.mode_read(now, pursuit, word.to_le_bytes()[0].cast_signed()),
            Act::Enable => self.enable(now, pursuit, Statusword(word)),
            Act::Start
            | Act::Guard(_)
            | Act::Ask
            | Act::Halt
            | Act::EndInching
            | Act::Target
            | Act::Velocity
            | Act::Inch
            | Act::Word(_)
            | Act::PutBack(_)
            | Act::ModeBack
            | Act::NmtBack => self.seen(now, pursuit, Statusword(word)),
        }
    }

    /// 6060h was read. A travel leaves another mode to whoever chose it, unless that was this client.
    fn mode_read(&mut self, now: Instant, pursuit: Pursuit, mode: i8) {
        let wanted = pursuit.goal.mode().code();
        let chooses = pursuit.goal.chooses_mode();
        if mode == wanted {
            self.step(now, pursuit.next());
        } else if mode != NO_MODE && !chooses && self.before.mode.is_none() {
            self.fail(NodeTrouble::Mode { mode });
        } else {
            if chooses {
                self.before.mode.get_or_insert(mode);
            }
            self.put(now, MODE, &wanted.to_le_bytes());
        }
    }

    /// It is time to look at the NMT state or at the status word.
    pub(super) fn look(&mut self, now: Instant, pursuit: Pursuit) {
        match pursuit.course.step() {
            Some(step) if step.act == Act::Start => self.start(now, pursuit),
            Some(step) if step.act == Act::Mode => self.ask(now, MODE),
            Some(_) | None => self.ask(now, STATUSWORD),
        }
    }

    /// To OPERATIONAL: the state tells whether the node has followed.
    fn start(&mut self, now: Instant, pursuit: Pursuit) {
        match self.nmt {
            Some(NmtState::Operational) => {
                self.before.nmt.get_or_insert(NmtState::Operational);
                return self.step(now, pursuit.next());
            }
            Some(other @ (NmtState::PreOperational | NmtState::Stopped)) => {
                self.before.nmt.get_or_insert(other);
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

    /// One step on the way to operation enabled.
    fn enable(&mut self, now: Instant, pursuit: Pursuit, status: Statusword) {
        self.status = Some(status);
        let state = State::of(status).unwrap_or(State::NotReadyToSwitchOn);
        let command = match state {
            State::Fault | State::FaultReactionActive => {
                return self.fail(NodeTrouble::Fault { status: status.0 });
            }
            State::OperationEnabled => return self.step(now, pursuit.next()),
            State::NotReadyToSwitchOn => None,
            State::SwitchOnDisabled => Some(SHUTDOWN),
            State::ReadyToSwitchOn => Some(SWITCH_ON),
            State::SwitchedOn => Some(ENABLE),
            State::QuickStopActive => Some(0),
        };
        if now >= self.due {
            return self.fail(NodeTrouble::Stays { state, status: status.0 });
        }
        match command {
            Some(command) => self.control(now, command),
            None => self.look_at = Some(now.saturating_add(LOOK)),
        }
    }

    /// A status word behind the command of the step.
    fn seen(&mut self, now: Instant, pursuit: Pursuit, status: Statusword) {
        self.status = Some(status);
        let Some(step) = pursuit.course.step() else { return };
        match (step.shown(status.0), step.or) {
            (Shown::Lost, _) => self.fail(lost(status)),
            (Shown::Wait, _) if now < self.due => self.look_at = Some(now.saturating_add(LOOK)),
            (Shown::Done, _) | (Shown::Wait, Or::GoOn) => self.step(now, pursuit.next()),
            (Shown::Wait, Or::Fault) => self.fail(NodeTrouble::Fault { status: status.0 }),
            (Shown::Wait, Or::NotAcknowledged) => {
                self.fail(NodeTrouble::NotAcknowledged { status: status.0 });
            }
            (Shown::Wait, Or::NotReached) => self.fail(NodeTrouble::NotReached { status: status.0 }),
        }
    }

    /// The node has refused what the step asks of it, or does not answer.
    pub(super) fn step_refused(&mut self, now: Instant, pursuit: Pursuit, trouble: NodeTrouble) {
        let act = pursuit.course.step().map(|step| step.act);
        let is_absent = matches!(trouble, NodeTrouble::Refused { code: Abort::NO_OBJECT, .. });
        let device_state = matches!(trouble, NodeTrouble::Refused { code: Abort::DEVICE_STATE, .. });
        match (pursuit.goal, act) {
            // A drive that still runs down takes the mode a little later.
            (_, Some(Act::Mode)) if device_state && now < self.due => {
                self.look_at = Some(now.saturating_add(LOOK));
            }
            // What could not be put back does not keep from the rest.
            (NodeGoal::Leave, _)
            // A device without heartbeats goes without.
            | (_, Some(Act::Keep(Kept::Heartbeat) | Act::Guard(Kept::Heartbeat))) => {
                self.step(now, pursuit.next());
            }
            // Nor a node that has no node guarding, though nobody stops it then when the master is lost.
            (_, Some(Act::Keep(kept @ (Kept::GuardTime | Kept::LifeFactor)))) if is_absent => {
                self.before.keep(kept, 0);
                self.step(now, pursuit.next());
            }
            (_, Some(Act::Guard(Kept::GuardTime | Kept::LifeFactor))) if is_absent => {
                self.step(now, pursuit.next());
            }
            // A drive that takes no control word in this state is not enabled: there is nothing to stop.
            (NodeGoal::Stop, Some(Act::Word(word))) if word != 0 && device_state => {
                self.end(NodeOutcome::Done);
            }
            (_, _) => self.fail(trouble),
        }
    }
}

/// What has happened to a drive that has left operation, or says that its homing failed.
fn lost(status: Statusword) -> NodeTrouble {
    let Statusword(word) = status;
    match State::of(status).unwrap_or(State::NotReadyToSwitchOn) {
        State::Fault | State::FaultReactionActive => NodeTrouble::Fault { status: word },
        State::OperationEnabled => NodeTrouble::Homing { status: word },
        state @ (State::NotReadyToSwitchOn
        | State::SwitchOnDisabled
        | State::ReadyToSwitchOn
        | State::SwitchedOn
        | State::QuickStopActive) => NodeTrouble::Ended { state, status: word },
    }
}
