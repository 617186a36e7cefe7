//! A drive of the profile on the bus, in virtual time: every PPO, the words of the profile, the parameter channel.

use profidrive::client::{
    ErrorCode, Job, PkwClient, PkwError, PpoClient, PpoGoal, PpoGoalError, PpoLimits, Profile, Reply,
};
use profidrive::devices::BusDrive as _;
use profidrive::devices::ag03::param::{Pnu, Subindex, Value};
use profidrive::devices::ppo_drive::State;
use profidrive::devices::ppo_drive::profibus::{CONFIGURATIONS, Family, IDENT_NUMBER, PpoDrive, PpoOnly};
use profidrive::devices::ppo_drive::table::{Fields, Row, Table};
use profidrive::profibus::dp::{Description, Fixed, State as DpState};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, Sap, Service, Telegram,
};
use profidrive::profibus::pkw::ErrorNumber;
use profidrive::profibus::ppo::{Pkw, PpoType};
use profidrive::time::{BaudRate, Instant};
use proptest::prelude::*;

type Drive = PpoDrive<PpoOnly<Fixed<'static>>>;

/// STW: OFF1, ON, run, and bit 10 each.
const OFF1: u16 = 0x047E;
const RUN: u16 = 0x047F;

struct Rig {
    drive: Drive,
    now: Instant,
    kind: PpoType,
    said: Vec<String>,
}

impl Rig {
    fn new(kind: PpoType, only: Option<PpoType>, table: Table) -> Self {
        let description = Description { ident: IDENT_NUMBER, ..Description::PLAIN };
        let application = PpoOnly { inner: Fixed { configurations: CONFIGURATIONS, ..Fixed::PLAIN }, only };
        let now = Instant::from_millis(1);
        let address = Address::station(7).unwrap();
        let drive = PpoDrive::new(address, BaudRate::K500, (description, application), table, now).unwrap();
        Self { drive, now, kind, said: Vec::new() }
    }

    /// In Data_Exchange.
    fn started(kind: PpoType, table: Table) -> Self {
        let mut rig = Self::new(kind, None, table);
        rig.start();
        assert_eq!(rig.drive.slave().state(), DpState::DataExch, "{kind}");
        rig
    }

    fn start(&mut self) {
        let [high, low] = IDENT_NUMBER.to_be_bytes();
        self.ask(Some(61), &[0x88, 10, 10, 11, high, low, 0]);
        self.ask(Some(62), self.kind.configuration());
    }

    /// The data of what comes back; a short acknowledgement has none.
    fn ask(&mut self, sap: Option<u8>, data: &[u8]) -> Vec<u8> {
        let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
        let request = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, data),
            da: self.drive.address(),
            sa: Address::from_octet(2),
            dsap,
            ssap,
            fc: FunctionCode::request(Service::SrdHigh, FrameCount::First),
            data,
        };
        let mut buf = [0; 255];
        let octets = request.encode(&mut buf).unwrap();
        let Decoded::Telegram { telegram, .. } = decode(octets) else { panic!("{octets:02X?}") };
        let said = &mut self.said;
        let mut news = |event: profidrive::devices::StationEvent| said.push(event.to_string());
        self.drive.handle_telegram(self.now, &telegram, &mut news);
        self.now = Instant::from_nanos(self.now.as_nanos() + 50_000);
        let mut reply = [0; MAX_TELEGRAM_LEN];
        let len = self.drive.poll_transmit(self.now, &mut reply, &mut news);
        match len.map(|len| decode(&reply[..len])) {
            Some(Decoded::Telegram { telegram: Telegram::Data(reply), .. }) => reply.data.to_vec(),
            _short_acknowledgement => Vec::new(),
        }
    }

    /// Exchanges every millisecond for so long; the last inputs.
    fn exchange(&mut self, millis: u32, pkw: Pkw, pzd: &[u16]) -> Vec<u8> {
        let mut outputs = if self.kind.has_pkw() { pkw.to_octets().to_vec() } else { Vec::new() };
        outputs.extend(pzd.iter().flat_map(|word| word.to_be_bytes()));
        outputs.resize(self.kind.len(), 0);
        let mut inputs = Vec::new();
        for _ in 0..millis {
            self.now = Instant::from_nanos(self.now.as_nanos() + 950_000);
            let said = &mut self.said;
            self.drive.handle_timeout(self.now, &mut |event| said.push(event.to_string()));
            inputs = self.ask(None, &outputs);
        }
        inputs
    }

    /// ZSW, actual value and the words behind after so long.
    fn run(&mut self, millis: u32, pzd: &[u16]) -> Vec<u16> {
        let inputs = self.exchange(millis, Pkw::ZERO, pzd);
        assert_eq!(inputs.len(), self.kind.len());
        let pkw = if self.kind.has_pkw() { 8 } else { 0 };
        inputs[pkw..].as_chunks().0.iter().map(|word| u16::from_be_bytes(*word)).collect()
    }

    fn job(&mut self, job: Job) -> Result<Reply, PkwError> {
        let mut client = PkwClient::new(Profile::PROFIDRIVE);
        client.submit(self.now, job).unwrap();
        loop {
            let inputs = self.exchange(1, client.output(), &[OFF1, 0]);
            client.handle_input(self.now, Pkw::from_octets(inputs[..8].try_into().unwrap()));
            if let Some(outcome) = client.poll_outcome() {
                return outcome.result;
            }
        }
    }
}

#[cfg(feature = "parameters")]
fn example() -> Table {
    Table::from_toml(include_str!("../../examples/ppo_drive.toml")).unwrap()
}

#[test]
fn each_ppo_commands_the_drive_and_shows_its_words() {
    for kind in [PpoType::Ppo1, PpoType::Ppo2, PpoType::Ppo3, PpoType::Ppo4, PpoType::Ppo5] {
        let mut rig = Rig::started(kind, Table::profile());
        assert_eq!(rig.drive.ppo(), Some(kind));
        // Bits 8 and 9 always at rest; S1 with OFF2, S2, S3 with enable = 0, S4.
        assert_eq!(rig.run(5, &[0x0400, 0])[..2], [0x0340, 0], "{kind}");
        assert_eq!(rig.run(5, &[OFF1, 0])[..2], [0x0331, 0], "{kind}");
        assert_eq!(rig.run(5, &[RUN & !0x0008, 0])[..2], [0x0333, 0], "{kind}");
        // The ramp of 10 s: a tenth of 4000h after a second.
        let words = rig.run(1000, &[RUN, 0x4000]);
        assert_eq!(words[0], 0x0337, "{kind}");
        assert!(words[1].abs_diff(0x4000 / 10) < 30, "{kind}: {words:04X?}");
        assert_eq!(words.len(), kind.pzd_words());
    }
}

#[test]
fn without_control_by_plc_the_command_before_holds() {
    let mut rig = Rig::started(PpoType::Ppo3, Table::profile());
    rig.run(5, &[OFF1, 0]);
    let before = rig.run(500, &[RUN, 0x4000]);
    let after = rig.run(500, &[0, 0]);
    assert!(after[0] == before[0] && after[1] > before[1], "{before:04X?} {after:04X?}");
}

#[test]
fn a_watchdog_is_a_fault_that_is_acknowledged() {
    let mut rig = Rig::started(PpoType::Ppo3, Table::profile());
    rig.run(5, &[OFF1, 0]);
    rig.run(100, &[RUN, 0x4000]);
    // 10 x 10 x 10 ms.
    rig.now = Instant::from_nanos(rig.now.as_nanos() + 1_100_000_000);
    rig.drive.handle_timeout(rig.now, &mut |_| {});
    assert_eq!(
        (rig.drive.slave().state(), rig.drive.drive().status().state),
        (DpState::WaitPrm, State::Fault)
    );
    rig.start();
    assert_eq!(rig.run(5, &[RUN, 0])[0] & 0x004F, 0x0008);
    assert_eq!(rig.run(5, &[RUN | 0x0080, 0])[0] & 0x004F, 0x0040);
    assert_eq!(rig.run(5, &[OFF1, 0])[0] & 0x004F, 0x0001);
}

#[test]
fn another_ppo_than_the_one_it_is_set_to_is_refused_with_its_cure() {
    let mut rig = Rig::new(PpoType::Ppo2, Some(PpoType::Ppo1), Table::profile());
    rig.start();
    assert_eq!(rig.drive.slave().state(), DpState::WaitPrm);
    let said = rig.said.join("\n");
    assert!(said.contains("choose the PPO it was started with"), "{said}");
}

#[test]
fn parameters_of_the_profile_without_a_choice_say_so() {
    let mut rig = Rig::started(PpoType::Ppo1, Table::profile());
    let pnu = |number| Pnu::new(number).unwrap();
    let word = |word| Ok(Reply::Value(Value::Word(word)));
    let refused = |number| Err(PkwError::Refused(ErrorCode::Known(number)));
    for (number, value, other) in [(917, 0, 1), (927, 1, 0), (928, 1, 0)] {
        assert_eq!(rig.job(Job::read(pnu(number))), word(value), "{number}");
        assert!(rig.job(Job::write(pnu(number), Value::Word(value))).is_ok(), "{number}");
        let wrong = rig.job(Job::write(pnu(number), Value::Word(other)));
        assert_eq!(wrong, refused(ErrorNumber::LimitExceeded), "{number}");
    }
    assert_eq!(rig.job(Job::read(pnu(965))), word(0x0314));
    assert_eq!(rig.job(Job::read(pnu(971))), word(0));
    assert!(rig.job(Job::write(pnu(971), Value::Word(1))).is_ok());
    assert_eq!(rig.job(Job::read(pnu(971))), word(0), "done");
}

#[test]
fn pages_and_sub_indexes_are_those_of_the_family() {
    let array = |line, pnu: &'static str, default| {
        let fields =
            [("pnu", pnu), ("name", "array"), ("type", "uint16"), ("elements", "3"), ("default", default)];
        Row::of(&Fields::new(line, fields)).unwrap()
    };
    let rows = || {
        [
            array(1, "700", "1 2 3"),
            array(2, "856", "4 5 6"),
            array(3, "2700", "7 8 9"),
            array(4, "2856", "10 11 12"),
        ]
    };
    // PKE and IND of the job, then PKE and value of the reply.
    let asked = |family, pke: u16, ind: u16, pwe: u16| {
        let mut rig = Rig::started(PpoType::Ppo1, Table::new(rows()).unwrap());
        rig.drive = rig.drive.of_family(family);
        let words = [pke, ind, 0, pwe];
        let octets: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
        let reply = rig.exchange(20, Pkw::from_octets(octets.try_into().unwrap()), &[OFF1, 0]);
        let untouched = rig.drive.read_parameter(856, Some(3)).unwrap().bits() == 6;
        (u16::from_be_bytes([reply[0], reply[1]]), u16::from_be_bytes([reply[6], reply[7]]), untouched)
    };
    let (read, write) = (0x6000, 0x7000);
    for (family, pke, ind, pwe, expected) in [
        (Family::Micromaster, read | 700, 0x0200, 0, (0x42BC, 3, true)),
        (Family::Micromaster, read | 700, 0x0280, 0, (0x42BC, 9, true)),
        (Family::Micromaster, write | 856, 0x0280, 77, (0x4358, 77, true)),
        (Family::Micromaster, read | 700, 0x0300, 0, (0x72BC, 3, true)),
        (Family::Micromaster, read | 700, 0x0290, 0, (0x72BC, 0, true)),
        (Family::Profile, read | 700, 0x0200, 0, (0x42BC, 2, true)),
        (Family::Profile, write | 856, 0x0380, 77, (0x7358, 0, true)),
        (Family::Profile, write | 856, 0x0300, 77, (0x4358, 77, false)),
        // Jobs that write and keep.
        (Family::Micromaster, 0xC000 | 856, 0x0280, 78, (0x4358, 78, true)),
        (Family::Profile, 0xC000 | 856, 0x0300, 78, (0x7358, 18, true)),
        (Family::Simodrive611u, read | 700, 0x0002, 0, (0x42BC, 3, true)),
        (Family::Simodrive611u, read | 700, 0x0300, 0, (0x42BC, 1, true)),
    ] {
        assert_eq!(asked(family, pke, ind, pwe), expected, "{family:?} {pke:04X} {ind:04X}");
    }
}

#[cfg(feature = "parameters")]
#[test]
fn the_parameter_channel_reads_writes_and_describes_the_table() {
    let mut rig = Rig::started(PpoType::Ppo1, example());
    let pnu = |number| Pnu::new(number).unwrap();
    let word = |word| Ok(Reply::Value(Value::Word(word)));
    let double = |double| Ok(Reply::Value(Value::Double(double)));
    let refused = |number| Err(PkwError::Refused(ErrorCode::Known(number)));
    assert_eq!(rig.job(Job::read(pnu(2))), word(20));
    assert!(rig.job(Job::write(pnu(2), Value::Word(5))).is_ok());
    assert_eq!((rig.job(Job::read(pnu(2))), rig.drive.drive().settings().ramp_up), (word(5), 0.5));
    assert_eq!(rig.job(Job::write(pnu(2), Value::Word(6501))), refused(ErrorNumber::LimitExceeded));
    assert_eq!(rig.job(Job::write(pnu(2), Value::Double(5))), refused(ErrorNumber::WrongDataType));
    assert_eq!(rig.job(Job::write(pnu(10), Value::Word(5))), refused(ErrorNumber::NotChangeable));
    assert_eq!(rig.job(Job::read(pnu(999))), refused(ErrorNumber::IllegalParameterNumber));
    assert_eq!(
        rig.job(Job::write(pnu(4), Value::Double(f32::NAN.to_bits()))),
        refused(ErrorNumber::LimitExceeded)
    );
    assert!(rig.job(Job::write(pnu(4), Value::Double(50.5_f32.to_bits()))).is_ok());
    assert_eq!(rig.drive.drive().settings().load, 50.5);
    // Arrays count from 1.
    assert_eq!(rig.job(Job::read_element(pnu(30), Subindex(3))), double(70_000));
    assert_eq!(rig.job(Job::read_element(pnu(30), Subindex(0))), refused(ErrorNumber::FaultySubindex));
    assert_eq!(rig.job(Job::read_element(pnu(30), Subindex(4))), refused(ErrorNumber::FaultySubindex));
    assert!(rig.job(Job::write_element(pnu(30), Subindex(1), Value::Double(7))).is_ok());
    assert_eq!(rig.job(Job::read_element(pnu(30), Subindex(1))), double(7));
    assert_eq!(rig.job(Job::read_element(pnu(2), Subindex(1))), refused(ErrorNumber::NoArray));
    // Those of the profile.
    assert_eq!((rig.job(Job::read(pnu(918))), rig.job(Job::read(pnu(929)))), (word(7), word(1)));
    assert_eq!(rig.job(Job::read(pnu(967))), word(OFF1));
    assert_eq!(rig.job(Job::read_element(pnu(980), Subindex(1))), word(1));
    // Descriptions: identifier (array, factor 1, int32), elements, limits, factor, name, whole.
    let mut describe = |number, element| rig.job(Job::description(pnu(number), Subindex(element)));
    let described = |bits: u32| Ok(Reply::Description(bits));
    assert_eq!(describe(30, 1), described(0x4104));
    assert_eq!(describe(30, 2), described(3));
    assert_eq!(describe(30, 8), described(100_000));
    assert_eq!(describe(2, 3), described(0.1_f32.to_bits()));
    assert_eq!(describe(10, 1), described(0x0303));
    assert_eq!(describe(2, 6), refused(ErrorNumber::NameNotReadable));
    assert_eq!(describe(2, 0), refused(ErrorNumber::DatumNotReadable));
    assert_eq!(describe(2, 13), refused(ErrorNumber::FaultySubindex));
    // A fault that is raised, its number, and the buffer cleared.
    assert!(rig.job(Job::write(pnu(20), Value::Word(77))).is_ok());
    assert_eq!(rig.job(Job::read_element(pnu(947), Subindex(1))), word(77));
    assert_eq!(rig.run(1, &[OFF1, 0])[0] & 0x0008, 0x0008);
    rig.run(3, &[OFF1 | 0x0080, 0]);
    assert_eq!(rig.job(Job::read_element(pnu(945), Subindex(9))), word(77));
    assert_eq!(rig.job(Job::read(pnu(952))), word(1));
    assert!(rig.job(Job::write(pnu(952), Value::Word(0))).is_ok());
    assert_eq!(rig.job(Job::read_element(pnu(945), Subindex(9))), word(0));
}

#[cfg(feature = "parameters")]
#[test]
fn words_of_process_data_show_and_set_the_parameters_assigned() {
    let mut rig = Rig::started(PpoType::Ppo2, example());
    let assign = |at: u8, number: u16, value: u16| {
        Job::write_element(Pnu::new(number).unwrap(), Subindex(at), Value::Word(value))
    };
    // Shown: the ramp-up time, then the load, a double word, in two words. Set: the ramp-down time.
    for (at, number, value) in [(1, 916, 2), (2, 916, 4), (3, 916, 4), (1, 915, 3)] {
        assert!(rig.job(assign(at, number, value)).is_ok());
    }
    let refused = |number| Err(PkwError::Refused(ErrorCode::Known(number)));
    assert_eq!(rig.job(assign(4, 916, 2000)), refused(ErrorNumber::LimitExceeded), "no such parameter");
    // A double word has its two words, too.
    assert!(rig.job(assign(2, 915, 4)).is_ok() && rig.job(assign(3, 915, 4)).is_ok());
    let load = 25.0_f32.to_bits();
    let words = rig.run(5, &[OFF1, 0, 42, (load >> 16) as u16, load as u16]);
    assert_eq!(rig.drive.drive().settings().load, 25.0);
    assert_eq!(words[3..5], [(load >> 16) as u16, load as u16]);
    let ten = 10.0_f32.to_bits();
    let words = rig.run(5, &[OFF1, 0, 42, (ten >> 16) as u16, ten as u16]);
    let [high, low] = [10.0_f32.to_bits() >> 16, 10.0_f32.to_bits() & 0xFFFF].map(|half| half as u16);
    assert_eq!(words[2..], [20, high, low, 0]);
    assert_eq!(rig.drive.drive().settings().ramp_down, 4.2);
}

#[cfg(feature = "parameters")]
#[test]
fn a_word_that_its_parameter_refuses_is_told_once_until_it_takes_one() {
    let mut rig = Rig::started(PpoType::Ppo2, example());
    let assign =
        |at: u8, value: u16| Job::write_element(Pnu::new(915).unwrap(), Subindex(at), Value::Word(value));
    // The ramp-up time, to 6500; a parameter that can only be read.
    for (at, number) in [(1, 2), (2, 10)] {
        assert!(rig.job(assign(at, number)).is_ok());
    }
    // The last one was told with the words of the jobs.
    rig.run(50, &[OFF1, 0, 7000, 5, 5]);
    rig.run(50, &[OFF1, 0, 7001, 6, 6]);
    let not_set =
        |rig: &Rig| rig.said.iter().filter(|said| said.contains("is not set")).cloned().collect::<Vec<_>>();
    let said = not_set(&rig);
    assert_eq!(said.len(), 2, "{:?}", rig.said);
    let told =
        |parts: [&str; 2]| said.iter().filter(|said| parts.iter().all(|part| said.contains(part))).count();
    for parts in [
        ["process data word 3 (7000) is not set in PNU 2", "name another parameter in PNU 915.1"],
        ["process data word 4 (5) is not set in PNU 10", "read-only"],
    ] {
        assert_eq!(told(parts), 1, "{parts:?}: {said:?}");
    }
    assert_eq!(rig.drive.drive().settings().ramp_up, 0.0, "as the words of the jobs have it");
    rig.run(5, &[OFF1, 0, 30, 0, 0]);
    rig.run(5, &[OFF1, 0, 7000, 0, 0]);
    assert_eq!((not_set(&rig).len(), rig.drive.drive().settings().ramp_up), (3, 3.0));
}

/// The client over this drive, until its goal is over.
fn pursue(rig: &mut Rig, client: &mut PpoClient, goal: PpoGoal) -> Result<i16, PpoGoalError> {
    client.pursue(rig.now, goal);
    loop {
        rig.now = Instant::from_nanos(rig.now.as_nanos() + 950_000);
        rig.drive.handle_timeout(rig.now, &mut |_| {});
        let inputs = rig.ask(None, client.outputs(&mut [0; PpoClient::MOST]));
        assert!(client.handle_inputs(rig.now, &inputs));
        if let Some(outcome) = client.poll_outcome() {
            return outcome.result;
        }
    }
}

#[test]
fn the_client_runs_stops_and_acknowledges_a_drive_of_each_ppo() {
    for kind in [PpoType::Ppo1, PpoType::Ppo2, PpoType::Ppo3, PpoType::Ppo4, PpoType::Ppo5] {
        let mut rig = Rig::started(kind, Table::profile());
        let mut client = PpoClient::new(kind, Profile::PROFIDRIVE, PpoLimits::default());
        assert_eq!(pursue(&mut rig, &mut client, PpoGoal::Enable), Ok(0), "{kind}");
        assert_eq!(rig.drive.drive().status().state, State::Operation);
        let speed = pursue(&mut rig, &mut client, PpoGoal::Run(-0x1000)).unwrap();
        assert!((i32::from(speed) + 0x1000).abs() < 0x200, "{kind}: {speed}");
        rig.drive.raise_fault(rig.now, 77);
        let fault = pursue(&mut rig, &mut client, PpoGoal::Run(0x1000));
        assert_eq!((fault, rig.drive.drive().faults().number(1)), (Err(PpoGoalError::Fault), Some(77)));
        assert!(pursue(&mut rig, &mut client, PpoGoal::Acknowledge).is_ok(), "{kind}");
        assert!(pursue(&mut rig, &mut client, PpoGoal::Run(0x0800)).is_ok(), "{kind}");
        assert!(pursue(&mut rig, &mut client, PpoGoal::Disable).is_ok(), "{kind}");
        assert_eq!(rig.drive.drive().status().state, State::ReadyToSwitchOn, "{kind}");
    }
}

#[cfg(feature = "parameters")]
#[test]
fn the_examples_say_the_same() {
    let csv = Table::from_csv(include_str!("../../examples/ppo_drive.csv")).unwrap();
    assert!(example().rows().eq(csv.rows()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whatever_a_master_sends_a_drive_answers_in_its_ppo(
        kind in 0..5_usize,
        exchanges in proptest::collection::vec((proptest::collection::vec(any::<u8>(), 0..32), 0..20_u32), 0..60),
    ) {
        let mut rig = Rig::started(PpoType::ALL[kind], Table::profile());
        for (octets, millis) in exchanges {
            let lost = octets.len() != rig.kind.len();
            let inputs = rig.ask(None, &octets);
            if lost && rig.drive.slave().state() != DpState::DataExch {
                rig.start();
            } else if !lost {
                prop_assert_eq!(inputs.len(), rig.kind.len());
            }
            rig.exchange(millis, Pkw::ZERO, &[u16::from_be_bytes([octets.first().copied().unwrap_or(0), 0x7F]), 0x4000]);
        }
    }
}

/// What is told of these control words, each for some cycles, with the setpoint 1000h.
fn told(words: &'static [u16]) -> Box<dyn FnOnce() -> Vec<String>> {
    Box::new(move || {
        let mut rig = Rig::started(PpoType::Ppo3, Table::profile());
        rig.said.clear();
        words.iter().for_each(|word| _ = rig.run(20, &[*word, 0x1000]));
        rig.said
    })
}

#[test]
fn what_it_says_of_control_words() {
    crate::sentences::compare(
        "Control word of the profile",
        vec![
            ("V-01", "047F at once, without OFF1 before", told(&[0x047F])),
            ("V-02", "007F: bit 10 is missing", told(&[OFF1, 0x007F])),
            ("V-03", "0000 while the drive turns: a PLC in STOP", told(&[OFF1, RUN, 0])),
            ("V-04", "047E and 047F with their octets exchanged", told(&[0x7E04, 0x7F04])),
            ("V-05", "inching before operation", told(&[OFF1, 0x057E])),
            ("V-06", "OFF2, then 047F", told(&[OFF1, 0x047C, 0x047F])),
        ],
    );
}
