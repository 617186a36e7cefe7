//! One reader of the live stream: what it is sent, and when it has read too slowly.

use core::time::Duration;

use axum::body::Bytes;
use tokio::sync::{broadcast, mpsc};
use tokio::time::{Instant as Moment, MissedTickBehavior, interval};

use super::super::line::Lines;
use super::super::problem::Problem;
use super::super::station::State;
use super::super::station::handlers::Stations;
use super::Wanted;
use super::event::{Item, Lost, NewsEvent, message_of};
use super::hub::Seat;
use crate::host::link::tap::Watch;

/// A state that has not changed is sent again after this time, so that a reader knows that the stream lives.
const HEARTBEAT: Duration = Duration::from_secs(1);

/// One reader of the stream.
pub(super) struct Subscriber {
    pub(super) lines: Lines,
    pub(super) wanted: Wanted,
    pub(super) news: broadcast::Receiver<Item>,
    pub(super) telegrams: broadcast::Receiver<Item>,
    pub(super) out: mpsc::Sender<Bytes>,
    pub(super) lost: Lost,
    pub(super) _seat: Seat,
    pub(super) _watches: Vec<Watch>,
}

/// What a subscriber does next.
enum Next {
    Look(Moment),
    News(Result<Item, broadcast::error::RecvError>),
    Telegram(Result<Item, broadcast::error::RecvError>),
    Gone,
}

/// What a look at the station or the stations brings.
enum Look {
    /// The state, if it has changed or was not sent for a while.
    There(Option<Bytes>),
    /// The station is gone, with the last message about it.
    Removed(Bytes),
}

impl Subscriber {
    pub(super) async fn run(mut self) {
        // Without states it is only looked whether the station is still there.
        let every = if self.wanted.states { self.wanted.interval } else { HEARTBEAT };
        let looks = self.wanted.states || self.wanted.station.is_some();
        let mut ticks = interval(every);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let mut last_tick: Option<Moment> = None;
        let mut sent = Sent::default();
        let mut removed = false;
        while !removed {
            let next = tokio::select! {
                () = self.out.closed() => Next::Gone,
                item = self.news.recv(), if self.wanted.news => Next::News(item),
                item = self.telegrams.recv(), if self.wanted.telegrams => Next::Telegram(item),
                tick = ticks.tick(), if looks => Next::Look(tick),
            };
            let message = match next {
                Next::Gone => return,
                Next::News(Ok(item)) | Next::Telegram(Ok(item)) => {
                    self.wanted.concerns(&item).then_some(item.message)
                }
                Next::News(Err(broadcast::error::RecvError::Lagged(count))) => {
                    self.lost.news = self.lost.news.saturating_add(count);
                    None
                }
                Next::Telegram(Err(broadcast::error::RecvError::Lagged(count))) => {
                    self.lost.telegrams = self.lost.telegrams.saturating_add(count);
                    None
                }
                Next::News(Err(broadcast::error::RecvError::Closed))
                | Next::Telegram(Err(broadcast::error::RecvError::Closed)) => return,
                Next::Look(tick) => {
                    if self.wanted.states {
                        let late = last_tick.map_or(0, |last| intervals(tick.duration_since(last), every));
                        self.lost.states = self.lost.states.saturating_add(late.saturating_sub(1));
                        last_tick = Some(tick);
                    }
                    match self.look(&mut sent).await {
                        Ok(Look::There(message)) => message,
                        Ok(Look::Removed(message)) => {
                            removed = true;
                            self.wanted.news.then_some(message)
                        }
                        // The line has no time: this state is not sent, the next may be.
                        Err(_) if !self.has_ended() => None,
                        Err(_) => return,
                    }
                }
            };
            if self.lost != Lost::default() {
                let lost = core::mem::take(&mut self.lost);
                if self.out.send(message_of("lost", &lost)).await.is_err() {
                    return;
                }
            }
            if let Some(message) = message
                && self.out.send(message).await.is_err()
            {
                return;
            }
        }
    }

    /// Whether there is nothing to look at any more.
    fn has_ended(&self) -> bool {
        match &self.wanted.station {
            Some(place) => place.line.asking.has_ended(),
            None => self.lines.all().iter().all(|line| line.asking.has_ended()),
        }
    }

    /// Looks at the station or the stations.
    async fn look(&self, sent: &mut Sent) -> Result<Look, Problem> {
        let Some(place) = &self.wanted.station else {
            let mut stations = Stations::of(&self.lines).await?;
            stations
                .stations
                .retain(|station| self.wanted.line.as_ref().is_none_or(|line| station.is_on(line)));
            return Ok(Look::There(sent.stations(stations)));
        };
        let (states, address, name) = (self.wanted.states, place.address, place.line.name.clone());
        let found = place.line.asking.ask(move |lent| match lent.station(address) {
            Some(_) => Ok(states.then(|| State::of(&name, lent, address).map(Box::new)).flatten()),
            None => Err(lent.now()),
        });
        Ok(match found.await? {
            Ok(Some(mut state)) => {
                let exchanging = state.summary.is_exchanging();
                state.last_refusal = place.line.hub.last_refusal(address, exchanging);
                Look::There(sent.state(state))
            }
            Ok(None) => Look::There(None),
            Err(now) => Look::Removed(NewsEvent::removed(now, &place.line.name, address)),
        })
    }
}

/// Between two ticks; a late one counts as many.
fn intervals(time: Duration, interval: Duration) -> u64 {
    let half = interval / 2;
    u64::try_from(time.saturating_add(half).as_nanos() / interval.as_nanos().max(1)).unwrap_or(u64::MAX)
}

/// What was sent last, and when.
#[derive(Default)]
struct Sent {
    state: Option<Box<State>>,
    stations: Option<Stations>,
    at: Option<Moment>,
}

impl Sent {
    fn state(&mut self, state: Box<State>) -> Option<Bytes> {
        let still = self.state.as_ref().is_some_and(|before| state.is_same(before));
        let message = self.due(still).then(|| message_of("state", &state))?;
        self.state = Some(state);
        Some(message)
    }

    fn stations(&mut self, stations: Stations) -> Option<Bytes> {
        let still = self.stations.as_ref().is_some_and(|before| stations.is_same(before));
        let message = self.due(still).then(|| message_of("state", &stations))?;
        self.stations = Some(stations);
        Some(message)
    }

    /// Whether to send, given that nothing has changed.
    fn due(&mut self, still: bool) -> bool {
        let now = Moment::now();
        let due = !still || self.at.is_none_or(|at| now.duration_since(at) >= HEARTBEAT);
        if due {
            self.at = Some(now);
        }
        due
    }
}
