//! Rows O: Global_Control, and what outputs say in CLEAR.

use core::time::Duration;

use super::Observer;
use super::cycle::Cycle;
use super::view::View;
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::judge::master::setup::Slave;
use crate::profibus::dp;
use crate::profibus::fdl::{Address, DataTelegram, FrameCount, Function};
use crate::time::Instant;

const CLEAR_DATA: u8 = 0x02;
/// Bits 0, 6 and 7.
const RESERVED: u8 = 0xC1;
/// Where Group_Ident is in Set_Prm.
const GROUP_OCTET: usize = 6;
/// Octets of Global_Control.
const LEN: usize = 2;
/// A session with data exchange shorter than this need not have shown OPERATE.
const LEAST_SESSION: Duration = Duration::from_secs(3);
/// OPERATE is announced again at least in this time.
const LEAST_REPEAT: Duration = Duration::from_secs(20);
/// Data_Exchange that may still carry outputs after CLEAR.
const GRACE: u32 = 2;

/// The operating mode that the master has announced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Mode {
    #[default]
    Unknown,
    Clear,
    Operate,
}

/// What Global_Control has said.
#[derive(Debug, Default)]
pub(super) struct Control {
    pub(super) mode: Mode,
    /// OPERATE was announced at least once.
    operated: bool,
    /// The groups that OPERATE was announced to, or all stations.
    operate_groups: u8,
    operate_to_all: bool,
    /// The first Data_Exchange and the last one.
    first_exchange: Option<Instant>,
    last_exchange: Option<Instant>,
    /// Data_Exchange with outputs since CLEAR, and without since OPERATE.
    since_clear: u32,
    /// When OPERATE was announced last, until that is too long ago.
    operate_at: Option<Instant>,
    /// How often it was announced since CLEAR.
    operates: u32,
    /// Somebody asked the master for CLEAR.
    pub(super) clear_wanted: bool,
    /// It is in CLEAR because stations are silent.
    auto_cleared: bool,
}

impl Observer {
    /// Somebody asks the master for CLEAR, or no longer does.
    pub(in crate::judge) const fn want_clear(&mut self, wanted: bool) {
        self.control.clear_wanted = wanted;
    }

    /// A station was silent until the master had given it up: OPERATE stays, or CLEAR comes if Auto_Clear is configured.
    pub(in crate::judge) fn judge_mode_at_loss(&mut self, station: Address) {
        match (self.setup.auto_clear, self.control.mode) {
            (None, Mode::Operate) => self.held(Row::O08),
            (Some(_), Mode::Clear) => self.held(Row::O07),
            (Some(time), Mode::Operate) => {
                let reason = format!(
                    "Auto_Clear is configured, station {station} was silent for more than twice {} ms, and no \
                     Global_Control with Clear_Data came",
                    time.as_millis()
                );
                self.show(Row::O07, Weight::Once, reason);
            }
            (_, Mode::Unknown) | (None, Mode::Clear) => {}
        }
    }

    /// Stations were silent for longer than Auto_Clear allows.
    pub(in crate::judge) fn note_auto_clear(&mut self) {
        self.control.auto_cleared = self.control.mode == Mode::Clear;
    }

    /// One of them is back, another one is still silent.
    pub(in crate::judge) fn judge_auto_clear(&mut self) {
        match (self.control.auto_cleared, self.control.mode) {
            (true, Mode::Clear) => self.held(Row::O09),
            (true, Mode::Operate | Mode::Unknown) => {
                let reason =
                    "Auto_Clear is configured, and OPERATE came back while a station was still silent";
                self.show(Row::O09, Weight::Once, reason.into());
            }
            (false, _) => {
                let reason = "the master did not go to CLEAR when two stations were silent";
                self.findings.missed(Row::O09, reason);
            }
        }
    }

    /// An SDN request.
    pub(super) fn controlled(&mut self, serial: u64, now: Instant, data: &DataTelegram<'_>) {
        self.judge_uncounted(serial, data);
        if dp::Service::of(data.dsap, data.ssap) != Some(dp::Service::GlobalControl) {
            return;
        }
        let &[command, groups] = data.data else {
            let reason = format!("Global_Control has {} octets, expected {LEN}", data.data.len());
            self.broken(Row::O04, Weight::Once, serial, None, reason);
            return;
        };
        self.held(Row::O04);
        if command & RESERVED == 0 {
            self.held(Row::O05);
        } else {
            let reason = format!("command 0x{command:02X}: bits 0, 6 and 7 are reserved, expected 0");
            self.broken(Row::O05, Weight::Once, serial, None, reason);
        }
        self.timing.controlled(now);
        self.note_command(command, groups);
        let lost = self.lost_station();
        let control = &mut self.control;
        if command & CLEAR_DATA == 0 {
            control.operated = true;
            control.operate_at = Some(now);
            control.operates = control.operates.saturating_add(1);
            control.operate_groups |= groups;
            control.operate_to_all |= groups == 0;
            control.mode = Mode::Operate;
            return;
        }
        let stays = control.mode == Mode::Operate && !control.clear_wanted && self.setup.auto_clear.is_none();
        if control.mode != Mode::Clear {
            control.since_clear = 0;
            control.operates = 0;
        }
        control.mode = Mode::Clear;
        // At other times it is the user who asks for CLEAR, and whether that was so a recording does not tell.
        if let Some((station, since)) = lost.filter(|_| stays && self.sight != super::Sight::Recorded) {
            let reason = format!("Global_Control with Clear_Data while station {station} is silent");
            self.broken(Row::O08, Weight::Once, since, None, reason);
        }
    }

    /// A station that exchanged data and does not answer, and the request that it did not answer.
    fn lost_station(&self) -> Option<(Address, u64)> {
        let silent = |view: &&View| {
            view.exchanges > 0
                && view.calm == 0
                && view.last.as_ref().is_some_and(|last| last.items.is_empty())
        };
        let last = self.views.values().filter(silent).find_map(|view| view.last.as_ref());
        last.map(|last| (last.to, last.serial))
    }

    /// Whether OPERATE was announced to every station, not only to some groups.
    fn judge_operate_groups(&mut self) {
        let groups = self.control.operate_groups;
        let left_out = |view: &View| {
            let group = view.prm_data.as_ref().and_then(|prm| prm.get(GROUP_OCTET)).copied();
            view.exchanges > 0 && group.is_some_and(|group| group & groups == 0)
        };
        let station = self.views.iter().find(|(_, view)| left_out(view)).map(|(number, _)| *number);
        match station.filter(|_| !self.control.operate_to_all) {
            Some(station) => {
                let reason = format!(
                    "OPERATE was announced to the groups 0x{groups:02X} only, and station {station} is in none of them"
                );
                self.show(Row::O01, Weight::Once, reason);
            }
            // A recording may leave out what is repeated.
            None if self.operate_due().is_some() && self.sight != super::Sight::Recorded => {
                let reason = "OPERATE was announced once, and data exchange was not seen until it must be announced again";
                self.findings.missed(Row::O01, reason);
            }
            None => self.held(Row::O01),
        }
    }

    /// FCV and FCB of a telegram that is not counted.
    pub(super) fn judge_uncounted(&mut self, serial: u64, data: &DataTelegram<'_>) {
        match data.fc.function() {
            Function::Request(_, FrameCount::Unused) => self.held(Row::C09),
            Function::Request(_, FrameCount::First | FrameCount::Even | FrameCount::Odd)
            | Function::Response(..)
            | Function::Reserved => {
                let reason = format!("function code 0x{:02X}: FCV and FCB are not 0", data.fc.octet());
                self.broken(Row::C09, Weight::Once, serial, None, reason);
            }
        }
    }

    /// A Global_Control that wants a reply.
    pub(super) fn judge_control_service(&mut self, cycle: &Cycle) {
        let reason = "Global_Control as SRD: it wants a reply";
        self.broken(Row::O04, Weight::Once, cycle.serial, None, reason);
    }

    /// In this time OPERATE is announced again.
    fn longest_repeat(&self) -> Duration {
        self.setup.longest_watchdog().unwrap_or_default().saturating_mul(3).max(LEAST_REPEAT)
    }

    /// When OPERATE, which was announced once, must have been announced again.
    pub(in crate::judge) fn operate_due(&self) -> Option<Instant> {
        let Control { mode, operate_at, operates, .. } = self.control;
        let once = mode == Mode::Operate && operates < 2;
        Some(operate_at.filter(|_| once)? + self.longest_repeat())
    }

    /// OPERATE is announced again and again.
    fn judge_repeated(&mut self, cycle: &Cycle) {
        let Control { mode, operate_at, .. } = self.control;
        let Some(at) = operate_at.filter(|_| mode == Mode::Operate) else { return };
        let silent = cycle.end.saturating_since(at);
        if silent > self.longest_repeat() && self.sight != super::Sight::Recorded {
            self.control.operate_at = None;
            let reason =
                format!("OPERATE was announced, and not again for {} s of data exchange", silent.as_secs());
            self.broken(Row::O01, Weight::Once, cycle.serial.saturating_sub(4), None, reason);
        }
    }

    /// The outputs of a Data_Exchange beside the operating mode.
    pub(super) fn judge_clear(&mut self, cycle: &Cycle, data: &[u8], slave: Option<&Slave>) {
        self.judge_repeated(cycle);
        let Self { control, .. } = self;
        control.first_exchange.get_or_insert(cycle.end);
        control.last_exchange = Some(cycle.end);
        let has_outputs = slave.and_then(Slave::lengths).is_some_and(|lengths| lengths.outputs > 0);
        let fail_safe = slave.is_some_and(|slave| slave.fail_safe);
        let zero = data.iter().all(|octet| *octet == 0);
        let (mode, operated) = (control.mode, control.operated);
        if data.is_empty() && has_outputs {
            let reason = match (fail_safe, mode) {
                (true, Mode::Clear | Mode::Unknown) => return self.held(Row::O06),
                (true, Mode::Operate) => "Data_Exchange without outputs in OPERATE",
                (false, _) => "Data_Exchange without outputs to a station without Fail_Safe",
            };
            self.broken(Row::O06, Weight::Once, cycle.serial, Some(cycle.to), reason);
            return;
        }
        match mode {
            Mode::Unknown if self.sight != super::Sight::Recorded => {
                if !zero {
                    let reason =
                        "outputs before OPERATE; the master shows no CLEAR phase, so this is left open";
                    self.findings.obstacle(Row::U10, reason);
                }
            }
            // Whoever exchanges data only now has shown nothing of the way there.
            Mode::Unknown | Mode::Operate => {}
            Mode::Clear if zero => {
                if operated {
                    self.held(Row::O03);
                } else {
                    self.held(Row::U10);
                }
            }
            Mode::Clear => {
                let control = &mut self.control;
                control.since_clear += 1;
                let stations = u32::try_from(self.setup.present().count()).unwrap_or(1).max(1);
                let (row, grace) = if operated { (Row::O03, GRACE * stations) } else { (Row::U10, 0) };
                if self.control.since_clear > grace {
                    let reason = "outputs that are not zero after Global_Control with Clear_Data";
                    self.broken(row, Weight::Once, cycle.serial.saturating_sub(4), None, reason);
                }
            }
        }
    }

    pub(super) fn finish_control(&mut self) {
        let session = match (self.control.first_exchange, self.control.last_exchange) {
            (Some(first), Some(last)) => last.saturating_since(first),
            (None, _) | (_, None) => Duration::ZERO,
        };
        let in_the_middle =
            self.sight == super::Sight::Recorded && self.views.values().all(|view| view.cfg_data.is_none());
        if self.control.operated {
            self.judge_operate_groups();
        } else if in_the_middle {
            self.findings
                .missed(Row::O01, "the recording begins in data exchange, and shows no Global_Control");
        } else if session >= LEAST_SESSION {
            let reason =
                format!("{} s of data exchange, and no Global_Control without Clear_Data", session.as_secs());
            self.broken(Row::O01, Weight::Once, self.recent.newest().saturating_sub(4), None, reason);
        } else {
            self.findings.obstacle(Row::O01, "data were exchanged for less than three seconds");
        }
        if self.setup.auto_clear.is_some() {
            self.findings.obstacle(Row::O07, "no station was silent while the master was in OPERATE");
            self.findings.obstacle(Row::O08, "does not apply: Auto_Clear is configured");
        } else {
            for row in [Row::O07, Row::O09] {
                self.findings.obstacle(row, "applies only if Auto_Clear is configured: --auto-clear MS");
            }
        }
        let reason = "which transition the user asked for is not known without --ask";
        self.findings.default_obstacle(Row::O12, reason);
    }
}
