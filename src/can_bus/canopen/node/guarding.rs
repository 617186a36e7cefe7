//! Node guarding: answers with a toggle bit, and the supervision of the master (`canopen-link.md` 4).

use core::time::Duration;

use super::Node;
use super::errors::Cause;
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::application::{Application, Notice};
use crate::can_bus::canopen::cob_id;
use crate::can_bus::canopen::emcy;
use crate::can_bus::canopen::event::{Event, NoEffect};
use crate::time::Instant;

/// What was answered last and until when the next request has to come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Guarding {
    /// Bit 7 of the next answer.
    toggle: bool,
    watch: Watch,
}

/// The supervision of the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Watch {
    /// No request yet, or no life time.
    Off,
    /// The next request has to come before.
    Until(Instant),
    /// It did not.
    Expired,
}

impl Guarding {
    pub(super) const FRESH: Self = Self { toggle: false, watch: Watch::Off };

    pub(super) const fn due(&self) -> Option<Instant> {
        match self.watch {
            Watch::Until(due) => Some(due),
            Watch::Off | Watch::Expired => None,
        }
    }
}

impl Node {
    /// A remote frame on 700h + node.
    pub(super) fn guarding_request(&mut self, now: Instant, app: &mut dyn Application) {
        let Some(state) = self.state else { return };
        if self.values.heartbeat != 0 && !self.policy.guarding_beside_heartbeat {
            return self.no_effect(NoEffect::Guarding { heartbeat: true });
        }
        let life_time = self.life_time();
        if life_time.is_none() && !self.policy.guarding_without_times {
            return self.no_effect(NoEffect::Guarding { heartbeat: false });
        }
        let octet = state.octet() | u8::from(self.guarding.toggle) << 7;
        self.send(Frame::with(cob_id::of_node(cob_id::ERROR_CONTROL, self.node_id), [octet]));
        let was = self.guarding.watch;
        self.guarding = Guarding {
            toggle: !self.guarding.toggle,
            watch: life_time.map_or(Watch::Off, |time| Watch::Until(now.saturating_add(time))),
        };
        match was {
            Watch::Off | Watch::Until(_) => {}
            Watch::Expired => {
                self.error_ends(now, Cause::LifeGuarding, app);
                self.tell(Event::LifeGuardingBack);
                app.notice(now, Notice::LifeGuardingBack);
            }
        }
    }

    pub(super) fn guarding_timeout(&mut self, now: Instant, app: &mut dyn Application) {
        if self.guarding.due().is_none_or(|due| now < due) {
            return;
        }
        let Some(life_time) = self.life_time() else {
            self.guarding.watch = Watch::Off;
            return;
        };
        self.guarding.watch = Watch::Expired;
        self.tell(Event::LifeGuardingExpired {
            guard_time: Duration::from_millis(self.values.guard_time.into()),
            factor: self.values.life_time_factor,
        });
        let rule = self.policy.life_guarding_error;
        if rule.emcy {
            self.error_begins(now, Cause::LifeGuarding, emcy::ERROR_CONTROL, app);
        }
        app.notice(now, Notice::LifeGuardingExpired(life_time));
        if rule.behaviour {
            self.error_behaviour(now, app);
        }
    }

    /// 100Ch times 100Dh, `None` if either is zero.
    fn life_time(&self) -> Option<Duration> {
        let millis = u64::from(self.values.guard_time) * u64::from(self.values.life_time_factor);
        (millis != 0).then(|| Duration::from_millis(millis))
    }
}
