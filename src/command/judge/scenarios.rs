//! `--scenarios FILE.toml`: scenarios of the user.
//!
//! ```toml
//! [[scenario]]
//! name = "Chk_Cfg is answered late, twice"
//! station = 6                      # the first one without it
//! first = "power-on"               # or diagnose, diagnosis-gone, long-diagnosis, take, release
//! faults = ["late=1.5slot,station=S,service=Chk_Cfg,count=2"]
//! seconds = 3.0
//! rows = ["M-C03"]                 # it is played if one of them is wanted
//! returns = ["M-L02"]              # broken if data exchange does not come back
//! ```

use core::time::Duration;
use std::path::{Path, PathBuf};

use crate::judge::scenario::{MissingStation, Scenario, Step, Which};
use crate::judge::{Act, Requirement as _, Row, Setup};
use crate::profibus::fdl::Address;
use serde::Deserialize;

use crate::command::Failure;

/// The longest step.
const MOST_SECONDS: f64 = 60.0;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    scenario: Vec<Written>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: String,
    station: Option<u8>,
    first: Option<String>,
    #[serde(default)]
    faults: Vec<String>,
    seconds: Option<f64>,
    #[serde(default)]
    rows: Vec<String>,
    #[serde(default)]
    returns: Vec<String>,
}

/// The scenarios of these files, for these stations.
pub(super) fn read(files: &[PathBuf], setup: &Setup) -> Result<Vec<Scenario>, Failure> {
    let mut scenarios = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(file)
            .map_err(|error| Failure::Other(format!("cannot read {}: {error}", file.display())))?;
        let parsed: File = toml::from_str(&text).map_err(|error| wrong(file, &error.to_string()))?;
        for written in &parsed.scenario {
            let scenario = scenario(written).map_err(|error| wrong(file, &error))?;
            scenario.check_stations(setup).map_err(|error| wrong(file, &missing(&scenario.name, &error)))?;
            scenarios.push(scenario);
        }
    }
    Ok(scenarios)
}

fn wrong(file: &Path, error: &str) -> Failure {
    let line = error.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    Failure::Usage(format!("{}: {line}", file.display()))
}

/// Names the station that is near.
fn missing(name: &str, error: &MissingStation) -> String {
    let distance = |station: &&Address| station.number().abs_diff(error.station.number());
    let near = error.there.iter().min_by_key(distance);
    let near = near.map(|near| format!("; did you mean {near}?")).unwrap_or_default();
    format!("{name}: {error}{near}")
}

fn scenario(written: &Written) -> Result<Scenario, String> {
    let Written { name, station, first, faults, seconds, rows, returns } = written;
    let named = |rows: &[String]| -> Result<Vec<Row>, String> {
        let row = |id: &String| {
            Row::named(id).ok_or_else(|| format!("{name}: '{id}' is no row; a row is for example M-C03"))
        };
        rows.iter().map(row).collect()
    };
    let act = first.as_ref().map(|first| {
        let act = Act::ALL.into_iter().find(|(act, _)| act == first).map(|(_, act)| act);
        let names = Act::ALL.map(|(act, _)| act).join(", ");
        act.ok_or_else(|| format!("{name}: '{first}' is no first step of a scenario; expected {names}"))
    });
    let station = match station {
        None => Which::Any,
        Some(number) => Which::At(Address::station(*number).map_err(|error| format!("{name}: {error}"))?),
    };
    let lasts = seconds.unwrap_or(3.0);
    if !(0.0..=MOST_SECONDS).contains(&lasts) {
        return Err(format!("{name}: seconds is {lasts}, expected 0 to {MOST_SECONDS}"));
    }
    let step = Step {
        act: act.transpose()?,
        faults: faults.clone(),
        lasts: Duration::from_secs_f64(lasts),
        until_injected: seconds.is_none(),
        ..Step::default()
    };
    let scenario = Scenario::written(name, &named(rows)?, station, step, named(returns)?);
    scenario.check().map_err(|error| format!("{name}: {error}"))?;
    Ok(scenario)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Scenario, String> {
        let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
        scenario(&file.scenario[0])
    }

    #[test]
    fn a_scenario_is_read_and_a_wrong_one_is_refused() {
        let text = "[[scenario]]\nname = \"late\"\nstation = 6\nfirst = \"power-on\"\n\
            faults = [\"late=1.5slot,station=S,service=Chk_Cfg,count=2\"]\nrows = [\"M-C03\"]\n";
        let scenario = read_text(text).unwrap();
        assert_eq!((scenario.rows, scenario.steps[0].act), (vec![Row::C03], Some(Act::PowerOn)));
        for (from, to, part) in [
            ("M-C03", "M-Q03", "'M-Q03' is no row"),
            ("power-on", "explode", "'explode' is no first step of a scenario"),
            ("late=1.5slot", "later=1.5slot", "'later'"),
            ("station = 6", "station = 127", "outside 0..126"),
            ("station = 6", "stations = 6", "unknown field"),
        ] {
            let error = read_text(&text.replace(from, to)).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }
}
