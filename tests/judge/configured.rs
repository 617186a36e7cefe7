//! How the test master and the judge are configured for each mistake.

use core::time::Duration;

use profidrive::gsd::Gsd;
use profidrive::judge::{Setup, Slave};
use profidrive::profibus::fdl::Address;

use crate::test_master::acyclic::Uses;
use crate::test_master::mistakes::{MISTAKES, Mistake};
use crate::test_master::{BAUD, Configured, Settings};

pub(crate) fn setup(settings: &Settings, absent: &[u8]) -> Setup {
    let slave = |configured: &Configured| Slave {
        prm: Some(configured.prm.clone()),
        groups: Some(configured.groups),
        absent: absent.contains(&configured.address),
        gsd: (settings.uses != Uses::NOTHING).then(dpv1_file),
        ..Slave::new(Address::station(configured.address).unwrap(), configured.ident, configured.cfg.clone())
    };
    Setup {
        stations: settings.stations.iter().map(slave).collect(),
        master: Address::station(settings.address).ok(),
        watchdog: Some(settings.watchdog),
        retries: Some(settings.retries),
        slot: Some(settings.slot),
        gap_factor: settings.token.then_some(settings.gap_factor),
        auto_clear: settings.auto_clear,
        ..Setup::default()
    }
}

/// 244 octets each way, in the special format.
pub(crate) const LONGEST: [u8; 12] = [0xC0, 0x3F, 0x3F, 0xC0, 0x3F, 0x3F, 0xC0, 0x3F, 0x3F, 0xC0, 0x33, 0x33];

/// Two stations that are there and one that is not, unless a mistake needs something else to be seen.
pub(crate) fn configured(mistake: Option<Mistake>) -> (Settings, Setup) {
    placed(mistake, &[5, 6, 9], &[9], Duration::from_micros(600))
}

/// These stations, of which some are absent, unless a mistake needs something else to be seen.
pub(crate) fn placed(
    mistake: Option<Mistake>,
    stations: &[u8],
    absent: &[u8],
    slot: Duration,
) -> (Settings, Setup) {
    let mut settings = Settings::new(stations, slot);
    settings.watchdog = settings.watchdog.max(slot * 50);
    let mut absent = absent.to_vec();
    let cfg: Option<&[u8]> = match mistake {
        // Eight octets of inputs.
        Some(Mistake::RejectsSd3) => Some(&[0x23, 0x17]),
        Some(Mistake::OutputsToInputs) => Some(&[0x13]),
        Some(Mistake::IgnoresEmptyHigh | Mistake::RejectsSc) => Some(&[0x23]),
        Some(Mistake::RejectsLong) => Some(&LONGEST),
        Some(Mistake::OtherSpecial) => Some(&[0xC0, 0x03, 0x03]),
        _ => None,
    };
    if let Some(cfg) = cfg {
        settings.stations[0].cfg = cfg.to_vec();
    }
    match mistake {
        // Telegrams are much shorter than the slot time.
        Some(Mistake::TakesLate) => settings.slot = slot.max(Duration::from_millis(5)),
        Some(Mistake::FewStations) => {
            settings.stations = Settings::new(&(10..42).collect::<Vec<u8>>(), slot).stations;
        }
        // As many are absent as are there.
        Some(Mistake::SleepsForAbsent) => {
            let there = stations.len() - absent.len();
            let more: Vec<u8> = (90..).take(there.saturating_sub(absent.len())).collect();
            settings.stations.extend(Settings::new(&more, slot).stations);
            absent.extend(more);
        }
        // Behind the last station of a cycle it may pause.
        Some(Mistake::SlowForAbsent) if !absent.is_empty() => {
            settings.stations.extend(Settings::new(&[12], slot).stations);
        }
        Some(Mistake::TightSlot) => settings.slot = BAUD.bit_times(u32::from(BAUD.max_tsdr_bits()) + 10),
        Some(Mistake::TightWatchdog) => {
            (settings.watchdog, settings.pause) = (Duration::from_millis(10), Duration::from_millis(4));
        }
        Some(Mistake::NeverPasses | Mistake::NoListening) => settings.token = true,
        // One that is never there keeps it in CLEAR.
        Some(Mistake::OperatesWithOne) => {
            absent.clear();
            settings.auto_clear = Some(Duration::from_millis(500).max(slot * 20));
        }
        Some(mistake) if is_of_dpv1(mistake) => settings.uses = Uses { ms1: true, ms2: true },
        Some(mistake) if in_ring(mistake) => {
            settings.token = true;
            settings.ttr = Some(Duration::from_millis(20));
            settings.gap_factor = if mistake == Mistake::GapBeyondNext { 1 } else { 5 };
        }
        _ => {}
    }
    let uses = settings.uses;
    let settings = dpv1(settings, uses);
    let mut setup = Setup {
        hsa: Address::station(if settings.token { settings.hsa } else { 60 }).ok(),
        ttr: settings.ttr,
        min_interval: (mistake == Some(Mistake::TooFast)).then_some(settings.pause * 2),
        ..setup(&settings, &absent)
    };
    if mistake == Some(Mistake::NoAutoClear) {
        setup.auto_clear = Some(Duration::from_millis(500));
    }
    if matches!(mistake, Some(Mistake::AsksSync | Mistake::Dpv1Octets)) {
        let gsd = Gsd::read(device_file(mistake == Some(Mistake::Dpv1Octets)).as_bytes()).unwrap();
        setup.stations[0].gsd = Some(Box::new(gsd));
        setup.stations[0].prm = None;
    }
    (settings, setup)
}

/// DPV1_Status: DP-V1, process and diagnostic alarms, blocks; and a block of one octet.
const DPV1_PRM: [u8; 8] = [0x80, 0x60, 0x08, 5, 0x81, 0, 0, 7];

/// The same master with slaves of DP-V1, whose services it uses.
pub(crate) fn dpv1(mut settings: Settings, uses: Uses) -> Settings {
    settings.uses = uses;
    for station in settings.stations.iter_mut().filter(|_| uses != Uses::NOTHING) {
        station.prm = DPV1_PRM.to_vec();
    }
    settings
}

/// The device file of a slave with every service of DP-V1.
pub(crate) fn dpv1_file() -> Box<Gsd> {
    let more = "DPV1_Slave=1\nC1_Read_Write_supp=1\nC1_Max_Data_Len=64\nC1_Response_Timeout=50\n\
        C2_Read_Write_supp=1\nC2_Max_Count_Channels=2\nProcess_Alarm_supp=1\nDiagnostic_Alarm_supp=1\n\
        Process_Alarm_required=1\nAlarm_Type_Mode_supp=1\nPrm_Block_Structure_supp=1\n\
        Max_User_Prm_Data_Len=8\nExt_User_Prm_Data_Const(0)=0x80,0x60,0x08,5,0x81,0,0,7\n";
    Box::new(Gsd::read(file_with(true, more).as_bytes()).unwrap())
}

/// Mistakes that are made at slaves of DP-V1.
fn is_of_dpv1(mistake: Mistake) -> bool {
    let rows = MISTAKES.iter().find(|(other, _)| *other == mistake).map(|(_, rows)| *rows);
    let first = rows.and_then(<[_]>::first).is_some_and(|row| row.starts_with("M-V"));
    first && !matches!(mistake, Mistake::ReadsRecord | Mistake::ReadsNothing)
        || mistake == Mistake::OtherIndex
}

/// Mistakes that are seen only in a ring.
fn in_ring(mistake: Mistake) -> bool {
    matches!(
        mistake,
        Mistake::NoStatusReply
            | Mistake::StatusAsSlave
            | Mistake::IgnoresReady
            | Mistake::TalksWithoutToken
            | Mistake::TakesForeignToken
            | Mistake::PassesOnce
            | Mistake::PassesForEver
            | Mistake::TakesFromStranger
            | Mistake::StaysDespiteDouble
            | Mistake::NeverClaims
            | Mistake::HoldsLong
            | Mistake::RestartsOnForeign
            | Mistake::TokenToNotReady
            | Mistake::GapBeyondNext
            | Mistake::GapSkips
            | Mistake::NeverAsksGap
            | Mistake::AlwaysAsksGap
    )
}

/// The device file of station 5, with Sync and Freeze or without.
fn device_file(sync: bool) -> String {
    file_with(sync, "User_Prm_Data_Len=2\nUser_Prm_Data=0x01,0x02\n")
}

fn file_with(sync: bool, more: &str) -> String {
    let sync = u8::from(sync);
    format!(
        "#Profibus_DP\nGSD_Revision=1\nVendor_Name=\"Test\"\nModel_Name=\"Four octets\"\nRevision=\"1\"\n\
         Ident_Number=0x1234\nProtocol_Ident=0\nStation_Type=0\nHardware_Release=\"1\"\nSoftware_Release=\"1\"\n\
         500_supp=1\nMaxTsdr_500=100\nSync_Mode_supp={sync}\nFreeze_Mode_supp={sync}\nMin_Slave_Intervall=1\n\
         Modular_Station=0\nMax_Diag_Data_Len=244\n{more}\
         Module=\"Four octets\" 0x23,0x13\nEndModule\n"
    )
}
