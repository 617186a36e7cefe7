//! The AG03/1 as a node: any frames, times, inputs, switches and supply. What `canopen_node` holds of any node, and of this
//! drive: enabled in OPERATIONAL only, released by everything else but the keys, and what it keeps is taken over again.
//!
//! ```text
//! 0..=3f  frame: flags (bit 0 extended, bit 1 remote), DLC, identifier (2), data
//! 40..=5f time passes: milliseconds (2)
//! 60..=6f the world: bits of the next octet
//! 70..=7f the error state of the controller
//! 80..=8f DIP switches (2)
//! 90      switched off and on
//! ```

use std::time::Duration;

use profidrive::can_bus::can::{ErrorState, Frame, Id};
use profidrive::can_bus::canopen::{NmtState, NodeId};
use profidrive::devices::CanopenDevice;
use profidrive::devices::ag03::canopen::state::State;
use profidrive::devices::ag03::canopen::{Ag03Node, Config};
use profidrive::devices::ag03::drive::{Inputs, Motor};
use profidrive::devices::ag03::unit::DipSwitches;
use profidrive::time::Instant;

pub(crate) fn check(data: &[u8]) {
    let now = Instant::ZERO;
    let node = Ag03Node::new(Config::new(NodeId::new(5).unwrap()), now);
    let mut rig = Rig { now, node };
    rig.drain();
    let mut rest = data;
    for _ in 0..1000 {
        let Some(behind) = rig.step(rest) else { break };
        rest = behind;
        rig.judge();
    }
    let image = rig.node.image();
    // With the switches of a factory reset it would begin with one.
    let mut config = *rig.node.config();
    config.switches = config.switches.with_reset(false);
    let again = Ag03Node::restore(config, &image, rig.now).expect("its own image");
    assert_eq!(&again.image()[..], &image[..], "what was kept is kept");
}

struct Rig {
    now: Instant,
    node: Ag03Node,
}

impl Rig {
    fn step<'a>(&mut self, steps: &'a [u8]) -> Option<&'a [u8]> {
        let (&kind, rest) = steps.split_first()?;
        match kind {
            0x00..=0x3F => return self.frame(rest),
            0x40..=0x5F => {
                let ([low, high], rest) = rest.split_first_chunk()?;
                self.pass(Duration::from_millis(u16::from_le_bytes([*low, *high]).into()));
                return Some(rest);
            }
            0x60..=0x6F => {
                let (bits, rest) = rest.split_first()?;
                let is = |bit: u8| bits >> bit & 1 == 1;
                let default = Inputs::default();
                let inputs = Inputs {
                    output_supply: if is(0) { 0.0 } else { default.output_supply },
                    blocked: is(1),
                    stage_temperature: is(2).then_some(95.0),
                    dc_link: is(3).then_some(40.0),
                    encoder_fault: is(4),
                    internal_fault: is(5),
                    key_clockwise: is(6),
                    key_counter_clockwise: is(7),
                    ..default
                };
                self.node.set_inputs(self.now, inputs);
                self.drain();
                return Some(rest);
            }
            0x70..=0x7F => {
                let state = match kind % 4 {
                    0 | 1 => ErrorState::Active,
                    2 => ErrorState::Passive,
                    _ => ErrorState::BusOff,
                };
                self.node.handle_error_state(self.now, ErrorState::Active, state);
                self.drain();
            }
            0x80..=0x8F => {
                let ([low, high], rest) = rest.split_first_chunk()?;
                self.node.set_switches(DipSwitches::from_bits(u16::from_le_bytes([*low, *high])));
                return Some(rest);
            }
            _ => {
                self.node.power_off(self.now);
                assert!(self.node.poll_transmit(self.now).is_none(), "it speaks without supply");
                self.node.power_on(self.now);
                self.drain();
            }
        }
        Some(rest)
    }

    fn frame<'a>(&mut self, rest: &'a [u8]) -> Option<&'a [u8]> {
        let ([flags, dlc, low, high], rest) = rest.split_first_chunk()?;
        let number = u16::from_le_bytes([*low, *high]);
        let id = if flags & 1 == 1 { Id::extended(number.into()) } else { Id::base(number & 0x7FF) }.unwrap();
        let (frame, rest) = if flags & 2 == 2 {
            (Frame::remote(id, dlc % 16).unwrap(), rest)
        } else {
            let (octets, rest) = rest.split_at_checked(usize::from(dlc % 9))?;
            (Frame::data(id, octets).unwrap(), rest)
        };
        let node = u16::from(self.node.node_id().number());
        let own = id == Id::base(0x600 + node).unwrap();
        let serves = self.node.nmt_state().is_some_and(NmtState::serves_sdo);
        self.node.handle_frame(self.now, &frame);
        let sent = self.drain();
        let answer = Id::base(0x580 + node).unwrap();
        let answers = sent.iter().filter(|frame| frame.id() == answer && frame.dlc() == 8).count();
        let may = own && serves && !frame.is_remote() && frame.dlc() == 8;
        // An RPDO or EMCY may have been given that identifier only as far as CiA 301 leaves it free: never.
        assert!(answers <= usize::from(may), "{frame} got {answers} SDO answers");
        Some(rest)
    }

    fn pass(&mut self, time: Duration) {
        let end = self.now.saturating_add(time);
        // A drive that moves has a cycle each millisecond; the fuzzer need not wait for all of them.
        for _ in 0..300 {
            let Some(due) = self.node.poll_timeout().filter(|due| *due <= end) else { break };
            self.now = self.now.max(due);
            self.node.handle_timeout(self.now);
            self.drain();
            assert!(self.node.poll_timeout().is_none_or(|due| due > self.now), "nothing moves on");
        }
        self.now = end;
        self.node.handle_timeout(end);
        self.drain();
    }

    fn judge(&self) {
        let enabled = matches!(self.node.state(), State::OperationEnabled | State::QuickStopActive);
        let operational = self.node.nmt_state() == Some(NmtState::Operational);
        assert!(!enabled || operational, "{:?} in {:?}", self.node.state(), self.node.nmt_state());
        let inputs = self.node.inputs();
        let keys = inputs.key_clockwise || inputs.key_counter_clockwise;
        if !enabled && operational && !keys {
            assert_eq!(self.node.status().motor, Motor::Released, "{:?}", self.node.state());
        }
    }

    fn drain(&mut self) -> Vec<Frame> {
        while self.node.poll_event().is_some() {}
        let mut sent = Vec::new();
        while let Some(frame) = self.node.poll_transmit(self.now) {
            assert!(sent.len() < 64, "it does not stop");
            sent.push(frame);
        }
        sent
    }
}
