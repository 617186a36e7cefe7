//! Stations from GSDs and profirust 0.6.0 as their master, which reads the same files with gsd-parser 0.6.0: over a
//! pseudo-terminal, over TCP, and in simulated time where something is refused.

use core::time::Duration;
use std::path::{Path, PathBuf};

use gsd_parser::{GenericStationDescription, PrmBuilder};
use profidrive::gsd::{Gsd, Policy, Station};
use profidrive::host::{BusEvent, GsdStation, Refusals};
use profidrive::master::{Profirust, baudrate};
use profidrive::profibus::fdl::Address;
use profidrive::time::BaudRate;
use profirust::dp::{DpMaster, Peripheral, PeripheralOptions};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};

const BAUD: BaudRate = BaudRate::K500;

/// Every kind of station: its file, the modules that a project has, and the octets out and in.
const STATIONS: [(&str, &[&str], usize, usize); 8] = [
    ("compact.gsd", &["PPO 1"], 12, 12),
    ("modular.gsd", &["2 out, 1 in", "empty slot", "2 inputs", "2 in, 2 out"], 4, 5),
    ("slots.gsd", &["out", "both"], 2, 1),
    ("preset.gsd", &["head", "valves"], 2, 1),
    ("extended_prm.gsd", &["1 in, 1 out"], 1, 1),
    ("unit_diag.gsd", &["special"], 2, 8),
    ("dpv1.gsd", &["p", "q", "p"], 1, 2),
    ("remote_io.gsd", &["8 DI", "8 DO", "2 AI", "2 AO"], 5, 5),
];

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gsd").join(name)
}

/// A project of a master: what its own reading of the file says.
struct Project {
    description: GenericStationDescription,
    user_parameters: Vec<u8>,
    config: Vec<u8>,
    outputs: usize,
    inputs: usize,
}

impl Project {
    fn new((name, modules, outputs, inputs): (&str, &[&str], usize, usize)) -> Self {
        // It knows no sign in a keyword.
        let text = std::fs::read_to_string(path(name)).unwrap().replace("Unit_Diag_!Bit", "Unit_Diag_Bit");
        let description = gsd_parser::parser::parse(&path(name), &text).unwrap();
        let module = |wanted: &&str| {
            description.available_modules.iter().find(|module| module.name == **wanted).unwrap().clone()
        };
        let modules: Vec<_> = modules.iter().map(module).collect();
        let mut user_parameters = PrmBuilder::new(&description.user_prm_data).into_bytes();
        for module in &modules {
            user_parameters.extend(PrmBuilder::new(&module.module_prm_data).into_bytes());
        }
        let config = modules.iter().flat_map(|module| module.config.clone()).collect();
        Self { description, user_parameters, config, outputs, inputs }
    }

    fn peripheral(&self, address: u8) -> Peripheral<'_> {
        let options = PeripheralOptions {
            ident_number: self.description.ident_number,
            sync_mode: self.description.sync_mode_supported,
            freeze_mode: self.description.freeze_mode_supported,
            groups: 0,
            max_tsdr: self.description.max_tsdr.b500000,
            fail_safe: self.description.fail_safe,
            user_parameters: Some(&self.user_parameters),
            config: Some(&self.config),
        };
        Peripheral::new(address, options, vec![0; self.inputs], vec![0; self.outputs])
    }
}

fn station(address: u8, name: &str, policy: Policy, refusals: &Refusals) -> GsdStation {
    let gsd = Gsd::read(&std::fs::read(path(name)).unwrap()).unwrap();
    let station = Station::new(gsd, policy).unwrap();
    GsdStation::new(Address::station(address).unwrap(), BAUD, station, refusals.clone())
}

/// What a simulated master hears of a station it projects wrongly: the words of the refusal.
fn refusal(name: &str, wrong: impl FnOnce(&mut Project)) -> String {
    let row = STATIONS.into_iter().find(|row| row.0 == name).unwrap();
    let mut project = Project::new(row);
    wrong(&mut project);
    let project: &'static Project = Box::leak(Box::new(project));
    let refusals = Refusals::default();
    let mut dp = DpMaster::new(Vec::new());
    let handle = dp.add(project.peripheral(7));
    dp.enter_operate();
    let mut fdl = FdlActiveStation::new(ParametersBuilder::new(2, baudrate(BAUD)).build_verified(&dp));
    fdl.set_online();
    let mut bus = Profirust::on_line(fdl, dp).unwrap();
    bus.add(station(7, name, Policy::STRICT, &refusals)).unwrap();
    let mut said = None;
    bus.run_until(Duration::from_secs(10), |bus| {
        while let Some((address, event)) = bus.poll_event() {
            let event = BusEvent::Station { address, event };
            let own = event.to_string();
            let words = refusals.words(&event).map_or(own.clone(), |words| format!("{own}: {words}"));
            if words.contains("refused") {
                said.get_or_insert(words);
            }
        }
        said.is_some()
    })
    .unwrap();
    assert!(!bus.master.dp.get_mut(handle).is_running());
    said.unwrap()
}

#[test]
fn what_a_master_projects_wrongly_is_refused_in_our_words() {
    for (name, wrong, words) in [
        (
            "remote_io.gsd",
            (|project| project.config[1] = 0x21) as fn(&mut Project),
            "Chk_Cfg octet 2: 0x21: slot 2: no module begins with this; expected '8 DI', '8 DO', '2 AI', '2 AO'",
        ),
        (
            "compact.gsd",
            |project| project.config[1] = 0xF5,
            "Chk_Cfg octet 2: 0xF5, expected 0xF1: module 'PPO 1' stands here; the station has the one configuration F3 F1",
        ),
        (
            "slots.gsd",
            |project| project.config = vec![0x10, 0x20],
            "Chk_Cfg octet 2: 0x20: module 'out' may not be in slot 2 'tail'; expected 'both'",
        ),
        (
            "modular.gsd",
            |project| project.config = vec![0x11; 5],
            "Chk_Cfg octet 5: 0x11: the station takes 4 modules (Max_Module): take the others out",
        ),
        (
            "extended_prm.gsd",
            |project| project.user_parameters[3] = 11,
            "parameter 'Offset' is -245, expected -10..10",
        ),
        ("dpv1.gsd", |project| project.user_parameters.truncate(2), "user parameters"),
        ("compact.gsd", |project| project.user_parameters.push(0), "user parameters"),
    ] {
        let said = refusal(name, wrong);
        assert!(said.contains(words), "{name}: {said}");
    }
}

#[test]
fn the_words_of_a_refusal_outlive_the_station_that_refused() {
    let refusals = Refusals::default();
    let mut bus = profidrive::host::Bus::new();
    bus.add(station(7, "remote_io.gsd", Policy::PROPOSED, &refusals)).unwrap();
    let now = profidrive::time::Instant::ZERO;
    let prm = [0x88, 20, 100, 11, 0x0A, 0x08, 0];
    for (sap, data) in [(61, &prm[..]), (62, &[0x21])] {
        let body: Vec<u8> = [&[0x87, 0x82, 0x7D ^ (u8::from(sap == 61) << 4), sap, 62][..], data].concat();
        let len = body.len() as u8;
        let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
        bus.handle_bytes(now, &[&[0x68, len, len, 0x68][..], &body, &[sum, 0x16]].concat());
    }
    let removed = bus.remove(Address::station(7).unwrap());
    assert!(removed.is_some());
    drop(removed);
    let mut told = Vec::new();
    while let Some(event) = bus.poll_event() {
        told.extend(refusals.words(&event));
    }
    assert_eq!(told.len(), 1, "once");
    assert!(told[0].starts_with("slot 1: no module begins with this; expected '8 DI'"), "{}", told[0]);
}

/// Time is real here and decides nothing, as for drives.
#[cfg(target_os = "linux")]
mod over_real_links {
    use std::thread;

    use profidrive::host::link::{pty::Pty, serial::Serial, tcp};
    use profidrive::host::{self, Bus, Clock, Link, Reach, Stop, SystemClock};
    use profidrive::master::{LinkPhy, instant};

    use super::*;
    use crate::patience::PATIENCE;

    /// 50 ms at 500 kbit/s.
    const SLOT_BITS: u16 = 25_000;

    /// Every station on one line; each gets the outputs 1, 2, 3, ...
    fn exchange(mut link: impl Link + Send, open: impl FnOnce() -> Box<dyn Link> + Send) {
        let (stop, clock) = (Stop::new().unwrap(), SystemClock::new());
        let mut bus = Bus::new();
        for (number, row) in (0..).zip(STATIONS) {
            bus.add(station(10 + number, row.0, Policy::STRICT, &Refusals::default())).unwrap();
        }
        thread::scope(|scope| {
            let slaves = scope.spawn(|| {
                let outcome = host::run(&mut link, &mut bus, &clock, &stop, &mut |_| {});
                (outcome, bus)
            });
            let master = scope.spawn(|| play(open())).join();
            stop.request();
            let (outcome, bus) = slaves.join().unwrap();
            outcome.unwrap();
            if let Err(panic) = master {
                std::panic::resume_unwind(panic);
            }
            for (number, (name, modules, outputs, _)) in (0..).zip(STATIONS) {
                let station = bus.station::<GsdStation>(Address::station(10 + number).unwrap()).unwrap();
                let layout = station.layout();
                let names: Vec<_> = layout.iter().map(|placed| placed.name(station.gsd())).collect();
                assert_eq!(names, modules, "{name}: what the master chose");
                let got: Vec<u8> =
                    layout.iter().flat_map(|placed| station.outputs(&placed.slot).to_vec()).collect();
                assert_eq!(got, (1..).take(outputs).collect::<Vec<u8>>(), "{name}");
            }
        });
    }

    fn play(link: Box<dyn Link>) {
        let projects: Vec<_> = STATIONS.into_iter().map(Project::new).collect();
        let mut dp = DpMaster::new(Vec::new());
        let handles: Vec<_> =
            (10..).zip(&projects).map(|(address, project)| dp.add(project.peripheral(address))).collect();
        dp.enter_operate();
        let parameters = ParametersBuilder::new(2, baudrate(BAUD))
            .slot_bits(SLOT_BITS)
            .max_retry_limit(15)
            .highest_station_address(20)
            .build_verified(&dp);
        let mut fdl = FdlActiveStation::new(parameters);
        fdl.set_online();
        let mut phy = LinkPhy::new(link, BAUD);
        let (clock, stop) = (SystemClock::new(), Stop::new().unwrap());
        let mut cycles = 0;
        while cycles < 20 {
            fdl.poll(instant(clock.now()), &mut phy, &mut dp);
            assert!(phy.take_error().is_none());
            let mut running = 0;
            for handle in &handles {
                let peripheral = dp.get_mut(*handle);
                for (octet, value) in peripheral.pi_q_mut().iter_mut().zip(1..) {
                    *octet = value;
                }
                running += usize::from(peripheral.is_running());
            }
            let cycle_completed = dp.take_last_events().cycle_completed;
            cycles += usize::from(running == handles.len() && cycle_completed);
            assert!(
                u128::from(clock.now().as_nanos()) < PATIENCE.as_nanos(),
                "{running} of {} run",
                handles.len()
            );
            phy.link_mut().wait(Some(Duration::from_micros(200)), &stop).unwrap();
        }
    }

    #[test]
    fn every_kind_of_station_exchanges_data_over_a_pseudo_terminal() {
        let pty = Pty::open(None).unwrap();
        let terminal = pty.path().to_str().unwrap().to_owned();
        exchange(pty, move || Box::new(Serial::open(&terminal, BAUD).unwrap()));
    }

    #[test]
    fn every_kind_of_station_exchanges_data_over_tcp() {
        let tcp = tcp::Tcp::bind("127.0.0.1:0", BAUD, Reach::ThisMachine).unwrap();
        let place = tcp.address().to_string();
        exchange(tcp, move || Box::new(tcp::Connection::open(&place).unwrap()));
    }
}
