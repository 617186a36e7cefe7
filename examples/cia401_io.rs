//! A CANopen device of your own: eight digital inputs and eight digital outputs after CiA 401; docs/new-device.md goes
//! through it part by part.
//!
//! ```text
//! cargo run --example cia401_io -- eds > io.eds
//! cargo run --example cia401_io -- slcan-tcp:127.0.0.1:5000
//! python3 -c 'import can; b = can.Bus("socket://127.0.0.1:5000", interface="slcan"); print(b.recv(2))'
//! ```

use core::error::Error;

use profidrive::can_bus::can::BitRate;
use profidrive::can_bus::canopen::eds;
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::can_bus::canopen::value::DataType::{U8, U16, U32};
use profidrive::can_bus::canopen::{
    Abort, Address, Application, Entry, Home, NmtState, NodeId, Notice, Object, Policy, Reset, Source, Value,
    Written,
};
use profidrive::devices::{CanopenEvent, PlainNode};
use profidrive::face::description::{self, Amount, Description, Group};
use profidrive::face::surroundings::{Face, Input, InputKind, Level, Surroundings};
use profidrive::host::can::{Line, StoredNode};
use profidrive::host::{Reach, Stop};
use profidrive::time::Instant;

const INPUTS: Address = Address::new(0x6000, 1);
const OUTPUTS: Address = Address::new(0x6200, 1);
const ERROR_MODE: Address = Address::new(0x6206, 1);
const ERROR_VALUE: Address = Address::new(0x6207, 1);

const VENDOR: u32 = 0xFFFF;
const PRODUCT: u32 = 401;

pub(crate) const OBJECTS: &[Object] = &[
    // Profile 401; bit 16: digital inputs, bit 17: digital outputs.
    Object::var(0x1000, &[Entry::ro(0, "Device type", U32).number(0x0003_0191)]),
    Object::var(0x1001, &[Entry::ro(0, "Error register", U8).node()]),
    Object::var(0x1017, &[Entry::rw(0, "Producer heartbeat time", U16).number(0).node()]),
    Object::record(
        0x1018,
        "Identity",
        &[
            highest(2),
            Entry::ro(1, "Vendor", U32).number(VENDOR as i64),
            Entry::ro(2, "Product", U32).number(PRODUCT as i64),
        ],
    ),
    Object::record(0x1400, "RPDO 1", &[highest(2), cob_id(0x200), kind()]),
    Object::record(0x1600, "RPDO 1 mapping", &[count(), mapped(OUTPUTS)]),
    Object::record(0x1800, "TPDO 1", &[highest(2), cob_id(0x180), kind()]),
    Object::record(0x1A00, "TPDO 1 mapping", &[count(), mapped(INPUTS)]),
    Object::array(0x6000, "Inputs", &[highest(1), Entry::ro(1, "Inputs 1 to 8", U8).live().to_tpdo()]),
    Object::array(0x6200, "Outputs", &[highest(1), Entry::rw(1, "Outputs 1 to 8", U8).number(0).to_rpdo()]),
    Object::array(0x6206, "Error mode", &[highest(1), Entry::rw(1, "Error mode", U8).number(0xFF)]),
    Object::array(0x6207, "Error value", &[highest(1), Entry::rw(1, "Error value", U8).number(0)]),
];

const fn highest(sub: i64) -> Entry {
    Entry::ro(0, "Highest sub-index", U8).number(sub)
}

const fn cob_id(base: u32) -> Entry {
    Entry::rw(1, "COB-ID", U32).node_id(base).node()
}

/// Event-driven by the device profile, or synchronous.
const fn kind() -> Entry {
    Entry::rw(2, "Transmission type", U8).number(255).ranges(&[(0, 240), (254, 255)]).node()
}

const fn count() -> Entry {
    Entry::ro(0, "Mapped entries", U8).number(1).node()
}

const fn mapped(at: Address) -> Entry {
    let (index, sub) = at.pair();
    Entry::ro(1, "Entry 1", U32).number((index as i64) << 16 | (sub as i64) << 8 | 8).home(Home::Node)
}

/// What the data sheet says besides the objects.
pub(crate) const SHEET: eds::Sheet<'_> = eds::Sheet {
    file_name: "io.eds",
    vendor_number: VENDOR,
    product_name: "IO 8/8",
    product_number: PRODUCT,
    ..eds::Sheet::PLAIN
};

/// The device behind the node.
pub(crate) struct Io {
    node_id: NodeId,
    inputs: u8,
    outputs: u8,
    /// 6206h: 1 for an output that takes its bit of 6207h after an error, 0 for one that stays.
    error_mode: u8,
    error_value: u8,
}

impl Io {
    pub(crate) const fn new(node_id: NodeId) -> Self {
        Self { node_id, inputs: 0, outputs: 0, error_mode: 0xFF, error_value: 0 }
    }

    /// The device on its node, switched off.
    pub(crate) fn on_node(self) -> PlainNode<Self> {
        PlainNode::new(Policy::CIA_301, Eeprom::Internal, self)
    }
}

impl Application for Io {
    fn objects(&self) -> &'static [Object] {
        OBJECTS
    }

    fn node_id(&self) -> NodeId {
        self.node_id
    }

    fn read(&self, at: Address) -> Result<Value<'_>, Abort> {
        match at {
            INPUTS => Ok(Value::U8(self.inputs)),
            OUTPUTS => Ok(Value::U8(self.outputs)),
            ERROR_MODE => Ok(Value::U8(self.error_mode)),
            ERROR_VALUE => Ok(Value::U8(self.error_value)),
            Address { .. } => Err(Abort::INTERNAL),
        }
    }

    fn write(&mut self, _: Instant, at: Address, value: Value<'_>, _: Source) -> Result<Written, Abort> {
        let Value::U8(value) = value else { return Err(Abort::INTERNAL) };
        match at {
            OUTPUTS => self.outputs = value,
            ERROR_MODE => self.error_mode = value,
            ERROR_VALUE => self.error_value = value,
            Address { .. } => return Err(Abort::INTERNAL),
        }
        Ok(Written::Done)
    }

    fn notice(&mut self, _: Instant, notice: Notice) {
        if let Notice::Reset(Reset::PowerOn | Reset::Node) = notice {
            *self = Self { inputs: self.inputs, ..Self::new(self.node_id) };
        }
        if let Notice::Nmt { to: NmtState::Stopped, .. } = notice {
            self.outputs = self.outputs & !self.error_mode | self.error_value & self.error_mode;
        }
    }
}

const WIRES: Input = Input {
    name: "inputs",
    about: "what is wired to the eight inputs, input 1 in bit 0",
    kind: InputKind::Number { low: 0.0, high: 255.0, own: false },
};

impl Surroundings for Io {
    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        tell(&WIRES, Level::Number(self.inputs.into()));
    }

    #[expect(clippy::cast_possible_truncation, reason = "a number within 0 to 255, as WIRES says")]
    fn set_input(&mut self, _: Instant, name: &str, level: Level) {
        if let (true, Level::Number(wires)) = (name == WIRES.name, level) {
            self.inputs = wires as u8;
        }
    }

    fn face(&self, _: Instant) -> Face {
        Face::default().row(&format!("{:08b}", self.outputs), false)
    }

    fn words(&self) -> &'static [Address] {
        &[OUTPUTS, INPUTS]
    }
}

impl Description for Io {
    fn each_value(&self, tell: &mut dyn FnMut(description::Value<'_>)) {
        tell(description::Value::new("lit", "outputs on", Group::Measured, Amount::Flag(self.outputs != 0)));
    }
}

#[allow(dead_code, reason = "a test includes this file")]
fn main() -> Result<(), Box<dyn Error>> {
    let link = std::env::args().nth(1).unwrap_or_else(|| "slcan-pty".into());
    if link == "eds" {
        let mut text = String::new();
        eds::write(&SHEET, OBJECTS, &mut text)?;
        print!("{text}");
        return Ok(());
    }
    let mut line: Line<CanopenEvent> = Line::open(&link.parse()?, BitRate::K500, Reach::ThisMachine)?;
    let device = Io::new(NodeId::new(5)?).on_node();
    line.add(Box::new(StoredNode::new(Box::new(device), Instant::ZERO)));
    println!("ready link={}", line.name());
    line.run(&Stop::new()?, &mut |news| eprintln!("{news:?}"))?;
    Ok(())
}
