//! `profidrive master`: which drive, and what is asked of it.

mod values;

use core::time::Duration;
use std::path::PathBuf;

use crate::can_bus::canopen::NodeId;
use crate::profibus::fdl::Address;
use crate::profibus::ppo::PpoType;
use clap::Subcommand;

use super::link::BaudSpec;
use super::master_link::{CanPlace, MasterLink};
use super::quantity::Quantity;
use super::records::{ParamAction, RecordAction};
use super::spec::{ident, ppo, product_names};
pub(crate) use values::{AddressRange, Asked, Direction};
use values::{master, node, rate, rpm, slot_time, station, time, watchdog};

/// Commissions a drive, real or emulated: parameters, status, faults, motion
///
/// Joins the line as a DP master, does one thing, and then unlocks the drive for other masters. The DP watchdog of the drive
/// runs meanwhile: if this master is killed or loses the line, the drive releases its motor.
///
/// On CANopen (--link slcan-..., --node) it reads and writes entries of the object dictionary, shows the status and what keeps the
/// drive from moving, acknowledges faults, and travels and homes by the state machine of CiA 402; node guarding is used in place of the watchdog.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES, subcommand_required = true)]
pub(crate) struct Master {
    /// The line: what 'profidrive emulate' prints as link= (/dev/pts/N, pty:PATH, tcp:HOST:PORT), or serial:DEVICE; of CANopen
    /// (with --node) also slcan-tty:PATH (a terminal or a USB adapter), slcan-tcp:HOST:PORT or socketcan:INTERFACE
    #[arg(long, global = true, value_name = "LINK", display_order = 90)]
    pub(crate) link: Option<MasterLink>,

    /// The address of the drive, 0 to 126
    #[arg(long, global = true, value_name = "N", value_parser = station, display_order = 91)]
    pub(crate) address: Option<Address>,

    /// The number of the drive on CANopen, 1 to 127
    #[arg(long, global = true, value_name = "N", value_parser = node, display_order = 91)]
    pub(crate) node: Option<NodeId>,

    #[arg(
        long, global = true, value_name = "FILE", display_order = 91,
        help = format!(
            "The EDS, DCF, XDD or XDC of the node: names, types, limits and bits of its objects. Without it those of {} are known, \
             and of other drives those of CiA 402",
            product_names()
        )
    )]
    pub(crate) eds: Option<PathBuf>,

    /// The drive is one of PROFIDRIVE version 2 with this PPO, 1 to 5: read, write, params, status, monitor, faults, ack, enable,
    /// velocity, stop
    #[arg(long, global = true, value_name = "1..5", value_parser = ppo, display_order = 92)]
    pub(crate) ppo: Option<PpoType>,

    /// The device file of the drive with --ppo; without it the customary configuration of the PPO. That of the slave for alarms
    #[arg(long, global = true, value_name = "FILE", display_order = 92)]
    pub(crate) gsd: Option<PathBuf>,

    /// The ident number of the drive with --ppo and without --gsd, four hexadecimal digits; 5044 unless given
    #[arg(long, global = true, value_name = "HEX", value_parser = ident, display_order = 92)]
    pub(crate) ident: Option<u16>,

    /// The table of parameters of the drive with --ppo, .toml or .csv: names, units, widths
    #[arg(long, global = true, value_name = "FILE", display_order = 92)]
    pub(crate) parameters: Option<PathBuf>,

    /// The speed of 100 % (setpoint 4000h) of the drive with --ppo in rpm, unless its table has a parameter tied to
    /// reference-speed
    #[arg(long, global = true, value_name = "RPM", display_order = 92, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) reference_speed: Option<u16>,

    /// The rate of the line in bit/s: of a serial line it must be given, elsewhere it is 500000
    #[arg(long, global = true, value_name = "RATE", value_parser = rate, display_order = 92)]
    pub(crate) baud: Option<BaudSpec>,

    /// The address of this master, 0 to 125: none that another master on the line has. It can take half a
    /// minute until other masters pass it the token
    #[arg(long, global = true, value_name = "N", default_value = "0", value_parser = master, display_order = 93)]
    pub(crate) master_address: Address,

    /// DP watchdog time; the drive releases the motor when it expires (10ms to 650s)
    #[arg(long, global = true, value_name = "TIME", default_value = "1s", value_parser = watchdog, display_order = 94)]
    pub(crate) watchdog: Duration,

    /// Slot time: how long the master waits for a reply before it repeats the request, 1ms to 10s. Use a longer time for a slow
    /// network or a busy machine. Without it 20ms on a serial line, else 50ms
    #[arg(long, global = true, value_name = "TIME", value_parser = slot_time, display_order = 95)]
    pub(crate) slot_time: Option<Duration>,

    /// Print JSON for programs instead of text
    #[arg(long, global = true, display_order = 96)]
    pub(crate) json: bool,

    #[command(subcommand)]
    pub(crate) action: Action,
}

const EXAMPLES: &str = "\
Examples, with an emulator started by 'profidrive emulate --link pty:/tmp/bus':
  profidrive master --link /tmp/bus scan
  profidrive master --link /tmp/bus --address 5 params
  profidrive master --link /tmp/bus --address 5 write v-Pos 60
  profidrive master --link /tmp/bus --address 5 move 1600 --yes
  profidrive master --link serial:/dev/ttyUSB0 --baud 19200 --address 5 status
  profidrive master --link slcan-tcp:127.0.0.1:5000 --node 5 read 6041
  profidrive master --link /tmp/bus --address 7 --ppo 1 --parameters drive.toml velocity 750 --for 5s --yes

Exit codes: 0 done, 1 it did not work, 2 the command line is wrong or asks for something that is not possible.
A drive that turns is dangerous. Ctrl-C stops it, but is no emergency stop: use a switch that takes the supply away.";

/// What is asked.
#[derive(Debug, Subcommand)]
pub(crate) enum Action {
    /// Lists the stations on the line: slaves with their ident numbers and owners, other masters
    ///
    /// Asks every address, a second time if there is no answer. It changes nothing. Stations are printed as they are found; Ctrl-C ends
    /// it early. Use a longer --slot-time for a slow network or a busy machine.
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus scan 1-20")]
    Scan {
        /// The addresses, FIRST-LAST
        #[arg(value_name = "RANGE", default_value = "0-126")]
        range: AddressRange,
    },
    /// The diagnosis of the slave, bit by bit in words
    ///
    /// Slave_Diag changes nothing, and works also while another master owns the slave.
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 5 diag")]
    Diag,
    /// Reads or writes a record of a slave of DP-V1, by slot and index
    ///
    /// Over a connection of a master of class 2: whoever owns the slave is not disturbed.
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 7 record read 1 10
  profidrive master --link /tmp/bus --address 7 record write 1 10 01020304")]
    Record {
        #[command(subcommand)]
        action: RecordAction,
    },
    /// Parameters of a drive of PROFIdrive by record 47: values, descriptions, texts; several in one request
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 7 param read 922 964.0-5
  profidrive master --link /tmp/bus --address 7 param write 927=0
  profidrive master --link /tmp/bus --address 7 param describe 930")]
    Param {
        #[command(subcommand)]
        action: ParamAction,
    },
    /// Alarms and status messages of a slave of DP-V1, shown and acknowledged
    ///
    /// As the master of class 1: it takes the slave over with the modules of its device file, outputs of zero and DP-V1 enabled, shows
    /// what comes with the diagnosis, and acknowledges alarms at SAP 51. Ctrl-C ends it and releases the slave.
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 7 --gsd V1.GSD alarms --modules \"8 DI,8 DO\"
  profidrive master --link /tmp/bus --address 7 --gsd V1.GSD alarms --modules io --for 10s --json")]
    Alarms {
        /// The modules of the slave in the order of their slots, by their names in the device file; a compact slave has its own
        #[arg(long, value_name = "NAME,..", default_value = "")]
        modules: String,
        /// Show alarms, do not acknowledge them
        #[arg(long)]
        keep: bool,
        /// End after this time
        #[arg(long = "for", value_name = "TIME", value_parser = time)]
        limit: Option<Duration>,
    },
    /// Identification and maintenance of a slave of DP-V1: order number, serial number, versions
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 7 im")]
    Im {
        /// The block: 0 what the device is, 1 to 4 what its owner wrote
        #[arg(default_value = "0", value_parser = clap::value_parser!(u16).range(..200))]
        block: u16,
        /// The slot, 0: the station
        #[arg(long, default_value = "0", value_name = "N", value_parser = clap::value_parser!(u8).range(..255))]
        slot: u8,
    },
    /// Reads one parameter, on CANopen one entry
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 5 read 1004
  profidrive master --link /tmp/bus --address 5 read v-Pos
  profidrive master --link /tmp/bus --address 5 read 945.0
  profidrive master --link slcan-tcp:127.0.0.1:5000 --node 5 read 2410:05")]
    Read {
        /// Number or name of the parameter, of an array with the element behind a point: 1004, 0x3EC, v-Pos, 945.0. On CANopen
        /// index and sub-index in hexadecimal, or the name of the object or parameter: 2410:05, 6041, Statusword, v-Pos
        #[arg(value_name = "PNU[.SUB]")]
        parameter: Asked,
    },
    /// Writes one parameter and reads it back, on CANopen one entry
    ///
    /// The drive keeps it in its EEPROM.
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 5 write v-Pos 60
  profidrive master --link /tmp/bus --address 5 write limit2 -25.5mm
  profidrive master --link /tmp/bus --address 5 write 970 2 --yes")]
    Write {
        /// Number or name of the parameter: 1004, v-Pos; on CANopen as for read
        #[arg(value_name = "PNU[.SUB]")]
        parameter: Asked,
        /// The number to write, decimal or 0x..., with its unit if you like: 60, 60rpm, 8.25mm, 800inc
        #[arg(allow_hyphen_values = true)]
        value: Quantity,
        #[command(flatten)]
        sure: Sure,
    },
    /// Reads all parameters of the drive
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 5 params --json")]
    Params,
    /// Saves all writable parameters of the drive in a file, with their names and units
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 5 save axis.json")]
    Save {
        /// The file, or - for stdout; a file that is there is replaced, a read-only one refused
        file: PathBuf,
    },
    /// Writes the parameters in a file to the drive: shows what differs, writes that, reads all of it back
    ///
    /// A file that does not fit the drive is refused before anything is written, and one of a drive of another model or gear
    /// without --yes. Settings that are not in the file are named and not changed. Also if it is interrupted, it says what
    /// was written and what was not.
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 5 restore axis.json --dry-run
  profidrive master --link /tmp/bus --address 5 restore axis.json")]
    Restore {
        /// The file that 'save' wrote, or - for stdin
        file: PathBuf,
        /// Show what differs and write nothing
        #[arg(long)]
        dry_run: bool,
        /// Also if the file is of a drive of another model or gear
        #[arg(long, short)]
        yes: bool,
    },
    /// Status word ZSW, system status word SSW and general status register, bit by bit in words
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 5 status")]
    Status,
    #[command(flatten)]
    Motion(Motion),
    /// Connects to the drive, stops it if it turns, and waits until it stands
    ///
    /// Works on a drive without a master, for example one that coasts. A drive that belongs to another master must be
    /// stopped there.
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 5 stop")]
    Stop,
    /// Acknowledges a fault, if its cause is gone, and gives OFF1, which ends turn-on disabled
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 5 ack")]
    Ack,
    /// The fault buffer with what the codes mean, newest first, and the number of faults
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 5 faults
  profidrive master --link /tmp/bus --address 5 faults --clear")]
    Faults {
        /// Clear buffer and counter
        #[arg(long)]
        clear: bool,
    },
    /// Calibrates: the position becomes the calibration value (PNU 1018), which can be given
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 5 calibrate
  profidrive master --link /tmp/bus --address 5 calibrate 0 --yes")]
    Calibrate {
        /// Write this calibration value first: decimal or 0x..., with its unit if you like
        #[arg(allow_hyphen_values = true)]
        value: Option<Quantity>,
        #[command(flatten)]
        sure: Sure,
    },
    /// Shows status and position until Ctrl-C: live on a terminal, else a line for each change
    #[command(after_help = "Example:\n  profidrive master --link /tmp/bus --address 5 monitor --json > log")]
    Monitor {
        /// End after this time
        #[arg(long = "for", value_name = "TIME", value_parser = time)]
        limit: Option<Duration>,
    },
}

/// What lets the shaft turn, or holds it, and must be confirmed.
#[derive(Clone, Copy, Debug, Subcommand)]
pub(crate) enum Motion {
    /// Enables operation and holds it: the motor is in control, nothing moves. Ctrl-C ends it
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 5 enable
  profidrive master --link /tmp/bus --address 5 enable --for 5s --yes")]
    Enable {
        #[command(flatten)]
        go: Go,
        /// End after this time
        #[arg(long = "for", value_name = "TIME", value_parser = time)]
        limit: Option<Duration>,
    },
    /// Travels to a position (positioning mode) and waits until it is reached. Ctrl-C stops the drive
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 5 move 1600
  profidrive master --link /tmp/bus --address 5 move -8.25mm --yes")]
    Move {
        /// The position in increments, or 0.01 mm if a spindle pitch is set; or with its unit: 800inc, 8.25mm
        #[arg(value_name = "POS", allow_hyphen_values = true)]
        position: Quantity,
        #[command(flatten)]
        go: Go,
    },
    /// Searches the home position of a drive on CANopen by its method (6098h), in homing mode. Ctrl-C stops the drive
    ///
    /// The position is 607Ch then. Method, speeds (6099h) and ramp (609Ah) are those in the drive: write them first.
    #[command(after_help = "\
Examples:
  profidrive master --link slcan-tcp:127.0.0.1:5000 --node 7 write 6098 35
  profidrive master --link slcan-tcp:127.0.0.1:5000 --node 7 home --yes")]
    Home {
        #[command(flatten)]
        go: Go,
    },
    /// Turns with v-Inch (positioning mode, inching 2) until Ctrl-C, which stops the drive
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 5 jog + --for 2s
  profidrive master --link /tmp/bus --address 5 jog - --yes")]
    Jog {
        /// + for positive, - for negative
        #[arg(value_name = "+|-", allow_hyphen_values = true)]
        direction: Direction,
        #[command(flatten)]
        go: Go,
        /// End after this time
        #[arg(long = "for", value_name = "TIME", value_parser = time)]
        limit: Option<Duration>,
    },
    /// Turns with a velocity (velocity mode) until Ctrl-C, which stops the drive
    #[command(after_help = "\
Examples:
  profidrive master --link /tmp/bus --address 5 write 930 1
  profidrive master --link /tmp/bus --address 5 velocity -30 --for 10s")]
    Velocity {
        /// Revolutions of the output shaft per minute: 30, -30, 30rpm
        #[arg(value_name = "RPM", allow_negative_numbers = true, value_parser = rpm)]
        rpm: i32,
        #[command(flatten)]
        go: Go,
        /// End after this time
        #[arg(long = "for", value_name = "TIME", value_parser = time)]
        limit: Option<Duration>,
    },
}

/// The permission to move something.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct Go {
    /// Do not ask before the drive moves
    #[arg(long, short)]
    pub(crate) yes: bool,
}

/// The permission to replace what the drive keeps.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct Sure {
    /// Do not ask before a parameter set is loaded (PNU 970) or the drive is calibrated: this cannot be undone
    #[arg(long, short)]
    pub(crate) yes: bool,
}

impl Master {
    /// What no single argument shows.
    pub(super) fn check(&self) -> Result<(), String> {
        let Some(link) = &self.link else {
            return Err(
                "the line is missing; add --link with what 'profidrive emulate' prints as link=".into()
            );
        };
        let of_ppo = [
            (self.gsd.is_some(), "--gsd"),
            (self.ident.is_some(), "--ident"),
            (self.parameters.is_some(), "--parameters"),
            (self.reference_speed.is_some(), "--reference-speed"),
        ];
        let for_alarms = matches!(self.action, Action::Alarms { .. });
        let missing = |(given, option): &(bool, &str)| {
            *given && self.ppo.is_none() && !(for_alarms && *option == "--gsd")
        };
        if for_alarms && self.gsd.is_none() {
            return Err("the master of class 1 needs the device file of the slave; add --gsd FILE".into());
        }
        if let Some((_, option)) = of_ppo.into_iter().find(missing) {
            return Err(format!("{option} is for a drive of PROFIDRIVE version 2; add --ppo with 1 to 5"));
        }
        if self.gsd.is_some() && self.ident.is_some() {
            return Err("the ident number is that of the GSD; leave --ident out".into());
        }
        if self.can_place().is_some() {
            if self.ppo.is_some() {
                return Err("--ppo is for PROFIBUS; leave it out on CANopen".into());
            }
            return self.check_can();
        }
        if self.eds.is_some() {
            return Err("--eds is for a node on CANopen; add --node N".into());
        }
        if self.ppo.is_some() {
            self.check_ppo()?;
        }
        if self.node.is_some() {
            return Err("--node is for CANopen; its links are slcan-tty:PATH, slcan-tcp:HOST:PORT and \
                        socketcan:INTERFACE"
                .into());
        }
        let baud = self.baud.map_or(Ok(()), BaudSpec::check_profibus);
        baud.map_err(|error| error.replace("auto or ", ""))?;
        if let (Action::Read { parameter } | Action::Write { parameter, .. }, None) = (&self.action, self.ppo)
        {
            parameter.parameter()?;
        }
        if let Action::Motion(Motion::Home { .. }) = self.action {
            return Err("home is for drives on CANopen with a homing mode; here there is calibrate".into());
        }
        if matches!(link, MasterLink::Serial(_)) && self.baud.is_none() {
            return Err("a serial line needs its rate; add for example --baud 19200".into());
        }
        if matches!(self.action, Action::Scan { .. }) {
            return Ok(());
        }
        let address = self.drive()?;
        if address == self.master_address {
            return Err(format!("address {address} is that of this master; choose another --master-address"));
        }
        if address.number() == 126 && !matches!(self.action, Action::Diag) {
            return Err(
                "address 126 is for stations that have no address yet: they exchange no data; set the DIP switches"
                    .into(),
            );
        }
        Ok(())
    }

    /// The bus of CAN that is asked for. A bare terminal is one of CAN if a node is named: emulators print it so.
    pub(crate) fn can_place(&self) -> Option<CanPlace> {
        match (&self.link, self.node) {
            (Some(MasterLink::Can(place)), _) => Some(place.clone()),
            (Some(MasterLink::Terminal(path)), Some(_)) => Some(CanPlace::Terminal(path.clone())),
            (Some(MasterLink::Serial(device)), Some(_)) => Some(CanPlace::Terminal(device.into())),
            (Some(MasterLink::Terminal(_) | MasterLink::Serial(_)), None)
            | (Some(MasterLink::Tcp(_)) | None, _) => None,
        }
    }

    /// What a drive of PROFIDRIVE version 2 can be asked, and its line.
    fn check_ppo(&self) -> Result<(), String> {
        let known = matches!(
            self.action,
            Action::Scan { .. }
                | Action::Diag
                | Action::Read { .. }
                | Action::Write { .. }
                | Action::Params
                | Action::Status
                | Action::Monitor { .. }
                | Action::Stop
                | Action::Ack
                | Action::Faults { .. }
                | Action::Motion(Motion::Enable { .. } | Motion::Velocity { .. })
        );
        known.then_some(()).ok_or_else(|| {
            "this is for drives that position; with --ppo there are read, write, params, status, monitor, faults, ack, enable, velocity \
             and stop"
                .into()
        })
    }

    fn check_can(&self) -> Result<(), String> {
        self.can_node()?;
        if self.address.is_some() {
            return Err("--address is for PROFIBUS: a drive on CANopen has a --node".into());
        }
        self.baud.map_or(Ok(()), BaudSpec::check_can)?;
        let known = matches!(
            self.action,
            Action::Read { .. }
                | Action::Write { .. }
                | Action::Status
                | Action::Stop
                | Action::Ack
                | Action::Faults { .. }
                | Action::Motion(Motion::Move { .. } | Motion::Home { .. })
        );
        known.then_some(()).ok_or_else(|| {
            "this is for PROFIBUS; on CANopen there are read, write, status, move, home, stop, ack and faults".into()
        })
    }

    /// The node that is asked for.
    pub(crate) fn can_node(&self) -> Result<NodeId, String> {
        self.node.ok_or_else(|| "the drive is missing; add --node N".into())
    }

    /// The drive that is asked for, of every action but a scan.
    pub(crate) fn drive(&self) -> Result<Address, String> {
        self.address
            .ok_or_else(|| "the drive is missing; add --address N, or search for it with 'scan'".into())
    }
}
