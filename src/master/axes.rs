//! Several drives in one program, each with a queue of goals.

use std::collections::VecDeque;

use super::{Session, SessionError};
use crate::client::{DriveClient, Goal, GoalOutcome};
use crate::host::{Clock, Link};
use crate::profibus::fdl::Address;
use crate::profibus::ppo::Inputs;

/// A [`Session`] with several drives, and for each a [`DriveClient`] and the goals it shall pursue one after the other.
///
/// [`Axes::cycle`] exchanges data with every drive once. Whoever stops calling it for longer than the watchdog loses
/// the drives, which release their motors then.
///
/// ```no_run
/// use profidrive::client::{DriveClient, Goal};
/// use profidrive::profibus::fdl::Address;
/// use profidrive::host::link::terminal::Terminal;
/// use profidrive::host::{Stop, SystemClock};
/// use profidrive::master::{Axes, Session, Settings};
/// use profidrive::time::BaudRate;
///
/// let link = Terminal::open("/tmp/bus".as_ref(), BaudRate::K500)?;
/// let settings = Settings::untimed(Address::station(2)?, BaudRate::K500);
/// let mut axes = Axes::new(Session::new(link, SystemClock::new(), Stop::new()?, settings)?);
/// let [width, height] = [Address::station(5)?, Address::station(6)?];
/// for axis in [width, height] {
///     axes.add(axis, DriveClient::default())?;
/// }
/// axes.queue(width, [Goal::Enable, Goal::MoveTo(4000), Goal::Disable]);
/// axes.queue(height, [Goal::Enable, Goal::MoveTo(-200), Goal::Disable]);
/// for (axis, outcome) in axes.run()? {
///     println!("{axis}: {}: {:?}", outcome.goal, outcome.result);
/// }
/// axes.release()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Axes<L, C> {
    session: Session<L, C>,
    axes: Vec<Axis>,
}

#[derive(Debug)]
struct Axis {
    address: Address,
    client: DriveClient,
    goals: VecDeque<Goal>,
}

impl<L: Link, C: Clock> Axes<L, C> {
    /// No drives yet.
    pub const fn new(session: Session<L, C>) -> Self {
        Self { session, axes: Vec::new() }
    }

    /// Takes a drive over. A drive that is there already gets this client and an empty queue.
    ///
    /// # Errors
    /// As [`Session::start`].
    pub fn add(&mut self, address: Address, client: DriveClient) -> Result<(), SessionError> {
        self.session.start(address)?;
        self.axes.retain(|axis| axis.address != address);
        self.axes.push(Axis { address, client, goals: VecDeque::new() });
        Ok(())
    }

    /// Puts goals behind those that wait for this drive. `false`: there is no such drive.
    pub fn queue(&mut self, address: Address, goals: impl IntoIterator<Item = Goal>) -> bool {
        let axis = self.axes.iter_mut().find(|axis| axis.address == address);
        axis.map(|axis| axis.goals.extend(goals)).is_some()
    }

    /// Whether no drive pursues a goal and none waits.
    pub(crate) fn is_idle(&self) -> bool {
        self.axes.iter().all(|axis| axis.goals.is_empty() && axis.client.goal().is_none())
    }

    /// Exchanges data with every drive once and begins the next goals. Says which goals are over.
    ///
    /// When a goal fails, the goals that wait for the same drive are forgotten: they were meant for a drive that had
    /// reached it.
    ///
    /// # Errors
    /// As [`Session::exchange`]; the drives after the one that was lost were not served.
    pub fn cycle(&mut self) -> Result<Vec<(Address, GoalOutcome)>, SessionError> {
        let Self { session, axes } = self;
        let mut over = Vec::new();
        for Axis { address, client, goals } in axes {
            if client.goal().is_none()
                && let Some(goal) = goals.pop_front()
            {
                client.pursue(session.now(), goal);
            }
            let inputs = session.exchange_with(*address, &client.outputs())?;
            client.handle_inputs(session.now(), Inputs::new(&inputs));
            if let Some(outcome) = client.poll_outcome() {
                if outcome.result.is_err() {
                    goals.clear();
                }
                over.push((*address, outcome));
            }
        }
        Ok(over)
    }

    /// Cycles until all are idle: every goal with its outcome, in the order in which they were over.
    ///
    /// # Errors
    /// As [`Axes::cycle`].
    pub fn run(&mut self) -> Result<Vec<(Address, GoalOutcome)>, SessionError> {
        let mut over = Vec::new();
        while !self.is_idle() {
            over.extend(self.cycle()?);
        }
        Ok(over)
    }

    /// Releases every drive, as [`Session::release`] does.
    ///
    /// # Errors
    /// As [`Session::release`].
    pub fn release(self) -> Result<(), SessionError> {
        self.session.release()
    }
}
