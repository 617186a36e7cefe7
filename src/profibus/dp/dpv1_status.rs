//! DPV1_Status_1 to 3: the first three user parameters of Set_Prm of a slave of DP-V1.
//!
//! Source: `dp-v1.md` 5.

use super::octet_bits::octet_bits;

octet_bits! {
    /// A bit of DPV1_Status_1, octet 8 of Set_Prm.
    Status1 {
        Enable = 7: "DPV1_Enable", "the slave works as one of DP-V1", "the slave works as one of DP-V0";
        FailSafe = 6: "Fail_Safe", "no outputs in Clear", "outputs of 0 in Clear";
        Publisher = 5: "Publisher_Enable", "the slave publishes its inputs", "it does not";
        WdBase1ms = 2: "WD_Base_1ms", "the watchdog counts 1 ms", "the watchdog counts 10 ms";
        DisStopControl = 1: "Dis_Stop_Control", "stop bits are not checked", "they are";
        DisStartControl = 0: "Dis_Start_Control", "start bits are not checked", "they are";
    }
}

octet_bits! {
    /// A bit of DPV1_Status_2, octet 9 of Set_Prm.
    Status2 {
        PullPlug = 7: "Enable_Pull_Plug_Alarm", "pull and plug alarms may come", "they do not come";
        Process = 6: "Enable_Process_Alarm", "process alarms may come", "they do not come";
        Diagnostic = 5: "Enable_Diagnostic_Alarm", "diagnostic alarms may come", "they do not come";
        Manufacturer = 4: "Enable_Manufacturer_Specific_Alarm", "alarms of the manufacturer may come", "they do not come";
        Status = 3: "Enable_Status_Alarm", "status alarms may come", "they do not come";
        Update = 2: "Enable_Update_Alarm", "update alarms may come", "they do not come";
        CheckCfgMode = 0: "Check_Cfg_Mode", "the slave checks the configuration by its own rule", "by the standard's";
    }
}

octet_bits! {
    /// A bit of DPV1_Status_3, octet 10 of Set_Prm; bits 2 to 0 are how many alarms at once.
    Status3 {
        PrmCmd = 7: "PrmCmd", "a command of redundancy follows", "none";
        IsoMReq = 4: "IsoM_Req", "the slave works in step with the bus", "it does not";
        PrmStructure = 3: "Prm_Structure", "the user parameters are blocks", "they are plain octets";
    }
}

/// Alarm_Mode in DPV1_Status_3.
const ALARM_MODE: u8 = 0x07;

/// How many alarms the master takes at once; `None`: one of each type.
pub(crate) const fn alarm_limit(status_3: u8) -> Option<u8> {
    match status_3 & ALARM_MODE {
        1 => Some(2),
        2 => Some(4),
        3 => Some(8),
        4 => Some(12),
        5 => Some(16),
        6 => Some(24),
        7 => Some(32),
        _ => None,
    }
}

/// How many octets they are.
pub const LEN: usize = 3;

/// The octets at the front of the user parameters; zeros where they are missing.
pub(crate) fn octets(user_prm: &[u8]) -> [u8; LEN] {
    user_prm.first_chunk().copied().unwrap_or_default()
}

/// The fewest octets of a block of parameters: length, type, slot, reserved.
pub(crate) const BLOCK_LEAST: u8 = 4;

/// Where the first block of parameters is whose length does not fit; blocks end with the octets.
pub(crate) fn first_wrong_block(octets: &[u8]) -> Option<usize> {
    let mut rest = octets;
    while let Some(len) = rest.first() {
        match rest.get(usize::from(*len)..) {
            Some(behind) if *len >= BLOCK_LEAST => rest = behind,
            Some(_) | None => return Some(octets.len().saturating_sub(rest.len())),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alarm_mode_counts_as_the_standard_does() {
        let limits: std::vec::Vec<_> = (0..8).map(|mode| alarm_limit(0xF8 | mode)).collect();
        let counts = [2, 4, 8, 12, 16, 24, 32].map(Some);
        assert_eq!((limits[0], &limits[1..]), (None, &counts[..]));
        // Bits 2 to 0 are the limit.
        assert_eq!(Status3::RESERVED, 0x67);
        assert_eq!((Status1::RESERVED, Status2::RESERVED), (0x18, 0x02));
        assert_eq!(octets(&[0x80, 0x60]), [0; 3]);
    }
}
