//! A station, its modules, and what moves its inputs.

use core::ops::Range;
use std::path::Path;

use crate::gsd::Station;
use crate::host::list::Group;
use crate::process::{AtEnd, Point, Signal, Source, Table};
use crate::profibus::dp::Application;
use crate::profibus::fdl::Address;

use super::line::{address, time};
use super::tables::{At, Behaviour, InputTable, PointTable, Then};
use super::wrong::Wrong;
use crate::command::emulate::SlavePlan;

/// Where a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Input,
    Output,
}

/// The stations of a line, in the order of their tables.
pub(super) struct Stations<'a>(Vec<(Address, Option<&'a Station>)>);

impl<'a> Stations<'a> {
    pub(super) fn of(plans: &'a [SlavePlan]) -> Self {
        let is_station = |plan: &&SlavePlan| plan.spec.device.group() == Group::Station;
        let stations = plans.iter().filter(is_station);
        Self(stations.map(|plan| (plan.address(), plan.prepared.station.as_ref())).collect())
    }

    pub(super) fn addresses(&self) -> impl Iterator<Item = Address> + '_ {
        self.0.iter().map(|(address, _)| *address)
    }

    pub(super) fn at(&self, address: Address) -> Option<&'a Station> {
        self.0.iter().find(|(known, _)| *known == address)?.1
    }
}

/// What moves the inputs of the station of this number.
pub(super) fn signals(
    inputs: &[At<InputTable>],
    number: usize,
    stations: &Stations<'_>,
    folder: &Path,
) -> Result<Vec<Signal>, Wrong> {
    let mut taken: Vec<(Point, Range<usize>)> = Vec::new();
    for input in inputs {
        let table = input.get();
        let to = point(&table.slot, table.octet.as_ref(), &table.kind)?;
        let own = to.kind.places(to.offset);
        let shares = |(other, places): &&(Point, Range<usize>)| {
            other.slot == to.slot && places.start < own.end && own.start < places.end
        };
        if let Some((other, _)) = taken.iter().find(shares) {
            let words = format!(
                "another input is {} at octet {} of slot {}, the same bits; take one of the two out",
                other.kind, other.offset, other.slot
            );
            return Err(Wrong::at(table.kind.span(), words));
        }
        taken.push((to, own));
    }
    inputs.iter().map(|input| signal(input, number, stations, folder)).collect()
}

/// The address of a station of the line.
pub(super) fn known(number: &At<u8>, stations: impl Iterator<Item = Address>) -> Result<Address, Wrong> {
    let wanted = address(number)?;
    let there: Vec<Address> = stations.collect();
    if there.contains(&wanted) {
        return Ok(wanted);
    }
    let there: Vec<_> = there.iter().map(Address::to_string).collect();
    Err(Wrong::at(
        number.span(),
        format!("there is no station {wanted} on this line; expected one of {}", there.join(", ")),
    ))
}

/// A value in a slot.
pub(super) fn point(slot: &At<u16>, octet: Option<&At<u8>>, kind: &At<String>) -> Result<Point, Wrong> {
    let offset = octet.map_or(0, |octet| usize::from(*octet.get()));
    let kind = kind.get().parse().map_err(|error| Wrong::at(kind.span(), error))?;
    Ok(Point { slot: *slot.get(), offset, kind })
}

/// Whether the station has it. Where the master chooses the modules, it may.
pub(super) fn check(
    station: &Station,
    point: Point,
    direction: Direction,
    slot: &At<u16>,
    kind: &At<String>,
) -> Result<(), Wrong> {
    if !station.is_fixed() {
        return Ok(());
    }
    let layout = station.layout(Application::configuration(station, None), None);
    let Some(placed) = layout.iter().find(|placed| placed.slot.number == point.slot) else {
        let ends = layout.first().zip(layout.last());
        let ends =
            ends.map(|(first, last)| format!("; expected {} to {}", first.slot.number, last.slot.number));
        return Err(Wrong::at(
            slot.span(),
            format!("there is no slot {}{}", point.slot, ends.unwrap_or_default()),
        ));
    };
    let (octets, name) = match direction {
        Direction::Input => (placed.slot.inputs.len(), "input"),
        Direction::Output => (placed.slot.outputs.len(), "output"),
    };
    let mut scratch = vec![0; octets];
    let read = point.kind.write(&mut scratch, point.offset, 0.0);
    let module = placed.name(station.gsd());
    let span = if octets == 0 { slot.span() } else { kind.span() };
    read.map_err(|error| Wrong::at(span, format!("{name} of module '{module}': {error}")))
}

/// What moves an input of the station at `place`.
fn signal(
    input: &At<InputTable>,
    place: usize,
    stations: &Stations<'_>,
    folder: &Path,
) -> Result<Signal, Wrong> {
    let table = input.get();
    let to = point(&table.slot, table.octet.as_ref(), &table.kind)?;
    let own = stations.0.get(place).and_then(|(_, station)| *station);
    if let Some(station) = own {
        check(station, to, Direction::Input, &table.slot, &table.kind)?;
    }
    let behaviour = table.behaviour.as_ref().map_or(Behaviour::Constant, |behaviour| *behaviour.get());
    let span = table.behaviour.as_ref().map_or_else(|| input.span(), At::span);
    let keys = Keys { table, behaviour, span };
    keys.refuse_others()?;
    let output = |of: &PointTable, station: Option<&Station>| {
        let read = point(&of.slot, of.octet.as_ref(), &of.kind)?;
        station.map_or(Ok(()), |station| check(station, read, Direction::Output, &of.slot, &of.kind))?;
        Ok(read)
    };
    let optional = |time_of: &Option<At<String>>| time_of.as_ref().map(time).transpose();
    let source = match behaviour {
        Behaviour::Constant => {
            let value = keys.needed("value", &table.value)?;
            to.kind.write(&mut [0; 4], 0, *value.get()).map_err(|error| Wrong::at(value.span(), error))?;
            Source::Constant(*value.get())
        }
        Behaviour::Mirror => Source::Mirror(output(keys.needed("of", &table.of)?, own)?),
        Behaviour::Count => Source::Count {
            from: *keys.needed("from", &table.from)?.get(),
            to: *keys.needed("to", &table.to)?.get(),
            step: table.step.as_ref().map_or(1.0, |step| *step.get()),
            every: time(keys.needed("every", &table.every)?)?,
        },
        Behaviour::Ramp => Source::Ramp {
            from: *keys.needed("from", &table.from)?.get(),
            to: *keys.needed("to", &table.to)?.get(),
            time: time(keys.needed("time", &table.time)?)?,
            then: match table.then.as_ref().map_or(Then::Hold, |then| *then.get()) {
                Then::Hold => AtEnd::Hold,
                Then::Repeat => AtEnd::Repeat,
                Then::Return => AtEnd::Return,
            },
        },
        Behaviour::Sine => Source::Sine {
            mean: table.mean.as_ref().map_or(0.0, |mean| *mean.get()),
            amplitude: *keys.needed("amplitude", &table.amplitude)?.get(),
            period: time(keys.needed("period", &table.period)?)?,
            phase: optional(&table.phase)?.unwrap_or_default(),
        },
        Behaviour::Table => {
            let file = keys.needed("file", &table.file)?;
            Source::Table { rows: rows(file, folder)?, repeat: optional(&table.repeat)? }
        }
        Behaviour::Follow => {
            let other = keys.needed("station", &table.station)?;
            let station = known(other, stations.addresses())?;
            let of = output(keys.needed("of", &table.of)?, stations.at(station))?;
            Source::Follow { station, of, delay: optional(&table.delay)?.unwrap_or_default() }
        }
    };
    if let Some((low, high)) = source.extremes() {
        let (least, most) = to.kind.range();
        if let Some(got) =
            [low, high].into_iter().find(|value| value.is_finite() && !(least..=most).contains(value))
        {
            let words = format!("it reaches {got}, {} has {least} to {most}", to.kind);
            return Err(Wrong::at(keys.span.clone(), words));
        }
    }
    Signal::new(to, source).map_err(|error| Wrong::at(input.span(), error))
}

fn rows(file: &At<String>, folder: &Path) -> Result<Table, Wrong> {
    let path = folder.join(file.get());
    let wrong = |words: String| Wrong::at(file.span(), words);
    let text = std::fs::read_to_string(&path)
        .map_err(|error| wrong(format!("cannot read {}: {error}", path.display())))?;
    Table::read(&text).map_err(|error| wrong(format!("{}: {error}", path.display())))
}

/// The keys of an input, by its behaviour.
struct Keys<'a> {
    table: &'a InputTable,
    behaviour: Behaviour,
    /// Where the behaviour stands.
    span: Range<usize>,
}

impl Keys<'_> {
    /// The name of the behaviour, and the keys that it has.
    const fn row(&self) -> (&'static str, &'static [&'static str]) {
        match self.behaviour {
            Behaviour::Constant => ("constant", &["value"]),
            Behaviour::Mirror => ("mirror", &["of"]),
            Behaviour::Count => ("count", &["from", "to", "step", "every"]),
            Behaviour::Ramp => ("ramp", &["from", "to", "time", "then"]),
            Behaviour::Sine => ("sine", &["mean", "amplitude", "period", "phase"]),
            Behaviour::Table => ("table", &["file", "repeat"]),
            Behaviour::Follow => ("follow", &["station", "of", "delay"]),
        }
    }

    /// A key that this behaviour cannot do without.
    fn needed<'t, T>(&self, key: &str, value: &'t Option<T>) -> Result<&'t T, Wrong> {
        value
            .as_ref()
            .ok_or_else(|| Wrong::at(self.span.clone(), format!("behaviour {} needs '{key}'", self.row().0)))
    }

    /// Keys of other behaviours are a mistake.
    fn refuse_others(&self) -> Result<(), Wrong> {
        fn span<T>(value: &Option<At<T>>) -> Option<Range<usize>> {
            value.as_ref().map(At::span)
        }
        let table = self.table;
        let given = [
            ("value", span(&table.value)),
            ("from", span(&table.from)),
            ("to", span(&table.to)),
            ("step", span(&table.step)),
            ("every", span(&table.every)),
            ("time", span(&table.time)),
            ("then", span(&table.then)),
            ("mean", span(&table.mean)),
            ("amplitude", span(&table.amplitude)),
            ("period", span(&table.period)),
            ("phase", span(&table.phase)),
            ("file", span(&table.file)),
            ("repeat", span(&table.repeat)),
            ("of", table.of.as_ref().map(|of| of.slot.span())),
            ("station", span(&table.station)),
            ("delay", span(&table.delay)),
        ];
        let (name, keys) = self.row();
        for (key, span) in given {
            if let Some(span) = span.filter(|_| !keys.contains(&key)) {
                let words = format!("behaviour {name} has no '{key}'; expected {}", keys.join(", "));
                return Err(Wrong::at(span, words));
            }
        }
        Ok(())
    }
}
