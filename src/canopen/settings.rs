//! Reads and writes of the objects that the node keeps.

use super::abort::Abort;
use super::application::{Application, Written};
use super::dictionary::Entry;
use super::node::Node;
use super::parameter::Parameter;
use crate::time::Instant;

impl Node {
    /// The value of an object that the node keeps.
    pub(super) fn parameter(&self, parameter: Parameter) -> Result<u32, Abort> {
        Ok(self.values.value(parameter))
    }

    /// Writes an object that the node keeps and does what follows from it.
    pub(super) fn write_parameter(
        &mut self,
        _now: Instant,
        parameter: Parameter,
        _entry: &'static Entry,
        value: u32,
        _app: &mut dyn Application,
    ) -> Result<Written, Abort> {
        self.values.set(parameter, value);
        Ok(Written::Done)
    }
}
