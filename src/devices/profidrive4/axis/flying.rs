//! Flying referencing: the edge of a probe corrects the position while the axis does something else.

use super::{Activity, Origin};
use crate::devices::profidrive4::block::BlockTask;
use crate::devices::profidrive4::{Drive, Event, Setting, Task};

/// How far it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Flying {
    pub(super) runs: bool,
    /// The last edge came too far from where it should be.
    pub(super) outside: bool,
    /// The probes of the step before.
    probes: [bool; 2],
}

impl Drive {
    /// A step of it, under this task.
    pub(super) fn step_flying(&mut self, task: &Task) {
        let [first, second] = self.probes;
        let before = core::mem::replace(&mut self.axis.flying.probes, self.probes);
        self.axis.flying.runs = task.fly && task.home && !matches!(self.axis.activity, Activity::Homing(_));
        if !self.axis.flying.runs {
            self.axis.flying.outside = false;
            return;
        }
        let (was, is) = if task.second_probe { (before[1], second) } else { (before[0], first) };
        if was != is && is != task.falling_edge {
            self.correct();
        }
    }

    /// The shaft is at the reference position now.
    fn correct(&mut self) {
        let deviation = self.position(self.plant.position) - self.settings.of(Setting::ReferencePosition);
        let (inner, outer) = (self.settings.of(Setting::InnerWindow), self.settings.of(Setting::OuterWindow));
        self.axis.flying.outside = self.axis.referenced && outer > 0.0 && deviation.abs() > outer;
        if self.axis.flying.outside {
            self.tell(Event::MarkOutside);
            return;
        }
        if self.axis.referenced && deviation.abs() <= inner {
            return;
        }
        let shift = deviation * self.unit();
        self.axis.zero += shift;
        // A target that counts from the reference moves with it.
        let absolute = self.is_absolute();
        if let Activity::Travel { target, .. } = &mut self.axis.activity
            && absolute
        {
            *target += shift;
            self.axis.target = self.axis.target.map(|target| target + shift);
        }
        self.axis.referenced = true;
        self.tell(Event::Referenced);
    }

    fn is_absolute(&self) -> bool {
        match self.axis.activity {
            Activity::Travel { by: Origin::Mdi, .. } => self.task().mdi.is_some_and(|mdi| mdi.absolute),
            Activity::Travel { by: Origin::Block(number), .. } => self
                .blocks
                .numbered(number.into())
                .is_some_and(|block| block.what() == BlockTask::Position { relative: false }),
            Activity::Travel { by: Origin::Jog, .. }
            | Activity::Idle
            | Activity::Endless { .. }
            | Activity::Homing(_)
            | Activity::Waiting { .. }
            | Activity::Held { .. } => false,
        }
    }
}
