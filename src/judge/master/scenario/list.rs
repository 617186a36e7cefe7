//! The scenarios of the judge itself, those that a master survives most easily first.

use core::time::Duration;

use super::{Act, Check, Need, Scenario, Step, Which, acyclic};
use crate::judge::master::rows::Row;
use crate::judge::master::setup::Setup;

fn step(act: Option<Act>, faults: &[&str], millis: u64) -> Step {
    let faults: Vec<_> = faults.iter().map(ToString::to_string).collect();
    Step { act, faults, lasts: Duration::from_millis(millis), ..Step::default() }
}

/// A step that lasts so many cycles of the master, and so long at least.
fn cycles(act: Option<Act>, faults: &[&str], cycles: u32, millis: u64) -> Step {
    Step { cycles, ..step(act, faults, millis) }
}

/// A diagnosis has gone: the master reads that.
fn gone() -> Step {
    cycles(Some(Act::DiagnosisGone), &[], GONE, 100)
}

/// Cycles until a diagnosis that was announced is read and the data exchange behind it was seen.
const READ: u32 = 30;
/// Cycles until the end of a diagnosis is read.
const GONE: u32 = 15;
/// Cycles until a start-up that a diagnosis asks for has begun, and is over.
const RESTARTED: u32 = 40;
/// A station that joins late was asked so often before.
const ASKED: u32 = 60;
/// A start-up has come to Chk_Cfg in so many cycles.
const STARTED: u32 = 10;
/// A station is not ready for so many cycles.
const NOT_READY: u32 = 24;
/// Cycles at least with random errors.
const RANDOM: u32 = 240;

/// Every scenario that the rows need.
pub fn built_in(setup: &Setup) -> Vec<Scenario> {
    let mut list = vec![joins_late(setup)];
    list.extend(start_ups(setup).into_iter().take(1));
    list.extend(lost_replies());
    list.extend(bad_replies(setup));
    list.extend(waiting());
    list.extend(diagnoses());
    list.extend(losses(setup));
    list.extend(setup.auto_clear.map(partial_return));
    list.extend(start_ups(setup).into_iter().skip(1));
    list.extend(persistent_replies(setup));
    list.extend(negative_replies());
    list.push(random_errors());
    list
}

/// So many cycles, of which nothing is known but that each waits a slot time for every absent station and for one more.
fn millis_of(setup: &Setup, cycles: u32, limits: core::ops::RangeInclusive<u64>) -> u64 {
    let absent = setup.stations.iter().filter(|slave| slave.absent).count();
    let slot = super::SLOT.min(setup.slot.unwrap_or(Duration::ZERO));
    let cycle = slot * u32::try_from(absent + 1).unwrap_or(1);
    let millis = u64::try_from((cycle * cycles).as_millis()).unwrap_or(u64::MAX);
    millis.clamp(*limits.start(), *limits.end())
}

/// A station that is switched on when the master runs already.
fn joins_late(setup: &Setup) -> Scenario {
    let millis = millis_of(setup, ASKED, 5000..=15_000);
    Scenario {
        station: Which::Last,
        steps: vec![step(None, &["drop-request,station=S"], millis)],
        returns: vec![Row::L09, Row::B04],
        ..Scenario::one("the last station is switched on late", &[Row::L09, Row::B04], &[])
    }
}

fn lost_replies() -> Vec<Scenario> {
    let one = |name: &str, rows: &[Row], fault: &str| Scenario::one(name, rows, &[fault]);
    let mut list = Vec::new();
    for number in ["first", "second", "third"] {
        list.push(one(
            &format!("a reply to Data_Exchange is lost ({number})"),
            &[Row::C03, Row::C04, Row::C05, Row::L08],
            "no-reply,count=1,station=S,service=Data_Exchange",
        ));
    }
    for service in ["Slave_Diag", "Set_Prm", "Chk_Cfg"] {
        let lost = format!("no-reply,count=1,station=S,service={service}");
        list.push(Scenario::one(
            &format!("a reply to {service} is lost in a start-up"),
            &[Row::C03, Row::C04, Row::C11, Row::U09],
            &["lose-prm,count=1,station=S", &lost],
        ));
    }
    list
}

/// One wrong reply to Data_Exchange each.
fn bad_replies(setup: &Setup) -> Vec<Scenario> {
    let data = |kind: &str| format!("{kind},count=1,station=S,service=Data_Exchange");
    let one = |name: &str, row: Row, kind: &str| Scenario {
        rows: if row == Row::E01 { vec![row, Row::C12] } else { vec![row] },
        ..Scenario::one(name, &[row], &[&data(kind)])
    };
    let free = (1..126_u8).find(|number| {
        setup.stations.iter().all(|slave| slave.address.number() != *number)
            && setup.master.is_none_or(|master| master.number() != *number)
            && *number > 90
    });
    let stranger = free.unwrap_or(125);
    let mut list = vec![
        one("wrong FCS", Row::E01, "wrong-fcs"),
        one("wrong FCS again", Row::E01, "wrong-fcs"),
        one("a truncated reply", Row::E02, "truncated,seed=5"),
        one("another truncated reply", Row::E02, "truncated,seed=9"),
        one("a reply with the address of another station", Row::E05, &format!("wrong-source={stranger}")),
        one("a reply to another master", Row::E05, &format!("wrong-destination={stranger}")),
        one("a reply with the request bit", Row::E13, "function-code=48"),
        one("a reply of a master", Row::E13, "function-code=38"),
        one("a reply with LE not LEr", Row::E15, "broken-frame=repeated"),
        one("a reply with LE 3", Row::E15, "broken-frame=length"),
        one("a reply with a wrong second start delimiter", Row::E15, "broken-frame=start"),
        one("a reply with a wrong end delimiter", Row::E15, "broken-frame=end"),
    ];
    for name in ["noise in front of a reply", "noise instead of a reply"] {
        let mut scenario = one(name, Row::E12, "noise=7");
        if name.contains("instead") {
            scenario.steps =
                vec![Step { faults: vec![data("noise=7"), data("no-reply")], ..scenario.steps.remove(0) }];
        }
        list.push(Scenario { returns: vec![Row::E12], ..scenario });
    }
    for (name, kind) in [
        ("Slave_Diag answered without SAPs", "no-saps"),
        ("Slave_Diag answered from another SAP", "wrong-saps"),
    ] {
        let fault = format!("{kind},count=1,station=S,service=Slave_Diag");
        let fault = Step { act: Some(Act::Diagnose), ..Scenario::one(name, &[], &[&fault]).steps.remove(0) };
        list.push(Scenario { steps: vec![fault, gone()], ..Scenario::one(name, &[Row::E14], &[]) });
    }
    list
}

/// Replies that come late: the next telegram shows what the master waits for.
fn waiting() -> Vec<Scenario> {
    let half = "late=0.5slot,count=12,station=S,service=Data_Exchange";
    let mut list = vec![Scenario {
        needs: vec![Need::Slot],
        holds: true,
        ..Scenario::one("replies after half the slot time", &[Row::T02, Row::T03], &[half])
    }];
    for number in ["first", "second", "third"] {
        list.push(Scenario {
            needs: vec![Need::Slot],
            holds: true,
            ..Scenario::one(
                &format!("a reply twice, the next one after half the slot time ({number})"),
                &[Row::E06],
                &[
                    "duplicate,at=1,count=1,station=S,service=Data_Exchange",
                    "late=0.5slot,at=2,count=1,station=S,service=Data_Exchange",
                ],
            )
        });
    }
    list.push(Scenario {
        needs: vec![Need::Slot, Need::Retries, Need::Other],
        holds: true,
        ..Scenario::one(
            "the reply of a lost cycle comes while another station is asked",
            &[Row::E10],
            &[
                "no-reply,count=RETRIES,station=S,service=Data_Exchange",
                // The first one that is not lost.
                "late=1.25slot,count=1,station=S,service=Data_Exchange",
                "late=0.5slot,count=6,station=O,service=Data_Exchange",
            ],
        )
    });
    list
}

/// Diagnoses while data are exchanged.
fn diagnoses() -> Vec<Scenario> {
    let told = |name: &str, row: &[Row], act: Act, faults: &[&str], lasts: u32| Scenario {
        steps: vec![cycles(Some(act), faults, lasts, 200), gone()],
        ..Scenario::one(name, row, &[])
    };
    let diag = |octets: &str| format!("diag={octets},count=1,station=S,service=Slave_Diag");
    // A master may read it again before it reacts.
    let twice = |octets: &str| format!("diag={octets},count=2,station=S,service=Slave_Diag");
    let overflow = Act::Diagnose;
    let mut list = vec![
        told(
            "a diagnosis, then its end",
            &[Row::D01, Row::D06, Row::D13, Row::D11],
            Act::Diagnose,
            &[],
            READ,
        ),
        told("a diagnosis of 244 octets", &[Row::D08], Act::LongDiagnosis, &[], READ),
        told("a diagnosis of 244 octets again", &[Row::D08], Act::LongDiagnosis, &[], READ),
        told("Ext_Diag_Overflow", &[Row::D09], overflow, &[&diag("....80")], READ),
        told("Ext_Diag_Overflow again", &[Row::D09], overflow, &[&diag("....80")], READ),
        told("Prm_Req while data are exchanged", &[Row::D02], Act::Diagnose, &[&twice("..0D")], RESTARTED),
        told(
            "Station_Not_Ready while data are exchanged",
            &[Row::D15],
            Act::Diagnose,
            &[&twice("020C")],
            RESTARTED,
        ),
        told(
            "no owner while data are exchanged",
            &[Row::D15],
            Act::Diagnose,
            &[&twice("......FF")],
            RESTARTED,
        ),
        told("bits that only masters set", &[Row::D16], Act::Diagnose, &[&diag("A18C")], READ),
    ];
    if let Some(scenario) = list.last_mut() {
        scenario.returns = vec![Row::D16];
    }
    list.push(Scenario {
        station: Which::OutputsOnly,
        ..told("a diagnosis of a station with outputs only", &[Row::D11], Act::Diagnose, &[], READ)
    });
    list.push(Scenario {
        others: Some((Row::D14, 3)),
        needs: vec![Need::Other],
        steps: vec![cycles(None, &["diag-announced,station=S"], 60, 1000)],
        ..Scenario::one("a diagnosis announced in every reply", &[Row::D14], &[])
    });
    list.push(Scenario {
        station: Which::EightInputs,
        ..Scenario::one("replies as SD3", &[Row::X07], &["sd3,count=10,station=S,service=Data_Exchange"])
    });
    list
}

/// Stations that are silent, reset or taken.
fn losses(setup: &Setup) -> Vec<Scenario> {
    let drop = "drop-request,station=S";
    let silent = setup
        .auto_clear
        .map_or(0, |time| u64::try_from(time.as_millis()).unwrap_or(u64::MAX))
        .saturating_mul(2);
    let lost = |millis| Step { until_lost: true, ..step(None, &[drop], millis) };
    vec![
        Scenario {
            steps: vec![lost(silent.max(3500)), step(Some(Act::PowerOn), &[], 50)],
            returns: vec![Row::L02],
            others: Some((Row::I02, 5)),
            asked: Some(Row::L06),
            ..Scenario::one(
                "a station is silent for some seconds and comes back after power-on",
                &[
                    Row::C06,
                    Row::C07,
                    Row::C08,
                    Row::C10,
                    Row::C11,
                    Row::L01,
                    Row::L02,
                    Row::L04,
                    Row::L06,
                    Row::I02,
                    Row::I03,
                    Row::I07,
                    Row::O07,
                    Row::O08,
                    Row::T04,
                ],
                &[],
            )
        },
        Scenario {
            steps: vec![lost(300)],
            returns: vec![Row::L07],
            ..Scenario::one(
                "a station is silent for a short time and keeps its state",
                &[Row::L07, Row::C08, Row::C10, Row::C11, Row::L04, Row::T04],
                &[],
            )
        },
        Scenario {
            steps: vec![lost(500), cycles(Some(Act::Take), &[], 40, 1200), step(Some(Act::Release), &[], 50)],
            returns: vec![Row::D07],
            ..Scenario::one("a silent station comes back with another owner", &[Row::D07], &[])
        },
        Scenario {
            steps: vec![cycles(Some(Act::Take), &[], 40, 1500), step(Some(Act::Release), &[], 50)],
            returns: vec![Row::L05],
            ..Scenario::one("another master takes a station", &[Row::L05], &[])
        },
    ]
}

/// Two stations are lost, and one of them comes back: too few for OPERATE.
fn partial_return(auto_clear: Duration) -> Scenario {
    let lost = auto_clear * 2;
    let silent = |faults: &[&str], least: u64, check| Step {
        lasts: lost.max(Duration::from_millis(least)),
        until_lost: true,
        check: Some(check),
        ..step(None, faults, 0)
    };
    let (one, other) = ("drop-request,station=S", "drop-request,station=O");
    Scenario {
        needs: vec![Need::Other],
        steps: vec![silent(&[one, other], 500, Check::AutoClear), silent(&[other], 1000, Check::StaysClear)],
        ..Scenario::one("two stations are silent, and one of them comes back", &[Row::O09], &[])
    }
}

/// What may go wrong in a start-up. Each begins with a slave that has lost its parameters.
fn start_ups(setup: &Setup) -> Vec<Scenario> {
    let lose = "lose-prm,count=1,station=S";
    let once = |name: &str, rows: &[Row], faults: &[&str]| {
        let faults: Vec<&str> = core::iter::once(lose).chain(faults.iter().copied()).collect();
        Scenario { returns: rows.to_vec(), ..Scenario::one(name, rows, &faults) }
    };
    let lasting = |name: &str, rows: &[Row], faults: &[&str], millis: u64| {
        let mut scenario = once(name, rows, faults);
        for step in &mut scenario.steps {
            step.until_injected = false;
            step.until_lost = true;
            step.more_cycles = STARTED;
            step.lasts = Duration::from_millis(millis);
        }
        scenario
    };
    let diag = "station=S,service=Slave_Diag,state=DATA-EXCH";
    let not_ready = millis_of(setup, NOT_READY, 1500..=6000);
    let mut list = vec![
        once("a slave loses its parameters", &[Row::L03, Row::E07], &[]),
        Scenario {
            others: Some((Row::I05, 3)),
            ..lasting(
                "a slave is not ready for a while",
                &[Row::U05, Row::U06, Row::I05],
                &[&format!("not-ready={not_ready}ms,count=1,station=S")],
                not_ready + 200,
            )
        },
        once("Stat_Diag for six diagnoses", &[Row::D03], &[&format!("diag=000E,count=6,{diag}")]),
        once("a diagnosis of four octets", &[Row::D12], &[&format!("diag-length=4,count=3,{diag}")]),
        once("Not_Supported", &[Row::D10], &[&format!("diag=10,count=1,{diag}")]),
        once("Set_Prm is refused three times", &[Row::D04], &["refuse-prm,count=3,station=S"]),
        once("Chk_Cfg is refused three times", &[Row::D05], &["refuse-cfg,count=3,station=S"]),
        once("RS to Set_Prm", &[Row::U08], &["reject,count=1,station=S,service=Set_Prm"]),
        once("RS to Chk_Cfg", &[Row::U08], &["reject,count=1,station=S,service=Chk_Cfg"]),
        lasting("Set_Prm is not answered", &[Row::U09], &["drop-request,station=S,service=Set_Prm"], 800),
        lasting("Chk_Cfg is not answered", &[Row::U09], &["drop-request,station=S,service=Chk_Cfg"], 800),
        Scenario {
            returns: Vec::new(),
            ..lasting("another ident number", &[Row::U07], &[&format!("diag=........5AA5,{diag}")], 600)
        },
    ];
    for number in 1..=10 {
        list.push(once(
            &format!("start-up {number} of ten"),
            &[Row::U01, Row::U02, Row::U03, Row::U04, Row::U11, Row::P12],
            &[],
        ));
    }
    // Their rows are judged by what is seen; only the tenth start-up itself is about coming back.
    for scenario in &mut list {
        if scenario.rows.contains(&Row::U11) {
            scenario.returns = vec![Row::U11];
        }
        scenario.returns.retain(|row| !matches!(row, Row::U05 | Row::U06 | Row::I05 | Row::D12));
    }
    list
}

/// Replies that cannot be right, one after the other.
fn persistent_replies(setup: &Setup) -> Vec<Scenario> {
    let probe = Scenario::one("", &[], &[]);
    let inputs = probe.subject(setup).and_then(|slave| slave.lengths()).map_or(1, |lengths| lengths.inputs);
    let lasting = |name: &str, row: Row, fault: &str| Scenario {
        needs: vec![Need::Inputs],
        steps: vec![cycles(None, &[fault], 20, 1700)],
        returns: vec![row],
        ..Scenario::one(name, &[row], &[])
    };
    let length = |name: &str, inputs: u8| {
        lasting(name, Row::E04, &format!("input-length={inputs},station=S,service=Data_Exchange"))
    };
    let mut list =
        vec![lasting("SC in place of inputs", Row::E03, "short-ack,station=S,service=Data_Exchange")];
    if inputs < 244 {
        list.push(length("more inputs than configured", inputs + 1));
    }
    if inputs > 1 {
        list.push(length("fewer inputs than configured", inputs - 1));
    }
    list.push(Scenario {
        steps: vec![step(None, &["noise=255", "no-reply"], 2000)],
        returns: vec![Row::E16],
        ..Scenario::one("noise for two seconds", &[Row::E16], &[])
    });
    list
}

/// Negative replies, by which some masters end.
fn negative_replies() -> Vec<Scenario> {
    [
        ("UE", Row::E08, "01"),
        ("RR", Row::E08, "02"),
        ("NR", Row::E08, "09"),
        ("RDL", Row::E09, "0C"),
        ("RDH", Row::E09, "0D"),
    ]
    .into_iter()
    .map(|(name, row, code)| Scenario {
        returns: vec![row],
        ..Scenario::one(
            &format!("{name} to Data_Exchange"),
            &[row],
            &[&format!("function-code={code},count=1,station=S,service=Data_Exchange")],
        )
    })
    .collect()
}

/// What needs somebody who operates the master.
pub fn asking(setup: &Setup) -> Vec<Scenario> {
    let ask = |name: &str, rows: &[Row], action: &str, check: Option<Check>, millis: u64| Scenario {
        steps: vec![Step { ask: Some(action.into()), check, ..step(None, &[], millis) }],
        ..Scenario::one(name, rows, &[])
    };
    let mut list = Vec::new();
    let mut wanted = Vec::new();
    for (number, slave) in (0_u8..).zip(setup.present()) {
        let outputs = slave.lengths().map_or(0, |lengths| lengths.outputs);
        if outputs == 0 {
            continue;
        }
        let octets: Vec<u8> = (0..outputs).map(|octet| octet ^ 0xA5 ^ (number << 4)).collect();
        let hex: Vec<_> = octets.iter().map(|octet| format!("{octet:02X}")).collect();
        wanted.push((slave.address, octets));
        let action = format!("outputs {} {}", slave.address, hex.concat());
        let check = Some(Check::Outputs(wanted.clone()));
        list.push(ask("outputs of the user", &[Row::X04, Row::O10], &action, check, 1000));
    }
    list.push(ask("CLEAR", &[Row::O02, Row::O03, Row::O06, Row::O10], "clear", Some(Check::Clear), 1500));
    list.push(ask("OPERATE", &[Row::O10], "operate", Some(Check::Operate), 1500));
    for (action, wanted, undo) in
        [("sync", 0x20, 0x10), ("unsync", 0x10, 0x20), ("freeze", 0x08, 0x04), ("unfreeze", 0x04, 0x08)]
    {
        let groups = setup.present().find_map(|slave| slave.groups).unwrap_or(1);
        let check = Some(Check::Command { wanted, undo, groups });
        let action = format!("{action} {groups:02X}");
        list.push(ask(&action, &[Row::S01, Row::S02, Row::S03], &action, check, 1000));
    }
    list.extend(
        setup.present().find(|slave| setup.has_services(slave)).map(acyclic::asked).into_iter().flatten(),
    );
    let mut stop = ask("STOP", &[Row::Z01, Row::Z02, Row::Z03, Row::O11], "stop", Some(Check::Stop), 2500);
    let operate = Step { ask: Some("operate".into()), check: Some(Check::Operate), ..step(None, &[], 1000) };
    stop.rows.insert(0, Row::Z04);
    stop.rows.push(Row::O12);
    stop.steps.push(operate);
    list.push(stop);
    list.push(Scenario {
        returns: vec![Row::Z06],
        ..ask("a restart of the master", &[Row::Z04, Row::Z06], "restart", Some(Check::Begun), 3000)
    });
    list
}

/// A little of everything, at random.
fn random_errors() -> Scenario {
    let faults = [
        "bit-errors,rate=0.006,seed=11",
        "no-reply,rate=0.0015,seed=12",
        "truncated,rate=0.0015,seed=13",
        "drop-request,rate=0.001,seed=14",
    ];
    Scenario {
        steps: vec![cycles(None, &faults, RANDOM, 5000)],
        returns: vec![Row::E17],
        ..Scenario::one("one per cent of random errors", &[Row::E17], &[])
    }
}
