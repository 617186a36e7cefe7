//! profirust as DP master over our links, for people who test applications written with it.
//!
//! ```text
//! application ─▶ profirust: dp::DpMaster ─▶ fdl::FdlActiveStation ─▶ LinkPhy ─▶ any host::Link
//! ```
//!
//! - [`LinkPhy`] is profirust's physical layer on a [`Link`](crate::host::Link): a serial port, the terminal of
//!   another process, a line in memory.
//! - [`peripheral()`] is an AG03 or AG03/1 as profirust must know it, as in `gsd/SIKO0AC5.GSD`.
//! - [`Profirust`] is the master of a simulated [`Line`](crate::bench::Line): a whole bus in one process, with emulated
//!   drives, faults on purpose, and a clock that jumps from one thing that happens to the next.
//! - [`Session`] is one drive or several on a line that somebody else serves, for programs that do one thing after the
//!   other; [`Axes`] gives each of them a queue of goals, [`Drive`] reads, saves and restores
//!   the parameters of one. [`Connection`] reads and writes records of any slave of DP-V1, [`Owner`] acknowledges its alarms. [`ProfileDrive`] is the same for any drive of PROFIDRIVE version 2.
//!
//! What profirust 0.6.0 wants, and where it differs from other masters:
//!
//! - It does nothing between two polls, and knows whole microseconds. A telegram that is due goes out with the first
//!   poll after its time.
//! - Its slot time runs anew with every poll that finds more octets than the one before. A reply that is longer
//!   than the slot time has to be seen arriving.
//! - It never sends user parameters unless [`profirust::dp::PeripheralOptions::user_parameters`] is `Some`, an empty
//!   slice for these drives.
//! - It sends Global_Control (operate) every 50 slot times.
//! - After each cycle it asks one address whether a station is there, slaves included. As the only master it never
//!   stops doing so, whatever its GAP factor, and waits a slot time for each absent station: with a long slot time
//!   that is what a cycle takes.
//! - The first frame count goes to a station once per process. It is not begun anew when a slave was gone.
//! - After a refused Set_Prm it sends Chk_Cfg all the same, and takes a slave that refuses it for gone: look at the
//!   diagnosis for the parameter fault.
//! - It knows the operating state Operate only.

mod acyclic;
mod axes;
mod drive;
mod error;
#[cfg(feature = "emulator")]
pub(crate) mod inner;
mod inquiry;
mod owner;
mod parameters;
mod peripheral;
mod phy;
mod profile_drive;
mod session;
mod simulated;

pub use acyclic::{Connection, RecordError};
pub use axes::Axes;
pub use drive::{Drive, DriveError, Identity, Reached, Seen};
pub use error::SessionError;
pub use owner::{OwnedSlave, Owner, Reported};
pub use parameters::{Change, Restored, WriteOutcome, changes};
pub use peripheral::{Slave, options, peripheral};
pub use phy::{LinkPhy, baudrate, instant};
pub use profile_drive::{ProfileDrive, ProfileReached, Values};
pub use session::{Session, Settings};
pub use simulated::Profirust;
