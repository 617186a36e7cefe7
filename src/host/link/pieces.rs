//! Cuts the octets of one sender into telegrams, and the noise between them.
//!
//! For links that must not mix the octets of two senders, or that act on whole telegrams: noise is handed on as well,
//! which a [`Framer`](crate::profibus::fdl::Framer) drops. What is cut is what a
//! [`Framer`](crate::profibus::fdl::Framer) with [`Resync::SCAN`] finds in the same octets.

use core::time::Duration;

use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{FrameError, MAX_TELEGRAM_LEN, Resync};
use crate::time::Instant;

/// How long the rest of a telegram may take, as on every link whose timing is not true.
const PATIENCE: Duration = match Resync::SCAN {
    Resync::Scan(silence) => silence,
    Resync::Idle(_) => Duration::ZERO,
};

/// Some octets of one sender, in their order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Piece {
    /// One whole and correct telegram.
    Telegram(Vec<u8>),
    /// Octets that are no telegram, at least one, and why the first is the beginning of none.
    Noise(Vec<u8>, FrameError),
}

/// Octets of one sender that are not handed out yet.
#[derive(Clone, Debug, Default)]
pub(super) struct Pieces {
    held: Vec<u8>,
    last: Instant,
    /// No more will come.
    ended: bool,
}

impl Pieces {
    /// Takes octets that arrived at `now`.
    pub(super) fn push(&mut self, now: Instant, octets: &[u8]) {
        self.held.extend_from_slice(octets);
        self.last = now;
    }

    /// How many octets are held.
    pub(super) fn len(&self) -> usize {
        self.held.len()
    }

    /// The next piece, if its end is known. Octets that no more came to for 50 ms are given up as a telegram.
    pub(super) fn pop(&mut self, now: Instant) -> Option<Piece> {
        let overdue = self.ended || now.saturating_since(self.last) >= PATIENCE;
        let (mut noise, mut reason) = (0, None);
        while let Some(front) = self.held.get(noise..).filter(|front| !front.is_empty()) {
            let (skip, error) = match decode(front) {
                Decoded::Invalid { skip, error } => (skip, error),
                Decoded::Incomplete if overdue => (1, broken_off(front)),
                Decoded::Telegram { len, .. } if noise == 0 => {
                    return Some(Piece::Telegram(self.held.drain(..len).collect()));
                }
                Decoded::Incomplete | Decoded::Telegram { .. } => break,
            };
            noise += skip;
            reason.get_or_insert(error);
        }
        let noise = noise.min(self.held.len());
        reason.map(|reason| Piece::Noise(self.held.drain(..noise).collect(), reason))
    }

    /// When the last octets came.
    pub(super) const fn last(&self) -> Instant {
        self.last
    }

    /// Octets no more of which come: each time they are pushed, what is unfinished stays so.
    pub(super) fn ended() -> Self {
        Self { ended: true, ..Self::default() }
    }

    /// When an unfinished telegram is given up.
    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        (!self.held.is_empty()).then(|| self.last.saturating_add(PATIENCE))
    }

    /// The sender says no more: what is unfinished stays so.
    pub(super) fn end(&mut self) {
        self.ended = true;
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.held.clear();
    }
}

/// Why octets that only begin a telegram are none.
pub(super) fn broken_off(octets: &[u8]) -> FrameError {
    FrameError::BrokenOff { octets: u8::try_from(octets.len()).unwrap_or(u8::MAX) }
}

/// The longest front of `noise` with which a framer is done as soon as it has it. Behind the rest it would wait for
/// more, and take the telegram of another sender for it.
///
/// One pass: a flood of start delimiters costs no more than other noise.
pub(super) fn settled(noise: &[u8]) -> &[u8] {
    let (mut at, mut judged, mut done) = (0, 0, 0);
    while let Some(front) = noise.get(at..).filter(|front| !front.is_empty()) {
        let (step, needed) = match decode(front) {
            Decoded::Invalid { skip, .. } => (skip, octets_judged(front)),
            Decoded::Telegram { len, .. } => (len, len),
            Decoded::Incomplete => break,
        };
        judged = judged.max(at + needed);
        at += step;
        // An octet may have been refused only for the sake of one further behind.
        if judged <= at {
            done = at;
        }
    }
    noise.get(..done).unwrap_or(noise)
}

/// How many octets of `front` it takes to see that no telegram begins with them.
fn octets_judged(front: &[u8]) -> usize {
    let (mut too_few, mut enough) = (0, front.len().min(MAX_TELEGRAM_LEN));
    while enough - too_few > 1 {
        let middle = too_few.midpoint(enough);
        match front.get(..middle).map(decode) {
            Some(Decoded::Incomplete) | None => too_few = middle,
            Some(Decoded::Invalid { .. } | Decoded::Telegram { .. }) => enough = middle,
        }
    }
    enough
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ASK: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];

    fn octets(pieces: &[Piece]) -> Vec<u8> {
        let octets = pieces.iter().map(|piece| match piece {
            Piece::Telegram(octets) | Piece::Noise(octets, _) => &octets[..],
        });
        octets.collect::<Vec<_>>().concat()
    }

    fn all(pieces: &mut Pieces, now: Instant) -> Vec<Piece> {
        core::iter::from_fn(|| pieces.pop(now)).collect()
    }

    #[test]
    fn telegrams_and_noise_are_told_apart_wherever_they_are_cut() {
        let octets = [&[1][..], &ASK, &ASK, &[0xE5, 3]].concat();
        let ask = || Piece::Telegram(ASK.to_vec());
        let noise = |octet| Piece::Noise(vec![octet], FrameError::StartDelimiter { got: octet });
        let expected = [noise(1), ask(), ask(), Piece::Telegram(vec![0xE5]), noise(3)];
        for cut in 0..octets.len() {
            let mut pieces = Pieces::default();
            pieces.push(Instant::ZERO, &octets[..cut]);
            let mut found = all(&mut pieces, Instant::ZERO);
            pieces.push(Instant::ZERO, &octets[cut..]);
            found.extend(all(&mut pieces, Instant::ZERO));
            let telegrams = |pieces: &[Piece]| {
                pieces.iter().filter(|piece| matches!(piece, Piece::Telegram(_))).cloned().collect::<Vec<_>>()
            };
            assert_eq!(telegrams(&found), telegrams(&expected), "cut at {cut}");
            assert_eq!(super::tests::octets(&found), octets);
        }
    }

    #[test]
    fn half_a_telegram_is_given_up_after_50_ms_and_what_is_inside_is_found() {
        let mut pieces = Pieces::default();
        pieces.push(Instant::ZERO, &[0x68, 0x20, 0x20, 0x68]);
        pieces.push(Instant::from_millis(10), &ASK);
        assert_eq!(pieces.poll_timeout(), Some(Instant::from_millis(60)));
        assert_eq!(pieces.pop(Instant::from_millis(59)), None);
        let noise = Piece::Noise(vec![0x68, 0x20, 0x20, 0x68], FrameError::BrokenOff { octets: 10 });
        assert_eq!(all(&mut pieces, Instant::from_millis(60)), [noise, Piece::Telegram(ASK.to_vec())]);
        assert_eq!((pieces.len(), pieces.poll_timeout()), (0, None));
    }

    #[test]
    fn noise_is_settled_up_to_the_octet_that_could_begin_a_telegram() {
        assert_eq!(settled(&[1, 2, 3]), [1, 2, 3]);
        assert_eq!(settled(&[1, 0x68, 0x0B]), [1]);
        assert_eq!(settled(&[0xA2]), [0; 0]);
        // The first DC is no token because of the second; alone it could be one.
        assert_eq!(settled(&[0xDC, 0xDC]), [0; 0]);
        assert_eq!(settled(&[1, 0xDC, 0xDC, 2]), [1]);
    }

    /// It took a minute of a processor for each of these once: every shorter front was judged anew.
    #[test]
    fn a_flood_of_start_delimiters_is_judged_in_one_pass() {
        let flood = vec![0x10; 1 << 20];
        assert_eq!(settled(&flood), [0; 0]);
        assert_eq!(settled(&[&[1, 2][..], &flood].concat()), [1, 2]);
    }

    /// What `settled` means, said slowly: the longest front that leaves nothing unfinished.
    fn longest_front(noise: &[u8]) -> &[u8] {
        let leaves_nothing = |front: &&[u8]| {
            let mut framer = crate::profibus::fdl::Framer::new(Resync::SCAN);
            framer.handle_bytes(Instant::ZERO, front, |_, _| {});
            framer.poll_timeout().is_none()
        };
        let fronts = (0..=noise.len()).rev().map(|len| &noise[..len]);
        fronts.into_iter().find(leaves_nothing).unwrap_or_default()
    }

    fn octet_of_noise() -> impl Strategy<Value = u8> {
        prop_oneof![
            Just(0x10),
            Just(0x68),
            Just(0xA2),
            Just(0xDC),
            Just(0xE5),
            Just(4),
            Just(0x16),
            any::<u8>()
        ]
    }

    proptest! {
        #[test]
        fn the_longest_front_is_found(noise in prop::collection::vec(octet_of_noise(), 0..60)) {
            prop_assert_eq!(settled(&noise), longest_front(&noise));
        }

        /// No octet is lost or changed, and what no telegram can follow from leaves a framer empty.
        #[test]
        fn nothing_is_lost(chunks in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..40), 0..8)) {
            let mut pieces = Pieces::default();
            let mut found = Vec::new();
            for chunk in &chunks {
                pieces.push(Instant::ZERO, chunk);
                found.extend(all(&mut pieces, Instant::ZERO));
            }
            found.extend(all(&mut pieces, Instant::from_millis(50)));
            for piece in &found {
                if let Piece::Noise(noise, _) = piece {
                    let mut framer = crate::profibus::fdl::Framer::new(Resync::SCAN);
                    framer.handle_bytes(Instant::ZERO, settled(noise), |_, _| {});
                    prop_assert_eq!(framer.poll_timeout(), None);
                }
            }
            prop_assert_eq!(octets(&found), chunks.concat());
        }
    }
}
