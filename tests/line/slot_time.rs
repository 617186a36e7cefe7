//! Replies that would be too late for the master: dropped and counted on a serial line, sent on the others.

use core::time::Duration;
use std::thread;

use profidrive::devices::StationEvent;
use profidrive::devices::ag03::profibus::{Config, Device, DipSwitches, MAX_TELEGRAM_LEN, Timing};
use profidrive::host::link::pty::Pty;
use profidrive::host::link::serial::Serial;
use profidrive::host::{Bus, BusEvent, Link, Received, SlotTime, Stop, SystemClock, run};
use profidrive::profibus::fdl::Address;
use profidrive::time::{BaudRate, Instant};

const BAUD: BaudRate = BaudRate::K19_2;
/// The beginning of a telegram of 70 octets that never ends, and a Chk_Cfg.
const HALF: [u8; 7] = [0x68, 0x40, 0x40, 0x68, 0x09, 0x02, 0x5D];
const CHK_CFG: [u8; 13] = [0x68, 7, 7, 0x68, 0x85, 0x82, 0x6D, 0x3E, 0x3E, 0xF3, 0xF2, 0xD5, 0x16];
const RS: [u8; 6] = [0x10, 0x02, 0x05, 0x03, 0x0A, 0x16];
/// FDL status of master 2 to station 5, and the reply.
const STATUS: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];
const STATUS_REPLY: [u8; 6] = [0x10, 0x02, 0x05, 0x00, 0x07, 0x16];

fn address(number: u8) -> Address {
    Address::station(number).unwrap()
}

fn bus(slot_time: Option<SlotTime>) -> Bus {
    let mut bus = Bus::on(BAUD, Timing::Untrue);
    bus.set_slot_time(slot_time);
    bus.add(Device::new(Config::new(address(5)), Instant::ZERO)).unwrap();
    bus
}

/// What the bus says until `end`, polled as `run` does, and when.
fn said(bus: &mut Bus, mut now: Instant, end: Instant) -> Vec<(Instant, Vec<u8>)> {
    let mut said = Vec::new();
    let mut buf = [0; MAX_TELEGRAM_LEN];
    loop {
        while let Some(octets) = bus.poll_transmit(now, &mut buf) {
            said.push((now, octets.to_vec()));
        }
        match bus.poll_timeout().filter(|due| *due <= end) {
            Some(due) => now = now.max(due),
            None => return said,
        }
        bus.handle_timeout(now);
    }
}

#[test]
fn a_request_that_is_found_50_ms_late_is_answered_only_where_a_late_reply_does_no_harm() {
    let start = Instant::from_millis(100);
    let asked = Instant::from_millis(104);
    let end = Instant::from_millis(400);
    for (slot_time, answered) in [
        (None, true),
        (Some(SlotTime::Customary), false),
        // 52 ms at 19.2 kbit/s: the 50 ms of waiting, min T_SDR and no more.
        (Some(SlotTime::Bits(1000)), true),
        (Some(SlotTime::Bits(900)), false),
    ] {
        let mut bus = bus(slot_time);
        bus.handle_bytes(start, &HALF);
        assert_eq!(said(&mut bus, start, asked), []);
        bus.handle_bytes(asked, &CHK_CFG);
        let said = said(&mut bus, asked, end);
        let events: Vec<BusEvent> = core::iter::from_fn(|| bus.poll_event()).collect();
        let told = events
            .iter()
            .filter(|event| matches!(event, BusEvent::Station { event: StationEvent::ReplyTooLate(_), .. }))
            .count();
        let counters = *bus.station_counters(address(5)).unwrap();
        assert_eq!(said.len(), usize::from(answered), "{slot_time:?}: {said:02X?}");
        assert_eq!((counters.replies, counters.too_late), (u64::from(answered), u64::from(!answered)));
        assert_eq!(told, usize::from(!answered));
        // The 50 ms are part of the time that the master waited.
        for (at, octets) in said {
            assert_eq!(octets, RS);
            assert!(at.saturating_since(asked) > Duration::from_millis(50));
            let slow: u64 = counters
                .latency
                .buckets()
                .filter(|(limit, _)| limit.is_none_or(|limit| limit > Duration::from_millis(50)))
                .map(|(_, times)| times)
                .sum();
            assert_eq!(slow, 1, "{}", counters.latency);
        }
        // The next request is answered in its time.
        bus.handle_bytes(end, &STATUS);
        let said = self::said(&mut bus, end, end.saturating_add(Duration::from_millis(10)));
        assert!(matches!(&said[..], [(_, octets)] if octets[..] == STATUS_REPLY), "{said:02X?}");
    }
}

#[test]
fn a_loop_that_comes_late_with_its_reply_drops_it() {
    let asked = Instant::from_millis(100);
    for (late, answered) in [(5, true), (6, false)] {
        // 100 bit times at 19.2 kbit/s are 5.2 ms.
        let mut bus = bus(Some(SlotTime::Customary));
        bus.handle_bytes(asked, &STATUS);
        let now = asked.saturating_add(Duration::from_millis(late));
        let reply = bus.poll_transmit(now, &mut [0; MAX_TELEGRAM_LEN]).map(<[u8]>::to_vec);
        assert_eq!(reply.is_some(), answered);
        assert_eq!(bus.station_counters(address(5)).unwrap().too_late, u64::from(!answered));
    }
}

#[test]
fn the_customary_slot_time_is_beyond_the_customary_reply_time_at_every_rate() {
    for rate in BaudRate::ALL {
        // A master must wait at least 15 bit times longer than the slowest slave takes.
        assert!(rate.slot_bits() >= rate.max_tsdr_bits() + 15, "{rate}");
        assert_eq!(SlotTime::Customary.at(rate), SlotTime::Bits(rate.slot_bits()).at(rate));
    }
    assert_eq!(SlotTime::Bits(16_383).at(BAUD), BAUD.bit_times(16_383));
}

/// A terminal stands for the serial port, its other side for the adapter.
#[test]
fn on_a_serial_port_the_late_reply_never_reaches_the_line() {
    // A slot time of 41 ms: longer than a busy machine takes, shorter than half a telegram is waited for.
    let slot_time = SlotTime::Bits(800);
    let mut adapter = Pty::open(None).unwrap();
    let device = adapter.path().to_str().unwrap().to_owned();
    let mut serial = Serial::open(&device, BAUD).unwrap();
    let (stop, clock, mut bus) = (Stop::new().unwrap(), SystemClock::new(), bus(Some(slot_time)));
    let mut heard = Vec::new();
    thread::scope(|scope| {
        let line = scope.spawn(|| run(&mut serial, &mut bus, &clock, &stop, &mut |_| {}));
        let waiting = Stop::new().unwrap();
        let mut listen = |adapter: &mut Pty, until: &dyn Fn(&[u8]) -> bool, limit: Duration| {
            let begun = std::time::Instant::now();
            while begun.elapsed() < limit && !until(&heard) {
                adapter.wait(Some(Duration::from_millis(5)), &waiting).unwrap();
                let mut buf = [0; 64];
                if let Received::Octets(count) = adapter.receive(&mut buf).unwrap() {
                    heard.extend_from_slice(&buf[..count]);
                }
            }
            core::mem::take(&mut heard)
        };
        // A machine may be too busy to send the second in time for the first, not each time.
        let mut late = Vec::new();
        for _ in 0..5 {
            adapter.send(&HALF).unwrap();
            listen(&mut adapter, &|_| false, Duration::from_millis(4));
            adapter.send(&CHK_CFG).unwrap();
            late.extend(listen(&mut adapter, &|_| false, Duration::from_millis(200)));
        }
        let mut status = Vec::new();
        // A machine may be too busy for one answer, not for each of a hundred.
        for _ in 0..100 {
            adapter.send(&STATUS).unwrap();
            let whole = |heard: &[u8]| heard.len() >= STATUS_REPLY.len();
            status = listen(&mut adapter, &whole, Duration::from_millis(100));
            if status == STATUS_REPLY {
                break;
            }
        }
        stop.request();
        line.join().unwrap().unwrap();
        assert!(late.is_empty(), "nothing after the slot time: {late:02X?}");
        assert_eq!(status, STATUS_REPLY, "what is in time is answered");
    });
    assert!(bus.station_counters(address(5)).unwrap().too_late >= 1);
}

#[test]
fn requests_to_an_address_that_a_drive_has_left_are_not_its_own() {
    let mut bus = bus(None);
    let mut now = Instant::from_millis(100);
    let mut ask = |bus: &mut Bus, request: &[u8]| {
        now = now.saturating_add(Duration::from_millis(20));
        bus.handle_bytes(now, request);
        said(bus, now, now.saturating_add(Duration::from_millis(10))).len()
    };
    assert_eq!(ask(&mut bus, &STATUS), 1);
    bus.with(address(5), |drive: &mut Device| {
        drive.power_off(Instant::from_millis(130));
        drive.set_switches(DipSwitches::from(address(6)));
        drive.power_on(Instant::from_millis(140));
    });
    let before = *bus.station_counters(address(6)).unwrap();
    for _ in 0..3 {
        assert_eq!(ask(&mut bus, &STATUS), 0);
    }
    let after = bus.station_counters(address(6)).unwrap();
    assert_eq!(after.requests, before.requests, "they were for address 5");
    assert_eq!(ask(&mut bus, &[0x10, 0x06, 0x02, 0x49, 0x51, 0x16]), 1);
}

#[test]
fn at_a_rate_that_the_drive_does_not_know_it_hears_nothing() {
    for rate in BaudRate::ALL {
        let mut bus = Bus::on(rate, Timing::Untrue);
        bus.add(Device::new(Config::new(address(5)), Instant::ZERO)).unwrap();
        let now = Instant::from_millis(100);
        bus.handle_bytes(now, &STATUS);
        let answers = said(&mut bus, now, now.saturating_add(Duration::from_millis(100))).len();
        assert_eq!(answers, usize::from(![BaudRate::K31_25, BaudRate::K45_45].contains(&rate)), "{rate}");
    }
}

#[test]
fn the_rate_is_searched_among_those_that_a_station_knows() {
    let mut bus = bus(None);
    bus.search_baud(Instant::ZERO);
    let mut tried = std::collections::BTreeSet::from([bus.baud()]);
    for _ in 0..30 {
        let due = bus.poll_timeout().unwrap();
        bus.handle_timeout(due);
        tried.insert(bus.baud());
    }
    assert_eq!(tried.len(), 9);
    assert!(!tried.contains(&BaudRate::K45_45));
}
