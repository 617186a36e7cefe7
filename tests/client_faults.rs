//! The clients against the emulated drives under stress: `PkwClient` behind a link that spoils telegrams, `DriveClient`
//! over images that are late by any time while the world around the drive changes.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a test may panic, and has std"
)]
#![cfg(feature = "std")]

mod common;

use std::collections::VecDeque;
use std::time::Duration;

use common::{CFG, IDENT, Line, MASTER, SLAVE, telegram};
use profidrive::client::{
    DriveClient, Goal, GoalError, GoalOutcome, Images, Job, Limits, PkwClient, PkwError, Profile, Reply,
};
use profidrive::device::{Config, Device, MAX_TELEGRAM_LEN, Timing};
use profidrive::drive::{Direction, Fault, Inputs};
use profidrive::fdl::telegram::{Decoded, decode};
use profidrive::fdl::{Address, FrameCount, FunctionCode, Service, Telegram};
use profidrive::host::link::fault::Faulty;
use profidrive::host::link::memory::{End, Wire};
use profidrive::host::{Clock, Link, ManualClock, Received};
use profidrive::param::{Model, Parameter, Pnu, Subindex, Value, Width};
use profidrive::ppo::{self, Outputs, Stw};
use profidrive::time::Instant;
use proptest::prelude::*;

fn cases(default: u32) -> ProptestConfig {
    let long = std::env::var_os("PROFIDRIVE_LONG").is_some();
    ProptestConfig { cases: if long { 50 * default } else { default }, ..ProptestConfig::default() }
}

fn model() -> impl Strategy<Value = Model> {
    prop_oneof![Just(Model::Ag03), Just(Model::Ag03_1)]
}

fn config(model: Model) -> Config {
    Config { model, ..Config::new(Address::station(SLAVE).unwrap()) }
}

/// A drive behind a link with faults, and a master that repeats what is not answered.
struct Spoilt {
    master: End,
    link: Faulty<End, ManualClock>,
    device: Device,
    clock: ManualClock,
    count: FrameCount,
}

impl Spoilt {
    fn new(model: Model, faults: &[String]) -> Self {
        let (wire, clock) = (Wire::new(), ManualClock::new());
        let faults: Vec<_> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
        let device = Device::new(config(model), clock.now());
        let (master, link) = (wire.end(), Faulty::new(wire.end(), clock.clone(), &faults));
        let mut line = Self { master, link, device, clock, count: FrameCount::First };
        for (sap, data) in [(61, &[0x80, 1, 1, 11, IDENT[0], IDENT[1], 0][..]), (62, &CFG)] {
            while line.ask(Some(sap), data) != Some(Vec::new()) {}
        }
        line
    }

    /// The data of the reply, after up to three repetitions.
    fn ask(&mut self, dsap: Option<u8>, data: &[u8]) -> Option<Vec<u8>> {
        let octets = telegram(SLAVE, MASTER, FunctionCode::request(Service::SrdHigh, self.count), dsap, data);
        let reply = (0..4).find_map(|_| self.send(&octets))?;
        self.count = match self.count {
            FrameCount::Even => FrameCount::Odd,
            FrameCount::First | FrameCount::Odd | FrameCount::Unused => FrameCount::Even,
        };
        Some(reply)
    }

    /// One request and half a millisecond for its reply.
    fn send(&mut self, octets: &[u8]) -> Option<Vec<u8>> {
        self.master.send(octets).unwrap();
        let (mut buf, mut telegram) = ([0; 600], [0; MAX_TELEGRAM_LEN]);
        for _ in 0..10 {
            self.clock.advance(Duration::from_micros(50));
            let now = self.clock.now();
            if let Received::Octets(count) = self.link.receive(&mut buf).unwrap() {
                self.device.handle_bytes(now, &buf[..count]);
            }
            self.device.handle_timeout(now);
            if let Some(octets) = self.device.poll_transmit(now, &mut telegram) {
                self.link.send(octets).unwrap();
            }
            while self.device.poll_event().is_some() {}
        }
        let Received::Octets(count) = self.master.receive(&mut buf).unwrap() else { return None };
        match decode(&buf[..count]) {
            Decoded::Telegram { telegram: Telegram::Data(data), len } if len == count => {
                Some(data.data.to_vec())
            }
            Decoded::Telegram { telegram: Telegram::ShortAcknowledge, len: 1 } if count == 1 => {
                Some(Vec::new())
            }
            _ => None,
        }
    }

    fn run(&mut self, client: &mut PkwClient, job: Job) -> Result<Reply, PkwError> {
        client.submit(self.clock.now(), job).unwrap();
        let deadline = client.poll_timeout().unwrap();
        loop {
            let outputs = Outputs::octets(client.output(), Stw::default(), 0);
            match self.ask(None, &outputs) {
                Some(inputs) => {
                    client.handle_input(self.clock.now(), ppo::Inputs::parse(&inputs).unwrap().pkw());
                }
                None => client.handle_timeout(self.clock.now()),
            }
            if let Some(outcome) = client.poll_outcome() {
                return outcome.result;
            }
            assert!(self.clock.now() < deadline, "{job} hangs");
        }
    }
}

fn fault() -> impl Strategy<Value = String> {
    let kind = prop_oneof![
        (1..6_u8).prop_map(|exchanges| format!("pkw-delay={exchanges}")),
        Just("pkw-wrong-ak".to_owned()),
        Just("pkw-wrong-pnu".to_owned()),
        Just("pkw-torn".to_owned()),
        Just("no-reply".to_owned()),
        Just("truncated".to_owned()),
        Just("wrong-fcs".to_owned()),
    ];
    (kind, 1..6_u8, any::<u16>())
        .prop_map(|(kind, tenths, seed)| format!("{kind},rate=0.{tenths},seed={seed}"))
}

#[derive(Clone, Copy, Debug)]
enum Access {
    Read(Parameter),
    Write(Parameter, i32),
    FaultBuffer(u8),
    Count,
    Calibrate,
}

fn access() -> impl Strategy<Value = Access> {
    let parameter = || {
        prop_oneof![
            Just(Parameter::VPos),
            Just(Parameter::PosWindow),
            Just(Parameter::Limit1),
            Just(Parameter::CalibrationValue),
        ]
    };
    prop_oneof![
        4 => parameter().prop_map(Access::Read),
        4 => (parameter(), prop_oneof![Just(30), Just(77), Just(2_000_000)]).prop_map(|(p, v)| Access::Write(p, v)),
        1 => (0..12_u8).prop_map(Access::FaultBuffer),
        1 => Just(Access::Count),
        1 => Just(Access::Calibrate),
    ]
}

proptest! {
    #![proptest_config(cases(40))]

    #[test]
    fn a_spoilt_line_brings_errors_but_no_wrong_values(
        model in model(), faults in proptest::collection::vec(fault(), 0..4),
        accesses in proptest::collection::vec(access(), 1..20), consistent: bool,
    ) {
        let mut line = Spoilt::new(model, &faults);
        let images = if consistent { Images::Consistent } else { Images::MayBeTorn };
        let mut client = PkwClient::new(Profile { images, exchanges: 60, ..Profile::AG03 });
        let mut answered = 0;
        for access in &accesses {
            let stored = |line: &Spoilt, p: Parameter| Value::of(p.entry().width, line.device.parameters().value(p));
            let (job, before) = match *access {
                Access::Read(p) => (Job::read(p.entry().pnu).expecting(p.entry().width), Some(p)),
                Access::Write(p, value) => (Job::write(p.entry().pnu, Value::of(p.entry().width, value)), Some(p)),
                Access::FaultBuffer(n) => {
                    (Job::read_element(Pnu::new(945).unwrap(), Subindex(n)).expecting(Width::Word), None)
                }
                Access::Count => (Job::element_count(Pnu::new(945).unwrap()), None),
                Access::Calibrate => (Job::write(Pnu::new(970).unwrap(), Value::Word(5)), None),
            };
            let old = before.map(|p| stored(&line, p));
            let result = line.run(&mut client, job);
            let new = before.map(|p| stored(&line, p));
            answered += usize::from(result.is_ok());
            match (*access, result) {
                (Access::Read(_) | Access::Write(..), Ok(reply)) => {
                    prop_assert_eq!(Some(reply), new.map(Reply::Value), "{}", job);
                    if let Access::Read(_) = access { prop_assert_eq!(old, new) }
                }
                (Access::FaultBuffer(n), Ok(reply)) => {
                    prop_assert!(n < 10);
                    prop_assert_eq!(reply, Reply::Value(Value::Word(0)));
                }
                (Access::Count, Ok(reply)) => prop_assert_eq!(reply, Reply::ElementCount(10)),
                (Access::Calibrate, Ok(reply)) => {
                    prop_assert!(matches!(reply, Reply::Value(value) if value.bits() == 0));
                }
                (_, Err(error)) => if error.is_certain() { prop_assert_eq!(old, new, "{}: {}", job, error) },
            }
        }
        let pkw_spoilt = faults.iter().any(|fault| fault.contains("wrong") || fault.contains("delay"));
        if !pkw_spoilt && !accesses.iter().any(|access| matches!(access, Access::Write(..) | Access::FaultBuffer(_))) {
            prop_assert_eq!(answered, accesses.len(), "lost telegrams and torn answers only cost time");
        }
    }
}

const LIMITS: Limits = Limits {
    reaction: Duration::from_millis(1500),
    motion: Duration::from_secs(4),
    explanation: Duration::from_millis(300),
};

/// What a drive with such a client can be put through.
#[derive(Clone, Copy, Debug)]
enum Event {
    Pursue(Goal),
    /// So many exchanges, whatever the goal.
    Exchanges(u16),
    /// Images are late by so many exchanges on either way from now on.
    Late(u8, u8),
    /// The world around the drive.
    Fault(Fault),
    OutputStage(bool),
    /// Data_Exchange is lost and comes back.
    Lose,
}

struct Rig {
    line: Line,
    client: DriveClient,
    late: (usize, usize),
    outputs: VecDeque<[u8; 14]>,
    inputs: VecDeque<[u8; 14]>,
    travels: usize,
    acknowledge: bool,
}

impl Rig {
    fn new(model: Model) -> Self {
        let mut line = Line::with(Config { timing: Timing::True, ..config(model) });
        line.start_up();
        let acknowledge = line.device.status().job_acknowledge;
        let client = DriveClient::new(Profile::AG03, LIMITS);
        let (outputs, inputs) = (VecDeque::new(), VecDeque::new());
        Self { line, client, late: (0, 0), outputs, inputs, travels: 0, acknowledge }
    }

    fn exchange(&mut self) {
        self.outputs.push_back(self.client.outputs());
        while self.outputs.len() > self.late.0 + 1 {
            self.outputs.pop_front();
        }
        let outputs = *self.outputs.front().unwrap();
        self.inputs.push_back(self.line.exchange(&outputs));
        self.line.wait(Duration::from_millis(1));
        if self.line.device.status().job_acknowledge != self.acknowledge {
            self.acknowledge = !self.acknowledge;
            self.travels += 1;
        }
        while self.inputs.len() > self.late.1 {
            let inputs = self.inputs.pop_front().unwrap();
            self.client.handle_inputs(self.line.now, ppo::Inputs::new(&inputs));
        }
        self.client.handle_timeout(self.line.now);
    }

    /// At rest for a while: nothing that was asked for earlier begins now.
    fn expect_peace(&mut self) {
        let travels = self.travels;
        // Coasting and braking end.
        self.exchanges(1500);
        let position = self.line.device.status().position;
        self.exchanges(300);
        assert_eq!((self.travels, self.line.device.status().position), (travels, position));
    }

    fn exchanges(&mut self, count: usize) {
        for _ in 0..count {
            self.exchange();
        }
    }
}

fn event() -> impl Strategy<Value = Event> {
    let goal = prop_oneof![
        3 => Just(Goal::Enable),
        2 => Just(Goal::Acknowledge),
        6 => (-4..=4_i32).prop_map(|steps| Goal::MoveTo(200 * steps)),
        1 => Just(Goal::MoveTo(2_000_000)),
        1 => Just(Goal::Pause),
        1 => Just(Goal::Resume),
        1 => Just(Goal::Stop),
        1 => Just(Goal::Inch),
        1 => Just(Goal::Jog(Direction::Negative)),
        1 => Just(Goal::Disable),
    ];
    prop_oneof![
        8 => goal.prop_map(Event::Pursue),
        2 => (1..600_u16).prop_map(Event::Exchanges),
        1 => (0..6_u8, 0..6_u8).prop_map(|(out, back)| Event::Late(out, back)),
        1 => prop_oneof![Just(Fault::D), Just(Fault::G)].prop_map(Event::Fault),
        1 => any::<bool>().prop_map(Event::OutputStage),
        1 => Just(Event::Lose),
    ]
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn one_start_is_one_travel_every_goal_ends_in_time_and_nothing_starts_later(
        model in model(), events in proptest::collection::vec(event(), 1..14),
    ) {
        let mut rig = Rig::new(model);
        let mut moves = 0;
        // Most of what shall be seen needs an enabled drive.
        for event in [Event::Pursue(Goal::Enable)].into_iter().chain(events) {
            match event {
                Event::Pursue(goal) => {
                    rig.client.pursue(rig.line.now, goal);
                    moves += usize::from(matches!(goal, Goal::MoveTo(_)));
                    let longest = LIMITS.reaction + LIMITS.motion + LIMITS.explanation;
                    let deadline: Instant = rig.line.now.saturating_add(longest + Duration::from_millis(10));
                    let outcome = loop {
                        rig.exchange();
                        if let Some(outcome) = rig.client.poll_outcome() {
                            break outcome;
                        }
                        prop_assert!(rig.line.now < deadline, "{} hangs", goal);
                    };
                    prop_assert_eq!(outcome.goal, goal);
                    let status = rig.line.device.status();
                    match outcome {
                        GoalOutcome { goal: Goal::MoveTo(target), result: Ok(position) } => {
                            prop_assert!(position.abs_diff(target) <= 10 && status.position.abs_diff(target) <= 10);
                            prop_assert!(!status.job_active);
                        }
                        GoalOutcome { goal: Goal::Enable, result: Ok(_) } => prop_assert!(status.operation_enabled),
                        GoalOutcome { goal: Goal::Stop | Goal::Pause, result: Ok(_) } => {
                            prop_assert!(status.standstill);
                        }
                        GoalOutcome { goal: Goal::Disable, result: Ok(_) } => {
                            prop_assert!(!status.operation_enabled && status.standstill);
                        }
                        GoalOutcome { goal: Goal::Acknowledge, result: Ok(_) } => {
                            prop_assert!(status.fault.is_none() && !status.turn_on_disabled);
                        }
                        GoalOutcome { result: Ok(_), .. } => {}
                        GoalOutcome { result: Err(GoalError::Refused(_)), .. } => rig.expect_peace(),
                        GoalOutcome { result: Err(error), .. } => prop_assert!(false, "{}", error),
                    }
                    prop_assert!(rig.travels <= moves, "{} travels after {} starts", rig.travels, moves);
                }
                Event::Exchanges(count) => rig.exchanges(count.into()),
                Event::Late(out, back) => rig.late = (out.into(), back.into()),
                Event::Fault(fault) => {
                    rig.line.device.set_inputs(rig.line.now, Inputs::default().provoking(fault));
                    rig.exchanges(50);
                    rig.line.device.set_inputs(rig.line.now, Inputs::default());
                    rig.exchanges(50);
                }
                Event::OutputStage(live) => {
                    rig.line.device.set_inputs(rig.line.now, Inputs::default().with_output_stage(live));
                    rig.exchanges(50);
                }
                Event::Lose => {
                    rig.client.handle_data_exchange_lost();
                    prop_assert_eq!(rig.client.poll_outcome(), None);
                    rig.outputs.clear();
                    rig.inputs.clear();
                    rig.line.start_up();
                    rig.expect_peace();
                }
            }
        }
    }
}
