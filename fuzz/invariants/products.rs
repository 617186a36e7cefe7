//! A device of the list on CANopen: any frames, times, inputs, keys, faults, power and images. No request of SDO has two
//! answers, the deadline moves on, and a new device that recalls an image keeps the same, unless 1011h has left something for
//! the next reset.
//!
//! ```text
//! which device of the list (1)
//! then 00..=3f  frame: identifier (which of those that the node hears; from 20 on a remote frame), length, data
//!      40..=5f  time passes: milliseconds (1), from 50 on a hundred times as much
//!      60..=67  an input: which (1), value (1)
//!      68..=6b  a key: which and whether it is pressed (1)
//!      6c..=6f  a fault is provoked: which (1)
//!      70..=77  switched off and on
//!      78..=7f  an image is kept, from 7c on refused
//!      80..     the state of the CAN controller
//! ```

use std::time::Duration;

use profidrive::can_bus::can::{ErrorState, Frame, Id};
use profidrive::can_bus::canopen::NodeId;
use profidrive::can_bus::canopen::node::storage::{Eeprom, NotStored};
use profidrive::devices::CanopenDevice;
use profidrive::face::surroundings::{InputKind, Level};
use profidrive::host::can::Product;
use profidrive::host::list::Choices;
use profidrive::time::Instant;

const NODE: u8 = 5;
const HEARD: [u16; 12] = [0x605, 0x000, 0x080, 0x205, 0x305, 0x405, 0x505, 0x705, 0x185, 0x7E5, 0x100, 0x07F];
/// Time passes in steps of a drive's cycle: the fuzzer need not wait for minutes of it.
const MOST_TIMEOUTS: usize = 400;

pub(crate) fn check(data: &[u8]) {
    let Some((&which, mut rest)) = data.split_first() else { return };
    let products: Vec<_> = Product::all().collect();
    let mut rig = Rig::of(products[usize::from(which) % products.len()]);
    for _ in 0..200 {
        let Some(behind) = rig.step(rest) else { break };
        rest = behind;
    }
    rig.keep(true);
}

struct Rig {
    now: Instant,
    timeouts: usize,
    product: &'static Product,
    device: Box<dyn CanopenDevice>,
    /// 1011h was written: the next reset changes what is kept, a node number too.
    defaults_asked: bool,
}

fn made(product: &Product) -> Box<dyn CanopenDevice> {
    let node = NodeId::new(NODE).expect("1 to 127");
    product.make(node, &Choices::default(), Eeprom::Host, Instant::ZERO)
}

impl Rig {
    fn of(product: &'static Product) -> Self {
        let mut rig =
            Self { now: Instant::ZERO, timeouts: 0, product, device: made(product), defaults_asked: false };
        rig.device.power_on(rig.now);
        rig.drain();
        rig
    }

    fn step<'a>(&mut self, steps: &'a [u8]) -> Option<&'a [u8]> {
        let (&kind, rest) = steps.split_first()?;
        match kind {
            0x00..=0x3F => {
                let (&len, rest) = rest.split_first()?;
                let (octets, rest) = rest.split_at_checked(usize::from(len % 9))?;
                self.frame(kind, octets);
                return Some(rest);
            }
            0x40..=0x5F => {
                let (&count, rest) = rest.split_first()?;
                self.pass(Duration::from_millis(u64::from(count) * if kind < 0x50 { 1 } else { 100 }));
                return Some(rest);
            }
            0x60..=0x6F => {
                let ([which, value], rest) = rest.split_first_chunk()?;
                self.surround(kind, usize::from(*which), *value);
                return Some(rest);
            }
            0x70..=0x77 => {
                self.device.power_off(self.now);
                assert!(self.device.poll_transmit(self.now).is_none(), "it speaks without supply");
                self.device.power_on(self.now);
                self.drain();
            }
            0x78..=0x7F => self.keep(kind < 0x7C),
            0x80.. => {
                let states = [ErrorState::Active, ErrorState::Passive, ErrorState::BusOff];
                let [from, to] = [kind >> 2, kind].map(|number| states[usize::from(number % 4).min(2)]);
                self.device.handle_error_state(self.now, from, to);
                self.drain();
            }
        }
        Some(rest)
    }

    fn frame(&mut self, kind: u8, octets: &[u8]) {
        let id = Id::base(HEARD[usize::from(kind % 0x20) % HEARD.len()]).expect("of 11 bits");
        self.defaults_asked |= matches!(octets, [_, 0x11, 0x10, ..]);
        let frame = if kind < 0x20 {
            Frame::data(id, octets)
        } else {
            Frame::remote(id, u8::try_from(octets.len()).expect("8 at most"))
        };
        self.device.handle_frame(self.now, &frame.expect("8 octets at most"));
        let answers = self.drain();
        // Segments of a block come one behind the other.
        let of_a_block = octets.first().is_some_and(|command| command >> 5 == 5);
        assert!(answers <= 1 || of_a_block, "{answers} answers to {octets:02X?}");
    }

    fn pass(&mut self, time: Duration) {
        let end = self.now.saturating_add(time);
        while self.timeouts < MOST_TIMEOUTS {
            let Some(due) = self.device.poll_timeout().filter(|due| *due <= end) else { break };
            self.timeouts += 1;
            self.now = self.now.max(due);
            self.device.handle_timeout(self.now);
            self.drain();
            assert!(self.device.poll_timeout().is_none_or(|next| next > self.now), "nothing moves on");
        }
        if self.timeouts < MOST_TIMEOUTS {
            self.now = end;
        }
    }

    fn surround(&mut self, kind: u8, which: usize, value: u8) {
        let now = self.now;
        self.device.act(now, &mut |device| {
            let (mut inputs, mut keys, mut faults) = (Vec::new(), Vec::new(), Vec::new());
            match kind {
                ..=0x67 => device.each_input(&mut |input, _| {
                    inputs.push((input.name, matches!(input.kind, InputKind::Switch)));
                }),
                0x68..=0x6B => device.each_key(&mut |key, _| keys.push(key)),
                0x6C.. => device.each_fault(&mut |fault| faults.push(fault.name.to_string())),
            }
            if let Some((name, is_switch)) = inputs.get(which % inputs.len().max(1)) {
                let number = f64::from(value.cast_signed()) * if value & 1 == 1 { 1e3 } else { 1.0 };
                let level = if *is_switch { Level::Switch(value & 1 == 1) } else { Level::Number(number) };
                device.set_input(now, name, level);
            }
            if let Some(key) = keys.get(which % keys.len().max(1)) {
                // Not without supply.
                let _ = device.press(now, key, value & 1 == 1);
            }
            if let Some(fault) = faults.get(which % faults.len().max(1)) {
                // Not without supply.
                let _ = device.provoke(now, fault);
            }
        });
        self.drain();
    }

    /// What it offers to keep, is kept or refused. A new device takes what was kept, and keeps the same.
    fn keep(&mut self, stored: bool) {
        let mut image = vec![0; 16_384];
        let Ok(Some(request)) = self.device.poll_image(&mut image) else { return };
        let (generation, length) = (request.generation, request.octets.len());
        self.device.handle_stored(self.now, generation, if stored { Ok(()) } else { Err(NotStored) });
        self.drain();
        if stored {
            image.truncate(length);
            let once = self.recalled(&image);
            assert!(self.defaults_asked || once == image, "what was kept is kept: {image:02X?}, {once:02X?}");
        }
    }

    /// What a new device keeps that was switched on with this image.
    fn recalled(&self, image: &[u8]) -> Vec<u8> {
        let mut again = made(self.product);
        again.recall(Instant::ZERO, image).expect("its own image");
        again.offer_image();
        again.power_on(Instant::ZERO);
        let mut buffer = vec![0; 16_384];
        let offered = again.poll_image(&mut buffer).expect("it fits").expect("it is offered");
        offered.octets.to_vec()
    }

    /// Takes what it sends; gives how many answers of SDO there are.
    fn drain(&mut self) -> usize {
        let mut answers = 0;
        while let Some(frame) = self.device.poll_transmit(self.now) {
            answers += usize::from(frame.id().number() == 0x580 + u32::from(NODE));
        }
        while self.device.poll_event().is_some() {}
        self.device.act(self.now, &mut |device| while device.poll_news().is_some() {});
        answers
    }
}
