//! Who sees what passes on the line: the capture of `--capture` and the stream of `--panel`.

use std::sync::mpsc::{SyncSender, sync_channel};

use crate::host::capture::{Capture, Interface};
use crate::host::link::tap::{Batch, Tap};
use crate::host::{BusEvent, Clock, Link, SystemClock};
use crate::panel::Panel;
use crate::profibus::fdl::Address;
use tracing::{info, warn};

use super::super::Failure;
use super::super::args::{BaudSpec, Emulate};

/// What waits for the next packet at most.
const REMARKS: usize = 64;

/// The link, with a tap if somebody wants to see. `stations` are all on the line, `path` is what a master opens.
pub(super) fn tapped(
    link: Box<dyn Link>,
    (args, stations): (&Emulate, &[Address]),
    path: &str,
    clock: SystemClock,
    panel: Option<&Panel>,
) -> Result<(Box<dyn Link>, Remarks), Failure> {
    let mut capture = capture(args, stations, path, clock)?;
    let (remarks, waiting) = sync_channel::<String>(REMARKS);
    let remarks = Remarks(capture.is_some().then_some(remarks));
    let mut stream = panel.map(Panel::observer);
    let trouble = panel.map(Panel::warner);
    if capture.is_none() && stream.is_none() {
        return Ok((link, remarks));
    }
    // A capture wants everything.
    let watchers = panel.filter(|_| capture.is_none()).map(Panel::watchers);
    let observer = move |batch: &Batch| {
        if let Some(capture) = &mut capture {
            waiting.try_iter().for_each(|text| capture.remark(&text));
        }
        if let Some(Err(error)) = capture.as_mut().map(|capture| capture.write(batch)) {
            let told = format!("the capture ends here, the drives go on: {error}");
            warn!("{told}");
            if let Some(tell) = &trouble {
                tell(clock.now(), told);
            }
            capture = None;
        }
        if let Some(stream) = &mut stream {
            stream(batch);
        }
    };
    let tap = Tap::new(link, clock, observer);
    let link: Box<dyn Link> = match watchers {
        Some(watchers) => Box::new(tap.only_for(watchers)),
        None => Box::new(tap),
    };
    Ok((link, remarks))
}

/// Says in the capture what happens.
pub(super) struct Remarks(Option<SyncSender<String>>);

impl Remarks {
    /// What the log says of it, as the comment of the next packet. Octets that are no telegram are marked already.
    pub(super) fn say(&self, event: &BusEvent) {
        if matches!(event, BusEvent::TelegramRefused(_)) || event.is_detail() {
            return;
        }
        if let Some(remarks) = &self.0 {
            // A capture that has ended takes none.
            let _ = remarks.try_send(event.to_string());
        }
    }
}

/// The capture, if one is wanted.
fn capture(
    args: &Emulate,
    stations: &[Address],
    path: &str,
    clock: SystemClock,
) -> Result<Option<Capture>, Failure> {
    let Some(file) = &args.capture else {
        return Ok(None);
    };
    let baud = args.baud.and_then(BaudSpec::fixed);
    let addresses: Vec<_> = stations.iter().map(Address::to_string).collect();
    let description = format!("PROFIBUS line with the emulated stations {}", addresses.join(", "));
    let line = Interface { name: path, description: &description, baud };
    let capture = Capture::create(file, &line, &clock).map_err(|error| Failure::from_error(&error))?;
    info!("capturing to {}", file.display());
    Ok(Some(capture))
}
