//! profirust 0.6.0, unmodified, as DP master: in this process in simulated time, and over a real pseudo-terminal.
//!
//! The words of the parameter channel are those of the manual (`ag03.md` 2.5), the masks of the status word those of
//! its flow charts (`ag03.md` 5).
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::wildcard_enum_match_arm,
    reason = "a test may panic"
)]

use core::time::Duration;

use profidrive::bench::{Line, Sender};
use profidrive::devices::StationEvent;
use profidrive::devices::ag03::param::{Model, Parameter};
use profidrive::devices::ag03::profibus::{CONFIGURATIONS, Config, DESCRIPTION, Event, IDENT_NUMBER};
use profidrive::devices::ag03::unit;
use profidrive::master::{Profirust, baudrate, options, peripheral};
use profidrive::profibus::dp;
use profidrive::profibus::fdl::Address;
use profidrive::profibus::ppo::{Inputs, Outputs, PPO_LEN, Pkw, Stw};
use profidrive::time::{BaudRate, Instant};
use profirust::dp::{
    DiagnosticFlags, DpMaster, Peripheral, PeripheralEvent, PeripheralHandle, PeripheralOptions,
};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};

/// Mask and value of the status word in the states of the flow charts.
const READY_TO_RUN: (u16, u16) = (0xAB6F, 0x2B23);
const OPERATION_ENABLED: (u16, u16) = (0x2B7F, 0x2B37);
const READY_TO_TRAVEL: (u16, u16) = (0xEB7F, 0xAB37);
const TRAVEL_JOB_ACTIVE: (u16, u16) = (0xEA7F, 0x0A37);
/// Bit 10 of the status word.
const TARGET_REACHED: (u16, u16) = (0x0400, 0x0400);
/// Bit 12: toggles with each job taken over.
const ACKNOWLEDGE: u16 = 0x1000;

const NO_JOB: &str = "0000 0000 0000 0000";
const READ_CALIBRATION_VALUE: &str = "13FA 0000 0000 0000";
const WRITE_LIMIT_1: &str = "33F8 0000 0003 D090";
const READ_LIMIT_1: &str = "13F8 0000 0000 0000";

fn pkw(words: &str) -> Pkw {
    let words: Vec<u16> = words.split(' ').map(|word| u16::from_str_radix(word, 16).unwrap()).collect();
    let octets: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
    Pkw::from_octets(octets.try_into().unwrap())
}

/// profirust and some drives, simulated.
struct Plant {
    bus: Line<Profirust<'static>>,
    drives: Vec<PeripheralHandle>,
    /// The job, the control word and the setpoint for each drive.
    outputs: Vec<(Pkw, u16, i32)>,
}

impl Plant {
    fn new(baud: BaudRate, addresses: &[u8]) -> Self {
        Self::with(baud, addresses, |_| {})
    }

    fn with(baud: BaudRate, addresses: &[u8], configure: impl FnOnce(&mut ParametersBuilder)) -> Self {
        let mut dp = DpMaster::new(Vec::new());
        let drives = addresses.iter().map(|address| dp.add(peripheral(*address, baud))).collect();
        dp.enter_operate();
        let mut parameters = ParametersBuilder::new(2, baudrate(baud));
        configure(&mut parameters);
        let mut fdl = FdlActiveStation::new(parameters.build_verified(&dp));
        fdl.set_online();
        let mut bus = Profirust::on_line(fdl, dp).unwrap();
        for address in addresses {
            bus.add_drive(Config::new(Address::station(*address).unwrap())).unwrap();
        }
        Self { bus, drives, outputs: vec![(Pkw::ZERO, 0, 0); addresses.len()] }
    }

    /// Waits until every drive exchanges data.
    fn start(&mut self) -> Duration {
        let drives = self.drives.clone();
        self.bus
            .run_until(Duration::from_secs(10), |bus| {
                drives.iter().all(|drive| bus.master.dp.get_mut(*drive).is_running())
            })
            .unwrap()
    }

    fn send(&mut self, drive: usize) {
        let (pkw, stw, hsw) = self.outputs[drive];
        let octets = Outputs::octets(pkw, Stw::from_raw(stw), hsw);
        self.bus.master.dp.get_mut(self.drives[drive]).pi_q_mut().copy_from_slice(&octets);
    }

    fn inputs(&mut self, drive: usize) -> (Pkw, u16, i32) {
        let inputs = self.bus.master.dp.get_mut(self.drives[drive]).pi_i();
        let inputs = Inputs::parse(inputs).unwrap();
        (inputs.pkw(), inputs.zsw().raw(), inputs.hiw())
    }

    fn wait(&mut self, drive: usize, what: &str, condition: impl Fn(Pkw, u16, i32) -> bool) -> Duration {
        let handle = self.drives[drive];
        let outcome = self.bus.run_until(Duration::from_secs(20), |bus| {
            let inputs = Inputs::parse(bus.master.dp.get_mut(handle).pi_i()).unwrap();
            condition(inputs.pkw(), inputs.zsw().raw(), inputs.hiw())
        });
        outcome.unwrap_or_else(|error| panic!("{what}: {error}; inputs {:04X?}", self.inputs(drive)))
    }

    /// Gives a job and waits for its reply, then takes the job back and waits for that too.
    fn job(&mut self, drive: usize, words: &str) -> String {
        self.outputs[drive].0 = pkw(words);
        self.send(drive);
        self.wait(drive, words, |pkw, _, _| pkw != Pkw::ZERO);
        let reply = self.inputs(drive).0.to_string();
        self.outputs[drive].0 = pkw(NO_JOB);
        self.send(drive);
        self.wait(drive, NO_JOB, |pkw, _, _| pkw == Pkw::ZERO);
        reply
    }

    fn command(&mut self, drive: usize, stw: u16, hsw: i32) {
        self.outputs[drive].1 = stw;
        self.outputs[drive].2 = hsw;
        self.send(drive);
    }

    fn wait_for(&mut self, drive: usize, (mask, value): (u16, u16)) -> Duration {
        self.wait(drive, &format!("status {value:04X} of mask {mask:04X}"), |_, zsw, _| zsw & mask == value)
    }

    fn assert(&mut self, drive: usize, (mask, value): (u16, u16)) {
        let zsw = self.inputs(drive).1;
        assert_eq!(zsw & mask, value, "ZSW {zsw:04X}, mask {mask:04X}");
    }

    /// Start-up done: parameters, enabling, a travel job and the one back.
    fn commission(&mut self, drive: usize) {
        assert_eq!(self.job(drive, READ_CALIBRATION_VALUE), "23FA 0000 0000 0000", "the default");
        assert_eq!(self.job(drive, WRITE_LIMIT_1), "23F8 0000 0003 D090");
        assert_eq!(self.job(drive, READ_LIMIT_1), "23F8 0000 0003 D090");
        self.assert(drive, READY_TO_RUN);

        self.command(drive, 0x000B, 0);
        self.wait_for(drive, OPERATION_ENABLED);
        self.assert(drive, READY_TO_TRAVEL);

        let accepted = self.inputs(drive).1 & ACKNOWLEDGE;
        self.command(drive, 0x003B, 800);
        self.command(drive, 0x007B, 800);
        self.wait_for(drive, TRAVEL_JOB_ACTIVE);
        assert_ne!(self.inputs(drive).1 & ACKNOWLEDGE, accepted, "taken over");
        self.wait_for(drive, TARGET_REACHED);
        self.assert(drive, READY_TO_TRAVEL);
        let position = self.inputs(drive).2;
        assert!((795..=805).contains(&position), "{position}");

        self.command(drive, 0x003B, 0);
        self.wait_for(drive, TRAVEL_JOB_ACTIVE);
        assert_eq!(self.inputs(drive).1 & ACKNOWLEDGE, accepted, "the falling edge is a job too");
        self.wait_for(drive, TARGET_REACHED);
        assert!(self.inputs(drive).2.abs() <= 5);

        self.command(drive, 0, 0);
        self.wait_for(drive, READY_TO_RUN);
    }

    fn assert_no_complaints(&mut self) {
        while let Some((address, event)) = self.bus.poll_event() {
            let expected = match event {
                StationEvent::Dp(event) => {
                    matches!(event, dp::Event::Parameterised { .. } | dp::Event::DataExchange { .. })
                }
                StationEvent::Device(ref event) => matches!(
                    event.of(),
                    Some(Event::Unit {
                        event: unit::Event::Drive(_)
                            | unit::Event::FaultCauseGone(_)
                            | unit::Event::Written { .. }
                            | unit::Event::Stored
                            | unit::Event::NotStored { .. }
                            | unit::Event::Input(_)
                            | unit::Event::SwitchesSet(_),
                        ..
                    })
                ),
                _ => false,
            };
            assert!(expected, "drive {address}: {event}");
        }
    }
}

#[test]
fn a_drive_is_commissioned_at_every_rate() {
    for baud in DESCRIPTION.rates.iter() {
        let mut plant = Plant::new(baud, &[5]);
        plant.start();
        plant.commission(0);
        plant.assert_no_complaints();
    }
}

/// The values of docs/links.md, with absent stations below the highest station address and a watchdog of 20 slot times.
#[test]
fn the_slot_times_of_the_guide_work_at_every_rate() {
    let guide = include_str!("../../docs/links.md");
    let (_, table) = guide.split_once("| rate | 20 ms: a serial adapter |").unwrap();
    let rows = table.lines().skip(2).map_while(|line| line.trim().strip_prefix('|'));
    let mut rates = 0;
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let (number, unit) = cells[0].split_at(cells[0].len() - 1);
        let factor = if unit == "k" { 1000.0 } else { 1_000_000.0 };
        let speed = (number.parse::<f64>().unwrap() * factor).round() as u32;
        let baud = BaudRate::from_bits_per_second(speed).unwrap();
        for cell in &cells[1..3] {
            let slot_bits: u16 = cell.split(' ').next().unwrap().parse().unwrap();
            let slot = baud.bit_times(slot_bits.into());
            let mut plant = Plant::with(baud, &[5], |parameters| {
                let watchdog = (20 * slot).max(Duration::from_millis(100));
                parameters
                    .slot_bits(slot_bits)
                    .token_rotation_bits((4 * u32::from(slot_bits)).max(32_436))
                    .watchdog_timeout(watchdog.into());
            });
            let started = plant.start();
            plant.commission(0);
            println!("{baud}, slot time {slot:?}: exchanges data after {started:?}");
        }
        rates += 1;
    }
    assert_eq!(rates, 9, "all but 45.45k, which these drives do not have");
}

#[test]
fn several_drives_on_one_wire_are_commissioned_one_after_the_other_and_travel_together() {
    let mut plant = Plant::new(BaudRate::K1500, &[5, 3, 125]);
    plant.start();
    for drive in 0..3 {
        plant.commission(drive);
    }
    let targets = [300, -300, 150];
    for (drive, target) in targets.into_iter().enumerate() {
        plant.command(drive, 0x003B, target);
        plant.wait_for(drive, READY_TO_TRAVEL);
    }
    for (drive, target) in targets.into_iter().enumerate() {
        plant.command(drive, 0x007B, target);
    }
    for (drive, target) in targets.into_iter().enumerate() {
        plant.wait(drive, "target", |_, zsw, hiw| zsw & 0x0400 != 0 && hiw.abs_diff(target) <= 5);
    }
    plant.assert_no_complaints();
}

#[test]
fn the_start_up_on_the_wire_is_the_one_of_the_standard() {
    let mut plant = Plant::with(BaudRate::K500, &[5], |parameters| {
        parameters.watchdog_timeout(profirust::time::Duration::from_millis(100));
    });
    let mut services = Vec::new();
    let mut events = Vec::new();
    let outcome = plant.bus.run_until(Duration::from_secs(1), |bus| {
        events.extend(bus.master.take_events().peripheral.map(|(_, event)| event));
        while let Some(heard) = bus.poll_telegram() {
            if heard.sender == Sender::Master && heard.octets.get(4) == Some(&0x85) {
                services.push((heard.octets[7], heard.octets[9..heard.octets.len() - 2].to_vec()));
            }
        }
        events.last() == Some(&PeripheralEvent::DataExchanged)
    });
    outcome.unwrap();
    // Lock, Sync, Freeze, watchdog 1 * 10 * 10 ms, min T_SDR 11, ident, no group.
    let prm = vec![0xB8, 1, 10, 11, 0x0A, 0xC5, 0];
    assert_eq!(
        services,
        [(60, vec![]), (61, prm), (62, vec![0xF3, 0xF2]), (60, vec![])],
        "Slave_Diag, Set_Prm, Chk_Cfg, Slave_Diag"
    );
    assert_eq!(
        events,
        [PeripheralEvent::Online, PeripheralEvent::Configured, PeripheralEvent::DataExchanged]
    );
}

#[test]
fn replies_keep_t_sdr_and_requests_keep_t_syn() {
    for baud in DESCRIPTION.rates.iter() {
        let mut plant = Plant::new(baud, &[5, 6]);
        let mut previous: Option<(Sender, Instant)> = None;
        let mut replies = 0;
        let outcome = plant.bus.run_until(Duration::from_secs(20), |bus| {
            while let Some(heard) = bus.poll_telegram() {
                let octets = u32::try_from(heard.octets.len()).unwrap();
                if let Some((sender, end)) = previous {
                    let pause = heard.at.saturating_since(end);
                    match heard.sender {
                        Sender::Test => panic!("the test sends nothing"),
                        Sender::Master => assert!(pause >= baud.bit_times(33), "{baud}: {pause:?}"),
                        Sender::Station => {
                            replies += 1;
                            assert_eq!(sender, Sender::Master);
                            assert!(pause >= baud.bit_times(11), "{baud}: {pause:?}");
                            assert!(
                                pause <= baud.bit_times(baud.max_tsdr_bits().into()),
                                "{baud}: {pause:?}"
                            );
                        }
                    }
                }
                previous = Some((heard.sender, heard.at.saturating_add(baud.octet_times(octets))));
            }
            replies >= 100
        });
        outcome.unwrap();
    }
}

#[test]
fn the_same_calls_give_the_same_telegrams_at_the_same_nanoseconds() {
    let play = || {
        let mut plant = Plant::new(BaudRate::K12000, &[5, 6]);
        plant.start();
        plant.command(0, 0x000B, 0);
        plant.wait_for(0, OPERATION_ENABLED);
        plant.bus.run_for(Duration::from_millis(3));
        let heard: Vec<_> = core::iter::from_fn(|| plant.bus.poll_telegram()).collect();
        (heard, plant.bus.now())
    };
    let (heard, now) = play();
    assert!(heard.len() > 10);
    assert_eq!(play(), (heard, now));
}

#[test]
fn a_master_that_stops_lets_the_watchdog_expire_and_finds_the_drive_again() {
    let mut plant = Plant::with(BaudRate::K500, &[5], |parameters| {
        parameters.watchdog_timeout(profirust::time::Duration::from_millis(50));
    });
    plant.start();
    plant.command(0, 0x000B, 0);
    plant.wait_for(0, OPERATION_ENABLED);
    plant.assert_no_complaints();

    plant.bus.master.fdl.set_offline();
    plant.bus.run_for(Duration::from_millis(60));
    let (_, event) = plant.bus.poll_event().expect("news of the watchdog");
    assert!(matches!(event, StationEvent::Dp(dp::Event::WatchdogExpired { .. })), "{event}");
    assert!(!plant.bus.device(5).unwrap().status().operation_enabled, "a lost master lets the drive go");

    plant.command(0, 0, 0);
    plant.bus.master.fdl.set_online();
    plant.wait_for(0, READY_TO_RUN);
    plant.command(0, 0x000B, 0);
    plant.wait_for(0, OPERATION_ENABLED);
}

/// A bus on which the master has this wrong idea of drive 5.
fn misconfigured(options: PeripheralOptions<'static>) -> (Line<Profirust<'static>>, PeripheralHandle) {
    let mut dp = DpMaster::new(Vec::new());
    let drive = dp.add(Peripheral::new(5, options, vec![0; PPO_LEN], vec![0; PPO_LEN]));
    dp.enter_operate();
    let parameters = ParametersBuilder::new(2, baudrate(BaudRate::K500)).build_verified(&dp);
    let mut fdl = FdlActiveStation::new(parameters);
    fdl.set_online();
    let mut bus = Profirust::on_line(fdl, dp).unwrap();
    bus.add_drive(Config::new(Address::station(5).unwrap())).unwrap();
    (bus, drive)
}

#[test]
fn a_wrong_ident_number_shows_in_the_diagnosis_and_in_the_news_of_the_drive() {
    let (mut bus, drive) =
        misconfigured(PeripheralOptions { ident_number: 0x1234, ..options(BaudRate::K500) });
    // profirust sends Chk_Cfg all the same, is refused (RS: no Set_Prm was accepted), and takes the drive for gone.
    // It says ParameterError only if the slave answers Chk_Cfg nevertheless.
    bus.run_until(Duration::from_secs(1), |bus| {
        let diagnosis = bus.master.dp.get_mut(drive).last_diagnostics();
        diagnosis.is_some_and(|diagnosis| diagnosis.flags.contains(DiagnosticFlags::PARAMETER_FAULT))
    })
    .unwrap();
    let (_, event) = bus.poll_event().unwrap();
    assert!(matches!(event, StationEvent::Dp(dp::Event::PrmRejected { .. })), "{event}");
    assert!(!bus.master.dp.get_mut(drive).is_running());
}

#[test]
fn a_wrong_configuration_is_told_to_both_sides() {
    let (mut bus, drive) =
        misconfigured(PeripheralOptions { config: Some(&[0xF3, 0xF3]), ..options(BaudRate::K500) });
    bus.run_until(Duration::from_secs(1), |bus| {
        let events = bus.master.take_events();
        events.peripheral == Some((drive, PeripheralEvent::ConfigError))
    })
    .unwrap();
    let refused = core::iter::from_fn(|| bus.poll_event())
        .any(|(_, event)| matches!(event, StationEvent::Dp(dp::Event::CfgRejected { .. })));
    assert!(refused);
}

#[test]
fn the_master_knows_what_the_device_and_the_gsd_say() {
    let drive = peripheral(5, BaudRate::K500);
    assert_eq!((drive.pi_i().len(), drive.pi_q().len()), (PPO_LEN, PPO_LEN));
    let gsd = gsd_parser::parse_from_file("gsd/SIKO0AC5.GSD");
    for baud in DESCRIPTION.rates.iter() {
        let options = options(baud);
        assert_eq!(options.ident_number, gsd.ident_number);
        assert_eq!(options.ident_number, IDENT_NUMBER);
        assert_eq!(options.config, Some(CONFIGURATIONS[0]));
        assert_eq!(options.config, Some(&gsd.available_modules[0].config[..]));
        assert_eq!((options.sync_mode, options.freeze_mode), (true, true));
        assert_eq!(options.user_parameters, Some(&[][..]), "None would wait for ever");
    }
}

#[test]
fn both_models_are_on_the_bus_as_they_were_connected() {
    let mut plant = Plant::new(BaudRate::K500, &[5]);
    let ag03 = Config { model: Model::Ag03, ..Config::new(Address::station(6).unwrap()) };
    plant.bus.add_drive(ag03).unwrap();
    assert!(plant.bus.add_drive(ag03).is_err(), "one drive per address");
    let handle = plant.bus.master.dp.add(peripheral(6, BaudRate::K500));
    plant.drives.push(handle);
    plant.outputs.push((Pkw::ZERO, 0, 0));
    plant.start();
    plant.job(1, WRITE_LIMIT_1);
    assert_eq!(plant.bus.device(6).unwrap().parameters().value(Parameter::Limit1), 250_000);
    assert_ne!(plant.bus.device(5).unwrap().parameters().value(Parameter::Limit1), 250_000);
    assert!(plant.bus.device(7).is_none());
}

/// The same over a real pseudo-terminal: `host::run` in a thread has the drive, profirust opens the terminal as it
/// would open a serial port. Time is real here, and decides nothing: profirust is given a slot time beyond anything a
/// loaded machine does, and the waits end with what they wait for.
#[cfg(target_os = "linux")]
mod over_a_pseudo_terminal {
    use core::time::Duration;
    use std::thread;

    use profidrive::devices::ag03::profibus::{Config, Device};
    use profidrive::host::link::{pty::Pty, serial::Serial};
    use profidrive::host::{self, Bus, Clock, Link, Stop, SystemClock};
    use profidrive::master::{LinkPhy, baudrate, instant, peripheral};
    use profidrive::profibus::fdl::Address;
    use profidrive::profibus::ppo::{Inputs, Outputs, Pkw, Stw};
    use profidrive::time::BaudRate;
    use profirust::dp::{DpMaster, PeripheralHandle};
    use profirust::fdl::{FdlActiveStation, ParametersBuilder};

    use super::{
        ACKNOWLEDGE, OPERATION_ENABLED, READ_CALIBRATION_VALUE, READ_LIMIT_1, READY_TO_RUN, READY_TO_TRAVEL,
        WRITE_LIMIT_1, pkw,
    };
    use crate::patience::PATIENCE;

    const BAUD: BaudRate = BaudRate::K500;
    /// 50 ms at 500 kbit/s. A late answer costs a retry, of which there are 15. More would slow this test: profirust
    /// waits a slot time for an absent station in every round.
    const SLOT_BITS: u16 = 25_000;

    struct Master {
        fdl: FdlActiveStation,
        dp: DpMaster<'static>,
        phy: LinkPhy<Serial>,
        drive: PeripheralHandle,
        clock: SystemClock,
        stop: Stop,
    }

    impl Master {
        fn open(terminal: &str) -> Self {
            let mut dp = DpMaster::new(Vec::new());
            let drive = dp.add(peripheral(5, BAUD));
            dp.enter_operate();
            let parameters = ParametersBuilder::new(2, baudrate(BAUD))
                .slot_bits(SLOT_BITS)
                .max_retry_limit(15)
                .build_verified(&dp);
            let mut fdl = FdlActiveStation::new(parameters);
            fdl.set_online();
            let phy = LinkPhy::new(Serial::open(terminal, BAUD).unwrap(), BAUD);
            Self { fdl, dp, phy, drive, clock: SystemClock::new(), stop: Stop::new().unwrap() }
        }

        fn send(&mut self, words: &str, stw: u16, hsw: i32) {
            let octets = Outputs::octets(pkw(words), Stw::from_raw(stw), hsw);
            self.dp.get_mut(self.drive).pi_q_mut().copy_from_slice(&octets);
        }

        fn wait(&mut self, what: &str, condition: impl Fn(Pkw, u16, i32) -> bool) {
            let begun = self.clock.now();
            loop {
                self.fdl.poll(instant(self.clock.now()), &mut self.phy, &mut self.dp);
                assert!(self.phy.take_error().is_none());
                let drive = self.dp.get_mut(self.drive);
                let inputs = Inputs::parse(drive.pi_i()).unwrap();
                let (pkw, zsw, hiw) = (inputs.pkw(), inputs.zsw().raw(), inputs.hiw());
                if drive.is_running() && condition(pkw, zsw, hiw) {
                    return;
                }
                let waited = self.clock.now().saturating_since(begun);
                assert!(waited < PATIENCE, "{what}: waited {waited:?}; {pkw} {zsw:04X} {hiw}");
                // Sleeps until octets have arrived, or profirust may have something to send.
                self.phy.link_mut().wait(Some(Duration::from_micros(200)), &self.stop).unwrap();
            }
        }

        fn job(&mut self, words: &str, reply: &str) {
            self.send(words, 0, 0);
            self.wait(words, |pkw, _, _| pkw.to_string() == reply);
            self.send("0000 0000 0000 0000", 0, 0);
            self.wait("job taken back", |pkw, _, _| pkw == Pkw::ZERO);
        }

        fn command(&mut self, stw: u16, hsw: i32, (mask, value): (u16, u16)) {
            self.send("0000 0000 0000 0000", stw, hsw);
            self.wait(&format!("status after {stw:04X}"), |_, zsw, _| zsw & mask == value);
        }
    }

    #[test]
    fn a_drive_in_another_thread_is_commissioned_over_a_pseudo_terminal() {
        let mut pty = Pty::open(None).unwrap();
        let terminal = pty.path().to_str().unwrap().to_owned();
        let stop = Stop::new().unwrap();
        let clock = SystemClock::new();
        let mut bus = Bus::new();
        let config = Config { baud: BAUD, ..Config::new(Address::station(5).unwrap()) };
        bus.add(Device::new(config, clock.now())).unwrap();
        thread::scope(|scope| {
            let slave = scope.spawn(|| host::run(&mut pty, &mut bus, &clock, &stop, &mut |_| {}));
            // The slave's thread ends with the master, whatever happens to it.
            let master = scope.spawn(|| commission(&terminal)).join();
            stop.request();
            slave.join().unwrap().unwrap();
            if let Err(panic) = master {
                std::panic::resume_unwind(panic);
            }
        });
    }

    fn commission(terminal: &str) {
        let mut master = Master::open(terminal);
        master.wait("ready", |_, zsw, _| zsw & READY_TO_RUN.0 == READY_TO_RUN.1);
        master.job(READ_CALIBRATION_VALUE, "23FA 0000 0000 0000");
        master.job(WRITE_LIMIT_1, "23F8 0000 0003 D090");
        master.job(READ_LIMIT_1, "23F8 0000 0003 D090");
        master.command(0x000B, 0, OPERATION_ENABLED);
        master.command(0x003B, 400, READY_TO_TRAVEL);
        // A job can be over before a slow machine looks; that it was taken over stays in bit 12.
        master.send("0000 0000 0000 0000", 0x007B, 400);
        let arrived = |toggle: u16, target: i32| {
            move |_, zsw, hiw: i32| {
                zsw & ACKNOWLEDGE == toggle && zsw & 0x0400 != 0 && hiw.abs_diff(target) <= 5
            }
        };
        master.wait("400", arrived(ACKNOWLEDGE, 400));
        master.send("0000 0000 0000 0000", 0x003B, 0);
        master.wait("0", arrived(0, 0));
        master.command(0, 0, READY_TO_RUN);
    }
}
