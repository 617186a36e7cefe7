//! Lines to a [`Gsd`]: the keywords and blocks of `gsd.md` 2 to 6.
//!
//! | file | holds |
//! | --- | --- |
//! | `block.rs` | blocks: their first and last lines, what stands in them |
//! | `main_part.rs` | the keywords of the main part, rates |
//! | `prm.rs` | user parameters: parts, definitions, both forms |

mod block;
mod main_part;
mod prm;

use std::collections::{BTreeMap, BTreeSet};

use self::block::Block;
pub(super) use self::main_part::rate_named;
use super::diagnosis::{DiagArea, DiagBit};
use super::hint::{Hint, Level, Place, ReadError};
use super::module::Module;
use super::parameter::PrmPart;
use super::statement::Statement;
use super::text::{CodePage, trimmed};
use super::{AcyclicKeywords, Flags, Gsd, lines};
use crate::profibus::fdl::Rates;
use crate::time::BaudRate;

/// Octets of Slave_Diag in front of the blocks.
const DIAG_FIXED_LEN: u8 = 6;

/// The most octets of Slave_Diag.
const MAX_DIAG_LEN: u8 = 244;

/// Hints that are kept; a file that earns more of them is no better understood with them.
const MAX_HINTS: usize = 1000;

/// The device that the text of a file describes, with hints on what its author should mend.
pub(super) fn read(text: &str, code_page: CodePage) -> Result<Gsd, ReadError> {
    let (lines, header, unclosed) = lines::lines(text).ok_or_else(|| {
        let is_eds = text.lines().any(|line| matches!(line.trim(), "[FileInfo]" | "[DeviceInfo]"));
        if is_eds { ReadError::IsEds } else { ReadError::NoHeader }
    })?;
    let mut reader = Reader::new(code_page, header);
    for place in unclosed {
        reader.warn(place, "the string is not closed in its line; it ends there".into());
    }
    for line in &lines {
        if let Some(statement) = Statement::of(line) {
            reader.statement(&statement)?;
        }
    }
    reader.end()
}

/// What was read so far.
struct Reader {
    gsd: Gsd,
    header: Place,
    ident: Option<u16>,
    wrong_ident: Option<Place>,
    /// Keywords of the main part that stand once.
    seen: BTreeSet<String>,
    /// Keywords that are none, and what may have been meant.
    unknown: BTreeMap<String, Option<&'static str>>,
    rates: BTreeMap<BaudRate, Place>,
    max_tsdr: BTreeMap<BaudRate, u16>,
    old_len: Option<(Place, usize)>,
    old_data: Option<Vec<u8>>,
    block: Block,
    /// Unit_Diag_Area, on its own or in a UnitDiagType.
    area: Option<DiagArea>,
    /// Between Data_Area_Beg and Data_Area_End, in a module or behind all: no matter of the slave.
    data_area: bool,
    /// The first module that could not be read.
    bad_module: Option<(Place, String)>,
    /// References to parameters, to be checked at the end.
    references: Vec<(Place, u32)>,
}

impl Reader {
    fn new(code_page: CodePage, header: Place) -> Self {
        let gsd = Gsd {
            code_page,
            gsd_revision: 1,
            vendor: String::new(),
            model: String::new(),
            revision: String::new(),
            hardware: String::new(),
            software: String::new(),
            order_number: String::new(),
            info: String::new(),
            ident: 0,
            rates: Rates::NONE,
            flags: Flags::default(),
            acyclic: AcyclicKeywords::default(),
            requires: None,
            max_diag_len: DIAG_FIXED_LEN,
            min_slave_interval: 1,
            max_module: None,
            max_input_len: None,
            max_output_len: None,
            max_data_len: None,
            slot_offset: 1,
            old_user_prm: None,
            user_prm: PrmPart::default(),
            max_user_prm_len: None,
            old_form_last: false,
            parameters: BTreeMap::new(),
            texts: BTreeMap::new(),
            modules: Vec::new(),
            slots: Vec::new(),
            diag_bits: Vec::new(),
            diag_areas: Vec::new(),
            diag_types: Vec::new(),
            channel_diag: Vec::new(),
            hints: Vec::new(),
        };
        Self {
            gsd,
            header,
            ident: None,
            wrong_ident: None,
            seen: BTreeSet::new(),
            unknown: BTreeMap::new(),
            rates: BTreeMap::new(),
            max_tsdr: BTreeMap::new(),
            old_len: None,
            old_data: None,
            block: Block::Main,
            area: None,
            data_area: false,
            bad_module: None,
            references: Vec::new(),
        }
    }

    fn hint(&mut self, level: Level, place: Place, text: String) {
        if self.gsd.hints.len() < MAX_HINTS {
            self.gsd.hints.push(Hint { place, level, text });
        }
    }

    fn warn(&mut self, place: Place, text: String) {
        self.hint(Level::Warning, place, text);
    }

    fn statement(&mut self, line: &Statement<'_>) -> Result<(), ReadError> {
        if line.blank_in_keyword {
            self.warn(line.place, format!("a blank in the keyword '{}', read as '_'", line.spelled));
        }
        if self.begins_or_ends_block(line)? || self.data_area || self.in_area(line) || self.in_block(line) {
            return Ok(());
        }
        self.in_main(line)
    }

    /// First and last lines of blocks.
    fn end(mut self) -> Result<Gsd, ReadError> {
        if let Block::Module { module: Module { place, .. }, .. }
        | Block::Texts { place, .. }
        | Block::Parameter { place, .. }
        | Block::Slots { place }
        | Block::DiagType { place, .. } = self.block
        {
            self.warn(place, "the block that begins here is not closed; it ends with the file".into());
        }
        self.end_block(None);
        let place = self.wrong_ident.unwrap_or(self.header);
        self.gsd.ident = self.ident.ok_or(ReadError::NoIdent { place })?;
        if let (Some((place, name)), true) = (&self.bad_module, self.gsd.modules.is_empty()) {
            return Err(ReadError::NoModuleLeft { place: *place, name: name.clone() });
        }
        self.end_rates();
        self.end_modules();
        self.end_old_user_prm();
        self.end_references();
        if !self.seen.contains("gsd_revision") {
            self.warn(self.header, "no GSD_Revision; read as 1".into());
        }
        if self.gsd.modules.is_empty() {
            self.hint(
                Level::Note,
                self.header,
                "no module: every configuration within the lengths is taken".into(),
            );
        }
        self.gsd.hints.sort_by_key(|hint| (hint.place.line, hint.place.column));
        Ok(self.gsd)
    }
}

/// Marks a bit of the diagnosis among the references to be checked; no parameter has so high a number.
const DIAG_BIT: u32 = 0x8000_0000;

pub(super) fn diag_bit(line: &Statement<'_>, keyword: &str) -> Option<DiagBit> {
    let bit = line.argument.and_then(|bit| u16::try_from(bit).ok()).filter(|_| line.keyword == keyword)?;
    Some(DiagBit { bit, inverted: line.inverted, text: trimmed(line.text()?) })
}
