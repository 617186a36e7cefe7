//! PROFIBUS-DP drives in software (guide follows).
#![no_std]
#[cfg(any(feature = "std", test))]
extern crate std;

pub mod time;
pub mod fdl;
pub mod dp;
pub mod ppo;
pub mod param;
pub mod pkw;
pub mod drive;
pub mod device;
#[cfg(feature = "std")]
pub mod host;
#[cfg(feature = "master")]
pub mod master;
