//! Control and status words as the manual prints them, to check its patterns. The library composes them elsewhere.

use super::*;

/// `stw` after `before`; `None`: outside Data_Exchange. Each change of STW.6 asks for a job.
pub(super) fn command(before: u16, stw: Option<u16>, setpoint: i32) -> Command {
    let word = stw.unwrap_or(0);
    let bit = |n: u32| word & (1 << n) != 0;
    let edge = (word ^ before) & 0x0040 != 0;
    let operation = match word & 0x000b {
        0x000b => Operation::Run,
        0x0003 => Operation::BrakeAndHold,
        _off1_or_off2 => Operation::Release,
    };
    Command {
        operation,
        enable: bit(3) && before & 8 == 0,
        travel: edge && (bit(6) || operation == Operation::Run),
        turn: bit(6),
        setpoint: if stw.is_some() { setpoint } else { 0 },
        stop: !bit(4),
        pause: !bit(5),
        inch_1: bit(8),
        inch_2: bit(9).then_some(Direction::negative_if(bit(15))),
        acknowledge: bit(7),
        rearm: !bit(0),
        keys: stw.is_none(),
    }
}

/// `ag03.md` 5.
pub(super) fn zsw(status: &Status, stw: u16) -> u16 {
    let velocity = status.mode == Mode::Velocity;
    let bits = [
        status.supply_ok,
        status.supply_ok,
        status.operation_enabled,
        status.fault.is_some(),
        stw & 2 != 0,
        true,
        status.turn_on_disabled,
        status.warning,
        if velocity { status.in_window } else { !status.lag_error },
        true,
        velocity || status.target_reached,
        true,
        velocity || status.jobs & 1 != 0,
        status.standstill,
        !velocity && (status.above_upper_limit || status.below_lower_limit),
        status.ready_to_travel,
    ];
    bits.iter().rev().fold(0, |word, &bit| word << 1 | u16::from(bit))
}

/// Mask and value of a pattern such as `0x1x 1x11 x01x 0011`.
fn pattern(text: &str) -> (u16, u16) {
    text.chars()
        .filter(|c| *c != ' ')
        .fold((0, 0), |(mask, value), c| (mask << 1 | u16::from(c != 'x'), value << 1 | u16::from(c == '1')))
}

/// The table at the end of section 8; `s` stands for supply ok, `t` for a shaft that stands (Table 14, bit 13: the
/// charts print what a standing drive shows), `l` for a shaft beyond a limit that was programmed during the job (row 34b),
/// `r` for one that is not and so is ready to travel.
fn printed(status: &Status) -> (u16, u16) {
    let velocity = status.mode == Mode::Velocity;
    let s = if status.supply_ok { "11" } else { "00" };
    let (positioning_text, velocity_text) = match status.state {
        State::Off => ("xxxx xxxx xxxx xxxx", "xxxx xxxx xxxx xxxx"),
        State::NotReady => ("0x1x 1x1x x01x 0000", "00t1 111x x01x 0000"),
        State::ReadyToRun(_) => ("0x1x 1x11 x01x 0011", "00t1 111x x01x 0011"),
        State::Disabling | State::KeyInching(_) | State::KeyInchingEnding => {
            ("0x0x 1x1x x01x 0011", "00t1 111x x01x 0011")
        }
        State::OperationEnabled(_) => ("xx1x 1x11 x011 0111", "x0t1 111x x011 0111"),
        State::TravelActive | State::Pausing { .. } | State::Stopping => {
            ("0l0x 1x1x x011 0111", "impossible")
        }
        State::Paused { .. } => ("rl1x 1x11 x011 0111", "impossible"),
        State::Inching(_) => ("0x0x 1x1x x011 0111", "impossible"),
        State::VelocityTravelling => ("impossible", "00t1 111x x011 0111"),
        State::Fault => ("0x1x 1x1x x01x 10ss", "00t1 111x x01x 10ss"),
        State::TurnOnDisabled => ("0x1x 1x11 x11x 00ss", "00t1 111x x11x 00ss"),
    };
    let text = if velocity { velocity_text } else { positioning_text };
    assert_ne!(text, "impossible", "{status:?}");
    let t = if status.moving { "0" } else { "1" };
    let (l, r) = if status.above_upper_limit || status.below_lower_limit { ("1", "0") } else { ("0", "1") };
    pattern(&text.replace("ss", s).replace('t', t).replace('l', l).replace('r', r))
}

/// The printed pattern holds for this status.
pub(super) fn assert_pattern(status: &Status, stw: u16) {
    let (mask, value) = printed(status);
    let word = zsw(status, stw);
    assert_eq!(word & mask, value, "{word:04x} is no {:?}: {status:?}", status.state);
    let ready = status.state.operation_enabled()
        && word & 0x4000 == 0
        && matches!(status.state, State::OperationEnabled(_))
        && status.output_stage_ok
        && !status.moving
        && (status.mode == Mode::Positioning);
    assert!(!ready || word & 0x8000 != 0, "{word:04x} should be ready-to-travel: {status:?}");
}

#[test]
fn masks_and_values_of_the_patterns_are_those_of_the_reference() {
    for (text, mask, value) in [
        ("0x1x 1x11 x01x 0011", 0xab6f, 0x2b23),
        ("xx1x 1x11 x011 0111", 0x2b7f, 0x2b37),
        ("0x0x 1x1x x011 0111", 0xaa7f, 0x0a37),
        ("101x 1x11 x011 0111", 0xeb7f, 0xab37),
        ("000x 1x1x x011 0111", 0xea7f, 0x0a37),
        ("0011 111x x01x 0011", 0xfe6f, 0x3e23),
        ("x011 111x x011 0111", 0x7e7f, 0x3e37),
        ("1011 111x x011 0111", 0xfe7f, 0xbe37),
        ("00x1 111x x011 0111", 0xde7f, 0x1e37),
    ] {
        assert_eq!(pattern(text), (mask, value), "{text}");
    }
}

#[test]
fn typical_words_of_the_positioning_mode() {
    let mut rig = Rig::new(Model::Ag03_1);
    assert_eq!(rig.run(1).zsw(), 0x2b23);
    assert_eq!(rig.stw(0x0002).zsw(), 0x2b33);
    assert_eq!(rig.stw(0x000b).zsw(), 0xab37);
    assert_eq!(rig.stw(0x003b).zsw(), 0xab37);
    assert_eq!(rig.travel(16_000).zsw(), 0x1b37);
    rig.until(State::OperationEnabled(Motor::InControl));
    assert_eq!(rig.zsw(), 0xbf37);
    rig.settings = rig.settings.with_limits(Limits::new(-5, 5));
    assert_eq!(rig.run(1).zsw(), 0x7f37);
}

#[test]
fn typical_words_of_the_velocity_mode() {
    let mut rig = Rig::with(Model::Ag03_1, defaults().with_mode(Mode::Velocity));
    assert_eq!(rig.run(1).zsw(), 0x3f23);
    assert_eq!(rig.stw(0x0002).zsw(), 0x3f33);
    assert_eq!(rig.stw(0x000b).zsw(), 0xbf37);
    rig.setpoint = 72;
    assert_eq!(rig.stw(0x004b).zsw(), 0x1e37);
    assert_eq!(rig.run(1000).zsw(), 0x1f37);
    assert_eq!(rig.status().velocity, 72);
}

/// One rig in each state, both modes, both models.
pub(super) fn in_every_state() -> Vec<Rig> {
    let mut rigs = Vec::new();
    let mut keep = |rig: &Rig| rigs.push(rig.clone());
    for mode in [Mode::Positioning, Mode::Velocity] {
        for model in [Model::Ag03, Model::Ag03_1] {
            let mut rig = Rig::with(model, defaults().with_mode(mode));
            keep(&rig);
            keep(rig.clone().output_stage(false));
            keep(rig.clone().inputs(|inputs| inputs.control_supply = 0.0));
            keep(rig.stw(0x003b));
            keep(rig.clone().output_stage(false));
            keep(rig.clone().stw(0x0033));
            rig.setpoint = 50_000;
            keep(rig.stw(0x007b).run(300));
            keep(rig.clone().output_stage(false));
            keep(rig.clone().stw(0x0000));
            keep(rig.clone().stw(0x0073));
            keep(rig.clone().causes([Fault::F]));
            keep(rig.clone().causes([Fault::F]).causes([]).stw(0x00fb));
            if mode == Mode::Positioning {
                keep(rig.clone().stw(0x005b));
                keep(rig.clone().stw(0x005b).run(1000));
                keep(rig.clone().stw(0x006b));
                let mut tripping = rig.clone();
                tripping.settings = tripping.settings.with_torque_deactivation(Some(100));
                tripping
                    .inputs(|inputs| inputs.friction_torque = 4.1)
                    .inputs(|inputs| inputs.friction_torque = 0.0);
                keep(&tripping);
                keep(tripping.run(500));
                let mut inching = Rig::with(model, defaults());
                inching.stw(0x000b);
                keep(inching.clone().stw(0x010b).run(300));
                keep(inching.clone().stw(0x010b).run(300).stw(0x000b));
                keep(inching.clone().stw(0x020b).run(300));
                keep(inching.clone().stw(0x820b).run(300));
                let mut key = Rig::with(model, defaults());
                key.connected = false;
                key.run(1);
                keep(key.inputs(|inputs| inputs.key_clockwise = true).run(300));
                keep(key.inputs(|inputs| inputs.key_clockwise = false));
            } else {
                keep(rig.stw(0x003b));
            }
        }
    }
    rigs
}

#[test]
fn every_state_is_among_those_tested_with_every_control_word() {
    let states: Vec<_> = in_every_state().iter().map(Rig::state).collect();
    for state in [
        State::Off,
        State::NotReady,
        State::ReadyToRun(Motor::Released),
        State::ReadyToRun(Motor::InControl),
        State::OperationEnabled(Motor::InControl),
        State::OperationEnabled(Motor::Released),
        State::Disabling,
        State::TravelActive,
        State::Pausing { torque_tripped: false },
        State::Pausing { torque_tripped: true },
        State::Paused { torque_tripped: false },
        State::Paused { torque_tripped: true },
        State::Stopping,
        State::Inching(Inching::One),
        State::Inching(Inching::Two(Direction::Positive)),
        State::Inching(Inching::Two(Direction::Negative)),
        State::Inching(Inching::Ending),
        State::VelocityTravelling,
        State::KeyInching(Key::Clockwise),
        State::KeyInchingEnding,
        State::Fault,
        State::TurnOnDisabled,
    ] {
        assert!(states.contains(&state), "{state:?}");
    }
}

/// What holds after each step, whatever was asked.
pub(super) fn assert_invariants(before: &Status, after: &Status, stw: u16) {
    assert_pattern(after, stw);
    if after.jobs != before.jobs && after.state != State::Off {
        let powered_on = before.state == State::Off;
        let started = after.state == State::TravelActive || matches!(after.state, State::OperationEnabled(_));
        assert!(powered_on || started && stw & 0x003b == 0x003b, "acknowledged without a job: {after:?}");
    }
    let commanded = after.positioning_active || after.state == State::VelocityTravelling;
    if commanded {
        assert!(after.output_stage_ok && after.supply_ok && after.fault.is_none());
        assert_eq!(after.motor, Motor::InControl);
    }
    if after.ready_to_travel {
        assert!(after.start_conditions_met && after.operation_enabled && !after.positioning_active);
    }
    // Without torque the shaft only runs out.
    if after.motor != Motor::InControl {
        assert!(after.velocity.abs() <= before.velocity.abs(), "{before:?} {after:?}");
    }
    assert_eq!(after.fault.is_some(), after.state == State::Fault);
}

/// All 65536 control words. Those that differ only in bits 2 and 10 to 14 make the same [`Command`] (`device::words`
/// has the test), so one of them is enough; with `PROFIDRIVE_LONG` set all are tried.
#[test]
fn all_control_words_in_every_state_keep_the_printed_patterns() {
    let long = std::env::var_os("PROFIDRIVE_LONG").is_some();
    for rig in in_every_state() {
        assert_pattern(&rig.status(), rig.before);
        for stw in (0..=u16::MAX).filter(|stw| long || stw & 0x7c04 == 0) {
            for setpoint in [-20_000, 1_000_001] {
                let mut drive = rig.drive.clone();
                let mut last = rig.before;
                for _ in 0..3 {
                    let before = drive.status();
                    drive.step(MILLISECOND, &command(last, Some(stw), setpoint), &rig.settings);
                    last = stw;
                    assert_invariants(&before, &drive.status(), stw);
                }
            }
        }
    }
}
