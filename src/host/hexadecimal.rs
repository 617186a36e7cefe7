//! Octets as a person writes them.

/// Octets in hexadecimal, with or without blanks; `None` if this is something else.
pub(crate) fn octets_of_hex(text: &str) -> Option<Vec<u8>> {
    let digits: Vec<_> = text.chars().filter(|letter| !letter.is_whitespace()).collect();
    let (pairs, []) = digits.as_chunks::<2>() else { return None };
    let octet = |[high, low]: &[char; 2]| Some(high.to_digit(16)? << 4 | low.to_digit(16)?);
    pairs.iter().map(|pair| u8::try_from(octet(pair)?).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octets_are_two_digits_each() {
        assert_eq!(octets_of_hex("01 fF\tA0"), Some(vec![1, 0xFF, 0xA0]));
        assert_eq!(octets_of_hex("01FF"), Some(vec![1, 0xFF]));
        assert_eq!(octets_of_hex(""), Some(Vec::new()));
        for wrong in ["1", "0x01", "01 F", "gg", "é1"] {
            assert_eq!(octets_of_hex(wrong), None, "{wrong}");
        }
    }
}
