//! The numbers of a line and of who is on it, as its thread copies them.

use core::fmt::Debug;

use crate::can_bus::can::ErrorState;
use crate::can_bus::canopen::NmtState;
use crate::devices::CanopenEvent;
use crate::face::DriveState;
use crate::host::can::{self, NodeCounters, Seat, StoredNode};
use crate::host::{Bus, Presence, StationErrors};
use crate::panel::Seated;
use crate::panel::queue::Lends;
use crate::profibus::dp;
use crate::profibus::fdl::{LineCounters, StationCounters};

/// The thread of a bus of PROFIBUS.
#[derive(Clone, Copy, Debug)]
pub(super) struct OfBus;

impl Lends for OfBus {
    type Access<'a> = &'a Bus;
}

/// The thread of a bus of CAN.
#[derive(Clone, Copy, Debug)]
pub(super) struct OfNodes;

impl Lends for OfNodes {
    type Access<'a> = (&'a can::Bus<CanopenEvent>, &'a [Seated]);
}

/// A line.
#[derive(Debug)]
pub(super) struct Line {
    /// Bit/s.
    pub(super) rate: u32,
    pub(super) counters: Counters,
    pub(super) members: Vec<Member>,
}

/// What passed on a line.
#[derive(Debug)]
pub(super) enum Counters {
    Profibus(Box<LineCounters>),
    Can(can::bus::Counters),
}

/// A station or a node.
#[derive(Debug)]
pub(super) struct Member {
    pub(super) address: u8,
    /// Which of the nodes with this number; that of stations is always 0.
    pub(super) twin: u8,
    pub(super) kind: &'static str,
    pub(super) model: String,
    pub(super) drive: Option<DriveState>,
    pub(super) of: Of,
}

/// What depends on the bus.
#[derive(Debug)]
pub(super) enum Of {
    Profibus { active: bool, slave: Option<dp::State>, counters: StationCounters, errors: StationErrors },
    Can { seat: Seat, nmt: Option<NmtState>, error_state: ErrorState, counters: NodeCounters },
}

impl Line {
    /// A copy of the numbers of a bus of PROFIBUS.
    pub(super) fn of_bus(bus: &Bus) -> Self {
        let member = |address| {
            let seen = bus.appearance(address)?;
            Some(Member {
                address: address.number(),
                twin: 0,
                kind: seen.kind.name(),
                model: seen.model.into_owned(),
                drive: seen.drive,
                of: Of::Profibus {
                    active: bus.presence(address) == Some(Presence::Active),
                    slave: seen.slave,
                    counters: *bus.station_counters(address)?,
                    errors: *bus.station_errors(address)?,
                },
            })
        };
        Self {
            rate: bus.baud().bits_per_second(),
            counters: Counters::Profibus(Box::new(*bus.counters())),
            members: bus.addresses().filter_map(member).collect(),
        }
    }

    /// A copy of the numbers of a bus of CAN. Which node is the twin of which is not known yet.
    pub(super) fn of_nodes(bus: &can::Bus<CanopenEvent>, nodes: &[Seated]) -> Self {
        let member = |Seated { seat, product }: &Seated| {
            let node: &StoredNode = bus.participant(*seat)?;
            let device = node.as_device();
            Some(Member {
                address: node.node_id().number(),
                twin: 0,
                kind: "node",
                model: product.name.into(),
                drive: device.description().drive_state(),
                of: Of::Can {
                    seat: *seat,
                    nmt: device.node().state(),
                    error_state: bus.confinement(*seat)?.state(),
                    counters: *node.counters(),
                },
            })
        };
        Self {
            rate: bus.rate().bits_per_second(),
            counters: Counters::Can(*bus.counters()),
            members: nodes.iter().filter_map(member).collect(),
        }
    }
}
