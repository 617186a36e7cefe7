//! News for the host.

use core::fmt;

use super::Refusal;
use super::words::Words;
use crate::dp;
use crate::drive::Fault;
use crate::fdl::FrameError;
use crate::fdl::station::TooLate;
use crate::param::DefaultSet;
use crate::pkw;
use crate::unit::dip::Terminator;
use crate::unit::{self, DipSwitches};

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
            Self::FactoryReset(set) => unit::Event::FactoryReset(*set).fmt(f),
            Self::TelegramRefused(error) => write!(f, "ignored octets: {error}"),
            Self::ReplyTooLate(TooLate { after, limit }) => {
                write!(f, "dropped a reply {after:?} after its request, expected at most {limit:?}")
            }
            Self::Lost { events } => write!(f, "{events} more events were lost"),
        }
    }
}

impl Event {
    /// What happened in the unit under these words.
    pub(super) const fn of_unit(event: unit::Event, words: &Words) -> Self {
        match event {
            unit::Event::CommandRefused(refusal) => Self::CommandRefused(Refusal::new(refusal, words)),
            unit::Event::Fault(fault) => Self::Fault(fault),
            unit::Event::SwitchedOff => Self::SwitchedOff,
            unit::Event::SwitchedOn(switches) => Self::SwitchedOn(switches),
            unit::Event::FactoryReset(set) => Self::FactoryReset(set),
            unit::Event::Lost { events } => Self::Lost { events },
        }
    }
}
