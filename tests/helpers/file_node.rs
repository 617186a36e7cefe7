//! A node that a file describes, and a master's requests to it.
#![cfg(feature = "eds")]

use std::fs;
use std::path::Path;
use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::NodeId;
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::devices::from_eds::{Dictionary, FromEds};
use profidrive::devices::{CanopenDevice, PlainNode};
use profidrive::eds::Eds;
use profidrive::face::surroundings::Level;
use profidrive::time::Instant;

pub(crate) const NODE: u8 = 5;

pub(crate) struct Rig {
    pub(crate) now: Instant,
    pub(crate) device: PlainNode<FromEds>,
}

impl Rig {
    pub(crate) fn of(dictionary: &'static Dictionary) -> Self {
        let node = NodeId::new(NODE).unwrap();
        let device = FromEds::on_node(dictionary, node, Eeprom::Internal);
        let mut rig = Self { now: Instant::from_millis(1), device };
        rig.device.power_on(rig.now);
        assert_eq!(rig.drain(), ["705#00"]);
        rig
    }

    pub(crate) fn text(text: &str) -> Self {
        let mut eds = Eds::read(text.as_bytes()).unwrap();
        eds.complete();
        Self::of(Dictionary::hold(eds))
    }

    pub(crate) fn file(name: &str) -> Self {
        Self::of(held(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/eds").join(name)))
    }

    pub(crate) fn drain(&mut self) -> Vec<String> {
        let mut seen = Vec::new();
        while let Some(frame) = self.device.poll_transmit(self.now) {
            seen.push(frame.to_string().replace(' ', ""));
        }
        while self.device.poll_event().is_some() {}
        seen
    }

    pub(crate) fn data(&mut self, id: u16, octets: &[u8]) -> Vec<String> {
        let frame = Frame::data(Id::base(id).unwrap(), octets).unwrap();
        self.device.handle_frame(self.now, &frame);
        self.drain()
    }

    pub(crate) fn start(&mut self) -> Vec<String> {
        self.data(0, &[1, NODE])
    }

    pub(crate) fn sync(&mut self) -> Vec<String> {
        self.data(0x80, &[])
    }

    /// One request and its answer.
    pub(crate) fn sdo(&mut self, request: [u8; 8]) -> [u8; 8] {
        let id = Id::base(0x600 + u16::from(NODE)).unwrap();
        self.device.handle_frame(self.now, &Frame::with(id, request));
        let mut answer = None;
        while let Some(frame) = self.device.poll_transmit(self.now) {
            if frame.id().number() == 0x580 + u32::from(NODE) {
                assert_eq!(answer.replace(frame.octets().try_into().unwrap()), None, "one answer");
            }
        }
        while self.device.poll_event().is_some() {}
        answer.unwrap_or_else(|| panic!("{request:02X?} is not answered"))
    }

    /// A value of any length, or the abort code.
    pub(crate) fn read(&mut self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        let [a, b] = index.to_le_bytes();
        let [command, _, _, _, data @ ..] = self.sdo([0x40, a, b, sub, 0, 0, 0, 0]);
        match command {
            0x80 => return Err(u32::from_le_bytes(data)),
            0x43 | 0x47 | 0x4B | 0x4F => return Ok(data[..usize::from(4 - (command >> 2 & 3))].to_vec()),
            _ => assert_eq!(command, 0x41),
        }
        let mut value = Vec::new();
        let mut toggle = 0;
        loop {
            let [command, octets @ ..] = self.sdo([0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]);
            assert_eq!(command & 0xF0, toggle, "a segment with the toggle bit");
            value.extend_from_slice(&octets[..usize::from(7 - (command >> 1 & 7))]);
            if command & 1 == 1 {
                assert_eq!(value.len(), u32::from_le_bytes(data) as usize, "the length that was announced");
                return Ok(value);
            }
            toggle ^= 0x10;
        }
    }

    pub(crate) fn write(&mut self, index: u16, sub: u8, value: &[u8]) -> Result<(), u32> {
        let [a, b] = index.to_le_bytes();
        let refused = |[command, _, _, _, data @ ..]: [u8; 8]| match command {
            0x80 => Err(u32::from_le_bytes(data)),
            _ => Ok(()),
        };
        if (1..=4).contains(&value.len()) {
            let mut data = [0; 4];
            data[..value.len()].copy_from_slice(value);
            let [d, e, f, g] = data;
            let unused = u8::try_from(4 - value.len()).unwrap();
            return refused(self.sdo([0x23 | unused << 2, a, b, sub, d, e, f, g]));
        }
        self.write_in_segments(index, sub, value)
    }

    pub(crate) fn write_in_segments(&mut self, index: u16, sub: u8, value: &[u8]) -> Result<(), u32> {
        let [a, b] = index.to_le_bytes();
        let [d, e, f, g] = u32::try_from(value.len()).unwrap().to_le_bytes();
        let refused = |[command, _, _, _, data @ ..]: [u8; 8]| match command {
            0x80 => Err(u32::from_le_bytes(data)),
            _ => Ok(()),
        };
        refused(self.sdo([0x21, a, b, sub, d, e, f, g]))?;
        let mut toggle = 0;
        let segments = value.chunks(7).chain(value.is_empty().then_some(&[][..]));
        let count = value.chunks(7).count().max(1);
        for (number, segment) in segments.enumerate() {
            let last = u8::from(number + 1 == count);
            let mut frame =
                [toggle | u8::try_from(7 - segment.len()).unwrap() << 1 | last, 0, 0, 0, 0, 0, 0, 0];
            frame[1..=segment.len()].copy_from_slice(segment);
            refused(self.sdo(frame))?;
            toggle ^= 0x10;
        }
        Ok(())
    }

    pub(crate) fn number(&mut self, index: u16, sub: u8) -> u32 {
        let mut octets = self.read(index, sub).unwrap();
        octets.resize(4, 0);
        u32::from_le_bytes(octets.try_into().unwrap())
    }

    pub(crate) fn set(&mut self, name: &str, level: Level) -> Vec<String> {
        let now = self.now;
        self.device.act(now, &mut |device| device.set_input(now, name, level));
        self.drain()
    }

    pub(crate) fn pass(&mut self, time: Duration) -> Vec<String> {
        let end = self.now.saturating_add(time);
        let mut seen = Vec::new();
        while let Some(due) = self.device.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            self.device.handle_timeout(self.now);
            seen.extend(self.drain());
        }
        self.now = end;
        seen
    }

    /// Off and on again, with what is kept.
    pub(crate) fn again(mut self) -> Self {
        let mut image = vec![0; 1 << 16];
        let (node, app) = self.device.parts();
        let len = node.image(app, &mut image).unwrap();
        let dictionary = self.device.application().objects();
        assert!(!dictionary.is_empty());
        self.device.power_off(self.now);
        self.device.recall(self.now, &image[..len]).unwrap();
        self.device.power_on(self.now);
        self.drain();
        self
    }
}

pub(crate) fn held(path: &Path) -> &'static Dictionary {
    let mut eds = Eds::read(&fs::read(path).unwrap()).unwrap();
    eds.complete();
    Dictionary::hold(eds)
}

/// An object with one value.
pub(crate) fn var(index: u16, data: u16, access: &str, more: &str) -> String {
    format!("[{index:04X}]\nParameterName=O{index:04X}\nDataType={data}\nAccessType={access}\n{more}\n")
}

/// An ARRAY that can be mapped; an empty default is none.
pub(crate) fn array(index: u16, data: u16, access: &str, defaults: &[&str]) -> String {
    let count = defaults.len();
    let mut text = format!(
        "[{index:04X}]\nParameterName=A{index:04X}\nObjectType=8\n[{index:04X}sub0]\nParameterName=Count\nDataType=5\n\
         AccessType=ro\nDefaultValue={count}\n"
    );
    for (sub, default) in (1..).zip(defaults) {
        text += &format!(
            "[{index:04X}sub{sub:X}]\nParameterName=E{sub}\nDataType={data}\nAccessType={access}\nDefaultValue={default}\n\
             PDOMapping=1\n"
        );
    }
    text
}

/// A PDO from its first object on, and its mapping.
pub(crate) fn pdo(index: u16, cob_id: &str, kind: u8, mapped: &[&str]) -> String {
    let record = |index: u16, entries: &[(u8, u16, &str)]| {
        let mut text = format!("[{index:04X}]\nParameterName=P{index:04X}\nObjectType=9\n");
        for (sub, data, default) in entries {
            text +=
                &format!("[{index:04X}sub{sub:X}]\nDataType={data}\nAccessType=rw\nDefaultValue={default}\n");
        }
        text
    };
    let kind = kind.to_string();
    let count = mapped.len().to_string();
    let words: Vec<_> =
        [(0, 5, &*count)].into_iter().chain((1..).zip(mapped).map(|(sub, word)| (sub, 7, *word))).collect();
    record(index, &[(0, 5, "2"), (1, 7, cob_id), (2, 5, &kind)]) + &record(index + 0x200, &words)
}
