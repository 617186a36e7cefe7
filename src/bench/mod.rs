//! A test bench for DP masters: a simulated line with stations, faults, a history, and one's own master on it.
//!
//! ```text
//! master under test ──octets──▶ Line ──▶ Faults ──▶ Bus: Device, dp::Station, … (any Participant)
//!   (trait Master)  ◀──octets──      ◀──        ◀──
//!                                 └──▶ history, breaches, pcapng
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `line` | [`Line`]: time, who sends, who hears |
//! | `stations` | what is on the line: [`Line::add`], [`Line::inject`] |
//! | `run` | letting time pass: [`Line::run_until`], [`Line::send`] |
//! | `rules` | the rules of the bus; [`Breach`]: which of them was broken |
//! | `master` | [`Master`]: what a master under test offers |
//! | `port` | [`Port`]: the line as link and clock, for masters that wait by themselves |
//! | `scripted` | [`ScriptedMaster`]: telegram by telegram, by the test itself |
//! | `history` | [`Passed`]: each telegram with its time and sender |
//! | `capture` | [`Line::save`](crate::bench::Line): the history as a pcapng file (feature `capture`) |
//! | `story` | telegrams in words, and assertions that print them |
//!
//! Octets last as long as they do on a wire, at any of the ten rates. Time jumps from one thing that happens to the
//! next, so hours pass in seconds, and the same calls give the same telegrams at the same nanoseconds everywhere.
//! Nothing sleeps.
//!
//! Two ways to send:
//!
//! - A master that implements [`Master`] is on the line by itself: [`Line::with`] puts it there, [`Line::run_until`] lets
//!   it work. profirust is one (`master::Profirust`).
//! - The test sends telegram by telegram: [`Line::send`], [`Line::request`], or a [`ScriptedMaster`]. It may do so beside a
//!   master under test, as another master of the ring.
//!
//! A rule of the bus that somebody breaks is a [`Breach`]: it is kept in [`Line::breaches`] and, where the test sends, it
//! is the error of that call. What a fault on purpose does is no breach.
//!
//! ```
//! use profidrive::bench::Line;
//! use profidrive::devices::ag03::profibus::Config;
//! use profidrive::profibus::fdl::Address;
//! use profidrive::time::BaudRate;
//!
//! let mut line = Line::new(BaudRate::K1500);
//! line.add_drive(Config::new(Address::station(5)?))?;
//! // FDL status of master 2 to station 5.
//! let reply = line.request(&[0x10, 0x05, 0x02, 0x49, 0x50, 0x16])?;
//! assert_eq!(reply, Some(&[0x10, 0x02, 0x05, 0x00, 0x07, 0x16][..]));
//! // The second reply from now on is lost.
//! line.inject(&["no-reply,at=2,station=5".parse()?])?;
//! assert!(line.request(&[0x10, 0x05, 0x02, 0x49, 0x50, 0x16])?.is_some());
//! assert!(line.request(&[0x10, 0x05, 0x02, 0x49, 0x50, 0x16])?.is_none());
//! println!("{}", line.story(10));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

mod breach;
#[cfg(feature = "capture")]
mod capture;
mod history;
mod line;
mod master;
mod port;
mod rules;
mod run;
mod scripted;
mod stations;
mod story;

pub use breach::Breach;
pub use history::{Damage, Passed, Request, Sender};
pub use line::{Disturbance, Line};
pub use master::{Master, NoMaster};
pub use port::{Attached, Port};
pub use run::TimedOut;
pub use scripted::{Answer, ScriptedMaster};
pub use story::Story;
