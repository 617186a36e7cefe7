//! The P-parameters of the drive that are no setting: they are kept and read back, and have no effect.
//!
//! A start-up list of a machine writes many of them. The guide has the rule for their places (P a-bc is 2aXXh, XX = bc in
//! hexadecimal) and their two types, but no list: the numbers are those that the drive has, the type is INTEGER32 in the
//! groups 5 to 7 (positions and paths), else INTEGER16 (CN-237, CN-238).

use super::settings::Setting;
use crate::face::DataType::{I16, I32};
use crate::face::ObjectEntry;

/// The last number of each group, from 0 on.
const LAST: [u8; 8] = [46, 77, 71, 12, 24, 99, 99, 27];
/// From this group on a parameter has 32 bits.
const FIRST_WIDE: usize = 5;

/// How many there are.
pub(crate) const COUNT: usize = count();

/// They by their places, sorted.
pub(crate) static STORED: [ObjectEntry; COUNT] = entries();

static NAMES: [[u8; NAME_LEN]; COUNT] = names();

const MARK: &[u8] = b" (stored, no effect)";
const NAME_LEN: usize = 5 + MARK.len();

/// Which one the object is.
pub(crate) fn place(at: (u16, u8)) -> Option<usize> {
    if !(0x2000..0x2800).contains(&at.0) {
        return None;
    }
    STORED.binary_search_by_key(&at, |entry| entry.at).ok()
}

/// Objects from 2000h to 27FFh that are settings.
#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn settings() -> [bool; 0x800] {
    let mut taken = [false; 0x800];
    let mut row = 0;
    while row < Setting::ALL.len() {
        let mut names = Setting::ALL[row].names();
        while let [name, rest @ ..] = names {
            if let 0x2000..=0x27FF = name.object.at.0 {
                taken[name.object.at.0 as usize & 0x7FF] = true;
            }
            names = rest;
        }
        row += 1;
    }
    taken
}

/// The next parameter that is no setting, from this place on: its group in the high octet, its number in the low one.
#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn next(taken: &[bool; 0x800], from: usize) -> Option<usize> {
    let mut place = from;
    while place < taken.len() {
        if (place & 0xFF) <= LAST[place >> 8] as usize && !taken[place] {
            return Some(place);
        }
        place += 1;
    }
    None
}

const fn count() -> usize {
    let taken = settings();
    let (mut count, mut from) = (0, 0);
    while let Some(place) = next(&taken, from) {
        (count, from) = (count + 1, place + 1);
    }
    count
}

#[expect(clippy::indexing_slicing, clippy::cast_possible_truncation, reason = "runs in the compiler only")]
const fn names() -> [[u8; NAME_LEN]; COUNT] {
    let taken = settings();
    let mut names = [*b"P0-00 (stored, no effect)"; COUNT];
    let (mut count, mut from) = (0, 0);
    while let Some(place) = next(&taken, from) {
        names[count][1] += (place >> 8) as u8;
        names[count][3] += (place & 0xFF) as u8 / 10;
        names[count][4] += (place & 0xFF) as u8 % 10;
        (count, from) = (count + 1, place + 1);
    }
    names
}

#[expect(clippy::indexing_slicing, clippy::cast_possible_truncation, reason = "runs in the compiler only")]
const fn entries() -> [ObjectEntry; COUNT] {
    let taken = settings();
    let mut entries = [ObjectEntry { at: (0, 0), data: I16, name: "" }; COUNT];
    let (mut count, mut from) = (0, 0);
    while let Some(place) = next(&taken, from) {
        let Ok(name) = core::str::from_utf8(&NAMES[count]) else { panic!("a name is no text") };
        let data = if place >> 8 < FIRST_WIDE { I16 } else { I32 };
        entries[count] = ObjectEntry { at: (0x2000 + place as u16, 0), data, name };
        (count, from) = (count + 1, place + 1);
    }
    entries
}
