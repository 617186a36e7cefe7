//! One piece of client code commissions an emulated AG03 and an AG03/1 through profirust: in this process in virtual
//! time, over a pseudo-terminal, and over TCP.

use core::time::Duration;
use std::thread;

use profidrive::bench::Line;
use profidrive::client::{DriveClient, Goal, GoalError, Job, Obstacle, PkwError, Reply};
use profidrive::devices::ag03::drive::Direction;
use profidrive::devices::ag03::param::{Model, Pnu, Subindex, Value};
use profidrive::devices::ag03::profibus::{Config, Device};
use profidrive::host::link::fault::Faulty;
use profidrive::host::link::pty::Pty;
use profidrive::host::link::tcp::{Connection, Reach, Tcp};
use profidrive::host::link::terminal::Terminal;
use profidrive::host::{self, Bus, Link, Stop, SystemClock};
use profidrive::master::{Profirust, Session, SessionError, Settings, baudrate, peripheral};
use profidrive::profibus::fdl::{Address, StationType};
use profidrive::profibus::ppo::{Inputs, PPO_LEN};
use profidrive::time::{BaudRate, Instant};
use profirust::dp::{DpMaster, PeripheralEvent, PeripheralHandle};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};

const BAUD: BaudRate = BaudRate::K500;

fn station(number: u8) -> Address {
    Address::station(number).unwrap()
}

fn pnu(number: u16) -> Pnu {
    Pnu::new(number).unwrap()
}

/// Something that exchanges images with a drive and knows the time.
trait Exchange {
    fn exchange(&mut self, outputs: [u8; PPO_LEN]) -> [u8; PPO_LEN];
    fn now(&self) -> Instant;
}

/// The client code that is the same everywhere.
struct Application<X> {
    client: DriveClient,
    exchange: X,
}

impl<X: Exchange> Application<X> {
    fn new(exchange: X) -> Self {
        Self { client: DriveClient::default(), exchange }
    }

    fn step(&mut self) {
        let inputs = self.exchange.exchange(self.client.outputs());
        self.client.handle_inputs(self.exchange.now(), Inputs::new(&inputs));
    }

    fn job(&mut self, job: Job) -> Result<Reply, PkwError> {
        self.client.submit(self.exchange.now(), job).unwrap();
        loop {
            self.step();
            if let Some(outcome) = self.client.poll_job() {
                assert_eq!(outcome.job, job);
                return outcome.result;
            }
        }
    }

    fn reach(&mut self, goal: Goal) -> Result<i32, GoalError> {
        self.client.pursue(self.exchange.now(), goal);
        loop {
            self.step();
            if let Some(outcome) = self.client.poll_outcome() {
                assert_eq!(outcome.goal, goal);
                return outcome.result;
            }
        }
    }

    /// Parameters, refusals, positioning, inching, velocity, and off again.
    fn commission(&mut self, model: Model) {
        let value = |value| Ok(Reply::Value(value));
        assert_eq!(self.job(Job::read(pnu(1018))), value(Value::Double(0)));
        assert_eq!(
            self.job(Job::write(pnu(1016), Value::Double(250_000))),
            value(Value::Double(250_000)),
            "limit 1 of the manual's example"
        );
        assert_eq!(self.job(Job::read_element(pnu(945), Subindex(9))), value(Value::Word(0)));
        assert_eq!(self.job(Job::element_count(pnu(945))), Ok(Reply::ElementCount(10)));
        let d_pos = self.job(Job::read(pnu(1039)));
        let zero_acceleration = self.job(Job::write(pnu(1003), Value::Word(0)));
        match model {
            Model::Ag03 => {
                assert!(matches!(d_pos, Err(PkwError::Refused(code)) if code.number() == 0), "{d_pos:?}");
                assert_eq!(zero_acceleration, value(Value::Word(0)), "C-02");
                assert_eq!(self.job(Job::write(pnu(1003), Value::Word(50))), value(Value::Word(50)));
            }
            Model::Ag03_1 => {
                assert_eq!(d_pos, value(Value::Word(101)));
                let refused = matches!(zero_acceleration, Err(PkwError::Refused(code)) if code.number() == 2);
                assert!(refused, "{zero_acceleration:?}");
            }
        }
        // The reply to PNU 970 differs between the two; the client takes both.
        assert!(
            matches!(self.job(Job::write(pnu(970), Value::Word(5))), Ok(Reply::Value(value)) if value.bits() == 0)
        );

        assert!(self.reach(Goal::Enable).is_ok());
        let position = self.reach(Goal::MoveTo(400)).unwrap();
        assert!((390..=410).contains(&position), "{position}");
        assert!(self.reach(Goal::Jog(Direction::Negative)).is_ok());
        while self.client.hiw() >= position {
            self.step();
        }
        assert!(self.reach(Goal::Stop).is_ok());
        assert!(self.reach(Goal::Disable).is_ok());

        assert_eq!(self.job(Job::write(pnu(930), Value::Word(1))), value(Value::Word(1)));
        assert!(self.reach(Goal::Enable).is_ok());
        let velocity = self.reach(Goal::Velocity(-40)).unwrap();
        assert!((-50..=-30).contains(&velocity), "{velocity}");
        assert!(self.reach(Goal::Disable).is_ok());
    }
}

/// profirust and the drive in this process.
struct InProcess {
    bus: Line<Profirust<'static>>,
    drive: PeripheralHandle,
}

impl InProcess {
    fn new(model: Model) -> Self {
        let mut dp = DpMaster::new(Vec::new());
        let drive = dp.add(peripheral(5, BAUD));
        dp.enter_operate();
        let parameters = ParametersBuilder::new(2, baudrate(BAUD)).build_verified(&dp);
        let mut fdl = FdlActiveStation::new(parameters);
        fdl.set_online();
        let mut bus = Profirust::on_line(fdl, dp).unwrap();
        bus.add_drive(Config { model, ..Config::new(station(5)) }).unwrap();
        Self { bus, drive }
    }
}

impl Exchange for InProcess {
    fn exchange(&mut self, outputs: [u8; PPO_LEN]) -> [u8; PPO_LEN] {
        let drive = self.drive;
        self.bus.master.dp.get_mut(drive).pi_q_mut().copy_from_slice(&outputs);
        let exchanged = Some((drive, PeripheralEvent::DataExchanged));
        self.bus
            .run_until(Duration::from_secs(10), |bus| bus.master.take_events().peripheral == exchanged)
            .unwrap();
        *self.bus.master.dp.get_mut(drive).pi_i().first_chunk().unwrap()
    }

    fn now(&self) -> Instant {
        self.bus.now()
    }
}

impl<L: Link> Exchange for Session<L, SystemClock> {
    fn exchange(&mut self, outputs: [u8; PPO_LEN]) -> [u8; PPO_LEN] {
        Self::exchange(self, &outputs).unwrap()
    }

    fn now(&self) -> Instant {
        Self::now(self)
    }
}

/// A session whose drive no busy machine lets go: it asks for two seconds.
fn session<L: Link>(link: L) -> Session<L, SystemClock> {
    let settings = Settings {
        slot_time: Duration::from_millis(130),
        retry_limit: 15,
        watchdog: Duration::from_secs(60),
        ..Settings::untimed(station(2), BAUD)
    };
    Session::new(link, SystemClock::new(), Stop::new().unwrap(), settings).unwrap()
}

/// Runs a drive on a link in a thread of its own while the master does its work.
fn beside(link: &mut (dyn Link + Send), model: Model, master: impl FnOnce() + Send) {
    let (stop, clock, mut bus) = (Stop::new().unwrap(), SystemClock::new(), Bus::new());
    let config = Config { model, baud: BAUD, ..Config::new(station(5)) };
    bus.add(Device::new(config, host::Clock::now(&clock))).unwrap();
    thread::scope(|scope| {
        let drive = scope.spawn(|| host::run(link, &mut bus, &clock, &stop, &mut |_| {}));
        // The drive's thread ends with the master, whatever happens to it.
        let outcome = scope.spawn(master).join();
        stop.request();
        drive.join().unwrap().unwrap();
        if let Err(panic) = outcome {
            std::panic::resume_unwind(panic);
        }
    });
}

#[test]
fn both_models_are_commissioned_in_this_process() {
    for model in Model::ALL {
        Application::new(InProcess::new(model)).commission(model);
    }
}

#[test]
fn a_refused_goal_says_what_is_in_the_way() {
    let mut application = Application::new(InProcess::new(Model::Ag03_1));
    assert!(application.reach(Goal::Enable).is_ok());
    let Err(GoalError::Refused(obstacles)) = application.reach(Goal::MoveTo(1_000_001)) else {
        panic!("accepted")
    };
    assert!(obstacles.contains(Obstacle::TargetBeyondLimits), "{obstacles}");
}

#[test]
fn both_models_are_commissioned_over_a_pseudo_terminal() {
    for model in Model::ALL {
        let mut pty = Pty::open(None).unwrap();
        let terminal = pty.path().to_owned();
        beside(&mut pty, model, || {
            let mut session = session(Terminal::open(&terminal, BAUD).unwrap());
            session.start(station(5)).unwrap();
            let mut application = Application::new(session);
            application.commission(model);
            application.exchange.release().unwrap();
        });
    }
}

#[test]
fn both_models_are_commissioned_over_tcp() {
    for model in Model::ALL {
        let mut tcp = Tcp::bind("127.0.0.1:0", BAUD, Reach::ThisMachine).unwrap();
        let place = tcp.address().to_string();
        beside(&mut tcp, model, || {
            let mut session = session(Connection::open(&place).unwrap());
            session.start(station(5)).unwrap();
            let mut application = Application::new(session);
            application.commission(model);
            application.exchange.release().unwrap();
        });
    }
}

#[test]
fn a_session_finds_who_is_there_and_a_released_drive_is_anybodys() {
    let mut pty = Pty::open(None).unwrap();
    let terminal = pty.path().to_owned();
    beside(&mut pty, Model::Ag03_1, || {
        let mut first = session(Terminal::open(&terminal, BAUD).unwrap());
        let mut found = Vec::new();
        first.find([station(4), station(5)], |address, who| found.push((address, who))).unwrap();
        assert_eq!(found, [(station(4), None), (station(5), Some(StationType::Slave))]);
        let before = first.diagnosis(station(5)).unwrap().0;
        assert_eq!((before.master, before.ident), (None, 0x0AC5));
        assert!(matches!(first.start(station(4)), Err(SessionError::NoAnswer { .. })));
        first.start(station(5)).unwrap();
        assert_eq!(first.diagnosis(station(5)).unwrap().0.master, Some(station(2)));
        drop(first);

        // The watchdog still has nearly a minute.
        let settings = Settings::untimed(station(3), BAUD);
        let link = Terminal::open(&terminal, BAUD).unwrap();
        let mut second = Session::new(link, SystemClock::new(), Stop::new().unwrap(), settings).unwrap();
        let locked = second.start(station(5)).unwrap_err();
        assert!(matches!(locked, SessionError::Locked { owner, .. } if owner == station(2)), "{locked}");
        drop(second);

        let mut owner = session(Terminal::open(&terminal, BAUD).unwrap());
        owner.start(station(5)).unwrap();
        owner.release().unwrap();
        let link = Terminal::open(&terminal, BAUD).unwrap();
        let mut second = Session::new(link, SystemClock::new(), Stop::new().unwrap(), settings).unwrap();
        second.start(station(5)).unwrap();
        second.release().unwrap();
    });
}

#[test]
fn a_start_that_failed_can_be_tried_again_and_another_drive_be_missing() {
    let pty = Pty::open(None).unwrap();
    let terminal = pty.path().to_owned();
    let refuses_once = "refuse-cfg,count=1".parse().unwrap();
    let mut faulty = Faulty::new(pty, SystemClock::new(), &[refuses_once]);
    beside(&mut faulty, Model::Ag03_1, || {
        let mut session = session(Terminal::open(&terminal, BAUD).unwrap());
        let outputs = [0; PPO_LEN];
        let exchanged = Session::exchange(&mut session, &outputs);
        assert!(matches!(exchanged, Err(SessionError::NotStarted)), "{exchanged:?}");
        let refused = session.start(station(5));
        assert!(matches!(refused, Err(SessionError::CfgRefused { .. })), "{refused:?}");
        let exchanged = Session::exchange(&mut session, &outputs);
        assert!(matches!(exchanged, Err(SessionError::NotStarted)), "{exchanged:?}");
        let other = session.start(station(7));
        assert!(matches!(other, Err(SessionError::NoAnswer { .. })), "{other:?}");
        session.start(station(5)).unwrap();
        Session::exchange(&mut session, &outputs).unwrap();
        session.start(station(5)).unwrap();
        session.release().unwrap();
    });
}
