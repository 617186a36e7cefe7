//! The switches under the cover of a station.

use axum::Json;
use serde::{Deserialize, Serialize};

#[cfg(test)]
use super::description::Problems;
use super::line::lacks;
use super::problem::{Body, Problem};
use super::routes::Place;
use crate::face::Description;

/// The switches of a station and what they mean. They are read when it is switched on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct SwitchesState {
    /// The first switch first, `true` = on.
    positions: Vec<bool>,
    /// What each is for.
    names: Vec<&'static str>,
    /// What they say together.
    text: String,
}

/// New positions of all switches.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct SwitchesChange {
    /// The first switch first, `true` = on.
    positions: Vec<bool>,
}

/// The switches of a station
#[cfg_attr(test, utoipa::path(get, path = "/api/v1/lines/{line}/stations/{address}/switches", tag = "station",
    responses((status = 200, body = SwitchesState), Problems)))]
pub(super) async fn read(place: Place) -> Result<Json<SwitchesState>, Problem> {
    let read = place.ask(|lent, address| {
        let switches = SwitchesState::of(lent.find(address)?.description);
        switches.map(Json).ok_or_else(|| lacks(address, "switches"))
    });
    read.await
}

/// Sets all switches
///
/// They are read when the station is switched on next.
#[cfg_attr(test, utoipa::path(put, path = "/api/v1/lines/{line}/stations/{address}/switches", tag = "station",
    request_body = SwitchesChange, responses((status = 200, body = SwitchesState), Problems)))]
pub(super) async fn set(
    place: Place,
    Body(SwitchesChange { positions }): Body<SwitchesChange>,
) -> Result<Json<SwitchesState>, Problem> {
    let address = place.address;
    let set = move |station: &mut dyn Description, _: &super::line::Acted<'_>| {
        let now = SwitchesState::of(station).ok_or_else(|| lacks(address, "switches"))?;
        let (count, got) = (now.names.len(), positions.len());
        if got != count {
            return Err(Problem::value(format!(
                "positions must have {count} values, the first switch first, got {got}"
            )));
        }
        station.set_switches(positions.iter().rev().fold(0, |bits, on| bits << 1 | u16::from(*on)));
        Ok(())
    };
    let switches = place.act(set, SwitchesState::of).await?;
    switches.map(Json).ok_or_else(|| lacks(address, "switches"))
}

impl SwitchesState {
    pub(super) fn of(station: &dyn Description) -> Option<Self> {
        let mut found = None;
        station.tell_switches(&mut |switches| {
            let is_on = |place: usize| switches.positions >> place & 1 != 0;
            found = Some(Self {
                positions: (0..switches.names.len()).map(is_on).collect(),
                names: switches.names.to_vec(),
                text: switches.text.to_string(),
            });
        });
        found
    }
}
