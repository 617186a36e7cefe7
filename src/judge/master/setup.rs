//! What is configured in the master under test: its stations, and what it says of itself.

use core::time::Duration;

use crate::gsd::{Gsd, MasterGsd};
use crate::profibus::dp::IoLengths;
use crate::profibus::dp::dpv1_status::Status2;
use crate::profibus::dpv1::{AlarmOffer, MAX_DATA, Ms2Offer, Offer};
use crate::profibus::fdl::Address;
use crate::time::BaudRate;

/// The least Send_Timeout of a connection to a station that the judge plays, times 10 ms.
const LEAST_SEND_TIMEOUT: u16 = 10;

/// What kind of master it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MasterClass {
    /// It parameterises its slaves and exchanges data with them.
    #[default]
    One,
    /// It reads slaves that another master owns, which the judge plays.
    Two,
}

/// What the master is configured to. What is `None` is not judged.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// What it is.
    pub class: MasterClass,
    /// The stations configured in the master; those that a master of class 2 reads.
    pub stations: Vec<Slave>,
    /// The address of the master.
    pub master: Option<Address>,
    /// The watchdog time of the stations that have none of their own.
    pub watchdog: Option<Duration>,
    /// How often it repeats a request.
    pub retries: Option<u32>,
    /// The rate of the line.
    pub baud: Option<BaudRate>,
    /// How long it waits for a reply, T_SL.
    pub slot: Option<Duration>,
    /// The highest station address, HSA.
    pub hsa: Option<Address>,
    /// The GAP factor G.
    pub gap_factor: Option<u32>,
    /// The target rotation time, T_TR.
    pub ttr: Option<Duration>,
    /// Min_Slave_Interval of stations that have none of their own.
    pub min_interval: Option<Duration>,
    /// Auto_Clear is configured (Error_Action_Flag): within twice this time, Data_Control_Time, the master goes to CLEAR
    /// when data exchange with a station is not possible. `None`: it is not configured.
    pub auto_clear: Option<Duration>,
    /// The master's own device file.
    pub master_gsd: Option<Box<MasterGsd>>,
}

/// A station that is configured in the master.
#[derive(Clone, Debug)]
pub struct Slave {
    /// Its address.
    pub address: Address,
    /// Ident_Number.
    pub ident: u16,
    /// The identifiers of Chk_Cfg; `None`: whatever the device file allows.
    pub cfg: Option<Vec<u8>>,
    /// User_Prm_Data; `None`: their content is not judged.
    pub prm: Option<Vec<u8>>,
    /// Group_Ident.
    pub groups: Option<u8>,
    /// Data_Exchange without outputs means the safe state.
    pub fail_safe: bool,
    /// Min_Slave_Interval.
    pub min_interval: Option<Duration>,
    /// The watchdog time; zero: it is off.
    pub watchdog: Option<Duration>,
    /// It is configured in the master and never there.
    pub absent: bool,
    /// It is a slave of DP-V1 with every service, and its user parameters begin with DPV1_Status; of a station with a device
    /// file that says so.
    pub dpv1: bool,
    /// Its device file.
    pub gsd: Option<Box<Gsd>>,
}

impl Slave {
    /// A station given by numbers.
    pub const fn new(address: Address, ident: u16, cfg: Vec<u8>) -> Self {
        Self {
            address,
            ident,
            cfg: Some(cfg),
            prm: None,
            groups: None,
            fail_safe: false,
            min_interval: None,
            watchdog: None,
            absent: false,
            dpv1: false,
            gsd: None,
        }
    }

    /// Whether its user parameters begin with DPV1_Status.
    pub(super) fn has_dpv1_status(&self) -> bool {
        self.gsd.as_ref().map_or(self.dpv1, |gsd| gsd.flags.dpv1)
    }

    /// What it offers of DP-V1.
    pub(super) fn offer(&self) -> Offer {
        match &self.gsd {
            _ if !self.has_dpv1_status() => Offer::NONE,
            Some(gsd) => gsd.acyclic.offer(LEAST_SEND_TIMEOUT),
            None => Offer {
                ms1: Some(MAX_DATA),
                ms2: Some(Ms2Offer {
                    connections: 4,
                    min_send_timeout: LEAST_SEND_TIMEOUT,
                    ..Ms2Offer::PLAIN
                }),
                alarms: AlarmOffer { types: !Status2::RESERVED, sequence: 32, extra_sap: true },
            },
        }
    }

    /// How long the master waits for the response of the owner's channel, C1_Response_Timeout.
    pub(super) fn response_timeout(&self) -> Option<Duration> {
        let units = self.gsd.as_ref()?.acyclic.c1_response.filter(|units| *units > 0)?;
        Some(Duration::from_millis(10) * u32::from(units))
    }

    /// As `--station` has it.
    fn words(&self) -> String {
        let millis = |time: Duration| time.as_secs_f64() * 1000.0;
        let hex = |octets: &[u8]| octets.iter().map(|octet| format!("{octet:02X}")).collect::<String>();
        let mut words = format!("{},ident={:04X}", self.address, self.ident);
        let parts = [
            self.cfg.as_ref().map(|cfg| format!(",cfg={}", hex(cfg))),
            self.prm.as_ref().map(|prm| format!(",prm={}", hex(prm))),
            self.groups.map(|groups| format!(",groups={groups:02X}")),
            self.fail_safe.then(|| ",failsafe=1".into()),
            self.min_interval.map(|time| format!(",min-interval={}", millis(time))),
            self.watchdog.map(|time| format!(",watchdog={}", millis(time))),
            self.absent.then(|| ",absent".into()),
            self.dpv1.then(|| ",dpv1".into()),
        ];
        words.extend(parts.into_iter().flatten());
        words
    }

    /// How many octets it exchanges, if its configuration is known and can be exchanged.
    pub fn lengths(&self) -> Option<IoLengths> {
        IoLengths::of(self.cfg.as_deref()?).ok()
    }
}

impl Setup {
    /// Whether it is a master of class 2.
    pub(super) fn is_class_2(&self) -> bool {
        self.class == MasterClass::Two
    }

    /// Whether a station has services of DP-V1 for this master.
    pub(super) fn has_services(&self, slave: &Slave) -> bool {
        let offer = slave.offer();
        if self.is_class_2() { offer.ms2.is_some() } else { !offer.is_none() }
    }

    /// The station at an address.
    pub fn slave(&self, address: Address) -> Option<&Slave> {
        self.stations.iter().find(|slave| slave.address == address)
    }

    /// The stations that are there.
    pub fn present(&self) -> impl Iterator<Item = &Slave> {
        self.stations.iter().filter(|slave| !slave.absent)
    }

    /// Min_Slave_Interval of a station.
    pub fn min_interval(&self, address: Address) -> Option<Duration> {
        self.slave(address).and_then(|slave| slave.min_interval).or(self.min_interval)
    }

    /// The watchdog time of a station.
    pub fn watchdog(&self, address: Address) -> Option<Duration> {
        self.slave(address).and_then(|slave| slave.watchdog).or(self.watchdog)
    }

    /// The longest watchdog time.
    pub(super) fn longest_watchdog(&self) -> Option<Duration> {
        self.stations.iter().filter_map(|slave| self.watchdog(slave.address)).max()
    }

    /// What is configured, as the options of the command have it: the name and the value of each.
    pub(super) fn words(&self) -> Vec<(&'static str, String)> {
        let millis = |time: Duration| format!("{}", time.as_secs_f64() * 1000.0);
        let mut words: Vec<(&'static str, String)> =
            self.stations.iter().map(|slave| ("station", slave.words())).collect();
        let others = [
            ("class", self.is_class_2().then(|| "2".into())),
            ("master", self.master.map(|master| master.to_string())),
            ("watchdog", self.watchdog.map(millis)),
            ("retries", self.retries.map(|retries| retries.to_string())),
            ("baud", self.baud.map(|baud| baud.bits_per_second().to_string())),
            ("slot", self.slot.map(millis)),
            ("hsa", self.hsa.map(|hsa| hsa.to_string())),
            ("gap-factor", self.gap_factor.map(|factor| factor.to_string())),
            ("ttr", self.ttr.map(millis)),
            ("min-interval", self.min_interval.map(millis)),
            ("auto-clear", self.auto_clear.map(millis)),
            ("master-gsd", self.master_gsd.as_ref().map(|gsd| format!("{} {}", gsd.vendor, gsd.model))),
        ];
        words.extend(others.into_iter().filter_map(|(name, value)| Some((name, value?))));
        words
    }
}
