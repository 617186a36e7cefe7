//! Travelling drives on one simulated bus at 12 Mbit/s, on one core: how many times faster than the bus they are, and
//! what one drive costs when it is alone and when it is one of 125. `cargo bench --bench full_bus`.
//!
//! In each round, as long as a full bus needs for 125 drives, the master exchanges data once with every drive, and the
//! line is silent for the rest: a drive has the same to do however many there are.
//!
//! 50 times in real time at 2.6 GHz are 917 ns or 2384 cycles of the processor for one exchange and 5.73 application
//! cycles of one drive, master and line included; `benches/instructions.sh` counts the instructions they take.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_precision_loss,
    clippy::std_instead_of_core,
    reason = "a bench may panic, and has std"
)]

use std::time;

use profidrive::bench::{Answer, Line, ScriptedMaster as Master};
use profidrive::devices::ag03::profibus::{Config, Device, Timing};
use profidrive::host::Bus;
use profidrive::profibus::fdl::{Address, Sap};
use profidrive::time::{BaudRate, Instant};

const BAUD: BaudRate = BaudRate::K12000;
const FULL: u8 = 125;
/// A target at 30 rpm a quarter of an hour away.
const FAR_AWAY: i32 = 900_000;

/// A line with its first drives on their way.
struct Rig {
    line: Line,
    master: Master,
    drives: u8,
}

impl Rig {
    fn new(drives: u8) -> Self {
        let mut bus = Bus::on(BAUD, Timing::True);
        for number in 1..=drives {
            let config = Config { baud: BAUD, timing: Timing::True, ..Config::new(address(number)) };
            bus.add(Device::new(config, Instant::ZERO)).unwrap();
        }
        let mut line = Line::new(BAUD);
        line.connect(bus);
        let mut rig = Self { line, master: Master::new(address(0)), drives };
        for number in 1..=drives {
            for (sap, data) in [(61, &[0x80, 0, 0, 11, 0x0A, 0xC5, 0][..]), (62, &[0xF3, 0xF2][..])] {
                let answer = rig.master.srd(&mut rig.line, address(number), Sap::new(sap), data).unwrap();
                assert_eq!(answer, Answer::ShortAcknowledge, "drive {number}");
            }
        }
        for stw in [0x0B, 0x3B, 0x7B] {
            (0..3).for_each(|_| rig.round(stw, None));
            rig.line.wait(core::time::Duration::from_millis(5)).unwrap();
        }
        rig.line.wait(core::time::Duration::from_secs(1)).unwrap();
        for number in 1..=drives {
            let device: &Device = rig.line.bus(0).unwrap().station(address(number)).unwrap();
            assert!(device.status().travelling, "drive {number}");
        }
        rig
    }

    /// One exchange with every drive, and silence until a round has taken `period`.
    fn round(&mut self, stw: u16, period: Option<core::time::Duration>) {
        let begin = self.line.now();
        let mut outputs = [0; 14];
        outputs[8..10].copy_from_slice(&stw.to_be_bytes());
        outputs[10..].copy_from_slice(&FAR_AWAY.to_be_bytes());
        for number in 1..=self.drives {
            let answer = self.master.srd(&mut self.line, address(number), None, &outputs).unwrap();
            assert!(matches!(answer, Answer::Data(_, inputs) if inputs.len() == 14), "drive {number}");
        }
        let rest = period.map(|period| period.saturating_sub(self.line.now().saturating_since(begin)));
        self.line.wait(rest.unwrap_or_default()).unwrap();
        while self.line.bus_mut(0).unwrap().poll_event().is_some() {}
    }

    /// How long rounds take here, in s for each of them.
    fn sample(&mut self, rounds: u32, period: core::time::Duration) -> f64 {
        let start = time::Instant::now();
        (0..rounds).for_each(|_| self.round(0x7B, Some(period)));
        start.elapsed().as_secs_f64() / f64::from(rounds)
    }
}

/// What `benches/instructions.sh` counts: rounds of a full bus.
#[inline(never)]
fn counted_rounds(full: &mut Rig, rounds: u32, period: core::time::Duration) {
    (0..rounds).for_each(|_| full.round(0x7B, Some(period)));
}

fn address(number: u8) -> Address {
    Address::station(number).unwrap()
}

fn main() {
    if !std::env::args().any(|argument| argument == "--bench") {
        // `cargo test --benches` only wants to know that it runs.
        return;
    }
    let mut full = Rig::new(FULL);
    // What a round of the full bus takes on the wire.
    let before = full.line.now();
    full.round(0x7B, None);
    let period = full.line.now().saturating_since(before);
    if let Some(rounds) = std::env::args().skip_while(|argument| argument != "--count").nth(1) {
        return counted_rounds(&mut full, rounds.parse().unwrap(), period);
    }
    let mut rigs: Vec<Rig> = [1, 5, 25].map(Rig::new).into_iter().chain([full]).collect();

    const SAMPLES: usize = 1001;
    let mut seconds = vec![Vec::new(); rigs.len()];
    for _ in 0..SAMPLES {
        for (rig, seconds) in rigs.iter_mut().zip(&mut seconds) {
            // The same number of exchanges in each sample, and so few that hardly one is interrupted.
            let rounds = u32::from(FULL) / u32::from(rig.drives);
            seconds.push(rig.sample(rounds, period));
        }
    }
    println!(
        "drives   ns for an exchange and {:.2} ms of one drive   bus time / time here",
        period.as_secs_f64() * 1e3
    );
    for (rig, seconds) in rigs.iter().zip(&mut seconds) {
        seconds.sort_unstable_by(f64::total_cmp);
        let median = seconds[SAMPLES / 2];
        let each = median / f64::from(rig.drives) * 1e9;
        println!("{:>6} {each:>12.0} {:>47.1}", rig.drives, period.as_secs_f64() / median);
    }
}
