//! The values of each station that are worth a curve, as they were.

use crate::map::Map;
use core::time::Duration;
use std::collections::VecDeque;

use super::super::line::OnLine;
use crate::face::Description;
use crate::face::description::Curve;
use crate::time::Instant;

/// Between two samples.
pub(in crate::panel) const EVERY: Duration = Duration::from_millis(200);

/// How far back samples go.
const SPAN: Duration = Duration::from_secs(300);

/// Samples of a station at most.
const MOST: usize = 1500;

/// What a value is called, and how many digits behind the point mean something.
pub(in crate::panel) type Column = (&'static str, Option<u8>);

/// What the values were at a moment, in the order of their columns; NaN: there was none.
type Row = Box<[f64]>;

/// One sample of every station of a line.
pub(in crate::panel) struct Sampled {
    at: Instant,
    stations: Vec<(u8, Vec<Column>, Row)>,
}

/// The samples of the last minutes.
#[derive(Debug, Default)]
pub(in crate::panel) struct Samples(Map<u8, Curves>);

/// The samples of a station.
#[derive(Clone, Debug, Default)]
pub(in crate::panel) struct Curves {
    pub(in crate::panel) columns: Vec<Column>,
    pub(in crate::panel) rows: VecDeque<(Instant, Row)>,
}

/// The columns and values of a station now.
pub(in crate::panel) fn of_station(station: &dyn Description) -> (Vec<Column>, Row) {
    let (mut columns, mut row) = (Vec::new(), Vec::new());
    station.each_value(&mut |value| {
        if value.curve != Curve::None {
            columns.push((value.key, value.digits));
            row.push(value.amount.number().unwrap_or(f64::NAN));
        }
    });
    (columns, row.into())
}

impl Sampled {
    /// On the thread of the line.
    pub(in crate::panel) fn of(lent: &dyn OnLine) -> Self {
        let sample = |address: u8| {
            let (columns, row) = of_station(lent.described(address)?);
            (!columns.is_empty()).then_some((address, columns, row))
        };
        Self { at: lent.now(), stations: lent.addresses().into_iter().filter_map(sample).collect() }
    }
}

fn is_as(row: &Row, other: &Row) -> bool {
    row.iter().map(|value| value.to_bits()).eq(other.iter().map(|value| value.to_bits()))
}

impl Curves {
    fn keep(&mut self, at: Instant, columns: Vec<Column>, row: Row) {
        if self.columns != columns {
            // Another device, or another unit.
            *self = Self { columns, rows: VecDeque::new() };
        }
        let mut newest = self.rows.iter().rev();
        let at_rest = [newest.next(), newest.next()]
            .into_iter()
            .all(|before| before.is_some_and(|(_, before)| is_as(before, &row)));
        if at_rest || self.rows.len() >= MOST {
            let _ = if at_rest { self.rows.pop_back() } else { self.rows.pop_front() };
        }
        self.rows.push_back((at, row));
    }
}

impl Samples {
    /// Of a station at rest the first and the newest sample are kept. What is older than the span goes.
    pub(in crate::panel) fn keep(&mut self, Sampled { at, stations }: Sampled) {
        for (address, columns, row) in stations {
            let curves = self.0.or_default(address);
            // Of two with one number the first counts.
            if curves.rows.back().is_none_or(|(then, _)| *then != at) {
                curves.keep(at, columns, row);
            }
        }
        let is_old = |(then, _): &(Instant, Row)| at.saturating_since(*then) > SPAN;
        self.0.retain(|_, curves| {
            // The last one before the span says what was at its beginning.
            while curves.rows.get(1).is_some_and(is_old) {
                curves.rows.pop_front();
            }
            !curves.rows.iter().all(is_old)
        });
    }

    /// Of one station, oldest first.
    pub(in crate::panel) fn of(&self, address: u8) -> Curves {
        self.0.get(&address).cloned().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(at: u64, address: u8, position: u32) -> Sampled {
        let row: Row = Box::new([position.into(), f64::NAN]);
        let columns = vec![("position", None), ("target", None)];
        Sampled { at: Instant::from_millis(at), stations: vec![(address, columns, row)] }
    }

    fn kept(samples: &Samples, address: u8) -> Vec<(u64, f64)> {
        let rows = samples.of(address).rows.into_iter();
        rows.map(|(at, row)| (at.as_nanos() / 1_000_000, row[0])).collect()
    }

    #[test]
    fn of_a_drive_at_rest_both_ends_are_kept() {
        let mut samples = Samples::default();
        for (at, position) in [(0, 7), (200, 7), (400, 7), (600, 7), (800, 8), (1000, 8)] {
            samples.keep(sampled(at, 5, position));
        }
        assert_eq!(kept(&samples, 5), [(0, 7.0), (600, 7.0), (800, 8.0), (1000, 8.0)]);
    }

    #[test]
    fn what_is_older_than_five_minutes_goes_and_so_does_a_drive_that_went() {
        let mut samples = Samples::default();
        samples.keep(sampled(0, 6, 1));
        for step in 0..4000 {
            samples.keep(sampled(step * 200, 5, u32::try_from(step).unwrap()));
            assert!(kept(&samples, 5).len() <= MOST);
        }
        assert_eq!(kept(&samples, 5).first(), Some(&(500_000, 2500.0)));
        assert_eq!(kept(&samples, 5).last(), Some(&(799_800, 3999.0)));
        assert_eq!(kept(&samples, 6), []);
    }
}
