//! The master in this program beside the devices of a line, and the browser that shows it.

use std::process::{Command, Stdio};

use crate::command::Failure;
use crate::command::args::Emulate;
use crate::devices::CanopenEvent;
use crate::host::can::{self, Seat};
use crate::host::inner_master::{self, Asked, InnerMaster};
use crate::host::link::beside::Beside;
use crate::host::{Bus, Link, Stop, SystemClock};
use crate::master::inner::{InnerNodes, InnerSlaves};
use crate::panel::Panel;
use crate::profibus::fdl::Address;
use crate::time::{BaudRate, Instant};

/// The master of a line of PROFIBUS, if one is wanted.
pub(super) struct SlavesBench {
    master: Option<(InnerMaster, InnerSlaves)>,
}

impl SlavesBench {
    /// The link with the master beside it.
    pub(super) fn beside(
        link: Box<dyn Link>,
        (args, wake): (&Emulate, &Stop),
        (clock, rate): (SystemClock, BaudRate),
        panel: Option<&Panel>,
    ) -> Result<(Box<dyn Link>, Self), Failure> {
        if !args.bench {
            return Ok((link, Self { master: None }));
        }
        let link = Beside::new(link);
        let board = InnerMaster::new(wake.clone());
        let door = link.door(wake.clone());
        let started = InnerSlaves::start(board.clone(), door, clock, rate);
        let started = started.map_err(|error| Failure::from_error(&error))?;
        if let Some(panel) = panel {
            panel.set_master(board.clone());
        }
        Ok((Box::new(link), Self { master: Some((board, started)) }))
    }

    /// Has the master take the device that somebody tries.
    pub(super) fn take(&self, bus: &Bus) {
        let Some((board, _)) = &self.master else { return };
        let is_taken = |address| bus.presence(Address::from_octet(address)).is_some();
        let Some(own) = inner_master::free_address(is_taken) else { return };
        for address in bus.addresses() {
            if let Some(startup) = bus.startup(address) {
                let _ = board.ask((address.number(), own), Some(startup), Asked::Take);
            }
        }
    }
}

/// The master of a bus of CAN, if one is wanted.
pub(super) struct NodesBench {
    seat: Option<Seat>,
}

impl NodesBench {
    /// On the bus, silent.
    pub(super) fn on(
        line: &mut can::Line<CanopenEvent>,
        args: &Emulate,
        wake: &Stop,
        panel: Option<&Panel>,
    ) -> Self {
        let (true, Some(panel)) = (args.bench, panel) else { return Self { seat: None } };
        let board = InnerMaster::new(wake.clone());
        panel.set_master(board.clone());
        Self { seat: Some(line.add(Box::new(InnerNodes::new(board)))) }
    }

    /// Takes what it was asked.
    pub(super) fn look(&self, line: &mut can::Line<CanopenEvent>, now: Instant) {
        if let Some(seat) = self.seat {
            line.bus_mut().with(now, seat, |master: &mut InnerNodes, now| master.look(now));
        }
    }
}

/// Shows the panel to somebody who tries a device.
pub(super) fn show(args: &Emulate, panel: Option<&Panel>) {
    let (Some(tried), Some(panel)) = (args.tried, panel) else { return };
    let address = format!("http://{}/", panel.address());
    if !(tried.browser && browse(&address)) {
        tracing::info!("open {address} in a browser; Ctrl-C ends this");
    }
}

/// Opens a browser. `false`: there is none.
fn browse(address: &str) -> bool {
    let has_screen = ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
    let (program, arguments): (&str, &[&str]) = if cfg!(windows) {
        ("cmd", &["/c", "start", ""])
    } else if cfg!(target_os = "macos") {
        ("open", &[])
    } else if has_screen {
        ("xdg-open", &[])
    } else {
        return false;
    };
    let mut browser = Command::new(program);
    browser.args(arguments).arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    browser.spawn().is_ok()
}
