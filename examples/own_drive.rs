//! A drive of one's own on PROFIBUS: own ident number, PPO type 1, own parameters, the parameter channel of this crate.
//!
//! `cargo run --example own_drive -- PATH` serves a pseudo-terminal at PATH; `own_drive.gsd` is its GSD.

use profidrive::devices::{PlainStation, SlaveDevice};
use profidrive::face::Description;
use profidrive::face::description::{self, Amount, Curve, Group};
use profidrive::face::surroundings::{Input, InputKind, Level, Surroundings};
use profidrive::host::link::pty::Pty;
use profidrive::host::{self, Bus, Stop, SystemClock};
use profidrive::profibus::dp::{self, Fixed};
use profidrive::profibus::fdl::Address;
use profidrive::profibus::pkw::{Config, Engine, JobError, Parameters, Value, Written};
use profidrive::profibus::ppo::{Pkw, PpoType};
use profidrive::time::{BaudRate, Instant};

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
    channel: Engine,
    table: Table,
    actual: i16,
    locked: bool,
}

impl OwnDrive {
    pub(crate) fn station(address: Address) -> PlainStation<Self> {
        let table = Table { ramp: 10, speeds: [100, 200, 300] };
        let drive = Self { channel: Engine::new(Config::default()), table, actual: 0, locked: false };
        PlainStation::new(address, BaudRate::K500, OWN, PPO_1, drive)
    }
}

/// The application: the parameter channel, ZSW and actual value as commanded by STW and setpoint.
impl SlaveDevice for OwnDrive {
    fn product(&self) -> (&'static str, &str) {
        ("own-drive", "Own drive")
    }

    fn exchange(&mut self, _: Instant, outputs: &[u8], inputs: &mut [u8]) {
        let (Some((job, [stw @ .., high, low])), Some((reply, [zsw @ .., actual_high, actual_low]))) =
            (outputs.split_first_chunk(), inputs.split_first_chunk_mut())
        else {
            return;
        };
        *reply = self.channel.cycle(Pkw::from_octets(*job), &mut self.table).reply.to_octets();
        zsw.copy_from_slice(stw);
        self.actual = if self.locked { 0 } else { i16::from_be_bytes([*high, *low]) };
        [*actual_high, *actual_low] = self.actual.to_be_bytes();
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
        // 4000h is 100 %.
        let speed = Amount::Number(f64::from(self.actual) * 100.0 / 16384.0);
        let speed = description::Value::new("speed", "speed", Group::Motion, speed);
        tell(speed.unit("%").curve(Curve::Own).headline());
    }
}

#[allow(dead_code, reason = "a test includes this file")]
fn main() -> Result<(), Box<dyn core::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: own_drive PATH")?;
    let (mut bus, mut pty) = (Bus::new(), Pty::open(Some(path.as_ref()))?);
    bus.add(OwnDrive::station(Address::station(5)?))?;
    println!("ready link={path} stations=5");
    let mut log = |event| eprintln!("{event}");
    Ok(host::run(&mut pty, &mut bus, &SystemClock::new(), &Stop::new()?, &mut log)?)
}
