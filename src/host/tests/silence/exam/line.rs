//! Thirty mistakes on PROFIBUS.

use core::time::Duration;

use crate::host::tests::silence::slaves::{self, CYCLE, Line, MASTER, OTHER};
use crate::host::tests::silence::words::Kind;
use crate::profibus::dp::Service;
use crate::profibus::fdl;

/// A mistake: what it is, at which target, what is sent, and words that are read of it in the log or by `why`.
pub(super) type OnLine = (&'static str, &'static str, fn(&mut Line), &'static [&'static str]);

/// Outputs from `at` on, for some cycles.
pub(super) fn put(line: &mut Line, at: usize, octets: &[u8]) {
    line.outputs[at..at + octets.len()].copy_from_slice(octets);
    line.exchange(12);
}

pub(in crate::host::tests::silence) fn word(line: &mut Line, word: u16) {
    let at = line.target.kind.stw().unwrap();
    put(line, at, &word.to_be_bytes());
}

pub(super) fn started(line: &mut Line) {
    assert!(line.start_up(), "{:#?}", line.story);
    line.take_news();
}

/// Operation enabled.
pub(super) fn enabled(line: &mut Line) {
    started(line);
    match line.target.kind {
        Kind::Ag03 => [0x3A, 0x3B].into_iter().for_each(|stw| word(line, stw)),
        Kind::Ppo | Kind::Profidrive => [0x47E, 0x47F].into_iter().for_each(|stw| word(line, stw)),
        Kind::Station => {}
    }
    line.take_news();
}

/// A PKW job: read or write.
pub(in crate::host::tests::silence) fn job(line: &mut Line, pke: u16, ind: u8, pwe: u32) {
    let [high, low] = pke.to_be_bytes();
    let [a, b, c, d] = pwe.to_be_bytes();
    put(line, 0, &[high, low, ind, 0, a, b, c, d]);
}

pub(super) const ON_LINE: &[OnLine] = &[
    (
        "the identifiers of Chk_Cfg are exchanged",
        "ag03-1",
        |line| {
            let prm = line.prm();
            line.ask(MASTER, Service::SetPrm, &prm);
            line.ask(MASTER, Service::ChkCfg, &[0xF2, 0xF3]);
        },
        &["Chk_Cfg octet 1", "0xF2", "expected 0xF3", "choose the module"],
    ),
    (
        "a PPO 2 project at a drive with PPO 1",
        "ppo-drive",
        |line| {
            let prm = line.prm();
            line.ask(MASTER, Service::SetPrm, &prm);
            line.ask(MASTER, Service::ChkCfg, &[0xF3, 0xF5]);
        },
        &["Chk_Cfg octet 2", "0xF5", "expected 0xF1", "PPO"],
    ),
    (
        "an identifier that no module of the GSD has",
        "station",
        |line| {
            let prm = line.prm();
            line.ask(MASTER, Service::SetPrm, &prm);
            line.ask(MASTER, Service::ChkCfg, &[0x11, 0x20]);
        },
        &["Chk_Cfg octet 1", "0x11"],
    ),
    (
        "Set_Prm with user parameters that the GSD does not have",
        "station",
        |line| {
            let prm = [&line.prm()[..], &[1, 2, 3, 4]].concat();
            line.ask(MASTER, Service::SetPrm, &prm);
        },
        &["Set_Prm", "11 octets", "expected"],
    ),
    (
        "Set_Prm without the octets of DP-V1",
        "profidrive",
        |line| {
            let prm = line.prm()[..7].to_vec();
            line.ask(MASTER, Service::SetPrm, &prm);
        },
        &["Set_Prm", "7 octets", "expected"],
    ),
    (
        "Set_Prm that wants Freeze of a slave without it",
        "station",
        |line| {
            let mut prm = line.prm();
            prm[0] |= 0x10;
            line.ask(MASTER, Service::SetPrm, &prm);
        },
        &["Set_Prm octet 1", "Freeze", "project"],
    ),
    (
        "min T_SDR above max T_SDR",
        "ag03-1",
        |line| {
            let mut prm = line.prm();
            prm[3] = 250;
            line.ask(MASTER, Service::SetPrm, &prm);
        },
        &["min T_SDR", "250", "max"],
    ),
    (
        "the frame count bit does not alternate",
        "ag03-1",
        |line| {
            enabled(line);
            let count = line.counts.get(&MASTER).copied().unwrap();
            for stw in [0x7B_u8, 0x3B, 0x7B, 0x3B, 0x7B, 0x3B] {
                line.counts.insert(MASTER, count);
                line.outputs[9] = stw;
                line.exchange(1);
            }
            for _ in 0..60 {
                line.counts.insert(MASTER, count);
                line.exchange(1);
            }
        },
        &["frame count bit", "FCB"],
    ),
    (
        "Data_Exchange to a DSAP",
        "ag03-1",
        |line| {
            started(line);
            for _ in 0..5 {
                let outputs = line.outputs.clone();
                let octets =
                    line.request((MASTER, slaves::SLAVE), fdl::Service::SrdHigh, Some(50), 62, &outputs);
                line.reply_to(&octets);
                line.wait(CYCLE);
            }
        },
        &["SAP 50"],
    ),
    (
        "a station as its own master",
        "ag03-1",
        |line| {
            for _ in 0..5 {
                line.ask(slaves::SLAVE, Service::SlaveDiag, &[]);
                line.wait(CYCLE);
            }
        },
        &["address 5", "another"],
    ),
    (
        "the control word with its octets exchanged",
        "ag03-1",
        |line| {
            started(line);
            for stw in [0x3A00, 0x3B00, 0x7B00] {
                word(line, stw);
            }
        },
        &["STW", "exchanged", "high"],
    ),
    (
        "the velocity in the high word of HSW",
        "ag03-1",
        |line| {
            started(line);
            job(line, 0x23A2, 0, 1);
            job(line, 0, 0, 0);
            for stw in [0x0A, 0x0B] {
                word(line, stw);
            }
            put(line, 10, &[0, 60, 0, 0]);
            word(line, 0x4B);
        },
        &["3932160 rpm", "give at most"],
    ),
    (
        "another setpoint without a change of STW.6",
        "ag03-1",
        |line| {
            enabled(line);
            put(line, 10, &[0, 0, 0x03, 0xE8]);
            word(line, 0x7B);
            line.exchange(300);
            line.take_news();
            put(line, 10, &[0, 0, 0x07, 0xD0]);
            line.exchange(300);
        },
        &["STW.6", "start"],
    ),
    (
        "a setpoint with its octets exchanged",
        "ag03-1",
        |line| {
            enabled(line);
            put(line, 10, &[0xE8, 0x03, 0, 0]);
            word(line, 0x7B);
        },
        &["setpoint", "limit", "exchanged"],
    ),
    (
        "inching during a travel job",
        "ag03-1",
        |line| {
            enabled(line);
            put(line, 10, &[0, 0x02, 0, 0]);
            word(line, 0x7B);
            word(line, 0x17B);
        },
        &["inching", "refused", "travel job"],
    ),
    (
        "both inching bits",
        "ag03-1",
        |line| {
            enabled(line);
            word(line, 0x33B);
        },
        &["inching", "STW.8", "STW.9"],
    ),
    (
        "STW.7 is 1 all the time",
        "ag03-1",
        |line| {
            started(line);
            for stw in [0xBA, 0xBB] {
                word(line, stw);
            }
            line.act(|device, now| _ = device.provoke(now, "F"));
            line.exchange(20);
            line.act(|device, now| device.make_nominal(now));
            line.exchange(20);
        },
        &["fault F", "STW.7", "from 0 to 1"],
    ),
    (
        "047F at once",
        "ppo-drive",
        |line| {
            started(line);
            word(line, 0x47F);
        },
        &["047F", "STW", "047E"],
    ),
    (
        "a setpoint while the ramp is held",
        "ppo-drive",
        |line| {
            enabled(line);
            word(line, 0x45F);
            put(line, 10, &[0x10, 0]);
        },
        &["STW bit 5"],
    ),
    (
        "a PPO drive without bit 10",
        "ppo-drive",
        |line| {
            started(line);
            word(line, 0x7E);
            word(line, 0x7F);
        },
        &["STW bit 10", "control by PLC"],
    ),
    (
        "a setpoint, and the ramp generator is off",
        "profidrive",
        |line| {
            enabled(line);
            word(line, 0x40F);
            put(line, 2, &[0x10, 0]);
        },
        &["bit 4"],
    ),
    (
        "OFF3 is given in all words",
        "profidrive",
        |line| {
            started(line);
            for stw in [0x47A, 0x47B] {
                word(line, stw);
            }
        },
        &["OFF3", "bit 2"],
    ),
    (
        "the operating mode is changed while operation is enabled",
        "ag03-1",
        |line| {
            enabled(line);
            put(line, 10, &[0, 0x02, 0, 0]);
            word(line, 0x7B);
            job(line, 0x23A2, 0, 1);
        },
        &["PNU 930", "moving", "when"],
    ),
    (
        "a job with PNU 0",
        "ag03-1",
        |line| {
            started(line);
            job(line, 0x1000, 0, 0);
        },
        &["PNU 0", "there is no parameter 0", "near it"],
    ),
    (
        "a parameter of the AG03/1 at an AG03",
        "ag03",
        |line| {
            started(line);
            job(line, 0x1410, 0, 0);
        },
        &["PNU 1040", "AG03/1"],
    ),
    (
        "a record before MS1 is there",
        "profidrive",
        |line| {
            let octets = line.request(
                (MASTER, slaves::SLAVE),
                fdl::Service::SrdHigh,
                Some(51),
                51,
                &[0x5E, 0, 47, 240],
            );
            line.reply_to(&octets);
        },
        &["SAP 51", "Set_Prm"],
    ),
    (
        "a record of a slave without DP-V1",
        "ag03-1",
        |line| {
            started(line);
            let octets = line.request(
                (MASTER, slaves::SLAVE),
                fdl::Service::SrdHigh,
                Some(51),
                51,
                &[0x5E, 0, 47, 240],
            );
            line.reply_to(&octets);
        },
        &["SAP 51", "DP-V1"],
    ),
    (
        "the master dies, and its watchdog is off",
        "ppo-drive",
        |line| {
            assert!(line.start_up());
            [0x47E, 0x47F].into_iter().for_each(|stw| word(line, stw));
            put(line, 10, &[0x10, 0]);
            line.wait(Duration::from_secs(20));
        },
        &["master 2", "watchdog"],
    ),
    (
        "Set_Prm in each cycle",
        "ag03-1",
        |line| {
            started(line);
            for _ in 0..40 {
                let prm = line.prm();
                line.ask(MASTER, Service::SetPrm, &prm);
                line.ask(MASTER, Service::ChkCfg, line.target.cfg);
                line.exchange(2);
            }
            line.wait(Duration::from_secs(3));
        },
        &["times more", "parameterised by master 2"],
    ),
    (
        "a second master parameterises in turn",
        "ag03-1",
        |line| {
            started(line);
            for _ in 0..5 {
                let mut prm = line.prm();
                prm[0] = 0x40;
                line.ask(OTHER, Service::SetPrm, &prm);
                line.exchange(2);
            }
        },
        &["master 3", "locked by master 2"],
    ),
];
