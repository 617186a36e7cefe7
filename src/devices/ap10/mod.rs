//! The position indicator SIKO AP10 without a bus: a battery-buffered encoder with a two-row display, three keys and
//! four LEDs. It drives nothing; it tells a person which way to turn a shaft (manual art. 86853, mod. 37/22).
//!
//! ```text
//! shaft ─▶ encoder ─▶ position ─▶ monitor ─▶ arrows, LEDs, status word
//!                                   ▲  set points and control word of the master
//! keys ──▶ calibration, incremental measurement, acknowledgement, menu
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `settings` | [`Setting`], [`Settings`]: every parameter with default and range |
//! | `shaft` | [`Turns`], the encoder: scaling, sense, calibration, incremental measurement |
//! | `words` | [`ControlBit`], [`StatusBit`]: every bit of both words |
//! | `set_point` | the two set points, validity and acknowledgement |
//! | `monitor` | target windows, loop, the way to turn |
//! | `faults` | [`Fault`], `Battery`: battery and speed |
//! | `keys` | [`Key`], what the keys do |
//! | `menu` | the parameter menu and the diagnosis |
//! | `leds` | [`Leds`] |
//! | `display` | [`Display`]: the two rows with their symbols, as text |
//! | `indicator` | [`Indicator`]: all of it as one object |

pub mod canopen;
mod display;
mod faults;
mod indicator;
mod keys;
mod leds;
mod menu;
mod monitor;
mod set_point;
mod settings;
mod shaft;
mod words;

pub use display::{Arrow, Display, Row};
pub(crate) use faults::Battery;
pub use faults::Fault;
pub use indicator::{Backup, Event, Indicator, Quirks, Restore};
pub use keys::Key;
pub use leds::{Leds, Light};
pub use set_point::Slot;
pub use settings::{Mode, Rule, Setting, Settings};
pub(crate) use shaft::RESOLUTION;
pub use shaft::Turns;
pub use words::{Control, ControlBit, Status, StatusBit};
