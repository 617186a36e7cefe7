//! The values of a node, and what it keeps over power-off.

use std::collections::BTreeMap;

use super::dictionary::{Dictionary, FIRST_OWN, Row};
use crate::can_bus::canopen::address::Sub;
use crate::can_bus::canopen::dictionary::Home;
use crate::can_bus::canopen::{Abort, Address, NodeId, Value};
use crate::eds::Content;

/// The most octets of all strings and domains that were written.
const MOST_LONG: usize = 4 << 20;
/// The most octets of what is kept: what an image has room for.
const MOST_KEPT: usize = 48 << 10;

/// Values by their place in the rows.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    node: NodeId,
    /// Those of a fixed length.
    numbers: Box<[[u8; 8]]>,
    /// Strings and domains that were written.
    long: BTreeMap<usize, Vec<u8>>,
    /// What was stored and is not the default.
    kept: BTreeMap<usize, Vec<u8>>,
    /// The value that is being written, until its last part.
    coming: Vec<u8>,
}

impl Memory {
    pub(super) fn new(dictionary: &Dictionary, node: NodeId) -> Self {
        let mut this = Self {
            node,
            numbers: vec![[0; 8]; dictionary.rows.len()].into(),
            long: BTreeMap::new(),
            kept: BTreeMap::new(),
            coming: Vec::new(),
        };
        for (place, row) in dictionary.rows.iter().enumerate() {
            this.make_default(place, row);
        }
        this
    }

    pub(super) fn read<'a>(&'a self, place: usize, row: &'a Row) -> Option<Value<'a>> {
        row.table.data.decode(self.octets(place, row))
    }

    /// As on the bus.
    fn octets<'a>(&'a self, place: usize, row: &'a Row) -> &'a [u8] {
        match row.table.data.octets() {
            Some(len) => self.numbers.get(place).and_then(|octets| octets.get(..len)).unwrap_or_default(),
            None => match (self.long.get(&place), &row.file.content) {
                (Some(octets), _) | (None, Content::Octets(octets)) => octets,
                (None, Content::None | Content::Whole(_) | Content::Real(_)) => &[],
            },
        }
    }

    /// Sets a value.
    ///
    /// # Errors
    /// [`Abort::MEMORY`]: all strings and domains together are too long.
    pub(super) fn set(&mut self, place: usize, row: &Row, octets: &[u8]) -> Result<(), Abort> {
        if row.table.data.octets().is_none() {
            let others = self.long.iter().filter(|(other, _)| **other != place);
            let held: usize = others.map(|(_, value)| value.len()).sum();
            if held.saturating_add(octets.len()) > MOST_LONG {
                return Err(Abort::MEMORY);
            }
            self.long.insert(place, octets.to_vec());
        } else if let Some(number) = self.numbers.get_mut(place) {
            number.iter_mut().zip(octets).for_each(|(to, from)| *to = *from);
        }
        Ok(())
    }

    /// Takes a part of a value; says the whole value behind its last part.
    ///
    /// # Errors
    /// [`Abort::TRANSFER`] if a part is missing.
    pub(super) fn take_part(
        &mut self,
        offset: usize,
        octets: &[u8],
        last: bool,
    ) -> Result<Option<Vec<u8>>, Abort> {
        if offset == 0 {
            self.coming.clear();
        }
        if offset != self.coming.len() {
            return Err(Abort::TRANSFER);
        }
        self.coming.extend_from_slice(octets);
        Ok(last.then(|| core::mem::take(&mut self.coming)))
    }

    /// The value of the file, or the kept one.
    pub(super) fn restore(&mut self, dictionary: &Dictionary, is_concerned: impl Fn(&Row) -> bool) {
        for (place, row) in dictionary.rows.iter().enumerate().filter(|(_, row)| is_concerned(row)) {
            self.make_default(place, row);
            if let Some(octets) = self.kept.get(&place).cloned() {
                // It was there before.
                let _ = self.set(place, row, &octets);
            }
        }
    }

    /// The node has this number from now on: `$NODEID` in a default.
    pub(super) const fn at_node(&mut self, node: NodeId) {
        self.node = node;
    }

    pub(super) fn make_default(&mut self, place: usize, row: &Row) {
        self.long.remove(&place);
        if row.table.data.octets().is_some()
            && let Some(number) = self.numbers.get_mut(place)
        {
            *number = [0; 8];
            let octets = row.file.octets(self.node);
            number.iter_mut().zip(octets).for_each(|(to, from)| *to = from);
        }
    }

    /// Stores the values of a group of 1010h.
    ///
    /// # Errors
    /// [`Abort::HARDWARE`]: it is more than can be kept; nothing is stored then.
    pub(super) fn store(&mut self, dictionary: &Dictionary, group: Sub) -> Result<(), Abort> {
        let mut kept = self.kept.clone();
        for (place, row) in rows_of(dictionary, group) {
            let octets = self.octets(place, row);
            if octets == row.file.octets(self.node) {
                kept.remove(&place);
            } else {
                kept.insert(place, octets.to_vec());
            }
        }
        let len: usize = kept.values().map(|octets| octets.len() + 5).sum();
        if len > MOST_KEPT {
            return Err(Abort::HARDWARE);
        }
        self.kept = kept;
        Ok(())
    }

    /// Forgets what is kept of a group of 1011h.
    pub(super) fn forget(&mut self, dictionary: &Dictionary, group: Sub) {
        for (place, _) in rows_of(dictionary, group) {
            self.kept.remove(&place);
        }
    }

    /// Takes a kept value over from an image.
    pub(super) fn keep(&mut self, place: usize, octets: &[u8]) {
        self.kept.insert(place, octets.to_vec());
    }

    pub(super) fn kept<'a>(&'a self, place: usize, row: &Row) -> Option<Value<'a>> {
        row.table.data.decode(self.kept.get(&place)?)
    }
}

/// What a sub-index of 1010h and 1011h concerns: 1 all, 2 communication, 3 application, 4 and up manufacturer.
fn rows_of(dictionary: &Dictionary, group: Sub) -> impl Iterator<Item = (usize, &Row)> {
    let apart = dictionary.has_manufacturer_group;
    let is_of = move |at: Address| match (group.0, at.index.0) {
        (1, _) | (2, ..FIRST_OWN) => true,
        (3, 0x2000..0x6000) => !apart,
        (3, 0x6000..) | (4.., 0x2000..0x6000) => true,
        (0 | 2.., _) => false,
    };
    let rows = dictionary.rows.iter().enumerate();
    rows.filter(move |(_, row)| row.table.stored && row.table.home == Home::Application && is_of(row.at))
}
