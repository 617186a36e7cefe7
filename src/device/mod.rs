//! One emulated drive as one object: octets and time in, octets and events out.
//!
//! The only place that knows every layer. It owns no clock, no port and no thread.
//!
//! **After every `handle_*` call, drain [`Device::poll_transmit`] and [`Device::poll_event`] to `None`, then wait
//! until octets arrive or [`Device::poll_timeout`] has come.** The crate guide shows the loop.
//!
//! A device is two machines, as the real one is. The *DP part* answers each telegram at once from buffers. The
//! *drive part* runs once per application cycle: it takes the newest outputs, runs the parameter channel, the
//! state machine and one fixed step of the motion, and offers new inputs. So a PKW reply never comes in the
//! exchange that brought its job. When nothing can change, the drive part sleeps and [`Device::poll_timeout`]
//! does not ask to be called for its sake; what happens is the same as if it had run.

mod event;
pub mod words;

use core::time::Duration;

use crate::dp::{self, Slave};
use crate::drive::{Drive, Inputs, Settings, Status};
use crate::fdl::{Address, FrameError, Framer, Reception, Resync, Station, Telegram};
use crate::param::{Effect, Gear, Live, Model, Store, WriteContext};
use crate::pkw::Engine;
use crate::ppo::{self, Outputs, PPO_LEN};
use crate::time::{BaudRate, Instant, nanos};

pub use crate::fdl::MAX_TELEGRAM_LEN;
pub use event::Event;

/// The ident number of both drives: the GSD is named `SIKO0AC5.GSD`.
pub const IDENT_NUMBER: u16 = 0x0AC5;

/// The configurations both drives accept: four and three words consistent, or seven words consistent. Which one
/// the real drive uses is not public (`ag03.md` 16).
pub const CONFIGURATIONS: &[&[u8]] = &[&[0xF3, 0xF2], &[0xF6]];

/// The rates the manual lists: all of PROFIBUS-DP without 45.45 kbit/s.
pub const BAUD_RATES: [BaudRate; 9] = [
    BaudRate::K9_6,
    BaudRate::K19_2,
    BaudRate::K93_75,
    BaudRate::K187_5,
    BaudRate::K500,
    BaudRate::K1500,
    BaudRate::K3000,
    BaudRate::K6000,
    BaudRate::K12000,
];

/// What both drives are to a DP master.
pub const DESCRIPTION: dp::Description = dp::Description {
    ident: IDENT_NUMBER,
    configurations: CONFIGURATIONS,
    user_prm_len: 0,
    sync_mode: true,
    freeze_mode: true,
};

/// A late device makes up for at most this much time; a process that slept longer has slept, not travelled.
const MOST_TIME_MADE_UP: Duration = Duration::from_secs(60);

/// What a device is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// Station address, 0..=126, as the DIP switches are set.
    pub address: Address,
    /// Which drive.
    pub model: Model,
    /// Which internal gear.
    pub gear: Gear,
    /// The rate of the line.
    pub baud: BaudRate,
    /// What can be known of the time of octets.
    pub timing: Timing,
    /// How often the drive part runs. Zero: once after each Data_Exchange, for tests that count exchanges.
    pub application_cycle: Duration,
    /// How many application cycles a PKW job takes beyond the first.
    pub pkw_latency: u16,
}

impl Config {
    /// An AG03/1 with gear 48:1 at `address`, on a line without true timing, with an application cycle of 1 ms.
    pub const fn new(address: Address) -> Self {
        Self {
            address,
            model: Model::Ag03_1,
            gear: Gear::Ratio48,
            baud: BaudRate::K500,
            timing: Timing::Untrue,
            application_cycle: Duration::from_millis(1),
            pkw_latency: 0,
        }
    }
}

/// What can be known of the time of octets on a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timing {
    /// Octets come when they come on the line: a simulated line or a UART. After rubbish the line must fall
    /// silent ([`Resync::Idle`]), and a reply is dropped once max T_SDR is over.
    True,
    /// Octets come when a scheduler delivers them: pseudo-terminal, TCP, USB adapter. Rubbish is skipped
    /// ([`Resync::SCAN`]), and a reply is sent however late, because the master's patience is set for such links.
    Untrue,
}

impl Timing {
    /// The rule for finding the next telegram on a line at `baud`.
    pub const fn resync(self, baud: BaudRate) -> Resync {
        match self {
            Self::True => Resync::Idle(baud),
            Self::Untrue => Resync::SCAN,
        }
    }
}

/// One emulated drive.
#[derive(Clone, Debug)]
pub struct Device {
    framer: Framer,
    part: Parts,
}

/// Everything behind the framer.
#[derive(Clone, Debug)]
struct Parts {
    config: Config,
    station: Station,
    slave: Slave,
    engine: Engine,
    store: Store,
    settings: Settings,
    drive: Drive,
    /// When the drive part runs next; `None` while nothing can change.
    next_cycle: Option<Instant>,
    /// The application cycles lie on a grid that starts here.
    power_on: Instant,
    /// The outputs the drive part has seen, as counted by the slave.
    outputs_seen: u32,
    events: event::Queue,
}

impl Device {
    /// A drive with factory settings, switched on at `now`.
    pub fn new(config: Config, now: Instant) -> Self {
        let store = Store::new(config.model, config.gear);
        let settings = Settings::read(&store);
        let max_tsdr = match config.timing {
            Timing::True => Some(config.baud.max_tsdr_bits()),
            Timing::Untrue => None,
        };
        let mut part = Parts {
            config,
            station: Station::new(config.address, config.baud, max_tsdr),
            slave: Slave::new(DESCRIPTION),
            engine: Engine::new(config.pkw_latency),
            store,
            drive: Drive::new(config.model, config.gear, &settings),
            settings,
            next_cycle: None,
            power_on: now,
            outputs_seen: 0,
            events: event::Queue::default(),
        };
        part.run_cycle();
        part.wake(now);
        Self { framer: Framer::new(config.timing.resync(config.baud)), part }
    }

    /// What the device was made of, with the rate of the line as it is now.
    pub const fn config(&self) -> &Config {
        &self.part.config
    }

    /// The state of the DP slave machine.
    pub const fn dp_state(&self) -> dp::State {
        self.part.slave.state()
    }

    /// The drive as the last application cycle left it.
    pub fn status(&self) -> Status {
        self.part.drive.status()
    }

    /// The stored parameters.
    pub const fn parameters(&self) -> &Store {
        &self.part.store
    }

    /// The line has another rate from now on.
    pub fn set_baud(&mut self, baud: BaudRate) {
        self.part.config.baud = baud;
        self.part.station.set_baud(baud);
        self.framer = Framer::new(self.part.config.timing.resync(baud));
    }

    /// Changes what acts on the drive from outside: supplies, keys, causes of faults. Counts as a `handle_*` call.
    pub fn set_inputs(&mut self, now: Instant, inputs: Inputs) {
        self.part.advance(now);
        self.part.drive.set_inputs(inputs);
        self.part.wake(now);
    }

    /// Takes octets, the last of which ended at `now`. They may be cut anywhere. Never panics, never blocks.
    pub fn handle_bytes(&mut self, now: Instant, octets: &[u8]) {
        let Self { framer, part } = self;
        part.advance(now);
        framer.receive(now, octets, |at, result| part.hear(at, result));
    }

    /// Takes one telegram whose last octet ended at `now`, for hosts that frame the octets of many devices once.
    pub fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>) {
        self.part.advance(now);
        self.part.hear(now, Ok(*telegram));
    }

    /// Time has passed. Spurious calls are harmless.
    pub fn handle_timeout(&mut self, now: Instant) {
        let Self { framer, part } = self;
        part.advance(now);
        framer.handle_timeout(now, |at, result| part.hear(at, result));
    }

    /// The other end of the line was replaced: an unfinished telegram is forgotten.
    pub fn handle_line_reset(&mut self) {
        self.framer.clear();
    }

    /// The telegram to send at `now`, written to `buf`, if its time has come.
    #[must_use = "the octets are not offered again"]
    pub fn poll_transmit<'b>(&mut self, now: Instant, buf: &'b mut [u8; MAX_TELEGRAM_LEN]) -> Option<&'b [u8]> {
        match self.part.station.poll_transmit(now) {
            Ok(octets) => {
                let octets = octets?;
                let out = buf.get_mut(..octets.len())?;
                out.copy_from_slice(octets);
                Some(out)
            }
            Err(too_late) => {
                self.part.events.push(Event::ReplyTooLate(too_late));
                None
            }
        }
    }

    /// When to call [`Device::handle_timeout`] and [`Device::poll_transmit`] again; `None` = octets come first.
    /// Changes with every `handle_*`, and with every `poll_transmit` that returned octets.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        let timeouts = [
            self.part.station.poll_timeout(),
            self.part.slave.poll_timeout(),
            self.part.next_cycle,
            self.framer.poll_timeout(),
        ];
        timeouts.into_iter().flatten().min()
    }

    /// The oldest event not taken yet. Changes with every `handle_*` and `poll_transmit`.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<Event> {
        self.part.events.pop()
    }
}

impl Parts {
    /// Lets everything happen that is due until `now`: application cycles and the watchdog, in the order of time.
    fn advance(&mut self, now: Instant) {
        self.forfeit_old_cycles(now);
        loop {
            let watchdog = self.slave.poll_timeout().filter(|due| *due <= now);
            match self.next_cycle.filter(|due| *due <= now) {
                Some(due) if watchdog.is_none_or(|watchdog| due < watchdog) => {
                    self.run_cycle();
                    self.next_cycle = (!self.is_at_rest()).then(|| due.saturating_add(self.config.application_cycle));
                }
                Some(_) | None => {
                    let Some(due) = watchdog else { return };
                    if let Some(event) = self.slave.handle_timeout(due) {
                        self.events.push(Event::Dp(event));
                    }
                    self.take_outputs(due);
                }
            }
        }
    }

    /// A telegram or a refusal from the line.
    fn hear(&mut self, now: Instant, result: Result<Telegram<'_>, FrameError>) {
        let telegram = match result {
            Ok(telegram) => telegram,
            Err(error) => return self.events.push(Event::TelegramRefused(error)),
        };
        match self.station.receive(now, &telegram) {
            Reception::Ignored => {}
            Reception::Answered { sa } | Reception::Repeated { sa } => self.slave.heard(now, sa),
            Reception::Data(request) => {
                if !request.da.is_broadcast() {
                    self.slave.heard(now, request.sa);
                }
                let event = self.slave.handle_sdn(&request);
                self.events.extend(event);
                self.take_outputs(now);
            }
            Reception::DataWithReply(request) => {
                self.slave.heard(now, request.sa);
                let handled = self.slave.handle_srd(now, &request);
                let (event, exchanged) = (handled.event, handled.exchanged);
                if let Some(reply) = handled.reply {
                    self.station.reply(now, &request, reply);
                }
                self.events.extend(event);
                if let Some(bits) = self.slave.min_tsdr() {
                    self.station.set_min_tsdr(bits);
                }
                self.take_outputs(now);
                if exchanged && self.config.application_cycle.is_zero() {
                    self.run_cycle();
                }
            }
        }
    }

    /// Wakes the drive part if outputs were passed on that it has not seen.
    fn take_outputs(&mut self, now: Instant) {
        let passed = self.slave.outputs_passed();
        if self.outputs_seen != passed {
            self.outputs_seen = passed;
            self.wake(now);
        }
    }

    /// The next point of the application cycle grid after `now`, unless one is set already.
    fn wake(&mut self, now: Instant) {
        let cycle = nanos(self.config.application_cycle);
        if cycle == 0 || self.next_cycle.is_some() {
            return;
        }
        let elapsed = nanos(now.saturating_since(self.power_on));
        let next = (elapsed / cycle + 1).saturating_mul(cycle);
        self.next_cycle = Some(self.power_on.saturating_add(Duration::from_nanos(next)));
    }

    /// One application cycle: newest outputs in, one fixed step, new inputs out.
    fn run_cycle(&mut self) {
        let outputs = self.exchanged_outputs();
        let command = outputs.map(|octets| {
            let outputs = Outputs::new(&octets);
            words::command(outputs.stw(), outputs.hsw())
        });
        let job = outputs.map(|octets| Outputs::new(&octets).pkw());
        self.run_job(job);
        self.drive.step(self.step(), command.as_ref(), &self.settings);
        self.report_drive();
        let status = self.drive.status();
        let inputs = ppo::Inputs::octets(self.engine.reply(), words::zsw(&status), words::hiw(&status));
        self.slave.set_inputs(&inputs);
    }
}
