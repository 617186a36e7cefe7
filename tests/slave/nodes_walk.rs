//! Every CANopen device under a master at random, compared with a model of `canopen-link.md` 3 to 5: NMT, error control and SDO,
//! with malformed commands, lost requests, lost answers and power failures at every point.

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::NodeId;
use profidrive::devices::CanopenDevice;
use profidrive::devices::ag03::canopen::{self as ag03, Ag03Node};
use profidrive::devices::ap10::canopen::{self as ap10, Ap10};
use profidrive::devices::asda_a2::canopen::{AsdaA2, Quirks};
use profidrive::devices::asda_a2::{self, Level};
use profidrive::time::Instant;
use proptest::prelude::*;

/// An identifier and what comes with it.
type Seen = (u32, Vec<u8>);

/// What the bus may do to a request and its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    Arrives,
    RequestLost,
    AnswerLost,
}

#[derive(Clone, Debug)]
enum Step {
    /// A command to all, to the node, or to another one; of two octets or not.
    Nmt {
        command: u8,
        to: To,
        octets: usize,
    },
    Sdo(Request, Fate),
    /// A remote frame of error control.
    Guard(Fate),
    Sync,
    Power(bool),
    Pass(u64),
}

#[derive(Clone, Copy, Debug)]
enum To {
    All,
    Node,
    Other,
}

#[derive(Clone, Copy, Debug)]
enum Request {
    ReadHeartbeat,
    WriteHeartbeat(u16),
    /// Four octets instead of two.
    WriteLong,
    ReadType,
    WriteType,
    ReadMissing,
    ReadMissingSub,
    /// Seven octets: no request.
    Short,
}

fn request() -> impl Strategy<Value = Request> {
    prop_oneof![
        2 => Just(Request::ReadHeartbeat),
        4 => prop_oneof![Just(0_u16), Just(10), Just(17), Just(100), Just(250)].prop_map(Request::WriteHeartbeat),
        1 => Just(Request::WriteLong),
        1 => Just(Request::ReadType),
        1 => Just(Request::WriteType),
        1 => Just(Request::ReadMissing),
        1 => Just(Request::ReadMissingSub),
        1 => Just(Request::Short),
    ]
}

fn fate() -> impl Strategy<Value = Fate> {
    prop_oneof![6 => Just(Fate::Arrives), 1 => Just(Fate::RequestLost), 1 => Just(Fate::AnswerLost)]
}

fn step() -> impl Strategy<Value = Step> {
    let commands = prop_oneof![
        3 => Just(0x01_u8), 2 => Just(0x02), 2 => Just(0x80), 1 => Just(0x81), 1 => Just(0x82), 1 => any::<u8>()
    ];
    let to = prop_oneof![3 => Just(To::All), 3 => Just(To::Node), 1 => Just(To::Other)];
    let octets = prop_oneof![8 => Just(2_usize), 1 => Just(1), 1 => Just(3)];
    prop_oneof![
        6 => (commands, to, octets).prop_map(|(command, to, octets)| Step::Nmt { command, to, octets }),
        8 => (request(), fate()).prop_map(|(request, fate)| Step::Sdo(request, fate)),
        3 => fate().prop_map(Step::Guard),
        1 => Just(Step::Sync),
        1 => prop_oneof![2 => Just(true), 1 => Just(false)].prop_map(Step::Power),
        4 => (0_u64..400).prop_map(Step::Pass),
    ]
}

/// What differs between the devices.
#[derive(Clone, Copy)]
struct Kind {
    number: u8,
    device_type: u32,
    /// The abort code of four octets for an entry of two.
    wrong_length: u32,
}

/// What the reference says of a node.
struct Model {
    kind: Kind,
    /// The octet of its state; `None`: it is off.
    state: Option<u8>,
    /// ms.
    heartbeat: u16,
    /// The next one is due, ms.
    due: u64,
    toggle: bool,
    /// ms.
    now: u64,
}

const STOPPED: u8 = 0x04;
const OPERATIONAL: u8 = 0x05;
const PRE_OPERATIONAL: u8 = 0x7F;

impl Model {
    fn error_control(&self, octet: u8) -> Vec<Seen> {
        vec![(0x700 + u32::from(self.kind.number), vec![octet])]
    }

    /// Boot-up and what is as after power-on: nothing was saved.
    fn reset(&mut self) -> Vec<Seen> {
        (self.state, self.heartbeat, self.toggle) = (Some(PRE_OPERATIONAL), 0, false);
        self.error_control(0)
    }

    fn nmt(&mut self, command: u8, to: To, octets: usize) -> Vec<Seen> {
        if self.state.is_none() || octets != 2 || matches!(to, To::Other) {
            return Vec::new();
        }
        match command {
            0x01 => self.state = Some(OPERATIONAL),
            0x02 => self.state = Some(STOPPED),
            0x80 => self.state = Some(PRE_OPERATIONAL),
            0x81 | 0x82 => return self.reset(),
            _ => {}
        }
        Vec::new()
    }

    fn sdo(&mut self, request: Request) -> Vec<Seen> {
        let answer = |octets: [u8; 8]| vec![(0x580 + u32::from(self.kind.number), octets.to_vec())];
        let abort = |[a, b, sub]: [u8; 3], code: u32| {
            let [c, d, e, f] = code.to_le_bytes();
            answer([0x80, a, b, sub, c, d, e, f])
        };
        if !matches!(self.state, Some(PRE_OPERATIONAL | OPERATIONAL)) {
            return Vec::new();
        }
        match request {
            Request::ReadHeartbeat => {
                let [low, high] = self.heartbeat.to_le_bytes();
                answer([0x4B, 0x17, 0x10, 0, low, high, 0, 0])
            }
            Request::WriteHeartbeat(time) => {
                let seen = answer([0x60, 0x17, 0x10, 0, 0, 0, 0, 0]);
                (self.heartbeat, self.due) = (time, self.now + u64::from(time));
                seen
            }
            Request::WriteLong => abort([0x17, 0x10, 0], self.kind.wrong_length),
            Request::ReadType => {
                let [a, b, c, d] = self.kind.device_type.to_le_bytes();
                answer([0x43, 0x00, 0x10, 0, a, b, c, d])
            }
            Request::WriteType => abort([0x00, 0x10, 0], 0x0601_0002),
            Request::ReadMissing => abort([0xFF, 0x0F, 0], 0x0602_0000),
            Request::ReadMissingSub => abort([0x17, 0x10, 7], 0x0609_0011),
            Request::Short => Vec::new(),
        }
    }

    /// Heartbeat and guarding exclude each other.
    fn guard(&mut self) -> Vec<Seen> {
        let Some(state) = self.state.filter(|_| self.heartbeat == 0) else { return Vec::new() };
        let octet = state | u8::from(self.toggle) << 7;
        self.toggle = !self.toggle;
        self.error_control(octet)
    }

    fn pass(&mut self, millis: u64) -> Vec<Seen> {
        let end = self.now + millis;
        let mut seen = Vec::new();
        while let (Some(state), 1..) = (self.state, self.heartbeat) {
            if self.due > end {
                break;
            }
            seen.extend(self.error_control(state));
            self.due += u64::from(self.heartbeat);
        }
        self.now = end;
        seen
    }
}

/// The octets of a request.
fn octets(request: Request) -> Vec<u8> {
    let whole = match request {
        Request::ReadHeartbeat | Request::Short => [0x40, 0x17, 0x10, 0, 0, 0, 0, 0],
        Request::WriteHeartbeat(time) => {
            let [low, high] = time.to_le_bytes();
            [0x2B, 0x17, 0x10, 0, low, high, 0, 0]
        }
        Request::WriteLong => [0x23, 0x17, 0x10, 0, 100, 0, 0, 0],
        Request::ReadType => [0x40, 0x00, 0x10, 0, 0, 0, 0, 0],
        Request::WriteType => [0x23, 0x00, 0x10, 0, 1, 0, 0, 0],
        Request::ReadMissing => [0x40, 0xFF, 0x0F, 0, 0, 0, 0, 0],
        Request::ReadMissingSub => [0x40, 0x17, 0x10, 7, 0, 0, 0, 0],
    };
    whole[..if matches!(request, Request::Short) { 7 } else { 8 }].to_vec()
}

/// The device, on a clock that counts ms.
struct Rig {
    device: Box<dyn CanopenDevice>,
    millis: u64,
}

impl Rig {
    fn now(&self) -> Instant {
        Instant::from_millis(self.millis)
    }

    fn frame(&mut self, frame: &Frame) {
        self.device.handle_frame(self.now(), frame);
    }

    fn data(&mut self, id: u16, octets: &[u8]) {
        self.frame(&Frame::data(Id::base(id).unwrap(), octets).unwrap());
    }

    fn pass(&mut self, millis: u64) -> Vec<Seen> {
        let end = Instant::from_millis(self.millis + millis);
        let mut seen = Vec::new();
        while let Some(due) = self.device.poll_timeout().filter(|due| *due <= end) {
            self.device.handle_timeout(due.max(self.now()));
            seen.extend(self.sent());
        }
        self.millis += millis;
        seen
    }

    fn sent(&mut self) -> Vec<Seen> {
        let now = self.now();
        while self.device.poll_event().is_some() {}
        std::iter::from_fn(|| self.device.poll_transmit(now))
            .map(|frame| (frame.id().number(), frame.octets().to_vec()))
            .collect()
    }
}

/// Process data and emergencies are not in the model; in which state, before the step or behind it, each may be sent is.
fn without_others(seen: Vec<Seen>, states: [Option<u8>; 2], number: u8) -> Vec<Seen> {
    let emergency = 0x080 + u32::from(number);
    let (others, own): (Vec<Seen>, Vec<Seen>) = seen.into_iter().partition(|(id, _)| *id < 0x580);
    for (id, octets) in others {
        let may = |state: Option<u8>| match state {
            Some(OPERATIONAL) => true,
            Some(PRE_OPERATIONAL) => id == emergency,
            Some(_) | None => false,
        };
        assert!(states.into_iter().any(may), "{id:03X} {octets:02X?} in the states {states:02X?}");
    }
    own
}

fn walk(device: Box<dyn CanopenDevice>, kind: Kind, steps: &[Step]) {
    let number = kind.number;
    let mut rig = Rig { device, millis: 1 };
    rig.device.power_off(rig.now());
    rig.sent();
    let mut model = Model { kind, state: None, heartbeat: 0, due: 0, toggle: false, now: 1 };
    // Each walk begins and ends with a master that finds the node and reads it.
    let begin = [Step::Power(true)];
    let end = [
        Step::Power(true),
        Step::Nmt { command: 0x80, to: To::All, octets: 2 },
        Step::Sdo(Request::ReadType, Fate::Arrives),
        Step::Sdo(Request::WriteHeartbeat(0), Fate::Arrives),
        Step::Guard(Fate::Arrives),
    ];
    for step in begin.iter().chain(steps).chain(&end) {
        let before = model.state;
        let mut lost = Fate::Arrives;
        let (seen, expected) = match step {
            Step::Nmt { command, to, octets } => {
                let to_number = match to {
                    To::All => 0,
                    To::Node => number,
                    To::Other => number ^ 1,
                };
                rig.data(0x000, &[*command, to_number, 0][..*octets]);
                (rig.sent(), model.nmt(*command, *to, *octets))
            }
            Step::Sdo(request, fate) => {
                lost = *fate;
                if lost == Fate::RequestLost {
                    (Vec::new(), Vec::new())
                } else {
                    rig.data(0x600 + u16::from(number), &octets(*request));
                    (rig.sent(), model.sdo(*request))
                }
            }
            Step::Guard(fate) => {
                lost = *fate;
                if lost == Fate::RequestLost {
                    (Vec::new(), Vec::new())
                } else {
                    rig.frame(&Frame::remote(Id::base(0x700 + u16::from(number)).unwrap(), 1).unwrap());
                    (rig.sent(), model.guard())
                }
            }
            Step::Sync => {
                rig.data(0x080, &[]);
                (rig.sent(), Vec::new())
            }
            Step::Power(true) => {
                let was_on = model.state.is_some();
                if !was_on {
                    rig.device.power_on(rig.now());
                }
                (rig.sent(), if was_on { Vec::new() } else { model.reset() })
            }
            Step::Power(false) => {
                rig.device.power_off(rig.now());
                model.state = None;
                (rig.sent(), Vec::new())
            }
            Step::Pass(millis) => (rig.pass(*millis), model.pass(*millis)),
        };
        let seen = without_others(seen, [before, model.state], number);
        if lost != Fate::AnswerLost {
            assert_eq!(seen, expected, "{step:?} in state {before:02X?}");
        }
    }
}

fn ag03_node() -> Box<dyn CanopenDevice> {
    let now = Instant::from_millis(1);
    Box::new(Ag03Node::new(ag03::Config::new(NodeId::new(5).unwrap()), now))
}

fn ap10_node() -> Box<dyn CanopenDevice> {
    Box::new(Ap10::new(ap10::Config::new(NodeId::new(125).unwrap())))
}

fn asda_a2_node() -> Box<dyn CanopenDevice> {
    let config = asda_a2::Config { level: Level::Full, ..asda_a2::Config::new(0x7F) };
    Box::new(AsdaA2::new(config, Quirks::default(), Instant::from_millis(1)))
}

proptest! {
    #![proptest_config(crate::long::cases(96, 20))]

    #[test]
    fn an_ag03_is_as_the_model(steps in prop::collection::vec(step(), 1..80)) {
        walk(ag03_node(), Kind { number: 5, device_type: 0x0000_0192, wrong_length: 0x0601_0000 }, &steps);
    }

    #[test]
    fn an_ap10_is_as_the_model(steps in prop::collection::vec(step(), 1..80)) {
        walk(ap10_node(), Kind { number: 125, device_type: 0x0005_0196, wrong_length: 0x0601_0000 }, &steps);
    }

    #[test]
    fn an_asda_a2_is_as_the_model(steps in prop::collection::vec(step(), 1..80)) {
        walk(asda_a2_node(), Kind { number: 0x7F, device_type: 0x0402_0192, wrong_length: 0x0607_0010 }, &steps);
    }
}
