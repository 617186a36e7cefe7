use core::time::Duration;

use super::*;
use crate::can_bus::canopen::faults::SdoFault;
use crate::host::link::fault::{PkwFault, ReplyFault, RequestFault, ShapeFault};

fn rule(kind: Kind, when: When, whom: Whom) -> Rule {
    Rule { kind, when, while_input: None, whom }
}

#[test]
fn a_fault_is_written_as_it_is_meant() {
    let late = |millis| Kind::Reply(ReplyFault::Late(Duration::from_millis(millis)));
    let (always, once, all) = (When::ALWAYS, When::once, Whom::default());
    let reply = Kind::Reply;
    for (spec, expected) in [
        ("no-reply", rule(reply(ReplyFault::Lost), always, all)),
        (
            "no-reply,rate=0.01,seed=7",
            rule(reply(ReplyFault::Lost), When { rate: 0.01, seed: 7, ..always }, all),
        ),
        ("late=20ms,at=100", rule(late(20), once(100), all)),
        ("late=1s,at=100,rate=0.5", rule(late(1000), When { at: 100, rate: 0.5, ..always }, all)),
        (
            "wrong-fcs,count=3",
            rule(reply(ReplyFault::Shape(ShapeFault::WrongFcs)), When { count: Some(3), ..always }, all),
        ),
        (
            "noise=7,count=3,at=9",
            rule(reply(ReplyFault::Noise(7)), When { at: 9, count: Some(3), ..always }, all),
        ),
        ("bit-errors", rule(reply(ReplyFault::BitErrors(1)), always, all)),
        ("pkw-torn,at=1", rule(reply(ReplyFault::Pkw(PkwFault::Torn)), once(1), all)),
        (
            "late=3ms,station=6,service=Chk_Cfg,retry=2",
            rule(
                late(3),
                always,
                Whom { station: Some(6), service: Some(Service::ChkCfg), retry: Some(2), ..all },
            ),
        ),
        (
            "wrong-source=9,state=DATA-EXCH",
            rule(
                reply(ReplyFault::Shape(ShapeFault::WrongSource(Address::station(9).ok()))),
                always,
                Whom { state: Some(State::DataExch), ..all },
            ),
        ),
        (
            "lose-prm,node=5",
            rule(Kind::Request(RequestFault::LosePrm), always, Whom { station: Some(5), ..all }),
        ),
        (
            "sdo-lost,station=5,from=2s,until=3s",
            rule(
                Kind::Node(crate::can_bus::canopen::faults::Kind::Sdo(SdoFault::Lost)),
                When { from: Duration::from_secs(2), until: Some(Duration::from_secs(3)), ..always },
                Whom { station: Some(5), ..all },
            ),
        ),
    ] {
        let fault: Rule = spec.parse().unwrap();
        assert_eq!(fault, expected, "{spec}");
        // A lone `at=1` reads back as `count=1`, which is the same.
        assert_eq!(fault.to_string().parse(), Ok(fault), "{spec} as {fault}");
    }
}

#[test]
fn every_fault_of_the_list_is_understood_and_reads_back() {
    for row in Row::all() {
        let spec = row
            .to_string()
            .replace("[=N]", "")
            .replace("[=ADDRESS]", "")
            .replace("TIME", "20ms")
            .replace("HH", "1A")
            .replace("PART", "end")
            .replace("OCTETS", "02..0C")
            .replace("CODE", "06090011")
            .replace("=N", "=3");
        let fault = Rule::on(row.way.bus(), &spec).unwrap();
        assert_eq!(fault.kind.way(), row.way);
        assert_eq!(fault.to_string().parse(), Ok(fault), "{spec}");
        assert!(fault.to_string().starts_with(&spec), "{spec}: {fault}");
    }
    for spec in [
        "sdo-lost,rate=0.5,count=3,at=7,seed=2,node=5",
        "frame-lost,node=5,id=185",
        "frame-damaged,count=32,id=00000185",
        "sdo-lost,count=1,at=9",
        "no-reply,station=5,from=10s,until=20s,while=7/1/0/bit0=1",
        "no-reply,while=7/2/3/signed16>-5.5",
    ] {
        assert_eq!(spec.parse::<Rule>().unwrap().to_string(), spec);
    }
}

/// docs/faults.md has a row for each fault, with the words of the table.
#[test]
fn a_name_of_before_is_read_and_written_as_it_is_now() {
    for (before, now) in
        [("diag-storm,count=3", "diag-announced,count=3"), ("emcy-storm=20ms", "emcy-repeated=20ms")]
    {
        assert_eq!(before.parse::<Rule>().unwrap().to_string(), now);
    }
}

#[test]
fn the_document_has_every_fault_as_the_table_has_it() {
    let document = include_str!("../../../docs/faults.md");
    let documented: Vec<&str> = document.lines().filter(|line| line.starts_with("| `")).collect();
    for row in Row::all() {
        let line = format!("| `{row}` | {} | {} |", row.occasion, row.effect);
        assert!(documented.contains(&&*line), "docs/faults.md lacks: {line}");
    }
    for bus in [BusKind::Profibus, BusKind::Can] {
        assert!(document.contains(&format!("    {}\n", bus.form())), "{}", bus.form());
    }
}

#[test]
fn a_fault_for_a_station_that_is_not_there_is_refused() {
    let fault: Rule = "no-reply,station=6".parse().unwrap();
    assert_eq!(fault.check([5, 6]), Ok(()));
    let told = |there: &[u8]| fault.check(there.iter().copied()).unwrap_err().to_string();
    assert_eq!(
        told(&[5, 7]),
        "fault 'no-reply,station=6' is for station 6, which is not on the line; expected one of 5, 7"
    );
    assert!(told(&[5]).ends_with("expected station 5"));
    assert_eq!("no-reply".parse::<Rule>().unwrap().check([]), Ok(()));
}

#[test]
fn a_wrong_fault_is_answered_with_the_wrong_part() {
    for (spec, part) in [
        ("", "'' is no fault; expected no-reply, late=TIME"),
        ("never", "'never' is no fault"),
        ("late", "late has no value; expected a time such as 20ms"),
        ("late=20", "'20' does not fit late"),
        ("late=0ms", "does not fit late"),
        ("late=3601s", "does not fit late"),
        ("late=99999999999999999999s", "does not fit late"),
        ("no-reply=1", "'1' does not fit no-reply; expected no value"),
        ("noise=256", "'256' does not fit noise; expected a number, 1 to 255"),
        ("pkw-delay", "pkw-delay has no value"),
        ("function-code=1", "'1' does not fit function-code; expected an octet in hex"),
        ("input-length=245", "'245' does not fit input-length; expected a number of octets, 0 to 244"),
        ("broken-frame=middle", "'middle' does not fit broken-frame; expected length, repeated"),
        ("diag=....", "'....' does not fit diag; expected 1 to 6 octets in hex"),
        ("diag=020C0000FF123456", "does not fit diag"),
        ("no-reply,rate=0", "'0' does not fit rate; expected a probability above 0 and up to 1"),
        ("no-reply,rate=1.5", "does not fit rate"),
        ("no-reply,rate=nan", "does not fit rate"),
        ("no-reply,rate=1e-3", "does not fit rate"),
        ("no-reply,count=0", "'0' does not fit count; expected a number, 1 or more"),
        ("no-reply,at", "at has no value"),
        ("no-reply,seed=-1", "'-1' does not fit seed"),
        ("no-reply,station=127", "'127' does not fit station; expected an address, 0 to 126"),
        ("wrong-source=127", "'127' does not fit wrong-source; expected an address, 0 to 126"),
        ("no-reply,service=Check", "'Check' does not fit service; expected Set_Slave_Add, RD_Inp"),
        ("no-reply,state=ready", "'ready' does not fit state; expected WAIT-PRM, WAIT-CFG or DATA-EXCH"),
        ("no-reply,retry=-1", "'-1' does not fit retry; expected a number, 0 for the request itself"),
        ("no-reply,often", "'often' is unknown; expected FAULT[=VALUE][,rate=P]"),
        ("no-reply,", "'' is unknown"),
        ("no-reply,at=1,at=2", "'at' is given twice"),
        ("no-reply,id=585", "'id=585' is unknown"),
        ("no-reply,from=2s,until=1s", "until must be later than from"),
        ("no-reply,while=7/1/bit0=1", "'7/1/bit0=1' does not fit while; expected an input of a station"),
        ("sdo-lost", "'sdo-lost' is no fault; expected no-reply"),
    ] {
        let error = Rule::on(BusKind::Profibus, spec).unwrap_err().to_string();
        assert!(error.contains(part), "{spec}: {error}");
    }
}

#[test]
fn a_wrong_fault_of_a_node_is_answered_with_the_wrong_part() {
    for (spec, says) in [
        ("no-reply", "'no-reply' is no fault of a node; expected boot-up-missing, "),
        ("sdo-late", "sdo-late has no value; expected a time"),
        ("sdo-late=0ms", "'0ms' does not fit sdo-late"),
        ("sdo-lost=1", "'1' does not fit sdo-lost; expected no value"),
        ("sdo-abort=060900111", "does not fit sdo-abort"),
        ("heartbeat-stuck=100", "does not fit heartbeat-stuck"),
        ("sdo-lost,node=0", "'0' does not fit node; expected a node number"),
        ("sdo-lost,rate=0", "'0' does not fit rate; expected a probability"),
        ("sdo-lost,count=1,count=2", "'count' is given twice"),
        ("sdo-lost,node=1,node=2", "'node' is given twice"),
        ("sdo-lost,service=Chk_Cfg", "'service=Chk_Cfg' is unknown; expected FAULT"),
        ("sdo-lost,while=7/1/0/bit0=1", "is unknown; expected FAULT"),
        ("sdo-lost,id=585", "id is only for faults of frames"),
        ("frame-lost,id=800", "'800' does not fit id; expected three hexadecimal digits"),
        ("frame-lost,id=+85", "does not fit id"),
        ("", "'' is no fault of a node"),
    ] {
        let error = Rule::on(BusKind::Can, spec).unwrap_err().to_string();
        assert!(error.contains(says), "{spec}: {error}");
    }
}
