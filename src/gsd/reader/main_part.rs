//! The main part: what stands once, the rates, the texts of the diagnosis.

use super::prm::part;
use super::{DIAG_BIT, DIAG_FIXED_LEN, MAX_DIAG_LEN, Reader, diag_bit};
use crate::gsd::hint::{Level, Place, ReadError, did_you_mean};
use crate::gsd::parameter::MAX_USER_PRM_LEN;
use crate::gsd::statement::Statement;
use crate::gsd::text::trimmed;
use crate::profibus::fdl::Rates;
use crate::time::BaudRate;

/// The names of the rates in keywords.
const RATES: [(&str, BaudRate); 11] = [
    ("9.6", BaudRate::K9_6),
    ("19.2", BaudRate::K19_2),
    ("31.25", BaudRate::K31_25),
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
    "unit_diag_bit_help",
    "x_unit_diag_bit_help",
];
const WITHOUT_EFFECT_BEGINNINGS: &[&str] =
    &["bitmap_", "c1_", "c2_", "alarm_", "dpv1_", "isochron_", "dxb_", "f_"];

/// What an author may have meant by a keyword that is none: those with an effect whose absence is not noticed at once.
const KEYWORDS: &[&str] = &[
    "Auto_Baud_supp",
    "Set_Slave_Add_supp",
    "Sync_Mode_supp",
    "Freeze_Mode_supp",
    "Fail_Safe",
    "Fail_Safe_required",
    "Modular_Station",
    "FixPresetModules",
    "DPV1_Slave",
    "WD_Base_1ms_supp",
    "Prm_Block_Structure_supp",
    "Max_Diag_Data_Len",
    "Min_Slave_Intervall",
    "Max_Module",
    "Max_Input_Len",
    "Max_Output_Len",
    "Max_Data_Len",
    "Modul_Offset",
    "User_Prm_Data_Len",
    "User_Prm_Data",
    "Max_User_Prm_Data_Len",
    "Ext_User_Prm_Data_Const",
    "Ext_User_Prm_Data_Ref",
    "Ext_Module_Prm_Data_Len",
    "Prm_Text_Ref",
    "Unit_Diag_Bit",
    "Unit_Diag_Area",
    "Channel_Diag",
    "EndModule",
    "EndPrmText",
    "EndExtUserPrmData",
    "ExtUserPrmData",
];

/// Keywords that count something, and the least that makes sense.
const COUNTS: &[(&str, i64)] = &[
    ("GSD_Revision", 1),
    ("Max_Diag_Data_Len", 0),
    ("Min_Slave_Intervall", 0),
    ("Max_Module", 1),
    ("Max_Input_Len", 0),
    ("Max_Output_Len", 0),
    ("Max_Data_Len", 0),
    ("Modul_Offset", 0),
    ("User_Prm_Data_Len", 0),
    ("Max_User_Prm_Data_Len", 0),
];

impl Reader {
    pub(super) fn in_main(&mut self, line: &Statement<'_>) -> Result<(), ReadError> {
        let place = line.place;
        let keyword = line.keyword.as_str();
        if line.argument.is_none() && !keyword.is_empty() && !self.seen.insert(keyword.to_owned()) {
            self.hint(
                Level::Warning,
                place,
                format!("{} is there twice; the last one is used", line.spelled),
            );
        }
        if let Some((name, least)) = COUNTS.iter().find(|(name, _)| name.eq_ignore_ascii_case(keyword)) {
            let place = line.place;
            match line.first() {
                None => self.warn(place, format!("{name} is no number; it is left out")),
                Some(got) if got < *least => {
                    self.warn(place, format!("{name} is {got}, expected {least} or more"));
                }
                Some(_) => {}
            }
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
                    self.warn(place, "User_Prm_Data has a value that is no octet; it is ignored".into());
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
            _ if gsd.acyclic.take(line) => {}
            required if required.ends_with("_required") => {
                if flags {
                    gsd.requires.get_or_insert_with(|| line.spelled.clone());
                }
            }
            _other => self.rate_or_text(line),
        }
        Ok(())
    }

    fn rate_or_text(&mut self, line: &Statement<'_>) {
        let keyword = line.keyword.as_str();
        if let Some(rate) = keyword.strip_suffix("_supp").and_then(rate_named) {
            if line.is_on() {
                self.rates.insert(rate, line.place);
            } else {
                self.rates.remove(&rate);
            }
        } else if let Some(rate) = keyword.strip_prefix("maxtsdr_").and_then(rate_named) {
            self.max_tsdr.extend(line.number().map(|bits: u16| (rate, bits)));
        } else if let Some(bit) = diag_bit(line, "unit_diag_bit") {
            self.check_diag_bit(line.place, bit.bit);
            self.gsd.diag_bits.push(bit);
        } else if !WITHOUT_EFFECT.contains(&keyword)
            && !WITHOUT_EFFECT_BEGINNINGS.iter().any(|beginning| keyword.starts_with(beginning))
        {
            let near = || did_you_mean(&line.spelled, KEYWORDS.iter().copied());
            // A file may have one of them in every second line.
            match *self.unknown.entry(keyword.to_owned()).or_insert_with(near) {
                Some(own) if own.eq_ignore_ascii_case(&line.spelled) => {
                    self.warn(line.place, format!("'{}' has no effect outside of its block", line.spelled));
                }
                Some(near) => {
                    let text =
                        format!("'{}' is no keyword and has no effect; did you mean {near}?", line.spelled);
                    self.warn(line.place, text);
                }
                None => {
                    let text = format!("'{}' has no effect on the slave", line.spelled);
                    self.hint(Level::Note, line.place, text);
                }
            }
        }
    }

    /// Kept in `references` of the end: Max_Diag_Data_Len may stand behind the bits.
    fn check_diag_bit(&mut self, place: Place, bit: u16) {
        self.references.push((place, u32::from(bit) | DIAG_BIT));
    }

    /// Modules that no configuration can have.
    pub(super) fn end_modules(&mut self) {
        let mut too_long = Vec::new();
        for module in &self.gsd.modules {
            let (inputs, outputs) = (u16::from(module.lengths.inputs), u16::from(module.lengths.outputs));
            for (keyword, got, most) in [
                ("Max_Input_Len", inputs, self.gsd.max_input_len),
                ("Max_Output_Len", outputs, self.gsd.max_output_len),
                ("Max_Data_Len", inputs + outputs, self.gsd.max_data_len),
            ] {
                if let Some(most) = most.filter(|most| got > *most) {
                    let name = &module.name;
                    let words = format!(
                        "module '{name}' has {got} octets, {keyword} is {most}: it cannot be configured"
                    );
                    too_long.push((module.place, words));
                }
            }
        }
        for (place, words) in too_long {
            self.warn(place, words);
        }
    }

    pub(super) fn end_rates(&mut self) {
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
}

/// The rate of that name in keywords, in lower case.
pub(in crate::gsd) fn rate_named(name: &str) -> Option<BaudRate> {
    RATES.iter().find(|rate| rate.0 == name).map(|rate| rate.1)
}

fn dp_slave(line: &Statement<'_>, keyword: &'static str) -> Result<(), ReadError> {
    match line.first() {
        None | Some(0) => Ok(()),
        Some(got) => Err(ReadError::NotDpSlave { place: line.place, keyword, got }),
    }
}
