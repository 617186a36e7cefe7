//! Emergencies: what a device reports, and the codes of the node itself (`canopen-link.md` 7).

/// An event that a device reports, or its end.
///
/// ```text
/// octets 0..1  code, low octet first
/// octet  2     error register 1001h
/// octets 3..7  of the device
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Emergency {
    /// The code, 0000h when errors are gone.
    pub code: u16,
    /// The device's bits of the error register from now on. Bit 0 is set by the node while any other is.
    pub register: u8,
    /// Bits 31..16 of the entry in the history.
    pub information: u16,
    /// Octets 3..7 of the frame.
    pub octets: [u8; 5],
    /// Whether it goes into the history. Code 0000h never does.
    pub in_history: bool,
}

impl Emergency {
    /// An error that goes into the history.
    pub const fn new(code: u16, register: u8) -> Self {
        Self { code, register, information: 0, octets: [0; 5], in_history: true }
    }

    /// The end of errors; `register` is what is left of them.
    pub const fn gone(register: u8) -> Self {
        Self { in_history: false, ..Self::new(0, register) }
    }
}

/// An RPDO was too short.
pub(super) const RPDO_LENGTH: u16 = 0x8210;
/// Life guarding or heartbeat failed.
pub(super) const ERROR_CONTROL: u16 = 0x8130;

/// Bit 4 of the error register: communication.
pub(crate) const COMMUNICATION: u8 = 1 << 4;

/// What a device calls its errors.
#[derive(Clone, Copy, Debug)]
pub struct ErrorNames {
    /// What an EMCY code means with the device's octets behind it; `None`: nothing is known.
    pub emcy: fn(u16, [u8; 5]) -> Option<&'static str>,
    /// The bits of the error register 1001h, bit 0 first.
    pub register: [&'static str; 8],
}

impl ErrorNames {
    /// Those of CiA 301, which every device has.
    pub const CIA_301: Self = Self { emcy: |code, _| Some(class(code)), register: REGISTER };

    /// The bits of an error register that are 1, the lowest first.
    pub(crate) fn set_in(&self, register: u8) -> impl Iterator<Item = &'static str> {
        let bits = (0..8_u8).zip(self.register);
        bits.filter(move |(bit, _)| register >> bit & 1 == 1).map(|(_, name)| name)
    }
}

/// Functions cannot be compared; devices differ in the names of bits, and an event in its code.
impl PartialEq for ErrorNames {
    fn eq(&self, other: &Self) -> bool {
        self.register == other.register
    }
}

impl Eq for ErrorNames {}

/// The bits of 1001h in CiA 301.
pub(crate) const REGISTER: [&str; 8] = [
    "generic error",
    "current",
    "voltage",
    "temperature",
    "communication",
    "device profile",
    "reserved",
    "manufacturer",
];

/// The class of an EMCY code in CiA 301.
pub(crate) const fn class(code: u16) -> &'static str {
    match code {
        0x0000..=0x00FF => "no error, or an error is gone",
        0x0100..=0x10FF => "generic error",
        0x1100..=0x1FFF => "reserved",
        0x2000..=0x2FFF => "current",
        0x3000..=0x3FFF => "voltage",
        0x4000..=0x4FFF => "temperature",
        0x5000..=0x5FFF => "hardware of the device",
        0x6000..=0x6FFF => "software of the device",
        0x7000..=0x7FFF => "additional modules",
        0x8110 => "CAN overrun",
        0x8120 => "CAN error passive",
        0x8130 => "life guarding or heartbeat error",
        0x8140 => "recovered from bus off",
        0x8210 => "PDO not processed: too short",
        0x8220 => "PDO too long",
        0x8000..=0x81FF => "communication",
        0x8200..=0x82FF => "protocol error",
        0x8300..=0x8FFF => "monitoring",
        0x9000..=0x9FFF => "external error",
        0xA000..=0xEFFF => "reserved",
        0xF000..=0xFEFF => "additional functions",
        0xFF00.. => "of the device",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_a_class() {
        for (code, name) in [
            (0x0000, "no error, or an error is gone"),
            (0x3210, "voltage"),
            (0x8130, "life guarding or heartbeat error"),
            (0x8150, "communication"),
            (0x8210, "PDO not processed: too short"),
            (0x8211, "protocol error"),
            (0xFF01, "of the device"),
        ] {
            assert_eq!(class(code), name);
        }
    }
}
