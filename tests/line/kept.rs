//! Nothing acknowledged is ever lost, nothing refused ever comes back: random sequences of adding, removing, moving by
//! DIP switches, switching off and on, writing, failing disks, kills, power failures and restarts, against a model that
//! knows every acknowledgement. For 10 000 sequences set `PROFIDRIVE_LONG`.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use profidrive::devices::ag03::param::{Parameter, Pnu, Value};
use profidrive::devices::ag03::profibus::{ApplicationCycle, Config, Device, DipSwitches, MAX_TELEGRAM_LEN};
use profidrive::host::{StateDir, StateDirError, Stored};
use profidrive::profibus::fdl::{Address, FrameCount, FunctionCode, Service};
use profidrive::profibus::ppo::{Ind, JobId, PPO_LEN, Pke, Pkw, ReplyId};
use profidrive::time::Instant;
use proptest::prelude::*;

use crate::drive_line::{CFG, IDENT, MASTER};
use crate::faulty_disk::{Failing, FaultyDisk};
use crate::long::cases;
use crate::telegrams::telegram;

/// Double words of a wide range, so that every value written is another one.
const PARAMETERS: [(u16, Parameter); 3] =
    [(1016, Parameter::Limit1), (1018, Parameter::CalibrationValue), (1019, Parameter::DeltaInch)];
const UNITS: u8 = 3;
/// DIP switches take units to addresses under which others are added, and elsewhere.
const ADDRESSES: u8 = 5;

#[derive(Clone, Copy, Debug)]
enum Op {
    Add(u8),
    Remove(u8),
    Move(u8, u8),
    SwitchOff(u8),
    SwitchOn(u8),
    /// A job over the bus: a new one, or the one that waits.
    Write(u8, usize),
    /// A job over the bus that writes the value it finds.
    WriteSame(u8, usize),
    /// Past the bus, as the panel does it, also while a job of the bus waits for its reply.
    Panel(u8, usize),
    /// Past the bus, the value that is there already, perhaps from a job that waits.
    PanelSame(u8, usize),
    Disk(Failing),
    /// The writer writes so many images.
    Writer(u8),
    Kill {
        calls: u32,
        power: Option<usize>,
    },
    /// Ended properly.
    Restart,
}

fn op() -> impl Strategy<Value = Op> {
    let unit = 1..=UNITS;
    let parameter = 0..PARAMETERS.len();
    let failing = (any::<bool>(), any::<bool>(), any::<bool>(), any::<bool>())
        .prop_map(|(write, sync, rename, sync_names)| Failing { write, sync, rename, sync_names });
    let one = prop_oneof![
        Just(Failing { write: true, ..Failing::default() }),
        Just(Failing { sync: true, ..Failing::default() }),
        Just(Failing { rename: true, ..Failing::default() }),
        Just(Failing { sync_names: true, ..Failing::default() }),
    ];
    prop_oneof![
        4 => unit.clone().prop_map(Op::Add),
        2 => unit.clone().prop_map(Op::Remove),
        1 => (unit.clone(), 1..=ADDRESSES).prop_map(|(unit, to)| Op::Move(unit, to)),
        1 => unit.clone().prop_map(Op::SwitchOff),
        1 => unit.clone().prop_map(Op::SwitchOn),
        8 => (unit.clone(), parameter.clone()).prop_map(|(unit, which)| Op::Write(unit, which)),
        3 => (unit.clone(), parameter.clone()).prop_map(|(unit, which)| Op::WriteSame(unit, which)),
        4 => (unit.clone(), parameter.clone()).prop_map(|(unit, which)| Op::Panel(unit, which)),
        2 => (unit, parameter).prop_map(|(unit, which)| Op::PanelSame(unit, which)),
        2 => Just(Op::Disk(Failing::default())),
        1 => failing.prop_map(Op::Disk),
        2 => one.prop_map(Op::Disk),
        8 => (1..4_u8).prop_map(Op::Writer),
        1 => (0..12_u32, proptest::option::of(any::<usize>())).prop_map(|(calls, power)| Op::Kill { calls, power }),
        1 => Just(Op::Restart),
    ]
}

/// What the model knows of one parameter of one unit.
#[derive(Clone, Debug)]
struct Known {
    /// The value acknowledged last, or found after a restart.
    acknowledged: i32,
    /// Values that were neither acknowledged nor refused: they may be found instead.
    open: Vec<i32>,
}

impl Known {
    fn may_be(&self, value: i32) -> bool {
        value == self.acknowledged || self.open.contains(&value)
    }
}

struct Unit {
    drive: Stored<Device>,
    count: FrameCount,
    /// In Data_Exchange.
    exchanging: bool,
    /// The job that waits for its reply.
    job: Option<Job>,
    /// A job was given up before its reply: until the next acknowledgement what is in force may change by itself.
    given_up: bool,
}

struct Job {
    which: usize,
    value: i32,
    /// All values before it.
    before: [i32; 3],
    /// What was written without the bus since, oldest first.
    past_the_bus: [Vec<i32>; 3],
}

impl Job {
    /// What is in force when the bus has changed these values: who writes without it, writes later.
    fn with_later_writes(&self, mut values: [i32; 3]) -> [i32; 3] {
        for (value, later) in values.iter_mut().zip(&self.past_the_bus) {
            *value = later.last().copied().unwrap_or(*value);
        }
        values
    }

    fn when_acknowledged(&self) -> [i32; 3] {
        let mut values = self.before;
        values[self.which] = self.value;
        values
    }
}

struct World {
    disk: FaultyDisk,
    state: Option<StateDir>,
    now: Instant,
    units: BTreeMap<u8, Unit>,
    known: BTreeMap<u8, [Known; 3]>,
    /// What a unit had when it was removed, if nothing can have changed it since.
    left_with: BTreeMap<u8, [i32; 3]>,
    last_value: i32,
}

fn address(number: u8) -> Address {
    // Not that of the master.
    Address::station(10 + number).unwrap()
}

fn values_of(drive: &Stored<Device>) -> [i32; 3] {
    PARAMETERS.map(|(_, parameter)| drive.unit().parameters().value(parameter))
}

impl Unit {
    fn request(&mut self, now: &mut Instant, dsap: Option<u8>, data: &[u8]) -> Vec<u8> {
        let fc = FunctionCode::request(Service::SrdHigh, self.count);
        self.count = if self.count == FrameCount::Even { FrameCount::Odd } else { FrameCount::Even };
        *now = now.saturating_add(Duration::from_millis(5));
        self.drive.act(*now, |drive| drive.handle_timeout(*now));
        let da = self.drive.unit().address().number();
        self.drive.act(*now, |drive| drive.handle_bytes(*now, &telegram(da, MASTER, fc, dsap, data)));
        let due = self.drive.unit().poll_timeout().unwrap();
        self.drive.act(due, |drive| drive.handle_timeout(due));
        let reply = self.drive.unit_mut().poll_transmit(due, &mut [0; MAX_TELEGRAM_LEN]).unwrap().to_vec();
        if reply.len() > PPO_LEN {
            reply[reply.len() - 2 - PPO_LEN..reply.len() - 2].to_vec()
        } else {
            Vec::new()
        }
    }

    fn exchange(&mut self, now: &mut Instant, job: Pkw) -> Pkw {
        if !self.exchanging {
            self.count = FrameCount::First;
            self.request(now, Some(61), &[0x80, 1, 1, 11, IDENT[0], IDENT[1], 0]);
            self.request(now, Some(62), &CFG);
            self.exchanging = true;
        }
        let mut outputs = [0; PPO_LEN];
        outputs[..8].copy_from_slice(&job.to_octets());
        let inputs = self.request(now, None, &outputs);
        Pkw::from_octets(inputs[..8].try_into().unwrap())
    }

    /// Nobody waits for the reply any more.
    fn give_up(&mut self) {
        self.exchanging = false;
        self.given_up |= self.job.take().is_some();
    }
}

impl World {
    fn new() -> Self {
        let mut world = Self {
            disk: FaultyDisk::default(),
            state: None,
            now: Instant::from_millis(1),
            units: BTreeMap::new(),
            known: BTreeMap::new(),
            left_with: BTreeMap::new(),
            last_value: 0,
        };
        world.start();
        world
    }

    fn start(&mut self) {
        self.state = Some(StateDir::on(Path::new("memory"), Box::new(self.disk.clone())).unwrap());
    }

    fn state(&self) -> &StateDir {
        self.state.as_ref().unwrap()
    }

    fn apply(&mut self, op: Op) {
        match op {
            Op::Add(key) => self.add(key),
            Op::Remove(key) => self.remove(key),
            Op::Move(key, to) => self.change_address(key, to),
            Op::SwitchOff(key) => self.switch(key, false),
            Op::SwitchOn(key) => self.switch(key, true),
            Op::Write(key, which) => {
                let value = self.new_value();
                self.write(key, which, Some(value));
            }
            Op::WriteSame(key, which) => self.write(key, which, None),
            Op::Panel(key, which) => {
                let value = self.new_value();
                self.panel(key, which, Some(value));
            }
            Op::PanelSame(key, which) => self.panel(key, which, None),
            Op::Disk(failing) => self.disk.fail(failing),
            Op::Writer(images) => (0..images).for_each(|_| _ = self.state().write_next()),
            Op::Kill { calls, power } => self.kill(calls, power),
            Op::Restart => self.restart(),
        }
    }

    fn add(&mut self, key: u8) {
        let config =
            Config { application_cycle: ApplicationCycle::EACH_EXCHANGE, ..Config::new(address(key)) };
        let drive = match self.state().load(config, self.now) {
            Ok(drive) => drive,
            Err(StateDirError::Owned { .. }) => return assert!(self.units.contains_key(&key)),
            // Its first image could not be stored.
            Err(StateDirError::File { .. }) => return assert!(!self.units.contains_key(&key)),
            Err(error) => panic!("{error}"),
        };
        assert!(!self.units.contains_key(&key), "two units have one file");
        let found = values_of(&drive);
        if let Some(left) = self.left_with.remove(&key) {
            assert_eq!(found, left, "unit {key} is added again");
        }
        let known = self.known.entry(key).or_insert_with(|| {
            PARAMETERS.map(|(_, parameter)| {
                let factory = profidrive::devices::ag03::profibus::Device::new(config, Instant::ZERO);
                Known { acknowledged: factory.parameters().value(parameter), open: Vec::new() }
            })
        });
        for (known, value) in known.iter().zip(found) {
            assert!(known.may_be(value), "unit {key} has {value}, expected {known:?}");
        }
        let unit = Unit { drive, count: FrameCount::First, exchanging: false, job: None, given_up: false };
        self.units.insert(key, unit);
    }

    fn remove(&mut self, key: u8) {
        if let Some(mut unit) = self.units.remove(&key) {
            self.open_job(key, &unit);
            unit.give_up();
            // Outcomes that are known change it before it goes.
            unit.drive.act(self.now, |drive| drive.handle_timeout(self.now));
            if !unit.given_up {
                self.left_with.insert(key, values_of(&unit.drive));
            }
        }
    }

    /// The reply to a job that waits is not waited for.
    fn open_job(&mut self, key: u8, unit: &Unit) {
        if let Some(job) = &unit.job {
            self.known.get_mut(&key).unwrap()[job.which].open.push(job.value);
        }
    }

    fn change_address(&mut self, key: u8, to: u8) {
        // As the panel refuses it.
        let taken = |(other, unit): (&u8, &Unit)| *other != key && unit.drive.unit().address() == address(to);
        if self.units.iter().any(taken) {
            return;
        }
        self.switch(key, false);
        if let Some(unit) = self.units.get_mut(&key) {
            unit.drive.unit_mut().set_switches(DipSwitches::from(address(to)));
        }
        self.switch(key, true);
    }

    fn switch(&mut self, key: u8, on: bool) {
        let Some(mut unit) = self.units.remove(&key) else { return };
        self.now = self.now.saturating_add(Duration::from_millis(1));
        let before = values_of(&unit.drive);
        if on {
            unit.drive.unit_mut().power_on(self.now);
        } else {
            self.open_job(key, &unit);
            unit.give_up();
            unit.drive.unit_mut().power_off(self.now);
        }
        assert_eq!(values_of(&unit.drive), before, "switched");
        unit.drive.act(self.now, |drive| drive.handle_timeout(self.now));
        self.units.insert(key, unit);
    }

    fn new_value(&mut self) -> i32 {
        self.last_value += 1;
        self.last_value
    }

    fn write(&mut self, key: u8, which: usize, value: Option<i32>) {
        let Some(unit) = self.units.get_mut(&key) else { return };
        if unit.drive.unit().power() != profidrive::devices::ag03::profibus::Power::On {
            return;
        }
        if unit.job.is_none() {
            for _ in 0..3 {
                if unit.exchange(&mut self.now, Pkw::ZERO) == Pkw::ZERO {
                    let before = values_of(&unit.drive);
                    let (value, past_the_bus) = (value.unwrap_or(before[which]), Default::default());
                    unit.job = Some(Job { which, value, before, past_the_bus });
                    break;
                }
            }
        }
        let Some(job) = unit.job.take() else { return };
        let pnu = PARAMETERS[job.which].0;
        let octets = job.value.cast_unsigned();
        let request = Pkw::new(Pke::of_job(JobId::WriteDoubleWord, pnu), Ind::default(), octets);
        let mut reply = unit.exchange(&mut self.now, request);
        if reply == Pkw::ZERO {
            reply = unit.exchange(&mut self.now, request);
        }
        if reply == Pkw::ZERO {
            unit.job = Some(job);
            return;
        }
        assert_eq!(reply.pke.pnu(), pnu);
        let found = values_of(&unit.drive);
        match reply.pke.reply() {
            ReplyId::DoubleWord => {
                assert_eq!(reply.double_word(), octets);
                let values = job.when_acknowledged();
                let in_force = job.with_later_writes(values)[job.which];
                assert_eq!(found[job.which], in_force, "acknowledged");
                // What an image holds is safe with it: all that was in force when the job was executed.
                let known = self.known.get_mut(&key).unwrap().iter_mut();
                for (which, (known, open)) in known.zip(job.past_the_bus).enumerate() {
                    if which == job.which || !unit.given_up {
                        *known = Known { acknowledged: values[which], open };
                    }
                }
                unit.given_up = false;
            }
            ReplyId::NotExecutable => {
                assert_eq!(reply.word(), 18);
                if !unit.given_up {
                    let expected = job.with_later_writes(job.before);
                    assert_eq!(found, expected, "nothing of a refused job stays, all that came later does");
                }
            }
            other => panic!("{other:?}"),
        }
    }

    fn panel(&mut self, key: u8, which: usize, value: Option<i32>) {
        let Some(unit) = self.units.get_mut(&key) else { return };
        if unit.drive.unit().power() != profidrive::devices::ag03::profibus::Power::On {
            return;
        }
        let pnu = Pnu::new(PARAMETERS[which].0).unwrap();
        let value = value.unwrap_or_else(|| values_of(&unit.drive)[which]);
        let value_written = Value::Double(value.cast_unsigned());
        unit.drive.unit_mut().write_parameter(self.now, pnu, None, value_written).unwrap();
        assert_eq!(values_of(&unit.drive)[which], value);
        if let Some(job) = &mut unit.job {
            job.past_the_bus[which].push(value);
        }
        self.known.get_mut(&key).unwrap()[which].open.push(value);
        unit.drive.act(self.now, |drive| drive.handle_timeout(self.now));
    }

    fn kill(&mut self, calls: u32, power: Option<usize>) {
        self.disk.kill_after(calls);
        for _ in 0..calls {
            self.state().write_next();
        }
        self.disk.kill();
        for key in 1..=UNITS {
            self.remove(key);
        }
        if let Some(chance) = power {
            self.disk.power_failure(chance);
        }
        self.begin_again();
    }

    fn restart(&mut self) {
        for key in 1..=UNITS {
            self.remove(key);
        }
        self.disk.fail(Failing::default());
        while self.state().write_next() {}
        let left = self.left_with.clone();
        self.begin_again();
        for (key, values) in left {
            assert_eq!(values_of(&self.units[&key].drive), values, "unit {key} ended properly");
        }
    }

    fn begin_again(&mut self) {
        self.state = None;
        self.left_with.clear();
        self.disk.revive();
        self.start();
        let stored: Vec<u8> = self.known.keys().copied().collect();
        for key in stored {
            self.add(key);
            let found = values_of(&self.units[&key].drive);
            // Read from the disk: it stays.
            for (known, value) in self.known.get_mut(&key).unwrap().iter_mut().zip(found) {
                *known = Known { acknowledged: value, open: Vec::new() };
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(300, 34))]
    #[test]
    fn nothing_acknowledged_is_lost_and_nothing_refused_comes_back(
        ops in proptest::collection::vec(op(), 1..120)
    ) {
        let mut world = World::new();
        for op in ops {
            world.apply(op);
        }
        world.kill(0, Some(0));
        world.restart();
    }
}

/// The drive that is added again has the value, the disk does not.
#[test]
fn a_value_found_again_is_acknowledged_only_when_it_is_safe() {
    let mut world = World::new();
    let kill = Op::Kill { calls: 0, power: None };
    let again = [Op::Panel(1, 0), Op::Remove(1), Op::Add(1), Op::WriteSame(1, 0)];
    for op in [Op::Add(1)].into_iter().chain(again).chain([kill, Op::Restart]) {
        world.apply(op);
    }
    for op in again.into_iter().chain([Op::Writer(1), Op::WriteSame(1, 0), kill]) {
        world.apply(op);
    }
}
