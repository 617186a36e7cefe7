//! A `[[line]]` of a line file as the arguments of `emulate`: its link, who is on it, faults.

use core::fmt::Display;
use core::ops::Range;
use core::str::FromStr;
use core::time::Duration;
use std::path::{Path, PathBuf};

use crate::host::can;
use crate::host::fault::{BusKind, Condition, Rule, While, duration, no_time};
use crate::host::list::Group;
use crate::host::reach::open_to_others;
use crate::profibus::fdl::Address;

use super::device;
use super::station::{self, Stations, point};
use super::tables::{At, Baud, FaultTable, LineTable, WhileTable};
use super::wrong::Wrong;
use crate::command::args::{Emulate, LinkSpec, SLOT_TIMES, panel_place};
use crate::command::emulate::{LinePlan, SlavePlan};

/// Reads a line. `folder` is where the file is: paths in it begin there.
pub(super) fn plan(number: usize, line: &At<LineTable>, folder: &Path) -> Result<LinePlan, Wrong> {
    let table = &line.get().keys;
    let mut args = Emulate::on(match parsed::<LinkSpec>(&table.link)? {
        LinkSpec::Pty(Some(path)) => LinkSpec::Pty(Some(folder.join(path))),
        LinkSpec::Can(can::LinkSpec::Pty(Some(path))) => {
            LinkSpec::Can(can::LinkSpec::Pty(Some(folder.join(path))))
        }
        LinkSpec::Can(can::LinkSpec::Terminal(path)) => {
            LinkSpec::Can(can::LinkSpec::Terminal(folder.join(path)))
        }
        link @ (LinkSpec::Pty(None) | LinkSpec::Serial(_) | LinkSpec::Tcp(_) | LinkSpec::Can(_)) => link,
    });
    if let Some(baud) = &table.baud {
        let text = match baud.get() {
            Baud::Rate(rate) => rate.to_string(),
            Baud::Word(word) => word.clone(),
        };
        args.baud = Some(text.parse().map_err(|error| Wrong::at(baud.span(), error))?);
    }
    if let Some(bits) = &table.slot_time {
        if !SLOT_TIMES.contains(bits.get()) {
            let (got, least, most) = (bits.get(), SLOT_TIMES.start(), SLOT_TIMES.end());
            return Err(Wrong::at(bits.span(), format!("slot-time {got} is outside {least} to {most}")));
        }
        args.slot_time = Some(*bits.get());
    }
    let is = |flag: &Option<At<bool>>| flag.as_ref().is_some_and(|flag| *flag.get());
    args.force_address = is(&table.force_address);
    args.allow_remote = is(&table.allow_remote);
    args.panel_allow_remote = is(&table.panel_allow_remote);
    args.bench = is(&table.bench);
    if let Some(bench) = table.bench.as_ref().filter(|bench| *bench.get() && table.panel.is_none()) {
        return Err(Wrong::at(bench.span(), "bench is used from the panel; add panel = \"127.0.0.1:8080\""));
    }
    if let Some(panel) = &table.panel {
        let place = panel_place(panel.get()).map_err(|error| Wrong::at(panel.span(), error))?;
        reaches(&place, args.panel_allow_remote, panel.span(), "the panel", "panel-allow-remote")?;
        args.panel = Some(place);
    }
    if let LinkSpec::Tcp(place) | LinkSpec::Can(can::LinkSpec::Tcp(place)) = &args.link {
        reaches(place, args.allow_remote, table.link.span(), "the link", "allow-remote")?;
    }
    let path =
        |path: &Option<At<String>>| -> Option<PathBuf> { path.as_ref().map(|path| folder.join(path.get())) };
    (args.state_dir, args.capture) = (path(&table.state_dir), path(&table.capture));
    args.panel_files = path(&table.panel_files);
    let is_can = matches!(args.link, LinkSpec::Can(_));
    args.quirks = table.quirks.iter().map(|(name, value)| format!("{name}={}", value.get())).collect();
    let slaves = device::slaves((number, folder), line.get(), &args)?;
    // Those with files are in the plan only; here they are what stands for all of the line.
    args.devices.slaves = slaves.iter().map(|slave| slave.spec.clone()).collect();
    args.devices.nodes = device::nodes((number, folder), line.get())?;
    for (name, value) in &table.quirks {
        let known = args.check_quirk(&format!("{name}={}", value.get()));
        known.map_err(|words| Wrong::at(value.span(), words))?;
    }
    let addresses: Vec<Address> = slaves.iter().map(SlavePlan::address).collect();
    let stations = Stations::of(&slaves);
    let (bus, there): (_, Vec<u8>) = if is_can {
        (BusKind::Can, args.nodes().iter().map(|node| node.node().number()).collect())
    } else {
        (BusKind::Profibus, addresses.iter().map(|address| address.number()).collect())
    };
    let faults =
        table.fault.iter().map(|table| fault(table, bus, &there, &stations)).collect::<Result<_, _>>()?;
    if addresses.is_empty() && args.nodes().is_empty() {
        let tables = Group::ALL.map(|group| format!("[[line.{}]]", group.name()));
        let words = format!("the line has no station; expected one of {}", tables.join(", "));
        return Err(Wrong::at(line.span(), words));
    }
    if let Some(place) = slave_tables(line.get()).next().filter(|_| is_can) {
        let words = "drives and stations are on PROFIBUS and an slcan link is a CAN bus; give them a line of their own";
        return Err(Wrong::at(place, words));
    }
    args.check().map_err(|words| contradiction(line, &words))?;
    Ok(LinePlan { args, slaves, faults })
}

/// Refuses a place to which other machines could connect unless the file allows it.
pub(super) fn reaches(
    place: &str,
    allowed: bool,
    span: Range<usize>,
    what: &str,
    key: &str,
) -> Result<(), Wrong> {
    match open_to_others(place).filter(|_| !allowed) {
        None => Ok(()),
        Some(address) => Err(Wrong::at(
            span,
            format!(
                "other machines could connect to {what} at {address}; use 127.0.0.1, or add {key} = true"
            ),
        )),
    }
}

/// What no single key shows, where the key that it begins with stands. Keys are called as options are.
fn contradiction(line: &At<LineTable>, words: &str) -> Wrong {
    let table = &line.get().keys;
    let spans = [
        ("--slot-time", table.slot_time.as_ref().map(At::span)),
        ("--allow-remote", table.allow_remote.as_ref().map(At::span)),
        ("--force-address", table.force_address.as_ref().map(At::span)),
        ("--fault", table.fault.first().map(|fault| fault.fault.span())),
        ("--quirk", table.quirks.values().next().map(At::span)),
        ("--baud", table.baud.as_ref().map(At::span)),
    ];
    let span = spans.into_iter().find_map(|(option, span)| span.filter(|_| words.contains(option)));
    Wrong::at(span.unwrap_or_else(|| line.span()), words.replace("--", ""))
}

fn parsed<T: FromStr<Err: Display>>(text: &At<String>) -> Result<T, Wrong> {
    text.get().parse().map_err(|error| Wrong::at(text.span(), error))
}

/// An address of a station.
pub(super) fn address(number: &At<u8>) -> Result<Address, Wrong> {
    Address::station(*number.get())
        .map_err(|_| Wrong::at(number.span(), format!("address {} is outside 0 to 126", number.get())))
}

/// A time such as `20ms`.
pub(super) fn time(text: &At<String>) -> Result<Duration, Wrong> {
    duration(text.get()).ok_or_else(|| Wrong::at(text.span(), no_time(text.get())))
}

/// Where the tables of devices on PROFIBUS are.
fn slave_tables(table: &LineTable) -> impl Iterator<Item = Range<usize>> {
    let groups = Group::ALL.into_iter().filter(|group| !group.is_on_can());
    groups.flat_map(|group| table.of(group)).map(At::span)
}

/// A fault. `there` are the stations or nodes of the line.
fn fault(table: &FaultTable, bus: BusKind, there: &[u8], stations: &Stations<'_>) -> Result<Rule, Wrong> {
    let text = &table.fault;
    let mut rule = Rule::on(bus, text.get()).map_err(|error| Wrong::at(text.span(), error))?;
    rule.check(there.iter().copied()).map_err(|error| Wrong::at(text.span(), error))?;
    if let Some(from) = &table.from {
        rule.when.from = time(from)?;
    }
    if let Some(until) = &table.until {
        rule.when.until = Some(time(until)?);
        rule = rule.timed().map_err(|error| Wrong::at(until.span(), error))?;
    }
    if let Some(condition) = &table.while_input {
        if bus == BusKind::Can {
            return Err(Wrong::at(condition.span(), "a CAN bus has no inputs of stations; leave while out"));
        }
        rule.while_input = Some(while_input(condition, stations)?);
    }
    Ok(rule)
}

fn while_input(table: &At<WhileTable>, stations: &Stations<'_>) -> Result<While, Wrong> {
    let WhileTable { station, slot, octet, kind, is, above, below } = table.get();
    let address = station::known(station, stations.addresses())?;
    let point = point(slot, octet.as_ref(), kind)?;
    if let Some(station) = stations.at(address) {
        station::check(station, point, slot, kind)?;
    }
    let condition = match (is, above, below) {
        (Some(value), None, None) => Condition::Is(*value.get()),
        (None, Some(limit), None) => Condition::Above(*limit.get()),
        (None, None, Some(limit)) => Condition::Below(*limit.get()),
        _ => return Err(Wrong::at(table.span(), "expected one of is, above, below")),
    };
    Ok(While { station: address, point, condition })
}
