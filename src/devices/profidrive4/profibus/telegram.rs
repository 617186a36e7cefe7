//! The telegrams: which signals are in the process data (`dp-v1.md` 9.2), as rows.

use std::borrow::Cow;

use super::free;
use super::signal::Signal;
use crate::profibus::dp::chk_cfg::{Identifier, Units, identifiers};
use crate::profibus::ppo::Pkw;

/// The first octet of the three of the maker behind a special identifier that names a telegram; its number follows.
const NAMES_A_TELEGRAM: u8 = 0xFD;

/// The octets of PKW.
const PKW_LEN: usize = 8;

/// A telegram.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Telegram {
    /// Its number (PNU 922).
    pub number: u16,
    /// The four words of PKW are in front of its signals.
    pub has_pkw: bool,
    /// Its number on the command line.
    pub word: &'static str,
    /// From the master.
    pub setpoints: Cow<'static, [Signal]>,
    /// To the master.
    pub actual_values: Cow<'static, [Signal]>,
}

macro_rules! telegrams {
    ($($number:literal $(+ $pkw:ident)?: [$($setpoint:ident)*] [$($actual:ident)*];)*) => {
        impl Telegram {
            /// Every telegram; of 999 the master chooses words and signals.
            pub const ALL: &'static [Self] = &[$(Self {
                number: $number,
                has_pkw: false $(|| stringify!($pkw).len() > 0)?,
                word: stringify!($number),
                setpoints: Cow::Borrowed(&[$(Signal::$setpoint),*]),
                actual_values: Cow::Borrowed(&[$(Signal::$actual),*]),
            }),*];

            /// Their numbers as words.
            pub(crate) const WORDS: &'static [&'static str] = &[$(stringify!($number)),*];
        }
    };
}

telegrams! {
    1: [Stw1 NsollA] [Zsw1 NistA];
    2: [Stw1 NsollB Stw2] [Zsw1 NistB Zsw2];
    3: [Stw1 NsollB Stw2 G1Stw] [Zsw1 NistB Zsw2 G1Zsw G1Xist1 G1Xist2];
    4: [Stw1 NsollB Stw2 G1Stw G2Stw] [Zsw1 NistB Zsw2 G1Zsw G1Xist1 G1Xist2 G2Zsw G2Xist1 G2Xist2];
    5: [Stw1 NsollB Stw2 G1Stw Xerr Kpc] [Zsw1 NistB Zsw2 G1Zsw G1Xist1 G1Xist2];
    6: [Stw1 NsollB Stw2 G1Stw G2Stw Xerr Kpc]
        [Zsw1 NistB Zsw2 G1Zsw G1Xist1 G1Xist2 G2Zsw G2Xist1 G2Xist2];
    7: [Stw1 Satzanw] [Zsw1 Aktsatz];
    9: [Stw1 Satzanw Stw2 MdiTarpos MdiVelocity MdiAcc MdiDec MdiMod] [Zsw1 Aktsatz Zsw2 XistA];
    20: [Stw1 NsollA] [Zsw1 NistAGlatt IaistGlatt MistGlatt PistGlatt MeldNamur];
    102: [Stw1 NsollB Stw2 Momred G1Stw] [Zsw1 NistB Zsw2 Meldw G1Zsw G1Xist1 G1Xist2];
    103: [Stw1 NsollB Stw2 Momred G1Stw G2Stw]
        [Zsw1 NistB Zsw2 Meldw G1Zsw G1Xist1 G1Xist2 G2Zsw G2Xist1 G2Xist2];
    105: [Stw1 NsollB Stw2 Momred G1Stw Xerr Kpc] [Zsw1 NistB Zsw2 Meldw G1Zsw G1Xist1 G1Xist2];
    106: [Stw1 NsollB Stw2 Momred G1Stw G2Stw Xerr Kpc]
        [Zsw1 NistB Zsw2 Meldw G1Zsw G1Xist1 G1Xist2 G2Zsw G2Xist1 G2Xist2];
    110: [Stw1 Satzanw PosStw Stw2 Override MdiTarpos MdiVelocity MdiAcc MdiDec MdiMod]
        [Zsw1 Aktsatz PosZsw Zsw2 Meldw XistA];
    111: [Stw1 PosStw1 PosStw2 Stw2 Override MdiTarpos MdiVelocity MdiAcc MdiDec Free]
        [Zsw1 PosZsw1 PosZsw2 Zsw2 Meldw XistA NistB FaultCode WarnCode Free];
    352: [Stw1 NsollA Free Free Free Free] [Zsw1 NistAGlatt IaistGlatt MistGlatt WarnCode FaultCode];
    353 + Pkw: [Stw1 NsollA] [Zsw1 NistAGlatt];
    354 + Pkw: [Stw1 NsollA Free Free Free Free] [Zsw1 NistAGlatt IaistGlatt MistGlatt WarnCode FaultCode];
    999: [] [];
}

fn octets(signals: &[Signal]) -> usize {
    2 * signals.iter().map(|signal| signal.words()).sum::<usize>()
}

/// The value of a signal in these octets.
fn value(signals: &[Signal], all: &[u8], wanted: Signal) -> Option<u32> {
    let place = signals.iter().position(|signal| *signal == wanted)?;
    let before = octets(signals.get(..place)?);
    let octets = all.get(before..before + 2 * wanted.words())?;
    Some(octets.iter().fold(0, |value, octet| value << 8 | u32::from(*octet)))
}

impl Telegram {
    /// The telegram of this number.
    pub fn numbered(number: u16) -> Option<&'static Self> {
        Self::ALL.iter().find(|telegram| telegram.number == number)
    }

    /// Whether it commands positions, not speeds.
    pub fn positions(&self) -> bool {
        let of_positions = [Signal::Satzanw, Signal::PosStw1];
        of_positions.iter().any(|signal| self.setpoints.contains(signal))
    }

    /// Octets from the master, and to it.
    pub fn lengths(&self) -> (usize, usize) {
        (self.pkw_len() + octets(&self.setpoints), self.pkw_len() + octets(&self.actual_values))
    }

    /// The octets of PKW in front of the signals.
    const fn pkw_len(&self) -> usize {
        if self.has_pkw { PKW_LEN } else { 0 }
    }

    /// The job of PKW in the octets from the master; `None`: the telegram has none.
    pub(super) fn job(&self, outputs: &[u8]) -> Option<Pkw> {
        outputs.first_chunk().copied().map(Pkw::from_octets).filter(|_| self.has_pkw)
    }

    /// The telegram of a configuration: that which it names, else the first of its lengths. `only`: no other one will do.
    /// The words of 999 are free.
    pub(crate) fn of_configuration(configuration: &[u8], only: Option<&Self>) -> Option<Self> {
        let (mut outputs, mut inputs, mut named) = (0, 0, None);
        let mut has_pkw = false;
        for octets in identifiers(configuration) {
            let Ok((identifier, _)) = Identifier::read(octets) else { return None };
            let both =
                (identifier.outputs.map_or(0, Units::octets), identifier.inputs.map_or(0, Units::octets));
            // PKW is an identifier of its own in front of the others.
            has_pkw |= (outputs, inputs, both) == (0, 0, (PKW_LEN, PKW_LEN));
            outputs += both.0;
            inputs += both.1;
            if let (Some(3), [.., NAMES_A_TELEGRAM, high, low]) = (identifier.manufacturer, octets) {
                named = Some(u16::from_be_bytes([*high, *low]));
            }
        }
        let fits = |telegram: &&Self| {
            telegram.lengths() == (outputs, inputs)
                && telegram.has_pkw == (has_pkw && outputs > PKW_LEN)
                && named.is_none_or(|number| number == telegram.number)
                && only.is_none_or(|only| only.number == telegram.number)
        };
        if named == Some(free::NUMBER) {
            let of_lengths = Self::free(outputs, inputs).filter(|_| !(has_pkw && outputs > PKW_LEN));
            return of_lengths.filter(|telegram| fits(&telegram));
        }
        Self::ALL.iter().find(fits).cloned()
    }

    /// Telegram 999 of so many octets.
    fn free(outputs: usize, inputs: usize) -> Option<Self> {
        let words = |octets: usize| {
            let fits = octets.is_multiple_of(2) && (1..=free::WORDS).contains(&(octets / 2));
            fits.then(|| Cow::Owned(vec![Signal::Free; octets / 2]))
        };
        let (setpoints, actual_values) = (words(outputs)?, words(inputs)?);
        Self::numbered(free::NUMBER).map(|empty| Self { setpoints, actual_values, ..empty.clone() })
    }

    /// A setpoint in the octets from the master, as a number; `None`: the telegram has none.
    pub fn setpoint(&self, outputs: &[u8], wanted: Signal) -> Option<u32> {
        value(&self.setpoints, outputs.get(self.pkw_len()..)?, wanted)
    }

    /// An actual value in the octets to the master, as a number; `None`: the telegram has none.
    pub fn actual_value(&self, inputs: &[u8], wanted: Signal) -> Option<u32> {
        value(&self.actual_values, inputs.get(self.pkw_len()..)?, wanted)
    }

    /// The octets to the master: the reply of PKW, if the telegram has one, and `value` says each signal.
    pub(super) fn inputs(&self, reply: Pkw, value: impl Fn(Signal) -> u32) -> Vec<u8> {
        let mut octets = if self.has_pkw { reply.to_octets().to_vec() } else { Vec::new() };
        for signal in &*self.actual_values {
            let value = value(*signal).to_be_bytes();
            octets.extend(value.iter().skip(value.len() - 2 * signal.words()));
        }
        octets
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_telegram_has_as_many_words_as_the_reference_says() {
        let words = [
            (1, 2, 2),
            (2, 4, 4),
            (3, 5, 9),
            (4, 6, 14),
            (5, 9, 9),
            (6, 10, 14),
            (7, 2, 2),
            (9, 10, 5),
            (20, 2, 6),
            (102, 6, 10),
            (103, 7, 15),
            (105, 10, 10),
            (106, 11, 15),
            (110, 12, 7),
            (111, 12, 12),
            (352, 6, 6),
            (353, 6, 6),
            (354, 10, 10),
            (999, 0, 0),
        ];
        let found = Telegram::ALL.iter().map(|telegram| {
            let (outputs, inputs) = telegram.lengths();
            (telegram.number, outputs / 2, inputs / 2)
        });
        assert_eq!(found.collect::<Vec<_>>(), words);
    }

    #[test]
    fn a_configuration_names_its_telegram_or_has_its_lengths() {
        let of = |configuration: &[u8]| {
            Telegram::of_configuration(configuration, None).map(|telegram| telegram.number)
        };
        assert_eq!(of(&[0xC3, 0xC1, 0xC1, 0xFD, 0x00, 0x01]), Some(1));
        assert_eq!(of(&[0xC3, 0xC5, 0xC5, 0xFD, 0x01, 0x60]), Some(352));
        assert_eq!(of(&[0xF1]), Some(1));
        assert_eq!(of(&[0xF3, 0xC3, 0xC1, 0xC1, 0xFD, 0x01, 0x61]), Some(353));
        // PKW in front, and six words in one.
        assert_eq!((of(&[0xF3, 0xF1]), of(&[0xF5])), (Some(353), Some(352)));
        assert_eq!(of(&[0xC3, 0xC5, 0xC5, 0xFD, 0x01, 0x61]), None);
        // Another number than the lengths say.
        assert_eq!(of(&[0xC3, 0xC1, 0xC1, 0xFD, 0x00, 0x14]), None);
        assert_eq!(of(&[0xF0]), None);
        // The words of 999 are free, up to 16 of them.
        let free = |outputs, inputs| [0xC3, outputs, inputs, 0xFD, 0x03, 0xE7];
        assert_eq!((of(&free(0xC3, 0xC3)), of(&free(0xC0, 0xCF))), (Some(999), Some(999)));
        assert_eq!((of(&free(0xD0, 0xC3)), of(&free(0x82, 0xC3))), (None, None));
        assert_eq!(Telegram::of_configuration(&[0xF1], Telegram::numbered(999)), None);
        assert_eq!(Telegram::of_configuration(&[0xF1], Telegram::numbered(20)), None);
    }

    #[test]
    fn signals_are_where_the_words_before_them_end() {
        let telegram = Telegram::numbered(102).unwrap();
        let outputs = [0x04, 0x7F, 0x40, 0, 0, 1, 0xA0, 0, 0x12, 0x34, 0x20, 0];
        assert_eq!(telegram.setpoint(&outputs, Signal::NsollB), Some(0x4000_0001));
        assert_eq!(telegram.setpoint(&outputs, Signal::Momred), Some(0x1234));
        assert_eq!(telegram.setpoint(&outputs, Signal::NsollA), None);
        assert_eq!(telegram.setpoint(&outputs[..9], Signal::Momred), None);
        let inputs =
            Telegram::numbered(2).unwrap().inputs(Pkw::ZERO, |signal| u32::from(signal.number()) << 8 | 1);
        assert_eq!(inputs, [2, 1, 0, 0, 8, 1, 4, 1]);
    }
}
