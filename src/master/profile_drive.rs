//! One drive of PROFIDRIVE version 2 of a session with its client: parameters by job, goals, each call until it is done.

use super::{DriveError, Session, SessionError, Slave};
use crate::client::{Images, Job, PpoClient, PpoGoal, PpoGoalError, PpoLimits, Profile, Reply};
use crate::devices::ag03::param::{Pnu, Subindex, Value, Width};
use crate::host::{Clock, Link};
use crate::profibus::fdl::Address;
use crate::profibus::ppo::{PpoType, Stw, Zsw};

/// A drive of PROFIDRIVE version 2 that belongs to this master. Every call blocks until it is done or has failed.
#[derive(Debug)]
pub struct ProfileDrive<L, C> {
    /// The session, to look at its time and its settings, and to release the drive.
    pub session: Session<L, C>,
    address: Address,
    client: PpoClient,
}

/// The words that a drive shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Values {
    /// The control word that was sent.
    pub stw: Stw,
    /// The status word.
    pub zsw: Zsw,
    /// The actual value: 4000h is 100 % of the reference speed.
    pub actual: i16,
}

/// How a goal ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileReached {
    /// With this actual value.
    Done(i16),
    /// Not reached, and why.
    Failed(PpoGoalError),
    /// Not yet: the drive still does what it was doing.
    Interrupted,
}

impl<L: Link, C: Clock> ProfileDrive<L, C> {
    /// Takes the drive over. `profile` says how its parameter channel is.
    ///
    /// # Errors
    /// As [`Session::start_slave`].
    pub(crate) fn take(
        mut session: Session<L, C>,
        address: Address,
        slave: &Slave,
        kind: PpoType,
        profile: Profile,
    ) -> Result<Self, SessionError> {
        session.start_slave(address, slave)?;
        // profirust copies the inputs of a telegram at once.
        let profile = Profile { images: Images::Consistent, ..profile };
        Ok(Self { session, address, client: PpoClient::new(kind, profile, PpoLimits::default()) })
    }

    /// Whether it has the parameter channel.
    pub(crate) const fn has_parameters(&self) -> bool {
        self.client.kind().has_pkw()
    }

    /// Whether the end is requested ([`Session::stop`]).
    pub(crate) fn is_stopped(&self) -> bool {
        self.session.stop().is_requested()
    }

    /// One exchange.
    ///
    /// # Errors
    /// As [`Session::exchange_octets`].
    pub(crate) fn exchange(&mut self) -> Result<Values, SessionError> {
        let (mut outputs, mut inputs) = ([0; PpoClient::MOST], [0; PpoClient::MOST]);
        let outputs = self.client.outputs(&mut outputs);
        let inputs = inputs.get_mut(..self.client.kind().len()).unwrap_or_default();
        let stw = self.client.stw();
        if let Err(error) = self.session.exchange_octets(self.address, outputs, inputs) {
            self.client.handle_data_exchange_lost();
            return Err(error);
        }
        self.client.handle_inputs(self.session.now(), inputs);
        Ok(Values { stw, zsw: self.client.zsw().unwrap_or_default(), actual: self.client.actual() })
    }

    /// Does one job, to its end. The control word stays as it is meanwhile.
    ///
    /// # Errors
    /// [`DriveError`]; after [`DriveError::Unanswered`] it is not known whether the job was done.
    pub(crate) fn job(&mut self, job: Job) -> Result<Reply, DriveError> {
        self.client.submit(self.session.now(), job)?;
        loop {
            let exchanged = self.exchange();
            match (exchanged, self.client.poll_job()) {
                (Ok(_), None) => {}
                (Ok(_), Some(outcome)) => return Ok(outcome.result?),
                (Err(error), Some(_)) => return Err(DriveError::Unanswered(error)),
                (Err(error), None) => return Err(error.into()),
            }
        }
    }

    /// Reads a parameter, of an array the element; `width`, if it is known.
    ///
    /// # Errors
    /// As [`ProfileDrive::job`].
    pub(crate) fn read(
        &mut self,
        pnu: Pnu,
        element: Option<Subindex>,
        width: Option<Width>,
    ) -> Result<Value, DriveError> {
        let job = element.map_or_else(|| Job::read(pnu), |element| Job::read_element(pnu, element));
        let job = width.map_or(job, |width| job.expecting(width));
        self.value(job)
    }

    /// Writes a parameter, of an array the element, and says what the drive answers.
    ///
    /// # Errors
    /// As [`ProfileDrive::job`].
    pub(crate) fn write(
        &mut self,
        pnu: Pnu,
        element: Option<Subindex>,
        value: Value,
    ) -> Result<Value, DriveError> {
        self.value(match element {
            Some(element) => Job::write_element(pnu, element, value),
            None => Job::write(pnu, value),
        })
    }

    fn value(&mut self, job: Job) -> Result<Value, DriveError> {
        match self.job(job)? {
            Reply::Value(value) => Ok(value),
            reply @ (Reply::ElementCount(_) | Reply::Description(_)) => {
                Err(DriveError::OtherReply { job, reply })
            }
        }
    }

    /// Pursues a goal until it is reached, has failed, or the end is requested.
    ///
    /// # Errors
    /// As [`ProfileDrive::exchange`].
    pub(crate) fn reach(&mut self, goal: PpoGoal) -> Result<ProfileReached, SessionError> {
        self.client.pursue(self.session.now(), goal);
        loop {
            if let Some(outcome) = self.client.poll_outcome() {
                return Ok(outcome.result.map_or_else(ProfileReached::Failed, ProfileReached::Done));
            }
            if self.is_stopped() {
                return Ok(ProfileReached::Interrupted);
            }
            self.exchange()?;
        }
    }
}
