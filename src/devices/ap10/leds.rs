//! The four LEDs (manual 3.3, tables 3 and 4).

use core::fmt;

use super::monitor::{Direction, Guide};
use super::settings::{Setting, Settings};
use super::words::{Control, ControlBit};

/// Something that shines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Light {
    /// Dark.
    #[default]
    Off,
    /// Blinking.
    Blinking,
    /// On.
    Steady,
}

impl fmt::Display for Light {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Off => "off",
            Self::Blinking => "blinking",
            Self::Steady => "on",
        })
    }
}

impl Light {
    pub(super) const fn on(on: bool, blinking: bool) -> Self {
        match (on, blinking) {
            (false, _) => Self::Off,
            (true, false) => Self::Steady,
            (true, true) => Self::Blinking,
        }
    }
}

/// The four LEDs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Leds {
    /// LED1.
    pub left_green: Light,
    /// LED2.
    pub left_red: Light,
    /// LED3.
    pub right_green: Light,
    /// LED4.
    pub right_red: Light,
}

impl fmt::Display for Leds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = |f: &mut fmt::Formatter<'_>, name, green, red| match (green, red) {
            (Light::Off, Light::Off) => write!(f, "{name} off"),
            (green, Light::Off) => write!(f, "{name} green {green}"),
            (Light::Off, red) => write!(f, "{name} red {red}"),
            (green, red) => write!(f, "{name} green {green} and red {red}"),
        };
        side(f, "left", self.left_green, self.left_red)?;
        side(f, ", right", self.right_green, self.right_red)
    }
}

/// What the LEDs have to say by their basic function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Basic {
    /// In the modes with a position.
    Position(Guide),
    /// In alpha-numeric mode, left and right: whether the valid set point is acknowledged.
    SetPoints([Option<bool>; 2]),
}

impl Leds {
    /// What shines: the basic function where it is switched on, else the control word.
    pub(super) fn shining(basic: Basic, control: Control, settings: &Settings) -> Self {
        let mut leds = basic.leds(settings);
        let flashing = settings.is_on(Setting::LedFlashing);
        for (led, setting, bit) in [
            (&mut leds.left_green, Setting::Led1, ControlBit::Led1),
            (&mut leds.left_red, Setting::Led2, ControlBit::Led2),
            (&mut leds.right_green, Setting::Led3, ControlBit::Led3),
            (&mut leds.right_red, Setting::Led4, ControlBit::Led4),
        ] {
            if !settings.is_on(setting) {
                *led = Light::on(control.has(bit), control.has(ControlBit::LedBlinking));
            } else if flashing && *led == Light::Steady {
                *led = Light::Blinking;
            }
        }
        leds
    }
}

impl Basic {
    fn leds(self, settings: &Settings) -> Leds {
        match self {
            Self::Position(Guide::Idle) => Leds::default(),
            Self::Position(Guide::Reached) => {
                Leds { left_green: Light::Steady, right_green: Light::Steady, ..Leds::default() }
            }
            Self::Position(Guide::Turn { to, near }) => {
                // The colours of the outer zone are only in a figure (CN-109).
                let red = Light::on(true, near && settings.is_on(Setting::Window2Visible));
                match to {
                    Direction::Clockwise => Leds { right_red: red, ..Leds::default() },
                    Direction::CounterClockwise => Leds { left_red: red, ..Leds::default() },
                }
            }
            Self::SetPoints([left, right]) => Leds {
                left_green: Light::on(left == Some(true), false),
                left_red: Light::on(left == Some(false), false),
                right_green: Light::on(right == Some(true), false),
                right_red: Light::on(right == Some(false), false),
            },
        }
    }
}
