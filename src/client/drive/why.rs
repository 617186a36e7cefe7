//! What a drive shows that keeps it from moving, and the control words to send, as a master sees it.

use core::fmt;

use super::goal::Goal;
use super::obstacle::{Findings, Obstacle, Obstacles};
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::profibus::bits::ZswBit;
use crate::devices::ag03::profibus::flow_charts;

/// What keeps a drive from moving, as far as its words and parameters show it.
///
/// `Display` is one line: every obstacle, then the control words that help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Why {
    obstacles: Obstacles,
}

impl Findings {
    /// What of this keeps the drive from moving, in the mode it is in.
    pub(crate) const fn why(self) -> Why {
        let goal = match self.mode {
            Some(Mode::Velocity) => Goal::Velocity(0),
            Some(Mode::Positioning) | None => Goal::Inch,
        };
        Why { obstacles: Obstacles { goal, waited: None, findings: self } }
    }
}

impl Why {
    /// Every obstacle, the most important first. None: it moves, or waits for a start.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Obstacle> {
        self.obstacles.iter().filter(|obstacle| !is_motion(*obstacle))
    }

    /// One of them in words: what, where it shows, and what to do about it.
    pub(crate) const fn text(&self, obstacle: Obstacle) -> impl fmt::Display + use<> {
        self.obstacles.text(obstacle)
    }

    /// The control words to send one after the other; `None`: no control word helps before the obstacles are removed.
    pub(crate) fn next(&self) -> Option<impl fmt::Display + use<>> {
        let helps = self.iter().all(|obstacle| {
            matches!(obstacle, Obstacle::Fault | Obstacle::TurnOnDisabled | Obstacle::NotEnabled)
        });
        let zsw = self.obstacles.findings.zsw.filter(|_| helps)?;
        let fault = ZswBit::Fault.is_set(zsw);
        let off1 = fault || ZswBit::TurnOnDisabled.is_set(zsw);
        let enabled = ZswBit::OperationEnabled.is_set(zsw);
        let velocity = self.obstacles.findings.mode == Some(Mode::Velocity);
        Some(Next { fault, off1, enabled, velocity })
    }
}

/// A drive that moves has nothing in its way.
const fn is_motion(obstacle: Obstacle) -> bool {
    matches!(obstacle, Obstacle::PositioningActive | Obstacle::ShaftTurns)
}

/// Control words by what the drive shows.
struct Next {
    fault: bool,
    off1: bool,
    enabled: bool,
    velocity: bool,
}

impl fmt::Display for Next {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("send STW ")?;
        if self.fault {
            write!(f, "{:04X}, then {:04X}, then ", flow_charts::DISABLED, flow_charts::ACKNOWLEDGING)?;
        }
        if self.off1 {
            write!(f, "{:04X}, then ", flow_charts::OFF1)?;
        }
        match (self.enabled, self.velocity) {
            (false, false) => write!(f, "{:04X}, wait for ZSW.2 = 1, then ", flow_charts::TRAVEL)?,
            (false, true) => write!(f, "{:04X}, wait for ZSW.2 = 1, then ", flow_charts::ENABLED)?,
            (true, false | true) => {}
        }
        if self.velocity {
            write!(f, "{:04X} with the velocity in HSW", flow_charts::VELOCITY)
        } else {
            write!(
                f,
                "{:04X} with the target in HSW (each change of STW.6 starts a travel job)",
                flow_charts::TRAVEL | flow_charts::START
            )
        }
    }
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut before = "it does not move: ";
        for obstacle in self.iter() {
            write!(f, "{before}{}", self.text(obstacle))?;
            before = "; ";
        }
        if self.iter().next().is_none() {
            f.write_str("nothing keeps it from moving")?;
        }
        match self.next() {
            Some(next) => write!(f, "; next: {next}"),
            None => Ok(()),
        }
    }
}
