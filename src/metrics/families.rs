//! Every metric, once: its name, type, labels and meaning, and where its numbers come from.

use core::fmt;

use prometheus_client::collector::Collector;
use prometheus_client::encoding::{DescriptorEncoder, text};
use prometheus_client::metrics::MetricType;
use prometheus_client::registry::{Registry, Unit};

use super::line::{Counters, Member, Of};
use super::scrape::{Found, Scrape};
use super::series::{Labels, Series};
use crate::can_bus::can::ErrorState;
use crate::can_bus::canopen::NmtState;
use crate::face::DriveState;
use crate::face::ErrorKind;
use crate::host::can::{self, NodeCounters};
use crate::profibus::dp;
use crate::profibus::fdl::{LineCounters, StationCounters};

/// A metric family.
pub(super) struct Family {
    /// Without its unit, and without what its type appends.
    pub(super) name: &'static str,
    pub(super) kind: MetricType,
    /// Its unit is the second; else it has none.
    pub(super) in_seconds: bool,
    /// What it means.
    pub(super) help: &'static str,
    source: Source,
}

type Tell<T> = fn(&mut Series<'_>, &Labels, &T) -> fmt::Result;

/// Whose numbers a family has, and which.
enum Source {
    /// Of the process.
    Process(fn(&mut Series<'_>, &Scrape) -> fmt::Result),
    /// Of every line.
    Lines(Tell<Found>),
    /// Of the lines of PROFIBUS.
    Profibus(Tell<LineCounters>),
    /// Of the buses of CAN.
    Can(Tell<can::bus::Counters>),
    /// Of stations and nodes.
    Members(Tell<Member>),
    Stations(Tell<StationCounters>),
    Nodes(Tell<NodeCounters>),
}

impl Source {
    fn tell(&self, scrape: &Scrape, series: &mut Series<'_>) -> fmt::Result {
        match self {
            Self::Process(tell) => tell(series, scrape),
            Self::Lines(_) | Self::Profibus(_) | Self::Can(_) => {
                let mut lines = scrape.lines.iter();
                lines.try_for_each(|found| self.tell_line(&Labels::of_line(found.number), found, series))
            }
            Self::Members(_) | Self::Stations(_) | Self::Nodes(_) => {
                let mut members = scrape.members();
                members.try_for_each(|(labels, member)| self.tell_member(&labels, member, series))
            }
        }
    }

    fn tell_line(&self, labels: &Labels, found: &Found, series: &mut Series<'_>) -> fmt::Result {
        match (self, &found.line.counters) {
            (Self::Lines(tell), _) => tell(series, labels, found),
            (Self::Profibus(tell), Counters::Profibus(counters)) => tell(series, labels, counters),
            (Self::Can(tell), Counters::Can(counters)) => tell(series, labels, counters),
            (_, Counters::Profibus(_) | Counters::Can(_)) => Ok(()),
        }
    }

    fn tell_member(&self, labels: &Labels, member: &Member, series: &mut Series<'_>) -> fmt::Result {
        match (self, &member.of) {
            (Self::Members(tell), _) => tell(series, labels, member),
            (Self::Stations(tell), Of::Profibus { counters, .. }) => tell(series, labels, counters),
            (Self::Nodes(tell), Of::Can { counters, .. }) => tell(series, labels, counters),
            (_, Of::Profibus { .. } | Of::Can { .. }) => Ok(()),
        }
    }
}

impl Family {
    const fn of(kind: MetricType, name: &'static str, help: &'static str, source: Source) -> Self {
        Self { name, kind, in_seconds: false, help, source }
    }

    const fn info(name: &'static str, help: &'static str, source: Source) -> Self {
        Self::of(MetricType::Info, name, help, source)
    }

    const fn gauge(name: &'static str, help: &'static str, source: Source) -> Self {
        Self::of(MetricType::Gauge, name, help, source)
    }

    const fn counter(name: &'static str, help: &'static str, source: Source) -> Self {
        Self::of(MetricType::Counter, name, help, source)
    }

    const fn in_seconds(self) -> Self {
        Self { in_seconds: true, ..self }
    }
}

/// All of them, in the order in which they are written.
pub(super) const FAMILIES: &[Family] = &[
    Family::info(
        "profidrive_build",
        "The version of profidrive.",
        Source::Process(|series, _| {
            series.info(&Labels::default().and("version", env!("CARGO_PKG_VERSION")))
        }),
    ),
    Family::gauge(
        "process_start_time",
        "When the metrics began, in seconds since 1970-01-01 UTC.",
        Source::Process(|series, scrape| series.gauge_without_labels(scrape.started)),
    )
    .in_seconds(),
    Family::info(
        "profidrive_line",
        "A line: its bus, and the link that a master opens.",
        Source::Lines(|series, labels, found| {
            let bus = match found.line.counters {
                Counters::Profibus(_) => "profibus",
                Counters::Can(_) => "can",
            };
            series.info(&labels.clone().and("bus", bus).and("link", &found.link))
        }),
    ),
    Family::gauge(
        "profidrive_line_rate_bits_per_second",
        "The rate of the line, or the one listened at while it is searched for.",
        Source::Lines(|series, labels, found| series.gauge(labels, found.line.rate.into())),
    ),
    Family::counter(
        "profidrive_telegrams_heard",
        "Telegrams without an error on a line of PROFIBUS, whoever they were for.",
        Source::Profibus(|series, labels, line| series.counts(labels, "kind", &line.heard.kinds())),
    ),
    Family::counter(
        "profidrive_telegrams_sent",
        "Telegrams that the stations of a line of PROFIBUS sent, those that are gone included.",
        Source::Profibus(|series, labels, line| series.count(labels, line.sent)),
    ),
    Family::counter(
        "profidrive_line_errors",
        "On PROFIBUS damaged telegrams and rows of noise, by what was wrong first; on CAN error frames.",
        Source::Lines(|series, labels, found| match &found.line.counters {
            Counters::Profibus(line) => series.counts(labels, "kind", &line.rejected.reasons()),
            Counters::Can(bus) => series.counts(labels, "kind", &[("error frame", bus.errors)]),
        }),
    ),
    Family::counter(
        "profidrive_resyncs",
        "How often the next telegram had to be searched for on a line of PROFIBUS.",
        Source::Profibus(|series, labels, line| series.count(labels, line.resyncs)),
    ),
    Family::of(
        MetricType::Histogram,
        "profidrive_reply_time",
        "From the last octet of a request, as it was heard, to the start of its reply, for replies \
         sent on PROFIBUS.",
        Source::Profibus(|series, labels, line| series.histogram(labels, &line.latency)),
    )
    .in_seconds(),
    Family::counter(
        "profidrive_can_frames",
        "Frames that ended without error on a bus of CAN.",
        Source::Can(|series, labels, bus| {
            let data = bus.frames.saturating_sub(bus.remote);
            series.counts(labels, "kind", &[("data", data), ("remote", bus.remote)])
        }),
    ),
    Family::counter(
        "profidrive_can_busy",
        "How long bits were on the wire of a bus of CAN; its rate is the load, 0 to 1.",
        Source::Can(|series, labels, bus| series.count_seconds(labels, bus.busy.as_secs_f64())),
    )
    .in_seconds(),
    Family::info(
        "profidrive_station",
        "A station or node that is connected: what it is, and its model.",
        Source::Members(|series, labels, member| {
            series.info(&labels.clone().and("kind", member.kind).and("model", &member.model))
        }),
    ),
    Family::gauge(
        "profidrive_station_active",
        "1: the station takes part. 0: it listens whether somebody else has its address, or somebody has.",
        Source::Members(|series, labels, member| match member.of {
            Of::Profibus { active, .. } => series.gauge(labels, active.into()),
            Of::Can { .. } => Ok(()),
        }),
    ),
    Family::gauge(
        "profidrive_slave_state",
        "The state of the DP slave: 1 for the one that holds, 0 for the others.",
        Source::Members(|series, labels, member| match member.of {
            Of::Profibus { slave: Some(slave), .. } => {
                let is = |state, name| (name, slave == state);
                series.states(
                    labels,
                    &[
                        is(dp::State::WaitPrm, "wait_prm"),
                        is(dp::State::WaitCfg, "wait_cfg"),
                        is(dp::State::DataExch, "data_exch"),
                    ],
                )
            }
            Of::Profibus { slave: None, .. } | Of::Can { .. } => Ok(()),
        }),
    ),
    Family::gauge(
        "profidrive_drive_state",
        "The state of the drive in the words that all devices share: 1 for the one that holds, 0 for \
         the others.",
        Source::Members(|series, labels, member| {
            let Some(drive) = member.drive else { return Ok(()) };
            let mut states = DriveState::ALL.iter().map(|state| (state.name(), drive == *state));
            states.try_for_each(|state| series.states(labels, &[state]))
        }),
    ),
    Family::counter(
        "profidrive_requests",
        "Telegrams to the station; broadcasts are not among them.",
        Source::Stations(|series, labels, station| {
            // Nobody sends the other kinds to a slave.
            let kinds = station.requests.kinds();
            let requests = kinds.get(..REQUESTS).unwrap_or_default();
            series.counts(labels, "kind", requests)
        }),
    ),
    Family::counter(
        "profidrive_retries",
        "Requests that repeat the one before them.",
        Source::Stations(|series, labels, station| series.count(labels, station.retries)),
    ),
    Family::counter(
        "profidrive_replies",
        "Replies that the station has sent.",
        Source::Stations(|series, labels, station| series.count(labels, station.replies)),
    ),
    Family::counter(
        "profidrive_station_reply_time",
        "The reply times of the station, all together; divided by its replies the mean.",
        Source::Stations(|series, labels, station| {
            series.count_seconds(labels, station.latency.sum().as_secs_f64())
        }),
    )
    .in_seconds(),
    Family::counter(
        "profidrive_watchdog_expiries",
        "How often the watchdog of the slave expired; of a node life guarding, or the heartbeat it \
         supervises.",
        Source::Members(|series, labels, member| {
            series.count(
                labels,
                match &member.of {
                    Of::Profibus { counters, .. } => counters.watchdog_expiries,
                    Of::Can { counters, .. } => counters.watchdog_expiries,
                },
            )
        }),
    ),
    Family::counter(
        "profidrive_faults",
        "How often the drive went to fault, or another fault came; of a node emergencies with an error \
         code.",
        Source::Members(|series, labels, member| {
            series.count(
                labels,
                match &member.of {
                    Of::Profibus { errors, .. } => errors.of(ErrorKind::Fault),
                    Of::Can { counters, .. } => counters.faults,
                },
            )
        }),
    ),
    Family::counter(
        "profidrive_errors",
        "What else went wrong at a station or node.",
        Source::Members(|series, labels, member| match &member.of {
            Of::Profibus { counters, errors, .. } => {
                series.counts(labels, "kind", &[("reply too late", counters.too_late)])?;
                // Faults have a metric of their own.
                let mut kinds = ErrorKind::ALL.iter().copied().filter(|kind| *kind != ErrorKind::Fault);
                kinds.try_for_each(|kind| series.counts(labels, "kind", &[(kind.name(), errors.of(kind))]))
            }
            Of::Can { counters, .. } => series.counts(labels, "kind", &counters.errors()),
        }),
    ),
    Family::gauge(
        "profidrive_node_state",
        "The NMT state of the node: 1 for the one that holds, 0 for the others.",
        Source::Members(|series, labels, member| match member.of {
            Of::Profibus { .. } => Ok(()),
            Of::Can { nmt, .. } => series.states(
                labels,
                &[
                    ("off", nmt.is_none()),
                    ("pre_operational", nmt == Some(NmtState::PreOperational)),
                    ("operational", nmt == Some(NmtState::Operational)),
                    ("stopped", nmt == Some(NmtState::Stopped)),
                ],
            ),
        }),
    ),
    Family::gauge(
        "profidrive_can_error_state",
        "Where the error counters have taken the CAN controller of the node: 1 for the state that \
         holds, 0 for the others.",
        Source::Members(|series, labels, member| match member.of {
            Of::Profibus { .. } => Ok(()),
            Of::Can { error_state, .. } => series.states(
                labels,
                &[
                    ("error_active", error_state == ErrorState::Active),
                    ("error_passive", error_state == ErrorState::Passive),
                    ("bus_off", error_state == ErrorState::BusOff),
                ],
            ),
        }),
    ),
    Family::counter(
        "profidrive_sdo_requests",
        "Frames of clients to the SDO server of the node, segments and aborts among them.",
        Source::Nodes(|series, labels, node| series.count(labels, node.sdo_requests)),
    ),
    Family::counter(
        "profidrive_sdo_aborts",
        "SDO transfers that ended with an abort code, by who sent it.",
        Source::Nodes(|series, labels, node| {
            let by = [("node", node.sdo_aborts), ("client", node.sdo_aborts_of_client)];
            series.counts(labels, "by", &by)
        }),
    ),
    Family::counter(
        "profidrive_pdos",
        "Process data of the node: RPDOs received, TPDOs sent.",
        Source::Nodes(|series, labels, node| {
            let both = [("received", node.pdos_received), ("sent", node.pdos_sent)];
            series.counts(labels, "direction", &both)
        }),
    ),
    Family::counter(
        "profidrive_emergencies",
        "EMCY messages that the node has sent, those with code 0000h (the end of an error) among them.",
        Source::Nodes(|series, labels, node| series.count(labels, node.emcy)),
    ),
    Family::counter(
        "profidrive_heartbeats",
        "Heartbeats that the node has sent.",
        Source::Nodes(|series, labels, node| series.count(labels, node.heartbeats)),
    ),
    Family::counter(
        "profidrive_guarding_replies",
        "Guarding requests that the node has answered.",
        Source::Nodes(|series, labels, node| series.count(labels, node.guarding)),
    ),
];

/// The first kinds of telegrams, which are requests.
const REQUESTS: usize = 4;

/// All metrics of a scrape as OpenMetrics.
pub(super) fn text(scrape: Scrape) -> Result<String, fmt::Error> {
    let mut registry = Registry::default();
    registry.register_collector(Box::new(scrape));
    let mut written = String::new();
    text::encode(&mut written, &registry)?;
    Ok(written)
}

impl Collector for Scrape {
    fn encode(&self, mut encoder: DescriptorEncoder<'_>) -> fmt::Result {
        FAMILIES.iter().try_for_each(|family| {
            let Family { name, kind, in_seconds, help, source } = family;
            let unit = in_seconds.then_some(Unit::Seconds);
            let metric = encoder.encode_descriptor(name, help, unit.as_ref(), *kind)?;
            source.tell(self, &mut Series(metric))
        })
    }
}
