//! A station from a GSD on a bus: its process image, what moves its inputs, what its diagnosis reports.
//!
//! ```text
//! outputs ──▶ processes ──▶ inputs ──▶ forced bits over them ──▶ slave
//! ```

use std::collections::{BTreeMap, VecDeque};

use super::fault::{Condition, Switch};
use super::gsd_description::ShownPrm;
use super::refusals::Refusals;
use super::reported::Reported;
use super::state_dir::Images;
use super::station_file::{Kept, KeptImage};
use super::value_board::ValueBoard;
use super::{Appearance, ByHand, Participant, Startup, StateDir, StateDirError, StationKind, Stored};
use crate::devices::StationEvent;
use crate::face::Description;
use crate::gsd::{Gsd, ModuleState, Placed, Raised, Station};
use crate::image::Generation;
use crate::image::storage::Outcome;
use crate::process::{Elsewhere, Image, Input, Point, Process, Slot, ValueError};
use crate::profibus::dp;
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::profibus::fdl::{Address, Rates, Telegram};
use crate::time::{BaudRate, Instant};

mod acyclic;
mod acyclic_face;
mod outputs;
mod records;
#[cfg(feature = "parameters")]
mod records_file;
mod reporting;
mod storing;
mod timed_alarms;

use acyclic::Acyclic;
pub use outputs::OutputsAre;
pub use records::{StationRecord, StationRecords};
pub(crate) use timed_alarms::TimedAlarm;
use timed_alarms::TimedAlarms;

/// The most inputs of a slave.
const MAX_IO_LEN: usize = dp::chk_cfg::MAX_IO_LEN;

/// A station that a GSD describes, with everything that a test bench does to it.
pub struct GsdStation {
    station: dp::Station<Station>,
    /// Its services of DP-V1, if its file promises any.
    acyclic: Option<Box<Acyclic>>,
    /// The modules of the configuration in force, and the same for processes.
    layout: Vec<Placed>,
    slots: Vec<Slot>,
    /// The inputs that processes write.
    inputs: [u8; MAX_IO_LEN],
    /// The bits that are forced, and what they are.
    mask: [u8; MAX_IO_LEN],
    forced: [u8; MAX_IO_LEN],
    processes: Vec<(Box<dyn Process>, Option<Instant>)>,
    /// Inputs with a signal of their own: they show it behind what the processes write.
    signals: Vec<(Input, Option<Instant>)>,
    /// `output_updates` of the slave when the processes ran last.
    seen: Option<u32>,
    outputs_are: OutputsAre,
    /// The parameters of the Set_Prm in force.
    prm: Vec<ShownPrm>,
    reported: Reported,
    /// The slots whose module is not that of the configuration.
    unlike: BTreeMap<u16, ModuleState>,
    /// The inputs of the others.
    live: [u8; MAX_IO_LEN],
    /// When the time line begins, and when something on it begins or ends next.
    began: Instant,
    next_report: Option<Instant>,
    /// The last call.
    now: Instant,
    /// How often something was raised.
    raises: u16,
    by_hand: VecDeque<ByHand>,
    refusals: Refusals,
    /// The names that a module may have, with their slots, as they were told.
    open: BTreeMap<String, Vec<String>>,
    board: Option<ValueBoard>,
    watched: Vec<(Point, Condition, Switch)>,
    image: Option<KeptImage>,
    timed_alarms: TimedAlarms,
}

impl core::fmt::Debug for GsdStation {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("GsdStation").field("address", &self.station.address()).finish_non_exhaustive()
    }
}

impl GsdStation {
    /// A station that has just been switched on. The words of what it refuses go into `refusals`.
    pub fn new(address: Address, baud: BaudRate, station: Station, refusals: Refusals) -> Self {
        let description = station.description();
        let acyclic = Acyclic::of(station.gsd(), StationRecords::default());
        let station = dp::Station::new(address, baud, None, description, station);
        let mut this = Self {
            station,
            acyclic,
            layout: Vec::new(),
            slots: Vec::new(),
            inputs: [0; MAX_IO_LEN],
            mask: [0; MAX_IO_LEN],
            forced: [0; MAX_IO_LEN],
            processes: Vec::new(),
            signals: Vec::new(),
            seen: None,
            outputs_are: OutputsAre::Unowned,
            prm: Vec::new(),
            reported: Reported::default(),
            unlike: BTreeMap::new(),
            live: [0xFF; MAX_IO_LEN],
            began: Instant::ZERO,
            next_report: None,
            now: Instant::ZERO,
            raises: 0,
            by_hand: VecDeque::new(),
            refusals,
            open: BTreeMap::new(),
            board: None,
            watched: Vec::new(),
            image: None,
            timed_alarms: TimedAlarms::default(),
        };
        this.lay_out(false);
        this
    }

    /// The same station, whose outputs others can follow and that can follow those of others on the same board.
    #[must_use]
    pub fn on_board(mut self, board: ValueBoard) -> Self {
        self.board = Some(board);
        self
    }

    /// The same station at the address that Set_Slave_Add gave it before it was switched off, with the records that were
    /// written; its file in `state` keeps them from now on. A master that writes a record is answered when the disk has it, one
    /// that sets the address before.
    ///
    /// # Errors
    /// [`StateDirError::Owned`], [`StateDirError::File`], [`StateDirError::Refused`]; the file is as before.
    pub(crate) fn kept_in(mut self, state: &StateDir, now: Instant) -> Result<Stored<Self>, StateDirError> {
        let ident = self.slave().description().ident;
        let (file, image, kept) = KeptImage::open(state, "gsd", ident, self.station.address())?;
        if let Some(acyclic) = &mut self.acyclic {
            acyclic.records.storing.on = true;
        }
        if let Some(Kept { address, rem_slave_data, records, .. }) = kept {
            self.station.recall(address, &rem_slave_data);
            if let Some(acyclic) = &mut self.acyclic {
                acyclic.records.recall(records);
            }
        }
        self.image = Some(image);
        Ok(Stored::in_file(self, file, now))
    }

    /// What it keeps, `waits`: somebody waits until it is safe.
    fn keep(&mut self, waits: bool) {
        let Self { station, image, acyclic, .. } = self;
        if let Some(image) = image {
            let kept = Kept {
                address: station.stored_address(),
                rem_slave_data: station.slave().rem_slave_data().to_vec(),
                values: Vec::new(),
                records: acyclic.as_ref().map(|acyclic| acyclic.records.kept()).unwrap_or_default(),
            };
            image.keep(&kept, waits);
        }
    }

    /// Connects a machine. Several run in the order in which they were connected, each over the inputs of those before.
    pub fn connect(&mut self, process: impl Process + 'static) {
        self.processes.push((Box::new(process), Some(Instant::ZERO)));
        self.seen = None;
    }

    /// Has an input show its signal from now on, in place of another one that has the same bits.
    pub(crate) fn connect_input(&mut self, input: Input) {
        self.disconnect_input(input.point());
        if let Some(board) = &self.board {
            input.elsewhere().for_each(|elsewhere| board.follow(elsewhere));
        }
        self.signals.push((input, Some(Instant::ZERO)));
        self.seen = None;
    }

    /// Has an input keep its last value. Whether a signal moved it.
    pub(crate) fn disconnect_input(&mut self, point: Point) -> bool {
        let own = point.kind.places(point.offset);
        let before = self.signals.len();
        self.signals.retain(|(input, _)| {
            let Point { slot, offset, kind } = input.point();
            let places = kind.places(offset);
            slot != point.slot || places.end <= own.start || own.end <= places.start
        });
        before != self.signals.len()
    }

    /// Has `switch` be on while a condition on an input holds, forced inputs as they are forced. It is off while there is
    /// no such input.
    pub(crate) fn watch(&mut self, point: Point, condition: Condition, switch: Switch) {
        self.watched.retain(|(_, _, switch)| !switch.is_abandoned());
        self.watched.push((point, condition, switch));
        self.offer();
    }

    /// Its file.
    pub const fn gsd(&self) -> &Gsd {
        self.station.slave().application().gsd()
    }

    /// Its slave: state, owner, octets, diagnosis.
    pub const fn slave(&self) -> &dp::Slave<Station> {
        self.station.slave()
    }

    /// The modules of the configuration in force, else of the one that Get_Cfg reports.
    pub fn layout(&self) -> &[Placed] {
        &self.layout
    }

    /// The parameters of the Set_Prm in force, by name and text.
    pub(super) fn prm(&self) -> &[ShownPrm] {
        let is_in_force = self.slave().state() == dp::State::DataExch;
        if is_in_force { &self.prm } else { &[] }
    }

    /// Why the outputs are what they are.
    pub const fn outputs_are(&self) -> OutputsAre {
        self.outputs_are
    }

    /// The inputs of a slot, forced ones as they are forced; empty if there is no such slot.
    pub(crate) fn inputs(&self, slot: &Slot) -> Vec<u8> {
        slot.inputs.clone().map(|at| self.input_octet(at)).collect()
    }

    /// Which bits of the inputs of a slot are forced.
    pub fn forced(&self, slot: &Slot) -> &[u8] {
        self.mask.get(slot.inputs.clone()).unwrap_or_default()
    }

    /// The outputs of a slot: zeros in the safe state.
    pub fn outputs(&self, slot: &Slot) -> &[u8] {
        self.slave().outputs().get(slot.outputs.clone()).unwrap_or_default()
    }

    /// Has an input keep this value, whatever its process does, until [`GsdStation::release`].
    ///
    /// # Errors
    /// [`ValueError`] if the slot does not have it, or the value does not fit. Nothing is changed then.
    pub fn force(&mut self, point: Point, value: f64) -> Result<(), ValueError> {
        let mut forced = self.forced;
        self.write(&mut forced, point, |octets| point.kind.write(octets, point.offset, value))?;
        let mut mask = self.mask;
        self.write(&mut mask, point, |octets| cover(octets, point, true))?;
        (self.forced, self.mask) = (forced, mask);
        self.offer();
        self.tell(ByHand::Forced { point, value });
        Ok(())
    }

    /// Gives an input back to its process.
    ///
    /// # Errors
    /// [`ValueError`] if the slot does not have it.
    pub fn release(&mut self, point: Point) -> Result<(), ValueError> {
        let mut mask = self.mask;
        self.write(&mut mask, point, |octets| cover(octets, point, false))?;
        self.mask = mask;
        self.offer();
        self.tell(ByHand::Released { point });
        Ok(())
    }

    /// Gives all inputs back to their processes.
    pub fn release_all(&mut self) {
        if self.mask.iter().any(|octet| *octet != 0) {
            self.tell(ByHand::AllReleased);
        }
        self.mask = [0; MAX_IO_LEN];
        self.offer();
    }

    /// The oldest thing that was done by hand and is not told yet.
    pub(super) fn poll_by_hand(&mut self) -> Option<ByHand> {
        self.by_hand.pop_front()
    }

    /// Kept until the bus takes it; of more than a few the oldest are lost.
    fn tell(&mut self, what: ByHand) {
        const KEPT: usize = 64;
        if self.by_hand.len() >= KEPT {
            self.by_hand.pop_front();
        }
        self.by_hand.push_back(what);
    }

    fn write(
        &self,
        octets: &mut [u8; MAX_IO_LEN],
        point: Point,
        act: impl FnOnce(&mut [u8]) -> Result<(), ValueError>,
    ) -> Result<(), ValueError> {
        let slot = self.slots.iter().find(|slot| slot.number == point.slot);
        act(slot.and_then(|slot| octets.get_mut(slot.inputs.clone())).unwrap_or_default())
    }

    fn input_octet(&self, at: usize) -> u8 {
        let of = |octets: &[u8; MAX_IO_LEN]| octets.get(at).copied().unwrap_or_default();
        ((of(&self.inputs) & !of(&self.mask)) | (of(&self.forced) & of(&self.mask))) & of(&self.live)
    }

    /// The modules are those of the configuration that the slave reports now. What was forced in other octets means
    /// nothing any more.
    fn lay_out(&mut self, parameterised: bool) {
        let slave = self.slave();
        let user_prm = parameterised.then(|| slave.user_prm());
        let layout = slave.application().layout(slave.configuration(), user_prm);
        self.seen = None;
        if layout == self.layout {
            return;
        }
        self.layout = layout;
        let Self { acyclic, station, layout, .. } = self;
        if let Some(acyclic) = acyclic {
            acyclic.lay_out(station.slave().application().gsd(), layout);
        }
        self.slots = self.layout.iter().map(|placed| placed.slot.clone()).collect();
        (self.inputs, self.mask) = ([0; MAX_IO_LEN], [0; MAX_IO_LEN]);
        let processes = self.processes.iter_mut().map(|(_, due)| due);
        for due in processes.chain(self.signals.iter_mut().map(|(_, due)| due)) {
            *due = Some(Instant::ZERO);
        }
        // Slots that are gone have no diagnosis.
        if self.reported.by_hand.blocks(self.gsd(), &self.layout).is_err() {
            self.reported.by_hand = Raised::default();
        }
        self.report(self.now);
    }

    /// Tells the modules that the master's octets leave open, once for each of its projects.
    fn tell_open(&mut self) {
        let mut open = BTreeMap::<String, Vec<String>>::new();
        for placed in self.layout.iter().filter(|placed| placed.names(self.gsd()).len() > 1) {
            open.entry(placed.name(self.gsd())).or_default().push(placed.slot.number.to_string());
        }
        if open != self.open {
            for (names, slots) in &open {
                let (s, slots) = (if slots.len() == 1 { "" } else { "s" }, slots.join(", "));
                let address = self.station.address();
                tracing::info!(
                    "station {address}: slot{s} {slots}: the module is {names}: Set_Prm and Chk_Cfg do not tell them apart; modules = [...] names it"
                );
            }
        }
        self.open = open;
    }

    /// Runs the processes that are due, and all of them when outputs have come.
    fn run(&mut self, now: Instant) {
        self.now = now;
        if self.next_report.is_some_and(|next| next <= now) {
            self.report(now);
            let (address, words) = (self.station.address(), self.report_words().join(", "));
            let words = if words.is_empty() { "nothing" } else { &words };
            tracing::info!("station {address}: by the time line the diagnosis reports {words}");
        }
        self.raise_timed(now);
        let updates = self.slave().output_updates();
        let news = self.seen != Some(updates);
        if !news && self.due().is_none_or(|due| due > now) {
            return;
        }
        self.seen = Some(updates);
        if let (true, Some(board)) = (news, &self.board) {
            board.publish(self.station.address(), &self.slots, self.station.slave().outputs());
        }
        if self.processes.is_empty() && self.signals.is_empty() {
            return;
        }
        let Self { station, slots, inputs, processes, signals, board, unlike, .. } = self;
        let others = |elsewhere: &Elsewhere| board.as_ref()?.value(elsewhere);
        let processes = processes.iter_mut().map(|(process, due)| (process.as_mut(), due));
        let signals = signals.iter_mut().map(|(input, due)| (input as &mut dyn Process, due));
        for (process, due) in processes.chain(signals) {
            if news || due.is_some_and(|due| due <= now) {
                let mut outputs = [0; MAX_IO_LEN];
                let live = |at: usize| {
                    slots.iter().all(|slot| !slot.outputs.contains(&at) || !unlike.contains_key(&slot.number))
                };
                let outputs = if unlike.is_empty() {
                    station.slave().outputs()
                } else {
                    for (at, (own, sent)) in outputs.iter_mut().zip(station.slave().outputs()).enumerate() {
                        *own = if live(at) { *sent } else { 0 };
                    }
                    &outputs
                };
                let mut image = Image { slots, outputs, inputs: &mut inputs[..], others: &others };
                *due = process.step(now, &mut image);
            }
        }
        self.offer();
    }

    fn due(&self) -> Option<Instant> {
        let signals = self
            .signals
            .iter()
            .filter_map(|(_, due)| *due)
            .chain(self.next_report)
            .chain(self.timed_alarms.next());
        self.processes.iter().filter_map(|(_, due)| *due).chain(signals).min()
    }

    /// Offers the inputs to the slave.
    fn offer(&mut self) {
        let mut inputs = [0; MAX_IO_LEN];
        for (at, octet) in inputs.iter_mut().enumerate() {
            *octet = self.input_octet(at);
        }
        self.station.set_inputs(&inputs);
        for (point, condition, switch) in &self.watched {
            let slot = self.slots.iter().find(|slot| slot.number == point.slot);
            let octets = slot.and_then(|slot| inputs.get(slot.inputs.clone()));
            let value = octets.and_then(|octets| point.kind.read(octets, point.offset));
            switch.set(value.is_some_and(|value| condition.holds(value)));
        }
    }
}

impl Images for GsdStation {
    type Generation = Generation;

    fn poll_image(&mut self) -> Option<(Generation, Vec<u8>)> {
        let due = self.acyclic.as_mut().and_then(|acyclic| acyclic.records.storing.take());
        if let Some(waits) = due {
            self.keep(waits);
        }
        self.image.as_mut()?.poll()
    }

    fn handle_stored(&mut self, _: Instant, generation: Generation, stored: bool) {
        let (Some(image), acyclic) = (&mut self.image, &mut self.acyclic) else { return };
        let outcome = image.report(generation, stored);
        let mut settle = |stored| {
            if let Some(acyclic) = acyclic {
                acyclic.records.settle(stored);
            }
        };
        match outcome {
            Outcome::None => {}
            Outcome::Safe => settle(true),
            Outcome::Undone => {
                settle(false);
                // The file may hold what was refused.
                self.keep(false);
            }
        }
    }
}

impl Drop for GsdStation {
    fn drop(&mut self) {
        // There is no such input any more.
        for (_, _, switch) in &self.watched {
            switch.set(false);
        }
        if let Some(board) = &self.board {
            board.withdraw(self.station.address().number());
        }
    }
}

/// Sets or clears the bits of a value.
fn cover(octets: &mut [u8], point: Point, on: bool) -> Result<(), ValueError> {
    let Point { offset, kind, .. } = point;
    let got = octets.len();
    let needed = offset.saturating_add(kind.octets());
    let field = octets.get_mut(offset..).and_then(|rest| rest.get_mut(..kind.octets()));
    let field = field.ok_or(ValueError::Outside { kind, offset, needed, got })?;
    for (octet, mask) in field.iter_mut().rev().zip(kind.mask().to_le_bytes()) {
        *octet = if on { *octet | mask } else { *octet & !mask };
    }
    Ok(())
}

impl Participant for GsdStation {
    fn address(&self) -> Address {
        self.station.address()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.station.set_baud(baud);
    }

    fn rates(&self) -> Rates {
        self.slave().description().rates
    }

    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        let outcome = self.hear(now, telegram);
        if let Some(event) = outcome.event {
            self.learn(&event);
            news(StationEvent::Dp(event));
        }
        // No event tells that outputs are there again after Fail_Safe or Clear_Data.
        if outcome.exchanged && self.has_outputs_again() {
            self.outputs_are = OutputsAre::Live;
        }
        self.tell_services(news);
        self.run(now);
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        if let Some(event) = self.pass(now) {
            self.learn(&event);
            news(StationEvent::Dp(event));
        }
        self.tell_services(news);
        self.run(now);
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        Participant::poll_transmit(&mut self.station, now, buf, news)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        let of_services = Instant::first_of(self.service_timeout(), self.due());
        let is_due = |acyclic: &Acyclic| acyclic.records.storing.is_due();
        let to_keep = self.acyclic.as_deref().is_some_and(is_due).then_some(self.now);
        let of_services = Instant::first_of(of_services, to_keep);
        Instant::first_of(self.station.poll_timeout(), of_services)
    }

    fn watchdog_on(&self) -> bool {
        self.slave().watchdog_on()
    }

    fn startup(&self) -> Option<Startup> {
        Startup::of_slave(self.slave())
    }

    fn appearance(&self) -> Appearance<'_> {
        let Gsd { vendor, model, .. } = self.gsd();
        Appearance {
            kind: StationKind::GsdStation,
            device: "gsd-station",
            model: model.as_str().into(),
            product: format!("{vendor} {model}").into(),
            ..Appearance::of_slave(self.slave())
        }
    }

    fn description(&self) -> Option<&dyn Description> {
        Some(self)
    }

    fn description_mut(&mut self) -> Option<&mut dyn Description> {
        Some(self)
    }

    fn modules(&self) -> Option<&GsdStation> {
        Some(self)
    }

    fn modules_mut(&mut self) -> Option<&mut GsdStation> {
        Some(self)
    }
}

#[cfg(test)]
mod tests;
