//! A slave at a UART in virtual time, with one mistake: what it hears and what it says passes through the mistake.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use profidrive::gsd::{self, Gsd};
use profidrive::host::{Clock, Link, Received, Stop};
use profidrive::judge::device::Attendant;
use profidrive::judge::device::slave::{Live, Report, Row, Setup, Sight, live};
use profidrive::profibus::dp::ext_diag::Block;
use profidrive::profibus::dp::{Description, ExtDiag, Policy, State, Station};
use profidrive::profibus::dpv1::{AlarmType, Specifier, StatusType};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, DataTelegram, Function, Resync, Telegram};
use profidrive::time::{BaudRate, Instant};

use super::whole::{Whole, known, records};

const BAUD: BaudRate = BaudRate::K500;
pub(crate) const SLAVE: u8 = 5;

/// The device file of the slave, with more lines.
pub(crate) fn file(more: &str) -> Gsd {
    let text = format!(
        "#Profibus_DP\nGSD_Revision=1\nVendor_Name=\"x\"\nModel_Name=\"slave under test\"\nIdent_Number=0x1234\n\
         500_supp=1\nMaxTsdr_500=100\nMin_Slave_Intervall=10\nMax_Diag_Data_Len=20\n\
         User_Prm_Data_Len=2\nUser_Prm_Data=0x01,0x02\n{more}"
    );
    Gsd::read(text.as_bytes()).unwrap()
}

/// The lines of most: everything that DP-V0 offers, two words of inputs and outputs.
pub(crate) const FULL: &str = "Freeze_Mode_supp=1\nSync_Mode_supp=1\nSet_Slave_Add_supp=1\nFail_Safe=0\n\
     Module=\"2 words\" 0xF1\nEndModule\n";

/// What is wrong with a slave, and the line that is changed by it.
pub(crate) struct Mistake {
    pub(crate) name: &'static str,
    /// The rows that must be broken, and no other.
    pub(crate) rows: &'static [&'static str],
    /// The lines of the device file.
    pub(crate) file: &'static str,
    /// What the judge is told: the device file of another, say.
    pub(crate) told: Option<&'static str>,
    pub(crate) policy: fn(&mut Policy),
    pub(crate) description: fn(&mut Description),
    /// What it makes of octets before it hears them; nothing: it does not hear them.
    pub(crate) hears: fn(&mut Slave, Vec<u8>) -> Vec<u8>,
    /// What it does when it has heard them.
    pub(crate) does: fn(&mut Slave, &[u8]),
    /// What becomes of its reply; empty: it says nothing.
    pub(crate) says: fn(&mut Slave, Vec<u8>) -> Vec<u8>,
    /// How much later it says it.
    pub(crate) late: fn(&Slave) -> Duration,
    /// What an action at the device does beside what it should; `false`: it does nothing else.
    pub(crate) acts: fn(&mut Slave, &str) -> bool,
}

/// None.
pub(crate) const RIGHT: Mistake = Mistake {
    name: "nothing is wrong",
    rows: &[],
    file: FULL,
    told: None,
    policy: |_| (),
    description: |_| (),
    hears: |_, octets| octets,
    does: |_, _| (),
    says: |_, octets| octets,
    late: |_| Duration::ZERO,
    acts: |_, _| false,
};

/// The slave, and what it remembers of the line.
pub(crate) struct Slave {
    pub(crate) now: Instant,
    pub(crate) framed: Whole,
    mistake: &'static Mistake,
    /// The master's octets, and when the last of them ends.
    coming: Option<(Instant, Vec<u8>)>,
    /// Its own octets, and when the last of them ends.
    going: VecDeque<(Instant, Vec<u8>)>,
    /// What the master has heard.
    heard: VecDeque<u8>,
    /// The last request, as it was sent.
    pub(crate) request: Vec<u8>,
    /// The last reply.
    pub(crate) reply: Vec<u8>,
    /// What a master asked for last at a SAP of DP-V1.
    pub(crate) job: Vec<u8>,
    /// What a mistake counts or remembers.
    pub(crate) count: u32,
    pub(crate) memory: Vec<u8>,
    /// It is gone.
    pub(crate) dead: bool,
    /// Its address and its lock are kept.
    pub(crate) forgets: bool,
}

impl Slave {
    fn new(mistake: &'static Mistake) -> Self {
        Self {
            now: Instant::ZERO,
            framed: framed(mistake, SLAVE),
            mistake,
            coming: None,
            going: VecDeque::new(),
            heard: VecDeque::new(),
            request: Vec::new(),
            reply: Vec::new(),
            job: Vec::new(),
            count: 0,
            memory: Vec::new(),
            dead: false,
            forgets: false,
        }
    }

    pub(crate) fn station(&mut self) -> &mut Station<gsd::Station> {
        self.framed.station_mut()
    }

    pub(crate) fn state(&self) -> State {
        self.framed.station().slave().state()
    }

    pub(crate) fn address(&self) -> u8 {
        self.framed.station().address().number()
    }

    /// The service access point that a request is for.
    pub(crate) fn dsap(octets: &[u8]) -> Option<u8> {
        let asks = |data: &DataTelegram<'_>| matches!(data.fc.function(), Function::Request(..));
        parsed(octets).filter(asks).and_then(|data| data.dsap).map(|sap| sap.number())
    }

    /// Says something by itself, so much later.
    pub(crate) fn say(&mut self, after: Duration, octets: &[u8]) {
        let mut end = self.now + after;
        // The first octets of a long one are on the line well before the last ones.
        let part = if octets.len() > 60 { 8 } else { octets.len().max(1) };
        for part in octets.chunks(part) {
            end = end + BAUD.octet_times(part.len() as u32);
            self.going.push_back((end, part.to_vec()));
        }
    }

    /// Takes another telegram as if the master had sent it, and forgets its reply.
    pub(crate) fn takes(&mut self, octets: &[u8]) {
        let now = self.now;
        self.framed.handle_bytes(now, octets);
        self.swallow();
    }

    fn swallow(&mut self) {
        let mut buf = [0; 255];
        let due = self.framed.poll_timeout().unwrap_or(self.now);
        let _ = self.framed.poll_transmit(due, &mut buf);
    }

    fn hear(&mut self, octets: Vec<u8>) {
        self.request = octets.clone();
        let content = parsed(&octets).map_or(Vec::new(), |data| data.data.to_vec());
        if Self::dsap(&octets).is_some_and(|sap| sap <= 53) && !content.is_empty() {
            self.job = content;
        }
        let octets = (self.mistake.hears)(self, octets);
        if !octets.is_empty() && !self.dead {
            let now = self.now;
            self.framed.handle_bytes(now, &octets);
        }
        (self.mistake.does)(self, &octets);
        self.mirror();
    }

    /// Its inputs follow its outputs.
    fn mirror(&mut self) {
        let outputs = self.framed.station().slave().outputs().to_vec();
        self.station().set_inputs(&outputs);
    }

    fn speak(&mut self) {
        let mut buf = [0; 255];
        let now = self.now;
        let Some(reply) = self.framed.poll_transmit(now, &mut buf) else { return };
        let reply = reply.to_vec();
        let reply = (self.mistake.says)(self, reply);
        if reply.is_empty() || self.dead {
            return;
        }
        self.reply = reply.clone();
        let late = (self.mistake.late)(self);
        self.say(late, &reply);
    }

    /// The next thing that happens.
    fn next(&self) -> Option<Instant> {
        let coming = self.coming.as_ref().map(|(at, _)| *at);
        let going = self.going.iter().map(|(at, _)| *at).min();
        [coming, going, self.framed.poll_timeout()].into_iter().flatten().min()
    }

    /// Lets time pass until something is heard by the master, at most until `end`.
    fn pass(&mut self, end: Instant) {
        while self.heard.is_empty() {
            let Some(next) = self.next().filter(|next| *next <= end) else {
                self.now = self.now.max(end);
                return;
            };
            self.now = self.now.max(next);
            if let Some((at, octets)) = self.coming.take() {
                if at <= self.now {
                    self.hear(octets);
                } else {
                    self.coming = Some((at, octets));
                }
            }
            if self.framed.poll_timeout().is_some_and(|due| due <= self.now) {
                self.speak();
                let now = self.now;
                self.framed.handle_timeout(now);
                self.mirror();
            }
            while let Some(at) = self.going.iter().position(|(at, _)| *at <= self.now) {
                let (_, octets) = self.going.remove(at).unwrap();
                self.heard.extend(octets);
            }
        }
    }

    fn act(&mut self, action: &str) -> Option<String> {
        let (verb, rest) = action.split_once(' ').unwrap_or((action, ""));
        if (self.mistake.acts)(self, action) {
            return Some(String::new());
        }
        match verb {
            "power-cycle" => {
                let address = if self.forgets { SLAVE } else { self.address() };
                self.framed = framed(self.mistake, address);
            }
            "new-device" => self.framed = framed(self.mistake, SLAVE),
            "set-address" => self.framed = framed(self.mistake, rest.parse().unwrap()),
            "set-input" => {
                let inputs = octets(rest);
                self.station().set_inputs(&inputs);
            }
            "read-output" => {
                let outputs = self.framed.station().slave().outputs().to_vec();
                return Some(outputs.iter().map(|octet| format!("{octet:02X}")).collect());
            }
            "set-diag" if rest == "none" => self.framed.file_diagnosis(&ExtDiag::NONE),
            "set-diag" => {
                let mut diagnosis = ExtDiag::fault();
                let data = octets(rest);
                diagnosis.push(Block::Device(&data[1..])).unwrap();
                self.framed.file_diagnosis(&diagnosis);
            }
            "raise-alarm" | "send-status" | "set-record" => {
                return self.act_acyclic(verb, &rest.split(' ').collect::<Vec<_>>()).then(String::new);
            }
            _ => return None,
        }
        Some(String::new())
    }

    /// Actions of DP-V1: whether it is done.
    fn act_acyclic(&mut self, verb: &str, words: &[&str]) -> bool {
        let number = |place: usize| words[place].parse::<u8>().unwrap();
        let hex = |place: usize| words.get(place).map_or(Vec::new(), |hex| octets(hex));
        let Whole { station, acyclic, records, .. } = &mut self.framed;
        match verb {
            "raise-alarm" => {
                let kind = AlarmType::named(words[0]).unwrap();
                let what = (number(1), Specifier::named(words[2]).unwrap(), words[3] == "1");
                acyclic.raise(station, kind, what, &hex(4)).is_ok()
            }
            "send-status" => {
                let kind = StatusType::numbered(number(0));
                let specifier = Specifier::named(words[2]).unwrap();
                acyclic.send_status(station, kind, number(1), specifier, &hex(3)).is_ok()
            }
            _ => {
                records.records.get_mut(&(number(0), number(1))).unwrap().data = hex(2);
                true
            }
        }
    }
}

fn octets(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|at| u8::from_str_radix(&hex[2 * at..2 * at + 2], 16).unwrap()).collect()
}

/// The fields of a telegram.
pub(crate) fn parsed(octets: &[u8]) -> Option<DataTelegram<'_>> {
    match decode(octets) {
        Decoded::Telegram { telegram: Telegram::Data(data), .. } => Some(data),
        _ => None,
    }
}

/// The same telegram with other fields.
pub(crate) fn changed(octets: &[u8], change: impl FnOnce(&mut DataTelegram<'_>, &mut Vec<u8>)) -> Vec<u8> {
    let Some(mut data) = parsed(octets) else { return octets.to_vec() };
    let mut content = data.data.to_vec();
    change(&mut data, &mut content);
    let format = DataTelegram::customary_format(data.dsap, data.ssap, &content);
    let telegram = DataTelegram { data: &content, format, ..data };
    let mut buf = [0; 255];
    telegram.encode(&mut buf).unwrap().to_vec()
}

fn framed(mistake: &Mistake, address: u8) -> Whole {
    let gsd = file(mistake.file);
    let application = gsd::Station::new(gsd.clone(), gsd::Policy::PROPOSED).unwrap();
    let mut description = application.description();
    (mistake.description)(&mut description);
    let mut policy = Policy::default();
    (mistake.policy)(&mut policy);
    let address = Address::station(address).unwrap();
    let station = Station::new(address, BAUD, None, description, application).with_policy(policy);
    Whole::new(Resync::Idle(BAUD), station, &gsd, records())
}

/// The line to it, and its time.
#[derive(Clone)]
pub(crate) struct Rig(Rc<RefCell<Slave>>);

impl Clock for Rig {
    fn now(&self) -> Instant {
        self.0.borrow().now
    }
}

impl Link for Rig {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        let mut slave = self.0.borrow_mut();
        let count = buf.len().min(slave.heard.len());
        for (to, octet) in buf.iter_mut().zip(slave.heard.drain(..count)) {
            *to = octet;
        }
        Ok(if count == 0 { Received::Nothing } else { Received::Octets(count) })
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        let mut slave = self.0.borrow_mut();
        let end = slave.now + BAUD.octet_times(telegram.len() as u32);
        // Two requests at once are one sending.
        let mut octets = slave.coming.take().map(|(_, octets)| octets).unwrap_or_default();
        octets.extend(telegram);
        slave.coming = Some((end, octets));
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>, _: &Stop) -> io::Result<()> {
        let mut slave = self.0.borrow_mut();
        let end = slave.now + timeout.unwrap_or(Duration::from_secs(1));
        slave.pass(end);
        Ok(())
    }
}

impl Attendant for Rig {
    fn act(&mut self, action: &str) -> Option<String> {
        self.0.borrow_mut().act(action)
    }
}

impl Rig {
    pub(crate) fn new(mistake: &'static Mistake) -> Self {
        Self(Rc::new(RefCell::new(Slave::new(mistake))))
    }

    /// A line with the times of this one.
    pub(crate) fn line(&self, link: impl Link + 'static, stop: Stop) -> Live {
        Live { link: Box::new(link), clock: Box::new(self.clone()), sight: Sight::Exact, rate: BAUD, stop }
    }
}

/// What the judge is told of it. Everything may be done to it.
pub(crate) fn setup(mistake: &Mistake) -> Setup {
    Setup {
        gsd: Some(Box::new(file(mistake.told.unwrap_or(mistake.file)))),
        mirror: true,
        moves_allowed: true,
        writes_allowed: true,
        records: Some(Box::new(known())),
        limit: Some(Duration::from_secs(3600)),
        ..Setup::new(Address::station(SLAVE).unwrap())
    }
}

/// Judges a slave with a mistake by these rows.
pub(crate) fn judged(mistake: &'static Mistake, wanted: &[Row]) -> Report {
    let rig = Rig::new(mistake);
    let line = rig.line(rig.clone(), Stop::new().unwrap());
    live(setup(mistake), wanted, line, Some(Box::new(rig)), &mut |_| ())
}
