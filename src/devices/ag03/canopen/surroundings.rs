//! What surrounds the drive, and what is seen of it.

use super::{Ag03Node, BLINK, STOPPED_DARK};
use crate::can_bus::canopen::{Address, NmtState};
use crate::can_bus::cia402;
use crate::devices::ag03::drive::{Inputs, Mode};
use crate::devices::ag03::param::Model;
use crate::devices::ag03::surroundings::BehindBus;
use crate::devices::ag03::unit::{Power, Unit};
use crate::face::surroundings::Glow;
use crate::face::{DriveState, Turning};
use crate::time::Instant;

const CONTROL_WORD: Address = Address::new(0x6040, 0);
const STATUS_WORD: Address = Address::new(0x6041, 0);
/// Inching 2 in positive and in negative direction, operation enabled.
const INCHING_2: [u16; 2] = [0x400F, 0x800F];

impl BehindBus for Ag03Node {
    const BOTH_MODELS: bool = false;

    fn unit(&self) -> &Unit {
        Self::unit(self)
    }

    fn model(&self) -> Model {
        Model::Ag03_1
    }

    fn change_inputs(&mut self, now: Instant, inputs: Inputs) {
        self.set_inputs(now, inputs);
    }

    fn bus_led(&self) -> Glow {
        match self.nmt_state() {
            None => Glow::Off,
            Some(NmtState::PreOperational) => Glow::Blinking { on: BLINK, off: BLINK },
            Some(NmtState::Stopped) => Glow::Blinking { on: BLINK, off: STOPPED_DARK },
            Some(NmtState::Operational) => Glow::On,
        }
    }

    fn state_on_bus(&self) -> DriveState {
        match self.power() {
            Power::On => self.state().into(),
            Power::Off | Power::FactoryReset(_) => DriveState::Off,
        }
    }

    fn word_entries(&self) -> &'static [Address] {
        &[CONTROL_WORD, STATUS_WORD]
    }

    fn turning_on_bus(&self) -> Option<Turning> {
        let most = self.unit().drive().maximum_rpm();
        Some(Turning {
            mode: cia402::Mode::Velocity,
            target: Address::new(0x60FF, 0),
            unit: "rpm",
            range: (-most, most),
            inching: Some(INCHING_2),
        })
    }

    fn mode_on_bus(&self) -> i64 {
        match self.status().mode {
            Mode::Positioning => 1,
            Mode::Velocity => 2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Config;
    use super::*;
    use crate::can_bus::can::Frame;
    use crate::can_bus::canopen::{NodeId, cob_id};
    use crate::devices::CanopenDevice;
    use crate::face::surroundings::{Declined, InputKind, Level};
    use crate::face::{Surroundings, Why};

    /// CN-42.
    #[test]
    fn the_bus_led_tells_pre_operational_stopped_and_operational_apart() {
        let mut node = Ag03Node::new(Config::new(NodeId::MIN), Instant::ZERO);
        let mut glows = std::vec::Vec::new();
        for command in [None, Some([2, 0]), Some([1, 0])] {
            if let Some(command) = command {
                node.handle_frame(Instant::ZERO, &Frame::with(cob_id::NMT_ID, command));
            }
            glows.push(node.bus_led().to_string());
        }
        assert_eq!(glows, ["blinking", "flashing", "on"]);
    }

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
