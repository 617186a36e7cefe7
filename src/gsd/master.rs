//! What the GSD of a master of class 1 says: the keywords that limit what can be configured in it.

use std::collections::BTreeMap;

use super::hint::ReadError;
use super::lines;
use super::reader::rate_named;
use super::statement::Statement;
use super::text::{self, trimmed};
use crate::time::BaudRate;

/// The revision of the format from which on the keywords of Sync and Freeze are there, and absent means no.
const WITH_MODES: u8 = 3;

/// A master of class 1 as its device file describes it. What is `None` the file does not say.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MasterGsd {
    /// Vendor_Name.
    pub vendor: String,
    /// Model_Name.
    pub model: String,
    /// The rates of `<rate>_supp`; empty: the file names none.
    pub rates: Vec<BaudRate>,
    /// Master_Sync_Mode_supp.
    pub sync: Option<bool>,
    /// Master_Freeze_Mode_supp.
    pub freeze: Option<bool>,
    /// Max_Slaves_supp: so many slaves.
    pub max_slaves: Option<u8>,
    /// Max_Master_Input_Len: octets of inputs of one slave.
    pub max_input_len: Option<u16>,
    /// Max_Master_Output_Len: octets of outputs of one slave.
    pub max_output_len: Option<u16>,
    /// Max_Master_Data_Len: both together.
    pub max_data_len: Option<u16>,
    /// Max_Lsdu_MS: the longest data of a telegram between master and slave, in octets.
    pub max_lsdu: Option<u8>,
    /// Max_MPS_Length: memory for the parameter sets of all slaves, in octets.
    pub max_parameter_set: Option<u32>,
    /// `Tqui_<rate>` and `Tset_<rate>`, in bit times.
    pub quiet_and_setup: BTreeMap<BaudRate, (u8, u8)>,
}

impl MasterGsd {
    /// Reads a file, whole. Keywords that a judge needs not know are passed over.
    ///
    /// # Errors
    /// [`ReadError`] for what is no GSD of a DP master.
    pub fn read(file: &[u8]) -> Result<Self, ReadError> {
        let (text, _) = text::decode(file)?;
        let (lines, header, _) = lines::lines(&text).ok_or(ReadError::NoHeader)?;
        let mut gsd = Self::default();
        let (mut revision, mut station_type) = (1, None);
        for statement in lines.iter().filter_map(Statement::of) {
            match statement.keyword.as_str() {
                "gsd_revision" => revision = statement.number().unwrap_or(revision),
                "station_type" => station_type = statement.first().map(|got| (statement.place, got)),
                _ => gsd.take(&statement),
            }
        }
        match station_type {
            Some((_, 1)) => {}
            Some((place, got)) => return Err(ReadError::NotDpMaster { place, got }),
            None => return Err(ReadError::NotDpMaster { place: header, got: 0 }),
        }
        if revision >= WITH_MODES {
            gsd.sync.get_or_insert(false);
            gsd.freeze.get_or_insert(false);
        }
        gsd.rates.sort_unstable();
        gsd.rates.dedup();
        Ok(gsd)
    }

    fn take(&mut self, line: &Statement<'_>) {
        let text = || trimmed(line.text().unwrap_or_default());
        match line.keyword.as_str() {
            "vendor_name" => self.vendor = text(),
            "model_name" => self.model = text(),
            "master_sync_mode_supp" => self.sync = Some(line.is_on()),
            "master_freeze_mode_supp" => self.freeze = Some(line.is_on()),
            "max_slaves_supp" => self.max_slaves = line.number(),
            "max_master_input_len" => self.max_input_len = line.number(),
            "max_master_output_len" => self.max_output_len = line.number(),
            "max_master_data_len" => self.max_data_len = line.number(),
            "max_lsdu_ms" => self.max_lsdu = line.number(),
            "max_mps_length" => self.max_parameter_set = line.number(),
            keyword => self.take_rate(keyword, line),
        }
    }

    /// What is said of one rate.
    fn take_rate(&mut self, keyword: &str, line: &Statement<'_>) {
        let of = |name: Option<&str>| name.and_then(rate_named);
        if let Some(rate) = of(keyword.strip_suffix("_supp")) {
            self.rates.extend(line.is_on().then_some(rate));
        } else if let Some(rate) = of(keyword.strip_prefix("tqui_")) {
            self.quiet_and_setup.entry(rate).or_default().0 = line.number().unwrap_or_default();
        } else if let Some(rate) = of(keyword.strip_prefix("tset_")) {
            self.quiet_and_setup.entry(rate).or_default().1 = line.number().unwrap_or_default();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "#Profibus_DP\nGSD_Revision=3\nVendor_Name=\"Test\"\nModel_Name=\"Master\"\nIdent_Number=0x0BCD\n\
        Protocol_Ident=0\nStation_Type=1\n9.6_supp=1\n500_supp=1\n1.5M_supp=1\n12M_supp=0\nMaster_Sync_Mode_supp=1\n\
        Max_MPS_Length=4096 ; octets\nMax_Lsdu_MS=200\nMax_Lsdu_MM=240\nMin_Poll_Timeout=100\nTqui_500=0\nTset_500=1\n\
        Tqui_1.5M=3\nLAS_Len=127\nMax_Slaves_supp=32\nMax_Master_Input_Len=122\nMax_Master_Output_Len=100\n\
        Max_Master_Data_Len=0x80\n";

    #[test]
    fn what_limits_a_master_is_read() {
        let gsd = MasterGsd::read(FILE.as_bytes()).unwrap();
        assert_eq!((gsd.vendor.as_str(), gsd.model.as_str()), ("Test", "Master"));
        assert_eq!(gsd.rates, [BaudRate::K9_6, BaudRate::K500, BaudRate::K1500]);
        // Of two keywords that this revision has one is missing.
        assert_eq!((gsd.sync, gsd.freeze), (Some(true), Some(false)));
        assert_eq!((gsd.max_slaves, gsd.max_lsdu, gsd.max_parameter_set), (Some(32), Some(200), Some(4096)));
        let lengths = (gsd.max_input_len, gsd.max_output_len, gsd.max_data_len);
        assert_eq!(lengths, (Some(122), Some(100), Some(128)));
        assert_eq!(gsd.quiet_and_setup.get(&BaudRate::K500), Some(&(0, 1)));
        assert_eq!(gsd.quiet_and_setup.get(&BaudRate::K1500), Some(&(3, 0)));
    }

    #[test]
    fn an_old_file_says_nothing_of_sync() {
        let gsd = MasterGsd::read(b"#Profibus_DP\nGSD_Revision=1\nStation_Type=1\n").unwrap();
        assert_eq!(gsd, MasterGsd::default());
    }

    #[test]
    fn the_file_of_a_slave_is_refused() {
        let error = MasterGsd::read(FILE.replace("Station_Type=1", "Station_Type=0").as_bytes()).unwrap_err();
        assert!(error.to_string().starts_with("line 7, column 1: Station_Type is 0, expected 1"), "{error}");
        let error = MasterGsd::read(b"#Profibus_DP\n").unwrap_err();
        assert!(error.to_string().contains("expected 1"), "{error}");
        assert_eq!(MasterGsd::read(b"x = 1"), Err(ReadError::NoHeader));
    }
}
