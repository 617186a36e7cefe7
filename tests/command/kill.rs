//! `emulate --state-dir` killed with SIGKILL at any moment loses nothing that it has acknowledged.
//!
//! A master over the pseudo-terminal writes parameters as fast as they are acknowledged; each time the emulator is
//! killed and started again, every parameter must read as acknowledged, and the one whose reply did not come as
//! before or as written. `PROFIDRIVE_KILLS` says how often (200 if it is not set), `PROFIDRIVE_KILL_SEED` with which
//! values and moments.

use core::time::Duration;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Sender};
use std::thread;

use profidrive::devices::ag03::param::{Gear, Model, Parameter, Store};
use profidrive::devices::ag03::unit::Image;
use profidrive::profibus::ppo::{Ind, JobId, Pke, Pkw, ReplyId};

use crate::pty::Master;

/// What is written: PNU, whether it is a double word, smallest and largest value.
const PARAMETERS: [(u16, bool, i32, i32); 9] = [
    (930, false, 1, 2),
    (1000, false, 1, 500),
    (1003, false, 1, 100),
    (1004, false, 1, 100),
    (1009, false, 0, 1000),
    (1016, true, -9_999_999, 9_999_999),
    (1017, true, -9_999_999, 9_999_999),
    (1018, true, -999_999, 999_999),
    (1023, false, 0, 10_000),
];

/// PNU 1004 among them.
const V_POS: usize = 3;

/// Pseudo-random numbers, the same for the same seed.
#[derive(Clone, Copy)]
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) % end
    }
}

fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |value| value.parse().unwrap())
}

/// What a master knows of the parameters of a drive.
#[derive(Clone)]
struct Known {
    /// The values acknowledged.
    values: [i32; PARAMETERS.len()],
    /// A write that was not answered: which, and the value.
    unanswered: Option<(usize, i32)>,
    acknowledged: u32,
}

#[test]
fn after_every_kill_each_acknowledged_value_is_there_and_the_image_is_valid() {
    let (kills, seed) =
        (setting("PROFIDRIVE_KILLS", 200), setting("PROFIDRIVE_KILL_SEED", 0x5EED_0F03_2611_2026));
    let mut random = Random(seed);
    let folder = tempfile::tempdir().unwrap();
    let mut known = {
        let mut emulator = Emulator::start(folder.path());
        let mut parameters = Parameters(Master::open(&emulator.terminal().unwrap()));
        let values = core::array::from_fn(|index| parameters.read(index).unwrap());
        Known { values, unanswered: None, acknowledged: 0 }
    };
    let mut in_flight = 0;
    for kill in 1..=kills {
        let context = format!("kill {kill}, PROFIDRIVE_KILL_SEED={seed}");
        let mut emulator = Emulator::start(folder.path());
        if random.below(8) == 0 {
            // Not even past its start.
            thread::sleep(Duration::from_micros(random.below(10_000)));
            drop(emulator);
            emulator = Emulator::start(folder.path());
        }
        let terminal = emulator.terminal().unwrap_or_else(|| panic!("{context}: {}", emulator.complaint()));
        let mut parameters = Parameters(Master::open(&terminal));
        parameters.check(&mut known, &context);

        let moment = Duration::from_micros(random.below(30_000));
        let values = Random(seed ^ kill.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        // Mostly behind an acknowledged write, however slow the machine is.
        let after_one = random.below(4) != 0;
        let (some_acknowledged, acknowledged) = mpsc::channel();
        known = thread::scope(|scope| {
            let writer =
                scope.spawn(move || parameters.write_until_killed(known, values, &some_acknowledged));
            if after_one {
                acknowledged.recv_timeout(Duration::from_secs(60)).unwrap();
            }
            thread::sleep(moment);
            drop(emulator);
            writer.join().unwrap()
        });
        in_flight += u64::from(known.unanswered.is_some());
        let image = fs::read(image(folder.path())).unwrap();
        Image::decode(&image, Model::Ag03_1, Gear::Ratio48)
            .unwrap_or_else(|error| panic!("{context}: {error}"));
    }
    let mut emulator = Emulator::start(folder.path());
    let mut parameters = Parameters(Master::open(&emulator.terminal().unwrap()));
    parameters.check(&mut known, "after the last kill");
    println!(
        "{kills} kills, {in_flight} of them with a write unanswered, {} acknowledged",
        known.acknowledged
    );
    assert!(u64::from(known.acknowledged) >= kills / 2, "{} writes were acknowledged", known.acknowledged);
    assert!(in_flight >= kills / 2, "{in_flight} kills had something to lose");
}

/// The other moments: while directory and first image are being made. Whatever the kill left, the next start finds a
/// usable directory, and in it factory settings.
#[test]
fn a_kill_while_the_directory_is_made_leaves_one_that_can_be_used() {
    let kills = setting("PROFIDRIVE_KILLS", 200) / 10;
    let mut random = Random(setting("PROFIDRIVE_KILL_SEED", 0x5EED_0F03_2611_2026) | 1);
    let factory = Store::new(Model::Ag03_1, Gear::Ratio48).value(Parameter::VPos);
    let folder = tempfile::tempdir().unwrap();
    let (mut early, mut late) = (0, 0);
    for kill in 1..=kills {
        let directory = folder.path().join(kill.to_string()).join("state");
        let emulator = Emulator::start(&directory);
        thread::sleep(Duration::from_micros(random.below(12_000)));
        drop(emulator);
        *(if image(&directory).exists() { &mut late } else { &mut early }) += 1;
        let mut emulator = Emulator::start(&directory);
        let terminal = emulator.terminal().unwrap_or_else(|| panic!("kill {kill}: {}", emulator.complaint()));
        let mut parameters = Parameters(Master::open(&terminal));
        assert_eq!(parameters.read(V_POS), Some(factory), "kill {kill}");
        parameters.write(V_POS, 70).unwrap();
        drop(emulator);
        let octets = fs::read(image(&directory)).unwrap();
        assert_eq!(
            Image::decode(&octets, Model::Ag03_1, Gear::Ratio48).unwrap().store.value(Parameter::VPos),
            70
        );
    }
    println!("{early} kills before the first image was there, {late} after");
}

fn image(directory: &Path) -> PathBuf {
    directory.join("ag03-1-005.eeprom")
}

/// A running emulator; dropped, it is killed with SIGKILL.
struct Emulator(Child);

impl Emulator {
    fn start(directory: &Path) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
        command.args(["emulate", "-q", "--state-dir"]).arg(directory).env_remove("RUST_LOG");
        let command = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Self(command.spawn().unwrap())
    }

    /// The terminal, once it is ready.
    fn terminal(&mut self) -> Option<PathBuf> {
        let mut ready = String::new();
        BufReader::new(self.0.stdout.take()?).read_line(&mut ready).unwrap();
        let path = ready.split(' ').nth(1)?.strip_prefix("link=")?;
        Some(path.into())
    }

    /// What it says on stderr until it ends.
    fn complaint(&mut self) -> String {
        let mut text = String::new();
        self.0.stderr.take().unwrap().read_to_string(&mut text).unwrap();
        text
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The parameters of [`PARAMETERS`] over the bus. Every call says `None` once the emulator is gone.
struct Parameters(Master);

impl Parameters {
    fn read(&mut self, index: usize) -> Option<i32> {
        let (pnu, double, ..) = PARAMETERS[index];
        let reply = self.0.job(Pkw::new(Pke::of_job(JobId::Read, pnu), Ind::default(), 0))?;
        let id = if double { ReplyId::DoubleWord } else { ReplyId::Word };
        assert_eq!(reply.pke, Pke::of_reply(id, pnu), "{reply}");
        Some(reply.double_word().cast_signed())
    }

    /// Whether it was acknowledged.
    fn write(&mut self, index: usize, value: i32) -> Option<()> {
        let (pnu, double, ..) = PARAMETERS[index];
        let (job, id) = if double {
            (JobId::WriteDoubleWord, ReplyId::DoubleWord)
        } else {
            (JobId::WriteWord, ReplyId::Word)
        };
        let value = value.cast_unsigned();
        let reply = self.0.job(Pkw::new(Pke::of_job(job, pnu), Ind::default(), value))?;
        assert_eq!(reply, Pkw::new(Pke::of_reply(id, pnu), Ind::default(), value));
        Some(())
    }

    /// Reads every parameter: as acknowledged, or the unanswered one as written.
    fn check(&mut self, known: &mut Known, context: &str) {
        for (index, (pnu, ..)) in PARAMETERS.iter().enumerate() {
            let found = self.read(index).unwrap();
            let expected = known.values[index];
            let written = known.unanswered.filter(|(which, _)| *which == index).map(|(_, value)| value);
            assert!(
                found == expected || Some(found) == written,
                "{context}: PNU {pnu} is {found}, acknowledged was {expected}, unanswered {written:?}"
            );
            known.values[index] = found;
        }
        known.unanswered = None;
    }

    fn write_until_killed(
        &mut self,
        mut known: Known,
        mut random: Random,
        acknowledged: &Sender<()>,
    ) -> Known {
        loop {
            let index = random.below(PARAMETERS.len() as u64) as usize;
            let (_, _, low, high) = PARAMETERS[index];
            let value = low + random.below((high - low + 1) as u64) as i32;
            known.unanswered = Some((index, value));
            if self.write(index, value).is_none() {
                return known;
            }
            known.values[index] = value;
            known.acknowledged += 1;
            // Nobody listens behind the first.
            let _ = acknowledged.send(());
        }
    }
}
