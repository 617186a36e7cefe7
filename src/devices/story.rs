//! What `profidrive demo` plays: the story of a device as data, each in the folder of its device.

use core::time::Duration;

use crate::can_bus::canopen::Address;
use crate::face::EventKind;
use crate::profibus::ppo::{JobId, Stw, ZswPattern};

/// The node number or the station address of the device of a story.
pub(crate) const PLACE: u8 = 5;

/// What happens in a story on CANopen, behind the boot-up.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NodeAct {
    /// A part begins.
    Title(&'static str),
    /// A paragraph.
    Text(&'static str),
    /// The master reads an entry by SDO; the answer says this.
    Read(Address, &'static str),
    /// The master writes an entry by SDO, at most four octets, low octet first; the answer says this.
    Write(Address, &'static [u8], &'static str),
    /// The master sends a frame with this identifier.
    Send(u16, &'static [u8]),
    /// Until the device says this.
    Wait(&'static str),
    /// SYNC until the device says this.
    SyncUntil(&'static str),
    /// Time passes.
    Pass(Duration),
    /// An input has this value.
    Input(&'static str, f64),
    /// A fault is made.
    Provoke(&'static str),
    /// Everything around the device is as it should be.
    Repair,
    /// A person sees this at the device.
    Look(&'static str),
}

/// What happens in a story on PROFIBUS with the PPO of seven words.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SlaveAct {
    /// A part begins.
    Title(&'static str),
    /// A paragraph.
    Text(&'static str),
    /// The telegrams until the first inputs.
    StartUp,
    /// A job of the parameter channel, what it does, and its reply of four words.
    Job {
        /// What is asked.
        job: JobId,
        /// Of which parameter.
        pnu: u16,
        /// The value.
        value: u32,
        /// What it does.
        meaning: &'static str,
        /// Four words in hexadecimal.
        reply: &'static str,
    },
    /// What the device says about what it refused or what has happened.
    Reason(EventKind),
    /// A control word and a setpoint, and the status word that follows.
    Command(&'static str, Stw, i32, ZswPattern),
    /// The status word that comes by itself.
    Observe(ZswPattern),
    /// The position is recorded from here.
    Record,
    /// This moment has a name in the picture.
    Mark(&'static str),
    /// Time passes.
    Pass(Duration),
    /// The picture of what was recorded.
    Draw,
    /// A fault is made.
    Provoke(&'static str),
    /// Everything around the device is as it should be.
    Repair,
}
