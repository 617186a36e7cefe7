//! The way from the threads of HTTP to the thread of the bus, and what they find there.

use core::error::Error;
use std::boxed::Box;
use std::format;
use std::string::{String, ToString};
use std::sync::Arc;

use tokio::sync::{mpsc, oneshot};

use super::problem::Problem;
use crate::device::{Config, Device, Power};
use crate::fdl::Address;
use crate::host::link::fault::Faults;
use crate::host::{Bus, StateDir, StateDirError, Stop, StoredDevice};
use crate::time::Instant;

/// Requests that wait for the thread of the bus at most; more are refused.
const QUEUE: usize = 64;

/// Requests carried out at most before the line is looked at again.
const AT_ONCE: usize = 4;

/// What the panel may see and change, lent by the thread of the bus between two telegrams.
pub struct BusAccess<'a> {
    /// The time now.
    pub now: Instant,
    /// The bus.
    pub bus: &'a mut Bus,
    /// The faults on the line; `None`: the link has none.
    pub faults: Option<&'a mut Faults>,
    /// What a drive that is added is made of, but for address, model and gear.
    pub config: Config,
    /// Where a drive that is added keeps its EEPROM; `None`: in itself.
    pub state: Option<&'a StateDir>,
    /// Whether a drive that is added listens first whether its address is live ([`Bus::join`]).
    pub listen: bool,
}

impl BusAccess<'_> {
    /// The drive at `address`, stored or not. Stations that are no drives are not found.
    pub(super) fn drive(&self, address: Address) -> Option<&Device> {
        let stored = self.bus.station::<StoredDevice>(address).map(StoredDevice::device);
        stored.or_else(|| self.bus.station::<Device>(address))
    }

    /// Does something to the drive at `address`.
    ///
    /// # Errors
    /// 404 if there is none.
    pub(super) fn with_drive<R>(
        &mut self,
        address: Address,
        act: impl FnOnce(&mut Device) -> R,
    ) -> Result<R, Problem> {
        if self.bus.station::<Device>(address).is_some() {
            return self.bus.with(address, act).ok_or_else(|| self.no_drive(address));
        }
        let stored = self.bus.with(address, |stored: &mut StoredDevice| act(stored.device_mut()));
        stored.ok_or_else(|| self.no_drive(address))
    }

    /// Does something to the drive at `address` that may switch it on, where its DIP switches are read.
    ///
    /// # Errors
    /// 404 if there is none; 409 if it would be switched on at the address of another station. Nothing is changed then.
    pub(super) fn with_supply<R>(
        &mut self,
        address: Address,
        act: impl Fn(&mut Device) -> R,
    ) -> Result<R, Problem> {
        if let Some(device) = self.drive(address).filter(|device| device.power() == Power::Off) {
            let mut trial = device.clone();
            act(&mut trial);
            let wanted = trial.address();
            if wanted != address && self.bus.presence(wanted).is_some() {
                return Err(Problem::conflict(format!(
                    "the DIP switches say address {wanted}, which another station has; set them to a free one"
                )));
            }
        }
        self.with_drive(address, act)
    }

    /// The refusal of a drive whose image cannot be used, with the drive that has it now.
    pub(super) fn not_loaded(&self, error: &StateDirError) -> Problem {
        let StateDirError::Owned { path } = error else {
            return Problem::conflict(in_one_line(error));
        };
        let has_it = |address: &Address| {
            self.bus.station::<StoredDevice>(*address).and_then(StoredDevice::path).as_ref() == Some(path)
        };
        match self.bus.addresses().find(has_it) {
            Some(address) => Problem::conflict(format!(
                "the EEPROM image {} belongs to the drive at address {address}, which was added under this address and \
                 moved by its DIP switches; move it back or remove it, or choose another address",
                path.display()
            )),
            None => Problem::conflict(in_one_line(error)),
        }
    }

    /// The refusal that says which drives there are.
    pub(super) fn no_drive(&self, address: Address) -> Problem {
        Problem::no_drive(address, self.bus.addresses().filter(|address| self.drive(*address).is_some()))
    }
}

/// An error and its causes.
fn in_one_line(error: &dyn Error) -> String {
    let mut line = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        line = format!("{line}: {error}");
        cause = error.source();
    }
    line
}

/// Something to do on the thread of the bus.
type Request = Box<dyn FnOnce(&mut BusAccess<'_>) + Send>;

/// The end of the queue at the thread of the bus.
#[derive(Debug)]
pub(super) struct Requests {
    waiting: mpsc::Receiver<Request>,
    wake: Stop,
}

impl Requests {
    /// Carries out some of what waits. If more waits, the next run of the bus ends at once.
    pub(super) fn serve(&mut self, bench: &mut BusAccess<'_>) {
        for _ in 0..AT_ONCE {
            match self.waiting.try_recv() {
                Ok(request) => request(bench),
                Err(_) => return,
            }
        }
        if !self.waiting.is_empty() {
            self.wake.request();
        }
    }
}

/// The end of the queue at the threads of HTTP.
#[derive(Clone, Debug)]
pub(super) struct Asking {
    queue: mpsc::Sender<Request>,
    wake: Arc<Stop>,
}

/// A queue whose requests end a run of the bus by `wake`.
pub(super) fn queue(wake: Stop) -> (Asking, Requests) {
    let (queue, waiting) = mpsc::channel(QUEUE);
    (Asking { queue, wake: Arc::new(wake.clone()) }, Requests { waiting, wake })
}

impl Asking {
    /// Has `act` done on the thread of the bus, between two telegrams, and says what came of it. `act` must be quick.
    ///
    /// # Errors
    /// 503 if the bus has ended, or has no time.
    pub(super) async fn ask<R: Send + 'static>(
        &self,
        act: impl FnOnce(&mut BusAccess<'_>) -> R + Send + 'static,
    ) -> Result<R, Problem> {
        let (answer, answered) = oneshot::channel();
        let request: Request = Box::new(move |bench| {
            // Whoever asked may have gone.
            let _ = answer.send(act(bench));
        });
        self.queue.try_send(request).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => Problem::busy(),
            mpsc::error::TrySendError::Closed(_) => Problem::ended(),
        })?;
        self.wake.request();
        answered.await.map_err(|_| Problem::ended())
    }

    /// Has the thread of the bus come by, without anything to do.
    pub(super) fn wake(&self) {
        self.wake.request();
    }

    /// Whether the thread of the bus is gone.
    pub(super) fn has_ended(&self) -> bool {
        self.queue.is_closed()
    }
}
