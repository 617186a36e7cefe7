//! Telegram 999: the master chooses which signal is in each word (PNU 915, 916).

use std::borrow::Cow;

use super::parameters::{NOT_PERMITTED, Wrong};
use super::signal::Signal;
use super::telegram::Telegram;

/// The most words of telegram 999 in each direction.
pub(super) const WORDS: usize = 16;

/// The number of the telegram.
pub(super) const NUMBER: u16 = 999;

/// Which way process data go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// From the master (PNU 915).
    Setpoints,
    /// To the master (PNU 916).
    ActualValues,
}

impl Way {
    /// The parameter that has its signals.
    pub(super) const fn pnu(self) -> u16 {
        match self {
            Self::Setpoints => 915,
            Self::ActualValues => 916,
        }
    }
}

/// The signal of each word. One of two words stands in both; alone it is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Free {
    setpoints: [Signal; WORDS],
    actual_values: [Signal; WORDS],
}

impl Free {
    /// Of a new drive: the control word and the status word in front.
    pub(super) const NEW: Self =
        Self { setpoints: begin_with(Signal::Stw1), actual_values: begin_with(Signal::Zsw1) };

    const fn words(&self, way: Way) -> &[Signal; WORDS] {
        match way {
            Way::Setpoints => &self.setpoints,
            Way::ActualValues => &self.actual_values,
        }
    }

    /// The number of the signal in a word.
    pub(super) fn number(&self, way: Way, word: usize) -> u16 {
        self.words(way).get(word).map_or(0, |signal| signal.number())
    }

    /// Another signal is in a word, if one with this number goes that way.
    pub(super) fn set(&mut self, way: Way, word: u16, number: f64) -> Result<(), Wrong> {
        let signal = signal(way, number).ok_or((NOT_PERMITTED, word))?;
        let words = match way {
            Way::Setpoints => &mut self.setpoints,
            Way::ActualValues => &mut self.actual_values,
        };
        words.iter_mut().skip(word.into()).take(1).for_each(|place| *place = signal);
        Ok(())
    }

    /// Every word, with the number of its signal.
    pub(super) fn each(&self) -> impl Iterator<Item = (Way, u8, u16)> {
        [Way::Setpoints, Way::ActualValues].into_iter().flat_map(|way| {
            (0..).zip(self.words(way)).map(move |(word, signal)| (way, word, signal.number()))
        })
    }

    /// The telegram with the signals that were chosen, if it is this one.
    pub(super) fn fill(&self, telegram: Telegram) -> Telegram {
        if telegram.number != NUMBER {
            return telegram;
        }
        let signals = |way, empty: &[Signal]| {
            Cow::Owned(signals(self.words(way).get(..empty.len()).unwrap_or_default()))
        };
        Telegram {
            setpoints: signals(Way::Setpoints, &telegram.setpoints),
            actual_values: signals(Way::ActualValues, &telegram.actual_values),
            ..telegram
        }
    }
}

const fn begin_with(signal: Signal) -> [Signal; WORDS] {
    let mut words = [Signal::Free; WORDS];
    words[0] = signal;
    words
}

/// The signal of a number that goes this way; 0 is none in particular.
pub(super) fn signal(way: Way, number: f64) -> Option<Signal> {
    let goes = |signal: Signal| {
        Telegram::ALL.iter().any(|telegram| {
            match way {
                Way::Setpoints => &telegram.setpoints,
                Way::ActualValues => &telegram.actual_values,
            }
            .contains(&signal)
        })
    };
    let is_it = |signal: &&Signal| f64::from(signal.number()) == number;
    Signal::ALL.iter().find(is_it).copied().filter(|signal| goes(*signal))
}

/// The signals of words that name them.
fn signals(mut words: &[Signal]) -> Vec<Signal> {
    let mut signals = Vec::new();
    while let [first, rest @ ..] = words {
        let whole = first.words() == 1 || rest.first() == Some(first);
        signals.push(if whole { *first } else { Signal::Free });
        words = if whole { words.get(first.words()..).unwrap_or_default() } else { rest };
    }
    signals
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_of_two_words_stands_in_both() {
        use Signal::{Free as None, NsollA, NsollB, Stw1};
        assert_eq!(signals(&[Stw1, NsollB, NsollB, None]), [Stw1, NsollB, None]);
        assert_eq!(signals(&[NsollB, Stw1, NsollB]), [None, Stw1, None]);
        assert_eq!(signals(&[NsollB, NsollB, NsollB, NsollA]), [NsollB, None, NsollA]);
    }

    #[test]
    fn only_signals_that_go_that_way_are_taken() {
        let mut free = Free::NEW;
        assert_eq!(free.set(Way::Setpoints, 1, 6.0), Err((NOT_PERMITTED, 1)), "NIST_A");
        assert_eq!(free.set(Way::ActualValues, 1, 17.0), Err((NOT_PERMITTED, 1)), "no signal");
        assert_eq!(free, Free::NEW);
        assert_eq!(free.set(Way::Setpoints, 1, 5.0), Ok(()));
        assert_eq!((free.number(Way::Setpoints, 1), free.number(Way::ActualValues, 0)), (5, 2));
        let changed = free.each().zip(Free::NEW.each()).filter(|(one, other)| one != other);
        assert_eq!(changed.map(|(one, _)| one).collect::<Vec<_>>(), [(Way::Setpoints, 1, 5)]);
    }
}
