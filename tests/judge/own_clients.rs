//! Our clients of both classes over profirust, as `master record`, `im`, `param` and `alarms` use them, in virtual time: a station
//! with records and alarms, a drive with parameters. The judge of masters accuses them of nothing.

use core::time::Duration;

use profidrive::bench::{Port, Sender};
use profidrive::client::{AcyclicError, ParameterRequest};
use profidrive::devices::profidrive4::profibus::{Family, ProfidriveDevice, TelegramOnly};
use profidrive::gsd::{Gsd, Policy, Station};
use profidrive::host::{GsdStation, HostedProfidrive, Refusals, StationRecord, StationRecords, Stop};
use profidrive::judge::{Recording, Report, Row, Setup, Slave, Verdict};
use profidrive::master::{Connection, OwnedSlave, Owner, RecordError, Reported, Session, Settings};
use profidrive::profibus::dpv1::base_mode::{Attribute, Format, ParameterAddress, Values};
use profidrive::profibus::dpv1::{AlarmType, ErrorCode, Identification, Ms2Offer, Offer, Specifier};
use profidrive::profibus::fdl::Address;
use profidrive::time::{BaudRate, Instant};

use crate::virtual_time::{broken, names};

const BAUD: BaudRate = BaudRate::K500;
const STATION: Address = Address::from_octet(7);
const DRIVE: Address = Address::from_octet(8);
const PATIENCE: Duration = Duration::from_secs(5);

const GSD: &str = "#Profibus_DP\nGSD_Revision=3\nVendor_Name=\"profidrive\"\nModel_Name=\"V1\"\nRevision=\"1\"\n\
    Ident_Number=0x1234\nProtocol_Ident=0\nStation_Type=0\nHardware_Release=\"1\"\nSoftware_Release=\"1\"\n500_supp=1\n\
    MaxTsdr_500=100\nMin_Slave_Intervall=1\nDPV1_Slave=1\nMax_Diag_Data_Len=60\nMax_User_Prm_Data_Len=3\n\
    Ext_User_Prm_Data_Const(0)=0x80,0x60,0x00\nC1_Read_Write_supp=1\nC1_Max_Data_Len=240\nC1_Response_Timeout=100\n\
    C2_Read_Write_supp=1\nC2_Max_Count_Channels=2\nIdent_Maintenance_supp=1\nProcess_Alarm_supp=1\n\
    Diagnostic_Alarm_supp=1\nAlarm_Type_Mode_supp=1\nModule=\"io\" 0x31\nEndModule\n";
const DPV1_STATUS: [u8; 3] = [0x80, 0x60, 0x00];

fn read(text: &[u8]) -> Gsd {
    Gsd::read(text).unwrap()
}

fn of_drive() -> Gsd {
    read(include_bytes!("../../gsd/PDRV5034.GSD"))
}

/// A line with the station and the drive.
fn line() -> Port {
    let port = Port::new(BAUD);
    let mut records = StationRecords::default();
    let record = |data: &[u8], delay: u64| StationRecord {
        data: data.to_vec(),
        read: true,
        write: true,
        delay: Duration::from_millis(delay),
    };
    records.insert((1, 10), record(&[1, 2, 3, 4], 0));
    records.insert((1, 20), record(&[5; 240], 300));
    let station = Station::new(read(GSD.as_bytes()), Policy::PROPOSED).unwrap();
    let station = GsdStation::new(STATION, BAUD, station, Refusals::default()).with_records(records);
    let application = Station::new(of_drive(), Policy::PROPOSED).unwrap();
    let description = application.description();
    let ms2 = Ms2Offer { connections: 2, max_data: 240, max_initiate: 52, min_send_timeout: 10 };
    let offer = Offer { ms1: Some(240), ms2: Some(ms2), ..Offer::NONE };
    let drive = ProfidriveDevice::new(
        DRIVE,
        BAUD,
        (description, TelegramOnly { inner: application, only: None }),
        (offer, Identification::PLAIN),
        Family::new(&[]).unwrap(),
        Instant::ZERO,
    );
    port.line(|line| {
        line.keep(1_000_000);
        line.add(station).unwrap();
        line.add(HostedProfidrive::new(drive, Refusals::default())).unwrap();
    });
    port
}

fn code(error: &RecordError) -> Option<ErrorCode> {
    if let RecordError::Acyclic(AcyclicError::Refused { failure, .. }) = error {
        Some(failure.code)
    } else {
        None
    }
}

/// Records of the station: read, written, slow, refused; and its identification.
fn use_records(session: &mut Session<Port, Port>, octet: u8) {
    let mut connection = Connection::open(session, STATION, PATIENCE).unwrap();
    connection.write(1, 10, &[octet; 4]).unwrap();
    assert_eq!(connection.read(1, 10).unwrap(), [octet; 4]);
    assert_eq!(connection.read(1, 20).unwrap(), [5; 240]);
    connection.write(1, 20, &[5; 240]).unwrap();
    assert_eq!(code(&connection.read(1, 99).unwrap_err()), Some(ErrorCode::INVALID_INDEX));
    assert_eq!(code(&connection.write(1, 10, &[1]).unwrap_err()), Some(ErrorCode::WRITE_LENGTH));
    assert_eq!(connection.identification(0, 0).unwrap()[10..12], [0, 0]);
    connection.close().unwrap();
}

/// Parameters of the drive: several in one request, one that is not there, one that is changed.
fn use_parameters(session: &mut Session<Port, Port>) {
    let address =
        |pnu, elements| ParameterAddress { attribute: Attribute::Value, elements, pnu, subindex: 0 };
    let mut connection = Connection::open(session, DRIVE, PATIENCE).unwrap();
    let request = ParameterRequest::read(1, 0, &[address(922, 0), address(964, 6), address(1, 0)]).unwrap();
    let response = connection.parameters(0, &request).unwrap();
    let results: Vec<_> = request.results(&response).unwrap().collect();
    assert_eq!(results.iter().map(Result::is_ok).collect::<Vec<_>>(), [true, true, false]);
    let speed = Values { format: Format::FLOAT, count: 1, octets: &1500_f32.to_be_bytes() };
    let change = ParameterRequest::change(2, 0, &[(address(1082, 0), speed)]).unwrap();
    let response = connection.parameters(0, &change).unwrap();
    assert!(change.results(&response).unwrap().all(|result| result.is_ok()));
    assert_eq!(connection.identification(0, 0).unwrap().len(), 64);
    connection.close().unwrap();
}

/// Alarms and a status message of the station, which this master owns meanwhile.
fn use_alarms(port: &Port, session: &mut Session<Port, Port>) {
    let slave = OwnedSlave {
        ident: 0x1234,
        user_prm: DPV1_STATUS.to_vec(),
        configuration: vec![0x31],
        outputs: vec![0, 0],
    };
    let mut owner = Owner::take(session, STATION, slave, PATIENCE).unwrap();
    let raise = |kind| {
        port.line(|line| {
            line.with_station(STATION.number(), |station: &mut GsdStation, _| {
                station.raise_alarm(kind, (1, Specifier::Appears, false), &[0x50]).unwrap()
            })
        })
        .unwrap()
    };
    for _ in 0..3 {
        assert_eq!(owner.exchange().unwrap(), []);
        let raised = [raise(AlarmType::Process), raise(AlarmType::Diagnostic)];
        let mut read = Vec::new();
        while read.len() < raised.len() {
            for reported in owner.exchange().unwrap() {
                let Reported::Alarm { head, .. } = reported else { panic!("{reported:?}") };
                owner.acknowledge(head).unwrap();
                read.push(head);
            }
        }
        assert_eq!(read, raised);
        for _ in 0..20 {
            assert_eq!(owner.exchange().unwrap(), []);
        }
    }
    owner.release().unwrap();
}

/// What the judge says of all that passed.
fn judged(port: &Port, settings: &Settings) -> Report {
    let slave = |address, ident, gsd| Slave {
        cfg: None,
        gsd: Some(Box::new(gsd)),
        ..Slave::new(address, ident, Vec::new())
    };
    let setup = Setup {
        stations: vec![slave(STATION, 0x1234, read(GSD.as_bytes())), slave(DRIVE, 0x5034, of_drive())],
        master: Some(settings.master),
        watchdog: Some(settings.watchdog),
        retries: Some(settings.retry_limit.into()),
        slot: Some(settings.slot_time),
        baud: Some(BAUD),
        ..Setup::default()
    };
    let mut recording = Recording::new(setup);
    let passed: Vec<_> = port.line(|line| core::iter::from_fn(|| line.poll_telegram()).collect());
    for passed in passed {
        recording.take(passed.end, &passed.octets, Some(passed.sender == Sender::Master));
    }
    recording.report(Row::ALL)
}

/// With sound telegrams, and with replies and requests that are lost now and then.
#[test]
fn the_judge_accuses_our_clients_of_nothing() {
    for faults in [&[][..], &["no-reply,rate=0.05,seed=1"], &["drop-request,rate=0.05,seed=2"]] {
        let port = line();
        let faults: Vec<_> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
        port.line(|line| line.inject(&faults).unwrap());
        let settings = Settings {
            slot_time: Duration::from_millis(2),
            ..Settings::on_wire(Address::from_octet(2), BAUD)
        };
        let mut session = Session::new(port.clone(), port.clone(), Stop::new().unwrap(), settings).unwrap();
        for round in 0..3 {
            use_records(&mut session, round);
            use_parameters(&mut session);
            use_alarms(&port, &mut session);
        }
        let report = judged(&port, &settings);
        println!("{report}");
        assert_eq!(broken(&report), [""; 0], "{report}");
        let passed = names(&report, Verdict::Pass);
        for row in ["M-V01", "M-V02", "M-V03", "M-V04", "M-V08", "M-V11", "M-V12", "M-V14", "M-V18", "M-V20"]
        {
            assert!(passed.contains(&row), "{row}: {report}");
        }
    }
}
