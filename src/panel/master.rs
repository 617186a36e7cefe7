//! The master in this program: what it can be asked about a station, and what it does.

use core::time::Duration;

use axum::Json;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use tokio::time::{Instant as Moment, sleep};

use super::acyclic::octets;
#[cfg(test)]
use super::description::Problems;
use super::line::Line;
use super::problem::{Body, Problem};
use super::routes::Place;
use super::station::seconds;
use crate::explain::hex;
use crate::face::operation::{Act, Verb};
use crate::face::{DriveState, Operation};
use crate::host::Startup;
use crate::host::fault::BusKind;
use crate::host::inner_master::{self, Asked, InnerMaster, Shown};

/// An answer waits so long for what comes of an order.
const PATIENCE: Duration = Duration::from_millis(1500);

/// How often it looks.
const LOOK: Duration = Duration::from_millis(5);

/// What a master can ask of a station, and the master in this program.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Mastery {
    acts: Vec<ActState>,
    /// It has parameters or objects that are read and written over the bus.
    reads: bool,
    /// Octets of outputs that are set as they are; `null`: it is operated by words.
    outputs: Option<u8>,
    /// The command that does what `why` advises; `null`: there is none.
    next_command: Option<String>,
    /// `null`: there is no master in this program; it is started with `--bench`, or by `profidrive try`.
    master: Option<MasterState>,
}

/// One thing that can be asked.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct ActState {
    act: &'static str,
    name: &'static str,
    quantity: Option<QuantityState>,
    /// The command of a terminal that does the same, the number in place of `{}`; `null`: there is none.
    command: Option<String>,
}

/// The number that is given with it.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct QuantityState {
    name: &'static str,
    unit: &'static str,
    low: f64,
    high: f64,
    /// It has no fraction.
    whole: bool,
}

/// What the master in this program does with a station.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct MasterState {
    /// It has the station.
    taken: bool,
    /// Its address while it is on a line of PROFIBUS.
    own_address: Option<u8>,
    /// What it does now.
    doing: Option<String>,
    /// What came of the last order.
    done: Option<Done>,
    /// What it sends in each cycle.
    outputs_hex: String,
    /// What it has sent, the newest last.
    sent: Vec<SentWords>,
}

/// What came of an order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Done {
    number: u64,
    what: String,
    /// It was done.
    well: bool,
    /// What came of it, or why it was not done.
    text: String,
}

/// Words that were sent.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct SentWords {
    time_seconds: f64,
    text: String,
}

/// What the master in this program shall do.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct NewOrder {
    /// One of `acts`; `take`, `read`, `write`, `outputs`.
    act: String,
    /// The number of the act, or what is written.
    value: Option<f64>,
    /// What is read or written: `1004`, `945.0`; of a node `6041`, `1018:1`.
    place: Option<String>,
    /// The octets of `outputs`.
    octets_hex: Option<String>,
}

/// What a master can ask of a station
///
/// The acts with the commands of a terminal that do the same, and the state of the master in this program.
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/master", tag = "master",
    responses((status = 200, body = Mastery), Problems)))]
pub(super) async fn read(place: Place) -> Result<Json<Mastery>, Problem> {
    let Known { operation, startup, kind, state, .. } = known(&place).await?;
    let (line, address) = (&place.line, place.address);
    let prefix = prefix(line, kind, address, startup.as_ref());
    let command = |act: &Act| Some(format!("{} {}", prefix.as_ref()?, act.command?));
    let acts = operation.acts().map(|act| ActState {
        act: act.key,
        name: act.name,
        quantity: act.quantity.map(|quantity| QuantityState {
            name: quantity.name,
            unit: quantity.unit,
            low: quantity.low,
            high: quantity.high,
            whole: quantity.whole,
        }),
        command: command(&act),
    });
    let next = next_act(operation, state).as_ref().and_then(command);
    let outputs = startup.as_ref().filter(|_| operation == Operation::Octets);
    Ok(Json(Mastery {
        acts: acts.collect(),
        reads: kind == BusKind::Can || startup.as_ref().is_some_and(has_channel),
        outputs: outputs.map(|startup| startup.lengths().outputs),
        next_command: next,
        master: line.master.as_ref().map(|master| MasterState::of(master, address)),
    }))
}

/// Has the master in this program do something
///
/// The station is taken over before. The answer comes when it is done, or after 1.5 s with what is under way.
#[cfg_attr(test, utoipa::path(post, path = "/api/v1/lines/{line}/stations/{address}/master", tag = "master",
    request_body = NewOrder, responses((status = 200, body = MasterState), Problems)))]
pub(super) async fn order(place: Place, Body(order): Body<NewOrder>) -> Result<Json<MasterState>, Problem> {
    let known = known(&place).await?;
    let asked = asked(&known, order)?;
    obey(&place, known, asked).await
}

/// Has the master in this program leave the line
///
/// Every station of it is let go.
#[cfg_attr(test, utoipa::path(delete, path = "/api/v1/lines/{line}/stations/{address}/master", tag = "master",
    responses((status = 204), Problems)))]
pub(super) async fn leave(place: Place) -> Result<StatusCode, Problem> {
    let known = known(&place).await?;
    drop(obey(&place, known, Asked::Leave).await?);
    Ok(StatusCode::NO_CONTENT)
}

/// What is known of a station that shall be operated.
struct Known {
    operation: Operation,
    startup: Option<Startup>,
    kind: BusKind,
    state: Option<DriveState>,
    /// The masters that own stations of the line, each with the station.
    owners: Vec<(u8, u8)>,
    addresses: Vec<u8>,
}

async fn known(place: &Place) -> Result<Known, Problem> {
    place
        .ask(|lent, address| {
            let state = lent.find(address)?.description.drive_state();
            let (operation, startup) = lent.operation(address).unwrap_or((Operation::Octets, None));
            let addresses = lent.addresses();
            let owners =
                addresses.iter().filter_map(|one| Some((lent.station(*one)?.owner?, *one))).collect();
            Ok(Known { operation, startup, kind: lent.kind(), state, owners, addresses })
        })
        .await
}

fn has_channel(startup: &Startup) -> bool {
    startup.ppo.is_some_and(|ppo| ppo.has_pkw())
}

/// What is asked, if it can be.
fn asked(known: &Known, order: NewOrder) -> Result<Asked, Problem> {
    let NewOrder { act, value, place, octets_hex } = order;
    let place = || {
        let text = place.as_deref().unwrap_or_default();
        place_of(known.kind, text).ok_or_else(|| {
            let form =
                if known.kind == BusKind::Can { "6041 or 1018:1, hexadecimal" } else { "1004 or 945.0" };
            Problem::value(format!(
                "place: '{text}' names nothing that can be read or written; expected {form}"
            ))
        })
    };
    Ok(match act.as_str() {
        "take" => Asked::Take,
        "read" => Asked::Read(place()?),
        "write" => {
            let value = value.ok_or_else(|| Problem::value("value is missing: nothing is written"))?;
            Asked::Write(place()?, value)
        }
        "outputs" => Asked::Outputs(octets(octets_hex.as_deref().unwrap_or_default())?),
        key => {
            let known = known.operation;
            let act = known.act(key).ok_or_else(|| {
                let keys: Vec<&str> = known.acts().map(|act| act.key).collect();
                Problem::value(format!(
                    "'{key}' cannot be asked of this station; there is take, {}",
                    keys.join(", ")
                ))
            })?;
            if act.quantity.is_some() && value.is_none() {
                return Err(Problem::value(format!("'{key}' needs a value")));
            }
            Asked::Act(act, value)
        }
    })
}

/// A parameter in decimal, or an entry in hexadecimal.
fn place_of(bus: BusKind, text: &str) -> Option<inner_master::Place> {
    let text = text.trim();
    let (number, sub) = match text.split_once(['.', ':']) {
        Some((number, sub)) => (number, Some(sub)),
        None => (text, None),
    };
    let plain = |text: &str| text.trim_start_matches("0x").trim_end_matches(['h', 'H']).to_owned();
    let radix = if bus == BusKind::Can { 16 } else { 10 };
    let number = u16::from_str_radix(&plain(number), radix).ok()?;
    let sub = sub.map(|sub| u8::from_str_radix(&plain(sub), radix)).transpose().ok()?;
    Some(inner_master::Place { number, sub })
}

/// Gives the order, and waits for what comes of it.
async fn obey(place: &Place, known: Known, asked: Asked) -> Result<Json<MasterState>, Problem> {
    let (line, address) = (&place.line, place.address);
    let master = line.master.as_ref().ok_or_else(|| {
        Problem::conflict(
            "there is no master in this program; start it with --bench, or use 'profidrive try'",
        )
    })?;
    let own = master.own();
    let other = known.owners.iter().find(|(owner, _)| Some(*owner) != own);
    if let Some((owner, station)) = other.filter(|_| asked != Asked::Leave) {
        return Err(Problem::conflict(format!(
            "master {owner} owns station {station}: two masters would disturb each other; end that one first"
        )));
    }
    let own = own
        .or_else(|| inner_master::free_address(|address| known.addresses.contains(&address)))
        .ok_or_else(|| Problem::conflict("no address is free for the master"))?;
    let ordered = master.ask((address, own), known.startup, asked);
    let number = ordered.ok_or_else(Problem::busy)?;
    let end = Moment::now() + PATIENCE;
    loop {
        let shown = master.shown(address);
        let over = shown.done.as_ref().is_some_and(|done| done.number >= number);
        if over || Moment::now() >= end {
            return Ok(Json(MasterState::shown(master, shown)));
        }
        sleep(LOOK).await;
    }
}

impl MasterState {
    /// What it does with a station.
    pub(super) fn of(master: &InnerMaster, address: u8) -> Self {
        Self::shown(master, master.shown(address))
    }

    fn shown(master: &InnerMaster, shown: Shown) -> Self {
        let Shown { taken, doing, done, outputs, sent } = shown;
        Self {
            taken,
            own_address: master.own(),
            doing,
            done: done.map(|inner_master::Done { number, what, well, text }| Done {
                number,
                what,
                well,
                text,
            }),
            outputs_hex: hex(&outputs),
            sent: sent
                .into_iter()
                .map(|sent| SentWords { time_seconds: seconds(sent.at), text: sent.text })
                .collect(),
        }
    }
}

/// What the drive needs next: as `why` advises.
fn next_act(operation: Operation, state: Option<DriveState>) -> Option<Act> {
    let verb = match state? {
        DriveState::Fault => Verb::Acknowledge,
        DriveState::Enabled => return None,
        DriveState::Off | DriveState::NotReady | DriveState::Inhibited | DriveState::Ready => Verb::Enable,
    };
    operation.acts().find(|act| act.verb == verb)
}

/// How `profidrive master` names the station; `None`: it cannot take it over.
fn prefix(line: &Line, kind: BusKind, address: u8, startup: Option<&Startup>) -> Option<String> {
    let link = &line.link;
    if kind == BusKind::Can {
        return Some(format!("profidrive master --link {link} --node {address}"));
    }
    let startup = startup?;
    let begin = format!("profidrive master --link {link} --address {address}");
    match (startup.operation, startup.ppo) {
        (Operation::Positioning, _) => Some(begin),
        // It sends the customary configuration and no user parameters.
        (Operation::Speed, Some(ppo))
            if startup.configuration == ppo.configuration() && startup.user_prm.is_empty() =>
        {
            let number = ppo.number()?;
            Some(format!("{begin} --ppo {number} --ident {:04X}", startup.ident))
        }
        (Operation::Speed | Operation::Octets | Operation::Cia402 { .. } | Operation::Objects, _) => None,
    }
}
