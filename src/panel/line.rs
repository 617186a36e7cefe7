//! The lines of a process, and what the thread of each lends to the threads of HTTP.
//!
//! | file | holds |
//! | --- | --- |
//! | `profibus` | what the thread of a bus of PROFIBUS lends |
//! | `can` | what the thread of a bus of CAN lends |
//! | `state` | a line as JSON |
//! | `faults` | the faults on purpose of a line |

pub(super) mod can;
pub(super) mod faults;
pub(super) mod profibus;
pub(super) mod state;

use core::any::Any;
use core::error::Error;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Component, Path};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::time::Instant as Moment;

use super::problem::Problem;
use super::queue::{self, Lends};
use super::station::State;
use super::stream::{Hub, Readers};
use crate::devices::{CanopenDevice, Vocabulary};
use crate::explain::Known;
use crate::face::description::Supply;
use crate::face::surroundings::Surroundings;
use crate::face::{Description, Operation};
use crate::host::fault::{BusKind, Listed, Rule};
use crate::host::inner_master::InnerMaster;
use crate::host::list::Spec;
use crate::host::{Bus, Presence, Startup};
use crate::time::{BaudRate, Instant};

/// The highest address on any bus.
const HIGHEST: u8 = 127;

/// The thread of a line of either bus.
#[derive(Clone, Copy, Debug)]
pub(super) struct OfLine;

impl Lends for OfLine {
    type Access<'a> = dyn OnLine + 'a;
}

/// The way to the thread of a line.
pub(super) type Asking = queue::Asking<OfLine>;

/// A station as its bus knows it.
pub(super) struct Station<'a> {
    pub(super) description: &'a dyn Description,
    /// Its name in the list of devices.
    pub(super) device: &'static str,
    pub(super) product: Cow<'a, str>,
    pub(super) power: Option<Supply>,
    pub(super) presence: Option<Presence>,
    pub(super) exchanging: bool,
    /// What its bus calls its state.
    pub(super) bus_state: Option<String>,
    pub(super) owner: Option<u8>,
}

/// What needs no more than to be listed.
struct Silent;

impl Surroundings for Silent {}
impl Description for Silent {}

/// When something is done, and to which device.
#[derive(Clone, Copy, Debug)]
pub(super) struct Acted<'a> {
    pub(super) now: Instant,
    /// As on the command line.
    pub(super) device: &'a str,
}

/// What is done to a station: first perhaps to a copy of it.
pub(super) type Act<'a> = dyn Fn(&mut dyn Description, &Acted<'_>) -> Result<(), Problem> + 'a;

/// What the thread of a line lends between two telegrams.
pub(super) trait OnLine {
    /// The time now.
    fn now(&self) -> Instant;

    /// Which bus.
    fn kind(&self) -> BusKind;

    /// The addresses of all stations, in the order in which they came; of two with one address both.
    fn addresses(&self) -> Vec<u8>;

    /// The station at this address; of two the first.
    fn station(&self, address: u8) -> Option<Station<'_>>;

    /// What the station at this address tells of itself; of two the first.
    fn described(&self, address: u8) -> Option<&dyn Description>;

    /// What only the bus knows of a station.
    fn complete(&self, address: u8, state: &mut State);

    /// Does something to a station.
    ///
    /// # Errors
    /// What `act` says; 409 if it would take the address of another station. Nothing is changed then.
    fn act(&mut self, address: u8, act: &Act<'_>) -> Result<(), Problem>;

    /// Switches the supply of a station on or off.
    ///
    /// # Errors
    /// As [`Self::act`].
    fn switch(&mut self, address: u8, on: bool) -> Result<Supply, Problem>;

    /// Puts a station on the line and says where.
    ///
    /// # Errors
    /// 409 if its address is taken or its memory cannot be used; 422 if it is of another bus.
    fn add(&mut self, spec: Spec) -> Result<u8, Problem>;

    /// Takes a station from the line.
    fn remove(&mut self, address: u8) -> Option<Box<dyn Any + Send>>;

    /// The line as JSON.
    fn state(&self) -> state::Counted;

    /// The rate of a line of PROFIBUS.
    fn baud(&self) -> Option<BaudRate>;

    /// Every fault on purpose with its number and how often it was injected.
    ///
    /// # Errors
    /// 409: the line cannot have faults.
    fn faults(&self) -> Result<Vec<Listed>, Problem>;

    /// Whether those are there that a fault is for.
    ///
    /// # Errors
    /// 422: they are not.
    fn check_fault(&self, rule: &Rule) -> Result<(), Problem>;

    /// Adds one and returns its number.
    ///
    /// # Errors
    /// 409: the line cannot have faults, or not one more.
    fn add_fault(&mut self, rule: Rule) -> Result<u32, Problem>;

    /// Ends one.
    fn remove_fault(&mut self, number: u32) -> Option<Rule>;

    /// The node with that number; `None`: this is no bus of CAN, or there is none.
    fn node(&self, _address: u8) -> Option<&dyn CanopenDevice> {
        None
    }

    /// Does something to the node with that number, if there is one.
    fn with_node(&mut self, _address: u8, _act: &mut dyn FnMut(&mut dyn CanopenDevice, Instant)) {}

    /// The bus, if it is one of PROFIBUS.
    fn profibus(&mut self) -> Option<&mut Bus> {
        None
    }

    /// What the words of a station depend on.
    fn known(&self, _address: u8) -> Option<Known> {
        None
    }

    /// By which words a master operates a station, and how it takes a slave over; `None`: there is no such station.
    fn operation(&self, address: u8) -> Option<(Operation, Option<Startup>)>;

    /// In which words the frames of a node are to be read.
    fn words(&self, _address: u8) -> Option<&'static Vocabulary> {
        None
    }
}

impl dyn OnLine + '_ {
    /// The station at this address.
    ///
    /// # Errors
    /// 404 if there is none, with those that there are.
    pub(super) fn find(&self, address: u8) -> Result<Station<'_>, Problem> {
        self.station(address).ok_or_else(|| no_station(address, &self.addresses()))
    }

    /// The same, if it has something.
    ///
    /// # Errors
    /// As `find`; 409 if it has not.
    pub(super) fn having<T>(&self, address: u8, what: &str, has: Option<T>) -> Result<T, Problem> {
        self.find(address)?;
        has.ok_or_else(|| lacks(address, what))
    }
}

/// A station has nothing of the kind.
pub(super) fn lacks(address: u8, what: &str) -> Problem {
    Problem::conflict(format!("the station at address {address} has no {what}"))
}

/// The refusal that says where stations are.
pub(super) fn no_station(address: u8, there: &[u8]) -> Problem {
    let there = there.iter().map(ToString::to_string).reduce(|all, one| format!("{all}, {one}"));
    Problem::not_found(match there {
        Some(there) => format!("there is no station at address {address}; there are stations at {there}"),
        None => format!("there is no station at address {address}, nor at any other; add one first"),
    })
}

/// The address in a path.
pub(super) fn address(text: &str) -> Result<u8, Problem> {
    let is_number = text.bytes().all(|octet| octet.is_ascii_digit());
    let number = text.parse().ok().filter(|number| is_number && *number <= HIGHEST);
    number.ok_or_else(|| {
        let detail = format!("'{text}' is no address; expected 0 to {HIGHEST}");
        Problem::new(axum::http::StatusCode::BAD_REQUEST, detail)
    })
}

/// An error and its causes.
pub(super) fn in_one_line(error: &dyn Error) -> String {
    let mut line = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        line = format!("{line}: {error}");
        cause = error.source();
    }
    line
}

/// A line that HTTP can reach.
#[derive(Clone)]
pub(super) struct Line {
    pub(super) name: Arc<str>,
    pub(super) kind: BusKind,
    /// What a master opens.
    pub(super) link: Arc<str>,
    /// The folder of the files that may be named over HTTP.
    files: Option<Arc<Path>>,
    pub(super) asking: Asking,
    pub(super) hub: Hub,
    /// The master in this program, if there is one.
    pub(super) master: Option<InnerMaster>,
    leases: Arc<Mutex<BTreeMap<(u8, String), Moment>>>,
}

impl Line {
    /// The folder in which a file that is named over HTTP lies.
    ///
    /// # Errors
    /// 422 if there is none, or if the name leads out of it.
    pub(super) fn folder(&self, key: &str, name: &str) -> Result<Arc<Path>, Problem> {
        let inside = Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
        match &self.files {
            Some(folder) if inside && !name.is_empty() => Ok(Arc::clone(folder)),
            Some(_) => {
                Err(Problem::value(format!("{key}: '{name}' leads out of the folder of --panel-files")))
            }
            None => Err(Problem::value(format!(
                "{key}: no file is read for who comes by HTTP; use a line file, or name the folder of such files with \
                 --panel-files"
            ))),
        }
    }

    /// Until when keys are held that nobody renews, by station and key.
    pub(super) fn leases(&self) -> MutexGuard<'_, BTreeMap<(u8, String), Moment>> {
        self.leases.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Every line of the process that has a panel, and who reads their streams. A clone is the same.
#[derive(Clone, Default)]
pub struct Lines {
    lines: Arc<Mutex<Vec<Line>>>,
    readers: Arc<Readers>,
}

impl core::fmt::Debug for Lines {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let names: Vec<Arc<str>> = self.all().into_iter().map(|line| line.name).collect();
        f.debug_tuple("Lines").field(&names).finish()
    }
}

impl Lines {
    fn locked(&self) -> MutexGuard<'_, Vec<Line>> {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) const fn readers(&self) -> &Arc<Readers> {
        &self.readers
    }

    /// Adds a line of this name on this bus. Lines open in any order and are told in that of their names; `line-2` comes
    /// before `line-10`.
    pub(super) fn add(&self, (name, kind): (Arc<str>, BusKind), asking: Asking, hub: Hub) {
        let mut lines = self.locked();
        let place = lines.partition_point(|line| (line.name.len(), &line.name) < (name.len(), &name));
        lines.insert(
            place,
            Line {
                name,
                kind,
                link: "".into(),
                files: None,
                asking,
                hub,
                master: None,
                leases: Arc::default(),
            },
        );
    }

    pub(super) fn set_link(&self, name: &str, link: &str) {
        if let Some(line) = self.locked().iter_mut().find(|line| &*line.name == name) {
            line.link = link.into();
        }
    }

    pub(super) fn set_files(&self, name: &str, folder: &Path) {
        if let Some(line) = self.locked().iter_mut().find(|line| &*line.name == name) {
            line.files = Some(folder.into());
        }
    }

    #[cfg(feature = "emulator")]
    pub(super) fn set_master(&self, name: &str, master: InnerMaster) {
        if let Some(line) = self.locked().iter_mut().find(|line| &*line.name == name) {
            line.master = Some(master);
        }
    }

    pub(super) fn remove(&self, name: &str) {
        self.locked().retain(|line| &*line.name != name);
    }

    pub(super) fn all(&self) -> Vec<Line> {
        self.locked().clone()
    }

    /// The line of that name.
    ///
    /// # Errors
    /// 404 if there is none, with those that there are.
    pub(super) fn named(&self, name: &str) -> Result<Line, Problem> {
        let lines = self.locked();
        lines.iter().find(|line| &*line.name == name).cloned().ok_or_else(|| {
            let names: Vec<&str> = lines.iter().map(|line| &*line.name).collect();
            Problem::not_found(format!("there is no line '{name}'; there is {}", names.join(", ")))
        })
    }

    /// Whether there can be a station at this address.
    ///
    /// # Errors
    /// 422 if no line has such an address.
    pub(super) fn check(&self, address: u8) -> Result<(), Problem> {
        let is_possible = |line: &Line| match line.kind {
            BusKind::Profibus => address < HIGHEST,
            BusKind::Can => address > 0 && address <= HIGHEST,
        };
        match self.locked().iter().any(is_possible) {
            true => Ok(()),
            false => Err(Problem::value(format!("no station can have address {address} here"))),
        }
    }

    /// The one line that has a station at this address; the first where none has.
    ///
    /// # Errors
    /// 409 if several have one.
    pub(super) async fn with(&self, address: u8) -> Result<Line, Problem> {
        let lines = self.all();
        let mut found: Option<Line> = None;
        if lines.len() > 1 {
            for line in &lines {
                let there = line.asking.ask(move |line| line.station(address).is_some()).await?;
                match &found {
                    Some(first) if there => {
                        return Err(Problem::conflict(format!(
                            "the lines {} and {} have a station at address {address}; ask \
                             /api/v1/lines/{}/stations/{address}",
                            first.name, line.name, first.name
                        )));
                    }
                    None if there => found = Some(line.clone()),
                    Some(_) | None => {}
                }
            }
        }
        let found = found.or_else(|| lines.into_iter().next());
        found.ok_or_else(|| Problem::not_found("there is no line"))
    }
}
