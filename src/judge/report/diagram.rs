//! The telegrams of a verdict as a drawing: time downwards, a line a station, an arrow a telegram, its meaning beside it.

use core::fmt::Write;

use super::ReportOf;
use super::markup::Text;
use crate::judge::moment::{Side, Telegram};
use crate::judge::requirement::Requirement;

/// Where the line of the master stands, and how far the next one is. In pixels, as everything here.
const MASTER_X: usize = 130;
const LANE: usize = 90;
/// The height of a line of text, and of the head.
const LINE: usize = 17;
const HEAD: usize = 44;
/// Characters of an explanation, and of octets, in a line.
const WORDS: usize = 92;
const OCTETS: usize = 96;
/// Lines of octets that are drawn at most.
const OCTET_LINES: usize = 2;
/// More than so many seconds between two telegrams are drawn as a gap.
const GAP: f64 = 0.2;
/// From this address on it is for everybody: a slave that has no address yet, and broadcast.
const EVERYBODY: u8 = 126;
/// How wide the text beside the lanes is.
const TEXT_WIDTH: usize = 720;

impl<R: Requirement> ReportOf<R> {
    /// The telegrams as inline SVG.
    pub(super) fn diagram(&self, name: &str, telegrams: &[Telegram]) -> String {
        let lanes = Lanes::of(telegrams);
        let mut rows = String::new();
        let mut y = HEAD;
        let mut before: Option<f64> = None;
        for telegram in telegrams {
            let at = self.seconds(telegram);
            if let Some(pause) = before.map(|before| at - before).filter(|pause| *pause > GAP) {
                let _ = writeln!(
                    rows,
                    "<text class=\"gap\" x=\"8\" y=\"{}\">… {pause:.3} s later</text>",
                    y + 12
                );
                y += LINE + 6;
            }
            before = Some(at);
            y += self.draw(&mut rows, &lanes, telegram, y);
        }
        let width = lanes.text_x() + TEXT_WIDTH;
        let mut svg = format!(
            "<svg class=\"bus\" role=\"img\" aria-label=\"Telegrams of {name}\" viewBox=\"0 0 {width} {height}\" \
             width=\"{width}\" height=\"{height}\" xmlns=\"http://www.w3.org/2000/svg\">\n",
            name = Text(name),
            height = y + 10
        );
        let _ = writeln!(svg, "<text class=\"head\" x=\"8\" y=\"18\">time in s</text>");
        for (title, x) in lanes.titles() {
            let _ = writeln!(
                svg,
                "<text class=\"head lane\" x=\"{x}\" y=\"18\">{}</text><path class=\"lane\" d=\"M{x} 26V{}\"/>",
                Text(&title),
                y + 4
            );
        }
        svg.push_str(&rows);
        svg.push_str("</svg>\n");
        svg
    }

    /// Draws one telegram and says how high it is.
    fn draw(&self, rows: &mut String, lanes: &Lanes, telegram: &Telegram, y: usize) -> usize {
        let Telegram { side, hex, explained, .. } = telegram;
        let middle = y + 8;
        let _ = writeln!(
            rows,
            "<text class=\"time\" x=\"8\" y=\"{}\">{:.6}</text>",
            y + 12,
            self.seconds(telegram)
        );
        let from = lanes.from(telegram);
        let class = if *side == Side::Master { "m" } else { "s" };
        match lanes.to(telegram) {
            Some(to) if to != from => {
                let head = if to > from { to - 7 } else { to + 7 };
                let _ = writeln!(
                    rows,
                    "<path class=\"{class}\" d=\"M{from} {middle}H{to}M{head} {}L{to} {middle}L{head} {}\"/>",
                    middle - 4,
                    middle + 4
                );
            }
            // To nobody on this drawing, or octets that are no telegram.
            Some(_) | None => {
                let _ = writeln!(rows, "<circle class=\"{class}\" cx=\"{from}\" cy=\"{middle}\" r=\"4\"/>");
            }
        }
        let x = lanes.text_x();
        let mut height = 0;
        let _ = writeln!(rows, "<g><title>{}</title>", Text(hex));
        for line in wrapped(explained, WORDS) {
            let _ = writeln!(rows, "<text x=\"{x}\" y=\"{}\">{}</text>", y + 12 + height, Text(&line));
            height += LINE;
        }
        let lines = wrapped(hex, OCTETS);
        for (number, line) in lines.iter().take(OCTET_LINES).enumerate() {
            let more = if number + 1 == OCTET_LINES && lines.len() > OCTET_LINES {
                format!(" … {} octets", hex.split_whitespace().count())
            } else {
                String::new()
            };
            let _ =
                writeln!(rows, "<text class=\"hex\" x=\"{x}\" y=\"{}\">{line}{more}</text>", y + 12 + height);
            height += LINE;
        }
        rows.push_str("</g>\n");
        height + 8
    }
}

/// A line a station: the master, then the stations in their order, then what nobody known has sent.
struct Lanes {
    stations: Vec<u8>,
    nobody: bool,
}

impl Lanes {
    fn of(telegrams: &[Telegram]) -> Self {
        let mut stations = Vec::new();
        for telegram in telegrams {
            let to = telegram.to.filter(|address| *address < EVERYBODY);
            match telegram.side {
                Side::Station(Some(address)) => stations.push(address.number()),
                Side::Master => stations.extend(to),
                Side::Other(address) => {
                    stations.push(address.number());
                    stations.extend(to);
                }
                Side::Station(None) => {}
            }
        }
        let of_master = telegrams.iter().filter(|telegram| telegram.side == Side::Master);
        let masters: Vec<u8> = of_master.filter_map(|telegram| telegram.from).collect();
        stations.retain(|station| !masters.contains(station));
        stations.sort_unstable();
        stations.dedup();
        let nobody = telegrams.iter().any(|telegram| telegram.side == Side::Station(None));
        Self { stations, nobody }
    }

    const fn count(&self) -> usize {
        1 + self.stations.len() + if self.nobody { 1 } else { 0 }
    }

    const fn text_x(&self) -> usize {
        MASTER_X + LANE * (self.count() - 1) + 50
    }

    fn titles(&self) -> Vec<(String, usize)> {
        let stations = self.stations.iter().map(|station| format!("station {station}"));
        let titles = core::iter::once("master".to_string()).chain(stations);
        titles
            .chain(self.nobody.then(|| "?".into()))
            .enumerate()
            .map(|(lane, title)| (title, x(lane)))
            .collect()
    }

    fn lane(&self, station: u8) -> Option<usize> {
        self.stations.iter().position(|known| *known == station).map(|lane| x(lane + 1))
    }

    fn from(&self, telegram: &Telegram) -> usize {
        match telegram.side {
            Side::Master => MASTER_X,
            Side::Station(Some(address)) | Side::Other(address) => {
                self.lane(address.number()).unwrap_or(MASTER_X)
            }
            Side::Station(None) => x(self.count() - 1),
        }
    }

    fn to(&self, telegram: &Telegram) -> Option<usize> {
        match telegram.side {
            // Global_Control goes to everybody.
            Side::Master => match telegram.to? {
                EVERYBODY.. => Some(x(self.count() - 1)),
                station => self.lane(station),
            },
            // A lane of its own has everybody but the master under test.
            Side::Other(_) => Some(telegram.to.and_then(|to| self.lane(to)).unwrap_or(MASTER_X)),
            Side::Station(_) => telegram.is_whole.then_some(MASTER_X),
        }
    }
}

const fn x(lane: usize) -> usize {
    MASTER_X + LANE * lane
}

/// Cut between words; a word longer than a line stays whole.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < width => {
                line.push(' ');
                line.push_str(word);
            }
            Some(_) | None => lines.push(word.into()),
        }
    }
    lines
}
