//! The parameters of the table as the object dictionary of the AG03/1 has them (`canopen-ag03.md` 11).

use super::table::{ROWS, Row, rows_by_parameter, rows_by_reading};
use super::{Entry, Kind, Parameter, Reading, Setting};
use crate::face::ObjectEntry;

/// The parameters by their place; every one has one.
pub(crate) static PARAMETERS: [((u16, u8), Parameter); Parameter::COUNT] = parameters();
/// The read-outs by their place.
pub(crate) static READINGS: [((u16, u8), Reading); SHOWN] = readings();

/// How many read-outs have a place.
const SHOWN: usize = shown();

impl Parameter {
    /// What its row says, and its place in the object dictionary. For tables that the compiler makes.
    pub(crate) const fn on_canopen(self) -> (Setting, bool, ObjectEntry) {
        let (entry, object) = row(rows_by_parameter(), self as usize);
        match entry.kind {
            Kind::Setting(setting) => (setting, entry.persistent, object),
            Kind::Reading(_) | Kind::LoadParameterSet => panic!("the row of a stored parameter holds none"),
        }
    }
}

impl Reading {
    /// Its place in the object dictionary. For tables that the compiler makes; there it must have one.
    pub(crate) const fn on_canopen(self) -> ObjectEntry {
        let (_, object) = row(rows_by_reading(), self as usize);
        object
    }
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn row<const N: usize>(rows: [u8; N], number: usize) -> (Entry, ObjectEntry) {
    let Row { entry, object } = ROWS[rows[number] as usize];
    match object {
        Some(object) => (entry, object),
        None => panic!("the object dictionary does not have it"),
    }
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn parameters() -> [((u16, u8), Parameter); Parameter::COUNT] {
    let mut places = [((0, 0), Parameter::ControllerP); Parameter::COUNT];
    let (mut row, mut found) = (0, 0);
    while row < ROWS.len() {
        let Row { entry, object } = ROWS[row];
        if let (Kind::Setting(setting), Some(object)) = (entry.kind, object) {
            places[found] = (object.at, setting.parameter);
            found += 1;
        }
        row += 1;
    }
    assert!(found == places.len(), "a parameter has no place");
    places
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn shown() -> usize {
    let (mut row, mut count) = (0, 0);
    while row < ROWS.len() {
        if let Row { entry: Entry { kind: Kind::Reading(_), .. }, object: Some(_) } = ROWS[row] {
            count += 1;
        }
        row += 1;
    }
    count
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn readings() -> [((u16, u8), Reading); SHOWN] {
    let mut places = [((0, 0), Reading::Position); SHOWN];
    let (mut row, mut found) = (0, 0);
    while row < ROWS.len() {
        let Row { entry, object } = ROWS[row];
        if let (Kind::Reading(reading), Some(object)) = (entry.kind, object) {
            places[found] = (object.at, reading);
            found += 1;
        }
        row += 1;
    }
    places
}
