//! A drive of the profile on a bus.

use core::fmt;
use std::string::ToString;

use super::{Participant, Refusals};
use crate::device::ppo_drive::PpoDrive;
use crate::device::{Event, MAX_TELEGRAM_LEN};
use crate::dp::{self, Application, CfgFault, PrmFault, Reason};
use crate::fdl::{Address, Rates, Telegram};
use crate::time::{BaudRate, Instant};

/// A drive of the profile that says why it refuses what its device file does not admit.
#[derive(Debug)]
pub struct HostedPpoDrive<A> {
    drive: PpoDrive<A>,
    refusals: Refusals,
}

impl<A: Application> HostedPpoDrive<A> {
    /// A drive whose words of refusals go into `refusals`.
    pub const fn new(drive: PpoDrive<A>, refusals: Refusals) -> Self {
        Self { drive, refusals }
    }

    /// The drive.
    pub const fn drive(&self) -> &PpoDrive<A> {
        &self.drive
    }
}

/// The words of a refusal.
struct Words<'a, A>(&'a A, u16);

impl<A: Application> fmt::Display for Words<'_, A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.words(self.1, f)
    }
}

impl<A: Application + Send + 'static> Participant for HostedPpoDrive<A> {
    fn address(&self) -> Address {
        self.drive.address()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.drive.set_baud(baud);
    }

    fn rates(&self) -> Rates {
        self.drive.slave().description().rates
    }

    fn receive(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(Event)) {
        let mut refused = None;
        self.drive.handle_telegram(now, telegram, &mut |event| {
            if let Event::Dp(
                dp::Event::PrmRejected { fault: PrmFault::UserPrm(refusal), .. }
                | dp::Event::CfgRejected { fault: CfgFault::Refused(refusal), .. },
            ) = &event
            {
                refused = Some(refusal.reason);
            }
            news(event);
        });
        if let Some(Reason::Numbered(number)) = refused {
            let words = Words(self.drive.slave().application(), number).to_string();
            self.refusals.keep(self.drive.address(), number, words);
        }
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(Event)) {
        self.drive.handle_timeout(now, news);
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(Event),
    ) -> Option<usize> {
        self.drive.poll_transmit(now, buf, news)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        self.drive.poll_timeout()
    }

    fn watchdog_on(&self) -> bool {
        self.drive.slave().watchdog_on()
    }
}
