//! `profidrive emulate --node`: CANopen devices on a bus in memory until a signal.

use core::sync::atomic::Ordering;
use core::time::Duration;
use std::path::PathBuf;

use crate::can_bus::can::BitRate;
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::can_bus::canopen::{Event, NodeId};
use crate::devices::CanopenEvent;
use crate::face::EventKind;
use crate::host::can::{
    self, AdapterNews, BusHint, Line, LinkSpec, News, NodeSignal, NodeWatch, Numbers, Product, Seat,
    StoredNode,
};
use crate::host::capture::Capture;
use crate::host::capture::can::CanInterface;
use crate::host::fault::{BusKind, Rule};
use crate::host::list::Spec;
use crate::host::{Clock, Error, Reach, StateDir};
use crate::panel::{NodeAccess, Panel, Seated};
use crate::time::Instant;
use tracing::{debug, info, warn};

use super::bench::{NodesBench, show};
use super::moving::Moving;
use super::{NOISE_PAUSE, Start, start_panel};
use crate::command::Failure;
use crate::command::args::Emulate;
use crate::command::signals::Signals;

/// Every device knows it.
const DEFAULT_RATE: BitRate = BitRate::K500;

/// The nodes have said that they are there after so long, whatever faults on purpose do to the bus.
const START: Duration = Duration::from_secs(1);

/// Runs until SIGINT, SIGTERM or SIGHUP.
pub(super) fn emulate(
    args: &Emulate,
    link: &LinkSpec,
    faults: &[Rule],
    start: &Start,
) -> Result<(), Failure> {
    // Before anything else begins.
    check(args)?;
    // Before the link is made, so that no signal ends the process with the link left behind.
    let signals = Signals::register().map_err(|error| Failure::from_error(&error))?;
    start.ends_with(&signals);
    let state = args.state_dir.as_deref().map(StateDir::open).transpose();
    let state = state.map_err(|error| Failure::from_error(&error))?;
    // Before the link, so that a refusal leaves nothing behind.
    let mut panel = start_panel(args, BusKind::Can, &signals.stop, start)?;
    let given = args.baud.and_then(|baud| baud.can());
    let rate = given.unwrap_or(DEFAULT_RATE);
    let mut line = open(args, link, rate)?;
    let mut nodes = Nodes::of(link);
    line.bus_mut().show_on(start.board());
    // For hints.
    line.bus_mut().watch(true);
    for fault in faults {
        warn!("fault on purpose: {fault}");
        let now = line.clock().now();
        line.bus_mut().add_fault(now, *fault).map_err(|error| Failure::Usage(format!("--fault: {error}")))?;
    }
    for spec in args.nodes() {
        let mut spec = spec.clone();
        args.choose_quirks(&mut spec).map_err(Failure::Usage)?;
        nodes.connect(&mut line, &spec, state.as_ref(), given)?;
    }
    line.bus_mut().reseat_faults();
    nodes.warn_of_doubles();
    let mut capture = Recorder::start(args, &line, &nodes, rate)?;
    if !start.all_are_open() {
        return Ok(());
    }
    let mut metrics = start.node_metrics(line.name(), &signals.stop);
    let (clock, mut seats) = (line.clock(), nodes.seats());
    let bench = NodesBench::on(&mut line, args, &signals.stop, panel.as_ref());
    let choose = |spec: &mut Spec| {
        // They were checked when the process was started.
        let _ = args.choose_quirks(spec);
    };
    if let Some(panel) = &panel {
        panel.set_link(line.name());
    }
    // A master that opens its adapter now sees no boot-up of the start.
    let started = line.run_until_idle(START, &signals.stop, &mut |news| {
        tell(news, &mut capture, &mut nodes, panel.as_ref(), clock.now());
    });
    started.map_err(|error| Failure::from_error(&error))?;
    // What the start brought is told whatever ends the process behind the ready line.
    while let Some(event) = line.bus_mut().poll_event() {
        tell(News::Bus(event), &mut capture, &mut nodes, panel.as_ref(), clock.now());
    }
    nodes.announce(line.name(), panel.as_ref(), start);
    show(args, panel.as_ref());
    let outcome = loop {
        let outcome = line.run(&signals.stop, &mut |news| {
            tell(news, &mut capture, &mut nodes, panel.as_ref(), clock.now());
        });
        // First, so that a signal after the flags are read ends the next run.
        signals.stop.clear();
        let end = outcome.is_err() || signals.end.load(Ordering::SeqCst);
        let asked = signals.report.swap(false, Ordering::SeqCst);
        if asked || end {
            let counters = line.bus().counters();
            info!(
                "bus: frames: {}, of them remote requests: {}; error frames: {}",
                counters.frames, counters.remote, counters.errors
            );
        }
        if asked {
            nodes.explain(&line);
        }
        if end {
            break outcome;
        }
        if let Some(metrics) = &mut metrics {
            metrics.serve(line.bus(), &seats);
        }
        if let Some(panel) = &mut panel {
            panel.serve_can(&mut NodeAccess {
                now: clock.now(),
                bus: line.bus_mut(),
                nodes: &mut seats,
                state: state.as_ref(),
                rate: given,
                choose: &choose,
            });
            nodes.follow(&seats, &line);
        }
        bench.look(&mut line, clock.now());
    };
    nodes.moving.end();
    drop(panel);
    // Switched off, the devices hand over their last images; the directory waits for them.
    drop(line);
    drop(state);
    outcome.map_err(|error| Failure::from_error(&error))?;
    info!("ended by a signal");
    Ok(())
}

/// Reads what the nodes name.
pub(super) fn check(args: &Emulate) -> Result<(), Failure> {
    args.nodes().iter().try_for_each(|spec| {
        args.choose_quirks(&mut spec.clone()).map_err(Failure::Usage)?;
        signals(spec).map(drop)
    })
}

fn signals(spec: &Spec) -> Result<Vec<NodeSignal>, Failure> {
    spec.signals().map_err(|wrong| Failure::Usage(format!("--node {}: {wrong}", spec.node())))
}

fn product(spec: &Spec) -> Result<&'static Product, Failure> {
    spec.product().map_err(|wrong| Failure::Usage(format!("--node {}: {wrong}", spec.node())))
}

/// Tells everybody who wants to know.
fn tell(
    news: News<CanopenEvent>,
    capture: &mut Recorder,
    nodes: &mut Nodes,
    panel: Option<&Panel>,
    now: Instant,
) {
    if let Some(trouble) = capture.take(&news) {
        warn!("{trouble}");
        if let Some(panel) = panel {
            panel.warner()(now, trouble);
        }
    }
    capture.remark(&news, nodes);
    if let (Some(panel), News::Bus(event)) = (panel, &news) {
        panel.tell_can(now, event);
    }
    if let Some(hint) = nodes.hint(now, &news) {
        capture.note(&hint);
        if let Some(panel) = panel {
            panel.hint(now, hint);
        }
        info!("{hint}");
    }
    nodes.say(now, news);
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
    match link {
        LinkSpec::Terminal(_) | LinkSpec::Socket(_) => {
            info!("a CAN bus at {rate} connected to {}", line.name())
        }
        LinkSpec::Pty(_) | LinkSpec::Tcp(_) => info!("a CAN bus at {rate}, adapters speak slcan"),
    }
    if args.allow_remote {
        warn!("other machines can connect to {} and command the nodes", line.name());
    }
    Ok(line)
}

/// Who is on the bus, and what they are called in the log.
pub(super) struct Nodes {
    on_bus: Vec<(Seated, NodeId)>,
    watch: NodeWatch,
    /// When a line of noise was logged last, and how many more came since.
    last_noise: Option<Instant>,
    unsaid: u64,
    pub(super) moving: Moving,
}

impl Nodes {
    /// None yet, on the bus behind `link`.
    pub(super) fn of(link: &LinkSpec) -> Self {
        let watch = match link {
            LinkSpec::Terminal(_) | LinkSpec::Socket(_) => NodeWatch::outside(),
            LinkSpec::Pty(_) | LinkSpec::Tcp(_) => NodeWatch::inside(),
        };
        Self { on_bus: Vec::new(), watch, last_noise: None, unsaid: 0, moving: Moving::default() }
    }

    /// What is odd about a frame of a master.
    fn hint(&mut self, now: Instant, news: &News<CanopenEvent>) -> Option<BusHint> {
        let News::Bus(can::Event::Passed { by_port: true, frame, .. }) = news else { return None };
        let Self { on_bus, watch, .. } = self;
        watch.heard(now, frame, || Numbers::of(on_bus.iter().map(|(_, node)| *node)))
    }

    fn connect(
        &mut self,
        line: &mut Line<CanopenEvent>,
        spec: &Spec,
        state: Option<&StateDir>,
        rate: Option<BitRate>,
    ) -> Result<(), Failure> {
        let product = product(spec)?;
        let asked = spec.node();
        let name = format!("{} as node {asked}", product.sheet.product_name);
        info!("{name}");
        let (now, of_bus, rates) = (line.clock().now(), line.bus().rate(), product.rates());
        if !rates.is_empty() && !rates.contains(&of_bus.bits_per_second()) {
            warn!("{name}: it does not have {of_bus}; it is at this rate all the same");
        }
        let mut node = match state {
            Some(state) => state
                .load_node(product, asked, &spec.choices, now)
                .map_err(|error| Failure::from_error(&error))?,
            None => StoredNode::new(product.make(asked, &spec.choices, Eeprom::Internal, now), now),
        };
        let id = node.node_id();
        if id != asked {
            warn!("{name}: its EEPROM has the node number {id}, which is used");
        }
        if let Some(rate) = rate {
            node.set_rate(now, rate);
        }
        // Before it is on the bus: its boot-up is concerned.
        line.bus().add_faults_to(now, &mut node);
        for signal in signals(spec)? {
            node.connect(now, signal);
        }
        let seat = line.add(Box::new(node));
        self.on_bus.push((Seated { seat, product }, id));
        Ok(())
    }

    /// Nodes were added and removed.
    fn follow(&mut self, seats: &[Seated], line: &Line<CanopenEvent>) {
        let number = |seat| line.bus().participant::<StoredNode>(seat).map(StoredNode::node_id);
        let is_same = self.on_bus.iter().map(|(seated, _)| seated).eq(seats);
        if !is_same {
            let known = |seated: &Seated| Some((*seated, number(seated.seat)?));
            self.on_bus = seats.iter().filter_map(known).collect();
            let nodes: Vec<_> =
                self.on_bus.iter().map(|(seated, id)| format!("{id} ({})", seated.product.name)).collect();
            info!("on the bus now: {}", if nodes.is_empty() { "no node".into() } else { nodes.join(", ") });
        }
    }

    fn warn_of_doubles(&self) {
        for (place, (_, id)) in self.on_bus.iter().enumerate() {
            if self.on_bus.iter().take(place).any(|(_, before)| before == id) {
                warn!("two devices have the node number {id}: their frames contradict each other");
            }
        }
    }

    /// Where they are, for the panel.
    fn seats(&self) -> Vec<Seated> {
        self.on_bus.iter().map(|(seated, _)| *seated).collect()
    }

    /// Says on stdout that a master can begin.
    fn announce(&self, link: &str, panel: Option<&Panel>, start: &Start) {
        let panel = panel.map(|panel| format!(" panel=http://{}", panel.address())).unwrap_or_default();
        let numbers: Vec<_> = self.on_bus.iter().map(|(_, id)| id.to_string()).collect();
        start.announce(&format!("ready link={link} nodes={}{panel}", numbers.join(",")));
    }

    /// What a station is called: the device and its node number, or a master.
    fn name(&self, seat: Seat) -> String {
        self.on_bus
            .iter()
            .find(|(seated, _)| seated.seat == seat)
            .map_or_else(|| "a master".into(), |(seated, id)| format!("node {id} ({})", seated.product.name))
    }

    /// Logs of every node what keeps its drive from moving.
    fn explain(&self, line: &Line<CanopenEvent>) {
        for (Seated { seat, .. }, _) in &self.on_bus {
            if let Some(why) = line.bus().participant::<StoredNode>(*seat).and_then(StoredNode::why) {
                let name = self.name(*seat);
                why.each_reason(&mut |reason| info!("{name}: it does not move: {reason}"));
            }
        }
    }

    fn say(&mut self, now: Instant, news: News<CanopenEvent>) {
        self.moving.look(now);
        match news {
            // So many of them are noise.
            News::Adapter { name, news: news @ AdapterNews::Refused(_) } => {
                if self.last_noise.is_some_and(|last| now.saturating_since(last) < NOISE_PAUSE) {
                    self.unsaid = self.unsaid.saturating_add(1);
                    debug!("slcan {name}: {news}");
                    return;
                }
                self.last_noise = Some(now);
                match core::mem::take(&mut self.unsaid) {
                    0 => info!("slcan {name}: {news}"),
                    more => info!("slcan {name}: {news}; {more} more such lines since the last one"),
                }
            }
            News::Bus(can::Event::Participant { seat, event }) => self.say_of_node(now, seat, &event),
            News::Bus(can::Event::State { seat, state, .. }) => warn!("{}: {state}", self.name(seat)),
            News::Bus(can::Event::Tuned(tuned)) => warn!("{}: {tuned}", self.name(tuned.seat)),
            News::Bus(can::Event::Damaged { from, frame, damage, .. }) => {
                debug!("{}: {damage}: {frame}", self.name(from));
            }
            News::Bus(can::Event::Passed { frame, .. }) => debug!("{frame}"),
            News::Bus(can::Event::Lost { events }) => {
                warn!("{events} events were too many for the log and are lost")
            }
            News::Adapter { name, news } => info!("slcan {name}: {news}"),
        }
    }

    pub(super) fn say_of_node(&mut self, now: Instant, seat: Seat, event: &CanopenEvent) {
        if let CanopenEvent::Node(Event::BootUp { node, .. }) = event
            && let Some((_, id)) = self.on_bus.iter_mut().find(|(seated, _)| seated.seat == seat)
        {
            *id = *node;
        }
        let name = self.name(seat);
        let is_warning = matches!(
            event,
            CanopenEvent::Node(
                Event::FramesLost { .. } | Event::LifeGuardingExpired { .. } | Event::HeartbeatLost { .. }
            )
        );
        let is_motion = event.kind() == EventKind::Drive;
        if event.is_detail() || is_motion && !self.moving.may_say(now) {
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
        line: &Line<CanopenEvent>,
        nodes: &Nodes,
        rate: BitRate,
    ) -> Result<Self, Failure> {
        let Some(file) = &args.capture else { return Ok(Self { capture: None }) };
        let numbers: Vec<_> = nodes.on_bus.iter().map(|(_, id)| id.to_string()).collect();
        let description = format!("CAN bus with the emulated CANopen nodes {}", numbers.join(", "));
        let bus = CanInterface { name: line.name(), description: &description, rate };
        let capture = Capture::create_can(file, &bus, &line.clock());
        let capture = capture.map_err(|error| Failure::from_error(&error))?;
        info!("capturing to {}", file.display());
        Ok(Self { capture: Some((capture, file.clone())) })
    }

    /// What the log says of a node, as the comment of the next frame.
    fn remark(&mut self, news: &News<CanopenEvent>, nodes: &Nodes) {
        let News::Bus(can::Event::Participant { seat, event }) = news else { return };
        if let Some((capture, _)) = self.capture.as_mut().filter(|_| !event.is_detail()) {
            capture.remark(&format!("{}: {event}", nodes.name(*seat)));
        }
    }

    /// A hint, as the comment of the next frame.
    fn note(&mut self, hint: &BusHint) {
        if let Some((capture, _)) = &mut self.capture {
            capture.remark(&hint.to_string());
        }
    }

    /// What happens; why the capture ends, if it does.
    fn take(&mut self, news: &News<CanopenEvent>) -> Option<String> {
        let (Some((capture, file)), News::Bus(event)) = (&mut self.capture, news) else { return None };
        let error = capture.write_can(event).err()?;
        let told = format!("the capture {} ends here, the nodes go on: {error}", file.display());
        self.capture = None;
        Some(told)
    }
}
