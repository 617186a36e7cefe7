//! What drives do differently in the parameter channel, as data (`profidrive-v2.md` 2 to 4).

use core::time::Duration;

use crate::devices::ag03::param::{LOAD_PARAMETER_SET, Pnu};

/// How a kind of drive wants to be asked, and how long it may take to answer.
///
/// The named profiles are starting points: `Profile { time: Duration::from_secs(20), ..Profile::AG03 }`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Profile {
    /// Which octet of IND carries the sub-index.
    pub subindex: SubindexPlace,
    /// When the array jobs 6, 7 and 8 are used.
    pub array_jobs: ArrayJobs,
    /// Where the jobs 2, 3, 7 and 8 write to; `None` if it is not known or depends on the parameter.
    pub writes: Option<Memory>,
    /// The drive knows the jobs 11 to 14, which write to the other memory than 2, 3, 7 and 8.
    pub jobs_11_to_14: bool,
    /// What the value in the reply to a write may be.
    pub write_reply: WriteReply,
    /// Parameters that are commands: the reply to their write is awaited with value 0, as a word or a double word
    /// (PNU 970 of the AG03 and AG03/1, `ag03.md` 3.3 and C-15).
    pub commands: &'static [Pnu],
    /// The first and the last of two or more parameters, of which 128 at most are used, that may be read at any time.
    /// One of them is read to find out whether everything that was asked earlier is over, see
    /// [`PkwClient`](super::PkwClient): the first one about which no answer may be outstanding. They need not exist in
    /// the drive: "no such parameter" is a reply too.
    pub probes: [Pnu; 2],
    /// Whether the four words of an input image belong together.
    pub images: Images,
    /// How long a job may take, from its submission on, with everything the client has to do before.
    pub time: Duration,
    /// How many input images a job may take, likewise.
    pub exchanges: u32,
}

/// Which octet of IND carries the sub-index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SubindexPlace {
    /// The high octet, octet 2 of the PPO counted from 0, as PROFIDRIVE version 2 has it.
    HighOctet,
    /// The low octet, octet 3 of the PPO counted from 0 (SIMODRIVE 611 universal).
    LowOctet,
}

/// When the array jobs 6, 7 and 8 are used instead of 1, 2 and 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ArrayJobs {
    /// For elements of arrays.
    ForElements,
    /// Never: the drive knows no array jobs and looks at IND always. Array replies are understood all the same.
    Never,
    /// Always (recommended for SINAMICS G120, where 1 = 6, 2 = 7 and 3 = 8). Plain replies are understood all the
    /// same.
    Always,
}

/// Where a write goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Memory {
    /// Kept when the drive is off. EEPROM cells wear out: do not write so in a cycle.
    Permanent,
    /// Lost when the drive is off.
    Volatile,
}

/// What the value in the positive reply to a write may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WriteReply {
    /// The value written. Any other is not taken for the reply.
    Mirrored,
    /// What a read would now find, which the drive may have rounded or limited. It is reported as it is.
    AsRead,
}

/// Whether the four PKW words of one input image belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Images {
    /// They do: the configuration asks for consistency over the whole module (F3), and the master copies the module
    /// at once (S7: SFC14). One image is enough for a reply.
    Consistent,
    /// An image in which the drive changed something may mix the words of before and after; the next one does not.
    /// A reply needs two images, and a double word that changes all the time needs three with the same high word.
    /// What passes is a double word whose high word changes with one image and back with the next: positions do not.
    MayBeTorn,
}

impl Profile {
    /// PROFIDRIVE version 2 as its tables have it, for drives of which nothing else is known.
    ///
    /// 5 s and 1000 exchanges for a job, [`Images::MayBeTorn`].
    pub const PROFIDRIVE: Self = Self {
        subindex: SubindexPlace::HighOctet,
        array_jobs: ArrayJobs::ForElements,
        writes: None,
        jobs_11_to_14: false,
        write_reply: WriteReply::AsRead,
        commands: &[],
        // From the node address on, those the profile keeps for itself (`profidrive-v2.md` 7).
        probes: [Pnu::from_low_bits(918), Pnu::from_low_bits(999)],
        images: Images::MayBeTorn,
        time: Duration::from_secs(5),
        exchanges: 1000,
    };

    /// SIKO AG03 and AG03/1. Every write is permanent.
    pub const AG03: Self = Self {
        writes: Some(Memory::Permanent),
        write_reply: WriteReply::Mirrored,
        commands: &[LOAD_PARAMETER_SET],
        ..Self::PROFIDRIVE
    };

    /// Siemens MASTERDRIVES, MICROMASTER and SIMOREG: jobs 11 to 14 write to the EEPROM.
    pub const MASTERDRIVES: Self =
        Self { writes: Some(Memory::Volatile), jobs_11_to_14: true, ..Self::PROFIDRIVE };

    /// NORD: jobs 11 to 14 write without the EEPROM.
    pub const NORD: Self = Self { writes: Some(Memory::Permanent), jobs_11_to_14: true, ..Self::PROFIDRIVE };

    /// Siemens SIMODRIVE 611 universal: the sub-index is in the low octet of IND.
    pub const SIMODRIVE_611U: Self = Self { subindex: SubindexPlace::LowOctet, ..Self::PROFIDRIVE };

    /// Siemens SINAMICS G120: array jobs for everything. The parameters from 2000 on, which the low octet of IND selects
    /// as pages, are out of reach.
    pub const SINAMICS_G120: Self = Self { array_jobs: ArrayJobs::Always, ..Self::PROFIDRIVE };

    /// Drives that know no array codes and find elements by the sub-index alone.
    pub const WITHOUT_ARRAY_JOBS: Self = Self { array_jobs: ArrayJobs::Never, ..Self::PROFIDRIVE };
}
