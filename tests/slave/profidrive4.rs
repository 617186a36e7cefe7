//! A drive of PROFIdrive 4 on the bus, in virtual time: telegrams, states, parameters by record 47 over MS1 and MS2.

use profidrive::devices::BusDrive as _;
use profidrive::devices::StationEvent;
use profidrive::devices::ppo_drive::State;
use profidrive::devices::profidrive4::profibus::{
    Family, IDENT_NUMBER, ProfidriveDevice, Signal, Telegram, TelegramOnly,
};
use profidrive::devices::profidrive4::{Fault, Setting};
use profidrive::face::{Surroundings as _, Why as _};
use profidrive::profibus::dp::{Description, Fixed, State as DpState};
use profidrive::profibus::dpv1::{Identification, Ms2Offer, Offer};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, Sap, Service, Telegram as Frame,
};
use profidrive::time::{BaudRate, Instant};

/// STW1: OFF1, and run.
const OFF1: u16 = 0x047E;
const RUN: u16 = 0x047F;
const OWNER: u8 = 2;
const TOOL: u8 = 3;

struct Rig {
    drive: ProfidriveDevice<TelegramOnly<Fixed<'static>>>,
    now: Instant,
    telegram: &'static Telegram,
    toggle: bool,
    said: Vec<String>,
}

fn configuration(telegram: &Telegram) -> Vec<u8> {
    let (outputs, inputs) = telegram.lengths();
    let length = |octets: usize| 0xC0 | u8::try_from(octets / 2 - 1).unwrap();
    let [high, low] = telegram.number.to_be_bytes();
    let pkw = if telegram.has_pkw { 8 } else { 0 };
    let signals = [0xC3, length(outputs - pkw), length(inputs - pkw), 0xFD, high, low];
    [if telegram.has_pkw { &[0xF3][..] } else { &[] }, &signals].concat()
}

impl Rig {
    /// In Data_Exchange.
    fn started(number: u16) -> Self {
        Self::started_with(Telegram::numbered(number).unwrap())
    }

    fn started_with(telegram: &'static Telegram) -> Self {
        let configuration: &'static [u8] = configuration(telegram).leak();
        let all = Telegram::ALL.iter().filter(|telegram| telegram.number != 999).chain([telegram]);
        let all = all.map(|telegram| &*self::configuration(telegram).leak());
        let configurations = all.collect::<Vec<_>>().leak();
        let application = Fixed { configurations, ..Fixed::PLAIN };
        let description =
            Description { ident: IDENT_NUMBER, dpv1_status: Some([0xFB, 0xFF, 0xFF]), ..Description::PLAIN };
        let ms2 = Ms2Offer { connections: 1, max_data: 240, max_initiate: 52, min_send_timeout: 10 };
        let offer = Offer { ms1: Some(240), ms2: Some(ms2), ..Offer::NONE };
        let drive = ProfidriveDevice::new(
            Address::station(7).unwrap(),
            BaudRate::K500,
            (description, TelegramOnly { inner: application, only: None }),
            (offer, Identification { profile_id: 0x3A00, ..Identification::PLAIN }),
            Family::new(&[]).unwrap(),
            Instant::from_millis(1),
        );
        let mut rig = Self { drive, now: Instant::from_millis(1), telegram, toggle: false, said: Vec::new() };
        let [high, low] = IDENT_NUMBER.to_be_bytes();
        rig.ask(OWNER, Some((61, 62)), &[0x88, 10, 10, 11, high, low, 0, 0x80, 0, 0]);
        rig.ask(OWNER, Some((62, 62)), configuration);
        assert_eq!(rig.drive.slave().state(), DpState::DataExch, "telegram {}", telegram.number);
        rig
    }

    /// The data of what comes back; a short acknowledgement has none.
    fn ask(&mut self, master: u8, saps: Option<(u8, u8)>, data: &[u8]) -> Vec<u8> {
        self.toggle = !self.toggle;
        let (dsap, ssap) = saps.map(|(dsap, ssap)| (Sap::new(dsap), Sap::new(ssap))).unwrap_or_default();
        let count = if self.toggle { FrameCount::Even } else { FrameCount::Odd };
        let request = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, data),
            da: self.drive.address(),
            sa: Address::from_octet(master),
            dsap,
            ssap,
            fc: FunctionCode::request(Service::SrdHigh, count),
            data,
        };
        let mut buf = [0; 255];
        let octets = request.encode(&mut buf).unwrap();
        let Decoded::Telegram { telegram, .. } = decode(octets) else { panic!("{octets:02X?}") };
        let said = &mut self.said;
        let mut news = |event: StationEvent| said.push(event.to_string());
        self.now = Instant::from_nanos(self.now.as_nanos() + 400_000);
        self.drive.handle_telegram(self.now, &telegram, &mut news);
        self.now = Instant::from_nanos(self.now.as_nanos() + 50_000);
        let mut reply = [0; MAX_TELEGRAM_LEN];
        let len = self.drive.poll_transmit(self.now, &mut reply, &mut news);
        match len.map(|len| decode(&reply[..len])) {
            Some(Decoded::Telegram { telegram: Frame::Data(reply), .. }) => reply.data.to_vec(),
            _short_acknowledgement => Vec::new(),
        }
    }

    /// Exchanges every half millisecond for so long; the last inputs.
    fn run(&mut self, millis: u32, words: &[u16]) -> Vec<u8> {
        let mut outputs: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
        outputs.resize(self.telegram.lengths().0, 0);
        let mut inputs = Vec::new();
        for _ in 0..2 * millis {
            inputs = self.ask(OWNER, None, &outputs);
        }
        inputs
    }

    fn value(&self, inputs: &[u8], signal: Signal) -> u32 {
        self.telegram.actual_value(inputs, signal).unwrap()
    }

    /// A request at SAP 51, polled.
    fn ms1(&mut self, data: &[u8]) -> Vec<u8> {
        assert_eq!(self.ask(OWNER, Some((51, 51)), data), [0_u8; 0]);
        self.ask(OWNER, Some((51, 51)), &[])
    }

    fn parameter(&mut self, request: &[u8]) -> Vec<u8> {
        let len = u8::try_from(request.len()).unwrap();
        let written = self.ms1(&[&[0x5F, 0, 47, len][..], request].concat());
        assert_eq!(written, [0x5F, 0, 47, len]);
        let read = self.ms1(&[0x5E, 0, 47, 240]);
        assert_eq!((&read[..3], usize::from(read[3])), (&[0x5E, 0, 47][..], read.len() - 4));
        read[4..].to_vec()
    }

    fn reasons(&self) -> Vec<&'static str> {
        let mut names = Vec::new();
        self.drive.each_reason(&mut |reason| names.push(reason.name));
        names
    }
}

#[test]
fn each_telegram_of_a_speed_drive_turns_the_shaft() {
    for telegram in Telegram::ALL.iter().filter(|telegram| {
        [Signal::NsollA, Signal::NsollB].iter().any(|speed| telegram.setpoints.contains(speed))
    }) {
        let mut rig = Rig::started(telegram.number);
        let pkw = if telegram.has_pkw { &[0; 4][..] } else { &[] };
        rig.run(5, &[pkw, &[OFF1, 0]].concat());
        let inputs = rig.run(1500, &[pkw, &[RUN, 0x2000]].concat());
        let shown = [(Signal::NistA, 0), (Signal::NistAGlatt, 0), (Signal::NistB, 16)];
        let shown =
            shown.iter().find_map(|(signal, shift)| Some(telegram.actual_value(&inputs, *signal)? >> shift));
        assert!((0x1FF0..=0x2010).contains(&shown.unwrap()), "telegram {}: {inputs:02X?}", telegram.number);
        assert_eq!(rig.drive.drive().status().state, State::Operation);
        let zsw = rig.value(&inputs, Signal::Zsw1);
        let of_profile = if telegram.number > 100 && telegram.number < 200 { 0x0337 } else { 0xEB37 };
        assert_eq!(zsw, of_profile, "telegram {}: {zsw:04X}", telegram.number);
    }
}

#[test]
fn the_signs_of_life_are_counted_and_watched() {
    let mut rig = Rig::started(2);
    rig.parameter(&[1, 2, 1, 1, 0x10, 1, 0x03, 0x9D, 0, 0, 6, 1, 0, 2]);
    assert_eq!(rig.drive.drive().settings().of(Setting::SignOfLifeFailures), 2.0);
    let mut life = 0;
    let mut own = Vec::new();
    for _ in 0..40 {
        life = life % 15 + 1;
        let mut outputs = [OFF1, 0, 0, life << 12].map(u16::to_be_bytes).concat();
        outputs.resize(8, 0);
        let inputs = rig.ask(OWNER, None, &outputs);
        own.push(rig.value(&inputs, Signal::Zsw2) >> 12);
        // An application cycle between two exchanges.
        rig.now = Instant::from_nanos(rig.now.as_nanos() + 1_000_000);
    }
    assert!(own.windows(2).skip(2).all(|two| two[1] == two[0] % 15 + 1), "{own:?}");
    let standing = |rig: &Rig| rig.drive.drive().standing_faults().next().map(|fault| fault.number);
    assert_eq!(standing(&rig), None);
    // It does not count on.
    for _ in 0..5 {
        rig.run(2, &[OFF1, 0, 0, life << 12]);
    }
    assert_eq!(standing(&rig), Some(Fault::SignOfLife.number()));
}

#[test]
fn v1_r88_v1_r90_v1_r91_parameters_over_ms1() {
    let mut rig = Rig::started(1);
    // Nothing was asked.
    assert_eq!(rig.ms1(&[0x5E, 0, 47, 240]), [0xDE, 0x80, 0xB5, 0]);
    assert_eq!(rig.parameter(&[7, 1, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0]), [7, 1, 1, 1, 6, 1, 0, 1]);
    // It was given once.
    assert_eq!(rig.ms1(&[0x5E, 0, 47, 240]), [0xDE, 0x80, 0xB5, 0]);
    let mixed = [4, 1, 0, 2, 0x10, 0, 0x03, 0x9A, 0, 0, 0x10, 0, 0, 1, 0, 0];
    assert_eq!(rig.parameter(&mixed), [4, 0x81, 0, 2, 6, 1, 0, 1, 0x44, 1, 0, 0]);
    assert!(
        rig.said.iter().any(|line| line.contains("PNU 1.0 of axis 0: error 00h, no such parameter")),
        "{:?}",
        rig.said
    );
    // Ramp-up of 2 s.
    assert_eq!(rig.parameter(&[5, 2, 1, 1, 0x10, 1, 0x04, 0x60, 0, 0, 8, 1, 0x40, 0, 0, 0]), [5, 2, 1, 1]);
    assert_eq!(rig.drive.drive().settings().of(Setting::RampUp), 2.0);
    assert!(rig.said.iter().any(|line| line == "record 47 changed PNU 1120"), "{:?}", rig.said);
    // Too short, another record, another slot.
    assert_eq!(rig.ms1(&[0x5F, 0, 47, 3, 1, 1, 1]), [0xDF, 0x80, 0xB7, 0]);
    assert_eq!(rig.ms1(&[0x5E, 0, 48, 240]), [0xDE, 0x80, 0xB0, 0]);
    assert_eq!(rig.ms1(&[0x5E, 2, 47, 240]), [0xDE, 0x80, 0xB2, 0]);
    // What was not fetched is gone with the owner.
    rig.ms1(&[0x5F, 0, 47, 10, 7, 1, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0]);
    let [high, low] = IDENT_NUMBER.to_be_bytes();
    rig.ask(OWNER, Some((61, 62)), &[0x40, 10, 10, 11, high, low, 0, 0x80, 0, 0]);
    rig.ask(OWNER, Some((61, 62)), &[0x88, 10, 10, 11, high, low, 0, 0x80, 0, 0]);
    rig.ask(OWNER, Some((62, 62)), &configuration(rig.telegram));
    assert_eq!(rig.ms1(&[0x5E, 0, 47, 240]), [0xDE, 0x80, 0xB5, 0]);
}

#[test]
fn v1_r88_v1_r92_parameters_and_identification_over_ms2_beside_ms1() {
    let mut rig = Rig::started(1);
    let initiate = [0x57, 0, 0, 0, 0, 0x64, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];
    assert_eq!(rig.ask(TOOL, Some((49, 50)), &initiate), [0_u8; 0]);
    let granted = rig.ask(TOOL, Some((49, 50)), &[]);
    let [0x56, sap, ..] = granted[..] else { panic!("{granted:02X?}") };
    assert_eq!(rig.ask(TOOL, Some((sap, 50)), &[])[0], 0x57);
    let mut ms2 = |data: &[u8]| {
        assert_eq!(rig.ask(TOOL, Some((sap, 50)), data), [0_u8; 0]);
        rig.ask(TOOL, Some((sap, 50)), &[])
    };
    // The description of PNU 930: 46 octets.
    assert_eq!(ms2(&[0x5F, 1, 47, 10, 9, 1, 1, 1, 0x20, 0, 0x03, 0xA2, 0, 0]), [0x5F, 1, 47, 10]);
    let read = ms2(&[0x5E, 1, 47, 240]);
    assert_eq!((read.len(), &read[4..10]), (4 + 6 + 46, &[9, 1, 1, 1, 0x0A, 46][..]));
    // I&M0: a drive of the profile.
    assert_eq!(ms2(&[0x5F, 0, 255, 4, 8, 0, 0xFD, 0xE8]), [0x5F, 0, 255, 4]);
    let read = ms2(&[0x5E, 0, 255, 240]);
    assert_eq!((read.len(), &read[4 + 4 + 56..][..2]), (4 + 68, &[0x3A, 0][..]));
    // What one asks the other does not fetch.
    assert_eq!(ms2(&[0x5F, 0, 47, 10, 7, 1, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0])[0], 0x5F);
    assert_eq!(rig.ms1(&[0x5E, 0, 47, 240]), [0xDE, 0x80, 0xB5, 0]);
    assert_eq!(rig.parameter(&[8, 1, 1, 1, 0x10, 0, 0, 1, 0, 0]), [8, 0x81, 1, 1, 0x44, 1, 0, 0]);
    rig.ask(TOOL, Some((sap, 50)), &[0x5E, 0, 47, 240]);
    assert_eq!(rig.ask(TOOL, Some((sap, 50)), &[])[4..], [7, 1, 1, 1, 6, 1, 0, 1]);
}

#[test]
fn what_is_stored_is_there_after_a_reset_and_the_rest_is_not() {
    let mut rig = Rig::started(1);
    let set = |rig: &mut Rig, pnu: u16, value: &[u8]| {
        let [p1, p0] = pnu.to_be_bytes();
        rig.parameter(&[&[5, 2, 1, 1, 0x10, 1, p1, p0, 0, 0][..], value].concat())
    };
    let up = |rig: &Rig| rig.drive.drive().settings().of(Setting::RampUp);
    assert_eq!(set(&mut rig, 1120, &[8, 1, 0x40, 0, 0, 0]), [5, 2, 1, 1]);
    assert_eq!(set(&mut rig, 971, &[6, 1, 0, 1]), [5, 2, 1, 1]);
    assert_eq!(set(&mut rig, 1120, &[8, 1, 0x40, 0x80, 0, 0]), [5, 2, 1, 1]);
    assert_eq!(up(&rig), 4.0);
    assert_eq!(set(&mut rig, 972, &[6, 1, 0, 1]), [5, 2, 1, 1]);
    assert_eq!(up(&rig), 2.0);
    assert_eq!(set(&mut rig, 976, &[6, 1, 0, 1]), [5, 2, 1, 1]);
    assert_eq!(up(&rig), 1.0);
    // Not while it is switched on.
    rig.run(5, &[OFF1, 0]);
    rig.run(5, &[RUN, 0]);
    assert_eq!(set(&mut rig, 976, &[6, 1, 0, 1])[4..], [0x44, 1, 0, 0x11]);
}

#[test]
fn faults_are_provoked_buffered_and_acknowledged_and_why_names_them() {
    let mut rig = Rig::started(352);
    assert_eq!(
        rig.reasons(),
        [
            "OutputsZero",
            "NotByPlc",
            "Off2",
            "Off3",
            "Inhibited",
            "NotEnabled",
            "RampDisabled",
            "RampFrozen",
            "SetpointDisabled"
        ]
    );
    rig.run(5, &[OFF1, 0]);
    rig.run(1500, &[RUN, 0x2000]);
    assert_eq!(rig.drive.is_moving(), Some(true));
    rig.drive.provoke(rig.now, "overload").unwrap();
    assert!(rig.drive.provoke(rig.now, "no-such-fault").is_err());
    let inputs = rig.run(8000, &[RUN, 0x2000]);
    assert_eq!(rig.value(&inputs, Signal::FaultCode), u32::from(Fault::Overload.number()));
    assert_eq!(rig.value(&inputs, Signal::Zsw1) & 0x4F, 0x48, "fault, S1");
    assert_eq!(rig.reasons(), ["Fault", "Inhibited"]);
    assert!(rig.said.iter().any(|line| line.starts_with("fault 2: the motor gave more")), "{:?}", rig.said);
    rig.run(5, &[OFF1 | 0x80, 0]);
    let inputs = rig.run(5, &[OFF1, 0]);
    assert_eq!(rig.value(&inputs, Signal::Zsw1) & 0x4F, 0x01);
    rig.drive.set_input(
        rig.now,
        "emergency_stop_released",
        profidrive::face::surroundings::Level::Switch(false),
    );
    rig.run(5, &[RUN, 0x2000]);
    assert_eq!(rig.reasons()[0], "EmergencyStop");
}

#[test]
fn without_a_master_it_brakes_and_goes_to_fault() {
    let mut rig = Rig::started(1);
    rig.run(5, &[OFF1, 0]);
    rig.run(1500, &[RUN, 0x4000]);
    // The watchdog of a second ends the exchange.
    for _ in 0..15 {
        rig.now = Instant::from_nanos(rig.now.as_nanos() + 100_000_000);
        let said = &mut rig.said;
        rig.drive.handle_timeout(rig.now, &mut |event| said.push(event.to_string()));
    }
    let status = rig.drive.drive().status();
    assert_eq!((status.state, status.fault, status.stands), (State::SwitchingOnInhibited, true, true));
    assert_eq!(rig.drive.drive().standing_faults().next().unwrap().number, Fault::Communication.number());
}

#[test]
fn another_telegram_than_the_only_one_is_refused() {
    let mut rig = Rig::started(1);
    let [high, low] = IDENT_NUMBER.to_be_bytes();
    rig.ask(OWNER, Some((61, 62)), &[0x88, 10, 10, 11, high, low, 0, 0x80, 0, 0]);
    rig.ask(OWNER, Some((62, 62)), &[0xC3, 0xC1, 0xC1, 0xFD, 0x00, 0x14]);
    assert_ne!(rig.drive.slave().state(), DpState::DataExch);
}

/// The words of telegram 110 with this STW1, SATZANW, POS_STW and target at 6 000 000 LU/min.
fn words_of_110(stw1: u16, choice: u16, pos_stw: u16, target: u16) -> [u16; 12] {
    [stw1, choice, pos_stw, 0, 0x4000, 0, target, 0, 6000, 0x4000, 0x4000, 1]
}

#[test]
fn telegram_110_positions_by_mdi_and_tells_it_in_its_words() {
    const MDI: u16 = 0x8000;
    let mut rig = Rig::started(110);
    rig.run(20, &words_of_110(OFF1, 0, 0, 0));
    let inputs = rig.run(300, &words_of_110(0x043F, 0, 0, 0));
    assert_eq!(rig.value(&inputs, Signal::Zsw1) & 0x0004, 0x0004, "operation");
    // POS_STW bit 0 follows the shaft, bit 1 sets the reference.
    let inputs = rig.run(20, &words_of_110(0x043F, 0, 1, 0));
    assert_eq!(rig.value(&inputs, Signal::PosZsw) & 1, 1);
    let inputs = rig.run(20, &words_of_110(0x043F, 0, 2, 0));
    assert_eq!(rig.value(&inputs, Signal::Zsw1) & 0x0800, 0x0800, "the position has a reference");
    rig.run(20, &words_of_110(0x043F, MDI, 0, 20_000));
    let inputs = rig.run(100, &words_of_110(0x047F, MDI, 0, 20_000));
    assert_eq!(rig.value(&inputs, Signal::Aktsatz), 0x8000);
    assert_eq!(rig.value(&inputs, Signal::PosZsw) & 0x3C, 0x10, "forward, not yet there");
    assert_eq!(rig.value(&inputs, Signal::Meldw) & 0x0C, 0x08, "600 rpm: below threshold 2, not below 3");
    let inputs = rig.run(2000, &words_of_110(0x047F, MDI, 0, 20_000));
    assert_eq!(rig.value(&inputs, Signal::XistA), 20_000);
    assert_eq!(rig.value(&inputs, Signal::Zsw1) & 0x3400, 0x3400, "there, accepted, standing");
    assert_eq!(rig.value(&inputs, Signal::PosZsw) & 0x3C, 0x0C, "setpoint stands and is reached");
    assert_eq!(rig.value(&inputs, Signal::Meldw) & 0x0C, 0x0C);
}

#[test]
fn telegram_111_tells_setting_up_and_cams() {
    const SET_UP: u16 = 0xC200;
    let words = |stw1: u16, pos_stw1: u16, pos_stw2: u16| {
        [stw1, pos_stw1, pos_stw2, 0, 0x4000, 0, 0, 0, 600, 0x4000, 0x4000, 0]
    };
    let mut rig = Rig::started(111);
    rig.run(20, &words(OFF1, 0, 0));
    rig.run(300, &words(0x043F, 0, 0));
    let inputs = rig.run(20, &words(0x043F, 0, 0x0002));
    assert_eq!(rig.value(&inputs, Signal::PosZsw2) & 0x0300, 0x0300, "at both cam positions, 0");
    rig.run(20, &words(0x043F, SET_UP, 0));
    let inputs = rig.run(1000, &words(0x047F, SET_UP, 0));
    assert_eq!(rig.value(&inputs, Signal::PosZsw1) & 0xC000, 0x4000, "set up, not positioning");
    assert_eq!(rig.value(&inputs, Signal::PosZsw2) & 0x8310, 0x8010, "travels forward, beyond the cams");
}

#[test]
fn pnu_923_has_the_parameter_of_each_signal_by_its_number() {
    let mut rig = Rig::started(1);
    // Elements 1 to 6: STW1, ZSW1, STW2, ZSW2, NSOLL_A, NIST_A; and 301, FAULT_CODE, the last but two.
    let answer = rig.parameter(&[1, 1, 0, 2, 0x10, 6, 0x03, 0x9B, 0, 1, 0x10, 1, 0x03, 0x9B, 0x01, 0x2D]);
    let first = [1, 1, 0, 2, 6, 6, 0x03, 0xC7, 0x03, 0xC8, 0, 0, 0, 0, 0, 20, 0, 21];
    assert_eq!(answer, [&first[..], &[6, 1, 0x08, 0x53]].concat());
    let beyond = rig.parameter(&[2, 1, 0, 1, 0x10, 1, 0x03, 0x9B, 0x01, 0x30]);
    assert_eq!(beyond[..6], [2, 0x81, 0, 1, 0x44, 2], "no element 304: {beyond:?}");
}

#[test]
fn a_new_configuration_while_a_block_runs_ends_it_and_the_axis_stands() {
    let mut rig = Rig::started(7);
    let set = |rig: &mut Rig, pnu: u16, value: i32| {
        let [high, low] = pnu.to_be_bytes();
        let [a, b, c, d] = value.to_be_bytes();
        let answer = rig.parameter(&[1, 2, 0, 1, 0x10, 1, high, low, 0, 0, 0x04, 1, a, b, c, d]);
        assert_eq!(answer, [1, 2, 0, 1], "PNU {pnu}");
    };
    // Block 0: on and on.
    for (pnu, value) in [(2616, 0), (2621, 3), (2618, 6000)] {
        set(&mut rig, pnu, value);
    }
    rig.run(20, &[OFF1, 0]);
    rig.run(300, &[0x043F, 0]);
    let inputs = rig.run(500, &[0x047F, 0]);
    assert_eq!((rig.value(&inputs, Signal::Aktsatz), rig.value(&inputs, Signal::Zsw1) & 0x2004), (0, 0x0004));
    assert_eq!(rig.drive.is_moving(), Some(true));
    // Another telegram: what was commanded by the one before is gone.
    rig.telegram = Telegram::numbered(1).unwrap();
    let owner = [0x88, 10, 10, 11, 0x50, 0x34, 0, 0x80, 0, 0];
    rig.ask(OWNER, Some((61, 62)), &owner);
    let octets = configuration(rig.telegram);
    rig.ask(OWNER, Some((62, 62)), &octets);
    assert_eq!(rig.drive.slave().state(), DpState::DataExch);
    // Everything released and a setpoint of 0: no speed is left over from the block.
    let inputs = rig.run(1500, &[RUN, 0]);
    assert_eq!(rig.drive.is_moving(), Some(false), "{:?}", rig.said);
    assert_eq!(rig.value(&inputs, Signal::NistA), 0);
    // Back again: the block does not go on by itself, bit 6 has no edge.
    rig.telegram = Telegram::numbered(7).unwrap();
    rig.ask(OWNER, Some((61, 62)), &owner);
    let octets = configuration(rig.telegram);
    rig.ask(OWNER, Some((62, 62)), &octets);
    rig.run(20, &[OFF1 | 0x80, 0]);
    rig.run(20, &[OFF1, 0]);
    rig.run(300, &[0x043F, 0]);
    assert_eq!(rig.drive.is_moving(), Some(false));
    rig.run(500, &[0x047F, 0]);
    assert_eq!(rig.drive.is_moving(), Some(true), "begun anew");
}

#[test]
fn telegrams_with_pkw_read_and_change_parameters_beside_the_process_data() {
    for number in [353, 354] {
        let mut rig = Rig::started(number);
        let mut job = |ak: u16, pnu: u16, ind: u16, pwe: u32| {
            let [a, b, c, d] = pwe.to_be_bytes();
            let words = [ak << 12 | pnu, ind, u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d])];
            let inputs = rig.run(2, &[&words[..], &[OFF1, 0]].concat());
            let word = |at: usize| u16::from_be_bytes([inputs[at], inputs[at + 1]]);
            let value = u32::from(word(4)) << 16 | u32::from(word(6));
            assert_eq!((word(0) & 0x07FF, word(2)), (pnu, ind), "the parameter is mirrored");
            (word(0) >> 12, value)
        };
        assert_eq!(job(1, 922, 0, 0), (1, number.into()));
        // Jobs 1 and 6 are the same, elements count from 0.
        assert_eq!((job(6, 964, 0x0500, 0), job(1, 964, 0x0500, 0)), ((4, 1), (4, 1)));
        assert_eq!((job(6, 922, 0, 0), job(9, 964, 0, 0)), ((1, number.into()), (6, 7)));
        // 1500.0 as single precision, and 2000 on its page.
        assert_eq!(job(3, 1082, 0, 0x44BB_8000), (2, 0x44BB_8000));
        assert_eq!(job(1, 0, 0x0080, 0).0, 2, "PNU 2000");
        assert_eq!(job(4, 922, 0x0002, 0).0, 7, "no such page");
        assert_eq!(job(4, 922, 0x0200, 0), (3, 0), "no elements");
        // What cannot be: the error numbers of record 47.
        assert_eq!((job(1, 5, 0, 0), job(2, 922, 0, 1)), ((7, 0), (7, 1)));
        assert_eq!((job(3, 1082, 0, 0xBF80_0000), job(6, 964, 0x0900, 0)), ((7, 2), (7, 3)));
        assert_eq!((job(6, 922, 0x0100, 0), job(2, 1082, 0, 1)), ((7, 4), (7, 5)));
        assert_eq!((job(2, 952, 0, 1), job(2, 927, 0, 0)), ((7, 6), (1, 0)));
        assert_eq!(job(3, 1082, 0, 0x4480_0000), (7, 11));
        assert_eq!(job(0, 0, 0, 0), (0, 0));
        assert!(rig.said.iter().any(|line| line == "PKW changed PNU 1082"), "{:?}", rig.said);
        let refused = rig.said.iter().any(|line| line.contains("refused with error 11, no control rights"));
        assert!(refused, "{:?}", rig.said);
        let inputs = rig.run(1500, &[0, 0, 0, 0, RUN, 0x2000]);
        assert_eq!(rig.value(&inputs, Signal::Zsw1) & 0x07, 0x07);
        assert!(rig.value(&inputs, Signal::NistAGlatt).abs_diff(0x2000) < 0x80);
    }
}

/// Changes elements of 915 or 916 from the first one on: what is answered behind the head.
fn choose(rig: &mut Rig, pnu: u16, first: u8, numbers: &[u8]) -> Vec<u8> {
    let [high, low] = pnu.to_be_bytes();
    let count = u8::try_from(numbers.len()).unwrap();
    let head = [1, 2, 1, 1, 0x10, count, high, low, 0, first, 6, count];
    let values: Vec<u8> = numbers.iter().flat_map(|number| [0, *number]).collect();
    let response = rig.parameter(&[&head[..], &values].concat());
    assert_eq!((response[0], response[2..4].to_vec()), (1, vec![1, 1]));
    response[4..].to_vec()
}

fn chosen(rig: &mut Rig, pnu: u16, count: u8) -> Vec<u8> {
    let [high, low] = pnu.to_be_bytes();
    let response = rig.parameter(&[1, 1, 1, 1, 0x10, count, high, low, 0, 0]);
    response[6..].chunks(2).map(|word| word[1]).collect()
}

#[test]
fn the_master_chooses_the_signals_of_telegram_999() {
    use Signal::{Free, MistGlatt, NistA, NistB, NsollA, Stw1, Zsw1};
    let telegram: &'static Telegram = Box::leak(Box::new(Telegram {
        setpoints: vec![Free, Stw1, NsollA].into(),
        actual_values: vec![Zsw1, NistA, NistB, MistGlatt].into(),
        ..Telegram::numbered(999).unwrap().clone()
    }));
    let mut rig = Rig::started_with(telegram);
    // Of a new drive: STW1 and ZSW1.
    assert_eq!((chosen(&mut rig, 915, 3), chosen(&mut rig, 916, 5)), (vec![1, 0, 0], vec![2, 0, 0, 0, 0]));
    assert_eq!(choose(&mut rig, 915, 0, &[0, 1, 5]), [0; 0]);
    assert_eq!(choose(&mut rig, 916, 1, &[6, 8, 8, 53]), [0; 0]);
    assert_eq!((chosen(&mut rig, 915, 3), chosen(&mut rig, 916, 5)), (vec![0, 1, 5], vec![2, 6, 8, 8, 53]));
    assert_eq!(rig.drive.telegram().as_ref(), Some(telegram));
    // Signals of the other way, none at all, and elements that the configuration does not have.
    assert_eq!(choose(&mut rig, 915, 2, &[6]), [0x44, 2, 0, 0x14, 0, 2]);
    assert_eq!(choose(&mut rig, 916, 1, &[5]), [0x44, 2, 0, 0x14, 0, 1]);
    assert_eq!(choose(&mut rig, 915, 3, &[1]), [0x44, 2, 0, 3, 0, 3]);
    rig.run(5, &[0, OFF1, 0]);
    let inputs = rig.run(1500, &[0, RUN, 0x2000]);
    assert_eq!(rig.value(&inputs, Zsw1) & 0x07, 0x07);
    assert!(rig.value(&inputs, NistA).abs_diff(0x2000) < 0x20, "{inputs:02X?}");
    assert!((rig.value(&inputs, NistB) >> 16).abs_diff(0x2000) < 0x20, "{inputs:02X?}");
    assert_eq!(choose(&mut rig, 915, 2, &[0]), [0x44, 1, 0, 0x11], "the drive is switched on");
    rig.run(2000, &[0, OFF1, 0]);
    // Stored, and there behind a reset; gone with the settings of a new drive.
    let switch = |rig: &mut Rig, pnu: u16| {
        let [high, low] = pnu.to_be_bytes();
        let changed = rig.parameter(&[1, 2, 1, 1, 0x10, 1, high, low, 0, 0, 6, 1, 0, 1]);
        assert_eq!(changed, [1, 2, 1, 1], "{pnu}");
    };
    switch(&mut rig, 971);
    assert_eq!(choose(&mut rig, 915, 0, &[1, 0, 0]), [0; 0]);
    switch(&mut rig, 972);
    assert_eq!(chosen(&mut rig, 915, 3), [0, 1, 5]);
    switch(&mut rig, 976);
    assert_eq!((chosen(&mut rig, 915, 3), chosen(&mut rig, 916, 5)), (vec![1, 0, 0], vec![2, 0, 0, 0, 0]));
    // A signal of two words that stands once is none.
    assert_eq!(choose(&mut rig, 916, 1, &[8, 6, 0, 8]), [0; 0]);
    let inputs = rig.run(5, &[0, 0, 0]);
    assert_eq!((&inputs[2..4], &inputs[8..10]), (&[0, 0][..], &[0, 0][..]));
    let mut rig = Rig::started(1);
    assert_eq!(choose(&mut rig, 915, 1, &[0]), [0x44, 2, 0, 1, 0, 1], "telegram 1 has its signals");
}
