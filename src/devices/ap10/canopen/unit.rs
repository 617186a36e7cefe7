//! Where objects meet the device: what each object of the dictionary reads and does.

use core::time::Duration;

use super::Quirks;
use super::objects::{Alarm, BATTERY_WARNING, OBJECTS, TOTAL_STEPS, TOTAL_STEPS_RANGE};
use super::vocabulary::ERRORS;
use crate::can_bus::canopen::application::MAX_BESIDE;
use crate::can_bus::canopen::dictionary;
use crate::can_bus::canopen::dictionary::{Limits, Object};
use crate::can_bus::canopen::{
    Abort, Address, Application, Emergency, ErrorNames, NmtState, NodeId, Notice, PdoNumber, Request, Reset,
    Rule, Source, Sub, Value, Written,
};
use crate::devices::ap10::{
    Backup, Battery, Control, Event, Fault, Indicator, RESOLUTION, Restore, Setting, Settings, Slot,
};
use crate::time::Instant;
use crate::untold::Untold;

/// Requests that wait for the node.
const MAX_REQUESTS: usize = 32;

/// From the answer of Auto-ID, or a code of the menu, to the initialisation: the answer has to leave first.
const RESTART_DELAY: Duration = Duration::from_millis(100);

/// Codes of EMCY (manual table 19).
pub(super) const ERROR_PASSIVE: u16 = 0x8120;
pub(super) const BUS_OFF_RECOVERED: u16 = 0x8140;

/// The code of a fault.
pub(super) const fn code(fault: Fault) -> u16 {
    match fault {
        Fault::BatteryCritical => 0xFF20,
        Fault::BatteryEmpty => 0x3200,
        Fault::Speed => 0xFF12,
    }
}

/// Bits of the error register; the node adds bit 0 while any is set.
const COMMUNICATION: u8 = 1 << 4;
const MANUFACTURER: u8 = 1 << 7;
const GENERIC: u8 = 1 << 0;

/// Groups of 1010h and 1011h.
const ALL: u8 = 1;
const BUS: u8 = 2;
const PROFILE: u8 = 3;
const MANUFACTURERS: u8 = 4;

/// The application of the node.
#[derive(Clone, Debug)]
pub(super) struct Unit {
    pub(super) indicator: Indicator,
    pub(super) quirks: Quirks,
    /// The parameters in the EEPROM.
    kept: Settings,
    /// The next restart takes factory values of these groups and leaves the EEPROM as it is (CN-110).
    load_pending: [bool; 3],
    requests: Untold<Request, MAX_REQUESTS>,
    operational: bool,
    /// When the silence of the master ends OPERATIONAL (5F09h).
    silence_ends: Option<Instant>,
    restart_due: Option<Instant>,
    error_passive: bool,
    /// 5F0Ah:3 as it was at the last start.
    rate_in_force: i32,
}

impl Unit {
    pub(super) fn new(node: NodeId, quirks: Quirks) -> Self {
        let mut kept = Settings::default();
        kept.set(Setting::NodeId, node.number().into());
        Self {
            indicator: Indicator::new(kept, quirks.indicator),
            quirks,
            kept,
            load_pending: [false; 3],
            requests: Untold::new(),
            operational: false,
            silence_ends: None,
            restart_due: None,
            error_passive: false,
            rate_in_force: 0,
        }
    }

    /// The bit rate since the last start; `None`: that of the bus.
    pub(super) fn bits_per_second(&self) -> Option<u32> {
        let place = usize::try_from(self.rate_in_force).ok()?.checked_sub(1)?;
        super::RATES.get(place).copied()
    }

    pub(super) fn set_rate(&mut self, bits_per_second: u32) {
        let code = (1..).zip(super::RATES).find(|(_, rate)| **rate == bits_per_second);
        if let Some((code, _)) = code {
            self.kept.set(Setting::BaudRate, code);
            self.indicator.set(Setting::BaudRate, code);
            self.rate_in_force = code;
        }
    }

    /// A parameter in the EEPROM.
    pub(super) fn kept_setting(&self, setting: Setting) -> i32 {
        self.kept.value(setting)
    }

    /// The supply fails: nobody is supervised and nothing waits any more.
    pub(super) fn power_off(&mut self) {
        self.operational = false;
        self.silence_ends = None;
        self.restart_due = None;
        self.indicator.offer_id(None);
    }

    /// Turns what happened at the device into requests of the node.
    pub(super) fn follow(&mut self, now: Instant) {
        while let Some(event) = self.indicator.poll_event() {
            match event {
                Event::FaultBegan(fault) => {
                    self.raise(code(fault), self.register());
                }
                Event::FaultEnded(_) => self.ask(Request::Emergency(Emergency::gone(self.register()))),
                Event::Calibrated => self.ask(Request::Store),
                Event::Chosen(setting) => {
                    self.kept.set(setting, self.indicator.settings().value(setting));
                    self.ask(Request::Store);
                }
                Event::AutoId(number) => {
                    self.indicator.set(Setting::NodeId, number.into());
                    self.kept.set(Setting::NodeId, number.into());
                    self.kept.set(Setting::AutoId, number.into());
                    self.ask(Request::Store);
                    self.ask(Request::AnswerSdo(Ok(())));
                    self.restart_due = Some(now.saturating_add(RESTART_DELAY));
                }
                Event::Restore(restore) => {
                    let groups: &[u8] = match restore {
                        Restore::All => &[ALL],
                        Restore::AllButBus => &[PROFILE, MANUFACTURERS],
                        Restore::Bus => &[BUS],
                    };
                    for group in groups {
                        self.ask(Request::LoadDefaults(Sub(*group)));
                    }
                    self.restart_due = Some(now.saturating_add(RESTART_DELAY));
                }
            }
        }
    }

    /// The CAN controller is error passive, or not any more.
    pub(super) fn set_error_passive(&mut self, passive: bool) {
        if self.error_passive != passive {
            self.error_passive = passive;
            if passive {
                self.raise(ERROR_PASSIVE, self.register());
            } else {
                self.ask(Request::Emergency(Emergency::gone(self.register())));
            }
        }
    }

    /// The CAN controller was off the bus and is back.
    pub(super) fn bus_off_recovered(&mut self) {
        self.raise(BUS_OFF_RECOVERED, self.register());
    }

    pub(super) fn handle_timeout(&mut self, now: Instant) {
        self.indicator.handle_timeout(now);
        if self.silence_ends.is_some_and(|due| due <= now) {
            self.silence_ends = None;
            self.ask(Request::Nmt(NmtState::PreOperational));
        }
        if self.restart_due.is_some_and(|due| due <= now) {
            self.restart_due = None;
            self.ask(Request::Reset(Reset::Node));
        }
        self.follow(now);
    }

    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        let due = Instant::first_of(self.silence_ends, self.restart_due);
        Instant::first_of(due, self.indicator.poll_timeout())
    }

    fn register(&self) -> u8 {
        let device = if self.indicator.has_fault() { MANUFACTURER } else { 0 };
        device | if self.error_passive { COMMUNICATION } else { 0 }
    }

    /// 1003h has the code in bits 0 to 15 and 1001h in bits 16 to 23 (CN-113).
    fn raise(&mut self, code: u16, register: u8) {
        let shown = if register == 0 { 0 } else { register | GENERIC };
        self.ask(Request::Emergency(Emergency {
            information: shown.into(),
            ..Emergency::new(code, register)
        }));
    }

    fn ask(&mut self, request: Request) {
        self.requests.push(request);
    }

    /// Parameters after a restart: those of the EEPROM, or factory values once.
    fn loaded(&mut self) -> Settings {
        let mut settings = self.kept;
        let pending = core::mem::take(&mut self.load_pending);
        if pending != [false; 3] {
            // Once: the next image does not say it any more.
            self.ask(Request::Store);
        }
        let [bus, profile, manufacturer] = pending;
        for (at, setting) in settings_of_dictionary() {
            let factory = match group_of_load(at) {
                BUS => bus,
                PROFILE => profile,
                0 | ALL | MANUFACTURERS.. => manufacturer,
            };
            if factory {
                settings.set(setting, setting.rule().default);
            }
        }
        settings
    }

    /// The supervision of the master begins without an event of it, unless it waits for the first (CN-130).
    fn expect(&mut self, now: Instant) {
        self.silence_ends = None;
        if !self.quirks.heartbeat_from_first {
            self.listen(now);
        }
    }

    /// The supervision of the master begins anew, or not at all.
    fn listen(&mut self, now: Instant) {
        let millis = self.indicator.settings().value(Setting::ExternalHeartbeatTime).unsigned_abs();
        let supervised = self.operational && millis != 0;
        self.silence_ends = supervised.then(|| now.saturating_add(Duration::from_millis(millis.into())));
    }

    fn heard(&mut self, now: Instant, by_sync: bool) {
        if self.indicator.settings().is_on(Setting::ExternalHeartbeatSource) == by_sync {
            self.listen(now);
        }
    }

    fn alarms(&self) -> u16 {
        let battery = match self.indicator.battery() {
            Battery::Good => 0,
            Battery::Critical => Alarm::BATTERY_CRITICAL,
            Battery::Empty => Alarm::BATTERY_CRITICAL | Alarm::BATTERY_EMPTY,
        };
        battery | if self.indicator.is_position_invalid() { Alarm::POSITION } else { 0 }
    }

    fn warnings(&self) -> u16 {
        match self.indicator.battery() {
            Battery::Good => 0,
            Battery::Critical | Battery::Empty => BATTERY_WARNING,
        }
    }

    /// 6002h: a constant, scaled as the position is (CN-122).
    fn total_steps(&self) -> i64 {
        let steps = i64::from(self.indicator.settings().value(Setting::StepsPerRevolution));
        let (low, high) = TOTAL_STEPS_RANGE;
        (i64::from(TOTAL_STEPS) * steps / i64::from(RESOLUTION)).clamp(low, high)
    }

    fn write_from_rpdo(&mut self, at: Address, number: i64) -> Result<Written, Abort> {
        let number = u32::try_from(number).map_err(|_| Abort::INTERNAL)?;
        let indicator = &mut self.indicator;
        match at.pair() {
            (0x5F16, 1) => indicator.set_low(Slot::Two, number),
            (0x5F16, 2) => indicator.set_high(Slot::Two, number),
            (0x5F16, 3) => indicator.set_low(Slot::One, number),
            (0x5F16, 4) => indicator.set_high(Slot::One, number),
            (0x5F0C, 0) => {
                indicator.set_control(Control(u16::try_from(number).map_err(|_| Abort::INTERNAL)?));
            }
            (0.., 0..) => return Err(Abort::NOT_MAPPABLE),
        }
        Ok(Written::Done)
    }

    fn write_from_image(&mut self, at: Address, number: i64) -> Result<Written, Abort> {
        let value = i32::try_from(number).map_err(|_| Abort::RANGE)?;
        match at.pair() {
            (0x2002, 0) => self.indicator.recall(self.indicator.zero(), value != 0),
            (0x6509, 0) => self.indicator.recall(value, self.indicator.is_calibrated()),
            (0.., 0..) => {
                if let Some(setting) = Setting::at(at.pair()) {
                    self.kept.set(setting, value);
                }
            }
        }
        Ok(Written::Done)
    }

    fn write_from_sdo(&mut self, now: Instant, at: Address, number: i64) -> Result<Written, Abort> {
        match at.pair() {
            (0x2002, 0) => {
                if number != 1 {
                    return Err(Abort::RANGE);
                }
                self.indicator.calibrate();
                self.follow(now);
                self.ask(Request::AnswerSdo(Ok(())));
                // The battery keeps it: answered when it is kept.
                Ok(Written::Held)
            }
            (0x5F0A, 2) => self.begin_auto_id(number),
            (0x6002, 0) => Ok(Written::Done),
            (index, _) => {
                let setting = Setting::at(at.pair()).ok_or(Abort::INTERNAL)?;
                let value = i32::try_from(number).map_err(|_| Abort::RANGE)?;
                if !self.indicator.set(setting, value) {
                    return Err(Abort::RANGE);
                }
                if index == 0x5F09 {
                    self.expect(now);
                }
                Ok(Written::Done)
            }
        }
    }

    /// The answer waits for the left key; an illegal number ends the function (manual 5.6.2).
    fn begin_auto_id(&mut self, number: i64) -> Result<Written, Abort> {
        let number = u8::try_from(number).ok().and_then(|number| NodeId::new(number).ok());
        self.indicator.offer_id(number.map(NodeId::number));
        let number = number.ok_or(Abort::RANGE)?;
        self.indicator.set(Setting::AutoId, number.number().into());
        Ok(Written::Held)
    }
}

impl Application for Unit {
    fn objects(&self) -> &'static [Object] {
        OBJECTS
    }

    fn error_names(&self) -> &'static ErrorNames {
        &ERRORS
    }

    fn node_id(&self) -> NodeId {
        let number = self.indicator.settings().value(Setting::NodeId);
        u8::try_from(number).ok().and_then(|number| NodeId::new(number).ok()).unwrap_or(NodeId::MAX)
    }

    fn read(&self, at: Address) -> Result<Value<'_>, Abort> {
        let indicator = &self.indicator;
        let number = match at.pair() {
            (0x100A, 0) => return Ok(Value::text(self.quirks.software_version.text())),
            (0x2002, 0) if indicator.is_calibrated() => 2,
            (0x2002, 0) => 0,
            (0x5F0C, 0) => indicator.control().0.into(),
            (0x5F0D, 1) => indicator.difference().into(),
            (0x5F16, 1) => indicator.set_point_low(Slot::Two).into(),
            (0x5F16, 2) => indicator.set_point_high(Slot::Two).into(),
            (0x5F16, 3) => indicator.set_point_low(Slot::One).into(),
            (0x5F16, 4) => indicator.set_point_high(Slot::One).into(),
            (0x5F19, 0) => indicator.status().0.into(),
            (0x6002, 0) => self.total_steps(),
            (0x6004, 0) => indicator.position().into(),
            (0x6500, 0) => indicator.settings().value(Setting::OperatingParameters).into(),
            (0x6503, 0) => self.alarms().into(),
            (0x6505, 0) => self.warnings().into(),
            (0x6509, 0) => indicator.zero().into(),
            (0.., 0..) => {
                let setting = Setting::at(at.pair()).ok_or(Abort::INTERNAL)?;
                indicator.settings().value(setting).into()
            }
        };
        Value::whole(dictionary::entry(OBJECTS, at)?.data, number).ok_or(Abort::INTERNAL)
    }

    fn write(
        &mut self,
        now: Instant,
        at: Address,
        value: Value<'_>,
        source: Source,
    ) -> Result<Written, Abort> {
        let number = value.number().ok_or(Abort::INTERNAL)?;
        match source {
            Source::Sdo => self.write_from_sdo(now, at, number),
            Source::Rpdo(_) => self.write_from_rpdo(at, number),
            Source::Image => self.write_from_image(at, number),
        }
    }

    fn rule(&self, at: Address, _value: Value<'_>) -> Option<Rule> {
        Some(Rule::Limits(match at.pair() {
            (0x2002, 0) => Limits::Range(1, 1),
            (0x5F0A, 2) => Limits::Range(NodeId::MIN.number().into(), NodeId::MAX.number().into()),
            (0.., 0..) => Limits::Ranges(Setting::at(at.pair())?.rule().ranges),
        }))
    }

    fn notice(&mut self, now: Instant, notice: Notice) {
        match notice {
            Notice::Reset(Reset::PowerOn | Reset::Node) => {
                self.restart_due = None;
                let settings = self.loaded();
                self.indicator.restart(settings);
                self.rate_in_force = settings.value(Setting::BaudRate);
                // What the battery kept is wrong from the beginning.
                self.ask(Request::ErrorRegister(self.register()));
            }
            // As the node number: that which was written last.
            Notice::Reset(Reset::Communication) => {
                self.indicator.offer_id(None);
                self.rate_in_force = self.indicator.settings().value(Setting::BaudRate);
            }
            Notice::Nmt { to, .. } => {
                self.operational = to == NmtState::Operational;
                self.expect(now);
            }
            Notice::Sync => self.heard(now, true),
            Notice::RpdoTaken(pdo) => {
                if let Some(slot) = slot_of(pdo) {
                    self.indicator.received(slot);
                    self.heard(now, false);
                }
            }
            // The two mapped entries take every value.
            Notice::RpdoRefused { .. } | Notice::RpdoLength { .. } => {}
            // The life time is a matter of the master (manual 5.5.2); there is no heartbeat consumer.
            Notice::LifeGuardingExpired(_) | Notice::LifeGuardingBack => {}
            Notice::HeartbeatLost(_) | Notice::HeartbeatBack(_) => {}
            // The values stay in effect and go into the next image.
            Notice::SyncMissing(_) | Notice::HistoryCleared | Notice::NotStored => {}
        }
    }

    fn poll_request(&mut self) -> Option<Request> {
        self.requests.pop()
    }

    fn store(&mut self, _now: Instant, group: Sub) -> Result<Written, Abort> {
        for (at, setting) in settings_of_dictionary() {
            let is_mode = setting == Setting::OperatingMode;
            if saved_by(group.0, at) && (self.quirks.keeps_mode || !is_mode) {
                self.kept.set(setting, self.indicator.settings().value(setting));
            }
        }
        Ok(Written::Done)
    }

    fn load_defaults(&mut self, _now: Instant, group: Sub) -> Result<Written, Abort> {
        let [bus, profile, manufacturer] = &mut self.load_pending;
        for (flag, own) in [(bus, BUS), (profile, PROFILE), (manufacturer, MANUFACTURERS)] {
            *flag |= group.0 == ALL || group.0 == own;
        }
        Ok(Written::Done)
    }

    fn complete_rtr_answer(&self, pdo: PdoNumber, octets: &mut [u8; 8]) {
        if let Some(slot) = slot_of(pdo) {
            let [.., low, high] = octets;
            [*low, *high] = self.indicator.status_of(slot).0.to_le_bytes();
        }
    }

    fn product(&self) -> &str {
        "ap10"
    }

    fn kept(&self, at: Address) -> Result<Value<'_>, Abort> {
        match Setting::at(at.pair()) {
            Some(setting) => {
                let number = self.kept.value(setting).into();
                Value::whole(dictionary::entry(OBJECTS, at)?.data, number).ok_or(Abort::INTERNAL)
            }
            None => self.read(at),
        }
    }

    /// ```text
    /// octets 0..9  what the battery keeps ([`Backup::octets`])
    /// octet  10    the next restart takes factory values of: bit 0 bus, 1 profile, 2 manufacturer parameters
    /// ```
    fn kept_beside(&self, into: &mut [u8; MAX_BESIDE]) -> usize {
        let [bus, profile, manufacturer] = self.load_pending;
        let pending = u8::from(bus) | u8::from(profile) << 1 | u8::from(manufacturer) << 2;
        let octets = self.indicator.backup().octets();
        for (to, octet) in into.iter_mut().zip(octets.into_iter().chain([pending])) {
            *to = octet;
        }
        Backup::LEN + 1
    }

    fn recall_beside(&mut self, octets: &[u8]) {
        if let Some((backup, [pending])) = octets.split_first_chunk() {
            self.indicator.restore(Backup::from_octets(*backup));
            self.load_pending = [pending & 1 != 0, pending & 2 != 0, pending & 4 != 0];
        }
    }
}

/// The set point that comes with an RPDO.
const fn slot_of(pdo: PdoNumber) -> Option<Slot> {
    match pdo.number() {
        1 => Some(Slot::One),
        2 => Some(Slot::Two),
        0 | 3.. => None,
    }
}

/// The parameters that 1010h keeps.
fn settings_of_dictionary() -> impl Iterator<Item = (Address, Setting)> {
    OBJECTS.iter().flat_map(|object| {
        object.entries.iter().filter(|entry| entry.stored).filter_map(|entry| {
            let at = Address { index: object.index, sub: entry.sub };
            Some((at, Setting::at(at.pair())?))
        })
    })
}

/// Whether 1010h:`group` keeps an entry: ranges of indices (CN-123).
const fn saved_by(group: u8, at: Address) -> bool {
    match (group, at.pair().0) {
        (ALL, _) | (PROFILE, 0x6000..=0x9FFF) | (MANUFACTURERS, 0x2000..=0x5FFF) => true,
        (0..=u8::MAX, _) => false,
    }
}

/// The group of 1011h that brings the factory value of an entry: bus parameters are those of manual table 9 (CN-123).
const fn group_of_load(at: Address) -> u8 {
    match at.pair().0 {
        0x5F09 | 0x5F0A => BUS,
        0x6000..=0x9FFF => PROFILE,
        0.. => MANUFACTURERS,
    }
}
