//! Services of DP-V1: any octets as PDUs, blocks of alarms and requests of parameters, and any requests of several masters at any
//! SAP of a slave: what is read is written back the same; a response is a PDU and one to what was asked last; a repeated telegram
//! has the same reply and runs nothing twice; nobody but the owner is served at SAP 51 and 50; the records keep their lengths. And
//! the master's end: whatever a slave answers, it goes on.

use std::time::Duration;

use profidrive::client::{AcyclicAnswer, AcyclicClient, Heard, ParameterRequest};
use profidrive::profibus::dp::{Description, Fixed, State, Station};
use profidrive::profibus::dpv1::base_mode::{Attribute, Head, ParameterAddress, Values};
use profidrive::profibus::dpv1::{
    Acyclic, AlarmOffer, AlarmType, ErrorCode, Job, MAX_PDU, Ms2Offer, NotDone, Offer, Records, RequestPdu,
    ResponsePdu, Specifier, TypedBlock,
};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, ReplyStatus, Sap, Service, Telegram,
};
use profidrive::time::{BaudRate, Instant};

const OWNER: u8 = 2;
const PRM: [u8; 10] = [0x80, 1, 1, 11, 0xC0, 0xDE, 0, 0x80, 0xFC, 0x01];

pub(crate) fn check(octets: &[u8]) {
    let Some((kind, rest)) = octets.split_first() else { return };
    match kind % 4 {
        0 => codec(rest),
        1 | 2 => slave(rest),
        _ => client(rest),
    }
}

fn codec(octets: &[u8]) {
    let mut buf = [0xA5; 300];
    if let Ok(pdu) = RequestPdu::parse(octets)
        && let Some(again) = pdu.encode(&mut buf)
    {
        assert_eq!(RequestPdu::parse(again), Ok(pdu));
    }
    if let Ok(pdu) = ResponsePdu::parse(octets)
        && let Some(again) = pdu.encode(&mut buf)
    {
        assert_eq!(ResponsePdu::parse(again), Ok(pdu));
    }
    if let Some(block) = TypedBlock::parse(octets) {
        let again = block.encode(&mut buf).expect("room for a block");
        assert_eq!(TypedBlock::parse(again), Some(block));
    }
    if let Some((values, behind)) = Values::split(octets) {
        assert!(behind.len() < octets.len());
        let again = values.encode(&mut buf);
        assert!(again.is_none_or(|again| Values::split(again) == Some((values, &[][..]))));
    }
    let address = ParameterAddress { attribute: Attribute::Value, elements: 0, pnu: 1, subindex: 0 };
    if let Some((Head { parameters: count @ 1..=39, .. }, _)) = Head::of_response(octets) {
        let request =
            ParameterRequest::read(octets[0], octets[2], &vec![address; count.into()]).expect("not too many");
        if let Ok(results) = request.results(octets) {
            assert_eq!(results.count(), usize::from(count));
        }
    }
}

/// Records whose lengths stay.
struct Table {
    /// Slot, index, octets.
    records: [(u8, u8, Vec<u8>); 3],
    runs: usize,
}

impl Table {
    fn record(&mut self, job: &Job) -> Result<&mut Vec<u8>, NotDone> {
        let is_it = |(slot, index, _): &&mut (u8, u8, Vec<u8>)| (*slot, *index) == (job.slot, job.index);
        let found = self.records.iter_mut().find(is_it);
        found.map(|(_, _, record)| record).ok_or(NotDone::refused(ErrorCode::INVALID_INDEX))
    }
}

impl Records for Table {
    fn read(&mut self, job: &Job, out: &mut [u8]) -> Result<usize, NotDone> {
        let record = self.record(job)?;
        if job.slot == 2 && job.now.saturating_since(job.since) < Duration::from_millis(30) {
            return Err(NotDone::Yet);
        }
        let len = record.len();
        out[..len].copy_from_slice(record);
        self.runs += 1;
        Ok(len)
    }

    fn write(&mut self, job: &Job, data: &[u8]) -> Result<(), NotDone> {
        let record = self.record(job)?;
        if record.len() != data.len() {
            return Err(NotDone::refused(ErrorCode::WRITE_LENGTH));
        }
        record.copy_from_slice(data);
        self.runs += 1;
        Ok(())
    }
}

struct Line {
    station: Station<Fixed<'static>>,
    acyclic: Acyclic<3, 4>,
    table: Table,
    now: Instant,
}

impl Line {
    fn new() -> Self {
        let device = Description {
            ident: 0xC0DE,
            dpv1_status: Some([0xFB, 0xFF, 0xFF]),
            max_diag_len: 244,
            ..Description::PLAIN
        };
        let application = Fixed { configurations: &[&[0x31]], ..Fixed::PLAIN };
        let offer = Offer {
            ms1: Some(64),
            ms2: Some(Ms2Offer { connections: 3, max_data: 200, max_initiate: 52, min_send_timeout: 10 }),
            alarms: AlarmOffer { types: 0xFC, sequence: 4, extra_sap: true },
        };
        let address = Address::station(7).expect("an address");
        let records = [(1, 1), (1, 240), (2, 8)].map(|(slot, len)| (slot, len, vec![0; len.into()]));
        Self {
            station: Station::new(address, BaudRate::K1500, None, device, application),
            acyclic: Acyclic::new(offer),
            table: Table { records, runs: 0 },
            now: Instant::from_millis(1),
        }
    }

    fn wait(&mut self, time: Duration) {
        let end = self.now.saturating_add(time);
        loop {
            let due = Instant::first_of(self.station.poll_timeout(), self.acyclic.poll_timeout());
            let Some(due) = due.filter(|due| *due <= end) else { break };
            self.now = self.now.max(due);
            let _told = self.acyclic.handle_timeout(&mut self.station, self.now);
            let _reply = self.station.poll_transmit(self.now);
        }
        self.now = end;
        while self.acyclic.poll_event().is_some() {}
    }

    /// The reply to a telegram.
    fn send(&mut self, telegram: &Telegram<'_>) -> Option<Vec<u8>> {
        self.wait(Duration::from_millis(1));
        let _outcome = self.acyclic.handle_telegram(&mut self.station, &mut self.table, self.now, telegram);
        let due = self.station.poll_timeout()?;
        let reply = self.station.poll_transmit(due).ok().flatten().map(<[u8]>::to_vec);
        self.now = self.now.max(due);
        reply
    }
}

/// What a telegram says; its octets are the business of the target `telegram`.
fn telegram(sa: u8, (dsap, ssap): (u8, u8), fc: FunctionCode, data: &[u8]) -> Telegram<'_> {
    let (dsap, ssap) = (Sap::new(dsap), Sap::new(ssap));
    Telegram::Data(DataTelegram {
        format: DataTelegram::customary_format(dsap, ssap, data),
        da: Address::from_octet(7),
        sa: Address::from_octet(sa),
        dsap,
        ssap,
        fc,
        data,
    })
}

/// Operations: what and by whom, how many octets, the octets.
fn slave(mut rest: &[u8]) {
    let mut line = Line::new();
    let mut odd = [false; 4];
    // By master and SAP.
    let mut asked = [[None; 64]; 4];
    while let [operation, len, tail @ ..] = rest {
        let (data, behind) = tail.split_at((usize::from(*len) % 245).min(tail.len()));
        rest = behind;
        let who = operation >> 3 & 3;
        let (master, repeats) = (OWNER + who, operation >> 5 & 1);
        line.wait(Duration::from_millis(u64::from(operation >> 6) * 40));
        let (dsap, data): (u8, &[u8]) = match operation & 7 {
            0 => (51, data),
            1 => (50, data),
            2 => (49, data),
            3 => (48 - len % 4, data),
            4 => (len % 50, data),
            5 => (61, &PRM),
            6 => (62, &[0x31]),
            _ => {
                let kind = AlarmType::numbered(*len);
                let _may_not_come =
                    line.acyclic.raise(&mut line.station, kind, (1, Specifier::Appears, false), data);
                (60, &[])
            }
        };
        let ssap = match dsap {
            51 | 50 => 51,
            60.. => 62,
            _ => 50,
        };
        let odd = &mut odd[usize::from(who)];
        *odd = !*odd;
        let count = if *odd { FrameCount::Odd } else { FrameCount::Even };
        let request = telegram(master, (dsap, ssap), FunctionCode::request(Service::SrdLow, count), data);
        let was_owner = line.station.slave().owner() == Some(Address::from_octet(master));
        let reply = line.send(&request);
        let runs = line.table.runs;
        for _ in 0..repeats {
            assert_eq!(line.send(&request), reply, "a repeated telegram has the same reply");
            assert_eq!(line.table.runs, runs, "and runs nothing");
        }
        let reply = reply.expect("an SRD to this address has a reply");
        let Decoded::Telegram { telegram, len } = decode(&reply) else { panic!("{reply:02X?}") };
        assert_eq!(len, reply.len());
        if dsap > 51 {
            continue;
        }
        if telegram == Telegram::ShortAcknowledge
            && let [first, ..] = data
        {
            asked[usize::from(who)][usize::from(dsap)] = Some(*first);
        }
        if let Telegram::Data(reply) = telegram {
            let is_response = reply.fc == FunctionCode::response(ReplyStatus::DataLow);
            assert!(is_response || reply.data.is_empty(), "{reply:?}");
            if dsap >= 50 {
                assert!(!is_response || was_owner && line.station.slave().state() == State::DataExch);
            }
            if is_response {
                assert!(data.is_empty(), "a request is never answered in its own reply");
                assert!(reply.data.len() <= MAX_PDU);
                let response = ResponsePdu::parse(reply.data);
                let asked = asked[usize::from(who)][usize::from(dsap)];
                let function = reply.data[0] & 0x7F;
                let fits = match response {
                    Ok(
                        ResponsePdu::ResourceManager { .. }
                        | ResponsePdu::Initiate(_)
                        | ResponsePdu::Abort(_),
                    ) => true,
                    Ok(_) => asked.is_some_and(|asked| asked & 0x7F == function),
                    // Of a function number that is none, the refusal has the same number.
                    Err(_) => {
                        matches!(*reply.data, [0x80..=0xFF, 0x80, 0xA9, 0])
                            && asked.is_some_and(|asked| asked & 0x7F == function)
                    }
                };
                assert!(fits, "asked {asked:02X?}, {response:?}");
            }
        }
        assert!(line.acyclic.alarms().len() <= 4);
    }
    for (_, len, record) in &line.table.records {
        assert_eq!(record.len(), usize::from(*len));
    }
}

/// The master's end, to which a slave says anything.
fn client(rest: &[u8]) {
    let Some((class, mut rest)) = rest.split_first() else { return };
    let patience = Duration::from_secs(1);
    let mut client =
        if class % 2 == 0 { AcyclicClient::class_1(patience) } else { AcyclicClient::class_2(10, patience) };
    let mut now = Instant::ZERO;
    while let [kind, len, tail @ ..] = rest {
        let (data, behind) = tail.split_at(usize::from(*len).min(tail.len()));
        rest = behind;
        now = now.saturating_add(Duration::from_millis((kind >> 4).into()));
        match kind >> 3 & 1 {
            0 => client.open(now),
            _ => {
                let _busy = client.write(now, 1, *len, &data[..data.len().min(240)]);
            }
        }
        let _busy = client.read(now, 1, 10, 240);
        if let Some(sent) = client.poll_transmit(now) {
            assert!(sent.dsap <= 51 && sent.data.len() <= MAX_PDU);
            assert!(sent.data.is_empty() || RequestPdu::parse(sent.data).is_ok());
        }
        let heard = match kind & 7 {
            0 => Heard::Silence,
            1 => Heard::NotActivated,
            2 => Heard::NoResource,
            3 => Heard::Acknowledged,
            _ => Heard::Data(data),
        };
        if let Some(Ok(AcyclicAnswer::Read(read))) = client.handle(now, heard) {
            assert!(read.len() <= 240);
        }
    }
}
