//! What a user asks of the test master, in the words of `profidrive judge --ask`.

use profidrive::time::Instant;

use super::acyclic::Wanted;
use super::mistakes::Mistake;
use super::slave::Slave;
use super::{CLEAR, Stop, TestMaster};

impl TestMaster {
    /// Does what is asked for; `false`: it cannot.
    pub(crate) fn do_action(&mut self, action: &str, now: Instant) -> bool {
        let words: Vec<&str> = action.split_whitespace().collect();
        let other = u8::from(self.does(Mistake::OtherGroup)) << 1;
        let groups = |text: &str| u8::from_str_radix(text, 16).unwrap() ^ other;
        match words[..] {
            ["operate"] if self.stop == Stop::No => {
                (self.operate, self.cleared) = (true, false);
                if self.does(Mistake::ZerosAfterClear) {
                    for slave in &mut self.slaves {
                        slave.user_outputs = slave.user_outputs.take().map(|outputs| vec![0; outputs.len()]);
                    }
                }
                self.controls.push_back((0, 0));
            }
            ["restart"] if self.does(Mistake::DoesNotRestart) => {}
            ["stop"] if self.does(Mistake::DoesNotStop) => {}
            ["operate" | "restart"] => {
                let fresh = Self::new(self.settings.clone(), self.mistake);
                *self = Self { next: now, ..fresh };
                if self.does(Mistake::BeginsWithOperate) {
                    self.operate = true;
                    self.controls = [(0, 0)].into();
                }
                self.listen(now);
            }
            ["clear"] => {
                (self.operate, self.cleared) = (false, true);
                if !self.does(Mistake::NoClearData) {
                    self.controls.push_back((CLEAR, 0));
                }
            }
            ["stop"] if self.does(Mistake::StopsFromOperate) => self.stop = Stop::Releasing,
            ["stop"] => {
                (self.operate, self.stop) = (false, Stop::Clearing);
                self.controls.push_back((CLEAR, 0));
            }
            ["outputs", address, hex] => {
                let outputs = octets(hex);
                let number: u8 = address.parse().unwrap();
                let wrong = self.does(Mistake::OtherOutputs);
                let torn = self.does(Mistake::TornOutputs);
                let meant = |slave: &&mut Slave| (slave.configured.address == number) != wrong;
                let slave = self.slaves.iter_mut().find(meant).unwrap();
                (slave.user_outputs, slave.torn) = (Some(outputs), torn);
            }
            ["sync", group] => self.controls.push_back((0x20, groups(group))),
            ["unsync", group] => self.controls.push_back((0x10, groups(group))),
            ["freeze", group] => self.controls.push_back((0x08, groups(group))),
            ["unfreeze", group] => self.controls.push_back((0x04, groups(group))),
            ["read", address, slot, index, len] => {
                return self.want(address, slot, index, Err(len.parse().unwrap()));
            }
            ["write", address, slot, index, hex] => {
                return self.want(address, slot, index, Ok(octets(hex)));
            }
            _ => return false,
        }
        true
    }

    /// The user wants a record; `false`: of a slave without DP-V1.
    fn want(&mut self, address: &str, slot: &str, index: &str, data: Result<Vec<u8>, u8>) -> bool {
        let number: u8 = address.parse().unwrap();
        let slave = self.slaves.iter_mut().find(|slave| slave.configured.address == number).unwrap();
        let Some(services) = &mut slave.services else { return false };
        services.wanted.push_back(Wanted {
            slot: slot.parse().unwrap(),
            index: index.parse().unwrap(),
            data,
        });
        true
    }
}

fn octets(hex: &str) -> Vec<u8> {
    let octet = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).unwrap();
    (0..hex.len()).step_by(2).map(octet).collect()
}
