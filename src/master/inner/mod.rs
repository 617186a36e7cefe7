//! The master in this program: it operates the devices of a line that the same process emulates, for people who have no
//! master of their own at hand.
//!
//! ```text
//! face ──order──▶ InnerMaster ──▶ slaves: a thread with a Session, beside the link of the line
//!      ◀──shown──             ◀── nodes:  a participant of the bus of CAN
//! ```
//!
//! The words are those of the clients ([`crate::client`]): the same steps that `profidrive master` takes.

mod commanded;
mod nodes;
mod slaves;

pub(crate) use nodes::InnerNodes;
pub(crate) use slaves::InnerSlaves;

use crate::face::operation::Act;
use crate::host::inner_master::Place;

/// An act in words, with its number.
fn said(act: &Act, number: Option<f64>) -> String {
    let name = act.name.to_lowercase();
    match (number, act.quantity) {
        (Some(number), Some(quantity)) => format!("{name} {number} {}", quantity.unit).trim_end().to_owned(),
        (_, _) => name,
    }
}

/// The number of an act, within its bounds.
fn number_of(act: &Act, number: Option<f64>) -> Result<i32, String> {
    let Some(quantity) = act.quantity else { return Ok(0) };
    let number = number.unwrap_or(f64::NAN);
    let (low, high) = (quantity.low, quantity.high);
    if !(low..=high).contains(&number) || quantity.whole && number.fract() != 0.0 {
        let unit = quantity.unit;
        return Err(format!(
            "{} must be a whole number from {low} to {high} {unit}",
            quantity.name.to_lowercase()
        ));
    }
    #[expect(clippy::cast_possible_truncation, reason = "within the bounds, which are of 32 bits")]
    let number = number as i32;
    Ok(number)
}

/// A parameter as people write it.
fn pnu(place: Place) -> String {
    match place.sub {
        Some(sub) => format!("PNU {}.{sub}", place.number),
        None => format!("PNU {}", place.number),
    }
}
