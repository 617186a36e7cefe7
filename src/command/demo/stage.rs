//! The PROFIBUS of the demo: profirust as master and a drive.

use core::time::Duration;
use std::collections::VecDeque;
use std::io::Write;

use crate::bench::{Line, Sender};
use crate::devices::StationEvent;
use crate::devices::story::{PLACE, SlaveAct};
use crate::explain::words;
use crate::explain::{self, Context, Explanation, Kind, Mode};
use crate::face::{Description, EventKind};
use crate::host::list::{Device, Ground, Spec};
use crate::host::{Refusals, ValueBoard};
use crate::master::{Profirust, baudrate, peripheral};
use crate::profibus::fdl::Address;
use crate::profibus::pkw::ErrorNumber;
use crate::profibus::ppo::{Ind, Inputs, JobId, Outputs, Pke, Pkw, ReplyId, Stw, Zsw, ZswPattern};
use crate::time::{BaudRate, Instant};
use profirust::dp::{DpMaster, PeripheralHandle};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};

use super::chart::Recording;
use super::page::{INDENT, Page, Trouble, WIDTH, unexpected};

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
    pub(super) fn open(device: &'static Device, out: &'w mut dyn Write) -> Result<Self, Trouble> {
        let mut dp = DpMaster::new(Vec::new());
        let drive = dp.add(peripheral(PLACE, BAUD));
        dp.enter_operate();
        let parameters = ParametersBuilder::new(MASTER, baudrate(BAUD))
            .watchdog_timeout(WATCHDOG.into())
            .build_verified(&dp);
        let mut fdl = FdlActiveStation::new(parameters);
        fdl.set_online();
        let mut bus = Profirust::on_line(fdl, dp).map_err(unexpected)?;
        let ground = Ground {
            now: bus.now(),
            rate: BAUD,
            state: None,
            refusals: &Refusals::default(),
            board: &ValueBoard::default(),
        };
        let prepared = Spec::plain(device, PLACE).prepare().map_err(|wrong| unexpected(wrong.words))?;
        let station = prepared.make(&ground).map_err(unexpected)?;
        let product = station.appearance().product.into_owned();
        bus.add_any(station).map_err(unexpected)?;
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
            "profidrive demo: profirust as DP master {MASTER} and an emulated drive ({product}) as station {PLACE} \
             on a wire at {BAUD}, all in memory. Times are milliseconds on the bus."
        ))?;
        Ok(stage)
    }

    /// Plays what happens next.
    pub(super) fn play(&mut self, act: &SlaveAct) -> Result<(), Trouble> {
        match *act {
            SlaveAct::Title(title) => self.page.title(title),
            SlaveAct::Text(text) => self.page.text(text),
            SlaveAct::StartUp => self.start_up(),
            SlaveAct::Job { job, pnu, value, meaning, reply } => self.job(job, pnu, value, meaning, reply),
            SlaveAct::Reason(of_interest) => self.reason(of_interest),
            SlaveAct::Command(meaning, stw, setpoint, until) => self.command(meaning, stw, setpoint, until),
            SlaveAct::Observe(pattern) => self.observe(pattern),
            SlaveAct::Record => {
                self.recording = Some(Recording::default());
                self.sampled = Instant::ZERO;
                Ok(())
            }
            SlaveAct::Mark(name) => {
                let now = self.bus.now();
                if let Some(recording) = &mut self.recording {
                    recording.mark(now, name);
                }
                Ok(())
            }
            SlaveAct::Pass(time) => {
                self.run_for(time);
                Ok(())
            }
            SlaveAct::Draw => self.page.picture(&self.recording.take().unwrap_or_default().lines()),
            SlaveAct::Provoke(fault) => self
                .surround(|drive, now| drive.provoke(now, fault))?
                .map_err(|declined| Trouble::Unexpected(format!("{fault}: {declined:?}"))),
            SlaveAct::Repair => self.surround(|drive, now| drive.make_nominal(now)),
        }
    }

    /// Shows every telegram between master and drive until the drive's first inputs have come.
    fn start_up(&mut self) -> Result<(), Trouble> {
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
    fn job(
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
    fn command(
        &mut self,
        meaning: &str,
        stw: Stw,
        setpoint: i32,
        expected: ZswPattern,
    ) -> Result<(), Trouble> {
        let changes = words::commanded(MODE, self.stw.raw(), stw.raw());
        self.stw = stw;
        self.setpoint = setpoint;
        self.page.line(self.bus.now(), "STW", format_args!("{stw}  {meaning}: {changes}"))?;
        // The inputs answer the exchange before; with two cycles of the drive they are of these outputs.
        self.run_for(Duration::from_millis(5));
        self.observe(expected)
    }

    /// Waits until the status word shows what is expected, and says so.
    fn observe(&mut self, pattern: ZswPattern) -> Result<(), Trouble> {
        self.exchange(&format!("status {pattern}"), |inputs| pattern.matches(inputs.zsw()))?;
        let inputs = self.inputs()?;
        let (zsw, position) = (inputs.zsw(), inputs.hiw());
        let said = words::said(MODE, self.zsw.raw(), zsw.raw());
        self.zsw = zsw;
        self.page.line(self.bus.now(), "ZSW", format_args!("{zsw}  {said}; at {position}"))
    }

    /// Says the reason for what has just happened, which the drive reported as an event.
    fn reason(&mut self, of_interest: EventKind) -> Result<(), Trouble> {
        let found = core::iter::from_fn(|| self.events.pop_front()).find(|event| event.kind() == of_interest);
        let Some(event) = found else {
            return Err(Trouble::Unexpected("the drive gives no reason".into()));
        };
        self.page.line_without_time("why", format_args!("{event}"))
    }

    /// Changes what acts on the drive from outside.
    fn surround<R>(&mut self, act: impl FnOnce(&mut dyn Description, Instant) -> R) -> Result<R, Trouble> {
        let address = Address::station(PLACE).map_err(unexpected)?;
        let done = self.bus.with_description(address, act);
        done.ok_or_else(|| Trouble::Unexpected("the drive is gone".into()))
    }

    /// Lets time pass on the bus.
    fn run_for(&mut self, duration: Duration) {
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
    let ours = |address: u8| address == PLACE || address == Address::BROADCAST.number();
    explanation.kind == Kind::Telegram && [explanation.from, explanation.to].into_iter().flatten().any(ours)
}

/// Whether a telegram carries the inputs of the drive.
fn is_inputs(explanation: &Explanation) -> bool {
    let exchange =
        explanation.service == Some("Data_Exchange") && explanation.sender == Some(explain::Sender::Slave);
    exchange && explanation.fields.iter().any(|field| field.name == "ZSW")
}
