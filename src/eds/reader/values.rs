//! The keys of an entry.

use super::Reader;
use crate::can_bus::canopen::value::{DataType, ValueKind};
use crate::eds::content::{self, Content};
use crate::eds::lines::{Key, Section, shortened};
use crate::eds::number;
use crate::eds::object::{Entry, Limit, Rights};

impl Reader<'_> {
    /// The entry of a section; `data` is its type where the section has none.
    pub(super) fn entry(&mut self, section: &Section<'_>, data: Option<DataType>) -> Entry {
        let data = self.data(section, data);
        let content = match section.key("ParameterValue").or_else(|| section.key("DefaultValue")).copied() {
            Some(key) => self.content(&key, data),
            None => Content::None,
        };
        let (low, high) = self.limits(section, data);
        Entry {
            name: section.text("ParameterName").to_owned(),
            data,
            rights: self.rights(section),
            content,
            mappable: self.flag(section, "PDOMapping"),
            low,
            high,
            file: section
                .key("UploadFile")
                .or_else(|| section.key("DownloadFile"))
                .map(|key| key.value.to_owned()),
            place: section.place,
        }
    }

    /// A value after power-up.
    pub(super) fn content(&mut self, key: &Key<'_>, data: DataType) -> Content {
        let text = match data.kind() {
            ValueKind::Text => key.value,
            ValueKind::Octets if data == DataType::UnicodeString => key.value,
            ValueKind::Boolean
            | ValueKind::Signed
            | ValueKind::Unsigned
            | ValueKind::Real
            | ValueKind::Octets => key.bare(),
        };
        if text.is_empty() {
            return Content::None;
        }
        let (content, odd) = Content::read(text, data, self.code_page);
        if let Some(odd) = odd {
            self.warn(key.place, format!("{}: {odd}", key.name));
        }
        content
    }

    fn data(&mut self, section: &Section<'_>, given: Option<DataType>) -> DataType {
        let is_domain = section.key("ObjectType").is_some_and(|key| key.bare().ends_with('2'));
        let otherwise = given.unwrap_or(if is_domain { DataType::Domain } else { DataType::U32 });
        let Some(key) = section.key("DataType").copied() else {
            if given.is_none() && !is_domain {
                self.warn(section.place, format!("DataType is missing: {} is assumed", otherwise.name()));
            }
            return otherwise;
        };
        let number = self.number_of(&key);
        let data = number.and_then(|number| u16::try_from(number).ok()).and_then(DataType::of_number);
        if let (None, Some(number)) = (data, number) {
            let text =
                format!("DataType {number:04X}h is no type of a value: {} is assumed", otherwise.name());
            self.warn(key.place, text);
        }
        data.unwrap_or(otherwise)
    }

    fn rights(&mut self, section: &Section<'_>) -> Rights {
        let Some(key) = section.key("AccessType").copied() else {
            self.warn(section.place, format!("AccessType of [{}] is missing: ro is assumed", section.name));
            return Rights::ReadOnly;
        };
        Rights::read(key.bare()).unwrap_or_else(|| {
            let value = shortened(key.value);
            let text =
                format!("AccessType is '{value}', expected ro, wo, rw, rwr, rww or const: ro is assumed");
            self.warn(key.place, text);
            Rights::ReadOnly
        })
    }

    /// LowLimit and HighLimit, none of them if they contradict each other.
    fn limits(&mut self, section: &Section<'_>, data: DataType) -> (Option<Limit>, Option<Limit>) {
        let mut limit = |name| {
            let key = *section.key(name)?;
            match read_limit(key.bare(), data)? {
                Ok(limit) => Some((limit, key.place)),
                Err(why) => {
                    self.warn(
                        key.place,
                        format!("{name} '{}' {why}: there is no such limit", shortened(key.value)),
                    );
                    None
                }
            }
        };
        let (low, high) = (limit("LowLimit"), limit("HighLimit"));
        if let (Some((low, _)), Some((high, place))) = (low, high) {
            let wrong = match (low, high) {
                (Limit::Whole(low), Limit::Whole(high)) if low.node_id == high.node_id => {
                    low.offset > high.offset || (low.offset, high.offset, low.node_id) == (0, 0, false)
                }
                (Limit::Real(low), Limit::Real(high)) => low > high || (low == 0.0 && high == 0.0),
                (Limit::Whole(_) | Limit::Real(_), _) => false,
            };
            if wrong {
                self.warn(place, "LowLimit and HighLimit leave no range: there are no limits");
                return (None, None);
            }
        }
        (low.map(|(limit, _)| limit), high.map(|(limit, _)| limit))
    }
}

/// Reads a limit; `None` of a type that has none.
fn read_limit(text: &str, data: DataType) -> Option<Result<Limit, &'static str>> {
    match data.kind() {
        ValueKind::Boolean | ValueKind::Signed | ValueKind::Unsigned => {
            Some(content::whole(text, data).map(|(number, _)| Limit::Whole(number)))
        }
        ValueKind::Real => {
            let number = number::real(text, data.octets().unwrap_or_default());
            Some(number.map(|(number, _)| Limit::Real(number)).ok_or("is no number"))
        }
        ValueKind::Text | ValueKind::Octets => None,
    }
}
