//! An emulated drive on a simulated line, and a master's link that can be cut off at any telegram.

use core::cell::Cell;
use core::time::Duration;
use std::io;
use std::rc::Rc;

use crate::bench::Port;
use crate::devices::ag03::drive::{Fault, Inputs};
use crate::devices::ag03::param::{Model, Parameter};
use crate::devices::ag03::profibus::{Config, Device};
use crate::host::{Clock, Link, Received, Stop};
use crate::master::{Drive, Session, Settings};
use crate::profibus::fdl::Address;
use crate::time::{BaudRate, Instant};

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

/// The test's view of the drive, and the master's end of the line.
#[derive(Clone)]
pub(super) struct Rig {
    port: Port,
    /// What happens after so many more telegrams.
    cut: Rc<Cell<Option<(usize, Cut)>>>,
    pub(super) stop: Stop,
}

impl Rig {
    /// A drive with its defaults.
    pub(super) fn new(model: Model) -> Self {
        let port = Port::new(BaudRate::K500);
        let config = Config { model, ..Config::new(Address::from_octet(DRIVE)) };
        port.line(|line| line.add_drive(config)).unwrap();
        Self { port, cut: Rc::default(), stop: Stop::new().unwrap() }
    }

    /// A master that has taken the drive.
    pub(super) fn drive(&self) -> Drive<Self, Port> {
        let settings = Settings::untimed(Address::from_octet(0), BaudRate::K500);
        let session = Session::new(self.clone(), self.port.clone(), self.stop.clone(), settings).unwrap();
        Drive::take(session, Address::from_octet(DRIVE)).unwrap()
    }

    /// What the drive has.
    pub(super) fn value(&self, parameter: Parameter) -> i32 {
        self.port.line(|line| line.device(DRIVE).unwrap().parameters().value(parameter))
    }

    /// What acts on the drive from now on.
    pub(super) fn set_inputs(&self, inputs: Inputs) {
        let set = |device: &mut Device, now| device.set_inputs(now, inputs);
        self.port.line(|line| line.with_station(DRIVE, set)).unwrap();
    }

    /// Whether its shaft turns.
    pub(super) fn turns(&self) -> bool {
        self.port.line(|line| line.device(DRIVE).unwrap().drive().status().travelling)
    }

    /// The time on the line.
    pub(super) fn now(&self) -> Instant {
        self.port.now()
    }

    /// After `telegrams` more telegrams of the master this happens.
    pub(super) fn cut(&self, telegrams: usize, cut: Cut) {
        self.cut.set(Some((telegrams, cut)));
    }

    /// Whether the cut is still to come.
    pub(super) fn is_whole(&self) -> bool {
        self.cut.get().is_some()
    }
}

impl Link for Rig {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        self.port.receive(buf)
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        let cut = self.cut.take();
        self.cut.set(cut.and_then(|(telegrams, cut)| Some((telegrams.checked_sub(1)?, cut))));
        match cut {
            Some((0, Cut::Stop)) => self.stop.request(),
            Some((0, Cut::Link)) => return Err(io::ErrorKind::NotConnected.into()),
            Some((0, Cut::Answers)) => {
                self.port.line(|line| line.inject(&["no-reply".parse().unwrap()])).unwrap();
            }
            Some((0, Cut::Enable)) => self.set_inputs(Inputs::default().with_output_stage(false)),
            Some((0, Cut::Heat)) => self.set_inputs(Inputs::default().provoking(Fault::D)),
            Some(_) | None => {}
        }
        self.port.send(telegram)
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        self.port.wait(timeout, stop)
    }
}
