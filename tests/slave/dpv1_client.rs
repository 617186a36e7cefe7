//! The master's end of DP-V1 against a slave, with lost and repeated telegrams: both connections beside Data_Exchange, compared
//! with a model of `dp-v1.md` 1 to 4.

use std::collections::BTreeMap;
use std::time::Duration;

use profidrive::client::{AcyclicAnswer, AcyclicClient, AcyclicError, Heard, NotAsked};
use profidrive::profibus::dpv1::{AlarmType, ErrorCode, Failure, Function, Offer};
use profidrive::profibus::fdl::Service;
use profidrive::time::Instant;
use proptest::prelude::*;

use crate::dpv1_line::{FULL, OTHER, OWNER, PRM, Record, V1Line};
use crate::slave_line::{Answer, RR, RS};

const PATIENCE: Duration = Duration::from_secs(5);
/// Times 10 ms.
const SEND_TIMEOUT: u16 = 10;

/// What came of a job, without its borrow.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Done {
    Opened(u8),
    Read(Vec<u8>),
    Written,
    Acknowledged,
    Closed,
}

impl Done {
    fn of(answer: AcyclicAnswer<'_>) -> Self {
        match answer {
            AcyclicAnswer::Opened { max_len } => Self::Opened(max_len),
            AcyclicAnswer::Read(data) => Self::Read(data.to_vec()),
            AcyclicAnswer::Written => Self::Written,
            AcyclicAnswer::Acknowledged => Self::Acknowledged,
            AcyclicAnswer::Closed => Self::Closed,
        }
    }
}

/// What was sent, what came back, and what came of the job, if it is over.
type Stepped = (Vec<u8>, Answer, Option<Result<Done, AcyclicError>>);

/// One telegram of a client: `lost` replies do not arrive and the telegram is repeated. What it sent, and what came of it.
fn step(line: &mut V1Line, master: u8, client: &mut AcyclicClient, lost: u8) -> Option<Stepped> {
    let sent = client.poll_transmit(line.now)?;
    let (saps, data) = ((sent.dsap, sent.ssap), sent.data.to_vec());
    let mut answer = line.srd(master, Some(saps), Service::SrdLow, &data);
    for _ in 0..lost {
        let again = line.retry();
        assert_eq!(again, answer, "a repeated telegram has the same reply");
        answer = again;
    }
    let heard = match &answer {
        Answer::Sc => Heard::Acknowledged,
        Answer::Low(data) | Answer::High(data) => Heard::Data(data),
        answer if *answer == RS => Heard::NotActivated,
        answer if *answer == RR => Heard::NoResource,
        Answer::Silence => Heard::Silence,
        answer @ Answer::Sd1(_) => panic!("{answer:?}"),
    };
    let outcome = client.handle(line.now, heard).map(|outcome| outcome.map(Done::of));
    Some((data, answer, outcome))
}

/// Until the job is over.
fn run(line: &mut V1Line, master: u8, client: &mut AcyclicClient) -> Result<Done, AcyclicError> {
    for _ in 0..100 {
        if let Some((.., Some(outcome))) = step(line, master, client, 0) {
            return outcome;
        }
    }
    panic!("not over: {client:?}")
}

fn refused(function: Function, place: (u8, u8), code: ErrorCode) -> Result<Done, AcyclicError> {
    Err(AcyclicError::Refused { function, place: Some(place), failure: Failure::of(code) })
}

#[test]
fn the_owner_reads_writes_and_acknowledges() {
    let mut line = V1Line::exchanging(FULL);
    let mut client = AcyclicClient::class_1(PATIENCE);
    let now = line.now;
    client.read(now, 1, 10, 240).unwrap();
    assert_eq!(client.read(now, 1, 10, 240), Err(NotAsked::Busy));
    assert_eq!(run(&mut line, OWNER, &mut client), Ok(Done::Read(vec![0x11, 0x22, 0x33, 0x44])));
    client.write(now, 1, 10, &[1, 2, 3, 4]).unwrap();
    assert_eq!(run(&mut line, OWNER, &mut client), Ok(Done::Written));
    client.read(now, 1, 10, 2).unwrap();
    assert_eq!(run(&mut line, OWNER, &mut client), Ok(Done::Read(vec![1, 2])));
    client.read(now, 1, 11, 240).unwrap();
    let error = run(&mut line, OWNER, &mut client);
    assert_eq!(error, refused(Function::Read, (1, 11), ErrorCode::INVALID_INDEX));
    let words =
        "Read of record 11 of slot 1: access, invalid index (80 B0 00): the slot has no record of this index";
    assert_eq!(error.unwrap_err().to_string(), words);
    let alarm = line.raise(AlarmType::Process, &[7]).unwrap();
    line.diagnosis(OWNER);
    client.acknowledge(now, alarm).unwrap();
    assert_eq!(run(&mut line, OWNER, &mut client), Ok(Done::Acknowledged));
    assert!(line.acyclic.alarms().is_empty());
    let wrong = NotAsked::Length { got: 241, most: 240 };
    assert_eq!(client.write(now, 1, 10, &[0; 241]), Err(wrong));
    // Without DP-V1 nobody listens, and with it the next job is answered.
    line.start(OWNER, &[0x88, 10, 10, 11, 0xC0, 0xDE, 0, 0, 0, 0]);
    client.read(now, 1, 10, 4).unwrap();
    assert_eq!(run(&mut line, OWNER, &mut client), Err(AcyclicError::ChannelClosed { sap: 51 }));
    line.start(OWNER, &PRM);
    client.read(now, 1, 10, 4).unwrap();
    assert_eq!(run(&mut line, OWNER, &mut client), Ok(Done::Read(vec![1, 2, 3, 4])));
}

#[test]
fn a_connection_is_opened_kept_and_closed() {
    let mut line = V1Line::new(FULL);
    let mut client = AcyclicClient::class_2(SEND_TIMEOUT, PATIENCE);
    assert_eq!(client.read(line.now, 1, 10, 4), Err(NotAsked::NotOpen));
    client.open(line.now);
    assert_eq!(run(&mut line, OTHER, &mut client), Ok(Done::Opened(240)));
    client.read(line.now, 1, 10, 240).unwrap();
    assert_eq!(run(&mut line, OTHER, &mut client), Ok(Done::Read(vec![0x11, 0x22, 0x33, 0x44])));
    // Idle keeps it for ten times as long as the slave waits.
    for _ in 0..60 {
        line.wait(Duration::from_millis(51));
        assert!(client.poll_timeout().is_some_and(|due| due <= line.now));
        for _ in 0..2 {
            let (.., outcome) = step(&mut line, OTHER, &mut client, 1).unwrap();
            assert_eq!(outcome, None);
        }
        assert!(step(&mut line, OTHER, &mut client, 0).is_none(), "nothing more to say");
    }
    assert_eq!(line.acyclic.links().count(), 1);
    client.close();
    assert_eq!(run(&mut line, OTHER, &mut client), Ok(Done::Closed));
    assert_eq!(line.acyclic.links().count(), 0);
    // Too long without a word.
    client.open(line.now);
    assert_eq!(run(&mut line, OTHER, &mut client), Ok(Done::Opened(240)));
    line.wait(Duration::from_millis(301));
    client.read(line.now, 1, 10, 4).unwrap();
    assert_eq!(run(&mut line, OTHER, &mut client), Err(AcyclicError::ChannelClosed { sap: 48 }));
    let mut without = V1Line::new(Offer { ms2: None, ..FULL });
    client.open(without.now);
    assert_eq!(run(&mut without, OTHER, &mut client), Err(AcyclicError::NoConnections));
    // Fewer than the least Send_Timeout of the slave.
    let mut hasty = AcyclicClient::class_2(9, PATIENCE);
    hasty.open(line.now);
    let error = run(&mut line, OTHER, &mut hasty).unwrap_err().to_string();
    assert_eq!(error, "the slave ended the connection: the Send_Timeout asked for is too small");
}

#[test]
fn a_slow_slave_is_polled_and_given_up_in_time() {
    let mut line = V1Line::exchanging(FULL);
    let slow = Record { data: vec![5], delay: Duration::from_secs(1), ..Record::default() };
    line.put(1, 20, slow);
    let mut client = AcyclicClient::class_1(Duration::from_secs(2));
    let poll_until_over = |line: &mut V1Line, client: &mut AcyclicClient| loop {
        if let Some((.., Some(outcome))) = step(line, OWNER, client, 0) {
            return outcome;
        }
        assert_eq!(line.exchange(), Answer::Low(vec![0, 0]));
        line.wait(Duration::from_millis(50));
    };
    client.read(line.now, 1, 20, 1).unwrap();
    assert_eq!(poll_until_over(&mut line, &mut client), Ok(Done::Read(vec![5])));
    line.records.records.get_mut(&(1, 20)).unwrap().delay = Duration::from_secs(9);
    client.read(line.now, 1, 20, 1).unwrap();
    let over = Err(AcyclicError::TimeOut(Duration::from_secs(2)));
    assert_eq!(poll_until_over(&mut line, &mut client), over);
}

/// What a random walk does next.
#[derive(Clone, Debug)]
enum Act {
    /// A client sends its next telegram, whose reply is lost so often.
    Telegram {
        who: usize,
        lost: u8,
    },
    /// A client that has nothing to do asks for something.
    Read {
        who: usize,
        slot: u8,
        index: u8,
        len: u8,
    },
    Write {
        who: usize,
        slot: u8,
        index: u8,
        data: Vec<u8>,
    },
    Open {
        who: usize,
    },
    Close {
        who: usize,
    },
    Exchange,
    Diagnosis,
    Restart {
        dp_v1: bool,
    },
    Wait {
        milliseconds: u16,
    },
}

fn act() -> impl Strategy<Value = Act> {
    let who = 0..3_usize;
    let index = prop_oneof![Just(10_u8), Just(11), Just(12), Just(13)];
    let slot = prop_oneof![6 => Just(1_u8), 1 => Just(2), 1 => Just(7)];
    prop_oneof![
        30 => (who.clone(), 0..3_u8).prop_map(|(who, lost)| Act::Telegram { who, lost }),
        6 => (who.clone(), slot.clone(), index.clone(), 1..=240_u8)
            .prop_map(|(who, slot, index, len)| Act::Read { who, slot, index, len }),
        6 => (who.clone(), slot, index, prop::collection::vec(any::<u8>(), 2..6))
            .prop_map(|(who, slot, index, data)| Act::Write { who, slot, index, data }),
        4 => who.clone().prop_map(|who| Act::Open { who }),
        1 => who.prop_map(|who| Act::Close { who }),
        6 => Just(Act::Exchange),
        2 => Just(Act::Diagnosis),
        1 => any::<bool>().prop_map(|dp_v1| Act::Restart { dp_v1 }),
        3 => (0..200_u16).prop_map(|milliseconds| Act::Wait { milliseconds }),
    ]
}

/// What the reference says that the records hold, and what each client must be told.
struct Model {
    records: BTreeMap<(u8, u8), Vec<u8>>,
    runs: usize,
    /// What a job that was taken must bring.
    due: [Option<Result<Done, AcyclicError>>; 3],
    /// When the slave last heard something of a connection.
    heard: [Instant; 3],
}

const READ_ONLY: (u8, u8) = (1, 12);

/// Lock, no watchdog; DP-V1, all alarms.
const NO_WATCHDOG: [u8; 10] = [0x80, 1, 1, 11, 0xC0, 0xDE, 0, 0x80, 0xFC, 0x00];

impl Model {
    /// A request was taken: from here on its outcome is certain.
    fn take(&mut self, who: usize, request: &[u8]) {
        let [function, slot, index, len, ref data @ ..] = *request else { return };
        let write = function == 0x5F;
        let name = if write { Function::Write } else { Function::Read };
        let outcome = match self.records.get_mut(&(slot, index)) {
            _ if slot > 2 => refused(name, (slot, index), ErrorCode::INVALID_SLOT),
            None => refused(name, (slot, index), ErrorCode::INVALID_INDEX),
            Some(record) => {
                self.runs += 1;
                match write {
                    false => Ok(Done::Read(record[..record.len().min(len.into())].to_vec())),
                    true if (slot, index) == READ_ONLY => {
                        refused(name, (slot, index), ErrorCode::ACCESS_DENIED)
                    }
                    true if data.len() != record.len() => {
                        refused(name, (slot, index), ErrorCode::WRITE_LENGTH)
                    }
                    true => {
                        *record = data.to_vec();
                        Ok(Done::Written)
                    }
                }
            }
        };
        self.due[who] = Some(outcome);
    }
}

/// Three clients: the owner at SAP 51, and two masters of class 2, one of them with the address of the owner's neighbour.
fn walk(acts: &[Act]) {
    const MASTERS: [u8; 3] = [OWNER, OTHER, 4];
    let mut line = V1Line::new(FULL);
    line.start(OWNER, &NO_WATCHDOG);
    // What is repeated behind the first telegram of a master is known by its frame count bit.
    for master in MASTERS {
        line.dp(master, 60, &[]);
    }
    line.put(1, 11, Record { data: vec![9, 9], ..Record::default() });
    line.put(1, 12, Record { data: vec![1, 2, 3], read_only: true, ..Record::default() });
    let records = line.records.records.iter().map(|(place, record)| (*place, record.data.clone())).collect();
    let start = line.now;
    let mut model = Model { records, runs: 0, due: [None, None, None], heard: [start; 3] };
    let mut clients = [
        AcyclicClient::class_1(Duration::from_secs(600)),
        AcyclicClient::class_2(SEND_TIMEOUT, Duration::from_secs(600)),
        AcyclicClient::class_2(SEND_TIMEOUT, Duration::from_secs(600)),
    ];
    let limit = Duration::from_millis(10) * u32::from(SEND_TIMEOUT) * 3;
    let mut dp_v1 = true;
    for act in acts {
        match act {
            Act::Telegram { who, lost } => {
                let (who, before) = (*who, line.now);
                let Some((sent, answer, outcome)) = step(&mut line, MASTERS[who], &mut clients[who], *lost)
                else {
                    continue;
                };
                if answer == Answer::Sc && matches!(sent.first(), Some(0x5E | 0x5F)) {
                    model.take(who, &sent);
                }
                let silent = before.saturating_since(model.heard[who]);
                if answer != RS {
                    model.heard[who] = line.now;
                }
                match outcome {
                    None => {}
                    Some(Err(AcyclicError::ChannelClosed { .. })) => {
                        // The data exchange has ended, or nothing came for too long.
                        let silent = silent.saturating_add(Duration::from_millis(1));
                        assert!(if who == 0 { !dp_v1 } else { silent >= limit }, "{who}: {silent:?}");
                        model.due[who] = None;
                    }
                    Some(Ok(Done::Opened(240) | Done::Closed)) => model.due[who] = None,
                    // Those that nobody fetched are free after a time only.
                    Some(Err(AcyclicError::NoConnections)) if who > 0 => model.due[who] = None,
                    Some(outcome) => assert_eq!(Some(outcome), model.due[who].take(), "{who}"),
                }
            }
            Act::Read { who, slot, index, len } => {
                let _busy_or_closed = clients[*who].read(line.now, *slot, *index, *len);
            }
            Act::Write { who, slot, index, data } => {
                let _busy_or_closed = clients[*who].write(line.now, *slot, *index, data);
            }
            Act::Open { who } => clients[*who].open(line.now),
            Act::Close { who } => clients[*who].close(),
            Act::Exchange => assert!(matches!(line.exchange(), Answer::Low(data) if data.len() == 2)),
            Act::Diagnosis => assert!(line.diagnosis(OWNER).is_empty()),
            Act::Restart { dp_v1: on } => {
                dp_v1 = *on;
                let mut prm = NO_WATCHDOG;
                if !on {
                    prm[7..].fill(0);
                }
                line.start(OWNER, &prm);
                // A job of the owner is forgotten, carried out or not.
                clients[0] = AcyclicClient::class_1(Duration::from_secs(600));
                model.due[0] = None;
            }
            Act::Wait { milliseconds } => line.wait(Duration::from_millis((*milliseconds).into())),
        }
        for (place, data) in &model.records {
            assert_eq!(&line.records.records[place].data, data, "{act:?}: {place:?}");
        }
        assert_eq!(line.records.runs, model.runs, "{act:?}: a job runs once");
    }
}

proptest! {
    #[test]
    fn random_masters_of_both_classes_find_what_the_reference_says(acts in prop::collection::vec(act(), 1..200)) {
        walk(&acts);
    }

    #[test]
    fn whatever_comes_the_client_goes_on(
        heard in prop::collection::vec((0..6_u8, prop::collection::vec(any::<u8>(), 0..245), 0..300_u16), 1..100),
        class_1 in any::<bool>(),
    ) {
        let patience = Duration::from_secs(2);
        let mut client = if class_1 { AcyclicClient::class_1(patience) } else { AcyclicClient::class_2(10, patience) };
        let mut now = Instant::ZERO;
        for (kind, mut data, wait) in heard {
            now = now.saturating_add(Duration::from_millis(wait.into()));
            client.open(now);
            let _busy = client.read(now, 1, 10, 240);
            if let Some(sent) = client.poll_transmit(now) {
                // Mostly a response that could be one.
                if let (Some(asked), [first, ..]) = (sent.data.first(), &mut data[..]) {
                    *first = if kind == 5 { asked | 0x80 } else { *asked };
                }
            }
            let heard = match kind {
                0 => Heard::Silence,
                1 => Heard::NotActivated,
                2 => Heard::NoResource,
                3 => Heard::Acknowledged,
                _ => Heard::Data(&data),
            };
            if let Some(Ok(AcyclicAnswer::Read(read))) = client.handle(now, heard) {
                prop_assert!(read.len() <= 240);
            }
        }
    }
}
