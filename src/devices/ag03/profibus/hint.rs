//! What is odd and not wrong: said once, as a hint. A hint hides no event and changes nothing.
//!
//! | file | holds |
//! | --- | --- |
//! | here | [`Hint`]: what is odd, in words |
//! | `watch` | what a device remembers to notice it |

use core::fmt;
use core::time::Duration;

use super::bits::StwBit;
use super::event::Limits;
use super::refusal::Bit;
use crate::devices::ag03::drive::Velocity;
use crate::devices::ag03::param::Parameter;
use crate::face::hint::is_due;
use crate::profibus::dp::StoredAddress;
use crate::profibus::fdl::Address;
use crate::profibus::ppo::{Pkw, Stw};
use crate::time::Instant;

pub(super) mod watch;

/// Something odd about a station. `Display` is one line of plain English: what, where, and what to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Hint {
    /// The drive is at the address of stations that have no address yet.
    AddressNotSet,
    /// The watchdog expires again and again while the master keeps asking.
    WatchdogShort {
        /// The owner.
        master: Address,
        /// The watchdog time.
        watchdog: Duration,
        /// From one request of the master to the next.
        gap: Duration,
    },
    /// A PKW write stood for one Data_Exchange: its words were changed one after the other.
    JobChanged {
        /// The write that was executed.
        executed: Pkw,
        /// What came with the next Data_Exchange.
        next: Pkw,
    },
    /// The velocity setpoint is more than the gear allows.
    SetpointLimited(Velocity),
    /// Both limits are equal: none is monitored.
    LimitsEqual {
        /// Both.
        limit: i32,
    },
    /// Limit 1 is below limit 2.
    LimitsInverted {
        /// PNU 1016.
        limit_1: i32,
        /// PNU 1017.
        limit_2: i32,
    },
    /// The acknowledgement is given again while turning on is disabled.
    AcknowledgedAlready {
        /// The control word.
        stw: Stw,
    },
    /// The start bit is 1 already when operation is enabled: no travel begins.
    StartAlready {
        /// The control word.
        stw: Stw,
    },
    /// The octets of the control word are exchanged.
    OctetsExchanged {
        /// The control word.
        stw: Stw,
    },
}

impl Hint {
    /// How many kinds there are.
    const KINDS: usize = 9;

    const fn kind(&self) -> usize {
        match self {
            Self::AddressNotSet => 0,
            Self::WatchdogShort { .. } => 1,
            Self::JobChanged { .. } => 2,
            Self::SetpointLimited(_) => 3,
            Self::LimitsEqual { .. } => 4,
            Self::LimitsInverted { .. } => 5,
            Self::AcknowledgedAlready { .. } => 6,
            Self::StartAlready { .. } => 7,
            Self::OctetsExchanged { .. } => 8,
        }
    }
}

/// When each kind of hint was said last.
#[derive(Clone, Debug, Default)]
pub(super) struct Pauses([Option<Instant>; Hint::KINDS]);

impl Pauses {
    /// Whether it is to be said at `now`; it counts as said then.
    pub(super) fn allow(&mut self, now: Instant, hint: &Hint) -> bool {
        self.0.get_mut(hint.kind()).is_some_and(|said| is_due(said, now))
    }
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("hint: ")?;
        match self {
            Self::AddressNotSet => write!(
                f,
                "address {} is for stations that have no address yet, there is no Data_Exchange at it; set another address \
                 with SW1 to SW7 and switch off and on",
                StoredAddress::DELIVERED.address
            ),
            Self::WatchdogShort { master, watchdog, gap } => write!(
                f,
                "the watchdog time {watchdog:?} is shorter than the cycle of master {master}: {gap:?} passed between two \
                 of its requests; raise the watchdog time in the master's project"
            ),
            Self::JobChanged { executed, next } => write!(
                f,
                "the PKW words changed in the middle of a job: {executed} was executed, then came {next} before there \
                 was a reply; write all four words in one Data_Exchange, and wait for the reply"
            ),
            Self::SetpointLimited(Velocity { setpoint, rpm }) => write!(
                f,
                "the velocity setpoint {setpoint} rpm is more than the gear allows, the shaft turns with {rpm} rpm; give \
                 at most {} rpm",
                rpm.abs()
            ),
            Self::LimitsEqual { limit } => write!(
                f,
                "both limits are {limit} ({Limits}): equal limits switch the monitoring off; set two different limits"
            ),
            Self::LimitsInverted { limit_1, limit_2 } => write!(
                f,
                "limit 1 is {limit_1} (PNU {}) and limit 2 is {limit_2} (PNU {}): the drive takes {limit_2} as the upper \
                 limit; exchange them if that is not meant",
                Parameter::Limit1.entry().pnu,
                Parameter::Limit2.entry().pnu
            ),
            Self::AcknowledgedAlready { stw } => {
                let off1 = stw.raw() & !StwBit::On.mask() & !StwBit::Acknowledge.mask();
                write!(
                    f,
                    "{} = 1 does nothing now: the fault is acknowledged and turning on is disabled until OFF1 is given \
                     once ({} = 0); next: send STW {off1:04X}, then {:04X}",
                    Bit(StwBit::Acknowledge),
                    Bit(StwBit::On),
                    off1 | StwBit::On.mask()
                )
            }
            Self::StartAlready { stw } => {
                let start = StwBit::Start.mask();
                write!(
                    f,
                    "{bit} is 1 already, so no travel begins: only a change of {bit} starts one; next: send STW {:04X}",
                    stw.raw() & !start,
                    bit = Bit(StwBit::Start),
                )
            }
            Self::OctetsExchanged { stw } => write!(
                f,
                "the octets of STW {:04X} seem to be exchanged: {:04X} was meant; send the high octet first",
                stw.raw(),
                stw.raw().swap_bytes()
            ),
        }
    }
}
