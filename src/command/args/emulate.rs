//! `profidrive emulate`: which drives, on which line, with which faults.

use core::ops::RangeInclusive;
use std::collections::BTreeSet;
use std::path::PathBuf;

use crate::host::can;
use crate::host::fault::{BusKind, Row, Rule, Way};
use crate::host::list::{DEVICES, Device, Group, RATES, Spec};
use crate::profibus::fdl::Address;

use super::link::expected_rates;
use super::link::host_and_port;
use super::spec::{offered_baud, offered_quirk, quirk_parts, quirks_help, unknown_quirk};
use super::{BaudSpec, Devices, LinkSpec, examples};

/// Puts emulated drives on a line, or CANopen nodes on a CAN bus, until SIGINT (Ctrl-C) or SIGTERM
///
/// Prints one line to stdout when it is ready, `ready link=<what a master opens> drives=<addresses>` (or
/// `nodes=<node numbers>`), and logs to stderr. Exit codes: 0 after
/// SIGINT or SIGTERM, 2 the command line is wrong, 1 any other error.
#[derive(Debug, clap::Args)]
#[command(after_help = after_help())]
pub(crate) struct Emulate {
    #[command(flatten)]
    pub(crate) devices: Devices,

    /// Takes everything from a file, also several lines (docs/line.md); only --check and --end-with-stdin can be given with it
    #[arg(
        long,
        value_name = "FILE.toml",
        conflicts_with_all = Devices::options().chain([
            "force_address", "link", "baud", "slot_time", "allow_remote", "faults", "panel", "panel_allow_remote", "metrics",
            "metrics_allow_remote", "state_dir", "capture", "quirks", "panel_files", "bench",
        ])
    )]
    pub(crate) line: Option<PathBuf>,

    /// Reads the file of --line, or what the other options say, and all files that are named, says what is there, and opens nothing
    #[arg(long = "check")]
    pub(crate) check_only: bool,

    /// Do not listen first whether another station on a serial line has the address of a drive
    #[arg(long)]
    pub(crate) force_address: bool,

    /// The line: pty (a new pseudo-terminal), pty:PATH (with a symbolic link PATH to it), serial:DEVICE or
    /// tcp:HOST:PORT (raw octets, several clients; port 0: a free one). With --node the adapters of the CAN bus: slcan-pty,
    /// slcan-pty:PATH or slcan-tcp:HOST:PORT, where each connection is an adapter; or a real bus that the nodes are connected to:
    /// slcan-tty:PATH (a USB adapter that speaks slcan) or socketcan:INTERFACE (Linux, feature socketcan)
    #[arg(
        long,
        default_value = "pty",
        default_value_if(Group::Node.name(), clap::builder::ArgPredicate::IsPresent, "slcan-pty")
    )]
    pub(crate) link: LinkSpec,

    /// The rate in bit/s, or auto: on a pty (and the default there) what the master sets the terminal to, on a serial
    /// line what is heard on it. On a CAN bus it is the rate of every node, 500000 unless given
    #[arg(long, value_name = "RATE|auto", value_parser = offered_baud(), hide_possible_values = true)]
    pub(crate) baud: Option<BaudSpec>,

    /// The slot time of the master on a serial line in bit times: a reply that cannot begin within it is dropped and
    /// counted. Without it the usual one of the rate, from 100 at 9600 bit/s to 1000 at 12000000 bit/s
    #[arg(long, value_name = "BITS", value_parser = slot_time)]
    pub(crate) slot_time: Option<u16>,

    /// Lets other machines connect to a tcp link. There is no password: everybody who connects can command the drives
    #[arg(long)]
    pub(crate) allow_remote: bool,

    /// A fault on purpose, to test the master: FAULT[=VALUE][,rate=P][,count=N][,at=N][,seed=N][,station=ADDRESS]
    /// [,service=NAME][,state=NAME][,retry=N], on a CAN bus FAULT[=VALUE][,node=ID][,id=HEX][,rate=P][,count=N][,at=N][,seed=N];
    /// repeat it for more
    #[arg(long = "fault", value_name = "SPEC")]
    pub(crate) faults: Vec<String>,

    /// Serves the panel for browsers, HTTP control and a live stream at ADDR:PORT, as in 127.0.0.1:8080 (port 0: a free
    /// one), and adds panel=URL to the line on stdout
    #[arg(long, value_name = "ADDR:PORT", value_parser = panel_place)]
    pub(crate) panel: Option<String>,

    /// Lets other machines reach the panel. There is no password: everybody who connects can control the stations
    #[arg(long, requires = "panel")]
    pub(crate) panel_allow_remote: bool,

    /// Serves the counters for Prometheus at http://ADDR:PORT/metrics, as in 127.0.0.1:9187 (port 0: a free one), and
    /// adds metrics=URL to the line on stdout (docs/metrics.md)
    #[arg(long, value_name = "ADDR:PORT", value_parser = metrics_place)]
    pub(crate) metrics: Option<String>,

    /// Lets other machines read the metrics. There is no password
    #[arg(long, requires = "metrics")]
    pub(crate) metrics_allow_remote: bool,

    /// The folder of device files and tables that may be named over HTTP, for stations that are added there; without it none is
    /// read
    #[arg(long, value_name = "DIR", requires = "panel")]
    pub(crate) panel_files: Option<PathBuf>,

    /// Lets those who connect to the panel use a small master in this program, beside the devices: to enable, move, stop, read
    /// and write. It is silent until it is asked, and leaves drives that another master owns alone. Not on a real bus
    #[arg(long, requires = "panel")]
    pub(crate) bench: bool,

    /// Keeps the EEPROM of each drive or node in a file in DIR, which is created if it is missing. Without it the EEPROM is lost
    /// when the process ends
    #[arg(long, value_name = "DIR")]
    pub(crate) state_dir: Option<PathBuf>,

    /// Writes every telegram or frame in both directions to FILE, which Wireshark opens (docs/wireshark); an existing FILE is
    /// replaced
    #[arg(long, value_name = "FILE.pcapng")]
    pub(crate) capture: Option<PathBuf>,

    /// Ends when its standard input ends: with the program that started it, also if that is killed
    #[arg(long)]
    pub(crate) end_with_stdin: bool,

    /// How all drives behave where the manuals are not clear; repeat it for more (--help lists the quirks)
    #[arg(
        long = "quirk",
        value_name = "NAME=VALUE",
        long_help = quirks_help(),
        value_parser = offered_quirk(),
        hide_possible_values = true
    )]
    pub(crate) quirks: Vec<String>,

    /// It is for somebody who tries a device.
    #[arg(skip)]
    pub(crate) tried: Option<Tried>,
}

/// What somebody wants who tries a device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tried {
    /// The panel in a browser.
    pub(crate) browser: bool,
}

/// Host and port of the panel.
pub(crate) fn panel_place(place: &str) -> Result<String, String> {
    host_and_port(place, "127.0.0.1:8080", "expected ADDR:PORT")
}

/// Host and port of the metrics.
pub(crate) fn metrics_place(place: &str) -> Result<String, String> {
    host_and_port(place, "127.0.0.1:9187", "expected ADDR:PORT")
}

/// Where Prometheus reads what was counted, and who may.
#[derive(Clone, Debug)]
pub(crate) struct MetricsSpec {
    pub(crate) place: String,
    pub(crate) allow_remote: bool,
}

impl Emulate {
    /// Where its metrics are.
    pub(crate) fn metrics(&self) -> Option<MetricsSpec> {
        let place = self.metrics.clone()?;
        Some(MetricsSpec { place, allow_remote: self.metrics_allow_remote })
    }

    /// A line with nobody on it.
    pub(crate) fn on(link: LinkSpec) -> Self {
        Self {
            devices: Devices::default(),
            line: None,
            check_only: false,
            force_address: false,
            link,
            baud: None,
            slot_time: None,
            allow_remote: false,
            faults: Vec::new(),
            panel: None,
            panel_allow_remote: false,
            metrics: None,
            metrics_allow_remote: false,
            panel_files: None,
            bench: false,
            state_dir: None,
            capture: None,
            end_with_stdin: false,
            quirks: Vec::new(),
            tried: None,
        }
    }

    /// Everybody on a line of PROFIBUS.
    pub(crate) fn slaves(&self) -> &[Spec] {
        &self.devices.slaves
    }

    /// Every node asked for.
    pub(crate) fn nodes(&self) -> &[Spec] {
        &self.devices.nodes
    }

    /// The faults of the line.
    pub(crate) fn faults(&self) -> Result<Vec<Rule>, String> {
        let bus = if self.nodes().is_empty() { BusKind::Profibus } else { BusKind::Can };
        let read = |text: &String| {
            Rule::on(bus, text)
                .map_err(|error| format!("invalid value '{text}' for '--fault <SPEC>': {error}"))
        };
        self.faults.iter().map(read).collect()
    }

    /// Chooses the quirks of all devices of the line for one of them.
    pub(crate) fn choose_quirks(&self, spec: &mut Spec) -> Result<(), String> {
        for text in &self.quirks {
            let (name, value) = quirk_parts(text)?;
            spec.choose_common_quirk(name, value)?;
        }
        Ok(())
    }

    /// Whether a quirk of all is one of a device: on PROFIBUS of any that may be added, on a CAN bus of one that is there.
    pub(crate) fn check_quirk(&self, text: &str) -> Result<(), String> {
        let (name, value) = quirk_parts(text)?;
        let mut there: Vec<&'static Device> = if self.nodes().is_empty() {
            DEVICES.iter().filter(|device| !device.group().is_on_can()).collect()
        } else {
            self.nodes().iter().map(|node| node.device).collect()
        };
        there.dedup_by_key(|device| device.quirks());
        let has_it = |device: &&&Device| device.quirks().iter().any(|row| row.name == name);
        match there.iter().find(has_it) {
            Some(device) => Spec::plain(device, 1).choose_quirk(name, value),
            None => Err(unknown_quirk(&there, name)),
        }
    }

    fn check_quirks(&self) -> Result<(), String> {
        self.quirks.iter().try_for_each(|text| {
            let checked = self.check_quirk(text);
            checked.map_err(|words| format!("invalid value '{text}' for '--quirk <NAME=VALUE>': {words}"))
        })
    }

    /// Whether the line goes on outside, on a real bus.
    const fn is_real(&self) -> bool {
        match &self.link {
            LinkSpec::Serial(_) | LinkSpec::Can(can::LinkSpec::Terminal(_) | can::LinkSpec::Socket(_)) => {
                true
            }
            LinkSpec::Pty(_)
            | LinkSpec::Tcp(_)
            | LinkSpec::Can(can::LinkSpec::Pty(_) | can::LinkSpec::Tcp(_)) => false,
        }
    }

    /// What no single argument shows.
    pub(crate) fn check(&self) -> Result<(), String> {
        if self.line.is_some() {
            // The file says it all.
            return Ok(());
        }
        if self.bench && self.is_real() {
            return Err("the master of --bench is not for a real bus, where it could move real drives; use a pty, tcp, slcan-pty \
                        or slcan-tcp link"
                .into());
        }
        match (&self.link, self.nodes().is_empty()) {
            (LinkSpec::Can(_), false) => self.check_nodes(),
            (LinkSpec::Pty(_) | LinkSpec::Serial(_) | LinkSpec::Tcp(_), true) => self.check_drives(),
            (LinkSpec::Can(_), true) => Err(format!(
                "this link is a CAN bus and the drives of --drive are on PROFIBUS; name CANopen nodes, for example \
                 --node 5,device={}, or use --link pty",
                Group::Node.devices().next().map_or("", Device::name)
            )),
            (LinkSpec::Pty(_) | LinkSpec::Serial(_) | LinkSpec::Tcp(_), false) => {
                Err("CANopen nodes are on a CAN bus; use --link slcan-pty:PATH, slcan-tcp:HOST:PORT, \
                     slcan-tty:PATH or socketcan:INTERFACE"
                    .into())
            }
        }
    }

    fn check_nodes(&self) -> Result<(), String> {
        if !self.slaves().is_empty() {
            return Err(
                "drives and stations are on PROFIBUS and nodes on CAN; start one emulator with --drive and another with \
                        --node"
                    .into(),
            );
        }
        let mut numbers = BTreeSet::new();
        if let Some(twice) =
            self.nodes().iter().find(|node| !numbers.insert(node.node()) && !node.choices.flag("twin"))
        {
            return Err(format!(
                "two nodes have the number {}; give each node its own, or say that one is a twin: --node {},twin",
                twice.place, twice.place
            ));
        }
        for (given, option) in
            [(self.force_address, "--force-address"), (self.slot_time.is_some(), "--slot-time")]
        {
            if given {
                return Err(format!("{option} is for drives on PROFIBUS; leave it out with --node"));
            }
        }
        for fault in self.faults()? {
            fault.check(numbers.iter().map(|node| node.number())).map_err(|error| {
                let (node, expected) = (error.station, error.expected());
                format!("--fault names node {node}, which is not on the bus; expected {expected}")
            })?;
        }
        self.check_quirks()?;
        if self.allow_remote && !matches!(self.link, LinkSpec::Can(can::LinkSpec::Tcp(_))) {
            return Err("--allow-remote needs an slcan-tcp link".into());
        }
        let Some(baud) = self.baud else { return Ok(()) };
        for product in self.nodes().iter().filter_map(|node| node.device.product()) {
            let rates = product.rates();
            if !baud.can().is_some_and(|rate| rates.contains(&rate.bits_per_second())) {
                let rates: Vec<_> = rates.iter().map(u32::to_string).collect();
                return Err(format!(
                    "the CAN bus of an {} has another rate; expected --baud with one of {}",
                    product.name,
                    rates.join(", ")
                ));
            }
        }
        baud.check_can()
    }

    fn check_drives(&self) -> Result<(), String> {
        self.baud.map_or(Ok(()), BaudSpec::check_profibus)?;
        let is_drive = |slave: &Spec| slave.device.group() == Group::Drive;
        if let Some(rate) = self.baud.and_then(BaudSpec::fixed)
            && !RATES.contains(rate)
            && self.slaves().iter().any(is_drive)
        {
            let (bits, expected) = (rate.bits_per_second(), expected_rates(RATES.iter()));
            return Err(format!("--baud {bits}: the drives do not know this rate; {expected}"));
        }
        let mut addresses: BTreeSet<Address> = BTreeSet::new();
        if let Some(twice) = self.slaves().iter().find(|slave| !addresses.insert(slave.address())) {
            let is_station = twice.device.group() == Group::Station;
            let (what, each) = if is_station { ("stations", "each") } else { ("drives", "each drive") };
            return Err(format!("two {what} have address {}; give {each} its own", twice.place));
        }
        self.check_quirks()?;
        for fault in self.faults()? {
            fault
                .check(addresses.iter().map(|address| address.number()))
                .map_err(|error| error.to_string())?;
        }
        if self.allow_remote && !matches!(self.link, LinkSpec::Tcp(_)) {
            return Err("--allow-remote needs a tcp link".into());
        }
        if self.slot_time.is_some() && !matches!(self.link, LinkSpec::Serial(_)) {
            return Err("--slot-time needs a serial link; on the others every reply is sent".into());
        }
        match (&self.link, self.baud) {
            (LinkSpec::Tcp(_), Some(BaudSpec::Auto)) => {
                Err("--baud auto needs a pty link; a tcp link has no rate of its own".into())
            }
            (LinkSpec::Tcp(_), Some(BaudSpec::OfFile | BaudSpec::Fixed(_) | BaudSpec::Other(_)) | None) => {
                Ok(())
            }
            (LinkSpec::Serial(_), None) => {
                Err("a serial line needs its rate; add for example --baud 19200, or --baud auto".into())
            }
            (LinkSpec::Serial(_), Some(_)) | (LinkSpec::Pty(_) | LinkSpec::Can(_), _) => Ok(()),
        }
    }
}

fn after_help() -> String {
    examples(EMULATE_EXAMPLES).replace("{faults}", &faults())
}

/// Every kind of fault, by where it acts.
fn faults() -> String {
    let ways = [
        ("requests", Way::Request),
        ("replies", Way::Reply),
        ("what a node sends", Way::Node),
        ("frames on a CAN bus", Way::Frame),
    ];
    let lines = ways.map(|(what, way)| {
        let rows = Row::all().iter().filter(|row| row.way == way);
        let rows: Vec<_> = rows.map(Row::to_string).collect();
        format!("  {what}: {}", rows.join(", "))
    });
    lines.join("\n")
}

const EMULATE_EXAMPLES: &str = "\
ADDRESS is 0 to 126; model defaults to {drive.1}, gear to 48.
ID is 1 to 127. An slcan adapter passes no frames before the master opens it (command O). The boot-up of the nodes is over by
then: read their state, or reset them (NMT 81h).
On a serial line each drive listens for up to 2 s before it answers; if another station has its address, it stays silent.
SIGUSR1 logs the counters (telegrams, retries, refusals, reply times), and for each drive what keeps it from moving.
RATE is 9600, 19200, 93750, 187500, 500000, 1500000, 3000000, 6000000 or 12000000;
on a CAN bus one that each node has, as 125000.

Faults, by what they count:
{faults}
Of the frames on a CAN bus those of one node with node=ID, with one identifier with id=HEX.
A fault is injected from number `at` on (1; `at` alone: only that one), with probability `rate` (1), at most `count` times
(no limit). The same `seed` (1) gives the same faults. TIME is for example 20ms. docs/faults.md explains each.

Examples:
  profidrive emulate --drive 5 --drive 6,model={drive.2},gear=24
  profidrive emulate --drives 1-125,model={drive.2}
  profidrive emulate --link pty:/tmp/bus --baud 500000
  profidrive emulate --drive 5 --station 7,gsd=valves.gsd --station 9,gsd=valves.gsd
{every group}
  profidrive emulate --state-dir ~/drives
  profidrive emulate --line line.toml
  profidrive emulate --node 5,device={node.2} --node 6,device={node.3} --link slcan-tcp:127.0.0.1:5000
  profidrive emulate --node 5 --node 6,device={node.2} --fault sdo-late=20ms,node=5 --panel 127.0.0.1:8080
  profidrive emulate --capture bus.pcapng
  profidrive emulate --drives 1-10 --link pty:/tmp/bus --metrics 127.0.0.1:9187
  profidrive emulate --link serial:/dev/ttyUSB0 --baud 19200 -v
  profidrive emulate --link tcp:127.0.0.1:5050 --fault no-reply,rate=0.01 --fault late=20ms,at=100";

/// The slot times that a master can have, in bit times.
pub(crate) const SLOT_TIMES: RangeInclusive<u16> = 37..=16383;

/// The slot time of a master in bit times.
fn slot_time(text: &str) -> Result<u16, String> {
    let bits = text.parse().ok().filter(|bits| SLOT_TIMES.contains(bits));
    bits.ok_or_else(|| format!("expected {} to {} bit times", SLOT_TIMES.start(), SLOT_TIMES.end()))
}
