//! CiA 402, the profile of drives: words, states, transitions and reactions, without a bus and without a device.
//!
//! ```text
//!  6040h ──▶ Controlword ──▶ Command ─┐
//!                                     ├──▶ State::next: (Transition, State) ──▶ what the device does
//!  fault, end of a reaction ──────────┘         │
//!  6041h ◀── Statusword ◀── State::bits ◀───────┘
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `words` | each bit of controlword and statusword, once: its number, and its name by mode |
//! | `state` | states, commands, the table of transitions |
//! | `option` | what 605Ah to 605Eh choose |
//! | `mode` | modes of operation, 6060h |
//! | `axis` | objects of further axes |

pub(crate) mod axis;
pub(crate) mod mode;
pub(crate) mod option;
pub(crate) mod state;
pub(crate) mod words;

pub use mode::Mode;
pub use option::{Disabling, FaultReaction, Halt, QuickStop, Stop};
pub use state::{Command, Event, State, Transition};
pub use words::{Controlword, Statusword};
