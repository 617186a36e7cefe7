//! The modules of a station that a file describes: values by slot, octet and type, and the diagnosis that is raised.
//!
//! | file | holds |
//! | --- | --- |
//! | `values` | inputs and outputs by slot, octet and type |
//! | `diagnosis` | the diagnosis that is raised |

mod diagnosis;
pub(super) mod values;

use axum::Json;
use serde::Serialize;

#[cfg(test)]
use super::description::Problems;
use super::line::{OnLine, lacks};
use super::problem::{Body, Problem};
use super::routes::Place;
use super::station::State;
use crate::gsd::Raised;
use crate::host::Bus;
use crate::profibus::fdl::Address;
use diagnosis::{Possible, RaisedDiagnosis};

pub(super) use diagnosis::Diagnosis;

/// What a diagnosis may say, by the texts of the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Texts {
    #[serde(flatten)]
    possible: Possible,
    /// The modules of the file by name.
    modules: Vec<String>,
    /// The slots of the configuration in force.
    slots: Vec<SlotNames>,
    /// The user parameters of the Set_Prm in force.
    user_prm: Vec<PrmState>,
}

/// A parameter of the station or of a module.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct PrmState {
    /// The slot of its module; `null`: it is one of the station.
    slot: Option<u16>,
    /// Its first octet of the user parameters, from 0.
    octet: usize,
    name: String,
    value: i64,
    /// The text of the value.
    text: Option<String>,
}

/// Which module is in a slot.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct SlotNames {
    slot: u16,
    /// Its name; several: Set_Prm and Chk_Cfg do not tell these modules apart; none: an empty slot.
    names: Vec<String>,
}

/// The station has no modules.
fn missing(address: u8) -> Problem {
    lacks(address, "modules")
}

/// The bus of the station.
fn bus(lent: &mut dyn OnLine, address: u8) -> Result<&mut Bus, Problem> {
    lent.find(address)?;
    lent.profibus().ok_or_else(|| missing(address))
}

/// The texts of its file: what a diagnosis may say, and the modules
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/texts", tag = "modules",
    responses((status = 200, body = Texts), Problems)))]
pub(super) async fn texts(place: Place) -> Result<Json<Texts>, Problem> {
    let texts = place.ask(|lent, address| {
        let station = bus(lent, address)?.modules(Address::from_octet(address));
        let station = station.ok_or_else(|| missing(address))?;
        let gsd = station.gsd();
        let modules = gsd.modules.iter().map(|module| module.name.clone()).collect();
        let slots = station.layout().iter().map(|placed| SlotNames {
            slot: placed.slot.number,
            names: placed.names(gsd).into_iter().map(str::to_owned).collect(),
        });
        let slave = station.slave();
        let user_prm = slave.application().prm_values(slave.configuration(), slave.user_prm());
        let user_prm = user_prm.into_iter().map(|value| PrmState {
            slot: value.slot,
            octet: value.octet,
            name: value.parameter.name.clone(),
            value: value.value,
            text: value.text.map(str::to_owned),
        });
        Ok(Json(Texts {
            possible: Possible::of(gsd),
            modules,
            slots: slots.collect(),
            user_prm: user_prm.collect(),
        }))
    });
    texts.await
}

/// The diagnosis that is raised
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/diagnosis", tag = "modules",
    responses((status = 200, body = Diagnosis), Problems)))]
pub(super) async fn diagnosis(place: Place) -> Result<Json<Diagnosis>, Problem> {
    let diagnosis = place.look().await?.diagnosis;
    diagnosis.map(Json).ok_or_else(|| missing(place.address))
}

/// Has the diagnosis report this and nothing else
#[cfg_attr(test, utoipa::path(put, path = "/api/v1/lines/{line}/stations/{address}/diagnosis", tag = "modules",
    request_body = RaisedDiagnosis, responses((status = 200, body = State), Problems)))]
pub(super) async fn raise(place: Place, Body(wanted): Body<RaisedDiagnosis>) -> Result<Json<State>, Problem> {
    report(&place, wanted.raised()?).await
}

/// Ends the diagnosis
#[cfg_attr(test, utoipa::path(delete, path = "/api/v1/lines/{line}/stations/{address}/diagnosis", tag = "modules",
    responses((status = 200, body = State), Problems)))]
pub(super) async fn end_diagnosis(place: Place) -> Result<Json<State>, Problem> {
    report(&place, Raised::default()).await
}

/// Has the diagnosis report something, and says how the station is then.
async fn report(place: &Place, raised: Raised) -> Result<Json<State>, Problem> {
    let done = place.ask(move |lent, address| {
        let raise =
            bus(lent, address)?.with_modules(Address::from_octet(address), |modules| modules.raise(raised));
        raise.ok_or_else(|| missing(address))?.map_err(Problem::value)
    });
    done.await?;
    place.look().await.map(Json)
}
