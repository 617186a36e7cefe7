//! The master's side, whatever a drive answers: a goal and a job end once, a deadline that was served is not due again, and
//! no more is sent than was asked for.
//!
//! ```text
//! which client (1): 0 of the AG03, 1 to 5 of this PPO, 6 of a node
//! then 00..=1f  a goal: which (1), value (4)
//!      20..=3f  a job of the parameter channel, or an entry to read or to write: number (2), index (1), value (4)
//!      40..=7f  an image or a frame: octets, as many as it has
//!      80..=9f  the image or the answer that would please it, with one octet changed: which (1), how (1)
//!      a0..=bf  time passes: milliseconds (2)
//!      c0..     Data_Exchange is lost, or a diagnosis: length (1), octets
//! ```

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::{Address, NodeId};
use profidrive::client::{
    Ag03Channel, DriveClient, Goal, Job, Limits, NodeClient, NodeGoal, NodeLimits, PpoClient, PpoGoal,
    PpoLimits, Profile,
};
use profidrive::devices::ag03::drive::Direction;
use profidrive::devices::ag03::param::{Pnu, Subindex, Value};
use profidrive::profibus::ppo::{Inputs, PPO_LEN, PpoType};
use profidrive::time::Instant;

const PPOS: [PpoType; 5] = [PpoType::Ppo1, PpoType::Ppo2, PpoType::Ppo3, PpoType::Ppo4, PpoType::Ppo5];
const NODE: u8 = 5;

pub(crate) fn check(data: &[u8]) {
    let Some((&which, steps)) = data.split_first() else { return };
    let end: Box<dyn End> = match which {
        0 => Box::new(DriveClient::new(Ag03Channel::DEFAULT, Limits::default())),
        6 => Box::new(NodeClient::new(NodeId::new(NODE).expect("1 to 127"), NodeLimits::default())),
        _ => {
            let kind = PPOS[usize::from(which) % PPOS.len()];
            let limits = PpoLimits::default();
            Box::new((PpoClient::new(kind, Profile::PROFIDRIVE, limits), kind))
        }
    };
    Rig { end, now: Instant::ZERO, asked: 0, over: 0 }.play(steps);
}

/// A client, with what differs from one to the other.
trait End {
    fn pursue(&mut self, now: Instant, which: u8, value: i32);
    /// Whether it took it.
    fn submit(&mut self, now: Instant, number: u16, index: u8, write: Option<u32>) -> bool;
    /// How many octets an image has.
    fn octets(&self) -> usize;
    fn handle(&mut self, now: Instant, octets: &[u8]);
    /// What a drive that does as it is told would show.
    fn pleasing(&mut self) -> Vec<u8>;
    fn handle_timeout(&mut self, now: Instant);
    fn lost(&mut self, diagnosis: &[u8]);
    fn poll_timeout(&self) -> Option<Instant>;
    /// How many goals and jobs are over.
    fn over(&mut self) -> usize;
}

struct Rig {
    end: Box<dyn End>,
    now: Instant,
    asked: usize,
    over: usize,
}

impl Rig {
    fn play(mut self, mut steps: &[u8]) {
        for _ in 0..500 {
            let Some(rest) = self.step(steps) else { break };
            steps = rest;
            self.over += self.end.over();
            assert!(self.over <= self.asked, "{} of {} are over", self.over, self.asked);
        }
    }

    fn step<'a>(&mut self, steps: &'a [u8]) -> Option<&'a [u8]> {
        let (&kind, rest) = steps.split_first()?;
        match kind {
            0x00..=0x1F => {
                let ([which, value @ ..], rest) = rest.split_first_chunk::<5>()?;
                self.end.pursue(self.now, *which, i32::from_be_bytes(*value));
                self.asked += 1;
                Some(rest)
            }
            0x20..=0x3F => {
                let ([high, low, index, value @ ..], rest) = rest.split_first_chunk::<7>()?;
                let number = u16::from_be_bytes([*high, *low]);
                let write = (kind & 1 == 1).then_some(u32::from_be_bytes(*value));
                self.asked += usize::from(self.end.submit(self.now, number, *index, write));
                Some(rest)
            }
            0x40..=0x7F => {
                let (octets, rest) = rest.split_at_checked(self.end.octets())?;
                self.end.handle(self.now, octets);
                Some(rest)
            }
            0x80..=0x9F => {
                let ([which, how], rest) = rest.split_first_chunk()?;
                let mut octets = self.end.pleasing();
                let len = octets.len().max(1);
                if let Some(octet) = octets.get_mut(usize::from(*which) % len) {
                    *octet ^= how;
                }
                self.end.handle(self.now, &octets);
                Some(rest)
            }
            0xA0..=0xBF => {
                let ([high, low], rest) = rest.split_first_chunk()?;
                let end =
                    self.now.saturating_add(Duration::from_millis(u16::from_be_bytes([*high, *low]).into()));
                for _ in 0..100 {
                    let Some(due) = self.end.poll_timeout().filter(|due| *due <= end) else { break };
                    self.now = self.now.max(due);
                    self.end.handle_timeout(self.now);
                    self.over += self.end.over();
                    let next = self.end.poll_timeout();
                    assert!(next.is_none_or(|next| next > self.now), "{next:?} at {:?}", self.now);
                }
                self.now = end;
                Some(rest)
            }
            0xC0.. => {
                let (&len, rest) = rest.split_first()?;
                let (octets, rest) = rest.split_at_checked(usize::from(len % 32))?;
                self.end.lost(octets);
                Some(rest)
            }
        }
    }
}

fn job(number: u16, index: u8, write: Option<u32>) -> Job {
    let (pnu, element) = (Pnu::from_low_bits(number), Subindex(index));
    match write {
        None if index == 0 => Job::read(pnu),
        None => Job::read_element(pnu, element),
        Some(value) if index == 0 => Job::write(pnu, Value::Double(value)),
        Some(value) => Job::write_element(pnu, element, Value::Word((value & 0xFFFF) as u16)),
    }
}

impl End for DriveClient {
    fn pursue(&mut self, now: Instant, which: u8, value: i32) {
        let goals = [
            Goal::Enable,
            Goal::Acknowledge,
            Goal::MoveTo(value),
            Goal::Pause,
            Goal::Resume,
            Goal::Stop,
            Goal::Inch,
            Goal::Jog(Direction::Positive),
            Goal::Jog(Direction::Negative),
            Goal::Velocity(value),
            Goal::Disable,
        ];
        self.pursue(now, goals[usize::from(which) % goals.len()]);
    }

    fn submit(&mut self, now: Instant, number: u16, index: u8, write: Option<u32>) -> bool {
        self.submit(now, job(number, index, write)).is_ok()
    }

    fn octets(&self) -> usize {
        PPO_LEN
    }

    fn handle(&mut self, now: Instant, octets: &[u8]) {
        if let Ok(inputs) = Inputs::parse(octets) {
            self.handle_inputs(now, inputs);
        }
    }

    /// The job is answered with its own number, and the status word is that of a drive in operation.
    fn pleasing(&mut self) -> Vec<u8> {
        let mut image = self.outputs();
        let reply = image[0] >> 4;
        image[0] = image[0] & 0x0F | if reply == 0 { 0 } else { 0x10 };
        image[8..10].copy_from_slice(&0x2B37_u16.to_be_bytes());
        image.to_vec()
    }

    fn handle_timeout(&mut self, now: Instant) {
        self.handle_timeout(now);
    }

    fn lost(&mut self, diagnosis: &[u8]) {
        if diagnosis.is_empty() {
            self.handle_data_exchange_lost();
        } else {
            self.handle_diagnosis(diagnosis);
        }
    }

    fn poll_timeout(&self) -> Option<Instant> {
        self.poll_timeout()
    }

    fn over(&mut self) -> usize {
        usize::from(self.poll_outcome().is_some()) + usize::from(self.poll_job().is_some())
    }
}

impl End for (PpoClient, PpoType) {
    fn pursue(&mut self, now: Instant, which: u8, value: i32) {
        let setpoint = (value & 0x7FFF) as i16;
        let goals = [PpoGoal::Enable, PpoGoal::Run(setpoint), PpoGoal::Disable, PpoGoal::Acknowledge];
        self.0.pursue(now, goals[usize::from(which) % goals.len()]);
    }

    fn submit(&mut self, now: Instant, number: u16, index: u8, write: Option<u32>) -> bool {
        self.0.submit(now, job(number, index, write)).is_ok()
    }

    fn octets(&self) -> usize {
        self.1.len()
    }

    fn handle(&mut self, now: Instant, octets: &[u8]) {
        let taken = self.0.handle_inputs(now, octets);
        assert_eq!(taken, octets.len() == self.1.len());
    }

    fn pleasing(&mut self) -> Vec<u8> {
        let mut buf = [0; PpoClient::MOST];
        let mut image = self.0.outputs(&mut buf).to_vec();
        assert_eq!(image.len(), self.1.len());
        let words = if self.1.has_pkw() { 8 } else { 0 };
        if self.1.has_pkw() {
            image[0] = image[0] & 0x0F | if image[0] >> 4 == 0 { 0 } else { 0x10 };
        }
        image[words..words + 2].copy_from_slice(&0x0337_u16.to_be_bytes());
        image
    }

    fn handle_timeout(&mut self, now: Instant) {
        self.0.handle_timeout(now);
    }

    fn lost(&mut self, _: &[u8]) {}

    fn poll_timeout(&self) -> Option<Instant> {
        self.0.poll_timeout()
    }

    fn over(&mut self) -> usize {
        usize::from(self.0.poll_outcome().is_some()) + usize::from(self.0.poll_job().is_some())
    }
}

impl End for NodeClient {
    fn pursue(&mut self, now: Instant, which: u8, value: i32) {
        let goals =
            [NodeGoal::MoveTo(value), NodeGoal::Home, NodeGoal::Acknowledge, NodeGoal::Stop, NodeGoal::Leave];
        self.pursue(now, goals[usize::from(which) % goals.len()]);
    }

    fn submit(&mut self, now: Instant, number: u16, index: u8, write: Option<u32>) -> bool {
        let at = Address::new(number, index);
        match write {
            None => self.read(now, at),
            Some(value) => self.write(now, at, &value.to_le_bytes()[..usize::from(index % 5)]),
        }
        true
    }

    fn octets(&self) -> usize {
        10
    }

    fn handle(&mut self, now: Instant, octets: &[u8]) {
        let Some(([high, low], data)) = octets.split_first_chunk() else { return };
        let Ok(id) = Id::base(u16::from_be_bytes([*high, *low]) & 0x7FF) else { return };
        if let Ok(frame) = Frame::data(id, data) {
            self.handle_frame(now, &frame);
        }
    }

    /// An answer of SDO about what was asked: a value of 4 octets, or that it was written.
    fn pleasing(&mut self) -> Vec<u8> {
        let mut last = None;
        while let Some(frame) = self.poll_transmit() {
            assert!(!frame.is_remote() || frame.id().number() > 0x700, "{frame}");
            last = Some(frame);
        }
        let request = last.as_ref().map_or(&[][..], Frame::octets);
        let [command, a, b, sub, ..] = request else { return vec![0x07, 0x05, 0x05] };
        let answer = if command >> 5 == 2 { 0x43 } else { 0x60 };
        vec![0x05, 0x85, answer, *a, *b, *sub, 0x37, 0x06, 0, 0]
    }

    fn handle_timeout(&mut self, now: Instant) {
        self.handle_timeout(now);
    }

    fn lost(&mut self, _: &[u8]) {}

    fn poll_timeout(&self) -> Option<Instant> {
        self.poll_timeout()
    }

    fn over(&mut self) -> usize {
        while self.poll_transmit().is_some() {}
        usize::from(self.poll_outcome().is_some())
    }
}
