//! A small DP master, class 1, without token, for two stations: what somebody writes in an afternoon.

use profidrive::bench::Master;
use profidrive::profibus::dp::Diagnosis;
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameCount, FrameError, Function, FunctionCode, MAX_TELEGRAM_LEN, ReplyStatus,
    Sap, Service, Telegram,
};
use profidrive::time::{BaudRate, Instant};

/// What it can be told to do wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mistake {
    NoPause,
    IgnoresNotReady,
    TogglesInRetry,
    BelievesWrongFcs,
    NeverStartsAgain,
}

/// Each mistake and what the bench says of it.
pub(super) const MISTAKES: [(Mistake, &str); 5] = [
    (Mistake::NoPause, "of silence, expected T_SYN"),
    (Mistake::IgnoresNotReady, "Data_Exchange to a station that is not ready"),
    (Mistake::TogglesInRetry, "a request without reply is repeated as it was"),
    (Mistake::BelievesWrongFcs, "a reply with a wrong FCS is no reply"),
    (Mistake::NeverStartsAgain, "station 6 is started again: not within 1s"),
];

const BAUD: BaudRate = BaudRate::K1500;
const SLOT_BITS: u32 = 300;
const RETRIES: u8 = 2;

/// Where a station is in its start-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Diagnosis,
    Parameters,
    Configuration,
    Ready,
    Exchange,
}

struct Peer {
    address: u8,
    ident: u16,
    cfg: &'static [u8],
    outputs: usize,
    step: Step,
    count: FrameCount,
    retries: u8,
}

pub(super) struct Naive {
    mistake: Option<Mistake>,
    /// Exchanges with each station, since it was set to 0.
    pub(super) exchanges: [u32; 2],
    peers: [Peer; 2],
    turn: usize,
    asked: bool,
    heard: Vec<u8>,
    /// The next request, or the end of waiting for a reply.
    due: Instant,
}

impl Naive {
    pub(super) fn new(mistake: Option<Mistake>) -> Self {
        let peer = |address, ident, cfg, outputs| Peer {
            address,
            ident,
            cfg,
            outputs,
            step: Step::Diagnosis,
            count: FrameCount::First,
            retries: 0,
        };
        let peers = [peer(5, 0x0AC5, &[0xF3, 0xF2], 14), peer(6, 0x1234, &[0x23, 0x13], 4)];
        let due = Instant::ZERO.saturating_add(BAUD.bit_times(SLOT_BITS));
        Self { mistake, exchanges: [0; 2], peers, turn: 0, asked: false, heard: Vec::new(), due }
    }

    fn has(&self, mistake: Mistake) -> bool {
        self.mistake == Some(mistake)
    }

    /// The cycle with this station is over.
    fn next(&mut self, now: Instant) {
        self.asked = false;
        self.heard.clear();
        self.turn = (self.turn + 1) % self.peers.len();
        self.due = if self.has(Mistake::NoPause) { now } else { now.saturating_add(BAUD.bit_times(33)) };
    }

    fn answered(&mut self, now: Instant, status: Option<ReplyStatus>, data: &[u8]) {
        let (not_ready, stays) = (self.has(Mistake::IgnoresNotReady), self.has(Mistake::NeverStartsAgain));
        let peer = &mut self.peers[self.turn];
        peer.retries = 0;
        peer.count = toggled(peer.count);
        let diagnosis = Diagnosis::parse(data);
        peer.step = match (peer.step, status) {
            (Step::Diagnosis, Some(ReplyStatus::DataLow)) => Step::Parameters,
            (Step::Parameters, None) => Step::Configuration,
            (Step::Configuration, None) if not_ready => Step::Exchange,
            (Step::Configuration, None) => Step::Ready,
            (Step::Ready, Some(ReplyStatus::DataLow)) => match diagnosis {
                Some(Diagnosis { prm_req: true, .. }) | None => Step::Parameters,
                Some(Diagnosis { station_not_ready: true, .. }) => Step::Ready,
                Some(_) => Step::Exchange,
            },
            (Step::Exchange, Some(ReplyStatus::DataLow | ReplyStatus::DataHigh)) => {
                self.exchanges[self.turn] += 1;
                Step::Exchange
            }
            (Step::Exchange, _) if not_ready || stays => Step::Exchange,
            (_, _) => Step::Diagnosis,
        };
        self.next(now);
    }

    fn missed(&mut self, now: Instant) {
        let toggles = self.has(Mistake::TogglesInRetry);
        let peer = &mut self.peers[self.turn];
        peer.retries += 1;
        if peer.retries > RETRIES {
            (peer.step, peer.count, peer.retries) = (Step::Diagnosis, FrameCount::First, 0);
            return self.next(now);
        }
        if toggles {
            peer.count = toggled(peer.count);
        }
        self.asked = false;
        self.heard.clear();
        self.due = now;
    }
}

fn toggled(count: FrameCount) -> FrameCount {
    match count {
        FrameCount::First | FrameCount::Odd | FrameCount::Unused => FrameCount::Even,
        FrameCount::Even => FrameCount::Odd,
    }
}

impl Master for Naive {
    fn handle_bytes(&mut self, now: Instant, octets: &[u8]) {
        if !self.asked {
            return;
        }
        self.heard.extend(octets);
        // The rest of the reply comes without a pause.
        self.due = now.saturating_add(BAUD.bit_times(11 * 8 + 33));
        let heard = std::mem::take(&mut self.heard);
        match decode(&heard) {
            Decoded::Telegram { telegram: Telegram::ShortAcknowledge, .. } => self.answered(now, None, &[]),
            Decoded::Telegram { telegram: Telegram::Data(data), .. }
                if data.sa.number() == self.peers[self.turn].address =>
            {
                let Function::Response(_, status) = data.fc.function() else { return };
                self.answered(now, Some(status), data.data);
            }
            Decoded::Invalid { error: FrameError::Checksum { .. }, .. }
                if self.has(Mistake::BelievesWrongFcs) =>
            {
                self.answered(now, Some(ReplyStatus::DataLow), &[]);
            }
            Decoded::Telegram { .. } | Decoded::Invalid { .. } | Decoded::Incomplete => self.heard = heard,
        }
    }

    fn handle_sent(&mut self, now: Instant) {
        self.due = now.saturating_add(BAUD.bit_times(SLOT_BITS + 1));
    }

    fn handle_timeout(&mut self, now: Instant) {
        if self.asked && now >= self.due {
            self.missed(now);
        }
    }

    fn poll_transmit(&mut self, now: Instant, buf: &mut [u8; MAX_TELEGRAM_LEN]) -> Option<usize> {
        if self.asked || now < self.due {
            return None;
        }
        let peer = &self.peers[self.turn];
        let [high, low] = peer.ident.to_be_bytes();
        let prm = [0x80, 1, 1, 11, high, low, 0];
        let outputs = [0; 14];
        let (dsap, data) = match peer.step {
            Step::Diagnosis | Step::Ready => (Sap::new(60), &[][..]),
            Step::Parameters => (Sap::new(61), &prm[..]),
            Step::Configuration => (Sap::new(62), peer.cfg),
            Step::Exchange => (None, &outputs[..peer.outputs]),
        };
        let ssap = dsap.and(Sap::new(62));
        let telegram = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, data),
            da: Address::from_octet(peer.address),
            sa: Address::from_octet(2),
            dsap,
            ssap,
            fc: FunctionCode::request(Service::SrdHigh, peer.count),
            data,
        };
        let len = telegram.encode(buf).ok()?.len();
        self.asked = true;
        // Until the end of the request is told.
        self.due = now.saturating_add(BAUD.bit_times(11 * 255));
        Some(len)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Some(self.due)
    }
}

/// What the document shows is in the test.
#[test]
fn the_document_shows_lines_of_the_test() {
    let (page, test) = (include_str!("../../../docs/test-your-master.md"), include_str!("../own_master.rs"));
    let block = page.split("## In Rust, in virtual time").nth(1).unwrap();
    let block = block.split("```rust\n").nth(1).unwrap().split("```").next().unwrap();
    let mut lines = test.lines().map(str::trim);
    for shown in block.lines().map(str::trim).filter(|line| !line.is_empty()) {
        assert!(lines.any(|line| line == shown), "'{shown}' is not in the test, or not in this order");
    }
}
