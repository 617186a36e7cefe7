//! Lines to a [`Gsd`]: the keywords and blocks of `gsd.md` 2 to 6.

use std::borrow::ToOwned;
use std::collections::{BTreeMap, BTreeSet};
use std::format;
use std::string::String;
use std::vec::Vec;

use super::diagnosis::{DiagArea, DiagBit, DiagType};
use super::hint::{Hint, Level, Place, ReadError};
use super::module::{Module, Slot};
use super::parameter::{Allowed, FieldType, MAX_USER_PRM_LEN, Parameter, PrmPart, Reference};
use super::statement::Statement;
use super::text::{CodePage, trimmed};
use super::{Flags, Gsd, MAX_MODULES, lines};
use crate::dp::IoLengths;
use crate::fdl::Rates;
use crate::time::BaudRate;

/// Octets of Slave_Diag in front of the blocks.
const DIAG_FIXED_LEN: u8 = 6;

/// The most octets of Slave_Diag.
const MAX_DIAG_LEN: u8 = 244;

/// Hints that are kept; a file that earns more of them is no better understood with them.
const MAX_HINTS: usize = 1000;

/// The names of the rates in keywords.
const RATES: [(&str, BaudRate); 10] = [
    ("9.6", BaudRate::K9_6),
    ("19.2", BaudRate::K19_2),
    ("45.45", BaudRate::K45_45),
    ("93.75", BaudRate::K93_75),
    ("187.5", BaudRate::K187_5),
    ("500", BaudRate::K500),
    ("1.5m", BaudRate::K1500),
    ("3m", BaudRate::K3000),
    ("6m", BaudRate::K6000),
    ("12m", BaudRate::K12000),
];

/// Keywords that a slave need not know, and beginnings of such.
const WITHOUT_EFFECT: &[&str] = &[
    "fms_supp",
    "slave_family",
    "implementation_type",
    "redundancy",
    "repeater_ctrl_sig",
    "24v_pins",
    "periphery",
    "family_name",
    "check_cfg_mode",
    "endpixmap",
    "31.25_supp",
    "maxtsdr_31.25",
];
const WITHOUT_EFFECT_BEGINNINGS: &[&str] = &["bitmap_", "c1_", "c2_", "alarm_", "dpv1_", "isochron_", "dxb_"];

pub(super) fn read(text: &str, code_page: CodePage) -> Result<Gsd, ReadError> {
    let (lines, header, unclosed) = lines::lines(text).ok_or(ReadError::NoHeader)?;
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

struct Reader {
    gsd: Gsd,
    header: Place,
    ident: Option<u16>,
    wrong_ident: Option<Place>,
    /// Keywords of the main part that stand once.
    seen: BTreeSet<String>,
    rates: BTreeMap<BaudRate, Place>,
    max_tsdr: BTreeMap<BaudRate, u16>,
    old_len: Option<(Place, usize)>,
    old_data: Option<Vec<u8>>,
    block: Block,
    /// Unit_Diag_Area, on its own or in a UnitDiagType.
    area: Option<DiagArea>,
    /// The first module that could not be read.
    bad_module: Option<(Place, String)>,
    /// References to parameters, to be checked at the end.
    references: Vec<(Place, u32)>,
}

/// The block that the lines are in.
enum Block {
    Main,
    Module { module: Module, good: bool },
    Texts { place: Place, id: u32, texts: Vec<(i64, String)> },
    Parameter { place: Place, id: u32, name: String, parameter: Option<Parameter> },
    Slots { place: Place },
    DiagType { place: Place, block: DiagType },
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
            rates: BTreeMap::new(),
            max_tsdr: BTreeMap::new(),
            old_len: None,
            old_data: None,
            block: Block::Main,
            area: None,
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
        if self.begins_or_ends_block(line)? || self.in_area(line) || self.in_block(line) {
            return Ok(());
        }
        self.in_main(line)
    }

    /// First and last lines of blocks.
    fn begins_or_ends_block(&mut self, line: &Statement<'_>) -> Result<bool, ReadError> {
        let place = line.place;
        match line.keyword.as_str() {
            "module" => {
                self.end_block(Some(place));
                self.begin_module(line)?;
            }
            "prmtext" => {
                self.end_block(Some(place));
                let id = self.id_of(line);
                self.block = Block::Texts { place, id, texts: Vec::new() };
            }
            "extuserprmdata" => {
                self.end_block(Some(place));
                let (id, name) = (self.id_of(line), line.text().unwrap_or_default());
                self.block = Block::Parameter { place, id, name: trimmed(name), parameter: None };
            }
            "slotdefinition" => {
                self.end_block(Some(place));
                self.block = Block::Slots { place };
            }
            "unitdiagtype" => {
                self.end_block(Some(place));
                let number = line.first().and_then(|number| u8::try_from(number).ok()).unwrap_or_default();
                self.block = Block::DiagType {
                    place,
                    block: DiagType { number, bits: Vec::new(), areas: Vec::new() },
                };
            }
            "unit_diag_area" | "x_unit_diag_area" => {
                self.end_area();
                match line.span().map(|(first, last)| (u16::try_from(first), u16::try_from(last))) {
                    Some((Ok(first), Ok(last))) if first <= last => {
                        self.area = Some(DiagArea { first, last, values: Vec::new() });
                    }
                    Some(_) | None => {
                        self.warn(place, "expected FIRST-LAST bits of the area; the area is left out".into());
                    }
                }
            }
            "unit_diag_area_end" | "x_unit_diag_area_end" => self.end_area(),
            "endmodule" | "endprmtext" | "endextuserprmdata" | "endslotdefinition" | "endunitdiagtype" => {
                self.end_block(None);
            }
            _other => return Ok(false),
        }
        Ok(true)
    }

    fn id_of(&mut self, line: &Statement<'_>) -> u32 {
        let id = line.first().and_then(|id| u32::try_from(id).ok());
        if id.is_none() {
            self.warn(line.place, format!("{} has no number; read as 0", line.spelled));
        }
        id.unwrap_or_default()
    }

    fn begin_module(&mut self, line: &Statement<'_>) -> Result<(), ReadError> {
        let place = line.place;
        if self.gsd.modules.len() >= MAX_MODULES {
            return Err(ReadError::TooManyModules { place });
        }
        let name = trimmed(line.text().unwrap_or_default());
        let identifiers = line.octets();
        let lengths = identifiers.as_deref().and_then(|octets| IoLengths::of(octets).ok());
        let good = lengths.is_some();
        if !good {
            self.warn(
                place,
                format!("the identifiers of module '{name}' are incomplete; the module is left out"),
            );
            self.bad_module.get_or_insert((place, name.clone()));
        }
        let module = Module {
            place,
            name,
            identifiers: identifiers.unwrap_or_default(),
            lengths: lengths.unwrap_or_default(),
            reference: None,
            preset: false,
            prm: PrmPart::default(),
            info: String::new(),
            safety: false,
        };
        self.block = Block::Module { module, good };
        Ok(())
    }

    fn end_area(&mut self) {
        let Some(area) = self.area.take() else { return };
        match &mut self.block {
            Block::DiagType { block, .. } => block.areas.push(area),
            Block::Main
            | Block::Module { .. }
            | Block::Texts { .. }
            | Block::Parameter { .. }
            | Block::Slots { .. } => self.gsd.diag_areas.push(area),
        }
    }

    /// Takes over what the block held; `unclosed` where another one begins instead of its last line.
    fn end_block(&mut self, unclosed: Option<Place>) {
        self.end_area();
        let begun = match core::mem::replace(&mut self.block, Block::Main) {
            Block::Main => return,
            Block::Module { module, good } => {
                let (place, name) = (module.place, module.name.clone());
                if module.safety {
                    let text = format!(
                        "module '{name}' has PROFIsafe parameters; its safety octets are not emulated"
                    );
                    self.warn(place, text);
                }
                if good {
                    self.gsd.modules.push(module);
                }
                place
            }
            Block::Texts { place, id, texts } => {
                if self.gsd.texts.insert(id, texts).is_some() {
                    self.warn(place, format!("PrmText {id} stands twice; the last one counts"));
                }
                place
            }
            Block::Parameter { place, id, name, parameter } => {
                match parameter {
                    Some(parameter) => {
                        if self.gsd.parameters.insert(id, parameter).is_some() {
                            self.warn(
                                place,
                                format!("ExtUserPrmData {id} stands twice; the last one counts"),
                            );
                        }
                    }
                    None => self.warn(place, format!("parameter '{name}' has no type; it is left out")),
                }
                place
            }
            Block::Slots { place } => place,
            Block::DiagType { place, block } => {
                self.gsd.diag_types.push(block);
                place
            }
        };
        if unclosed.is_some() {
            self.warn(
                begun,
                "the block that begins here is not closed; it ends where the next one begins".into(),
            );
        }
    }

    fn in_area(&mut self, line: &Statement<'_>) -> bool {
        let Some(area) = self.area.as_mut().filter(|_| line.keyword == "value") else { return false };
        if let (Some(value), Some(text)) = (line.argument, line.text()) {
            area.values.push((value, trimmed(text)));
        }
        true
    }

    /// Lines that belong to the block at hand; the others belong to the main part, wherever they stand.
    fn in_block(&mut self, line: &Statement<'_>) -> bool {
        let place = line.place;
        let mut hint = None;
        let known = match &mut self.block {
            Block::Main => false,
            Block::Module { module, .. } => match line.keyword.as_str() {
                "" => {
                    module.reference = line.first().and_then(|number| u32::try_from(number).ok());
                    true
                }
                "ext_module_prm_data_len" => {
                    module.prm.len = line.prm_len();
                    true
                }
                "ext_user_prm_data_const" | "ext_user_prm_data_ref" => {
                    hint = part(&mut module.prm, line, &mut self.references).err();
                    true
                }
                "preset" => {
                    module.preset = line.is_on();
                    true
                }
                "info_text" => {
                    module.info = trimmed(line.text().unwrap_or_default());
                    true
                }
                "f_ext_module_prm_data_len" | "f_paramdesccrc" => {
                    module.safety = true;
                    true
                }
                _main => false,
            },
            Block::Texts { texts, .. } => match (line.keyword.as_str(), line.argument, line.text()) {
                ("text", Some(value), Some(text)) => {
                    texts.push((value, trimmed(text)));
                    true
                }
                _main => false,
            },
            Block::Parameter { parameter, name, .. } => match (line.keyword.as_str(), parameter) {
                ("prm_text_ref", Some(parameter)) => {
                    parameter.text_ref = line.first().and_then(|number| u32::try_from(number).ok());
                    true
                }
                ("changeable", Some(parameter)) => {
                    parameter.changeable = line.is_on();
                    true
                }
                ("visible", Some(parameter)) => {
                    parameter.visible = line.is_on();
                    true
                }
                (_, parameter) => match field_type(line) {
                    Some(Ok(field)) => {
                        let (read, odd) = definition(name.clone(), field, line);
                        (*parameter, hint) = (Some(read), odd);
                        true
                    }
                    Some(Err(odd)) => {
                        hint = Some(odd);
                        true
                    }
                    None => false,
                },
            },
            Block::Slots { .. } => match (line.keyword.as_str(), line.argument.map(u16::try_from)) {
                ("slot", Some(Ok(number))) => {
                    let (default, references) = line.slot();
                    let name = trimmed(line.text().unwrap_or_default());
                    self.gsd.slots.push(Slot { number, name, default, references });
                    true
                }
                _main => false,
            },
            Block::DiagType { block, .. } => match diag_bit(line, "x_unit_diag_bit") {
                Some(bit) => {
                    block.bits.push(bit);
                    true
                }
                None => false,
            },
        };
        if let Some(hint) = hint {
            self.warn(place, hint);
        }
        known
    }

    fn in_main(&mut self, line: &Statement<'_>) -> Result<(), ReadError> {
        let place = line.place;
        let keyword = line.keyword.as_str();
        if line.argument.is_none() && !keyword.is_empty() && !self.seen.insert(keyword.to_owned()) {
            self.hint(Level::Warning, place, format!("{} stands twice; the last one counts", line.spelled));
        }
        let text = || trimmed(line.text().unwrap_or_default());
        let (gsd, flags) = (&mut self.gsd, line.is_on());
        match keyword {
            "gsd_revision" => gsd.gsd_revision = line.number().unwrap_or(1),
            "vendor_name" => gsd.vendor = text(),
            "model_name" => gsd.model = text(),
            "revision" => gsd.revision = text(),
            "hardware_release" => gsd.hardware = text(),
            "software_release" => gsd.software = text(),
            "ordernumber" => gsd.order_number = text(),
            "info_text" => gsd.info = text(),
            "ident_number" => match line.number() {
                Some(ident) => self.ident = Some(ident),
                None => self.wrong_ident = Some(place),
            },
            "protocol_ident" => dp_slave(line, "Protocol_Ident")?,
            "station_type" => dp_slave(line, "Station_Type")?,
            "auto_baud_supp" => gsd.flags.auto_baud = flags,
            "set_slave_add_supp" => gsd.flags.set_slave_add = flags,
            "sync_mode_supp" => gsd.flags.sync = flags,
            "freeze_mode_supp" => gsd.flags.freeze = flags,
            "fail_safe" => gsd.flags.fail_safe = flags,
            "fail_safe_required" => gsd.flags.fail_safe_required = flags,
            "modular_station" => gsd.flags.modular = flags,
            "fixpresetmodules" => gsd.flags.fixed_presets = flags,
            "dpv1_slave" => gsd.flags.dpv1 = flags,
            "wd_base_1ms_supp" => gsd.flags.watchdog_1ms = flags,
            "prm_block_structure_supp" | "prm_block_structure_req" => gsd.flags.prm_blocks |= flags,
            "max_diag_data_len" => {
                let got = line.first().unwrap_or_default();
                let len = u8::try_from(got).unwrap_or(MAX_DIAG_LEN).clamp(DIAG_FIXED_LEN, MAX_DIAG_LEN);
                gsd.max_diag_len = len;
                if i64::from(len) != got {
                    self.warn(place, format!("Max_Diag_Data_Len is {got}, expected 6..244; read as {len}"));
                }
            }
            "min_slave_intervall" => gsd.min_slave_interval = line.number().unwrap_or(1),
            "max_module" => gsd.max_module = line.number(),
            "max_input_len" => gsd.max_input_len = line.number(),
            "max_output_len" => gsd.max_output_len = line.number(),
            "max_data_len" => gsd.max_data_len = line.number(),
            "modul_offset" => gsd.slot_offset = line.number().unwrap_or(1),
            "user_prm_data_len" => {
                self.old_len = line.number().map(|len: u8| (place, usize::from(len).min(MAX_USER_PRM_LEN)));
            }
            "user_prm_data" => {
                self.old_data = line.octets();
                gsd.old_form_last = true;
                if self.old_data.is_none() {
                    self.warn(place, "User_Prm_Data holds what is no octet; it is left out".into());
                }
            }
            "max_user_prm_data_len" => {
                gsd.max_user_prm_len = line.prm_len();
                gsd.old_form_last = false;
            }
            "ext_user_prm_data_const" | "ext_user_prm_data_ref" => {
                gsd.old_form_last = false;
                if let Err(hint) = part(&mut gsd.user_prm, line, &mut self.references) {
                    self.warn(place, hint);
                }
            }
            "channel_diag" => {
                if let (Some(Ok(number)), Some(text)) = (line.argument.map(u8::try_from), line.text()) {
                    gsd.channel_diag.push((number, trimmed(text)));
                }
            }
            required if required.ends_with("_required") => gsd.flags.needs_dpv1_services |= flags,
            _other => self.rate_or_text(line),
        }
        Ok(())
    }

    fn rate_or_text(&mut self, line: &Statement<'_>) {
        let keyword = line.keyword.as_str();
        let rate = |name: &str| RATES.iter().find(|rate| rate.0 == name).map(|rate| rate.1);
        if let Some(rate) = keyword.strip_suffix("_supp").and_then(rate) {
            if line.is_on() {
                self.rates.insert(rate, line.place);
            } else {
                self.rates.remove(&rate);
            }
        } else if let Some(rate) = keyword.strip_prefix("maxtsdr_").and_then(rate) {
            self.max_tsdr.extend(line.number().map(|bits: u16| (rate, bits)));
        } else if let Some(bit) = diag_bit(line, "unit_diag_bit") {
            self.check_diag_bit(line.place, bit.bit);
            self.gsd.diag_bits.push(bit);
        } else if !WITHOUT_EFFECT.contains(&keyword)
            && !WITHOUT_EFFECT_BEGINNINGS.iter().any(|beginning| keyword.starts_with(beginning))
        {
            self.hint(Level::Note, line.place, format!("'{}' has no effect on the slave", line.spelled));
        }
    }

    /// Kept in `references` of the end: Max_Diag_Data_Len may stand behind the bits.
    fn check_diag_bit(&mut self, place: Place, bit: u16) {
        self.references.push((place, u32::from(bit) | DIAG_BIT));
    }

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

    fn end_rates(&mut self) {
        for (rate, place) in core::mem::take(&mut self.rates) {
            let bits = self.max_tsdr.get(&rate).copied();
            if bits.is_none() {
                let text = format!("no MaxTsdr for {rate}; read as {} bit times", rate.max_tsdr_bits());
                self.warn(place, text);
            }
            self.gsd.rates = self.gsd.rates.with(rate, bits.unwrap_or(rate.max_tsdr_bits()));
        }
        if self.gsd.rates == Rates::NONE {
            self.warn(self.header, "no rate of PROFIBUS-DP is offered; read as every rate".into());
            self.gsd.rates = Rates::CUSTOMARY;
        }
    }

    fn end_old_user_prm(&mut self) {
        let data = self.old_data.take();
        self.gsd.old_user_prm = match (self.old_len, data) {
            (None, data) => data,
            (Some((place, len)), data) => {
                let mut data = data.unwrap_or_else(|| {
                    if len > 0 && self.gsd.user_prm.is_empty() {
                        self.warn(place, "User_Prm_Data_Len without User_Prm_Data; read as zeros".into());
                    }
                    Vec::new()
                });
                if !data.is_empty() && data.len() != len {
                    let text = format!(
                        "User_Prm_Data_Len is {len}, User_Prm_Data has {} octets; the length counts",
                        data.len()
                    );
                    self.warn(place, text);
                }
                data.resize(len, 0);
                Some(data)
            }
        };
        if let Some(data) = &mut self.gsd.old_user_prm {
            data.truncate(MAX_USER_PRM_LEN);
        }
    }

    fn end_references(&mut self) {
        for (place, number) in core::mem::take(&mut self.references) {
            if number & DIAG_BIT != 0 {
                let octets = u32::from(DIAG_FIXED_LEN) + 2 + (number & !DIAG_BIT) / 8;
                let most = self.gsd.max_diag_len;
                if octets > u32::from(most) {
                    let text = format!(
                        "bit {} needs a diagnosis of {octets} octets, Max_Diag_Data_Len is {most}: raise it",
                        number & !DIAG_BIT
                    );
                    self.warn(place, text);
                }
            } else if !self.gsd.parameters.contains_key(&number) {
                self.warn(place, format!("no ExtUserPrmData {number}; the reference is left out"));
            }
        }
        let dangling = |parameter: &&Parameter| {
            parameter.text_ref.is_some_and(|text| !self.gsd.texts.contains_key(&text))
        };
        let without_text: Vec<_> =
            self.gsd.parameters.values().filter(dangling).map(|parameter| parameter.name.clone()).collect();
        for name in without_text {
            self.warn(self.header, format!("the Prm_Text_Ref of parameter '{name}' leads to no PrmText"));
        }
    }
}

/// Marks a bit of the diagnosis among the references to be checked; no parameter has so high a number.
const DIAG_BIT: u32 = 0x8000_0000;

fn dp_slave(line: &Statement<'_>, keyword: &'static str) -> Result<(), ReadError> {
    match line.first() {
        None | Some(0) => Ok(()),
        Some(got) => Err(ReadError::NotDpSlave { place: line.place, keyword, got }),
    }
}

/// A constant or a reference of a part of the user parameters.
fn part(part: &mut PrmPart, line: &Statement<'_>, references: &mut Vec<(Place, u32)>) -> Result<(), String> {
    let offset = line.argument.unwrap_or_default();
    let offset = u8::try_from(offset).ok().filter(|offset| usize::from(*offset) < MAX_USER_PRM_LEN);
    let offset = offset.ok_or_else(|| format!("{} lies behind octet 236; it is left out", line.spelled))?;
    if line.keyword == "ext_user_prm_data_const" {
        let octets = line
            .octets()
            .ok_or_else(|| format!("{} holds what is no octet; it is left out", line.spelled))?;
        part.constants.push((offset, octets));
        return Ok(());
    }
    let id = line.first().and_then(|id| u32::try_from(id).ok()).filter(|id| id & DIAG_BIT == 0);
    let id = id.ok_or_else(|| format!("{} has no number; it is left out", line.spelled))?;
    part.references.push(Reference { offset, id });
    references.push((line.place, id));
    Ok(())
}

/// The type of a parameter's definition; `None` if the line is something else.
fn field_type(line: &Statement<'_>) -> Option<Result<FieldType, String>> {
    let bit = |number: Option<i64>| number.and_then(|bit| u8::try_from(bit).ok()).filter(|bit| *bit < 32);
    let (first, last) = (bit(line.argument), bit(line.argument_end));
    let wrong = || format!("{} names no bits of 0..31; the parameter is left out", line.spelled);
    Some(match line.keyword.as_str() {
        "bit" => first.map(FieldType::Bit).ok_or_else(wrong),
        "bitarea" => match (first, last) {
            (Some(first), Some(last)) if first <= last => Ok(FieldType::BitArea(first, last)),
            (_, _) => Err(wrong()),
        },
        "unsigned8" => Ok(FieldType::Unsigned8),
        "unsigned16" => Ok(FieldType::Unsigned16),
        "unsigned32" => Ok(FieldType::Unsigned32),
        "signed8" => Ok(FieldType::Signed8),
        "signed16" => Ok(FieldType::Signed16),
        "signed32" => Ok(FieldType::Signed32),
        "changeable" | "visible" | "prm_text_ref" => {
            Err(format!("{} stands before the type; it is left out", line.spelled))
        }
        _other => return None,
    })
}

/// `Type default range-or-set`.
fn definition(name: String, field: FieldType, line: &Statement<'_>) -> (Parameter, Option<String>) {
    let numbers = line.definition();
    let mut odd = None;
    if numbers.default.is_none() {
        odd = Some(format!("parameter '{name}' has no default; read as 0"));
    }
    let default = numbers.default.unwrap_or_default();
    let allowed = match (numbers.range, numbers.set) {
        (Some((least, most)), _) => Allowed::Range(least, most),
        (None, set) if set.is_empty() => Allowed::Any,
        (None, set) => Allowed::Set(set),
    };
    if numbers.default.is_some() && !allowed.contains(default) {
        odd = Some(format!("parameter '{name}': the default {default} is not among {allowed}"));
    }
    if matches!(field, FieldType::Bit(last) | FieldType::BitArea(_, last) if last > 7) {
        odd = Some(format!("parameter '{name}': bits above 7, read in a word with bit 0 in its last octet"));
    }
    (Parameter { name, field, default, allowed, text_ref: None, changeable: true, visible: true }, odd)
}

fn diag_bit(line: &Statement<'_>, keyword: &str) -> Option<DiagBit> {
    let bit = line.argument.and_then(|bit| u16::try_from(bit).ok()).filter(|_| line.keyword == keyword)?;
    Some(DiagBit { bit, inverted: line.inverted, text: trimmed(line.text()?) })
}

impl Statement<'_> {
    /// A length in octets of user parameters.
    fn prm_len(&self) -> Option<u8> {
        let most = u8::try_from(MAX_USER_PRM_LEN).unwrap_or(u8::MAX);
        self.first().map(|len| u8::try_from(len).map_or(most, |len| len.min(most)))
    }
}
