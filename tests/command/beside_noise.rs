//! `profidrive master` and a [`Session`] on a line on which anything may be heard: random octets, tokens, short
//! acknowledges, telegrams of stations that are not there. No run panics or hangs; each ends with status 0, or with 1 and
//! one sentence.
//!
//! Some seconds of it, and with `PROFIDRIVE_LONG` an hour; `PROFIDRIVE_NOISE=SECONDS` says otherwise, and
//! `PROFIDRIVE_NOISE_SEED` with which octets. `--nocapture` shows each run.

use core::time::Duration;
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Instant;

use profidrive::host::link::tcp::Connection;
use profidrive::host::{Stop, SystemClock};
use profidrive::master::{Session, SessionError, Settings};
use profidrive::profibus::fdl::Address;
use profidrive::profibus::ppo::{Outputs, Pkw, Stw};
use profidrive::time::BaudRate;

use crate::master_command::rig::{Emulator, Running, profidrive};

/// A run that takes longer hangs: a scan beside other masters takes a minute and a half.
const LONGEST: Duration = Duration::from_secs(180);

/// Emulators, each with a line on which one command runs after the other.
const LINES: u64 = 3;

/// What is asked. Only addresses that a scan needs some seconds for.
const COMMANDS: [&[&str]; 12] = [
    &["scan", "1-12"],
    &["read", "v-Pos"],
    &["read", "945.0"],
    &["monitor", "--for", "3s"],
    &["move", "300", "--yes"],
    &["move", "0", "--yes"],
    &["status"],
    &["params"],
    &["diag"],
    &["write", "v-Pos", "60"],
    &["jog", "+", "--yes", "--for", "500ms"],
    &["faults"],
];

/// Numbers that look random, the same for the same seed.
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % end.max(1)
    }

    fn octet(&mut self) -> u8 {
        self.below(256) as u8
    }

    fn octets(&mut self, most: u64) -> Vec<u8> {
        (0..=self.below(most)).map(|_| self.octet()).collect()
    }
}

/// How much is heard.
#[derive(Clone, Copy, Debug)]
enum Amount {
    /// A piece now and then, so that most of what is asked is answered.
    Little,
    /// Several pieces a second.
    Some,
    /// Beside every telegram, before and behind it.
    EachTelegram,
    /// Without a pause in which a master could claim the token.
    Flood,
}

impl Amount {
    fn any(random: &mut Random) -> Self {
        match random.below(10) {
            0..4 => Self::Little,
            4..6 => Self::Some,
            6..9 => Self::EachTelegram,
            _ => Self::Flood,
        }
    }

    /// From one piece to the next.
    fn pause(self, random: &mut Random) -> Duration {
        Duration::from_millis(match self {
            Self::Little => 500 + random.below(4_000),
            Self::Some => 20 + random.below(400),
            Self::EachTelegram => 2_000,
            Self::Flood => random.below(30),
        })
    }

    /// Whether one is heard beside a telegram.
    fn beside(self, random: &mut Random) -> bool {
        random.below(100)
            < match self {
                Self::Little => 1,
                Self::Some => 10,
                Self::EachTelegram | Self::Flood => 60,
            }
    }
}

/// SD1 with any function code.
fn short_telegram(random: &mut Random) -> Vec<u8> {
    let [da, sa, fc] = [random.below(8) as u8, random.below(8) as u8, random.octet()];
    vec![0x10, da, sa, fc, da.wrapping_add(sa).wrapping_add(fc), 0x16]
}

/// SD2 with any content, often of drive 5 to master 0.
fn long_telegram(random: &mut Random) -> Vec<u8> {
    let data = random.octets(40);
    let mut body = vec![0, 5, 8];
    if random.below(2) == 0 {
        body = vec![0x80, 0x85, 0x08, 0x3E, 0x3C];
    }
    body.extend(data);
    let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
    let length = body.len() as u8;
    [&[0x68, length, length, 0x68][..], &body, &[sum, 0x16]].concat()
}

fn piece(random: &mut Random) -> Vec<u8> {
    match random.below(8) {
        0 => vec![0xE5],
        1 => vec![0xDC, 0, random.below(6) as u8],
        // None of this master's own address: it would give up.
        2 => vec![0xDC, random.below(6) as u8, 1 + random.below(6) as u8],
        3 => vec![0xDC, random.octet(), random.octet()],
        4 => short_telegram(random),
        5 => long_telegram(random),
        // Half of a telegram, of which the rest never comes.
        6 => long_telegram(random).split_off(3),
        _ => random.octets(60),
    }
}

/// A place between a master and its line, at which noise is heard by both; how many pieces it was.
struct Noise {
    place: String,
    pieces: Arc<AtomicU64>,
    over: Arc<AtomicBool>,
    line: Option<thread::JoinHandle<()>>,
}

impl Noise {
    /// For one master, which has left when this goes.
    fn on(line: &str, amount: Amount, seed: u64) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let place = format!("tcp:{}", listener.local_addr().unwrap());
        let line = line.strip_prefix("tcp:").unwrap().to_owned();
        let (pieces, over) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
        let (count, end) = (Arc::clone(&pieces), Arc::clone(&over));
        let serve = move || {
            let (master, _) = listener.accept().unwrap();
            if end.load(Ordering::Relaxed) {
                return;
            }
            let slaves = TcpStream::connect(line).unwrap();
            let ends = [&master, &slaves].map(|end| {
                end.set_nodelay(true).unwrap();
                Mutex::new(end.try_clone().unwrap())
            });
            thread::scope(|scope| {
                for (from, place) in [(&master, 1), (&slaves, 0)] {
                    let (ends, count) = (&ends, &count);
                    scope.spawn(move || {
                        pass_on(from, ends, place, amount, Random(seed ^ place as u64), count)
                    });
                }
                let mut random = Random(seed ^ 77);
                while !end.load(Ordering::Relaxed) {
                    let next = Instant::now() + amount.pause(&mut random);
                    while Instant::now() < next && !end.load(Ordering::Relaxed) {
                        thread::sleep(Duration::from_millis(5));
                    }
                    heard(&ends, &piece(&mut random), &count);
                }
                // Either of them is waited at.
                for end in [&master, &slaves] {
                    let _ = end.shutdown(Shutdown::Both);
                }
            });
        };
        Self { place, pieces, over, line: Some(thread::spawn(serve)) }
    }

    fn pieces(&self) -> u64 {
        self.pieces.load(Ordering::Relaxed)
    }
}

impl Drop for Noise {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        // A master that never came.
        drop(TcpStream::connect(self.place.trim_start_matches("tcp:")));
        let ended = self.line.take().unwrap().join();
        assert!(ended.is_ok() || thread::panicking(), "the noise of the test failed");
    }
}

/// Both ends hear `octets`, unless they are gone.
fn heard(ends: &[Mutex<TcpStream>; 2], octets: &[u8], count: &AtomicU64) {
    count.fetch_add(1, Ordering::Relaxed);
    for end in ends {
        let _ = end.lock().unwrap().write_all(octets);
    }
}

/// What comes from one end reaches the other, with noise before it, behind it or in place of it.
fn pass_on(
    mut from: &TcpStream,
    ends: &[Mutex<TcpStream>; 2],
    to: usize,
    amount: Amount,
    mut random: Random,
    count: &AtomicU64,
) {
    let mut octets = [0; 512];
    while let Ok(length @ 1..) = from.read(&mut octets) {
        if amount.beside(&mut random) {
            heard(ends, &piece(&mut random), count);
            if random.below(8) == 0 {
                continue;
            }
        }
        if ends[to].lock().unwrap().write_all(&octets[..length]).is_err() {
            return;
        }
        if amount.beside(&mut random) {
            heard(ends, &piece(&mut random), count);
        }
    }
}

/// How runs ended, and how many of them so.
type Endings = Mutex<BTreeMap<String, u32>>;

/// Sentences that differ in a number only are counted as one.
fn note(endings: &Endings, what: &str, sentence: &str) {
    println!("{what}: {sentence}");
    let sentence: String = sentence.chars().map(|c| if c.is_ascii_digit() { '0' } else { c }).collect();
    *endings.lock().unwrap().entry(format!("{what}: {sentence}")).or_default() += 1;
}

/// One command beside noise.
fn command(emulator: &Emulator, seed: u64, endings: &Endings) {
    let mut random = Random(seed);
    let (amount, arguments) =
        (Amount::any(&mut random), COMMANDS[random.below(COMMANDS.len() as u64) as usize]);
    let noise = Noise::on(&emulator.link, amount, seed);
    let what = format!("{arguments:?} beside {amount:?}, seed {seed}");
    let address = ["--link", &noise.place, "--address", "5"];
    let mut run = Running::start(profidrive(&[&["master"][..], &address, arguments].concat()));
    let start = Instant::now();
    while run.process.try_wait().unwrap().is_none() {
        assert!(start.elapsed() < LONGEST, "{what}: still runs after {LONGEST:?}");
        thread::sleep(Duration::from_millis(5));
    }
    let (status, stdout, stderr) = run.end();
    assert!(noise.pieces() > 0 || start.elapsed() < Duration::from_secs(5), "{what}: nothing was heard");
    let sentence = match status {
        Some(0) => String::new(),
        Some(1) => {
            assert_eq!(stderr.lines().count(), 1, "{what}: {stderr}");
            assert!(stderr.starts_with("profidrive: ") && stderr.len() > 30, "{what}: {stderr}");
            stderr.trim().to_owned()
        }
        other => panic!("{what}: status {other:?}: {stdout}{stderr}"),
    };
    for word in ["panicked", "mistake in profidrive", "backtrace"] {
        assert!(!stderr.contains(word), "{what}: {stderr}");
    }
    let what = format!("{} {amount:?}, status {}", arguments[0], status.unwrap_or_default());
    note(endings, &what, &sentence);
}

/// The library's master beside noise: found, asked, started, exchanged with, released.
fn session(emulator: &Emulator, seed: u64, endings: &Endings) {
    let mut random = Random(seed);
    let amount = Amount::any(&mut random);
    let noise = Noise::on(&emulator.link, amount, seed);
    let link = Connection::open(noise.place.trim_start_matches("tcp:")).unwrap();
    let settings = Settings::untimed(Address::from_octet(0), BaudRate::K500);
    let mut session = Session::new(link, SystemClock::new(), Stop::new().unwrap(), settings).unwrap();
    let address = Address::from_octet(5);
    let outcomes = [
        session.find((1..8).map(Address::from_octet), |_, _| {}),
        session.diagnosis(address).map(drop),
        session.start(address),
        (0..200).try_for_each(|_| {
            let outputs = Outputs::octets(Pkw::ZERO, Stw::from_raw(0x003A), 0);
            session.exchange(&outputs).map(drop)
        }),
        session.release(),
    ];
    for (step, outcome) in ["find", "diagnosis", "start", "exchange", "release"].iter().zip(outcomes) {
        let sentence = outcome.as_ref().map_or_else(ToString::to_string, |()| "done".into());
        assert!(
            !matches!(outcome, Err(SessionError::Library(_))),
            "session, seed {seed}, {step}: {sentence}"
        );
        note(endings, &format!("session {amount:?}, {step}"), &sentence);
    }
}

fn setting(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|value| value.parse().unwrap())
}

#[test]
fn a_master_beside_noise_ends_with_a_status_and_a_sentence() {
    let usual = if std::env::var_os("PROFIDRIVE_LONG").is_some() { 3600 } else { 4 };
    let time = Duration::from_secs(setting("PROFIDRIVE_NOISE").unwrap_or(usual));
    let seed = setting("PROFIDRIVE_NOISE_SEED").unwrap_or(25);
    let (start, endings) = (Instant::now(), Endings::default());
    thread::scope(|scope| {
        for line in 0..=LINES {
            let endings = &endings;
            scope.spawn(move || {
                let emulator = Emulator::start("tcp:127.0.0.1:0", &[]);
                let mut run = 0;
                while run == 0 || start.elapsed() < time {
                    let seed = seed + 1_000 * run + 7 * line;
                    match line {
                        LINES => session(&emulator, seed, endings),
                        _ => command(&emulator, seed, endings),
                    }
                    run += 1;
                }
            });
        }
    });
    let endings = endings.into_inner().unwrap();
    println!("\n{} runs and steps in {:?}", endings.values().sum::<u32>(), start.elapsed());
    for (ending, count) in &endings {
        println!("{count:6} {ending}");
    }
    assert!(endings.values().sum::<u32>() > LINES as u32);
}
