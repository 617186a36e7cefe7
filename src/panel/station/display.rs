//! What a person sees of a station as JSON.

use core::time::Duration;

use serde::Serialize;

use super::FaultNow;
use crate::face::surroundings::{Face, FaceLed, FaceRow, Glow};

/// What a person sees of a device.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Display {
    /// The rows of the display from above; none if there is no display.
    rows: Vec<Row>,
    /// What is lit beside the rows, as `battery empty`.
    signs: Vec<&'static str>,
    leds: Vec<Led>,
}

/// A row of a display.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct Row {
    text: String,
    flashing: bool,
}

/// An LED.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct Led {
    /// Which, with its colour: `left green`.
    led: &'static str,
    colour: &'static str,
    glow: GlowName,
    /// How often it blinks before the pause: the code of a fault; 0 unless it does.
    blinks: u8,
    /// How long it is lit each time, if it blinks without end.
    #[serde(skip_serializing_if = "Option::is_none")]
    on_milliseconds: Option<u64>,
    /// How long it is dark each time.
    #[serde(skip_serializing_if = "Option::is_none")]
    off_milliseconds: Option<u64>,
    /// What that means.
    #[serde(skip_serializing_if = "Option::is_none")]
    text: Option<String>,
}

/// What an LED does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
enum GlowName {
    Off,
    On,
    Blinking,
}

impl Led {
    fn of(led: &FaceLed, fault: Option<&FaultNow>) -> Self {
        let (glow, blinks, text) = match led.glow {
            Glow::Off => (GlowName::Off, 0, None),
            Glow::On => (GlowName::On, 0, None),
            Glow::Blinking { .. } => (GlowName::Blinking, 0, None),
            Glow::Alternating => (GlowName::Blinking, 0, Some("alternates: reset".into())),
            Glow::Code(blinks) => {
                let times = if blinks == 1 { "blink" } else { "blinks" };
                let code = fault.map(|fault| format!("{blinks} {times}: fault {}", fault.fault));
                (GlowName::Blinking, blinks, code)
            }
        };
        let colour = led.name.rsplit_once(' ').map_or(led.name, |(_, colour)| colour);
        let (on_milliseconds, off_milliseconds) = match led.glow {
            Glow::Blinking { on, off } => (Some(millis(on)), Some(millis(off))),
            Glow::Off | Glow::On | Glow::Alternating | Glow::Code(_) => (None, None),
        };
        Self { led: led.name, colour, glow, blinks, on_milliseconds, off_milliseconds, text }
    }
}

fn millis(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}

impl Display {
    pub(super) fn of(face: &Face, fault: Option<&FaultNow>) -> Self {
        let row = |row: &FaceRow| Row { text: row.text.as_str().to_owned(), flashing: row.flashing };
        Self {
            rows: face.rows.iter().map(row).collect(),
            signs: face.signs.iter().copied().collect(),
            leds: face.leds.iter().map(|led| Led::of(led, fault)).collect(),
        }
    }
}
