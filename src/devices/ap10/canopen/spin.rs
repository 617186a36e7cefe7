//! A shaft that something turns with a constant speed.

use core::time::Duration;

use super::Ap10;
use crate::devices::ap10::{Fault, Turns};
use crate::time::Instant;

/// Above it the sensor loses count (manual 4.5.3: "admissible speed"). The manual gives no number; this one is assumed.
pub const MAX_RPM: f64 = 600.0;

/// How often a turning shaft is looked at.
const STEP: Duration = Duration::from_millis(10);

/// A turning shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spin {
    rpm: f64,
    since: Instant,
    from: f64,
    due: Instant,
}

impl Ap10 {
    /// From now on the shaft turns with this speed, clockwise seen on the display; 0 stops it. Above [`MAX_RPM`] the fault
    /// [`Fault::Speed`] is there.
    pub(crate) fn spin(&mut self, now: Instant, rpm: f64) {
        self.turn_on(now);
        if self.spin.is_some() {
            // The count is kept when the shaft stops or turns with another speed.
            self.node.offer_image();
        }
        let due = now.saturating_add(STEP);
        let from = self.indicator().shaft().revolutions();
        self.spin = (rpm.abs() > 0.0).then_some(Spin { rpm, since: now, from, due });
        if rpm.abs() > MAX_RPM {
            self.provoke(now, Fault::Speed);
        } else {
            self.end_fault(now, Fault::Speed);
        }
    }

    /// The speed of [`spin`](Self::spin) in rpm.
    pub(crate) fn rpm(&self) -> f64 {
        self.spin.map_or(0.0, |spin| spin.rpm)
    }

    /// When the turning shaft is to be looked at.
    pub(super) fn spin_due(&self) -> Option<Instant> {
        self.spin.map(|spin| spin.due)
    }

    /// The shaft is where its speed has brought it.
    pub(super) fn turn_on(&mut self, now: Instant) {
        let Some(spin) = &mut self.spin else { return };
        spin.due = now.saturating_add(STEP);
        let turns = spin.from + spin.rpm / 60.0 * now.saturating_since(spin.since).as_secs_f64();
        self.place(now, Turns::from_revolutions(turns));
    }
}

#[cfg(test)]
mod tests {
    use super::super::Config;
    use super::*;
    use crate::can_bus::canopen::NodeId;
    use crate::devices::CanopenDevice;

    #[test]
    fn a_shaft_turns_with_its_speed_and_above_the_limit_the_speed_fault_is_there() {
        let at = Instant::from_millis;
        let mut device = Ap10::new(Config::new(NodeId::MIN));
        device.power_on(at(0));
        device.spin(at(0), -120.0);
        while let Some(due) = device.poll_timeout().filter(|due| *due <= at(1000)) {
            device.handle_timeout(due);
        }
        assert_eq!(device.indicator().shaft(), Turns::from_revolutions(-2.0));
        assert!(!device.indicator().has(Fault::Speed));

        device.spin(at(1000), MAX_RPM + 1.0);
        assert!(device.indicator().has(Fault::Speed));
        device.spin(at(1000), MAX_RPM);
        assert!(!device.indicator().has(Fault::Speed));
        device.spin(at(1006), 0.0);
        assert_eq!(device.indicator().shaft(), Turns::from_revolutions(-1.94));
        assert_eq!(device.poll_timeout(), None, "nothing moves");
    }

    #[test]
    fn a_hand_stops_a_turning_shaft_where_it_puts_it() {
        let mut device = Ap10::new(Config::new(NodeId::MIN));
        device.power_on(Instant::ZERO);
        device.spin(Instant::ZERO, MAX_RPM * 2.0);
        device.turn_to(Instant::ZERO, Turns::from_revolutions(7.0));
        assert_eq!((device.rpm(), device.indicator().has(Fault::Speed)), (0.0, false));
        device.handle_timeout(Instant::from_millis(100));
        assert_eq!(device.indicator().shaft(), Turns::from_revolutions(7.0));
    }
}
