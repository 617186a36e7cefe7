use super::*;

#[test]
fn a_fault_is_written_as_it_is_meant() {
    let late = |millis| Kind::Late(Duration::from_millis(millis));
    for (spec, expected) in [
        ("no-reply", Fault::always(Kind::NoReply)),
        ("no-reply,rate=0.01,seed=7", Fault { rate: 0.01, seed: 7, ..Fault::always(Kind::NoReply) }),
        ("late=20ms,at=100", Fault::once(late(20), 100)),
        ("late=1s,at=100,rate=0.5", Fault { at: 100, rate: 0.5, ..Fault::always(late(1000)) }),
        ("wrong-fcs,count=3", Fault { count: Some(3), ..Fault::always(Kind::WrongFcs) }),
        ("noise=7,count=3,at=9", Fault { count: Some(3), at: 9, ..Fault::always(Kind::Noise(7)) }),
        ("bit-errors", Fault::always(Kind::BitErrors(1))),
        ("pkw-torn,at=1", Fault::once(Kind::Pkw(PkwFault::Torn), 1)),
        (
            "late=3ms,station=6,service=Chk_Cfg,retry=2",
            Fault {
                station: Address::station(6).ok(),
                service: Some(Service::ChkCfg),
                retry: Some(2),
                ..Fault::always(late(3))
            },
        ),
        (
            "wrong-source=9,state=DATA-EXCH",
            Fault {
                state: Some(State::DataExch),
                ..Fault::always(Kind::WrongSource(Address::station(9).ok()))
            },
        ),
        ("lose-prm,station=5", Fault { station: Address::station(5).ok(), ..Fault::always(Kind::LosePrm) }),
    ] {
        let fault: Fault = spec.parse().unwrap();
        assert_eq!(fault, expected, "{spec}");
        // A lone `at=1` reads back as `count=1`, which is the same.
        assert_eq!(fault.to_string().parse(), Ok(fault), "{spec} as {fault}");
    }
}

#[test]
fn every_fault_of_the_list_is_understood_and_reads_back() {
    for form in KINDS.replace(" or ", ", ").split(", ") {
        let spec = form
            .trim()
            .replace("[=N]", "")
            .replace("[=ADDRESS]", "")
            .replace("TIME", "20ms")
            .replace("HH", "1A")
            .replace("PART", "end")
            .replace("OCTETS", "02..0C")
            .replace("=N", "=3");
        let fault: Fault = spec.parse().unwrap();
        assert_eq!(fault.to_string().parse(), Ok(fault), "{spec}");
    }
}

#[test]
fn a_fault_for_a_station_that_is_not_there_is_refused() {
    let address = |number| Address::station(number).unwrap();
    let fault: Fault = "no-reply,station=6".parse().unwrap();
    assert_eq!(fault.check([address(5), address(6)]), Ok(()));
    let told = |there: &[u8]| fault.check(there.iter().copied().map(address)).unwrap_err().to_string();
    assert_eq!(
        told(&[5, 7]),
        "fault 'no-reply,station=6' is for station 6, which is not on the line; expected one of 5, 7"
    );
    assert!(told(&[5]).ends_with("expected station 5"));
    assert_eq!("no-reply".parse::<Fault>().unwrap().check([]), Ok(()));
}

#[test]
fn the_lists_of_the_messages_name_everything() {
    assert!(Service::ALL.iter().all(|service| SERVICES.contains(service.name())));
    assert!(State::ALL.into_iter().all(|state| STATES.contains(state.name())));
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
    ] {
        let error = spec.parse::<Fault>().unwrap_err().to_string();
        assert!(error.contains(part), "{spec}: {error}");
    }
}
