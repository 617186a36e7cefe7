//! What surrounds the drive, and what is seen of it.

use super::Ag03Node;
use crate::can_bus::canopen::{Address, NmtState};
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param::Model;
use crate::devices::ag03::surroundings;
use crate::devices::ag03::unit::Power;
use crate::face::surroundings::{Declined, Face, Glow, Input, Level, Provocable, Surroundings};
use crate::face::{DriveState, Why};
use crate::time::Instant;

const CONTROL_WORD: Address = Address::new(0x6040, 0);
const STATUS_WORD: Address = Address::new(0x6041, 0);

impl Surroundings for Ag03Node {
    fn each_fault(&self, tell: &mut dyn FnMut(Provocable<'_>)) {
        let drive = self.unit().drive();
        let causes = [drive.causes(), drive.provoked_by(self.inputs())];
        surroundings::each_fault(Model::Ag03_1, causes, tell);
    }

    fn provoke(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let fault = surroundings::fault(Model::Ag03_1, fault)?;
        let inputs = self.unit().drive().provoking(self.inputs(), fault);
        self.set_inputs(now, inputs);
        Ok(())
    }

    fn take_back(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let fault = surroundings::fault(Model::Ag03_1, fault)?;
        self.set_inputs(now, surroundings::taken_back(self.inputs(), fault));
        Ok(())
    }

    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        surroundings::each_input(Model::Ag03_1, self.inputs(), tell);
    }

    fn set_input(&mut self, now: Instant, name: &str, level: Level) {
        if let Some(inputs) = surroundings::with_input(Model::Ag03_1, self.inputs(), name, level) {
            self.set_inputs(now, inputs);
        }
    }

    fn nominal(&self, name: &str) -> Option<Level> {
        surroundings::nominal_level(name)
    }

    fn calculated(&self, name: &str) -> Option<f64> {
        surroundings::calculated(self.unit().drive(), name)
    }

    fn make_nominal(&mut self, now: Instant) {
        self.set_inputs(now, surroundings::nominal(self.inputs()));
    }

    fn each_key(&self, tell: &mut dyn FnMut(&'static str, bool)) {
        surroundings::each_key(self.inputs(), tell);
    }

    fn press(&mut self, now: Instant, key: &str, down: bool) -> Result<(), Declined> {
        self.set_inputs(now, surroundings::with_key(self.inputs(), key, down)?);
        Ok(())
    }

    fn face(&self, _now: Instant) -> Face {
        let (status, bus) = match (self.power(), self.nmt_state()) {
            (Power::Off, _) => (Glow::Off, Glow::Off),
            (Power::FactoryReset(_), _) => (Glow::Alternating, Glow::Alternating),
            (Power::On, nmt) => {
                let status = surroundings::glow(self.status().led);
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

    fn words(&self) -> &'static [Address] {
        &[CONTROL_WORD, STATUS_WORD]
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

    fn why(&self) -> Option<&dyn Why> {
        Some(self)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Config;
    use super::*;
    use crate::can_bus::canopen::NodeId;
    use crate::devices::ag03::drive::Inputs;
    use crate::face::surroundings::InputKind;

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
        let said = |node: &Ag03Node| {
            let mut said = Vec::new();
            node.each_reason(&mut |reason| said.push(reason.to_string()));
            said
        };
        assert!(said(&node)[0].starts_with("NMT state PRE-OPERATIONAL"), "{:?}", said(&node));
        assert!(said(&node)[1].contains("send 6040h = 0006h"), "{:?}", said(&node));
        node.power_off(now);
        assert_eq!(said(&node), ["the drive is switched off: switch its supply on"]);
        assert_eq!(node.face(now).to_string(), "LED status green off, LED bus orange off");
    }
}
