//! A drive in virtual time whose events are read as lines of text.

use std::time::Duration;

use crate::drive_line::{IDENT, Line};
use profidrive::devices::StationEvent;
use profidrive::devices::ag03::drive::Inputs;
use profidrive::devices::ag03::param::{Pnu, Value};
use profidrive::devices::ag03::profibus::Config;
use profidrive::face::EventKind;
use profidrive::profibus::fdl::Address;

/// The outputs are sent this often, well below the watchdog time.
pub(crate) const CYCLE: Duration = Duration::from_millis(20);
/// Lock, watchdog 100 ms, Sync and Freeze enabled, min T_SDR 11, groups 1 and 3.
pub(crate) const PRM: [u8; 7] = [0xB8, 10, 1, 11, IDENT[0], IDENT[1], 0x05];

/// A drive at address 5, its master 2, and what PKW says in each cycle.
pub(crate) struct Told {
    pub(crate) line: Line,
    pub(crate) pkw: [u8; 8],
}

impl Told {
    pub(crate) fn new() -> Self {
        Self { line: Line::new(), pkw: [0; 8] }
    }

    /// Another drive; it is at the address of its switches.
    pub(crate) fn with(config: impl FnOnce(Config) -> Config) -> Self {
        let line = Line::with(config(*Line::new().device.config()));
        Self { line, ..Self::new() }
    }

    /// In Data_Exchange, and nothing is told yet.
    pub(crate) fn exchanging() -> Self {
        let mut told = Self::new();
        told.line.start_up_with(&PRM);
        told.line.events.clear();
        told
    }

    /// Enabled, after OFF1 was seen; nothing is told yet.
    pub(crate) fn enabled() -> Self {
        let mut told = Self::exchanging();
        told.say(0x0000, 0, CYCLE);
        told.say(0x003B, 0, CYCLE);
        assert!(told.line.device.status().operation_enabled);
        told.line.events.clear();
        told
    }

    /// What has happened since this was asked last, without cyclic detail.
    pub(crate) fn texts(&mut self) -> Vec<String> {
        self.line.events.drain(..).filter(|event| !event.is_detail()).map(|event| event.to_string()).collect()
    }

    /// The hints among that.
    pub(crate) fn hints(&mut self) -> Vec<String> {
        let hint = |event: StationEvent<_>| (event.kind() == EventKind::Hint).then(|| event.to_string());
        self.line.events.drain(..).filter_map(hint).collect()
    }

    pub(crate) fn inputs(&mut self, inputs: Inputs) {
        self.line.device.set_inputs(self.line.now, inputs);
    }

    /// Writes a parameter without the bus.
    pub(crate) fn write(&mut self, pnu: u16, value: Value) {
        let pnu = Pnu::new(pnu).unwrap();
        self.line.device.write_parameter(self.line.now, pnu, None, value).unwrap();
    }

    /// Exchanges these outputs for `time`, at least twice.
    pub(crate) fn say(&mut self, stw: u16, setpoint: i32, time: Duration) {
        let end = self.line.now.saturating_add(time);
        self.exchange(stw, setpoint);
        while self.line.now < end {
            self.line.wait(CYCLE);
            self.exchange(stw, setpoint);
        }
    }

    /// Exchanges these outputs once.
    pub(crate) fn exchange(&mut self, stw: u16, setpoint: i32) {
        let mut outputs = [0; 14];
        outputs[..8].copy_from_slice(&self.pkw);
        outputs[8..10].copy_from_slice(&stw.to_be_bytes());
        outputs[10..].copy_from_slice(&setpoint.to_be_bytes());
        self.line.exchange(&outputs);
    }
}

pub(crate) fn address(number: u8) -> Address {
    Address::station(number).unwrap()
}
