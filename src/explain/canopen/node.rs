//! What is known of one node.

use crate::map::Map;

use super::service::Service;
use crate::can_bus::canopen::dictionary;
use crate::can_bus::canopen::dictionary::{Entry, Object};
use crate::can_bus::canopen::pdo;
use crate::can_bus::canopen::pdo::mapping::MappingWord;
use crate::can_bus::canopen::{Abort, Address, NmtState, NodeId};
use crate::can_bus::cia402::axis;
use crate::devices::Vocabulary;
use crate::devices::ag03::param::{Kind, Parameter};
use crate::devices::vocabulary::CIA_402;
use crate::explain::value::Lengths;

/// What is known of one node.
#[derive(Clone, Debug)]
pub(super) struct Learned {
    /// Which device it is, if that was said.
    pub(super) vocabulary: Option<&'static Vocabulary>,
    pub(super) nmt: Option<NmtState>,
    pub(super) asked: Option<Asked>,
    /// 6040h and 6041h as last seen.
    pub(super) control: Option<u16>,
    pub(super) status: Option<u16>,
    /// Objects that say how to read frames, as written or read.
    /// What positions are counted in.
    pub(super) lengths: Lengths,
    heard: Map<Address, u32>,
    changed: Option<Address>,
}

/// The SDO request that waits for its answer, or the transfer under way.
#[derive(Clone, Debug)]
pub(super) enum Asked {
    Read(Address),
    Write(Address, Vec<u8>),
    /// A read in segments: what came, and the toggle bit of the next.
    Reading(Address, Vec<u8>, bool),
    /// A write in segments: what was sent.
    Writing(Address, Vec<u8>, bool),
}

/// Octets of a segmented transfer that are kept.
const MOST_OCTETS: usize = 4096;

impl Asked {
    pub(super) const fn at(&self) -> Address {
        match self {
            Self::Read(at) | Self::Write(at, _) | Self::Reading(at, _, _) | Self::Writing(at, _, _) => *at,
        }
    }
}

/// Appends octets of a segment.
pub(super) fn append(octets: &mut Vec<u8>, more: &[u8]) {
    if octets.len() < MOST_OCTETS {
        octets.extend_from_slice(more);
    }
}

impl Learned {
    pub(super) const fn new(vocabulary: Option<&'static Vocabulary>) -> Self {
        Self {
            vocabulary,
            nmt: None,
            asked: None,
            control: None,
            status: None,
            lengths: Lengths::Unknown,
            heard: Map::new(),
            changed: None,
        }
    }

    /// The words of the device, or those of CiA 402.
    pub(super) fn words(&self) -> &'static Vocabulary {
        self.vocabulary.unwrap_or(&CIA_402)
    }

    pub(super) fn object(&self, at: Address) -> Option<&'static Object> {
        dictionary::object(self.words().objects, at.index)
    }

    pub(super) fn entry(&self, at: Address) -> Result<&'static Entry, Abort> {
        dictionary::entry(self.words().objects, at)
    }

    /// 6060h of the axis of an object: as heard, else the default of the device.
    pub(super) fn mode(&self, of: Address) -> i64 {
        let at = mode_of(of);
        let heard = self.heard(at).map(|octet| i64::from(octet.to_le_bytes()[0].cast_signed()));
        let default = || self.entry(at).ok()?.default_value(NodeId::MIN).number();
        heard.or_else(default).unwrap_or(0)
    }

    pub(super) fn heard(&self, at: Address) -> Option<u32> {
        self.heard.get(&at).copied()
    }

    /// The node has this value now.
    pub(super) fn hear(&mut self, at: Address, octets: &[u8]) {
        let mut value = [0; 4];
        for (place, octet) in value.iter_mut().zip(octets) {
            *place = *octet;
        }
        let value = u32::from_le_bytes(value);
        let [low, high, ..] = value.to_le_bytes();
        match at.pair() {
            (0x6040, 0) => self.control = Some(u16::from_le_bytes([low, high])),
            (0x6041, 0) => self.status = Some(u16::from_le_bytes([low, high])),
            (0.., 0..) => {}
        }
        if of_first(at) == MODE_DISPLAY {
            self.heard.insert(mode_of(at), value);
        }
        let parameter = (self.words().parameter)(at).map(|entry| entry.kind);
        if matches!(parameter, Some(Kind::Setting(setting)) if setting.parameter == Parameter::SpindlePitch) {
            self.lengths = Lengths::of_spindle_pitch(value);
        }
        if says_how_to_read(at) {
            self.heard.insert(at, value);
            self.changed = Some(at);
        }
    }

    /// The object heard last, if it says how to read frames.
    pub(super) const fn take_changed(&mut self) -> Option<Address> {
        self.changed.take()
    }

    /// The communication starts anew.
    pub(super) fn reset(&mut self) {
        self.heard.retain(|at, _| at.index.0 >= 0x2000);
        self.asked = None;
        self.control = None;
        self.status = None;
    }

    /// The words of the mapping at `index`; `None` if they are not known.
    pub(super) fn mapping(&self, index: u16) -> Option<Vec<MappingWord>> {
        let of = |sub: u8| {
            let at = Address::new(index, sub);
            let default = || self.entry(at).ok()?.default_value(NodeId::MIN).number();
            let heard = self.heard(at).map(i64::from);
            u32::try_from(heard.or_else(default)?).ok()
        };
        let count = u8::try_from(of(0)?).ok().filter(|count| (1..=64).contains(count))?;
        (1..=count).map(|sub| of(sub).map(MappingWord::decode)).collect()
    }
}

const MODE: Address = Address::new(0x6060, 0);
const MODE_DISPLAY: Address = Address::new(0x6061, 0);

/// Where the first axis has an object.
const fn of_first(at: Address) -> Address {
    Address::new(axis::of_first(at.index.0).1, at.sub.0)
}

/// 6060h of the axis of an object.
const fn mode_of(at: Address) -> Address {
    Address::new(axis::index(axis::of_first(at.index.0).0, MODE.index.0), 0)
}

/// Mapping of RPDO 1.
pub(super) const RPDO_MAPPING: u16 = 0x1600;
/// Mapping of TPDO 1.
pub(super) const TPDO_MAPPING: u16 = 0x1A00;

/// Whether the object decides what later frames mean: identifiers, mappings, mode.
fn says_how_to_read(at: Address) -> bool {
    let mapping = |base: u16| (base..base + pdo::OBJECTS).contains(&at.index.0) && at.sub.0 <= 8;
    of_first(at) == MODE
        || Service::of_object(1, at).is_some()
        || mapping(RPDO_MAPPING)
        || mapping(TPDO_MAPPING)
}
