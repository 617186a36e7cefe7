//! What a further axis of a drive calls what the first one has: `axis_2_position`, `axis 2: fault reset: 6840h = 0080h`.

use core::fmt;
use std::collections::BTreeMap;

use super::drive::Axis;
use crate::can_bus::cia402::axis;
use crate::devices::cia402_drive::Fault;
use crate::devices::servo::news::News;
use crate::face::description::{Curve, Value};
use crate::face::surroundings::Input;
use crate::face::{DeviceEvent, EventKind};

/// The names of one axis; the first has its own.
#[derive(Debug, Default)]
pub(super) struct Names(BTreeMap<&'static str, &'static str>);

impl Names {
    /// Those of a further axis, for as long as the program runs.
    pub(super) fn of(axis: &Axis) -> Self {
        let mut all = BTreeMap::new();
        let number = axis.number();
        if number == 0 {
            return Self(all);
        }
        let mut key = |own: &'static str| {
            all.entry(own).or_insert_with(|| &*format!("{}{own}", Prefix(number)).leak());
        };
        axis.each_motion(&mut |value| key(value.key));
        axis.drive.each_input(&mut |input, _| key(input.name));
        let mut text = |own: &'static str| {
            all.entry(own).or_insert_with(|| &*OfAxis(number, own).to_string().leak());
        };
        axis.each_motion(&mut |value| text(value.name));
        axis.drive.each_input(&mut |input, _| text(input.about));
        Self(all)
    }

    fn name(&self, own: &'static str) -> &'static str {
        self.0.get(own).copied().unwrap_or(own)
    }

    /// An input by its name.
    pub(super) fn input(&self, input: &Input) -> Input {
        Input { name: self.name(input.name), about: self.name(input.about), ..*input }
    }

    /// A value by its name.
    pub(super) fn value<'a>(&self, value: Value<'a>) -> Value<'a> {
        let curve = match value.curve {
            Curve::SetpointOf(key) => Curve::SetpointOf(self.name(key)),
            curve @ (Curve::None | Curve::Own) => curve,
        };
        Value { key: self.name(value.key), name: self.name(value.name), curve, ..value }
    }
}

/// How the names of an axis begin.
struct Prefix(u8);

impl fmt::Display for Prefix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 == 0 { Ok(()) } else { write!(f, "axis_{}_", self.0 + 1) }
    }
}

/// The axis of a name, and its name at the first axis.
pub(super) fn of_first(name: &str) -> (u8, &str) {
    let further = (1..axis::MAX_AXES).find_map(|number| {
        let rest = name.strip_prefix("axis_")?.strip_prefix(char::from(b'1' + number))?.strip_prefix('_')?;
        Some((number, rest))
    });
    further.unwrap_or((0, name))
}

/// The name of a fault of an axis.
pub(super) struct FaultName(pub(super) u8, pub(super) Fault);

impl fmt::Display for FaultName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{:04X}", Prefix(self.0), self.1.0)
    }
}

/// What is said of the first axis, said of that one: its objects are others.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OfAxis<T>(pub(super) u8, pub(super) T);

impl<T: fmt::Display> fmt::Display for OfAxis<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(number, text) = self;
        if *number == 0 {
            return text.fmt(f);
        }
        let text = text.to_string();
        write!(f, "axis {}: ", number + 1)?;
        let mut rest = &*text;
        while let Some((at, index)) = next_object(rest) {
            let (before, object) = rest.split_at(at);
            write!(f, "{before}{:04X}", axis::index(*number, index))?;
            rest = object.get(4..).unwrap_or_default();
        }
        f.write_str(rest)
    }
}

/// The first object of the first axis in a text, as `6040h`. What is written to one, `= 600Fh`, is none.
fn next_object(text: &str) -> Option<(usize, u16)> {
    text.match_indices('6').find_map(|(at, _)| {
        let (before, from) = (text.get(..at)?, text.get(at..)?);
        let index = from.get(..5)?.strip_suffix('h')?;
        let is_word = !before.ends_with(|end: char| end.is_ascii_alphanumeric()) && !before.ends_with("= ");
        let index = u16::from_str_radix(index, 16).ok()?;
        (is_word && (0x6000..0x6800).contains(&index)).then_some((at, index))
    })
}

impl DeviceEvent for OfAxis<News<Fault>> {
    fn kind(&self) -> EventKind {
        self.1.kind()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_further_axis_has_its_number_and_its_objects_in_what_is_said() {
        let text =
            "6040h = 600Fh has no effect: send 6040h = 0006h, then 607Dh:01; 16040h, 6840h and 64 stay";
        assert_eq!(OfAxis(0, text).to_string(), text);
        assert_eq!(
            OfAxis(1, text).to_string(),
            "axis 2: 6840h = 600Fh has no effect: send 6840h = 0006h, then 687Dh:01; 16040h, 6840h and 64 stay"
        );
        assert_eq!(of_first("axis_2_home_switch"), (1, "home_switch"));
        assert_eq!(of_first("axis_8_8611"), (7, "8611"));
        for other in ["home_switch", "axis_1_home_switch", "axis_9_blocked", "axis_2", "axis_12_blocked"] {
            assert_eq!(of_first(other), (0, other));
        }
    }
}
