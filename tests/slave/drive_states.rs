//! The control and status words from the bus: chart 13 of the manual for positioning (`ag03.md` 5 and 7).

use std::time::Duration;

use profidrive::devices::ag03::drive::{Fault, Inputs};
use profidrive::devices::ag03::param::Parameter;
use profidrive::devices::ag03::unit;
use profidrive::face::EventKind;

use crate::drive_line;
use crate::drive_line::{IDENT, Line, MASTER};

/// Mask and value of the printed patterns (`ag03.md` 5).
const READY_TO_RUN: (u16, u16) = (0xAB6F, 0x2B23);
const OPERATION_ENABLED: (u16, u16) = (0x2B7F, 0x2B37);
const READY_TO_TRAVEL: (u16, u16) = (0xEB7F, 0xAB37);
const TRAVEL_JOB_ACTIVE: (u16, u16) = (0xEA7F, 0x0A37);
const TRAVEL_JOB_INACTIVE: (u16, u16) = (0xEB7F, 0xAB37);
const FAULT: (u16, u16) = (0x0008, 0x0008);
const TURN_ON_DISABLED: (u16, u16) = (0x0040, 0x0040);

struct Drive {
    line: Line,
}

impl Drive {
    fn new() -> Self {
        let mut line = Line::new();
        line.start_up();
        Self { line }
    }

    /// Sends STW and setpoint, lets the drive part see them, and returns ZSW and HIW.
    fn say(&mut self, stw: u16, setpoint: i32) -> (u16, i32) {
        let mut outputs = [0; 14];
        outputs[8..10].copy_from_slice(&stw.to_be_bytes());
        outputs[10..].copy_from_slice(&setpoint.to_be_bytes());
        self.line.exchange(&outputs);
        self.line.wait(Duration::from_millis(2));
        let inputs = self.line.exchange(&outputs);
        let zsw = u16::from_be_bytes(inputs[8..10].try_into().unwrap());
        (zsw, i32::from_be_bytes(inputs[10..].try_into().unwrap()))
    }

    #[track_caller]
    fn expect(&mut self, stw: u16, setpoint: i32, pattern: (u16, u16), what: &str) -> u16 {
        let (zsw, _) = self.say(stw, setpoint);
        assert_eq!(zsw & pattern.0, pattern.1, "{what}: ZSW {zsw:04X}");
        zsw
    }

    fn enable(&mut self) {
        self.expect(0x0000, 0, READY_TO_RUN, "STW 0000");
        self.expect(0x000B, 0, OPERATION_ENABLED, "STW 000B");
        self.expect(0x003B, 0, READY_TO_TRAVEL, "STW 003B");
    }

    fn refusals(&mut self) -> Vec<String> {
        let events = self.line.events.drain(..);
        events
            .filter(|event| event.kind() == EventKind::CommandRefused)
            .map(|event| event.to_string())
            .collect()
    }
}

#[test]
fn the_chart_of_the_manual_from_power_on_to_the_target() {
    let mut drive = Drive::new();
    assert_eq!(drive.expect(0x0000, 0, READY_TO_RUN, "power-on"), 0x2B23);
    assert_eq!(drive.expect(0x0002, 0, READY_TO_RUN, "no OFF2"), 0x2B33);
    assert_eq!(drive.expect(0x000B, 0, READY_TO_TRAVEL, "enabled"), 0xAB37);
    assert_eq!(drive.expect(0x003B, 1600, READY_TO_TRAVEL, "prepared"), 0xAB37);
    assert_eq!(drive.expect(0x007B, 1600, TRAVEL_JOB_ACTIVE, "edge"), 0x1B37);
    drive.line.wait(Duration::from_secs(3));
    assert_eq!(drive.expect(0x007B, 1600, READY_TO_TRAVEL, "there"), 0xBF37);
    assert_eq!(drive.say(0x007B, 1600).1, 1600);
    // The other edge starts the next job, and ZSW.12 toggles back.
    assert_eq!(drive.expect(0x003B, 0, TRAVEL_JOB_ACTIVE, "falling edge"), 0x0B37);
    drive.line.wait(Duration::from_secs(3));
    assert_eq!(drive.expect(0x003B, 0, READY_TO_TRAVEL, "back"), 0xAF37);
}

#[test]
fn pause_and_resume_keep_the_job() {
    let mut drive = Drive::new();
    drive.enable();
    drive.expect(0x007B, 8000, TRAVEL_JOB_ACTIVE, "started");
    drive.line.wait(Duration::from_secs(2));
    drive.expect(0x005B, 8000, TRAVEL_JOB_ACTIVE, "STW.5 = 0, the shaft brakes");
    drive.line.wait(Duration::from_secs(1));
    drive.expect(0x005B, 8000, TRAVEL_JOB_INACTIVE, "it stands");
    let (_, held) = drive.say(0x005B, 8000);
    drive.line.wait(Duration::from_secs(5));
    assert_eq!(drive.say(0x005B, 8000).1, held, "stands still");
    drive.expect(0x001B, 0, TRAVEL_JOB_INACTIVE, "row 25b: an edge while paused is refused");
    drive.expect(0x007B, 0, TRAVEL_JOB_ACTIVE, "STW.5 = 1");
    drive.line.wait(Duration::from_secs(20));
    assert_eq!(drive.say(0x007B, 0).1, 8000, "the latched target, not the new setpoint");
}

#[test]
fn every_documented_way_to_end_a_travel() {
    for (stw, pattern, motor_released, what) in [
        (0x006B, OPERATION_ENABLED, false, "stop, STW.4 = 0"),
        (0x0073, READY_TO_RUN, false, "disable, STW.3 = 0"),
        (0x007A, READY_TO_RUN, true, "OFF1, STW.0 = 0"),
        (0x0079, READY_TO_RUN, true, "OFF2, STW.1 = 0"),
        (0x0000, READY_TO_RUN, true, "all at once"),
    ] {
        let mut drive = Drive::new();
        drive.enable();
        drive.expect(0x007B, 16000, TRAVEL_JOB_ACTIVE, "started");
        drive.line.wait(Duration::from_secs(2));
        drive.say(stw, 16000);
        drive.line.wait(Duration::from_secs(2));
        let (zsw, stopped_at) = drive.say(stw, 16000);
        assert_eq!(zsw & pattern.0, pattern.1, "{what}: ZSW {zsw:04X}");
        assert!(stopped_at > 0 && stopped_at < 16000, "{what}");
        let ssw = drive.line.device.system_status();
        assert_eq!(ssw & 0x0080 != 0, motor_released, "{what}: SSW.7");
        assert_eq!(ssw & 0x4010, 0, "{what}: neither travelling nor positioning, SSW {ssw:04X}");
        // The job is gone: enabling again without an edge of STW.6 does not continue it.
        let again = 0x003B | stw & 0x0040;
        drive.say(again, 16000);
        drive.line.wait(Duration::from_secs(1));
        assert_eq!(drive.say(again, 16000).1, stopped_at, "{what}");
    }
}

#[test]
fn a_refused_start_says_every_reason_and_does_not_acknowledge() {
    let mut drive = Drive::new();
    drive.enable();
    let before = drive.say(0x003B, 1_200_000).0;
    assert_eq!(drive.say(0x007B, 1_200_000).0, before, "ZSW.12 unchanged");
    let refusals = drive.refusals();
    assert_eq!(refusals.len(), 1, "{refusals:?}");
    assert!(
        refusals[0].contains("1200000") && refusals[0].contains("upper limit (1000000 inc)"),
        "{refusals:?}"
    );
    drive.say(0x002B, 100);
    drive.say(0x006B, 100);
    let refusals = drive.refusals();
    assert!(
        refusals.iter().any(|refusal| refusal.contains("STW.4") || refusal.contains("stop")),
        "{refusals:?}"
    );
}

#[test]
fn a_fault_is_latched_acknowledged_and_released_by_off_1() {
    let mut drive = Drive::new();
    drive.enable();
    drive.expect(0x007B, 16000, TRAVEL_JOB_ACTIVE, "started");
    drive.line.device.set_inputs(drive.line.now, Inputs::default().provoking(Fault::F));
    drive.expect(0x007B, 16000, FAULT, "row 9");
    drive.expect(0x00FB, 16000, FAULT, "row 11: the cause persists");
    drive.line.device.set_inputs(drive.line.now, Inputs::default());
    drive.expect(0x00FB, 16000, FAULT, "row 12: no edge");
    drive.expect(0x007B, 16000, FAULT, "edge prepared");
    drive.expect(0x00FB, 16000, TURN_ON_DISABLED, "row 10");
    drive.expect(0x007B, 16000, TURN_ON_DISABLED, "row 14");
    drive.expect(0x007A, 16000, READY_TO_RUN, "row 13");
    drive.expect(0x000B, 16000, READY_TO_TRAVEL, "enabled again");
    assert!(drive.line.has_told(&unit::Event::Fault(Fault::F)));
}

#[test]
fn supply_lost_and_back() {
    let mut drive = Drive::new();
    drive.enable();
    drive.expect(0x007B, 16000, TRAVEL_JOB_ACTIVE, "started");
    let lost = Inputs::default().with_output_stage(false);
    drive.line.device.set_inputs(drive.line.now, lost);
    drive.expect(0x007B, 16000, (0x806F, 0x0020), "row 3: not ready to turn on");
    drive.line.device.set_inputs(drive.line.now, Inputs::default());
    drive.expect(0x0000, 16000, READY_TO_RUN, "row 2");
}

#[test]
fn row_50_leaving_data_exchange_takes_the_enable_away() {
    let prm = [0x88, 1, 10, 11, IDENT[0], IDENT[1], 0];
    let mut line = Line::new();
    line.start_up_with(&prm);
    let mut drive = Drive { line };
    drive.enable();
    drive.expect(0x007B, 16000, TRAVEL_JOB_ACTIVE, "started");
    drive.line.wait(Duration::from_secs(5));
    let zsw = drive.line.device.zsw().raw();
    assert_eq!(zsw & READY_TO_RUN.0, READY_TO_RUN.1, "{zsw:04X}");
    // A break shorter than an application cycle counts too.
    drive.line.start_up_with(&prm);
    drive.enable();
    drive.line.request(MASTER, Some(61), &prm);
    drive.line.request(MASTER, Some(62), &drive_line::CFG);
    let first = drive.line.exchange(&[0, 0, 0, 0, 0, 0, 0, 0, 0x00, 0x7B, 0, 0, 0, 100]);
    let zsw = u16::from_be_bytes([first[8], first[9]]);
    assert_eq!(zsw & 0x0004, 0, "not enabled by what was before: {zsw:04X}");
}

#[test]
fn row_51_clear_data_takes_the_enable_away() {
    let mut drive = Drive::new();
    drive.enable();
    drive.line.global_control(0x02, 0);
    drive.line.wait(Duration::from_millis(2));
    let zsw = drive.line.device.zsw().raw();
    assert_eq!(zsw & READY_TO_RUN.0, READY_TO_RUN.1, "{zsw:04X}");
}

/// Time of a travel of `s` increments at `v` inc/s with `a` inc/s² both ways.
fn closed_formula(s: f64, v: f64, a: f64) -> f64 {
    if s >= v * v / a { s / v + v / a } else { 2.0 * (s / a).sqrt() }
}

#[test]
fn default_travels_take_the_time_of_the_closed_formula() {
    // 30 rpm = 800 inc/s, 50 % = 2 rev/s² = 3200 inc/s².
    for distance in [1600, 16_000, -48_000, 50] {
        let mut drive = Drive::new();
        drive.enable();
        let (_, start) = drive.say(0x003B, distance);
        let mut outputs = [0; 14];
        outputs[8..10].copy_from_slice(&0x007B_u16.to_be_bytes());
        outputs[10..].copy_from_slice(&distance.to_be_bytes());
        drive.line.exchange(&outputs);
        let status = |drive: &Drive| *drive.line.device.status();
        let millisecond = Duration::from_millis(1);
        let mut waited = 0;
        while !status(&drive).job_active {
            drive.line.wait(millisecond);
            waited += 1;
            assert!(waited < 5, "the job starts at once");
        }
        let begun = drive.line.now;
        let mut last = start;
        while status(&drive).job_active {
            drive.line.wait(millisecond);
            let position = status(&drive).position;
            assert!((position - last) * distance.signum() >= 0, "never back");
            assert!((distance - position) * distance.signum() >= 0, "never beyond: {position}");
            last = position;
        }
        // The step in which the job was seen started is part of its time.
        let took = drive.line.now.saturating_since(begun).as_secs_f64() + 0.001;
        let expected = closed_formula(f64::from(distance.abs()), 800.0, 3200.0);
        assert!((took - expected).abs() <= 0.001 + 1e-9, "{distance}: {took} s, expected {expected} s");
        assert!(status(&drive).target_reached);
        assert_eq!(last, distance);
    }
}

#[test]
fn the_limits_act_on_ssw_zsw_and_starts() {
    let mut drive = Drive::new();
    drive.enable();
    // Limit 1 = -100 by PKW, limit 2 stays at -1000000: position 0 is above both.
    let write = [0x33, 0xF8, 0, 0, 0xFF, 0xFF, 0xFF, 0x9C, 0x00, 0x3B, 0, 0, 0, 0];
    drive.line.exchange(&write);
    drive.line.wait(Duration::from_millis(3));
    assert_eq!(drive.line.device.parameters().value(Parameter::Limit1), -100);
    let ssw = drive.line.device.system_status();
    assert_eq!(ssw & 0x0860, 0x0820, "above the upper limit, not ready to travel: {ssw:04X}");
    let zsw = drive.expect(0x003B, -200, OPERATION_ENABLED, "ZSW.14");
    assert_eq!(zsw & 0xC000, 0x4000, "{zsw:04X}");
    drive.expect(0x007B, -200, OPERATION_ENABLED, "start refused");
    assert_eq!(drive.refusals().len(), 1);
}
