//! News for the host, and the queue they wait in.

use core::fmt;

use super::dip::{DipSwitches, Terminator};
use crate::dp;
use crate::drive::{Fault, Refusal};
use crate::fdl::FrameError;
use crate::fdl::station::TooLate;
use crate::param::DefaultSet;
use crate::pkw;

/// Something a user may want to read. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The DP slave: parameters, configuration, data exchange, watchdog.
    Dp(dp::Event),
    /// A PKW job was answered with an error number.
    JobRefused(pkw::Refusal),
    /// The drive did not do what the control word asked for, and why.
    CommandRefused(Refusal),
    /// The drive went to fault.
    Fault(Fault),
    /// The control lost its supply.
    SwitchedOff,
    /// The control is supplied again, and the DIP switches were read.
    SwitchedOn(DipSwitches),
    /// Switched on with the DIP switches of a factory reset: these parameters are back at their defaults.
    FactoryReset(DefaultSet),
    /// Octets on the line were no telegram.
    TelegramRefused(FrameError),
    /// A reply was dropped because its time was over.
    ReplyTooLate(TooLate),
    /// Events were lost because nobody took them in time.
    Lost {
        /// How many.
        events: u32,
    },
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dp(event) => event.fmt(f),
            Self::JobRefused(refusal) => refusal.fmt(f),
            Self::CommandRefused(refusal) => refusal.fmt(f),
            Self::Fault(fault) => write!(f, "fault {fault}"),
            Self::SwitchedOff => f.write_str("switched off"),
            Self::SwitchedOn(switches) => {
                let terminator = match switches.terminator() {
                    Terminator::Inactive => "off",
                    Terminator::Active => "on",
                    Terminator::Half => "half on: set SW9 and SW10 alike",
                };
                if switches.reset() {
                    // They may say no address.
                    write!(
                        f,
                        "switched on with SW8 ON (SW1 to SW10: {switches}), bus terminator {terminator}"
                    )
                } else {
                    write!(f, "switched on at address {}, bus terminator {terminator}", switches.address())
                }
            }
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
            Self::TelegramRefused(error) => write!(f, "ignored octets: {error}"),
            Self::ReplyTooLate(TooLate { after, limit }) => {
                write!(f, "dropped a reply {after:?} after its request, expected at most {limit:?}")
            }
            Self::Lost { events } => write!(f, "{events} more events were lost"),
        }
    }
}

/// How many events wait at most.
const CAPACITY: usize = 16;

/// Events in the order they came. When it is full, newer ones are counted and dropped.
#[derive(Clone, Debug, Default)]
pub(super) struct Queue {
    events: [Option<Event>; CAPACITY],
    first: usize,
    len: usize,
    lost: u32,
}

impl Queue {
    pub(super) fn push(&mut self, event: Event) {
        let place = (self.first + self.len) % CAPACITY;
        match self.events.get_mut(place) {
            Some(place) if self.len < CAPACITY => {
                *place = Some(event);
                self.len += 1;
            }
            Some(_) | None => self.lost = self.lost.saturating_add(1),
        }
    }

    pub(super) fn pop(&mut self) -> Option<Event> {
        if self.len == 0 {
            let events = core::mem::take(&mut self.lost);
            return (events > 0).then_some(Event::Lost { events });
        }
        let event = self.events.get_mut(self.first).and_then(Option::take);
        self.first = (self.first + 1) % CAPACITY;
        self.len -= 1;
        event
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_come_out_in_order_and_a_full_queue_counts_what_it_loses() {
        let mut queue = Queue::default();
        let event = |got| Event::TelegramRefused(FrameError::StartDelimiter { got });
        for number in 0..20 {
            queue.push(event(number));
        }
        for number in 0..16 {
            assert_eq!(queue.pop(), Some(event(number)));
        }
        assert_eq!(queue.pop(), Some(Event::Lost { events: 4 }));
        assert_eq!(queue.pop(), None);
        queue.push(event(99));
        assert_eq!(queue.pop(), Some(event(99)));
    }
}
