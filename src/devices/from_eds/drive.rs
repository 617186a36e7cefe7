//! The drive behind a file of CiA 402: which objects it has, and what the bus does to it.

use std::collections::VecDeque;

use super::FromEds;
use super::dictionary::{Dictionary, Row};
use crate::can_bus::canopen::dictionary::Entry;
use crate::can_bus::canopen::value::DataType;
use crate::can_bus::canopen::{
    Abort, Address, Emergency, NmtCause, NmtState, Notice, Request, Reset, Source, Value,
};
use crate::devices::cia402_drive::{Actual, Drive, Event, Fault, Setting};
use crate::eds::{Eds, Profile};
use crate::time::Instant;

/// Modes that a drive can have, as bits of 6502h.
const MODES: u32 = 0x3EF;

/// What an entry is to the drive of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Nothing: a value.
    Value,
    /// What the drive is told.
    Setting(Setting),
    /// What the drive tells.
    Actual(Actual),
}

impl Role {
    pub(super) fn of(eds: &Eds, at: Address, table: &Entry) -> Self {
        let (index, sub) = at.pair();
        if !table.data.kind().is_whole() {
            return Self::Value;
        }
        match (Setting::of(index, sub), Actual::of(index, sub)) {
            (Some(setting), _) => Self::Setting(setting),
            // What the file says stays.
            (None, Some(Actual::SupportedModes)) if said_modes(eds) != 0 => Self::Value,
            (None, Some(actual)) => Self::Actual(actual),
            (None, None) => Self::Value,
        }
    }
}

/// Whether the file has what makes a drive of CiA 402.
pub(super) fn is_driven(eds: &Eds) -> bool {
    let is_word = |index| eds.entry(index, 0).is_some_and(|entry| entry.data == DataType::U16);
    eds.profile() == Profile::Drive && is_word(0x6040) && is_word(0x6041)
}

/// 6502h, of the modes that there are.
fn said_modes(eds: &Eds) -> u32 {
    let said = eds.number(0x6502, 0).and_then(|modes| u32::try_from(modes).ok());
    said.unwrap_or_default() & MODES
}

/// The modes that the file offers: 6502h, or without it those whose objects it has.
fn modes(eds: &Eds) -> u32 {
    let said = said_modes(eds);
    if said != 0 {
        return said;
    }
    let has = |index: &u16| eds.objects.contains_key(index);
    let rows: [(i8, &[u16]); 9] = [
        (1, &[0x607A, 0x6081]),
        (2, &[0x6042]),
        (3, &[0x60FF, 0x6083]),
        (4, &[0x6071]),
        (6, &[0x6098]),
        (7, &[0x60C1]),
        (8, &[0x607A, 0x60C2]),
        (9, &[0x60FF, 0x60C2]),
        (10, &[0x6071, 0x60C2]),
    ];
    let offered = rows.iter().filter(|(_, objects)| objects.iter().all(has));
    offered.fold(0, |modes, (code, _)| modes | 1 << (code - 1))
}

/// The drive with what the bus adds to it.
#[derive(Clone, Debug)]
pub(super) struct Driven {
    pub(super) drive: Drive,
    /// `None`: it is switched off.
    pub(super) nmt: Option<NmtState>,
    /// The mode of a file without 6060h.
    only_mode: Option<i64>,
    /// A controlword from a PDO acts when the whole PDO is taken.
    word: Option<i64>,
    requests: VecDeque<Request>,
}

impl Driven {
    /// That of a file; `None`: it is no drive.
    pub(super) fn of(dictionary: &Dictionary) -> Option<Self> {
        let eds = dictionary.eds;
        let modes = modes(eds);
        let only = (!eds.objects.contains_key(&0x6060) && modes != 0).then(|| modes.trailing_zeros() + 1);
        is_driven(eds).then(|| Self {
            drive: Drive::new(modes, eds.objects.contains_key(&0x60B8)),
            nmt: None,
            only_mode: only.map(i64::from),
            word: None,
            requests: VecDeque::new(),
        })
    }

    pub(super) fn advance(&mut self, now: Instant) {
        self.take_word();
        self.drive.advance(now);
    }

    fn take_word(&mut self) {
        if let Some(word) = self.word.take() {
            self.drive.set(Setting::Controlword, word);
        }
    }

    pub(super) fn power_off(&mut self) {
        self.nmt = None;
        self.word = None;
        self.requests.clear();
        self.drive.power_off();
    }

    /// Tells the node what happened in the drive.
    pub(super) fn poll_request(&mut self) -> Option<Request> {
        while let Some(event) = self.drive.poll_event() {
            self.requests.push_back(match event {
                // The node has told it.
                Event::Raised(fault @ Fault::CONNECTION) => Request::ErrorRegister(fault.register()),
                Event::Raised(fault) => Request::Emergency(Emergency::new(fault.0, fault.register())),
                Event::Cleared => Request::Emergency(Emergency::gone(0)),
            });
        }
        self.requests.pop_front()
    }
}

impl FromEds {
    /// What the drive tells in this entry.
    pub(super) fn driven(&self, row: &Row) -> Option<Value<'static>> {
        let Role::Actual(actual) = row.role else { return None };
        let number = self.drive.as_ref()?.drive.actual(actual);
        let data = row.table.data;
        // Counters of 32 bits run round; smaller numbers end at their limit.
        let number = match (data.range(), data.octets()) {
            (Some((low, high)), Some(..=3)) => number.clamp(low, high),
            (_, _) => number,
        };
        Value::whole(data, number)
    }

    /// Whether the drive takes that value.
    pub(super) fn judge_driven(&self, row: &Row, value: Value<'_>) -> Result<(), Abort> {
        let (Role::Setting(setting), Some(driven)) = (row.role, &self.drive) else { return Ok(()) };
        let number = value.number().unwrap_or(i64::MAX);
        if driven.drive.accepts(setting, number) { Ok(()) } else { Err(Abort::RANGE) }
    }

    /// A master has set a value.
    pub(super) fn drive_written(&mut self, now: Instant, row: &Row, value: Value<'_>, source: Source) {
        let (Role::Setting(setting), Some(driven)) = (row.role, &mut self.drive) else { return };
        let number = value.number().unwrap_or(i64::MAX);
        match (source, setting) {
            (Source::Image, _) => {}
            (Source::Rpdo(_), Setting::Controlword) => driven.word = Some(number),
            (Source::Sdo | Source::Rpdo(_), _) => {
                driven.drive.advance(now);
                driven.drive.set(setting, number);
            }
        }
    }

    pub(super) fn notice_driven(&mut self, now: Instant, notice: Notice) {
        let Some(driven) = &mut self.drive else { return };
        match notice {
            Notice::Reset(Reset::PowerOn | Reset::Node) => self.restart_drive(now),
            Notice::Reset(Reset::Communication)
            | Notice::LifeGuardingExpired(_)
            | Notice::HeartbeatLost(_)
            | Notice::Nmt { to: NmtState::Stopped, cause: NmtCause::Master, .. } => {
                driven.advance(now);
                driven.drive.connection_aborted();
            }
            Notice::Sync => {
                driven.advance(now);
                driven.drive.sync(now);
            }
            Notice::RpdoTaken(_) => driven.take_word(),
            Notice::Nmt { .. }
            | Notice::RpdoRefused { .. }
            | Notice::RpdoLength { .. }
            | Notice::LifeGuardingBack
            | Notice::HeartbeatBack(_)
            | Notice::HistoryCleared
            | Notice::NotStored => {}
        }
        if let (Notice::Nmt { to, .. }, Some(driven)) = (notice, &mut self.drive) {
            driven.nmt = Some(to);
        }
    }

    /// The drive begins with the values of the memory.
    fn restart_drive(&mut self, now: Instant) {
        let Some(driven) = &mut self.drive else { return };
        driven.advance(now);
        driven.word = None;
        driven.requests = [Request::ErrorRegister(0)].into();
        driven.drive.restart();
        if let Some(mode) = driven.only_mode {
            driven.drive.set(Setting::Mode, mode);
        }
        for (place, row) in self.dictionary.rows.iter().enumerate() {
            let Role::Setting(setting) = row.role else { continue };
            let number = self.memory.read(place, row).and_then(Value::number).unwrap_or_default();
            if setting != Setting::Controlword {
                driven.drive.set(setting, number);
            }
        }
    }
}
