//! How the devices on PROFIBUS are made from their specifications.

use core::fmt;
use std::collections::BTreeSet;
use std::path::Path;

use thiserror::Error;

use super::{Choice, Choices, Group, QuirkRow, Spec, Wrong, acyclic, inputs, named, timed};
use crate::devices::ag03::param::{self, Access, Model, Pnu, Value, Width};
use crate::devices::ag03::profibus::{Config, Device, Gear, QUIRKS};
use crate::devices::ag03::unit::DipSwitches;
use crate::devices::ag03::unit::dip::ResetPatterns;
use crate::devices::named_word::NamedWords;
use crate::devices::ppo_drive::profibus::{CONFIGURATIONS, Family, IDENT_NUMBER, PpoDrive, PpoOnly, Shape};
#[cfg(feature = "parameters")]
use crate::devices::ppo_drive::table::TableError;
use crate::devices::ppo_drive::table::{Row, Table};
use crate::devices::ppo_drive::{Drive, Settings};
use crate::devices::story::SlaveAct;
use crate::gsd::{Level, Module, Policy, Station, did_you_mean};
use crate::host::fault::{Condition, Switch};
use crate::host::{
    GsdStation, HostedPpoDrive, Participant, PpoJudge, Refusals, StateDir, StateDirError, StationRecords,
    Stored, ValueBoard, gsd_of_file,
};
use crate::process::{Elsewhere, Input, Point};
use crate::profibus::dp::{Application as _, Description, Fixed};
use crate::profibus::ppo::PpoType;
use crate::time::{BaudRate, Instant};

/// A device on PROFIBUS.
pub(crate) struct Slave {
    /// Its name on the command line.
    pub(crate) name: &'static str,
    pub(super) group: Group,
    /// What can be chosen about it.
    pub(crate) choices: &'static [Choice],
    /// What `profidrive demo` plays; nothing: it is not offered there.
    pub(crate) story: &'static [SlaveAct],
    /// Its control and status word in names, for `profidrive encode`.
    pub(crate) words: Option<&'static NamedWords>,
    pub(super) quirks: fn() -> Vec<QuirkRow>,
    pub(super) prepare: fn(&Spec) -> Result<Prepared, Wrong>,
}

/// A device whose specification is right.
pub(crate) struct Prepared {
    /// What it is, for the log.
    pub(crate) about: String,
    /// Its file, if it has one.
    pub(crate) station: Option<Station>,
    /// What moves its inputs.
    pub(crate) inputs: Vec<Input>,
    /// Which switches its inputs turn.
    pub(crate) watched: Vec<(Point, Condition, Switch)>,
    make: Box<Make>,
}

type Made = Result<Box<dyn Participant>, MakeError>;
type Make = dyn FnOnce(&Ground<'_>, Parts) -> Made + Send;

/// What a [`Prepared`] device is made of besides what it knows itself.
pub(super) struct Parts {
    station: Option<Station>,
    inputs: Vec<Input>,
    watched: Vec<(Point, Condition, Switch)>,
}

impl fmt::Debug for Prepared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Prepared").field(&self.about).finish()
    }
}

/// The line that a device comes to.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// The time now.
    pub now: Instant,
    /// The rate of the line.
    pub rate: BaudRate,
    /// Where it keeps its memory; `None`: in itself.
    pub state: Option<&'a StateDir>,
    /// Where the words of what it refuses go.
    pub refusals: &'a Refusals,
    /// Where stations follow the outputs of others.
    pub board: &'a ValueBoard,
}

/// Why a device cannot be made.
#[derive(Debug, Error)]
pub(crate) enum MakeError {
    /// Its memory cannot be used.
    #[error(transparent)]
    State(#[from] StateDirError),
    /// The device refuses what it should begin with.
    #[error("{0}")]
    Refused(String),
}

impl Prepared {
    pub(super) fn new(about: String, make: impl FnOnce(&Ground<'_>, Parts) -> Made + Send + 'static) -> Self {
        Self { about, station: None, inputs: Vec::new(), watched: Vec::new(), make: Box::new(make) }
    }

    /// The values of other devices that its inputs follow, with the place of the input in the list.
    pub(crate) fn followed(&self) -> impl Iterator<Item = (usize, &Elsewhere)> {
        let inputs = self.inputs.iter().enumerate();
        inputs.flat_map(|(place, input)| input.elsewhere().map(move |elsewhere| (place, elsewhere)))
    }

    /// The device, switched on.
    ///
    /// # Errors
    /// [`MakeError`].
    pub(crate) fn make(self, ground: &Ground<'_>) -> Made {
        let Self { station, inputs, watched, make, .. } = self;
        let made = make(ground, Parts { station, inputs, watched })?;
        if !made.rates().contains(ground.rate) {
            let (address, rate) = (made.address(), ground.rate);
            tracing::warn!("station {address} hears nothing at {rate}: it does not offer this rate");
        }
        Ok(made)
    }
}

/// The internal gear that was chosen.
pub(super) fn gear(choices: &Choices) -> Gear {
    match choices.word("gear") {
        Some("24") => Gear::Ratio24,
        Some(_) | None => Gear::Ratio48,
    }
}

/// The DIP switches of the factory reset that an AG03 or AG03/1 begins with.
pub(super) fn reset(choices: &Choices, patterns: ResetPatterns) -> Option<DipSwitches> {
    let pattern = match choices.word("reset")? {
        "standard" => patterns.standard,
        "controller" => patterns.controller,
        _ => patterns.all,
    };
    Some(DipSwitches::from_bits(pattern.into()).with_reset(true))
}

/// The gear that a hardware version tells.
pub(super) fn gear_told(version: i64) -> Option<(&'static str, &'static str)> {
    let gear = Gear::of_hardware_version(u16::try_from(version).ok()?)?;
    Some((
        "gear",
        match gear {
            Gear::Ratio24 => "24",
            Gear::Ratio48 => "48",
        },
    ))
}

/// An AG03 or AG03/1.
pub(super) fn ag03(spec: &Spec, model: Model) -> Result<Prepared, Wrong> {
    let mut config = Config { model, gear: gear(&spec.choices), ..Config::new(spec.address()) };
    spec.choices.apply(QUIRKS, &mut config);
    // One that nobody sees takes the values first.
    let mut trial = Device::new(config, Instant::ZERO);
    let mut values = Vec::new();
    for (name, number) in &spec.choices.values {
        let wrong = |words: String| Wrong::within("values", name, words);
        let (pnu, value) = first_value(name, *number, model).map_err(wrong)?;
        let written = trial.write_parameter(Instant::ZERO, pnu, None, value);
        written.map_err(|error| wrong(format!("'{name}': {error}")))?;
        values.push((pnu, value));
    }
    let reset = reset(&spec.choices, config.reset_patterns);
    if reset.is_some() && !values.is_empty() {
        return Err(Wrong::at("values", "a drive with 'reset' has its defaults: leave one of them out"));
    }
    let address = spec.address();
    let about = format!("SIKO {}, gear {}:1, at address {address}", model.product_name(), config.gear);
    Ok(Prepared::new(about, move |ground, _| {
        let mut device: Stored<Device> = match ground.state {
            Some(state) => state.load(config, ground.now)?,
            None => Device::new(config, ground.now).into(),
        };
        for (pnu, value) in values {
            let written = device.unit_mut().write_parameter(ground.now, pnu, None, value);
            written.map_err(|error| MakeError::Refused(format!("drive {address}: PNU {pnu}: {error}")))?;
        }
        if let Some(switches) = reset {
            // The switches are read when it is switched on, and the address of a reset stays that from before.
            device.act(ground.now, |device| {
                device.power_off(ground.now);
                device.set_switches(switches);
                device.power_on(ground.now);
            });
        }
        Ok(Box::new(device))
    }))
}

fn first_value(name: &str, number: f64, model: Model) -> Result<(Pnu, Value), String> {
    let entry = named::parameter(name)?;
    match entry.access() {
        Access::ReadWrite => {}
        Access::ReadOnly | Access::WriteOnly => {
            return Err(format!("{} (PNU {}) is no setting; leave it out", entry.name, entry.pnu));
        }
    }
    if param::entry(model, entry.pnu).is_none() {
        return Err(format!("an {} has no {} (PNU {})", model.product_name(), entry.name, entry.pnu));
    }
    if number.fract() != 0.0 {
        return Err(format!("'{name}': {number} is no whole number"));
    }
    let (least, most) = match entry.width {
        Width::Word => (i16::MIN.into(), u16::MAX.into()),
        Width::Double => (i32::MIN.into(), i32::MAX.into()),
    };
    if !(least..=most).contains(&number) {
        return Err(format!("the value does not fit in {} (PNU {})", entry.name, entry.pnu));
    }
    #[expect(clippy::cast_possible_truncation, reason = "whole and within 32 bits")]
    let number = number as i32;
    Ok((entry.pnu, Value::of(entry.width, number)))
}

/// A station that a GSD describes.
pub(super) fn gsd_station(spec: &Spec) -> Result<Prepared, Wrong> {
    let policy = if spec.choices.flag("strict") { Policy::STRICT } else { Policy::PROPOSED };
    let station = station(spec.choices.file("gsd").unwrap_or(Path::new("")), policy)
        .map_err(|words| Wrong::at("gsd", words))?;
    let station = match spec.choices.names("modules") {
        Some(names) => plugged(station, names)?,
        None if spec.choices.word("unlike").is_some() => {
            return Err(Wrong::at(
                "unlike",
                "unlike needs modules, the names of the modules that are plugged in",
            ));
        }
        None => station,
    };
    let reports = match spec.choices.word("unlike") {
        Some(word) => word == "report",
        None => station.gsd().has_module_status(),
    };
    let station = station.reporting(reports);
    let (given, folder) = &spec.choices.inputs;
    let inputs = inputs::inputs("input", given, folder, &station)?;
    let timed = timed::rows("diagnosis", &spec.choices.diagnoses, &station)?;
    let (address, gsd) = (spec.address(), station.gsd());
    let records = spec.choices.file("records");
    let records = records.map(|file| records_of_file(file).map_err(|words| Wrong::at("records", words)));
    let mut records = records.transpose()?;
    let (own, alarms) = (&spec.choices.records, &spec.choices.alarms);
    let key = [("records", records.is_some()), ("record", !own.is_empty()), ("alarm", !alarms.is_empty())];
    let key = key.iter().find(|(_, given)| *given);
    if let (Some((key, _)), false) = (key, gsd.flags.dpv1 && (gsd.acyclic.c1 || gsd.acyclic.c2)) {
        let words = format!(
            "its GSD has no services of DP-V1 (DPV1_Slave with C1_Read_Write_supp or C2_Read_Write_supp), so nobody can read records; leave {key} out"
        );
        return Err(Wrong::at(key, words));
    }
    if !own.is_empty() {
        acyclic::records("record", own, records.get_or_insert_default())?;
    }
    let alarms = acyclic::alarms("alarm", alarms, gsd)?;
    let about =
        format!("{} {}, ident 0x{:04X}, from its GSD at address {address}", gsd.vendor, gsd.model, gsd.ident);
    let prepared = Prepared::new(about, move |ground, parts| {
        let Some(station) = parts.station else {
            return Err(MakeError::Refused("its file is missing".to_owned()));
        };
        let gsd = station.gsd();
        if let Some(keyword) = &gsd.requires {
            tracing::warn!("station {address}: its GSD has {keyword}, which is not emulated");
        }
        let mut hosted = GsdStation::new(address, ground.rate, station, ground.refusals.clone())
            .on_board(ground.board.clone())
            .with_records(records.unwrap_or_default())
            .with_timed(ground.now, timed)
            .with_timed_alarms(ground.now, alarms);
        for input in parts.inputs {
            hosted.connect_input(input);
        }
        for (point, condition, switch) in parts.watched {
            hosted.watch(point, condition, switch);
        }
        Ok(match ground.state {
            Some(state) => Box::new(hosted.kept_in(state, ground.now)?),
            None => Box::new(hosted),
        })
    });
    Ok(Prepared { station: Some(station), inputs, ..prepared })
}

/// The station with the modules that are named.
fn plugged(station: Station, names: &[String]) -> Result<Station, Wrong> {
    let known = || station.gsd().modules.iter().map(|module| &*module.name);
    let place = |(at, name): (usize, &String)| {
        if name.is_empty() {
            return Ok(None);
        }
        known().position(|known| known == name).map(Some).ok_or_else(|| {
            let cure = match did_you_mean(name, known()) {
                Some(near) => format!("did you mean '{near}'?"),
                None => format!("expected one of '{}'", known().take(12).collect::<Vec<_>>().join("', '")),
            };
            Wrong::within("modules", &at.to_string(), format!("there is no module '{name}'; {cure}"))
        })
    };
    let modules: Vec<Option<usize>> = names.iter().enumerate().map(place).collect::<Result<_, _>>()?;
    station.with_slots(&modules).map_err(|error| Wrong::at("modules", error))
}

/// The station of a file; what is odd about the file is logged.
pub(super) fn station(file: &Path, policy: Policy) -> Result<Station, String> {
    let gsd = gsd_of_file(file)?;
    let name = file.display();
    for hint in gsd.hints.iter().filter(|hint| hint.level == Level::Warning) {
        tracing::warn!("{name}: {hint}");
    }
    Station::new(gsd, policy).map_err(|error| format!("{name}: {error}"))
}

/// A drive of the profile.
pub(super) fn ppo_drive(spec: &Spec) -> Result<Prepared, Wrong> {
    let choices = &spec.choices;
    let only = choices.word("ppo").and_then(ppo);
    let (description, inner, has) = match choices.file("gsd") {
        Some(_) if choices.hexadecimal("ident").is_some() => {
            return Err(Wrong::at("ident", "the ident number is that of the GSD; leave ident out"));
        }
        Some(file) => {
            let station = station(file, Policy::PROPOSED).map_err(|words| Wrong::at("gsd", words))?;
            let has = ppos(&station, file, only)?;
            (station.description(), PpoJudge::Gsd(Box::new(station)), in_words(&has))
        }
        None => {
            let ident = choices.hexadecimal("ident").unwrap_or(IDENT_NUMBER);
            let place_of = |kind: PpoType| CONFIGURATIONS.iter().position(|own| *own == kind.configuration());
            let configurations = match only.and_then(place_of) {
                Some(at) => CONFIGURATIONS.get(at..=at).unwrap_or(CONFIGURATIONS),
                None => CONFIGURATIONS,
            };
            let description = Description { ident, sync_mode: true, freeze_mode: true, ..Description::PLAIN };
            let has = "PPO 1 to 5".to_owned();
            (description, PpoJudge::Profile(Fixed { configurations, ..Fixed::PLAIN }), has)
        }
    };
    let model = match &inner {
        PpoJudge::Gsd(station) => station.gsd().model.as_str(),
        PpoJudge::Profile(_) => "",
    };
    let family = choices.word("family").and_then(Family::named).unwrap_or_else(|| Family::of_model(model));
    let table = table(choices)?;
    if let Some(row) = table.rows().find(|row| row.pnu > family.highest()) {
        let words = format!(
            "PNU {} {}: no job can name it, the highest is {}; family=micromaster has parameters to {}",
            row.pnu,
            row.name,
            family.highest(),
            Family::Micromaster.highest()
        );
        return Err(Wrong::at("parameters", words));
    }
    let address = spec.address();
    let ppo = only.map_or(has, |kind| kind.to_string());
    let of_family = match family {
        Family::Profile => "",
        Family::Micromaster => ", parameters as in MICROMASTER",
        Family::Simodrive611u => ", parameters as in SIMODRIVE 611U",
    };
    let about = format!(
        "drive of PROFIDRIVE version 2, {ppo}, ident 0x{:04X}{of_family}, at address {address}",
        description.ident
    );
    Ok(Prepared::new(about, move |ground, _| {
        let what = (description, PpoOnly { inner, only });
        let drive = PpoDrive::new(address, ground.rate, what, table, ground.now);
        let drive = drive.map_err(|row| MakeError::Refused(default_refused(&row)))?;
        let hosted = HostedPpoDrive::new(drive.of_family(family), ground.refusals.clone());
        Ok(hosted.kept_in(ground.state, ground.now)?)
    }))
}

/// The type of a PPO by its number.
pub(crate) fn ppo(number: &str) -> Option<PpoType> {
    Some(match number {
        "1" => PpoType::Ppo1,
        "2" => PpoType::Ppo2,
        "3" => PpoType::Ppo3,
        "4" => PpoType::Ppo4,
        "5" => PpoType::Ppo5,
        _ => return None,
    })
}

fn in_words(kinds: &BTreeSet<PpoType>) -> String {
    kinds.iter().map(PpoType::to_string).collect::<Vec<_>>().join(", ")
}

/// The PPO of a device file. One that has none is refused, or not the one that is wanted.
fn ppos(station: &Station, file: &Path, only: Option<PpoType>) -> Result<BTreeSet<PpoType>, Wrong> {
    let admitted = admitted(station);
    if admitted.iter().any(|kind| only.is_none_or(|only| only == *kind)) {
        return Ok(admitted);
    }
    let (name, numbers) = (file.display(), "12, 20, 4, 12 or 28 octets each way");
    Err(match only.filter(|_| !admitted.is_empty()) {
        Some(only) => {
            let has = in_words(&admitted);
            Wrong::at(
                "ppo",
                format!("{name} has {has}, not {only}; choose one that it has, or leave ppo out"),
            )
        }
        None => {
            let words =
                format!("{name} has no PPO: none of its configurations has {numbers}; use --station for it");
            Wrong::at("gsd", words)
        }
    })
}

/// Which PPO a master can configure, also one composed of several modules.
fn admitted(station: &Station) -> BTreeSet<PpoType> {
    let gsd = station.gsd();
    if !gsd.is_modular() {
        return Shape::of(station.configuration(None)).ppo().into_iter().collect();
    }
    let shape = |module: &Module| Shape::of(&module.identifiers);
    let modules: BTreeSet<Shape> = gsd.modules.iter().map(shape).collect();
    let presets = gsd.modules.iter().filter(|module| module.preset && gsd.flags.fixed_presets);
    let slots = usize::from(gsd.max_module.unwrap_or(1)).saturating_sub(presets.clone().count());
    let begin = presets.fold(Shape::default(), |whole, module| whole.and(shape(module)));
    let (mut all, mut newest) = (BTreeSet::from([begin]), vec![begin]);
    for _ in 0..slots {
        let longer = newest.iter().flat_map(|before| modules.iter().map(|module| before.and(*module)));
        newest = longer.filter(|whole| whole.fits()).collect();
        newest.retain(|whole| all.insert(*whole));
        if newest.is_empty() {
            break;
        }
    }
    all.into_iter().filter_map(Shape::ppo).collect()
}

/// The parameters of a drive of the profile, with what they begin with.
fn table(choices: &Choices) -> Result<Table, Wrong> {
    let mut table = match choices.file("parameters") {
        Some(file) => table_of_file(file).map_err(|words| Wrong::at("parameters", words))?,
        None => Table::profile(),
    };
    for (name, number) in &choices.values {
        let wrong = |words: String| Wrong::within("values", name, words);
        let (pnu, element) =
            named::find(table.rows(), name).map(|(row, element)| (row.pnu, element)).map_err(wrong)?;
        let begun = table.begin_with(pnu, element, *number);
        begun.map_err(|error| wrong(format!("'{name}': {error}")))?;
        try_out(&table).map_err(wrong)?;
    }
    Ok(table)
}

/// The records of a station from their file.
#[cfg(feature = "parameters")]
pub(crate) fn records_of_file(file: &Path) -> Result<StationRecords, String> {
    let name = file.display();
    let text = std::fs::read_to_string(file).map_err(|error| format!("cannot read {name}: {error}"))?;
    StationRecords::from_toml(&text).map_err(|error| format!("{name}, {error}"))
}

/// Reads nothing: the feature `parameters` is off.
#[cfg(not(feature = "parameters"))]
pub(crate) fn records_of_file(file: &Path) -> Result<StationRecords, String> {
    let name = file.display();
    Err(format!("{name}: this program reads no records; build it with the feature parameters"))
}

/// A table of parameters from its file.
///
/// # Errors
/// What is wrong with it, with its name.
#[cfg(feature = "parameters")]
pub(crate) fn table_of_file(file: &Path) -> Result<Table, String> {
    let table = of_file(file, Table::from_toml, Table::from_csv)?;
    try_out(&table).map_err(|words| format!("{}: {words}", file.display()))?;
    Ok(table)
}

/// What is in a table of parameters, by the ending of its name.
#[cfg(feature = "parameters")]
pub(super) fn of_file<T>(
    file: &Path,
    toml: fn(&str) -> Result<T, TableError>,
    csv: fn(&str) -> Result<T, TableError>,
) -> Result<T, String> {
    let name = file.display();
    let text = std::fs::read_to_string(file).map_err(|error| format!("cannot read {name}: {error}"))?;
    let extension = file.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase);
    let table = match extension.as_deref() {
        Some("toml") => toml(&text),
        Some("csv") => csv(&text),
        Some(_) | None => return Err(format!("{name}: the name of a table ends in .toml or .csv")),
    };
    table.map_err(|error| format!("{name}: {error}"))
}

/// Reads nothing: the feature `parameters` is off.
///
/// # Errors
/// That.
#[cfg(not(feature = "parameters"))]
pub(crate) fn table_of_file(file: &Path) -> Result<Table, String> {
    Err(no_tables(file))
}

/// Why a table is not read.
#[cfg(not(feature = "parameters"))]
pub(super) fn no_tables(file: &Path) -> String {
    let name = file.display();
    format!("{name}: this program reads no tables of parameters; build it with the feature parameters")
}

/// Whether the drive takes what its parameters begin with.
fn try_out(table: &Table) -> Result<(), String> {
    table.set_up(&mut Drive::new(Settings::DEFAULT)).map_err(default_refused)
}

fn default_refused(row: &Row) -> String {
    format!(
        "PNU {} {}: the drive does not take its default; times and loads are 0 or more, the reference speed is above 0",
        row.pnu, row.name
    )
}
