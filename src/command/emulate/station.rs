//! Stations from device files: read before anything starts, and what they tell in the log.

use profidrive::device::{Event, MAX_TELEGRAM_LEN};
use profidrive::dp;
use profidrive::fdl::{Address, Rates, Telegram};
use profidrive::gsd::{Level, Station};
use profidrive::host::{Bus, Participant};
use profidrive::time::{BaudRate, Instant};
use tracing::{info, warn};

use crate::command::Failure;
use crate::command::args::StationSpec;
use crate::command::gsd::read;

/// The stations asked for. Nothing is started before all of their files are right.
pub(super) fn load(stations: &[StationSpec]) -> Result<Vec<(Address, Station)>, Failure> {
    let one = |spec: &StationSpec| {
        let gsd = read(&spec.file)?;
        let file = spec.file.display();
        for hint in gsd.hints.iter().filter(|hint| hint.level == Level::Warning) {
            warn!("{file}: {hint}");
        }
        let station =
            Station::new(gsd, spec.policy).map_err(|error| Failure::Usage(format!("{file}: {error}")))?;
        Ok((spec.address, station))
    };
    stations.iter().map(one).collect()
}

/// Puts a station on the bus.
pub(super) fn connect(
    bus: &mut Bus,
    (address, station): (Address, Station),
    rate: BaudRate,
    now: Instant,
    listen: bool,
) -> Result<(), Failure> {
    let gsd = station.gsd();
    info!("{} {}, ident 0x{:04X}, from its GSD at address {address}", gsd.vendor, gsd.model, gsd.ident);
    if !gsd.rates.contains(rate) {
        warn!("station {address} hears nothing at {rate}: its GSD does not offer it");
    }
    if gsd.flags.needs_dpv1_services {
        warn!("station {address}: its GSD requires services of DPV1, which are not emulated");
    }
    let description = station.description();
    let station = Described(dp::Station::new(address, rate, None, description, station));
    let connected = if listen { bus.join(now, station) } else { bus.add(station) };
    connected.map_err(|error| Failure::from_error(&error))
}

/// `drives=5 stations=7,9` of the ready line; either part is absent if there are none.
pub(super) fn ready(addresses: &[Address], stations: &[Address]) -> String {
    let (stations, drives): (Vec<_>, Vec<_>) =
        addresses.iter().partition(|address| stations.contains(address));
    let named = |name: &str, addresses: Vec<&Address>| {
        let addresses: Vec<_> = addresses.into_iter().map(Address::to_string).collect();
        (!addresses.is_empty()).then(|| format!("{name}={}", addresses.join(",")))
    };
    let parts: Vec<_> =
        [named("drives", drives), named("stations", stations)].into_iter().flatten().collect();
    parts.join(" ")
}

/// A station that says in the log why it refuses and what is odd in what it accepts: its words are its own.
struct Described(dp::Station<Station>);

impl Described {
    fn tell(&self, event: &dp::Event) {
        let (address, slave) = (self.0.address(), self.0.slave());
        match event {
            dp::Event::PrmRejected { .. } | dp::Event::CfgRejected { .. } => {
                warn!("station {address}: {}", self.0.explain(event));
            }
            dp::Event::DataExchange { .. } => {
                let station = slave.application();
                let Ok(modules) = station.modules(slave.configuration()) else { return };
                for remark in station.remarks(slave.user_prm(), &modules) {
                    warn!("station {address}: {remark}");
                }
            }
            dp::Event::Parameterised { .. }
            | dp::Event::PrmForeign { .. }
            | dp::Event::Released { .. }
            | dp::Event::CfgToJudge { .. }
            | dp::Event::WrongOutputLength { .. }
            | dp::Event::WatchdogExpired { .. }
            | dp::Event::Controlled { .. }
            | dp::Event::SafeState { .. }
            | dp::Event::ApplicationSilent { .. }
            | dp::Event::ApplicationAborted { .. }
            | dp::Event::Read { .. }
            | dp::Event::AddressSet { .. }
            | dp::Event::AddressRefused { .. } => {}
            // No other can ask for parameters or a configuration.
            _ => {}
        }
    }
}

impl Participant for Described {
    fn address(&self) -> Address {
        self.0.address()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.0.set_baud(baud);
    }

    fn rates(&self) -> Rates {
        self.0.slave().description().rates
    }

    fn receive(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(Event)) {
        if let Some(event) = self.0.receive(now, telegram).event {
            self.tell(&event);
            news(Event::Dp(event));
        }
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(Event)) {
        Participant::handle_timeout(&mut self.0, now, news);
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(Event),
    ) -> Option<usize> {
        Participant::poll_transmit(&mut self.0, now, buf, news)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        self.0.poll_timeout()
    }

    fn watchdog_on(&self) -> bool {
        self.0.slave().watchdog_on()
    }
}
