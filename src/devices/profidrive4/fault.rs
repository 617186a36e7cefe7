//! Faults and warnings: number, words, and how the drive reacts.

use core::fmt;

use crate::devices::ppo_drive::Noted;

/// How the drive stops at a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// The motor is released at once.
    Coast,
    /// It brakes with the time of OFF3, then it is released.
    QuickStop,
}

macro_rules! faults {
    ($($(#[$doc:meta])* $fault:ident = $number:literal: $name:literal, $words:literal, $reaction:ident;)*) => {
        /// Why the drive is in fault. Numbers are a matter of each maker; these are of this crate.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Fault {
            $(
                #[doc = concat!("Number ", $number, ": ", $words, ".")]
                $(#[doc = ""] #[$doc])*
                $fault,
            )*
            /// Raised on purpose, with this number; the motor is released.
            Raised(u16),
        }

        impl Fault {
            /// Every fault with a cause in the drive.
            pub const ALL: &'static [Self] = &[$(Self::$fault),*];

            /// Its number in the buffer.
            pub const fn number(self) -> u16 {
                match self {
                    $(Self::$fault => $number,)*
                    Self::Raised(number) => number,
                }
            }

            /// Its name in commands.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$fault => $name,)*
                    Self::Raised(_) => "raised",
                }
            }

            /// What it is.
            pub const fn words(self) -> &'static str {
                match self {
                    $(Self::$fault => $words,)*
                    Self::Raised(_) => "raised on purpose",
                }
            }

            /// How the drive stops.
            pub const fn reaction(self) -> Reaction {
                match self {
                    $(Self::$fault => Reaction::$reaction,)*
                    Self::Raised(_) => Reaction::Coast,
                }
            }
        }
    };
}

faults! {
    Communication = 1: "communication", "Data_Exchange ended while the drive was switched on", QuickStop;
    Overload = 2: "overload", "the motor gave more than its rated torque for too long", Coast;
    Blocked = 3: "blocked", "the torque is at its limit and the shaft stands", Coast;
    MainCircuit = 4: "main-circuit", "the main circuit lost its supply while the drive was switched on", Coast;
    SignOfLife = 5: "sign-of-life", "the sign of life of the master (STW2 bits 12 to 15) failed", QuickStop;
    FollowingError = 6: "following-error", "the shaft does not follow its position setpoint", QuickStop;
    LimitSwitch = 7: "limit-switch", "the axis ran into a limit switch", QuickStop;
    Homing = 8: "homing", "referencing found no switch where it should be", QuickStop;
    Block = 9: "block", "a traversing block has a task that this drive does not do", QuickStop;
}

impl Fault {
    /// The fault of this number.
    pub fn numbered(number: u16) -> Self {
        Self::ALL.iter().copied().find(|fault| fault.number() == number).unwrap_or(Self::Raised(number))
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.number(), self.words())
    }
}

/// A fault in the buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Occurrence {
    /// Its number (PNU 945, 947).
    pub number: u16,
    /// When it came, in ms since the drive was switched on (PNU 948).
    pub millis: u32,
    /// What the drive says of it besides (PNU 949).
    pub value: i32,
}

impl Noted for Occurrence {
    fn number(&self) -> u16 {
        self.number
    }
}

/// The warnings: those that stand, and the last eight (PNU 953 to 960), the newest first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Warnings {
    last: [u16; 8],
    standing: Vec<u16>,
}

impl Warnings {
    /// The motor gives more than its rated torque.
    pub(crate) const OVERLOAD: u16 = 2;

    /// Those that stand.
    pub fn standing(&self) -> &[u16] {
        &self.standing
    }

    /// The last (0) to the eighth-last (7) one; 0 is none.
    pub fn last(&self, before: usize) -> u16 {
        self.last.get(before).copied().unwrap_or_default()
    }

    /// One stands or does not from now on; whether that is news that it does.
    pub(super) fn set(&mut self, number: u16, stands: bool) -> bool {
        let is_new = stands && !self.standing.contains(&number);
        self.standing.retain(|standing| stands || *standing != number);
        if is_new {
            self.standing.push(number);
            self.last.rotate_right(1);
            let [first, ..] = &mut self.last;
            *first = number;
        }
        is_new
    }

    /// None but those of the drive itself stands.
    pub(super) fn end_raised(&mut self) {
        self.standing.retain(|number| *number == Self::OVERLOAD);
    }

    /// What a warning is.
    pub(crate) const fn words(number: u16) -> &'static str {
        match number {
            Self::OVERLOAD => "the motor gives more than its rated torque",
            _ => "raised on purpose",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_have_numbers_and_names_of_their_own() {
        for (at, fault) in Fault::ALL.iter().enumerate() {
            let others = &Fault::ALL[..at];
            assert!(
                others.iter().all(|other| other.number() != fault.number() && other.name() != fault.name())
            );
            assert_eq!(Fault::numbered(fault.number()), *fault);
        }
        assert_eq!(Fault::numbered(7000), Fault::Raised(7000));
    }

    #[test]
    fn a_warning_is_noted_when_it_comes() {
        let mut warnings = Warnings::default();
        assert!(warnings.set(7, true) && !warnings.set(7, true) && warnings.set(Warnings::OVERLOAD, true));
        assert_eq!((warnings.last(0), warnings.last(1), warnings.last(2)), (2, 7, 0));
        warnings.end_raised();
        assert_eq!(warnings.standing(), [2]);
        warnings.set(2, false);
        assert!(warnings.standing().is_empty());
    }
}
