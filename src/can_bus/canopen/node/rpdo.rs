//! RPDOs: taken at once or at the next SYNC.

use super::Node;
use super::errors::Cause;
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::address::Address;
use crate::can_bus::canopen::application::{Application, Notice, Source};
use crate::can_bus::canopen::cob_id::{self, CobId};
use crate::can_bus::canopen::emcy;
use crate::can_bus::canopen::event::{AwaitsSync, Event, NoEffect};
use crate::can_bus::canopen::parameter::PdoParameters;
use crate::can_bus::canopen::pdo::mapping::{self, Pieces};
use crate::can_bus::canopen::pdo::{MAX_MAPPED, PdoNumber, TransmissionType};
use crate::time::Instant;

/// One RPDO.
#[derive(Clone, Debug)]
pub(super) struct Rpdo {
    /// While it is on.
    pub(super) id: Option<Id>,
    pieces: Pieces,
    octets: usize,
    /// The newest frame, waiting for SYNC.
    waiting: Option<[u8; 8]>,
    /// How many before it waited in vain since the last SYNC.
    unread: u8,
    /// What was taken last.
    last: Option<u64>,
    /// An entry of it that an SDO has written since then, with another value.
    rewritten: Option<Address>,
}

/// So many frames without a SYNC between them show that none comes.
const UNREAD: u8 = 10;

impl Rpdo {
    pub(super) const OFF: Self = Self {
        id: None,
        pieces: Pieces::new(),
        octets: 0,
        waiting: None,
        unread: 0,
        last: None,
        rewritten: None,
    };

    const fn take_waiting(&mut self) -> Option<[u8; 8]> {
        self.unread = 0;
        self.waiting.take()
    }

    /// Forgets what has come.
    pub(super) const fn forget(&mut self) {
        self.waiting = None;
        self.unread = 0;
        self.last = None;
        self.rewritten = None;
    }

    /// What `data` carries for an entry.
    fn value_of(&self, at: Address, data: u64) -> Option<u64> {
        let mut begin = 0;
        for piece in &self.pieces {
            if piece.at == at {
                return Some(piece.take(data, begin));
            }
            begin += piece.bits;
        }
        None
    }

    /// An SDO has written an entry.
    fn sdo_wrote(&mut self, at: Address, value: u64) {
        let before = self.last.and_then(|last| self.value_of(at, last));
        if before.is_some_and(|before| before != value) {
            self.rewritten = Some(at);
        }
    }

    /// Octets are taken: the entry whose value of before the SDO they put back.
    fn puts_back(&mut self, data: u64) -> Option<Address> {
        let before = self.last.replace(data)?;
        let at = self.rewritten.take()?;
        (self.value_of(at, before) == self.value_of(at, data)).then_some(at)
    }
}

impl Node {
    /// Puts the objects of an RPDO into effect.
    pub(super) fn set_up_rpdo(&mut self, place: usize) {
        let values = self.values.rpdos.at(place);
        let pieces = mapping::pieces(self.objects, values.mapping());
        let octets = mapping::octets(&pieces);
        let id = CobId(values.cob_id).active();
        if let Some(rpdo) = self.rpdos.get_mut(place) {
            *rpdo = Rpdo { id, pieces, octets, ..Rpdo::OFF };
        }
    }

    /// An SDO has written an entry: an RPDO may put the old value back.
    pub(super) fn sdo_wrote(&mut self, at: Address, octets: &[u8]) {
        let mut value = [0; 8];
        value.iter_mut().zip(octets).for_each(|(place, octet)| *place = *octet);
        self.rpdos.iter_mut().for_each(|rpdo| rpdo.sdo_wrote(at, u64::from_le_bytes(value)));
    }

    /// The place of the RPDO with that identifier.
    pub(super) fn rpdo_of(&self, id: Id) -> Option<usize> {
        self.rpdos.iter().position(|rpdo| rpdo.id == Some(id))
    }

    /// Whether this is the identifier of an RPDO that is on, whatever it carries.
    pub(crate) fn takes_rpdo(&self, id: Id) -> bool {
        self.rpdo_of(id).is_some()
    }

    /// The RPDO with that identifier, or else the one whose usual identifier it is.
    pub(super) fn rpdo_meant(&self, id: Id) -> Option<PdoNumber> {
        let on = self.rpdo_of(id).map(|place| self.values.rpdos.at(place).number);
        on.or_else(|| self.usual_pdo(cob_id::RPDO_1, id))
    }

    /// The PDO of this node whose usual identifier that is; `first` is that of PDO 1 without the node number.
    pub(super) fn usual_pdo(&self, first: u16, id: Id) -> Option<PdoNumber> {
        let usual = |number: &u16| cob_id::of_node(first + 0x100 * (number - 1), self.node_id) == id;
        (1..=4).find(usual).and_then(PdoNumber::new)
    }

    /// A frame that is for nobody: of a master that has sent none of our RPDOs, the node number may be missing.
    pub(super) fn look_for_node_number(&mut self, id: Id) {
        let usual = |number: u16| cob_id::RPDO_1 + 0x100 * (number - 1);
        let of = |number: &u16| Id::base(usual(*number)) == Ok(id);
        let Some(number) = (1..=4).find(of) else { return };
        let waits = self.rpdos.iter().all(|rpdo| rpdo.last.is_none() && rpdo.waiting.is_none());
        if let (Some(pdo), true) = (PdoNumber::new(number), waits) {
            let got = usual(number);
            let usual = got + u16::from(self.node_id.number());
            self.no_effect(NoEffect::RpdoWithoutNode { pdo, got, usual });
        }
    }

    /// A data frame for an RPDO in OPERATIONAL.
    pub(super) fn rpdo_received(
        &mut self,
        now: Instant,
        place: usize,
        frame: &Frame,
        app: &mut dyn Application,
    ) {
        let &PdoParameters { number: pdo, kind, .. } = self.values.rpdos.at(place);
        let in_window = self.in_sync_window(now);
        self.pdos_are_used(now);
        let Some(&Rpdo { octets: needed, .. }) = self.rpdos.get(place) else { return };
        let octets = frame.octets();
        if needed == 0 {
            return self.no_effect(NoEffect::RpdoEmpty { pdo });
        }
        let [expected, got] = [needed, octets.len()].map(|len| u8::try_from(len).unwrap_or(8));
        if got < expected {
            self.tell(Event::RpdoLength { pdo, expected, got });
            if self.policy.rpdo_short_emcy {
                self.error_begins(now, Cause::RpdoLength(place), emcy::RPDO_LENGTH, app);
            }
            app.notice(now, Notice::RpdoLength { pdo, expected, got });
            return;
        }
        if got > expected {
            self.no_effect(NoEffect::RpdoLong { pdo, expected, got });
        }
        let Some(rpdo) = self.rpdos.get_mut(place) else { return };
        let mut data = [0; 8];
        for (place, octet) in data.iter_mut().zip(octets) {
            *place = *octet;
        }
        if TransmissionType(kind).is_synchronous() {
            if !in_window {
                self.no_effect(NoEffect::RpdoLate { pdo });
            } else if rpdo.waiting.replace(data).is_some() {
                rpdo.unread = rpdo.unread.saturating_add(1);
                if rpdo.unread == UNREAD {
                    self.miss_sync(now, AwaitsSync::Rpdo(pdo), app);
                }
            }
        } else {
            self.take(now, place, data, app);
        }
        self.error_ends(now, Cause::RpdoLength(place), app);
    }

    /// SYNC: what waits acts, the lowest number first.
    pub(super) fn take_synchronous_rpdos(&mut self, now: Instant, app: &mut dyn Application) {
        for place in 0..self.rpdos.len() {
            if let Some(data) = self.rpdos.get_mut(place).and_then(Rpdo::take_waiting) {
                self.take(now, place, data, app);
            }
        }
    }

    fn take(&mut self, now: Instant, place: usize, data: [u8; 8], app: &mut dyn Application) {
        let pdo = self.values.rpdos.at(place).number;
        let data = u64::from_le_bytes(data);
        if let Some(at) = self.rpdos.get_mut(place).and_then(|rpdo| rpdo.puts_back(data)) {
            self.no_effect(NoEffect::SdoOverwritten { pdo, at });
        }
        let mut begin = 0;
        for mapped in 0..MAX_MAPPED {
            let piece = self.rpdos.get(place).and_then(|rpdo| rpdo.pieces.get(mapped));
            let Some(&piece) = piece else { break };
            // A mapping may take less than the whole entry: the rest is zero.
            let value = piece.take(data, begin).to_le_bytes();
            begin += piece.bits;
            let Some(entry) = piece.entry else { continue };
            let value = value.get(..entry.data.octets().unwrap_or_default()).unwrap_or_default();
            let judged = match entry.data.decode(value) {
                Some(value) if self.policy.rpdo_limits => self.policy.judge_range(entry, value),
                Some(_) | None => Ok(()),
            };
            let source = Source::Rpdo(pdo);
            let written = judged.and_then(|()| self.write_home(now, piece.at, entry, value, source, app));
            if let Err(broken) = written {
                let refusal = self.refusal_of_write(piece.at, broken, value, app);
                self.tell(Event::RpdoRefused { pdo, refusal });
                app.notice(now, Notice::RpdoRefused { pdo, at: piece.at, abort: broken.code });
            }
        }
        app.notice(now, Notice::RpdoTaken(pdo));
    }

    /// A remote request of an RPDO: answered only by devices that say with what.
    pub(super) fn rpdo_requested(&mut self, place: usize, app: &dyn Application) {
        let pdo = self.values.rpdos.at(place).number;
        let answer = self.policy.rpdo_rtr.iter().find(|answer| answer.pdo == pdo);
        let id = self.rpdos.get(place).and_then(|rpdo| rpdo.id);
        if let (Some(answer), Some(id)) = (answer, id) {
            let pieces = mapping::pieces(self.objects, answer.mapping);
            let mut data = self.sample(&pieces, app);
            app.complete_rtr_answer(pdo, &mut data);
            if let Ok(frame) = Frame::data(id, data.get(..mapping::octets(&pieces)).unwrap_or_default()) {
                self.send(frame);
            }
        }
    }
}
