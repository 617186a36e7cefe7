//! What tells a retry from a new request.

use crate::fdl::telegram::MAX_PDU_LEN;
use crate::fdl::{Address, DataTelegram, FrameCount, Function, FunctionCode, Sap};

/// What identifies a counted request; its repetition is a retry.
pub(super) struct LastRequest {
    /// Everything but the data; `None` for what has no frame count.
    header: Option<Header>,
    data: [u8; MAX_PDU_LEN],
    len: usize,
}

#[derive(Clone, Copy, PartialEq, Eq)]
struct Header {
    fc: FunctionCode,
    sa: Address,
    dsap: Option<Sap>,
    ssap: Option<Sap>,
}

impl LastRequest {
    /// Before the first request.
    pub(super) const NONE: Self = Self { header: None, data: [0; MAX_PDU_LEN], len: 0 };

    /// Takes a request, in place of the one before. Whether it repeats that.
    pub(super) fn take(&mut self, request: &DataTelegram<'_>) -> bool {
        let counted = match request.fc.function() {
            Function::Request(_, FrameCount::Even | FrameCount::Odd) => true,
            Function::Request(_, FrameCount::Unused | FrameCount::First)
            | Function::Response(..)
            | Function::Reserved => false,
        };
        let DataTelegram { fc, sa, dsap, ssap, data, .. } = *request;
        let header = counted.then_some(Header { fc, sa, dsap, ssap });
        if counted && self.header == header && self.data.get(..self.len) == Some(data) {
            return true;
        }
        self.header = header;
        self.len = data.len();
        match self.data.get_mut(..data.len()) {
            Some(room) => room.copy_from_slice(data),
            None => self.header = None,
        }
        false
    }
}
