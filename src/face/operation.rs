//! What a master can ask of a device: the same list for whoever offers it to a person.

use super::Turning;
use crate::can_bus::canopen::Address;
use crate::can_bus::cia402::Mode;

/// By which words a master operates a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    /// Control word, set-point and parameter channel of a positioning drive in seven words.
    Positioning,
    /// Control word and speed of PROFIDRIVE, with a parameter channel where the PPO has one.
    Speed,
    /// The control word of CiA 402; NMT, objects.
    Cia402 {
        /// It can be homed.
        homes: bool,
        /// How it turns with a velocity, where it does.
        turning: Option<Turning>,
    },
    /// NMT and objects.
    Objects,
    /// Octets without a meaning that all devices share.
    Octets,
}

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verb {
    /// Operation enabled, standing.
    Enable,
    /// Operation not enabled any more.
    Disable,
    /// A fault acknowledged.
    Acknowledge,
    /// Standing.
    Stop,
    /// At this position.
    Move,
    /// Inching in positive direction until something else is asked.
    JogPositive,
    /// The same in negative direction.
    JogNegative,
    /// Turning with this velocity.
    Velocity,
    /// Turning with this part of the reference speed.
    Speed,
    /// Of a node: turning with the velocity of this entry, in this mode.
    Turn(Mode, Address),
    /// Of a node: inching by this control word until something else is asked.
    Inch(u16),
    /// Homed.
    Home,
    /// NMT: OPERATIONAL.
    NmtStart,
    /// NMT: STOPPED.
    NmtStop,
    /// NMT: PRE-OPERATIONAL.
    NmtPreOperational,
    /// NMT: as after power-on.
    NmtResetNode,
    /// NMT: communication as after power-on.
    NmtResetCommunication,
}

/// The number that is given with what is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quantity {
    /// What it is.
    pub(crate) name: &'static str,
    /// Its unit.
    pub(crate) unit: &'static str,
    /// The lowest.
    pub(crate) low: f64,
    /// The highest.
    pub(crate) high: f64,
    /// It has no fraction.
    pub(crate) whole: bool,
}

/// One thing that can be asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Act {
    /// What.
    pub(crate) verb: Verb,
    /// A name that stays, for programs.
    pub(crate) key: &'static str,
    /// What people call it.
    pub(crate) name: &'static str,
    /// With which number; `None`: with none.
    pub(crate) quantity: Option<Quantity>,
    /// What `profidrive master` is told to do the same, the number in place of `{}`; `None`: it has no such command.
    pub(crate) command: Option<&'static str>,
}

impl Act {
    const fn of(verb: Verb, key: &'static str, name: &'static str, command: &'static str) -> Self {
        Self { verb, key, name, quantity: None, command: Some(command) }
    }

    /// What has no command.
    const fn uncommanded(verb: Verb, key: &'static str, name: &'static str) -> Self {
        Self { verb, key, name, quantity: None, command: None }
    }

    const fn with(self, quantity: Quantity) -> Self {
        Self { quantity: Some(quantity), ..self }
    }
}

const POSITION: Quantity =
    Quantity { name: "Position", unit: "", low: i32::MIN as f64, high: i32::MAX as f64, whole: true };
const VELOCITY: Quantity = Quantity { name: "Velocity", unit: "rpm", low: -200.0, high: 200.0, whole: true };
const PERCENT: Quantity = Quantity { name: "Speed", unit: "%", low: -199.0, high: 199.0, whole: true };

const ENABLE: Act = Act::of(Verb::Enable, "enable", "Enable", "enable");
const DISABLE: Act = Act::uncommanded(Verb::Disable, "disable", "Disable");
const ACKNOWLEDGE: Act = Act::of(Verb::Acknowledge, "acknowledge", "Acknowledge", "ack");
const HOME: Act = Act::of(Verb::Home, "home", "Home", "home");
const STOP: Act = Act::of(Verb::Stop, "stop", "Stop", "stop");
const MOVE: Act = Act::of(Verb::Move, "move", "Move to", "move {}").with(POSITION);
const JOG_NEGATIVE: Act = Act::of(Verb::JogNegative, "jog_negative", "Jog −", "jog -");
const JOG_POSITIVE: Act = Act::of(Verb::JogPositive, "jog_positive", "Jog +", "jog +");
const TURN: Act = Act::of(Verb::Velocity, "velocity", "Turn with", "velocity {}").with(VELOCITY);
const NMT_START: Act = Act::uncommanded(Verb::NmtStart, "nmt_start", "NMT start");
const NMT_STOP: Act = Act::uncommanded(Verb::NmtStop, "nmt_stop", "NMT stop");
const NMT_PRE_OPERATIONAL: Act =
    Act::uncommanded(Verb::NmtPreOperational, "nmt_pre_operational", "NMT pre-operational");
const NMT_RESET_NODE: Act = Act::uncommanded(Verb::NmtResetNode, "nmt_reset_node", "NMT reset node");
const NMT_RESET_COMMUNICATION: Act =
    Act::uncommanded(Verb::NmtResetCommunication, "nmt_reset_communication", "NMT reset communication");

const POSITIONING: &[Act] = &[ENABLE, DISABLE, ACKNOWLEDGE, MOVE, JOG_NEGATIVE, JOG_POSITIVE, TURN, STOP];

const SPEED: &[Act] = &[
    ENABLE,
    DISABLE,
    ACKNOWLEDGE,
    // Of 100 rpm so many percent are so many rpm.
    Act::of(Verb::Speed, "speed", "Turn with", "--reference-speed 100 velocity {}").with(PERCENT),
    STOP,
];

const CIA_402: &[Act] = &[Act::uncommanded(Verb::Enable, "enable", "Enable"), DISABLE, ACKNOWLEDGE, MOVE];

/// What a drive on CANopen adds to it.
fn of_turning(turning: Turning) -> impl Iterator<Item = Act> {
    let Turning { mode, target, unit, range: (low, high), inching } = turning;
    let (low, high) = (low.into(), high.into());
    let inching = inching.into_iter().flat_map(|[positive, negative]| {
        [
            Act::uncommanded(Verb::Inch(negative), JOG_NEGATIVE.key, JOG_NEGATIVE.name),
            Act::uncommanded(Verb::Inch(positive), JOG_POSITIVE.key, JOG_POSITIVE.name),
        ]
    });
    let quantity = Quantity { unit, low, high, ..VELOCITY };
    let turn = Act::uncommanded(Verb::Turn(mode, target), TURN.key, TURN.name).with(quantity);
    inching.chain([turn])
}

const NMT: &[Act] = &[NMT_START, NMT_STOP, NMT_PRE_OPERATIONAL, NMT_RESET_NODE, NMT_RESET_COMMUNICATION];

impl Operation {
    /// Everything that can be asked beside reading and writing.
    pub(crate) fn acts(self) -> impl Iterator<Item = Act> {
        let (first, homes, turning, last): (&[Act], _, _, &[Act]) = match self {
            Self::Positioning => (POSITIONING, false, None, &[]),
            Self::Speed => (SPEED, false, None, &[]),
            Self::Cia402 { homes, turning } => (CIA_402, homes, turning, &[STOP]),
            Self::Objects | Self::Octets => (&[], false, None, &[]),
        };
        let nmt = match self {
            Self::Cia402 { .. } | Self::Objects => NMT,
            Self::Positioning | Self::Speed | Self::Octets => &[],
        };
        let turning = turning.into_iter().flat_map(of_turning);
        let home = homes.then_some(HOME);
        first.iter().copied().chain(home).chain(turning).chain(last.iter().chain(nmt).copied())
    }

    /// What can be asked, by the name for programs.
    pub(crate) fn act(self, key: &str) -> Option<Act> {
        self.acts().find(|act| act.key == key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURNING: Turning = Turning {
        mode: Mode::ProfileVelocity,
        target: Address::new(0x60FF, 0),
        unit: "rpm",
        range: (-200, 200),
        inching: Some([0x400F, 0x800F]),
    };

    #[test]
    fn each_key_is_one_act_and_a_number_has_a_place_in_its_command() {
        let all = [
            Operation::Positioning,
            Operation::Speed,
            Operation::Cia402 { homes: false, turning: None },
            Operation::Cia402 { homes: true, turning: Some(TURNING) },
            Operation::Objects,
            Operation::Octets,
        ];
        for operation in all {
            for act in operation.acts() {
                assert_eq!(operation.act(act.key), Some(act), "one act for one key");
                if let Some(command) = act.command {
                    assert_eq!(command.contains("{}"), act.quantity.is_some(), "{}", act.key);
                }
            }
        }
    }

    #[test]
    fn a_drive_on_canopen_is_asked_by_the_same_keys_as_one_on_profibus() {
        let keys = |operation: Operation| operation.acts().map(|act| act.key).collect::<std::vec::Vec<_>>();
        let on_canopen = keys(Operation::Cia402 { homes: true, turning: Some(TURNING) });
        for key in keys(Operation::Positioning) {
            assert!(on_canopen.contains(&key), "{key}");
        }
        assert!(!keys(Operation::Cia402 { homes: false, turning: None }).contains(&"velocity"));
    }
}
