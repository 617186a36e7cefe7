//! One sending on the line.

use crate::map::Map;
use core::fmt;

use crate::explain::{Context, hex};
use crate::profibus::fdl::Address;
use crate::profibus::fdl::telegram;
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::time::Instant;

/// A telegram, or octets that are none, with its time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Moment {
    /// When its first octet began. On links without true timing: when its last octet was read.
    pub at: Instant,
    /// When its last octet ended.
    pub end: Instant,
    /// Who sent it.
    pub side: Side,
    /// Its octets.
    pub octets: Vec<u8>,
}

/// Who sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The master under test.
    Master,
    /// Another master, which the judge plays.
    Other(Address),
    /// A station, or who answers in its place; `None`: nobody was asked.
    Station(Option<Address>),
}

impl fmt::Display for Side {
    /// `M`, `M3` of another master, `S5`, or `S` of nobody known.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Master => f.pad("M"),
            Self::Other(address) => f.pad(&std::format!("M{address}")),
            Self::Station(Some(address)) => f.pad(&std::format!("S{address}")),
            Self::Station(None) => f.pad("S"),
        }
    }
}

impl Moment {
    /// A telegram that is known of at one time.
    pub(crate) fn new(at: Instant, side: Side, octets: &[u8]) -> Self {
        Self { at, end: at, side, octets: octets.to_vec() }
    }

    /// Its octets as text.
    pub(crate) fn hex(&self) -> String {
        hex(&self.octets)
    }
}

/// A telegram, or a frame of CAN, that shows a verdict.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Telegram {
    /// When its first octet began, as [`Moment::at`].
    pub at: Instant,
    /// Who sent it.
    pub side: Side,
    /// The address that it has of its sender; `None`: it has none.
    pub from: Option<u8>,
    /// The address of the one that it is for.
    pub to: Option<u8>,
    /// Its octets as text.
    pub hex: String,
    /// What it means. Octets that are no telegram have no meaning for anybody.
    pub explained: String,
    /// Whether it is whole and right.
    pub is_whole: bool,
}

/// Sendings with their meaning, beside the ident numbers of the stations. A stream explains itself: the reply by its request.
pub(super) fn explained(moments: impl IntoIterator<Item = Moment>, idents: &Map<u8, u16>) -> Vec<Telegram> {
    let mut context = Context::default();
    for (station, ident) in idents {
        context.know_ident(Address::from_octet(*station), *ident);
    }
    let explain = |moment: Moment| {
        let explained = context.telegram(&moment.octets).line();
        let decoded = decode(&moment.octets);
        let (from, to) = named(&decoded);
        let is_whole = matches!(decoded, Decoded::Telegram { .. });
        Telegram { at: moment.at, side: moment.side, from, to, hex: moment.hex(), explained, is_whole }
    };
    moments.into_iter().map(explain).collect()
}

/// Who sends a telegram and whom it is for.
const fn named(decoded: &Decoded<'_>) -> (Option<u8>, Option<u8>) {
    match decoded {
        Decoded::Telegram { telegram: telegram::Telegram::Data(data), .. } => {
            (Some(data.sa.number()), Some(data.da.number()))
        }
        Decoded::Telegram { telegram: telegram::Telegram::Token { da, sa }, .. } => {
            (Some(sa.number()), Some(da.number()))
        }
        Decoded::Telegram { telegram: telegram::Telegram::ShortAcknowledge, .. }
        | Decoded::Incomplete
        | Decoded::Invalid { .. } => (None, None),
    }
}

/// The telegrams in one sending of a station: a reply sent twice is two, noise in front of a reply is apart.
pub(super) fn split(octets: &[u8]) -> Vec<&[u8]> {
    let whole =
        |octets: &[u8]| matches!(decode(octets), Decoded::Telegram { len, .. } if len == octets.len());
    let mut parts = Vec::new();
    let mut rest = octets;
    while let Decoded::Telegram { len, .. } = decode(rest)
        && let Some((telegram, behind)) = rest.split_at_checked(len)
    {
        parts.push(telegram);
        rest = behind;
    }
    // Two octets or more: what looks like SC at the end of something broken is none.
    let begin = (1..rest.len().saturating_sub(1)).find(|at| rest.get(*at..).is_some_and(whole));
    match begin.and_then(|at| rest.split_at_checked(at)) {
        Some((noise, telegram)) => parts.extend([noise, telegram]),
        None if rest.is_empty() => {}
        None => parts.push(rest),
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPLY: [u8; 6] = [0x10, 0x02, 0x05, 0x00, 0x07, 0x16];

    #[test]
    fn a_sending_is_cut_where_telegrams_meet() {
        let twice = [REPLY, REPLY].concat();
        assert_eq!(split(&twice), [&REPLY[..], &REPLY[..]]);
        let noisy = [&[0x33, 0xE5, 0x44][..], &REPLY[..]].concat();
        assert_eq!(split(&noisy), [&noisy[..3], &REPLY[..]]);
        let broken = [0x10, 0x02, 0x05, 0x00, 0x08, 0xE5];
        assert_eq!(split(&broken), [&broken[..]]);
        assert!(split(&[]).is_empty());
    }
}
