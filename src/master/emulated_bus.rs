//! A bus in one process and in virtual time.

use core::fmt;
use core::time::Duration;
use std::collections::VecDeque;
use std::io;
use std::vec::Vec;

use profirust::dp::{DpEvents, DpMaster};
use profirust::fdl::FdlActiveStation;
use thiserror::Error;

use super::phy::{LinkPhy, instant};
use crate::device::{Config, Device, Event, MAX_TELEGRAM_LEN, Timing};
use crate::fdl::Address;
use crate::host::link::fault::{Fault, Faulty};
use crate::host::link::memory::{End, Wire};
use crate::host::{self, Bus, BusEvent, Link, ManualClock, Participant, Received, Stop};
use crate::time::{BaudRate, BaudRateError, Instant, SYN_BITS};

/// Telegrams kept for [`EmulatedBus::poll_telegram`]. When nobody takes them, the oldest are forgotten.
const HEARD_LEN: usize = 64;

/// profirust and emulated stations on one line, with a clock that stands until it is told to go on.
///
/// ```
/// use core::time::Duration;
/// use profidrive::device::Config;
/// use profidrive::fdl::Address;
/// use profidrive::master::{EmulatedBus, baudrate, peripheral};
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
/// let mut bus = EmulatedBus::new(fdl, dp)?;
/// bus.connect(Config::new(Address::station(5)?))?;
/// // The third telegram of the drive gets lost, and the master has to cope.
/// bus.inject(&["no-reply,at=3".parse()?]);
/// let took = bus.run_until(Duration::from_secs(1), |bus, _| bus.dp.get_mut(drive).is_running())?;
/// assert!(took < Duration::from_millis(50));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Time jumps to the next point at which something happens: the end of a telegram, a deadline of a station, the end of
/// one of profirust's pauses. Octets arrive when they would on a wire. Nothing sleeps, and the same calls give the
/// same telegrams at the same nanoseconds on every machine.
///
/// The stations are those of a [`Bus`], so a line can also have slaves that are no drives ([`EmulatedBus::stations`]).
/// Two that send at the same time (profirust, and a drive whose reply is late on purpose) are heard by nobody.
pub struct EmulatedBus<'a> {
    /// The master's token and telegram layer.
    pub fdl: FdlActiveStation,
    /// The master's peripherals and their process images.
    pub dp: DpMaster<'a>,
    phy: LinkPhy<End>,
    /// Where the master's octets come out, and the stations' go in.
    wire: End,
    bus: Bus,
    /// Between the wire and the stations.
    faults: Faulty<Passage, ManualClock>,
    clock: ManualClock,
    baud: BaudRate,
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
    /// A station: a drive, or another one.
    Station,
}

impl fmt::Display for Sender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Master => "master",
            Self::Station => "station",
        })
    }
}

/// A telegram under way.
struct Talk {
    heard: Heard,
    /// How many of its octets have reached profirust.
    arrived: usize,
    /// Another sends at the same time.
    collided: bool,
}

/// Telegrams between the faults and the line, as a link that [`Faulty`] wraps.
#[derive(Debug, Default)]
struct Passage {
    /// What the master has said.
    requests: VecDeque<u8>,
    /// What the stations say, after the faults, one entry for what goes out in one piece.
    replies: VecDeque<Vec<u8>>,
}

impl Link for Passage {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        let count = buf.len().min(self.requests.len());
        for (to, octet) in buf.iter_mut().zip(self.requests.drain(..count)) {
            *to = octet;
        }
        Ok(if count == 0 { Received::Nothing } else { Received::Octets(count) })
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        self.replies.push_back(telegram.to_vec());
        Ok(())
    }

    fn wait(&mut self, _: Option<Duration>, _: &Stop) -> io::Result<()> {
        Ok(())
    }
}

/// What was waited for did not come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("waited {limit:?} in vain")]
pub struct TimedOut {
    /// How long was waited, in virtual time.
    pub limit: Duration,
}

impl<'a> EmulatedBus<'a> {
    /// A line at the rate of `fdl` with this master on it, without stations. The time is zero.
    ///
    /// # Errors
    /// [`BaudRateError`] for profirust's 31.25 kbit/s, which is not of PROFIBUS-DP on RS-485.
    pub fn new(fdl: FdlActiveStation, dp: DpMaster<'a>) -> Result<Self, BaudRateError> {
        let rate = fdl.parameters().baudrate.to_rate();
        let baud = BaudRate::from_bits_per_second(u32::try_from(rate).unwrap_or(u32::MAX))?;
        let line = Wire::new();
        let clock = ManualClock::new();
        Ok(Self {
            fdl,
            dp,
            phy: LinkPhy::new(line.end(), baud),
            wire: line.end(),
            bus: Bus::on(baud, Timing::True),
            faults: Faulty::new(Passage::default(), clock.clone(), &[]),
            clock,
            baud,
            talk: None,
            activity: Instant::ZERO,
            heard: VecDeque::new(),
        })
    }

    /// Connects a drive and switches it on now. Rate and [`Timing::True`] of the line replace those of `config`.
    ///
    /// # Errors
    /// [`host::Error::AddressTaken`] if another station has its address.
    pub fn connect(&mut self, config: Config) -> Result<(), host::Error> {
        let config = Config { baud: self.baud, timing: Timing::True, ..config };
        self.bus.add(Device::new(config, self.now()))
    }

    /// The stations, to connect, look at and disconnect any of them: a drive with a stored EEPROM, another slave.
    pub fn stations(&mut self) -> &mut Bus {
        &mut self.bus
    }

    /// These faults are injected from now on, instead of those before; none: the line is sound. They count
    /// telegrams from here.
    pub fn inject(&mut self, faults: &[Fault]) {
        self.faults = Faulty::new(Passage::default(), self.clock.clone(), faults);
    }

    /// The time on the bus.
    pub fn now(&self) -> Instant {
        use crate::host::Clock;

        self.clock.now()
    }

    /// The rate of the line.
    pub const fn baud(&self) -> BaudRate {
        self.baud
    }

    /// The drive at `address`.
    pub fn device(&self, address: u8) -> Option<&Device> {
        self.bus.station(Address::station(address).ok()?)
    }

    /// Does something to the station at `address` now, if there is one and it is a `T`: sets what acts on a
    /// [`Device`] with [`Device::set_inputs`], say.
    pub fn with<T: Participant, R>(
        &mut self,
        address: u8,
        act: impl FnOnce(&mut T, Instant) -> R,
    ) -> Option<R> {
        let now = self.now();
        self.bus.with(Address::station(address).ok()?, |station| act(station, now))
    }

    /// The oldest telegram not taken yet, of the last 64. A telegram is there once it has ended.
    #[must_use]
    pub fn poll_telegram(&mut self) -> Option<Heard> {
        self.heard.pop_front()
    }

    /// News of a drive or another station, and its address.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<(u8, Event)> {
        loop {
            // What else a bus tells is of lines on which others may be.
            if let BusEvent::Station { address, event } = self.bus.poll_event()? {
                return Some((address.number(), event));
            }
        }
    }

    /// Goes to the next point in time at which something happens, and lets it happen.
    ///
    /// profirust is polled once; what it reports are its events of this poll.
    pub fn step(&mut self) -> DpEvents {
        self.advance_to(self.next())
    }

    /// Lets `duration` pass.
    pub fn run_for(&mut self, duration: Duration) {
        let end = self.now().saturating_add(duration);
        while self.now() < end {
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
        let start = self.now();
        let end = start.saturating_add(limit);
        while self.now() < end {
            let events = self.advance_to(self.next().min(end));
            if condition(self, &events) {
                return Ok(self.now().saturating_since(start));
            }
        }
        Err(TimedOut { limit })
    }
}

impl EmulatedBus<'_> {
    /// When something happens next: always later than now.
    fn next(&self) -> Instant {
        let stations = [self.bus.poll_timeout(), self.faults.poll_timeout()].into_iter().flatten();
        let next = stations.chain(self.talk_continues()).chain(self.master_acts()).min();
        // Nanoseconds are what the clock counts in: with no step smaller than one it always goes on.
        next.unwrap_or(self.now()).max(self.now().saturating_add(Duration::from_nanos(1)))
    }

    /// When profirust must next see the telegram on the line: at its first octet, at its end, and between them
    /// before the shortest slot time (100 bits) has passed.
    fn talk_continues(&self) -> Option<Instant> {
        const OCTETS_AT_ONCE: usize = 8;

        let Talk { heard, arrived, .. } = self.talk.as_ref()?;
        let len = heard.octets.len();
        let until = match heard.sender {
            Sender::Master => len,
            Sender::Station if *arrived == 0 => 1,
            Sender::Station => len.min(arrived.saturating_add(OCTETS_AT_ONCE)),
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
        let (now, activity) = (self.now(), self.activity);
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
        self.clock.advance_to(now);
        self.carry(now);
        self.run_stations(now);
        self.fdl.poll(instant(now), &mut self.phy, &mut self.dp);
        self.hear_master(now);
        self.dp.take_last_events()
    }

    /// Brings the octets on the line to who hears them.
    fn carry(&mut self, now: Instant) {
        let Some(mut talk) = self.talk.take() else {
            return;
        };
        let Heard { at, sender, octets } = &talk.heard;
        let spoken = now.saturating_since(*at);
        let mut arrived = talk.arrived;
        while arrived < octets.len() && octet_times(self.baud, arrived + 1) <= spoken {
            arrived += 1;
        }
        match sender {
            Sender::Master => {}
            Sender::Station => {
                if let Some(new) = octets.get(talk.arrived..arrived).filter(|new| !new.is_empty()) {
                    if !talk.collided {
                        // A line in memory does not fail.
                        let _ = self.wire.send(new);
                    }
                    self.activity = now;
                }
            }
        }
        if arrived < octets.len() {
            talk.arrived = arrived;
            self.talk = Some(talk);
            return;
        }
        self.activity = now;
        if talk.collided {
            return;
        }
        if *sender == Sender::Master {
            self.tell_stations(now, octets);
        }
        if self.heard.len() == HEARD_LEN {
            self.heard.pop_front();
        }
        self.heard.push_back(talk.heard);
    }

    /// A telegram of the master has ended, and goes to the stations as far as the faults let it pass.
    fn tell_stations(&mut self, now: Instant, octets: &[u8]) {
        self.faults.link_mut().requests.extend(octets);
        let mut buf = [0; MAX_TELEGRAM_LEN];
        // Nor does a passage.
        while let Ok(Received::Octets(count)) = self.faults.receive(&mut buf) {
            self.bus.handle_bytes(now, buf.get(..count).unwrap_or_default());
        }
    }

    /// Does what is due in the stations, and begins the reply if there is one.
    fn run_stations(&mut self, now: Instant) {
        if self.bus.poll_timeout().is_some_and(|due| due <= now) {
            self.bus.handle_timeout(now);
        }
        let mut buf = [0; MAX_TELEGRAM_LEN];
        while let Some(octets) = self.bus.poll_transmit(now, &mut buf) {
            let _ = self.faults.send(octets);
        }
        // Looks for late replies, too.
        self.tell_stations(now, &[]);
        let replies: Vec<u8> = self.faults.link_mut().replies.drain(..).flatten().collect();
        if !replies.is_empty() {
            self.begin(now, Sender::Station, replies);
        }
    }

    /// Begins what profirust has just sent.
    fn hear_master(&mut self, now: Instant) {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        if let Ok(Received::Octets(count)) = self.wire.receive(&mut buf) {
            let octets = buf.get(..count).unwrap_or_default();
            self.begin(now, Sender::Master, octets.to_vec());
            self.activity = now.saturating_add(octet_times(self.baud, count));
        }
    }

    /// Somebody sends. Who still does so is no longer understood, nor is the new one.
    fn begin(&mut self, at: Instant, sender: Sender, octets: Vec<u8>) {
        let collided = self.talk.is_some();
        self.talk = Some(Talk { heard: Heard { at, sender, octets }, arrived: 0, collided });
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
    fn alone(baudrate: Baudrate) -> Result<EmulatedBus<'static>, BaudRateError> {
        let mut fdl = FdlActiveStation::new(ParametersBuilder::new(2, baudrate).build());
        fdl.set_online();
        EmulatedBus::new(fdl, DpMaster::new(Vec::new()))
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
