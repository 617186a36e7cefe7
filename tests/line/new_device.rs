//! The device of `examples/cia401_io.rs` on a bus, and `docs/new-device.md`, which explains it.

#[path = "../../examples/cia401_io.rs"]
mod cia401_io;

use std::fs;
use std::path::Path;
use std::time::Duration;

use cia401_io::{Io, OBJECTS, SHEET};
use profidrive::can_bus::can::{BitRate, Frame, Id};
use profidrive::can_bus::canopen::{NodeId, check, eds};
use profidrive::devices::CanopenEvent;
use profidrive::face::Description;
use profidrive::face::description::Amount;
use profidrive::face::surroundings::Level;
use profidrive::host::can::{Bus, Seat, StoredNode};
use profidrive::time::Instant;

/// A master, and the device as node 5.
struct Rig {
    bus: Bus<CanopenEvent>,
    master: Seat,
    device: Seat,
    now: Instant,
}

impl Rig {
    fn new() -> Self {
        let now = Instant::ZERO;
        let mut bus = Bus::new(BitRate::K500);
        let master = bus.connect(now);
        let device = Io::new(NodeId::new(5).unwrap()).on_node();
        let device = bus.add(now, Box::new(StoredNode::new(Box::new(device), now)));
        let mut rig = Self { bus, master, device, now };
        assert_eq!(rig.heard(), ["705#00"]);
        rig
    }

    fn send(&mut self, id: u16, octets: &[u8]) -> Vec<String> {
        let frame = Frame::data(Id::base(id).unwrap(), octets).unwrap();
        self.bus.send(self.now, self.master, frame).unwrap();
        self.heard()
    }

    /// What the device sends within 5 ms.
    fn heard(&mut self) -> Vec<String> {
        let end = self.now.saturating_add(Duration::from_millis(5));
        while let Some(due) = self.bus.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            self.bus.handle_timeout(self.now);
        }
        self.now = end;
        let heard = std::iter::from_fn(|| self.bus.poll_heard(self.master));
        let text = |frame: Frame| {
            let octets: String = frame.octets().iter().map(|octet| format!("{octet:02X}")).collect();
            format!("{:03X}#{octets}", frame.id().number())
        };
        heard.map(|heard| text(heard.frame)).collect()
    }

    fn wire(&mut self, inputs: f64) -> Vec<String> {
        let change = |node: &mut StoredNode, now| {
            node.act(now, |device, now| {
                device.act(now, &mut |io| io.set_input(now, "inputs", Level::Number(inputs)));
            });
        };
        self.bus.with(self.now, self.device, change).unwrap();
        self.heard()
    }

    fn outputs(&mut self) -> String {
        self.io().face(self.now).to_string()
    }

    /// What it tells of itself.
    fn io(&self) -> &dyn Description {
        self.bus.participant::<StoredNode>(self.device).unwrap().as_device().description()
    }
}

#[test]
fn inputs_go_out_by_tpdo_and_outputs_come_by_rpdo() {
    let mut rig = Rig::new();
    assert_eq!(rig.send(0x605, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]), ["585#4300100091010300"]);
    assert_eq!(rig.wire(3.0), [""; 0], "no process data before it is started");
    assert_eq!(rig.send(0x605, &[0x40, 0, 0x60, 1, 0, 0, 0, 0]), ["585#4F00600103000000"]);
    assert_eq!(rig.send(0x000, &[0x01, 5]), ["185#03"]);
    assert_eq!(rig.wire(129.0), ["185#81"]);
    assert_eq!(rig.wire(129.0), [""; 0], "nothing new");
    assert_eq!(rig.wire(1e9), ["185#FF"], "a number beyond the inputs counts as the nearest");
    assert_eq!(rig.send(0x205, &[0xA5]), [""; 0]);
    assert_eq!(rig.outputs(), "[10100101]");
    let mut values = Vec::new();
    rig.io().each_value(&mut |value| values.push((value.key, matches!(value.amount, Amount::Flag(true)))));
    assert_eq!(values, [("lit", true)]);
    assert_eq!(rig.send(0x605, &[0x40, 0, 0x62, 1, 0, 0, 0, 0]), ["585#4F006201A5000000"]);
}

#[test]
fn outputs_take_their_error_value_when_the_node_is_stopped_and_are_off_after_a_reset() {
    let mut rig = Rig::new();
    assert_eq!(rig.send(0x605, &[0x2F, 0x06, 0x62, 1, 0x0F, 0, 0, 0]), ["585#6006620100000000"]);
    assert_eq!(rig.send(0x605, &[0x2F, 0x07, 0x62, 1, 0xF9, 0, 0, 0]), ["585#6007620100000000"]);
    rig.send(0x000, &[0x01, 5]);
    rig.send(0x205, &[0x36]);
    rig.send(0x000, &[0x02, 5]);
    assert_eq!(rig.outputs(), "[00111001]", "only the low four take part");
    assert_eq!(rig.send(0x000, &[0x81, 5]), ["705#00"]);
    assert_eq!(rig.outputs(), "[00000000]");
    assert_eq!(rig.send(0x605, &[0x40, 0x06, 0x62, 1, 0, 0, 0, 0]), ["585#4F066201FF000000"]);
}

#[test]
fn what_it_does_not_have_is_refused() {
    let mut rig = Rig::new();
    let write = |index: u16, sub| {
        let [low, high] = index.to_le_bytes();
        [0x2F, low, high, sub, 0, 0, 0, 0]
    };
    assert_eq!(rig.send(0x605, &write(0x6000, 1)), ["585#8000600102000106"], "inputs are read-only");
    assert_eq!(rig.send(0x605, &write(0x6200, 2)), ["585#8000620211000906"], "no such sub-index");
    assert_eq!(rig.send(0x605, &write(0x6400, 1)), ["585#8000640100000206"], "no such object");
}

#[test]
fn its_table_agrees_with_itself_and_makes_a_data_sheet() {
    let mut problems = Vec::new();
    check::each_problem(OBJECTS, &mut |problem| problems.push(problem.to_string()));
    assert_eq!(problems, [""; 0]);
    let mut sheet = String::new();
    eds::write(&SHEET, OBJECTS, &mut sheet).unwrap();
    for line in ["ProductName=IO 8/8", "NrOfRXPDO=1", "NrOfTXPDO=1", "[6200sub1]", "BaudRate_500=1"] {
        assert!(sheet.lines().any(|has| has == line), "no '{line}' in\n{sheet}");
    }
}

/// Whitespace does not count: the document indents less.
fn words(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}

#[test]
fn the_document_shows_the_devices_as_they_are_in_less_than_200_lines() {
    let read = |path: &str| fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap();
    let (node, slave) = (read("examples/cia401_io.rs"), read("examples/own_drive.rs"));
    for device in [&node, &slave] {
        assert!(device.lines().count() < 200, "{}", device.lines().count());
    }
    let list = read("src/host/list/mod.rs");
    let document = read("docs/new-device.md");
    let excerpts: Vec<&str> =
        document.split("```rust\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert!(excerpts.len() >= 11, "{}", excerpts.len());
    for excerpt in excerpts {
        let found = [&node, &slave, &list].iter().any(|file| {
            let (file, excerpt) = (words(file), words(excerpt));
            file.windows(excerpt.len()).any(|window| window == excerpt)
        });
        assert!(found, "not in the source as it stands there:\n{excerpt}");
    }
}
