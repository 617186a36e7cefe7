//! The green status LED of the drive (manual chapter 5.2, `ag03.md` 10 and 11).

use core::time::Duration;

use super::faults::Fault;

/// How long the LED is lit per blink. The manuals state no times (INF).
pub(crate) const BLINK_ON: Duration = Duration::from_millis(250);
/// How long it is dark between two blinks.
pub(crate) const BLINK_OFF: Duration = Duration::from_millis(250);
/// How long it is dark after the last blink, in addition to `BLINK_OFF`.
pub const BLINK_PAUSE: Duration = Duration::from_millis(1250);

/// What the status LED does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StatusLed {
    /// A supply is missing, or on an AG03 the enable input is not active.
    Off,
    /// Supplied and enabled.
    On,
    /// Blinks as often as [`Fault::blinks`] says, then pauses.
    Blinking(Fault),
}

impl StatusLed {
    /// Whether the LED is lit `time` after a sequence of blinks began.
    ///
    /// ```
    /// use core::time::Duration;
    /// use profidrive::devices::ag03::drive::{Fault, StatusLed};
    ///
    /// let twice = StatusLed::Blinking(Fault::B);
    /// let lit = |millis| twice.is_lit(Duration::from_millis(millis));
    /// assert_eq!([0, 300, 600, 800, 2200, 2250].map(lit), [true, false, true, false, false, true]);
    /// ```
    pub fn is_lit(self, time: Duration) -> bool {
        match self {
            Self::Off => false,
            Self::On => true,
            Self::Blinking(fault) => {
                let blink = BLINK_ON.saturating_add(BLINK_OFF).as_nanos();
                let blinks = u128::from(fault.blinks());
                let within = time.as_nanos() % (blinks * blink + BLINK_PAUSE.as_nanos());
                within < blinks * blink && within % blink < BLINK_ON.as_nanos()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_blinks_as_often_as_its_code_says_in_each_sequence() {
        for fault in Fault::ALL {
            let led = StatusLed::Blinking(fault);
            let blinks = u32::from(fault.blinks());
            let sequence = (BLINK_ON + BLINK_OFF) * blinks + BLINK_PAUSE;
            for start in [Duration::ZERO, sequence, sequence * 1000] {
                let samples = (0..sequence.as_millis())
                    .map(|millis| led.is_lit(start + Duration::from_millis(u64::try_from(millis).unwrap())));
                let samples: std::vec::Vec<_> = samples.collect();
                let rising = samples.windows(2).filter(|pair| !pair[0] && pair[1]).count();
                assert!(samples[0]);
                assert_eq!(rising + 1, usize::from(fault.blinks()), "{fault}");
                assert!(samples.iter().rev().take(1500).all(|lit| !lit), "the pause");
            }
        }
    }
}
