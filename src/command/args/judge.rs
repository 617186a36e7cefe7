//! `profidrive judge`: which master with which stations, or which device; what is judged.

use core::str::FromStr;
use core::time::Duration;
use std::path::PathBuf;

use crate::host::can;
use crate::judge::device::{Soak, node, slave};
use crate::judge::{Requirement, Row, Slave};
use crate::profibus::fdl::Address;
use crate::time::BaudRate;
use clap::Args;

use super::judged_device::{DeviceLink, JudgedNode, JudgedSlave};
use super::spec::address;
use super::{BaudSpec, LinkSpec};

/// Judges a DP master, a slave or a CANopen node: makes errors on purpose, and says row by row whether it reacts correctly
///
/// A master: emulates its slaves. Prints `ready link=LINK stations=5,6`; then start the master under test, configured for
/// exactly these stations. The master is not changed.
///
/// A slave, with --slave: is its master, and tries it. Outputs are zero, and its address stays, unless --moves-allowed says
/// otherwise: do not give that option while the device can move a machine.
///
/// A node, with --node: is the master of its network. It is only read unless --write is given, and nothing moves unless
/// --moves-allowed is.
///
/// Exit status: 0 passed and complete, 1 a row failed, 2 wrong command line, 3 no master (no device) or no data exchange, 4
/// not finished or not enough judged, 5 a file or the link fails.
///
/// With a capture (pcapng, pcap, or octets in hexadecimal) nothing is provoked: it judges what the capture shows.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, after_help = EXAMPLES)]
pub(crate) struct Judge {
    #[command(subcommand)]
    pub(crate) compare: Option<Compare>,

    /// A capture to judge instead of a live master
    #[arg(value_name = "FILE.pcapng")]
    pub(crate) capture_file: Option<PathBuf>,

    /// The line of the master: pty, pty:PATH, serial:DEVICE or tcp:HOST:PORT (listens). Of a device: pty:PATH (makes it), the
    /// path of a terminal, serial:DEVICE, tcp:HOST:PORT (connects) or tcp-listen:HOST:PORT. Of a node: slcan-pty:PATH (makes it),
    /// slcan-tty:DEVICE, slcan-tcp:HOST:PORT (connects) or socketcan:INTERFACE
    #[arg(long, value_name = "LINK", default_value = "pty")]
    pub(crate) link: JudgeLink,

    /// Judges the slave at this address:
    /// ADDRESS[,gsd=FILE[,modules='A','B']][,ident=HEX][,cfg=HEX][,prm=HEX][,profile=ppo1..ppo5|profidrive][,records=FILE.toml][,mirror];
    /// mirror: its inputs follow its outputs. What is not given it says itself
    #[arg(long, value_name = "SPEC", group = "device", conflicts_with_all = ["capture_file", "class", "stations", "line",
        "master_gsd", "watchdog", "retries", "hsa", "gap_factor", "ttr", "min_interval", "auto_clear", "scenarios"])]
    pub(crate) slave: Option<JudgedSlave>,

    /// Judges the CANopen node of this number: ID[,eds=FILE], with a link of a CAN bus. It is only read unless --write is given
    #[arg(long, value_name = "SPEC", group = "device", conflicts_with_all = ["capture_file", "class", "stations", "line",
        "master_gsd", "watchdog", "retries", "hsa", "gap_factor", "ttr", "min_interval", "auto_clear", "scenarios",
        "slave", "slot", "master"])]
    pub(crate) node: Option<JudgedNode>,

    /// Of a device: records of a slave, and objects of a node, are written, and written back: of a node communication
    /// parameters, and values that no PDO carries
    #[arg(long, requires = "device")]
    pub(crate) write: bool,

    /// Of a device: outputs other than zero are sent, and its address is changed and changed back; process data of a node are
    /// written, and a drive is enabled and moved
    #[arg(long, requires = "device")]
    pub(crate) moves_allowed: bool,

    /// Of a device: what takes long is left out or done less often
    #[arg(long, requires = "device")]
    pub(crate) quick: bool,

    /// The rate of the line in bit/s; several rates: the master is judged at each, and --ask configures it. A slave is judged at
    /// the first, and must exchange data at each; gsd: the rates of its device file
    #[arg(long, value_name = "RATE[,RATE..]", value_delimiter = ',')]
    pub(crate) baud: Vec<BaudSpec>,

    /// The class of the master: 1, or 2 for one that reads slaves of another master, which the judge plays then
    #[arg(long, value_name = "CLASS", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub(crate) class: u8,

    /// A station as configured in the master:
    /// ADDRESS,ident=HEX,cfg=HEX[,prm=HEX][,groups=HEX][,failsafe=1][,min-interval=MS][,watchdog=MS][,absent][,dpv1], or ADDRESS,gsd=FILE
    #[arg(long = "station", value_name = "SPEC")]
    pub(crate) stations: Vec<JudgedStation>,

    /// The stations of a line file of `emulate` as well
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) line: Option<PathBuf>,

    /// The master's own device file: what it does not offer is not judged, what it cannot have is refused
    #[arg(long, value_name = "FILE.gsd")]
    pub(crate) master_gsd: Option<PathBuf>,

    /// The address of the master; of a device the address that the judge has
    #[arg(long, value_name = "ADDRESS", value_parser = master_address)]
    pub(crate) master: Option<Address>,

    /// The watchdog time that is configured in the master, in milliseconds; 0 = off. Of the stations without watchdog
    #[arg(long, value_name = "MS")]
    pub(crate) watchdog: Option<u64>,

    /// How often the master repeats a request without reply
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=15))]
    pub(crate) retries: Option<u32>,

    /// How long the master waits for a reply, T_SL, in milliseconds; of a device how long the judge waits
    #[arg(long, value_name = "MS", value_parser = clap::value_parser!(u64).range(1..=60_000))]
    pub(crate) slot: Option<u64>,

    /// The highest station address of the master
    #[arg(long, value_name = "ADDRESS", value_parser = station_address)]
    pub(crate) hsa: Option<Address>,

    /// The GAP factor G of the master: addresses of its GAP are asked in every G-th target rotation time
    #[arg(long, value_name = "G", value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) gap_factor: Option<u32>,

    /// The target rotation time of the token, T_TR, in milliseconds
    #[arg(long, value_name = "MS")]
    pub(crate) ttr: Option<f64>,

    /// Min_Slave_Interval of the stations without min-interval, in milliseconds
    #[arg(long, value_name = "MS")]
    pub(crate) min_interval: Option<f64>,

    /// Auto_Clear is configured in the master, with this Data_Control_Time in milliseconds
    #[arg(long, value_name = "MS", value_parser = clap::value_parser!(u64).range(1..=20_000))]
    pub(crate) auto_clear: Option<u64>,

    /// A command that operates the master, or does things at the device, run as COMMAND ACTION
    #[arg(long, value_name = "COMMAND")]
    pub(crate) ask: Option<String>,

    /// The judgement takes so long at most, in seconds: without it 180, one row alone 50, and 5 000 cycles of the master more
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=86_400))]
    pub(crate) time: Option<u64>,

    /// When everything was tried once, repeat scenarios at random for so long: 90s, 10min, 8h
    #[arg(long, value_name = "DURATION", value_parser = soak, conflicts_with_all = ["time", "capture_file"])]
    pub(crate) soak: Option<Duration>,

    /// Which scenarios a soak repeats: the same number, the same ones
    #[arg(long, value_name = "N", default_value_t = 1, requires = "soak")]
    pub(crate) seed: u64,

    /// Judge these rows only, as M-C03,M-E*; of slaves S-C03
    #[arg(long, value_name = "ROWS", value_delimiter = ',', value_parser = rows)]
    pub(crate) only: Vec<Rows>,

    /// These rows must be judged: without a verdict on each of them the exit status is 4
    #[arg(long, value_name = "ROWS", value_delimiter = ',', value_parser = rows)]
    pub(crate) require: Vec<Rows>,

    /// Write the verdicts as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,

    /// Write the verdicts as JUnit XML, for CI
    #[arg(long, value_name = "FILE")]
    pub(crate) junit: Option<PathBuf>,

    /// Write the verdicts as one HTML page, with a diagram of the telegrams of each failure
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,

    /// Also play the scenarios of this file
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) scenarios: Vec<PathBuf>,

    /// Write all telegrams, of a node all frames, to a capture
    #[arg(long, value_name = "FILE.pcapng")]
    pub(crate) capture: Option<PathBuf>,

    /// Let other machines connect to a tcp link
    #[arg(long)]
    pub(crate) allow_remote: bool,

    /// End when the standard input ends: with the program that started the judge, also if that is killed
    #[arg(long, conflicts_with = "capture_file")]
    pub(crate) end_with_stdin: bool,
}

#[derive(Debug, clap::Subcommand)]
pub(crate) enum Compare {
    /// Compares two judgements: which rows fail that did not, which no longer do, of which less is known, which take longer
    ///
    /// Exit status: 0 no row fails that did not, 1 one does, 4 less is known than before, 5 a file fails.
    #[command(after_help = "Example:\n  profidrive judge compare before.json after.json")]
    Compare {
        /// The report before, of --json
        before: PathBuf,
        /// The report after
        after: PathBuf,
    },
}

const EXAMPLES: &str = "\
Examples:
  profidrive judge --link pty:/tmp/bus --station 5,ident=1234,cfg=2313 --slot 100 --retries 2
                                              plays station 5 for the master on /tmp/bus
  profidrive judge --station 5,gsd=valves.gsd --only 'M-C03,M-E*' --json verdicts.json
  profidrive judge line.pcapng                judges a capture of a foreign bus
  profidrive judge --slave 5,gsd=my.gsd --link pty:/tmp/bus --html slave.html
                                              judges the slave that opens /tmp/bus
  profidrive judge --slave 5,gsd=my.gsd --link serial:/dev/ttyUSB0 --baud 19200 --ask ./bench.sh --moves-allowed
  profidrive judge --node 7,eds=my.eds --link slcan-tty:/dev/ttyACM0 --baud 250000 --write
                                              judges node 7 of the bus behind an slcan adapter";

/// The rows of one pattern, whoever is judged.
#[derive(Clone, Debug)]
pub(crate) struct Rows(String);

impl Rows {
    /// Its rows of this table.
    pub(crate) fn of<R: Requirement>(&self) -> Vec<R> {
        R::matching(&self.0)
    }
}

/// The rows of patterns: every row if there are none.
pub(crate) fn rows_of<R: Requirement>(patterns: &[Rows]) -> Vec<R> {
    if patterns.is_empty() {
        return R::all();
    }
    let named: Vec<R> = patterns.iter().flat_map(Rows::of).collect();
    R::all().into_iter().filter(|row| named.contains(row)).collect()
}

fn rows(pattern: &str) -> Result<Rows, String> {
    let rows = Rows(pattern.trim().into());
    if rows.of::<Row>().is_empty() && rows.of::<slave::Row>().is_empty() && rows.of::<node::Row>().is_empty()
    {
        return Err("no row has this name; expected names such as M-C03, or beginnings such as M-E*".into());
    }
    Ok(rows)
}

/// Where the other side is: a master or a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct JudgeLink(String);

impl JudgeLink {
    /// As it was given.
    pub(crate) fn text(&self) -> &str {
        &self.0
    }

    /// Of a master.
    ///
    /// # Errors
    /// It is one of a device.
    pub(crate) fn of_master(&self) -> Result<LinkSpec, String> {
        self.0.parse()
    }

    /// Of a node.
    ///
    /// # Errors
    /// It is no link of a CAN bus.
    pub(crate) fn of_node(&self) -> Result<can::LinkSpec, String> {
        match self.of_master() {
            Ok(LinkSpec::Can(spec)) => Ok(spec),
            Ok(LinkSpec::Pty(_) | LinkSpec::Serial(_) | LinkSpec::Tcp(_)) | Err(_) => {
                Err("a node is on a CAN bus; expected --link slcan-pty:PATH, slcan-tty:DEVICE, slcan-tcp:HOST:PORT or \
                     socketcan:INTERFACE"
                    .into())
            }
        }
    }

    /// Of a device.
    ///
    /// # Errors
    /// It is one of a master.
    pub(crate) fn of_device(&self) -> Result<DeviceLink, String> {
        self.0.parse()
    }
}

impl FromStr for JudgeLink {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let of_master = spec.parse::<LinkSpec>().map(|_| ());
        of_master.or_else(|words| spec.parse::<DeviceLink>().map(|_| ()).map_err(|_| words))?;
        Ok(Self(spec.into()))
    }
}

/// A time of a soak: a whole number of `s`, `min` or `h`, at most a week.
fn soak(text: &str) -> Result<Duration, String> {
    let wrong = || format!("'{text}' is no such time; expected for example 90s, 10min or 8h, at most 168h");
    let unit = text.find(|c: char| !c.is_ascii_digit()).ok_or_else(wrong)?;
    let (number, unit) = text.split_at(unit);
    let seconds = match unit {
        "s" => 1,
        "min" => 60,
        "h" => 3600,
        _ => return Err(wrong()),
    };
    let number: u64 = number.parse().map_err(|_| wrong())?;
    let whole = number.checked_mul(seconds).filter(|whole| (1..=LONGEST_SOAK).contains(whole));
    whole.map(Duration::from_secs).ok_or_else(wrong)
}

/// A week, in seconds.
const LONGEST_SOAK: u64 = 168 * 3600;

fn station_address(text: &str) -> Result<Address, String> {
    address(text, "expected 0 to 126")
}

/// 126 is for slaves that have no address yet.
fn master_address(text: &str) -> Result<Address, String> {
    let expected = "expected 0 to 125";
    let address = address(text, expected)?;
    if address.number() == 126 {
        Err(format!("126 is no address of a master; {expected}"))
    } else {
        Ok(address)
    }
}

/// A station as configured in the master.
#[derive(Clone, Debug)]
pub(crate) struct JudgedStation {
    pub(crate) slave: Slave,
    pub(crate) gsd: Option<PathBuf>,
}

const FORM: &str = "expected ADDRESS,ident=HEX,cfg=HEX[,prm=HEX][,groups=HEX][,failsafe=1][,min-interval=MS]\
    [,watchdog=MS][,absent][,dpv1], or ADDRESS,gsd=FILE with the same";

/// The longest user parameters and configuration.
const MOST_PRM: usize = 237;
const MOST_CFG: usize = 244;

impl FromStr for JudgedStation {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let mut parts = spec.split(',');
        let address = address(parts.next().unwrap_or_default(), FORM)?;
        let (mut ident, mut cfg, mut gsd) = (None, None, None);
        let mut slave = Slave::new(address, 0, Vec::new());
        for part in parts {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let wrong = |expected: &str| format!("'{value}' does not fit {key}; expected {expected}");
            match key {
                "ident" => {
                    let number = u16::from_str_radix(value, 16).ok().filter(|_| value.len() <= 4);
                    ident = Some(number.ok_or_else(|| wrong("an ident number in hex, such as 0AC5"))?);
                }
                "cfg" => {
                    let octets = octets(value, MOST_CFG).filter(|octets| !octets.is_empty());
                    cfg = Some(octets.ok_or_else(|| wrong("identifiers in hex, such as F3F2"))?);
                }
                "prm" => {
                    slave.prm =
                        Some(octets(value, MOST_PRM).ok_or_else(|| wrong("octets in hex, such as 0102"))?);
                }
                "groups" => {
                    let groups = octets(value, 1).and_then(|octets| octets.first().copied());
                    slave.groups = Some(groups.ok_or_else(|| wrong("one octet in hex, such as 01"))?);
                }
                "failsafe" => {
                    slave.fail_safe = match value {
                        "1" => true,
                        "0" => false,
                        _ => return Err(wrong("0 or 1")),
                    }
                }
                "min-interval" => {
                    let time = value.parse().ok().and_then(millis);
                    slave.min_interval = Some(time.ok_or_else(|| wrong("milliseconds"))?);
                }
                "watchdog" => {
                    let time = value.parse().ok().and_then(millis);
                    slave.watchdog = Some(time.ok_or_else(|| wrong("milliseconds"))?);
                }
                "absent" if value.is_empty() => slave.absent = true,
                "dpv1" if value.is_empty() => slave.dpv1 = true,
                "gsd" if !value.is_empty() => gsd = Some(PathBuf::from(value)),
                _ => return Err(format!("'{part}' is not understood; {FORM}")),
            }
        }
        match (&gsd, ident, cfg) {
            (None, Some(ident), Some(cfg)) => {
                slave.ident = ident;
                crate::profibus::dp::IoLengths::of(&cfg).map_err(|error| format!("cfg: {error}"))?;
                slave.cfg = Some(cfg);
            }
            (Some(_), None, cfg) => slave.cfg = cfg,
            (None, ..) => return Err(format!("ident and cfg must be given; {FORM}")),
            (Some(_), Some(_), _) => return Err(format!("ident is in the device file already; {FORM}")),
        }
        Ok(Self { slave, gsd })
    }
}

fn octets(text: &str, most: usize) -> Option<Vec<u8>> {
    if !text.len().is_multiple_of(2)
        || text.len() / 2 > most
        || !text.bytes().all(|digit| digit.is_ascii_hexdigit())
    {
        return None;
    }
    text.as_bytes()
        .chunks(2)
        .map(|pair| u8::from_str_radix(core::str::from_utf8(pair).ok()?, 16).ok())
        .collect()
}

/// A time in milliseconds, at most a minute.
pub(crate) fn millis(millis: f64) -> Option<Duration> {
    (0.0..=60_000.0).contains(&millis).then(|| Duration::from_secs_f64(millis / 1000.0))
}

impl Judge {
    /// The rate of the line, if one is given.
    pub(crate) fn rate(&self) -> Option<BaudRate> {
        match &self.baud[..] {
            [rate] => rate.fixed(),
            [] | [_, _, ..] => None,
        }
    }

    /// The rates at which the master is judged one after the other, if there are several.
    pub(crate) fn rates(&self) -> Option<Vec<BaudRate>> {
        (self.baud.len() > 1).then(|| self.baud.iter().filter_map(|rate| rate.fixed()).collect())
    }

    /// The rate at which a slave is judged, and the others at which it is tried; `of_file` are those of its device file.
    pub(crate) fn rates_of_slave(&self, of_file: Vec<BaudRate>) -> (Option<BaudRate>, Vec<BaudRate>) {
        let mut rates = match &self.baud[..] {
            [BaudSpec::OfFile] => of_file,
            rates => rates.iter().filter_map(|rate| rate.fixed()).collect(),
        };
        // The rate that every serial port has.
        let home = rates
            .iter()
            .position(|rate| *rate == BaudRate::K19_2)
            .filter(|_| self.baud == [BaudSpec::OfFile]);
        if rates.is_empty() {
            return (None, rates);
        }
        let home = rates.remove(home.unwrap_or_default());
        (Some(home), rates)
    }

    /// How long rows of a device are tried again.
    pub(crate) fn soak_of_device(&self) -> Option<Soak> {
        self.soak.map(|lasts| Soak { lasts, seed: self.seed })
    }

    /// Whether it can be judged at these rates.
    fn check_rates(&self) -> Result<(), String> {
        if let Some(slave) = &self.slave
            && self.baud == [BaudSpec::OfFile]
        {
            return if slave.gsd.is_some() {
                Ok(())
            } else {
                Err("--baud gsd needs the device file: --slave ADDRESS,gsd=FILE".into())
            };
        }
        for rate in &self.baud {
            if self.node.is_some() { rate.check_can() } else { rate.check_profibus() }?;
        }
        if self.baud.len() > 1 && self.node.is_some() {
            return Err(
                "a node is judged at one rate; give --baud one, and judge it again at the next".into()
            );
        }
        let Some(rates) = self.rates() else { return Ok(()) };
        if rates.len() < self.baud.len() {
            return Err("--baud auto is one rate; give the rates as numbers".into());
        }
        if let Some((_, rate)) =
            rates.iter().enumerate().find(|(at, rate)| rates.iter().take(*at).any(|before| before == *rate))
        {
            return Err(format!("--baud names {rate} twice"));
        }
        if self.slave.is_some() {
            return Ok(());
        }
        if self.ask.is_none() {
            return Err("--baud with several rates needs --ask: COMMAND rate RATE configures the master for each and starts it".into());
        }
        let single = [
            ("--capture", self.capture.is_some()),
            ("--soak", self.soak.is_some()),
            ("a capture file", self.capture_file.is_some()),
        ];
        match single.iter().find(|(_, given)| *given) {
            Some((name, _)) => Err(format!("{name} is for one rate; give --baud one")),
            None => Ok(()),
        }
    }

    /// Whether these stations can be judged together.
    pub(crate) fn check_stations<'a>(
        &self,
        stations: impl Iterator<Item = &'a Slave> + Clone,
    ) -> Result<(), String> {
        if self.capture_file.is_none() && stations.clone().next().is_none() {
            return Err(format!("a station is missing: --station SPEC; {FORM}"));
        }
        if self.capture_file.is_none() && stations.clone().all(|slave| slave.absent) {
            return Err("every station is absent; give one that is present".into());
        }
        for (at, slave) in stations.clone().enumerate() {
            let address = slave.address;
            if stations.clone().take(at).any(|other| other.address == address) {
                return Err(format!("two stations have address {address}; give each its own"));
            }
            if self.master == Some(address) {
                return Err(format!("station {address} has the address of the master"));
            }
        }
        Ok(())
    }

    /// Whether the rows that are named are of this table, and those that are required among those that are judged.
    fn check_rows<R: Requirement>(&self) -> Result<(), String> {
        if let Some(rows) = self.only.iter().chain(&self.require).find(|rows| rows.of::<R>().is_empty()) {
            return Err(format!("no row of a {} is named '{}'", R::SUBJECT, rows.0));
        }
        let wanted = rows_of::<R>(&self.only);
        let required: Vec<R> = self.require.iter().flat_map(Rows::of).collect();
        match required.iter().find(|row| !wanted.contains(row)) {
            Some(row) => Err(format!("--require names {}, which --only does not", row.id())),
            None => Ok(()),
        }
    }

    pub(super) fn check(&self) -> Result<(), String> {
        if self.compare.is_some() {
            return Ok(());
        }
        self.check_rates()?;
        if self.slave.is_some() {
            self.link.of_device()?;
            return self.check_rows::<slave::Row>();
        }
        if self.node.is_some() {
            self.link.of_node()?;
            return self.check_rows::<node::Row>();
        }
        if let LinkSpec::Can(_) = self.link.of_master()? {
            return Err("a link of a CAN bus is for CANopen; the judge plays slaves of PROFIBUS-DP".into());
        }
        if self.line.is_none() {
            self.check_stations(self.stations.iter().map(|station| &station.slave))?;
        }
        self.check_rows::<Row>()?;
        if self.min_interval.is_some_and(|interval| millis(interval).is_none()) {
            return Err("--min-interval is outside 0 to 60000 ms".into());
        }
        if self.ttr.is_some_and(|ttr| millis(ttr).is_none()) {
            return Err("--ttr is outside 0 to 60000 ms".into());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
