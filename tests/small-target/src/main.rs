//! A firmware as small as can be around one slave, one drive, one CANopen node or nothing: octets of a UART or frames of a CAN
//! controller in, octets or frames out, a timer.
//!
//! The registers are no real chip's; the point is what the linker keeps.
#![no_std]
#![no_main]

use core::ptr::{read_volatile, write_volatile};

use cortex_m_rt::entry;

#[cfg(feature = "drive")]
#[path = "../../../examples/firmware.rs"]
mod firmware;

/// Where a chip would have its receiver, transmitter and a timer in ns.
const RECEIVED: *const u32 = 0x4000_0000 as *const u32;
const SEND: *mut u32 = 0x4000_0004 as *mut u32;
const NANOS: *const u64 = 0x4000_0008 as *const u64;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

fn received() -> u8 {
    // SAFETY: stands for a register; this program is linked, never run.
    unsafe { read_volatile(RECEIVED) as u8 }
}

fn send(octet: u8) {
    // SAFETY: as above.
    unsafe { write_volatile(SEND, u32::from(octet)) }
}

fn nanos() -> u64 {
    // SAFETY: as above.
    unsafe { read_volatile(NANOS) }
}

#[entry]
fn main() -> ! {
    run()
}

#[cfg(not(any(
    feature = "slave",
    feature = "drive",
    feature = "node",
    feature = "ag03_node",
    feature = "ap10_node",
    feature = "asda_a2_node"
)))]
fn run() -> ! {
    loop {
        send(received().wrapping_add(nanos() as u8));
    }
}

/// A slave with two octets in and two out.
#[cfg(feature = "slave")]
fn run() -> ! {
    use core::mem::MaybeUninit;

    use profidrive::profibus::dp::{Description, Fixed, Station};
    use profidrive::profibus::fdl::{Address, Framer, Resync};
    use profidrive::time::{BaudRate, Instant};

    static mut SLAVE: MaybeUninit<(Framer, Station)> = MaybeUninit::uninit();

    let baud = BaudRate::K1500;
    let description = Description { ident: 0x1234, ..Description::default() };
    let application = Fixed { configurations: &[&[0x11, 0x21]], ..Fixed::PLAIN };
    let max_tsdr = Some(baud.max_tsdr_bits());
    let station = Station::new(Address::from_octet(5), baud, max_tsdr, description, application);
    // SAFETY: the only use of this static.
    let (framer, station) = unsafe { (*&raw mut SLAVE).write((Framer::new(Resync::Idle(baud)), station)) };
    loop {
        let now = Instant::from_nanos(nanos());
        framer.handle_bytes(now, &[received()], |at, result| {
            if let Ok(telegram) = result {
                station.handle_telegram(at, &telegram);
            }
        });
        station.handle_timeout(now);
        station.set_inputs(&[received(), received()]);
        if let Ok(Some(octets)) = station.poll_transmit(now) {
            octets.iter().for_each(|octet| send(*octet));
        }
        station.slave().outputs().iter().for_each(|octet| send(*octet));
    }
}

/// A drive: the loop of `examples/firmware.rs`.
#[cfg(feature = "drive")]
fn run() -> ! {
    use core::mem::MaybeUninit;

    use profidrive::devices::ag03::profibus::Device;
    use profidrive::profibus::fdl::Address;
    use profidrive::time::Instant;

    struct Chip;

    impl firmware::Board for Chip {
        fn now(&mut self) -> Instant {
            Instant::from_nanos(nanos())
        }
        fn receive(&mut self) -> Option<u8> {
            Some(received()).filter(|octet| *octet != 0)
        }
        fn send(&mut self, octets: &[u8]) {
            octets.iter().for_each(|octet| send(*octet));
        }
    }

    static mut DRIVE: MaybeUninit<Device> = MaybeUninit::uninit();

    let Ok(address) = Address::station(5) else { loop {} };
    // SAFETY: the only use of this static.
    let device = unsafe { (*&raw mut DRIVE).write(firmware::drive(address, Instant::from_nanos(nanos()))) };
    loop {
        firmware::pass(&mut Chip, device);
        send(device.status().position as u8);
    }
}

/// A frame from the registers of a controller.
#[cfg(any(feature = "node", feature = "ag03_node", feature = "ap10_node", feature = "asda_a2_node"))]
fn frame() -> Option<profidrive::can_bus::can::Frame> {
    let id = u16::from(received()) << 8 | u16::from(received());
    let octets = [(); 8].map(|()| received());
    let octets = octets.get(..usize::from(received() & 7))?;
    profidrive::can_bus::can::Frame::data(profidrive::can_bus::can::Id::base(id).ok()?, octets).ok()
}

#[cfg(any(feature = "node", feature = "ag03_node", feature = "ap10_node", feature = "asda_a2_node"))]
fn put(frame: &profidrive::can_bus::can::Frame) {
    frame.id().number().to_le_bytes().iter().chain(frame.octets()).for_each(|octet| send(*octet));
}

/// A node with one octet in and one out, in a PDO each way.
#[cfg(feature = "node")]
fn run() -> ! {
    use core::mem::MaybeUninit;

    use profidrive::can_bus::canopen::dictionary::{Entry, Object};
    use profidrive::can_bus::canopen::value::DataType::{U8, U16, U32};
    use profidrive::can_bus::canopen::{
        Abort, Address, Application, Node, NodeId, Notice, Policy, Request, Source, Value, Written,
    };
    use profidrive::time::Instant;

    const OBJECTS: &[Object] = &[
        Object::var(0x1000, &[Entry::ro(0, "Device type", U32).number(0x0003_0191)]),
        Object::var(0x1001, &[Entry::ro(0, "Error register", U8).number(0).node()]),
        Object::var(0x1014, &[Entry::rw(0, "COB-ID EMCY", U32).node_id(0x80).node()]),
        Object::var(0x1017, &[Entry::rw(0, "Producer heartbeat time", U16).number(0).node()]),
        Object::record(
            0x1018,
            "Identity",
            &[Entry::ro(0, "Highest sub-index", U8).number(1), Entry::ro(1, "Vendor", U32).number(0)],
        ),
        Object::record(
            0x1400,
            "RPDO 1 communication",
            &[
                Entry::ro(0, "Highest sub-index", U8).number(2),
                Entry::rw(1, "COB-ID", U32).node_id(0x200).node(),
                Entry::rw(2, "Transmission type", U8).number(255).node(),
            ],
        ),
        Object::record(
            0x1600,
            "RPDO 1 mapping",
            &[
                Entry::ro(0, "Mapped objects", U8).number(1).node(),
                Entry::ro(1, "Mapping 1", U32).number(0x6200_0108).node(),
            ],
        ),
        Object::record(
            0x1800,
            "TPDO 1 communication",
            &[
                Entry::ro(0, "Highest sub-index", U8).number(5),
                Entry::rw(1, "COB-ID", U32).node_id(0x180).node(),
                Entry::rw(2, "Transmission type", U8).number(255).node(),
                Entry::rw(3, "Inhibit time", U16).number(0).node(),
                Entry::rw(5, "Event timer", U16).number(0).node(),
            ],
        ),
        Object::record(
            0x1A00,
            "TPDO 1 mapping",
            &[
                Entry::ro(0, "Mapped objects", U8).number(1).node(),
                Entry::ro(1, "Mapping 1", U32).number(0x6000_0108).node(),
            ],
        ),
        Object::array(
            0x6000,
            "Inputs",
            &[
                Entry::ro(0, "Highest sub-index", U8).number(1),
                Entry::ro(1, "Inputs 1 to 8", U8).live().to_tpdo(),
            ],
        ),
        Object::array(
            0x6200,
            "Outputs",
            &[Entry::ro(0, "Highest sub-index", U8).number(1), Entry::rw(1, "Outputs 1 to 8", U8).to_rpdo()],
        ),
    ];

    struct Io {
        inputs: u8,
        outputs: u8,
        changed: bool,
    }

    impl Application for Io {
        fn objects(&self) -> &'static [Object] {
            OBJECTS
        }

        fn node_id(&self) -> NodeId {
            NodeId::MIN
        }

        fn read(&self, at: Address) -> Result<Value<'_>, Abort> {
            Ok(Value::U8(if at.index.0 == 0x6000 { self.inputs } else { self.outputs }))
        }

        fn write(&mut self, _: Instant, _: Address, value: Value<'_>, _: Source) -> Result<Written, Abort> {
            if let Value::U8(outputs) = value {
                self.outputs = outputs;
            }
            Ok(Written::Done)
        }

        fn notice(&mut self, _: Instant, _: Notice) {}

        fn poll_request(&mut self) -> Option<Request> {
            core::mem::take(&mut self.changed)
                .then_some(Request::Tpdo(profidrive::can_bus::canopen::PdoNumber::P1))
        }
    }

    static mut NODE: MaybeUninit<(Node, Io)> = MaybeUninit::uninit();

    let io = Io { inputs: 0, outputs: 0, changed: false };
    // SAFETY: the only use of this static.
    let (node, io) = unsafe { (*&raw mut NODE).write((Node::new(Policy::CIA_301), io)) };
    node.power_on(Instant::from_nanos(nanos()), io);
    loop {
        let now = Instant::from_nanos(nanos());
        if let Some(frame) = frame() {
            node.handle_frame(now, &frame, io);
        }
        let inputs = received();
        io.changed = inputs != io.inputs;
        io.inputs = inputs;
        node.handle_change(now, io);
        node.handle_timeout(now, io);
        while let Some(frame) = node.poll_transmit() {
            put(&frame);
        }
        while node.poll_event().is_some() {}
        send(io.outputs);
    }
}

/// A device as a node, whichever it is, on the registers: `$show` is what a board would show of it.
#[cfg(any(feature = "ag03_node", feature = "ap10_node", feature = "asda_a2_node"))]
macro_rules! device {
    ($device:ty, $make:expr, $show:expr) => {
        fn run() -> ! {
            use core::mem::MaybeUninit;

            use profidrive::devices::CanopenDevice;
            use profidrive::time::Instant;

            static mut NODE: MaybeUninit<$device> = MaybeUninit::uninit();

            let now = Instant::from_nanos(nanos());
            let make: fn(Instant) -> $device = $make;
            let show: fn(&$device) -> u8 = $show;
            // SAFETY: the only use of this static.
            let node = unsafe { (*&raw mut NODE).write(make(now)) };
            CanopenDevice::power_on(node, now);
            loop {
                let now = Instant::from_nanos(nanos());
                if let Some(frame) = frame() {
                    CanopenDevice::handle_frame(node, now, &frame);
                }
                CanopenDevice::handle_timeout(node, now);
                while let Some(frame) = CanopenDevice::poll_transmit(node, now) {
                    put(&frame);
                }
                while CanopenDevice::poll_event(node).is_some() {}
                send(show(node));
            }
        }
    };
}

#[cfg(feature = "ag03_node")]
use profidrive::devices::ag03::canopen::{Ag03Node, Config as Ag03Config};
#[cfg(feature = "ag03_node")]
device!(
    Ag03Node,
    |now| Ag03Node::new(Ag03Config::new(profidrive::can_bus::canopen::NodeId::MIN), now),
    |node| node.status().position as u8
);

#[cfg(feature = "ap10_node")]
use profidrive::devices::ap10::canopen::{Ap10, Config as Ap10Config};
#[cfg(feature = "ap10_node")]
device!(Ap10, |_| Ap10::new(Ap10Config::new(profidrive::can_bus::canopen::NodeId::MIN)), |node| node
    .indicator()
    .position()
    as u8);

#[cfg(feature = "asda_a2_node")]
use profidrive::devices::asda_a2::canopen::{AsdaA2, Config as AsdaConfig, Quirks};
#[cfg(feature = "asda_a2_node")]
device!(AsdaA2, |now| AsdaA2::new(AsdaConfig::new(1), Quirks::default(), now), |node| node.statusword().0
    as u8);
