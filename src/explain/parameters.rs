//! Requests and responses of parameters by record 47 in words.

use super::field::{Field, Mark, hex};
use crate::profibus::dpv1::base_mode::description::{ARRAY, CANNOT_BE_WRITTEN, HAS_TEXTS, UNITS};
use crate::profibus::dpv1::base_mode::{
    ADDRESS_LEN, Attribute, Format, HEAD_LEN, Head, ParameterAddress, Service, Values,
};

/// A request that is written to record 47 and whose data begin at octet `at`; `None` if it has no head.
pub(super) fn request(data: &[u8], at: usize) -> Option<(String, Vec<Field>)> {
    let (head, mut rest) = Head::of_request(data)?;
    let mut parts = Parts::of(data, at, &head);
    let mut names = Vec::new();
    for _ in 0..head.parameters {
        let Some((address, behind)) = ParameterAddress::split(rest) else {
            return Some(parts.cut("the addresses are cut off"));
        };
        let name = address_words(&address);
        parts.push("Parameter_Address", ADDRESS_LEN, &name);
        names.push(name);
        rest = behind;
    }
    let words = match head.service {
        Service::Read => format!("reads {}", names.join(", ")),
        Service::Change => {
            let mut changes = Vec::new();
            for name in &names {
                let Some((values, behind)) = Values::split(rest) else {
                    return Some(parts.cut("the values are cut off"));
                };
                let text = values_text(&values);
                parts.push("Parameter_Value", rest.len().saturating_sub(behind.len()), &text);
                changes.push(format!("{name} = {text}"));
                rest = behind;
            }
            format!("sets {}", changes.join(", "))
        }
        Service::Unknown(number) => format!("asks for the unknown service {number:02X}"),
    };
    Some((format!("request {}: {words}", head.reference), parts.done()))
}

/// A response that was read from record 47; `None` if it has no head.
pub(super) fn response(data: &[u8], at: usize) -> Option<(String, Vec<Field>)> {
    let (head, mut rest) = Head::of_response(data)?;
    let mut parts = Parts::of(data, at, &head);
    if head.service == Service::Change && !head.failed {
        return Some((format!("response {}: changed", head.reference), parts.done()));
    }
    let mut words = Vec::new();
    for place in 1..=head.parameters {
        let Some((values, behind)) = Values::split(rest) else {
            return Some(parts.cut("the values are cut off"));
        };
        let len = rest.len().saturating_sub(behind.len());
        rest = behind;
        match values.error() {
            None => {
                let text =
                    if values.format == Format::ZERO { "changed".into() } else { values_text(&values) };
                parts.push("Parameter_Value", len, &text);
                words.push(text);
            }
            Some((error, info)) => {
                let of = if error.names_subindex() { format!(", sub-index {info}") } else { String::new() };
                let text = format!("{} (error {:02X}{of})", error.words(), error.0);
                parts.push("Parameter_Value", len, &text);
                parts.trouble(error.cure());
                words.push(if head.parameters == 1 { text } else { format!("parameter {place}: {text}") });
            }
        }
    }
    Some((format!("response {}: {}", head.reference, words.join(", ")), parts.done()))
}

/// `PNU 964 [0..5]`, `the description of PNU 922`
fn address_words(address: &ParameterAddress) -> String {
    let ParameterAddress { attribute, elements, pnu, subindex } = *address;
    let place = match elements {
        0 | 1 if subindex == 0 => format!("PNU {pnu}"),
        0 | 1 => format!("PNU {pnu} [{subindex}]"),
        2.. => {
            format!("PNU {pnu} [{subindex}..{}]", u32::from(subindex).saturating_add(u32::from(elements) - 1))
        }
    };
    match attribute {
        Attribute::Value => place,
        Attribute::Description => format!("the description of {place}"),
        Attribute::Text => format!("the text of {place}"),
        Attribute::Unknown(number) => format!("the unknown attribute {number:02X} of {place}"),
    }
}

/// Values of a parameter as a person reads them: numbers, a text, octets.
pub(crate) fn values_text(values: &Values<'_>) -> String {
    let Values { format, octets, .. } = *values;
    match format {
        Format::VISIBLE_STRING => {
            let text = String::from_utf8_lossy(octets);
            return format!("'{}'", text.trim_end_matches([' ', '\0']));
        }
        Format::OCTET_STRING => return hex(octets),
        _ => {}
    }
    let size = format.size().filter(|size| *size > 0).unwrap_or(1);
    let texts: Vec<_> = octets.chunks(size).map(|octets| value_text(format, octets)).collect();
    if texts.is_empty() { "no value".into() } else { texts.join(", ") }
}

/// The whole description of a parameter as a person reads it; `None`: these octets are none.
pub(crate) fn description_text(octets: &[u8]) -> Option<String> {
    let &[i1, i0, c1, c0, _, _, _, _, variable, conversion, _, _, _, _, ref rest @ ..] = octets else {
        return None;
    };
    let (name, rest) = rest.split_first_chunk::<16>()?;
    let (low, rest) = rest.split_first_chunk::<4>()?;
    let (high, rest) = rest.split_first_chunk::<4>()?;
    let identifier = u16::from_be_bytes([i1, i0]);
    let format = Format(i0);
    if rest.len() != 8 {
        return None;
    }
    let mut text = values_text(&Values { format: Format::VISIBLE_STRING, count: 16, octets: name });
    text.push_str(&format!(", {}", format.words()));
    if identifier & ARRAY != 0 {
        text.push_str(&format!(", {} elements", u16::from_be_bytes([c1, c0])));
    }
    // A limit is a double word, its value in the low octets.
    let size = format.size().filter(|size| (1..=4).contains(size)).unwrap_or(4);
    let limit = |octets: &[u8; 4]| value_text(format, octets.get(4 - size..).unwrap_or_default());
    text.push_str(&format!(", {} to {}", limit(low), limit(high)));
    if let Some((unit, _)) = UNITS.iter().find(|(_, indices)| *indices == [variable, conversion]) {
        text.push_str(&format!(" {unit}"));
    }
    text.push_str(if identifier & CANNOT_BE_WRITTEN == 0 {
        ", can be written"
    } else {
        ", can only be read"
    });
    if identifier & HAS_TEXTS != 0 {
        text.push_str(", has texts");
    }
    Some(text)
}

fn value_text(format: Format, octets: &[u8]) -> String {
    let unsigned = octets.iter().fold(0_u64, |value, octet| value << 8 | u64::from(*octet));
    let signed = || {
        let bits = 64 - 8 * u32::try_from(octets.len()).unwrap_or(8).min(8);
        #[expect(clippy::cast_possible_wrap, reason = "the sign is that of the highest octet")]
        let shifted = (unsigned << bits) as i64;
        shifted >> bits
    };
    match format {
        Format::BOOLEAN => if unsigned == 0 { "false" } else { "true" }.into(),
        Format::INTEGER8 | Format::INTEGER16 | Format::INTEGER32 => signed().to_string(),
        Format::UNSIGNED8 | Format::UNSIGNED16 | Format::UNSIGNED32 | Format::TIME_DIFFERENCE => {
            unsigned.to_string()
        }
        Format::FLOAT => {
            octets.first_chunk().map_or_else(|| hex(octets), |octets| f32::from_be_bytes(*octets).to_string())
        }
        #[expect(clippy::cast_precision_loss, reason = "32 bits at most")]
        Format::N2 => format!("{} ({:.2} %)", signed(), signed() as f64 / 163.84),
        #[expect(clippy::cast_precision_loss, reason = "32 bits at most")]
        Format::N4 => format!("{} ({:.2} %)", signed(), signed() as f64 / 10_737_418.24),
        Format::BYTE | Format::WORD | Format::DOUBLE_WORD => {
            format!("{unsigned} ({}h)", hex(octets).replace(' ', ""))
        }
        _ => format!("{}h", hex(octets).replace(' ', "")),
    }
}

/// The fields of a block, from its front to its end.
struct Parts<'a> {
    rest: &'a [u8],
    at: usize,
    fields: Vec<Field>,
}

impl<'a> Parts<'a> {
    fn of(data: &'a [u8], at: usize, head: &Head) -> Self {
        let service = match (head.service, head.failed) {
            (Service::Read, false) => "values are read",
            (Service::Read, true) => "values are read, and some were refused",
            (Service::Change, false) => "values are changed",
            (Service::Change, true) => "values are changed, and some were refused",
            (Service::Unknown(_), _) => "an unknown service",
        };
        let mut this = Self { rest: data, at, fields: Vec::new() };
        this.push("Request_Reference", 1, "");
        this.push("Request_ID", 1, service);
        this.push("Axis", 1, "");
        let many = if head.parameters == 1 {
            "1 parameter".into()
        } else {
            format!("{} parameters", head.parameters)
        };
        this.push("No_of_Parameters", HEAD_LEN - 3, &many);
        this
    }

    fn push(&mut self, name: &str, len: usize, meaning: &str) {
        let (taken, rest) = self.rest.split_at_checked(len).unwrap_or((self.rest, &[]));
        if !taken.is_empty() {
            self.fields.push(Field::octets(name, self.at, taken, meaning));
        }
        self.rest = rest;
        self.at = self.at.saturating_add(taken.len());
    }

    /// The last one tells of trouble.
    fn trouble(&mut self, cure: &str) {
        if let Some(field) = self.fields.pop() {
            let field = field.marked(Mark::Trouble);
            self.fields.push(if cure.is_empty() { field } else { field.hinted(cure) });
        }
    }

    /// What is left is no part of it.
    fn cut(mut self, why: &str) -> (String, Vec<Field>) {
        let len = self.rest.len();
        self.push("data", len, "");
        if let Some(field) = self.fields.pop() {
            self.fields.push(field.mistaken(why));
        }
        (format!("a request of parameters that cannot be read: {why}"), self.fields)
    }

    fn done(mut self) -> Vec<Field> {
        let len = self.rest.len();
        self.push("detail", len, "");
        self.fields
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn octets(text: &str) -> Vec<u8> {
        text.split(' ').map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect()
    }

    #[test]
    fn a_description_says_name_format_limits_and_unit() {
        let text = |hex: &str| description_text(&octets(hex));
        let maximum = "00 08 00 00 3F 80 00 00 0B 43 00 00 00 00 4D 61 78 69 6D 75 6D 20 73 70 65 65 64 20 20 20 \
            00 00 00 00 48 4D 14 00 00 00 00 00 00 00 00 00";
        let expected = "'Maximum speed', floating point, 0 to 210000 rpm, can be written";
        assert_eq!(text(maximum).as_deref(), Some(expected));
        let words = "46 03 00 07 3F 80 00 00 00 00 00 00 00 00 41 20 20 20 20 20 20 20 20 20 20 20 20 20 20 20 \
            FF FF 80 00 00 00 7F FF 00 00 00 00 00 00 00 00";
        let expected = "'A', integer of 16 bits, 7 elements, -32768 to 32767, can only be read, has texts";
        assert_eq!(text(words).as_deref(), Some(expected));
        assert_eq!(text("00 08 00 00"), None);
    }

    #[test]
    fn the_examples_of_the_reference_say_which_parameter_and_why_not() {
        for (hex, line) in [
            ("01 01 00 01 10 06 03 C4 00 00", "request 1: reads PNU 964 [0..5]"),
            ("03 02 00 01 10 00 03 C5 00 00 42 01 00 01", "request 3: sets PNU 965 = 1 (0001h)"),
            (
                "04 01 00 02 10 00 03 9A 00 00 20 00 00 01 00 03",
                "request 4: reads PNU 922, the description of PNU 1 [3]",
            ),
            (
                "02 01 00 02 10 00 03 9A 00",
                "a request of parameters that cannot be read: the addresses are cut off",
            ),
            (
                "02 02 00 01 10 00 03 9A 00 00 42 02 00 01",
                "a request of parameters that cannot be read: the values are cut off",
            ),
            ("05 07 00 00", "request 5: asks for the unknown service 07"),
        ] {
            let data = octets(hex);
            let (words, fields) = request(&data, 11).unwrap();
            assert_eq!(words, line);
            assert_eq!(fields.iter().map(|field| field.len).sum::<usize>(), data.len(), "{line}");
        }
        for (hex, line) in [
            (
                "01 01 00 01 06 06 00 2A 00 01 00 64 07 EA 0B 16 00 01",
                "response 1: 42, 1, 100, 2026, 2838, 1",
            ),
            ("03 82 00 01 44 02 00 01 00 00", "response 3: not changeable (error 01, sub-index 0)"),
            (
                "04 81 00 02 42 01 00 01 44 01 00 00",
                "response 4: 1 (0001h), parameter 2: no such parameter (error 00)",
            ),
            ("02 02 01 01", "response 2: changed"),
        ] {
            let data = octets(hex);
            let (words, fields) = response(&data, 11).unwrap();
            assert_eq!(words, line);
            assert_eq!(fields.iter().map(|field| field.len).sum::<usize>(), data.len(), "{line}");
        }
        let (_, fields) = response(&octets("03 82 00 01 44 02 00 01 00 00"), 0).unwrap();
        let value = fields.last().unwrap();
        assert_eq!((value.mark, value.hints.len()), (Mark::Trouble, 1));
        assert_eq!((request(&[1, 2], 0), response(&[], 0)), (None, None));
    }

    #[test]
    fn values_are_said_by_their_format() {
        for (format, octets, text) in [
            (Format::INTEGER8, &[0xFE][..], "-2"),
            (Format::INTEGER16, &[0xFF, 0xFE, 0, 5], "-2, 5"),
            (Format::INTEGER32, &[0xFF, 0xFF, 0xFF, 0xFF], "-1"),
            (Format::FLOAT, &[0x3F, 0xC0, 0, 0], "1.5"),
            (Format::VISIBLE_STRING, b"abc  ", "'abc'"),
            (Format::OCTET_STRING, &[3, 0x2A], "03 2A"),
            (Format::N2, &[0x20, 0], "8192 (50.00 %)"),
            (Format::V2, &[0x20, 0x01], "2001h"),
            (Format::BOOLEAN, &[1], "true"),
            (Format::ZERO, &[], "no value"),
        ] {
            let count = u8::try_from(octets.len() / format.size().unwrap().max(1)).unwrap();
            assert_eq!(values_text(&Values { format, count, octets }), text);
        }
    }
}
