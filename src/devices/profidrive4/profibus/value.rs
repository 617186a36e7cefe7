//! Values of parameters and their octets, by format.

use crate::profibus::dpv1::base_mode::Format;

/// The octets of a value; none for formats that no parameter has.
pub(super) fn octets(format: Format, value: f64) -> Vec<u8> {
    let all = bits(format, value).to_be_bytes();
    let size = format.size().unwrap_or_default().min(all.len());
    all.iter().skip(all.len() - size).copied().collect()
}

/// The value of the octets of one element.
pub(super) fn of_octets(format: Format, octets: &[u8]) -> f64 {
    of_bits(format, octets.iter().fold(0, |bits, octet| bits << 8 | u32::from(*octet)))
}

/// The least and the greatest value of a format.
pub(super) const fn range(format: Format) -> (f64, f64) {
    match format {
        Format::BOOLEAN => (0.0, 1.0),
        Format::INTEGER8 => (i8::MIN as f64, i8::MAX as f64),
        Format::UNSIGNED8 | Format::VISIBLE_STRING | Format::OCTET_STRING | Format::BYTE => {
            (0.0, u8::MAX as f64)
        }
        Format::INTEGER16 | Format::N2 => (i16::MIN as f64, i16::MAX as f64),
        Format::UNSIGNED16 | Format::V2 | Format::WORD => (0.0, u16::MAX as f64),
        Format::INTEGER32 | Format::N4 => (i32::MIN as f64, i32::MAX as f64),
        Format::FLOAT => (f32::MIN as f64, f32::MAX as f64),
        _ => (0.0, u32::MAX as f64),
    }
}

/// The bits of a value in the low octets; what is outside of the format is its nearest value.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the range, and NaN is 0")]
pub(super) fn bits(format: Format, value: f64) -> u32 {
    let (low, high) = range(format);
    let value = value.max(low).min(high);
    match format {
        Format::FLOAT => (value as f32).to_bits(),
        _ => (libm::round(value) as i64) as u32,
    }
}

/// The value of bits.
pub(super) fn of_bits(format: Format, bits: u32) -> f64 {
    let [_, _, high, low] = bits.to_be_bytes();
    match format {
        Format::INTEGER8 => low.cast_signed().into(),
        Format::INTEGER16 | Format::N2 => i16::from_be_bytes([high, low]).into(),
        Format::INTEGER32 | Format::N4 => bits.cast_signed().into(),
        Format::FLOAT => f32::from_bits(bits).into(),
        _ => bits.into(),
    }
}

/// Whether values of `given` may be written to a parameter of `own`: the same, or octets of as many.
pub(super) fn fits(own: Format, given: Format) -> bool {
    let plain = matches!(given, Format::BYTE | Format::WORD | Format::DOUBLE_WORD);
    own == given || plain && own.size() == given.size()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octets_of_each_format_and_back() {
        for (format, value, expected) in [
            (Format::BOOLEAN, 1.0, &[1][..]),
            (Format::INTEGER8, -2.0, &[0xFE]),
            (Format::UNSIGNED8, 200.0, &[200]),
            (Format::INTEGER16, -2.0, &[0xFF, 0xFE]),
            (Format::UNSIGNED16, 65535.0, &[0xFF, 0xFF]),
            (Format::V2, 1151.0, &[0x04, 0x7F]),
            (Format::N2, -16384.0, &[0xC0, 0]),
            (Format::INTEGER32, -2.0, &[0xFF, 0xFF, 0xFF, 0xFE]),
            (Format::UNSIGNED32, 4_294_967_295.0, &[0xFF; 4]),
            (Format::N4, 1_073_741_824.0, &[0x40, 0, 0, 0]),
            (Format::TIME_DIFFERENCE, 1000.0, &[0, 0, 3, 0xE8]),
            (Format::FLOAT, 1.5, &[0x3F, 0xC0, 0, 0]),
            (Format::VISIBLE_STRING, 65.0, b"A"),
        ] {
            assert_eq!(octets(format, value), expected, "{format:?}");
            assert_eq!(of_octets(format, expected), value, "{format:?}");
        }
        assert_eq!(octets(Format::UNSIGNED8, 300.0), [255]);
        assert_eq!(octets(Format::INTEGER16, f64::NAN), i16::MIN.to_be_bytes());
        assert!(fits(Format::FLOAT, Format::DOUBLE_WORD) && fits(Format::V2, Format::WORD));
        assert!(!fits(Format::FLOAT, Format::UNSIGNED32) && !fits(Format::UNSIGNED16, Format::BYTE));
    }
}
