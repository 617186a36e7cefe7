//! Analogue inputs of CiA 401: what makes a change of a value an event.
//!
//! A value is an event if it is within the limits that 6421h chooses, and has changed by more than the deltas that it
//! chooses since the last event. A group of which nothing is chosen asks for nothing.

/// What 6421h chooses, and the limits of 6424h to 6428h or 6429h to 642Dh. `None`: the file has no such object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trigger {
    /// 6421h.
    pub(super) chosen: u8,
    pub(super) upper: Option<f64>,
    pub(super) lower: Option<f64>,
    pub(super) delta: Option<f64>,
    pub(super) less: Option<f64>,
    pub(super) more: Option<f64>,
}

impl Trigger {
    /// Whether a value is an event when that of the last one was `last`.
    pub(super) fn is_event(&self, value: f64, last: f64) -> bool {
        let of = |bit: u8, limit: Option<f64>| limit.filter(|_| self.chosen >> bit & 1 == 1);
        let limits =
            [of(0, self.upper).map(|upper| value >= upper), of(1, self.lower).map(|lower| value < lower)];
        let deltas = [
            of(2, self.delta).map(|delta| (value - last).abs() > delta),
            of(3, self.less).map(|delta| last - value > delta),
            of(4, self.more).map(|delta| value - last > delta),
        ];
        let any = |met: &[Option<bool>]| met.iter().all(Option::is_none) || met.contains(&Some(true));
        self.chosen & 0x1F != 0 && value != last && any(&limits) && any(&deltas)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_and_deltas_both_hold() {
        let all = Trigger {
            chosen: 0,
            upper: Some(100.0),
            lower: Some(-100.0),
            delta: Some(10.0),
            less: Some(20.0),
            more: Some(30.0),
        };
        for (chosen, value, last, expected) in [
            (0, 200.0, 0.0, false),
            (0b1, 100.0, 99.0, true),
            (0b1, 99.0, 200.0, false),
            (0b1, 100.0, 100.0, false),
            (0b10, -101.0, 0.0, true),
            (0b10, -100.0, 0.0, false),
            (0b11, 0.0, 150.0, false),
            (0b100, 11.0, 0.0, true),
            (0b100, 10.0, 0.0, false),
            (0b1000, 0.0, 21.0, true),
            (0b1000, 50.0, 0.0, false),
            (0b1_0000, 31.0, 0.0, true),
            (0b1_0000, 0.0, 50.0, false),
            (0b101, 105.0, 100.0, false),
            (0b101, 111.0, 100.0, true),
            (0b101, 50.0, 100.0, false),
        ] {
            let trigger = Trigger { chosen, ..all };
            assert_eq!(trigger.is_event(value, last), expected, "{chosen:05b}: {last} to {value}");
        }
        // Each change is an event by the defaults of the profile.
        let defaults = Trigger { chosen: 7, upper: Some(0.0), lower: Some(0.0), delta: Some(0.0), ..all };
        assert!([-1.0, 1.0].iter().all(|value| defaults.is_event(*value, 0.0)));
        let bare = Trigger { chosen: 7, upper: None, lower: None, delta: None, less: None, more: None };
        assert!(bare.is_event(1.0, 0.0));
    }
}
