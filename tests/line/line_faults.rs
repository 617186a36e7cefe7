//! Faults on purpose, each seen on the wire by the master.

use core::time::Duration;

use profidrive::devices::ag03::profibus::{ApplicationCycle, Config, Device};
use profidrive::host::fault::{Row, Rule, Way};
use profidrive::host::link::fault::Faulty;
use profidrive::host::link::memory::{End, Wire};
use profidrive::host::{Bus, Clock, Link, ManualClock, Received, Stop, run};
use profidrive::profibus::dp::State;
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, FrameCount, FunctionCode, Service, Telegram};
use profidrive::time::Instant;
use proptest::prelude::*;

use crate::drive_line::{CFG, IDENT, MASTER, SLAVE, hex, telegram};

const PRM: [u8; 7] = [0x80, 1, 1, 11, IDENT[0], IDENT[1], 0];
const NO_OUTPUTS: [u8; 14] = [0; 14];
/// PNU 1018 and PNU 1009, read.
const READ_1018: [u8; 14] = [0x13, 0xFA, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];

/// A drive behind faults, and a master that asks and hears.
struct Line {
    master: End,
    link: Faulty<End, ManualClock>,
    bus: Bus,
    clock: ManualClock,
    count: FrameCount,
}

impl Line {
    fn new(faults: &[Rule]) -> Self {
        let wire = Wire::new();
        let clock = ManualClock::new();
        let mut bus = Bus::new();
        let config = Config {
            application_cycle: ApplicationCycle::EACH_EXCHANGE,
            ..Config::new(Address::station(SLAVE).unwrap())
        };
        bus.add(Device::new(config, clock.now())).unwrap();
        let (master, link) = (wire.end(), Faulty::new(wire.end(), clock.clone(), faults));
        Self { master, link, bus, clock, count: FrameCount::First }
    }

    fn with(fault: &str) -> Self {
        Self::new(&[fault.parse().unwrap()])
    }

    /// Lets the drive hear, act and reply for 1 ms: the run loop with a clock of ours.
    fn turn(&mut self) -> Vec<u8> {
        for _ in 0..100 {
            self.clock.advance(Duration::from_micros(10));
            let stop = Stop::new().unwrap();
            stop.request();
            run(&mut self.link, &mut self.bus, &self.clock, &stop, &mut |_| {}).unwrap();
        }
        let mut buf = [0; 4096];
        match self.master.receive(&mut buf).unwrap() {
            Received::Octets(count) => buf[..count].to_vec(),
            _ => Vec::new(),
        }
    }

    fn ask(&mut self, octets: &[u8]) -> Vec<u8> {
        self.master.send(octets).unwrap();
        self.turn()
    }

    fn srd(&mut self, dsap: Option<u8>, data: &[u8]) -> Vec<u8> {
        let fc = FunctionCode::request(Service::SrdHigh, self.count);
        self.count = match self.count {
            FrameCount::Even => FrameCount::Odd,
            FrameCount::First | FrameCount::Odd | FrameCount::Unused => FrameCount::Even,
        };
        self.ask(&telegram(SLAVE, MASTER, fc, dsap, data))
    }

    fn start_up(&mut self) {
        assert_eq!(self.srd(Some(61), &PRM), [0xE5]);
        assert_eq!(self.srd(Some(62), &CFG), [0xE5]);
    }

    fn diagnosis(&mut self) -> Vec<u8> {
        data(&self.srd(Some(60), &[]))
    }

    fn exchange(&mut self) -> Vec<u8> {
        self.srd(None, &NO_OUTPUTS)
    }

    fn pkw(&mut self, outputs: &[u8]) -> Vec<u8> {
        data(&self.srd(None, outputs))[..8].to_vec()
    }

    fn injected(&self) -> Vec<u32> {
        self.link.injected().map(|(_, injected)| injected).collect()
    }
}

/// The data of the one whole telegram that these octets are.
fn data(octets: &[u8]) -> Vec<u8> {
    match decode(octets) {
        Decoded::Telegram { telegram: Telegram::Data(telegram), len } if len == octets.len() => {
            telegram.data.to_vec()
        }
        other => panic!("{octets:02X?}: {other:?}"),
    }
}

/// What a sound drive replies to FDL status.
const OK: [u8; 6] = [0x10, MASTER, SLAVE, 0x00, 0x07, 0x16];
const ASK: [u8; 6] = [0x10, SLAVE, MASTER, 0x49, 0x50, 0x16];
const RS: [u8; 6] = [0x10, MASTER, SLAVE, 0x03, 0x0A, 0x16];

/// A session of every service, with and without faults: what the master heard.
fn session(line: &mut Line) -> Vec<Vec<u8>> {
    let mut heard = vec![line.ask(&ask()), line.diagnosis_octets()];
    heard.push(line.srd(Some(61), &PRM));
    heard.push(line.srd(Some(62), &CFG));
    heard.push(line.diagnosis_octets());
    heard.push(line.srd(Some(59), &[]));
    for _ in 0..4 {
        heard.push(line.srd(None, &READ_1018));
    }
    heard.push(line.srd(Some(40), &[]));
    heard.push(line.ask(&ask()));
    heard
}

fn ask() -> Vec<u8> {
    ASK.to_vec()
}

impl Line {
    fn diagnosis_octets(&mut self) -> Vec<u8> {
        self.srd(Some(60), &[])
    }
}

#[test]
fn without_a_fault_and_with_faults_that_never_strike_the_octets_are_untouched() {
    let sound = session(&mut Line::new(&[]));
    assert_eq!(sound[0], OK);
    assert_eq!(sound.last().unwrap(), &OK);
    for row in Row::all() {
        if !matches!(row.way, Way::Request | Way::Reply) {
            continue;
        }
        let fault = row
            .to_string()
            .replace("TIME", "5ms")
            .replace("[=N]", "=3")
            .replace("[=ADDRESS]", "")
            .replace("HH", "03")
            .replace("PART", "end")
            .replace("OCTETS", "02")
            .replace("=N", "=2");
        let mut line = Line::with(&format!("{fault},at={}", u32::MAX));
        assert_eq!(session(&mut line), sound, "{fault}");
        assert_eq!(line.injected(), [0]);
        let mut other_station = Line::with(&format!("{fault},station=6"));
        assert_eq!(session(&mut other_station), sound, "{fault} of another station");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Noise included, and wherever the octets are cut.
    #[test]
    fn octets_pass_a_fault_that_does_not_strike(
        chunks in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..300), 0..6),
    ) {
        let wire = Wire::new();
        let (mut master, clock) = (wire.end(), ManualClock::new());
        let never: Rule = format!("drop-request,at={}", u32::MAX).parse().unwrap();
        let mut link = Faulty::new(wire.end(), clock.clone(), &[never]);
        let mut heard = Vec::new();
        let mut hear = |link: &mut Faulty<End, ManualClock>| {
            let mut buf = [0; 100];
            while let Received::Octets(count) = link.receive(&mut buf).unwrap() {
                heard.extend_from_slice(&buf[..count]);
            }
        };
        for chunk in &chunks {
            master.send(chunk).unwrap();
            hear(&mut link);
        }
        clock.advance(Duration::from_millis(50));
        hear(&mut link);
        prop_assert_eq!(heard, chunks.concat());
    }
}

#[test]
fn no_reply_is_silence() {
    let mut line = Line::with("no-reply,at=2");
    assert_eq!([line.ask(&ask()), line.ask(&ask()), line.ask(&ask())], [OK.to_vec(), vec![], OK.to_vec()]);
    assert_eq!(line.injected(), [1]);
}

#[test]
fn a_late_reply_comes_so_much_later_and_behind_the_next_one() {
    let mut line = Line::with("late=20ms,at=1");
    assert_eq!(line.srd(Some(60), &[]), [0; 0]);
    for _ in 0..17 {
        assert_eq!(line.turn(), [0; 0]);
    }
    assert_eq!(line.ask(&ask()), OK);
    let heard = (0..5).map(|_| line.turn()).find(|heard| !heard.is_empty()).unwrap();
    assert_eq!(data(&heard), hex("02 05 00 FF 0A C5"));
    assert!((20..=22).contains(&(line.clock.now().as_nanos() / 1_000_000)), "{}", line.clock.now());
}

/// A link whose master leaves when told to.
struct Leaving {
    end: End,
    leaves: bool,
}

impl Link for Leaving {
    fn receive(&mut self, buf: &mut [u8]) -> std::io::Result<Received> {
        if core::mem::take(&mut self.leaves) { Ok(Received::Reset) } else { self.end.receive(buf) }
    }
    fn send(&mut self, telegram: &[u8]) -> std::io::Result<()> {
        self.end.send(telegram)
    }
    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> std::io::Result<()> {
        self.end.wait(timeout, stop)
    }
}

#[test]
fn a_late_reply_wakes_the_link_in_time_and_is_forgotten_with_its_master() {
    for leaves in [false, true] {
        let wire = Wire::new();
        let (mut master, clock) = (wire.end(), ManualClock::new());
        let leaving = Leaving { end: wire.end(), leaves };
        let mut link = Faulty::new(leaving, clock.clone(), &["late=1ms".parse().unwrap()]);
        link.send(&OK).unwrap();
        let (start, stop) = (std::time::Instant::now(), Stop::new().unwrap());
        link.wait(None, &stop).unwrap();
        assert!(start.elapsed() >= Duration::from_millis(1));
        if leaves {
            assert_eq!(link.receive(&mut [0; 9]).unwrap(), Received::Reset);
        }
        assert_eq!(master.receive(&mut [0; 9]).unwrap(), Received::Nothing);
        clock.advance(Duration::from_millis(1));
        assert_eq!(link.receive(&mut [0; 9]).unwrap(), Received::Nothing);
        let sent = if leaves { Received::Nothing } else { Received::Octets(6) };
        assert_eq!(master.receive(&mut [0; 9]).unwrap(), sent);
    }
}

#[test]
fn a_duplicate_is_the_same_reply_twice() {
    let mut line = Line::with("duplicate,count=1");
    assert_eq!(line.ask(&ask()), [OK, OK].concat());
    assert_eq!(line.ask(&ask()), OK);
}

#[test]
fn a_truncated_reply_is_a_front_of_it() {
    let mut line = Line::with("truncated");
    let lengths: Vec<_> = (0..50)
        .map(|_| {
            let heard = line.ask(&ask());
            assert!(heard.len() < OK.len() && OK.starts_with(&heard), "{heard:02X?}");
            heard.len()
        })
        .collect();
    assert!((0..6).all(|len| lengths.contains(&len)), "{lengths:?}");
}

#[test]
fn bit_errors_are_so_many_bits() {
    for bits in [1, 3, 48, 255] {
        let mut line = Line::with(&format!("bit-errors={bits}"));
        let heard = line.ask(&ask());
        assert_eq!(heard.len(), OK.len());
        let wrong: u32 = heard.iter().zip(OK).map(|(heard, sound)| (heard ^ sound).count_ones()).sum();
        assert_eq!(wrong, bits.min(48));
    }
}

#[test]
fn a_wrong_fcs_is_the_only_wrong_octet_and_sc_has_none() {
    let mut line = Line::with("wrong-fcs,count=3");
    assert_eq!(line.ask(&ask()), [0x10, MASTER, SLAVE, 0x00, 0x08, 0x16]);
    line.start_up();
    let heard = line.srd(Some(60), &[]);
    assert!(
        matches!(decode(&heard), Decoded::Invalid { error: profidrive::profibus::fdl::FrameError::Checksum { expected, got }, .. }
            if got == expected + 1),
        "{heard:02X?}"
    );
    assert_eq!(line.injected(), [2]);
}

#[test]
fn a_wrong_length_asks_for_an_octet_that_does_not_come() {
    let mut line = Line::with("wrong-length");
    assert_eq!(line.ask(&ask()), OK, "no LE, no fault");
    let heard = line.srd(Some(60), &[]);
    assert_eq!(heard[..4], [0x68, 0x0C, 0x0C, 0x68]);
    assert_eq!((heard.len(), decode(&heard)), (17, Decoded::Incomplete));
}

#[test]
fn a_wrong_source_is_a_sound_telegram_of_the_next_station() {
    let mut line = Line::with("wrong-source");
    assert_eq!(line.ask(&ask()), [0x10, MASTER, SLAVE + 1, 0x00, 0x08, 0x16]);
}

#[test]
fn noise_comes_between_request_and_reply_and_is_the_same_for_the_same_seed() {
    let heard = |spec: &str| {
        let mut line = Line::with(spec);
        [line.ask(&ask()), line.ask(&ask())]
    };
    let [first, second] = heard("noise=7");
    assert_eq!((first.len(), second.len()), (13, 13));
    assert_eq!((&first[7..], &second[7..]), (&OK[..], &OK[..]));
    assert_ne!(first[..7], second[..7]);
    assert_eq!(heard("noise=7"), [first.clone(), second]);
    assert_ne!(heard("noise=7,seed=2")[0], first);
}

#[test]
fn a_dropped_request_is_heard_by_nobody_and_repeated_with_success() {
    let mut line = Line::with("drop-request,at=2");
    line.srd(Some(60), &[]);
    let prm =
        telegram(SLAVE, MASTER, FunctionCode::request(Service::SrdHigh, FrameCount::Even), Some(61), &PRM);
    assert_eq!(line.ask(&prm), [0; 0]);
    assert_eq!(line.ask(&prm), [0xE5]);
}

#[test]
fn dh_announces_a_diagnosis_in_each_data_exchange() {
    let mut line = Line::with("diag-announced,count=3");
    line.start_up();
    let diagnosis = line.diagnosis();
    assert_eq!(diagnosis[..2], [0x00, 0x04]);
    let codes: Vec<_> = (0..5)
        .map(|_| {
            let heard = line.exchange();
            assert_eq!(data(&heard).len(), 14);
            heard[6]
        })
        .collect();
    assert_eq!(codes, [0x0A, 0x0A, 0x0A, 0x08, 0x08]);
}

#[test]
fn a_station_that_is_not_ready_says_so_for_a_time_after_chk_cfg() {
    let mut line = Line::with("not-ready=20ms,at=1");
    assert_eq!(line.diagnosis()[..2], [0x02, 0x05]);
    line.start_up();
    let chk_cfg_over = line.clock.now();
    let passed = |line: &Line| line.clock.now().saturating_since(chk_cfg_over);
    while passed(&line) < Duration::from_millis(17) {
        assert_eq!(line.diagnosis()[0], 0x02);
        assert_eq!(line.exchange(), RS);
    }
    while passed(&line) < Duration::from_millis(20) {
        line.turn();
    }
    assert_eq!(line.diagnosis()[..4], [0x00, 0x04, 0x00, MASTER]);
    assert_eq!(data(&line.exchange()).len(), 14);
    line.start_up();
    assert_eq!(line.diagnosis()[0], 0x00, "once only");
}

#[test]
fn a_station_that_is_not_ready_is_one_that_can_exist() {
    let mut line = Line::with("not-ready=20ms,count=1");
    // Sync and Freeze asked for.
    let mut prm = PRM;
    prm[0] |= 0x30;
    assert_eq!(line.srd(Some(61), &prm), [0xE5]);
    assert_eq!(line.srd(Some(62), &CFG), [0xE5], "acknowledged like any Chk_Cfg");
    let slave = |line: &Line| {
        let device = line.bus.station::<Device>(Address::station(SLAVE).unwrap()).unwrap();
        (device.dp_state(), device.slave().diagnosis().octets())
    };
    let before = slave(&line);
    assert_eq!(before.0, State::WaitCfg);
    for sap in [56, 57] {
        assert_eq!(line.srd(Some(sap), &[]), RS, "RD_Inp and RD_Outp");
    }
    // Global_Control: Sync and Freeze to this slave.
    let control = telegram(SLAVE, MASTER, FunctionCode::from_octet(0x46), Some(58), &[0x28, 0]);
    line.master.send(&control).unwrap();
    assert!(line.turn().is_empty());
    assert_eq!(slave(&line), before, "no effect");
    assert_eq!(line.diagnosis()[..2], [0x02, 0x04], "what the master sees is what the slave is");
    // Another Chk_Cfg does not begin the time anew, a Set_Prm makes it void.
    let begun = line.clock.now();
    while line.clock.now().saturating_since(begun) < Duration::from_millis(20) {
        assert_eq!(line.srd(Some(62), &CFG), [0xE5]);
    }
    assert_eq!(line.diagnosis()[..4], [0x00, 0x04, 0x00, MASTER]);
    assert_eq!(slave(&line).0, State::DataExch);
    assert_eq!(data(&line.exchange()).len(), 14);
}

#[test]
fn a_refused_set_prm_is_shown_as_prm_fault() {
    let mut line = Line::with("refuse-prm,count=2");
    for _ in 0..2 {
        assert_eq!(line.srd(Some(61), &PRM), [0xE5]);
        assert_eq!(line.diagnosis()[..4], [0x42, 0x05, 0x00, 0xFF]);
    }
    line.start_up();
    assert_eq!(line.diagnosis()[..2], [0x00, 0x04]);
}

#[test]
fn a_refused_chk_cfg_is_shown_as_cfg_fault() {
    let mut line = Line::with("refuse-cfg,count=1");
    line.start_up();
    assert_eq!(line.diagnosis()[0] & 0x06, 0x06, "Cfg_Fault and Station_Not_Ready");
    line.start_up();
    assert_eq!(line.diagnosis()[..2], [0x00, 0x04]);
}

#[test]
fn parameterisation_is_lost_at_a_given_exchange() {
    let mut line = Line::with("lose-prm,at=100");
    line.start_up();
    for _ in 1..100 {
        assert_eq!(data(&line.exchange()).len(), 14);
    }
    assert_eq!(line.exchange(), RS);
    assert_eq!(line.diagnosis()[..4], [0x02, 0x05, 0x00, 0xFF]);
    line.start_up();
    assert_eq!(data(&line.exchange()).len(), 14);
}

/// What the master sees of PKE while it asks for PNU 1018 in each exchange.
fn answers(line: &mut Line, exchanges: usize) -> Vec<String> {
    (0..exchanges)
        .map(|_| line.pkw(&READ_1018).iter().map(|octet| format!("{octet:02X}")).collect::<String>())
        .collect()
}

#[test]
fn a_pkw_answer_comes_n_exchanges_later() {
    let mut sound = Line::new(&[]);
    sound.start_up();
    let sound = answers(&mut sound, 6);
    let first = sound.iter().position(|pkw| pkw.starts_with("23FA")).unwrap();
    for delay in [1, 4] {
        let mut line = Line::with(&format!("pkw-delay={delay}"));
        line.start_up();
        let late = answers(&mut line, 12);
        let came = late.iter().position(|pkw| pkw.starts_with("23FA")).unwrap();
        assert_eq!(came, first + delay as usize, "{late:?}");
        assert!(late[..came].iter().all(|pkw| *pkw == "0000000000000000"), "{late:?}");
        assert_eq!(late[came..came + 2], sound[first..first + 2]);
    }
}

#[test]
fn a_wrong_ak_and_a_wrong_pnu_stand_as_long_as_the_answer() {
    for (fault, pke) in [("pkw-wrong-ak,count=1", "13FA"), ("pkw-wrong-pnu,count=1", "23FB")] {
        let mut line = Line::with(fault);
        line.start_up();
        let wrong = answers(&mut line, 6);
        assert!(wrong[2..].iter().all(|pkw| pkw.starts_with(pke)), "{fault}: {wrong:?}");
        while line.pkw(&NO_OUTPUTS) != [0; 8] {}
        let right = answers(&mut line, 3);
        assert!(right[2].starts_with("23FA"), "the next answer is right: {right:?}");
        assert_eq!(line.injected(), [1]);
    }
}

#[test]
fn a_torn_pkw_has_the_old_pke_and_the_new_pwe_for_one_exchange() {
    let job = |pke: u16| [&pke.to_be_bytes()[..], &[0; 12]].concat();
    let exchange = |line: &mut Line| {
        line.start_up();
        for _ in 0..3 {
            line.pkw(&job(0x1000 | 1016));
        }
        // PNU 1016 (limit 1) is not 0; the job after it reads 1009.
        (0..3).map(|_| line.pkw(&job(0x1000 | 1009))).collect::<Vec<_>>()
    };
    let sound = exchange(&mut Line::new(&[]));
    let torn = exchange(&mut Line::with("pkw-torn,at=2"));
    let new = sound.iter().position(|pkw| pkw[0] == 0x13).unwrap();
    let old = sound[new - 1].clone();
    assert_ne!((&sound[new][..4], &sound[new][4..]), (&old[..4], &old[4..]));
    assert_eq!(torn[new], [&old[..4], &sound[new][4..]].concat(), "{torn:02X?}");
    assert_eq!(torn[new + 1], sound[new + 1]);
}

#[test]
fn a_rate_strikes_that_often_and_the_same_seed_the_same_occasions() {
    let silent = |spec: &str| -> Vec<usize> {
        let wire = Wire::new();
        let mut master = wire.end();
        let mut link = Faulty::new(wire.end(), ManualClock::new(), &[spec.parse().unwrap()]);
        (0..10_000)
            .filter(|_| {
                link.send(&OK).unwrap();
                master.receive(&mut [0; 9]).unwrap() == Received::Nothing
            })
            .collect()
    };
    let seventh = silent("no-reply,rate=0.01,seed=7");
    assert!((60..140).contains(&seventh.len()), "{} of 10000", seventh.len());
    assert_eq!(silent("no-reply,rate=0.01,seed=7"), seventh);
    assert_ne!(silent("no-reply,rate=0.01,seed=8"), seventh);
    assert_eq!(silent("no-reply,rate=0.01,seed=7,count=5"), seventh[..5]);
    assert!(silent("no-reply,rate=0.01,at=5001").iter().all(|index| *index >= 5000));
    assert_eq!(silent("no-reply,at=3,count=2"), [2, 3]);
}

#[test]
fn faults_act_one_after_the_other_each_with_its_own_count() {
    let mut line = Line::new(&["noise=1,count=1".parse().unwrap(), "duplicate,at=2".parse().unwrap()]);
    assert_eq!(line.ask(&ask()).len(), 7);
    assert_eq!(line.ask(&ask()).len(), 12);
    assert_eq!(line.ask(&ask()), OK);
    assert_eq!(line.injected(), [1, 1]);
}

#[test]
fn what_is_half_passes_after_50_ms_so_that_the_drives_see_it_too() {
    let mut line = Line::with("drop-request,at=1000");
    assert_eq!(line.ask(&ask()[..3]), [0; 0]);
    for _ in 0..60 {
        assert_eq!(line.turn(), [0; 0]);
    }
    assert_eq!(line.ask(&ask()), OK);
    assert!(line.clock.now() > Instant::from_millis(60));
}

#[test]
fn faults_come_and_go_while_the_drives_run_and_nothing_stays_behind() {
    let mut line = Line::new(&[]);
    assert_eq!(line.ask(&ASK), OK);
    let [no_reply, duplicate]: [Rule; 2] = ["no-reply", "duplicate"].map(|text| text.parse().unwrap());
    let (now, faults) = (line.clock.now(), line.link.faults_mut());
    let first = faults.add(now, no_reply);
    let second = faults.add(now, duplicate);
    assert_eq!(line.ask(&ASK), [0; 0]);
    assert_eq!(line.link.faults_mut().remove(first), Some(no_reply));
    assert_eq!(line.ask(&ASK), [OK, OK].concat());

    // Half a telegram waits for its rest when the last fault goes, and is heard all the same.
    assert_eq!(line.ask(&ASK[..3]), [0; 0]);
    assert_eq!(line.link.faults_mut().remove(second), Some(duplicate));
    assert_eq!(line.ask(&ASK[3..]), OK);
    assert_eq!(line.ask(&ASK), OK);
    assert_eq!(line.link.faults_mut().remove(second), None);
    assert_ne!(line.link.faults_mut().add(now, no_reply), second, "a number is not given twice");
    line.link.faults_mut().clear();
    assert_eq!(line.link.faults_mut().iter().count(), 0);
    assert_eq!(line.ask(&ASK), OK);
}
