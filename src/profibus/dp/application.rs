//! Who judges what a master says about the device: the application behind the slave.
//!
//! The slave knows the layout of Set_Prm and Chk_Cfg. Whether the user parameters make sense and whether the modules
//! are there, only the application knows. It is asked while the request is carried out, so its answer is in the next
//! Slave_Diag; one that needs longer accepts what it can see at once and judges the rest later
//! ([`Station::judge_cfg`](super::Station::judge_cfg)).
//!
//! [`Fixed`] is all that a slave with a list of configurations needs. A modular station, or one that reads its GSD at
//! run time, implements [`Application`] with data of its own.

use core::fmt;
use core::ops::RangeInclusive;

/// The application of a slave, as far as it judges what a master sends.
///
/// The methods only judge: they are called with requests that may still be refused for other reasons. What was
/// accepted in the end is told by [`Event`](super::Event) and kept by [`Slave`](super::Slave).
pub trait Application {
    /// Judges the user parameters of a Set_Prm with Lock_Req that is otherwise in order: every octet behind
    /// Group_Ident. DPV1_Status_1 to 3 are the first three of a slave that has them; they and the number of octets
    /// agree with the [`Description`](super::Description) already.
    ///
    /// # Errors
    /// What is wrong: the slave shows Prm_Fault and waits for another Set_Prm.
    fn judge_prm(&self, user_prm: &[u8]) -> Result<(), Refusal>;

    /// Judges the configuration of a Chk_Cfg, 0..=244 octets in any state, under the user parameters in force.
    ///
    /// # Errors
    /// What is wrong: the slave shows Cfg_Fault and waits for Set_Prm.
    fn judge_cfg(&self, configuration: &[u8], user_prm: &[u8]) -> Result<(), Refusal>;

    /// The real configuration, which Get_Cfg reports: at most 244 octets. `accepted` is that of the last Chk_Cfg
    /// that was accepted, for stations that are whatever their master chose.
    fn configuration<'a>(&'a self, accepted: Option<&'a [u8]>) -> &'a [u8];

    /// The words of [`Reason::Numbered`], without a full stop.
    ///
    /// # Errors
    /// Those of the formatter.
    fn words(&self, number: u16, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "reason {number} of the application")
    }
}

/// Why an application refuses user parameters or a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The first octet that is wrong, from 0: of the user parameters or of the configuration.
    pub index: usize,
    /// What should be there.
    pub expected: Expected,
    /// The octet found, `None` behind the end of the request.
    pub got: Option<u8>,
    /// Why, and what to do about it.
    pub reason: Reason,
}

/// What an application expected at an octet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Expected {
    /// This octet.
    Octet(u8),
    /// An octet from the first to the second.
    Range(u8, u8),
    /// The end of the request.
    End,
    /// What the reason says: a choice of modules, a value of several octets.
    AsReasoned,
}

/// Why, in the words of the application. Copied without an allocator into every [`Event`](super::Event).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// Words that are known when the program is built.
    Text(&'static str),
    /// The number of words that are made at run time, by [`Application::words`].
    Numbered(u16),
}

impl Refusal {
    /// The refusal in words: `what` is the service, `first` the number of the octet with index 0.
    pub(super) fn write(&self, f: &mut fmt::Formatter<'_>, what: &str, first: usize) -> fmt::Result {
        write!(f, "{what} octet {}: {}", self.index + first, Octet(self.got))?;
        match self.expected {
            Expected::Octet(octet) => write!(f, ", expected {}", Octet(Some(octet)))?,
            Expected::Range(least, most) => write!(f, ", expected 0x{least:02X}..0x{most:02X}")?,
            Expected::End => write!(f, ", expected {}", Octet(None))?,
            Expected::AsReasoned => {}
        }
        match self.reason {
            Reason::Text(text) => write!(f, ": {text}"),
            Reason::Numbered(_) => Ok(()),
        }
    }
}

/// An octet of a request or its end, as a person reads it.
struct Octet(Option<u8>);

impl fmt::Display for Octet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(octet) => write!(f, "0x{octet:02X}"),
            None => f.write_str("the end"),
        }
    }
}

/// The application of a plain slave: a list of configurations, and what each octet of the user parameters may be.
///
/// ```
/// use profidrive::profibus::dp::{Application, Fixed};
///
/// // Four octets out, four in, and one user parameter of 0 to 3.
/// const DEVICE: Fixed<'static> = Fixed { configurations: &[&[0x23, 0x13]], user_prm: &[0..=3], ..Fixed::PLAIN };
/// assert!(DEVICE.judge_cfg(&[0x23, 0x13], &[]).is_ok());
/// assert!(DEVICE.judge_prm(&[4]).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fixed<'a> {
    /// The configurations Chk_Cfg accepts; Get_Cfg reports the first until another one was accepted.
    pub configurations: &'a [&'a [u8]],
    /// What each octet of the user parameters may be, the first one first, DPV1_Status included. Octets behind the
    /// end of the list may be anything.
    pub user_prm: &'a [RangeInclusive<u8>],
    /// What to do about a configuration that is in no list.
    pub cfg_advice: &'static str,
    /// What to do about a user parameter out of its range.
    pub prm_advice: &'static str,
}

impl Fixed<'_> {
    /// A slave without configurations that takes any user parameters.
    pub const PLAIN: Self = Self {
        configurations: &[],
        user_prm: &[],
        cfg_advice: "choose the modules of the slave in the master's project from the GSD of the slave",
        prm_advice: "correct the user parameters of the slave in the master's project",
    };
}

impl Application for Fixed<'_> {
    fn judge_prm(&self, user_prm: &[u8]) -> Result<(), Refusal> {
        let wrong =
            user_prm.iter().zip(self.user_prm).enumerate().find(|(_, (got, allowed))| !allowed.contains(got));
        let Some((index, (got, allowed))) = wrong else { return Ok(()) };
        Err(Refusal {
            index,
            expected: Expected::Range(*allowed.start(), *allowed.end()),
            got: Some(*got),
            reason: Reason::Text(self.prm_advice),
        })
    }

    /// A refusal names the first octet that differs from the configuration that agrees longest.
    fn judge_cfg(&self, configuration: &[u8], _: &[u8]) -> Result<(), Refusal> {
        let mut nearest: Option<(usize, &[u8])> = None;
        for candidate in self.configurations {
            if *candidate == configuration {
                return Ok(());
            }
            let agrees =
                configuration.iter().zip(*candidate).take_while(|(got, expected)| got == expected).count();
            if nearest.is_none_or(|(longest, _)| agrees > longest) {
                nearest = Some((agrees, candidate));
            }
        }
        let (index, candidate) = nearest.unwrap_or_default();
        Err(Refusal {
            index,
            expected: candidate.get(index).map_or(Expected::End, |octet| Expected::Octet(*octet)),
            got: configuration.get(index).copied(),
            reason: Reason::Text(self.cfg_advice),
        })
    }

    fn configuration<'a>(&'a self, accepted: Option<&'a [u8]>) -> &'a [u8] {
        accepted.or(self.configurations.first().copied()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: Fixed<'static> = Fixed { configurations: &[&[0xF3, 0xF2], &[0xF6]], ..Fixed::PLAIN };

    #[test]
    fn g_02_the_difference_to_the_nearest_configuration_is_named() {
        use Expected::{End, Octet};
        for (identifiers, index, expected, got) in [
            (&[0xF3, 0xF1][..], 1, Octet(0xF2), Some(0xF1)),
            (&[0xF3], 1, Octet(0xF2), None),
            (&[0xF3, 0xF2, 0x00], 2, End, Some(0x00)),
            (&[0xF6, 0xF6], 1, End, Some(0xF6)),
            (&[0x13], 0, Octet(0xF3), Some(0x13)),
            (&[], 0, Octet(0xF3), None),
        ] {
            let reason = Reason::Text(TWO.cfg_advice);
            assert_eq!(TWO.judge_cfg(identifiers, &[]), Err(Refusal { index, expected, got, reason }));
        }
        for identifiers in TWO.configurations {
            assert_eq!(TWO.judge_cfg(identifiers, &[]), Ok(()));
        }
    }

    #[test]
    fn a_list_without_configurations_accepts_none_and_reports_none() {
        let refusal = Fixed::PLAIN.judge_cfg(&[0x00], &[]).unwrap_err();
        assert_eq!((refusal.index, refusal.expected, refusal.got), (0, Expected::End, Some(0x00)));
        assert!(Fixed::PLAIN.configuration(None).is_empty());
    }

    #[test]
    fn the_first_of_the_list_is_reported_until_another_one_was_accepted() {
        assert_eq!(TWO.configuration(None), [0xF3, 0xF2]);
        assert_eq!(TWO.configuration(Some(&[0xF6])), [0xF6]);
    }
}
