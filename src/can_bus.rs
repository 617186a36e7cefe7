//! CAN and CANopen, from the bits of a frame to the words of a drive. Nothing here knows a device.
//!
//! ```text
//!        frame           service          entry
//!  link ───────▶ canopen ────────▶ canopen ───────▶ application
//!                 node         SDO, PDO, NMT           └──▶ control word: cia402
//!  link ◀─────── canopen ◀──────────────────────────── application
//! ```

pub mod can;

pub mod canopen;

pub mod cia402;
