//! Octets of a file or a stream, cut into telegrams and words, each explained.
//!
//! Not with a [`Framer`](crate::profibus::fdl::Framer): octets in a file have no time, broken telegrams are explained instead of
//! dropped, and words of a PPO may stand between telegrams.

use super::{Context, Explanation, Field, Kind, Mark, Sender, ppo};
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::profibus::fdl::foreign::Foreign;
use crate::profibus::fdl::telegram::{Decoded, Telegram, decode};

/// Cuts octets into telegrams and words and explains each. Every octet comes back in exactly one [`Explanation`], in
/// order. Keeps at most the octets of one call and one unfinished telegram.
///
/// Unlike a station on a bus, which drops what it does not understand, it explains what is broken and goes on with the
/// next telegram whose checksum is right.
///
/// ```
/// use profidrive::explain::{Context, Decoder, Taking};
///
/// let mut decoder = Decoder::new(Context::default(), Taking::Auto);
/// let mut lines = Vec::new();
/// // A telegram over two lines, a parameter channel alone.
/// decoder.line(&[0x10, 0x05, 0x02], &mut |_, said| lines.push(said.line()));
/// decoder.line(&[0x49, 0x50, 0x16], &mut |_, said| lines.push(said.line()));
/// decoder.line(&[0x13, 0xFA, 0, 0, 0, 0, 0, 0], &mut |_, said| lines.push(said.line()));
/// decoder.finish(&mut |_, said| lines.push(said.line()));
/// assert_eq!(lines, ["2 -> 5  FDL status request", "PKW job: read PNU 1018 Calibration value"]);
/// ```
#[derive(Clone, Debug)]
pub struct Decoder {
    context: Context,
    taking: Taking,
    /// The unfinished telegram, or octets that may be noise up to the next one.
    pending: Vec<u8>,
    /// How many octets were explained.
    explained: u64,
}

/// What octets are taken as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Taking {
    /// Telegrams; a line that is none, not even one with a wrong delimiter, and has 14, 8, 6 or 2 octets as PPO, PKW,
    /// PZD or one word.
    #[default]
    Auto,
    /// Telegrams only.
    Telegrams,
    /// Words only, each line a PPO, PKW, PZD or word, of the master or the drive, or of whom the words tell.
    Words(Option<Sender>),
}

impl Decoder {
    /// A decoder that has seen nothing yet.
    pub const fn new(context: Context, taking: Taking) -> Self {
        Self { context, taking, pending: Vec::new(), explained: 0 }
    }

    /// Takes the octets of one line. `sink` gets each explanation with the number of octets before it. Noise ends with
    /// its line, an unfinished telegram may go on in the next.
    pub fn line(&mut self, octets: &[u8], sink: &mut dyn FnMut(u64, Explanation)) {
        if octets.is_empty() {
            return;
        }
        match self.taking {
            Taking::Words(sender) => return self.words(octets, sender, sink),
            Taking::Auto
                if self.pending.is_empty()
                    && !is_telegrams(octets)
                    && !resembles_telegram(octets)
                    && !Foreign::is_all(octets) =>
            {
                if let Some(explanation) = self.context.bare(octets, None) {
                    return self.tell(explanation, sink);
                }
            }
            Taking::Auto | Taking::Telegrams => {}
        }
        // One telegram a line is more usual than a telegram over several: a line of its own is not a continuation.
        if !self.pending.is_empty() && is_whole_telegrams(octets) {
            let joined = [self.pending.as_slice(), octets].concat();
            if !is_telegrams(&joined) {
                self.flush(sink);
            }
        }
        self.pending.extend_from_slice(octets);
        self.cut(true, sink);
    }

    /// Takes octets of a stream without lines.
    pub fn octets(&mut self, octets: &[u8], sink: &mut dyn FnMut(u64, Explanation)) {
        self.pending.extend_from_slice(octets);
        self.cut(false, sink);
    }

    /// There is no more: what is unfinished is broken off.
    pub fn finish(&mut self, sink: &mut dyn FnMut(u64, Explanation)) {
        self.cut(true, sink);
        self.flush(sink);
    }

    fn words(&mut self, octets: &[u8], sender: Option<Sender>, sink: &mut dyn FnMut(u64, Explanation)) {
        let explanation = self.context.bare(octets, sender).unwrap_or_else(|| no_words(octets));
        self.tell(explanation, sink);
    }

    /// Explains everything whole at the front. At an `end` noise goes to the end.
    fn cut(&mut self, end: bool, sink: &mut dyn FnMut(u64, Explanation)) {
        let pending = core::mem::take(&mut self.pending);
        let mut rest = pending.as_slice();
        while !rest.is_empty() {
            let len = match decode(rest) {
                Decoded::Incomplete => break,
                Decoded::Telegram { len, .. } => len,
                Decoded::Invalid { skip, .. } => match noise(rest, skip, end) {
                    Some(len) => len,
                    None => break,
                },
            };
            let (octets, behind) = rest.split_at_checked(len).unwrap_or((rest, &[]));
            let explanation = self.context.telegram(octets);
            self.tell(explanation, sink);
            rest = behind;
        }
        self.pending = rest.into();
    }

    fn flush(&mut self, sink: &mut dyn FnMut(u64, Explanation)) {
        let pending = core::mem::take(&mut self.pending);
        if !pending.is_empty() {
            let explanation = self.context.telegram(&pending);
            self.tell(explanation, sink);
        }
    }

    fn tell(&mut self, explanation: Explanation, sink: &mut dyn FnMut(u64, Explanation)) {
        let at = self.explained;
        self.explained += u64::try_from(explanation.octets.len()).unwrap_or(0);
        sink(at, explanation);
    }
}

/// How many octets at the front are noise, of which `skip` certainly are: up to the next telegram, but not more than
/// the longest telegram has. `None` if more octets must come to tell.
fn noise(octets: &[u8], skip: usize, end: bool) -> Option<usize> {
    let most = octets.len().min(MAX_TELEGRAM_LEN);
    let next = (skip..most).find(|at| octets.get(*at..).is_some_and(|rest| telegram_begins(rest, end)));
    match next {
        Some(len) => Some(len),
        None if end || octets.len() > 2 * MAX_TELEGRAM_LEN => Some(most.max(skip)),
        None => None,
    }
}

/// Whether a telegram begins here that does not do so by chance: one with a checksum, or the head of one; tokens and
/// short acknowledges only in front of it or of the `end`.
fn telegram_begins(octets: &[u8], end: bool) -> bool {
    // Far enough for every chance to be gone.
    let mut rest = octets.get(..2 * MAX_TELEGRAM_LEN).unwrap_or(octets);
    while !rest.is_empty() {
        match decode(rest) {
            Decoded::Telegram { telegram: Telegram::Data(_), .. } => return true,
            Decoded::Telegram { telegram: Telegram::Token { .. } | Telegram::ShortAcknowledge, len } => {
                rest = rest.get(len..).unwrap_or_default();
            }
            Decoded::Incomplete => return matches!(rest, [0x68, le, ler, 0x68, ..] if le == ler),
            Decoded::Invalid { .. } => return false,
        }
    }
    end
}

/// Whether the octets are telegrams, the last of them perhaps unfinished.
fn is_telegrams(octets: &[u8]) -> bool {
    matches!(behind_telegrams(octets), Decoded::Incomplete)
}

/// Whether the octets are telegrams and nothing else.
fn is_whole_telegrams(octets: &[u8]) -> bool {
    let mut rest = octets;
    while let Decoded::Telegram { len, .. } = decode(rest) {
        rest = rest.get(len..).unwrap_or_default();
    }
    rest.is_empty()
}

/// What follows the whole telegrams at the front. Of no octets: incomplete.
fn behind_telegrams(octets: &[u8]) -> Decoded<'_> {
    let mut rest = octets;
    loop {
        match decode(rest) {
            Decoded::Telegram { len, .. } => rest = rest.get(len..).unwrap_or_default(),
            other @ (Decoded::Incomplete | Decoded::Invalid { .. }) => return other,
        }
    }
}

/// Whether octets that are no telegram were meant to be one: they begin and end like one, hold one, or are one but for a
/// delimiter.
fn resembles_telegram(octets: &[u8]) -> bool {
    let framed = match *octets {
        [SD1 | SD2 | SD3, .., ED] | [SD2, _, _, SD2, ..] => true,
        [..] => false,
    };
    let holds_one = |at: usize| {
        let decoded = decode(octets.get(at..).unwrap_or_default());
        matches!(decoded, Decoded::Telegram { telegram: Telegram::Data(_), .. })
    };
    framed || (1..octets.len().min(MAX_TELEGRAM_LEN)).any(holds_one) || has_one_wrong_delimiter(octets)
}

/// Whether the octets are one telegram with a right frame check sequence but for its end delimiter or for its start.
/// Words of these drives seldom look like that: a control word has no bit 12, which 10xx has, and four octets and their
/// sum before a 16 are a telegram unless the words make sense.
fn has_one_wrong_delimiter(octets: &[u8]) -> bool {
    let is_telegram = |at: usize, delimiter: u8| {
        let mut copy = Vec::from(octets);
        if let Some(octet) = copy.get_mut(at) {
            *octet = delimiter;
        }
        match decode(&copy) {
            // Zeros are a telegram of station 0 to itself.
            Decoded::Telegram { telegram: Telegram::Data(data), len } => {
                len == octets.len() && data.da != data.sa
            }
            Decoded::Telegram { telegram: Telegram::Token { .. } | Telegram::ShortAcknowledge, .. }
            | Decoded::Incomplete
            | Decoded::Invalid { .. } => false,
        }
    };
    match *octets {
        [SD1 | SD2 | SD3, .., _] if is_telegram(octets.len() - 1, ED) => true,
        // A length said twice and a delimiter within are no chance.
        [_, _, _, SD2, .., ED] if is_telegram(0, SD2) => true,
        [.., ED] => !ppo::makes_sense(octets) && (is_telegram(0, SD1) || is_telegram(0, SD3)),
        [..] => false,
    }
}

const SD1: u8 = 0x10;
const SD2: u8 = 0x68;
const SD3: u8 = 0xA2;
const ED: u8 = 0x16;

fn no_words(octets: &[u8]) -> Explanation {
    let reason = std::format!("{} octets are no PPO (14), PKW (8), PZD (6) or word (2)", octets.len());
    let field = Field::octets("octets", 0, octets, reason.clone()).marked(Mark::Invalid);
    let summary = std::format!("invalid at octet 0: {reason}");
    Explanation::of_nobody(Kind::Noise, summary, octets, Vec::from([field]))
}

#[cfg(test)]
mod tests {

    use proptest::prelude::*;

    use super::*;

    fn octets(hex: &str) -> Vec<u8> {
        hex.split(' ').map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect()
    }

    fn explained(lines: &[&str], taking: Taking) -> Vec<(u64, String)> {
        let mut decoder = Decoder::new(Context::default(), taking);
        let mut said = Vec::new();
        let mut sink = |at, explanation: Explanation| said.push((at, explanation.line()));
        for line in lines {
            decoder.line(&octets(line), &mut sink);
        }
        decoder.finish(&mut sink);
        said
    }

    #[test]
    fn a_frame_of_modbus_has_eight_octets_and_is_no_pkw() {
        let said = explained(&["01 03 00 00 00 0A C5 CD"], Taking::Auto);
        assert_eq!(said.len(), 1);
        assert!(said[0].1.contains("this is Modbus RTU, not PROFIBUS: station 1"), "{said:?}");
        assert!(explained(&["13 FA 00 00 00 00 00 00"], Taking::Auto)[0].1.starts_with("PKW job"));
    }

    #[test]
    fn telegrams_words_and_noise_are_told_apart() {
        let said = explained(
            &[
                "10 05 02 49 50 16 10 02 05 00 07 16",
                "13 FA 00 00 00 00 00 00",
                "00 0B",
                "68 05 05 68 85 82 6D 3C 3E EF 16 E5",
                "FF 00 10 05 02 49 50 16",
                "10 05 02 49 51 16",
                "FF FF FF",
            ],
            Taking::Auto,
        );
        let said: Vec<(u64, &str)> = said.iter().map(|(at, line)| (*at, line.as_str())).collect();
        assert_eq!(
            said,
            [
                (0, "2 -> 5  FDL status request"),
                (6, "5 -> 2  here, a slave"),
                (12, "PKW job: read PNU 1018 Calibration value"),
                (20, "STW 000B (ON, no OFF2, enable operation)"),
                (
                    22,
                    "2 -> 5  invalid at octet 9: frame check sequence is 0xEF, expected 0xEE; Slave_Diag request"
                ),
                (33, "short acknowledge: request received"),
                (34, "invalid at octet 0: octet 0xFF starts no telegram, expected 10, 68, A2, DC or E5"),
                (36, "2 -> 5  FDL status request"),
                (
                    42,
                    "2 -> 5  invalid at octet 4: frame check sequence is 0x51, expected 0x50; FDL status request"
                ),
                (48, "invalid at octet 0: octet 0xFF starts no telegram, expected 10, 68, A2, DC or E5"),
            ]
        );
    }

    #[test]
    fn a_telegram_may_go_on_in_the_next_line_and_one_that_does_not_is_broken_off() {
        let said = explained(
            &["68 05 05 68 85", "82 6D 3C 3E EE 16", "68 05 05 68 85", "10 05 02 49 50 16", "68 05"],
            Taking::Auto,
        );
        let lines: Vec<&str> = said.iter().map(|said| said.1.as_str()).collect();
        assert_eq!(
            lines,
            [
                "2 -> 5  Slave_Diag request",
                "invalid at octet 5: telegram broken off after 5 octets, 6 more are missing",
                "2 -> 5  FDL status request",
                "invalid at octet 2: telegram broken off after 2 octets, 9 more are missing",
            ]
        );
    }

    #[test]
    fn what_octets_are_taken_as_can_be_given() {
        let broken = "13 FA 00 00 00 00 00 00";
        assert!(explained(&[broken], Taking::Telegrams)[0].1.starts_with("invalid at octet 0"));
        assert!(explained(&["10 05 02 49 50 16"], Taking::Words(None))[0].1.starts_with("PZD: STW 1005"));
        let reply = explained(&["13 E8 00 00 00 00 00 00"], Taking::Words(Some(Sender::Slave)));
        assert_eq!(reply[0].1, "PKW reply: PNU 1000 Controller parameter P = 0");
        let said = explained(&["00 01 02"], Taking::Words(None));
        assert_eq!(said[0].1, "invalid at octet 0: 3 octets are no PPO (14), PKW (8), PZD (6) or word (2)");
    }

    #[test]
    fn a_telegram_with_one_wrong_delimiter_is_no_word() {
        for (damaged, reason) in [
            ("10 05 02 49 50 17", "2 -> 5  invalid at octet 5: end delimiter"),
            ("11 05 02 49 50 16", "invalid at octet 0: octet 0x11 starts no telegram"),
            ("00 05 02 49 50 16", "invalid at octet 0: octet 0x00 starts no telegram"),
            ("68 08 08 68 05 02 6D 13 FA 00 00 00 81 00", "2 -> 5  invalid at octet 13: end delimiter"),
            (
                "69 08 08 68 05 02 6D 13 FA 00 00 00 81 16",
                "invalid at octet 0: octet 0x69 starts no telegram",
            ),
            ("A2 05 02 6D 13 FA 00 00 00 00 00 00 81 15", "2 -> 5  invalid at octet 13: end delimiter"),
            (
                "A3 05 02 6D 13 FA 00 00 7C 00 00 00 FD 16",
                "invalid at octet 0: octet 0xA3 starts no telegram",
            ),
        ] {
            let said = explained(&[damaged], Taking::Auto);
            assert!(said[0].1.starts_with(reason), "{damaged}: {}", said[0].1);
            let words = explained(&[damaged], Taking::Words(None));
            assert!(!words[0].1.contains("invalid"), "{damaged}: {}", words[0].1);
        }
        // Words nevertheless: zeros, a wrong sum, and a setpoint that has the sum of the octets before it.
        for words in ["10 00 00 00 00 00", "10 05 02 49 51 17", "00 0B 00 00 0B 16", "0A 37 00 00 37 16"] {
            let said = explained(&[words], Taking::Auto);
            assert!(said[0].1.starts_with("PZD: "), "{words}: {}", said[0].1);
        }
    }

    #[test]
    fn a_stream_of_noise_keeps_no_more_than_two_telegrams() {
        let mut decoder = Decoder::new(Context::default(), Taking::Auto);
        let mut told = 0;
        for _ in 0..1000 {
            decoder.octets(&[0xFF; 100], &mut |_, said| told += said.octets.len());
            assert!(decoder.pending.len() <= 2 * MAX_TELEGRAM_LEN);
        }
        decoder.finish(&mut |_, said| told += said.octets.len());
        assert_eq!(told, 100_000);
    }

    fn any_stream() -> impl Strategy<Value = Vec<Vec<u8>>> {
        let piece = prop_oneof![
            proptest::collection::vec(any::<u8>(), 0..40),
            Just(octets("10 05 02 49 50 16")),
            Just(octets("68 05 05 68 85 82 6D 3C 3E EE 16")),
            Just(octets("E5")),
            Just(octets("DC 02 03")),
            Just(octets("68 11 11 68")),
        ];
        proptest::collection::vec(piece, 0..20)
    }

    proptest! {
        #[test]
        fn every_octet_comes_back_once_in_order(lines in any_stream(), by_line: bool) {
            let mut decoder = Decoder::new(Context::default(), Taking::Auto);
            let mut back: Vec<u8> = Vec::new();
            let mut sink = |at, said: Explanation| {
                assert_eq!(at, back.len() as u64);
                back.extend(said.octets);
            };
            for line in &lines {
                if by_line {
                    decoder.line(line, &mut sink);
                } else {
                    decoder.octets(line, &mut sink);
                }
            }
            decoder.finish(&mut sink);
            prop_assert_eq!(back, lines.concat());
        }

        #[test]
        fn a_stream_of_telegrams_is_cut_the_same_however_it_arrives(cuts in proptest::collection::vec(1usize..20, 0..30)) {
            let stream = octets("10 05 02 49 50 16 E5 DC 02 03 68 05 05 68 85 82 6D 3C 3E EE 16 10 02 05 00 07 16").repeat(3);
            let mut decoder = Decoder::new(Context::default(), Taking::Auto);
            let mut lines = Vec::new();
            let mut rest = stream.as_slice();
            for cut in cuts.into_iter().chain([usize::MAX]) {
                let (piece, behind) = rest.split_at(cut.min(rest.len()));
                decoder.octets(piece, &mut |_, said| lines.push(said.octets.len()));
                rest = behind;
            }
            prop_assert_eq!(lines, [6, 1, 3, 11, 6].repeat(3));
        }
    }
}
