//! `profidrive encode`: which words or telegram.

use crate::explain::Mode;
use clap::{Subcommand, ValueEnum};

use super::decode::modes;

/// Builds words and telegrams from names of states, bits and parameters, and explains them field by field
///
/// What a drive of 'emulate --drive' would refuse or ignore is not built; the reason is printed instead. --force builds it: for other devices, and
/// for tests with mistakes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES, subcommand_required = true)]
pub(crate) struct Encode {
    #[command(subcommand)]
    pub(crate) what: What,

    /// Build it although it is a mistake, or not for such a drive
    #[arg(long, global = true, display_order = 90)]
    pub(crate) force: bool,

    /// Print one JSON object: words, octets and the fields of 'decode --json'
    #[arg(long, global = true, display_order = 91)]
    pub(crate) json: bool,

    /// Print the octets only
    #[arg(long, global = true, display_order = 92, conflicts_with = "json")]
    pub(crate) octets: bool,

    /// The operating mode, which decides what the bits mean
    #[arg(long, global = true, value_name = "MODE", default_value = "positioning", value_parser = modes(), display_order = 93)]
    pub(crate) mode: Mode,
}

#[derive(Debug, Subcommand)]
pub(crate) enum What {
    /// The four words of the parameter channel, as master or as drive
    #[command(subcommand, after_help = PKW_EXAMPLES)]
    Pkw(Pkw),
    /// A control word from names of states and bits; with a setpoint, the whole PZD
    #[command(after_help = STW_EXAMPLES)]
    Stw(Word),
    /// A status word from names of states and bits; with an actual value, the whole PZD
    #[command(after_help = ZSW_EXAMPLES)]
    Zsw(Word),
    /// A telegram of PROFIBUS
    #[command(after_help = TELEGRAM_EXAMPLES, subcommand_required = true)]
    Telegram(Telegram),
}

/// Which job or reply.
#[derive(Debug, Subcommand)]
pub(crate) enum Pkw {
    /// No job, no reply: four zero words
    #[command(after_help = "Example:\n  profidrive encode pkw none")]
    None,
    /// Job 1, of an array element 6: read a value
    #[command(
        after_help = "Examples:\n  profidrive encode pkw read 1018\n  profidrive encode pkw read 945.3"
    )]
    Read {
        #[command(flatten)]
        parameter: Parameter,
    },
    /// Job 2 (word) or 3 (double word), of an array element 7 or 8: write a value
    #[command(
        after_help = "Examples:\n  profidrive encode pkw write limit1 250000\n  profidrive encode pkw write limit2 -1000000"
    )]
    Write {
        #[command(flatten)]
        parameter: Parameter,
        /// The value in the unit of the drive, decimal or 0x..
        #[arg(allow_negative_numbers = true, value_parser = number)]
        value: i64,
        #[command(flatten)]
        width: Width,
    },
    /// Job 9: read how many elements an array has
    #[command(after_help = "Example:\n  profidrive encode pkw count 945")]
    Count {
        #[command(flatten)]
        parameter: Parameter,
    },
    /// Any job or reply identification with any words
    #[command(after_help = "Example:\n  profidrive encode pkw raw 3 limit1 0x3D090")]
    Raw {
        /// AK, 0 to 15
        #[arg(value_parser = clap::value_parser!(u8).range(0..=15))]
        ak: u8,
        #[command(flatten)]
        parameter: Parameter,
        /// PWE, decimal or 0x..
        #[arg(allow_negative_numbers = true, value_parser = number, default_value = "0")]
        value: i64,
        /// Set bit 11, SPM
        #[arg(long)]
        spm: bool,
    },
    /// A drive's reply 1 (word) or 2 (double word), of an array element 4 or 5
    #[command(after_help = "Example:\n  profidrive encode pkw reply limit1 250000")]
    Reply {
        #[command(flatten)]
        parameter: Parameter,
        /// The value in the unit of the drive, decimal or 0x..
        #[arg(allow_negative_numbers = true, value_parser = number)]
        value: i64,
        #[command(flatten)]
        width: Width,
    },
    /// A drive's reply 6: how many elements an array has
    #[command(after_help = "Example:\n  profidrive encode pkw reply-count 945 10")]
    ReplyCount {
        #[command(flatten)]
        parameter: Parameter,
        /// How many
        count: u16,
    },
    /// A drive's reply 7: the job is not executed
    #[command(after_help = "Example:\n  profidrive encode pkw refuse a-Pos 2")]
    Refuse {
        #[command(flatten)]
        parameter: Parameter,
        /// The error number, 0 to 19 in the manual
        error: u16,
    },
}

/// A parameter, as text: what it means is decided where --force is known.
#[derive(Debug, clap::Args)]
pub(crate) struct Parameter {
    /// Number or name, of an array element with its number behind a dot: 1018, limit1, 945.3
    #[arg(value_name = "PARAMETER")]
    pub(crate) text: String,

    /// The octet of IND with the sub-index
    #[arg(long, value_name = "OCTET", default_value = "high")]
    pub(crate) ind: Octet,
}

/// An octet of a word.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum Octet {
    /// The high octet, as in PROFIDRIVE version 2
    High,
    /// The low octet, as in some drives and masters
    Low,
}

#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct Width {
    /// Another width than the parameter has
    #[arg(long = "width", value_name = "WIDTH")]
    pub(crate) given: Option<WidthSpec>,
}

/// How wide a value is.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum WidthSpec {
    /// 16 bits
    Word,
    /// 32 bits
    Double,
}

/// A word of bits.
#[derive(Debug, clap::Args)]
pub(crate) struct Word {
    /// States, bits and words, one after the other
    #[arg(value_name = "STATE|BIT=0|BIT=1|HEX", required = true)]
    pub(crate) terms: Vec<String>,

    /// Setpoint or actual value: the two words behind it
    #[arg(long, value_name = "N", allow_negative_numbers = true, alias = "setpoint")]
    pub(crate) value: Option<i32>,
}

/// A telegram and who sends it to whom.
#[derive(Debug, clap::Args)]
pub(crate) struct Telegram {
    #[command(subcommand)]
    pub(crate) service: Service,

    /// Address of the slave, 0 to 127 (127: all)
    #[arg(long, global = true, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u8).range(0..=127), display_order = 80)]
    pub(crate) address: u8,

    /// Address of the master, 0 to 127
    #[arg(long, global = true, value_name = "N", default_value = "2", value_parser = clap::value_parser!(u8).range(0..=127), display_order = 81)]
    pub(crate) master: u8,

    /// The frame count bit of a request with a reply: first (FCV = 0, FCB = 1), 0, 1, or none
    #[arg(long, global = true, value_name = "FCB", default_value = "first", display_order = 82)]
    pub(crate) fcb: Fcb,

    /// Low priority instead of high
    #[arg(long, global = true, display_order = 83)]
    pub(crate) low: bool,

    /// As SD3, which holds 8 octets, SAPs included
    #[arg(long, global = true, display_order = 84)]
    pub(crate) sd3: bool,

    /// Another frame check sequence, for a telegram that is wrong on purpose
    #[arg(long, global = true, value_name = "HEX", value_parser = octet, display_order = 85)]
    pub(crate) fcs: Option<u8>,
}

/// The frame count bit of a request.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum Fcb {
    /// The first request to a station: FCV = 0, FCB = 1
    First,
    /// FCV = 1, FCB = 0
    #[value(name = "0")]
    Zero,
    /// FCV = 1, FCB = 1
    #[value(name = "1")]
    One,
    /// FCV = 0, FCB = 0
    None,
}

/// What a telegram is for.
#[derive(Debug, Subcommand)]
pub(crate) enum Service {
    /// FDL status request
    #[command(after_help = "Example:\n  profidrive encode telegram fdl-status --address 5")]
    FdlStatus,
    /// Slave_Diag request
    #[command(after_help = "Example:\n  profidrive encode telegram diag --address 5")]
    Diag,
    /// Set_Prm: lock the slave, watchdog, min T_SDR
    #[command(
        after_help = "Examples:\n  profidrive encode telegram set-prm --watchdog 1000 --groups 1,4 --fcb 0\n  profidrive encode telegram set-prm --ident 1234 --force"
    )]
    SetPrm {
        /// Ident_Number
        #[arg(long, value_name = "HEX", default_value = "0AC5", value_parser = word)]
        ident: u16,
        /// Watchdog time in ms, 10 to 650250, or 0: off. Rounded up to a time that the two factors can give
        #[arg(long, value_name = "MS", default_value = "200")]
        watchdog: u32,
        /// min T_SDR in bit times
        #[arg(long, value_name = "BITS", default_value = "11")]
        min_tsdr: u8,
        /// Group_Ident: groups 1 to 8
        #[arg(long, value_delimiter = ',', value_name = "GROUPS", value_parser = clap::value_parser!(u8).range(1..=8))]
        groups: Vec<u8>,
        /// Unlock_Req: other masters may take the slave
        #[arg(long)]
        unlock: bool,
        /// No Lock_Req: min T_SDR only
        #[arg(long)]
        no_lock: bool,
        /// Sync_Req
        #[arg(long)]
        sync: bool,
        /// Freeze_Req
        #[arg(long)]
        freeze: bool,
        /// User_Prm_Data
        #[arg(value_name = "HEX")]
        user: Vec<String>,
    },
    /// Chk_Cfg: check the configuration
    #[command(
        after_help = "Examples:\n  profidrive encode telegram chk-cfg\n  profidrive encode telegram chk-cfg F3 F1 --force"
    )]
    ChkCfg {
        /// Configuration identifiers; F3 F2 if none are given
        #[arg(value_name = "HEX")]
        identifiers: Vec<String>,
    },
    /// Get_Cfg: read the configuration
    #[command(after_help = "Example:\n  profidrive encode telegram get-cfg --address 5")]
    GetCfg,
    /// Data_Exchange: send outputs, get inputs
    #[command(
        after_help = "Examples:\n  profidrive encode telegram data-exchange --pkw '13FA 0000 0000 0000' --stw enable --setpoint 5000\n  profidrive encode telegram data-exchange --stw enable,start=1 --setpoint -5000 --octets"
    )]
    DataExchange {
        /// All octets of the outputs, in place of the words
        #[arg(value_name = "HEX", conflicts_with_all = ["pkw", "stw", "setpoint"])]
        data: Vec<String>,
        /// The four words of the parameter channel in hexadecimal
        #[arg(long, value_name = "WORDS")]
        pkw: Option<String>,
        /// The control word: names and bits as for 'encode stw', separated by commas
        #[arg(long, value_name = "TERMS", value_delimiter = ',')]
        stw: Vec<String>,
        /// The setpoint
        #[arg(long, value_name = "N", allow_negative_numbers = true, default_value = "0")]
        setpoint: i32,
    },
    /// Global_Control: a command to many slaves, without reply
    #[command(
        after_help = "Examples:\n  profidrive encode telegram global-control clear --address 127\n  profidrive encode telegram global-control sync --groups 1,4 --address 127"
    )]
    GlobalControl {
        /// The commands; without any: the master is in Operate
        commands: Vec<Control>,
        /// Group_Select: groups 1 to 8; all slaves without it
        #[arg(long, value_delimiter = ',', value_name = "GROUPS", value_parser = clap::value_parser!(u8).range(1..=8))]
        groups: Vec<u8>,
    },
    /// RD_Inp: read the inputs
    #[command(after_help = "Example:\n  profidrive encode telegram rd-inp --address 5")]
    RdInp,
    /// RD_Outp: read the outputs
    #[command(after_help = "Example:\n  profidrive encode telegram rd-outp --address 5")]
    RdOutp,
    /// Set_Slave_Add: give the slave another address
    #[command(
        after_help = "Example:\n  profidrive encode telegram set-slave-add 7 --address 126 --ident 1234 --force"
    )]
    SetSlaveAdd {
        /// The new address
        new: u8,
        /// Ident_Number of the slave
        #[arg(long, value_name = "HEX", default_value = "0AC5", value_parser = word)]
        ident: u16,
        /// No_Add_Chg: the address cannot be changed again
        #[arg(long)]
        no_change: bool,
    },
    /// The token, from --master to --address
    #[command(after_help = "Example:\n  profidrive encode telegram token --address 3 --master 2")]
    Token,
    /// SC, one octet
    #[command(after_help = "Example:\n  profidrive encode telegram short-acknowledge --octets")]
    ShortAcknowledge,
    /// Any function code, SAPs and data; without --fc a slave's answer (DL)
    #[command(
        after_help = "Examples:\n  profidrive encode telegram raw --fc 03 --address 2 --master 5\n  profidrive encode telegram raw --fc 6D --dsap 60 --ssap 62"
    )]
    Raw {
        /// FC
        #[arg(long, value_name = "HEX", value_parser = octet, default_value = "08")]
        fc: u8,
        /// DSAP, 0 to 63
        #[arg(long, value_name = "SAP", value_parser = clap::value_parser!(u8).range(0..=63))]
        dsap: Option<u8>,
        /// SSAP, 0 to 63
        #[arg(long, value_name = "SAP", value_parser = clap::value_parser!(u8).range(0..=63))]
        ssap: Option<u8>,
        /// The data
        #[arg(value_name = "HEX")]
        data: Vec<String>,
    },
}

/// A command of Global_Control.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum Control {
    /// Outputs to zero
    Clear,
    /// End Freeze
    Unfreeze,
    /// Hold the inputs
    Freeze,
    /// End Sync
    Unsync,
    /// Hold the outputs
    Sync,
}

fn number(text: &str) -> Result<i64, String> {
    let parsed = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => i64::from_str_radix(digits, 16),
        None => text.parse(),
    };
    parsed.map_err(|_| "expected a whole number, decimal or 0x..".into())
}

fn octet(text: &str) -> Result<u8, String> {
    u8::from_str_radix(text.trim_start_matches("0x"), 16)
        .map_err(|_| "expected two hexadecimal digits".into())
}

fn word(text: &str) -> Result<u16, String> {
    u16::from_str_radix(text.trim_start_matches("0x"), 16)
        .map_err(|_| "expected four hexadecimal digits".into())
}

const EXAMPLES: &str = "\
Exit codes: 0 built, 2 the command line is wrong or asks for a mistake without --force, 1 the output cannot be written.

Examples:
  profidrive encode pkw read 1018
  profidrive encode pkw write limit1 250000
  profidrive encode stw enable
  profidrive encode telegram diag --address 5
  profidrive encode telegram data-exchange --stw enable,start=1 --setpoint 5000 --octets";

const PKW_EXAMPLES: &str = "\
Examples:
  profidrive encode pkw read 'calibration value'
  profidrive encode pkw write limit2 -1000000
  profidrive encode pkw read 945.3
  profidrive encode pkw write 1000 100 --width double --force
  profidrive encode pkw refuse a-Pos 2";

const STW_EXAMPLES: &str = "\
States: off 0000, enable 000B, prepare 003B, start 007B, pause 005B, resume 007B, stop 006B, disable 0003, off1 000A,
off2 0009, acknowledge 008B, inch1 010B, jog+ 020B, jog- 820B; in velocity mode run 004B, stop 000B.
Bits: on, no-off2, off3, enable-operation, no-stop, no-intermediate-stop, start, acknowledge, inch1, inch2,
inch2-negative, or their numbers. A bit changes the word that the terms before it give; a state or a word replaces it.

Examples:
  profidrive encode stw enable
  profidrive encode stw prepare start=1 --value 5000
  profidrive encode stw 003B no-intermediate-stop=0
  profidrive encode stw --mode velocity run --value -72";

const ZSW_EXAMPLES: &str = "\
States: ready-to-run 2B33, ready-to-travel AB37, travelling 0B37, arrived AF37, fault 2B3B, turn-on-disabled 2B73; in
velocity mode ready-to-run 3E33, ready-to-travel BE37, travelling 1E37, fault 3E3B, turn-on-disabled 3E73.
Bits: their names in 'decode --json', or their numbers.

Examples:
  profidrive encode zsw ready-to-travel --value 42
  profidrive encode zsw travelling job-toggle=1";

const TELEGRAM_EXAMPLES: &str = "\
Examples:
  profidrive encode telegram fdl-status --address 5
  profidrive encode telegram set-prm --watchdog 1000 --groups 1,4 --fcb 0
  profidrive encode telegram chk-cfg F3 F2 --fcb 1
  profidrive encode telegram data-exchange --pkw '13FA 0000 0000 0000' --stw enable --setpoint 5000
  profidrive encode telegram global-control clear --address 127
  profidrive encode telegram raw --fc 03 --address 2 --master 5
  profidrive encode telegram diag --fcs 00 --force";
