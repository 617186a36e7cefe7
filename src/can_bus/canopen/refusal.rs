//! A refused request in full: the answer, what was to be written, and the rule that it broke.

use core::fmt;

use super::abort::Abort;
use super::address::Address;
use super::dictionary::{Entry, Limits, Place};
use super::nmt::NmtState;
use super::value::ValueKind;

/// Octets of a value that are kept to be told; of longer ones the first.
const KEPT: usize = 8;

/// A request for an entry that was refused. `Display` is the sentence: the entry, the abort code, what was expected and what
/// came, what to do.
#[derive(Clone, Copy, Debug)]
pub struct Refusal {
    /// The entry.
    pub at: Address,
    /// The answer.
    pub code: Abort,
    entry: Option<&'static Entry>,
    written: Option<Attempt>,
    rule: Option<Rule>,
}

/// A write that was carried out. `Display`: the entry and the value, `6040h:00 Controlword written: 000Fh`.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// The entry.
    pub at: Address,
    entry: Option<&'static Entry>,
    written: Attempt,
}

impl Change {
    /// Octets that were written; of a long value that came in parts the last ones.
    pub(super) fn new(at: Address, entry: Option<&'static Entry>, octets: &[u8], unit: &'static str) -> Self {
        Self { at, entry, written: Attempt::of(octets, unit) }
    }
}

impl PartialEq for Change {
    fn eq(&self, other: &Self) -> bool {
        (self.at, self.written) == (other.at, other.written)
    }
}

impl Eq for Change {}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at, entry, written } = self;
        at.fmt(f)?;
        if let Some(entry) = entry {
            write!(f, " {}", entry.name)?;
        }
        write!(f, " written: {}", Got { written, entry: *entry, counted: false })
    }
}

/// What was to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Attempt {
    octets: [u8; KEPT],
    /// Octets that came, or were announced.
    len: usize,
    /// Those of them that are in `octets`.
    kept: usize,
    unit: &'static str,
}

/// The rule that a write broke.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Rule {
    /// So many octets at least and at most.
    Length(usize, usize),
    /// These values.
    Limits(Limits),
    /// Not below the value of another entry.
    AtLeast(i64, Address),
    /// Not above the value of another entry.
    AtMost(i64, Address),
    /// Only in the first NMT state; the node is in the second.
    State(NmtState, NmtState),
    /// The PDO is on; this is its COB-ID.
    PdoOn(Address),
    /// There is no such object, but this one, whose index has the two octets the other way round.
    Exchanged(Address),
    /// A segment comes without a transfer.
    NoTransfer,
    /// So many segments in a block are none.
    BlockSize(u8),
    /// So many segments of a block are said to be taken, and fewer were sent.
    Taken {
        /// By the client.
        got: u8,
        /// By the node.
        sent: u8,
    },
    /// The check sequence behind a block transfer.
    Crc {
        /// Over the octets that came.
        expected: u16,
        /// With the end of the transfer.
        got: u16,
    },
    /// So many bits has the object that is mapped.
    Bits(usize),
    /// This entry supervises the same node.
    Supervised(Address),
    /// The mapping has nothing at this sub-index.
    NotMapped(u8),
    /// What else is in the way, as the end of "1 was written, but".
    But(&'static str),
}

impl Rule {
    /// Whether it compares numbers.
    const fn counts(self) -> bool {
        match self {
            Self::Limits(_) | Self::AtLeast(..) | Self::AtMost(..) => true,
            Self::Length(..)
            | Self::State(..)
            | Self::PdoOn(_)
            | Self::Exchanged(_)
            | Self::NoTransfer
            | Self::BlockSize(_)
            | Self::Taken { .. }
            | Self::Crc { .. }
            | Self::Bits(_)
            | Self::NotMapped(_)
            | Self::Supervised(_)
            | Self::But(_) => false,
        }
    }
}

/// The answer to a write on its way to a [`Refusal`]: the code and the rule, if one is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::can_bus::canopen) struct Broken {
    pub(in crate::can_bus::canopen) code: Abort,
    pub(in crate::can_bus::canopen) rule: Option<Rule>,
}

impl Broken {
    pub(in crate::can_bus::canopen) const fn rule(code: Abort, rule: Rule) -> Self {
        Self { code, rule: Some(rule) }
    }
}

impl From<Abort> for Broken {
    fn from(code: Abort) -> Self {
        Self { code, rule: None }
    }
}

impl Refusal {
    /// Of a request that brings no value: a read, or a transfer that went wrong.
    pub(crate) const fn new(at: Address, code: Abort, entry: Option<&'static Entry>) -> Self {
        Self { at, code, entry, written: None, rule: None }
    }

    /// Of a write of `octets`, as another end of the bus sees it: the rule is the one of the table, if that is broken. `unit`
    /// is what a number in the entry counts, empty if nothing is known.
    #[must_use]
    pub(crate) fn of_write(
        at: Address,
        code: Abort,
        entry: Option<&'static Entry>,
        octets: &[u8],
        unit: &'static str,
    ) -> Self {
        let rule = entry.filter(|entry| entry.is_writable()).and_then(|entry| of_table(entry, octets));
        Self::broken(at, Broken { code, rule }, entry, octets, unit)
    }

    /// Of a write by a node.
    pub(super) fn broken(
        at: Address,
        broken: Broken,
        entry: Option<&'static Entry>,
        octets: &[u8],
        unit: &'static str,
    ) -> Self {
        let written = Attempt::of(octets, unit);
        Self { at, code: broken.code, entry, written: Some(written), rule: broken.rule }
    }

    /// Of a write whose octets were announced only.
    pub(super) const fn announced(
        at: Address,
        broken: Broken,
        entry: Option<&'static Entry>,
        len: usize,
    ) -> Self {
        let written = Attempt { octets: [0; KEPT], len, kept: 0, unit: "" };
        Self { at, code: broken.code, entry, written: Some(written), rule: broken.rule }
    }

    /// With the rule that it broke.
    #[must_use]
    pub(super) const fn with(mut self, rule: Rule) -> Self {
        self.rule = Some(rule);
        self
    }

    /// Why, without the entry: the abort code, what was expected and what came, what to do.
    pub const fn reason(&self) -> Reason<'_> {
        Reason(self)
    }
}

/// The rule of the table that a value breaks.
fn of_table(entry: &Entry, octets: &[u8]) -> Option<Rule> {
    let (fewest, most) = entry.lengths();
    if !(fewest..=most).contains(&octets.len()) {
        return Some(Rule::Length(fewest, most));
    }
    match entry.place(entry.data.decode(octets)?) {
        Place::Inside => None,
        Place::Below | Place::Above | Place::Gap => Some(Rule::Limits(entry.limits)),
    }
}

impl PartialEq for Refusal {
    /// Entries are the same if they are one entry of one table.
    fn eq(&self, other: &Self) -> bool {
        let pointer = |refusal: &Self| refusal.entry.map(core::ptr::from_ref);
        (self.at, self.code, self.written, self.rule) == (other.at, other.code, other.written, other.rule)
            && pointer(self) == pointer(other)
    }
}

impl Eq for Refusal {}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.at.fmt(f)?;
        if let Some(entry) = self.entry {
            write!(f, " {}", entry.name)?;
        }
        write!(f, " refused: {}", self.reason())
    }
}

impl core::error::Error for Refusal {}

/// Why a request was refused ([`Refusal::reason`]).
#[derive(Clone, Copy, Debug)]
pub struct Reason<'a>(&'a Refusal);

impl fmt::Display for Reason<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Refusal { code, written, entry, rule, .. }) = self;
        code.fmt(f)?;
        if let Some(written) = written {
            f.write_str(": ")?;
            let got = Got { written, entry: *entry, counted: rule.is_some_and(Rule::counts) };
            match rule {
                Some(Rule::Length(fewest, most)) if fewest == most => {
                    write!(f, "expected {}, got {}", Octets(*most), Raw(written))
                }
                Some(Rule::Length(fewest, most)) => {
                    write!(f, "expected {fewest} to {most} octets, got {}", Raw(written))
                }
                Some(Rule::Limits(limits)) => write!(f, "expected {}, got {got}", Expected(*limits)),
                Some(Rule::AtLeast(value, of)) => {
                    write!(f, "expected at least {value}, the value of {of}, got {got}")
                }
                Some(Rule::AtMost(value, of)) => {
                    write!(f, "expected at most {value}, the value of {of}, got {got}")
                }
                Some(Rule::State(expected, state)) => {
                    write!(f, "got {got}, but it is taken in {expected} only and the node is in {state}")
                }
                Some(Rule::PdoOn(_)) => write!(f, "got {got}, but the PDO is on"),
                Some(Rule::But(but)) => write!(f, "got {got}, but {but}"),
                Some(Rule::Bits(bits)) => write!(f, "got {got}, but the object has {bits} bits"),
                Some(Rule::Supervised(other)) => write!(f, "got {got}, but {other} supervises that node"),
                Some(Rule::NotMapped(sub)) => write!(f, "got {got}, but sub-index {sub} is 0"),
                Some(
                    Rule::Exchanged(_)
                    | Rule::NoTransfer
                    | Rule::BlockSize(_)
                    | Rule::Taken { .. }
                    | Rule::Crc { .. },
                )
                | None => write!(f, "got {got}"),
            }?;
        }
        match rule {
            Some(Rule::PdoOn(cob_id)) => return write!(f, ": write {cob_id} with bit 31 = 1 first"),
            Some(Rule::NoTransfer) => {
                return f.write_str(
                    ": no transfer is under way; begin one with an upload (40h) or a download request (20h to 2Fh)",
                );
            }
            Some(Rule::Exchanged(meant)) => {
                return write!(
                    f,
                    ": the octets of the index seem to be exchanged: {meant} is there; send the low octet first"
                );
            }
            Some(Rule::BlockSize(got)) => {
                return write!(f, ": expected blocks of 1 to 127 segments, got {got}: send another size");
            }
            Some(Rule::Taken { got, sent }) => {
                return write!(f, ": expected at most {sent}, the segments of the block, got {got}");
            }
            Some(Rule::Crc { expected, got }) => {
                return write!(
                    f,
                    ": expected CRC {expected:04X}h, got {got:04X}h: count it over the octets of the value, from 0, polynomial 1021h"
                );
            }
            Some(Rule::Bits(_)) => return f.write_str(": write its length to bits 0 to 7 of the entry"),
            Some(Rule::Supervised(other)) => {
                return write!(f, ": write {other} = 0 first, or use that entry");
            }
            Some(Rule::NotMapped(_)) => return f.write_str(": write what is mapped there first"),
            Some(
                Rule::Length(..)
                | Rule::Limits(_)
                | Rule::AtLeast(..)
                | Rule::AtMost(..)
                | Rule::State(..)
                | Rule::But(_),
            )
            | None => {}
        }
        code.cure().map_or(Ok(()), |cure| write!(f, ": {cure}"))
    }
}

/// `1 octet`, `4 octets`.
pub(super) struct Octets(pub(super) usize);

impl fmt::Display for Octets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} octet{}", self.0, if self.0 == 1 { "" } else { "s" })
    }
}

/// `2 octets (63 00)`.
struct Raw<'a>(&'a Attempt);

impl fmt::Display for Raw<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Attempt { len, .. } = *self.0;
        Octets(len).fmt(f)?;
        let octets = self.0.octets();
        if octets.is_empty() {
            return Ok(());
        }
        f.write_str(" (")?;
        octets
            .iter()
            .enumerate()
            .try_for_each(|(place, octet)| write!(f, "{}{octet:02X}", if place == 0 { "" } else { " " }))?;
        f.write_str(if octets.len() < len { " ...)" } else { ")" })
    }
}

/// The values that limits allow.
struct Expected(Limits);

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let range = |f: &mut fmt::Formatter<'_>, (low, high): (i64, i64)| match low == high {
            true => write!(f, "{low}"),
            false => write!(f, "{low} to {high}"),
        };
        match self.0 {
            Limits::Type => f.write_str("a value of its type"),
            Limits::Range(low, high) => range(f, (low, high)),
            Limits::Ranges(ranges) => ranges.iter().enumerate().try_for_each(|(place, one)| {
                let last = place + 1 == ranges.len();
                f.write_str(if place == 0 {
                    ""
                } else if last {
                    " or "
                } else {
                    ", "
                })?;
                range(f, *one)
            }),
            Limits::MaxLen(most) => write!(f, "at most {}", Octets(most)),
        }
    }
}

/// What came: a number with its unit; without unit or limits hexadecimal, as wide as it is; or octets.
struct Got<'a> {
    written: &'a Attempt,
    entry: Option<&'static Entry>,
    /// The rule is about a number.
    counted: bool,
}

impl fmt::Display for Got<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { written, entry, counted } = self;
        let octets = written.octets();
        let decoded = entry.filter(|_| octets.len() == written.len);
        let decoded = decoded.and_then(|entry| Some((entry, entry.data.decode(octets)?)));
        match (decoded, octets) {
            (Some((entry, value)), _) if *counted || is_counted(entry) || !written.unit.is_empty() => {
                value.fmt(f)?;
                match written.unit.as_bytes() {
                    [] => Ok(()),
                    // The number of a scale is no unit to stand behind a number.
                    [b'0'..=b'9', ..] => write!(f, ", counted in {}", written.unit),
                    [..] => write!(f, " {}", written.unit),
                }
            }
            (Some(_) | None, [_, ..]) if written.len <= KEPT && !is_text(*entry) => {
                octets.iter().rev().try_for_each(|octet| write!(f, "{octet:02X}"))?;
                f.write_str("h")
            }
            (Some((_, value)), _) => value.fmt(f),
            (None, _) => Raw(written).fmt(f),
        }
    }
}

impl Attempt {
    fn of(octets: &[u8], unit: &'static str) -> Self {
        let mut kept = [0; KEPT];
        kept.iter_mut().zip(octets).for_each(|(place, octet)| *place = *octet);
        Self { octets: kept, len: octets.len(), kept: octets.len().min(KEPT), unit }
    }

    fn octets(&self) -> &[u8] {
        self.octets.get(..self.kept).unwrap_or_default()
    }
}

/// Whether the values of an entry are numbers that somebody counts, not bits.
fn is_counted(entry: &Entry) -> bool {
    match entry.data.kind() {
        ValueKind::Signed | ValueKind::Real | ValueKind::Boolean => true,
        ValueKind::Unsigned => entry.limits != Limits::Type,
        ValueKind::Text | ValueKind::Octets => false,
    }
}

fn is_text(entry: Option<&Entry>) -> bool {
    entry.is_some_and(|entry| entry.data.octets().is_none())
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::can_bus::canopen::value::DataType;

    const MODE: Entry = Entry::rw(0, "Mode", DataType::I8).range(1, 2);
    const ID: Entry = Entry::rw(1, "COB-ID", DataType::U32);
    const NAME: Entry = Entry::rw(0, "Name", DataType::VisibleString).max_len(4);
    const RATE: Entry = Entry::rw(0, "Rate", DataType::U8).ranges(&[(0, 0), (2, 5), (7, 7)]);

    fn said(entry: &'static Entry, octets: &[u8], code: Abort, unit: &'static str) -> std::string::String {
        Refusal::of_write(Address::new(0x2000, 0), code, Some(entry), octets, unit).reason().to_string()
    }

    #[test]
    fn the_value_stands_beside_the_rule_it_broke() {
        const RANGE: &str = "value range of the parameter exceeded (06090030h): ";
        const CURE: &str = ": send a value within the limits of the EDS";
        for (entry, octets, unit, expected) in [
            (&MODE, &[99][..], "", "expected 1 to 2, got 99"),
            (&MODE, &[0x9D], "rpm", "expected 1 to 2, got -99 rpm"),
            (&MODE, &[99], "0.01 mm", "expected 1 to 2, got 99, counted in 0.01 mm"),
            (&MODE, &[99, 0], "", "expected 1 octet, got 2 octets (63 00)"),
            (&RATE, &[6], "", "expected 0, 2 to 5 or 7, got 6"),
            (&ID, &[5, 2, 0, 0x80], "", "got 80000205h"),
            (&ID, &[5], "", "expected 4 octets, got 1 octet (05)"),
            (&NAME, b"abc", "", "got \"abc\""),
            (&NAME, b"abcdefghij", "", "expected 0 to 4 octets, got 10 octets (61 62 63 64 65 66 67 68 ...)"),
        ] {
            assert_eq!(said(entry, octets, Abort::RANGE, unit), std::format!("{RANGE}{expected}{CURE}"));
        }
    }

    #[test]
    fn of_an_entry_that_is_not_there_the_octets_are_told_by_their_width() {
        for (octets, expected) in [(&[1, 0][..], "0001h"), (&[1, 2, 3, 4], "04030201h"), (&[], "0 octets")] {
            let refusal = Refusal::of_write(Address::new(0x9999, 0), Abort::NO_OBJECT, None, octets, "");
            let text = refusal.to_string();
            assert!(text.contains(&std::format!("(06020000h): got {expected}: ")), "{text}");
        }
    }

    #[test]
    fn a_read_has_no_value_to_tell() {
        let refusal = Refusal::new(Address::new(0x1010, 1), Abort::WRITE_ONLY, Some(&ID));
        assert_eq!(
            refusal.to_string(),
            "1010h:01 COB-ID refused: attempt to read a write-only object (06010001h): it can only be written"
        );
    }
}
