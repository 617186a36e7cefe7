//! PPO 2: PKW and 6 words of process data; Chk_Cfg F3 F5.
//!
//! ```text
//! octet             0 1  2 3  4 5       6 7      8 9  10 11  12 13  ...  18 19
//! master -> slave   PKE  IND  PWE high  PWE low  STW  HSW    PZD 3  ...  PZD 6
//! slave -> master   PKE  IND  PWE high  PWE low  ZSW  HIW    PZD 3  ...  PZD 6
//! ```
//!
//! ```
//! use profidrive::profibus::ppo::{Pkw, Stw, ppo2};
//!
//! let octets = ppo2::Outputs::octets(Pkw::ZERO, Stw::from_raw(0x047F), -0x4000, [1, 2, 3, 4]);
//! assert_eq!(ppo2::Outputs::parse(&octets)?.hsw(), -0x4000);
//! # Ok::<(), profidrive::profibus::ppo::LengthError>(())
//! ```
//!
//! Octets of another type do not pass for it:
//!
//! ```compile_fail,E0308
//! # let octets = [0; profidrive::profibus::ppo::PPO_LEN];
//! profidrive::profibus::ppo::ppo2::Inputs::new(&octets);
//! ```

use super::views::ppo_views;

ppo_views! {
    /// A view of PPO 2 from the master to the slave.
    Outputs,
    /// A view of PPO 2 from the slave to the master.
    Inputs,
    /// Octets of PPO 2 in each direction.
    LEN = 20,
    with pkw, word at 8, main i16 at 10, more 4 at 12
}
