//! The master in this program, as those see it who ask something of it: what is asked, and what came of it.
//!
//! A face puts an [`Order`] here; the machine behind (`profidrive::master`) takes it, and shows what it does. Neither knows
//! the other.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use super::{Startup, Stop};
use crate::face::operation::Act;
use crate::time::Instant;

/// Lines that are kept of what a station was sent.
const SENT: usize = 24;

/// Orders that wait at most.
const WAITING: usize = 64;

/// What is asked of the master about one station.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    /// Which order it is.
    pub(crate) number: u64,
    /// The station.
    pub(crate) address: u8,
    /// An address on PROFIBUS that the master may have.
    pub(crate) own: u8,
    /// How a slave is taken over; `None` of a node.
    pub(crate) startup: Option<Startup>,
    pub(crate) asked: Asked,
}

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Asked {
    /// To take the station over, and no more.
    Take,
    /// To leave the line: every station is let go.
    Leave,
    /// One of the acts of its operation, with its number.
    Act(Act, Option<f64>),
    /// To send these octets in each cycle.
    Outputs(Vec<u8>),
    /// To read a parameter or an entry.
    Read(Place),
    /// To write one.
    Write(Place, f64),
}

/// A parameter, of an array the element; or an entry of an object dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) number: u16,
    pub(crate) sub: Option<u8>,
}

/// What the master shows of one station.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Shown {
    /// It exchanges data with it, or has sent it something.
    pub(crate) taken: bool,
    /// What it does now.
    pub(crate) doing: Option<String>,
    /// What came of the last order.
    pub(crate) done: Option<Done>,
    /// The octets that it sends in each cycle; none to a node.
    pub(crate) outputs: Vec<u8>,
    /// What was sent, the newest last.
    pub(crate) sent: VecDeque<Sent>,
}

/// What came of an order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Done {
    pub(crate) number: u64,
    pub(crate) what: String,
    pub(crate) well: bool,
    pub(crate) text: String,
}

/// Words that were sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Sent {
    pub(crate) at: Instant,
    pub(crate) text: String,
}

impl Shown {
    /// These words are sent from now on.
    pub(crate) fn send(&mut self, at: Instant, text: String) {
        if self.sent.len() >= SENT {
            self.sent.pop_front();
        }
        self.sent.push_back(Sent { at, text });
    }

    /// An order is over.
    pub(crate) fn end(&mut self, number: u64, what: String, outcome: Result<String, String>) {
        let well = outcome.is_ok();
        let text = outcome.unwrap_or_else(|why| why);
        self.doing = None;
        self.done = Some(Done { number, what, well, text });
    }
}

/// The master in this program. A clone is the same one.
#[derive(Clone, Debug)]
pub(crate) struct InnerMaster {
    shared: Arc<Shared>,
    /// Ends a run of the line, so that it looks here.
    wake: Stop,
}

#[derive(Debug, Default)]
struct Shared {
    desk: Mutex<Desk>,
    asked: Condvar,
}

#[derive(Debug, Default)]
struct Desk {
    last: u64,
    waiting: VecDeque<Order>,
    shown: BTreeMap<u8, Shown>,
    /// The address of the master on PROFIBUS while it is on the line.
    own: Option<u8>,
    ended: bool,
}

/// An address on PROFIBUS that the master can have.
pub(crate) fn free_address(is_taken: impl Fn(u8) -> bool) -> Option<u8> {
    (1..=125).find(|address| !is_taken(*address))
}

impl InnerMaster {
    /// A master that nobody has asked anything. `wake` ends a run of its line.
    pub(crate) fn new(wake: Stop) -> Self {
        Self { shared: Arc::default(), wake }
    }

    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.shared.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts an order and says its number; `None`: too many wait.
    /// `own` is an address that the master may have on the line.
    pub(crate) fn ask(
        &self,
        (address, own): (u8, u8),
        startup: Option<Startup>,
        asked: Asked,
    ) -> Option<u64> {
        let mut desk = self.desk();
        if desk.waiting.len() >= WAITING || desk.ended {
            return None;
        }
        desk.last += 1;
        let number = desk.last;
        desk.waiting.push_back(Order { number, address, own, startup, asked });
        drop(desk);
        self.shared.asked.notify_all();
        self.wake.request();
        Some(number)
    }

    /// The oldest order that waits.
    pub(crate) fn next(&self) -> Option<Order> {
        self.desk().waiting.pop_front()
    }

    /// Sleeps until an order waits. `false`: the master shall end.
    pub(crate) fn wait(&self) -> bool {
        let mut desk = self.desk();
        while desk.waiting.is_empty() && !desk.ended {
            desk = self.shared.asked.wait(desk).unwrap_or_else(PoisonError::into_inner);
        }
        !desk.ended
    }

    /// Has the master end.
    pub(crate) fn end(&self) {
        self.desk().ended = true;
        self.shared.asked.notify_all();
    }

    /// Whether it shall end.
    pub(crate) fn has_ended(&self) -> bool {
        self.desk().ended
    }

    /// What it shows of a station.
    pub(crate) fn shown(&self, address: u8) -> Shown {
        self.desk().shown.get(&address).cloned().unwrap_or_default()
    }

    /// Changes what it shows of a station.
    pub(crate) fn show(&self, address: u8, change: impl FnOnce(&mut Shown)) {
        change(self.desk().shown.entry(address).or_default());
    }

    /// It has let every station go.
    pub(crate) fn let_go(&self) {
        let mut desk = self.desk();
        desk.own = None;
        for shown in desk.shown.values_mut() {
            shown.taken = false;
            shown.doing = None;
            shown.outputs.clear();
        }
    }

    /// Its address on the line; `None`: it is not on it.
    pub(crate) fn own(&self) -> Option<u8> {
        self.desk().own
    }

    /// It is on the line with this address.
    pub(crate) fn join(&self, own: u8) {
        self.desk().own = Some(own);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_come_in_their_order_wake_the_line_and_are_bounded() {
        let wake = Stop::new().unwrap();
        let master = InnerMaster::new(wake.clone());
        let numbers: Vec<_> = (0..WAITING).map(|_| master.ask((5, 1), None, Asked::Take)).collect();
        assert_eq!((numbers[0], numbers[1]), (Some(1), Some(2)));
        assert!(wake.is_requested());
        assert_eq!(master.ask((5, 1), None, Asked::Take), None);
        assert_eq!(master.next().map(|order| order.number), Some(1));
        assert!(master.wait());
        master.end();
        assert!(!master.wait());
        assert_eq!(master.ask((5, 1), None, Asked::Take), None);
    }

    #[test]
    fn what_was_sent_is_bounded_and_what_was_let_go_is_not_taken() {
        let master = InnerMaster::new(Stop::new().unwrap());
        master.join(1);
        master.show(5, |shown| {
            shown.taken = true;
            (0..SENT + 5).for_each(|number| shown.send(Instant::ZERO, number.to_string()));
            shown.end(7, "enable".into(), Err("it has a fault".into()));
        });
        let shown = master.shown(5);
        assert_eq!((shown.sent.len(), shown.sent[0].text.as_str()), (SENT, "5"));
        assert_eq!(shown.done.map(|done| (done.number, done.well)), Some((7, false)));
        master.let_go();
        assert_eq!((master.own(), master.shown(5).taken), (None, false));
    }
}
