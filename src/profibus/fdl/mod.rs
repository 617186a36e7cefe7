//! Layer 1, FDL: octets to telegrams and back, and the passive station that answers them.
//!
//! The five telegrams of PROFIBUS (`dp-v0.md` 2; DIN 19245 part 1 / EN 50170 part 4, read at second hand):
//!
//! ```text
//! SD1  10 DA SA FC FCS 16                      no data
//! SD2  68 LE LEr 68 DA SA FC data.. FCS 16     LE = octets from DA to the last data octet, 4..=249
//! SD3  A2 DA SA FC d0 .. d7 FCS 16             exactly 8 data octets
//! SD4  DC DA SA                                token
//! SC   E5                                      short acknowledge
//!
//! DA, SA   b7 = an extension octet (SAP) follows in the data, DA's first; b6..b0 = station 0..=126, 127 = all
//! FCS      sum of the octets from DA to the last data octet, modulo 256
//! ```
//!
//! [`telegram::decode`] and [`telegram::DataTelegram::encode`] know no state; [`framer::Framer`] cuts a stream of
//! octets into telegrams and decides how to resynchronise; [`station::Station`] keeps what a responder must
//! remember: its address, the frame count bit with the last reply, and when that reply may be sent.
//!
//! This layer knows that service access points exist. What they mean is known in [`dp`](crate::profibus::dp).

pub(crate) mod address;
pub(crate) mod baud_search;
pub mod counters;
mod fcs;
#[cfg(feature = "std")]
pub(crate) mod foreign;
pub(crate) mod framer;
pub(crate) mod function_code;
mod rates;
pub mod station;
pub mod telegram;

pub use address::{Address, AddressError, Sap};
pub(crate) use baud_search::BaudSearch;
pub use baud_search::RateChange;
pub use counters::{LineCounters, StationCounters};
pub use framer::{Framer, Resync, Timing};
pub use function_code::{FrameCount, Function, FunctionCode, ReplyStatus, Service, StationType};
pub use rates::Rates;
pub use station::{Reception, Reply, Request, Station};
pub use telegram::{DataTelegram, Decoded, EncodeError, FrameError, MAX_TELEGRAM_LEN, Telegram};
