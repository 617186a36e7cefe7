//! Connections of masters of class 2 and who hands them out (`dp-v1.md` 4).

use std::time::Duration;

use profidrive::profibus::dpv1::Ms2Offer;
use profidrive::time::Instant;

use super::server::{Channel, Contents, Server};
use crate::slave_line::{Answer, RR, RS};

/// How far a connection is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    Free,
    /// Its SAP is not fetched.
    Offered,
    /// The answer to Initiate is not fetched.
    Answering,
    Open,
}

#[derive(Clone, Debug)]
pub(super) struct Connection {
    pub(super) phase: Phase,
    pub(super) master: u8,
    /// The answer to Initiate, and whether it opens.
    answer: (Vec<u8>, bool),
    send_timeout: Duration,
    ends: Instant,
    pub(super) server: Server,
}

#[derive(Clone, Debug)]
pub(super) struct Connections {
    offer: Ms2Offer,
    /// SAP 48 first, downwards.
    pub(super) list: Vec<Connection>,
    /// Those that ended because nothing came.
    pub(super) silent: usize,
}

impl Connections {
    pub(super) fn new(offer: Ms2Offer) -> Self {
        let free = Connection {
            phase: Phase::Free,
            master: 0,
            answer: (Vec::new(), false),
            send_timeout: Duration::ZERO,
            ends: Instant::ZERO,
            server: Server::default(),
        };
        Self { offer, list: vec![free; usize::from(offer.connections)], silent: 0 }
    }

    /// The F-timer and the I-timer.
    pub(super) fn pass(&mut self, now: Instant) {
        for connection in self.list.iter_mut().filter(|connection| connection.ends <= now) {
            self.silent += usize::from(connection.phase != Phase::Free);
            connection.free();
        }
    }

    /// Those that are open, with their masters.
    pub(super) fn open(&self) -> Vec<(u8, u8)> {
        let saps = (0..=48_u8).rev().zip(&self.list);
        let open = saps.filter(|(_, connection)| connection.phase == Phase::Open);
        open.map(|(sap, connection)| (sap, connection.master)).collect()
    }

    /// Three times the least Send_Timeout.
    fn patience(&self) -> Duration {
        3 * Duration::from_millis(10) * u32::from(self.offer.min_send_timeout)
    }

    /// SAP 49.
    pub(super) fn manager(&mut self, now: Instant, sa: u8, data: &[u8]) -> Answer {
        let (patience, offer) = (self.patience(), self.offer);
        let offered = self.list.iter().position(|connection| connection.phase == Phase::Offered);
        match (offered, data.is_empty()) {
            (Some(at), true) if self.list[at].master == sa => {
                let connection = &mut self.list[at];
                connection.phase = Phase::Answering;
                connection.ends = now.saturating_add(patience);
                let [high, low] = offer.min_send_timeout.to_be_bytes();
                Answer::Low(vec![0x56, 48 - at as u8, high, low])
            }
            (_, true) => Answer::Sc,
            // One Initiate at a time.
            (Some(_), false) => RR,
            (None, false) if data.len() > usize::from(offer.max_initiate) => RR,
            (None, false) => {
                let free = self.list.iter_mut().find(|connection| connection.phase == Phase::Free);
                let Some(connection) = free else { return RS };
                connection.master = sa;
                connection.phase = Phase::Offered;
                connection.ends = now.saturating_add(patience);
                connection.answer = answer(&offer, data);
                if let [0x57, _, _, _, high, low, ..] = *data {
                    let times = u32::from(u16::from_be_bytes([high, low]));
                    connection.send_timeout = Duration::from_millis(10) * times;
                }
                Answer::Sc
            }
        }
    }

    /// SAP 48 and below.
    pub(super) fn serve(
        &mut self,
        now: Instant,
        sa: u8,
        (dsap, ssap): (u8, u8),
        data: &[u8],
        contents: &mut Contents,
    ) -> Answer {
        let max = self.offer.max_data;
        let Some(connection) = self.list.get_mut(usize::from(48 - dsap)) else { return RS };
        if connection.master != sa || ssap != 50 {
            return RS;
        }
        let is_abort = matches!(data, [0x58, _, _, ..]);
        match connection.phase {
            Phase::Free | Phase::Offered => RS,
            // The SAP is closed at once.
            Phase::Answering | Phase::Open if is_abort => {
                connection.free();
                Answer::Sc
            }
            Phase::Answering if !data.is_empty() => RR,
            Phase::Answering => {
                let (octets, opens) = connection.answer.clone();
                connection.phase = if opens { Phase::Open } else { Phase::Free };
                connection.heard(now);
                Answer::Low(octets)
            }
            Phase::Open => {
                // A poll without a job keeps nothing.
                if !data.is_empty() || connection.server.is_busy() {
                    connection.heard(now);
                }
                connection.server.take(Channel::Ms2, now, data, max, contents, &mut Vec::new())
            }
        }
    }
}

impl Connection {
    fn free(&mut self) {
        self.phase = Phase::Free;
        self.server = Server::default();
    }

    fn heard(&mut self, now: Instant) {
        self.ends = now.saturating_add(3 * self.send_timeout);
    }
}

/// The answer to Initiate, and whether it opens.
fn answer(offer: &Ms2Offer, data: &[u8]) -> (Vec<u8>, bool) {
    let abort = |reason: u8| (vec![0x58, 1, 0x10 | reason], false);
    let [0x57, _, _, _, high, low, features, _, _, _, _, _, s_type, 2, d_type, 2, _, _, api, scl] = *data
    else {
        return abort(2);
    };
    if features & 1 == 0 {
        return abort(2);
    }
    if (s_type, d_type, api, scl) != (0, 0, 0, 0) {
        return abort(7);
    }
    if u16::from_be_bytes([high, low]) < offer.min_send_timeout {
        return abort(6);
    }
    (vec![0x57, offer.max_data, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0], true)
}
