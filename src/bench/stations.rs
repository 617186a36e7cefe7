//! What is on the line: buses with their stations, faults, disturbances.

use super::{Disturbance, Line, Master};
use crate::devices::StationEvent;
use crate::devices::ag03::profibus::{Config, Device, Timing};
use crate::face::Description;
use crate::host::fault::{NoStation, Rule};
use crate::host::link::fault::Faults;
use crate::host::{Bus, BusEvent, Error, Participant};
use crate::profibus::fdl::Address;
use crate::time::Instant;

impl<M: Master> Line<M> {
    /// Connects stations and returns the number of their bus, which counts from 0. Several buses are several devices:
    /// nothing keeps them from having the same addresses.
    pub fn connect(&mut self, bus: Bus) -> usize {
        self.buses.push(bus);
        self.buses.len() - 1
    }

    /// The bus of that number.
    pub fn bus(&self, number: usize) -> Option<&Bus> {
        self.buses.get(number)
    }

    /// The bus of that number, to take its news, or to add, change and remove stations.
    pub fn bus_mut(&mut self, number: usize) -> Option<&mut Bus> {
        self.buses.get_mut(number)
    }

    /// The first bus, which is there from now on.
    pub(crate) fn stations(&mut self) -> &mut Bus {
        if self.buses.is_empty() {
            self.buses.push(Bus::on(self.baud, Timing::True));
        }
        match &mut self.buses[..] {
            [first, ..] => first,
            [] => unreachable!("one was added above"),
        }
    }

    /// Connects a station to the first bus.
    ///
    /// # Errors
    /// [`Error::AddressTaken`] if another station of that bus has its address.
    pub fn add(&mut self, station: impl Participant) -> Result<(), Error> {
        self.stations().add(station)
    }

    /// Connects a drive to the first bus and switches it on now. Rate and [`Timing::True`] of the line replace those of
    /// `config`.
    ///
    /// # Errors
    /// As [`Line::add`].
    pub fn add_drive(&mut self, config: Config) -> Result<(), Error> {
        let config = Config { baud: self.baud, timing: Timing::True, ..config };
        self.add(Device::new(config, self.now))
    }

    /// Connects a station of any kind to the first bus.
    ///
    /// # Errors
    /// As [`Line::add`].
    pub(crate) fn add_any(&mut self, station: Box<dyn Participant>) -> Result<(), Error> {
        let now = self.now;
        self.stations().connect(now, station, false)
    }

    /// Does something to what surrounds the station at `address` of the first bus, if there is one.
    pub(crate) fn with_description<R>(
        &mut self,
        address: Address,
        act: impl FnOnce(&mut dyn Description, Instant) -> R,
    ) -> Option<R> {
        let now = self.now;
        self.stations().with_description(address, |description| act(description, now))
    }

    /// The drive at `address`.
    pub fn device(&self, address: u8) -> Option<&Device> {
        self.station(address)
    }

    /// The station at `address`, if there is one and it is a `T`.
    pub(crate) fn station<T: Participant>(&self, address: u8) -> Option<&T> {
        let address = Address::station(address).ok()?;
        self.buses.iter().find_map(|bus| bus.station(address))
    }

    /// Does something to the station at `address` now, if there is one and it is a `T`: sets what acts on a
    /// [`Device`] with [`Device::set_inputs`], say.
    pub fn with_station<T: Participant, R>(
        &mut self,
        address: u8,
        act: impl FnOnce(&mut T, crate::time::Instant) -> R,
    ) -> Option<R> {
        let (now, address) = (self.now, Address::station(address).ok()?);
        let bus = self.buses.iter_mut().find(|bus| bus.station::<T>(address).is_some())?;
        bus.with(address, |station| act(station, now))
    }

    /// News of a drive or another station of the first bus, and its address.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<(Address, StationEvent)> {
        loop {
            // What else a bus tells is of lines on which others may be.
            if let BusEvent::Station { address, event } = self.buses.first_mut()?.poll_event()? {
                return Some((address, event));
            }
        }
    }

    /// These faults on purpose act from now on, instead of those before; none: the line is sound. They count telegrams
    /// from here.
    ///
    /// # Errors
    /// [`NoStation`]: a fault is for a station that is not on the line; the faults are as before.
    pub fn inject(&mut self, faults: &[Rule]) -> Result<(), NoStation> {
        for fault in faults {
            fault.check(self.buses.iter().flat_map(Bus::addresses).map(Address::number))?;
        }
        self.faults.clear();
        for fault in faults {
            self.faults.add(self.now, *fault);
        }
        Ok(())
    }

    /// The first bus and the faults on the line, both to be changed.
    pub(crate) fn stations_and_faults(&mut self) -> (&mut Bus, &mut Faults) {
        self.stations();
        match &mut self.buses[..] {
            [first, ..] => (first, &mut self.faults),
            [] => unreachable!("`stations` has added one"),
        }
    }

    /// Disturbs what is sent from now on; `None` ends it.
    pub fn disturb(&mut self, disturbance: Option<Disturbance>) {
        self.disturbance = disturbance;
    }
}
