//! `profidrive emulate`: drives on a line until a signal.

use core::sync::atomic::Ordering;
use core::time::Duration;
use std::path::Path;

use crate::host::fault::{BusKind, Rule, Switch, While};
use crate::host::link::fault::{Faults, Faulty};
use crate::host::link::pty::Pty;
use crate::host::link::serial::Serial;
use crate::host::link::tcp::Tcp;
use crate::host::list::{Ground, Group, MakeError, Prepared, Spec, Wrong};
use crate::host::{
    Bus, BusEvent, Clock, Error, Link, Reach, Refusals, SlotTime, StateDir, Stop, SystemClock, run,
};
use crate::panel::{BusAccess, Panel, PanelError};
use crate::profibus::fdl::{Address, RateChange, Timing};
use crate::time::{BaudRate, Instant};
use tracing::{debug, info, warn};

use super::args::{BaudSpec, Emulate, LinkSpec, MetricsSpec};
use super::signals::Signals;
use super::{Failure, line_file};
use crate::face::EventKind;
use moving::Moving;

mod bench;
#[cfg(test)]
mod flood;
mod lines;
mod moving;
mod nodes;
mod tap;

use bench::SlavesBench;
use lines::Start;

/// The rate of a terminal whose master has set none of PROFIBUS-DP, and of a TCP port. There it only says how long a
/// drive waits before it replies.
const UNTIMED_RATE: BaudRate = BaudRate::K500;

/// A serial line whose rate is to be found is opened at one that every port has.
const FIRST_SERIAL_RATE: BaudRate = BaudRate::K19_2;

/// Invalid octets are logged at most once in this time; each is for `-v`.
const NOISE_PAUSE: Duration = Duration::from_secs(20);

/// Runs what the arguments ask for, until SIGINT, SIGTERM, or SIGHUP, which comes when the window of its terminal is
/// closed.
pub(crate) fn emulate(args: Emulate) -> Result<(), Failure> {
    let (check_only, end_with_stdin) = (args.check_only, args.end_with_stdin);
    let (source, plan) = match &args.line {
        Some(file) => (file.display().to_string(), line_file::read(file)?),
        None => {
            let plan = LinesPlan { metrics: args.metrics(), lines: vec![LinePlan::of_flags(args)?] };
            ("command line".into(), plan)
        }
    };
    if check_only {
        plan.lines.iter().try_for_each(|line| nodes::check(&line.args))?;
        return line_file::say(&source, &plan.lines);
    }
    lines::run(plan, end_with_stdin)
}

/// All lines of the process.
pub(crate) struct LinesPlan {
    pub(crate) lines: Vec<LinePlan>,
    /// Where the metrics of all of them are.
    pub(crate) metrics: Option<MetricsSpec>,
}

/// A line and everybody on it: the general form, which a file or the flags fill.
pub(crate) struct LinePlan {
    /// All but what flags cannot say; its slaves and faults are those below.
    pub(crate) args: Emulate,
    /// Everybody on a line of PROFIBUS.
    pub(crate) slaves: Vec<SlavePlan>,
    pub(crate) faults: Vec<Rule>,
}

/// A device on PROFIBUS whose specification is right.
pub(crate) struct SlavePlan {
    pub(crate) spec: Spec,
    pub(crate) prepared: Prepared,
}

impl SlavePlan {
    /// Reads its files and checks it. Nothing is started before all are right.
    pub(crate) fn new(spec: Spec) -> Result<Self, Wrong> {
        let prepared = spec.prepare()?;
        Ok(Self { spec, prepared })
    }

    pub(crate) const fn address(&self) -> Address {
        self.spec.address()
    }
}

impl LinePlan {
    /// The addresses of all on the line.
    fn addresses(&self) -> Vec<Address> {
        self.slaves.iter().map(SlavePlan::address).collect()
    }

    fn of_flags(args: Emulate) -> Result<Self, Failure> {
        let slave = |mut spec: Spec| {
            args.choose_quirks(&mut spec).map_err(Failure::Usage)?;
            SlavePlan::new(spec).map_err(|wrong| Failure::Usage(wrong.words))
        };
        let slaves = if args.nodes().is_empty() {
            args.slaves().iter().cloned().map(slave).collect::<Result<_, _>>()?
        } else {
            Vec::new()
        };
        let faults = args.faults().map_err(Failure::Usage)?;
        Ok(Self { args, slaves, faults })
    }
}

/// Runs one line until its end.
fn run_line(plan: LinePlan, start: &Start) -> Result<(), Failure> {
    let addresses = plan.addresses();
    let LinePlan { args, faults, slaves } = plan;
    let (args, faults) = (&args, &faults);
    if let LinkSpec::Can(link) = &args.link {
        return nodes::emulate(args, link, faults, start);
    }
    // Before the link is made, so that no signal ends the process with the link left behind.
    let signals = Signals::register().map_err(|error| Failure::from_error(&error))?;
    start.ends_with(&signals);
    let clock = SystemClock::new();
    let state = args.state_dir.as_deref().map(StateDir::open).transpose();
    let state = state.map_err(|error| Failure::from_error(&error))?;
    // Before the link, so that a refusal leaves nothing behind.
    let mut panel = start_panel(args, BusKind::Profibus, &signals.stop, start)?;
    let Opened { rate, link, path } =
        open_link(&args.link, args.baud.and_then(BaudSpec::fixed), args.allow_remote)?;
    if let Some(panel) = &panel {
        panel.set_link(&path);
    }
    let (link, bench) = SlavesBench::beside(link, (args, &signals.stop), (clock, rate), panel.as_ref())?;
    // Next to the line, so that what faults do is seen.
    let (link, remarks) = tap::tapped(link, (args, &addresses), &path, clock, panel.as_ref())?;
    let mut link = Faulty::new(link, clock, &[]);
    let switches = arm(link.faults_mut(), faults, clock.now());

    let mut bus = Bus::on(rate, Timing::Untrue);
    if let LinkSpec::Serial(_) = args.link {
        // A late reply is credited to another station of a real line.
        bus.set_slot_time(Some(args.slot_time.map_or(SlotTime::Customary, SlotTime::Bits)));
    }
    // Nobody but a master is on a terminal that was made just now.
    let serial = matches!(args.link, LinkSpec::Serial(_));
    let (listen, search) = (serial && !args.force_address, serial && args.baud == Some(BaudSpec::Auto));
    let (refusals, board) = (Refusals::default(), start.board());
    bus.show_on(board.clone());
    let mut described = Vec::new();
    for slave in slaves {
        let now = clock.now();
        let ground = Ground { now, rate, state: state.as_ref(), refusals: &refusals, board: &board };
        let group = slave.spec.device.group();
        let in_force = connect(&mut bus, slave, &ground, listen, &switches)?;
        if group == Group::Station {
            described.push(in_force);
        }
    }
    let choose = |spec: &mut Spec| {
        // They were checked when the process was started.
        let _ = args.choose_quirks(spec);
    };
    let mut metrics = start.line_metrics(&path, &signals.stop);
    if !start.all_are_open() {
        return Ok(());
    }
    let mut news = News::new(path, &bus, listen, panel.as_ref(), described, start);
    if search {
        bus.search_baud(clock.now());
        // No drive sends anything until a master is heard, so a master need not wait.
        news.announce();
    }
    news.announce_if_decided();
    if args.tried.is_some() {
        bench.take(&bus);
        bench::show(args, panel.as_ref());
    }
    let outcome = loop {
        let outcome = run(&mut link, &mut bus, &clock, &signals.stop, &mut |event| {
            let now = clock.now();
            let words = refusals.words(&event);
            if let Some(panel) = &panel {
                panel.tell_with(now, &event, words.clone());
            }
            remarks.say(&event);
            news.say(now, event, words.as_deref());
            if news.nobody_is_left() {
                signals.end();
            }
        });
        // First, so that a signal after the flags are read, or what the panel asks after it was served, ends the next
        // run.
        signals.stop.clear();
        let end = outcome.is_err() || signals.end.load(Ordering::SeqCst);
        let asked = signals.report.swap(false, Ordering::SeqCst);
        if asked || end {
            report(&bus);
        }
        if asked {
            explain(&bus);
        }
        if end {
            break outcome;
        }
        if let Some(metrics) = &mut metrics {
            metrics.serve(&bus);
        }
        if let Some(panel) = &mut panel {
            let (now, rate, faults) = (clock.now(), bus.baud(), Some(link.faults_mut()));
            let ground = Ground { now, rate, state: state.as_ref(), refusals: &refusals, board: &board };
            panel.serve(&mut BusAccess { bus: &mut bus, faults, ground, choose: &choose, listen });
        }
    };
    news.moving.end();
    drop(panel);
    // Switched off, the drives hand over their last images; the directory waits for them.
    drop(bus);
    drop(state);
    outcome.map_err(|error| Failure::from_error(&error))?;
    if news.nobody_is_left() {
        return Err(Failure::Other(
            "every address is taken by another station; choose others, or --force-address".into(),
        ));
    }
    info!("ended by a signal");
    Ok(())
}

/// A condition on an input of a station, and the switch that it turns.
type Watched = (While, Switch);

/// Adds the faults, and says which inputs turn them on and off.
fn arm(faults: &mut Faults, rules: &[Rule], now: Instant) -> Vec<Watched> {
    let numbers: Vec<u32> = rules
        .iter()
        .map(|rule| {
            warn!("fault on purpose: {rule}");
            faults.add(now, *rule)
        })
        .collect();
    numbers.into_iter().filter_map(|number| faults.watches(number)).collect()
}

/// Says what happens: the ready line on stdout, the rest in the log.
struct News<'a> {
    start: &'a Start,
    path: String,
    /// Where the panel is, as the end of the ready line.
    panel: String,
    /// Drives and stations whose address is not another's, as far as is known.
    drives: Vec<Address>,
    /// Stations that a GSD describes.
    described: Vec<Address>,
    /// How many of them still listen.
    undecided: usize,
    announced: bool,
    /// The search for the rate was said: one line for all rates tried.
    searching: bool,
    last_noise: Option<Instant>,
    /// Noise since then that was not said.
    unsaid: u64,
    moving: Moving,
}

impl<'a> News<'a> {
    fn new(
        path: String,
        bus: &Bus,
        listen: bool,
        panel: Option<&Panel>,
        described: Vec<Address>,
        start: &'a Start,
    ) -> Self {
        let drives: Vec<_> = bus.addresses().collect();
        let undecided = if listen { drives.len() } else { 0 };
        if undecided > 0 {
            info!("listening whether the addresses are free");
        }
        let panel = panel.map(|panel| format!(" panel=http://{}", panel.address())).unwrap_or_default();
        Self {
            start,
            path,
            panel,
            drives,
            described,
            undecided,
            announced: false,
            searching: false,
            last_noise: None,
            unsaid: 0,
            moving: Moving::default(),
        }
    }

    /// `words` stand behind what the event says itself.
    fn say(&mut self, now: Instant, event: BusEvent, words: Option<&str>) {
        self.moving.look(now);
        match event {
            // So many events at once are noise, whatever else there is among them.
            BusEvent::TelegramRefused(_) | BusEvent::Lost { .. } => {
                if self.last_noise.is_some_and(|last| now.saturating_since(last) < NOISE_PAUSE) {
                    let more = if let BusEvent::Lost { events } = event { events } else { 1 };
                    self.unsaid = self.unsaid.saturating_add(more);
                    debug!("{event}");
                    return;
                }
                self.last_noise = Some(now);
                match core::mem::take(&mut self.unsaid) {
                    0 => info!("{event}"),
                    more => info!("{event}; {more} more events since the last such line"),
                }
            }
            BusEvent::Joined { .. } => {
                info!("{event}");
                self.decide();
            }
            BusEvent::AddressLive { address, .. } => {
                warn!("{event}; choose another address, or --force-address");
                self.drives.retain(|drive| *drive != address);
                self.decide();
            }
            BusEvent::Rate(RateChange::Try(_)) if !core::mem::replace(&mut self.searching, true) => {
                info!("{event} and below");
            }
            BusEvent::Rate(RateChange::Try(_)) => debug!("{event}"),
            BusEvent::Rate(RateChange::Found(_)) => {
                self.searching = false;
                info!("{event}");
            }
            BusEvent::MovedToTakenAddress { .. } => warn!("{event}"),
            BusEvent::RateLost { .. } => warn!("{event}"),
            _ if event.is_detail() => debug!("{event}"),
            _ if event.kind() == EventKind::Drive && !self.moving.may_say(now) => debug!("{event}"),
            BusEvent::Hint(_)
            | BusEvent::ByHand { .. }
            | BusEvent::Station { .. }
            | BusEvent::Repeated { .. } => match words {
                Some(words) => info!("{event}: {words}"),
                None => info!("{event}"),
            },
        }
    }

    fn decide(&mut self) {
        self.undecided = self.undecided.saturating_sub(1);
        self.announce_if_decided();
    }

    fn nobody_is_left(&self) -> bool {
        self.drives.is_empty()
    }

    /// Says on stdout that a master can begin, once that is so.
    fn announce_if_decided(&mut self) {
        if self.undecided == 0 && !self.nobody_is_left() {
            self.announce();
        }
    }

    fn announce(&mut self) {
        if core::mem::replace(&mut self.announced, true) {
            return;
        }
        let Self { path, panel, drives, described, .. } = self;
        let stations = ready(drives, described);
        self.start.announce(&format!("ready link={path} {stations}{panel}"));
    }
}

/// The panel of a line, if it is to have one.
fn start_panel(args: &Emulate, bus: BusKind, wake: &Stop, start: &Start) -> Result<Option<Panel>, Failure> {
    let Some(place) = &args.panel else { return Ok(None) };
    let reach = if args.panel_allow_remote { Reach::Network } else { Reach::ThisMachine };
    let panel = Panel::start((place, reach), (&start.name(), bus), wake.clone(), start.panel_lines());
    let panel = panel.map_err(|error| match error {
        PanelError::TooFar { .. } => Failure::Usage(format!(
            "{error}; add --panel-allow-remote if that is wanted, or use --panel 127.0.0.1:PORT; see 'profidrive emulate \
             --help'"
        )),
        PanelError::Listen { .. } | PanelError::Thread { .. } => Failure::from_error(&error),
    })?;
    if let Some(folder) = &args.panel_files {
        panel.set_files(folder);
    }
    let address = panel.address();
    info!("the panel is at http://{address}");
    if !address.ip().is_loopback() {
        let controls = if bus == BusKind::Can { "nodes" } else { "drives" };
        warn!("other machines can connect to the panel at {address} and control the {controls}");
    }
    Ok(Some(panel))
}

/// Logs what was counted: the line, and every station that was asked something.
fn report(bus: &Bus) {
    info!("line: {}", bus.counters());
    for address in bus.addresses() {
        if let Some(counters) = bus.station_counters(address).filter(|station| station.requests.total() > 0) {
            info!("station {address}: {counters}");
        }
    }
}

/// Logs of every drive what keeps it from moving.
fn explain(bus: &Bus) {
    for address in bus.addresses() {
        if let Some(why) = bus.why(address) {
            info!("station {address}: {why}");
        }
    }
}

/// A link, the rate to begin with, and what a master opens.
pub(super) struct Opened {
    pub(super) rate: BaudRate,
    pub(super) link: Box<dyn Link>,
    pub(super) path: String,
}

/// Opens the link of a line with our stations on it.
pub(super) fn open_link(
    link: &LinkSpec,
    rate: Option<BaudRate>,
    allow_remote: bool,
) -> Result<Opened, Failure> {
    let (rate, link, path) = open(link, rate, allow_remote)?;
    Ok(Opened { rate, link, path })
}

fn open(
    link: &LinkSpec,
    rate: Option<BaudRate>,
    allow_remote: bool,
) -> Result<(BaudRate, Box<dyn Link>, String), Failure> {
    match link {
        LinkSpec::Pty(path) => open_pty(path.as_deref(), rate),
        LinkSpec::Serial(device) => {
            let opened = rate.unwrap_or(FIRST_SERIAL_RATE);
            let mut serial = Serial::open(device, opened).map_err(|error| Failure::from_error(&error))?;
            serial.reopen(true);
            match rate {
                Some(rate) => info!("{device} at {rate}, 8 data bits, even parity, 1 stop bit"),
                None => info!("{device}, 8 data bits, even parity, 1 stop bit, at the rate heard on it"),
            }
            Ok((opened, Box::new(serial), device.clone()))
        }
        LinkSpec::Can(_) => {
            Err(Failure::Usage("a link of a CAN bus is for nodes; see 'profidrive emulate --help'".into()))
        }
        LinkSpec::Tcp(place) => open_tcp(place, rate.unwrap_or(UNTIMED_RATE), allow_remote),
    }
}

fn open_tcp(
    place: &str,
    rate: BaudRate,
    allow_remote: bool,
) -> Result<(BaudRate, Box<dyn Link>, String), Failure> {
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

fn open_pty(
    path: Option<&Path>,
    rate: Option<BaudRate>,
) -> Result<(BaudRate, Box<dyn Link>, String), Failure> {
    let mut pty = Pty::open(path).map_err(|error| Failure::from_error(&error))?;
    pty.follow_rate(rate.is_none());
    match rate {
        Some(rate) => info!("a pseudo-terminal at {rate}"),
        None => info!("a pseudo-terminal at {UNTIMED_RATE} until a master sets another rate"),
    }
    let opened = pty.path().display().to_string();
    Ok((rate.unwrap_or(UNTIMED_RATE), Box::new(pty), opened))
}

/// Puts a device on the bus.
fn connect(
    bus: &mut Bus,
    SlavePlan { spec, mut prepared }: SlavePlan,
    ground: &Ground<'_>,
    listen: bool,
    watched: &[Watched],
) -> Result<Address, Failure> {
    info!("{}", prepared.about);
    match (spec.place, spec.device.group()) {
        (126, Group::Drive) => warn!(
            "address 126 is for stations that have no address yet: the drive answers FDL status, Slave_Diag and Get_Cfg \
             there and exchanges no data; give it another address, for example --drive 5"
        ),
        (0, Group::Drive) => warn!("address 0 is usually that of a master, often of a programming device"),
        _ => {}
    }
    let address = spec.address();
    for (watched, switch) in watched.iter().filter(|(watched, _)| watched.station == address) {
        prepared.watched.push((watched.point, watched.condition, switch.clone()));
    }
    let station = prepared.make(ground).map_err(|error| match error {
        MakeError::State(error) => Failure::from_error(&error),
        MakeError::Refused(words) => Failure::Usage(words),
    })?;
    let in_force = station.address();
    if spec.device.group() != Group::Drive && in_force != address {
        let what = if spec.device.group() == Group::Station { "station" } else { "drive" };
        warn!("{what} {address}: Set_Slave_Add gave it address {in_force}, which is used");
    }
    bus.connect(ground.now, station, listen).map_err(|error| Failure::from_error(&error))?;
    Ok(in_force)
}

/// `drives=5 stations=7,9` of the ready line; either part is absent if there are none.
fn ready(addresses: &[Address], stations: &[Address]) -> String {
    let (stations, drives): (Vec<_>, Vec<_>) =
        addresses.iter().partition(|address| stations.contains(address));
    let named = |name: &str, addresses: Vec<&Address>| {
        let addresses: Vec<_> = addresses.into_iter().map(Address::to_string).collect();
        (!addresses.is_empty()).then(|| format!("{name}={}", addresses.join(",")))
    };
    let parts: Vec<_> =
        [named("drives", drives), named("stations", stations)].into_iter().flatten().collect();
    parts.join(" ")
}
