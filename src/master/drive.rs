//! One drive of a session with its client: parameters by job, goals, each call until it is done.

use core::time::Duration;

use thiserror::Error;

use super::{Session, SessionError};
use crate::client::{
    Ag03Channel, DriveClient, Goal, GoalError, Images, Job, Limits, NotSubmitted, PkwError, Reply,
};
use crate::devices::ag03::param::{Gear, Model, Pnu, Subindex, Value, Width};
use crate::host::{Clock, Link};
use crate::profibus::fdl::Address;
use crate::profibus::pkw::ErrorNumber;
use crate::profibus::ppo::{Inputs, Outputs, Stw, Zsw};

/// d-Pos, which only an AG03/1 has.
const D_POS: Pnu = Pnu::from_low_bits(1039);
/// Hardware version, which tells the gear.
const HARDWARE: Pnu = Pnu::from_low_bits(961);

/// How long the drive may take to do anything but travel. Somebody waits for it.
const REACTION: Duration = Duration::from_secs(3);

/// Why a drive did not do what it was asked.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DriveError {
    /// The bus, or the start-up of the drive.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// Lost after a job was sent and before its reply.
    #[error(transparent)]
    Unanswered(SessionError),
    /// The job failed.
    #[error(transparent)]
    Job(#[from] PkwError),
    /// The profile has no such job.
    #[error(transparent)]
    NotSubmitted(#[from] NotSubmitted),
    /// The goal was refused or not reached.
    #[error(transparent)]
    Goal(#[from] GoalError),
    /// The drive sent a reply of another kind.
    #[error("the drive answered {job} with another reply: {reply:?}")]
    OtherReply {
        /// The job.
        job: Job,
        /// The reply.
        reply: Reply,
    },
    /// PNU 961 has a value that no gear has.
    #[error("the drive says hardware version {0}, expected 2 (gear 24:1) or 3 (gear 48:1)")]
    Hardware(u32),
}

impl DriveError {
    /// Whether the drive can no longer be reached.
    pub(crate) fn is_loss(&self) -> bool {
        match self {
            Self::Session(error) | Self::Unanswered(error) => error.is_loss(),
            Self::Goal(error) => matches!(error, GoalError::Interrupted),
            Self::Job(_) | Self::NotSubmitted(_) | Self::OtherReply { .. } | Self::Hardware(_) => false,
        }
    }
}

/// A drive that belongs to this master. Every call blocks until it is done or has failed.
///
/// Reads and writes parameters, pursues goals, saves and restores all settings ([`Drive::settings`], [`Drive::restore`]).
#[derive(Debug)]
pub struct Drive<L, C> {
    /// The session, to look at its time and its settings, and to release the drive.
    pub session: Session<L, C>,
    pub(super) address: Address,
    client: DriveClient,
}

/// What a drive says in one exchange beside the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// The status word.
    pub zsw: Zsw,
    /// The actual value: a position or a velocity.
    pub hiw: i32,
}

/// How a goal ended that nothing stood against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// With this actual value.
    Done(i32),
    /// Not yet: the drive still does what it was doing.
    Interrupted,
}

/// Which drive it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// The model.
    pub model: Model,
    /// The gear.
    pub gear: Gear,
}

impl<L: Link, C: Clock> Drive<L, C> {
    /// Takes the drive over.
    ///
    /// # Errors
    /// As [`Session::start`].
    pub(crate) fn take(mut session: Session<L, C>, address: Address) -> Result<Self, SessionError> {
        session.start(address)?;
        // profirust copies the inputs of a telegram at once.
        let channel = Ag03Channel { images: Images::Consistent, ..Ag03Channel::DEFAULT };
        let limits = Limits { reaction: REACTION, ..Limits::default() };
        Ok(Self { session, address, client: DriveClient::new(channel, limits) })
    }

    /// Its address.
    pub(crate) const fn address(&self) -> Address {
        self.address
    }

    /// Whether the end is requested ([`Session::stop`]).
    pub(crate) fn is_stopped(&self) -> bool {
        self.session.stop().is_requested()
    }

    /// The control word that is sent now.
    pub(crate) fn stw(&self) -> Stw {
        Outputs::new(&self.client.outputs()).stw()
    }

    /// One exchange.
    ///
    /// # Errors
    /// As [`Session::exchange_with`].
    pub(crate) fn exchange(&mut self) -> Result<Seen, SessionError> {
        match self.session.exchange_with(self.address, &self.client.outputs()) {
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
    ///
    /// # Errors
    /// [`DriveError`]; after [`DriveError::Unanswered`] it is not known whether the job was done.
    pub fn job(&mut self, job: Job) -> Result<Reply, DriveError> {
        self.client.submit(self.session.now(), job)?;
        loop {
            let exchanged = self.exchange();
            let outcome = self.client.poll_job();
            match (exchanged, outcome) {
                (Ok(_), None) => {}
                (Ok(_), Some(outcome)) => return Ok(outcome.result?),
                (Err(error), Some(_)) => return Err(DriveError::Unanswered(error)),
                // The job was not sent, and never will be.
                (Err(error), None) => return Err(error.into()),
            }
        }
    }

    /// Pursues a goal until it is reached or the end is requested.
    ///
    /// # Errors
    /// [`DriveError::Goal`], [`DriveError::Session`].
    pub(crate) fn reach(&mut self, goal: Goal) -> Result<Reached, DriveError> {
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
    ///
    /// # Errors
    /// As [`Drive::job`].
    pub(crate) fn read(
        &mut self,
        pnu: Pnu,
        element: Option<Subindex>,
        width: Width,
    ) -> Result<Value, DriveError> {
        let job = match element {
            Some(element) => Job::read_element(pnu, element),
            None => Job::read(pnu),
        };
        let job = job.expecting(width);
        match self.job(job)? {
            Reply::Value(value) => Ok(value),
            reply @ (Reply::ElementCount(_) | Reply::Description(_)) => {
                Err(DriveError::OtherReply { job, reply })
            }
        }
    }

    /// Writes a value and says what the drive has then.
    ///
    /// # Errors
    /// As [`Drive::job`].
    pub(crate) fn write(&mut self, pnu: Pnu, value: Value) -> Result<Value, DriveError> {
        let job = Job::write(pnu, value);
        match self.job(job)? {
            Reply::Value(value) => Ok(value),
            reply @ (Reply::ElementCount(_) | Reply::Description(_)) => {
                Err(DriveError::OtherReply { job, reply })
            }
        }
    }

    /// Asks which model it is: only the AG03/1 has d-Pos.
    ///
    /// # Errors
    /// As [`Drive::job`].
    pub(crate) fn model(&mut self) -> Result<Model, DriveError> {
        match self.read(D_POS, None, Width::Word) {
            Ok(_) => Ok(Model::Ag03_1),
            Err(DriveError::Job(PkwError::Refused(code)))
                if code.number() == ErrorNumber::IllegalParameterNumber.number() =>
            {
                Ok(Model::Ag03)
            }
            Err(error) => Err(error),
        }
    }

    /// Asks which drive it is: the hardware version tells the gear.
    ///
    /// # Errors
    /// As [`Drive::job`], and [`DriveError::Hardware`].
    pub(crate) fn identify(&mut self) -> Result<Identity, DriveError> {
        let model = self.model()?;
        let hardware = self.read(HARDWARE, None, Width::Word)?.bits();
        let gear = Gear::ALL.into_iter().find(|gear| u32::from(gear.hardware_version()) == hardware);
        Ok(Identity { model, gear: gear.ok_or(DriveError::Hardware(hardware))? })
    }
}
