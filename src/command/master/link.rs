//! Opens the link of `profidrive master`, which is the master on it.

use crate::host::Link;
use crate::host::link::serial::Serial;
use crate::host::link::tcp::Connection;
#[cfg(unix)]
use crate::host::link::terminal::Terminal;
use crate::master::Settings;
use crate::time::BaudRate;

use crate::command::Failure;
use crate::command::args::{BaudSpec, Master, MasterLink};

/// The rate where there is none: it only says how long a telegram counts as being on its way.
const UNTIMED_RATE: BaudRate = BaudRate::K500;

/// The link, and how to take part in what is behind it.
pub(super) fn open(args: &Master) -> Result<(Box<dyn Link>, Settings), Failure> {
    let baud = match args.baud {
        Some(BaudSpec::Fixed(rate)) => rate,
        Some(BaudSpec::Auto | BaudSpec::OfFile | BaudSpec::Other(_)) | None => UNTIMED_RATE,
    };
    let untimed = Settings::untimed(args.master_address, baud);
    let opened: Result<(Box<dyn Link>, Settings), _> = match &args.link {
        #[cfg(not(unix))]
        Some(MasterLink::Terminal(path)) => {
            let path = path.display();
            return Err(Failure::Usage(format!(
                "{path} is no link on Windows; name a port as serial:COM3, or use tcp:HOST:PORT"
            )));
        }
        #[cfg(unix)]
        Some(MasterLink::Terminal(path)) => {
            Terminal::open(path, baud).map(|link| (Box::new(link) as Box<dyn Link>, untimed))
        }
        Some(MasterLink::Tcp(place)) => {
            Connection::open(place).map(|link| (Box::new(link) as Box<dyn Link>, untimed))
        }
        Some(MasterLink::Serial(device)) => Serial::open(device, baud)
            .map(|link| (Box::new(link) as Box<dyn Link>, Settings::on_wire(args.master_address, baud))),
        Some(MasterLink::Can(_)) | None => {
            return Err(Failure::Usage("a line of PROFIBUS is missing; add --link LINK".into()));
        }
    };
    let (link, settings) = opened.map_err(|error| Failure::from_error(&error))?;
    let slot_time = args.slot_time.unwrap_or(settings.slot_time);
    Ok((link, Settings { watchdog: args.watchdog, slot_time, ..settings }))
}
