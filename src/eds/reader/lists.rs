//! The lists of objects beside the sections of the objects.

use std::collections::BTreeMap;

use super::Reader;
use crate::device_file::Place;
use crate::eds::object::{Group, Object};

impl Reader<'_> {
    /// Says of each object which list names it. What has a section is served, with a list or without.
    pub(super) fn lists(&mut self, objects: &mut BTreeMap<u16, Object>) {
        for group in Group::ALL {
            self.list(group, objects);
        }
        let mut unlisted: BTreeMap<&str, Vec<(u16, Place)>> = BTreeMap::new();
        for (index, object) in objects.iter().filter(|(_, object)| object.group.is_none()) {
            unlisted.entry(expected(*index).name()).or_default().push((*index, object.place));
        }
        for (section, objects) in unlisted {
            if self.sections.named(section).is_some() {
                for (index, place) in objects {
                    self.warn(
                        place,
                        format!(
                            "{index:04X}h stands in no list of objects, such as [{section}]: it is served"
                        ),
                    );
                }
            } else if let [(_, place), ..] = objects[..] {
                let count = objects.len();
                self.warn(
                    place,
                    format!(
                        "section [{section}] is missing: {count} objects stand in no list and are served"
                    ),
                );
            }
        }
    }

    fn list(&mut self, group: Group, objects: &mut BTreeMap<u16, Object>) {
        let Some(section) = self.sections.named(group.name()) else { return };
        let is_count = |name: &str| name.eq_ignore_ascii_case("SupportedObjects");
        let keys: Vec<_> = section.keys().copied().collect();
        let mut named = 0;
        for key in keys.iter().filter(|key| !is_count(key.name)) {
            let Some(index) = self.number_of(key) else { continue };
            named += 1;
            match u16::try_from(index).ok().and_then(|index| objects.get_mut(&index)) {
                Some(object) => object.group = Some(group),
                None => {
                    self.warn(key.place, format!("{index:04X}h has no section of its own: it is not served"))
                }
            }
        }
        if let Some(key) = keys.iter().find(|key| is_count(key.name))
            && let Some(count) = self.number_of(key).filter(|count| *count != named)
        {
            self.warn(
                key.place,
                format!("SupportedObjects is {count}, but {named} objects follow: all of them count"),
            );
        }
    }
}

/// XDD has no lists.
pub(super) fn without_lists(objects: &mut BTreeMap<u16, Object>) {
    for (index, object) in objects {
        object.group = Some(expected(*index));
    }
}

/// The list in which an object belongs.
const fn expected(index: u16) -> Group {
    match index {
        0x1000 | 0x1001 | 0x1018 => Group::Mandatory,
        0x2000..=0x5FFF => Group::Manufacturer,
        _other => Group::Optional,
    }
}
