//! What the test master does otherwise than most, and rightly: nobody may accuse it of one of these.

use core::time::Duration;

use profidrive::profibus::fdl::Service;

use super::requests::short;
use super::slave::State;
use super::{Configured, TestMaster};

/// An unusual and legal habit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Habit {
    /// Slave_Diag in each exchange of this number.
    DiagnosesEach(u32),
    /// Get_Cfg before Set_Prm.
    ReadsCfg,
    /// A station that does not answer is asked for its FDL status before it is asked for more.
    AsksStatus,
    /// Two Slave_Diags before Set_Prm.
    DiagnosesTwice,
    /// Global_Control in each cycle.
    ControlsEachCycle,
    /// Pauses of all lengths up to four times the usual one.
    Jitters,
    /// A pause behind each station, too.
    PausesEach,
    /// CLEAR for so many cycles.
    ClearFor(u32),
    /// A station that does not answer is asked again in each cycle of this number.
    AsksLostEach(u32),
    /// After so many cycles it becomes slow: its pauses are so many times as long.
    SlowsAfter(u32, u32),
    /// Requests of low priority.
    LowPriority,
    /// min T_SDR 0: the slave keeps its own.
    KeepsTsdr,
    /// The watchdog of the second station has twice the time of the first.
    TwoWatchdogs,
    /// Stations are started one after the other.
    StartsOneByOne,
}

impl TestMaster {
    pub(super) fn has(&self, habit: Habit) -> bool {
        self.settings.habits.contains(&habit)
    }

    /// The first number that a habit gives.
    fn number(&self, of: impl Fn(Habit) -> Option<u32>) -> Option<u32> {
        self.settings.habits.iter().copied().find_map(of)
    }

    /// How many cycles CLEAR lasts.
    pub(super) fn cycles_of_clear(&self) -> u32 {
        let of = |habit| if let Habit::ClearFor(cycles) = habit { Some(cycles) } else { None };
        self.number(of).unwrap_or(20)
    }

    /// How many cycles are between two Global_Controls.
    pub(super) fn cycles_of_control(&self) -> u32 {
        if self.has(Habit::ControlsEachCycle) { 1 } else { 20 }
    }

    /// Between two cycles.
    pub(super) fn usual_pause(&self) -> Duration {
        let quarters =
            if self.has(Habit::Jitters) { self.cycles.wrapping_mul(2_654_435_761) >> 28 } else { 4 };
        let times = |habit: &Habit| match habit {
            Habit::SlowsAfter(cycles, times) if self.cycles > *cycles => Some(*times),
            _ => None,
        };
        self.settings.pause * quarters / 4 * self.settings.habits.iter().find_map(times).unwrap_or(1)
    }

    /// Whether it pauses now, before it asks the next station.
    pub(super) fn rests_before(&mut self, turn: usize) -> bool {
        let place = (self.cycles, turn);
        let rests = self.has(Habit::PausesEach) && turn > 0 && self.rested != place;
        self.rested = place;
        rests && self.slaves[turn].open.is_none()
    }

    pub(super) fn data_service(&self) -> Service {
        if self.has(Habit::LowPriority) { Service::SrdLow } else { Service::SrdHigh }
    }

    pub(super) fn least_tsdr(&self) -> u8 {
        if self.has(Habit::KeepsTsdr) { 0 } else { 11 }
    }

    pub(super) fn watchdog_of(&self, station: &Configured) -> Duration {
        let second = self.settings.stations.get(1).is_some_and(|second| second.address == station.address);
        self.settings.watchdog * if second && self.has(Habit::TwoWatchdogs) { 2 } else { 1 }
    }

    /// Whether a station has to wait for its turn.
    pub(super) fn lets_pass(&self, turn: usize) -> bool {
        let slave = &self.slaves[turn];
        let fresh = slave.open.is_none() && !slave.operational;
        let each = self.number(|habit| if let Habit::AsksLostEach(each) = habit { Some(each) } else { None });
        let rests = each.is_some_and(|each| slave.first_asks > 0 && !slave.turns.is_multiple_of(each));
        let begins = |slave: &super::Slave| slave.operational && slave.state != State::Exchange;
        let waits = self.has(Habit::StartsOneByOne) && self.slaves[..turn].iter().any(begins);
        fresh && (rests || waits)
    }

    /// A request that a habit puts before the usual one.
    pub(super) fn first_of_habit(&mut self, turn: usize) -> Option<Vec<u8>> {
        let each =
            self.number(|habit| if let Habit::DiagnosesEach(each) = habit { Some(each) } else { None });
        let asks_status = self.has(Habit::AsksStatus);
        let own = self.settings.address;
        let slave = &mut self.slaves[turn];
        if each.is_some_and(|each| slave.state == State::Exchange && slave.turns.is_multiple_of(each)) {
            slave.wants_diag = true;
        }
        let unknown = !slave.operational && !slave.is_there && slave.state == State::Diag1;
        slave.asks_status = asks_status && unknown;
        slave.asks_status.then(|| short(slave.configured.address, own, 0x49))
    }

    /// Get_Cfg is due.
    pub(super) fn reads_cfg(&self, turn: usize) -> bool {
        let slave = &self.slaves[turn];
        self.has(Habit::ReadsCfg) && slave.state == State::Prm && !slave.has_read_cfg
    }

    /// Whether a reply was to a request of a habit only.
    pub(super) fn takes_of_habit(&mut self, turn: usize) -> bool {
        if self.reads_cfg(turn) {
            self.slaves[turn].has_read_cfg = true;
            return true;
        }
        let twice = self.has(Habit::DiagnosesTwice);
        let slave = &mut self.slaves[turn];
        let first = twice && slave.state == State::Diag1 && !slave.has_diagnosed;
        slave.has_diagnosed |= first;
        first
    }
}
