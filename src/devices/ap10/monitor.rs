//! Position monitoring: the target windows, the loop and the way to turn the shaft (manual 4.1.1).

use super::settings::{Setting, Settings};

/// A way to turn, seen on the display.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Direction {
    Clockwise,
    CounterClockwise,
}

/// What a person has to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Guide {
    /// Nothing: there is no valid set point.
    Idle,
    /// Turn the shaft; `near` inside target window 2.
    Turn { to: Direction, near: bool },
    /// Nothing: target window 1 is reached.
    Reached,
}

/// How the set point is approached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Approach {
    Direct,
    /// First beyond that point: from below for loop+, from above for loop-.
    Via {
        point: i64,
        rising: bool,
    },
}

/// The monitor of the set point in force.
#[derive(Clone, Copy, Debug)]
pub(super) struct Monitor {
    target: Option<i32>,
    approach: Approach,
    /// The difference actual - set.
    deviation: i64,
    inside: bool,
    /// Target window 1 was reached and nobody acknowledged it.
    pub(super) reached: bool,
}

impl Monitor {
    pub(super) const IDLE: Self =
        Self { target: None, approach: Approach::Direct, deviation: 0, inside: false, reached: false };

    /// The position or the set point in force may have changed.
    pub(super) fn update(&mut self, position: i32, target: Option<i32>, settings: &Settings) {
        if target != self.target {
            self.target = target;
            self.inside = false;
            self.approach = target.map_or(Approach::Direct, |target| approach(position, target, settings));
        }
        let Some(target) = target else {
            self.deviation = 0;
            return;
        };
        let window = i64::from(settings.value(Setting::Window1));
        self.deviation = i64::from(position) - i64::from(target);
        match self.approach {
            Approach::Direct => {}
            Approach::Via { point, rising: true } if i64::from(position) <= point + window => {
                self.approach = Approach::Direct;
            }
            Approach::Via { point, rising: false } if i64::from(position) >= point - window => {
                self.approach = Approach::Direct;
            }
            Approach::Via { .. } => {}
        }
        let inside = self.approach == Approach::Direct && self.deviation.abs() <= window;
        self.reached |= inside && !self.inside;
        self.inside = inside;
    }

    pub(super) const fn is_inside(&self) -> bool {
        self.inside
    }

    /// Inside target window 2.
    pub(super) fn is_near(&self, settings: &Settings) -> bool {
        self.target.is_some() && self.deviation.abs() <= i64::from(settings.value(Setting::Window2))
    }

    pub(super) const fn is_above(&self) -> bool {
        self.deviation > 0
    }

    /// 5F0Dh:1, 0 without a valid set point.
    pub(super) fn difference(&self, settings: &Settings) -> i32 {
        let difference =
            if settings.is_on(Setting::DifferenceFormation) { -self.deviation } else { self.deviation };
        i32::try_from(difference).unwrap_or(if difference < 0 { i32::MIN } else { i32::MAX })
    }

    pub(super) fn guide(&self, position: i32, settings: &Settings) -> Guide {
        let Some(target) = self.target else { return Guide::Idle };
        if self.inside {
            return Guide::Reached;
        }
        let goal = match self.approach {
            Approach::Direct => i64::from(target),
            Approach::Via { point, .. } => point,
        };
        let rise = i64::from(position) < goal;
        let to = if rise == settings.rises_clockwise() {
            Direction::Clockwise
        } else {
            Direction::CounterClockwise
        };
        Guide::Turn { to, near: self.is_near(settings) }
    }
}

/// Manual 4.1.1.2: loop+ goes beyond a set point below the actual value, loop- beyond one above.
fn approach(position: i32, target: i32, settings: &Settings) -> Approach {
    let (position, target) = (i64::from(position), i64::from(target));
    let length = i64::from(settings.value(Setting::LoopLength));
    match settings.value(Setting::Positioning) {
        1 if length > 0 && target < position => Approach::Via { point: target - length, rising: true },
        2 if length > 0 && target > position => Approach::Via { point: target + length, rising: false },
        i32::MIN..=i32::MAX => Approach::Direct,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guide(monitor: &mut Monitor, position: i32, target: i32, settings: &Settings) -> Guide {
        monitor.update(position, Some(target), settings);
        monitor.guide(position, settings)
    }

    const CW: Direction = Direction::Clockwise;
    const CCW: Direction = Direction::CounterClockwise;

    #[test]
    fn the_printed_example_100_with_windows_5_and_15() {
        let mut settings = Settings::default();
        settings.set(Setting::Window2, 15);
        for (position, expected) in [
            (84, Guide::Turn { to: CW, near: false }),
            (85, Guide::Turn { to: CW, near: true }),
            (94, Guide::Turn { to: CW, near: true }),
            (95, Guide::Reached),
            (105, Guide::Reached),
            (106, Guide::Turn { to: CCW, near: true }),
            (116, Guide::Turn { to: CCW, near: false }),
        ] {
            let mut monitor = Monitor::IDLE;
            assert_eq!(guide(&mut monitor, position, 100, &settings), expected, "{position}");
            assert_eq!(monitor.reached, expected == Guide::Reached);
        }
    }

    #[test]
    fn a_loop_ends_every_approach_from_the_same_side() {
        let mut settings = Settings::default();
        settings.set(Setting::LoopLength, 50);
        settings.set(Setting::Positioning, 1);
        let mut monitor = Monitor::IDLE;
        assert_eq!(guide(&mut monitor, 0, 100, &settings), Guide::Turn { to: CW, near: false }, "direct");
        monitor = Monitor::IDLE;
        for (position, expected) in [
            (200, Guide::Turn { to: CCW, near: false }),
            (100, Guide::Turn { to: CCW, near: true }),
            (56, Guide::Turn { to: CCW, near: false }),
            (55, Guide::Turn { to: CW, near: false }),
            (94, Guide::Turn { to: CW, near: false }),
            (95, Guide::Reached),
        ] {
            assert_eq!(guide(&mut monitor, position, 100, &settings), expected, "{position}");
        }
        settings.set(Setting::Positioning, 2);
        monitor = Monitor::IDLE;
        assert_eq!(guide(&mut monitor, 0, 100, &settings), Guide::Turn { to: CW, near: false });
        assert_eq!(guide(&mut monitor, 144, 100, &settings), Guide::Turn { to: CW, near: false });
        assert_eq!(guide(&mut monitor, 145, 100, &settings), Guide::Turn { to: CCW, near: false });
        assert_eq!(guide(&mut monitor, 100, 100, &settings), Guide::Reached);
    }

    #[test]
    fn the_other_sense_turns_the_other_way() {
        let mut settings = Settings::default();
        settings.set(Setting::OperatingParameters, 5);
        let mut monitor = Monitor::IDLE;
        assert_eq!(guide(&mut monitor, 0, 100, &settings), Guide::Turn { to: CCW, near: false });
    }
}
