//! Inputs of a node that move by themselves.

use super::StoredNode;
use crate::can_bus::canopen::{Address, Value, dictionary};
use crate::devices::CanopenDevice;
use crate::face::surroundings::Level;
use crate::host::ValueBoard;
use crate::process::{Elsewhere, Signal, Source};
use crate::time::Instant;

/// Where a signal of a node reads.
#[derive(Clone, Debug, PartialEq)]
pub enum NodeOrigin {
    /// An object of the same node.
    Object(Address),
    /// A value of another device.
    Elsewhere(Elsewhere),
}

/// An input of a node and the signal that it shows.
#[derive(Clone, Debug)]
pub struct NodeSignal {
    input: String,
    is_switch: bool,
    signal: Signal<NodeOrigin>,
    /// `None`: nothing changes any more.
    due: Option<Instant>,
}

impl NodeSignal {
    /// The input of that name shows `signal`; of a switch 0 is off.
    pub(crate) const fn new(input: String, is_switch: bool, signal: Signal<NodeOrigin>) -> Self {
        Self { input, is_switch, signal, due: Some(Instant::ZERO) }
    }

    /// Its input.
    pub(crate) fn input(&self) -> &str {
        &self.input
    }

    /// The values of other devices that it reads.
    pub(crate) fn elsewhere(&self) -> impl Iterator<Item = &Elsewhere> {
        self.signal.source().read_values().iter().filter_map(|origin| match origin {
            NodeOrigin::Elsewhere(elsewhere) => Some(elsewhere),
            NodeOrigin::Object(_) => None,
        })
    }

    pub(super) const fn due(&self) -> Option<Instant> {
        self.due
    }

    /// Sets the input if it is time.
    fn step(&mut self, now: Instant, device: &mut dyn CanopenDevice, board: Option<&ValueBoard>) {
        if self.due.is_none_or(|due| now < due) {
            return;
        }
        let read = |origin: &NodeOrigin| match origin {
            NodeOrigin::Object(at) => number(device, *at),
            NodeOrigin::Elsewhere(elsewhere) => board?.value(elsewhere),
        };
        let (value, next) = self.signal.value(now, &read);
        // Nobody tells of a change of what it reads.
        let looks = !self.signal.source().read_values().is_empty();
        let look = looks.then(|| now.saturating_add(Source::<NodeOrigin>::tick()));
        self.due = Instant::first_of(next, look);
        let level = if self.is_switch { Level::Switch(value != 0.0) } else { Level::Number(value) };
        device.act(now, &mut |description| description.set_input(now, &self.input, level));
    }
}

impl StoredNode {
    /// Has an input show its signal from now on.
    pub fn connect(&mut self, now: Instant, signal: NodeSignal) {
        if let Some(board) = &self.board {
            signal.elsewhere().for_each(|elsewhere| board.follow(elsewhere));
        }
        self.signals.push(signal);
        self.move_inputs(now);
    }

    /// Whoever its signals follow shows its values there.
    pub(super) fn follow_on(&self, board: &ValueBoard) {
        let elsewhere = self.signals.iter().flat_map(NodeSignal::elsewhere);
        elsewhere.for_each(|elsewhere| board.follow(elsewhere));
    }

    pub(super) fn move_inputs(&mut self, now: Instant) {
        if self.signals.iter().all(|signal| signal.due.is_none_or(|due| now < due)) {
            return;
        }
        let mut signals = core::mem::take(&mut self.signals);
        let board = self.board.clone();
        self.act(now, |device, now| {
            signals.iter_mut().for_each(|signal| signal.step(now, device, board.as_ref()));
        });
        self.signals = signals;
    }
}

/// A number of the dictionary; `None`: there is none, or the device is off.
#[expect(clippy::cast_precision_loss, reason = "of a number of 64 bits the 53 highest count")]
pub(crate) fn number(device: &dyn CanopenDevice, at: Address) -> Option<f64> {
    let app = device.application();
    let entry = dictionary::entry(app.objects(), at).ok()?;
    let read = device.node().read_with(at, app, |octets| {
        let value = entry.data.decode(octets);
        Ok(value.and_then(|value| match value {
            Value::Real32(number) => Some(number.into()),
            Value::Real64(number) => Some(number),
            Value::U64(number) => Some(number as f64),
            Value::Boolean(_)
            | Value::I8(_)
            | Value::I16(_)
            | Value::I32(_)
            | Value::U8(_)
            | Value::U16(_)
            | Value::U32(_)
            | Value::I64(_)
            | Value::Wide { .. }
            | Value::Octets(_) => value.number().map(|number| number as f64),
        }))
    });
    read.ok().flatten()
}
