//! The values of faults as they are written.

use core::time::Duration;

use crate::can_bus::canopen::Abort;
use crate::profibus::dp::slave_diag;
use crate::profibus::fdl::Address;
use crate::profibus::fdl::station::MAX_USER_DATA;

/// The longest time that can be asked for.
const LONGEST: Duration = Duration::from_secs(3600);

/// Bits and octets that can be asked for at most: those of a telegram.
const MOST: u32 = 255;

/// What stands behind the name of a fault.
pub(super) trait Parameter {
    /// What it is read as.
    type Value;
    /// How it is written in a list of faults.
    const FORM: &'static str;
    /// What fits.
    const EXPECTED: &'static str;

    /// Reads it; `None`: it does not fit. The text is `None` if there is none.
    fn read(text: Option<&str>) -> Option<Self::Value>;

    /// Writes it; `None`: nothing.
    fn write(value: Self::Value) -> Option<String>;
}

/// No value.
pub(super) struct Nothing;

impl Parameter for Nothing {
    type Value = ();
    const FORM: &'static str = "";
    const EXPECTED: &'static str = "no value";

    fn read(text: Option<&str>) -> Option<()> {
        text.is_none().then_some(())
    }

    fn write((): ()) -> Option<String> {
        None
    }
}

/// A whole number of `us`, `ms` or `s`, above 0 and at most an hour.
pub(super) struct Time;

impl Parameter for Time {
    type Value = Duration;
    const FORM: &'static str = "=TIME";
    const EXPECTED: &'static str = "a time such as 20ms, 500us or 1s, at most 3600s";

    fn read(text: Option<&str>) -> Option<Duration> {
        duration(text?)
    }

    fn write(time: Duration) -> Option<String> {
        Some(in_micros(time))
    }
}

/// Bits or octets of a telegram, so many unless it is said.
pub(super) struct Few<const DEFAULT: u32>;

impl<const DEFAULT: u32> Parameter for Few<DEFAULT> {
    type Value = u32;
    const FORM: &'static str = "[=N]";
    const EXPECTED: &'static str = "a number, 1 to 255";

    fn read(text: Option<&str>) -> Option<u32> {
        text.map_or(Some(DEFAULT), |text| number(text).filter(|number| *number <= MOST))
    }

    fn write(number: u32) -> Option<String> {
        Some(number.to_string())
    }
}

/// Exchanges, 1 or more.
pub(super) struct Exchanges;

impl Parameter for Exchanges {
    type Value = u32;
    const FORM: &'static str = "=N";
    const EXPECTED: &'static str = "a number of exchanges, 1 or more";

    fn read(text: Option<&str>) -> Option<u32> {
        number(text?)
    }

    fn write(number: u32) -> Option<String> {
        Some(number.to_string())
    }
}

/// Octets that one telegram carries.
pub(super) struct Octets;

impl Parameter for Octets {
    type Value = u8;
    const FORM: &'static str = "=N";
    const EXPECTED: &'static str = "a number of octets, 0 to 244";

    fn read(text: Option<&str>) -> Option<u8> {
        digits(text?)?.parse().ok().filter(|octets| usize::from(*octets) <= MAX_USER_DATA)
    }

    fn write(octets: u8) -> Option<String> {
        Some(octets.to_string())
    }
}

/// The address of a station or master; none: the next one.
pub(super) struct Other;

impl Parameter for Other {
    type Value = Option<Address>;
    const FORM: &'static str = "[=ADDRESS]";
    const EXPECTED: &'static str = "an address, 0 to 126";

    fn read(text: Option<&str>) -> Option<Option<Address>> {
        text.map_or(Some(None), |text| Some(Some(station(text)?)))
    }

    fn write(address: Option<Address>) -> Option<String> {
        address.map(|address| address.to_string())
    }
}

/// An octet in hex, of so many digits at least.
pub(super) struct HexOctet<const LEAST: usize>;

impl<const LEAST: usize> Parameter for HexOctet<LEAST> {
    type Value = u8;
    const FORM: &'static str = "=HH";
    const EXPECTED: &'static str = "an octet in hex, 00 to FF";

    fn read(text: Option<&str>) -> Option<u8> {
        let octet = hexadecimal(text?, LEAST, 2)?;
        u8::try_from(octet).ok()
    }

    fn write(octet: u8) -> Option<String> {
        Some(format!("{octet:02X}"))
    }
}

/// An abort code.
pub(super) struct AbortCode;

impl Parameter for AbortCode {
    type Value = Abort;
    const FORM: &'static str = "=CODE";
    const EXPECTED: &'static str = "an abort code in hexadecimal, as 06090011";

    fn read(text: Option<&str>) -> Option<Abort> {
        hexadecimal(text?, 1, 8).map(Abort::from_code)
    }

    fn write(code: Abort) -> Option<String> {
        Some(format!("{:08X}", code.code()))
    }
}

/// Which part of an SD2 telegram is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FramePart {
    /// LE and LEr.
    Length,
    /// LEr.
    Repeated,
    /// The second start octet.
    Start,
    /// ED.
    End,
}

impl FramePart {
    const ALL: [(Self, &'static str); 4] =
        [(Self::Length, "length"), (Self::Repeated, "repeated"), (Self::Start, "start"), (Self::End, "end")];
}

impl Parameter for FramePart {
    type Value = Self;
    const FORM: &'static str = "=PART";
    const EXPECTED: &'static str = "length, repeated, start or end";

    fn read(text: Option<&str>) -> Option<Self> {
        Self::ALL.into_iter().find(|(_, name)| Some(*name) == text).map(|(part, _)| part)
    }

    fn write(part: Self) -> Option<String> {
        Self::ALL.into_iter().find(|(one, _)| *one == part).map(|(_, name)| name.to_string())
    }
}

/// The first octets of a diagnosis: `None` stays.
pub(crate) type DiagOctets = [Option<u8>; slave_diag::LEN];

/// [`DiagOctets`] in hex.
pub(super) struct Diagnosis;

impl Parameter for Diagnosis {
    type Value = DiagOctets;
    const FORM: &'static str = "=OCTETS";
    const EXPECTED: &'static str = "1 to 6 octets in hex, such as 020C or ..0D";

    fn read(text: Option<&str>) -> Option<DiagOctets> {
        let mut octets = DiagOctets::default();
        let mut places = octets.iter_mut();
        let mut rest = text?;
        while !rest.is_empty() {
            let (octet, behind) = rest.split_at_checked(2)?;
            *places.next()? = if octet == ".." { None } else { Some(HexOctet::<2>::read(Some(octet))?) };
            rest = behind;
        }
        octets.iter().any(Option::is_some).then_some(octets)
    }

    fn write(octets: DiagOctets) -> Option<String> {
        let used = octets.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
        let octet = |octet: &Option<u8>| octet.map_or("..".into(), |octet| format!("{octet:02X}"));
        Some(octets.iter().take(used).map(octet).collect())
    }
}

/// A text of digits only: numbers have no sign here.
pub(super) fn digits(text: &str) -> Option<&str> {
    (!text.is_empty() && text.bytes().all(|octet| octet.is_ascii_digit())).then_some(text)
}

/// A number from 1 on.
pub(super) fn number(text: &str) -> Option<u32> {
    digits(text)?.parse().ok().filter(|number| *number > 0)
}

/// A number such as 0.01; no exponents, no names.
pub(super) fn decimal(text: &str) -> Option<f64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    digits(whole)?;
    digits(fraction)?;
    text.parse().ok()
}

/// The address of a station.
pub(super) fn station(text: &str) -> Option<Address> {
    digits(text)?.parse().ok().and_then(|number| Address::station(number).ok())
}

/// So many digits in hex, with or without the `h` of the manuals.
fn hexadecimal(text: &str, least: usize, most: usize) -> Option<u32> {
    let hex = text.trim_end_matches('h');
    let are_digits = hex.bytes().all(|digit| digit.is_ascii_hexdigit());
    u32::from_str_radix(hex, 16).ok().filter(|_| are_digits && (least..=most).contains(&hex.len()))
}

/// A time as faults have it: a whole number of `us`, `ms` or `s`, above 0 and at most an hour. `None`: it is none.
pub(crate) fn duration(text: &str) -> Option<Duration> {
    let unit = text.find(|c: char| !c.is_ascii_digit())?;
    let (value, unit) = text.split_at(unit);
    let value: u64 = value.parse().ok()?;
    let duration = match unit {
        "us" => Duration::from_micros(value),
        "ms" => Duration::from_millis(value),
        "s" => Duration::from_secs(value),
        _ => return None,
    };
    (!duration.is_zero() && duration <= LONGEST).then_some(duration)
}

/// The times that [`duration`] reads, as a pattern of JSON Schema.
#[cfg(all(test, feature = "emulator"))]
pub(crate) const TIME_PATTERN: &str = concat!(
    "^0*([1-9][0-9]{0,8}|[12][0-9]{9}|3[0-5][0-9]{8}|3600000000)us$",
    "|^0*([1-9][0-9]{0,5}|[12][0-9]{6}|3[0-5][0-9]{5}|3600000)ms$",
    "|^0*([1-9][0-9]{0,2}|[12][0-9]{3}|3[0-5][0-9]{2}|3600)s$",
);

/// What is said about a text that is none.
pub(crate) fn no_time(text: &str) -> String {
    format!("'{text}' is no time; expected for example 500us, 20ms or 5s, at most 3600s")
}

/// A time as it is written.
pub(super) fn in_micros(time: Duration) -> String {
    let micros = time.as_micros();
    match (micros % 1_000_000, micros % 1_000) {
        (0, _) => format!("{}s", micros / 1_000_000),
        (_, 0) => format!("{}ms", micros / 1_000),
        (_, _) => format!("{micros}us"),
    }
}
