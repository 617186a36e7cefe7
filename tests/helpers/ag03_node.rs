//! An AG03/1 on CANopen on a bus of the test's own: frames in, frames out, and a clock that the test sets.

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::NodeId;
use profidrive::devices::CanopenDevice;
use profidrive::devices::CanopenEvent;
use profidrive::devices::ag03::canopen::{Ag03Node, Config};
use profidrive::devices::ag03::drive::Inputs;
use profidrive::time::Instant;

/// A frame as text, so that a difference is readable: `705#00`.
pub(crate) type Seen = String;

pub(crate) struct Rig {
    pub(crate) now: Instant,
    pub(crate) node: Ag03Node,
}

/// Node 5 as the factory delivers it.
pub(crate) fn config() -> Config {
    Config::new(NodeId::new(5).unwrap())
}

impl Rig {
    /// Node 5, switched on, boot-up taken.
    pub(crate) fn new() -> Self {
        Self::with(config())
    }

    pub(crate) fn with(config: Config) -> Self {
        let now = Instant::from_millis(1);
        let mut rig = Self { now, node: Ag03Node::new(config, now) };
        assert_eq!(rig.drain(), ["705#00"]);
        rig
    }

    /// In OPERATIONAL and OPERATION ENABLED, CW.8 = 1.
    pub(crate) fn enabled() -> Self {
        let mut rig = Self::new();
        rig.enable();
        rig
    }

    pub(crate) fn enable(&mut self) {
        self.nmt(0x01);
        for word in [0x0106, 0x0107, 0x010F] {
            self.word(word);
        }
    }

    pub(crate) fn frame(&mut self, frame: &Frame) -> Vec<Seen> {
        self.node.handle_frame(self.now, frame);
        self.drain()
    }

    pub(crate) fn data(&mut self, id: u16, octets: &[u8]) -> Vec<Seen> {
        self.frame(&Frame::data(Id::base(id).unwrap(), octets).unwrap())
    }

    pub(crate) fn remote(&mut self, id: u16, dlc: u8) -> Vec<Seen> {
        self.frame(&Frame::remote(Id::base(id).unwrap(), dlc).unwrap())
    }

    pub(crate) fn nmt(&mut self, command: u8) -> Vec<Seen> {
        self.data(0x000, &[command, 5])
    }

    /// A control word in RPDO1.
    pub(crate) fn word(&mut self, word: u16) -> Vec<Seen> {
        self.data(0x205, &word.to_le_bytes())
    }

    /// A control word and a target in RPDO3.
    pub(crate) fn travel(&mut self, word: u16, target: i32) {
        self.both(0x405, word, target);
    }

    /// A control word and a speed in RPDO4.
    pub(crate) fn turn(&mut self, word: u16, rpm: i32) {
        self.both(0x505, word, rpm);
    }

    fn both(&mut self, id: u16, word: u16, value: i32) {
        let ([a, b], [c, d, e, f]) = (word.to_le_bytes(), value.to_le_bytes());
        self.data(id, &[a, b, c, d, e, f]);
    }

    /// One SDO request and its answer.
    pub(crate) fn sdo(&mut self, request: [u8; 8]) -> [u8; 8] {
        let answers = self.sdo_answers(request);
        let [answer] = answers[..] else { panic!("{request:02X?} got {answers:?}") };
        answer
    }

    pub(crate) fn sdo_answers(&mut self, request: [u8; 8]) -> Vec<[u8; 8]> {
        self.node.handle_frame(self.now, &Frame::with(Id::base(0x605).unwrap(), request));
        self.answers()
    }

    /// The SDO answers among the frames that wait.
    pub(crate) fn answers(&mut self) -> Vec<[u8; 8]> {
        std::iter::from_fn(|| self.node.poll_transmit(self.now))
            .filter(|frame| frame.id() == Id::base(0x585).unwrap())
            .map(|frame| frame.octets().try_into().unwrap())
            .collect()
    }

    /// Reads up to four octets.
    pub(crate) fn read(&mut self, index: u16, sub: u8) -> Result<u32, u32> {
        let [a, b] = index.to_le_bytes();
        let [command, _, _, _, data @ ..] = self.sdo([0x40, a, b, sub, 0, 0, 0, 0]);
        let data = u32::from_le_bytes(data);
        if command == 0x80 { Err(data) } else { Ok(data) }
    }

    /// Writes `len` octets of `value`.
    pub(crate) fn write(&mut self, index: u16, sub: u8, value: i32, len: u8) -> Result<(), u32> {
        let [a, b] = index.to_le_bytes();
        let [d, e, f, g] = value.to_le_bytes();
        let [command, _, _, _, data @ ..] = self.sdo([0x23 | (4 - len) << 2, a, b, sub, d, e, f, g]);
        let data = u32::from_le_bytes(data);
        match command {
            0x60 => Ok(()),
            0x80 => Err(data),
            other => panic!("{index:04X}h:{sub:02X} answered with {other:02X}h"),
        }
    }

    /// Time passes; every deadline on the way is met.
    pub(crate) fn pass(&mut self, time: Duration) -> Vec<Seen> {
        let end = self.now.saturating_add(time);
        let mut seen = Vec::new();
        while let Some(due) = self.node.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            self.node.handle_timeout(self.now);
            seen.extend(self.drain());
        }
        self.now = end;
        seen
    }

    pub(crate) fn pass_ms(&mut self, millis: u64) -> Vec<Seen> {
        self.pass(Duration::from_millis(millis))
    }

    /// Until `ready`, at most a minute.
    pub(crate) fn until(&mut self, what: &str, ready: impl Fn(&Ag03Node) -> bool) {
        for _ in 0..60_000 {
            if ready(&self.node) {
                return;
            }
            self.pass_ms(1);
        }
        panic!("{what} did not come: 6041h is {:04X}h", self.sw());
    }

    /// 6041h.
    pub(crate) fn sw(&self) -> u16 {
        self.node.status_word()
    }

    /// Whether the status word fits a pattern of the manual, bits 15..0, `x` = any.
    pub(crate) fn fits(&self, pattern: &str) -> bool {
        let bits = pattern.chars().filter(|c| *c != ' ').collect::<Vec<_>>();
        assert_eq!(bits.len(), 16, "{pattern}");
        (0..16).all(|place| match bits[15 - place] {
            'x' => true,
            bit => (bit == '1') == (self.sw() >> place & 1 == 1),
        })
    }

    pub(crate) fn position(&self) -> i32 {
        self.node.status().position
    }

    pub(crate) fn input(&mut self, change: impl FnOnce(&mut Inputs)) -> Vec<Seen> {
        let mut inputs = *self.node.inputs();
        change(&mut inputs);
        self.node.set_inputs(self.now, inputs);
        self.drain()
    }

    pub(crate) fn events(&mut self) -> Vec<CanopenEvent> {
        std::iter::from_fn(|| self.node.poll_event()).collect()
    }

    pub(crate) fn drain(&mut self) -> Vec<Seen> {
        std::iter::from_fn(|| self.node.poll_transmit(self.now))
            .map(|frame| frame.to_string().replace(' ', ""))
            .collect()
    }
}
