//! On the way from octets to the reply, and in the application cycle, nothing is allocated: not by a device, and by a bus
//! of many only what is told of the events of a device. (The core cannot: it builds without an allocator. This is about `host::Bus`, and keeps both so.)
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a test may panic, and has std"
)]
#![cfg(feature = "std")]

use core::time::Duration;

use profidrive::devices::StationEvent;
use profidrive::devices::ag03::profibus::{Config, Device, MAX_TELEGRAM_LEN, Timing};
use profidrive::gsd::{Gsd, Policy, Station};
use profidrive::host::link::tap::{Batch, Tap, Watchers};
use profidrive::host::{Bus, BusEvent, GsdStation, Link, ManualClock, Received, Refusals, Stop, ValueBoard};
use profidrive::process::{Input, Origin, Point, Signal, Source, ValueType};
use profidrive::profibus::dp::Application;
use profidrive::profibus::fdl::{Address, DataTelegram, FunctionCode, Sap};
use profidrive::time::{BaudRate, Instant};

const BAUD: BaudRate = BaudRate::K12000;

fn address(number: u8) -> Address {
    Address::station(number).unwrap()
}

fn telegram(da: u8, fc: u8, sap: Option<u8>, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
    let telegram = DataTelegram {
        format: DataTelegram::customary_format(dsap, ssap, data),
        da: Address::from_octet(da),
        sa: address(0),
        dsap,
        ssap,
        fc: FunctionCode::from_octet(fc),
        data,
    };
    telegram.encode(&mut [0; MAX_TELEGRAM_LEN]).unwrap().to_vec()
}

/// Everything a master says to one drive: start-up, enabling, a travel job with PKW jobs under way, retries, diagnosis,
/// a refusal, and what is no telegram.
fn script(da: u8) -> Vec<Vec<u8>> {
    let mut script = vec![
        telegram(da, 0x49, None, &[]),
        telegram(da, 0x6D, Some(60), &[]),
        telegram(da, 0x5D, Some(61), &[0x80, 1, 1, 11, 0x0A, 0xC5, 0]),
        telegram(da, 0x7D, Some(62), &[0xF3, 0xF2]),
    ];
    let jobs: [[u8; 8]; 6] = [
        [0; 8],
        // Read PNU 1036 (position), write PNU 1008 (v-Pos), read an unknown one, read element 2 of PNU 945, a write
        // refused under way: PNU 970.
        [0x14, 0x0C, 0, 0, 0, 0, 0, 0],
        [0x23, 0xF0, 0, 0, 0, 0, 0, 50],
        [0x17, 0xCF, 0, 0, 0, 0, 0, 0],
        [0x63, 0xB1, 2, 0, 0, 0, 0, 0],
        [0x23, 0xCA, 0, 0, 0, 0, 0, 1],
    ];
    let mut even = true;
    for stw in [0x0B, 0x3B, 0x7B] {
        for pkw in jobs {
            let data = [&pkw[..], &[0, stw], &100_000_i32.to_be_bytes()].concat();
            let request = telegram(da, if even { 0x5D } else { 0x7D }, None, &data);
            even = !even;
            // The second one is a retry.
            script.extend([request.clone(), request]);
        }
    }
    script.push(telegram(da, if even { 0x5D } else { 0x7D }, Some(60), &[]));
    script.push(telegram(da, 0x46, Some(58), &[0x20, 0]));
    script.push(vec![0x68, 0x11, 0x12, 0x68, 0xFF]);
    script.push(vec![0xDC, 2, 3]);
    script
}

/// How often the allocator was asked meanwhile, a result apart.
fn allocations<T>(act: impl FnOnce() -> T) -> (u64, T) {
    let mut result = None;
    let counted = allocation_counter::measure(|| result = Some(act()));
    (counted.count_total, result.unwrap())
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| Box::new(1_u8)).0, 1);
    assert_eq!(allocations(|| 1 + 1).0, 0);
}

#[test]
fn a_device_allocates_nothing_from_octets_to_the_reply_and_in_its_cycles() {
    let config = Config { baud: BAUD, timing: Timing::True, ..Config::new(address(5)) };
    let mut device = Device::new(config, Instant::ZERO);
    let script = script(5);
    let mut buf = [0; MAX_TELEGRAM_LEN];
    let (count, (replies, news)) = allocations(|| {
        let (mut now, mut replies, mut news) = (Instant::ZERO, 0, 0);
        for octets in &script {
            // In two pieces, so that the framer has to keep one.
            let (first, second) = octets.split_at(octets.len() / 2);
            now = now.saturating_add(Duration::from_millis(3));
            device.handle_timeout(now);
            device.handle_bytes(now, first);
            device.handle_bytes(now, second);
            let due = now.saturating_add(BAUD.bit_times(11));
            replies += u32::from(device.poll_transmit(due, &mut buf).is_some());
            while device.poll_event().is_some() {
                news += 1;
            }
        }
        device.handle_timeout(now.saturating_add(Duration::from_secs(10)));
        (replies, news)
    });
    assert!(device.status().travelling, "the script makes it travel");
    assert!(replies > 35 && news > 3, "{replies} replies, {news} news");
    assert_eq!(count, 0);
}

/// A master that asks the same for ever.
struct Asked([u8; 6]);

impl Link for Asked {
    fn receive(&mut self, buf: &mut [u8]) -> std::io::Result<Received> {
        buf[..6].copy_from_slice(&self.0);
        Ok(Received::Octets(6))
    }
    fn send(&mut self, _: &[u8]) -> std::io::Result<()> {
        Ok(())
    }
    fn wait(&mut self, _: Option<Duration>, _: &Stop) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_tap_allocates_nothing_while_nobody_watches() {
    let (watchers, stop) = (Watchers::default(), Stop::new().unwrap());
    let asked = Asked([0x10, 0x05, 0x02, 0x49, 0x50, 0x16]);
    let mut shown = 0;
    let observer = |batch: &Batch| shown += batch.iter().count();
    let mut tap = Tap::new(asked, ManualClock::new(), observer).only_for(watchers.clone());
    let mut pass = || {
        for _ in 0..1000 {
            tap.receive(&mut [0; 16]).unwrap();
            tap.send(&[0x10, 0x02, 0x05, 0x00, 0x07, 0x16]).unwrap();
            tap.wait(None, &stop).unwrap();
        }
    };
    assert_eq!(allocations(&mut pass).0, 0, "never watched");
    let watch = watchers.watch();
    assert!(allocations(&mut pass).0 > 0, "watched");
    drop(watch);
    assert_eq!(allocations(&mut pass).0, 0, "no longer watched");
    drop(tap);
    assert_eq!(shown, 2000);
}

#[test]
fn a_bus_of_125_drives_allocates_what_it_tells_of_its_devices_and_nothing_else() {
    let mut bus = Bus::on(BAUD, Timing::True);
    for number in 1..=125 {
        let config = Config { baud: BAUD, timing: Timing::True, ..Config::new(address(number)) };
        bus.add(Device::new(config, Instant::ZERO)).unwrap();
    }
    let scripts: Vec<_> = (1..=125).map(script).collect();
    let mut buf = [0; MAX_TELEGRAM_LEN];
    let mut now = Instant::ZERO;
    let mut play = |turn: usize, drain: bool| {
        let (mut replies, mut told) = (0, 0);
        for script in &scripts {
            now = now.saturating_add(Duration::from_micros(100));
            bus.handle_timeout(now);
            bus.handle_bytes(now, &script[turn]);
            let due = now.saturating_add(BAUD.bit_times(11));
            replies += u32::from(bus.poll_transmit(due, &mut buf).is_some());
            while drain && let Some(event) = bus.poll_event() {
                told += u64::from(matches!(event, BusEvent::Station { event: StationEvent::Device(_), .. }));
            }
        }
        (replies, told)
    };
    // The list of news grows to what the host leaves in it, once.
    let turns = scripts[0].len();
    for turn in 0..turns {
        let _first = play(turn, turn % 2 == 1);
    }
    for turn in 0..turns {
        let (count, (replies, told)) = allocations(|| play(turn, true));
        // An event of a device is shared by all who are told. What the same one refuses again and again is counted, not told.
        let most = told.max(u64::from(replies)) + 6;
        assert!(
            (told..=most).contains(&count),
            "turn {turn}, {replies} replies, {told} told, {count} allocations"
        );
    }
    bus.handle_timeout(now.saturating_add(Duration::from_millis(10)));
    let travelling = (1..=125).filter(|number| {
        let device: &Device = bus.station(address(*number)).unwrap();
        device.status().moving
    });
    assert_eq!(travelling.count(), 125);
}

/// 125 of the longest stations of a GSD, each with an input that mirrors an output: Data_Exchange is told on the board, moves
/// the input, and allocates nothing.
#[test]
fn the_exchange_of_125_stations_from_gsds_allocates_nothing() {
    let file = format!(
        "#Profibus_DP\nIdent_Number=0x0ABC\nModule=\"long\" {}\nEndModule\n",
        ["0x5F,0x5F,0x5F,0x5F,0x5F,0x5F,0x5F,0x59", "0x6F,0x6F,0x6F,0x6F,0x6F,0x6F,0x6F,0x69"].join(",")
    );
    let (last, board) = (Point { slot: 1, offset: 242, kind: ValueType::Unsigned16 }, ValueBoard::default());
    let mut bus = Bus::on(BAUD, Timing::Untrue);
    let mut cfg = Vec::new();
    for number in 1..=125 {
        let station = Station::new(Gsd::read(file.as_bytes()).unwrap(), Policy::PROPOSED).unwrap();
        cfg = station.configuration(None).to_vec();
        let mut station =
            GsdStation::new(address(number), BAUD, station, Refusals::default()).on_board(board.clone());
        let mirror = Source::Follow { of: Origin::Output(last), delay: Duration::ZERO };
        station.connect(Input::new(last, Signal::new(mirror).unwrap()));
        bus.add(station).unwrap();
    }
    let mut buf = [0; MAX_TELEGRAM_LEN];
    let mut now = Instant::ZERO;
    let mut say = |bus: &mut Bus, octets: &[u8]| {
        bus.handle_bytes(now, octets);
        now = now.saturating_add(Duration::from_millis(1));
        bus.handle_timeout(now);
        let reply = bus.poll_transmit(now, &mut buf).map(<[u8]>::len);
        while bus.poll_event().is_some() {}
        reply
    };
    for number in 1..=125 {
        say(&mut bus, &telegram(number, 0x6D, Some(61), &[0x80, 1, 1, 11, 0x0A, 0xBC, 0]));
        say(&mut bus, &telegram(number, 0x5D, Some(62), &cfg));
    }
    let round = |n: u8| -> Vec<Vec<u8>> {
        let fc = if n.is_multiple_of(2) { 0x7D } else { 0x5D };
        (1..=125).map(|number| telegram(number, fc, None, &[n; 244])).collect()
    };
    // The board learns the lengths with the first ones.
    assert!(round(0).iter().all(|octets| say(&mut bus, octets) == Some(253)));
    let rounds: Vec<_> = (1..10).flat_map(round).collect();
    let (count, replies) =
        allocations(|| rounds.iter().filter(|octets| say(&mut bus, octets).is_some()).count());
    assert_eq!((count, replies), (0, 9 * 125));
    let station = bus.station::<GsdStation>(address(125)).unwrap();
    assert_eq!(station.slave().inputs()[242..], [9, 9]);
}
