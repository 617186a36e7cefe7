//! The master in this program on PROFIBUS: a thread of its own, beside the link of the line.

use core::time::Duration;
use std::io;
use std::thread::{self, JoinHandle};

use super::commanded::{Commanded, Over, in_words};
use super::pnu;
use crate::host::inner_master::{Asked, InnerMaster, Order};
use crate::host::link::beside::{Door, Neighbour};
use crate::host::{Clock, Startup, Stop, SystemClock};
use crate::master::{Session, SessionError, Settings, Slave};
use crate::profibus::dp::chk_cfg::MAX_IO_LEN;
use crate::profibus::fdl::Address;
use crate::time::BaudRate;

/// From one exchange to the next.
const CYCLE: Duration = Duration::from_millis(2);

/// The least slot time of a machine that is busy.
const SLOT_TIME: Duration = Duration::from_millis(20);

/// The master of a line. Dropped, it lets the slaves go and ends.
pub(crate) struct InnerSlaves {
    board: InnerMaster,
    stop: Stop,
    thread: Option<JoinHandle<()>>,
}

impl InnerSlaves {
    /// A master that comes on the line behind `door` when it is asked something. `clock` is that of the line.
    ///
    /// # Errors
    /// No thread can be started, or there are no descriptors left.
    pub(crate) fn start(
        board: InnerMaster,
        door: Door,
        clock: SystemClock,
        rate: BaudRate,
    ) -> io::Result<Self> {
        let stop = Stop::new()?;
        let mut master = Master {
            board: board.clone(),
            door,
            clock,
            rate,
            stop: stop.clone(),
            session: None,
            slaves: Vec::new(),
            known: Vec::new(),
        };
        let thread = thread::Builder::new().name("master".into()).spawn(move || master.run())?;
        Ok(Self { board, stop, thread: Some(thread) })
    }
}

impl Drop for InnerSlaves {
    fn drop(&mut self) {
        self.board.end();
        self.stop.request();
        // Nobody answers it any more: it does not wait for answers.
        drop(self.thread.take());
    }
}

/// No order has this number: something has happened by itself.
const NO_ORDER: u64 = 0;

type Line = Session<Neighbour, SystemClock>;

struct Master {
    board: InnerMaster,
    door: Door,
    clock: SystemClock,
    rate: BaudRate,
    stop: Stop,
    session: Option<Line>,
    slaves: Vec<Commanded>,
    /// What slaves are started with: once in the life of the process for each.
    known: Vec<Slave>,
}

impl Master {
    fn run(&mut self) {
        loop {
            if self.session.is_none() && !self.board.wait() || self.board.has_ended() {
                return;
            }
            while let Some(order) = self.board.next() {
                self.carry_out(order);
            }
            self.cycle();
        }
    }

    fn carry_out(&mut self, order: Order) {
        let Order { number, address, own, startup, asked } = order;
        let what = in_words(&asked, pnu);
        if asked == Asked::Leave {
            self.leave("the master has left the line");
            self.board
                .show(address, |shown| shown.end(number, what, Ok("the master has left the line".into())));
            return;
        }
        self.board.show(address, |shown| shown.doing = Some(what.clone()));
        let taken = match startup {
            Some(startup) => self.take(address, own, &startup),
            None => Err("nobody can say how this station is taken over".to_owned()),
        };
        if let Err(why) = taken {
            self.board.show(address, |shown| shown.end(number, what, Err(why)));
            return;
        }
        let now = self.clock.now();
        let Some(slave) = self.slaves.iter_mut().find(|slave| slave.address.number() == address) else {
            return;
        };
        let (over, doing) = (slave.begin(now, number, &asked), slave.doing());
        self.board.show(address, |shown| {
            shown.doing = doing;
            end(shown, over);
        });
    }

    /// Has the station, if it has it not yet.
    fn take(&mut self, address: u8, own: u8, startup: &Startup) -> Result<(), String> {
        if self.slaves.iter().any(|slave| slave.address.number() == address) {
            return Ok(());
        }
        let station = |number| Address::station(number).map_err(|error| error.to_string());
        let (own, at) = (station(own)?, station(address)?);
        let slave = self.slave(startup);
        let session = match &mut self.session {
            Some(session) => session,
            none => {
                let joined = join(&self.door, self.clock, &self.stop, (own, self.rate));
                self.board.join(own.number());
                none.insert(joined.map_err(|error| error.to_string())?)
            }
        };
        if let Err(error) = session.start_slave(at, &slave) {
            if self.slaves.is_empty() {
                self.leave("");
            }
            return Err(told(&error));
        }
        self.slaves.push(Commanded::new(at, startup));
        self.board.show(address, |shown| shown.taken = true);
        Ok(())
    }

    /// The slave in the words of the session, which keep.
    fn slave(&mut self, startup: &Startup) -> Slave {
        let lengths = startup.lengths();
        let is_it = |slave: &&Slave| {
            slave.ident == startup.ident
                && slave.configuration == startup.configuration.as_slice()
                && slave.user_prm == startup.user_prm.as_slice()
        };
        if let Some(slave) = self.known.iter().find(is_it) {
            return *slave;
        }
        let slave = Slave {
            ident: startup.ident,
            configuration: startup.configuration.clone().leak(),
            user_prm: startup.user_prm.clone().leak(),
            outputs: lengths.outputs.into(),
            inputs: lengths.inputs.into(),
            sync_mode: false,
            freeze_mode: false,
        };
        self.known.push(slave);
        slave
    }

    /// One exchange with each slave.
    fn cycle(&mut self) {
        let Self { session: Some(session), slaves, board, clock, .. } = self else { return };
        let mut lost = None;
        for slave in slaves.iter_mut() {
            let (outputs, mut inputs) = (slave.outputs(), [0; MAX_IO_LEN]);
            let address = slave.address.number();
            if let Some(words) = slave.new_words(&outputs) {
                let now = clock.now();
                board.show(address, |shown| {
                    shown.send(now, words);
                    shown.outputs.clone_from(&outputs);
                });
            }
            if let Err(error) = session.exchange_octets(slave.address, &outputs, &mut inputs) {
                lost = Some(told(&error));
                break;
            }
            let over = slave.take(clock.now(), &inputs);
            if over.is_some() {
                board.show(address, |shown| end(shown, over));
            }
        }
        if let Some(why) = lost {
            self.leave(&why);
        }
    }

    /// Lets every slave go, and is silent.
    fn leave(&mut self, why: &str) {
        for slave in self.slaves.drain(..) {
            let address = slave.address.number();
            let over = slave.lose(why);
            self.board.show(address, |shown| match over {
                Some(over) => end(shown, Some(over)),
                None => shown.end(NO_ORDER, "exchange data".into(), Err(why.to_owned())),
            });
        }
        if let Some(session) = self.session.take() {
            // What cannot be let go, its watchdog lets go.
            let _ = session.release();
        }
        self.board.let_go();
    }
}

fn join(door: &Door, clock: SystemClock, stop: &Stop, (own, rate): (Address, BaudRate)) -> io::Result<Line> {
    let settings = Settings { cycle: CYCLE, slot_time: SLOT_TIME, ..Settings::untimed(own, rate) };
    Session::new(door.neighbour(), clock, stop.clone(), settings)
}

fn end(shown: &mut crate::host::inner_master::Shown, over: Option<Over>) {
    if let Some(Over { number, what, outcome }) = over {
        shown.end(number, what, outcome);
    }
}

/// An error of the bus, as a master says it that is in the same program.
fn told(error: &SessionError) -> String {
    format!("{error}; the master in this program has left the line")
}
