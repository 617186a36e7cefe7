//! The rules of the bus: pauses, collisions, who may reply and when.

use super::line::{Asked, Said};
use super::{Breach, Line, Master, Sender};
use crate::host::Bus;
use crate::profibus::fdl::station::DEFAULT_MIN_TSDR;
use crate::profibus::fdl::telegram::Decoded;
use crate::profibus::fdl::{Function, Telegram};
use crate::time::{Instant, SYN_BITS};

impl<M: Master> Line<M> {
    /// The rule that is broken if this is sent now.
    pub(super) fn breach_of(
        &mut self,
        sender: Sender,
        bus: Option<usize>,
        said: Said<'_>,
        injected: bool,
    ) -> Option<Breach> {
        let asked = match sender {
            Sender::Master | Sender::Test => self.asked,
            // Octets of a station end the slot time, whatever they are.
            Sender::Station => self.asked.take(),
        };
        if let Some(other) = self.speaking {
            // Who cannot have heard the other yet is not to blame if a fault made it late.
            let heard = other.begin.saturating_add(self.baud.octet_times(1)) <= self.now;
            let excused = injected || (other.injected && !heard);
            return (!excused).then_some(Breach::Collision { at: self.now, by: sender });
        }
        match sender {
            Sender::Master | Sender::Test => self.breach_of_master(sender, asked, said),
            Sender::Station if injected => None,
            Sender::Station => self.breach_of_station(bus, asked, said),
        }
    }

    /// Requests and tokens: T_SYN before them, and no other reply to wait for. What the test sends may be anything.
    fn breach_of_master(&self, sender: Sender, asked: Option<Asked>, said: Said<'_>) -> Option<Breach> {
        let at = self.now;
        let is_request = match said.first {
            Decoded::Telegram { .. } if !said.is_one_telegram() && sender == Sender::Master => {
                return Some(Breach::NoTelegram { at, by: sender });
            }
            Decoded::Telegram { telegram: Telegram::Data(data), .. } => {
                matches!(data.fc.function(), Function::Request(..))
            }
            Decoded::Telegram { telegram: Telegram::Token { .. }, .. } => true,
            Decoded::Telegram { telegram: Telegram::ShortAcknowledge, .. } => false,
            Decoded::Incomplete | Decoded::Invalid { .. } => match sender {
                Sender::Master => return Some(Breach::NoTelegram { at, by: sender }),
                Sender::Test | Sender::Station => false,
            },
        };
        let (idle, expected) = (at.saturating_since(self.idle_since), self.baud.bit_times(SYN_BITS));
        // The line was silent before the simulation began.
        if is_request && idle < expected && self.idle_since > Instant::ZERO {
            return Some(Breach::NoSyn { at, idle, expected });
        }
        let waited = at.saturating_since(asked.filter(|_| is_request)?.end);
        let expected = self.slot_time;
        (waited < expected).then_some(Breach::NoSlotTime { at, waited, expected })
    }

    /// The reply to the last request, once, in time.
    fn breach_of_station(&self, bus: Option<usize>, asked: Option<Asked>, said: Said<'_>) -> Option<Breach> {
        let at = self.now;
        let rate = bus.and_then(|number| self.buses.get(number)).map_or(self.baud, Bus::baud);
        if rate != self.baud {
            return Some(Breach::WrongRate { at, got: rate, expected: self.baud });
        }
        let telegram = match said.first {
            Decoded::Telegram { telegram, .. } if said.is_one_telegram() => telegram,
            Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. } => {
                return Some(Breach::NoTelegram { at, by: Sender::Station });
            }
        };
        let Some(asked) = asked else {
            return Some(Breach::Unasked { at });
        };
        let after = at.saturating_since(asked.end);
        let earliest = self.baud.bit_times(DEFAULT_MIN_TSDR.into());
        let latest = self.baud.bit_times(self.baud.max_tsdr_bits().into());
        if after < earliest {
            return Some(Breach::TooEarly { at, after, expected: earliest });
        }
        if after > latest {
            return Some(Breach::TooLate { at, after, expected: latest });
        }
        match telegram {
            // SC names nobody.
            Telegram::ShortAcknowledge => None,
            Telegram::Data(data)
                if data.sa == asked.station
                    && data.da == asked.master
                    && matches!(data.fc.function(), Function::Response(..)) =>
            {
                None
            }
            Telegram::Data(data) => Some(Breach::WrongStation { at, got: data.sa, expected: asked.station }),
            Telegram::Token { .. } => Some(Breach::Unasked { at }),
        }
    }
}
