//! Prints a travel as a picture (SVG): position, speed, current and the bits of STW and ZSW over time.
//!
//! ```text
//! cargo run --example travel -- direct > travel.svg      or loop, or load
//! ```
//!
//! The pictures are in `docs/`; a test compares them with what this prints.

use core::fmt::Write;
use core::time::Duration;
use std::process::ExitCode;

use profidrive::devices::ag03::drive::{Drive, Inputs, Settings, Status};
use profidrive::devices::ag03::param::{Gear, Model, Parameter, Store};
use profidrive::devices::ag03::profibus::words::Words;
use profidrive::profibus::ppo::Stw;

#[allow(dead_code, reason = "the test that compares the pictures calls picture() instead")]
fn main() -> ExitCode {
    let name = std::env::args().nth(1).unwrap_or_else(|| "direct".into());
    match picture(&name) {
        Some(svg) => {
            print!("{svg}");
            ExitCode::SUCCESS
        }
        None => {
            eprintln!("travel: there is no '{name}'; expected direct, loop or load");
            ExitCode::from(2)
        }
    }
}

/// The picture of this name.
pub(crate) fn picture(name: &str) -> Option<String> {
    let scenario = match name {
        "direct" => direct(),
        "loop" => by_loop(),
        "load" => load(),
        _ => return None,
    };
    Some(Sheet::of(&scenario, &play(&scenario)).finish())
}

/// What is done to a drive, and what to write above it.
struct Scenario {
    title: &'static str,
    settings: Settings,
    start: i32,
    millis: u32,
    acts: Vec<(u32, Act, &'static str)>,
}

/// Something that happens at a time in ms.
enum Act {
    /// The master sends a control word and a setpoint.
    Say(u16, i32),
    /// The load brakes the shaft with this torque in Nm.
    Friction(f64),
}

fn defaults() -> Settings {
    Settings::read(&Store::new(Model::Ag03_1, Gear::Ratio48))
}

fn direct() -> Scenario {
    Scenario {
        title: "Travel job to 3200 with an intermediate stop, 30 rpm, 50 %",
        settings: defaults(),
        start: 0,
        millis: 7200,
        acts: vec![
            (200, Act::Say(0x003B, 3200), "enable"),
            (600, Act::Say(0x007B, 3200), "start"),
            (2600, Act::Say(0x005B, 3200), "pause"),
            (3600, Act::Say(0x007B, 3200), "resume"),
            (6600, Act::Say(0x0073, 3200), "disable"),
        ],
    }
}

fn by_loop() -> Scenario {
    Scenario {
        title: "Loop + from 1600 to 0: the target is always approached in positive direction",
        settings: defaults().with(Parameter::PosType, 1).with(Parameter::VPos, 60).with(Parameter::APos, 100),
        start: 1600,
        millis: 5000,
        acts: vec![
            (200, Act::Say(0x003B, 0), "enable"),
            (600, Act::Say(0x007B, 0), "start"),
            (4600, Act::Say(0x0073, 0), "disable"),
        ],
    }
}

fn load() -> Scenario {
    Scenario {
        title: "A load of 5 Nm at 60 rpm: lag error, current above 2.4 A, fault C after 4 s",
        settings: defaults().with(Parameter::VPos, 60),
        start: 0,
        millis: 14_000,
        acts: vec![
            (200, Act::Say(0x003B, 10_000), "enable"),
            (600, Act::Say(0x007B, 10_000), "start"),
            (2500, Act::Friction(5.0), "load on"),
            (8500, Act::Friction(0.0), "load off"),
            (9000, Act::Say(0x00FB, 10_000), "acknowledge"),
            (9500, Act::Say(0x007A, 10_000), "OFF1"),
            (10_000, Act::Say(0x007B, 10_000), "enable"),
            (10_500, Act::Say(0x003B, 10_000), "start"),
        ],
    }
}

/// The drive at one millisecond.
struct Sample {
    stw: u16,
    zsw: u16,
    status: Status,
    current_milliamperes: i16,
}

fn play(scenario: &Scenario) -> Vec<Sample> {
    let mut drive = Drive::new(Model::Ag03_1, Gear::Ratio48, &scenario.settings);
    if let Err(error) = drive.calibrate(scenario.start) {
        eprintln!("travel: {error}");
    }
    let mut words = Words::default();
    let mut said = (0, 0);
    let mut samples = Vec::new();
    for now in 0..scenario.millis {
        for (_, act, _) in scenario.acts.iter().filter(|(at, _, _)| *at == now) {
            match act {
                Act::Say(stw, setpoint) => said = (*stw, *setpoint),
                Act::Friction(torque) => {
                    drive.set_inputs(Inputs { friction_torque: *torque, ..Inputs::default() });
                }
            }
        }
        let command = words.command(Some((Stw::from_raw(said.0), said.1)));
        drive.step(Duration::from_millis(1), &command, &scenario.settings);
        let status = drive.status();
        words.accept(&status);
        let current_milliamperes = drive.measured().current;
        samples.push(Sample { stw: said.0, zsw: words.zsw(&status).raw(), status, current_milliamperes });
    }
    samples
}

const LEFT: f64 = 190.0;
const WIDTH: f64 = 740.0;
const RIGHT: f64 = 20.0;
const GAP: f64 = 22.0;
const PANEL: f64 = 110.0;
const ROW: f64 = 19.0;
/// Height of a row of labels, and about how wide a letter is.
const LABEL: f64 = 13.0;
const LETTER: f64 = 6.2;

const STW_BITS: [(u32, &str); 6] = [
    (0, "ON"),
    (3, "enable operation"),
    (4, "no stop"),
    (5, "no intermediate stop"),
    (6, "start (each edge)"),
    (7, "acknowledge"),
];
const ZSW_BITS: [(u32, &str); 9] = [
    (2, "operation enabled"),
    (3, "fault"),
    (6, "turn-on disabled"),
    (7, "warning"),
    (8, "no lag error"),
    (10, "target reached"),
    (12, "job acknowledged"),
    (13, "stands still"),
    (15, "ready to travel"),
];

/// A sheet that grows downwards.
struct Sheet {
    body: String,
    /// The next free line.
    top: f64,
    millis: f64,
}

impl Sheet {
    fn of(scenario: &Scenario, samples: &[Sample]) -> Self {
        let mut sheet = Self { body: String::new(), top: 34.0, millis: f64::from(scenario.millis) };
        sheet.text(LEFT, 22.0, "title", "start", scenario.title);
        sheet.top += 3.0 * LABEL;
        let acts_from = sheet.top;
        let series = |value: fn(&Sample) -> f64| samples.iter().map(value).collect();
        sheet.panel("position", "increments", "blue", series(|sample| f64::from(sample.status.position)));
        sheet.panel("speed", "rpm", "green", series(|sample| f64::from(sample.status.velocity)));
        sheet.panel(
            "motor current",
            "A",
            "red",
            series(|sample| f64::from(sample.current_milliamperes) / 1000.0),
        );
        sheet.bits("STW", &STW_BITS, "out", samples, |sample| sample.stw);
        sheet.bits("ZSW", &ZSW_BITS, "in", samples, |sample| sample.zsw);
        sheet.axis(scenario.millis);
        sheet.acts(scenario, acts_from);
        sheet
    }

    fn x(&self, millis: f64) -> f64 {
        LEFT + WIDTH * millis / self.millis
    }

    /// One value over time, with its scale.
    fn panel(&mut self, name: &str, unit: &str, class: &str, values: Vec<f64>) {
        let step = scale_step(values.iter().fold(0.0, |most: f64, value| most.max(value.abs())));
        let low = values.iter().fold(0.0, |low: f64, value| low.min(*value));
        let high = values.iter().fold(0.0, |high: f64, value| high.max(*value));
        let (low, high) = ((low / step).floor() * step, (high / step).ceil() * step);
        let (top, bottom) = (self.top, self.top + PANEL);
        let y = |value: f64| bottom - PANEL * (value - low) / (high - low);
        self.text(LEFT - 60.0, top + PANEL / 2.0 - 2.0, "name", "end", name);
        self.text(LEFT - 60.0, top + PANEL / 2.0 + 13.0, "unit", "end", unit);
        let mut tick = low;
        while tick <= high + step / 2.0 {
            let at = y(tick);
            self.line((LEFT, at), (LEFT + WIDTH, at), if tick == 0.0 { "zero" } else { "grid" });
            self.text(LEFT - 6.0, at + 4.0, "tick", "end", &format!("{}", (tick * 10.0).round() / 10.0));
            tick += step;
        }
        let mut points = String::new();
        for (millis, value) in (0_u32..).zip(&values).step_by(10) {
            let _ = write!(points, "{:.1},{:.1} ", self.x(f64::from(millis)), y(*value));
        }
        let _ = writeln!(self.body, r#"<polyline class="{class}" points="{}"/>"#, points.trim_end());
        self.top = bottom + GAP;
    }

    /// Bits of a word, one row each; what is 1 is filled.
    fn bits(
        &mut self,
        word: &str,
        bits: &[(u32, &str)],
        class: &str,
        samples: &[Sample],
        of: fn(&Sample) -> u16,
    ) {
        for (bit, name) in bits {
            let top = self.top + 4.0;
            let low = self.top + ROW - 2.0;
            self.text(LEFT - 60.0, low - 2.0, "bit", "end", name);
            self.text(LEFT - 6.0, low - 2.0, "tick", "end", &format!("{word}.{bit}"));
            self.line((LEFT, low), (LEFT + WIDTH, low), "grid");
            let mut since = None;
            let levels = samples.iter().map(|sample| of(sample) & 1 << bit != 0).chain([false]);
            for (millis, level) in (0_u32..).zip(levels) {
                match (since, level) {
                    (None, true) => since = Some(millis),
                    (Some(from), false) => {
                        let (from, to) = (self.x(f64::from(from)), self.x(f64::from(millis)));
                        let (width, height) = (to - from, low - top);
                        let _ = writeln!(
                            self.body,
                            r#"<rect class="{class}" x="{from:.1}" y="{top:.1}" width="{width:.1}" height="{height:.1}"/>"#
                        );
                        since = None;
                    }
                    (None, false) | (Some(_), true) => {}
                }
            }
            self.top += ROW;
        }
        self.top += 12.0;
    }

    fn axis(&mut self, millis: u32) {
        let y = self.top;
        self.line((LEFT, y), (LEFT + WIDTH, y), "zero");
        for second in 0..=millis / 1000 {
            let x = self.x(f64::from(second * 1000));
            self.line((x, y), (x, y + 5.0), "zero");
            self.text(x, y + 18.0, "tick", "middle", &second.to_string());
        }
        self.text(LEFT - 60.0, y + 18.0, "unit", "end", "time in s");
        self.top += 30.0;
    }

    /// A line through everything where something is done. Labels that would touch go to another row.
    fn acts(&mut self, scenario: &Scenario, from: f64) {
        let mut free = [0.0; 3];
        for (millis, _, name) in &scenario.acts {
            let x = self.x(f64::from(*millis));
            let mut height = 0.0;
            for (row, free) in (0_u8..).zip(&mut free) {
                if *free < x {
                    *free = x + 6.0 + LETTER * name.len() as f64;
                    height = f64::from(row) * LABEL;
                    break;
                }
            }
            self.line((x, from - 16.0 - height), (x, self.top - 30.0), "act");
            self.text(x + 3.0, from - 8.0 - height, "unit", "start", name);
        }
    }

    fn line(&mut self, (x1, y1): (f64, f64), (x2, y2): (f64, f64), class: &str) {
        let _ = writeln!(
            self.body,
            r#"<line class="{class}" x1="{x1:.1}" y1="{y1:.1}" x2="{x2:.1}" y2="{y2:.1}"/>"#
        );
    }

    fn text(&mut self, x: f64, y: f64, class: &str, anchor: &str, text: &str) {
        let _ = writeln!(
            self.body,
            r#"<text class="{class}" x="{x:.1}" y="{y:.1}" text-anchor="{anchor}">{text}</text>"#
        );
    }

    fn finish(self) -> String {
        let (width, height) = (LEFT + WIDTH + RIGHT, self.top);
        format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" font-family="Helvetica, Arial, sans-serif" font-size="11">
<style>
.title {{ font-size: 15px; font-weight: bold; }}
.name {{ font-size: 13px; font-weight: bold; }}
.unit {{ fill: #666; }}
.tick {{ fill: #444; }}
.grid {{ stroke: #e4e4e4; }}
.zero {{ stroke: #888; }}
.act {{ stroke: #999; stroke-dasharray: 3 3; }}
polyline {{ fill: none; stroke-width: 2; stroke-linejoin: round; }}
.blue {{ stroke: #1f5fa8; }}
.green {{ stroke: #2b8a3e; }}
.red {{ stroke: #c23b22; }}
.out {{ fill: #f0b429; }}
.in {{ fill: #7a9cc6; }}
</style>
<rect width="{width}" height="{height}" fill="white"/>
{}</svg>
"##,
            self.body
        )
    }
}

/// A round number of which two to five make `most`.
fn scale_step(most: f64) -> f64 {
    let decade = 10.0_f64.powf(most.max(1e-3).log10().floor());
    [0.5, 1.0, 2.0]
        .into_iter()
        .map(|factor| factor * decade)
        .find(|step| most / step <= 4.0)
        .unwrap_or(5.0 * decade)
}
