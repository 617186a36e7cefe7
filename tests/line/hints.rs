//! What is odd on a line is said once, and nothing is said of a line that is in order.

use core::time::Duration;

use profidrive::devices::ag03::profibus::{Config, Device};
use profidrive::host::{Bus, BusEvent};
use profidrive::profibus::fdl::{Address, FrameCount, FunctionCode, ReplyStatus, Service};
use profidrive::time::Instant;

use crate::telegrams::telegram;

/// Time passes from one telegram to the next.
const CYCLE: Duration = Duration::from_millis(10);

pub(crate) struct Line {
    pub(crate) bus: Bus,
    pub(crate) now: Instant,
}

impl Line {
    pub(crate) fn with(addresses: &[u8]) -> Self {
        let mut bus = Bus::new();
        for number in addresses {
            bus.add(Device::new(Config::new(Address::station(*number).unwrap()), Instant::ZERO)).unwrap();
        }
        Self { bus, now: Instant::ZERO }
    }

    pub(crate) fn hear(&mut self, octets: &[u8]) {
        self.now = self.now.saturating_add(CYCLE);
        self.bus.handle_timeout(self.now);
        self.bus.handle_bytes(self.now, octets);
        let mut buf = [0; 255];
        while let Some(due) = self.bus.poll_timeout().filter(|due| *due < self.now.saturating_add(CYCLE)) {
            self.bus.handle_timeout(due);
            let _reply = self.bus.poll_transmit(due, &mut buf);
        }
    }

    /// Octets that are no telegram, and a pause behind them.
    pub(crate) fn hear_noise(&mut self, octet: u8) {
        self.hear(&[octet; 3]);
        self.bus.handle_broken_off(self.now);
        self.now = self.now.saturating_add(Duration::from_secs(1));
    }

    /// A request of `master` to station `da` by this service.
    pub(crate) fn ask(&mut self, master: u8, da: u8, service: Service, dsap: Option<u8>) {
        self.hear(&telegram(da, master, FunctionCode::request(service, FrameCount::First), dsap, &[]));
    }

    /// A request of `master` with data to station `da`.
    pub(crate) fn send(&mut self, master: u8, da: u8, dsap: Option<u8>, data: &[u8]) {
        let function = FunctionCode::request(Service::SrdHigh, FrameCount::First);
        self.hear(&telegram(da, master, function, dsap, data));
    }

    /// A Global_Control to all.
    pub(crate) fn control(&mut self, master: u8, data: &[u8]) {
        let function = FunctionCode::request(Service::SdnHigh, FrameCount::Unused);
        self.hear(&telegram(127, master, function, Some(58), data));
    }

    /// What has happened, without detail.
    pub(crate) fn texts(&mut self) -> Vec<String> {
        let news = core::iter::from_fn(|| self.bus.poll_event());
        news.filter(|event| !event.is_detail()).map(|event| event.to_string()).collect()
    }

    pub(crate) fn hints(&mut self) -> Vec<String> {
        let news = core::iter::from_fn(|| self.bus.poll_event());
        news.filter(|event| matches!(event, BusEvent::Hint(_))).map(|event| event.to_string()).collect()
    }
}

#[test]
fn requests_to_an_address_where_nobody_is_are_said_with_who_is_there() {
    let mut line = Line::with(&[5, 7, 8, 9]);
    for _ in 0..15 {
        line.ask(2, 5, Service::SrdHigh, Some(60));
        line.ask(2, 6, Service::SrdHigh, Some(60));
    }
    let text = "hint: master 2 asks for station 6, which is not on the line; on the line: 5, 7 to 9; change the address in the \
                master's project or that of the station";
    assert_eq!(line.hints(), [text]);
    for _ in 0..3 {
        line.ask(2, 4, Service::SrdLow, None);
    }
    assert_eq!(line.hints().len(), 1, "another address");
    line.now = line.now.saturating_add(Duration::from_secs(60));
    for _ in 0..3 {
        line.ask(2, 6, Service::SrdHigh, Some(60));
    }
    assert_eq!(line.hints(), [text], "again after a minute");
}

#[test]
fn a_master_that_looks_around_or_asks_a_station_of_others_is_no_hint() {
    let mut line = Line::with(&[5]);
    for _ in 0..5 {
        // The GAP.
        for da in (0..126).filter(|da| *da != 5) {
            line.ask(2, da, Service::FdlStatus, None);
        }
        // A scan: each address once or twice.
        for da in (0..126).filter(|da| *da != 5) {
            line.ask(2, da, Service::SrdHigh, Some(60));
            line.ask(2, da, Service::SrdHigh, Some(60));
        }
        // Another station of the line.
        line.ask(2, 6, Service::SrdHigh, Some(60));
        line.hear(&telegram(2, 6, FunctionCode::response(ReplyStatus::DataLow), Some(62), &[0; 6]));
        line.ask(2, 5, Service::SrdHigh, Some(60));
    }
    assert_eq!(line.hints(), Vec::<String>::new());
}

#[test]
fn a_start_up_that_takes_its_time_and_commands_for_groups_of_ours_or_of_others_are_no_hints() {
    const PRM: [u8; 7] = [0xA0, 0, 0, 11, 0x0A, 0xC5, 3];
    let mut line = Line::with(&[5, 6]);
    // The GAP of a master that passes the token to itself.
    for _ in 0..50 {
        line.hear(&[0xDC, 2, 2]);
        line.ask(2, 3, Service::FdlStatus, None);
    }
    for _ in 0..50 {
        // A diagnosis in data exchange, or between tries to start.
        (0..15).for_each(|_| line.ask(2, 5, Service::SrdHigh, Some(60)));
        line.send(2, 5, Some(61), &PRM);
        line.send(2, 5, Some(62), &[0xF3, 0xF2]);
        (0..9).for_each(|_| line.send(2, 5, None, &[0; 14]));
        line.ask(2, 6, Service::SrdHigh, Some(60));
        line.send(2, 6, Some(61), &[0x80, 0, 0, 11, 0x0A, 0xC5, 0]);
        line.control(2, &[0x20, 2]);
        line.control(2, &[0, 0x80]);
    }
    assert_eq!(line.hints(), Vec::<String>::new());
    // Station 9 is of others, and may be in the group.
    line.hear(&telegram(2, 9, FunctionCode::response(ReplyStatus::DataLow), None, &[0; 2]));
    (0..9).for_each(|_| line.control(2, &[0x20, 0x80]));
    assert_eq!(line.hints(), Vec::<String>::new());
}

#[test]
fn sync_or_freeze_that_is_repeated_is_no_hint_and_one_that_is_left_is_said_each_minute() {
    let mut line = Line::with(&[5]);
    line.send(2, 5, Some(61), &[0xB0, 0, 0, 11, 0x0A, 0xC5, 0]);
    line.send(2, 5, Some(62), &[0xF3, 0xF2]);
    for _ in 0..1000 {
        line.control(2, &[0x28, 0]);
        (0..4).for_each(|_| line.send(2, 5, None, &[0; 14]));
    }
    assert_eq!(line.hints(), Vec::<String>::new());
    (0..7000).for_each(|_| line.send(2, 5, None, &[0; 14]));
    let told = line.hints();
    let of = |what: &str| told.iter().filter(|hint| hint.contains(what)).count();
    assert_eq!(
        (of("Sync of master 2 holds"), of("Freeze of master 2 holds"), told.len()),
        (2, 2, 4),
        "{told:?}"
    );
    line.control(2, &[0x14, 0]);
    (0..7000).for_each(|_| line.send(2, 5, None, &[0; 14]));
    assert_eq!(line.hints(), Vec::<String>::new(), "Unsync and Unfreeze");
}

#[test]
fn a_token_for_a_station_that_listens_hides_none_for_another_one() {
    let mut line = Line::with(&[5]);
    let joins = Device::new(Config::new(Address::station(6).unwrap()), Instant::ZERO);
    line.bus.join(line.now, joins).unwrap();
    line.hear(&[0xDC, 6, 2]);
    assert_eq!(line.hints(), Vec::<String>::new(), "6 may be a master");
    line.hear(&[0xDC, 5, 2]);
    let hints = line.hints();
    assert!(matches!(&hints[..], [hint] if hint.contains("passes the token to station 5")), "{hints:?}");
}

#[test]
fn noise_and_nothing_else_is_said_and_noise_between_telegrams_is_not() {
    let mut line = Line::with(&[5]);
    for octet in 0..30 {
        line.hear_noise(0x80 + octet);
    }
    let text = "hint: only octets that are no telegram are heard at 500000 bit/s; set the rate of the master, and check \
                whether A and B are exchanged and the line is terminated at both ends";
    assert_eq!(line.hints(), [text]);
    let mut line = Line::with(&[5]);
    for _ in 0..20 {
        for octet in 0..10 {
            line.hear_noise(0x80 + octet);
        }
        line.ask(2, 5, Service::FdlStatus, None);
    }
    assert_eq!(line.hints(), Vec::<String>::new());
}

#[test]
fn a_master_at_the_address_of_a_station_is_said() {
    let mut line = Line::with(&[5, 7]);
    for _ in 0..10 {
        line.ask(7, 5, Service::SrdHigh, Some(60));
    }
    let text = "hint: a master has address 7, which is that of a station on the line; give one of the two another address";
    assert_eq!(line.hints(), [text]);
}

#[test]
fn a_second_master_is_said_and_one_that_comes_after_the_other_is_not() {
    let mut line = Line::with(&[5]);
    for _ in 0..10 {
        line.ask(2, 5, Service::SrdHigh, Some(60));
        line.ask(3, 5, Service::SrdHigh, Some(60));
    }
    let text = "hint: master 3 is on the line with master 2; only the master that locked a slave controls it";
    assert_eq!(line.hints(), [text]);
    let mut line = Line::with(&[5]);
    line.ask(2, 5, Service::SrdHigh, Some(60));
    line.now = line.now.saturating_add(Duration::from_secs(5));
    line.ask(3, 5, Service::SrdHigh, Some(60));
    assert_eq!(line.hints(), Vec::<String>::new());
}
