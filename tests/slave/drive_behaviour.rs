//! What ZSW, HIW and the parameters show while the shaft brakes, catches up, is blocked or runs out: every model and
//! gear, at several ramps.

use std::time::Duration;

use profidrive::devices::ag03::drive::Inputs;
use profidrive::devices::ag03::param::{Gear, Model};
use profidrive::devices::ag03::profibus::{Config, Timing};
use profidrive::profibus::fdl::Address;

use crate::drive_line::Line;

const READ_SSW: [u16; 4] = [0x13FC, 0, 0, 0];
const READ_GENERAL_STATUS: [u16; 4] = [0x1407, 0, 0, 0];
const CALIBRATE: [u16; 4] = [0x23CA, 0, 0, 5];
/// Increments/s² of 1 %.
const PERCENT: f64 = 64.0;

/// A drive in Data_Exchange.
struct Drive {
    line: Line,
    stw: u16,
    setpoint: i32,
    gear: Gear,
    zsw: u16,
    hiw: i32,
}

impl Drive {
    fn new(model: Model, gear: Gear, quirks: &[(&str, &str)]) -> Self {
        let address = Address::station(5).unwrap();
        let mut config = Config { model, gear, timing: Timing::True, ..Config::new(address) };
        for (name, value) in quirks {
            config.set_quirk(name, value).unwrap();
        }
        let mut line = Line::with(config);
        line.start_up();
        let mut drive = Self { line, stw: 0, setpoint: 0, gear, zsw: 0, hiw: 0 };
        drive.say(0x0000);
        drive
    }

    /// One exchange and what it shows.
    fn exchange(&mut self, pkw: [u16; 4]) -> [u16; 4] {
        let mut outputs: Vec<u8> = pkw.iter().flat_map(|word| word.to_be_bytes()).collect();
        outputs.extend(self.stw.to_be_bytes());
        outputs.extend(self.setpoint.to_be_bytes());
        let inputs = self.line.exchange(&outputs);
        let word = |n: usize| u16::from_be_bytes([inputs[2 * n], inputs[2 * n + 1]]);
        self.zsw = word(4);
        self.hiw = i32::from_be_bytes(inputs[10..].try_into().unwrap());
        [word(0), word(1), word(2), word(3)]
    }

    /// A job until it is answered.
    fn job(&mut self, pkw: [u16; 4]) -> [u16; 4] {
        self.exchange([0; 4]);
        self.line.wait(Duration::from_millis(2));
        self.exchange(pkw);
        self.line.wait(Duration::from_millis(2));
        self.exchange(pkw)
    }

    fn write(&mut self, pnu: u16, value: u16) {
        assert_eq!(self.job([0x2000 | pnu, 0, 0, value])[3], value);
    }

    fn say(&mut self, stw: u16) -> u16 {
        self.stw = stw;
        self.wait(0);
        self.zsw
    }

    fn wait(&mut self, millis: u64) {
        self.exchange([0; 4]);
        self.line.wait(Duration::from_millis(millis + 2));
        self.exchange([0; 4]);
    }

    fn inputs(&mut self, change: impl FnOnce(&mut Inputs)) {
        let mut inputs = Inputs::default();
        change(&mut inputs);
        self.line.device.set_inputs(self.line.now, inputs);
    }

    fn top_rpm(&self) -> u16 {
        match self.gear {
            Gear::Ratio24 => 200,
            Gear::Ratio48 => 100,
        }
    }

    /// More than the motor can turn at the most speed.
    fn heavy(&self) -> f64 {
        match self.gear {
            Gear::Ratio24 => 2.5,
            Gear::Ratio48 => 5.0,
        }
    }
}

/// Every model and gear.
fn drives() -> impl Iterator<Item = Drive> {
    [Model::Ag03, Model::Ag03_1]
        .into_iter()
        .flat_map(|model| [Gear::Ratio24, Gear::Ratio48].map(|gear| Drive::new(model, gear, &[])))
}

const RAMPS: [u16; 4] = [1, 10, 50, 100];

#[test]
fn an_intermediate_stop_shows_standstill_and_readiness_when_the_shaft_stands() {
    for ramp in RAMPS {
        for mut drive in drives() {
            drive.write(1003, ramp);
            drive.write(1004, 60);
            drive.say(0x003B);
            drive.setpoint = 500_000;
            drive.say(0x007B);
            drive.wait(1000 + 26_000 / u64::from(ramp));
            drive.say(0x005B);
            let mut images = 0;
            while drive.zsw & 0x2000 == 0 {
                assert_eq!(drive.zsw & 0xEA7F, 0x0A37, "{ramp} %: chart 13, travel job active");
                let before = drive.hiw;
                drive.line.wait(Duration::from_millis(5));
                let ssw = drive.exchange(READ_SSW);
                let braking = drive.zsw & 0x2000 == 0;
                assert!(ssw[0] != 0x13FC || !braking || ssw[3] & 0x4800 == 0x4800, "SSW {:04X}", ssw[3]);
                assert!(drive.hiw >= before);
                images += 1;
            }
            assert!(images >= 200 / u32::from(ramp), "{ramp} %: {images} images");
            assert_eq!(drive.zsw & 0xEB7F, 0xAB37, "chart 13, travel job inactive");
            let stands = drive.hiw;
            let ssw = drive.job(READ_SSW)[3];
            assert_eq!(ssw & 0x4810, 0, "SSW {ssw:04X}: ready, stands, not positioning");
            drive.wait(500);
            assert_eq!(drive.hiw, stands, "{ramp} %");
            assert_eq!(drive.say(0x007B) & 0xEA7F, 0x0A37);
        }
    }
}

#[test]
fn in_velocity_mode_standstill_is_shown_only_when_the_shaft_stands() {
    for ramp in RAMPS {
        for mut drive in drives() {
            drive.write(930, 1);
            drive.write(1005, ramp);
            drive.setpoint = 60;
            for stw in [0x004A, 0x0049, 0x0043, 0x0000, 0x000B] {
                drive.say(0x000B);
                drive.say(0x004B);
                drive.wait(1000 + 26_000 / u64::from(ramp));
                assert_eq!(drive.hiw, 60);
                drive.say(stw);
                assert_ne!(drive.hiw, 0);
                let mut images = 0;
                while drive.hiw != 0 {
                    assert_eq!(drive.zsw & 0xA000, 0, "STW {stw:04X}, {} rpm: {:04X}", drive.hiw, drive.zsw);
                    drive.wait(1);
                    images += 1;
                }
                assert!(images > 20);
                drive.wait(1000);
                assert_eq!(drive.zsw & 0x2000, 0x2000, "STW {stw:04X}: {:04X}", drive.zsw);
            }
        }
    }
}

#[test]
fn a_freed_shaft_keeps_v_pos_and_a_pos() {
    for ramp in RAMPS {
        for (v_pos, mut drive) in
            [10, 30, 100].into_iter().flat_map(|v_pos| drives().map(move |drive| (v_pos, drive)))
        {
            drive.write(1003, ramp);
            drive.write(1004, v_pos);
            drive.say(0x003B);
            drive.setpoint = 400_000;
            drive.say(0x007B);
            drive.wait(1000);
            drive.inputs(|inputs| inputs.blocked = true);
            drive.line.wait(Duration::from_millis(450));
            drive.inputs(|_| {});
            let speed = f64::from(v_pos) * 1600.0 / 60.0;
            let acceleration = f64::from(ramp) * PERCENT;
            let (mut place, mut seen, mut last) = (drive.hiw, drive.line.now, 0.0);
            for _ in 0..40 {
                drive.line.wait(Duration::from_millis(50));
                drive.exchange([0; 4]);
                let time = drive.line.now.saturating_since(seen).as_secs_f64();
                seen = drive.line.now;
                let now = f64::from(drive.hiw - place) / time;
                // HIW is whole increments, of the last application cycle (1 ms).
                let rounding = (1.0 + 0.0011 * speed) / time;
                assert!(now <= speed + rounding, "{ramp} %, {v_pos} rpm: {now} increments/s");
                let most = acceleration * (time + 0.0011) + 2.0 * rounding;
                assert!(last == 0.0 || now - last <= most, "{ramp} %, {v_pos} rpm: {last} to {now}");
                (place, last) = (drive.hiw, now);
            }
            assert_eq!(drive.zsw & 0x0008, 0);
        }
    }
}

#[test]
fn in_velocity_mode_a_freed_shaft_keeps_a_rot() {
    for ramp in RAMPS {
        for mut drive in drives() {
            drive.write(930, 1);
            drive.write(1005, ramp);
            drive.setpoint = drive.top_rpm().into();
            drive.say(0x000B);
            drive.say(0x004B);
            drive.wait(1000 + 84_000 / u64::from(ramp));
            assert_eq!(drive.hiw, drive.setpoint);
            let heavy = drive.heavy();
            drive.inputs(|inputs| inputs.friction_torque = heavy);
            drive.wait(2000);
            let slow = drive.hiw;
            assert!(slow < drive.setpoint / 2, "{slow} rpm");
            drive.inputs(|_| {});
            let (mut last, mut seen) = (slow, drive.line.now);
            for _ in 0..200 {
                drive.wait(8);
                let time = drive.line.now.saturating_since(seen).as_secs_f64();
                seen = drive.line.now;
                // 1 % are 2.4 rpm/s; HIW is whole rpm, of the last application cycle (1 ms).
                let most = f64::from(ramp) * 2.4 * (time + 0.0011) + 1.0;
                assert!(f64::from(drive.hiw - last) <= most, "{ramp} %: {last} to {}", drive.hiw);
                assert!(drive.hiw <= drive.setpoint);
                last = drive.hiw;
            }
            assert!(last > slow, "{last}");
        }
    }
}

#[test]
fn the_torque_deactivation_acts_in_inching_too() {
    for ramp in RAMPS {
        for (stw, mut drive) in
            [0x010B, 0x020B, 0x820B].into_iter().flat_map(|stw| drives().map(move |d| (stw, d)))
        {
            drive.write(1032, 60);
            drive.write(1007, ramp);
            drive.say(0x000B);
            drive.say(stw);
            drive.wait(300);
            drive.inputs(|inputs| inputs.blocked = true);
            drive.wait(2000);
            assert_eq!(drive.zsw & 0xAB7F, 0xAB37, "{stw:04X}: no fault, stands, enabled: {:04X}", drive.zsw);
            assert_eq!(drive.job(READ_SSW)[3] & 0x0080, 0, "the motor stays in control");
            assert_eq!(drive.job(READ_GENERAL_STATUS)[3] & 0x0080, 0x0080);
            drive.inputs(|_| {});
            let place = drive.hiw;
            drive.wait(500);
            assert_eq!(drive.hiw, place, "it does not begin again by itself");
            drive.say(0x000B);
            drive.say(stw);
            drive.wait(1000);
            assert_ne!(drive.hiw, place);
            assert_eq!(drive.job(READ_GENERAL_STATUS)[3] & 0x0080, 0, "reset with the next one");
        }
    }
}

#[test]
fn a_drive_that_turns_is_not_calibrated() {
    let refused = |drive: &mut Drive| drive.job(CALIBRATE) == [0x73CA, 0, 0, 17];
    for mut drive in drives() {
        drive.write(930, 1);
        drive.setpoint = 60;
        drive.say(0x000B);
        assert!(!refused(&mut drive));
        drive.say(0x004B);
        drive.wait(1000);
        assert!(refused(&mut drive), "velocity mode, 60 rpm");
        drive.setpoint = 0;
        drive.wait(1000);
        assert!(refused(&mut drive), "the setpoint 0 is released: a travel job");
        drive.setpoint = 60;
        drive.wait(1000);
        drive.stw = 0x000B;
        assert!(refused(&mut drive), "running down");
        drive.wait(1000);
        assert!(!refused(&mut drive), "stands");
    }
}

#[test]
fn d_pos_may_be_written_in_travel_and_does_not_change_it() {
    for gear in [Gear::Ratio24, Gear::Ratio48] {
        for (quirk, reply) in [("any-time", [0x140F, 0, 0, 60]), ("no-job", [0x740F, 0, 0, 17])] {
            let mut drive = Drive::new(Model::Ag03_1, gear, &[("d-pos", quirk)]);
            drive.say(0x003B);
            drive.setpoint = 1600;
            drive.say(0x007B);
            assert_eq!(drive.job([0x240F, 0, 0, 60]), reply);
            drive.wait(2300);
            assert_eq!((drive.hiw, drive.zsw & 0x0400), (1600, 0x0400));
        }
    }
}
