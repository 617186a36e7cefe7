//! Text to sections of keys and values (`eds.md` 1).

use std::collections::HashMap;

use crate::device_file::{Hint, Level, Place};

/// A section with its keys, in the order of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Section<'a> {
    pub(super) name: &'a str,
    pub(super) place: Place,
    keys: Vec<Key<'a>>,
}

/// `key=value`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Key<'a> {
    pub(super) name: &'a str,
    pub(super) value: &'a str,
    /// Of the value.
    pub(super) place: Place,
}

impl<'a> Section<'a> {
    pub(super) const fn new(name: &'a str, place: Place, keys: Vec<Key<'a>>) -> Self {
        Self { name, place, keys }
    }

    /// The keys whose value is not blank.
    pub(super) fn keys(&self) -> impl Iterator<Item = &Key<'a>> {
        self.keys.iter().filter(|key| !key.value.is_empty())
    }

    /// The key with that name in any case; `None` if its value is blank.
    pub(super) fn key(&self, name: &str) -> Option<&Key<'a>> {
        self.keys().find(|key| key.name.eq_ignore_ascii_case(name))
    }

    /// The text of a key, empty without it.
    pub(super) fn text(&self, name: &str) -> &'a str {
        self.key(name).map_or("", |key| key.value)
    }
}

impl<'a> Key<'a> {
    /// The value without a comment behind it: of numbers, types and access rights, never of texts.
    pub(super) fn bare(&self) -> &'a str {
        self.value.split([';', '#']).next().unwrap_or_default().trim()
    }
}

/// The sections of a text. A section or a key that is there twice is one: the last value that is not blank holds.
pub(super) fn sections<'a>(text: &'a str, hints: &mut Vec<Hint>) -> Vec<Section<'a>> {
    let mut sections: Vec<Section<'a>> = Vec::new();
    // By name: real files have thousands of sections.
    let mut known: HashMap<String, usize> = HashMap::new();
    let mut current: Option<usize> = None;
    let mut keys = Places::default();
    let mut warn = |place, text| hints.push(Hint { place, level: Level::Warning, text });
    for (line, number) in physical_lines(text).zip(1..) {
        let start = line.trim_start();
        let place = Place { line: number, column: column(line, start) };
        let line = start.trim_end();
        if line.is_empty() || line.starts_with([';', '#']) {
            continue;
        }
        if let Some(rest) = line.strip_prefix('[') {
            let (name, behind) = rest.split_once(']').unwrap_or_else(|| {
                warn(place, "']' is missing; the section is named by the whole line".into());
                (rest, "")
            });
            let (name, behind) = (name.trim(), behind.trim_start());
            if !(behind.is_empty() || behind.starts_with([';', '#'])) {
                warn(place, format!("text behind [{name}] is ignored"));
            }
            let at = *known.entry(name.to_ascii_lowercase()).or_insert_with(|| {
                sections.push(Section { name, place, keys: Vec::new() });
                sections.len() - 1
            });
            if let Some(first) = sections.get(at).filter(|first| first.place != place) {
                warn(
                    place,
                    format!("section [{name}] is there already, in line {}: both are one", first.place.line),
                );
            }
            current = Some(at);
            continue;
        }
        let Some((name, value)) = line.split_once('=') else {
            warn(place, format!("no '=' in '{}': the line is ignored", shortened(line)));
            continue;
        };
        let (name, value) = (name.trim_end(), value.trim());
        let place = Place { line: number, column: column(line, value).saturating_add(place.column - 1) };
        let Some((at, section)) = current.and_then(|at| Some((at, sections.get_mut(at)?))) else {
            warn(place, format!("'{}' stands before the first section: it is ignored", shortened(name)));
            continue;
        };
        let key = Key { name, value, place };
        let before = keys.place(at, section, name).and_then(|place| section.keys.get_mut(place));
        match before {
            Some(before) => {
                let first = before.place.line;
                if !value.is_empty() {
                    *before = key;
                }
                let text = format!(
                    "{name} is there already, in line {first}: the last value that is not blank holds"
                );
                warn(place, text);
            }
            None => {
                section.keys.push(key);
                keys.add(at, section);
            }
        }
    }
    sections
}

/// Where the keys of sections with many of them are, by name: of lists of objects. Those of an object are few.
#[derive(Default)]
struct Places(HashMap<(usize, String), usize>);

impl Places {
    const FEW: usize = 32;

    fn place(&self, at: usize, section: &Section<'_>, name: &str) -> Option<usize> {
        if section.keys.len() < Self::FEW {
            section.keys.iter().position(|key| key.name.eq_ignore_ascii_case(name))
        } else {
            self.0.get(&(at, name.to_ascii_lowercase())).copied()
        }
    }

    /// The section has one key more.
    fn add(&mut self, at: usize, section: &Section<'_>) {
        let len = section.keys.len();
        if len >= Self::FEW {
            let first = if len == Self::FEW { 0 } else { len - 1 };
            let added = section.keys.iter().enumerate().skip(first);
            self.0.extend(added.map(|(place, key)| ((at, key.name.to_ascii_lowercase()), place)));
        }
    }
}

/// Lines end with CR LF, LF or CR.
fn physical_lines(text: &str) -> impl Iterator<Item = &str> {
    text.split('\n').flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'))
}

/// The column in which the end `rest` of a line begins.
fn column(line: &str, rest: &str) -> u32 {
    let before = line.len().saturating_sub(rest.len());
    let chars = line.get(..before).map_or(before, |before| before.chars().count());
    u32::try_from(chars).unwrap_or(u32::MAX).saturating_add(1)
}

/// The beginning of what is quoted.
pub(super) fn shortened(text: &str) -> String {
    const MOST: usize = 40;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", text.get(..end).unwrap_or_default()),
        None => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Vec<Section<'_>>, Vec<String>) {
        let mut hints = Vec::new();
        let sections = sections(text, &mut hints);
        (sections, hints.iter().map(ToString::to_string).collect())
    }

    #[test]
    fn sections_keys_and_comments_in_every_form_of_line() {
        let text = "; comment\r\n[ A ] ; behind\n\tKey = a;b \r# also\r\nBlank=\n[b]#x\nKEY=0x07 # VAR\n";
        let (sections, hints) = read(text);
        assert_eq!(hints, [""; 0]);
        assert_eq!(sections.iter().map(|section| section.name).collect::<Vec<_>>(), ["A", "b"]);
        assert_eq!(sections[0].text("key"), "a;b");
        assert_eq!(sections[0].key("Blank"), None);
        let key = sections[1].key("key").unwrap();
        assert_eq!((key.value, key.bare()), ("0x07 # VAR", "0x07"));
        assert_eq!(sections[0].key("KEY").unwrap().place, Place { line: 3, column: 8 });
    }

    #[test]
    fn what_is_odd_is_said_with_its_place_and_costs_nothing_else() {
        let (sections, hints) = read("x=1\n[A\nk=1\n[A] more\nk=\nk=2\nnothing\n");
        assert_eq!(
            hints,
            [
                "line 1, column 3: warning: 'x' stands before the first section: it is ignored",
                "line 2, column 1: warning: ']' is missing; the section is named by the whole line",
                "line 4, column 1: warning: text behind [A] is ignored",
                "line 4, column 1: warning: section [A] is there already, in line 2: both are one",
                "line 5, column 3: warning: k is there already, in line 3: the last value that is not blank holds",
                "line 6, column 3: warning: k is there already, in line 3: the last value that is not blank holds",
                "line 7, column 1: warning: no '=' in 'nothing': the line is ignored",
            ]
        );
        assert_eq!((sections.len(), sections[0].text("K")), (1, "2"));
    }

    #[test]
    fn a_key_twice_is_found_among_few_and_among_many() {
        for count in [2, 31, 32, 33, 40, 100] {
            let keys: String = (0..count).map(|number| format!("Key{number}={number}\n")).collect();
            for twice in [0, count / 2, count - 1] {
                let text = format!("[A]\n{keys}[B]\n{keys}KEY{twice}=x\nnew=1\n");
                let (sections, hints) = read(&text);
                assert_eq!(hints.len(), 1, "{hints:?}");
                assert_eq!(sections[1].text(&format!("key{twice}")), "x");
                assert_eq!([sections[0].keys.len(), sections[1].keys.len()], [count, count + 1]);
            }
        }
    }
}
