//! One reader of the stream.

use core::time::Duration;

use axum::body::Bytes;
use tokio::sync::{broadcast, mpsc};
use tokio::time::{Instant as Moment, MissedTickBehavior, interval};

use super::super::bus_access::Asking;
use super::super::drives::{Drives, Snapshot};
use super::super::ppo_drives::{self, PpoDriveState};
use super::super::problem::Problem;
use super::super::state::{DriveState, DriveSummary};
use super::super::stations::{GsdStationState, look};
use super::Wanted;
use super::event::{Item, Lost, NewsEvent, message_of};
use super::hub::{Hub, Place};
use crate::host::link::tap::Watch;

/// A state that has not changed is sent again after this time, so that a reader knows that the stream lives.
pub(in crate::panel) const HEARTBEAT: Duration = Duration::from_secs(1);

/// One reader of the stream.
pub(super) struct Subscriber {
    pub(super) asking: Asking,
    pub(super) hub: Hub,
    pub(super) wanted: Wanted,
    pub(super) news: broadcast::Receiver<Item>,
    pub(super) telegrams: broadcast::Receiver<Item>,
    pub(super) out: mpsc::Sender<Bytes>,
    pub(super) lost: Lost,
    pub(super) _place: Place,
    pub(super) _watch: Option<Watch>,
}

/// What a subscriber does next.
enum Next {
    Look(Moment),
    News(Result<Item, broadcast::error::RecvError>),
    Telegram(Result<Item, broadcast::error::RecvError>),
    Gone,
}

/// What a look at the drive or the drives brings.
enum Look {
    /// The state, if it has changed or was not sent for a while.
    There(Option<Bytes>),
    /// The drive is gone, with the last message about it.
    Removed(Bytes),
}

/// What is at an address.
enum Seen {
    Drive(Box<Snapshot>),
    Station(Box<GsdStationState>),
    PpoDrive(Box<PpoDriveState>),
}

impl Subscriber {
    pub(super) async fn run(mut self) {
        // Without states it is only looked whether the drive is still there.
        let every = if self.wanted.states { self.wanted.interval } else { HEARTBEAT };
        let looks = self.wanted.states || self.wanted.address.is_some();
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
                    item.concerns(self.wanted.address).then_some(item.message)
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
                        // The bus has no time: this state is not sent, the next may be.
                        Err(_) if !self.asking.has_ended() => None,
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

    /// Looks at the drive or the drives.
    async fn look(&self, sent: &mut Sent) -> Result<Look, Problem> {
        let Some(address) = self.wanted.address else {
            return Ok(Look::There(sent.drives(self.asking.ask(|bench| Drives::of(bench)).await?)));
        };
        let states = self.wanted.states;
        let found = self.asking.ask(move |bench| match (bench.drive(address), look(bench, address)) {
            (Some(drive), _) => Ok(states.then(|| Seen::Drive(Box::new(Snapshot::of(bench, drive))))),
            (None, Ok(station)) => Ok(states.then(|| Seen::Station(Box::new(station)))),
            (None, Err(_)) => match ppo_drives::look(bench, address) {
                Ok(drive) => Ok(states.then(|| Seen::PpoDrive(Box::new(drive)))),
                Err(_) => Err(bench.now),
            },
        });
        Ok(match found.await? {
            Ok(Some(Seen::Drive(snapshot))) => Look::There(sent.drive(snapshot.state(&self.hub))),
            Ok(Some(Seen::Station(station))) => {
                Look::There(sent.station(station.with_refusal(self.hub.last_station_refusal(address))))
            }
            Ok(Some(Seen::PpoDrive(drive))) => {
                Look::There(sent.ppo_drive(drive.with_refusal(self.hub.last_station_refusal(address))))
            }
            Ok(None) => Look::There(None),
            Err(now) => Look::Removed(NewsEvent::removed(now, address)),
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
    drive: Option<DriveState>,
    drives: Option<Drives>,
    station: Option<GsdStationState>,
    ppo_drive: Option<PpoDriveState>,
    at: Option<Moment>,
}

impl Sent {
    fn drive(&mut self, state: DriveState) -> Option<Bytes> {
        let still = self.drive.as_ref().is_some_and(|before| state.is_same(before));
        let message = self.due(still).then(|| message_of("state", &state))?;
        self.drive = Some(state);
        Some(message)
    }

    fn station(&mut self, state: GsdStationState) -> Option<Bytes> {
        let still = self.station.as_ref().is_some_and(|before| state.is_same(before));
        let message = self.due(still).then(|| message_of("state", &state))?;
        self.station = Some(state);
        Some(message)
    }

    fn ppo_drive(&mut self, state: PpoDriveState) -> Option<Bytes> {
        let still = self.ppo_drive.as_ref().is_some_and(|before| state.is_same(before));
        let message = self.due(still).then(|| message_of("state", &state))?;
        self.ppo_drive = Some(state);
        Some(message)
    }

    fn drives(&mut self, drives: Drives) -> Option<Bytes> {
        let timeless = |drives: &Drives| drives.drives.iter().map(DriveSummary::timeless).collect::<Vec<_>>();
        let still = self.drives.as_ref().is_some_and(|before| timeless(before) == timeless(&drives));
        let message = self.due(still).then(|| message_of("state", &drives))?;
        self.drives = Some(drives);
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
