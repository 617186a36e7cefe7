//! Both values of each quirk of the drive.

use super::*;

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
