//! `profidrive decode`: what to explain, and how.

use std::ffi::OsString;

use crate::can_bus::canopen::NodeId;
use crate::explain::{MODES, Mode, Sender, Taking};
use crate::host::can::Product;
use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::examples;
use super::spec::{device, offered_device, product_names};

/// Explains telegrams and words of PROFIBUS and frames of CANopen field by field: text, files, streams, captures
///
/// Takes octets in hexadecimal in any usual form: 68 05, 6805, 0x68, \x68, 16#68, W#16#6805, arrays of C, Rust and Python,
/// dumps with offsets (xxd, hexdump -C, od -tx1, tcpdump -X, Wireshark), log lines with a time stamp, comments behind # or
/// //. Or raw octets, or a pcapng capture with link type 257. One telegram in each line, or a stream; a line of 14, 8, 6 or 2
/// octets that is no telegram is taken as PPO, PKW, PZD or one word; the output says as which.
///
/// Frames of CANopen are taken as candump -L or candump write them, as lines of slcan (t6058...), or from a pcapng capture with
/// link type 227. --device and --node say which devices the nodes are: then objects, errors and bits have the names of the
/// device, and what it refuses is a mistake; without them only what CiA 301 and CiA 402 say is used.
///
/// A damaged telegram is shown with the octet and the reason, a mistake with what is wrong. What a stream shows is used for
/// what comes later: which request a reply answers, the operating mode (PNU 930) and the unit of positions (PNU 1012).
#[derive(Debug, clap::Args)]
#[command(after_help = examples(EXAMPLES))]
pub(crate) struct Decode {
    /// Octets in hexadecimal or frames of CAN (an argument with spaces is a line of its own), or one file; - or nothing: stdin
    #[arg(value_name = "HEX|FILE")]
    pub(crate) input: Vec<OsString>,

    /// One JSON object a line for each telegram (docs/decode.md lists the members)
    #[arg(long)]
    pub(crate) json: bool,

    /// One line for each telegram, and its hints
    #[arg(long, conflicts_with = "json")]
    pub(crate) brief: bool,

    /// What lines that are no telegrams are: outputs (of the master: job, STW, setpoint), inputs (of the drive: reply, ZSW,
    /// actual value), words (the sender is found from the bits), telegrams (never words)
    #[arg(long = "as", value_name = "WHAT", default_value = "auto")]
    pub(crate) taking: As,

    /// The operating mode of the drives, which decides what the bits mean. Without it: as read in the telegrams, positioning
    /// mode at the beginning
    #[arg(long, value_name = "MODE", value_parser = modes())]
    pub(crate) mode: Option<Mode>,

    #[arg(long, value_name = "DEVICE", help = format!("Every node on CANopen is this device: {}", product_names()), value_parser = offered_device(), hide_possible_values = true)]
    pub(crate) device: Option<&'static Product>,

    /// This node on CANopen is this device; may be given for each node
    #[arg(long, value_name = "N=DEVICE", value_parser = node_device)]
    pub(crate) node: Vec<(NodeId, &'static Product)>,

    /// Exit code 1 also for mistakes, not only for what is invalid
    #[arg(long)]
    pub(crate) strict: bool,
}

fn node_device(text: &str) -> Result<(NodeId, &'static Product), String> {
    let (node, name) =
        text.split_once('=').ok_or_else(|| examples("expected N=DEVICE, for example 5={node.1}"))?;
    let node = node.parse().ok().and_then(|number| NodeId::new(number).ok());
    Ok((node.ok_or("expected a node number from 1 to 127 before =")?, device(name)?))
}

/// What octets are taken as.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum As {
    /// Telegrams, and words where a line cannot be one
    Auto,
    /// Telegrams only
    Telegrams,
    /// Words; the sender is found from the bits
    Words,
    /// Words of the master
    Outputs,
    /// Words of the drive
    Inputs,
}

impl From<As> for Taking {
    fn from(taking: As) -> Self {
        match taking {
            As::Auto => Self::Auto,
            As::Telegrams => Self::Telegrams,
            As::Words => Self::Words(None),
            As::Outputs => Self::Words(Some(Sender::Master)),
            As::Inputs => Self::Words(Some(Sender::Slave)),
        }
    }
}

/// An operating mode by name.
pub(super) fn modes() -> impl TypedValueParser<Value = Mode> {
    let names = MODES.map(|(name, about, _)| PossibleValue::new(name).help(about));
    let mode = |name: String| MODES.into_iter().find(|row| row.0 == name).map(|row| row.2);
    PossibleValuesParser::new(names).try_map(move |name| mode(name).ok_or("no mode"))
}

const EXAMPLES: &str = "\
In the output, '!' marks a refusal or a fault, X a mistake or what is invalid, ^ a hint.

Exit codes: 0 everything is valid, 1 something is invalid or cannot be read (with --strict: or a mistake), 2 the command
line is wrong. The whole input is explained in each case.

Examples:
  profidrive decode 10 05 02 49 50 16
  profidrive decode 13FA 0000 0000 0000
  profidrive decode --brief bus.pcapng
  profidrive decode --device {node.1} 605#4041600000000000
  profidrive decode --brief --node 5={node.1} --node 7={node.3} candump.log
  profidrive decode --json - < trace.txt
  profidrive decode --as inputs --mode velocity 1E37";
