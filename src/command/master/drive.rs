//! The drive as the commands use it: parameters by job, words by exchange.

use core::time::Duration;

use profidrive::client::{
    Ag03Channel, DriveClient, Goal, GoalError, Images, Job, Limits, NotSubmitted, PkwError, Reply,
};
use profidrive::fdl::Address;
use profidrive::host::{Clock, Link};
use profidrive::master::{Session, SessionError};
use profidrive::param::{Gear, Model, Pnu, Subindex, Value, Width};
use profidrive::pkw::ErrorNumber;
use profidrive::ppo::{Inputs, Outputs, Stw, Zsw};
use thiserror::Error;

/// d-Pos, which only an AG03/1 has.
const D_POS: Pnu = Pnu::from_low_bits(1039);
/// Hardware version, which tells the gear.
const HARDWARE: Pnu = Pnu::from_low_bits(961);

/// How long the drive may take to do anything but travel. Somebody waits for it.
const REACTION: Duration = Duration::from_secs(3);

/// Why a drive did not do what it was asked.
#[derive(Debug, Error)]
pub(super) enum Trouble {
    #[error(transparent)]
    Session(#[from] SessionError),
    /// Lost after a job was sent and before its reply.
    #[error(transparent)]
    Unanswered(SessionError),
    #[error(transparent)]
    Job(#[from] PkwError),
    #[error(transparent)]
    NotSubmitted(#[from] NotSubmitted),
    #[error(transparent)]
    Goal(#[from] GoalError),
    /// What the drive says, which is not what was asked of it.
    #[error("the drive has stopped doing it: {0}")]
    Ended(String),
    /// It was not seen to stand.
    #[error("{0}")]
    StillTurns(String),
    #[error("the drive answered {job} with something else: {reply:?}")]
    OtherReply { job: Job, reply: Reply },
    #[error("the drive says hardware version {0}, expected 2 (gear 24:1) or 3 (gear 48:1)")]
    Hardware(u32),
}

impl Trouble {
    /// Whether the drive can no longer be reached.
    pub(super) fn is_loss(&self) -> bool {
        match self {
            Self::Session(error) | Self::Unanswered(error) => error.is_loss(),
            Self::Goal(error) => matches!(error, GoalError::Interrupted),
            Self::Job(_)
            | Self::NotSubmitted(_)
            | Self::Ended(_)
            | Self::StillTurns(_)
            | Self::OtherReply { .. }
            | Self::Hardware(_) => false,
        }
    }
}

/// A drive that belongs to this master.
pub(super) struct Drive<L, C> {
    pub(super) session: Session<L, C>,
    pub(super) address: Address,
    client: DriveClient,
}

/// What a drive says in one exchange beside the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seen {
    pub(super) zsw: Zsw,
    pub(super) hiw: i32,
}

/// How a goal ended that nothing stood against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reached {
    /// With this actual value.
    Done(i32),
    /// Not yet: the drive still does what it was doing.
    Interrupted,
}

/// Which drive it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Identity {
    pub(super) model: Model,
    pub(super) gear: Gear,
}

impl<L: Link, C: Clock> Drive<L, C> {
    /// Takes the drive over.
    pub(super) fn take(mut session: Session<L, C>, address: Address) -> Result<Self, SessionError> {
        session.start(address)?;
        // profirust copies the inputs of a telegram at once.
        let channel = Ag03Channel { images: Images::Consistent, ..Ag03Channel::DEFAULT };
        let limits = Limits { reaction: REACTION, ..Limits::default() };
        Ok(Self { session, address, client: DriveClient::new(channel, limits) })
    }

    /// Whether Ctrl-C or a signal asks for the end.
    pub(super) fn is_stopped(&self) -> bool {
        self.session.stop().is_requested()
    }

    /// The control word that is sent now.
    pub(super) fn stw(&self) -> Stw {
        Outputs::new(&self.client.outputs()).stw()
    }

    /// One exchange.
    pub(super) fn exchange(&mut self) -> Result<Seen, SessionError> {
        match self.session.exchange(&self.client.outputs()) {
            Ok(octets) => {
                let inputs = Inputs::new(&octets);
                self.client.handle_inputs(self.session.now(), inputs);
                Ok(Seen { zsw: inputs.zsw(), hiw: inputs.hiw() })
            }
            Err(error) => {
                self.client.handle_data_exchange_lost();
                Err(error)
            }
        }
    }

    /// Does one job, to its end: a job that was sent cannot be taken back. The control word stays as it is meanwhile.
    pub(super) fn job(&mut self, job: Job) -> Result<Reply, Trouble> {
        self.client.submit(self.session.now(), job)?;
        loop {
            let exchanged = self.exchange();
            let outcome = self.client.poll_job();
            match (exchanged, outcome) {
                (Ok(_), None) => {}
                (Ok(_), Some(outcome)) => return Ok(outcome.result?),
                (Err(error), Some(_)) => return Err(Trouble::Unanswered(error)),
                // The job was not sent, and never will be.
                (Err(error), None) => return Err(error.into()),
            }
        }
    }

    /// Pursues a goal until it is reached, or Ctrl-C or a signal asks for the end.
    pub(super) fn reach(&mut self, goal: Goal) -> Result<Reached, Trouble> {
        self.client.pursue(self.session.now(), goal);
        loop {
            if self.is_stopped() {
                return Ok(Reached::Interrupted);
            }
            self.exchange()?;
            if let Some(outcome) = self.client.poll_outcome() {
                return Ok(Reached::Done(outcome.result?));
            }
        }
    }

    /// Reads a value of a known width.
    pub(super) fn read(
        &mut self,
        pnu: Pnu,
        element: Option<Subindex>,
        width: Width,
    ) -> Result<Value, Trouble> {
        let job = match element {
            Some(element) => Job::read_element(pnu, element),
            None => Job::read(pnu),
        };
        let job = job.expecting(width);
        match self.job(job)? {
            Reply::Value(value) => Ok(value),
            reply @ (Reply::ElementCount(_) | Reply::Description(_)) => {
                Err(Trouble::OtherReply { job, reply })
            }
        }
    }

    /// Writes a value and says what the drive has then.
    pub(super) fn write(&mut self, pnu: Pnu, value: Value) -> Result<Value, Trouble> {
        let job = Job::write(pnu, value);
        match self.job(job)? {
            Reply::Value(value) => Ok(value),
            reply @ (Reply::ElementCount(_) | Reply::Description(_)) => {
                Err(Trouble::OtherReply { job, reply })
            }
        }
    }

    /// Asks which model it is: only the AG03/1 has d-Pos.
    pub(super) fn model(&mut self) -> Result<Model, Trouble> {
        match self.read(D_POS, None, Width::Word) {
            Ok(_) => Ok(Model::Ag03_1),
            Err(Trouble::Job(PkwError::Refused(code)))
                if code.number() == ErrorNumber::IllegalParameterNumber.number() =>
            {
                Ok(Model::Ag03)
            }
            Err(error) => Err(error),
        }
    }

    /// Asks which drive it is: the hardware version tells the gear.
    pub(super) fn identify(&mut self) -> Result<Identity, Trouble> {
        let model = self.model()?;
        let hardware = self.read(HARDWARE, None, Width::Word)?.bits();
        let gear = Gear::ALL.into_iter().find(|gear| u32::from(gear.hardware_version()) == hardware);
        Ok(Identity { model, gear: gear.ok_or(Trouble::Hardware(hardware))? })
    }
}
