//! Thirty more mistakes on PROFIBUS: start-up, DP-V1, parameter channel, words.

use core::time::Duration;

use super::line::{OnLine, enabled, job, put, started, word};
use crate::host::tests::silence::slaves::{CYCLE, Line, MASTER, OTHER, SLAVE};
use crate::profibus::dp::Service;
use crate::profibus::fdl;

/// A request of class 1 on its own SAP, and the polls for its answer.
fn record(line: &mut Line, data: &[u8]) {
    for data in core::iter::once(data).chain([&[][..]; 8]) {
        let octets = line.request((MASTER, SLAVE), fdl::Service::SrdHigh, Some(51), 51, data);
        line.reply_to(&octets);
        line.exchange(1);
    }
}

/// A job of the parameter channel of PROFIdrive: written to record 47, then read.
fn base_mode(line: &mut Line, request: &[u8]) {
    let len = u8::try_from(request.len()).unwrap();
    record(line, &[&[0x5F, 0, 47, len][..], request].concat());
    record(line, &[0x5E, 0, 47, 240]);
}

fn set_prm(line: &mut Line, change: impl FnOnce(&mut Vec<u8>)) {
    let mut prm = line.prm();
    change(&mut prm);
    line.ask(MASTER, Service::SetPrm, &prm);
}

pub(super) const RECORDS: &[OnLine] = &[
    (
        "a watchdog with the factor 0",
        "ag03-1",
        |line| set_prm(line, |prm| prm[0] |= 0x08),
        &["Set_Prm octets 2-3", "watchdog", "expected 1..255", "project"],
    ),
    (
        "Set_Prm of a device with the ident number of another",
        "ppo-drive",
        |line| set_prm(line, |prm| prm[5] ^= 0xFF),
        &["Set_Prm octets 5-6", "0x50BB", "expected 0x5044", "another device at this address"],
    ),
    (
        "a watchdog shorter than the cycle of the master",
        "ag03-1",
        |line| {
            set_prm(line, |prm| (prm[0], prm[1], prm[2]) = (prm[0] | 0x08, 2, 1));
            line.ask(MASTER, Service::ChkCfg, line.target.cfg);
            for _ in 0..3 {
                line.exchange(1);
                line.wait(Duration::from_millis(100));
            }
        },
        &["watchdog expired", "20ms", "raise its watchdog time"],
    ),
    (
        "Sync without Sync_Req in Set_Prm",
        "ag03-1",
        |line| {
            set_prm(line, |prm| prm[0] = 0x80);
            line.ask(MASTER, Service::ChkCfg, line.target.cfg);
            line.exchange(5);
            line.take_news();
            for _ in 0..5 {
                line.control(MASTER, &[0x20, 0]);
                line.exchange(1);
            }
        },
        &["Sync", "Set_Prm"],
    ),
    ("Data_Exchange before Set_Prm", "ppo-drive", |line| _ = line.exchange(3), &["Data_Exchange", "Set_Prm"]),
    (
        "Chk_Cfg with the special format cut off",
        "station",
        |line| {
            set_prm(line, |_| {});
            line.ask(MASTER, Service::ChkCfg, &[0x10, 0x40]);
        },
        &["Chk_Cfg octet 3: the end"],
    ),
    (
        "Chk_Cfg with fifty identifiers",
        "ag03-1",
        |line| {
            set_prm(line, |_| {});
            line.ask(MASTER, Service::ChkCfg, &[0x10; 50]);
        },
        &["Chk_Cfg octet 1", "0x10", "expected 0xF3", "choose the module"],
    ),
    (
        "Data_Exchange with eight octets of outputs",
        "ag03-1",
        |line| {
            started(line);
            line.outputs.truncate(8);
            line.exchange(2);
            line.outputs.resize(14, 0);
        },
        &["left Data_Exchange", "8 output octets", "expected 14", "Chk_Cfg"],
    ),
    (
        "Data_Exchange by SDN",
        "ag03-1",
        |line| {
            started(line);
            for _ in 0..5 {
                let outputs = line.outputs.clone();
                let octets = line.request((MASTER, SLAVE), fdl::Service::SdnHigh, None, 62, &outputs);
                line.reply_to(&octets);
                line.wait(CYCLE);
            }
        },
        &["SDN", "SRD"],
    ),
    (
        "Set_Prm to all stations",
        "ag03-1",
        |line| {
            for _ in 0..5 {
                let prm = line.prm();
                let octets = line.request((MASTER, 127), fdl::Service::SrdHigh, Some(61), 62, &prm);
                line.reply_to(&octets);
                line.wait(CYCLE);
            }
        },
        &["127", "Set_Prm", "station"],
    ),
    (
        "outputs that are 0 all the time",
        "profidrive",
        |line| {
            started(line);
            line.exchange(10);
        },
        &["outputs of master 2 are 0", "CLEAR"],
    ),
    (
        "a record of slot 9",
        "profidrive",
        |line| {
            started(line);
            record(line, &[0x5E, 9, 47, 240]);
        },
        &["Read of record 47 of slot 9", "slot"],
    ),
    (
        "a record that the drive does not have",
        "profidrive",
        |line| {
            started(line);
            record(line, &[0x5E, 0, 200, 240]);
        },
        &["Read of record 200 of slot 0", "index"],
    ),
    (
        "an answer is read before there was a job",
        "profidrive",
        |line| {
            started(line);
            record(line, &[0x5E, 0, 47, 240]);
        },
        &["Read of record 47", "write the request first"],
    ),
    (
        "a job of two octets",
        "profidrive",
        |line| {
            started(line);
            base_mode(line, &[1, 1]);
        },
        &["Write of record 47", "length"],
    ),
    (
        "a job with request ID 5",
        "profidrive",
        |line| {
            started(line);
            base_mode(line, &[1, 5, 0, 1, 0x10, 1, 3, 0x9A, 0, 0]);
        },
        &["request ID 05h", "expected 01h", "02h"],
    ),
    (
        "a job for PNU 9999",
        "profidrive",
        |line| {
            started(line);
            base_mode(line, &[1, 1, 1, 1, 0x10, 1, 0x27, 0x0F, 0, 0]);
        },
        &["PNU 9999", "no such parameter", "PNU 980"],
    ),
    (
        "a read-only parameter is written",
        "profidrive",
        |line| {
            started(line);
            base_mode(line, &[1, 2, 1, 1, 0x10, 1, 0x03, 0xB0, 0, 0, 0x42, 1, 0, 1]);
        },
        &["PNU 944", "not changeable", "only be read"],
    ),
    (
        "a job for axis 7",
        "profidrive",
        |line| {
            started(line);
            base_mode(line, &[1, 1, 7, 1, 0x10, 1, 0x03, 0x9A, 0, 0]);
        },
        &["7", "axis"],
    ),
    (
        "a job for no parameter",
        "profidrive",
        |line| {
            started(line);
            base_mode(line, &[1, 1, 1, 0]);
        },
        &["0 parameters", "1 to 39"],
    ),
    (
        "an alarm is acknowledged that nobody has raised",
        "profidrive",
        |line| {
            started(line);
            record(line, &[0x5C, 0, 1, 0]);
        },
        &["Alarm_Ack", "no alarm waits", "Slave_Diag"],
    ),
    (
        "class 2 asks without Initiate",
        "profidrive",
        |line| {
            started(line);
            let octets = line.request((OTHER, SLAVE), fdl::Service::SrdLow, Some(0), 50, &[0x5E, 0, 47, 240]);
            line.reply_to(&octets);
        },
        &["SAP 0", "SAP 49 opens one"],
    ),
    (
        "a word is written by the job for double words",
        "ag03-1",
        |line| {
            started(line);
            job(line, 0x33A2, 0, 2);
        },
        &["PNU 930", "job 3", "job 2"],
    ),
    (
        "an array is read that is a single value",
        "ag03-1",
        |line| {
            started(line);
            job(line, 0x63EC, 1, 0);
        },
        &["PNU 1004", "array", "job 1"],
    ),
    (
        "job 15",
        "ag03-1",
        |line| {
            started(line);
            job(line, 0xF3EC, 0, 0);
        },
        &["job 15", "1"],
    ),
    (
        "a value beyond the limits of a parameter",
        "ag03",
        |line| {
            started(line);
            job(line, 0x23EC, 0, 5000);
        },
        &["PNU 1004", "1 to", "5000", "rpm"],
    ),
    (
        "OFF2 is given in all words",
        "ppo-drive",
        |line| {
            started(line);
            for stw in [0x47C, 0x47D] {
                word(line, stw);
            }
        },
        &["OFF2", "STW bit 1"],
    ),
    (
        "a fault is acknowledged while ON stays given",
        "profidrive",
        |line| {
            enabled(line);
            line.act(|device, now| {
                let mut first = None;
                device.each_fault(&mut |fault| {
                    first.get_or_insert_with(|| fault.name.to_string());
                });
                _ = device.provoke(now, &first.unwrap());
            });
            line.exchange(20);
            line.act(|device, now| device.make_nominal(now));
            word(line, 0x4FF);
            word(line, 0x47F);
            line.exchange(20);
        },
        &["OFF1"],
    ),
    (
        "inching while the setpoint is given",
        "ppo-drive",
        |line| {
            enabled(line);
            put(line, 10, &[0x10, 0]);
            word(line, 0x57F);
        },
        &["inching", "STW bit"],
    ),
    (
        "the master of class 2 locks the slave for itself",
        "ag03-1",
        |line| {
            started(line);
            for _ in 0..5 {
                line.exchange(2);
                let octets = line.request((OTHER, SLAVE), fdl::Service::SrdHigh, None, 62, &[0; 14]);
                line.reply_to(&octets);
            }
        },
        &["Data_Exchange of master 3", "master 2"],
    ),
];
