//! Slaves that hang, reset, come late or talk by themselves, and lines that end: each ends in a verdict, and none is green.

use std::io;
use std::time::Duration;

use profidrive::host::{Clock as _, Link, Received, Stop};
use profidrive::judge::device::slave::{Report, Row, live};
use profidrive::judge::device::{Attendant as _, Ending};
use profidrive::judge::{Outcome, Requirement as _};

use super::broken;
use super::rig::{Mistake, RIGHT, Rig, judged, setup};

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trouble {
    /// It hears nothing any more.
    Hangs,
    /// It is switched off and on, by whatever.
    Resets,
    /// It sends without end.
    Babbles,
    /// It sends an octet in each silence.
    Talks,
    /// Whatever is asked is answered with SC.
    Acknowledges,
    /// Whatever is sent is heard again, as by an adapter with an echo and nobody behind it.
    Echoes,
    /// The line ends.
    Closes,
    /// Somebody stops the judgement.
    Stops,
}

/// A line on which something happens with one of the requests.
struct Troubled {
    rig: Rig,
    trouble: Trouble,
    /// From this request on.
    from: u32,
    sent: u32,
    /// What is heard in place of the slave.
    heard: Vec<u8>,
    stop: Stop,
}

impl Troubled {
    fn has_begun(&self, trouble: Trouble) -> bool {
        self.trouble == trouble && self.sent >= self.from
    }
}

impl Link for Troubled {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        if self.has_begun(Trouble::Closes) {
            return Err(io::ErrorKind::ConnectionReset.into());
        }
        if self.has_begun(Trouble::Babbles) {
            buf[..8].fill(0x55);
            return Ok(Received::Octets(8));
        }
        if self.heard.is_empty() {
            return self.rig.receive(buf);
        }
        let len = self.heard.len();
        buf[..len].copy_from_slice(&self.heard);
        self.heard.clear();
        Ok(Received::Octets(len))
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        self.sent += 1;
        if self.sent < self.from {
            return self.rig.send(telegram);
        }
        match self.trouble {
            Trouble::Hangs | Trouble::Babbles => Ok(()),
            Trouble::Acknowledges => {
                self.heard = vec![0xE5];
                Ok(())
            }
            Trouble::Echoes => {
                self.heard = telegram.to_vec();
                Ok(())
            }
            Trouble::Closes => Err(io::ErrorKind::BrokenPipe.into()),
            Trouble::Resets => {
                if self.sent.is_multiple_of(self.from) {
                    self.rig.act("power-cycle");
                }
                self.rig.send(telegram)
            }
            Trouble::Stops => {
                self.stop.request();
                self.rig.send(telegram)
            }
            Trouble::Talks => self.rig.send(telegram),
        }
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        if self.has_begun(Trouble::Talks) && timeout.is_some_and(|time| time > Duration::from_millis(2)) {
            let after = Some(Duration::from_millis(1));
            self.heard = vec![0xFF];
            return self.rig.wait(after, stop);
        }
        self.rig.wait(timeout, stop)
    }
}

fn troubled(trouble: Trouble, from: u32) -> Report {
    let rig = Rig::new(&RIGHT);
    let stop = Stop::new().unwrap();
    let line = Troubled { rig: rig.clone(), trouble, from, sent: 0, heard: Vec::new(), stop: stop.clone() };
    let report = live(setup(&RIGHT), &Row::all(), rig.line(line, stop), None, &mut |_| ());
    // An hour is the limit: nothing came near it.
    assert!(rig.now().as_nanos() < 2_000_000_000_000, "{trouble:?} {from}: {report}");
    report
}

/// With the first requests, in the middle, near the end.
const WHEN: [u32; 12] = [1, 2, 3, 4, 5, 6, 10, 30, 100, 300, 1000, 1900];

#[test]
fn whoever_hangs_or_babbles_is_never_green_however_late() {
    for trouble in [Trouble::Hangs, Trouble::Babbles, Trouble::Acknowledges, Trouble::Echoes] {
        for from in WHEN {
            let report = troubled(trouble, from);
            let status = report.outcome().status();
            assert!([1, 3, 4].contains(&status), "{trouble:?} {from}: {report}");
            assert_ne!(report.ending, Ending::Done, "{trouble:?} {from}: {report}");
        }
    }
    let report = troubled(Trouble::Hangs, 2);
    assert_eq!(report.outcome().status(), 3, "{report}");
    assert!(report.ending.to_string().contains("it answered, and then said nothing more"), "{report}");
}

#[test]
fn whoever_resets_or_talks_by_itself_is_found() {
    for from in [3, 40, 500] {
        for trouble in [Trouble::Resets, Trouble::Talks] {
            let report = troubled(trouble, from);
            assert!([1, 3].contains(&report.outcome().status()), "{trouble:?} {from}: {report}");
            assert!(!broken(&report).is_empty() || from == 3, "{trouble:?} {from}: {report}");
        }
    }
}

#[test]
fn a_line_that_ends_and_a_judgement_that_is_stopped_accuse_nobody() {
    for from in WHEN {
        let closed = troubled(Trouble::Closes, from);
        assert!(matches!(closed.ending, Ending::Broken { .. }), "{from}: {closed}");
        let stopped = troubled(Trouble::Stops, from);
        assert_eq!(stopped.ending, Ending::Stopped, "{from}: {stopped}");
        for report in [closed, stopped] {
            assert!(matches!(report.outcome(), Outcome::NotFinished(_)), "{from}: {report}");
            assert!(broken(&report).is_empty(), "{from}: {report}");
        }
    }
}

#[test]
fn whoever_answers_late_is_found() {
    static LATE: [Mistake; 4] = [
        Mistake { late: |_| Duration::from_millis(1), ..RIGHT },
        Mistake { late: |_| Duration::from_millis(2), ..RIGHT },
        Mistake { late: |_| Duration::from_millis(10), ..RIGHT },
        Mistake { late: |_| Duration::from_millis(300), ..RIGHT },
    ];
    for (number, late) in LATE.iter().enumerate() {
        let report = judged(late, &Row::all());
        assert!([1, 3].contains(&report.outcome().status()), "{number}: {report}");
    }
}

#[test]
fn rows_that_do_not_apply_are_no_verdict() {
    // A slave of DP-V0, and rows of drives and of DP-V1.
    for only in ["P-*", "V1-R2*", "S-F06"] {
        let report = judged(&RIGHT, &Row::matching(only));
        assert_eq!(report.outcome(), Outcome::NotFinished("no row was judged".into()), "{only}: {report}");
    }
    let report = judged(&RIGHT, &[]);
    assert_eq!(report.outcome().status(), 4, "{report}");
}
