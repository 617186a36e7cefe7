//! A slave that finds the rate of the line is judged at each; one that is deaf at a rate fails the row of that rate.

use profidrive::bench::Port;
use profidrive::devices::StationEvent;
use profidrive::gsd::{self, Gsd};
use profidrive::host::{GsdStation, Participant, Refusals};
use profidrive::judge::Requirement as _;
use profidrive::judge::device::slave::{Report, Row, Setup, simulated};
use profidrive::profibus::fdl::{Address, MAX_TELEGRAM_LEN, Rates, Telegram};
use profidrive::time::{BaudRate, Instant};

use super::broken;

/// The rate of the line when the judgement begins.
const HOME: BaudRate = BaudRate::K1500;

/// Says nothing at one rate.
struct MuteAt {
    station: GsdStation,
    rate: Option<BaudRate>,
    is_mute: bool,
}

impl Participant for MuteAt {
    fn address(&self) -> Address {
        self.station.address()
    }

    fn rates(&self) -> Rates {
        self.station.rates()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.is_mute = self.rate == Some(baud);
        self.station.set_baud(baud);
    }

    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        if !self.is_mute {
            self.station.handle_telegram(now, telegram, news);
        }
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        self.station.handle_timeout(now, news);
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        self.station.poll_transmit(now, buf, news)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        self.station.poll_timeout()
    }

    fn watchdog_on(&self) -> bool {
        self.station.watchdog_on()
    }
}

fn judged(mute: Option<BaudRate>) -> Report {
    let mut text =
        String::from("#Profibus_DP\nIdent_Number=0x1234\nAuto_Baud_supp=1\nMin_Slave_Intervall=1\n");
    for rate in ["9.6", "19.2", "31.25", "45.45", "93.75", "187.5", "500", "1.5M", "3M", "6M", "12M"] {
        text.push_str(&format!("{rate}_supp=1\n"));
    }
    text.push_str("Module=\"word\" 0x70\nEndModule\n");
    let gsd = Gsd::read(text.as_bytes()).unwrap();
    let station = gsd::Station::new(gsd.clone(), gsd::Policy::PROPOSED).unwrap();
    let address = Address::station(5).unwrap();
    let station = GsdStation::new(address, HOME, station, Refusals::default());
    let port = Port::new(HOME);
    port.line(|line| {
        line.add(MuteAt { station, rate: mute, is_mute: false }).unwrap();
        let now = line.now();
        line.bus_mut(0).unwrap().search_baud(now);
    });
    let setup = Setup { gsd: Some(Box::new(gsd)), rates: BaudRate::ALL.to_vec(), ..Setup::new(address) };
    let rows: Vec<Row> = ["S-P01", "S-G01", "S-X01", "S-R*"].into_iter().flat_map(Row::matching).collect();
    simulated(&port, setup, &rows, None).unwrap()
}

fn rows() -> Vec<&'static str> {
    Row::matching("S-R*").iter().map(|row| row.id()).collect()
}

#[test]
fn a_slave_that_finds_every_rate_is_right() {
    let report = judged(None);
    assert!(broken(&report).is_empty(), "{report}");
    assert_eq!(report.outcome().status(), 0, "{report}");
    assert!(report.judgements.iter().all(|judged| judged.applies), "{report}");
}

#[test]
fn a_slave_that_says_nothing_at_a_rate_fails_its_row() {
    assert_eq!(rows().len(), BaudRate::ALL.len());
    for (rate, row) in BaudRate::ALL.into_iter().zip(rows()).filter(|(rate, _)| *rate != HOME) {
        let report = judged(Some(rate));
        assert_eq!(broken(&report), [row], "{rate}: {report}");
    }
}
