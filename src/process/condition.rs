//! What must hold of a value.

/// A comparison with a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// It has this value.
    Is(f64),
    /// It is greater.
    Above(f64),
    /// It is less.
    Below(f64),
}

impl Condition {
    /// Whether it holds for a value.
    pub(crate) fn holds(self, value: f64) -> bool {
        match self {
            Self::Is(wanted) => value == wanted,
            Self::Above(limit) => value > limit,
            Self::Below(limit) => value < limit,
        }
    }

    /// What it compares with.
    pub(crate) const fn limit(self) -> f64 {
        let (Self::Is(limit) | Self::Above(limit) | Self::Below(limit)) = self;
        limit
    }
}
