//! The command `profidrive`, as its users run it.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a test may panic, and has std"
)]

#[path = "../common/mod.rs"]
mod common;
#[path = "../panel/mod.rs"]
mod panel;
#[path = "../common/pty.rs"]
mod pty;
#[path = "../said/mod.rs"]
mod said;
#[path = "../telegrams/mod.rs"]
mod telegrams;
#[path = "../test_master/mod.rs"]
mod test_master;

#[cfg(target_os = "linux")]
mod capture;
#[cfg(target_os = "linux")]
mod command;
mod decode_encode;
mod demo;
#[cfg(target_os = "linux")]
mod documents;
mod emulator;
#[cfg(target_os = "linux")]
mod judge;
#[cfg(target_os = "linux")]
mod kept_stations;
#[cfg(target_os = "linux")]
mod kill;
#[cfg(target_os = "linux")]
mod left_behind;
mod log;
#[cfg(target_os = "linux")]
mod manual;
#[cfg(target_os = "linux")]
mod master_can;
#[cfg(target_os = "linux")]
mod master_command;
#[cfg(target_os = "linux")]
mod metrics;
#[cfg(target_os = "linux")]
mod node_panel;
#[cfg(target_os = "linux")]
mod nodes;
#[cfg(target_os = "linux")]
mod panel_api;
#[cfg(target_os = "linux")]
mod panel_history;
#[cfg(target_os = "linux")]
mod panel_inputs;
#[cfg(target_os = "linux")]
mod panel_kinds;
#[cfg(target_os = "linux")]
mod panel_ppo;
#[cfg(target_os = "linux")]
mod panel_robustness;
mod panel_stations;
#[cfg(target_os = "linux")]
mod plant;
#[cfg(target_os = "linux")]
mod ppo_drives;
#[cfg(target_os = "linux")]
mod state_dir;
#[cfg(target_os = "linux")]
mod stations;
#[cfg(target_os = "linux")]
mod what_it_says;
