//! The kinds of signals: their names, their keys, and how they are made. One table for line files, the command line and HTTP,
//! whatever the bus: the values that a signal reads elsewhere stay as they were given.

use core::time::Duration;
use std::path::Path;

use super::choice::{near, one_of};
use super::{Given, Wrong};
use crate::host::fault::{duration, no_time};
use crate::process::{AtEnd, Condition, Source, Table};

/// A kind of signal.
pub(crate) struct Kind {
    /// Its name.
    pub(crate) name: &'static str,
    /// What the value does.
    pub(crate) about: &'static str,
    /// What it is given by.
    pub(crate) keys: &'static [Key],
    make: fn(&Keys<'_>) -> Result<Source<Given>, Wrong>,
}

/// The keys of which a comparison has one.
pub(crate) const LIMITS: [&str; 3] = ["is", "above", "below"];

/// Something by which a signal is given.
#[derive(Clone, Copy)]
pub(crate) struct Key {
    /// Its name.
    pub(crate) name: &'static str,
    /// What it holds.
    pub(crate) holds: Holds,
    /// Whether the signal cannot be without it.
    pub(crate) required: bool,
}

/// What a key holds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Holds {
    /// A number.
    Number,
    /// A number other than 0.
    Step,
    /// A whole number from 0.
    Whole,
    /// A time such as `20ms`.
    Time,
    /// One of these words.
    OneOf(&'static [&'static str]),
    /// The name of a file.
    File,
    /// A value elsewhere.
    Value,
    /// One such value or more.
    Values,
}

const fn needed(name: &'static str, holds: Holds) -> Key {
    Key { name, holds, required: true }
}

const fn usual(name: &'static str, holds: Holds) -> Key {
    Key { name, holds, required: false }
}

/// The key of the kind.
pub(crate) const BEHAVIOUR: &str = "behaviour";

/// Every kind; the first is the one of a signal that names none.
pub(crate) static KINDS: &[Kind] = &[
    Kind {
        name: "constant",
        about: "Always `value`.",
        keys: &[needed("value", Holds::Number)],
        make: |keys| Ok(Source::Constant(keys.number("value", 0.0)?)),
    },
    Kind {
        name: "mirror",
        about: "The value `of` of the same device.",
        keys: &[needed("of", Holds::Value)],
        make: |keys| Ok(Source::Follow { of: keys.value(), delay: Duration::ZERO }),
    },
    Kind {
        name: "count",
        about: "Counts from `from` to `to`: `step` (1) is added `every` time; then again.",
        keys: &[
            needed("from", Holds::Number),
            needed("to", Holds::Number),
            usual("step", Holds::Step),
            needed("every", Holds::Time),
        ],
        make: |keys| {
            Ok(Source::Count {
                from: keys.number("from", 0.0)?,
                to: keys.number("to", 0.0)?,
                step: keys.number("step", 1.0)?,
                every: keys.time("every", Duration::ZERO)?,
            })
        },
    },
    Kind {
        name: "ramp",
        about: "Linearly from `from` to `to` in `time`, `then` hold (unless given), repeat or return.",
        keys: &[
            needed("from", Holds::Number),
            needed("to", Holds::Number),
            needed("time", Holds::Time),
            usual("then", Holds::OneOf(&["hold", "repeat", "return"])),
        ],
        make: |keys| {
            Ok(Source::Ramp {
                from: keys.number("from", 0.0)?,
                to: keys.number("to", 0.0)?,
                time: keys.time("time", Duration::ZERO)?,
                then: match keys.word("then")? {
                    "repeat" => AtEnd::Repeat,
                    "return" => AtEnd::Return,
                    _ => AtEnd::Hold,
                },
            })
        },
    },
    Kind {
        name: "sine",
        about: "`mean` (0) + `amplitude` * sin(2 pi (time + `phase` (0)) / `period`).",
        keys: &[
            usual("mean", Holds::Number),
            needed("amplitude", Holds::Number),
            needed("period", Holds::Time),
            usual("phase", Holds::Time),
        ],
        make: |keys| {
            Ok(Source::Sine {
                mean: keys.number("mean", 0.0)?,
                amplitude: keys.number("amplitude", 0.0)?,
                period: keys.time("period", Duration::ZERO)?,
                phase: keys.time("phase", Duration::ZERO)?,
            })
        },
    },
    Kind {
        name: "square",
        about: "`high` (1) for `on` (half the period) at the beginning of each `period`, then `low` (0); it begins `phase` \
                (0) into a period.",
        keys: &[
            usual("high", Holds::Number),
            usual("low", Holds::Number),
            needed("period", Holds::Time),
            usual("on", Holds::Time),
            usual("phase", Holds::Time),
        ],
        make: |keys| {
            let period = keys.time("period", Duration::ZERO)?;
            Ok(Source::Square {
                high: keys.number("high", 1.0)?,
                low: keys.number("low", 0.0)?,
                period,
                on: keys.time("on", period / 2)?,
                phase: keys.time("phase", Duration::ZERO)?,
            })
        },
    },
    Kind {
        name: "random",
        about: "Another value from `least` (0) to `most` (1) `every` time, the same ones for the same `seed` (0).",
        keys: &[
            usual("least", Holds::Number),
            usual("most", Holds::Number),
            needed("every", Holds::Time),
            usual("seed", Holds::Whole),
        ],
        make: |keys| {
            Ok(Source::Random {
                least: keys.number("least", 0.0)?,
                most: keys.number("most", 1.0)?,
                every: keys.time("every", Duration::ZERO)?,
                seed: keys.whole("seed")?,
            })
        },
    },
    Kind {
        name: "table",
        about: "The rows SECONDS;VALUE of the CSV `file`, again after the time `repeat` (never).",
        keys: &[needed("file", Holds::File), usual("repeat", Holds::Time)],
        make: |keys| {
            let repeat = keys.given("repeat").map(|_| keys.time("repeat", Duration::ZERO)).transpose()?;
            Ok(Source::Table { rows: keys.rows()?, repeat })
        },
    },
    Kind {
        name: "follow",
        about: "The value `of` of another `station` of this or another `line` (number), `delay` (0) later.",
        keys: &[
            usual("line", Holds::Whole),
            needed("station", Holds::Whole),
            needed("of", Holds::Value),
            usual("delay", Holds::Time),
        ],
        make: |keys| Ok(Source::Follow { of: keys.value(), delay: keys.time("delay", Duration::ZERO)? }),
    },
    Kind {
        name: "lag",
        about: "The value `of` through a lag of first order with the time constant `time`.",
        keys: &[needed("of", Holds::Value), needed("time", Holds::Time)],
        make: |keys| Ok(Source::Lag { of: keys.value(), time: keys.time("time", Duration::ZERO)? }),
    },
    Kind {
        name: "scale",
        about: "`factor` (1) * the value `of` + `offset` (0).",
        keys: &[needed("of", Holds::Value), usual("factor", Holds::Number), usual("offset", Holds::Number)],
        make: |keys| {
            Ok(Source::Scale {
                of: keys.value(),
                factor: keys.number("factor", 1.0)?,
                offset: keys.number("offset", 0.0)?,
            })
        },
    },
    Kind {
        name: "compare",
        about: "1 while the value `of` is equal to `is`, greater than `above` or less than `below`, else 0.",
        keys: &[
            needed("of", Holds::Value),
            usual("is", Holds::Number),
            usual("above", Holds::Number),
            usual("below", Holds::Number),
        ],
        make: |keys| Ok(Source::Compare { of: keys.value(), condition: keys.condition()? }),
    },
    Kind {
        name: "not",
        about: "1 while the value `of` is 0, else 0.",
        keys: &[needed("of", Holds::Value)],
        make: |keys| Ok(Source::Not(keys.value())),
    },
    Kind {
        name: "and",
        about: "1 while none of the values `of` is 0, else 0.",
        keys: &[needed("of", Holds::Values)],
        make: |keys| Ok(Source::And(keys.values())),
    },
    Kind {
        name: "or",
        about: "1 while one of the values `of` is not 0, else 0.",
        keys: &[needed("of", Holds::Values)],
        make: |keys| Ok(Source::Or(keys.values())),
    },
];

/// Reads a signal. `own` are the keys of the value that follows it; paths of files begin in `folder`.
///
/// # Errors
/// [`Wrong`] says which key.
pub(crate) fn read(given: &[(String, Given)], own: &[&str], folder: &Path) -> Result<Source<Given>, Wrong> {
    let named = given.iter().find(|(key, _)| key == BEHAVIOUR);
    let kind = match named {
        None => KINDS.first(),
        Some((_, name)) => {
            let name = name.to_string();
            let kind = KINDS.iter().find(|kind| kind.name == name);
            if kind.is_none() {
                let names: Vec<_> = KINDS.iter().map(|kind| kind.name).collect();
                let near = near(&name, names.iter().copied());
                let words = format!("{BEHAVIOUR} '{name}' is unknown; {near}expected {}", one_of(&names));
                return Err(Wrong::at(BEHAVIOUR, words));
            }
            kind
        }
    };
    let Some(kind) = kind else { return Err(Wrong::whole("there are no signals")) };
    for (before, (key, _)) in given.iter().enumerate() {
        if given.iter().take(before).any(|(known, _)| known == key) {
            return Err(Wrong::key(key, format!("'{key}' is given twice")));
        }
        let is_its = kind.keys.iter().any(|known| known.name == key) || own.contains(&&**key);
        if is_its || key == BEHAVIOUR {
            continue;
        }
        let of_kinds = KINDS.iter().flat_map(|kind| kind.keys).map(|key| key.name);
        let expected: Vec<_> = kind.keys.iter().map(|key| key.name).collect();
        if of_kinds.clone().any(|known| known == key) {
            let words = format!("{BEHAVIOUR} {} has no '{key}'; expected {}", kind.name, expected.join(", "));
            return Err(Wrong::at(key, words));
        }
        let near = near(key, of_kinds.chain(own.iter().copied()).chain([BEHAVIOUR]));
        let words = format!("'{key}' is unknown; {near}expected {}", [own, &expected].concat().join(", "));
        return Err(Wrong::key(key, words));
    }
    let keys = Keys { given, folder };
    if let Some(missing) = kind.keys.iter().find(|key| key.required && keys.given(key.name).is_none()) {
        let words = format!("{BEHAVIOUR} {} needs '{}': {}", kind.name, missing.name, kind.about);
        return Err(if named.is_some() { Wrong::at(BEHAVIOUR, words) } else { Wrong::whole(words) });
    }
    (kind.make)(&keys)
}

/// A number, also as text.
pub(super) fn number(key: &str, given: &Given) -> Result<f64, Wrong> {
    match given {
        Given::Number(number) => Some(*number),
        Given::Text(text) => text.parse().ok(),
        Given::Flag(_) | Given::List(_) | Given::Table(_) => None,
    }
    .ok_or_else(|| Wrong::at(key, format!("{key}: expected a number, not {given}")))
}

/// A whole number from 0, also as text.
pub(super) fn whole<N: TryFrom<u32>>(key: &str, given: &Given) -> Result<N, Wrong> {
    let wrong = || Wrong::at(key, format!("{key}: expected a whole number, not {given}"));
    let number = number(key, given)?;
    let is_whole = libm::trunc(number) == number && (0.0..=f64::from(u32::MAX)).contains(&number);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole and within u32")]
    let number = if is_whole { number as u32 } else { return Err(wrong()) };
    N::try_from(number).map_err(|_| Wrong::at(key, format!("{key}: {number} is too large")))
}

/// What a signal was given.
struct Keys<'a> {
    given: &'a [(String, Given)],
    folder: &'a Path,
}

impl Keys<'_> {
    fn given(&self, key: &str) -> Option<&Given> {
        self.given.iter().find(|(known, _)| known == key).map(|(_, given)| given)
    }

    fn number(&self, key: &str, usual: f64) -> Result<f64, Wrong> {
        self.given(key).map_or(Ok(usual), |given| number(key, given))
    }

    fn whole(&self, key: &str) -> Result<u32, Wrong> {
        self.given(key).map_or(Ok(0), |given| whole(key, given))
    }

    fn time(&self, key: &str, usual: Duration) -> Result<Duration, Wrong> {
        let Some(given) = self.given(key) else { return Ok(usual) };
        let text = given.to_string();
        duration(&text).ok_or_else(|| Wrong::at(key, no_time(&text)))
    }

    /// One of the words of a key; empty: none was given.
    fn word(&self, key: &str) -> Result<&'static str, Wrong> {
        let Some(given) = self.given(key) else { return Ok("") };
        let text = given.to_string();
        let known = KINDS.iter().flat_map(|kind| kind.keys).find_map(|known| {
            let Holds::OneOf(words) = known.holds else { return None };
            (known.name == key).then_some(words)
        });
        let known = known.unwrap_or_default();
        known.iter().find(|word| **word == text).copied().ok_or_else(|| {
            let near = near(&text, known.iter().copied());
            Wrong::at(key, format!("{key} '{text}' is unknown; {near}expected {}", one_of(known)))
        })
    }

    /// The value elsewhere, with the line and the station that are named beside it.
    fn value(&self) -> Given {
        let of = self.given("of").cloned().unwrap_or(Given::Flag(false));
        let places = ["line", "station"].map(|key| Some((key, self.given(key)?)));
        let places: Vec<_> = places.into_iter().flatten().collect();
        match of {
            Given::Text(text) => {
                let places: String = places.iter().map(|(_, place)| format!("{place}/")).collect();
                Given::Text(format!("{places}{text}"))
            }
            Given::Table(mut keys) => {
                keys.extend(places.into_iter().map(|(key, place)| (key.to_owned(), place.clone())));
                Given::Table(keys)
            }
            Given::Flag(_) | Given::Number(_) | Given::List(_) => of,
        }
    }

    /// Several of them, on the command line with a plus between two.
    fn values(&self) -> Vec<Given> {
        match self.given("of") {
            Some(Given::List(all)) => all.clone(),
            Some(Given::Text(all)) => all.split('+').map(|one| Given::Text(one.to_owned())).collect(),
            Some(one) => vec![one.clone()],
            None => Vec::new(),
        }
    }

    fn condition(&self) -> Result<Condition, Wrong> {
        let limits = LIMITS.map(|key| self.given(key).map(|given| number(key, given)));
        match limits {
            [Some(limit), None, None] => Ok(Condition::Is(limit?)),
            [None, Some(limit), None] => Ok(Condition::Above(limit?)),
            [None, None, Some(limit)] => Ok(Condition::Below(limit?)),
            _ => Err(Wrong::at(BEHAVIOUR, "expected one of is, above, below")),
        }
    }

    fn rows(&self) -> Result<Table, Wrong> {
        let path = self.folder.join(self.given("file").map(Given::to_string).unwrap_or_default());
        let wrong = |words: String| Wrong::at("file", words);
        let text = std::fs::read_to_string(&path)
            .map_err(|error| wrong(format!("cannot read {}: {error}", path.display())))?;
        Table::read(&text).map_err(|error| wrong(format!("{}: {error}", path.display())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Vec<(String, Given)> {
        let parts = text.split(' ').filter_map(|part| part.split_once('='));
        parts.map(|(key, value)| (key.to_owned(), Given::Text(value.to_owned()))).collect()
    }

    fn of(text: &str) -> Given {
        Given::Text(text.to_owned())
    }

    #[test]
    fn every_kind_is_made_from_its_keys_and_is_in_the_page_with_all_of_them() {
        let ms = Duration::from_millis;
        let given: &[(&str, Source<Given>)] = &[
            ("value=5", Source::Constant(5.0)),
            ("behaviour=mirror of=1/0/bit0", Source::Follow { of: of("1/0/bit0"), delay: ms(0) }),
            (
                "behaviour=count from=0 to=3 every=1s",
                Source::Count { from: 0.0, to: 3.0, step: 1.0, every: ms(1000) },
            ),
            (
                "behaviour=ramp from=0 to=3 time=1s then=return",
                Source::Ramp { from: 0.0, to: 3.0, time: ms(1000), then: AtEnd::Return },
            ),
            (
                "behaviour=sine amplitude=2 period=1s",
                Source::Sine { mean: 0.0, amplitude: 2.0, period: ms(1000), phase: ms(0) },
            ),
            (
                "behaviour=square period=1s high=7",
                Source::Square { high: 7.0, low: 0.0, period: ms(1000), on: ms(500), phase: ms(0) },
            ),
            (
                "behaviour=random most=9 every=1s seed=3",
                Source::Random { least: 0.0, most: 9.0, every: ms(1000), seed: 3 },
            ),
            (
                "behaviour=table file=level.csv",
                Source::Table { rows: Table::read("0;1").unwrap(), repeat: None },
            ),
            (
                "behaviour=follow line=2 station=9 of=1/0/bit0 delay=5ms",
                Source::Follow { of: of("2/9/1/0/bit0"), delay: ms(5) },
            ),
            ("behaviour=lag of=1/0/bit0 time=1s", Source::Lag { of: of("1/0/bit0"), time: ms(1000) }),
            (
                "behaviour=scale of=1/0/bit0 offset=1",
                Source::Scale { of: of("1/0/bit0"), factor: 1.0, offset: 1.0 },
            ),
            (
                "behaviour=compare of=1/0/bit0 above=1",
                Source::Compare { of: of("1/0/bit0"), condition: Condition::Above(1.0) },
            ),
            ("behaviour=not of=a", Source::Not(of("a"))),
            ("behaviour=and of=a+b", Source::And(vec![of("a"), of("b")])),
            ("behaviour=or of=a+b", Source::Or(vec![of("a"), of("b")])),
        ];
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("level.csv"), "0;1\n").unwrap();
        assert_eq!(given.len(), KINDS.len());
        let page = include_str!("../../../docs/line.md");
        for (kind, (text, source)) in KINDS.iter().zip(given) {
            assert_eq!(read(&table(text), &[], folder.path()).as_ref(), Ok(source), "{text}");
            let row = page.lines().find(|line| line.starts_with(&format!("| {}", kind.name)));
            let row = row.unwrap_or_else(|| panic!("{} is not in docs/line.md", kind.name));
            for key in kind.keys {
                assert!(row.contains(&format!("`{}`", key.name)), "{} {}", kind.name, key.name);
            }
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_key() {
        for (text, key, words) in [
            ("behaviour=rmp", "behaviour", "'rmp' is unknown; did you mean ramp? expected constant, mirror"),
            ("behaviour=ramp from=0", "behaviour", "ramp needs 'to'"),
            ("", "", "constant needs 'value'"),
            ("value=x", "value", "value: expected a number, not x"),
            ("value=5 from=3", "from", "constant has no 'from'; expected value"),
            ("value=5 vaule=3", "vaule", "'vaule' is unknown; did you mean value?"),
            ("value=5 value=3", "value", "is given twice"),
            ("behaviour=ramp from=0 to=1 time=1h", "time", "'1h' is no time"),
            ("behaviour=ramp from=0 to=1 time=1s then=stop", "then", "expected hold, repeat or return"),
            ("behaviour=random every=1s seed=-1", "seed", "seed: expected a whole number, not -1"),
            ("behaviour=compare of=a", "behaviour", "expected one of is, above, below"),
            ("behaviour=compare of=a is=1 above=2", "behaviour", "expected one of is, above, below"),
            ("behaviour=table file=no.csv", "file", "cannot read"),
        ] {
            let wrong = read(&table(text), &["slot"], Path::new("")).unwrap_err();
            assert_eq!(wrong.path.join("."), key, "{text}: {wrong}");
            assert!(wrong.words.contains(words), "{text}: {wrong}");
        }
    }
}
