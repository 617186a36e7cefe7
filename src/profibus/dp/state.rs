//! The slave machine: three states and what moves it (`dp-v0.md` 7).
//!
//! Pure: given a state and a stimulus it names the next state. The reactions are in [`slave`](super::slave).

/// State of the slave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum State {
    /// Waits for Set_Prm: nobody owns the slave.
    #[default]
    #[doc(alias = "Wait_Prm")]
    WaitPrm,
    /// Owned, waits for Chk_Cfg.
    #[doc(alias = "Wait_Cfg")]
    WaitCfg,
    /// Exchanges data with its owner.
    #[doc(alias = "Data_Exch")]
    DataExch,
}

/// What happened, judged already: who may do what is decided by `Service::access`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stimulus {
    /// Set_Prm with Lock_Req, everything in order.
    PrmAccepted,
    /// The Set_Prm that was accepted last once more, octet for octet, in DATA-EXCH, where the policy lets it stay.
    PrmRepeated,
    /// Set_Prm with a fault.
    PrmRejected,
    /// Set_Prm with neither lock nor unlock: min T_SDR only.
    MinTsdrOnly,
    /// Set_Prm with Unlock_Req.
    Unlocked,
    /// Set_Prm of a master that does not own the locked slave.
    ForeignPrm,
    /// Chk_Cfg with an accepted configuration.
    CfgAccepted,
    /// Chk_Cfg with an accepted configuration that the application has yet to judge.
    CfgPending,
    /// Chk_Cfg with another one, or one the application refuses.
    CfgRejected,
    /// Data_Exchange with the configured number of output octets.
    Outputs,
    /// Data_Exchange without outputs to a slave with Fail_Safe: the safe state.
    NoOutputs,
    /// Data_Exchange with another number of octets.
    WrongOutputLength,
    /// The owner was silent for the watchdog time.
    WatchdogExpired,
    /// The application gave up, or was silent for the user watchdog time.
    ApplicationLost,
}

impl State {
    /// Every state, in the order of the start-up.
    pub const ALL: [Self; 3] = [Self::WaitPrm, Self::WaitCfg, Self::DataExch];

    /// The standard's name: `WAIT-PRM`.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::WaitPrm => "WAIT-PRM",
            Self::WaitCfg => "WAIT-CFG",
            Self::DataExch => "DATA-EXCH",
        }
    }

    /// The state after `stimulus`. The numbers are the rows of `dp-v0.md` 7.
    #[must_use]
    pub(crate) const fn on(self, stimulus: Stimulus) -> Self {
        match (self, stimulus) {
            // Rows 3, 11, 22: accepted parameters wait for a configuration, also where data were exchanged.
            (Self::WaitPrm | Self::WaitCfg | Self::DataExch, Stimulus::PrmAccepted) => Self::WaitCfg,
            // Row 22 with `SetPrmInDataExch::StayIfIdentical`; elsewhere it is an accepted Set_Prm.
            (Self::DataExch, Stimulus::PrmRepeated) => Self::DataExch,
            (Self::WaitPrm | Self::WaitCfg, Stimulus::PrmRepeated) => Self::WaitCfg,
            // Rows 4, 13.
            (Self::WaitPrm | Self::WaitCfg | Self::DataExch, Stimulus::PrmRejected) => Self::WaitPrm,
            // Row 12.
            (Self::WaitPrm | Self::WaitCfg | Self::DataExch, Stimulus::Unlocked) => Self::WaitPrm,
            // Rows 5, 14.
            (Self::WaitPrm, Stimulus::MinTsdrOnly | Stimulus::ForeignPrm) => Self::WaitPrm,
            (Self::WaitCfg, Stimulus::MinTsdrOnly | Stimulus::ForeignPrm) => Self::WaitCfg,
            (Self::DataExch, Stimulus::MinTsdrOnly | Stimulus::ForeignPrm) => Self::DataExch,
            // Rows 8, 20.
            (Self::WaitCfg | Self::DataExch, Stimulus::CfgAccepted) => Self::DataExch,
            // Row 9: nothing is exchanged until the application has judged.
            (Self::WaitCfg | Self::DataExch, Stimulus::CfgPending) => Self::WaitCfg,
            // Rows 10, 21.
            (Self::WaitCfg | Self::DataExch, Stimulus::CfgRejected) => Self::WaitPrm,
            // Row 7: closed without an owner.
            (Self::WaitPrm, Stimulus::CfgAccepted | Stimulus::CfgPending | Stimulus::CfgRejected) => {
                Self::WaitPrm
            }
            // Rows 16, 17.
            (Self::DataExch, Stimulus::Outputs | Stimulus::NoOutputs) => Self::DataExch,
            // Row 18.
            (Self::DataExch, Stimulus::WrongOutputLength) => Self::WaitPrm,
            // Rows 7, 19: closed outside Data_Exchange.
            (Self::WaitPrm, Stimulus::Outputs | Stimulus::NoOutputs | Stimulus::WrongOutputLength) => {
                Self::WaitPrm
            }
            (Self::WaitCfg, Stimulus::Outputs | Stimulus::NoOutputs | Stimulus::WrongOutputLength) => {
                Self::WaitCfg
            }
            // Row 25.
            (Self::WaitPrm | Self::WaitCfg | Self::DataExch, Stimulus::ApplicationLost) => Self::WaitPrm,
            // Row 15.
            (Self::WaitPrm | Self::WaitCfg | Self::DataExch, Stimulus::WatchdogExpired) => Self::WaitPrm,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_transition_table() {
        use State::{DataExch as Dx, WaitCfg as Cfg, WaitPrm as Prm};
        for (stimulus, next) in [
            //                             from WaitPrm, WaitCfg, DataExch
            (Stimulus::PrmAccepted, [Cfg, Cfg, Cfg]),
            (Stimulus::PrmRepeated, [Cfg, Cfg, Dx]),
            (Stimulus::PrmRejected, [Prm, Prm, Prm]),
            (Stimulus::MinTsdrOnly, [Prm, Cfg, Dx]),
            (Stimulus::Unlocked, [Prm, Prm, Prm]),
            (Stimulus::ForeignPrm, [Prm, Cfg, Dx]),
            (Stimulus::CfgAccepted, [Prm, Dx, Dx]),
            (Stimulus::CfgPending, [Prm, Cfg, Cfg]),
            (Stimulus::CfgRejected, [Prm, Prm, Prm]),
            (Stimulus::Outputs, [Prm, Cfg, Dx]),
            (Stimulus::NoOutputs, [Prm, Cfg, Dx]),
            (Stimulus::WrongOutputLength, [Prm, Cfg, Prm]),
            (Stimulus::WatchdogExpired, [Prm, Prm, Prm]),
            (Stimulus::ApplicationLost, [Prm, Prm, Prm]),
        ] {
            for (state, expected) in State::ALL.into_iter().zip(next) {
                assert_eq!(state.on(stimulus), expected, "{state:?} on {stimulus:?}");
            }
        }
    }
}
