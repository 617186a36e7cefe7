//! `profidrive demo`: which story.

use crate::host::can::Product;

use super::examples;
use super::spec::offered_device;

/// Shows a master and a device on a bus in memory: start-up, parameters, motion or display, a fault
///
/// Needs no hardware and takes less than two seconds. Without --device: a DP master and a drive on PROFIBUS. Every
/// telegram of the start-up is shown with its meaning, then the words of the parameter channel, control word and status
/// word, and why the drive refuses what it refuses. Times are those on the bus.
#[derive(Debug, clap::Args)]
#[command(
    after_help = examples("Examples:\n  profidrive demo\n  profidrive demo | less\n  profidrive demo --device {node.2}")
)]
pub(crate) struct Demo {
    /// A CANopen device instead, by its name in `profidrive eds`
    #[arg(long, value_name = "DEVICE", value_parser = offered_device(), hide_possible_values = true)]
    pub(crate) device: Option<&'static Product>,
}
