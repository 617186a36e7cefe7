//! Our own octets, heard back from an adapter whose receiver is on while it sends.

use std::collections::VecDeque;

use crate::profibus::fdl::telegram::{Decoded, decode};

/// Octets that are kept to be compared at most: those of some telegrams.
const MAX_EXPECTED: usize = 1024;

/// What was sent and can come back.
///
/// Between a reply and its echo nobody else can speak, so the echo is what is heard first or not at all. A request never
/// begins with a whole reply before it, so nothing but an echo is dropped: octets that begin like one and go on otherwise
/// are handed over late, but whole.
#[derive(Debug, Default)]
pub(super) struct Echo {
    /// Sent, and not heard back yet.
    expected: VecDeque<u8>,
    /// Heard, and so far equal to what was sent.
    matched: VecDeque<u8>,
}

impl Echo {
    /// These octets were sent. Only a whole telegram is sure to differ from what comes next.
    pub(super) fn sent(&mut self, octets: &[u8]) {
        if !matches!(decode(octets), Decoded::Telegram { len, .. } if len == octets.len()) {
            return;
        }
        if self.expected.len() + octets.len() > MAX_EXPECTED {
            self.expected.clear();
        }
        self.expected.extend(octets);
    }

    /// Hands over what was heard, but for the echo.
    pub(super) fn hear(&mut self, octets: &[u8], heard: &mut VecDeque<u8>) {
        for octet in octets {
            match self.expected.front() {
                Some(expected) if expected == octet => {
                    self.expected.pop_front();
                    self.matched.push_back(*octet);
                    if self.expected.is_empty() {
                        self.matched.clear();
                    }
                }
                Some(_) => {
                    // No echo, or a damaged one: all of it was meant to be heard.
                    heard.append(&mut self.matched);
                    self.expected.clear();
                    heard.push_back(*octet);
                }
                None => heard.push_back(*octet),
            }
        }
    }

    /// What was sent will not come back.
    pub(super) fn forget(&mut self) {
        self.expected.clear();
        self.matched.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPLY: [u8; 6] = [0x10, 0x02, 0x05, 0x00, 0x07, 0x16];
    const REQUEST: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];

    /// What is handed over of octets heard in two parts after the reply was sent.
    fn heard(octets: &[u8], cut: usize) -> Vec<u8> {
        let mut echo = Echo::default();
        let mut heard = VecDeque::new();
        echo.sent(&REPLY);
        echo.hear(&octets[..cut], &mut heard);
        echo.hear(&octets[cut..], &mut heard);
        heard.into()
    }

    #[test]
    fn an_echo_is_dropped_and_everything_else_is_heard_whole_wherever_it_is_cut() {
        let mut damaged = REPLY;
        damaged[3] = 0x01;
        for (octets, expected) in [
            (REPLY.to_vec(), Vec::new()),
            ([REPLY, REQUEST].concat(), REQUEST.to_vec()),
            (REQUEST.to_vec(), REQUEST.to_vec()),
            ([REQUEST, REPLY].concat(), [REQUEST, REPLY].concat()),
            ([REPLY, REPLY].concat(), REPLY.to_vec()),
            (damaged.to_vec(), damaged.to_vec()),
        ] {
            for cut in 0..=octets.len() {
                assert_eq!(heard(&octets, cut), expected, "{octets:02X?} cut at {cut}");
            }
        }
    }

    #[test]
    fn replies_without_echo_are_not_kept_for_ever() {
        let mut echo = Echo::default();
        for _ in 0..10_000 {
            echo.sent(&REPLY);
            assert!((1..=MAX_EXPECTED).contains(&echo.expected.len()));
        }
        let mut heard = VecDeque::new();
        echo.hear(&REQUEST, &mut heard);
        assert_eq!(heard, REQUEST);
        assert!(echo.expected.is_empty());
    }
}
