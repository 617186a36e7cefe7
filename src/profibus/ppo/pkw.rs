//! The parameter channel: four words of identification, index and value.

use core::fmt;

/// The parameter channel PKW, words 1 to 4 of the PPO: a job of the master or a reply of the slave.
///
/// Every combination of bits is a `Pkw` and comes out of it as it went in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Pkw {
    /// Word 1: job or reply, and the parameter's number.
    pub pke: Pke,
    /// Word 2: the element of an array.
    pub ind: Ind,
    /// Word 3: the high word of a double word.
    pub pwe_high: u16,
    /// Word 4: a word, the low word of a double word, or an error number.
    pub pwe_low: u16,
}

impl Pkw {
    /// "No job" and "no reply": four zero words.
    pub const ZERO: Self = Self::new(Pke(0), Ind(0), 0);

    /// A PKW of these parts; a word sits in the low half of `pwe`.
    pub const fn new(pke: Pke, ind: Ind, pwe: u32) -> Self {
        let [a, b, c, d] = pwe.to_be_bytes();
        Self { pke, ind, pwe_high: u16::from_be_bytes([a, b]), pwe_low: u16::from_be_bytes([c, d]) }
    }

    /// The value as a word: word 4 (manual chapter 7.4.2.3).
    pub const fn word(self) -> u16 {
        self.pwe_low
    }

    /// The value as a double word: word 3 is its high word.
    pub const fn double_word(self) -> u32 {
        let [a, b] = self.pwe_high.to_be_bytes();
        let [c, d] = self.pwe_low.to_be_bytes();
        u32::from_be_bytes([a, b, c, d])
    }

    /// The PKW in octets 0 to 7 of the PPO.
    pub const fn from_octets(octets: [u8; 8]) -> Self {
        let [a, b, c, d, e, f, g, h] = octets;
        Self {
            pke: Pke(u16::from_be_bytes([a, b])),
            ind: Ind(u16::from_be_bytes([c, d])),
            pwe_high: u16::from_be_bytes([e, f]),
            pwe_low: u16::from_be_bytes([g, h]),
        }
    }

    /// Octets 0 to 7 of the PPO.
    pub const fn to_octets(self) -> [u8; 8] {
        let [a, b] = self.pke.0.to_be_bytes();
        let [c, d] = self.ind.0.to_be_bytes();
        let [e, f] = self.pwe_high.to_be_bytes();
        let [g, h] = self.pwe_low.to_be_bytes();
        [a, b, c, d, e, f, g, h]
    }
}

impl fmt::Display for Pkw {
    /// Four words in hexadecimal, as the manuals print them: `13FA 0000 0000 0000`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X} {:04X} {:04X} {:04X}", self.pke.0, self.ind.0, self.pwe_high, self.pwe_low)
    }
}

/// Parameter identification PKE, word 1 (manual figure 9).
///
/// ```text
/// bit  15 14 13 12   11   10 9 8 7 6 5 4 3 2 1 0
///      AK            SPM  PNU
/// ```
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Pke(u16);

impl Pke {
    const SPM: u16 = 0x0800;
    const PNU: u16 = 0x07FF;

    /// The identification with these 16 bits.
    pub const fn from_raw(raw: u16) -> Self {
        Self(raw)
    }

    /// The identification of a job. Of `pnu` only the 11 bits the word has room for are used; SPM is 0.
    pub const fn of_job(job: JobId, pnu: u16) -> Self {
        Self::of(job.ak(), pnu)
    }

    /// The identification of a reply. Of `pnu` only the 11 bits the word has room for are used; SPM is 0.
    pub const fn of_reply(reply: ReplyId, pnu: u16) -> Self {
        Self::of(reply.ak(), pnu)
    }

    const fn of(ak: u8, pnu: u16) -> Self {
        Self((ak as u16) << 12 | pnu & Self::PNU)
    }

    /// All 16 bits.
    pub const fn raw(self) -> u16 {
        self.0
    }

    /// AK, 0 to 15: the job or reply identification, whichever this word carries.
    pub const fn ak(self) -> u8 {
        let [high, _] = self.0.to_be_bytes();
        high >> 4
    }

    /// The job this word of a master asks for.
    pub const fn job(self) -> JobId {
        JobId::from_ak(self.ak())
    }

    /// The reply this word of a slave gives.
    pub const fn reply(self) -> ReplyId {
        ReplyId::from_ak(self.ak())
    }

    /// Bit 11, toggle bit of spontaneous messages. Without function on these drives: its state does not
    /// matter.
    pub const fn spm(self) -> bool {
        self.0 & Self::SPM != 0
    }

    /// The same word with SPM cleared.
    #[must_use]
    pub const fn without_spm(self) -> Self {
        Self(self.0 & !Self::SPM)
    }

    /// PNU, the parameter's number, 0 to 2047.
    pub const fn pnu(self) -> u16 {
        self.0 & Self::PNU
    }
}

impl fmt::Debug for Pke {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Pke({:#06X})", self.0)
    }
}

/// Index IND, word 2: the sub-index of an array element.
///
/// Neither manual says in which octet it is (`ag03.md` C-14), so both are offered.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Ind(u16);

impl Ind {
    /// The index with these 16 bits.
    pub const fn from_raw(raw: u16) -> Self {
        Self(raw)
    }

    /// A sub-index in the high octet, where PROFIDRIVE version 2 puts it.
    pub const fn in_high_octet(subindex: u8) -> Self {
        Self(u16::from_be_bytes([subindex, 0]))
    }

    /// All 16 bits.
    pub const fn raw(self) -> u16 {
        self.0
    }

    /// Bits 15 to 8, octet 2 of the PPO.
    pub const fn high_octet(self) -> u8 {
        let [high, _] = self.0.to_be_bytes();
        high
    }

    /// Bits 7 to 0, octet 3 of the PPO.
    pub const fn low_octet(self) -> u8 {
        let [_, low] = self.0.to_be_bytes();
        low
    }
}

impl fmt::Debug for Ind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Ind({:#06X})", self.0)
    }
}

/// What a master asks of the parameter channel (manual table 8).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JobId {
    /// 0: nothing.
    NoJob,
    /// 1: read a value.
    Read,
    /// 2: write a word.
    WriteWord,
    /// 3: write a double word.
    WriteDoubleWord,
    /// 4: read an element of the parameter's description.
    ReadDescription,
    /// 5: write an element of the parameter's description.
    WriteDescription,
    /// 6: read an element of an array.
    ReadElement,
    /// 7: write a word into an array.
    WriteElementWord,
    /// 8: write a double word into an array.
    WriteElementDoubleWord,
    /// 9: read the number of elements of an array.
    ReadElementCount,
    /// 10 to 15: without meaning in PROFIDRIVE version 2.
    Reserved(ReservedId),
}

impl JobId {
    const fn from_ak(ak: u8) -> Self {
        match ak {
            0 => Self::NoJob,
            1 => Self::Read,
            2 => Self::WriteWord,
            3 => Self::WriteDoubleWord,
            4 => Self::ReadDescription,
            5 => Self::WriteDescription,
            6 => Self::ReadElement,
            7 => Self::WriteElementWord,
            8 => Self::WriteElementDoubleWord,
            9 => Self::ReadElementCount,
            10.. => Self::Reserved(ReservedId(ak)),
        }
    }

    /// AK, 0 to 15.
    pub(crate) const fn ak(self) -> u8 {
        match self {
            Self::NoJob => 0,
            Self::Read => 1,
            Self::WriteWord => 2,
            Self::WriteDoubleWord => 3,
            Self::ReadDescription => 4,
            Self::WriteDescription => 5,
            Self::ReadElement => 6,
            Self::WriteElementWord => 7,
            Self::WriteElementDoubleWord => 8,
            Self::ReadElementCount => 9,
            Self::Reserved(id) => id.0,
        }
    }
}

impl fmt::Display for JobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoJob => "no job",
            Self::Read => "read value",
            Self::WriteWord => "write word",
            Self::WriteDoubleWord => "write double word",
            Self::ReadDescription => "read description",
            Self::WriteDescription => "write description",
            Self::ReadElement => "read array element",
            Self::WriteElementWord => "write array word",
            Self::WriteElementDoubleWord => "write array double word",
            Self::ReadElementCount => "read number of array elements",
            Self::Reserved(id) => return write!(f, "reserved job {id}"),
        })
    }
}

/// What a slave answers in the parameter channel (manual table 9).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ReplyId {
    /// 0: nothing.
    NoReply,
    /// 1: a word.
    Word,
    /// 2: a double word.
    DoubleWord,
    /// 3: an element of a description.
    Description,
    /// 4: a word of an array.
    ElementWord,
    /// 5: a double word of an array.
    ElementDoubleWord,
    /// 6: the number of elements of an array.
    ElementCount,
    /// 7: the job cannot be executed; word 4 holds the error number.
    NotExecutable,
    /// 8: the parameter channel has no control rights.
    NoControlRights,
    /// 9 to 15: not used by these drives.
    Reserved(ReservedId),
}

impl ReplyId {
    const fn from_ak(ak: u8) -> Self {
        match ak {
            0 => Self::NoReply,
            1 => Self::Word,
            2 => Self::DoubleWord,
            3 => Self::Description,
            4 => Self::ElementWord,
            5 => Self::ElementDoubleWord,
            6 => Self::ElementCount,
            7 => Self::NotExecutable,
            8 => Self::NoControlRights,
            9.. => Self::Reserved(ReservedId(ak)),
        }
    }

    /// AK, 0 to 15.
    pub(crate) const fn ak(self) -> u8 {
        match self {
            Self::NoReply => 0,
            Self::Word => 1,
            Self::DoubleWord => 2,
            Self::Description => 3,
            Self::ElementWord => 4,
            Self::ElementDoubleWord => 5,
            Self::ElementCount => 6,
            Self::NotExecutable => 7,
            Self::NoControlRights => 8,
            Self::Reserved(id) => id.0,
        }
    }
}

impl fmt::Display for ReplyId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoReply => "no reply",
            Self::Word => "word",
            Self::DoubleWord => "double word",
            Self::Description => "description element",
            Self::ElementWord => "array word",
            Self::ElementDoubleWord => "array double word",
            Self::ElementCount => "number of array elements",
            Self::NotExecutable => "job not executable",
            Self::NoControlRights => "no control rights",
            Self::Reserved(id) => return write!(f, "reserved reply {id}"),
        })
    }
}

/// An identification without meaning. Only [`Pke::job`] and [`Pke::reply`] make one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ReservedId(u8);

impl ReservedId {
    /// The AK found, 9 to 15.
    pub const fn ak(self) -> u8 {
        self.0
    }
}

impl ReservedId {
    /// The job that some families have for it: the same write, the value to be kept in the EEPROM.
    pub(crate) const fn keeping(self) -> Option<JobId> {
        match self.0 {
            11 => Some(JobId::WriteElementDoubleWord),
            12 => Some(JobId::WriteElementWord),
            13 => Some(JobId::WriteDoubleWord),
            14 => Some(JobId::WriteWord),
            _ => None,
        }
    }
}

impl fmt::Display for ReservedId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn the_two_telegrams_of_manual_chapter_7_6() {
        let read = Pkw::new(Pke::of_job(JobId::Read, 1018), Ind::default(), 0);
        assert_eq!(read.to_octets(), [0x13, 0xFA, 0, 0, 0, 0, 0, 0]);
        let write = Pkw::new(Pke::of_job(JobId::WriteDoubleWord, 1016), Ind::default(), 250_000);
        assert_eq!(write.to_octets(), [0x33, 0xF8, 0, 0, 0x00, 0x03, 0xD0, 0x90]);
        assert_eq!(write.to_string(), "33F8 0000 0003 D090");

        let reply = Pkw::from_octets([0x23, 0xFA, 0, 0, 0, 0, 0x27, 0x10]);
        assert_eq!((reply.pke.reply(), reply.pke.pnu()), (ReplyId::DoubleWord, 1018));
        assert_eq!((reply.word(), reply.double_word()), (10_000, 10_000));
    }

    #[test]
    fn every_identification_keeps_its_16_bits_and_says_what_it_means() {
        for raw in 0..=u16::MAX {
            let pke = Pke::from_raw(raw);
            let job = Pke::of_job(pke.job(), pke.pnu());
            let reply = Pke::of_reply(pke.reply(), pke.pnu());
            assert_eq!(job, pke.without_spm());
            assert_eq!(reply, pke.without_spm());
            assert_eq!(pke.raw(), job.raw() | if pke.spm() { 0x0800 } else { 0 });
            assert_eq!(matches!(pke.job(), JobId::Reserved(_)), raw >= 0xA000);
            assert_eq!(matches!(pke.reply(), ReplyId::Reserved(_)), raw >= 0x9000);
        }
    }

    #[test]
    fn a_number_too_big_for_11_bits_leaves_the_job_alone() {
        assert_eq!(Pke::of_job(JobId::Read, 0xFFFF).raw(), 0x17FF);
    }

    #[test]
    fn the_index_has_two_octets() {
        let ind = Ind::from_raw(0x0307);
        assert_eq!((ind.high_octet(), ind.low_octet()), (3, 7));
        assert_eq!(Ind::in_high_octet(3).raw(), 0x0300);
    }

    #[test]
    fn words_sit_in_word_4_and_double_words_in_both() {
        let pkw = Pkw::new(Pke::from_raw(0x23FB), Ind::default(), (-1600_i32).cast_unsigned());
        assert_eq!((pkw.pwe_high, pkw.pwe_low), (0xFFFF, 0xF9C0));
        assert_eq!(pkw.double_word().cast_signed(), -1600);
        assert_eq!(pkw.word(), 0xF9C0);
    }

    #[test]
    fn reserved_identifications_name_their_number() {
        assert_eq!(Pke::from_raw(0xB3E8).job().to_string(), "reserved job 11");
        assert_eq!(Pke::from_raw(0x93E8).reply().to_string(), "reserved reply 9");
    }
}
