//! Which drive: two models with two gears each.

use core::fmt;
use core::str::FromStr;

use thiserror::Error;

/// Which of the two drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Model {
    /// SIKO AG03 (firmware 3.00 and later).
    Ag03,
    /// SIKO AG03/1 (firmware 1.00 and later).
    Ag03_1,
}

impl Model {
    /// Both models.
    pub const ALL: [Self; 2] = [Self::Ag03, Self::Ag03_1];

    /// As the manuals write it: `AG03`, `AG03/1`.
    pub(crate) const fn product_name(self) -> &'static str {
        match self {
            Self::Ag03 => "AG03",
            Self::Ag03_1 => "AG03/1",
        }
    }
}

impl fmt::Display for Model {
    /// `ag03` or `ag03-1`, as [`FromStr`] reads it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ag03 => "ag03",
            Self::Ag03_1 => "ag03-1",
        })
    }
}

impl FromStr for Model {
    type Err = ModelError;

    /// Reads `ag03` or `ag03-1`, in capitals or not.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        if text.eq_ignore_ascii_case("ag03") {
            Ok(Self::Ag03)
        } else if text.eq_ignore_ascii_case("ag03-1") {
            Ok(Self::Ag03_1)
        } else {
            Err(ModelError)
        }
    }
}

/// A text that names no model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("unknown model; expected ag03 or ag03-1")]
pub struct ModelError;

/// Reduction of the internal gear, PNU 961.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Gear {
    /// 24:1, up to 200 rpm.
    Ratio24,
    /// 48:1, up to 100 rpm.
    Ratio48,
}

impl Gear {
    /// Both gears.
    pub const ALL: [Self; 2] = [Self::Ratio24, Self::Ratio48];

    /// The gear that turns fastest.
    pub(crate) const FASTEST: Self = Self::Ratio24;

    /// The gear of a drive with this hardware version (PNU 961).
    pub(crate) const fn of_hardware_version(version: u16) -> Option<Self> {
        match version {
            2 => Some(Self::Ratio24),
            3 => Some(Self::Ratio48),
            _unknown => None,
        }
    }

    /// Turns of the motor per turn of the output shaft.
    pub(crate) const fn ratio(self) -> u16 {
        match self {
            Self::Ratio24 => 24,
            Self::Ratio48 => 48,
        }
    }

    /// Largest speed of the output shaft in rpm, in either direction.
    pub(crate) const fn max_rpm(self) -> u16 {
        match self {
            Self::Ratio24 => 200,
            Self::Ratio48 => 100,
        }
    }

    /// The hardware version a drive with this gear reports (PNU 961).
    pub(crate) const fn hardware_version(self) -> u16 {
        match self {
            Self::Ratio24 => 2,
            Self::Ratio48 => 3,
        }
    }
}

impl fmt::Display for Gear {
    /// `24` or `48`, as [`FromStr`] reads it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.ratio(), f)
    }
}

impl FromStr for Gear {
    type Err = GearError;

    /// Reads `24` or `48`.
    fn from_str(text: &str) -> Result<Self, GearError> {
        match text {
            "24" => Ok(Self::Ratio24),
            "48" => Ok(Self::Ratio48),
            _ => Err(GearError),
        }
    }
}

/// A text that names no gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("unknown gear; expected 24 (24:1) or 48 (48:1)")]
pub struct GearError;

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn names_survive_the_round_trip() {
        for model in Model::ALL {
            assert_eq!(model.to_string().parse(), Ok(model));
        }
        for gear in Gear::ALL {
            assert_eq!(gear.to_string().parse(), Ok(gear));
        }
    }

    #[test]
    fn other_names_are_refused() {
        for text in ["", "ag03/1", "ag031", "ag05"] {
            assert_eq!(text.parse::<Model>(), Err(ModelError), "{text}");
        }
        for text in ["", "24:1", "2", "048"] {
            assert_eq!(text.parse::<Gear>(), Err(GearError), "{text}");
        }
        assert_eq!("AG03-1".parse(), Ok(Model::Ag03_1));
    }

    #[test]
    fn the_gear_decides_speed_and_hardware_version() {
        assert_eq!((Gear::Ratio24.max_rpm(), Gear::Ratio24.hardware_version()), (200, 2));
        assert_eq!((Gear::Ratio48.max_rpm(), Gear::Ratio48.hardware_version()), (100, 3));
        assert!(Gear::ALL.iter().all(|gear| gear.max_rpm() <= Gear::FASTEST.max_rpm()));
        for version in 0..=10 {
            let gear = Gear::ALL.into_iter().find(|gear| gear.hardware_version() == version);
            assert_eq!(Gear::of_hardware_version(version), gear);
        }
    }
}
