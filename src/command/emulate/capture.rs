//! `profidrive emulate --capture`: what passes goes to a file, as long as the file takes it.

use profidrive::host::capture::{Capture, Interface};
use profidrive::host::link::tap::{Batch, Tap};
use profidrive::host::{Link, SystemClock};
use tracing::{info, warn};

use super::super::Failure;
use super::super::args::{BaudSpec, Emulate};

/// The link, with a tap if a capture is wanted. `path` is what a master opens.
pub(super) fn tapped(
    link: Box<dyn Link>,
    args: &Emulate,
    path: &str,
    clock: SystemClock,
) -> Result<Box<dyn Link>, Failure> {
    let Some(file) = &args.capture else {
        return Ok(link);
    };
    let baud = match args.baud {
        Some(BaudSpec::Fixed(rate)) => Some(rate),
        Some(BaudSpec::Auto) | None => None,
    };
    let line = Interface { name: path, description: &description(args), baud };
    let capture = Capture::create(file, &line, &clock).map_err(|error| Failure::from_error(&error))?;
    info!("capturing to {}", file.display());
    let name = file.display().to_string();
    let mut capture = Some(capture);
    let observer = move |batch: &Batch| {
        if let Some(Err(error)) = capture.as_mut().map(|capture| capture.write(batch)) {
            warn!("the capture {name} ends here, the drives go on: {error}");
            capture = None;
        }
    };
    Ok(Box::new(Tap::new(link, clock, observer)))
}

/// The drives on the line.
fn description(args: &Emulate) -> String {
    let addresses: Vec<_> = args.drives().map(|drive| drive.address.to_string()).collect();
    format!("PROFIBUS line with the emulated drives {}", addresses.join(", "))
}
