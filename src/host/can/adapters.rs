//! The adapters through which masters reach the bus: one at a pseudo-terminal, or one for each connection at a TCP port.

use core::net::SocketAddr;
use std::io;
use std::net::TcpListener;
use std::path::PathBuf;

use rustix::event::{PollFd, PollFlags};

use super::Bus;
use super::line::News;
use crate::host::link::{Look, Sleep};
use crate::host::reach::{ListenError, Reach, listen};
use crate::host::{Error, Stop};
use crate::time::Instant;

mod adapter;
mod stream;

use adapter::Adapter;
use stream::Stream;

/// A loop asks twice in a turn: for what has come, and whether that was all.
const IN_TURN: u8 = 2;

/// How many connections there can be at a time.
const MAX_ADAPTERS: usize = 32;

/// After the operating system could not accept a connection.
const ACCEPT_PAUSE: core::time::Duration = core::time::Duration::from_secs(1);

/// Every adapter of a bus.
pub(super) struct Adapters {
    port: Option<Port>,
    /// What a master opens.
    name: String,
    adapters: Vec<Adapter>,
}

struct Port {
    listener: TcpListener,
    knocks: Look,
    /// No connection is accepted until then.
    pause: Option<Instant>,
}

impl Adapters {
    /// One adapter at a pseudo-terminal.
    pub(super) fn at_pty<E: 'static>(
        path: Option<&PathBuf>,
        bus: &mut Bus<E>,
        now: Instant,
    ) -> Result<Self, Error> {
        let pty = crate::host::link::pty::Pty::open_replacing(path.map(|path| &**path))?;
        let name = pty.path().display().to_string();
        let adapter = Adapter::new(Stream::Pty(Box::new(pty)), name.clone(), bus, now);
        Ok(Self { port: None, name, adapters: Vec::from([adapter]) })
    }

    /// An adapter for each connection at `place`.
    pub(super) fn at_tcp(place: &str, reach: Reach) -> Result<Self, Error> {
        let (listener, address) = listen(place, reach).map_err(|error| match error {
            ListenError::Failed(source) => Error::Tcp { place: place.into(), source },
            ListenError::TooFar(address) => Error::TcpReach { place: place.into(), address },
        })?;
        let port = Some(Port { listener, knocks: Look::new(IN_TURN), pause: None });
        Ok(Self { port, name: format!("slcan-tcp:{address}"), adapters: Vec::new() })
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Takes in new masters, and what masters have sent. True if there may be more at once.
    pub(super) fn read<E: 'static>(
        &mut self,
        bus: &mut Bus<E>,
        now: Instant,
        on_news: &mut dyn FnMut(News<E>),
    ) -> io::Result<bool> {
        self.accept(bus, now);
        let mut more = false;
        for adapter in &mut self.adapters {
            more |= adapter.read(bus, now, on_news)?;
        }
        Ok(more)
    }

    /// Hands out what the bus has for masters, and lets those go that have left.
    pub(super) fn write<E: 'static>(&mut self, bus: &mut Bus<E>, now: Instant) -> io::Result<()> {
        for adapter in &mut self.adapters {
            adapter.write(bus, now)?;
        }
        self.adapters.retain(|adapter| {
            let gone = adapter.is_gone(bus);
            if gone {
                bus.remove(now, adapter.seat());
                tracing::info!(
                    "slcan: {} has closed its connection, {} frames were not read",
                    adapter.name(),
                    adapter.dropped()
                );
            }
            !gone
        });
        Ok(())
    }

    /// Sleeps until a master sends something, comes, leaves or reads, or until a stop or `latest`.
    pub(super) fn wait<E: 'static>(
        &mut self,
        bus: &Bus<E>,
        now: Instant,
        latest: Option<Instant>,
        stop: &Stop,
    ) -> io::Result<()> {
        let pause = self.port.as_ref().and_then(|port| port.pause);
        let held = self.adapters.iter().filter_map(Adapter::held_until).min();
        let until = [bus.poll_noticed(), pause, held, latest].into_iter().flatten().min();
        let patience = self.adapters.iter_mut().filter_map(Adapter::patience).min();
        let timeout = until.map(|until| until.saturating_since(now)).into_iter().chain(patience).min();
        let mut sleep = Sleep::until(stop);
        if let Some(Port { listener, knocks, pause: None }) = &self.port {
            sleep.or(PollFd::new(listener, PollFlags::IN), knocks);
        }
        for adapter in &self.adapters {
            adapter.watch(bus, &mut sleep);
        }
        sleep.sleep(timeout)
    }

    fn accept<E: 'static>(&mut self, bus: &mut Bus<E>, now: Instant) {
        let Some(port) = &mut self.port else { return };
        if port.pause.is_some_and(|pause| now < pause) {
            return;
        }
        port.pause = None;
        if !port.knocks.asks() {
            return;
        }
        loop {
            let (stream, peer): (_, SocketAddr) = match port.listener.accept() {
                Ok(accepted) => accepted,
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    port.knocks.is_empty();
                    return;
                }
                // That one has gone again.
                Err(error) if error.kind() == io::ErrorKind::ConnectionAborted => continue,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => {
                    tracing::warn!("slcan: cannot accept a connection: {error}");
                    port.pause = Some(now.saturating_add(ACCEPT_PAUSE));
                    return;
                }
            };
            if self.adapters.len() >= MAX_ADAPTERS {
                tracing::warn!("slcan: {peer} is refused: {MAX_ADAPTERS} masters are connected");
                continue;
            }
            match Stream::tcp(stream) {
                Ok(stream) => {
                    tracing::info!("slcan: {peer} connected");
                    self.adapters.push(Adapter::new(stream, peer.to_string(), bus, now));
                }
                Err(error) => tracing::warn!("slcan: {peer} is refused: {error}"),
            }
        }
    }
}
