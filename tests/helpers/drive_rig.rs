//! An emulated drive in Data_Exchange and the `DriveClient` of its master, exchange by exchange.
#![allow(dead_code, reason = "each test file uses its part")]

use std::time::Duration;

use profidrive::client::{
    Ag03Channel, DriveClient, Goal, GoalError, GoalOutcome, Job, Limits, Obstacle, PkwError, Reply,
};
use profidrive::devices::ag03::drive::Inputs;
use profidrive::devices::ag03::param::{Model, Pnu, Value};
use profidrive::devices::ag03::profibus::{Config, Timing};
use profidrive::profibus::fdl::Address;
use profidrive::profibus::ppo;

use crate::drive_line::Line;

/// A drive in Data_Exchange and the client of its master.
pub(crate) struct Rig {
    pub(crate) line: Line,
    pub(crate) client: DriveClient,
    /// Each control word, as often as it changed.
    pub(crate) words: Vec<String>,
}

impl Rig {
    pub(crate) fn new(model: Model) -> Self {
        Self::with(Self::config(model))
    }

    /// With quirks: names and values.
    pub(crate) fn quirky(model: Model, quirks: &[(&str, &str)]) -> Self {
        let mut config = Self::config(model);
        for (name, value) in quirks {
            config.set_quirk(name, value).unwrap();
        }
        Self::with(config)
    }

    fn config(model: Model) -> Config {
        Config { model, timing: Timing::True, ..Config::new(Address::station(5).unwrap()) }
    }

    /// In velocity mode, with operation enabled.
    pub(crate) fn in_velocity_mode(model: Model) -> Self {
        let mut rig = Self::new(model);
        rig.write(930, Value::Word(1));
        rig.pursue(Goal::Enable).unwrap();
        rig
    }

    pub(crate) fn with(config: Config) -> Self {
        let mut line = Line::with(config);
        line.start_up();
        let limits = Limits { motion: Duration::from_secs(30), ..Limits::default() };
        Self { line, client: DriveClient::new(Ag03Channel::DEFAULT, limits), words: Vec::new() }
    }

    pub(crate) fn exchange(&mut self) {
        let outputs = self.client.outputs();
        let stw = ppo::Outputs::new(&outputs).stw().to_string();
        if self.words.last() != Some(&stw) {
            self.words.push(stw);
        }
        let inputs = self.line.exchange(&outputs);
        self.line.wait(Duration::from_millis(1));
        self.client.handle_inputs(self.line.now, ppo::Inputs::new(&inputs));
    }

    pub(crate) fn exchanges(&mut self, count: usize) {
        for _ in 0..count {
            self.exchange();
        }
    }

    pub(crate) fn pursue(&mut self, goal: Goal) -> Result<i32, GoalError> {
        self.begin(goal);
        let outcome = self.outcome();
        assert_eq!(outcome.goal, goal);
        outcome.result
    }

    pub(crate) fn begin(&mut self, goal: Goal) {
        self.words.clear();
        self.client.pursue(self.line.now, goal);
    }

    pub(crate) fn outcome(&mut self) -> GoalOutcome {
        loop {
            self.exchange();
            if let Some(outcome) = self.client.poll_outcome() {
                return outcome;
            }
        }
    }

    /// Whether the shaft turns, whatever the status word says.
    pub(crate) fn moves(&self) -> bool {
        self.line.device.status().moving
    }

    /// The control word that goes out next.
    pub(crate) fn stw(&self) -> String {
        ppo::Outputs::new(&self.client.outputs()).stw().to_string()
    }

    pub(crate) fn job(&mut self, job: Job) -> Result<Reply, PkwError> {
        self.client.submit(self.line.now, job).unwrap();
        loop {
            self.exchange();
            if let Some(outcome) = self.client.poll_job() {
                return outcome.result;
            }
        }
    }

    pub(crate) fn write(&mut self, pnu: u16, value: Value) {
        self.job(Job::write(Pnu::new(pnu).unwrap(), value)).unwrap();
    }

    pub(crate) fn set_inputs(&mut self, inputs: Inputs) {
        self.line.device.set_inputs(self.line.now, inputs);
    }

    /// The text of a refusal, and that these obstacles and no other are in it.
    pub(crate) fn refused(&mut self, goal: Goal, expected: &[Obstacle]) -> String {
        match self.pursue(goal) {
            Err(GoalError::Refused(obstacles)) => {
                assert_eq!(obstacles.iter().collect::<Vec<_>>(), expected, "{obstacles}");
                obstacles.to_string()
            }
            other => panic!("{goal}: {other:?}"),
        }
    }
}

pub(crate) const MODELS: [Model; 2] = [Model::Ag03, Model::Ag03_1];
