//! Many stations on one simulated line: a full bus, groups, stations that come and go and move. The line itself checks
//! the rules of the bus all the time.
use core::time::Duration;

use profidrive::bench::{Answer, Line, ScriptedMaster as Master};
use profidrive::devices::StationEvent;
use profidrive::devices::ag03::profibus::{Config, Device, MAX_TELEGRAM_LEN, Timing};
use profidrive::host::{Bus, BusEvent, Participant};
use profidrive::profibus::dp;
use profidrive::profibus::dp::{Description, State};
use profidrive::profibus::fdl::{Address, ReplyStatus, Sap, Telegram};
use profidrive::time::{BaudRate, Instant};

use crate::mirror_slaves::{
    BAUD, IDENT, LARGE, Mirror, SMALL, SMALL_LEN, address, inputs, line, long, mirror, outputs, start_up,
};

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
fn n_02_a_broadcast_ends_the_time_of_a_reply_and_acts_once() {
    let mut line = line(1..=3, &[SMALL]);
    let mut master = Master::new(address(0));
    for number in 1..=3 {
        start_up(&mut line, &mut master, number, 0, SMALL);
    }
    let now = line.now().saturating_add(BAUD.bit_times(33));
    let bus = line.bus_mut(0).unwrap();
    while bus.poll_event().is_some() {}
    bus.handle_bytes(now, &[0x10, 2, 0, 0x49, 0x4B, 0x16]);
    // Clear_Data to all before the host found time to send the reply of station 2.
    let later = now.saturating_add(Duration::from_micros(50));
    bus.handle_bytes(later, &[0x68, 7, 7, 0x68, 0xFF, 0x80, 0x46, 0x3A, 0x3E, 0x02, 0, 0x3F, 0x16]);
    assert_eq!(bus.poll_transmit(later, &mut [0; MAX_TELEGRAM_LEN]), None);
    let mut cleared = Vec::new();
    while let Some(event) = bus.poll_event() {
        let BusEvent::Station { address, event: StationEvent::Dp(dp::Event::Controlled { .. }) } = event
        else {
            panic!("{event}");
        };
        cleared.push(address.number());
    }
    assert_eq!(cleared, [1, 2, 3]);
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
                line.wait(line.slot_time()).unwrap();
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
    let description = Description { ident: IDENT, ..Description::default() };
    let application = dp::Fixed { configurations: &[SMALL], ..dp::Fixed::PLAIN };
    bus.add(dp::Station::new(address(3), BAUD, None, description, application)).unwrap();
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

/// A station that takes the address in the last octet of any SDN to it, as Set_Slave_Add would make it, and answers
/// FDL status.
struct Settler(dp::Station, Address);

impl Participant for Settler {
    fn address(&self) -> Address {
        self.1
    }
    fn set_baud(&mut self, _: BaudRate) {}
    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, _: &mut dyn FnMut(StationEvent)) {
        let Telegram::Data(data) = telegram else { return };
        match data.data.last() {
            Some(new) => *self = Self::at(*new),
            None => drop(self.0.handle_telegram(now, telegram)),
        }
    }
    fn handle_timeout(&mut self, _: Instant, _: &mut dyn FnMut(StationEvent)) {}
    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        Participant::poll_transmit(&mut self.0, now, buf, news)
    }
    fn poll_timeout(&self) -> Option<Instant> {
        self.0.poll_timeout()
    }
    fn watchdog_on(&self) -> bool {
        false
    }
}

impl Settler {
    fn at(number: u8) -> Self {
        let max_tsdr = Some(BAUD.max_tsdr_bits());
        let station =
            dp::Station::new(address(number), BAUD, max_tsdr, Description::default(), dp::Fixed::PLAIN);
        Self(station, address(number))
    }
}

#[test]
fn a_station_that_gets_another_address_is_found_there_unless_it_is_taken() {
    let mut line = line([7], &[SMALL]);
    line.bus_mut(0).unwrap().add(Settler::at(126)).unwrap();
    let mut master = Master::new(address(0));
    let give = |line: &mut Line, master: &mut Master, from: u8, to: u8| {
        master.sdn(line, address(from), Sap::new(55).unwrap(), &[to]).unwrap();
    };
    let there = |line: &mut Line, master: &mut Master, numbers: [u8; 3]| {
        numbers.map(|number| master.fdl_status(line, address(number)).unwrap())
    };
    assert_eq!(there(&mut line, &mut master, [126, 9, 7]), [true, false, true]);
    give(&mut line, &mut master, 126, 9);
    assert_eq!(there(&mut line, &mut master, [9, 126, 7]), [true, false, true]);
    line.bus_mut(0).unwrap().add(Settler::at(126)).unwrap();
    assert_eq!(there(&mut line, &mut master, [126, 9, 7]), [true, true, true], "the next one at 126");
    give(&mut line, &mut master, 126, 7);
    assert_eq!(there(&mut line, &mut master, [126, 9, 7]), [false, true, true]);
    let moved = BusEvent::MovedToTakenAddress { from: address(126), to: address(7) };
    assert_eq!(line.bus_mut(0).unwrap().poll_event(), Some(moved));
    let left: Vec<_> = line.bus(0).unwrap().addresses().map(Address::number).collect();
    assert_eq!(left, [7, 9]);
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
