//! A CANopen device on a bus, and the file its EEPROM is kept in.

use super::CanParticipant;
use super::node_counters::NodeCounters;
use super::node_signals::NodeSignal;
use super::product::Product;
use crate::can_bus::can::{BitRate, ErrorState, Frame};
use crate::can_bus::canopen;
use crate::can_bus::canopen::faults::{Action, FaultInjector, Kind, TooMany, When};
use crate::can_bus::canopen::nmt::Command;
use crate::can_bus::canopen::node::storage::{Eeprom, Generation, NotStored, StoreRequest};
use crate::can_bus::canopen::{NmtState, NodeId};
use crate::devices::{CanopenDevice, CanopenEvent};
use crate::face::{DeviceEvent as _, EventKind, Why};
use crate::host::list::Choices;
use crate::host::repeats::{Told, cause};
use crate::host::state_dir::{Images, Newest, StateDir, StateDirError};
use crate::host::{Stored, ValueBoard};
use crate::time::Instant;

/// Room for the image of any device.
const LONGEST_IMAGE: usize = u16::MAX as usize;

/// A device on a [`Bus`](super::Bus) whose EEPROM may be kept in a [`StateDir`].
///
/// It is switched on when it is made, and off when it is dropped. With a file, an SDO that stores something is
/// answered when what it stores is on the disk.
pub struct StoredNode {
    stored: Stored<Unit>,
    error_state: ErrorState,
    /// Faults on purpose between the device and the bus.
    injector: Option<Box<FaultInjector>>,
    counters: NodeCounters,
    repeats: Told<CanopenEvent>,
    /// Where its values are shown that somebody follows.
    pub(super) board: Option<ValueBoard>,
    /// What moves its inputs.
    pub(super) signals: Vec<NodeSignal>,
}

/// The device with what it hands over.
struct Unit {
    device: Box<dyn CanopenDevice>,
    buffer: Vec<u8>,
}

impl StoredNode {
    /// A device whose EEPROM lives as long as it, switched on at `now`.
    pub fn new(mut device: Box<dyn CanopenDevice>, now: Instant) -> Self {
        device.power_on(now);
        let mut stored = Stored::from(Unit { device, buffer: Vec::new() });
        stored.act(now, |_| {});
        Self::over(stored)
    }

    fn over(stored: Stored<Unit>) -> Self {
        Self {
            stored,
            error_state: ErrorState::Active,
            injector: None,
            counters: NodeCounters::default(),
            repeats: Told::default(),
            board: None,
            signals: Vec::new(),
        }
    }

    /// Shows its values from now on, if somebody follows them.
    pub(super) fn show_on(&mut self, board: ValueBoard) {
        self.follow_on(&board);
        self.board = Some(board);
    }

    /// What it has heard and sent since it was made.
    pub(crate) const fn counters(&self) -> &NodeCounters {
        &self.counters
    }

    /// The node number in force.
    pub fn node_id(&self) -> NodeId {
        self.stored.unit().device.node_id()
    }

    /// The device, whichever it is.
    pub fn as_device(&self) -> &dyn CanopenDevice {
        &*self.stored.unit().device
    }

    /// Gives a device whose rate is fixed another one, as if it had been stored before its start.
    pub fn set_rate(&mut self, now: Instant, rate: BitRate) {
        let bits = rate.bits_per_second();
        if self.as_device().bits_per_second().is_some_and(|own| own != bits) {
            self.act(now, |device, _| device.set_rate(bits));
        }
    }

    /// Does something to the device, whichever it is.
    pub fn act<R>(&mut self, now: Instant, act: impl FnOnce(&mut dyn CanopenDevice, Instant) -> R) -> R {
        self.stored.act(now, |unit| act(&mut *unit.device, now))
    }

    /// From now on what it sends has this fault, too. `number` is for [`remove_fault`](Self::remove_fault).
    ///
    /// # Errors
    /// [`TooMany`].
    pub(crate) fn add_fault(
        &mut self,
        now: Instant,
        number: u32,
        kind: Kind,
        when: When,
    ) -> Result<(), TooMany> {
        self.injector.get_or_insert_default().add(now, number, kind, when)
    }

    /// Ends the fault of that number.
    pub(crate) fn remove_fault(&mut self, number: u32) {
        if let Some(injector) = &mut self.injector {
            injector.remove(number);
        }
    }

    /// How often the fault of that number was injected.
    pub(crate) fn injected(&self, number: u32) -> u32 {
        self.injector.as_ref().map_or(0, |injector| injector.injected(number))
    }

    /// Tells everything again.
    #[cfg(test)]
    pub(crate) fn forget_told(&mut self) {
        self.repeats = Told::default();
    }

    /// What keeps its drive from moving now; `None`: it has no drive.
    pub fn why(&self) -> Option<&dyn Why> {
        self.stored.unit().device.description().why()
    }

    /// Carries out what faults ask for.
    fn follow_faults(&mut self, now: Instant) {
        let Self { stored, injector: Some(injector), .. } = self else { return };
        stored.act(now, |unit| {
            while let Some(action) = injector.poll_action(now) {
                unit.follow(now, action);
            }
        });
    }

    /// The next frame to send, with what faults do to it.
    fn next_frame(&mut self, now: Instant) -> Option<Frame> {
        let device = &mut self.stored.unit_mut().device;
        let Some(injector) = &mut self.injector else { return device.poll_transmit(now) };
        while let Some(frame) = device.poll_transmit(now) {
            injector.handle_frame(now, frame, device.node());
        }
        let frame = injector.poll_transmit();
        self.follow_faults(now);
        frame
    }
}

impl Drop for StoredNode {
    fn drop(&mut self) {
        if let Some(board) = &self.board {
            board.withdraw(self.node_id().number());
        }
    }
}

impl Unit {
    fn follow(&mut self, now: Instant, action: Action) {
        let device = &mut self.device;
        match action {
            Action::Off => device.power_off(now),
            Action::On if device.is_on() => {}
            Action::On => device.power_on(now),
            // As if it had heard the command.
            Action::LeaveOperational => {
                let command = Command::Enter(NmtState::PreOperational).frame(Some(device.node_id()));
                device.handle_frame(now, &command);
            }
        }
    }
}

impl StateDir {
    /// The device of this product and node number, switched on at `now` as its newest image says; without an image as the
    /// factory made it. Its file is named by the product, by `node` and as that of a twin, and stays its own whatever number
    /// the bus gives the device, until it is dropped.
    ///
    /// # Errors
    /// [`StateDirError::Owned`], [`StateDirError::File`], [`StateDirError::Refused`]; the file is as before.
    pub fn load_node(
        &self,
        product: &Product,
        node: NodeId,
        choices: &Choices,
        now: Instant,
    ) -> Result<StoredNode, StateDirError> {
        let mut device = product.make(node, choices, Eeprom::Host, now);
        let twin = if choices.flag("twin") { "-twin" } else { "" };
        let name = format!("{}-node-{:03}{twin}", device.application().product(), node.number());
        let (file, newest) = self.file::<Generation>(&name, LONGEST_IMAGE)?;
        match newest {
            Some(Newest { octets, safe }) => {
                tracing::info!("EEPROM from {}", file.path().display());
                device
                    .recall(now, &octets)
                    .map_err(|cause| StateDirError::Refused { path: file.path(), cause: Box::new(cause) })?;
                if !safe {
                    device.offer_image();
                }
            }
            None => tracing::info!("EEPROM will be kept in {}", file.path().display()),
        }
        device.power_on(now);
        let unit = Unit { device, buffer: vec![0; LONGEST_IMAGE] };
        Ok(StoredNode::over(Stored::in_file(unit, file, now)))
    }
}

impl Images for Unit {
    type Generation = Generation;

    fn poll_image(&mut self) -> Option<(Generation, Vec<u8>)> {
        match self.device.poll_image(&mut self.buffer) {
            Ok(request) => request.map(|StoreRequest { generation, octets }| (generation, octets.to_vec())),
            Err(error) => {
                tracing::error!("node {}: its EEPROM cannot be kept: {error}", self.device.node_id());
                None
            }
        }
    }

    fn handle_stored(&mut self, now: Instant, generation: Generation, stored: bool) {
        self.device.handle_stored(now, generation, if stored { Ok(()) } else { Err(NotStored) });
    }

    fn switch_off(&mut self, now: Instant) {
        self.device.power_off(now);
    }
}

/// How often what a master can cause with each frame is told before it is counted; `None`: it is told each time.
fn told_each_time(event: &CanopenEvent) -> Option<u32> {
    let refused = |kind| matches!(kind, EventKind::CommandRefused | EventKind::JobRefused | EventKind::Hint);
    match event {
        CanopenEvent::Node(
            canopen::Event::NmtIgnored { .. }
            | canopen::Event::NoEffect(_)
            | canopen::Event::SdoRefused(_)
            | canopen::Event::SdoAbortedByClient { .. }
            | canopen::Event::RpdoLength { .. }
            | canopen::Event::RpdoRefused { .. }
            | canopen::Event::LssRefused(_)
            | canopen::Event::SegmentsMissed { .. }
            | canopen::Event::FramesLost { .. },
        ) => Some(1),
        // Changes belong between others; only a circle of them is counted.
        CanopenEvent::Node(canopen::Event::BootUp { .. } | canopen::Event::State { .. }) => Some(3),
        CanopenEvent::Device(event) if refused(event.kind()) => Some(1),
        CanopenEvent::Node(_)
        | CanopenEvent::Device(_)
        | CanopenEvent::Repeated { .. }
        | CanopenEvent::DeviceRepeated { .. } => None,
    }
}

/// Whether two events say the same; what was lost is counted by the event itself.
fn is_same(one: &CanopenEvent, other: &CanopenEvent) -> bool {
    let lost = |event: &CanopenEvent| matches!(event, CanopenEvent::Node(canopen::Event::FramesLost { .. }));
    one == other || lost(one) && lost(other)
}

impl CanParticipant for StoredNode {
    type Event = CanopenEvent;

    fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        let Self { stored, counters, .. } = self;
        stored.act(now, |unit| {
            counters.hear(unit.device.node(), frame);
            unit.device.handle_frame(now, frame);
        });
    }

    fn handle_timeout(&mut self, now: Instant) {
        let Self { stored, injector, .. } = self;
        stored.act(now, |unit| {
            unit.device.handle_timeout(now);
            if let Some(injector) = injector {
                injector.handle_timeout(now, unit.device.node());
            }
        });
        self.follow_faults(now);
        self.move_inputs(now);
        if let Some(board) = &self.board {
            let device = &self.stored.unit().device;
            board.show(device.node_id().number(), &|| Some(device.description()));
        }
    }

    fn set_error_state(&mut self, now: Instant, state: ErrorState) {
        let before = core::mem::replace(&mut self.error_state, state);
        self.counters.enter(before, state);
        self.stored.act(now, |unit| unit.device.handle_error_state(now, before, state));
    }

    fn bits_per_second(&self) -> Option<u32> {
        self.stored.unit().device.bits_per_second()
    }

    fn take_back(&mut self, frame: Frame) {
        self.stored.unit_mut().device.parts().0.take_back(frame);
    }

    fn poll_transmit(&mut self, now: Instant) -> Option<Frame> {
        let frame = self.next_frame(now)?;
        self.counters.send(self.stored.unit().device.node(), &frame);
        Some(frame)
    }

    fn poll_event(&mut self) -> Option<CanopenEvent> {
        let now = self.stored.now();
        while let Some(event) = self.stored.unit_mut().device.poll_event() {
            self.counters.tell(&event);
            let each = told_each_time(&event);
            if each
                .is_none_or(|each| self.repeats.is_new(now, &event, is_same, each, |event| (0, cause(event))))
            {
                return Some(event);
            }
        }
        let (event, again) = self.repeats.poll(now)?;
        Some(match event {
            CanopenEvent::Node(event) => CanopenEvent::Repeated { event, again },
            CanopenEvent::Device(event) => CanopenEvent::DeviceRepeated { event, again },
            counted @ (CanopenEvent::Repeated { .. } | CanopenEvent::DeviceRepeated { .. }) => counted,
        })
    }

    fn poll_timeout(&self) -> Option<Instant> {
        let device = self.stored.poll_timeout(self.stored.unit().device.poll_timeout());
        let fault = self.injector.as_ref().and_then(|injector| injector.poll_timeout());
        let signals = self.signals.iter().filter_map(NodeSignal::due).min();
        let own = Instant::first_of(signals, self.repeats.poll_timeout());
        Instant::first_of(Instant::first_of(device, fault), own)
    }
}
