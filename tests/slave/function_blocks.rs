//! The function blocks of `examples/function_blocks.rs` run a drive of PROFIdrive 4.

#[path = "../../examples/function_blocks.rs"]
mod example;

use example::{Line, ModePos, PositionBlock, SpeedBlock};
use profidrive::face::Surroundings as _;
use profidrive::time::Instant;

#[test]
fn the_speed_block_switches_on_turns_and_acknowledges() {
    let (mut line, mut block) = (Line::with(1), SpeedBlock::NEW);
    line.run(20, |telegram, inputs| block.call(telegram, inputs));
    assert!(!block.axis_enabled && !block.lockout && !block.error);
    (block.enable_axis, block.speed_sp) = (true, -750.0);
    line.run(600, |telegram, inputs| block.call(telegram, inputs));
    assert!(block.axis_enabled && (block.act_velocity + 750.0).abs() < 1.0, "{block:?}");
    line.drive.provoke(Instant::from_millis(700), "overload").unwrap();
    line.run(20, |telegram, inputs| block.call(telegram, inputs));
    assert!(block.error && block.lockout && !block.axis_enabled);
    (block.ack_error, block.enable_axis) = (true, false);
    line.run(20, |telegram, inputs| block.call(telegram, inputs));
    assert!(!block.error && !block.lockout);
    (block.ack_error, block.enable_axis, block.speed_sp) = (false, true, 0.0);
    line.run(600, |telegram, inputs| block.call(telegram, inputs));
    assert!(block.axis_enabled && block.act_velocity.abs() < 1.0);
}

/// Parts of the reference speed.
fn velocity(block: &PositionBlock) -> f64 {
    f64::from(block.act_velocity) / 1_073_741_824.0
}

/// Executes a mode for so long.
fn execute(line: &mut Line, block: &mut PositionBlock, mode: ModePos, position: i32, millis: u32) {
    (block.mode_pos, block.position, block.execute_mode) = (mode as u16, position, false);
    line.run(20, |telegram, inputs| block.call(telegram, inputs));
    block.execute_mode = true;
    line.run(millis, |telegram, inputs| block.call(telegram, inputs));
}

#[test]
fn the_position_block_does_each_of_its_modes() {
    let (mut line, mut block) = (Line::with(111), PositionBlock::NEW);
    line.run(20, |telegram, inputs| block.call(telegram, inputs));
    block.enable_axis = true;
    execute(&mut line, &mut block, ModePos::Home, 0, 20_000);
    assert!(block.axis_enabled && block.axis_ref && block.act_position == 0, "{block:?}");
    execute(&mut line, &mut block, ModePos::Absolute, 25_000, 1500);
    assert!(block.axis_pos_ok && block.act_position == 25_000, "{block:?}");
    execute(&mut line, &mut block, ModePos::Relative, -5_000, 1500);
    assert!(block.axis_pos_ok && block.act_position == 20_000, "{block:?}");
    (block.positive, block.velocity) = (true, 600);
    execute(&mut line, &mut block, ModePos::SetUp, 0, 1000);
    assert!(velocity(&block) > 0.019 && block.act_position > 25_000, "{block:?}");
    block.cancel_traversing = false;
    line.run(500, |telegram, inputs| block.call(telegram, inputs));
    assert!(velocity(&block).abs() < 1e-4);
    (block.positive, block.cancel_traversing) = (false, true);
    execute(&mut line, &mut block, ModePos::SetReference, 0, 20);
    assert!(block.axis_ref && block.act_position == 0, "{block:?}");
    block.jog_1 = true;
    execute(&mut line, &mut block, ModePos::Jog, 0, 1000);
    assert!(velocity(&block) < -0.009, "{block:?}");
    block.jog_1 = false;
    line.run(500, |telegram, inputs| block.call(telegram, inputs));
    let begin = block.act_position;
    block.jog_2 = true;
    execute(&mut line, &mut block, ModePos::JogIncremental, 0, 1500);
    assert!((block.act_position - begin - 1000).abs() <= 1, "{block:?}");
    let there = block.act_position;
    block.jog_2 = false;
    // There is no traversing block: nothing moves.
    execute(&mut line, &mut block, ModePos::Block, 3, 500);
    assert_eq!((block.act_position, block.axis_error), (there, false), "{block:?}");
    // Software limits.
    block.config_epos = 0b111;
    line.drive.provoke(Instant::from_millis(60_000), "following-error").unwrap();
    line.run(400, |telegram, inputs| block.call(telegram, inputs));
    assert!(block.axis_error && block.act_fault == 6 && !block.axis_enabled, "{block:?}");
}

#[test]
fn each_bit_of_config_axis_is_one_of_stw1() {
    let (line, mut block) = (Line::with(1), SpeedBlock::NEW);
    let places = [1, 2, 3, 4, 5, 6, 12, 11, 13, 14, 8, 9, 15];
    for (at, place) in places.iter().enumerate() {
        block.config_axis = 1 << at;
        assert_eq!(block.call(line.telegram, &[0; 4])[0], 0x0400 | 1 << place, "bit {at}");
    }
    // Without data of the drive the block says so.
    block.call(line.telegram, &[]);
    assert_eq!((block.error, block.status, block.diag_id), (true, 0x8600, 0x80A0));
    block.call(line.telegram, &[0, 0x40, 0, 0]);
    assert_eq!((block.error, block.status, block.lockout), (true, 0x8402, true));
    block.call(line.telegram, &[0, 0x48, 0, 0]);
    assert_eq!((block.status, block.diag_id), (0x8401, 0));
    block.call(line.telegram, &[0, 0x31, 0, 0]);
    assert_eq!((block.error, block.status), (false, 0x7002));
}

#[test]
fn each_bit_of_config_epos_is_one_of_the_first_four_words() {
    let (line, mut block) = (Line::with(111), PositionBlock::NEW);
    let inputs = [0; 24];
    block.config_epos = 0;
    let none = block.call(line.telegram, &inputs);
    let mut seen = Vec::new();
    for at in 0..32 {
        block.config_epos = 1 << at;
        let words = block.call(line.telegram, &inputs);
        let changed: Vec<_> = (0..12).filter(|word| words[*word] != none[*word]).collect();
        assert!(changed.len() <= 1, "bit {at}");
        seen.extend(changed.first().map(|word| (at, *word, (words[*word] ^ none[*word]).trailing_zeros())));
    }
    let named = [
        (0, 0, 1),
        (1, 0, 2),
        (2, 2, 14),
        (3, 2, 15),
        (4, 2, 11),
        (5, 2, 10),
        (6, 2, 2),
        (7, 0, 13),
        (8, 1, 12),
        (9, 3, 0),
        (14, 3, 7),
        (30, 3, 8),
    ];
    assert!(named.iter().all(|place| seen.contains(place)), "{seen:?}");
    assert_eq!(seen.len(), 31);
}

#[test]
fn the_position_block_says_what_is_wrong_and_what_runs() {
    let (mut line, mut block) = (Line::with(111), PositionBlock::NEW);
    assert_eq!((block.call(line.telegram, &[]).len(), block.status, block.diag_id), (12, 0x8600, 0x80A0));
    line.run(20, |telegram, inputs| block.call(telegram, inputs));
    assert_eq!((block.error, block.status), (false, 0x7002), "{block:?}");
    block.enable_axis = true;
    execute(&mut line, &mut block, ModePos::SetReference, 0, 100);
    assert!(block.axis_ref && block.axis_sp_fixed && block.act_mode == 0, "{block:?}");
    execute(&mut line, &mut block, ModePos::Absolute, 30_000, 100);
    assert!(!block.axis_sp_fixed && block.act_mode == 2 && block.epos_zsw1 & 0x8000 != 0, "{block:?}");
    line.run(2000, |telegram, inputs| block.call(telegram, inputs));
    assert!(block.axis_pos_ok && block.axis_sp_fixed, "{block:?}");
    // Each wrong input, and the task is not begun.
    let (mut wrong, there) = (block.clone(), block.act_position);
    for (mode, position, over, status) in
        [(9, 0, 100, 0x8202), (0, 0, 100, 0x8202), (2, 0, 200, 0x8203), (6, 64, 100, 0x8204)]
    {
        (wrong.mode_pos, wrong.position, wrong.over_v, wrong.execute_mode) = (mode, position, over, false);
        line.run(20, |telegram, inputs| wrong.call(telegram, inputs));
        wrong.execute_mode = true;
        line.run(100, |telegram, inputs| wrong.call(telegram, inputs));
        assert_eq!((wrong.error, wrong.status, wrong.act_position), (true, status, there), "{mode}");
    }
    // Intermediate stop, and on.
    execute(&mut line, &mut block, ModePos::Relative, 60_000, 300);
    block.intermediate_stop = false;
    line.run(500, |telegram, inputs| block.call(telegram, inputs));
    assert!(velocity(&block).abs() < 1e-4 && !block.axis_pos_ok && block.act_mode == 1, "{block:?}");
    block.intermediate_stop = true;
    line.run(3000, |telegram, inputs| block.call(telegram, inputs));
    assert!(block.axis_pos_ok && (block.act_position - there - 60_000).abs() <= 1, "{block:?}");
    // A new target is taken over at once.
    block.config_epos = 0x103;
    execute(&mut line, &mut block, ModePos::Absolute, 50_000, 100);
    block.position = 10_000;
    line.run(4000, |telegram, inputs| block.call(telegram, inputs));
    assert!((block.act_position - 10_000).abs() <= 1, "{block:?}");
}

#[test]
fn flying_referencing_runs_beside_a_mode_and_takes_the_position_of_the_probe() {
    let (mut line, mut block) = (Line::with(111), PositionBlock::NEW);
    line.run(20, |telegram, inputs| block.call(telegram, inputs));
    (block.enable_axis, block.fly_ref, block.positive) = (true, true, true);
    execute(&mut line, &mut block, ModePos::SetUp, 0, 1500);
    assert!(!block.axis_ref && block.epos_zsw1 & 0x1000 != 0 && block.status == 0x7002, "{block:?}");
    let before = block.act_position;
    line.close_probe();
    line.run(10, |telegram, inputs| block.call(telegram, inputs));
    assert!(block.axis_ref && block.act_position < before, "{before} {block:?}");
    // Not in the modes that reference themselves.
    (block.positive, block.cancel_traversing) = (false, false);
    line.run(500, |telegram, inputs| block.call(telegram, inputs));
    block.cancel_traversing = true;
    execute(&mut line, &mut block, ModePos::SetReference, 0, 100);
    assert!(block.epos_zsw1 & 0x1000 == 0 && block.act_position == 0, "{block:?}");
}
