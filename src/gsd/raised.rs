//! A diagnosis that is raised on purpose, as blocks of Slave_Diag (`gsd.md` 5).
//!
//! ```text
//! device      header, bits of Unit_Diag_Bit and Unit_Diag_Area from the lowest on; with DPV1 the first three octets
//!             are type A1h, slot 0 and specifier 0 where no text lies in them
//! identifier  header, one bit for each identifier of the configuration
//! status      header, 82h, slot 0, specifier 0, two bits for each slot
//! other       header, type, slot 0, specifier 0, bits of X_Unit_Diag_Bit and X_Unit_Diag_Area from bit 24 on
//! channel     three octets each
//! ```

use std::collections::{BTreeMap, BTreeSet};

use thiserror::Error;

use super::diagnosis::MODULE_STATUS;
use super::{DiagArea, DiagBit, Gsd, Placed};
use crate::profibus::dp::ExtDiag;
use crate::profibus::dp::ext_diag::{Block, BlockError, Channel, ChannelError, Direction, Width};

/// Octets of one block behind its header.
const MAX_BLOCK: usize = 62;
/// The octets of Slave_Diag before the blocks.
const FIXED_LEN: usize = 6;
/// Type, slot and specifier.
const TYPED_LEN: usize = 3;
/// The type of the first block of a status of the manufacturer.
const MANUFACTURER_STATUS: u8 = 0xA1;

/// What a station shall report besides what its slave reports by itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Raised {
    /// Unit_Diag_Bit: the bits whose text applies. An inverted one (`Unit_Diag_!Bit`) is 0 then, else 1.
    pub bits: BTreeSet<u16>,
    /// Unit_Diag_Area: by its first bit, the value.
    pub areas: BTreeMap<u16, u32>,
    /// Status blocks of a UnitDiagType, by its number.
    pub statuses: BTreeMap<u8, Status>,
    /// Slots of the identifier-related diagnosis.
    pub identifiers: BTreeSet<u16>,
    /// Slots of the module status.
    pub modules: BTreeMap<u16, ModuleState>,
    /// Channel-related diagnosis.
    pub channels: Vec<ChannelFault>,
    /// Blocks as they are on the wire, behind the others.
    pub octets: Vec<u8>,
    /// Stat_Diag: the inputs are not valid.
    pub not_valid: bool,
}

/// What a status block of a UnitDiagType reports. Bits count from the octet behind the header, so that the first are those
/// of type, slot and specifier.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// X_Unit_Diag_Bit: the bits whose text applies. An inverted one is 0 then, else 1.
    pub bits: BTreeSet<u16>,
    /// X_Unit_Diag_Area: by its first bit, the value.
    pub areas: BTreeMap<u16, u32>,
}

/// The module status of a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "panel", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
#[repr(u8)]
pub enum ModuleState {
    /// The module works.
    Valid = 0,
    /// The module has a fault: its data are not valid.
    Invalid = 1,
    /// Another module is plugged than was configured.
    Wrong = 2,
    /// No module is plugged.
    Missing = 3,
}

impl ModuleState {
    /// Its words.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::Valid => "data valid",
            Self::Invalid => "data invalid",
            Self::Wrong => "wrong module",
            Self::Missing => "no module",
        }
    }
}

/// A fault of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelFault {
    /// The number of the slot.
    pub slot: u16,
    /// The channel of the module, 0..=63.
    pub channel: u8,
    /// Whether it is an input or an output.
    pub direction: Direction,
    /// How wide it is.
    pub width: Width,
    /// What is wrong.
    pub error: ChannelError,
}

/// Why a diagnosis cannot be raised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum RaiseError {
    /// The configuration has no such slot.
    #[error("there is no slot {got}; the configuration has {first} to {last}")]
    Slot {
        /// The number.
        got: u16,
        /// The first one there is.
        first: u16,
        /// The last one there is.
        last: u16,
    },
    /// A bit that lies behind the longest block.
    #[error("bit {got} lies behind the longest block; expected 0 to {most}")]
    Bit {
        /// The bit.
        got: u16,
        /// The last one.
        most: u16,
    },
    /// A bit of the first octets of a status block: type, slot, specifier.
    #[error("bit {got} is one of type, slot and specifier of the block; expected {least} or more")]
    Head {
        /// The bit.
        got: u16,
        /// The first that can be raised.
        least: u16,
    },
    /// An area that the file does not have, or a value that does not fit.
    #[error("the file has no area of bits from bit {first} on that holds {value}")]
    Area {
        /// Its first bit.
        first: u16,
        /// The value.
        value: u32,
    },
    /// A type of status that the file does not have.
    #[error("the file has no UnitDiagType {got}")]
    Status {
        /// The type.
        got: u8,
    },
    /// More octets than Slave_Diag of the station has room for.
    #[error("{got} octets of diagnosis, Max_Diag_Data_Len leaves {most} behind the first six")]
    TooLong {
        /// Octets.
        got: usize,
        /// The most.
        most: usize,
    },
    /// A block that cannot be written.
    #[error("{0}")]
    Block(#[from] BlockError),
}

impl Raised {
    /// Whether nothing is raised.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Its blocks for the modules of a configuration, in the customary order.
    ///
    /// # Errors
    /// [`RaiseError`] for what the configuration or the file does not have.
    pub(crate) fn blocks(&self, gsd: &Gsd, layout: &[Placed]) -> Result<ExtDiag, RaiseError> {
        if self.is_empty() {
            return Ok(ExtDiag::NONE);
        }
        let mut diagnosis = ExtDiag::fault();
        if self.not_valid {
            diagnosis = diagnosis.with_stat_diag();
        }
        if !(self.bits.is_empty() && self.areas.is_empty()) {
            diagnosis.push(Block::Device(&self.device(gsd)?))?;
        }
        for (number, status) in &self.statuses {
            let (prefix, texts) = ([*number, 0, 0], Texts::of_type(gsd, *number)?);
            diagnosis.push(Block::Device(&texts.octets(&prefix, &status.bits, &status.areas)?))?;
        }
        if !self.identifiers.is_empty() {
            let most = layout.iter().map(|placed| placed.identifiers.end).max().unwrap_or(0);
            let mut octets = vec![0; most.div_ceil(8).clamp(1, MAX_BLOCK)];
            for slot in &self.identifiers {
                for bit in placed(layout, *slot)?.identifiers.clone() {
                    set(&mut octets, bit);
                }
            }
            diagnosis.push(Block::Modules(&octets))?;
        }
        if !self.modules.is_empty() {
            diagnosis.push(Block::Device(&self.status(layout)?))?;
        }
        for fault in &self.channels {
            let module = placed(layout, fault.slot)?.identifiers.start;
            let ChannelFault { direction, channel, width, error, .. } = *fault;
            let module = u8::try_from(module).unwrap_or(u8::MAX);
            diagnosis.push(Block::Channel(Channel { module, direction, channel, width, error }))?;
        }
        let most = usize::from(gsd.max_diag_len).saturating_sub(FIXED_LEN);
        if self.octets.len() > most {
            return Err(RaiseError::TooLong { got: self.octets.len(), most });
        }
        diagnosis.push_octets(&self.octets)?;
        Ok(diagnosis)
    }

    /// Reports what another one does, too; of two that exclude each other the other one.
    pub(crate) fn join(&mut self, other: &Self) {
        let Self { bits, areas, statuses, identifiers, modules, channels, octets, not_valid } = other;
        self.bits.extend(bits);
        self.areas.extend(areas);
        self.statuses.extend(statuses.iter().map(|(number, status)| (*number, status.clone())));
        self.identifiers.extend(identifiers);
        self.modules.extend(modules);
        self.channels.extend(channels);
        self.octets.extend(octets);
        self.not_valid |= not_valid;
    }

    /// The same without slots that the configuration does not have.
    pub(crate) fn within(mut self, layout: &[Placed]) -> Self {
        let is_there = |slot: u16| placed(layout, slot).is_ok();
        self.identifiers.retain(|slot| is_there(*slot));
        self.modules.retain(|slot, _| is_there(*slot));
        self.channels.retain(|fault| is_there(fault.slot));
        self
    }

    /// What is raised, in the texts of the file where it has some.
    pub(crate) fn words(&self, gsd: &Gsd, layout: &[Placed]) -> Vec<String> {
        let mut words = Vec::new();
        Texts::of_device(gsd).words(&self.bits, &self.areas, &mut words);
        for (number, status) in &self.statuses {
            if let Ok(texts) = Texts::of_type(gsd, *number) {
                texts.words(&status.bits, &status.areas, &mut words);
            }
        }
        let named = |slot: &u16| {
            let name = placed(layout, *slot).map_or_else(|_| String::new(), |placed| placed.name(gsd));
            format!("slot {slot} '{name}'")
        };
        words.extend(self.identifiers.iter().map(|slot| format!("{}: has a diagnosis", named(slot))));
        words.extend(self.modules.iter().map(|(slot, state)| format!("{}: {}", named(slot), state.words())));
        for fault in &self.channels {
            let number = fault.error.number();
            let own = gsd.channel_diag.iter().find(|known| known.0 == number).map(|known| known.1.as_str());
            let text = own.or(fault.error.words()).unwrap_or("error of the manufacturer");
            words.push(format!("{}, channel {}: {text} ({number})", named(&fault.slot), fault.channel));
        }
        if !self.octets.is_empty() {
            words.push(format!("octets {}", super::split::hex(&self.octets)));
        }
        if self.not_valid {
            words.push("the inputs are not valid".into());
        }
        words
    }

    /// The device-related block without its header.
    fn device(&self, gsd: &Gsd) -> Result<Vec<u8>, RaiseError> {
        let typed = gsd.flags.dpv1 && gsd.diag_bits.iter().all(|bit| usize::from(bit.bit) >= TYPED_LEN * 8);
        let prefix: &[u8] = if typed { &[MANUFACTURER_STATUS, 0, 0] } else { &[0] };
        Texts::of_device(gsd).octets(prefix, &self.bits, &self.areas)
    }

    /// The module status without its header.
    fn status(&self, layout: &[Placed]) -> Result<Vec<u8>, RaiseError> {
        let mut octets = vec![MODULE_STATUS, 0, 0];
        octets.resize(TYPED_LEN + layout.len().div_ceil(4).clamp(1, MAX_BLOCK - TYPED_LEN), 0);
        for (slot, state) in &self.modules {
            let wanted = placed(layout, *slot)?.slot.number;
            let place = layout.iter().position(|placed| placed.slot.number == wanted).unwrap_or_default();
            for bit in (0..2).filter(|bit| *state as u8 >> bit & 1 == 1) {
                set(&mut octets, TYPED_LEN * 8 + place * 2 + bit);
            }
        }
        Ok(octets)
    }
}

/// The texts that a file has for the bits of one block.
struct Texts<'a> {
    bits: &'a [DiagBit],
    areas: &'a [DiagArea],
}

impl<'a> Texts<'a> {
    fn of_device(gsd: &'a Gsd) -> Self {
        Self { bits: &gsd.diag_bits, areas: &gsd.diag_areas }
    }

    fn of_type(gsd: &'a Gsd, number: u8) -> Result<Self, RaiseError> {
        let known = gsd.diag_types.iter().find(|known| known.number == number);
        let known = known.ok_or(RaiseError::Status { got: number })?;
        Ok(Self { bits: &known.bits, areas: &known.areas })
    }

    fn area(&self, first: u16) -> Option<&'a DiagArea> {
        self.areas.iter().find(|area| area.first == first)
    }

    fn words(&self, bits: &BTreeSet<u16>, areas: &BTreeMap<u16, u32>, words: &mut Vec<String>) {
        for bit in bits {
            let text = self.bits.iter().find(|known| known.bit == *bit).map(|known| known.text.as_str());
            words.push(text.map_or_else(|| format!("bit {bit}"), Into::into));
        }
        for (first, value) in areas {
            let text = self
                .area(*first)
                .and_then(|area| area.values.iter().find(|text| text.0 == i64::from(*value)));
            words.push(text.map_or_else(|| format!("value {value} from bit {first}"), |text| text.1.clone()));
        }
    }

    /// A block without its header: it begins with `prefix`, and is as long as what is raised.
    fn octets(
        &self,
        prefix: &[u8],
        bits: &BTreeSet<u16>,
        areas: &BTreeMap<u16, u32>,
    ) -> Result<Vec<u8>, RaiseError> {
        let mut octets = prefix.to_vec();
        octets.resize(MAX_BLOCK, 0);
        let mut used = prefix.len();
        let least = if used == TYPED_LEN { 24 } else { 0 };
        if let Some(got) = bits.iter().chain(areas.keys()).copied().find(|first| *first < least) {
            return Err(RaiseError::Head { got, least });
        }
        for bit in self.bits.iter().filter(|bit| bit.inverted && !bits.contains(&bit.bit)) {
            set(&mut octets, bit.bit.into());
            used = used.max(usize::from(bit.bit) / 8 + 1);
        }
        for got in bits {
            if usize::from(*got) >= MAX_BLOCK * 8 {
                let most = u16::try_from(MAX_BLOCK * 8 - 1).unwrap_or(u16::MAX);
                return Err(RaiseError::Bit { got: *got, most });
            }
            if !self.bits.iter().any(|bit| bit.bit == *got && bit.inverted) {
                set(&mut octets, (*got).into());
            }
            used = used.max(usize::from(*got) / 8 + 1);
        }
        for (first, value) in areas {
            let wrong = RaiseError::Area { first: *first, value: *value };
            let area = self.area(*first).ok_or(wrong)?;
            let width = u32::from(area.last - area.first) + 1;
            if u64::from(*value) >> width.min(32) != 0 || usize::from(area.last) >= MAX_BLOCK * 8 {
                return Err(wrong);
            }
            for bit in (0..width.min(32)).filter(|bit| value >> bit & 1 == 1) {
                set(&mut octets, usize::from(*first) + usize::try_from(bit).unwrap_or_default());
            }
            used = used.max(usize::from(area.last) / 8 + 1);
        }
        octets.truncate(used.min(MAX_BLOCK));
        Ok(octets)
    }
}

fn placed(layout: &[Placed], slot: u16) -> Result<&Placed, RaiseError> {
    layout.iter().find(|placed| placed.slot.number == slot).ok_or_else(|| {
        let number = |placed: Option<&Placed>| placed.map_or(0, |placed| placed.slot.number);
        RaiseError::Slot { got: slot, first: number(layout.first()), last: number(layout.last()) }
    })
}

/// Sets a bit, counted from the lowest of the first octet. One behind the end is left out.
fn set(octets: &mut [u8], bit: usize) {
    if let Some(octet) = octets.get_mut(bit / 8) {
        *octet |= 1 << (bit % 8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gsd::{Policy, Station};

    const MODULAR: &str = "#Profibus_DP\nIdent_Number=1\nModular_Station=1\nMax_Module=9\nModul_Offset=1\n\
        Unit_Diag_Bit(0)=\"short\"\nUnit_Diag_Bit(9)=\"supply\"\nUnit_Diag_!Bit(1)=\"fan stands\"\n\
        Unit_Diag_Area=4-6\nValue(5)=\"hot\"\nUnit_Diag_Area_End\nChannel_Diag(16)=\"broken\"\n\
        Module=\"a\" 0x10,0x20\nEndModule\nModule=\"b\" 0x11\nEndModule\n";

    fn station(file: &str) -> Station {
        Station::new(Gsd::read(file.as_bytes()).unwrap(), Policy::PROPOSED).unwrap()
    }

    fn octets(raised: &Raised) -> Result<Vec<u8>, RaiseError> {
        let station = station(MODULAR);
        let layout = station.layout(&[0x11, 0x10, 0x20, 0x11, 0x00, 0x11], None);
        raised.blocks(station.gsd(), &layout).map(|diagnosis| diagnosis.octets().to_vec())
    }

    #[test]
    fn golden_blocks_of_each_kind() {
        let channel = ChannelFault {
            slot: 2,
            channel: 3,
            direction: Direction::Input,
            width: Width::Word,
            error: ChannelError::numbered(16).unwrap(),
        };
        for (raised, expected) in [
            (Raised::default(), &[][..]),
            (Raised { bits: [0].into(), ..Raised::default() }, &[0x02, 0x03]),
            (Raised { bits: [1, 9].into(), ..Raised::default() }, &[0x03, 0x00, 0x02]),
            (Raised { areas: [(4, 5)].into(), ..Raised::default() }, &[0x02, 0x52]),
            // Slot 2 has two identifiers, the second and the third.
            (Raised { identifiers: [2, 5].into(), ..Raised::default() }, &[0x42, 0x26]),
            (
                Raised {
                    modules: [(1, ModuleState::Missing), (5, ModuleState::Invalid)].into(),
                    ..Raised::default()
                },
                &[0x06, 0x82, 0x00, 0x00, 0x03, 0x01],
            ),
            (Raised { channels: vec![channel], ..Raised::default() }, &[0x81, 0x43, 0xB0]),
            (Raised { not_valid: true, ..Raised::default() }, &[]),
        ] {
            assert_eq!(octets(&raised).unwrap(), expected, "{raised:?}");
        }
        let all = Raised {
            bits: [0].into(),
            identifiers: [1].into(),
            modules: [(1, ModuleState::Wrong)].into(),
            channels: vec![channel],
            areas: [(4, 5)].into(),
            statuses: [].into(),
            octets: Vec::new(),
            not_valid: true,
        };
        let station = station(MODULAR);
        let layout = station.layout(&[0x11, 0x10, 0x20], None);
        assert_eq!(
            all.words(station.gsd(), &layout),
            [
                "short",
                "hot",
                "slot 1 'b': has a diagnosis",
                "slot 1 'b': wrong module",
                "slot 2 'a', channel 3: broken (16)",
                "the inputs are not valid",
            ]
        );
        let diagnosis = all.blocks(station.gsd(), &layout).unwrap();
        assert!(diagnosis.ext_diag() && diagnosis.stat_diag() && !diagnosis.overflow());
    }

    #[test]
    fn with_dpv1_the_bits_lie_behind_type_slot_and_specifier() {
        let station = station(
            "#Profibus_DP\nIdent_Number=1\nDPV1_Slave=1\nUnit_Diag_Bit(24)=\"x\"\nModule=\"a\" 0x10\nEndModule\n",
        );
        let raised = Raised { bits: [24].into(), ..Raised::default() };
        let diagnosis = raised.blocks(station.gsd(), &station.layout(&[0x10], None)).unwrap();
        assert_eq!(diagnosis.octets(), [0x05, 0xA1, 0, 0, 0x01]);
        let head = Raised { bits: [23].into(), ..Raised::default() };
        let refused = head.blocks(station.gsd(), &station.layout(&[0x10], None));
        assert_eq!(refused, Err(RaiseError::Head { got: 23, least: 24 }));
    }

    #[test]
    fn a_status_block_has_the_texts_of_its_unit_diag_type() {
        let station = station(
            "#Profibus_DP\nIdent_Number=1\nUnitDiagType=161\nX_Unit_Diag_Bit(24)=\"door\"\nX_Unit_Diag_Area=28-31\n\
             X_Value(0)=\"cold\"\nX_Value(3)=\"hot\"\nX_Unit_Diag_Area_End\nEndUnitDiagType\n\
             Module=\"a\" 0x10\nEndModule\n",
        );
        let (gsd, layout) = (station.gsd(), station.layout(&[0x10], None));
        let status = Status { bits: [24].into(), areas: [(28, 3)].into() };
        let raised = Raised { statuses: [(161, status.clone())].into(), ..Raised::default() };
        assert_eq!(raised.blocks(gsd, &layout).unwrap().octets(), [0x05, 0xA1, 0, 0, 0x31]);
        assert_eq!(raised.words(gsd, &layout), ["door", "hot"]);
        for got in [0, 23] {
            let head = Status { bits: [got].into(), ..Status::default() };
            let head = Raised { statuses: [(161, head)].into(), ..Raised::default() };
            assert_eq!(head.blocks(gsd, &layout), Err(RaiseError::Head { got, least: 24 }));
        }
        let unknown = Raised { statuses: [(162, status)].into(), ..Raised::default() };
        assert_eq!(unknown.blocks(gsd, &layout), Err(RaiseError::Status { got: 162 }));
    }

    #[test]
    fn octets_stand_behind_the_other_blocks_within_the_length_of_the_file() {
        let file = MODULAR.replace("Modul_Offset=1", "Modul_Offset=1\nMax_Diag_Data_Len=12");
        let station = station(&file);
        let layout = station.layout(&[0x11], None);
        let raised =
            |octets: &[u8]| Raised { bits: [0].into(), octets: octets.to_vec(), ..Raised::default() };
        let blocks = |raised: &Raised| raised.blocks(station.gsd(), &layout).map(|all| all.octets().to_vec());
        assert_eq!(blocks(&raised(&[0x42, 0x01])).unwrap(), [0x02, 0x03, 0x42, 0x01]);
        assert_eq!(blocks(&raised(&[0xC0; 7])), Err(RaiseError::TooLong { got: 7, most: 6 }));
        assert_eq!(
            blocks(&raised(&[0x43, 0x01])),
            Err(RaiseError::Block(BlockError::Cut { at: 0, header: 0x43 }))
        );
        assert_eq!(raised(&[0x42, 0x01]).words(station.gsd(), &layout), ["short", "octets 42 01"]);
    }

    #[test]
    fn what_is_not_there_cannot_be_raised() {
        let slot = RaiseError::Slot { got: 6, first: 1, last: 5 };
        for (raised, error) in [
            (Raised { identifiers: [6].into(), ..Raised::default() }, slot),
            (Raised { modules: [(6, ModuleState::Valid)].into(), ..Raised::default() }, slot),
            (Raised { bits: [496].into(), ..Raised::default() }, RaiseError::Bit { got: 496, most: 495 }),
            (Raised { areas: [(4, 8)].into(), ..Raised::default() }, RaiseError::Area { first: 4, value: 8 }),
            (Raised { areas: [(5, 1)].into(), ..Raised::default() }, RaiseError::Area { first: 5, value: 1 }),
        ] {
            assert_eq!(octets(&raised), Err(error));
        }
    }
}
