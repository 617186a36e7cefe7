//! Octets of one telegram that outlive it.

use super::set_prm::MAX_LEN;

/// Up to 244 octets.
#[derive(Clone, Debug)]
pub(super) struct Buffer {
    octets: [u8; MAX_LEN],
    len: usize,
}

impl Buffer {
    pub(super) const EMPTY: Self = Self { octets: [0; MAX_LEN], len: 0 };

    pub(super) fn octets(&self) -> &[u8] {
        self.octets.get(..self.len).unwrap_or_default()
    }

    /// Keeps the octets of `parts`, one behind the other; what is too much is dropped.
    pub(super) fn keep(&mut self, parts: [&[u8]; 2]) {
        self.len = 0;
        for (place, octet) in self.octets.iter_mut().zip(parts.into_iter().flatten()) {
            *place = *octet;
            self.len += 1;
        }
    }
}
