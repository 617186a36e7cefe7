//! What else is spoken on a line where nobody speaks DP.

use crate::profibus::dp;
use crate::profibus::fdl::foreign::Foreign;
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{DataTelegram, Function, Service, Telegram};

/// Octets that are looked at, at most: the first ones.
const MOST: usize = 2048;

/// So many requests that are not of DP are no chance.
const NOT_DP: u8 = 3;

/// What was heard of a line: octets that are no telegrams, and requests.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overheard {
    noise: Vec<u8>,
    /// The newest request that is not one of DP, and how many there were.
    not_dp: Option<(Foreign, u8)>,
    /// A request of DP was heard.
    is_dp: bool,
}

impl Overheard {
    /// Takes one telegram, or octets that are none.
    pub(crate) fn take(&mut self, octets: &[u8]) {
        match decode(octets) {
            Decoded::Telegram { telegram: Telegram::Data(data), .. } => self.telegram(&data),
            Decoded::Telegram { telegram: Telegram::Token { .. } | Telegram::ShortAcknowledge, .. } => {}
            Decoded::Incomplete | Decoded::Invalid { .. } => {
                let room = MOST.saturating_sub(self.noise.len());
                self.noise.extend(octets.iter().take(room));
            }
        }
    }

    fn telegram(&mut self, data: &DataTelegram<'_>) {
        let Function::Request(service, _) = data.fc.function() else { return };
        match service {
            Service::FdlStatus
            | Service::Ident
            | Service::LsapStatus
            | Service::TimeEvent
            | Service::Msrd => {}
            Service::SrdLow
            | Service::SrdHigh
            | Service::SdaLow
            | Service::SdaHigh
            | Service::SdnLow
            | Service::SdnHigh => {
                self.is_dp |= dp::Service::of(data.dsap, data.ssap).is_some();
                if let Some(foreign) = Foreign::of_request(data) {
                    let times = self.not_dp.map_or(0, |(_, times)| times);
                    self.not_dp = Some((foreign, times.saturating_add(1)));
                }
            }
        }
    }

    /// Whether there were octets that are no telegrams.
    pub(crate) const fn has_noise(&self) -> bool {
        !self.noise.is_empty()
    }

    /// What is spoken; `None`: DP, or nothing that is known.
    pub(crate) fn foreign(&self) -> Option<Foreign> {
        if self.is_dp {
            return None;
        }
        let many = self.not_dp.filter(|(_, times)| *times >= NOT_DP);
        many.map(|(foreign, _)| foreign).or_else(|| Foreign::in_noise(&self.noise))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODBUS: [u8; 8] = [0x01, 0x03, 0, 0, 0, 0x0A, 0xC5, 0xCD];
    /// Master 2 asks SAP 10 of station 5, and the diagnosis.
    const FMS: [u8; 12] = [0x68, 6, 6, 0x68, 0x85, 0x82, 0x6D, 0x0A, 0x0B, 0x00, 0x89, 0x16];
    const DIAGNOSIS: [u8; 11] = [0x68, 5, 5, 0x68, 0x85, 0x82, 0x6D, 0x3C, 0x3E, 0xEE, 0x16];

    fn said(heard: &[&[u8]]) -> Option<String> {
        let mut overheard = Overheard::default();
        heard.iter().for_each(|octets| overheard.take(octets));
        overheard.foreign().map(|foreign| foreign.to_string())
    }

    #[test]
    fn another_protocol_is_named_whatever_pieces_it_comes_in() {
        let pieces = [&MODBUS[..3], &MODBUS[3..], &MODBUS[..]];
        assert!(said(&pieces).unwrap().contains("this is Modbus RTU, not PROFIBUS: station 1"));
        assert!(said(&[b"Temperature 21.5 C", b", humidity 40 %\r\n"]).unwrap().contains("text"));
    }

    #[test]
    fn who_asks_only_what_dp_does_not_have_speaks_another_protocol() {
        let not_dp = "master 2 speaks PROFIBUS, but not DP (it asks SAP 10): MPI, FMS or another protocol";
        assert_eq!(said(&[&FMS, &FMS, &FMS]).as_deref(), Some(not_dp));
        assert_eq!(said(&[&FMS, &FMS, &FMS, &DIAGNOSIS]), None);
        assert_eq!(said(&[&DIAGNOSIS, &MODBUS]), None);
    }
}
