//! Scenarios with a second master on the line, those that the master survives most easily first.

use core::time::Duration;

use super::{Course, Need, Scenario, Step};
use crate::judge::master::rows::Row;

/// How long it may take until the master asks for an address of its GAP.
const GAP: Duration = Duration::from_secs(6);
const GAP_CYCLES: u32 = 150;

/// A master of the ring is played.
pub(in crate::judge) fn ring() -> Vec<Scenario> {
    vec![
        one(
            "a second master enters the ring, reads a slave, and then takes no token",
            &[Row::R01, Row::R02, Row::R03, Row::R04, Row::R09, Row::K04],
            Course::Works,
            &[],
        ),
        one(
            "a second and a third master pass the token to each other",
            &[Row::R03, Row::R04],
            Course::Third,
            &[],
        ),
        one("a second master listens only", &[Row::R02, Row::K02], Course::Listens, &[]),
        one("a token of a station that is not in the ring", &[Row::R05], Course::Strange, &[]),
        one(
            "a second master has the token for twice the target rotation time",
            &[Row::R08],
            Course::Slow,
            // One message cycle is always allowed.
            &[Need::Ttr, Need::Other],
        ),
        one("a second master leaves with the token", &[Row::R07], Course::LeavesWithToken, &[Need::Slot]),
    ]
}

/// The end of all: behind it a master may want its user.
pub(in crate::judge) fn double() -> Scenario {
    one("a second master has the address of the master", &[Row::R06], Course::Double, &[])
}

fn one(name: &str, rows: &[Row], course: Course, needs: &[Need]) -> Scenario {
    let step = Step {
        lasts: GAP,
        cycles: GAP_CYCLES,
        until_injected: true,
        second: Some(course),
        ..Step::default()
    };
    let returns = vec![course.row()];
    Scenario { steps: vec![step], needs: needs.to_vec(), returns, ..Scenario::one(name, rows, &[]) }
}

/// The same for a master that is operated: it is switched off and on while a ring runs.
pub(in crate::judge) fn joining() -> Scenario {
    let step = Step {
        lasts: GAP,
        until_injected: true,
        ask: Some("restart".into()),
        second: Some(Course::Runs),
        ..Step::default()
    };
    let name = "the master is restarted while another one has the ring";
    Scenario { steps: vec![step], returns: vec![Row::R10], ..Scenario::one(name, &[Row::R10], &[]) }
}
