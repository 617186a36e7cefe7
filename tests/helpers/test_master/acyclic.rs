//! The services of DP-V1 of the test master: our own clients of both classes, beside data exchange; and the mistakes.

use core::time::Duration;
use std::collections::VecDeque;

use profidrive::client::{AcyclicAnswer, AcyclicClient, AcyclicError, Heard};
use profidrive::profibus::dp::ext_diag;
use profidrive::profibus::dpv1::{AlarmHead, TypedBlock};
use profidrive::profibus::fdl::ReplyStatus;
use profidrive::time::Instant;

use super::TestMaster;
use super::mistakes::Mistake;
use super::slave::{Slave, State};

/// Which services it uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Uses {
    /// Those of the owner, SAP 51.
    pub(crate) ms1: bool,
    /// A connection.
    pub(crate) ms2: bool,
}

impl Uses {
    pub(crate) const NOTHING: Self = Self { ms1: false, ms2: false };
}

/// C1_Response_Timeout of the device file.
pub(crate) const TIMEOUT: Duration = Duration::from_millis(500);
/// Send_Timeout, times 10 ms.
const SEND_TIMEOUT: u16 = 20;
/// Polls in a row of a master that does nothing but poll.
const MOST_IN_ROW: u32 = 40;
/// Cycles between two jobs.
const REST: u32 = 20;

/// The octets at which a request or a poll is sent.
type Sent = (u8, Vec<u8>);

/// What it does at one slave.
#[derive(Debug)]
pub(super) struct Services {
    ms1: Option<AcyclicClient>,
    ms2: Option<AcyclicClient>,
    /// The open request is one of these.
    asking: Asking,
    /// It is the turn of the connection.
    of_connection: bool,
    /// What is sent behind this Data_Exchange.
    ready: Option<Sent>,
    /// Cycles since the last job, and jobs.
    rest: u32,
    jobs: u32,
    /// Polls of this job.
    polls: u32,
    /// Turns with nothing but polls.
    in_row: u32,
    alarms: VecDeque<AlarmHead>,
    acknowledged: Option<AlarmHead>,
    /// What the user wants.
    pub(super) wanted: VecDeque<Wanted>,
    /// It asks nothing any more.
    mute: bool,
}

/// A record that the user wants.
#[derive(Clone, Debug)]
pub(super) struct Wanted {
    pub(super) slot: u8,
    pub(super) index: u8,
    /// What is written, or how much is read.
    pub(super) data: Result<Vec<u8>, u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asking {
    Nothing,
    Owner,
    Connection,
    /// What a mistake asks.
    Mistake,
}

impl Services {
    pub(super) fn new(uses: Uses, mistake: Option<Mistake>) -> Self {
        Self {
            ms1: uses.ms1.then(|| owner(mistake)),
            ms2: uses.ms2.then(|| AcyclicClient::class_2(SEND_TIMEOUT, TIMEOUT)),
            asking: Asking::Nothing,
            of_connection: false,
            ready: None,
            rest: 0,
            jobs: 0,
            polls: 0,
            in_row: 0,
            alarms: VecDeque::new(),
            acknowledged: None,
            wanted: VecDeque::new(),
            mute: false,
        }
    }

    /// The slave is started anew: what its owner asked is over.
    pub(super) fn begin(&mut self, mistake: Option<Mistake>) {
        if self.ms1.is_some() && mistake != Some(Mistake::PollsOldJob) {
            self.ms1 = Some(owner(mistake));
        }
        self.alarms.clear();
        self.mute = false;
        (self.ready, self.polls) = (None, 0);
    }

    /// What a diagnosis reports.
    pub(super) fn note(&mut self, diagnosis: &[u8], mistake: Option<Mistake>) {
        if mistake == Some(Mistake::NeverAcknowledges) || self.ms1.is_none() {
            return;
        }
        for block in ext_diag::blocks(diagnosis.get(6..).unwrap_or_default()) {
            if block[0] & 0xC0 == 0
                && let Some(TypedBlock::Alarm { head, .. }) = TypedBlock::parse(&block[1..])
            {
                self.alarms.push_back(head);
            }
        }
    }

    /// The telegram of a service, if there is one.
    fn next(&mut self, now: Instant, turns: u32, mistake: Option<Mistake>) -> Option<Sent> {
        if self.mute {
            return None;
        }
        self.rest += 1;
        if mistake == Some(Mistake::AsksForeignSap) && turns.is_multiple_of(50) {
            self.asking = Asking::Mistake;
            return Some((40, Vec::new()));
        }
        if mistake == Some(Mistake::AcknowledgesTwice)
            && let Some(head) = self.acknowledged.take()
        {
            self.alarms.push_back(head);
        }
        if let Some(client) = self.ms1.as_mut().filter(|client| client.is_open()) {
            let acknowledged = self.alarms.pop_front().map(|mut head| {
                head.sequence ^= u8::from(mistake == Some(Mistake::AcknowledgesOther));
                client.acknowledge(now, head).unwrap();
            });
            let rested = self.rest >= REST && mistake != Some(Mistake::AcknowledgesAtSap50);
            if acknowledged.is_none() && (rested || !self.wanted.is_empty()) {
                self.rest = 0;
                begin(client, now, self.jobs, self.wanted.pop_front(), mistake);
                self.jobs += 1;
            }
            if !client.is_open() {
                self.polls = 0;
            }
        }
        if let Some(sent) = self.ms1.as_mut().and_then(|client| client.poll_transmit(now)) {
            let (dsap, data) = (sent.dsap, sent.data.to_vec());
            self.asking = Asking::Owner;
            self.polls += u32::from(data.is_empty());
            if mistake == Some(Mistake::SecondRequest) && self.polls == 1 && self.jobs.is_multiple_of(3) {
                self.asking = Asking::Mistake;
                return Some((51, vec![0x5E, 1, 9, 4]));
            }
            let other = mistake == Some(Mistake::AcknowledgesAtSap50);
            return Some((if other { 50 } else { dsap }, data));
        }
        self.ask_connection(now, mistake)
    }

    fn ask_connection(&mut self, now: Instant, mistake: Option<Mistake>) -> Option<Sent> {
        let only = self.ms1.is_none();
        let client = self.ms2.as_mut()?;
        if client.is_open() {
            if only && (self.rest >= REST || !self.wanted.is_empty()) {
                (self.rest, self.polls) = (0, 0);
                begin(client, now, self.jobs, self.wanted.pop_front(), mistake);
                self.jobs += 1;
            } else if mistake == Some(Mistake::NoIdle) {
                return None;
            }
        } else if self.rest >= REST / 2 {
            client.open(now);
        }
        let sent = client.poll_transmit(now)?;
        let (dsap, mut data) = (sent.dsap, sent.data.to_vec());
        self.polls += u32::from(data.is_empty());
        self.asking = Asking::Connection;
        if mistake == Some(Mistake::NoReadWrite) && data.first() == Some(&0x57) {
            data[6] = 0;
        }
        if mistake == Some(Mistake::AbortsSlowJob) && self.polls > 3 {
            client.close();
            self.polls = 0;
        }
        Some((dsap, data))
    }

    /// Whether the open request is one of these.
    pub(super) fn is_asking(&self) -> bool {
        self.asking != Asking::Nothing
    }

    /// What came to it. `true`: the slave is to be started anew.
    pub(super) fn take(
        &mut self,
        now: Instant,
        status: Option<ReplyStatus>,
        data: &[u8],
        mistake: Option<Mistake>,
    ) -> bool {
        let heard = match status {
            None => Heard::Acknowledged,
            Some(ReplyStatus::DataLow | ReplyStatus::DataHigh) => Heard::Data(data),
            Some(ReplyStatus::NoResource) => Heard::NoResource,
            Some(_) => Heard::NotActivated,
        };
        self.hand_on(now, heard, mistake)
    }

    /// Nothing came to it, however often it was repeated.
    pub(super) fn silence(&mut self, now: Instant, mistake: Option<Mistake>) {
        self.hand_on(now, Heard::Silence, mistake);
        self.begin(mistake);
    }

    fn hand_on(&mut self, now: Instant, heard: Heard<'_>, mistake: Option<Mistake>) -> bool {
        let asking = core::mem::replace(&mut self.asking, Asking::Nothing);
        let client = match asking {
            Asking::Owner => self.ms1.as_mut(),
            Asking::Connection => self.ms2.as_mut(),
            Asking::Nothing | Asking::Mistake => None,
        };
        let Some(client) = client else { return false };
        let asked = asking == Asking::Owner && heard == Heard::Acknowledged;
        self.mute |= asked && mistake == Some(Mistake::NeverPolls);
        let outcome = client.handle(now, heard);
        if mistake == Some(Mistake::RestartsOnSlowJob) && self.polls > 3 {
            return asking == Asking::Owner;
        }
        match outcome {
            Some(Err(AcyclicError::TimeOut(_))) => asking == Asking::Owner,
            Some(Err(AcyclicError::Refused { .. })) => mistake == Some(Mistake::RestartsOnRefusal),
            Some(Ok(AcyclicAnswer::Acknowledged)) => {
                // Any one will do.
                self.acknowledged = self.acknowledged.or(Some(AlarmHead {
                    kind: profidrive::profibus::dpv1::AlarmType::Process,
                    slot: 1,
                    sequence: 0,
                    additional_ack: false,
                    specifier: profidrive::profibus::dpv1::Specifier::None,
                }));
                false
            }
            Some(Ok(_) | Err(_)) | None => false,
        }
    }

    /// Behind a reply of the slave: whether a telegram of a service follows.
    pub(super) fn prepare(
        &mut self,
        now: Instant,
        (turns, owns): (u32, bool),
        mistake: Option<Mistake>,
    ) -> bool {
        // One way does not keep the other one from its turn.
        self.of_connection = !self.of_connection || !owns;
        let first = if self.of_connection { self.ask_connection(now, mistake) } else { None };
        self.ready = first.or_else(|| if owns { self.next(now, turns, mistake) } else { None });
        self.ready.is_some()
    }

    /// Whether a job of the owner runs.
    fn is_busy(&self) -> bool {
        self.ms1.as_ref().is_some_and(|client| !client.is_open())
    }
}

fn owner(mistake: Option<Mistake>) -> AcyclicClient {
    let patient = mistake == Some(Mistake::PollsForEver);
    AcyclicClient::class_1(if patient { TIMEOUT * 1000 } else { TIMEOUT })
}

/// Begins a job: what the user wants, or one after the other.
fn begin(
    client: &mut AcyclicClient,
    now: Instant,
    jobs: u32,
    wanted: Option<Wanted>,
    mistake: Option<Mistake>,
) {
    let long = mistake == Some(Mistake::LongWrite);
    let data = match jobs % 2 {
        0 => Err(8),
        _ if long => Ok(vec![0x5A; 65]),
        _ => Ok(jobs.to_be_bytes().to_vec()),
    };
    let usual = Wanted { slot: 1, index: 2, data };
    let mut wanted = wanted.unwrap_or(usual);
    wanted.index ^= u8::from(mistake == Some(Mistake::OtherIndex));
    match wanted.data {
        Ok(data) => client.write(now, wanted.slot, wanted.index, &data),
        Err(len) => client.read(now, wanted.slot, wanted.index, len),
    }
    .unwrap();
}

impl TestMaster {
    /// The telegram of a service to this slave, if it is its turn.
    pub(super) fn ask_service(&mut self, turn: usize) -> Option<Sent> {
        let (now, mistake) = (self.now, self.mistake);
        let Slave { services, turns, state, .. } = &mut self.slaves[turn];
        let services = services.as_mut()?;
        let only_polls =
            mistake == Some(Mistake::PollsOnly) && services.is_busy() && *state == State::Exchange;
        // Now and then it exchanges data, or all else would fail, too.
        services.in_row = if only_polls { (services.in_row + 1) % MOST_IN_ROW } else { 0 };
        let only_polls = only_polls && services.in_row > 0;
        if services.ms1.is_none() {
            return services.next(now, *turns, mistake);
        }
        // What the client has handed over is sent before it is asked for more.
        services.ready.take().or_else(|| if only_polls { services.next(now, *turns, mistake) } else { None })
    }
}
