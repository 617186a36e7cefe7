//! `DriveClient` over images that are late by any time, with goals that replace each other at any exchange, while the
//! world around the drive changes and the drive reads its manual in any way.

use crate::drive_line;
use crate::long;

use std::collections::VecDeque;
use std::time::Duration;

use drive_line::{Line, SLAVE};
use long::cases;
use profidrive::client::{Ag03Channel, DriveClient, Goal, GoalError, GoalOutcome, Job, Limits};
use profidrive::devices::ag03::drive::{Direction, Fault, Inputs};
use profidrive::devices::ag03::param::{Model, Pnu, Value};
use profidrive::devices::ag03::profibus::{Config, QUIRKS, Timing};
use profidrive::profibus::fdl::Address;
use profidrive::profibus::ppo;
use proptest::prelude::*;

const LIMITS: Limits = Limits {
    reaction: Duration::from_millis(1500),
    motion: Duration::from_secs(4),
    explanation: Duration::from_millis(300),
};

/// What a drive with such a client can be put through.
#[derive(Clone, Copy, Debug)]
enum Event {
    /// Until its end.
    Pursue(Goal),
    /// So many exchanges of it; what comes next may replace it.
    Begin(Goal, u16),
    /// So many exchanges, whatever the goal.
    Exchanges(u16),
    /// Images are late by so many exchanges on either way from now on.
    Late(u8, u8),
    /// The world around the drive.
    Fault(Fault),
    OutputStage(bool),
    /// The supply of the output stage or the enable input goes and comes back.
    Dip(u16),
    /// Data_Exchange is lost and comes back.
    Lose,
    /// PNU 930 is written.
    Mode(u16),
}

struct Rig {
    line: Line,
    client: DriveClient,
    late: (usize, usize),
    outputs: VecDeque<[u8; 14]>,
    inputs: VecDeque<[u8; 14]>,
    travels: usize,
    jobs: u8,
}

impl Rig {
    fn new(config: Config) -> Self {
        let mut line = Line::with(config);
        line.start_up();
        let jobs = line.device.status().jobs;
        let client = DriveClient::new(Ag03Channel::DEFAULT, LIMITS);
        let (outputs, inputs) = (VecDeque::new(), VecDeque::new());
        Self { line, client, late: (0, 0), outputs, inputs, travels: 0, jobs }
    }

    fn exchange(&mut self) {
        self.outputs.push_back(self.client.outputs());
        while self.outputs.len() > self.late.0 + 1 {
            self.outputs.pop_front();
        }
        let outputs = *self.outputs.front().unwrap();
        self.inputs.push_back(self.line.exchange(&outputs));
        self.line.wait(Duration::from_millis(1));
        let jobs = self.line.device.status().jobs;
        self.travels += usize::from(jobs.wrapping_sub(self.jobs));
        self.jobs = jobs;
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
        assert!(!self.line.device.status().moving);
    }

    fn exchanges(&mut self, count: usize) {
        for _ in 0..count {
            self.exchange();
        }
    }

    fn reach(&mut self, goal: Goal) -> GoalOutcome {
        self.client.pursue(self.line.now, goal);
        let longest = 2 * LIMITS.reaction + LIMITS.motion + LIMITS.explanation;
        let deadline = self.line.now.saturating_add(longest + Duration::from_millis(10));
        loop {
            self.exchange();
            if let Some(outcome) = self.client.poll_outcome() {
                return outcome;
            }
            assert!(self.line.now < deadline, "{goal} hangs");
        }
    }

    fn set_inputs(&mut self, inputs: Inputs, exchanges: usize) {
        self.line.device.set_inputs(self.line.now, inputs);
        self.exchanges(exchanges);
    }

    /// How often a goal may start a travel. One that ends where it begins shows nothing where ZSW.12 mirrors STW.6
    /// (C-07): the client gives the other edge of STW.6, too, in case only that one starts (C-32).
    fn starts(&self, goal: Goal) -> usize {
        match goal {
            Goal::MoveTo(target) if self.line.device.status().position.abs_diff(target) <= 10 => 2,
            Goal::MoveTo(_) => 1,
            _ => 0,
        }
    }

    /// What the drive does when a goal has been reached.
    fn check(&self, goal: Goal, reached: i32) {
        let status = self.line.device.status();
        match goal {
            Goal::MoveTo(target) => {
                assert!(reached.abs_diff(target) <= 10 && status.position.abs_diff(target) <= 10, "{goal}");
                assert!(!status.job_active && !status.moving, "{goal}");
            }
            Goal::Enable => assert!(status.operation_enabled),
            Goal::Stop => assert!(!status.moving && !status.job_active, "{goal}"),
            Goal::Pause => assert!(!status.moving && status.job_active, "{goal}"),
            Goal::Disable => assert!(!status.moving && !status.operation_enabled, "{goal}"),
            Goal::Acknowledge => assert!(status.fault.is_none() && !status.turn_on_disabled),
            Goal::Inch | Goal::Resume => assert!(!status.moving && !status.job_active, "{goal}"),
            Goal::Velocity(0) => assert!(!status.moving, "{goal}"),
            Goal::Velocity(rpm) => assert_eq!(status.velocity.signum(), rpm.signum(), "{goal}"),
            Goal::Jog(Direction::Positive) => assert!(status.moving && status.velocity >= 0, "{goal}"),
            Goal::Jog(Direction::Negative) => assert!(status.moving && status.velocity <= 0, "{goal}"),
            _ => panic!("{goal} is not checked"),
        }
    }
}

fn config() -> impl Strategy<Value = Config> {
    let model = prop_oneof![Just(Model::Ag03), Just(Model::Ag03_1)];
    let quirk = proptest::sample::select(QUIRKS)
        .prop_flat_map(|quirk| (Just(quirk.name), proptest::sample::select(quirk.values)));
    (model, proptest::collection::vec(quirk, 0..6)).prop_map(|(model, quirks)| {
        let mut config =
            Config { model, timing: Timing::True, ..Config::new(Address::station(SLAVE).unwrap()) };
        for (name, value) in quirks {
            config.set_quirk(name, value).unwrap();
        }
        config
    })
}

fn goal() -> impl Strategy<Value = Goal> {
    prop_oneof![
        3 => Just(Goal::Enable),
        2 => Just(Goal::Acknowledge),
        6 => (-4..=4_i32).prop_map(|steps| Goal::MoveTo(200 * steps)),
        1 => Just(Goal::MoveTo(2_000_000)),
        1 => Just(Goal::Pause),
        1 => Just(Goal::Resume),
        1 => Just(Goal::Stop),
        1 => Just(Goal::Inch),
        1 => Just(Goal::Jog(Direction::Negative)),
        1 => Just(Goal::Jog(Direction::Positive)),
        3 => (-2..=2_i32).prop_map(|steps| Goal::Velocity(45 * steps)),
        1 => Just(Goal::Disable),
    ]
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        8 => goal().prop_map(Event::Pursue),
        6 => (goal(), prop_oneof![0..30_u16, 0..400_u16]).prop_map(|(goal, count)| Event::Begin(goal, count)),
        2 => (1..600_u16).prop_map(Event::Exchanges),
        1 => (0..6_u8, 0..6_u8).prop_map(|(out, back)| Event::Late(out, back)),
        1 => prop_oneof![Just(Fault::D), Just(Fault::G)].prop_map(Event::Fault),
        1 => any::<bool>().prop_map(Event::OutputStage),
        2 => (50..400_u16).prop_map(Event::Dip),
        1 => Just(Event::Lose),
        1 => (1..=2_u16).prop_map(Event::Mode),
    ]
}

fn play(config: Config, mode: u16, events: Vec<Event>) {
    let mut rig = Rig::new(config);
    let mut moves = 0;
    // Most of what shall be seen needs an enabled drive.
    for event in [Event::Mode(mode), Event::Pursue(Goal::Enable)].into_iter().chain(events) {
        match event {
            Event::Pursue(goal) => {
                moves += rig.starts(goal);
                let outcome = rig.reach(goal);
                assert_eq!(outcome.goal, goal);
                match outcome.result {
                    Ok(reached) => rig.check(goal, reached),
                    Err(GoalError::Refused(_)) => rig.expect_peace(),
                    Err(error) => panic!("{error}"),
                }
                assert!(rig.travels <= moves, "{} travels after {moves} starts", rig.travels);
            }
            Event::Begin(goal, count) => {
                moves += rig.starts(goal);
                rig.client.pursue(rig.line.now, goal);
                rig.exchanges(count.into());
            }
            Event::Exchanges(count) => rig.exchanges(count.into()),
            Event::Late(out, back) => rig.late = (out.into(), back.into()),
            Event::Fault(fault) => {
                rig.set_inputs(Inputs::default().provoking(fault), 50);
                rig.set_inputs(Inputs::default(), 50);
            }
            Event::OutputStage(live) => rig.set_inputs(Inputs::default().with_output_stage(live), 50),
            Event::Dip(count) => {
                rig.set_inputs(Inputs::default().with_output_stage(false), count.into());
                rig.line.device.set_inputs(rig.line.now, Inputs::default());
                if rig.client.goal().is_none() {
                    rig.expect_peace();
                }
            }
            Event::Lose => {
                rig.client.handle_data_exchange_lost();
                // Of a goal that was begun.
                let _ended = rig.client.poll_outcome();
                rig.outputs.clear();
                rig.inputs.clear();
                rig.line.start_up();
                rig.expect_peace();
            }
            Event::Mode(mode) => {
                let job = Job::write(Pnu::new(930).unwrap(), Value::Word(mode));
                if rig.client.submit(rig.line.now, job).is_ok() {
                    while rig.client.poll_job().is_none() {
                        rig.exchange();
                    }
                    assert!(!ppo::Outputs::new(&rig.client.outputs()).stw().bit(6));
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(40, 50))]

    #[test]
    fn one_start_is_one_travel_what_is_done_is_true_and_nothing_starts_later(
        config in config(), mode in 1..=2_u16, events in proptest::collection::vec(event(), 1..16),
    ) {
        play(config, mode, events);
    }
}
