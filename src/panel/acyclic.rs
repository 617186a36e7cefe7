//! Records, alarms, identification and connections of a station, read and changed without the bus.

use axum::Json;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};

#[cfg(test)]
use super::description::Problems;
use super::line::lacks;
use super::problem::{Body, PathOf, Problem};
use super::routes::Place;
use crate::explain;
use crate::face::Acyclic;
use crate::face::acyclic::{NewAlarm, NewStatus, Record};
use crate::face::description::Denied;
use crate::host::octets_of_hex;
use crate::profibus::dpv1::{AlarmHead, AlarmState, AlarmType, Identification, Link, Specifier, StatusType};

/// What a station without records says it lacks.
const WHAT: &str = "services of DP-V1 (records, alarms)";

/// A record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct RecordState {
    /// 0: the station; from 1: its modules.
    slot: u8,
    index: u8,
    /// How many octets it has.
    length: usize,
    access: RecordAccess,
    /// Its octets, hexadecimal, apart.
    data: String,
    /// The same as text, a point for what is no letter.
    text: String,
}

/// What a master may do to a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(rename_all = "lowercase")]
enum RecordAccess {
    /// Read.
    R,
    /// Write.
    W,
    /// Both.
    Rw,
    /// Nothing.
    None,
}

/// Every record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Records {
    records: Vec<RecordState>,
}

/// What a record shall hold.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct NewRecordData {
    /// As many octets as it has, hexadecimal, with or without blanks.
    data: String,
}

/// An alarm that is not acknowledged.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct AlarmEntry {
    /// Its number: 1 diagnostic, 2 process, 3 pull, 4 plug, 5 status, 6 update, 32 to 126 of the manufacturer.
    #[serde(rename = "type")]
    kind: u8,
    slot: u8,
    /// Seq_Nr.
    #[cfg_attr(test, schema(maximum = 31))]
    sequence: u8,
    specifier: SpecifierName,
    additional_ack: bool,
    /// What the manufacturer says about it, hexadecimal.
    data: String,
    state: AlarmProgress,
    /// One line.
    text: String,
}

/// How far an alarm is. Acknowledged ones are gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(rename_all = "lowercase")]
enum AlarmProgress {
    /// The owner has not read it.
    Pending,
    /// The owner has read it and not acknowledged it.
    Delivered,
}

/// Whether something begins or ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(rename_all = "lowercase")]
enum SpecifierName {
    /// Neither.
    #[default]
    None,
    /// It appears: the slot is disturbed.
    Appears,
    /// It disappears: the slot is in order.
    Disappears,
    /// It disappears, and the slot is disturbed still.
    Still,
}

/// Every alarm, and which types there are.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Alarms {
    alarms: Vec<AlarmEntry>,
    /// The types that the station has: numbers, 32 for those of the manufacturer.
    types: Vec<u8>,
}

/// The type of an alarm: `diagnostic`, `process`, `pull`, `plug`, `status`, `update`, or a number.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(untagged)]
enum TypeName {
    Number(u8),
    Word(String),
}

/// An alarm to raise.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct AlarmToRaise {
    #[serde(rename = "type")]
    kind: TypeName,
    slot: u8,
    #[serde(default)]
    specifier: SpecifierName,
    #[serde(default)]
    additional_ack: bool,
    /// At most 59 octets, hexadecimal.
    #[serde(default)]
    data: String,
}

/// A status message to send.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct StatusToSend {
    /// 1 a message, 2 module status, 3 links of DXB, 30 and 31 of redundancy, 32 to 126 of the manufacturer.
    #[serde(rename = "type")]
    #[cfg_attr(test, schema(minimum = 1, maximum = 126))]
    kind: u8,
    slot: u8,
    #[serde(default)]
    specifier: SpecifierName,
    /// At most 59 octets, hexadecimal.
    #[serde(default)]
    data: String,
}

/// The channel of the owner and the connections of masters of class 2.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Channels {
    ms1: OwnersChannelState,
    ms2: Vec<LinkState>,
    /// The most connections at once.
    max: u8,
    /// Identification and maintenance.
    identification: Vec<IdentificationState>,
}

/// The channel of the owner.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct OwnersChannelState {
    open: bool,
    /// The master that owns the slave.
    owner: Option<u8>,
    /// A request is being carried out.
    busy: bool,
}

/// A connection.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct LinkState {
    sap: u8,
    master: u8,
    send_timeout_ms: u64,
    busy: bool,
}

/// A block of identification and maintenance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct IdentificationState {
    /// 0 for I&M0.
    block: u16,
    /// A master can write it.
    writable: bool,
    /// The 64 octets, hexadecimal.
    data: String,
    /// What it says.
    text: String,
}

/// Which record.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct OfRecord {
    slot_number: u8,
    record: u8,
}

impl RecordState {
    fn of(record: &Record<'_>) -> Self {
        let Record { slot, index, data, read, write } = *record;
        let access = match (read, write) {
            (true, true) => RecordAccess::Rw,
            (true, false) => RecordAccess::R,
            (false, true) => RecordAccess::W,
            (false, false) => RecordAccess::None,
        };
        let (length, text) = (data.len(), printable(data));
        Self { slot, index, length, access, data: explain::hex(data), text }
    }

    fn find(acyclic: &dyn Acyclic, of: OfRecord) -> Result<Self, Problem> {
        let mut found = None;
        let mut of_slot = Vec::new();
        acyclic.each_record(&mut |record| {
            if record.slot == of.slot_number {
                of_slot.push(record.index.to_string());
            }
            if (record.slot, record.index) == (of.slot_number, of.record) {
                found = Some(Self::of(&record));
            }
        });
        let OfRecord { slot_number: slot, record } = of;
        found.ok_or_else(|| {
            Problem::not_found(match &of_slot[..] {
                [] => format!("slot {slot} has no records"),
                indices => {
                    format!("slot {slot} has no record {record}; it has {}", indices.join(", "))
                }
            })
        })
    }
}

impl SpecifierName {
    const fn of(specifier: Specifier) -> Self {
        match specifier {
            Specifier::None => Self::None,
            Specifier::Appears => Self::Appears,
            Specifier::Disappears => Self::Disappears,
            Specifier::StillDisturbed => Self::Still,
        }
    }

    const fn specifier(self) -> Specifier {
        match self {
            Self::None => Specifier::None,
            Self::Appears => Specifier::Appears,
            Self::Disappears => Specifier::Disappears,
            Self::Still => Specifier::StillDisturbed,
        }
    }
}

impl AlarmEntry {
    fn of(head: AlarmHead, data: &[u8], state: AlarmState) -> Self {
        let state = match state {
            AlarmState::Pending => AlarmProgress::Pending,
            AlarmState::Delivered => AlarmProgress::Delivered,
        };
        Self {
            kind: head.kind.number(),
            slot: head.slot,
            sequence: head.sequence,
            specifier: SpecifierName::of(head.specifier),
            additional_ack: head.additional_ack,
            data: explain::hex(data),
            state,
            text: head.to_string(),
        }
    }
}

impl TypeName {
    fn kind(&self) -> Result<AlarmType, Problem> {
        let word = match self {
            Self::Number(number) => number.to_string(),
            Self::Word(word) => word.clone(),
        };
        AlarmType::named(&word).ok_or_else(|| {
            let names = AlarmType::NAMED.map(|(name, _)| name).join(", ");
            Problem::value(format!(
                "'{word}' is no type of an alarm; expected {names}, or a number from 1 to 6 or from 32 to 126"
            ))
        })
    }
}

impl LinkState {
    fn of(link: Link) -> Self {
        let Link { sap, master, send_timeout, busy } = link;
        let send_timeout_ms = u64::try_from(send_timeout.as_millis()).unwrap_or(u64::MAX);
        Self { sap, master: master.number(), send_timeout_ms, busy }
    }
}

/// Octets as text, a point for what is no letter.
fn printable(octets: &[u8]) -> String {
    let letter = |octet: &u8| match octet {
        0x20..=0x7E => char::from(*octet),
        0..=0x1F | 0x7F.. => '.',
    };
    octets.iter().map(letter).collect()
}

/// Octets from hexadecimal digits.
pub(super) fn octets(text: &str) -> Result<Vec<u8>, Problem> {
    octets_of_hex(text).ok_or_else(|| {
        Problem::value(format!(
            "'{text}' is no hexadecimal octets; expected two digits for each, as \"01 FF\""
        ))
    })
}

/// The slot of an alarm.
fn slot(number: u8) -> Result<u8, Problem> {
    if number == u8::MAX { Err(Problem::value("slot 255 is none; expected 0 to 254")) } else { Ok(number) }
}

/// The station's records, read.
async fn look<R: Send + 'static>(
    place: &Place,
    look: impl FnOnce(&dyn Acyclic, Option<u8>) -> Result<R, Problem> + Send + 'static,
) -> Result<R, Problem> {
    place
        .ask(move |lent, address| {
            let station = lent.find(address)?;
            let (acyclic, owner) = (station.description.acyclic(), station.owner);
            look(acyclic.ok_or_else(|| lacks(address, WHAT))?, owner)
        })
        .await
}

/// Something is done to the station's records, and they are looked at then.
async fn act<R: Send + 'static>(
    place: &Place,
    act: impl Fn(&mut dyn Acyclic, crate::time::Instant) -> Result<(), Problem> + Send + 'static,
    look: impl FnOnce(&dyn Acyclic) -> Result<R, Problem> + Send + 'static,
) -> Result<R, Problem> {
    let address = place.address;
    let lacks = move || lacks(address, WHAT);
    place
        .act(
            move |station, acted| act(station.acyclic_mut().ok_or_else(lacks)?, acted.now),
            move |station| look(station.acyclic().ok_or_else(lacks)?),
        )
        .await?
}

/// Every record, by slot and index
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/records", tag = "records",
    responses((status = 200, body = Records), Problems)))]
pub(super) async fn records(place: Place) -> Result<Json<Records>, Problem> {
    let list = look(&place, |acyclic, _| {
        let mut records = Vec::new();
        acyclic.each_record(&mut |record| records.push(RecordState::of(&record)));
        Ok(Json(Records { records }))
    });
    list.await
}

/// Reads a record, not over the bus
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/records/{slot_number}/{record}", tag = "records",
    responses((status = 200, body = RecordState), Problems)))]
pub(super) async fn record(place: Place, PathOf(of): PathOf<OfRecord>) -> Result<Json<RecordState>, Problem> {
    look(&place, move |acyclic, _| RecordState::find(acyclic, of).map(Json)).await
}

/// Changes what is in a record, as the device does
///
/// Also of a record that a master cannot write. No master is told.
#[cfg_attr(test, utoipa::path(put, path = "/api/v1/lines/{line}/stations/{address}/records/{slot_number}/{record}", tag = "records", request_body = NewRecordData,
    responses((status = 200, body = RecordState), Problems)))]
pub(super) async fn change_record(
    place: Place,
    PathOf(of): PathOf<OfRecord>,
    Body(NewRecordData { data }): Body<NewRecordData>,
) -> Result<Json<RecordState>, Problem> {
    let data = octets(&data)?;
    let change = move |acyclic: &mut dyn Acyclic, now| {
        let length = RecordState::find(acyclic, of)?.length;
        acyclic.change_record(now, (of.slot_number, of.record), &data).map_err(|denied| match denied {
            Denied::Value | Denied::NotNow | Denied::Unknown => Problem::value(format!(
                "{} octets, expected {length}: record {} of slot {} has as many",
                data.len(),
                of.record,
                of.slot_number
            )),
        })
    };
    act(&place, change, move |acyclic| RecordState::find(acyclic, of).map(Json)).await
}

/// The alarms that are not acknowledged, and which types there are
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/alarms", tag = "records",
    responses((status = 200, body = Alarms), Problems)))]
pub(super) async fn alarms(place: Place) -> Result<Json<Alarms>, Problem> {
    look(&place, |acyclic, _| Ok(Json(Alarms::of(acyclic)))).await
}

impl Alarms {
    fn of(acyclic: &dyn Acyclic) -> Self {
        let (mut alarms, mut types) = (Vec::new(), Vec::new());
        acyclic.each_alarm(&mut |head, data, state| alarms.push(AlarmEntry::of(head, data, state)));
        acyclic.each_alarm_type(&mut |kind| types.push(kind.number()));
        Self { alarms, types }
    }
}

/// Raises an alarm
///
/// The owner reads it with its next Slave_Diag and acknowledges it.
#[cfg_attr(test, utoipa::path(post, path = "/api/v1/lines/{line}/stations/{address}/alarms", tag = "records", request_body = AlarmToRaise,
    responses((status = 201, body = AlarmEntry), Problems)))]
pub(super) async fn raise_alarm(
    place: Place,
    Body(wanted): Body<AlarmToRaise>,
) -> Result<(StatusCode, Json<AlarmEntry>), Problem> {
    let AlarmToRaise { kind, slot: number, specifier, additional_ack, data } = wanted;
    let (kind, slot, data) = (kind.kind()?, slot(number)?, octets(&data)?);
    let raise = move |acyclic: &mut dyn Acyclic, now| {
        let specifier = specifier.specifier();
        let new = NewAlarm { kind, slot, specifier, additional_ack, data: &data };
        acyclic.raise_alarm(now, &new).map(drop).map_err(Problem::conflict)
    };
    // The newest is the last.
    let newest = |acyclic: &dyn Acyclic| {
        let raised = Alarms::of(acyclic).alarms.pop();
        raised.ok_or_else(|| Problem::conflict("the alarm is acknowledged already"))
    };
    let raised = act(&place, raise, newest).await?;
    Ok((StatusCode::CREATED, Json(raised)))
}

/// Forgets every alarm, as if none had been raised
#[cfg_attr(test, utoipa::path(delete, path = "/api/v1/lines/{line}/stations/{address}/alarms", tag = "records",
    responses((status = 204), Problems)))]
pub(super) async fn forget_alarms(place: Place) -> Result<StatusCode, Problem> {
    let forget = |acyclic: &mut dyn Acyclic, now| {
        acyclic.forget_alarms(now);
        Ok(())
    };
    act(&place, forget, |_| Ok(StatusCode::NO_CONTENT)).await
}

/// Sends a status message, which nobody acknowledges
#[cfg_attr(test, utoipa::path(post, path = "/api/v1/lines/{line}/stations/{address}/status-messages", tag = "records", request_body = StatusToSend,
    responses((status = 201), Problems)))]
pub(super) async fn send_status(
    place: Place,
    Body(wanted): Body<StatusToSend>,
) -> Result<StatusCode, Problem> {
    let StatusToSend { kind, slot: number, specifier, data } = wanted;
    if !(1..=126).contains(&kind) {
        return Err(Problem::value(format!("{kind} is no type of a status message; expected 1 to 126")));
    }
    let (kind, slot, data) = (StatusType::numbered(kind), slot(number)?, octets(&data)?);
    let send = move |acyclic: &mut dyn Acyclic, now| {
        let new = NewStatus { kind, slot, specifier: specifier.specifier(), data: &data };
        acyclic.send_status(now, &new).map_err(Problem::conflict)
    };
    act(&place, send, |_| Ok(StatusCode::CREATED)).await
}

/// The channel of the owner, the connections of masters of class 2, identification
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/acyclic", tag = "records",
    responses((status = 200, body = Channels), Problems)))]
pub(super) async fn channels(place: Place) -> Result<Json<Channels>, Problem> {
    let list = look(&place, |acyclic, owner| {
        let channel = acyclic.channel();
        let (mut ms2, mut identification) = (Vec::new(), Vec::new());
        acyclic.each_link(&mut |link| ms2.push(LinkState::of(link)));
        acyclic.each_identification(&mut |block, octets, writable| {
            let text = match Identification::parse(octets) {
                Some(own) if block == 0 => own.to_string(),
                Some(_) | None => printable(octets).trim().to_owned(),
            };
            let data = explain::hex(octets);
            identification.push(IdentificationState { block, writable, data, text });
        });
        let ms1 = OwnersChannelState { open: channel.open, owner, busy: channel.busy };
        Ok(Json(Channels { ms1, ms2, max: acyclic.most_links(), identification }))
    });
    list.await
}
