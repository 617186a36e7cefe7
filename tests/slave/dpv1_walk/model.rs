//! What `dp-v1.md` and `dp-v0.md` say a slave of DP-V1 answers, written from them: sections 1 to 7, and 2.3, 4, 5.2, 6.2, 7.

use std::collections::VecDeque;
use std::time::Duration;

use profidrive::profibus::dp::State;
use profidrive::profibus::dpv1::Offer;
use profidrive::profibus::fdl::FrameCount;
use profidrive::time::Instant;

use super::connections::Connections;
use super::server::{Channel, Contents, Server};
use crate::dpv1_line::{CFG, Request};
use crate::slave_line::{Answer, RS};

/// An alarm that is not acknowledged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Raised {
    /// Type, slot, and the octet of number, Add_Ack and specifier.
    pub(super) head: [u8; 3],
    pub(super) data: Vec<u8>,
    pub(super) delivered: bool,
}

/// Whether Data_Exchange is answered with high priority.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Announced {
    No,
    Yes,
    /// What was announced has gone with the data exchange: nothing says whether it is.
    Either,
}

/// What stands in front of Slave_Diag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Front {
    Alarm,
    Message,
}

#[derive(Clone, Debug)]
pub(super) struct Model {
    offer: Offer,
    pub(super) contents: Contents,
    pub(super) state: State,
    pub(super) owner: Option<u8>,
    /// Its time, and when the owner was heard.
    watchdog: Option<(Duration, Instant)>,
    faults: (bool, bool),
    /// DPV1_Status_1 to 3.
    status: [u8; 3],
    announced: Announced,
    front: Option<Front>,
    pub(super) alarms: Vec<Raised>,
    messages: VecDeque<Vec<u8>>,
    pub(super) ms1: Server,
    alarm_sap: Server,
    pub(super) connections: Connections,
    last: Option<(Request, Vec<Answer>)>,
    fed: bool,
}

impl Model {
    pub(super) fn new(offer: Offer, contents: Contents) -> Self {
        Self {
            offer,
            contents,
            state: State::WaitPrm,
            owner: None,
            watchdog: None,
            faults: (false, false),
            status: [0; 3],
            announced: Announced::No,
            front: None,
            alarms: Vec::new(),
            messages: VecDeque::new(),
            ms1: Server::default(),
            alarm_sap: Server::default(),
            connections: Connections::new(offer.ms2.unwrap()),
            last: None,
            fed: false,
        }
    }

    /// The records stay.
    pub(super) fn power_cycle(&mut self) {
        *self = Self::new(self.offer, self.contents.clone());
    }

    pub(super) fn pass(&mut self, now: Instant) -> bool {
        self.connections.pass(now);
        let expired = self.watchdog.is_some_and(|(time, heard)| heard.saturating_add(time) <= now);
        if expired {
            self.leave();
        }
        expired
    }

    /// What it may answer; mostly one thing.
    pub(super) fn hear(&mut self, now: Instant, request: &Request) -> Vec<Answer> {
        self.pass(now);
        // 2.3 rule 4: the frame count bit of the frame before, and the same frame.
        let bit = |request: &Request| request.count != FrameCount::Even;
        if request.count != FrameCount::First
            && let Some((last, answers)) = &self.last
            && bit(last) == bit(request)
            && (last.sa, last.saps, last.service, &last.data)
                == (request.sa, request.saps, request.service, &request.data)
        {
            let answers = answers.clone();
            if self.fed {
                self.feed(now, request.sa);
            }
            return answers;
        }
        self.fed = false;
        let answers = self.answers(now, request);
        self.last = Some((request.clone(), answers.clone()));
        answers
    }

    /// Global_Control and other frames without a reply: what comes behind is no retry.
    pub(super) fn hear_control(&mut self, now: Instant) {
        self.pass(now);
        self.last = None;
    }

    fn answers(&mut self, now: Instant, request: &Request) -> Vec<Answer> {
        let Request { sa, saps, data, .. } = request;
        let is_owner = self.owner == Some(*sa);
        let Some((dsap, ssap)) = *saps else { return self.data_exchange(now, *sa, data) };
        let answer = match dsap {
            51 | 50 if !(is_owner && self.is_open()) => RS,
            51 | 50 => {
                let (channel, server) = match dsap {
                    51 => (Channel::Ms1, &mut self.ms1),
                    _ => (Channel::Alarms, &mut self.alarm_sap),
                };
                let max = self.offer.ms1.unwrap();
                server.take(channel, now, data, max, &mut self.contents, &mut self.alarms)
            }
            49 => self.connections.manager(now, *sa, data),
            0..49 => self.connections.serve(now, *sa, (dsap, ssap), data, &mut self.contents),
            60 => self.slave_diag(now, *sa),
            61 => self.set_prm(now, *sa, data),
            62 => match self.state {
                State::WaitPrm => RS,
                State::WaitCfg | State::DataExch if !is_owner => RS,
                State::WaitCfg | State::DataExch => {
                    self.feed(now, *sa);
                    self.faults.1 = data[..] != CFG;
                    if self.faults.1 {
                        self.leave()
                    } else {
                        self.state = State::DataExch
                    }
                    Answer::Sc
                }
            },
            _ => unreachable!("SAP {dsap}"),
        };
        vec![answer]
    }

    fn data_exchange(&mut self, now: Instant, sa: u8, data: &[u8]) -> Vec<Answer> {
        if self.owner != Some(sa) || self.state != State::DataExch {
            return vec![RS];
        }
        self.feed(now, sa);
        if data.len() != 2 {
            self.leave();
            return vec![RS];
        }
        let (low, high) = (Answer::Low(vec![0, 0]), Answer::High(vec![0, 0]));
        match self.announced {
            Announced::No => vec![low],
            Announced::Yes => vec![high],
            Announced::Either => vec![low, high],
        }
    }

    fn slave_diag(&mut self, now: Instant, sa: u8) -> Answer {
        let bit = |set: bool, number: u32| u8::from(set) << number;
        let block = match self.front {
            None => Vec::new(),
            Some(Front::Message) => self.messages[0].clone(),
            Some(Front::Alarm) => {
                let alarm = self.alarms.iter().find(|alarm| !alarm.delivered).unwrap();
                [&alarm.head[..], &alarm.data].concat()
            }
        };
        let disturbs = self.front == Some(Front::Alarm) && block[2] & 1 == 1;
        let one = bit(self.state != State::DataExch, 1)
            | bit(self.faults.1, 2)
            | bit(disturbs, 3)
            | bit(self.faults.0, 6);
        let two = 0x04 | bit(self.state == State::WaitPrm, 0) | bit(self.watchdog.is_some(), 3);
        let mut octets = vec![one, two, 0, self.owner.unwrap_or(255), 0xC0, 0xDE];
        if !block.is_empty() {
            octets.push(1 + block.len() as u8);
            octets.extend(block);
        }
        if self.owner == Some(sa) {
            self.feed(now, sa);
            self.announced = Announced::No;
            match self.front.take() {
                None => {}
                Some(Front::Message) => drop(self.messages.pop_front()),
                Some(Front::Alarm) => {
                    self.alarms.iter_mut().find(|alarm| !alarm.delivered).unwrap().delivered = true;
                }
            }
            self.put_in_front();
        }
        Answer::Low(octets)
    }

    /// `dp-v0.md` 5.2, by its steps.
    fn set_prm(&mut self, now: Instant, sa: u8, data: &[u8]) -> Answer {
        if self.owner.is_some_and(|owner| owner != sa) {
            return Answer::Sc;
        }
        self.feed(now, sa);
        let [station, f1, f2, _, high, low, _, ref user @ ..] = *data else {
            self.faults.0 = true;
            self.leave();
            return Answer::Sc;
        };
        match (station & 0x80 != 0, station & 0x40 != 0) {
            (_, true) => self.leave(),
            (false, false) => {}
            (true, false) => match <[u8; 3]>::try_from(user) {
                Ok(status) if [high, low] == [0xC0, 0xDE] => {
                    self.leave();
                    self.faults.0 = false;
                    self.state = State::WaitCfg;
                    self.owner = Some(sa);
                    self.status = status;
                    let time = Duration::from_millis(10) * u32::from(f1) * u32::from(f2);
                    self.watchdog = (station & 8 != 0).then_some((time, now));
                }
                Ok(_) | Err(_) => {
                    self.faults.0 = true;
                    self.leave();
                }
            },
        }
        Answer::Sc
    }

    fn feed(&mut self, now: Instant, sa: u8) {
        self.fed = true;
        if let (true, Some((_, heard))) = (self.owner == Some(sa), &mut self.watchdog) {
            *heard = now;
        }
    }

    pub(super) fn is_open(&self) -> bool {
        self.state == State::DataExch && self.status[0] & 0x80 != 0
    }

    /// Leave-Master: jobs, responses and alarms are dropped.
    fn leave(&mut self) {
        if self.announced == Announced::Yes {
            self.announced = Announced::Either;
        }
        self.state = State::WaitPrm;
        self.owner = None;
        self.watchdog = None;
        self.front = None;
        self.alarms.clear();
        self.messages.clear();
        self.ms1 = Server::default();
        self.alarm_sap = Server::default();
    }

    /// 6.2: whether an alarm may come.
    pub(super) fn may_raise(&self, kind: u8) -> bool {
        let bit = |kind: u8| match kind {
            1 => 5,
            2 => 6,
            3 | 4 => 7,
            5 => 3,
            6 => 2,
            _ => 4,
        };
        let in_all = match self.status[2] & 7 {
            0 => None,
            mode => Some([2, 4, 8, 12, 16, 24, 32][usize::from(mode) - 1]),
        };
        let room = match in_all.filter(|_| self.offer.alarms.sequence >= 2) {
            Some(limit) => self.alarms.len() < usize::from(self.offer.alarms.sequence).min(limit),
            None => self.alarms.iter().all(|alarm| bit(alarm.head[0]) != bit(kind)),
        };
        let types = self.offer.alarms.types & self.status[1];
        self.is_open() && types >> bit(kind) & 1 == 1 && room
    }

    /// An alarm was raised; the number is the slave's choice, and one that no other alarm has.
    pub(super) fn raised(&mut self, head: [u8; 3], data: &[u8]) {
        let number = head[2] >> 3;
        let in_sequence = self.status[2] & 7 != 0 && self.offer.alarms.sequence >= 2;
        assert!(in_sequence || number == 0, "type mode");
        assert!(!in_sequence || self.alarms.iter().all(|alarm| alarm.head[2] >> 3 != number));
        self.alarms.push(Raised { head, data: data.to_vec(), delivered: false });
        self.put_in_front();
    }

    /// A status message: whether it may be sent. Four wait at most.
    pub(super) fn send_status(&mut self, block: Vec<u8>) -> bool {
        let may = self.is_open() && self.messages.len() < 4;
        if may {
            self.messages.push_back(block);
            self.put_in_front();
        }
        may
    }

    fn put_in_front(&mut self) {
        if self.front.is_none() {
            self.front = match (self.alarms.iter().any(|alarm| !alarm.delivered), self.messages.is_empty()) {
                (true, _) => Some(Front::Alarm),
                (false, false) => Some(Front::Message),
                (false, true) => return,
            };
            self.announced = Announced::Yes;
        }
    }
}

/// A negative response.
pub(super) fn refused(function: u8, code: u8) -> Vec<u8> {
    vec![function | 0x80, 0x80, code, 0]
}
