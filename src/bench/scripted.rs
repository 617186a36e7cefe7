//! A master that the test scripts, telegram by telegram.

use super::{Breach, Line, Master};
use crate::profibus::dp::MASTER_SAP;
use crate::profibus::fdl::telegram::{Decoded, EncodeError, decode};
use crate::profibus::fdl::{
    Address, DataTelegram, FrameCount, Function, FunctionCode, MAX_TELEGRAM_LEN, ReplyStatus, Sap, Service,
    Telegram,
};

/// A master that sends what it is told, counts its requests to each station, and repeats what was not answered.
#[derive(Clone, Debug)]
pub struct ScriptedMaster {
    address: Address,
    /// How often a request is repeated at most.
    pub retry_limit: u32,
    /// Requests repeated so far.
    pub retries: u64,
    /// The frame count of the last request to each station, `None` before the first.
    counts: Vec<Option<FrameCount>>,
}

/// FCS and ED.
const TRAILER_LEN: usize = 2;

/// What a master made of the answer to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer<'a> {
    /// Nothing within the slot time, or nothing whole, after all retries.
    Silence,
    /// SC.
    ShortAcknowledge,
    /// A status without data: OK, RR, RS, or DH of a slave without inputs.
    Status(ReplyStatus),
    /// Data, with their priority as status.
    Data(ReplyStatus, &'a [u8]),
}

impl ScriptedMaster {
    /// A master that has not sent anything and repeats each request once.
    pub fn new(address: Address) -> Self {
        let mut counts = Vec::new();
        counts.resize(usize::from(Address::BROADCAST.number()), None);
        Self { address, retry_limit: 1, retries: 0, counts }
    }

    /// Its address.
    pub const fn address(&self) -> Address {
        self.address
    }

    /// Sends data that want a reply to `da`, high priority: Data_Exchange without `dsap`, else that service. Repeats
    /// it as often as allowed while no whole answer comes; then the next request to `da` is a first one again.
    ///
    /// # Errors
    /// The first [`Breach`]. Data longer than a telegram carries are not sent: that is silence.
    pub fn srd<'l, M: Master>(
        &mut self,
        line: &'l mut Line<M>,
        da: Address,
        dsap: Option<Sap>,
        data: &[u8],
    ) -> Result<Answer<'l>, Breach> {
        let Some(place) = self.counts.get_mut(usize::from(da.number())) else {
            return Ok(Answer::Silence);
        };
        let count = match place {
            None => FrameCount::First,
            Some(FrameCount::First | FrameCount::Odd | FrameCount::Unused) => FrameCount::Even,
            Some(FrameCount::Even) => FrameCount::Odd,
        };
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let fc = FunctionCode::request(Service::SrdHigh, count);
        let Ok(request) = encode(self.address, da, fc, dsap, data, &mut buf) else {
            return Ok(Answer::Silence);
        };
        for attempt in 0..=self.retry_limit {
            self.retries += u64::from(attempt > 0);
            let heard = line.request(request)?.and_then(|octets| Heard::of(octets, self.address, da));
            if let Some(heard) = heard {
                *place = Some(count);
                return Ok(heard.answer(&line.octets));
            }
        }
        *place = None;
        Ok(Answer::Silence)
    }

    /// Sends data without acknowledge, high priority: Global_Control to SAP 58, say.
    ///
    /// # Errors
    /// The first [`Breach`]. Data longer than a telegram carries are not sent.
    pub fn sdn<M: Master>(
        &mut self,
        line: &mut Line<M>,
        da: Address,
        dsap: Sap,
        data: &[u8],
    ) -> Result<(), Breach> {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let fc = FunctionCode::request(Service::SdnHigh, FrameCount::Unused);
        match encode(self.address, da, fc, Some(dsap), data, &mut buf) {
            Ok(octets) => line.send(octets).map(|_| ()),
            Err(_) => Ok(()),
        }
    }

    /// Asks for the FDL status of `da`: whether anybody is there.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn fdl_status<M: Master>(&mut self, line: &mut Line<M>, da: Address) -> Result<bool, Breach> {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let fc = FunctionCode::request(Service::FdlStatus, FrameCount::Unused);
        let Ok(request) = encode(self.address, da, fc, None, &[], &mut buf) else {
            return Ok(false);
        };
        Ok(line.request(request)?.is_some_and(|octets| Heard::of(octets, self.address, da).is_some()))
    }

    /// Passes the token to another master.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn pass_token<M: Master>(&mut self, line: &mut Line<M>, to: Address) -> Result<(), Breach> {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let token = Telegram::Token { da: to, sa: self.address };
        line.send(token.encode(&mut buf).unwrap_or_default()).map(|_| ())
    }
}

fn encode<'b>(
    sa: Address,
    da: Address,
    fc: FunctionCode,
    dsap: Option<Sap>,
    data: &[u8],
    buf: &'b mut [u8; MAX_TELEGRAM_LEN],
) -> Result<&'b [u8], EncodeError> {
    let ssap = dsap.and(MASTER_SAP);
    let format = DataTelegram::customary_format(dsap, ssap, data);
    DataTelegram { format, da, sa, dsap, ssap, fc, data }.encode(buf)
}

/// One whole answer, apart from its octets: while those are borrowed nothing can be asked again.
#[derive(Clone, Copy)]
enum Heard {
    ShortAcknowledge,
    /// Its status, and how many octets of data lie before FCS and ED.
    Response(ReplyStatus, usize),
}

impl Heard {
    /// The answer of `station` to `master`, if `octets` are one.
    fn of(octets: &[u8], master: Address, station: Address) -> Option<Self> {
        let Decoded::Telegram { telegram, len } = decode(octets) else {
            return None;
        };
        if len != octets.len() {
            return None;
        }
        match telegram {
            Telegram::ShortAcknowledge => Some(Self::ShortAcknowledge),
            Telegram::Token { .. } => None,
            Telegram::Data(data) if (data.da, data.sa) != (master, station) => None,
            Telegram::Data(data) => match data.fc.function() {
                Function::Response(_, status) => Some(Self::Response(status, data.data.len())),
                Function::Request(..) | Function::Reserved => None,
            },
        }
    }

    /// Its meaning, with the data in its octets.
    fn answer(self, octets: &[u8]) -> Answer<'_> {
        match self {
            Self::ShortAcknowledge => Answer::ShortAcknowledge,
            Self::Response(status, 0) => Answer::Status(status),
            Self::Response(status, count) => {
                let end = octets.len().saturating_sub(TRAILER_LEN);
                Answer::Data(status, octets.get(end.saturating_sub(count)..end).unwrap_or_default())
            }
        }
    }
}
