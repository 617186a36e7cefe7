//! What has happened in a unit, and the queue it waits in.

use core::fmt;

use heapless::Deque;

use super::DipSwitches;
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::{Fault, InputChange, Refusal};
use crate::devices::ag03::param::{DefaultSet, Effect, Lengths, Value, Write};
use crate::face::{ErrorKind, EventKind};

/// Something a user may want to read. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The drive did not do what the command asked for, and why.
    CommandRefused(Refusal),
    /// The drive went to fault, or another fault came while one was latched.
    Fault(Fault),
    /// The cause of the latched fault is no longer present.
    FaultCauseGone(Fault),
    /// What the drive did.
    Drive(drive::Event),
    /// A parameter was written, or a command that is written as a parameter.
    Written {
        /// What.
        write: Write,
        /// The value before, of a stored parameter.
        before: Option<i32>,
        /// What it changed.
        effect: Effect,
        /// What positions are counted in now.
        lengths: Lengths,
        /// Who wrote.
        by: Writer,
    },
    /// The EEPROM keeps everything.
    Stored,
    /// The host could not keep the EEPROM image.
    NotStored {
        /// Writes that waited for it were undone.
        undone: bool,
    },
    /// The world around the drive was changed.
    Input(InputChange),
    /// The DIP switches were set while the drive was on or off; they are read when it is switched on.
    SwitchesSet(DipSwitches),
    /// The control lost its supply.
    SwitchedOff,
    /// The control is supplied again, and the DIP switches were read.
    SwitchedOn(DipSwitches),
    /// Switched on with the DIP switches of a factory reset: these parameters are back at their defaults.
    FactoryReset(DefaultSet),
    /// Events were lost because nobody took them in time.
    Lost {
        /// How many.
        events: u32,
    },
}

/// Who wrote a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Writer {
    /// The master of the bus.
    Bus,
    /// The panel or a program, not over the bus.
    Host,
}

impl Event {
    /// What it is about, for filters.
    pub const fn kind(&self) -> EventKind {
        match self {
            Self::CommandRefused(_) => EventKind::CommandRefused,
            Self::Fault(_) => EventKind::Fault,
            Self::FaultCauseGone(_) | Self::Drive(_) => EventKind::Drive,
            Self::Written { .. } | Self::Stored | Self::NotStored { .. } => EventKind::Parameter,
            Self::Input(_) => EventKind::Input,
            Self::SwitchesSet(_) | Self::SwitchedOff | Self::SwitchedOn(_) | Self::FactoryReset(_) => {
                EventKind::Power
            }
            Self::Lost { .. } => EventKind::Line,
        }
    }

    /// Which error it tells, for counters; `None`: it tells none.
    pub const fn error(&self) -> Option<ErrorKind> {
        if let Self::NotStored { .. } = self { Some(ErrorKind::NotStored) } else { self.kind().error() }
    }

    /// Whether it is cyclic detail: a log leaves it out unless asked for more.
    pub(crate) const fn is_detail(&self) -> bool {
        matches!(self, Self::Written { effect: Effect::None, .. } | Self::Stored)
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CommandRefused(refusal) => refusal.fmt(f),
            Self::Fault(fault) => write!(f, "fault {fault}: {}", fault.cure()),
            Self::FaultCauseGone(fault) => {
                write!(f, "the cause of fault {fault} is gone: acknowledge the fault")
            }
            Self::Drive(event) => event.fmt(f),
            Self::Written { write, before, effect, lengths, by } => {
                written(f, *write, *before, *effect, *lengths, *by)
            }
            Self::Stored => f.write_str("stored in the EEPROM"),
            Self::NotStored { undone } => {
                let what = if *undone { ", what was written last is undone" } else { "" };
                write!(f, "the EEPROM could not be written{what}")
            }
            Self::Input(change) => write!(f, "set from outside: {change}"),
            Self::SwitchesSet(switches) => {
                write!(f, "DIP switches set to {switches} (SW1 to SW10), read when it is switched on next")
            }
            Self::SwitchedOff => f.write_str("switched off"),
            Self::SwitchedOn(switches) => write!(f, "switched on (SW1 to SW10: {switches})"),
            Self::FactoryReset(set) => {
                write!(
                    f,
                    "{} parameters are back at their factory settings; switch off, set the address, put SW8 to \
                     OFF and switch on",
                    which(*set)
                )
            }
            Self::Lost { events } => write!(f, "{events} more events were lost"),
        }
    }
}

fn written(
    f: &mut fmt::Formatter<'_>,
    write: Write,
    before: Option<i32>,
    effect: Effect,
    lengths: Lengths,
    by: Writer,
) -> fmt::Result {
    match write {
        Write::Set(parameter, value) => {
            let entry = parameter.entry();
            write!(f, "PNU {} ({}) ", entry.pnu, entry.name)?;
            let shown = |value: i32| entry.in_words(entry.number(Value::of(entry.width, value)), lengths);
            match before {
                Some(before) if before != value => {
                    write!(f, "changed from {} to {}", shown(before), shown(value))?;
                }
                Some(_) | None => write!(f, "written, unchanged {}", shown(value))?,
            }
            if effect == Effect::Calibrate {
                f.write_str(", the position is calibrated")?;
            }
        }
        Write::Load(set) => write!(f, "{} parameters set to their defaults", which(set))?,
        Write::ClearFaults => f.write_str("fault buffer and fault counter cleared")?,
        Write::Calibrate => f.write_str("the position is calibrated")?,
    }
    f.write_str(match by {
        Writer::Bus => ", by the master",
        Writer::Host => ", not over the bus",
    })
}

const fn which(set: DefaultSet) -> &'static str {
    match set {
        DefaultSet::All => "all",
        DefaultSet::Standard => "the standard",
        DefaultSet::Controller => "the controller",
    }
}

/// Events in the order they came. When it is full, newer ones are counted and dropped.
#[derive(Clone, Debug)]
pub(crate) struct Queue<E, const CAPACITY: usize> {
    events: Deque<E, CAPACITY>,
    lost: u32,
}

impl<E, const CAPACITY: usize> Default for Queue<E, CAPACITY> {
    fn default() -> Self {
        Self { events: Deque::new(), lost: 0 }
    }
}

impl<E, const CAPACITY: usize> Queue<E, CAPACITY> {
    /// Lets an event wait.
    pub(crate) fn push(&mut self, event: E) {
        if self.events.push_back(event).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// Whether nothing waits.
    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.events.is_empty() && self.lost == 0
    }

    /// The oldest event; behind the last one how many were lost, if any were.
    #[inline]
    pub(crate) fn pop(&mut self) -> Option<Result<E, u32>> {
        // Asked far more often than anything waits: nothing else is to be done where the caller stands.
        if self.is_empty() { None } else { self.pop_waiting() }
    }

    #[inline(never)]
    fn pop_waiting(&mut self) -> Option<Result<E, u32>> {
        Some(self.events.pop_front().ok_or_else(|| core::mem::take(&mut self.lost)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_come_out_in_order_and_a_full_queue_counts_what_it_loses() {
        let mut queue = Queue::<u8, 16>::default();
        for number in 0..20 {
            queue.push(number);
        }
        for number in 0..16 {
            assert_eq!(queue.pop(), Some(Ok(number)));
        }
        assert_eq!(queue.pop(), Some(Err(4)));
        assert_eq!(queue.pop(), None);
        queue.push(99);
        assert_eq!(queue.pop(), Some(Ok(99)));
    }
}
