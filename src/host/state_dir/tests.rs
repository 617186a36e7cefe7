use std::collections::BTreeMap;
use std::sync::Mutex;

use super::*;
use crate::time::Instant;

/// A unit that is one number.
#[derive(Debug, Default)]
struct Number {
    value: u8,
    taken: Option<u8>,
    told: Vec<(u8, bool)>,
}

impl Images for Number {
    type Generation = u8;

    fn poll_image(&mut self) -> Option<(u8, Vec<u8>)> {
        (self.taken.replace(self.value) != Some(self.value)).then(|| (self.value, vec![self.value]))
    }

    fn handle_stored(&mut self, _: Instant, generation: u8, stored: bool) {
        self.told.push((generation, stored));
    }
}

impl Number {
    fn set(&mut self, file: &mut ImageFile<u8>, value: u8) {
        self.value = value;
        file.take_from(Instant::ZERO, self);
    }

    fn told(&mut self, file: &mut ImageFile<u8>) -> Vec<(u8, bool)> {
        file.report_to(Instant::ZERO, self);
        core::mem::take(&mut self.told)
    }
}

/// Files in memory; each of the two steps that matter can fail.
#[derive(Clone, Debug, Default)]
struct Memory {
    files: Arc<Mutex<BTreeMap<String, Vec<u8>>>>,
    failing: Arc<Mutex<(bool, bool)>>,
}

impl Memory {
    fn fail(&self, rename: bool, sync_names: bool) {
        *self.failing.lock().unwrap() = (rename, sync_names);
    }

    fn file(&self, name: &str) -> Option<Vec<u8>> {
        self.files.lock().unwrap().get(name).cloned()
    }
}

impl Disk for Memory {
    fn read(&self, name: &str, _: usize) -> io::Result<Option<Vec<u8>>> {
        Ok(self.file(name))
    }
    fn write(&self, name: &str, octets: &[u8]) -> io::Result<()> {
        self.files.lock().unwrap().insert(name.into(), octets.into());
        Ok(())
    }
    fn sync(&self, _: &str) -> io::Result<()> {
        Ok(())
    }
    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        if self.failing.lock().unwrap().0 {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let mut files = self.files.lock().unwrap();
        let octets = files.remove(from).unwrap();
        files.insert(to.into(), octets);
        Ok(())
    }
    fn sync_names(&self) -> io::Result<()> {
        if self.failing.lock().unwrap().1 { Err(io::ErrorKind::StorageFull.into()) } else { Ok(()) }
    }
    fn remove(&self, name: &str) -> io::Result<()> {
        self.files.lock().unwrap().remove(name);
        Ok(())
    }
    fn names(&self) -> io::Result<Vec<String>> {
        Ok(self.files.lock().unwrap().keys().cloned().collect())
    }
}

fn state(disk: &Memory) -> StateDir {
    StateDir::on(Path::new("memory"), Box::new(disk.clone())).unwrap()
}

#[test]
fn any_unit_keeps_its_images_under_the_name_it_is_given() {
    let disk = Memory::default();
    let state = state(&disk);
    let (mut file, newest) = state.file("node-7", 1).unwrap();
    assert_eq!(newest, None);
    let mut unit = Number::default();
    for value in [1, 2, 3] {
        unit.set(&mut file, value);
    }
    assert_eq!(unit.told(&mut file), []);
    assert!(state.write_next());
    assert!(!state.write_next(), "only the newest");
    assert_eq!(unit.told(&mut file), [(3, true)]);
    assert_eq!(disk.file("node-7.eeprom"), Some(vec![3]));
    assert!(matches!(state.file::<u8>("node-7", 1), Err(StateDirError::Owned { .. })));
    drop(file);
    let again = state.file::<u8>("node-7", 1).unwrap().1;
    assert_eq!(again, Some(Newest { octets: vec![3], safe: true }));
}

#[test]
fn the_next_owner_gets_what_waits_and_is_told_nothing_that_concerns_the_one_before() {
    let disk = Memory::default();
    let state = state(&disk);
    let mut unit = Number::default();
    for value in 1..=20 {
        let (mut file, newest) = state.file("a", 1).unwrap();
        let waits = Some(Newest { octets: vec![value - 1], safe: false });
        assert_eq!(newest, waits.filter(|_| value > 1));
        unit.set(&mut file, value);
    }
    let (mut file, _) = state.file("a", 1).unwrap();
    assert!(state.write_next());
    assert_eq!(unit.told(&mut file), []);
    assert_eq!(disk.file("a.eeprom"), Some(vec![20]));
}

#[test]
fn a_failure_is_told_only_if_the_file_is_surely_as_before() {
    let disk = Memory::default();
    let state = state(&disk);
    let (mut file, _) = state.file("a", 1).unwrap();
    let mut unit = Number::default();
    disk.fail(true, false);
    unit.set(&mut file, 1);
    assert!(state.write_next());
    assert_eq!(unit.told(&mut file), [(1, false)]);
    assert!(!state.write_next(), "its owner decides");

    disk.fail(false, true);
    unit.set(&mut file, 2);
    assert!(state.write_next());
    assert_eq!(unit.told(&mut file), [], "the file may hold it");
    disk.fail(true, false);
    assert!(state.write_next());
    assert_eq!(unit.told(&mut file), [], "and still does");
    disk.fail(false, false);
    assert!(state.write_next());
    assert_eq!(unit.told(&mut file), [(2, true)]);
}

#[test]
fn an_image_that_is_safe_is_told_although_one_after_it_has_failed_meanwhile() {
    let disk = Memory::default();
    let state = state(&disk);
    let (mut file, _) = state.file("a", 1).unwrap();
    let mut unit = Number::default();
    unit.set(&mut file, 1);
    assert!(state.write_next());
    unit.set(&mut file, 2);
    assert!(state.write_next());
    disk.fail(true, false);
    unit.set(&mut file, 3);
    assert!(state.write_next());
    assert_eq!(disk.file("a.eeprom"), Some(vec![2]));
    assert_eq!(unit.told(&mut file), [(2, true), (3, false)]);
    disk.fail(false, false);
    unit.set(&mut file, 4);
    assert!(state.write_next());
    assert_eq!(unit.told(&mut file), [(4, true)]);
}

#[test]
fn what_the_last_owner_left_is_tried_until_it_is_stored() {
    let disk = Memory::default();
    let state = state(&disk);
    let (mut file, _) = state.file("a", 1).unwrap();
    let mut unit = Number::default();
    disk.fail(true, false);
    unit.set(&mut file, 1);
    state.write_next();
    assert_eq!(unit.told(&mut file), [(1, false)]);
    drop(file);
    assert!(state.write_next() && state.write_next());
    disk.fail(false, false);
    assert!(state.write_next());
    assert_eq!((disk.file("a.eeprom"), state.slots.len()), (Some(vec![1]), 0));
}

#[test]
fn ten_thousand_units_that_came_and_went_leave_nothing_behind() {
    let state = state(&Memory::default());
    for round in 0..10_000_u32 {
        let (mut file, _) = state.file(&format!("{}", round % 100), 1).unwrap();
        Number::default().set(&mut file, round.to_le_bytes()[0]);
        drop(file);
        if round % 3 == 0 {
            while state.write_next() {}
            assert_eq!(state.slots.len(), 0);
        }
        assert!(state.slots.len() <= 3);
    }
}
