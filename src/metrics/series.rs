//! The text of a metric: its labels and its values.

use core::fmt::{self, Display};

use prometheus_client::encoding::{EncodeLabelSet, LabelSetEncoder, MetricEncoder, NoLabelSet};
use prometheus_client::metrics::exemplar::Exemplar;

use crate::profibus::fdl::counters::Latency;

/// What one series is known by.
#[derive(Clone, Debug, Default)]
pub(super) struct Labels(Vec<(&'static str, String)>);

impl Labels {
    pub(super) fn of_line(number: usize) -> Self {
        Self::default().and("line", number)
    }

    /// With one more. `value` comes from this program, or from a file or the command line of its user.
    pub(super) fn and(mut self, label: &'static str, value: impl Display) -> Self {
        self.0.push((label, value.to_string()));
        self
    }

    /// With a name from a list of this crate, in the form of Prometheus: `FDL status` is `fdl_status`.
    pub(super) fn named(self, label: &'static str, name: &str) -> Self {
        self.and(label, name.to_lowercase().replace([' ', '-'], "_"))
    }
}

impl EncodeLabelSet for Labels {
    fn encode(&self, encoder: &mut LabelSetEncoder<'_>) -> fmt::Result {
        self.0.as_slice().encode(encoder)
    }
}

/// The series of one metric, in the order in which they are written.
pub(super) struct Series<'a>(pub(super) MetricEncoder<'a>);

/// A counter has no example.
const NONE: Option<&Exemplar<NoLabelSet, f64>> = None;

impl Series<'_> {
    pub(super) fn count(&mut self, labels: &Labels, value: u64) -> fmt::Result {
        self.0.encode_family(labels)?.encode_counter(&value, NONE)
    }

    pub(super) fn count_seconds(&mut self, labels: &Labels, seconds: f64) -> fmt::Result {
        self.0.encode_family(labels)?.encode_counter(&seconds, NONE)
    }

    /// One for each name.
    pub(super) fn counts(
        &mut self,
        labels: &Labels,
        label: &'static str,
        named: &[(&'static str, u64)],
    ) -> fmt::Result {
        named.iter().try_for_each(|(name, value)| self.count(&labels.clone().named(label, name), *value))
    }

    pub(super) fn gauge(&mut self, labels: &Labels, value: u64) -> fmt::Result {
        self.0.encode_family(labels)?.encode_gauge(&value)
    }

    pub(super) fn gauge_without_labels(&mut self, value: f64) -> fmt::Result {
        self.0.encode_gauge(&value)
    }

    /// One for each state there is: 1 for that which holds, 0 for the others.
    pub(super) fn states(&mut self, labels: &Labels, states: &[(&str, bool)]) -> fmt::Result {
        states
            .iter()
            .try_for_each(|(state, holds)| self.gauge(&labels.clone().named("state", state), (*holds).into()))
    }

    pub(super) fn info(&mut self, labels: &Labels) -> fmt::Result {
        self.0.encode_info(labels)
    }

    pub(super) fn histogram(&mut self, labels: &Labels, latency: &Latency) -> fmt::Result {
        let bound =
            |limit: Option<core::time::Duration>| limit.map_or(f64::INFINITY, |limit| limit.as_secs_f64());
        let buckets: Vec<_> = latency.buckets().map(|(limit, times)| (bound(limit), times)).collect();
        let count = buckets.iter().map(|(_, times)| times).sum();
        let sum = latency.sum().as_secs_f64();
        self.0.encode_family(labels)?.encode_histogram::<NoLabelSet>(sum, count, &buckets, None)
    }
}
