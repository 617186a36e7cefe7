//! What surrounds the drive, and what is seen of it.

use super::Ag03Node;
use crate::can_bus::canopen::{Address, NmtState};
use crate::devices::ag03::drive::{Fault, Inputs, Mode, StatusLed};
use crate::devices::ag03::param::Model;
use crate::devices::ag03::unit::Power;
use crate::face::DriveState;
use crate::face::surroundings::{Declined, Face, Glow, Input, InputKind, Level, Provocable, Surroundings};
use crate::time::Instant;

const CONTROL_WORD: Address = Address::new(0x6040, 0);
const STATUS_WORD: Address = Address::new(0x6041, 0);

/// One input: what it is, and where the drive has it.
struct Row {
    input: Input,
    read: fn(&Inputs) -> Level,
    write: fn(&mut Inputs, Level),
}

/// A row of the table by the kind of its field.
macro_rules! row {
    (switch $name:literal, $about:literal, $field:ident) => {
        Row {
            input: Input { name: $name, about: $about, kind: InputKind::Switch },
            read: |inputs| Level::Switch(inputs.$field),
            write: |inputs, level| {
                if let Level::Switch(on) = level {
                    inputs.$field = on;
                }
            },
        }
    };
    (number $name:literal, $about:literal, $field:ident, $low:literal, $high:literal) => {
        Row {
            input: Input {
                name: $name,
                about: $about,
                kind: InputKind::Number { low: $low, high: $high, own: false },
            },
            read: |inputs| Level::Number(inputs.$field),
            write: |inputs, level| {
                if let Level::Number(number) = level {
                    inputs.$field = number;
                }
            },
        }
    };
    (own $name:literal, $about:literal, $field:ident, $low:literal, $high:literal) => {
        Row {
            input: Input {
                name: $name,
                about: $about,
                kind: InputKind::Number { low: $low, high: $high, own: true },
            },
            read: |inputs| inputs.$field.map_or(Level::Own, Level::Number),
            write: |inputs, level| match level {
                Level::Own => inputs.$field = None,
                Level::Number(number) => inputs.$field = Some(number),
                Level::Switch(_) => {}
            },
        }
    };
}

/// The inputs of an AG03/1, as [`Inputs`] has them.
const ROWS: &[Row] = &[
    row!(number "control_supply_volts", "supply of the control", control_supply, 0.0, 60.0),
    row!(number "output_supply_volts", "supply of the output stage", output_supply, 0.0, 60.0),
    row!(number "battery_volts", "battery of the encoder", battery, 0.0, 10.0),
    row!(number "load_torque_newton_metres", "load that pulls the shaft clockwise", load_torque, -1000.0, 1000.0),
    row!(number "friction_torque_newton_metres", "friction in both directions", friction_torque, 0.0, 1000.0),
    row!(switch "blocked", "the shaft is blocked", blocked),
    row!(number "ambient_temperature_celsius", "temperature of the air", ambient, -50.0, 200.0),
    row!(own "stage_temperature_celsius", "temperature of the output stage", stage_temperature, -50.0, 200.0),
    row!(own "dc_link_volts", "voltage of the intermediate circuit", dc_link, 0.0, 100.0),
    row!(switch "encoder_fault", "error of the SIN/COS monitoring", encoder_fault),
    row!(switch "internal_fault", "internal error", internal_fault),
];

/// The keys of the manual setup mode.
const KEYS: [&str; 2] = ["key_1", "key_2"];

impl Surroundings for Ag03Node {
    fn each_fault(&self, tell: &mut dyn FnMut(Provocable<'_>)) {
        let causes = self.unit().drive().causes();
        for fault in Fault::ALL.into_iter().filter(|fault| fault.exists_on(Model::Ag03_1)) {
            let name = char::from(fault.code());
            tell(Provocable { name: &name, text: &fault, present: causes.contains(fault) });
        }
    }

    fn provoke(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let named = |known: &Fault| *fault.as_bytes() == [known.code()] && known.exists_on(Model::Ag03_1);
        let fault = Fault::ALL.into_iter().find(named).ok_or(Declined::Unknown)?;
        let inputs = self.unit().drive().provoking(self.inputs(), fault);
        self.set_inputs(now, inputs);
        Ok(())
    }

    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        for row in ROWS {
            tell(&row.input, (row.read)(self.inputs()));
        }
    }

    fn set_input(&mut self, now: Instant, name: &str, level: Level) {
        if let Some(row) = ROWS.iter().find(|row| row.input.name == name) {
            let mut inputs = *self.inputs();
            (row.write)(&mut inputs, level);
            self.set_inputs(now, inputs);
        }
    }

    fn make_nominal(&mut self, now: Instant) {
        let Inputs { key_clockwise, key_counter_clockwise, .. } = *self.inputs();
        self.set_inputs(now, Inputs { key_clockwise, key_counter_clockwise, ..Inputs::default() });
    }

    fn each_key(&self, tell: &mut dyn FnMut(&'static str, bool)) {
        let [one, two] = KEYS;
        tell(one, self.inputs().key_clockwise);
        tell(two, self.inputs().key_counter_clockwise);
    }

    fn press(&mut self, now: Instant, key: &str, down: bool) -> Result<(), Declined> {
        let mut inputs = *self.inputs();
        match KEYS.iter().position(|known| *known == key) {
            Some(0) => inputs.key_clockwise = down,
            Some(_) => inputs.key_counter_clockwise = down,
            None => return Err(Declined::Unknown),
        }
        self.set_inputs(now, inputs);
        Ok(())
    }

    fn face(&self, _now: Instant) -> Face {
        let (status, bus) = match (self.power(), self.nmt_state()) {
            (Power::Off, _) => (Glow::Off, Glow::Off),
            (Power::FactoryReset(_), _) => (Glow::Blinking, Glow::Blinking),
            (Power::On, nmt) => {
                let status = match self.status().led {
                    StatusLed::Off => Glow::Off,
                    StatusLed::On => Glow::On,
                    StatusLed::Blinking(fault) => Glow::Code(fault.blinks()),
                };
                let bus = match nmt {
                    None => Glow::Off,
                    Some(NmtState::PreOperational | NmtState::Stopped) => Glow::Blinking,
                    Some(NmtState::Operational) => Glow::On,
                };
                (status, bus)
            }
        };
        Face::default().led("status green", status).led("bus orange", bus)
    }

    fn words(&self) -> [Address; 2] {
        [CONTROL_WORD, STATUS_WORD]
    }

    fn mode(&self) -> i64 {
        match self.status().mode {
            Mode::Positioning => 1,
            Mode::Velocity => 2,
        }
    }

    fn is_drive(&self) -> bool {
        true
    }

    fn drive_state(&self) -> Option<DriveState> {
        Some(match self.power() {
            Power::On => self.state().into(),
            Power::Off | Power::FactoryReset(_) => DriveState::Off,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Config;
    use super::*;
    use crate::can_bus::canopen::NodeId;
    use std::string::ToString;
    use std::vec::Vec;

    #[test]
    fn each_input_is_set_and_read_back_and_nominal_is_as_made() {
        let now = Instant::ZERO;
        let fresh = Ag03Node::new(Config::new(NodeId::MIN), now);
        let mut node = fresh.clone();
        let mut rows = Vec::new();
        fresh.each_input(&mut |input, level| rows.push((*input, level)));
        for (input, level) in &rows {
            let other = match (input.kind, level) {
                (InputKind::Switch, Level::Switch(on)) => Level::Switch(!on),
                (InputKind::Number { low, high, .. }, _) => Level::Number((low + high) / 2.0 + 1.0),
                (InputKind::Switch, Level::Number(_) | Level::Own) => unreachable!(),
            };
            node.set_input(now, input.name, other);
            let mut found = None;
            node.each_input(&mut |known, level| {
                if known.name == input.name {
                    found = Some(level);
                }
            });
            assert_eq!(found, Some(other), "{}", input.name);
            node.set_input(now, input.name, *level);
            assert_eq!(node.inputs(), fresh.inputs(), "{}", input.name);
        }
        node.set_input(now, "blocked", Level::Number(1.0));
        node.set_input(now, "blocket", Level::Switch(true));
        assert_eq!(node.inputs(), fresh.inputs());
        assert_eq!((node.provoke(now, "D"), node.press(now, "key_1", true)), (Ok(()), Ok(())));
        node.make_nominal(now);
        assert_eq!(*node.inputs(), Inputs { key_clockwise: true, ..Inputs::default() });
        for fault in ["H", "d", "", "DD"] {
            assert_eq!(node.provoke(now, fault), Err(Declined::Unknown), "{fault}");
        }
        assert_eq!(node.press(now, "key_3", true), Err(Declined::Unknown));
    }

    #[test]
    fn a_drive_says_what_it_waits_for() {
        let now = Instant::ZERO;
        let mut node = Ag03Node::new(Config::new(NodeId::MIN), now);
        let said = |node: &Ag03Node| node.why().map(|hindrance| hindrance.to_string()).collect::<Vec<_>>();
        assert!(said(&node)[0].starts_with("NMT state PRE-OPERATIONAL"), "{:?}", said(&node));
        assert!(said(&node)[1].contains("send 6040h = 0006h"), "{:?}", said(&node));
        node.power_off(now);
        assert_eq!(said(&node), ["the drive is switched off: switch its supply on"]);
        assert_eq!(node.face(now).to_string(), "LED status green off, LED bus orange off");
    }
}
