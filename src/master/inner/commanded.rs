//! A slave that the master in this program has: its client, and the order that it carries out.

use super::{number_of, pnu, said};
use crate::client::{
    Ag03Channel, DriveClient, Goal, Images, Job, Limits, Outcome, PpoClient, PpoGoal, PpoLimits, Profile,
    Reply,
};
use crate::devices::ag03::drive::Direction;
use crate::devices::ag03::param::{Pnu, Subindex, Value};
use crate::explain::hex;
use crate::face::Operation;
use crate::face::operation::{Act, Verb};
use crate::host::Startup;
use crate::host::inner_master::{Asked, Place};
use crate::profibus::fdl::Address;
use crate::profibus::ppo::{Inputs, Outputs, Pkw};
use crate::time::Instant;

/// A set-point of 100 %.
const FULL: i32 = 0x4000;

/// A slave of this master.
pub(super) struct Commanded {
    pub(super) address: Address,
    /// Octets that come back.
    inputs: usize,
    client: Client,
    /// The octets that were sent last.
    sent: Vec<u8>,
    /// The order that is carried out, and what it is in words.
    order: Option<(u64, String)>,
    job: Option<Access>,
}

enum Client {
    Positioning(Box<DriveClient>),
    Speed(Box<PpoClient>),
    Octets(Vec<u8>),
}

/// An access to a parameter that is under way.
#[derive(Clone, Copy)]
enum Access {
    Read(Place),
    /// Read first: the reply tells the width.
    Write(Place, f64),
    Written(Place),
}

impl Access {
    const fn place(self) -> Place {
        match self {
            Self::Read(place) | Self::Write(place, _) | Self::Written(place) => place,
        }
    }
}

/// An order that is over.
pub(super) struct Over {
    pub(super) number: u64,
    pub(super) what: String,
    pub(super) outcome: Result<String, String>,
}

impl Commanded {
    /// A slave that was taken over just now.
    pub(super) fn new(address: Address, startup: &Startup) -> Self {
        let client = match (startup.operation, startup.ppo) {
            (Operation::Positioning, _) => {
                let channel = Ag03Channel { images: Images::Consistent, ..Ag03Channel::DEFAULT };
                Client::Positioning(Box::new(DriveClient::new(channel, Limits::default())))
            }
            (Operation::Speed, Some(kind)) => {
                let profile = Profile { images: Images::Consistent, ..Profile::PROFIDRIVE };
                Client::Speed(Box::new(PpoClient::new(kind, profile, PpoLimits::default())))
            }
            (Operation::Speed | Operation::Octets | Operation::Cia402 { .. } | Operation::Objects, _) => {
                Client::Octets(vec![0; startup.lengths().outputs.into()])
            }
        };
        Self {
            address,
            inputs: startup.lengths().inputs.into(),
            client,
            sent: Vec::new(),
            order: None,
            job: None,
        }
    }

    /// What it is asked, in words.
    pub(super) fn doing(&self) -> Option<String> {
        self.order.as_ref().map(|(_, what)| what.clone())
    }

    /// Begins what is asked. What was under way is forgotten.
    pub(super) fn begin(&mut self, now: Instant, number: u64, asked: &Asked) -> Option<Over> {
        let what = in_words(asked, pnu);
        let begun = match asked {
            Asked::Act(act, value) => number_of(act, *value).and_then(|value| self.pursue(now, act, value)),
            Asked::Read(place) => self.access(now, Access::Read(*place), Job::read, Job::read_element),
            Asked::Write(place, value) => {
                self.access(now, Access::Write(*place, *value), Job::read, Job::read_element)
            }
            Asked::Outputs(octets) => match self.set_outputs(octets) {
                Ok(()) => return Some(Over { number, what, outcome: Ok("sent in each cycle".into()) }),
                Err(why) => Err(why),
            },
            Asked::Take | Asked::Leave => {
                return Some(Over { number, what, outcome: Ok("it exchanges data with this master".into()) });
            }
        };
        match begun {
            Ok(()) => {
                self.order = Some((number, what));
                None
            }
            Err(why) => Some(Over { number, what, outcome: Err(why) }),
        }
    }

    fn pursue(&mut self, now: Instant, act: &Act, value: i32) -> Result<(), String> {
        let none = || Err(format!("this device has no '{}'", act.key));
        match &mut self.client {
            Client::Positioning(client) => {
                let goal = match act.verb {
                    Verb::Enable => Goal::Enable,
                    Verb::Disable => Goal::Disable,
                    Verb::Acknowledge => Goal::Acknowledge,
                    Verb::Stop => Goal::Stop,
                    Verb::Move => Goal::MoveTo(value),
                    Verb::JogPositive => Goal::Jog(Direction::Positive),
                    Verb::JogNegative => Goal::Jog(Direction::Negative),
                    Verb::Velocity => Goal::Velocity(value),
                    Verb::Speed
                    | Verb::Turn(..)
                    | Verb::Inch(_)
                    | Verb::Home
                    | Verb::NmtStart
                    | Verb::NmtStop
                    | Verb::NmtPreOperational
                    | Verb::NmtResetNode
                    | Verb::NmtResetCommunication => return none(),
                };
                client.pursue(now, goal);
            }
            Client::Speed(client) => {
                let goal = match act.verb {
                    Verb::Enable => PpoGoal::Enable,
                    Verb::Disable => PpoGoal::Disable,
                    Verb::Acknowledge => PpoGoal::Acknowledge,
                    Verb::Stop => PpoGoal::Run(0),
                    Verb::Speed => PpoGoal::Run(i16::try_from(value * FULL / 100).unwrap_or_default()),
                    Verb::Move
                    | Verb::JogPositive
                    | Verb::JogNegative
                    | Verb::Velocity
                    | Verb::Turn(..)
                    | Verb::Inch(_)
                    | Verb::Home
                    | Verb::NmtStart
                    | Verb::NmtStop
                    | Verb::NmtPreOperational
                    | Verb::NmtResetNode
                    | Verb::NmtResetCommunication => return none(),
                };
                client.pursue(now, goal);
            }
            Client::Octets(_) => return none(),
        }
        Ok(())
    }

    fn set_outputs(&mut self, octets: &[u8]) -> Result<(), String> {
        let Client::Octets(outputs) = &mut self.client else {
            return Err("this device is operated by its words; its octets are not set one by one".into());
        };
        if octets.len() != outputs.len() {
            let (got, expected) = (octets.len(), outputs.len());
            return Err(format!("its configuration has {expected} octets of outputs, got {got}"));
        }
        outputs.copy_from_slice(octets);
        Ok(())
    }

    fn access(
        &mut self,
        now: Instant,
        access: Access,
        whole: impl Fn(Pnu) -> Job,
        element: impl Fn(Pnu, Subindex) -> Job,
    ) -> Result<(), String> {
        let Place { number, sub } = access.place();
        let pnu = Pnu::new(number).map_err(|error| error.to_string())?;
        let job = sub.map_or_else(|| whole(pnu), |sub| element(pnu, Subindex(sub)));
        let submitted = match &mut self.client {
            Client::Positioning(client) => client.submit(now, job),
            Client::Speed(client) => client.submit(now, job),
            Client::Octets(_) => return Err("this device has no parameter channel".into()),
        };
        submitted.map_err(|error| error.to_string())?;
        self.job = Some(access);
        Ok(())
    }

    /// The octets of the next cycle.
    pub(super) fn outputs(&self) -> Vec<u8> {
        match &self.client {
            Client::Positioning(client) => client.outputs().to_vec(),
            Client::Speed(client) => client.outputs(&mut [0; PpoClient::MOST]).to_vec(),
            Client::Octets(octets) => octets.clone(),
        }
    }

    /// What came back, and the orders that are over by it.
    pub(super) fn take(&mut self, now: Instant, inputs: &[u8]) -> Option<Over> {
        let inputs = inputs.get(..self.inputs).unwrap_or(inputs);
        let (goal, job) = match &mut self.client {
            Client::Positioning(client) => {
                if let Ok(inputs) = Inputs::parse(inputs) {
                    client.handle_inputs(now, inputs);
                }
                let goal = client.poll_outcome().map(|over| match over.result {
                    Ok(hiw) => Ok(format!("done, actual value {hiw}")),
                    Err(error) => Err(error.to_string()),
                });
                (goal, client.poll_job())
            }
            Client::Speed(client) => {
                client.handle_inputs(now, inputs);
                let goal = client.poll_outcome().map(|over| match over.result {
                    Ok(actual) => Ok(format!("done, actual value {:.1} %", percent(actual))),
                    Err(error) => Err(error.to_string()),
                });
                (goal, client.poll_job())
            }
            Client::Octets(_) => (None, None),
        };
        let outcome = match (job, self.job) {
            (Some(job), Some(access)) => self.job_over(now, job, access),
            (_, _) => None,
        };
        let outcome = outcome.or(goal.filter(|_| self.job.is_none()))?;
        let (number, what) = self.order.take()?;
        Some(Over { number, what, outcome })
    }

    /// What comes after a job.
    fn job_over(&mut self, now: Instant, job: Outcome, access: Access) -> Option<Result<String, String>> {
        self.job = None;
        let value = match job.result {
            Ok(Reply::Value(value)) => value,
            Ok(other @ (Reply::ElementCount(_) | Reply::Description(_))) => {
                return Some(Err(format!("the drive answered with another reply: {other:?}")));
            }
            Err(error) => return Some(Err(error.to_string())),
        };
        let Access::Write(place, number) = access else {
            return Some(Ok(shown(access.place(), value)));
        };
        let next = match written(value, number) {
            Ok(value) => self.access(
                now,
                Access::Written(place),
                |pnu| Job::write(pnu, value),
                |pnu, element| Job::write_element(pnu, element, value),
            ),
            Err(why) => Err(why),
        };
        next.err().map(Err)
    }

    /// The slave is lost.
    pub(super) fn lose(self, why: &str) -> Option<Over> {
        let (number, what) = self.order?;
        Some(Over { number, what, outcome: Err(why.to_owned()) })
    }

    /// What the octets of this cycle say, if they are not those of the cycle before.
    pub(super) fn new_words(&mut self, octets: &[u8]) -> Option<String> {
        if self.sent == octets {
            return None;
        }
        self.sent = octets.to_vec();
        Some(self.words(octets))
    }

    /// The words in the octets of a cycle, for people.
    fn words(&self, octets: &[u8]) -> String {
        let octets_in_hex = || hex(octets);
        let pkw = |octets: &[u8]| match octets.first_chunk() {
            Some(pkw) if Pkw::from_octets(*pkw) != Pkw::ZERO => format!("PKW {}, ", Pkw::from_octets(*pkw)),
            Some(_) | None => String::new(),
        };
        match &self.client {
            Client::Positioning(_) => match Outputs::parse(octets) {
                Ok(outputs) => format!("{}STW {}, set-point {}", pkw(octets), outputs.stw(), outputs.hsw()),
                Err(_) => octets_in_hex(),
            },
            Client::Speed(client) => {
                let (channel, at) =
                    if client.kind().has_pkw() { (pkw(octets), 8) } else { (String::new(), 0) };
                let word = |at: usize| {
                    let octets = octets.get(at..at + 2).and_then(|octets| octets.try_into().ok());
                    octets.map(i16::from_be_bytes).unwrap_or_default()
                };
                let (stw, setpoint) = (word(at), word(at + 2));
                format!("{channel}STW {stw:04X}, set-point {setpoint} ({:.1} %)", percent(setpoint))
            }
            Client::Octets(_) => format!("outputs {}", octets_in_hex()),
        }
    }
}

fn percent(setpoint: i16) -> f64 {
    f64::from(setpoint) * 100.0 / f64::from(FULL)
}

/// A number as the value of a parameter that has the width of `before`.
fn written(before: Value, number: f64) -> Result<Value, String> {
    let (low, high) = match before {
        Value::Word(_) => (f64::from(i16::MIN), f64::from(u16::MAX)),
        Value::Double(_) => (f64::from(i32::MIN), f64::from(u32::MAX)),
    };
    if !(low..=high).contains(&number) || number.fract() != 0.0 {
        return Err(format!("it takes a whole number from {low} to {high}, got {number}"));
    }
    #[expect(clippy::cast_possible_truncation, reason = "within 33 bits")]
    let [_, _, _, _, a, b, c, d] = (number as i64).to_be_bytes();
    Ok(match before {
        Value::Word(_) => Value::Word(u16::from_be_bytes([c, d])),
        Value::Double(_) => Value::Double(u32::from_be_bytes([a, b, c, d])),
    })
}

fn shown(place: Place, value: Value) -> String {
    let (name, bits) = (pnu(place), value.bits());
    match value {
        Value::Word(word) => format!("{name} = {} ({bits:04X}h)", word.cast_signed()),
        Value::Double(double) => format!("{name} = {} ({bits:08X}h)", double.cast_signed()),
    }
}

/// What is asked, for people; `named` says what a place is called.
pub(super) fn in_words(asked: &Asked, named: impl Fn(Place) -> String) -> String {
    match asked {
        Asked::Take => "take over".into(),
        Asked::Leave => "leave the line".into(),
        Asked::Act(act, value) => said(act, *value),
        Asked::Outputs(octets) => {
            format!("outputs {}", hex(octets))
        }
        Asked::Read(place) => format!("read {}", named(*place)),
        Asked::Write(place, value) => format!("write {value} to {}", named(*place)),
    }
}
