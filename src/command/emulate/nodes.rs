//! `profidrive emulate --node`: CANopen devices on a bus in memory until a signal.

use core::sync::atomic::Ordering;
use std::io::{self, Write};
use std::path::PathBuf;

use profidrive::can::BitRate;
use profidrive::canopen::storage::Memory;
use profidrive::canopen::{Event, NodeId};
use profidrive::device::CanopenEvent;
use profidrive::host::can::{Event as BusEvent, Line, LinkSpec, News, Seat, Stay, StoredNode};
use profidrive::host::capture::Capture;
use profidrive::host::capture::can::Interface;
use profidrive::host::{Clock, Error, Reach, StateDir};
use tracing::{debug, info, warn};

use super::Signals;
use crate::command::Failure;
use crate::command::args::{Emulate, NodeSpec};

/// Every device knows it.
const DEFAULT_RATE: BitRate = BitRate::K500;

/// Runs until SIGINT, SIGTERM or SIGHUP.
pub(super) fn emulate(args: &Emulate, link: &LinkSpec) -> Result<(), Failure> {
    // Before the link is made, so that no signal ends the process with the link left behind.
    let signals = Signals::register().map_err(|error| Failure::from_error(&error))?;
    let state = args.state_dir.as_deref().map(StateDir::open).transpose();
    let state = state.map_err(|error| Failure::from_error(&error))?;
    let rate = args.baud.and_then(|baud| baud.can()).unwrap_or(DEFAULT_RATE);
    let mut line = open(args, link, rate)?;
    let mut nodes = Nodes::default();
    for &spec in args.nodes() {
        nodes.connect(&mut line, spec, state.as_ref())?;
    }
    nodes.warn_of_doubles();
    let mut capture = Recorder::start(args, &mut line, &nodes, rate)?;
    // What the start brought is told whatever ends the process behind the ready line.
    line.turn(Stay::Awake, &signals.stop, &mut |news| tell(news, &mut capture, &mut nodes))
        .map_err(|error| Failure::from_error(&error))?;
    nodes.announce(line.name());
    let outcome = loop {
        let outcome = line.run(&signals.stop, &mut |news| tell(news, &mut capture, &mut nodes));
        // First, so that a signal after the flags are read ends the next run.
        signals.stop.clear();
        let end = outcome.is_err() || signals.end.load(Ordering::SeqCst);
        if signals.report.swap(false, Ordering::SeqCst) || end {
            let counters = line.bus().counters();
            info!(
                "bus: {} frames, {} of them remote requests, {} error frames",
                counters.frames, counters.remote, counters.errors
            );
        }
        if end {
            break outcome;
        }
    };
    // Switched off, the devices hand over their last images; the directory waits for them.
    drop(line);
    drop(state);
    outcome.map_err(|error| Failure::from_error(&error))?;
    info!("ended by a signal");
    Ok(())
}

/// Tells everybody who wants to know.
fn tell(news: News<CanopenEvent>, capture: &mut Recorder, nodes: &mut Nodes) {
    capture.take(&news);
    nodes.say(news);
}

fn open(args: &Emulate, link: &LinkSpec, rate: BitRate) -> Result<Line<CanopenEvent>, Failure> {
    let reach = if args.allow_remote { Reach::Network } else { Reach::ThisMachine };
    let line = Line::open(link, rate, reach).map_err(|error| match matches!(error, Error::TcpReach { .. }) {
        true => Failure::Usage(format!(
            "{error}; add --allow-remote if that is wanted, or use slcan-tcp:127.0.0.1:PORT; see 'profidrive emulate \
             --help'"
        )),
        false => Failure::from_error(&error),
    })?;
    info!("a CAN bus at {rate}, adapters speak slcan");
    if args.allow_remote {
        warn!("other machines can connect to {} and command the nodes", line.name());
    }
    Ok(line)
}

/// Who is on the bus, and what they are called in the log.
#[derive(Default)]
struct Nodes {
    on_bus: Vec<(Seat, NodeId, NodeSpec)>,
}

impl Nodes {
    fn connect(
        &mut self,
        line: &mut Line<CanopenEvent>,
        spec: NodeSpec,
        state: Option<&StateDir>,
    ) -> Result<(), Failure> {
        info!("{spec}");
        let now = line.clock().now();
        let node = match state {
            Some(state) => state
                .load_node(spec.product, spec.id, spec.choices, now)
                .map_err(|error| Failure::from_error(&error))?,
            None => StoredNode::new(spec.product.make(spec.id, spec.choices, Memory::Internal, now), now),
        };
        let id = node.node_id();
        if id != spec.id {
            warn!("{spec}: its EEPROM says node {id}, which is in force");
        }
        self.on_bus.push((line.add(Box::new(node)), id, spec));
        Ok(())
    }

    fn warn_of_doubles(&self) {
        for (place, (_, id, _)) in self.on_bus.iter().enumerate() {
            if self.on_bus.iter().take(place).any(|(_, before, _)| before == id) {
                warn!(
                    "two devices have the node number {id} in their EEPROMs: their frames collide in meaning"
                );
            }
        }
    }

    /// Says on stdout that a master can begin.
    fn announce(&self, link: &str) {
        let numbers: Vec<_> = self.on_bus.iter().map(|(_, id, _)| id.to_string()).collect();
        let mut stdout = io::stdout().lock();
        let said =
            writeln!(stdout, "ready link={link} nodes={}", numbers.join(",")).and_then(|()| stdout.flush());
        if let Err(error) = said {
            // Whoever started this may not care; the nodes are there all the same.
            warn!("cannot say on stdout that link={link} is ready: {error}");
        }
    }

    /// What a station is called: the device and its node number, or a master.
    fn name(&self, seat: Seat) -> String {
        self.on_bus
            .iter()
            .find(|(place, ..)| *place == seat)
            .map_or_else(|| "a master".into(), |(_, id, spec)| format!("node {id} ({})", spec.product.name))
    }

    fn say(&mut self, news: News<CanopenEvent>) {
        match news {
            News::Bus(BusEvent::Participant { seat, event }) => self.say_of_node(seat, &event),
            News::Bus(BusEvent::State { seat, state, .. }) => warn!("{}: {state}", self.name(seat)),
            News::Bus(BusEvent::Damaged { from, frame, damage, .. }) => {
                debug!("{}: {damage}: {frame}", self.name(from));
            }
            News::Bus(BusEvent::Passed { frame, .. }) => debug!("{frame}"),
            News::Bus(BusEvent::Lost { events }) => warn!("{events} events came too fast for the log"),
            News::Adapter { name, news } => info!("slcan {name}: {news}"),
        }
    }

    fn say_of_node(&mut self, seat: Seat, event: &CanopenEvent) {
        if let CanopenEvent::Node(Event::BootUp { node, .. }) = event
            && let Some((_, id, _)) = self.on_bus.iter_mut().find(|(place, ..)| *place == seat)
        {
            *id = *node;
        }
        let name = self.name(seat);
        let is_warning = matches!(
            event,
            CanopenEvent::Node(
                Event::FramesLost { .. } | Event::LifeGuardingExpired | Event::HeartbeatLost(_)
            )
        );
        if event.is_detail() {
            debug!("{name}: {event}");
        } else if is_warning {
            warn!("{name}: {event}");
        } else {
            info!("{name}: {event}");
        }
    }
}

/// The capture of `--capture`, until it cannot be written.
struct Recorder {
    capture: Option<(Capture, PathBuf)>,
}

impl Recorder {
    fn start(
        args: &Emulate,
        line: &mut Line<CanopenEvent>,
        nodes: &Nodes,
        rate: BitRate,
    ) -> Result<Self, Failure> {
        let Some(file) = &args.capture else { return Ok(Self { capture: None }) };
        let numbers: Vec<_> = nodes.on_bus.iter().map(|(_, id, _)| id.to_string()).collect();
        let description = format!("CAN bus with the emulated CANopen nodes {}", numbers.join(", "));
        let bus = Interface { name: line.name(), description: &description, rate };
        let capture = Capture::create_can(file, &bus, &line.clock());
        let capture = capture.map_err(|error| Failure::from_error(&error))?;
        line.bus_mut().watch(true);
        info!("capturing to {}", file.display());
        Ok(Self { capture: Some((capture, file.clone())) })
    }

    fn take(&mut self, news: &News<CanopenEvent>) {
        let (Some((capture, file)), News::Bus(event)) = (&mut self.capture, news) else { return };
        if let Err(error) = capture.write_can(event) {
            warn!("the capture {} ends here, the nodes go on: {error}", file.display());
            self.capture = None;
        }
    }
}
