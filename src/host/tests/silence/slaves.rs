//! A line with a slave of each kind, and a master that sends what it is told to.

use core::time::Duration;
use std::collections::{BTreeSet, HashMap};

use super::words;
use crate::face::Description;
use crate::face::description::Supply;
use crate::host::list::{Ground, Group, Spec};
use crate::host::{Bus, BusEvent, Refusals, ValueBoard};
use crate::profibus::dp;
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{
    Address, DataTelegram, FrameCount, Function, FunctionCode, MAX_TELEGRAM_LEN, Sap, Service, Telegram,
    Timing,
};
use crate::time::{BaudRate, Instant};

/// How a word stays before it is looked at what it did, and how often outputs are sent meanwhile.
pub(super) const CYCLE: Duration = Duration::from_millis(10);
pub(super) const HELD: u32 = 12;

/// A slave, and what a correct master sends it.
pub(super) struct Target {
    pub(super) name: &'static str,
    group: Group,
    spec: &'static str,
    ident: u16,
    user_prm: &'static [u8],
    pub(super) cfg: &'static [u8],
    pub(super) outputs: usize,
    pub(super) kind: words::Kind,
}

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "ag03-1",
        group: Group::Drive,
        spec: "5",
        ident: 0x0AC5,
        user_prm: &[],
        cfg: &[0xF3, 0xF2],
        outputs: 14,
        kind: words::Kind::Ag03,
    },
    Target {
        name: "ag03",
        group: Group::Drive,
        spec: "5,model=ag03",
        ident: 0x0AC5,
        user_prm: &[],
        cfg: &[0xF3, 0xF2],
        outputs: 14,
        kind: words::Kind::Ag03,
    },
    Target {
        name: "ppo-drive",
        group: Group::PpoDrive,
        spec: "5,ppo=1",
        ident: 0x5044,
        user_prm: &[],
        cfg: &[0xF3, 0xF1],
        outputs: 12,
        kind: words::Kind::Ppo,
    },
    Target {
        name: "profidrive",
        group: Group::Profidrive,
        spec: "5,telegram=1",
        ident: 0,
        user_prm: &[0x80, 0, 0],
        cfg: &[0xC3, 0xC1, 0xC1, 0xFD, 0x00, 0x01],
        outputs: 4,
        kind: words::Kind::Profidrive,
    },
    Target {
        name: "station",
        group: Group::Station,
        spec: "5,gsd=GSD",
        ident: 0x0A08,
        user_prm: &[],
        cfg: &[0x10, 0x20],
        outputs: 1,
        kind: words::Kind::Station,
    },
];

/// What came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Reply {
    Silence,
    Sc,
    Status(u8),
    Data(Vec<u8>),
}

impl Reply {
    pub(super) const fn is_positive(&self) -> bool {
        matches!(self, Self::Sc | Self::Data(_))
    }
}

pub(super) struct Line {
    pub(super) target: &'static Target,
    pub(super) bus: Bus,
    pub(super) now: Instant,
    pub(super) counts: HashMap<u8, FrameCount>,
    pub(super) ident: u16,
    /// What the master sends in each cycle.
    pub(super) outputs: Vec<u8>,
    pub(super) inputs: Vec<u8>,
    /// What a person reads, since it was taken.
    pub(super) news: Vec<String>,
    /// The same with everything else, since it was taken.
    pub(super) events: Vec<(Instant, BusEvent)>,
    /// Everything of the walk, for the report.
    pub(super) story: Vec<String>,
    /// What was told and is told once for its kind, until something changes.
    pub(super) once: BTreeSet<String>,
}

pub(super) const SLAVE: u8 = 5;
pub(super) const MASTER: u8 = 2;
pub(super) const OTHER: u8 = 3;

impl Line {
    pub(super) fn of(target: &'static Target) -> Self {
        let mut bus = Bus::on(BaudRate::K500, Timing::Untrue);
        let now = Instant::from_millis(1);
        let gsd = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gsd/remote_io.gsd");
        let spec = Spec::parse(target.group, &target.spec.replace("GSD", gsd)).unwrap();
        let (refusals, board) = (Refusals::default(), ValueBoard::default());
        let ground = Ground { now, rate: BaudRate::K500, state: None, refusals: &refusals, board: &board };
        let station = spec.prepare().unwrap().make(&ground).ok().unwrap();
        bus.connect(now, station, false).unwrap();
        let ident = bus.appearance(Address::station(SLAVE).unwrap()).unwrap().ident.unwrap();
        assert!(target.ident == 0 || ident == target.ident, "{}: {ident:04X}", target.name);
        let outputs = vec![0; target.outputs];
        let (news, story, counts, inputs) = (Vec::new(), Vec::new(), HashMap::new(), Vec::new());
        let (once, events) = (BTreeSet::new(), Vec::new());
        Self { target, bus, now, counts, ident, outputs, inputs, news, events, story, once }
    }

    pub(super) fn slave() -> Address {
        Address::station(SLAVE).unwrap()
    }

    pub(super) fn description(&self) -> Option<&dyn Description> {
        self.bus.description(Self::slave())
    }

    /// Does something to the device.
    pub(super) fn act(&mut self, act: impl FnOnce(&mut dyn Description, Instant)) {
        let now = self.now;
        self.bus.with_description(Self::slave(), |device| act(device, now));
    }

    pub(super) fn is_off(&self) -> bool {
        self.description().and_then(|device| device.supply()) == Some(Supply::Off)
    }

    /// Whether a master owns the slave, and which.
    pub(super) fn owner(&self) -> Option<u8> {
        self.bus.appearance(Self::slave())?.owner.map(Address::number)
    }

    pub(super) fn state(&self) -> Option<dp::State> {
        self.bus.appearance(Self::slave())?.slave
    }

    /// Time passes without telegrams.
    pub(super) fn wait(&mut self, time: Duration) {
        let end = self.now.saturating_add(time);
        while let Some(due) = self.bus.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            self.bus.handle_timeout(self.now);
            let _late = self.bus.poll_transmit(self.now, &mut [0; MAX_TELEGRAM_LEN]);
        }
        self.now = end;
        self.bus.handle_timeout(end);
        self.hear_news();
    }

    pub(super) fn hear_news(&mut self) {
        while let Some(event) = self.bus.poll_event() {
            let text = event.to_string();
            self.events.push((self.now, event.clone()));
            if event.is_detail() {
                self.story.push(format!("      ({text})"));
            } else {
                self.story.push(format!("      {text}"));
                self.once.extend(self.kind_of(&text));
                self.news.push(text);
            }
        }
    }

    /// The kind of what is told once for its kind.
    pub(super) fn kind_of(&self, text: &str) -> Option<String> {
        if let Some((_, rest)) = text.split_once("refused ")
            && let Some((service, _)) = rest.split_once(" of master")
        {
            let service = if text.contains("octets of data") { "with data" } else { service };
            return Some(self.refused(service));
        }
        let kinds =
            ["request that DP does not use", "Sync of master", "Freeze of master", "parameterised by master"];
        let of_words = [
            ("not followed", "a word without control by PLC"),
            ("goes on with what was commanded", "a word without control by PLC"),
            ("octets of STW", "a word without control by PLC"),
            ("enabling operation", "enable"),
            ("inching refused", "inching"),
        ];
        if let Some((_, want)) = of_words.iter().find(|(words, _)| text.contains(words)) {
            return Some(format!("{want} in '{}'", words::Seen::of(self).state));
        }
        if text.contains("ignored the parameters") {
            return Some("Set_Prm not the owner".to_owned());
        }
        kinds.iter().find(|kind| text.contains(**kind)).map(|kind| (*kind).to_owned())
    }

    pub(super) fn refused(&self, service: &str) -> String {
        format!("{service} refused in {:?} of {:?}", self.state(), self.owner())
    }

    pub(super) fn take_news(&mut self) -> Vec<String> {
        core::mem::take(&mut self.news)
    }

    /// Sends octets: what comes back.
    pub(super) fn send(&mut self, octets: &[u8]) -> Option<Vec<u8>> {
        self.wait(Duration::from_micros(300));
        self.bus.handle_bytes(self.now, octets);
        let end = self.now.saturating_add(Duration::from_millis(2));
        let mut buf = [0; MAX_TELEGRAM_LEN];
        loop {
            if let Some(reply) = self.bus.poll_transmit(self.now, &mut buf) {
                let reply = reply.to_vec();
                self.hear_news();
                return Some(reply);
            }
            let Some(due) = self.bus.poll_timeout().filter(|due| *due <= end) else { break };
            self.now = self.now.max(due);
            self.bus.handle_timeout(self.now);
        }
        self.bus.handle_broken_off(self.now);
        self.hear_news();
        None
    }

    /// The octets of a request to `da`; the SSAP of one with a DSAP is `ssap`.
    pub(super) fn request(
        &mut self,
        (sa, da): (u8, u8),
        service: Service,
        dsap: Option<u8>,
        ssap: u8,
        data: &[u8],
    ) -> Vec<u8> {
        let count = match self.counts.get(&sa) {
            None => FrameCount::First,
            Some(FrameCount::First | FrameCount::Odd | FrameCount::Unused) => FrameCount::Even,
            Some(FrameCount::Even) => FrameCount::Odd,
        };
        let sdn = matches!(service, Service::SdnLow | Service::SdnHigh | Service::FdlStatus);
        let count = if sdn { FrameCount::Unused } else { count };
        if !sdn {
            self.counts.insert(sa, count);
        }
        let (dsap, ssap) = (dsap.and_then(Sap::new), dsap.and(Sap::new(ssap)));
        let telegram = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, data),
            da: Address::from_octet(da),
            sa: Address::from_octet(sa),
            dsap,
            ssap,
            fc: FunctionCode::request(service, count),
            data,
        };
        telegram.encode(&mut [0; MAX_TELEGRAM_LEN]).unwrap().to_vec()
    }

    pub(super) fn reply_to(&mut self, octets: &[u8]) -> Reply {
        let Some(reply) = self.send(octets) else { return Reply::Silence };
        let Decoded::Telegram { telegram, .. } = decode(&reply) else { return Reply::Silence };
        match telegram {
            Telegram::ShortAcknowledge => Reply::Sc,
            Telegram::Token { .. } => Reply::Silence,
            Telegram::Data(data) if data.data.is_empty() => match data.fc.function() {
                Function::Response(_, status) => Reply::Status(status as u8),
                _ => Reply::Silence,
            },
            Telegram::Data(data) => Reply::Data(data.data.to_vec()),
        }
    }

    pub(super) fn ask(&mut self, sa: u8, service: dp::Service, data: &[u8]) -> Reply {
        let dsap = service.sap().map(Sap::number);
        let octets = self.request((sa, SLAVE), Service::SrdHigh, dsap, 62, data);
        let reply = self.reply_to(&octets);
        self.story.push(format!("  {} of master {sa} {data:02X?}: {reply:02X?}", service.name()));
        reply
    }

    pub(super) fn control(&mut self, sa: u8, data: &[u8]) {
        let octets = self.request((sa, 127), Service::SdnHigh, Some(58), 62, data);
        self.story.push(format!("  Global_Control of master {sa} {data:02X?}"));
        assert_eq!(self.reply_to(&octets), Reply::Silence);
    }

    /// `sa` passes the token.
    pub(super) fn token(&mut self, da: u8, sa: u8) {
        self.send(&[0xDC, da, sa]);
    }

    /// `sa` asks whether somebody is there.
    pub(super) fn status(&mut self, sa: u8, da: u8) {
        let octets = self.request((sa, da), Service::FdlStatus, None, 62, &[]);
        self.send(&octets);
    }

    /// A telegram whose check sequence is wrong.
    pub(super) fn noise(&mut self) {
        self.send(&[0x10, SLAVE, MASTER, 0x49, 0, 0x16]);
    }

    /// The last Data_Exchange once more, octet for octet.
    pub(super) fn repeat(&mut self) {
        let outputs = self.outputs.clone();
        let octets = self.request((MASTER, SLAVE), Service::SrdHigh, None, 62, &outputs);
        (0..2).for_each(|_| _ = self.reply_to(&octets));
    }

    pub(super) fn prm(&self) -> Vec<u8> {
        let [high, low] = self.ident.to_be_bytes();
        [&[0xB0, 0, 0, 11, high, low, 0], self.target.user_prm].concat()
    }

    /// As a correct master does. Whether it came to Data_Exchange.
    pub(super) fn start_up(&mut self) -> bool {
        let prm = self.prm();
        let _ = self.ask(MASTER, dp::Service::SlaveDiag, &[]);
        let _ = self.ask(MASTER, dp::Service::SetPrm, &prm);
        let _ = self.ask(MASTER, dp::Service::ChkCfg, self.target.cfg);
        for _ in 0..5 {
            self.wait(CYCLE);
            let _ = self.ask(MASTER, dp::Service::SlaveDiag, &[]);
        }
        self.state() == Some(dp::State::DataExch)
    }

    /// Data_Exchange for some cycles: the last reply.
    pub(super) fn exchange(&mut self, cycles: u32) -> Reply {
        let mut last = Reply::Silence;
        for _ in 0..cycles {
            let outputs = self.outputs.clone();
            let octets = self.request((MASTER, SLAVE), Service::SrdHigh, None, 62, &outputs);
            last = self.reply_to(&octets);
            if let Reply::Data(inputs) = &last {
                self.inputs.clone_from(inputs);
            }
            self.wait(CYCLE);
        }
        let told = format!("  {cycles} Data_Exchange {:02X?}: {last:02X?}", self.outputs);
        self.story.push(told);
        last
    }

    /// What is seen of the slave and the device, without what changes by itself.
    pub(super) fn look(&self) -> String {
        let appearance = self.bus.appearance(Self::slave());
        let mut look = String::new();
        if let Some(appearance) = &appearance {
            look += &format!("{:?} {:?} {:?} ", appearance.slave, appearance.owner, appearance.watchdog);
        }
        look + &words::state(self.description())
    }
}
