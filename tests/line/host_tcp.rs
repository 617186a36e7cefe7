//! The TCP link, seen from its clients.

use core::time::Duration;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::thread;
use std::time::Instant;

use profidrive::devices::ag03::profibus::{Config, Device};
use profidrive::host::link::tap::{Batch, Tap};
use profidrive::host::link::tcp::{MAX_BACKLOG, MAX_BURST, MAX_CLIENTS, Reach, Tcp};
use profidrive::host::{Bus, Clock, Error, Link, ManualClock, Received, Stop, SystemClock, run};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, FrameCount, FunctionCode, Service, Telegram};
use profidrive::time::BaudRate;

use crate::drive_line::{CFG, IDENT, telegram};
use crate::patience::PATIENCE;

mod masters;

const ASK_5: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];
const ASK_6: [u8; 6] = [0x10, 0x06, 0x03, 0x49, 0x52, 0x16];

fn bind() -> Tcp {
    Tcp::bind("127.0.0.1:0", BaudRate::K500, Reach::ThisMachine).unwrap()
}

/// A program at the line.
struct Client(TcpStream);

impl Client {
    fn connect(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_nodelay(true).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        Self(stream)
    }

    /// Connected and taken in.
    fn join<C: Clock>(tcp: &mut Tcp<C>) -> Self {
        let before = tcp.clients();
        let client = Self::connect(tcp.address());
        settle(tcp, |tcp| tcp.clients() == before + 1);
        client
    }

    fn write(&mut self, octets: &[u8]) {
        self.0.write_all(octets).unwrap();
    }

    fn reads(&mut self, octets: &[u8]) {
        let mut read = vec![0; octets.len()];
        self.0.read_exact(&mut read).unwrap();
        assert_eq!(read, octets);
    }

    fn reads_nothing_now(&mut self) {
        self.0.set_nonblocking(true).unwrap();
        let error = self.0.read(&mut [0; 16]).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::WouldBlock);
        self.0.set_nonblocking(false).unwrap();
    }

    fn is_dropped(&mut self) -> bool {
        let mut buf = [0; 65536];
        loop {
            match self.0.read(&mut buf) {
                Ok(0) => return true,
                Ok(_) => {}
                Err(error) => return error.kind() != ErrorKind::WouldBlock,
            }
        }
    }
}

/// Lets the link work until `done`; what the drives heard meanwhile.
fn settle<C: Clock>(tcp: &mut Tcp<C>, mut done: impl FnMut(&mut Tcp<C>) -> bool) -> Vec<u8> {
    let (start, stop) = (Instant::now(), Stop::new().unwrap());
    let mut heard = Vec::new();
    let mut buf = [0; 2048];
    while !done(tcp) {
        assert!(start.elapsed() < PATIENCE, "nothing came; heard {} octets", heard.len());
        tcp.wait(Some(Duration::from_millis(10)), &stop).unwrap();
        if let Received::Octets(count) = tcp.receive(&mut buf).unwrap() {
            heard.extend_from_slice(&buf[..count]);
        }
    }
    heard
}

/// What the drives hear, so many octets.
fn hear<C: Clock>(tcp: &mut Tcp<C>, count: usize) -> Vec<u8> {
    let (start, stop) = (Instant::now(), Stop::new().unwrap());
    let mut heard = Vec::new();
    let mut buf = [0; 2048];
    while heard.len() < count {
        assert!(start.elapsed() < PATIENCE, "heard only {heard:02X?}");
        tcp.wait(Some(Duration::from_millis(10)), &stop).unwrap();
        if let Received::Octets(count) = tcp.receive(&mut buf).unwrap() {
            heard.extend_from_slice(&buf[..count]);
        }
    }
    heard
}

/// What breaks off next.
fn breaks_off(tcp: &mut Tcp) -> Vec<u8> {
    let (start, stop) = (Instant::now(), Stop::new().unwrap());
    let mut buf = [0; 2048];
    loop {
        assert!(start.elapsed() < PATIENCE, "nothing broke off");
        tcp.wait(Some(Duration::from_millis(10)), &stop).unwrap();
        match tcp.receive(&mut buf).unwrap() {
            Received::BrokenOff(count) => return buf[..count].to_vec(),
            Received::Nothing => {}
            other => panic!("{other:?}"),
        }
    }
}

fn hears_nothing_for<C: Clock>(tcp: &mut Tcp<C>, time: Duration) {
    let start = Instant::now();
    assert_eq!(settle(tcp, |_| start.elapsed() >= time), [0; 0]);
}

/// Ends the run loop, also when a test panics.
struct Ending(Stop);

impl Drop for Ending {
    fn drop(&mut self) {
        self.0.request();
    }
}

#[test]
fn every_client_hears_the_others_and_the_drives_and_not_itself() {
    let mut tcp = bind();
    let (mut a, mut b, mut c) = (Client::join(&mut tcp), Client::join(&mut tcp), Client::join(&mut tcp));
    a.write(&[1, 2, 3]);
    assert_eq!(hear(&mut tcp, 3), [1, 2, 3]);
    b.reads(&[1, 2, 3]);
    c.reads(&[1, 2, 3]);
    tcp.send(&[0xE5]).unwrap();
    for client in [&mut a, &mut b, &mut c] {
        client.reads(&[0xE5]);
        client.reads_nothing_now();
    }
}

#[test]
fn telegrams_of_two_clients_are_never_mixed() {
    let mut tcp = bind();
    let (mut a, mut b) = (Client::join(&mut tcp), Client::join(&mut tcp));
    for cut in 1..ASK_5.len() {
        a.write(&ASK_5[..cut]);
        hears_nothing_for(&mut tcp, Duration::from_millis(2));
        b.write(&ASK_6);
        assert_eq!(hear(&mut tcp, 6), ASK_6);
        a.reads(&ASK_6);
        tcp.send(&[0xE5]).unwrap();
        a.write(&ASK_5[cut..]);
        assert_eq!(hear(&mut tcp, 6), ASK_5);
        b.reads(&[0xE5]);
        b.reads(&ASK_5);
        a.reads(&[0xE5]);
        tcp.send(&[0xE5]).unwrap();
        a.reads(&[0xE5]);
        b.reads(&[0xE5]);
    }
}

#[test]
fn a_request_waits_for_the_reply_to_the_one_before() {
    let clock = ManualClock::new();
    let mut tcp = Tcp::bind_with("127.0.0.1:0", BaudRate::K9_6, Reach::ThisMachine, clock.clone()).unwrap();
    let (mut a, mut b) = (Client::join(&mut tcp), Client::join(&mut tcp));
    a.write(&ASK_5);
    assert_eq!(hear(&mut tcp, 6), ASK_5);
    b.write(&ASK_6);
    hears_nothing_for(&mut tcp, Duration::from_millis(5));
    tcp.send(&[0xE5]).unwrap();
    assert_eq!(hear(&mut tcp, 6), ASK_6);
    // Nobody replies: after the slot time, 300 T_bit and 1 ms, the next is heard.
    a.write(&ASK_5);
    hears_nothing_for(&mut tcp, Duration::from_millis(5));
    clock.advance(Duration::from_millis(25));
    hears_nothing_for(&mut tcp, Duration::from_millis(5));
    clock.advance(Duration::from_millis(15));
    assert_eq!(hear(&mut tcp, 6), ASK_5);
    // A reply by another client ends the time as well, and is not kept waiting.
    b.write(&[0xE5]);
    assert_eq!(hear(&mut tcp, 1), [0xE5]);
    b.write(&ASK_6);
    assert_eq!(hear(&mut tcp, 6), ASK_6);
}

#[test]
fn half_a_telegram_costs_the_others_nothing_and_is_given_up_after_50_ms() {
    let mut tcp = bind();
    let (mut slow, mut b) = (Client::join(&mut tcp), Client::join(&mut tcp));
    slow.write(&[0x68, 0x20, 0x20, 0x68, 1, 2, 3]);
    settle(&mut tcp, |tcp| {
        b.write(&ASK_6);
        let heard = hear(tcp, 6);
        assert_eq!(heard, ASK_6);
        tcp.send(&[0xE5]).unwrap();
        b.reads(&[0xE5]);
        true
    });
    // No other client hears it in the end, which would wait for its rest; the drives hear that it broke off.
    assert_eq!(breaks_off(&mut tcp), [0x68, 0x20, 0x20, 0x68, 1, 2, 3]);
    b.reads_nothing_now();
    slow.write(&ASK_5);
    assert_eq!(hear(&mut tcp, 6), ASK_5);
    b.reads(&ASK_5);
}

#[test]
fn what_broke_off_is_shown_and_counted_and_never_meets_the_octets_of_another() {
    let (tcp, stop) = (bind(), Stop::new().unwrap());
    let (address, ending) = (tcp.address(), stop.clone());
    let running = thread::spawn(move || {
        let mut shown = Vec::new();
        let clock = SystemClock::new();
        let mut bus = Bus::new();
        bus.add(Device::new(Config::new(Address::station(5).unwrap()), clock.now())).unwrap();
        let mut tap = Tap::new(tcp, clock, |batch: &Batch| {
            shown.extend(batch.iter().map(|seen| (seen.octets.to_vec(), seen.telegram.is_ok())));
        });
        run(&mut tap, &mut bus, &clock, &ending, &mut |_| {}).unwrap();
        drop(tap);
        (shown, bus.counters().rejected.broken_off)
    });
    let _ending = Ending(stop.clone());
    let (mut a, mut b) = (Client::connect(address), Client::connect(address));
    let (halves, reply) =
        ([&ASK_5[..5], &[0x68, 0x11, 0x11, 0x68, 5, 2]], [0x10, 0x02, 0x05, 0x00, 0x07, 0x16]);
    for (number, half) in halves.into_iter().enumerate() {
        a.write(half);
        // The second one ends with its client instead of after 50 ms.
        if number == 1 {
            drop(a.0.shutdown(Shutdown::Both));
        }
        thread::sleep(Duration::from_millis(100));
        b.write(&ASK_5);
        b.reads(&reply);
    }
    stop.request();
    let (shown, broken_off) = running.join().unwrap();
    let telegram = |octets: &[u8]| (octets.to_vec(), true);
    let half = |octets: &[u8]| (octets.to_vec(), false);
    let (ask, reply) = (telegram(&ASK_5), telegram(&reply));
    assert_eq!(shown, [half(halves[0]), ask.clone(), reply.clone(), half(halves[1]), ask, reply]);
    assert_eq!(broken_off, 2);
}

#[test]
fn a_client_that_drips_octets_delays_nobody() {
    // On a clock that stands still half a telegram is never given up.
    let mut tcp =
        Tcp::bind_with("127.0.0.1:0", BaudRate::K500, Reach::ThisMachine, ManualClock::new()).unwrap();
    let (mut slow, mut b) = (Client::join(&mut tcp), Client::join(&mut tcp));
    for octet in [0x68, 0xF9, 0xF9, 0x68].into_iter().chain([0x68; 60]) {
        slow.write(&[octet]);
        b.write(&ASK_6);
        assert_eq!(hear(&mut tcp, 6), ASK_6);
        tcp.send(&[0xE5]).unwrap();
    }
}

#[test]
fn the_port_is_of_this_machine_unless_told_otherwise() {
    for place in ["0.0.0.0:0", "[::]:0", "192.0.2.1:0"] {
        let refused = Tcp::bind(place, BaudRate::K500, Reach::ThisMachine);
        assert!(matches!(refused, Err(Error::TcpReach { .. })), "{place}: {refused:?}");
    }
    let tcp = Tcp::bind("localhost:0", BaudRate::K500, Reach::ThisMachine).unwrap();
    assert!(tcp.address().ip().is_loopback() && tcp.address().port() != 0);
    let open = Tcp::bind("0.0.0.0:0", BaudRate::K500, Reach::Network).unwrap();
    Client::connect(SocketAddr::from(([127, 0, 0, 1], open.address().port())));
    let taken = Tcp::bind(&tcp.address().to_string(), BaudRate::K500, Reach::ThisMachine).unwrap_err();
    assert!(taken.to_string().contains(&tcp.address().to_string()), "{taken}");
    for wrong in ["", "5050", "localhost", "localhost:x"] {
        assert!(
            matches!(Tcp::bind(wrong, BaudRate::K500, Reach::ThisMachine), Err(Error::Tcp { .. })),
            "{wrong}"
        );
    }
}

#[test]
fn of_a_hundred_connections_32_are_clients_and_a_place_that_is_left_can_be_taken() {
    let mut tcp = bind();
    let address = tcp.address();
    let mut clients: Vec<_> = (0..MAX_CLIENTS).map(|_| Client::join(&mut tcp)).collect();
    let mut others: Vec<_> = (MAX_CLIENTS..100)
        .map(|_| {
            let client = Client::connect(address);
            settle(&mut tcp, |tcp| {
                tcp.receive(&mut [0; 8]).unwrap();
                true
            });
            client
        })
        .collect();
    hears_nothing_for(&mut tcp, Duration::from_millis(5));
    assert_eq!(tcp.clients(), MAX_CLIENTS);
    assert!(others.iter_mut().all(Client::is_dropped));
    clients[0].write(&ASK_5);
    assert_eq!(hear(&mut tcp, 6), ASK_5);
    clients[31].reads(&ASK_5);
    tcp.send(&[0xE5]).unwrap();
    drop(clients.pop());
    settle(&mut tcp, |tcp| tcp.clients() == MAX_CLIENTS - 1);
    Client::join(&mut tcp);
}

#[test]
fn the_last_client_to_leave_resets_the_line_and_an_abrupt_one_is_no_error() {
    let mut tcp = bind();
    for _ in 0..20 {
        let (mut a, mut b) = (Client::join(&mut tcp), Client::join(&mut tcp));
        // Octets that are never read make the closing a reset of the connection.
        a.write(&ASK_5);
        assert_eq!(hear(&mut tcp, 6), ASK_5);
        tcp.send(&[0xE5; 200]).unwrap();
        drop(a);
        b.reads(&ASK_5);
        let stop = Stop::new().unwrap();
        while tcp.clients() == 2 {
            tcp.wait(None, &stop).unwrap();
            assert_eq!(tcp.receive(&mut [0; 8]).unwrap(), Received::Nothing);
        }
        drop(b);
        let mut received = Received::Nothing;
        while received == Received::Nothing {
            tcp.wait(None, &stop).unwrap();
            received = tcp.receive(&mut [0; 8]).unwrap();
        }
        assert_eq!(received, Received::Reset);
        assert_eq!(tcp.receive(&mut [0; 8]).unwrap(), Received::Nothing, "said once");
    }
}

#[test]
fn a_client_that_asks_and_closes_its_half_gets_the_reply() {
    let mut tcp = bind();
    let mut client = Client::join(&mut tcp);
    client.write(&ASK_5);
    client.0.shutdown(Shutdown::Write).unwrap();
    assert_eq!(hear(&mut tcp, 6), ASK_5);
    tcp.send(&[0xE5]).unwrap();
    client.reads(&[0xE5]);
    settle(&mut tcp, |tcp| tcp.clients() == 0);
}

#[test]
fn a_client_that_does_not_read_is_dropped_when_too_much_waits_for_it() {
    let mut tcp = bind();
    let (mut stalled, mut reader) = (Client::join(&mut tcp), Client::join(&mut tcp));
    let mut sent = 0;
    while tcp.clients() == 2 {
        tcp.send(&[0x55; 250]).unwrap();
        reader.reads(&[0x55; 250]);
        sent += 250;
        tcp.receive(&mut [0; 8]).unwrap();
        assert!(sent < 16 * MAX_BACKLOG, "bounded memory");
    }
    assert!(sent > MAX_BACKLOG, "{sent}");
    tcp.send(&[1, 2]).unwrap();
    reader.reads(&[1, 2]);
    assert!(stalled.is_dropped());
}

#[test]
fn a_client_that_floods_is_dropped_and_nobody_else() {
    // On a clock that stands still no client is ever slow enough, whatever else the machine does.
    let mut tcp =
        Tcp::bind_with("127.0.0.1:0", BaudRate::K500, Reach::ThisMachine, ManualClock::new()).unwrap();
    let mut reader = Client::join(&mut tcp);
    let flooder = Client::join(&mut tcp);
    flooder.0.set_nonblocking(true).unwrap();
    let mut sent = 0;
    let mut heard = settle(&mut tcp, |tcp| {
        sent += (&flooder.0).write(&[0xFF; 65536]).unwrap_or(0);
        tcp.clients() == 1
    });
    // What it said before it was dropped is heard to its end.
    let mut buf = [0; 2048];
    while let Received::Octets(count) = tcp.receive(&mut buf).unwrap() {
        heard.extend_from_slice(&buf[..count]);
    }
    assert!(
        sent > MAX_BURST as usize && heard.len() < 4 * MAX_BURST as usize,
        "{sent} sent, {} heard",
        heard.len()
    );
    reader.write(&ASK_5);
    assert_eq!(hear(&mut tcp, 6), ASK_5);
    reader.0.set_nonblocking(true).unwrap();
    let mut read = Vec::new();
    settle(&mut tcp, |_| {
        let mut buf = [0; 65536];
        let count = reader.0.read(&mut buf).unwrap_or(0);
        read.extend_from_slice(&buf[..count]);
        read.len() >= heard.len()
    });
    assert_eq!(read, heard, "the reader, which was far behind, lost nothing");
}

#[test]
fn an_idle_line_sleeps_and_a_client_an_octet_and_a_stop_wake_it() {
    let mut tcp = bind();
    let stop = Stop::new().unwrap();
    let mut client = Client::join(&mut tcp);
    for wakes_wanted in [0, 1] {
        let start = Instant::now();
        let mut wakes = 0;
        while let Some(left) = Duration::from_millis(30).checked_sub(start.elapsed()) {
            tcp.wait(Some(left), &stop).unwrap();
            tcp.receive(&mut [0; 8]).unwrap();
            wakes += 1;
        }
        assert!(wakes < 10 + wakes_wanted, "woken {wakes} times in 30 ms");
        // Half a telegram is no reason to stay awake, nor is a stalled client.
        client.write(&[0x68]);
    }
    let address = tcp.address();
    thread::scope(|scope| {
        let other = scope.spawn(move || Client::connect(address));
        while tcp.clients() < 2 {
            tcp.wait(None, &stop).unwrap();
            tcp.receive(&mut [0; 8]).unwrap();
        }
        scope.spawn(|| client.write(&ASK_5));
        while tcp.receive(&mut [0; 8]).unwrap() == Received::Nothing {
            tcp.wait(None, &stop).unwrap();
        }
        drop(other.join().unwrap());
        scope.spawn(|| stop.request());
        while !stop.is_requested() {
            tcp.wait(None, &stop).unwrap();
            tcp.receive(&mut [0; 8]).unwrap();
        }
    });
}
