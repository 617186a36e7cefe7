//! Slaves and drives in virtual time, as the bus sees them: the master says, the slave answers, at this time.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a test may panic, and has std"
)]

#[path = "../helpers/ag03_node.rs"]
mod ag03_node;
#[path = "../helpers/ap10_node/mod.rs"]
mod ap10_node;
#[path = "../helpers/asda_a2_node/mod.rs"]
mod asda_a2_node;
#[path = "../helpers/dpv1_line.rs"]
mod dpv1_line;
#[path = "../helpers/drive_line.rs"]
mod drive_line;
#[path = "../helpers/drive_rig.rs"]
mod drive_rig;
#[path = "../helpers/long.rs"]
mod long;
#[path = "../helpers/pkw_adversary.rs"]
mod pkw_adversary;
#[path = "../helpers/record_table.rs"]
mod record_table;
#[path = "../helpers/sentences.rs"]
mod sentences;
#[path = "../helpers/slave_line.rs"]
mod slave_line;
#[path = "../helpers/telegrams.rs"]
mod telegrams;

mod ap10_display;
mod ap10_kept;
mod ap10_objects;
mod ap10_process_data;
mod ap10_robustness;
mod asda_errors;
mod asda_modes;
mod asda_objects;
mod asda_states;
mod canopen_client;
mod canopen_eds;
mod canopen_errors;
mod canopen_faults;
mod canopen_nmt;
mod canopen_pdo;
mod canopen_robustness;
mod canopen_sdo;
mod canopen_storage;
mod client_adversary;
mod client_drive;
#[cfg(feature = "std")]
mod client_faults;
#[cfg(feature = "std")]
mod client_goals;
mod client_motion;
mod client_node;
mod client_quirks;
mod co_ag03_bus;
mod co_ag03_motion;
mod co_ag03_node;
mod conformance;
mod data_exchange;
mod diagnosis;
mod dp_states;
mod dpv1;
mod dpv1_client;
mod dpv1_connections;
mod dpv1_walk;
mod drive_behaviour;
mod drive_faults;
mod drive_log;
mod drive_states;
#[cfg(feature = "std")]
mod eds_axes;
#[cfg(feature = "std")]
mod eds_drive;
#[cfg(feature = "std")]
mod eds_encoder;
#[cfg(feature = "std")]
mod eds_files;
#[cfg(feature = "std")]
mod eds_io;
#[cfg(feature = "std")]
mod eds_node;
#[cfg(feature = "std")]
mod eds_profiles;
#[cfg(feature = "std")]
mod eds_transfers;
#[cfg(feature = "std")]
#[path = "../helpers/file_drive.rs"]
mod file_drive;
#[cfg(feature = "std")]
#[path = "../helpers/file_node.rs"]
mod file_node;
#[cfg(feature = "std")]
mod function_blocks;
mod fuzz_corpus;
mod generic_slave;
mod gsd;
#[cfg(feature = "std")]
mod gsd_acyclic;
#[cfg(feature = "std")]
mod gsd_hints;
#[cfg(feature = "std")]
mod gsd_modules;
#[cfg(feature = "std")]
mod gsd_station;
mod hints;
mod layers;
mod modular;
mod names;
mod node_quirks;
mod nodes_walk;
mod one_place_per_fact;
mod oracle;
#[cfg(feature = "std")]
mod own_drive;
mod persistence;
mod pkw_jobs;
mod policy;
#[cfg(feature = "std")]
#[cfg(feature = "parameters")]
mod ppo_drive;
#[cfg(feature = "std")]
mod profidrive4;
mod quirks;
mod references;
mod robustness;
mod set_address;
mod startup;
mod story;
mod travel_pictures;
mod what_it_says;

// The fuzz targets need it, too.
use fuzz_corpus::invariants::canopen_device;
