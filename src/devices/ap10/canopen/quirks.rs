//! Doubts about the AP10 on CANopen as data, by their number in the project's reference (`canopen-ap10.md` 17).

use crate::can_bus::canopen::pdo::PdoNumber;
use crate::can_bus::canopen::policy::{
    ErrorControlRule, EventRule, LoadRule, OutOfRange, RtrAnswer, WrongLength,
};
use crate::can_bus::canopen::{Abort, Policy};
use crate::devices::ap10;
use crate::face::Quirk;

/// How the device reads where its manual contradicts itself or is silent.
///
/// Not a choice, as only one reading can be built or one is printed twice: CN-101, 103, 104, 107, 109, 111 to 113, 115
/// to 117, 119 to 122, 124 to 129 and 131 to 138 follow the proposals of the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quirks {
    /// CN-105 and CN-108.
    pub indicator: ap10::Quirks,
    /// CN-102: what malformed SDO requests are answered with.
    pub sdo_codes: SdoCodes,
    /// CN-106: guarding is answered while 100Ch or 100Dh is 0.
    pub guarding_without_times: bool,
    /// CN-110: what `load` does to the EEPROM.
    pub load: LoadRule,
    /// CN-114: what 100Ah says.
    pub software_version: SoftwareVersion,
    /// CN-118: `save` keeps the operating mode.
    pub keeps_mode: bool,
    /// CN-130: the external heartbeat (5F09h) is supervised from its first event on. Off by default: from the entry into
    /// OPERATIONAL on, so that a master that never sends is noticed, too.
    pub heartbeat_from_first: bool,
    /// Section 5.6.1: with the rate on auto the device is silent until it hears a frame. Off by default: a bus in
    /// memory has one rate and no errors, so the search is over before a master could notice it.
    pub listens_first: bool,
}

/// The abort codes of malformed requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SdoCodes {
    /// 06010000h for all, as the manual's table has no other.
    Siko,
    /// 05040001h and 06070010h.
    Cia301,
}

/// The firmware's name of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SoftwareVersion {
    /// As 6507h.
    V301,
    /// As printed at 100Ah.
    V100,
}

impl SoftwareVersion {
    /// As it is read.
    pub(crate) const fn text(self) -> &'static str {
        match self {
            Self::V301 => "V301",
            Self::V100 => "V100",
        }
    }
}

/// Every choice by its name, in the order of the reference.
pub const QUIRKS: &[Quirk<Quirks>] = &[
    Quirk {
        name: "sdo-codes",
        register: "CN-102",
        about: "the answer to malformed SDO requests: 06010000h for all, or the codes of CiA 301",
        values: &["06010000", "cia-301"],
        choose: |quirks, value| {
            quirks.sdo_codes = if value == 1 { SdoCodes::Cia301 } else { SdoCodes::Siko };
        },
    },
    Quirk {
        name: "ascii",
        register: "CN-105",
        about: "where the first octet of six characters is shown",
        values: &["left", "right"],
        choose: |quirks, value| quirks.indicator.ascii_reversed = value == 1,
    },
    Quirk {
        name: "guarding",
        register: "CN-106",
        about: "guarding while 100Ch or 100Dh is 0: answered, or not",
        values: &["always", "with-times"],
        choose: |quirks, value| quirks.guarding_without_times = value == 0,
    },
    Quirk {
        name: "load",
        register: "CN-110",
        about: "what `load` does: the next reset takes the defaults once, or what is kept is erased",
        values: &["once", "erase"],
        choose: |quirks, value| {
            quirks.load = if value == 1 { LoadRule::Erase } else { LoadRule::OnceAfterReset };
        },
    },
    Quirk {
        name: "software-version",
        register: "CN-114",
        about: "what 100Ah says: as 6507h, or as printed",
        values: &["V301", "V100"],
        choose: |quirks, value| {
            quirks.software_version = if value == 1 { SoftwareVersion::V100 } else { SoftwareVersion::V301 };
        },
    },
    Quirk {
        name: "save-mode",
        register: "CN-118",
        about: "whether `save` keeps the operating mode",
        values: &["kept", "lost"],
        choose: |quirks, value| quirks.keeps_mode = value == 0,
    },
    Quirk {
        name: "external-heartbeat",
        register: "CN-130",
        about: "when the time of 5F09h begins: with OPERATIONAL, or with the first RPDO or SYNC",
        values: &["operational", "first"],
        choose: |quirks, value| quirks.heartbeat_from_first = value == 1,
    },
    Quirk {
        name: "auto-rate",
        register: "5.6.1",
        about: "with the rate on auto: sends at once, or only after it has heard a frame",
        values: &["sends", "listens"],
        choose: |quirks, value| quirks.listens_first = value == 1,
    },
];

impl Quirks {
    /// The proposals of the reference.
    pub const DEFAULT: Self = Self {
        indicator: ap10::Quirks::DEFAULT,
        sdo_codes: SdoCodes::Siko,
        guarding_without_times: true,
        load: LoadRule::OnceAfterReset,
        software_version: SoftwareVersion::V301,
        keeps_mode: true,
        heartbeat_from_first: false,
        listens_first: false,
    };

    /// What a node of this device does.
    pub(crate) const fn policy(&self) -> Policy {
        let (unknown_command, wrong_length) = match self.sdo_codes {
            SdoCodes::Siko => (Abort::UNSUPPORTED_ACCESS, Abort::UNSUPPORTED_ACCESS),
            SdoCodes::Cia301 => (Abort::COMMAND, Abort::LENGTH),
        };
        Policy {
            segmented: false,
            unknown_command,
            wrong_length: WrongLength::One(wrong_length),
            out_of_range: OutOfRange::One(Abort::RANGE),
            load: self.load,
            type_254: EventRule::TIMER,
            type_255: EventRule::TIMER,
            rpdo_rtr: READ_OUT,
            rpdo_short_emcy: false,
            guarding_without_times: self.guarding_without_times,
            life_guarding_error: QUIET,
            heartbeat_error: QUIET,
            error_behaviour: None,
            ..Policy::CIA_301
        }
    }
}

impl Default for Quirks {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The life time is a matter of the master (manual 5.5.2).
const QUIET: ErrorControlRule = ErrorControlRule { emcy: false, behaviour: false };

/// Set points are read by remote request, with the status word (CN-103).
const READ_OUT: &[RtrAnswer] = &[
    RtrAnswer { pdo: PdoNumber::P1, mapping: &[0x5F16_0320, 0x5F16_0410, 0x5F19_0010] },
    RtrAnswer { pdo: PdoNumber::P2, mapping: &[0x5F16_0120, 0x5F16_0210, 0x5F19_0010] },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_of_every_quirk_makes_another_choice_and_the_first_is_the_default() {
        crate::face::check(QUIRKS, Quirks::DEFAULT);
    }
}
