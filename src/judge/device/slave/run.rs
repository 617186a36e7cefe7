//! A slave on a link of the operating system, or in virtual time.

use super::wire::{Sight, Wire};
use super::{Bench, Report, Row, Setup};
use crate::bench;
use crate::host::{Clock, Link, Stop};
use crate::judge::Progress;
use crate::judge::device::{Attendant, play};
use crate::time::BaudRate;

/// Judges the slave behind `link` by these rows until it is over or `stop` is requested. `told` gets what is tried.
pub fn live(
    setup: Setup,
    wanted: &[Row],
    link: Box<dyn Link>,
    clock: Box<dyn Clock>,
    rate: BaudRate,
    stop: Stop,
    attendant: Option<Box<dyn Attendant>>,
    told: &mut dyn FnMut(&Progress),
) -> Report {
    let sight = if setup.sight == Sight::Exact { Sight::Untimed } else { setup.sight };
    let wire = Wire::live(link, clock, stop, rate, sight, setup.slot);
    play::run(&mut Bench::new(setup, wire, attendant), wanted, told)
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
    let wire = Wire::simulated(port, Stop::new()?);
    Ok(play::run(&mut Bench::new(setup, wire, attendant), wanted, &mut |_| ()))
}
