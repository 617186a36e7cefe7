//! Start-up, data exchange, and back to where each row begins.

use core::time::Duration;

use super::{DIAG_LEN, Prm, Tester};
use crate::judge::device::course::{Course, Halt, broken};
use crate::judge::device::play::Trial;
use crate::judge::device::row::{Group, Table};
use crate::judge::device::slave::answer::{Answer, Diagnosis, NO_MASTER};
use crate::judge::device::slave::request::Request;
use crate::judge::device::slave::rows;
use crate::judge::device::slave::wire::Sight;
use crate::judge::device::{Ending, Soak};
use crate::judge::moment::Telegram;
use crate::profibus::dp::DiagBit;
use crate::profibus::dp::{IoLengths, Service};
use crate::profibus::fdl::{FrameCount, ReplyStatus};
use crate::profibus::ppo::PpoType;
use crate::time::Instant;

/// A slave that was just started, or searches for the rate, is looked for so long.
const LOOKS: Duration = Duration::from_secs(10);
/// Between two looks.
const LOOK_PAUSE: Duration = Duration::from_millis(50);
/// A slave checks parameters and configuration so long at most.
const READY: Duration = Duration::from_secs(5);
/// Between two diagnoses of a slave that is not ready.
const READY_PAUSE: Duration = Duration::from_millis(5);

impl Table for Tester {
    const SUBJECT: &'static str = "slave";

    fn groups() -> Vec<Group<Self>> {
        rows::groups()
    }
}

impl Trial for Tester {
    fn now(&self) -> Instant {
        self.wire.now()
    }

    fn take_shown(&mut self) -> Vec<Telegram> {
        self.shown()
    }

    fn forget_shown(&mut self) {
        self.wire.take_passed();
    }

    fn begin(&mut self) -> Course {
        self.look()?;
        let first = self.diag()?;
        self.ident = match (self.setup.ident, &self.setup.gsd) {
            (Some(ident), _) => ident,
            (None, Some(gsd)) => gsd.ident,
            (None, None) => first.ident(),
        };
        self.first = Some(first);
        self.cfg = match &self.setup.cfg {
            Some(cfg) => cfg.clone(),
            None => {
                let answer = self.serve(self.owner(), Service::GetCfg, &[])?;
                let Answer::Data(_, cfg) = answer else {
                    let answer = answer.words();
                    return broken(format!(
                        "Get_Cfg is answered with {answer}; give the configuration with cfg="
                    ));
                };
                cfg
            }
        };
        // A drive of the profile has a configuration for each PPO.
        if let Some(kind) = self.setup.profile.filter(|_| self.setup.cfg.is_none()) {
            let lengths = IoLengths::of(&self.cfg).unwrap_or_default();
            let is_of_another = PpoType::ALL.iter().any(|other| other.configuration() == self.cfg);
            if is_of_another || usize::from(lengths.outputs) != kind.len() {
                self.cfg = kind.configuration().to_vec();
            }
        }
        match IoLengths::of(&self.cfg) {
            Ok(lengths) => self.lengths = lengths,
            Err(error) => return broken(format!("its configuration is none: {error}")),
        }
        self.settle()
    }

    fn settle(&mut self) -> Course {
        self.release()
    }

    fn calm(&mut self) -> Course {
        self.wire.calm()
    }

    fn must_end(&self) -> Option<Ending> {
        self.wire.must_end()
    }

    fn noted(&mut self, id: &str) -> Option<(String, Vec<Telegram>)> {
        self.notes.against(id, self.least(id))
    }

    fn never_exchanged(&self) -> Option<String> {
        self.why_not.clone().filter(|_| !self.exchanged)
    }

    fn soak(&self) -> Option<Soak> {
        self.setup.soak
    }

    fn words(&self) -> Vec<(&'static str, String)> {
        let hex = |octets: &[u8]| octets.iter().map(|octet| format!("{octet:02X}")).collect::<String>();
        let mut slave = self.slave().to_string();
        if let Some(gsd) = &self.setup.gsd {
            slave.push_str(&format!(",gsd={}", gsd.model));
        }
        let mut words = vec![
            ("slave", slave),
            ("ident", format!("{:04X}", self.ident)),
            ("cfg", hex(&self.cfg)),
            ("prm", hex(&self.setup.user_prm())),
        ];
        if let Some(kind) = self.setup.profile {
            words.push(("profile", kind.to_string()));
        }
        if self.setup.mirror {
            words.push(("mirror", "1".into()));
        }
        if self.wire.sight != Sight::Untimed {
            words.push(("baud", self.wire.baud.bits_per_second().to_string()));
        }
        words.push(("slot", format!("{} ms", self.wire.slot().as_secs_f64() * 1000.0)));
        words
    }
}

impl Tester {
    /// What every slave answers.
    pub(super) fn probes(&self) -> [Request; 2] {
        let (slave, owner) = (self.slave(), self.owner());
        let diag = Request::of(slave, owner, Service::SlaveDiag, FrameCount::First, &[]);
        [Request::status(slave, owner), diag]
    }

    /// To WAIT-PRM, whoever owns it. What does not lead there is found by the rows about it.
    pub(in super::super) fn release(&mut self) -> Course {
        for sa in [self.owner(), self.other()] {
            self.forget_count(sa);
        }
        let diagnosis = self.diag()?;
        if diagnosis.is(DiagBit::PrmReq) && diagnosis.master() == NO_MASTER {
            return Ok(());
        }
        let owner = if diagnosis.master() < 126 { diagnosis.master() } else { self.owner() };
        let user = self.setup.user_prm();
        let [unlock, wrong] = [Prm::unlock(self.ident, user.clone()), Prm::lock(!self.ident, user)];
        for (service, data) in [
            (Service::SetPrm, unlock.octets()),
            (Service::SetPrm, wrong.octets()),
            (Service::ChkCfg, vec![0x00; 3]),
        ] {
            // Whether it is answered is for the rows about it.
            match self.serve(owner, service, &data) {
                Err(halt @ Halt::Over(_)) => return Err(halt),
                Ok(_) | Err(Halt::Broken { .. } | Halt::Missed(_) | Halt::Inapplicable(_)) => {}
            }
            if self.diag()?.is(DiagBit::PrmReq) {
                return Ok(());
            }
        }
        let telegrams = self.last_shown();
        let diagnosis = self.diag()?;
        if self.is_attended() && self.power_cycle().is_ok() && self.diag()?.is(DiagBit::PrmReq) {
            let why = format!("Unlock does not release it, it was switched off: {}", diagnosis.words());
            self.notes.breach("S-P04", || (why, telegrams));
            return Ok(());
        }
        broken(format!(
            "it does not wait for Set_Prm, neither after Unlock nor after a Set_Prm or Chk_Cfg that is wrong: {}",
            diagnosis.words()
        ))
    }

    /// Asks for its FDL status until it answers.
    pub(in super::super) fn look(&mut self) -> Course {
        let begun = self.wire.now();
        let mut unheard = false;
        loop {
            for probe in self.probes() {
                if self.ask(&probe)? == Answer::Silence {
                    unheard = true;
                    continue;
                }
                if unheard {
                    // A slave that has just come may find earlier probes waiting for it.
                    self.wire.calm()?;
                    self.wire.take_unasked();
                }
                return Ok(());
            }
            if self.wire.now().saturating_since(begun) >= LOOKS {
                return Err(Halt::Over(Ending::NoDevice));
            }
            self.wire.pass(self.wire.now().saturating_add(LOOK_PAUSE))?;
        }
    }

    /// What Set_Prm says of a slave that has nothing to be said: lock, no watchdog.
    pub(in super::super) fn prm(&self) -> Prm {
        Prm::lock(self.ident, self.setup.user_prm())
    }

    /// Set_Prm of the owner, acknowledged.
    pub(in super::super) fn set_prm(&mut self, prm: &Prm) -> Course {
        let min_tsdr = if prm.min_tsdr >= 11 { prm.min_tsdr.into() } else { self.min_tsdr };
        // Its own reply may have the new one already.
        self.min_tsdr = self.min_tsdr.min(min_tsdr);
        self.acknowledged(Service::SetPrm, &prm.octets())?;
        self.min_tsdr = min_tsdr;
        Ok(())
    }

    /// Chk_Cfg of the owner with its configuration, acknowledged.
    pub(in super::super) fn chk_cfg(&mut self) -> Course {
        let cfg = self.cfg.clone();
        self.acknowledged(Service::ChkCfg, &cfg)
    }

    /// From WAIT-PRM to data exchange with these parameters.
    pub(in super::super) fn start_with(&mut self, prm: &Prm) -> Course {
        self.set_prm(prm)?;
        let diagnosis = self.diag()?;
        if diagnosis.is(DiagBit::PrmReq) {
            return broken(format!("Set_Prm is not accepted: {}", diagnosis.words()));
        }
        self.chk_cfg()?;
        self.ready()?;
        self.control(0, 0)?;
        for _ in 0..2 {
            self.exchanged_zeros()?;
        }
        Ok(())
    }

    /// A part of the way to data exchange: why it ends before is what the judgement ends with.
    pub(in super::super) fn leads_to_exchange(&mut self, part: fn(&mut Self) -> Course) -> Course {
        let course = part(self);
        if let Err(Halt::Broken { why, .. } | Halt::Missed(why)) = &course {
            self.why_not.get_or_insert_with(|| why.clone());
        }
        course
    }

    /// From WAIT-PRM to data exchange, where every row about it begins: that it comes there is judged by other rows.
    pub(in super::super) fn start(&mut self) -> Course {
        let prm = self.prm();
        self.begin_with(&prm)
    }

    /// The same with these parameters.
    pub(in super::super) fn begin_with(&mut self, prm: &Prm) -> Course {
        match self.start_with(prm) {
            Ok(()) => Ok(()),
            Err(Halt::Broken { why, .. }) => {
                self.why_not.get_or_insert(why.clone());
                Err(Halt::Missed(format!("data exchange is not reached: {why}")))
            }
            Err(halt @ (Halt::Missed(_) | Halt::Inapplicable(_) | Halt::Over(_))) => Err(halt),
        }
    }

    /// Polls the diagnosis until the slave is ready.
    pub(in super::super) fn ready(&mut self) -> Course<Diagnosis> {
        let begun = self.wire.now();
        loop {
            let diagnosis = self.diag()?;
            if diagnosis.is(DiagBit::PrmReq) {
                return broken(format!("Chk_Cfg is not accepted: {}", diagnosis.words()));
            }
            if !diagnosis.is(DiagBit::StationNotReady) && !diagnosis.is(DiagBit::StatDiag) {
                return Ok(diagnosis);
            }
            if self.wire.now().saturating_since(begun) >= READY {
                return broken(format!(
                    "it is not ready {} s after Chk_Cfg: {}",
                    READY.as_secs(),
                    diagnosis.words()
                ));
            }
            self.wire.pass(self.wire.now().saturating_add(READY_PAUSE))?;
        }
    }

    /// Outputs of zeros.
    pub(in super::super) fn zeros(&self) -> Vec<u8> {
        vec![0; self.lengths.outputs.into()]
    }

    /// Data_Exchange with zeros, which must give the inputs.
    pub(in super::super) fn exchanged_zeros(&mut self) -> Course<Vec<u8>> {
        let outputs = self.zeros();
        self.exchanged(&outputs)
    }

    /// Data_Exchange with these outputs: the inputs.
    pub(in super::super) fn exchanged(&mut self, outputs: &[u8]) -> Course<Vec<u8>> {
        let answer = self.serve(self.owner(), Service::DataExchange, outputs)?;
        self.inputs_of(answer).map(|(_, inputs)| inputs)
    }

    /// What an answer to Data_Exchange says: its status, DL or DH, and the inputs.
    pub(in super::super) fn inputs_of(&mut self, answer: Answer) -> Course<(ReplyStatus, Vec<u8>)> {
        let expected = usize::from(self.lengths.inputs);
        let said = match answer {
            Answer::Acknowledged if expected == 0 => (ReplyStatus::DataLow, Vec::new()),
            Answer::Status(status @ (ReplyStatus::DataHigh | ReplyStatus::DataLow)) if expected == 0 => {
                (status, Vec::new())
            }
            Answer::Data(status @ (ReplyStatus::DataLow | ReplyStatus::DataHigh), inputs)
                if inputs.len() == expected =>
            {
                (status, inputs)
            }
            Answer::Silence
            | Answer::Acknowledged
            | Answer::Status(_)
            | Answer::Data(..)
            | Answer::Wrong(_) => {
                return broken(format!(
                    "Data_Exchange is answered with {}, expected {}",
                    answer.words(),
                    if expected == 0 { "SC".into() } else { format!("DL with {expected} octets") }
                ));
            }
        };
        self.exchanged = true;
        Ok(said)
    }

    /// It waits for Set_Prm, owned by nobody.
    pub(in super::super) fn waits_for_prm(&mut self, after: &str) -> Course<Diagnosis> {
        let diagnosis = self.diag()?;
        if diagnosis.is(DiagBit::PrmReq) {
            Ok(diagnosis)
        } else {
            broken(format!("after {after} it does not wait for Set_Prm: {}", diagnosis.words()))
        }
    }

    /// Data exchange goes on.
    pub(in super::super) fn still_exchanges(&mut self, after: &str) -> Course {
        let outputs = self.zeros();
        let answer = self.serve(self.owner(), Service::DataExchange, &outputs)?;
        match self.inputs_of(answer) {
            Ok(_) => Ok(()),
            Err(Halt::Broken { why, shown }) => {
                Err(Halt::Broken { why: format!("after {after}, {why}"), shown })
            }
            Err(halt @ (Halt::Missed(_) | Halt::Inapplicable(_) | Halt::Over(_))) => Err(halt),
        }
    }

    /// The octets of a diagnosis in front of the extended one.
    pub(in super::super) fn head(diagnosis: &Diagnosis) -> &[u8] {
        diagnosis.0.get(..DIAG_LEN).unwrap_or_default()
    }
}
