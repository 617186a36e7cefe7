//! A judgement in virtual time, over any sans-I/O master.

use core::time::Duration;

use super::Report;
use super::observer::Sight;
use super::play::Judge;
use super::rows::Row;
use super::setup::Setup;
use crate::bench::{Line, Master, Sender};
use crate::judge::moment::{Moment, Side};
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// The longest judgement in virtual time.
const LIMIT: Duration = Duration::from_secs(3600);

/// Judges the master on `line` by these rows. The stations of `setup` are connected to the line here; the slot time, if
/// `setup` names none, is that of the line. Timing is judged to the bit time.
///
/// The line should be new: what was on it before is not seen.
pub fn simulated<M: Master>(line: &mut Line<M>, setup: Setup, wanted: &[Row]) -> Report {
    run(line, seeing(line, setup, wanted), |_, _, _| false)
}

/// The same until one of the rows is broken, by a failure or a warning.
pub fn simulated_until_breach<M: Master>(line: &mut Line<M>, setup: Setup, wanted: &[Row]) -> Report {
    run(line, seeing(line, setup, wanted).until_breach(), |_, _, _| false)
}

/// The same, and then scenarios are repeated at random for `lasts`. The same seed repeats the same ones.
pub fn soaked<M: Master>(
    line: &mut Line<M>,
    setup: Setup,
    wanted: &[Row],
    lasts: Duration,
    seed: u64,
) -> Report {
    run(line, seeing(line, setup, wanted).soaking(lasts, seed), |_, _, _| false)
}

/// The same for a master that is operated: `operate` does an action, as `--ask` takes it, and says whether it could.
pub fn simulated_with<M: Master>(
    line: &mut Line<M>,
    setup: Setup,
    wanted: &[Row],
    operate: impl FnMut(&mut M, &str, Instant) -> bool,
) -> Report {
    run(line, seeing(line, setup, wanted).operated(), operate)
}

fn seeing<M: Master>(line: &Line<M>, setup: Setup, wanted: &[Row]) -> Judge {
    let setup = Setup { slot: setup.slot.or(Some(line.slot_time())), ..setup };
    Judge::seeing(setup, wanted, Sight::Exact(line.baud()))
}

fn run<M: Master>(
    line: &mut Line<M>,
    mut judge: Judge,
    mut operate: impl FnMut(&mut M, &str, Instant) -> bool,
) -> Report {
    let origin = line.now();
    let limit = LIMIT + judge.soak_time();
    let (bus, faults) = line.stations_and_faults();
    judge.begin(origin, bus, faults);
    while judge.ending().is_none() && line.now().saturating_since(origin) < limit {
        let second = judge.second_due().filter(|_| !line.is_speaking());
        let due = Instant::first_of(judge.poll_timeout(), second).unwrap_or(line.now() + LIMIT);
        let wait = due.saturating_since(line.now()).min(LIMIT);
        // One thing at a time: faults begin and end at the telegram that they are for.
        let _ = line.run_until(wait, |_| true);
        while let Some(passed) = line.poll_telegram() {
            let side = match passed.sender {
                Sender::Master => Side::Master,
                Sender::Test => judge.second_address().map_or(Side::Station(None::<Address>), Side::Other),
                Sender::Station => Side::Station(None::<Address>),
            };
            judge.hear(Moment { at: passed.at, end: passed.end, side, octets: passed.octets });
        }
        let now = line.now();
        let (bus, faults) = line.stations_and_faults();
        judge.step(now, bus, faults);
        if !line.is_speaking()
            && let Some(octets) = judge.speak(now)
        {
            line.speak(&octets);
        }
        if let Some(action) = judge.poll_ask() {
            let done = operate(&mut line.master, &action, now);
            judge.asked(now, done);
        }
    }
    judge.report(origin)
}
