//! The judge of masters: correct masters are not accused, each mistake is found by its rows.

#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::wildcard_enum_match_arm,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::alloc_instead_of_core
)]

#[path = "../../examples/own_station.rs"]
mod own_station;
#[path = "../helpers/record_table.rs"]
mod record_table;
#[path = "../helpers/test_master/mod.rs"]
mod test_master;

mod acyclic;
mod admitted;
mod class_two;
mod configured;
mod covered;
mod endings;
mod habits;
mod live;
mod many;
mod nodes;
mod operated;
#[cfg(feature = "master")]
mod own_clients;
#[cfg(feature = "master")]
mod profirust;
mod rates;
mod recordings;
mod reports;
mod ring;
#[cfg(feature = "master")]
mod session;
mod situations;
mod slaves;
mod soaked;
mod virtual_time;
