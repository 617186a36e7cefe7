//! The adapter's side as a machine: octets of a master in, answers and effects out.

use thiserror::Error;

use super::command::{BusTiming, Command, CommandError, MAX_COMMAND};
use super::text::{FrameLine, TimeStamp};
use super::{BEL, CR, LF};
use crate::can_bus::can::Frame;
use crate::time::Instant;

/// Hardware 1.0, software 1.0: what `V` and `v` tell.
const VERSION: [u8; 4] = *b"1010";

/// What `N` tells: four characters, and none of them belongs to a device that was sold.
const SERIAL_NUMBER: [u8; 4] = *b"PD01";

/// An adapter as one master has it: closed at first, without time stamps.
///
/// Give it every octet of the master with [`Adapter::handle_octet`], and every frame of the bus with [`Adapter::frame`].
#[derive(Clone, Debug)]
pub struct Adapter {
    line: [u8; MAX_COMMAND],
    /// Characters since the last CR, of which at most [`MAX_COMMAND`] are kept.
    length: usize,
    channel: Channel,
    stamps: bool,
    flags: Flags,
}

/// Whether the adapter takes part in the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Not at all.
    Closed,
    /// In both directions.
    Open,
    /// Frames of the bus reach the master; what it sends is refused.
    ListenOnly,
}

/// What a line of the master comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reaction {
    /// What the master reads. Send it after the effect took place.
    pub answer: Answer,
    /// What is to be done.
    pub effect: Option<Effect>,
    /// Why the answer is BEL.
    pub refusal: Option<Refusal>,
}

/// What is to be done outside of the adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Send this frame on the bus.
    Transmit(Frame),
    /// The master wants this rate.
    Rate(BusTiming),
    /// `O`, `L` or `C`: frames that the master has not read are stale, forget them.
    Channel(Channel),
}

/// Why a line is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Refusal {
    /// More characters than any command has.
    #[error("a line has at most {MAX_COMMAND} characters, not {got}")]
    TooLong {
        /// How many came before CR.
        got: usize,
    },
    /// The line is no command.
    #[error(transparent)]
    Command(#[from] CommandError),
    /// A frame while the channel is closed.
    #[error("the channel is closed: send O first")]
    Closed,
    /// A frame while the channel is open to listen only.
    #[error("the channel is open to listen only: send O first")]
    ListenOnly,
    /// A rate while the channel is open.
    #[error("the rate can be set only while the channel is closed: send C first")]
    Open,
    /// A frame for which there is no room.
    #[error("no frame can be sent now: the adapter has no room or is bus off")]
    Full,
}

/// The status flags of `F`.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub struct Flags(u8);

impl Flags {
    /// The receive queue was full: frames are lost that the master did not read.
    pub(crate) const RECEIVE_FULL: Self = Self(1 << 0);
    /// The transmit queue was full: a frame of the master was refused.
    pub(crate) const TRANSMIT_FULL: Self = Self(1 << 1);
    /// An error counter reached 96.
    pub(crate) const WARNING: Self = Self(1 << 2);
    /// Data overrun.
    pub(crate) const OVERRUN: Self = Self(1 << 3);
    /// Error passive.
    pub(crate) const PASSIVE: Self = Self(1 << 5);
    /// A frame of this adapter had to wait for one of higher priority.
    pub(crate) const ARBITRATION_LOST: Self = Self(1 << 6);
    /// An error frame.
    pub(crate) const BUS_ERROR: Self = Self(1 << 7);

    /// These and those.
    #[must_use]
    pub(crate) const fn with(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }
}

impl core::fmt::Debug for Flags {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Flags({:#010b})", self.0)
    }
}

impl Default for Adapter {
    fn default() -> Self {
        Self::new()
    }
}

impl Adapter {
    /// An adapter right after it was plugged in.
    pub const fn new() -> Self {
        Self { line: [0; MAX_COMMAND], length: 0, channel: Channel::Closed, stamps: false, flags: Flags(0) }
    }

    /// Whether it takes part in the bus.
    pub const fn channel(&self) -> Channel {
        self.channel
    }

    /// Takes one octet of the master. `room` says whether a frame could be sent now. `None`: the line goes on.
    ///
    /// Never panics; a line without end needs no memory.
    pub fn handle_octet(&mut self, octet: u8, room: bool) -> Option<Reaction> {
        match octet {
            LF => None,
            CR => {
                let (line, length) = (self.line, core::mem::take(&mut self.length));
                Some(match line.get(..length) {
                    Some(line) => match Command::parse(line) {
                        Ok(command) => self.obey(command, room),
                        Err(error) => Reaction::refused(error.into()),
                    },
                    None => Reaction::refused(Refusal::TooLong { got: length }),
                })
            }
            octet => {
                if let Some(place) = self.line.get_mut(self.length) {
                    *place = octet;
                }
                self.length = self.length.saturating_add(1);
                None
            }
        }
    }

    /// The line for a frame of the bus that ended at `now`; `None` while the channel is closed.
    #[must_use]
    pub fn frame(&self, now: Instant, frame: &Frame) -> Option<FrameLine> {
        match self.channel {
            Channel::Closed => None,
            Channel::Open | Channel::ListenOnly => {
                Some(FrameLine::new(frame, self.stamps.then(|| TimeStamp::of(now))))
            }
        }
    }

    /// Notes what the next `F` tells.
    pub(crate) const fn raise(&mut self, flags: Flags) {
        self.flags = self.flags.with(flags);
    }

    /// What was received since the last CR is forgotten: what comes next is of another master.
    pub const fn break_line(&mut self) {
        self.length = 0;
    }

    fn obey(&mut self, command: Command, room: bool) -> Reaction {
        match command {
            Command::Nothing | Command::NoEffect => Reaction::answered(Answer::DONE),
            Command::Rate(timing) => match self.channel {
                Channel::Closed => Reaction::with(Answer::DONE, Effect::Rate(timing)),
                Channel::Open | Channel::ListenOnly => Reaction::refused(Refusal::Open),
            },
            Command::Open => self.switch(Channel::Open),
            Command::ListenOnly => self.switch(Channel::ListenOnly),
            Command::Close => self.switch(Channel::Closed),
            Command::Transmit(frame) => self.transmit(frame, room),
            Command::Versions => Reaction::answered(Answer::text(b'V', &VERSION)),
            Command::SoftwareVersion => Reaction::answered(Answer::text(b'v', &VERSION)),
            Command::SerialNumber => Reaction::answered(Answer::text(b'N', &SERIAL_NUMBER)),
            Command::Status => {
                let flags = core::mem::take(&mut self.flags);
                Reaction::answered(Answer::status(flags))
            }
            Command::TimeStamps(on) => {
                self.stamps = on;
                Reaction::answered(Answer::DONE)
            }
        }
    }

    const fn switch(&mut self, channel: Channel) -> Reaction {
        self.channel = channel;
        Reaction::with(Answer::DONE, Effect::Channel(channel))
    }

    fn transmit(&mut self, frame: Frame, room: bool) -> Reaction {
        match self.channel {
            Channel::Closed => Reaction::refused(Refusal::Closed),
            Channel::ListenOnly => Reaction::refused(Refusal::ListenOnly),
            Channel::Open if !room => {
                self.raise(Flags::TRANSMIT_FULL);
                Reaction::refused(Refusal::Full)
            }
            Channel::Open => {
                let sent = if frame.id().is_extended() { b'Z' } else { b'z' };
                Reaction::with(Answer::text(sent, &[]), Effect::Transmit(frame))
            }
        }
    }
}

impl Reaction {
    const fn answered(answer: Answer) -> Self {
        Self { answer, effect: None, refusal: None }
    }

    const fn with(answer: Answer, effect: Effect) -> Self {
        Self { answer, effect: Some(effect), refusal: None }
    }

    const fn refused(refusal: Refusal) -> Self {
        Self { answer: Answer::REFUSED, effect: None, refusal: Some(refusal) }
    }
}

/// What the master reads, 1..=6 characters.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Answer {
    text: [u8; 6],
    length: usize,
}

impl Answer {
    const DONE: Self = Self { text: [CR, 0, 0, 0, 0, 0], length: 1 };
    const REFUSED: Self = Self { text: [BEL, 0, 0, 0, 0, 0], length: 1 };

    /// `letter`, at most four characters, CR.
    fn text(letter: u8, rest: &[u8]) -> Self {
        let mut text = [0; 6];
        let mut length = 0;
        for (to, character) in text.iter_mut().zip([letter].iter().chain(rest).chain(&[CR])) {
            *to = *character;
            length += 1;
        }
        Self { text, length }
    }

    fn status(flags: Flags) -> Self {
        let digit = |value: u8| if value < 10 { b'0' + value } else { b'A' + value - 10 };
        Self::text(b'F', &[digit(flags.0 >> 4), digit(flags.0 & 0xF)])
    }

    /// The characters: CR or a text that ends with CR, or BEL.
    pub fn as_octets(&self) -> &[u8] {
        self.text.get(..self.length).unwrap_or_default()
    }
}

impl core::fmt::Debug for Answer {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Answer(\"{}\")", self.as_octets().escape_ascii())
    }
}

#[cfg(test)]
mod tests;
