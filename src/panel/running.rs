//! The thread of HTTP.

use core::net::SocketAddr;
use std::io;
use std::thread::{self, JoinHandle};

use axum::Router;
use tokio::runtime;
use tokio::sync::oneshot;

use super::server::{self, Names};
use crate::host::Reach;
use crate::host::reach::{ListenError, listen};

/// A thread that serves HTTP. Dropped, it closes its port and every connection.
#[derive(Debug)]
pub(crate) struct Running {
    address: SocketAddr,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// Where a thread of HTTP listens, and what it is called in the log.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<'a> {
    pub(crate) name: &'static str,
    /// `HOST:PORT`.
    pub(crate) place: &'a str,
    pub(crate) reach: Reach,
    pub(crate) names: Names,
}

/// Why a thread of HTTP cannot be started.
#[derive(Debug)]
pub(crate) enum StartError {
    Listen(ListenError),
    Thread(io::Error),
}

/// How much this thread steps back (`nice`).
#[cfg(target_os = "linux")]
const STEP_BACK: i32 = 10;

impl Running {
    /// Listens and serves; `beside` runs on the same thread.
    pub(crate) fn start(
        at: Place<'_>,
        router: Router,
        beside: impl Future<Output = ()> + Send + 'static,
    ) -> Result<Self, StartError> {
        let Place { name, place, reach, names } = at;
        let (listener, address) = listen(place, reach).map_err(StartError::Listen)?;
        let failed = StartError::Thread;
        let runtime = runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
        let (end, ended) = oneshot::channel();
        let serve = move || {
            yield_to_the_bus();
            let served = runtime.block_on(async {
                tokio::spawn(beside);
                server::serve(listener, (reach, names), router, ended).await
            });
            if let Err(error) = served {
                tracing::warn!("{name}: {error}");
            }
        };
        let thread = thread::Builder::new().name(name.into()).spawn(serve).map_err(failed)?;
        Ok(Self { address, end: Some(end), thread: Some(thread) })
    }

    pub(crate) const fn address(&self) -> SocketAddr {
        self.address
    }
}

/// Where both want a processor, the bus has it first: on Linux a thread has a priority of its own.
fn yield_to_the_bus() {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(Some(rustix::thread::gettid()), STEP_BACK);
}

impl Drop for Running {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            // It has nothing to wait for.
            let _ = thread.join();
        }
    }
}
