//! What the thread of a bus of PROFIBUS lends to the threads of HTTP.

use core::any::Any;

use super::super::problem::Problem;
use super::super::station::{State, ValueState};
use super::state::{self, Counted, Counters};
use super::{Act, Acted, OnLine, Silent, Station, in_one_line, no_station};
use crate::explain::Known;
use crate::face::description::{Amount, Group, Supply, Value};
use crate::face::{Description, Operation};
use crate::host::fault::{BusKind, Listed, Rule, While};
use crate::host::link::fault::Faults;
use crate::host::list::{self, Ground, MakeError, Spec};
use crate::host::{Appearance, Bus, Startup, StateDirError};
use crate::panel::modules;
use crate::profibus::dp;
use crate::profibus::fdl::{Address, StationCounters};
use crate::time::{BaudRate, Instant};

/// What the panel may see and change, lent by the thread of the bus between two telegrams.
pub struct BusAccess<'a> {
    /// The bus.
    pub bus: &'a mut Bus,
    /// The faults on the line; `None`: the link has none.
    pub faults: Option<&'a mut Faults>,
    /// What a station that is added finds; with the time now.
    pub ground: Ground<'a>,
    /// What is chosen about every station that is added: its quirks.
    pub choose: &'a dyn Fn(&mut Spec),
    /// Whether a station that is added listens first whether its address is live ([`Bus::join`]).
    pub listen: bool,
}

/// The link has none.
fn no_faults() -> Problem {
    Problem::conflict("this line cannot have faults")
}

impl BusAccess<'_> {
    /// Logs who is on the line after a station was added or removed, and which faults are for none of them.
    fn announce(&self) {
        let mut addresses = self.addresses();
        addresses.sort_unstable();
        let stations: Vec<_> = addresses.iter().map(ToString::to_string).collect();
        let stations = if stations.is_empty() { "no station".into() } else { stations.join(", ") };
        tracing::info!("on the line now: {stations}");
        for (_, fault, _) in self.faults.iter().flat_map(|faults| faults.iter()) {
            if let Err(error) = fault.check(self.bus.addresses().map(Address::number)) {
                tracing::warn!("{error}");
            }
        }
    }

    /// 409 if a station that comes to `wanted`, where its switches are read, would meet another one there.
    fn stays_apart(&self, address: Address, wanted: Option<Address>) -> Result<(), Problem> {
        match wanted.filter(|wanted| *wanted != address) {
            Some(wanted) if self.bus.presence(wanted).is_some() => Err(Problem::conflict(format!(
                "the DIP switches say address {wanted}, which another station has; set them to a free one"
            ))),
            Some(_) | None => Ok(()),
        }
    }

    /// The refusal of a station that cannot be made, with the one that has its memory now.
    fn not_made(&self, error: &MakeError) -> Problem {
        let MakeError::State(StateDirError::Owned { path }) = error else {
            return Problem::conflict(in_one_line(error));
        };
        let has_it = |address: &Address| self.bus.path(*address).as_ref() == Some(path);
        match self.bus.addresses().find(has_it) {
            Some(address) => Problem::conflict(format!(
                "the EEPROM image {} belongs to the drive at address {address}, which was added under this address and \
                 moved by its DIP switches; move it back or remove it, or choose another address",
                path.display()
            )),
            None => Problem::conflict(in_one_line(error)),
        }
    }
}

fn dp_state(state: dp::State) -> &'static str {
    match state {
        dp::State::WaitPrm => "WAIT-PRM",
        dp::State::WaitCfg => "WAIT-CFG",
        dp::State::DataExch => "DATA-EXCH",
    }
}

/// What a station was asked and answered.
fn counted(counters: &StationCounters) -> [(&'static str, u64); 5] {
    [
        ("requests", counters.requests.total()),
        ("retries", counters.retries),
        ("replies", counters.replies),
        ("replies_too_late", counters.too_late),
        ("watchdog_expiries", counters.watchdog_expiries),
    ]
}

impl OnLine for BusAccess<'_> {
    fn now(&self) -> Instant {
        self.ground.now
    }

    fn kind(&self) -> BusKind {
        BusKind::Profibus
    }

    fn addresses(&self) -> Vec<u8> {
        self.bus.addresses().map(Address::number).collect()
    }

    fn station(&self, address: u8) -> Option<Station<'_>> {
        let address = Address::from_octet(address);
        let Appearance { device, model, product, slave, owner, .. } = self.bus.appearance(address)?;
        let description = self.bus.description(address).unwrap_or(&Silent);
        Some(Station {
            description,
            device: if device.is_empty() { "own" } else { device },
            product: if product.is_empty() { model } else { product },
            power: description.supply(),
            presence: self.bus.presence(address),
            exchanging: slave == Some(dp::State::DataExch),
            bus_state: slave.map(|state| dp_state(state).into()),
            owner: owner.map(Address::number),
        })
    }

    fn described(&self, address: u8) -> Option<&dyn Description> {
        self.bus.description(Address::from_octet(address))
    }

    fn complete(&self, address: u8, state: &mut State) {
        let address = Address::from_octet(address);
        let Some(Appearance { ident, watchdog, .. }) = self.bus.appearance(address) else { return };
        let ident = ident.map(|ident| format!("0x{ident:04X}"));
        if let Some(ident) = &ident {
            let value = Value::new("ident", "Ident number", Group::Slave, Amount::Text(ident));
            state.values.push(ValueState::of(&value));
        }
        #[expect(clippy::cast_precision_loss, reason = "no watchdog has more than 650 s")]
        let watchdog = watchdog.map(|time| time.as_millis() as f64);
        let value = Value::new("watchdog", "Watchdog", Group::Slave, watchdog.into()).unit("ms");
        state.values.push(ValueState::of(&value));
        let counters = self.bus.station_counters(address).map(counted).unwrap_or_default();
        state.counters.extend(counters.map(|(key, count)| ValueState::counter(key, count)));
        if let Some(modules) = self.bus.modules(address) {
            state.has.modules = true;
            let (slave, raised) = (modules.slave(), modules.raised());
            let texts = modules.report_words();
            state.diagnosis =
                Some(modules::Diagnosis::of(raised, texts, slave.diagnosis(), slave.ext_diag()));
        }
    }

    fn act(&mut self, address: u8, act: &Act<'_>) -> Result<(), Problem> {
        let there = self.addresses();
        let at = Address::from_octet(address);
        let none = || no_station(address, &there);
        let device = self.station(address).ok_or_else(none)?.device;
        let acted = Acted { now: self.ground.now, device };
        // What is refused is refused below.
        let wanted = self.bus.address_after(at, &|station| drop(act(station, &acted)));
        self.stays_apart(at, wanted)?;
        let done = self.bus.with_description(at, |station| act(station, &acted));
        done.unwrap_or_else(|| act(&mut Silent, &acted))
    }

    fn switch(&mut self, address: u8, on: bool) -> Result<Supply, Problem> {
        let (now, at) = (self.ground.now, Address::from_octet(address));
        let switch = |station: &mut dyn Description| {
            if !(on && station.supply() == Some(Supply::On)) {
                station.switch_supply(now, on);
            }
        };
        let supply = self.bus.description(at).and_then(Description::supply);
        supply.ok_or_else(|| super::lacks(address, "switch of its power"))?;
        let wanted = if on { self.bus.address_after(at, &switch) } else { None };
        self.stays_apart(at, wanted)?;
        let switched = self.bus.with_description(at, |station| {
            switch(station);
            station.supply()
        });
        Ok(switched.flatten().unwrap_or(Supply::Off))
    }

    fn add(&mut self, mut spec: Spec) -> Result<u8, Problem> {
        if spec.device.group() == list::Group::Node {
            return Err(Problem::value(format!(
                "{} is on CANopen, this line is PROFIBUS",
                spec.device.name()
            )));
        }
        let address = spec.address();
        if self.bus.presence(address).is_some() {
            return Err(Problem::conflict(format!(
                "address {address} is taken; choose another, or remove that one"
            )));
        }
        (self.choose)(&mut spec);
        let prepared = spec.prepare().map_err(|wrong| Problem::value(wrong.words))?;
        let station = prepared.make(&self.ground).map_err(|error| self.not_made(&error))?;
        let address = station.address().number();
        self.bus.connect(self.ground.now, station, self.listen).map_err(Problem::conflict)?;
        self.announce();
        Ok(address)
    }

    fn remove(&mut self, address: u8) -> Option<Box<dyn Any + Send>> {
        let removed = self.bus.remove(Address::from_octet(address))?;
        self.announce();
        Some(removed)
    }

    fn state(&self) -> Counted {
        let station = |address: Address| state::LineStation {
            address: address.number(),
            device: self.station(address.number()).map_or("own", |station| station.device),
            presence: self.bus.presence(address),
            owner_address: self.bus.appearance(address).and_then(|seen| seen.owner).map(Address::number),
            counters: self.bus.station_counters(address).map(counted).unwrap_or_default().into(),
            reply_times: self.bus.station_counters(address).map(state::ReplyTime::of),
            error_state: None,
        };
        Counted {
            rate_bits_per_second: self.bus.baud().bits_per_second(),
            counters: Counters::of_profibus(self.bus.counters()),
            stations: self.bus.addresses().map(station).collect(),
        }
    }

    fn baud(&self) -> Option<BaudRate> {
        Some(self.bus.baud())
    }

    fn faults(&self) -> Result<Vec<Listed>, Problem> {
        self.faults.as_ref().map(|faults| faults.listed().collect()).ok_or_else(no_faults)
    }

    fn check_fault(&self, rule: &Rule) -> Result<(), Problem> {
        rule.check(self.bus.addresses().map(Address::number))
            .map_err(|error| Problem::value(error.to_string()))?;
        match rule.while_input {
            Some(While { station, .. }) if self.bus.modules(station).is_none() => {
                Err(Problem::value(format!(
                    "fault '{rule}' waits for an input of station {station}, which is no station from a GSD of this line"
                )))
            }
            Some(_) | None => Ok(()),
        }
    }

    fn add_fault(&mut self, rule: Rule) -> Result<u32, Problem> {
        let now = self.ground.now;
        let faults = self.faults.as_deref_mut().ok_or_else(no_faults)?;
        let number = faults.add(now, rule);
        if let Some((While { station, point, condition }, switch)) = faults.watches(number) {
            self.bus.with_modules(station, |modules| modules.watch(point, condition, switch));
        }
        Ok(number)
    }

    fn remove_fault(&mut self, number: u32) -> Option<Rule> {
        self.faults.as_deref_mut()?.remove(number)
    }

    fn known(&self, address: u8) -> Option<Known> {
        Known::of(self.bus.description(Address::from_octet(address))?)
    }

    fn operation(&self, address: u8) -> Option<(Operation, Option<Startup>)> {
        let startup = self.bus.startup(Address::from_octet(address));
        let operation = startup.as_ref().map_or(Operation::Octets, |startup| startup.operation);
        self.bus.presence(Address::from_octet(address)).map(|_| (operation, startup))
    }

    fn profibus(&mut self) -> Option<&mut Bus> {
        Some(self.bus)
    }
}
