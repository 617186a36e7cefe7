//! Where the octets of each module lie in a configuration and in the process image.

use core::ops::Range;

use super::{Gsd, Station};
use crate::process::Slot;
use crate::profibus::dp::IoLengths;
use crate::profibus::dp::chk_cfg::identifiers;

/// A module in its slot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Placed {
    /// Its place in [`Gsd::modules`]; `None`: an empty slot that the file does not have.
    pub module: Option<usize>,
    /// Its octets in the configuration.
    pub octets: Range<usize>,
    /// Which of the identifiers of the configuration are its own, counted from 0: the bits of the identifier-related
    /// diagnosis.
    pub identifiers: Range<usize>,
    /// The number of the slot, and the octets in the process image.
    pub slot: Slot,
}

impl Placed {
    /// The name of the module.
    pub fn name<'a>(&self, gsd: &'a Gsd) -> &'a str {
        let module = self.module.and_then(|module| gsd.modules.get(module));
        module.map_or("empty slot", |module| &module.name)
    }
}

impl Station {
    /// The modules of a configuration, slot by slot; empty if it is not accepted. The first slot has the number
    /// [`Gsd::slot_offset`]. A station whose file has no modules has one slot with all octets.
    pub fn layout(&self, configuration: &[u8]) -> Vec<Placed> {
        let Some(modules) = self.split(configuration) else { return Vec::new() };
        let gsd = self.gsd();
        let lengths = modules.iter().map(|module| {
            let module = module.and_then(|module| gsd.modules.get(module));
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
                module: modules.get(usize::from(number)).copied().flatten(),
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
