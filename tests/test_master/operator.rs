//! What a user asks of the test master, in the words of `profidrive judge --ask`.

use profidrive::time::Instant;

use super::{CLEAR, Stop, TestMaster};

impl TestMaster {
    /// Does what is asked for; `false`: it cannot.
    pub(crate) fn do_action(&mut self, action: &str, now: Instant) -> bool {
        let words: Vec<&str> = action.split_whitespace().collect();
        let groups = |text: &str| u8::from_str_radix(text, 16).unwrap();
        match words[..] {
            ["operate"] if self.stop == Stop::No => {
                (self.operate, self.cleared) = (true, false);
                self.controls.push_back((0, 0));
            }
            ["operate" | "restart"] => {
                let fresh = Self::new(self.settings.clone(), self.mistake);
                *self = Self { next: now, ..fresh };
            }
            ["clear"] => {
                (self.operate, self.cleared) = (false, true);
                self.controls.push_back((CLEAR, 0));
            }
            ["stop"] => {
                (self.operate, self.stop) = (false, Stop::Clearing);
                self.controls.push_back((CLEAR, 0));
            }
            ["outputs", address, hex] => {
                let octet = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).unwrap();
                let outputs = (0..hex.len()).step_by(2).map(octet).collect();
                let number: u8 = address.parse().unwrap();
                let slave = self.slaves.iter_mut().find(|slave| slave.configured.address == number);
                slave.unwrap().user_outputs = Some(outputs);
            }
            ["sync", group] => self.controls.push_back((0x20, groups(group))),
            ["unsync", group] => self.controls.push_back((0x10, groups(group))),
            ["freeze", group] => self.controls.push_back((0x08, groups(group))),
            ["unfreeze", group] => self.controls.push_back((0x04, groups(group))),
            _ => return false,
        }
        true
    }
}
