//! Scenarios: what the stations do on purpose, as data.
//!
//! A scenario is a list of [`Step`]s. A step does something to a station, injects faults, and lasts until its faults
//! have acted or its time is over. Faults are written as for `--fault` ([`crate::host::fault::Rule`]), with three
//! things more: `station=S` is the station of the scenario, `station=O` another one, and times may be given in slot times
//! of the master, `late=1.5slot`. What the master makes of it the observer sees; a scenario says only which rows it is
//! for.

use core::time::Duration;

use thiserror::Error;

use super::rows::Row;
use super::setup::{Setup, Slave};
use super::station::Act;
use crate::host::fault::{Rule, RuleError};
use crate::profibus::dp::IoLengths;
use crate::profibus::fdl::Address;

mod acyclic;
mod list;
mod reading;
mod ring;

pub use super::second::{Course, Duty};
pub(super) use acyclic::acyclic;
pub use list::{asking, built_in};
pub(super) use reading::reading;
pub(super) use ring::{double, joining, ring};

/// Something the stations do on purpose.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// What is tried, in words.
    pub name: String,
    /// The rows it gives an occasion to.
    pub rows: Vec<Row>,
    /// Which station.
    pub station: Which,
    /// What it needs.
    pub needs: Vec<Need>,
    /// One after the other.
    pub steps: Vec<Step>,
    /// Data exchange with every station must come back behind it, or these rows are broken.
    pub returns: Vec<Row>,
    /// While it lasts at least so many Data_Exchange with each other station, or the row is broken.
    pub others: Option<(Row, u32)>,
    /// The station must have been asked while it was silent, or the row is broken.
    pub asked: Option<Row>,
    /// Replies are held back: the master must wait for them.
    pub holds: bool,
}

/// One step of a scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Step {
    /// What is done to the station first.
    pub act: Option<Act>,
    /// The faults, as they are written.
    pub faults: Vec<String>,
    /// How long it lasts at most.
    pub lasts: Duration,
    /// It ends earlier, once every fault with a count has acted so often.
    pub until_injected: bool,
    /// What the master is asked for, as `--ask` takes it; the time counts from when that is done.
    pub ask: Option<String>,
    /// What must have been seen at its end.
    pub check: Option<Check>,
    /// It lasts at least so many slot times, retries included: until the master has given the station up.
    pub until_lost: bool,
    /// It lasts at least so many cycles of the master.
    pub cycles: u32,
    /// And so many of them more: its time begins when the master has come so far.
    pub more_cycles: u32,
    /// What a second master does on the line; the step ends when that is done.
    pub second: Option<Course>,
}

/// What a master must have done after it was asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Check {
    /// It is in CLEAR.
    Clear,
    /// It is in OPERATE.
    Operate,
    /// These outputs are sent.
    Outputs(Vec<(Address, Vec<u8>)>),
    /// It is silent.
    Stop,
    /// It has started every station anew.
    Begun,
    /// It has gone to CLEAR by itself, if it has.
    AutoClear,
    /// It is still in CLEAR, if it went there by itself.
    StaysClear,
    /// The station got this request of DP-V1.
    Service(Address, Vec<u8>),
    /// It has sent a Global_Control.
    Command {
        /// With this bit of the command.
        wanted: u8,
        /// Without this one.
        undo: u8,
        /// To these groups.
        groups: u8,
    },
}

/// The station of a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// The first with inputs and outputs, or the first.
    Any,
    /// The last one.
    Last,
    /// Each one by itself.
    At(Address),
    /// The first with outputs only.
    OutputsOnly,
    /// The first with eight octets of inputs.
    EightInputs,
    /// The first that has services of DP-V1 for this master.
    Services,
}

/// What a scenario needs to say something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// The slot time of the master.
    Slot,
    /// The retries of the master.
    Retries,
    /// Another station.
    Other,
    /// The target rotation time of the master.
    Ttr,
    /// A station with inputs.
    Inputs,
    /// A C1_Response_Timeout that can be waited for.
    ResponseTimeout,
}

/// A scenario names a station that is not there.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("station {station} is not one of those that are present: {}", listed(there))]
pub struct MissingStation {
    /// The station.
    pub station: Address,
    /// Those that are there.
    pub there: Vec<Address>,
}

fn listed(stations: &[Address]) -> String {
    stations.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

impl Scenario {
    /// The station it is about. `None`: there is none.
    pub(super) fn subject<'a>(&self, setup: &'a Setup) -> Option<&'a Slave> {
        let lengths = |slave: &Slave| slave.lengths().unwrap_or(IoLengths { outputs: 1, inputs: 1 });
        match self.station {
            Which::Any => setup
                .present()
                .find(|slave| lengths(slave).inputs > 0 && lengths(slave).outputs > 0)
                .or(setup.present().find(|slave| lengths(slave).inputs > 0))
                .or(setup.present().next()),
            Which::Last => setup.present().last(),
            Which::At(address) => setup.present().find(|slave| slave.address == address),
            Which::OutputsOnly => setup.present().find(|slave| lengths(slave).inputs == 0),
            Which::EightInputs => setup.present().find(|slave| lengths(slave).inputs == 8),
            Which::Services => setup.present().find(|slave| setup.has_services(slave)),
        }
    }

    /// Why it cannot be played here; `None`: it can.
    pub(super) fn obstacle(&self, setup: &Setup) -> Option<&'static str> {
        let Some(subject) = self.subject(setup) else {
            return Some(match self.station {
                Which::OutputsOnly => "needs a station with outputs only",
                Which::EightInputs => "needs a station with eight octets of inputs",
                Which::Services => {
                    "needs a station of DP-V1: dpv1, or a device file that offers its services"
                }
                Which::Any | Which::Last | Which::At(_) => "needs a station that is present",
            });
        };
        if let Some(reason) = setup.master_gsd.as_ref().and_then(|gsd| gsd.obstacle(self)) {
            return Some(reason);
        }
        let inputs = subject.lengths().is_none_or(|lengths| lengths.inputs > 0);
        self.needs.iter().find_map(|need| match need {
            Need::Slot if setup.slot.is_none() => Some("needs --slot: how long the master waits for a reply"),
            Need::Retries if setup.retries.is_none() => Some("needs --retries: how often the master repeats"),
            Need::Other if setup.present().count() < 2 => Some("needs two stations"),
            Need::Inputs if !inputs => Some("needs a station with inputs"),
            Need::ResponseTimeout if subject.response_timeout().is_none_or(|time| time > LONGEST_TIMEOUT) => {
                Some("needs a device file with a C1_Response_Timeout of 2 s at most")
            }
            Need::Ttr if setup.ttr.is_none() => Some("needs --ttr: the target rotation time of the master"),
            Need::Slot | Need::Retries | Need::Other | Need::Inputs | Need::Ttr | Need::ResponseTimeout => {
                None
            }
        })
    }

    /// A scenario of one step, as a user writes it.
    pub fn written(name: &str, rows: &[Row], station: Which, step: Step, returns: Vec<Row>) -> Self {
        Self { station, returns, steps: vec![step], ..Self::one(name, rows, &[]) }
    }

    /// Whether its faults are faults.
    ///
    /// # Errors
    /// The first that is none.
    pub fn check(&self) -> Result<(), RuleError> {
        let any = Address::from_octet(0);
        self.steps.iter().try_for_each(|step| step.compiled(&Setup::default(), any).map(|_| ()))
    }

    /// Whether it says something of one of these rows. One that is for no row in particular says something of all.
    pub(crate) fn is_for(&self, wanted: &[Row]) -> bool {
        let mut rows = self.rows.iter().chain(&self.returns).peekable();
        rows.peek().is_none() || rows.any(|row| wanted.contains(row))
    }

    /// Whether the stations that it names are there.
    ///
    /// # Errors
    /// The first that is not.
    pub(crate) fn check_stations(&self, setup: &Setup) -> Result<(), MissingStation> {
        let there: Vec<Address> = setup.present().map(|slave| slave.address).collect();
        let missing = |station| MissingStation { station, there: there.clone() };
        if let Which::At(station) = self.station
            && !there.contains(&station)
        {
            return Err(missing(station));
        }
        let any = there.first().copied().unwrap_or(Address::from_octet(0));
        let faults = self.steps.iter().filter_map(|step| step.compiled(setup, any).ok()).flatten();
        let mut stations = faults.filter_map(|fault| fault.station());
        stations.find(|station| !there.contains(station)).map_or(Ok(()), |station| Err(missing(station)))
    }

    /// What a second master does in it.
    pub(super) fn course(&self) -> Option<Course> {
        self.steps.iter().find_map(|step| step.second)
    }

    /// A scenario about these rows, one step long.
    pub(super) fn one(name: &str, rows: &[Row], faults: &[&str]) -> Self {
        let faults = faults.iter().map(ToString::to_string).collect();
        let lasts = Duration::from_secs(3);
        let step = Step { faults, lasts, until_injected: true, cycles: INJECTED, ..Step::default() };
        Self {
            name: name.into(),
            rows: rows.to_vec(),
            station: Which::Any,
            needs: Vec::new(),
            steps: vec![step],
            returns: Vec::new(),
            others: None,
            asked: None,
            holds: false,
        }
    }
}

impl Step {
    /// Its faults, for a station.
    ///
    /// # Errors
    /// [`RuleError`]: one of them is none.
    pub(super) fn compiled(&self, setup: &Setup, subject: Address) -> Result<Vec<Rule>, RuleError> {
        self.faults.iter().map(|fault| compile(fault, setup, subject)?.parse()).collect()
    }

    /// How long it lasts at most with a master whose cycle takes so long.
    pub(super) fn time(&self, setup: &Setup, cycle: Duration) -> Duration {
        let lasts = self.lasts.max(cycle.saturating_mul(self.cycles));
        let lasts = lasts.saturating_add(cycle.saturating_mul(self.more_cycles));
        if !self.until_lost {
            return lasts;
        }
        let slot = setup.slot.unwrap_or(SLOT);
        let attempts = setup.retries.unwrap_or(RETRIES).min(MOST_RETRIES) + 2;
        lasts.max(slot * attempts * 2)
    }
}

/// So many cycles are enough for every fault of a step that ends when they have acted.
const INJECTED: u32 = 40;
/// What a master is taken to wait if it is not said.
pub(super) const SLOT: Duration = Duration::from_millis(100);
/// A longer C1_Response_Timeout is not waited for.
const LONGEST_TIMEOUT: Duration = Duration::from_secs(2);
/// How often a master is taken to repeat if it is not said.
const RETRIES: u32 = 3;

/// More retries than this are not waited for.
const MOST_RETRIES: u32 = 15;

/// A fault as `--fault` takes it.
fn compile(fault: &str, setup: &Setup, subject: Address) -> Result<String, RuleError> {
    let other = setup.present().find(|slave| slave.address != subject).map(|slave| slave.address);
    let part = |part: &str| -> Result<String, RuleError> {
        let wrong = || RuleError::Value {
            key: part.into(),
            expected: "a number of slot times, such as late=1.5slot, or lost for those until a slave is lost",
            got: part.into(),
        };
        match part {
            "station=S" => return Ok(format!("station={subject}")),
            "station=O" => return Ok(format!("station={}", other.unwrap_or(subject))),
            "count=RETRIES" => return Ok(format!("count={}", setup.retries.unwrap_or(RETRIES).max(1))),
            _ => {}
        }
        let Some((key, slots)) = part.strip_suffix("slot").and_then(|part| part.split_once('=')) else {
            return Ok(part.into());
        };
        let attempts = f64::from(setup.retries.unwrap_or(RETRIES)) + 1.0;
        let slots = match slots.strip_prefix("lost+") {
            Some(more) => attempts + more.parse::<f64>().map_err(|_| wrong())?,
            None => slots.parse::<f64>().map_err(|_| wrong())?,
        };
        if !(0.0..1e6).contains(&slots) {
            return Err(wrong());
        }
        let time = setup.slot.unwrap_or(SLOT).mul_f64(slots);
        Ok(format!("{key}={}us", time.as_micros().max(1)))
    };
    let parts: Vec<String> = fault.split(',').map(part).collect::<Result<_, _>>()?;
    Ok(parts.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup() -> Setup {
        let slave = |number| Slave::new(Address::from_octet(number), 0x1234, vec![0x23, 0x13]);
        Setup {
            stations: vec![slave(5), slave(6)],
            slot: Some(Duration::from_millis(20)),
            retries: Some(2),
            ..Setup::default()
        }
    }

    #[test]
    fn times_in_slots_and_stations_are_put_in() {
        let compiled = |fault| compile(fault, &setup(), Address::from_octet(5));
        assert_eq!(compiled("late=1.5slot,station=S"), Ok("late=30000us,station=5".into()));
        assert_eq!(compiled("late=lost+0.25slot,station=O"), Ok("late=65000us,station=6".into()));
        assert!(compiled("late=xslot").is_err());
    }

    #[test]
    fn every_fault_of_the_list_is_one() {
        for scenario in built_in(&setup()) {
            for step in &scenario.steps {
                let faults = step.compiled(&setup(), Address::from_octet(5));
                assert!(faults.is_ok(), "{}: {faults:?}", scenario.name);
            }
        }
    }
}
