//! News of a drive, with the bits and parameters of PROFIBUS.

use core::fmt;

use super::bits::StwBit;
use super::job::Job;
use super::refusal::Bit;
use super::words::Words;
use super::{Hint, Refusal};
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::{DisableCause, Operation};
use crate::devices::ag03::param::Parameter;
use crate::devices::ag03::unit;
use crate::devices::ag03::unit::DipSwitches;
use crate::devices::ag03::unit::dip::Terminator;
use crate::face::{DeviceEvent, ErrorKind, EventKind, Reason};
use crate::profibus::pkw;
use crate::profibus::ppo::Stw;

/// What has happened in a drive on PROFIBUS. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// A PKW job was answered with an error number.
    JobRefused(pkw::Refusal),
    /// The drive did not do what the control word asked for, and why.
    CommandRefused(Refusal),
    /// What else has happened in the unit.
    Unit {
        /// What.
        event: unit::Event,
        /// The control word under which it did; `None`: outside Data_Exchange.
        stw: Option<Stw>,
    },
    /// Something is odd.
    Hint(Hint),
}

impl Event {
    /// What happened in the unit under these words; `exchanging`: in Data_Exchange. `None`: nothing worth telling.
    pub(super) fn of_unit(event: unit::Event, words: &Words, exchanging: bool) -> Option<Self> {
        if let unit::Event::CommandRefused(refusal) = event {
            return Refusal::told(refusal, words).map(Self::CommandRefused);
        }
        Some(Self::Unit { event, stw: exchanging.then_some(words.stw()) })
    }
}

impl DeviceEvent for Event {
    fn kind(&self) -> EventKind {
        match self {
            Self::JobRefused(_) => EventKind::JobRefused,
            Self::CommandRefused(_) => EventKind::CommandRefused,
            Self::Unit { event, .. } => event.kind(),
            Self::Hint(_) => EventKind::Hint,
        }
    }

    fn error(&self) -> Option<ErrorKind> {
        match self {
            Self::Unit { event, .. } => event.error(),
            Self::JobRefused(_) | Self::CommandRefused(_) | Self::Hint(_) => self.kind().error(),
        }
    }

    fn is_detail(&self) -> bool {
        match self {
            Self::Unit { event, .. } => event.is_detail(),
            Self::JobRefused(_) | Self::CommandRefused(_) | Self::Hint(_) => false,
        }
    }

    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        if let Self::CommandRefused(refusal) = self {
            refusal.each_reason(tell);
        }
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::JobRefused(refusal) => Job(refusal).fmt(f),
            Self::CommandRefused(refusal) => refusal.fmt(f),
            Self::Unit { event, stw } => fmt_unit(f, event, *stw),
            Self::Hint(hint) => hint.fmt(f),
        }
    }
}

/// What happened in the unit, with the bits that PROFIBUS has for what to do next, and the station's address.
fn fmt_unit(f: &mut fmt::Formatter<'_>, event: &unit::Event, stw: Option<Stw>) -> fmt::Result {
    let (acknowledge, on) = (Bit(StwBit::Acknowledge), Bit(StwBit::On));
    if let unit::Event::Fault(fault) = event {
        return write!(
            f,
            "fault {fault}: {}; next: acknowledge it ({acknowledge} from 0 to 1), then give OFF1 once ({on} = 0)",
            fault.cure()
        );
    }
    if let unit::Event::FaultCauseGone(fault) = event {
        return write!(f, "the cause of fault {fault} is gone: acknowledge it ({acknowledge} from 0 to 1)");
    }
    if let unit::Event::SwitchedOn(switches) = event {
        return fmt_switched_on(f, switches);
    }
    if let unit::Event::Drive(event) = event { fmt_drive(f, event, stw) } else { write!(f, "{event}") }
}

fn fmt_switched_on(f: &mut fmt::Formatter<'_>, switches: &DipSwitches) -> fmt::Result {
    let terminator = match switches.terminator() {
        Terminator::Inactive => "off",
        Terminator::Active => "on",
        Terminator::Half => "half on: set SW9 and SW10 alike",
    };
    if switches.reset() {
        // They may say no address.
        return write!(f, "switched on with SW8 ON (SW1 to SW10: {switches}), bus terminator {terminator}");
    }
    write!(f, "switched on at address {}", switches.address())?;
    // The highest number is no address.
    if switches.number() != switches.address().number() {
        let number = switches.number();
        write!(f, " (SW1 to SW7 are set to {number}, which is no address of a station)")?;
    }
    write!(f, ", bus terminator {terminator}")
}

/// What the drive did, with the bits and parameters that PROFIBUS has for it.
fn fmt_drive(f: &mut fmt::Formatter<'_>, event: &drive::Event, stw: Option<Stw>) -> fmt::Result {
    if let drive::Event::Disabled { cause: DisableCause::Command(operation), motor } = event {
        return match stw {
            Some(stw) => {
                write!(f, "operation disabled, {motor}: {}", Asked { operation: *operation, stw })
            }
            None => write!(f, "operation disabled, {motor}: no Data_Exchange"),
        };
    }
    write!(f, "{event}")?;
    let has = |bit: StwBit| stw.is_some_and(|stw| bit.is_set(stw));
    let (start, resume) = (Bit(StwBit::Start), Bit(StwBit::NoIntermediateStop));
    if let drive::Event::TravelStarted(_) = event {
        write!(f, " ({Limits})")?;
    }
    if let drive::Event::Paused { torque } = event {
        match torque {
            false => write!(f, " ({resume} = 0), {resume} = 1 continues it")?,
            true => write!(f, " (PNU {})", Parameter::TorqueDeactivation.entry().pnu)?,
        }
    }
    if *event == drive::Event::VelocityEnded && stw.is_some() && !has(StwBit::Start) {
        write!(f, " ({start} = 0)")?;
    }
    if *event == drive::Event::Acknowledged && has(StwBit::On) {
        write!(f, "; next: give OFF1 once ({on} = 0), then {on} = 1", on = Bit(StwBit::On))?;
    }
    Ok(())
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
