//! The drive of `examples/own_drive.rs` and a master that reads and writes its parameters.

#[path = "../../examples/own_drive.rs"]
mod example;

use example::OwnDrive;
use profidrive::client::{ErrorCode, Job, PkwClient, PkwError, Profile, Reply};
use profidrive::devices::PlainStation;
use profidrive::devices::ag03::param::{Pnu, Subindex, Value};
use profidrive::face::surroundings::Level;
use profidrive::host::Participant;
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, Sap, Service, Telegram,
};
use profidrive::profibus::pkw::ErrorNumber;
use profidrive::profibus::ppo::Pkw;
use profidrive::time::Instant;

type Drive = PlainStation<OwnDrive>;

/// The data of what comes back; a short acknowledgement has none.
fn ask(drive: &mut Drive, now: &mut Instant, sap: Option<u8>, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
    let request = DataTelegram {
        format: DataTelegram::customary_format(dsap, ssap, data),
        da: drive.address(),
        sa: Address::from_octet(2),
        dsap,
        ssap,
        fc: FunctionCode::request(Service::SrdHigh, FrameCount::First),
        data,
    };
    let mut buf = [0; 255];
    let octets = request.encode(&mut buf).unwrap();
    let Decoded::Telegram { telegram, .. } = decode(octets) else { panic!("{octets:02X?}") };
    drive.handle_telegram(*now, &telegram, &mut |_| {});
    *now = drive.poll_timeout().unwrap_or(*now);
    let mut reply = [0; MAX_TELEGRAM_LEN];
    let len = drive.poll_transmit(*now, &mut reply, &mut |_| {}).unwrap();
    match decode(&reply[..len]) {
        Decoded::Telegram { telegram: Telegram::Data(reply), .. } => reply.data.to_vec(),
        _short_acknowledgement => Vec::new(),
    }
}

/// Started as a master starts it.
fn started(now: &mut Instant) -> Drive {
    let mut drive = OwnDrive::station(Address::station(5).unwrap());
    ask(&mut drive, now, Some(61), &[0x80, 1, 1, 11, 0x4F, 0x44, 0]);
    ask(&mut drive, now, Some(62), profidrive::profibus::ppo::PpoType::Ppo1.configuration());
    drive
}

#[test]
fn whoever_shows_it_asks_for_its_inputs_and_values() {
    let mut now = Instant::from_millis(1);
    let mut drive = started(&mut now);
    let half = [&[0; 8][..], &[0x04, 0x7F, 0x20, 0]].concat();
    let shown = |drive: &Drive| {
        let mut shown = Vec::new();
        drive.description().unwrap().each_value(&mut |value| {
            shown.push((value.key, value.amount.number(), value.unit));
        });
        shown
    };
    assert_eq!(shown(&drive), [("speed", Some(0.0), "%")]);
    ask(&mut drive, &mut now, None, &half);
    assert_eq!(ask(&mut drive, &mut now, None, &half)[8..], half[8..]);
    assert_eq!(shown(&drive), [("speed", Some(50.0), "%")]);

    let mut inputs = Vec::new();
    drive.description().unwrap().each_input(&mut |input, level| inputs.push((input.name, level)));
    assert_eq!(inputs, [("locked", Level::Switch(false))]);
    drive.description_mut().unwrap().set_input(now, "locked", Level::Switch(true));
    ask(&mut drive, &mut now, None, &half);
    assert_eq!(ask(&mut drive, &mut now, None, &half)[8..], [0x04, 0x7F, 0, 0]);
    assert_eq!(shown(&drive), [("speed", Some(0.0), "%")]);
    drive.description_mut().unwrap().make_nominal(now);
    ask(&mut drive, &mut now, None, &half);
    assert_eq!(ask(&mut drive, &mut now, None, &half)[8..], half[8..]);
}

#[test]
fn a_client_reads_and_writes_parameters_of_a_drive_of_ones_own() {
    let mut now = Instant::from_millis(1);
    let mut drive = started(&mut now);

    let mut client = PkwClient::new(Profile::PROFIDRIVE);
    let mut run = |job: Job| {
        client.submit(now, job).unwrap();
        loop {
            let pkw = client.output().to_octets();
            let inputs = ask(&mut drive, &mut now, None, &[&pkw[..], &[0x04, 0x7F, 0x12, 0x34]].concat());
            assert_eq!(inputs.len(), 12);
            client.handle_input(now, Pkw::from_octets(inputs[..8].try_into().unwrap()));
            if let Some(outcome) = client.poll_outcome() {
                break outcome.result;
            }
        }
    };
    let pnu = |number| Pnu::new(number).unwrap();
    let value = |value| Ok(Reply::Value(value));
    let refused = |number| Err(PkwError::Refused(ErrorCode::Known(number)));
    assert_eq!(run(Job::read(pnu(100))), value(Value::Word(10)));
    assert!(run(Job::write(pnu(100), Value::Word(30))).is_ok());
    assert_eq!(run(Job::read(pnu(100))), value(Value::Word(30)));
    assert_eq!(run(Job::write(pnu(100), Value::Word(61))), refused(ErrorNumber::LimitExceeded));
    assert_eq!(run(Job::write(pnu(100), Value::Double(1))), refused(ErrorNumber::WrongDataType));
    assert_eq!(run(Job::read_element(pnu(200), Subindex(2))), value(Value::Double(300)));
    assert!(run(Job::write_element(pnu(200), Subindex(2), Value::Double(350))).is_ok());
    assert_eq!(run(Job::read_element(pnu(200), Subindex(2))), value(Value::Double(350)));
    assert_eq!(run(Job::read_element(pnu(200), Subindex(3))), refused(ErrorNumber::FaultySubindex));
    assert_eq!(run(Job::read(pnu(1004))), refused(ErrorNumber::IllegalParameterNumber));
}
