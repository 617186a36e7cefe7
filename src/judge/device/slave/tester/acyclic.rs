//! Services of DP-V1 as a master asks for them: a request, polls, the response.

use core::time::Duration;

use super::{Prm, Tester};
use crate::gsd::AcyclicKeywords;
use crate::judge::device::course::{Course, broken, inapplicable, missed};
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::request::Request;
use crate::profibus::dp::dpv1_status::Status1;
use crate::profibus::dpv1::connection::{
    Abort, AbortReason, AdditionalAddress, Initiate, Instance, READ_WRITE, Subnet, Terms,
};
use crate::profibus::dpv1::{
    ErrorCode, ErrorDecode, Failure, Function, MAX_DATA, MAX_PDU, MS1_SAP, RESOURCE_MANAGER_SAP, RequestPdu,
    ResponsePdu,
};
use crate::profibus::fdl::{self, ReplyStatus};
use crate::time::Instant;

/// The SAP of a master of class 2.
pub(in super::super) const CLASS_2_SAP: u8 = 50;
/// A response is waited for so long, unless the device file promises it later.
const PATIENCE: Duration = Duration::from_secs(5);
/// So many polls follow one another at once.
const FAST_POLLS: u32 = 20;
/// Between two polls later on.
const POLL_PAUSE: Duration = Duration::from_millis(2);
/// The unit of times of DP-V1.
pub(in super::super) const UNIT: Duration = Duration::from_millis(10);
/// Send_Timeout of a connection that a row uses for itself, times 10 ms.
const LONG: u16 = 6000;

/// Where and as whom a master asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) struct Channel {
    pub(in super::super) sa: u8,
    pub(in super::super) dsap: u8,
    pub(in super::super) ssap: u8,
}

impl Channel {
    pub(in super::super) const fn ms1(sa: u8) -> Self {
        Self { sa, dsap: MS1_SAP, ssap: MS1_SAP }
    }

    pub(in super::super) const fn ms2(sa: u8, dsap: u8) -> Self {
        Self { sa, dsap, ssap: CLASS_2_SAP }
    }
}

/// What a connection was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) struct Granted {
    pub(in super::super) channel: Channel,
    /// The least Send_Timeout of the slave, times 10 ms.
    pub(in super::super) least: u16,
}

/// Initiate with this Send_Timeout, times 10 ms.
pub(in super::super) fn initiate(send_timeout: u16) -> Vec<u8> {
    let terms = Terms {
        features: READ_WRITE,
        profile_features: 0,
        profile_ident: 0,
        source: AdditionalAddress::STATION,
        destination: AdditionalAddress::STATION,
    };
    let mut buf = [0; MAX_PDU];
    let pdu = RequestPdu::Initiate(Initiate { send_timeout, terms });
    pdu.encode(&mut buf).map(<[u8]>::to_vec).unwrap_or_default()
}

/// Abort by the user of the master.
pub(in super::super) fn abort() -> Vec<u8> {
    let abort = Abort { subnet: Subnet::None, instance: Instance::User, reason: AbortReason(0) };
    let mut buf = [0; MAX_PDU];
    RequestPdu::Abort(abort).encode(&mut buf).map(<[u8]>::to_vec).unwrap_or_default()
}

/// Whether a response refuses a service.
pub(in super::super) fn is_negative(octets: &[u8]) -> bool {
    octets.first().is_some_and(|function| function & Function::NEGATIVE != 0)
}

/// The service of a response, positive or negative.
pub(in super::super) fn service(octets: &[u8]) -> Option<Function> {
    Function::numbered(octets.first()? & !Function::NEGATIVE)
}

impl Tester {
    /// What the device file says of DP-V1.
    pub(in super::super) fn keywords(&self) -> Course<AcyclicKeywords> {
        match &self.setup.gsd {
            None => inapplicable("needs the device file: gsd="),
            Some(gsd) if !gsd.flags.dpv1 => inapplicable("the device file has no DPV1_Slave"),
            Some(gsd) => Ok(gsd.acyclic),
        }
    }

    /// It has MS1.
    pub(in super::super) fn has_ms1(&self) -> Course<Channel> {
        if self.keywords()?.c1 {
            Ok(Channel::ms1(self.owner()))
        } else {
            inapplicable("the device file has no C1_Read_Write_supp")
        }
    }

    /// It has MS2.
    pub(in super::super) fn has_ms2(&self) -> Course {
        if self.keywords()?.c2 { Ok(()) } else { inapplicable("the device file has no C2_Read_Write_supp") }
    }

    /// Set_Prm with DP-V1 enabled, and every alarm that is offered, one of a type at a time.
    pub(in super::super) fn prm_v1(&self) -> Prm {
        let alarms = self.setup.gsd.as_ref().map_or(0, |gsd| gsd.acyclic.alarms);
        let mut prm = self.prm().status(0, Status1::Enable.mask(), 0).status(1, alarms, 0);
        // Alarm_Mode is the lower half but for bit 3.
        prm = prm.status(2, 0, 0x07);
        prm
    }

    /// In data exchange, with MS1 open.
    pub(in super::super) fn open(&mut self) -> Course<Channel> {
        let channel = self.has_ms1()?;
        let prm = self.prm_v1();
        self.begin_with(&prm)?;
        Ok(channel)
    }

    /// A Read that every slave answers somehow.
    pub(in super::super) const fn probe() -> [u8; 4] {
        [Function::Read.number(), 0, 0, MAX_DATA]
    }

    /// A telegram, with the next frame count.
    pub(in super::super) fn telegram(&mut self, channel: Channel, data: &[u8]) -> Request {
        let Channel { sa, dsap, ssap } = channel;
        Request {
            da: self.slave(),
            sa,
            dsap: Some(dsap),
            ssap: Some(ssap),
            service: fdl::Service::SrdLow,
            count: self.next_count(sa),
            data: data.to_vec(),
            as_sd3: false,
        }
    }

    /// What layer 2 says to it.
    pub(in super::super) fn put(&mut self, channel: Channel, data: &[u8]) -> Course<Answer> {
        let request = self.telegram(channel, data);
        self.must_answer(&request)
    }

    /// It is answered so.
    pub(in super::super) fn put_is(
        &mut self,
        channel: Channel,
        data: &[u8],
        expected: &Answer,
        what: &str,
    ) -> Course {
        let answer = self.put(channel, data)?;
        if answer == *expected {
            return Ok(());
        }
        broken(format!("{what} is answered with {}, expected {}", answer.words(), expected.words()))
    }

    /// SC.
    pub(in super::super) fn taken(&mut self, channel: Channel, data: &[u8], what: &str) -> Course {
        self.put_is(channel, data, &Answer::Acknowledged, what)
    }

    /// RS.
    pub(in super::super) fn closed(&mut self, channel: Channel, data: &[u8], what: &str) -> Course {
        self.put_is(channel, data, &Answer::Status(ReplyStatus::NotActivated), what)
    }

    /// Polls until the response is there: the poll that brought it, and the response.
    pub(in super::super) fn polled(&mut self, channel: Channel) -> Course<(Request, Vec<u8>)> {
        let begun = self.wire.now();
        let patience = self.promised(channel).map_or(PATIENCE, |promised| PATIENCE.max(promised * 2));
        for number in 0_u32.. {
            let request = self.telegram(channel, &[]);
            match self.must_answer(&request)? {
                Answer::Data(_, octets) => {
                    self.notice_response(channel, begun, &octets);
                    return Ok((request, octets));
                }
                Answer::Acknowledged => {}
                answer @ (Answer::Status(_) | Answer::Silence | Answer::Wrong(_)) => {
                    let (sap, answer) = (channel.dsap, answer.words());
                    return broken(format!(
                        "a poll at SAP {sap} is answered with {answer}, expected SC or the response"
                    ));
                }
            }
            if self.wire.now().saturating_since(begun) > patience {
                break;
            }
            if number > FAST_POLLS {
                self.pause(POLL_PAUSE)?;
            }
        }
        broken(format!("no response at SAP {} within {} ms", channel.dsap, patience.as_millis()))
    }

    /// The response to what was asked.
    pub(in super::super) fn response(&mut self, channel: Channel) -> Course<Vec<u8>> {
        self.polled(channel).map(|(_, octets)| octets)
    }

    /// Asks, and polls until the response is there.
    pub(in super::super) fn carried_out(&mut self, channel: Channel, data: &[u8]) -> Course<Vec<u8>> {
        self.taken(channel, data, &format!("a request at SAP {}", channel.dsap))?;
        self.response(channel)
    }

    /// Reads a record: what is in it, or why not.
    pub(in super::super) fn read_record(
        &mut self,
        channel: Channel,
        (slot, index): (u8, u8),
        len: u8,
    ) -> Course<Result<Vec<u8>, Failure>> {
        let octets = self.carried_out(channel, &[Function::Read.number(), slot, index, len])?;
        match ResponsePdu::parse(&octets) {
            Ok(ResponsePdu::Read { slot: of, index: at, data }) if (of, at) == (slot, index) => {
                Ok(Ok(data.to_vec()))
            }
            Ok(_) | Err(_) => refused("Read", (slot, index), Function::Read, &octets).map(Err),
        }
    }

    /// Writes a record.
    pub(in super::super) fn write_record(
        &mut self,
        channel: Channel,
        (slot, index): (u8, u8),
        data: &[u8],
    ) -> Course<Result<(), Failure>> {
        let mut buf = [0; MAX_PDU];
        let pdu = RequestPdu::Write { slot, index, data };
        let Some(request) = pdu.encode(&mut buf).map(<[u8]>::to_vec) else {
            return missed(format!("a Write has no room for {} octets", data.len()));
        };
        let octets = self.carried_out(channel, &request)?;
        match ResponsePdu::parse(&octets) {
            Ok(ResponsePdu::Write { slot: of, index: at, len })
                if (of, at, usize::from(len)) == (slot, index, data.len()) =>
            {
                Ok(Ok(()))
            }
            Ok(_) | Err(_) => refused("Write", (slot, index), Function::Write, &octets).map(Err),
        }
    }

    /// Opens a connection.
    pub(in super::super) fn connect(&mut self, sa: u8, send_timeout: u16) -> Course<Granted> {
        let granted = self.ask_for_connection(sa, &initiate(send_timeout))?;
        let octets = self.response(granted.channel)?;
        match ResponsePdu::parse(&octets) {
            Ok(ResponsePdu::Initiate(_)) => Ok(granted),
            Ok(_) | Err(_) => {
                broken(format!("Initiate is answered with {}, expected 57 ..", crate::explain::hex(&octets)))
            }
        }
    }

    /// Initiate, and what the resource manager says.
    pub(in super::super) fn ask_for_connection(&mut self, sa: u8, data: &[u8]) -> Course<Granted> {
        let manager = Channel::ms2(sa, RESOURCE_MANAGER_SAP);
        let octets = self.carried_out(manager, data)?;
        match ResponsePdu::parse(&octets) {
            Ok(ResponsePdu::ResourceManager { sap, send_timeout }) if sap < RESOURCE_MANAGER_SAP => {
                Ok(Granted { channel: Channel::ms2(sa, sap), least: send_timeout })
            }
            Ok(_) | Err(_) => broken(format!(
                "SAP 49 answers Initiate with {}, expected 56 with a SAP of 0 to 48 and a time",
                crate::explain::hex(&octets)
            )),
        }
    }

    /// Ends a connection, whatever has become of it.
    pub(in super::super) fn disconnect(&mut self, channel: Channel) -> Course {
        self.put(channel, &abort()).map(|_| ())
    }

    /// Does something with a connection of another master, which ends behind it.
    pub(in super::super) fn connected(
        &mut self,
        course: impl FnOnce(&mut Self, Granted) -> Course,
    ) -> Course {
        self.has_ms2()?;
        let granted = self.connect(self.other(), LONG)?;
        let course = course(self, granted);
        self.disconnect(granted.channel)?;
        course
    }

    /// How long a response may take by the device file.
    fn promised(&self, channel: Channel) -> Option<Duration> {
        let keywords = self.keywords().ok()?;
        let units = if channel.ssap == MS1_SAP { keywords.c1_response } else { keywords.c2_response };
        units.map(|units| UNIT * u32::from(units))
    }

    /// What every response must be.
    fn notice_response(&mut self, channel: Channel, begun: Instant, octets: &[u8]) {
        if let Some(promised) = self.promised(channel) {
            let (row, keyword) = match channel.ssap {
                MS1_SAP => ("V1-K01", "C1_Response_Timeout"),
                _ => ("V1-K02", "C2_Response_Timeout"),
            };
            let took = self.wire.now().saturating_since(begun);
            self.notes.occasion(row);
            if took > promised {
                let telegrams = self.last_shown();
                let why = format!(
                    "a response comes {} ms after its request, {keyword} is {} ms",
                    took.as_millis(),
                    promised.as_millis()
                );
                self.notes.breach(row, || (why, telegrams));
            }
        }
        if is_negative(octets) {
            self.notes.occasion("V1-R31");
            if let Some(why) = wrong_refusal(octets) {
                let telegrams = self.last_shown();
                self.notes.breach("V1-R31", || (why, telegrams));
            }
        }
    }
}

/// Why a service is refused; a response that is neither positive nor negative breaks the row.
fn refused(name: &str, (slot, index): (u8, u8), function: Function, octets: &[u8]) -> Course<Failure> {
    if is_negative(octets) && service(octets) == Some(function) {
        let [decode, code, detail] = [1, 2, 3].map(|at| octets.get(at).copied().unwrap_or_default());
        return Ok(Failure::from_octets([decode, code, detail]));
    }
    let octets = crate::explain::hex(octets);
    broken(format!("{name} of slot {slot} index {index} is answered with {octets}"))
}

/// What is wrong with the form of a negative response.
fn wrong_refusal(octets: &[u8]) -> Option<String> {
    let &[_, decode, code, _] = octets else {
        return Some(format!("a negative response has {} octets, expected 4", octets.len()));
    };
    let code = ErrorCode(code);
    if ErrorDecode(decode) != ErrorDecode::DP_V1 {
        return Some(format!("Error_Decode of a negative response is {decode:02X}, expected 80"));
    }
    (code.words().is_none() && !code.is_of_user())
        .then(|| format!("Error_Code_1 of a negative response is {:02X}, which is reserved", code.0))
}
