//! What a master can ask of a device: the same list for whoever offers it to a person.

/// By which words a master operates a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    /// Control word, set-point and parameter channel of a positioning drive in seven words.
    Positioning,
    /// Control word and speed of PROFIDRIVE, with a parameter channel where the PPO has one.
    Speed,
    /// The control word of CiA 402, NMT, objects.
    Cia402,
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
const STOP: Act = Act::of(Verb::Stop, "stop", "Stop", "stop");
const MOVE: Act = Act::of(Verb::Move, "move", "Move to", "move {}").with(POSITION);
const NMT_START: Act = Act::uncommanded(Verb::NmtStart, "nmt_start", "NMT start");
const NMT_STOP: Act = Act::uncommanded(Verb::NmtStop, "nmt_stop", "NMT stop");
const NMT_PRE_OPERATIONAL: Act =
    Act::uncommanded(Verb::NmtPreOperational, "nmt_pre_operational", "NMT pre-operational");
const NMT_RESET_NODE: Act = Act::uncommanded(Verb::NmtResetNode, "nmt_reset_node", "NMT reset node");
const NMT_RESET_COMMUNICATION: Act =
    Act::uncommanded(Verb::NmtResetCommunication, "nmt_reset_communication", "NMT reset communication");

const POSITIONING: &[Act] = &[
    ENABLE,
    DISABLE,
    ACKNOWLEDGE,
    MOVE,
    Act::of(Verb::JogNegative, "jog_negative", "Jog −", "jog -"),
    Act::of(Verb::JogPositive, "jog_positive", "Jog +", "jog +"),
    Act::of(Verb::Velocity, "velocity", "Turn with", "velocity {}").with(VELOCITY),
    STOP,
];

const SPEED: &[Act] = &[
    ENABLE,
    DISABLE,
    ACKNOWLEDGE,
    // Of 100 rpm so many percent are so many rpm.
    Act::of(Verb::Speed, "speed", "Turn with", "--reference-speed 100 velocity {}").with(PERCENT),
    STOP,
];

const CIA_402: &[Act] = &[
    Act::uncommanded(Verb::Enable, "enable", "Enable"),
    DISABLE,
    ACKNOWLEDGE,
    MOVE,
    Act::of(Verb::Home, "home", "Home", "home"),
    STOP,
    NMT_START,
    NMT_STOP,
    NMT_PRE_OPERATIONAL,
    NMT_RESET_NODE,
    NMT_RESET_COMMUNICATION,
];

const OBJECTS: &[Act] = &[NMT_START, NMT_STOP, NMT_PRE_OPERATIONAL, NMT_RESET_NODE, NMT_RESET_COMMUNICATION];

impl Operation {
    /// Everything that can be asked beside reading and writing.
    pub(crate) const fn acts(self) -> &'static [Act] {
        match self {
            Self::Positioning => POSITIONING,
            Self::Speed => SPEED,
            Self::Cia402 => CIA_402,
            Self::Objects => OBJECTS,
            Self::Octets => &[],
        }
    }

    /// What can be asked, by the name for programs.
    pub(crate) fn act(self, key: &str) -> Option<&'static Act> {
        self.acts().iter().find(|act| act.key == key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_key_is_one_act_and_a_number_has_a_place_in_its_command() {
        let all = [
            Operation::Positioning,
            Operation::Speed,
            Operation::Cia402,
            Operation::Objects,
            Operation::Octets,
        ];
        for operation in all {
            for act in operation.acts() {
                assert_eq!(operation.act(act.key), Some(act));
                if let Some(command) = act.command {
                    assert_eq!(command.contains("{}"), act.quantity.is_some(), "{}", act.key);
                }
            }
        }
    }
}
