//! The observer: every telegram in, evidence for each row out. Sans-I/O, the same live, in virtual time and for captures.
//!
//! ```text
//! telegram of the master ──▶ framing ──▶ timing ──▶ SD4, FDL status: token
//!                                              ├──▶ SDN: control
//!                                              └──▶ SRD: counting, start_up, contents, exchange
//! telegrams of stations  ──▶ the open Cycle; what it led to is judged with the master's next telegram
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `recent` | the sendings that can still be shown |
//! | `request` | which rows look at a request, and at what it has led to |
//! | `cycle` | a request and what came back |
//! | `view` | what is known of one station |
//! | `framing` | rows F |
//! | `refused` | why data exchange is not reached |
//! | `counting` | rows C and those of bad replies that the frame count bit shows |
//! | `start_up` | rows U, D and L: what is asked when |
//! | `contents` | rows P and G |
//! | `acyclic`, `alarms`, `connections`, `dpv1_status` | rows V |
//! | `exchange` | rows X, D and L of data exchange |
//! | `control` | rows O |
//! | `asked` | rows that need somebody who operates the master |
//! | `token` | rows K |
//! | `timing` | rows T and I |
//! | `measured` | the traffic in figures |

mod acyclic;
mod alarms;
mod asked;
mod connections;
mod contents;
mod control;
mod counting;
mod cycle;
mod dpv1_status;
mod exchange;
mod framing;
mod measured;
mod recent;
mod refused;
mod request;
mod start_up;
mod timing;
mod token;
mod view;

pub(super) use self::acyclic::MOST_BESIDE;
use crate::map::Map;
use core::time::Duration;
use std::collections::BTreeSet;

use super::findings::{Findings, Weight};
use super::rows::Row;
use super::setup::Setup;
use crate::explain::Overheard;
use crate::judge::figures::Figures;
use crate::judge::moment::{Moment, Side, split};
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, Function, Telegram};
use crate::time::{BaudRate, Instant};
use control::Control;
use cycle::{Bad, Cycle, Item};
use recent::Recent;
use timing::Timing;
use token::Ring;
use view::View;

/// The start delimiter of telegrams with eight octets of data.
const SD3: u8 = 0xA2;

/// How the line is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sight {
    /// A link whose times are those of a program that reads.
    Untimed,
    /// Virtual time: exact, at this rate.
    Exact(BaudRate),
    /// A recording: it may begin anywhere.
    Recorded,
}

/// What was seen so far.
#[derive(Debug)]
pub(super) struct Observer {
    pub(super) setup: Setup,
    pub(super) findings: Findings,
    pub(super) figures: Figures,
    /// The last request that got no good answer.
    trouble: Option<Instant>,
    sight: Sight,
    recent: Recent,
    /// The address of the master, once it is known.
    master: Option<Address>,
    /// The first station that it asked: a cycle begins there.
    first_asked: Option<Address>,
    open: Option<Cycle>,
    views: Map<u8, View>,
    /// Addresses that are asked and not configured.
    strangers: BTreeSet<u8>,
    control: Control,
    ring: Ring,
    timing: Timing,
    noise: u32,
    /// What tells another protocol from DP.
    pub(super) overheard: Overheard,
    /// Octets of the master since its last telegram.
    noise_octets: usize,
    telegrams: u64,
    last_heard: Option<Instant>,
    /// FCB of the last counted request to any station, and how often it went on over all of them.
    common: counting::Common,
    /// Replies are held back on purpose.
    pub(super) held_back: bool,
    pub(super) asked_for: asked::Asked,
    /// So much is wrong on purpose that only coming back is judged.
    pub(super) blind: bool,
    /// Nothing is wrong on purpose.
    pub(super) watching: bool,
}

impl Observer {
    pub(super) fn new(setup: Setup, sight: Sight) -> Self {
        let mut findings = Findings::default();
        for slave in &setup.stations {
            findings.identify(slave.address, slave.ident);
        }
        Self {
            master: setup.master,
            setup,
            sight,
            findings,
            figures: Figures::default(),
            trouble: None,
            recent: Recent::default(),
            first_asked: None,
            open: None,
            views: Map::new(),
            strangers: BTreeSet::new(),
            control: Control::default(),
            ring: Ring::default(),
            timing: Timing::default(),
            noise: 0,
            overheard: Overheard::default(),
            noise_octets: 0,
            telegrams: 0,
            last_heard: None,
            common: counting::Common::default(),
            held_back: false,
            blind: false,
            asked_for: asked::Asked::default(),
            watching: matches!(sight, Sight::Recorded),
        }
    }

    /// The watchdog time that the master has set in each station.
    pub(super) fn watchdogs(&self) -> Vec<(Address, Duration)> {
        let set = |(number, view): &(u8, View)| Some((Address::from_octet(*number), view.watchdog?));
        self.views.iter().filter_map(set).collect()
    }

    /// The address of the master, once it is known.
    pub(super) const fn master(&self) -> Option<Address> {
        self.master
    }

    /// When the master was heard last.
    pub(super) const fn last_heard(&self) -> Option<Instant> {
        self.last_heard
    }

    /// Whole telegrams of the master.
    pub(super) const fn telegrams(&self) -> u64 {
        self.telegrams
    }

    /// Octets of the master since its last whole telegram.
    pub(super) const fn noise_octets(&self) -> usize {
        self.noise_octets
    }

    /// Good exchanges in a row with a station.
    pub(super) fn streak(&self, station: Address) -> u32 {
        self.views.get(&station.number()).map_or(0, |view| view.streak)
    }

    /// Good exchanges with a station, all of them.
    pub(super) fn exchanges(&self, station: Address) -> u32 {
        self.views.get(&station.number()).map_or(0, |view| view.exchanges)
    }

    /// Complete start-ups of a station.
    pub(super) fn start_ups(&self, station: Address) -> u32 {
        self.views.get(&station.number()).map_or(0, |view| view.start_ups)
    }

    /// Data_Exchange requests to a station, retries apart.
    pub(super) fn polled(&self, station: Address) -> u32 {
        self.views.get(&station.number()).map_or(0, |view| view.polled)
    }

    /// All requests to a station since streaks began.
    pub(super) fn asks(&self, station: Address) -> u32 {
        self.views.get(&station.number()).map_or(0, |view| view.asks)
    }

    /// When a station was asked last, FDL status included.
    pub(super) fn last_asked(&self, station: Address) -> Option<Instant> {
        self.views.get(&station.number())?.spoken_to
    }

    /// Whether a time is longer ago than that, seen from the last telegram.
    pub(super) fn is_long_ago(&self, at: Instant, time: Duration) -> bool {
        self.last_heard.is_some_and(|heard| heard.saturating_since(at) >= time)
    }

    /// A row was broken by what was seen over a longer time: the last telegrams show it.
    pub(super) fn show(&mut self, row: Row, weight: Weight, reason: String) {
        let shown = self.recent.since(self.recent.newest().saturating_sub(6), None);
        self.findings.broken(row, weight, reason, shown);
    }

    /// Counts of good exchanges and of requests begin anew.
    pub(super) fn begin_streaks(&mut self) {
        for view in self.views.values_mut() {
            view.streak = 0;
            view.asks = 0;
        }
    }

    /// The judge could not look at the line for a while: what waits then proves nothing.
    pub(super) fn paused(&mut self) {
        if let Some(open) = &mut self.open {
            open.void = true;
        }
        self.timing.paused();
    }

    /// Takes a sending.
    pub(super) fn take(&mut self, moment: Moment) {
        match moment.side {
            Side::Master => self.master_sent(moment),
            Side::Other(_) => self.other_sent(moment),
            Side::Station(_) => self.station_sent(&moment),
        }
    }

    /// The recording or the judgement has come to its end.
    pub(super) fn finish(&mut self) {
        self.blind = false;
        self.close();
        self.finish_control();
        self.finish_timing();
        self.finish_token();
        self.finish_counting();
        self.finish_exchange();
    }

    fn held(&mut self, row: Row) {
        self.findings.held(row);
    }

    /// A row was broken; the telegrams from a number on show it.
    fn broken(
        &mut self,
        row: Row,
        weight: Weight,
        from: u64,
        station: Option<Address>,
        reason: impl Into<String>,
    ) {
        // In a flood of errors a master may take noise for a reply, and is right.
        if self.blind {
            return;
        }
        let shown = self.recent.since(from, station);
        self.findings.broken(row, weight, reason.into(), shown);
    }

    fn view(&mut self, station: Address) -> &mut View {
        self.views.or_default(station.number())
    }

    fn station_sent(&mut self, moment: &Moment) {
        let side = Side::Station(self.open.as_ref().map(|open| open.to));
        // Two at once: what the master hears of them nobody knows.
        if self.timing.is_heard_at(moment.at)
            && let Some(open) = &mut self.open
        {
            open.items.insert(0, Item::Bad(Bad::Noise));
        }
        for octets in split(&moment.octets) {
            let shown = Moment { side, octets: octets.to_vec(), ..*moment };
            if let Some(open) = &mut self.open {
                // What began while the master still sent it cannot have heard.
                open.void |= moment.at < open.end;
                let item = open.classify(octets);
                open.sd3 |= octets.first() == Some(&SD3);
                open.answered_at.get_or_insert(moment.at);
                open.items.push(item);
            }
            self.recent.keep(shown);
        }
        self.timing.heard(moment.end, self.open.is_some());
    }

    /// Another master has sent, which the judge plays: it answers the one under test, or has the token.
    fn other_sent(&mut self, moment: Moment) {
        let end = moment.end;
        let token = match decode(&moment.octets) {
            Decoded::Telegram { telegram: Telegram::Token { sa, .. }, .. } => Some(sa),
            Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. } => None,
        };
        if let Some(open) = &mut self.open {
            let item = open.classify(&moment.octets);
            open.answered_at.get_or_insert(moment.at);
            open.items.push(item);
        } else {
            // Times without the token say nothing of the master.
            self.timing.away(end);
            self.trouble = Some(end);
        }
        if let Some(sa) = token.filter(|sa| self.master != Some(*sa)) {
            self.note_other_master(sa);
        }
        self.recent.keep(moment);
        self.timing.heard(end, self.open.is_some());
    }

    /// How the line is seen.
    pub(super) const fn sight(&self) -> Sight {
        self.sight
    }

    fn master_sent(&mut self, moment: Moment) {
        self.last_heard = Some(moment.end);
        let octets = moment.octets.clone();
        let (at, end) = (moment.at, moment.end);
        let serial = self.recent.keep(moment);
        self.overheard.take(&octets);
        let telegram = match decode(&octets) {
            Decoded::Telegram { telegram, len } if len == octets.len() => telegram,
            Decoded::Telegram { .. } => return self.not_framed(serial, &octets, None),
            Decoded::Incomplete => {
                let broken = u8::try_from(octets.len()).unwrap_or(u8::MAX);
                return self.not_framed(
                    serial,
                    &octets,
                    Some(crate::profibus::fdl::FrameError::BrokenOff { octets: broken }),
                );
            }
            Decoded::Invalid { error, .. } => return self.not_framed(serial, &octets, Some(error)),
        };
        let function = match &telegram {
            Telegram::Data(data) => Some(data.fc.function()),
            Telegram::Token { .. } | Telegram::ShortAcknowledge => None,
        };
        // In noise one octet may look like SC, and three like a token.
        let is_sure = match &telegram {
            Telegram::Data(_) => true,
            Telegram::Token { da, sa } => da == sa,
            Telegram::ShortAcknowledge => false,
        };
        if is_sure {
            self.telegrams += 1;
            self.noise_octets = 0;
        }
        if !matches!(function, Some(Function::Response(..))) {
            self.judge_pace(serial, at, &octets);
        }
        self.close();
        self.timing.sent(at, end);
        self.framed(serial, &telegram);
        match telegram {
            Telegram::Token { da, sa } => self.token(serial, da, sa),
            Telegram::ShortAcknowledge => {}
            Telegram::Data(data) => self.requested(serial, end, &octets, &data),
        }
    }
}
