//! The LEDs of a drive, as lit now and as they blink.

use serde::Serialize;
use utoipa::ToSchema;

use crate::devices::ag03::drive::{StatusLed, leds};
use crate::devices::ag03::profibus::{Device, Power};
use crate::time::Instant;

/// One LED, now and over time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct Led {
    /// Lit now.
    lit: bool,
    pattern: LedPattern,
    /// How often it blinks before the pause; 0 unless it blinks.
    blinks: u8,
    on_milliseconds: u32,
    off_milliseconds: u32,
    /// Dark after the last blink, in addition to `off_milliseconds`.
    pause_milliseconds: u32,
    /// How long ago the sequence of blinks began that runs now; 0 unless it blinks.
    phase_milliseconds: u32,
}

/// What an LED does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::panel) enum LedPattern {
    Off,
    On,
    /// A number of blinks, then a pause: the code of a fault.
    Blinking,
    /// Both LEDs in turn: a factory reset.
    Alternating,
}

impl Led {
    pub(super) fn status(device: &Device, now: Instant) -> Self {
        let leds = device.leds(now);
        let steady = |pattern| Self::steady(leds.status, pattern);
        match (device.power(), leds.pattern) {
            (Power::FactoryReset(_), _) => steady(LedPattern::Alternating),
            (Power::Off | Power::On, StatusLed::Off) => steady(LedPattern::Off),
            (Power::Off | Power::On, StatusLed::On) => steady(LedPattern::On),
            (Power::Off | Power::On, StatusLed::Blinking(fault)) => {
                let blinks = fault.blinks();
                let sequence = (leds::BLINK_ON + leds::BLINK_OFF) * u32::from(blinks) + leds::BLINK_PAUSE;
                let phase = device.blink_time(now).as_nanos().checked_rem(sequence.as_nanos()).unwrap_or(0);
                Self {
                    blinks,
                    phase_milliseconds: u32::try_from(phase / 1_000_000).unwrap_or(0),
                    ..steady(LedPattern::Blinking)
                }
            }
        }
    }

    pub(super) fn bus(device: &Device, now: Instant) -> Self {
        let lit = device.leds(now).bus;
        Self::steady(
            lit,
            match (device.power(), lit) {
                (Power::FactoryReset(_), _) => LedPattern::Alternating,
                (Power::Off | Power::On, true) => LedPattern::On,
                (Power::Off | Power::On, false) => LedPattern::Off,
            },
        )
    }

    /// Without what changes though nothing happens.
    pub(super) const fn timeless(self) -> Self {
        Self { phase_milliseconds: 0, ..self }
    }

    fn steady(lit: bool, pattern: LedPattern) -> Self {
        let milliseconds = |time: core::time::Duration| u32::try_from(time.as_millis()).unwrap_or(u32::MAX);
        Self {
            lit,
            pattern,
            blinks: 0,
            on_milliseconds: milliseconds(leds::BLINK_ON),
            off_milliseconds: milliseconds(leds::BLINK_OFF),
            pause_milliseconds: milliseconds(leds::BLINK_PAUSE),
            phase_milliseconds: 0,
        }
    }
}
