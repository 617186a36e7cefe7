//! [`NodeClient`] with the emulated AG03/1 and ASDA-A2, in virtual time.

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::{Abort, Address, NmtState, NodeId};
use profidrive::client::{NodeClient, NodeGoal, NodeLimits, NodeOutcome, NodeTrouble};
use profidrive::devices::CanopenDevice;
use profidrive::devices::ag03::canopen::{Ag03Node, Config};
use profidrive::devices::asda_a2::canopen::{AsdaA2, Quirks};
use profidrive::devices::asda_a2::{Config as AsdaConfig, Level};
use profidrive::face::Turning;
use profidrive::time::Instant;

const NODE: u8 = 5;

/// A client and a device, and what was sent.
struct Rig {
    now: Instant,
    client: NodeClient,
    device: Box<dyn CanopenDevice>,
    /// The frames of the client.
    sent: Vec<Frame>,
    /// While false nothing of the client arrives.
    connected: bool,
}

impl Rig {
    fn new(device: Box<dyn CanopenDevice>) -> Self {
        let client = NodeClient::new(NodeId::new(NODE).unwrap(), NodeLimits::default());
        let now = Instant::from_millis(1);
        let mut rig = Self { now, client, device, sent: Vec::new(), connected: true };
        rig.device.power_on(now);
        rig.settle();
        rig
    }

    fn ag03() -> Self {
        let now = Instant::from_millis(1);
        Self::new(Box::new(Ag03Node::new(Config::new(NodeId::new(NODE).unwrap()), now).unsupplied(now)))
    }

    fn asda() -> Self {
        let config = AsdaConfig { level: Level::Full, ..AsdaConfig::new(NODE) };
        Self::new(Box::new(AsdaA2::new(config, Quirks::default(), Instant::from_millis(1))))
    }

    /// Frames go over and back until nobody says anything.
    fn settle(&mut self) {
        loop {
            let mut quiet = true;
            while let Some(frame) = self.client.poll_transmit() {
                quiet = false;
                self.sent.push(frame);
                if self.connected {
                    self.device.handle_frame(self.now, &frame);
                }
            }
            while let Some(frame) = self.device.poll_transmit(self.now) {
                quiet = false;
                if self.connected {
                    self.client.handle_frame(self.now, &frame);
                }
            }
            while self.device.poll_event().is_some() {}
            if quiet {
                return;
            }
        }
    }

    fn pass(&mut self, end: Instant) {
        loop {
            let due = Instant::first_of(self.client.poll_timeout(), self.device.poll_timeout());
            let Some(due) = due.filter(|due| *due <= end) else { break };
            self.now = self.now.max(due);
            self.device.handle_timeout(self.now);
            self.client.handle_timeout(self.now);
            self.settle();
        }
        self.now = end;
    }

    fn outcome(&mut self) -> NodeOutcome {
        self.settle();
        for _ in 0..120_000 {
            if let Some(outcome) = self.client.poll_outcome() {
                return outcome;
            }
            self.pass(self.now.saturating_add(Duration::from_millis(10)));
        }
        panic!("no outcome in 20 minutes");
    }

    fn pursue(&mut self, goal: NodeGoal) -> NodeOutcome {
        self.client.pursue(self.now, goal);
        self.outcome()
    }

    fn read(&mut self, index: u16, sub: u8) -> i32 {
        self.client.read(self.now, Address::new(index, sub));
        match self.outcome() {
            NodeOutcome::Read(octets, len) => {
                let mut value = [0; 4];
                value[..len.min(4)].copy_from_slice(&octets[..len.min(4)]);
                i32::from_le_bytes(value)
            }
            other => panic!("{index:04X}: {other:?}"),
        }
    }

    fn write(&mut self, index: u16, sub: u8, octets: &[u8]) -> NodeOutcome {
        self.client.write(self.now, Address::new(index, sub), octets);
        self.outcome()
    }

    /// The control words sent, each once.
    fn words(&self) -> Vec<u16> {
        let mut words: Vec<u16> = self
            .sent
            .iter()
            .filter(|frame| {
                frame.id() == Id::base(0x605).unwrap() && frame.octets()[..4] == [0x2B, 0x40, 0x60, 0]
            })
            .map(|frame| u16::from_le_bytes([frame.octets()[4], frame.octets()[5]]))
            .collect();
        words.dedup();
        words
    }
}

#[test]
fn an_entry_is_read_written_and_refused_with_its_reason() {
    let mut rig = Rig::ag03();
    assert_eq!(rig.read(0x1000, 0), 0x192);
    assert_eq!(rig.write(0x2410, 5, &[60]), NodeOutcome::Written);
    assert_eq!(rig.read(0x2410, 5), 60);
    let at = Address::new(0x2410, 5);
    let refused = NodeOutcome::Failed(NodeTrouble::Refused { at, code: Abort::RANGE });
    assert_eq!(rig.write(0x2410, 5, &[0]), refused);
    let nothing = NodeOutcome::Failed(NodeTrouble::Refused { at, code: Abort::LENGTH });
    assert_eq!(rig.write(0x2410, 5, &[]), nothing);
    rig.connected = false;
    rig.client.read(rig.now, at);
    assert_eq!(rig.outcome(), NodeOutcome::Failed(NodeTrouble::NoAnswer { at }));
}

#[test]
fn the_ag03_1_travels_and_is_left_as_it_was() {
    let mut rig = Rig::ag03();
    rig.write(0x100C, 0, &[7, 0]);
    for target in [1600, 1600, -400] {
        rig.sent.clear();
        assert_eq!(rig.pursue(NodeGoal::MoveTo(target)), NodeOutcome::Done);
        assert!((rig.read(0x6064, 0) - target).abs() <= 10);
        assert_eq!(rig.pursue(NodeGoal::Leave), NodeOutcome::Done);
        assert_eq!(rig.words(), [0x0006, 0x0007, 0x000F, 0x001F, 0x000F, 0x0000]);
        assert_eq!((rig.read(0x100C, 0), rig.read(0x100D, 0), rig.read(0x1017, 0)), (7, 0, 0));
        assert_eq!(rig.read(0x6041, 0), 0x0470, "SWITCH ON DISABLED in PRE-OPERATIONAL, at the target");
    }
}

#[test]
fn a_quick_stop_ends_a_travel() {
    let mut rig = Rig::ag03();
    rig.client.pursue(rig.now, NodeGoal::MoveTo(100_000));
    rig.settle();
    rig.pass(rig.now.saturating_add(Duration::from_secs(1)));
    assert_eq!(rig.client.poll_outcome(), None, "under way");
    assert!(rig.client.status().is_some_and(|status| status.0 & 1 << 14 != 0));
    assert_eq!(rig.pursue(NodeGoal::Stop), NodeOutcome::Done);
    assert_eq!(rig.pursue(NodeGoal::Leave), NodeOutcome::Done);
    let at = rig.read(0x6064, 0);
    rig.pass(rig.now.saturating_add(Duration::from_secs(1)));
    assert!(at > 0 && rig.read(0x6064, 0) - at < 400, "it stands, or runs out");
}

#[test]
fn a_master_that_is_gone_lets_the_drive_release_its_motor() {
    let mut rig = Rig::ag03();
    rig.client.pursue(rig.now, NodeGoal::MoveTo(100_000));
    rig.settle();
    rig.pass(rig.now.saturating_add(Duration::from_secs(5)));
    assert_eq!(rig.client.poll_outcome(), None, "five seconds of a life time of one");
    rig.connected = false;
    rig.pass(rig.now.saturating_add(Duration::from_secs(3)));
    rig.connected = true;
    assert_eq!(rig.read(0x6041, 0) & 0x4F, 0x40, "SWITCH ON DISABLED");
}

#[test]
fn why_a_travel_is_not_done() {
    let mut rig = Rig::ag03();
    let beyond = rig.pursue(NodeGoal::MoveTo(2_000_000));
    assert!(matches!(beyond, NodeOutcome::Failed(NodeTrouble::NotAcknowledged { .. })), "{beyond:?}");
    rig.pursue(NodeGoal::Leave);
    assert_eq!(rig.write(0x6060, 0, &[2]), NodeOutcome::Written);
    assert_eq!(rig.pursue(NodeGoal::MoveTo(0)), NodeOutcome::Failed(NodeTrouble::Mode { mode: 2 }));
    rig.pursue(NodeGoal::Leave);
    rig.write(0x6060, 0, &[1]);
    let out_of_range = NodeTrouble::Refused { at: Address::new(0x607A, 0), code: Abort::RANGE };
    assert_eq!(rig.pursue(NodeGoal::MoveTo(i32::MAX)), NodeOutcome::Failed(out_of_range));
    rig.pursue(NodeGoal::Leave);
    rig.connected = false;
    assert_eq!(rig.pursue(NodeGoal::MoveTo(0)), NodeOutcome::Failed(NodeTrouble::NotOperational));
}

#[test]
fn there_is_nothing_to_stop_outside_operational() {
    let mut rig = Rig::ag03();
    assert_eq!(rig.pursue(NodeGoal::Stop), NodeOutcome::Done);
    rig.connected = false;
    let nobody = NodeTrouble::NoAnswer { at: Address::new(0x6040, 0) };
    assert_eq!(rig.pursue(NodeGoal::Stop), NodeOutcome::Failed(nobody));
}

#[test]
fn the_asda_a2_is_homed_and_its_mode_put_back() {
    let mut rig = Rig::asda();
    rig.write(0x6060, 0, &[3]);
    rig.write(0x607C, 0, &5000_i32.to_le_bytes());
    let without = rig.pursue(NodeGoal::Home);
    assert!(matches!(without, NodeOutcome::Failed(NodeTrouble::Homing { .. })), "no method: {without:?}");
    rig.pursue(NodeGoal::Leave);
    rig.write(0x6098, 0, &[35]);
    assert_eq!(rig.pursue(NodeGoal::Home), NodeOutcome::Done);
    assert_eq!((rig.read(0x6061, 0) & 0xFF, rig.read(0x6064, 0)), (6, 5000));
    assert_eq!(rig.pursue(NodeGoal::Leave), NodeOutcome::Done);
    assert_eq!(rig.read(0x6060, 0) & 0xFF, 3);
    let mut drive = Rig::ag03();
    let refused = drive.pursue(NodeGoal::Home);
    assert!(matches!(refused, NodeOutcome::Failed(NodeTrouble::Refused { .. })), "{refused:?}");
}

#[test]
fn a_fault_is_acknowledged_when_its_cause_is_gone() {
    for (mut rig, fault) in [(Rig::ag03(), "F"), (Rig::asda(), "011")] {
        let now = rig.now;
        rig.device.act(now, &mut |description| description.provoke(now, fault).unwrap());
        rig.settle();
        assert_eq!(rig.read(0x6041, 0) & 0x4F, 8, "a fault");
        let now = rig.now;
        rig.device.act(now, &mut |description| description.make_nominal(now));
        assert_eq!(rig.pursue(NodeGoal::Acknowledge), NodeOutcome::Done);
        assert_eq!(rig.pursue(NodeGoal::Leave), NodeOutcome::Done);
        assert_eq!(rig.read(0x6041, 0) & 0x4F, 0x40, "SWITCH ON DISABLED");
    }
}

#[test]
fn the_asda_a2_travels_by_the_same_words() {
    let mut rig = Rig::asda();
    let turn: i32 = 1_280_000;
    assert_eq!(rig.write(0x6081, 0, &(10 * turn).to_le_bytes()), NodeOutcome::Written);
    assert_eq!(rig.pursue(NodeGoal::MoveTo(2 * turn)), NodeOutcome::Done);
    assert!((rig.read(0x6064, 0) - 2 * turn).abs() < 20_000);
    assert_eq!(rig.client.nmt(), Some(NmtState::Operational));
    assert_eq!(rig.pursue(NodeGoal::Stop), NodeOutcome::Done);
    assert_eq!(rig.pursue(NodeGoal::Leave), NodeOutcome::Done);
    assert_eq!(rig.words(), [0x0006, 0x0007, 0x000F, 0x001F, 0x000F, 0x0002, 0x0000]);
}

/// What the device itself says of how it turns.
fn turn(rig: &Rig, velocity: i32) -> NodeGoal {
    let Turning { mode, target, .. } = rig.device.description().turning().unwrap();
    NodeGoal::Turn { mode, target, velocity }
}

#[test]
fn a_drive_turns_with_a_velocity_and_travels_afterwards() {
    for (mut rig, fast, slow, near) in [(Rig::ag03(), 60, -30, 4), (Rig::asda(), 3000, -1000, 20)] {
        rig.write(0x6060, 0, &[1]);
        for velocity in [fast, slow, slow] {
            let goal = turn(&rig, velocity);
            assert_eq!(rig.pursue(goal), NodeOutcome::Done);
            rig.pass(rig.now.saturating_add(Duration::from_millis(500)));
            assert!((rig.read(0x606C, 0) - velocity).abs() <= near, "{} of {velocity}", rig.read(0x606C, 0));
        }
        let at = rig.read(0x6064, 0);
        assert_eq!(rig.pursue(NodeGoal::MoveTo(at + 500)), NodeOutcome::Done);
        assert!((rig.read(0x6064, 0) - at - 500).abs() <= 110);
        let goal = turn(&rig, fast);
        assert_eq!(rig.pursue(goal), NodeOutcome::Done);
        assert_eq!(rig.pursue(NodeGoal::Stop), NodeOutcome::Done);
        rig.pass(rig.now.saturating_add(Duration::from_secs(1)));
        assert_eq!(rig.read(0x606C, 0), 0);
        assert_eq!(rig.pursue(NodeGoal::Leave), NodeOutcome::Done);
        assert_eq!(rig.read(0x6060, 0) & 0xFF, 1, "the mode is as before");
    }
}

#[test]
fn a_velocity_beyond_the_bounds_is_refused_and_a_drive_in_fault_does_not_turn() {
    let mut rig = Rig::ag03();
    let at = Address::new(0x60FF, 0);
    let goal = turn(&rig, 500);
    let refused = NodeOutcome::Failed(NodeTrouble::Refused { at, code: Abort::RANGE });
    assert_eq!(rig.pursue(goal), refused);
    let now = rig.now;
    rig.device.act(now, &mut |description| description.provoke(now, "F").unwrap());
    let goal = turn(&rig, 50);
    let fault = rig.pursue(goal);
    assert!(matches!(fault, NodeOutcome::Failed(NodeTrouble::Fault { .. })), "{fault:?}");
}

#[test]
fn the_ag03_1_inches_in_both_directions_until_something_else_is_asked() {
    let mut rig = Rig::ag03();
    let [positive, negative] = rig.device.description().turning().unwrap().inching.unwrap();
    for (word, sign) in [(positive, 1), (negative, -1), (positive, 1)] {
        assert_eq!(rig.pursue(NodeGoal::Inch { word }), NodeOutcome::Done);
        let at = rig.read(0x6064, 0);
        rig.pass(rig.now.saturating_add(Duration::from_secs(1)));
        assert!((rig.read(0x6064, 0) - at) * sign > 50, "{word:04X}");
    }
    let begun = rig.now;
    assert_eq!(rig.pursue(NodeGoal::MoveTo(0)), NodeOutcome::Done);
    assert!(rig.read(0x6064, 0).abs() <= 10);
    assert!(rig.now.saturating_since(begun) < Duration::from_secs(20));
    rig.pursue(NodeGoal::Inch { word: positive });
    assert_eq!(rig.pursue(NodeGoal::Stop), NodeOutcome::Done);
    let at = rig.read(0x6064, 0);
    rig.pass(rig.now.saturating_add(Duration::from_secs(1)));
    assert!((rig.read(0x6064, 0) - at).abs() < 100, "it stands");
    assert!(Rig::asda().device.description().turning().unwrap().inching.is_none());
}
