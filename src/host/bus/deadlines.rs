//! When each station of a bus wants to be called again.

use core::cell::Cell;

use crate::fdl::Address;
use crate::time::Instant;

/// The address of each station with the time it waits for. A table by address, looked through from end to end when the
/// first one has changed: quicker for the 127 there can be at most than to keep them in order, and never allocates.
pub(super) struct Deadlines {
    /// By address, in ns; [`NEVER`] for who waits for nothing.
    nanos: [u64; STATIONS],
    /// One behind the highest address that ever waited.
    end: usize,
    /// The first of them, if it is known.
    first: Cell<Option<First>>,
}

const STATIONS: usize = 127;
const NEVER: u64 = u64::MAX;

/// The earliest deadline and the lowest address that has it.
#[derive(Clone, Copy)]
struct First {
    nanos: u64,
    address: u8,
}

impl Deadlines {
    pub(super) const fn new() -> Self {
        Self { nanos: [NEVER; STATIONS], end: 0, first: Cell::new(None) }
    }

    /// The station at `address` waits for `deadline`, or for nothing.
    pub(super) fn set(&mut self, address: Address, deadline: Option<Instant>) {
        let nanos = deadline.map_or(NEVER, Instant::as_nanos);
        let address = address.number();
        let Some(place) = self.nanos.get_mut(usize::from(address)) else { return };
        if core::mem::replace(place, nanos) == nanos {
            return;
        }
        self.end = self.end.max(usize::from(address) + 1);
        let first = self.first.get();
        if first.is_some_and(|first| (nanos, address) < (first.nanos, first.address)) {
            self.first.set(Some(First { nanos, address }));
        } else if first.is_some_and(|first| first.address == address) {
            self.first.set(None);
        }
    }

    /// The earliest deadline.
    pub(super) fn first(&self) -> Option<(Instant, Address)> {
        let first = self.first.get().unwrap_or_else(|| {
            let first = self.search();
            self.first.set(Some(first));
            first
        });
        first.key()
    }

    /// The first one behind `last` by time and address.
    pub(super) fn behind(&self, (deadline, address): (Instant, Address)) -> Option<(Instant, Address)> {
        let last = (deadline.as_nanos(), address.number());
        let waiting = self.waiting().iter().copied().zip(0..).filter(|key| *key > last);
        waiting.min().and_then(|(nanos, address)| First { nanos, address }.key())
    }

    /// The first station from `from` on, by address, whose deadline is reached at `now`.
    pub(super) fn due_from(&self, from: u8, now: Instant) -> Option<Address> {
        let (from, now) = (usize::from(from), now.as_nanos());
        let places = self.waiting().get(from..)?;
        let at = from + places.iter().position(|nanos| *nanos <= now && *nanos != NEVER)?;
        u8::try_from(at).ok().map(Address::from_octet)
    }

    fn waiting(&self) -> &[u64] {
        self.nanos.get(..self.end).unwrap_or_default()
    }

    /// Two plain loops are quicker than one that remembers where it was.
    fn search(&self) -> First {
        let nanos = self.waiting().iter().fold(NEVER, |first, nanos| first.min(*nanos));
        let address = self.waiting().iter().position(|other| *other == nanos);
        First { nanos, address: address.and_then(|address| u8::try_from(address).ok()).unwrap_or_default() }
    }
}

impl First {
    fn key(self) -> Option<(Instant, Address)> {
        (self.nanos != NEVER).then(|| (Instant::from_nanos(self.nanos), Address::from_octet(self.address)))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn it_is_as_a_set_ordered_by_time_and_address(
            changes in proptest::collection::vec((0_u8..127, proptest::option::of(0_u64..20)), 0..200)
        ) {
            let (mut deadlines, mut set) = (Deadlines::new(), BTreeSet::new());
            for (number, deadline) in changes {
                let address = Address::from_octet(number);
                let deadline = deadline.map(Instant::from_millis);
                set.retain(|(_, other)| *other != address);
                set.extend(deadline.map(|deadline| (deadline, address)));
                deadlines.set(address, deadline);
                prop_assert_eq!(deadlines.first(), set.first().copied());
            }
            let (mut in_order, mut next) = (Vec::new(), deadlines.first());
            while let Some(key) = next {
                in_order.push(key);
                next = deadlines.behind(key);
            }
            prop_assert_eq!(in_order, set.iter().copied().collect::<Vec<_>>());
            let now = Instant::from_millis(10);
            let (mut due, mut from) = (BTreeSet::new(), 0);
            while let Some(address) = deadlines.due_from(from, now) {
                due.insert(address);
                from = address.number() + 1;
            }
            let expected: BTreeSet<_> = set.iter().filter(|(at, _)| *at <= now).map(|(_, who)| *who).collect();
            prop_assert_eq!(due, expected);
        }
    }
}
