//! What control words are refused.

use profidrive::devices::ag03::drive::Inputs;
use profidrive::devices::ag03::param::Value;

use super::row;
use crate::drive_log::{CYCLE, Told};
use crate::sentences::compare;

/// What the drive says to one control word after others.
fn refused(before: &[(u16, i32)], stw: u16, setpoint: i32) -> Vec<String> {
    let mut told = Told::exchanging();
    told.say(0, 0, CYCLE);
    for (stw, setpoint) in before {
        told.say(*stw, *setpoint, CYCLE);
    }
    told.line.events.clear();
    told.say(stw, setpoint, CYCLE);
    told.texts()
}

/// As [`refused`], of an enabled drive prepared by `prepare`.
fn prepared(prepare: fn(&mut Told), stw: u16, setpoint: i32) -> Vec<String> {
    let mut told = Told::enabled();
    prepare(&mut told);
    told.line.events.clear();
    told.say(stw, setpoint, CYCLE);
    told.texts()
}

fn limits(told: &mut Told, limit_1: i32, limit_2: i32) {
    told.write(1016, Value::Double(limit_1.cast_unsigned()));
    told.write(1017, Value::Double(limit_2.cast_unsigned()));
    told.say(0x003B, 0, CYCLE);
}

fn supply(told: &mut Told, volts: f64) {
    told.inputs(Inputs { output_supply: volts, ..Inputs::default() });
    told.say(0x0000, 0, CYCLE);
}

#[test]
fn the_control_word() {
    compare(
        "Control word",
        vec![
            row("C-01", "STW 0008", || refused(&[], 0x0008, 0)),
            row("C-02", "STW 000A", || refused(&[], 0x000A, 0)),
            row("C-03", "a start with STW 0040", || refused(&[], 0x0040, 1600)),
            row("C-04", "a start with STW 004B", || refused(&[(0x000B, 0)], 0x004B, 1600)),
            row("C-05", "a start with STW 005B, intermediate stop", || refused(&[(0x003B, 0)], 0x005B, 1600)),
            row("C-06", "a start in the same word as the enable", || refused(&[], 0x007B, 1600)),
            row("C-07", "a start above the upper limit", || refused(&[(0x003B, 0)], 0x007B, 1_200_000)),
            row("C-08", "a start below the lower limit", || refused(&[(0x003B, 0)], 0x007B, -1_200_000)),
            row("C-09", "a start while a travel job is active", || {
                refused(&[(0x003B, 0), (0x007B, 16_000)], 0x003B, 3200)
            }),
            row("C-10", "a start while a travel job is paused", || {
                refused(&[(0x003B, 0), (0x007B, 16_000), (0x005B, 16_000)], 0x001B, 3200)
            }),
            row("C-11", "a start with the actual position above the upper limit", || {
                prepared(|told| limits(told, -100, -1000), 0x007B, -500)
            }),
            row("C-12", "a start with the actual position below the lower limit", || {
                prepared(|told| limits(told, 1000, 100), 0x007B, 500)
            }),
            row("C-13", "a start whose loop point is beyond the lower limit", || {
                let loop_plus = |told: &mut Told| {
                    told.write(1014, Value::Word(1));
                    limits(told, 100_000, -100);
                };
                prepared(loop_plus, 0x007B, -50)
            }),
            row("C-14", "inching 1 without enable", || refused(&[], 0x0100, 0)),
            row("C-15", "inching 2 without enable", || refused(&[], 0x0200, 0)),
            row("C-16", "inching 1 and 2 together", || refused(&[(0x003B, 0)], 0x033B, 0)),
            row("C-17", "inching 2 in velocity mode", || {
                prepared(|told| told.write(930, Value::Word(1)), 0x023B, 0)
            }),
            row("C-18", "inching 2 outward beyond a limit", || {
                prepared(|told| limits(told, -100, -1000), 0x023B, 0)
            }),
            row("C-19", "inching 2 during a travel job", || {
                refused(&[(0x003B, 0), (0x007B, 16_000)], 0x027B, 16_000)
            }),
            row("C-20", "enable without supply of the output stage (AG03/1)", || {
                prepared(|told| supply(told, 0.0), 0x003B, 0)
            }),
            row("C-21", "velocity mode: the setpoint is released without enable", || {
                let mut told = Told::exchanging();
                told.write(930, Value::Word(1));
                told.say(0, 0, CYCLE);
                told.line.events.clear();
                told.say(0x0040, 30, CYCLE);
                told.texts()
            }),
            row("C-22", "velocity mode: setpoint 170 rpm with gear 48:1", || {
                let velocity = |told: &mut Told| {
                    told.write(930, Value::Word(1));
                    told.say(0x000B, 0, CYCLE);
                };
                prepared(velocity, 0x004B, 170)
            }),
            row("C-23", "the start bit is 1 before the enable", || refused(&[(0x0070, 1600)], 0x007B, 1600)),
            row("C-24", "OFF1 and OFF2 during a travel job", || {
                refused(&[(0x003B, 0), (0x007B, 16_000)], 0x0078, 16_000)
            }),
            row("C-25", "disable operation during a travel job", || {
                refused(&[(0x003B, 0), (0x007B, 16_000)], 0x0073, 16_000)
            }),
            row("C-26", "stop during a travel job", || {
                refused(&[(0x003B, 0), (0x007B, 16_000)], 0x006B, 16_000)
            }),
            row("C-27", "switched off and on during a travel job", || {
                let mut told = Told::enabled();
                told.say(0x007B, 16_000, CYCLE);
                told.line.events.clear();
                told.line.device.power_off(told.line.now);
                told.line.wait(CYCLE);
                told.line.device.power_on(told.line.now);
                told.line.wait(CYCLE);
                told.texts()
            }),
            row("C-28", "limits exchanged while operation is enabled, then a start", || {
                prepared(|told| limits(told, -5000, 5000), 0x007B, 1600)
            }),
            row("C-29", "STW 003B with its octets exchanged", || refused(&[], 0x3B00, 0)),
        ],
    );
}
