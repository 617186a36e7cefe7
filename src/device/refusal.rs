//! Why the drive does not do what the control word asks for: what the drive has against it, with the bits of PROFIBUS.

use core::fmt;

use super::bits::StwBit;
use super::words::Words;
use crate::drive;
use crate::ppo::Stw;

/// A request of the control word that was refused, and the conditions it does not meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// What the drive says.
    pub drive: drive::Refusal,
    /// The control word that asked.
    pub stw: Stw,
    /// STW.0 = 0 was not seen since Data_Exchange began (C-36).
    pub off1_not_seen: bool,
}

/// What stands against a request, in words of PROFIBUS.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reason {
    /// OFF2 is given.
    Off2,
    /// OFF1 is given.
    Off1,
    /// STW.0 = 0 was not seen since Data_Exchange began (C-36).
    Off1NotSeen,
    /// What has no bit of its own.
    Drive(drive::Reason),
}

impl fmt::Debug for Reason {
    /// The name of the reason, without the layer it belongs to.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off2 => f.write_str("Off2"),
            Self::Off1 => f.write_str("Off1"),
            Self::Off1NotSeen => f.write_str("Off1NotSeen"),
            Self::Drive(reason) => reason.fmt(f),
        }
    }
}

impl Refusal {
    pub(super) const fn new(drive: drive::Refusal, words: &Words) -> Self {
        Self { drive, stw: words.stw(), off1_not_seen: words.awaits_off1() }
    }

    /// Every reason, in the order in which they are printed.
    pub fn reasons(&self) -> impl Iterator<Item = Reason> {
        let Self { drive, stw, off1_not_seen } = *self;
        let enabled = !drive.contains(drive::Reason::NotEnabled);
        drive::Reason::ALL.into_iter().filter(move |&reason| drive.contains(reason)).flat_map(move |reason| {
            let not_asked = reason == drive::Reason::NotAsked;
            // Asked to enable by STW.3, it is not told that STW.3 is missing.
            let not_enabled = enabled && !StwBit::EnableOperation.is_set(stw);
            let bits = [
                (!StwBit::NoOff2.is_set(stw), Reason::Off2),
                (!StwBit::On.is_set(stw), Reason::Off1),
                (off1_not_seen && StwBit::On.is_set(stw), Reason::Off1NotSeen),
                (not_enabled, Reason::Drive(drive::Reason::NotEnabled)),
            ];
            let of_bits =
                bits.into_iter().filter(move |(applies, _)| not_asked && *applies).map(|(_, reason)| reason);
            of_bits.chain((!not_asked).then_some(Reason::Drive(reason)))
        })
    }

    /// One of the reasons in words, with its numbers.
    pub const fn text(&self, reason: Reason) -> impl fmt::Display + use<> {
        ReasonText { refusal: self.drive, reason }
    }
}

/// A reason with the numbers of its refusal.
struct ReasonText {
    refusal: drive::Refusal,
    reason: Reason,
}

impl fmt::Display for ReasonText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.reason {
            Reason::Off2 => f.write_str("OFF2 is given"),
            Reason::Off1 => f.write_str("OFF1 is given"),
            Reason::Off1NotSeen => f.write_str("OFF1 must be given once in Data_Exchange first"),
            Reason::Drive(reason @ drive::Reason::TurnOnDisabled) => {
                write!(f, "{}: give OFF1 once", self.refusal.text(reason))
            }
            Reason::Drive(reason) => self.refusal.text(reason).fmt(f),
        }
    }
}

impl fmt::Display for Refusal {
    /// One line: the request, then every unmet condition.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} refused", self.drive.request)?;
        for (index, reason) in self.reasons().enumerate() {
            write!(f, "{}{}", if index == 0 { ": " } else { "; " }, self.text(reason))?;
        }
        Ok(())
    }
}
