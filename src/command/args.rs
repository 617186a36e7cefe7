//! The command line: what may be asked for, and how a wrong question is answered.

use core::fmt;
use core::str::FromStr;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{ArgAction, CommandFactory, Parser, Subcommand};
use profidrive::device::{Config, QUIRKS, QuirkError};
use profidrive::fdl::Address;
use profidrive::host::link::fault::Fault;
use profidrive::param::{Gear, Model};
use profidrive::time::BaudRate;

use super::{Failure, report};

/// Emulated PROFIBUS-DP drives to test masters against.
///
/// A simulator only: it moves nothing, and nothing it says is a proof of safety for a real machine.
#[derive(Debug, Parser)]
#[command(name = "profidrive", version, after_help = EXAMPLES, disable_help_subcommand = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) verbosity: Verbosity,
}

const EXAMPLES: &str = "\
Examples:
  profidrive demo                             a master and a drive in memory, told as a story
  profidrive emulate                          one AG03/1 at address 5; prints the terminal a master opens
  profidrive emulate --link pty:/tmp/bus      the same, under a name that stays
  profidrive emulate --help                   all about it";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Shows a master and a drive at work on a bus in memory: start-up, parameters, a travel job, a fault
    ///
    /// Needs no hardware and no arguments, and takes less than two seconds. Every telegram of the start-up is shown
    /// with its meaning, then the words of the parameter channel, control word and status word, and why the drive
    /// refuses what it refuses. Times are those on the bus.
    Demo,
    Emulate(Emulate),
}

/// Puts emulated drives on a line until SIGINT (Ctrl-C) or SIGTERM
///
/// Prints one line to stdout when it is ready, `ready link=<what a master opens> drives=<addresses>`, and logs to
/// stderr. Ends with 0 on SIGINT and SIGTERM, 2 if the command line is wrong, 1 if something else is.
#[derive(Debug, clap::Args)]
#[command(after_help = EMULATE_EXAMPLES)]
pub(crate) struct Emulate {
    /// A drive: ADDRESS[,model=ag03|ag03-1][,gear=24|48]; repeat it for more drives on the same line
    #[arg(
        long = "drive",
        value_name = "SPEC",
        default_value = "5,model=ag03-1,gear=48",
        default_value_if("ranges", clap::builder::ArgPredicate::IsPresent, None)
    )]
    single: Vec<DriveSpec>,

    /// Many alike: FIRST-LAST[,model=ag03|ag03-1][,gear=24|48], as in 1-125,gear=24; may be repeated and mixed with --drive
    #[arg(long = "drives", id = "ranges", value_name = "SPECS")]
    ranges: Vec<RangeSpec>,

    /// Do not listen first whether another station on a serial line has the address of a drive
    #[arg(long)]
    pub(crate) force_address: bool,

    /// The line: pty (a new pseudo-terminal), pty:PATH (with a symbolic link PATH to it), serial:DEVICE or
    /// tcp:HOST:PORT (raw octets, several clients; port 0: a free one)
    #[arg(long, default_value = "pty")]
    pub(crate) link: LinkSpec,

    /// The rate in bit/s, or auto: on a pty (and the default there) what the master sets the terminal to, on a serial
    /// line what is heard on it
    #[arg(long, value_name = "RATE|auto")]
    pub(crate) baud: Option<BaudSpec>,

    /// Lets other machines connect to a tcp link. There is no password: whoever connects commands the drives
    #[arg(long)]
    pub(crate) allow_remote: bool,

    /// A fault on purpose, to test the master: FAULT[=VALUE][,rate=P][,count=N][,at=N][,seed=N][,station=ADDRESS];
    /// repeat it for more
    #[arg(long = "fault", value_name = "SPEC")]
    pub(crate) faults: Vec<Fault>,

    /// Keeps each drive's EEPROM in a file in DIR, which is made if it is missing; without it the EEPROM lives as long
    /// as the process
    #[arg(long, value_name = "DIR")]
    pub(crate) state_dir: Option<PathBuf>,

    /// How all drives behave where the manuals leave it open; repeat it for more (--help lists the quirks)
    #[arg(long = "quirk", value_name = "NAME=VALUE", long_help = quirks_help())]
    pub(crate) quirks: Vec<QuirkSpec>,
}

/// A quirk, checked to exist.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct QuirkSpec {
    name: String,
    value: String,
}

impl QuirkSpec {
    /// Sets the quirk.
    pub(crate) fn choose(&self, config: &mut Config) -> Result<(), QuirkError> {
        config.set_quirk(&self.name, &self.value)
    }
}

impl FromStr for QuirkSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let (name, value) = spec.split_once('=').ok_or("expected NAME=VALUE, for example off1=brake")?;
        let quirk = Self { name: name.into(), value: value.into() };
        quirk.choose(&mut Config::new(Address::from_octet(0))).map_err(|error| match error {
            QuirkError::Unknown => {
                let names: Vec<_> = QUIRKS.iter().map(|quirk| quirk.name).collect();
                format!("quirk '{name}' is unknown; expected one of {}", names.join(", "))
            }
            QuirkError::Value { name, values } => {
                format!("quirk {name} cannot be '{value}'; expected {}", values.join(" or "))
            }
        })?;
        Ok(quirk)
    }
}

/// Every quirk with its values, the default first.
fn quirks_help() -> String {
    let mut text = String::from(
        "How all drives behave where the manuals leave it open; repeat it for more.\nThe first value is the \
         default; docs/quirks.md has the reasons.\n",
    );
    for quirk in QUIRKS {
        text += &format!("\n  {}={}\n      {}", quirk.name, quirk.values.join("|"), quirk.about);
    }
    text
}

impl Emulate {
    /// Every drive asked for, those named one by one first.
    pub(crate) fn drives(&self) -> impl Iterator<Item = DriveSpec> + '_ {
        self.single.iter().copied().chain(self.ranges.iter().flat_map(RangeSpec::drives))
    }
}

const EMULATE_EXAMPLES: &str = "\
ADDRESS is 0 to 126; model defaults to ag03-1, gear to 48.
On a serial line each drive listens up to two seconds before it takes part; one whose address is live stays silent.
SIGUSR1 logs what was counted so far: telegrams, retries, refusals, times of replies.
RATE is 9600, 19200, 45450, 93750, 187500, 500000, 1500000, 3000000, 6000000 or 12000000.

Faults, and what they count:
  replies         no-reply, late=TIME, duplicate, truncated, bit-errors[=N], wrong-fcs, wrong-length, wrong-source,
                  noise[=OCTETS]
  requests        drop-request, refuse-prm, refuse-cfg, not-ready=TIME (Chk_Cfg), lose-prm (Data_Exchange)
  Data_Exchange   diag-storm
  PKW answers     pkw-delay=EXCHANGES, pkw-wrong-ak, pkw-wrong-pnu, pkw-torn
A fault strikes from number `at` on (1; a lone `at` means that one only), with probability `rate` (1), at most `count`
times (no limit), the same for the same `seed` (1). TIME is for example 20ms. docs/faults.md explains each.

Examples:
  profidrive emulate --drive 5 --drive 6,model=ag03,gear=24
  profidrive emulate --drives 1-125,model=ag03
  profidrive emulate --link pty:/tmp/bus --baud 500000
  profidrive emulate --state-dir ~/drives
  profidrive emulate --link serial:/dev/ttyUSB0 --baud 19200 -v
  profidrive emulate --link tcp:127.0.0.1:5050 --fault no-reply,rate=0.01 --fault late=20ms,at=100";

/// How much is logged.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct Verbosity {
    /// Log more (-vv: everything); overrides RUST_LOG
    #[arg(short, long, global = true, display_order = 100, action = ArgAction::Count, conflicts_with = "quiet")]
    pub(crate) verbose: u8,

    /// Log warnings and errors only; overrides RUST_LOG
    #[arg(short, long, global = true, display_order = 101)]
    pub(crate) quiet: bool,
}

/// One emulated drive, as asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DriveSpec {
    pub(crate) address: Address,
    pub(crate) model: Model,
    pub(crate) gear: Gear,
}

const DRIVE_FORM: &str = "expected ADDRESS[,model=ag03|ag03-1][,gear=24|48]";

impl FromStr for DriveSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let (number, options) = split(spec);
        let address = address(number, DRIVE_FORM)?;
        Self::with_options(address, options, DRIVE_FORM)
    }
}

impl DriveSpec {
    fn with_options<'a>(
        address: Address,
        options: impl Iterator<Item = &'a str>,
        form: &str,
    ) -> Result<Self, String> {
        let (mut model, mut gear) = (None, None);
        for part in options {
            let (key, value) =
                part.split_once('=').ok_or_else(|| format!("'{part}' is not understood; {form}"))?;
            let again = match (key, value) {
                ("model", "ag03") => model.replace(Model::Ag03).is_some(),
                ("model", "ag03-1") => model.replace(Model::Ag03_1).is_some(),
                ("model", _) => return Err(format!("model '{value}' is unknown; expected ag03 or ag03-1")),
                ("gear", "24") => gear.replace(Gear::Ratio24).is_some(),
                ("gear", "48") => gear.replace(Gear::Ratio48).is_some(),
                ("gear", _) => return Err(format!("gear '{value}' is unknown; expected 24 or 48")),
                _ => return Err(format!("'{key}' is unknown; {form}")),
            };
            if again {
                return Err(format!("'{key}' is given twice; {form}"));
            }
        }
        let (model, gear) = (model.unwrap_or(Model::Ag03_1), gear.unwrap_or(Gear::Ratio48));
        Ok(Self { address, model, gear })
    }
}

/// Drives that differ in nothing but their addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RangeSpec {
    first: DriveSpec,
    last: Address,
}

const RANGE_FORM: &str = "expected FIRST-LAST[,model=ag03|ag03-1][,gear=24|48]";

impl FromStr for RangeSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let (range, options) = split(spec);
        let (first, last) = range
            .split_once('-')
            .ok_or_else(|| format!("'{range}' is no range of addresses; {RANGE_FORM}"))?;
        let (first, last) = (address(first, RANGE_FORM)?, address(last, RANGE_FORM)?);
        if last < first {
            return Err(format!("the range {range} is empty; {RANGE_FORM}"));
        }
        Ok(Self { first: DriveSpec::with_options(first, options, RANGE_FORM)?, last })
    }
}

impl RangeSpec {
    fn drives(&self) -> impl Iterator<Item = DriveSpec> + use<> {
        let first = self.first;
        let numbers = first.address.number()..=self.last.number();
        numbers.map(move |number| DriveSpec { address: Address::from_octet(number), ..first })
    }
}

/// What stands before the first comma, and the options behind it.
fn split(spec: &str) -> (&str, impl Iterator<Item = &str>) {
    let mut parts = spec.split(',');
    (parts.next().unwrap_or_default(), parts)
}

fn address(text: &str, form: &str) -> Result<Address, String> {
    if text.is_empty() || !text.bytes().all(|octet| octet.is_ascii_digit()) {
        return Err(format!("'{text}' is no address; {form}"));
    }
    let station = text.parse().ok().and_then(|number| Address::station(number).ok());
    station.ok_or_else(|| format!("address {text} is outside 0 to 126"))
}

impl fmt::Display for DriveSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let model = match self.model {
            Model::Ag03 => "AG03",
            Model::Ag03_1 => "AG03/1",
        };
        let gear = match self.gear {
            Gear::Ratio24 => "24:1",
            Gear::Ratio48 => "48:1",
        };
        write!(f, "SIKO {model}, gear {gear}, at address {}", self.address)
    }
}

/// Where the line is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum LinkSpec {
    Pty(Option<PathBuf>),
    Serial(String),
    /// Host and port.
    Tcp(String),
}

const LINKS: &str = "expected pty, pty:PATH, serial:DEVICE or tcp:HOST:PORT";

impl FromStr for LinkSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        // The ready line is one line whatever the path is.
        if spec.chars().any(char::is_control) {
            return Err(format!("a link has no control characters; {LINKS}"));
        }
        match spec.split_once(':') {
            None if spec == "pty" => Ok(Self::Pty(None)),
            Some(("pty", "")) => Err(format!("the path is missing; {LINKS}")),
            Some(("pty", path)) => Ok(Self::Pty(Some(path.into()))),
            None if spec == "serial" => Err(format!("the device is missing; {LINKS}")),
            Some(("serial", "")) => Err(format!("the device is missing; {LINKS}")),
            Some(("serial", device)) => Ok(Self::Serial(device.into())),
            Some(("tcp", place)) => tcp(place),
            None if spec == "tcp" => Err(format!("host and port are missing; {LINKS}")),
            _ => Err(LINKS.into()),
        }
    }
}

/// `HOST:PORT`, an IPv6 address in brackets. Whether the host is there shows when it is listened at.
fn tcp(place: &str) -> Result<LinkSpec, String> {
    match place.rsplit_once(':') {
        None | Some(("", _)) => {
            Err(format!("host and port must be given, for example tcp:127.0.0.1:5050; {LINKS}"))
        }
        Some((host, port)) if port.is_empty() || !port.bytes().all(|octet| octet.is_ascii_digit()) => {
            Err(format!("'{port}' is no port of {host}; {LINKS}"))
        }
        Some((_, port)) if port.parse::<u16>().is_err() => Err(format!("port {port} is outside 0 to 65535")),
        Some((host, _)) if host.contains(':') && !host.starts_with('[') => {
            Err(format!("an IPv6 address is written in brackets, for example tcp:[::1]:5050; {LINKS}"))
        }
        Some(_) => Ok(LinkSpec::Tcp(place.into())),
    }
}

/// How fast the line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BaudSpec {
    /// As the master sets it.
    Auto,
    Fixed(BaudRate),
}

impl FromStr for BaudSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        if spec == "auto" {
            return Ok(Self::Auto);
        }
        let rate = spec.parse().ok().and_then(|bits| BaudRate::from_bits_per_second(bits).ok());
        rate.map(Self::Fixed).ok_or_else(|| {
            let rates: Vec<_> = BaudRate::ALL.iter().map(|rate| rate.bits_per_second().to_string()).collect();
            format!("expected auto or one of {}", rates.join(", "))
        })
    }
}

/// A command line that leads to no command: wrong, or a question for help or the version.
pub(crate) struct Refusal(clap::Error);

impl Args {
    /// The arguments of this process.
    pub(crate) fn from_command_line() -> Result<Self, Refusal> {
        Self::from_arguments(std::env::args_os())
    }

    fn from_arguments(arguments: impl IntoIterator<Item = OsString>) -> Result<Self, Refusal> {
        let args = Self::try_parse_from(arguments).map_err(Refusal)?;
        args.check().map_err(|line| {
            let mut command = Self::command();
            command.build();
            let emulate = command.find_subcommand_mut("emulate").map(|emulate| emulate.to_owned());
            Refusal(emulate.unwrap_or(command).error(ErrorKind::ValueValidation, line))
        })?;
        Ok(args)
    }

    /// How much is logged: the demo tells its story without the master's log, unless that is asked for.
    pub(crate) fn log_verbosity(&self) -> Verbosity {
        match self.command {
            Command::Demo if self.verbosity.verbose == 0 => Verbosity { quiet: true, ..self.verbosity },
            Command::Demo | Command::Emulate(_) => self.verbosity,
        }
    }

    /// What no single argument shows.
    fn check(&self) -> Result<(), String> {
        let emulate = match &self.command {
            Command::Demo => return Ok(()),
            Command::Emulate(emulate) => emulate,
        };
        let mut addresses = BTreeSet::new();
        if let Some(twice) = emulate.drives().find(|drive| !addresses.insert(drive.address)) {
            return Err(format!("two drives have address {}; give each drive its own", twice.address));
        }
        if emulate.allow_remote && !matches!(emulate.link, LinkSpec::Tcp(_)) {
            return Err("--allow-remote needs a tcp link".into());
        }
        match (&emulate.link, emulate.baud) {
            (LinkSpec::Tcp(_), Some(BaudSpec::Auto)) => {
                Err("--baud auto needs a pty link; a tcp link has no rate of its own".into())
            }
            (LinkSpec::Tcp(_), Some(BaudSpec::Fixed(_)) | None) => Ok(()),
            (LinkSpec::Serial(_), None) => {
                Err("a serial line needs its rate; add for example --baud 19200, or --baud auto".into())
            }
            (LinkSpec::Serial(_), Some(_)) | (LinkSpec::Pty(_), _) => Ok(()),
        }
    }
}

impl Refusal {
    /// Prints what was asked for, or one line that says what is wrong; says the exit code.
    pub(crate) fn print(&self) -> ExitCode {
        let kind = self.0.kind();
        if matches!(kind, ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
            // Whoever asked may have closed the pipe after the first lines (`| head`).
            let _ = self.0.print();
            return ExitCode::SUCCESS;
        }
        let line = match kind == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
            true => "a command is missing; see 'profidrive --help'".into(),
            false => self.line(),
        };
        report(&Failure::Usage(line))
    }

    /// The first paragraph of the parser's error as one line, and where to read on.
    fn line(&self) -> String {
        let text = self.0.to_string();
        let lines: Vec<&str> = text.lines().map(str::trim).take_while(|line| !line.is_empty()).collect();
        let line = lines.join(" ");
        let line = line.strip_prefix("error: ").unwrap_or(&line);
        let emulate = std::env::args_os().any(|argument| argument == "emulate");
        let command = if emulate { "profidrive emulate" } else { "profidrive" };
        format!("{line}; see '{command} --help'")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_declared_arguments_are_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn a_drive_is_its_address_and_what_differs_from_the_default() {
        let full = |number, model, gear| {
            let address = Address::station(number).unwrap();
            Ok(DriveSpec { address, model, gear })
        };
        for (spec, drive) in [
            ("5", full(5, Model::Ag03_1, Gear::Ratio48)),
            ("0,gear=24", full(0, Model::Ag03_1, Gear::Ratio24)),
            ("126,model=ag03", full(126, Model::Ag03, Gear::Ratio48)),
            ("7,gear=48,model=ag03-1", full(7, Model::Ag03_1, Gear::Ratio48)),
        ] {
            assert_eq!(spec.parse::<DriveSpec>(), drive, "{spec}");
        }
    }

    #[test]
    fn a_wrong_drive_is_answered_with_the_wrong_part() {
        for (spec, part) in [
            ("", "'' is no address; expected ADDRESS"),
            ("+5", "'+5' is no address"),
            ("x,gear=24", "'x' is no address"),
            ("127", "address 127 is outside 0 to 126"),
            ("99999999999999999999", "is outside 0 to 126"),
            ("5,", "'' is not understood; expected ADDRESS"),
            ("5,gear", "'gear' is not understood"),
            ("5,gear=36", "gear '36' is unknown; expected 24 or 48"),
            ("5,model=ag04", "model 'ag04' is unknown; expected ag03 or ag03-1"),
            ("5,color=red", "'color' is unknown"),
            ("5,gear=24,gear=48", "'gear' is given twice"),
            ("5,gear=24,gear=24", "'gear' is given twice"),
        ] {
            let error = spec.parse::<DriveSpec>().unwrap_err();
            assert!(error.contains(part), "{spec}: {error}");
        }
    }

    #[test]
    fn a_range_is_its_bounds_and_what_its_drives_share() {
        let range: RangeSpec = "1-125,model=ag03,gear=24".parse().unwrap();
        let drives: Vec<_> = range.drives().collect();
        assert_eq!(drives.len(), 125);
        assert_eq!(drives[0].to_string(), "SIKO AG03, gear 24:1, at address 1");
        assert_eq!(drives[124].to_string(), "SIKO AG03, gear 24:1, at address 125");
        assert_eq!("7-7".parse::<RangeSpec>().unwrap().drives().count(), 1);
        for (spec, part) in [
            ("5", "'5' is no range of addresses; expected FIRST-LAST"),
            ("", "'' is no range"),
            ("5-", "'' is no address; expected FIRST-LAST"),
            ("-5", "'' is no address"),
            ("1-2-3", "'2-3' is no address"),
            ("6-5", "the range 6-5 is empty"),
            ("1-127", "address 127 is outside 0 to 126"),
            ("1-2,gear=36", "gear '36' is unknown"),
            ("1-2,color=red", "'color' is unknown; expected FIRST-LAST"),
        ] {
            let error = spec.parse::<RangeSpec>().unwrap_err();
            assert!(error.contains(part), "{spec}: {error}");
        }
    }

    #[test]
    fn drives_and_ranges_add_up_and_must_not_overlap() {
        let numbers = |arguments: &[&str]| {
            let arguments = ["profidrive", "emulate"].iter().chain(arguments).map(OsString::from);
            let args = Args::from_arguments(arguments).map_err(|refusal| refusal.0.to_string())?;
            let Command::Emulate(emulate) = args.command else { panic!("not emulate") };
            Ok(emulate.drives().map(|drive| drive.address.number()).collect::<Vec<_>>())
        };
        let all = numbers(&["--drives", "3-5", "--drive", "9", "--drives", "1-1"]);
        assert_eq!(all, Ok::<_, String>(vec![9, 3, 4, 5, 1]));
        assert_eq!(numbers(&["--drives", "1-2"]), Ok(vec![1, 2]), "no default beside them");
        assert_eq!(numbers(&[]), Ok(vec![5]));
        for overlap in [&["--drives", "1-5", "--drive", "3"], &["--drives", "1-5", "--drives", "5-9"]] {
            let error = numbers(overlap).unwrap_err();
            assert!(error.contains("two drives have address"), "{error}");
        }
    }

    #[test]
    fn a_link_is_named_by_its_kind_and_place() {
        assert_eq!("pty".parse(), Ok(LinkSpec::Pty(None)));
        assert_eq!("pty:/tmp/a:b".parse(), Ok(LinkSpec::Pty(Some("/tmp/a:b".into()))));
        assert_eq!("serial:/dev/ttyUSB0".parse(), Ok(LinkSpec::Serial("/dev/ttyUSB0".into())));
        assert_eq!("tcp:localhost:0".parse(), Ok(LinkSpec::Tcp("localhost:0".into())));
        assert_eq!("tcp:[::1]:5050".parse(), Ok(LinkSpec::Tcp("[::1]:5050".into())));
        for wrong in [
            "",
            "pty:",
            "serial",
            "serial:",
            "tcp",
            "tcp:",
            "tcp:5050",
            "tcp::5050",
            "tcp:a:b",
            "tcp:::1:5",
            "usb",
            "pty:a\nb",
            "PTY",
        ] {
            assert!(wrong.parse::<LinkSpec>().unwrap_err().contains("pty:PATH"), "{wrong}");
        }
    }

    #[test]
    fn a_quirk_is_one_of_the_table() {
        assert!("off1=brake".parse::<QuirkSpec>().is_ok());
        for (wrong, part) in [
            ("off1", "expected NAME=VALUE"),
            ("off2=brake", "expected one of i-gain, "),
            ("off1=x", "quirk off1 cannot be 'x'; expected release or brake"),
        ] {
            let error = wrong.parse::<QuirkSpec>().unwrap_err();
            assert!(error.contains(part), "{wrong}: {error}");
        }
        for quirk in QUIRKS {
            assert!(quirks_help().contains(&format!("\n  {}={}", quirk.name, quirk.values.join("|"))));
        }
    }

    #[test]
    fn a_rate_is_one_of_the_ten_or_auto() {
        assert_eq!("auto".parse(), Ok(BaudSpec::Auto));
        assert_eq!("45450".parse(), Ok(BaudSpec::Fixed(BaudRate::K45_45)));
        for wrong in ["", "115200", "-1", "500k", "Auto"] {
            assert!(wrong.parse::<BaudSpec>().unwrap_err().contains("12000000"), "{wrong}");
        }
    }
}
