//! What every servo drive is made of, without a bus and without a maker: motor and load, motion with limits, set-points,
//! homing. Positions are increments of its encoder.
//!
//! | file | holds |
//! | --- | --- |
//! | [`inputs`] | load, switches, supply |
//! | `pace` | the steps in which a drive lives |
//! | [`plant`] | motor and load |
//! | `profile` | motion with limited velocity and accelerations |
//! | `position` | set-points of the profile position mode |
//! | `smooth` | the same without corners |
//! | `homing` | every homing method |
//! | `news` | what it tells of itself, in words |
//! | `stopping` | a ramp to rest, and what follows |

pub(crate) mod homing;
pub mod inputs;
pub(crate) mod news;
pub(crate) mod pace;
pub mod plant;
pub(crate) mod position;
pub(crate) mod profile;
pub(crate) mod smooth;
pub(crate) mod stopping;
