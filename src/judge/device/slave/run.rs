//! Runs the judgement of a slave: on a link of the operating system, or in virtual time.

use super::wire::{Sight, Wire};
use super::{Report, Row, Setup, Tester};
use crate::bench;
use crate::host::{Clock, Link, Stop};
use crate::judge::Progress;
use crate::judge::device::{Attendant, play};
use crate::time::BaudRate;

/// A line of the operating system.
pub struct Live {
    /// Its octets.
    pub link: Box<dyn Link>,
    /// The clock of their times.
    pub clock: Box<dyn Clock>,
    /// How far these can be trusted. [`Sight::Exact`] is for virtual time.
    pub sight: Sight,
    /// Its rate, as far as there is one.
    pub rate: BaudRate,
    /// Ends the judgement when it is requested.
    pub stop: Stop,
}

impl core::fmt::Debug for Live {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Live").field("sight", &self.sight).field("rate", &self.rate).finish_non_exhaustive()
    }
}

/// Judges the slave on a line by these rows. `told` gets what is tried.
pub fn live(
    setup: Setup,
    wanted: &[Row],
    line: Live,
    attendant: Option<Box<dyn Attendant>>,
    told: &mut dyn FnMut(&Progress),
) -> Report {
    let wire = Wire::live(line, &setup);
    play::run(&mut Tester::new(setup, wire, attendant), wanted, told)
}

/// Judges a slave on a line in virtual time by these rows, to the bit time. It is on the line already.
///
/// # Errors
/// The operating system has no pipe for [`Stop`].
pub fn simulated(
    port: &bench::Port,
    setup: Setup,
    wanted: &[Row],
    attendant: Option<Box<dyn Attendant>>,
) -> std::io::Result<Report> {
    let wire = Wire::simulated(port, &setup, Stop::new()?);
    Ok(play::run(&mut Tester::new(setup, wire, attendant), wanted, &mut |_| ()))
}
