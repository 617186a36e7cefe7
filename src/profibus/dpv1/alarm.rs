//! Alarms and status messages: the blocks of Slave_Diag that tell of them, and what acknowledges an alarm.
//!
//! ```text
//! alarm    00llllll  0ttttttt  slot  sssssaSS  data..    sssss number, a acknowledgement of the user, SS specifier
//! status   00llllll  1ttttttt  slot  000000SS  data..
//! ```
//!
//! Source: `dp-v1.md` 6.1.

use core::fmt;

use crate::profibus::dp::dpv1_status::Status2;
use crate::profibus::dp::ext_diag::FORMAT;

/// What kind of alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum AlarmType {
    /// A fault of the module, or its end.
    Diagnostic,
    /// Something happened in the process.
    Process,
    /// A module was pulled.
    Pull,
    /// A module was plugged.
    Plug,
    /// The state of the module changed.
    Status,
    /// A parameter of the module changed.
    Update,
    /// Of the manufacturer, 32..=126.
    Manufacturer(u8),
    /// A number that the standard reserves.
    Reserved(u8),
}

impl AlarmType {
    /// The type of a number, bit 7 left out.
    pub const fn numbered(number: u8) -> Self {
        match number & 0x7F {
            1 => Self::Diagnostic,
            2 => Self::Process,
            3 => Self::Pull,
            4 => Self::Plug,
            5 => Self::Status,
            6 => Self::Update,
            number @ 32..=126 => Self::Manufacturer(number),
            number => Self::Reserved(number),
        }
    }

    /// Its number, 0..=127.
    pub const fn number(self) -> u8 {
        match self {
            Self::Diagnostic => 1,
            Self::Process => 2,
            Self::Pull => 3,
            Self::Plug => 4,
            Self::Status => 5,
            Self::Update => 6,
            Self::Manufacturer(number) | Self::Reserved(number) => number & 0x7F,
        }
    }

    /// The types that the standard names, each with its word for programs.
    pub const NAMED: [(&'static str, Self); 6] = [
        ("diagnostic", Self::Diagnostic),
        ("process", Self::Process),
        ("pull", Self::Pull),
        ("plug", Self::Plug),
        ("status", Self::Status),
        ("update", Self::Update),
    ];

    /// The type of a word, or of a number: 1 to 6, or 32 to 126 of the manufacturer.
    pub fn named(word: &str) -> Option<Self> {
        let named = Self::NAMED.iter().find(|(name, _)| *name == word).map(|(_, kind)| *kind);
        let numbered = || word.parse().ok().filter(|number| *number < 127).map(Self::numbered);
        named.or_else(numbered).filter(|kind| kind.enabled_by().is_some())
    }

    /// Its word for programs; `None`: it is one of the manufacturer, or reserved.
    pub fn name(self) -> Option<&'static str> {
        Self::NAMED.iter().find(|(_, kind)| *kind == self).map(|(name, _)| *name)
    }

    /// The bit of DPV1_Status_2 that enables it; `None`: it never comes.
    pub(crate) const fn enabled_by(self) -> Option<Status2> {
        Some(match self {
            Self::Diagnostic => Status2::Diagnostic,
            Self::Process => Status2::Process,
            Self::Pull | Self::Plug => Status2::PullPlug,
            Self::Status => Status2::Status,
            Self::Update => Status2::Update,
            Self::Manufacturer(_) => Status2::Manufacturer,
            Self::Reserved(_) => return None,
        })
    }
}

impl fmt::Display for AlarmType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Diagnostic => f.write_str("diagnostic alarm"),
            Self::Process => f.write_str("process alarm"),
            Self::Pull => f.write_str("pull alarm"),
            Self::Plug => f.write_str("plug alarm"),
            Self::Status => f.write_str("status alarm"),
            Self::Update => f.write_str("update alarm"),
            Self::Manufacturer(number) => write!(f, "alarm {number} of the manufacturer"),
            Self::Reserved(number) => write!(f, "alarm of the reserved type {number}"),
        }
    }
}

/// Whether what is reported begins or ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Specifier {
    /// Neither.
    #[default]
    None = 0,
    /// It appears: the slot is disturbed.
    Appears = 1,
    /// It disappears: the slot is in order.
    Disappears = 2,
    /// It disappears, and the slot is disturbed still.
    StillDisturbed = 3,
}

impl Specifier {
    const fn of(octet: u8) -> Self {
        match octet & 3 {
            1 => Self::Appears,
            2 => Self::Disappears,
            3 => Self::StillDisturbed,
            _ => Self::None,
        }
    }

    /// Each with its word for programs.
    pub const NAMED: [(&'static str, Self); 4] = [
        ("none", Self::None),
        ("appears", Self::Appears),
        ("disappears", Self::Disappears),
        ("still", Self::StillDisturbed),
    ];

    /// The specifier of a word.
    pub fn named(word: &str) -> Option<Self> {
        Self::NAMED.iter().find(|(name, _)| *name == word).map(|(_, specifier)| *specifier)
    }

    /// Its word for programs.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Appears => "appears",
            Self::Disappears => "disappears",
            Self::StillDisturbed => "still",
        }
    }

    /// In a few words; empty if it says nothing.
    pub const fn words(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Appears => "appears",
            Self::Disappears => "disappears",
            Self::StillDisturbed => "disappears, the slot is disturbed still",
        }
    }

    /// Whether the slot is disturbed: Ext_Diag is set then.
    pub const fn disturbs(self) -> bool {
        matches!(self, Self::Appears | Self::StillDisturbed)
    }
}

/// What names an alarm, in its block and in its acknowledgement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AlarmHead {
    /// What kind.
    pub kind: AlarmType,
    /// Of which slot, 0..=254.
    pub slot: u8,
    /// Seq_Nr, 0..=31.
    pub sequence: u8,
    /// Add_Ack: the user of the master shall acknowledge it, too.
    pub additional_ack: bool,
    /// Whether it begins or ends.
    pub specifier: Specifier,
}

impl AlarmHead {
    pub(super) const fn of(kind: u8, slot: u8, specifier: u8) -> Self {
        Self {
            kind: AlarmType::numbered(kind),
            slot,
            sequence: specifier >> 3,
            additional_ack: specifier & 4 != 0,
            specifier: Specifier::of(specifier),
        }
    }

    const fn specifier_octet(self) -> u8 {
        self.sequence << 3 | (self.additional_ack as u8) << 2 | self.specifier as u8
    }

    /// Type, slot and specifier, as the block has them.
    pub(super) const fn reported(self) -> [u8; 3] {
        [self.kind.number(), self.slot, self.specifier_octet()]
    }

    /// Slot, type and specifier, as Alarm_Ack has them.
    pub(super) const fn acknowledged(self) -> [u8; 3] {
        [self.slot, self.kind.number(), self.specifier_octet()]
    }

    /// Whether an acknowledgement of `self` means `other`: Add_Ack and the specifier are not compared.
    pub(crate) fn means(self, other: Self) -> bool {
        (self.kind, self.slot, self.sequence) == (other.kind, other.slot, other.sequence)
    }
}

impl fmt::Display for AlarmHead {
    /// `process alarm of slot 1 appears, number 3`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of slot {}", self.kind, self.slot)?;
        if self.specifier != Specifier::None {
            write!(f, " {}", self.specifier.words())?;
        }
        write!(f, ", number {}", self.sequence)?;
        if self.additional_ack { f.write_str(", to be acknowledged by the user") } else { Ok(()) }
    }
}

/// What kind of status message, the type without its bit 7.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum StatusType {
    /// A message.
    Message,
    /// The state of each module.
    Modules,
    /// A link of DXB.
    DxbLink,
    /// The answer to PrmCmd.
    PrmCmdAck,
    /// The state of a redundant slave.
    RedState,
    /// Of the manufacturer, 32..=126.
    Manufacturer(u8),
    /// A number that the standard reserves.
    Reserved(u8),
}

impl StatusType {
    /// Set in the type octet of a status message.
    pub const MARK: u8 = 0x80;

    /// The type of a number, bit 7 left out.
    pub const fn numbered(number: u8) -> Self {
        match number & !Self::MARK {
            1 => Self::Message,
            2 => Self::Modules,
            3 => Self::DxbLink,
            30 => Self::PrmCmdAck,
            31 => Self::RedState,
            number @ 32..=126 => Self::Manufacturer(number),
            number => Self::Reserved(number),
        }
    }

    /// Its number, 0..=127.
    pub const fn number(self) -> u8 {
        match self {
            Self::Message => 1,
            Self::Modules => 2,
            Self::DxbLink => 3,
            Self::PrmCmdAck => 30,
            Self::RedState => 31,
            Self::Manufacturer(number) | Self::Reserved(number) => number & !Self::MARK,
        }
    }
}

impl fmt::Display for StatusType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Message => f.write_str("status message"),
            Self::Modules => f.write_str("module status"),
            Self::DxbLink => f.write_str("status of DXB links"),
            Self::PrmCmdAck => f.write_str("answer to PrmCmd"),
            Self::RedState => f.write_str("state of redundancy"),
            Self::Manufacturer(number) => write!(f, "status {number} of the manufacturer"),
            Self::Reserved(number) => write!(f, "status of the reserved type {number}"),
        }
    }
}

/// A device-related block of Slave_Diag, as a slave of DP-V1 means it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TypedBlock<'a> {
    /// An alarm.
    Alarm {
        /// Which.
        head: AlarmHead,
        /// What the manufacturer says about it, up to 59 octets.
        data: &'a [u8],
    },
    /// A status message, which nobody acknowledges.
    Status {
        /// What kind.
        kind: StatusType,
        /// Of which slot.
        slot: u8,
        /// Whether it begins or ends.
        specifier: Specifier,
        /// What it says, up to 59 octets.
        data: &'a [u8],
    },
}

/// The most octets of data in a block.
pub(super) const MAX_BLOCK_DATA: usize = 59;

impl<'a> TypedBlock<'a> {
    /// Reads a block of Slave_Diag with its header. `None` if it is not device-related, or as [`TypedBlock::parse`].
    pub(crate) fn of_block(block: &'a [u8]) -> Option<Self> {
        let (header, octets) = block.split_first()?;
        if header & FORMAT == 0 { Self::parse(octets) } else { None }
    }

    /// Reads a block behind its header: type, slot, specifier, data. `None` if it has less than three octets or more than
    /// fit.
    pub fn parse(octets: &'a [u8]) -> Option<Self> {
        let [kind, slot, specifier, ref data @ ..] = *octets else { return None };
        if data.len() > MAX_BLOCK_DATA {
            return None;
        }
        Some(if kind & StatusType::MARK == 0 {
            Self::Alarm { head: AlarmHead::of(kind, slot, specifier), data }
        } else {
            let kind = StatusType::numbered(kind);
            Self::Status { kind, slot, specifier: Specifier::of(specifier), data }
        })
    }

    /// Writes the octets behind the header; `None` if there are too many.
    pub fn encode<'b>(&self, buf: &'b mut [u8]) -> Option<&'b [u8]> {
        let (head, data) = match self {
            Self::Alarm { head, data } => (head.reported(), data),
            Self::Status { kind, slot, specifier, data } => {
                ([kind.number() | StatusType::MARK, *slot, *specifier as u8], data)
            }
        };
        if data.len() > MAX_BLOCK_DATA {
            return None;
        }
        super::pdu::put(buf, &[&head, data])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_block_and_the_acknowledgement_of_an_alarm_are_those_of_the_reference() {
        let block = TypedBlock::parse(&[0x02, 0x01, 0x01, 0x50]).unwrap();
        let TypedBlock::Alarm { head, data } = block else { panic!("{block:?}") };
        assert_eq!((head.kind, head.slot, head.specifier), (AlarmType::Process, 1, Specifier::Appears));
        assert_eq!((head.acknowledged(), data), ([0x01, 0x02, 0x01], &[0x50][..]));
        assert_eq!(head.to_string(), "process alarm of slot 1 appears, number 0");
        let other = AlarmHead::of(0x20, 3, 0b1011_1110);
        assert_eq!(
            (other.kind, other.sequence, other.additional_ack),
            (AlarmType::Manufacturer(32), 23, true)
        );
        assert!(!other.means(head) && head.means(AlarmHead { additional_ack: true, ..head }));
        let status = TypedBlock::parse(&[0x82, 0, 0, 0x30]).unwrap();
        assert!(matches!(status, TypedBlock::Status { kind: StatusType::Modules, slot: 0, .. }));
    }

    #[test]
    fn types_and_specifiers_have_words_for_programs() {
        for (word, kind) in AlarmType::NAMED {
            let number = std::format!("{}", kind.number());
            assert_eq!((AlarmType::named(word), AlarmType::named(&number)), (Some(kind), Some(kind)));
            assert_eq!(kind.name(), Some(word));
        }
        assert_eq!(AlarmType::named("32"), Some(AlarmType::Manufacturer(32)));
        for wrong in ["0", "7", "31", "127", "130", "-1", "", "Process"] {
            assert_eq!(AlarmType::named(wrong), None, "{wrong}");
        }
        for (word, specifier) in Specifier::NAMED {
            assert_eq!((Specifier::named(word), specifier.name()), (Some(specifier), word));
        }
    }

    proptest! {
        #[test]
        fn a_block_of_whatever_octets_is_read_and_written_back(octets in proptest::collection::vec(any::<u8>(), 0..70)) {
            let parsed = TypedBlock::parse(&octets);
            prop_assert_eq!(parsed.is_some(), (3..=62).contains(&octets.len()));
            if let Some(block) = parsed {
                let mut buf = [0; 62];
                let again = block.encode(&mut buf).unwrap();
                prop_assert_eq!(TypedBlock::parse(again), Some(block));
                if octets[0] & 0x80 == 0 {
                    prop_assert_eq!(again, &octets[..]);
                }
            }
        }
    }
}
