//! The doubts of the references about devices on CANopen: each is a quirk or a line in docs/quirks.md.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::NodeId;
use profidrive::devices::CanopenDevice;
use profidrive::devices::ag03;
use profidrive::devices::ap10;
use profidrive::devices::asda_a2;
use profidrive::face::{Quirk, Surroundings};
use profidrive::time::Instant;

/// A quirk whatever it is of: name, register, values, what it decides.
type Row = (&'static str, &'static str, &'static [&'static str], &'static str);

fn rows<C>(table: &'static [Quirk<C>]) -> Vec<Row> {
    table.iter().map(|quirk| (quirk.name, quirk.register, quirk.values, quirk.about)).collect()
}

/// Each device: its reference and the heading of its doubts, the heading of its part of the document, its quirks.
fn devices() -> [(&'static str, &'static str, &'static str, Vec<Row>); 4] {
    [
        ("canopen-ag03.md", "## 16. Open points", "### AG03/1", rows(ag03::canopen::QUIRKS)),
        ("canopen-ap10.md", "## 17. Open points", "### AP10", rows(ap10::canopen::QUIRKS)),
        ("canopen-asda-a2.md", "## 14. Open points", "### ASDA-A2", rows(asda_a2::canopen::QUIRKS)),
        ("canopen-link.md", "## 16. Doubts", "### The bus and its adapters", Vec::new()),
    ]
}

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// What stands below a heading up to the next one.
fn section<'t>(text: &'t str, heading: &str) -> &'t str {
    let (_, rest) = text.split_once(heading).unwrap_or_else(|| panic!("no '{heading}'"));
    rest.split("\n#").next().unwrap()
}

/// The numbers in the first column of a table.
fn doubts(section: &str) -> BTreeSet<u16> {
    let first = section.lines().filter_map(|line| line.strip_prefix("| ")?.split(" |").next());
    first.filter_map(|cell| cell.parse().ok()).collect()
}

/// Every `CN-12` and every `CN-12 to CN-15` of a text.
fn named(text: &str) -> Vec<u16> {
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut found: Vec<u16> = Vec::new();
    let mut parts = text.split("CN-");
    let mut before = parts.next().unwrap_or_default();
    for part in parts {
        let digits: String = part.chars().take_while(char::is_ascii_digit).collect();
        let number: u16 = digits.parse().unwrap();
        match found.last().copied() {
            Some(first) if before.trim_start_matches(|sign: char| sign.is_ascii_digit()) == " to " => {
                found.extend(first + 1..=number);
            }
            Some(_) | None => found.push(number),
        }
        before = part;
    }
    found
}

#[test]
fn each_doubt_is_a_quirk_or_has_a_line_why_not() {
    let document = read("docs/quirks.md");
    for (reference, heading, part, quirks) in devices() {
        let reference_text = read(&format!("docs/reference/{reference}"));
        let doubts = doubts(section(&reference_text, heading));
        assert!(doubts.len() >= 12, "{reference}: {doubts:?}");
        let (_, excuses) = section(&document, part).split_once("Not a choice:").unwrap();
        let chosen = quirks.iter().flat_map(|(_, register, ..)| named(register));
        let mut said: Vec<u16> = chosen.chain(named(excuses)).collect();
        said.sort_unstable();
        let once: BTreeSet<u16> = said.iter().copied().collect();
        assert_eq!(once, doubts, "{reference}: these are said");
        assert_eq!(said.len(), once.len(), "{reference}: said twice in {said:?}");
    }
}

#[test]
fn the_tables_of_the_document_are_those_of_the_code() {
    let document = read("docs/quirks.md");
    for (reference, _, part, quirks) in devices() {
        let rows: Vec<&str> =
            section(&document, part).lines().filter(|line| line.starts_with("| `")).collect();
        let expected: Vec<String> = quirks
            .iter()
            .map(|(name, register, values, about)| {
                format!("| `{name}` | {register} | `{}` | {about} |", values.join("`, `"))
            })
            .collect();
        assert_eq!(rows, expected, "{reference}");
    }
}

/// What an AG03/1 with a quirk answers to reading 1000h, and the EMCY of fault F.
fn answers(quirk: &str, value: &str) -> [Vec<String>; 2] {
    let now = Instant::from_millis(1);
    let mut config = ag03::canopen::Config::new(NodeId::new(5).unwrap());
    config.set_quirk(quirk, value).unwrap();
    let mut node = ag03::canopen::Ag03Node::new(config, now);
    let drain = |node: &mut ag03::canopen::Ag03Node| -> Vec<String> {
        std::iter::from_fn(|| node.poll_transmit(now)).map(|frame| frame.to_string()).collect()
    };
    drain(&mut node);
    let request = [0x40, 0x00, 0x10, 0, 0, 0, 0, 0];
    node.handle_frame(now, &Frame::data(Id::base(0x605).unwrap(), &request).unwrap());
    let answer = drain(&mut node);
    Surroundings::provoke(&mut node, now, "F").unwrap();
    [answer, drain(&mut node)]
}

#[test]
fn the_order_of_emcy_codes_and_the_command_of_four_octets_can_be_chosen() {
    let [four, _] = answers("sdo-size", "43");
    assert!(four.len() == 1 && four[0].starts_with("585#43 00 10 00"), "{four:?}");
    let [other, _] = answers("sdo-size", "42");
    assert_eq!(other, [four[0].replace("585#43", "585#42")]);

    let [_, low] = answers("emcy-order", "low");
    let [_, high] = answers("emcy-order", "high");
    let (low, high) = (&low[0], &high[0]);
    assert!(low.starts_with("085#") && high.starts_with("085#"), "{low} {high}");
    assert_eq!((&low[4..6], &low[7..9], &low[9..]), (&high[7..9], &high[4..6], &high[9..]));
    assert_ne!(low, high);
}

#[test]
fn lists_of_doubts_are_read_with_their_ranges() {
    assert_eq!(named("CN-01 (81h), CN-19 to\nCN-22, CN-30."), [1, 19, 20, 21, 22, 30]);
    assert_eq!(named("CN-05, 10 to CN-07"), [5, 7]);
}
