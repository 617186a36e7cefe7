//! FDL: one telegram around whatever it carries, and what is wrong with a broken one.

use super::context::{Asked, Context};
use super::field::{Bits, Field, Mark, hex};
use super::service::{self, Carried};
use super::{Explanation, Kind, Sender, acyclic};
use crate::profibus::dp;
use crate::profibus::fdl::foreign::Foreign;
use crate::profibus::fdl::telegram::{Decoded, Format, FrameError, decode};
use crate::profibus::fdl::{
    Address, DataTelegram, FrameCount, Function, MAX_TELEGRAM_LEN, ReplyStatus, Service, StationType,
    Telegram,
};

pub(super) fn explain(octets: &[u8], context: &mut Context) -> Explanation {
    match decode(octets) {
        Decoded::Telegram { telegram, len } => {
            let mut explanation = telegram_of(telegram, octets.get(..len).unwrap_or_default(), context);
            if let Some(rest) = octets.get(len..).filter(|rest| !rest.is_empty()) {
                let text = format!("behind the end of the telegram, which has {len} octets");
                let rest = Field::octets("more", len, rest, text).marked(Mark::Invalid);
                explanation.summary =
                    format!("invalid at octet {len}: {}; {}", rest.meaning, explanation.summary);
                explanation.fields.push(rest);
            }
            explanation.octets = octets.into();
            explanation
        }
        Decoded::Invalid { error, .. } => invalid(octets, error, context),
        Decoded::Incomplete => {
            let error = FrameError::BrokenOff { octets: u8::try_from(octets.len()).unwrap_or(u8::MAX) };
            invalid(octets, error, context)
        }
    }
}

/// A correct telegram that is all of `octets`.
fn telegram_of(telegram: Telegram<'_>, octets: &[u8], context: &mut Context) -> Explanation {
    match telegram {
        Telegram::Data(data) => data_telegram(&data, octets, context),
        Telegram::Token { da, sa } => {
            let fields = Vec::from([
                Field::octet("SD4", 0, SD4, "token"),
                Field::octet("DA", 1, da.number(), format!("station {da} gets the token")),
                Field::octet("SA", 2, sa.number(), format!("station {sa} passes it on")),
            ]);
            Explanation {
                kind: Kind::Token,
                id: None,
                sender: Some(Sender::Master),
                from: Some(sa.number()),
                to: Some(da.number()),
                service: None,
                summary: "token".into(),
                octets: octets.into(),
                fields,
            }
        }
        Telegram::ShortAcknowledge => short_acknowledge(context),
    }
}

/// SC has no address: it answers the last request.
fn short_acknowledge(context: &mut Context) -> Explanation {
    let asked = context.asked.take();
    let service = asked.and_then(|asked| asked.service);
    let (meaning, summary) = match service {
        Some(service) => {
            let name = service.name();
            (format!("short acknowledge: {name} was received"), format!("short acknowledge: {name} received"))
        }
        None => (
            "short acknowledge: the request was received".into(),
            "short acknowledge: request received".into(),
        ),
    };
    let mut field = Field::octet("SC", 0, SC, meaning);
    if matches!(service, Some(dp::Service::SetPrm | dp::Service::ChkCfg)) {
        field = field.hinted(
            "this is no answer to the contents: the next Slave_Diag shows whether the slave accepts them",
        );
    }
    Explanation {
        kind: Kind::Telegram,
        id: None,
        sender: Some(Sender::Slave),
        from: asked.map(|asked| asked.station),
        to: asked.map(|asked| asked.master),
        service: service.map(crate::profibus::dp::Service::name),
        summary,
        octets: Vec::from([SC]),
        fields: Vec::from([field]),
    }
}

fn data_telegram(telegram: &DataTelegram<'_>, octets: &[u8], context: &mut Context) -> Explanation {
    let (da, sa) = (telegram.da.number(), telegram.sa.number());
    let (from, to) = (Some(sa), Some(da));
    let mut fields = head(telegram.format, octets);
    let at = fields.len();
    let function = telegram.fc.function();
    fields.push(judge_da(address_field("DA", at, telegram.da, telegram.dsap.is_some()), telegram, function));
    let sender = address_field("SA", at + 1, telegram.sa, telegram.ssap.is_some());
    fields.push(match telegram.sa.is_broadcast() {
        true => sender.mistaken("127 means all stations; no station has this address"),
        false => sender,
    });
    let repeats = repetition(telegram, function, context);
    fields.push(fc_field(at + 2, telegram.fc.octet(), function, repeats));
    let mut data_at = at + 3;
    let masters_is_ssap = !matches!(function, Function::Response(..));
    for (name, sap, masters) in
        [("DSAP", telegram.dsap, !masters_is_ssap), ("SSAP", telegram.ssap, masters_is_ssap)]
    {
        if let Some(sap) = sap {
            let of = if masters { format!("SAP {sap} of the master") } else { service::sap_name(sap) };
            fields.push(Field::octet(name, data_at, sap.number(), of));
            data_at += 1;
        }
    }
    let (sender, carried) = match function {
        Function::Request(fdl, _) => (Some(Sender::Master), request(fdl, telegram, data_at, context)),
        Function::Response(_, status) => (Some(Sender::Slave), response(status, telegram, data_at, context)),
        Function::Reserved => {
            let summary = "a reserved function code".to_string();
            (None, Carried { service: None, summary, fields: service::raw_data(telegram.data, data_at) })
        }
    };
    fields.extend(carried.fields);
    let end = data_at + telegram.data.len();
    let fcs = octets.get(end).copied().unwrap_or_default();
    fields.push(Field::octet("FCS", end, fcs, "frame check sequence, sum of the octets from DA to here"));
    fields.push(Field::octet("ED", end + 1, ED, "end delimiter"));
    let summary = if repeats { format!("{} (repeated)", carried.summary) } else { carried.summary };
    Explanation {
        kind: Kind::Telegram,
        id: None,
        sender,
        from,
        to,
        service: carried.service.map(crate::profibus::dp::Service::name),
        summary,
        octets: octets.into(),
        fields,
    }
}

/// Everything before DA.
fn head(format: Format, octets: &[u8]) -> Vec<Field> {
    let octet = |at: usize| octets.get(at).copied().unwrap_or_default();
    match format {
        Format::Sd1 => Vec::from([Field::octet("SD1", 0, octet(0), "start, no data")]),
        Format::Sd2 => Vec::from([
            Field::octet("SD2", 0, octet(0), "start, length follows"),
            Field::octet("LE", 1, octet(1), format!("{} octets from DA to the last data octet", octet(1))),
            Field::octet("LEr", 2, octet(2), "the same again"),
            Field::octet("SD2", 3, octet(3), "start again"),
        ]),
        Format::Sd3 => Vec::from([Field::octet("SD3", 0, octet(0), "start, 8 data octets")]),
    }
}

fn address_field(name: &str, at: usize, address: Address, extended: bool) -> Field {
    let octet = address.number() | if extended { 0x80 } else { 0 };
    let who = match (address.number(), name) {
        (127, "DA") => "all stations".to_string(),
        (number, _) => format!("station {number}"),
    };
    let sap = if extended { ", a SAP follows (bit 7)" } else { "" };
    Field::octet(name, at, octet, format!("{who}{sap}"))
}

/// Whether somebody can take the telegram.
fn judge_da(field: Field, telegram: &DataTelegram<'_>, function: Function) -> Field {
    let wants_reply = match function {
        Function::Request(service, _) => service.wants_reply(),
        Function::Response(..) | Function::Reserved => false,
    };
    if wants_reply && telegram.da.is_broadcast() {
        field
            .mistaken("this request needs a reply, and no station replies to a request to all stations (127)")
    } else if telegram.da == telegram.sa {
        field.mistaken(format!("station {} sends it to itself: no other station accepts it", telegram.sa))
    } else {
        field
    }
}

fn fc_field(at: usize, octet: u8, function: Function, repeats: bool) -> Field {
    let bits = |name: &str, high, low, meaning: String| {
        Field::bits(name, (at, 1), Bits { high, low }, octet.into(), meaning)
    };
    let reserved = bits("b7", 7, 7, if octet & 0x80 == 0 { "0" } else { "1, reserved" }.into());
    match function {
        Function::Request(service, count) => {
            let fcb = bits("FCB", 5, 5, fcb(count, repeats).into());
            let counts = if matches!(count, FrameCount::Even | FrameCount::Odd) {
                "FCB counts"
            } else {
                "FCB does not count"
            };
            Field::octet("FC", at, octet, "request").with(Vec::from([
                reserved,
                bits("direction", 6, 6, "request".into()),
                fcb,
                bits("FCV", 4, 4, counts.into()),
                bits("function", 3, 0, service.name().into()),
            ]))
        }
        Function::Response(station, status) => Field::octet("FC", at, octet, "response").with(Vec::from([
            reserved,
            bits("direction", 6, 6, "response".into()),
            bits("station type", 5, 4, station_name(station).into()),
            bits("status", 3, 0, status_name(status).into()).marked_if(Mark::Trouble, refuses(status)),
        ])),
        Function::Reserved => Field::octet("FC", at, octet, "reserved function code")
            .mistaken("the standard reserves this code"),
    }
}

const fn fcb(count: FrameCount, repeats: bool) -> &'static str {
    match (count, repeats) {
        (FrameCount::First, _) => "first cycle to this station",
        (FrameCount::Unused, _) => "not used",
        (FrameCount::Even | FrameCount::Odd, true) => "as in the request before: a repetition",
        (FrameCount::Even | FrameCount::Odd, false) => "frame count bit, alternates",
    }
}

/// Whether the frame count bit says that the request before is repeated (`dp-v0.md` 2.3).
fn repetition(telegram: &DataTelegram<'_>, function: Function, context: &mut Context) -> bool {
    let count = match function {
        Function::Request(_, count @ (FrameCount::First | FrameCount::Even | FrameCount::Odd)) => count,
        Function::Request(_, FrameCount::Unused) | Function::Response(..) | Function::Reserved => {
            return false;
        }
    };
    let mut station = context.station(telegram.da.number());
    let bit = |count: FrameCount| matches!(count, FrameCount::First | FrameCount::Odd);
    let same =
        station.count.is_some_and(|(sa, before)| sa == telegram.sa.number() && bit(before) == bit(count));
    station.count = Some((telegram.sa.number(), count));
    context.learn(telegram.da.number(), station);
    same && count != FrameCount::First
}

fn request(fdl: Service, telegram: &DataTelegram<'_>, at: usize, context: &mut Context) -> Carried {
    let station = telegram.da.number();
    let service = match fdl {
        Service::SdaLow
        | Service::SdnLow
        | Service::SdaHigh
        | Service::SdnHigh
        | Service::Msrd
        | Service::SrdLow
        | Service::SrdHigh => dp::Service::of(telegram.dsap, telegram.ssap),
        Service::TimeEvent | Service::FdlStatus | Service::Ident | Service::LsapStatus => None,
    };
    let asks = fdl.wants_reply() && !telegram.da.is_broadcast();
    context.asked = asks.then_some(Asked { master: telegram.sa.number(), station, service, fdl });
    let mut learned = context.station(station);
    let carried = match fdl {
        Service::FdlStatus => plain("FDL status request", telegram.data, at),
        Service::Ident => plain("Ident request", telegram.data, at),
        Service::LsapStatus => plain("LSAP status request", telegram.data, at),
        Service::TimeEvent => plain("time event", telegram.data, at),
        Service::SdaLow
        | Service::SdnLow
        | Service::SdaHigh
        | Service::SdnHigh
        | Service::Msrd
        | Service::SrdLow
        | Service::SrdHigh => {
            if service.is_none() && acyclic::carries(telegram.dsap) {
                if !telegram.data.is_empty() {
                    learned.record = telegram.dsap.zip(acyclic::place(telegram.data));
                }
                let (summary, fields) = acyclic::request(telegram.data, at);
                Carried { service, summary, fields }
            } else {
                service::request(service, telegram.data, at, &mut learned)
            }
        }
    };
    context.learn(station, learned);
    carried
}

fn plain(summary: &str, data: &[u8], at: usize) -> Carried {
    Carried { service: None, summary: summary.into(), fields: service::raw_data(data, at) }
}

fn response(status: ReplyStatus, telegram: &DataTelegram<'_>, at: usize, context: &mut Context) -> Carried {
    let station = telegram.sa.number();
    let asked = context.asked.take();
    let asked = asked.filter(|asked| asked.station == station && asked.master == telegram.da.number());
    // A response has the SAPs of its request, the other way round.
    let by_sap = dp::Service::of(telegram.ssap, telegram.dsap);
    let empty = telegram.data.is_empty();
    let service = match (asked, by_sap) {
        (Some(asked), _) if empty && by_sap == Some(dp::Service::DataExchange) => asked.service,
        (_, by_sap) => by_sap,
    };
    if refuses(status) {
        let what = asked.and_then(|asked| asked.service).or(service).map(crate::profibus::dp::Service::name);
        let what = what.filter(|_| asked.is_some() || by_sap != Some(dp::Service::DataExchange));
        let summary = match what {
            Some(name) => format!("{name} refused: {}", status_name(status)),
            None => format!("refused: {}", status_name(status)),
        };
        return Carried { service, summary, fields: service::raw_data(telegram.data, at) };
    }
    match asked.map(|asked| asked.fdl) {
        Some(Service::FdlStatus) if empty => return plain(here(telegram), telegram.data, at),
        Some(Service::Ident) => return plain("ident", telegram.data, at),
        Some(Service::LsapStatus) => return plain("LSAP status", telegram.data, at),
        Some(
            Service::FdlStatus
            | Service::TimeEvent
            | Service::SdaLow
            | Service::SdnLow
            | Service::SdaHigh
            | Service::SdnHigh
            | Service::Msrd
            | Service::SrdLow
            | Service::SrdHigh,
        )
        | None => {}
    }
    // Without its request an empty OK is the answer to FDL status.
    if empty && status == ReplyStatus::Ok && service == by_sap && by_sap == Some(dp::Service::DataExchange) {
        return plain(here(telegram), telegram.data, at);
    }
    if service.is_none() && !empty && acyclic::carries(telegram.ssap) {
        let asked = context.station(station).record.filter(|(sap, _)| Some(*sap) == telegram.ssap);
        let (summary, fields) = acyclic::response(telegram.data, at, asked.map(|(_, place)| place));
        return Carried { service, summary, fields };
    }
    let mut learned = context.station(station);
    let mut carried = service::response(service, telegram.data, at, &mut learned);
    context.learn(station, learned);
    if status == ReplyStatus::DataHigh {
        carried.summary.push_str("; a new diagnosis waits");
    }
    carried
}

fn here(telegram: &DataTelegram<'_>) -> &'static str {
    match telegram.fc.function() {
        Function::Response(StationType::Slave, _) => "here, a slave",
        Function::Response(StationType::MasterNotReady, _) => "here, a master not ready for the token",
        Function::Response(StationType::MasterReady, _) => "here, a master ready for the token",
        Function::Response(StationType::MasterInRing, _) => "here, a master in the ring",
        Function::Request(..) | Function::Reserved => "here",
    }
}

const fn refuses(status: ReplyStatus) -> bool {
    match status {
        ReplyStatus::UserError | ReplyStatus::NoResource | ReplyStatus::NotActivated => true,
        ReplyStatus::Ok
        | ReplyStatus::DataLow
        | ReplyStatus::NotReady
        | ReplyStatus::DataHigh
        | ReplyStatus::NoResourceDataLow
        | ReplyStatus::NoResourceDataHigh => false,
    }
}

const fn status_name(status: ReplyStatus) -> &'static str {
    match status {
        ReplyStatus::Ok => "OK: positive acknowledge",
        ReplyStatus::UserError => "UE: error of the user layer",
        ReplyStatus::NoResource => "RR: no resource for the data, or their length is wrong",
        ReplyStatus::NotActivated => "RS: service or SAP not active now, or not for this master",
        ReplyStatus::DataLow => "DL: data, low priority",
        ReplyStatus::NotReady => "NR: no data ready",
        ReplyStatus::DataHigh => "DH: data, high priority: a new diagnosis waits",
        ReplyStatus::NoResourceDataLow => "RDL: data low, no resource for those of the request",
        ReplyStatus::NoResourceDataHigh => "RDH: data high, no resource for those of the request",
    }
}

const fn station_name(station: StationType) -> &'static str {
    match station {
        StationType::Slave => "slave",
        StationType::MasterNotReady => "master, not ready for the token",
        StationType::MasterReady => "master, ready for the token",
        StationType::MasterInRing => "master in the ring",
    }
}

/// What is no telegram: the reason, where it is, and what can be said nevertheless.
fn invalid(octets: &[u8], error: FrameError, context: &Context) -> Explanation {
    let at = fault_octet(octets, error);
    if let Some(mut explanation) = repaired(octets, context) {
        explanation.octets = octets.into();
        explanation.summary = format!("invalid at octet {at}: {error}; {}", explanation.summary);
        if let Some(field) = explanation.fields.iter_mut().find(|field| field.at == at) {
            field.raw = octets.get(at).map(|octet| hex(&[*octet])).unwrap_or_default();
            field.mark = Mark::Invalid;
            field.meaning = error.to_string();
        }
        return explanation;
    }
    let mut fields = Vec::new();
    let (before, behind) = octets.split_at_checked(at).unwrap_or((octets, &[]));
    if !before.is_empty() {
        fields.push(Field::octets("octets", 0, before, begun(octets)));
    }
    match behind.split_first() {
        Some((wrong, rest)) => {
            fields.push(Field::octet("wrong", at, *wrong, error.to_string()).marked(Mark::Invalid));
            if !rest.is_empty() {
                fields.push(Field::octets("octets", at + 1, rest, "not looked at"));
            }
        }
        None => fields.push(Field::octets("end", at, &[], missing(octets, error)).marked(Mark::Invalid)),
    }
    let mut reason = if behind.is_empty() { missing(octets, error) } else { error.to_string() };
    if let Some(foreign) = Foreign::of(octets) {
        reason = format!("{reason}; {foreign}");
        if let Some(first) = fields.first_mut() {
            first.hints.push(foreign.to_string());
        }
    }
    Explanation::of_nobody(Kind::Noise, format!("invalid at octet {at}: {reason}"), octets, fields)
}

/// What broken octets began as.
fn begun(octets: &[u8]) -> &'static str {
    match octets.first() {
        Some(&SD1) => "begins like a telegram without data (SD1)",
        Some(&SD2) => "begins like a telegram with data (SD2)",
        Some(&SD3) => "begins like a telegram with 8 data octets (SD3)",
        Some(&SD4) => "begins like a token (SD4)",
        Some(_) | None => "no telegram",
    }
}

/// The error, for a telegram that broke off with how many octets are missing.
fn missing(octets: &[u8], error: FrameError) -> String {
    match (error, whole_len(octets)) {
        (FrameError::BrokenOff { .. }, Some(whole)) => {
            format!("{error}, {} more are missing", whole.saturating_sub(octets.len()))
        }
        (_, _) => error.to_string(),
    }
}

/// How long the telegram is that begins here, if that can be told.
fn whole_len(octets: &[u8]) -> Option<usize> {
    match *octets {
        [SD1, ..] => Some(6),
        [SD2, le, ..] => Some(usize::from(le) + 6),
        [SD3, ..] => Some(14),
        [SD4, ..] => Some(3),
        [..] => None,
    }
}

/// Which octet the error is about.
fn fault_octet(octets: &[u8], error: FrameError) -> usize {
    let whole = whole_len(octets).unwrap_or(1);
    match error {
        FrameError::StartDelimiter { .. } | FrameError::Parity => 0,
        FrameError::Length { .. } => 1,
        FrameError::RepeatedLength { .. } => 2,
        FrameError::SecondStartDelimiter { .. } => 3,
        FrameError::EndDelimiter { .. } => whole - 1,
        FrameError::Checksum { .. } => whole - 2,
        FrameError::TokenAddress { got } => match octets.get(1) {
            Some(da) if *da == got => 1,
            Some(_) | None => 2,
        },
        FrameError::ExtensionMissing => whole - 2,
        FrameError::Extension { .. } => {
            let head = if octets.first() == Some(&SD2) { 4 } else { 1 };
            let da_extended = octets.get(head).is_some_and(|da| da & 0x80 != 0);
            let plain = |octet: &u8| octet & 0xC0 == 0;
            let first_is_plain = octets.get(head + 3).is_some_and(plain);
            head + 3 + usize::from(da_extended && first_is_plain)
        }
        FrameError::BrokenOff { .. } => octets.len(),
    }
}

/// The explanation of a telegram in which nothing but its end is wrong: checksum, end delimiter or both. It teaches
/// nothing, for nobody knows which octets are wrong.
fn repaired(octets: &[u8], context: &Context) -> Option<Explanation> {
    let whole = whole_len(octets).filter(|whole| *whole == octets.len() && *whole <= MAX_TELEGRAM_LEN)?;
    let mut copy = Vec::from(octets);
    if let Some(ed) = copy.get_mut(whole - 1) {
        *ed = ED;
    }
    if let Decoded::Invalid { error: FrameError::Checksum { expected, .. }, .. } = decode(&copy)
        && let Some(fcs) = copy.get_mut(whole.checked_sub(2)?)
    {
        *fcs = expected;
    }
    let Decoded::Telegram { telegram: telegram @ Telegram::Data(_), .. } = decode(&copy) else { return None };
    let mut explanation = telegram_of(telegram, &copy, &mut context.clone());
    for field in &mut explanation.fields {
        let octet = octets.get(field.at).copied();
        if field.name == "FCS" && octet != copy.get(field.at).copied() {
            *field = Field::octet("FCS", field.at, octet?, format!("should be {}", field.raw))
                .marked(Mark::Invalid);
        }
    }
    Some(explanation)
}

const SD1: u8 = 0x10;
const SD2: u8 = 0x68;
const SD3: u8 = 0xA2;
const SD4: u8 = 0xDC;
const SC: u8 = 0xE5;
const ED: u8 = 0x16;

#[cfg(test)]
pub(crate) mod tests;
