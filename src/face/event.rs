//! Kinds of events and of errors, for filters and counters: the same for every device on either bus.

use core::fmt;
use core::time::Duration;

use strum::{IntoStaticStr, VariantArray};

/// What an event is about, for filters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
#[cfg_attr(feature = "panel", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
pub enum EventKind {
    /// The device did not do what a control word, a PDO or process data asked for.
    CommandRefused,
    /// A PKW job was answered with an error number.
    JobRefused,
    /// The device went to fault.
    Fault,
    /// What the device did: enabled, disabled, travels, inching, states, warnings, acknowledged.
    Drive,
    /// A parameter or the memory was written.
    Parameter,
    /// Something outside the device was changed: supplies, load, keys.
    Input,
    /// Switched on or off, factory reset.
    Power,
    /// The DP slave: parameters, configuration, Data_Exchange, watchdog.
    Dp,
    /// The CANopen node: boot-up, changes of the NMT state, commands that are ignored.
    Nmt,
    /// An SDO that was refused or ended by its client, an entry that was written.
    Sdo,
    /// A PDO that was not as its mapping says.
    Pdo,
    /// An emergency message was sent.
    Emcy,
    /// Guarding and heartbeat.
    ErrorControl,
    /// Something is odd: a hint, said once.
    Hint,
    /// The line: stations, rate, octets that are no telegram, replies too late, error states, what was lost.
    Line,
    /// The device is gone: the end of its events.
    Removed,
}

impl EventKind {
    /// Every kind.
    pub const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// Its name for programs, as `command_refused`.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Which error every event of the kind tells; `None`: not every one.
    pub const fn error(self) -> Option<ErrorKind> {
        match self {
            Self::CommandRefused => Some(ErrorKind::CommandRefused),
            Self::JobRefused => Some(ErrorKind::JobRefused),
            Self::Fault => Some(ErrorKind::Fault),
            Self::Drive
            | Self::Parameter
            | Self::Input
            | Self::Power
            | Self::Dp
            | Self::Nmt
            | Self::Sdo
            | Self::Pdo
            | Self::Emcy
            | Self::ErrorControl
            | Self::Hint
            | Self::Line
            | Self::Removed => None,
        }
    }
}

/// How often an event came again since it was told, and in which time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Again {
    /// How often.
    pub times: u32,
    /// From when it was told to the last time.
    pub within: Duration,
    /// It stands for others of the same device, too: so much is wrong that not all of it is told.
    pub of_others: bool,
}

impl fmt::Display for Again {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let times = if self.times == 1 { "time" } else { "times" };
        let others = if self.of_others { ", with others like it," } else { "" };
        write!(f, "{} {times} more{others} in {:.1} s", self.times, self.within.as_secs_f64())
    }
}

/// A kind of error that an event tells, for counters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum ErrorKind {
    /// Its drive went to fault, or another fault came while one was latched.
    Fault,
    /// Set_Prm refused, also that of a master that is not the owner.
    PrmRefused,
    /// Chk_Cfg refused.
    CfgRefused,
    /// Data_Exchange with a wrong number of outputs.
    OutputLength,
    /// Set_Slave_Add refused.
    AddressRefused,
    /// The application of the slave was silent or gave up.
    Application,
    /// A job of the parameter channel answered with an error number.
    JobRefused,
    /// A control word or process data that the drive did not follow.
    CommandRefused,
    /// The image of its EEPROM could not be kept.
    NotStored,
}

impl ErrorKind {
    /// Every kind.
    pub const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// Its name for programs, as `prm_refused`.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_its_place_in_the_list() {
        for (place, kind) in ErrorKind::ALL.iter().enumerate() {
            assert_eq!(*kind as usize, place, "{}", kind.name());
        }
    }
}
