//! The sections of the objects.

use std::collections::BTreeMap;

use super::Reader;
use crate::can_bus::canopen::Index;
use crate::can_bus::canopen::dictionary::ObjectType;
use crate::can_bus::canopen::value::DataType;
use crate::eds::content::Content;
use crate::eds::lines::Section;
use crate::eds::number::Number;
use crate::eds::object::{Entry, Object, Rights};
use crate::eds::{MAX_ENTRIES, ReadError};

/// The first index that is served; below it types are described.
const FIRST: u16 = 0x1000;

/// The highest sub-index of an object.
const HIGHEST: u8 = 0xFE;

// Object codes.
const DOMAIN: u32 = 2;
const VAR: u32 = 7;
const ARRAY: u32 = 8;
const RECORD: u32 = 9;

/// The sections of an object.
#[derive(Default)]
struct Sources<'a> {
    head: Option<&'a Section<'a>>,
    subs: BTreeMap<u8, &'a Section<'a>>,
    /// Of CompactSubObj.
    values: Option<&'a Section<'a>>,
    names: Option<&'a Section<'a>>,
}

/// What a section holds of an object.
enum Part {
    Head,
    Sub(u8),
    Value,
    Name,
}

impl Reader<'_> {
    pub(super) fn objects(&mut self, sections: &[Section<'_>]) -> Result<BTreeMap<u16, Object>, ReadError> {
        let mut sources: BTreeMap<u16, Sources<'_>> = BTreeMap::new();
        let mut prefixed = None;
        for section in sections {
            let name = bare(section.name);
            let Some((index, part)) = place_of(name).filter(|(index, _)| *index >= FIRST) else {
                continue;
            };
            if name != section.name {
                prefixed.get_or_insert(section);
            }
            let sources = sources.entry(index).or_default();
            match part {
                Part::Head => sources.head = Some(section),
                Part::Sub(sub) => {
                    sources.subs.insert(sub, section);
                }
                Part::Value => sources.values = Some(section),
                Part::Name => sources.names = Some(section),
            }
        }
        if let Some(Section { name, place, .. }) = prefixed {
            self.warn(*place, format!("'0x' in the name of a section, as in [{name}], is left out"));
        }
        sources.retain(|_, sources| sources.head.is_some() || !sources.subs.is_empty());
        if sources.is_empty() {
            return Err(self.other_bus().unwrap_or(ReadError::NoObject));
        }
        let (mut objects, mut entries) = (BTreeMap::new(), 0_usize);
        for (index, sources) in sources {
            let Some(object) = self.object(index, &sources) else { continue };
            entries = entries.saturating_add(object.entries.len());
            if entries > MAX_ENTRIES {
                return Err(ReadError::TooManyEntries { place: object.place });
            }
            objects.insert(index, object);
        }
        Ok(objects)
    }

    /// EtherNet/IP and DeviceNet call their files EDS, too.
    fn other_bus(&self) -> Option<ReadError> {
        let section = ["Device Classification", "Params", "IO_Info", "Connection Manager"]
            .iter()
            .find_map(|name| self.sections.named(name))?;
        Some(ReadError::OtherBus { place: section.place })
    }

    fn object(&mut self, index: u16, sources: &Sources<'_>) -> Option<Object> {
        let (kind, compact) = self.kind(index, sources)?;
        let first = sources.head.or_else(|| sources.subs.values().next().copied())?;
        let mut entries = BTreeMap::new();
        if let (Some(head), true) = (sources.head, compact > 0) {
            self.compact(head, compact, sources, &mut entries);
        }
        for (sub, section) in &sources.subs {
            entries.insert(*sub, self.entry(section, None));
        }
        match (kind, sources.head) {
            (ObjectType::Var, Some(head)) => {
                entries.insert(0, self.entry(head, None));
            }
            (ObjectType::Var | ObjectType::Array | ObjectType::Record, _) => {
                self.highest(first, &mut entries)
            }
        }
        let head = sources.head;
        let flags = head.and_then(|head| self.number(head, "ObjFlags")).unwrap_or(0);
        let text = |key| head.map(|head| head.text(key)).unwrap_or_default().to_owned();
        Some(Object {
            index: Index(index),
            name: text("ParameterName"),
            denotation: text("Denotation"),
            kind,
            group: None,
            refuses_download: flags & 1 != 0,
            refuses_scan: flags & 2 != 0,
            entries,
            place: first.place,
        })
    }

    /// How an object is built, and for how many entries CompactSubObj stands; `None` if it cannot be served.
    fn kind(&mut self, index: u16, sources: &Sources<'_>) -> Option<(ObjectType, u8)> {
        let Some(head) = sources.head else {
            let place = sources.subs.values().next()?.place;
            self.warn(place, format!("section [{index:04X}] is missing: {index:04X}h is taken as a RECORD"));
            return Some((ObjectType::Record, 0));
        };
        let compact = self.number(head, "CompactSubObj").unwrap_or(0);
        if compact > HIGHEST.into() {
            self.warn(head.place, format!("CompactSubObj is {compact}, expected at most {HIGHEST}"));
        }
        let compact = u8::try_from(compact).unwrap_or(HIGHEST).min(HIGHEST);
        let kind = match self.number(head, "ObjectType").unwrap_or(VAR) {
            VAR | DOMAIN if sources.subs.is_empty() && compact == 0 => ObjectType::Var,
            VAR | DOMAIN => {
                self.warn(
                    head.place,
                    format!("{index:04X}h is a VAR with sub-indexes: it is taken as a RECORD"),
                );
                ObjectType::Record
            }
            ARRAY => ObjectType::Array,
            RECORD => ObjectType::Record,
            other => {
                self.warn(
                    head.place,
                    format!("ObjectType of {index:04X}h is {other}, expected 2, 7, 8 or 9: it is not served"),
                );
                return None;
            }
        };
        if kind != ObjectType::Var && sources.subs.is_empty() && compact == 0 {
            self.warn(head.place, format!("{index:04X}h has no sub-index: it is not served"));
            return None;
        }
        if let Some(count) =
            self.number(head, "SubNumber").filter(|_| compact == 0 && kind != ObjectType::Var)
        {
            let got = sources.subs.len();
            if usize::try_from(count).ok() != Some(got) {
                self.warn(
                    head.place,
                    format!("SubNumber of {index:04X}h is {count}, but {got} sub-indexes have a section"),
                );
            }
        }
        Some((kind, compact))
    }

    /// The entries that CompactSubObj stands for, with the names and values of their own sections.
    fn compact(
        &mut self,
        head: &Section<'_>,
        highest: u8,
        sources: &Sources<'_>,
        entries: &mut BTreeMap<u8, Entry>,
    ) {
        let model = self.entry(head, None);
        entries.insert(0, number_of_entries(highest, &model));
        for sub in 1..=highest {
            let mut entry = model.clone();
            entry.name = match sources.names.map(|names| names.text(&sub.to_string())) {
                Some("") | None => format!("{}{sub}", model.name),
                Some(name) => name.into(),
            };
            if let Some(value) = sources.values.and_then(|values| values.key(&sub.to_string())) {
                entry.content = self.content(value, entry.data);
            }
            entries.insert(sub, entry);
        }
    }

    /// Sub-index 0 of an ARRAY or a RECORD is the highest sub-index, if the file says nothing else.
    fn highest(&mut self, section: &Section<'_>, entries: &mut BTreeMap<u8, Entry>) {
        let highest = entries.keys().last().copied().unwrap_or_default();
        match entries.get_mut(&0) {
            Some(first) if first.content == Content::None && first.data.kind().is_whole() => {
                if first.data.range().is_none_or(|(_, most)| i64::from(highest) <= most) {
                    first.content = Content::Whole(Number { offset: highest.into(), node_id: false });
                } else {
                    let (place, data) = (first.place, first.data.name());
                    self.warn(
                        place,
                        format!(
                            "sub-index 0 of {}h has no default, and the highest sub-index, {highest}, is beyond {data}: it is 0",
                            bare(section.name)
                        ),
                    );
                }
            }
            Some(_) => {}
            None => {
                self.warn(section.place, format!("[{}sub0] is missing: it is {highest}", section.name));
                if let Some(model) = entries.values().next().cloned() {
                    entries.insert(0, number_of_entries(highest, &model));
                }
            }
        }
    }
}

/// Sub-index 0 that no section describes.
fn number_of_entries(highest: u8, model: &Entry) -> Entry {
    Entry {
        name: "Highest sub-index".into(),
        data: DataType::U8,
        rights: Rights::ReadOnly,
        content: Content::Whole(Number { offset: highest.into(), node_id: false }),
        mappable: false,
        low: None,
        high: None,
        file: None,
        place: model.place,
    }
}

/// Some write `0x1018`.
fn bare(section: &str) -> &str {
    section.strip_prefix("0x").or_else(|| section.strip_prefix("0X")).unwrap_or(section)
}

/// `1018`, `1018sub1`, `1003Value`, `1003Name`: which object, and what of it.
fn place_of(section: &str) -> Option<(u16, Part)> {
    let (index, rest) = section.split_at_checked(4)?;
    let hex = |digits: &str| {
        let all = digits.bytes().all(|octet| octet.is_ascii_hexdigit());
        u16::from_str_radix(digits, 16).ok().filter(|_| all)
    };
    let index = hex(index)?;
    let rest = rest.trim().to_ascii_lowercase();
    let part = match &rest[..] {
        "" => Part::Head,
        "value" => Part::Value,
        "name" => Part::Name,
        rest => Part::Sub(u8::try_from(hex(rest.strip_prefix("sub")?.trim())?).ok()?),
    };
    Some((index, part))
}
