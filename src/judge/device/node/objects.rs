//! What is known of the objects of the node: by its data sheet, else by what it answers.

use crate::map::Map;
use core::time::Duration;

use super::Tester;
use crate::can_bus::can::Id;
use crate::can_bus::canopen::value::{DataType, ValueKind};
use crate::can_bus::canopen::{Abort, Address};
use crate::eds::{Entry, Limit};
use crate::judge::device::course::{Course, broken};

/// What was learned of the node.
#[derive(Debug, Default)]
pub(super) struct Known {
    /// Its heartbeat, if it has one.
    pub(super) heartbeat: Option<Duration>,
    /// That of its power-on.
    pub(super) own_heartbeat: Option<Duration>,
    /// No boot-up came after a reset.
    pub(super) boots_silently: bool,
    /// The identifier of SYNC, as it is without the rows.
    pub(super) sync: Option<Id>,
    /// Entries that were looked for.
    looked_for: Map<Address, bool>,
}

impl Known {
    /// The period that 1017h says.
    pub(super) fn heartbeat_of(octets: &[u8]) -> Option<Duration> {
        let millis = whole(octets);
        (millis > 0).then(|| Duration::from_millis(millis))
    }
}

/// An entry of the data sheet.
#[derive(Clone, Debug)]
pub(super) struct Listed {
    pub(super) at: Address,
    pub(super) entry: Entry,
}

impl Listed {
    /// How many octets its type has; `None`: any.
    pub(super) fn size(&self) -> Option<usize> {
        self.entry.data.octets()
    }

    /// Whether it is a whole number.
    pub(super) fn is_whole(&self) -> bool {
        match self.entry.data.kind() {
            ValueKind::Signed | ValueKind::Unsigned => true,
            ValueKind::Boolean | ValueKind::Real | ValueKind::Text | ValueKind::Octets => false,
        }
    }

    /// Its limits, as whole numbers.
    pub(super) fn limits(&self, node: crate::can_bus::canopen::NodeId) -> (Option<i128>, Option<i128>) {
        let of = |limit: &Option<Limit>| match limit {
            Some(Limit::Whole(number)) => Some(number.at(node)),
            Some(Limit::Real(_)) | None => None,
        };
        (of(&self.entry.low), of(&self.entry.high))
    }

    /// The octets of a whole number, if the type has it.
    pub(super) fn octets_of(&self, number: i128) -> Option<Vec<u8>> {
        let len = self.size()?;
        let bits = u32::try_from(len * 8).ok()?;
        let (low, high) = match self.entry.data.kind() {
            ValueKind::Signed => (-(1_i128 << (bits - 1)), (1_i128 << (bits - 1)) - 1),
            ValueKind::Unsigned
            | ValueKind::Boolean
            | ValueKind::Real
            | ValueKind::Text
            | ValueKind::Octets => (0, (1_i128 << bits) - 1),
        };
        let fits = (low..=high).contains(&number);
        fits.then(|| number.to_le_bytes().get(..len).unwrap_or_default().to_vec())
    }

    /// The whole number of its octets.
    pub(super) fn number_of(&self, octets: &[u8]) -> i128 {
        let unsigned = i128::from(whole(octets));
        let bits = u32::try_from(octets.len().min(8) * 8).unwrap_or(64);
        let negative =
            self.entry.data.kind() == ValueKind::Signed && bits > 0 && unsigned >> (bits - 1) & 1 == 1;
        if negative { unsigned - (1 << bits) } else { unsigned }
    }

    /// Whether it is process data, which may move something: a PDO can carry what is written.
    pub(super) fn is_process_data(&self) -> bool {
        self.entry.mappable && self.entry.rights.is_writable()
    }

    /// Whether it belongs to the device and not to its communication.
    pub(super) const fn is_application(&self) -> bool {
        self.at.index.0 >= 0x2000
    }
}

/// Octets as a number, low octet first, eight at most.
pub(super) fn whole(octets: &[u8]) -> u64 {
    octets.iter().take(8).rev().fold(0, |number, octet| number << 8 | u64::from(*octet))
}

impl Tester {
    /// Learns what rows need to know.
    pub(super) fn learn(&mut self) -> Course {
        // What is wrong with the answer is said by the rows about it.
        let answer = self.exchange(super::sdo::addressed(0x40, Address::new(0x1017, 0), [0; 4]))?;
        self.known.heartbeat =
            answer.and_then(super::sdo::expedited).and_then(|octets| Known::heartbeat_of(&octets));
        Ok(())
    }

    /// Whether the node has an entry.
    pub(super) fn has(&mut self, index: u16, sub: u8) -> Course<bool> {
        if let Some(eds) = &self.setup.eds {
            return Ok(eds.entry(index, sub).is_some());
        }
        let at = Address::new(index, sub);
        if let Some(has) = self.known.looked_for.get(&at) {
            return Ok(*has);
        }
        let missing = [Abort::NO_OBJECT.code(), Abort::NO_SUB.code()];
        let has = match self.upload(at)? {
            Ok(_) => true,
            Err(code) => !missing.contains(&code),
        };
        self.known.looked_for.insert(at, has);
        Ok(has)
    }

    /// Whether an entry is there and can be written, as far as the data sheet says.
    pub(super) fn is_writable(&mut self, index: u16, sub: u8) -> Course<bool> {
        if let Some(eds) = &self.setup.eds {
            return Ok(eds.entry(index, sub).is_some_and(|entry| entry.rights.is_writable()));
        }
        self.has(index, sub)
    }

    /// The entries of the data sheet that a client may look at; none without one.
    pub(super) fn listed(&self) -> Vec<Listed> {
        let Some(eds) = &self.setup.eds else { return Vec::new() };
        let objects = eds.objects.values().filter(|object| !object.refuses_scan);
        let entries = objects.flat_map(|object| {
            let index = object.index.0;
            object
                .entries
                .iter()
                .map(move |(sub, entry)| Listed { at: Address::new(index, *sub), entry: entry.clone() })
        });
        entries.filter(|listed| listed.at.index.0 >= 0x1000).collect()
    }

    /// As [`listed`](Self::listed), of a quick judgement only every few of many.
    pub(super) fn some_listed(&self, wanted: impl Fn(&Listed) -> bool) -> Vec<Listed> {
        const FEW: usize = 100;
        let listed: Vec<Listed> = self.listed().into_iter().filter(wanted).collect();
        let step = if self.setup.quick { listed.len().div_ceil(FEW).max(1) } else { 1 };
        listed.into_iter().step_by(step).collect()
    }

    /// The octets of an entry that must be there.
    pub(super) fn value(&mut self, index: u16, sub: u8) -> Course<Vec<u8>> {
        let at = Address::new(index, sub);
        match self.upload(at)? {
            Ok(octets) => Ok(octets),
            Err(code) => broken(format!("a read of {at} is refused with {}", super::sdo::refused(code))),
        }
    }

    /// The number of an entry that must be there.
    pub(super) fn number(&mut self, index: u16, sub: u8) -> Course<u64> {
        Ok(whole(&self.value(index, sub)?))
    }

    /// The number of an entry, if it is there.
    pub(super) fn number_if(&mut self, index: u16, sub: u8) -> Course<Option<u64>> {
        if !self.has(index, sub)? {
            return Ok(None);
        }
        Ok(self.upload(Address::new(index, sub))?.ok().map(|octets| whole(&octets)))
    }
}

/// Whether values of this type have a length of their own.
pub(super) const fn is_text(data: DataType) -> bool {
    data.octets().is_none()
}
