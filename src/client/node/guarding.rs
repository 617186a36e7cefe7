//! What is set up before a travel and put back behind it: guarding with a life time that the node supervises, and the mode.

use super::{CONTROLWORD, Errand, MODE, NodeClient, NodeOutcome, NodeTrouble, Task};
use crate::can_bus::canopen::{Address, NmtState};
use crate::can_bus::cia402::Mode;
use crate::time::Instant;

/// The entries of guarding, in the order in which they are read and written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Preparation {
    ReadHeartbeat,
    ReadGuardTime,
    ReadLifeFactor,
    Heartbeat,
    GuardTime,
    LifeFactor,
    ReadMode,
    Mode,
    Word,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Guard {
    /// When the node is asked next; `None` while it is not guarded.
    pub(super) next: Option<Instant>,
    /// 1017h, 100Ch, 100Dh as they were.
    pub(super) before: Option<[u16; 3]>,
    pub(super) reading: [u16; 3],
    /// 6060h as it was, if this client changed it.
    mode: Option<i8>,
    /// The NMT state before this client started the node.
    pub(super) nmt: Option<NmtState>,
}

const HEARTBEAT: Address = Address::new(0x1017, 0);
const GUARD_TIME: Address = Address::new(0x100C, 0);
const LIFE_FACTOR: Address = Address::new(0x100D, 0);
/// The life time factor: so many guard times.
const FACTOR: u8 = 2;

const NO_MODE: i8 = 0;

/// 6060h of an errand; on the AG03/1 1 is positioning.
const fn mode_for(errand: Errand) -> i8 {
    match errand {
        Errand::MoveTo(_) | Errand::Acknowledge => Mode::ProfilePosition.code(),
        Errand::Home => Mode::Homing.code(),
    }
}

impl NodeClient {
    pub(super) fn prepare(&mut self, now: Instant, errand: Errand, step: Preparation) {
        self.go(now, Task::Prepare(errand, step), self.limits.reaction);
        let guard_time = u16::try_from(self.limits.life.as_millis() / u128::from(FACTOR)).unwrap_or(u16::MAX);
        match step {
            Preparation::ReadHeartbeat
            | Preparation::ReadGuardTime
            | Preparation::ReadLifeFactor
            | Preparation::ReadMode => {
                self.ask(now, step.entry());
            }
            Preparation::Heartbeat => self.put(now, HEARTBEAT, &[0, 0]),
            Preparation::GuardTime => self.put(now, GUARD_TIME, &guard_time.to_le_bytes()),
            Preparation::LifeFactor => self.put(now, LIFE_FACTOR, &[FACTOR]),
            Preparation::Mode => self.put(now, MODE, &mode_for(errand).to_le_bytes()),
            Preparation::Word => {}
        }
    }

    /// 6060h was read. A travel leaves another mode to whoever chose it; a homing is asked for by its name.
    pub(super) fn mode_read(&mut self, now: Instant, errand: Errand, mode: i8) {
        if mode == mode_for(errand) {
            return self.prepared(now, errand, Preparation::Mode);
        }
        if mode != NO_MODE && errand != Errand::Home {
            return self.fail(NodeTrouble::Mode { mode });
        }
        if errand == Errand::Home {
            self.guard.mode.get_or_insert(mode);
        }
        self.prepare(now, errand, Preparation::Mode);
    }

    pub(super) fn prepared(&mut self, now: Instant, errand: Errand, step: Preparation) {
        let next = match step {
            Preparation::ReadHeartbeat => Preparation::ReadGuardTime,
            Preparation::ReadGuardTime => Preparation::ReadLifeFactor,
            Preparation::ReadLifeFactor => {
                self.guard.before.get_or_insert(self.guard.reading);
                Preparation::Heartbeat
            }
            Preparation::Heartbeat => Preparation::GuardTime,
            Preparation::GuardTime => Preparation::LifeFactor,
            Preparation::LifeFactor => {
                self.guard.next = Some(now);
                Preparation::ReadMode
            }
            Preparation::ReadMode | Preparation::Mode | Preparation::Word => {
                return self.watch(now, Task::Enable(errand), self.limits.reaction);
            }
        };
        self.prepare(now, errand, next);
    }

    /// One step of leaving is done, or cannot be done.
    pub(super) fn left(&mut self, now: Instant, step: Preparation) {
        let [heartbeat, guard_time, factor] = self.guard.before.unwrap_or_default();
        let next = match (step, self.guard.before) {
            (Preparation::Word, Some(_)) => Preparation::GuardTime,
            (Preparation::GuardTime, _) => Preparation::LifeFactor,
            (Preparation::LifeFactor, _) => Preparation::Heartbeat,
            (Preparation::Heartbeat, _) if self.guard.mode.is_some() => Preparation::Mode,
            (
                Preparation::ReadHeartbeat
                | Preparation::ReadGuardTime
                | Preparation::ReadLifeFactor
                | Preparation::Heartbeat
                | Preparation::ReadMode
                | Preparation::Mode
                | Preparation::Word,
                _,
            ) => {
                if let Some(state) = self.guard.nmt.filter(|state| *state != NmtState::Operational) {
                    self.nmt_to(state);
                    self.nmt = Some(state);
                }
                self.guard = Guard::default();
                return self.end(NodeOutcome::Done);
            }
        };
        self.go(now, Task::Leave(next), self.limits.reaction);
        match next {
            Preparation::GuardTime => self.put(now, GUARD_TIME, &guard_time.to_le_bytes()),
            Preparation::LifeFactor => self.put(now, LIFE_FACTOR, &factor.to_le_bytes()[..1]),
            Preparation::Mode => {
                let mode = self.guard.mode.take().unwrap_or(NO_MODE);
                self.put(now, MODE, &mode.to_le_bytes());
            }
            Preparation::ReadHeartbeat
            | Preparation::ReadGuardTime
            | Preparation::ReadLifeFactor
            | Preparation::Heartbeat
            | Preparation::ReadMode
            | Preparation::Word => self.put(now, HEARTBEAT, &heartbeat.to_le_bytes()),
        }
    }
}

impl Preparation {
    pub(super) const fn entry(self) -> Address {
        match self {
            Self::ReadHeartbeat | Self::Heartbeat => HEARTBEAT,
            Self::ReadGuardTime | Self::GuardTime => GUARD_TIME,
            Self::ReadLifeFactor | Self::LifeFactor => LIFE_FACTOR,
            Self::ReadMode | Self::Mode => MODE,
            Self::Word => CONTROLWORD,
        }
    }

    /// Where what is read is kept.
    pub(super) const fn place(self) -> Option<usize> {
        match self {
            Self::ReadHeartbeat => Some(0),
            Self::ReadGuardTime => Some(1),
            Self::ReadLifeFactor => Some(2),
            Self::Heartbeat
            | Self::GuardTime
            | Self::LifeFactor
            | Self::ReadMode
            | Self::Mode
            | Self::Word => None,
        }
    }
}
