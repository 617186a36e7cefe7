//! Words of bits by the names of their bits and states.

use crate::devices::ag03::drive::Mode;

/// A word that can be written in names.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NamedWord {
    /// As `STW`.
    pub(crate) name: &'static str,
    pub(crate) states: &'static [State],
    /// The name of each bit in an operating mode, bit 0 first; `None`: it is not used.
    pub(crate) bits: fn(Mode) -> [Option<&'static str>; 16],
}

/// Name of a state, its word in positioning and in velocity mode, if it exists there.
pub(crate) type State = (&'static str, Option<u16>, Option<u16>);

/// What a device writes in names on PROFIBUS.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NamedWords {
    /// The control word.
    pub(crate) stw: NamedWord,
    /// The status word.
    pub(crate) zsw: NamedWord,
}
