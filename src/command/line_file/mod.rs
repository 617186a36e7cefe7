//! `emulate --line FILE`: whole lines from one file.
//!
//! | file | holds |
//! | --- | --- |
//! | `tables.rs`, `schema.rs` | the tables and keys as they are written; the JSON Schema of them |
//! | `line.rs` | a line: its link, who is on it, faults |
//! | `device.rs` | the devices by their specifications |
//! | `station.rs` | values of stations that other tables name |
//! | `wrong.rs` | what is wrong, with line and column |
//!
//! Everything is read and checked before anything is opened.

mod device;
mod line;
#[cfg(test)]
mod schema;
mod station;
mod tables;
mod wrong;

use std::io::{self, Write};
use std::path::Path;

use crate::host::list::Group;

use self::tables::{At, LineFile, LineTable};
use self::wrong::Wrong;
use super::Failure;
use super::args::{MetricsSpec, metrics_place};
use super::emulate::{LinePlan, LinesPlan, SlavePlan};

/// What is in a file.
pub(crate) fn read(file: &Path) -> Result<LinesPlan, Failure> {
    let name = file.display();
    let text = std::fs::read_to_string(file)
        .map_err(|error| Failure::Usage(format!("cannot read {name}: {error}")))?;
    let folder = file.parent().unwrap_or(Path::new(""));
    plan(&text, folder).map_err(|wrong| wrong.in_file(&name, &text))
}

fn plan(text: &str, folder: &Path) -> Result<LinesPlan, Wrong> {
    let file: LineFile = toml::from_str(text).map_err(|error| Wrong::of_toml(&error, text))?;
    if file.line.is_empty() {
        return Err(Wrong::at(0..0, "there is no line; expected a table [[line]]"));
    }
    alone(&file.line)?;
    let lines = file.line.iter().enumerate();
    let lines: Vec<_> =
        lines.map(|(number, line)| line::plan(number, line, folder)).collect::<Result<_, _>>()?;
    device::check_followed(&lines)?;
    Ok(LinesPlan { lines, metrics: metrics(&file)? })
}

/// Where the metrics are.
fn metrics(file: &LineFile) -> Result<Option<MetricsSpec>, Wrong> {
    let allow_remote = file.metrics_allow_remote.as_ref();
    match (&file.metrics, allow_remote) {
        (Some(place), _) => {
            let allow_remote = allow_remote.is_some_and(|allowed| *allowed.get());
            let checked = metrics_place(place.get()).map_err(|error| Wrong::at(place.span(), error))?;
            line::reaches(&checked, allow_remote, place.span(), "the metrics", "metrics-allow-remote")?;
            Ok(Some(MetricsSpec { place: checked, allow_remote }))
        }
        (None, Some(allowed)) => Err(Wrong::at(
            allowed.span(),
            "metrics-allow-remote needs metrics, as in metrics = \"0.0.0.0:9187\"",
        )),
        (None, None) => Ok(None),
    }
}

/// What two lines cannot share.
fn alone(lines: &[At<LineTable>]) -> Result<(), Wrong> {
    let mut taken: Vec<(&str, &str)> = Vec::new();
    for line in lines {
        let line = &line.get().keys;
        let link = Some(&line.link).filter(|link| link.get().contains(':'));
        for (key, value) in [
            ("link", link),
            ("panel", line.panel.as_ref()),
            ("state-dir", line.state_dir.as_ref()),
            ("capture", line.capture.as_ref()),
        ] {
            let Some(value) = value.filter(|value| !value.get().ends_with(":0")) else { continue };
            if taken.contains(&(key, value.get())) {
                let words = format!("two lines have {key} '{}'; give each its own", value.get());
                return Err(Wrong::at(value.span(), words));
            }
            taken.push((key, value.get()));
        }
    }
    Ok(())
}

/// Says what is in the lines of `source`.
pub(crate) fn say(source: &str, plans: &[LinePlan]) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let said = plans.iter().zip(1..).try_for_each(|(plan, number)| {
        let LinePlan { args, slaves, faults } = plan;
        let inputs: usize = slaves.iter().map(|slave| slave.prepared.inputs.len()).sum();
        let (faults, nodes) = (faults.len() + args.faults.len(), args.nodes().len());
        let is_station = |slave: &&SlavePlan| slave.spec.device.group() == Group::Station;
        let stations = slaves.iter().filter(is_station).count();
        let drives = slaves.len() - stations;
        writeln!(
            out,
            "{source} line {number}: {drives} drives, {stations} stations with {inputs} moving inputs, {nodes} nodes, {faults} \
             faults"
        )
    });
    said.map_err(|error| Failure::from_error(&error))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beside the GSDs of the tests.
    fn refused(text: &str) -> String {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gsd");
        let Err(wrong) = plan(text, &folder) else { panic!("accepted: {text}") };
        wrong.in_file(&"line.toml", text).into_line()
    }

    const STATION: &str = "[[line]]\nlink = 'pty'\n[[line.station]]\naddress = 7\ngsd = 'remote_io.gsd'\nmodules = ['8 DI', '2 AO']\n";

    #[test]
    fn an_input_follows_values_of_other_lines_and_of_drives_and_nodes() {
        let input = |keys: &str| format!("[[line.station.input]]\nslot = 1\n{keys}");
        let text = [
            STATION,
            &input("type = 'bit0'\nbehaviour = 'follow'\nline = 2\nstation = 7\nof = '2/0/unsigned16'\n"),
            &input("type = 'bit1'\nbehaviour = 'compare'\nabove = 5\nof = '2/5/position'\n"),
            &input("type = 'bit2'\nbehaviour = 'not'\nof = { line = 3, station = 9, value = 'position' }\n"),
            &STATION.replace("'pty'", "'tcp:127.0.0.1:0'"),
            "[[line.drive]]\naddress = 5\n[[line]]\nlink = 'slcan-pty:x'\n[[line.node]]\nid = 9\n",
        ]
        .concat();
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gsd");
        let lines = plan(&text, &folder).unwrap().lines;
        assert_eq!(lines[0].slaves[0].prepared.inputs.len(), 3);
    }

    #[test]
    fn a_station_may_have_empty_slots_and_a_time_line_of_its_diagnosis() {
        let text = format!(
            "{}unlike = 'report'\n[[line.station.diagnosis]]\nfrom = '5s'\nuntil = '9s'\nbits = [0]\nmissing = [3]\n\
             areas = [{{ first-bit = 4, value = 2 }}]\noctets = [193]\nnot-valid = true\n\
             channels = [{{ slot = 1, channel = 3, error = 16, direction = 'input', width = 'bit' }}]\n",
            STATION.replace("'8 DI', ", "'8 DI', '', ")
        );
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gsd");
        let lines = plan(&text, &folder).unwrap().lines;
        let station = lines[0].slaves[0].prepared.station.as_ref().unwrap();
        let layout = station.layout(&[0x10, 0x00, 0x61], None);
        let names: Vec<_> = layout.iter().map(|placed| placed.name(station.gsd())).collect();
        assert_eq!(names, ["8 DI", "empty slot", "2 AO"]);
    }

    /// Text, line and column, words of what is said.
    pub(super) fn wrong_files() -> Vec<(String, &'static str, &'static str)> {
        let line = |rest: &str| format!("[[line]]\nlink = 'pty'\n{rest}");
        let station = |rest: &str| format!("{STATION}{rest}");
        let node = |rest: &str| format!("[[line]]\nlink = 'slcan-pty:x'\n[[line.node]]\nid = 5\n{rest}");
        let input = |rest: &str| station(&format!("[[line.station.input]]\nslot = 1\ntype = 'bit0'\n{rest}"));
        vec![
            (String::new(), "1, column 1", "missing field `line`"),
            (format!("metrics = '9187'\n{STATION}"), "1, column 11", "for example 127.0.0.1:9187"),
            (format!("metrics-allow-remote = true\n{STATION}"), "1, column 24", "needs metrics"),
            (line("buad = 500000"), "3, column 1", "did you mean `baud`?"),
            (line("baud = 500001\n[[line.drive]]\naddress = 5"), "3, column 8", "12000000"),
            (line("baud = ["), "3, column", ""),
            (line("slot-time = 'x'"), "3, column 13", "expected a whole number, got the text \"x\""),
            (
                line("slot-time = 40\n[[line.drive]]\naddress = 5"),
                "3, column 13",
                "slot-time needs a serial link",
            ),
            (line("quirks = { off2 = 'brake' }"), "3, column 19", "quirk 'off2' is unknown"),
            (line("[[line.drive]]\naddress = 127"), "4, column 11", "address 127 is outside 0 to 126"),
            (line("[[line.drive]]\naddress = 5\ngear = 36"), "5, column 8", "gear '36' is unknown"),
            (
                line("[[line.drive]]\naddress = 5\n[[line.drive]]\naddress = 5"),
                "6, column 11",
                "two stations have address 5",
            ),
            (
                line("[[line.drive]]\naddress = 5\nquirks = { off2 = 'x' }"),
                "5, column 19",
                "quirk 'off2' is unknown",
            ),
            (
                line("[[line.drive]]\naddress = 5\nvalues = { v-Poss = 5 }"),
                "5, column 21",
                "close to it are 1004 v-Pos",
            ),
            (
                line("[[line.drive]]\naddress = 5\nvalues = { v-Pos = 5000 }"),
                "5, column 20",
                "'v-Pos': the value must be within",
            ),
            (
                line("[[line.drive]]\naddress = 5\nvalues = { 1027 = 5 }"),
                "5, column 19",
                "is no setting; leave it out",
            ),
            (
                line("[[line.drive]]\naddress = 5\nmodel = 'ag03'\nvalues = { d-Pos = 5 }"),
                "6, column 20",
                "an AG03 has no d-Pos",
            ),
            (line("[[line.ppo-drive]]\naddress = 5\nppo = 6"), "5, column 7", "expected 1, 2, 3, 4 or 5"),
            (line("[[line.ppo-drive]]\naddress = 5\nident = 'x'"), "5, column 9", "'x' is no ident number"),
            (
                line("[[line.ppo-drive]]\naddress = 5\nident = '5044'\ngsd = 'compact.gsd'"),
                "5, column 9",
                "leave ident out",
            ),
            (line("[[line.ppo-drive]]\naddress = 5\ngsd = 'no.gsd'"), "5, column 7", "cannot read"),
            (
                line("[[line.ppo-drive]]\naddress = 5\ngsd = 'unit_diag.gsd'"),
                "5, column 7",
                "has no PPO: none of its configurations",
            ),
            (
                line("[[line.ppo-drive]]\naddress = 5\ngsd = 'modular.gsd'\nppo = 1"),
                "6, column 7",
                "has PPO 3, not PPO 1; choose one that it has",
            ),
            (
                line("[[line.ppo-drive]]\naddress = 5\ngsd = 'compact.gsd'\nppo = 5"),
                "6, column 7",
                "has PPO 1, not PPO 5; choose one that it has",
            ),
            (line("[[line.drive]]\naddress = 5\nmodle = 'ag03'"), "5, column 1", "did you mean model?"),
            (
                line("[[line.drive]]\naddress = 5\ngear = true"),
                "5, column 8",
                "gear: expected a word or a number, not true",
            ),
            (line("[[line.drive]]\ngear = 24"), "3, column 1", "'address' is missing; expected ADDRESS"),
            (line("[[line.drive]]\naddress = '5'"), "4, column 11", "address: expected a number, not the text '5'"),
            (
                line("[[line.drive]]\naddress = 5\nmode = 'half'"),
                "5, column 1",
                "'mode' is unknown",
            ),
            (node("device = 'eds-node'"), "3, column 1", "no file is named; expected ID"),
            (node("mode = 'half'"), "5, column 1", "mode is for the device asda-a2 only, not for ag03-1"),
            (node("device = 'ap10'\nbits = 1"), "6, column 1", "'bits' is unknown"),
            (node("quirks = { x = 'y' }"), "5, column 16", "quirk 'x' is unknown; ag03-1 has "),
            (node("eds = 'pump.eds'\nmode = 'half'"), "6, column 1", "mode is for the device asda-a2"),
            (
                line("[[line.station]]\naddress = 7\ngsd = '../../gsd/PDRV5034.GSD'\n[[line.station.record]]\nslot = 1\nindex = 47\nlength = 1"),
                "8, column 9",
                "index 47 has a meaning of its own",
            ),
            (
                input("behaviour = 'ramp'\nfrom = 0\nto = 1\ntime = '3601s'"),
                "13, column 8",
                "'3601s' is no time",
            ),
            (
                input("behaviour = 'ramp'\nfrom = 0\nto = 1\ntime = '0ms'"),
                "13, column 8",
                "'0ms' is no time",
            ),
            (
                input("behaviour = 'count'\nfrom = 0\nto = 1\nstep = 0\nevery = '1s'"),
                "7, column 1",
                "counts",
            ),
            (
                input("behaviour = 'mirror'\nof = 'bit0'"),
                "11, column 6",
                "'bit0' is no value",
            ),
            (
                input("behaviour = 'and'\nof = ['2/0/bit0', 'bit0']"),
                "11, column 19",
                "'bit0' is no value",
            ),
            (
                input("behaviour = 'mirror'\nof = { slot = 2 }"),
                "11, column 6",
                "'type' is missing",
            ),
            (
                line("[[line.ppo-drive]]\naddress = 5\nparameters = 'compact.gsd'"),
                "5, column 14",
                "ends in .toml or .csv",
            ),
            (
                line("[[line.ppo-drive]]\naddress = 5\nparameters = '../../examples/ppo_drive.toml'\nvalues = { 99 = 1 }"),
                "6, column 17",
                "there is no parameter 99",
            ),
            (
                line("[[line.ppo-drive]]\naddress = 5\nparameters = '../../examples/ppo_drive.toml'\nvalues = { 1 = 50 }"),
                "6, column 16",
                "'1': 50 is outside 100 to 6000",
            ),
            (
                line("[[line.ppo-drive]]\naddress = 5\n[[line.station]]\naddress = 5\ngsd = 'compact.gsd'"),
                "6, column 11",
                "two stations have address 5",
            ),
            (
                "[[line]]\nlink = 'slcan-pty:x'\n[[line.node]]\nid = 5\ndevice = 'ap10'\nquirks = { x = 'y' }".into(),
                "6, column 16",
                "quirk 'x' is unknown; ap10 has ",
            ),
            (line("[[line.node]]\nid = 5"), "1, column 1", "use link slcan-pty:PATH"),
            ("[[line]]\nlink = 'usb'".into(), "2, column 8", "expected pty"),
            (line("[[line.station]]\naddress = 7\ngsd = 'nowhere.gsd'"), "5, column 7", "cannot read"),
            (station("[[line.drive]]\naddress = 7\n"), "8, column 11", "two stations have address 7"),
            (
                STATION.replace("2 AO", "2 AOO"),
                "6, column 20",
                "there is no module '2 AOO'; did you mean '2 AO'?",
            ),
            (
                STATION
                    .replace("'8 DI', ", "'8 DI', '8 DI', '8 DI', '8 DI', '8 DI', '8 DI', '8 DI', '8 DI', "),
                "6, column 11",
                "the station takes 8 modules (Max_Module)",
            ),
            (input("behaviour = 'rmp'"), "10, column 13", "did you mean ramp?"),
            (input("behaviour = 'ramp'"), "10, column 13", "ramp needs 'from'"),
            (
                input("behaviour = 'ramp'\nmean = 1.0"),
                "11, column 8",
                "ramp has no 'mean'; expected from, to, time, then",
            ),
            (
                input("behaviour = 'ramp'\nfrom = 0\nto = 1\ntime = '5 minutes'"),
                "13, column 8",
                "'5 minutes' is no time",
            ),
            (
                input("behaviour = 'count'\nfrom = 0\nto = 1\nstep = -1\nevery = '1s'"),
                "7, column 1",
                "counts nothing",
            ),
            (
                input("behaviour = 'compare'\nof = '1/0/bit0'\nis = 1\nabove = 2"),
                "10, column 13",
                "expected one of is, above, below",
            ),
            (
                input("behaviour = 'ramp'\nfrom = {a=1}\nto = 1\ntime = '5s'"),
                "11, column 8",
                "from: expected a number, not a table",
            ),
            (line("baud = 19200\nbaud = 9600"), "4, column 1", "'baud' is there twice"),
            (input("behaviour = 'table'\nfile = 'no.csv'"), "11, column 8", "cannot read"),
            (input("value = 2"), "10, column 9", "2 does not fit, expected 0 to 1"),
            (
                input("behaviour = 'ramp'\nfrom = 0\nto = 2\ntime = '1s'"),
                "10, column 13",
                "it reaches 2, bit0 has 0 to 1",
            ),
            (
                input("behaviour = 'sine'\namplitude = 1\nperiod = '1s'"),
                "10, column 13",
                "it reaches -1, bit0 has 0 to 1",
            ),
            (
                input("behaviour = 'count'\nfrom = 0\nto = 3\nevery = '1s'"),
                "10, column 13",
                "it reaches 3, bit0 has 0 to 1",
            ),
            (
                input("behaviour = 'table'\nfile = '../../examples/line/level.csv'"),
                "10, column 13",
                "it reaches",
            ),
            (
                input("behaviour = 'scale'\nof = {slot = 2, type = 'bit0'}\nfactor = -1"),
                "10, column 13",
                "it reaches -1, bit0 has 0 to 1",
            ),
            (
                input("value = 1\n[[line.station.input]]\nslot = 1\ntype = 'unsigned8'\nvalue = 1"),
                "13, column 8",
                "another input is bit0 at octet 0 of slot 1, the same bits",
            ),
            (line("panel = '0.0.0.0:8080'"), "3, column 9", "add panel-allow-remote = true"),
            ("[[line]]\nlink = 'tcp:0.0.0.0:5050'".into(), "2, column 8", "add allow-remote = true"),
            (format!("metrics = '0.0.0.0:9187'\n{STATION}"), "1, column 11", "add metrics-allow-remote = true"),
            (
                input("behaviour = 'mirror'\nof = { slot = 3, type = 'bit0' }"),
                "11, column 15",
                "there is no slot 3; expected 1 to 2",
            ),
            (
                input("behaviour = 'follow'\nstation = 8\ndelay = '1s'\nof = { slot = 3, type = 'bit0' }"),
                "11, column 11",
                "there is no station 8",
            ),
            (station("unlike = 'maybe'"), "7, column 10", "expected refuse or report"),
            (
                station("[[line.station.diagnosis]]\nfrom = '5s'\nuntil = '5s'\nbits = [0]"),
                "9, column 9",
                "until must be later than from",
            ),
            (station("[[line.station.diagnosis]]\nbit = [0]"), "8, column 1", "'bit' is unknown"),
            (station("[[line.station.diagnosis]]\nfrom = '5s'"), "7, column 1", "reports nothing"),
            (station("[[line.station.diagnosis]]\nidentifiers = [1, 3]"), "7, column 1", "there is no slot 3"),
            (station("[[line.station.diagnosis]]\noctets = [67, 0]"), "7, column 1", "no whole block"),
            (
                station("[[line.station.diagnosis]]\nchannels = [{ slot = 1, channel = 0, error = 12 }]"),
                "8, column 46",
                "12 is no error of a channel",
            ),
            (
                input("behaviour = 'follow'\nline = 2\nstation = 8\nof = '1/0/bit0'"),
                "11, column 8",
                "there is no line 2; expected 1 to 1",
            ),
            (
                input("behaviour = 'follow'\nstation = 5\nof = '1/0/bit0'\n[[line.drive]]\naddress = 5"),
                "12, column 6",
                "station 5 has no slots; name one of its values",
            ),
            (
                input("behaviour = 'follow'\nstation = 7\nof = { slot = 3, type = 'bit0' }"),
                "12, column 15",
                "there is no slot 3",
            ),
            (
                input("behaviour = 'and'\nof = ['2/0/unsigned16', '2/3/unsigned32']"),
                "11, column 25",
                "output of module '2 AO': unsigned32 at octet 3 needs 7 octets, the slot has 4",
            ),
            (
                station("[[line.station.input]]\nslot = 2\ntype = 'unsigned16'\nvalue = 1"),
                "8, column 8",
                "needs 2 octets, the slot has 0",
            ),
            (station("[[line.station.input]]\nslot = 1\ntype = 'bit9'"), "9, column 8", "bit9"),
            (station("[[line.fault]]\nfault = 'lat=20ms'"), "8, column 9", "'lat' is no fault"),
            (
                station("[[line.fault]]\nfault = 'no-reply,station=9'"),
                "8, column 9",
                "which is not on the line",
            ),
            (
                station("[[line.fault]]\nfault = 'no-reply'\nfrom = '5s'\nuntil = '5s'"),
                "10, column 9",
                "until must be later than from",
            ),
            (
                station(
                    "[[line.fault]]\nfault = 'no-reply'\nwhile = { station = 7, slot = 1, type = 'bit0' }",
                ),
                "9, column 9",
                "expected one of is, above, below",
            ),
            (
                line(
                    "panel = '127.0.0.1:8080'\n[[line.drive]]\naddress = 5\n[[line]]\nlink = 'pty'\npanel = '127.0.0.1:8080'\n[[line.drive]]\naddress = 5",
                ),
                "8, column 9",
                "two lines have panel",
            ),
        ]
    }

    #[test]
    fn what_is_wrong_is_told_with_line_column_and_cure() {
        for (text, place, words) in wrong_files() {
            let said = refused(&text);
            assert!(said.contains(&format!("line {place}")), "{text}\n{said}");
            assert!(said.contains(words), "{text}\n{said}");
            assert!(!said.contains('\n'), "{said}");
        }
    }
}
