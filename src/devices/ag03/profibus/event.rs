//! News for the host.

use core::fmt;

use super::bits::StwBit;
use super::job::Job;
use super::refusal::Bit;
use super::words::Words;
use super::{Hint, Refusal};
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::{DisableCause, Fault, Operation};
use crate::devices::ag03::param::{DefaultSet, Parameter};
use crate::devices::ag03::unit;
use crate::devices::ag03::unit::DipSwitches;
use crate::devices::ag03::unit::dip::Terminator;
use crate::profibus::dp;
use crate::profibus::fdl::FrameError;
use crate::profibus::fdl::station::TooLate;
use crate::profibus::pkw;
use crate::profibus::ppo::Stw;

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
    /// The drive went to fault, or another fault came while one was latched.
    Fault(Fault),
    /// What the drive did.
    Drive {
        /// What.
        event: drive::Event,
        /// The control word under which it did; `None`: outside Data_Exchange.
        stw: Option<Stw>,
    },
    /// What else has happened in the unit: parameters, EEPROM, DIP switches, the world around the drive.
    Unit(unit::Event),
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
    /// A drive of the profile.
    #[cfg(feature = "std")]
    PpoDrive(crate::devices::ppo_drive::profibus::Event),
    /// Something is odd.
    Hint(Hint),
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
            Self::JobRefused(refusal) => Job(refusal).fmt(f),
            Self::CommandRefused(refusal) => refusal.fmt(f),
            Self::Fault(fault) => write!(
                f,
                "fault {fault}: {}; next: acknowledge it ({} from 0 to 1), then give OFF1 once ({} = 0)",
                fault.cure(),
                Bit(StwBit::Acknowledge),
                Bit(StwBit::On)
            ),
            Self::Drive { event, stw } => fmt_drive(f, event, *stw),
            Self::Unit(unit::Event::FaultCauseGone(fault)) => {
                write!(
                    f,
                    "the cause of fault {fault} is gone: acknowledge it ({} from 0 to 1)",
                    Bit(StwBit::Acknowledge)
                )
            }
            Self::Unit(event) => event.fmt(f),
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
                    write!(f, "switched on at address {}", switches.address())?;
                    // The highest number is no address.
                    if switches.number() != switches.address().number() {
                        write!(
                            f,
                            " (SW1 to SW7 are set to {}, which is no address of a station)",
                            switches.number()
                        )?;
                    }
                    write!(f, ", bus terminator {terminator}")
                }
            }
            Self::FactoryReset(set) => unit::Event::FactoryReset(*set).fmt(f),
            Self::TelegramRefused(error) => write!(f, "ignored octets: {error}"),
            Self::ReplyTooLate(TooLate { after, limit }) => {
                write!(f, "dropped a reply {after:?} after its request, expected at most {limit:?}")
            }
            #[cfg(feature = "std")]
            Self::PpoDrive(event) => event.fmt(f),
            Self::Hint(hint) => hint.fmt(f),
            Self::Lost { events } => write!(f, "{events} more events were lost"),
        }
    }
}

impl Event {
    /// What happened in the unit under these words; `exchanging`: in Data_Exchange.
    pub(super) fn of_unit(event: unit::Event, words: &Words, exchanging: bool) -> Self {
        match event {
            unit::Event::CommandRefused(refusal) => Self::CommandRefused(Refusal::new(refusal, words)),
            unit::Event::Fault(fault) => Self::Fault(fault),
            unit::Event::Drive(event) => Self::Drive { event, stw: exchanging.then_some(words.stw()) },
            unit::Event::SwitchedOff => Self::SwitchedOff,
            unit::Event::SwitchedOn(switches) => Self::SwitchedOn(switches),
            unit::Event::FactoryReset(set) => Self::FactoryReset(set),
            unit::Event::Lost { events } => Self::Lost { events },
            unit::Event::FaultCauseGone(_)
            | unit::Event::Written { .. }
            | unit::Event::Stored
            | unit::Event::NotStored { .. }
            | unit::Event::Input(_)
            | unit::Event::SwitchesSet(_) => Self::Unit(event),
        }
    }

    /// Whether it is cyclic detail: a log leaves it out unless asked for more.
    pub const fn is_detail(&self) -> bool {
        match self {
            Self::Dp(event) => event.is_detail(),
            Self::Unit(event) => event.is_detail(),
            #[cfg(feature = "std")]
            Self::PpoDrive(_) => false,
            Self::JobRefused(_)
            | Self::CommandRefused(_)
            | Self::Fault(_)
            | Self::Drive { .. }
            | Self::SwitchedOff
            | Self::SwitchedOn(_)
            | Self::FactoryReset(_)
            | Self::TelegramRefused(_)
            | Self::ReplyTooLate(_)
            | Self::Hint(_)
            | Self::Lost { .. } => false,
        }
    }
}

/// What the drive did, with the bits and parameters that PROFIBUS has for it.
fn fmt_drive(f: &mut fmt::Formatter<'_>, event: &drive::Event, stw: Option<Stw>) -> fmt::Result {
    match (event, stw) {
        (drive::Event::Disabled { cause: DisableCause::Command(operation), motor }, Some(stw)) => {
            write!(f, "operation disabled, {motor}: {}", Asked { operation: *operation, stw })
        }
        (drive::Event::Disabled { cause: DisableCause::Command(_), motor }, None) => {
            write!(f, "operation disabled, {motor}: no Data_Exchange")
        }
        (drive::Event::TravelStarted(travel), _) => write!(f, "{travel} ({})", Limits),
        (drive::Event::Paused { torque: false }, _) => {
            write!(
                f,
                "{event} ({} = 0), {} = 1 continues it",
                Bit(StwBit::NoIntermediateStop),
                Bit(StwBit::NoIntermediateStop)
            )
        }
        (drive::Event::Paused { torque: true }, _) => {
            write!(f, "{event} (PNU {})", Parameter::TorqueDeactivation.entry().pnu)
        }
        (drive::Event::VelocityEnded, Some(stw)) if !StwBit::Start.is_set(stw) => {
            write!(f, "{event} ({} = 0)", Bit(StwBit::Start))
        }
        (drive::Event::Acknowledged, Some(stw)) if StwBit::On.is_set(stw) => {
            write!(f, "{event}; next: give OFF1 once ({on} = 0), then {on} = 1", on = Bit(StwBit::On))
        }
        (
            drive::Event::Disabled { cause: DisableCause::Fault | DisableCause::Supply, .. }
            | drive::Event::Enabled(_)
            | drive::Event::Mode(_)
            | drive::Event::Resumed { .. }
            | drive::Event::TargetReached { .. }
            | drive::Event::Discarded { .. }
            | drive::Event::Stands { .. }
            | drive::Event::InchingStarted(_)
            | drive::Event::InchingEnded { .. }
            | drive::Event::VelocityStarted(_)
            | drive::Event::VelocityChanged(_)
            | drive::Event::VelocityEnded
            | drive::Event::Acknowledged
            | drive::Event::Rearmed
            | drive::Event::NotReady
            | drive::Event::Ready
            | drive::Event::Warning { .. },
            _,
        ) => write!(f, "{event}"),
    }
}

/// The parameters that hold the limits: `PNU 1016, 1017`.
pub(super) struct Limits;

impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PNU {}, {}", Parameter::Limit1.entry().pnu, Parameter::Limit2.entry().pnu)
    }
}

/// Which bits of a control word take operation away.
struct Asked {
    operation: Operation,
    stw: Stw,
}

impl fmt::Display for Asked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bits =
            [(StwBit::NoOff2, "OFF2"), (StwBit::On, "OFF1"), (StwBit::EnableOperation, "disable operation")];
        let mut given = bits.into_iter().filter(|(bit, _)| !bit.is_set(self.stw));
        let Some((bit, name)) = given.next() else {
            return DisableCause::Command(self.operation).fmt(f);
        };
        write!(f, "{name} ({} = 0)", Bit(bit))?;
        given.try_for_each(|(bit, name)| write!(f, ", {name} ({} = 0)", Bit(bit)))
    }
}
