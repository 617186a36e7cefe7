//! PPO 1: PKW and 2 words of process data; Chk_Cfg F3 F1.
//!
//! ```text
//! octet             0 1  2 3  4 5       6 7      8 9  10 11
//! master -> slave   PKE  IND  PWE high  PWE low  STW  HSW
//! slave -> master   PKE  IND  PWE high  PWE low  ZSW  HIW
//! ```
//!
//! ```
//! use profidrive::profibus::ppo::{Pkw, Stw, ppo1};
//!
//! let octets = ppo1::Outputs::octets(Pkw::ZERO, Stw::from_raw(0x047F), -0x4000);
//! assert_eq!(ppo1::Outputs::parse(&octets)?.hsw(), -0x4000);
//! # Ok::<(), profidrive::profibus::ppo::LengthError>(())
//! ```
//!
//! Octets of another type do not pass for it:
//!
//! ```compile_fail,E0308
//! # let octets = [0; profidrive::profibus::ppo::PPO_LEN];
//! profidrive::profibus::ppo::ppo1::Inputs::new(&octets);
//! ```

use super::views::ppo_views;

ppo_views! {
    /// A view of PPO 1 from the master to the slave.
    Outputs,
    /// A view of PPO 1 from the slave to the master.
    Inputs,
    /// Octets of PPO 1 in each direction.
    LEN = 12,
    with pkw, word at 8, main i16 at 10
}
