//! Every metric, once: its name, type, labels and meaning, and where its numbers come from.

use core::fmt;

use prometheus_client::collector::Collector;
use prometheus_client::encoding::{DescriptorEncoder, text};
use prometheus_client::metrics::MetricType;
use prometheus_client::registry::{Registry, Unit};

use super::line::{Counters, Member, Of};
use super::scrape::Scrape;
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
    pub(super) unit: Option<Unit>,
    /// What it means.
    pub(super) help: &'static str,
    series: fn(&Scrape, &mut Series<'_>) -> fmt::Result,
}

/// All of them, in the order in which they are written.
pub(super) const FAMILIES: &[Family] = &[
    Family {
        name: "profidrive_build",
        kind: MetricType::Info,
        unit: None,
        help: "The version of profidrive.",
        series: |_, series| series.info(&Labels::default().and("version", env!("CARGO_PKG_VERSION"))),
    },
    Family {
        name: "process_start_time",
        kind: MetricType::Gauge,
        unit: Some(Unit::Seconds),
        help: "When the metrics began, in seconds since 1970-01-01 UTC.",
        series: |scrape, series| series.gauge_without_labels(scrape.started),
    },
    Family {
        name: "profidrive_line",
        kind: MetricType::Info,
        unit: None,
        help: "A line: its bus, and the link that a master opens.",
        series: |scrape, series| {
            scrape.lines.iter().try_for_each(|found| {
                let bus = match found.line.counters {
                    Counters::Profibus(_) => "profibus",
                    Counters::Can(_) => "can",
                };
                series.info(&Labels::of_line(found.number).and("bus", bus).and("link", &found.link))
            })
        },
    },
    Family {
        name: "profidrive_line_rate_bits_per_second",
        kind: MetricType::Gauge,
        unit: None,
        help: "The rate of the line, or the one listened at while it is searched for.",
        series: |scrape, series| {
            let mut lines = scrape.lines.iter();
            lines.try_for_each(|found| series.gauge(&Labels::of_line(found.number), found.line.rate.into()))
        },
    },
    Family {
        name: "profidrive_telegrams_heard",
        kind: MetricType::Counter,
        unit: None,
        help: "Telegrams without an error on a line of PROFIBUS, whoever they were for.",
        series: |scrape, series| {
            lines(scrape, |labels, line| series.counts(labels, "kind", &line.heard.kinds()))
        },
    },
    Family {
        name: "profidrive_telegrams_sent",
        kind: MetricType::Counter,
        unit: None,
        help: "Telegrams that the stations of a line of PROFIBUS sent, those that are gone included.",
        series: |scrape, series| lines(scrape, |labels, line| series.count(labels, line.sent)),
    },
    Family {
        name: "profidrive_line_errors",
        kind: MetricType::Counter,
        unit: None,
        help: "On PROFIBUS damaged telegrams and rows of noise, by what was wrong first; on CAN error frames.",
        series: |scrape, series| {
            lines(scrape, |labels, line| series.counts(labels, "kind", &line.rejected.reasons()))?;
            buses(scrape, |labels, bus| series.counts(labels, "kind", &[("error frame", bus.errors)]))
        },
    },
    Family {
        name: "profidrive_resyncs",
        kind: MetricType::Counter,
        unit: None,
        help: "How often the next telegram had to be searched for on a line of PROFIBUS.",
        series: |scrape, series| lines(scrape, |labels, line| series.count(labels, line.resyncs)),
    },
    Family {
        name: "profidrive_reply_time",
        kind: MetricType::Histogram,
        unit: Some(Unit::Seconds),
        help: "From the last octet of a request, as it was heard, to the start of its reply, for replies sent on PROFIBUS.",
        series: |scrape, series| lines(scrape, |labels, line| series.histogram(labels, &line.latency)),
    },
    Family {
        name: "profidrive_can_frames",
        kind: MetricType::Counter,
        unit: None,
        help: "Frames that ended without error on a bus of CAN.",
        series: |scrape, series| {
            buses(scrape, |labels, bus| {
                let data = bus.frames.saturating_sub(bus.remote);
                series.counts(labels, "kind", &[("data", data), ("remote", bus.remote)])
            })
        },
    },
    Family {
        name: "profidrive_can_busy",
        kind: MetricType::Counter,
        unit: Some(Unit::Seconds),
        help: "How long bits were on the wire of a bus of CAN; its rate is the load, 0 to 1.",
        series: |scrape, series| {
            buses(scrape, |labels, bus| series.count_seconds(labels, bus.busy.as_secs_f64()))
        },
    },
    Family {
        name: "profidrive_station",
        kind: MetricType::Info,
        unit: None,
        help: "A station or node that is connected: what it is, and its model.",
        series: |scrape, series| {
            members(scrape, |labels, member| {
                series.info(&labels.and("kind", member.kind).and("model", &member.model))
            })
        },
    },
    Family {
        name: "profidrive_station_active",
        kind: MetricType::Gauge,
        unit: None,
        help: "1: the station takes part. 0: it listens whether somebody else has its address, or somebody has.",
        series: |scrape, series| {
            members(scrape, |labels, member| match member.of {
                Of::Profibus { active, .. } => series.gauge(&labels, active.into()),
                Of::Can { .. } => Ok(()),
            })
        },
    },
    Family {
        name: "profidrive_slave_state",
        kind: MetricType::Gauge,
        unit: None,
        help: "The state of the DP slave: 1 for the one that holds, 0 for the others.",
        series: |scrape, series| {
            members(scrape, |labels, member| match member.of {
                Of::Profibus { slave: Some(slave), .. } => {
                    let is = |state, name| (name, slave == state);
                    series.states(
                        &labels,
                        &[
                            is(dp::State::WaitPrm, "wait_prm"),
                            is(dp::State::WaitCfg, "wait_cfg"),
                            is(dp::State::DataExch, "data_exch"),
                        ],
                    )
                }
                Of::Profibus { slave: None, .. } | Of::Can { .. } => Ok(()),
            })
        },
    },
    Family {
        name: "profidrive_drive_state",
        kind: MetricType::Gauge,
        unit: None,
        help: "The state of the drive in the words that all devices share: 1 for the one that holds, 0 for the others.",
        series: |scrape, series| {
            members(scrape, |labels, member| {
                let Some(drive) = member.drive else { return Ok(()) };
                let mut states = DriveState::ALL.iter().map(|state| (state.name(), drive == *state));
                states.try_for_each(|state| series.states(&labels, &[state]))
            })
        },
    },
    Family {
        name: "profidrive_requests",
        kind: MetricType::Counter,
        unit: None,
        help: "Telegrams to the station; broadcasts are not among them.",
        series: |scrape, series| {
            stations(scrape, |labels, station| {
                // Nobody sends the other kinds to a slave.
                let kinds = station.requests.kinds();
                let requests = kinds.get(..REQUESTS).unwrap_or_default();
                series.counts(&labels, "kind", requests)
            })
        },
    },
    Family {
        name: "profidrive_retries",
        kind: MetricType::Counter,
        unit: None,
        help: "Requests that repeat the one before them.",
        series: |scrape, series| stations(scrape, |labels, station| series.count(&labels, station.retries)),
    },
    Family {
        name: "profidrive_replies",
        kind: MetricType::Counter,
        unit: None,
        help: "Replies that the station has sent.",
        series: |scrape, series| stations(scrape, |labels, station| series.count(&labels, station.replies)),
    },
    Family {
        name: "profidrive_station_reply_time",
        kind: MetricType::Counter,
        unit: Some(Unit::Seconds),
        help: "The reply times of the station, all together; divided by its replies the mean.",
        series: |scrape, series| {
            stations(scrape, |labels, station| {
                series.count_seconds(&labels, station.latency.sum().as_secs_f64())
            })
        },
    },
    Family {
        name: "profidrive_watchdog_expiries",
        kind: MetricType::Counter,
        unit: None,
        help: "How often the watchdog of the slave expired; of a node life guarding, or the heartbeat it supervises.",
        series: |scrape, series| {
            members(scrape, |labels, member| {
                series.count(
                    &labels,
                    match &member.of {
                        Of::Profibus { counters, .. } => counters.watchdog_expiries,
                        Of::Can { counters, .. } => counters.watchdog_expiries,
                    },
                )
            })
        },
    },
    Family {
        name: "profidrive_faults",
        kind: MetricType::Counter,
        unit: None,
        help: "How often the drive went to fault, or another fault came; of a node emergencies with an error code.",
        series: |scrape, series| {
            members(scrape, |labels, member| {
                series.count(
                    &labels,
                    match &member.of {
                        Of::Profibus { errors, .. } => errors.of(ErrorKind::Fault),
                        Of::Can { counters, .. } => counters.faults,
                    },
                )
            })
        },
    },
    Family {
        name: "profidrive_errors",
        kind: MetricType::Counter,
        unit: None,
        help: "What else went wrong at a station or node.",
        series: |scrape, series| {
            members(scrape, |labels, member| match &member.of {
                Of::Profibus { counters, errors, .. } => {
                    series.counts(&labels, "kind", &[("reply too late", counters.too_late)])?;
                    // Faults have a metric of their own.
                    let mut kinds = ErrorKind::ALL.iter().copied().filter(|kind| *kind != ErrorKind::Fault);
                    kinds.try_for_each(|kind| {
                        series.counts(&labels, "kind", &[(kind.name(), errors.of(kind))])
                    })
                }
                Of::Can { counters, .. } => series.counts(&labels, "kind", &counters.errors()),
            })
        },
    },
    Family {
        name: "profidrive_node_state",
        kind: MetricType::Gauge,
        unit: None,
        help: "The NMT state of the node: 1 for the one that holds, 0 for the others.",
        series: |scrape, series| {
            members(scrape, |labels, member| match member.of {
                Of::Profibus { .. } => Ok(()),
                Of::Can { nmt, .. } => series.states(
                    &labels,
                    &[
                        ("off", nmt.is_none()),
                        ("pre_operational", nmt == Some(NmtState::PreOperational)),
                        ("operational", nmt == Some(NmtState::Operational)),
                        ("stopped", nmt == Some(NmtState::Stopped)),
                    ],
                ),
            })
        },
    },
    Family {
        name: "profidrive_can_error_state",
        kind: MetricType::Gauge,
        unit: None,
        help: "Where the error counters have taken the CAN controller of the node: 1 for the state that holds, 0 for the others.",
        series: |scrape, series| {
            members(scrape, |labels, member| match member.of {
                Of::Profibus { .. } => Ok(()),
                Of::Can { error_state, .. } => series.states(
                    &labels,
                    &[
                        ("error_active", error_state == ErrorState::Active),
                        ("error_passive", error_state == ErrorState::Passive),
                        ("bus_off", error_state == ErrorState::BusOff),
                    ],
                ),
            })
        },
    },
    Family {
        name: "profidrive_sdo_requests",
        kind: MetricType::Counter,
        unit: None,
        help: "Frames of clients to the SDO server of the node, segments and aborts among them.",
        series: |scrape, series| nodes(scrape, |labels, node| series.count(&labels, node.sdo_requests)),
    },
    Family {
        name: "profidrive_sdo_aborts",
        kind: MetricType::Counter,
        unit: None,
        help: "SDO transfers that ended with an abort code, by who sent it.",
        series: |scrape, series| {
            nodes(scrape, |labels, node| {
                let by = [("node", node.sdo_aborts), ("client", node.sdo_aborts_of_client)];
                series.counts(&labels, "by", &by)
            })
        },
    },
    Family {
        name: "profidrive_pdos",
        kind: MetricType::Counter,
        unit: None,
        help: "Process data of the node: RPDOs received, TPDOs sent.",
        series: |scrape, series| {
            nodes(scrape, |labels, node| {
                let both = [("received", node.pdos_received), ("sent", node.pdos_sent)];
                series.counts(&labels, "direction", &both)
            })
        },
    },
    Family {
        name: "profidrive_emergencies",
        kind: MetricType::Counter,
        unit: None,
        help: "EMCY messages that the node has sent, those with code 0000h (the end of an error) among them.",
        series: |scrape, series| nodes(scrape, |labels, node| series.count(&labels, node.emcy)),
    },
    Family {
        name: "profidrive_heartbeats",
        kind: MetricType::Counter,
        unit: None,
        help: "Heartbeats that the node has sent.",
        series: |scrape, series| nodes(scrape, |labels, node| series.count(&labels, node.heartbeats)),
    },
    Family {
        name: "profidrive_guarding_replies",
        kind: MetricType::Counter,
        unit: None,
        help: "Guarding requests that the node has answered.",
        series: |scrape, series| nodes(scrape, |labels, node| series.count(&labels, node.guarding)),
    },
];

/// The first kinds of telegrams, which are requests.
const REQUESTS: usize = 4;

fn lines(scrape: &Scrape, mut tell: impl FnMut(&Labels, &LineCounters) -> fmt::Result) -> fmt::Result {
    scrape.lines.iter().try_for_each(|found| match &found.line.counters {
        Counters::Profibus(counters) => tell(&Labels::of_line(found.number), counters),
        Counters::Can(_) => Ok(()),
    })
}

fn buses(scrape: &Scrape, mut tell: impl FnMut(&Labels, &can::bus::Counters) -> fmt::Result) -> fmt::Result {
    scrape.lines.iter().try_for_each(|found| match &found.line.counters {
        Counters::Profibus(_) => Ok(()),
        Counters::Can(counters) => tell(&Labels::of_line(found.number), counters),
    })
}

fn members(scrape: &Scrape, mut tell: impl FnMut(Labels, &Member) -> fmt::Result) -> fmt::Result {
    scrape.members().try_for_each(|(labels, member)| tell(labels, member))
}

fn stations(scrape: &Scrape, mut tell: impl FnMut(Labels, &StationCounters) -> fmt::Result) -> fmt::Result {
    members(scrape, |labels, member| match &member.of {
        Of::Profibus { counters, .. } => tell(labels, counters),
        Of::Can { .. } => Ok(()),
    })
}

fn nodes(scrape: &Scrape, mut tell: impl FnMut(Labels, &NodeCounters) -> fmt::Result) -> fmt::Result {
    members(scrape, |labels, member| match &member.of {
        Of::Profibus { .. } => Ok(()),
        Of::Can { counters, .. } => tell(labels, counters),
    })
}

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
            let Family { name, kind, unit, help, series, .. } = family;
            let metric = encoder.encode_descriptor(name, help, unit.as_ref(), *kind)?;
            series(self, &mut Series(metric))
        })
    }
}
