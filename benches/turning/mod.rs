//! Nodes that turn and send a TPDO after SYNC, for the benches of CAN.
#![allow(dead_code, reason = "each bench uses a part")]

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::can_bus::canopen::{Address, NodeId};
use profidrive::devices::CanopenDevice;
use profidrive::devices::from_eds::{Dictionary, FromEds};
use profidrive::eds::Eds;
use profidrive::face::surroundings::Level;
use profidrive::host::can::Product;
use profidrive::host::list::Choices;
use profidrive::time::Instant;

pub(crate) const SYNC: u16 = 0x080;

/// A drive, and a file of 1000 entries.
pub(crate) const FILE: &[u8] = include_bytes!("../../tests/eds/asda-a2.eds");

/// A device of the list in OPERATIONAL, whichever it is; its TPDOs as the list below has them.
pub(crate) struct Listed {
    pub(crate) now: Instant,
    pub(crate) device: Box<dyn CanopenDevice>,
}

impl Listed {
    /// Switched on and turning with 60 rpm.
    pub(crate) fn turning(product: &Product, number: u8, kind: u8) -> Self {
        let now = Instant::from_millis(1);
        let node = NodeId::new(number).unwrap();
        let device = product.make(node, &Choices::default(), Eeprom::Internal, now);
        let mut this = Self { now, device };
        this.device.power_on(now);
        this.drain();
        turn_by_hand(&mut *this.device, now);
        for (id, octets) in commands(product.name, number, kind) {
            this.data(id, &octets);
        }
        (0..2000).for_each(|_| _ = this.millisecond());
        let before = position(&*this.device);
        (0..100).for_each(|_| _ = this.millisecond());
        assert_ne!(position(&*this.device), before, "{}: it turns", product.name);
        this
    }

    /// A drive from that file, switched on.
    pub(crate) fn from_file(dictionary: &'static Dictionary, number: u8) -> Self {
        let now = Instant::from_millis(1);
        let device = FromEds::on_node(dictionary, NodeId::new(number).unwrap(), Eeprom::Internal);
        let mut this = Self { now, device: Box::new(device) };
        this.device.power_on(now);
        assert_eq!(this.drain(), 1, "its boot-up");
        this
    }

    /// The device with that name, or for `eds` the drive from [`FILE`], at node 5: a TPDO follows each SYNC.
    pub(crate) fn named(name: &str) -> Self {
        let Some(product) = Product::named(name) else {
            let mut this = Self::from_file(Dictionary::hold(Eds::read(FILE).unwrap()), 5);
            for (id, octets) in commands("asda-a2", 5, 1) {
                this.data(id, &octets);
            }
            return this;
        };
        Self::turning(product, 5, 1)
    }

    pub(crate) fn data(&mut self, id: u16, octets: &[u8]) -> usize {
        let frame = Frame::data(Id::base(id).unwrap(), octets).unwrap();
        self.device.handle_frame(self.now, &frame);
        self.drain()
    }

    pub(crate) fn drain(&mut self) -> usize {
        while self.device.poll_event().is_some() {}
        std::iter::from_fn(|| self.device.poll_transmit(self.now)).count()
    }

    /// A SYNC, and everything that is due until the next.
    pub(crate) fn millisecond(&mut self) -> usize {
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

/// What a master sends so that a device sends a TPDO after every `kind`-th SYNC and turns with 60 rpm: TPDO 2 of an AP10,
/// TPDO 3 of an AG03/1, TPDO 1 of an ASDA-A2 with 6041h and 6064h.
pub(crate) fn commands(product: &str, number: u8, kind: u8) -> Vec<(u16, Vec<u8>)> {
    let sdo = |octets: [u8; 8]| (0x600 + u16::from(number), octets.to_vec());
    let start = (0x000, vec![0x01, number]);
    match product {
        "ap10" => vec![sdo([0x2F, 0x01, 0x18, 2, kind, 0, 0, 0]), start],
        "ag03-1" => {
            let mut frames = vec![
                sdo([0x2F, 0x02, 0x18, 2, kind, 0, 0, 0]),
                // Velocity mode.
                sdo([0x2F, 0x60, 0x60, 0, 2, 0, 0, 0]),
                start,
            ];
            for word in [0x06, 0x07, 0x0F, 0x10F, 0x0F] {
                let [low, high] = u16::to_le_bytes(word);
                frames.push((0x500 + u16::from(number), vec![low, high, 60, 0, 0, 0]));
            }
            frames
        }
        _ => {
            let mut frames = vec![
                sdo([0x23, 0x00, 0x18, 1, 0x80 + number, 0x01, 0, 0x80]),
                sdo([0x2F, 0x00, 0x1A, 0, 0, 0, 0, 0]),
                sdo([0x23, 0x00, 0x1A, 1, 0x10, 0, 0x41, 0x60]),
                sdo([0x23, 0x00, 0x1A, 2, 0x20, 0, 0x64, 0x60]),
                sdo([0x2F, 0x00, 0x1A, 0, 2, 0, 0, 0]),
                sdo([0x2F, 0x00, 0x18, 2, kind, 0, 0, 0]),
                sdo([0x23, 0x00, 0x18, 1, 0x80 + number, 0x01, 0, 0]),
                // Profile velocity.
                sdo([0x2F, 0x60, 0x60, 0, 3, 0, 0, 0]),
                start,
            ];
            frames.extend([0x06, 0x07, 0x0F].map(|word| sdo([0x2B, 0x40, 0x60, 0, word, 0, 0, 0])));
            // 60 rpm.
            frames.push(sdo([0x23, 0xFF, 0x60, 0, 0x58, 0x02, 0, 0]));
            frames
        }
    }
}

/// The shaft of what has no drive.
pub(crate) fn turn_by_hand(device: &mut dyn CanopenDevice, now: Instant) {
    if !device.description().is_drive() {
        device.act(now, &mut |description| description.set_input(now, "shaft_rpm", Level::Number(60.0)));
    }
}

/// 6064h or 6004h.
fn position(device: &dyn CanopenDevice) -> Vec<u8> {
    let at = Address::new(if device.description().is_drive() { 0x6064 } else { 0x6004 }, 0);
    device.node().read_with(at, device.application(), |octets| Ok(octets.to_vec())).unwrap()
}
