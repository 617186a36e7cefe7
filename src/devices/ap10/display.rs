//! The display as text a person can read (manual 3.2).

use core::fmt;
use core::fmt::Write;
use core::time::Duration;

use heapless::String;

use super::faults::{Battery, Fault};
use super::indicator::Indicator;
use super::leds::{Leds, Light};
use super::menu::{ROW_LEN, rate_text};
use super::monitor::Direction;
use super::set_point::{SetPoint, Slot};
use super::settings::{Mode, Setting};
use super::words::ControlBit;

/// What stands for a set point that is not valid.
const NO_SET_POINT: &str = "---";

/// One row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Row {
    text: String<ROW_LEN>,
    /// The whole row blinks: it waits for an acknowledgement.
    pub flashing: bool,
    /// The sign and the first digit are shown in turn, as there is room for one.
    pub alternating: bool,
}

impl Row {
    /// What it shows.
    pub fn text(&self) -> &str {
        &self.text
    }

    fn of(text: &str) -> Self {
        let mut row = Self::default();
        for character in text.chars() {
            let _ = row.text.push(character);
        }
        row
    }
}

/// An arrow on the display: turn the shaft that way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Arrow {
    /// Clockwise.
    Clockwise,
    /// Counter-clockwise.
    CounterClockwise,
}

/// All that can be seen of the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Display {
    /// The rows from above.
    pub rows: [Row; 2],
    /// The arrow.
    pub arrow: Option<Arrow>,
    /// The battery symbol: blinking is critical, steady is empty.
    pub battery: Light,
    /// The symbol of incremental measurement.
    pub incremental: bool,
    /// The LEDs.
    pub leds: Leds,
    /// Turned by 180 degrees.
    pub rotated: bool,
}

impl Display {
    /// Nothing: the device is without supply.
    pub(crate) const DARK: Self = Self {
        rows: [const { Row { text: String::new(), flashing: false, alternating: false } }; 2],
        arrow: None,
        battery: Light::Off,
        incremental: false,
        leds: Leds {
            left_green: Light::Off,
            left_red: Light::Off,
            right_green: Light::Off,
            right_red: Light::Off,
        },
        rotated: false,
    };
}

/// How long each LED of the test is lit; the manual does not say it.
const TEST_STEP: Duration = Duration::from_millis(100);

impl Display {
    /// So long behind the supply the test of everything that shines, the LEDs one after the other (manual 2.1); `None`: it
    /// is over.
    pub(super) fn test(since: Duration) -> Option<Self> {
        let leds = Leds::default();
        let leds = match since.as_nanos() / TEST_STEP.as_nanos() {
            0 => Leds { left_green: Light::Steady, ..leds },
            1 => Leds { left_red: Light::Steady, ..leds },
            2 => Leds { right_green: Light::Steady, ..leds },
            3 => Leds { right_red: Light::Steady, ..leds },
            4.. => return None,
        };
        let all = Row::of("88888888");
        let (rows, arrow) = ([all.clone(), all], Some(Arrow::Clockwise));
        Some(Self { rows, arrow, battery: Light::Steady, incremental: true, leds, rotated: false })
    }
}

impl fmt::Display for Display {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [one, two] = &self.rows;
        write!(f, "[{:>8}] [{:>8}]", one.text(), two.text())?;
        for (row, number) in self.rows.iter().zip(1..) {
            if row.flashing {
                write!(f, ", row {number} flashing")?;
            }
        }
        match self.arrow {
            Some(Arrow::Clockwise) => f.write_str(", arrow clockwise")?,
            Some(Arrow::CounterClockwise) => f.write_str(", arrow counter-clockwise")?,
            None => {}
        }
        write!(f, ", LED {}", self.leds)?;
        if self.incremental {
            f.write_str(", incremental")?;
        }
        match self.battery {
            Light::Off => Ok(()),
            Light::Blinking => f.write_str(", battery critical"),
            Light::Steady => f.write_str(", battery empty"),
        }
    }
}

impl Indicator {
    /// What can be seen.
    pub(crate) fn display(&self) -> Display {
        let empty = self.faults.is_unread(Fault::BatteryEmpty);
        Display {
            rows: self.rows(),
            arrow: self.arrow(),
            battery: match self.faults.battery() {
                Battery::Empty => Light::Steady,
                Battery::Good | Battery::Critical if empty => Light::Steady,
                Battery::Critical => Light::Blinking,
                Battery::Good => Light::Off,
            },
            incremental: self.encoder.is_incremental(),
            leds: self.leds(),
            rotated: self.settings.is_on(Setting::Orientation),
        }
    }

    fn rows(&self) -> [Row; 2] {
        if self.auto_id.is_some() {
            return [Row::of("New ID"), Row::default()];
        }
        if let Some(menu) = &self.menu {
            return menu.rows(self.faults.log()).map(|text| Row { text, ..Row::default() });
        }
        if self.pressed.star_since.is_some() {
            let mut number = Row::default();
            let _ = write!(number.text, "ID {}", self.settings.value(Setting::NodeId));
            return [number, Row::of(rate_text(self.settings.value(Setting::BaudRate)))];
        }
        let mode = self.settings.mode();
        let mut rows = match mode {
            Mode::Absolute | Mode::Modulo => [self.actual_row(mode), self.target_row()],
            Mode::Difference => [self.actual_row(mode), self.difference_row()],
            Mode::Alphanumeric => [self.alpha_row(Slot::One), self.alpha_row(Slot::Two)],
        };
        let [one, two] = &mut rows;
        if mode != Mode::Alphanumeric && self.settings.is_on(Setting::RowTwo) {
            *two = Row::default();
        }
        if self.faults.is_unread(Fault::Speed) {
            *one = Row::of(Fault::Speed.shown());
        }
        rows
    }

    fn actual_row(&self, mode: Mode) -> Row {
        let value = self.shown(self.position());
        match mode {
            Mode::Modulo => self.number_row(value.rem_euclid(360)),
            Mode::Absolute | Mode::Difference | Mode::Alphanumeric => self.number_row(value),
        }
    }

    fn target_row(&self) -> Row {
        match self.target() {
            Some(target) => self.number_row(self.shown(target)),
            None => Row::of(NO_SET_POINT),
        }
    }

    fn difference_row(&self) -> Row {
        match self.target() {
            Some(_) => self.number_row(self.shown(self.difference())),
            None => Row::of(NO_SET_POINT),
        }
    }

    /// Without a valid set point row 1 is blank and row 2 shows "---" (manual 4.1.2).
    fn alpha_row(&self, slot: Slot) -> Row {
        let set_point: &SetPoint = self.set_point(slot);
        let mut row = match (set_point.characters(), set_point.number(), slot) {
            (Some(mut characters), _, _) => {
                if self.quirks.ascii_reversed {
                    characters.reverse();
                }
                let mut row = Row::default();
                for octet in characters {
                    let character = if matches!(octet, 0x20..=0x7E) { char::from(octet) } else { ' ' };
                    let _ = row.text.push(character);
                }
                row
            }
            (None, Some(number), _) => self.number_row(number),
            (None, None, Slot::One) => Row::default(),
            (None, None, Slot::Two) => Row::of(NO_SET_POINT),
        };
        row.flashing = set_point.is_pending() && !self.settings.is_on(Setting::PendingSteady);
        row
    }

    /// A value with the divisor, where that acts on the display only.
    #[expect(clippy::cast_possible_truncation, reason = "a quotient is not larger than its dividend")]
    fn shown(&self, value: i32) -> i32 {
        if self.settings.is_on(Setting::DivisorUse) {
            (i64::from(value) / self.settings.divisor()) as i32
        } else {
            value
        }
    }

    /// A number with its decimal places, or the overflow text (manual 3.2 and 3.2.1).
    fn number_row(&self, value: i32) -> Row {
        let extended = self.control.has(ControlBit::ExtendedRange);
        let range = if extended { -999_999..=999_999 } else { -19_999..=99_999 };
        if !range.contains(&value) {
            return Row::of(self.quirks.overflow);
        }
        let mut row = Row { alternating: value < -199_999, ..Row::default() };
        let sign = if value < 0 { "-" } else { "" };
        let places = self.settings.value(Setting::DecimalPlaces).unsigned_abs();
        let one = 10_u32.pow(places);
        let value = value.unsigned_abs();
        let _ = match usize::try_from(places) {
            Ok(0) | Err(_) => write!(row.text, "{sign}{value}"),
            Ok(width) => write!(row.text, "{sign}{}.{:0width$}", value / one, value % one),
        };
        row
    }

    /// The arrow, as 5F1Fh has it.
    pub(super) fn arrow(&self) -> Option<Arrow> {
        let inverted = match self.settings.value(Setting::Arrows) {
            ..=0 => false,
            1 => true,
            2.. => return None,
        };
        Some(match (self.way()?, inverted) {
            (Direction::Clockwise, false) | (Direction::CounterClockwise, true) => Arrow::Clockwise,
            (Direction::Clockwise, true) | (Direction::CounterClockwise, false) => Arrow::CounterClockwise,
        })
    }
}
