//! A value of a device as the object dictionary of its bus has it: part of the row of a parameter.

pub(crate) use crate::can_bus::canopen::value::DataType;

/// An entry of an object dictionary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObjectEntry {
    /// Index and sub-index.
    pub(crate) at: (u16, u8),
    /// Its type.
    pub(crate) data: DataType,
    /// The name in the manual.
    pub(crate) name: &'static str,
}
