//! `profidrive emulate`: drives on a line until a signal.

use core::time::Duration;
use std::io::{self, Write};

use profidrive::device::{Config, Device, Event};
use profidrive::host::link::fault::Faulty;
use profidrive::host::link::serial::Serial;
use profidrive::host::{Bus, Clock, Link, StateDir, Stop, SystemClock, run};
use profidrive::time::BaudRate;
use signal_hook::consts::{SIGINT, SIGTERM};
use tracing::{debug, info, warn};

use super::Failure;
use super::args::{BaudSpec, DriveSpec, Emulate, LinkSpec};

/// The rate of a terminal whose master has set none of PROFIBUS-DP, and of a TCP port. There it only says how long a
/// drive waits before it replies.
const UNTIMED_RATE: BaudRate = BaudRate::K500;

/// A line full of rubbish is said once in this time; the rest is for `-v`.
const NOISE_PAUSE: Duration = Duration::from_secs(1);

/// Runs until SIGINT or SIGTERM.
pub(crate) fn emulate(args: &Emulate) -> Result<(), Failure> {
    // Before the link is made, so that no signal ends the process with the link left behind.
    let stop = stop_on_signals().map_err(|error| Failure::from_error(&error))?;
    let clock = SystemClock::new();
    let state = args.state_dir.as_deref().map(StateDir::open).transpose();
    let state = state.map_err(|error| Failure::from_error(&error))?;
    let (rate, link, path) = open(args)?;
    for fault in &args.faults {
        warn!("fault on purpose: {fault}");
    }
    let mut link = Faulty::new(link, clock, &args.faults);

    let mut bus = Bus::new();
    for drive in &args.drives {
        connect(&mut bus, *drive, rate, &clock, state.as_ref())?;
    }
    announce(&path, &bus);
    let mut last_noise = None;
    let outcome = run(&mut link, &mut bus, &clock, &stop, &mut |address, event| {
        let noise = matches!(event, Event::TelegramRefused(_));
        let now = clock.now();
        if noise && last_noise.is_some_and(|last| now.saturating_since(last) < NOISE_PAUSE) {
            debug!("drive {address}: {event}");
            return;
        }
        info!("drive {address}: {event}");
        if noise {
            last_noise = Some(now);
        }
    });
    // Switched off, the drives hand over their last images; the directory waits for them.
    drop(bus);
    drop(state);
    match outcome {
        Ok(()) => info!("ended by a signal"),
        Err(error) => return Err(Failure::from_error(&error)),
    }
    Ok(())
}

fn stop_on_signals() -> io::Result<Stop> {
    let stop = Stop::new()?;
    for signal in [SIGINT, SIGTERM] {
        signal_hook::low_level::pipe::register(signal, stop.waker()?)?;
    }
    Ok(stop)
}

/// The rate to begin with, the link, and what a master opens.
fn open(args: &Emulate) -> Result<(BaudRate, Box<dyn Link>, String), Failure> {
    let rate = match args.baud {
        Some(BaudSpec::Fixed(rate)) => Some(rate),
        Some(BaudSpec::Auto) | None => None,
    };
    match &args.link {
        LinkSpec::Pty(path) => open_pty(path.as_deref(), rate),
        LinkSpec::Serial(device) => {
            let rate = rate.ok_or_else(|| Failure::Usage("a serial line needs --baud RATE".into()))?;
            let mut serial = Serial::open(device, rate).map_err(|error| Failure::from_error(&error))?;
            serial.reopen(true);
            info!("{device} at {rate}, 8 data bits, even parity, 1 stop bit");
            Ok((rate, Box::new(serial), device.clone()))
        }
        LinkSpec::Tcp(place) => open_tcp(place, rate.unwrap_or(UNTIMED_RATE), args.allow_remote),
    }
}

#[cfg(unix)]
fn open_tcp(
    place: &str,
    rate: BaudRate,
    allow_remote: bool,
) -> Result<(BaudRate, Box<dyn Link>, String), Failure> {
    use profidrive::host::Error;
    use profidrive::host::link::tcp::{Reach, Tcp};

    let reach = if allow_remote { Reach::Network } else { Reach::ThisMachine };
    let tcp = Tcp::bind(place, rate, reach).map_err(|error| match matches!(error, Error::TcpReach { .. }) {
        true => Failure::Usage(format!(
            "{error}; add --allow-remote if that is wanted, or use tcp:127.0.0.1:PORT; see 'profidrive emulate --help'"
        )),
        false => Failure::from_error(&error),
    })?;
    let address = tcp.address();
    info!("a TCP port at {rate}");
    if !address.ip().is_loopback() {
        warn!("other machines can connect to {address} and command the drives");
    }
    Ok((rate, Box::new(tcp), format!("tcp:{address}")))
}

#[cfg(not(unix))]
fn open_tcp(_: &str, _: BaudRate, _: bool) -> Result<(BaudRate, Box<dyn Link>, String), Failure> {
    Err(Failure::Other("tcp links need Unix; use --link serial:DEVICE --baud RATE".into()))
}

#[cfg(target_os = "linux")]
fn open_pty(
    path: Option<&std::path::Path>,
    rate: Option<BaudRate>,
) -> Result<(BaudRate, Box<dyn Link>, String), Failure> {
    use profidrive::host::link::pty::Pty;

    let mut pty = Pty::open(path).map_err(|error| Failure::from_error(&error))?;
    pty.follow_rate(rate.is_none());
    match rate {
        Some(rate) => info!("a pseudo-terminal at {rate}"),
        None => info!("a pseudo-terminal at {UNTIMED_RATE} until a master sets another rate"),
    }
    let opened = pty.path().display().to_string();
    Ok((rate.unwrap_or(UNTIMED_RATE), Box::new(pty), opened))
}

#[cfg(not(target_os = "linux"))]
fn open_pty(
    _: Option<&std::path::Path>,
    _: Option<BaudRate>,
) -> Result<(BaudRate, Box<dyn Link>, String), Failure> {
    Err(Failure::Other("pty links need Linux; use --link serial:DEVICE --baud RATE".into()))
}

fn connect(
    bus: &mut Bus,
    drive: DriveSpec,
    baud: BaudRate,
    clock: &dyn Clock,
    state: Option<&StateDir>,
) -> Result<(), Failure> {
    let DriveSpec { address, model, gear } = drive;
    info!("{drive}");
    match address.number() {
        126 => warn!(
            "address 126 is for stations that have none yet: a master can set another, but not exchange data"
        ),
        0 => warn!("address 0 is customarily a master's, often of a programming device"),
        _ => {}
    }
    let config = Config { model, gear, baud, ..Config::new(address) };
    let device = match state {
        Some(state) => state.load(config, clock.now()).map_err(|error| Failure::from_error(&error))?,
        None => Device::new(config, clock.now()).into(),
    };
    bus.add(device).map_err(|error| Failure::from_error(&error))
}

/// Says on stdout that a master can begin.
fn announce(path: &str, bus: &Bus) {
    let addresses: Vec<_> = bus.addresses().map(|address| address.to_string()).collect();
    let mut stdout = io::stdout().lock();
    let said =
        writeln!(stdout, "ready link={path} drives={}", addresses.join(",")).and_then(|()| stdout.flush());
    if let Err(error) = said {
        // Whoever started this may not care; the drives are there all the same.
        warn!("cannot say on stdout that link={path} is ready: {error}");
    }
}
