//! A slave of DP-V1 that belongs to this master: data exchange, and the alarms that only its owner can acknowledge.
//!
//! profirust exchanges data by itself, and what is asked beside it would count its frames twice. Here every telegram to the slave
//! is asked in turn, with one frame count.

use core::time::Duration;

use super::acyclic::RecordError;
use super::inquiry::Answer;
use super::{Session, SessionError};
use crate::client::{AcyclicAnswer, AcyclicClient, Heard};
use crate::host::{Clock, Link};
use crate::profibus::dp::{Diagnosis, MASTER_SAP, PrmBit, Service, ext_diag};
use crate::profibus::dpv1::{AlarmHead, TypedBlock};
use crate::profibus::fdl::{Address, Sap};
use crate::time::Instant;

/// How long a slave may take to become ready behind Chk_Cfg.
const READY: Duration = Duration::from_secs(5);

/// Between two questions to a slave that is not ready.
const LOOK: Duration = Duration::from_millis(10);

/// One step of the watchdog.
const WATCHDOG_STEP: Duration = Duration::from_millis(10);

/// Octets of Slave_Diag before its blocks.
const DIAG_HEAD: usize = 6;

/// What its master sends to a slave: what its GSD and the project say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnedSlave {
    /// The ident number.
    pub ident: u16,
    /// The user parameters of Set_Prm, DPV1_Status_1 to 3 included.
    pub user_prm: Vec<u8>,
    /// The identifiers of Chk_Cfg.
    pub configuration: Vec<u8>,
    /// The outputs.
    pub outputs: Vec<u8>,
}

/// What a slave reported in its diagnosis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reported {
    /// An alarm, which waits for its acknowledgement.
    Alarm {
        /// Which.
        head: AlarmHead,
        /// What the manufacturer says about it.
        data: Vec<u8>,
    },
    /// A status message, as it stands behind its header.
    Status(Vec<u8>),
}

/// A slave that this master has taken over. Every call blocks, in bounded time; [`Owner::exchange`] has to be called more often than
/// the watchdog of the session counts.
#[derive(Debug)]
pub struct Owner<'s, L, C> {
    session: &'s mut Session<L, C>,
    address: Address,
    slave: OwnedSlave,
    client: AcyclicClient,
    /// The slave has a new diagnosis.
    urgent: bool,
    /// What it reported and nobody has taken yet: an alarm is read once.
    reported: Vec<Reported>,
}

impl<'s, L: Link, C: Clock> Owner<'s, L, C> {
    /// Takes the slave over: Set_Prm with watchdog, Chk_Cfg, and waits until it is ready. An acknowledgement is given up after
    /// `patience`.
    ///
    /// # Errors
    /// As [`Session::start`].
    pub fn take(
        session: &'s mut Session<L, C>,
        address: Address,
        slave: OwnedSlave,
        patience: Duration,
    ) -> Result<Self, RecordError> {
        if session.exchanges_with(address) {
            return Err(RecordError::Exchanging { address });
        }
        let (diagnosis, _) = session.diagnosis(address)?;
        let (got, expected) = (diagnosis.ident, slave.ident);
        if got != expected {
            return Err(SessionError::Ident { address, got, expected }.into());
        }
        if let Some(owner) = diagnosis.master.filter(|owner| *owner != session.settings().master) {
            return Err(SessionError::Locked { address, owner }.into());
        }
        let client = AcyclicClient::class_1(patience);
        let mut this = Self { session, address, slave, client, urgent: true, reported: Vec::new() };
        let prm = this.set_prm(PrmBit::LockReq.mask() | PrmBit::WdOn.mask());
        let configuration = this.slave.configuration.clone();
        this.ask(Some(Service::SetPrm), &prm)?;
        this.ask(Some(Service::ChkCfg), &configuration)?;
        this.wait_until_ready()?;
        Ok(this)
    }

    /// Exchanges data once, and reads the diagnosis if there is a new one.
    ///
    /// # Errors
    /// [`RecordError`], if the slave is lost.
    pub fn exchange(&mut self) -> Result<Vec<Reported>, RecordError> {
        self.exchange_data()?;
        if core::mem::take(&mut self.urgent) {
            let diagnosis = self.diagnosis()?;
            self.check_owner(&diagnosis)?;
        }
        Ok(core::mem::take(&mut self.reported))
    }

    /// Acknowledges an alarm at SAP 51, while data are exchanged.
    ///
    /// # Errors
    /// [`RecordError`]
    pub fn acknowledge(&mut self, alarm: AlarmHead) -> Result<(), RecordError> {
        let now = self.session.now();
        self.client.acknowledge(now, alarm)?;
        loop {
            let now = self.session.now();
            let Some(sent) = self.client.poll_transmit(now) else { return Ok(()) };
            let answer = self.session.ask(self.address, Some((sent.dsap, sent.ssap)), sent.data)?;
            let done = match self.client.handle(self.session.now(), heard(&answer)) {
                Some(Ok(AcyclicAnswer::Acknowledged)) => true,
                Some(Ok(
                    AcyclicAnswer::Opened { .. }
                    | AcyclicAnswer::Read(_)
                    | AcyclicAnswer::Written
                    | AcyclicAnswer::Closed,
                ))
                | None => false,
                Some(Err(error)) => return Err(error.into()),
            };
            if done {
                return Ok(());
            }
            self.exchange_data()?;
        }
    }

    /// Waits, while the slave keeps its outputs.
    ///
    /// # Errors
    /// [`SessionError::Stopped`], [`SessionError::Link`]
    pub fn pause(&mut self, time: Duration) -> Result<(), SessionError> {
        self.session.pause(time)
    }

    /// The time of the session.
    pub fn now(&self) -> Instant {
        self.session.now()
    }

    /// Unlocks the slave for other masters.
    ///
    /// # Errors
    /// [`RecordError::Session`]
    pub fn release(mut self) -> Result<(), RecordError> {
        self.session.stop().clear();
        let prm = self.set_prm(PrmBit::UnlockReq.mask());
        self.ask(Some(Service::SetPrm), &prm).map(drop)
    }

    fn set_prm(&self, station_status: u8) -> Vec<u8> {
        let [high, low] = self.slave.ident.to_be_bytes();
        let (first, second) = factors(self.session.settings().watchdog);
        let head = [station_status, first, second, MIN_TSDR, high, low, 0];
        [&head, self.slave.user_prm.as_slice()].concat()
    }

    fn wait_until_ready(&mut self) -> Result<(), RecordError> {
        let begun = self.session.now();
        loop {
            let diagnosis = self.diagnosis()?;
            let address = self.address;
            if diagnosis.prm_fault {
                return Err(SessionError::PrmRefused { address }.into());
            }
            if diagnosis.cfg_fault {
                return Err(SessionError::CfgRefused { address }.into());
            }
            self.check_owner(&diagnosis)?;
            if !diagnosis.station_not_ready {
                return Ok(());
            }
            let waited = self.session.now().saturating_since(begun);
            if waited > READY {
                return Err(SessionError::NotReady { address, waited }.into());
            }
            self.session.pause(LOOK)?;
        }
    }

    /// Whether the slave is still ours.
    fn check_owner(&self, diagnosis: &Diagnosis) -> Result<(), SessionError> {
        let address = self.address;
        match diagnosis.master {
            Some(owner) if owner == self.session.settings().master => Ok(()),
            Some(owner) => Err(SessionError::Taken { address, owner }),
            None => Err(SessionError::Restarted { address }),
        }
    }

    fn exchange_data(&mut self) -> Result<(), RecordError> {
        let outputs = core::mem::take(&mut self.slave.outputs);
        let answer = self.ask(None, &outputs);
        self.slave.outputs = outputs;
        match answer? {
            Answer::Urgent(_) => self.urgent = true,
            // It left data exchange: its diagnosis says why.
            Answer::NotActivated => self.urgent = true,
            Answer::Silence
            | Answer::Station(_, _)
            | Answer::ShortAcknowledge
            | Answer::NothingToSay
            | Answer::NoResource => {}
        }
        Ok(())
    }

    fn diagnosis(&mut self) -> Result<Diagnosis, RecordError> {
        let address = self.address;
        match self.ask(Some(Service::SlaveDiag), &[])? {
            Answer::Station(_, octets) | Answer::Urgent(octets) => {
                let diagnosis = Diagnosis::parse(&octets).ok_or(SessionError::NoSlave { address })?;
                let blocks = ext_diag::blocks(octets.get(DIAG_HEAD..).unwrap_or_default());
                self.reported.extend(blocks.filter_map(reported));
                Ok(diagnosis)
            }
            Answer::Silence
            | Answer::ShortAcknowledge
            | Answer::NothingToSay
            | Answer::NotActivated
            | Answer::NoResource => Err(SessionError::NoSlave { address }.into()),
        }
    }

    /// Asks for a service of DP, `None`: Data_Exchange.
    fn ask(&mut self, service: Option<Service>, data: &[u8]) -> Result<Answer, RecordError> {
        let dsap = service.and_then(Service::sap).map(Sap::number);
        let saps = dsap.zip(MASTER_SAP.map(Sap::number));
        let answer = self.session.ask(self.address, saps, data)?;
        if answer == Answer::Silence {
            return Err(SessionError::Silent { address: self.address }.into());
        }
        Ok(answer)
    }
}

/// The least time before a slave answers, in bit times.
const MIN_TSDR: u8 = 11;

/// The two factors of Set_Prm of a watchdog time, rounded up.
fn factors(watchdog: Duration) -> (u8, u8) {
    const MOST: u128 = 255;
    let steps = watchdog.as_millis().div_ceil(WATCHDOG_STEP.as_millis()).clamp(1, MOST * MOST);
    let first = steps.div_ceil(MOST);
    let octet = |factor: u128| u8::try_from(factor).unwrap_or(u8::MAX);
    (octet(first), octet(steps.div_ceil(first)))
}

/// What layer 2 brought.
pub(super) fn heard(answer: &Answer) -> Heard<'_> {
    match answer {
        Answer::Silence => Heard::Silence,
        Answer::ShortAcknowledge | Answer::NothingToSay => Heard::Acknowledged,
        Answer::Station(_, data) | Answer::Urgent(data) => Heard::Data(data),
        Answer::NotActivated => Heard::NotActivated,
        Answer::NoResource => Heard::NoResource,
    }
}

/// What a block of the diagnosis reports, if it is device-related.
fn reported(block: &[u8]) -> Option<Reported> {
    Some(match TypedBlock::of_block(block)? {
        TypedBlock::Alarm { head, data } => Reported::Alarm { head, data: data.to_vec() },
        TypedBlock::Status { .. } => Reported::Status(block.get(1..).unwrap_or_default().to_vec()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factors_of_a_watchdog_time_are_never_too_short() {
        for (millis, expected) in [
            (0, (1, 1)),
            (10, (1, 1)),
            (1000, (1, 100)),
            (2550, (1, 255)),
            (2551, (2, 128)),
            (10_000_000, (255, 255)),
        ] {
            assert_eq!(factors(Duration::from_millis(millis)), expected, "{millis}");
        }
    }
}
