//! What a node keeps over power-off: 1010h, 1011h, and images that the host keeps.
//!
//! ```text
//! SDO write ─▶ value acts ─▶ poll_image ─▶ host writes ─▶ handle_stored ─▶ SDO answer
//!                                                    └─ failed: kept values go back, answer 06060000h
//! ```
//!
//! The content of an [image](mod@crate::image):
//!
//! ```text
//! octet 0   the node number it was made with
//! then      entries: index (2), sub-index (1), length (2), value; low octets first
//!           0000h:00 what the device keeps beside its dictionary; 0000h:01 one octet, 1: the defaults come
//!           back with the next reset (1011h)
//! ```
//!
//! Images of earlier versions name no product: "CO1", the same content, CRC-32 with the low octet first.

use super::Node;
use crate::can_bus::canopen::abort::Abort;
use crate::can_bus::canopen::address::{Address, NodeId, Sub};
use crate::can_bus::canopen::application::{Application, MAX_BESIDE, Notice, Source, Written};
use crate::can_bus::canopen::dictionary::{self, Default, Home, Object};
use crate::can_bus::canopen::parameter::{self, Communication, Parameter};
use crate::can_bus::canopen::policy::{LoadRule, Storing};
use crate::image;
use crate::image::storage::{Newest, Outcome};
use crate::image::{ProductName, Writer};
use crate::time::Instant;

pub use crate::image::{Eeprom, Generation, ImageError, NotStored, StoreRequest};

/// How images of earlier versions begin.
const UNNAMED: [u8; 3] = *b"CO1";
const ENTRY_HEADER_LEN: usize = 5;

/// The entry of an image that holds them; there is no object 0000h.
const BESIDE: Address = Address::new(0, 0);
/// The entry of an image that says that the defaults come back once.
const DEFAULTS_ONCE: Address = Address::new(0, 1);

/// What comes back with a reset, and how far the newest image is.
#[derive(Clone, Debug)]
pub(super) struct Storage {
    pub(super) memory: Eeprom,
    kept: Option<Kept>,
    /// What was kept before the image that is on its way.
    before: Option<Option<Kept>>,
    /// The next reset takes the defaults and leaves what is kept.
    defaults_once: bool,
    newest: Newest,
    /// An SDO answer waits for the device.
    device_holds: bool,
}

/// Communication objects with the node number they were made with.
#[derive(Clone, Debug)]
struct Kept {
    values: Communication,
    node: NodeId,
}

impl Storage {
    pub(super) const fn new(memory: Eeprom) -> Self {
        let newest = Newest::SAFE;
        Self { memory, kept: None, before: None, defaults_once: false, newest, device_holds: false }
    }

    /// What is kept is not what the newest image holds.
    pub(super) const fn changed(&mut self) {
        match self.memory {
            Eeprom::Internal => {}
            Eeprom::Host => self.newest.offer(),
        }
    }

    /// The device changed what it keeps. An answer that it holds then waits for the image, too.
    pub(super) fn changed_by_device(&mut self) {
        self.changed();
        if self.device_holds && self.memory == Eeprom::Host {
            self.newest.wait();
        }
    }

    /// The client does not wait any more.
    pub(super) const fn forget_answer(&mut self) {
        self.newest.forget();
        self.device_holds = false;
    }

    /// An SDO answer waits, for an image or for the device.
    const fn is_held(&self) -> bool {
        self.device_holds || self.newest.is_awaited()
    }

    fn remember_before(&mut self) {
        if self.memory == Eeprom::Host && self.before.is_none() {
            self.before = Some(self.kept.clone());
        }
    }
}

impl Node {
    /// What the device keeps changed, with supply or without: an image is offered to the host.
    pub(crate) fn offer_image(&mut self) {
        self.storage.changed();
    }

    /// The image to keep, if it differs from the one taken before and [`Eeprom::Host`] is set. Poll it when frames and
    /// events are drained.
    ///
    /// # Errors
    /// [`ImageError::NoRoom`]; it stays on offer.
    pub fn poll_image<'a>(
        &mut self,
        app: &dyn Application,
        into: &'a mut [u8],
    ) -> Result<Option<StoreRequest<&'a [u8]>>, ImageError> {
        // What has no room stays on offer.
        if self.storage.newest.stage() != image::storage::Stage::Offered {
            return Ok(None);
        }
        let len = self.image(app, into)?;
        let octets = into.get(..len).unwrap_or_default();
        Ok(self.storage.newest.take().map(|generation| StoreRequest { generation, octets }))
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
        let newest = generation == self.storage.newest.generation();
        let waiting = self.storage.newest.report(generation, outcome);
        match outcome {
            Ok(()) if newest => self.storage.before = None,
            Err(NotStored) if newest => {
                if let Some(before) = self.storage.before.take() {
                    self.storage.kept = before;
                }
                app.notice(now, Notice::NotStored);
            }
            Ok(()) | Err(NotStored) => {}
        }
        match waiting {
            Outcome::None => {}
            Outcome::Safe => self.answer_if_free(),
            Outcome::Undone => self.answer_held(Err(Abort::HARDWARE)),
        }
    }

    /// Everything that is kept, as an image. Says how many octets it has.
    ///
    /// # Errors
    /// [`ImageError::NoRoom`].
    pub fn image(&self, app: &dyn Application, into: &mut [u8]) -> Result<usize, ImageError> {
        let mut writer = Writer::named(into, app.product());
        let node = self.storage.kept.as_ref().map_or(self.node_id, |kept| kept.node);
        writer.put(&[node.number()]);
        for object in self.objects {
            for entry in object.entries.iter().filter(|entry| entry.stored) {
                let at = Address { index: object.index, sub: entry.sub };
                match entry.home {
                    Home::Application => {
                        if let Ok(value) = app.kept(at) {
                            value.with_octets(|octets| put_entry(&mut writer, at, octets));
                        }
                    }
                    Home::Node => self.put_parameter(at, &mut writer),
                    Home::Default | Home::Alias(_) => {}
                }
            }
        }
        let mut beside = [0; MAX_BESIDE];
        let len = app.kept_beside(&mut beside);
        if let Some(octets) = beside.get(..len).filter(|octets| !octets.is_empty()) {
            put_entry(&mut writer, BESIDE, octets);
        }
        if self.storage.defaults_once {
            put_entry(&mut writer, DEFAULTS_ONCE, &[1]);
        }
        writer.finish()
    }

    fn put_parameter(&self, at: Address, writer: &mut Writer<'_>) {
        let value = match (Parameter::of(at), &self.storage.kept) {
            (Some(Parameter::History(sub)), _) => self.errors.entry(sub),
            (Some(Parameter::HistoryCount | Parameter::ErrorRegister), _) => None,
            (Some(parameter), Some(kept)) => Some(kept.values.value(parameter)),
            (Some(_), None) | (None, _) => None,
        };
        if let Some(value) = value {
            put_entry(writer, at, &value.to_le_bytes());
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
        self.objects = app.objects();
        let (node, mut rest) = open(image, app.product(), self.objects)?;
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
        self.storage.newest.forget();
        if before != self.storage.newest.generation() {
            self.storage.newest.wait();
        }
        if self.storage.is_held() { Written::Held } else { Written::Done }
    }

    pub(super) const fn generation(&self) -> Generation {
        self.storage.newest.generation()
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
        if !self.storage.is_held() {
            self.answer_held(Ok(()));
        }
    }
}

fn put_entry(writer: &mut Writer<'_>, at: Address, octets: &[u8]) {
    let [low, high] = at.index.0.to_le_bytes();
    // Longer than an image can be: it has no room, which is found out at its end.
    let [len_low, len_high] = u16::try_from(octets.len()).unwrap_or(u16::MAX).to_le_bytes();
    writer.put(&[low, high, at.sub.0, len_low, len_high]);
    writer.put(octets);
}

/// The node number and the entries of an image of this product.
fn open<'a>(octets: &'a [u8], product: &str, objects: &[Object]) -> Result<(NodeId, &'a [u8]), ImageError> {
    let content = match octets.strip_prefix(&UNNAMED) {
        Some(rest) => open_unnamed(octets, rest, product, objects)?,
        None => image::open(octets)?.of(product)?,
    };
    let (node, entries) = content.split_first().ok_or(ImageError::Foreign)?;
    Ok((NodeId::new(*node).map_err(|_| ImageError::Foreign)?, entries))
}

/// The content of an image that names no product: it is of this one if the dictionary has all of its objects.
fn open_unnamed<'a>(
    octets: &[u8],
    rest: &'a [u8],
    product: &str,
    objects: &[Object],
) -> Result<&'a [u8], ImageError> {
    let (content, crc) = rest.split_last_chunk().ok_or(ImageError::Foreign)?;
    let body = octets.get(..UNNAMED.len() + content.len()).unwrap_or_default();
    let (expected, got) = (image::crc32(body), u32::from_le_bytes(*crc));
    if expected != got {
        return Err(ImageError::Checksum { expected, got });
    }
    let mut entries = content.get(1..).unwrap_or_default();
    while let Some((at, _, behind)) = next_entry(entries) {
        entries = behind;
        if at.index != BESIDE.index && !objects.iter().any(|object| object.index == at.index) {
            let (expected, got) = (ProductName::new(product), ProductName::new("a node with other objects"));
            return Err(ImageError::OtherProduct { expected, got });
        }
    }
    Ok(content)
}

/// The first entry, its octets, and what is behind it.
fn next_entry(rest: &[u8]) -> Option<(Address, &[u8], &[u8])> {
    let (&[low, high, sub, len_low, len_high], rest) = rest.split_first_chunk::<ENTRY_HEADER_LEN>()?;
    let len = usize::from(u16::from_le_bytes([len_low, len_high]));
    let (octets, behind) = rest.split_at_checked(len)?;
    Some((Address::new(u16::from_le_bytes([low, high]), sub), octets, behind))
}
