//! A drive of one's own on PROFIBUS: own ident number, PPO type 1, own parameters, the parameter channel of this crate.
//!
//! `cargo run --example own_drive -- PATH` serves a pseudo-terminal at PATH; `own_drive.gsd` is its GSD.

use profidrive::devices::StationEvent;
use profidrive::face::Description;
use profidrive::face::description::{self, Amount, Curve, Group};
use profidrive::face::surroundings::{Input, InputKind, Level, Surroundings};
use profidrive::host::link::pty::Pty;
use profidrive::host::{self, Bus, Participant, Stop, SystemClock};
use profidrive::profibus::dp::{self, Fixed, Station};
use profidrive::profibus::fdl::MAX_TELEGRAM_LEN;
use profidrive::profibus::fdl::{Address, Telegram};
use profidrive::profibus::pkw::{Config, Engine, JobError, Parameters, Value, Written};
use profidrive::profibus::ppo::{Pkw, PpoType};
use profidrive::time::{BaudRate, Instant};

type Buffer = [u8; MAX_TELEGRAM_LEN];
type News<'a> = &'a mut dyn FnMut(StationEvent);

const OWN: dp::Description = dp::Description { ident: 0x4F44, ..dp::Description::PLAIN };
const PPO_1: Fixed<'static> = Fixed { configurations: &[PpoType::Ppo1.configuration()], ..Fixed::PLAIN };

/// PNU 100: ramp time in s, 1 to 60. PNU 200: three fixed speeds in rpm.
struct Table {
    ramp: u16,
    speeds: [u32; 3],
}

impl Parameters for Table {
    fn elements(&self, pnu: u16) -> Result<Option<u8>, JobError> {
        match pnu {
            100 => Ok(None),
            200 => Ok(Some(3)),
            got => Err(JobError::UnknownParameter { got }),
        }
    }

    fn read(&self, pnu: u16, element: Option<u8>) -> Result<Value, JobError> {
        match (self.elements(pnu)?, element) {
            (None, Some(_)) => Err(JobError::NotAnArray),
            (Some(count), None) => Err(JobError::IsArray { count }),
            (Some(count), Some(got)) => match self.speeds.get(usize::from(got)) {
                Some(speed) => Ok(Value::Double(*speed)),
                None => Err(JobError::SubindexOutOfRange { count, got }),
            },
            (None, None) => Ok(Value::Word(self.ramp)),
        }
    }

    fn write(&mut self, pnu: u16, element: Option<u8>, value: Value) -> Result<Written, JobError> {
        let (expected, got) = (self.read(pnu, element)?.width(), value.width());
        match (pnu, value) {
            (100, Value::Word(ramp @ 1..=60)) => self.ramp = ramp,
            (100, Value::Word(got)) => {
                return Err(JobError::OutOfRange { low: 1, high: 60, got: got.into() });
            }
            (200, Value::Double(new)) => {
                let own = self.speeds.get_mut(usize::from(element.unwrap_or(0)));
                own.into_iter().for_each(|speed| *speed = new);
            }
            _other_width => return Err(JobError::WrongWidth { expected, got }),
        }
        Ok(Written::at_once(value))
    }
}

/// Somebody holds the shaft.
const LOCKED: Input =
    Input { name: "locked", about: "the shaft is held; the speed is 0", kind: InputKind::Switch };

pub(crate) struct OwnDrive {
    station: Station,
    channel: Engine,
    table: Table,
    locked: bool,
}

impl OwnDrive {
    pub(crate) fn new(address: Address) -> Self {
        let station = Station::new(address, BaudRate::K500, None, OWN, PPO_1);
        let table = Table { ramp: 10, speeds: [100, 200, 300] };
        Self { station, channel: Engine::new(Config::default()), table, locked: false }
    }

    /// The application: the parameter channel, ZSW and actual value as commanded by STW and setpoint.
    fn cycle(&mut self) {
        let Some((pkw, [stw_high, stw_low, setpoint @ ..])) =
            self.station.slave().outputs().split_first_chunk()
        else {
            return;
        };
        let reply = self.channel.cycle(Pkw::from_octets(*pkw), &mut self.table).reply;
        let actual: &[u8] = if self.locked { &[0, 0] } else { setpoint };
        self.station.set_inputs(&[&reply.to_octets()[..], &[*stw_high, *stw_low], actual].concat());
    }

    /// The actual value in percent: 4000h is 100 %.
    fn speed(&self) -> Option<f64> {
        let actual = self.station.slave().inputs().last_chunk()?;
        Some(f64::from(i16::from_be_bytes(*actual)) * 100.0 / 16384.0)
    }
}

impl Surroundings for OwnDrive {
    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        tell(&LOCKED, Level::Switch(self.locked));
    }

    fn set_input(&mut self, _: Instant, name: &str, level: Level) {
        if let (true, Level::Switch(locked)) = (name == LOCKED.name, level) {
            self.locked = locked;
        }
    }

    fn make_nominal(&mut self, _: Instant) {
        self.locked = false;
    }
}

impl Description for OwnDrive {
    fn each_value(&self, tell: &mut dyn FnMut(description::Value<'_>)) {
        let speed = description::Value::new("speed", "speed", Group::Motion, Amount::from(self.speed()));
        tell(speed.unit("%").curve(Curve::Own).headline());
    }
}

impl Participant for OwnDrive {
    fn address(&self) -> Address {
        self.station.address()
    }
    fn set_baud(&mut self, baud: BaudRate) {
        self.station.set_baud(baud);
    }
    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: News<'_>) {
        Participant::handle_telegram(&mut self.station, now, telegram, news);
        self.cycle();
    }
    fn handle_timeout(&mut self, now: Instant, news: News<'_>) {
        Participant::handle_timeout(&mut self.station, now, news);
    }
    fn poll_transmit(&mut self, now: Instant, buf: &mut Buffer, news: News<'_>) -> Option<usize> {
        Participant::poll_transmit(&mut self.station, now, buf, news)
    }
    fn poll_timeout(&self) -> Option<Instant> {
        self.station.poll_timeout()
    }
    fn watchdog_on(&self) -> bool {
        self.station.slave().watchdog_on()
    }
    fn description(&self) -> Option<&dyn Description> {
        Some(self)
    }
    fn description_mut(&mut self) -> Option<&mut dyn Description> {
        Some(self)
    }
}

#[allow(dead_code, reason = "a test includes this file")]
fn main() -> Result<(), Box<dyn core::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: own_drive PATH")?;
    let (mut bus, mut pty) = (Bus::new(), Pty::open(Some(path.as_ref()))?);
    bus.add(OwnDrive::new(Address::station(5)?))?;
    println!("ready link={path} stations=5");
    let mut log = |event| eprintln!("{event}");
    Ok(host::run(&mut pty, &mut bus, &SystemClock::new(), &Stop::new()?, &mut log)?)
}
