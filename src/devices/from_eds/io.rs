//! CiA 401: inputs and outputs behind a file, from the objects that it has.
//!
//! | module | holds |
//! | --- | --- |
//! | `lines` | digital inputs and outputs |
//! | `analogue` | what makes an analogue value an event |

mod analogue;
mod lines;

use std::collections::{BTreeMap, VecDeque};

use super::dictionary::{Role, Row};
use super::{Behaviour, FromEds};
use crate::can_bus::canopen::dictionary::Entry;
use crate::can_bus::canopen::value::ValueKind;
use crate::can_bus::canopen::{Address, NmtCause, NmtState, Notice, Request, Reset, Value};
use crate::time::Instant;
use analogue::Trigger;
use lines::{Bank, Lines};

pub(super) use lines::{Block, What};

/// 6422h has 32 channels in each entry, and 8 entries.
const CHANNELS_OF_ENTRY: u8 = 32;
const SOURCES: usize = 8;

/// What an entry is to the inputs and outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Point {
    /// Digital lines.
    Lines(Block),
    /// 6005h: events of digital inputs are on.
    DigitalEvents,
    /// 6400h to 6404h: the input of a channel.
    AnalogueInput(u8),
    /// 6410h to 6414h: the output of a channel.
    AnalogueOutput(u8),
    /// 6422h: channels that had an event.
    Sources(usize),
}

impl Point {
    pub(super) fn of(at: Address, table: &Entry) -> Option<Self> {
        let is_number = table.data.kind().is_whole() || table.data.kind() == ValueKind::Real;
        match at.pair() {
            (0x6005, 0) => Some(Self::DigitalEvents),
            (0x6400..=0x6404, channel @ 1..) if is_number => Some(Self::AnalogueInput(channel)),
            (0x6410..=0x6414, channel @ 1..) if is_number => Some(Self::AnalogueOutput(channel)),
            (0x6422, entry @ 1..=8) => Some(Self::Sources(usize::from(entry - 1))),
            (_, _) => Block::of(at, table.data).map(Self::Lines),
        }
    }

    /// Whether its value comes from outside.
    pub(super) fn is_input(self) -> bool {
        match self {
            Self::Lines(block) => block.what == What::Input,
            Self::AnalogueInput(_) => true,
            Self::DigitalEvents | Self::AnalogueOutput(_) | Self::Sources(_) => false,
        }
    }
}

/// The state of the inputs and outputs.
#[derive(Clone, Debug)]
pub(super) struct Io {
    lines: Lines,
    /// The value of each analogue input at its last event, by its place.
    told: BTreeMap<usize, f64>,
    sources: [u32; SOURCES],
    pub(super) requests: VecDeque<Request>,
}

impl Io {
    pub(super) const fn new() -> Self {
        Self { lines: Lines::new(), told: BTreeMap::new(), sources: [0; SOURCES], requests: VecDeque::new() }
    }

    pub(super) const fn due(&self) -> Option<Instant> {
        self.lines.due()
    }

    /// What the device tells in this entry, if it does not come from the memory.
    pub(super) fn read(&self, point: Point, row: &Row) -> Option<Value<'static>> {
        let number = match point {
            Point::Lines(block) => self.lines.read(block),
            Point::Sources(entry) => self.sources.get(entry).copied().unwrap_or_default().into(),
            Point::DigitalEvents | Point::AnalogueInput(_) | Point::AnalogueOutput(_) => return None,
        };
        i64::try_from(number).ok().and_then(|number| Value::whole(row.table.data, number))
    }

    /// The level at the terminals, of digital lines.
    pub(super) fn at_terminal(&self, point: Point) -> Option<u64> {
        match point {
            Point::Lines(block) if block.what == What::Input => Some(self.lines.levels(block)),
            Point::Lines(block) if block.what == What::Output => Some(self.lines.terminals(block)),
            Point::Lines(_)
            | Point::DigitalEvents
            | Point::AnalogueInput(_)
            | Point::AnalogueOutput(_)
            | Point::Sources(_) => None,
        }
    }
}

impl FromEds {
    /// Power-on and reset of the node: what the memory has holds.
    pub(super) fn restart_io(&mut self) {
        let Behaviour::Io(io) = &mut self.behaviour else { return };
        let blocks = || {
            let rows = self.dictionary.rows.iter().enumerate();
            rows.filter_map(|(place, row)| match row.role {
                Role::Io(Point::Lines(block)) => Some((place, row, block)),
                Role::Io(_) | Role::Value | Role::Setting(..) | Role::Actual(..) | Role::Encoder(_) => None,
            })
        };
        io.lines.restart(|what| blocks().any(|(_, _, block)| block.what == what));
        io.sources = [0; SOURCES];
        for (place, row, block) in blocks().filter(|(_, _, block)| block.what != What::Input) {
            io.lines.load(block, lines_of(self.memory.read(place, row)));
        }
        let events_on = self.dictionary.place(Address::new(0x6005, 0));
        let events_on = events_on.and_then(|place| self.memory.read(place, self.dictionary.rows.get(place)?));
        io.lines.events_on = events_on.and_then(Value::number).is_none_or(|on| on != 0);
        self.tell_all_analogue();
    }

    /// The master knows every analogue value.
    fn tell_all_analogue(&mut self) {
        let Behaviour::Io(io) = &mut self.behaviour else { return };
        for (place, row) in self.dictionary.rows.iter().enumerate() {
            if let Role::Io(Point::AnalogueInput(_)) = row.role
                && let Some(value) = self.memory.read(place, row).and_then(super::description::as_f64)
            {
                io.told.insert(place, value);
            }
        }
    }

    /// A master has written an object.
    pub(super) fn io_written(&mut self, point: Point, value: Value<'_>) {
        let Behaviour::Io(io) = &mut self.behaviour else { return };
        let events = match point {
            Point::Lines(block) => io.lines.write(block, lines_of(Some(value))),
            Point::DigitalEvents => {
                io.lines.events_on = value.number() != Some(0);
                return;
            }
            Point::AnalogueInput(_) | Point::AnalogueOutput(_) | Point::Sources(_) => return,
        };
        self.tell_lines(&events);
    }

    /// Something from outside: a level at the terminals, or an analogue value that the memory has taken.
    pub(super) fn io_input(&mut self, now: Instant, place: usize, point: Point, number: f64) {
        match (point, &mut self.behaviour) {
            (Point::Lines(block), Behaviour::Io(io)) => {
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "casts saturate")]
                let events = io.lines.set_levels(now, block, number.round() as u64);
                self.tell_lines(&events);
            }
            (Point::AnalogueInput(channel), Behaviour::Io(_)) => self.judge_analogue(place, channel),
            (Point::Lines(_) | Point::AnalogueInput(_), _)
            | (Point::DigitalEvents | Point::AnalogueOutput(_) | Point::Sources(_), _) => {}
        }
    }

    pub(super) fn advance_io(&mut self, now: Instant) {
        let Behaviour::Io(io) = &mut self.behaviour else { return };
        let events = io.lines.advance(now);
        self.tell_lines(&events);
    }

    fn tell_lines(&mut self, events: &Bank) {
        let Behaviour::Io(io) = &mut self.behaviour else { return };
        if *events == Bank::LOW {
            return;
        }
        for row in &self.dictionary.rows {
            if let Role::Io(Point::Lines(block)) = row.role
                && block.what == What::Input
                && events.of(block) != 0
            {
                ask(&mut io.requests, row.at);
            }
        }
    }

    /// Whether the new value of an analogue input is an event.
    fn judge_analogue(&mut self, place: usize, channel: u8) {
        let (global, chosen) = (self.float(0x6423, 0), self.float(0x6421, channel));
        if global == Some(0.0) {
            return;
        }
        let Some(row) = self.dictionary.rows.get(place) else { return };
        let Some(value) = self.memory.read(place, row).and_then(super::description::as_f64) else { return };
        let first = if row.table.data.kind() == ValueKind::Real { 0x6429 } else { 0x6424 };
        let [upper, lower, delta, less, more] = [0, 1, 2, 3, 4].map(|at| self.float(first + at, channel));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "casts saturate")]
        let chosen = chosen.map_or(7, |chosen| chosen as u8);
        let trigger = Trigger { chosen, upper, lower, delta, less, more };
        let Behaviour::Io(io) = &mut self.behaviour else { return };
        if !trigger.is_event(value, io.told.get(&place).copied().unwrap_or_default()) {
            return;
        }
        io.told.insert(place, value);
        let bit = (channel - 1) % CHANNELS_OF_ENTRY;
        if let Some(source) = io.sources.get_mut(usize::from((channel - 1) / CHANNELS_OF_ENTRY)) {
            *source |= 1 << bit;
        }
        ask(&mut io.requests, row.at);
    }

    /// The value of an entry that the memory has.
    fn float(&self, index: u16, sub: u8) -> Option<f64> {
        let place = self.dictionary.place(Address::new(index, sub))?;
        let row = self.dictionary.rows.get(place)?;
        self.memory.read(place, row).and_then(super::description::as_f64)
    }

    pub(super) fn notice_io(&mut self, notice: Notice) {
        match notice {
            Notice::Reset(Reset::PowerOn | Reset::Node) => self.restart_io(),
            Notice::Nmt { to: NmtState::Operational, .. } => self.tell_all_analogue(),
            Notice::LifeGuardingExpired(_)
            | Notice::HeartbeatLost(_)
            | Notice::Nmt { to: NmtState::Stopped, .. }
            | Notice::Nmt { cause: NmtCause::ErrorBehaviour, .. } => self.fail_outputs(),
            Notice::Reset(Reset::Communication)
            | Notice::Nmt { .. }
            | Notice::Sync
            | Notice::RpdoTaken(_)
            | Notice::RpdoRefused { .. }
            | Notice::RpdoLength { .. }
            | Notice::LifeGuardingBack
            | Notice::HeartbeatBack(_)
            | Notice::SyncMissing(_)
            | Notice::HistoryCleared
            | Notice::NotStored => {}
        }
    }

    /// Outputs go to their error values where 6206h and 6443h say so.
    fn fail_outputs(&mut self) {
        let Behaviour::Io(io) = &mut self.behaviour else { return };
        io.lines.fail();
        for (place, row) in self.dictionary.rows.iter().enumerate() {
            let Role::Io(Point::AnalogueOutput(channel)) = row.role else { continue };
            let value = if row.table.data.kind() == ValueKind::Real { 0x6445 } else { 0x6444 };
            if self.float(0x6443, channel) == Some(1.0)
                && let Some(value) = self.float(value, channel)
                && let Some(value) = super::description::of_f64(row.table.data, value)
            {
                // A number is never too long.
                let _ = value.with_octets(|octets| self.memory.set(place, row, octets));
            }
        }
    }

    /// 6422h says what had an event since it was read.
    pub(super) fn io_read(&mut self, point: Point) {
        if let (Point::Sources(entry), Behaviour::Io(io)) = (point, &mut self.behaviour)
            && let Some(sources) = io.sources.get_mut(entry)
        {
            *sources = 0;
        }
    }
}

/// Once for each entry until the node has heard it.
fn ask(requests: &mut VecDeque<Request>, at: Address) {
    let request = Request::Changed(at);
    if !requests.contains(&request) {
        requests.push_back(request);
    }
}

fn lines_of(value: Option<Value<'_>>) -> u64 {
    value.and_then(Value::number).and_then(|number| u64::try_from(number).ok()).unwrap_or_default()
}
