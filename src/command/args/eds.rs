//! `profidrive eds`: of which device, or which file, in which form.

use std::path::PathBuf;

use crate::host::can::Product;

use super::examples;
use super::spec::{Offered, device, offered_device};

/// Prints the electronic data sheet (EDS, CiA 306) of a CANopen device, or explains a file: EDS, DCF, XDD or XDC
///
/// That of a device is for the configuration tool of a master. It is made from the same tables as the answers of the
/// emulated device. Defaults are those of the unconfigured device; $NODEID stands where they depend on the node number.
#[derive(Debug, clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    arg_required_else_help = true,
    after_help = examples("Examples:\n  profidrive eds {node.3} > {node.3}.eds\n  profidrive eds {node.2}\n  profidrive eds pump.eds\n  \
                           profidrive eds --objects pump.eds\n  profidrive eds --json pump.dcf\n  profidrive eds pump.xdd\n  profidrive eds check pump.eds")
)]
pub(crate) struct Eds {
    /// The device by its name, or a file (.eds, .dcf, .xdd, .xdc); an unknown name is answered with the list of all devices
    #[arg(value_name = "DEVICE|FILE", required = true, value_parser = offered_sheet(), hide_possible_values = true)]
    pub(crate) of: Option<Sheet>,

    /// List every object of the file
    #[arg(long, conflicts_with = "json")]
    pub(crate) objects: bool,

    /// One JSON object, of a file
    #[arg(long)]
    pub(crate) json: bool,

    #[command(subcommand)]
    pub(crate) check: Option<CheckFile>,
}

/// A device or a file.
#[derive(Clone, Debug)]
pub(crate) enum Sheet {
    /// Its EDS is printed.
    Device(&'static Product),
    /// It is explained.
    File(PathBuf),
}

#[derive(Debug, clap::Subcommand)]
pub(crate) enum CheckFile {
    /// For authors of device files (EDS, DCF, XDD, XDC): says what is wrong or unusual, with line and column; exit code 1 if there is anything
    #[command(after_help = "Example:\n  profidrive eds check pump.eds")]
    Check {
        /// The file
        file: PathBuf,
    },
}

fn offered_sheet() -> Offered<Sheet> {
    Offered { read: sheet, offers: offered_device().offers }
}

/// A word with a dot or a slash, or of a file that is there, is a file.
fn sheet(text: &str) -> Result<Sheet, String> {
    match device(text) {
        Ok(product) => Ok(Sheet::Device(product)),
        Err(_) if text.contains(['.', '/', '\\']) || PathBuf::from(text).exists() => {
            Ok(Sheet::File(text.into()))
        }
        Err(unknown) => Err(unknown),
    }
}
