//! What a drive of the profile accepts of its master beside what its device file says: a PPO.

use core::fmt;

use super::ppo_of;
use crate::profibus::dp::application::Expected;
use crate::profibus::dp::{Application, Reason, Refusal};
use crate::profibus::ppo::PpoType;

/// Any application of a slave that accepts only configurations which are a PPO.
#[derive(Clone, Debug)]
pub struct PpoOnly<A> {
    /// Who judges everything else.
    pub inner: A,
    /// The only type that is accepted; `None`: any from 1 to 5.
    pub only: Option<PpoType>,
}

impl<A: Application> Application for PpoOnly<A> {
    fn judge_prm(&self, user_prm: &[u8]) -> Result<(), Refusal> {
        self.inner.judge_prm(user_prm)
    }

    fn judge_cfg(&self, configuration: &[u8], user_prm: &[u8]) -> Result<(), Refusal> {
        self.inner.judge_cfg(configuration, user_prm)?;
        let reason = match (ppo_of(configuration), self.only) {
            (Some(_), None) => return Ok(()),
            (Some(kind), Some(only)) if kind == only => return Ok(()),
            (Some(_), Some(_)) => {
                "this is another PPO than the drive is set to; choose the PPO it was started with"
            }
            (None, _) => {
                "these modules are none of PPO 1 to 5 (12, 20, 4, 12, 28 octets each way); choose the module of a PPO"
            }
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
