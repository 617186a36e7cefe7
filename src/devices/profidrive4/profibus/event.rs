//! News of the drive on PROFIBUS.

use core::fmt;

use crate::devices::ppo_drive::profile::NotFollowed;
use crate::devices::profidrive4;
use crate::face::{DeviceEvent, EventKind, Reason};
use crate::profibus::dpv1::base_mode::{Head, MAX_PARAMETERS, ParameterAddress, ParameterError, Service};
use crate::profibus::pkw;

/// What happened in a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// In the drive.
    Drive(profidrive4::Event),
    /// A control word was not followed.
    NotFollowed(NotFollowed),
    /// Parameters were changed by record 47.
    Changed {
        /// Which.
        address: ParameterAddress,
    },
    /// A parameter was changed by PKW.
    Written {
        /// Which.
        pnu: u16,
        /// Which element of it, from 0.
        element: u16,
    },
    /// A job of PKW was refused.
    JobRefused(pkw::Refusal),
    /// A request of record 47 was answered with an error.
    Refused {
        /// At which slot.
        slot: u8,
        /// Of which axis (drive object).
        axis: u8,
        /// What was asked.
        service: Service,
        /// Of which parameter.
        address: ParameterAddress,
        /// Why not.
        error: ParameterError,
        /// The sub-index, if the error names one.
        info: u16,
    },
    /// A request of record 47 was answered with an error before a parameter was looked at.
    RequestRefused {
        /// At which slot.
        slot: u8,
        /// Its first octets.
        head: Head,
        /// Why not.
        error: ParameterError,
    },
    /// The parameters were stored (PNU 971).
    Stored,
    /// They could not be stored.
    NotStored,
    /// The drive starts again (PNU 972).
    Reset,
}

impl DeviceEvent for Event {
    fn kind(&self) -> EventKind {
        match self {
            Self::Drive(profidrive4::Event::Fault(_)) => EventKind::Fault,
            Self::NotFollowed(word) => word.kind(),
            Self::Drive(event) if event.is_refusal() => EventKind::CommandRefused,
            Self::Drive(_) => EventKind::Drive,
            Self::Changed { .. } | Self::Written { .. } | Self::Stored | Self::NotStored => {
                EventKind::Parameter
            }
            Self::Refused { .. } | Self::RequestRefused { .. } | Self::JobRefused(_) => EventKind::JobRefused,
            Self::Reset => EventKind::Power,
        }
    }

    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        if let Self::NotFollowed(word) = self {
            word.each_reason(tell);
        }
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drive(event) => event.fmt(f),
            Self::NotFollowed(word) => word.fmt(f),
            Self::Changed { address: ParameterAddress { pnu, elements, subindex, .. } } => {
                write!(f, "record 47 changed PNU {pnu}")?;
                match elements {
                    0 | 1 if *subindex == 0 => Ok(()),
                    0 | 1 => write!(f, ".{subindex}"),
                    more => write!(f, ", {more} elements from {subindex}"),
                }
            }
            Self::Written { pnu, element: 0 } => write!(f, "PKW changed PNU {pnu}"),
            Self::Written { pnu, element } => write!(f, "PKW changed PNU {pnu}.{element}"),
            Self::JobRefused(refusal) => refusal.fmt(f),
            Self::Refused {
                slot,
                axis,
                service,
                address: ParameterAddress { pnu, subindex, .. },
                error,
                info,
            } => {
                let verb = match service {
                    Service::Read => "read",
                    Service::Change => "change",
                    Service::Unknown(_) => "answer",
                };
                write!(f, "record 47 of slot {slot} does not {verb} PNU {pnu}.{subindex} of axis {axis}: error {:02X}h", error.0)?;
                write!(f, ", {}", error.words())?;
                if error.names_subindex() {
                    write!(f, " (sub-index {info})")?;
                }
                match error.cure() {
                    "" => Ok(()),
                    cure => write!(f, ": {cure}"),
                }
            }
            Self::RequestRefused { slot, head: Head { service, parameters, .. }, error } => {
                write!(f, "record 47 of slot {slot}: the request is refused with error {:02X}h, {}: ", error.0, error.words())?;
                match (service, parameters) {
                    (Service::Unknown(number), _) => {
                        write!(f, "request ID {number:02X}h (octet 2), expected 01h (read) or 02h (change)")
                    }
                    (Service::Read | Service::Change, 0 | 40..) => write!(
                        f,
                        "{parameters} parameters (octet 4), expected 1 to {MAX_PARAMETERS}"
                    ),
                    (Service::Read | Service::Change, 1..=MAX_PARAMETERS) => write!(
                        f,
                        "it ends before the addresses and values of its {parameters} parameters (octet 4); send 6 octets for each \
                         address, and for a change format, number and values"
                    ),
                }
            }
            Self::Stored => f.write_str("parameters stored (PNU 971)"),
            Self::NotStored => f.write_str(
                "the parameters could not be stored (PNU 971), the values of before stay; next: check the disk, write 1 to PNU \
                 971 again",
            ),
            Self::Reset => f.write_str("the drive starts again with the stored parameters (PNU 972)"),
        }
    }
}
