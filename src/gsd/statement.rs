//! A line as keyword, argument and values.
//!
//! ```text
//! keyword ( argument - end ) = "text" number , number - number
//! ```

use super::hint::Place;
use super::lines::{Kind, Line, Token, number};

/// A line, taken apart. Its values are read as what the keyword wants.
pub(super) struct Statement<'a> {
    pub(super) place: Place,
    /// In lower case, without `!`, with `_` for a blank; empty where a line is only a number.
    pub(super) keyword: String,
    /// As in the file.
    pub(super) spelled: String,
    pub(super) blank_in_keyword: bool,
    /// A `!` in the keyword.
    pub(super) inverted: bool,
    pub(super) argument: Option<i64>,
    pub(super) argument_end: Option<i64>,
    values: &'a [Token],
}

/// The numbers of `Type default range-or-set`.
#[derive(Default)]
pub(super) struct Definition {
    pub(super) default: Option<i64>,
    pub(super) range: Option<(i64, i64)>,
    pub(super) set: Vec<i64>,
}

impl<'a> Statement<'a> {
    /// `None` for a line without any meaning.
    pub(super) fn of(line: &'a Line) -> Option<Self> {
        let mut tokens = line.tokens.as_slice();
        let first = tokens.first()?;
        let mut statement = Self {
            place: first.place,
            keyword: String::new(),
            spelled: String::new(),
            blank_in_keyword: false,
            inverted: false,
            argument: None,
            argument_end: None,
            values: tokens,
        };
        let is_equation = tokens.iter().any(|token| matches!(token.kind, Kind::Sign('=')));
        match &first.kind {
            Kind::Word(word) if is_equation || number(word).is_none() => {}
            Kind::Word(_) | Kind::Text(_) | Kind::Sign(_) => return Some(statement),
        }
        while let Some((Token { kind: Kind::Word(word), .. }, rest)) = tokens.split_first() {
            if !statement.spelled.is_empty() {
                // Without = the words behind the first are values.
                if !is_equation {
                    break;
                }
                statement.blank_in_keyword = true;
                statement.spelled.push(' ');
            }
            statement.spelled.push_str(word);
            tokens = rest;
        }
        statement.inverted = statement.spelled.contains('!');
        let plain = statement.spelled.chars().filter(|c| *c != '!');
        statement.keyword = plain.map(|c| if c == ' ' { '_' } else { c.to_ascii_lowercase() }).collect();
        if let Some(behind) = after(tokens, '(') {
            let mut numbers = Numbers(behind);
            statement.argument = numbers.number();
            if after(numbers.0, '-').is_some() {
                numbers.skip();
                statement.argument_end = numbers.number();
            }
            let closed = numbers.0.iter().position(|token| token.kind == Kind::Sign(')'));
            tokens = closed.and_then(|closed| numbers.0.get(closed + 1..)).unwrap_or_default();
        }
        statement.values = after(tokens, '=').unwrap_or(tokens);
        Some(statement)
    }

    /// The first string.
    pub(super) fn text(&self) -> Option<&'a str> {
        self.values.iter().find_map(|token| match &token.kind {
            Kind::Text(text) => Some(text.as_str()),
            Kind::Word(_) | Kind::Sign(_) => None,
        })
    }

    /// The first value, if it is a number.
    pub(super) fn first(&self) -> Option<i64> {
        Numbers(self.values).number()
    }

    /// The first value, if it is a number that fits.
    pub(super) fn number<T: TryFrom<i64>>(&self) -> Option<T> {
        self.first().and_then(|number| T::try_from(number).ok())
    }

    /// Whether a switch is on: any number but 0.
    pub(super) fn is_on(&self) -> bool {
        self.first().is_some_and(|number| number != 0)
    }

    /// `FIRST-LAST`.
    pub(super) fn span(&self) -> Option<(i64, i64)> {
        let mut numbers = Numbers(self.values);
        let first = numbers.number()?;
        if after(numbers.0, '-').is_none() {
            return Some((first, first));
        }
        numbers.skip();
        Some((first, numbers.number()?))
    }

    /// The values behind the string, if there is one, as octets; `None` if one is no octet.
    pub(super) fn octets(&self) -> Option<Vec<u8>> {
        let (mut numbers, mut octets) = (Numbers(self.behind_text()), Vec::new());
        while !numbers.0.is_empty() {
            if after(numbers.0, ',').is_some() {
                numbers.skip();
                continue;
            }
            octets.push(u8::try_from(numbers.number()?).ok()?);
        }
        Some(octets)
    }

    /// The values of a parameter's definition.
    pub(super) fn definition(&self) -> Definition {
        let mut numbers = Numbers(self.values);
        let mut definition = Definition::default();
        // A range begins at once where a number and a minus stand without a blank between: `0-1`.
        let ahead = self.values.get(1..).unwrap_or_default();
        let begins_with_range =
            ahead.first().is_some_and(|token| token.glued && token.kind == Kind::Sign('-'));
        if !begins_with_range {
            definition.default = numbers.number();
        }
        while let Some(least) = numbers.number() {
            if after(numbers.0, '-').is_some() {
                numbers.skip();
                definition.range = numbers.number().map(|most| (least, most));
                break;
            }
            definition.set.push(least);
            if after(numbers.0, ',').is_some() {
                numbers.skip();
            }
        }
        definition
    }

    /// `"name" default references`: the default and the references, as ranges.
    pub(super) fn slot(&self) -> (Option<u32>, Vec<(u32, u32)>) {
        let reference = |number: i64| u32::try_from(number).ok();
        let mut numbers = Numbers(self.behind_text());
        let default = numbers.number().and_then(reference);
        let mut references = Vec::new();
        while let Some(first) = numbers.number() {
            let mut last = first;
            if after(numbers.0, '-').is_some() {
                numbers.skip();
                last = numbers.number().unwrap_or(first);
            }
            references.extend(reference(first).zip(reference(last)));
            if after(numbers.0, ',').is_some() {
                numbers.skip();
            }
        }
        (default, references)
    }

    fn behind_text(&self) -> &'a [Token] {
        let text = self.values.iter().position(|token| matches!(token.kind, Kind::Text(_)));
        text.and_then(|text| self.values.get(text + 1..)).unwrap_or(self.values)
    }
}

/// The tokens behind a sign, if it is the first.
fn after(tokens: &[Token], sign: char) -> Option<&[Token]> {
    tokens.split_first().filter(|(token, _)| token.kind == Kind::Sign(sign)).map(|(_, rest)| rest)
}

/// Tokens, read as numbers.
struct Numbers<'a>(&'a [Token]);

impl Numbers<'_> {
    /// The next number with its sign; nothing is taken if there is none.
    fn number(&mut self) -> Option<i64> {
        let (negative, tokens) = match after(self.0, '-') {
            Some(tokens) => (true, tokens),
            None => (false, self.0),
        };
        let (Token { kind: Kind::Word(word), .. }, rest) = tokens.split_first()? else { return None };
        let value = number(word)?;
        self.0 = rest;
        Some(if negative { -value } else { value })
    }

    fn skip(&mut self) {
        self.0 = self.0.get(1..).unwrap_or_default();
    }
}
