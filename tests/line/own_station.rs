//! The station of `examples/own_station.rs`, its GSD, and `docs/build-your-own-slave.md`, which explains both.

#[path = "../../examples/own_station.rs"]
mod station;

use std::fs;
use std::path::Path;

use profidrive::devices::StationEvent;
use profidrive::devices::ag03::profibus::{Config, Device, Timing};
use profidrive::gsd::Gsd;
use profidrive::profibus::dp::{Framed, State};
use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameCount, FrameError, FunctionCode, MAX_TELEGRAM_LEN, Resync, Sap, Service,
};
use profidrive::time::{BaudRate, Instant};
use station::{application, slave};

const BAUD: BaudRate = BaudRate::K1500;

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// Asks, octet by octet, and returns the reply; the application has its turn behind it.
fn ask(slave: &mut Framed, now: &mut Instant, sap: Option<u8>, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
    let request = DataTelegram {
        format: DataTelegram::customary_format(dsap, ssap, data),
        da: Address::from_octet(7),
        sa: Address::from_octet(2),
        dsap,
        ssap,
        fc: FunctionCode::request(Service::SrdHigh, FrameCount::First),
        data,
    };
    *now = now.saturating_add(BAUD.bit_times(100));
    let mut buf = [0; MAX_TELEGRAM_LEN];
    for octet in request.encode(&mut buf).unwrap() {
        *now = now.saturating_add(BAUD.octet_times(1));
        slave.handle_bytes(*now, &[*octet]);
    }
    *now = now.saturating_add(BAUD.bit_times(11));
    let mut buf = [0; MAX_TELEGRAM_LEN];
    let reply = slave.poll_transmit(*now, &mut buf).expect("a reply at min T_SDR").to_vec();
    application(*now, slave);
    reply
}

#[test]
fn the_station_does_what_its_gsd_says() {
    let mut own = slave(BAUD, Resync::Idle(BAUD));
    let mut now = Instant::from_millis(1);
    assert_eq!(ask(&mut own, &mut now, Some(61), &[0x80, 1, 1, 11, 0x49, 0x4F, 0, 1]), [0xE5]);
    assert_eq!(ask(&mut own, &mut now, Some(62), &[0x20, 0x10, 0x50]), [0xE5]);
    assert_eq!(own.station().slave().state(), State::DataExch);
    ask(&mut own, &mut now, None, &[0x8F]);
    let reply = ask(&mut own, &mut now, None, &[0x8F]);
    // DH: a diagnosis waits. The user parameter inverts the inputs.
    assert_eq!(reply.get(4..8), Some(&[2, 7, 0x0A, 0x70][..]));
    let diagnosis = ask(&mut own, &mut now, Some(60), &[]);
    assert_eq!(diagnosis.get(15..18), Some(&[0x80, 0x87, 0x21][..]), "{diagnosis:02X?}");

    let gsd = Gsd::read(read("gsd/PDRV494F.GSD").as_bytes()).unwrap();
    assert!(gsd.hints.is_empty(), "gsd check: {:?}", gsd.hints);
    let said = profidrive::gsd::Station::new(gsd, profidrive::gsd::Policy::PROPOSED).unwrap().description();
    let has = own.station().slave().description();
    assert_eq!(
        (said.ident, said.rates, said.sync_mode, said.freeze_mode, said.user_prm_len, said.max_diag_len),
        (has.ident, has.rates, has.sync_mode, has.freeze_mode, has.user_prm_len, has.max_diag_len),
    );
}

/// The firmware of the drive drains it only when something has come of an octet.
#[test]
fn a_drive_says_which_octets_bring_news_and_answers_no_damaged_request() {
    const STATUS: [u8; 6] = [0x10, 5, 2, 0x49, 0x50, 0x16];
    let at = |octet: u64| {
        Instant::from_millis(1).saturating_add(BAUD.octet_times(1) * u32::try_from(octet).unwrap())
    };
    for damaged in (0..STATUS.len()).map(Some).chain([None]) {
        let address = Address::station(5).unwrap();
        let config = Config { baud: BAUD, timing: Timing::True, ..Config::new(address) };
        let mut drive = Device::new(config, Instant::ZERO);
        drive.handle_timeout(at(0));
        let mut news = Vec::new();
        for (number, octet) in STATUS.iter().enumerate() {
            let now = at(1 + number as u64);
            let heard = if damaged == Some(number) {
                drive.handle_damaged(now)
            } else {
                drive.handle_bytes(now, &[*octet])
            };
            news.extend(heard.then_some(number));
        }
        assert_eq!(news, [damaged.unwrap_or(STATUS.len() - 1)]);
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let reply = drive.poll_transmit(at(6).saturating_add(BAUD.bit_times(11)), &mut buf);
        assert_eq!(reply.is_some(), damaged.is_none(), "{damaged:?}");
        let refused = std::iter::from_fn(|| drive.poll_event())
            .filter(|event| matches!(event, StationEvent::TelegramRefused(FrameError::Parity)));
        assert_eq!(refused.count(), usize::from(damaged.is_some()));
    }
}

/// Whitespace does not count: the page indents less.
fn words(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}

#[test]
fn the_page_shows_the_sources_as_they_are() {
    let sources = [
        "examples/own_station.rs",
        "gsd/PDRV494F.GSD",
        "examples/firmware/boards/rp2040/src/main.rs",
        "examples/firmware/boards/stm32f4/src/main.rs",
        "examples/firmware/src/board/mod.rs",
    ]
    .map(read);
    for page in ["docs/build-your-own-slave.md", "docs/firmware.md"] {
        let page = read(page);
        for kind in ["```rust\n", "```ini\n"] {
            for excerpt in page.split(kind).skip(1).map(|rest| rest.split("```").next().unwrap()) {
                let found = sources.iter().any(|source| {
                    let (source, excerpt) = (words(source), words(excerpt));
                    source.windows(excerpt.len()).any(|window| window == excerpt)
                });
                assert!(found, "not in the source as it stands there:\n{excerpt}");
            }
        }
    }
}

/// Every number of docs/firmware.md that is recorded is the recorded one.
#[test]
fn the_page_has_the_numbers_that_are_recorded() {
    let page = read("docs/firmware.md");
    for line in read("examples/firmware/numbers.txt").lines() {
        let (name, number) = line.split_once(' ').unwrap();
        let row = page.lines().find(|row| row.contains(&format!("`{name}`")));
        let row = row.unwrap_or_else(|| panic!("docs/firmware.md has no row for {name}"));
        assert!(row.replace(' ', "").contains(&format!("|{number}|")), "{name} is {number}: {row}");
    }
}
