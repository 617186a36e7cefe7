//! Hexadecimal numbers in a line, and how wide each is.

use super::TextError;

const SEPARATORS: [char; 16] =
    [' ', '\t', ',', ':', '-', '_', '"', '\'', '{', '}', '[', ']', '(', ')', '<', '>'];

/// What names the type of a PLC's number before `#16#`, and its octets.
const TYPES: [(&str, usize); 6] = [("B", 1), ("BYTE", 1), ("W", 2), ("WORD", 2), ("DW", 4), ("DWORD", 4)];

/// Digits with all around them that says how they are meant.
#[derive(Clone, Copy)]
struct Number<'a> {
    /// As it stands in the text.
    token: &'a str,
    digits: &'a str,
    notation: Notation,
}

#[derive(Clone, Copy, PartialEq)]
enum Notation {
    /// Nothing before the digits.
    Plain,
    /// `0x` or `$`.
    Prefixed,
    /// `16#`.
    Based,
    /// `W#16#`: the type says how many octets.
    Typed(usize),
}

/// The octets of numbers. Words without digits at the front that cannot be numbers are a label.
pub(super) fn numbers(text: &str) -> Result<Vec<u8>, TextError> {
    let text = text.replace("\\x", " ");
    // Between the digits of a PLC's number it only helps to read.
    let text = if text.contains("16#") { text.replace('_', "") } else { text };
    let mut numbers: Vec<Number<'_>> = Vec::new();
    let mut tokens = text.split(SEPARATORS).filter(|token| !token.is_empty()).peekable();
    while let Some(token) = tokens.next() {
        let number = Number::of(token);
        if !number.digits.is_empty() && number.digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            numbers.push(number);
            continue;
        }
        let found = shortened(token);
        if token.chars().any(|char| ('\u{ff10}'..='\u{ff5a}').contains(&char)) {
            return Err(TextError::FullWidth { found });
        }
        let word = !token.chars().any(char::is_numeric);
        if !(numbers.is_empty() && word && tokens.peek().is_some()) {
            return Err(TextError::NotHex { found });
        }
    }
    let words = are_words(&numbers)?;
    let mut octets = Vec::new();
    for number in numbers {
        number.write(words, &mut octets)?;
    }
    Ok(octets)
}

/// Whether numbers without their leading zeros are words: one has more than two digits, none more than four.
fn are_words(numbers: &[Number<'_>]) -> Result<bool, TextError> {
    let mixed = |number: &Number<'_>| Err(TextError::Mixed { found: shortened(number.token) });
    let of_plc = |number: &&Number<'_>| matches!(number.notation, Notation::Based | Notation::Typed(_));
    // `16#1` may be the end of a telegram and a comment.
    if let Some(number) = numbers.iter().find(of_plc)
        && !numbers.iter().all(|number| of_plc(&number))
    {
        return mixed(number);
    }
    let marked = |number: &&Number<'_>| matches!(number.notation, Notation::Prefixed | Notation::Based);
    let len = |number: &Number<'_>| number.digits.len();
    let longest = numbers.iter().filter(marked).map(len).max().unwrap_or(0);
    let Some(short) = numbers.iter().filter(marked).find(|number| len(number) < longest.min(4)) else {
        return Ok(longest == 3 && numbers.iter().all(|number| marked(&number)));
    };
    if longest <= 2 {
        return Ok(false);
    }
    // Who writes the zeros of an octet writes those of a word; five digits and more are no word.
    let zero = |number: &&Number<'_>| len(number) == 2 && number.digits.starts_with('0');
    match numbers.iter().filter(marked).find(zero) {
        Some(number) => mixed(number),
        None if longest > 4 || !numbers.iter().all(|number| marked(&number)) => mixed(short),
        None => Ok(true),
    }
}

impl<'a> Number<'a> {
    /// The token without what marks it as hexadecimal.
    fn of(token: &'a str) -> Self {
        if let Some((front, digits)) = token.rsplit_once("16#")
            && let Some(notation) = plc_notation(front)
        {
            return Self { token, digits, notation };
        }
        let stripped = ["0x", "0X", "$"].iter().find_map(|prefix| token.strip_prefix(prefix));
        let digits = stripped.unwrap_or(token);
        let digits = digits.strip_suffix(['h', 'H']).unwrap_or(digits);
        match stripped {
            // The suffixes of C and Rust: 0x68u, 0x68u8.
            Some(_) => {
                let digits = digits.split(['u', 'U']).next().unwrap_or(digits);
                Self { token, digits, notation: Notation::Prefixed }
            }
            None => Self { token, digits, notation: Notation::Plain },
        }
    }

    /// Appends its octets, high octet first; as a word at least two if it has no width of its own.
    fn write(self, word: bool, octets: &mut Vec<u8>) -> Result<(), TextError> {
        let least = match self.notation {
            Notation::Plain => 0,
            Notation::Prefixed | Notation::Based if word => 4,
            // 0x5 is clear, 5 between other octets is not.
            Notation::Prefixed | Notation::Based if self.digits.len() == 1 => 2,
            Notation::Prefixed | Notation::Based => 0,
            Notation::Typed(octets) => octets * 2,
        };
        let found = || shortened(self.token);
        if matches!(self.notation, Notation::Typed(_)) && self.digits.len() > least {
            return Err(TextError::TooLong { found: found() });
        }
        let zeros = least.saturating_sub(self.digits.len());
        if (zeros + self.digits.len()) % 2 == 1 {
            return Err(TextError::OddDigits { found: found() });
        }
        let digits: String = core::iter::repeat_n('0', zeros).chain(self.digits.chars()).collect();
        let pairs = digits.as_bytes().chunks(2).filter_map(|pair| core::str::from_utf8(pair).ok());
        octets.extend(pairs.filter_map(|pair| u8::from_str_radix(pair, 16).ok()));
        Ok(())
    }
}

/// The notation of a PLC by what is before `16#`; `None` if that is none.
fn plc_notation(front: &str) -> Option<Notation> {
    if front.is_empty() {
        return Some(Notation::Based);
    }
    let name = front.strip_suffix('#')?;
    let (_, octets) = TYPES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?;
    Some(Notation::Typed(*octets))
}

/// Whether this is a number of whole octets in hexadecimal and nothing else.
pub(super) fn is_number(token: &str) -> bool {
    let Number { digits, notation, .. } = Number::of(token.trim_end_matches(SEPARATORS));
    let hex = !digits.is_empty() && digits.split(SEPARATORS).all(is_hex);
    hex && (digits.len() > 1 || notation != Notation::Plain)
}

fn is_hex(digits: &str) -> bool {
    digits.bytes().all(|digit| digit.is_ascii_hexdigit())
}

/// Whether the `#` at this place belongs to a PLC's number and begins no comment.
pub(super) fn is_in_number(line: &str, at: usize) -> bool {
    let Some((front, behind)) = line.split_at_checked(at) else { return false };
    let start = front.rfind(|char: char| SEPARATORS.contains(&char) || "=;".contains(char));
    let front = start.and_then(|start| front.get(start + 1..)).unwrap_or(front);
    let behind = behind.trim_start_matches('#');
    let end = behind.find(|char: char| (SEPARATORS.contains(&char) && char != '_') || "#;/".contains(char));
    let (token, rest) = behind.split_at_checked(end.unwrap_or(behind.len())).unwrap_or((behind, ""));
    let digits =
        |text: &str| !text.is_empty() && text.bytes().all(|char| char.is_ascii_hexdigit() || char == b'_');
    match front.strip_suffix("16") {
        Some(before) => plc_notation(before).is_some() && digits(token),
        None => plc_notation(&(front.to_string() + "#")).is_some() && token == "16" && rest.starts_with('#'),
    }
}

pub(super) fn shortened(token: &str) -> String {
    const MOST: usize = 24;
    if token.chars().count() <= MOST {
        return token.to_string();
    }
    token.chars().take(MOST).chain("...".chars()).collect()
}
