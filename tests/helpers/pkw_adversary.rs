//! A slave's end of the parameter channel that does its worst, as far as the guarantees of `PkwClient` allow it.
//!
//! Between client and slave lie two queues of images, in order, of any length. The slave looks at some of the images,
//! takes a job, answers it after any time, and goes on with what it sees then. Meanwhile others change the values,
//! images are torn, replies carry a wrong AK, PNU or IND, and Data_Exchange is lost and comes back.
//!
//! Each output image carries the number of the submission it was made for, so that the slave can keep books: which
//! submission was executed how often, and what was truly answered to it.

use std::collections::{HashMap, HashSet, VecDeque};

use profidrive::profibus::ppo::{Ind, JobId, Pke, Pkw, ReplyId};

/// What a parameter is.
#[derive(Clone, Debug)]
pub(crate) enum Parameter {
    Word(u16),
    Double(u32),
    Array(Vec<u16>),
    /// Written as a command, 0 afterwards, confirmed as a double word (PNU 970 of the AG03/1).
    Command,
    ReadOnly(u16),
}

/// What the adversary does with one exchange.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exchange {
    /// How many of the waiting output images the slave passes over at most before it looks at one; `None`: it does
    /// not look.
    pub(crate) look: Option<u8>,
    /// How many looks a job taken now waits for its reply.
    pub(crate) latency: u8,
    /// How many input images are held back.
    pub(crate) held_back: u8,
    /// Whether an image in which something changes mixes old and new words, and which are old.
    pub(crate) torn: Option<u8>,
    /// How the answer of a job taken now is corrupted, if it is.
    pub(crate) corrupted: Option<Corrupted>,
    /// Another writes this into a parameter.
    pub(crate) written: Option<(u8, u16)>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Corrupted {
    Ak,
    Pnu,
    Ind,
}

/// The slave and both queues.
pub(crate) struct Adversary {
    parameters: HashMap<u16, Parameter>,
    outputs: VecDeque<(Pkw, u32)>,
    inputs: VecDeque<Pkw>,
    taken: (Pkw, u32),
    waiting: Option<u8>,
    corrupted: Option<Corrupted>,
    shown: Pkw,
    /// The last image was torn; the next is whole.
    was_torn: bool,
    published: Pkw,
    /// How often each submission was executed.
    pub(crate) executions: HashMap<u32, u32>,
    /// What was answered to each submission: AK and PWE.
    pub(crate) answers: HashMap<u32, HashSet<(u8, u32)>>,
}

impl Adversary {
    /// A slave that another master has left with this job, perhaps not answered yet.
    pub(crate) fn new(left: Pkw, answered: bool) -> Self {
        let parameters = [
            (1000, Parameter::Word(100)),
            (1001, Parameter::Word(5)),
            (1016, Parameter::Double(1_000_000)),
            (1017, Parameter::Double(0xFFFF_0001)),
            (945, Parameter::Array(vec![0x41, 0x42, 0x43])),
            (970, Parameter::Command),
            (918, Parameter::ReadOnly(5)),
            (961, Parameter::ReadOnly(3)),
        ];
        let mut slave = Self {
            parameters: parameters.into_iter().collect(),
            outputs: VecDeque::new(),
            inputs: VecDeque::new(),
            taken: (left, 0),
            waiting: Some(3),
            corrupted: None,
            shown: Pkw::ZERO,
            was_torn: false,
            published: Pkw::ZERO,
            executions: HashMap::new(),
            answers: HashMap::new(),
        };
        if answered {
            slave.waiting = None;
            slave.run();
            slave.published = slave.shown;
        }
        slave
    }

    /// One exchange: an output image goes out, input images come back as far as they are not held back.
    pub(crate) fn exchange(&mut self, output: Pkw, submission: u32, how: &Exchange) -> Vec<Pkw> {
        self.outputs.push_back((output, submission));
        if let Some((which, value)) = how.written {
            self.write_by_others(which, value);
        }
        if let Some(passed) = how.look {
            for _ in 0..usize::from(passed).min(self.outputs.len() - 1) {
                self.outputs.pop_front();
            }
            let seen = *self.outputs.front().unwrap();
            if self.outputs.len() > 1 {
                self.outputs.pop_front();
            }
            self.cycle(seen, how);
        }
        self.publish(how);
        let arrived = self.inputs.len().saturating_sub(usize::from(how.held_back));
        self.inputs.drain(..arrived).collect()
    }

    /// Data_Exchange was left. A job that waits may still be executed, nothing is answered any more.
    pub(crate) fn lose_data_exchange(&mut self, executes: bool) {
        if executes && self.waiting.is_some() {
            self.run();
        }
        self.outputs.clear();
        self.inputs.clear();
        self.taken = (Pkw::ZERO, 0);
        self.waiting = None;
        self.corrupted = None;
        self.shown = Pkw::ZERO;
        self.published = Pkw::ZERO;
        self.was_torn = false;
    }

    /// One job at a time, in the order seen; a job is new if its words differ from the last.
    fn cycle(&mut self, seen: (Pkw, u32), how: &Exchange) {
        match self.waiting {
            Some(0) => {
                self.waiting = None;
                self.run();
            }
            Some(cycles) => self.waiting = Some(cycles - 1),
            None if seen.0 != self.taken.0 => {
                self.taken = seen;
                self.corrupted = how.corrupted;
                self.waiting = Some(how.latency);
            }
            None if matches!(seen.0.pke.job(), JobId::Read | JobId::ReadElement) => {
                // A held read follows the value.
                self.run();
            }
            None => {}
        }
    }

    fn run(&mut self) {
        let (job, submission) = self.taken;
        let (reply, executed) = self.execute(job);
        if submission != 0 {
            self.answers.entry(submission).or_default().insert((reply.pke.ak(), reply.double_word()));
            if executed {
                *self.executions.entry(submission).or_default() += 1;
            }
        }
        let pke = reply.pke.raw();
        self.shown = match self.corrupted {
            // An error that poses as a value cannot be found out, nor a value that poses as an error be wrong.
            Some(Corrupted::Ak) if (1..=5).contains(&reply.pke.ak()) => {
                let wrong = [0, 2, 1, 4, 5, 4][usize::from(reply.pke.ak())];
                Pkw { pke: Pke::from_raw(pke & 0x0FFF | wrong << 12), ..reply }
            }
            // Not one that a probe may be about: an answer to nobody's question cannot be found out.
            Some(Corrupted::Pnu) if reply.pke.ak() != 0 => {
                let other = if (900..1000).contains(&reply.pke.pnu()) { 0x400 } else { 1 };
                Pkw { pke: Pke::from_raw(pke ^ other), ..reply }
            }
            Some(Corrupted::Ind) => Pkw { ind: Ind::from_raw(reply.ind.raw() ^ 0x0100), ..reply },
            Some(Corrupted::Ak | Corrupted::Pnu) | None => reply,
        };
    }

    fn execute(&mut self, job: Pkw) -> (Pkw, bool) {
        let reply = |id, pwe| Pkw::new(Pke::of_reply(id, job.pke.pnu()), job.ind, pwe);
        let error = |number| (reply(ReplyId::NotExecutable, number), false);
        let index = usize::from(job.ind.high_octet());
        match (job.pke.job(), self.parameters.get_mut(&job.pke.pnu())) {
            (JobId::NoJob, _) => (Pkw::ZERO, false),
            (_, None) => error(0),
            (JobId::Read, Some(Parameter::Word(value) | Parameter::ReadOnly(value))) => {
                (reply(ReplyId::Word, u32::from(*value)), false)
            }
            (JobId::Read, Some(Parameter::Double(value))) => (reply(ReplyId::DoubleWord, *value), false),
            (JobId::WriteWord, Some(Parameter::Word(value))) if job.word() <= 1000 => {
                *value = job.word();
                (reply(ReplyId::Word, u32::from(*value)), true)
            }
            (JobId::WriteWord, Some(Parameter::Word(_))) => error(2),
            (JobId::WriteWord, Some(Parameter::Command)) => (reply(ReplyId::DoubleWord, 0), true),
            (JobId::WriteDoubleWord, Some(Parameter::Double(value))) => {
                *value = job.double_word();
                (reply(ReplyId::DoubleWord, *value), true)
            }
            (JobId::ReadElement, Some(Parameter::Array(values))) => match values.get(index) {
                Some(value) => (reply(ReplyId::ElementWord, u32::from(*value)), false),
                None => error(3),
            },
            (JobId::ReadElementCount, Some(Parameter::Array(values))) => {
                (reply(ReplyId::ElementCount, values.len() as u32), false)
            }
            (JobId::WriteWord | JobId::WriteDoubleWord, Some(Parameter::ReadOnly(_))) => error(1),
            (_, Some(_)) => error(5),
        }
    }

    fn write_by_others(&mut self, which: u8, written: u16) {
        match self.parameters.get_mut(&[1000, 1001, 1016, 1017, 945][usize::from(which) % 5]).unwrap() {
            Parameter::Word(value) => *value = written,
            // Both words change. The high one must not come back with the next image: a torn image between two equal
            // ones looks like a whole one (`Images::MayBeTorn`).
            Parameter::Double(value) => *value = value.wrapping_add(0x7FFF * (1 + u32::from(written))),
            Parameter::Array(values) => values[1] = written,
            Parameter::Command | Parameter::ReadOnly(_) => {}
        }
    }

    fn publish(&mut self, how: &Exchange) {
        let (old, new) = (self.published, self.shown);
        let mut image = new;
        if let Some(which) = how.torn.filter(|_| old != new && !self.was_torn) {
            let pick = |n: u8| which >> n & 1 == 1;
            image = Pkw {
                pke: if pick(0) { old.pke } else { new.pke },
                ind: if pick(1) { old.ind } else { new.ind },
                pwe_high: if pick(2) { old.pwe_high } else { new.pwe_high },
                pwe_low: if pick(3) { old.pwe_low } else { new.pwe_low },
            };
            self.was_torn = true;
        } else {
            self.was_torn = false;
        }
        self.published = new;
        self.inputs.push_back(image);
    }
}
