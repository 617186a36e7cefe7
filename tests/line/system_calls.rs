//! How many system calls an exchange takes: what `benches/system_calls.py` counts with strace, counted here by the kernel
//! (reads and writes of a thread) and by the loop (one `ppoll` for each sleep).

use core::cell::Cell;
use core::time::Duration;
use std::collections::VecDeque;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::Path;
use std::rc::Rc;
use std::thread;

use profidrive::can_bus::can::{BitRate, Content, ErrorState, Frame, Id};
use profidrive::devices::ag03::profibus::{Config, Device};
use profidrive::host::can::{CanParticipant, Line, LinkSpec, Stay};
use profidrive::host::link::pty::Pty;
use profidrive::host::{Bus, Link, Reach, Received, Stop, SystemClock, run};
use profidrive::profibus::fdl::Address;
use profidrive::time::Instant;
use rustix::termios::OptionalActions;

const EXCHANGES: usize = 400;
/// Other work on the machine makes single rounds worse: a process that is held up looks once more.
const ROUNDS: usize = 8;

/// FDL status of master 2 to station 5, and the reply of station 5.
const STATUS: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];
const STATUS_REPLY: [u8; 6] = [0x10, 0x02, 0x05, 0x00, 0x07, 0x16];

/// Reads and writes of this thread so far; `None`: this kernel does not count them.
fn reads_and_writes() -> Option<usize> {
    let text = fs::read_to_string("/proc/thread-self/io").ok()?;
    let of = |name| text.lines().find_map(|line| line.strip_prefix(name)?.trim().parse::<usize>().ok());
    Some(of("syscr:")? + of("syscw:")?)
}

/// A terminal as a master opens it: raw, with reads that wait.
fn open(path: &Path) -> File {
    let terminal = OpenOptions::new().read(true).write(true).open(path).unwrap();
    let mut settings = rustix::termios::tcgetattr(&terminal).unwrap();
    settings.make_raw();
    rustix::termios::tcsetattr(&terminal, OptionalActions::Now, &settings).unwrap();
    terminal
}

/// A master that asks and waits, again and again, then ends the line.
fn exchange(path: &Path, request: &[u8], reply: &[u8], stop: &Stop) {
    let mut terminal = open(path);
    let mut octets = vec![0; reply.len()];
    for _ in 0..EXCHANGES {
        terminal.write_all(request).unwrap();
        terminal.read_exact(&mut octets).unwrap();
        assert_eq!(octets, reply);
    }
    stop.request();
}

/// Asserts that an exchange takes so many calls, and not one more, in the best of several rounds. Each says its sleeps.
fn takes(most: usize, mut round: impl FnMut() -> usize) {
    if reads_and_writes().is_none() {
        return;
    }
    let mut fewest = usize::MAX;
    for _ in 0..ROUNDS {
        let before = reads_and_writes().unwrap();
        let sleeps = round();
        fewest = fewest.min(reads_and_writes().unwrap() - before + sleeps);
        if fewest < (most + 1) * EXCHANGES {
            return;
        }
    }
    panic!("{EXCHANGES} exchanges take {fewest} calls, not {most} each");
}

/// A link that counts its sleeps.
struct Counted {
    pty: Pty,
    sleeps: Rc<Cell<usize>>,
}

impl Link for Counted {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        self.pty.receive(buf)
    }
    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        self.pty.send(telegram)
    }
    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        self.sleeps.set(self.sleeps.get() + 1);
        self.pty.wait(timeout, stop)
    }
    fn resolution(&self) -> Duration {
        self.pty.resolution()
    }
}

#[test]
fn an_exchange_over_a_terminal_takes_four() {
    takes(4, || {
        let (clock, stop, sleeps) = (SystemClock::new(), Stop::new().unwrap(), Rc::default());
        let mut link = Counted { pty: Pty::open(None).unwrap(), sleeps: Rc::clone(&sleeps) };
        let mut bus = Bus::new();
        bus.add(Device::new(Config::new(Address::station(5).unwrap()), Instant::ZERO)).unwrap();
        let (path, asked) = (link.pty.path().to_owned(), stop.clone());
        let master = thread::spawn(move || exchange(&path, &STATUS, &STATUS_REPLY, &asked));
        run(&mut link, &mut bus, &clock, &stop, &mut |_| {}).unwrap();
        master.join().unwrap();
        sleeps.get()
    });
}

/// Answers an SDO with its own octets.
#[derive(Default)]
struct Echo(VecDeque<Frame>);

impl CanParticipant for Echo {
    type Event = ();

    fn handle_frame(&mut self, _: Instant, frame: &Frame) {
        if let Content::Data(octets) = frame.content() {
            self.0.extend(Frame::data(Id::base(0x585).unwrap(), octets));
        }
    }
    fn handle_timeout(&mut self, _: Instant) {}
    fn set_error_state(&mut self, _: Instant, _: ErrorState) {}
    fn poll_transmit(&mut self, _: Instant) -> Option<Frame> {
        self.0.pop_front()
    }
    fn poll_event(&mut self) -> Option<()> {
        None
    }
    fn poll_timeout(&self) -> Option<Instant> {
        None
    }
}

#[test]
fn an_sdo_over_a_terminal_takes_five() {
    takes(5, || {
        let stop = Stop::new().unwrap();
        let mut line: Line<()> =
            Line::open(&LinkSpec::Pty(None), BitRate::K1000, Reach::ThisMachine).unwrap();
        line.add(Box::new(Echo::default()));
        let (path, asked) = (line.name().to_owned(), stop.clone());
        let master = thread::spawn(move || {
            let path = Path::new(&path);
            let mut terminal = open(path);
            terminal.write_all(b"O\r").unwrap();
            terminal.read_exact(&mut [0]).unwrap();
            exchange(path, b"t60584018100100000000\r", b"z\rt58584018100100000000\r", &asked);
        });
        let mut sleeps = 0;
        while !stop.is_requested() {
            sleeps += 1;
            line.turn(Stay::Sleep, &stop, &mut |_| {}).unwrap();
        }
        master.join().unwrap();
        sleeps
    });
}
