//! The I/O station of `gsd/PDRV494F.GSD`: eight outputs, eight inputs wired to them, and a word that counts milliseconds. A
//! user parameter inverts the inputs; output 8 is short-circuited, and the diagnosis says so.

use profidrive::dp::ext_diag::{Block, Channel, ChannelError, Direction, ExtDiag, Width};
use profidrive::dp::{Description, Fixed, Framed, Rates, Station};
use profidrive::fdl::Address;
use profidrive::time::{BaudRate, Instant};

use crate::board::TIMING;

const ADDRESS: Address = Address::from_octet(7);
const BAUD: BaudRate = BaudRate::K1500;

/// What the GSD says.
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
/// One octet out, one octet in, one word in.
const APPLICATION: Fixed<'static> =
    Fixed { configurations: &[&[0x20, 0x10, 0x50]], user_prm: &[0..=1], ..Fixed::PLAIN };
const SHORT_CIRCUIT: Block = Block::Channel(Channel {
    module: 0,
    direction: Direction::Output,
    channel: 7,
    width: Width::Bit,
    error: ChannelError::SHORT_CIRCUIT,
});

/// The station, just switched on.
pub fn slave() -> Framed {
    let station = Station::new(ADDRESS, BAUD, None, DESCRIPTION, APPLICATION);
    Framed::new(TIMING.resync(BAUD), station)
}

/// Inputs from outputs, and what is wrong.
pub fn application(now: Instant, slave: &mut Framed) {
    // A log would take them.
    while slave.poll_news().is_some() {}
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
