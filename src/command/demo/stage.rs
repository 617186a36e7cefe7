//! The PROFIBUS of the demo: profirust as master and a drive.

use core::time::Duration;
use std::collections::VecDeque;
use std::io::Write;

use crate::bench::{Line, Sender};
use crate::client::ZswPattern;
use crate::devices::StationEvent;
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::profibus::bits::Word;
use crate::devices::ag03::profibus::{Config, Device};
use crate::explain::words;
use crate::explain::{self, Context, Explanation, Kind};
use crate::face::EventKind;
use crate::master::{Profirust, baudrate, peripheral};
use crate::profibus::fdl::Address;
use crate::profibus::pkw::ErrorNumber;
use crate::profibus::ppo::{Ind, Inputs, JobId, Outputs, Pke, Pkw, ReplyId, Stw, Zsw};
use crate::time::{BaudRate, Instant};
use profirust::dp::{DpMaster, PeripheralHandle};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};

use super::chart::Recording;
use super::page::{INDENT, Page, Trouble, WIDTH, unexpected};

const DRIVE: u8 = 5;
const MASTER: u8 = 2;
const BAUD: BaudRate = BaudRate::K500;
const MODE: Mode = Mode::Positioning;
const WATCHDOG: Duration = Duration::from_millis(200);

/// How long anything may take on the bus before it is unexpected.
const PATIENCE: Duration = Duration::from_secs(10);
/// How often the position is recorded.
const SAMPLE: Duration = Duration::from_millis(10);

/// Master, wire and drive, and the page.
pub(super) struct Stage<'w> {
    bus: Line<Profirust<'static>>,
    drive: PeripheralHandle,
    pub(super) page: Page<'w>,
    pkw: Pkw,
    stw: Stw,
    setpoint: i32,
    /// The status word that was last told.
    zsw: Zsw,
    /// What the drive has reported and nobody has asked for yet.
    events: VecDeque<StationEvent>,
    recording: Option<Recording>,
    sampled: Instant,
}

impl<'w> Stage<'w> {
    /// A master and a drive that have just been switched on.
    pub(super) fn open(out: &'w mut dyn Write) -> Result<Self, Trouble> {
        let mut dp = DpMaster::new(Vec::new());
        let drive = dp.add(peripheral(DRIVE, BAUD));
        dp.enter_operate();
        let parameters = ParametersBuilder::new(MASTER, baudrate(BAUD))
            .watchdog_timeout(WATCHDOG.into())
            .build_verified(&dp);
        let mut fdl = FdlActiveStation::new(parameters);
        fdl.set_online();
        let mut bus = Profirust::on_line(fdl, dp).map_err(unexpected)?;
        bus.add_drive(Config::new(Address::station(DRIVE).map_err(unexpected)?)).map_err(unexpected)?;
        let mut stage = Self {
            bus,
            drive,
            page: Page::new(out),
            pkw: Pkw::ZERO,
            stw: Stw::default(),
            setpoint: 0,
            zsw: Zsw::default(),
            events: VecDeque::new(),
            recording: None,
            sampled: Instant::ZERO,
        };
        stage.page.text(&format!(
            "profidrive demo: profirust as DP master {MASTER} and an emulated SIKO AG03/1 as station {DRIVE} on a \
             wire at {BAUD}, all in memory. Times are milliseconds on the bus."
        ))?;
        Ok(stage)
    }

    /// Shows every telegram between master and drive until the drive's first inputs have come.
    pub(super) fn start_up(&mut self) -> Result<(), Trouble> {
        let mut told = Vec::new();
        let mut context = Context::with_mode(MODE);
        let outcome = self.bus.run_until(PATIENCE, |bus| {
            let mut inputs = false;
            while let Some(heard) = bus.poll_telegram() {
                let explanation = context.telegram(&heard.octets);
                inputs |= is_inputs(&explanation);
                if belongs(&explanation) {
                    told.push((heard, explanation.summary));
                }
            }
            inputs
        });
        for (heard, words) in told {
            let speaker = match heard.sender {
                Sender::Master | Sender::Test => "master",
                Sender::Station => "drive",
            };
            let hex: Vec<String> = heard.octets.iter().map(|octet| format!("{octet:02X}")).collect();
            let hex = hex.join(" ");
            let room = (WIDTH - INDENT).saturating_sub(words.chars().count());
            if hex.len() + 2 <= room {
                self.page.line(heard.at, speaker, format_args!("{words}{hex:>room$}"))?;
            } else {
                self.page.line(heard.at, speaker, format_args!("{words}"))?;
                self.page.line_without_time("", format_args!("{hex}"))?;
            }
        }
        outcome.map_err(|error| Trouble::Unexpected(format!("the drive does not start: {error}")))?;
        self.run_for(Duration::from_millis(5));
        Ok(())
    }

    /// Gives a job, expects this reply, and takes the job back.
    pub(super) fn job(
        &mut self,
        job: JobId,
        pnu: u16,
        value: u32,
        meaning: &str,
        expected: &str,
    ) -> Result<(), Trouble> {
        let request = Pkw::new(Pke::of_job(job, pnu), Ind::default(), value);
        self.page.line(self.bus.now(), "job", format_args!("{request}  PNU {pnu}: {meaning}"))?;
        self.pkw = request;
        self.exchange(&format!("a reply to job {request}"), |inputs| inputs.pkw() != Pkw::ZERO)?;
        let reply = self.inputs()?.pkw();
        let answer = match reply.pke.reply() {
            ReplyId::NotExecutable => match ErrorNumber::from_number(reply.word()) {
                Some(error) => error.to_string(),
                None => format!("error {}", reply.word()),
            },
            ReplyId::Word => format!("{}", reply.word()),
            ReplyId::DoubleWord => format!("{}", reply.double_word().cast_signed()),
            ReplyId::NoReply
            | ReplyId::Description
            | ReplyId::ElementWord
            | ReplyId::ElementDoubleWord
            | ReplyId::ElementCount
            | ReplyId::NoControlRights
            | ReplyId::Reserved(_) => reply.pke.reply().to_string(),
        };
        self.page.line(self.bus.now(), "reply", format_args!("{reply}  {answer}"))?;
        if reply.to_string() != expected {
            return Err(Trouble::Unexpected(format!(
                "job {request} was answered {reply}, expected {expected}"
            )));
        }
        self.pkw = Pkw::ZERO;
        self.exchange("no reply without a job", |inputs| inputs.pkw() == Pkw::ZERO)
    }

    /// Sends a control word and a setpoint, and waits until the status word shows what is meant to follow.
    pub(super) fn command(
        &mut self,
        meaning: &str,
        stw: Stw,
        setpoint: i32,
        expected: ZswPattern,
    ) -> Result<(), Trouble> {
        let changes = words::changes(Word::Stw, MODE, self.stw.raw(), stw.raw());
        self.stw = stw;
        self.setpoint = setpoint;
        self.page.line(self.bus.now(), "STW", format_args!("{stw}  {meaning}: {changes}"))?;
        // The inputs answer the exchange before; with two cycles of the drive they are of these outputs.
        self.run_for(Duration::from_millis(5));
        self.observe(expected)
    }

    /// Waits until the status word shows what is expected, and says so.
    pub(super) fn observe(&mut self, pattern: ZswPattern) -> Result<(), Trouble> {
        self.exchange(&format!("status {pattern}"), |inputs| pattern.matches(inputs.zsw()))?;
        let inputs = self.inputs()?;
        let (zsw, position) = (inputs.zsw(), inputs.hiw());
        let said = words::said(MODE, self.zsw.raw(), zsw.raw());
        self.zsw = zsw;
        self.page.line(self.bus.now(), "ZSW", format_args!("{zsw}  {said}; at {position}"))
    }

    /// Says the reason for what has just happened, which the drive reported as an event.
    pub(super) fn reason(&mut self, of_interest: EventKind) -> Result<(), Trouble> {
        let found = core::iter::from_fn(|| self.events.pop_front()).find(|event| event.kind() == of_interest);
        let Some(event) = found else {
            return Err(Trouble::Unexpected("the drive gives no reason".into()));
        };
        self.page.line_without_time("why", format_args!("{event}"))
    }

    /// Changes what acts on the drive from outside.
    pub(super) fn surround(&mut self, inputs: drive::Inputs) {
        self.bus.with_station(DRIVE, |device: &mut Device, now| device.set_inputs(now, inputs));
    }

    /// Records the position from now on.
    pub(super) fn begin_recording(&mut self) {
        self.recording = Some(Recording::default());
        self.sampled = Instant::ZERO;
    }

    /// Names this moment in the recording.
    pub(super) fn mark(&mut self, name: &'static str) {
        let now = self.bus.now();
        if let Some(recording) = &mut self.recording {
            recording.mark(now, name);
        }
    }

    /// Draws what was recorded.
    pub(super) fn draw_recording(&mut self) -> Result<(), Trouble> {
        self.page.picture(&self.recording.take().unwrap_or_default().lines())
    }

    /// Lets time pass on the bus.
    pub(super) fn run_for(&mut self, duration: Duration) {
        // Nothing is waited for but the time.
        let _ = self.run(duration, |_| false);
    }
}

impl Stage<'_> {
    /// Waits for inputs, naming what is waited for if they do not come.
    fn exchange(&mut self, what: &str, condition: impl FnMut(Inputs<'_>) -> bool) -> Result<(), Trouble> {
        if self.run(PATIENCE, condition) {
            return Ok(());
        }
        let zsw: Zsw = self.inputs()?.zsw();
        Err(Trouble::Unexpected(format!("waited {PATIENCE:?} for {what}; the status word is {zsw}")))
    }

    /// Exchanges data until inputs meet the condition, at most for `limit`. Records and collects meanwhile.
    fn run(&mut self, limit: Duration, mut condition: impl FnMut(Inputs<'_>) -> bool) -> bool {
        let Self { bus, drive, events, recording, sampled, .. } = self;
        let octets = Outputs::octets(self.pkw, self.stw, self.setpoint);
        bus.master.dp.get_mut(*drive).pi_q_mut().copy_from_slice(&octets);
        let outcome = bus.run_until(limit, |bus| {
            events.extend(core::iter::from_fn(|| bus.poll_event()).map(|(_, event)| event));
            let now = bus.now();
            let drive = bus.master.dp.get_mut(*drive);
            let Ok(inputs) = Inputs::parse(drive.pi_i()) else {
                return false;
            };
            if let Some(recording) = recording
                && now.saturating_since(*sampled) >= SAMPLE
            {
                recording.sample(now, inputs.hiw());
                *sampled = now;
            }
            drive.is_running() && condition(inputs)
        });
        outcome.is_ok()
    }

    fn inputs(&mut self) -> Result<Inputs<'_>, Trouble> {
        Inputs::parse(self.bus.master.dp.get_mut(self.drive).pi_i()).map_err(unexpected)
    }
}

/// Whether a telegram belongs to the story: no token, and not for a station that is not there.
fn belongs(explanation: &Explanation) -> bool {
    let ours = |address: u8| address == DRIVE || address == Address::BROADCAST.number();
    explanation.kind == Kind::Telegram && [explanation.from, explanation.to].into_iter().flatten().any(ours)
}

/// Whether a telegram carries the inputs of the drive.
fn is_inputs(explanation: &Explanation) -> bool {
    let exchange =
        explanation.service == Some("Data_Exchange") && explanation.sender == Some(explain::Sender::Slave);
    exchange && explanation.fields.iter().any(|field| field.name == "ZSW")
}
