//! Counts instructions and stack for `measure.sh`: under QEMU's `-icount shift=10` an instruction takes exactly 1024 ns, more
//! than 25 ticks of the clock. Needs some octets on the serial port.
#![no_std]
#![no_main]

#[path = "../../../own_station.rs"]
mod own_station;

use core::time::Duration;

use cortex_m::interrupt;
use cortex_m_rt::entry;
use profidrive::devices::ag03::profibus::{Config, Device, DipSwitches, MAX_TELEGRAM_LEN};
use profidrive::embedded::Slave;
use profidrive::profibus::dp::Framed;
use profidrive::profibus::fdl::{Address, DataTelegram, FunctionCode, Sap};
use profidrive::time::{BaudRate, Instant};
use profidrive_firmware::board::{self, Board, NANOS_PER_TICK, TIMING, ticks};
use profidrive_firmware::{done, ended, say};

/// `-icount shift=10`.
const NANOS_PER_INSTRUCTION: u64 = 1024;
/// Deeper than any stack here.
const PAINTED: u32 = 64 * 1024;

#[entry]
fn main() -> ! {
    interrupt::disable();
    let mut board = Board::start();
    measure_interrupt(&mut board);
    measure_drive(&mut board, board::paint(PAINTED));
    measure_station(&mut board, board::paint(PAINTED));
    done()
}

/// One octet: from the end of its stop bit, without the cycles in which the hardware enters and leaves the interrupt.
#[inline(never)]
fn measure_interrupt(board: &mut Board) {
    let (mut with, mut without, mut stack) = (u32::MAX, u32::MAX, 0);
    // One interrupt may follow the other: only a single one counts.
    while with == u32::MAX || without == u32::MAX {
        while board.receive().is_some() {}
        while !board::holds_octet() {}
        let paint = board::paint(PAINTED);
        let taken = board::octets_taken();
        let instructions = instructions(let_interrupts_in);
        if board::octets_taken() == taken + 1 {
            with = with.min(instructions);
            stack = board::painted_depth(paint, PAINTED);
        }
        if !board::holds_octet() {
            without = without.min(instructions_if_silent());
        }
    }
    tell("interrupt_per_octet", with - without);
    tell("interrupt_stack", stack);
}

/// As with an octet, without one.
fn instructions_if_silent() -> u32 {
    let taken = board::octets_taken();
    let instructions = instructions(let_interrupts_in);
    if board::octets_taken() == taken { instructions } else { u32::MAX }
}

#[inline(never)]
fn let_interrupts_in() {
    // SAFETY: nothing here relies on interrupts being masked.
    unsafe { interrupt::enable() };
    cortex_m::asm::isb();
    interrupt::disable();
}

#[inline(never)]
fn measure_drive(board: &mut Board, paint: u32) {
    let drive = &mut drive();
    tell("drive_stack_making", board::painted_depth(paint, PAINTED));
    tell("drive_octets", size_of::<Device>() as u32);

    let paint = board::paint(PAINTED);
    let mut bench = Bench { board, slave: drive, address: 5, now: Instant::ZERO, longest: 0 };
    bench.request(0x6D, Some(61), &[0x80, 1, 1, 11, 0x0A, 0xC5, 0]);
    bench.request(0x5D, Some(62), &[0xF3, 0xF2]);
    let mut fc = 0x5D;
    for stw in [0x0B, 0x0B, 0x3B, 0x3B, 0x7B, 0x7B] {
        fc ^= 0x20;
        bench.request(fc, None, &outputs(READ_POSITION, stw));
        bench.cycle();
    }
    for _ in 0..1000 {
        bench.cycle();
    }
    tell("drive_per_octet", bench.quiet_octet());
    let cycle = bench.cycle();
    fc ^= 0x20;
    let (octets, reply) = bench.request(fc, None, &outputs(READ_POSITION, 0x7B));
    tell("drive_reply", reply);
    tell("drive_reply_octets", octets);
    tell("drive_cycle", cycle);
    fc ^= 0x20;
    bench.request(fc, None, &outputs(WRITE_LIMIT, 0x7B));
    let job = bench.cycle();
    for round in 0..200 {
        fc ^= 0x20;
        bench.request(fc, None, &outputs(if round % 2 == 0 { READ_POSITION } else { WRITE_LIMIT }, 0x7B));
        bench.cycle();
    }
    for stw in [0x0B, 0x00, 0x0B, 0x3B] {
        fc ^= 0x20;
        bench.request(fc, None, &outputs([0; 8], stw));
        bench.cycle();
    }
    tell("drive_cycle_with_job", job);
    tell("drive_longest", bench.longest);
    let Bench { slave, .. } = bench;
    if slave.status().position == 0 {
        ended("the drive has not moved\n");
    }
    tell("drive_stack", board::painted_depth(paint, PAINTED));
}

/// As `bin/ag03` has it.
#[inline(never)]
fn drive() -> Device {
    let config = Config { baud: BaudRate::K1500, timing: TIMING, ..Config::new(DipSwitches::from_bits(5)) };
    Device::new(config, Instant::ZERO)
}

#[inline(never)]
fn measure_station(board: &mut Board, paint: u32) {
    let slave = &mut own_station::slave(BaudRate::K1500, TIMING.resync(BaudRate::K1500));
    tell("station_stack_making", board::painted_depth(paint, PAINTED));
    tell("station_octets", size_of::<Framed>() as u32);
    let paint = board::paint(PAINTED);
    let mut bench = Bench { board, slave, address: 7, now: Instant::ZERO, longest: 0 };
    bench.request(0x6D, Some(61), &[0x80, 1, 1, 11, 0x49, 0x4F, 0, 0]);
    bench.request(0x5D, Some(62), &[0x20, 0x10, 0x50]);
    bench.request(0x7D, None, &[0x0F]);
    tell("station_per_octet", bench.quiet_octet());
    let (_, reply) = bench.request(0x5D, None, &[0x8F]);
    tell("station_reply", reply);
    let Bench { slave, now, .. } = bench;
    let application = instructions(|| own_station::application(now, slave));
    if slave.station().slave().outputs() != [0x8F] {
        ended("the station has no outputs\n");
    }
    tell("station_application", application);
    tell("station_stack", board::painted_depth(paint, PAINTED));
}

const READ_POSITION: [u8; 8] = [0x13, 0xF9, 0, 0, 0, 0, 0, 0];
const WRITE_LIMIT: [u8; 8] = [0x33, 0xF8, 0, 0, 0, 3, 0xD0, 0x90];
const FAR_AWAY: i32 = 900_000;

fn outputs(job: [u8; 8], stw: u16) -> [u8; 14] {
    let ([a, b], [c, d, e, f]) = (stw.to_be_bytes(), FAR_AWAY.to_be_bytes());
    let [p, q, r, s, t, u, v, w] = job;
    [p, q, r, s, t, u, v, w, a, b, c, d, e, f]
}

/// A slave, and a master that asks it while its time stands still.
struct Bench<'a, S> {
    board: &'a mut Board,
    slave: &'a mut S,
    address: u8,
    now: Instant,
    /// The longest call so far.
    longest: u32,
}

impl<S: Slave + Say> Bench<'_, S> {
    /// Asks, and returns how many octets the reply has and how many instructions there are between the interrupt of the
    /// last octet of the request and the first octet of the reply.
    fn request(&mut self, fc: u8, sap: Option<u8>, data: &[u8]) -> (u32, u32) {
        let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
        let telegram = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, data),
            da: Address::from_octet(self.address),
            sa: Address::from_octet(2),
            dsap,
            ssap,
            fc: FunctionCode::from_octet(fc),
            data,
        };
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let Ok(octets) = telegram.encode(&mut buf) else { ended("no telegram\n") };
        let Some((last, others)) = octets.split_last() else { ended("no telegram\n") };
        self.now = self.now.saturating_add(Duration::from_micros(200));
        for octet in others {
            let (slave, now) = (&mut *self.slave, self.now);
            let count = instructions(|| _ = slave.handle_bytes(now, &[*octet]));
            self.longest = self.longest.max(count);
        }
        let mut out = [0; MAX_TELEGRAM_LEN];
        let (slave, board, now) = (&mut *self.slave, &mut *self.board, self.now);
        // min T_SDR is over: whoever is slower than 11 bit times does not wait for it.
        let due = now.saturating_add(Duration::from_micros(8));
        let mut len = 0;
        // The octets that came for the interrupt.
        while board.receive().is_some() {}
        board::hear(*last);
        let count = instructions(|| {
            while let Some((_, board::Heard::Octet(octet))) = board.receive() {
                slave.handle_bytes(now, &[octet]);
            }
            if let Some(reply) = slave.poll_transmit(due, &mut out) {
                len = reply.len();
                board.send(reply);
            }
        });
        if len == 0 {
            ended("no reply\n");
        }
        self.longest = self.longest.max(count);
        self.slave.drain();
        while board::is_sending() {
            let_interrupts_in();
        }
        (len as u32, count)
    }

    /// An octet in the middle of a telegram; the telegram is forgotten then.
    fn quiet_octet(&mut self) -> u32 {
        self.slave.handle_bytes(self.now, &[0x68]);
        let (slave, now) = (&mut *self.slave, self.now);
        let count = instructions(|| _ = slave.handle_bytes(now, &[17]));
        self.now = self.now.saturating_add(Duration::from_secs(1));
        self.slave.handle_timeout(self.now);
        self.slave.drain();
        count
    }

    /// The next millisecond.
    fn cycle(&mut self) -> u32 {
        self.now = self.now.saturating_add(Duration::from_millis(1));
        let (slave, now) = (&mut *self.slave, self.now);
        let count = instructions(|| slave.handle_timeout(now));
        self.longest = self.longest.max(count);
        self.slave.drain();
        count
    }
}

/// What a log would take.
trait Say {
    fn drain(&mut self);
}

impl Say for Device {
    fn drain(&mut self) {
        while self.poll_event().is_some() {}
    }
}

impl Say for Framed {
    fn drain(&mut self) {
        while self.poll_news().is_some() {}
    }
}

/// How many instructions this takes, the reading of the clock less.
#[inline(never)]
fn instructions(what: impl FnOnce()) -> u32 {
    let start = ticks();
    what();
    let passed = u64::from(ticks().wrapping_sub(start));
    ((passed * NANOS_PER_TICK + NANOS_PER_INSTRUCTION / 2) / NANOS_PER_INSTRUCTION) as u32
}

fn tell(name: &str, number: u32) {
    say(name);
    say(" ");
    let mut place = 1_000_000_000;
    let mut digits = [0; 10];
    let mut len = 0;
    while place > 0 {
        let digit = number / place % 10;
        if digit != 0 || len > 0 || place == 1 {
            if let Some(free) = digits.get_mut(len) {
                *free = b'0' + digit as u8;
            }
            len += 1;
        }
        place /= 10;
    }
    if let Some(Ok(text)) = digits.get(..len).map(core::str::from_utf8) {
        say(text);
    }
    say("\n");
}
