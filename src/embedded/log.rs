//! Errors and events for `defmt`: the same words as everywhere, in a microcontroller's log.
//!
//! The words are put together on the target ([`defmt::Display2Format`]), because they are the ones of the one vocabulary; that
//! costs the flash of `core::fmt`. Who cannot spare it logs numbers of the fields instead.

use defmt::{Display2Format, Format, Formatter};

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

logged![
    crate::can::ErrorState,
    crate::can::BitRateError,
    crate::can::FrameError,
    crate::can::IdError,
    crate::can::slcan::CommandError,
    crate::can::slcan::LineError,
    crate::can::slcan::Refusal,
    crate::canopen::Event,
    crate::canopen::NodeIdError,
    crate::canopen::storage::ImageError,
    crate::canopen::storage::NotStored,
    crate::device::CanopenEvent,
    crate::device::Event,
    crate::device::Hint,
    crate::device::QuirkError,
    crate::device::RecallError,
    crate::device::Refusal,
    crate::device::ag03_canopen::Event,
    crate::dp::AddressFault,
    crate::dp::CfgFault,
    crate::dp::CfgSyntax,
    crate::dp::Event,
    crate::dp::PrmFault,
    crate::dp::ext_diag::BlockError,
    crate::dp::framed::News,
    crate::drive::CalibrationError,
    crate::drive::Event,
    crate::fdl::AddressError,
    crate::fdl::EncodeError,
    crate::fdl::FrameError,
    crate::param::GearError,
    crate::param::ModelError,
    crate::param::ParamError,
    crate::param::PnuError,
    crate::pkw::JobError,
    crate::ppo::LengthError,
    crate::time::Instant,
    crate::unit::BusSettingsError,
    crate::unit::CycleTooShort,
    crate::unit::Event,
    crate::unit::ImageError,
    crate::unit::NotStored,
];
