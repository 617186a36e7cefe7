//! Both values of each quirk of the drive.

use super::*;

const ENABLED: State = State::OperationEnabled(Motor::InControl);

fn quirky(quirks: Quirks) -> Rig {
    quirky_with(quirks, defaults())
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
fn quirk_c11_velocity_is_ready_when_the_shaft_stands_or_at_once() {
    let [proposed, other] = both(|quirks| quirks.ready_while_running_down = true);
    for (quirks, ready) in [(proposed, false), (other, true)] {
        let mut rig = quirky_with(quirks, defaults().with_mode(Mode::Velocity));
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
        let mut rig = quirky_with(quirks, defaults().with_offset_inch_2(47));
        rig.stw(0x000b).stw(0x020b).run(500);
        assert_eq!(rig.status().velocity, speed, "30 * 47 % = 14.1");
    }
}

#[test]
fn quirk_c13_the_torque_deactivation_keeps_or_discards_the_job() {
    let [proposed, other] = both(|quirks| quirks.torque_discards_job = true);
    for (quirks, stopped) in [(proposed, State::Paused { torque_tripped: true }), (other, ENABLED)] {
        let mut rig = travelling(quirks);
        rig.settings = rig.settings.with_torque_deactivation(Some(50));
        rig.inputs(|inputs| inputs.friction_torque = 3.0).run(1);
        rig.inputs(|inputs| inputs.friction_torque = 0.0).run(1000);
        assert_eq!((rig.state(), rig.status().torque_tripped), (stopped, true));
        rig.travel(0);
        assert_eq!((rig.state(), rig.status().torque_tripped), (State::TravelActive, false));
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
            let settings = defaults().with_inpos(inpos).with_pos_type(PosType::LoopPlus);
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
                let mut rig = quirky_with(quirks, defaults().with_limits(limits).with_sense(sense));
                rig.stw(0x000b).stw(stw).until(ENABLED);
                let past = rig.position() * sign - 500;
                assert_eq!((past > 0, past <= 51), (beyond, true), "{stw:04x}: {past}");
                assert!(beyond || past == 0);
                assert_eq!(rig.status().ready_to_travel, !beyond);
            }
        }
        let mut rig = quirky_with(quirks, defaults().with_limits(Limits::new(500, -500)));
        rig.connected = false;
        rig.run(1).inputs(|inputs| inputs.key_counter_clockwise = true).run(3000);
        assert_eq!(rig.position() > 500, beyond);
    }
}
