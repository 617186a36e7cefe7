//! What surrounds the indicator, and what is seen of it.

use core::time::Duration;

use super::{Ap10, Power};
use crate::can_bus::canopen::Address;
use crate::devices::ap10::{Arrow, Display, Fault, Key, Light, Setting, StatusBit, Turns};
use crate::face::surroundings::{Declined, Face, Glow, Input, InputKind, Level, Provocable, Surroundings};
use crate::time::Instant;

const CONTROL_WORD: Address = Address::new(0x5F0C, 0);
const STATUS_WORD: Address = Address::new(0x5F19, 0);

/// The angle of the shaft.
const SHAFT: Input = Input {
    name: "shaft_revolutions",
    about: "angle of the shaft in turns, clockwise seen on the display",
    kind: InputKind::Number { low: -1e6, high: 1e6, own: false },
};

/// The speed of the shaft.
const SPEED: Input = Input {
    name: "shaft_rpm",
    about: "speed of the shaft in revolutions per minute, clockwise seen on the display",
    kind: InputKind::Number { low: -10_000.0, high: 10_000.0, own: false },
};

impl Surroundings for Ap10 {
    fn each_fault(&self, tell: &mut dyn FnMut(Provocable<'_>)) {
        for fault in Fault::ALL {
            let present = self.indicator().has(fault);
            tell(Provocable { name: &fault.name(), text: &fault, present, provoked: present });
        }
    }

    fn provoke(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let fault = Fault::from_name(fault).ok_or(Declined::Unknown)?;
        Self::provoke(self, now, fault);
        Ok(())
    }

    fn take_back(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let fault = Fault::from_name(fault).ok_or(Declined::Unknown)?;
        self.end_fault(now, fault);
        Ok(())
    }

    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        tell(&SHAFT, Level::Number(self.indicator().shaft().revolutions()));
        tell(&SPEED, Level::Number(self.rpm()));
    }

    fn set_input(&mut self, now: Instant, name: &str, level: Level) {
        let Level::Number(number) = level else { return };
        for input in [SHAFT, SPEED].into_iter().filter(|input| input.name == name) {
            let InputKind::Number { low, high, .. } = input.kind else { continue };
            let number = number.clamp(low, high);
            if input == SHAFT {
                self.turn_to(now, Turns::from_revolutions(number));
            } else {
                self.spin(now, number);
            }
        }
    }

    fn nominal(&self, name: &str) -> Option<Level> {
        // Where the shaft is, is nobody's mistake.
        (name == SPEED.name).then_some(Level::Number(0.0))
    }

    fn make_nominal(&mut self, now: Instant) {
        self.spin(now, 0.0);
        for fault in Fault::ALL {
            self.end_fault(now, fault);
        }
    }

    fn each_key(&self, tell: &mut dyn FnMut(&'static str, bool)) {
        let status = self.indicator().status();
        for key in Key::ALL {
            let bit = match key {
                Key::Left => StatusBit::LeftKey,
                Key::Up => StatusBit::UpKey,
                Key::Star => StatusBit::StarKey,
            };
            tell(key.name(), status.has(bit));
        }
    }

    fn press(&mut self, now: Instant, key: &str, down: bool) -> Result<(), Declined> {
        let key = Key::from_name(key).ok_or(Declined::Unknown)?;
        match (down, self.power) {
            (false, _) => self.release(now, key),
            (true, Power::Off) => return Err(Declined::SwitchedOff),
            (true, Power::Listening | Power::On) => Self::press(self, now, key),
        }
        Ok(())
    }

    fn face(&self, now: Instant) -> Face {
        let Display { rows, arrow, battery, incremental, leds, rotated } = self.seen(now);
        let mut face = Face::default();
        for row in &rows {
            face = face.row(row.text(), row.flashing);
        }
        face.sign("arrow clockwise", arrow == Some(Arrow::Clockwise))
            .sign("arrow counter-clockwise", arrow == Some(Arrow::CounterClockwise))
            .sign("battery critical", battery == Light::Blinking)
            .sign("battery empty", battery == Light::Steady)
            .sign("incremental", incremental)
            .sign("rotated by 180 degrees", rotated)
            .led("left green", glow(leds.left_green))
            .led("left red", glow(leds.left_red))
            .led("right green", glow(leds.right_green))
            .led("right red", glow(leds.right_red))
    }

    fn words(&self) -> &'static [Address] {
        &[CONTROL_WORD, STATUS_WORD]
    }

    fn mode(&self) -> i64 {
        self.indicator().settings().value(Setting::OperatingMode).into()
    }
}

/// How long an LED is lit and dark; the manual does not say it.
const BLINK: Duration = Duration::from_millis(250);

const fn glow(light: Light) -> Glow {
    match light {
        Light::Off => Glow::Off,
        Light::Blinking => Glow::Blinking { on: BLINK, off: BLINK },
        Light::Steady => Glow::On,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Config;
    use super::*;
    use crate::can_bus::canopen::NodeId;
    use crate::devices::CanopenDevice;

    #[test]
    fn what_is_seen_is_said_in_one_line() {
        let mut device = Ap10::new(Config::new(NodeId::MIN));
        device.power_on(Instant::ZERO);
        let now = Instant::from_millis(400);
        device.set_input(now, "shaft_revolutions", Level::Number(0.5));
        let dark = "LED left green off, LED left red off, LED right green off, LED right red off";
        assert_eq!(device.face(now).to_string(), std::format!("[440] [---], {dark}"));
        assert_eq!(Surroundings::provoke(&mut device, now, "battery-critical"), Ok(()));
        assert!(device.face(now).signs.contains(&"battery critical"));
        assert_eq!(Surroundings::provoke(&mut device, now, "battery"), Err(Declined::Unknown));
        Surroundings::make_nominal(&mut device, now);
        assert!(device.face(now).signs.is_empty());
    }
    #[test]
    fn behind_the_supply_comes_a_test_of_display_and_leds() {
        let mut device = Ap10::new(Config::new(NodeId::MIN));
        for start in [Instant::from_millis(7), Instant::from_millis(5000)] {
            device.power_on(start);
            let lit = |millis| {
                let face = device.face(start.saturating_add(Duration::from_millis(millis)));
                let lit = face.leds.iter().filter(|led| led.glow == Glow::On).map(|led| led.name);
                (lit.collect::<std::vec::Vec<_>>(), face.rows[0].text.to_string(), face.signs.len())
            };
            for (millis, led) in
                [(0, "left green"), (100, "left red"), (200, "right green"), (399, "right red")]
            {
                assert_eq!(lit(millis), (std::vec![led], "88888888".into(), 3), "{millis} ms");
            }
            assert_eq!(lit(400), (std::vec![], "0".into(), 0));
            device.power_off(start);
            assert_eq!(device.face(start).rows[0].text.to_string(), "");
        }
    }
}
