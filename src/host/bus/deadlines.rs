//! When each station of a bus wants to be called again.

use crate::fdl::Address;
use crate::time::Instant;

/// The address of each station with the time it waits for, as a tree: of every two places the earlier time is in the place
/// above them. A change goes up seven places at most, and who is due is found on the way down. Never allocates.
///
/// ```text
///                 1                    the earliest of all
///         2               3
///     4       5       6       7        2n and 2n + 1 are below n
///    ..      ..      ..      ..
///   128 .. 254, 255                    the station at address 0 .. 126, and a place that stays empty
/// ```
pub(super) struct Deadlines {
    /// In ns; [`NEVER`] for who waits for nothing. Place 0 is not used.
    nanos: [u64; 2 * PLACES],
}

/// How many places are above that of a station.
const DEPTH: u32 = 7;
const PLACES: usize = 1 << DEPTH;
const NEVER: u64 = u64::MAX;

impl Deadlines {
    pub(super) const fn new() -> Self {
        Self { nanos: [NEVER; 2 * PLACES] }
    }

    /// The station at `address` waits for `deadline`, or for nothing.
    pub(super) fn set(&mut self, address: Address, deadline: Option<Instant>) {
        let mut place = PLACES | (usize::from(address.number()) % PLACES);
        let mut earliest = deadline.map_or(NEVER, Instant::as_nanos);
        for _ in 0..DEPTH {
            let Some(held) = self.nanos.get_mut(place) else { return };
            if *held == earliest {
                return;
            }
            *held = earliest;
            earliest = earliest.min(self.at(place ^ 1));
            place /= 2;
        }
        if let Some(first) = self.nanos.get_mut(place) {
            *first = earliest;
        }
    }

    /// The earliest deadline.
    #[inline]
    pub(super) fn first(&self) -> Option<Instant> {
        let first = self.at(1);
        (first != NEVER).then(|| Instant::from_nanos(first))
    }

    /// The stations whose deadline is reached at `now`.
    pub(super) fn due(&self, now: Instant) -> Due {
        // Who waits for nothing is not due at the end of time either.
        Due { now: now.as_nanos().min(NEVER - 1), place: 1 }
    }

    #[inline]
    fn at(&self, place: usize) -> u64 {
        self.nanos.get(place).copied().unwrap_or(NEVER)
    }
}

/// The stations whose deadline is reached, one after the other by address. While they are gone through, deadlines may
/// change.
pub(super) struct Due {
    now: u64,
    /// The place to look at next, with all below it; 0 behind the last.
    place: usize,
}

impl Due {
    #[inline]
    pub(super) fn next(&mut self, deadlines: &Deadlines) -> Option<Address> {
        // Nearly always one station is due, and then nobody.
        if deadlines.at(1) > self.now {
            return None;
        }
        while deadlines.at(self.place) > self.now {
            self.place = behind(self.place);
            if self.place == 0 {
                return None;
            }
        }
        while self.place < PLACES {
            self.place *= 2;
            self.place += usize::from(deadlines.at(self.place) > self.now);
        }
        let address = self.place % PLACES;
        self.place = behind(self.place);
        u8::try_from(address).ok().map(Address::from_octet)
    }
}

/// The place to the right of all that is below `place`; 0: there is none.
#[inline]
const fn behind(place: usize) -> usize {
    match place >> place.trailing_ones() {
        0 => 0,
        left => left + 1,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::vec::Vec;

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
