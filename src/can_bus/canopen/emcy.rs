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
