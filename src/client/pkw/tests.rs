use std::collections::VecDeque;

use core::time::Duration;

use super::*;
use crate::devices::ag03::param::live::live;
use crate::devices::ag03::param::{Gear, Model, Pnu, Reading, Store, Subindex, Value, Width};
use crate::profibus::pkw;
use crate::profibus::pkw::{Config, Engine, ErrorNumber, JobError, Parameters};
use crate::profibus::ppo::{Ind, Pke};

/// A drive that shows something.
struct Drive {
    store: Store,
    position: i32,
}

impl Parameters for Drive {
    fn read(&self, pnu: u16, element: Option<u8>) -> Result<pkw::Value, JobError> {
        let show = |reading, element| {
            if reading == Reading::Position { self.position } else { live(reading, element) }
        };
        Ok(self.store.read(Pnu::from_low_bits(pnu), element.map(Subindex), show)?.into())
    }

    fn write(&mut self, pnu: u16, element: Option<u8>, value: pkw::Value) -> Result<pkw::Written, JobError> {
        Parameters::write(&mut self.store, pnu, element, value)
    }

    fn elements(&self, pnu: u16) -> Result<Option<u8>, JobError> {
        self.store.elements(pnu)
    }
}

/// From PNU 918 to 999.
const PROBES: usize = 82;

fn pnu(number: u16) -> Pnu {
    Pnu::new(number).unwrap()
}

/// A PKW as the manuals print it.
fn pkw(text: &str) -> Pkw {
    let words: Vec<u16> = text.split(' ').map(|word| u16::from_str_radix(word, 16).unwrap()).collect();
    let [pke, ind, pwe_high, pwe_low] = words[..] else { panic!("{text}") };
    Pkw { pke: Pke::from_raw(pke), ind: Ind::from_raw(ind), pwe_high, pwe_low }
}

/// A client, the drive's end of the channel, and what went over it.
struct Line {
    client: PkwClient,
    engine: Engine,
    drive: Drive,
    sent: Vec<String>,
    exchanges: usize,
}

impl Line {
    fn new(model: Model, profile: Profile, latency: u16) -> Self {
        Self {
            client: PkwClient::new(profile),
            engine: Engine::new(Config { latency, ..Config::default() }),
            drive: Drive { store: Store::new(model, Gear::Ratio48), position: -5000 },
            sent: Vec::new(),
            exchanges: 0,
        }
    }

    fn exchange(&mut self, reply: Pkw) -> Pkw {
        let job = self.client.output();
        if self.sent.last() != Some(&job.to_string()) {
            self.sent.push(job.to_string());
        }
        self.client.handle_input(Instant::ZERO, reply);
        self.exchanges += 1;
        self.engine.cycle(job, &mut self.drive).reply
    }

    fn run(&mut self, job: Job) -> Result<Reply, PkwError> {
        self.sent.clear();
        self.exchanges = 0;
        self.client.submit(Instant::ZERO, job).unwrap();
        // The inputs of an exchange were ready before its outputs came.
        let mut reply = self.engine.cycle(self.client.output(), &mut self.drive).reply;
        loop {
            reply = self.exchange(reply);
            if let Some(outcome) = self.client.poll_outcome() {
                assert_eq!(outcome.job, job);
                return outcome.result;
            }
        }
    }
}

#[test]
fn every_kind_of_job_in_the_words_of_each_profile() {
    let word = Value::Word(5);
    let double = Value::of(Width::Double, -1600);
    let third = Subindex(3);
    for (job, profile, expected) in [
        (Job::read(pnu(1018)), Profile::AG03, "13FA 0000 0000 0000"),
        (Job::write(pnu(970), word), Profile::AG03, "23CA 0000 0000 0005"),
        (Job::write(pnu(1019), double), Profile::AG03, "33FB 0000 FFFF F9C0"),
        (Job::description(pnu(1016), third), Profile::AG03, "43F8 0300 0000 0000"),
        (Job::read_element(pnu(945), third), Profile::AG03, "63B1 0300 0000 0000"),
        (Job::write_element(pnu(945), third, word), Profile::AG03, "73B1 0300 0000 0005"),
        (Job::write_element(pnu(945), third, double), Profile::AG03, "83B1 0300 FFFF F9C0"),
        (Job::element_count(pnu(945)), Profile::AG03, "93B1 0000 0000 0000"),
        (Job::write(pnu(970), word).to_memory(Memory::Permanent), Profile::AG03, "23CA 0000 0000 0005"),
        (Job::read_element(pnu(945), third), Profile::SIMODRIVE_611U, "63B1 0003 0000 0000"),
        (Job::read_element(pnu(945), third), Profile::WITHOUT_ARRAY_JOBS, "13B1 0300 0000 0000"),
        (Job::write_element(pnu(945), third, word), Profile::WITHOUT_ARRAY_JOBS, "23B1 0300 0000 0005"),
        (Job::read(pnu(1018)), Profile::SINAMICS_G120, "63FA 0000 0000 0000"),
        (Job::write(pnu(1019), double), Profile::SINAMICS_G120, "83FB 0000 FFFF F9C0"),
        (Job::write(pnu(970), word), Profile::MASTERDRIVES, "23CA 0000 0000 0005"),
        (
            Job::write(pnu(970), word).to_memory(Memory::Volatile),
            Profile::MASTERDRIVES,
            "23CA 0000 0000 0005",
        ),
        (
            Job::write(pnu(970), word).to_memory(Memory::Permanent),
            Profile::MASTERDRIVES,
            "E3CA 0000 0000 0005",
        ),
        (
            Job::write(pnu(970), double).to_memory(Memory::Permanent),
            Profile::MASTERDRIVES,
            "D3CA 0000 FFFF F9C0",
        ),
        (
            Job::write_element(pnu(945), third, word).to_memory(Memory::Permanent),
            Profile::MASTERDRIVES,
            "C3B1 0300 0000 0005",
        ),
        (
            Job::write_element(pnu(945), third, double).to_memory(Memory::Volatile),
            Profile::NORD,
            "B3B1 0300 FFFF F9C0",
        ),
    ] {
        assert_eq!(job.request(&profile).unwrap().to_string(), expected, "{job}");
    }
    for (job, profile) in [
        (Job::write(pnu(970), word).to_memory(Memory::Volatile), Profile::AG03),
        (Job::write(pnu(970), word).to_memory(Memory::Permanent), Profile::PROFIDRIVE),
        (Job::element_count(pnu(945)), Profile::WITHOUT_ARRAY_JOBS),
    ] {
        let refused = PkwClient::new(profile).submit(Instant::ZERO, job);
        assert_eq!(refused, Err(NotSubmitted::NoSuchJob { job }));
    }
}

#[test]
fn every_kind_of_job_brings_what_the_drive_has() {
    let mut line = Line::new(Model::Ag03_1, Profile::AG03, 0);
    let word = |number| Ok(Reply::Value(Value::Word(number)));
    let double = |number| Ok(Reply::Value(Value::of(Width::Double, number)));
    let refused = |number| Err(PkwError::Refused(ErrorCode::Known(number)));
    for (job, result) in [
        (Job::read(pnu(1004)), word(30)),
        (Job::read(pnu(1036)).expecting(Width::Double), double(-5000)),
        (Job::write(pnu(1016), Value::of(Width::Double, 250_000)), double(250_000)),
        (Job::write(pnu(1016), Value::of(Width::Double, 250_000)), double(250_000)),
        (Job::read(pnu(1016)), double(250_000)),
        (Job::read_element(pnu(945), Subindex(0)), word(0x47)),
        (Job::read_element(pnu(945), Subindex(1)), word(0x46)),
        (Job::element_count(pnu(945)), Ok(Reply::ElementCount(10))),
        (Job::read_element(pnu(945), Subindex(10)), refused(ErrorNumber::FaultySubindex)),
        (Job::write(pnu(970), Value::Word(5)), word(0).map(|_| Reply::Value(Value::Double(0)))),
        (Job::write(pnu(1003), Value::Word(101)), refused(ErrorNumber::LimitExceeded)),
        (Job::description(pnu(1003), Subindex(1)), refused(ErrorNumber::NoDescription)),
        (Job::read(pnu(999)), refused(ErrorNumber::IllegalParameterNumber)),
        (Job::write(pnu(918), Value::Word(5)), refused(ErrorNumber::NotChangeable)),
    ] {
        assert_eq!(line.run(job), result, "{job}");
    }
    let mut line = Line::new(Model::Ag03, Profile::AG03, 3);
    assert_eq!(line.run(Job::write(pnu(970), Value::Word(5))), word(0), "an AG03 confirms with a word");
}

#[test]
fn the_first_job_waits_for_the_probe_and_the_next_ones_for_what_they_need() {
    let mut line = Line::new(Model::Ag03_1, Profile::AG03, 0);
    let zero = "0000 0000 0000 0000";
    line.run(Job::read(pnu(1004))).unwrap();
    assert_eq!(line.sent, [zero, "1396 0000 0000 0000", "13EC 0000 0000 0000"]);
    line.run(Job::read(pnu(1005))).unwrap();
    assert_eq!(line.sent, ["13ED 0000 0000 0000"], "another parameter: at once");
    line.run(Job::read(pnu(1005))).unwrap();
    assert_eq!(line.sent, [zero, "13ED 0000 0000 0000"], "the same one: job 0 first");
    line.client.handle_data_exchange_lost();
    line.run(Job::read(pnu(918))).unwrap();
    assert_eq!(line.sent, [zero, "1397 0000 0000 0000", "1396 0000 0000 0000"], "the other probe");
}

#[test]
fn a_reply_that_is_later_than_a_job_may_take_is_not_taken_for_the_reply_to_the_next() {
    const LATE: usize = 45;
    // Nothing, and what another master has read last: the parameter of the first probe.
    for left in [Pkw::ZERO, pkw("1396 0000 0000 0005")] {
        let profile = Profile { exchanges: 40, images: Images::Consistent, ..Profile::AG03 };
        let mut line = Line::new(Model::Ag03_1, profile, 0);
        let mut under_way: VecDeque<Pkw> = [left; LATE].into();
        under_way[0] = Pkw::ZERO;
        // Each exchange has its own position, so that a value tells when it was read.
        let mut now = 0;
        for _ in 0..2 * PROBES {
            line.client.submit(Instant::ZERO, Job::read(pnu(1036)).expecting(Width::Double)).unwrap();
            let submitted = now;
            let outcome = loop {
                now += 1;
                line.drive.position = now;
                let reply = line.engine.cycle(line.client.output(), &mut line.drive).reply;
                under_way.push_back(reply);
                line.client.handle_input(Instant::ZERO, under_way.pop_front().unwrap());
                if let Some(outcome) = line.client.poll_outcome() {
                    break outcome;
                }
            };
            if let Ok(Reply::Value(value)) = outcome.result {
                assert!(
                    value.bits() > submitted.unsigned_abs(),
                    "at {submitted}, but the value is {value:?}"
                );
            }
        }
    }
}

#[test]
fn a_job_without_reply_ends_by_exchanges_or_by_time_and_says_what_it_saw() {
    let profile = Profile { exchanges: 10, time: Duration::from_secs(1), ..Profile::AG03 };
    let mut client = PkwClient::new(profile);
    let job = Job::read(pnu(1018));
    client.submit(Instant::ZERO, job).unwrap();
    assert_eq!(client.submit(Instant::ZERO, job), Err(NotSubmitted::Busy));
    assert_eq!(client.poll_timeout(), Some(Instant::from_millis(1000)));
    for _ in 0..10 {
        assert_eq!(client.poll_outcome(), None);
        client.handle_input(Instant::ZERO, pkw("13EC 0000 0000 001E"));
    }
    let error = client.poll_outcome().unwrap().result.unwrap_err();
    assert!(error.is_certain());
    assert_eq!(
        error.to_string(),
        "the empty reply to job 0, before the job was sent, did not come within 10 exchanges; \
         the last PKW was 13EC 0000 0000 001E (word, PNU 1004)"
    );

    client.submit(Instant::ZERO, job).unwrap();
    client.handle_timeout(Instant::from_millis(999));
    assert_eq!(client.poll_outcome(), None);
    client.handle_timeout(Instant::from_millis(1000));
    let error = client.poll_outcome().unwrap().result.unwrap_err();
    assert_eq!(
        error.to_string(),
        "the empty reply to job 0, before the job was sent, did not come within 1s; there was no input image at all"
    );
    assert_eq!(client.poll_timeout(), None);
}
