//! Correct masters of unusual habits are not accused, whatever happens to them.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::judge::{Ending, Row, Setup, simulated_with};
use profidrive::profibus::fdl::Address;

use crate::configured::setup;
use crate::test_master::habits::Habit;
use crate::test_master::{BAUD, Settings, TestMaster, UNHURRIED};
use crate::virtual_time::{broken, in_threads, is_long};

const SLOT: Duration = Duration::from_micros(600);

fn with(habits: &[Habit]) -> Settings {
    Settings { habits: habits.to_vec(), pause: UNHURRIED, ..Settings::new(&[5, 6, 9], SLOT) }
}

fn of_watchdog(millis: u64, settings: Settings) -> Settings {
    Settings { watchdog: Duration::from_millis(millis), ..settings }
}

fn of_pause(millis: u64, settings: Settings) -> Settings {
    Settings { pause: Duration::from_millis(millis), ..settings }
}

/// Masters, each with what is unusual of it.
fn masters() -> Vec<(&'static str, Settings)> {
    let ring = |settings| Settings { token: true, ..settings };
    vec![
        ("Get_Cfg before Set_Prm", with(&[Habit::ReadsCfg])),
        ("FDL status of a silent station", with(&[Habit::AsksStatus])),
        ("FDL status of a silent station in a ring", ring(with(&[Habit::AsksStatus]))),
        ("Slave_Diag in each second exchange", with(&[Habit::DiagnosesEach(2)])),
        ("Slave_Diag in each tenth exchange", with(&[Habit::DiagnosesEach(10)])),
        ("two Slave_Diags at the start", with(&[Habit::DiagnosesTwice])),
        ("Global_Control in each cycle", with(&[Habit::ControlsEachCycle])),
        ("pauses of all lengths", with(&[Habit::Jitters])),
        ("pauses of all lengths up to 120 ms", of_pause(30, with(&[Habit::Jitters]))),
        ("a cycle of 300 ms", of_watchdog(2550, of_pause(300, with(&[])))),
        ("100 ms behind each station", of_watchdog(2550, of_pause(100, with(&[Habit::PausesEach])))),
        ("CLEAR for 2000 cycles", with(&[Habit::ClearFor(2000)])),
        ("a silent station is asked in each hundredth cycle", with(&[Habit::AsksLostEach(100)])),
        ("requests of low priority", with(&[Habit::LowPriority])),
        ("min T_SDR 0", with(&[Habit::KeepsTsdr])),
        ("two watchdog times", of_watchdog(500, with(&[Habit::TwoWatchdogs]))),
        ("no watchdog", of_watchdog(0, with(&[]))),
        ("one station is started behind the other", with(&[Habit::StartsOneByOne])),
        ("no retries", Settings { retries: 0, ..with(&[]) }),
        ("one retry", Settings { retries: 1, ..with(&[]) }),
        ("five retries", Settings { retries: 5, ..with(&[]) }),
        ("15 retries", Settings { retries: 15, ..with(&[]) }),
        ("address 0", Settings { address: 0, ..with(&[]) }),
        ("address 125", Settings { address: 125, ..with(&[]) }),
        ("address 125 in a ring", ring(Settings { address: 125, hsa: 125, ..with(&[]) })),
        ("a long GAP", ring(Settings { hsa: 126, gap_factor: 1, ..with(&[]) })),
        ("several in a ring", ring(with(&[Habit::Jitters, Habit::DiagnosesTwice, Habit::ReadsCfg]))),
        (
            "several alone",
            with(&[
                Habit::ControlsEachCycle,
                Habit::DiagnosesTwice,
                Habit::LowPriority,
                Habit::AsksLostEach(30),
            ]),
        ),
    ]
}

/// From this pause on a master is not in OPERATE soon enough for `--ask`.
const SLOW: Duration = Duration::from_millis(30);

/// Whether it is in OPERATE within a second of its start, as `--ask` wants it.
fn is_quick(settings: &Settings) -> bool {
    settings.pause < SLOW && !settings.habits.contains(&Habit::ClearFor(2000))
}

/// By every row; operated as by `--ask`, and not. Without `PROFIDRIVE_LONG` every sixth.
#[test]
fn correct_masters_of_unusual_habits_are_not_accused() {
    let only = std::env::var("HABIT").ok();
    let every = if is_long() || only.is_some() { 1 } else { 6 };
    let masters: Vec<_> = masters()
        .into_iter()
        .step_by(every)
        .filter(|(words, _)| only.as_ref().is_none_or(|only| words == only))
        .flat_map(|(words, settings)| [(words, settings.clone(), false), (words, settings, true)])
        .filter(|(_, settings, operated)| !operated || is_quick(settings))
        .collect();
    let wrong = in_threads(&masters, |(words, settings, operated)| {
        let settings = settings.clone();
        let mut setup = Setup { hsa: Address::station(settings.hsa).ok(), ..setup(&settings, &[9]) };
        if settings.habits.contains(&Habit::TwoWatchdogs) {
            setup.stations[1].watchdog = Some(settings.watchdog * 2);
        }
        let mut line = Line::with(BAUD, TestMaster::new(settings, None));
        line.set_slot_time(SLOT);
        let report = simulated_with(&mut line, setup, Row::ALL, |master, action, now| {
            *operated && master.do_action(action, now)
        });
        let accused = broken(&report);
        (!accused.is_empty() || report.ending != Ending::Done)
            .then(|| format!("{words}, operated {operated}: {accused:?}, {:?}\n{report}", report.ending))
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
