//! A bus in one process and in simulated time.

use core::fmt;
use core::time::Duration;
use std::collections::VecDeque;
use std::vec::Vec;

use profirust::dp::{DpEvents, DpMaster};
use profirust::fdl::FdlActiveStation;
use thiserror::Error;

use super::phy::{LinkPhy, instant};
use crate::device::{Config, Device, Event, MAX_TELEGRAM_LEN, Timing};
use crate::host::link::memory::{End, Wire};
use crate::host::{self, Link, Received};
use crate::time::{BaudRate, BaudRateError, Instant, SYN_BITS};

/// Telegrams kept for [`SimulatedBus::poll_telegram`]. When nobody takes them, the oldest are forgotten.
const HEARD_LEN: usize = 64;

/// profirust and emulated drives on one line, with a clock that stands until it is told to go on.
///
/// ```
/// use core::time::Duration;
/// use profidrive::device::Config;
/// use profidrive::fdl::Address;
/// use profidrive::master::{SimulatedBus, baudrate, peripheral};
/// use profidrive::time::BaudRate;
/// use profirust::{dp::DpMaster, fdl::{FdlActiveStation, ParametersBuilder}};
///
/// let mut dp = DpMaster::new(Vec::new());
/// let drive = dp.add(peripheral(5, BaudRate::K500));
/// dp.enter_operate();
/// let parameters = ParametersBuilder::new(2, baudrate(BaudRate::K500)).build_verified(&dp);
/// let mut fdl = FdlActiveStation::new(parameters);
/// fdl.set_online();
///
/// let mut bus = SimulatedBus::new(fdl, dp)?;
/// bus.connect(Config::new(Address::station(5)?))?;
/// let took = bus.run_until(Duration::from_secs(1), |bus, _| bus.dp.get_mut(drive).is_running())?;
/// assert!(took < Duration::from_millis(50));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Time jumps to the next point at which something happens: the end of a telegram, a deadline of a drive, the end of
/// one of profirust's pauses. Octets arrive when they would on a wire. Nothing sleeps, and the same calls give the
/// same telegrams at the same nanoseconds on every machine.
pub struct SimulatedBus<'a> {
    /// The master's token and telegram layer.
    pub fdl: FdlActiveStation,
    /// The master's peripherals and their process images.
    pub dp: DpMaster<'a>,
    phy: LinkPhy<End>,
    /// The drives' end of the wire.
    wire: End,
    devices: Vec<Device>,
    baud: BaudRate,
    now: Instant,
    /// What is being said on the line.
    talk: Option<Talk>,
    /// When profirust last sent or heard an octet.
    activity: Instant,
    heard: VecDeque<Heard>,
}

/// One telegram on the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Heard {
    /// When its first octet began.
    pub at: Instant,
    /// Who sent it.
    pub sender: Sender,
    /// All of it.
    pub octets: Vec<u8>,
}

/// Who sent a telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sender {
    /// profirust.
    Master,
    /// The drive with this address.
    Drive(u8),
}

impl fmt::Display for Sender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Master => f.write_str("master"),
            Self::Drive(address) => write!(f, "drive {address}"),
        }
    }
}

/// A telegram under way.
struct Talk {
    heard: Heard,
    /// How many of its octets have reached profirust.
    arrived: usize,
}

/// What was waited for did not come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("waited {limit:?} in vain")]
pub struct TimedOut {
    /// How long was waited, in simulated time.
    pub limit: Duration,
}

impl<'a> SimulatedBus<'a> {
    /// A line at the rate of `fdl` with this master on it, without drives. The time is zero.
    ///
    /// # Errors
    /// [`BaudRateError`] for profirust's 31.25 kbit/s, which is not of PROFIBUS-DP on RS-485.
    pub fn new(fdl: FdlActiveStation, dp: DpMaster<'a>) -> Result<Self, BaudRateError> {
        let rate = fdl.parameters().baudrate.to_rate();
        let baud = BaudRate::from_bits_per_second(u32::try_from(rate).unwrap_or(u32::MAX))?;
        let line = Wire::new();
        Ok(Self {
            fdl,
            dp,
            phy: LinkPhy::new(line.end(), baud),
            wire: line.end(),
            devices: Vec::new(),
            baud,
            now: Instant::ZERO,
            talk: None,
            activity: Instant::ZERO,
            heard: VecDeque::new(),
        })
    }

    /// Connects a drive and switches it on now. Rate and [`Timing::True`] of the line replace those of `config`.
    ///
    /// # Errors
    /// [`host::Error::AddressTaken`] if another drive has its address.
    pub fn connect(&mut self, config: Config) -> Result<(), host::Error> {
        let address = config.switches.address();
        if self.devices.iter().any(|other| other.address() == address) {
            return Err(host::Error::AddressTaken { address: address.number() });
        }
        let config = Config { baud: self.baud, timing: Timing::True, ..config };
        self.devices.push(Device::new(config, self.now));
        Ok(())
    }

    /// The time on the bus.
    pub const fn now(&self) -> Instant {
        self.now
    }

    /// The rate of the line.
    pub const fn baud(&self) -> BaudRate {
        self.baud
    }

    /// The drive at `address`.
    pub fn device(&self, address: u8) -> Option<&Device> {
        self.devices.iter().find(|device| device.address().number() == address)
    }

    /// The drive at `address`, to change what acts on it: [`Device::set_inputs`] with the time of [`Self::now`].
    pub fn device_mut(&mut self, address: u8) -> Option<&mut Device> {
        self.devices.iter_mut().find(|device| device.address().number() == address)
    }

    /// The oldest telegram not taken yet, of the last 64. A telegram is there once it has ended.
    #[must_use]
    pub fn poll_telegram(&mut self) -> Option<Heard> {
        self.heard.pop_front()
    }

    /// News of a drive, and its address.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<(u8, Event)> {
        self.devices
            .iter_mut()
            .find_map(|device| device.poll_event().map(|event| (device.address().number(), event)))
    }

    /// Goes to the next point in time at which something happens, and lets it happen.
    ///
    /// profirust is polled once; what it reports are its events of this poll.
    pub fn step(&mut self) -> DpEvents {
        self.advance_to(self.next())
    }

    /// Lets `duration` pass.
    pub fn run_for(&mut self, duration: Duration) {
        let end = self.now.saturating_add(duration);
        while self.now < end {
            self.advance_to(self.next().min(end));
        }
    }

    /// Steps until `condition` holds after a step, at most for `limit`. Says how long it took.
    ///
    /// `condition` also sees what profirust reported in that step.
    ///
    /// # Errors
    /// [`TimedOut`]; the time is then `limit` later.
    pub fn run_until(
        &mut self,
        limit: Duration,
        mut condition: impl FnMut(&mut Self, &DpEvents) -> bool,
    ) -> Result<Duration, TimedOut> {
        let start = self.now;
        let end = start.saturating_add(limit);
        while self.now < end {
            let events = self.advance_to(self.next().min(end));
            if condition(self, &events) {
                return Ok(self.now.saturating_since(start));
            }
        }
        Err(TimedOut { limit })
    }
}

impl SimulatedBus<'_> {
    /// When something happens next: always later than now.
    fn next(&self) -> Instant {
        let devices = self.devices.iter().filter_map(Device::poll_timeout);
        let next = devices.chain(self.talk_continues()).chain(self.master_acts()).min();
        // Nanoseconds are what the clock counts in: with no step smaller than one it always goes on.
        next.unwrap_or(self.now).max(self.now.saturating_add(Duration::from_nanos(1)))
    }

    /// When profirust must next see the telegram on the line: at its first octet, at its end, and between them
    /// before the shortest slot time (100 bits) has passed.
    fn talk_continues(&self) -> Option<Instant> {
        const OCTETS_AT_ONCE: usize = 8;

        let Talk { heard, arrived } = self.talk.as_ref()?;
        let len = heard.octets.len();
        let until = match heard.sender {
            Sender::Master => len,
            Sender::Drive(_) if *arrived == 0 => 1,
            Sender::Drive(_) => len.min(arrived.saturating_add(OCTETS_AT_ONCE)),
        };
        Some(heard.at.saturating_add(octet_times(self.baud, until)))
    }

    /// When one of profirust's pauses is over, as far as it can be known from outside: the pause before a request,
    /// the slot time, the time after which a token is lost.
    ///
    /// Each is there twice, one microsecond apart, because profirust gives the token up in one poll and passes it
    /// on in the next.
    fn master_acts(&self) -> impl Iterator<Item = Instant> {
        let parameters = self.fdl.parameters();
        let micros = |duration: profirust::time::Duration| Duration::from_micros(duration.total_micros());
        let (now, activity) = (self.now, self.activity);
        let slot = micros(parameters.slot_time());
        let pauses = [self.baud.bit_times(SYN_BITS), slot, micros(parameters.token_lost_timeout())];
        // profirust acts when a pause is over, not when it ends.
        let ends = pauses.into_iter().flat_map(move |pause| {
            [1, 2].map(|after| activity.saturating_add(pause).saturating_add(Duration::from_micros(after)))
        });
        // Nothing is due any more, so nothing is missed by a look per slot time.
        ends.chain([now.saturating_add(slot)]).filter(move |end| *end > now)
    }

    fn advance_to(&mut self, now: Instant) -> DpEvents {
        self.now = now;
        self.carry();
        self.run_devices();
        self.fdl.poll(instant(now), &mut self.phy, &mut self.dp);
        self.hear_master();
        self.dp.take_last_events()
    }

    /// Brings the octets on the line to who hears them.
    fn carry(&mut self) {
        let Some(mut talk) = self.talk.take() else {
            return;
        };
        let Heard { at, sender, octets } = &talk.heard;
        let spoken = self.now.saturating_since(*at);
        let mut arrived = talk.arrived;
        while arrived < octets.len() && octet_times(self.baud, arrived + 1) <= spoken {
            arrived += 1;
        }
        match sender {
            Sender::Master => {}
            Sender::Drive(_) => {
                if let Some(new) = octets.get(talk.arrived..arrived).filter(|new| !new.is_empty()) {
                    // A line in memory does not fail.
                    let _ = self.wire.send(new);
                    self.activity = self.now;
                }
            }
        }
        if arrived < octets.len() {
            talk.arrived = arrived;
            self.talk = Some(talk);
            return;
        }
        self.activity = self.now;
        for device in &mut self.devices {
            if *sender != Sender::Drive(device.address().number()) {
                device.handle_bytes(self.now, octets);
            }
        }
        if self.heard.len() == HEARD_LEN {
            self.heard.pop_front();
        }
        self.heard.push_back(talk.heard);
    }

    /// Does what is due in the drives, and begins the reply if there is one.
    fn run_devices(&mut self) {
        let now = self.now;
        let mut buf = [0; MAX_TELEGRAM_LEN];
        for device in &mut self.devices {
            if device.poll_timeout().is_some_and(|due| due <= now) {
                device.handle_timeout(now);
            }
            if let Some(octets) = device.poll_transmit(now, &mut buf) {
                let sender = Sender::Drive(device.address().number());
                self.talk = Some(Talk::begin(now, sender, octets));
            }
        }
    }

    /// Begins what profirust has just sent.
    fn hear_master(&mut self) {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        if let Ok(Received::Octets(count)) = self.wire.receive(&mut buf) {
            let octets = buf.get(..count).unwrap_or_default();
            self.talk = Some(Talk::begin(self.now, Sender::Master, octets));
            self.activity = self.now.saturating_add(octet_times(self.baud, count));
        }
    }
}

impl Talk {
    fn begin(at: Instant, sender: Sender, octets: &[u8]) -> Self {
        Self { heard: Heard { at, sender, octets: octets.to_vec() }, arrived: 0 }
    }
}

fn octet_times(baud: BaudRate, octets: usize) -> Duration {
    baud.octet_times(u32::try_from(octets).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use profirust::Baudrate;
    use profirust::fdl::ParametersBuilder;
    use std::string::ToString;

    use super::*;
    use crate::master::baudrate;

    /// A master without anything to do but pass the token to itself.
    fn alone(baudrate: Baudrate) -> Result<SimulatedBus<'static>, BaudRateError> {
        let mut fdl = FdlActiveStation::new(ParametersBuilder::new(2, baudrate).build());
        fdl.set_online();
        SimulatedBus::new(fdl, DpMaster::new(Vec::new()))
    }

    #[test]
    fn time_passes_as_told_and_no_further() {
        let mut bus = alone(baudrate(BaudRate::K500)).unwrap();
        bus.run_for(Duration::from_nanos(1_234_567));
        assert_eq!(bus.now(), Instant::from_nanos(1_234_567));
        let limit = Duration::from_nanos(7);
        assert_eq!(bus.run_until(limit, |_, _| false), Err(TimedOut { limit }));
        assert_eq!(bus.now(), Instant::from_nanos(1_234_574));
        assert_eq!(TimedOut { limit }.to_string(), "waited 7ns in vain");
    }

    #[test]
    fn every_step_goes_on_in_time_whether_the_master_is_there_or_not() {
        for baud in BaudRate::ALL {
            let mut bus = alone(baudrate(baud)).unwrap();
            for step in 0..500 {
                let before = bus.now();
                bus.step();
                assert!(bus.now() > before, "{baud}, step {step}");
                if step == 400 {
                    bus.fdl.set_offline();
                }
            }
        }
    }

    #[test]
    fn what_nobody_takes_is_forgotten_from_the_oldest_on() {
        let mut bus = alone(baudrate(BaudRate::K12000)).unwrap();
        bus.run_for(Duration::from_millis(20));
        let heard: Vec<Heard> = core::iter::from_fn(|| bus.poll_telegram()).collect();
        assert_eq!(heard.len(), HEARD_LEN);
        assert!(heard.first().is_some_and(|first| first.at > Instant::from_millis(5)));
        assert!(heard.windows(2).all(|pair| pair[0].at < pair[1].at));
    }

    #[test]
    fn the_rate_of_profibus_pa_is_refused() {
        assert_eq!(alone(Baudrate::B31250).err(), Some(BaudRateError { got: 31_250 }));
    }
}
