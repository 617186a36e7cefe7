//! Network management: states, commands, boot-up (`canopen-link.md` 3).

use core::fmt;

use super::address::NodeId;
use super::cob_id;
use crate::can_bus::can::Frame;

/// The state of a node that is switched on and initialised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NmtState {
    /// Only NMT and error control.
    Stopped,
    /// Everything.
    Operational,
    /// Everything but PDOs.
    PreOperational,
}

impl NmtState {
    /// The state in heartbeat and guarding frames.
    pub const fn octet(self) -> u8 {
        match self {
            Self::Stopped => 0x04,
            Self::Operational => 0x05,
            Self::PreOperational => 0x7F,
        }
    }

    /// The state that `octet` stands for; bit 7 is not looked at. `None` for boot-up and unknown states.
    pub(crate) const fn from_octet(octet: u8) -> Option<Self> {
        match octet & 0x7F {
            0x04 => Some(Self::Stopped),
            0x05 => Some(Self::Operational),
            0x7F => Some(Self::PreOperational),
            ..=0x03 | 0x06..=0x7E | 0x80.. => None,
        }
    }

    /// Whether SDOs are served and EMCY messages sent.
    pub const fn serves_sdo(self) -> bool {
        match self {
            Self::PreOperational | Self::Operational => true,
            Self::Stopped => false,
        }
    }
}

impl fmt::Display for NmtState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stopped => "STOPPED",
            Self::Operational => "OPERATIONAL",
            Self::PreOperational => "PRE-OPERATIONAL",
        })
    }
}

/// How far a reset goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reset {
    /// Switched on.
    PowerOn,
    /// 81h: everything as after power-on.
    Node,
    /// 82h: objects 1000h to 1FFFh as after power-on, node number and rate read again.
    Communication,
}

/// A command of the NMT master.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// 01h, 02h, 80h: to a state.
    Enter(NmtState),
    /// 81h, 82h: initialise.
    Reset(Reset),
}

impl Command {
    /// The command of frame 000h if it is for node `own`.
    ///
    /// ```text
    /// octet 0  01 start, 02 stop, 80 pre-operational, 81 reset node, 82 reset communication
    /// octet 1  node, 0 = all
    /// ```
    ///
    /// Exactly two octets; others are ignored.
    pub(crate) fn decode(frame: &Frame, own: NodeId) -> Option<Self> {
        let &[command, node] = frame.octets() else { return None };
        if node != 0 && node != own.number() {
            return None;
        }
        match command {
            0x01 => Some(Self::Enter(NmtState::Operational)),
            0x02 => Some(Self::Enter(NmtState::Stopped)),
            0x80 => Some(Self::Enter(NmtState::PreOperational)),
            0x81 => Some(Self::Reset(Reset::Node)),
            0x82 => Some(Self::Reset(Reset::Communication)),
            0x00 | 0x03..=0x7F | 0x83.. => None,
        }
    }

    /// The frame for one node, `None` for all.
    pub fn frame(self, node: Option<NodeId>) -> Frame {
        Frame::with(cob_id::NMT_ID, [self.octet(), node.map_or(0, NodeId::number)])
    }

    /// The first octet of the frame; power-on is no command of a bus and reads as 81h.
    pub(crate) const fn octet(self) -> u8 {
        match self {
            Self::Enter(NmtState::Operational) => 0x01,
            Self::Enter(NmtState::Stopped) => 0x02,
            Self::Enter(NmtState::PreOperational) => 0x80,
            Self::Reset(Reset::Node | Reset::PowerOn) => 0x81,
            Self::Reset(Reset::Communication) => 0x82,
        }
    }
}
