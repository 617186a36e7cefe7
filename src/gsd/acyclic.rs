//! The keywords of DP-V1: which services, alarms and blocks of identification a slave has (`gsd.md` 2, `dp-v1.md` 8).

use super::statement::Statement;
use crate::profibus::dp::dpv1_status::{Status1, Status2, Status3};
use crate::profibus::dpv1::{AlarmOffer, MAX_DATA, Ms2Offer, Offer};

/// What the keywords of DP-V1 say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AcyclicKeywords {
    /// C1_Read_Write_supp.
    pub c1: bool,
    /// C1_Max_Data_Len.
    pub c1_max_data_len: Option<u8>,
    /// C1_Read_Write_required.
    pub c1_required: bool,
    /// C1_Response_Timeout, times 10 ms.
    pub c1_response: Option<u16>,
    /// C2_Read_Write_supp.
    pub c2: bool,
    /// C2_Response_Timeout, times 10 ms.
    pub(crate) c2_response: Option<u16>,
    /// C2_Max_Data_Len.
    pub c2_max_data_len: Option<u8>,
    /// C2_Max_Count_Channels.
    pub c2_channels: Option<u8>,
    /// Max_Initiate_PDU_Length.
    pub max_initiate: Option<u8>,
    /// The alarms that the slave has, as bits of DPV1_Status_2: Process_Alarm_supp and the others.
    pub alarms: u8,
    /// The alarms that a master must enable: Process_Alarm_required and the others.
    pub alarms_required: u8,
    /// Alarm_Sequence_Mode_Count.
    pub sequence: u8,
    /// Extra_Alarm_SAP_supp.
    pub extra_alarm_sap: bool,
    /// Publisher_supp.
    pub publisher: bool,
    /// Check_Cfg_Mode.
    pub check_cfg_mode: bool,
    /// PrmCmd_supp.
    pub(crate) prm_cmd: bool,
    /// Isochron_Mode_supp.
    pub(crate) isochron: bool,
    /// Ident_Maintenance_supp.
    pub identification: bool,
}

impl AcyclicKeywords {
    /// Takes a statement; `false` if it is none of these.
    pub(super) fn take(&mut self, line: &Statement<'_>) -> bool {
        let on = line.is_on();
        let len = || line.first().map(|len| u8::try_from(len).unwrap_or(MAX_DATA).min(MAX_DATA));
        match line.keyword.as_str() {
            "c1_read_write_supp" => self.c1 = on,
            "c1_max_data_len" => self.c1_max_data_len = len(),
            "c1_read_write_required" => self.c1_required = on,
            "c1_response_timeout" => self.c1_response = line.number(),
            "c2_response_timeout" => self.c2_response = line.number(),
            "prmcmd_supp" => self.prm_cmd = on,
            "isochron_mode_supp" => self.isochron = on,
            "c2_read_write_supp" => self.c2 = on,
            // A master without connections works all the same.
            "c2_read_write_required" => {}
            "c2_max_data_len" => self.c2_max_data_len = len(),
            "c2_max_count_channels" => self.c2_channels = len(),
            "max_initiate_pdu_length" => self.max_initiate = len(),
            "alarm_sequence_mode_count" => self.sequence = len().unwrap_or_default(),
            "extra_alarm_sap_supp" => self.extra_alarm_sap = on,
            "publisher_supp" => self.publisher = on,
            "check_cfg_mode" => self.check_cfg_mode = on,
            "ident_maintenance_supp" => self.identification = on,
            keyword => {
                let Some((alarm, end)) = keyword.split_once("_alarm_") else { return false };
                let Some(bit) = alarm_bit(alarm) else { return false };
                let bits = match end {
                    "supp" => &mut self.alarms,
                    "required" => &mut self.alarms_required,
                    _ => return false,
                };
                *bits = if on { *bits | bit.mask() } else { *bits & !bit.mask() };
            }
        }
        true
    }

    /// What a slave of these keywords offers; `min_send_timeout` times 10 ms is the least Send_Timeout of a connection.
    pub fn offer(&self, min_send_timeout: u16) -> Offer {
        let plain = Ms2Offer::PLAIN;
        let ms2 = Ms2Offer {
            connections: self.c2_channels.unwrap_or(plain.connections),
            max_data: self.c2_max_data_len.unwrap_or(plain.max_data),
            max_initiate: self.max_initiate.unwrap_or(plain.max_initiate),
            min_send_timeout,
        };
        let alarms =
            AlarmOffer { types: self.alarms, sequence: self.sequence, extra_sap: self.extra_alarm_sap };
        Offer {
            ms1: self.c1.then(|| self.c1_max_data_len.unwrap_or(MAX_DATA)),
            ms2: self.c2.then_some(ms2),
            alarms,
        }
    }

    /// What a master must have enabled and has not, with its octet in DPV1_Status: the name of the bit and the keyword that
    /// wants it.
    pub(crate) fn missing(&self, status: [u8; 3]) -> Option<(usize, &'static str)> {
        let [one, two, _] = status;
        if self.c1_required && !Status1::Enable.is_set(one) {
            return Some((0, Status1::Enable.name()));
        }
        let bit = Status2::ALL.iter().find(|bit| bit.is_set(self.alarms_required) && !bit.is_set(two))?;
        Some((1, bit.name()))
    }

    /// The bits of DPV1_Status that the slave lacks.
    pub(super) fn lacks(&self) -> [u8; 3] {
        let lacks = |bit: u8, has: bool| if has { 0 } else { bit };
        [
            lacks(Status1::Publisher.mask(), self.publisher),
            lacks(Status2::CheckCfgMode.mask(), self.check_cfg_mode),
            // Neither redundancy nor isochronous mode is emulated.
            Status3::PrmCmd.mask() | Status3::IsoMReq.mask(),
        ]
    }
}

/// The bit that enables alarms of this name in keywords, in lower case.
fn alarm_bit(name: &str) -> Option<Status2> {
    Some(match name {
        "pull_plug" => Status2::PullPlug,
        "process" => Status2::Process,
        "diagnostic" => Status2::Diagnostic,
        "manufacturer_specific" => Status2::Manufacturer,
        "status" => Status2::Status,
        "update" => Status2::Update,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gsd::Gsd;

    #[test]
    fn the_keywords_of_dp_v1_are_an_offer() {
        let file = "#Profibus_DP\nIdent_Number=1\nDPV1_Slave=1\nC1_Read_Write_supp=1\nC1_Max_Data_Len=64\n\
            C2_Read_Write_supp=1\nC2_Max_Count_Channels=3\nC2_Max_Data_Len=255\nMax_Initiate_PDU_Length=40\n\
            Process_Alarm_supp=1\nPull_Plug_Alarm_supp=1\nUpdate_Alarm_supp=0\nDiagnostic_Alarm_required=1\n\
            Alarm_Sequence_Mode_Count=8\nExtra_Alarm_SAP_supp=1\nIdent_Maintenance_supp=1\nModule=\"a\" 0x10\nEndModule\n";
        let keywords = Gsd::read(file.as_bytes()).unwrap().acyclic;
        let ms2 = Ms2Offer { connections: 3, max_data: 240, max_initiate: 40, min_send_timeout: 10 };
        let alarms = AlarmOffer { types: 0xC0, sequence: 8, extra_sap: true };
        assert_eq!(keywords.offer(10), Offer { ms1: Some(64), ms2: Some(ms2), alarms });
        assert!(keywords.identification);
        assert_eq!(keywords.missing([0x80, 0x40, 0]), Some((1, "Enable_Diagnostic_Alarm")));
        assert_eq!(keywords.missing([0x80, 0x20, 0]), None);
        let needs =
            Gsd::read(b"#Profibus_DP\nIdent_Number=1\nC1_Read_Write_required=1\nIsochron_Mode_required=1\n");
        assert_eq!(needs.unwrap().requires.as_deref(), Some("Isochron_Mode_required"));
        let plain = Gsd::read(b"#Profibus_DP\nIdent_Number=1\nModule=\"a\" 0x10\nEndModule\n").unwrap();
        assert!(plain.acyclic.offer(10).is_none());
    }
}
