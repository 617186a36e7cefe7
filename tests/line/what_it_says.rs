//! Ways to fail on a line with many stations, and the words that appear: a section of `docs/what-it-says.md`.

use core::time::Duration;

use profidrive::devices::ag03::profibus::{Config, Device};
use profidrive::host::Bus;
use profidrive::profibus::fdl::{Address, FunctionCode, ReplyStatus, Service};
use profidrive::time::Instant;

use crate::hints::Line;
use crate::sentences::{Row, compare};
use crate::telegrams::telegram;

fn row<'a>(id: &'a str, done: &'a str, act: impl FnOnce() -> Vec<String> + 'a) -> Row<'a> {
    (id, done, Box::new(act))
}

fn address(number: u8) -> Address {
    Address::station(number).unwrap()
}

#[test]
fn a_line() {
    compare(
        "Hints of a line",
        vec![
            row("B-01", "the master asks for station 6, the drives are 5, 7, 8 and 9", || {
                let mut line = Line::with(&[5, 7, 8, 9]);
                (0..3).for_each(|_| line.ask(2, 6, Service::SrdHigh, Some(60)));
                line.texts()
            }),
            row("B-02", "only octets that are no telegram: wrong rate, or A and B exchanged", || {
                let mut line = Line::with(&[5]);
                (0..30).for_each(|octet| line.hear_noise(0x80 + octet));
                line.hints()
            }),
            row("B-03", "two masters at the same time", || {
                let mut line = Line::with(&[5]);
                line.ask(2, 5, Service::SrdHigh, Some(60));
                line.ask(3, 5, Service::SrdHigh, Some(60));
                line.texts()
            }),
            row("B-04", "a drive comes on a line where another station has its address", || {
                let mut line = Line::with(&[]);
                let device = Device::new(Config::new(address(5)), Instant::ZERO);
                line.bus.join(line.now, device).unwrap();
                line.hear(&telegram(2, 5, FunctionCode::response(ReplyStatus::DataLow), Some(62), &[0; 6]));
                line.texts()
            }),
            row("B-05", "two drives with one address", || {
                let mut bus = Bus::new();
                let drive = || Device::new(Config::new(address(5)), Instant::ZERO);
                bus.add(drive()).unwrap();
                vec![bus.add(drive()).unwrap_err().to_string()]
            }),
            row("B-06", "the rate is searched for and found, then the line falls silent", || {
                let mut line = Line::with(&[5]);
                line.bus.search_baud(line.now);
                line.ask(2, 5, Service::FdlStatus, None);
                let silent = line.now.saturating_add(Duration::from_secs(60));
                while let Some(due) = line.bus.poll_timeout().filter(|due| *due < silent) {
                    line.bus.handle_timeout(due);
                }
                let mut texts = line.texts();
                texts.truncate(4);
                texts
            }),
            row("B-07", "FDL_Status to station 9 again and again, of a master that passes no token", || {
                let mut line = Line::with(&[5]);
                (0..9).for_each(|_| line.ask(2, 9, Service::FdlStatus, None));
                line.texts()
            }),
            row("B-08", "a master that only reads the diagnosis", || {
                let mut line = Line::with(&[5]);
                (0..50).for_each(|_| line.ask(2, 5, Service::SrdHigh, Some(60)));
                line.texts()
            }),
            row("B-09", "Set_Prm with Lock_Req and Unlock_Req", || {
                let mut line = Line::with(&[5]);
                (0..9).for_each(|_| line.send(2, 5, Some(61), &[0xC0, 0, 0, 11, 0x0A, 0xC5, 0]));
                line.texts()
            }),
            row("B-10", "Sync for group 2, Set_Prm had Group_Ident 1 (group 1)", || {
                let mut line = Line::with(&[5]);
                line.send(2, 5, Some(61), &[0xA0, 0, 0, 11, 0x0A, 0xC5, 1]);
                (0..9).for_each(|_| line.control(2, &[0x20, 2]));
                line.hints()
            }),
            row("B-11", "a Global_Control of one octet", || {
                let mut line = Line::with(&[5]);
                (0..9).for_each(|_| line.control(2, &[0x20]));
                line.texts()
            }),
            row("B-12", "a Global_Control with a reserved bit", || {
                let mut line = Line::with(&[5]);
                (0..9).for_each(|_| line.control(2, &[0x60, 0]));
                line.texts()
            }),
            row("B-13", "a token for a slave", || {
                let mut line = Line::with(&[5]);
                (0..9).for_each(|_| line.hear(&[0xDC, 5, 2]));
                line.texts()
            }),
            row("B-14", "Sync, and Data_Exchange goes on", || held(0x20)),
            row("B-15", "Freeze, and Data_Exchange goes on", || held(0x08)),
            row("B-16", "Sync by master 3, which has parameterised no station", || {
                let mut line = Line::with(&[5]);
                line.send(2, 5, Some(61), &[0xA0, 0, 0, 11, 0x0A, 0xC5, 0]);
                line.now = line.now.saturating_add(Duration::from_secs(2));
                line.texts();
                (0..9).for_each(|_| line.control(3, &[0x20, 0]));
                line.texts()
            }),
            row("B-17", "Set_Prm with SDA instead of SRD", || {
                let mut line = Line::with(&[5]);
                (0..9).for_each(|_| line.ask(2, 5, Service::SdaHigh, Some(61)));
                line.texts()
            }),
            row("B-18", "Modbus RTU on the line", || {
                let mut line = Line::with(&[5]);
                for _ in 0..20 {
                    line.hear(&[1, 3, 0, 0, 0, 0x0A, 0xC5, 0xCD]);
                    line.bus.handle_broken_off(line.now);
                    line.now = line.now.saturating_add(Duration::from_millis(50));
                }
                line.hints()
            }),
            row("B-19", "text on the line, and the rate is searched for", || {
                let mut line = Line::with(&[5]);
                line.bus.search_baud(line.now);
                for _ in 0..220 {
                    line.hear(b"Temperature 21.5 C\r\n");
                    line.bus.handle_broken_off(line.now);
                    line.now = line.now.saturating_add(Duration::from_millis(50));
                }
                line.hints()
            }),
            row("B-20", "MPI: a master asks SAP 1 of others, and no station of ours", || {
                let mut line = Line::with(&[5]);
                (0..30).for_each(|_| line.ask(0, 2, Service::SrdLow, Some(1)));
                line.hints()
            }),
        ],
    );
}

/// A command that holds something, and 6 s of Data_Exchange behind it.
fn held(command: u8) -> Vec<String> {
    let mut line = Line::with(&[5]);
    line.send(2, 5, Some(61), &[0xB0, 0, 0, 11, 0x0A, 0xC5, 0]);
    line.send(2, 5, Some(62), &[0xF3, 0xF2]);
    line.control(2, &[command, 0]);
    (0..600).for_each(|_| line.send(2, 5, None, &[0; 14]));
    line.hints()
}
