//! The octets of one sender, cut into telegrams and what is none.
//!
//! For links that must not mix the octets of two senders, or that act on whole telegrams. What is cut is what a
//! [`Framer`](crate::fdl::Framer) with [`Resync::SCAN`] finds in the same octets.

use core::time::Duration;
use std::vec::Vec;

use crate::fdl::Resync;
use crate::fdl::telegram::{Decoded, decode};
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
    /// Octets that are no telegram, at least one.
    Noise(Vec<u8>),
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
        let mut noise = 0;
        while let Some(front) = self.held.get(noise..).filter(|front| !front.is_empty()) {
            match decode(front) {
                Decoded::Invalid { skip, .. } => noise += skip,
                Decoded::Incomplete if overdue => noise += 1,
                Decoded::Telegram { len, .. } if noise == 0 => {
                    return Some(Piece::Telegram(self.held.drain(..len).collect()));
                }
                Decoded::Incomplete | Decoded::Telegram { .. } => break,
            }
        }
        let noise = noise.min(self.held.len());
        (noise > 0).then(|| Piece::Noise(self.held.drain(..noise).collect()))
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

/// The longest front of `noise` with which a framer is done as soon as it has it. Behind the rest it would wait for
/// more, and take the telegram of another sender for it.
pub(super) fn settled(noise: &[u8]) -> &[u8] {
    let mut front = noise;
    loop {
        // An octet may be refused only for the sake of the one behind it: a shorter front is judged anew.
        let cut = front.get(..cut_len(front)).unwrap_or_default();
        if cut.len() == front.len() {
            return front;
        }
        front = cut;
    }
}

/// How many octets come before the first place where a telegram could begin that is not whole.
fn cut_len(octets: &[u8]) -> usize {
    let mut cut = 0;
    while let Some(front) = octets.get(cut..).filter(|front| !front.is_empty()) {
        match decode(front) {
            Decoded::Invalid { skip, .. } => cut += skip,
            Decoded::Telegram { len, .. } => cut += len,
            Decoded::Incomplete => break,
        }
    }
    cut
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ASK: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];

    fn octets(pieces: &[Piece]) -> Vec<u8> {
        let octets = pieces.iter().map(|piece| match piece {
            Piece::Telegram(octets) | Piece::Noise(octets) => &octets[..],
        });
        octets.collect::<Vec<_>>().concat()
    }

    fn all(pieces: &mut Pieces, now: Instant) -> Vec<Piece> {
        core::iter::from_fn(|| pieces.pop(now)).collect()
    }

    #[test]
    fn telegrams_and_noise_are_told_apart_wherever_they_are_cut() {
        let octets = [&[1, 2][..], &ASK, &ASK, &[0xE5, 3]].concat();
        let ask = || Piece::Telegram(ASK.to_vec());
        let expected =
            [Piece::Noise(vec![1, 2]), ask(), ask(), Piece::Telegram(vec![0xE5]), Piece::Noise(vec![3])];
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
        let noise = Piece::Noise(vec![0x68, 0x20, 0x20, 0x68]);
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

    proptest! {
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
                if let Piece::Noise(noise) = piece {
                    let mut framer = crate::fdl::Framer::new(Resync::SCAN);
                    framer.receive(Instant::ZERO, settled(noise), |_, _| {});
                    prop_assert_eq!(framer.poll_timeout(), None);
                }
            }
            prop_assert_eq!(octets(&found), chunks.concat());
        }
    }
}
