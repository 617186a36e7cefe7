//! What a second master does, as data.

use crate::judge::master::rows::Row;

/// What a second master does on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Course {
    /// It works in the ring: it asks for FDL status, reads a slave of the other master, and then takes no token any more.
    Works,
    /// It passes the token on to a third master, which passes it back; then it takes none any more.
    Third,
    /// It leaves the ring while it has the token.
    LeavesWithToken,
    /// It answers FDL status with 'not ready', and only listens.
    Listens,
    /// It passes the token in the name of a station that is not in the ring.
    Strange,
    /// It keeps the token longer than the target rotation time.
    Slow,
    /// It sends in the name of the master under test.
    Double,
    /// It has a ring by itself when the master is switched on, and lets it in.
    Runs,
    /// It is of class 1, enters the ring, and exchanges data with its slaves without end.
    Owns,
}

/// What it does with one token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Duty {
    /// Asks the FDL status of the master under test, and passes the token.
    AskMaster,
    /// Reads the diagnosis of a slave, and passes the token.
    ReadDiagnosis,
    /// Reads the inputs of a slave, and passes the token.
    ReadInputs,
    /// Asks each slave that it owns once, and passes the token.
    Exchange,
    /// Passes the token on to a third master, which asks the FDL status of the master under test and passes the token back.
    PassOn,
    /// Asks until twice the target rotation time is over, and passes the token.
    Hold,
    /// Passes the token in the name of a station that is not in the ring.
    PassAsStranger,
    /// Sends twice in the name of the master under test, and passes the token.
    SendAsMaster,
    /// Asks once, and says nothing more.
    Keep,
    /// Does not take it.
    Ignore,
}

impl Course {
    /// What it does with each token, the last one for good.
    pub(super) const fn duties(self) -> &'static [Duty] {
        match self {
            Self::Works => &[
                Duty::AskMaster,
                Duty::ReadDiagnosis,
                Duty::ReadInputs,
                Duty::ReadDiagnosis,
                // A start-up takes five rotations.
                Duty::AskMaster,
                Duty::AskMaster,
                Duty::AskMaster,
                Duty::AskMaster,
                Duty::AskMaster,
                Duty::AskMaster,
                Duty::AskMaster,
                Duty::AskMaster,
                Duty::Ignore,
            ],
            Self::Third => &[Duty::AskMaster, Duty::PassOn, Duty::PassOn, Duty::PassOn, Duty::Ignore],
            Self::LeavesWithToken => &[Duty::AskMaster, Duty::Keep],
            Self::Listens => &[],
            Self::Strange => &[Duty::AskMaster, Duty::PassAsStranger, Duty::AskMaster, Duty::Ignore],
            Self::Slow => {
                &[Duty::AskMaster, Duty::Hold, Duty::AskMaster, Duty::Hold, Duty::AskMaster, Duty::Ignore]
            }
            Self::Runs => &[Duty::Ignore],
            Self::Owns => &[Duty::Exchange],
            Self::Double => &[Duty::AskMaster, Duty::SendAsMaster],
        }
    }

    /// The row that is about what only this course does.
    pub(in crate::judge) const fn row(self) -> Row {
        match self {
            Self::Works => Row::R04,
            Self::Third => Row::R03,
            Self::LeavesWithToken => Row::R07,
            Self::Listens => Row::R02,
            Self::Strange => Row::R05,
            Self::Slow => Row::R08,
            Self::Double => Row::R06,
            Self::Runs => Row::R10,
            Self::Owns => Row::R09,
        }
    }
}
