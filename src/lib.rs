//! PROFIBUS-DP drives in software (guide follows).
#![no_std]
#[cfg(any(feature = "std", test))]
#[cfg_attr(test, macro_use)]
extern crate std;

pub mod device;
pub mod dp;
pub mod drive;
pub mod fdl;
#[cfg(feature = "std")]
pub mod host;
#[cfg(feature = "master")]
pub mod master;
pub mod param;
pub mod pkw;
pub mod ppo;
pub mod time;
