//! Many stations on one simulated line: a full bus, groups, stations that come and go, a line full of errors, and
//! octets of all kinds. The line itself checks the rules of the bus all the time.
//!
//! The long versions: `PROFIDRIVE_LONG=1 cargo test --release --all-features --test many_stations -- --nocapture`.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a test may panic, and has std"
)]
#![cfg(feature = "std")]

use core::sync::atomic::{AtomicU64, Ordering};
use core::time::Duration;
use std::sync::Arc;

use profidrive::device::{Config, Device, Event, MAX_TELEGRAM_LEN, Timing};
use profidrive::dp::{self, Description, State};
use profidrive::fdl::{Address, ReplyStatus, Sap, Telegram};
use profidrive::host::line::{Answer, Line, Master};
use profidrive::host::{Bus, BusEvent, Participant};
use profidrive::time::{BaudRate, Instant};

const BAUD: BaudRate = BaudRate::K12000;

/// 122 words of outputs and of inputs: 244 octets each, in two identifiers with two length octets.
const LARGE: &[u8] = &[0xC0, 0x7F, 0x7F, 0xC0, 0x79, 0x79];
const LARGE_LEN: usize = 244;
/// 8 octets of each.
const SMALL: &[u8] = &[0x37];
const SMALL_LEN: usize = 8;
const IDENT: u16 = 0x1234;

fn long() -> bool {
    std::env::var_os("PROFIDRIVE_LONG").is_some()
}

fn address(number: u8) -> Address {
    Address::station(number).unwrap()
}

/// A slave whose inputs are its outputs of the exchange before, each octet with the address, and behind the first
/// four octets the number of exchanges it has carried out.
struct Mirror {
    station: dp::Station,
    exchanges: u32,
}

impl Mirror {
    fn new(number: u8, configurations: &'static [&'static [u8]]) -> Self {
        let description = Description {
            ident: IDENT,
            configurations,
            sync_mode: true,
            freeze_mode: true,
            ..Description::default()
        };
        let max_tsdr = Some(BAUD.max_tsdr_bits());
        Self { station: dp::Station::new(address(number), BAUD, max_tsdr, description), exchanges: 0 }
    }

    fn state(&self) -> State {
        self.station.slave().state()
    }
}

impl Participant for Mirror {
    fn address(&self) -> Address {
        self.station.address()
    }
    fn set_baud(&mut self, baud: BaudRate) {
        self.station.set_baud(baud);
    }
    fn receive(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(Event)) {
        let outcome = self.station.receive(now, telegram);
        if let Some(event) = outcome.event {
            news(Event::Dp(event));
        }
        if outcome.exchanged {
            self.exchanges += 1;
            let mut inputs = [0; LARGE_LEN];
            let outputs = self.station.slave().outputs();
            let number = self.station.address().number();
            for (input, output) in inputs.iter_mut().zip(outputs) {
                *input = output ^ number;
            }
            let len = outputs.len();
            inputs[4..8].copy_from_slice(&self.exchanges.to_be_bytes());
            self.station.set_inputs(&inputs[..len]);
        }
    }
    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(Event)) {
        Participant::handle_timeout(&mut self.station, now, news);
    }
    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(Event),
    ) -> Option<usize> {
        Participant::poll_transmit(&mut self.station, now, buf, news)
    }
    fn poll_timeout(&self) -> Option<Instant> {
        self.station.poll_timeout()
    }
    fn watchdog_on(&self) -> bool {
        self.station.watchdog_on()
    }
}

fn line(numbers: impl IntoIterator<Item = u8>, configurations: &'static [&'static [u8]]) -> Line {
    let mut bus = Bus::on(BAUD, Timing::True);
    for number in numbers {
        bus.add(Mirror::new(number, configurations)).unwrap();
    }
    let mut line = Line::new(BAUD);
    line.connect(bus);
    line
}

fn mirror(line: &Line, number: u8) -> &Mirror {
    line.bus(0).unwrap().station(address(number)).unwrap()
}

/// Set_Prm with a watchdog of one second, Chk_Cfg, and a diagnosis that says ready.
fn start_up(line: &mut Line, master: &mut Master, number: u8, group: u8, cfg: &[u8]) {
    let [high, low] = IDENT.to_be_bytes();
    let prm = [0xB8, 10, 10, 11, high, low, group];
    for (sap, data) in [(61, &prm[..]), (62, cfg)] {
        assert_eq!(
            master.srd(line, address(number), Sap::new(sap), data),
            Ok(Answer::ShortAcknowledge),
            "{number}"
        );
    }
    let ready = [0x00, 0x0C, 0x00, master.address().number(), high, low];
    let diagnosis = master.srd(line, address(number), Sap::new(60), &[]);
    assert_eq!(diagnosis, Ok(Answer::Data(ReplyStatus::DataLow, &ready)), "{number}");
}

/// Outputs of an exchange that no other exchange has, as far as its first four octets go.
fn outputs(number: u8, round: u32) -> [u8; LARGE_LEN] {
    let mut octets = [0; LARGE_LEN];
    for (at, octet) in octets.iter_mut().enumerate() {
        *octet = (at as u8).wrapping_mul(7).wrapping_add(round as u8) ^ number;
    }
    octets[..4].copy_from_slice(&(round ^ u32::from(number) << 24).to_be_bytes());
    octets
}

/// The inputs that belong to the outputs of the exchange before; the first exchange has none.
fn inputs(number: u8, round: u32) -> [u8; LARGE_LEN] {
    if round == 0 {
        return [0; LARGE_LEN];
    }
    let mut octets = outputs(number, round - 1);
    for octet in &mut octets {
        *octet ^= number;
    }
    octets[4..8].copy_from_slice(&round.to_be_bytes());
    octets
}

/// The two masters of a full bus: 127 addresses are needed and a real bus has 126, so the second has 126 here.
fn two_masters() -> [(Master, core::ops::RangeInclusive<u8>); 2] {
    [(Master::new(address(0)), 1..=63), (Master::new(address(126)), 64..=125)]
}

/// For an hour of bus time set `PROFIDRIVE_LONG`.
#[test]
fn n_01_125_stations_of_244_octets_each_way_and_two_masters_on_a_full_line() {
    let simulated = Duration::from_millis(if long() { 3_600_000 } else { 700 });
    let begun = std::time::Instant::now();
    let mut line = line(1..=125, &[LARGE]);
    let mut masters = two_masters();
    for (master, stations) in &mut masters {
        for number in stations.clone() {
            start_up(&mut line, master, number, 0, LARGE);
        }
    }
    let end = line.now().saturating_add(simulated);
    let (mut round, mut exchanges) = (0, 0_u64);
    while line.now() < end {
        let (mut sent, mut received) = (0, 0);
        for at in 0..masters.len() {
            let successor = masters[1 - at].0.address();
            let (master, stations) = &mut masters[at];
            for number in stations.clone() {
                let outputs = outputs(number, round);
                let answer = master.srd(&mut line, address(number), None, &outputs).unwrap();
                let Answer::Data(ReplyStatus::DataLow, octets) = answer else {
                    panic!("station {number}: {answer:?}");
                };
                assert!(octets == inputs(number, round), "station {number}, exchange {round}");
                sent += outputs.len();
                received += octets.len();
                exchanges += 1;
            }
            master.pass_token(&mut line, successor).unwrap();
        }
        assert_eq!((sent, received), (30_500, 30_500));
        round += 1;
    }
    assert_eq!(masters[0].0.retries + masters[1].0.retries, 0);
    for number in 1..=125 {
        let counters = line.bus(0).unwrap().station_counters(address(number)).unwrap();
        assert_eq!((counters.retries, counters.too_late, counters.watchdog_expiries), (0, 0, 0));
        assert_eq!(mirror(&line, number).exchanges, round);
    }
    if long() {
        println!("{exchanges} exchanges, {simulated:?} of bus time in {:?}, no breach", begun.elapsed());
    }

    // Independent: one is unlocked, one starves, one is asked too much; the others go on.
    let [high, low] = IDENT.to_be_bytes();
    let [(first, _), (second, _)] = &mut masters;
    let unlock = [0x40, 0, 0, 0, high, low, 0];
    assert_eq!(first.srd(&mut line, address(7), Sap::new(61), &unlock), Ok(Answer::ShortAcknowledge));
    let refused = Ok(Answer::Status(ReplyStatus::NotActivated));
    assert_eq!(second.srd(&mut line, address(70), None, &[0; 3]), refused, "wrong length");
    assert_eq!(first.srd(&mut line, address(71), None, &[0; 244]), refused, "not its master");
    let hungry = 9;
    let end = line.now().saturating_add(Duration::from_millis(1_100));
    while line.now() < end {
        for (master, stations) in &mut masters {
            for number in stations.clone().filter(|number| ![7, 70, hungry].contains(number)) {
                let answer = master.srd(&mut line, address(number), None, &[number; 244]).unwrap();
                assert!(matches!(answer, Answer::Data(..)), "station {number}: {answer:?}");
            }
        }
    }
    for number in 1..=125 {
        let expected = if [7, 70, hungry].contains(&number) { State::WaitPrm } else { State::DataExch };
        assert_eq!(mirror(&line, number).state(), expected, "station {number}");
    }
    let counters = line.bus(0).unwrap().station_counters(address(hungry)).unwrap();
    assert_eq!(counters.watchdog_expiries, 1);
}

#[test]
fn n_02_a_broadcast_reaches_each_station_by_its_own_group() {
    let mut line = line(1..=16, &[SMALL]);
    let mut master = Master::new(address(0));
    // Stations 1..=8 in one group each, 9..=16 in that group and its neighbour.
    let group = |number: u8| {
        let bit = 1_u8 << ((number - 1) % 8);
        if number > 8 { bit | bit.rotate_left(1) } else { bit }
    };
    for number in 1..=16 {
        start_up(&mut line, &mut master, number, group(number), SMALL);
    }
    let exchange = |line: &mut Line, master: &mut Master, value: u8| {
        for number in 1..=16 {
            let answer = master.srd(line, address(number), None, &[value; SMALL_LEN]).unwrap();
            assert!(matches!(answer, Answer::Data(..)));
        }
    };
    let control = |line: &mut Line, master: &mut Master, command: u8, groups: u8| {
        master.sdn(line, Address::BROADCAST, Sap::new(58).unwrap(), &[command, groups]).unwrap();
    };
    const SYNC: u8 = 0x20;
    const UNSYNC: u8 = 0x10;
    for groups in [0x01, 0x80, 0x24, 0xFF, 0x00] {
        exchange(&mut line, &mut master, 1);
        control(&mut line, &mut master, SYNC, groups);
        exchange(&mut line, &mut master, 2);
        for number in 1..=16 {
            let held = groups == 0 || group(number) & groups != 0;
            let expected = if held { 1 } else { 2 };
            assert_eq!(
                mirror(&line, number).station.slave().outputs(),
                [expected; SMALL_LEN],
                "station {number} of group {:02X}, sync of {groups:02X}",
                group(number)
            );
        }
        control(&mut line, &mut master, UNSYNC, 0);
        for number in 1..=16 {
            assert_eq!(mirror(&line, number).station.slave().outputs(), [2; SMALL_LEN]);
        }
    }
}

#[test]
fn n_05_stations_come_and_go_while_the_others_exchange() {
    let mut line = line(1..=20, &[SMALL]);
    let mut master = Master::new(address(0));
    for number in 1..=20 {
        start_up(&mut line, &mut master, number, 0, SMALL);
    }
    let mut round = [0_u32; 126];
    let mut exchange = |line: &mut Line, master: &mut Master, number: u8| {
        let round = &mut round[usize::from(number)];
        let answer = master.srd(line, address(number), None, &outputs(number, *round)[..SMALL_LEN]).unwrap();
        let expected = inputs(number, *round);
        assert_eq!(answer, Answer::Data(ReplyStatus::DataLow, &expected[..SMALL_LEN]), "station {number}");
        *round += 1;
    };
    for step in 0..200_u32 {
        for number in (1..=20).filter(|number| *number != 10) {
            exchange(&mut line, &mut master, number);
        }
        match step % 4 {
            0 => {
                // Half of the times with a reply that has not been sent: it is never sent.
                if step % 8 == 0 {
                    line.send(&[0x10, 10, 0, 0x49, 0x53, 0x16]).unwrap();
                }
                let removed = line.bus_mut(0).unwrap().remove(address(10)).unwrap();
                assert_eq!(removed.address(), address(10));
                assert!(line.bus_mut(0).unwrap().remove(address(10)).is_none());
                assert!(!master.fdl_status(&mut line, address(10)).unwrap());
            }
            2 => {
                line.bus_mut(0).unwrap().add(Mirror::new(10, &[SMALL])).unwrap();
                assert!(line.bus_mut(0).unwrap().add(Mirror::new(10, &[SMALL])).is_err());
                assert!(master.fdl_status(&mut line, address(10)).unwrap());
                let [high, low] = IDENT.to_be_bytes();
                let power_on = [0x02, 0x05, 0x00, 0xFF, high, low];
                let diagnosis = master.srd(&mut line, address(10), Sap::new(60), &[]).unwrap();
                assert_eq!(diagnosis, Answer::Data(ReplyStatus::DataLow, &power_on), "a new one");
            }
            _ => {}
        }
    }
    assert_eq!(line.bus(0).unwrap().addresses().count(), 19 + 1);
}

#[test]
fn drives_and_other_stations_share_a_bus_and_are_reached_as_what_they_are() {
    let mut line = line([1], &[SMALL]);
    let bus = line.bus_mut(0).unwrap();
    bus.add(Device::new(Config { timing: Timing::True, ..Config::new(address(2)) }, Instant::ZERO)).unwrap();
    let description = Description { ident: IDENT, configurations: &[SMALL], ..Description::default() };
    bus.add(dp::Station::new(address(3), BAUD, None, description)).unwrap();
    assert!(bus.station::<Device>(address(2)).is_some() && bus.station::<Device>(address(3)).is_none());
    assert_eq!(bus.station::<Device>(address(2)).unwrap().config().baud, BAUD, "set by the bus");

    let mut master = Master::new(address(0));
    let [high, low] = IDENT.to_be_bytes();
    for (sap, data) in [(61, &[0x80, 0, 0, 11, high, low, 0][..]), (62, SMALL)] {
        assert_eq!(master.srd(&mut line, address(3), Sap::new(sap), data), Ok(Answer::ShortAcknowledge));
    }
    // The process image of a bare station is the user's.
    let bus = line.bus_mut(0).unwrap();
    bus.with(address(3), |station: &mut dp::Station| station.set_inputs(&[9; 8])).unwrap();
    assert!(bus.with(address(3), |_: &mut Device| ()).is_none());
    let answer = master.srd(&mut line, address(3), None, &[4; 8]);
    assert_eq!(answer, Ok(Answer::Data(ReplyStatus::DataLow, &[9; 8])));
    let station: &dp::Station = line.bus(0).unwrap().station(address(3)).unwrap();
    assert_eq!(station.slave().outputs(), [4; 8]);
}

/// A bus in memory: what either side says is heard once it has ended.
#[cfg(feature = "master")]
#[test]
fn profirust_drives_forty_drives_on_one_bus() {
    use profidrive::host::Link;
    use profidrive::host::Received;
    use profidrive::host::link::memory::Wire;
    use profidrive::master::{LinkPhy, baudrate, instant, peripheral};
    use profirust::dp::DpMaster;
    use profirust::fdl::{FdlActiveStation, ParametersBuilder};

    let baud = BaudRate::K1500;
    let mut dp = DpMaster::new(Vec::new());
    let handles: Vec<_> = (3..=42).map(|number| dp.add(peripheral(number, baud))).collect();
    dp.enter_operate();
    let mut fdl = FdlActiveStation::new(ParametersBuilder::new(2, baudrate(baud)).build_verified(&dp));
    fdl.set_online();
    let mut bus = Bus::on(baud, Timing::True);
    for number in 3..=42 {
        let config = Config { timing: Timing::True, ..Config::new(address(number)) };
        bus.add(Device::new(config, Instant::ZERO)).unwrap();
    }
    let wire = Wire::new();
    let (mut phy, mut slaves) = (LinkPhy::new(wire.end(), baud), wire.end());
    // Who speaks: octets, when they have ended, and whether they are the master's.
    let mut speaking: Option<(Vec<u8>, Instant, bool)> = None;
    let (mut now, mut buf, mut cycles, mut running) = (Instant::ZERO, [0; MAX_TELEGRAM_LEN], 0, 0);
    while cycles < 50 {
        assert!(now < Instant::from_millis(2_000), "{running} of 40 drives running, {cycles} cycles");
        if let Some((octets, _, by_master)) = speaking.take_if(|(_, end, _)| *end <= now) {
            if by_master {
                bus.handle_bytes(now, &octets);
            } else {
                slaves.send(&octets).unwrap();
            }
        }
        if bus.poll_timeout().is_some_and(|due| due <= now) {
            bus.handle_timeout(now);
        }
        let ends = |octets: &[u8]| now.saturating_add(baud.octet_times(octets.len() as u32));
        if let Some(octets) = bus.poll_transmit(now, &mut buf) {
            assert!(speaking.is_none(), "two speak at {now}");
            speaking = Some((octets.to_vec(), ends(octets), false));
        }
        fdl.poll(instant(now), &mut phy, &mut dp);
        if let Received::Octets(count) = slaves.receive(&mut buf).unwrap() {
            assert!(speaking.is_none(), "two speak at {now}");
            speaking = Some((buf[..count].to_vec(), ends(&buf[..count]), true));
        }
        let events = dp.take_last_events();
        running = handles.iter().filter(|handle| dp.get_mut(**handle).is_running()).count();
        cycles += u32::from(events.cycle_completed && running == 40);
        let step = now.saturating_add(Duration::from_micros(10));
        let next = [Some(step), bus.poll_timeout(), speaking.as_ref().map(|(_, end, _)| *end)];
        now = next.into_iter().flatten().filter(|next| *next > now).min().unwrap();
    }
    for number in 3..=42 {
        assert_eq!(bus.station::<Device>(address(number)).unwrap().dp_state(), State::DataExch);
        let counters = bus.station_counters(address(number)).unwrap();
        assert!(counters.replies > 50 && counters.retries == 0 && counters.too_late == 0, "{counters}");
    }
}

#[test]
fn t_02_a_late_host_costs_the_reply_and_is_counted() {
    let mut bus = Bus::on(BAUD, Timing::True);
    bus.add(Mirror::new(5, &[SMALL])).unwrap();
    let now = Instant::from_millis(1);
    bus.handle_bytes(now, &[0x10, 5, 0, 0x49, 0x4E, 0x16]);
    let late = now.saturating_add(BAUD.bit_times(801));
    assert_eq!(bus.poll_transmit(late, &mut [0; MAX_TELEGRAM_LEN]), None);
    let said = bus.poll_event().unwrap().to_string();
    assert!(said.starts_with("station 5: dropped a reply") && said.contains("expected at most"), "{said}");
    let counters = bus.station_counters(address(5)).unwrap();
    assert_eq!((counters.requests.fdl_status, counters.replies, counters.too_late), (1, 0, 1));
}

/// Numbers that look random and are the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }
}

/// One error on the line: what any FCS and parity bit detect. Says which octet has wrong parity.
fn spoil(random: &mut Random, octets: &mut Vec<u8>) -> Option<usize> {
    let at = random.below(octets.len());
    match random.below(5) {
        0 => octets[at] ^= 1 << random.below(8),
        1 => octets.truncate(at),
        2 => {
            octets.remove(at);
        }
        3 => octets.insert(0, random.next() as u8),
        _ => return Some(at),
    }
    None
}

/// For ten million exchanges set `PROFIDRIVE_LONG`.
#[test]
fn one_percent_of_line_errors_costs_retries_and_nothing_else() {
    const STATIONS: core::ops::RangeInclusive<u8> = 1..=10;
    let limit: u32 = if long() { 10_000_000 } else { 15_000 };
    let begun = std::time::Instant::now();
    let mut line = line(STATIONS, &[SMALL]);
    let mut master = Master::new(address(0));
    master.retry_limit = 4;
    for number in STATIONS {
        start_up(&mut line, &mut master, number, 0, SMALL);
    }
    let errors = Arc::new(AtomicU64::new(0));
    let (counted, mut random) = (Arc::clone(&errors), Random(0x9E37_79B9_7F4A_7C15));
    line.disturb(Some(Box::new(move |_, octets| {
        if random.below(100) != 0 {
            return None;
        }
        counted.fetch_add(1, Ordering::Relaxed);
        spoil(&mut random, octets)
    })));
    for exchange in 0..limit {
        let (number, round) = (*STATIONS.start() + (exchange % 10) as u8, exchange / 10);
        let outputs = outputs(number, round);
        let answer = master.srd(&mut line, address(number), None, &outputs[..SMALL_LEN]).unwrap();
        // Each exchange is carried out exactly once, however often it was said: the inputs count them.
        let expected = inputs(number, round);
        assert_eq!(
            answer,
            Answer::Data(ReplyStatus::DataLow, &expected[..SMALL_LEN]),
            "station {number}, exchange {round}"
        );
    }
    let errors = errors.load(Ordering::Relaxed);
    let (retries, bus) = (master.retries, line.bus(0).unwrap());
    // Recovery at the first valid request: a request goes unanswered only if it or its reply was disturbed.
    assert!(retries > 0 && retries <= errors, "{retries} retries of {errors} errors");
    let seen: u64 = STATIONS.map(|number| bus.station_counters(address(number)).unwrap().retries).sum();
    assert!(seen <= retries && seen > 0, "{seen} of {retries} retries followed a request that was heard");
    assert!(bus.counters().rejected.total() > 0 && bus.counters().rejected.parity > 0);
    if long() {
        println!(
            "{limit} exchanges, {errors} errors, {retries} retries in {:?}; {}",
            begun.elapsed(),
            bus.counters()
        );
    }
}

/// Who may answer octets, by rules written down once more: whom the last valid request among the valid telegrams at
/// their front wants a reply from.
fn may_answer(octets: &[u8]) -> Option<u8> {
    let (mut rest, mut last) = (octets, None);
    loop {
        let len = match rest {
            [0xE5, ..] => 1,
            [0xDC, da, sa, ..] if *da < 127 && *sa < 127 => 3,
            [0x10, ..] => 6,
            [0xA2, ..] => 14,
            [0x68, le, ..] => usize::from(*le) + 6,
            _ => return last,
        };
        match (rest.get(..len), rest[0]) {
            (Some(_), 0xE5 | 0xDC) => {}
            // Anything else that is not a request either ends what can be understood or changes nothing.
            (Some(telegram), _) => last = asked(telegram).or(last),
            (None, _) => return last,
        }
        rest = &rest[len..];
    }
}

/// Whom one valid request wants a reply from.
fn asked(octets: &[u8]) -> Option<u8> {
    let (body, format_ok) = match octets {
        [0x10, body @ .., fcs, 0x16] if body.len() == 3 => (body, sum(body) == *fcs),
        [0xA2, body @ .., fcs, 0x16] if body.len() == 11 => (body, sum(body) == *fcs),
        [0x68, le, ler, 0x68, body @ .., fcs, 0x16] => {
            let le_ok = le == ler && (4..=249).contains(le) && usize::from(*le) == body.len();
            (body, le_ok && sum(body) == *fcs)
        }
        _ => return None,
    };
    let &[da, sa, fc, ref pdu @ ..] = body else { return None };
    let saps = usize::from(da >> 7) + usize::from(sa >> 7);
    let saps_ok = pdu.len() >= saps && pdu[..saps].iter().all(|sap| *sap < 64);
    // Request, not reserved, one of SDA, MSRD, FDL status, SRD, ident, LSAP status.
    let fc_ok = fc & 0xC0 == 0x40 && [0x3, 0x5, 0x7, 0x9, 0xC, 0xD, 0xE, 0xF].contains(&(fc & 0x0F));
    let addresses_ok = da & 0x7F != 127 && sa & 0x7F != 127 && (da & 0x7F) != (sa & 0x7F);
    (format_ok && saps_ok && fc_ok && addresses_ok).then_some(da & 0x7F)
}

fn sum(octets: &[u8]) -> u8 {
    octets.iter().fold(0, |sum, octet| sum.wrapping_add(*octet))
}

/// A telegram of any format with likely and unlikely contents, right in every octet.
fn telegram(random: &mut Random) -> Vec<u8> {
    let pick = |random: &mut Random, likely: &[u8]| {
        if random.below(8) == 0 { random.next() as u8 } else { likely[random.below(likely.len())] }
    };
    let sap = random.below(4) != 0;
    let da = pick(random, &[1, 2, 3, 4, 127]) & 0x7F | if sap { 0x80 } else { 0 };
    let sa = pick(random, &[0, 0, 0, 100]) & 0x7F | if sap { 0x80 } else { 0 };
    let fc = pick(random, &[0x6D, 0x5D, 0x7D, 0x4D, 0x6C, 0x5C, 0x7C, 0x49, 0x46, 0x44, 0x08]);
    let mut body = vec![da, sa, fc];
    if sap {
        body.push(pick(random, &[55, 56, 57, 58, 59, 60, 60, 61, 61, 62, 62, 40]));
        body.push(62);
    }
    let [high, low] = IDENT.to_be_bytes();
    match random.below(8) {
        0 => body.extend_from_slice(&[0xB8, 1, 1, 11, high, low, 0]),
        1 => body.extend_from_slice(&[0x80, 0, 0, 0, 0x0A, 0xC5, 0]),
        2 => body.extend_from_slice(SMALL),
        3 => body.extend_from_slice(&[0xF3, 0xF2]),
        4 => body.extend_from_slice(&[0; SMALL_LEN]),
        5 => body.extend((0..random.below(244)).map(|_| random.next() as u8)),
        _ => {}
    }
    let fcs = sum(&body);
    let mut octets = match body.len() {
        3 => vec![0x10],
        11 if random.below(2) == 0 => vec![0xA2],
        len => vec![0x68, len as u8, len as u8, 0x68],
    };
    octets.append(&mut body);
    octets.extend([fcs, 0x16]);
    octets
}

/// What comes next: a telegram, a telegram with one octet or more wrong, or rubbish.
fn utterance(random: &mut Random) -> Vec<u8> {
    let mut octets = telegram(random);
    match random.below(4) {
        0 | 1 => {}
        2 => {
            for _ in 0..=random.below(3) {
                let at = random.below(octets.len().max(1));
                match (random.below(4), octets.get_mut(at)) {
                    (0, Some(octet)) => *octet = random.next() as u8,
                    (1, Some(octet)) => *octet ^= 1 << random.below(8),
                    (2, Some(_)) => octets.truncate(at.max(1)),
                    _ => octets.insert(0, random.next() as u8),
                }
            }
        }
        _ => {
            octets.clear();
            octets.extend((0..1 + random.below(40)).map(|_| random.next() as u8));
            if random.below(2) == 0 {
                octets[0] = [0x10, 0x68, 0xA2, 0xDC, 0xE5][random.below(5)];
            }
        }
    }
    octets
}

/// For ten million of them set `PROFIDRIVE_LONG`.
#[test]
fn f_23_random_and_damaged_telegrams_get_no_reply_they_must_not_have() {
    let limit: u32 = if long() { 10_000_000 } else { 15_000 };
    let begun = std::time::Instant::now();
    let mut line = line([1, 2], &[SMALL]);
    let bus = line.bus_mut(0).unwrap();
    bus.add(Device::new(Config { timing: Timing::True, ..Config::new(address(3)) }, Instant::ZERO)).unwrap();
    let states = |line: &Line| {
        let bus = line.bus(0).unwrap();
        [
            mirror(line, 1).state(),
            mirror(line, 2).state(),
            bus.station::<Device>(address(3)).unwrap().dp_state(),
        ]
    };
    let mut random = Random(0xD1B5_4A32_D192_ED03);
    let (mut replies, mut entered, mut before) = (0_u32, 0_u32, states(&line));
    for number in 0..limit {
        let octets = utterance(&mut random);
        // The line refuses a reply that is early, late, unasked, from the wrong station, to the wrong master, or no
        // telegram, by our own decoder; and the rules above refuse it once more.
        let reply = line.request(&octets).unwrap_or_else(|breach| panic!("{octets:02X?}: {breach}"));
        let replied = reply.is_some();
        let may = may_answer(&octets).is_some_and(|station| (1..=3).contains(&station));
        assert!(may || !replied, "{octets:02X?} got {reply:02X?}");
        replies += u32::from(replied);
        let now = states(&line);
        for (before, now) in before.into_iter().zip(now) {
            assert!(
                (before, now) != (State::WaitPrm, State::DataExch),
                "Data_Exchange without parameters: {octets:02X?}"
            );
            entered += u32::from(before != State::DataExch && now == State::DataExch);
        }
        before = now;
        // Whatever came before, the first valid request is answered.
        if number % 4 == 0 {
            let station = 1 + (number / 4 % 3) as u8;
            let status = [0x10, station, 100, 0x49, sum(&[station, 100, 0x49]), 0x16];
            let answer = [0x10, 100, station, 0, sum(&[100, station]), 0x16];
            let reply = line.request(&status).unwrap();
            assert_eq!(reply, Some(&answer[..]), "behind {octets:02X?}");
        }
    }
    assert!(replies > limit / 10 && entered > 0, "{replies} replies, Data_Exchange entered {entered} times");
    let bus = line.bus_mut(0).unwrap();
    assert!(
        bus.counters().rejected.reasons().iter().all(|(reason, times)| *reason == "parity" || *times > 0)
    );
    while let Some(event) = bus.poll_event() {
        assert!(!matches!(event, BusEvent::MovedToTakenAddress { .. }), "{event}");
    }
    if long() {
        println!(
            "{limit} telegrams and rubbish, {replies} replies, Data_Exchange entered {entered} times, in {:?}; {}",
            begun.elapsed(),
            bus.counters()
        );
    }
}
