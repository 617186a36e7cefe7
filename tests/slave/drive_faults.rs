//! Every fault and warning of the manual (chapter 5), provoked by what causes it and seen from the bus.

use std::time::Duration;

use profidrive::devices::ag03::drive::{Fault, Inputs, StatusLed, leds};
use profidrive::devices::ag03::param::{Gear, Model};
use profidrive::devices::ag03::profibus::{Config, Leds, Timing};
use profidrive::profibus::fdl::Address;

use crate::drive_line;
use crate::drive_line::Line;

const FAULT: u16 = 0x0008;
const TURN_ON_DISABLED: u16 = 0x0040;
const WARNING: u16 = 0x0080;
const NO_LAG_ERROR: u16 = 0x0100;

fn config(model: Model) -> Config {
    Config { model, timing: Timing::True, ..Config::new(Address::station(5).unwrap()) }
}

struct Drive {
    line: Line,
    stw: u16,
    setpoint: i32,
}

impl Drive {
    /// In Data_Exchange with operation enabled.
    fn enabled(model: Model) -> Self {
        Self::with(config(model))
    }

    fn with(config: Config) -> Self {
        let mut line = Line::with(config);
        line.start_up();
        let mut drive = Self { line, stw: 0x003B, setpoint: 0 };
        drive.run(2);
        drive
    }

    /// On its way at 30 rpm.
    fn travelling(model: Model) -> Self {
        let mut drive = Self::enabled(model);
        drive.setpoint = 500_000;
        drive.stw = 0x007B;
        drive.run(2000);
        drive
    }

    /// Says a control word for 2 ms.
    fn say(&mut self, stw: u16) {
        self.stw = stw;
        self.run(2);
    }

    fn run(&mut self, millis: u64) {
        self.exchange([0; 8]);
        self.line.wait(Duration::from_millis(millis));
    }

    fn exchange(&mut self, pkw: [u8; 8]) -> [u8; 14] {
        let mut outputs = [0; 14];
        outputs[..8].copy_from_slice(&pkw);
        outputs[8..10].copy_from_slice(&self.stw.to_be_bytes());
        outputs[10..].copy_from_slice(&self.setpoint.to_be_bytes());
        self.line.exchange(&outputs)
    }

    fn zsw(&mut self) -> u16 {
        let inputs = self.exchange([0; 8]);
        u16::from_be_bytes([inputs[8], inputs[9]])
    }

    /// PWE of the reply to a read job.
    fn read(&mut self, job: u8, pnu: u16) -> u32 {
        let [high, low] = (u16::from(job) << 12 | pnu).to_be_bytes();
        let request = [high, low, 0, 0, 0, 0, 0, 0];
        self.exchange(request);
        self.line.wait(Duration::from_millis(2));
        let reply = self.exchange(request);
        assert!(matches!(reply[0] >> 4, 1 | 2 | 4), "PNU {pnu} refused");
        self.exchange([0; 8]);
        u32::from_be_bytes(reply[4..8].try_into().unwrap())
    }

    fn ssw(&mut self) -> u32 {
        self.read(1, 1020)
    }

    fn set(&mut self, inputs: Inputs) {
        self.line.device.set_inputs(self.line.now, inputs);
    }

    fn leds(&self) -> Leds {
        self.line.device.leds(self.line.now)
    }

    fn diagnosis(&mut self) -> Vec<u8> {
        match self.line.request(drive_line::MASTER, Some(60), &[]) {
            drive_line::Reply::Data(octets) => octets,
            other => panic!("{other:?}"),
        }
    }

    /// Blinks of each whole sequence seen in 25 seconds.
    fn blinks(&mut self) -> Vec<u8> {
        let mut sequences = Vec::from([0]);
        let mut lit = self.leds().status;
        let mut dark = Duration::ZERO;
        let step = Duration::from_millis(10);
        for _ in 0..2500 {
            self.line.wait(step);
            let now = self.leds().status;
            if now && !lit {
                *sequences.last_mut().unwrap() += 1;
            }
            dark = if now { Duration::ZERO } else { dark + step };
            if dark == leds::BLINK_PAUSE {
                sequences.push(0);
            }
            lit = now;
        }
        sequences.remove(0);
        sequences.pop();
        sequences
    }
}

/// A row of the manual's Table 2: what is done to a travelling drive, and how long the fault may take.
struct Row {
    fault: Fault,
    blinks: u8,
    cause: fn(&mut Inputs),
    millis: u64,
}

const TABLE_2: [Row; 8] = [
    // supply voltage < 18 V and motor current > 200 mA
    Row {
        fault: Fault::A,
        blinks: 1,
        cause: |inputs| {
            (inputs.control_supply, inputs.output_supply) = (17.9, 17.9);
            inputs.friction_torque = 0.3;
        },
        millis: 3,
    },
    // shaft blocked: speed < 2 rpm and lag error
    Row { fault: Fault::B, blinks: 2, cause: |inputs| inputs.blocked = true, millis: 700 },
    // motor current > 2.4 A for more than 4 s
    Row { fault: Fault::C, blinks: 3, cause: |inputs| inputs.friction_torque = 4.7, millis: 4010 },
    // output stage > 90 degC
    Row { fault: Fault::D, blinks: 4, cause: |inputs| inputs.ambient = 91.0, millis: 30_000 },
    // SIN/COS monitoring
    Row { fault: Fault::E, blinks: 5, cause: |inputs| inputs.encoder_fault = true, millis: 3 },
    // internal error
    Row { fault: Fault::F, blinks: 6, cause: |inputs| inputs.internal_fault = true, millis: 3 },
    // intermediate circuit > 35 V: a supply too high, and at speed a load that drives the shaft
    Row { fault: Fault::G, blinks: 7, cause: |inputs| inputs.dc_link = Some(35.1), millis: 3 },
    // battery < 2.2 V
    Row { fault: Fault::J, blinks: 10, cause: |inputs| inputs.battery = 2.19, millis: 3 },
];

#[test]
fn every_fault_of_table_2_is_provoked_seen_and_acknowledged() {
    for model in Model::ALL {
        for row in TABLE_2 {
            let fault = row.fault;
            let mut drive = Drive::travelling(model);
            let healthy = drive.diagnosis();
            assert_eq!(drive.leds().pattern, StatusLed::On);
            let mut inputs = Inputs::default();
            (row.cause)(&mut inputs);
            drive.set(inputs);
            drive.run(row.millis);

            if !fault.exists_on(model) {
                assert_eq!(drive.zsw() & FAULT, 0, "{model} does not know {fault}");
                assert_eq!(drive.read(1, 952), 0);
                continue;
            }
            // latched: ZSW.3, SSW.8, no more motion commanded, motor released (SSW.7)
            assert_eq!(drive.zsw() & 0x800C, FAULT, "{model} {fault}");
            let ssw = drive.ssw();
            assert_eq!(ssw & 0x4180, 0x0180, "{model} {fault}: SSW {ssw:04X}");
            // shown: LED, buffer, counter, and nothing in the DP diagnosis
            assert_eq!(drive.leds().pattern, StatusLed::Blinking(fault));
            let blinks = drive.blinks();
            assert!(blinks.len() >= 2 && blinks.iter().all(|&n| n == row.blinks), "{fault}: {blinks:?}");
            assert!(drive.leds().bus);
            assert_eq!(drive.read(6, 945), u32::from(fault.code()), "PNU 945, newest");
            assert_eq!(drive.read(1, 952), 1, "PNU 952");
            assert_eq!(drive.diagnosis(), healthy, "{fault} is not in the diagnosis");

            // cause gone, acknowledged, turn-on disabled, OFF1, enabled again
            drive.set(Inputs::default());
            drive.run(20_000);
            assert_eq!(drive.zsw() & FAULT, FAULT, "latched");
            drive.say(0x00FB);
            assert_eq!(drive.zsw() & (FAULT | TURN_ON_DISABLED), TURN_ON_DISABLED, "{fault}");
            assert_eq!(drive.leds().pattern, StatusLed::On);
            drive.say(0x0000);
            drive.say(0x003B);
            assert_eq!(drive.zsw() & 0x804F, 0x8007, "{fault}: ready-to-travel");
            assert_eq!(drive.read(6, 945), u32::from(fault.code()), "the buffer keeps it");
        }
    }
}

#[test]
fn a_cause_that_stays_cannot_be_acknowledged() {
    for fault in [Fault::D, Fault::E, Fault::F, Fault::G, Fault::J] {
        let mut drive = Drive::travelling(Model::Ag03_1);
        drive.set(Inputs::default().provoking(fault));
        drive.run(3);
        drive.say(0x00FB);
        assert_eq!(drive.zsw() & (FAULT | TURN_ON_DISABLED), FAULT, "{fault}");
    }
}

#[test]
fn provoking_makes_each_fault_on_a_travelling_drive_of_either_gear() {
    let gears = Gear::ALL.into_iter().flat_map(|gear| Model::ALL.map(|model| (model, gear)));
    for ((model, gear), fault) in gears.flat_map(|drive| Fault::ALL.map(|fault| (drive, fault))) {
        if !fault.exists_on(model) {
            continue;
        }
        let mut drive = Drive::with(Config { gear, ..config(model) });
        drive.setpoint = 500_000;
        drive.say(0x007B);
        drive.run(2000);
        // Acceleration takes the current that A asks for.
        drive.say(0x006B);
        drive.run(500);
        let inputs = drive.line.device.drive().provoking(&Inputs::default(), fault);
        drive.set(inputs);
        drive.say(0x003B);
        drive.say(0x007B);
        drive.run(6000);
        assert_eq!(drive.read(6, 945), u32::from(fault.code()), "{model} {gear} {fault}");
        // Some causes went with the motion, and would come back with it.
        let provoked = drive.line.device.drive().provoked_by(&inputs);
        assert_eq!(provoked.iter().collect::<Vec<_>>(), [fault], "{model} {gear} {fault}");
        assert!(drive.line.device.drive().provoked_by(&Inputs::default()).is_empty());
    }
}

#[test]
fn too_much_friction_or_too_little_supply_blocks_the_shaft_instead() {
    let drive = Drive::with(config(Model::Ag03_1));
    let provoked = |inputs| drive.line.device.drive().provoked_by(&inputs).iter().collect::<Vec<_>>();
    let nominal = Inputs::default();
    assert_eq!(provoked(Inputs { friction_torque: 5.0, ..nominal }), [Fault::C]);
    assert_eq!(provoked(Inputs { load_torque: -5.0, ..nominal }), [Fault::C]);
    assert_eq!(provoked(Inputs { friction_torque: 6.0, ..nominal }), [Fault::B]);
    assert_eq!(provoked(Inputs { friction_torque: 5.0, output_supply: 19.0, ..nominal }), [Fault::B]);
    assert_eq!(provoked(Inputs { output_supply: 0.0, control_supply: 0.0, ..nominal }), []);
    assert_eq!(provoked(Inputs { output_supply: 40.0, ambient: 95.0, ..nominal }), [Fault::D, Fault::G]);
}

#[test]
fn a_hanging_weight_makes_g_on_its_way_down() {
    let config =
        Config { gear: Gear::Ratio24, timing: Timing::True, ..Config::new(Address::station(5).unwrap()) };
    let mut line = Line::with(config);
    line.start_up();
    let mut drive = Drive { line, stw: 0x003B, setpoint: 500_000 };
    drive.set(Inputs { load_torque: -2.5, ..Inputs::default() });
    drive.run(2);
    // v-Pos = 200 rpm
    drive.exchange([0x23, 0xEC, 0, 0, 0, 0, 0, 200]);
    drive.run(2);
    drive.say(0x007B);
    drive.run(4000);
    assert_eq!(drive.read(6, 945), u32::from(b'G'));
}

#[test]
fn every_warning_comes_and_goes_without_an_influence_on_the_travel() {
    // what causes it, how long it takes, its bit of SSW, and whether ZSW.8 shows it too
    let nominal = Inputs::default();
    for (inputs, millis, bit, lag) in [
        (Inputs { battery: 2.59, ..nominal }, 5, 0x1000, false),
        (Inputs { friction_torque: 4.7, ..nominal }, 3000, 0x2000, false),
        // 18.5 V leave 6 rpm against 4.3 Nm, and 2.3 A
        (Inputs { friction_torque: 4.3, output_supply: 18.5, ..nominal }, 5000, 0x8000, true),
    ] {
        let mut drive = Drive::travelling(Model::Ag03_1);
        drive.set(inputs);
        drive.run(millis);
        let (zsw, ssw) = (drive.zsw(), drive.ssw());
        assert_eq!(ssw & 0xB000, bit, "SSW {ssw:04X}");
        assert_eq!(zsw & WARNING, WARNING, "ZSW {zsw:04X}");
        assert_eq!(zsw & NO_LAG_ERROR == 0, lag, "ZSW {zsw:04X}");
        assert_eq!(ssw & 0x4000, 0x4000, "still travelling");
        drive.set(Inputs::default());
        drive.run(3000);
        let (zsw, ssw) = (drive.zsw(), drive.ssw());
        assert_eq!((zsw & (WARNING | FAULT | NO_LAG_ERROR), ssw & 0xB000), (NO_LAG_ERROR, 0));
        assert_eq!(drive.read(1, 952), 0, "no fault");
        assert_eq!(ssw & 0x4000, 0x4000, "still travelling");
    }
}

#[test]
fn the_ten_newest_faults_are_kept_and_command_4_of_pnu_970_clears_them() {
    let mut drive = Drive::enabled(Model::Ag03_1);
    for number in 0..12 {
        let fault = if number % 2 == 0 { Fault::F } else { Fault::D };
        drive.set(Inputs::default().provoking(fault));
        drive.say(0x0000);
        drive.set(Inputs::default());
        drive.say(0x0080);
        drive.say(0x0000);
    }
    assert_eq!(drive.read(1, 952), 12);
    assert_eq!(drive.read(6, 945), u32::from(b'D'));
    drive.exchange([0x23, 0xCA, 0, 0, 0, 0, 0, 4]);
    drive.run(2);
    assert_eq!((drive.read(1, 952), drive.read(6, 945)), (0, 0));
}

#[test]
fn the_measured_values_of_the_ag03_1_show_the_plant() {
    let mut drive = Drive::travelling(Model::Ag03_1);
    drive.set(Inputs {
        control_supply: 23.5,
        output_supply: 26.0,
        battery: 2.95,
        friction_torque: 2.0,
        ..Inputs::default()
    });
    drive.run(60_000);
    assert_eq!(drive.read(1, 1029), 1100, "mA: 0.1 A idle and 2 Nm");
    assert_eq!(drive.read(1, 1027), 371, "0.1 degC: 25 + 10 K/A^2 * 1.21 A^2");
    assert_eq!(drive.read(1, 1040), 260);
    assert_eq!(drive.read(1, 1041), 235);
    assert_eq!(drive.read(1, 1042), 295);
    assert_eq!(drive.read(1, 1031), 0x0010, "output stage supplied");
    drive.set(Inputs::default().with_output_stage(false));
    drive.run(10);
    assert_eq!(drive.read(1, 1040), 0);
    assert_eq!(drive.read(1, 1031), 0);
    assert_eq!(drive.leds().pattern, StatusLed::Off);
}

#[test]
fn the_leds_tell_the_models_apart() {
    // AG03: enable input, one supply; AG03/1: both supplies
    for (model, inputs, led) in [
        (Model::Ag03, Inputs::default(), StatusLed::On),
        (Model::Ag03, Inputs { enable_input: false, ..Inputs::default() }, StatusLed::Off),
        (Model::Ag03, Inputs { output_supply: 0.0, ..Inputs::default() }, StatusLed::On),
        (Model::Ag03, Inputs { control_supply: 0.0, ..Inputs::default() }, StatusLed::Off),
        (Model::Ag03_1, Inputs { enable_input: false, ..Inputs::default() }, StatusLed::On),
        (Model::Ag03_1, Inputs { output_supply: 0.0, ..Inputs::default() }, StatusLed::Off),
        (Model::Ag03_1, Inputs { control_supply: 0.0, ..Inputs::default() }, StatusLed::Off),
    ] {
        let mut drive = Drive::enabled(model);
        drive.set(inputs);
        drive.line.wait(Duration::from_millis(3));
        assert_eq!(drive.leds().pattern, led, "{model} {inputs:?}");
        assert_eq!(drive.leds().bus, inputs.control_supply > 0.0, "off, it exchanges no data");
    }
    let line = Line::new();
    assert!(!line.device.leds(line.now).bus, "no Data_Exchange yet");
}

#[test]
fn a_factory_reset_blinks_both_leds_alternately_and_a_drive_that_is_off_shows_nothing() {
    use profidrive::devices::ag03::profibus::{DipSwitches, Power};

    let mut drive = Drive::enabled(Model::Ag03_1);
    let now = drive.line.now;
    drive.line.device.power_off(now);
    assert_eq!(drive.leds(), Leds { status: false, pattern: StatusLed::Off, bus: false });
    // SW1 and SW8
    drive.line.device.set_switches(DipSwitches::from_bits(0x0081));
    drive.line.device.power_on(now);
    assert!(matches!(drive.line.device.power(), Power::FactoryReset(_)));
    let mut changes = 0;
    let mut before = drive.leds();
    for millis in 0..2000 {
        let leds = drive.line.device.leds(now.saturating_add(Duration::from_millis(millis)));
        assert_ne!(leds.status, leds.bus);
        changes += u32::from(leds.status != before.status);
        before = leds;
    }
    assert_eq!(changes, 8, "every quarter of a second");
}
