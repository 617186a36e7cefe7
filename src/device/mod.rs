//! One emulated drive as one object: octets and time in, octets and events out.
//!
//! The only place that knows every layer. It owns no clock, no port and no thread.
//!
//! **After every `handle_*` call, drain [`Device::poll_transmit`] and [`Device::poll_event`] to `None`, then wait
//! until octets arrive or [`Device::poll_timeout`] has come.** The crate guide shows the loop.
//!
//! A device is two machines, as the real one is. The *DP part* answers each telegram at once from buffers. The
//! *drive part* runs once per application cycle: it takes the newest outputs, runs the state machine, one fixed
//! step of the motion and the parameter channel, and offers new inputs. So a PKW reply never comes in the
//! exchange that brought its job. When nothing can change, the drive part sleeps and [`Device::poll_timeout`]
//! does not ask to be called for its sake; what happens is the same as if it had run.
//!
//! | file | holds |
//! | --- | --- |
//! | `config` | [`Config`]: what a device is made of |
//! | `words` | every bit of STW, ZSW, SSW and the general status register |
//! | `event` | [`Event`]: news for the host |
//! | `dip` | [`DipSwitches`]: address, factory reset, bus terminator |
//! | `power` | [`Power`]: switching off and on, row 1 of `ag03.md` 8 |
//! | [`ap10_canopen`] | the position indicator AP10 on CANopen, an object of its own |
//! | `storage` | [`Eeprom`]: images the host keeps, and the acknowledge that waits for them |

pub mod ap10_canopen;
mod config;
pub mod dip;
mod event;
mod power;
mod quirks;
mod storage;
pub mod words;

use core::time::Duration;

use crate::dp;
use crate::drive::{Drive, Inputs, Refusal, Settings, Status, StatusLed, leds};
use crate::fdl::{Address, FrameError, Framer, Telegram};
use crate::param::{Effect, Image, Live, ParamError, Parameter, Pnu, Store, Subindex, Value, WriteContext};
use crate::pkw::Engine;
use crate::ppo::{self, Outputs, PPO_LEN, Pkw, PpoType};
use crate::time::{BaudRate, Instant, nanos};

pub use crate::fdl::MAX_TELEGRAM_LEN;
pub use crate::param::{IMAGE_LEN, ImageError};
pub use config::{Config, DEFAULT_APPLICATION_CYCLE, Timing};
pub use dip::DipSwitches;
pub use event::Event;
pub use power::Power;
pub use quirks::{QUIRKS, Quirk, QuirkError};
pub use storage::{Eeprom, EepromState, Generation, NotStored, StoreRequest};

/// The ident number of both drives: the GSD is named `SIKO0AC5.GSD`.
pub const IDENT_NUMBER: u16 = 0x0AC5;

/// The configurations both drives accept: four and three words consistent, or seven words consistent. Which one
/// the real drive uses is not public (`ag03.md` 16).
pub const CONFIGURATIONS: &[&[u8]] = &[PpoType::Ag03.configuration(), &[0xF6]];

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
    sync_mode: true,
    freeze_mode: true,
    ..dp::Description::PLAIN
};

/// A late device makes up for at most this much time; a process that slept longer has slept, not travelled.
const MOST_TIME_MADE_UP: Duration = Duration::from_secs(60);

/// The LEDs of a drive (`ag03.md` 11).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Leds {
    /// The green status LED is lit.
    pub status: bool,
    /// What the status LED tells of the drive over time.
    pub pattern: StatusLed,
    /// The orange bus LED is lit: Data_Exchange.
    pub bus: bool,
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
    /// SW1 to SW7 as they were when it was switched on, but for a factory reset.
    address: Address,
    power: Power,
    /// The world around the drive as last set.
    inputs: Inputs,
    /// The control supply of the inputs reaches the drive.
    switch_closed: bool,
    station: dp::Station,
    engine: Engine,
    store: Store,
    settings: Settings,
    drive: Drive,
    /// When the drive part runs next; `None` while nothing can change.
    next_cycle: Option<Instant>,
    /// The application cycles lie on a grid that starts here.
    power_on: Instant,
    /// The outputs the drive part was woken for, as counted by the slave.
    outputs_seen: u32,
    /// The last application cycle ran in Data_Exchange.
    exchanging: bool,
    /// Data_Exchange was left since the last application cycle.
    interrupted: bool,
    /// The last application cycle wrote a parameter that the drive sees in the next one.
    parameters_acted: bool,
    /// The drive as the last application cycle left it.
    status: Status,
    /// The reply of the parameter channel offered to the master.
    pkw_reply: Pkw,
    storage: Option<storage::Storage>,
    events: event::Queue,
}

impl Device {
    /// A drive with factory settings, switched on at `now` with its shaft at 0.
    pub fn new(config: Config, now: Instant) -> Self {
        Self { framer: config.framer(), part: Parts::new(config, None, now) }
    }

    /// A drive as an image of its EEPROM says, switched on at `now`.
    ///
    /// # Errors
    /// [`ImageError`] if the octets are no whole image, or that of another model or gear.
    pub fn restore(config: Config, octets: &[u8], now: Instant) -> Result<Self, ImageError> {
        let image = Image::decode(octets, config.model, config.gear)?;
        Ok(Self { framer: config.framer(), part: Parts::new(config, Some(image), now) })
    }

    /// What the device was made of, with the rate of the line and the DIP switches as they are now.
    pub const fn config(&self) -> &Config {
        &self.part.config
    }

    /// Its station address, as the DIP switches were when it was switched on. A factory reset does not change it.
    pub const fn address(&self) -> Address {
        self.part.address
    }

    /// Whether it is switched on.
    pub const fn power(&self) -> Power {
        self.part.power
    }

    /// The world around the drive as last set, switched on or not.
    pub const fn inputs(&self) -> &Inputs {
        &self.part.inputs
    }

    /// The state of the DP slave machine; WAIT-PRM while switched off.
    pub const fn dp_state(&self) -> dp::State {
        self.part.station.slave().state()
    }

    /// The DP slave: owner, outputs, inputs, diagnosis.
    pub const fn slave(&self) -> &dp::Slave {
        self.part.station.slave()
    }

    /// The drive as the last application cycle left it.
    pub const fn status(&self) -> &Status {
        &self.part.status
    }

    /// The drive itself: its faults and their causes.
    pub const fn drive(&self) -> &Drive {
        &self.part.drive
    }

    /// What the drive reports through parameters that are only read.
    pub fn live(&self) -> Live {
        self.part.live()
    }

    /// What stands now against a start with the newest outputs (`ag03.md` 8 rows 20 to 22, 40); `None`: nothing.
    pub fn start_refusal(&self) -> Option<Refusal> {
        self.part.drive.start_refusal(&self.part.settings)
    }

    /// The LEDs at `now`; those of a factory reset alternate.
    pub fn leds(&self, now: Instant) -> Leds {
        let time = self.blink_time(now);
        match self.part.power {
            Power::Off => Leds { status: false, pattern: StatusLed::Off, bus: false },
            Power::On => Leds {
                status: self.part.status.led.is_lit(time),
                pattern: self.part.status.led,
                bus: self.dp_state() == dp::State::DataExch,
            },
            // Alternately, manual chapter 2.4.
            Power::FactoryReset(_) => {
                let half = time.as_nanos() / leds::BLINK_ON.as_nanos() % 2;
                Leds { status: half == 0, pattern: StatusLed::Off, bus: half == 1 }
            }
        }
    }

    /// The time that blinks count from, for [`StatusLed::is_lit`]: since the device was made.
    pub fn blink_time(&self, now: Instant) -> Duration {
        now.saturating_since(self.part.power_on)
    }

    /// The stored parameters.
    pub const fn parameters(&self) -> &Store {
        &self.part.store
    }

    /// Writes a parameter past the bus, by the rules of the bus: the drive cannot tell it from a PKW job, but no reply
    /// is sent, nothing waits for the EEPROM, and the master does not notice. Counts as a `handle_*` call.
    ///
    /// # Errors
    /// As [`Store::write`]; nothing is changed then.
    pub fn write_parameter(
        &mut self,
        now: Instant,
        pnu: Pnu,
        element: Option<Subindex>,
        value: Value,
    ) -> Result<(), ParamError> {
        self.part.advance(now);
        let context = self.part.write_context();
        let effect = self.part.store.write(pnu, element, value, &context)?;
        self.part.act(effect);
        self.part.note_changes();
        self.part.wake(now);
        Ok(())
    }

    /// The line has another rate from now on.
    pub fn set_baud(&mut self, baud: BaudRate) {
        self.part.config.baud = baud;
        self.part.station.set_baud(baud);
        self.framer = self.part.config.framer();
    }

    /// Takes octets, the last of which ended at `now`. They may be cut anywhere. Never panics, never blocks.
    pub fn handle_bytes(&mut self, now: Instant, octets: &[u8]) {
        let Self { framer, part } = self;
        part.advance(now);
        if !part.is_on_the_bus() {
            return;
        }
        // What a scan finds among octets whose rest did not come counts from now: for the drive part, time has passed.
        framer.receive(now, octets, |_, result| part.hear(now, result));
    }

    /// Takes one telegram whose last octet ended at `now`, for hosts that frame the octets of many devices once.
    pub fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>) {
        self.part.advance(now);
        if self.part.is_on_the_bus() {
            self.part.hear(now, Ok(*telegram));
        }
    }

    /// Time has passed. Spurious calls are harmless.
    pub fn handle_timeout(&mut self, now: Instant) {
        let Self { framer, part } = self;
        part.advance(now);
        framer.handle_timeout(now, |_, result| part.hear(now, result));
    }

    /// The other end of the line was replaced: an unfinished telegram is forgotten.
    pub fn handle_line_reset(&mut self) {
        self.framer.clear();
    }

    /// The telegram to send at `now`, written to `buf`, if its time has come.
    #[must_use = "the octets are not offered again"]
    pub fn poll_transmit<'b>(
        &mut self,
        now: Instant,
        buf: &'b mut [u8; MAX_TELEGRAM_LEN],
    ) -> Option<&'b [u8]> {
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
        let drive = Instant::first_of(self.part.station.poll_timeout(), self.part.next_cycle);
        Instant::first_of(drive, self.framer.poll_timeout())
    }

    /// Whether the DP watchdog minds the master (WD_On of Slave_Diag).
    pub fn watchdog_on(&self) -> bool {
        self.part.station.slave().watchdog_on()
    }

    /// The oldest event not taken yet. Changes with every `handle_*` and `poll_transmit`.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<Event> {
        self.part.events.pop()
    }
}

impl Parts {
    fn new(config: Config, kept: Option<Image>, now: Instant) -> Self {
        let fresh = kept.is_none();
        let mut image = kept.unwrap_or_else(|| Image::of_new(config.model, config.gear));
        image.store.set_quirks(config.param);
        let store = image.store.clone();
        let settings = Settings::read(&store);
        let mut drive = Drive::with(config.model, config.gear, &settings, config.drive);
        storage::recall(&mut drive, &image);
        let mut part = Self {
            config,
            address: config.switches.address(),
            power: Power::On,
            inputs: drive.inputs(),
            switch_closed: true,
            station: config.station(),
            engine: Engine::new(config.pkw),
            store,
            settings,
            status: drive.status(),
            drive,
            next_cycle: None,
            power_on: now,
            outputs_seen: 0,
            exchanging: false,
            interrupted: false,
            parameters_acted: false,
            pkw_reply: Pkw::ZERO,
            storage: storage::Storage::new(config.eeprom, image, fresh),
            events: event::Queue::default(),
        };
        part.read_switches();
        part.run_cycle(config.step());
        part.wake(now);
        part
    }

    /// Lets everything happen that is due until `now`: application cycles and the watchdog, in the order of time.
    fn advance(&mut self, now: Instant) {
        self.forfeit_old_cycles(now);
        loop {
            let watchdog = self.station.watchdog_timeout().filter(|due| *due <= now);
            let cycle = self.next_cycle.filter(|due| *due <= now);
            match (cycle, watchdog) {
                (Some(cycle), Some(watchdog)) if watchdog <= cycle => self.expire_watchdog(watchdog),
                (Some(cycle), Some(_) | None) => {
                    self.next_cycle = None;
                    self.run_cycle(self.config.step());
                    if !self.is_at_rest() {
                        self.next_cycle = Some(cycle.saturating_add(self.config.application_cycle));
                    }
                }
                (None, Some(watchdog)) => self.expire_watchdog(watchdog),
                (None, None) => return,
            }
        }
    }

    /// Moves a cycle that is overdue beyond all measure up to the time that is made up for.
    fn forfeit_old_cycles(&mut self, now: Instant) {
        let overdue = self.next_cycle.map(|due| now.saturating_since(due));
        if overdue.is_some_and(|overdue| overdue > MOST_TIME_MADE_UP) {
            self.next_cycle = None;
            self.wake(Instant::from_nanos(now.as_nanos().saturating_sub(nanos(MOST_TIME_MADE_UP))));
        }
    }

    fn expire_watchdog(&mut self, due: Instant) {
        if let Some(event) = self.station.handle_timeout(due) {
            self.events.push(Event::Dp(event));
        }
        self.outputs_passed(due);
    }

    /// A telegram or a refusal from the line.
    fn hear(&mut self, now: Instant, result: Result<Telegram<'_>, FrameError>) {
        let telegram = match result {
            Ok(telegram) => telegram,
            Err(error) => return self.events.push(Event::TelegramRefused(error)),
        };
        let outcome = self.station.receive(now, &telegram);
        if let Some(event) = outcome.event {
            self.events.push(Event::Dp(event));
        }
        self.outputs_passed(now);
        if outcome.exchanged && self.config.application_cycle.is_zero() {
            self.run_cycle(self.config.step());
        }
    }

    /// Wakes the drive part if outputs were passed that it has not seen.
    fn outputs_passed(&mut self, now: Instant) {
        let passed = self.station.slave().outputs_passed();
        if self.outputs_seen == passed {
            return;
        }
        self.outputs_seen = passed;
        if self.exchanging && self.station.slave().state() != dp::State::DataExch {
            self.exchanging = false;
            self.interrupted = true;
            if self.config.application_cycle.is_zero() {
                self.run_cycle(self.config.step());
            }
        }
        self.wake(now);
    }

    /// Sets the next point of the application cycle grid after `now`, unless one is set already.
    fn wake(&mut self, now: Instant) {
        let cycle = nanos(self.config.application_cycle);
        if self.next_cycle.is_some() || cycle == 0 {
            return;
        }
        let elapsed = nanos(now.saturating_since(self.power_on));
        let next = (elapsed / cycle + 1).saturating_mul(cycle);
        self.next_cycle = Some(self.power_on.saturating_add(Duration::from_nanos(next)));
    }

    /// One application cycle: newest outputs in, one step of this length, new inputs out.
    fn run_cycle(&mut self, step: Duration) {
        // A break in Data_Exchange is seen for one cycle even if it was shorter.
        self.exchanging = self.station.slave().state() == dp::State::DataExch && !self.interrupted;
        self.interrupted = false;
        let octets =
            self.station.slave().outputs().first_chunk::<PPO_LEN>().copied().filter(|_| self.exchanging);
        let outputs = octets.as_ref().map(Outputs::new);

        let command = outputs.map(|outputs| self.config.words.command(outputs.stw(), outputs.hsw()));
        let fault = self.status.fault;
        self.drive.step(step, command.as_ref(), &self.settings);
        self.status = self.drive.status();
        // Behind the step, so that a parameter that shows the drive agrees with ZSW and HIW.
        self.pkw_reply = self.run_job(outputs.map(Outputs::pkw));
        self.note_changes();

        if let Some(refusal) = self.drive.take_refusal() {
            self.events.push(Event::CommandRefused(refusal));
        }
        if let Some(fault) = self.status.fault.filter(|_| fault.is_none()) {
            self.events.push(Event::Fault(fault));
        }
        let inputs = ppo::Inputs::octets(
            self.pkw_reply,
            self.config.words.zsw(&self.status),
            words::hiw(&self.status),
        );
        self.station.set_inputs(&inputs);
    }

    /// Runs the parameter channel; `None` outside Data_Exchange.
    fn run_job(&mut self, job: Option<Pkw>) -> Pkw {
        self.parameters_acted = false;
        let Some(job) = job else {
            self.engine.reset();
            return Pkw::ZERO;
        };
        // Most cycles only hold the reply.
        if !self.engine.may_read(job) {
            return self.pkw_reply;
        }
        let live = self.live();
        let context = self.write_context();
        // Only a job that runs now can write; a held one must not cost a copy of everything in each cycle.
        let may_write = self.storage.is_some() && self.engine.has_work(job);
        let before = may_write.then(|| self.image());
        let outcome = self.engine.cycle(job, &mut self.store, &live, &context);
        self.act(outcome.effect);
        if let Some(refusal) = outcome.refusal {
            self.events.push(Event::JobRefused(refusal));
        }
        if let Some(before) = before.filter(|_| outcome.stores)
            && self.must_be_stored(before)
        {
            self.engine.hold(self.pkw_reply);
            return self.pkw_reply;
        }
        outcome.reply
    }

    /// Lets the drive follow what was written to a parameter.
    #[inline]
    fn act(&mut self, effect: Effect) {
        match effect {
            Effect::None => {}
            Effect::SettingsChanged => self.settings = Settings::read(&self.store),
            Effect::ClearFaults => self.drive.clear_faults(),
            // Not during a travel job: the store has refused it by the same status.
            Effect::Calibrate => {
                let _refused = self.drive.calibrate(self.store.value(Parameter::CalibrationValue));
            }
        }
        self.parameters_acted = effect != Effect::None;
        if self.parameters_acted {
            self.status = self.drive.status();
        }
    }

    /// Whether another application cycle with the same outputs would change nothing.
    fn is_at_rest(&self) -> bool {
        if !self.drive.is_at_rest() {
            return false;
        }
        let job = self.station.slave().outputs().first_chunk().map(|outputs| Outputs::new(outputs).pkw());
        let job_waits = self.exchanging && job.is_some_and(|job| self.engine.has_work(job));
        let exchanging = self.station.slave().state() == dp::State::DataExch;
        !self.parameters_acted && !job_waits && self.exchanging == exchanging
    }

    const fn write_context(&self) -> WriteContext {
        WriteContext { moving: self.status.moving, job_active: self.status.job_active }
    }

    /// What the drive reports through parameters that are only read.
    fn live(&self) -> Live {
        let faults = self.drive.faults();
        let measured = self.drive.measured();
        Live {
            address: self.address.number(),
            fault_buffer: self.drive.fault_codes(),
            fault_count: faults.count(),
            system_status: words::system_status(&self.status),
            temperature: measured.temperature,
            motor_current: measured.current,
            general_status: words::general_status(&self.status),
            position: self.status.position,
            output_stage_voltage: measured.output_supply,
            control_voltage: measured.control_supply,
            battery_voltage: measured.battery,
        }
    }
}
