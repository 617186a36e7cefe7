//! Where the octets of each module lie in a configuration and in the process image.

use core::ops::Range;

use super::{Gsd, Station};
use crate::process::Slot;
use crate::profibus::dp::IoLengths;
use crate::profibus::dp::chk_cfg::identifiers;

/// A module in its slot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Placed {
    /// Its place in [`Gsd::modules`]. Several: modules between which the master's octets do not decide. None: an empty slot
    /// that the file does not have.
    pub modules: Vec<usize>,
    /// Its octets in the configuration.
    pub octets: Range<usize>,
    /// Which of the identifiers of the configuration are its own, counted from 0: the bits of the identifier-related
    /// diagnosis.
    pub identifiers: Range<usize>,
    /// The number of the slot, and the octets in the process image.
    pub slot: Slot,
}

impl Placed {
    /// The names that it may have, each once.
    pub fn names<'a>(&self, gsd: &'a Gsd) -> Vec<&'a str> {
        let mut names = Vec::new();
        for module in self.modules.iter().filter_map(|place| gsd.modules.get(*place)) {
            if !names.contains(&module.name.as_str()) {
                names.push(module.name.as_str());
            }
        }
        names
    }

    /// Its name, or those that it may have.
    pub fn name(&self, gsd: &Gsd) -> String {
        const SHOWN: usize = 4;
        let names = self.names(gsd);
        match names.split_last() {
            None => "empty slot".to_owned(),
            Some((only, [])) => (*only).to_owned(),
            Some((last, others)) if names.len() <= SHOWN => format!("{} or {last}", others.join(", ")),
            Some(_) => {
                let shown = names.get(..SHOWN).unwrap_or_default();
                format!("{} or one of {} more", shown.join(", "), names.len() - SHOWN)
            }
        }
    }
}

impl Station {
    /// The modules of a configuration, slot by slot, as far as these user parameters decide between modules with equal
    /// identifiers; empty if it is not accepted. The first slot has the number [`Gsd::slot_offset`]. A station whose file has
    /// no modules has one slot with all octets.
    pub fn layout(&self, configuration: &[u8], user_prm: Option<&[u8]>) -> Vec<Placed> {
        let Ok(modules) = self.modules(configuration, user_prm) else { return Vec::new() };
        let gsd = self.gsd();
        let lengths = modules.iter().map(|modules| {
            let module = modules.first().and_then(|module| gsd.modules.get(*module));
            module.map_or(1, |module| module.identifiers.len())
        });
        let lengths: Vec<_> =
            if modules.is_empty() { [configuration.len()].into() } else { lengths.collect() };
        let (mut at, mut identifier, mut input, mut output) = (0, 0, 0, 0);
        let mut place = |(len, number): (usize, u16)| {
            let octets = at..at + len;
            let own = configuration.get(octets.clone()).unwrap_or_default();
            let IoLengths { inputs, outputs } = IoLengths::of(own).unwrap_or_default();
            let (inputs, outputs) =
                (input..input + usize::from(inputs), output..output + usize::from(outputs));
            let count = identifier + identifiers(own).count();
            let placed = Placed {
                modules: modules.get(usize::from(number)).cloned().unwrap_or_default(),
                octets,
                identifiers: identifier..count,
                slot: Slot {
                    number: number.saturating_add(gsd.slot_offset),
                    inputs: inputs.clone(),
                    outputs: outputs.clone(),
                },
            };
            (at, identifier, input, output) = (at + len, count, inputs.end, outputs.end);
            placed
        };
        lengths.into_iter().zip(0..).map(&mut place).collect()
    }
}
