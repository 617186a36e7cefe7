//! The positioning drives SIKO AG03 and AG03/1: parameters, state machine and motion, the powered unit, and the unit on
//! either bus.

pub mod canopen;
mod description;
pub mod drive;
pub mod param;
pub mod profibus;
mod surroundings;
pub mod unit;
mod why;
