//! What correct masters do gives no refusal and no hint.

use core::time::Duration;

use super::nodes::{self, frame};
use super::slaves::{self, CYCLE, Line, MASTER, OTHER, Reply};
use super::words::Kind;
use crate::can_bus::can::{Frame, Id};
use crate::profibus::dp::Service;

/// A habit on PROFIBUS: what it is, whose it is or which standard prescribes it, and what is sent.
type OnLine = (&'static str, &'static str, fn(&mut Line));
/// The same on CANopen.
type OnBus = (&'static str, &'static str, fn(&mut nodes::Bus));

fn start(line: &mut Line) {
    assert!(line.start_up(), "{:#?}", line.story);
}

/// Words of a drive, each for some cycles; the setpoint stands behind.
fn words(line: &mut Line, words: &[(u16, u16)]) {
    let Some(at) = line.target.kind.stw() else { return };
    for (word, setpoint) in words {
        line.outputs[at..at + 2].copy_from_slice(&word.to_be_bytes());
        line.outputs[at + 2..at + 4].copy_from_slice(&setpoint.to_be_bytes());
        line.exchange(12);
    }
}

/// The start that the profile prescribes, travel or speed, and the stop.
fn operate(line: &mut Line) {
    match line.target.kind {
        Kind::Ag03 => words(line, &[(0x003A, 0), (0x003B, 0), (0x007B, 0), (0x003B, 0), (0x003A, 0)]),
        Kind::Ppo | Kind::Profidrive => {
            words(line, &[(0x047E, 0), (0x047F, 0), (0x047F, 0x1000), (0x047F, 0), (0x047E, 0)]);
            line.exchange(200);
        }
        Kind::Station => _ = line.exchange(5),
    }
}

const ON_LINE: &[OnLine] = &[
    ("a start with the diagnosis before and behind", "IEC 61158-6-3, start-up by a class 1 master", |line| {
        start(line)
    }),
    (
        "Set_Prm and Chk_Cfg repeated before Data_Exchange",
        "masters that begin again when one reply was lost",
        |line| {
            for _ in 0..2 {
                start(line);
            }
        },
    ),
    (
        "the start of the profile, and the stop",
        "profile PROFIDRIVE, general state machine: 047E, 047F",
        |line| {
            start(line);
            operate(line);
        },
    ),
    ("043E before 043F", "profile PROFIDRIVE with the ramp left out; the sequence of FW-2", |line| {
        start(line);
        if matches!(line.target.kind, Kind::Ppo | Kind::Profidrive) {
            words(line, &[(0x043E, 0), (0x043F, 0), (0x043E, 0)]);
        }
    }),
    ("a PLC that is restarted", "a PLC goes to STOP: outputs 0, Clear, unlock, and starts again", |line| {
        start(line);
        operate(line);
        line.outputs.fill(0);
        line.exchange(10);
        line.control(MASTER, &[0x02, 0]);
        let unlock = [&[0x40], &line.prm()[1..]].concat();
        line.ask(MASTER, Service::SetPrm, &unlock);
        line.wait(Duration::from_secs(10));
        start(line);
        operate(line);
    }),
    (
        "Global_Control Operate and Clear to all in each state",
        "IEC 61158-6-3, a class 1 master tells its mode to all",
        |line| {
            line.control(MASTER, &[0x02, 0]);
            start(line);
            for command in [0x00, 0x02, 0x00] {
                line.control(MASTER, &[command, 0]);
                line.exchange(3);
            }
        },
    ),
    ("unlock of a slave that nobody has", "IEC 61158-6-3, Unlock_Req at the end of a master", |line| {
        let unlock = [&[0x40], &line.prm()[1..]].concat();
        line.ask(MASTER, Service::SetPrm, &unlock);
    }),
    ("the GAP", "IEC 61158-4-3, GAP maintenance by FDL_Status", |line| {
        for da in (0..126).cycle().skip(3).take(300) {
            line.token(MASTER, MASTER);
            line.status(MASTER, da);
        }
    }),
    ("a live list of a master without a token", "IEC 61158-4-3, live list by FDL_Status", |line| {
        (0..126).for_each(|da| line.status(MASTER, da))
    }),
    (
        "a ring of two masters, the other one reads",
        "IEC 61158-4-3, ring; IEC 61158-6-3, Get_Cfg, RD_Inp, RD_Outp of class 2",
        |line| {
            start(line);
            for _ in 0..50 {
                line.token(OTHER, MASTER);
                line.exchange(1);
                line.token(MASTER, OTHER);
                line.ask(OTHER, Service::SlaveDiag, &[]);
            }
            line.token(MASTER, OTHER);
            for service in [Service::GetCfg, Service::RdInp, Service::RdOutp] {
                assert!(
                    matches!(line.ask(OTHER, service, &[]), Reply::Data(_) | Reply::Sc),
                    "{}",
                    service.name()
                );
            }
        },
    ),
    (
        "one diagnosis now and then in Data_Exchange",
        "class 1 masters that read the diagnosis by a timer",
        |line| {
            start(line);
            for _ in 0..100 {
                line.exchange(3);
                line.ask(MASTER, Service::SlaveDiag, &[]);
            }
        },
    ),
    ("Sync and Freeze in each cycle", "IEC 61158-6-3, Global_Control, axes in step", |line| {
        start(line);
        if line.target.kind != Kind::Station {
            for _ in 0..800 {
                line.control(MASTER, &[0x28, 0]);
                line.exchange(1);
            }
            line.control(MASTER, &[0x14, 0]);
        }
    }),
    ("a silent line", "a master that is switched off over night", |line| line.wait(Duration::from_secs(120))),
    ("a slow master without watchdog", "masters in software; pyprofibus without watchdog", |line| {
        start(line);
        for _ in 0..20 {
            line.exchange(1);
            line.wait(Duration::from_secs(1));
        }
    }),
    (
        "a request that is repeated because its reply was lost",
        "IEC 61158-4-3, retries with the same frame count bit",
        |line| {
            start(line);
            line.exchange(3);
            line.repeat();
            line.exchange(3);
        },
    ),
    ("the diagnosis in each cycle", "class 1 masters that show the diagnosis to their program", |line| {
        start(line);
        for _ in 0..100 {
            line.exchange(1);
            line.ask(MASTER, Service::SlaveDiag, &[]);
        }
    }),
    ("Set_Prm in Data_Exchange", "IEC 61158-6-3, a master may parameterise again", |line| {
        start(line);
        line.exchange(5);
        start(line);
    }),
    (
        "a fault is acknowledged as the profile says",
        "profile PROFIDRIVE: bit 7 from 0 to 1, then OFF1",
        |line| {
            start(line);
            line.act(|device, now| device.make_nominal(now));
            match line.target.kind {
                Kind::Ag03 => words(line, &[(0x00BA, 0), (0x003A, 0), (0x003B, 0), (0x003A, 0)]),
                Kind::Ppo | Kind::Profidrive => {
                    words(line, &[(0x04FE, 0), (0x047E, 0), (0x047F, 0), (0x047E, 0)])
                }
                Kind::Station => {}
            }
        },
    ),
];

fn enable(bus: &mut nodes::Bus) {
    bus.nmt(1);
    if bus.target.drive {
        for word in [6, 7, 0xF] {
            bus.write(0x6040, 0, word, 2);
            bus.wait(CYCLE * 10);
        }
    }
}

const ON_BUS: &[OnBus] = &[
    ("reset, boot-up, start", "CiA 301, network start-up", |bus| {
        for command in [0x81, 0x82, 1, 0x80, 1] {
            bus.nmt(command);
            bus.wait(Duration::from_secs(1));
        }
    }),
    ("the state asked for once more", "masters that send NMT start until the heartbeat shows it", |bus| {
        (0..9).for_each(|_| bus.nmt(1))
    }),
    ("1000h and 1018h read", "CiA 302-2, identity check before the start", |bus| {
        for (index, sub) in [(0x00, 0), (0x18, 1), (0x18, 0), (0x01, 0)] {
            assert!(bus.sdo(&[0x40, index, 0x10, sub, 0, 0, 0, 0]).is_some_and(|reply| reply[0] != 0x80));
        }
    }),
    ("6, 7, Fh", "CiA 402-2, transitions 2, 3, 4", |bus| enable(bus)),
    ("set-points with bit 4 given and taken back", "CiA 402-2, hand shake of profile position", |bus| {
        enable(bus);
        // A drive of velocity only has no set-points.
        let positions = bus.target.drive && bus.target.name != "servo";
        if positions {
            bus.write(0x6060, 0, 1, 1);
            for target in [100, 200, 300] {
                bus.write(0x607A, 0, target, 4);
                for word in [0x1F, 0xF] {
                    bus.write(0x6040, 0, word, 2);
                    bus.wait(Duration::from_secs(3));
                }
            }
            bus.write(0x6040, 0, 6, 2);
        }
    }),
    ("heartbeat produced", "CiA 301, 1017h", |bus| {
        bus.write(0x1017, 0, 200, 2);
        bus.nmt(1);
        bus.wait(Duration::from_secs(5));
    }),
    ("SYNC and TIME on the bus", "CiA 301, objects for others", |bus| {
        bus.nmt(1);
        for _ in 0..100 {
            bus.send(&frame(0x80, &[]));
            bus.send(&frame(0x100, &[0; 6]));
        }
    }),
    ("heartbeats of others", "CiA 301, producers on the same bus", |bus| {
        (0..100).for_each(|_| _ = bus.send(&frame(0x701, &[5])))
    }),
    ("LSS of others: all to waiting, inquiries", "CiA 305, switch mode and inquiry", |bus| {
        for octets in
            [[0x04, 0, 0, 0, 0, 0, 0, 0], [0x5E, 0, 0, 0, 0, 0, 0, 0], [0x51, 0, 0, 0, 0x80, 0, 0, 0]]
        {
            bus.send(&frame(0x7E5, &octets));
        }
    }),
    ("process data and SDO of other nodes", "CiA 301, predefined connections of other nodes", |bus| {
        bus.nmt(1);
        for id in [0x182, 0x202, 0x282, 0x302, 0x582, 0x082, 0x702] {
            bus.send(&frame(id, &[0; 8]));
        }
    }),
    ("node guarding as it is configured", "CiA 301, 100Ch and 100Dh", |bus| {
        if bus.write(0x100C, 0, 100, 2).is_some_and(|reply| reply[0] == 0x60) {
            bus.write(0x100D, 0, 3, 1);
            bus.write(0x1017, 0, 0, 2);
            let remote = Frame::remote(Id::base(0x705).unwrap(), 1).unwrap();
            for _ in 0..50 {
                bus.send(&remote);
                bus.wait(Duration::from_millis(100));
            }
            bus.write(0x100C, 0, 0, 2);
            bus.write(0x100D, 0, 0, 1);
        } else {
            bus.take_news();
        }
    }),
    ("an aborted transfer that is begun again", "CiA 301, a client that repeats", |bus| {
        for _ in 0..2 {
            bus.sdo(&[0x40, 0x18, 0x10, 1, 0, 0, 0, 0]);
        }
    }),
    ("a silent bus", "a master that is switched off over night", |bus| bus.wait(Duration::from_secs(60))),
    ("frames of another protocol with 29 bits", "J1939 on the same bus", |bus| {
        for id in [0x18FE_F100, 0x0CF0_0400] {
            bus.send(&Frame::data(Id::extended(id).unwrap(), &[0; 8]).unwrap());
        }
    }),
    ("stop and start", "CiA 301, NMT", |bus| {
        for command in [1, 2, 1] {
            bus.nmt(command);
        }
    }),
    ("the status word polled by SDO", "masters without PDOs", |bus| {
        bus.nmt(1);
        if bus.target.drive {
            for _ in 0..200 {
                bus.sdo(&[0x40, 0x41, 0x60, 0, 0, 0, 0, 0]);
                bus.wait(CYCLE);
            }
        }
    }),
    (
        "a consumer of heartbeats before there is a producer",
        "CiA 302-2: 1016h is written before NMT start of the other",
        |bus| {
            if bus.write(0x1016, 1, 0x0001_01F4, 4).is_some_and(|reply| reply[0] == 0x60) {
                bus.nmt(1);
                bus.wait(Duration::from_secs(5));
                for _ in 0..20 {
                    bus.send(&frame(0x701, &[5]));
                    bus.wait(Duration::from_millis(200));
                }
                bus.write(0x1016, 1, 0, 4);
            } else {
                bus.take_news();
            }
        },
    ),
    ("an RPDO is mapped anew", "CiA 301: off, count 0, entries, count, on", |bus| {
        if bus.target.drive && bus.write(0x1400, 1, 0x8000_0205, 4).is_some_and(|reply| reply[0] == 0x60) {
            if bus.write(0x1600, 0, 0, 1).is_some_and(|reply| reply[0] == 0x60) {
                bus.write(0x1600, 1, 0x6040_0010, 4);
                bus.write(0x1600, 0, 1, 1);
            } else {
                // Its mapping cannot be changed, and it says so.
                bus.take_news();
            }
            bus.write(0x1400, 1, 0x205, 4);
        } else {
            bus.take_news();
        }
    }),
    ("start of all nodes", "CiA 301, NMT to node 0", |bus| {
        for command in [0x82, 1] {
            bus.send(&frame(0, &[command, 0]));
            bus.wait(Duration::from_secs(1));
        }
    }),
    ("another node produces SYNC", "CiA 301: one producer, everybody consumes", |bus| {
        bus.nmt(1);
        for _ in 0..100 {
            bus.send(&frame(0x80, &[]));
            bus.wait(CYCLE);
        }
    }),
];

/// What no correct master reads.
fn is_complaint(text: &str) -> bool {
    ["refused", "ignored", "hint", "no effect", "not followed", "expected", "expired", "missing", "warning"]
        .iter()
        .any(|word| text.contains(word))
}

#[test]
fn habits_of_correct_masters_give_no_refusal_and_no_hint() {
    let mut complaints = Vec::new();
    for target in slaves::TARGETS {
        for (habit, source, act) in ON_LINE {
            let mut line = Line::of(target);
            act(&mut line);
            line.wait(Duration::from_secs(3));
            let said = line.take_news().into_iter().filter(|text| is_complaint(text));
            complaints.extend(said.map(|text| format!("{}, {habit} ({source}): {text}", target.name)));
        }
    }
    for target in nodes::TARGETS {
        for (habit, source, act) in ON_BUS {
            let mut bus = nodes::Bus::of(target);
            act(&mut bus);
            bus.wait(Duration::from_secs(3));
            let said = bus.take_news().into_iter().filter(|text| is_complaint(text));
            complaints.extend(said.map(|text| format!("{}, {habit} ({source}): {text}", target.name)));
        }
    }
    assert!(ON_LINE.len() + ON_BUS.len() >= 30, "thirty habits");
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}
