//! Data_Exchange as the profile PROFIDRIVE version 2 has it: a job of the parameter channel, a control word.

use core::time::Duration;

use super::Tester;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::profibus::ppo::{JobId, Pke, Pkw, PpoType, ReplyId, Stw, Zsw};

/// Octets of the parameter channel.
const PKW_LEN: usize = 8;
/// A drive carries out a job within so long.
const JOB: Duration = Duration::from_secs(3);
/// So many exchanges at least, whatever the time.
const LEAST: u32 = 5;
/// Between two exchanges.
const CYCLE: Duration = Duration::from_millis(2);

impl Tester {
    /// The PPO of the slave.
    pub(in super::super) fn profile(&self) -> Course<PpoType> {
        match self.setup.profile {
            Some(kind) => Ok(kind),
            None => inapplicable("needs profile=ppo1..ppo5"),
        }
    }

    /// Starts a drive with a parameter channel.
    pub(in super::super) fn start_channel(&mut self) -> Course {
        if !self.profile()?.has_pkw() {
            return inapplicable("this PPO has no parameter channel");
        }
        self.start()
    }

    /// One exchange: the reply of the parameter channel and the status word.
    pub(in super::super) fn exchange_ppo(&mut self, job: Pkw, stw: Stw) -> Course<(Pkw, Zsw)> {
        let has_pkw = self.profile()?.has_pkw();
        let mut outputs = Vec::new();
        if has_pkw {
            outputs.extend(job.to_octets());
        }
        outputs.extend(stw.raw().to_be_bytes());
        outputs.resize(self.lengths.outputs.into(), 0);
        let inputs = self.exchanged(&outputs)?;
        self.pause(CYCLE)?;
        let front = inputs.first_chunk::<PKW_LEN>().filter(|_| has_pkw);
        let reply = front.map_or(Pkw::ZERO, |octets| Pkw::from_octets(*octets));
        let at = if has_pkw { PKW_LEN } else { 0 };
        match inputs.get(at..).and_then(<[u8]>::first_chunk) {
            Some(zsw) => Ok((reply, Zsw::from_raw(u16::from_be_bytes(*zsw)))),
            None => broken(format!("{} octets of inputs are no PPO", inputs.len())),
        }
    }

    /// A job from the beginning: no job until there is no reply, then this one until there is one.
    pub(in super::super) fn job(&mut self, job: Pkw) -> Course<Pkw> {
        let none = self.replied(Pkw::ZERO, |reply| reply.pke.reply() == ReplyId::NoReply)?;
        if none.is_none() {
            return broken("the parameter channel goes on replying without a job");
        }
        let answers =
            |reply: Pkw| !matches!(reply.pke.reply(), ReplyId::NoReply) && reply.pke.pnu() == job.pke.pnu();
        match self.replied(job, answers)? {
            Some(reply) => Ok(reply),
            None => broken(format!(
                "'{}' of PNU {} gets no reply with this PNU within {} s",
                job.pke.job(),
                job.pke.pnu(),
                JOB.as_secs()
            )),
        }
    }

    /// Exchanges until the reply is one of these.
    fn replied(&mut self, job: Pkw, is_it: impl Fn(Pkw) -> bool) -> Course<Option<Pkw>> {
        let begun = self.wire.now();
        let mut exchanges = 0;
        while exchanges < LEAST || self.wire.now().saturating_since(begun) < JOB {
            let (reply, _) = self.exchange_ppo(job, Stw::from_raw(0))?;
            exchanges += 1;
            // What is there in the first two may be of the job before.
            if exchanges > 2 && is_it(reply) {
                return Ok(Some(reply));
            }
        }
        Ok(None)
    }

    /// The reply to reading a parameter, or an element of one.
    pub(in super::super) fn read(&mut self, pnu: u16, subindex: Option<u8>) -> Course<Pkw> {
        let job = if subindex.is_some() { JobId::ReadElement } else { JobId::Read };
        self.job(pkw(job, pnu, subindex.unwrap_or(0), 0))
    }

    /// Goes on with this control word for so long, or until the status word is one of these: the last one.
    pub(in super::super) fn hold(
        &mut self,
        stw: u16,
        time: Duration,
        is_it: impl Fn(u16) -> bool,
    ) -> Course<u16> {
        let begun = self.wire.now();
        loop {
            let zsw = self.exchange_ppo(Pkw::ZERO, Stw::from_raw(stw))?.1.raw();
            if is_it(zsw) || self.wire.now().saturating_since(begun) >= time {
                return Ok(zsw);
            }
        }
    }
}

/// A job.
pub(in super::super) const fn pkw(job: JobId, pnu: u16, subindex: u8, value: u32) -> Pkw {
    Pkw::new(Pke::of_job(job, pnu), crate::profibus::ppo::Ind::in_high_octet(subindex), value)
}
