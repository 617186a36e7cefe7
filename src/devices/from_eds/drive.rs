//! The drives behind a file of CiA 402, one for each axis: which objects they have, and what the bus does to them.

use std::collections::VecDeque;

use super::dictionary::{Dictionary, Role, Row};
use super::{Behaviour, FromEds};
use crate::can_bus::canopen::dictionary::Entry;
use crate::can_bus::canopen::value::DataType;
use crate::can_bus::canopen::{
    Abort, Address, AwaitsSync, Emergency, NmtCause, NmtState, Notice, Request, Reset, Source, Value,
};
use crate::can_bus::cia402::axis::{self, MAX_AXES, index};
use crate::devices::cia402_drive::{Actual, Drive, Event, Fault, Setting};
use crate::eds::{self, Content, Eds, Number, Profile};
use crate::time::Instant;

/// Modes that a drive can have, as bits of 6502h.
const MODES: u32 = 0x3EF;

/// What an entry is to the drive.
pub(super) fn role(eds: &Eds, axes: u8, at: Address, table: &Entry) -> Role {
    let (axis, index) = axis::of_first(at.index.0);
    let sub = at.sub.0;
    if !table.data.kind().is_whole() || axis >= axes {
        return Role::Value;
    }
    match (Setting::of(index, sub), Actual::of(index, sub)) {
        (Some(setting), _) => Role::Setting(axis, setting),
        // What the file says stays.
        (None, Some(Actual::SupportedModes)) if said_modes(eds, axis) != 0 => Role::Value,
        (None, Some(actual)) => Role::Actual(axis, actual),
        (None, None) => Role::Value,
    }
}

/// Whether the file has what makes a drive of CiA 402.
pub(super) fn is_driven(eds: &Eds) -> bool {
    eds.profile() == Profile::Drive && axes(eds) > 0
}

/// How many axes the file has: each has a controlword and a statusword.
pub(super) fn axes(eds: &Eds) -> u8 {
    let is_word = |index| eds.entry(index, 0).is_some_and(|entry| entry.data == DataType::U16);
    let has_words = |axis: &u8| is_word(index(*axis, 0x6040)) && is_word(index(*axis, 0x6041));
    (0..MAX_AXES).find(|axis| !has_words(axis)).unwrap_or(MAX_AXES)
}

/// 6502h, of the modes that there are.
fn said_modes(eds: &Eds, axis: u8) -> u32 {
    let said = eds.number(index(axis, 0x6502), 0).and_then(|modes| u32::try_from(modes).ok());
    said.unwrap_or_default() & MODES
}

/// The modes that the file offers: 6502h, or without it those whose objects it has.
fn modes(eds: &Eds, axis: u8) -> u32 {
    let said = said_modes(eds, axis);
    if said != 0 {
        return said;
    }
    let has = |first: &u16| eds.objects.contains_key(&index(axis, *first));
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

/// Supported homing methods.
const METHODS: u16 = 0x60E3;

/// Entries of 60E3h without a default have the methods that the drive has, one after the other.
pub(super) fn fill(eds: &mut Eds, axes: u8) {
    for axis in 0..axes {
        let Some(object) = eds.objects.get_mut(&index(axis, METHODS)) else { continue };
        let is_blank = |entry: &eds::Entry| entry.content == Content::None && entry.data.kind().is_whole();
        let is_record = object.entries.len() > 1;
        if is_record && object.entries.iter().all(|(sub, entry)| *sub == 0 || is_blank(entry)) {
            let entries = object.entries.iter_mut().filter(|(sub, _)| **sub > 0);
            for ((_, entry), method) in entries.zip(Drive::METHODS) {
                entry.content = Content::Whole(Number { offset: method.into(), node_id: false });
            }
        }
    }
}

/// The drives of a file with what the bus adds to them.
#[derive(Clone, Debug)]
pub(super) struct Driven {
    /// The first one, and those behind it.
    pub(super) axes: Vec<Axis>,
    /// `None`: it is switched off.
    pub(super) nmt: Option<NmtState>,
    /// A PDO that waits for SYNC in vain.
    pub(super) awaits: Option<AwaitsSync>,
    /// The node itself tells of the master that is lost.
    node_tells: bool,
    requests: VecDeque<Request>,
}

/// One of them.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// 0 the first.
    number: u8,
    pub(super) drive: Drive,
    /// The mode of a file without 6060h.
    only_mode: Option<i64>,
    /// A controlword from a PDO acts when the whole PDO is taken.
    word: Option<i64>,
}

impl Axis {
    /// An axis of a file.
    pub(super) fn of(eds: &Eds, number: u8) -> Self {
        let modes = modes(eds, number);
        let has = |first| eds.objects.contains_key(&index(number, first));
        let only = (!has(0x6060) && modes != 0).then(|| modes.trailing_zeros() + 1);
        Self { number, drive: Drive::new(modes, has(0x60B8)), only_mode: only.map(i64::from), word: None }
    }

    /// 0 the first.
    pub(super) const fn number(&self) -> u8 {
        self.number
    }

    fn advance(&mut self, now: Instant) {
        self.take_word();
        self.drive.advance(now);
    }

    fn take_word(&mut self) {
        if let Some(word) = self.word.take() {
            self.drive.set(Setting::Controlword, word);
            self.drive.look_at_target(false);
        }
    }

    /// What the drive tells, in an entry of that type.
    pub(super) fn value(&self, actual: Actual, data: DataType) -> Option<Value<'static>> {
        let number = self.drive.actual(actual);
        // Counters of 32 bits run round; smaller numbers end at their limit.
        let number = match (data.range(), data.octets()) {
            (Some((low, high)), Some(..=3)) => number.clamp(low, high),
            (_, _) => number,
        };
        Value::whole(data, number)
    }
}

impl Driven {
    /// Those of a file.
    pub(super) fn of(dictionary: &Dictionary) -> Self {
        let axes = (0..MAX_AXES).zip(&dictionary.axes);
        Self {
            axes: axes.map(|(number, _)| Axis::of(dictionary.eds, number)).collect(),
            nmt: None,
            awaits: None,
            node_tells: false,
            requests: VecDeque::new(),
        }
    }

    pub(super) fn axis(&self, number: u8) -> Option<&Axis> {
        self.axes.get(usize::from(number))
    }

    pub(super) fn axis_mut(&mut self, number: u8) -> Option<&mut Axis> {
        self.axes.get_mut(usize::from(number))
    }

    pub(super) fn advance(&mut self, now: Instant) {
        self.axes.iter_mut().for_each(|axis| axis.advance(now));
    }

    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        self.axes.iter().filter_map(|axis| axis.drive.poll_timeout()).min()
    }

    pub(super) fn power_off(&mut self) {
        self.nmt = None;
        self.requests.clear();
        for axis in &mut self.axes {
            axis.word = None;
            axis.drive.power_off();
        }
    }

    /// Tells the node what happened in the drives.
    pub(super) fn poll_request(&mut self) -> Option<Request> {
        for number in 0..self.axes.len() {
            while let Some(event) = self.axes.get_mut(number).and_then(|axis| axis.drive.poll_event()) {
                let others = self.axes.iter().enumerate().filter(|(other, _)| *other != number);
                let faults = others.filter_map(|(_, axis)| axis.drive.fault());
                let others = faults.fold(0, |register, fault| register | fault.register());
                self.requests.push_back(match event {
                    Event::Raised(fault @ Fault::CONNECTION) if self.node_tells => {
                        Request::ErrorRegister(others | fault.register())
                    }
                    Event::Raised(fault) => {
                        Request::Emergency(Emergency::new(fault.0, others | fault.register()))
                    }
                    Event::Cleared if others == 0 => Request::Emergency(Emergency::gone(0)),
                    Event::Cleared => Request::ErrorRegister(others),
                });
            }
        }
        self.requests.pop_front()
    }
}

impl FromEds {
    /// Whether the drive takes that value.
    pub(super) fn judge_driven(&self, row: &Row, value: Value<'_>) -> Result<(), Abort> {
        let (Role::Setting(axis, setting), Some(driven)) = (row.role, self.driven()) else { return Ok(()) };
        let number = value.number().unwrap_or(i64::MAX);
        let is_method = setting != Setting::HomingMethod || number == 0 || self.offers_method(axis, number);
        let accepts = || driven.axis(axis).is_some_and(|axis| axis.drive.accepts(setting, number));
        if is_method && accepts() { Ok(()) } else { Err(Abort::RANGE) }
    }

    /// Whether 60E3h has that homing method; without 60E3h every one is there.
    fn offers_method(&self, axis: u8, method: i64) -> bool {
        let methods = index(axis, METHODS);
        let entries = self.dictionary.eds.objects.get(&methods).map(|object| &object.entries);
        let said = entries.into_iter().flatten().filter(|(sub, _)| **sub > 0);
        let mut said = said.filter_map(|(sub, _)| self.dictionary.eds.number(methods, *sub));
        let first = said.next();
        first.is_none() || first.into_iter().chain(said).any(|said| said == i128::from(method))
    }

    /// A master has set a value.
    pub(super) fn drive_written(&mut self, now: Instant, row: &Row, value: Value<'_>, source: Source) {
        let Role::Setting(axis, setting) = row.role else { return };
        let Some(axis) = self.driven_mut().and_then(|driven| driven.axis_mut(axis)) else { return };
        let number = value.number().unwrap_or(i64::MAX);
        match (source, setting) {
            (Source::Image, _) => {}
            (Source::Rpdo(_), Setting::Controlword) => axis.word = Some(number),
            (Source::Sdo | Source::Rpdo(_), _) => {
                axis.drive.advance(now);
                axis.drive.set(setting, number);
                if setting == Setting::Controlword {
                    axis.drive.look_at_target(true);
                }
            }
        }
    }

    pub(super) fn notice_driven(&mut self, now: Instant, notice: Notice) {
        let Some(driven) = self.driven_mut() else { return };
        match notice {
            Notice::Reset(Reset::PowerOn | Reset::Node) => self.restart_drive(now),
            Notice::Reset(Reset::Communication)
            | Notice::LifeGuardingExpired(_)
            | Notice::HeartbeatLost(_)
            | Notice::Nmt { to: NmtState::Stopped, cause: NmtCause::Master, .. } => {
                driven.advance(now);
                driven.node_tells =
                    matches!(notice, Notice::LifeGuardingExpired(_) | Notice::HeartbeatLost(_));
                driven.axes.iter_mut().for_each(|axis| axis.drive.connection_aborted());
            }
            Notice::SyncMissing(pdo) => driven.awaits = Some(pdo),
            Notice::Sync => {
                driven.awaits = None;
                driven.advance(now);
                driven.axes.iter_mut().for_each(|axis| axis.drive.sync(now));
            }
            Notice::RpdoTaken(_) => driven.axes.iter_mut().for_each(Axis::take_word),
            Notice::Nmt { .. }
            | Notice::RpdoRefused { .. }
            | Notice::RpdoLength { .. }
            | Notice::LifeGuardingBack
            | Notice::HeartbeatBack(_)
            | Notice::HistoryCleared
            | Notice::NotStored => {}
        }
        if let (Notice::Nmt { to, .. }, Some(driven)) = (notice, self.driven_mut()) {
            (driven.nmt, driven.awaits) = (Some(to), None);
        }
    }

    /// The drives begin with the values of the memory.
    fn restart_drive(&mut self, now: Instant) {
        let Behaviour::Drive(driven) = &mut self.behaviour else { return };
        driven.advance(now);
        driven.requests = [Request::ErrorRegister(0)].into();
        for axis in &mut driven.axes {
            axis.word = None;
            axis.drive.restart();
            if let Some(mode) = axis.only_mode {
                axis.drive.set(Setting::Mode, mode);
            }
        }
        for (place, row) in self.dictionary.rows.iter().enumerate() {
            let Role::Setting(axis, setting) = row.role else { continue };
            let number = self.memory.read(place, row).and_then(Value::number).unwrap_or_default();
            if let Some(axis) = driven.axis_mut(axis).filter(|_| setting != Setting::Controlword) {
                axis.drive.set(setting, number);
            }
        }
    }
}
