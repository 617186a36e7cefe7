//! The two set points: what the master sent, whether it is valid and whether a person acknowledged it.

use super::words::{Control, ControlBit};

/// Which of the two set points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Slot {
    /// Set point 1, of RPDO1; row 1 in alpha-numeric mode.
    One,
    /// Set point 2, of RPDO2; row 2 in alpha-numeric mode.
    Two,
}

impl Slot {
    /// Both.
    pub(crate) const ALL: [Self; 2] = [Self::One, Self::Two];

    /// The bit of the control word that makes it valid.
    pub(super) const fn valid_bit(self) -> ControlBit {
        match self {
            Self::One => ControlBit::SetPoint1Valid,
            Self::Two => ControlBit::SetPoint2Valid,
        }
    }

    const fn acknowledge_bit(self) -> ControlBit {
        match self {
            Self::One => ControlBit::AcknowledgeSetPoint1,
            Self::Two => ControlBit::AcknowledgeSetPoint2,
        }
    }
}

/// What a valid set point says: the six octets and whether they are characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Content {
    low: u32,
    high: u16,
    ascii: bool,
}

/// One set point.
///
/// ```text
/// octets 0..3  number, low octet first, or characters 1..4
/// octets 4..5  characters 5 and 6
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SetPoint {
    pub(super) low: u32,
    pub(super) high: u32,
    ascii: bool,
    /// What is in force, `None` while it is not valid.
    content: Option<Content>,
    acknowledged: bool,
}

impl SetPoint {
    pub(super) const fn is_valid(&self) -> bool {
        self.content.is_some()
    }

    /// The number, `None` while it is not valid.
    pub(super) fn number(&self) -> Option<i32> {
        self.content.map(|content| content.low.cast_signed())
    }

    /// The six characters, `None` unless it is valid and ASCII. The first octet is the leftmost (CN-105).
    pub(super) fn characters(&self) -> Option<[u8; 6]> {
        let content = self.content.filter(|content| content.ascii)?;
        let ([a, b, c, d], [e, f]) = (content.low.to_le_bytes(), content.high.to_le_bytes());
        Some([a, b, c, d, e, f])
    }

    pub(super) const fn is_ascii(&self) -> bool {
        self.ascii
    }

    pub(super) const fn is_pending(&self) -> bool {
        self.is_valid() && !self.acknowledged
    }

    pub(super) const fn is_acknowledged(&self) -> bool {
        self.is_valid() && self.acknowledged
    }

    pub(super) const fn acknowledge(&mut self) {
        self.acknowledged = true;
    }

    /// A control word came; `own` if with this set point. A new content wants a new acknowledgement.
    pub(super) fn follow(&mut self, slot: Slot, control: Control, own: bool) {
        if own {
            self.ascii = control.has(ControlBit::Ascii);
        }
        #[expect(clippy::cast_possible_truncation, reason = "the upper half is not transmitted (CN-117)")]
        let content = Content { low: self.low, high: self.high as u16, ascii: self.ascii };
        let content = control.has(slot.valid_bit()).then_some(content);
        if content != self.content {
            self.content = content;
            self.acknowledged = false;
        }
        if control.has(slot.acknowledge_bit()) {
            self.acknowledged = true;
        }
    }
}
