//! A drive of CiA 402 that a file describes, and a master that commands it.
#![cfg(feature = "eds")]

use std::fmt::Write;
use std::time::Duration;

use profidrive::devices::CanopenDevice;
use profidrive::face::surroundings::Level;

use crate::file_node::{Rig, var};

pub(crate) const ENABLED: u32 = 0x27;
pub(crate) const FAULT: u32 = 0x08;
pub(crate) const REACHED: u32 = 1 << 10;
pub(crate) const LIMIT: u32 = 1 << 11;
pub(crate) const BIT_12: u32 = 1 << 12;
pub(crate) const BIT_13: u32 = 1 << 13;

/// Index, type, access; a drive with everything that the profile has, 1000 increments in a revolution.
const OBJECTS: &[(u16, u16, &str, &str)] = &[
    (0x1000, 7, "ro", "DefaultValue=0x00020192"),
    (0x1001, 5, "ro", ""),
    (0x1014, 7, "rw", "DefaultValue=$NODEID+0x80"),
    (0x6007, 3, "rw", "DefaultValue=1"),
    (0x603F, 6, "ro", "PDOMapping=1"),
    (0x6040, 6, "rww", "PDOMapping=1"),
    (0x6041, 6, "ro", "PDOMapping=1\nDefaultValue=0x1234"),
    (0x6042, 3, "rw", ""),
    (0x6044, 3, "ro", ""),
    (0x605A, 3, "rw", "DefaultValue=2"),
    (0x605B, 3, "rw", "DefaultValue=0"),
    (0x605C, 3, "rw", "DefaultValue=1"),
    (0x605D, 3, "rw", "DefaultValue=1"),
    (0x605E, 3, "rw", "DefaultValue=2"),
    (0x6060, 2, "rw", "PDOMapping=1"),
    (0x6061, 2, "ro", "PDOMapping=1"),
    (0x6063, 4, "ro", ""),
    (0x6064, 4, "ro", "PDOMapping=1"),
    (0x6065, 7, "rw", "DefaultValue=0xFFFFFFFF"),
    (0x6066, 6, "rw", "DefaultValue=0"),
    (0x6067, 7, "rw", "DefaultValue=2"),
    (0x6068, 6, "rw", "DefaultValue=20"),
    (0x606C, 4, "ro", "PDOMapping=1"),
    (0x6071, 3, "rw", ""),
    (0x6072, 6, "rw", ""),
    (0x6077, 3, "ro", "PDOMapping=1"),
    (0x607A, 4, "rw", "PDOMapping=1"),
    (0x607C, 4, "rw", ""),
    (0x607E, 5, "rw", ""),
    (0x6081, 7, "rw", "DefaultValue=10000"),
    (0x6083, 7, "rw", "DefaultValue=100000"),
    (0x6084, 7, "rw", ""),
    (0x6087, 7, "rw", ""),
    (0x6098, 2, "rw", "DefaultValue=35"),
    (0x60B8, 6, "rw", ""),
    (0x60B9, 6, "ro", ""),
    (0x60BA, 4, "ro", ""),
    (0x60F4, 4, "ro", ""),
    (0x60FD, 7, "ro", ""),
    (0x60FF, 4, "rw", "PDOMapping=1"),
    (0x6502, 7, "ro", "DefaultValue=0x3EF"),
];

/// Index, types of the entries behind sub-index 0 with their defaults.
const RECORDS: &[(u16, &[(u16, &str)])] = &[
    (0x1400, &[(7, "$NODEID+0x200"), (5, "255")]),
    (0x1600, &[(7, "0x60400010"), (7, "0x607A0020")]),
    (0x1800, &[(7, "$NODEID+0x180"), (5, "255")]),
    (0x1A00, &[(7, "0x60410010")]),
    (0x607D, &[(4, "0"), (4, "0")]),
    (0x608F, &[(7, "1000"), (7, "1")]),
    (0x6091, &[(7, "1"), (7, "1")]),
    (0x6099, &[(7, "2000"), (7, "500")]),
    (0x60C1, &[(4, "0")]),
    (0x60C2, &[(5, "10"), (2, "-3")]),
];

fn record(index: u16, entries: &[(u16, &str)]) -> String {
    let count = entries.len();
    let mut text = format!("[{index:04X}]\nParameterName=R{index:04X}\nObjectType=9\n[{index:04X}sub0]\n");
    writeln!(text, "ParameterName=Count\nDataType=5\nAccessType=ro\nDefaultValue={count}").unwrap();
    for (sub, (data, default)) in (1..).zip(entries) {
        writeln!(text, "[{index:04X}sub{sub:X}]\nParameterName=E{sub}\nDataType={data}\nAccessType=rw")
            .unwrap();
        writeln!(text, "DefaultValue={default}\nPDOMapping=1").unwrap();
    }
    text
}

/// What an axis of a drive has: its objects are 800h, its PDOs 40h behind those of the axis before.
fn text(axis: u16, left_out: &[u16]) -> String {
    let at = |index: u16| index + axis * if index < 0x6000 { 0x40 } else { 0x800 };
    let default = |of: &str| match (of.strip_prefix("$NODEID+0x"), of.strip_prefix("0x60")) {
        (Some(base), _) => {
            let base = u32::from_str_radix(base, 16).unwrap();
            // There are identifiers for four axes; the PDOs of the others are off.
            let off = if axis < 4 { 0 } else { 1 << 31 };
            format!("$NODEID+{:#X}", base + u32::from(axis % 4) * 0x100 + off)
        }
        (None, Some(rest)) => format!("{:#X}{rest}", (0x6000 + axis * 0x800) >> 8),
        (None, None) => of.to_owned(),
    };
    let is_there =
        |index: &u16| !left_out.contains(index) && (axis == 0 || !(0x1000..0x1400).contains(index));
    let vars = OBJECTS.iter().filter(|row| is_there(&row.0));
    let vars = vars.map(|(index, data, access, more)| var(at(*index), *data, access, more));
    let records = RECORDS.iter().filter(|row| is_there(&row.0));
    let records = records.map(|(index, entries)| {
        let entries: Vec<_> = entries.iter().map(|(data, of)| (*data, default(of))).collect();
        let entries: Vec<_> = entries.iter().map(|(data, of)| (*data, &**of)).collect();
        record(at(*index), &entries)
    });
    vars.chain(records).collect()
}

/// A drive, and the axis of it that is commanded, 0 the first.
pub(crate) struct Drive(pub(crate) Rig, pub(crate) u16);

impl Drive {
    /// With so many axes.
    pub(crate) fn with_axes(count: u16) -> Self {
        let mut rig = Rig::text(&(0..count).map(|axis| text(axis, &[])).collect::<String>());
        rig.start();
        Self(rig, 0)
    }

    /// Where the axis has an object of the first.
    const fn at(&self, index: u16) -> u16 {
        if index < 0x6000 { index } else { index + self.1 * 0x800 }
    }

    pub(crate) fn new() -> Self {
        Self::without(&[])
    }

    pub(crate) fn without(left_out: &[u16]) -> Self {
        Self::of(left_out, &[], &[])
    }

    /// With objects and records besides.
    pub(crate) fn with(objects: &[(u16, u16, &str, &str)], added: &[(u16, &[(u16, &str)])]) -> Self {
        Self::of(&[], objects, added)
    }

    fn of(left_out: &[u16], objects: &[(u16, u16, &str, &str)], added: &[(u16, &[(u16, &str)])]) -> Self {
        let more = objects.iter().map(|(index, data, access, more)| var(*index, *data, access, more));
        let more = more.chain(added.iter().map(|(index, entries)| record(*index, entries)));
        let text = more.fold(text(0, left_out), |text, more| text + &more);
        let mut rig = Rig::text(&text);
        rig.start();
        Self(rig, 0)
    }

    pub(crate) fn word(&mut self, word: u16) {
        self.0.write(self.at(0x6040), 0, &word.to_le_bytes()).unwrap();
    }

    pub(crate) fn put(&mut self, index: u16, sub: u8, value: i32) {
        let index = self.at(index);
        let len = self.0.read(index, sub).unwrap().len();
        self.0.write(index, sub, &value.to_le_bytes()[..len]).unwrap();
    }

    pub(crate) fn mode(&mut self, mode: i8) {
        self.0.write(self.at(0x6060), 0, &[mode.cast_unsigned()]).unwrap();
    }

    pub(crate) fn status(&mut self) -> u32 {
        self.0.number(self.at(0x6041), 0)
    }

    pub(crate) fn state(&mut self) -> u32 {
        match self.status() {
            word if word & 0x4F == 0x40 || word & 0x4F == 0x08 || word & 0x4F == 0x0F => word & 0x4F,
            word => word & 0x6F,
        }
    }

    pub(crate) fn signed(&mut self, index: u16) -> i32 {
        match self.0.read(self.at(index), 0).unwrap()[..] {
            [a] => i32::from(a.cast_signed()),
            [a, b] => i16::from_le_bytes([a, b]).into(),
            [a, b, c, d] => i32::from_le_bytes([a, b, c, d]),
            ref other => panic!("{other:?}"),
        }
    }

    pub(crate) fn position(&mut self) -> i32 {
        self.signed(0x6064)
    }

    pub(crate) fn speed(&mut self) -> i32 {
        self.signed(0x606C)
    }

    pub(crate) fn millis(&mut self, millis: u64) -> Vec<String> {
        self.0.pass(Duration::from_millis(millis))
    }

    pub(crate) fn enable(&mut self, mode: i8) {
        self.mode(mode);
        [6, 7, 0xF].into_iter().for_each(|word| self.word(word));
        assert_eq!(self.state(), ENABLED);
    }

    /// Milliseconds until these bits are set.
    pub(crate) fn until(&mut self, bits: u32) -> u64 {
        for millis in 0..20_000 {
            if self.status() & bits == bits {
                return millis;
            }
            self.millis(1);
        }
        panic!("status {:04X}h, bits {bits:04X}h do not come, position {}", self.status(), self.position());
    }

    pub(crate) fn go_to(&mut self, target: i32, word: u16) {
        self.put(0x607A, 0, target);
        self.word(0x0F);
        self.word(word);
        assert_ne!(self.status() & BIT_12, 0, "the set-point is acknowledged");
        self.word(0x0F);
        assert_eq!(self.status() & BIT_12, 0);
    }

    pub(crate) fn set(&mut self, name: &str, level: Level) {
        self.0.set(name, level);
    }

    pub(crate) fn why(&self) -> Vec<String> {
        let mut names = Vec::new();
        let description = self.0.device.description();
        description.why().unwrap().each_reason(&mut |reason| names.push(reason.name.to_owned()));
        names
    }
}
