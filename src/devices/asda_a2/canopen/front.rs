//! The keys of the front, behind which are the parameters of the object dictionary.

use super::AsdaA2;
use super::application::Drive;
use crate::can_bus::canopen::{Abort, Address, Application, DataType, Source, Value, dictionary};
use crate::devices::CanopenDevice;
use crate::devices::asda_a2::keypad::{Key, Outcome, Parameter, Seen};
use crate::time::Instant;

impl AsdaA2 {
    /// A key goes down. What it writes is checked as what comes over the bus, and kept.
    pub(super) fn press_key(&mut self, now: Instant, key: Key) {
        self.drive.servo.advance(now);
        let drive = &self.drive;
        let wanted = self.keypad.press(now, key, &|place| parameter(drive, place));
        if let Some((place, parameter)) = wanted {
            let outcome = self.write_by_key(now, Address::new(place, 0), parameter);
            self.keypad.tell(now, outcome);
        }
    }

    /// What the display shows; nothing while it is off.
    pub(super) fn seen(&self, now: Instant) -> Seen {
        self.node.state().map_or_else(Seen::default, |_| self.keypad.seen(now, self.servo()))
    }

    fn write_by_key(&mut self, now: Instant, at: Address, Parameter { value, wide }: Parameter) -> Outcome {
        let octets = value.to_le_bytes();
        let (narrow, _) = octets.split_at(if wide { 4 } else { 2 });
        match self.write_without_bus(now, at, narrow) {
            Ok(()) => {
                let data = if wide { DataType::I32 } else { DataType::I16 };
                if let Some(value) = Value::whole(data, value) {
                    // What was taken over is kept, too.
                    let _ = self.drive.write(now, at, value, Source::Image);
                }
                self.node.offer_image();
                Outcome::Saved
            }
            Err(refusal) => match refusal.code {
                Abort::READ_ONLY => Outcome::ReadOnly,
                Abort::DEVICE_STATE => Outcome::ServoOn,
                _ => Outcome::OutOfRange,
            },
        }
    }
}

fn parameter(drive: &Drive, place: u16) -> Option<Parameter> {
    let at = Address::new(place, 0);
    let entry = dictionary::entry(drive.table(), at).ok()?;
    let value = drive.read(at).ok()?.number()?;
    Some(Parameter { value, wide: entry.data == DataType::I32 })
}

#[cfg(test)]
mod tests {
    use super::super::{Config, Quirks};
    use super::*;
    use crate::face::Surroundings;

    fn on(quirks: Quirks) -> AsdaA2 {
        let mut device = AsdaA2::new(Config::new(5), quirks, Instant::ZERO);
        device.power_on(Instant::ZERO);
        device
    }

    fn types(device: &mut AsdaA2, keys: &str) -> std::string::String {
        for key in keys.split_whitespace() {
            device.press(Instant::ZERO, key, true).unwrap();
            device.press(Instant::ZERO, key, false).unwrap();
        }
        device.face(Instant::ZERO).rows[0].text.to_string()
    }

    #[test]
    fn a_node_number_is_set_at_the_front_and_comes_back_with_the_supply() {
        let mut device = on(Quirks::default());
        assert_eq!(types(&mut device, "mode"), "P0-00");
        assert_eq!(types(&mut device, "shift shift shift set"), " 0005");
        assert_eq!(types(&mut device, "up shift up"), " 0016");
        assert_eq!(device.face(Instant::ZERO).signs, ["digit 2"]);
        assert_eq!(types(&mut device, "set"), "SAVEd");
        device.power_off(Instant::ZERO);
        assert_eq!(device.face(Instant::ZERO).rows[0].text, "");
        assert!(device.press(Instant::ZERO, "mode", true).is_err());
        device.power_on(Instant::ZERO);
        assert_eq!(device.node_id().number(), 0x16);
        assert_eq!(types(&mut device, "mode shift shift shift set"), " 0016");
    }

    #[test]
    fn what_the_bus_would_refuse_the_front_refuses_too() {
        let mut device = on(Quirks::default());
        assert_eq!(types(&mut device, "mode shift shift shift set shift shift up set"), "Out-r");
        assert_eq!(device.node_id().number(), 5);
        assert!(device.press(Instant::ZERO, "star", true).is_err());
    }

    #[test]
    fn parameters_that_the_drive_does_not_have_are_not_shown() {
        let mut device = on(Quirks { other_parameters_absent: true, ..Quirks::default() });
        assert_eq!(types(&mut device, "mode"), "P1-01");
        assert_eq!(types(&mut device, "up"), "P1-32");
        assert_eq!(types(&mut device, "shift shift shift"), "P1-01");
    }
}
