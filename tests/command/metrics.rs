//! `emulate --metrics`: what Prometheus reads is what the panel says, whatever happens on the line.

use std::collections::BTreeMap;
use std::io::Write;
use std::net::{SocketAddr, TcpStream};

use profidrive::profibus::ppo::{Outputs, Pkw, Stw};
use serde_json::{Value, json};

use super::nodes;
use crate::emulator;
use crate::panel::{Answer, Emulator, PATIENCE, State};
use crate::pty::Master;

/// What is at this place.
fn get(place: SocketAddr, request: &str, host: &str) -> Answer {
    let mut stream = TcpStream::connect(place).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(stream, "{request} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
    Answer::read(stream)
}

/// The series that Prometheus reads.
#[derive(Debug)]
struct Series(BTreeMap<String, f64>);

impl Series {
    fn of(place: SocketAddr) -> Self {
        let answer = get(place, "GET /metrics", &place.to_string());
        assert_eq!(answer.status, 200, "{answer:?}");
        assert!(
            answer.head.contains("application/openmetrics-text; version=1.0.0; charset=utf-8"),
            "{answer:?}"
        );
        let body = answer.body.strip_suffix("# EOF\n").expect("the end");
        let lines = body.lines().filter(|line| !line.starts_with('#'));
        let series = lines.map(|line| line.rsplit_once(' ').unwrap());
        Self(series.map(|(name, value)| (name.to_owned(), value.parse().unwrap())).collect())
    }

    /// The value of `profidrive_NAME{LABELS}`.
    fn at(&self, name: &str, labels: &str) -> u64 {
        let name = format!("profidrive_{name}{{{labels}}}");
        *self.0.get(&name).unwrap_or_else(|| panic!("no {name} in {:#?}", self.0)) as u64
    }

    fn has(&self, labels: &str) -> bool {
        self.0.keys().any(|name| name.contains(labels))
    }

    /// Waits until one has this value.
    fn wait(place: SocketAddr, name: &str, labels: &str, value: u64) -> Self {
        let start = std::time::Instant::now();
        loop {
            let series = Self::of(place);
            if series.at(name, labels) == value {
                return series;
            }
            assert!(start.elapsed() < PATIENCE, "{name}{{{labels}}} is never {value}: {series:#?}");
        }
    }
}

/// A name of the panel as a label.
fn label(name: &Value) -> String {
    name.as_str().unwrap().to_lowercase().replace(' ', "_")
}

/// Every number of `/api/v1/lines/line`, beside the same of the metrics.
fn compare(series: &Series, bus: &Value) {
    let line = r#"line="1""#;
    assert_eq!(json!(series.at("line_rate_bits_per_second", line)), bus["rate_bits_per_second"]);
    assert_eq!(json!(series.at("telegrams_sent_total", line)), bus["telegrams_sent"]);
    assert_eq!(json!(series.at("resyncs_total", line)), bus["resyncs"]);
    for (list, name) in [("telegrams_heard", "telegrams_heard_total"), ("rejected", "line_errors_total")] {
        for counted in bus[list].as_array().unwrap() {
            let kind = format!("{line},kind=\"{}\"", label(&counted["what"]));
            assert_eq!(json!(series.at(name, &kind)), counted["count"], "{kind}");
        }
    }
    let mut reply_times = BTreeMap::<String, u64>::new();
    for station in bus["stations"].as_array().unwrap() {
        let (address, counters) = (&station["address"], &station["counters"]);
        let station_is = format!("{line},address=\"{address}\"");
        let requests: u64 = ["srd", "sdn", "fdl_status", "other_requests"]
            .iter()
            .map(|kind| series.at("requests_total", &format!("{station_is},kind=\"{kind}\"")))
            .sum();
        assert_eq!(json!(requests), counters["requests"], "{station_is}");
        assert_eq!(json!(series.at("retries_total", &station_is)), counters["retries"]);
        assert_eq!(json!(series.at("replies_total", &station_is)), counters["replies"]);
        assert_eq!(json!(series.at("watchdog_expiries_total", &station_is)), counters["watchdog_expiries"]);
        let too_late = series.at("errors_total", &format!("{station_is},kind=\"reply_too_late\""));
        assert_eq!(json!(too_late), counters["replies_too_late"]);
        let active = station["presence"] == json!("active");
        assert_eq!(series.at("station_active", &station_is), u64::from(active));
        for time in station["reply_times"].as_array().unwrap() {
            let up_to = time["up_to_microseconds"].as_u64();
            let up_to = up_to.map_or("+Inf".into(), |up_to| (up_to as f64 / 1e6).to_string());
            *reply_times.entry(up_to).or_default() += time["count"].as_u64().unwrap();
        }
    }
    let mut bounds: Vec<_> = reply_times.into_iter().collect();
    bounds.sort_by(|(one, _), (other, _)| one.parse::<f64>().unwrap().total_cmp(&other.parse().unwrap()));
    let mut sum = 0;
    for (up_to, count) in bounds {
        sum += count;
        assert_eq!(series.at("reply_time_seconds_bucket", &format!("le=\"{up_to}\",{line}")), sum, "{up_to}");
    }
    assert_eq!(series.at("reply_time_seconds_count", line), sum);
}

#[test]
fn each_number_is_what_the_panel_says_and_a_power_cycle_takes_none_back() {
    let gsd = format!("7,gsd={}/tests/gsd/remote_io.gsd", env!("CARGO_MANIFEST_DIR"));
    let emulator =
        Emulator::with(&["--metrics", "127.0.0.1:0", "--drive", "5", "--station", &gsd, "--ppo-drive", "9"]);
    let place = emulator.metrics.unwrap();
    let five = r#"line="1",address="5""#;
    let state = |state: &str| format!("{five},state=\"{state}\"");

    let fresh = Series::of(place);
    compare(&fresh, &emulator.get("/api/v1/lines/line"));
    assert_eq!(
        (fresh.at("slave_state", &state("wait_prm")), fresh.at("drive_state", &state("ready"))),
        (1, 1)
    );

    // Data_Exchange, and the last request once more.
    let mut master = Master::open(emulator.terminal());
    for _ in 0..20 {
        master.exchange(&Outputs::octets(Pkw::ZERO, Stw::from_raw(0), 0)).unwrap();
    }
    master.retry().unwrap();
    // Noise, and a telegram with a wrong FCS.
    master.noise(&[0x10, 0x05, 0x02, 0x49, 0x51, 0x16]);
    let series = Series::wait(place, "line_errors_total", r#"line="1",kind="checksum""#, 1);
    compare(&series, &emulator.get("/api/v1/lines/line"));
    assert_eq!(series.at("retries_total", five), 1);
    assert_eq!(series.at("requests_total", &format!("{five},kind=\"srd\"")), 3 + 20 + 1);
    assert_eq!(
        (series.at("slave_state", &state("data_exch")), series.at("slave_state", &state("wait_prm"))),
        (1, 0)
    );

    // A fault of each kind of drive.
    emulator.set("POST", "/api/v1/stations/5/provoke", &json!({ "fault": "F" }));
    emulator.set("PATCH", "/api/v1/stations/9/inputs", &json!({ "fault_number": 77 }));
    let series = Series::wait(place, "faults_total", five, 1);
    assert_eq!(&json!(series.at("faults_total", five)), emulator.get("/api/v1/stations/5").counter("faults"));
    assert_eq!(series.at("drive_state", &state("fault")), 1);
    let nine = r#"line="1",address="9""#;
    assert_eq!(series.at("faults_total", nine), 1);
    assert_eq!(series.at("drive_state", &format!("{nine},state=\"fault\"")), 1);

    // A watchdog of 1 s, and a master that is silent.
    drop(master);
    let master = Master::parameterised(emulator.terminal(), [0x88, 100, 1]);
    let series = Series::wait(place, "watchdog_expiries_total", five, 1);
    compare(&series, &emulator.get("/api/v1/lines/line"));
    drop(master);

    // A power cycle takes nothing back, and without its cause the fault does not come again.
    assert_eq!(emulator.request("DELETE", "/api/v1/stations/5/inputs", "", "").status, 200);
    emulator.set("PUT", "/api/v1/stations/5/power", &json!({ "on": false }));
    assert_eq!(Series::of(place).at("drive_state", &state("off")), 1);
    emulator.set("PUT", "/api/v1/stations/5/power", &json!({ "on": true }));
    let cycled = Series::of(place);
    compare(&cycled, &emulator.get("/api/v1/lines/line"));
    assert_eq!((cycled.at("faults_total", five), cycled.at("retries_total", five)), (1, 1));

    // A station that is gone has no series; one that is added begins at 0. The line goes on.
    assert_eq!(emulator.request("DELETE", "/api/v1/stations/5", "", "").status, 204);
    let gone = Series::of(place);
    assert!(!gone.has(five), "{gone:#?}");
    emulator.set("POST", "/api/v1/stations", &json!({ "address": 5, "device": "ag03-1" }));
    let added = Series::of(place);
    assert_eq!((added.at("replies_total", five), added.at("faults_total", five)), (0, 0));
    let replies = |series: &Series| series.at("reply_time_seconds_count", r#"line="1""#);
    assert_eq!(replies(&added), replies(&cycled));
    assert_eq!(
        added.at("telegrams_sent_total", r#"line="1""#),
        cycled.at("telegrams_sent_total", r#"line="1""#)
    );
}

#[test]
fn a_station_removed_and_added_again_between_two_scrapes_begins_anew_and_is_there_once() {
    let emulator = Emulator::with(&["--metrics", "127.0.0.1:0", "--drive", "5"]);
    let place = emulator.metrics.unwrap();
    let five = r#"line="1",address="5""#;
    let requests = |series: &Series| -> u64 {
        ["srd", "sdn", "fdl_status", "other_requests"]
            .iter()
            .map(|kind| series.at("requests_total", &format!("{five},kind=\"{kind}\"")))
            .sum()
    };
    let mut master = Master::open(emulator.terminal());
    for _ in 0..5 {
        master.exchange(&Outputs::octets(Pkw::ZERO, Stw::from_raw(0), 0)).unwrap();
    }
    let before = Series::of(place);
    assert!(requests(&before) > 0);
    assert_eq!(emulator.request("DELETE", "/api/v1/stations/5", "", "").status, 204);
    emulator.set("POST", "/api/v1/stations", &json!({"address": 5, "device": "ag03-1"}));
    // A counter that goes back to 0 is a restart to Prometheus.
    let after = Series::of(place);
    assert_eq!(requests(&after), 0);
    assert_eq!(after.at("slave_state", &format!("{five},state=\"wait_prm\"")), 1);
    let answer = get(place, "GET /metrics", &place.to_string());
    let once = answer.body.matches(&format!("profidrive_retries_total{{{five}}}")).count();
    assert_eq!(once, 1, "{}", answer.body);
}

#[test]
fn nodes_have_their_states_services_and_faults() {
    let emulator = Emulator::with(&[
        "--metrics",
        "127.0.0.1:0",
        "--node",
        "5",
        "--node",
        "6,device=ap10",
        "--node",
        "7,device=asda-a2",
        "--link",
        "slcan-tcp:127.0.0.1:0",
    ]);
    let place = emulator.metrics.unwrap();
    let link = emulator.terminal().to_str().unwrap().strip_prefix("slcan-tcp:").unwrap().to_owned();
    let mut master = nodes::Master::open(&link);
    // 1018h sub 0, then an object that there is not, then the master gives a transfer up.
    assert!(master.sdo(6, "4018100000000000").starts_with("4F"));
    assert!(master.sdo(6, "40FF5F0000000000").starts_with("80"));
    master.send("t606880FF5F0000000405");
    master.send("t00020100");
    let six = r#"line="1",address="6""#;
    let series = Series::wait(place, "node_state", &format!("{six},state=\"operational\""), 1);
    let aborts = |by: &str| series.at("sdo_aborts_total", &format!("{six},by=\"{by}\""));
    assert_eq!((series.at("sdo_requests_total", six), aborts("node"), aborts("client")), (3, 1, 1));
    assert_eq!(series.at("can_error_state", &format!("{six},state=\"error_active\"")), 1);
    assert_eq!(series.at("drive_state", r#"line="1",address="7",state="inhibited""#), 1);
    assert!(!series.has(r#"profidrive_drive_state{line="1",address="6""#), "an AP10 is no drive");

    emulator.set("POST", "/api/v1/stations/5/provoke", &json!({ "fault": "F" }));
    let five = r#"line="1",address="5""#;
    let series = Series::wait(place, "drive_state", &format!("{five},state=\"fault\""), 1);
    assert_eq!((series.at("faults_total", five), series.at("emergencies_total", five)), (1, 1));

    // The bus as the panel sees it; TPDOs may pass meanwhile.
    let before = Series::of(place);
    let bus = emulator.get("/api/v1/lines/line");
    let after = Series::of(place);
    let frames = |series: &Series| {
        let of = |kind: &str| series.at("can_frames_total", &format!("line=\"1\",kind=\"{kind}\""));
        of("data") + of("remote")
    };
    let counted = bus["frames"].as_u64().unwrap();
    assert!((frames(&before)..=frames(&after)).contains(&counted), "{counted}");
    assert_eq!(json!(after.at("line_errors_total", r#"line="1",kind="error_frame""#)), bus["error_frames"]);
    assert_eq!(json!(after.at("line_rate_bits_per_second", r#"line="1""#)), bus["rate_bits_per_second"]);

    emulator.set("PUT", "/api/v1/stations/5/power", &json!({ "on": false }));
    let off = Series::of(place);
    assert_eq!(off.at("node_state", &format!("{five},state=\"off\"")), 1);
    assert_eq!(
        (off.at("drive_state", &format!("{five},state=\"off\"")), off.at("faults_total", five)),
        (1, 1)
    );
}

#[test]
fn all_lines_of_a_file_are_at_one_place_which_every_ready_line_names() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("line.toml");
    let text = "metrics = '127.0.0.1:0'\n[[line]]\nlink = 'pty:a\"b'\n[[line.drive]]\naddress = 5\n\
                [[line]]\nlink = 'slcan-tcp:127.0.0.1:0'\n[[line.node]]\nid = 5\ndevice = 'ap10'\n";
    std::fs::write(&file, text).unwrap();
    let mut emulator = emulator::Emulator::start(&["--line", file.to_str().unwrap()]);
    let second = emulator.line();
    let url = |ready: &str| ready.trim_end().split_once(" metrics=http://").unwrap().1.to_owned();
    assert_eq!(url(&emulator.ready), url(&second));
    let place = url(&second).strip_suffix("/metrics").unwrap().parse().unwrap();
    let series = Series::of(place);
    assert!(series.has("{line=\"1\",bus=\"profibus\",link=\"") && series.has("/a\\\"b\"}"), "{series:#?}");
    assert!(series.has("{line=\"2\",bus=\"can\",link=\"slcan-tcp:127.0.0.1:"), "{series:#?}");
    assert_eq!(series.at("station_active", r#"line="1",address="5""#), 1);
    assert_eq!(series.at("node_state", r#"line="2",address="5",state="pre_operational""#), 1);

    // Read only, and by this machine only: a web site whose name leads here is refused.
    for (request, host, status, words) in [
        ("GET /", "localhost", 404, "the metrics are at /metrics"),
        ("POST /metrics", "localhost", 405, "GET /metrics"),
        ("GET /metrics", "plant.example", 403, "an address of this machine in numbers"),
    ] {
        let answer = get(place, request, host);
        assert_eq!(answer.status, status, "{answer:?}");
        assert!(answer.detail().contains(words), "{answer:?}");
    }
    emulator.signal("TERM");
    let (code, _, log) = emulator.end();
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains("the metrics are at http://127.0.0.1:"), "{log}");
}

#[test]
fn others_read_the_metrics_under_any_name_where_they_are_let_in() {
    let emulator = emulator::Emulator::start(&["--metrics", "0.0.0.0:0", "--metrics-allow-remote"]);
    let (_, port) = emulator.ready.trim_end().split_once(" metrics=http://0.0.0.0:").unwrap();
    let port: u16 = port.strip_suffix("/metrics").unwrap().parse().unwrap();
    let answer =
        get(SocketAddr::from(([127, 0, 0, 1], port)), "GET /metrics", "profidrive.plant.example:9187");
    assert_eq!(answer.status, 200, "{answer:?}");
    emulator.signal("TERM");
    let (_, _, log) = emulator.end();
    assert!(log.contains("other machines can connect to 0.0.0.0:"), "{log}");
}
