//! The way to a goal as a table: what is commanded, which bits of the status word must come, what stands in the way if
//! they do not.
//!
//! The engine knows no bus, no time and no profile. A client gives the command of a step to its drive, and shows the
//! step every status word that is younger than the command. Where a status word does not say enough, a step is a
//! [`Fork`]: something is asked in it, and its rows say what comes by the answer.
//!
//! | table | for |
//! | --- | --- |
//! | `drive::course` | AG03 and AG03/1 on PROFIBUS: enabling and acknowledging |
//! | `drive::step` | AG03 and AG03/1 on PROFIBUS: motion, where answers of the parameter channel decide |
//! | `ppo::course` | drives with variable speed of PROFIDRIVE version 2 |
//! | `node::course` | CiA 402 |

/// Some bits of a status word, and the values they must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bits {
    pub(super) mask: u16,
    pub(super) value: u16,
}

impl Bits {
    /// Every status word.
    pub(super) const ANY: Self = Self { mask: 0, value: 0 };

    /// The bits of `mask` are 1.
    pub(super) const fn set(mask: u16) -> Self {
        Self { mask, value: mask }
    }

    /// The bits of `mask` are 0.
    pub(super) const fn clear(mask: u16) -> Self {
        Self { mask, value: 0 }
    }

    /// Both.
    pub(super) const fn and(self, other: Self) -> Self {
        Self { mask: self.mask | other.mask, value: self.value | other.value }
    }

    pub(super) const fn matches(self, status: u16) -> bool {
        status & self.mask == self.value
    }
}

/// How long a step may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Time {
    /// A change of state.
    Reaction,
    /// A motion.
    Motion,
}

/// One step: `A` is what it commands, `O` what stands in the way if the bits do not come in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Step<A, O> {
    pub(super) act: A,
    /// One of these ends it. None: it ends when the drive has the command.
    pub(super) until: &'static [Bits],
    /// The goal is lost without these.
    pub(super) keeps: Bits,
    pub(super) time: Time,
    pub(super) or: O,
}

/// What a status word makes of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shown {
    Wait,
    Done,
    Lost,
}

impl<A: Copy, O: Copy> Step<A, O> {
    /// A step that ends with one of these bits.
    pub(super) const fn new(act: A, until: &'static [Bits], or: O) -> Self {
        Self { act, until, keeps: Bits::ANY, time: Time::Reaction, or }
    }

    /// The same step with the time of a motion.
    pub(super) const fn moving(self) -> Self {
        Self { time: Time::Motion, ..self }
    }

    /// The same step, lost without these bits.
    pub(super) const fn keeping(self, keeps: Bits) -> Self {
        Self { keeps, ..self }
    }

    /// What a status word says that is younger than the command.
    pub(super) fn shown(&self, status: u16) -> Shown {
        if !self.keeps.matches(status) {
            Shown::Lost
        } else if self.until.is_empty() || self.until.iter().any(|bits| bits.matches(status)) {
            Shown::Done
        } else {
            Shown::Wait
        }
    }
}

/// The steps that are left, the present one first: those of a part that goals share, then those of the goal.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Course<A: 'static, O: 'static> {
    steps: &'static [Step<A, O>],
    then: &'static [Step<A, O>],
}

impl<A, O> Clone for Course<A, O> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<A, O> Copy for Course<A, O> {}

impl<A, O> Course<A, O> {
    pub(super) const fn new(steps: &'static [Step<A, O>]) -> Self {
        Self { steps, then: &[] }
    }

    /// Steps that goals share, and the steps behind them.
    pub(super) const fn and_then(steps: &'static [Step<A, O>], then: &'static [Step<A, O>]) -> Self {
        Self { steps, then }
    }

    /// The present step; `None`: the goal is reached.
    pub(super) const fn step(self) -> Option<&'static Step<A, O>> {
        match self.steps.first() {
            Some(step) => Some(step),
            None => self.then.first(),
        }
    }

    /// The present step is done.
    #[must_use]
    pub(super) const fn next(self) -> Self {
        match (self.steps, self.then) {
            ([_, steps @ ..], then) => Self { steps, then },
            ([], [_, then @ ..]) => Self { steps: &[], then },
            ([], []) => self,
        }
    }
}

/// A step that is decided by what was asked in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fork<Q, W: 'static, A: 'static, S: 'static> {
    /// The step goes on when this is answered.
    pub(super) ask: Option<Q>,
    pub(super) time: Time,
    rows: &'static [Row<W, A, S>],
}

/// If `when` holds, `act` is done and `then` comes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<W, A, S> {
    when: W,
    pub(super) act: Option<A>,
    pub(super) then: Then<S>,
}

/// What comes after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Then<S> {
    /// Nothing yet.
    Stay,
    /// That step; the same one asks again.
    Go(S),
    /// The goal is reached.
    Done,
    /// The drive shows that it does not.
    Refused,
}

impl<Q, W: Copy, A: Copy, S: Copy> Fork<Q, W, A, S> {
    /// A step without motion.
    pub(super) const fn new(ask: Option<Q>, rows: &'static [Row<W, A, S>]) -> Self {
        Self { ask, time: Time::Reaction, rows }
    }

    /// A step with the time of a motion.
    pub(super) const fn moving(ask: Option<Q>, rows: &'static [Row<W, A, S>]) -> Self {
        Self { ask, time: Time::Motion, rows }
    }

    /// The first row that holds; without one the step stays.
    pub(super) fn row(&self, holds: impl Fn(W) -> bool) -> Option<&'static Row<W, A, S>> {
        self.rows.iter().find(|row| holds(row.when))
    }
}

impl<W: Copy, A: Copy, S: Copy> Row<W, A, S> {
    pub(super) const fn new(when: W, then: Then<S>) -> Self {
        Self { when, act: None, then }
    }

    /// The row with something to do.
    pub(super) const fn act(when: W, act: A, then: Then<S>) -> Self {
        Self { when, act: Some(act), then }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_row_of_a_fork_that_holds_decides() {
        type Rows = Row<u8, char, ()>;
        const ROWS: &[Rows] =
            &[Rows::new(1, Then::Refused), Rows::act(2, 'a', Then::Go(())), Rows::new(3, Then::Done)];
        let fork = Fork::new(Some("what"), ROWS);
        for (holding, then) in [
            (&[2, 3][..], Some(Then::Go(()))),
            (&[3], Some(Then::Done)),
            (&[1, 2, 3], Some(Then::Refused)),
            (&[], None),
        ] {
            assert_eq!(fork.row(|when| holding.contains(&when)).map(|row| row.then), then, "{holding:?}");
        }
    }

    const SWITCH: Step<char, ()> = Step::new('s', &[Bits::set(1), Bits::clear(6)], ());
    const MOVE: Step<char, ()> = Step::new('m', &[], ()).keeping(Bits::set(8).and(Bits::clear(4))).moving();

    #[test]
    fn a_step_ends_with_any_of_its_bits_and_is_lost_without_those_it_keeps() {
        for (status, shown) in [(7, Shown::Done), (0, Shown::Done), (2, Shown::Wait), (6, Shown::Wait)] {
            assert_eq!(SWITCH.shown(status), shown, "{status:04X}");
        }
        for (status, shown) in [(8, Shown::Done), (12, Shown::Lost), (0, Shown::Lost)] {
            assert_eq!(MOVE.shown(status), shown, "{status:04X}");
        }
    }

    #[test]
    fn a_course_goes_through_both_parts_and_ends() {
        let mut course = Course::and_then(&[SWITCH], &[MOVE, SWITCH]);
        let acts = core::iter::from_fn(|| {
            let step = course.step();
            course = course.next();
            step.map(|step| step.act)
        });
        assert!(acts.eq(['s', 'm', 's']));
        assert_eq!(course.next().step(), None);
        assert_eq!(Course::new(&[MOVE]).step(), Some(&MOVE));
    }
}
