//! A whole commissioning as `emulate` logs it at its default level: `docs/story.txt`, line by line.

use std::fmt::Write;
use std::fs;
use std::ops::{Deref, DerefMut};
use std::path::Path;
use std::time::Duration;

use profidrive::devices::StationEvent;
use profidrive::devices::ag03::drive::{Fault, Inputs, Mode};
use profidrive::devices::ag03::param::{Pnu, Value};
use profidrive::devices::ag03::profibus::Event;
use profidrive::devices::ag03::unit;
use profidrive::face::EventKind;

use crate::drive_line::{CFG, MASTER, Reply};
use crate::drive_log::{CYCLE, PRM, Told};

#[test]
fn a_commissioning_reads_as_the_committed_story() {
    let mut plant = Plant::new();
    plant.start_up();
    plant.travel();
    plant.refuse();
    plant.inch();
    plant.pause_and_stop();
    plant.fault();
    plant.parameters();
    plant.end();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/story.txt");
    if std::env::var_os("PROFIDRIVE_WRITE_STORY").is_some() {
        fs::write(&path, &plant.story).unwrap();
    }
    let committed = fs::read_to_string(path).unwrap();
    for (number, (line, expected)) in plant.story.lines().zip(committed.lines()).enumerate() {
        assert_eq!(line, expected, "line {} of docs/story.txt", number + 1);
    }
    assert_eq!(plant.story, committed);
}

#[test]
fn the_control_words_that_a_refusal_names_do_what_was_asked() {
    for (stw, setpoint, what) in [
        (0x004B, 1600, "travel without stop bits"),
        (0x0040, 1600, "travel without anything"),
        (0x0240, 0, "inching 2 without enable"),
        (0x0100, 0, "inching 1 without enable"),
    ] {
        let mut plant = Plant::exchanging();
        plant.say(if stw == 0x004B { 0x000B } else { 0x0000 }, 0, CYCLE);
        plant.line.events.clear();
        plant.say(stw, setpoint, CYCLE);
        let refusal = plant.line.events.iter().find_map(|event| match event {
            StationEvent::Device(Event::CommandRefused(refusal)) => Some(*refusal),
            _ => None,
        });
        let next = refusal.unwrap().next().expect(what).to_string();
        let words: Vec<u16> = next
            .split([' ', ','])
            .filter(|word| word.len() == 4)
            .filter_map(|word| u16::from_str_radix(word, 16).ok())
            .collect();
        assert_eq!(words.len(), 2, "{what}: {next}");
        plant.line.events.clear();
        for stw in words {
            plant.say(stw, setpoint, CYCLE);
        }
        assert!(plant.line.device.status().job_active, "{what}: {next}");
        assert!(
            !plant.line.events.iter().any(|event| event.kind() == EventKind::CommandRefused),
            "{what}: {next}"
        );
    }
}

#[test]
fn each_refusal_names_cause_place_and_cure() {
    let refused = |stw: u16, setpoint, before: u16| {
        let mut plant = Plant::exchanging();
        plant.say(0, 0, CYCLE);
        plant.say(before, 0, CYCLE);
        plant.line.events.clear();
        plant.say(stw, setpoint, CYCLE);
        let texts: Vec<_> = plant
            .line
            .events
            .iter()
            .filter(|event| event.kind() == EventKind::CommandRefused)
            .map(StationEvent::to_string)
            .collect();
        texts.join(" | ")
    };
    for (stw, setpoint, before, text) in [
        (
            0x004B,
            5,
            0x000B,
            "travel to 5 inc refused: stop is given (STW.4 = 0); intermediate stop is given (STW.5 = 0); next: send STW 007B, \
             then 003B",
        ),
        (
            0x007B,
            1_200_000,
            0x003B,
            "travel to 1200000 inc refused: setpoint is above the upper limit (1000000 inc): give a setpoint from -1000000 inc to \
             1000000 inc, or change the limits (PNU 1016, 1017)",
        ),
        (
            0x0200,
            0,
            0x0000,
            "inching 2 in positive direction refused: OFF2 is given (STW.1 = 0); OFF1 is given (STW.0 = 0); operation is \
             not enabled (STW.3 = 0); next: send STW 000B, wait for ZSW.2 = 1, then 020B",
        ),
    ] {
        assert_eq!(refused(stw, setpoint, before), text, "{stw:04X}");
    }
}

#[test]
fn after_a_fault_the_acknowledgement_says_that_off1_is_needed() {
    for held in [0x043F, 0x047F] {
        let mut plant = Plant::exchanging();
        plant.say(0, 0, CYCLE);
        plant.say(held, 0, CYCLE);
        plant.inputs(Inputs::default().provoking(Fault::F));
        plant.say(held, 0, CYCLE);
        plant.inputs(Inputs::default());
        plant.say(held, 0, CYCLE);
        plant.line.events.clear();
        plant.say(held | 0x0080, 0, CYCLE);
        let texts: Vec<_> = plant.line.events.iter().map(StationEvent::to_string).collect();
        assert_eq!(
            texts,
            ["fault acknowledged, turning on is disabled; next: give OFF1 once (STW.0 = 0), then STW.0 = 1"],
            "{held:04X}"
        );
        plant.line.events.clear();
        plant.say(held & !1, 0, CYCLE);
        plant.say(held, 0, CYCLE);
        assert!(plant.line.device.status().operation_enabled, "{held:04X}");
    }
}

#[test]
fn what_comes_in_every_cycle_is_detail() {
    let mut plant = Plant::exchanging();
    plant.say(0x000B, 0, CYCLE);
    plant.line.events.clear();
    for _ in 0..20 {
        // Unfreeze and Unsync of a master that sends them in each cycle; the same value written again and again.
        plant.line.global_control(0x14, 0);
        plant.say(0x000B, 0, CYCLE);
        let v_pos = Pnu::new(1004).unwrap();
        let line = &mut plant.line;
        line.device.write_parameter(line.now, v_pos, None, Value::Word(30)).unwrap();
        plant.say(0x000B, 0, CYCLE);
    }
    assert!(plant.line.events.len() >= 40);
    assert!(plant.line.events.iter().all(StationEvent::is_detail), "{:?}", plant.line.events);
    plant.line.events.clear();
    plant.say(0x000B, 0, Duration::from_secs(10));
    assert_eq!(plant.line.events, [], "a standing drive has nothing to tell");
}

#[test]
fn an_overflow_of_events_is_counted_and_said() {
    let mut plant = Plant::exchanging();
    let now = plant.line.now;
    while plant.line.device.poll_event().is_some() {}
    let v_pos = Pnu::new(1004).unwrap();
    for value in 1..=100 {
        plant.line.device.write_parameter(now, v_pos, None, Value::Word(value)).unwrap();
    }
    let told: Vec<_> = std::iter::from_fn(|| plant.line.device.poll_event()).collect();
    let written = told
        .iter()
        .filter(|event| {
            matches!(event, StationEvent::Device(Event::Unit { event: unit::Event::Written { .. }, .. }))
        })
        .count();
    let Some(StationEvent::Lost { events }) = told.last() else { panic!("{told:?}") };
    assert_eq!(written + usize::try_from(*events).unwrap(), 100);
}

struct Plant {
    told: Told,
    story: String,
}

impl Deref for Plant {
    type Target = Told;

    fn deref(&self) -> &Told {
        &self.told
    }
}

impl DerefMut for Plant {
    fn deref_mut(&mut self) -> &mut Told {
        &mut self.told
    }
}

impl Plant {
    fn new() -> Self {
        let mut story = String::new();
        story.push_str("# What the log of a drive says during a commissioning. '>' is what the user or the master does,\n");
        story.push_str("# indented what the drive says. Compared by tests/slave/story.rs.\n");
        Self { told: Told::new(), story }
    }

    fn exchanging() -> Self {
        let mut plant = Self::new();
        plant.line.start_up_with(&PRM);
        plant
    }

    fn start_up(&mut self) {
        self.act("power off and on");
        let line = &mut self.line;
        line.device.power_off(line.now);
        self.line.wait(CYCLE);
        let line = &mut self.line;
        line.device.power_on(line.now);
        self.line.wait(CYCLE);
        self.act("Set_Prm with ident number 1234");
        self.line.request(MASTER, Some(61), &[0x88, 10, 1, 11, 0x12, 0x34, 0]);
        self.act("Set_Prm, then Chk_Cfg with 11 21");
        self.line.request(MASTER, Some(61), &PRM);
        self.line.request(MASTER, Some(62), &[0x11, 0x21]);
        self.act("Set_Prm, then Chk_Cfg with F3 F2");
        self.line.request(MASTER, Some(61), &PRM);
        assert_eq!(self.line.request(MASTER, Some(62), &CFG), Reply::Sc);
        self.act("Set_Prm by master 3");
        self.line.request(3, Some(61), &PRM);
    }

    fn travel(&mut self) {
        self.act("STW 0000, then 003B");
        self.say(0x0000, 0, CYCLE);
        self.say(0x003B, 0, CYCLE);
        self.act("STW 007B, setpoint 1600");
        self.say(0x007B, 1600, Duration::from_secs(4));
    }

    fn refuse(&mut self) {
        self.act("STW 003B, setpoint 1200000");
        self.say(0x003B, 1_200_000, CYCLE);
        self.act("STW 004B, setpoint 0");
        self.say(0x004B, 0, CYCLE);
        self.act("STW 0000, then 0200");
        self.say(0x0000, 0, CYCLE);
        self.say(0x0200, 0, CYCLE);
        self.act("STW 003B");
        self.say(0x003B, 0, CYCLE);
    }

    fn inch(&mut self) {
        self.act("STW 023B for a second, then 003B");
        self.say(0x023B, 0, Duration::from_secs(1));
        self.say(0x003B, 0, Duration::from_secs(1));
    }

    fn pause_and_stop(&mut self) {
        self.act("STW 007B, setpoint 0; 005B; 007B");
        self.say(0x007B, 0, Duration::from_secs(1));
        self.say(0x005B, 0, Duration::from_secs(1));
        self.say(0x007B, 0, CYCLE);
        self.act("STW 006B");
        self.say(0x006B, 0, Duration::from_secs(1));
        self.say(0x007B, 0, CYCLE);
    }

    fn fault(&mut self) {
        self.act("STW 003B, setpoint 16000; after a second the shaft is blocked");
        self.say(0x003B, 16_000, Duration::from_secs(1));
        self.inputs(Inputs::default().provoking(Fault::B));
        self.say(0x003B, 16_000, Duration::from_secs(2));
        self.act("the shaft is free");
        self.inputs(Inputs::default());
        self.say(0x003B, 16_000, CYCLE);
        self.act("STW 00BB");
        self.say(0x00BB, 16_000, CYCLE);
        self.act("STW 003A, then 003B");
        self.say(0x003A, 16_000, CYCLE);
        self.say(0x003B, 16_000, CYCLE);
    }

    fn parameters(&mut self) {
        self.act("PKW: change PNU 1004 to 50, then to 101");
        self.pkw = [0x23, 0xEC, 0, 0, 0, 0, 0, 50];
        self.say(0x003B, 16_000, CYCLE);
        self.pkw = [0x23, 0xEC, 0, 0, 0, 0, 0, 101];
        self.say(0x003B, 16_000, CYCLE);
        self.act("panel: PNU 930 = 1, velocity mode");
        let mode = Pnu::new(930).unwrap();
        let line = &mut self.line;
        line.device.write_parameter(line.now, mode, None, Value::Word(1)).unwrap();
        self.pkw = [0; 8];
        self.say(0x003B, 0, CYCLE);
        assert_eq!(self.line.device.status().mode, Mode::Velocity);
        self.act("STW 004B, setpoint 20, then 40; 000B");
        self.say(0x004B, 20, Duration::from_secs(1));
        self.say(0x004B, 40, Duration::from_secs(1));
        self.say(0x000B, 20, Duration::from_secs(2));
        self.act("battery 2.4 V");
        self.inputs(Inputs { battery: 2.4, ..Inputs::default() });
        self.say(0x000B, 0, CYCLE);
    }

    fn end(&mut self) {
        self.act("Global_Control: Freeze, Unfreeze");
        self.line.global_control(0x08, 0);
        self.line.global_control(0x04, 0);
        self.act("the master is silent");
        self.line.wait(Duration::from_millis(300));
        self.act("power off");
        let line = &mut self.line;
        line.device.power_off(line.now);
        self.line.wait(CYCLE);
        self.tell();
    }

    /// What was logged so far, then what is done now.
    fn act(&mut self, what: &str) {
        self.tell();
        writeln!(self.story, "> {what}").unwrap();
    }

    fn tell(&mut self) {
        for text in self.told.texts() {
            writeln!(self.story, "  {text}").unwrap();
        }
    }
}
