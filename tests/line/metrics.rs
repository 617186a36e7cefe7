//! What Prometheus reads of lines: the form of the text, the pages that say what it means, and counters that only grow.

use core::fmt::Write as _;
use std::collections::BTreeSet;
use std::io::{Read, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::thread;

use profidrive::can_bus::can::{BitRate, Frame};
use profidrive::can_bus::canopen::NodeId;
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::devices::CanopenEvent;
use profidrive::devices::ag03::param::Model;
use profidrive::devices::ag03::profibus::{Config, Device, DipSwitches, MAX_TELEGRAM_LEN};
use profidrive::devices::ppo_drive::profibus::{CONFIGURATIONS, PpoDrive, PpoOnly};
use profidrive::devices::ppo_drive::table::Table;
use profidrive::devices::profidrive4::profibus::{Family, ProfidriveDevice, TelegramOnly};
use profidrive::gsd::{Gsd, Policy, Station};
use profidrive::host::can::{self, Product, Seat, StoredNode};
use profidrive::host::list::Choices;
use profidrive::host::{Bus, GsdStation, HostedPpoDrive, HostedProfidrive, PpoJudge, Reach, Refusals, Stop};
use profidrive::metrics::{LineMetrics, Metrics, MetricsError, NodeMetrics, PATH};
use profidrive::panel::Seated;
use profidrive::profibus::dp;
use profidrive::profibus::dp::{Description, Fixed};
use profidrive::profibus::dpv1::{Identification, Offer};
use profidrive::profibus::fdl::Address;
use profidrive::time::{BaudRate, Instant};
use serde_json::Value;

mod counters;
mod text;

use text::{families, series};

/// What a link may be called at worst.
const LINK: &str = "pty:/tmp/a \"bus\"\\of\nmine";

/// A line of PROFIBUS and a bus of CAN with their metrics, in virtual time.
struct Rig {
    metrics: Metrics,
    of_line: LineMetrics,
    of_nodes: NodeMetrics,
    bus: Bus,
    can: can::Bus<CanopenEvent>,
    nodes: Vec<Seated>,
    /// Where the master of the nodes is.
    port: Seat,
    now: Instant,
}

impl Rig {
    fn new() -> Self {
        let metrics = Metrics::start("127.0.0.1:0", Reach::ThisMachine).unwrap();
        // Not in the order of their numbers.
        let of_nodes = metrics.can_line(2, "slcan-tcp:127.0.0.1:5000", Stop::new().unwrap());
        let of_line = metrics.line(1, LINK, Stop::new().unwrap());
        let mut can = can::Bus::new(BitRate::K500);
        let port = can.connect(Instant::ZERO);
        let (bus, nodes, now) = (Bus::new(), Vec::new(), Instant::ZERO);
        Self { metrics, of_line, of_nodes, bus, can, nodes, port, now }
    }

    /// With one of each kind.
    fn full() -> Self {
        let mut rig = Self::new();
        rig.add_drive(5);
        let drive = Config { model: Model::Ag03, ..Config::new(switches(6)) };
        rig.bus.add(Device::new(drive, rig.now)).unwrap();
        let gsd = Gsd::read(&std::fs::read(root().join("tests/gsd/remote_io.gsd")).unwrap()).unwrap();
        let station = Station::new(gsd, Policy::PROPOSED).unwrap();
        let refusals = Refusals::default();
        rig.bus.add(GsdStation::new(address(9), BaudRate::K500, station, refusals.clone())).unwrap();
        let judge = PpoJudge::Profile(Fixed { configurations: CONFIGURATIONS, ..Fixed::PLAIN });
        let parts = (Description::PLAIN, PpoOnly { inner: judge, only: None });
        let table = Table::new([]).unwrap();
        let drive = PpoDrive::new(address(7), BaudRate::K500, parts, table, rig.now).unwrap();
        rig.bus.add(HostedPpoDrive::new(drive, refusals)).unwrap();
        let gsd = Gsd::read(&std::fs::read(root().join("gsd/PDRV5034.GSD")).unwrap()).unwrap();
        let station = Station::new(gsd, Policy::PROPOSED).unwrap();
        let parts = (station.description(), TelegramOnly { inner: station, only: None });
        let acyclic = (Offer::NONE, Identification::PLAIN);
        let family = Family::new(&[]).unwrap();
        let drive = ProfidriveDevice::new(address(13), BaudRate::K500, parts, acyclic, family, rig.now);
        rig.bus.add(HostedProfidrive::new(drive, Refusals::default())).unwrap();
        let plain = dp::Station::new(address(11), BaudRate::K500, None, Description::PLAIN, Fixed::PLAIN);
        rig.bus.add(plain).unwrap();
        for (node, product) in [(5, "ag03-1"), (6, "ap10"), (7, "asda-a2"), (6, "ap10")] {
            rig.add_node(node, product);
        }
        rig
    }

    fn add_drive(&mut self, number: u8) {
        self.bus.add(Device::new(Config::new(switches(number)), self.now)).unwrap();
    }

    fn add_node(&mut self, number: u8, product: &str) -> Seat {
        let product = Product::named(product).unwrap();
        let node = NodeId::new(number).unwrap();
        let device = product.make(node, &Choices::default(), Eeprom::Internal, self.now);
        let seat = self.can.add(self.now, Box::new(StoredNode::new(device, self.now)));
        self.nodes.push(Seated { seat, product });
        seat
    }

    /// What Prometheus gets, while the threads of the lines come by.
    fn scrape(&mut self) -> String {
        let place = self.metrics.address();
        let client = thread::spawn(move || get(place, PATH));
        while !client.is_finished() {
            self.of_line.serve(&self.bus);
            self.of_nodes.serve(&self.can, &self.nodes);
            thread::yield_now();
        }
        let (head, text) = client.join().unwrap();
        assert!(head.starts_with("HTTP/1.1 200"), "{head}\n{text}");
        let media_type = "content-type: application/openmetrics-text; version=1.0.0; charset=utf-8\r\n";
        assert!(head.contains(media_type), "{head}");
        text
    }

    /// Time goes on by so many milliseconds.
    fn pass(&mut self, milliseconds: u64) {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        for _ in 0..milliseconds {
            self.now = self.now.saturating_add(core::time::Duration::from_millis(1));
            self.bus.handle_timeout(self.now);
            while self.bus.poll_transmit(self.now, &mut buf).is_some() {}
            while self.bus.poll_event().is_some() {}
            self.can.handle_timeout(self.now);
            while self.can.poll_event().is_some() {}
            while self.can.poll_heard(self.port).is_some() {}
        }
    }

    /// A request of master 2 to a station, and its reply as soon as it may be sent.
    fn request(&mut self, octets: &[u8]) {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        self.bus.handle_bytes(self.now, octets);
        let end = self.now.saturating_add(core::time::Duration::from_micros(100));
        while let Some(due) = self.bus.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            while self.bus.poll_transmit(self.now, &mut buf).is_some() {}
            self.bus.handle_timeout(self.now);
            while self.bus.poll_transmit(self.now, &mut buf).is_some() {}
        }
        self.pass(1);
    }

    fn send(&mut self, frame: Frame) {
        // Refused where the port is bus off.
        let _ = self.can.send(self.now, self.port, frame);
        self.pass(2);
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn address(number: u8) -> Address {
    Address::station(number).unwrap()
}

fn switches(number: u8) -> DipSwitches {
    address(number).into()
}

/// FDL status of master 2 to a station.
fn status_request(da: u8) -> [u8; 6] {
    [0x10, da, 0x02, 0x49, da.wrapping_add(0x4B), 0x16]
}

/// Head and body of an answer.
fn get(place: SocketAddr, path: &str) -> (String, String) {
    let mut stream = TcpStream::connect(place).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {place}\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (format!("{head}\r\n").to_lowercase().replacen("http", "HTTP", 1), body.to_owned())
}

#[test]
fn every_participant_has_its_series_and_every_label_is_escaped() {
    let mut rig = Rig::full();
    rig.request(&status_request(5));
    let text = rig.scrape();
    families(&text);
    let series = series(&text);
    let at = |name: &str| *series.get(name).unwrap_or_else(|| panic!("no {name} in\n{text}"));
    let escaped = r#"profidrive_line_info{line="1",bus="profibus",link="pty:/tmp/a \"bus\"\\of\nmine"}"#;
    assert_eq!(at(escaped), 1.0);
    for (place, kind, model) in [
        (r#"line="1",address="5""#, "drive", "ag03-1"),
        (r#"line="1",address="6""#, "drive", "ag03"),
        (r#"line="1",address="7""#, "ppo_drive", "profile"),
        (r#"line="1",address="9""#, "gsd_station", "Remote I/O"),
        (r#"line="1",address="11""#, "other", ""),
        (r#"line="1",address="13""#, "profidrive", "PROFIdrive 4"),
        (r#"line="2",address="5""#, "node", "ag03-1"),
        (r#"line="2",address="6""#, "node", "ap10"),
        (r#"line="2",address="6",twin="1""#, "node", "ap10"),
        (r#"line="2",address="7""#, "node", "asda-a2"),
    ] {
        assert_eq!(at(&format!("profidrive_station_info{{{place},kind=\"{kind}\",model=\"{model}\"}}")), 1.0);
        assert_eq!(at(&format!("profidrive_faults_total{{{place}}}")), 0.0);
        let sum = |name: &str| {
            let begin = format!("{name}{{{place},state=");
            let states = series.iter().filter(|(name, _)| name.starts_with(&begin));
            states.map(|(_, value)| value).sum::<f64>()
        };
        let is_node = kind == "node";
        assert_eq!(sum("profidrive_slave_state"), f64::from(u8::from(!is_node)), "{place}");
        assert_eq!(sum("profidrive_node_state"), f64::from(u8::from(is_node)), "{place}");
        assert_eq!(sum("profidrive_can_error_state"), f64::from(u8::from(is_node)), "{place}");
        let is_drive = !matches!(model, "ap10" | "Remote I/O" | "");
        assert_eq!(sum("profidrive_drive_state"), f64::from(u8::from(is_drive)), "{place}");
    }
    assert_eq!(at(r#"profidrive_requests_total{line="1",address="5",kind="fdl_status"}"#), 1.0);
    assert_eq!(at(r#"profidrive_reply_time_seconds_count{line="1"}"#), 1.0);
    assert_eq!(at(r#"profidrive_reply_time_seconds_bucket{le="+Inf",line="1"}"#), 1.0);
    // Min T_SDR, 11 bit times at 500 kbit/s.
    assert_eq!(at(r#"profidrive_reply_time_seconds_sum{line="1"}"#), 0.000_022);
    assert_eq!(at(r#"profidrive_station_reply_time_seconds_total{line="1",address="5"}"#), 0.000_022);
    assert_eq!(at(r#"profidrive_reply_time_seconds_bucket{le="0.00002",line="1"}"#), 0.0);
    assert_eq!(at(r#"profidrive_reply_time_seconds_bucket{le="0.00005",line="1"}"#), 1.0);
    // A full line must not be too much for Prometheus.
    let per_station = series.keys().filter(|name| name.contains(r#"line="1",address="5""#)).count();
    assert!(per_station <= 40, "{per_station} series of a drive");
}

#[test]
fn a_line_that_is_gone_has_no_metrics_and_the_others_keep_theirs() {
    let mut rig = Rig::full();
    rig.of_nodes = rig.metrics.can_line(2, "memory", Stop::new().unwrap());
    // The first bus of CAN was dropped, another one took its number.
    let text = rig.scrape();
    assert_eq!(text.matches("profidrive_can_busy_seconds_total{line=\"2\"}").count(), 1);
    drop(rig.metrics.line(3, "memory", Stop::new().unwrap()));
    assert!(!rig.scrape().contains("line=\"3\""));
}

#[test]
fn an_address_that_cannot_be_is_refused() {
    let metrics = Metrics::start("127.0.0.1:0", Reach::ThisMachine).unwrap();
    let taken = metrics.address().to_string();
    let error = Metrics::start(&taken, Reach::ThisMachine).unwrap_err();
    assert!(matches!(error, MetricsError::Listen { .. }));
    assert!(error.to_string().contains("another program listens there"), "{error}");
    let error = Metrics::start("0.0.0.0:0", Reach::ThisMachine).unwrap_err();
    assert!(matches!(error, MetricsError::TooFar { .. }), "{error}");
    let (head, body) = get(metrics.address(), "/");
    assert!(head.starts_with("HTTP/1.1 404") && body.contains("the metrics are at /metrics"), "{body}");
}

/// What a page shows between two marks, and the page with something else there.
fn between(page: &str, wanted: &str) -> (String, String) {
    const MARKS: [&str; 2] = ["<!-- made by tests/line/metrics.rs -->\n", "<!-- end -->"];
    let (before, rest) = page.split_once(MARKS[0]).unwrap();
    let (shown, after) = rest.split_once(MARKS[1]).unwrap();
    (shown.to_owned(), format!("{before}{}{wanted}{}{after}", MARKS[0], MARKS[1]))
}

#[test]
fn the_page_lists_every_metric() {
    let mut table = String::from("\n| metric | type | labels | meaning |\n| --- | --- | --- | --- |\n");
    // What comes from the user, or has one value for each line, station or bucket.
    let free = ["line", "address", "twin", "link", "model", "version", "le"];
    for (family, told) in families(&Rig::full().scrape()) {
        let name = match told.kind.as_str() {
            "histogram" => family,
            _ => told.names.iter().next().unwrap().clone(),
        };
        let label = |(label, values): (&String, &BTreeSet<String>)| {
            if free.contains(&label.as_str()) {
                return format!("`{label}`");
            }
            let values: Vec<_> = values.iter().map(String::as_str).collect();
            format!("`{label}`: {}", values.join(", "))
        };
        let labels: Vec<_> = told.labels.iter().filter(|(label, _)| *label != "twin").map(label).collect();
        writeln!(table, "| `{name}` | {} | {} | {} |", told.kind, labels.join("; "), told.help).unwrap();
    }
    table.push('\n');
    let file = root().join("docs/metrics.md");
    let page = std::fs::read_to_string(&file).unwrap();
    let (shown, rewritten) = between(&page, &table);
    if std::env::var_os("PROFIDRIVE_REWRITE").is_some() {
        std::fs::write(&file, rewritten).unwrap();
    } else {
        assert_eq!(shown, table, "rewrite it with PROFIDRIVE_REWRITE=1");
    }
}

/// Every text under the keys `expr` and `query`.
fn queries(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                match (key.as_str(), value) {
                    ("expr" | "query", Value::String(query)) => found.push(query.clone()),
                    _ => queries(value, found),
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| queries(item, found)),
        _ => {}
    }
}

/// The words of a query that are names.
fn words(query: &str) -> impl Iterator<Item = &str> {
    query.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_')
}

#[test]
fn the_dashboard_asks_for_metrics_and_labels_that_there_are() {
    let told = families(&Rig::full().scrape());
    let names: BTreeSet<_> = told.iter().flat_map(|(_, told)| told.names.clone()).collect();
    let mut labels: BTreeSet<_> = told.iter().flat_map(|(_, told)| told.labels.keys().cloned()).collect();
    // Prometheus adds these.
    labels.extend(["job".to_owned(), "instance".to_owned()]);
    let file = std::fs::read_to_string(root().join("docs/grafana/profidrive.json")).unwrap();
    let mut found = Vec::new();
    queries(&serde_json::from_str(&file).unwrap(), &mut found);
    assert!(found.len() > 20, "{found:?}");
    let mut asked = BTreeSet::new();
    for query in found {
        for name in
            words(&query).filter(|name| name.starts_with("profidrive_") || name.starts_with("process_"))
        {
            assert!(names.contains(name), "{name} in {query}");
            asked.insert(name.to_owned());
        }
        for clause in ["by (", "on (", "group_left (", "without ("] {
            for rest in query.split(clause).skip(1) {
                for label in words(rest.split(')').next().unwrap()).filter(|label| !label.is_empty()) {
                    assert!(labels.contains(label), "{label} in {query}");
                }
            }
        }
    }
    for name in ["requests_total", "retries_total", "watchdog_expiries_total", "faults_total", "drive_state"]
    {
        assert!(asked.contains(&format!("profidrive_{name}")), "nobody asks for {name}");
    }
    // And the page's examples.
    let page = std::fs::read_to_string(root().join("docs/metrics.md")).unwrap();
    for name in words(&page).filter(|name| name.starts_with("profidrive_")) {
        let is_family = told.iter().any(|(family, _)| family == name);
        assert!(is_family || names.contains(name), "{name} in docs/metrics.md");
    }
}
