//! Errors and events for `defmt`: the same words as everywhere, in a microcontroller's log.
//!
//! The words are put together on the target ([`defmt::Display2Format`]), because they are the ones of the one vocabulary; that
//! costs the flash of `core::fmt`. Who cannot spare it logs numbers of the fields instead.

use core::fmt::Display;

use defmt::{Display2Format, Format, Formatter};

use crate::devices::StationEvent;

macro_rules! logged {
    ($($name:ty),* $(,)?) => {
        $(
            impl Format for $name {
                fn format(&self, formatter: Formatter<'_>) {
                    defmt::write!(formatter, "{}", Display2Format(self));
                }
            }
        )*
    };
}

impl<D: Display> Format for StationEvent<D> {
    fn format(&self, formatter: Formatter<'_>) {
        defmt::write!(formatter, "{}", Display2Format(self));
    }
}

logged![
    crate::can_bus::can::ErrorState,
    crate::can_bus::can::BitRateError,
    crate::can_bus::can::FrameError,
    crate::can_bus::can::IdError,
    crate::can_bus::can::slcan::CommandError,
    crate::can_bus::can::slcan::LineError,
    crate::can_bus::can::slcan::Refusal,
    crate::can_bus::canopen::Event,
    crate::can_bus::canopen::NodeIdError,
    crate::devices::CanopenEvent,
    crate::devices::ag03::profibus::Event,
    crate::devices::ag03::profibus::Hint,
    crate::face::QuirkError,
    crate::devices::RecallError,
    crate::devices::ag03::profibus::Refusal,
    crate::devices::ag03::canopen::Event,
    crate::profibus::dp::AddressFault,
    crate::profibus::dp::CfgFault,
    crate::profibus::dp::CfgSyntax,
    crate::profibus::dp::Event,
    crate::profibus::dp::PrmFault,
    crate::profibus::dp::ext_diag::BlockError,
    crate::profibus::dp::framed::News,
    crate::devices::ag03::drive::CalibrationError,
    crate::devices::ag03::drive::Event,
    crate::profibus::fdl::AddressError,
    crate::profibus::fdl::EncodeError,
    crate::profibus::fdl::FrameError,
    crate::devices::ag03::param::GearError,
    crate::devices::ag03::param::ModelError,
    crate::devices::ag03::param::ParamError,
    crate::devices::ag03::param::PnuError,
    crate::profibus::pkw::JobError,
    crate::profibus::ppo::LengthError,
    crate::time::Instant,
    crate::devices::ag03::unit::BusSettingsError,
    crate::devices::ag03::unit::CycleTooShort,
    crate::devices::ag03::unit::Event,
    crate::devices::ag03::unit::ImageError,
    crate::image::ImageError,
    crate::image::NotStored,
];
