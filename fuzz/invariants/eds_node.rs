//! A node from a file, whatever frames come: what an entry says has the octets of its type, a value that is taken is the one
//! that is read, and no request has two answers.
//!
//! ```text
//! 0..=3f  frame: identifier (which of those that the node hears), data (length, octets)
//! 40..=5f time passes: milliseconds (1)
//! 60..=6f an input: which, value
//! 70      switched off and on
//! ```

use std::sync::OnceLock;
use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::can_bus::canopen::{Address, NodeId};
use profidrive::devices::from_eds::{Dictionary, FromEds};
use profidrive::devices::{CanopenDevice, PlainNode};
use profidrive::eds::Eds;
use profidrive::face::surroundings::Level;
use profidrive::time::Instant;

const HEARD: [u16; 6] = [0x605, 0x000, 0x080, 0x205, 0x705, 0x185];
const INPUTS: [&str; 2] = ["2001h", "2002h"];

pub(crate) fn check(data: &[u8]) {
    static DICTIONARY: OnceLock<&'static Dictionary> = OnceLock::new();
    let dictionary = *DICTIONARY.get_or_init(|| {
        let mut eds = Eds::read(include_bytes!("../../tests/eds/pump.eds")).expect("it is an EDS");
        eds.complete();
        Dictionary::hold(eds)
    });
    let device = FromEds::on_node(dictionary, NodeId::new(5).expect("1 to 127"), Eeprom::Internal);
    let mut rig = Rig { now: Instant::ZERO, device };
    rig.device.power_on(rig.now);
    rig.drain();
    let mut rest = data;
    for _ in 0..500 {
        let Some(behind) = rig.step(rest) else { break };
        rest = behind;
    }
    for object in dictionary.objects {
        for entry in object.entries {
            let at = Address { index: object.index, sub: entry.sub };
            let read = rig.device.node().read_with(at, rig.device.application(), |octets| Ok(octets.len()));
            if let (Some(expected), Ok(len)) = (entry.data.octets(), read) {
                assert_eq!(len, expected, "{at}");
            }
        }
    }
}

struct Rig {
    now: Instant,
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
                let frame = Frame::data(id, octets).expect("up to 8 octets");
                self.device.handle_frame(self.now, &frame);
                let answers = self.drain();
                assert!(
                    answers <= 1 || octets.first().is_some_and(|command| command >> 5 == 5),
                    "{answers} answers"
                );
                Some(rest)
            }
            0x40..=0x5F => {
                let (&millis, rest) = rest.split_first()?;
                let end = self.now.saturating_add(Duration::from_millis(millis.into()));
                for _ in 0..1000 {
                    let Some(due) = self.device.poll_timeout().filter(|due| *due <= end) else { break };
                    self.now = self.now.max(due);
                    self.device.handle_timeout(self.now);
                    self.drain();
                }
                self.now = end;
                Some(rest)
            }
            0x60..=0x6F => {
                let (&value, rest) = rest.split_first()?;
                let (now, name) = (self.now, INPUTS[usize::from(kind) % INPUTS.len()]);
                self.device.act(now, &mut |device| {
                    device.set_input(now, name, Level::Number(f64::from(value) * 1e6))
                });
                self.drain();
                Some(rest)
            }
            0x70.. => {
                self.device.power_off(self.now);
                self.device.power_on(self.now);
                self.drain();
                Some(rest)
            }
        }
    }

    /// Takes what it sends; says how many answers of SDO there are.
    fn drain(&mut self) -> usize {
        let mut answers = 0;
        while let Some(frame) = self.device.poll_transmit(self.now) {
            answers += usize::from(frame.id().number() == 0x585);
        }
        while self.device.poll_event().is_some() {}
        answers
    }
}
