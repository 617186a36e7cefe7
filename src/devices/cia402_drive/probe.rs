//! Touch probes: the position at an edge of an input, 60B8h to 60BDh.
//!
//! ```text
//! 60B8h  bit 0 on   bit 1 every edge, not only the first   bit 4 rising edges   bit 5 falling edges   +8: probe 2
//! 60B9h  bit 0 on   bit 1 rising edge stored   bit 2 falling edge stored                              +8: probe 2
//! ```

use crate::face::surroundings::{Input, InputKind, Level};

const INPUTS: [Input; 2] = [
    Input { name: "touch_probe_1", about: "touch probe 1", kind: InputKind::Switch },
    Input { name: "touch_probe_2", about: "touch probe 2", kind: InputKind::Switch },
];

const ON: u8 = 1 << 0;
const CONTINUOUS: u8 = 1 << 1;
const RISING: u8 = 1 << 4;
const FALLING: u8 = 1 << 5;
const RISING_STORED: u8 = 1 << 1;
const FALLING_STORED: u8 = 1 << 2;

/// Both probes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Probes([Probe; 2]);

#[derive(Clone, Copy, Debug, Default)]
struct Probe {
    function: u8,
    status: u8,
    level: bool,
    rising: i64,
    falling: i64,
}

impl Probes {
    /// 60B8h.
    pub(super) fn choose(&mut self, word: i64) {
        let [first, second, ..] = word.to_le_bytes();
        for (probe, function) in self.0.iter_mut().zip([first, second]) {
            if probe.function != function {
                probe.status = function & ON;
            }
            probe.function = function;
        }
    }

    /// 60B9h.
    pub(super) fn status(&self) -> i64 {
        let [first, second] = self.0.map(|probe| i64::from(probe.status));
        second << 8 | first
    }

    /// The position at the last rising and falling edge of the probe.
    pub(super) const fn positions(&self) -> [(i64, i64); 2] {
        let [first, second] = self.0;
        [(first.rising, first.falling), (second.rising, second.falling)]
    }

    pub(super) fn each_level(&self, tell: &mut dyn FnMut(&Input, Level)) {
        for (input, probe) in INPUTS.iter().zip(&self.0) {
            tell(input, Level::Switch(probe.level));
        }
    }

    pub(super) fn level(&self, name: &str) -> Option<Level> {
        let mut rows = INPUTS.iter().zip(&self.0);
        rows.find_map(|(input, probe)| (input.name == name).then_some(Level::Switch(probe.level)))
    }

    /// An input changes while the shaft is at `position`; says whether there is one of that name.
    pub(super) fn change(&mut self, name: &str, level: Level, position: i64) -> bool {
        let mut rows = INPUTS.iter().zip(&mut self.0);
        let (Some((_, probe)), Level::Switch(on)) = (rows.find(|(input, _)| input.name == name), level)
        else {
            return false;
        };
        if on != probe.level {
            probe.level = on;
            probe.edge(position);
        }
        true
    }
}

impl Probe {
    const fn edge(&mut self, position: i64) {
        let (wanted, stored) = if self.level { (RISING, RISING_STORED) } else { (FALLING, FALLING_STORED) };
        let again = self.function & CONTINUOUS != 0 || self.status & stored == 0;
        if self.function & ON == 0 || self.function & wanted == 0 || !again {
            return;
        }
        self.status |= stored;
        if self.level {
            self.rising = position;
        } else {
            self.falling = position;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press(probes: &mut Probes, position: i64) {
        assert!(probes.change("touch_probe_1", Level::Switch(true), position));
        assert!(probes.change("touch_probe_1", Level::Switch(false), position + 1));
    }

    #[test]
    fn the_first_edge_or_every_one() {
        let mut probes = Probes::default();
        press(&mut probes, 5);
        assert_eq!((probes.status(), probes.positions()[0]), (0, (0, 0)), "off");
        probes.choose(0x11);
        press(&mut probes, 10);
        press(&mut probes, 20);
        assert_eq!((probes.status(), probes.positions()[0]), (0b011, (10, 0)));
        probes.choose(0x33);
        press(&mut probes, 30);
        press(&mut probes, 40);
        assert_eq!((probes.status(), probes.positions()[0]), (0b111, (40, 41)));
        probes.choose(0x1100);
        assert!(probes.change("touch_probe_2", Level::Switch(true), 7));
        assert_eq!((probes.status(), probes.positions()[1]), (0x0300, (7, 0)));
    }
}
