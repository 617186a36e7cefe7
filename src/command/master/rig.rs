//! An emulated drive behind a link in this process, in virtual time, that can be cut off at any telegram.

use core::cell::RefCell;
use core::time::Duration;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;

use profidrive::device::{Config, Device, Timing};
use profidrive::drive::{Fault, Inputs};
use profidrive::fdl::{Address, MAX_TELEGRAM_LEN};
use profidrive::host::{Bus, Clock, Link, ManualClock, Received, Stop};
use profidrive::master::{Session, Settings};
use profidrive::param::{Model, Parameter};
use profidrive::time::BaudRate;

use super::drive::Drive;

const DRIVE: u8 = 5;

/// What happens at a telegram of the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    /// Somebody presses Ctrl-C.
    Stop,
    /// The link fails, and the drive does not get the telegram.
    Link,
    /// The drive gets the telegram; its answer and everything later is lost.
    Answers,
    /// The AG03 loses its enable input, the AG03/1 the supply of its output stage.
    Enable,
    /// The output stage of the drive gets too hot: fault D.
    Heat,
}

/// The test's view of the drive.
#[derive(Clone)]
pub(super) struct Rig {
    line: Rc<RefCell<Line>>,
    pub(super) stop: Stop,
}

struct Line {
    bus: Bus,
    clock: ManualClock,
    to_master: VecDeque<u8>,
    /// What happens after so many more telegrams.
    cut: Option<(usize, Cut)>,
    silent: bool,
}

impl Rig {
    /// A drive with its defaults.
    pub(super) fn new(model: Model) -> Self {
        let (mut bus, clock) = (Bus::on(BaudRate::K500, Timing::Untrue), ManualClock::new());
        let config = Config { model, ..Config::new(Address::from_octet(DRIVE)) };
        bus.add(Device::new(config, clock.now())).unwrap();
        let line = Line { bus, clock, to_master: VecDeque::new(), cut: None, silent: false };
        Self { line: Rc::new(RefCell::new(line)), stop: Stop::new().unwrap() }
    }

    /// A master that has taken the drive.
    pub(super) fn drive(&self) -> Drive<RigLink, ManualClock> {
        let clock = self.line.borrow().clock.clone();
        let settings = Settings::untimed(Address::from_octet(0), BaudRate::K500);
        let link = RigLink { line: Rc::clone(&self.line), stop: self.stop.clone() };
        let session = Session::new(link, clock, self.stop.clone(), settings).unwrap();
        Drive::take(session, Address::from_octet(DRIVE)).unwrap()
    }

    /// What the drive has.
    pub(super) fn value(&self, parameter: Parameter) -> i32 {
        let line = self.line.borrow();
        let device: &Device = line.bus.station(Address::from_octet(DRIVE)).unwrap();
        device.parameters().value(parameter)
    }

    /// What acts on the drive from now on.
    pub(super) fn set_inputs(&self, inputs: Inputs) {
        self.line.borrow_mut().set_inputs(inputs);
    }

    /// Whether its shaft turns.
    pub(super) fn turns(&self) -> bool {
        let line = self.line.borrow();
        let device: &Device = line.bus.station(Address::from_octet(DRIVE)).unwrap();
        device.drive().status().travelling
    }

    /// After `telegrams` more telegrams of the master this happens.
    pub(super) fn cut(&self, telegrams: usize, cut: Cut) {
        self.line.borrow_mut().cut = Some((telegrams, cut));
    }

    /// Whether the cut is still to come.
    pub(super) fn is_whole(&self) -> bool {
        self.line.borrow().cut.is_some()
    }
}

/// The master's end.
pub(super) struct RigLink {
    line: Rc<RefCell<Line>>,
    stop: Stop,
}

impl Line {
    fn set_inputs(&mut self, inputs: Inputs) {
        let now = self.clock.now();
        let set = |device: &mut Device| device.set_inputs(now, inputs);
        self.bus.with(Address::from_octet(DRIVE), set).unwrap();
    }

    fn drain(&mut self) {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        while let Some(octets) = self.bus.poll_transmit(self.clock.now(), &mut buf) {
            if !self.silent {
                self.to_master.extend(octets);
            }
        }
        while self.bus.poll_event().is_some() {}
    }
}

impl Link for RigLink {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        let mut line = self.line.borrow_mut();
        let count = buf.len().min(line.to_master.len());
        for (to, octet) in buf.iter_mut().zip(line.to_master.drain(..count)) {
            *to = octet;
        }
        Ok(if count == 0 { Received::Nothing } else { Received::Octets(count) })
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        let mut line = self.line.borrow_mut();
        match line.cut {
            Some((0, cut)) => {
                line.cut = None;
                match cut {
                    Cut::Stop => self.stop.request(),
                    Cut::Link => return Err(io::ErrorKind::NotConnected.into()),
                    Cut::Answers => line.silent = true,
                    Cut::Enable => line.set_inputs(Inputs::default().with_output_stage(false)),
                    Cut::Heat => line.set_inputs(Inputs::default().provoking(Fault::D)),
                }
            }
            Some((telegrams, cut)) => line.cut = Some((telegrams - 1, cut)),
            None => {}
        }
        let now = line.clock.now();
        line.bus.handle_bytes(now, telegram);
        line.drain();
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>, _: &Stop) -> io::Result<()> {
        let mut line = self.line.borrow_mut();
        let now = line.clock.now();
        let latest = now.saturating_add(timeout.unwrap_or_default());
        // Time goes on, if only a little.
        let due = line.bus.poll_timeout().unwrap_or(latest).min(latest);
        line.clock.advance_to(due.max(now.saturating_add(Duration::from_micros(10))));
        let now = line.clock.now();
        if line.bus.poll_timeout().is_some_and(|due| due <= now) {
            line.bus.handle_timeout(now);
        }
        line.drain();
        Ok(())
    }
}
