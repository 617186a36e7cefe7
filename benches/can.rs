//! Frames of CAN as text of an slcan adapter, both ways, and their bits on the wire; an AG03/1 as a node: an SDO answer, a SYNC
//! up to the last TPDO, a millisecond of 127 nodes that move; the same of AP10 and ASDA-A2, and of all of them mixed; frames
//! in words.
#![allow(clippy::unwrap_used, clippy::std_instead_of_core, reason = "a bench may panic, and has std")]

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use profidrive::can::slcan::{Adapter, FrameLine, parse_frame};
use profidrive::can::{Frame, Id, timing};
use profidrive::canopen::NodeId;
use profidrive::device::ag03_canopen::{Ag03Node, Config};
use profidrive::time::Instant;

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
                adapter.receive(*octet, true);
            }
            bencher.iter(|| {
                let octets = black_box(line.as_octets());
                octets.iter().filter_map(|octet| adapter.receive(*octet, true)).count()
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

/// A device of the list in OPERATIONAL, whichever it is; its TPDOs as the list below has them.
#[cfg(feature = "std")]
struct Listed {
    now: Instant,
    device: Box<dyn profidrive::device::CanopenDevice>,
}

#[cfg(feature = "std")]
impl Listed {
    /// `requests` are SDO writes before the start.
    fn new(product: &profidrive::host::can::Product, number: u8, requests: &[[u8; 8]]) -> Self {
        use profidrive::canopen::storage::Memory;
        use profidrive::host::can::Choices;

        let now = Instant::from_millis(1);
        let node = NodeId::new(number).unwrap();
        let device = product.make(node, Choices::default(), Memory::Internal, now);
        let mut this = Self { now, device };
        this.device.power_on(now);
        this.drain();
        for request in requests {
            assert_eq!(this.data(0x600 + u16::from(number), request), 1);
        }
        this.data(0x000, &[0x01, number]);
        this
    }

    fn data(&mut self, id: u16, octets: &[u8]) -> usize {
        let frame = Frame::data(Id::base(id).unwrap(), octets).unwrap();
        self.device.handle_frame(self.now, &frame);
        self.drain()
    }

    fn drain(&mut self) -> usize {
        while self.device.poll_event().is_some() {}
        std::iter::from_fn(|| self.device.poll_transmit(self.now)).count()
    }

    /// A SYNC, and everything that is due until the next.
    fn millisecond(&mut self) -> usize {
        let sent = self.data(SYNC, &[]);
        let end = self.now.saturating_add(Duration::from_millis(1));
        while let Some(due) = self.device.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            self.device.handle_timeout(self.now);
            self.drain();
        }
        self.now = end;
        sent
    }
}

/// The other devices alone, and all of them by turns.
#[cfg(feature = "std")]
fn listed(criterion: &mut Criterion) {
    use profidrive::host::can::{PRODUCTS, Product};

    // After every SYNC TPDO 2 of the AP10 as it is; TPDO 1 of the ASDA-A2 with 6041h and 6064h, which has no mapping at first.
    let indicator: &[[u8; 8]] = &[[0x2F, 0x01, 0x18, 2, 1, 0, 0, 0]];
    let servo: &[[u8; 8]] = &[
        [0x23, 0x00, 0x18, 1, 0x85, 0x01, 0, 0x80],
        [0x2F, 0x00, 0x1A, 0, 0, 0, 0, 0],
        [0x23, 0x00, 0x1A, 1, 0x10, 0, 0x41, 0x60],
        [0x23, 0x00, 0x1A, 2, 0x20, 0, 0x64, 0x60],
        [0x2F, 0x00, 0x1A, 0, 2, 0, 0, 0],
        [0x2F, 0x00, 0x18, 2, 1, 0, 0, 0],
        [0x23, 0x00, 0x18, 1, 0x85, 0x01, 0, 0],
    ];
    for (name, requests) in [("ap10", indicator), ("asda-a2", servo)] {
        let mut one = Listed::new(Product::named(name).unwrap(), 5, requests);
        criterion.bench_function(&format!("{name}_sdo_answer"), |bencher| {
            bencher.iter(|| one.data(0x605, black_box(&[0x40, 0x18, 0x10, 1, 0, 0, 0, 0])));
        });
        assert_eq!(one.data(0x605, &[0x40, 0x18, 0x10, 1, 0, 0, 0, 0]), 1, "{name}");
        assert!(one.data(SYNC, &[]) >= 1, "{name}: a TPDO follows SYNC");
        criterion.bench_function(&format!("{name}_sync_to_last_tpdo"), |bencher| {
            bencher.iter(|| one.data(SYNC, black_box(&[])));
        });
    }
    let mut all: Vec<Listed> =
        (1..=127).zip(PRODUCTS.iter().cycle()).map(|(n, product)| Listed::new(product, n, &[])).collect();
    criterion.bench_function("127_mixed_nodes_millisecond", |bencher| {
        bencher.iter(|| all.iter_mut().map(Listed::millisecond).sum::<usize>());
    });
}

#[cfg(not(feature = "std"))]
fn listed(_: &mut Criterion) {}

#[cfg(feature = "std")]
fn words(criterion: &mut Criterion) {
    use profidrive::device::ag03_canopen::VOCABULARY;
    use profidrive::explain::canopen::Network;

    let mut network = Network::of(&VOCABULARY);
    let frame = Frame::with(Id::base(0x385).unwrap(), [0x37, 0x02, 0x40, 0x1F, 0, 0]);
    criterion.bench_function("frame_in_words", |bencher| bencher.iter(|| network.frame(black_box(&frame))));
}

#[cfg(not(feature = "std"))]
fn words(_: &mut Criterion) {}

criterion_group!(benches, frames, nodes, listed, words);
criterion_main!(benches);
