//! Who sees what passes on the line: the capture of `--capture` and the stream of `--panel`.

use profidrive::host::capture::{Capture, Interface};
use profidrive::host::link::tap::{Batch, Tap};
use profidrive::host::{Link, SystemClock};
use profidrive::panel::Panel;
use tracing::{info, warn};

use super::super::Failure;
use super::super::args::{BaudSpec, Emulate};

/// The link, with a tap if somebody wants to see. `path` is what a master opens.
pub(super) fn tapped(
    link: Box<dyn Link>,
    args: &Emulate,
    path: &str,
    clock: SystemClock,
    panel: Option<&Panel>,
) -> Result<Box<dyn Link>, Failure> {
    let mut capture = capture(args, path, clock)?;
    let mut stream = panel.map(Panel::observer);
    if capture.is_none() && stream.is_none() {
        return Ok(link);
    }
    // A capture wants everything.
    let watchers = panel.filter(|_| capture.is_none()).map(Panel::watchers);
    let observer = move |batch: &Batch| {
        if let Some(Err(error)) = capture.as_mut().map(|capture| capture.write(batch)) {
            warn!("the capture ends here, the drives go on: {error}");
            capture = None;
        }
        if let Some(stream) = &mut stream {
            stream(batch);
        }
    };
    let tap = Tap::new(link, clock, observer);
    Ok(match watchers {
        Some(watchers) => Box::new(tap.only_for(watchers)),
        None => Box::new(tap),
    })
}

/// The capture, if one is wanted.
fn capture(args: &Emulate, path: &str, clock: SystemClock) -> Result<Option<Capture>, Failure> {
    let Some(file) = &args.capture else {
        return Ok(None);
    };
    let baud = args.baud.and_then(BaudSpec::fixed);
    let stations = args.stations.iter().map(|station| station.address);
    let addresses = args.drives().map(|drive| drive.address).chain(stations);
    let addresses: Vec<_> = addresses.map(|address| address.to_string()).collect();
    let description = format!("PROFIBUS line with the emulated stations {}", addresses.join(", "));
    let line = Interface { name: path, description: &description, baud };
    let capture = Capture::create(file, &line, &clock).map_err(|error| Failure::from_error(&error))?;
    info!("capturing to {}", file.display());
    Ok(Some(capture))
}
