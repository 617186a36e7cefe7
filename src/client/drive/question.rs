//! What the client reads from the drive for its goals.

use super::obstacle::{Findings, Obstacles};
use crate::client::{Job, Reply};
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param::{Gear, Parameter, Reading, Subindex};
use crate::devices::ag03::profibus::bits::ZswBit;

/// A parameter the client reads. The reply also shows that the drive has seen the control word it was sent with:
/// both travel in one image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Question {
    OperatingMode,
    HardwareVersion,
    Window,
    DeltaInch,
    SystemStatus,
    GeneralStatus,
    NewestFault,
    Limit1,
    Limit2,
    PosType,
}

impl Question {
    /// The job that reads it, by the parameter table.
    pub(super) fn job(self) -> Job {
        let entry = match self {
            Self::OperatingMode => Parameter::OperatingMode.entry(),
            Self::HardwareVersion => Reading::HardwareVersion.entry(),
            Self::Window => Parameter::PosWindow.entry(),
            Self::DeltaInch => Parameter::DeltaInch.entry(),
            Self::SystemStatus => Reading::SystemStatus.entry(),
            Self::GeneralStatus => Reading::GeneralStatus.entry(),
            Self::NewestFault => Reading::FaultBuffer.entry(),
            Self::Limit1 => Parameter::Limit1.entry(),
            Self::Limit2 => Parameter::Limit2.entry(),
            Self::PosType => Parameter::PosType.entry(),
        };
        let read = match entry.elements {
            None => Job::read(entry.pnu),
            Some(_) => Job::read_element(entry.pnu, Subindex(0)),
        };
        read.expecting(entry.width)
    }
}

impl Findings {
    /// Notes the answer to a question and gives its bits.
    pub(super) fn note(&mut self, question: Question, reply: Reply) -> Option<u32> {
        let Reply::Value(value) = reply else {
            return None;
        };
        // What is asked as a word fits in one: its job says so.
        let [_, _, high, low] = value.bits().to_be_bytes();
        let word = u16::from_be_bytes([high, low]);
        match question {
            Question::OperatingMode => self.mode = Mode::of_number(word),
            Question::HardwareVersion => {
                self.gear = Gear::of_hardware_version(word);
            }
            Question::Window | Question::DeltaInch => {}
            Question::SystemStatus => self.ssw = Some(word),
            Question::GeneralStatus => self.general_status = Some(word),
            Question::NewestFault => self.fault_code = Some(low),
            Question::Limit1 => self.limits = [Some(value.bits().cast_signed()), self.limits[1]],
            Question::Limit2 => self.limits = [self.limits[0], Some(value.bits().cast_signed())],
            Question::PosType => self.pos_type = Some(word),
        }
        Some(value.bits())
    }
}

impl Obstacles {
    /// What to ask next to find out why the goal was not reached.
    pub(super) fn question_after(&self, question: Option<Question>) -> Option<Question> {
        const ALL: [Question; 6] = [
            Question::SystemStatus,
            Question::GeneralStatus,
            Question::NewestFault,
            Question::Limit1,
            Question::Limit2,
            Question::PosType,
        ];
        // Without Data_Exchange nobody would answer.
        let zsw = self.findings.zsw?;
        let asked = question.and_then(|question| ALL.iter().position(|other| *other == question));
        let rest = ALL.into_iter().skip(asked.map_or(0, |index| index + 1));
        rest.into_iter().find(|question| match question {
            Question::SystemStatus | Question::GeneralStatus => true,
            Question::NewestFault => ZswBit::Fault.is_set(zsw),
            Question::Limit1 | Question::Limit2 | Question::PosType => self.goal.target().is_some(),
            Question::OperatingMode | Question::HardwareVersion | Question::Window | Question::DeltaInch => {
                false
            }
        })
    }
}
