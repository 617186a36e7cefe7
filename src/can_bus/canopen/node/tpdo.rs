//! TPDOs: sent after SYNC, on request, on events and by time.

use core::time::Duration;

use super::Node;
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::address::Address;
use crate::can_bus::canopen::application::Application;
use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::event::NoEffect;
use crate::can_bus::canopen::pdo::mapping::{self, Pieces};
use crate::can_bus::canopen::pdo::{PdoNumber, TransmissionType, Trigger};
use crate::can_bus::canopen::policy::{EventRule, TypeZero};
use crate::time::Instant;

/// One TPDO.
#[derive(Clone, Debug)]
pub(super) struct Tpdo {
    /// While it is on and carries something.
    pub(super) id: Option<Id>,
    trigger: Trigger,
    pieces: Pieces,
    octets: usize,
    /// SYNCs since it was sent last.
    syncs: u8,
    /// It does not count before the SYNC with this counter (sub-index 6).
    starts_at: Option<u8>,
    /// What was sent last, or sampled last: what a change is held against.
    data: [u8; 8],
    /// Something happened that is not sent yet.
    event: bool,
    /// It is not sent before.
    inhibited_until: Instant,
    /// Sent then at the latest.
    timer: Option<Instant>,
}

impl Tpdo {
    pub(super) const OFF: Self = Self {
        id: None,
        trigger: Trigger::Request,
        pieces: Pieces::new(),
        octets: 0,
        syncs: 0,
        starts_at: None,
        data: [0; 8],
        event: false,
        inhibited_until: Instant::ZERO,
        timer: None,
    };

    /// When something is to be done for it in OPERATIONAL.
    pub(super) fn due(&self) -> Option<Instant> {
        let event = self.event.then_some(self.inhibited_until);
        Instant::first_of(event.filter(|_| self.trigger.is_event()), self.timer)
    }
}

impl Node {
    /// The first TPDO that waits for SYNC.
    pub(super) fn synchronous_tpdo(&self) -> Option<PdoNumber> {
        let waits = |tpdo: &Tpdo| tpdo.id.is_some() && matches!(tpdo.trigger, Trigger::EverySync(_));
        self.tpdos.iter().position(waits).map(|place| self.values.tpdos.at(place).number)
    }

    /// Puts the objects of a TPDO into effect; counters and timers begin anew.
    pub(super) fn set_up_tpdo(&mut self, now: Instant, place: usize, app: &dyn Application) {
        let values = self.values.tpdos.at(place);
        let pieces = mapping::pieces(self.objects, values.mapping());
        let octets = mapping::octets(&pieces);
        let id = CobId(values.cob_id).active().filter(|_| octets != 0);
        let trigger = TransmissionType(values.kind).trigger();
        let data = if id.is_some() { self.sample(&pieces, app) } else { [0; 8] };
        let starts_at =
            (self.values.sync_counter != 0 && values.sync_start != 0).then_some(values.sync_start);
        if let Some(tpdo) = self.tpdos.get_mut(place) {
            *tpdo = Tpdo { id, trigger, pieces, octets, data, starts_at, ..Tpdo::OFF };
        }
        self.restart_event_timer(now, place);
    }

    /// OPERATIONAL is entered: counters and timers begin, and what has to be said at once is said.
    pub(super) fn start_tpdos(&mut self, now: Instant, app: &dyn Application) {
        for place in 0..self.tpdos.len() {
            self.set_up_tpdo(now, place, app);
            let Some(tpdo) = self.tpdos.get(place) else { continue };
            if self.event_rule(tpdo.trigger).is_some_and(|rule| rule.on_start) {
                self.tpdo_event(now, place, app);
            }
        }
    }

    /// The device or the bus wants an event-driven TPDO; others are marked for the next SYNC.
    pub(super) fn tpdo_event(&mut self, now: Instant, place: usize, app: &dyn Application) {
        if let Some(tpdo) = self.tpdos.get_mut(place) {
            tpdo.event = tpdo.id.is_some();
            self.send_if_allowed(now, place, app);
        }
    }

    /// The device says that this entry has changed: an event for each TPDO that carries it. They are sent when all such
    /// entries are told.
    pub(super) fn entry_changed(&mut self, at: Address) {
        let carries = |tpdo: &&mut Tpdo| tpdo.pieces.iter().any(|piece| piece.at == at);
        self.tpdos.iter_mut().filter(carries).for_each(|tpdo| tpdo.event = tpdo.id.is_some());
    }

    /// Whether values differ from those sent last, but for those whose changes the device tells.
    fn is_changed(&self, tpdo: &Tpdo, app: &dyn Application) -> bool {
        let (before, data) = (u64::from_le_bytes(tpdo.data), self.sample(&tpdo.pieces, app));
        let changed = u64::from_le_bytes(data) ^ before;
        let mut begin = 0;
        changed != 0
            && tpdo.pieces.iter().any(|piece| {
                let differs = piece.take(changed, begin) != 0;
                begin += piece.bits;
                differs && !app.tells_changes(piece.at)
            })
    }

    /// SYNC: samples, counts and sends.
    pub(super) fn send_synchronous_tpdos(
        &mut self,
        now: Instant,
        counter: Option<u8>,
        app: &dyn Application,
    ) {
        for place in 0..self.tpdos.len() {
            let Some(tpdo) = self.tpdos.get(place) else { continue };
            if tpdo.id.is_none() {
                continue;
            }
            match tpdo.trigger {
                Trigger::EverySync(_) if tpdo.starts_at.is_some() && tpdo.starts_at != counter => {}
                Trigger::EverySync(n) => {
                    let syncs = tpdo.syncs.saturating_add(1);
                    let send = syncs >= n;
                    if let Some(tpdo) = self.tpdos.get_mut(place) {
                        tpdo.syncs = if send { 0 } else { syncs };
                        tpdo.starts_at = None;
                    }
                    if send {
                        self.sample_and_send(now, place, app);
                    }
                }
                Trigger::SyncAfterEvent => {
                    let send = match self.policy.type_0 {
                        TypeZero::EverySync => true,
                        TypeZero::OnChange => tpdo.event || self.is_changed(tpdo, app),
                    };
                    if send {
                        self.sample_and_send(now, place, app);
                    }
                }
                Trigger::RequestSampledAtSync => {
                    let data = self.sample(&tpdo.pieces, app);
                    if let Some(tpdo) = self.tpdos.get_mut(place) {
                        tpdo.data = data;
                    }
                }
                Trigger::Request | Trigger::Event254 | Trigger::Event255 => {}
            }
        }
    }

    /// Looks for changes and timers of event-driven TPDOs in OPERATIONAL.
    pub(super) fn send_event_driven_tpdos(&mut self, now: Instant, app: &dyn Application) {
        for place in 0..self.tpdos.len() {
            let Some(tpdo) = self.tpdos.get(place) else { continue };
            let Some(rule) = self.event_rule(tpdo.trigger) else { continue };
            if tpdo.id.is_none() {
                continue;
            }
            let timer = tpdo.timer.is_some_and(|timer| timer <= now);
            let event = tpdo.event || timer || rule.change && self.is_changed(tpdo, app);
            if let Some(tpdo) = self.tpdos.get_mut(place) {
                tpdo.event = event;
                if timer {
                    tpdo.timer = None;
                }
            }
            if event {
                self.send_if_allowed(now, place, app);
            }
        }
    }

    /// A remote request of a TPDO in OPERATIONAL.
    pub(super) fn tpdo_requested(&mut self, place: usize, app: &dyn Application) {
        let values = self.values.tpdos.at(place);
        let Some(tpdo) = self.tpdos.get(place) else { return };
        if !self.policy.tpdo_rtr || CobId(values.cob_id).bit_30() {
            return self.no_effect(NoEffect::TpdoRequest { pdo: values.number });
        }
        let data = match tpdo.trigger {
            Trigger::RequestSampledAtSync => tpdo.data,
            Trigger::SyncAfterEvent
            | Trigger::EverySync(_)
            | Trigger::Request
            | Trigger::Event254
            | Trigger::Event255 => self.sample(&tpdo.pieces, app),
        };
        self.send_tpdo(place, data);
    }

    /// The place of the TPDO with that identifier.
    pub(super) fn tpdo_of(&self, id: Id) -> Option<usize> {
        self.tpdos.iter().position(|tpdo| tpdo.id == Some(id))
    }

    /// The values of the pieces now. One that cannot be read is zero.
    pub(super) fn sample(&self, pieces: &Pieces, app: &dyn Application) -> [u8; 8] {
        let mut data = 0;
        let mut begin = 0;
        for piece in pieces {
            if let Some(entry) = piece.entry {
                let _ = self.value_with(piece.at, entry, app, |octets| {
                    let mut low = [0; 8];
                    low.iter_mut().zip(octets).for_each(|(place, octet)| *place = *octet);
                    data |= piece.place(u64::from_le_bytes(low), begin);
                    Ok(())
                });
            }
            begin += piece.bits;
        }
        data.to_le_bytes()
    }

    /// 1800h:5 was written, or the PDO was sent.
    pub(super) fn restart_event_timer(&mut self, now: Instant, place: usize) {
        let millis = self.values.tpdos.at(place).event_timer;
        let Some(tpdo) = self.tpdos.get_mut(place) else { return };
        let runs = millis != 0 && tpdo.id.is_some() && tpdo.trigger.is_event();
        tpdo.timer = runs.then(|| now.saturating_add(Duration::from_millis(millis.into())));
    }

    const fn event_rule(&self, trigger: Trigger) -> Option<EventRule> {
        match trigger {
            Trigger::Event254 => Some(self.policy.type_254),
            Trigger::Event255 => Some(self.policy.type_255),
            Trigger::SyncAfterEvent
            | Trigger::EverySync(_)
            | Trigger::Request
            | Trigger::RequestSampledAtSync => None,
        }
    }

    fn send_if_allowed(&mut self, now: Instant, place: usize, app: &dyn Application) {
        let Some(tpdo) = self.tpdos.get(place) else { return };
        let Some(rule) = self.event_rule(tpdo.trigger) else { return };
        if tpdo.event && (!rule.inhibit || tpdo.inhibited_until <= now) {
            self.sample_and_send(now, place, app);
            let inhibit = Duration::from_micros(u64::from(self.values.tpdos.at(place).inhibit) * 100);
            if let Some(tpdo) = self.tpdos.get_mut(place)
                && rule.inhibit
            {
                tpdo.inhibited_until = now.saturating_add(inhibit);
            }
        }
    }

    fn sample_and_send(&mut self, now: Instant, place: usize, app: &dyn Application) {
        let Some(tpdo) = self.tpdos.get(place) else { return };
        let data = self.sample(&tpdo.pieces, app);
        if let Some(tpdo) = self.tpdos.get_mut(place) {
            tpdo.data = data;
            tpdo.event = false;
        }
        self.restart_event_timer(now, place);
        self.send_tpdo(place, data);
    }

    fn send_tpdo(&mut self, place: usize, data: [u8; 8]) {
        let Some(tpdo) = self.tpdos.get(place) else { return };
        let data = data.get(..tpdo.octets).unwrap_or_default();
        if let Some(Ok(frame)) = tpdo.id.map(|id| Frame::data(id, data)) {
            self.send(frame);
        }
    }
}
