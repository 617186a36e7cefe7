//! What a node keeps over power-off: 1010h, 1011h, and images that the host keeps.
//!
//! ```text
//! SDO write ─▶ value acts ─▶ poll_image ─▶ host writes ─▶ handle_stored ─▶ SDO answer
//!                                                    └─ failed: kept values go back, answer 06060000h
//! ```
//!
//! An image:
//!
//! ```text
//! octets 0..3  "CO1" and the node number it was made with
//! octets 4..   entries: index (2), sub-index (1), length (2), value; low octets first
//!              0000h:00 what the device keeps beside its dictionary; 0000h:01 one octet, 1: the defaults come
//!              back with the next reset (1011h)
//! last 4       CRC-32 of all before
//! ```

use thiserror::Error;

use super::abort::Abort;
use super::address::{Address, NodeId, Sub};
use super::application::{Application, Notice, Source, Written};
use super::dictionary::{self, Default, Home};
use super::node::Node;
use super::parameter::{self, Communication, Parameter};
use super::policy::{LoadRule, Storing};
use crate::time::Instant;

const MAGIC: [u8; 3] = *b"CO1";
const HEADER_LEN: usize = 4;
const ENTRY_HEADER_LEN: usize = 5;
const CRC_LEN: usize = 4;

/// The most octets that a device keeps beside its dictionary.
pub const MAX_BESIDE: usize = 32;

/// The entry of an image that holds them; there is no object 0000h.
const BESIDE: Address = Address::new(0, 0);
/// The entry of an image that says that the defaults come back once.
const DEFAULTS_ONCE: Address = Address::new(0, 1);

/// Where what is stored is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Memory {
    /// In the node and its device, for as long as they live: writes are answered at once and no image is offered.
    #[default]
    Internal,
    /// By the host: it takes every image from [`Node::poll_image`] and reports with [`Node::handle_stored`]. A write
    /// that stores something is answered only after that.
    Host,
}

/// Numbers the images of one node: a later image has a larger number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Generation(u64);

impl From<u64> for Generation {
    fn from(number: u64) -> Self {
        Self(number)
    }
}

impl From<Generation> for u64 {
    fn from(generation: Generation) -> Self {
        generation.0
    }
}

/// An image the host shall keep instead of all before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreRequest<'a> {
    /// To be reported with it.
    pub generation: Generation,
    /// The image, for [`Node::recall`].
    pub octets: &'a [u8],
}

/// The host could not keep an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the image of the node could not be stored")]
pub struct NotStored;

/// Octets that are no image, or no room for one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The buffer is too short.
    #[error("the image needs more than {got} octets")]
    NoRoom {
        /// Octets of the buffer.
        got: usize,
    },
    /// It ends too early or does not begin as an image.
    #[error("{got} octets are no image of a CANopen node")]
    NoImage {
        /// Octets given.
        got: usize,
    },
    /// It was changed.
    #[error("image has CRC {got:08X}h, expected {expected:08X}h")]
    Crc {
        /// As computed.
        expected: u32,
        /// As found.
        got: u32,
    },
}

/// What comes back with a reset, and how far the newest image is.
#[derive(Clone, Debug)]
pub(super) struct Storage {
    pub(super) memory: Memory,
    kept: Option<Kept>,
    /// What was kept before the image that is on its way.
    before: Option<Option<Kept>>,
    /// The next reset takes the defaults and leaves what is kept.
    defaults_once: bool,
    generation: Generation,
    progress: Progress,
    /// An SDO answer waits for this image.
    awaited: Option<Generation>,
    /// An SDO answer waits for the device.
    device_holds: bool,
}

/// Communication objects with the node number they were made with.
#[derive(Clone, Debug)]
struct Kept {
    values: Communication,
    node: NodeId,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    /// Nothing to keep that the host does not have.
    Safe,
    /// The host may take it.
    Offered,
    /// The host has taken it.
    Taken,
    /// The host could not keep it; it is offered again with the next change.
    Failed,
}

impl Storage {
    pub(super) const fn new(memory: Memory) -> Self {
        Self {
            memory,
            kept: None,
            before: None,
            defaults_once: false,
            generation: Generation(0),
            progress: Progress::Safe,
            awaited: None,
            device_holds: false,
        }
    }

    /// What is kept is not what the newest image holds.
    pub(super) const fn changed(&mut self) {
        match self.memory {
            Memory::Internal => {}
            Memory::Host => {
                self.generation = Generation(self.generation.0.saturating_add(1));
                self.progress = Progress::Offered;
            }
        }
    }

    /// The device changed what it keeps. An answer that it holds then waits for the image, too.
    pub(super) fn changed_by_device(&mut self) {
        self.changed();
        if self.device_holds && self.memory == Memory::Host {
            self.awaited = Some(self.generation);
        }
    }

    /// The client does not wait any more.
    pub(super) const fn forget_answer(&mut self) {
        self.awaited = None;
        self.device_holds = false;
    }

    fn remember_before(&mut self) {
        if self.memory == Memory::Host && self.before.is_none() {
            self.before = Some(self.kept.clone());
        }
    }
}

impl Node {
    /// What the device keeps changed, with supply or without: an image is offered to the host.
    pub fn offer_image(&mut self) {
        self.storage.changed();
    }

    /// The image to keep, if it differs from the one taken before and [`Memory::Host`] is set. Poll it when frames and
    /// events are drained.
    ///
    /// # Errors
    /// [`ImageError::NoRoom`]; it stays on offer.
    pub fn poll_image<'a>(
        &mut self,
        app: &dyn Application,
        into: &'a mut [u8],
    ) -> Result<Option<StoreRequest<'a>>, ImageError> {
        match self.storage.progress {
            Progress::Offered => {
                let len = self.image(app, into)?;
                self.storage.progress = Progress::Taken;
                let octets = into.get(..len).unwrap_or_default();
                Ok(Some(StoreRequest { generation: self.storage.generation, octets }))
            }
            Progress::Safe | Progress::Taken | Progress::Failed => Ok(None),
        }
    }

    /// The host says what became of an image. Only reports on the newest image taken are needed.
    ///
    /// When it could not be kept, the communication objects kept before it are kept again, and a waiting SDO is
    /// answered with 06060000h.
    pub fn handle_stored(
        &mut self,
        now: Instant,
        generation: Generation,
        outcome: Result<(), NotStored>,
        app: &mut dyn Application,
    ) {
        let newest = generation == self.storage.generation;
        match outcome {
            Ok(()) => {
                if newest {
                    self.storage.progress = Progress::Safe;
                    self.storage.before = None;
                }
                if self.storage.awaited.is_some_and(|awaited| awaited <= generation) {
                    self.storage.awaited = None;
                    self.answer_if_free();
                }
            }
            Err(NotStored) if newest => {
                self.storage.progress = Progress::Failed;
                if let Some(before) = self.storage.before.take() {
                    self.storage.kept = before;
                }
                app.notice(now, Notice::NotStored);
                if self.storage.awaited.is_some() {
                    self.answer_held(Err(Abort::HARDWARE));
                }
            }
            Err(NotStored) => {}
        }
    }

    /// Everything that is kept, as an image. Says how many octets it has.
    ///
    /// # Errors
    /// [`ImageError::NoRoom`].
    pub fn image(&self, app: &dyn Application, into: &mut [u8]) -> Result<usize, ImageError> {
        let mut writer = Writer { got: into.len(), into, len: 0 };
        let node = self.storage.kept.as_ref().map_or(self.node_id, |kept| kept.node);
        writer.put(&MAGIC)?;
        writer.put(&[node.number()])?;
        for object in self.objects {
            for entry in object.entries.iter().filter(|entry| entry.stored) {
                let at = Address { index: object.index, sub: entry.sub };
                match entry.home {
                    Home::Application => {
                        if let Ok(value) = app.kept(at) {
                            value.with_octets(|octets| writer.entry(at, octets))?;
                        }
                    }
                    Home::Node => self.image_parameter(at, &mut writer)?,
                    Home::Default | Home::Alias(_) => {}
                }
            }
        }
        let mut beside = [0; MAX_BESIDE];
        let len = app.kept_beside(&mut beside);
        if let Some(octets) = beside.get(..len).filter(|octets| !octets.is_empty()) {
            writer.entry(BESIDE, octets)?;
        }
        if self.storage.defaults_once {
            writer.entry(DEFAULTS_ONCE, &[1])?;
        }
        let crc = crc32(writer.into.get(..writer.len).unwrap_or_default());
        writer.put(&crc.to_le_bytes())?;
        Ok(writer.len)
    }

    fn image_parameter(&self, at: Address, writer: &mut Writer<'_>) -> Result<(), ImageError> {
        match (Parameter::of(at), &self.storage.kept) {
            (Some(Parameter::History(sub)), _) => match self.errors.entry(sub) {
                Some(entry) => writer.entry(at, &entry.to_le_bytes()),
                None => Ok(()),
            },
            (Some(Parameter::HistoryCount | Parameter::ErrorRegister), _) => Ok(()),
            (Some(parameter), Some(kept)) => writer.entry(at, &kept.values.value(parameter).to_le_bytes()),
            (Some(_), None) | (None, _) => Ok(()),
        }
    }

    /// Takes an image over, before the node is switched on. Entries that the dictionary does not have, or does not
    /// accept, are left out: an image may be older than the device.
    ///
    /// # Errors
    /// [`ImageError`]; nothing is taken over then.
    pub fn recall(
        &mut self,
        now: Instant,
        image: &[u8],
        app: &mut dyn Application,
    ) -> Result<(), ImageError> {
        let (node, mut rest) = open(image)?;
        self.objects = app.objects();
        let mut kept = Kept { values: Communication::defaults(self.objects, node), node };
        let mut any = false;
        self.errors.clear_history();
        self.storage.defaults_once = false;
        while let Some((at, octets, behind)) = next_entry(rest) {
            rest = behind;
            match at {
                BESIDE => app.recall_beside(octets),
                DEFAULTS_ONCE => self.storage.defaults_once = octets == [1],
                Address { .. } => {}
            }
            let Ok(entry) = dictionary::entry(self.objects, at) else { continue };
            if !entry.stored {
                continue;
            }
            match entry.home {
                Home::Application => {
                    if self.judge_length(entry, octets.len()).is_ok()
                        && let Some(value) = entry.data.decode(octets)
                        && self.policy.judge_range(entry, value).is_ok()
                    {
                        let _ = app.write(now, at, value, Source::Image);
                    }
                }
                Home::Node => {
                    let number = <[u8; 4]>::try_from(octets).map(u32::from_le_bytes);
                    match (Parameter::of(at), number) {
                        (Some(Parameter::History(_)), Ok(number)) => self.errors.recall(number),
                        (Some(parameter), Ok(number)) => {
                            kept.values.set(parameter, number);
                            any = true;
                        }
                        (None, _) | (_, Err(_)) => {}
                    }
                }
                Home::Default | Home::Alias(_) => {}
            }
        }
        self.storage.kept = any.then_some(kept);
        Ok(())
    }

    /// The values of the communication objects after a reset.
    pub(super) fn values_after_reset(&mut self) -> Communication {
        let mut values = Communication::defaults(self.objects, self.node_id);
        if core::mem::take(&mut self.storage.defaults_once) {
            // Once: the next image does not say it any more.
            self.storage.changed();
            return values;
        }
        let Some(kept) = &self.storage.kept else { return values };
        for (parameter, entry) in parameter::kept(self.objects) {
            let value = kept.values.value(parameter);
            // A COB-ID that was the default of its node number is the default of the new one.
            let is_default = match entry.default {
                Default::NodeId(base) => value == base + u32::from(kept.node.number()),
                Default::None | Default::Number(_) | Default::Real(_) | Default::Text(_) => false,
            };
            if entry.stored && !is_default {
                values.set(parameter, value);
            }
        }
        values
    }

    /// 1010h with the right signature.
    pub(super) fn store(
        &mut self,
        now: Instant,
        group: Sub,
        app: &mut dyn Application,
    ) -> Result<Written, Abort> {
        let written = app.store(now, group)?;
        self.storage.remember_before();
        if self.policy.communication_groups.contains(&group.0) {
            self.storage.kept = Some(Kept { values: self.values.clone(), node: self.node_id });
        }
        self.storage.changed();
        Ok(written)
    }

    /// 1011h with the right signature: acts with the next reset.
    pub(super) fn load_defaults(
        &mut self,
        now: Instant,
        group: Sub,
        app: &mut dyn Application,
    ) -> Result<Written, Abort> {
        let written = app.load_defaults(now, group)?;
        self.storage.remember_before();
        if self.policy.communication_groups.contains(&group.0) {
            match self.policy.load {
                LoadRule::Erase => self.storage.kept = None,
                LoadRule::OnceAfterReset => self.storage.defaults_once = true,
            }
        }
        self.storage.changed();
        Ok(written)
    }

    /// One communication object is kept with its write.
    pub(super) fn keep(&mut self, parameter: Parameter, value: u32) {
        self.storage.remember_before();
        let (objects, node) = (self.objects, self.node_id);
        let kept = self
            .storage
            .kept
            .get_or_insert_with(|| Kept { values: Communication::defaults(objects, node), node });
        kept.values.set(parameter, value);
        self.storage.changed();
    }

    /// A write is done. Says whether its answer has to wait, for an image or for the device.
    pub(super) fn hold(&mut self, before: Generation, written: Written) -> Written {
        self.storage.device_holds = written == Written::Held;
        self.storage.awaited = (before != self.storage.generation).then_some(self.storage.generation);
        if self.storage.device_holds || self.storage.awaited.is_some() {
            Written::Held
        } else {
            Written::Done
        }
    }

    pub(super) const fn generation(&self) -> Generation {
        self.storage.generation
    }

    /// A value of the device was written that is kept at once.
    pub(super) fn note_written(&mut self, stored: bool) {
        if stored && self.policy.storing == Storing::OnWrite {
            self.storage.changed();
        }
    }

    /// The device does not hold the answer any more.
    pub(super) fn device_answers(&mut self, outcome: Result<(), Abort>) {
        if !self.storage.device_holds {
            return;
        }
        self.storage.device_holds = false;
        match outcome {
            Ok(()) => self.answer_if_free(),
            Err(code) => self.answer_held(Err(code)),
        }
    }

    fn answer_if_free(&mut self) {
        if !self.storage.device_holds && self.storage.awaited.is_none() {
            self.answer_held(Ok(()));
        }
    }
}

struct Writer<'a> {
    into: &'a mut [u8],
    len: usize,
    got: usize,
}

impl Writer<'_> {
    fn put(&mut self, octets: &[u8]) -> Result<(), ImageError> {
        let end = self.len + octets.len();
        let room = self.into.get_mut(self.len..end).ok_or(ImageError::NoRoom { got: self.got })?;
        room.copy_from_slice(octets);
        self.len = end;
        Ok(())
    }

    fn entry(&mut self, at: Address, octets: &[u8]) -> Result<(), ImageError> {
        let [low, high] = at.index.0.to_le_bytes();
        let len = u16::try_from(octets.len()).map_err(|_| ImageError::NoRoom { got: self.got })?;
        let [len_low, len_high] = len.to_le_bytes();
        self.put(&[low, high, at.sub.0, len_low, len_high])?;
        self.put(octets)
    }
}

/// The node number and the entries of an image that is whole.
fn open(image: &[u8]) -> Result<(NodeId, &[u8]), ImageError> {
    let no_image = ImageError::NoImage { got: image.len() };
    let (content, crc) = image.split_last_chunk::<CRC_LEN>().ok_or(no_image)?;
    let (expected, got) = (crc32(content), u32::from_le_bytes(*crc));
    let (header, entries) = content.split_first_chunk::<HEADER_LEN>().ok_or(no_image)?;
    let [a, b, c, node] = *header;
    let node = NodeId::new(node).map_err(|_| no_image)?;
    if [a, b, c] != MAGIC {
        return Err(no_image);
    }
    if expected == got { Ok((node, entries)) } else { Err(ImageError::Crc { expected, got }) }
}

/// The first entry, its octets, and what is behind it.
fn next_entry(rest: &[u8]) -> Option<(Address, &[u8], &[u8])> {
    let (&[low, high, sub, len_low, len_high], rest) = rest.split_first_chunk::<ENTRY_HEADER_LEN>()?;
    let len = usize::from(u16::from_le_bytes([len_low, len_high]));
    let (octets, behind) = rest.split_at_checked(len)?;
    Some((Address::new(u16::from_le_bytes([low, high]), sub), octets, behind))
}

/// CRC-32 of IEEE 802.3.
fn crc32(octets: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for octet in octets {
        crc ^= u32::from(*octet);
        for _ in 0..8 {
            let carry = crc & 1;
            crc >>= 1;
            if carry == 1 {
                crc ^= 0xEDB8_8320;
            }
        }
    }
    !crc
}
