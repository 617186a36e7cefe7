//! The bus to the node: frames out, frames in until a time.

use core::fmt;
use core::time::Duration;

use crate::can_bus::can::Frame;
use crate::host::can::CanEndpoint;
use crate::host::{Clock, Stop};
use crate::judge::device::Ending;
use crate::judge::device::course::{Course, Halt};
use crate::time::Instant;

/// A frame that passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Passed {
    pub(super) at: Instant,
    pub(super) ours: bool,
    pub(super) frame: Frame,
}

/// A device that sends so many frames in a second that nobody asked for has no other end.
const MOST_UNASKED: u32 = 1500;
/// So many frames may answer one.
const EACH_ASKS: u32 = 4;
/// Frames that are kept to be shown at most.
const KEPT: usize = 256;

pub(super) struct Wire {
    endpoint: Box<dyn CanEndpoint>,
    clock: Box<dyn Clock>,
    stop: Stop,
    /// The judgement ends then.
    end: Option<Instant>,
    /// How much later than on the bus frames are seen.
    pub(super) latency: Duration,
    passed: Vec<Passed>,
    /// Frames heard and sent in the second that began then.
    second: (Instant, u32, u32),
}

impl fmt::Debug for Wire {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Wire").field("latency", &self.latency).finish_non_exhaustive()
    }
}

impl Wire {
    pub(super) fn new(
        endpoint: Box<dyn CanEndpoint>,
        clock: Box<dyn Clock>,
        stop: Stop,
        latency: Duration,
        limit: Option<Duration>,
    ) -> Self {
        let begun = clock.now();
        let (second, end) = ((begun, 0, 0), limit.map(|limit| begun.saturating_add(limit)));
        Self { endpoint, clock, stop, end, latency, passed: Vec::new(), second }
    }

    pub(super) fn now(&self) -> Instant {
        self.clock.now()
    }

    /// Why nothing more may be tried.
    pub(super) fn must_end(&self) -> Option<Ending> {
        if self.stop.is_requested() {
            return Some(Ending::Stopped);
        }
        self.end.filter(|end| self.now() >= *end).map(|_| Ending::TimeOver)
    }

    pub(super) fn take_passed(&mut self) -> Vec<Passed> {
        core::mem::take(&mut self.passed)
    }

    /// The last so many frames, which stay.
    pub(super) fn last_passed(&self, count: usize) -> &[Passed] {
        self.passed.get(self.passed.len().saturating_sub(count)..).unwrap_or_default()
    }

    pub(super) fn send(&mut self, frame: Frame) -> Course {
        self.endpoint.send(&frame).map_err(failed)?;
        self.second.2 += 1;
        self.keep(Passed { at: self.now(), ours: true, frame });
        Ok(())
    }

    /// The next frame of somebody else, if it comes before `until`.
    pub(super) fn hear(&mut self, until: Instant) -> Course<Option<Passed>> {
        loop {
            if let Some(frame) = self.endpoint.receive().map_err(failed)? {
                let passed = Passed { at: self.now(), ours: false, frame };
                self.count(passed.at)?;
                self.keep(passed);
                return Ok(Some(passed));
            }
            if let Some(ending) = self.must_end() {
                return Err(Halt::Over(ending));
            }
            let now = self.now();
            if now >= until {
                return Ok(None);
            }
            self.endpoint.wait(Some(until.saturating_since(now)), &self.stop).map_err(failed)?;
        }
    }

    /// So many frames were asked for by one: the segments of a block.
    pub(super) fn awaits(&mut self, frames: u8) {
        self.second.2 += u32::from(frames).div_ceil(EACH_ASKS);
    }

    fn keep(&mut self, passed: Passed) {
        if self.passed.len() >= 2 * KEPT {
            self.passed.drain(..KEPT);
        }
        self.passed.push(passed);
    }

    fn count(&mut self, now: Instant) -> Course {
        let (since, heard, sent) = &mut self.second;
        if now.saturating_since(*since) >= Duration::from_secs(1) {
            (*since, *heard, *sent) = (now, 0, 0);
        }
        *heard += 1;
        if *heard > MOST_UNASKED + EACH_ASKS * *sent {
            return Err(Halt::Over(Ending::Babbles { during: "" }));
        }
        Ok(())
    }
}

fn failed(error: std::io::Error) -> Halt {
    Halt::Over(Ending::Broken { why: error.to_string() })
}
