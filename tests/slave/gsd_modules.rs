//! Which modules a station of a GSD has: those that the user names, or those of which the master's octets can be.
//!
//! `PROFIDRIVE_GSD_FOLDER=<folder>` has the last test read every device file below a folder: real ones, which we do not keep.
//! For hundreds of them with `--config 'profile.test.package.profidrive.opt-level=1'`: a minute and a half.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use profidrive::gsd::{Gsd, Placed, Policy, Station};
use profidrive::profibus::dp::Application;

/// Twins: equal identifiers, and nothing else, another range, another constant, another length, another hidden value.
const TWINS: &[u8] = include_bytes!("../gsd/twins.gsd");

fn twins(policy: Policy) -> Station {
    Station::new(Gsd::read(TWINS).unwrap(), policy).unwrap()
}

fn place(gsd: &Gsd, name: &str) -> usize {
    gsd.modules.iter().position(|module| module.name == name).unwrap()
}

/// What a project of a master sends for these modules, with the defaults of their parameters.
fn project(gsd: &Gsd, modules: &[usize]) -> (Vec<u8>, Vec<u8>) {
    let configuration = modules.iter().flat_map(|place| gsd.modules[*place].identifiers.clone()).collect();
    (configuration, gsd.default_user_prm(modules))
}

fn names(station: &Station, configuration: &[u8], user_prm: &[u8]) -> Vec<String> {
    let layout = station.layout(configuration, Some(user_prm));
    layout.iter().map(|placed| placed.name(station.gsd())).collect()
}

#[test]
fn set_prm_decides_among_modules_with_equal_identifiers() {
    let station = twins(Policy::STRICT);
    let gsd = station.gsd();
    for (list, shown) in [
        (&["plain"][..], &["plain or plain HF"][..]),
        (&["filter"], &["filter"]),
        (&["range"], &["range"]),
        (&["other"], &["other"]),
        (&["keyed"], &["keyed"]),
        (
            &["filter", "plain", "range"],
            &["plain, plain HF or filter", "plain, plain HF, filter or range", "plain, plain HF or range"],
        ),
        (&["range", "other", "filter"], &["range", "other", "filter"]),
        (&["plain", "out"], &["plain or plain HF", "out"]),
        (&["pair"], &["pair"]),
        (&["pair", "keyed"], &["pair", "keyed"]),
    ] {
        let modules: Vec<_> = list.iter().map(|name| place(gsd, name)).collect();
        let (configuration, user_prm) = project(gsd, &modules);
        assert_eq!(station.judge_cfg(&configuration, &user_prm), Ok(()), "{list:?}");
        assert_eq!(station.remarks(&configuration, &user_prm), Vec::<String>::new(), "{list:?}");
        let layout = station.layout(&configuration, Some(&user_prm));
        for (placed, name) in layout.iter().zip(list) {
            assert!(placed.names(gsd).contains(name), "{list:?}: {name} is shown as {}", placed.name(gsd));
        }
        assert_eq!(names(&station, &configuration, &user_prm), shown, "{list:?}");
    }
}

#[test]
fn what_no_reading_allows_is_odd_and_what_one_allows_is_not() {
    let station = twins(Policy::PROPOSED);
    let strict = twins(Policy::STRICT);
    for (user_prm, odd, refused) in [
        // The value of `range`, and those of none.
        (&[0, 0xA1, 30][..], None, false),
        (&[0, 0xA1, 99], None, false),
        // Without a module of three octets.
        (&[0, 1, 2, 3], Some("4 octets of user parameters, the modules have 1"), true),
        // Masters may send the part of the station only: nothing tells the modules apart.
        (&[0], None, false),
    ] {
        let remarks = station.remarks(&[0x13], user_prm);
        assert_eq!(remarks.first().map(String::as_str), odd, "{user_prm:?}");
        assert_eq!(strict.judge_cfg(&[0x13], user_prm).is_err(), refused, "{user_prm:?}");
    }
    // 99 is the value of no parameter but `keyed`, whose constant it does not have.
    assert_eq!(names(&station, &[0x13], &[0, 0xA1, 99]), ["keyed"]);
    assert_eq!(names(&station, &[0x13], &[0, 1, 2, 3]).len(), 1);
}

#[test]
fn modules_that_are_named_are_those_and_no_others() {
    let gsd = Gsd::read(TWINS).unwrap();
    for name in ["plain", "plain HF", "filter", "range", "other", "keyed"] {
        let own = [place(&gsd, name), place(&gsd, "out")];
        let station = twins(Policy::STRICT).plugged(&own).unwrap();
        let (configuration, user_prm) = project(&gsd, &own);
        let before: Vec<_> = station.layout(&configuration, None).iter().map(|at| at.name(&gsd)).collect();
        assert_eq!(before, [name, "out"]);
        assert_eq!(names(&station, &configuration, &user_prm), [name, "out"]);
        assert_eq!(station.judge_cfg(&configuration, &user_prm), Ok(()));
        assert_eq!(station.remarks(&configuration, &user_prm), Vec::<String>::new());
    }
    // The octets of `filter` with the value of `range`: right for that one only.
    let named = |name| twins(Policy::STRICT).plugged(&[place(&gsd, name)]).unwrap();
    assert_eq!(named("range").judge_cfg(&[0x13], &[0, 0xA1, 30]), Ok(()));
    assert!(named("filter").judge_cfg(&[0x13], &[0, 0xA1, 30]).is_err());
}

#[test]
fn modules_that_are_named_obey_slots_and_presets() {
    let slots = Gsd::read(
        b"#Profibus_DP\nGSD_Revision=3\nIdent_Number=0x0ABC\nModular_Station=1\nMax_Module=2\n\
        Module=\"one\" 0x10\n1\nEndModule\nModule=\"two\" 0x10\n2\nEndModule\n\
        SlotDefinition\nSlot(1)=\"head\" 1 1\nSlot(2)=\"tail\" 2 2\nEndSlotDefinition\n",
    )
    .unwrap();
    let plug = |gsd: &Gsd, modules: &[usize]| {
        let plugged = Station::new(gsd.clone(), Policy::PROPOSED).unwrap().plugged(modules);
        plugged.map(|_| ()).map_err(|error| error.words)
    };
    assert_eq!(plug(&slots, &[0, 1]), Ok(()));
    let wrong = "module 'two' may not be in slot 1 'head'; expected 'one'";
    assert_eq!(plug(&slots, &[1, 0]), Err(wrong.to_owned()));
    // Five modules in four slots, though their octets could be four.
    let twins = Gsd::read(TWINS).unwrap();
    let wrong = "the station takes 4 modules (Max_Module): take the others out";
    assert_eq!(plug(&twins, &[2, 4, 1, 7, 3]), Err(wrong.to_owned()));
}

/// Numbers that look random.
struct Dice(u64);

impl Dice {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end.max(1)
    }
}

fn files(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, all);
        } else {
            all.push(path);
        }
    }
    all.sort();
}

/// A list of modules that the file allows, `first` among them if it may be; empty if chance found none.
fn list(gsd: &Gsd, station: &Station, first: usize, dice: &mut Dice) -> Vec<usize> {
    let presets: Vec<usize> = gsd
        .modules
        .iter()
        .enumerate()
        .filter(|(_, module)| module.preset && gsd.flags.fixed_presets)
        .map(|(place, _)| place)
        .collect();
    let others = (0..dice.below(5)).map(|_| dice.below(gsd.modules.len()));
    let one = [&presets[..], &[first]].concat();
    let longer = [&one[..], &others.collect::<Vec<_>>()].concat();
    let fits = |modules: &Vec<usize>| {
        let (_, user_prm) = project(gsd, modules);
        let most = usize::from(gsd.user_prm_lengths().1);
        user_prm.len() <= most && station.clone().plugged(modules).is_ok()
    };
    [longer, one].into_iter().find(fits).unwrap_or_default()
}

/// How each module of a list is shown: by its own name, by others, or in a slot of another length.
#[derive(Debug, Default, PartialEq, Eq)]
struct Shown {
    alone: usize,
    among_others: usize,
    in_another_split: usize,
    under_another_name: usize,
}

fn compare(gsd: &Gsd, layout: &[Placed], modules: &[usize], shown: &mut Shown) -> Option<String> {
    let (configuration, _) = project(gsd, modules);
    let (mut at, mut wrong) = (0, None);
    for module in modules {
        let module = &gsd.modules[*module];
        let placed = layout.iter().find(|placed| placed.octets.start == at);
        let names = placed.map(|placed| placed.names(gsd)).unwrap_or_default();
        match names.contains(&module.name.as_str()) {
            true if names.len() == 1 => shown.alone += 1,
            true => shown.among_others += 1,
            false if placed.is_none() => {
                println!("'{}' at octet {at} of {:02X?} is in another split", module.name, configuration);
                shown.in_another_split += 1;
            }
            false => {
                shown.under_another_name += 1;
                wrong = Some(format!("'{}' at octet {at} is shown as {names:?}", module.name));
            }
        }
        at += module.identifiers.len();
    }
    wrong
}

#[test]
fn no_module_that_a_legal_list_names_is_shown_under_another_name() {
    let mut all = Vec::new();
    files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gsd"), &mut all);
    if let Some(folder) = std::env::var_os("PROFIDRIVE_GSD_FOLDER") {
        files(Path::new(&folder), &mut all);
    }
    let (mut open, mut named, mut failures) = (Shown::default(), Shown::default(), Vec::new());
    let (mut dice, mut idents, mut modules_read) = (Dice(25), BTreeSet::new(), 0);
    for path in &all {
        let Ok(gsd) = Gsd::read(&fs::read(path).unwrap()) else { continue };
        let Ok(station) = Station::new(gsd.clone(), Policy::STRICT) else { continue };
        idents.insert(gsd.ident);
        modules_read += gsd.modules.len();
        if !gsd.is_modular() {
            continue;
        }
        for first in 0..gsd.modules.len() {
            let modules = list(&gsd, &station, first, &mut dice);
            let (configuration, user_prm) = project(&gsd, &modules);
            if modules.is_empty() {
                continue;
            }
            let mut check = |station: &Station, shown: &mut Shown| {
                if let Err(refusal) = station.judge_cfg(&configuration, &user_prm) {
                    failures.push(format!("{}: {modules:?} refused: {refusal:?}", path.display()));
                }
                let remarks: Vec<_> = station.remarks(&configuration, &user_prm);
                if remarks.iter().any(|remark| remark.contains("module")) {
                    failures.push(format!("{}: {modules:?}: {remarks:?}", path.display()));
                }
                let layout = station.layout(&configuration, Some(&user_prm));
                failures.extend(
                    compare(&gsd, &layout, &modules, shown)
                        .map(|words| format!("{}: {words}", path.display())),
                );
            };
            check(&station, &mut open);
            check(&station.clone().plugged(&modules).unwrap(), &mut named);
        }
    }
    println!("{} files, {} ident numbers, {modules_read} modules", all.len(), idents.len());
    println!("without names {open:?}\nwith names {named:?}");
    assert!(
        failures.is_empty(),
        "{} failures:\n{}",
        failures.len(),
        failures[..failures.len().min(40)].join("\n")
    );
    assert!(open.alone > 10 && open.among_others + named.alone > 10);
    assert_eq!((named.among_others, named.in_another_split, named.under_another_name), (0, 0, 0));
}
