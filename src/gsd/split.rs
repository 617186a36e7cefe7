//! A configuration split into modules (`gsd.md` 3.4 and 3.5).
//!
//! A file may offer `F3` and `F3 F1`, so the longest module first leads astray; and most modules have a twin with the same
//! identifiers, so the octets alone do not say which one it is. Every reading is followed at once, over the places (octet,
//! slot), of which there are at most 244 x 244, each with the octets of Set_Prm where its parameters may begin.

use std::collections::{BTreeMap, BTreeSet};

use super::agreement::{Agreement, Positions, UserPrm};
use super::{Gsd, Module, Slot};

/// The most slots: each takes an octet of a configuration.
const MAX_SLOTS: u16 = 244;

/// What is plugged, slot by slot: places in [`Gsd::modules`]. Several: what the master sent admits each of them. None: 00
/// that the file does not have.
pub(super) type Plugged = Vec<Vec<usize>>;

/// The modules of a configuration, as far as the master's octets decide.
#[derive(Clone, Debug)]
pub(super) struct Reading {
    /// Slot by slot. The first of a slot has the octets that the slot has; a shorter one behind it would lead to other slots.
    pub(super) plugged: Plugged,
    /// How far the user parameters agree.
    pub(super) agreement: Agreement,
    /// The modules of one reading that agrees so far, in their order.
    one: Vec<usize>,
}

impl Reading {
    /// Of modules that are known.
    pub(super) fn of(gsd: &Gsd, plugged: &[Option<usize>], prm: Option<UserPrm<'_>>) -> Self {
        let modules: Vec<usize> = plugged.iter().copied().flatten().collect();
        let agreement = prm.map_or(Agreement::Open, |prm| {
            let parts =
                || modules.iter().filter_map(|place| gsd.modules.get(*place)).map(|module| &module.prm);
            let agrees = |agreement: &Agreement| prm.agrees(gsd, parts(), *agreement);
            Agreement::BEST_FIRST.into_iter().find(agrees).unwrap_or(Agreement::Open)
        });
        let plugged = plugged.iter().map(|place| place.iter().copied().collect()).collect();
        Self { plugged, agreement, one: modules }
    }

    /// The modules of one reading.
    pub(super) fn modules<'a>(&'a self, gsd: &'a Gsd) -> impl Iterator<Item = &'a Module> {
        self.one.iter().filter_map(|place| gsd.modules.get(*place))
    }

    /// Their places, one for each slot that has a module.
    pub(super) fn known(&self) -> impl Iterator<Item = usize> + '_ {
        self.one.iter().copied()
    }

    /// The octets of user parameters that they have.
    pub(super) fn extent(&self, gsd: &Gsd) -> usize {
        self.modules(gsd).map(|module| module.prm.extent(gsd)).sum()
    }
}

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

/// Splits a configuration into modules in slots: those that the user parameters agree with best, and of these the longest
/// first (G-07). With `free_slots` an octet 00 is an empty slot even if the file has no such module (G-01).
pub(super) fn split(
    gsd: &Gsd,
    free_slots: bool,
    configuration: &[u8],
    prm: Option<UserPrm<'_>>,
) -> Result<Reading, Stuck> {
    Splitter::new(gsd, free_slots, configuration).split(prm)
}

/// Whether a station of the file may have these modules, slot by slot, and if not, why.
pub(super) fn admits(gsd: &Gsd, modules: &[Option<usize>]) -> Result<(), String> {
    let splitter = Splitter::new(gsd, false, &[]);
    let wrong =
        |(slot, module): &(usize, &Option<usize>)| module.is_some() && !splitter.allows(*slot, **module);
    match modules.iter().enumerate().find(wrong) {
        _ if modules.len() > splitter.slots => Err(splitter.too_many()),
        Some((slot, module)) => Err(splitter.not_allowed(slot, module.unwrap_or_default())),
        None if modules.len() < splitter.fixed.len() => {
            let presets: Vec<_> = splitter.fixed.iter().filter_map(|place| gsd.modules.get(*place)).collect();
            let names: Vec<_> = presets.iter().map(|module| format!("'{}'", module.name)).collect();
            Err(format!("the first modules are preset: {}", names.join(", ")))
        }
        None => Ok(()),
    }
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

    fn split(&self, prm: Option<UserPrm<'_>>) -> Result<Reading, Stuck> {
        let reading = prm.and_then(|prm| {
            // Without the length nothing else agrees.
            let length = self.read(prm, Agreement::Length)?;
            let better = [Agreement::Constants, Agreement::Values];
            better.into_iter().find_map(|agreement| self.read(prm, agreement)).or(Some(length))
        });
        let open = || self.read(UserPrm::default(), Agreement::Open);
        reading.or_else(open).ok_or_else(|| self.stuck())
    }

    /// The readings with which the user parameters agree so far; `None` if there is none.
    fn read(&self, prm: UserPrm<'_>, agreement: Agreement) -> Option<Reading> {
        let ways = Ways::new(self, prm, agreement);
        let begin = ways.from(0, 0) & Positions::one(prm.start);
        if begin == Positions::NONE {
            return None;
        }
        let (mut at, mut places, mut plugged) = (0, begin, Vec::new());
        while at < self.configuration.len() {
            let (mut taken, mut next, mut modules) = (1, Positions::NONE, Vec::new());
            for (way, (len, module)) in ways.on(at, plugged.len(), places).enumerate() {
                taken = if way == 0 { len.0 } else { taken };
                if len.0 == taken {
                    next = next | len.1;
                }
                modules.extend(module);
            }
            plugged.push(modules);
            (at, places) = (at + taken, next);
        }
        let (mut at, mut places, mut slot, mut one) = (0, begin, 0, Vec::new());
        while let Some(((len, next), module)) = ways.on(at, slot, places).next() {
            one.extend(module);
            (at, places, slot) = (at + len, next, slot + 1);
        }
        Some(Reading { plugged, agreement, one })
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
        if slot >= self.slots {
            return Stuck { index: at, expected: None, words: self.too_many() };
        }
        let fixed = self.fixed.get(slot).and_then(|fixed| self.gsd.modules.get(*fixed));
        let candidates = match fixed {
            Some(fixed) => core::slice::from_ref(fixed),
            None => self.gsd.modules.as_slice(),
        };
        let place = self.place(slot);
        let rest = self.configuration.get(at..).unwrap_or_default();
        if let (None, Some((_, Some(module)))) = (fixed, self.begins_at(at).first()) {
            return Stuck { index: at, expected: None, words: self.not_allowed(slot, *module) };
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

    fn too_many(&self) -> String {
        let modules = if self.slots == 1 { "module" } else { "modules" };
        format!("the station takes {} {modules} (Max_Module): take the others out", self.slots)
    }

    /// A slot in words.
    fn place(&self, slot: usize) -> String {
        let number = slot + usize::from(self.gsd.slot_offset);
        match self.definitions.get(slot).copied().flatten() {
            Some(definition) => format!("slot {number} '{}'", definition.name),
            None => format!("slot {number}"),
        }
    }

    fn not_allowed(&self, slot: usize, module: usize) -> String {
        let name = self.gsd.modules.get(module).map(|module| module.name.as_str()).unwrap_or_default();
        format!("module '{name}' may not be in {}; expected {}", self.place(slot), self.choice(slot))
    }

    /// The first modules that a slot takes, by name.
    fn choice(&self, slot: usize) -> String {
        let fits = self.gsd.modules.iter().enumerate().filter(|(place, _)| self.allows(slot, Some(*place)));
        let names: Vec<_> = fits.take(4).map(|(_, module)| format!("'{}'", module.name)).collect();
        if names.is_empty() { "nothing".into() } else { names.join(", ") }
    }
}

/// The ways through a configuration with which the user parameters agree.
struct Ways<'a> {
    splitter: &'a Splitter<'a>,
    /// Each module that begins somewhere: where its parameters may begin, and how many octets they have.
    parts: BTreeMap<usize, (Positions, usize)>,
    /// The octets of Set_Prm from which the end can be reached, for each place (octet, slot).
    leads_on: Vec<Positions>,
    width: usize,
}

impl<'a> Ways<'a> {
    fn new(splitter: &'a Splitter<'a>, prm: UserPrm<'_>, agreement: Agreement) -> Self {
        let end = splitter.configuration.len();
        let slots = splitter.slots.min(end);
        let width = slots + 1;
        let begins = splitter.begins.iter().flatten().filter_map(|(_, module)| *module);
        let extent = |place: usize| {
            let part = &splitter.gsd.modules.get(place)?.prm;
            let octets = if agreement == Agreement::Open { 0 } else { part.extent(splitter.gsd) };
            Some((place, (Positions::NONE, octets)))
        };
        let parts = begins.collect::<BTreeSet<_>>().into_iter().filter_map(extent).collect();
        let mut this = Self { splitter, parts, leads_on: vec![Positions::NONE; (end + 1) * width], width };
        this.reach(prm.start, slots);
        for (place, (positions, _)) in &mut this.parts {
            if let Some(module) = splitter.gsd.modules.get(*place) {
                *positions = prm.places(splitter.gsd, &module.prm, agreement, *positions);
            }
        }
        for slot in splitter.fixed.len()..width {
            this.set(end, slot, prm.end(agreement));
        }
        for at in (0..end).rev() {
            for slot in 0..slots {
                let mut here = Positions::NONE;
                for (len, module) in splitter.begins_at(at) {
                    if splitter.allows(slot, *module) {
                        let (fits, octets) = this.part(*module);
                        here = here | (this.from(at + len, slot + 1).down(octets) & fits);
                    }
                }
                this.set(at, slot, here);
            }
        }
        this
    }

    /// Where the parameters of each module may begin by the lengths of those before.
    fn reach(&mut self, start: usize, slots: usize) {
        let mut reached = BTreeMap::from([((0, 0), Positions::one(start))]);
        while let Some(((at, slot), here)) = reached.pop_first() {
            for (len, module) in self.splitter.begins_at(at) {
                if slot >= slots || !self.splitter.allows(slot, *module) {
                    continue;
                }
                let part = module.and_then(|module| self.parts.get_mut(&module));
                let octets = part.map_or(0, |(positions, octets)| {
                    *positions = *positions | here;
                    *octets
                });
                let next = reached.entry((at + len, slot + 1)).or_insert(Positions::NONE);
                *next = *next | here.up(octets);
            }
        }
    }

    fn set(&mut self, at: usize, slot: usize, positions: Positions) {
        if let Some(place) = self.leads_on.get_mut(at * self.width + slot) {
            *place = positions;
        }
    }

    /// Where in Set_Prm the parameters of the module at a place may begin.
    fn from(&self, at: usize, slot: usize) -> Positions {
        self.leads_on.get(at * self.width + slot).copied().unwrap_or(Positions::NONE)
    }

    /// An empty slot has no parameters.
    fn part(&self, module: Option<usize>) -> (Positions, usize) {
        module.and_then(|place| self.parts.get(&place).copied()).unwrap_or((Positions::ALL, 0))
    }

    /// The modules that lead on from a place, the longest first: their octets, where their parameters may end, and which.
    fn on(
        &self,
        at: usize,
        slot: usize,
        places: Positions,
    ) -> impl Iterator<Item = ((usize, Positions), Option<usize>)> + '_ {
        let all = self.splitter.begins_at(at).iter();
        let allowed = all.filter(move |(_, module)| self.splitter.allows(slot, *module));
        allowed.filter_map(move |(len, module)| {
            let (fits, octets) = self.part(*module);
            let after = (places & fits).up(octets) & self.from(at + len, slot + 1);
            (after != Positions::NONE).then_some(((*len, after), *module))
        })
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
