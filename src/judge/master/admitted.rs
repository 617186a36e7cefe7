//! What the master's own device file admits: of the configuration, of what is asked of it, of what is sent to it.

use super::scenario::Scenario;
use super::setup::{Setup, Slave};
use super::station::Act;
use crate::gsd::MasterGsd;
use crate::time::{BaudRate, SYN_BITS};

/// Octets of the longest diagnosis.
const LONGEST_DIAG: u8 = 244;
/// Octets of Set_Prm in front of the user parameters.
const PRM_HEAD: usize = 7;
/// The shortest min T_SDR, in bit times.
const LEAST_TSDR: u32 = 11;

impl Setup {
    /// Whether the master's device file admits the rate and the stations.
    ///
    /// # Errors
    /// What it does not admit, in words.
    pub fn check_master(&self) -> Result<(), String> {
        let Some(gsd) = &self.master_gsd else { return Ok(()) };
        if let Some(rate) = self.baud.filter(|rate| !gsd.rates.is_empty() && !gsd.rates.contains(rate)) {
            let offered: Vec<String> = gsd.rates.iter().map(BaudRate::to_string).collect();
            return Err(format!("it offers no {rate}, but {}", offered.join(", ")));
        }
        let stations = self.stations.len();
        if let Some(most) = gsd.max_slaves.filter(|most| stations > usize::from(*most)) {
            return Err(format!("Max_Slaves_supp is {most}, and there are {stations} stations"));
        }
        self.stations.iter().try_for_each(|slave| check_slave(gsd, slave))?;
        let octets: usize = self.stations.iter().map(parameter_octets).sum();
        let memory = gsd.max_parameter_set.and_then(|most| usize::try_from(most).ok());
        match memory.filter(|most| octets > *most) {
            Some(most) => Err(format!(
                "Max_MPS_Length is {most}, and Set_Prm and Chk_Cfg of all stations have {octets} octets"
            )),
            None => Ok(()),
        }
    }
}

/// Set_Prm and Chk_Cfg of a station, as far as they are known.
fn parameter_octets(slave: &Slave) -> usize {
    PRM_HEAD + slave.prm.as_ref().map_or(0, Vec::len) + slave.cfg.as_ref().map_or(0, Vec::len)
}

/// Whether a master can have this station.
fn check_slave(gsd: &MasterGsd, slave: &Slave) -> Result<(), String> {
    let (inputs, outputs) =
        slave.lengths().map_or((0, 0), |lengths| (u16::from(lengths.inputs), u16::from(lengths.outputs)));
    let prm = slave.prm.as_ref().map_or(0, |prm| PRM_HEAD + prm.len());
    let cfg = slave.cfg.as_ref().map_or(0, Vec::len);
    let longest = u16::try_from(prm.max(cfg)).unwrap_or(u16::MAX).max(inputs).max(outputs);
    for (keyword, most, got, what) in [
        ("Max_Master_Input_Len", gsd.max_input_len, inputs, "octets of inputs"),
        ("Max_Master_Output_Len", gsd.max_output_len, outputs, "octets of outputs"),
        ("Max_Master_Data_Len", gsd.max_data_len, inputs + outputs, "octets both ways"),
        ("Max_Lsdu_MS", gsd.max_lsdu.map(u16::from), longest, "octets in one telegram"),
    ] {
        if let Some(most) = most.filter(|most| got > *most) {
            return Err(format!("{keyword} is {most}, and station {} has {got} {what}", slave.address));
        }
    }
    Ok(())
}

impl MasterGsd {
    /// Why a scenario is nothing for this master; `None`: it is.
    pub(super) fn obstacle(&self, scenario: &Scenario) -> Option<&'static str> {
        let asks = |actions: &[&str]| {
            let mut asked = scenario.steps.iter().filter_map(|step| step.ask.as_deref());
            asked.any(|ask| actions.iter().any(|action| ask.split(' ').next() == Some(action)))
        };
        let long = scenario.steps.iter().any(|step| step.act == Some(Act::LongDiagnosis));
        if long && self.max_lsdu.is_some_and(|most| most < LONGEST_DIAG) {
            Some("the master's device file takes no diagnosis of 244 octets (Max_Lsdu_MS)")
        } else if asks(&["sync", "unsync"]) && self.sync == Some(false) {
            Some("the master's device file has no Sync (Master_Sync_Mode_supp)")
        } else if asks(&["freeze", "unfreeze"]) && self.freeze == Some(false) {
            Some("the master's device file has no Freeze (Master_Freeze_Mode_supp)")
        } else {
            None
        }
    }

    /// T_ID1 in bit times: max(T_QUI + 2 T_SET + 2 + T_SYN, min T_SDR). `None`: the file says nothing of the rate.
    pub(super) fn idle_bits(&self, rate: BaudRate) -> Option<u32> {
        let (quiet, setup) = self.quiet_and_setup.get(&rate)?;
        Some((u32::from(*quiet) + 2 * u32::from(*setup) + 2 + SYN_BITS).max(LEAST_TSDR))
    }
}
