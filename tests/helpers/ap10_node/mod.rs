//! One AP10 on a bus of the test's own: frames, keys and turns in, frames out, and a clock that the test sets.

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::can_bus::canopen::{NmtState, NodeId};
use profidrive::devices::CanopenDevice;
use profidrive::devices::ap10::canopen::{Ap10, Config, Quirks};
use profidrive::devices::ap10::{Display, Key, Turns};
use profidrive::time::Instant;

pub(crate) struct Rig {
    pub(crate) now: Instant,
    pub(crate) device: Ap10,
}

impl Rig {
    /// Switched on, boot-up taken.
    pub(crate) fn new(node: u8) -> Self {
        Self::with(node, Quirks::DEFAULT)
    }

    pub(crate) fn with(node: u8, quirks: Quirks) -> Self {
        let config = Config { quirks, ..Config::new(NodeId::new(node).unwrap()) };
        let mut rig = Self { now: Instant::from_millis(1), device: Ap10::new(config) };
        assert_eq!(rig.power_on(), [format!("{:03X}#00", 0x700 + u16::from(node))]);
        rig
    }

    /// With an EEPROM of the host.
    pub(crate) fn hosted(node: u8) -> Self {
        let config = Config { memory: Eeprom::Host, ..Config::new(NodeId::new(node).unwrap()) };
        let mut rig = Self { now: Instant::from_millis(1), device: Ap10::new(config) };
        rig.power_on();
        rig
    }

    /// The factory's node 125 in OPERATIONAL.
    pub(crate) fn operational() -> Self {
        let mut rig = Self::new(125);
        rig.start();
        rig
    }

    pub(crate) fn start(&mut self) {
        assert_eq!(self.data(0x000, &[0x01, 0x00]), [""; 0]);
        assert_eq!(self.device.node().state(), Some(NmtState::Operational));
    }

    pub(crate) fn power_on(&mut self) -> Vec<String> {
        self.device.power_on(self.now);
        self.drain()
    }

    pub(crate) fn power_cycle(&mut self) -> Vec<String> {
        self.device.power_off(self.now);
        self.power_on()
    }

    pub(crate) fn data(&mut self, id: u16, octets: &[u8]) -> Vec<String> {
        self.frame(&Frame::data(Id::base(id).unwrap(), octets).unwrap())
    }

    pub(crate) fn remote(&mut self, id: u16) -> Vec<String> {
        self.frame(&Frame::remote(Id::base(id).unwrap(), 8).unwrap())
    }

    pub(crate) fn frame(&mut self, frame: &Frame) -> Vec<String> {
        self.device.handle_frame(self.now, frame);
        self.drain()
    }

    /// RPDO1 of node 125: a number and the control word.
    pub(crate) fn set_point_1(&mut self, number: i32, control: u16) {
        self.set_point(0x27D, number, control);
    }

    pub(crate) fn set_point_2(&mut self, number: i32, control: u16) {
        self.set_point(0x37D, number, control);
    }

    fn set_point(&mut self, id: u16, number: i32, control: u16) {
        let [a, b, c, d] = number.to_le_bytes();
        let [low, high] = control.to_le_bytes();
        assert_eq!(self.data(id, &[a, b, c, d, 0, 0, low, high]), [""; 0]);
    }

    /// Turns the shaft to that many steps of the sensor.
    pub(crate) fn steps(&mut self, steps: i32) {
        self.turns(f64::from(steps) / 880.0);
    }

    pub(crate) fn turns(&mut self, turns: f64) {
        self.device.turn_to(self.now, Turns::from_revolutions(turns));
    }

    /// Down and up again; what is sent.
    pub(crate) fn tap(&mut self, key: Key) -> Vec<String> {
        self.device.press(self.now, key);
        self.device.release(self.now, key);
        self.drain()
    }

    pub(crate) fn display(&self) -> Display {
        self.device.display()
    }

    /// The two rows.
    pub(crate) fn rows(&self) -> [String; 2] {
        self.display().rows.map(|row| row.text().to_owned())
    }

    pub(crate) fn leds(&self) -> String {
        self.display().leds.to_string()
    }

    pub(crate) fn status(&mut self) -> u16 {
        u16::try_from(self.read(0x5F19, 0).unwrap()).unwrap()
    }

    pub(crate) fn position(&mut self) -> i32 {
        self.read(0x6004, 0).unwrap().cast_signed()
    }

    /// One SDO request and what follows it.
    pub(crate) fn sdo(&mut self, request: [u8; 8]) -> Vec<String> {
        let id = 0x600 + u16::from(self.device.node().node_id().number());
        self.data(id, &request)
    }

    /// Reads an entry: the octets that count, as a number.
    pub(crate) fn read(&mut self, index: u16, sub: u8) -> Result<u32, u32> {
        let [a, b] = index.to_le_bytes();
        let [command, _, _, _, data @ ..] = self.answer([0x40, a, b, sub, 0, 0, 0, 0]);
        let data = u32::from_le_bytes(data);
        if command == 0x80 { Err(data) } else { Ok(data) }
    }

    pub(crate) fn write(&mut self, index: u16, sub: u8, value: u32, len: u8) -> Result<(), u32> {
        let [a, b] = index.to_le_bytes();
        let [d, e, f, g] = value.to_le_bytes();
        let [command, ra, rb, rsub, data @ ..] = self.answer([0x23 | (4 - len) << 2, a, b, sub, d, e, f, g]);
        assert_eq!([ra, rb, rsub], [a, b, sub]);
        if command == 0x60 { Ok(()) } else { Err(u32::from_le_bytes(data)) }
    }

    pub(crate) fn save(&mut self, group: u8) {
        assert_eq!(self.write(0x1010, group, 0x6576_6173, 4), Ok(()));
    }

    pub(crate) fn load(&mut self, group: u8) {
        assert_eq!(self.write(0x1011, group, 0x6461_6F6C, 4), Ok(()));
    }

    fn answer(&mut self, request: [u8; 8]) -> [u8; 8] {
        let node = u16::from(self.device.node().node_id().number());
        let frame = Frame::with(Id::base(0x600 + node).unwrap(), request);
        self.device.handle_frame(self.now, &frame);
        let mut answers = Vec::new();
        while let Some(frame) = self.device.poll_transmit(self.now) {
            if frame.id().number() == u32::from(0x580 + node) {
                answers.push(frame.octets().try_into().unwrap());
            }
        }
        let [answer] = answers[..] else { panic!("{request:02X?} got {answers:?}") };
        answer
    }

    /// Time passes; every deadline on the way is met. Says when each frame was sent, in milliseconds from the call.
    pub(crate) fn pass(&mut self, millis: u64) -> Vec<(u64, String)> {
        let begin = self.now;
        let end = begin.saturating_add(Duration::from_millis(millis));
        let mut seen = Vec::new();
        for _ in 0..1_000_000 {
            match self.device.poll_timeout() {
                Some(due) if due <= end => {
                    self.now = self.now.max(due);
                    self.device.handle_timeout(self.now);
                    let at = u64::try_from(self.now.saturating_since(begin).as_millis()).unwrap();
                    seen.extend(self.drain().into_iter().map(|frame| (at, frame)));
                }
                Some(_) | None => {
                    self.now = end;
                    return seen;
                }
            }
        }
        panic!("the device asks for time without end");
    }

    pub(crate) fn drain(&mut self) -> Vec<String> {
        std::iter::from_fn(|| self.device.poll_transmit(self.now)).map(|frame| frame.to_string()).collect()
    }
}
