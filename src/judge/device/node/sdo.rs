//! Transfers of an SDO client, with every octet of the answers looked at.

use super::Tester;
use crate::can_bus::canopen::sdo::block::{LAST, SEGMENT_LEN, crc_16};
use crate::can_bus::canopen::{Abort, Address, cob_id};
use crate::explain::hex;
use crate::judge::device::course::{Course, broken};

/// More octets are no value.
const LONGEST: usize = 1 << 20;

/// A code with its meaning.
pub(super) fn refused(code: u32) -> String {
    match Abort::from_code(code).meaning() {
        Some(meaning) => format!("{code:08X}h ({meaning})"),
        None => format!("{code:08X}h"),
    }
}

/// A request or an answer with an address.
pub(super) const fn addressed(command: u8, at: Address, [d, e, f, g]: [u8; 4]) -> [u8; 8] {
    let [a, b] = at.index.0.to_le_bytes();
    [command, a, b, at.sub.0, d, e, f, g]
}

/// The code of an answer that is an abort.
pub(super) const fn abort_of([command, _, _, _, d, e, f, g]: [u8; 8]) -> Option<u32> {
    if command == 0x80 { Some(u32::from_le_bytes([d, e, f, g])) } else { None }
}

/// The address that an answer repeats.
pub(super) const fn address_of([_, a, b, c, ..]: [u8; 8]) -> Address {
    Address::new(u16::from_le_bytes([a, b]), c)
}

/// The octets of an expedited answer: as many as it says, four if it says nothing; `None`: it is none.
pub(super) fn expedited([command, _, _, _, data @ ..]: [u8; 8]) -> Option<Vec<u8>> {
    let len = match command & 0x03 {
        3 => 4 - usize::from(command >> 2 & 3),
        2 => 4,
        _segmented => return None,
    };
    (command >> 5 == 2).then(|| data.get(..len).unwrap_or_default().to_vec())
}

impl Tester {
    /// Reads an entry: its octets, or the code of the abort.
    pub(super) fn upload(&mut self, at: Address) -> Course<Result<Vec<u8>, u32>> {
        let what = format!("a read of {at}");
        let answer = self.asked(addressed(0x40, at, [0; 4]), &what)?;
        if let Some(code) = abort_of(answer) {
            return Ok(Err(code));
        }
        if address_of(answer) != at {
            return broken(format!("{what} is answered with {}", address_of(answer)));
        }
        if let Some(octets) = expedited(answer) {
            return Ok(Ok(octets));
        }
        let [command, _, _, _, d, e, f, g] = answer;
        if command >> 5 != 2 {
            return broken(format!("{what} is answered with {}", hex(&answer)));
        }
        let announced = u32::from_le_bytes([d, e, f, g]);
        let octets = self.segments(&what)?;
        match octets {
            Ok(octets) => {
                let says = command & 1 == 1;
                if says && u32::try_from(octets.len()) != Ok(announced) {
                    let came = octets.len();
                    return broken(format!("{what} announces {announced} octets, and {came} come"));
                }
                Ok(Ok(octets))
            }
            Err(code) => Ok(Err(code)),
        }
    }

    /// The segments of an upload that has begun.
    fn segments(&mut self, what: &str) -> Course<Result<Vec<u8>, u32>> {
        let (mut octets, mut toggle) = (Vec::new(), 0);
        loop {
            let answer = self.asked([0x60 | toggle, 0, 0, 0, 0, 0, 0, 0], "a segment request")?;
            if let Some(code) = abort_of(answer) {
                return Ok(Err(code));
            }
            let [command, data @ ..] = answer;
            if command >> 5 != 0 {
                return broken(format!("a segment of {what} is answered with {}", hex(&answer)));
            }
            if command & 0x10 != toggle {
                return broken(format!("a segment of {what} has not the toggle bit of its request"));
            }
            let len = 7 - usize::from(command >> 1 & 7);
            octets.extend(data.get(..len).unwrap_or_default());
            if data.iter().skip(len).any(|octet| *octet != 0) {
                self.note("N-O08", "octets of the last segment that are not used are not 0");
            }
            if command & 1 == 1 {
                return Ok(Ok(octets));
            }
            if octets.len() > LONGEST {
                return broken(format!("{what} does not end"));
            }
            toggle ^= 0x10;
        }
    }

    /// Writes an entry, in segments if it is longer than four octets: whether it is taken, or the code of the abort.
    pub(super) fn download(&mut self, at: Address, octets: &[u8]) -> Course<Result<(), u32>> {
        let mut data = [0; 4];
        match data.get_mut(..octets.len()) {
            Some(front) if !octets.is_empty() => front.copy_from_slice(octets),
            Some(_) | None => return self.download_in_segments(at, octets),
        }
        let unused = 4_u8.saturating_sub(u8::try_from(octets.len()).unwrap_or(4));
        let what = format!("a write of {at}");
        let answer = self.asked(addressed(0x23 | unused << 2, at, data), &what)?;
        self.taken(answer, at, &what)
    }

    /// Whether an initiated download was taken.
    fn taken(&mut self, answer: [u8; 8], at: Address, what: &str) -> Course<Result<(), u32>> {
        if let Some(code) = abort_of(answer) {
            return Ok(Err(code));
        }
        let [command, _, _, _, rest @ ..] = answer;
        if command != 0x60 || address_of(answer) != at {
            return broken(format!("{what} is answered with {}", hex(&answer)));
        }
        if rest != [0; 4] {
            self.note("N-O01", "octets of an answer to a write that are reserved are not 0");
        }
        Ok(Ok(()))
    }

    /// The same in segments, however short.
    pub(super) fn download_in_segments(&mut self, at: Address, octets: &[u8]) -> Course<Result<(), u32>> {
        let what = format!("a write of {at} in segments");
        let len = u32::try_from(octets.len()).unwrap_or(u32::MAX);
        let answer = self.asked(addressed(0x21, at, len.to_le_bytes()), &what)?;
        match self.taken(answer, at, &what)? {
            Ok(()) => {}
            Err(code) => return Ok(Err(code)),
        }
        let mut chunks: Vec<&[u8]> = octets.chunks(SEGMENT_LEN).collect();
        if chunks.is_empty() {
            chunks.push(&[]);
        }
        let last = chunks.len() - 1;
        let mut toggle = 0;
        for (number, chunk) in chunks.into_iter().enumerate() {
            let answer = self.asked(segment(toggle, chunk, number == last), &what)?;
            if let Some(code) = abort_of(answer) {
                return Ok(Err(code));
            }
            if answer.first().is_none_or(|command| command & 0xF0 != 0x20 | toggle) {
                return broken(format!("a segment of {what} is answered with {}", hex(&answer)));
            }
            toggle ^= 0x10;
        }
        Ok(Ok(()))
    }

    /// A request that must be refused with one of these codes.
    pub(super) fn must_refuse(&mut self, got: Result<(), u32>, codes: &[u32], what: &str) -> Course {
        let expected: Vec<String> = codes.iter().map(|code| format!("{code:08X}h")).collect();
        let expected = expected.join(" or ");
        match got {
            Ok(()) => broken(format!("{what} is taken, expected {expected}")),
            Err(code) if codes.contains(&code) => Ok(()),
            Err(code) => broken(format!("{what} is refused with {}, expected {expected}", refused(code))),
        }
    }

    /// Reads an entry in blocks. `None`: it has no block upload.
    pub(super) fn upload_in_blocks(&mut self, at: Address, size: u8) -> Course<Option<Vec<u8>>> {
        let what = format!("a block read of {at}");
        let answer = self.asked(addressed(0xA4, at, [size, 0, 0, 0]), &what)?;
        if abort_of(answer).is_some() || expedited(answer).is_some() || answer.first() == Some(&0x41) {
            return Ok(None);
        }
        let [command, _, _, _, d, e, f, g] = answer;
        if command & 0xF9 != 0xC0 || address_of(answer) != at {
            return broken(format!("{what} is answered with {}", hex(&answer)));
        }
        let announced = u32::from_le_bytes([d, e, f, g]);
        self.send(self.id(cob_id::SDO_CLIENT), &[0xA3, 0, 0, 0, 0, 0, 0, 0])?;
        let mut octets = Vec::new();
        loop {
            let before = octets.len();
            self.wire.awaits(size);
            let (mut taken, mut last) = self.block(size, &mut octets, &what)?;
            if core::mem::take(&mut self.lose_segment) && taken > 1 {
                octets.truncate(before + SEGMENT_LEN);
                (taken, last) = (1, false);
            }
            if octets.len() > LONGEST {
                return broken(format!("{what} does not end"));
            }
            self.send(self.id(cob_id::SDO_CLIENT), &[0xA2, taken, size, 0, 0, 0, 0, 0])?;
            if last {
                break;
            }
        }
        let id = self.id(cob_id::SDO_SERVER);
        let Some(end) = self.find(super::tester::LATE * 3, |frame| frame.id() == id)? else {
            return broken(format!("the end of {what} does not come"));
        };
        let Ok([command, low, high, ..]) = <[u8; 8]>::try_from(end.frame.octets()) else {
            return broken(format!("the end of {what} is {}", end.frame));
        };
        if command & 0xE3 != 0xC1 {
            return broken(format!("the end of {what} is {}", end.frame));
        }
        octets.truncate(octets.len().saturating_sub(usize::from(command >> 2 & 7)));
        self.send(self.id(cob_id::SDO_CLIENT), &[0xA1, 0, 0, 0, 0, 0, 0, 0])?;
        if command_has_size(answer) && u32::try_from(octets.len()) != Ok(announced) {
            return broken(format!("{what} announces {announced} octets, and {} come", octets.len()));
        }
        let crc = crc_16(0, &octets);
        if answer.first().is_some_and(|command| command & 0x04 != 0) && u16::from_le_bytes([low, high]) != crc
        {
            return broken(format!("the checksum of {what} is {high:02X}{low:02X}h, expected {crc:04X}h"));
        }
        Ok(Some(octets))
    }

    /// The segments of one block: how many came, and whether it was the last one.
    fn block(&mut self, size: u8, octets: &mut Vec<u8>, what: &str) -> Course<(u8, bool)> {
        let id = self.id(cob_id::SDO_SERVER);
        for number in 1..=size {
            let Some(segment) = self.find(super::tester::LATE * 3, |frame| frame.id() == id)? else {
                self.alive()?;
                return broken(format!("segment {number} of {what} does not come"));
            };
            let [head, data @ ..] = segment.frame.octets() else {
                return broken(format!("segment {number} of {what} is empty"));
            };
            if head & 0x7F != number || data.len() != SEGMENT_LEN {
                return broken(format!("segment {number} of {what} is {}", segment.frame));
            }
            octets.extend(data);
            if head & LAST != 0 {
                return Ok((number, true));
            }
        }
        Ok((size, false))
    }

    /// Writes an entry in blocks. `None`: it has no block download.
    pub(super) fn download_in_blocks(
        &mut self,
        at: Address,
        octets: &[u8],
        crc: u16,
    ) -> Course<Option<Result<(), u32>>> {
        let what = format!("a block write of {at}");
        let len = u32::try_from(octets.len()).unwrap_or(u32::MAX);
        let answer = self.asked(addressed(0xC6, at, len.to_le_bytes()), &what)?;
        if let Some(code) = abort_of(answer) {
            return Ok(if code == Abort::COMMAND.code() { None } else { Some(Err(code)) });
        }
        let [command, _, _, _, mut size, ..] = answer;
        if command & 0xFB != 0xA0 || !(1..=127).contains(&size) {
            return broken(format!("{what} is answered with {}", hex(&answer)));
        }
        let segments: Vec<&[u8]> = octets.chunks(SEGMENT_LEN).collect();
        let (count, id) = (segments.len(), self.id(cob_id::SDO_CLIENT));
        let mut rest = segments.as_slice();
        while !rest.is_empty() {
            let (block, behind) = rest.split_at(rest.len().min(size.into()));
            let is_lost = core::mem::take(&mut self.lose_segment) && block.len() > 2;
            for (number, chunk) in (1_u8..).zip(block) {
                if is_lost && number == 2 {
                    continue;
                }
                let is_last = behind.is_empty() && usize::from(number) == block.len();
                let mut segment = [0; 8];
                for (to, octet) in
                    segment.iter_mut().zip([number | if is_last { LAST } else { 0 }].iter().chain(*chunk))
                {
                    *to = *octet;
                }
                self.send(id, &segment)?;
            }
            let server = self.id(cob_id::SDO_SERVER);
            let Some(taken) = self.find(super::tester::LATE * 3, |frame| frame.id() == server)? else {
                self.alive()?;
                return broken(format!("a block of {what} is not answered"));
            };
            match taken.frame.octets() {
                [0xA2, 1, next, ..] if is_lost => {
                    size = *next;
                    rest = rest.get(1..).unwrap_or_default();
                    continue;
                }
                [0xA2, taken, next, ..] if !is_lost && usize::from(*taken) == block.len() => size = *next,
                [0x80, _, _, _, d, e, f, g] => return Ok(Some(Err(u32::from_le_bytes([*d, *e, *f, *g])))),
                _other if is_lost => {
                    return broken(format!(
                        "a block whose segment 2 is lost is answered with {}",
                        taken.frame
                    ));
                }
                _other => return broken(format!("a block of {what} is answered with {}", taken.frame)),
            }
            rest = behind;
        }
        let unused = u8::try_from(count * SEGMENT_LEN - octets.len()).unwrap_or_default();
        let [low, high] = crc.to_le_bytes();
        let answer =
            self.asked([0xC1 | unused << 2, low, high, 0, 0, 0, 0, 0], "the end of a block write")?;
        match (abort_of(answer), answer.first()) {
            (Some(code), _) => Ok(Some(Err(code))),
            (None, Some(0xA1)) => Ok(Some(Ok(()))),
            (None, _) => broken(format!("the end of {what} is answered with {}", hex(&answer))),
        }
    }
}

/// Whether a block upload says how many octets will come.
fn command_has_size(answer: [u8; 8]) -> bool {
    answer.first().is_some_and(|command| command & 0x02 != 0)
}

/// A segment of a download.
pub(super) fn segment(toggle: u8, octets: &[u8], last: bool) -> [u8; 8] {
    let unused = SEGMENT_LEN.saturating_sub(octets.len());
    let command = toggle | u8::try_from(unused).unwrap_or_default() << 1 | u8::from(last);
    let mut segment = [0; 8];
    for (to, octet) in segment.iter_mut().zip([command].iter().chain(octets)) {
        *to = *octet;
    }
    segment
}
