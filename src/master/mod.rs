//! profirust as DP master over our links, for people who test applications written with it.
//!
//! ```text
//! application ─▶ profirust: dp::DpMaster ─▶ fdl::FdlActiveStation ─▶ LinkPhy ─▶ any host::Link
//! ```
//!
//! - [`LinkPhy`] is profirust's physical layer on a [`Link`](crate::host::Link): a serial port, the terminal of
//!   another process, a line in memory.
//! - [`peripheral`] is an AG03 or AG03/1 as profirust must be told of it, as in `gsd/SIKO0AC5.GSD`.
//! - [`SimulatedBus`] is a whole bus in one process: profirust, emulated drives, and a clock that jumps from one
//!   thing that happens to the next.
//!
//! What profirust 0.6.0 wants, and where it differs from other masters:
//!
//! - It does nothing between two polls, and knows whole microseconds. A telegram that is due goes out with the first
//!   poll after its time.
//! - Its slot time runs anew with every poll that finds more octets than the one before. A reply that is longer
//!   than the slot time has to be seen arriving.
//! - It never sends user parameters unless [`profirust::dp::PeripheralOptions::user_parameters`] is `Some`, an empty
//!   slice for these drives.
//! - It sends every request with the frame count bit and Global_Control (operate) every 50 slot times, and asks one
//!   address after the other whether a master is there, slaves included.
//! - It knows the operating state Operate only.

mod peripheral;
mod phy;
mod simulated_bus;

pub use peripheral::{options, peripheral};
pub use phy::{LinkPhy, baudrate, instant};
pub use simulated_bus::{Heard, Sender, SimulatedBus, TimedOut};
