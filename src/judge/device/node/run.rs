//! A node behind an endpoint of the operating system, or in virtual time.

use core::time::Duration;

use super::wire::Wire;
use super::{Port, Report, Row, Setup, Tester};
use crate::host::can::CanEndpoint;
use crate::host::{Clock, Stop};
use crate::judge::Progress;
use crate::judge::device::{Attendant, play};

/// An operating system and an adapter bring frames so much later than they were on the bus.
const LATENCY: Duration = Duration::from_millis(30);

/// A bus of the operating system.
pub struct Live {
    /// The bus from the master's end.
    pub endpoint: Box<dyn CanEndpoint>,
    /// The clock of its frames.
    pub clock: Box<dyn Clock>,
    /// Ends the judgement when it is requested.
    pub stop: Stop,
}

impl core::fmt::Debug for Live {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Live").finish_non_exhaustive()
    }
}

/// Judges the node on a bus by these rows. `told` gets what is tried.
pub fn live(
    setup: Setup,
    wanted: &[Row],
    bus: Live,
    attendant: Option<Box<dyn Attendant>>,
    told: &mut dyn FnMut(&Progress),
) -> Report {
    let wire = Wire::new(bus.endpoint, bus.clock, bus.stop, LATENCY, setup.limit);
    play::run(&mut Tester::new(setup, wire, attendant), wanted, told)
}

/// Judges a node on a bus in virtual time by these rows. It is on the bus already.
///
/// # Errors
/// The operating system has no pipe for [`Stop`].
pub fn simulated<E: 'static>(
    port: &Port<E>,
    setup: Setup,
    wanted: &[Row],
    attendant: Option<Box<dyn Attendant>>,
) -> std::io::Result<Report> {
    let wire =
        Wire::new(Box::new(port.clone()), Box::new(port.clone()), Stop::new()?, Duration::ZERO, setup.limit);
    Ok(play::run(&mut Tester::new(setup, wire, attendant), wanted, &mut |_| ()))
}
