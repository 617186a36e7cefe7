//! The parameters that a drive begins with, before there is one.

use super::table::{Source, Table};
use crate::devices::ppo_drive::table::Row;
use crate::profibus::dpv1::base_mode::Format;

/// The parameters of every drive and those of a file, with their first values.
#[derive(Clone, Debug)]
pub struct Family(pub(super) Table);

/// A parameter that can begin with another value.
#[derive(Clone, Debug)]
pub(crate) struct Settable {
    /// Its number.
    pub(crate) number: u16,
    /// Its name.
    pub(crate) name: String,
    /// How many elements it has, from 0; `None`: it is no array.
    pub(crate) elements: Option<u8>,
}

impl Family {
    /// Those of every drive, and these; of two with the same number this one stands.
    ///
    /// # Errors
    /// What the drive does not have, or a first value that it does not take.
    pub fn new(rows: &[Row]) -> Result<Self, String> {
        Table::new(rows).map(Self)
    }

    /// Each parameter that can begin with another value.
    pub(crate) fn settable(&self) -> Vec<Settable> {
        let settable = self.0.entries().filter(|(_, entry)| entry.is_kept());
        settable
            .map(|(number, entry)| Settable {
                number,
                name: entry.name.to_string(),
                elements: entry.elements.map(|count| u8::try_from(count).unwrap_or(u8::MAX)),
            })
            .collect()
    }

    /// A parameter begins with this value, as a number on the bus.
    ///
    /// # Errors
    /// Why it cannot.
    pub(crate) fn begin_with(&mut self, pnu: u16, element: u8, number: f64) -> Result<(), String> {
        let entry = self.0.entry_mut(pnu).ok_or_else(|| format!("there is no parameter {pnu}"))?;
        let (low, high) = entry.limits;
        if !(low..=high).contains(&number) {
            return Err(format!("{number} is outside {low} to {high} (min and max, as numbers on the bus)"));
        }
        if entry.format != Format::FLOAT && number.fract() != 0.0 {
            return Err(format!("{number} is no whole number; give the number on the bus"));
        }
        match &mut entry.source {
            Source::Own { values, first } => {
                let places =
                    [values, first].into_iter().flat_map(|all| all.iter_mut().skip(element.into()).take(1));
                places.for_each(|place| *place = number);
            }
            Source::Setting(setting) => {
                let (setting, first) = (*setting, number * entry.scale);
                self.0.begin_with(setting, first)?;
            }
            Source::Block(_) => return Err("a traversing block is written by record 47".to_owned()),
            Source::Profile(_) | Source::Actual(_) => return Err("it can only be read".to_owned()),
        }
        Ok(())
    }
}
