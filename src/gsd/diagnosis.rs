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
