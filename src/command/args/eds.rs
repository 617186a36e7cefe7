//! `profidrive eds`: of which device.

use crate::host::can::Product;

use super::spec::offered_device;

/// Prints the electronic data sheet (EDS, CiA 306) of a CANopen device, for the configuration tool of a master
///
/// It is made from the same tables as the answers of the emulated device. Defaults are those of the unconfigured device;
/// $NODEID stands where they depend on the node number.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  profidrive eds asda-a2 > asda-a2.eds\n  profidrive eds ap10")]
pub(crate) struct Eds {
    /// The device, for example asda-a2; an unknown name is answered with the list of all
    #[arg(value_name = "DEVICE", value_parser = offered_device(), hide_possible_values = true)]
    pub(crate) device: &'static Product,
}
