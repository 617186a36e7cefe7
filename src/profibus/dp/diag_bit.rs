//! Every bit of octets 1 to 3 of Slave_Diag, once: place, name, meaning.
//!
//! Source: EN 50170 part 8 at second hand (`docs/reference/dp-v0.md` 6.2). The octets behind are drawn in
//! [`slave_diag`](super::slave_diag).

/// What a bit of the diagnosis that is 1 says of the station.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tells {
    /// A state that belongs to normal operation.
    State,
    /// Something is wrong.
    Trouble,
    /// Nothing: the bit is 1 in every diagnosis.
    Nothing,
}

macro_rules! diag_bits {
    ($($bit:ident = $octet:literal . $n:literal: $name:literal, $one:literal, $note:literal, $tells:ident;)*) => {
        /// A bit of the diagnosis.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum DiagBit {
            $(
                #[doc = concat!("Octet ", $octet, " bit ", $n, ", ", $name, ": ", $one, ".")]
                $bit,
            )*
        }

        impl DiagBit {
            /// Every used bit, octet by octet, the lowest first.
            pub const ALL: &[Self] = &[$(Self::$bit),*];

            /// Which octet of the diagnosis, counted from 0 (the standard counts from 1).
            pub const fn octet(self) -> usize {
                match self { $(Self::$bit => $octet - 1,)* }
            }

            /// Its number in the octet, 0 to 7.
            pub const fn number(self) -> u8 {
                match self { $(Self::$bit => $n,)* }
            }

            /// The name in the standard, `Prm_Req`.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$bit => $name,)* }
            }

            /// What 1 means, in a few words.
            pub const fn one(self) -> &'static str {
                match self { $(Self::$bit => $one,)* }
            }

            /// What to know about it; empty where nothing is left to say.
            pub const fn note(self) -> &'static str {
                match self { $(Self::$bit => $note,)* }
            }

            /// What it says of the station.
            pub const fn tells(self) -> Tells {
                match self { $(Self::$bit => Tells::$tells,)* }
            }
        }
    };
}

diag_bits! {
    StationNonExistent = 1 . 0: "Station_Non_Existent", "does not exist", "set by the master", Trouble;
    StationNotReady = 1 . 1: "Station_Not_Ready", "not ready", "not ready for Data_Exchange", State;
    CfgFault = 1 . 2: "Cfg_Fault", "configuration fault", "the last Chk_Cfg was refused", Trouble;
    ExtDiag = 1 . 3: "Ext_Diag", "extended diagnosis", "the blocks behind show a fault", Trouble;
    NotSupported = 1 . 4: "Not_Supported", "asked for what it cannot do", "for example Sync or Freeze", Trouble;
    InvalidSlaveResponse = 1 . 5: "Invalid_Slave_Response", "answered wrongly", "set by the master", Trouble;
    PrmFault = 1 . 6: "Prm_Fault", "parameter fault", "the last Set_Prm was refused: ident number, length or values", Trouble;
    MasterLock = 1 . 7: "Master_Lock", "locked by another master", "set by the master", Trouble;
    PrmReq = 2 . 0: "Prm_Req", "wants parameters", "must be parameterised", State;
    StatDiag = 2 . 1: "Stat_Diag", "cannot deliver valid data", "the master must read the diagnosis again", State;
    Always1 = 2 . 2: "always 1", "1", "", Nothing;
    WdOn = 2 . 3: "WD_On", "watchdog on", "", State;
    FreezeMode = 2 . 4: "Freeze_Mode", "inputs frozen", "", State;
    SyncMode = 2 . 5: "Sync_Mode", "outputs in Sync", "", State;
    Deactivated = 2 . 7: "Deactivated", "deactivated", "set by the master", Trouble;
    ExtDiagOverflow = 3 . 7: "Ext_Diag_Overflow", "more diagnosis than fits", "", Trouble;
}

impl DiagBit {
    /// Whether it is 1 in the octets of a diagnosis; `false` where they end before it.
    pub(crate) fn is_set(self, diagnosis: &[u8]) -> bool {
        diagnosis.get(self.octet()).is_some_and(|octet| octet & self.mask() != 0)
    }

    /// The octet in which it alone is 1.
    pub(crate) const fn mask(self) -> u8 {
        1 << self.number()
    }

    /// The bit at this place, `octet` from 0; `None` if it is reserved.
    pub(crate) fn at(octet: usize, number: u8) -> Option<Self> {
        Self::ALL.iter().copied().find(|bit| (bit.octet(), bit.number()) == (octet, number))
    }
}
