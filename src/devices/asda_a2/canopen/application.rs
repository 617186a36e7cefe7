//! The objects of the drive as the node asks for them, and what the bus does to the drive.

use heapless::Deque;

use super::links::Link;
use super::objects;
use crate::can_bus::canopen::{
    Abort, Address, Application, Emergency, ErrorNames, NmtCause, NmtState, NodeId, Notice, Object, Request,
    Reset, Rule, Source, Sub, Value, Written, dictionary,
};
use crate::can_bus::cia402::{Controlword, Mode, Statusword};
use crate::devices::asda_a2::{Alarm, Config, Digit, Event, Servo, Setting, stored};
use crate::time::Instant;

/// Requests that wait for the node; more are not taken.
const MAX_REQUESTS: usize = 16;

/// 1029h:1: no reaction.
const NO_CHANGE: i64 = 1;
/// 1029h:1: STOPPED.
const STOP: i64 = 2;

/// The drive with what the bus adds to it.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    pub(super) servo: Servo,
    state: NmtState,
    requests: Deque<Request, MAX_REQUESTS>,
    /// It has the parameters without effect.
    stored: bool,
    /// Digit Z of P3-01 as it was at the last start.
    rate_in_force: u8,
}

/// The bit rates by digit Z of P3-01.
pub(super) const RATES: [u32; 5] = [125_000, 250_000, 500_000, 750_000, 1_000_000];

impl Drive {
    pub(super) fn new(config: Config, stored: bool, now: Instant) -> Self {
        let servo = Servo::new(config, now);
        let rate_in_force = servo.settings().digit(Setting::Rates, Digit::Z);
        Self { servo, state: NmtState::PreOperational, requests: Deque::new(), stored, rate_in_force }
    }

    /// The bit rate since the last start; `None`: the digit has none.
    pub(super) fn bits_per_second(&self) -> Option<u32> {
        RATES.get(usize::from(self.rate_in_force)).copied()
    }

    pub(super) fn set_rate(&mut self, bits_per_second: u32) {
        let digit = (0_u8..).zip(RATES).find(|(_, rate)| *rate == bits_per_second);
        if let Some((digit, _)) = digit {
            let rates = self.servo.settings().of(Setting::Rates) & !0xF00 | i64::from(digit) << 8;
            self.servo.recall(Setting::Rates, rates);
            self.servo.set(Setting::Rates, rates);
            self.rate_in_force = digit;
        }
    }

    /// The objects of the level in force.
    pub(super) const fn table(&self) -> &'static [Object] {
        objects::of(self.servo.level(), self.stored)
    }

    fn link(&self, at: Address) -> Option<&'static Link> {
        Link::of(self.servo.level(), at)
    }

    /// The value of an entry that is no setting.
    fn actual(&self, at: Address) -> Option<Value<'static>> {
        let servo = &self.servo;
        Some(match at.pair() {
            (0x603F, 0) => Value::U16(servo.error_code()),
            (0x6040, 0) => Value::U16(servo.controlword().0),
            (0x6041, 0) => Value::U16(self.statusword().0),
            (0x6061, 0) => Value::I8(servo.mode().map_or(0, Mode::code)),
            (0x6062, 0) => Value::I32(servo.position_demand()),
            (0x6063, 0) => Value::I32(servo.position_actual_increments()),
            (0x6064, 0) => Value::I32(servo.position_actual()),
            (0x606B, 0) => Value::I32(servo.velocity_demand()),
            (0x606C, 0) => Value::I32(servo.velocity_actual()),
            (0x6074, 0) => Value::I16(servo.torque_demand()),
            (0x6075, 0) => Value::U32(servo.rated_current()),
            (0x6076, 0) => Value::U32(servo.rated_torque()),
            (0x6077, 0) | (0x6078, 0) => Value::I16(servo.torque_actual()),
            (0x60F4, 0) => Value::I32(servo.following_error_puu()),
            (0x60FC, 0) => Value::I32(servo.position_demand_increments()),
            (0x60FD, 0) => Value::U32(servo.digital_inputs()),
            (0.., 0..) => return None,
        })
    }

    /// The statusword; bit 9 says that the node is OPERATIONAL (CN-230).
    pub(super) fn statusword(&self) -> Statusword {
        self.servo.statusword() | Statusword::REMOTE.when(self.state == NmtState::Operational)
    }

    fn value(&self, at: Address, number: i64) -> Result<Value<'static>, Abort> {
        let data = dictionary::entry(self.table(), at)?.data;
        // A setting can be wider than an older name of it.
        let number = data.range().map_or(number, |(low, high)| number.clamp(low, high));
        Value::whole(data, number).ok_or(Abort::INTERNAL)
    }

    fn want(&mut self, request: Request) {
        let _ = self.requests.push_back(request);
    }

    /// Tells the node what happened in the drive.
    fn report(&mut self) {
        while let Some(event) = self.servo.poll_event() {
            match event {
                Event::Raised(alarm) => {
                    let emergency = emergency(alarm, self.servo.error_register());
                    self.want(Request::Emergency(emergency));
                }
                Event::Restarted => self.want(Request::ErrorRegister(0)),
                Event::Cleared(0) => self.want(Request::Emergency(Emergency::gone(0))),
                Event::Cleared(register) => self.want(Request::ErrorRegister(register)),
            }
        }
    }

    /// Guarding or heartbeat failed: AL170 or AL180, then 1029h:1.
    fn master_lost(&mut self) {
        let on = self.servo.is_on();
        self.servo.raise(if on { Alarm::GuardingServoOn } else { Alarm::GuardingServoOff });
        self.report();
        match self.servo.settings().of(Setting::ErrorBehaviour) {
            NO_CHANGE => {}
            STOP => self.want(Request::Nmt(NmtState::Stopped)),
            _ => {
                if self.state == NmtState::Operational {
                    self.want(Request::Nmt(NmtState::PreOperational));
                }
            }
        }
    }
}

impl Application for Drive {
    fn objects(&self) -> &'static [Object] {
        self.table()
    }

    fn node_id(&self) -> NodeId {
        let number = u8::try_from(self.servo.settings().of(Setting::NodeNumber)).unwrap_or_default();
        NodeId::new(number).unwrap_or(NodeId::MAX)
    }

    fn read(&self, at: Address) -> Result<Value<'_>, Abort> {
        // What PDOs carry comes first: it needs no table.
        if let Some(value) = self.actual(at) {
            return Ok(value);
        }
        let number = match (self.link(at), stored::place(at.pair())) {
            (Some(link), _) => link.read(self.servo.settings()),
            (None, Some(place)) => self.servo.settings().stored(place).into(),
            (None, None) => return Err(Abort::INTERNAL),
        };
        self.value(at, number)
    }

    fn write(
        &mut self,
        now: Instant,
        at: Address,
        value: Value<'_>,
        source: Source,
    ) -> Result<Written, Abort> {
        let number = value.number().ok_or(Abort::INTERNAL)?;
        if at == CONTROLWORD {
            self.servo.advance(now);
            self.servo.control(Controlword(u16::try_from(number).map_err(|_| Abort::INTERNAL)?));
            self.servo.look_at_target(source == Source::Sdo);
            return Ok(Written::Done);
        }
        if let Some(place) = stored::place(at.pair()) {
            let value = i32::try_from(number).map_err(|_| Abort::RANGE)?;
            match source {
                Source::Image => self.servo.recall_stored(place, value),
                Source::Sdo | Source::Rpdo(_) => self.servo.set_stored(place, value),
            }
            return Ok(Written::Done);
        }
        let link = self.link(at).ok_or(Abort::INTERNAL)?;
        if !link.accepts(self.servo.settings(), number) {
            return Err(Abort::RANGE);
        }
        match source {
            Source::Image => {
                let value = link.write(self.servo.kept(), number);
                self.servo.recall(link.setting, value);
            }
            Source::Sdo | Source::Rpdo(_) => {
                self.servo.advance(now);
                let value = link.write(self.servo.settings(), number);
                self.servo.set(link.setting, value);
            }
        }
        Ok(Written::Done)
    }

    fn error_names(&self) -> &'static ErrorNames {
        &super::vocabulary::ERRORS
    }

    fn rule(&self, at: Address, _value: Value<'_>) -> Option<Rule> {
        self.link(at)?.needs().map(Rule::But)
    }

    fn notice(&mut self, now: Instant, notice: Notice) {
        self.servo.advance(now);
        if let Notice::Reset(reset) = notice {
            // As the node number: after a reset of the communication that which was written last.
            let from = if reset == Reset::Communication { self.servo.settings() } else { self.servo.kept() };
            self.rate_in_force = from.digit(Setting::Rates, Digit::Z);
        }
        match notice {
            Notice::Reset(Reset::PowerOn) => self.servo.power_on(),
            Notice::Reset(Reset::Node) => self.servo.restart(),
            Notice::Reset(Reset::Communication) => {
                if self.servo.is_on() {
                    self.servo.raise(Alarm::NmtWhileOn);
                }
            }
            Notice::Nmt { to, cause, .. } => {
                self.state = to;
                if (to, cause) == (NmtState::Stopped, NmtCause::Master) && self.servo.is_on() {
                    self.servo.raise(Alarm::NmtWhileOn);
                }
            }
            Notice::Sync => self.servo.sync(now),
            Notice::RpdoRefused { abort, .. } => self.servo.raise(of_refusal(abort)),
            Notice::RpdoLength { .. } => self.servo.raise(Alarm::PdoLength),
            Notice::LifeGuardingExpired(_) | Notice::HeartbeatLost(_) => self.master_lost(),
            Notice::NotStored => self.servo.raise(Alarm::EepromWrite),
            Notice::RpdoTaken(_)
            | Notice::LifeGuardingBack
            | Notice::HeartbeatBack(_)
            | Notice::SyncMissing(_)
            | Notice::HistoryCleared => {}
        }
    }

    fn poll_request(&mut self) -> Option<Request> {
        self.report();
        self.requests.pop_front()
    }

    fn store(&mut self, _now: Instant, _group: Sub) -> Result<Written, Abort> {
        self.servo.store();
        Ok(Written::Done)
    }

    fn load_defaults(&mut self, _now: Instant, _group: Sub) -> Result<Written, Abort> {
        self.servo.restore();
        Ok(Written::Done)
    }

    // Of two names of one value the objects of CiA 402 come last in an image, and hold it without loss.
    fn product(&self) -> &str {
        "asda-a2"
    }

    fn kept(&self, at: Address) -> Result<Value<'_>, Abort> {
        if let Some(place) = stored::place(at.pair()) {
            // An image names those that were written.
            return match self.servo.kept().stored(place) {
                0 => Err(Abort::NO_DATA),
                number => self.value(at, number.into()),
            };
        }
        let link = self.link(at).ok_or(Abort::NO_DATA)?;
        self.value(at, link.read(self.servo.kept()))
    }
}

const CONTROLWORD: Address = Address::new(0x6040, 0);

/// ```text
/// octets 0..1 code   2 error register   3..4 number on the panel   5..7 zero
/// history: number << 16 | code
/// ```
fn emergency(alarm: Alarm, register: u8) -> Emergency {
    let [low, high] = alarm.number().to_le_bytes();
    Emergency {
        information: alarm.number(),
        octets: [low, high, 0, 0, 0],
        ..Emergency::new(alarm.code(), register)
    }
}

/// The alarm for a value of an RPDO that was refused.
fn of_refusal(abort: Abort) -> Alarm {
    match abort {
        Abort::NO_OBJECT => Alarm::PdoIndex,
        Abort::NO_SUB => Alarm::PdoSubIndex,
        Abort::LENGTH => Alarm::PdoLength,
        Abort::READ_ONLY => Alarm::PdoReadOnly,
        Abort::NOT_MAPPABLE => Alarm::PdoNotMappable,
        Abort::DEVICE_STATE => Alarm::PdoServoOn,
        _ => Alarm::PdoRange,
    }
}
