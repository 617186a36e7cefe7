//! The adapters of a CAN bus, as masters see them (`canopen-link.md` 11 and rows L-01 to L-06 of 14).

use core::time::Duration;
use std::collections::VecDeque;
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::os::unix::fs::{OpenOptionsExt, symlink};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Instant as Wall;

use profidrive::can_bus::can::slcan::parse_frame;
use profidrive::can_bus::can::{BitRate, Content, ErrorState, Frame, Id};
use profidrive::host::can::{CanParticipant, Line, LinkSpec, News, Stay};
use profidrive::host::{Error, PathOccupant, Reach, Stop};
use profidrive::time::Instant;
use rustix::fs::OFlags;

use crate::patience::PATIENCE;

/// What a CANopen node does of which these rows speak: a boot-up, a heartbeat, and an answer to each SDO.
struct Node {
    number: u16,
    heartbeat: Duration,
    next: Instant,
    queue: VecDeque<Frame>,
    /// Dropped when the frames of the start have passed.
    starting: Option<Sender<()>>,
}

impl Node {
    fn boxed(number: u16, heartbeat: Duration, starting: Sender<()>) -> Box<dyn CanParticipant<Event = ()>> {
        let starting = Some(starting);
        let mut node = Self { number, heartbeat, next: Instant::ZERO, queue: VecDeque::new(), starting };
        node.boot();
        Box::new(node)
    }

    fn boot(&mut self) {
        self.queue.push_back(Frame::with(base(0x700 + self.number), [0]));
    }
}

fn base(number: u16) -> Id {
    Id::base(number).unwrap()
}

impl CanParticipant for Node {
    type Event = ();

    fn handle_frame(&mut self, _: Instant, frame: &Frame) {
        match (frame.id(), frame.content()) {
            (id, Content::Data(&[0x81, node]))
                if id == base(0) && (node == 0 || u16::from(node) == self.number) =>
            {
                self.boot();
            }
            (id, Content::Data(octets)) if id == base(0x600 + self.number) => {
                self.queue.extend(Frame::data(base(0x580 + self.number), octets));
            }
            _ => {}
        }
    }

    fn handle_timeout(&mut self, now: Instant) {
        if self.next <= now {
            self.next = now.saturating_add(self.heartbeat);
            self.queue.push_back(Frame::with(base(0x700 + self.number), [0x7F]));
        }
    }

    fn set_error_state(&mut self, _: Instant, _: ErrorState) {}

    fn poll_transmit(&mut self, _: Instant) -> Option<Frame> {
        let frame = self.queue.pop_front();
        if frame.is_none() && self.next != Instant::ZERO {
            self.starting = None;
        }
        frame
    }

    fn poll_event(&mut self) -> Option<()> {
        None
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Some(self.next)
    }
}

const SELDOM: Duration = Duration::from_secs(3600);
const OFTEN: Duration = Duration::from_millis(2);

/// A line that ran, and its news.
type Outcome = (Line<()>, Vec<News<()>>);

/// A line that runs on a thread of its own.
struct Running {
    name: String,
    stop: Stop,
    thread: Option<JoinHandle<Outcome>>,
}

impl Running {
    fn start(spec: &LinkSpec, nodes: impl IntoIterator<Item = u16>, heartbeat: Duration) -> Self {
        let mut line = Line::open(spec, BitRate::K1000, Reach::ThisMachine).unwrap();
        let (starting, started) = channel();
        for number in nodes {
            line.add(Node::boxed(number, heartbeat, starting.clone()));
        }
        drop(starting);
        let (name, stop) = (line.name().to_owned(), Stop::new().unwrap());
        let asked = stop.clone();
        let thread = thread::spawn(move || {
            let mut news = Vec::new();
            line.run(&asked, &mut |item| {
                if news.len() < 10_000 {
                    news.push(item);
                }
            })
            .unwrap();
            (line, news)
        });
        // The frames of the start pass before anybody is there.
        assert!(
            started.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Disconnected),
            "the nodes do not start"
        );
        Self { name, stop, thread: Some(thread) }
    }

    fn pty(nodes: impl IntoIterator<Item = u16>, heartbeat: Duration) -> Self {
        Self::start(&LinkSpec::Pty(None), nodes, heartbeat)
    }

    fn tcp(nodes: impl IntoIterator<Item = u16>, heartbeat: Duration) -> Self {
        Self::start(&"slcan-tcp:127.0.0.1:0".parse().unwrap(), nodes, heartbeat)
    }

    fn end(mut self) -> Outcome {
        self.stop.request();
        self.thread.take().unwrap().join().unwrap()
    }

    fn terminal(&self) -> Master {
        Master::terminal(Path::new(&self.name))
    }

    fn connect(&self) -> Master {
        let stream = TcpStream::connect(self.name.strip_prefix("slcan-tcp:").unwrap()).unwrap();
        stream.set_nodelay(true).unwrap();
        stream.set_nonblocking(true).unwrap();
        Master { stream: Box::new(stream), read: VecDeque::new() }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.request();
    }
}

trait Stream: Read + Write + Send {}
impl<S: Read + Write + Send> Stream for S {}

/// A program at an adapter.
struct Master {
    stream: Box<dyn Stream>,
    read: VecDeque<u8>,
}

impl Master {
    fn terminal(path: &Path) -> Self {
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits().cast_signed();
        let file: File = OpenOptions::new().read(true).write(true).custom_flags(flags).open(path).unwrap();
        Self { stream: Box::new(file), read: VecDeque::new() }
    }

    fn write(&mut self, octets: &[u8]) {
        let (mut rest, end) = (octets, Wall::now() + PATIENCE);
        while !rest.is_empty() {
            assert!(Wall::now() < end, "the adapter takes nothing");
            match self.stream.write(rest) {
                Ok(count) => rest = &rest[count..],
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    thread::sleep(Duration::from_millis(1))
                }
                Err(error) => panic!("{error}"),
            }
        }
    }

    /// Takes what has come.
    fn look(&mut self) {
        let mut buf = [0; 4096];
        match self.stream.read(&mut buf) {
            Ok(count) => self.read.extend(&buf[..count]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            Err(error) => panic!("{error}"),
        }
    }

    /// The next answer or frame line, its CR or BEL included.
    fn line(&mut self) -> Vec<u8> {
        let end = Wall::now() + PATIENCE;
        loop {
            if let Some(last) = self.read.iter().position(|octet| matches!(octet, b'\r' | 7)) {
                return self.read.drain(..=last).collect();
            }
            assert!(Wall::now() < end, "no line within {PATIENCE:?}");
            self.look();
            thread::sleep(Duration::from_micros(200));
        }
    }

    /// The next frame; answers between are skipped.
    fn frame(&mut self) -> Frame {
        loop {
            let line = self.line();
            if let Some(frame) = line.split_last().and_then(|(_, line)| parse_frame(line)) {
                return frame.unwrap();
            }
        }
    }

    /// The next answer; frames between are skipped.
    fn ask(&mut self, line: &[u8]) -> Vec<u8> {
        self.write(line);
        loop {
            let line = self.line();
            if line.split_last().and_then(|(_, line)| parse_frame(line)).is_none() {
                return line;
            }
        }
    }

    /// Answered after all before it was read: nothing else has come.
    fn expect_only(&mut self, line: &[u8], answers: &[u8]) {
        self.write(line);
        self.write(b"N\r");
        let mut read = Vec::new();
        while !read.ends_with(b"NPD01\r") {
            read.extend(self.line());
        }
        read.truncate(read.len() - b"NPD01\r".len());
        assert_eq!(read.escape_ascii().to_string(), answers.escape_ascii().to_string());
    }

    fn expect_silence(&mut self) {
        thread::sleep(Duration::from_millis(50));
        self.look();
        assert!(self.read.is_empty(), "{:?}", self.read);
    }
}

fn sdo(number: u16) -> Vec<u8> {
    format!("t{:03X}84000100000000000\r", 0x600 + number).into_bytes()
}

#[test]
fn l_01_every_command_in_either_case_split_and_joined() {
    let lines: [(&[u8], &[u8]); 18] = [
        (b"C\r", b"\r"),
        (b"S6\r", b"\r"),
        (b"s031c\r", b"\r"),
        (b"\r", b"\r"),
        (b"V\r", b"V1010\r"),
        (b"v\r", b"v1010\r"),
        (b"F\r", b"F00\r"),
        (b"Z0\r", b"\r"),
        (b"M00000000\r", b"\r"),
        (b"mffffFFFF\r", b"\r"),
        (b"W1\r", b"\r"),
        (b"U2\r", b"\r"),
        (b"X1\r", b"\r"),
        (b"Q0\r", b"\r"),
        (b"O\r\n", b"\r"),
        (b"t1232abCD\r", b"z\r"),
        (b"T0000aBcD0\rr1231\r", b"Z\rz\r"),
        (b"R000000008\rO\r", b"Z\r\r"),
    ];
    for line in [Running::pty([], SELDOM), Running::tcp([], SELDOM)] {
        let mut master = if line.name.contains("tcp") { line.connect() } else { line.terminal() };
        for (command, answer) in lines {
            master.expect_only(command, answer);
        }
        let (joined, answers) = (lines.map(|line| line.0).concat(), lines.map(|line| line.1).concat());
        master.expect_only(b"C\r", b"\r");
        master.expect_only(&joined, &answers);
        master.expect_only(b"C\r", b"\r");
        for octet in joined {
            master.write(&[octet]);
        }
        master.expect_only(b"", &answers);
        let (mut line, _) = line.end();
        // Four each time: by line, joined, octet by octet. The last may still wait for the bus.
        let (ended, stop) = (Wall::now(), Stop::new().unwrap());
        while line.bus().counters().frames < 12 && ended.elapsed() < PATIENCE {
            line.turn(Stay::Awake, &stop, &mut |_| {}).unwrap();
        }
        assert_eq!(line.bus().counters().frames, 12);
        assert_eq!(line.bus().counters().remote, 6);
    }
}

#[test]
fn l_01_time_stamps_and_listen_only() {
    let line = Running::tcp([5], SELDOM);
    let (mut master, mut listener) = (line.connect(), line.connect());
    assert_eq!(listener.ask(b"L\r"), b"\r");
    assert_eq!(listener.ask(b"Z1\r"), b"\r");
    assert_eq!(listener.ask(b"t1230\r"), b"\x07");
    assert_eq!(master.ask(b"O\r"), b"\r");
    master.write(&sdo(5));
    for id in ["t605", "t585"] {
        let heard = listener.line();
        assert_eq!(heard.len(), b"t60584000100000000000MMMM\r".len());
        assert!(heard.starts_with(id.as_bytes()));
        let stamp = std::str::from_utf8(&heard[heard.len() - 5..heard.len() - 1]).unwrap();
        assert!(u16::from_str_radix(stamp, 16).unwrap() < 60_000);
    }
}

#[test]
fn l_02_malformed_lines_and_noise_are_refused_and_the_next_line_works() {
    for line in [Running::pty([5], SELDOM), Running::tcp([5], SELDOM)] {
        let mut master = if line.name.contains("tcp") { line.connect() } else { line.terminal() };
        assert_eq!(master.ask(b"O\r"), b"\r");
        for wrong in [
            &b"t12390\r"[..],
            b"t8000\r",
            b"T200000000\r",
            b"t123\r",
            b"t1231A\r",
            b"t12310G\r",
            b"t1230 \r",
            b"r12311234\r",
            b"S6\r",
            b"S\r",
            b"x\r",
            b"O1\r",
        ] {
            master.expect_only(wrong, b"\x07");
        }
        let noise: Vec<u8> = (0..=255_u8).filter(|octet| *octet != b'\r').cycle().take(10_000).collect();
        for long in [vec![b't'; 10_000], noise] {
            master.write(&long);
            master.expect_only(b"\r", b"\x07");
        }
        master.write(&sdo(5));
        assert_eq!(master.frame().to_string(), "585#40 00 10 00 00 00 00 00");
        let (line, news) = line.end();
        // The boot-up, the first heartbeat, and what was asked.
        assert_eq!(line.bus().counters().frames, 4);
        let refused = news.iter().filter(
            |news| matches!(news, News::Adapter { news, .. } if news.to_string().contains("refused")),
        );
        assert_eq!(refused.count(), 14);
    }
}

#[test]
fn l_03_while_closed_no_frame_passes_either_way() {
    for line in [Running::pty([5], OFTEN), Running::tcp([5], OFTEN)] {
        let mut master = if line.name.contains("tcp") { line.connect() } else { line.terminal() };
        master.expect_silence();
        master.expect_only(b"t00028105\rT000000000\rr7050\r", b"\x07\x07\x07");
        assert_eq!(master.ask(b"O\r"), b"\r");
        assert_eq!(master.frame().to_string(), "705#7F");
        assert_eq!(master.ask(b"C\r"), b"\r");
        master.expect_silence();
        master.expect_only(b"t00028105\r", b"\x07");
        assert_eq!(master.ask(b"O\r"), b"\r");
        assert_eq!(master.frame().to_string(), "705#7F", "no boot-up: the reset was refused");
    }
}

#[test]
fn l_04_a_master_leaves_without_goodbye_and_the_next_gets_fresh_frames() {
    for line in [Running::pty([5], SELDOM), Running::tcp([5], SELDOM)] {
        let tcp = line.name.contains("tcp");
        let open = || if tcp { line.connect() } else { line.terminal() };
        let mut first = open();
        assert_eq!(first.ask(b"O\r"), b"\r");
        // Answers that it does not read, and half a line.
        for _ in 0..20 {
            first.write(&sdo(5));
        }
        thread::sleep(Duration::from_millis(50));
        first.write(b"t12");
        thread::sleep(Duration::from_millis(20));
        drop(first);
        thread::sleep(Duration::from_millis(50));
        let mut second = open();
        second.expect_silence();
        assert_eq!(second.ask(b"O\r"), b"\r");
        second.write(b"t60582F00000000000000\r");
        assert_eq!(second.frame().to_string(), "585#2F 00 00 00 00 00 00 00");
    }
}

#[test]
fn l_04_a_master_that_does_not_read_stops_neither_the_bus_nor_others() {
    let line = Running::tcp([5], OFTEN);
    let (mut deaf, mut master) = (line.connect(), line.connect());
    deaf.write(b"O\r");
    assert_eq!(master.ask(b"O\r"), b"\r");
    // More than the kernel and the adapter keep for the one that does not read.
    for number in 0..20_000_u32 {
        master.write(format!("t12380000{number:08X}0000\r").as_bytes());
        master.look();
    }
    master.write(&sdo(5));
    while master.frame().id() != base(0x585) {}
    // Its own frames still go out, and what it reads once it does is whole.
    deaf.write(b"t60582300000000000000\r");
    while master.frame().id() != base(0x585) {}
    deaf.write(b"C\rO\rV\r");
    while deaf.line() != b"V1010\r" {}
    assert!(deaf.ask(b"F\r").starts_with(b"F"));
}

#[test]
fn l_04_nobody_reads_the_terminal_and_the_bus_goes_on() {
    let line = Running::pty([5], OFTEN);
    let mut deaf = line.terminal();
    deaf.write(b"O\r");
    // 500 heartbeats a second, ten octets each, fill the terminal in a second or two; SDO answers do so at once.
    for _ in 0..2000 {
        deaf.write(&sdo(5));
    }
    thread::sleep(Duration::from_millis(200));
    deaf.write(b"C\rO\rV\r");
    while deaf.line() != b"V1010\r" {}
    deaf.write(b"t60582F00000000000000\r");
    let end = Wall::now() + PATIENCE;
    while deaf.frame().octets().first() != Some(&0x2F) {
        assert!(Wall::now() < end, "only stale frames");
    }
    let (line, _) = line.end();
    assert!(line.bus().counters().frames > 4000, "requests and answers were all on the bus");
}

#[test]
fn l_05_two_masters_hear_each_other_and_the_nodes_and_not_themselves() {
    let line = Running::tcp([5], SELDOM);
    let (mut one, mut other) = (line.connect(), line.connect());
    assert_eq!((one.ask(b"O\r"), other.ask(b"O\r")), (b"\r".to_vec(), b"\r".to_vec()));
    one.write(&sdo(5));
    let answer = "585#40 00 10 00 00 00 00 00";
    assert_eq!(one.frame().to_string(), answer);
    assert_eq!(other.frame().to_string(), "605#40 00 10 00 00 00 00 00");
    assert_eq!(other.frame().to_string(), answer);
    other.write(b"R000001234\r");
    assert_eq!(one.frame().to_string(), "00000123#R4");
    other.expect_only(b"", b"Z\r");
    // One leaves; the other and its bus stay.
    drop(other);
    one.write(&sdo(5));
    assert_eq!(one.frame().to_string(), answer);
}

#[test]
fn l_06_127_nodes_answer_each_for_itself_and_boot_once_each() {
    let line = Running::pty(1..=127, SELDOM);
    let mut master = line.terminal();
    assert_eq!(master.ask(b"O\r"), b"\r");
    master.write(b"t00028100\r");
    for number in 1..=127 {
        let id = master.frame().to_string();
        assert_eq!(id, format!("{:03X}#00", 0x700 + number), "lowest identifier first");
    }
    for number in 1..=127 {
        master.write(&sdo(number));
        assert_eq!(master.frame().id(), base(0x580 + number));
    }
    master.expect_silence_of_frames();
}

impl Master {
    fn expect_silence_of_frames(&mut self) {
        thread::sleep(Duration::from_millis(50));
        self.look();
        while let Some(last) = self.read.iter().position(|octet| matches!(octet, b'\r' | 7)) {
            let line: Vec<u8> = self.read.drain(..=last).collect();
            assert!(line.len() <= 2, "{}", line.escape_ascii());
        }
    }
}

#[test]
fn the_link_to_the_terminal_replaces_links_and_never_files() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let open =
        |path: PathBuf| Line::<()>::open(&LinkSpec::Pty(Some(path)), BitRate::K125, Reach::ThisMachine);
    symlink("/nowhere/at/all", place("dangling")).unwrap();
    symlink("/dev/null", place("in-use")).unwrap();
    for name in ["new", "dangling", "in-use"] {
        let line = open(place(name)).unwrap();
        assert_eq!(line.name(), place(name).to_str().unwrap());
        assert!(fs::read_link(place(name)).unwrap().starts_with("/dev/pts"));
        drop(line);
        assert!(fs::symlink_metadata(place(name)).is_err(), "{name} is gone with the line");
    }
    fs::write(place("file"), "precious").unwrap();
    fs::create_dir(place("directory")).unwrap();
    for (name, expected) in [("file", PathOccupant::File), ("directory", PathOccupant::Directory)] {
        let error = open(place(name)).err().unwrap();
        assert!(matches!(error, Error::PathTaken { found, .. } if found == expected), "{error}");
    }
    assert_eq!(fs::read_to_string(place("file")).unwrap(), "precious");
}

#[test]
fn a_port_that_others_could_reach_is_refused_unless_they_are_invited() {
    let spec: LinkSpec = "slcan-tcp:0.0.0.0:0".parse().unwrap();
    let error = Line::<()>::open(&spec, BitRate::K125, Reach::ThisMachine).err().unwrap();
    assert!(matches!(error, Error::TcpReach { .. }), "{error}");
    assert!(Line::<()>::open(&spec, BitRate::K125, Reach::Network).is_ok());
    for text in ["slcan-pty:", "slcan-tcp", "slcan-tcp:5000", "pty:/tmp/a", "slcan:/tmp/a", ""] {
        assert!(text.parse::<LinkSpec>().is_err(), "{text}");
    }
}

#[test]
fn an_idle_line_sleeps() {
    let mut line: Line<()> = Line::open(&LinkSpec::Pty(None), BitRate::K1000, Reach::ThisMachine).unwrap();
    for number in 1..=127 {
        line.add(Node::boxed(number, SELDOM, channel().0));
    }
    let stop = Stop::new().unwrap();
    let asked = stop.clone();
    let later = thread::spawn(move || {
        thread::sleep(Duration::from_millis(300));
        asked.request();
    });
    let mut turns = 0;
    while !stop.is_requested() {
        line.turn(Stay::Sleep, &stop, &mut |_| {}).unwrap();
        turns += 1;
    }
    later.join().unwrap();
    assert_eq!(line.bus().counters().frames, 254, "a boot-up and a heartbeat of each");
    // One for the end of each frame and one for the bits between, and some when the terminal was opened.
    assert!(turns < 600, "{turns} turns in 300 ms");
}
