//! Several drives on one line, and the loop that runs them, on an in-memory line whose time a test owns.

use core::time::Duration;
use std::collections::VecDeque;
use std::io;

use profidrive::devices::ag03::profibus::{Config, Device, MAX_TELEGRAM_LEN};
use profidrive::host::link::memory::{End, Wire};
use profidrive::host::{Bus, BusEvent, Clock, Link, ManualClock, Received, Stop, run};
use profidrive::profibus::fdl::{Address, Timing};
use profidrive::time::{BaudRate, Instant};

/// FDL status of master 2 to station 5, and the reply of station 5.
const STATUS: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];
const STATUS_REPLY: [u8; 6] = [0x10, 0x02, 0x05, 0x00, 0x07, 0x16];

fn drive(address: u8) -> Device {
    Device::new(Config::new(Address::station(address).unwrap()), Instant::ZERO)
}

fn bus(addresses: &[u8]) -> Bus {
    let mut bus = Bus::new();
    for &address in addresses {
        bus.add(drive(address)).unwrap();
    }
    bus
}

/// Everything the drives send in the 10 ms after `now`, in order.
fn sent(bus: &mut Bus, now: Instant) -> Vec<u8> {
    let end = now.saturating_add(Duration::from_millis(10));
    let mut now = now;
    let mut sent = Vec::new();
    let mut buf = [0xA5; MAX_TELEGRAM_LEN];
    loop {
        while let Some(telegram) = bus.poll_transmit(now, &mut buf) {
            sent.extend_from_slice(telegram);
        }
        match bus.poll_timeout() {
            Some(deadline) if deadline <= end => now = now.max(deadline),
            Some(_) | None => return sent,
        }
        bus.handle_timeout(now);
    }
}

#[test]
fn a_second_drive_on_one_address_is_refused_by_name_and_the_first_stays() {
    let mut bus = bus(&[5, 6]);
    let error = bus.add(drive(5)).unwrap_err();
    assert_eq!(error.to_string(), "two drives have address 5; give each drive its own");
    assert_eq!(bus.addresses().map(Address::number).collect::<Vec<_>>(), [5, 6]);
}

#[test]
fn of_several_drives_the_one_that_is_asked_replies() {
    let mut bus = bus(&[4, 5, 6]);
    let now = Instant::from_millis(1);
    bus.handle_bytes(now, &STATUS);
    assert_eq!(sent(&mut bus, now), STATUS_REPLY);
}

#[test]
fn half_a_telegram_and_a_reply_do_not_survive_a_reset() {
    let mut bus = bus(&[5]);
    let now = Instant::from_millis(1);
    bus.handle_bytes(now, &STATUS);
    bus.handle_reset();
    assert_eq!(sent(&mut bus, now), [0; 0]);

    let now = Instant::from_millis(20);
    bus.handle_bytes(now, &[0x68, 0x0B, 0x0B]);
    bus.handle_reset();
    bus.handle_bytes(now, &STATUS);
    assert_eq!(sent(&mut bus, now), STATUS_REPLY);
}

/// The drives' end of an in-memory line on which sleeping moves the clock instead of taking time. Each sleep brings
/// the next octets of the script; the sleep after the last requests the stop.
struct Scripted {
    end: End,
    master: End,
    clock: ManualClock,
    script: VecDeque<Vec<u8>>,
    sleeps: Vec<Option<Duration>>,
    resolution: Duration,
    /// When each telegram of the drives was sent, and after how many sleeps.
    replies: Vec<(Instant, usize)>,
}

impl Link for Scripted {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        self.end.receive(buf)
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        self.replies.push((self.clock.now(), self.sleeps.len()));
        self.end.send(telegram)
    }

    fn resolution(&self) -> Duration {
        self.resolution
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        self.sleeps.push(timeout);
        let next = self.script.pop_front();
        let slept = match (timeout, &next) {
            // Octets end a sleep before its time.
            (Some(timeout), Some(octets)) if !octets.is_empty() => timeout / 2,
            (Some(timeout), Some(_) | None) => timeout,
            (None, Some(_) | None) => Duration::from_millis(10),
        };
        self.clock.advance(slept);
        match next {
            Some(octets) => self.master.send(&octets),
            None => {
                stop.request();
                Ok(())
            }
        }
    }
}

/// A drive at address 5 and what it hears.
fn scripted(script: &[&[u8]]) -> (Scripted, Bus, ManualClock) {
    let wire = Wire::new();
    let clock = ManualClock::new();
    let link = Scripted {
        end: wire.end(),
        master: wire.end(),
        clock: clock.clone(),
        script: script.iter().map(|octets| octets.to_vec()).collect(),
        sleeps: Vec::new(),
        resolution: Duration::ZERO,
        replies: Vec::new(),
    };
    (link, bus(&[5]), clock)
}

/// Runs the script to its end: the news of the bus.
fn play(link: &mut Scripted, bus: &mut Bus, clock: &ManualClock) -> Vec<BusEvent> {
    let stop = Stop::new().unwrap();
    let mut news = Vec::new();
    run(link, bus, clock, &stop, &mut |event| news.push(event)).unwrap();
    news
}

#[test]
fn a_request_cut_in_two_is_answered_over_the_link() {
    let (mut link, mut bus, clock) = scripted(&[&STATUS[..2], &STATUS[2..], &[], &[]]);
    play(&mut link, &mut bus, &clock);
    let mut reply = [0; 16];
    assert_eq!(link.master.receive(&mut reply).unwrap(), Received::Octets(6));
    assert_eq!(reply[..6], STATUS_REPLY);
}

#[test]
fn after_a_delay_only_the_newest_of_several_requests_is_answered() {
    let (mut link, mut bus, clock) = scripted(&[&STATUS.repeat(3), &[], &[]]);
    play(&mut link, &mut bus, &clock);
    assert_eq!(link.master.receive(&mut [0; 64]).unwrap(), Received::Octets(6));
}

#[test]
fn everything_that_arrives_is_taken() {
    let (mut link, mut bus, clock) = scripted(&[&[0xFF; 4000], &[0x00; 3000]]);
    play(&mut link, &mut bus, &clock);
    assert_eq!(link.end.receive(&mut [0; 1]).unwrap(), Received::Nothing);
    assert_eq!(link.end.lost(), 0);
}

#[test]
fn noise_is_said_once_however_many_drives_hear_it() {
    let (mut link, mut bus, clock) = scripted(&[&[0xFF]]);
    bus.add(drive(6)).unwrap();
    let news = play(&mut link, &mut bus, &clock);
    assert!(matches!(news[..], [BusEvent::TelegramRefused(_)]), "{news:?}");
    assert_eq!((bus.counters().rejected.start_delimiter, bus.counters().resyncs), (1, 1));
}

#[test]
fn news_of_a_drive_reach_the_caller_with_its_address() {
    // Set_Prm with the ident number of another device.
    let prm = [0x68, 12, 12, 0x68, 0x85, 0x82, 0x6D, 0x3D, 0x3E, 0x80, 1, 1, 11, 0x12, 0x34, 0, 0xC2, 0x16];
    let (mut link, mut bus, clock) = scripted(&[&prm]);
    let news = play(&mut link, &mut bus, &clock);
    let [BusEvent::Station { address, event }] = &news[..] else { panic!("{news:?}") };
    assert_eq!(address.number(), 5);
    assert!(event.to_string().contains("refused the parameters of master 2"), "{event}");
}

#[test]
fn a_stop_requested_before_the_start_ends_the_loop_without_sleep() {
    let (mut link, mut bus, clock) = scripted(&[&[0x10]]);
    let stop = Stop::new().unwrap();
    stop.request();
    run(&mut link, &mut bus, &clock, &stop, &mut |_| {}).unwrap();
    assert_eq!(link.sleeps, []);
}

#[test]
fn a_sleep_ends_at_the_next_deadline_and_a_drive_at_rest_has_none() {
    let (mut link, mut bus, clock) = scripted(&[&[][..]; 8]);
    let first = bus.poll_timeout().map(|deadline| deadline.saturating_since(clock.now()));
    play(&mut link, &mut bus, &clock);
    assert_eq!(link.sleeps[0], first);
    assert_eq!(link.sleeps.last(), Some(&None), "{:?}", link.sleeps);
}

/// How long after its request a drive replies, how often the loop sleeps for that, and what is counted.
fn reply_time(resolution: Duration, baud: BaudRate) -> (Duration, usize, String) {
    let (mut link, _, clock) = scripted(&[&STATUS, &[]]);
    let mut bus = Bus::on(baud, Timing::Untrue);
    bus.add(drive(5)).unwrap();
    // The drive comes to rest, and has no deadline of its own then.
    sent(&mut bus, Instant::ZERO);
    assert_eq!(bus.poll_timeout(), None);
    link.resolution = resolution;
    play(&mut link, &mut bus, &clock);
    let counted = bus.station_counters(Address::station(5).unwrap()).unwrap().latency.to_string();
    let (at, sleeps) = link.replies[0];
    // One sleep brings the request.
    (at.saturating_since(Instant::from_millis(10)), sleeps - 1, counted)
}

#[test]
fn a_reply_that_is_due_sooner_than_a_link_can_show_takes_no_sleep() {
    let fine = Duration::from_micros(50);
    let (k500, k187) = (BaudRate::K500, BaudRate::K187_5);
    let (soon, later) = ("after <=50µs: 1", "after <=100µs: 1");
    assert_eq!(reply_time(Duration::ZERO, k500), (k500.bit_times(11), 1, soon.into()), "22 us are kept");
    assert_eq!(reply_time(fine, k500), (Duration::ZERO, 0, soon.into()), "counted is what the master set");
    assert_eq!(reply_time(fine, k187), (k187.bit_times(11), 1, later.into()), "59 us are kept");
}
