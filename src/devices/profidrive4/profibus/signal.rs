//! The signals of process data: name, number, and how many words each has (`dp-v1.md` 9.2).

macro_rules! signals {
    ($($signal:ident = $number:literal: $name:literal, $words:literal, $about:literal;)*) => {
        /// A signal of the process data.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Signal {
            $(
                #[doc = concat!($name, ": ", $about, ".")]
                $signal,
            )*
        }

        impl Signal {
            /// Every signal.
            pub const ALL: &'static [Self] = &[$(Self::$signal),*];

            /// Its number (PNU 915, 916, 923); 0 of a word that is free.
            pub const fn number(self) -> u16 {
                match self { $(Self::$signal => $number,)* }
            }

            /// Its name.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$signal => $name,)* }
            }

            /// Its name for programs, as `stw1`.
            pub(super) fn key(self) -> String {
                self.name().to_lowercase()
            }

            /// How many words it has.
            pub const fn words(self) -> usize {
                match self { $(Self::$signal => $words,)* }
            }

            /// What it is.
            pub const fn about(self) -> &'static str {
                match self { $(Self::$signal => $about,)* }
            }
        }
    };
}

signals! {
    Free = 0: "free", 1, "a word that is not used";
    Stw1 = 1: "STW1", 1, "control word 1";
    Zsw1 = 2: "ZSW1", 1, "status word 1";
    Stw2 = 3: "STW2", 1, "control word 2";
    Zsw2 = 4: "ZSW2", 1, "status word 2";
    NsollA = 5: "NSOLL_A", 1, "speed setpoint";
    NistA = 6: "NIST_A", 1, "actual speed";
    NsollB = 7: "NSOLL_B", 2, "speed setpoint";
    NistB = 8: "NIST_B", 2, "actual speed";
    G1Stw = 9: "G1_STW", 1, "control word of encoder 1";
    G1Zsw = 10: "G1_ZSW", 1, "status word of encoder 1";
    G1Xist1 = 11: "G1_XIST1", 2, "actual value 1 of encoder 1";
    G1Xist2 = 12: "G1_XIST2", 2, "actual value 2 of encoder 1";
    G2Stw = 13: "G2_STW", 1, "control word of encoder 2";
    G2Zsw = 14: "G2_ZSW", 1, "status word of encoder 2";
    G2Xist1 = 15: "G2_XIST1", 2, "actual value 1 of encoder 2";
    G2Xist2 = 16: "G2_XIST2", 2, "actual value 2 of encoder 2";
    Xerr = 25: "XERR", 2, "position deviation";
    Kpc = 26: "KPC", 2, "gain of the position controller";
    XistA = 28: "XIST_A", 2, "actual position";
    Satzanw = 32: "SATZANW", 1, "choice of the traversing block";
    Aktsatz = 33: "AKTSATZ", 1, "traversing block that runs";
    MdiTarpos = 34: "MDI_TARPOS", 2, "target of the master";
    MdiVelocity = 35: "MDI_VELOCITY", 2, "velocity to it";
    MdiAcc = 36: "MDI_ACC", 1, "acceleration to it";
    MdiDec = 37: "MDI_DEC", 1, "deceleration to it";
    MdiMod = 38: "MDI_MOD", 1, "way to it";
    IaistGlatt = 52: "IAIST_GLATT", 1, "actual current, smoothed";
    MistGlatt = 53: "MIST_GLATT", 1, "actual torque, smoothed";
    PistGlatt = 54: "PIST_GLATT", 1, "actual power, smoothed";
    NistAGlatt = 57: "NIST_A_GLATT", 1, "actual speed, smoothed";
    MeldNamur = 58: "MELD_NAMUR", 1, "faults as VIK-NAMUR counts them";
    Momred = 101: "MOMRED", 1, "torque reduction";
    Meldw = 102: "MELDW", 1, "message word";
    PosStw = 203: "POS_STW", 1, "control word of the positioner";
    PosZsw = 204: "POS_ZSW", 1, "status word of the positioner";
    Override = 205: "OVERRIDE", 1, "part of the velocity";
    PosStw1 = 220: "POS_STW1", 1, "control word 1 of the positioner";
    PosZsw1 = 221: "POS_ZSW1", 1, "status word 1 of the positioner";
    PosStw2 = 222: "POS_STW2", 1, "control word 2 of the positioner";
    PosZsw2 = 223: "POS_ZSW2", 1, "status word 2 of the positioner";
    FaultCode = 301: "FAULT_CODE", 1, "number of the fault";
    WarnCode = 303: "WARN_CODE", 1, "number of the warning";
}

impl Signal {
    /// The greatest number.
    pub(super) const MOST: u16 = Self::WarnCode.number();

    /// The parameter that has the same value; `None`: there is none.
    pub(super) const fn parameter(self) -> Option<u16> {
        Some(match self {
            Self::Stw1 => 967,
            Self::Zsw1 => 968,
            Self::NsollA | Self::NsollB => 20,
            Self::NistA | Self::NistB | Self::NistAGlatt => 21,
            Self::IaistGlatt => 27,
            Self::MistGlatt => 31,
            Self::XistA => 2521,
            Self::FaultCode => 2131,
            Self::WarnCode => 2132,
            Self::Free
            | Self::Stw2
            | Self::Zsw2
            | Self::G1Stw
            | Self::G1Zsw
            | Self::G1Xist1
            | Self::G1Xist2
            | Self::G2Stw
            | Self::G2Zsw
            | Self::G2Xist1
            | Self::G2Xist2
            | Self::Xerr
            | Self::Kpc
            | Self::Satzanw
            | Self::Aktsatz
            | Self::MdiTarpos
            | Self::MdiVelocity
            | Self::MdiAcc
            | Self::MdiDec
            | Self::MdiMod
            | Self::PistGlatt
            | Self::MeldNamur
            | Self::Momred
            | Self::Meldw
            | Self::PosStw
            | Self::PosZsw
            | Self::Override
            | Self::PosStw1
            | Self::PosZsw1
            | Self::PosStw2
            | Self::PosZsw2 => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_is_above_the_greatest() {
        assert!(Signal::ALL.iter().all(|signal| signal.number() <= Signal::MOST));
    }
}
