//! Samples of each drive, for curves.

use core::time::Duration;
use std::collections::{BTreeMap, VecDeque};

use serde::Serialize;
use utoipa::ToSchema;

use super::super::bus_access::BusAccess;
use super::super::state::{Motion, seconds};
use crate::devices::ag03::profibus::Device;
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// Between two samples.
pub(in crate::panel) const EVERY: Duration = Duration::from_millis(200);

/// How far back samples go.
const SPAN: Duration = Duration::from_secs(300);

/// Samples of a drive at most.
const MOST: usize = 1500;

/// What a drive was at a moment.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct Sample {
    /// Since the bus was started.
    pub(super) time_seconds: f64,
    pub(super) position_user_units: i32,
    /// `increments`, or `hundredth_millimetres` with a spindle pitch (PNU 1012).
    pub(super) user_unit: &'static str,
    /// The target of the job in progress or paused; `null`: there is none.
    pub(super) target_user_units: Option<i32>,
    pub(super) velocity_rpm: i32,
    /// The setpoint of velocity mode while it is released.
    pub(super) setpoint_rpm: Option<i32>,
    pub(super) current_milliamperes: i16,
}

/// One sample of every drive of a bus.
pub(in crate::panel) struct Sampled {
    at: Instant,
    drives: Vec<(Address, Sample)>,
}

/// The samples of the last minutes.
#[derive(Debug, Default)]
pub(in crate::panel) struct Samples(BTreeMap<u8, VecDeque<(Instant, Sample)>>);

impl Sampled {
    /// On the thread of the bus.
    pub(in crate::panel) fn of(bench: &BusAccess<'_>) -> Self {
        let sample = |address: Address| Some((address, Sample::of(bench.drive(address)?, bench.now)));
        Self { at: bench.now, drives: bench.bus.addresses().filter_map(sample).collect() }
    }
}

impl Sample {
    fn of(device: &Device, now: Instant) -> Self {
        Self {
            time_seconds: seconds(now),
            position_user_units: device.status().position,
            user_unit: Motion::unit_of(device),
            target_user_units: device.drive().target(),
            velocity_rpm: device.status().velocity,
            setpoint_rpm: Motion::released_rpm(device),
            current_milliamperes: device.drive().measured().current,
        }
    }

    fn is_as(&self, other: &Self) -> bool {
        Self { time_seconds: 0.0, ..self.clone() } == Self { time_seconds: 0.0, ..other.clone() }
    }
}

impl Samples {
    /// Of a drive at rest the first and the newest sample are kept. What is older than the span goes.
    pub(in crate::panel) fn keep(&mut self, Sampled { at, drives }: Sampled) {
        for (address, sample) in drives {
            let samples = self.0.entry(address.number()).or_default();
            let mut newest = samples.iter().rev();
            let at_rest = [newest.next(), newest.next()]
                .into_iter()
                .all(|before| before.is_some_and(|(_, before)| before.is_as(&sample)));
            if at_rest || samples.len() >= MOST {
                let _ = if at_rest { samples.pop_back() } else { samples.pop_front() };
            }
            samples.push_back((at, sample));
        }
        let is_old = |(then, _): &(Instant, Sample)| at.saturating_since(*then) > SPAN;
        self.0.retain(|_, samples| {
            // The last one before the span says what was at its beginning.
            while samples.get(1).is_some_and(is_old) {
                samples.pop_front();
            }
            !samples.iter().all(is_old)
        });
    }

    /// Of one drive, oldest first.
    pub(in crate::panel) fn of(&self, address: Address) -> impl Iterator<Item = &Sample> {
        self.0.get(&address.number()).into_iter().flatten().map(|(_, sample)| sample)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(at: u64, address: u8, position: i32) -> Sampled {
        let at = Instant::from_millis(at);
        let sample = Sample {
            time_seconds: seconds(at),
            position_user_units: position,
            user_unit: "increments",
            target_user_units: None,
            velocity_rpm: 0,
            setpoint_rpm: None,
            current_milliamperes: 0,
        };
        Sampled { at, drives: vec![(Address::station(address).unwrap(), sample)] }
    }

    fn kept(samples: &Samples, address: u8) -> Vec<(f64, i32)> {
        let of = samples.of(Address::station(address).unwrap());
        of.map(|sample| (sample.time_seconds, sample.position_user_units)).collect()
    }

    #[test]
    fn of_a_drive_at_rest_both_ends_are_kept() {
        let mut samples = Samples::default();
        for (at, position) in [(0, 7), (200, 7), (400, 7), (600, 7), (800, 8), (1000, 8)] {
            samples.keep(sampled(at, 5, position));
        }
        assert_eq!(kept(&samples, 5), [(0.0, 7), (0.6, 7), (0.8, 8), (1.0, 8)]);
    }

    #[test]
    fn what_is_older_than_five_minutes_goes_and_so_does_a_drive_that_went() {
        let mut samples = Samples::default();
        samples.keep(sampled(0, 6, 1));
        for step in 0..4000 {
            samples.keep(sampled(step * 200, 5, i32::try_from(step).unwrap()));
            assert!(kept(&samples, 5).len() <= MOST);
        }
        assert_eq!(kept(&samples, 5).first(), Some(&(500.0, 2500)));
        assert_eq!(kept(&samples, 5).last(), Some(&(799.8, 3999)));
        assert_eq!(kept(&samples, 6), []);
    }
}
