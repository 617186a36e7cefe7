//! A station from a GSD on a bus in virtual time: what becomes of its outputs and inputs.

use core::time::Duration;

use profidrive::devices::ag03::profibus::MAX_TELEGRAM_LEN;
use profidrive::face::description::Amount;
use profidrive::gsd::{Gsd, ModuleState, Policy, Raised, Station, Status};
use profidrive::host::{Bus, GsdStation, OutputsAre, Refusals, ValueBoard};
use profidrive::process::{Elsewhere, Image, Input, Origin, Point, Process, Signal, Source, ValueType, What};
use profidrive::profibus::dp::Application;
use profidrive::profibus::fdl::Address;
use profidrive::time::{BaudRate, Instant};

/// 8 DI, 8 DO, 2 AI, 2 AO.
const MODULES: [u8; 4] = [0x10, 0x20, 0x51, 0x61];
const MASTER: u8 = 2;

/// A bus, and a master that sends single requests.
struct Rig {
    bus: Bus,
    now: Instant,
    toggles: [bool; 127],
}

impl Rig {
    fn new(stations: impl IntoIterator<Item = GsdStation>) -> Self {
        let mut bus = Bus::new();
        for station in stations {
            bus.add(station).unwrap();
        }
        Self { bus, now: Instant::ZERO, toggles: [false; 127] }
    }

    /// Sends a telegram and returns the data of the reply.
    fn telegram(&mut self, to: u8, function: u8, sap: Option<u8>, data: &[u8]) -> Option<Vec<u8>> {
        let extension = if sap.is_some() { 0x80 } else { 0 };
        let saps = sap.map(|sap| vec![sap, 62]).unwrap_or_default();
        let body = [&[to | extension, MASTER | extension, function][..], &saps, data].concat();
        let (len, sum) = (body.len() as u8, body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet)));
        // Without data it is a telegram of fixed length.
        let head = if body.len() == 3 { vec![0x10] } else { vec![0x68, len, len, 0x68] };
        let octets = [&head[..], &body, &[sum, 0x16]].concat();
        self.bus.handle_bytes(self.now, &octets);
        let mut buf = [0; MAX_TELEGRAM_LEN];
        self.pass(Duration::from_micros(300));
        let reply = self.bus.poll_transmit(self.now, &mut buf)?;
        // Without saps: a reply to Data_Exchange.
        Some(if reply[0] == 0x68 { reply[7..reply.len() - 2].to_vec() } else { Vec::new() })
    }

    fn request(&mut self, to: u8, sap: Option<u8>, data: &[u8]) -> Option<Vec<u8>> {
        let toggle = &mut self.toggles[usize::from(to)];
        *toggle = !*toggle;
        let function = if *toggle { 0x7D } else { 0x5D };
        self.telegram(to, function, sap, data)
    }

    /// Lets time pass; the bus is told at its deadlines.
    fn pass(&mut self, time: Duration) {
        let end = self.now.saturating_add(time);
        while let Some(due) = self.bus.poll_timeout().filter(|due| *due < end) {
            self.now = self.now.max(due);
            self.bus.handle_timeout(self.now);
            // A reply is fetched by `telegram`.
            if self.bus.poll_timeout().is_some_and(|again| again <= due) {
                break;
            }
        }
        self.now = end;
        self.bus.handle_timeout(end);
    }

    fn start(&mut self, address: u8) {
        self.telegram(address, 0x6D, Some(61), &[0x88 | 0x20, 10, 10, 11, 0x0A, 0x08, 0]);
        self.toggles[usize::from(address)] = false;
        self.request(address, Some(62), &MODULES);
        while self.bus.poll_event().is_some() {}
        assert_eq!(self.exchange(address, [0; 5]).len(), 5);
    }

    fn exchange(&mut self, address: u8, outputs: [u8; 5]) -> Vec<u8> {
        self.request(address, None, &outputs).unwrap()
    }

    fn control(&mut self, command: u8) {
        assert_eq!(self.telegram(127, 0x46, Some(58), &[command, 0]), None);
    }

    fn station(&self, address: u8) -> &GsdStation {
        self.bus.station(Address::station(address).unwrap()).unwrap()
    }

    fn with<R>(&mut self, address: u8, act: impl FnOnce(&mut GsdStation) -> R) -> R {
        self.bus.with(Address::station(address).unwrap(), act).unwrap()
    }

    /// Why the outputs of station 7 are what they are, and the octet of its 8 DO.
    fn outputs(&self) -> (OutputsAre, u8) {
        let station = self.station(7);
        (station.outputs_are(), station.outputs(&station.layout()[1].slot)[0])
    }
}

fn station(address: u8) -> GsdStation {
    let gsd = Gsd::read(include_bytes!("../gsd/remote_io.gsd")).unwrap();
    let station = Station::new(gsd, Policy::PROPOSED).unwrap();
    GsdStation::new(Address::station(address).unwrap(), BaudRate::K500, station, Refusals::default())
}

const fn point(slot: u16, offset: usize, kind: ValueType) -> Point {
    Point { slot, offset, kind }
}

#[test]
fn clear_fail_safe_and_the_watchdog_are_seen_in_the_outputs() {
    let mut rig = Rig::new([station(7)]);
    assert_eq!(rig.station(7).outputs_are(), OutputsAre::Unowned);
    rig.start(7);
    rig.exchange(7, [0xA5, 0, 0, 0, 0]);
    assert_eq!(rig.outputs(), (OutputsAre::Live, 0xA5));
    rig.control(0x02);
    assert_eq!(rig.outputs(), (OutputsAre::Cleared, 0));
    rig.control(0x00);
    rig.exchange(7, [0xA5, 0, 0, 0, 0]);
    assert_eq!(rig.outputs(), (OutputsAre::Live, 0xA5));
    rig.request(7, None, &[]);
    assert_eq!(rig.outputs(), (OutputsAre::FailSafe, 0));
    rig.exchange(7, [0x5A, 0, 0, 0, 0]);
    assert_eq!(rig.outputs(), (OutputsAre::Live, 0x5A));
    rig.pass(Duration::from_millis(1100));
    assert_eq!(rig.outputs(), (OutputsAre::WatchdogExpired, 0));
}

#[test]
fn a_forced_input_stands_over_what_moves_it_until_it_is_released() {
    let mut own = station(7);
    let word = point(3, 0, ValueType::Unsigned16);
    let of = Origin::Output(point(4, 0, ValueType::Unsigned16));
    own.connect(Input::new(word, Signal::new(Source::Follow { of, delay: Duration::ZERO }).unwrap()));
    let mut rig = Rig::new([own]);
    rig.start(7);
    rig.exchange(7, [0, 0x12, 0x34, 0, 0]);
    assert_eq!(rig.exchange(7, [0, 0x12, 0x34, 0, 0])[1..3], [0x12, 0x34]);
    rig.with(7, |station| station.force(point(3, 1, ValueType::Bit(7)), 1.0).unwrap());
    rig.with(7, |station| station.force(point(1, 0, ValueType::Bit(0)), 1.0).unwrap());
    assert_eq!(rig.exchange(7, [0, 0x12, 0x34, 0, 0])[..3], [0x01, 0x12, 0xB4]);
    let slot = rig.station(7).layout()[2].slot.clone();
    assert_eq!(rig.station(7).forced(&slot), [0, 0x80, 0, 0]);
    rig.with(7, |station| station.release(point(3, 1, ValueType::Bit(7))).unwrap());
    assert_eq!(rig.exchange(7, [0; 5])[..3], [0x01, 0x12, 0x34]);
    rig.with(7, GsdStation::release_all);
    assert_eq!(rig.exchange(7, [0; 5])[..3], [0, 0, 0]);
    for wrong in
        [point(9, 0, ValueType::Bit(0)), point(1, 1, ValueType::Bit(0)), point(2, 0, ValueType::Bit(0))]
    {
        assert!(rig.with(7, |station| station.force(wrong, 1.0)).is_err(), "{wrong:?}");
    }
}

#[test]
fn an_input_follows_an_output_of_another_station_after_a_delay() {
    let board = ValueBoard::default();
    let mut follower = station(7).on_board(board.clone());
    let leader = station(9).on_board(board.clone());
    let what = What::Output(point(4, 0, ValueType::Unsigned16));
    let of = Elsewhere { line: None, station: 9, what };
    let source = Source::Follow { of: Origin::Elsewhere(of.clone()), delay: Duration::from_millis(200) };
    follower.connect(Input::new(point(3, 0, ValueType::Unsigned16), Signal::new(source).unwrap()));
    let mut rig = Rig::new([follower, leader]);
    rig.start(7);
    rig.start(9);
    rig.exchange(9, [0, 0x12, 0x34, 0, 0]);
    rig.pass(Duration::from_millis(100));
    assert_eq!(rig.exchange(7, [0; 5])[1..3], [0, 0]);
    rig.pass(Duration::from_millis(150));
    rig.exchange(7, [0; 5]);
    assert_eq!(rig.exchange(7, [0; 5])[1..3], [0x12, 0x34]);
    assert_eq!(board.value(&of), Some(4660.0));
    drop(rig.bus.remove(Address::station(9).unwrap()));
    assert_eq!(board.value(&of), None, "removed");
}

#[test]
fn an_input_follows_a_station_of_another_line() {
    let board = ValueBoard::default();
    let leader = station(9).on_board(board.of_line(2));
    let mut follower = station(9).on_board(board.of_line(1));
    let what = What::Output(point(4, 0, ValueType::Unsigned16));
    let of = Origin::Elsewhere(Elsewhere { line: Some(2), station: 9, what });
    let source = Source::Scale { of, factor: 2.0, offset: 1.0 };
    follower.connect(Input::new(point(3, 0, ValueType::Unsigned16), Signal::new(source).unwrap()));
    let (mut first, mut second) = (Rig::new([follower]), Rig::new([leader]));
    first.start(9);
    second.start(9);
    second.exchange(9, [0, 0x12, 0x34, 0, 0]);
    first.pass(Duration::from_millis(20));
    assert_eq!(first.exchange(9, [0; 5])[1..3], [0x24, 0x69]);
}

/// Doubles the output word with every call, and wants to be called every second.
struct Doubler;

impl Process for Doubler {
    fn step(&mut self, now: Instant, image: &mut Image<'_>) -> Option<Instant> {
        let value = image.output(point(4, 0, ValueType::Signed16)).unwrap_or_default();
        image.set_input(point(3, 0, ValueType::Signed16), value * 2.0).unwrap_or_default();
        let ticks = image.input(point(1, 0, ValueType::Unsigned8)).unwrap_or_default() + 1.0;
        image.set_input(point(1, 0, ValueType::Unsigned8), ticks % 256.0).unwrap_or_default();
        Some(now.saturating_add(Duration::from_secs(1)))
    }
}

#[test]
fn a_machine_of_ones_own_gets_outputs_and_time() {
    let mut own = station(7);
    own.connect(Doubler);
    let mut rig = Rig::new([own]);
    rig.start(7);
    rig.exchange(7, [0, 0xFF, 0x38, 0, 0]);
    let inputs = rig.exchange(7, [0, 0xFF, 0x38, 0, 0]);
    assert_eq!(inputs[1..3], [0xFE, 0x70], "-200 doubled");
    rig.pass(Duration::from_millis(500));
    let before = rig.exchange(7, [0, 0xFF, 0x38, 0, 0])[0];
    assert!(before > inputs[0], "called with every exchange");
}

#[test]
fn a_raised_diagnosis_is_read_by_the_master_and_kept_until_another_configuration() {
    let mut rig = Rig::new([station(7)]);
    rig.start(7);
    let raised = Raised {
        bits: [1].into(),
        modules: [(3, ModuleState::Missing)].into(),
        not_valid: true,
        ..Raised::default()
    };
    rig.with(7, |station| station.raise(raised).unwrap());
    let diagnosis = rig.request(7, Some(60), &[]).unwrap();
    // Behind the saps: Ext_Diag, Stat_Diag, then the blocks.
    let units = &diagnosis[2..];
    assert_eq!(units[0] & 0x08, 0x08, "{units:02X?}");
    assert_eq!(units[1] & 0x02, 0x02, "{units:02X?}");
    assert_eq!(units[6..], [0x02, 0x02, 0x05, 0x82, 0x00, 0x00, 0x30]);
    let wrong = Raised { identifiers: [5].into(), ..Raised::default() };
    let refused = rig.with(7, |station| station.raise(wrong)).unwrap_err().to_string();
    assert_eq!(refused, "there is no slot 5; the configuration has 1 to 4");
    assert_eq!(rig.station(7).raised().bits, [1].into(), "a refusal changes nothing");
    rig.telegram(7, 0x6D, Some(61), &[0x88 | 0x20, 10, 10, 11, 0x0A, 0x08, 0]);
    rig.toggles[7] = false;
    rig.request(7, Some(62), &MODULES[..1]);
    assert!(rig.station(7).raised().is_empty(), "slot 3 is gone");
}

#[test]
fn a_status_block_that_is_raised_stays_when_the_configuration_changes() {
    let file = "#Profibus_DP\nIdent_Number=0x0A08\n500_supp=1\nMaxTsdr_500=100\nMax_Diag_Data_Len=20\nModular_Station=1\n\
        Max_Module=4\nUnitDiagType=161\nX_Unit_Diag_Bit(24)=\"door\"\nEndUnitDiagType\n\
        Module=\"in\" 0x10\nEndModule\nModule=\"out\" 0x20\nEndModule\n";
    let gsd = Gsd::read(file.as_bytes()).unwrap();
    let station = Station::new(gsd, Policy::PROPOSED).unwrap();
    let address = Address::station(7).unwrap();
    let mut rig = Rig::new([GsdStation::new(address, BaudRate::K500, station, Refusals::default())]);
    let configure = |rig: &mut Rig, configuration: &[u8]| {
        rig.telegram(7, 0x6D, Some(61), &[0x88 | 0x20, 10, 10, 11, 0x0A, 0x08, 0]);
        rig.toggles[7] = false;
        rig.request(7, Some(62), configuration);
        rig.request(7, Some(60), &[]).unwrap()[8..].to_vec()
    };
    configure(&mut rig, &[0x10, 0x20]);
    let status = Status { bits: [24].into(), ..Status::default() };
    let raised = Raised { statuses: [(161, status)].into(), ..Raised::default() };
    rig.with(7, |station| station.raise(raised.clone()).unwrap());
    let block = [0x05, 0xA1, 0, 0, 0x01];
    assert_eq!(rig.request(7, Some(60), &[]).unwrap()[8..], block);
    assert_eq!(configure(&mut rig, &[0x10]), block, "it has no slot");
    assert_eq!(*rig.station(7).raised(), raised);
}

#[test]
fn a_master_that_expects_other_modules_is_told_which_are_wrong_or_missing() {
    let file = "#Profibus_DP\nIdent_Number=0x0A08\n500_supp=1\nMaxTsdr_500=100\nMax_Diag_Data_Len=20\nModular_Station=1\n\
        Max_Module=4\nUnitDiagType=130\nX_Unit_Diag_Area=24-25\nX_Value(3)=\"no module\"\nX_Unit_Diag_Area_End\n\
        EndUnitDiagType\nModule=\"in\" 0x10\nEndModule\nModule=\"out\" 0x20\nEndModule\n";
    let gsd = Gsd::read(file.as_bytes()).unwrap();
    assert!(gsd.has_module_status());
    let plugged = [Some(0), Some(0), None];
    let address = Address::station(7).unwrap();
    for (reports, cfg_fault) in [(true, false), (false, true)] {
        let station = Station::new(gsd.clone(), Policy::PROPOSED).unwrap();
        let station = station.with_slots(&plugged).unwrap().reporting(reports);
        let mut rig = Rig::new([GsdStation::new(address, BaudRate::K500, station, Refusals::default())]);
        rig.telegram(7, 0x6D, Some(61), &[0x88 | 0x20, 10, 10, 11, 0x0A, 0x08, 0]);
        rig.toggles[7] = false;
        rig.request(7, Some(62), &[0x10, 0x20, 0x10]);
        let diagnosis = rig.request(7, Some(60), &[]).unwrap()[2..].to_vec();
        assert_eq!(diagnosis[0] & 0x04 != 0, cfg_fault, "{diagnosis:02X?}");
        if reports {
            rig.exchange(7, [0; 5]);
            rig.request(7, None, &[0]).unwrap();
            let diagnosis = rig.request(7, Some(60), &[]).unwrap();
            assert_eq!(diagnosis[8..], [0x42, 0x06, 0x05, 0x82, 0x00, 0x00, 0x38], "{diagnosis:02X?}");
        }
    }
}

#[test]
fn the_user_parameters_in_force_are_described_by_name_and_text() {
    let file = include_str!("../gsd/extended_prm.gsd").replace("0x0A05", "0x0A08");
    let station = Station::new(Gsd::read(file.as_bytes()).unwrap(), Policy::PROPOSED).unwrap();
    let configuration = station.configuration(None).to_vec();
    let user_prm = station.gsd().default_user_prm(&[]);
    let address = Address::station(7).unwrap();
    let mut rig = Rig::new([GsdStation::new(address, BaudRate::K500, station, Refusals::default())]);
    let shown = |rig: &Rig| {
        let mut shown = Vec::new();
        rig.bus.description(address).unwrap().each_exchange(&mut |exchange| {
            if exchange.key.to_string() == "set_prm" {
                (exchange.each_entry)(&mut |entry| {
                    let amount = match entry.amount {
                        Amount::Text(text) => text.to_string(),
                        amount => amount.number().unwrap().to_string(),
                    };
                    shown.push(format!("{} ({}) = {amount}", entry.name, entry.place));
                });
            }
        });
        shown
    };
    assert!(shown(&rig).is_empty());
    let prm = [&[0x88 | 0x20, 10, 10, 11, 0x0A, 0x08, 0][..], &user_prm].concat();
    rig.telegram(7, 0x6D, Some(61), &prm);
    rig.toggles[7] = false;
    rig.request(7, Some(62), &configuration);
    rig.request(7, None, &[]);
    let shown = shown(&rig);
    assert!(shown.contains(&"Diagnosis (octet 1) = on".to_owned()), "{shown:?}");
    assert!(shown.contains(&"Range (octet 1) = 5".to_owned()), "{shown:?}");
}
