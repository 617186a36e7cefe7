//! What tells a retry from a new request.

use crate::profibus::fdl::telegram::MAX_PDU_LEN;
use crate::profibus::fdl::{Address, DataTelegram, FrameCount, Function, FunctionCode, Sap};

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
        if self.is_repeated_by(request) {
            return true;
        }
        let data = request.data;
        self.header = Header::of(request);
        self.len = data.len();
        match self.data.get_mut(..data.len()) {
            Some(room) => room.copy_from_slice(data),
            None => self.header = None,
        }
        false
    }

    /// Whether a request repeats this one.
    pub(super) fn is_repeated_by(&self, request: &DataTelegram<'_>) -> bool {
        self.header.is_some()
            && self.header == Header::of(request)
            && self.data.get(..self.len) == Some(request.data)
    }
}

impl Header {
    fn of(request: &DataTelegram<'_>) -> Option<Self> {
        match request.fc.function() {
            Function::Request(_, FrameCount::Even | FrameCount::Odd) => {
                let DataTelegram { fc, sa, dsap, ssap, .. } = *request;
                Some(Self { fc, sa, dsap, ssap })
            }
            Function::Request(_, FrameCount::Unused | FrameCount::First)
            | Function::Response(..)
            | Function::Reserved => None,
        }
    }
}
