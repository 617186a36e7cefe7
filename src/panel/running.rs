//! The thread of HTTP.

use core::net::SocketAddr;
use std::string::ToString;
use std::thread::{self, JoinHandle};

use axum::Router;
use tokio::runtime;
use tokio::sync::oneshot;

use super::{PanelError, server};
use crate::host::Reach;
use crate::host::reach::{ListenError, listen};

/// A thread that serves HTTP. Dropped, it closes its port and every connection.
#[derive(Debug)]
pub(super) struct Running {
    address: SocketAddr,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// How much this thread steps back (`nice`).
#[cfg(target_os = "linux")]
const STEP_BACK: i32 = 10;

impl Running {
    /// Listens at `place` and serves; `beside` runs on the same thread.
    pub(super) fn start(
        place: &str,
        reach: Reach,
        router: Router,
        beside: impl Future<Output = ()> + Send + 'static,
    ) -> Result<Self, PanelError> {
        let (listener, address) = listen(place, reach).map_err(|error| match error {
            ListenError::Failed(source) => PanelError::Listen { place: place.to_string(), source },
            ListenError::TooFar(address) => PanelError::TooFar { place: place.to_string(), address },
        })?;
        let failed = |source| PanelError::Thread { source };
        let runtime = runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
        let (end, ended) = oneshot::channel();
        let serve = move || {
            yield_to_the_bus();
            let served = runtime.block_on(async {
                tokio::spawn(beside);
                server::serve(listener, reach, router, ended).await
            });
            if let Err(error) = served {
                tracing::warn!("panel: {error}");
            }
        };
        let thread = thread::Builder::new().name("panel".into()).spawn(serve).map_err(failed)?;
        Ok(Self { address, end: Some(end), thread: Some(thread) })
    }

    pub(super) const fn address(&self) -> SocketAddr {
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
