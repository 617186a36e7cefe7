//! What the rows of slaves are judged with: requests, and what is made of the answers.

use crate::map::Map;

use super::Setup;
use super::answer::{Answer, Diagnosis, is_sd3, misformed, short};
use super::notes::Notes;
use super::request::Request;
use super::wire::{Heard, Sight, Wire};
use crate::judge::device::attendant::Attended;
use crate::judge::device::course::{Course, Halt, broken};
use crate::judge::device::{Attendant, Ending};
use crate::judge::moment::{Moment, Side, Telegram, explained};
use crate::profibus::dp::DiagBit;
use crate::profibus::dp::{IoLengths, Service};
use crate::profibus::fdl;
use crate::profibus::fdl::station::DEFAULT_MIN_TSDR;
use crate::profibus::fdl::{Address, FrameCount, ReplyStatus};

mod acyclic;
mod hands;
mod ppo;
mod prm;
mod start;

pub(super) use acyclic::{CLASS_2_SAP, Channel, Granted, UNIT, abort, initiate, is_negative, service};
pub(super) use hands::{CLEAR, FREEZE_COMMAND, SYNC_COMMAND, UNFREEZE_COMMAND, UNSYNC_COMMAND};
pub(super) use ppo::pkw;
pub(super) use prm::{FREEZE, LOCK, Prm, SYNC, UNLOCK};

pub(super) use crate::profibus::dp::slave_diag::LEN as DIAG_LEN;

/// Telegrams that are shown of one row at most: the last ones.
const SHOWN: usize = 24;
/// An operating system may sleep now and then: so many late replies count where no times are seen.
const LATE_UNTIMED: u32 = 3;
/// Probes of a slave that no longer answers.
const PROBES: u32 = 3;

/// A slave under test, and a master beside it.
#[derive(Debug)]
pub struct Tester {
    pub(super) setup: Setup,
    pub(super) wire: Wire,
    attendant: Attended,
    counts: Map<u8, FrameCount>,
    pub(super) notes: Notes,
    /// What it is, by the file or by its own words.
    pub(super) ident: u16,
    pub(super) cfg: Vec<u8>,
    pub(super) lengths: IoLengths,
    /// The first diagnosis of all.
    pub(super) first: Option<Diagnosis>,
    /// The last reply, as octets.
    pub(super) last_reply: Vec<u8>,
    /// Who asked for it, and what.
    last_asked: Option<(u8, Option<u8>)>,
    /// min T_SDR as it was set last, in bit times.
    pub(super) min_tsdr: u16,
    /// What the outputs are while the inputs follow them.
    pub(super) frozen_outputs: Option<u8>,
    exchanged: bool,
    why_not: Option<String>,
}

impl Tester {
    pub(super) fn new(setup: Setup, wire: Wire, attendant: Option<Box<dyn Attendant>>) -> Self {
        Self {
            setup,
            wire,
            attendant: Attended(attendant),
            counts: Map::new(),
            notes: Notes::default(),
            ident: 0,
            cfg: Vec::new(),
            lengths: IoLengths::default(),
            first: None,
            last_reply: Vec::new(),
            last_asked: None,
            min_tsdr: 11,
            frozen_outputs: None,
            exchanged: false,
            why_not: None,
        }
    }

    /// The ident number by the address, as the words of telegrams need it.
    fn idents(&self) -> Map<u8, u16> {
        Map::from_iter([(self.slave(), self.ident)])
    }

    pub(super) const fn slave(&self) -> u8 {
        self.setup.address.number()
    }

    pub(super) const fn owner(&self) -> u8 {
        self.setup.owner.number()
    }

    pub(super) fn other(&self) -> u8 {
        self.setup.other()
    }

    /// Who is shown as the sender of a request.
    fn side(&self, sa: u8) -> Side {
        if sa == self.owner() { Side::Master } else { Side::Other(Address::from_octet(sa)) }
    }

    /// The frame count of the next request of this master.
    pub(super) fn next_count(&mut self, sa: u8) -> FrameCount {
        let next = match self.counts.get(&sa) {
            None => FrameCount::First,
            Some(FrameCount::First | FrameCount::Odd | FrameCount::Unused) => FrameCount::Even,
            Some(FrameCount::Even) => FrameCount::Odd,
        };
        self.counts.insert(sa, next);
        next
    }

    /// The next request of this master is a first one again.
    pub(super) fn forget_count(&mut self, sa: u8) {
        self.counts.remove(&sa);
    }

    /// The request of a service, with the next frame count.
    pub(super) fn request(&mut self, sa: u8, service: Service, data: &[u8]) -> Request {
        let count = self.next_count(sa);
        Request::of(self.slave(), sa, service, count, data)
    }

    /// Sends a request, and says what comes back, if anything does.
    pub(super) fn ask(&mut self, request: &Request) -> Course<Answer> {
        let heard = self.exchange_octets(request.sa, &request.octets())?;
        let Some(Heard { octets, after }) = heard else { return Ok(Answer::Silence) };
        self.notice(request, &octets, after);
        self.last_reply = octets.clone();
        Ok(Answer::of(&octets))
    }

    /// Sends octets as this master, and says what comes back within the time.
    pub(super) fn exchange_octets(&mut self, sa: u8, octets: &[u8]) -> Course<Option<Heard>> {
        let side = self.side(sa);
        self.wire.send(octets, side)?;
        let heard = self.wire.reply()?;
        self.notice_unasked();
        Ok(heard)
    }

    /// Sends octets that nobody may answer. `what` they are.
    pub(super) fn unanswered(&mut self, sa: u8, octets: &[u8], what: &str) -> Course {
        match self.intruder(sa, octets)? {
            None => Ok(()),
            Some(octets) => broken(format!("{what} is answered with {}", Answer::of(&octets).words())),
        }
    }

    /// Sends octets that nobody may answer, and says what comes back all the same.
    pub(super) fn intruder(&mut self, sa: u8, octets: &[u8]) -> Course<Option<Vec<u8>>> {
        let side = self.side(sa);
        self.wire.send(octets, side)?;
        let heard = self.wire.silence()?;
        self.notice_unasked();
        Ok(heard)
    }

    /// A request that must be answered.
    pub(super) fn must_answer(&mut self, request: &Request) -> Course<Answer> {
        let mut answer = self.ask(request)?;
        // An operating system loses time, and a slave then rightly says nothing: a master repeats its request.
        if answer == Answer::Silence && self.wire.sight != Sight::Exact {
            let telegrams = self.last_shown();
            let why = || (format!("{} is not answered at first", request.name()), telegrams);
            self.notes.breach("S-T03", why);
            answer = self.ask(request)?;
        }
        match answer {
            Answer::Silence => self.silent(request.name()),
            Answer::Wrong(why) => broken(format!("{} is answered with {why}", request.name())),
            answer @ (Answer::Acknowledged | Answer::Status(_) | Answer::Data(..)) => Ok(answer),
        }
    }

    /// It did not answer: whether it is still there.
    pub(super) fn silent<T>(&mut self, name: &str) -> Course<T> {
        let shown = self.shown();
        let probes = self.probes();
        for probe in (0..PROBES).flat_map(|_| &probes) {
            if self.exchange_octets(probe.sa, &probe.octets())?.is_some() {
                self.forget_count(self.owner());
                self.forget_count(self.other());
                return Err(Halt::Broken { why: format!("{name} is not answered"), shown: Some(shown) });
            }
        }
        Err(Halt::Over(Ending::Died { during: "" }))
    }

    /// A service of this master, answered.
    pub(super) fn serve(&mut self, sa: u8, service: Service, data: &[u8]) -> Course<Answer> {
        let request = self.request(sa, service, data);
        self.must_answer(&request)
    }

    /// A service of the owner that must be answered with SC, whatever comes of it.
    pub(super) fn acknowledged(&mut self, service: Service, data: &[u8]) -> Course {
        let answer = self.serve(self.owner(), service, data)?;
        if answer == Answer::Acknowledged || answer.is_status(ReplyStatus::Ok) {
            return Ok(());
        }
        broken(format!("{} is answered with {}, expected SC", service.name(), answer.words()))
    }

    /// The diagnosis, as this master reads it.
    pub(super) fn diag_of(&mut self, sa: u8) -> Course<Diagnosis> {
        let answer = self.serve(sa, Service::SlaveDiag, &[])?;
        if let Answer::Data(status, octets) = &answer
            && octets.len() >= DIAG_LEN
        {
            let diagnosis = Diagnosis(octets.clone());
            self.notice_diag(*status, &diagnosis);
            return Ok(diagnosis);
        }
        let answer = answer.words();
        broken(format!("Slave_Diag is answered with {answer}, expected DL with at least {DIAG_LEN} octets"))
    }

    /// The diagnosis, as the owner reads it.
    pub(super) fn diag(&mut self) -> Course<Diagnosis> {
        self.diag_of(self.owner())
    }

    /// Global_Control to everybody.
    pub(super) fn control(&mut self, command: u8, groups: u8) -> Course {
        let (owner, everybody) = (self.owner(), Address::BROADCAST.number());
        self.control_of(owner, everybody, &[command, groups])
    }

    /// Global_Control of this master to this address; nobody answers it.
    pub(super) fn control_of(&mut self, sa: u8, da: u8, data: &[u8]) -> Course {
        let mut request = Request::of(da, sa, Service::GlobalControl, FrameCount::Unused, data);
        request.service = fdl::Service::SdnHigh;
        let side = self.side(sa);
        self.wire.send(&request.octets(), side)?;
        self.notice_unasked();
        Ok(())
    }

    /// Asks who stands beside the slave for an action; the row cannot be judged without.
    pub(super) fn attend(&mut self, action: &str) -> Course<String> {
        self.attendant.act(action)
    }

    /// Whether somebody stands beside the slave.
    pub(super) const fn is_attended(&self) -> bool {
        self.attendant.0.is_some()
    }

    /// A row that was watched while others were judged.
    pub(super) fn watched(&mut self, id: &'static str, nothing: &str) -> Course {
        match self.notes.against(id, self.least(id)) {
            Some((why, shown)) => Err(Halt::Broken { why, shown: Some(shown) }),
            None if self.notes.occasions(id) == 0 => Err(Halt::Missed(nothing.into())),
            None => Ok(()),
        }
    }

    /// How often a row must be broken to count.
    pub(super) fn least(&self, id: &str) -> u32 {
        if id == "S-T03" && self.wire.sight == Sight::Untimed { LATE_UNTIMED } else { 1 }
    }

    /// What passed since it was taken.
    pub(super) fn shown(&mut self) -> Vec<Telegram> {
        let mut moments: Vec<Moment> = self.wire.take_passed();
        moments.drain(..moments.len().saturating_sub(SHOWN));
        explained(moments, &self.idents())
    }

    /// What the last few telegrams are, which stay.
    fn last_shown(&self) -> Vec<Telegram> {
        explained(self.wire.last_passed(4), &self.idents())
    }

    /// What the form and the time of a reply say.
    fn notice(&mut self, request: &Request, octets: &[u8], after: core::time::Duration) {
        let shown = |tester: &Self| tester.last_shown();
        self.notes.occasion("S-F14");
        self.notes.occasion("S-T02");
        // The reply to another request says that a retry was seen: rows of the frame count bit.
        let asked = (request.sa, request.dsap);
        let is_other = self.last_asked.replace(asked) != Some(asked);
        let is_old = is_other && self.last_reply == octets;
        if let Some(why) = misformed(request, octets).filter(|_| !is_old) {
            let telegrams = shown(self);
            self.notes.breach("S-F14", || (format!("the reply to {}: {why}", request.name()), telegrams));
        }
        if is_sd3(octets) {
            let telegrams = shown(self);
            self.notes.breach("S-F11", || ("a reply of eight octets is SD3".into(), telegrams));
        }
        let slot = self.wire.slot();
        let late = after > slot;
        // Later ones that Set_Prm asked for are judged by S-P07.
        let least = self.wire.baud.bit_times(DEFAULT_MIN_TSDR.into());
        let most = self.max_tsdr();
        let (row, is_broken) = match self.wire.sight {
            Sight::Untimed => ("S-T03", late),
            Sight::Measured | Sight::Exact if late => ("S-T02", true),
            Sight::Exact => ("S-T01", after < least || after > most),
            // What the operating system adds is in T_SL.
            Sight::Measured => ("S-T01", after < least),
        };
        self.notes.occasion(row);
        if is_broken {
            let telegrams = shown(self);
            let why = match row {
                "S-T01" => format!(
                    "the reply to {} begins {} us after it, expected {} to {} us",
                    request.name(),
                    after.as_micros(),
                    least.as_micros(),
                    most.as_micros()
                ),
                _ => format!(
                    "the reply to {} begins {} ms after it, and T_SL is {} ms",
                    request.name(),
                    after.as_millis(),
                    slot.as_millis()
                ),
            };
            self.notes.breach(row, || (why, telegrams));
        }
    }

    /// max T_SDR of the rate.
    pub(super) fn max_tsdr(&self) -> core::time::Duration {
        let baud = self.wire.baud;
        let of_file = self.setup.gsd.as_ref().and_then(|gsd| gsd.rates.max_tsdr(baud));
        // A slave that was given a later min T_SDR may take that long.
        let bits = of_file.unwrap_or(baud.max_tsdr_bits()).max(self.min_tsdr);
        baud.bit_times(bits.into())
    }

    /// What was sent although nobody had asked.
    fn notice_unasked(&mut self) {
        let unasked = self.wire.take_unasked();
        if unasked.is_empty() {
            return;
        }
        let telegrams = explained(unasked, &self.idents());
        let count = telegrams.len();
        self.notes.breach("S-T02", || {
            (format!("{count} sendings although nobody had asked, or after T_SL"), telegrams)
        });
    }

    /// What every diagnosis must be.
    fn notice_diag(&mut self, status: ReplyStatus, diagnosis: &Diagnosis) {
        const OF_MASTERS: [DiagBit; 4] = [
            DiagBit::StationNonExistent,
            DiagBit::InvalidSlaveResponse,
            DiagBit::MasterLock,
            DiagBit::Deactivated,
        ];
        for row in ["S-D07", "S-D08", "S-D09", "S-K03"] {
            self.notes.occasion(row);
        }
        let of_masters = OF_MASTERS.iter().find(|bit| diagnosis.is(**bit));
        let most = self.setup.gsd.as_ref().map(|gsd| usize::from(gsd.max_diag_len));
        let len = diagnosis.0.len();
        let breaches = [
            ("S-D07", wrong_block(diagnosis.0.get(DIAG_LEN..).unwrap_or_default())),
            ("S-D08", of_masters.map(|bit| format!("{} is set, which only a master sets", bit.name()))),
            ("S-D09", (!diagnosis.is(DiagBit::Always1)).then(|| "octet 2 bit 2 is 0".into())),
            (
                "S-K03",
                most.filter(|most| len > *most)
                    .map(|most| format!("a diagnosis has {len} octets, Max_Diag_Data_Len is {most}")),
            ),
            (
                "S-D02",
                (status != ReplyStatus::DataLow)
                    .then(|| format!("Slave_Diag is answered with {}, expected DL", short(status))),
            ),
        ];
        for (row, why) in breaches {
            if let Some(why) = why {
                let telegrams = self.last_shown();
                self.notes.breach(row, || (why, telegrams));
            }
        }
    }
}

/// What is wrong with the blocks of an extended diagnosis.
fn wrong_block(octets: &[u8]) -> Option<String> {
    let mut rest = octets;
    while let [header, ..] = rest {
        let len = match header >> 6 {
            0 | 1 => usize::from(header & 0x3F),
            2 => 3,
            _ => 1,
        };
        let at = octets.len() - rest.len() + DIAG_LEN + 1;
        if len == 0 || len > rest.len() {
            return Some(format!(
                "the block at octet {at} has the header {header:02X}, and {} octets follow",
                rest.len() - 1
            ));
        }
        rest = rest.get(len..).unwrap_or_default();
    }
    None
}
