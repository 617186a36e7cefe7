//! Jobs of any kind against the parameter channel: documented replies only, each job carried out once, a refused job
//! changes nothing, a written value is read back, every value stays in its range.

use arbitrary::{Arbitrary, Unstructured};
use profidrive::devices::ag03::param::{
    Effect, Gear, Kind, Model, Parameter, Pnu, Store, Subindex, Value, WriteContext, parameters,
};
use profidrive::profibus::pkw;
use profidrive::profibus::pkw::{Config, Engine, JobError, Parameters};
use profidrive::profibus::ppo::{JobId, Pkw, ReplyId};

#[derive(Arbitrary, Debug)]
struct Session {
    ag03: bool,
    ratio_24: bool,
    latency: u8,
    steps: Vec<Step>,
}

#[derive(Arbitrary, Debug)]
enum Step {
    /// Any words.
    Words { octets: [u8; 8], cycles: u8, moving: bool, job_active: bool },
    /// A job for a parameter that exists.
    Job { ak: u8, parameter: u8, subindex: u8, value: u32, cycles: u8, moving: bool, job_active: bool },
    /// Data_Exchange left and entered again.
    Reset,
}

/// The parameters of a drive that is doing something.
struct Drive {
    store: Store,
    context: WriteContext,
    effects: u32,
}

impl Parameters for Drive {
    fn read(&self, pnu: u16, element: Option<u8>) -> Result<pkw::Value, JobError> {
        Parameters::read(&self.store, pnu, element)
    }

    fn write(&mut self, pnu: u16, element: Option<u8>, value: pkw::Value) -> Result<pkw::Written, JobError> {
        let write = self.store.meaning(Pnu::from_low_bits(pnu), element.map(Subindex), value.into())?;
        self.effects += u32::from(self.store.apply(write, &self.context)? != Effect::None);
        Ok(pkw::Written::at_once(value))
    }

    fn elements(&self, pnu: u16) -> Result<Option<u8>, JobError> {
        self.store.elements(pnu)
    }
}

pub(crate) fn check(data: &[u8]) {
    let Ok(session) = Session::arbitrary_take_rest(Unstructured::new(data)) else { return };
    let model = if session.ag03 { Model::Ag03 } else { Model::Ag03_1 };
    let gear = if session.ratio_24 { Gear::Ratio24 } else { Gear::Ratio48 };
    let mut drive = Drive { store: Store::new(model, gear), context: WriteContext::default(), effects: 0 };
    let latency = u16::from(session.latency % 8);
    let mut engine = Engine::new(Config { latency, ..Config::default() });
    let numbers: Vec<u16> = parameters(model).map(|entry| entry.pnu.number()).collect();
    for step in session.steps.iter().take(200) {
        let (job, cycles, context) = match *step {
            Step::Reset => {
                engine.reset();
                continue;
            }
            Step::Words { octets, cycles, moving, job_active } => {
                (Pkw::from_octets(octets), cycles, WriteContext { moving, job_active })
            }
            Step::Job { ak, parameter, subindex, value, cycles, moving, job_active } => {
                let number = numbers[usize::from(parameter) % numbers.len()];
                let [high, low] = (u16::from(ak) << 12 | number).to_be_bytes();
                let [a, b, c, d] = value.to_be_bytes();
                let octets = [high, low, subindex, 0, a, b, c, d];
                (Pkw::from_octets(octets), cycles, WriteContext { moving, job_active })
            }
        };
        drive.context = context;
        hold(&mut engine, &mut drive, job, cycles);
        for parameter in Parameter::all() {
            let range = drive.store.range(parameter);
            let value = drive.store.value(parameter);
            let none = parameter == Parameter::DPos && model == Model::Ag03;
            assert!(none || range.contains(value), "{parameter:?} = {value}");
        }
    }
}

/// Holds a job for some cycles, as a master does.
fn hold(engine: &mut Engine, drive: &mut Drive, job: Pkw, cycles: u8) {
    drive.effects = 0;
    let mut refusals = 0;
    for _ in 0..=cycles % 32 {
        let before = drive.store.clone();
        let outcome = engine.cycle(job, drive);
        match outcome.reply.pke.reply() {
            ReplyId::NoReply => assert_eq!(outcome.reply, Pkw::ZERO),
            ReplyId::Reserved(_) => panic!("{}", outcome.reply),
            _ => {}
        }
        assert!(!outcome.reply.pke.spm(), "spontaneous messages do not exist");
        if let Some(refusal) = outcome.refusal {
            refusals += 1;
            assert_eq!(outcome.reply.pke.reply(), ReplyId::NotExecutable);
            assert_eq!(outcome.reply.pke.pnu(), refusal.job.pke.pnu());
            assert_eq!(outcome.reply.word(), refusal.number.number());
            assert_eq!(values(&before), values(&drive.store), "a refused job changed something");
        }
        if !engine.has_work(job) {
            check_written(job, outcome.reply, &drive.store);
        }
        let reads = matches!(job.pke.job(), JobId::Read | JobId::ReadElement);
        if reads && !engine.has_work(job) {
            assert_eq!(values(&before), values(&drive.store), "a read changed something");
        }
    }
    // One job that was waiting and the one held.
    assert!(drive.effects <= 2, "{} effects of one job", drive.effects);
    assert!(refusals <= 2, "{refusals} refusals of one job");
}

/// A write that was acknowledged is echoed, and reads as written.
fn check_written(job: Pkw, reply: Pkw, store: &Store) {
    let written = match (job.pke.job(), reply.pke.reply()) {
        (JobId::WriteWord, ReplyId::Word) => Value::Word(job.word()),
        (JobId::WriteDoubleWord, ReplyId::DoubleWord) => Value::Double(job.double_word()),
        _ => return,
    };
    assert_eq!(reply.pke.pnu(), job.pke.pnu());
    let pnu = Pnu::from_low_bits(job.pke.pnu());
    match store.entry(pnu).map(|entry| entry.kind) {
        Ok(Kind::Setting(_)) => assert_eq!(store.read(pnu, None, |_, _| 0), Ok(written), "{job}"),
        Ok(Kind::LoadParameterSet) => assert!((1..=5).contains(&job.word())),
        other => panic!("{job} was acknowledged: {other:?}"),
    }
}

fn values(store: &Store) -> Vec<i32> {
    Parameter::all().map(|parameter| store.value(parameter)).collect()
}
