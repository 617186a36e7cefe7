//! PPO 3: 2 words of process data, without parameter channel; Chk_Cfg F1.
//!
//! ```text
//! octet             0 1  2 3
//! master -> slave   STW  HSW
//! slave -> master   ZSW  HIW
//! ```
//!
//! ```
//! use profidrive::profibus::ppo::{Stw, ppo3};
//!
//! let octets = ppo3::Outputs::octets(Stw::from_raw(0x047F), -0x4000);
//! assert_eq!(ppo3::Outputs::parse(&octets)?.hsw(), -0x4000);
//! # Ok::<(), profidrive::profibus::ppo::LengthError>(())
//! ```
//!
//! It has no parameter channel to ask for:
//!
//! ```compile_fail,E0599
//! # let octets = [0; profidrive::profibus::ppo::ppo3::LEN];
//! profidrive::profibus::ppo::ppo3::Inputs::new(&octets).pkw();
//! ```

use super::views::ppo_views;

ppo_views! {
    /// A view of PPO 3 from the master to the slave.
    Outputs,
    /// A view of PPO 3 from the slave to the master.
    Inputs,
    /// Octets of PPO 3 in each direction.
    LEN = 4,
    word at 0, main i16 at 2
}
