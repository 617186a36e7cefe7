//! A PROFIBUS-DP slave as its device file (GSD) describes it: the file read and typed, and the slave for a bus.
//!
//! | file | holds |
//! | --- | --- |
//! | `text.rs` | octets to text: code pages |
//! | `lines.rs` | text to lines of words, numbers and strings |
//! | `statement.rs` | a line as keyword, argument and values |
//! | `reader.rs`, `reader/` | statements to a [`Gsd`]: blocks, main part, user parameters |
//! | `module.rs` | modules, slots |
//! | `master.rs` | [`MasterGsd`]: the file of a master, as far as it limits what is configured |
//! | `parameter.rs` | user parameters: fields, ranges, texts, the octets of Set_Prm |
//! | `acyclic.rs` | the keywords of DP-V1 |
//! | `agreement.rs` | which modules the octets of Set_Prm can be those of |
//! | `diagnosis.rs` | the texts of the diagnosis |
//! | `hint.rs` | what is odd in a file, and what makes it useless |
//! | `layout.rs` | where the octets of each module lie |
//! | `project.rs` | Chk_Cfg and Set_Prm of chosen modules, by parameter and text |
//! | `raised.rs` | a diagnosis that is raised on purpose |
//! | `split.rs` | a configuration split into modules |
//! | `station.rs` | [`Station`]: what a slave accepts of its master |
//!
//! The reader is our own, line by line, after `docs/reference/gsd.md` (which says `C` for what it counted in 578
//! real files): each oddity found there is one line here, whereas mending a file for another parser would need the
//! same lexer before it.
//!
//! ```
//! use profidrive::profibus::dp::Application;
//! use profidrive::gsd::{Gsd, Policy, Station};
//!
//! let file = b"#Profibus_DP\nIdent_Number = 0x0ABC\nModule = \"4 in\" 0x13\nEndModule\n";
//! let gsd = Gsd::read(file)?;
//! assert_eq!((gsd.ident, gsd.modules[0].name.as_str()), (0x0ABC, "4 in"));
//! let station = Station::new(gsd, Policy::PROPOSED)?;
//! assert!(station.judge_cfg(&[0x13], &[]).is_ok());
//! assert!(station.judge_cfg(&[0x23], &[]).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod acyclic;
mod agreement;
mod diagnosis;
mod hint;
mod layout;
mod lines;
mod master;
mod module;
mod parameter;
mod project;
mod raised;
mod reader;
mod split;
mod statement;
mod station;
mod text;

pub use acyclic::AcyclicKeywords;
pub use diagnosis::{DiagArea, DiagBit, DiagType};
pub use hint::{Hint, Level, Place, ReadError, did_you_mean};
pub use layout::Placed;
pub use master::MasterGsd;
pub use module::{Module, Slot};
pub use parameter::{Allowed, FieldType, Parameter, PrmPart, Reference};
pub use project::{PrmValue, SettingError};
pub use raised::{ChannelFault, ModuleState, RaiseError, Raised, Status};
pub use station::{Contradiction, NotPluggable, Policy, Station};
pub use text::CodePage;

use std::collections::BTreeMap;

use crate::profibus::dp::IoLengths;
use crate::profibus::fdl::Rates;

/// The longest file that is read, in octets. The longest one known has 256 kB.
pub(crate) const MAX_FILE_LEN: usize = 4 << 20;

/// The most modules of one file. The most known are 302.
pub(crate) const MAX_MODULES: usize = 4096;

/// What a GSD says, keyword by keyword; texts as they stand in the file without the blanks around them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Gsd {
    /// How its octets were read.
    pub code_page: CodePage,
    /// GSD_Revision.
    pub gsd_revision: u8,
    /// Vendor_Name.
    pub vendor: String,
    /// Model_Name.
    pub model: String,
    /// Revision.
    pub revision: String,
    /// Hardware_Release.
    pub hardware: String,
    /// Software_Release.
    pub software: String,
    /// OrderNumber.
    pub order_number: String,
    /// Info_Text.
    pub info: String,
    /// Ident_Number.
    pub ident: u16,
    /// `<rate>_supp` with `MaxTsdr_<rate>`.
    pub rates: Rates,
    /// The switches of the main part.
    pub flags: Flags,
    /// The keywords of DP-V1: services, alarms, identification.
    pub acyclic: AcyclicKeywords,
    /// The keyword of a mode that is required and not emulated; a machine may need it.
    pub requires: Option<String>,
    /// Max_Diag_Data_Len: the longest Slave_Diag with its six fixed octets, 6..=244.
    pub max_diag_len: u8,
    /// Min_Slave_Intervall in units of 100 us.
    pub min_slave_interval: u16,
    /// Max_Module, `None` if it is absent.
    pub max_module: Option<u16>,
    /// Max_Input_Len.
    pub max_input_len: Option<u16>,
    /// Max_Output_Len.
    pub max_output_len: Option<u16>,
    /// Max_Data_Len of the main part.
    pub max_data_len: Option<u16>,
    /// Modul_Offset: the number of the first slot in displays.
    pub slot_offset: u16,
    /// User_Prm_Data_Len with User_Prm_Data: the old form of the user parameters, `None` if both are absent.
    pub old_user_prm: Option<Vec<u8>>,
    /// The station's part of the user parameters in the new form.
    pub user_prm: PrmPart,
    /// Max_User_Prm_Data_Len.
    pub max_user_prm_len: Option<u8>,
    /// The old form stands behind the new one, so it counts (G-12).
    pub old_form_last: bool,
    /// ExtUserPrmData, by number.
    pub parameters: BTreeMap<u32, Parameter>,
    /// PrmText by number: values and their texts.
    pub texts: BTreeMap<u32, Vec<(i64, String)>>,
    /// Module, in the order of the file.
    pub modules: Vec<Module>,
    /// SlotDefinition.
    pub slots: Vec<Slot>,
    /// Unit_Diag_Bit.
    pub diag_bits: Vec<DiagBit>,
    /// Unit_Diag_Area.
    pub diag_areas: Vec<DiagArea>,
    /// UnitDiagType.
    pub diag_types: Vec<DiagType>,
    /// Channel_Diag: error number and text.
    pub channel_diag: Vec<(u8, String)>,
    /// What is odd, in the order of the file.
    pub hints: Vec<Hint>,
}

/// The switches of a GSD's main part; one that is absent is off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Auto_Baud_supp.
    pub auto_baud: bool,
    /// Set_Slave_Add_supp.
    pub set_slave_add: bool,
    /// Sync_Mode_supp.
    pub sync: bool,
    /// Freeze_Mode_supp.
    pub freeze: bool,
    /// Fail_Safe.
    pub fail_safe: bool,
    /// Fail_Safe_required.
    pub fail_safe_required: bool,
    /// Modular_Station.
    pub modular: bool,
    /// FixPresetModules.
    pub fixed_presets: bool,
    /// DPV1_Slave.
    pub dpv1: bool,
    /// WD_Base_1ms_supp.
    pub watchdog_1ms: bool,
    /// Prm_Block_Structure_supp or Prm_Block_Structure_req.
    pub prm_blocks: bool,
}

impl Flags {
    /// Every switch with the keyword of the file.
    pub(crate) const fn by_keyword(&self) -> [(&'static str, bool); 11] {
        [
            ("Auto_Baud_supp", self.auto_baud),
            ("Set_Slave_Add_supp", self.set_slave_add),
            ("Sync_Mode_supp", self.sync),
            ("Freeze_Mode_supp", self.freeze),
            ("Fail_Safe", self.fail_safe),
            ("Fail_Safe_required", self.fail_safe_required),
            ("Modular_Station", self.modular),
            ("FixPresetModules", self.fixed_presets),
            ("DPV1_Slave", self.dpv1),
            ("WD_Base_1ms_supp", self.watchdog_1ms),
            ("Prm_Block_Structure_supp", self.prm_blocks),
        ]
    }
}

impl Gsd {
    /// Reads a file, whole.
    ///
    /// What is odd in it becomes a [`Hint`]; real files are full of it. Never panics, and takes time and memory in
    /// proportion to the file.
    ///
    /// # Errors
    /// [`ReadError`] for what is no GSD of a DP slave.
    pub fn read(file: &[u8]) -> Result<Self, ReadError> {
        let (text, code_page) = text::decode(file)?;
        reader::read(&text, code_page)
    }

    /// The text of a value of a parameter.
    pub fn text_of(&self, parameter: &Parameter, value: i64) -> Option<&str> {
        let texts = self.texts.get(&parameter.text_ref?)?;
        texts.iter().find(|text| text.0 == value).map(|text| text.1.as_str())
    }

    /// Whether its modules are a choice. If not, all of them in the order of the file are the only configuration.
    ///
    /// More modules than Max_Module are a choice whatever Modular_Station says (G-03), and so are modules that have more
    /// octets together than the station.
    pub fn is_modular(&self) -> bool {
        let too_many = |most: u16| self.modules.len() > usize::from(most.max(1));
        self.flags.modular || self.max_module.is_some_and(too_many) || self.are_alternatives()
    }

    fn are_alternatives(&self) -> bool {
        let sum = |of: fn(&IoLengths) -> u8| -> usize {
            self.modules.iter().map(|module| usize::from(of(&module.lengths))).sum()
        };
        let (inputs, outputs) = (sum(|lengths| lengths.inputs), sum(|lengths| lengths.outputs));
        let most = [
            (inputs, self.max_input_len),
            (outputs, self.max_output_len),
            (inputs + outputs, self.max_data_len),
        ];
        let is_over = |(got, most): &(usize, Option<u16>)| most.is_some_and(|most| *got > usize::from(most));
        self.modules.len() > 1 && most.iter().any(is_over)
    }

    /// The default of the user parameters for these modules: the station's part, then those of the modules.
    pub fn default_user_prm(&self, modules: &[usize]) -> Vec<u8> {
        let mut octets = match &self.old_user_prm {
            Some(old) if !self.has_new_user_prm() => old.clone(),
            Some(_) | None => self.user_prm.default_octets(self),
        };
        for module in modules.iter().filter_map(|module| self.modules.get(*module)) {
            octets.extend(module.prm.default_octets(self));
        }
        octets
    }

    /// Whether the new form of the user parameters counts: it is there, and not in front of an old one (G-12).
    fn has_new_user_prm(&self) -> bool {
        let given = self.max_user_prm_len.is_some() || !self.user_prm.is_empty();
        given && !(self.old_form_last && self.old_user_prm.is_some())
    }

    /// The fewest and the most octets of user parameters that Set_Prm may have, DPV1_Status included.
    pub fn user_prm_lengths(&self) -> (u8, u8) {
        let octets = |len: usize| u8::try_from(len.min(parameter::MAX_USER_PRM_LEN)).unwrap_or(u8::MAX);
        let (modules, slots) = (&self.modules, usize::from(self.max_module.unwrap_or(1).max(1)));
        let of_modules = if self.is_modular() {
            modules.iter().map(|module| module.prm.extent(self)).max().unwrap_or(0).saturating_mul(slots)
        } else {
            modules.iter().map(|module| module.prm.extent(self)).sum()
        };
        let status = if self.flags.dpv1 { 3 } else { 0 };
        let least = self.default_user_prm(&[]).len().max(status);
        let most = match self.max_user_prm_len {
            Some(most) if self.has_new_user_prm() => usize::from(most),
            Some(_) | None => least.saturating_add(of_modules),
        };
        (octets(least), octets(most.max(least)))
    }
}
