//! `PkwClient` against a slave that does its worst: no wrong value is reported as a success, no job is executed twice,
//! nothing hangs beyond the stated limit.

use crate::long;
use crate::pkw_adversary;

use long::cases;
use pkw_adversary::{Adversary, Corrupted, Exchange};
use profidrive::client::{Images, Job, Outcome, PkwClient, PkwError, Profile, Reply};
use profidrive::devices::ag03::param::{Pnu, Subindex, Value, Width};
use profidrive::profibus::ppo::Pkw;
use profidrive::time::Instant;
use proptest::prelude::*;

/// Few, so that many jobs run out of them and their replies come late.
const EXCHANGES: u32 = 40;

#[derive(Clone, Copy, Debug)]
enum Operation {
    Exchange(Exchange),
    /// Until the present job ends, or some time without one.
    Sound,
    /// So many exchanges whose input images all come late by so many, perhaps more than a job may take.
    Late {
        images: u8,
        exchanges: u8,
    },
    Lose {
        executes: bool,
    },
}

struct Play {
    client: PkwClient,
    slave: Adversary,
    jobs: Vec<Job>,
    /// Number of the last submission, counted from 1.
    submitted: u32,
    exchanges: u32,
    /// Jobs that ended with a reply.
    answered: u32,
    ended: Vec<(u32, Outcome)>,
}

impl Play {
    fn new(profile: Profile, left: Pkw, answered: bool, jobs: Vec<Job>) -> Self {
        let (client, slave) = (PkwClient::new(profile), Adversary::new(left, answered));
        Self { client, slave, jobs, submitted: 0, exchanges: 0, answered: 0, ended: Vec::new() }
    }

    fn submit(&mut self) {
        if self.client.job().is_none() {
            let job = self.jobs[self.submitted as usize % self.jobs.len()];
            self.client.submit(Instant::ZERO, job).unwrap();
            self.submitted += 1;
            self.exchanges = 0;
        }
    }

    fn exchange(&mut self, how: &Exchange) {
        self.submit();
        let output = self.client.output();
        // Only the words of the job itself are the submission; job 0 and probes are not.
        let own = output.pke.pnu() == self.client.job().unwrap().pnu().number() && output != Pkw::ZERO;
        let submission = if own { self.submitted } else { 0 };
        for input in self.slave.exchange(output, submission, how) {
            self.client.handle_input(Instant::ZERO, input);
            self.exchanges += 1;
            self.take_outcome();
            assert!(self.exchanges < EXCHANGES || self.client.job().is_none(), "{EXCHANGES} are the limit");
        }
    }

    fn take_outcome(&mut self) {
        if let Some(outcome) = self.client.poll_outcome() {
            self.check(&outcome);
            self.ended.push((self.submitted, outcome));
        }
    }

    /// What is reported was answered to this very submission.
    fn check(&mut self, outcome: &Outcome) {
        let Outcome { job, result } = outcome;
        let answers = self.slave.answers.get(&self.submitted).cloned().unwrap_or_default();
        let executions = self.slave.executions.get(&self.submitted).copied().unwrap_or(0);
        match result {
            Ok(reply) => {
                self.answered += 1;
                let expected = match *reply {
                    // Word or double word, a command ends with 0.
                    Reply::Value(value) if job.pnu() == pnu(970) => (2, value.bits()),
                    Reply::Value(value) => {
                        let array = job.to_string().contains("sub-index");
                        let ak = match (value.width(), array) {
                            (Width::Word, false) => 1,
                            (Width::Double, false) => 2,
                            (Width::Word, true) => 4,
                            (Width::Double, true) => 5,
                        };
                        (ak, value.bits())
                    }
                    Reply::ElementCount(count) => (6, u32::from(count)),
                    Reply::Description(value) => (3, value),
                };
                assert!(answers.contains(&expected), "{job}: {reply:?} was never answered, but {answers:?}");
                assert_eq!(executions, u32::from(job.is_write()), "{job}");
            }
            Err(PkwError::Refused(code)) => {
                self.answered += 1;
                assert!(answers.contains(&(7, u32::from(code.number()))), "{job}: {code}, but {answers:?}");
            }
            Err(PkwError::NoControlRights | PkwError::TimedOut { .. } | PkwError::Interrupted) => {}
            Err(other) => panic!("{job}: {other} is not checked"),
        }
    }

    fn play(mut self, operations: &[Operation]) -> Self {
        let sound =
            Exchange { look: Some(0), latency: 0, held_back: 0, torn: None, corrupted: None, written: None };
        for operation in operations {
            match operation {
                Operation::Exchange(how) => self.exchange(how),
                Operation::Sound => {
                    let before = self.ended.len();
                    while self.ended.len() == before {
                        self.exchange(&sound);
                    }
                }
                Operation::Late { images, exchanges } => {
                    for _ in 0..*exchanges {
                        self.exchange(&Exchange { held_back: *images, ..sound });
                    }
                }
                Operation::Lose { executes } => {
                    self.slave.lose_data_exchange(*executes);
                    self.client.handle_data_exchange_lost();
                    self.take_outcome();
                }
            }
        }
        // However it was treated before, a sound drive is understood again: the first job may still run out of
        // exchanges.
        let before = self.answered;
        for _ in 0..4 * EXCHANGES {
            self.exchange(&sound);
        }
        assert!(self.answered > before, "{:?}", self.ended);
        for (submission, outcome) in &self.ended {
            let executions = self.slave.executions.get(submission).copied().unwrap_or(0);
            assert!(executions <= 1, "{outcome:?} was executed {executions} times");
            if outcome.result.is_err_and(PkwError::is_certain) {
                assert_eq!(executions, 0, "{outcome:?}");
            }
        }
        self
    }
}

fn pnu(number: u16) -> Pnu {
    Pnu::new(number).unwrap()
}

/// Few parameters and few values, so that replies to different jobs look alike.
fn job() -> impl Strategy<Value = Job> {
    let word = prop_oneof![Just(1000), Just(1001)];
    let double = prop_oneof![Just(1016), Just(1017)];
    prop_oneof![
        3 => word.clone().prop_map(|number| Job::read(pnu(number)).expecting(Width::Word)),
        3 => double.clone().prop_map(|number| Job::read(pnu(number)).expecting(Width::Double)),
        3 => (word, prop_oneof![Just(5), Just(100), Just(2000)])
            .prop_map(|(number, value)| Job::write(pnu(number), Value::Word(value))),
        3 => (double, prop_oneof![Just(5), Just(0x5_0000)])
            .prop_map(|(number, value)| Job::write(pnu(number), Value::Double(value))),
        2 => (0..4_u8).prop_map(|element| Job::read_element(pnu(945), Subindex(element)).expecting(Width::Word)),
        1 => Just(Job::element_count(pnu(945))),
        2 => Just(Job::write(pnu(970), Value::Word(5))),
        1 => Just(Job::read(pnu(918)).expecting(Width::Word)),
        1 => Just(Job::write(pnu(961), Value::Word(5))),
        1 => Just(Job::read(pnu(7)).expecting(Width::Word)),
    ]
}

fn exchange(torn: bool) -> impl Strategy<Value = Exchange> {
    let torn = if torn { proptest::option::weighted(0.5, 0..16_u8).boxed() } else { Just(None).boxed() };
    (
        proptest::option::weighted(0.8, 0..3_u8),
        prop_oneof![4 => 0..2_u8, 1 => 2..60_u8],
        prop_oneof![8 => 0..2_u8, 2 => 2..12_u8, 1 => 12..120_u8],
        torn,
        proptest::option::weighted(
            0.1,
            prop_oneof![Just(Corrupted::Ak), Just(Corrupted::Pnu), Just(Corrupted::Ind)],
        ),
        proptest::option::weighted(0.15, (0..5_u8, 0..4_u16)),
    )
        .prop_map(|(look, latency, held_back, torn, corrupted, written)| Exchange {
            look,
            latency,
            held_back,
            torn,
            corrupted,
            written,
        })
}

fn operations(torn: bool) -> impl Strategy<Value = Vec<Operation>> {
    let operation = prop_oneof![
        60 => exchange(torn).prop_map(Operation::Exchange),
        2 => Just(Operation::Sound),
        1 => (1..120_u8, any::<u8>()).prop_map(|(images, exchanges)| Operation::Late { images, exchanges }),
        1 => any::<bool>().prop_map(|executes| Operation::Lose { executes }),
    ];
    proptest::collection::vec(operation, 1..400)
}

/// What another master left in the drive: a job of the same kind as ours.
fn left() -> impl Strategy<Value = Pkw> {
    let words =
        [0_u32, 0x1396_0000, 0x13C1_0000, 0x13E8_0000, 0x23E8_0000, 0x33F8_0000, 0x23CA_0000, 0x63B1_0100];
    (0..words.len(), 0..6_u32).prop_map(move |(which, value)| {
        let [a, b, c, d] = words[which].to_be_bytes();
        let [e, f, g, h] = value.to_be_bytes();
        Pkw::from_octets([a, b, c, d, e, f, g, h])
    })
}

proptest! {
    #![proptest_config(cases(1000, 200))]

    #[test]
    fn nothing_wrong_is_believed_and_nothing_done_twice_with_torn_images(
        operations in operations(true), jobs in proptest::collection::vec(job(), 1..12),
        left in left(), answered: bool,
    ) {
        let profile = Profile { exchanges: EXCHANGES, ..Profile::AG03 };
        Play::new(profile, left, answered, jobs).play(&operations);
    }

    #[test]
    fn nor_with_whole_images_of_which_one_is_enough(
        operations in operations(false), jobs in proptest::collection::vec(job(), 1..12),
        left in left(), answered: bool,
    ) {
        let profile = Profile { exchanges: EXCHANGES, images: Images::Consistent, ..Profile::AG03 };
        Play::new(profile, left, answered, jobs).play(&operations);
    }
}
