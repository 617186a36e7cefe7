//! Text to lines of tokens: comments, continuations, strings (`gsd.md` 1.2).

use super::hint::Place;

/// A line of the file with those that continue it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Line {
    pub(super) tokens: Vec<Token>,
}

/// A piece of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Token {
    pub(super) place: Place,
    /// No blank stands before it.
    pub(super) glued: bool,
    pub(super) kind: Kind,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A keyword or a number.
    Word(String),
    /// A string, without its quotes.
    Text(String),
    /// One of the signs between them.
    Sign(char),
}

/// What no word holds.
const SIGNS: [char; 8] = ['=', '(', ')', ',', '-', '"', ';', '\\'];

/// The lines behind the header, the place of the header, and the strings that are not closed. `None` without header.
pub(super) fn lines(text: &str) -> Option<(Vec<Line>, Place, Vec<Place>)> {
    let mut physical = physical_lines(text).zip(1..);
    let (_, header) = physical.find(|(line, _)| is_header(line))?;
    let mut lexer = Lexer::default();
    for (line, number) in physical {
        lexer.line(line, number);
    }
    lexer.end_string();
    lexer.end_line();
    Some((lexer.lines, Place { line: header, column: 1 }, lexer.unclosed))
}

fn is_header(line: &str) -> bool {
    const HEADER: &[u8] = b"#Profibus_DP";
    let line = line.trim_start().as_bytes();
    line.get(..HEADER.len()).is_some_and(|start| start.eq_ignore_ascii_case(HEADER))
}

/// Lines end with CR LF, LF or CR.
fn physical_lines(text: &str) -> impl Iterator<Item = &str> {
    text.split('\n').flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'))
}

#[derive(Default)]
struct Lexer {
    lines: Vec<Line>,
    tokens: Vec<Token>,
    /// A string that goes on in the next line.
    string: Option<(Place, bool, String)>,
    unclosed: Vec<Place>,
    /// The line before ended with a backslash.
    continued: bool,
}

impl Lexer {
    fn line(&mut self, line: &str, number: u32) {
        let (mut rest, mut column, mut glued) = (line, 1_u32, false);
        let continued = core::mem::take(&mut self.continued);
        loop {
            if self.string.is_some() {
                let Some((inside, behind)) = rest.split_once('"') else {
                    return self.end_of_string_line(rest);
                };
                column = column.saturating_add(chars(inside)).saturating_add(1);
                rest = behind;
                if let Some((_, _, string)) = &mut self.string {
                    string.push_str(inside);
                }
                self.end_string();
                glued = true;
                continue;
            }
            let behind = rest.trim_start();
            if behind.len() != rest.len() {
                glued = false;
            }
            column = column.saturating_add(chars(rest).saturating_sub(chars(behind)));
            rest = behind;
            let place = Place { line: number, column };
            let Some(first) = rest.chars().next() else { break };
            let behind = rest.get(first.len_utf8()..).unwrap_or_default();
            match first {
                ';' => {
                    // A line of comment between two that belong together.
                    self.continued = continued && column_is_first(line, rest);
                    break;
                }
                '\\' if matches!(behind.trim_start().chars().next(), None | Some(';')) => {
                    self.continued = true;
                    break;
                }
                '"' => {
                    self.string = Some((place, glued, String::new()));
                    (rest, column) = (behind, column.saturating_add(1));
                }
                sign if SIGNS.contains(&sign) => {
                    self.tokens.push(Token { place, glued, kind: Kind::Sign(sign) });
                    (rest, column, glued) = (behind, column.saturating_add(1), true);
                }
                _word => {
                    let end = rest.find(|c: char| c.is_whitespace() || SIGNS.contains(&c));
                    let (word, behind) = rest.split_at(end.unwrap_or(rest.len()));
                    self.tokens.push(Token { place, glued, kind: Kind::Word(word.into()) });
                    (rest, column, glued) = (behind, column.saturating_add(chars(word)), true);
                }
            }
        }
        if !self.continued {
            self.end_line();
        }
    }

    /// A string that is not closed in its line goes on behind a backslash, else it ends.
    fn end_of_string_line(&mut self, rest: &str) {
        let Some((place, _, string)) = &mut self.string else { return };
        if let Some(before) = rest.trim_end().strip_suffix('\\') {
            string.push_str(before);
            self.continued = true;
            return;
        }
        string.push_str(rest);
        self.unclosed.push(*place);
        self.end_string();
        self.end_line();
    }

    fn end_string(&mut self) {
        if let Some((place, glued, string)) = self.string.take() {
            self.tokens.push(Token { place, glued, kind: Kind::Text(string) });
        }
    }

    fn end_line(&mut self) {
        let tokens = core::mem::take(&mut self.tokens);
        if !tokens.is_empty() {
            self.lines.push(Line { tokens });
        }
    }
}

/// Only blanks stand before `rest`, the end of `line`.
fn column_is_first(line: &str, rest: &str) -> bool {
    line.trim_start().len() == rest.len()
}

fn chars(text: &str) -> u32 {
    u32::try_from(text.chars().count()).unwrap_or(u32::MAX)
}

/// A number as the file writes it: decimal, also with zeros in front, or hexadecimal with 0x.
pub(super) fn number(word: &str) -> Option<i64> {
    let hex = word.strip_prefix("0x").or_else(|| word.strip_prefix("0X"));
    let (digits, radix) = hex.map_or((word, 10), |digits| (digits, 16));
    let is_digits = digits.chars().all(|c| c.is_ascii_hexdigit());
    is_digits.then(|| u32::from_str_radix(digits, radix).ok().map(i64::from)).flatten()
}

#[cfg(test)]
mod tests {

    use super::*;

    fn words(text: &str) -> Vec<String> {
        let (lines, _, _) = lines(&format!("#Profibus_DP\n{text}")).unwrap();
        let words = |line: &Line| {
            let words = line.tokens.iter().map(|token| match &token.kind {
                Kind::Word(word) => word.clone(),
                Kind::Text(text) => format!("<{text}>"),
                Kind::Sign(sign) => sign.to_string(),
            });
            words.collect::<Vec<_>>().join(" ")
        };
        lines.iter().map(words).collect()
    }

    #[test]
    fn comments_continuations_and_strings_are_told_apart() {
        for (text, expected) in [
            ("a = 1 ; b = 2\nc=3", &["a = 1", "c = 3"][..]),
            ("a = 1,\\\n  2", &["a = 1 , 2"]),
            ("a = 1,\\  \n  2", &["a = 1 , 2"]),
            ("a = 1,\\ ; one\n2\nb", &["a = 1 , 2", "b"]),
            ("a = 1,\\\n ; two\n 2", &["a = 1 , 2"]),
            ("a = \"x;y\\\n z\"\nb", &["a = <x;y z>", "b"]),
            ("a = \"x\\y\"", &["a = <x\\y>"]),
            ("a = \"x\nb = 1", &["a = <x>", "b = 1"]),
            ("a\r\nb\rc\n\n\nd", &["a", "b", "c", "d"]),
            ("Bit(4-6) -2 -10-10", &["Bit ( 4 - 6 ) - 2 - 10 - 10"]),
            ("a = \"\u{fc}\"", &["a = <\u{fc}>"]),
            ("a \\ b", &["a \\ b"]),
            ("a = 1,\\", &["a = 1 ,"]),
            ("a = \"x\\", &["a = <x>"]),
        ] {
            assert_eq!(words(text), expected, "{text}");
        }
    }

    #[test]
    fn the_header_is_found_behind_anything_and_in_any_case() {
        for text in ["#Profibus_DP", "x\n  #PROFIBUS_DP  ; start\na", "\u{feff}\n#profibus_dp\r"] {
            assert!(lines(text).is_some(), "{text}");
        }
        for text in ["", "Profibus_DP", "#Profibus", "; #Profibus_DP"] {
            assert!(lines(text).is_none(), "{text}");
        }
    }

    #[test]
    fn numbers_are_decimal_or_hexadecimal_and_never_octal() {
        for (word, value) in [
            ("0017", Some(17)),
            ("0xFF", Some(255)),
            ("0XfF", Some(255)),
            ("4294967295", Some(0xFFFF_FFFF)),
            ("4294967296", None),
            ("", None),
            ("0x", None),
            ("+1", None),
            ("1.5M", None),
            ("0x+1", None),
        ] {
            assert_eq!(number(word), value, "{word}");
        }
    }
}
