//! The way from the threads of HTTP to the thread of a bus.

use core::fmt::Debug;
use std::sync::Arc;

use tokio::sync::{mpsc, oneshot};

use super::problem::Problem;
use crate::host::Stop;

/// Requests that wait for the thread of the bus at most; more are refused.
const QUEUE: usize = 64;

/// Requests carried out at most before the line is looked at again.
const AT_ONCE: usize = 4;

/// The thread of a bus, by what it lends between two telegrams.
pub(crate) trait Lends: Copy + Debug + 'static {
    /// What it lends.
    type Access<'a>: ?Sized;
}

/// Something to do on the thread of the bus.
type Request<L> = Box<dyn FnOnce(&mut <L as Lends>::Access<'_>) + Send>;

/// The end of the queue at the thread of the bus.
#[derive(Debug)]
pub(crate) struct Requests<L: Lends> {
    waiting: mpsc::Receiver<Request<L>>,
    wake: Stop,
}

impl<L: Lends> Requests<L> {
    /// Carries out some of what waits. If more waits, the next run of the bus ends at once.
    pub(crate) fn serve(&mut self, lent: &mut L::Access<'_>) {
        for _ in 0..AT_ONCE {
            match self.waiting.try_recv() {
                Ok(request) => request(lent),
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
pub(crate) struct Asking<L: Lends> {
    queue: mpsc::Sender<Request<L>>,
    wake: Arc<Stop>,
}

/// A queue whose requests end a run of the bus by `wake`.
pub(crate) fn queue<L: Lends>(wake: Stop) -> (Asking<L>, Requests<L>) {
    let (queue, waiting) = mpsc::channel(QUEUE);
    (Asking { queue, wake: Arc::new(wake.clone()) }, Requests { waiting, wake })
}

impl<L: Lends> Asking<L> {
    /// Has `act` done on the thread of the bus, between two telegrams, and says what came of it. `act` must be quick.
    ///
    /// # Errors
    /// 503 if the bus has ended, or has no time.
    pub(crate) async fn ask<R: Send + 'static>(
        &self,
        act: impl FnOnce(&mut L::Access<'_>) -> R + Send + 'static,
    ) -> Result<R, Problem> {
        let (answer, answered) = oneshot::channel();
        let request: Request<L> = Box::new(move |lent| {
            // Whoever asked may have gone.
            let _ = answer.send(act(lent));
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
    pub(crate) fn has_ended(&self) -> bool {
        self.queue.is_closed()
    }
}
