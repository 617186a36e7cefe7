//! What the telegrams show of one station and of how the master treats it.

use core::time::Duration;

use super::acyclic::Services;
use super::cycle::Cycle;
use crate::judge::master::rows::Row;
use crate::profibus::dp::{Diagnosis, IoLengths};
use crate::time::Instant;

/// One station.
#[derive(Clone, Debug, Default)]
pub(super) struct View {
    /// The last SRD request, once the master has gone on.
    pub(super) last: Option<Cycle>,
    /// It has answered something.
    pub(super) answered: bool,
    /// Its diagnosis was read since the master began or lost it.
    pub(super) diag_read: bool,
    pub(super) prm: Step,
    pub(super) cfg: Step,
    /// It may have been acknowledged, or not.
    pub(super) cfg_in_doubt: bool,
    /// Its diagnosis was read since Chk_Cfg.
    pub(super) diag_after_cfg: bool,
    /// The last diagnosis was too short.
    pub(super) short_diag: bool,
    /// The last good diagnosis.
    pub(super) diag: Option<Diagnosis>,
    /// What diagnoses have shown since the last Set_Prm.
    pub(super) shown: Shown,
    /// Data_Exchange was answered with data since the last start-up.
    pub(super) exchanging: bool,
    pub(super) loss: Loss,
    /// Good Data_Exchange in a row.
    pub(super) streak: u32,
    /// The same, whatever the judge has begun anew.
    pub(super) calm: u32,
    /// Cycles in a row with one good reply each.
    pub(super) sound: u32,
    /// All good Data_Exchange.
    pub(super) exchanges: u32,
    /// All Data_Exchange requests, retries apart.
    pub(super) polled: u32,
    /// Good Data_Exchange while nothing was wrong on purpose.
    pub(super) undisturbed: u32,
    /// Start-ups that were complete.
    pub(super) start_ups: u32,
    /// The last Set_Prm.
    pub(super) prm_data: Option<Vec<u8>>,
    /// The last Chk_Cfg.
    pub(super) cfg_data: Option<Vec<u8>>,
    /// The last Prm_Fault or Cfg_Fault that a diagnosis has shown, one of them set.
    pub(super) fault: Option<(bool, bool)>,
    /// The outputs of the last Data_Exchange.
    pub(super) last_outputs: Option<Vec<u8>>,
    /// What the identifiers of the last Chk_Cfg exchange.
    pub(super) lengths: Option<IoLengths>,
    pub(super) watchdog: Option<Duration>,
    /// When it was last asked for anything.
    pub(super) spoken_to: Option<Instant>,
    /// When it was last asked by SRD.
    pub(super) asked: Option<Instant>,
    /// All SRD requests.
    pub(super) asks: u32,
    /// How long the master is silent behind a good reply, before its next telegram.
    pub(super) pause: Duration,
    /// The longest of these pauses.
    pub(super) longest_pause: Duration,
    /// How long that request was, in octets.
    pub(super) asked_len: usize,
    /// The last Data_Exchange request, if nothing else was asked since.
    pub(super) exchange_asked: Option<Instant>,
    /// Times between two requests in data exchange.
    pub(super) intervals: Vec<Duration>,
    /// Data_Exchange since a reply of high priority, and the row that wants the diagnosis.
    pub(super) announced: Option<Due>,
    /// Replies of high priority in a row.
    pub(super) dh_in_row: u32,
    /// Data_Exchange since a diagnosis that wants a new start-up.
    pub(super) restart_due: Option<Due>,
    /// A diagnosis wanted a new start-up and the next one no longer did: both reactions are right.
    pub(super) excused: Option<Row>,
    /// Diagnoses in a row while data are exchanged.
    pub(super) diagnoses: u32,
    /// Data_Exchange with a reply that cannot be right.
    pub(super) wrong_replies: Option<WrongReplies>,
    /// What was unusual, and how many good exchanges ago.
    pub(super) disturbed: Option<Disturbed>,
    /// The retries were over and the master went on.
    pub(super) gave_up: bool,
    /// The same, until it answers a request: an FDL status counts no retries.
    pub(super) over: bool,
    /// The last start-up began with FCV = 0: the master may have begun anew.
    pub(super) anew: bool,
    /// Requests since then, FDL status included.
    pub(super) asked_since: u32,
    /// Data_Exchange answered with RS, without a diagnosis between, and since when.
    pub(super) refused: Option<Refused>,
    /// Station_Not_Ready since then.
    pub(super) not_ready: Option<(Instant, u64)>,
    /// Diagnoses since Chk_Cfg got a negative answer.
    pub(super) waits: u32,
    /// First cycles in a row without answer.
    pub(super) first_run: u32,
    /// DP-V1.
    pub(super) services: Services,
}

/// How far a start-up service has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Step {
    /// Not asked since the master began or lost the station.
    #[default]
    None,
    Acknowledged,
    /// RS, or another negative answer.
    Refused,
    /// No good answer.
    Unanswered,
}

/// How a station was lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Loss {
    #[default]
    None,
    /// It said nothing until the retries were over.
    Silent,
    /// It answered RS.
    Refused,
}

/// What the diagnoses of a start-up have shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Shown {
    pub(super) not_ready: bool,
    pub(super) stat_diag: bool,
    pub(super) prm_fault: bool,
    pub(super) cfg_fault: bool,
    pub(super) other_ident: bool,
    pub(super) short: bool,
    pub(super) other_master: bool,
}

/// Replies to Data_Exchange that cannot be right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct WrongReplies {
    pub(super) row: Row,
    pub(super) since: Instant,
    pub(super) count: u32,
    /// The number of the first request that was answered so.
    pub(super) serial: u64,
}

/// Something that a row wants the master to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Due {
    pub(super) row: Row,
    /// Data_Exchange since then.
    pub(super) exchanges: u32,
    /// The number of the request whose reply showed it.
    pub(super) serial: u64,
}

impl Due {
    pub(super) const fn new(row: Row, serial: u64) -> Self {
        Self { row, exchanges: 0, serial }
    }
}

/// Data_Exchange answered with RS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Refused {
    pub(super) since: Instant,
    pub(super) count: u32,
    /// The number of the first request that was answered so.
    pub(super) serial: u64,
}

/// Something unusual, and how many good exchanges ago.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Disturbed {
    pub(super) what: Disturbance,
    pub(super) age: u32,
    /// The number of the request that shows it.
    pub(super) serial: u64,
}

/// What a new start-up would be no right reaction to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Disturbance {
    LostReply,
    /// A new start-up is right.
    BadReply,
    CleanDiagnosis,
    LongDiagnosis,
    Overflow,
    /// A job of DP-V1 is not over yet.
    SlowJob,
    /// One was refused.
    RefusedJob,
}

impl Disturbance {
    pub(super) const fn row(self) -> Option<Row> {
        match self {
            Self::LostReply => Some(Row::L08),
            Self::BadReply => None,
            Self::CleanDiagnosis => Some(Row::D06),
            Self::LongDiagnosis => Some(Row::D08),
            Self::Overflow => Some(Row::D09),
            Self::SlowJob => Some(Row::V05),
            Self::RefusedJob => Some(Row::V07),
        }
    }

    /// The row that holds when nothing has come of it.
    pub(super) const fn proves(self) -> Option<Row> {
        match self {
            // Only the response shows that it was waited for.
            Self::SlowJob => None,
            Self::LostReply
            | Self::BadReply
            | Self::CleanDiagnosis
            | Self::LongDiagnosis
            | Self::Overflow
            | Self::RefusedJob => self.row(),
        }
    }
}

impl View {
    /// The master has lost the station, or should have.
    pub(super) fn lose(&mut self, loss: Loss) {
        self.loss = loss;
        self.diag_read = false;
        self.prm = Step::None;
        self.streak = 0;
        self.calm = 0;
        self.announced = None;
        self.restart_due = None;
        self.disturbed = None;
        self.dh_in_row = 0;
        self.services.end_owners();
    }

    /// Something was not as it should be.
    pub(super) const fn trouble(&mut self) {
        self.streak = 0;
        self.calm = 0;
    }
}
