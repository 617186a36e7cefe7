//! Hints of a drive.

use std::time::Duration;

use profidrive::devices::ag03::param::Value;
use profidrive::devices::ag03::profibus::Config;

use super::row;
use crate::drive_line::IDENT;
use crate::drive_log::{CYCLE, Told, address};
use crate::sentences::compare;

#[test]
fn hints() {
    compare(
        "Hints of a drive",
        vec![
            row("H-01", "a drive at address 126", || {
                let mut told = Told::with(|config| Config { switches: address(126).into(), ..config });
                told.line.wait(CYCLE);
                told.hints()
            }),
            row("H-02", "a watchdog of 10 ms, and a master that asks every 25 ms", || {
                let mut told = Told::new();
                for _ in 0..3 {
                    told.line.start_up_with(&[0x88, 1, 1, 11, IDENT[0], IDENT[1], 0]);
                    told.line.wait(Duration::from_millis(25));
                }
                told.hints()
            }),
            row("H-03", "equal limits", || {
                let mut told = Told::exchanging();
                told.write(1016, Value::Double(500));
                told.write(1017, Value::Double(500));
                told.say(0, 0, CYCLE);
                told.say(0x003B, 0, CYCLE);
                told.hints()
            }),
            row("H-04", "limit 1 below limit 2", || {
                let mut told = Told::exchanging();
                told.write(1016, Value::Double(0));
                told.write(1017, Value::Double(500));
                told.say(0, 0, CYCLE);
                told.say(0x003B, 0, CYCLE);
                told.hints()
            }),
        ],
    );
}
