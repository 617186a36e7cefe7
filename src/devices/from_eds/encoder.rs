//! CiA 406: an encoder behind a file, from the objects that it has.
//!
//! ```text
//! steps of the shaft ─▶ code sequence (6000h bit 0) ─▶ scaling (6000h bit 2: 6001h, 6002h) ─▶ + offset 6509h ─▶ 6004h
//! ```

use core::time::Duration;

use super::dictionary::{Role, Row};
use super::{Behaviour, FromEds};
use crate::can_bus::canopen::address::Sub;
use crate::can_bus::canopen::dictionary::Entry;
use crate::can_bus::canopen::value::{DataType, ValueKind};
use crate::can_bus::canopen::{Abort, Address, Notice, Reset, Value};
use crate::time::Instant;

/// The speed is measured over so long at least, and is zero when nothing has moved for longer.
const GATE: Duration = Duration::from_millis(20);
const STANDSTILL: Duration = Duration::from_millis(200);

/// The offset in what is kept beside the dictionary.
pub(super) const OFFSET_OCTETS: usize = 8;

/// What an entry is to the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// 6004h: where the shaft is.
    Position,
    /// 6003h: what the position is from now on.
    Preset,
    /// 6030h: units of the position in a second.
    Speed,
    /// 6300h: cams that are active.
    Cams,
    /// 6400h: outside of the work area.
    Area,
    /// 6500h: what 6000h has switched on.
    Status,
    /// 6509h: what the preset has added.
    Offset,
    /// 6000h to 6002h, 6301h to 6337h, 6401h, 6402h: the position or the cams follow.
    Setting,
}

impl Part {
    pub(super) fn of(at: Address, table: &Entry) -> Option<Self> {
        if !table.data.kind().is_whole() {
            return None;
        }
        let part = match at.pair() {
            (0x6004, 0) if !table.is_writable() => Self::Position,
            (0x6003, 0) => Self::Preset,
            (0x6030, 0) if table.data.kind() == ValueKind::Signed => Self::Speed,
            (0x6030, 1) => Self::Speed,
            (0x6300, 1) => Self::Cams,
            (0x6400, 1) => Self::Area,
            (0x6500, 0) => Self::Status,
            (0x6509, 0) => Self::Offset,
            (0x6000..=0x6002, 0) | (0x6301..=0x6337, 1) | (0x6401 | 0x6402, 1) => Self::Setting,
            (_, _) => return None,
        };
        Some(part)
    }

    /// Whether its value comes from outside.
    pub(super) fn is_input(self) -> bool {
        self == Self::Position
    }
}

/// The shaft and what was made of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Encoder {
    /// Steps.
    shaft: i64,
    offset: i64,
    /// After power-on.
    kept_offset: i64,
    speed: i64,
    /// Where the shaft was then.
    mark: Option<(Instant, i64)>,
    still_at: Option<Instant>,
    /// Bit n: the position is in cam n + 1.
    cams: u8,
}

impl Encoder {
    /// Where the shaft is, steps.
    pub(super) const fn shaft(&self) -> i64 {
        self.shaft
    }

    pub(super) const fn due(&self) -> Option<Instant> {
        self.still_at
    }

    pub(super) fn advance(&mut self, now: Instant) {
        if self.still_at.is_some_and(|due| due <= now) {
            self.still_at = None;
            self.mark = None;
            self.speed = 0;
        }
    }

    /// 1010h and 1011h: 6003h is of the application.
    pub(super) const fn keep(&mut self, group: Sub) {
        if let 1 | 3 = group.0 {
            self.kept_offset = self.offset;
        }
    }

    pub(super) const fn forget(&mut self, group: Sub) {
        if let 1 | 3 = group.0 {
            self.kept_offset = 0;
        }
    }

    pub(super) const fn kept_offset(&self) -> [u8; OFFSET_OCTETS] {
        self.kept_offset.to_le_bytes()
    }

    pub(super) const fn recall_offset(&mut self, octets: [u8; OFFSET_OCTETS]) {
        self.kept_offset = i64::from_le_bytes(octets);
    }
}

/// How steps become positions.
struct Scale {
    /// Of the shaft, in steps.
    range: i128,
    counts_down: bool,
    units: i128,
    steps: i128,
    /// Positions run from 0 to it, that it is not.
    end: i128,
}

impl Scale {
    fn units_of(&self, shaft: i64) -> i128 {
        let shaft = i128::from(shaft).rem_euclid(self.range);
        let shaft = if self.counts_down { (self.range - shaft).rem_euclid(self.range) } else { shaft };
        shaft * self.units / self.steps
    }

    fn position(&self, shaft: i64, offset: i64) -> i64 {
        let position = (self.units_of(shaft) + i128::from(offset)).rem_euclid(self.end);
        i64::try_from(position).unwrap_or_default()
    }
}

impl FromEds {
    fn whole(&self, index: u16, sub: u8) -> Option<i64> {
        let place = self.dictionary.place(Address::new(index, sub))?;
        self.memory.read(place, self.dictionary.rows.get(place)?)?.number()
    }

    fn scale(&self) -> Scale {
        let above = |index| self.whole(index, 0).filter(|number| *number > 0).map(i128::from);
        let all = i128::from(u32::MAX) + 1;
        let steps = above(0x6501);
        let range = steps.map_or(all, |steps| steps * above(0x6502).unwrap_or(1)).min(all);
        let operating = self.whole(0x6000, 0).unwrap_or_default();
        let scaled = steps.zip(above(0x6001)).filter(|_| operating & 0b100 != 0);
        let (steps, units) = scaled.unwrap_or((1, 1));
        let whole = (range * units / steps).max(1);
        let end = if scaled.is_some() { above(0x6002).unwrap_or(whole) } else { whole };
        Scale { range, counts_down: operating & 1 != 0, units, steps, end }
    }

    fn position(&self, encoder: &Encoder) -> i64 {
        self.scale().position(encoder.shaft, encoder.offset)
    }

    /// What the encoder tells in this entry, if it does not come from the memory.
    pub(super) fn encoder_value(
        &self,
        encoder: &Encoder,
        part: Part,
        data: DataType,
    ) -> Option<Value<'static>> {
        let number = match part {
            Part::Position => self.position(encoder),
            Part::Speed => encoder.speed,
            Part::Cams => {
                let said = |index| self.whole(index, 1).map(|bits| bits & 0xFF);
                (i64::from(encoder.cams) ^ said(0x6302).unwrap_or_default()) & said(0x6301).unwrap_or(0xFF)
            }
            Part::Area => {
                let position = self.position(encoder);
                let low = self.whole(0x6401, 1).is_some_and(|low| position < low);
                let high = self.whole(0x6402, 1).is_some_and(|high| position > high);
                i64::from(low || high) | i64::from(high) << 1 | i64::from(low) << 2
            }
            Part::Status => self.whole(0x6000, 0).unwrap_or_default(),
            Part::Offset => encoder.offset,
            Part::Preset | Part::Setting => return None,
        };
        let (low, high) = data.range()?;
        // A speed ends at its limits; what counts runs round.
        let number = match part {
            Part::Speed => number.clamp(low, high),
            Part::Position
            | Part::Preset
            | Part::Cams
            | Part::Area
            | Part::Status
            | Part::Offset
            | Part::Setting => {
                let (low, high) = (i128::from(low), i128::from(high));
                i64::try_from((i128::from(number) - low).rem_euclid(high - low + 1) + low).ok()?
            }
        };
        Value::whole(data, number)
    }

    /// Whether the encoder takes that value.
    pub(super) fn judge_encoder(&self, row: &Row, value: Value<'_>) -> Result<(), Abort> {
        match (row.role, value.number()) {
            (Role::Encoder(Part::Preset), Some(number)) if i128::from(number) >= self.scale().end => {
                Err(Abort::TOO_HIGH)
            }
            (_, _) => Ok(()),
        }
    }

    /// A master has written an object.
    pub(super) fn encoder_written(&mut self, part: Part, value: Value<'_>) {
        let (scale, number) = (self.scale(), value.number());
        if let (Part::Preset, Some(preset), Behaviour::Encoder(encoder)) = (part, number, &mut self.behaviour)
        {
            let offset = i128::from(preset) - scale.units_of(encoder.shaft);
            encoder.offset = i64::try_from(offset).unwrap_or_default();
        }
        self.follow_cams();
    }

    /// Steps of the shaft, from outside.
    pub(super) fn turn_shaft(&mut self, now: Instant, steps: f64) {
        let scale = self.scale();
        let Behaviour::Encoder(encoder) = &mut self.behaviour else { return };
        #[expect(clippy::cast_possible_truncation, reason = "casts saturate")]
        let steps = steps.round() as i64;
        if steps == encoder.shaft {
            return;
        }
        let before = *encoder.mark.get_or_insert((now, encoder.shaft));
        encoder.shaft = steps;
        encoder.still_at = Some(now.saturating_add(STANDSTILL));
        let time = now.saturating_since(before.0);
        if time >= GATE {
            // The shorter way round.
            let moved = scale.units_of(steps) - scale.units_of(before.1);
            let turn = (scale.range * scale.units / scale.steps).max(1);
            let moved = (moved + turn / 2).rem_euclid(turn) - turn / 2;
            let nanos = i128::try_from(time.as_nanos()).unwrap_or(i128::MAX);
            encoder.speed = i64::try_from(moved * 1_000_000_000 / nanos).unwrap_or_default();
            encoder.mark = Some((now, steps));
        }
        self.follow_cams();
    }

    /// Cams from 6310h to 6337h; a position that leaves one goes its hysteresis beyond.
    fn follow_cams(&mut self) {
        let Behaviour::Encoder(encoder) = &self.behaviour else { return };
        let (before, position) = (encoder.cams, self.position(encoder));
        let limits = |cam: u16| {
            let low = self.whole(0x6310 + cam, 1)?;
            Some((low, self.whole(0x6320 + cam, 1)?, self.whole(0x6330 + cam, 1).unwrap_or_default()))
        };
        let cams = (0..8).filter(|cam| {
            let Some((low, high, beyond)) = limits(*cam) else { return false };
            let beyond = if before >> cam & 1 == 1 { beyond } else { 0 };
            (low.saturating_sub(beyond)..=high.saturating_add(beyond)).contains(&position)
        });
        let cams = cams.fold(0, |cams, cam| cams | 1 << cam);
        if let Behaviour::Encoder(encoder) = &mut self.behaviour {
            encoder.cams = cams;
        }
    }

    pub(super) fn notice_encoder(&mut self, notice: Notice) {
        if let (Notice::Reset(Reset::PowerOn | Reset::Node), Behaviour::Encoder(encoder)) =
            (notice, &mut self.behaviour)
        {
            encoder.offset = encoder.kept_offset;
            self.follow_cams();
        }
    }
}
