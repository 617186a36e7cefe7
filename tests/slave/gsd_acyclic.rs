//! DP-V1 as a GSD promises it: which octets of Set_Prm are taken, and the station with its records (`dp-v1.md` 5, 8 and 13).

use std::time::Duration;

use profidrive::devices::StationEvent;
use profidrive::gsd::{Gsd, Policy, Station};
use profidrive::host::{GsdStation, Participant, Refusals, StationRecord, StationRecords};
use profidrive::profibus::dp;
use profidrive::profibus::dpv1::{AlarmType, NotRaised, Specifier};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, DataTelegram, FrameCount, FunctionCode, Sap, Service};
use profidrive::time::{BaudRate, Instant};

use crate::slave_line::{Answer, RS, SlaveLine, answer};

const HEAD: &str = "#Profibus_DP\nIdent_Number=0x1234\nDPV1_Slave=1\nMax_Diag_Data_Len=60\nMax_User_Prm_Data_Len=30\n\
    Ext_User_Prm_Data_Const(0)=0x00,0x00,0x00\n";
const MODULE: &str = "Module=\"io\" 0x31\nEndModule\n";

fn station(keywords: &str) -> Station {
    let gsd = Gsd::read(format!("{HEAD}{keywords}{MODULE}").as_bytes()).unwrap();
    Station::new(gsd, Policy::PROPOSED).unwrap()
}

/// Whether Set_Prm with these user parameters is refused, and the watchdog time if it is not.
fn judged(keywords: &str, user_prm: &[u8]) -> Option<Option<Duration>> {
    let application = station(keywords);
    let description = application.description();
    let address = Address::station(5).unwrap();
    let station = dp::Station::new(address, BaudRate::K12000, None, description, application);
    let mut line = SlaveLine::of(station);
    let prm = [&[0x88, 10, 10, 11, 0x12, 0x34, 0][..], user_prm].concat();
    assert_eq!(line.request(2, Some(61), &prm), Answer::Sc);
    let fault = line.station.slave().diagnosis().octets()[0] & 0x40 != 0;
    (!fault).then(|| line.station.slave().watchdog().map(|(time, _)| time))
}

#[test]
fn v1_r42_v1_r43_the_watchdog_counts_milliseconds_where_the_gsd_says_so() {
    let second = Some(Some(Duration::from_secs(1)));
    let tenth = Some(Some(Duration::from_millis(100)));
    assert_eq!(judged("WD_Base_1ms_supp=1\n", &[0x04, 0, 0]), tenth);
    assert_eq!(judged("WD_Base_1ms_supp=1\n", &[0x00, 0, 0]), second);
    assert_eq!(judged("", &[0x04, 0, 0]), None);
}

#[test]
fn v1_r44_v1_r45_what_the_gsd_does_not_have_is_a_parameter_fault() {
    for (keywords, user_prm, taken) in [
        ("", [0x40, 0, 0], false),
        ("Fail_Safe=1\n", [0x40, 0, 0], true),
        ("Fail_Safe=1\n", [0x00, 0, 0], true),
        ("Fail_Safe=1\nFail_Safe_required=1\n", [0x00, 0, 0], false),
        ("", [0x20, 0, 0], false),
        ("Publisher_supp=1\n", [0x20, 0, 0], true),
        ("", [0, 0x01, 0], false),
        ("Check_Cfg_Mode=1\n", [0, 0x01, 0], true),
        ("", [0, 0, 0x08], false),
        ("", [0, 0, 0x10], false),
        ("", [0, 0, 0x80], false),
        ("", [0x80, 0, 0x07], true),
    ] {
        assert_eq!(judged(keywords, &user_prm).is_some(), taken, "{keywords} {user_prm:02X?}");
    }
}

#[test]
fn v1_r46_the_lengths_of_blocks_end_with_the_octets() {
    let blocks = "Prm_Block_Structure_supp=1\n";
    assert!(judged(blocks, &[0x80, 0, 0x08, 5, 0x81, 0, 0, 9]).is_some());
    assert_eq!(judged(blocks, &[0x80, 0, 0x08, 6, 0x81, 0, 0, 9]), None);
}

#[test]
fn v1_r47_v1_r48_v1_r49_enables_that_are_not_offered_are_taken_and_required_ones_are_wanted() {
    assert!(judged("", &[0x80, 0xFC, 0]).is_some());
    let remarks = station("Process_Alarm_supp=1\n").remarks(&[0x31], &[0x80, 0x60, 0]);
    let words =
        "the master enables alarms that the GSD does not have: Enable_Diagnostic_Alarm; they never come";
    assert_eq!(remarks, [words]);
    assert_eq!(judged("C1_Read_Write_required=1\n", &[0x00, 0, 0]), None);
    assert!(judged("C1_Read_Write_required=1\n", &[0x80, 0, 0]).is_some());
    assert_eq!(judged("Diagnostic_Alarm_required=1\n", &[0x80, 0x40, 0]), None);
    assert!(judged("Diagnostic_Alarm_required=1\n", &[0x80, 0x20, 0]).is_some());
}

/// A station from a GSD and the masters that ask it.
struct Line {
    station: GsdStation,
    now: Instant,
    odd: bool,
    events: Vec<String>,
}

impl Line {
    fn new(keywords: &str, records: StationRecords) -> Self {
        Self::of(station(keywords), records)
    }

    fn of(station: Station, records: StationRecords) -> Self {
        let address = Address::station(7).unwrap();
        let station =
            GsdStation::new(address, BaudRate::K500, station, Refusals::default()).with_records(records);
        Self { station, now: Instant::from_millis(1), odd: false, events: Vec::new() }
    }

    fn ask(&mut self, master: u8, saps: Option<(u8, u8)>, data: &[u8]) -> Answer {
        self.now = self.now.saturating_add(Duration::from_millis(5));
        self.odd = !self.odd;
        let count = if self.odd { FrameCount::Odd } else { FrameCount::Even };
        let (dsap, ssap) = saps.map(|(dsap, ssap)| (Sap::new(dsap), Sap::new(ssap))).unwrap_or_default();
        let telegram = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, data),
            da: Address::from_octet(7),
            sa: Address::from_octet(master),
            dsap,
            ssap,
            fc: FunctionCode::request(Service::SrdLow, count),
            data,
        };
        let mut buf = [0; 255];
        let octets = telegram.encode(&mut buf).unwrap();
        let Decoded::Telegram { telegram, .. } = decode(octets) else { panic!("{octets:02X?}") };
        let Self { station, events, .. } = self;
        let mut news = |event: StationEvent| events.push(event.to_string());
        station.handle_telegram(self.now, &telegram, &mut news);
        let mut out = [0; 255];
        let due = self.now.saturating_add(Duration::from_millis(1));
        let len = station.poll_transmit(due, &mut out, &mut news).unwrap();
        answer(Some(out[..len].to_vec()))
    }

    fn start(&mut self, user_prm: &[u8]) {
        let prm = [&[0x80, 1, 1, 11, 0x12, 0x34, 0][..], user_prm].concat();
        assert_eq!(self.ask(2, Some((61, 62)), &prm), Answer::Sc);
        assert_eq!(self.ask(2, Some((62, 62)), &[0x31]), Answer::Sc);
        assert_eq!(self.station.slave().state(), dp::State::DataExch);
    }

    /// The response at SAP 51.
    fn ms1(&mut self, data: &[u8]) -> Vec<u8> {
        assert_eq!(self.ask(2, Some((51, 51)), data), Answer::Sc);
        match self.ask(2, Some((51, 51)), &[]) {
            Answer::Low(octets) => octets,
            answer => panic!("{answer:?}"),
        }
    }
}

fn records() -> StationRecords {
    let mut records = StationRecords::default();
    let delay = Duration::ZERO;
    records.insert((1, 10), StationRecord { data: vec![1, 2, 3, 4], read: true, write: true, delay });
    records
}

const C1: &str = "C1_Read_Write_supp=1\nC1_Max_Data_Len=64\nOrderNumber=\"ABC-1\"\nIdent_Maintenance_supp=1\n\
    Process_Alarm_supp=1\nC2_Read_Write_supp=1\nC2_Max_Data_Len=100\n";

#[test]
fn v1_r15_v1_r16_v1_r33_a_station_from_a_gsd_has_the_records_of_its_file() {
    let mut line = Line::new(C1, records());
    line.start(&[0x80, 0x40, 0]);
    assert_eq!(line.ms1(&[0x5E, 1, 10, 240]), [0x5E, 1, 10, 4, 1, 2, 3, 4]);
    assert_eq!(line.ms1(&[0x5F, 1, 10, 4, 9, 9, 9, 9]), [0x5F, 1, 10, 4]);
    assert_eq!(line.station.records().unwrap().record(1, 10).unwrap().data, [9; 4]);
    assert!(line.station.records_mut().unwrap().change(1, 10, &[5, 6, 7, 8]));
    assert_eq!(line.ms1(&[0x5E, 1, 10, 240]), [0x5E, 1, 10, 4, 5, 6, 7, 8]);
    assert_eq!(line.ms1(&[0x5E, 1, 11, 240]), [0xDE, 0x80, 0xB0, 0], "a module of the configuration");
    assert_eq!(line.ms1(&[0x5E, 2, 10, 240]), [0xDE, 0x80, 0xB2, 0], "no module");
    assert!(line.events.iter().any(|event| event == "master 2 wrote record 10 of slot 1, 4 octets"));
    // I&M0 by the keywords.
    assert_eq!(line.ms1(&[0x5F, 0, 255, 4, 8, 0, 0xFD, 0xE8]), [0x5F, 0, 255, 4]);
    assert_eq!(&line.ms1(&[0x5E, 0, 255, 240])[20..26], b"ABC-1 ");
    for keywords in ["", "C2_Read_Write_supp=1\n"] {
        let mut line = Line::new(keywords, records());
        line.start(&[0x80, 0, 0]);
        assert_eq!(line.ask(2, Some((51, 51)), &[0x5E, 1, 10, 1]), RS, "{keywords}");
    }
    // One of DP-V0, whatever else its file says.
    let text = format!("{HEAD}{C1}Extra_Alarm_SAP_supp=1\n{MODULE}").replace("DPV1_Slave=1\n", "");
    let plain = Station::new(Gsd::read(text.as_bytes()).unwrap(), Policy::PROPOSED).unwrap();
    let mut line = Line::of(plain, records());
    for _ in 0..2 {
        for sap in [49, 50, 51] {
            let ssap = if sap == 49 { 50 } else { 51 };
            assert_eq!(line.ask(2, Some((sap, ssap)), &[0x5E, 1, 10, 1]), RS, "SAP {sap}");
        }
        assert_eq!(line.ask(2, Some((61, 62)), &[0x80, 1, 1, 11, 0x12, 0x34, 0, 0, 0, 0]), Answer::Sc);
        assert_eq!(line.ask(2, Some((62, 62)), &[0x31]), Answer::Sc);
        assert_eq!(line.station.slave().state(), dp::State::DataExch);
    }
}

#[test]
fn v1_r70_a_connection_says_the_length_of_the_gsd() {
    let mut line = Line::new(C1, records());
    let initiate = [0x57, 0, 0, 0, 0, 100, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];
    assert_eq!(line.ask(3, Some((49, 50)), &initiate), Answer::Sc);
    assert_eq!(line.ask(3, Some((49, 50)), &[]), Answer::Low(vec![0x56, 48, 0, 100]));
    let Answer::Low(accepted) = line.ask(3, Some((48, 50)), &[]) else { panic!() };
    assert_eq!(accepted[..4], [0x57, 100, 1, 0]);
    assert_eq!(line.events, ["opened a connection for master 3 at SAP 48"]);
    let ends = line.station.poll_timeout().unwrap();
    let mut news = Vec::new();
    line.station.handle_timeout(ends, &mut |event| news.push(event.to_string()));
    assert!(news[0].contains("nothing from the master for three times its Send_Timeout"), "{news:?}");
}

#[test]
fn v1_r51_v1_r55_v1_r56_an_alarm_of_a_station_from_a_gsd() {
    let mut line = Line::new(C1, records());
    let raise = |line: &mut Line, kind| line.station.raise_alarm(kind, (1, Specifier::Appears, false), &[7]);
    assert_eq!(raise(&mut line, AlarmType::Process), Err(NotRaised::NoExchange));
    line.start(&[0x80, 0x40, 0]);
    let not_offered = NotRaised::NotOffered(AlarmType::Update);
    assert_eq!(raise(&mut line, AlarmType::Update), Err(not_offered));
    raise(&mut line, AlarmType::Process).unwrap();
    assert_eq!(line.ask(2, None, &[0, 0]), Answer::High(vec![0, 0]));
    let Answer::Low(diagnosis) = line.ask(2, Some((60, 62)), &[]) else { panic!() };
    assert_eq!(diagnosis[6..], [5, 2, 1, 1, 7]);
    assert_eq!(line.ms1(&[0x5C, 1, 2, 1]), [0x5C, 1, 2, 1]);
    assert!(line.station.services().unwrap().alarms().is_empty());
    line.start(&[0x80, 0, 0]);
    let not_enabled = NotRaised::TypeNotEnabled(AlarmType::Process);
    assert_eq!(raise(&mut line, AlarmType::Process), Err(not_enabled));
}

#[test]
fn v1_r50_set_ext_prm_is_taken_between_set_prm_and_chk_cfg() {
    const BLOCK: [u8; 5] = [5, 0x81, 1, 0, 9];
    let prm = [0x80, 1, 1, 11, 0x12, 0x34, 0, 0x80, 0, 0];
    for (keywords, answer) in [("Prm_Block_Structure_supp=1\n", Answer::Sc), (C1, RS)] {
        let mut line = Line::new(keywords, StationRecords::default());
        assert_eq!(line.ask(2, Some((53, 62)), &BLOCK), RS, "WAIT-PRM");
        assert_eq!(line.ask(2, Some((61, 62)), &prm), Answer::Sc);
        // Twice, so that the frame count bit of the owner goes on.
        assert_eq!(line.ask(3, Some((53, 62)), &BLOCK), RS, "a foreign master");
        assert_eq!(line.ask(3, Some((53, 62)), &BLOCK), RS, "a foreign master");
        assert_eq!(line.ask(2, Some((53, 62)), &BLOCK), answer, "{keywords}");
        assert_eq!(line.ask(2, Some((62, 62)), &[0x31]), Answer::Sc);
        assert_eq!(line.station.slave().state(), dp::State::DataExch);
        assert_eq!(line.ask(2, Some((53, 62)), &BLOCK), RS, "DATA-EXCH");
        assert_eq!(line.station.slave().state(), dp::State::DataExch);
    }
    for wrong in [&[4, 0x81, 1, 0, 9][..], &[6, 0x81, 1, 0, 9], &[3, 0x81, 1], &[]] {
        let mut line = Line::new("Prm_Block_Structure_supp=1\n", StationRecords::default());
        assert_eq!(line.ask(2, Some((61, 62)), &prm), Answer::Sc);
        assert_eq!(line.ask(2, Some((53, 62)), wrong), Answer::Sc);
        assert_eq!(line.station.slave().state(), dp::State::WaitPrm, "{wrong:02X?}");
        assert!(line.station.slave().diagnosis().prm_fault);
        assert!(
            line.events.iter().any(|event| event.contains("refused Set_Ext_Prm of master 2")),
            "{:?}",
            line.events
        );
    }
}
