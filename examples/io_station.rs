//! A plain digital I/O station: eight outputs, eight inputs wired to them, and a diagnosis when output 7 is on.
//!
//! `cargo run --example io_station` prints a start-up and a diagnosis, seen from a scripted master.

use std::io::{self, Write};

use profidrive::profibus::dp::ext_diag::{Block, Channel, ChannelError, Direction, ExtDiag, Width};
use profidrive::profibus::dp::{Description, Fixed, Station};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, DataTelegram, FrameCount, FunctionCode, Sap, Service};
use profidrive::time::{BaudRate, Instant};

/// One octet out, one octet in, and a user parameter: 0 = inputs as wired, 1 = inverted.
const IO_STATION: Description =
    Description { ident: 0x1234, user_prm_len: 1, max_diag_len: 32, ..Description::PLAIN };
const ACCEPTED: Fixed<'static> =
    Fixed { configurations: &[&[0x20, 0x10]], user_prm: &[0..=1], ..Fixed::PLAIN };

/// The application: inputs from outputs, and a short circuit while output 7 is on.
fn application(station: &mut Station) {
    let outputs = station.slave().outputs().first().copied().unwrap_or(0);
    let inverted = station.slave().user_prm() == [1];
    station.set_inputs(&[if inverted { !outputs } else { outputs }]);

    let mut diagnosis = ExtDiag::NONE;
    if outputs & 0x80 != 0 {
        diagnosis = ExtDiag::fault();
        let error = ChannelError::SHORT_CIRCUIT;
        let output_7 =
            Channel { module: 0, direction: Direction::Output, channel: 7, width: Width::Bit, error };
        diagnosis.push(Block::Channel(output_7)).expect("module and channel are below 64");
    }
    station.file_diagnosis(&diagnosis);
}

/// Asks the station and prints both telegrams.
fn ask(
    station: &mut Station,
    now: &mut Instant,
    out: &mut dyn Write,
    what: &str,
    sap: Option<u8>,
    data: &[u8],
) -> io::Result<()> {
    let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
    let request = DataTelegram {
        format: DataTelegram::customary_format(dsap, ssap, data),
        da: station.address(),
        sa: Address::from_octet(2),
        dsap,
        ssap,
        // A first cycle is never a retry, so a script need not count.
        fc: FunctionCode::request(Service::SrdHigh, FrameCount::First),
        data,
    };
    let mut buf = [0; 255];
    let octets = request.encode(&mut buf).map_err(io::Error::other)?;
    let Decoded::Telegram { telegram, .. } = decode(octets) else { return Ok(()) };
    let event = station.handle_telegram(*now, &telegram).event;
    *now = station.poll_timeout().unwrap_or(*now);
    let reply = station.poll_transmit(*now).unwrap_or_default().unwrap_or_default();
    writeln!(out, "{what:<14} {octets:02X?}\n{:14} {reply:02X?}", "")?;
    application(station);
    event.map_or(Ok(()), |event| writeln!(out, "{:14} {event}", ""))
}

/// A start-up, exchanges, and a diagnosis that comes and goes.
pub(crate) fn run(out: &mut dyn Write) -> io::Result<()> {
    let mut station = Station::new(Address::from_octet(5), BaudRate::K1500, None, IO_STATION, ACCEPTED);
    let mut now = Instant::ZERO;
    let script: [(&str, Option<u8>, &[u8]); 10] = [
        ("Slave_Diag", Some(60), &[]),
        ("Set_Prm, bad", Some(61), &[0x80, 1, 1, 11, 0x12, 0x34, 0, 7]),
        ("Set_Prm", Some(61), &[0x80, 1, 1, 11, 0x12, 0x34, 0, 1]),
        ("Chk_Cfg", Some(62), &[0x20, 0x10]),
        ("Data_Exchange", None, &[0x0F]),
        ("Data_Exchange", None, &[0x8F]),
        ("Data_Exchange", None, &[0x8F]),
        ("Slave_Diag", Some(60), &[]),
        ("Data_Exchange", None, &[0x00]),
        ("Data_Exchange", None, &[0x00]),
    ];
    script.into_iter().try_for_each(|(what, sap, data)| ask(&mut station, &mut now, out, what, sap, data))
}

#[allow(dead_code, reason = "a test includes this file and calls `run`")]
fn main() -> io::Result<()> {
    run(&mut io::stdout())
}
