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

/// Executes a mode for so long.
fn execute(line: &mut Line, block: &mut PositionBlock, mode: ModePos, position: i32, millis: u32) {
    (block.mode_pos, block.position, block.execute_mode) = (mode, position, false);
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
    assert!(block.act_velocity > 0.019 && block.act_position > 25_000, "{block:?}");
    block.cancel_traversing = false;
    line.run(500, |telegram, inputs| block.call(telegram, inputs));
    assert!(block.act_velocity.abs() < 1e-4);
    (block.positive, block.cancel_traversing) = (false, true);
    execute(&mut line, &mut block, ModePos::SetReference, 0, 20);
    assert!(block.axis_ref && block.act_position == 0, "{block:?}");
    block.jog_1 = true;
    execute(&mut line, &mut block, ModePos::Jog, 0, 1000);
    assert!(block.act_velocity < -0.009, "{block:?}");
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
