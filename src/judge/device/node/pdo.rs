//! The PDOs of the node: identifiers, transmission types, mappings.

use core::time::Duration;

use super::Tester;
use super::objects::Listed;
use super::wire::Passed;
use crate::can_bus::can::Id;
use crate::can_bus::canopen::Address;
use crate::can_bus::canopen::cob_id::CobId;
use crate::eds::Rights;
use crate::judge::device::course::{Course, inapplicable};

/// The most PDOs of a direction that are tried.
const MOST: u16 = 8;

/// The direction of a PDO, as the node sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    Received,
    Sent,
}

/// A PDO.
#[derive(Clone, Debug)]
pub(super) struct Pdo {
    way: Way,
    /// From 0 on.
    number: u16,
    /// The entries that are mapped: index << 16 | sub-index << 8 | bits.
    pub(super) entries: Vec<u32>,
}

impl Pdo {
    /// The object of its communication parameters.
    pub(super) const fn parameters(&self) -> u16 {
        match self.way {
            Way::Received => 0x1400 + self.number,
            Way::Sent => 0x1800 + self.number,
        }
    }

    /// The object of its mapping.
    pub(super) const fn mapping(&self) -> u16 {
        self.parameters() + 0x200
    }

    /// How many octets it has.
    pub(super) fn len(&self) -> usize {
        let bits: u32 = self.entries.iter().map(|entry| entry & 0xFF).sum();
        usize::try_from(bits.div_ceil(8)).unwrap_or_default()
    }

    /// Where each entry lies, if all are whole octets: its address, and the octets.
    pub(super) fn places(&self) -> Option<Vec<(Address, core::ops::Range<usize>)>> {
        let mut begin = 0;
        let place = |entry: &u32| {
            let len = usize::try_from((entry & 0xFF) / 8).unwrap_or_default();
            let [_, sub, low, high] = entry.to_le_bytes();
            let place = (Address::new(u16::from_le_bytes([low, high]), sub), begin..begin + len);
            begin += len;
            place
        };
        let whole = self.entries.iter().all(|entry| entry & 0x07 == 0);
        whole.then(|| self.entries.iter().map(place).collect())
    }

    /// The same with one entry alone.
    pub(super) fn of(self, entry: u32) -> Self {
        Self { entries: vec![entry], ..self }
    }

    /// The identifier of the predefined connection set; `None`: there is none for it.
    fn predefined(&self, node: u8) -> Option<u32> {
        let base = match self.way {
            Way::Received => 0x200,
            Way::Sent => 0x180,
        };
        (self.number < 4).then(|| base + 0x100 * u32::from(self.number) + u32::from(node))
    }
}

impl Tester {
    /// The PDOs of that direction, the first few.
    pub(super) fn pdos(&mut self, way: Way) -> Course<Vec<Pdo>> {
        let mut pdos = Vec::new();
        for number in 0..MOST {
            let mut pdo = Pdo { way, number, entries: Vec::new() };
            if !self.has(pdo.parameters(), 1)? || !self.has(pdo.mapping(), 0)? {
                continue;
            }
            let count = self.number_if(pdo.mapping(), 0)?.unwrap_or_default();
            for sub in 1..=u8::try_from(count.min(64)).unwrap_or_default() {
                let entry = self.number_if(pdo.mapping(), sub)?.unwrap_or_default();
                pdo.entries.push(u32::try_from(entry).unwrap_or_default());
            }
            if pdo.len() <= 8 {
                pdos.push(pdo);
            }
        }
        Ok(pdos)
    }

    /// The first PDO of that direction whose identifier and type can be set.
    pub(super) fn a_pdo(&mut self, way: Way) -> Course<Pdo> {
        self.may_write()?;
        let mut candidates = Vec::new();
        for pdo in self.pdos(way)? {
            if self.is_writable(pdo.parameters(), 1)? && self.is_writable(pdo.parameters(), 2)? {
                candidates.push(pdo);
            }
        }
        if let Some(pdo) = candidates.iter().find(|pdo| !pdo.entries.is_empty()) {
            return Ok(pdo.clone());
        }
        for mut pdo in candidates {
            if self.is_writable(pdo.mapping(), 0)? && self.map_something(&mut pdo)? {
                return Ok(pdo);
            }
        }
        inapplicable(match way {
            Way::Received => "it has no RPDO with a mapping whose identifier and type can be written",
            Way::Sent => "it has no TPDO with a mapping whose identifier and type can be written",
        })
    }

    /// Maps the first entry that the node takes; false: it takes none of a few.
    fn map_something(&mut self, pdo: &mut Pdo) -> Course<bool> {
        const FEW: usize = 5;
        let way = pdo.way;
        let fits = |listed: &Listed| {
            let rights = listed.entry.rights;
            let right = match way {
                Way::Received => rights.is_writable() && rights != Rights::ReadWriteSent,
                Way::Sent => rights != Rights::ReadWriteReceived,
            };
            listed.entry.mappable
                && rights.is_readable()
                && right
                && listed.size().is_some_and(|size| size <= 8)
        };
        let listed: Vec<Listed> = self.listed().into_iter().filter(fits).take(FEW).collect();
        for Listed { at, entry } in listed {
            let bits = u8::try_from(entry.data.octets().unwrap_or_default() * 8).unwrap_or_default();
            let [low, high] = at.index.0.to_le_bytes();
            let entry = u32::from_le_bytes([bits, at.sub.0, low, high]);
            if self.maps(pdo, entry)? {
                pdo.entries = vec![entry];
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Has a PDO, which is off then, map one entry alone: whether the node takes that.
    pub(super) fn maps(&mut self, pdo: &Pdo, entry: u32) -> Course<bool> {
        self.switch_off(pdo)?;
        Ok(self.try_set(pdo.mapping(), 0, &[0])?.is_ok()
            && self.try_set(pdo.mapping(), 1, &entry.to_le_bytes())?.is_ok()
            && self.try_set(pdo.mapping(), 0, &[1])?.is_ok())
    }

    /// The identifier of a PDO as its object has it.
    pub(super) fn cob_id(&mut self, pdo: &Pdo) -> Course<u32> {
        let number = self.number(pdo.parameters(), 1)?;
        Ok(u32::try_from(number).unwrap_or_default())
    }

    /// Writes the identifier of a PDO.
    pub(super) fn set_cob_id(&mut self, pdo: &Pdo, cob_id: u32) -> Course {
        self.set(pdo.parameters(), 1, &cob_id.to_le_bytes())
    }

    /// Switches a PDO off.
    pub(super) fn switch_off(&mut self, pdo: &Pdo) -> Course {
        let cob_id = self.cob_id(pdo)?;
        if CobId(cob_id).is_valid() { self.set_cob_id(pdo, cob_id | CobId::INVALID) } else { Ok(()) }
    }

    /// Switches all TPDOs but this off, so that nothing else comes.
    pub(super) fn alone(&mut self, pdo: &Pdo) -> Course {
        for other in self.pdos(Way::Sent)? {
            if other.parameters() != pdo.parameters() && self.is_writable(other.parameters(), 1)? {
                self.switch_off(&other)?;
            }
        }
        Ok(())
    }

    /// Switches a PDO on with this transmission type. A type that the node refuses it has not.
    pub(super) fn switch_on(&mut self, pdo: &Pdo, kind: u8) -> Course<Id> {
        let cob_id = self.cob_id(pdo)?;
        self.switch_off(pdo)?;
        if self.number(pdo.parameters(), 2)? != u64::from(kind)
            && let Err(code) = self.try_set(pdo.parameters(), 2, &[kind])?
        {
            let why = super::sdo::refused(code);
            return inapplicable(format!("it refuses transmission type {kind} with {why}"));
        }
        let mut on = cob_id & !CobId::INVALID;
        if on & 0x1FFF_FFFF == 0 || CobId(on & 0x7FF).is_restricted() {
            let Some(predefined) = pdo.predefined(self.node().number()) else {
                return inapplicable("its PDO has no identifier");
            };
            on = on & 0x6000_0000 | predefined;
        }
        self.set_cob_id(pdo, on)?;
        match CobId(on).active() {
            Some(id) => Ok(id),
            None => inapplicable("its PDO has no identifier"),
        }
    }

    /// The values of the entries of a PDO, as SDO shows them; `None`: some entry cannot be read, or is no whole octets.
    pub(super) fn shown_by_sdo(&mut self, pdo: &Pdo) -> Course<Option<Vec<u8>>> {
        let Some(places) = pdo.places() else { return Ok(None) };
        let mut all = Vec::new();
        for (at, place) in places {
            if at.index.0 < 0x1000 {
                all.extend(core::iter::repeat_n(0, place.len()));
                continue;
            }
            match self.upload(at)? {
                Ok(octets) if octets.len() == place.len() => all.extend(octets),
                Ok(_) | Err(_) => return Ok(None),
            }
        }
        Ok(Some(all))
    }

    /// Sends a SYNC.
    pub(super) fn sync(&mut self) -> Course {
        let id = self.sync_id()?;
        self.send(id, &[])
    }

    /// The identifier of SYNC.
    pub(super) fn sync_id(&mut self) -> Course<Id> {
        let is_own = !self.is_written(Address::new(0x1005, 0));
        if let Some(id) = self.known.sync.filter(|_| is_own) {
            return Ok(id);
        }
        let number = self.number_if(0x1005, 0)?.unwrap_or(0x80);
        let cob_id = CobId(u32::try_from(number).unwrap_or(0x80) & !CobId::INVALID);
        match cob_id.id() {
            Some(id) => {
                self.known.sync = is_own.then_some(id);
                Ok(id)
            }
            None => inapplicable("1005h has no identifier"),
        }
    }

    /// The frames with this identifier that come in this time.
    pub(super) fn come(&mut self, id: Id, time: Duration) -> Course<Vec<Passed>> {
        let all = self.collect(time)?;
        Ok(all.into_iter().filter(|passed| passed.frame.id() == id && !passed.frame.is_remote()).collect())
    }
}
