//! The whole transition table, printed to `docs/drive-states.txt` and compared. `PROFIDRIVE_REWRITE=1` writes it anew.

use core::fmt::Write;
use std::path::Path;
use std::{env, fs};

use super::words::in_every_state;
use super::*;

/// Something that happens to a drive.
struct Stimulus {
    name: &'static str,
    happen: fn(&mut Rig),
}

const fn stimulus(name: &'static str, happen: fn(&mut Rig)) -> Stimulus {
    Stimulus { name, happen }
}

/// In the order of priority, then requests, then plant and bus.
const STIMULI: [Stimulus; 27] = [
    stimulus("nothing", |rig| _ = rig.run(1)),
    stimulus("STW 0000", |rig| _ = rig.stw(0x0000)),
    stimulus("OFF2 (STW.1 = 0)", |rig| _ = rig.stw(rig.stw & !0x0002)),
    stimulus("OFF1 (STW.0 = 0)", |rig| _ = rig.stw(rig.stw & !0x0001)),
    stimulus("disable (STW.3 = 0)", |rig| _ = rig.stw(rig.stw & !0x0008)),
    stimulus("enable (STW.0, .1, .3 = 1)", |rig| _ = rig.stw(rig.stw | 0x000b)),
    stimulus("prepare (STW 003B)", |rig| _ = rig.stw(0x003b | rig.stw & 0x0040)),
    stimulus("stop (STW.4 = 0)", |rig| _ = rig.stw(rig.stw & !0x0010)),
    stimulus("pause (STW.5 = 0)", |rig| _ = rig.stw(rig.stw & !0x0020)),
    stimulus("continue (STW.5 = 1)", |rig| _ = rig.stw(rig.stw | 0x0020)),
    stimulus("change of STW.6, 003B", |rig| _ = rig.stw(0x003b | !rig.stw & 0x0040)),
    stimulus("change of STW.6, 000B", |rig| _ = rig.stw(0x000b | !rig.stw & 0x0040)),
    stimulus("setpoint beyond the limits, change of STW.6", |rig| {
        rig.setpoint = 2_000_000;
        rig.stw(0x003b | !rig.stw & 0x0040);
    }),
    stimulus("acknowledge (STW.7)", |rig| _ = rig.stw(rig.stw | 0x0080)),
    stimulus("inching 1 (STW.8)", |rig| _ = rig.stw(rig.stw | 0x0100)),
    stimulus("inching 2 + (STW.9)", |rig| _ = rig.stw(rig.stw | 0x0200)),
    stimulus("inching 2 - (STW.9, .15)", |rig| _ = rig.stw(rig.stw | 0x8200)),
    stimulus("both inching", |rig| _ = rig.stw(rig.stw | 0x0300)),
    stimulus("no inching", |rig| _ = rig.stw(rig.stw & !0x8300)),
    stimulus("Data_Exchange left", |rig| {
        rig.connected = false;
        rig.run(1);
    }),
    stimulus("Data_Exchange left, key pressed", |rig| {
        rig.connected = false;
        rig.inputs(|inputs| (inputs.key_clockwise, inputs.key_counter_clockwise) = (false, false));
        rig.inputs(|inputs| inputs.key_counter_clockwise = true);
    }),
    stimulus("fault F", |rig| _ = rig.inputs(|inputs| inputs.internal_fault = true)),
    stimulus("output stage or enable input lost", |rig| _ = rig.output_stage(false)),
    stimulus("output stage or enable input back", |rig| _ = rig.output_stage(true)),
    stimulus("control supply lost", |rig| _ = rig.inputs(|inputs| inputs.control_supply = 0.0)),
    stimulus("control supply back", |rig| _ = rig.inputs(|inputs| inputs.control_supply = 24.0)),
    stimulus("shaft blocked", |rig| _ = rig.inputs(|inputs| inputs.blocked = true)),
];

/// A state of a model and what the stimuli make of it.
struct Section {
    model: Model,
    title: String,
    lines: Vec<String>,
}

impl Section {
    fn of(rig: &Rig) -> Self {
        let status = rig.status();
        let moving = if status.moving { ", shaft turns" } else { "" };
        let live = if status.output_stage_ok { "" } else { ", no output stage" };
        let words = format!("(STW {:04X}, ZSW {:04X})", rig.stw, rig.zsw());
        let title = format!("{:?}: {}{moving}{live}   {words}", status.mode, name(status.state));
        let lines = STIMULI.iter().map(|stimulus| line(stimulus, rig.clone()));
        Self { model: rig.drive.model, title, lines: lines.collect() }
    }
}

fn line(Stimulus { name: what, happen }: &Stimulus, mut rig: Rig) -> String {
    let before = shown(&rig);
    happen(&mut rig);
    let next = shown(&rig);
    for _ in 0..200 {
        rig.step(Duration::from_millis(50));
    }
    let later = shown(&rig);
    let [after, end] =
        [(&before, &next), (&next, &later)].map(|(old, new)| if old == new { "=" } else { new.as_str() });
    format!("  {what:<45} {after:<36} {end}").trim_end().into()
}

/// State and ZSW.
fn shown(rig: &Rig) -> String {
    format!("{:<30} {:04X}", name(rig.state()), rig.zsw())
}

fn table() -> String {
    let mut text = String::from(
        "Transition table of the drive: what each stimulus makes of each state, one cycle (1 ms) and 10 s later.\n\
         Printed by src/devices/ag03/drive/tests/table.rs; PROFIDRIVE_REWRITE=1 writes it anew. ZSW in hexadecimal,\n\
         = as before.\n\
         (R) motor released, (C) motor in control. First the AG03/1, then what an AG03 does otherwise.\n",
    );
    let mut sections: Vec<Section> = Vec::new();
    for section in in_every_state().iter().map(Section::of) {
        let known = |other: &Section| (other.model, &other.title) == (section.model, &section.title);
        if !sections.iter().any(known) {
            sections.push(section);
        }
    }
    let (ag03, ag03_1): (Vec<_>, Vec<_>) =
        sections.into_iter().partition(|section| section.model == Model::Ag03);
    for Section { title, lines, .. } in &ag03_1 {
        let _ = writeln!(text, "\nAG03/1 {title}\n{}", lines.join("\n"));
    }
    for Section { title, lines, .. } in &ag03 {
        let same = ag03_1.iter().find(|other| other.title == *title);
        let others = lines.iter().filter(|line| same.is_none_or(|same| !same.lines.contains(line)));
        let others: Vec<_> = others.cloned().collect();
        if !others.is_empty() {
            let _ = writeln!(text, "\nAG03 {title}\n{}", others.join("\n"));
        }
    }
    text
}

fn name(state: State) -> String {
    let motor = |motor| match motor {
        Motor::Released => "R",
        Motor::InControl => "C",
        Motor::Shorted => "shorted",
    };
    match state {
        State::ReadyToRun(kind) => format!("ReadyToRun({})", motor(kind)),
        State::OperationEnabled(kind) => format!("OperationEnabled({})", motor(kind)),
        State::Pausing { torque_tripped: true } => "Pausing(torque)".into(),
        State::Pausing { torque_tripped: false } => "Pausing".into(),
        State::Paused { torque_tripped: true } => "Paused(torque)".into(),
        State::Paused { torque_tripped: false } => "Paused".into(),
        State::Off
        | State::NotReady
        | State::Disabling
        | State::TravelActive
        | State::Stopping
        | State::Inching(_)
        | State::VelocityTravelling
        | State::KeyInching(_)
        | State::KeyInchingEnding
        | State::Fault
        | State::TurnOnDisabled => format!("{state:?}"),
    }
}

#[test]
fn the_transition_table_is_the_one_in_the_docs() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/drive-states.txt");
    let table = table();
    if env::var_os("PROFIDRIVE_REWRITE").is_some() {
        fs::write(&path, &table).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap_or_default();
    for (number, (kept, now)) in kept.lines().zip(table.lines()).enumerate() {
        assert_eq!(kept, now, "line {} of {}", number + 1, path.display());
    }
    assert_eq!(kept.len(), table.len(), "{} is not complete", path.display());
}
