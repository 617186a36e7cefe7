//! Fault confinement: how a station that sees too many errors withdraws from the bus (ISO 11898-1).
//!
//! | event | counter |
//! | --- | --- |
//! | a frame was sent | TEC - 1 |
//! | an error while sending | TEC + 8 |
//! | nobody acknowledges, and the station is error passive | TEC stays |
//! | a frame was received | REC - 1, from above 127 to 127 |
//! | an error while receiving | REC + 1 |
//!
//! Both counters up to 127: error active. One above 127: error passive. TEC above 255: bus off, until the bus was idle
//! for 128 times 11 bits.

use core::fmt;

/// Bits of silence after which a station that is bus off is error active again.
pub(crate) const RECOVERY: u32 = 128 * 11;

/// A counter from here on is a warning.
const WARNING: u16 = 96;
/// A counter above this makes a station error passive.
const LAST_ACTIVE: u16 = 127;
/// A TEC above this makes it bus off.
const LAST_ON_BUS: u16 = 255;
/// What an error while sending costs.
const SENDING_ERROR: u16 = 8;

/// How much a station may still do on the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ErrorState {
    /// Everything.
    #[default]
    Active,
    /// It sends with a pause after each frame, and its error flags disturb nobody.
    Passive,
    /// Nothing.
    BusOff,
}

impl fmt::Display for ErrorState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Active => "error active",
            Self::Passive => "error passive",
            Self::BusOff => "bus off",
        })
    }
}

/// The error counters of one station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Confinement {
    tec: u16,
    rec: u16,
}

impl Confinement {
    /// The counters of a station that is in `state`, with as few errors as that takes.
    #[must_use]
    pub(crate) const fn in_state(state: ErrorState) -> Self {
        let tec = match state {
            ErrorState::Active => 0,
            ErrorState::Passive => LAST_ACTIVE + 1,
            ErrorState::BusOff => LAST_ON_BUS + 1,
        };
        Self { tec, rec: 0 }
    }

    /// What the station may do.
    pub(crate) const fn state(&self) -> ErrorState {
        if self.tec > LAST_ON_BUS {
            ErrorState::BusOff
        } else if self.tec > LAST_ACTIVE || self.rec > LAST_ACTIVE {
            ErrorState::Passive
        } else {
            ErrorState::Active
        }
    }

    /// Whether a counter is at 96 or above.
    pub(crate) const fn is_warning(&self) -> bool {
        self.tec >= WARNING || self.rec >= WARNING
    }

    /// The transmit error counter.
    #[doc(alias = "TEC")]
    pub const fn transmit_errors(&self) -> u16 {
        self.tec
    }

    /// The receive error counter.
    #[doc(alias = "REC")]
    pub(crate) const fn receive_errors(&self) -> u16 {
        self.rec
    }

    /// A frame of this station was sent.
    pub(crate) const fn sent(&mut self) {
        self.tec = self.tec.saturating_sub(1);
    }

    /// A frame of this station ended in an error.
    pub(crate) const fn sending_failed(&mut self) {
        self.tec = self.tec.saturating_add(SENDING_ERROR);
    }

    /// Nobody acknowledged a frame of this station. That alone never takes it off the bus.
    pub(crate) const fn not_acknowledged(&mut self) {
        if let ErrorState::Active = self.state() {
            self.sending_failed();
        }
    }

    /// A frame of another station was received.
    pub(crate) const fn received(&mut self) {
        self.rec = if self.rec > LAST_ACTIVE { LAST_ACTIVE } else { self.rec.saturating_sub(1) };
    }

    /// A frame of another station ended in an error.
    pub(crate) const fn receiving_failed(&mut self) {
        // Above 127 it says no more than that the station is error passive.
        if self.rec <= LAST_ACTIVE {
            self.rec += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_errors_make_a_sender_passive_and_sixteen_more_take_it_off_the_bus() {
        let mut station = Confinement::default();
        for errors in 1..=32 {
            station.sending_failed();
            let expected = match errors {
                ..16 => ErrorState::Active,
                16..32 => ErrorState::Passive,
                32.. => ErrorState::BusOff,
            };
            assert_eq!((station.state(), station.is_warning()), (expected, errors >= 12), "{errors} errors");
        }
    }

    #[test]
    fn a_frame_sent_takes_back_one() {
        let mut station = Confinement::in_state(ErrorState::Passive);
        assert_eq!(station.state(), ErrorState::Passive);
        station.sent();
        assert_eq!((station.state(), station.transmit_errors()), (ErrorState::Active, 127));
        assert_eq!(Confinement::in_state(ErrorState::BusOff).state(), ErrorState::BusOff);
    }

    #[test]
    fn a_station_alone_on_the_bus_becomes_passive_and_stays_there() {
        let mut station = Confinement::default();
        for _ in 0..1000 {
            station.not_acknowledged();
        }
        assert_eq!((station.state(), station.transmit_errors()), (ErrorState::Passive, 128));
    }

    #[test]
    fn a_receiver_becomes_passive_never_bus_off_and_one_frame_makes_it_active() {
        let mut station = Confinement::default();
        for _ in 0..1000 {
            station.receiving_failed();
        }
        assert_eq!((station.state(), station.receive_errors()), (ErrorState::Passive, 128));
        station.received();
        assert_eq!((station.state(), station.receive_errors()), (ErrorState::Active, 127));
        station.received();
        assert_eq!(station.receive_errors(), 126);
    }
}
