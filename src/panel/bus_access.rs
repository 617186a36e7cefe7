//! What the thread of a bus of PROFIBUS lends to the threads of HTTP.

use core::error::Error;

use axum::http::StatusCode;

use super::faults::FaultAccess;
use super::inputs::{Acted, PowerName, Stations};
use super::problem::{Problem, station};
use super::queue::{self, Lends};
use crate::devices::ag03::profibus::{Config, Device, Power};
use crate::face::Surroundings;
use crate::host::fault::{BusKind, Rule, While};
use crate::host::link::fault::Faults;
use crate::host::{Bus, GsdStation, HostedPpoDrive, Participant, StateDir, StateDirError};
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// What the panel may see and change, lent by the thread of the bus between two telegrams.
pub struct BusAccess<'a> {
    /// The time now.
    pub now: Instant,
    /// The bus.
    pub bus: &'a mut Bus,
    /// The faults on the line; `None`: the link has none.
    pub faults: Option<&'a mut Faults>,
    /// What a drive that is added is made of, but for address, model and gear.
    pub config: Config,
    /// Where a drive that is added keeps its EEPROM; `None`: in itself.
    pub state: Option<&'a StateDir>,
    /// Whether a drive that is added listens first whether its address is live ([`Bus::join`]).
    pub listen: bool,
}

/// The thread of a bus of PROFIBUS.
#[derive(Clone, Copy, Debug)]
pub(super) struct OfBus;

impl Lends for OfBus {
    type Access<'a> = BusAccess<'a>;
}

/// The way to the thread of a bus of PROFIBUS.
pub(super) type Asking = queue::Asking<OfBus>;

/// A kind of station beside the drives: what one is called, what several are, and which option starts one.
pub(super) trait Called: Participant {
    const CALLED: [&'static str; 3];
}

impl Called for GsdStation {
    const CALLED: [&'static str; 3] = ["station from a GSD", "stations from GSDs", "--station"];
}

impl Called for HostedPpoDrive {
    const CALLED: [&'static str; 3] = ["PROFIDRIVE drive", "PROFIDRIVE drives", "--ppo-drive"];
}

impl FaultAccess for BusAccess<'_> {
    const BUS: BusKind = BusKind::Profibus;

    fn faults(&self) -> Result<Vec<(u32, Rule, u32)>, Problem> {
        self.faults.as_ref().map(|faults| faults.iter().collect()).ok_or_else(no_faults)
    }

    fn check_fault(&self, rule: &Rule) -> Result<(), Problem> {
        rule.check(self.bus.addresses().map(Address::number))
            .map_err(|error| Problem::value(error.to_string()))?;
        match rule.while_input {
            Some(While { station, .. }) if self.bus.station::<GsdStation>(station).is_none() => {
                Err(Problem::value(format!(
                    "fault '{rule}' waits for an input of station {station}, which is no station from a GSD of this line"
                )))
            }
            Some(_) | None => Ok(()),
        }
    }

    fn add_fault(&mut self, rule: Rule) -> Result<u32, Problem> {
        let faults = self.faults.as_deref_mut().ok_or_else(no_faults)?;
        let number = faults.add(self.now, rule);
        if let Some((While { station, point, condition }, switch)) = faults.watches(number) {
            self.bus.with(station, |station: &mut GsdStation| station.watch(point, condition, switch));
        }
        Ok(number)
    }

    fn remove_fault(&mut self, number: u32) -> Option<Rule> {
        self.faults.as_deref_mut()?.remove(number)
    }
}

/// The link has none.
fn no_faults() -> Problem {
    Problem::conflict("this line cannot have faults")
}

impl BusAccess<'_> {
    /// The station of a kind at `address`.
    ///
    /// # Errors
    /// 404 if there is none, with those that there are.
    pub(super) fn find<T: Called>(&self, address: Address) -> Result<&T, Problem> {
        self.bus.station(address).ok_or_else(|| self.no_station::<T>(address))
    }

    /// Does something to the station of a kind at `address`.
    ///
    /// # Errors
    /// As [`Self::find`].
    pub(super) fn change<T: Called, R>(
        &mut self,
        address: Address,
        act: impl FnOnce(&mut T) -> R,
    ) -> Result<R, Problem> {
        self.bus.with(address, act).ok_or_else(|| self.no_station::<T>(address))
    }

    /// Takes the station of a kind from the line.
    ///
    /// # Errors
    /// As [`Self::find`].
    pub(super) fn unplug<T: Called>(&mut self, address: Address) -> Result<StatusCode, Problem> {
        self.find::<T>(address)?;
        self.bus.remove(address);
        self.announce();
        Ok(StatusCode::NO_CONTENT)
    }

    /// The refusal that says where such stations are.
    pub(super) fn no_station<T: Called>(&self, address: Address) -> Problem {
        let [one, several, option] = T::CALLED;
        let places = self.bus.addresses().filter(|address| self.bus.station::<T>(*address).is_some());
        let places = places.map(|place| place.to_string()).reduce(|all, place| format!("{all}, {place}"));
        Problem::not_found(match places {
            Some(places) => {
                format!("there is no {one} at address {address}; there are {several} at {places}")
            }
            None => format!(
                "there is no {one} at address {address}, nor at any other; start one with emulate {option}"
            ),
        })
    }

    /// The drive at `address`. Stations that are no drives are not found.
    pub(super) fn drive(&self, address: Address) -> Option<&Device> {
        self.bus.station::<Device>(address)
    }

    /// Logs who is on the line after a station was added or removed, and which faults are for none of them.
    pub(super) fn announce(&self) {
        let mut addresses: Vec<_> = self.bus.addresses().collect();
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

    /// Does something to the drive at `address`.
    ///
    /// # Errors
    /// 404 if there is none.
    pub(super) fn with_drive<R>(
        &mut self,
        address: Address,
        act: impl FnOnce(&mut Device) -> R,
    ) -> Result<R, Problem> {
        self.bus.with(address, act).ok_or_else(|| self.no_drive(address))
    }

    /// 409 if a station that comes to `wanted`, where its DIP switches are read, would meet another one there.
    fn stays_apart(&self, address: Address, wanted: Option<Address>) -> Result<(), Problem> {
        match wanted.filter(|wanted| *wanted != address) {
            Some(wanted) if self.bus.presence(wanted).is_some() => Err(Problem::conflict(format!(
                "the DIP switches say address {wanted}, which another station has; set them to a free one"
            ))),
            Some(_) | None => Ok(()),
        }
    }

    /// Where the drive at `address` would be if it was switched on now.
    fn address_when_on(&self, address: Address) -> Option<Address> {
        let mut trial = self.drive(address).filter(|device| device.power() == Power::Off)?.clone();
        trial.power_on(self.now);
        Some(trial.address())
    }

    /// The refusal of a drive whose image cannot be used, with the drive that has it now.
    pub(super) fn not_loaded(&self, error: &StateDirError) -> Problem {
        let StateDirError::Owned { path } = error else {
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

    /// The refusal that says which drives there are.
    pub(super) fn no_drive(&self, address: Address) -> Problem {
        Problem::no_drive(address, self.bus.addresses().filter(|address| self.drive(*address).is_some()))
    }
}

impl Stations for OfBus {
    fn address(text: &str) -> Result<u8, Problem> {
        station(text).map(Address::number)
    }

    fn look<R>(
        access: &BusAccess<'_>,
        address: u8,
        look: impl FnOnce(&dyn Surroundings) -> R,
    ) -> Result<R, Problem> {
        let address = Address::from_octet(address);
        access.bus.surroundings(address).map(look).ok_or_else(|| access.no_drive(address))
    }

    fn act<R>(
        access: &mut BusAccess<'_>,
        address: u8,
        act: impl Fn(&mut dyn Surroundings, &Acted<'_>) -> Result<R, Problem>,
    ) -> Result<R, Problem> {
        let address = Address::from_octet(address);
        let device = access.bus.appearance(address).map(|station| station.model.into_owned());
        let acted = Acted { now: access.now, device: &device.unwrap_or_default() };
        // What is refused is refused below.
        let wanted = access.bus.address_after(address, &|station| drop(act(station, &acted)));
        access.stays_apart(address, wanted)?;
        let done = access.bus.with_surroundings(address, |station| act(station, &acted));
        done.unwrap_or_else(|| Err(access.no_drive(address)))
    }

    fn switch(access: &mut BusAccess<'_>, address: u8, on: bool) -> Result<PowerName, Problem> {
        let (now, address) = (access.now, Address::from_octet(address));
        let wanted = if on { access.address_when_on(address) } else { None };
        access.stays_apart(address, wanted)?;
        access.with_drive(address, |device| {
            if on {
                device.power_on(now);
            } else {
                device.power_off(now);
            }
            device.power().into()
        })
    }
}

/// An error and its causes.
pub(super) fn in_one_line(error: &dyn Error) -> String {
    let mut line = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        line = format!("{line}: {error}");
        cause = error.source();
    }
    line
}
