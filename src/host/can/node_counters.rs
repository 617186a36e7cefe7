//! What a node has heard and sent, and what went wrong at it.

use crate::can_bus::can::{ErrorState, Frame};
use crate::can_bus::canopen::sdo::{Response, SdoRequest};
use crate::can_bus::canopen::{Event, NmtState, Node, Service, cob_id};
use crate::devices::CanopenEvent;

/// Counters of a node: plain numbers that only grow. They begin at 0 when the node is made, and a power cycle leaves
/// them as they are. A frame that was sent counts when the bus takes it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct NodeCounters {
    /// Frames of clients to its SDO server, segments and aborts among them.
    pub sdo_requests: u64,
    /// SDO transfers that the node ended with an abort code.
    pub sdo_aborts: u64,
    /// SDO transfers that the client ended with an abort code.
    pub sdo_aborts_of_client: u64,
    /// RPDOs it has taken.
    pub pdos_received: u64,
    /// TPDOs it has sent.
    pub pdos_sent: u64,
    /// Emergencies it has sent, the ends of errors among them.
    pub emcy: u64,
    /// Emergencies with an error code among them: faults of the device.
    pub faults: u64,
    /// Heartbeats it has sent.
    pub heartbeats: u64,
    /// Guarding requests it has answered.
    pub guarding: u64,
    /// How often a supervision expired: life guarding, the heartbeat of another node.
    pub watchdog_expiries: u64,
    /// RPDOs whose length does not fit their mapping.
    pub rpdo_length: u64,
    /// Entries of RPDOs that were refused.
    pub rpdo_refused: u64,
    /// How often frames were lost because the bus did not take them in time.
    pub frames_lost: u64,
    /// How often it became error passive.
    pub error_passive: u64,
    /// How often it went bus off.
    pub bus_off: u64,
}

impl NodeCounters {
    /// Every kind of error with a name and how often.
    pub(crate) const fn errors(&self) -> [(&'static str, u64); 5] {
        [
            ("RPDO length", self.rpdo_length),
            ("RPDO refused", self.rpdo_refused),
            ("frames lost", self.frames_lost),
            ("error passive", self.error_passive),
            ("bus off", self.bus_off),
        ]
    }

    /// Counts a frame that the node is about to take.
    pub(super) fn hear(&mut self, node: &Node, frame: &Frame) {
        let Some(state) = node.state() else { return };
        if frame.is_remote() {
            return;
        }
        if frame.id() == cob_id::of_node(cob_id::SDO_CLIENT, node.node_id()) {
            if state.serves_sdo() {
                count(&mut self.sdo_requests);
                let octets = frame.octets().try_into().map(SdoRequest::decode);
                if matches!(octets, Ok(SdoRequest::Abort(_))) {
                    count(&mut self.sdo_aborts_of_client);
                }
            }
        } else if state == NmtState::Operational && node.takes_rpdo(frame.id()) {
            count(&mut self.pdos_received);
        }
    }

    /// Counts a frame that the node has sent.
    pub(super) fn send(&mut self, node: &Node, frame: &Frame) {
        match node.service_of(frame) {
            Some(Service::SdoAnswer) => {
                let answer = frame.octets().try_into().map(Response::decode);
                if matches!(answer, Ok(Some(Response::Abort { .. }))) {
                    count(&mut self.sdo_aborts);
                }
            }
            Some(Service::Tpdo(_)) => count(&mut self.pdos_sent),
            Some(Service::Emcy) => {
                count(&mut self.emcy);
                // Code 0000h is the end of an error.
                if frame.octets().get(..2).is_some_and(|code| code != [0, 0]) {
                    count(&mut self.faults);
                }
            }
            Some(Service::Heartbeat) => count(&mut self.heartbeats),
            Some(Service::Guarding) => count(&mut self.guarding),
            Some(Service::BootUp) | None => {}
        }
    }

    /// Counts what the node tells, if it is an error.
    pub(super) const fn tell(&mut self, event: &CanopenEvent) {
        let CanopenEvent::Node(event) = event else { return };
        match event {
            Event::RpdoLength { .. } => count(&mut self.rpdo_length),
            Event::RpdoRefused { .. } => count(&mut self.rpdo_refused),
            Event::LifeGuardingExpired { .. } | Event::HeartbeatLost { .. } => {
                count(&mut self.watchdog_expiries)
            }
            Event::FramesLost { .. } => count(&mut self.frames_lost),
            Event::BootUp { .. }
            | Event::State { .. }
            | Event::NmtIgnored { .. }
            | Event::NoEffect(_)
            | Event::SdoRefused(_)
            | Event::LssRefused(_)
            | Event::SegmentsMissed { .. }
            | Event::SdoAbortedByClient { .. }
            | Event::Written(_)
            | Event::Emergency { .. }
            | Event::LifeGuardingBack
            | Event::HeartbeatBack(_) => {}
        }
    }

    /// Counts that the error counters took the node to another state.
    pub(super) const fn enter(&mut self, before: ErrorState, state: ErrorState) {
        match (before, state) {
            (ErrorState::Active, ErrorState::Passive) => count(&mut self.error_passive),
            (ErrorState::Active | ErrorState::Passive, ErrorState::BusOff) => count(&mut self.bus_off),
            (
                ErrorState::Active | ErrorState::Passive | ErrorState::BusOff,
                ErrorState::Active | ErrorState::Passive,
            )
            | (ErrorState::BusOff, ErrorState::BusOff) => {}
        }
    }
}

const fn count(counter: &mut u64) {
    *counter = counter.saturating_add(1);
}
