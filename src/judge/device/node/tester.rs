//! What the rows of nodes are judged with: the node, its state, and what was written to it.

use core::time::Duration;
use std::collections::BTreeMap;

use super::objects::Known;
use super::wire::{Passed, Wire};
use super::{Setup, rows};
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::{Address, NmtState, NodeId, cob_id};
use crate::explain::canopen::Network;
use crate::explain::hex;
use crate::judge::device::attendant::Attended;
use crate::judge::device::course::{Course, Halt, broken, inapplicable};
use crate::judge::device::play::Trial;
use crate::judge::device::row::{Group, Table};
use crate::judge::device::{Attendant, Ending, Soak};
use crate::judge::moment::{Side, Telegram};
use crate::profibus::fdl;
use crate::time::Instant;

/// An answer that takes longer is late: clients give up then.
pub(super) const LATE: Duration = Duration::from_millis(300);
/// An answer that takes longer is none.
const PATIENCE: Duration = Duration::from_millis(1000);
/// Some drives take two SDO requests within a millisecond for an overrun.
const PAUSE: Duration = Duration::from_micros(1200);
/// Nothing comes if nothing came in this time, and what the link adds.
const SILENCE: Duration = Duration::from_millis(20);
const QUICK_SILENCE: Duration = Duration::from_millis(10);
/// The longest time until an answer loses such a part with each answer.
const FORGETS: u32 = 1000;
/// A heartbeat that is not worth waiting for.
const SELDOM: Duration = Duration::from_millis(100);
/// Boot-up after a reset comes within this time.
const BOOT: Duration = Duration::from_secs(10);
/// Frames that are shown of one row at most: the last ones.
const SHOWN: usize = 24;
/// Probes of a node that no longer answers.
const PROBES: u32 = 3;

/// A node under test, and a master beside it.
pub struct Tester {
    pub(super) setup: Setup,
    pub(super) wire: Wire,
    pub(super) known: Known,
    attendant: Attended,
    /// Entries that were written, and what they held, oldest first.
    written: Vec<(Address, Vec<u8>)>,
    /// The row has left behind what only a reset ends.
    dirty: bool,
    /// Guarding requests are answered.
    pub(super) guarded: bool,
    /// When an SDO was sent last, and the least time until the next one.
    asked: Instant,
    pub(super) pause: Duration,
    /// The longest time until the answer to an SDO, of the last few thousand.
    pub(super) longest: Duration,
    /// What is held against rows that were tried: the first breach.
    noted: BTreeMap<&'static str, (String, Vec<Telegram>)>,
    /// The second segment of the next block is lost.
    pub(super) lose_segment: bool,
    /// Services that have an identifier now that is none of the predefined connection set.
    pub(super) moved: Vec<Id>,
}

impl core::fmt::Debug for Tester {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Tester").field("setup", &self.setup).field("wire", &self.wire).finish_non_exhaustive()
    }
}

impl Tester {
    pub(super) fn new(setup: Setup, wire: Wire, attendant: Option<Box<dyn Attendant>>) -> Self {
        Self {
            asked: wire.now(),
            setup,
            wire,
            known: Known::default(),
            attendant: Attended(attendant),
            written: Vec::new(),
            dirty: false,
            guarded: false,
            pause: PAUSE,
            longest: Duration::ZERO,
            noted: BTreeMap::new(),
            lose_segment: false,
            moved: Vec::new(),
        }
    }

    pub(super) const fn node(&self) -> NodeId {
        self.setup.node
    }

    /// Another node number than that of the node.
    pub(super) const fn other(&self) -> NodeId {
        let other =
            if self.node().number() == 1 { NodeId::new(2) } else { NodeId::new(self.node().number() - 1) };
        match other {
            Ok(other) => other,
            Err(_) => NodeId::MIN,
        }
    }

    /// The identifier of a service of the node.
    pub(super) const fn id(&self, service: u16) -> Id {
        cob_id::of_node(service, self.node())
    }

    /// How long nothing must come to say that nothing comes.
    pub(super) fn silence(&self) -> Duration {
        let silence = if self.setup.quick { QUICK_SILENCE } else { SILENCE };
        silence + self.moment()
    }

    /// What a node needs to be in another state; none of ours does in virtual time. A node that answers slowly needs more.
    pub(super) fn moment(&self) -> Duration {
        if self.wire.latency.is_zero() {
            Duration::ZERO
        } else {
            self.wire.latency / 6 + self.longest.min(LATE)
        }
    }

    /// The time of supervision in rows that wait for its end.
    pub(super) const fn supervision(&self) -> Duration {
        Duration::from_millis(if self.setup.quick { 50 } else { 100 })
    }

    /// The row writes to the node.
    pub(super) fn may_write(&self) -> Course {
        if self.setup.write {
            Ok(())
        } else {
            inapplicable("needs --write: it writes to objects of the node")
        }
    }

    /// The row may make something move.
    pub(super) fn may_move(&self) -> Course {
        self.may_write()?;
        if self.setup.moves_allowed {
            return Ok(());
        }
        inapplicable("needs --moves-allowed: it changes process data of the node, and something may move")
    }

    /// Has somebody do this at the node.
    pub(super) fn act(&mut self, action: &str) -> Course<String> {
        self.attendant.act(action)
    }

    /// Sends a frame of data.
    pub(super) fn send(&mut self, id: Id, octets: &[u8]) -> Course {
        match Frame::data(id, octets) {
            Ok(frame) => self.wire.send(frame),
            Err(error) => Err(Halt::Missed(error.to_string())),
        }
    }

    /// Sends a remote request.
    pub(super) fn request(&mut self, id: Id, dlc: u8) -> Course {
        match Frame::remote(id, dlc) {
            Ok(frame) => self.wire.send(frame),
            Err(error) => Err(Halt::Missed(error.to_string())),
        }
    }

    /// A command of NMT as octets.
    pub(super) fn nmt(&mut self, octets: &[u8]) -> Course {
        self.send(cob_id::NMT_ID, octets)
    }

    /// Everything that comes in this time.
    pub(super) fn collect(&mut self, time: Duration) -> Course<Vec<Passed>> {
        let until = self.wire.now().saturating_add(time);
        let mut all = Vec::new();
        while let Some(passed) = self.wire.hear(until)? {
            all.push(passed);
        }
        Ok(all)
    }

    /// The first frame that is wanted, within this time; others are passed over.
    pub(super) fn find(
        &mut self,
        time: Duration,
        mut wanted: impl FnMut(&Frame) -> bool,
    ) -> Course<Option<Passed>> {
        let until = self.wire.now().saturating_add(time);
        while let Some(passed) = self.wire.hear(until)? {
            if wanted(&passed.frame) {
                return Ok(Some(passed));
            }
        }
        Ok(None)
    }

    /// What has come meanwhile: nobody waits for it.
    pub(super) fn drain(&mut self) -> Course {
        self.drain_until(self.wire.now())
    }

    fn drain_until(&mut self, until: Instant) -> Course {
        while let Some(passed) = self.wire.hear(until)? {
            if passed.frame.id() == self.id(cob_id::SDO_SERVER) {
                self.note("N-O15", "an SDO answer that nobody waits for: a second one, or a late one");
            }
        }
        Ok(())
    }

    /// No frame with this identifier may come now.
    pub(super) fn silent_on(&mut self, id: Id, why: &str) -> Course {
        match self.find(self.silence(), |frame| frame.id() == id)? {
            None => Ok(()),
            Some(Passed { frame, .. }) => broken(format!("{why}, and {frame} comes")),
        }
    }

    /// Holds something against a row.
    pub(super) fn note(&mut self, row: &'static str, why: &str) {
        if !self.noted.contains_key(row) {
            let shown = self.shown_of(self.wire.last_passed(6));
            self.noted.insert(row, (why.into(), shown));
        }
    }

    /// The boot-up of a reset. What was on its way may come before it.
    pub(super) fn boot_up(&mut self, what: &str) -> Course {
        self.boots(what, false)
    }

    /// The boot-up of a reset of a node that was silent, and nothing before it.
    pub(super) fn boot_up_first(&mut self, what: &str) -> Course {
        self.boots(what, true)
    }

    fn boots(&mut self, what: &str, first: bool) -> Course {
        self.moved.clear();
        let id = self.id(cob_id::ERROR_CONTROL);
        let time = if self.known.boots_silently { BOOT / 10 } else { BOOT };
        let until = self.wire.now().saturating_add(time);
        loop {
            let Some(Passed { frame, .. }) = self.wire.hear(until)? else {
                self.alive()?;
                self.known.boots_silently = true;
                return broken(format!("no boot-up after {what} within {} s", time.as_secs()));
            };
            if frame.id() == id && !frame.is_remote() && frame.octets() == [0] {
                return Ok(());
            }
            if first && self.is_own(&frame) {
                return broken(format!("{frame} comes before the boot-up after {what}"));
            }
        }
    }

    /// Whether a frame has an identifier of the node.
    fn is_own(&self, frame: &Frame) -> bool {
        const SERVICES: [u16; 7] = [0x080, 0x180, 0x280, 0x380, 0x480, 0x580, 0x700];
        SERVICES.iter().any(|service| frame.id() == self.id(*service))
    }

    /// Resets the communication of the node, and waits for its boot-up.
    pub(super) fn reset(&mut self) -> Course {
        self.reset_by(0x82, "reset communication")
    }

    fn reset_by(&mut self, command: u8, name: &str) -> Course {
        self.drain()?;
        self.nmt(&[command, self.node().number()])?;
        self.boot_up(name)?;
        // In virtual time the node takes requests from then on; another one needs a moment.
        self.collect(self.moment()).map(drop)
    }

    /// What the row leaves behind only a reset ends.
    pub(super) const fn leaves_errors(&mut self) {
        self.dirty = true;
    }

    /// Has the node enter a state.
    pub(super) fn enter(&mut self, state: NmtState) -> Course {
        let command = match state {
            NmtState::Operational => 0x01,
            NmtState::Stopped => 0x02,
            NmtState::PreOperational => 0x80,
        };
        self.nmt(&[command, self.node().number()])?;
        // It takes the next frame in its new state; another node than ours needs a moment.
        self.collect(self.moment()).map(drop)
    }

    /// The answer to a guarding request: bit 7 toggle, then the state.
    pub(super) fn guard(&mut self) -> Course<Option<u8>> {
        let id = self.id(cob_id::ERROR_CONTROL);
        self.request(id, 1)?;
        let answer = self.find(self.silence(), |frame| frame.id() == id && !frame.is_remote())?;
        match answer {
            None => Ok(None),
            Some(Passed { frame, .. }) => match frame.octets() {
                [octet] => Ok(Some(*octet)),
                octets => broken(format!("guarding is answered with {} octets, expected 1", octets.len())),
            },
        }
    }

    /// The state of the node: by guarding, else by its heartbeat; `None`: it has neither.
    pub(super) fn state(&mut self) -> Course<Option<u8>> {
        if self.guarded {
            return Ok(self.guard()?.map(|octet| octet & 0x7F));
        }
        let Some(period) = self.known.heartbeat else { return Ok(None) };
        let id = self.id(cob_id::ERROR_CONTROL);
        self.drain()?;
        // What was on its way says the state before.
        self.collect(self.moment())?;
        let heard = self.find(period * 2 + self.silence(), |frame| frame.id() == id)?;
        match heard {
            Some(Passed { frame, .. }) => Ok(frame.octets().first().map(|octet| octet & 0x7F)),
            None => broken(format!("no heartbeat within {} ms", (period * 2).as_millis())),
        }
    }

    /// Lets the state be seen: by guarding, else by a heartbeat that is set for this row.
    pub(super) fn show_state(&mut self) -> Course {
        let seldom = |period: Duration| period > SELDOM && self.setup.write;
        if self.guarded || self.known.heartbeat.is_some_and(|period| !seldom(period)) {
            return Ok(());
        }
        self.may_write()?;
        if !self.has(0x1017, 0)? {
            return inapplicable("it answers no guarding request and has no 1017h: its state cannot be seen");
        }
        let period = 50_u16;
        self.set(0x1017, 0, &period.to_le_bytes())?;
        self.known.heartbeat = Some(Duration::from_millis(period.into()));
        Ok(())
    }

    /// The state must be this.
    pub(super) fn must_be(&mut self, state: NmtState, when: &str) -> Course {
        match self.state()? {
            Some(octet) if octet == state.octet() => Ok(()),
            Some(octet) => {
                broken(format!("{when} its state is {octet:02X}h, expected {:02X}h ({state})", state.octet()))
            }
            None if self.guarded => {
                self.alive()?;
                broken(format!("{when} a guarding request is not answered"))
            }
            None => inapplicable("its state cannot be seen"),
        }
    }

    /// The node answers an SDO in PRE-OPERATIONAL, or it has died.
    pub(super) fn alive(&mut self) -> Course {
        for _ in 0..PROBES {
            if self.exchange([0x40, 0x00, 0x10, 0, 0, 0, 0, 0])?.is_some() {
                return Ok(());
            }
            self.nmt(&[0x80, self.node().number()])?;
            self.collect(self.silence())?;
        }
        Err(Halt::Over(Ending::Died { during: "" }))
    }

    /// Sends a request to the SDO server, and waits for what it answers.
    pub(super) fn exchange(&mut self, request: [u8; 8]) -> Course<Option<[u8; 8]>> {
        self.drain_until(self.asked.saturating_add(self.pause))?;
        let id = self.id(cob_id::SDO_SERVER);
        let sent = self.wire.now();
        self.asked = sent;
        self.send(self.id(cob_id::SDO_CLIENT), &request)?;
        let answer = self.find(PATIENCE, |frame| frame.id() == id && !frame.is_remote())?;
        let Some(Passed { at, frame, .. }) = answer else { return Ok(None) };
        let after = at.saturating_since(sent);
        // One that was held up by something else is forgotten in time.
        self.longest = after.max(self.longest - self.longest / FORGETS);
        if after > LATE {
            self.note("N-O20", &format!("an SDO is answered after {} ms", after.as_millis()));
        }
        match <[u8; 8]>::try_from(frame.octets()) {
            Ok(octets) => Ok(Some(octets)),
            Err(_) => broken(format!("an SDO answer of {} octets, expected 8", frame.octets().len())),
        }
    }

    /// The answer that must come.
    pub(super) fn asked(&mut self, request: [u8; 8], what: &str) -> Course<[u8; 8]> {
        if let Some(answer) = self.exchange(request)? {
            return Ok(answer);
        }
        self.alive()?;
        broken(format!("{what} is not answered within {} s", PATIENCE.as_secs()))
    }

    /// Writes an entry that is written back when the row is over.
    pub(super) fn try_set(&mut self, index: u16, sub: u8, octets: &[u8]) -> Course<Result<(), u32>> {
        self.may_write()?;
        let at = Address::new(index, sub);
        let before = self.upload(at)?;
        let done = self.download(at, octets)?;
        if let (Ok(before), Ok(())) = (before, done) {
            self.written.push((at, before));
        }
        Ok(done)
    }

    /// The same for an entry that a row writes again and again: what it held first is written back.
    pub(super) fn put(&mut self, at: Address, octets: &[u8]) -> Course<Result<(), u32>> {
        if self.is_written(at) {
            self.download(at, octets)
        } else {
            self.try_set(at.index.0, at.sub.0, octets)
        }
    }

    /// Whether a row has written an entry and not written it back yet.
    pub(super) fn is_written(&self, at: Address) -> bool {
        self.written.iter().any(|(written, _)| *written == at)
    }

    /// As [`try_set`](Self::try_set), where it must be taken.
    pub(super) fn set(&mut self, index: u16, sub: u8, octets: &[u8]) -> Course {
        match self.try_set(index, sub, octets)? {
            Ok(()) => Ok(()),
            Err(code) => {
                let at = Address::new(index, sub);
                broken(format!("{at} = {} is refused: {}", hex(octets), super::sdo::refused(code)))
            }
        }
    }

    /// Writes back what rows have written.
    fn write_back(&mut self) -> Course {
        while let Some((at, before)) = self.written.pop() {
            if at == Address::new(0x1017, 0) {
                self.known.heartbeat = Known::heartbeat_of(&before);
            }
            if let Err(code) = self.download(at, &before)? {
                self.written.clear();
                let why = super::sdo::refused(code);
                return broken(format!("{at} cannot be given its former value {}: {why}", hex(&before)));
            }
        }
        Ok(())
    }

    /// What was written may stay: a row has written it back itself, or a reset has.
    pub(super) fn forget_written(&mut self) {
        self.written.clear();
        self.known.heartbeat = self.known.own_heartbeat;
    }

    fn shown_of(&self, passed: &[Passed]) -> Vec<Telegram> {
        let mut network = Network::default();
        let node = self.node().number();
        let show = |passed: &Passed| {
            let Passed { at, ours, frame } = passed;
            let number = frame.id().number();
            let own = u8::try_from(number & 0x7F).unwrap_or_default();
            let station = fdl::Address::from_octet(if own == 0 { node } else { own });
            Telegram {
                at: *at,
                side: if *ours { Side::Master } else { Side::Station(Some(station)) },
                from: None,
                to: None,
                hex: format!("{number:03X}#{}", hex(frame.octets()).replace(' ', "")),
                explained: network.frame(frame).line(),
                is_whole: true,
            }
        };
        passed.iter().map(show).collect()
    }
}

impl Table for Tester {
    const SUBJECT: &'static str = "node";

    fn groups() -> Vec<Group<Self>> {
        rows::groups()
    }
}

impl Trial for Tester {
    fn now(&self) -> Instant {
        self.wire.now()
    }

    fn take_shown(&mut self) -> Vec<Telegram> {
        let passed = self.wire.take_passed();
        self.shown_of(passed.get(passed.len().saturating_sub(SHOWN)..).unwrap_or_default())
    }

    fn forget_shown(&mut self) {
        self.wire.take_passed();
    }

    fn begin(&mut self) -> Course {
        let read = [0x40, 0x00, 0x10, 0, 0, 0, 0, 0];
        // It may be stopped, and one whose boot-up nobody has acknowledged may be bus off.
        self.collect(self.silence())?;
        for _ in 0..PROBES {
            self.nmt(&[0x80, self.node().number()])?;
            self.collect(self.silence())?;
            if self.exchange(read)?.is_some() {
                self.learn()?;
                self.known.own_heartbeat = self.known.heartbeat;
                // A heartbeat would be taken for an answer.
                self.guarded = self.known.heartbeat.is_none() && self.guard()?.is_some();
                return Ok(());
            }
        }
        Err(Halt::Over(Ending::NoDevice))
    }

    /// To PRE-OPERATIONAL with every value as it was.
    fn settle(&mut self) -> Course {
        self.enter(NmtState::PreOperational)?;
        self.drain()?;
        let back = self.write_back();
        if core::mem::take(&mut self.dirty) || back.is_err() {
            // That a node has no boot-up is the failure of the row that has seen it first.
            let is_known = self.known.boots_silently;
            match self.reset_by(0x81, "reset node") {
                Err(Halt::Broken { .. }) if is_known => {}
                reset => reset?,
            }
        }
        self.alive()?;
        back
    }

    fn calm(&mut self) -> Course {
        self.collect(self.silence() * 5).map(drop)
    }

    fn must_end(&self) -> Option<Ending> {
        self.wire.must_end()
    }

    fn noted(&mut self, id: &str) -> Option<(String, Vec<Telegram>)> {
        self.noted.get(id).cloned()
    }

    fn never_exchanged(&self) -> Option<String> {
        None
    }

    fn soak(&self) -> Option<Soak> {
        self.setup.soak
    }

    fn words(&self) -> Vec<(&'static str, String)> {
        let mut node = self.node().to_string();
        if let Some(eds) = &self.setup.eds {
            node.push_str(&format!(",eds={}", eds.device.product));
        }
        let yes = |is: bool| if is { "yes" } else { "no" }.to_owned();
        vec![
            ("node", node),
            ("write", yes(self.setup.write)),
            ("moves_allowed", yes(self.setup.moves_allowed)),
            ("quick", yes(self.setup.quick)),
        ]
    }
}
