//! The bench finds five mistakes of a naive master.
mod naive;
use core::time::Duration;
use naive::{Mistake, Naive};
use profidrive::bench::{Line, Passed, Request};
use profidrive::devices::ag03::profibus::Config;
use profidrive::profibus::dp::{Description, Fixed, Service, Station};
use profidrive::profibus::fdl::Address;
use profidrive::time::BaudRate;
use std::panic::catch_unwind;
const SECOND: Duration = Duration::from_secs(1);
fn exchange_with_5(line: &mut Line<Naive>) -> Vec<u8> {
    let mut sent = Vec::new();
    while line.poll_telegram().is_some() {}
    line.must(SECOND, "Data_Exchange with station 5", |line| {
        sent.extend(line.poll_telegram().filter(to_5).map(|passed| passed.octets));
        !sent.is_empty()
    });
    sent.remove(0)
}

fn to_5(passed: &Passed) -> bool {
    let exchange = |Request { to, service, .. }| to.number() == 5 && service == Some(Service::DataExchange);
    passed.request().is_some_and(exchange)
}

fn conforms(mistake: Option<Mistake>) {
    let mut line = Line::with(BaudRate::K1500, Naive::new(mistake));
    line.add_drive(Config::new(Address::from_octet(5))).unwrap();
    let io = Description { ident: 0x1234, ..Description::PLAIN };
    let cfg = Fixed { configurations: &[&[0x23, 0x13]], ..Fixed::PLAIN };
    line.add(Station::new(Address::from_octet(6), line.baud(), Some(60), io, cfg)).unwrap();
    line.inject(&["not-ready=20ms,station=5".parse().unwrap()]).unwrap();
    line.never(SECOND / 60, "Data_Exchange to a station that is not ready", to_5);
    line.must(SECOND, "both exchange data", |line| line.master.exchanges.iter().all(|count| *count > 9));
    line.assert_no_breach();
    for (fault, rule) in [
        ("no-reply,at=1,station=5", "a request without reply is repeated as it was"),
        ("wrong-fcs,at=1,station=5", "a reply with a wrong FCS is no reply"),
    ] {
        let request = exchange_with_5(&mut line);
        line.inject(&[fault.parse().unwrap()]).unwrap();
        let retry = exchange_with_5(&mut line);
        line.check(request == retry, rule);
    }
    line.inject(&["lose-prm,at=3,station=6".parse().unwrap()]).unwrap();
    line.run_for(SECOND / 50);
    line.master.exchanges = [0; 2];
    line.must(SECOND, "station 6 is started again", |line| line.master.exchanges[1] > 0);
}

#[test]
fn five_mistakes_are_found_and_nothing_else() {
    conforms(None);
    for (mistake, says) in naive::MISTAKES {
        let panic = catch_unwind(|| conforms(Some(mistake))).expect_err("a mistake is found");
        let message = *panic.downcast::<String>().unwrap();
        assert!(message.contains(says) && message.contains("2 -> 5"), "{mistake:?}: {message}");
    }
}
