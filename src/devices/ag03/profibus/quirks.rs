//! Every named alternative of `ag03.md` 15, whichever layer it belongs to, as one table.
//!
//! `docs/quirks.md` gives the reasons for the defaults.

use super::Config;
use crate::devices::ag03::drive::DirectionChange;
use crate::devices::ag03::unit::dip::ResetPatterns;
use crate::face::{Quirk, QuirkError};
use crate::profibus::pkw::SubindexOctet;

impl Config {
    /// Sets a quirk by its name, as [`QUIRKS`] lists them.
    ///
    /// ```
    /// use profidrive::devices::ag03::profibus::Config;
    /// use profidrive::profibus::fdl::Address;
    ///
    /// let mut config = Config::new(Address::station(5)?);
    /// config.set_quirk("off1", "brake")?;
    /// assert!(config.words.off1_brakes);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
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
        name: "i-gain",
        register: "C-01",
        about: "smallest I gain (PNU 1001) on an AG03/1",
        values: &["0", "1"],
        choose: |config, value| config.param.i_gain_from_1 = value == 1,
    },
    Quirk {
        name: "acceleration",
        register: "C-02",
        about: "smallest acceleration (PNU 1003, 1005, 1007) on an AG03",
        values: &["0", "1"],
        choose: |config, value| config.param.acceleration_from_1 = value == 1,
    },
    Quirk {
        name: "velocity-zsw14",
        register: "C-03",
        about: "ZSW.14 in velocity mode",
        values: &["0", "1"],
        choose: |config, value| config.words.velocity_bit_14 = value == 1,
    },
    Quirk {
        name: "paused",
        register: "C-05",
        about: "state of a paused travel job in ZSW.15 and SSW.14",
        values: &["ready", "active"],
        choose: |config, value| config.words.paused_is_active = value == 1,
    },
    Quirk {
        name: "off1-release",
        register: "C-06",
        about: "what ends turn-on disabled: STW.0 = 0, or a change of STW.0 from 1 to 0",
        values: &["level", "edge"],
        choose: |config, value| config.words.off1_needs_edge = value == 1,
    },
    Quirk {
        name: "zsw12",
        register: "C-07",
        about: "how ZSW.12 acknowledges a job: it toggles, or it follows STW.6",
        values: &["toggle", "mirror"],
        choose: |config, value| config.words.acknowledge_mirrors_start = value == 1,
    },
    Quirk {
        name: "fault-zsw0",
        register: "C-09",
        about: "ZSW.0 and ZSW.1 in fault and turn-on disabled: as the supplies, or 0",
        values: &["supply", "0"],
        choose: |config, value| config.words.not_ready_in_fault = value == 1,
    },
    Quirk {
        name: "velocity-ready",
        register: "C-11",
        about: "when ZSW.15 follows STW.6 = 0 in velocity mode",
        values: &["standstill", "at-once"],
        choose: |config, value| config.drive.quirks.ready_while_running_down = value == 1,
    },
    Quirk {
        name: "inch-rounding",
        register: "C-12",
        about: "how the speed of inching 2 is rounded to whole rpm",
        values: &["nearest", "up"],
        choose: |config, value| config.drive.quirks.inching_rounds_up = value == 1,
    },
    Quirk {
        name: "torque-job",
        register: "C-13",
        about: "what the torque deactivation does with the travel job",
        values: &["keep", "discard"],
        choose: |config, value| config.drive.quirks.torque_discards_job = value == 1,
    },
    Quirk {
        name: "subindex",
        register: "C-14",
        about: "which octet of IND carries the sub-index",
        values: &["high-else-low", "high", "low"],
        choose: |config, value| {
            config.pkw.subindex = match value {
                0 => SubindexOctet::HighElseLow,
                1 => SubindexOctet::High,
                _low => SubindexOctet::Low,
            }
        },
    },
    Quirk {
        name: "load-reply",
        register: "C-15",
        about: "how an AG03/1 confirms a write of PNU 970",
        values: &["double-word", "word"],
        choose: |config, value| config.parameters.confirm_load_as_word = value == 1,
    },
    Quirk {
        name: "plain-array-read",
        register: "C-16",
        about: "what job 1 on an array (PNU 945) does: error 5, or read the element in IND",
        values: &["refuse", "element"],
        choose: |config, value| config.pkw.read_element_by_plain_job = value == 1,
    },
    Quirk {
        name: "read-970",
        register: "C-17",
        about: "the reply to reading PNU 970: value 0, or error 18",
        values: &["0", "refuse"],
        choose: |config, value| config.parameters.refuse_command_read = value == 1,
    },
    Quirk {
        name: "fault-order",
        register: "C-18",
        about: "which fault PNU 945 lists first",
        values: &["newest", "oldest"],
        choose: |config, value| config.words.oldest_fault_first = value == 1,
    },
    Quirk {
        name: "calibration",
        register: "C-19",
        about: "what calibrates: PNU 970 = 5 only, or a write of PNU 1018 too",
        values: &["command", "value"],
        choose: |config, value| config.param.calibrate_by_value = value == 1,
    },
    Quirk {
        name: "stw2",
        register: "C-21",
        about: "STW.2 = 1: without effect, or operation is disabled",
        values: &["ignored", "must-be-0"],
        choose: |config, value| config.words.bit_2_must_be_0 = value == 1,
    },
    Quirk {
        name: "off1",
        register: "C-23",
        about: "what OFF1 does to a turning shaft: release at once, or brake and release",
        values: &["release", "brake"],
        choose: |config, value| config.words.off1_brakes = value == 1,
    },
    Quirk {
        name: "all-zero",
        register: "C-24",
        about: "what STW = 0 does to a turning shaft: release at once, or brake and release",
        values: &["release", "brake"],
        choose: |config, value| config.words.all_zero_brakes = value == 1,
    },
    Quirk {
        name: "start-edge",
        register: "C-32",
        about: "which change of STW.6 starts a travel job",
        values: &["any", "rising"],
        choose: |config, value| config.words.start_needs_rising_edge = value == 1,
    },
    Quirk {
        name: "zsw10",
        register: "C-35",
        about: "when ZSW.10 shows target reached",
        values: &["end-of-job", "live"],
        choose: |config, value| config.words.target_reached_live = value == 1,
    },
    Quirk {
        name: "first-enable",
        register: "C-36",
        about: "when operation can be enabled in Data_Exchange: from the first telegram on, or after STW.0 = 0",
        values: &["at-once", "after-off1"],
        choose: |config, value| config.words.off1_must_be_seen = value == 1,
    },
    Quirk {
        name: "d-pos",
        register: "C-38",
        about: "when d-Pos (PNU 1039) can be written: during a travel job too, or only without one",
        values: &["any-time", "no-job"],
        choose: |config, value| config.param.d_pos_without_job = value == 1,
    },
    Quirk {
        name: "calibrate-when",
        register: "C-39",
        about: "what calibration needs: no travel job and standstill, or no travel job only",
        values: &["standstill", "no-job"],
        choose: |config, value| config.param.calibrate_while_moving = value == 1,
    },
    Quirk {
        name: "inch-direction",
        register: "C-40",
        about: "what a change of STW.15 does while inching 2 goes on: reverse, end it, or nothing",
        values: &["reverse", "stop", "ignore"],
        choose: |config, value| {
            config.drive.quirks.inch_2_direction_change = match value {
                0 => DirectionChange::Reverses,
                1 => DirectionChange::Ends,
                _ignore => DirectionChange::IsIgnored,
            }
        },
    },
    Quirk {
        name: "inpos",
        register: "C-41",
        about: "when inpos modes 1 and 2 (PNU 1022) act: at the end of the travel, or on reaching the window",
        values: &["end", "window"],
        choose: |config, value| config.drive.quirks.inpos_acts_in_window = value == 1,
    },
    Quirk {
        name: "inch-limit",
        register: "C-42",
        about: "where inching ends at a limit: it brakes from there, or stands there",
        values: &["brake", "stand"],
        choose: |config, value| config.drive.quirks.inching_stops_at_limit = value == 1,
    },
    Quirk {
        name: "reset-patterns",
        register: "16.2",
        about: "SW1 to SW7 of the factory reset: the number of the PNU 970 command, or one switch each",
        values: &["command", "one-switch"],
        choose: |config, value| {
            config.reset_patterns =
                if value == 1 { ResetPatterns::ONE_SWITCH } else { ResetPatterns::ASSUMED };
        },
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profibus::fdl::Address;

    #[test]
    fn every_value_of_every_quirk_makes_another_configuration_and_the_first_is_the_default() {
        crate::face::check(QUIRKS, Config::new(Address::station(5).unwrap()));
    }
}
