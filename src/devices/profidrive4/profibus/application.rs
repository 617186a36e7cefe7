//! What the drive accepts of its master beside what its device file says: a telegram.

use core::fmt;

use super::telegram::Telegram;
use crate::profibus::dp::application::Expected;
use crate::profibus::dp::{Application, Reason, Refusal};

/// Any application of a slave that accepts only configurations which are a telegram.
#[derive(Clone, Debug)]
pub struct TelegramOnly<A> {
    /// Who judges everything else.
    pub inner: A,
    /// The only telegram that is accepted; `None`: any.
    pub only: Option<&'static Telegram>,
}

impl<A: Application> Application for TelegramOnly<A> {
    fn judge_prm(&self, user_prm: &[u8]) -> Result<(), Refusal> {
        self.inner.judge_prm(user_prm)
    }

    fn judge_cfg(&self, configuration: &[u8], user_prm: &[u8]) -> Result<(), Refusal> {
        self.inner.judge_cfg(configuration, user_prm)?;
        if Telegram::of_configuration(configuration, self.only).is_some() {
            return Ok(());
        }
        let reason = match Telegram::of_configuration(configuration, None) {
            Some(_) => {
                "this is another telegram than the drive is set to; choose the one it was started with"
            }
            None => "these modules are no telegram that the drive has; choose the module of one",
        };
        let got = configuration.first().copied();
        Err(Refusal { index: 0, expected: Expected::AsReasoned, got, reason: Reason::Text(reason) })
    }

    fn configuration<'a>(&'a self, accepted: Option<&'a [u8]>) -> &'a [u8] {
        self.inner.configuration(accepted)
    }

    fn words(&self, number: u16, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.inner.words(number, f)
    }
}
