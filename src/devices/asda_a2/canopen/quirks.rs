//! Where the guide leaves a doubt (CN-201 to CN-238 of the project's reference), and what this device does.
//!
//! | doubt | this device | choice |
//! | --- | --- | --- |
//! | CN-201 | of P3-01 a client changes digit Z only | fixed |
//! | CN-202 | 6083h, 6084h, 6087h are P1-34, P1-35, P1-36 | fixed: the names of the parameters say so |
//! | CN-203 | transmission types 241 to 253 are out of range, remote requests are ignored | [`Quirks::answers_rtr`] |
//! | CN-204, CN-234 | one AL132, one AL201 | fixed: texts only |
//! | CN-205 | AL185 while the controller is error passive, AL186 once it was bus off | fixed |
//! | CN-206 | bit 2 = 0 is the quick stop | fixed: CiA 402 |
//! | CN-207, CN-215 to CN-217, CN-220, CN-226, CN-236 | misprints | fixed |
//! | CN-208 to CN-213, CN-219 | as the overview says | fixed |
//! | CN-214 | the error register | fixed: `Alarm::register` |
//! | CN-218 | 6093h and P1-44, P1-45 are one value, reloaded with 1:1 | fixed: P3-12.Z |
//! | CN-221 | device type and product of the A2 | fixed: the other models are other devices |
//! | CN-222 | AL111 and AL112 | [`Quirks::overrun_alarms`] |
//! | CN-223 | P1-01 decides, P3-10.X is stored only | fixed |
//! | CN-224 | P3-10.Y = 0: the motor keeps running | [`Quirks::bus_error_coasts`] |
//! | CN-225 | units and ranges of 6099h by level | fixed |
//! | CN-227 | 1014h is read-only, EMCY always on | fixed |
//! | CN-228 | the difference is 60C1h:2 in full CANopen | fixed |
//! | CN-229 | quick stop, halt, disable | fixed: `asda_a2::machine` |
//! | CN-230 | bit 4 main circuit, bit 9 OPERATIONAL | fixed |
//! | CN-231 | 6040h is taken in PRE-OPERATIONAL | fixed: nothing restricts it |
//! | CN-232, CN-233 | 1010h, 1011h read 1; defaults act with the next reset | fixed |
//! | CN-235 | 1006h counts in half CANopen only, 1000 to 20000 us | fixed |
//! | CN-237 | parameters that the guide does not name: stored, without effect | [`Quirks::other_parameters_absent`] |
//! | CN-238 | types: I32 as their object, and in P5, P6, P7; else I16 | fixed |

use crate::can_bus::canopen::Abort;
use crate::can_bus::canopen::Policy;
use crate::can_bus::canopen::policy::{ErrorControlRule, OutOfRange, WrongLength};
use crate::face::Quirk;

/// The choices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks {
    /// CN-222: two SDO requests, or two PDOs with one COB-ID, within 1 ms cause AL111 and AL112. Off by default: the
    /// frames of a master on a PC come in bursts.
    pub overrun_alarms: bool,
    /// CN-203: remote requests of TPDOs are answered. Off by default: the guide does not mention them.
    pub answers_rtr: bool,
    /// CN-224: P3-10.Y = 0 and an error of the bus: the servo goes off and the motor coasts. Off by default: the motor keeps
    /// running under the last command.
    pub bus_error_coasts: bool,
    /// CN-237: parameters without a function in this device do not exist. Off by default: they are kept and have no effect,
    /// so that a start-up list goes on.
    pub other_parameters_absent: bool,
}

/// Every choice by its name, in the order of the reference.
pub const QUIRKS: &[Quirk<Quirks>] = &[
    Quirk {
        name: "rtr",
        register: "CN-203",
        about: "remote requests of TPDOs: ignored, or answered",
        values: &["ignored", "answered"],
        choose: |quirks, value| quirks.answers_rtr = value == 1,
    },
    Quirk {
        name: "overrun-alarms",
        register: "CN-222",
        about: "two SDO requests, or two PDOs with one COB-ID, within 1 ms: accepted, or AL111 and AL112",
        values: &["off", "on"],
        choose: |quirks, value| quirks.overrun_alarms = value == 1,
    },
    Quirk {
        name: "bus-error",
        register: "CN-224",
        about: "the motor after an error of the bus while P3-10.Y is 0: runs under the last command, or coasts with the servo off",
        values: &["runs", "coasts"],
        choose: |quirks, value| quirks.bus_error_coasts = value == 1,
    },
    Quirk {
        name: "other-parameters",
        register: "CN-237",
        about: "P-parameters without a function in this device: stored without effect, or absent (06020000h)",
        values: &["stored", "absent"],
        choose: |quirks, value| quirks.other_parameters_absent = value == 1,
    },
];

impl Quirks {
    /// How the node behaves.
    pub(crate) const fn policy(&self) -> Policy {
        /// The drive itself sends EMCY with its alarm, and follows 1029h after it.
        const BY_DEVICE: ErrorControlRule = ErrorControlRule { emcy: false, behaviour: false };
        Policy {
            segmented: false,
            unknown_command: Abort::COMMAND,
            wrong_length: WrongLength::One(Abort::LENGTH),
            out_of_range: OutOfRange::One(Abort::RANGE),
            empty_history: None,
            communication_groups: &[1],
            extended_ids: false,
            tpdo_rtr: self.answers_rtr,
            rpdo_short_emcy: false,
            life_guarding_error: BY_DEVICE,
            heartbeat_error: BY_DEVICE,
            ..Policy::CIA_301
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_of_every_quirk_makes_another_choice_and_the_first_is_the_default() {
        crate::face::check(QUIRKS, Quirks::default());
    }
}
