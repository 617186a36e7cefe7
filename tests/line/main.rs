//! Lines, links and the run loop of the host; masters of others over them.
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
#[cfg(feature = "std")]
mod faulty_disk;
mod gsd_image;
#[path = "../helpers/long.rs"]
mod long;
#[path = "../helpers/mirror_slaves.rs"]
mod mirror_slaves;
#[path = "../helpers/patience.rs"]
mod patience;
#[path = "../helpers/sentences.rs"]
mod sentences;
#[path = "../helpers/telegrams.rs"]
mod telegrams;

mod axes;
#[cfg(feature = "std")]
mod hints;
#[cfg(target_os = "linux")]
mod host_pty;
#[cfg(feature = "std")]
mod host_run;
#[cfg(all(target_os = "linux", feature = "std"))]
mod host_tcp;
mod interop_profirust;
#[cfg(feature = "std")]
mod interop_stations;
#[cfg(feature = "std")]
mod kept;
#[cfg(feature = "std")]
mod line;
#[cfg(feature = "std")]
mod line_errors;
#[cfg(feature = "std")]
mod line_faults;
#[cfg(feature = "std")]
mod many_stations;
#[cfg(target_os = "linux")]
mod master_clients;
#[cfg(feature = "metrics")]
mod metrics;
mod new_device;
#[cfg(feature = "std")]
mod node_bus;
#[cfg(feature = "std")]
mod node_images;
mod noisy_line;
mod own_master;
mod own_station;
mod ppo_drive;
#[cfg(target_os = "linux")]
mod slcan;
#[cfg(all(target_os = "linux", feature = "serial"))]
mod slot_time;
#[cfg(target_os = "linux")]
mod system_calls;
#[cfg(feature = "std")]
mod what_it_says;
