//! Every named alternative of `canopen-ag03.md` 16 that can be chosen, as one table.

use super::Config;
use crate::can_bus::canopen::Abort;
use crate::can_bus::canopen::policy::{TypeZero, WrongLength};
use crate::devices::ag03::unit::dip::ResetPatterns;
use crate::face::{Quirk, QuirkError};

/// Alternatives of the device; each is off by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks {
    /// 607Dh takes the limits in any order, as on PROFIBUS (CN-04, CN-37).
    pub limits_in_any_order: bool,
    /// Without supply of the output stage the drive goes to SWITCH ON DISABLED (CN-43).
    pub supply_loss_disables: bool,
    /// Inching 1 runs to its end when CW.13 goes to 0 (CN-50).
    pub inching_1_runs_to_its_end: bool,
}

impl Config {
    /// Sets a quirk by its name, as [`QUIRKS`] lists them.
    ///
    /// # Errors
    /// [`QuirkError`] if there is no such quirk or value.
    pub fn set_quirk(&mut self, name: &str, value: &str) -> Result<(), QuirkError> {
        Quirk::set(QUIRKS, self, name, value)
    }
}

/// Every quirk, in the order of the register.
pub const QUIRKS: &[Quirk<Config>] = &[
    Quirk {
        name: "reset-patterns",
        register: "CN-01",
        about: "which of SW1 to SW7 ask for a factory reset with SW8: a number, or one switch each",
        values: &["number", "one-switch"],
        choose: |config, value| {
            config.reset_patterns =
                if value == 1 { ResetPatterns::ONE_SWITCH } else { ResetPatterns::ASSUMED };
        },
    },
    Quirk {
        name: "sdo-size",
        register: "CN-03",
        about: "the command of an answer of four octets: 43h, or 42h as one example prints it",
        values: &["43", "42"],
        choose: |config, value| config.policy.four_octets_say_size = value == 0,
    },
    Quirk {
        name: "emcy-order",
        register: "CN-10",
        about: "which octet of the code comes first in EMCY frames",
        values: &["low", "high"],
        choose: |config, value| config.policy.emcy_high_octet_first = value == 1,
    },
    Quirk {
        name: "limit-order",
        register: "CN-37",
        about: "607Dh:1 above 607Dh:2: refused with 06090036h, or accepted",
        values: &["refused", "any"],
        choose: |config, value| config.quirks.limits_in_any_order = value == 1,
    },
    Quirk {
        name: "sdo-unknown",
        register: "CN-05",
        about: "the answer to an unknown command and to a wrong length: 06010000h, or the codes of CiA 301",
        values: &["06010000", "cia-301"],
        choose: |config, value| {
            let cia_301 = value == 1;
            config.policy.unknown_command = if cia_301 { Abort::COMMAND } else { Abort::UNSUPPORTED_ACCESS };
            config.policy.wrong_length = if cia_301 {
                WrongLength::One(Abort::LENGTH)
            } else {
                WrongLength::One(Abort::UNSUPPORTED_ACCESS)
            };
        },
    },
    Quirk {
        name: "tpdo-type-0",
        register: "CN-06",
        about: "a TPDO of type 0: after every SYNC, or after a SYNC if its data changed",
        values: &["every-sync", "on-change"],
        choose: |config, value| {
            config.policy.type_0 = if value == 1 { TypeZero::OnChange } else { TypeZero::EverySync };
        },
    },
    Quirk {
        name: "guarding-off",
        register: "CN-08",
        about: "a guarding request while 100Ch or 100Dh is 0: answered, or not",
        values: &["answered", "silent"],
        choose: |config, value| config.policy.guarding_without_times = value == 0,
    },
    Quirk {
        name: "guarding-and-heartbeat",
        register: "CN-09",
        about: "a guarding request while heartbeats are sent: not answered, or answered",
        values: &["silent", "answered"],
        choose: |config, value| config.policy.guarding_beside_heartbeat = value == 1,
    },
    Quirk {
        name: "calibration-value",
        register: "CN-15",
        about: "what writing 607Ch does: store and calibrate, or store",
        values: &["calibrate", "store"],
        choose: |config, value| config.param.calibrate_by_value = value == 0,
    },
    Quirk {
        name: "load-signature",
        register: "CN-33",
        about: "the answer to a wrong signature in 1011h",
        values: &["06090030", "08000020"],
        choose: |config, value| {
            config.policy.wrong_signature = if value == 1 { Abort::TRANSFER } else { Abort::RANGE };
        },
    },
    Quirk {
        name: "rpdo-short",
        register: "CN-36",
        about: "an RPDO that is too short: ignored, or ignored with EMCY 8210h",
        values: &["ignored", "emcy"],
        choose: |config, value| config.policy.rpdo_short_emcy = value == 1,
    },
    Quirk {
        name: "supply-loss",
        register: "CN-43",
        about: "the drive state when the supply of the output stage is lost: kept, or SWITCH ON DISABLED",
        values: &["kept", "disabled"],
        choose: |config, value| config.quirks.supply_loss_disables = value == 1,
    },
    Quirk {
        name: "inching-1",
        register: "CN-50",
        about: "inching 1 when CW.13 goes to 0: it ends, or it runs to its end",
        values: &["ends", "runs"],
        choose: |config, value| config.quirks.inching_1_runs_to_its_end = value == 1,
    },
    Quirk {
        name: "cob-id-change",
        register: "CN-62",
        about: "another identifier for a PDO that is on: accepted, or refused with 08000022h",
        values: &["accepted", "refused"],
        choose: |config, value| {
            config.policy.change_while_valid = (value == 1).then_some(Abort::DEVICE_STATE);
        },
    },
    Quirk {
        name: "tpdo-rtr",
        register: "CN-07",
        about: "remote requests of TPDOs of any type: answered, or not",
        values: &["answered", "silent"],
        choose: |config, value| config.policy.tpdo_rtr = value == 0,
    },
    Quirk {
        name: "inching-rounding",
        register: "C-12",
        about: "the speed of inching 2: nearest whole rpm, or rounded up; the same as on PROFIBUS",
        values: &["nearest", "up"],
        choose: |config, value| config.drive.quirks.inching_rounds_up = value == 1,
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can_bus::canopen::NodeId;

    #[test]
    fn every_value_of_every_quirk_makes_another_configuration_and_the_first_is_the_default() {
        crate::face::check(QUIRKS, Config::new(NodeId::MIN));
    }
}
