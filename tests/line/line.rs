//! The simulated line: it sees every breach of the bus rules, and nothing of ours commits one, at any rate.

use core::time::Duration;

use profidrive::bench::{Answer, Breach, Line, ScriptedMaster as Master};
use profidrive::devices::StationEvent;
use profidrive::devices::ag03::profibus::{
    CONFIGURATIONS, Config, DESCRIPTION, Device, IDENT_NUMBER, MAX_TELEGRAM_LEN, Timing,
};
use profidrive::host::{Bus, BusEvent, Evidence, LISTEN_TIME, Participant, Presence};
use profidrive::profibus::dp::State;
use profidrive::profibus::fdl::{Address, RateChange, Sap, Telegram};
use profidrive::time::{BaudRate, Instant};

/// FDL status of master 2 to station 5, and the reply of station 5.
const STATUS: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];
const STATUS_REPLY: [u8; 6] = [0x10, 0x02, 0x05, 0x00, 0x07, 0x16];

fn address(number: u8) -> Address {
    Address::station(number).unwrap()
}

fn drive(number: u8) -> Device {
    Device::new(Config { timing: Timing::True, ..Config::new(address(number)) }, Instant::ZERO)
}

fn bus(baud: BaudRate, numbers: &[u8]) -> Bus {
    let mut bus = Bus::on(baud, Timing::True);
    for &number in numbers {
        bus.add(drive(number)).unwrap();
    }
    bus
}

fn line(baud: BaudRate, numbers: &[u8]) -> Line {
    let mut line = Line::new(baud);
    line.connect(bus(baud, numbers));
    line
}

fn news(line: &mut Line, number: usize) -> Vec<BusEvent> {
    let bus = line.bus_mut(number).unwrap();
    std::iter::from_fn(|| bus.poll_event()).collect()
}

fn state(line: &Line) -> State {
    line.bus(0).unwrap().station::<Device>(address(5)).unwrap().dp_state()
}

/// Set_Prm and Chk_Cfg for station 5.
fn start_up(line: &mut Line, master: &mut Master, watchdog: bool) {
    let [high, low] = IDENT_NUMBER.to_be_bytes();
    let status = if watchdog { 0x88 } else { 0x80 };
    for (sap, data) in [(61, &[status, 1, 100, 11, high, low, 0][..]), (62, CONFIGURATIONS[0])] {
        assert_eq!(master.srd(line, address(5), Sap::new(sap), data), Ok(Answer::ShortAcknowledge));
    }
    assert_eq!(state(line), State::DataExch);
}

fn exchanges(line: &mut Line, master: &mut Master) -> bool {
    matches!(master.srd(line, address(5), None, &[0; 14]).unwrap(), Answer::Data(_, data) if data.len() == 14)
}

/// A station that answers everything with the same octets after the same time.
struct Rogue {
    answer: Vec<u8>,
    after: Duration,
    due: Option<Instant>,
}

impl Participant for Rogue {
    fn address(&self) -> Address {
        address(5)
    }
    fn set_baud(&mut self, _: BaudRate) {}
    fn handle_telegram(&mut self, now: Instant, _: &Telegram<'_>, _: &mut dyn FnMut(StationEvent)) {
        self.due = Some(now.saturating_add(self.after));
    }
    fn handle_timeout(&mut self, _: Instant, _: &mut dyn FnMut(StationEvent)) {}
    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        _: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        self.due.take_if(|due| *due <= now)?;
        buf[..self.answer.len()].copy_from_slice(&self.answer);
        Some(self.answer.len())
    }
    fn poll_timeout(&self) -> Option<Instant> {
        self.due
    }
    fn watchdog_on(&self) -> bool {
        false
    }
}

/// What the line says of an answer to STATUS, in T_bit of 500 kbit/s after it.
fn judged(request: &[u8], answer: &[u8], after: u32) -> Result<Option<Vec<u8>>, Breach> {
    let baud = BaudRate::K500;
    let mut bus = Bus::on(baud, Timing::True);
    bus.add(Rogue { answer: answer.to_vec(), after: baud.bit_times(after), due: None }).unwrap();
    let mut line = Line::new(baud);
    line.connect(bus);
    line.request(request).map(|octets| octets.map(<[u8]>::to_vec))
}

#[test]
fn a_reply_must_come_between_min_and_max_tsdr() {
    let after = |bits| judged(&STATUS, &STATUS_REPLY, bits);
    assert!(matches!(after(10), Err(Breach::TooEarly { .. })), "{:?}", after(10));
    assert_eq!(after(11), Ok(Some(STATUS_REPLY.to_vec())));
    assert_eq!(after(100), Ok(Some(STATUS_REPLY.to_vec())));
    assert!(matches!(after(101), Err(Breach::TooLate { .. })), "{:?}", after(101));
    let breach = after(101).unwrap_err();
    assert_eq!(
        breach.to_string(),
        "at 0.000400: a reply 202µs after its request, expected at most max T_SDR, 200µs"
    );
}

#[test]
fn only_the_station_that_was_asked_may_reply_and_only_in_telegrams() {
    let other = [0x10, 0x02, 0x06, 0x00, 0x08, 0x16];
    assert!(matches!(judged(&STATUS, &other, 20), Err(Breach::WrongStation { .. })));
    let request = [0x10, 0x02, 0x05, 0x49, 0x50, 0x16];
    assert!(matches!(judged(&STATUS, &request, 20), Err(Breach::WrongStation { .. })));
    assert!(matches!(judged(&STATUS, &STATUS_REPLY[..5], 20), Err(Breach::NoTelegram { .. })));
    assert!(matches!(judged(&STATUS, &[0xE5, 0xE5], 20), Err(Breach::NoTelegram { .. })));
    // SDN to station 5 wants no reply.
    let sdn = [0x68, 7, 7, 0x68, 0x85, 0x82, 0x46, 0x3A, 0x3E, 0, 0, 0xC5, 0x16];
    assert!(matches!(judged(&sdn, &STATUS_REPLY, 20), Err(Breach::Unasked { .. })));
}

#[test]
fn two_senders_at_the_same_time_are_a_collision() {
    let mut line = line(BaudRate::K500, &[5]);
    line.connect(bus(BaudRate::K500, &[5]));
    assert!(matches!(line.request(&STATUS), Err(Breach::Collision { .. })), "two stations at one address");

    let mut line = self::line(BaudRate::K500, &[5]);
    let end = line.send(&STATUS).unwrap();
    let during_the_reply = end.saturating_add(BaudRate::K500.bit_times(20));
    assert!(matches!(line.send_at(during_the_reply, &[0]), Err(Breach::Collision { .. })), "a hasty master");
}

#[test]
fn a_request_needs_silence_before_it_and_noise_does_not() {
    let mut line = line(BaudRate::K500, &[5]);
    line.send(&[0xFF]).unwrap();
    let end = line.send_at(line.now(), &[0xFF]).unwrap();
    let hasty = end.saturating_add(BaudRate::K500.bit_times(32));
    assert!(matches!(line.send_at(hasty, &STATUS), Err(Breach::NoSyn { .. })));
    // Nobody has heard it behind what was no telegram; its slot time must pass all the same.
    assert!(matches!(line.send(&STATUS), Err(Breach::NoSlotTime { .. })));
    assert_eq!(line.listen(line.now().saturating_add(line.slot_time())), Ok(Some(&STATUS_REPLY[..])));
    assert_eq!(line.request(&STATUS), Ok(Some(&STATUS_REPLY[..])));
}

#[test]
fn t_01_every_reply_of_a_whole_session_is_in_time_at_every_rate() {
    for baud in DESCRIPTION.rates.iter() {
        let mut line = line(baud, &[4, 5, 6]);
        let mut master = Master::new(address(2));
        assert!(master.fdl_status(&mut line, address(5)).unwrap());
        assert!(!master.fdl_status(&mut line, address(7)).unwrap(), "nobody at 7");
        start_up(&mut line, &mut master, true);
        for _ in 0..100 {
            assert!(exchanges(&mut line, &mut master), "{baud}");
            let diagnosis = master.srd(&mut line, address(6), Sap::new(60), &[]).unwrap();
            assert!(matches!(diagnosis, Answer::Data(_, data) if data.len() == 6), "{diagnosis:?}");
        }
        assert_eq!(master.retries, 0);
        let counters = line.bus(0).unwrap().station_counters(address(5)).unwrap();
        assert_eq!((counters.replies, counters.too_late, counters.retries), (103, 0, 0), "{counters}");
        let latency: Vec<_> = counters.latency.buckets().filter(|(_, times)| *times > 0).collect();
        let [(Some(limit), 103)] = latency[..] else { panic!("{latency:?}") };
        assert!(limit >= baud.bit_times(11), "{baud}: {limit:?}");
    }
}

#[test]
fn f_06_a_parity_error_at_any_position_leaves_the_request_without_answer_and_effect() {
    let [high, low] = IDENT_NUMBER.to_be_bytes();
    let unlock = [0x40, 0, 0, 0, high, low, 0];
    for (sap, data) in [(None, &[0x55; 14][..]), (Sap::new(61), &unlock), (Sap::new(60), &[])] {
        let len = 6 + if sap.is_some() { 5 } else { 3 } + data.len();
        for position in 0..len {
            let mut line = line(BaudRate::K1500, &[5]);
            let mut master = Master::new(address(2));
            start_up(&mut line, &mut master, true);
            assert!(exchanges(&mut line, &mut master));
            // A watchdog of one second that the damaged request does not feed.
            line.wait(Duration::from_millis(900)).unwrap();
            line.disturb(Some(Box::new(move |_, octets| {
                assert_eq!(octets.len(), len);
                Some(position)
            })));
            master.retry_limit = 0;
            assert_eq!(master.srd(&mut line, address(5), sap, data), Ok(Answer::Silence), "octet {position}");
            line.disturb(None);
            assert_eq!(state(&line), State::DataExch);
            assert_eq!(line.bus(0).unwrap().counters().rejected.parity, 1);
            assert_eq!(line.request(&STATUS), Ok(Some(&STATUS_REPLY[..])), "the next request is answered");
        }
    }
    let mut line = line(BaudRate::K1500, &[5]);
    let mut master = Master::new(address(2));
    start_up(&mut line, &mut master, true);
    line.wait(Duration::from_millis(900)).unwrap();
    line.disturb(Some(Box::new(|_, _| Some(0))));
    master.retry_limit = 0;
    assert_eq!(master.srd(&mut line, address(5), None, &[0; 14]), Ok(Answer::Silence));
    line.wait(Duration::from_millis(200)).unwrap();
    assert_eq!(state(&line), State::WaitPrm, "the damaged request did not feed the watchdog");
}

/// Asks station 5 for its status every 20 ms until it answers, at most for `limit`: the time it took.
fn until_answered(line: &mut Line, master: &mut Master, limit: Duration) -> Duration {
    let start = line.now();
    while !master.fdl_status(line, address(5)).unwrap() {
        assert!(line.now().saturating_since(start) < limit, "not found at {}", line.baud());
        line.wait(Duration::from_millis(20)).unwrap();
    }
    line.now().saturating_since(start)
}

/// A whole sweep over all rates and what is missed of the first window.
const SWEEP: Duration = Duration::from_millis(3_000);
const CONTROL_TIME: Duration = Duration::from_millis(2_560);

#[test]
fn w_08_the_rate_of_the_line_is_found_and_found_again_after_every_change() {
    for first in DESCRIPTION.rates.iter() {
        let mut line = Line::new(first);
        let mut bus = bus(BaudRate::K500, &[5]);
        bus.search_baud(Instant::ZERO);
        line.connect(bus);
        let mut master = Master::new(address(2));
        until_answered(&mut line, &mut master, SWEEP);
        assert_eq!(line.bus(0).unwrap().baud(), first);
        start_up(&mut line, &mut master, false);
        assert!(exchanges(&mut line, &mut master));
        for second in DESCRIPTION.rates.iter().filter(|second| *second != first) {
            line.set_baud(second);
            let took = until_answered(&mut line, &mut master, CONTROL_TIME + SWEEP);
            assert!(took >= CONTROL_TIME - Duration::from_millis(500), "{first} to {second} took {took:?}");
            assert_eq!(line.bus(0).unwrap().baud(), second);
            // Without watchdog the DP slave is not touched by the search.
            assert_eq!(state(&line), State::DataExch);
            assert!(exchanges(&mut line, &mut master), "{first} to {second}");
        }
    }
}

#[test]
fn w_08_with_a_watchdog_the_search_begins_after_it_and_the_slave_waits_for_parameters() {
    let mut line = Line::new(BaudRate::K1500);
    let mut bus = bus(BaudRate::K500, &[5]);
    bus.search_baud(Instant::ZERO);
    line.connect(bus);
    let mut master = Master::new(address(2));
    until_answered(&mut line, &mut master, SWEEP);
    start_up(&mut line, &mut master, true);
    assert!(exchanges(&mut line, &mut master));
    news(&mut line, 0);
    line.set_baud(BaudRate::K19_2);
    // A watchdog of 1 s, then BAUD_CONTROL, then the search.
    let took = until_answered(&mut line, &mut master, Duration::from_secs(1) + CONTROL_TIME + SWEEP);
    assert!(took >= Duration::from_secs(1) + CONTROL_TIME, "{took:?}");
    assert_eq!(state(&line), State::WaitPrm);
    let said: Vec<_> = news(&mut line, 0).iter().map(ToString::to_string).collect();
    let position = |part: &str| said.iter().position(|line| line.contains(part)).unwrap();
    assert!(position("watchdog expired") < position("searching for the rate of the line at 12000000"));
    assert!(position("at 93750 bit/s") < position("the rate of the line is 19200 bit/s"), "{said:?}");
}

#[test]
fn a_silent_line_is_searched_from_the_top_over_and_over_and_nothing_is_sent() {
    let mut line = Line::new(BaudRate::K500);
    let mut bus = bus(BaudRate::K500, &[5]);
    bus.search_baud(Instant::ZERO);
    line.connect(bus);
    line.wait(Duration::from_secs(10)).unwrap();
    let tried = news(&mut line, 0).into_iter().map(|event| match event {
        BusEvent::Rate(RateChange::Try(rate)) => rate,
        other => panic!("{other}"),
    });
    let tried: Vec<_> = tried.collect();
    let expected: Vec<_> =
        DESCRIPTION.rates.iter().rev().collect::<Vec<_>>().into_iter().cycle().take(tried.len()).collect();
    assert!(tried.len() > 30);
    assert_eq!(tried, expected);
}

#[test]
fn n_04_a_station_does_not_become_active_on_an_address_that_is_live() {
    let mut line = line(BaudRate::K500, &[5, 6]);
    let mut newcomer = Bus::on(BaudRate::K500, Timing::True);
    for number in [5, 6, 7, 8] {
        newcomer.join(Instant::ZERO, drive(number)).unwrap();
    }
    let newcomer = line.connect(newcomer);
    let mut master = Master::new(address(2));
    // Data gives 5 away, SC gives 6 away, 7 is asked in vain, nobody speaks of 8.
    assert!(master.fdl_status(&mut line, address(5)).unwrap());
    let [high, low] = IDENT_NUMBER.to_be_bytes();
    let prm = [0x80, 1, 1, 11, high, low, 0];
    assert_eq!(
        master.srd(&mut line, address(6), Sap::new(61), &prm),
        Ok(Answer::ShortAcknowledge),
        "only one of two answers"
    );
    for _ in 0..2 {
        assert!(!master.fdl_status(&mut line, address(7)).unwrap());
    }
    assert!(master.fdl_status(&mut line, address(7)).unwrap(), "active since nobody answered twice");
    let live = |number| BusEvent::AddressLive { address: address(number), evidence: Evidence::Answers };
    assert_eq!(news(&mut line, newcomer), [live(5), live(6), BusEvent::Joined { address: address(7) }]);
    assert!(live(5).to_string().contains("station 5 stays silent: another station has this address"));

    assert!(!master.fdl_status(&mut line, address(8)).unwrap());
    let begun = line.now();
    line.wait(LISTEN_TIME).unwrap();
    assert!(begun < Instant::ZERO.saturating_add(LISTEN_TIME));
    assert_eq!(news(&mut line, newcomer), [BusEvent::Joined { address: address(8) }]);
    assert!(master.fdl_status(&mut line, address(8)).unwrap());

    let bus = line.bus_mut(newcomer).unwrap();
    assert_eq!(bus.presence(address(5)), Some(Presence::Refused));
    assert!(master.fdl_status(&mut line, address(5)).unwrap(), "without collision");
    // All the same, if set so: both answer.
    assert!(line.bus_mut(newcomer).unwrap().activate(address(5)));
    assert!(matches!(master.fdl_status(&mut line, address(5)), Err(Breach::Collision { .. })));
}

#[test]
fn n_04_the_address_of_a_master_is_live_too() {
    let mut line = line(BaudRate::K500, &[]);
    let bus = line.bus_mut(0).unwrap();
    for number in [2, 3] {
        bus.join(Instant::ZERO, drive(number)).unwrap();
    }
    let mut master = Master::new(address(2));
    master.pass_token(&mut line, address(3)).unwrap();
    let said: Vec<_> = news(&mut line, 0).iter().map(ToString::to_string).collect();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said.iter().all(|line| line.contains("a master in the token ring")), "{said:?}");
    line.wait(LISTEN_TIME * 2).unwrap();
    assert_eq!(line.bus(0).unwrap().presence(address(2)), Some(Presence::Refused), "for good");
}
