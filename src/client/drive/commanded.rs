//! What the outputs command: control word, start bit, setpoint, and the travel job they stand for.

use super::control_word::ControlWord;
use super::goal::Goal;
use super::job::TravelJob;
use crate::client::pkw::{Outcome, Reply};
use crate::devices::ag03::param::Value;
use crate::devices::ag03::profibus::bits::{SswBit, ZswBit};
use crate::profibus::ppo::{Stw, Zsw};

/// What is commanded; at first nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Commanded {
    pub(super) word: ControlWord,
    /// STW.6 as it rests in positioning mode.
    pub(super) start: bool,
    pub(super) setpoint: i32,
    pub(super) job: TravelJob,
}

impl Commanded {
    pub(super) const NOTHING: Self =
        Self { word: ControlWord::Off, start: false, setpoint: 0, job: TravelJob::None };

    pub(super) const fn stw(&self) -> Stw {
        self.word.stw(self.start)
    }

    /// Whether the shaft turns by it, or may.
    pub(super) const fn turns(&self) -> bool {
        self.job.is_possible()
            || matches!(self.word, ControlWord::Inch | ControlWord::Jog(_) | ControlWord::Turn)
    }

    /// Whether the shaft turns by a velocity.
    pub(super) const fn is_velocity(&self) -> bool {
        matches!(self.word, ControlWord::Turn) && self.setpoint != 0
    }

    /// Back to "enabled and nothing else", if operation is enabled at all.
    pub(super) const fn halt(&mut self) {
        self.job = TravelJob::None;
        if self.word.enables() {
            self.word = ControlWord::Enabled;
        }
    }

    /// A control word that ends every job.
    pub(super) const fn end_job_with(&mut self, word: ControlWord) {
        self.word = word;
        self.start &= word.enables();
        self.job = TravelJob::None;
    }

    /// Takes a velocity back when the answer to [`Question::SystemStatus`](super::question::Question) says that the
    /// output stage is off: ZSW of an AG03 does not show it while the shaft runs out (row 3b).
    pub(super) fn note_output_stage(&mut self, answer: Outcome) {
        if let Ok(Reply::Value(Value::Word(ssw))) = answer.result
            && SswBit::NoOutputStage.is_set(ssw)
            && self.word == ControlWord::Turn
        {
            self.halt();
        }
    }

    /// What of a new goal cannot wait for anything. `begins`: a turning was commanded and not reached yet.
    pub(super) fn begin(&mut self, goal: Goal, begins: bool) {
        match goal {
            Goal::Stop => self.halt(),
            // The drive takes no job while it has one.
            Goal::MoveTo(_) | Goal::Inch | Goal::Jog(_) if self.job.is_possible() => self.halt(),
            Goal::Disable if self.word != ControlWord::Off => self.end_job_with(ControlWord::Disabled),
            Goal::Pause if self.job.is_possible() => self.word = ControlWord::Paused,
            Goal::Resume if self.job.is_possible() => self.word = ControlWord::Travel,
            // Another velocity takes over without a stop.
            Goal::Velocity(_) if self.word == ControlWord::Turn => {}
            // Inching ends, and so does a velocity that was not reached; a travel job or a velocity goes on until the
            // new goal changes it.
            Goal::Enable
            | Goal::Acknowledge
            | Goal::MoveTo(_)
            | Goal::Pause
            | Goal::Resume
            | Goal::Inch
            | Goal::Jog(_)
            | Goal::Velocity(_)
            | Goal::Disable => {
                let inches = matches!(self.word, ControlWord::Inch | ControlWord::Jog(_));
                if inches || begins && self.word == ControlWord::Turn {
                    self.word = ControlWord::Enabled;
                }
            }
        }
    }

    /// Takes the control word back to 000B when a motion ends by what happens to the drive: what a level of STW asks
    /// for would begin again by itself when the supply or the enable input comes back. `begins`: a motion is about to begin, or passes through standstill.
    pub(super) fn note_lost_motion(&mut self, zsw: Zsw, begins: bool) {
        let enabled = ZswBit::OperationEnabled.is_set(zsw) && !ZswBit::Fault.is_set(zsw);
        let ended = ZswBit::Standstill.is_set(zsw) && !begins;
        let lost = match self.word {
            ControlWord::Off
            | ControlWord::Off1
            | ControlWord::Disabled
            | ControlWord::Acknowledging
            | ControlWord::Enabled => !enabled && self.job != TravelJob::None,
            // Only an edge begins these, and STW.5 continues only a job that the drive still has.
            ControlWord::Travel | ControlWord::Paused | ControlWord::Inch => !enabled,
            ControlWord::Jog(_) => !enabled || ended,
            ControlWord::Turn => !enabled || ended && self.setpoint != 0,
        };
        if lost {
            self.halt();
        }
    }
}
