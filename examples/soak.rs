//! An hour of profirust against a running `emulate`, over a pseudo-terminal, and why each retry came:
//!
//! ```sh
//! cargo build --release --features cli
//! cargo run --release --features cli --example soak -- 3600 target/release/profidrive 500000
//! ```
//!
//! The kernel carries the octets of a pseudo-terminal in a thread of its own, which no priority of ours reaches: the
//! busier the machine, the slower the rate must be, whose slot time is the longer.
//!
//! A retry is the master's fault if the reply was there and the master had not looked, or if the master itself slept
//! through half of the slot time (a machine that stands still wakes both, in any order); otherwise the emulator was
//! late, and the run has failed. On a busy machine run it with `nice -n -5` or `chrt -f 10`. While it lasts the drive travels, and parameters are written and read back. Each
//! minute prints a line; the memory of the emulator in it must not grow.

use core::cell::RefCell;
use core::error::Error;
use core::time::Duration;
use std::collections::VecDeque;
use std::fs;
use std::io::{self, BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::rc::Rc;
use std::thread::{self, JoinHandle};

use profidrive::host::link::serial::Serial;
use profidrive::host::{Clock, Link, Received, Stop, SystemClock};
use profidrive::master::{LinkPhy, baudrate, instant, peripheral};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Function, Telegram};
use profidrive::profibus::ppo::{Ind, Inputs, JobId, Outputs, Pke, Pkw, ReplyId, Stw};
use profidrive::time::{BaudRate, Instant};
use profirust::dp::{DpMaster, PeripheralHandle};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};

/// The most a master configurator allows, 16383 T_bit: 33 ms at 500 kbit/s, 1.7 s at 9.6 kbit/s.
const SLOT_BITS: u16 = 16_383;
/// The master is station 2.
const DRIVES: [u8; 12] = [0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
/// How long an output is held at least.
const HOLD: Duration = Duration::from_secs(3);
/// PNU 1018, upper limit.
const LIMIT_1: u16 = 1018;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(seconds), Some(program), Some(rate)) = (arguments.next(), arguments.next(), arguments.next())
    else {
        return Err("usage: soak SECONDS PATH_OF_PROFIDRIVE RATE".into());
    };
    let (mut emulator, terminal) = Emulator::start(&program)?;
    let mut master = Master::open(&terminal, BaudRate::from_bits_per_second(rate.parse()?)?)?;
    let outcome = master.run(Duration::from_secs(seconds.parse()?), emulator.process.id());
    let log = emulator.end()?;
    if outcome.is_err() {
        println!("{log}");
    }
    outcome?;

    let seen = master.seen.borrow();
    println!("{seen}");
    // What the slave has counted itself: `emulate` logs it when it ends.
    log.lines()
        .filter(|line| line.contains(" heard ") || line.contains(" retries;"))
        .for_each(|line| println!("{line}"));
    if seen.emulator_late > 0 {
        return Err(format!("{} retries were the emulator's fault", seen.emulator_late).into());
    }
    Ok(())
}

/// A running `profidrive emulate` and its log; dropped, it is killed.
struct Emulator {
    process: Child,
    log: Option<JoinHandle<io::Result<String>>>,
}

impl Emulator {
    /// Returns its terminal too.
    fn start(program: &str) -> Result<(Self, String), Box<dyn Error>> {
        let mut command = Command::new(program);
        command
            .args(["emulate", "--drives", "0-1", "--drives", "3-12"])
            .env_remove("RUST_LOG")
            .stdin(Stdio::null());
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
        let (stdout, stderr) = (process.stdout.take().ok_or("no stdout")?, process.stderr.take());
        // Read all the time: a full pipe would stop the emulator.
        let log = stderr.map(|stderr| thread::spawn(move || io::read_to_string(stderr)));
        let emulator = Self { process, log };
        let mut ready = String::new();
        BufReader::new(stdout).read_line(&mut ready)?;
        let terminal = ready.split(' ').find_map(|word| word.strip_prefix("link="));
        let terminal = terminal.ok_or_else(|| format!("not ready: {ready:?}"))?.to_owned();
        Ok((emulator, terminal))
    }

    /// Ends it as a user does and returns its log.
    fn end(&mut self) -> io::Result<String> {
        Command::new("kill").args(["-TERM", &self.process.id().to_string()]).status()?;
        self.process.wait()?;
        self.log.take().map_or(Ok(String::new()), |log| log.join().unwrap_or_else(|_| Ok(String::new())))
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _gone = self.process.kill();
        let _gone = self.process.wait();
    }
}

/// profirust with twelve drives.
struct Master {
    fdl: FdlActiveStation,
    dp: DpMaster<'static>,
    phy: LinkPhy<Overheard>,
    drives: Vec<(PeripheralHandle, Play)>,
    clock: SystemClock,
    stop: Stop,
    seen: Rc<RefCell<Seen>>,
}

impl Master {
    fn open(terminal: &str, baud: BaudRate) -> Result<Self, Box<dyn Error>> {
        let mut dp = DpMaster::new(Vec::new());
        let mut drives = Vec::new();
        for address in DRIVES {
            drives.push((dp.add(peripheral(address, baud)), Play::default()));
        }
        dp.enter_operate();
        // With every token profirust asks one address below the highest whether it is a master, itself among them. The
        // other two are drives, which answer; one that does not costs a slot time.
        let parameters = ParametersBuilder::new(2, baudrate(baud))
            .highest_station_address(3)
            .token_rotation_bits(1_000_000)
            .slot_bits(SLOT_BITS)
            .max_retry_limit(15)
            .build_verified(&dp);
        let mut fdl = FdlActiveStation::new(parameters);
        fdl.set_online();
        let seen = Rc::new(RefCell::new(Seen::default()));
        let clock = SystemClock::new();
        let link = Overheard {
            link: Serial::open(terminal, baud)?,
            clock: SystemClock::new(),
            looked_ahead: VecDeque::new(),
            request: Vec::new(),
            asked: None,
            baud,
            looked: Instant::ZERO,
            longest_pause: Duration::ZERO,
            seen: Rc::clone(&seen),
        };
        Ok(Self { fdl, dp, phy: LinkPhy::new(link, baud), drives, clock, stop: Stop::new()?, seen })
    }

    fn run(&mut self, time: Duration, emulator: u32) -> Result<(), Box<dyn Error>> {
        let begun = self.clock.now();
        let mut next_line = begun;
        loop {
            let now = self.clock.now();
            if now >= next_line {
                let minute = now.saturating_since(begun).as_secs() / 60;
                let travels: u32 = self.drives.iter().map(|(_, play)| play.travels).sum();
                let jobs: u32 = self.drives.iter().map(|(_, play)| play.jobs).sum();
                println!(
                    "{minute} min: {}; {travels} travels, {jobs} jobs; emulator {} KiB",
                    self.seen.borrow(),
                    resident(emulator)?
                );
                next_line = next_line.saturating_add(Duration::from_secs(60));
            }
            if now.saturating_since(begun) >= time {
                return Ok(());
            }
            self.fdl.poll(instant(now), &mut self.phy, &mut self.dp);
            if let Some(error) = self.phy.take_error() {
                return Err(error.into());
            }
            for (handle, play) in &mut self.drives {
                let drive = self.dp.get_mut(*handle);
                if drive.is_running() {
                    let outputs = play.next(Inputs::parse(drive.pi_i())?, now)?;
                    drive.pi_q_mut().copy_from_slice(&outputs);
                } else if now.saturating_since(begun) > Duration::from_secs(60) {
                    return Err(format!("drive {} is not in Data_Exchange", drive.address()).into());
                }
            }
            self.phy.link_mut().wait(Some(Duration::from_millis(2)), &self.stop)?;
        }
    }
}

/// Memory of a process in KiB.
fn resident(process: u32) -> io::Result<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status"))?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    Ok(line.and_then(|line| line.trim().strip_suffix(" kB")?.parse().ok()).unwrap_or(0))
}

/// What the application of the master does: travels to and fro, and writes a limit and reads it back.
#[derive(Default)]
struct Play {
    travels: u32,
    jobs: u32,
    enabled: u8,
    far: bool,
    start: Option<Instant>,
    starts_missed: u32,
    job: Option<Pkw>,
    reading: bool,
}

impl Play {
    fn next(&mut self, inputs: Inputs<'_>, now: Instant) -> Result<[u8; 14], Box<dyn Error>> {
        let pkw = self.parameters(inputs.pkw())?;
        let target = if self.far { 2_000 } else { 0 };
        let zsw = inputs.zsw();
        // OFF1 first; then operation enabled, intermediate stop released, start.
        let stw = match self.enabled {
            0 => {
                self.enabled = if zsw.bit(0) { 1 } else { 0 };
                0x0000
            }
            1 => {
                self.enabled = if zsw.bit(2) { 2 } else { 1 };
                0x000B
            }
            _ => {
                let arrived = zsw.bit(10) && inputs.hiw().abs_diff(target) <= 5;
                match self.start.map(|begun| now.saturating_since(begun)) {
                    None => {
                        self.start = Some(now);
                        0x003B
                    }
                    // Some exchanges long, so that the start is an edge; again if the machine slept through them.
                    Some(ago) if ago < HOLD => 0x003B,
                    Some(ago) if ago > 10 * HOLD => {
                        self.start = None;
                        self.starts_missed += 1;
                        if self.starts_missed > 10 {
                            return Err(format!("no travel: ZSW {zsw:?} at {}", inputs.hiw()).into());
                        }
                        0x003B
                    }
                    Some(ago) if arrived && ago > 2 * HOLD => {
                        self.travels += 1;
                        self.starts_missed = 0;
                        self.far = !self.far;
                        self.start = None;
                        0x003B
                    }
                    Some(_) => 0x007B,
                }
            }
        };
        Ok(Outputs::octets(pkw, Stw::from_raw(stw), if self.far { 2_000 } else { 0 }))
    }

    /// Writes a value, takes the job back, reads it, takes the job back.
    fn parameters(&mut self, reply: Pkw) -> Result<Pkw, Box<dyn Error>> {
        let value = 200_000 + self.jobs / 2 % 1_000;
        match self.job {
            None if reply == Pkw::ZERO => {
                self.job = Some(if self.reading {
                    Pkw::new(Pke::of_job(JobId::Read, LIMIT_1), Ind::default(), 0)
                } else {
                    Pkw::new(Pke::of_job(JobId::WriteDoubleWord, LIMIT_1), Ind::default(), value)
                });
            }
            Some(_) if reply != Pkw::ZERO => {
                let expected = Pkw::new(Pke::of_reply(ReplyId::DoubleWord, LIMIT_1), Ind::default(), value);
                if reply != expected {
                    return Err(format!("PKW reply {reply}, expected {expected}").into());
                }
                self.jobs += 1;
                self.reading = !self.reading;
                self.job = None;
            }
            None | Some(_) => {}
        }
        Ok(self.job.unwrap_or(Pkw::ZERO))
    }
}

/// What was said on the line.
#[derive(Default)]
struct Seen {
    /// Requests that want a reply, without retries.
    requests: u64,
    /// Retries whose reply was there, and the master had not looked, or had slept.
    master_late: u64,
    /// Retries whose reply was not there.
    emulator_late: u64,
    slowest_reply: Duration,
}

impl core::fmt::Display for Seen {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { requests, master_late, emulator_late, slowest_reply } = self;
        write!(
            f,
            "{requests} requests, retries: {master_late} of a late master, {emulator_late} of a late emulator; "
        )?;
        write!(f, "slowest reply {slowest_reply:?}")
    }
}

/// A link that notes what passes.
struct Overheard {
    link: Serial,
    clock: SystemClock,
    /// Heard while judging a retry, and not handed over yet.
    looked_ahead: VecDeque<u8>,
    /// The last counted request, and when it was said if nothing has come since.
    request: Vec<u8>,
    asked: Option<Instant>,
    baud: BaudRate,
    /// When the master looked last, and the longest it has not since it asked.
    looked: Instant,
    longest_pause: Duration,
    seen: Rc<RefCell<Seen>>,
}

impl Overheard {
    fn look(&mut self) {
        let now = self.clock.now();
        self.longest_pause = self.longest_pause.max(now.saturating_since(self.looked));
        self.looked = now;
    }
}

impl Link for Overheard {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        self.look();
        if !self.looked_ahead.is_empty() {
            let count = self.looked_ahead.read(buf)?;
            return Ok(Received::Octets(count));
        }
        let received = self.link.receive(buf)?;
        if matches!(received, Received::Octets(_))
            && let Some(asked) = self.asked.take()
        {
            let mut seen = self.seen.borrow_mut();
            seen.slowest_reply = seen.slowest_reply.max(self.clock.now().saturating_since(asked));
        }
        Ok(received)
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        if is_counted(telegram) {
            if self.asked.is_some() && self.request == telegram {
                let mut buf = [0; 256];
                let answered = match self.link.receive(&mut buf)? {
                    Received::Octets(count) => {
                        self.looked_ahead.extend(buf.iter().take(count));
                        true
                    }
                    Received::BrokenOff(_) | Received::Reset | Received::Rate(_) | Received::Nothing => false,
                };
                let slept = self.longest_pause > self.baud.bit_times(u32::from(SLOT_BITS) / 2);
                let mut seen = self.seen.borrow_mut();
                *(if answered || slept { &mut seen.master_late } else { &mut seen.emulator_late }) += 1;
            } else {
                self.seen.borrow_mut().requests += 1;
            }
            self.request = telegram.to_vec();
            self.look();
            self.asked = Some(self.looked);
            self.longest_pause = Duration::ZERO;
        }
        self.link.send(telegram)
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        if self.looked_ahead.is_empty() { self.link.wait(timeout, stop) } else { Ok(()) }
    }
}

/// A request whose repetition the frame count bit tells: what a master sends twice is then a retry.
fn is_counted(octets: &[u8]) -> bool {
    let Decoded::Telegram { telegram: Telegram::Data(data), .. } = decode(octets) else { return false };
    match data.fc.function() {
        Function::Request(service, _) => service.wants_reply() && data.fc.octet() & 0x10 != 0,
        Function::Response(..) | Function::Reserved => false,
    }
}
