//! A service access point that carries out one job at a time, and what is in the records (`dp-v1.md` 1.1, 2, 3, 7).

use std::collections::BTreeMap;

use profidrive::time::Instant;

use super::model::{Raised, refused};
use crate::dpv1_line::Record;
use crate::slave_line::{Answer, RR};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Channel {
    Ms1,
    Alarms,
    Ms2,
}

/// The records of slots 0 to 2, and I&M1.
#[derive(Clone, Debug)]
pub(super) struct Contents {
    pub(super) records: BTreeMap<(u8, u8), Record>,
    pub(super) tag: [u8; 64],
    /// How often a record was read or written.
    pub(super) runs: usize,
}

/// A request that was taken and not answered.
#[derive(Clone, Debug, Default)]
pub(super) struct Server {
    job: Option<(Instant, Vec<u8>)>,
    response: Option<Vec<u8>>,
    /// The block of I&M that was called.
    call: Option<u8>,
}

/// What a record answers.
type Outcome = Result<Vec<u8>, u8>;

impl Server {
    /// The request is taken and its response not fetched.
    pub(super) fn is_busy(&self) -> bool {
        self.job.is_some() || self.response.is_some()
    }

    pub(super) fn take(
        &mut self,
        channel: Channel,
        now: Instant,
        data: &[u8],
        max: u8,
        contents: &mut Contents,
        alarms: &mut Vec<Raised>,
    ) -> Answer {
        let is_poll = data.is_empty();
        if !is_poll && self.is_busy() {
            return RR;
        }
        if !is_poll {
            self.job = Some((now, data.to_vec()));
        }
        if let Some((since, pdu)) = self.job.take() {
            self.response = self.carry_out(channel, (since, now), &pdu, max, contents, alarms);
            if self.response.is_none() {
                self.job = Some((since, pdu));
            }
        }
        // Never the response in the reply to its request.
        match if is_poll { self.response.take() } else { None } {
            Some(response) => Answer::Low(response),
            None => Answer::Sc,
        }
    }

    /// `None`: not yet.
    fn carry_out(
        &mut self,
        channel: Channel,
        (since, now): (Instant, Instant),
        pdu: &[u8],
        max: u8,
        contents: &mut Contents,
        alarms: &mut Vec<Raised>,
    ) -> Option<Vec<u8>> {
        let function = pdu[0] & 0x7F;
        Some(match *pdu {
            [0x5E, slot, index, len] if channel != Channel::Alarms => {
                match self.read(slot, index, len, contents, (since, now))? {
                    Ok(mut data) => {
                        data.truncate(len.min(max).into());
                        [&[0x5E, slot, index, data.len() as u8], &data[..]].concat()
                    }
                    Err(code) => refused(function, code),
                }
            }
            [0x5F, slot, index, len, ref data @ ..]
                if usize::from(len) == data.len() && channel != Channel::Alarms =>
            {
                let outcome = match len {
                    0 => Err(0xB7),
                    len if len > max => Err(0xB1),
                    _ => self.write(slot, index, data, contents, (since, now))?,
                };
                outcome.map_or_else(|code| refused(function, code), |_| vec![0x5F, slot, index, len])
            }
            [0x5C, slot, kind, specifier] if channel != Channel::Ms2 => {
                let means = |alarm: &Raised| {
                    alarm.delivered && alarm.head[..2] == [kind, slot] && alarm.head[2] >> 3 == specifier >> 3
                };
                match alarms.iter().position(means) {
                    Some(at) => {
                        alarms.remove(at);
                        pdu.to_vec()
                    }
                    None => refused(function, 0xB5),
                }
            }
            [0x48] if channel == Channel::Ms2 => vec![0x48],
            // Lengths that do not agree.
            [0x5E | 0x5F, ..] if channel != Channel::Alarms => refused(function, 0xB7),
            _ => refused(function, 0xA9),
        })
    }

    fn read(
        &mut self,
        slot: u8,
        index: u8,
        len: u8,
        contents: &mut Contents,
        times: (Instant, Instant),
    ) -> Option<Outcome> {
        if len == 0 {
            return Some(Err(0xB7));
        }
        if index == 255 {
            let Some(block) = self.call.take() else { return Some(Err(0xB5)) };
            let octets = match block {
                0 => identification(),
                1 => contents.tag,
                _ => [b' '; 64],
            };
            return Some(Ok([&[8, 0, 0xFD, 0xE8 + block][..], &octets].concat()));
        }
        match contents.find(slot, index, times)? {
            Ok(record) if record.write_only => Some(Err(0xB6)),
            Ok(record) => Some(Ok(record.data.clone())),
            Err(code) => Some(Err(code)),
        }
    }

    fn write(
        &mut self,
        slot: u8,
        index: u8,
        data: &[u8],
        contents: &mut Contents,
        times: (Instant, Instant),
    ) -> Option<Outcome> {
        if index == 255 {
            return Some(self.write_identification(slot, data, contents));
        }
        Some(match contents.find(slot, index, times)? {
            Ok(record) if record.read_only => Err(0xB6),
            Ok(record) if record.data.len() != data.len() => Err(0xB1),
            Ok(record) => {
                record.data = data.to_vec();
                Ok(Vec::new())
            }
            Err(code) => Err(code),
        })
    }

    fn write_identification(&mut self, slot: u8, data: &[u8], contents: &mut Contents) -> Outcome {
        let [8, 0, 0xFD, low @ 0xE8..=0xEB, block @ ..] = data else { return Err(0xB0) };
        let number = low - 0xE8;
        match (number, <[u8; 64]>::try_from(block)) {
            (_, Err(_)) if !block.is_empty() => Err(0xB1),
            (_, Err(_)) if slot != 0 => Err(0xB0),
            (_, Err(_)) => {
                self.call = Some(number);
                Ok(Vec::new())
            }
            (1, Ok(octets)) if slot == 0 => {
                contents.tag = octets;
                Ok(Vec::new())
            }
            (_, Ok(_)) => Err(0xB6),
        }
    }
}

impl Contents {
    pub(super) fn new(records: &BTreeMap<(u8, u8), Record>) -> Self {
        Self { records: records.clone(), tag: [b' '; 64], runs: 0 }
    }

    fn find(
        &mut self,
        slot: u8,
        index: u8,
        (since, now): (Instant, Instant),
    ) -> Option<Result<&mut Record, u8>> {
        if slot > 2 {
            return Some(Err(0xB2));
        }
        let Some(record) = self.records.get_mut(&(slot, index)) else { return Some(Err(0xB0)) };
        if now.saturating_since(since) < record.delay {
            return None;
        }
        self.runs += 1;
        Some(Ok(record))
    }
}

/// I&M0 of the station, field by field.
fn identification() -> [u8; 64] {
    let parts: [&[u8]; 11] = [
        &[b' '; 10],
        &[0, 42],
        b"6ES7 000-0AA00      ",
        &[b' '; 16],
        &[0, 0],
        &[b'V', 0, 0, 0],
        &[0, 0],
        &[0xF6, 0],
        &[0, 0],
        &[1, 1],
        &[0, 0x0E],
    ];
    parts.concat().try_into().unwrap()
}
