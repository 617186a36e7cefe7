//! slcan: the ASCII protocol of Lawicel between a master and its CAN adapter.
//!
//! ```text
//! master ──"t60584000100000000000\r"──▶ Adapter ──Effect::Transmit(frame)──▶ bus
//!        ◀──────────"z\r"─────────────  Adapter
//!        ◀──"t58584300100092010200\r"── Adapter ◀──────────frame──────────── bus
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `adapter` | the adapter's side as a machine: octets in, answers and frames out |
//! | `command` | the lines of a master |
//! | `text` | a frame as a line, both ways |
//!
//! Every line ends with CR (0Dh). The adapter refuses with BEL (07h). LF is ignored and never sent. Hexadecimal digits
//! are read in either case and written in upper case (`canopen-link.md` 11).

pub(crate) mod adapter;
pub(crate) mod command;
pub(crate) mod text;

pub use adapter::{Adapter, Answer, Channel, Effect, Flags, Reaction, Refusal};
pub use command::{BusTiming, Command, CommandError, MAX_COMMAND};
pub use text::{FrameLine, LineError, TimeStamp, parse_frame};

/// The end of every line.
pub const CR: u8 = b'\r';

/// The answer to a line that is refused.
pub const BEL: u8 = 0x07;

/// Ignored: masters that end a line with CR LF are served too.
pub const LF: u8 = b'\n';
