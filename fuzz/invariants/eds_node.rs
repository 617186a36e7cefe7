//! A node from a file, whatever frames come: what an entry says has the octets of its type, a number that a node without a
//! profile takes is the one that is read, and no request has two answers.
//!
//! ```text
//! 0..=3f  frame: identifier (which of those that the node hears; from 20 on a remote frame), data (length, octets)
//! 40..=5f time passes: milliseconds (1)
//! 60..=67 an input: which, value
//! 68..=6f a fault is provoked: which
//! 70..=7f switched off and on
//! 80..    from here on another node, as it is after it was switched on: of which file
//! ```

use std::sync::OnceLock;
use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::can_bus::canopen::{Address, NodeId};
use profidrive::devices::from_eds::{Dictionary, FromEds};
use profidrive::devices::{CanopenDevice, PlainNode};
use profidrive::eds::Eds;
use profidrive::face::surroundings::{InputKind, Level};
use profidrive::time::Instant;

const HEARD: [u16; 8] = [0x605, 0x000, 0x080, 0x205, 0x705, 0x185, 0x7E5, 0x305];
/// A memory, a drive, inputs and outputs, an encoder, a drive with two axes.
const FILES: [&[u8]; 5] = [
    include_bytes!("../../tests/eds/pump.eds"),
    include_bytes!("../../tests/eds/servo.dcf"),
    include_bytes!("../../tests/eds/terminal.eds"),
    include_bytes!("../../tests/eds/encoder.eds"),
    include_bytes!("../../tests/eds/two-axes.eds"),
];
/// A producer of SYNC is due each 100 µs.
const MOST_TIMEOUTS: usize = 1000;

pub(crate) fn check(data: &[u8]) {
    let mut rig = Rig { now: Instant::ZERO, timeouts: 0, model: model(0), device: model(0).device.clone() };
    let mut rest = data;
    for _ in 0..500 {
        let Some(behind) = rig.step(rest) else { break };
        rest = behind;
    }
    rig.check_entries(data.len());
}

/// A node that was switched on. It is made once: what an input costs is what it does.
struct Model {
    dictionary: &'static Dictionary,
    device: PlainNode<FromEds>,
    inputs: Vec<(&'static str, bool)>,
    faults: Vec<String>,
}

fn model(number: usize) -> &'static Model {
    static MODELS: [OnceLock<Model>; FILES.len()] = [const { OnceLock::new() }; FILES.len()];
    let number = number % FILES.len();
    MODELS[number].get_or_init(|| Model::of(FILES[number]))
}

impl Model {
    fn of(file: &[u8]) -> Self {
        let mut eds = Eds::read(file).expect("it is an EDS");
        eds.complete();
        let dictionary = Dictionary::hold(eds);
        let mut device = FromEds::on_node(dictionary, NodeId::new(5).expect("1 to 127"), Eeprom::Internal);
        device.power_on(Instant::ZERO);
        drain(&mut device, Instant::ZERO);
        let (mut inputs, mut faults) = (Vec::new(), Vec::new());
        device.description().each_input(&mut |input, _| {
            inputs.push((input.name, matches!(input.kind, InputKind::Switch)));
        });
        device.description().each_fault(&mut |fault| faults.push(fault.name.to_string()));
        Self { dictionary, device, inputs, faults }
    }
}

struct Rig {
    now: Instant,
    timeouts: usize,
    model: &'static Model,
    device: PlainNode<FromEds>,
}

impl Rig {
    fn step<'a>(&mut self, steps: &'a [u8]) -> Option<&'a [u8]> {
        let (&kind, rest) = steps.split_first()?;
        match kind {
            0x00..=0x3F => {
                let (&len, rest) = rest.split_first()?;
                let (octets, rest) = rest.split_at_checked(usize::from(len % 9))?;
                let id = Id::base(HEARD[usize::from(kind) % HEARD.len()]).expect("of 11 bits");
                let frame = if kind < 0x20 { Frame::data(id, octets) } else { Frame::remote(id, len % 9) };
                self.device.handle_frame(self.now, &frame.expect("up to 8 octets"));
                let (answers, taken) = drain(&mut self.device, self.now);
                assert!(
                    answers <= 1 || octets.first().is_some_and(|command| command >> 5 == 5),
                    "{answers} answers"
                );
                self.check_taken(octets, taken);
                Some(rest)
            }
            0x40..=0x5F => {
                let (&millis, rest) = rest.split_first()?;
                let end = self.now.saturating_add(Duration::from_millis(millis.into()));
                while self.timeouts < MOST_TIMEOUTS {
                    let Some(due) = self.device.poll_timeout().filter(|due| *due <= end) else { break };
                    self.timeouts += 1;
                    self.now = self.now.max(due);
                    self.device.handle_timeout(self.now);
                    drain(&mut self.device, self.now);
                }
                self.now = end;
                Some(rest)
            }
            0x60..=0x6F => {
                let (&value, rest) = rest.split_first()?;
                let (now, number) = (self.now, usize::from(kind % 8));
                let Model { inputs, faults, .. } = self.model;
                let input = inputs.get(number % inputs.len().max(1)).filter(|_| kind < 0x68);
                let fault = faults.get(usize::from(value) % faults.len().max(1)).filter(|_| kind >= 0x68);
                self.device.act(now, &mut |device| {
                    if let Some((name, is_switch)) = input {
                        let level = if *is_switch {
                            Level::Switch(value & 1 == 1)
                        } else {
                            Level::Number(f64::from(value) * 1e6)
                        };
                        device.set_input(now, name, level);
                    }
                    if let Some(fault) = fault {
                        device.provoke(now, fault).expect("it is in the list and the node is on");
                    }
                });
                drain(&mut self.device, self.now);
                Some(rest)
            }
            0x70..=0x7F => {
                self.device.power_off(self.now);
                self.device.power_on(self.now);
                drain(&mut self.device, self.now);
                Some(rest)
            }
            0x80.. => {
                self.check_entries(rest.len());
                self.model = model(kind.into());
                self.device = self.model.device.clone();
                self.now = Instant::ZERO;
                Some(rest)
            }
        }
    }

    /// The number of a download of one frame, if `taken` says it was taken.
    fn check_taken(&self, request: &[u8], taken: Option<[u8; 4]>) {
        let Some([0x60, a, b, sub]) = taken else { return };
        let at = Address::new(u16::from_le_bytes([a, b]), sub);
        if let [0x23 | 0x27 | 0x2B | 0x2F, c, d, e, data @ ..] = request
            && [*c, *d, *e] == [a, b, sub]
            && at.index.0 >= 0x2000
            && core::ptr::eq(self.model, model(0))
        {
            let read = self
                .device
                .node()
                .read_with(at, self.device.application(), |octets| Ok(data.starts_with(octets)));
            // What can only be written has no value to read.
            assert!(read != Ok(false), "{at} is not what was written");
        }
    }

    /// An eighth of the objects: all of them take longer than everything else.
    fn check_entries(&self, which: usize) {
        for object in self.model.dictionary.objects.iter().skip(which % 8).step_by(8) {
            for entry in object.entries {
                let Some(expected) = entry.data.octets() else { continue };
                let at = Address { index: object.index, sub: entry.sub };
                let read =
                    self.device.node().read_with(at, self.device.application(), |octets| Ok(octets.len()));
                assert!(read.is_err() || read == Ok(expected), "{at}: {read:?}");
            }
        }
    }
}

/// Takes what it sends; says how many answers of SDO there are, and how the last one begins.
fn drain(device: &mut PlainNode<FromEds>, now: Instant) -> (usize, Option<[u8; 4]>) {
    let mut answers = 0;
    let mut last = None;
    while let Some(frame) = device.poll_transmit(now) {
        if frame.id().number() == 0x585 {
            answers += 1;
            last = frame.octets().first_chunk().copied();
        }
    }
    while device.poll_event().is_some() {}
    (answers, last)
}
