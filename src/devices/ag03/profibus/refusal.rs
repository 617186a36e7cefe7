//! Why the drive does not do what the control word asks for: what the drive has against it, with the bits of PROFIBUS.

use core::fmt;

use super::bits::{StwBit, Word};
use super::event::Limits;
use super::words::Words;
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::Request;
use crate::devices::ag03::param::Parameter;
use crate::face;
use crate::profibus::ppo::Stw;

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
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Reason {
    /// OFF2 is given.
    Off2,
    /// OFF1 is given.
    Off1,
    /// STW.0 = 0 was not seen since Data_Exchange began (C-36).
    Off1NotSeen,
    /// What has no bit of its own.
    Drive(drive::Reason),
}

impl Reason {
    /// Its name for programs.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Off2 => "Off2",
            Self::Off1 => "Off1",
            Self::Off1NotSeen => "Off1NotSeen",
            Self::Drive(reason) => reason.name(),
        }
    }
}

impl Refusal {
    /// A refusal worth telling; `None`: the master asked for nothing yet.
    pub(super) fn told(drive: drive::Refusal, words: &Words) -> Option<Self> {
        let rests = drive.request == Request::Enable && words.rests();
        (!rests).then(|| Self::new(drive, words))
    }

    pub(super) const fn new(drive: drive::Refusal, words: &Words) -> Self {
        Self { drive, stw: words.stw(), off1_not_seen: words.awaits_off1() }
    }

    /// Tells every unmet condition, in the order in which they are printed.
    pub(crate) fn each_reason(&self, tell: &mut dyn FnMut(face::Reason<'_>)) {
        self.reasons().for_each(|reason| tell(face::Reason::new(reason.name(), &self.text(reason))));
    }

    pub(super) fn reasons(&self) -> impl Iterator<Item = Reason> + use<> {
        let Self { drive, stw, off1_not_seen } = *self;
        let enabled = !drive.contains(drive::Reason::NotEnabled);
        drive.reasons().flat_map(move |reason| {
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

    /// One of the reasons in words: the cause, its bit or parameter, and what to do where no control word helps.
    pub(super) const fn text(&self, reason: Reason) -> impl fmt::Display + use<> {
        ReasonText { refusal: *self, reason }
    }

    /// The control words to send one after the other to get what was asked, where they are all that is missing.
    pub fn next(&self) -> Option<impl fmt::Display + use<>> {
        self.next_with(false)
    }

    /// As [`Refusal::next`]; where the cause of a latched fault is gone, with those that acknowledge it.
    pub(super) fn next_with(&self, cause_gone: bool) -> Option<Next> {
        let mut lacks = 0;
        let mut off1_once = false;
        let mut acknowledge = false;
        // The end of the intermediate stop is all that a paused job waits for.
        let mut resumes = false;
        for reason in self.reasons() {
            match reason {
                Reason::Off2 => lacks |= StwBit::NoOff2.mask(),
                Reason::Off1 => lacks |= StwBit::On.mask(),
                Reason::Off1NotSeen | Reason::Drive(drive::Reason::TurnOnDisabled) => off1_once = true,
                Reason::Drive(drive::Reason::NotEnabled) => lacks |= StwBit::EnableOperation.mask(),
                Reason::Drive(drive::Reason::Stop) => lacks |= StwBit::NoStop.mask(),
                Reason::Drive(drive::Reason::IntermediateStop) => lacks |= StwBit::NoIntermediateStop.mask(),
                Reason::Drive(drive::Reason::JobPaused) => resumes = true,
                Reason::Drive(drive::Reason::FaultLatched) if cause_gone => {
                    (acknowledge, off1_once) = (true, true)
                }
                Reason::Drive(
                    drive::Reason::SwitchedOff
                    | drive::Reason::FaultLatched
                    | drive::Reason::FaultCause
                    | drive::Reason::NoSupply
                    | drive::Reason::NoOutputStage
                    | drive::Reason::NotAsked
                    | drive::Reason::StartHeld
                    | drive::Reason::JobActive
                    | drive::Reason::InchingActive
                    | drive::Reason::ShaftTurns
                    | drive::Reason::BothInching
                    | drive::Reason::VelocityMode
                    | drive::Reason::AboveUpperLimit
                    | drive::Reason::BelowLowerLimit
                    | drive::Reason::SetpointAboveUpperLimit
                    | drive::Reason::SetpointBelowLowerLimit
                    | drive::Reason::LoopPointAboveUpperLimit
                    | drive::Reason::LoopPointBelowLowerLimit
                    | drive::Reason::BeyondEncoder,
                ) => return None,
            }
        }
        let stw = self.stw.raw() & if acknowledge { !StwBit::Acknowledge.mask() } else { u16::MAX };
        // A bit that is 1 already has no edge.
        let acknowledge = acknowledge.then_some([
            Some(stw).filter(|_| StwBit::Acknowledge.is_set(self.stw)),
            Some(stw | StwBit::Acknowledge.mask()),
        ]);
        let off1 = Some(stw & !StwBit::On.mask()).filter(|_| off1_once);
        let ready = stw | lacks | if off1_once { StwBit::On.mask() } else { 0 };
        let waits = self.drive.contains(drive::Reason::NotEnabled) || off1_once;
        Some(match self.drive.request {
            Request::Travel { .. } if resumes => Next { acknowledge, off1, ready, waits, start: None },
            // Each change of the bit starts a job.
            Request::Travel { .. } => {
                Next { acknowledge, off1, ready, waits, start: Some(ready ^ StwBit::Start.mask()) }
            }
            Request::Inching1(_) => {
                Next { acknowledge, off1, ready: ready & !StwBit::Inching1.mask(), waits, start: Some(ready) }
            }
            Request::Inching2(_) => {
                Next { acknowledge, off1, ready: ready & !StwBit::Inching2.mask(), waits, start: Some(ready) }
            }
            Request::Enable | Request::Acknowledge | Request::Velocity { .. } => {
                Next { acknowledge, off1, ready, waits, start: None }
            }
        })
    }
}

/// A reason with the numbers of its refusal.
struct ReasonText {
    refusal: Refusal,
    reason: Reason,
}

impl fmt::Display for ReasonText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Refusal { drive, stw, .. } = self.refusal;
        match self.reason {
            Reason::Off2 => write!(f, "OFF2 is given ({} = 0)", Bit(StwBit::NoOff2)),
            Reason::Off1 => write!(f, "OFF1 is given ({} = 0)", Bit(StwBit::On)),
            Reason::Off1NotSeen => {
                write!(f, "OFF1 must be given once in Data_Exchange first ({} = 0)", Bit(StwBit::On))
            }
            Reason::Drive(reason) => {
                let text = drive.text(reason);
                match reason {
                    drive::Reason::TurnOnDisabled => {
                        write!(f, "{text}: give OFF1 once ({} = 0)", Bit(StwBit::On))
                    }
                    drive::Reason::FaultLatched => {
                        write!(f, "{text}: remove its cause, then {} from 0 to 1", Bit(StwBit::Acknowledge))
                    }
                    drive::Reason::FaultCause => write!(f, "{text}: remove it, then acknowledge again"),
                    drive::Reason::NotEnabled if StwBit::EnableOperation.is_set(stw) => {
                        write!(f, "{text} yet: wait for ZSW.2 = 1")
                    }
                    drive::Reason::NotEnabled => write!(f, "{text} ({} = 0)", Bit(StwBit::EnableOperation)),
                    drive::Reason::Stop => write!(f, "{text} ({} = 0)", Bit(StwBit::NoStop)),
                    drive::Reason::IntermediateStop => {
                        write!(f, "{text} ({} = 0)", Bit(StwBit::NoIntermediateStop))
                    }
                    drive::Reason::StartHeld => write!(f, "{text} ({} = 0)", Bit(StwBit::Start)),
                    drive::Reason::JobActive => {
                        write!(f, "{text}: wait for its end, or discard it ({} = 0)", Bit(StwBit::NoStop))
                    }
                    drive::Reason::JobPaused => write!(
                        f,
                        "{text} ({} = 1 continues, {} = 0 stops)",
                        Bit(StwBit::NoIntermediateStop),
                        Bit(StwBit::NoStop)
                    ),
                    drive::Reason::SetpointAboveUpperLimit | drive::Reason::SetpointBelowLowerLimit => {
                        write!(
                            f,
                            "{text}: give a setpoint from {} to {}, or change the limits ({Limits})",
                            drive.lengths.position(drive.lower_limit.into()),
                            drive.lengths.position(drive.upper_limit.into())
                        )
                    }
                    drive::Reason::LoopPointAboveUpperLimit | drive::Reason::LoopPointBelowLowerLimit => {
                        write!(
                            f,
                            "{text}: give a setpoint farther from the limit, or change loop length (PNU {}) or limits \
                         ({Limits})",
                            Parameter::LoopLength.entry().pnu
                        )
                    }
                    drive::Reason::AboveUpperLimit | drive::Reason::BelowLowerLimit => {
                        write!(f, "{text}, or change the limits ({Limits})")
                    }
                    drive::Reason::VelocityMode => {
                        write!(f, "{text} (PNU {} = 2)", Parameter::OperatingMode.entry().pnu)
                    }
                    drive::Reason::ShaftTurns => write!(f, "{text}: wait until it stands"),
                    drive::Reason::InchingActive => write!(
                        f,
                        "{text}: end it first ({} = 0, {} = 0)",
                        Bit(StwBit::Inching1),
                        Bit(StwBit::Inching2)
                    ),
                    drive::Reason::BothInching => write!(
                        f,
                        "{text}: set only one of {} and {}",
                        Bit(StwBit::Inching1),
                        Bit(StwBit::Inching2)
                    ),
                    drive::Reason::NoSupply => {
                        write!(f, "{text}: switch it on (PNU 1040, 1041 show the voltages)")
                    }
                    drive::Reason::NoOutputStage => write!(f, "{text}: switch it on"),
                    drive::Reason::BeyondEncoder => {
                        write!(f, "{text}: give a setpoint nearer to the position 0 of the encoder")
                    }
                    drive::Reason::SwitchedOff | drive::Reason::NotAsked => text.fmt(f),
                }
            }
        }
    }
}

/// Control words to send one after the other.
pub(super) struct Next {
    /// What acknowledges a fault.
    acknowledge: Option<[Option<u16>; 2]>,
    off1: Option<u16>,
    ready: u16,
    /// Operation is enabled by `ready`.
    waits: bool,
    /// What asks again.
    start: Option<u16>,
}

impl fmt::Display for Next {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("send STW ")?;
        for word in self.acknowledge.into_iter().flatten().chain([self.off1]).flatten() {
            write!(f, "{word:04X}, then ")?;
        }
        write!(f, "{:04X}", self.ready)?;
        if let Some(start) = self.start {
            let wait = if self.waits { ", wait for ZSW.2 = 1" } else { "" };
            write!(f, "{wait}, then {start:04X}")?;
        }
        Ok(())
    }
}

/// The place of a bit: `STW.4`.
pub(super) struct Bit(pub(super) StwBit);

impl fmt::Display for Bit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", Word::Stw.name(), self.0.number())
    }
}

impl fmt::Display for Refusal {
    /// One line: the request, every unmet condition, and the control words that help.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} refused", self.drive.asked())?;
        for (index, reason) in self.reasons().enumerate() {
            write!(f, "{}{}", if index == 0 { ": " } else { "; " }, self.text(reason))?;
        }
        match self.next() {
            Some(next) => write!(f, "; next: {next}"),
            None => Ok(()),
        }
    }
}
