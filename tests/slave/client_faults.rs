//! `PkwClient` against the emulated drives behind a link that corrupts telegrams.

use crate::drive_line;
use crate::long;

use std::time::Duration;

use drive_line::{CFG, IDENT, MASTER, SLAVE, telegram};
use long::cases;
use profidrive::client::{Images, Job, PkwClient, PkwError, Profile, Reply};
use profidrive::devices::ag03::param::{Model, Parameter, Pnu, Subindex, Value, Width};
use profidrive::devices::ag03::profibus::{Config, Device, MAX_TELEGRAM_LEN};
use profidrive::host::link::fault::Faulty;
use profidrive::host::link::memory::{End, Wire};
use profidrive::host::{Clock, Link, ManualClock, Received};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, FrameCount, FunctionCode, Service, Telegram};
use profidrive::profibus::ppo;
use profidrive::profibus::ppo::{Outputs, Stw};
use proptest::prelude::*;

fn model() -> impl Strategy<Value = Model> {
    prop_oneof![Just(Model::Ag03), Just(Model::Ag03_1)]
}

fn config(model: Model) -> Config {
    Config { model, ..Config::new(Address::station(SLAVE).unwrap()) }
}

/// A drive behind a link with faults, and a master that repeats what is not answered.
struct Corrupted {
    master: End,
    link: Faulty<End, ManualClock>,
    device: Device,
    clock: ManualClock,
    count: FrameCount,
}

impl Corrupted {
    fn new(model: Model, faults: &[String]) -> Self {
        let (wire, clock) = (Wire::new(), ManualClock::new());
        let faults: Vec<_> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
        let device = Device::new(config(model), clock.now());
        let (master, link) = (wire.end(), Faulty::new(wire.end(), clock.clone(), &faults));
        let mut line = Self { master, link, device, clock, count: FrameCount::First };
        for (sap, data) in [(61, &[0x80, 1, 1, 11, IDENT[0], IDENT[1], 0][..]), (62, &CFG)] {
            while line.ask(Some(sap), data) != Some(Vec::new()) {}
        }
        line
    }

    /// The data of the reply, after up to three repetitions.
    fn ask(&mut self, dsap: Option<u8>, data: &[u8]) -> Option<Vec<u8>> {
        let octets = telegram(SLAVE, MASTER, FunctionCode::request(Service::SrdHigh, self.count), dsap, data);
        let reply = (0..4).find_map(|_| self.send(&octets))?;
        self.count = match self.count {
            FrameCount::Even => FrameCount::Odd,
            FrameCount::First | FrameCount::Odd | FrameCount::Unused => FrameCount::Even,
        };
        Some(reply)
    }

    /// One request and half a millisecond for its reply.
    fn send(&mut self, octets: &[u8]) -> Option<Vec<u8>> {
        self.master.send(octets).unwrap();
        let (mut buf, mut telegram) = ([0; 600], [0; MAX_TELEGRAM_LEN]);
        for _ in 0..10 {
            self.clock.advance(Duration::from_micros(50));
            let now = self.clock.now();
            if let Received::Octets(count) = self.link.receive(&mut buf).unwrap() {
                self.device.handle_bytes(now, &buf[..count]);
            }
            self.device.handle_timeout(now);
            if let Some(octets) = self.device.poll_transmit(now, &mut telegram) {
                self.link.send(octets).unwrap();
            }
            while self.device.poll_event().is_some() {}
        }
        let Received::Octets(count) = self.master.receive(&mut buf).unwrap() else { return None };
        match decode(&buf[..count]) {
            Decoded::Telegram { telegram: Telegram::Data(data), len } if len == count => {
                Some(data.data.to_vec())
            }
            Decoded::Telegram { telegram: Telegram::ShortAcknowledge, len: 1 } if count == 1 => {
                Some(Vec::new())
            }
            _ => None,
        }
    }

    fn run(&mut self, client: &mut PkwClient, job: Job) -> Result<Reply, PkwError> {
        client.submit(self.clock.now(), job).unwrap();
        let deadline = client.poll_timeout().unwrap();
        loop {
            let outputs = Outputs::octets(client.output(), Stw::default(), 0);
            match self.ask(None, &outputs) {
                Some(inputs) => {
                    client.handle_input(self.clock.now(), ppo::Inputs::parse(&inputs).unwrap().pkw());
                }
                None => client.handle_timeout(self.clock.now()),
            }
            if let Some(outcome) = client.poll_outcome() {
                return outcome.result;
            }
            assert!(self.clock.now() < deadline, "{job} hangs");
        }
    }
}

fn fault() -> impl Strategy<Value = String> {
    let kind = prop_oneof![
        (1..6_u8).prop_map(|exchanges| format!("pkw-delay={exchanges}")),
        Just("pkw-wrong-ak".to_owned()),
        Just("pkw-wrong-pnu".to_owned()),
        Just("pkw-torn".to_owned()),
        Just("no-reply".to_owned()),
        Just("truncated".to_owned()),
        Just("wrong-fcs".to_owned()),
    ];
    (kind, 1..6_u8, any::<u16>())
        .prop_map(|(kind, tenths, seed)| format!("{kind},rate=0.{tenths},seed={seed}"))
}

#[derive(Clone, Copy, Debug)]
enum Access {
    Read(Parameter),
    Write(Parameter, i32),
    FaultBuffer(u8),
    Count,
    Calibrate,
}

fn access() -> impl Strategy<Value = Access> {
    let parameter = || {
        prop_oneof![
            Just(Parameter::VPos),
            Just(Parameter::PosWindow),
            Just(Parameter::Limit1),
            Just(Parameter::CalibrationValue),
        ]
    };
    prop_oneof![
        4 => parameter().prop_map(Access::Read),
        4 => (parameter(), prop_oneof![Just(30), Just(77), Just(2_000_000)]).prop_map(|(p, v)| Access::Write(p, v)),
        1 => (0..12_u8).prop_map(Access::FaultBuffer),
        1 => Just(Access::Count),
        1 => Just(Access::Calibrate),
    ]
}

proptest! {
    #![proptest_config(cases(40, 50))]

    #[test]
    fn a_corrupted_line_brings_errors_but_no_wrong_values(
        model in model(), faults in proptest::collection::vec(fault(), 0..4),
        accesses in proptest::collection::vec(access(), 1..20), consistent: bool,
    ) {
        let mut line = Corrupted::new(model, &faults);
        let images = if consistent { Images::Consistent } else { Images::MayBeTorn };
        let mut client = PkwClient::new(Profile { images, exchanges: 60, ..Profile::AG03 });
        let mut answered = 0;
        for access in &accesses {
            let stored = |line: &Corrupted, p: Parameter| Value::of(p.entry().width, line.device.parameters().value(p));
            let (job, before) = match *access {
                Access::Read(p) => (Job::read(p.entry().pnu).expecting(p.entry().width), Some(p)),
                Access::Write(p, value) => (Job::write(p.entry().pnu, Value::of(p.entry().width, value)), Some(p)),
                Access::FaultBuffer(n) => {
                    (Job::read_element(Pnu::new(945).unwrap(), Subindex(n)).expecting(Width::Word), None)
                }
                Access::Count => (Job::element_count(Pnu::new(945).unwrap()), None),
                Access::Calibrate => (Job::write(Pnu::new(970).unwrap(), Value::Word(5)), None),
            };
            let old = before.map(|p| stored(&line, p));
            let result = line.run(&mut client, job);
            let new = before.map(|p| stored(&line, p));
            answered += usize::from(result.is_ok());
            match (*access, result) {
                (Access::Read(_) | Access::Write(..), Ok(reply)) => {
                    prop_assert_eq!(Some(reply), new.map(Reply::Value), "{}", job);
                    if let Access::Read(_) = access { prop_assert_eq!(old, new) }
                }
                (Access::FaultBuffer(n), Ok(reply)) => {
                    prop_assert!(n < 10);
                    prop_assert_eq!(reply, Reply::Value(Value::Word(0)));
                }
                (Access::Count, Ok(reply)) => prop_assert_eq!(reply, Reply::ElementCount(10)),
                (Access::Calibrate, Ok(reply)) => {
                    prop_assert!(matches!(reply, Reply::Value(value) if value.bits() == 0));
                }
                (_, Err(error)) => if error.is_certain() { prop_assert_eq!(old, new, "{}: {}", job, error) },
            }
        }
        let pkw_corrupted = faults.iter().any(|fault| fault.contains("wrong") || fault.contains("delay"));
        if !pkw_corrupted && !accesses.iter().any(|access| matches!(access, Access::Write(..) | Access::FaultBuffer(_))) {
            prop_assert_eq!(answered, accesses.len(), "lost telegrams and torn answers only cost time");
        }
    }
}
