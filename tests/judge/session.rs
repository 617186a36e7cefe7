//! `profidrive::master::Session`, our own master, judged in real time: a program that takes a drive over, exchanges data,
//! and takes it over again whenever it was lost.

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use profidrive::gsd::Gsd;
use profidrive::host::link::memory::{End, Wire};
use profidrive::host::{Stop, SystemClock};
use profidrive::judge::{Judge, Report, Requirement as _, Row, Setup, Slave, Verdict, live};
use profidrive::master::{Session, Settings};
use profidrive::profibus::fdl::Address;
use profidrive::profibus::ppo::PPO_LEN;
use profidrive::time::BaudRate;

/// What it gets wrong, as docs/judged-masters.md says.
const KNOWN: &[&str] = &["M-C07", "M-D02", "M-D03", "M-D07", "M-L05", "M-E03", "M-E04", "M-E15"];

/// Found only in some runs. C04: outputs that are written while a request has no reply yet go out with its repetition,
/// which depends on the moment. F04: its own address comes late in the GAP. E13: on a busy machine the reply with the
/// request bit may come so late that taking it says nothing; only the other wrong function code is judged then.
const SOMETIMES: &[&str] = &["M-C04", "M-E13", "M-F04"];

fn serve(link: End, end: &AtomicBool, stop: Stop) {
    let master = Address::from_octet(2);
    let settings = Settings {
        slot_time: Duration::from_millis(100),
        retry_limit: 2,
        ..Settings::untimed(master, BaudRate::K500)
    };
    let mut session = Session::new(link, SystemClock::new(), stop, settings).unwrap();
    let drive = Address::from_octet(5);
    let mut count = 0_u8;
    while !end.load(Ordering::Relaxed) {
        if session.start(drive).is_err() {
            continue;
        }
        while !end.load(Ordering::Relaxed) {
            count = count.wrapping_add(1);
            if session.exchange_with(drive, &[count; PPO_LEN]).is_err() {
                break;
            }
        }
    }
}

fn judged(rows: &[Row]) -> Report {
    let text = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("gsd/SIKO0AC5.GSD")).unwrap();
    let gsd = Gsd::read(&text).unwrap();
    let slave =
        Slave { gsd: Some(Box::new(gsd)), ..Slave::new(Address::from_octet(5), 0x0AC5, vec![0xF3, 0xF2]) };
    let setup = Setup {
        stations: vec![slave],
        master: Address::station(2).ok(),
        watchdog: Some(Duration::from_secs(1)),
        retries: Some(2),
        slot: Some(Duration::from_millis(100)),
        ..Setup::default()
    };
    let wire = Wire::new();
    let (master_end, judge_end) = (wire.end(), wire.end());
    let end = Arc::new(AtomicBool::new(false));
    let ends = Arc::clone(&end);
    let stop = Stop::new().unwrap();
    let stops = stop.clone();
    let thread = std::thread::spawn(move || serve(master_end, &ends, stops));
    let never = Stop::new().unwrap();
    let judge = Judge::new(setup, rows);
    let report =
        live(judge, judge_end, &SystemClock::new(), BaudRate::K500, &never, None, &mut |_| {}).unwrap();
    end.store(true, Ordering::Relaxed);
    stop.request();
    thread.join().unwrap();
    report
}

#[test]
fn our_session_is_judged_as_the_page_says() {
    let all = std::env::var_os("PROFIDRIVE_EVERY_ROW").is_some();
    let some = ["M-F*", "M-C03", "M-C04", "M-C05", "M-P*", "M-G*", "M-E01", "M-E13", "M-U01", "M-O01"];
    let some = some.iter().flat_map(|pattern| Row::matching(pattern));
    let rows: Vec<Row> = if all { Row::ALL.to_vec() } else { some.collect() };
    let report = judged(&rows);
    println!("{report}");
    let failed = report.judgements.iter().filter(|judged| judged.verdict == Verdict::Fail);
    let failed: Vec<_> = failed.map(|judged| judged.row.id()).filter(|id| !SOMETIMES.contains(id)).collect();
    let known: Vec<_> = KNOWN.iter().filter(|id| rows.iter().any(|row| row.id() == **id)).copied().collect();
    assert_eq!(failed, known, "{report}");
    assert!(report.count(Verdict::Pass) > 10, "{report}");
}
