//! A configuration split into modules (`gsd.md` 3.4 and 3.5).
//!
//! A file may offer `F3` and `F3 F1`, so the longest module first leads astray: every split is followed, over the
//! places (octet, slot), of which there are at most 244 x 244.

use super::{Gsd, Module, Slot};

/// The most slots: each takes an octet of a configuration.
const MAX_SLOTS: u16 = 244;

/// What is plugged, slot by slot: a place in [`Gsd::modules`], or `None` for 00 that the file does not have.
pub(super) type Plugged = Vec<Option<usize>>;

/// Where no module fits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Stuck {
    /// The octet, from 0.
    pub(super) index: usize,
    /// The octet that the nearest module has there.
    pub(super) expected: Option<u8>,
    /// Why, and what would fit.
    pub(super) words: String,
}

/// Splits a configuration into modules in slots, the longest modules first where several splits are right (G-07).
/// With `free_slots` an octet 00 is an empty slot even if the file has no such module (G-01).
pub(super) fn split(gsd: &Gsd, free_slots: bool, configuration: &[u8]) -> Result<Plugged, Stuck> {
    Splitter::new(gsd, free_slots, configuration).split()
}

/// The modules that must be first, in the order of the file.
pub(super) fn fixed_presets(gsd: &Gsd) -> Vec<usize> {
    let presets =
        gsd.modules.iter().enumerate().filter(|(_, module)| module.preset && gsd.flags.fixed_presets);
    presets.map(|(place, _)| place).collect()
}

/// How many modules fit.
pub(super) fn slot_count(gsd: &Gsd) -> u16 {
    gsd.max_module.unwrap_or(1).clamp(1, MAX_SLOTS)
}

struct Splitter<'a> {
    gsd: &'a Gsd,
    configuration: &'a [u8],
    /// The modules that begin at each octet, the longest first: length and place.
    begins: Vec<Vec<(usize, Option<usize>)>>,
    slots: usize,
    definitions: Vec<Option<&'a Slot>>,
    fixed: Vec<usize>,
}

impl<'a> Splitter<'a> {
    fn new(gsd: &'a Gsd, free_slots: bool, configuration: &'a [u8]) -> Self {
        let begins = (0..configuration.len()).map(|at| {
            let rest = configuration.get(at..).unwrap_or_default();
            let fits =
                |module: &Module| !module.identifiers.is_empty() && rest.starts_with(&module.identifiers);
            let modules = gsd.modules.iter().enumerate().filter(|(_, module)| fits(module));
            let mut begins: Vec<_> =
                modules.map(|(place, module)| (module.identifiers.len(), Some(place))).collect();
            if free_slots && rest.first() == Some(&0) {
                begins.push((1, None));
            }
            begins.sort_by_key(|(len, _)| core::cmp::Reverse(*len));
            begins
        });
        let slots = slot_count(gsd);
        // Slots count from 1, and in some files from 0.
        let base = u16::from(!gsd.slots.iter().any(|slot| slot.number == 0));
        let definition = |slot: u16| gsd.slots.iter().find(|definition| definition.number == slot + base);
        Self {
            gsd,
            configuration,
            begins: begins.collect(),
            slots: slots.into(),
            definitions: (0..slots).map(definition).collect(),
            fixed: fixed_presets(gsd),
        }
    }

    fn split(&self) -> Result<Plugged, Stuck> {
        let end = self.configuration.len();
        // Whether the octets from a place on can be split into the slots from a slot on.
        let width = self.slots + 1;
        let mut leads_on = vec![false; (end + 1) * width];
        for slot in self.fixed.len()..width {
            set(&mut leads_on, end * width + slot);
        }
        for at in (0..end).rev() {
            for slot in 0..self.slots {
                let goes_on = |(len, module): &(usize, Option<usize>)| {
                    is_set(&leads_on, (at + len) * width + slot + 1) && self.allows(slot, *module)
                };
                if self.begins_at(at).iter().any(goes_on) {
                    set(&mut leads_on, at * width + slot);
                }
            }
        }
        let (mut at, mut plugged) = (0, Vec::new());
        while at < end {
            let slot = plugged.len();
            let goes_on = |(len, module): &&(usize, Option<usize>)| {
                is_set(&leads_on, (at + len) * width + slot + 1) && self.allows(slot, *module)
            };
            let Some((len, module)) = self.begins_at(at).iter().find(goes_on) else {
                return Err(self.stuck());
            };
            plugged.push(*module);
            at += len;
        }
        if plugged.len() < self.fixed.len() { Err(self.stuck()) } else { Ok(plugged) }
    }

    fn begins_at(&self, at: usize) -> &[(usize, Option<usize>)] {
        self.begins.get(at).map(Vec::as_slice).unwrap_or_default()
    }

    fn allows(&self, slot: usize, module: Option<usize>) -> bool {
        if let Some(fixed) = self.fixed.get(slot) {
            return module == Some(*fixed);
        }
        match (self.definitions.get(slot).copied().flatten(), module) {
            (None, _) | (Some(_), None) => true,
            (Some(definition), Some(module)) => {
                definition.takes(self.gsd.modules.get(module).and_then(|module| module.reference))
            }
        }
    }

    /// The farthest place that some split reaches, and what is wrong there.
    fn stuck(&self) -> Stuck {
        let (end, width) = (self.configuration.len(), self.slots + 1);
        let mut reached = vec![false; (end + 1) * width];
        set(&mut reached, 0);
        let (mut at, mut slot) = (0, 0);
        for place in 0..=end {
            let Some(first) = (0..width).find(|slot| is_set(&reached, place * width + slot)) else {
                continue;
            };
            (at, slot) = (place, first);
            for slot in first..self.slots {
                if !is_set(&reached, place * width + slot) {
                    continue;
                }
                for (len, module) in self.begins_at(place) {
                    if self.allows(slot, *module) {
                        set(&mut reached, (place + len) * width + slot + 1);
                    }
                }
            }
        }
        self.explain(at, slot)
    }

    fn explain(&self, at: usize, slot: usize) -> Stuck {
        let number = slot + usize::from(self.gsd.slot_offset);
        if slot >= self.slots {
            let modules = if self.slots == 1 { "module" } else { "modules" };
            let words =
                format!("the station takes {} {modules} (Max_Module): take the others out", self.slots);
            return Stuck { index: at, expected: None, words };
        }
        let fixed = self.fixed.get(slot).and_then(|fixed| self.gsd.modules.get(*fixed));
        let candidates = match fixed {
            Some(fixed) => core::slice::from_ref(fixed),
            None => self.gsd.modules.as_slice(),
        };
        let place = match self.definitions.get(slot).copied().flatten() {
            Some(definition) => format!("slot {number} '{}'", definition.name),
            None => format!("slot {number}"),
        };
        let rest = self.configuration.get(at..).unwrap_or_default();
        if let (None, Some((_, Some(module)))) = (fixed, self.begins_at(at).first()) {
            let name = self.gsd.modules.get(*module).map(|module| module.name.as_str()).unwrap_or_default();
            let words = format!("module '{name}' may not be in {place}; expected {}", self.choice(slot));
            return Stuck { index: at, expected: None, words };
        }
        let agrees = |module: &Module| {
            module.identifiers.iter().zip(rest).take_while(|(one, other)| one == other).count()
        };
        let mut nearest: Option<(usize, &Module)> = None;
        for module in candidates.iter().filter(|module| !module.identifiers.is_empty()) {
            let octets = agrees(module);
            if nearest.is_none_or(|(most, _)| octets > most) {
                nearest = Some((octets, module));
            }
        }
        let Some((agreed, module)) = nearest else {
            return Stuck { index: at, expected: None, words: "the file has no module".into() };
        };
        if fixed.is_none() && agreed == 0 {
            let words = format!("{place}: no module begins with this; expected {}", self.choice(slot));
            return Stuck { index: at, expected: None, words };
        }
        let what = if fixed.is_some() { "the preset module is" } else { "the nearest module is" };
        let words =
            format!("{place}: no module fits; {what} '{}' ({})", module.name, hex(&module.identifiers));
        let expected = module.identifiers.get(agreed).copied();
        Stuck { index: at + agreed, expected, words }
    }

    /// The first modules that a slot takes, by name.
    fn choice(&self, slot: usize) -> String {
        let fits = self.gsd.modules.iter().enumerate().filter(|(place, _)| self.allows(slot, Some(*place)));
        let names: Vec<_> = fits.take(4).map(|(_, module)| format!("'{}'", module.name)).collect();
        if names.is_empty() { "nothing".into() } else { names.join(", ") }
    }
}

/// Octets as the file writes them.
pub(super) fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ")
}

fn set(flags: &mut [bool], place: usize) {
    if let Some(flag) = flags.get_mut(place) {
        *flag = true;
    }
}

fn is_set(flags: &[bool], place: usize) -> bool {
    flags.get(place).copied().unwrap_or(false)
}
