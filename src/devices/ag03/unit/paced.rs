//! What can change in every cycle is told at most once a second: the velocity setpoint, and warnings that come and go.

use core::time::Duration;

use crate::devices::ag03::drive::{Event, Velocity, Warning};

/// The shortest time between two events of the same thing.
const PAUSE: Duration = Duration::from_secs(1);

/// What was told last.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Paced {
    /// The setpoint told last, and how long ago, at most [`PAUSE`].
    velocity: Option<(Velocity, Duration)>,
    warnings: [Told; Warning::ALL.len()],
    /// Something will have to be told when time has passed.
    waits: bool,
}

/// What was told of a warning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Told {
    #[default]
    Absent,
    Present,
    /// Told as present, and gone for this time.
    Gone(Duration),
}

impl Paced {
    /// An event of the drive: what is to be told of it now.
    pub(super) fn pass(&mut self, event: Event) -> Option<Event> {
        match event {
            Event::VelocityStarted(velocity) => {
                self.velocity = Some((velocity, Duration::ZERO));
                Some(event)
            }
            Event::VelocityEnded => {
                self.velocity = None;
                self.waits = self.is_warning_gone();
                Some(event)
            }
            Event::Warning { warning, present } => {
                let told = self.warnings.get_mut(warning as usize)?;
                let before = *told;
                *told = match (before, present) {
                    (_, true) => Told::Present,
                    (Told::Present, false) => Told::Gone(Duration::ZERO),
                    (Told::Absent | Told::Gone(_), false) => before,
                };
                self.waits = self.is_warning_gone();
                (present && before == Told::Absent).then_some(event)
            }
            Event::Enabled(_)
            | Event::Disabled { .. }
            | Event::Mode(_)
            | Event::TravelStarted(_)
            | Event::Paused { .. }
            | Event::Resumed { .. }
            | Event::TargetReached { .. }
            | Event::Discarded { .. }
            | Event::Stands { .. }
            | Event::InchingStarted(_)
            | Event::InchingEnded { .. }
            | Event::VelocityChanged(_)
            | Event::Acknowledged
            | Event::Rearmed
            | Event::NotReady
            | Event::Ready => Some(event),
        }
    }

    /// Whether something will have to be told when time has passed.
    #[inline]
    pub(super) const fn waits(&self) -> bool {
        self.waits
    }

    fn is_warning_gone(&self) -> bool {
        self.warnings.iter().any(|told| matches!(told, Told::Gone(_)))
    }

    /// `dt` has passed, and the shaft turns with this setpoint, if it does.
    pub(super) fn pass_time(&mut self, dt: Duration, now: Option<Velocity>, mut say: impl FnMut(Event)) {
        let mut unsaid = false;
        if let (Some((told, ago)), Some(now)) = (&mut self.velocity, now) {
            *ago = PAUSE.min(ago.saturating_add(dt));
            if *told != now && *ago >= PAUSE {
                (*told, *ago) = (now, Duration::ZERO);
                say(Event::VelocityChanged(now));
            }
            unsaid = *told != now;
        }
        for (warning, told) in Warning::ALL.into_iter().zip(&mut self.warnings) {
            let Told::Gone(since) = told else { continue };
            *since = since.saturating_add(dt);
            if *since >= PAUSE {
                *told = Told::Absent;
                say(Event::Warning { warning, present: false });
            }
        }
        self.waits = unsaid || self.is_warning_gone();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: Duration = Duration::from_millis(10);

    fn velocity(setpoint: i32) -> Velocity {
        Velocity { setpoint, rpm: setpoint }
    }

    #[test]
    fn a_warning_that_flaps_is_told_once() {
        let mut paced = Paced::default();
        let event = |present| Event::Warning { warning: Warning::LagError, present };
        assert_eq!(paced.pass(event(true)), Some(event(true)));
        let mut told = std::vec![];
        for _ in 0..50 {
            assert_eq!(paced.pass(event(false)), None);
            assert!(paced.waits());
            paced.pass_time(STEP, None, |event| told.push(event));
            assert_eq!(paced.pass(event(true)), None);
            assert!(!paced.waits());
        }
        assert_eq!(paced.pass(event(false)), None);
        for _ in 0..99 {
            paced.pass_time(STEP, None, |event| told.push(event));
        }
        assert_eq!(told, []);
        paced.pass_time(STEP, None, |event| told.push(event));
        assert_eq!(told, [event(false)]);
        assert!(!paced.waits());
        assert_eq!(paced.pass(event(true)), Some(event(true)));
    }

    #[test]
    fn a_setpoint_that_changes_in_every_cycle_is_told_once_a_second_and_its_last_value_always() {
        let mut paced = Paced::default();
        let started = Event::VelocityStarted(velocity(1));
        assert_eq!(paced.pass(started), Some(started));
        let mut told = std::vec![];
        for setpoint in 2..=250 {
            paced.pass_time(STEP, Some(velocity(setpoint)), |event| told.push(event));
        }
        for _ in 0..200 {
            paced.pass_time(STEP, Some(velocity(250)), |event| told.push(event));
        }
        assert_eq!(told, [101, 201, 250].map(|setpoint| Event::VelocityChanged(velocity(setpoint))));
        assert_eq!(paced.pass(Event::VelocityEnded), Some(Event::VelocityEnded));
        paced.pass_time(Duration::from_secs(9), None, |event| told.push(event));
        assert_eq!(told.len(), 3);
    }
}
