//! The PDUs of DP-V1 in words: which slot and record, which alarm, which connection, why not.

use super::field::{Field, Mark, hex};
use super::parameters;
use super::service::raw_data;
use crate::profibus::dpv1::connection::{Abort, Initiate, InitiateResponse, Terms};
use crate::profibus::dpv1::{
    ALARM_SAP, AlarmHead, CALL_INDEX, Failure, Function, Identification, MS1_SAP, PARAMETER_INDEX,
    RESOURCE_MANAGER_SAP, RequestPdu, ResponsePdu,
};
use crate::profibus::fdl::Sap;

/// Octets of a PDU before the data of a record.
const PDU_HEAD: usize = 4;

/// The number of I&M0.
const FIRST_BLOCK: u16 = 65000;

/// What a SAP of a slave is for, if DP-V1 has it.
pub(super) fn sap_use(sap: Sap) -> Option<&'static str> {
    Some(match sap.number() {
        53 => "Set_Ext_Prm (DP-V1)",
        ALARM_SAP | MS1_SAP => "MS1 (DP-V1)",
        RESOURCE_MANAGER_SAP => "connections are asked for (DP-V1)",
        ..RESOURCE_MANAGER_SAP => "a connection (DP-V1)",
        _ => return None,
    })
}

/// Whether PDUs of DP-V1 go to this SAP of a slave.
pub(super) fn carries(sap: Option<Sap>) -> bool {
    sap.is_some_and(|sap| sap.number() <= MS1_SAP)
}

pub(super) fn request(data: &[u8], at: usize) -> (String, Vec<Field>) {
    if data.is_empty() {
        return ("poll: is the response there?".into(), Vec::new());
    }
    let pdu = match RequestPdu::parse(data) {
        Ok(pdu) => pdu,
        Err(error) => return none(error, data, at),
    };
    let fields = Fields::of(data, at);
    match pdu {
        RequestPdu::Read { slot, index, len } => {
            let wanted = format!("at most {len} octets are wanted");
            (format!("Read {}", record(slot, index)), fields.place().octet("Length", wanted).done())
        }
        RequestPdu::Write { slot, index: PARAMETER_INDEX, data } => {
            match parameters::request(data, at + PDU_HEAD) {
                Some((words, parts)) => {
                    let head = format!("Write {}, {words}", record(slot, PARAMETER_INDEX));
                    (head, fields.place().within("a request of parameters", parts))
                }
                None => (
                    format!("Write {}: {}", record(slot, PARAMETER_INDEX), hex(data)),
                    fields.place().sized(""),
                ),
            }
        }
        RequestPdu::Write { slot, index: CALL_INDEX, data } => {
            (format!("Write {}: {}", record(slot, CALL_INDEX), call(data)), fields.place().sized("a call"))
        }
        RequestPdu::Write { slot, index, data } => {
            (format!("Write {}: {}", record(slot, index), hex(data)), fields.place().sized("its new octets"))
        }
        RequestPdu::DataTransport { slot, index, data } => {
            let to = record(slot, index);
            (format!("Data_Transport to {to}: {}", hex(data)), fields.place().sized("for the application"))
        }
        RequestPdu::AlarmAck(head) => (format!("acknowledges the {head}"), fields.alarm(head)),
        RequestPdu::Initiate(initiate) => initiate_words(&initiate, fields),
        RequestPdu::Idle => ("Idle: the connection is wanted still".into(), fields.done()),
        RequestPdu::Abort(abort) => {
            (format!("ends the connection: {}", abort.reason.words()), fields.abort(abort))
        }
    }
}

/// The slot and index that a request is for; `None`: it is for none.
pub(super) fn place(data: &[u8]) -> Option<(u8, u8)> {
    match RequestPdu::parse(data) {
        Ok(
            RequestPdu::Read { slot, index, .. }
            | RequestPdu::Write { slot, index, .. }
            | RequestPdu::DataTransport { slot, index, .. },
        ) => Some((slot, index)),
        Ok(RequestPdu::AlarmAck(_) | RequestPdu::Initiate(_) | RequestPdu::Idle | RequestPdu::Abort(_))
        | Err(_) => None,
    }
}

/// `asked`: slot and index of the request, if they are known.
pub(super) fn response(data: &[u8], at: usize, asked: Option<(u8, u8)>) -> (String, Vec<Field>) {
    let pdu = match ResponsePdu::parse(data) {
        Ok(pdu) => pdu,
        Err(error) => return none(error, data, at),
    };
    let fields = Fields::of(data, at);
    match pdu {
        ResponsePdu::Read { slot, index: PARAMETER_INDEX, data } => {
            match parameters::response(data, at + PDU_HEAD) {
                Some((words, parts)) => {
                    let head = format!("{}, {words}", record(slot, PARAMETER_INDEX));
                    (head, fields.place().within("a response of parameters", parts))
                }
                None => {
                    (format!("{}: {}", record(slot, PARAMETER_INDEX), hex(data)), fields.place().sized(""))
                }
            }
        }
        ResponsePdu::Read { slot, index: CALL_INDEX, data } => {
            (format!("{}: {}", record(slot, CALL_INDEX), call(data)), fields.place().sized("a block"))
        }
        ResponsePdu::Read { slot, index, data } => {
            (format!("{}: {}", record(slot, index), hex(data)), fields.place().sized("what is in it"))
        }
        ResponsePdu::Write { slot, index, len } => {
            let written = format!("{len} octets were written");
            (format!("wrote {}", record(slot, index)), fields.place().octet("Length", written).done())
        }
        ResponsePdu::DataTransport { slot, index, data } => {
            let from = record(slot, index);
            (format!("Data_Transport from {from}: {}", hex(data)), fields.place().sized("of the application"))
        }
        ResponsePdu::AlarmAck(head) => {
            (format!("took the acknowledgement of the {head}"), fields.alarm(head))
        }
        ResponsePdu::ResourceManager { sap, send_timeout } => {
            let time = format!("at least {} ms", u32::from(send_timeout) * 10);
            let fields = fields.octet("Server_SAP", format!("SAP {sap}")).word("Send_Timeout", time);
            (format!("the connection is at SAP {sap}"), fields.done())
        }
        ResponsePdu::Initiate(accepted) => accepted_words(&accepted, fields),
        ResponsePdu::Idle => ("Idle: the slave is there still".into(), fields.done()),
        ResponsePdu::Abort(abort) => {
            (format!("ends the connection: {}", abort.reason.words()), fields.abort(abort))
        }
        ResponsePdu::Negative { function, failure } => {
            let name = Function::numbered(function).map_or("service", Function::name);
            let of = asked.map_or_else(String::new, |(slot, index)| format!(" of {}", record(slot, index)));
            (format!("{name}{of} refused: {failure}"), fields.failure(failure))
        }
    }
}

/// `I&M0 is asked for`, `I&M0: order 6ES7 000-0AA00, ..`
fn call(data: &[u8]) -> String {
    let Some((&[0x08, _, high, low], block)) = data.split_first_chunk::<4>() else { return hex(data) };
    let Some(number) = u16::from_be_bytes([high, low]).checked_sub(FIRST_BLOCK) else { return hex(data) };
    let own = block.try_into().ok().and_then(Identification::parse).filter(|_| number == 0);
    match own {
        Some(own) => format!("I&M0: {own}"),
        None if block.is_empty() => format!("I&M{number} is asked for"),
        None => format!("I&M{number}: {}", String::from_utf8_lossy(block).trim()),
    }
}

/// Octets that are no PDU.
fn none(error: impl ToString, data: &[u8], at: usize) -> (String, Vec<Field>) {
    let error = error.to_string();
    let fields = raw_data(data, at).into_iter().map(|field| field.mistaken(&error)).collect();
    (format!("no PDU of DP-V1: {error}"), fields)
}

fn record(slot: u8, index: u8) -> String {
    match index {
        CALL_INDEX => format!("record {index} (identification) of slot {slot}"),
        PARAMETER_INDEX => format!("record {index} (parameters of a drive) of slot {slot}"),
        _ => format!("record {index} of slot {slot}"),
    }
}

fn initiate_words(initiate: &Initiate<'_>, fields: Fields<'_>) -> (String, Vec<Field>) {
    let time = format!("{} ms", u32::from(initiate.send_timeout) * 10);
    let fields = fields.rest_of("reserved", 3).word("Send_Timeout", &time);
    let fields = fields.terms(&initiate.terms);
    (format!("asks for a connection, Send_Timeout {time}"), fields)
}

fn accepted_words(accepted: &InitiateResponse<'_>, fields: Fields<'_>) -> (String, Vec<Field>) {
    let most = format!("records of up to {} octets", accepted.max_len);
    let fields = fields.octet("Max_Len_Data_Unit", &most).terms(&accepted.terms);
    (format!("the connection is open: {most}"), fields)
}

/// The fields of a PDU, from its front to its end.
struct Fields<'a> {
    rest: &'a [u8],
    at: usize,
    fields: Vec<Field>,
}

impl<'a> Fields<'a> {
    fn of(data: &'a [u8], at: usize) -> Self {
        let name = data.first().map(|number| (number, Function::numbered(number & !Function::NEGATIVE)));
        let words = match name {
            Some((number, Some(function))) if number & Function::NEGATIVE != 0 => {
                format!("{} refused", function.name())
            }
            Some((_, Some(function))) => function.name().into(),
            Some((_, None)) | None => String::new(),
        };
        Self { rest: data, at, fields: Vec::new() }.octet("Function_Num", words)
    }

    fn take(&mut self, len: usize) -> &'a [u8] {
        let (taken, rest) = self.rest.split_at_checked(len).unwrap_or((self.rest, &[]));
        self.rest = rest;
        self.at += taken.len();
        taken
    }

    fn octet(self, name: &str, meaning: impl Into<String>) -> Self {
        self.some(name, 1, meaning.into())
    }

    fn word(self, name: &str, meaning: impl Into<String>) -> Self {
        self.some(name, 2, meaning.into())
    }

    fn rest_of(self, name: &str, len: usize) -> Self {
        self.some(name, len, String::new())
    }

    fn some(mut self, name: &str, len: usize, meaning: String) -> Self {
        let at = self.at;
        let taken = self.take(len);
        if !taken.is_empty() {
            self.fields.push(Field::octets(name, at, taken, meaning));
        }
        self
    }

    fn place(self) -> Self {
        let slot = self.rest.first().map_or(String::new(), |slot| match slot {
            0 => "the station".into(),
            slot => format!("module {slot}"),
        });
        self.octet("Slot_Number", slot).octet("Index", "")
    }

    /// The length octet and what it announces.
    fn sized(self, what: &str) -> Vec<Field> {
        let len = self.rest.len().saturating_sub(1);
        self.octet("Length", format!("{len} octets follow")).some("data", len, what.into()).done()
    }

    /// The length octet, and the data as fields of their own.
    fn within(self, what: &str, parts: Vec<Field>) -> Vec<Field> {
        let mut fields = self.sized(what);
        if let Some(data) = fields.last_mut() {
            data.mark = parts.iter().map(|part| part.mark).fold(data.mark, Ord::max);
            data.fields = parts;
        }
        fields
    }

    fn alarm(self, head: AlarmHead) -> Vec<Field> {
        let specifier = format!(
            "number {}, {}",
            head.sequence,
            match head.specifier.words() {
                "" => "neither appears nor disappears",
                words => words,
            }
        );
        self.octet("Slot_Number", "")
            .octet("Alarm_Type", head.kind.to_string())
            .octet("Alarm_Specifier", specifier)
            .done()
    }

    fn abort(self, abort: Abort) -> Vec<Field> {
        self.octet("Subnet", "").octet("Instance and reason", abort.reason.words()).done()
    }

    fn failure(self, failure: Failure) -> Vec<Field> {
        let mut fields = self.octet("Error_Decode", failure.decode.name());
        fields = fields.octet("Error_Code_1", failure.code.to_string());
        if let Some(code) = fields.fields.pop() {
            let code = code.marked(Mark::Trouble);
            fields.fields.push(match failure.code.cure() {
                "" => code,
                cure => code.hinted(cure),
            });
        }
        fields.octet("Error_Code_2", "").done()
    }

    fn terms(self, terms: &Terms<'_>) -> Vec<Field> {
        self.word("Features_Supported", "")
            .word("Profile_Features", "")
            .word("Profile_Ident_Number", "")
            .octet("S_Type", "")
            .octet("S_Len", "")
            .octet("D_Type", "")
            .octet("D_Len", "")
            .some("S_Addr", terms.source.octets.len(), "API and SCL of who sends it".into())
            .some("D_Addr", terms.destination.octets.len(), "API and SCL of who gets it".into())
            .done()
    }

    fn done(mut self) -> Vec<Field> {
        let len = self.rest.len();
        self = self.some("detail", len, String::new());
        self.fields
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Context, Mark};
    use crate::profibus::fdl::MAX_TELEGRAM_LEN;

    fn said(hex: &str) -> super::super::Explanation {
        let octets: Vec<u8> = hex.split(' ').map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect();
        assert!(octets.len() <= MAX_TELEGRAM_LEN);
        Context::default().telegram(&octets)
    }

    #[test]
    fn the_telegrams_of_the_reference_say_what_they_are() {
        for (hex, line) in [
            ("68 09 09 68 87 82 7D 33 33 5E 01 0A 08 5D 16", "2 -> 7  Read record 10 of slot 1"),
            ("68 05 05 68 87 82 5D 33 33 CC 16", "2 -> 7  poll: is the response there?"),
            (
                "68 0D 0D 68 82 87 08 33 33 5E 01 0A 04 11 22 33 44 8E 16",
                "7 -> 2  record 10 of slot 1: 11 22 33 44",
            ),
            (
                "68 09 09 68 82 87 08 33 33 DE 80 B0 00 85 16",
                "7 -> 2  Read refused: access, invalid index (80 B0 00)",
            ),
            (
                "68 0D 0D 68 87 82 7D 33 33 5F 01 0A 04 AA BB CC DD 68 16",
                "2 -> 7  Write record 10 of slot 1: AA BB CC DD",
            ),
            ("68 09 09 68 82 87 08 33 33 5F 01 0A 04 E5 16", "7 -> 2  wrote record 10 of slot 1"),
            (
                "68 09 09 68 87 82 7D 33 33 5C 01 02 01 4C 16",
                "2 -> 7  acknowledges the process alarm of slot 1 appears, number 0",
            ),
            (
                "68 19 19 68 87 83 6D 31 32 57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00 9A 16",
                "3 -> 7  asks for a connection, Send_Timeout 1000 ms",
            ),
            ("68 09 09 68 83 87 08 32 31 56 30 00 0A 05 16", "7 -> 3  the connection is at SAP 48"),
            (
                "68 15 15 68 83 87 08 32 30 57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00 00 C0 16",
                "7 -> 3  the connection is open: records of up to 240 octets",
            ),
            ("68 06 06 68 83 87 08 32 30 48 BC 16", "7 -> 3  Idle: the slave is there still"),
            ("68 08 08 68 83 87 08 32 30 58 01 13 E0 16", "7 -> 3  ends the connection: a time-out"),
            (
                "68 13 13 68 87 82 7D 33 33 5F 00 2F 0A 01 01 00 01 10 06 03 C4 00 00 64 16",
                "2 -> 7  Write record 47 (parameters of a drive) of slot 0, request 1: reads PNU 964 [0..5]",
            ),
            (
                "68 1B 1B 68 82 87 08 33 33 5E 00 2F 12 01 01 00 01 06 06 00 2A 00 01 00 64 07 EA 0B 16 00 01 C7 16",
                "7 -> 2  record 47 (parameters of a drive) of slot 0, response 1: 42, 1, 100, 2026, 2838, 1",
            ),
            (
                "68 0D 0D 68 87 82 7D 33 33 5F 00 FF 04 08 00 FD E8 3B 16",
                "2 -> 7  Write record 255 (identification) of slot 0: I&M0 is asked for",
            ),
            (
                "68 09 09 68 87 82 5D 33 33 5E 00 2F F0 49 16",
                "2 -> 7  Read record 47 (parameters of a drive) of slot 0",
            ),
        ] {
            let explanation = said(hex);
            assert_eq!(explanation.line(), line);
            // Every octet has a name.
            let covered: usize = explanation.fields.iter().map(|field| field.len).sum();
            assert_eq!(covered, explanation.octets.len(), "{line}");
        }
    }

    #[test]
    fn a_refusal_is_trouble_with_a_cure_and_a_broken_pdu_is_a_mistake() {
        let refused = said("68 09 09 68 82 87 08 33 33 DE 80 B0 00 85 16");
        let code = refused.fields.iter().find(|field| field.name == "Error_Code_1").unwrap();
        assert_eq!((code.mark, &*code.hints[0]), (Mark::Trouble, "the slot has no record of this index"));
        let broken = said("68 07 07 68 87 82 7D 33 33 5E 01 4B 16");
        assert_eq!(broken.line(), "2 -> 7  no PDU of DP-V1: Read has 2 octets, expected 4 or more");
    }
}
