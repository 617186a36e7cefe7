//! `profidrive eds`: of which device.

use profidrive::host::can::Product;

use super::node::device;

/// Prints the electronic data sheet (EDS, CiA 306) of a CANopen device, for the configuration tool of a master
///
/// It is made of the same tables that the emulated device answers from. Defaults are those of the unconfigured device;
/// where they depend on the node number they say so with $NODEID.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  profidrive eds asda-a2 > asda-a2.eds\n  profidrive eds ap10")]
pub(crate) struct Eds {
    /// The device; a name that is unknown is answered with the list
    #[arg(value_name = "DEVICE", value_parser = device)]
    pub(crate) device: &'static Product,
}
