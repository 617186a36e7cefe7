//! Frames of CAN as text of an slcan adapter, both ways, and their bits on the wire; an AG03/1 as a node: an SDO answer, a SYNC
//! up to the last TPDO, a millisecond of 127 nodes that move; the same of AP10 and ASDA-A2, and of all of them mixed; frames
//! in words.
#![allow(clippy::unwrap_used, clippy::std_instead_of_core, reason = "a bench may panic, and has std")]

mod turning;

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use profidrive::can_bus::can::slcan::{Adapter, FrameLine, parse_frame};
use profidrive::can_bus::can::{Frame, Id, timing};
use profidrive::can_bus::canopen::NodeId;
use profidrive::devices::CanopenDevice;
use profidrive::devices::ag03::canopen::{Ag03Node, Config};
use profidrive::time::Instant;
use turning::{Listed, commands, turn_by_hand};

fn frames(criterion: &mut Criterion) {
    let base = Frame::with(Id::base(0x605).unwrap(), [0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0]);
    let extended = Frame::with(Id::extended(0x0605_0001).unwrap(), [0x5A; 8]);
    for (name, frame) in [("base", base), ("extended", extended)] {
        let line = FrameLine::new(&frame, None);
        let text = line.as_octets().split_last().unwrap().1;
        criterion.bench_function(&format!("slcan_decode_{name}"), |bencher| {
            bencher.iter(|| parse_frame(black_box(text)));
        });
        criterion.bench_function(&format!("slcan_encode_{name}"), |bencher| {
            bencher.iter(|| FrameLine::new(black_box(&frame), None));
        });
        criterion.bench_function(&format!("bits_{name}"), |bencher| {
            bencher.iter(|| timing::bits(black_box(&frame)));
        });
        criterion.bench_function(&format!("adapter_{name}"), |bencher| {
            let mut adapter = Adapter::new();
            for octet in b"O\r" {
                adapter.handle_octet(*octet, true);
            }
            bencher.iter(|| {
                let octets = black_box(line.as_octets());
                octets.iter().filter_map(|octet| adapter.handle_octet(*octet, true)).count()
            });
        });
    }
}

/// A node in OPERATIONAL, turning with 60 rpm.
struct Turning {
    now: Instant,
    node: Ag03Node,
}

const SYNC: u16 = 0x080;

impl Turning {
    /// The TPDOs of these objects follow every `kind`-th SYNC; the others are as the factory delivers them.
    fn new(number: u8, objects: &[u16], kind: u8) -> Self {
        let now = Instant::from_millis(1);
        let mut this = Self { now, node: Ag03Node::new(Config::new(NodeId::new(number).unwrap()), now) };
        let sdo = 0x600 + u16::from(number);
        for object in objects {
            let [low, high] = object.to_le_bytes();
            this.data(sdo, &[0x2F, low, high, 2, kind, 0, 0, 0]);
        }
        this.data(sdo, &[0x2F, 0x60, 0x60, 0, 2, 0, 0, 0]);
        this.data(0x000, &[0x01, number]);
        for word in [0x06, 0x07, 0x0F, 0x10F, 0x0F] {
            let [low, high] = u16::to_le_bytes(word);
            this.data(0x500 + u16::from(number), &[low, high, 60, 0, 0, 0]);
        }
        for _ in 0..2000 {
            this.millisecond();
        }
        assert!(this.node.status().travelling, "it turns");
        this
    }

    fn data(&mut self, id: u16, octets: &[u8]) -> usize {
        let frame = Frame::data(Id::base(id).unwrap(), octets).unwrap();
        self.node.handle_frame(self.now, &frame);
        self.drain()
    }

    fn drain(&mut self) -> usize {
        while self.node.poll_event().is_some() {}
        std::iter::from_fn(|| self.node.poll_transmit(self.now)).count()
    }

    /// A SYNC, and everything that is due until the next.
    fn millisecond(&mut self) -> usize {
        let sent = self.data(SYNC, &[]);
        let end = self.now.saturating_add(Duration::from_millis(1));
        while let Some(due) = self.node.poll_timeout().filter(|due| *due <= end) {
            self.now = due;
            self.node.handle_timeout(due);
            self.drain();
        }
        self.now = end;
        sent
    }
}

fn nodes(criterion: &mut Criterion) {
    let mut one = Turning::new(5, &[0x1800, 0x1802, 0x1803], 1);
    criterion.bench_function("node_sdo_answer", |bencher| {
        bencher.iter(|| one.data(0x605, black_box(&[0x40, 0x41, 0x60, 0, 0, 0, 0, 0])));
    });
    assert_eq!(one.data(SYNC, &[]), 3);
    criterion.bench_function("node_sync_to_last_tpdo", |bencher| {
        bencher.iter(|| one.data(SYNC, black_box(&[])));
    });
    criterion.bench_function("node_millisecond", |bencher| bencher.iter(|| one.millisecond()));
    // TPDO 3 with every 20th SYNC and TPDO 1 every 100 ms: four fifths of what a bus of 1 Mbit/s carries.
    let mut all: Vec<Turning> = (1..=127).map(|number| Turning::new(number, &[0x1802], 20)).collect();
    criterion.bench_function("127_nodes_millisecond", |bencher| {
        bencher.iter(|| all.iter_mut().map(Turning::millisecond).sum::<usize>());
    });
    assert!(all.iter().all(|one| one.node.status().travelling), "they turn to the end");
}

/// The other devices alone, and all of them by turns, turning; the same on a bus with arbitration and bit times.
fn listed(criterion: &mut Criterion) {
    use profidrive::host::can::Product;

    for name in ["ap10", "asda-a2"] {
        let mut one = Listed::named(name);
        criterion.bench_function(&format!("{name}_sdo_answer"), |bencher| {
            bencher.iter(|| one.data(0x605, black_box(&[0x40, 0x18, 0x10, 1, 0, 0, 0, 0])));
        });
        assert_eq!(one.data(0x605, &[0x40, 0x18, 0x10, 1, 0, 0, 0, 0]), 1, "{name}");
        assert!(one.data(SYNC, &[]) >= 1, "{name}: a TPDO follows SYNC");
        criterion.bench_function(&format!("{name}_sync_to_last_tpdo"), |bencher| {
            bencher.iter(|| one.data(SYNC, black_box(&[])));
        });
    }
    let turning = |kind| {
        (1..)
            .zip(Product::all().collect::<Vec<_>>().into_iter().cycle())
            .map(move |(n, product)| Listed::turning(product, n, kind))
    };
    let mut three: Vec<Listed> = turning(1).take(3).collect();
    criterion.bench_function("three_devices_sync_to_last_tpdo", |bencher| {
        bencher.iter(|| three.iter_mut().map(|one| one.data(SYNC, black_box(&[]))).sum::<usize>());
    });
    let mut all: Vec<Listed> = turning(20).take(127).collect();
    criterion.bench_function("127_mixed_nodes_millisecond", |bencher| {
        bencher.iter(|| all.iter_mut().map(Listed::millisecond).sum::<usize>());
    });
    let mut bus = OnBus::new(127, 20);
    criterion
        .bench_function("bus_of_127_mixed_nodes_millisecond", |bencher| bencher.iter(|| bus.millisecond()));
}

/// Devices on a bus of 1 Mbit/s, and a master that sends SYNC and hears everything.
struct OnBus {
    now: Instant,
    bus: profidrive::host::can::Bus<profidrive::devices::CanopenEvent>,
    master: profidrive::host::can::Seat,
}

impl OnBus {
    /// So many devices by turns, turning.
    fn new(count: usize, kind: u8) -> Self {
        use profidrive::can_bus::can::BitRate;
        use profidrive::can_bus::canopen::node::storage::Eeprom;
        use profidrive::host::can::{Bus, Product, StoredNode};
        use profidrive::host::list::Choices;

        let now = Instant::from_millis(1);
        let mut bus = Bus::new(BitRate::K1000);
        let master = bus.connect(now);
        let mut this = Self { now, bus, master };
        for (number, product) in (1..).zip(Product::all().collect::<Vec<_>>().into_iter().cycle()).take(count)
        {
            let node = NodeId::new(number).unwrap();
            let device = product.make(node, &Choices::default(), Eeprom::Internal, this.now);
            let mut stored = StoredNode::new(device, this.now);
            // On a bus at another rate than its own it would be silent.
            stored.set_rate(this.now, BitRate::K1000);
            stored.act(this.now, turn_by_hand);
            this.bus.add(this.now, Box::new(stored));
            this.millisecond();
            for (id, octets) in commands(product.name, number, kind) {
                let frame = Frame::data(Id::base(id).unwrap(), &octets).unwrap();
                this.bus.send(this.now, this.master, frame).unwrap();
                this.millisecond();
            }
        }
        let heard: usize = (0..100).map(|_| this.millisecond()).sum();
        assert!(heard >= count * 100 / usize::from(kind), "{heard} frames in 100 ms");
        this
    }

    fn millisecond(&mut self) -> usize {
        let end = self.now.saturating_add(Duration::from_millis(1));
        let sync = Frame::data(Id::base(SYNC).unwrap(), &[]).unwrap();
        self.bus.send(self.now, self.master, sync).unwrap();
        self.bus.handle_timeout(end);
        self.now = end;
        while self.bus.poll_event().is_some() {}
        std::iter::from_fn(|| self.bus.poll_heard(self.master)).count()
    }
}

fn words(criterion: &mut Criterion) {
    use profidrive::devices::ag03::canopen::VOCABULARY;
    use profidrive::explain::canopen::Network;

    let mut network = Network::of(&VOCABULARY);
    let frame = Frame::with(Id::base(0x385).unwrap(), [0x37, 0x02, 0x40, 0x1F, 0, 0]);
    criterion.bench_function("frame_in_words", |bencher| bencher.iter(|| network.frame(black_box(&frame))));
}

/// 127 nodes from a file of 1000 entries: their start, an SDO answer, a SYNC, and a millisecond of all of them.
fn from_files(criterion: &mut Criterion) {
    use profidrive::devices::from_eds::Dictionary;
    use profidrive::eds::Eds;
    use turning::FILE;

    let dictionary = Dictionary::hold(Eds::read(FILE).unwrap());
    let start = || (1..=127).map(|number| Listed::from_file(dictionary, number)).collect::<Vec<_>>();
    criterion.bench_function("eds_file", |bencher| bencher.iter(|| Eds::read(black_box(FILE)).unwrap()));
    criterion.bench_function("127_eds_nodes_start", |bencher| bencher.iter(start));
    let mut all = start();
    for (number, one) in (1..).zip(&mut all) {
        for (id, octets) in commands("asda-a2", number, if number == 5 { 1 } else { 20 }) {
            one.data(id, &octets);
        }
    }
    let one = all.get_mut(4).unwrap();
    criterion.bench_function("eds_node_sdo_answer", |bencher| {
        bencher.iter(|| one.data(0x605, black_box(&[0x40, 0x18, 0x10, 1, 0, 0, 0, 0])));
    });
    assert_eq!(one.data(SYNC, &[]), 1);
    criterion.bench_function("eds_node_sync_to_last_tpdo", |bencher| {
        bencher.iter(|| one.data(SYNC, black_box(&[])));
    });
    criterion.bench_function("127_eds_nodes_millisecond", |bencher| {
        bencher.iter(|| all.iter_mut().map(Listed::millisecond).sum::<usize>());
    });
}

criterion_group!(benches, frames, nodes, listed, from_files, words);
criterion_main!(benches);
