//! The command `profidrive`, as its users run it.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a test may panic, and has std"
)]

#[path = "../helpers/drive_line.rs"]
mod drive_line;
#[path = "../helpers/panel.rs"]
mod panel;
#[path = "../helpers/patience.rs"]
mod patience;
#[path = "../helpers/process.rs"]
mod process;
#[path = "../helpers/pty.rs"]
mod pty;
#[path = "../helpers/raw_master.rs"]
mod raw_master;
#[path = "../helpers/sentences.rs"]
mod sentences;
#[path = "../helpers/telegrams.rs"]
mod telegrams;
#[path = "../helpers/test_master/mod.rs"]
mod test_master;

#[cfg(target_os = "linux")]
mod acyclic_words;
#[cfg(target_os = "linux")]
mod bench;
#[cfg(target_os = "linux")]
mod beside_noise;
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
#[cfg(target_os = "linux")]
mod line_file;
mod log;
#[cfg(all(target_os = "linux", feature = "manual"))]
mod manual;
#[cfg(target_os = "linux")]
mod master_can;
#[cfg(target_os = "linux")]
mod master_command;
#[cfg(target_os = "linux")]
mod master_records;
#[cfg(target_os = "linux")]
mod metrics;
#[cfg(target_os = "linux")]
mod node_files;
#[cfg(target_os = "linux")]
mod node_objects;
mod node_panel;
#[cfg(target_os = "linux")]
mod node_switches;
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
mod panel_records;
#[cfg(target_os = "linux")]
mod panel_robustness;
#[cfg(target_os = "linux")]
mod panel_served;
mod panel_stations;
#[cfg(target_os = "linux")]
mod ppo_drives;
#[cfg(target_os = "linux")]
mod state_dir;
#[cfg(target_os = "linux")]
mod stations;
#[cfg(target_os = "linux")]
mod try_devices;
#[cfg(target_os = "linux")]
mod what_it_says;
