//! PROFIBUS DP, from the octets of a line to the words of a drive. Nothing here knows a device.
//!
//! ```text
//!        octets         Telegram         Request          outputs          PKW words
//!  link ────────▶ fdl ───────────▶ fdl ───────────▶ dp ─────────────▶ ppo ─────────────▶ pkw
//!                framer          station          slave                └──▶ STW, setpoints
//!  link ◀──────── fdl ◀─────────────────────────── dp ◀────────────── ppo ◀── reply, ZSW, actual values
//! ```

pub mod fdl;

pub mod dp;

pub mod dpv1;

pub mod ppo;

pub mod pkw;
