//! Sections to an [`Eds`]: a mistake is told and costs the value that it stands in.

mod info;
mod lists;
mod objects;
mod values;

use super::lines::{self, Key, Section};
use super::xdd::Written;
use super::{Eds, MAX_FILE_LEN, ReadError, check, number, xdd};
use crate::device_file::{CodePage, Hint, Level, Place, Utf16, decode};

/// Reads a file.
pub(super) fn read(octets: &[u8]) -> Result<Eds, ReadError> {
    if octets.len() > MAX_FILE_LEN {
        return Err(ReadError::TooLong { got: octets.len() });
    }
    let (text, code_page) = decode(octets).map_err(|Utf16| ReadError::Utf16)?;
    if text.trim_start().is_empty() {
        return Err(ReadError::Empty);
    }
    let mut hints = Vec::new();
    let is_xml = xdd::is_xml(&text);
    let written = if is_xml { xdd::sections(&text)? } else { Vec::new() };
    let sections = match &written[..] {
        [] => lines::sections(&text, &mut hints),
        written => written.iter().map(Written::section).collect(),
    };
    if sections.is_empty() {
        return Err(if text.lines().any(is_gsd) { ReadError::Gsd } else { ReadError::NoSection });
    }
    let mut reader = Reader { code_page, sections: Sections(&sections), hints };
    let mut objects = reader.objects(&sections)?;
    if is_xml {
        lists::without_lists(&mut objects);
    } else {
        reader.lists(&mut objects);
    }
    let mut eds = Eds {
        code_page,
        file: reader.file_info(),
        device: reader.device_info(),
        commissioning: reader.commissioning(),
        dummies: reader.dummies(),
        objects,
        hints: Vec::new(),
    };
    let mut hints = reader.hints;
    hints.extend(check::contradictions(&eds, reader.sections.named("DeviceInfo")));
    hints.sort_by_key(|hint| (hint.place.line, hint.place.column));
    eds.hints = hints;
    Ok(eds)
}

/// The first line of a GSD that is no comment.
fn is_gsd(line: &str) -> bool {
    const HEADER: &str = "#Profibus_DP";
    line.trim_start().get(..HEADER.len()).is_some_and(|start| start.eq_ignore_ascii_case(HEADER))
}

/// The sections of the file.
struct Sections<'a>(&'a [Section<'a>]);

impl<'a> Sections<'a> {
    /// The one with that name in any case.
    fn named(&self, name: &str) -> Option<&'a Section<'a>> {
        self.0.iter().find(|section| section.name.eq_ignore_ascii_case(name))
    }
}

struct Reader<'a> {
    code_page: CodePage,
    sections: Sections<'a>,
    hints: Vec<Hint>,
}

impl Reader<'_> {
    fn warn(&mut self, place: Place, text: impl Into<String>) {
        self.hints.push(Hint { place, level: Level::Warning, text: text.into() });
    }

    /// The whole number of a key, `None` if it is not there, blank or no number of 32 bits.
    fn number(&mut self, section: &Section<'_>, name: &str) -> Option<u32> {
        let key = *section.key(name)?;
        self.number_of(&key)
    }

    fn number_of(&mut self, key: &Key<'_>) -> Option<u32> {
        let written = number::read(key.bare()).filter(|written| !written.number.node_id);
        let number = written.and_then(|written| u32::try_from(written.number.offset).ok());
        match (written.and_then(|written| written.odd), number) {
            (Some(odd), Some(_)) => self.warn(key.place, odd),
            (_, None) => {
                let value = lines::shortened(key.value);
                self.warn(
                    key.place,
                    format!("{} = '{value}' is no number of 32 bits: it is ignored", key.name),
                );
            }
            (None, Some(_)) => {}
        }
        number
    }

    /// A number that is 0 or not.
    fn flag(&mut self, section: &Section<'_>, name: &str) -> bool {
        self.number(section, name).is_some_and(|number| number != 0)
    }
}
