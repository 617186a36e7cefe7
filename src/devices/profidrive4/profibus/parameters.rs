//! The values of the parameters: where each is read, and what a write does.

use super::free::{self, Free};
use super::table::{Actual, Entry, Profile, Source, Table};
use super::telegram::Telegram;
use super::{signal::Signal, value};
use crate::devices::profidrive4::encoder::{LINES, REVOLUTIONS, SHIFT_1, SHIFT_2};
use crate::devices::profidrive4::{Drive, Fault, Setting};
use crate::profibus::dpv1::MAX_DATA;
use crate::profibus::dpv1::base_mode::{MAX_PARAMETERS, ParameterError};
use crate::profibus::fdl::Address;
use crate::time::BaudRate;

/// The element of a parameter, from 0, and what is wrong with it.
pub(super) type Wrong = (ParameterError, u16);

pub(super) const NO_PARAMETER: ParameterError = ParameterError(0x00);
pub(super) const READ_ONLY: ParameterError = ParameterError(0x01);
pub(super) const LIMITS: ParameterError = ParameterError(0x02);
pub(super) const NO_SUBINDEX: ParameterError = ParameterError(0x03);
pub(super) const NO_ARRAY: ParameterError = ParameterError(0x04);
pub(super) const ONLY_ZERO: ParameterError = ParameterError(0x06);
pub(super) const NO_RIGHT: ParameterError = ParameterError(0x0B);
const NOT_IN_THIS_STATE: ParameterError = ParameterError(0x11);
pub(super) const NOT_PERMITTED: ParameterError = ParameterError(0x14);

/// The profile of drives, and version 4.2 of it (PNU 965).
const PROFILE: [u8; 2] = [3, 0x2A];
/// Version, year, day and month of the drive (PNU 964, 975).
const VERSION: [u16; 3] = [0x0100, 2026, 2611];
/// An axis (PNU 975), of application classes 1, 3 and 4.
const TYPE_CLASS: u16 = 1;
const SUB_CLASS: u16 = 0x000D;
/// The number of the one drive object.
pub(super) const OBJECT: u8 = 1;
/// One encoder, of five elements, in structure 1.2 (PNU 979); its description is valid and does not change.
const ENCODER: [u32; 2] = [0x0000_5112, 0xC000_0002];
/// Situations and faults of each in the buffer (PNU 950).
const BUFFER: [u16; 2] = [8, 8];

/// What the drive alone does not know.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub(super) address: Address,
    pub(super) baud: BaudRate,
    pub(super) ident: u16,
    pub(super) telegram: Option<Telegram>,
    pub(super) stw1: u16,
    pub(super) zsw1: u16,
}

impl Known {
    /// The master chooses the signals of the telegram.
    fn is_free(&self) -> bool {
        self.telegram.as_ref().is_some_and(|telegram| telegram.number == free::NUMBER)
    }
}

impl Entry {
    /// Whether it may be changed at all with this telegram.
    pub(super) fn is_writable(&self, known: &Known) -> bool {
        self.writable && (self.way().is_none() || known.is_free())
    }
}

/// What a write asks of whoever has the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    /// PNU 971.
    Store,
    /// PNU 972.
    Reset,
}

/// The drive with its parameters.
#[derive(Debug)]
pub(super) struct Parameters {
    pub(super) drive: Drive,
    pub(super) table: Table,
    /// What the master chose for telegram 999.
    pub(super) free: Free,
    /// Whether parameters may be changed (PNU 927).
    may_change: bool,
    /// What was stored is not safe yet (PNU 971).
    pub(super) storing: bool,
    pub(super) effect: Option<Effect>,
}

impl Parameters {
    pub(super) fn new(drive: Drive, table: Table) -> Self {
        let mut this = Self { drive, table, free: Free::NEW, may_change: true, storing: false, effect: None };
        this.make_new();
        this
    }

    /// All settings are those of a new drive.
    pub(super) fn make_new(&mut self) {
        let settings = self.drive.settings_mut();
        *settings = Default::default();
        for (setting, value) in &self.table.firsts {
            settings.set(*setting, *value);
        }
        *self.drive.blocks_mut() = Default::default();
        self.table.make_new();
        self.free = Free::NEW;
        self.may_change = true;
    }

    /// How many elements a parameter has; `None`: it is no array.
    pub(super) fn count(&self, entry: &Entry, known: &Known) -> Option<u16> {
        let Source::Profile(profile) = entry.source else { return entry.elements };
        let words = |signals: &[Signal]| signals.iter().map(|signal| signal.words()).sum::<usize>();
        let of_telegram = |signals: fn(&Telegram) -> &[Signal]| {
            known.telegram.as_ref().map_or(0, |telegram| words(signals(telegram)))
        };
        let count = if profile == Profile::Setpoints {
            of_telegram(|telegram| &telegram.setpoints)
        } else if profile == Profile::ActualValues {
            of_telegram(|telegram| &telegram.actual_values)
        } else if profile == Profile::Signals {
            usize::from(Signal::MOST) + 1
        } else if profile == Profile::FaultList {
            Fault::ALL.len()
        } else if profile == Profile::List {
            // An element of 0 ends the list.
            self.table.entries().count() + 1
        } else {
            return entry.elements;
        };
        Some(u16::try_from(count).unwrap_or(u16::MAX))
    }

    /// Whether a parameter has these elements: the first one, and how many, 0 and 1 alike.
    pub(super) fn check_elements(
        &self,
        entry: &Entry,
        known: &Known,
        (first, elements): (u16, u8),
    ) -> Result<(), Wrong> {
        let last = u32::from(first) + u32::from(elements.max(1)) - 1;
        match self.count(entry, known) {
            None if last == 0 => Ok(()),
            None => Err((NO_ARRAY, 0)),
            Some(count) if last < u32::from(count) => Ok(()),
            Some(count) => Err((NO_SUBINDEX, first.max(count))),
        }
    }

    /// The value of an element that there is, on the bus.
    pub(super) fn value(&self, entry: &Entry, known: &Known, element: u16) -> f64 {
        let at = usize::from(element);
        match &entry.source {
            Source::Own { values, .. } => values.get(at).copied().unwrap_or_default(),
            Source::Setting(setting) => self.drive.settings().of(*setting) / entry.scale,
            Source::Block(field) => {
                self.drive.blocks().0.get(at).map_or(0.0, |block| block.of(*field).into())
            }
            Source::Actual(actual) => self.actual(*actual) / entry.scale,
            Source::Profile(profile) => self.of_profile(*profile, known, at),
        }
    }

    fn actual(&self, actual: Actual) -> f64 {
        let status = self.drive.status();
        match actual {
            Actual::Setpoint => status.demand,
            Actual::Speed => status.speed,
            Actual::Current => status.current,
            Actual::Torque => status.torque,
            Actual::Position => self.drive.axis().position,
            Actual::Fault => self.drive.standing_faults().next().map_or(0.0, |fault| fault.number.into()),
            Actual::Warning => self.drive.warnings().standing().first().copied().map_or(0.0, Into::into),
        }
    }

    fn of_profile(&self, profile: Profile, known: &Known, at: usize) -> f64 {
        let drive = &self.drive;
        let fault =
            || u8::try_from(at).ok().and_then(|place| drive.faults().noted(place)).unwrap_or_default();
        let word = |words: &[u16]| f64::from(words.get(at).copied().unwrap_or_default());
        let signals = |signals: &[Signal]| {
            let words =
                signals.iter().flat_map(|signal| core::iter::repeat_n(signal.number(), signal.words()));
            f64::from(words.clone().nth(at).unwrap_or_default())
        };
        let [version, year, day] = VERSION;
        let telegram = known.telegram.as_ref();
        if let (Some(way), true) = (profile.way(), known.is_free()) {
            return self.free.number(way, at).into();
        }
        match profile {
            Profile::Setpoints => telegram.map_or(0.0, |telegram| signals(&telegram.setpoints)),
            Profile::ActualValues => telegram.map_or(0.0, |telegram| signals(&telegram.actual_values)),
            Profile::Signals => parameter_of(at),
            Profile::Address => known.address.number().into(),
            Profile::SystemNumber => f64::from(b"PROFIDRIVE      ".get(at).copied().unwrap_or(b' ')),
            Profile::Telegram => telegram.map_or(0.0, |telegram| telegram.number.into()),
            Profile::ParameterRights => self.may_change.into(),
            Profile::ProcessRights => 1.0,
            Profile::Mode if telegram.is_some_and(Telegram::positions) => 2.0,
            Profile::Mode => 1.0,
            Profile::FaultMessages => drive.faults().messages().into(),
            Profile::FaultCodes | Profile::FaultNumbers => fault().number.into(),
            Profile::FaultTimes => fault().millis.into(),
            Profile::FaultValues => fault().value.into(),
            Profile::FaultScaling => word(&BUFFER),
            Profile::FaultList => Fault::ALL.get(at).map_or(0.0, |fault| fault.number().into()),
            Profile::FaultSituations => drive.faults().count().into(),
            Profile::Warning(before) => drive.warnings().last(before.into()).into(),
            Profile::Rate => rate(known.baud).into(),
            Profile::Identification => word(&[0, known.ident, version, year, day, 1, 1]),
            Profile::Version => PROFILE.get(at).copied().unwrap_or_default().into(),
            Profile::ControlWord => known.stw1.into(),
            Profile::StatusWord => known.zsw1.into(),
            Profile::Store => self.storing.into(),
            Profile::Reset | Profile::Factory => 0.0,
            Profile::BaseMode => word(&[MAX_DATA.into(), MAX_PARAMETERS.into(), 1]),
            Profile::Object => {
                word(&[0, TYPE_CLASS, version, year, day, TYPE_CLASS, SUB_CLASS, OBJECT.into()])
            }
            Profile::Objects => OBJECT.into(),
            Profile::EncoderFormat => {
                let [header, kind] = ENCODER;
                let all = [header, kind, LINES, SHIFT_1, SHIFT_2, REVOLUTIONS];
                all.get(at).copied().unwrap_or_default().into()
            }
            Profile::List => self.table.entries().nth(at).map_or(0.0, |(pnu, _)| pnu.into()),
            Profile::SpeedReference => drive.settings().of(Setting::ReferenceSpeed),
        }
    }

    /// Whether a parameter may be changed now.
    pub(super) fn check_writable(&self, entry: &Entry, known: &Known, element: u16) -> Result<(), Wrong> {
        let rights = matches!(entry.source, Source::Profile(Profile::ParameterRights));
        if !entry.is_writable(known) {
            return Err((READ_ONLY, element));
        }
        if !self.may_change && !rights {
            return Err((NO_RIGHT, 0));
        }
        let wants_standstill = match &entry.source {
            Source::Setting(setting) => setting.wants_standstill(),
            Source::Profile(
                Profile::Reset | Profile::Factory | Profile::Setpoints | Profile::ActualValues,
            ) => true,
            Source::Profile(_) | Source::Block(_) | Source::Actual(_) | Source::Own { .. } => false,
        };
        if wants_standstill && self.drive.status().state.is_switched_on() {
            return Err((NOT_IN_THIS_STATE, 0));
        }
        Ok(())
    }

    /// Whether an element may have this value.
    pub(super) fn check_value(&self, entry: &Entry, element: u16, value: f64) -> Result<(), Wrong> {
        let (low, high) = entry.limits;
        let within = |value: f64, (low, high): (f64, f64)| (low..=high).contains(&value);
        let of_source = match &entry.source {
            Source::Profile(Profile::FaultSituations) if value != 0.0 => return Err((ONLY_ZERO, element)),
            Source::Profile(Profile::Setpoints | Profile::ActualValues) => {
                let way = entry.way();
                let is_one = way.is_some_and(|way| free::signal(way, value).is_some());
                return if is_one { Ok(()) } else { Err((NOT_PERMITTED, element)) };
            }
            Source::Setting(setting) => within(value * entry.scale, setting.limits()),
            Source::Profile(_) | Source::Block(_) | Source::Actual(_) | Source::Own { .. } => true,
        };
        // Also what is no number.
        if within(value, (low, high)) && of_source { Ok(()) } else { Err((LIMITS, element)) }
    }

    /// Sets an element to a value that was checked.
    pub(super) fn set(&mut self, pnu: u16, element: u16, value: f64) {
        let Some(entry) = self.table.entry_mut(pnu) else { return };
        match &mut entry.source {
            Source::Own { values, .. } => {
                values.iter_mut().skip(element.into()).take(1).for_each(|place| *place = value);
            }
            Source::Setting(setting) => {
                let (setting, value) = (*setting, value * entry.scale);
                self.drive.settings_mut().set(setting, value);
            }
            Source::Block(field) => {
                let field = *field;
                #[expect(clippy::cast_possible_truncation, reason = "within the limits of the field")]
                let value = value as i32;
                let blocks = self.drive.blocks_mut().0.iter_mut();
                blocks.skip(element.into()).take(1).for_each(|block| block.set(field, value));
            }
            Source::Actual(_) => {}
            Source::Profile(profile) => {
                let profile = *profile;
                match profile.way() {
                    Some(way) => {
                        let _checked = self.free.set(way, element, value);
                    }
                    None => self.set_of_profile(profile, value != 0.0),
                }
            }
        }
    }

    fn set_of_profile(&mut self, profile: Profile, on: bool) {
        match (profile, on) {
            (Profile::ParameterRights, _) => self.may_change = on,
            (Profile::FaultSituations, _) => self.drive.clear_faults(),
            (Profile::Store, true) => self.effect = Some(Effect::Store),
            (Profile::Reset, true) => self.effect = Some(Effect::Reset),
            (Profile::Factory, true) => self.make_new(),
            // All others can only be read.
            (_, _) => {}
        }
    }

    /// Every value that is kept when it is stored: number, element, bits.
    pub(super) fn kept(&self, known: &Known) -> Vec<((u16, u8), u32)> {
        let kept = self.table.entries().filter(|(_, entry)| entry.is_kept());
        let values = kept.flat_map(|(pnu, entry)| {
            let count = entry.elements.unwrap_or(1).min(u16::from(u8::MAX));
            (0..count).filter_map(move |element| {
                let bits = value::bits(entry.format, self.value(entry, known, element));
                Some(((pnu, u8::try_from(element).ok()?), bits))
            })
        });
        let changed = self.free.each().zip(Free::NEW.each()).filter(|(chosen, new)| chosen != new);
        let chosen = changed.map(|((way, word, number), _)| ((way.pnu(), word), number.into()));
        values.chain(chosen).collect()
    }

    /// Values that were kept; what the table does not take any more is left out.
    pub(super) fn recall(&mut self, known: &Known, values: &[((u16, u8), u32)]) {
        self.free = Free::NEW;
        for ((pnu, element), bits) in values {
            let Some(entry) = self.table.entry(*pnu) else { continue };
            let (element, value) = (u16::from(*element), value::of_bits(entry.format, *bits));
            let is_free = entry.way().is_some();
            let there = is_free || entry.is_kept() && self.check_elements(entry, known, (element, 1)).is_ok();
            if there && self.check_value(entry, element, value).is_ok() {
                self.set(*pnu, element, value);
            }
        }
    }
}

/// The parameter of the signal with this number (PNU 923); 0: there is none.
fn parameter_of(number: usize) -> f64 {
    let is_it = |signal: &&Signal| usize::from(signal.number()) == number;
    f64::from(Signal::ALL.iter().find(is_it).and_then(|signal| signal.parameter()).unwrap_or_default())
}

/// A rate of the line as PNU 963 counts it.
const fn rate(baud: BaudRate) -> u16 {
    match baud.bits_per_second() {
        9600 => 0,
        19_200 => 1,
        93_750 => 2,
        187_500 => 3,
        500_000 => 4,
        1_500_000 => 6,
        3_000_000 => 7,
        6_000_000 => 8,
        12_000_000 => 9,
        31_250 => 10,
        45_450 => 11,
        _ => 255,
    }
}
