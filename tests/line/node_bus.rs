//! Nodes on a bus in memory: what they say around bus off, and rates that do not fit.

use std::time::Duration;

use profidrive::can_bus::can::{BitRate, Frame, Id};
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::can_bus::canopen::{self, NodeId};
use profidrive::devices::CanopenEvent;
use profidrive::host::can::{Bus, Event, Product, Seat, StoredNode};
use profidrive::host::fault::Rule;
use profidrive::host::list::Choices;
use profidrive::time::Instant;

/// A master, and a node 5.
struct Rig {
    bus: Bus<CanopenEvent>,
    master: Seat,
    node: Seat,
    now: Instant,
    heard: Vec<String>,
    /// Emergencies that the node says it has sent, and what the bus tells.
    told: Vec<String>,
}

impl Rig {
    fn new(product: &str, rate: BitRate) -> Self {
        let now = Instant::ZERO;
        let mut bus = Bus::new(rate);
        let master = bus.connect(now);
        let product = Product::named(product).unwrap();
        let device = product.make(NodeId::new(5).unwrap(), &Choices::default(), Eeprom::Internal, now);
        let node = bus.add(now, Box::new(StoredNode::new(device, now)));
        let mut rig = Self { bus, master, node, now, heard: Vec::new(), told: Vec::new() };
        rig.pass(5);
        rig
    }

    fn pass(&mut self, millis: u64) {
        let end = self.now.saturating_add(Duration::from_millis(millis));
        while let Some(due) = self.bus.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            self.bus.handle_timeout(self.now);
        }
        self.now = end;
        while let Some(heard) = self.bus.poll_heard(self.master) {
            self.heard.push(heard.frame.to_string().replace(' ', ""));
        }
        while let Some(event) = self.bus.poll_event() {
            match event {
                Event::Participant {
                    event: CanopenEvent::Node(canopen::Event::Emergency { code, .. }),
                    ..
                } => {
                    let [low, high] = code.to_le_bytes();
                    self.told.push(format!("085#{low:02X}{high:02X}"));
                }
                Event::Tuned(tuned) => self.told.push(tuned.to_string()),
                _ => {}
            }
        }
    }

    /// What is heard within 10 ms of a frame of the master.
    fn send(&mut self, id: u16, octets: &[u8]) -> Vec<String> {
        self.heard.clear();
        let frame = Frame::data(Id::base(id).unwrap(), octets).unwrap();
        self.bus.send(self.now, self.master, frame).unwrap();
        self.pass(10);
        self.heard.clone()
    }

    /// Writes an entry of one or two octets; whether that was confirmed.
    fn write(&mut self, index: u16, sub: u8, value: u16, len: u8) -> bool {
        let ([a, b], [d, e]) = (index.to_le_bytes(), value.to_le_bytes());
        let answer = self.send(0x605, &[0x23 | (4 - len) << 2, a, b, sub, d, e, 0, 0]);
        answer.iter().any(|frame| frame.starts_with("585#60"))
    }

    fn save(&mut self) -> bool {
        let answer = self.send(0x605, &[0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e']);
        answer.iter().any(|frame| frame.starts_with("585#60"))
    }

    fn reset(&mut self) -> Vec<String> {
        self.send(0x000, &[0x81, 5])
    }

    fn is_there(&mut self) -> bool {
        !self.send(0x605, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]).is_empty()
    }
}

#[test]
fn fc_6_every_emergency_that_is_told_is_on_the_bus() {
    for delay in 0..30 {
        let mut rig = Rig::new("ag03-1", BitRate::K500);
        rig.send(0x000, &[0x01, 5]);
        for word in [0x06, 0x07, 0x0F] {
            rig.send(0x205, &[word, 0x01]);
        }
        rig.send(0x405, &[0x1F, 0x00, 0x50, 0xC3, 0, 0]);
        rig.pass(500 + delay * 3);
        rig.heard.clear();
        rig.told.clear();
        let rule = "frame-damaged,node=5,count=32".parse::<Rule>().unwrap();
        rig.bus.add_fault(rig.now, rule).unwrap();
        rig.pass(2000);
        let heard: Vec<_> = rig
            .heard
            .iter()
            .filter(|frame| frame.starts_with("085#"))
            .map(|frame| frame[..8].to_owned())
            .collect();
        assert_eq!(rig.told, ["085#02FF", "085#03FF", "085#4081"], "{delay}");
        assert_eq!(heard, rig.told, "{delay}");
        for count in [32, 32, 100, 320] {
            rig.heard.clear();
            rig.told.clear();
            let rule = format!("frame-damaged,node=5,count={count}").parse::<Rule>().unwrap();
            rig.bus.add_fault(rig.now, rule).unwrap();
            rig.pass(1000 + delay);
            let heard: Vec<_> = rig
                .heard
                .iter()
                .filter(|frame| frame.starts_with("085#"))
                .map(|frame| frame[..8].to_owned())
                .collect();
            assert_eq!(rig.told.iter().filter(|told| *told == "085#4081").count(), count / 32);
            assert_eq!(heard, rig.told, "{delay} again");
        }
    }
}

#[test]
fn fc_6_a_damaged_frame_comes_again_before_the_next_of_its_station() {
    let mut rig = Rig::new("ag03-1", BitRate::K500);
    // Two answers wait, one is on the wire.
    let rule = "frame-damaged,node=5,count=1".parse::<Rule>().unwrap();
    rig.bus.add_fault(rig.now, rule).unwrap();
    let read = |index: u16| {
        let [a, b] = index.to_le_bytes();
        Frame::data(Id::base(0x605).unwrap(), &[0x40, a, b, 0, 0, 0, 0, 0]).unwrap()
    };
    for index in [0x1000, 0x1001, 0x1017] {
        rig.bus.send(rig.now, rig.master, read(index)).unwrap();
    }
    rig.heard.clear();
    rig.pass(50);
    let seen: Vec<_> = rig.heard.iter().map(|frame| &frame[6..10]).collect();
    assert_eq!(seen, ["0010", "0110", "1710"]);
}

/// What changes the rate of each device to 125 kbit/s, before it is saved.
const RATES: [(&str, u16, u8, u16, u8); 3] =
    [("ag03-1", 0x2100, 0, 7, 1), ("ap10", 0x5F0A, 3, 1, 1), ("asda-a2", 0x2301, 0, 0x0003, 2)];

#[test]
fn fc_8_a_rate_has_its_effect_after_the_reset_and_a_master_that_changes_over_finds_the_node_again() {
    for (product, index, sub, code, len) in RATES {
        let mut rig = Rig::new(product, BitRate::K500);
        assert!(rig.is_there() && rig.write(index, sub, code, len), "{product}");
        rig.save();
        assert!(rig.is_there(), "{product}: not before the reset");
        rig.told.clear();
        assert_eq!(rig.reset(), [""; 0], "{product}");
        assert!(!rig.is_there(), "{product}: at 125 kbit/s");
        let silent = "its rate is 125000 bit/s and that of the bus 500000 bit/s: it is silent and hears nothing until the \
                      master uses 125000 bit/s";
        assert_eq!(rig.told, [silent], "{product}");
    }
}

#[test]
fn fc_8_a_device_of_the_factory_has_the_rate_of_the_command_line_if_one_is_given() {
    for product in ["ag03-1", "asda-a2"] {
        let mut rig = Rig::new(product, BitRate::K250);
        assert!(!rig.is_there(), "{product}: the factory has 500 kbit/s");
        let now = rig.now;
        rig.bus.with(now, rig.node, |node: &mut StoredNode, now| node.set_rate(now, BitRate::K250)).unwrap();
        assert!(rig.is_there(), "{product}");
        assert!(rig.told.last().unwrap().starts_with("its rate is that of the bus again"), "{:?}", rig.told);
        assert_eq!(rig.reset(), ["705#00"], "{product}");
    }
    assert!(Rig::new("ap10", BitRate::K250).is_there(), "it finds the rate");
}

#[test]
fn fc_8_a_rate_that_is_not_saved_is_in_force_after_a_reset_of_the_communication_only() {
    for (product, index, sub, code, len) in RATES {
        let mut rig = Rig::new(product, BitRate::K500);
        assert!(rig.write(index, sub, code, len), "{product}");
        rig.send(0x000, &[0x82, 5]);
        assert!(!rig.is_there(), "{product}");
        // An AG03/1 keeps what is written.
        let mut rig = Rig::new(product, BitRate::K500);
        assert!(rig.write(index, sub, code, len), "{product}");
        rig.reset();
        assert_eq!(rig.is_there(), product != "ag03-1", "{product}");
    }
}
