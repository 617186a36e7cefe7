//! How a drive stops: what 605Ah to 605Eh choose. Codes below zero belong to the device.

/// How the motor comes to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stop {
    /// Without torque.
    Coast,
    /// On the ramp of the mode, 6084h.
    SlowDownRamp,
    /// On the ramp of the quick stop, 6085h.
    QuickStopRamp,
    /// At the limit of the current.
    CurrentLimit,
    /// At the limit of the voltage.
    VoltageLimit,
}

/// 605Ah, quick stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QuickStop {
    /// How it stops.
    pub stop: Stop,
    /// Whether the drive stays in [`State::QuickStopActive`](super::State::QuickStopActive).
    pub stays: bool,
}

/// 605Bh, shutdown, and 605Ch, disable operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Disabling(pub Stop);

/// 605Dh, halt. The motor keeps its torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Halt(pub Stop);

/// 605Eh, fault reaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FaultReaction(pub Stop);

impl QuickStop {
    /// The option of a code of CiA 402.
    pub const fn of(code: i16) -> Option<Self> {
        let (stop, stays) = match code {
            0 => (Stop::Coast, false),
            1 => (Stop::SlowDownRamp, false),
            2 => (Stop::QuickStopRamp, false),
            3 => (Stop::CurrentLimit, false),
            4 => (Stop::VoltageLimit, false),
            5 => (Stop::SlowDownRamp, true),
            6 => (Stop::QuickStopRamp, true),
            7 => (Stop::CurrentLimit, true),
            8 => (Stop::VoltageLimit, true),
            ..0 | 9.. => return None,
        };
        Some(Self { stop, stays })
    }
}

impl Disabling {
    /// The option of a code of CiA 402.
    pub const fn of(code: i16) -> Option<Self> {
        match code {
            0 => Some(Self(Stop::Coast)),
            1 => Some(Self(Stop::SlowDownRamp)),
            ..0 | 2.. => None,
        }
    }
}

impl Halt {
    /// The option of a code of CiA 402.
    pub const fn of(code: i16) -> Option<Self> {
        match code {
            1 => Some(Self(Stop::SlowDownRamp)),
            2 => Some(Self(Stop::QuickStopRamp)),
            3 => Some(Self(Stop::CurrentLimit)),
            4 => Some(Self(Stop::VoltageLimit)),
            ..1 | 5.. => None,
        }
    }
}

impl FaultReaction {
    /// The option of a code of CiA 402.
    pub(crate) const fn of(code: i16) -> Option<Self> {
        match code {
            0 => Some(Self(Stop::Coast)),
            1 => Some(Self(Stop::SlowDownRamp)),
            2 => Some(Self(Stop::QuickStopRamp)),
            3 => Some(Self(Stop::CurrentLimit)),
            4 => Some(Self(Stop::VoltageLimit)),
            ..0 | 5.. => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_of_605a_to_605e_and_no_other() {
        let known = |of: &dyn Fn(i16) -> bool| -> std::vec::Vec<i16> {
            (i16::MIN..=i16::MAX).filter(|code| of(*code)).collect()
        };
        assert_eq!(known(&|code| QuickStop::of(code).is_some()), [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(known(&|code| Disabling::of(code).is_some()), [0, 1]);
        assert_eq!(known(&|code| Halt::of(code).is_some()), [1, 2, 3, 4]);
        assert_eq!(known(&|code| FaultReaction::of(code).is_some()), [0, 1, 2, 3, 4]);
        for code in 1..=4 {
            let [leaves, stays] = [code, code + 4].map(|code| QuickStop::of(code).unwrap());
            assert_eq!((leaves.stop, leaves.stays, stays.stays), (stays.stop, false, true));
        }
    }
}
