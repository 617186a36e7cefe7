//! The texts of the diagnosis. Bits count from the octet behind the header of their block, the lowest bit first.

/// Unit_Diag_Bit: the text of one bit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagBit {
    /// The bit.
    pub bit: u16,
    /// The text is shown when the bit is 0 (`Unit_Diag_!Bit`).
    pub inverted: bool,
    /// The text.
    pub text: String,
}

/// Unit_Diag_Area: the texts of a number of several bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagArea {
    /// Its lowest bit.
    pub first: u16,
    /// Its highest bit.
    pub last: u16,
    /// Value and text.
    pub values: Vec<(i64, String)>,
}

/// UnitDiagType: the texts of a status block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagType {
    /// The type, the first octet behind the header.
    pub number: u8,
    /// X_Unit_Diag_Bit.
    pub bits: Vec<DiagBit>,
    /// X_Unit_Diag_Area.
    pub areas: Vec<DiagArea>,
}

/// The type of the module status.
pub(super) const MODULE_STATUS: u8 = 0x82;

impl super::Gsd {
    /// Whether it has texts for "wrong module" and "no module": in the module status, or in areas of two bits behind its head
    /// (`gsd.md` 5.2, 5.3).
    pub fn has_module_status(&self) -> bool {
        let says_it = |area: &DiagArea| {
            let (wrong, missing) = (2, 3);
            let has = |value| area.values.iter().any(|text| text.0 == value);
            area.first >= 24 && area.last == area.first + 1 && (has(wrong) || has(missing))
        };
        self.diag_types.iter().any(|status| status.number == MODULE_STATUS)
            || self.diag_areas.iter().any(says_it)
    }
}
