//! Scenarios for a master of class 2, which reads and exchanges no data.

use super::{Course, Scenario, Step, built_in};
use crate::judge::master::rows::Row;
use crate::judge::master::setup::Setup;
use crate::judge::master::station::Act;
use core::time::Duration;

/// How long it may take until the master has asked for the address of the other one, and that one exchanges data.
const ENTER: Duration = Duration::from_secs(15);
const ENTER_CYCLES: u32 = 400;
/// Faults that only a start-up or data exchange gives an occasion to.
const OF_EXCHANGE: [&str; 5] =
    ["service=Set_Prm", "service=Chk_Cfg", "lose-prm", "state=DATA-EXCH", "diag-announced"];
/// Rows about a diagnosis, which it reads without being told.
const DIAGNOSES: [Row; 2] = [Row::D08, Row::D16];

/// What a master of class 2 gives an occasion to, behind the entry of the one that owns the slaves.
pub(in crate::judge) fn reading(setup: &Setup) -> Vec<Scenario> {
    let enter = Step {
        lasts: ENTER,
        cycles: ENTER_CYCLES,
        until_injected: true,
        second: Some(Course::Owns),
        ..Step::default()
    };
    let rows = [Row::R01, Row::R02, Row::R03, Row::R09];
    let mut list = vec![Scenario {
        steps: vec![enter],
        ..Scenario::one("a master of class 1 enters the ring and exchanges data with its slaves", &rows, &[])
    }];
    list.extend(built_in(setup).into_iter().filter_map(without_exchange));
    list.push(Scenario {
        returns: vec![Row::E07],
        ..Scenario::one("RS to a request", &[Row::E07], &["reject,count=1,station=S"])
    });
    list
}

/// The scenario for requests of any service, if it says something of a master that only reads.
fn without_exchange(mut scenario: Scenario) -> Option<Scenario> {
    scenario.rows.retain(|row| row.is_of_class_2());
    scenario.returns.retain(|row| row.is_of_class_2());
    let diagnoses = scenario.rows.iter().any(|row| DIAGNOSES.contains(row));
    if diagnoses {
        scenario.returns.clone_from(&scenario.rows);
    }
    for step in &mut scenario.steps {
        if step.act == Some(Act::PowerOn) || !diagnoses {
            step.act = None;
        }
        for fault in &mut step.faults {
            *fault = fault.replace(",service=Data_Exchange", "");
        }
    }
    let of_exchange = |fault: &String| OF_EXCHANGE.iter().any(|word| fault.contains(word));
    let apart = scenario.steps.iter().flat_map(|step| &step.faults).any(of_exchange);
    (scenario.others, scenario.asked) = (None, None);
    let says = !scenario.rows.is_empty() || !scenario.returns.is_empty();
    (says && !apart).then_some(scenario)
}
