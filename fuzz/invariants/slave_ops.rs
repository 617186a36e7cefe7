//! Bus operations and time against a whole device: replies only to valid requests for us, mirrored, within the time
//! allowed, one a request; a repeated request gets the same octets again; the slave moves from state to state only as
//! it may; words only as documented; a deadline in the future after every drain; whatever happened, a drive that is
//! on answers the next request.

use std::time::Duration;

use arbitrary::{Arbitrary, Unstructured};
use profidrive::devices::ag03::drive::{Fault, Inputs};
use profidrive::devices::ag03::param::{Gear, Model};
use profidrive::devices::ag03::profibus::{
    ApplicationCycle, Config, DESCRIPTION, Device, Eeprom, MAX_EVENTS, MAX_TELEGRAM_LEN, NotStored, Power,
    Timing,
};
use profidrive::profibus::dp::State;
use profidrive::profibus::fdl::telegram::{Decoded, Format, decode};
use profidrive::profibus::fdl::{Address, DataTelegram, Function, FunctionCode, Sap, Telegram};
use profidrive::time::{BaudRate, Instant};

use super::Octets;

const OWN: u8 = 5;
const SET_PRM: u8 = 61;
const CHK_CFG: u8 = 62;
/// One event says that more were lost.
const MOST_EVENTS: usize = MAX_EVENTS + 1;

#[derive(Arbitrary, Debug)]
struct Session<'a> {
    rate: u8,
    kind: Kind,
    operations: Vec<Operation<'a>>,
}

#[derive(Arbitrary, Clone, Copy, Debug)]
struct Kind {
    every_exchange: bool,
    untrue: bool,
    ag03: bool,
    ratio_24: bool,
    host_keeps_eeprom: bool,
}

#[derive(Arbitrary, Debug)]
enum Operation<'a> {
    /// Any octets.
    Octets(Octets<'a>),
    /// A telegram in order, with any fields.
    Telegram { to_us: bool, da: u8, sa: u8, dsap: Option<u8>, ssap: Option<u8>, fc: u8, data: Octets<'a> },
    /// A master that means it: the services of the start-up and Data_Exchange.
    Service { sa: u8, service: Service, repeat: bool },
    /// The octets sent last once more.
    Again,
    /// Time.
    Wait { micros: u16 },
    /// Much time.
    Sleep { centiseconds: u8 },
    /// Something happens to the drive.
    World { output_stage: bool, fault: Option<u8>, key: bool },
    /// The control supply goes or comes.
    Power { on: bool },
    /// The host has kept the newest image of the EEPROM, or could not.
    Kept { ok: bool },
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Service {
    SetPrm { status: u8, factors: [u8; 2], min_tsdr: u8, group: u8 },
    ChkCfg,
    SlaveDiag,
    GetCfg,
    RdInp,
    RdOutp,
    GlobalControl { command: u8, groups: u8 },
    DataExchange { pkw: [u8; 8], stw: u16, hsw: i32 },
}

pub(crate) fn check(data: &[u8]) {
    let Ok(session) = Session::arbitrary_take_rest(Unstructured::new(data)) else { return };
    let rates = DESCRIPTION.rates;
    let rate = rates.iter().nth(usize::from(session.rate) % rates.iter().count()).expect("below the count");
    let kind = session.kind;
    let config = Config {
        baud: rate,
        timing: if kind.untrue { Timing::Untrue } else { Timing::True },
        application_cycle: if kind.every_exchange {
            ApplicationCycle::EACH_EXCHANGE
        } else {
            ApplicationCycle::DEFAULT
        },
        model: if kind.ag03 { Model::Ag03 } else { Model::Ag03_1 },
        gear: if kind.ratio_24 { Gear::Ratio24 } else { Gear::Ratio48 },
        eeprom: if kind.host_keeps_eeprom { Eeprom::Host } else { Eeprom::Internal },
        ..Config::new(Address::station(OWN).expect("below 127"))
    };
    let mut bus = Bus::new(config);
    for operation in session.operations.iter().take(100) {
        let before = bus.device.dp_state();
        let said = bus.carry_out(operation);
        bus.check_move(before, &said);
        bus.check_state();
    }
    bus.check_answers();
}

struct Bus {
    device: Device,
    now: Instant,
    rate: BaudRate,
    timing: Timing,
    frame_count: bool,
    /// A master may have set a min T_SDR beyond max T_SDR, and a reply comes when that is over.
    patient: bool,
    /// Something else than whole telegrams was said. Where idle time cannot be seen, a scan may find a telegram in it
    /// much later, and the reply to that belongs to no saying.
    noise: bool,
    /// What was said of late, for a device that cannot see where one saying ends.
    line: Vec<u8>,
    /// What was said last, and the reply if it was one telegram and got one.
    last: Vec<u8>,
    last_reply: Option<Vec<u8>>,
}

impl Bus {
    fn new(config: Config) -> Self {
        Self {
            device: Device::new(config, Instant::ZERO),
            now: Instant::ZERO,
            rate: config.baud,
            timing: config.timing,
            frame_count: false,
            patient: false,
            noise: false,
            line: Vec::new(),
            last: Vec::new(),
            last_reply: None,
        }
    }

    /// Returns the octets it has sent.
    fn carry_out(&mut self, operation: &Operation<'_>) -> Vec<u8> {
        match operation {
            Operation::Octets(Octets(octets)) => self.say(octets.to_vec()),
            Operation::Telegram { to_us, da, sa, dsap, ssap, fc, data: Octets(data) } => {
                let da = if *to_us { OWN } else { *da };
                self.say(telegram(da, *sa, *dsap, *ssap, *fc, data))
            }
            Operation::Service { sa, service, repeat } => {
                self.frame_count ^= !repeat;
                self.say(service.telegram(*sa, if self.frame_count { 0x7D } else { 0x5D }))
            }
            Operation::Again => self.repeat(),
            Operation::Wait { micros } => self.wait(Duration::from_micros((*micros).into())),
            Operation::Sleep { centiseconds } => {
                self.wait(Duration::from_millis(10 * u64::from(*centiseconds)))
            }
            Operation::World { output_stage, fault, key } => {
                let inputs = Inputs {
                    key_clockwise: *key,
                    control_supply: self.device.inputs().control_supply,
                    ..Inputs::default().with_output_stage(*output_stage)
                };
                let fault = fault.and_then(|fault| Fault::ALL.get(usize::from(fault)).copied());
                self.device.set_inputs(self.now, fault.map_or(inputs, |fault| inputs.provoking(fault)));
                self.nothing_said()
            }
            Operation::Power { on: true } => {
                self.device.power_on(self.now);
                self.nothing_said()
            }
            Operation::Power { on: false } => {
                self.device.power_off(self.now);
                assert_eq!(self.device.dp_state(), State::WaitPrm);
                self.nothing_said()
            }
            Operation::Kept { ok } => {
                if let Some(request) = self.device.poll_image() {
                    assert_eq!(self.device.poll_image(), None, "offered twice");
                    let outcome = if *ok { Ok(()) } else { Err(NotStored) };
                    self.device.handle_stored(self.now, request.generation, outcome);
                }
                self.nothing_said()
            }
        }
    }

    fn nothing_said(&mut self) -> Vec<u8> {
        self.last_reply = None;
        self.drain_silently();
        Vec::new()
    }

    fn wait(&mut self, time: Duration) -> Vec<u8> {
        self.now = self.now.saturating_add(time);
        self.device.handle_timeout(self.now);
        self.nothing_said()
    }

    fn say(&mut self, octets: Vec<u8>) -> Vec<u8> {
        let reply = self.send(&octets);
        let one = matches!(decode(&octets), Decoded::Telegram { len, .. } if len == octets.len());
        self.last_reply = reply.filter(|_| one);
        self.last.clone_from(&octets);
        octets
    }

    /// A master that has not heard the reply asks again: the same reply, and nothing else happens.
    fn repeat(&mut self) -> Vec<u8> {
        let Some(expected) = self.last_reply.clone() else { return self.nothing_said() };
        let counted = matches!(decode(&self.last), Decoded::Telegram { telegram: Telegram::Data(data), .. }
            if data.fc.octet() & 0x10 != 0 && matches!(data.fc.octet() & 0x0F, 0xC | 0xD));
        let (octets, state) = (self.last.clone(), self.device.dp_state());
        let reply = self.send(&octets);
        if counted && self.timing == Timing::True {
            assert_eq!(reply.as_deref(), Some(expected.as_slice()), "another reply to a repeated request");
            assert!(self.device.dp_state() == state || self.device.dp_state() == State::WaitPrm);
        }
        self.last_reply = reply;
        octets
    }

    /// Sends octets after T_SYN and returns what comes back.
    fn send(&mut self, octets: &[u8]) -> Option<Vec<u8>> {
        self.now = self.now.saturating_add(self.rate.bit_times(33));
        self.now =
            self.now.saturating_add(self.rate.octet_times(u32::try_from(octets.len()).expect("few octets")));
        self.device.handle_timeout(self.now);
        self.drain_silently();
        let end = self.now;
        self.device.handle_bytes(end, octets);
        let begin = self.line.len().saturating_sub(2 * MAX_TELEGRAM_LEN);
        self.line.drain(..begin);
        self.line.extend_from_slice(octets);
        self.patient |= holds(octets, SET_PRM);
        self.noise |= !behind_telegrams(octets).is_empty();
        let beyond = if self.patient { u32::from(u8::MAX) } else { 0 };
        let latest = end.saturating_add(self.rate.bit_times(beyond.max(self.rate.max_tsdr_bits().into())));
        let mut heard = None;
        loop {
            let mut buf = [0; MAX_TELEGRAM_LEN];
            if let Some(reply) = self.device.poll_transmit(self.now, &mut buf) {
                assert_eq!(heard, None, "a second reply");
                let scanned = self.noise && self.timing == Timing::Untrue;
                let earliest = end.saturating_add(self.rate.bit_times(11));
                assert!(scanned || self.now >= earliest, "before min T_SDR");
                assert!(self.now <= latest, "after max T_SDR");
                assert_eq!(self.device.power(), Power::On);
                let asked = |da| match self.timing {
                    Timing::True => last_request(octets) == Some(da),
                    Timing::Untrue => requests_anywhere(&self.line).any(|sa| sa == da),
                };
                check_reply(reply, asked);
                heard = Some(reply.to_vec());
            }
            self.drain_events();
            let Some(due) = self.device.poll_timeout().filter(|due| *due <= latest) else { break };
            assert!(due > self.now, "a deadline that has passed, after a drain");
            self.now = due;
            self.device.handle_timeout(due);
        }
        self.now = latest;
        heard
    }

    /// Nobody has asked anything, so nothing is said, but to a telegram that a scan finds among octets whose rest did
    /// not come.
    fn drain_silently(&mut self) {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        if let Some(reply) = self.device.poll_transmit(self.now, &mut buf) {
            assert_eq!(self.timing, Timing::Untrue, "a reply nobody waits for");
            check_reply(reply, |da| requests_anywhere(&self.line).any(|sa| sa == da));
        }
        self.drain_events();
    }

    fn drain_events(&mut self) {
        let mut events = 0;
        while let Some(event) = self.device.poll_event() {
            events += 1;
            assert!(events <= MOST_EVENTS);
            assert_ne!(event.to_string(), "");
        }
    }

    /// The slave machine moves only where a service in what was said, or the watchdog, may take it.
    fn check_move(&self, before: State, said: &[u8]) {
        let after = self.device.dp_state();
        let said = match self.timing {
            Timing::True => said,
            Timing::Untrue => &self.line,
        };
        let (may_own, may_enter) = (holds(said, SET_PRM), holds(said, CHK_CFG));
        match (before, after) {
            (State::WaitPrm, State::WaitCfg) => assert!(may_own, "owned without Set_Prm"),
            (State::WaitPrm, State::DataExch) => {
                assert!(may_own && may_enter, "Data_Exchange without parameters");
            }
            (State::WaitCfg, State::DataExch) => assert!(may_enter, "Data_Exchange without Chk_Cfg"),
            (State::DataExch, State::WaitCfg) => assert!(may_own, "back to WAIT-CFG without Set_Prm"),
            (State::WaitPrm | State::WaitCfg | State::DataExch, State::WaitPrm)
            | (State::WaitCfg, State::WaitCfg)
            | (State::DataExch, State::DataExch) => {}
        }
    }

    fn check_state(&self) {
        assert!(self.device.poll_timeout().is_none_or(|due| due > self.now));
        let status = self.device.status();
        let zsw = self.device.zsw().raw();
        // ZSW.5, 9 and 11 are fixed; operation is never enabled in fault or turn-on disabled.
        assert_eq!(zsw & 0x0A20, 0x0A20);
        assert!(zsw & 0x0004 == 0 || zsw & 0x0048 == 0, "{zsw:04X}");
        assert_eq!(self.device.system_status() & 0x0007, 0);
        assert!(!status.operation_enabled || status.supply_ok, "operation enabled without supply");
        assert!(!status.job_active || status.operation_enabled || status.fault.is_none());
        assert_eq!(status.fault.is_some(), zsw & 0x0008 != 0);
        if self.device.power() == Power::Off {
            assert!(!status.operation_enabled && self.device.dp_state() == State::WaitPrm);
        }
    }

    /// Recovery at the first valid request, whatever came before.
    fn check_answers(&mut self) {
        self.wait(Duration::from_millis(100));
        let reply = self.send(&telegram(OWN, 2, None, None, 0x49, &[]));
        let expected = telegram(2, OWN, None, None, 0x00, &[]);
        assert_eq!(reply, (self.device.power() == Power::On).then_some(expected));
    }
}

impl Service {
    fn telegram(self, sa: u8, fc: u8) -> Vec<u8> {
        let (da, fc, sap, data) = match self {
            Self::SetPrm { status, factors, min_tsdr, group } => {
                (OWN, fc, Some(61), vec![status, factors[0], factors[1], min_tsdr, 0x0A, 0xC5, group])
            }
            Self::ChkCfg => (OWN, fc, Some(62), vec![0xF3, 0xF2]),
            Self::SlaveDiag => (OWN, fc, Some(60), vec![]),
            Self::GetCfg => (OWN, fc, Some(59), vec![]),
            Self::RdInp => (OWN, fc, Some(56), vec![]),
            Self::RdOutp => (OWN, fc, Some(57), vec![]),
            Self::GlobalControl { command, groups } => (127, 0x46, Some(58), vec![command, groups]),
            Self::DataExchange { pkw, stw, hsw } => {
                (OWN, fc, None, [pkw.as_slice(), &stw.to_be_bytes(), &hsw.to_be_bytes()].concat())
            }
        };
        telegram(da, sa, sap, sap.and(Some(62)), fc, &data)
    }
}

/// Short acknowledge, or a response from us to who has asked.
fn check_reply(reply: &[u8], has_asked: impl Fn(Address) -> bool) {
    match decode(reply) {
        Decoded::Telegram { telegram: Telegram::ShortAcknowledge, len: 1 } => {
            assert!(
                (0..127).any(|number| Address::station(number).is_ok_and(&has_asked)),
                "nobody has asked"
            );
        }
        Decoded::Telegram { telegram: Telegram::Data(data), len } => {
            assert!(has_asked(data.da), "{} has not asked", data.da);
            assert_eq!((data.sa.number(), len), (OWN, reply.len()));
            assert!(matches!(data.fc.function(), Function::Response(..)));
        }
        other => panic!("{other:?}"),
    }
}

/// Who waits for a reply to the last request to us among the telegrams that begin these octets one behind the other.
/// What follows the first wrong octet is nobody's, until the line falls silent.
fn last_request(octets: &[u8]) -> Option<Address> {
    let (mut rest, mut asker) = (octets, None);
    while let Decoded::Telegram { telegram, len } = decode(rest) {
        asker = request(&telegram).or(asker);
        rest = &rest[len..];
    }
    asker
}

/// What follows the telegrams that begin these octets one behind the other.
fn behind_telegrams(octets: &[u8]) -> &[u8] {
    let mut rest = octets;
    while let Decoded::Telegram { len, .. } = decode(rest) {
        rest = &rest[len..];
    }
    rest
}

/// Who waits where idle time cannot be seen: a telegram may stand at any place.
fn requests_anywhere(octets: &[u8]) -> impl Iterator<Item = Address> {
    (0..octets.len()).filter_map(|at| match decode(&octets[at..]) {
        Decoded::Telegram { telegram, .. } => request(&telegram),
        Decoded::Incomplete | Decoded::Invalid { .. } => None,
    })
}

/// Who waits for our reply to this telegram.
fn request(telegram: &Telegram<'_>) -> Option<Address> {
    let Telegram::Data(data) = telegram else { return None };
    let Function::Request(service, _) = data.fc.function() else { return None };
    (data.da.number() == OWN && service.wants_reply()).then_some(data.sa)
}

/// Whether a telegram to a SAP of ours stands anywhere in the octets.
fn holds(octets: &[u8], sap: u8) -> bool {
    (0..octets.len()).any(|at| {
        matches!(decode(&octets[at..]), Decoded::Telegram { telegram: Telegram::Data(data), .. }
            if data.da.number() == OWN && data.dsap.is_some_and(|dsap| dsap.number() == sap))
    })
}

fn telegram(da: u8, sa: u8, dsap: Option<u8>, ssap: Option<u8>, fc: u8, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = (dsap.and_then(Sap::new), ssap.and_then(Sap::new));
    let data = &data[..data.len().min(244)];
    let format = DataTelegram::customary_format(dsap, ssap, data);
    let format = if data.len() == 8 && dsap.is_none() && ssap.is_none() { Format::Sd3 } else { format };
    let (da, sa, fc) = (Address::from_octet(da), Address::from_octet(sa), FunctionCode::from_octet(fc));
    let telegram = DataTelegram { format, da, sa, dsap, ssap, fc, data };
    telegram.encode(&mut [0; MAX_TELEGRAM_LEN]).expect("at most 244 octets").to_vec()
}
