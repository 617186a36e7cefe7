//! A drive of PROFIDRIVE version 2 as JSON.

use serde::Serialize;
use utoipa::ToSchema;

use super::super::bus_access::BusAccess;
use super::super::state::{Counters, DpState, PresenceState, seconds};
use crate::devices::ppo_drive::profile::{StwBit, ZswBit};
use crate::devices::ppo_drive::{Quantity, State};
use crate::face::Why;
use crate::host::HostedPpoDrive;
use crate::profibus::fdl::Address;
use crate::profibus::ppo::{JobId, Pkw, PpoType, ReplyId, Stw, Zsw};

/// The drives of PROFIDRIVE version 2 of a bus.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct PpoDrives {
    /// When this was so, since the bus was started.
    time_seconds: f64,
    ppo_drives: Vec<PpoDriveSummary>,
}

/// What is to be known about a drive at a glance.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct PpoDriveSummary {
    /// Station address.
    #[schema(minimum = 0, maximum = 126)]
    address: u8,
    ident_number: u16,
    presence: PresenceState,
    dp_state: DpState,
    /// The master that owns the slave.
    owner_address: Option<u8>,
    /// The PPO in use, as PPO 1; `null`: none, or none of the profile.
    ppo: Option<String>,
    /// The state of the drive in words (`profidrive-v2.md` 8).
    state: String,
    /// STW as the drive has seen it last.
    stw: u16,
    zsw: u16,
    /// The setpoint in force, in % of the reference speed.
    setpoint_percent: f64,
    /// The actual speed, in % of the reference speed.
    actual_percent: f64,
    speed_rpm: f64,
    operation_enabled: bool,
    fault: bool,
    warning: bool,
}

/// The complete state of a drive of PROFIDRIVE version 2.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct PpoDriveState {
    /// When this was so, since the bus was started.
    time_seconds: f64,
    #[serde(flatten)]
    summary: PpoDriveSummary,
    /// The watchdog time that Set_Prm asked for; `null`: no watchdog runs.
    watchdog_milliseconds: Option<u64>,
    /// Bit 0 first.
    stw_bits: Vec<ProfileBit>,
    /// Bit 0 first.
    zsw_bits: Vec<ProfileBit>,
    /// It turns: nothing keeps it from that.
    turning: bool,
    /// What keeps it from turning, the first thing to do first.
    why: Vec<String>,
    reference_speed_rpm: f64,
    /// The output of the ramp generator.
    ramp_rpm: f64,
    torque_percent: f64,
    current_amperes: f64,
    load_percent: f64,
    /// The numbers of the faults that stand, PNU 947.1 to 947.8.
    faults: Vec<u16>,
    /// The numbers of those that were acknowledged, the newest occasion first.
    faults_acknowledged: Vec<u16>,
    /// The last warnings, the newest first, PNU 953 to 960.
    warnings: Vec<u16>,
    /// What the master asked of the parameter channel last.
    pkw_job: Option<Dialogue>,
    /// What the drive answers.
    pkw_reply: Option<Dialogue>,
    /// The newest request of a master that the drive refused, and why.
    last_refusal: Option<String>,
    counters: Counters,
}

/// One bit of a word of the profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
struct ProfileBit {
    bit: u8,
    set: bool,
    /// What 1 means.
    name: &'static str,
}

/// A job or a reply of the parameter channel.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct Dialogue {
    /// The four words in hexadecimal.
    words_hex: String,
    pnu: u16,
    /// The name of the parameter, if the table has it.
    parameter: Option<String>,
    /// In words.
    text: String,
}

impl PpoDrives {
    pub(in crate::panel) fn of(bench: &BusAccess<'_>) -> Self {
        let summary = |address| Some(PpoDriveSummary::of(bench, address, bench.bus.station(address)?));
        let ppo_drives = bench.bus.addresses().filter_map(summary).collect();
        Self { time_seconds: seconds(bench.now), ppo_drives }
    }
}

/// 4000h is 100 %.
fn percent(value: i16) -> f64 {
    tenths(f64::from(value) / 163.84)
}

/// Digits that say nothing are left out.
fn tenths(value: f64) -> f64 {
    libm::round(value * 10.0) / 10.0
}

impl PpoDriveSummary {
    fn of(bench: &BusAccess<'_>, address: Address, hosted: &HostedPpoDrive) -> Self {
        let (drive, slave) = (hosted.drive(), hosted.drive().slave());
        let status = drive.drive().status();
        Self {
            address: address.number(),
            ident_number: slave.description().ident,
            presence: bench.bus.presence(address).into(),
            dp_state: slave.state().into(),
            owner_address: slave.owner().map(Address::number),
            ppo: drive.ppo().filter(|kind| *kind != PpoType::SevenWords).map(|kind| kind.to_string()),
            state: status.state.to_string(),
            stw: drive.stw().raw(),
            zsw: drive.zsw().raw(),
            setpoint_percent: percent(drive.command().setpoint),
            actual_percent: percent(status.actual),
            speed_rpm: tenths(drive.drive().quantity(Quantity::ActualSpeed, 1)),
            operation_enabled: status.state == State::Operation,
            fault: status.state == State::Fault,
            warning: status.warning,
        }
    }
}

impl PpoDriveState {
    pub(super) fn of(bench: &BusAccess<'_>, address: Address, hosted: &HostedPpoDrive) -> Self {
        let drive = hosted.drive();
        let watchdog = drive.slave().watchdog().map(|(time, _)| time.as_millis());
        let quantity = |quantity| tenths(drive.drive().quantity(quantity, 1));
        let (stw, zsw) = (drive.stw(), drive.zsw());
        let faults = drive.drive().faults();
        let numbers = |from: u8, to: u8| -> Vec<u16> {
            (from..=to).filter_map(|at| faults.number(at)).filter(|number| *number != 0).collect()
        };
        let mut why = Vec::new();
        drive.each_reason(&mut |reason| why.push(reason.to_string()));
        let (job, reply) = drive.channel();
        let name = |pkw: Pkw| drive.table().row(pkw.pke.pnu()).map(|row| row.name.clone());
        Self {
            time_seconds: seconds(bench.now),
            summary: PpoDriveSummary::of(bench, address, hosted),
            watchdog_milliseconds: watchdog.map(|time| u64::try_from(time).unwrap_or(u64::MAX)),
            stw_bits: stw_bits(stw),
            zsw_bits: zsw_bits(zsw),
            turning: drive.is_moving() == Some(true),
            why,
            reference_speed_rpm: quantity(Quantity::ReferenceSpeed),
            ramp_rpm: quantity(Quantity::SetpointSpeed),
            torque_percent: quantity(Quantity::Torque),
            current_amperes: quantity(Quantity::Current),
            load_percent: quantity(Quantity::Load),
            faults: numbers(1, 8),
            faults_acknowledged: numbers(9, 64),
            warnings: (0..8)
                .filter_map(|at| drive.drive().warnings().number(at))
                .filter(|number| *number != 0)
                .collect(),
            pkw_job: (job.pke.job() != JobId::NoJob)
                .then(|| Dialogue::of(job, &job.pke.job().to_string(), name(job))),
            pkw_reply: (reply.pke.reply() != ReplyId::NoReply)
                .then(|| Dialogue::of(reply, &reply.pke.reply().to_string(), name(reply))),
            last_refusal: None,
            counters: bench.bus.station_counters(address).map(Counters::from).unwrap_or_default(),
        }
    }

    /// With the newest refusal, which the drive does not remember.
    pub(in crate::panel) fn with_refusal(self, last_refusal: Option<String>) -> Self {
        Self { last_refusal, ..self }
    }

    /// Whether nothing has changed but time.
    pub(in crate::panel) fn is_same(&self, other: &Self) -> bool {
        let timeless =
            |state: &Self| Self { time_seconds: 0.0, counters: Counters::default(), ..state.clone() };
        timeless(self) == timeless(other)
    }
}

fn stw_bits(stw: Stw) -> Vec<ProfileBit> {
    let bit = |bit: &StwBit| ProfileBit { bit: bit.number(), set: bit.is_set(stw), name: bit.name() };
    StwBit::ALL.iter().map(bit).collect()
}

fn zsw_bits(zsw: Zsw) -> Vec<ProfileBit> {
    let bit = |bit: &ZswBit| ProfileBit { bit: bit.number(), set: bit.is_set(zsw), name: bit.name() };
    ZswBit::ALL.iter().map(bit).collect()
}

impl Dialogue {
    fn of(pkw: Pkw, what: &str, parameter: Option<String>) -> Self {
        let pnu = pkw.pke.pnu();
        let element = pkw.ind.high_octet();
        let place = if element == 0 { pnu.to_string() } else { format!("{pnu}.{element}") };
        let named = parameter.as_ref().map(|name| format!(" {name}")).unwrap_or_default();
        let text = format!("{what}, PNU {place}{named}, value {}", pkw.double_word());
        Self { words_hex: pkw.to_string(), pnu, parameter, text }
    }
}
