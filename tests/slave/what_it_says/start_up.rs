//! Start-up of the slave, and octets on the line.

use std::time::Duration;

use profidrive::profibus::dp::{Description, Fixed, Station};
use profidrive::profibus::fdl::{Framer, Resync};
use profidrive::time::{BaudRate, Instant};

use super::row;
use crate::drive_line::{CFG, IDENT, MASTER, telegram};
use crate::drive_log::{CYCLE, PRM, Told, address};
use crate::sentences::compare;

/// What a drive says to one request of its master.
fn service(dsap: u8, data: &[u8]) -> Vec<String> {
    let mut told = Told::new();
    if dsap == 62 {
        told.line.request(MASTER, Some(61), &PRM);
        told.line.events.clear();
    }
    told.line.request(MASTER, Some(dsap), data);
    told.texts()
}

#[test]
fn start_up() {
    let prm = |change: fn(&mut Vec<u8>)| {
        let mut octets = PRM.to_vec();
        change(&mut octets);
        service(61, &octets)
    };
    compare(
        "Start-up of the slave",
        vec![
            row("S-01", "Set_Prm with ident number 1234", || {
                prm(|prm| prm[4..6].copy_from_slice(&[0x12, 0x34]))
            }),
            row("S-02", "Set_Prm with 5 octets", || prm(|prm| prm.truncate(5))),
            row("S-03", "Set_Prm with a watchdog factor of 0", || prm(|prm| prm[1] = 0)),
            row("S-04", "Set_Prm with a reserved bit in octet 1", || prm(|prm| prm[0] |= 1)),
            row("S-05", "Set_Prm with min T_SDR 5", || prm(|prm| prm[3] = 5)),
            row("S-06", "Set_Prm with one octet of user parameters", || prm(|prm| prm.push(0))),
            row("S-07", "Set_Prm with Lock_Req and Unlock_Req", || {
                let mut told = Told::exchanging();
                told.line.request(MASTER, Some(61), &[0xF8, 10, 1, 11, IDENT[0], IDENT[1], 0]);
                told.texts()
            }),
            row("S-08", "Set_Prm in order", || service(61, &PRM)),
            row("S-09", "Chk_Cfg with 11 21", || service(62, &[0x11, 0x21])),
            row("S-10", "Chk_Cfg with F3 alone", || service(62, &[0xF3])),
            row("S-11", "Chk_Cfg with a third identifier", || service(62, &[0xF3, 0xF2, 0x11])),
            row("S-12", "Chk_Cfg without an identifier", || service(62, &[])),
            row("S-13", "Chk_Cfg whose last identifier is cut off", || service(62, &[0xF3, 0xC0])),
            row("S-14", "Chk_Cfg in order", || service(62, &CFG)),
            row("S-15", "Set_Prm by master 3 while master 2 has the slave locked", || {
                let mut told = Told::exchanging();
                told.line.request(3, Some(61), &PRM);
                told.texts()
            }),
            row("S-16", "Data_Exchange with 10 octets", || {
                let mut told = Told::exchanging();
                told.line.request(MASTER, None, &[0; 10]);
                told.texts()
            }),
            row("S-17", "the master is silent in Data_Exchange, operation enabled", || {
                let mut told = Told::enabled();
                told.line.wait(Duration::from_millis(200));
                told.texts()
            }),
            row("S-18", "Set_Prm with Unlock_Req", || {
                let mut told = Told::exchanging();
                told.line.request(MASTER, Some(61), &[0x40, 0, 0, 0, IDENT[0], IDENT[1], 0]);
                told.texts()
            }),
            row("S-19", "Global_Control with Clear_Data while operation is enabled", || {
                let mut told = Told::enabled();
                told.line.global_control(0x02, 0);
                told.line.wait(CYCLE);
                told.texts()
            }),
            row("S-20", "Global_Control with Sync and Freeze", || {
                let mut told = Told::enabled();
                told.line.global_control(0x28, 0);
                told.texts()
            }),
            row("S-21", "DIP switches at 127", || {
                let mut told = Told::new();
                told.line.device.power_off(told.line.now);
                told.line
                    .device
                    .set_switches(profidrive::devices::ag03::profibus::DipSwitches::from_bits(0x7F));
                told.line.device.power_on(told.line.now);
                told.line.wait(CYCLE);
                told.texts()
            }),
            row("S-22", "switched off and on with SW8 ON, a factory reset", || {
                let mut told = Told::new();
                told.line.device.power_off(told.line.now);
                told.line
                    .device
                    .set_switches(profidrive::devices::ag03::profibus::DipSwitches::from_bits(0x81));
                told.line.device.power_on(told.line.now);
                told.line.wait(CYCLE);
                told.texts()
            }),
            row("S-23", "Set_Slave_Add with another ident number", || slave_add(&[7, 0x12, 0x35, 0])),
            row("S-24", "Set_Slave_Add with address 126", || slave_add(&[126, 0x12, 0x34, 0])),
            row("S-25", "Set_Slave_Add with 3 octets", || slave_add(&[7, 0x12, 0x34])),
            row("S-26", "Set_Slave_Add in order", || slave_add(&[7, 0x12, 0x34, 0])),
            row("S-27", "Set_Prm with neither Lock_Req nor Unlock_Req", || prm(|prm| prm[0] = 0)),
            row("S-28", "Set_Prm with the octets of the ident number exchanged", || {
                prm(|prm| prm.swap(4, 5))
            }),
            row("S-29", "Data_Exchange before Set_Prm, three times", || {
                let mut told = Told::new();
                (0..3).for_each(|_| _ = told.line.request(MASTER, None, &[0; 14]));
                told.texts()
            }),
            row("S-30", "Data_Exchange before Chk_Cfg", || {
                let mut told = Told::new();
                told.line.request(MASTER, Some(61), &PRM);
                told.line.events.clear();
                told.line.request(MASTER, None, &[0; 14]);
                told.texts()
            }),
            row("S-31", "Chk_Cfg before Set_Prm", || {
                let mut told = Told::new();
                told.line.request(MASTER, Some(62), &CFG);
                told.texts()
            }),
            row("S-32", "Chk_Cfg and Data_Exchange by master 3 while master 2 has the slave locked", || {
                let mut told = Told::exchanging();
                told.line.request(3, Some(62), &CFG);
                (0..3).for_each(|_| _ = told.line.request(3, None, &[0; 14]));
                told.texts()
            }),
            row("S-33", "RD_Inp before Data_Exchange", || service(56, &[])),
            row("S-34", "Set_Slave_Add to a drive, which has DIP switches", || {
                service(55, &[7, IDENT[0], IDENT[1], 0])
            }),
            row("S-35", "a request to SAP 51, where a slave of DP-V1 listens", || {
                service(51, &[0x5E, 0, 0, 1])
            }),
            row("S-36", "Slave_Diag with two octets of data", || service(60, &[1, 2])),
            row("S-37", "Set_Prm to a station at address 126", || {
                slave_asked(126, 61, &[0x88, 10, 1, 11, 0x12, 0x34, 0])
            }),
            row("S-38", "Sync and Freeze, which Set_Prm did not ask for", || {
                let mut told = Told::new();
                told.line.start_up_with(&[0x88, 10, 1, 11, IDENT[0], IDENT[1], 0]);
                told.line.events.clear();
                (0..3).for_each(|_| told.line.global_control(0x20, 0));
                told.line.global_control(0x08, 0);
                told.texts()
            }),
            row("S-39", "Set_Prm asks a slave for Sync that has none", || {
                slave_asked(7, 61, &[0xA8, 10, 1, 11, 0x12, 0x34, 0])
            }),
            row("S-40", "the master is silent behind Set_Prm", || {
                let mut told = Told::new();
                told.line.request(MASTER, Some(61), &PRM);
                told.line.events.clear();
                told.line.wait(Duration::from_millis(200));
                told.texts()
            }),
            row("S-41", "Global_Control as a request with a reply", || {
                let mut told = Told::exchanging();
                told.line.request(MASTER, Some(58), &[2, 0]);
                told.texts()
            }),
        ],
    );
}

/// What a station that takes another address says to Set_Slave_Add.
fn slave_add(data: &[u8]) -> Vec<String> {
    slave_asked(126, 55, data)
}

/// What a station that takes another address says to one request at `da`.
fn slave_asked(da: u8, dsap: u8, data: &[u8]) -> Vec<String> {
    let description = Description { ident: 0x1234, set_slave_add: true, ..Description::PLAIN };
    let mut station = Station::new(address(da), BaudRate::K500, None, description, Fixed::PLAIN);
    let mut said = Vec::new();
    let fc = profidrive::profibus::fdl::FunctionCode::request(
        profidrive::profibus::fdl::Service::SrdHigh,
        profidrive::profibus::fdl::FrameCount::First,
    );
    Framer::new(Resync::SCAN).handle_bytes(
        Instant::ZERO,
        &telegram(da, MASTER, fc, Some(dsap), data),
        |at, result| {
            let event = station.handle_telegram(at, &result.unwrap()).event.unwrap();
            said.push(event.to_string());
        },
    );
    said
}

/// What a drive says to octets.
fn octets(octets: &[u8]) -> Vec<String> {
    let mut told = Told::new();
    told.line.device.handle_bytes(told.line.now, octets);
    told.line.wait(Duration::from_millis(100));
    told.texts()
}

#[test]
fn the_line() {
    let mut ask = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];
    ask[4] ^= 1;
    compare(
        "Octets on the line",
        vec![
            row("L-01", "an octet 44", || octets(&[0x44])),
            row("L-02", "a telegram with a wrong check sequence", || octets(&ask)),
            row("L-03", "a telegram with a wrong end delimiter", || {
                octets(&[0x10, 0x05, 0x02, 0x49, 0x50, 0x17])
            }),
            row("L-04", "LE and LEr differ", || octets(&[0x68, 0x05, 0x06, 0x68])),
            row("L-05", "LE is 3", || octets(&[0x68, 0x03, 0x03, 0x68])),
            row("L-06", "an incomplete telegram", || octets(&[0x68, 0x05, 0x05, 0x68, 0x85])),
            row("L-07", "a token to address 255", || octets(&[0xDC, 0xFF, 0x02])),
        ],
    );
}
