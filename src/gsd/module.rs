//! Modules and the slots they may be in.

use super::hint::Place;
use super::parameter::PrmPart;
use crate::profibus::dp::IoLengths;

/// A module: identifiers that a master sends together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Module {
    /// Where it begins.
    pub place: Place,
    /// Its name.
    pub name: String,
    /// Its octets in Chk_Cfg.
    pub identifiers: Vec<u8>,
    /// What it exchanges.
    pub lengths: IoLengths,
    /// Module_Reference: the line that is only a number.
    pub reference: Option<u32>,
    /// Preset.
    pub preset: bool,
    /// Its part of the user parameters.
    pub prm: PrmPart,
    /// Info_Text.
    pub info: String,
    /// It has parameters of PROFIsafe, which is not emulated.
    pub safety: bool,
}

/// What may be in a slot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Its number, of the first module usually 1.
    pub number: u16,
    /// Its name.
    pub name: String,
    /// The module reference that a project begins with.
    pub default: Option<u32>,
    /// The module references it takes, each from the first to the second.
    pub references: Vec<(u32, u32)>,
}

impl Slot {
    /// Whether the slot takes a module with this reference.
    pub(crate) fn takes(&self, reference: Option<u32>) -> bool {
        let is_in =
            |wanted: u32| self.references.iter().any(|(first, last)| (*first..=*last).contains(&wanted));
        reference.is_some_and(|reference| is_in(reference) || self.default == Some(reference))
    }
}
