//! The other side of a fieldbus, in software: PROFIBUS-DP slaves and CANopen nodes that real masters run, and judges that
//! say what a master does wrong.
//!
//! Begin with what you want. Each page has a complete program, which every test run compiles and runs:
//!
//! | you want | begin with | then |
//! | --- | --- | --- |
#![cfg_attr(
    all(feature = "master", feature = "serial"),
    doc = "| to move a drive, emulated or real | [`first_drive`] | [`client`], [`master`] |"
)]
#![cfg_attr(
    feature = "std",
    doc = "| a PROFIBUS slave of your own | [`first_slave`] | [`profibus::dp`], [`embedded`] |"
)]
//! | a CANopen node of your own | [`first_node`] | [`can_bus::canopen`] |
#![cfg_attr(
    feature = "judge",
    doc = "| to test a master that you write | [`bench`](mod@bench) | [`judge`](mod@judge) |"
)]
//!
//! The command `profidrive` emulates whole lines, judges masters and commissions drives: `docs/README.md` of the repository.
//!
//! # Layers
//!
//! A layer imports the layers above it in this table, and no other. A bus knows no device. A device without a bus knows no
//! bus; each of its folders `profibus` and `canopen` puts it on one.
//!
//! ```text
//!                     octets         telegram        14 octets                  command
//!  PROFIBUS  link ────────────▶ fdl ──────────▶ dp ────────────▶ ppo ──▶ pkw ──────────────▶ ┐
//!                                                                                            ├─ device
//!  CANopen   link ────────────▶ can ──────────▶ canopen ───────▶ dictionary, cia402 ───────▶ ┘    │
//!                     frame          service         entry                      command          face
//!                                                                                                 │
//!                                                             panel, command, metrics, documents ◀┘
//! ```
//!
//! | module | is | knows |
//! | --- | --- | --- |
//! | [`time`] | instants, bit times, rates | |
//! | [`image`](mod@image) | what a device keeps while it is switched off, as octets | that products have names |
//! | [`profibus::fdl`] | octets to telegrams, the passive station | that service access points exist |
//! | [`profibus::dp`] | the DP-V0 slave and its services | what the service access points mean |
//! | [`profibus::ppo`] | the words of one Data_Exchange | where each word lies |
//! | [`profibus::pkw`] | jobs and replies of the parameter channel | job, reply and error numbers |
//! | [`can_bus::can`] | frames of CAN, bit times, the text of an adapter | that frames have a priority |
//! | [`can_bus::canopen`] | a node of CiA 301: NMT, SDO, PDO, EMCY, error control, EDS | what identifiers mean, object dictionaries |
//! | [`can_bus::cia402`] | states and words of drives on CANopen | which command leads where |
//! | [`face`] | what every device is asked by whoever shows it | inputs, keys, display, faults |
//! | [`devices`] | AG03 and AG03/1, AP10, ASDA-A2, drives of the profile; each alone, then on its buses | everything about one device |
//! | [`embedded`] | a slave at the UART of a microcontroller, for `embedded-io` too | direction pins, deadlines |
//! | [`client`] | the master's side: parameters and control words of a drive, without I/O | PKW, STW and ZSW patterns |
//! | [`process`] | values in inputs and outputs, inputs that move by themselves (feature `std`) | what a machine does |
//! | [`device_file`] | files of devices with what is odd in them (feature `std`) | |
//! | `eds` | files of CANopen nodes (feature `eds`) | CiA 306 |
//! | [`gsd`] | device files, and the slave that one describes (feature `std`) | what a GSD says |
//! | [`explain`] | telegrams, frames and words in words (feature `std`) | what all of the above mean to a person |
//! | [`host`] | links, clock, run loop (feature `std`) | the operating system |
//! | [`bench`](mod@bench) | a simulated line to test masters on (feature `std`) | the rules of the bus |
//! | `judge` | judges a master, a slave or a node row by row (feature `judge`) | what is required of each |
//! | `panel` | HTTP control, live stream and a page (feature `panel`) | what a bench around a bus needs |
//! | `metrics` | what was counted, for Prometheus (feature `metrics`) | OpenMetrics |
//! | `command` | the command `profidrive` (feature `cli`) | arguments, and what a person wants |
//!
//! Everything above [`process`] is `no_std`, allocates nothing, and never panics whatever octets it is given.
//!
//! # The loop
//!
//! A [`Device`](devices::ag03::profibus::Device) takes octets and time and gives octets, events and a deadline. **After every `handle_*`,
//! drain `poll_transmit` and `poll_event` to `None`, then wait until octets arrive or `poll_timeout` has come.**
//!
//! ```
//! use profidrive::devices::ag03::profibus::{Config, Device, MAX_TELEGRAM_LEN};
//! use profidrive::profibus::fdl::Address;
//! use profidrive::time::Instant;
//!
//! // A line with one master on it that asks station 5 whether it is there.
//! let mut from_master = Vec::from([0x10, 0x05, 0x02, 0x49, 0x50, 0x16]);
//! let mut to_master = Vec::new();
//!
//! let mut now = Instant::ZERO;
//! let mut device = Device::new(Config::new(Address::station(5)?), now);
//! let mut telegram = [0; MAX_TELEGRAM_LEN];
//! loop {
//!     // 1. Octets, if some have come, else time.
//!     if from_master.is_empty() {
//!         device.handle_timeout(now);
//!     } else {
//!         device.handle_bytes(now, &std::mem::take(&mut from_master));
//!     }
//!     // 2. Drain.
//!     while let Some(octets) = device.poll_transmit(now, &mut telegram) {
//!         to_master.extend_from_slice(octets);
//!     }
//!     while let Some(event) = device.poll_event() {
//!         println!("{now}: {event}");
//!     }
//!     if !to_master.is_empty() {
//!         break;
//!     }
//!     // 3. Sleep. This clock is ours, so sleeping is setting it.
//!     if let Some(deadline) = device.poll_timeout() {
//!         now = now.max(deadline);
//!     }
//! }
//! assert_eq!(to_master, [0x10, 0x02, 0x05, 0x00, 0x07, 0x16]);
//! // Not before min T_SDR, 11 bit times at 500 kbit/s.
//! assert_eq!(now, Instant::from_micros(22));
//! # Ok::<(), profidrive::profibus::fdl::AddressError>(())
//! ```
//!
//! [`host`] has this loop for links of an operating system, and the command `profidrive emulate` runs it.
//!
//! # Features
//!
//! * `std` (default): [`host`], [`explain`], [`gsd`] and [`process`].
//! * `judge`: judges of masters, and of slaves and nodes.
//! * `eds`: EDS, DCF and XDD files, and the nodes that they describe.
//! * `alloc`: telegrams built into `bytes::BufMut`.
//! * `serial`: an RS-485 serial port as link.
//! * `master`: profirust as DP master over our links and on a bench, sessions with one drive or several.
//! * `embedded-io`, `embedded-io-async`: loops over UARTs behind these traits ([`embedded`]).
//! * `defmt`: errors and events are `defmt::Format`. Does nothing on Windows, where only a program with a logger would link.
//! * `serde`: explanations as data for `serde`.
//! * `capture`: what passes on a line in pcapng files, written and read.
//! * `parameters`: the parameters of a PPO drive from TOML and CSV files.
//! * `panel`: HTTP control, a live stream and a page for browsers.
//! * `metrics`: what was counted, as OpenMetrics for Prometheus.
//! * `cli`: the command.
//! * `emulator`: the command without its `judge`.
#![cfg_attr(not(any(feature = "std", test)), no_std)]
#![cfg_attr(docsrs, feature(doc_cfg))]
// With these features every layer is in use, and the compiler says what nobody needs.
#![cfg_attr(
    not(all(feature = "cli", feature = "embedded-io", feature = "embedded-io-async")),
    allow(dead_code, unused_imports)
)]

// Tests share files with those of tests/.
#[cfg(test)]
extern crate self as profidrive;

pub mod time;

mod chance;

mod untold;

#[cfg(feature = "std")]
mod map;

pub mod image;

pub mod profibus;

pub mod can_bus;

pub mod face;

pub mod devices;

pub mod embedded;

pub mod client;

#[cfg(all(feature = "master", feature = "serial"))]
#[doc = include_str!("../docs/first-drive.md")]
pub mod first_drive {}

#[cfg(feature = "std")]
#[doc = include_str!("../docs/first-slave.md")]
pub mod first_slave {}

#[doc = include_str!("../docs/first-node.md")]
pub mod first_node {}

#[cfg(all(doctest, feature = "std"))]
#[doc = include_str!("../README.md")]
mod readme {}

#[cfg(feature = "std")]
pub mod process;

#[cfg(feature = "std")]
pub mod device_file;

#[cfg(feature = "std")]
pub mod gsd;

#[cfg(feature = "eds")]
pub mod eds;

#[cfg(feature = "std")]
pub mod explain;

#[cfg(feature = "std")]
pub mod host;

#[cfg(feature = "std")]
pub mod bench;

#[cfg(feature = "judge")]
pub mod judge;

#[cfg(feature = "master")]
pub mod master;

#[cfg(feature = "panel")]
pub mod panel;

#[cfg(feature = "metrics")]
pub mod metrics;

#[cfg(feature = "emulator")]
pub mod command;
