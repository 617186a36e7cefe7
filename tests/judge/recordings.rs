//! Recordings of correct masters that do what users do: nobody is accused.

use core::time::Duration;

use profidrive::judge::{Outcome, Recording, Report, Row, Setup, Slave, Verdict};
use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, ReplyStatus, Sap, Service,
};
use profidrive::time::{BaudRate, Instant};

use crate::test_master::mistakes::Mistake;
use crate::virtual_time::judged;

const MASTER: u8 = 2;
const SLOT: Duration = Duration::from_millis(100);
/// Prm_Req in the second octet of a diagnosis.
const PRM_REQ: u8 = 0x01;

/// A recording in the making.
struct Trace {
    recording: Recording,
    at: Instant,
    counts: [Option<bool>; 127],
}

impl Trace {
    fn new(stations: &[u8]) -> Self {
        let slave = |number: &u8| Slave::new(Address::from_octet(*number), 0x1234, vec![0x23, 0x13]);
        let stations = stations.iter().map(slave).collect();
        let setup = Setup {
            stations,
            slot: Some(SLOT),
            retries: Some(1),
            hsa: Address::station(10).ok(),
            baud: Some(BaudRate::K500),
            ..Setup::default()
        };
        Self { recording: Recording::new(setup), at: Instant::ZERO, counts: [None; 127] }
    }

    fn take(&mut self, octets: &[u8]) {
        self.after(Duration::from_millis(1), octets);
    }

    fn after(&mut self, pause: Duration, octets: &[u8]) {
        self.at = self.at + pause;
        self.recording.take(self.at, octets, None);
    }

    fn request(&self, to: u8, sap: u8, service: Service, count: FrameCount, data: &[u8]) -> Vec<u8> {
        let sap = (sap > 0).then_some(sap);
        telegram(MASTER, to, sap, sap.map(|_| 62), FunctionCode::request(service, count), data)
    }

    /// A request with the next FCB; no sap: Data_Exchange.
    fn ask(&mut self, to: u8, sap: u8, data: &[u8]) -> Vec<u8> {
        let bit = self.counts[usize::from(to)];
        let count = match bit {
            None => FrameCount::First,
            Some(true) => FrameCount::Odd,
            Some(false) => FrameCount::Even,
        };
        self.counts[usize::from(to)] = Some(!bit.unwrap_or(true));
        let octets = self.request(to, sap, Service::SrdHigh, count, data);
        self.take(&octets);
        octets
    }

    fn reply(&mut self, from: u8, sap: u8, data: &[u8]) {
        let sap = (sap > 0).then_some(sap);
        let fc = FunctionCode::response(ReplyStatus::DataLow);
        let octets = telegram(from, MASTER, sap.map(|_| 62), sap, fc, data);
        self.take(&octets);
    }

    fn diagnose(&mut self, slave: u8, second: u8, owner: u8) {
        self.ask(slave, 60, &[]);
        self.reply(slave, 60, &[0, 0x0C | second, 0, owner, 0x12, 0x34]);
    }

    fn start(&mut self, slave: u8) {
        self.diagnose(slave, PRM_REQ, 255);
        self.ask(slave, 61, &[0x88, 10, 10, 11, 0x12, 0x34, 0]);
        self.take(&[0xE5]);
        self.ask(slave, 62, &[0x23, 0x13]);
        self.take(&[0xE5]);
        self.diagnose(slave, 0, MASTER);
    }

    fn exchange(&mut self, slave: u8, output: u8) {
        self.ask(slave, 0, &[output; 4]);
        self.reply(slave, 0, &[7; 4]);
    }

    fn control(&mut self, command: u8) {
        self.control_of(command, 0);
    }

    fn control_of(&mut self, command: u8, groups: u8) {
        let octets = self.request(127, 58, Service::SdnHigh, FrameCount::Unused, &[command, groups]);
        self.take(&octets);
    }

    /// FDL status of an address where nobody is.
    fn poll(&mut self, address: u8) {
        let octets = self.request(address, 0, Service::FdlStatus, FrameCount::Unused, &[]);
        self.take(&octets);
        self.at = self.at + SLOT;
    }

    fn accuses_nobody(self) -> Report {
        let report = self.recording.report(Row::ALL);
        assert_eq!(report.count(Verdict::Fail) + report.count(Verdict::Warn), 0, "{report}");
        assert_eq!(report.outcome().status(), 0, "{report}");
        report
    }
}

fn telegram(from: u8, to: u8, dsap: Option<u8>, ssap: Option<u8>, fc: FunctionCode, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = (dsap.and_then(Sap::new), ssap.and_then(Sap::new));
    let format = DataTelegram::customary_format(dsap, ssap, data);
    let (da, sa) = (Address::from_octet(to), Address::from_octet(from));
    let mut buf = [0; MAX_TELEGRAM_LEN];
    DataTelegram { format, da, sa, dsap, ssap, fc, data }.encode(&mut buf).unwrap().to_vec()
}

/// What is wrong in a recording: a row finds it.
type Planted = (&'static str, Row, fn(&mut Trace));

const PLANTED: &[Planted] = &[
    ("outputs to a SAP", Row::F06, |trace| {
        trace.ask(5, 57, &[9; 4]);
    }),
    ("a SAP that no service has", Row::F06, |trace| {
        trace.ask(5, 10, &[9; 4]);
    }),
    ("Set_Slave_Add that nobody asked for", Row::U12, |trace| {
        trace.ask(126, 55, &[9, 0x12, 0x34, 0]);
    }),
    ("min T_SDR longer than max T_SDR of the rate", Row::P06, |trace| {
        trace.diagnose(5, PRM_REQ, 255);
        trace.ask(5, 61, &[0x88, 10, 10, 200, 0x12, 0x34, 0]);
    }),
    ("the GAP leaves out an address", Row::K04, |trace| {
        for address in [3, 4, 6, 8, 9, 10, 0, 1].repeat(4) {
            trace.take(&[0xDC, MASTER, MASTER]);
            trace.poll(address);
        }
    }),
    ("OPERATE to a group that the slave is not in", Row::O01, |trace| {
        trace.start(5);
        trace.control_of(0, 1);
        trace.exchange(5, 9);
    }),
];

#[test]
fn what_is_wrong_in_a_recording_is_found() {
    for (what, row, plant) in PLANTED {
        let mut trace = Trace::new(&[5]);
        plant(&mut trace);
        trace.exchange(5, 9);
        let report = trace.recording.report(Row::ALL);
        let failed: Vec<Row> = report
            .judgements
            .iter()
            .filter(|judgement| judgement.verdict == Verdict::Fail)
            .map(|judgement| judgement.row)
            .collect();
        assert_eq!(failed, [*row], "{what}: {report}");
    }
}

/// The same, and nothing is left out.
#[test]
fn a_whole_gap_is_right() {
    let mut trace = Trace::new(&[5]);
    for address in [3, 4, 6, 7, 8, 9, 10, 0, 1].repeat(4) {
        trace.take(&[0xDC, MASTER, MASTER]);
        trace.poll(address);
    }
    trace.accuses_nobody();
}

#[test]
fn the_user_may_ask_for_clear() {
    let mut trace = Trace::new(&[5]);
    trace.start(5);
    trace.control(0);
    for _ in 0..20 {
        trace.exchange(5, 9);
    }
    trace.control(2);
    for _ in 0..20 {
        trace.exchange(5, 0);
    }
    trace.control(0);
    trace.exchange(5, 9);
    trace.accuses_nobody();
}

#[test]
fn a_ring_may_run_already_and_its_gap_may_be_one_address() {
    let mut trace = Trace::new(&[5]);
    trace.counts[5] = Some(true);
    for _ in 0..30 {
        trace.exchange(5, 9);
        trace.poll(3);
        trace.take(&[0xDC, 4, MASTER]);
        trace.take(&[0xDC, MASTER, 4]);
    }
    trace.accuses_nobody();
}

#[test]
fn a_token_to_a_slave_fails_in_a_recording_too() {
    let mut trace = Trace::new(&[5]);
    trace.counts[5] = Some(true);
    trace.exchange(5, 9);
    trace.take(&[0xDC, 5, MASTER]);
    let report = trace.recording.report(&[Row::K02]);
    assert_eq!(report.count(Verdict::Fail), 1, "{report}");
}

#[test]
fn a_slave_may_be_off_and_the_user_may_start_the_master_again() {
    let mut trace = Trace::new(&[5, 6, 7]);
    for _ in 0..3 {
        trace.counts = [None; 127];
        for slave in [5, 6] {
            trace.start(slave);
        }
        trace.control(0);
        for _ in 0..60 {
            trace.exchange(5, 9);
            trace.exchange(6, 9);
            // Nobody answers.
            trace.counts[7] = None;
            trace.ask(7, 60, &[]);
            trace.at = trace.at + SLOT;
        }
    }
    trace.accuses_nobody();
}

/// The reply to the last retry comes when the master has already given the station up.
#[test]
fn a_late_reply_to_the_last_retry_is_no_reply() {
    let mut trace = Trace::new(&[5]);
    for _ in 0..3 {
        trace.counts = [None; 127];
        trace.start(5);
        for _ in 0..10 {
            trace.exchange(5, 9);
        }
        let octets = trace.ask(5, 0, &[9; 4]);
        trace.after(SLOT, &octets);
        trace.at = trace.at + SLOT;
        trace.reply(5, 0, &[7; 4]);
    }
    let report = trace.accuses_nobody();
    assert!(
        report
            .judgements
            .iter()
            .all(|judgement| judgement.row != Row::L08 || judgement.verdict != Verdict::Fail)
    );
}

/// A start-up that leads to nothing: the master unlocks the slave for others, and the user starts it again.
#[test]
fn a_master_may_let_a_slave_go_before_data_exchange() {
    let mut trace = Trace::new(&[5]);
    for _ in 0..3 {
        let diag = trace.request(5, 60, Service::SrdHigh, FrameCount::First, &[]);
        trace.take(&diag);
        trace.reply(5, 60, &[0, 0x0C | PRM_REQ, 0, 0xFF, 0x12, 0x34]);
        trace.counts[5] = Some(false);
        trace.ask(5, 61, &[0xB8, 1, 100, 11, 0x12, 0x34, 0]);
        trace.take(&[0xE5]);
        let release = [0x40, 1, 1, 0, 0x12, 0x34, 0];
        let release = trace.request(5, 61, Service::SrdHigh, FrameCount::First, &release);
        trace.take(&release);
        trace.take(&[0xE5]);
    }
    trace.accuses_nobody();
}

#[test]
fn what_a_recording_without_times_cannot_show_is_not_judged() {
    let mut trace = Trace::new(&[5]);
    trace.start(5);
    trace.exchange(5, 9);
    trace.recording.without_times();
    let report = trace.accuses_nobody();
    let of = |row: Row| report.judgements.iter().find(|judgement| judgement.row == row).unwrap().verdict;
    assert_eq!((of(Row::T08), of(Row::C02)), (Verdict::NotJudged, Verdict::Pass), "{report}");
}

#[test]
fn a_recording_that_is_cut_off_is_no_complete_judgement() {
    let mut trace = Trace::new(&[5]);
    trace.start(5);
    trace.recording.cut_off("packet 17 is not whole");
    let report = trace.recording.report(Row::ALL);
    assert_eq!(report.count(Verdict::Fail) + report.count(Verdict::Warn), 0, "{report}");
    assert!(report.ending.to_string().ends_with("judged as far as it goes: packet 17 is not whole"));
    assert_eq!(report.outcome(), Outcome::NotFinished(report.ending.to_string()));
}

#[test]
fn what_decides_is_among_the_telegrams() {
    let report = judged(Some(Mistake::IgnoresPrmReq), &[Row::D02]);
    let judgement = &report.judgements[0];
    assert_eq!(judgement.verdict, Verdict::Fail, "{report}");
    let shows = |hex: &str| {
        let octets: Vec<u8> = hex.split(' ').map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect();
        octets.get(8) == Some(&60) && octets.get(10).is_some_and(|octet| octet & PRM_REQ != 0)
    };
    assert!(judgement.telegrams.iter().any(|telegram| shows(&telegram.hex)), "{report}");
}

/// Nothing is known of the user parameters without `prm=` and without a device file.
#[test]
fn user_parameters_that_are_not_given_are_not_judged() {
    let mut trace = Trace::new(&[5]);
    trace.diagnose(5, PRM_REQ, 255);
    trace.ask(5, 61, &[0x88, 10, 10, 11, 0x12, 0x34, 0, 1, 2, 3]);
    trace.take(&[0xE5]);
    let report = trace.accuses_nobody();
    let of = report.judgements.iter().find(|judgement| judgement.row == Row::P07).unwrap();
    assert_eq!(of.verdict, Verdict::NotJudged, "{report}");
}
