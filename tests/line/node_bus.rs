//! Nodes on a bus in memory: what they say around bus off.

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
    now: Instant,
    heard: Vec<String>,
    /// Emergencies that the node says it has sent.
    told: Vec<String>,
}

impl Rig {
    fn new(product: &str, rate: BitRate) -> Self {
        let now = Instant::ZERO;
        let mut bus = Bus::new(rate);
        let master = bus.connect(now);
        let product = Product::named(product).unwrap();
        let device = product.make(NodeId::new(5).unwrap(), &Choices::default(), Eeprom::Internal, now);
        bus.add(now, Box::new(StoredNode::new(device, now)));
        let mut rig = Self { bus, master, now, heard: Vec::new(), told: Vec::new() };
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
            if let Event::Participant {
                event: CanopenEvent::Node(canopen::Event::Emergency { code, .. }),
                ..
            } = event
            {
                let [low, high] = code.to_le_bytes();
                self.told.push(format!("085#{low:02X}{high:02X}"));
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
    let mut rig = Rig::new("ag03-1", BitRate::K125);
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
