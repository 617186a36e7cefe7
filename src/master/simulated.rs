//! profirust on a simulated line.

use core::fmt;
use core::time::Duration;

use profirust::dp::{DpEvents, DpMaster};
use profirust::fdl::FdlActiveStation;

use super::phy::{LinkPhy, instant};
use crate::bench::{Line, Master};
use crate::host::link::memory::{End, Wire};
use crate::host::{Link, Received};
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::time::{BaudRate, BaudRateError, Instant, SYN_BITS};

/// profirust as the master of a [`Line`], in virtual time.
///
/// ```
/// use core::time::Duration;
/// use profidrive::devices::ag03::profibus::Config;
/// use profidrive::profibus::fdl::Address;
/// use profidrive::master::{Profirust, baudrate, peripheral};
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
/// let mut line = Profirust::on_line(fdl, dp)?;
/// line.add_drive(Config::new(Address::station(5)?))?;
/// // The third telegram of the drive gets lost, and the master has to cope.
/// line.inject(&["no-reply,at=3".parse()?])?;
/// let took = line.run_until(Duration::from_secs(1), |line| line.master.dp.get_mut(drive).is_running())?;
/// assert!(took < Duration::from_millis(50));
/// line.assert_no_breach();
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Profirust<'a> {
    /// The token and telegram layer.
    pub fdl: FdlActiveStation,
    /// The peripherals and their process images.
    pub dp: DpMaster<'a>,
    phy: LinkPhy<End>,
    /// Where its octets come out, and those of the line go in.
    wire: End,
    baud: BaudRate,
    events: DpEvents,
    /// When it was polled last.
    polled: Instant,
    /// When it last sent or heard an octet.
    activity: Instant,
}

impl fmt::Debug for Profirust<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { baud, polled, activity, .. } = self;
        f.debug_struct("Profirust")
            .field("baud", baud)
            .field("polled", polled)
            .field("activity", activity)
            .finish_non_exhaustive()
    }
}

impl<'a> Profirust<'a> {
    /// A line at the rate and with the slot time of `fdl`, this master on it, without stations. The time is zero.
    ///
    /// # Errors
    /// [`BaudRateError`] for profirust's 31.25 kbit/s, which is not of PROFIBUS-DP on RS-485.
    pub fn on_line(fdl: FdlActiveStation, dp: DpMaster<'a>) -> Result<Line<Self>, BaudRateError> {
        let rate = fdl.parameters().baudrate.to_rate();
        let baud = BaudRate::from_bits_per_second(u32::try_from(rate).unwrap_or(u32::MAX))?;
        let slot_time = duration(fdl.parameters().slot_time());
        let wire = Wire::new();
        let master = Self {
            fdl,
            dp,
            phy: LinkPhy::new(wire.end(), baud),
            wire: wire.end(),
            baud,
            events: DpEvents::default(),
            polled: Instant::ZERO,
            activity: Instant::ZERO,
        };
        let mut line = Line::with(baud, master);
        line.set_slot_time(slot_time);
        Ok(line)
    }

    /// What it has reported since the last call: the newest of each kind.
    #[must_use]
    pub fn take_events(&mut self) -> DpEvents {
        core::mem::take(&mut self.events)
    }

    fn poll(&mut self, now: Instant) {
        self.polled = now;
        self.fdl.poll(instant(now), &mut self.phy, &mut self.dp);
        let DpEvents { cycle_completed, peripheral } = self.dp.take_last_events();
        self.events.cycle_completed |= cycle_completed;
        self.events.peripheral = peripheral.or(self.events.peripheral);
    }
}

impl Master for Profirust<'_> {
    fn handle_bytes(&mut self, now: Instant, octets: &[u8]) {
        // A line in memory does not fail.
        let _ = self.wire.send(octets);
        self.activity = now;
        self.poll(now);
    }

    fn handle_sent(&mut self, now: Instant) {
        self.activity = now;
        self.poll(now);
    }

    fn handle_timeout(&mut self, now: Instant) {
        self.poll(now);
    }

    fn poll_transmit(&mut self, _: Instant, buf: &mut [u8; MAX_TELEGRAM_LEN]) -> Option<usize> {
        match self.wire.receive(buf) {
            Ok(Received::Octets(count)) => Some(count),
            Ok(Received::BrokenOff(_) | Received::Reset | Received::Rate(_) | Received::Nothing) | Err(_) => {
                None
            }
        }
    }

    /// When one of its pauses is over, as far as it can be known from outside: the pause before a request, the slot
    /// time, the time after which a token is lost.
    ///
    /// Each is there twice, one microsecond apart, because profirust gives the token up in one poll and passes it on in
    /// the next.
    fn poll_timeout(&self) -> Option<Instant> {
        let parameters = self.fdl.parameters();
        let slot = duration(parameters.slot_time());
        let pauses = [self.baud.bit_times(SYN_BITS), slot, duration(parameters.token_lost_timeout())];
        // profirust acts when a pause is over, not when it ends.
        let ends = pauses.into_iter().flat_map(|pause| {
            [1, 2]
                .map(|after| self.activity.saturating_add(pause).saturating_add(Duration::from_micros(after)))
        });
        // Nothing is due any more, so nothing is missed by a look per slot time.
        ends.chain([self.polled.saturating_add(slot)]).filter(|end| *end > self.polled).min()
    }
}

fn duration(time: profirust::time::Duration) -> Duration {
    Duration::from_micros(time.total_micros())
}

#[cfg(test)]
mod tests {

    use profirust::Baudrate;
    use profirust::fdl::ParametersBuilder;

    use super::*;
    use crate::bench::{Passed, TimedOut};
    use crate::master::baudrate;

    /// A master without anything to do but pass the token to itself.
    fn alone(baudrate: Baudrate) -> Result<Line<Profirust<'static>>, BaudRateError> {
        let mut fdl = FdlActiveStation::new(ParametersBuilder::new(2, baudrate).build());
        fdl.set_online();
        Profirust::on_line(fdl, DpMaster::new(Vec::new()))
    }

    #[test]
    fn time_passes_as_told_and_no_further() {
        let mut line = alone(baudrate(BaudRate::K500)).unwrap();
        line.run_for(Duration::from_nanos(1_234_567));
        assert_eq!(line.now(), Instant::from_nanos(1_234_567));
        let limit = Duration::from_nanos(7);
        assert_eq!(line.run_until(limit, |_| false), Err(TimedOut { limit }));
        assert_eq!(line.now(), Instant::from_nanos(1_234_574));
        assert_eq!(TimedOut { limit }.to_string(), "not within 7ns");
    }

    #[test]
    fn time_goes_on_whether_the_master_is_there_or_not_and_no_rule_is_broken() {
        for baud in BaudRate::ALL {
            let mut line = alone(baudrate(baud)).unwrap();
            for step in 0..500 {
                let before = line.now();
                // A sending ends and its sender is told at the same time.
                (0..3).for_each(|_| assert!(line.step()));
                assert!(line.now() > before, "{baud}, step {step}");
                if step == 400 {
                    line.master.fdl.set_offline();
                }
            }
            line.assert_no_breach();
        }
    }

    #[test]
    fn what_nobody_takes_is_forgotten_from_the_oldest_on() {
        let mut line = alone(baudrate(BaudRate::K12000)).unwrap();
        line.keep(64);
        line.run_for(Duration::from_millis(20));
        let heard: Vec<Passed> = core::iter::from_fn(|| line.poll_telegram()).collect();
        assert_eq!(heard.len(), 64);
        assert!(heard.first().is_some_and(|first| first.at > Instant::from_millis(5)));
        assert!(heard.windows(2).all(|pair| pair[0].end < pair[1].at));
        assert!(line.poll_telegram().is_none());
    }
}
