//! When each station of a bus wants to be called again.

use core::cell::Cell;

use crate::profibus::fdl::Address;
use crate::time::Instant;

/// The address of each station with the time it waits for. A table by address, and of each [`BLOCK`] addresses and of all
/// the earliest time: quicker for the 127 there can be at most than to keep them in order, and never allocates.
pub(super) struct Deadlines {
    /// By address, in ns; [`NEVER`] for who waits for nothing.
    nanos: [[u64; BLOCK]; BLOCKS],
    /// The earliest of each block, or [`UNKNOWN`]: many change before the first one is asked for.
    earliest: [Cell<u64>; BLOCKS],
    /// The earliest of all, or [`UNKNOWN`].
    first: Cell<u64>,
    /// How many blocks have ever been used.
    used: usize,
}

const BLOCK: usize = 16;
/// 127 addresses, and a place that stays empty.
const BLOCKS: usize = 8;
const NEVER: u64 = u64::MAX;
/// No later than any time there is.
const UNKNOWN: u64 = 0;

impl Deadlines {
    pub(super) const fn new() -> Self {
        Self {
            nanos: [[NEVER; BLOCK]; BLOCKS],
            earliest: [const { Cell::new(NEVER) }; BLOCKS],
            first: Cell::new(NEVER),
            used: 0,
        }
    }

    /// The station at `address` waits for `deadline`, or for nothing.
    pub(super) fn set(&mut self, address: Address, deadline: Option<Instant>) {
        let at = usize::from(address.number());
        let (block, earliest) = (self.nanos.get_mut(at / BLOCK), self.earliest.get_mut(at / BLOCK));
        let (Some(block), Some(earliest)) = (block, earliest) else { return };
        let Some(place) = block.get_mut(at % BLOCK) else { return };
        let nanos = deadline.map_or(NEVER, Instant::as_nanos);
        let before = core::mem::replace(place, nanos);
        if nanos == before {
            return;
        }
        self.used = self.used.max(at / BLOCK + 1);
        follow(earliest.get_mut(), before, nanos);
        follow(self.first.get_mut(), before, nanos);
    }

    /// The earliest deadline.
    #[inline]
    pub(super) fn first(&self) -> Option<Instant> {
        let first = match self.first.get() {
            UNKNOWN => self.find_first(),
            known => known,
        };
        (first != NEVER).then(|| Instant::from_nanos(first))
    }

    fn find_first(&self) -> u64 {
        let mut first = NEVER;
        for (earliest, block) in self.earliest.iter().zip(&self.nanos).take(self.used) {
            if earliest.get() == UNKNOWN {
                earliest.set(block.iter().fold(NEVER, |first, nanos| first.min(*nanos)));
            }
            first = first.min(earliest.get());
        }
        self.first.set(first);
        first
    }

    /// The stations whose deadline is reached at `now`.
    pub(super) fn due(&self, now: Instant) -> Due {
        // Who waits for nothing is not due at the end of time either.
        Due { now: now.as_nanos().min(NEVER - 1), block: 0, left: 0 }
    }
}

/// The stations whose deadline is reached, one after the other by address. While they are gone through, deadlines may
/// change: each [`BLOCK`] addresses are looked at once, when the first of them has its turn.
pub(super) struct Due {
    now: u64,
    /// The block to look at next.
    block: usize,
    /// Those of the block before that still have their turn, a bit for each.
    left: u16,
}

impl Due {
    #[inline]
    pub(super) fn next(&mut self, deadlines: &Deadlines) -> Option<Address> {
        while self.left == 0 {
            let earliest = deadlines.earliest.get(..deadlines.used)?.get(self.block)?;
            if earliest.get() <= self.now {
                let nanos = deadlines.nanos.get(self.block)?;
                let due = nanos.iter().rev().map(|nanos| u16::from(*nanos <= self.now));
                self.left = due.fold(0, |left, due| left << 1 | due);
            }
            self.block += 1;
        }
        let place = self.left.trailing_zeros();
        self.left &= self.left - 1;
        let address = (self.block - 1) * BLOCK + usize::try_from(place).ok()?;
        u8::try_from(address).ok().map(Address::from_octet)
    }
}

/// Keeps the earliest of many deadlines while one of them goes from `before` to `nanos`.
#[inline]
const fn follow(earliest: &mut u64, before: u64, nanos: u64) {
    if nanos <= *earliest {
        *earliest = nanos;
    } else if before == *earliest {
        *earliest = UNKNOWN;
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn it_is_as_a_map_that_is_looked_through(
            changes in proptest::collection::vec((0_u8..127, proptest::option::of(0_u64..20)), 0..200)
        ) {
            let (mut deadlines, mut map) = (Deadlines::new(), BTreeMap::new());
            for (number, deadline) in changes {
                let deadline = deadline.map(Instant::from_millis);
                map.insert(number, deadline);
                deadlines.set(Address::from_octet(number), deadline);
                prop_assert_eq!(deadlines.first(), map.values().flatten().min().copied());
            }
            let now = Instant::from_millis(10);
            let mut turns = deadlines.due(now);
            let due: Vec<_> = core::iter::from_fn(|| turns.next(&deadlines)).map(Address::number).collect();
            let reached = map.iter().filter(|(_, deadline)| deadline.is_some_and(|deadline| deadline <= now));
            prop_assert_eq!(due, reached.map(|(number, _)| *number).collect::<Vec<_>>());
        }
    }
}
