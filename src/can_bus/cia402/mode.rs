//! Modes of operation, 6060h.

/// A mode of operation. The bit of 6502h is the number of the mode minus 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    /// 1: to positions, each with a profile.
    ProfilePosition,
    /// 2: at speeds, of frequency converters.
    Velocity,
    /// 3: at speeds.
    ProfileVelocity,
    /// 4: with torques.
    ProfileTorque,
    /// 6: seek the home position.
    Homing,
    /// 7: positions with each SYNC.
    InterpolatedPosition,
    /// 8: a position in each cycle.
    CyclicPosition,
    /// 9: a speed in each cycle.
    CyclicVelocity,
    /// 10: a torque in each cycle.
    CyclicTorque,
}

impl Mode {
    /// The mode of a code, `None` for 0 and codes of other modes.
    pub(crate) const fn of(code: i8) -> Option<Self> {
        match code {
            1 => Some(Self::ProfilePosition),
            2 => Some(Self::Velocity),
            3 => Some(Self::ProfileVelocity),
            4 => Some(Self::ProfileTorque),
            6 => Some(Self::Homing),
            7 => Some(Self::InterpolatedPosition),
            8 => Some(Self::CyclicPosition),
            9 => Some(Self::CyclicVelocity),
            10 => Some(Self::CyclicTorque),
            ..=0 | 5 | 11.. => None,
        }
    }

    /// The code of the mode.
    pub const fn code(self) -> i8 {
        match self {
            Self::ProfilePosition => 1,
            Self::Velocity => 2,
            Self::ProfileVelocity => 3,
            Self::ProfileTorque => 4,
            Self::Homing => 6,
            Self::InterpolatedPosition => 7,
            Self::CyclicPosition => 8,
            Self::CyclicVelocity => 9,
            Self::CyclicTorque => 10,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_is_its_code_and_the_codes_are_bits_of_6502h() {
        let modes = (i8::MIN..=i8::MAX).filter_map(|code| Mode::of(code).map(|mode| (code, mode)));
        let mut bits = 0_u32;
        for (code, mode) in modes {
            assert_eq!(mode.code(), code);
            bits |= 1 << (code - 1);
        }
        assert_eq!(bits, 0x3EF);
    }
}
