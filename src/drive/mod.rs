//! The drive, bus-neutral (interface sketch; names fixed by agreement, bodies to come).
use crate::param::Store;
use core::time::Duration;

/// What the control word asks for, without bit positions. `device::words` builds it from STW and HSW.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Command {
    /// STW.0: 1 = ON, 0 = OFF1.
    pub on: bool,
    /// STW.1: 1 = no OFF2, 0 = OFF2.
    pub no_off2: bool,
    /// STW.3: 1 = enable operation.
    pub enable_operation: bool,
    /// STW.4 (positioning): 0 = stop, discard the job.
    pub no_stop: bool,
    /// STW.5 (positioning): 0 = intermediate stop.
    pub no_intermediate_stop: bool,
    /// STW.6: positioning: each change starts a travel job; velocity: 1 = setpoint released.
    pub start: bool,
    /// STW.7: rising edge acknowledges a fault.
    pub acknowledge: bool,
    /// STW.8: inching 1.
    pub inch_1: bool,
    /// STW.9: inching 2.
    pub inch_2: bool,
    /// STW.15: direction of inching 2 is negative.
    pub inch_2_negative: bool,
    /// HSW: target position (increments or 0.01 mm) or target velocity (rpm).
    pub setpoint: i32,
}
