//! PPO 4: 6 words of process data, without parameter channel; Chk_Cfg F5.
//!
//! ```text
//! octet             0 1  2 3  4 5    ...  10 11
//! master -> slave   STW  HSW  PZD 3  ...  PZD 6
//! slave -> master   ZSW  HIW  PZD 3  ...  PZD 6
//! ```
//!
//! ```
//! use profidrive::profibus::ppo::{Stw, ppo4};
//!
//! let octets = ppo4::Outputs::octets(Stw::from_raw(0x047F), -0x4000, [1, 2, 3, 4]);
//! assert_eq!(ppo4::Outputs::parse(&octets)?.hsw(), -0x4000);
//! # Ok::<(), profidrive::profibus::ppo::LengthError>(())
//! ```
//!
//! It has no parameter channel to ask for:
//!
//! ```compile_fail,E0599
//! # let octets = [0; profidrive::profibus::ppo::ppo4::LEN];
//! profidrive::profibus::ppo::ppo4::Inputs::new(&octets).pkw();
//! ```

use super::views::ppo_views;

ppo_views! {
    /// A view of PPO 4 from the master to the slave.
    Outputs,
    /// A view of PPO 4 from the slave to the master.
    Inputs,
    /// Octets of PPO 4 in each direction.
    LEN = 12,
    word at 0, main i16 at 2, more 4 at 4
}
