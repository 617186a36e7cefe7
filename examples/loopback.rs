//! A drive and a master of a few lines, without hardware: `cargo run --example loopback` prints a start-up.
//!
//! The drive is [`Device`]: octets and time in, octets out. The master says what masters say to bring a slave into
//! Data_Exchange; its telegrams are built and read with [`profidrive::profibus::fdl`].

use core::error::Error;

use profidrive::devices::ag03::profibus::{Config, Device, MAX_TELEGRAM_LEN};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, DataTelegram, FrameCount, FunctionCode, Sap, Service, Telegram};
use profidrive::profibus::ppo::Inputs;
use profidrive::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let drive = Address::station(5)?;
    let mut now = Instant::ZERO;
    let mut device = Device::new(Config::new(drive), now);

    let outputs = [0; 14];
    // The service access point, the data, and what they mean. Data_Exchange has no service access point.
    let script: [(Option<u8>, &[u8], &str); 5] = [
        (Some(60), &[], "Slave_Diag request"),
        (Some(61), &[0x80, 1, 1, 11, 0x0A, 0xC5, 0], "Set_Prm: lock, no watchdog, ident number 0AC5"),
        (Some(62), &[0xF3, 0xF2], "Chk_Cfg: four and three words"),
        (Some(60), &[], "Slave_Diag: ready?"),
        (None, &outputs, "Data_Exchange"),
    ];
    // The frame count bit tells a new request from a repeated one.
    let counts = [FrameCount::First, FrameCount::Even, FrameCount::Odd].into_iter();
    let counts = counts.chain([FrameCount::Even, FrameCount::Odd]);
    for ((sap, data, meaning), count) in script.into_iter().zip(counts) {
        let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
        let request = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, data),
            da: drive,
            sa: Address::station(2)?,
            dsap,
            ssap,
            fc: FunctionCode::request(Service::SrdHigh, count),
            data,
        };
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let octets = request.encode(&mut buf)?;
        println!("{now}  master  {octets:02X?}  {meaning}");
        device.handle_bytes(now, octets);

        // The reply comes when the drive says, not before. This clock is ours, so waiting is setting it.
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let reply = loop {
            if let Some(reply) = device.poll_transmit(now, &mut buf) {
                break reply.to_vec();
            }
            now = device.poll_timeout().ok_or("the drive does not answer")?;
            device.handle_timeout(now);
        };
        println!("{now}  drive   {reply:02X?}");
        if let (None, Decoded::Telegram { telegram: Telegram::Data(data), .. }) = (sap, decode(&reply)) {
            println!("in Data_Exchange: status word {}", Inputs::parse(data.data)?.zsw());
        }
        while let Some(event) = device.poll_event() {
            println!("{now}  drive   {event}");
        }
    }
    Ok(())
}
