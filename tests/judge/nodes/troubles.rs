//! Nodes that hang, reset, come late or talk by themselves, and buses that end: each ends in a verdict, and none is green.

use std::io;
use std::time::Duration;

use profidrive::can_bus::can::{BitRate, Frame};
use profidrive::devices::CanopenEvent;
use profidrive::host::can::{CanEndpoint, StoredNode};
use profidrive::host::{Clock as _, Stop};
use profidrive::judge::device::Ending;
use profidrive::judge::device::node::{Live, Port, Report, Row, live};
use profidrive::judge::{Outcome, Requirement as _};
use profidrive::time::Instant;

use super::wrong::{answer, base, data};
use super::{accused, of_file, setup, sheet};

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trouble {
    /// It hears nothing any more.
    Hangs,
    /// It sends without end.
    Babbles,
    /// A TPDO each 20 ms, in each state.
    Talks,
    /// It is reset, by whatever.
    Resets,
    /// Each SDO is refused.
    Refuses,
    /// Each SDO is a write that was taken.
    Takes,
    /// Whatever is sent is heard again.
    Echoes,
    /// The bus can no longer be reached.
    Closes,
    /// Somebody stops the judgement.
    Stops,
}

/// A bus on which something happens with one of the frames.
struct Troubled {
    port: Port<CanopenEvent>,
    trouble: Trouble,
    /// From this frame on.
    from: u32,
    sent: u32,
    /// What is heard in place of the node.
    heard: Option<Frame>,
    talks: Instant,
    stop: Stop,
}

impl Troubled {
    fn has_begun(&self, trouble: Trouble) -> bool {
        self.trouble == trouble && self.sent >= self.from
    }
}

impl CanEndpoint for Troubled {
    fn send(&mut self, frame: &Frame) -> io::Result<()> {
        self.sent += 1;
        if self.sent < self.from {
            return self.port.send(frame);
        }
        let is_sdo = frame.id() == base(0x605) && frame.octets().len() == 8;
        match self.trouble {
            Trouble::Hangs | Trouble::Babbles => return Ok(()),
            Trouble::Closes => return Err(io::ErrorKind::BrokenPipe.into()),
            Trouble::Stops => self.stop.request(),
            Trouble::Resets if self.sent.is_multiple_of(self.from) => {
                self.port.send(&data(0, &[0x81, super::NODE]))?;
            }
            Trouble::Echoes => {
                self.heard = Some(*frame);
                return Ok(());
            }
            Trouble::Refuses | Trouble::Takes => {
                let octets = frame.octets();
                let command = if self.trouble == Trouble::Takes { 0x60 } else { 0x80 };
                if is_sdo {
                    self.heard = Some(answer([command, octets[1], octets[2], octets[3], 0, 0, 0, 8]));
                }
                return Ok(());
            }
            Trouble::Talks | Trouble::Resets => {}
        }
        self.port.send(frame)
    }

    fn receive(&mut self) -> io::Result<Option<Frame>> {
        if self.has_begun(Trouble::Closes) {
            return Err(io::ErrorKind::ConnectionReset.into());
        }
        if self.has_begun(Trouble::Babbles) {
            return Ok(Some(data(0x3F5, &[1])));
        }
        if self.has_begun(Trouble::Talks) && self.port.now() >= self.talks {
            self.talks = self.port.now().saturating_add(Duration::from_millis(20));
            return Ok(Some(data(0x185, &[0; 3])));
        }
        match self.heard.take() {
            Some(frame) => Ok(Some(frame)),
            None => self.port.receive(),
        }
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        if !self.has_begun(Trouble::Talks) {
            return self.port.wait(timeout, stop);
        }
        let left = self.talks.saturating_since(self.port.now());
        self.port.wait(Some(timeout.map_or(left, |timeout| timeout.min(left))), stop)
    }
}

fn troubled(trouble: Trouble, from: u32) -> Report {
    let port: Port<CanopenEvent> = Port::new(BitRate::K500);
    port.bus(|bus, now| bus.add(now, Box::new(StoredNode::new(of_file("complete.eds"), now))));
    let stop = Stop::new().unwrap();
    let endpoint = Troubled {
        port: port.clone(),
        trouble,
        from,
        sent: 0,
        heard: None,
        talks: Instant::ZERO,
        stop: stop.clone(),
    };
    let bus = Live { endpoint: Box::new(endpoint), clock: Box::new(port.clone()), stop };
    let report = live(setup(sheet("complete.eds")), &Row::all(), bus, None, &mut |_| ());
    assert!(port.now() < Instant::from_millis(2_000_000), "{trouble:?} {from}: {report}");
    report
}

/// With the first frames, in the middle, near the end.
const WHEN: [u32; 10] = [1, 2, 3, 4, 5, 10, 30, 100, 300, 1000];

#[test]
fn whoever_hangs_or_babbles_is_never_green_however_late() {
    for trouble in [Trouble::Hangs, Trouble::Babbles, Trouble::Refuses, Trouble::Takes, Trouble::Echoes] {
        for from in WHEN {
            let report = troubled(trouble, from);
            assert!([1, 3, 4].contains(&report.outcome().status()), "{trouble:?} {from}: {report}");
        }
    }
    let report = troubled(Trouble::Hangs, 2);
    assert_eq!(report.outcome().status(), 3, "{report}");
}

#[test]
fn whoever_resets_or_talks_by_itself_is_found() {
    for trouble in [Trouble::Resets, Trouble::Talks] {
        for from in [20, 300] {
            let report = troubled(trouble, from);
            assert_eq!(report.outcome(), Outcome::Failed, "{trouble:?} {from}: {report}");
        }
    }
}

#[test]
fn a_bus_that_ends_and_a_judgement_that_is_stopped_accuse_nobody() {
    for from in WHEN {
        let closed = troubled(Trouble::Closes, from);
        assert!(matches!(closed.ending, Ending::Broken { .. }), "{from}: {closed}");
        let stopped = troubled(Trouble::Stops, from);
        assert_eq!(stopped.ending, Ending::Stopped, "{from}: {stopped}");
        for report in [closed, stopped] {
            assert!(matches!(report.outcome(), Outcome::NotFinished(_)), "{from}: {report}");
            assert!(accused(&report).is_empty(), "{from}: {report}");
        }
    }
}

#[test]
fn rows_that_do_not_apply_are_no_verdict() {
    let judged = |only| {
        let factory = Box::new(|| of_file("complete.eds"));
        super::judged(factory, setup(sheet("complete.eds")), &Row::matching(only))
    };
    // It is no drive.
    for only in ["N-D*", "N-K07"] {
        let report = judged(only);
        assert_eq!(report.outcome(), Outcome::NotFinished("no row was judged".into()), "{only}: {report}");
    }
}
