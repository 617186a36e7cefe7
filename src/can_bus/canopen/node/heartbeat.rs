//! Heartbeat: the node's own, and the supervision of others (`canopen-link.md` 4).

use core::time::Duration;

use super::Node;
use super::errors::Cause;
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::address::NodeId;
use crate::can_bus::canopen::application::{Application, NmtCause, Notice};
use crate::can_bus::canopen::cob_id;
use crate::can_bus::canopen::emcy;
use crate::can_bus::canopen::event::Event;
use crate::can_bus::canopen::nmt::NmtState;
use crate::can_bus::canopen::parameter::MAX_CONSUMERS;
use crate::time::Instant;

/// The supervision of one node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Consumer {
    /// Nothing was heard since the entry was set.
    Waiting,
    /// The next heartbeat has to come before.
    Until(Instant),
    /// It did not.
    Lost,
}

impl Consumer {
    pub(super) const fn due(self) -> Option<Instant> {
        match self {
            Self::Until(due) => Some(due),
            Self::Waiting | Self::Lost => None,
        }
    }
}

/// The node and the time of an entry of 1016h, `None` if it is off.
///
/// ```text
/// bits 31..24 zero   bits 23..16 node   bits 15..0 milliseconds
/// ```
pub(super) fn supervised(entry: u32) -> Option<(NodeId, Duration)> {
    let [low, high, node, 0] = entry.to_le_bytes() else { return None };
    let millis = u16::from_le_bytes([low, high]);
    let node = NodeId::new(node).ok()?;
    (millis != 0).then(|| (node, Duration::from_millis(millis.into())))
}

impl Node {
    /// 1017h was written, or the node booted: the first frame comes one period later.
    pub(super) fn restart_heartbeat(&mut self, now: Instant) {
        self.heartbeat_due = self.heartbeat_period().map(|period| now.saturating_add(period));
    }

    fn heartbeat_period(&self) -> Option<Duration> {
        match self.values.heartbeat {
            0 => None,
            millis => Some(Duration::from_millis(millis.into())),
        }
    }

    pub(super) fn heartbeat_timeout(&mut self, now: Instant) {
        let (Some(due), Some(period), Some(state)) =
            (self.heartbeat_due, self.heartbeat_period(), self.state)
        else {
            return;
        };
        if now < due {
            return;
        }
        self.send(Frame::with(cob_id::of_node(cob_id::ERROR_CONTROL, self.node_id), [state.octet()]));
        // Counted from when it was due, so that a late host does not shift the period; a very late one does.
        let next = due.saturating_add(period);
        self.heartbeat_due = Some(if next <= now { now.saturating_add(period) } else { next });
    }

    /// A frame on 700h + another node.
    pub(super) fn heartbeat_heard(
        &mut self,
        now: Instant,
        node: u8,
        frame: &Frame,
        app: &mut dyn Application,
    ) {
        if frame.octets().len() != 1 {
            return;
        }
        for place in 0..MAX_CONSUMERS {
            let entry = self.values.consumers.get(place).copied().and_then(supervised);
            let Some((supervised, time)) = entry.filter(|(supervised, _)| supervised.number() == node) else {
                continue;
            };
            match self.set_consumer(place, Consumer::Until(now.saturating_add(time))) {
                Some(Consumer::Waiting | Consumer::Until(_)) | None => {}
                Some(Consumer::Lost) => {
                    self.error_ends(now, Cause::Heartbeat(place), app);
                    self.tell(Event::HeartbeatBack(supervised));
                    app.notice(now, Notice::HeartbeatBack(supervised));
                }
            }
        }
    }

    /// Says what it was before.
    pub(super) fn set_consumer(&mut self, place: usize, to: Consumer) -> Option<Consumer> {
        let was = core::mem::replace(self.consumers.get_mut(place)?, to);
        self.consumer_due = self.consumers.iter().filter_map(|consumer| consumer.due()).min();
        Some(was)
    }

    pub(super) fn consumer_timeout(&mut self, now: Instant, app: &mut dyn Application) {
        if self.consumer_due.is_none_or(|due| now < due) {
            return;
        }
        for place in 0..MAX_CONSUMERS {
            if self.consumers.get(place).and_then(|consumer| consumer.due()).is_none_or(|due| now < due) {
                continue;
            }
            self.set_consumer(place, Consumer::Lost);
            let Some((node, time)) = self.values.consumers.get(place).copied().and_then(supervised) else {
                continue;
            };
            let sub = u8::try_from(place.saturating_add(1)).unwrap_or(u8::MAX);
            self.tell(Event::HeartbeatLost { node, time, sub });
            let rule = self.policy.heartbeat_error;
            if rule.emcy {
                self.error_begins(now, Cause::Heartbeat(place), emcy::ERROR_CONTROL, app);
            }
            app.notice(now, Notice::HeartbeatLost(node));
            if rule.behaviour {
                self.error_behaviour(now, app);
            }
        }
    }

    /// 1029h:1 after a communication error.
    pub(super) fn error_behaviour(&mut self, now: Instant, app: &mut dyn Application) {
        let to = match (self.has_error_behaviour, self.values.error_behaviour) {
            (true, 0) => Some(NmtState::PreOperational),
            (true, 2) => Some(NmtState::Stopped),
            (true, 1 | 3..) => None,
            (false, _) => self.policy.error_behaviour,
        };
        match (to, self.state) {
            (Some(NmtState::PreOperational), Some(NmtState::Operational)) => {
                self.enter(now, NmtState::PreOperational, NmtCause::ErrorBehaviour, app);
            }
            (Some(NmtState::Stopped), Some(_)) => {
                self.enter(now, NmtState::Stopped, NmtCause::ErrorBehaviour, app);
            }
            (Some(NmtState::PreOperational | NmtState::Operational | NmtState::Stopped) | None, _) => {}
        }
    }
}
