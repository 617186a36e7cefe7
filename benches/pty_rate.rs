//! Exchanges per second over a pseudo-terminal: `emulate` against an echo slave that answers from a table and checks
//! nothing, with profirust and with pyprofibus as master. Pairs of runs, one after the other, so that whatever else the
//! machine does hits both. `bash benches/pty_rate.sh`, which provides pyprofibus.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::std_instead_of_core,
    reason = "a bench may panic, and has std"
)]
#![cfg_attr(not(target_os = "linux"), allow(unused_imports, dead_code))]

use core::time::Duration;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use profidrive::host::link::serial::Serial;
use profidrive::host::{Clock, Link, Stop, SystemClock};
use profidrive::master::{LinkPhy, baudrate, instant, peripheral};
use profidrive::time::BaudRate;
use profirust::dp::DpMaster;
use profirust::fdl::{FdlActiveStation, ParametersBuilder};

const BAUD: BaudRate = BaudRate::K12000;
/// How long each master exchanges data with each slave in a round.
const SECONDS: f64 = 2.0;
const ROUNDS: usize = 7;

/// Exchanges per second of a master with the slave at a terminal.
type Rate<'a> = &'a dyn Fn(&str) -> f64;

fn main() {
    if std::env::args().any(|argument| argument == "--echo") {
        return echo();
    }
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let python = std::env::var("PYPROFIBUS_PYTHON").ok();
    if python.is_none() {
        println!("without pyprofibus: run bash benches/pty_rate.sh");
    }
    let masters: [(&str, Rate<'_>); 2] = [
        ("profirust", &profirust_rate),
        ("pyprofibus", &|terminal| python.as_ref().map_or(0.0, |python| pyprofibus_rate(python, terminal))),
    ];
    println!(
        "{:<12}{:>14}{:>14}{:>8}   exchanges per second, medians of {ROUNDS} pairs",
        "", "emulate", "echo", "ratio"
    );
    for (name, rate) in masters.iter().take(1 + usize::from(python.is_some())) {
        let pairs: Vec<_> = (0..ROUNDS)
            .map(|round| {
                let emulate = || rate(&Slave::emulate().terminal);
                let echo = || rate(&Slave::echo().terminal);
                if round % 2 == 0 {
                    let emulate = emulate();
                    (emulate, echo())
                } else {
                    let echo = echo();
                    (emulate(), echo)
                }
            })
            .collect();
        let median = |of: &dyn Fn(&(f64, f64)) -> f64| {
            let mut values: Vec<f64> = pairs.iter().map(of).collect();
            values.sort_unstable_by(f64::total_cmp);
            values[ROUNDS / 2]
        };
        let (emulate, echo) = (median(&|pair| pair.0), median(&|pair| pair.1));
        println!("{name:<12}{emulate:>14.0}{echo:>14.0}{:>8.3}", median(&|pair| pair.0 / pair.1));
    }
}

/// A process with a slave at address 5 at the other end of a terminal.
struct Slave {
    process: Child,
    terminal: String,
}

impl Slave {
    fn emulate() -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
        Self::start(command.args(["emulate", "-q", "--drive", "5"]))
    }

    fn echo() -> Self {
        Self::start(Command::new(std::env::current_exe().unwrap()).arg("--echo"))
    }

    /// The line on stdout says `link=` and the terminal.
    fn start(command: &mut Command) -> Self {
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let terminal = line.split_whitespace().find_map(|word| word.strip_prefix("link="));
        Self { process, terminal: terminal.unwrap().to_owned() }
    }
}

impl Drop for Slave {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Exchanges per second of profirust, which is asked to poll as often as it can.
fn profirust_rate(terminal: &str) -> f64 {
    let mut dp = DpMaster::new(Vec::new());
    let drive = dp.add(peripheral(5, BAUD));
    dp.enter_operate();
    // A slot time of 0.5 ms, and many retries for a machine with other things to do. Looking for other masters seldom,
    // for it costs one.
    let parameters = ParametersBuilder::new(2, baudrate(BAUD))
        .slot_bits(6_000)
        .highest_station_address(6)
        .gap_wait_rotations(100)
        .max_retry_limit(15)
        .build_verified(&dp);
    let mut fdl = FdlActiveStation::new(parameters);
    fdl.set_online();
    let mut phy = LinkPhy::new(Serial::open(terminal, BAUD).unwrap(), BAUD);
    let (clock, stop) = (SystemClock::new(), Stop::new().unwrap());
    let (mut begun, mut cycles) = (None, 0_u32);
    loop {
        fdl.poll(instant(clock.now()), &mut phy, &mut dp);
        let now = clock.now();
        if dp.take_last_events().cycle_completed && dp.get_mut(drive).is_running() {
            cycles += 1;
            begun.get_or_insert_with(|| {
                cycles = 0;
                now
            });
        }
        if let Some(begun) = begun {
            let passed = now.saturating_since(begun).as_secs_f64();
            if passed >= SECONDS {
                return f64::from(cycles) / passed;
            }
        }
        assert!(now.as_nanos() < 30_000_000_000, "no Data_Exchange, or too little, within 30 s");
        phy.link_mut().wait(Some(Duration::from_micros(20)), &stop).unwrap();
    }
}

fn pyprofibus_rate(python: &str, terminal: &str) -> f64 {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/pty_rate.py");
    let output = Command::new(python).args([script, terminal, &SECONDS.to_string()]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    // The rate is the last line, behind warnings of pyprofibus.
    let rate = said.lines().last().and_then(|line| line.parse().ok());
    rate.unwrap_or_else(|| panic!("{said}{}", String::from_utf8_lossy(&output.stderr)))
}

#[cfg(not(target_os = "linux"))]
fn echo() {}

/// A slave of two system calls per request: reads, looks at two octets, writes what lies ready.
#[cfg(target_os = "linux")]
fn echo() {
    use rustix::pty::OpenptFlags;
    use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

    let framed = |counted: &[u8]| {
        let (le, fcs) =
            (counted.len() as u8, counted.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet)));
        [&[0x68, le, le, 0x68], counted, &[fcs, 0x16]].concat()
    };
    let data = framed(&[&[2, 5, 8], &[0; 14][..]].concat());
    let diagnosis = framed(&[0x82, 0x85, 8, 62, 60, 0, 0x0C, 0, 2, 0x0A, 0xC5]);
    let line = rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    rustix::pty::grantpt(&line).unwrap();
    rustix::pty::unlockpt(&line).unwrap();
    let terminal = rustix::pty::ptsname(&line, Vec::new()).unwrap().into_string().unwrap();
    // Held open, so that a master that closes it does not end this.
    let held = std::fs::File::options().read(true).write(true).open(&terminal).unwrap();
    let mut raw = tcgetattr(&held).unwrap();
    raw.make_raw();
    tcsetattr(&held, OptionalActions::Now, &raw).unwrap();
    println!("ready link={terminal} drives=5");
    let (mut buf, mut len) = ([0; 1024], 0);
    loop {
        len += rustix::io::read(&line, &mut buf[len..]).unwrap();
        let mut at = 0;
        while at < len {
            let whole = match buf[at] {
                0x68 if at + 1 < len => usize::from(buf[at + 1]) + 6,
                0x10 => 6,
                0xDC => 3,
                0x68 => usize::MAX,
                _ => 1,
            };
            if len - at < whole {
                break;
            }
            let reply: &[u8] = match &buf[at..at + whole] {
                [0x10, 5, ..] => &[0x10, 2, 5, 0, 7, 0x16],
                [0x68, _, _, _, 5, ..] => &data,
                [0x68, _, _, _, 0x85, _, _, 60, ..] => &diagnosis,
                [0x68, _, _, _, 0x85, _, _, 61 | 62, ..] => &[0xE5],
                _ => &[],
            };
            if !reply.is_empty() {
                rustix::io::write(&line, reply).unwrap();
            }
            at += whole;
        }
        buf.copy_within(at..len, 0);
        len -= at;
    }
}
