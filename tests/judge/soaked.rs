//! A soak: scenarios repeated at random, the same ones for the same seed, and the traffic in figures.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::judge::{Ending, Report, Row, Verdict, simulated, soaked};
use roxmltree::Document;

use crate::configured::setup;
use crate::test_master::mistakes::Mistake;
use crate::test_master::{BAUD, Settings, TestMaster, UNHURRIED};
use crate::virtual_time::rows;

const SLOT: Duration = Duration::from_micros(600);
const LASTS: Duration = Duration::from_secs(20);

fn line(mistake: Option<Mistake>) -> (Line<TestMaster>, profidrive::judge::Setup) {
    line_of(Settings::new(&[5, 6], SLOT), mistake)
}

fn unhurried() -> (Line<TestMaster>, profidrive::judge::Setup) {
    line_of(Settings { pause: UNHURRIED, ..Settings::new(&[5, 6], SLOT) }, None)
}

fn line_of(settings: Settings, mistake: Option<Mistake>) -> (Line<TestMaster>, profidrive::judge::Setup) {
    let setup = setup(&settings, &[]);
    let mut line = Line::with(BAUD, TestMaster::new(settings, mistake));
    line.set_slot_time(SLOT);
    (line, setup)
}

fn soak(rows: &[Row], seed: u64) -> Report {
    let (mut line, setup) = line(None);
    soaked(&mut line, setup, rows, LASTS, seed)
}

#[test]
fn a_correct_master_is_not_accused_in_a_soak_that_its_seed_repeats() {
    let (mut line, setup) = unhurried();
    let report = soaked(&mut line, setup, Row::ALL, LASTS, 1);
    let accused = report.count(Verdict::Fail) + report.count(Verdict::Warn);
    assert_eq!((&report.ending, accused), (&Ending::Done, 0), "{report}");
    let (mut once, setup) = unhurried();
    let once = simulated(&mut once, setup, Row::ALL);
    assert!(report.took >= once.took + LASTS && report.took < once.took + LASTS * 2, "{:?}", report.took);
    // What one judgement has the soak has more often.
    assert!(report.figures.retries() > once.figures.retries(), "{report}");
    assert!(report.figures.losses() > once.figures.losses(), "{report}");
    assert!(report.configuration.contains(&("soak", "20s".into())), "{:?}", report.configuration);
    assert!(report.configuration.contains(&("seed", "1".into())), "{:?}", report.configuration);
    let some = rows(&["M-C0*", "M-E01", "M-L*"]);
    let seventh = soak(&some, 7);
    assert_eq!(seventh, soak(&some, 7));
    assert_ne!(seventh.figures, soak(&some, 8).figures);
}

/// Nothing is disturbed: the cycle of the test master is two milliseconds and its telegrams.
#[test]
fn the_cycle_and_its_spread_are_measured() {
    let report = soak(&rows(&["M-F*"]), 1);
    let figures = &report.figures;
    let cycle = figures.cycle_time();
    assert!(report.took >= LASTS, "{:?}", report.took);
    assert!((2000..4000).contains(&cycle.mean().as_micros()), "{report}");
    assert!(cycle.count() > 2 * 5_000, "{report}");
    assert!(cycle.deviation() < cycle.mean() / 5 && cycle.shortest() <= cycle.mean(), "{report}");
    assert_eq!((figures.retries(), figures.losses()), (0, 0), "{report}");
    let (mut pausing, setup) = line(Some(Mistake::Pauses));
    let pausing = soaked(&mut pausing, setup, &rows(&["M-F*"]), LASTS, 1);
    let (longest, watchdog) = (pausing.figures.cycle_time().longest(), Duration::from_secs(1));
    assert!(
        longest > watchdog && pausing.figures.cycle_time().deviation() > cycle.deviation() * 5,
        "{pausing}"
    );
}

#[test]
fn every_report_has_the_figures_and_the_page_a_plot() {
    let report = soak(&rows(&["M-C03", "M-L01"]), 3);
    let (cycle, retries, losses) =
        (report.figures.cycle_time(), report.figures.retries(), report.figures.losses());
    let millis = |time: Duration| format!("{:.3}", time.as_secs_f64() * 1000.0);
    let mean = millis(cycle.mean());
    let figures = format!(
        "\"figures\":{{\"cycles\":{},\"mean_ms\":{mean},\"shortest_ms\":{},\"longest_ms\":{},\"deviation_ms\":{},\"retries\":{retries},\"losses\":{losses}}}",
        cycle.count(),
        millis(cycle.shortest()),
        millis(cycle.longest()),
        millis(cycle.deviation())
    );
    assert!(report.json().contains(&figures), "{}", report.json());
    let text = report.to_string();
    assert!(text.contains(&format!("cycle {mean} ms (")) && text.contains(" retries, "), "{text}");
    let page = report.html("A master");
    let document = Document::parse(&page[page.find("<html").unwrap()..]).unwrap();
    let mut drawings = document.descendants().filter(|node| node.has_tag_name("svg"));
    let plot = drawings.find(|node| node.attribute("class") == Some("plot")).unwrap();
    let of = |name: &str, class: &str| {
        let nodes = plot.descendants().filter(|node| node.has_tag_name(name));
        nodes.filter(|node| node.attribute("class") == Some(class)).collect::<Vec<_>>()
    };
    let points = of("polyline", "mean")[0].attribute("points").unwrap().split_whitespace();
    let inside = |point: &str| {
        let (x, y) = point.split_once(',').unwrap();
        (0.0..=1000.0).contains(&x.parse::<f64>().unwrap())
            && (20.0..=203.0).contains(&y.parse::<f64>().unwrap())
    };
    let points: Vec<_> = points.collect();
    assert!(points.len() > 10 && points.iter().all(|point| inside(point)), "{points:?}");
    assert!(!of("rect", "retry").is_empty() && !of("rect", "loss").is_empty());
    assert_eq!(
        of("polygon", "spread")[0].attribute("points").unwrap().split_whitespace().count(),
        points.len() * 2
    );
}
