//! The ASDA-A2 on a bus of the test's own, and a clock that the test sets.

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::NmtState;
use profidrive::can_bus::cia402::{Mode, State};
use profidrive::devices::CanopenDevice;
use profidrive::devices::asda_a2::canopen::{AsdaA2, Quirks};
use profidrive::devices::asda_a2::{Config, Level, Servo};
use profidrive::time::Instant;

pub(crate) const NODE: u8 = 0x7F;

pub(crate) struct Rig {
    pub(crate) now: Instant,
    pub(crate) device: AsdaA2,
}

pub(crate) fn millis(millis: u64) -> Duration {
    Duration::from_millis(millis)
}

impl Rig {
    /// Node 7Fh, switched on, boot-up taken, PRE-OPERATIONAL.
    pub(crate) fn new(level: Level) -> Self {
        Self::with(Config { level, ..Config::new(NODE) }, Quirks::default())
    }

    pub(crate) fn full() -> Self {
        Self::new(Level::Full)
    }

    pub(crate) fn with(config: Config, quirks: Quirks) -> Self {
        let now = Instant::from_millis(1);
        let mut rig = Self { now, device: AsdaA2::new(config, quirks, now) };
        rig.device.power_on(now);
        assert_eq!(rig.drain(), ["77F#00"]);
        rig
    }

    pub(crate) fn servo(&self) -> &Servo {
        self.device.servo()
    }

    pub(crate) fn drain(&mut self) -> Vec<String> {
        std::iter::from_fn(|| self.device.poll_transmit(self.now)).map(|frame| frame.to_string()).collect()
    }

    pub(crate) fn data(&mut self, id: u16, octets: &[u8]) -> Vec<String> {
        let frame = Frame::data(Id::base(id).unwrap(), octets).unwrap();
        self.device.handle_frame(self.now, &frame);
        self.drain()
    }

    pub(crate) fn nmt(&mut self, command: u8) -> Vec<String> {
        self.data(0x000, &[command, NODE])
    }

    pub(crate) fn start(&mut self) -> Vec<String> {
        let seen = self.nmt(0x01);
        assert_eq!(self.device.node().state(), Some(NmtState::Operational));
        seen
    }

    pub(crate) fn sync(&mut self) -> Vec<String> {
        self.data(0x080, &[])
    }

    /// One SDO request and its answer.
    pub(crate) fn sdo(&mut self, request: [u8; 8]) -> [u8; 8] {
        let frame = Frame::with(Id::base(0x600 + u16::from(NODE)).unwrap(), request);
        self.device.handle_frame(self.now, &frame);
        let answers: Vec<Frame> = std::iter::from_fn(|| self.device.poll_transmit(self.now)).collect();
        let mut answers = answers.iter().filter(|frame| frame.id().number() == 0x580 + u32::from(NODE));
        let answer = answers.next().expect("an answer").octets().try_into().unwrap();
        assert!(answers.next().is_none());
        answer
    }

    /// Whether a request gets no answer.
    pub(crate) fn sdo_is_silent(&mut self) -> bool {
        self.data(0x600 + u16::from(NODE), &[0x40, 0, 0x10, 0, 0, 0, 0, 0]).is_empty()
    }

    /// Reads up to four octets.
    pub(crate) fn read(&mut self, index: u16, sub: u8) -> Result<u32, u32> {
        let [a, b] = index.to_le_bytes();
        let [command, _, _, _, data @ ..] = self.sdo([0x40, a, b, sub, 0, 0, 0, 0]);
        let data = u32::from_le_bytes(data);
        if command == 0x80 { Err(data) } else { Ok(data) }
    }

    /// A value with sign.
    pub(crate) fn signed(&mut self, index: u16) -> i32 {
        self.read(index, 0).unwrap().cast_signed()
    }

    /// Writes without saying a length.
    pub(crate) fn set(&mut self, index: u16, sub: u8, value: i64) {
        assert_eq!(self.write(index, sub, value), Ok(()), "{index:04X}h:{sub} := {value}");
    }

    pub(crate) fn write(&mut self, index: u16, sub: u8, value: i64) -> Result<(), u32> {
        self.write_with(0x22, index, sub, value as u32)
    }

    /// Writes `len` octets.
    pub(crate) fn write_len(&mut self, index: u16, sub: u8, value: u32, len: u8) -> Result<(), u32> {
        self.write_with(0x23 | (4 - len) << 2, index, sub, value)
    }

    fn write_with(&mut self, command: u8, index: u16, sub: u8, value: u32) -> Result<(), u32> {
        let [a, b] = index.to_le_bytes();
        let [d, e, f, g] = value.to_le_bytes();
        let [command, _, _, _, data @ ..] = self.sdo([command, a, b, sub, d, e, f, g]);
        match command {
            0x60 => Ok(()),
            0x80 => Err(u32::from_le_bytes(data)),
            _ => panic!("answer {command:02X}"),
        }
    }

    pub(crate) fn control(&mut self, word: u16) {
        self.set(0x6040, 0, word.into());
    }

    pub(crate) fn status(&mut self) -> u16 {
        self.read(0x6041, 0).unwrap() as u16
    }

    pub(crate) fn position(&mut self) -> i32 {
        self.signed(0x6064)
    }

    /// Servo on in a mode.
    pub(crate) fn enable(&mut self, mode: Mode) {
        self.set(0x6060, 0, mode.code().into());
        for word in [0x06, 0x07, 0x0F] {
            self.control(word);
        }
        assert_eq!(self.servo().state(), State::OperationEnabled);
    }

    /// Time passes; every deadline on the way is met. Frames with their time from the call in microseconds.
    pub(crate) fn pass(&mut self, time: Duration) -> Vec<(u64, String)> {
        let begin = self.now;
        let end = begin.saturating_add(time);
        let mut seen = Vec::new();
        while let Some(due) = self.device.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            self.device.handle_timeout(self.now);
            let at = u64::try_from(self.now.saturating_since(begin).as_micros()).unwrap();
            seen.extend(self.drain().into_iter().map(|frame| (at, frame)));
        }
        self.now = end;
        seen
    }

    /// Time passes until the statusword has these bits, at most so long; the frames on the way.
    pub(crate) fn until(&mut self, mask: u16, value: u16, most: Duration) -> Vec<String> {
        let mut seen = Vec::new();
        let end = self.now.saturating_add(most);
        while self.device.statusword().0 & mask != value {
            assert!(self.now < end, "statusword {:04X}h after {most:?}", self.device.statusword().0);
            seen.extend(self.pass(millis(1)).into_iter().map(|(_, frame)| frame));
        }
        seen
    }
}
