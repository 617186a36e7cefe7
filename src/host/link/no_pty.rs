//! Systems without pseudo-terminals whose masters can be watched: all but Linux.

use core::time::Duration;
use std::io;
use std::path::Path;

use super::Sleep;

use crate::host::{Error, Link, Received, Stop};

const INSTEAD: &str = "pseudo-terminals are for Linux only; use a TCP port (tcp:127.0.0.1:0, of CAN slcan-tcp:127.0.0.1:0), or a serial \
                       port, on Windows one of a pair of com0com; see docs/platforms.md";

/// A pseudo-terminal, of which there is never one here.
#[derive(Debug)]
pub enum Pty {}

impl Pty {
    /// Fails.
    ///
    /// # Errors
    /// [`Error::Pty`], always.
    pub fn open(_: Option<&Path>) -> Result<Self, Error> {
        Err(Error::Pty { source: io::Error::new(io::ErrorKind::Unsupported, INSTEAD) })
    }

    /// Fails.
    ///
    /// # Errors
    /// [`Error::Pty`], always.
    pub fn open_replacing(path: Option<&Path>) -> Result<Self, Error> {
        Self::open(path)
    }

    /// Never called: there is no `Pty`.
    pub fn follow_rate(&mut self, _: bool) {
        match *self {}
    }

    /// Never called: there is no `Pty`.
    pub fn path(&self) -> &Path {
        match *self {}
    }

    /// Never called: there is no `Pty`.
    pub fn lost(&self) -> u64 {
        match *self {}
    }

    pub(in crate::host) fn discard_output(&self) -> io::Result<()> {
        match *self {}
    }

    pub(in crate::host) fn write(&mut self, _: &[u8]) -> io::Result<Option<usize>> {
        match *self {}
    }

    pub(in crate::host) fn watch<'a>(&'a self, _: bool, _: bool, _: &mut Sleep<'a>) {
        match *self {}
    }

    pub(in crate::host) fn patience(&mut self) -> Option<Duration> {
        match *self {}
    }
}

impl Link for Pty {
    fn receive(&mut self, _: &mut [u8]) -> io::Result<Received> {
        match *self {}
    }

    fn send(&mut self, _: &[u8]) -> io::Result<()> {
        match *self {}
    }

    fn wait(&mut self, _: Option<Duration>, _: &Stop) -> io::Result<()> {
        match *self {}
    }
}
