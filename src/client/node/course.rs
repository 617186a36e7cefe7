//! The steps to each goal of a drive of CiA 402, as words and bits.

use super::super::course::{Bits, Course, Step};
use super::NodeGoal;
use crate::can_bus::canopen::Address;
use crate::can_bus::cia402::{Controlword, Mode, State, Statusword};

pub(super) const CONTROLWORD: Address = Address::new(0x6040, 0);
pub(super) const STATUSWORD: Address = Address::new(0x6041, 0);
pub(super) const MODE: Address = Address::new(0x6060, 0);
pub(super) const TARGET: Address = Address::new(0x607A, 0);

/// An entry that is changed to guard the node, and put back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kept {
    Heartbeat,
    GuardTime,
    LifeFactor,
}

impl Kept {
    pub(super) const fn at(self) -> Address {
        match self {
            Self::Heartbeat => Address::new(0x1017, 0),
            Self::GuardTime => Address::new(0x100C, 0),
            Self::LifeFactor => Address::new(0x100D, 0),
        }
    }
}

/// Control words of the flow charts.
pub(super) const SHUTDOWN: u16 = 0x0006;
pub(super) const SWITCH_ON: u16 = 0x0007;
pub(super) const ENABLE: u16 = 0x000F;
const QUICK_STOP: u16 = 0x0002;
const START: u16 = ENABLE | Controlword::NEW_SET_POINT.0;
pub(super) const HALT: u16 = ENABLE | Controlword::HALT.0;

/// What a step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Act {
    /// NMT to OPERATIONAL; the state tells whether the node has followed.
    Start,
    /// Reads a [`Kept`] entry, which is put back later.
    Keep(Kept),
    /// Writes a [`Kept`] entry.
    Guard(Kept),
    /// From here on the node is asked before its life time is over.
    Ask,
    /// 6060h, if it is another one.
    Mode,
    /// Up to operation enabled, from whatever state.
    Enable,
    /// Comes to rest if this client turns it with a velocity.
    Halt,
    /// Comes to rest if this client inches it.
    EndInching,
    /// 607Ah.
    Target,
    /// The velocity of the goal.
    Velocity,
    /// The control word of the goal.
    Inch,
    /// 6040h.
    Word(u16),
    /// Writes a [`Kept`] entry as it was.
    PutBack(Kept),
    /// 6060h as it was.
    ModeBack,
    /// NMT as it was.
    NmtBack,
}

/// What it means that the bits do not come in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Or {
    Fault,
    NotAcknowledged,
    NotReached,
    /// Nothing: it goes on.
    GoOn,
}

type Row = Step<Act, Or>;

const ACKNOWLEDGED: Bits = Bits::set(Statusword::SET_POINT_ACKNOWLEDGE.0);
const REACHED: Bits =
    Bits::set(Statusword::TARGET_REACHED.0).and(Bits::clear(Statusword::SET_POINT_ACKNOWLEDGE.0));
const ATTAINED: Bits = Bits::set(Statusword::HOMING_ATTAINED.0);
const NO_FAULT: Bits = Bits::clear(Statusword::FAULT.0);
const ENABLED: Bits = Bits { mask: 0x6F, value: State::OperationEnabled.bits().0 };
const NO_HOMING_ERROR: Bits = Bits::clear(Statusword::HOMING_ERROR.0);

/// Standing, or no longer in quick stop: nothing holds it there but this client.
const STANDS: &[Bits] = &[
    Bits::set(Statusword::TARGET_REACHED.0),
    Bits::clear(Statusword::READY_TO_SWITCH_ON.0),
    Bits::clear(Statusword::SWITCHED_ON.0),
    Bits::clear(Statusword::OPERATION_ENABLED.0),
    Bits::set(Statusword::FAULT.0),
    Bits::set(Statusword::QUICK_STOP.0),
    Bits::set(Statusword::SWITCH_ON_DISABLED.0),
];

/// A step that ends when the drive has confirmed it.
const fn act(act: Act) -> Row {
    Step::new(act, &[], Or::Fault)
}

/// Started and guarded.
const PREPARE: &[Row] = &[
    act(Act::Start),
    act(Act::Keep(Kept::Heartbeat)),
    act(Act::Keep(Kept::GuardTime)),
    act(Act::Keep(Kept::LifeFactor)),
    act(Act::Guard(Kept::Heartbeat)),
    act(Act::Guard(Kept::GuardTime)),
    act(Act::Guard(Kept::LifeFactor)),
    act(Act::Ask),
];

const STAND: &[Row] = &[act(Act::Enable)];

/// No velocity any more: another mode can be chosen. A drive that does not say so gets the time for it.
const REST: Row = Step::new(Act::Halt, &[Bits::set(Statusword::TARGET_REACHED.0)], Or::GoOn);

/// No inching any more; it is of the AG03/1, whose bit 15 says that it travels.
const INCHED: Row = Step::new(Act::EndInching, &[Bits::clear(1 << 15)], Or::GoOn);

const MOVE: &[Row] = &[
    REST,
    INCHED,
    act(Act::Mode),
    act(Act::Enable),
    act(Act::Target),
    Step::new(Act::Word(START), &[ACKNOWLEDGED], Or::NotAcknowledged).keeping(ENABLED),
    Step::new(Act::Word(ENABLE), &[REACHED], Or::NotReached).keeping(ENABLED).moving(),
];

const HOME: &[Row] = &[
    REST,
    INCHED,
    act(Act::Mode),
    act(Act::Enable),
    Step::new(Act::Word(START), &[ATTAINED], Or::NotReached).keeping(ENABLED.and(NO_HOMING_ERROR)).moving(),
];

/// A falling edge of "halt" starts it; some drives wait for the edge.
const TURN: &[Row] = &[
    REST,
    INCHED,
    act(Act::Mode),
    act(Act::Enable),
    act(Act::Velocity),
    act(Act::Word(HALT)),
    Step::new(Act::Word(ENABLE), &[Bits::set(Statusword::TARGET_REACHED.0)], Or::NotReached)
        .keeping(ENABLED)
        .moving(),
];

const INCH: &[Row] =
    &[REST, INCHED, act(Act::Mode), act(Act::Enable), act(Act::Word(ENABLE)), act(Act::Inch)];

const ACKNOWLEDGE: &[Row] = &[
    act(Act::Start),
    // Before the rising edge of bit 7.
    act(Act::Word(0)),
    Step::new(Act::Word(Controlword::FAULT_RESET.0), &[NO_FAULT], Or::Fault),
];

const STOP: &[Row] = &[Step::new(Act::Word(QUICK_STOP), STANDS, Or::GoOn).moving(), act(Act::Word(0))];

const LEAVE: &[Row] = &[
    act(Act::Word(0)),
    act(Act::PutBack(Kept::GuardTime)),
    act(Act::PutBack(Kept::LifeFactor)),
    act(Act::PutBack(Kept::Heartbeat)),
    act(Act::ModeBack),
    act(Act::NmtBack),
];

impl NodeGoal {
    pub(super) const fn course(self) -> Course<Act, Or> {
        match self {
            Self::Enable => Course::and_then(PREPARE, STAND),
            Self::MoveTo(_) => Course::and_then(PREPARE, MOVE),
            Self::Home => Course::and_then(PREPARE, HOME),
            Self::Turn { .. } => Course::and_then(PREPARE, TURN),
            Self::Inch { .. } => Course::and_then(PREPARE, INCH),
            Self::Acknowledge => Course::new(ACKNOWLEDGE),
            Self::Stop => Course::new(STOP),
            Self::Leave => Course::new(LEAVE),
        }
    }

    /// 6060h of it; on the AG03/1 1 is positioning.
    pub(super) const fn mode(self) -> Mode {
        match self {
            Self::Home => Mode::Homing,
            Self::Turn { mode, .. } => mode,
            Self::Enable
            | Self::MoveTo(_)
            | Self::Inch { .. }
            | Self::Acknowledge
            | Self::Stop
            | Self::Leave => Mode::ProfilePosition,
        }
    }

    /// The position it leads to.
    pub(super) const fn target(self) -> i32 {
        match self {
            Self::MoveTo(target) => target,
            Self::Enable
            | Self::Home
            | Self::Turn { .. }
            | Self::Inch { .. }
            | Self::Acknowledge
            | Self::Stop
            | Self::Leave => 0,
        }
    }

    /// The control word by which it inches.
    pub(super) const fn word(self) -> u16 {
        match self {
            Self::Inch { word } => word,
            Self::Enable
            | Self::MoveTo(_)
            | Self::Home
            | Self::Turn { .. }
            | Self::Acknowledge
            | Self::Stop
            | Self::Leave => ENABLE,
        }
    }

    /// Whether its mode is asked for by its name; a travel leaves another mode to whoever chose it.
    pub(super) const fn chooses_mode(self) -> bool {
        match self {
            Self::Home | Self::Turn { .. } | Self::Inch { .. } => true,
            Self::Enable | Self::MoveTo(_) | Self::Acknowledge | Self::Stop | Self::Leave => false,
        }
    }
}
