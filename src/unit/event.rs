//! What has happened in a unit, and the queue it waits in.

use core::fmt;

use super::DipSwitches;
use crate::drive::{Fault, Refusal};
use crate::param::DefaultSet;

/// Something a user may want to read. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The drive did not do what the command asked for, and why.
    CommandRefused(Refusal),
    /// The drive went to fault.
    Fault(Fault),
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

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CommandRefused(refusal) => refusal.fmt(f),
            Self::Fault(fault) => write!(f, "fault {fault}"),
            Self::SwitchedOff => f.write_str("switched off"),
            Self::SwitchedOn(switches) => write!(f, "switched on (SW1 to SW10: {switches})"),
            Self::FactoryReset(set) => {
                let which = match set {
                    DefaultSet::All => "all",
                    DefaultSet::Standard => "the standard",
                    DefaultSet::Controller => "the controller",
                };
                write!(
                    f,
                    "{which} parameters are back at their factory settings; switch off, set the address, put SW8 to \
                     OFF and switch on"
                )
            }
            Self::Lost { events } => write!(f, "{events} more events were lost"),
        }
    }
}

/// Events in the order they came. When it is full, newer ones are counted and dropped.
#[derive(Clone, Debug)]
pub struct Queue<E, const CAPACITY: usize> {
    events: [Option<E>; CAPACITY],
    first: usize,
    len: usize,
    lost: u32,
}

impl<E, const CAPACITY: usize> Default for Queue<E, CAPACITY> {
    fn default() -> Self {
        Self { events: [const { None }; CAPACITY], first: 0, len: 0, lost: 0 }
    }
}

impl<E, const CAPACITY: usize> Queue<E, CAPACITY> {
    /// Lets an event wait.
    pub fn push(&mut self, event: E) {
        let place = (self.first + self.len) % CAPACITY;
        match self.events.get_mut(place) {
            Some(place) if self.len < CAPACITY => {
                *place = Some(event);
                self.len += 1;
            }
            Some(_) | None => self.lost = self.lost.saturating_add(1),
        }
    }

    /// The oldest event; behind the last one how many were lost, if any were.
    pub fn pop(&mut self) -> Option<Result<E, u32>> {
        if self.len == 0 {
            let lost = core::mem::take(&mut self.lost);
            return (lost > 0).then_some(Err(lost));
        }
        let event = self.events.get_mut(self.first).and_then(Option::take);
        self.first = (self.first + 1) % CAPACITY;
        self.len -= 1;
        event.map(Ok)
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
