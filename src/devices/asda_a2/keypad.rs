//! The front of the drive: five digits and five keys, which walk through the parameters and change them.
//!
//! ```text
//!             MODE            SET            SET
//!  monitor ─────────▶ P1-44 ──────▶ value ──────▶ SAVEd
//!     ▲   ◀─────────    ▲             │
//!             MODE      └─────────────┘ MODE
//! ```
//!
//! SHIFT goes to the next group, or to the next digit of a value; UP and DOWN to the next parameter of the group, or change
//! the digit. The guide has the numbers of the parameters, their values and their format, but not the keys: these act as is
//! usual on this series. Parameters that the drive does not have are not shown.

use core::fmt::Write;
use core::time::Duration;

use heapless::String;

use super::Servo;
use super::settings::Setting;
use super::status::Panel;
use crate::time::Instant;

/// How long a message stands.
const MESSAGE: Duration = Duration::from_secs(1);
/// Where the P-parameters are: P a-bc is 2aXXh.
const FIRST: u16 = 0x2000;
/// Groups, and the most parameters of one.
const GROUPS: u16 = 8;
const OF_GROUP: u16 = 100;

/// A key of the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Key {
    /// Monitor or parameters; leaves a value as it was.
    Mode,
    /// The next group; the next digit to the left.
    Shift,
    /// The next parameter; a digit more.
    Up,
    /// The parameter before; a digit less.
    Down,
    /// Shows the value; writes it.
    Set,
}

impl Key {
    /// Every key, from the left.
    pub(crate) const ALL: [Self; 5] = [Self::Mode, Self::Shift, Self::Up, Self::Down, Self::Set];

    /// Its name in commands.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Mode => "mode",
            Self::Shift => "shift",
            Self::Up => "up",
            Self::Down => "down",
            Self::Set => "set",
        }
    }

    /// The key with that name.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|key| key.name() == name)
    }

    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// What came of writing a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// It is in force and kept.
    Saved,
    /// The parameter cannot be written.
    ReadOnly,
    /// The value cannot be.
    OutOfRange,
    /// Not while the servo is on.
    ServoOn,
}

impl Outcome {
    const fn text(self) -> &'static str {
        match self {
            Self::Saved => "SAVEd",
            Self::ReadOnly => "r-OLY",
            Self::OutOfRange => "Out-r",
            Self::ServoOn => "SvOn",
        }
    }
}

/// A parameter as the keys see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Parameter {
    pub(crate) value: i64,
    /// It has 32 bits.
    pub(crate) wide: bool,
}

/// Reads the parameter at an index; `None`: the drive has none there.
pub(crate) type Read<'a> = &'a dyn Fn(u16) -> Option<Parameter>;

/// What the monitor shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Watched {
    Position,
    Demand,
    Deviation,
    Speed,
}

impl Watched {
    const ALL: [Self; 4] = [Self::Position, Self::Demand, Self::Deviation, Self::Speed];

    const fn text(self) -> &'static str {
        match self {
            Self::Position => "FbPUU",
            Self::Demand => "C-PUU",
            Self::Deviation => "ErPUU",
            Self::Speed => "SPEEd",
        }
    }

    fn of(self, servo: &Servo) -> i32 {
        match self {
            Self::Position => servo.position_actual(),
            Self::Demand => servo.position_demand(),
            Self::Deviation => servo.following_error_puu(),
            Self::Speed => servo.velocity_actual() / 10,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum View {
    Monitor(Watched),
    /// Its number.
    Number,
    /// Its value as it is changed, and which digit of it is: 0 is the lowest.
    Value {
        value: Parameter,
        digit: u8,
    },
}

/// What is seen of it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    /// Five digits.
    pub(crate) text: String<8>,
    /// The points are lit: the number is below zero, and its sign has no place.
    pub(crate) negative: bool,
    /// The digit that UP and DOWN change; 0 is the lowest.
    pub(crate) digit: Option<u8>,
}

/// The keys and what they have led to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Keypad {
    view: View,
    /// The parameter that was looked at last.
    at: u16,
    held: u8,
    message: Option<(&'static str, Instant)>,
}

impl Default for Keypad {
    /// As after power-on: the position.
    fn default() -> Self {
        Self { view: View::Monitor(Watched::Position), at: FIRST, held: 0, message: None }
    }
}

impl Keypad {
    /// Whether a key is down.
    pub(crate) const fn is_held(&self, key: Key) -> bool {
        self.held & key.bit() != 0
    }

    /// A key goes up.
    pub(crate) const fn release(&mut self, key: Key) {
        self.held &= !key.bit();
    }

    /// A key goes down: the parameter that is to be written, with its value. A key that is down already does nothing.
    pub(crate) fn press(&mut self, now: Instant, key: Key, read: Read<'_>) -> Option<(u16, Parameter)> {
        if self.is_held(key) {
            return None;
        }
        self.held |= key.bit();
        self.message = None;
        match (self.view, key) {
            (View::Monitor(watched), Key::Up) => self.watch(now, watched, 1),
            (View::Monitor(watched), Key::Down) => self.watch(now, watched, Watched::ALL.len() - 1),
            (View::Monitor(_), Key::Shift | Key::Set) => {}
            (View::Monitor(_), Key::Mode) => {
                self.view = View::Number;
                if read(self.at).is_none() {
                    self.seek(read, (0..GROUPS * OF_GROUP).map(place));
                }
            }
            (View::Number, Key::Mode) => self.view = View::Monitor(Watched::Position),
            (View::Number, Key::Shift) => {
                let next = group(self.at) + 1;
                let groups = (0..GROUPS).map(|further| (next + further) % GROUPS);
                self.seek(
                    read,
                    groups.flat_map(|group| (0..OF_GROUP).map(move |number| in_group(group, number))),
                );
            }
            (View::Number, Key::Up) => self.walk(read, 1),
            (View::Number, Key::Down) => self.walk(read, OF_GROUP - 1),
            (View::Number, Key::Set) => {
                if let Some(value) = read(self.at) {
                    self.view = View::Value { value, digit: 0 };
                }
            }
            (View::Value { .. }, Key::Mode) => self.view = View::Number,
            (View::Value { value, digit }, Key::Shift) => {
                self.view = View::Value { value, digit: (digit + 1) % digits(self.at, value) };
            }
            (View::Value { value, digit }, Key::Up) => self.turn(value, digit, 1),
            (View::Value { value, digit }, Key::Down) => self.turn(value, digit, -1),
            (View::Value { value, .. }, Key::Set) => return Some((self.at, value)),
        }
        None
    }

    /// What came of the value that [`press`](Self::press) gave.
    pub(crate) fn tell(&mut self, now: Instant, outcome: Outcome) {
        self.message = Some((outcome.text(), now.saturating_add(MESSAGE)));
        self.view = View::Number;
    }

    /// What is seen at `now`.
    pub(crate) fn seen(&self, now: Instant, servo: &Servo) -> Seen {
        let mut seen = Seen::default();
        let text = &mut seen.text;
        let message = self.message.filter(|(_, until)| now < *until);
        let _ = match (message, self.view) {
            (Some((message, _)), _) => write!(text, "{message:5}"),
            (None, View::Number) => {
                write!(text, "P{}-{:02}", group(self.at), self.at & 0xFF)
            }
            (None, View::Value { value: Parameter { value, .. }, digit }) => {
                seen.digit = Some(digit);
                if is_hexadecimal(self.at) {
                    write!(text, " {:04X}", value & 0xFFFF)
                } else {
                    seen.negative = value < 0;
                    // Of more than five digits those beside the one that is changed.
                    let page = value.unsigned_abs() / if digit < 5 { 1 } else { 100_000 };
                    write!(text, "{:05}", page % 100_000)
                }
            }
            (None, View::Monitor(Watched::Position)) => {
                let panel = servo.panel();
                seen.negative = matches!(panel, Panel::Number(..=-10_000));
                write!(text, "{panel}")
            }
            (None, View::Monitor(watched)) => {
                let number = watched.of(servo);
                seen.negative = number <= -10_000;
                write!(text, "{}", Panel::Number(number))
            }
        };
        seen
    }

    /// The next of what the monitor shows: its name first.
    fn watch(&mut self, now: Instant, watched: Watched, further: usize) {
        let next = Watched::ALL.into_iter().cycle().nth(watched as usize + further);
        if let Some(next) = next {
            self.view = View::Monitor(next);
            self.message = Some((next.text(), now.saturating_add(MESSAGE)));
        }
    }

    /// The first of these places that has a parameter.
    fn seek(&mut self, read: Read<'_>, mut places: impl Iterator<Item = u16>) {
        if let Some(found) = places.find(|place| read(*place).is_some()) {
            self.at = found;
        }
    }

    /// The next parameter of the group in steps of so many numbers.
    fn walk(&mut self, read: Read<'_>, step: u16) {
        let (group, number) = (group(self.at), self.at & 0xFF);
        let numbers = (1..=OF_GROUP).map(move |times| (number + times * step) % OF_GROUP);
        self.seek(read, numbers.map(move |number| in_group(group, number)));
    }

    /// A digit of the value is turned.
    fn turn(&mut self, Parameter { value, wide }: Parameter, digit: u8, by: i64) {
        let value = if is_hexadecimal(self.at) {
            let shift = 4 * u32::from(digit);
            let turned = ((value >> shift) + by) & 0xF;
            let word = value & 0xFFFF & !(0xF << shift) | turned << shift;
            if word > i64::from(i16::MAX) { word - 0x1_0000 } else { word }
        } else {
            let (low, high) = if wide {
                (i64::from(i32::MIN), i64::from(i32::MAX))
            } else {
                (i64::from(i16::MIN), i64::from(i16::MAX))
            };
            (value + by * 10_i64.pow(digit.into())).clamp(low, high)
        };
        self.view = View::Value { value: Parameter { value, wide }, digit };
    }
}

const fn place(number: u16) -> u16 {
    in_group(number / OF_GROUP, number % OF_GROUP)
}

const fn in_group(group: u16, number: u16) -> u16 {
    FIRST + group * 0x100 + number
}

const fn group(place: u16) -> u16 {
    (place - FIRST) >> 8
}

/// Digits that can be changed.
fn digits(place: u16, value: Parameter) -> u8 {
    match (is_hexadecimal(place), value.wide) {
        (true, _) => 4,
        (false, false) => 5,
        (false, true) => 10,
    }
}

/// Whether the guide writes the value in hexadecimal digits.
fn is_hexadecimal(place: u16) -> bool {
    const HEXADECIMAL: [Setting; 8] = [
        Setting::ControlMode,
        Setting::NodeNumber,
        Setting::Rates,
        Setting::StopMode,
        Setting::SyncAdjustment,
        Setting::CanEnable,
        Setting::PdoToEeprom,
        Setting::QuickStopOptions,
    ];
    HEXADECIMAL.iter().any(|setting| setting.names().iter().any(|name| name.object.at == (place, 0)))
}

#[cfg(test)]
mod tests {
    use super::super::Config;
    use super::*;

    /// P0-02, P1-44 of 32 bits, P3-00 and P3-05.
    fn read(place: u16) -> Option<Parameter> {
        let (value, wide) = match place {
            0x2002 => (-7, false),
            0x212C => (1_234_567, true),
            0x2300 => (0x7F, false),
            0x2305 => (10, false),
            _ => return None,
        };
        Some(Parameter { value, wide })
    }

    /// What is seen after each key, at the end of every message.
    fn typed(keypad: &mut Keypad, keys: &str) -> std::vec::Vec<std::string::String> {
        let servo = Servo::new(Config::new(1), Instant::ZERO);
        let seen = keys.split(' ').map(|name| {
            let key = Key::from_name(name).unwrap();
            assert_eq!(keypad.press(Instant::ZERO, key, &read), None, "{name} writes nothing");
            keypad.release(key);
            keypad.seen(Instant::from_millis(5000), &servo).text.to_string()
        });
        seen.collect()
    }

    #[test]
    fn keys_walk_through_groups_and_parameters_that_there_are() {
        let mut keypad = Keypad::default();
        let seen = typed(&mut keypad, "mode up shift shift up up down shift mode mode");
        let expected =
            ["P0-02", "P0-02", "P1-44", "P3-00", "P3-05", "P3-00", "P3-05", "P0-02", "    0", "P0-02"];
        assert_eq!(seen, expected);
    }

    #[test]
    fn a_value_is_changed_digit_by_digit_in_its_format() {
        let mut keypad = Keypad::default();
        let seen = typed(&mut keypad, "mode set up shift up shift mode shift set up");
        assert_eq!(
            seen,
            ["P0-02", "00007", "00006", "00006", "00004", "00004", "P0-02", "P1-44", "34567", "34568"]
        );
        let pages = typed(&mut keypad, "shift shift shift shift shift up shift");
        assert_eq!(pages, ["34568", "34568", "34568", "34568", "00012", "00013", "00013"]);
        let hexadecimal = typed(&mut keypad, "mode shift set up shift down");
        assert_eq!(hexadecimal, ["P1-44", "P3-00", " 007F", " 0070", " 0070", " 0060"]);
        let set = keypad.press(Instant::ZERO, Key::Set, &read);
        assert_eq!(set, Some((0x2300, Parameter { value: 0x60, wide: false })));
    }

    #[test]
    fn a_message_stands_for_a_second_and_a_key_that_is_held_acts_once() {
        let servo = Servo::new(Config::new(1), Instant::ZERO);
        let mut keypad = Keypad::default();
        let seen =
            |keypad: &Keypad, millis| keypad.seen(Instant::from_millis(millis), &servo).text.to_string();
        keypad.press(Instant::ZERO, Key::Up, &read);
        keypad.press(Instant::ZERO, Key::Up, &read);
        assert_eq!((seen(&keypad, 999), seen(&keypad, 1000)), ("C-PUU".into(), "    0".into()));
        assert!(keypad.is_held(Key::Up) && !keypad.is_held(Key::Down));
        keypad.release(Key::Up);
        keypad.press(Instant::ZERO, Key::Up, &read);
        assert_eq!(seen(&keypad, 0), "ErPUU");
        keypad.tell(Instant::from_millis(2000), Outcome::OutOfRange);
        assert_eq!((seen(&keypad, 2500), seen(&keypad, 3000)), ("Out-r".into(), "P0-00".into()));
    }
}
