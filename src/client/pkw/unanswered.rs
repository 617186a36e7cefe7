//! Which parameters were asked about without an answer.

use super::profile::Profile;
use crate::devices::ag03::param::Pnu;

/// Parameters among [`Profile::probes`] that were asked about since it was last known that every job is over: a reply
/// about one of them may be the reply to any of those jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unanswered {
    /// Bit n: the parameter n behind the first probe.
    bits: u128,
}

impl Unanswered {
    pub(super) const NONE: Self = Self { bits: 0 };

    /// Nobody waits for the reply about `pnu` any more, but it may come.
    pub(super) fn add(&mut self, profile: &Profile, pnu: Pnu) {
        let [first, last] = profile.probes;
        if pnu >= first && pnu <= last {
            let behind = u32::from(pnu.number() - first.number());
            self.bits |= 1_u128.checked_shl(behind).unwrap_or(0);
        }
    }

    /// A probe for a job about `pnu`: about another parameter, and one that no reply is outstanding about. When there is
    /// none left, the replies to the oldest jobs are not expected any more.
    pub(super) fn next_probe(&mut self, profile: &Profile, pnu: Pnu) -> Pnu {
        self.unasked(profile, pnu).unwrap_or_else(|| {
            *self = Self::NONE;
            let [first, last] = profile.probes;
            if first == pnu { last } else { first }
        })
    }

    fn unasked(self, profile: &Profile, pnu: Pnu) -> Option<Pnu> {
        let [first, last] = profile.probes;
        (0..u128::BITS)
            .zip(first.number()..=last.number())
            .filter(|(behind, _)| self.bits >> behind & 1 == 0)
            .map(|(_, number)| Pnu::from_low_bits(number))
            .find(|probe| *probe != pnu)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pnu(number: u16) -> Pnu {
        Pnu::new(number).unwrap()
    }

    #[test]
    fn no_probe_comes_again_before_one_was_answered_or_all_were_used() {
        let profile = Profile { probes: [pnu(900), pnu(903)], ..Profile::PROFIDRIVE };
        let mut unanswered = Unanswered::NONE;
        let mut probes = [0; 6];
        for probe in &mut probes {
            let next = unanswered.next_probe(&profile, pnu(901));
            unanswered.add(&profile, next);
            *probe = next.number();
        }
        assert_eq!(probes, [900, 902, 903, 900, 902, 903]);
        // A job of the user counts too, one about anything else does not.
        let mut unanswered = Unanswered::NONE;
        unanswered.add(&profile, pnu(900));
        unanswered.add(&profile, pnu(899));
        unanswered.add(&profile, pnu(1036));
        assert_eq!(unanswered.next_probe(&profile, pnu(1036)), pnu(901));
    }

    #[test]
    fn probes_that_make_no_sense_do_no_harm() {
        for probes in [[903, 900], [5, 5], [0, 1999]] {
            let profile = Profile { probes: probes.map(pnu), ..Profile::PROFIDRIVE };
            let mut unanswered = Unanswered::NONE;
            for _ in 0..300 {
                let next = unanswered.next_probe(&profile, pnu(7));
                unanswered.add(&profile, next);
                assert_ne!(next, pnu(7));
            }
        }
    }
}
