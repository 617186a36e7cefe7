//! What the parameter channel asks of a device: a table of parameters.

use core::fmt;

use super::JobError;

/// The parameters of a device, by number (0 to 2047) and, of an array, by element counted from 0.
///
/// A refused access says why as [`JobError`] and changes nothing. What a table does not keep while it is switched off, and
/// which values it has, the channel does not know.
pub trait Parameters {
    /// The value of a parameter, or of one element of an array.
    ///
    /// # Errors
    /// [`JobError`]: no such parameter, an element missing or too much, nothing to read.
    fn read(&self, pnu: u16, element: Option<u8>) -> Result<Value, JobError>;

    /// Writes a parameter, or one element of an array.
    ///
    /// # Errors
    /// [`JobError`]: as [`read`](Self::read), and what is wrong with the value or the moment.
    fn write(&mut self, pnu: u16, element: Option<u8>, value: Value) -> Result<Written, JobError>;

    /// How many elements the array has; `None`: it is a single value.
    ///
    /// # Errors
    /// [`JobError::UnknownParameter`].
    fn elements(&self, pnu: u16) -> Result<Option<u8>, JobError>;

    /// The four octets of an element of the description of a parameter (`profidrive-v2.md` 6). A table without
    /// descriptions leaves this out.
    ///
    /// # Errors
    /// [`JobError`]: no such parameter, no description, no such element, one of more than four octets.
    fn describe(&self, pnu: u16, element: u8) -> Result<u32, JobError> {
        let _ = element;
        self.elements(pnu).and(Err(JobError::NoDescription))
    }
}

/// What a write came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// The value that the reply shows: for a parameter the one written.
    pub shown: Value,
    /// The value must be safe before it is acknowledged: the reply waits for [`Engine::stored`](super::Engine::stored) or
    /// `Engine::store_failed`.
    pub waits: bool,
}

impl Written {
    /// A value that is written and acknowledged at once.
    pub const fn at_once(shown: Value) -> Self {
        Self { shown, waits: false }
    }
}

/// A value as a job or a reply carries it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Value {
    /// 16 bits, in word 4.
    Word(u16),
    /// 32 bits, in words 3 and 4.
    Double(u32),
}

impl Value {
    /// How wide it is.
    pub const fn width(self) -> Width {
        match self {
            Self::Word(_) => Width::Word,
            Self::Double(_) => Width::Double,
        }
    }

    /// The bits, zero-extended.
    pub const fn bits(self) -> u32 {
        match self {
            Self::Word(word) => word as u32,
            Self::Double(double) => double,
        }
    }
}

/// How wide a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Width {
    /// 16 bits.
    Word,
    /// 32 bits.
    Double,
}

impl fmt::Display for Width {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Word => "word",
            Self::Double => "double word",
        })
    }
}
