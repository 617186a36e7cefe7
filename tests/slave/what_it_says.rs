//! Ways to fail at a drive in virtual time, and the words that appear: sections of `docs/what-it-says.md`.

use std::time::Duration;

use profidrive::device::{Config, Device};
use profidrive::dp::{Description, Fixed, Station};
use profidrive::drive::{Fault, Inputs};
use profidrive::fdl::{Framer, Resync};
use profidrive::param::{Model, Value};
use profidrive::time::{BaudRate, Instant};

use crate::ag03_node::Rig;
use crate::common::{CFG, IDENT, MASTER, telegram};
use crate::said::{Row, compare};
use crate::told::{CYCLE, PRM, Told, address};

fn row<'a>(id: &'a str, done: &'a str, act: impl FnOnce() -> Vec<String> + 'a) -> Row<'a> {
    (id, done, Box::new(act))
}

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
                told.line.device.set_switches(profidrive::device::DipSwitches::from_bits(0x7F));
                told.line.device.power_on(told.line.now);
                told.line.wait(CYCLE);
                told.texts()
            }),
            row("S-22", "switched off and on with SW8 ON, a factory reset", || {
                let mut told = Told::new();
                told.line.device.power_off(told.line.now);
                told.line.device.set_switches(profidrive::device::DipSwitches::from_bits(0x81));
                told.line.device.power_on(told.line.now);
                told.line.wait(CYCLE);
                told.texts()
            }),
            row("S-23", "Set_Slave_Add with another ident number", || slave_add(&[7, 0x12, 0x35, 0])),
            row("S-24", "Set_Slave_Add with address 126", || slave_add(&[126, 0x12, 0x34, 0])),
            row("S-25", "Set_Slave_Add with 3 octets", || slave_add(&[7, 0x12, 0x34])),
            row("S-26", "Set_Slave_Add in order", || slave_add(&[7, 0x12, 0x34, 0])),
        ],
    );
}

/// What a station that takes another address says to Set_Slave_Add.
fn slave_add(data: &[u8]) -> Vec<String> {
    let description = Description { ident: 0x1234, set_slave_add: true, ..Description::PLAIN };
    let mut station = Station::new(address(126), BaudRate::K500, None, description, Fixed::PLAIN);
    let mut said = Vec::new();
    let fc = profidrive::fdl::FunctionCode::request(
        profidrive::fdl::Service::SrdHigh,
        profidrive::fdl::FrameCount::First,
    );
    Framer::new(Resync::SCAN).receive(
        Instant::ZERO,
        &telegram(126, MASTER, fc, Some(55), data),
        |at, result| {
            let event = station.receive(at, &result.unwrap()).event.unwrap();
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
        ],
    );
}

/// A drive in this fault, operation was enabled.
fn in_fault(fault: Fault) -> Told {
    let mut told = Told::enabled();
    told.inputs(Inputs::default().provoking(fault));
    told.say(0x007B, 16_000, Duration::from_secs(8));
    assert!(told.line.device.status().fault.is_some(), "{fault:?}");
    told
}

#[test]
fn faults() {
    let provoked = |fault: Fault| {
        move || {
            let mut told = in_fault(fault);
            let texts = told.texts();
            texts.into_iter().filter(|text| text.starts_with("fault ")).collect()
        }
    };
    let said = |words: fn(&mut Told)| {
        move || {
            let mut told = in_fault(Fault::F);
            told.line.events.clear();
            words(&mut told);
            told.texts()
        }
    };
    let names: Vec<_> = Fault::ALL
        .into_iter()
        .filter(|fault| !matches!(fault, Fault::H | Fault::I))
        .enumerate()
        .map(|(number, fault)| {
            (fault, format!("F-{:02}", number + 1), format!("the cause of fault {fault:?} acts"))
        })
        .collect();
    let mut rows: Vec<Row<'_>> = Vec::new();
    for (fault, id, done) in &names {
        rows.push((id, done, Box::new(provoked(*fault))));
    }
    rows.push(row(
        "F-20",
        "acknowledged while the cause is still there",
        said(|told| told.say(0x00BB, 0, CYCLE)),
    ));
    rows.push(row(
        "F-21",
        "the cause goes",
        said(|told| {
            told.inputs(Inputs::default());
            told.say(0x007B, 0, CYCLE);
        }),
    ));
    rows.push(row("F-22", "a start in fault", said(|told| told.say(0x003B, 0, CYCLE))));
    rows.push(row(
        "F-23",
        "acknowledged with 047F held",
        said(|told| {
            told.inputs(Inputs::default());
            told.say(0x047F, 0, CYCLE);
            told.line.events.clear();
            told.say(0x04FF, 0, CYCLE);
        }),
    ));
    rows.push(row(
        "F-24",
        "enabled after the acknowledgement, without OFF1",
        said(|told| {
            told.inputs(Inputs::default());
            for stw in [0x0073, 0x00F3, 0x0073] {
                told.say(stw, 0, CYCLE);
            }
            told.line.events.clear();
            told.say(0x007B, 0, CYCLE);
        }),
    ));
    rows.push(row(
        "F-25",
        "acknowledged a second time",
        said(|told| {
            told.inputs(Inputs::default());
            for stw in [0x003B, 0x00BB, 0x003B] {
                told.say(stw, 0, CYCLE);
            }
            told.line.events.clear();
            told.say(0x00BB, 0, CYCLE);
        }),
    ));
    rows.push(row("F-26", "the battery has 2.4 V", || {
        let mut told = Told::enabled();
        told.inputs(Inputs { battery: 2.4, ..Inputs::default() });
        told.say(0x003B, 0, CYCLE);
        told.texts()
    }));
    compare("Faults and warnings", rows);
}

/// What the drive says to one PKW job: PKE, IND, PWE.
fn job(pke: u16, ind: u16, pwe: u32) -> Vec<String> {
    job_of(Told::exchanging(), pke, ind, pwe)
}

fn job_of(mut told: Told, pke: u16, ind: u16, pwe: u32) -> Vec<String> {
    told.pkw[..2].copy_from_slice(&pke.to_be_bytes());
    told.pkw[2..4].copy_from_slice(&ind.to_be_bytes());
    told.pkw[4..].copy_from_slice(&pwe.to_be_bytes());
    told.say(0x003B, 16_000, CYCLE * 2);
    told.texts()
}

const fn pke(ak: u16, pnu: u16) -> u16 {
    ak << 12 | pnu
}

#[test]
fn parameters() {
    let travelling = || {
        let mut told = Told::enabled();
        told.say(0x007B, 16_000, CYCLE * 5);
        told.line.events.clear();
        told
    };
    compare(
        "Parameter channel",
        vec![
            row("P-01", "read PNU 1", || job(pke(1, 1), 0, 0)),
            row("P-02", "change PNU 1004 (v-Pos) to 101 with gear 48:1", || job(pke(2, 1004), 0, 101)),
            row("P-03", "change PNU 1004 (v-Pos) as a double word", || job(pke(3, 1004), 0, 50)),
            row("P-04", "change PNU 1016 (limit) as a word", || job(pke(2, 1016), 0, 50)),
            row("P-05", "change PNU 1029 (motor current)", || job(pke(2, 1029), 0, 5)),
            row("P-06", "read PNU 945 (array) with job 1", || job(pke(1, 945), 0, 0)),
            row("P-07", "read element 99 of PNU 945", || job(pke(6, 945), 99 << 8, 0)),
            row("P-08", "read an element of PNU 1004", || job(pke(6, 1004), 0, 0)),
            row("P-09", "read the description of PNU 1004", || job(pke(4, 1004), 0, 0)),
            row("P-10", "change the description of PNU 1004", || job(pke(5, 1004), 0, 0)),
            row("P-11", "job 11", || job(pke(11, 1004), 0, 0)),
            row("P-12", "change PNU 930 (operating mode) to 3", || job(pke(2, 930), 0, 3)),
            row("P-13", "change PNU 1012 (spindle pitch) during a travel job", || {
                job_of(travelling(), pke(2, 1012), 0, 400)
                    .into_iter()
                    .filter(|text| text.starts_with("job "))
                    .collect()
            }),
            row("P-14", "change PNU 1004 to 50", || {
                job(pke(2, 1004), 0, 50).into_iter().filter(|text| text.starts_with("PNU ")).collect()
            }),
            row("P-15", "change PNU 1016 to 800 with a spindle pitch of 4 mm", || {
                let mut told = Told::exchanging();
                told.write(1012, Value::Word(400));
                told.line.events.clear();
                job_of(told, pke(3, 1016), 0, 800)
                    .into_iter()
                    .filter(|text| text.starts_with("PNU "))
                    .collect()
            }),
            row("P-16", "PWE is changed first and PKE one exchange later", || {
                let mut told = Told::exchanging();
                told.pkw = [0x23, 0xEC, 0, 0, 0, 0, 0, 50];
                told.say(0, 0, CYCLE * 3);
                told.line.events.clear();
                told.pkw[7] = 7;
                told.exchange(0, 0);
                told.line.wait(CYCLE);
                told.pkw[1] = 0xED;
                told.exchange(0, 0);
                told.line.wait(CYCLE);
                told.texts()
            }),
        ],
    );
}

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
            row("H-02", "Sync is left on", || {
                let mut told = Told::enabled();
                told.line.global_control(0x20, 0);
                told.say(0x003B, 0, Duration::from_secs(6));
                told.hints()
            }),
            row("H-03", "a watchdog of 10 ms, and a master that asks every 25 ms", || {
                let mut told = Told::new();
                for _ in 0..3 {
                    told.line.start_up_with(&[0x88, 1, 1, 11, IDENT[0], IDENT[1], 0]);
                    told.line.wait(Duration::from_millis(25));
                }
                told.hints()
            }),
            row("H-04", "equal limits", || {
                let mut told = Told::exchanging();
                told.write(1016, Value::Double(500));
                told.write(1017, Value::Double(500));
                told.say(0, 0, CYCLE);
                told.say(0x003B, 0, CYCLE);
                told.hints()
            }),
            row("H-05", "limit 1 below limit 2", || {
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

#[test]
fn why() {
    let asked = |told: &Told| vec![told.line.device.why().to_string()];
    let after = |act: fn(&mut Told)| {
        move || {
            let mut told = Told::exchanging();
            told.say(0, 0, CYCLE);
            act(&mut told);
            asked(&told)
        }
    };
    compare(
        "Why a drive does not move",
        vec![
            row("W-01", "no master", || asked(&Told::new())),
            row("W-02", "Set_Prm was refused", || {
                let mut told = Told::new();
                told.line.request(MASTER, Some(61), &[0x88, 10, 1, 11, 0x12, 0x34, 0]);
                asked(&told)
            }),
            row("W-03", "Chk_Cfg was refused", || {
                let mut told = Told::new();
                told.line.request(MASTER, Some(61), &PRM);
                told.line.request(MASTER, Some(62), &[0x11]);
                asked(&told)
            }),
            row("W-04", "switched off", || {
                let mut told = Told::new();
                told.line.device.power_off(told.line.now);
                asked(&told)
            }),
            row("W-05", "STW 0000", after(|_| {})),
            row("W-06", "STW 003B, no start", after(|told| told.say(0x003B, 0, CYCLE))),
            row("W-07", "STW 004B", after(|told| told.say(0x004B, 0, CYCLE))),
            row(
                "W-08",
                "a fault whose cause acts",
                after(|told| {
                    told.say(0x003B, 0, CYCLE);
                    told.inputs(Inputs::default().provoking(Fault::F));
                    told.say(0x003B, 0, CYCLE);
                }),
            ),
            row(
                "W-09",
                "a fault whose cause is gone",
                after(|told| {
                    told.say(0x003B, 0, CYCLE);
                    told.inputs(Inputs::default().provoking(Fault::F));
                    told.say(0x003B, 0, CYCLE);
                    told.inputs(Inputs::default());
                    told.say(0x003B, 0, CYCLE);
                }),
            ),
            row(
                "W-10",
                "acknowledged",
                after(|told| {
                    told.say(0x003B, 0, CYCLE);
                    told.inputs(Inputs::default().provoking(Fault::F));
                    told.say(0x003B, 0, CYCLE);
                    told.inputs(Inputs::default());
                    told.say(0x003B, 0, CYCLE);
                    told.say(0x00BB, 0, CYCLE);
                }),
            ),
            row("W-11", "a setpoint beyond the limit", after(|told| told.say(0x003B, 1_200_000, CYCLE))),
            row("W-12", "Sync holds the outputs", after(|told| told.line.global_control(0x20, 0))),
            row(
                "W-13",
                "velocity mode, setpoint 0",
                after(|told| {
                    told.write(930, Value::Word(1));
                    told.say(0x000B, 0, CYCLE);
                }),
            ),
            row("W-14", "an AG03 whose enable input is not active", || {
                let mut told = Told::with(|config| Config { model: Model::Ag03, ..config });
                told.line.start_up_with(&PRM);
                told.inputs(Inputs { enable_input: false, ..Inputs::default() });
                told.say(0, 0, CYCLE);
                told.say(0x003B, 0, CYCLE);
                asked(&told)
            }),
            row(
                "W-15",
                "it travels",
                after(|told| {
                    told.say(0x003B, 0, CYCLE);
                    told.say(0x007B, 16_000, CYCLE * 10);
                }),
            ),
        ],
    );
}

#[test]
fn the_control_words_that_why_names_make_it_move() {
    let fault_gone = |told: &mut Told| {
        told.say(0x003B, 0, CYCLE);
        told.inputs(Inputs::default().provoking(Fault::F));
        told.say(0x003B, 0, CYCLE);
        told.inputs(Inputs::default());
        told.say(0x003B, 0, CYCLE);
    };
    type Case = (&'static str, Box<dyn Fn(&mut Told)>);
    let cases: [Case; 7] = [
        ("nothing", Box::new(|_| {})),
        ("enabled", Box::new(|told| told.say(0x003B, 1600, CYCLE))),
        ("no stop bits", Box::new(|told| told.say(0x000B, 1600, CYCLE))),
        ("start bit", Box::new(|told| told.say(0x0070, 1600, CYCLE))),
        ("fault", Box::new(fault_gone)),
        (
            "fault, acknowledge bit held",
            Box::new(move |told| {
                told.say(0x00BB, 0, CYCLE);
                fault_gone(told);
                told.say(0x0080, 0, CYCLE);
            }),
        ),
        (
            "acknowledged",
            Box::new(move |told| {
                fault_gone(told);
                told.say(0x00BB, 0, CYCLE);
            }),
        ),
    ];
    for (what, act) in cases {
        let mut told = Told::exchanging();
        told.say(0, 0, CYCLE);
        act(&mut told);
        let next = told.line.device.why().next().expect(what).to_string();
        let words = next.split([' ', ',']).filter(|word| word.len() == 4);
        for word in words.filter_map(|word| u16::from_str_radix(word, 16).ok()) {
            told.say(word, 1600, CYCLE);
        }
        let device: &Device = &told.line.device;
        assert!(device.status().job_active, "{what}: {next}; {}", device.why());
    }
}

#[test]
fn the_node() {
    let events = |rig: &mut Rig| -> Vec<String> {
        std::iter::from_fn(|| rig.node.poll_event()).map(|event| event.to_string()).collect()
    };
    let after = |act: fn(&mut Rig)| {
        move || {
            let mut rig = Rig::enabled();
            events(&mut rig);
            act(&mut rig);
            events(&mut rig)
        }
    };
    let why = |act: fn(&mut Rig)| {
        move || {
            let mut rig = Rig::new();
            act(&mut rig);
            rig.node.why().map(|hindrance| hindrance.to_string()).collect()
        }
    };
    compare(
        "AG03/1 on CANopen",
        vec![
            row(
                "N-01",
                "a start above the upper limit",
                after(|rig| {
                    rig.travel(0x010F, 1_500_000);
                    rig.travel(0x011F, 1_500_000);
                    rig.pass(Duration::from_millis(20));
                }),
            ),
            row(
                "N-02",
                "a fault",
                after(|rig| {
                    rig.node.set_inputs(rig.now, Inputs::default().provoking(Fault::F));
                    rig.pass(Duration::from_millis(50));
                }),
            ),
            row(
                "N-03",
                "NMT stop during operation",
                after(|rig| {
                    rig.nmt(0x02);
                    rig.pass(Duration::from_millis(20));
                }),
            ),
            row("N-04", "why: after power-on", why(|_| {})),
            row("N-05", "why: in OPERATIONAL", why(|rig| _ = rig.nmt(0x01))),
            row(
                "N-06",
                "why: switched on",
                why(|rig| {
                    rig.nmt(0x01);
                    rig.word(0x0106);
                    rig.word(0x0107);
                    rig.pass(Duration::from_millis(20));
                }),
            ),
            row(
                "N-07",
                "why: a fault",
                why(|rig| {
                    rig.enable();
                    rig.node.set_inputs(rig.now, Inputs::default().provoking(Fault::F));
                    rig.pass(Duration::from_millis(50));
                }),
            ),
            row("N-08", "why: switched off", why(|rig| rig.node.power_off(rig.now))),
        ],
    );
}
