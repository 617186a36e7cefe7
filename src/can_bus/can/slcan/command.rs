//! The lines of a master.

use thiserror::Error;

use super::text::{LineError, hex, parse_frame, word};
use crate::can_bus::can::Frame;

/// Characters of the longest line a master may send, without CR: an extended data frame of eight octets.
pub const MAX_COMMAND: usize = 26;

/// What a master wants from its adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// An empty line.
    Nothing,
    /// `Sn`, `sxxyy`: the rate of the bus.
    Rate(BusTiming),
    /// `O`: take part in the bus.
    Open,
    /// `L`: listen only.
    ListenOnly,
    /// `C`: leave the bus.
    Close,
    /// `t`, `T`, `r`, `R`: send a frame.
    Transmit(Frame),
    /// `V`: versions of hardware and software.
    Versions,
    /// `v`: version of the software.
    SoftwareVersion,
    /// `N`: serial number.
    SerialNumber,
    /// `F`: status flags, which reading clears.
    Status,
    /// `Z0`, `Z1`: time stamps off or on.
    TimeStamps(bool),
    /// `M`, `m`, `W`, `U`, `X`, `Q`: filters, rate of the serial line, poll modes. They change nothing here.
    NoEffect,
}

/// The rate of the bus as a master sets it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusTiming {
    /// 0..=9: 10, 20, 50, 100, 125, 250, 500, 800 (or 750), 1000 kbit/s, and 83.3 kbit/s of python-can.
    Standard(u8),
    /// BTR0 in the high octet and BTR1 in the low one.
    Registers(u16),
}

impl BusTiming {
    /// The rates in bit/s that it may mean; none are known of registers.
    pub(crate) const fn rates(self) -> &'static [u32] {
        match self {
            Self::Standard(0) => &[10_000],
            Self::Standard(1) => &[20_000],
            Self::Standard(2) => &[50_000],
            Self::Standard(3) => &[100_000],
            Self::Standard(4) => &[125_000],
            Self::Standard(5) => &[250_000],
            Self::Standard(6) => &[500_000],
            Self::Standard(7) => &[800_000, 750_000],
            Self::Standard(8) => &[1_000_000],
            Self::Standard(9) => &[83_333],
            Self::Standard(10..) | Self::Registers(_) => &[],
        }
    }
}

impl core::fmt::Display for BusTiming {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Standard(code) => {
                const NAMES: [&str; 10] =
                    ["10", "20", "50", "100", "125", "250", "500", "800 or 750", "1000", "83.3"];
                let name = NAMES.get(usize::from(*code)).copied().unwrap_or("an unknown number of");
                write!(f, "{name} kbit/s (S{code})")
            }
            Self::Registers(value) => write!(f, "BTR {value:04X}h"),
        }
    }
}

/// Why a line is no command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CommandError {
    /// No command begins so.
    #[error("no command begins with {got:02X}h")]
    Unknown {
        /// The first octet.
        got: u8,
    },
    /// The command takes another value.
    #[error("{:?} takes {expected}", char::from(*command))]
    Value {
        /// The command.
        command: u8,
        /// What it takes.
        expected: &'static str,
    },
    /// The frame, or the number behind the command, is none.
    #[error(transparent)]
    Line(#[from] LineError),
}

impl Command {
    /// The command that `line` is, without its CR.
    ///
    /// # Errors
    /// [`CommandError`]. Never panics.
    pub(crate) fn parse(line: &[u8]) -> Result<Self, CommandError> {
        if let Some(frame) = parse_frame(line) {
            return Ok(Self::Transmit(frame?));
        }
        let Some((&command, value)) = line.split_first() else {
            return Ok(Self::Nothing);
        };
        let none = |this| if value.is_empty() { Ok(this) } else { Err(expected(command, "no value")) };
        let digits = |count: usize| match value.len() == count {
            true => Ok(hex(line, 1, count)?),
            false => Err(LineError::Length { expected: 1 + count, got: line.len() }.into()),
        };
        match command {
            b'S' => digit(command, value, b'9', "0 to 9").map(|code| Self::Rate(BusTiming::Standard(code))),
            b's' => digits(4).map(|value| Self::Rate(BusTiming::Registers(word(value)))),
            b'O' => none(Self::Open),
            b'L' => none(Self::ListenOnly),
            b'C' => none(Self::Close),
            b'V' => none(Self::Versions),
            b'v' => none(Self::SoftwareVersion),
            b'N' => none(Self::SerialNumber),
            b'F' => none(Self::Status),
            b'Z' => digit(command, value, b'1', "0 or 1").map(|on| Self::TimeStamps(on == 1)),
            b'M' | b'm' => digits(8).map(|_| Self::NoEffect),
            b'W' => digit(command, value, b'2', "0 to 2").map(|_| Self::NoEffect),
            b'U' => digit(command, value, b'6', "0 to 6").map(|_| Self::NoEffect),
            b'X' => digit(command, value, b'1', "0 or 1").map(|_| Self::NoEffect),
            b'Q' => digit(command, value, b'2', "0 to 2").map(|_| Self::NoEffect),
            got => Err(CommandError::Unknown { got }),
        }
    }
}

/// The one decimal digit behind a command, up to `last`.
fn digit(command: u8, value: &[u8], last: u8, form: &'static str) -> Result<u8, CommandError> {
    match value {
        [digit] if (b'0'..=last).contains(digit) => Ok(digit - b'0'),
        _ => Err(expected(command, form)),
    }
}

const fn expected(command: u8, expected: &'static str) -> CommandError {
    CommandError::Value { command, expected }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can_bus::can::Id;

    #[test]
    fn golden_commands() {
        let frame = Frame::with(Id::base(0).unwrap(), [0x01, 0x05]);
        for (line, command) in [
            (&b""[..], Command::Nothing),
            (b"S6", Command::Rate(BusTiming::Standard(6))),
            (b"S9", Command::Rate(BusTiming::Standard(9))),
            (b"s031c", Command::Rate(BusTiming::Registers(0x031C))),
            (b"O", Command::Open),
            (b"L", Command::ListenOnly),
            (b"C", Command::Close),
            (b"t00020105", Command::Transmit(frame)),
            (b"V", Command::Versions),
            (b"v", Command::SoftwareVersion),
            (b"N", Command::SerialNumber),
            (b"F", Command::Status),
            (b"Z0", Command::TimeStamps(false)),
            (b"Z1", Command::TimeStamps(true)),
            (b"M00000000", Command::NoEffect),
            (b"mFFFFffff", Command::NoEffect),
            (b"W0", Command::NoEffect),
            (b"U6", Command::NoEffect),
            (b"X1", Command::NoEffect),
            (b"Q2", Command::NoEffect),
        ] {
            assert_eq!(Command::parse(line), Ok(command), "{}", line.escape_ascii());
        }
    }

    #[test]
    fn what_is_almost_a_command_is_none() {
        for line in [
            "S",
            "SA",
            "S10",
            "s031",
            "s031CC",
            "s03G0",
            "O1",
            "OO",
            "L0",
            "C1",
            "V1",
            "v0",
            "N0",
            "F0",
            "Z",
            "Z2",
            "Z10",
            "M0000000",
            "M000000000",
            "M0000000G",
            "m",
            "W",
            "W3",
            "U",
            "U7",
            "X2",
            "Q3",
            "P",
            "A",
            "o",
            "l",
            "c",
            "f",
            "z",
            " ",
            " O",
            "O ",
            "\u{7}",
            "t",
            "T123",
        ] {
            assert!(Command::parse(line.as_bytes()).is_err(), "{line:?}");
        }
        assert_eq!(Command::parse(b"\xFF\x00"), Err(CommandError::Unknown { got: 0xFF }));
    }

    #[test]
    fn a_refused_line_is_explained() {
        let says = |line: &[u8]| Command::parse(line).unwrap_err().to_string();
        assert_eq!(says(b"S"), "'S' takes 0 to 9");
        assert_eq!(says(b"O1"), "'O' takes no value");
        assert_eq!(says(b"P"), "no command begins with 50h");
        assert_eq!(says(b"t1230F"), "a line of this kind has 5 characters, not 6");
    }
}
