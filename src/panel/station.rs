//! A station of either bus as JSON, from what it tells of itself ([`Description`]) and what its bus knows of it.
//!
//! | file | holds |
//! | --- | --- |
//! | `values` | values, words, process data, history |
//! | `display` | rows, signs, LEDs |
//! | `handlers` | which stations there are, the state of each, why it does not move |
//! | `spec` | a station that is added |

mod display;
pub(super) mod handlers;
pub(super) mod spec;
mod values;

use serde::Serialize;

use super::inputs::{InputState, KeyState, Provocation};
use super::line::OnLine;
use super::master::MasterState;
use super::modules::Diagnosis;
use super::stream::LastRefusal;
use super::switches::SwitchesState;
use crate::explain::Known;
use crate::face::description::{Group, Supply};
use crate::face::{Description, Reason};
use crate::host::Presence;
use crate::host::fault::BusKind;
use crate::time::Instant;
use display::Display;

pub(super) use values::{AmountState, BitState, Entry, Past, Process, ValueState, WordState};

/// A fault that a station is in.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct FaultNow {
    /// Its code in the device's own words.
    pub(super) fault: String,
    /// What it means; may be empty.
    pub(super) text: String,
}

/// What is to be known about a station at a glance.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Summary {
    /// The name of its line.
    line: String,
    bus: BusKind,
    /// The station address, or the node number.
    #[cfg_attr(test, schema(minimum = 0, maximum = 127))]
    address: u8,
    /// As on the command line: `ag03-1`; `own` for one that is in no list.
    device: &'static str,
    /// Its name for people.
    product: String,
    /// `null`: its supply is not switched here.
    power: Option<Supply>,
    /// `null`: every node takes part.
    presence: Option<Presence>,
    /// Whether it exchanges process data.
    exchanging: bool,
    /// What its bus calls its state: `DATA-EXCH`, `PRE-OPERATIONAL`; `null` while it is off.
    pub(super) bus_state: Option<String>,
    /// The master that owns the slave.
    owner_address: Option<u8>,
    /// The state of its drive in the words that all devices share: `off`, `not_ready`, `inhibited`, `ready`, `enabled`,
    /// `fault`; `null`: it is no drive.
    state: Option<&'static str>,
    /// The same in its own words.
    state_text: Option<String>,
    /// Whether it moves; `null`: it does not say.
    moving: Option<bool>,
    pub(super) fault: Option<FaultNow>,
    /// What it warns of.
    pub(super) warning: Option<String>,
    /// What a person sees of it.
    display: Display,
    /// The two or three values worth seeing in a list.
    headline: Vec<ValueState>,
}

/// The complete state of a station.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct State {
    /// When this was so, since its line was started.
    pub(super) time_seconds: f64,
    #[serde(flatten)]
    pub(super) summary: Summary,
    /// Words of bits, those of the master first.
    pub(super) words: Vec<WordState>,
    /// Where it is, what it measures, its slave.
    pub(super) values: Vec<ValueState>,
    /// What is exchanged cyclically.
    pub(super) process: Vec<Process>,
    /// What acts on it from outside.
    inputs: Vec<InputState>,
    keys: Vec<KeyState>,
    /// The faults that can be provoked.
    faults: Vec<Provocation>,
    switches: Option<SwitchesState>,
    /// What it remembers, the newest first.
    pub(super) history: Vec<Past>,
    /// The newest request of the master that it refused, and why.
    pub(super) last_refusal: Option<LastRefusal>,
    why: Reasons,
    /// What the diagnosis of a station from a GSD reports.
    pub(super) diagnosis: Option<Diagnosis>,
    pub(super) counters: Vec<ValueState>,
    /// How safe what its memory holds is.
    eeprom: Option<&'static str>,
    pub(super) has: Has,
    /// What the master in this program does with it; `null`: there is none.
    pub(super) master: Option<MasterState>,
}

/// Which routes a station answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Has {
    pub(super) parameters: bool,
    pub(super) objects: bool,
    pub(super) modules: bool,
    /// Records and alarms: `/records`, `/alarms`, `/status-messages`, `/acyclic`.
    pub(super) records: bool,
    pub(super) samples: bool,
    pub(super) switches: bool,
    pub(super) power: bool,
}

/// What keeps a station from moving.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct Reasons {
    /// Whether it moves; `null`: it does not say.
    moving: Option<bool>,
    /// What keeps it from moving, the most important first.
    reasons: Vec<ReasonText>,
    /// What to send until it moves; `null`: it moves, or nothing that is sent helps before the reasons are removed.
    next: Option<String>,
    /// What keeps masters from its services of DP-V1, or waits for a master: alarms, the last service that was refused. A device
    /// without such services does not have it.
    #[serde(skip_serializing_if = "Option::is_none")]
    services: Option<Vec<ReasonText>>,
}

/// One thing that keeps it from moving, or a condition that is not met.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(super) struct ReasonText {
    /// A name that stays, for programs.
    pub(super) reason: &'static str,
    /// A sentence with numbers.
    pub(super) text: String,
}

impl ReasonText {
    fn of(reason: &Reason<'_>) -> Self {
        Self { reason: reason.name, text: reason.to_string() }
    }
}

impl Reasons {
    /// All about the services in one line, behind what stands before it.
    pub(super) fn say_services(&self, text: &mut String) {
        for service in self.services.iter().flatten() {
            text.push_str("; ");
            text.push_str(&service.text);
        }
    }

    pub(super) fn of(description: &dyn Description) -> Self {
        let services = description.acyclic().map(|acyclic| {
            let mut services = Vec::new();
            acyclic.each_obstacle(&mut |reason| services.push(ReasonText::of(&reason)));
            services
        });
        let Some(why) = description.why() else { return Self { services, ..Self::default() } };
        let (mut reasons, mut next) = (Vec::new(), None);
        why.each_reason(&mut |reason| {
            reasons.push(ReasonText::of(&reason));
        });
        why.next(&mut |words| next = Some(words.to_string()));
        Self { moving: Some(why.is_moving() == Some(true)), reasons, next, services }
    }
}

impl Summary {
    pub(super) fn of(line: &str, lent: &dyn OnLine, address: u8) -> Option<Self> {
        let station = lent.station(address)?;
        let description = station.description;
        let fault = fault(description);
        let (mut state_text, mut warning, mut headline) = (None, None, Vec::new());
        description.say_state(&mut |text| state_text = Some(text.to_string()));
        description.say_warning(&mut |text| warning = Some(text.to_string()));
        description.each_value(&mut |value| {
            if value.headline {
                headline.push(ValueState::of(&value));
            }
        });
        Some(Self {
            line: line.into(),
            bus: lent.kind(),
            address,
            device: station.device,
            product: station.product.into_owned(),
            power: station.power,
            presence: station.presence,
            exchanging: station.exchanging,
            bus_state: station.bus_state,
            owner_address: station.owner,
            state: description.drive_state().map(|state| state.name()),
            state_text,
            moving: description.why().map(|why| why.is_moving() == Some(true)),
            display: Display::of(&description.face(lent.now()), fault.as_ref()),
            fault,
            warning,
            headline,
        })
    }

    /// Whether it exchanges process data.
    pub(super) const fn is_exchanging(&self) -> bool {
        self.exchanging
    }

    /// Whether it is on that line.
    pub(super) fn is_on(&self, line: &str) -> bool {
        self.line == line
    }

    /// Of every station of a line; of two with one address both.
    pub(super) fn all(line: &str, lent: &dyn OnLine) -> Vec<Self> {
        lent.addresses().into_iter().filter_map(|address| Self::of(line, lent, address)).collect()
    }
}

fn fault(description: &dyn Description) -> Option<FaultNow> {
    let mut fault = None;
    description.tell_fault(&mut |code, text| {
        fault = Some(FaultNow { fault: code.to_string(), text: text.to_string() });
    });
    fault
}

impl State {
    /// Without the last refusal, which the station does not remember.
    pub(super) fn of(line: &str, lent: &dyn OnLine, address: u8) -> Option<Self> {
        let summary = Summary::of(line, lent, address)?;
        let description = lent.station(address)?.description;
        let (values, counters) = all_values(description);
        let switches = SwitchesState::of(description);
        let mut parameters = false;
        description.each_parameter(&mut |_| parameters = true);
        let has = Has {
            parameters,
            records: description.acyclic().is_some(),
            samples: values.iter().any(ValueState::has_curve),
            switches: switches.is_some(),
            power: summary.power.is_some(),
            ..Has::default()
        };
        let (mut words, mut history) = (Vec::new(), Vec::new());
        description.each_word(&mut |word| words.push(WordState::of(&word)));
        description.each_past(&mut |past| history.push(Past::of(&past)));
        let mut state = Self {
            time_seconds: seconds(lent.now()),
            summary,
            words,
            values,
            process: process(description, lent.known(address)),
            inputs: InputState::all(description),
            keys: KeyState::all(description),
            faults: Provocation::all(description),
            switches,
            history,
            last_refusal: None,
            why: Reasons::of(description),
            diagnosis: None,
            counters,
            eeprom: description.memory(),
            has,
            master: None,
        };
        lent.complete(address, &mut state);
        Some(state)
    }

    /// Whether nothing has changed but time.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let Self {
            time_seconds: _,
            summary,
            words,
            values,
            process,
            inputs,
            keys,
            faults,
            switches,
            history,
            last_refusal,
            why,
            diagnosis,
            counters: _,
            eeprom,
            has,
            master,
        } = self;
        (summary, words, values, process) == (&other.summary, &other.words, &other.values, &other.process)
            && (inputs, keys, faults) == (&other.inputs, &other.keys, &other.faults)
            && (switches, history, last_refusal) == (&other.switches, &other.history, &other.last_refusal)
            && (why, diagnosis, eeprom, has) == (&other.why, &other.diagnosis, &other.eeprom, &other.has)
            && *master == other.master
    }
}

/// The values of a station, and what it counts.
fn all_values(description: &dyn Description) -> (Vec<ValueState>, Vec<ValueState>) {
    let (mut values, mut counters) = (Vec::new(), Vec::new());
    description.each_value(&mut |value| {
        let of = if value.group == Group::Counter { &mut counters } else { &mut values };
        of.push(ValueState::of(&value));
    });
    (values, counters)
}

/// What is exchanged, with the words that depend on more than the octets.
fn process(description: &dyn Description, known: Option<Known>) -> Vec<Process> {
    let (mut process, mut outputs, mut inputs) = (Vec::new(), Vec::new(), Vec::new());
    description.each_exchange(&mut |exchange| {
        let side = if exchange.from_master { &mut outputs } else { &mut inputs };
        *side = exchange.octets.to_vec();
        process.push(Process::of(&exchange));
    });
    if let Some(known) = known {
        let [outputs, inputs] = known.channel(&outputs, &inputs);
        for side in &mut process {
            side.explain(if side.from_master { &outputs } else { &inputs });
        }
    }
    process
}

/// The time on the clock of a line.
pub(super) fn seconds(now: Instant) -> f64 {
    // Of nanoseconds a reader has nothing, and digits that are none.
    (now.as_nanos() / 1000) as f64 / 1e6
}
