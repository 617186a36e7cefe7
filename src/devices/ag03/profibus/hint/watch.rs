//! What a device remembers to notice what is odd. Where nothing is, each look costs one comparison.

use core::time::Duration;

use super::{Hint, Pauses};
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::{Mode, Status};
use crate::devices::ag03::profibus::bits::StwBit;
use crate::profibus::fdl::Address;
use crate::profibus::ppo::{JobId, Pkw, Stw};
use crate::time::Instant;

/// A master that asks again within this time after its watchdog expired was not gone.
const BACK_AGAIN: Duration = Duration::from_secs(1);

/// Expiries with a master that came back at once, until that is said: one may be a hiccup.
const EXPIRIES: u8 = 2;

/// What was seen, and what was said of it.
#[derive(Clone, Debug, Default)]
pub(in crate::devices::ag03::profibus) struct Watch {
    pauses: Pauses,
    /// Now, as the host said last.
    pub(in crate::devices::ag03::profibus) now: Instant,
    /// The last expiry, whose master has not asked since.
    expired: Option<Expired>,
    expiries: u8,
    /// The control word before the newest.
    stw: Stw,
    job: Pkw,
    job_before: Pkw,
    /// The outputs with which the job came, as the slave counts them.
    job_since: u32,
}

#[derive(Clone, Copy, Debug)]
struct Expired {
    master: Address,
    watchdog: Duration,
    at: Instant,
}

impl Watch {
    /// The hint, if it is to be said now.
    pub(in crate::devices::ag03::profibus) fn allow(&mut self, hint: Hint) -> Option<Hint> {
        self.pauses.allow(self.now, &hint).then_some(hint)
    }

    /// The watchdog of this master expired.
    pub(in crate::devices::ag03::profibus) const fn expired(
        &mut self,
        at: Instant,
        master: Address,
        watchdog: Duration,
    ) {
        self.expired = Some(Expired { master, watchdog, at });
    }

    /// Whether a request is of interest to [`Watch::asked`].
    pub(in crate::devices::ag03::profibus) const fn awaits_master(&self) -> bool {
        self.expired.is_some()
    }

    /// A request of this master after a watchdog expired.
    pub(in crate::devices::ag03::profibus) fn asked(&mut self, by: Address) -> Option<Hint> {
        let Expired { master, watchdog, at } = self.expired.take_if(|expired| expired.master == by)?;
        let since = self.now.saturating_since(at);
        self.expiries = if since <= BACK_AGAIN { self.expiries.saturating_add(1) } else { 0 };
        let hint = Hint::WatchdogShort { master, watchdog, gap: watchdog.saturating_add(since) };
        if self.expiries >= EXPIRIES { self.allow(hint) } else { None }
    }

    /// The drive has followed the control word `stw`; `before` is its status as it was.
    #[inline]
    pub(in crate::devices::ag03::profibus) fn commanded(
        &mut self,
        stw: Stw,
        before: &Status,
    ) -> Option<Hint> {
        if stw == self.stw { None } else { self.commanded_anew(stw, before) }
    }

    #[inline(never)]
    fn commanded_anew(&mut self, stw: Stw, before: &Status) -> Option<Hint> {
        let last = self.stw;
        if exchanged(stw) {
            return self.allow(Hint::OctetsExchanged { stw });
        }
        let acknowledges = StwBit::Acknowledge.is_set(stw) && !StwBit::Acknowledge.is_set(last);
        if acknowledges && before.turn_on_disabled && StwBit::On.is_set(stw) {
            return self.allow(Hint::AcknowledgedAlready { stw });
        }
        None
    }

    /// Takes note of the control word, behind everything that compares it with the one before.
    #[inline]
    pub(in crate::devices::ag03::profibus) const fn note(&mut self, stw: Stw) {
        self.stw = stw;
    }

    /// What an event of the drive says about the control word and the settings.
    pub(in crate::devices::ag03::profibus) fn told(
        &mut self,
        event: &drive::Event,
        stw: Stw,
        mode: Mode,
        limits: (i32, i32),
    ) -> Option<Hint> {
        match event {
            drive::Event::Enabled(_) if mode == Mode::Positioning => {
                let held = StwBit::Start.is_set(stw) && StwBit::Start.is_set(self.stw);
                let start = if held { self.allow(Hint::StartAlready { stw }) } else { None };
                start.or_else(|| self.limits(limits))
            }
            drive::Event::TravelStarted(_) => self.limits(limits),
            drive::Event::VelocityStarted(velocity) | drive::Event::VelocityChanged(velocity)
                if velocity.setpoint != velocity.rpm =>
            {
                self.allow(Hint::SetpointLimited(*velocity))
            }
            drive::Event::Enabled(_)
            | drive::Event::Disabled { .. }
            | drive::Event::Mode(_)
            | drive::Event::Paused { .. }
            | drive::Event::Resumed { .. }
            | drive::Event::TargetReached { .. }
            | drive::Event::Discarded { .. }
            | drive::Event::Stands { .. }
            | drive::Event::InchingStarted(_)
            | drive::Event::InchingEnded { .. }
            | drive::Event::VelocityStarted(_)
            | drive::Event::VelocityChanged(_)
            | drive::Event::VelocityEnded
            | drive::Event::Acknowledged
            | drive::Event::Rearmed
            | drive::Event::NotReady
            | drive::Event::Ready
            | drive::Event::Warning { .. } => None,
        }
    }

    fn limits(&mut self, (limit_1, limit_2): (i32, i32)) -> Option<Hint> {
        match limit_1.cmp(&limit_2) {
            core::cmp::Ordering::Equal => self.allow(Hint::LimitsEqual { limit: limit_1 }),
            core::cmp::Ordering::Less => self.allow(Hint::LimitsInverted { limit_1, limit_2 }),
            core::cmp::Ordering::Greater => None,
        }
    }

    /// Whether this job is another one than that of the last cycle.
    #[inline]
    pub(in crate::devices::ag03::profibus) fn is_other_job(&self, job: Pkw) -> bool {
        self.job != job
    }

    /// Another job, which came with the outputs that the slave counts as `updates`: a write that stood for one exchange
    /// only, and shares PKE with the words before it and the value with those behind it or the other way round, was no
    /// job but half of one.
    pub(in crate::devices::ag03::profibus) fn other_job(&mut self, job: Pkw, updates: u32) -> Option<Hint> {
        let (before, executed) = (self.job_before, self.job);
        let stood = updates.wrapping_sub(self.job_since);
        (self.job_before, self.job, self.job_since) = (executed, job, updates);
        let writes = match executed.pke.job() {
            JobId::WriteWord
            | JobId::WriteDoubleWord
            | JobId::WriteElementWord
            | JobId::WriteElementDoubleWord => true,
            JobId::NoJob
            | JobId::Read
            | JobId::ReadDescription
            | JobId::WriteDescription
            | JobId::ReadElement
            | JobId::ReadElementCount
            | JobId::Reserved(_) => false,
        };
        let value = |pkw: Pkw| (pkw.ind, pkw.double_word());
        let of_before = (executed.pke == before.pke, value(executed) == value(before));
        let of_next = (executed.pke == job.pke, value(executed) == value(job));
        let torn =
            matches!((of_before, of_next), ((true, false), (false, true)) | ((false, true), (true, false)));
        (writes && stood == 1 && torn)
            .then_some(Hint::JobChanged { executed, next: job })
            .and_then(|hint| self.allow(hint))
    }
}

/// Whether a control word has nothing of a low octet but control by the PLC, and both inchings at once, which are ON and OFF2 of
/// the low octet: nobody means that.
const fn exchanged(stw: Stw) -> bool {
    const CONTROL_BY_PLC: u16 = 0x0004;
    let both = StwBit::Inching1.mask() | StwBit::Inching2.mask();
    let low = stw.raw() & 0xFF;
    (low == 0 || low == CONTROL_BY_PLC) && stw.raw() & both == both
}
