//! Why a drive does not move.

use profidrive::devices::ag03::drive::{Fault, Inputs};
use profidrive::devices::ag03::param::{Model, Value};
use profidrive::devices::ag03::profibus::{Config, Device};
use profidrive::face::Why;

use super::row;
use crate::drive_line::MASTER;
use crate::drive_log::{CYCLE, PRM, Told};
use crate::sentences::compare;

fn line_of(device: &dyn Why) -> String {
    device.to_string()
}

#[test]
fn why() {
    let asked = |told: &Told| vec![line_of(&told.line.device)];
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
            row("W-17", "the watchdog expired", || {
                let mut told = Told::exchanging();
                told.line.wait(std::time::Duration::from_secs(10));
                asked(&told)
            }),
            row("W-18", "Data_Exchange with another number of outputs", || {
                let mut told = Told::exchanging();
                told.line.request(MASTER, None, &[0; 10]);
                asked(&told)
            }),
            row("W-19", "Set_Prm was accepted, and no Chk_Cfg comes", || {
                let mut told = Told::new();
                told.line.request(MASTER, Some(61), &PRM);
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
            row("W-16", "Freeze holds the inputs", after(|told| told.line.global_control(0x08, 0))),
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
        let mut next = String::new();
        told.line.device.next(&mut |words| next = words.to_string());
        assert!(!next.is_empty(), "{what}");
        let words = next.split([' ', ',']).filter(|word| word.len() == 4);
        for word in words.filter_map(|word| u16::from_str_radix(word, 16).ok()) {
            told.say(word, 1600, CYCLE);
        }
        let device: &Device = &told.line.device;
        assert!(device.status().job_active, "{what}: {next}; {}", line_of(device));
    }
}
