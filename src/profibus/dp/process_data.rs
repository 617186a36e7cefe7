//! The buffers behind Data_Exchange: outputs and inputs, held by Sync and Freeze (`dp-v0.md` 6.3).

use super::chk_cfg::MAX_IO_LEN;
use super::global_control::{GlobalControl, Latch};
use super::{Description, IoLengths, PrmBit, SetPrm};

/// Outputs and inputs of a slave. Each is copied whole, so nobody sees half of one exchange.
#[derive(Clone, Debug)]
pub(super) struct ProcessData {
    lengths: IoLengths,
    sync: Mode,
    freeze: Mode,
    /// What the application sees.
    outputs: Octets,
    /// What Data_Exchange brought while Sync holds the outputs.
    waiting_outputs: Octets,
    /// What the application offers.
    inputs: Octets,
    /// What Freeze holds.
    frozen_inputs: Octets,
    /// Counts what is passed to the application.
    output_updates: u32,
}

impl ProcessData {
    pub(super) const fn new(lengths: IoLengths) -> Self {
        Self {
            lengths,
            sync: Mode::Closed,
            freeze: Mode::Closed,
            outputs: Octets::EMPTY,
            waiting_outputs: Octets::EMPTY,
            inputs: Octets::EMPTY,
            frozen_inputs: Octets::EMPTY,
            output_updates: 0,
        }
    }

    /// The accepted configuration has these lengths. Outputs of other lengths mean nothing any more.
    pub(super) fn measure(&mut self, lengths: IoLengths) {
        if self.lengths != lengths {
            self.lengths = lengths;
            self.clear();
        }
    }

    /// The modes that an accepted Set_Prm asks for and the slave has may be commanded from now on.
    pub(super) const fn enable(&mut self, prm: SetPrm<'_>, description: &Description) {
        self.sync = Mode::enabled(prm.sync_req() && description.sync_mode);
        self.freeze = Mode::enabled(prm.freeze_req() && description.freeze_mode);
    }

    pub(super) fn sync_mode(&self) -> bool {
        self.sync == Mode::Active
    }

    pub(super) fn freeze_mode(&self) -> bool {
        self.freeze == Mode::Active
    }

    pub(super) const fn lengths(&self) -> IoLengths {
        self.lengths
    }

    pub(super) fn outputs(&self) -> &[u8] {
        self.outputs.first(self.lengths.outputs)
    }

    pub(super) const fn output_updates(&self) -> u32 {
        self.output_updates
    }

    /// The inputs as Data_Exchange carries them now.
    pub(super) fn inputs(&self) -> &[u8] {
        let inputs = if self.freeze_mode() { &self.frozen_inputs } else { &self.inputs };
        inputs.first(self.lengths.inputs)
    }

    pub(super) fn set_inputs(&mut self, inputs: &[u8]) {
        self.inputs.copy(inputs);
    }

    /// Data_Exchange brought outputs.
    pub(super) fn take_outputs(&mut self, outputs: &[u8]) {
        if self.sync_mode() {
            self.waiting_outputs.copy(outputs);
        } else {
            self.outputs.copy(outputs);
            self.pass();
        }
    }

    /// Outputs to zero, those that wait for Sync too.
    pub(super) fn clear(&mut self) {
        self.outputs = Octets::EMPTY;
        self.waiting_outputs = Octets::EMPTY;
        self.pass();
    }

    /// The owner has gone: outputs to zero, Sync and Freeze end.
    pub(super) fn close(&mut self) {
        self.sync = Mode::Closed;
        self.freeze = Mode::Closed;
        self.clear();
    }

    /// Carries out a command. A mode that Set_Prm did not enable stays closed (S-10).
    pub(super) fn control(&mut self, command: GlobalControl) {
        if command.clear_data {
            self.clear();
        }
        match (self.sync, command.sync) {
            (Mode::Closed, _) | (_, Latch::Keep) | (Mode::Enabled, Latch::Release) => {}
            (Mode::Enabled, Latch::Set) => {
                // The outputs received last are out already; from now on they wait.
                self.waiting_outputs = self.outputs;
                self.sync = Mode::Active;
            }
            (Mode::Active, Latch::Set) => self.pass_waiting(),
            (Mode::Active, Latch::Release) => {
                self.pass_waiting();
                self.sync = Mode::Enabled;
            }
        }
        match (self.freeze, command.freeze) {
            (Mode::Closed, _) | (_, Latch::Keep) => {}
            (Mode::Enabled | Mode::Active, Latch::Set) => {
                self.frozen_inputs = self.inputs;
                self.freeze = Mode::Active;
            }
            (Mode::Enabled | Mode::Active, Latch::Release) => self.freeze = Mode::Enabled,
        }
    }

    /// The bit of Set_Prm that a Sync or Freeze of this command lacks.
    pub(super) fn closed(&self, command: GlobalControl) -> Option<PrmBit> {
        let closed = |mode, latch| mode == Mode::Closed && latch == Latch::Set;
        match (closed(self.sync, command.sync), closed(self.freeze, command.freeze)) {
            (true, _) => Some(PrmBit::SyncReq),
            (false, true) => Some(PrmBit::FreezeReq),
            (false, false) => None,
        }
    }

    fn pass_waiting(&mut self) {
        self.outputs = self.waiting_outputs;
        self.pass();
    }

    const fn pass(&mut self) {
        self.output_updates = self.output_updates.wrapping_add(1);
    }
}

/// Sync or Freeze.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    /// Set_Prm did not ask for it.
    Closed,
    /// May be commanded.
    Enabled,
    /// Commanded.
    Active,
}

impl Mode {
    const fn enabled(enabled: bool) -> Self {
        if enabled { Self::Enabled } else { Self::Closed }
    }
}

/// The octets of one direction; those never written are zero.
#[derive(Clone, Copy, Debug)]
struct Octets([u8; MAX_IO_LEN]);

impl Octets {
    const EMPTY: Self = Self([0; MAX_IO_LEN]);

    fn first(&self, len: u8) -> &[u8] {
        self.0.get(..len.into()).unwrap_or_default()
    }

    fn copy(&mut self, octets: &[u8]) {
        for (place, octet) in self.0.iter_mut().zip(octets) {
            *place = *octet;
        }
    }
}
