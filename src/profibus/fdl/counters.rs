//! Counters of a line and of a station on it. Plain numbers that only grow; reading them is looking at the fields.
//!
//! Whoever carries the telegrams counts them here: [`host::Bus`](crate::host::Bus), or a firmware's own loop.
//! `Display` is a few short lines for people.

use core::fmt;
use core::time::Duration;

use super::function_code::{Function, Service};
use super::telegram::{FrameError, Telegram};

/// What was heard on a line: telegrams by kind, and octets that were none by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineCounters {
    /// Telegrams without an error, whoever they were for.
    pub heard: Kinds,
    /// Damaged telegrams and rows of noise, by the reason given.
    pub rejected: Rejections,
    /// How often the next telegram had to be searched for: rows of refusals without a telegram between.
    pub resyncs: u64,
    /// Telegrams that stations at this end sent.
    pub sent: u64,
    /// From the last octet of a request, as it was heard, to the start of its reply, for replies sent. Those of stations
    /// that are gone count on.
    pub latency: Latency,
    /// The last thing heard was a refusal.
    searching: bool,
}

impl LineCounters {
    /// Counts a telegram or a refusal.
    pub(crate) const fn hear(&mut self, result: &Result<Telegram<'_>, FrameError>) {
        match result {
            Ok(telegram) => {
                self.searching = false;
                self.heard.count(telegram);
            }
            Err(error) => {
                self.rejected.count(*error);
                if !self.searching {
                    self.resyncs = self.resyncs.saturating_add(1);
                }
                self.searching = true;
            }
        }
    }

    /// Counts a reply that one of our stations began `after` the end of its request.
    pub(crate) fn reply(&mut self, after: Duration) {
        self.sent = self.sent.saturating_add(1);
        self.latency.count(after);
    }
}

impl fmt::Display for LineCounters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "heard {}; sent {}; ", self.heard, self.sent)?;
        write!(f, "rejected {} ({}), {} resyncs", self.rejected.total(), self.rejected, self.resyncs)
    }
}

/// Telegrams by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kinds {
    /// SRD: data that want a reply, Data_Exchange and the services of DP.
    pub srd: u64,
    /// SDN: data without reply, Global_Control.
    pub sdn: u64,
    /// FDL status.
    pub fdl_status: u64,
    /// Other requests: SDA, ident, LSAP status, those of DP-V2.
    pub other: u64,
    /// Responses with a function code.
    pub responses: u64,
    /// SC.
    pub short_acknowledges: u64,
    /// Tokens.
    pub tokens: u64,
}

impl Kinds {
    const fn count(&mut self, telegram: &Telegram<'_>) {
        let kind = match telegram {
            Telegram::ShortAcknowledge => &mut self.short_acknowledges,
            Telegram::Token { .. } => &mut self.tokens,
            Telegram::Data(data) => match data.fc.function() {
                Function::Request(Service::SrdLow | Service::SrdHigh, _) => &mut self.srd,
                Function::Request(Service::SdnLow | Service::SdnHigh, _) => &mut self.sdn,
                Function::Request(Service::FdlStatus, _) => &mut self.fdl_status,
                Function::Request(
                    Service::TimeEvent
                    | Service::SdaLow
                    | Service::SdaHigh
                    | Service::Msrd
                    | Service::Ident
                    | Service::LsapStatus,
                    _,
                )
                | Function::Reserved => &mut self.other,
                Function::Response(..) => &mut self.responses,
            },
        };
        *kind = kind.saturating_add(1);
    }

    /// Every kind with a name and how often.
    pub(crate) const fn kinds(&self) -> [(&'static str, u64); 7] {
        [
            ("SRD", self.srd),
            ("SDN", self.sdn),
            ("FDL status", self.fdl_status),
            ("other requests", self.other),
            ("responses", self.responses),
            ("SC", self.short_acknowledges),
            ("tokens", self.tokens),
        ]
    }

    /// All of them.
    pub(crate) fn total(&self) -> u64 {
        sum(&self.kinds())
    }
}

impl fmt::Display for Kinds {
    /// All of them, and the kinds that happened.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} telegrams (", self.total())?;
        write_named(f, &self.kinds())?;
        f.write_str(")")
    }
}

/// What was no telegram, by reason: the variants of [`FrameError`]. A damaged telegram counts once however many octets it
/// has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(missing_docs, reason = "the variants of FrameError say it")]
pub struct Rejections {
    pub start_delimiter: u64,
    pub length: u64,
    pub repeated_length: u64,
    pub second_start_delimiter: u64,
    pub end_delimiter: u64,
    pub checksum: u64,
    pub extension: u64,
    pub token_address: u64,
    pub broken_off: u64,
    pub parity: u64,
}

impl Rejections {
    const fn count(&mut self, error: FrameError) {
        let reason = match error {
            FrameError::StartDelimiter { .. } => &mut self.start_delimiter,
            FrameError::Length { .. } => &mut self.length,
            FrameError::RepeatedLength { .. } => &mut self.repeated_length,
            FrameError::SecondStartDelimiter { .. } => &mut self.second_start_delimiter,
            FrameError::EndDelimiter { .. } => &mut self.end_delimiter,
            FrameError::Checksum { .. } => &mut self.checksum,
            FrameError::ExtensionMissing | FrameError::Extension { .. } => &mut self.extension,
            FrameError::TokenAddress { .. } => &mut self.token_address,
            FrameError::BrokenOff { .. } => &mut self.broken_off,
            FrameError::Parity => &mut self.parity,
        };
        *reason = reason.saturating_add(1);
    }

    /// Every reason with a name and how often, in the order of [`FrameError`].
    pub const fn reasons(&self) -> [(&'static str, u64); 10] {
        [
            ("start delimiter", self.start_delimiter),
            ("length", self.length),
            ("repeated length", self.repeated_length),
            ("second start delimiter", self.second_start_delimiter),
            ("end delimiter", self.end_delimiter),
            ("checksum", self.checksum),
            ("extension octet", self.extension),
            ("token address", self.token_address),
            ("broken off", self.broken_off),
            ("parity", self.parity),
        ]
    }

    /// All of them.
    pub fn total(&self) -> u64 {
        sum(&self.reasons())
    }
}

impl fmt::Display for Rejections {
    /// The reasons that happened, or `none`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_named(f, &self.reasons())
    }
}

fn sum(named: &[(&str, u64)]) -> u64 {
    named.iter().fold(0, |sum: u64, (_, times)| sum.saturating_add(*times))
}

/// What happened, with how often, or `none`.
fn write_named(f: &mut fmt::Formatter<'_>, named: &[(&str, u64)]) -> fmt::Result {
    let mut between = "";
    for (name, times) in named.iter().filter(|(_, times)| *times > 0) {
        write!(f, "{between}{name} {times}")?;
        between = ", ";
    }
    f.write_str(if between.is_empty() { "none" } else { "" })
}

/// What a station was asked and what it answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StationCounters {
    /// Telegrams to this station; broadcasts are not among them.
    pub requests: Kinds,
    /// Those among them that repeat the counted request (FCV = 1) before them octet for octet.
    pub retries: u64,
    /// Replies sent.
    pub replies: u64,
    /// Replies dropped because max T_SDR or the slot time of the master was over.
    pub too_late: u64,
    /// How often the watchdog of the layer above expired.
    pub watchdog_expiries: u64,
    /// From the last octet of a request, as it was heard, to the start of its reply, for replies sent.
    pub latency: Latency,
}

impl StationCounters {
    /// Counts a telegram to the station.
    pub(crate) const fn request(&mut self, telegram: &Telegram<'_>, retry: bool) {
        self.requests.count(telegram);
        if retry {
            self.retries = self.retries.saturating_add(1);
        }
    }

    /// Counts a reply that began `after` the end of its request.
    pub(crate) fn reply(&mut self, after: Duration) {
        self.replies = self.replies.saturating_add(1);
        self.latency.count(after);
    }
}

impl fmt::Display for StationCounters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { requests, retries, replies, too_late, watchdog_expiries, latency } = self;
        write!(f, "{requests}, {retries} retries; {replies} replies, {too_late} too late; ")?;
        write!(f, "watchdog expired {watchdog_expiries} times; replies {latency}")
    }
}

/// How many replies took how long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Latency {
    buckets: [u64; LATENCY_LIMITS.len() + 1],
    /// All of the times together, in ns.
    sum: u64,
}

/// The upper bounds of the buckets of [`Latency`], each counting the times up to and including its own and above the
/// one before; one more bucket counts what is longer than the last. From one T_bit at 1.5 Mbit/s, rounded up, to
/// the longest slot time anybody can set at 187.5 kbit/s, rounded up.
pub(crate) const LATENCY_LIMITS: [Duration; 16] = [
    Duration::from_micros(1),
    Duration::from_micros(2),
    Duration::from_micros(5),
    Duration::from_micros(10),
    Duration::from_micros(20),
    Duration::from_micros(50),
    Duration::from_micros(100),
    Duration::from_micros(200),
    Duration::from_micros(500),
    Duration::from_millis(1),
    Duration::from_millis(2),
    Duration::from_millis(5),
    Duration::from_millis(10),
    Duration::from_millis(20),
    Duration::from_millis(50),
    Duration::from_millis(100),
];

impl Latency {
    fn count(&mut self, time: Duration) {
        let place = LATENCY_LIMITS.iter().position(|limit| time <= *limit).unwrap_or(LATENCY_LIMITS.len());
        if let Some(bucket) = self.buckets.get_mut(place) {
            *bucket = bucket.saturating_add(1);
        }
        self.sum = self.sum.saturating_add(crate::time::nanos(time));
    }

    /// All of the times together.
    pub(crate) const fn sum(&self) -> Duration {
        Duration::from_nanos(self.sum)
    }

    /// The buckets with their upper bounds, shortest first; the last has none.
    pub fn buckets(&self) -> impl Iterator<Item = (Option<Duration>, u64)> + '_ {
        let limits = LATENCY_LIMITS.iter().copied().map(Some).chain([None]);
        limits.zip(self.buckets.iter().copied())
    }
}

impl fmt::Display for Latency {
    /// The buckets that are not empty, or `none`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut between = "after ";
        for (limit, times) in self.buckets().filter(|(_, times)| *times > 0) {
            match limit {
                Some(limit) => write!(f, "{between}<={limit:?}: {times}")?,
                None => write!(f, "{between}longer: {times}")?,
            }
            between = ", ";
        }
        f.write_str(if between == "after " { "none" } else { "" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profibus::fdl::telegram::{Decoded, decode};

    fn telegram(octets: &[u8]) -> Telegram<'_> {
        match decode(octets) {
            Decoded::Telegram { telegram, .. } => telegram,
            other @ (Decoded::Incomplete | Decoded::Invalid { .. }) => panic!("{other:?}"),
        }
    }

    #[test]
    fn telegrams_are_counted_by_kind_and_a_row_of_refusals_is_one_resync() {
        let mut line = LineCounters::default();
        line.hear(&Ok(telegram(&[0x10, 5, 2, 0x49, 0x50, 0x16])));
        line.hear(&Ok(telegram(&[0x10, 2, 5, 0, 7, 0x16])));
        line.hear(&Ok(telegram(&[0x10, 5, 2, 0x6D, 0x74, 0x16])));
        line.hear(&Ok(telegram(&[0x10, 5, 2, 0x4E, 0x55, 0x16])));
        line.hear(&Ok(telegram(&[0x68, 7, 7, 0x68, 0xFF, 0x81, 0x46, 0x3A, 0x3E, 0, 0, 0x3E, 0x16])));
        line.hear(&Err(FrameError::Parity));
        line.hear(&Err(FrameError::StartDelimiter { got: 0 }));
        line.hear(&Ok(telegram(&[0xE5])));
        line.hear(&Err(FrameError::Parity));
        line.hear(&Ok(telegram(&[0xDC, 1, 2])));
        let expected =
            Kinds { srd: 1, sdn: 1, fdl_status: 1, other: 1, responses: 1, short_acknowledges: 1, tokens: 1 };
        assert_eq!((line.heard, line.resyncs), (expected, 2));
        assert_eq!(
            line.to_string(),
            "heard 7 telegrams (SRD 1, SDN 1, FDL status 1, other requests 1, responses 1, SC 1, tokens 1); \
             sent 0; rejected 3 (start delimiter 1, parity 2), 2 resyncs"
        );
    }

    #[test]
    fn every_refusal_has_its_counter() {
        let mut rejected = Rejections::default();
        for error in [
            FrameError::StartDelimiter { got: 0 },
            FrameError::Length { got: 0 },
            FrameError::RepeatedLength { expected: 4, got: 0 },
            FrameError::SecondStartDelimiter { got: 0 },
            FrameError::EndDelimiter { got: 0 },
            FrameError::Checksum { expected: 0, got: 1 },
            FrameError::Extension { got: 0xFF },
            FrameError::TokenAddress { got: 0xFF },
            FrameError::BrokenOff { octets: 1 },
            FrameError::Parity,
        ] {
            rejected.count(error);
        }
        assert!(rejected.reasons().iter().all(|(_, times)| *times == 1), "{rejected:?}");
        rejected.count(FrameError::ExtensionMissing);
        assert_eq!((rejected.extension, rejected.total()), (2, 11));
        assert_eq!(Rejections::default().to_string(), "none");
    }

    #[test]
    fn a_bucket_holds_its_limit_and_what_is_longer_than_all_is_counted_too() {
        let mut station = StationCounters::default();
        for nanos in [0, 1_000, 1_001, 100_000_000, 100_000_001, u64::MAX] {
            station.reply(Duration::from_nanos(nanos));
        }
        let filled: [u64; 17] = core::array::from_fn(|at| match at {
            0 | 16 => 2,
            1 | 15 => 1,
            2..=14 | 17.. => 0,
        });
        assert_eq!(station.latency.buckets, filled);
        assert_eq!(station.latency.to_string(), "after <=1µs: 2, <=2µs: 1, <=100ms: 1, longer: 2");
        // Of 584 years more are not told apart.
        assert_eq!(station.latency.sum(), Duration::from_nanos(u64::MAX));
        let mut line = LineCounters::default();
        line.reply(Duration::from_micros(22));
        line.reply(Duration::from_micros(30));
        assert_eq!((line.sent, line.latency.sum()), (2, Duration::from_micros(52)));
        assert_eq!(Latency::default().to_string(), "none");
    }
}
