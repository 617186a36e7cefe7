//! Both values of each quirk of the drive.

use super::*;

const READY: State = State::ReadyToRun(Motor::Released);
const ENABLED: State = State::OperationEnabled(Motor::InControl);

fn quirky(quirks: Quirks) -> Rig {
    quirky_with(quirks, DEFAULTS)
}

fn quirky_with(quirks: Quirks, settings: Settings) -> Rig {
    let config = Config { quirks, ..Config::default() };
    Rig::made(Model::Ag03_1, Gear::Ratio48, settings, config)
}

fn travelling(quirks: Quirks) -> Rig {
    let mut rig = quirky(quirks);
    rig.stw(0x003b).travel(16_000).run(499);
    rig
}

/// With and without the quirk that `set` sets.
fn both(set: impl FnOnce(&mut Quirks)) -> [Quirks; 2] {
    let mut quirks = Quirks::default();
    set(&mut quirks);
    [Quirks::default(), quirks]
}

#[test]
fn quirk_c05_a_paused_job_is_ready_or_still_active() {
    let [proposed, other] = both(|quirks| quirks.paused_is_active = true);
    for (quirks, zsw, active) in [(proposed, 0xa000, false), (other, 0x2000, true)] {
        let mut rig = travelling(quirks);
        rig.stw(0x005b).run(1000);
        assert_eq!((rig.zsw() & 0xe000, rig.status().positioning_active), (zsw, active));
        assert_eq!(rig.stw(0x007b).state(), State::TravelActive);
    }
}

#[test]
fn quirk_c06_turn_on_disabled_is_left_by_the_level_or_by_the_edge_of_off1() {
    let [proposed, other] = both(|quirks| quirks.off1_needs_edge = true);
    for (quirks, next) in [(proposed, READY), (other, State::TurnOnDisabled)] {
        let mut rig = quirky(quirks);
        rig.causes([Fault::F]).causes([]).stw(0x0080).stw(0x0000);
        assert_eq!(rig.state(), next, "level");
        assert_eq!(rig.stw(0x0001).stw(0x0000).state(), READY, "edge");
    }
}

#[test]
fn quirk_c07_the_acknowledge_bit_toggles_or_takes_the_level_of_start() {
    let [proposed, other] = both(|quirks| quirks.acknowledge_mirrors_start = true);
    for (quirks, acknowledge) in [(proposed, true), (other, false)] {
        let mut rig = quirky(quirks);
        // The rising edge is refused, the falling one accepted.
        rig.stw(0x003b).travel(2_000_000).travel(100);
        assert_eq!((rig.state(), rig.status().job_acknowledge), (State::TravelActive, acknowledge));
    }
}

#[test]
fn quirk_c09_a_drive_in_fault_is_ready_to_turn_on_or_not() {
    let [proposed, other] = both(|quirks| quirks.not_ready_in_fault = true);
    for (quirks, bits) in [(proposed, 3), (other, 0)] {
        let mut rig = quirky(quirks);
        rig.causes([Fault::F]);
        assert_eq!(rig.zsw() & 0x000b, 0x0008 | bits);
        rig.causes([]).stw(0x0080);
        assert_eq!(rig.zsw() & 0x0043, 0x0040 | bits);
        assert_eq!(rig.stw(0x0000).zsw() & 3, 3);
    }
}

#[test]
fn quirk_c11_velocity_is_ready_when_the_shaft_stands_or_at_once() {
    let [proposed, other] = both(|quirks| quirks.ready_while_running_down = true);
    for (quirks, ready) in [(proposed, false), (other, true)] {
        let mut rig = quirky_with(quirks, Settings { mode: Mode::Velocity, ..DEFAULTS });
        rig.setpoint = 60;
        rig.stw(0x004b).run(1000).stw(0x000b);
        assert_eq!((rig.status().moving, rig.status().ready_to_travel), (true, ready));
        assert!(rig.run(1000).status().ready_to_travel);
    }
}

#[test]
fn quirk_c12_the_speed_of_inching_2_is_rounded_or_rounded_up() {
    let [proposed, other] = both(|quirks| quirks.inching_rounds_up = true);
    for (quirks, speed) in [(proposed, 14), (other, 15)] {
        let mut rig = quirky_with(quirks, Settings { offset_inch_2: 47, ..DEFAULTS });
        rig.stw(0x000b).stw(0x020b).run(500);
        assert_eq!(rig.status().velocity, speed, "30 * 47 % = 14.1");
    }
}

#[test]
fn quirk_c13_the_torque_deactivation_keeps_or_discards_the_job() {
    let [proposed, other] = both(|quirks| quirks.torque_discards_job = true);
    for (quirks, stopped) in [(proposed, State::Paused { torque_tripped: true }), (other, ENABLED)] {
        let mut rig = travelling(quirks);
        rig.settings.torque_deactivation = Some(50);
        rig.inputs(|inputs| inputs.friction_torque = 3.0).run(1);
        rig.inputs(|inputs| inputs.friction_torque = 0.0).run(1000);
        assert_eq!((rig.state(), rig.status().torque_tripped), (stopped, true));
        rig.travel(0);
        assert_eq!((rig.state(), rig.status().torque_tripped), (State::TravelActive, false));
    }
}

#[test]
fn quirk_c18_the_fault_buffer_begins_with_the_newest_or_with_the_oldest() {
    let [proposed, other] = both(|quirks| quirks.oldest_fault_first = true);
    for (quirks, codes) in [(proposed, *b"GF"), (other, *b"FG")] {
        let mut rig = quirky(quirks);
        rig.causes([Fault::F]).causes([Fault::F, Fault::G]);
        assert_eq!(rig.drive.fault_codes()[..2], codes);
    }
}

#[test]
fn quirk_c23_off1_releases_at_once_or_after_braking() {
    let [proposed, other] = both(|quirks| quirks.off1_brakes = true);
    for (quirks, next) in [(proposed, READY), (other, State::Disabling)] {
        let mut rig = travelling(quirks);
        assert_eq!(rig.stw(0x007a).state(), next);
        rig.run(1000);
        assert_eq!((rig.state(), rig.status().moving), (READY, false));
        let mut rig = travelling(quirks);
        assert_eq!(rig.stw(0x0079).state(), READY, "OFF2 releases in any case");
    }
}

#[test]
fn quirk_c24_all_zero_outputs_let_the_shaft_run_out_or_brake_it() {
    let [proposed, other] = both(|quirks| quirks.all_zero_brakes = true);
    for (quirks, next, time) in [(proposed, READY, 499), (other, State::Disabling, 124)] {
        let mut rig = travelling(quirks);
        assert_eq!(rig.stw(0x0000).state(), next);
        let mut cycles = 0;
        while rig.status().moving {
            rig.run(1);
            cycles += 1;
        }
        assert_eq!(cycles, time);
        assert_eq!(rig.run(2).state(), READY);
    }
}

#[test]
fn quirk_c32_both_edges_of_start_start_or_only_the_rising_one() {
    let [proposed, other] = both(|quirks| quirks.start_needs_rising_edge = true);
    for (quirks, next) in [(proposed, State::TravelActive), (other, ENABLED)] {
        let mut rig = quirky(quirks);
        rig.stw(0x003b).travel(100);
        rig.until(ENABLED);
        assert_eq!(rig.travel(0).state(), next);
        assert_eq!(rig.drive.take_refusal(), None, "a falling edge is no request then");
    }
}

#[test]
fn quirk_c35_target_reached_waits_for_the_end_of_the_job_or_is_live() {
    let [proposed, other] = both(|quirks| quirks.target_reached_live = true);
    for (quirks, reached) in [(proposed, false), (other, true)] {
        let mut rig = quirky(quirks);
        rig.stw(0x003b).travel(5);
        assert_eq!((rig.state(), rig.status().target_reached), (State::TravelActive, reached));
        rig.until(ENABLED);
        assert!(rig.status().target_reached);
    }
}

#[test]
fn quirk_c36_the_first_telegram_may_enable_or_off1_must_be_seen() {
    let [proposed, other] = both(|quirks| quirks.off1_must_be_seen = true);
    for (quirks, next) in [(proposed, ENABLED), (other, READY)] {
        let mut rig = quirky(quirks);
        assert_eq!(rig.stw(0x000b).state(), next);
        if next == READY {
            assert_eq!(
                rig.refusal_text(),
                "enabling operation refused: OFF1 must be given once in Data_Exchange first"
            );
        }
        assert_eq!(rig.stw(0x000a).stw(0x000b).state(), ENABLED);
        rig.connected = false;
        rig.run(1);
        rig.connected = true;
        assert_eq!(rig.run(1).state(), next, "each Data_Exchange anew");
    }
}

#[test]
fn quirk_c40_a_change_of_direction_reverses_inching_2_ends_it_or_does_nothing() {
    use DirectionChange::{Ends, IsIgnored, Reverses};
    for (change, later) in [(Reverses, -30), (Ends, 0), (IsIgnored, 30)] {
        let [_, quirks] = both(|quirks| quirks.inch_2_direction_change = change);
        let mut rig = quirky(quirks);
        rig.stw(0x000b).stw(0x020b).run(1000).stw(0x820b).run(1000);
        assert_eq!(rig.status().velocity, later, "{change:?}");
        rig.stw(0x000b).until(ENABLED);
        assert_eq!(rig.stw(0x820b).run(1000).status().velocity, -30, "a new edge");
    }
}

#[test]
fn quirk_c41_inpos_mode_acts_at_the_end_of_the_travel_or_in_the_window() {
    let [proposed, other] = both(|quirks| quirks.inpos_acts_in_window = true);
    for (quirks, moving) in [(proposed, false), (other, true)] {
        for inpos in [Motor::Shorted, Motor::Released] {
            let settings = Settings { inpos, pos_type: PosType::LoopPlus, ..DEFAULTS };
            let mut rig = quirky_with(quirks, settings);
            rig.stw(0x003b).travel(-1600);
            rig.until(State::OperationEnabled(inpos));
            assert_eq!((rig.status().moving, rig.status().target_reached), (moving, true));
            assert_eq!(rig.status().ready_to_travel, !moving);
            assert!(!rig.status().approach_reversed, "not on the way to the loop point");
            assert!(rig.run(1000).status().ready_to_travel);
        }
        let mut rig = quirky(quirks);
        rig.stw(0x003b).travel(1600).until(ENABLED);
        assert_eq!((rig.position(), rig.status().moving), (1600, false), "in control: to the setpoint");
    }
}

#[test]
fn quirk_c42_inching_brakes_from_the_limit_or_stands_at_it() {
    let [proposed, other] = both(|quirks| quirks.inching_stops_at_limit = true);
    for (quirks, beyond) in [(proposed, true), (other, false)] {
        for (stw, sign) in [(0x010b, 1), (0x020b, 1), (0x820b, -1)] {
            for sense in [SenseOfRotation::I, SenseOfRotation::E] {
                let limits = Limits::new(500, -500);
                let mut rig = quirky_with(quirks, Settings { limits, sense, ..DEFAULTS });
                rig.stw(0x000b).stw(stw).until(ENABLED);
                let past = rig.position() * sign - 500;
                assert_eq!((past > 0, past <= 51), (beyond, true), "{stw:04x}: {past}");
                assert!(beyond || past == 0);
                assert_eq!(rig.status().ready_to_travel, !beyond);
            }
        }
        let mut rig = quirky_with(quirks, Settings { limits: Limits::new(500, -500), ..DEFAULTS });
        rig.connected = false;
        rig.run(1).inputs(|inputs| inputs.key_counter_clockwise = true).run(3000);
        assert_eq!(rig.position() > 500, beyond);
    }
}
