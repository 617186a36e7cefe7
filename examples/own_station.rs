//! An I/O station of one's own, from its GSD (`gsd/PDRV494F.GSD`) to a loop that a master runs: docs/build-your-own-slave.md goes
//! through it. Eight outputs, eight inputs wired to them, a word that counts milliseconds; output 8 is short-circuited.
//!
//! `cargo run --example own_station -- PATH` serves a pseudo-terminal at PATH. The firmwares of `examples/firmware` have the same
//! station on a microcontroller.

use profidrive::profibus::dp::ext_diag::{Block, Channel, ChannelError, Direction, ExtDiag, Width};
use profidrive::profibus::dp::{Description, Fixed, Framed, Rates, Station};
use profidrive::profibus::fdl::{Address, Resync};
use profidrive::time::{BaudRate, Instant};

/// Ident number, rates and services, as in the GSD.
const DESCRIPTION: Description = Description {
    ident: 0x494F,
    rates: Rates::CUSTOMARY
        .without(BaudRate::K45_45)
        .without(BaudRate::K3000)
        .without(BaudRate::K6000)
        .without(BaudRate::K12000),
    sync_mode: true,
    freeze_mode: true,
    user_prm_len: 1,
    max_diag_len: 9,
    ..Description::PLAIN
};

/// One octet out, one octet in, one word in; a user parameter of 0 or 1.
const APPLICATION: Fixed<'static> =
    Fixed { configurations: &[&[0x20, 0x10, 0x50]], user_prm: &[0..=1], ..Fixed::PLAIN };

/// Output 8 has a short circuit.
const SHORT_CIRCUIT: Block = Block::Channel(Channel {
    module: 0,
    direction: Direction::Output,
    channel: 7,
    width: Width::Bit,
    error: ChannelError::SHORT_CIRCUIT,
});

/// The station at address 7, just switched on. Of a line whose timing it sees, it drops replies that are too late.
pub(crate) fn slave(baud: BaudRate, resync: Resync) -> Framed {
    let max_tsdr = match resync {
        Resync::Idle(_) => Some(baud.max_tsdr_bits()),
        Resync::Scan(_) => None,
    };
    Framed::new(resync, Station::new(Address::from_octet(7), baud, max_tsdr, DESCRIPTION, APPLICATION))
}

/// The application: inputs from outputs, and what is wrong.
pub(crate) fn application(now: Instant, slave: &mut Framed) {
    let station = slave.station_mut();
    let outputs = station.slave().outputs().first().copied().unwrap_or(0);
    let wires = if station.slave().user_prm() == [1] { !outputs } else { outputs };
    let [.., high, low] = (now.as_nanos() / 1_000_000).to_be_bytes();
    station.set_inputs(&[wires, high, low]);

    let mut diagnosis = ExtDiag::NONE;
    if outputs & 0x80 != 0 {
        diagnosis = ExtDiag::fault();
        // Module and channel are below 64.
        let _fits = diagnosis.push(SHORT_CIRCUIT);
    }
    station.file_diagnosis(&diagnosis);
}

#[cfg(not(target_os = "none"))]
#[allow(dead_code, reason = "a test includes this file")]
fn main() -> Result<(), Box<dyn core::error::Error>> {
    use profidrive::host::link::pty::Pty;
    use profidrive::host::{Clock, Link, Received, Stop, SystemClock};
    use profidrive::profibus::fdl::MAX_TELEGRAM_LEN;

    let path = std::env::args().nth(1).ok_or("usage: own_station PATH")?;
    let (mut line, clock, stop) = (Pty::open(Some(path.as_ref()))?, SystemClock::new(), Stop::new()?);
    // Of a pseudo-terminal no timing is seen.
    let mut slave = slave(BaudRate::K500, Resync::SCAN);
    println!("ready link={path} stations=7");
    let (mut octets, mut reply) = ([0; 256], [0; MAX_TELEGRAM_LEN]);
    while !stop.is_requested() {
        loop {
            match line.receive(&mut octets)? {
                Received::Octets(len) | Received::BrokenOff(len) => {
                    slave.handle_bytes(clock.now(), octets.get(..len).unwrap_or_default());
                }
                // Another master, another rate: nothing to this station.
                Received::Reset | Received::Rate(_) => {}
                Received::Nothing => break,
            }
        }
        slave.handle_timeout(clock.now());
        if let Some(reply) = slave.poll_transmit(clock.now(), &mut reply) {
            line.send(reply)?;
        }
        application(clock.now(), &mut slave);
        while let Some(news) = slave.poll_news() {
            eprintln!("{news}");
        }
        let timeout = slave.poll_timeout().map(|due| due.saturating_since(clock.now()));
        line.wait(timeout, &stop)?;
    }
    Ok(())
}
