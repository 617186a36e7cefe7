//! DP-V1 beside a slave: sees each telegram first and answers at SAP 51, 50, 49 and the SAPs of connections.

use heapless::{Deque, Vec};

use super::alarm::MAX_BLOCK_DATA;
use super::job::{Context, Server};
use super::ms2::ResourceManager;
use super::queue::Queue;
use super::{
    ALARM_SAP, Alarm, AlarmHead, AlarmState, AlarmType, Channel, EXT_PRM_SAP, Event, Link, MAX_DATA, MS1_SAP,
    NotRaised, Obstacle, Offer, RESOURCE_MANAGER_SAP, Records, Specifier, StatusType, TypedBlock,
};
use crate::profibus::dp::dpv1_status::{self, Status1};
use crate::profibus::dp::station::Beside;
use crate::profibus::dp::{self, Application, ExtDiag, Service, Slave, State, Station};
use crate::profibus::fdl::{Reply, Request, Telegram};
use crate::time::Instant;
use crate::untold::Untold;

/// How many news wait to be taken; of more the oldest are lost.
const MAX_NEWS: usize = 8;

/// The octets of a block before its data: header, type, slot, specifier.
const BLOCK_HEAD: usize = 4;

/// The octets of Slave_Diag before the blocks.
const DIAG_HEAD: usize = 6;

/// What a slave of DP-V1 has besides one of DP-V0: up to `CONNECTIONS` masters of class 2 at once, and up to `ALARMS`
/// alarms that are not acknowledged.
///
/// ```
/// use profidrive::profibus::dp::{Description, Fixed, Station};
/// use profidrive::profibus::dpv1::{Acyclic, Job, NotDone, Offer, Records};
/// use profidrive::profibus::fdl::{Address, Framer, Resync};
/// use profidrive::time::{BaudRate, Instant};
///
/// /// Record 1 of slot 0 is one octet.
/// struct One(u8);
///
/// impl Records for One {
///     fn read(&mut self, job: &Job, out: &mut [u8]) -> Result<usize, NotDone> {
///         match (job.slot, job.index, out) {
///             (0, 1, [octet, ..]) => {
///                 *octet = self.0;
///                 Ok(1)
///             }
///             _ => Err(NotDone::refused(profidrive::profibus::dpv1::ErrorCode::INVALID_INDEX)),
///         }
///     }
///     fn write(&mut self, _: &Job, _: &[u8]) -> Result<(), NotDone> {
///         Err(NotDone::refused(profidrive::profibus::dpv1::ErrorCode::ACCESS_DENIED))
///     }
/// }
///
/// let description = Description { ident: 0x1234, dpv1_status: Some([0x80, 0, 0]), ..Description::PLAIN };
/// let application = Fixed { configurations: &[&[0x23, 0x13]], ..Fixed::PLAIN };
/// let mut station = Station::new(Address::station(5)?, BaudRate::K500, None, description, application);
/// let mut acyclic = Acyclic::<1, 4>::new(Offer { ms1: Some(240), ..Offer::NONE });
/// let mut records = One(7);
/// let mut framer = Framer::new(Resync::SCAN);
/// framer.handle_bytes(Instant::ZERO, &[0x10, 0x05, 0x02, 0x49, 0x50, 0x16], |at, result| {
///     if let Ok(telegram) = result {
///         acyclic.handle_telegram(&mut station, &mut records, at, &telegram);
///     }
/// });
/// assert!(station.poll_timeout().is_some(), "a reply is waiting");
/// # Ok::<(), profidrive::profibus::fdl::AddressError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Acyclic<const CONNECTIONS: usize, const ALARMS: usize> {
    offer: Offer,
    ms1: Server,
    alarm_sap: Server,
    connections: ResourceManager<CONNECTIONS>,
    alarms: Queue<ALARMS>,
    /// Status messages that the owner has not read, as they stand behind the header.
    messages: Deque<Vec<u8, { MAX_BLOCK_DATA + 3 }>, 4>,
    /// What the application reports besides.
    diagnosis: ExtDiag,
    /// What stands in front of it in Slave_Diag.
    front: Front,
    /// The owner has just read Slave_Diag.
    was_read: bool,
    /// MS1 is open.
    open: bool,
    /// It takes Set_Ext_Prm.
    ext_prm: bool,
    /// The parameters of Set_Ext_Prm are no blocks.
    ext_prm_fault: bool,
    news: Untold<Event, MAX_NEWS>,
}

/// The block in front of the others in Slave_Diag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Front {
    Nothing,
    Alarm(AlarmHead),
    Message,
}

impl<const CONNECTIONS: usize, const ALARMS: usize> Acyclic<CONNECTIONS, ALARMS> {
    /// What a slave offers that has just been switched on.
    pub const fn new(offer: Offer) -> Self {
        Self {
            offer,
            ms1: Server::IDLE,
            alarm_sap: Server::IDLE,
            connections: ResourceManager::NEW,
            alarms: Queue::NONE,
            messages: Deque::new(),
            diagnosis: ExtDiag::NONE,
            front: Front::Nothing,
            was_read: false,
            open: false,
            ext_prm: false,
            ext_prm_fault: false,
            news: Untold::new(),
        }
    }

    /// The same slave that takes blocks of parameters at SAP 53, too (Set_Ext_Prm), behind Set_Prm and before Chk_Cfg.
    #[must_use]
    pub const fn with_ext_prm(mut self) -> Self {
        self.ext_prm = true;
        self
    }

    /// What it offers.
    pub const fn offer(&self) -> &Offer {
        &self.offer
    }

    /// Whether the owner can read and write records now.
    pub const fn is_open(&self) -> bool {
        self.open
    }

    /// Whether a request of the owner is being carried out.
    pub const fn is_busy(&self) -> bool {
        self.ms1.is_busy()
    }

    /// The connections that are open.
    pub fn links(&self) -> impl Iterator<Item = Link> {
        self.connections.links()
    }

    /// The alarms that are not acknowledged.
    pub fn alarms(&self) -> &[Alarm] {
        self.alarms.alarms()
    }

    /// What a master has to do first before it can use MS1, and the alarms that wait for it.
    pub(crate) fn each_obstacle<A: Application>(&self, slave: &Slave<A>, tell: &mut dyn FnMut(Obstacle)) {
        if self.offer.ms1.is_some() || self.offer.alarms.types != 0 {
            match slave.state() {
                State::DataExch if is_enabled(slave) => {}
                State::DataExch => tell(Obstacle::NotEnabled),
                state @ (State::WaitPrm | State::WaitCfg) => tell(Obstacle::NoExchange(state)),
            }
        }
        for alarm in self.alarms() {
            tell(match alarm.state {
                AlarmState::Pending => Obstacle::AlarmNotRead(alarm.head),
                AlarmState::Delivered => Obstacle::AlarmNotAcknowledged(alarm.head),
            });
        }
    }

    /// Takes a telegram for `station` whose last octet ended at `now`.
    pub fn handle_telegram<A: Application, R: Records>(
        &mut self,
        station: &mut Station<A>,
        records: &mut R,
        now: Instant,
        telegram: &Telegram<'_>,
    ) -> dp::Outcome {
        let outcome = station.handle_beside(now, telegram, &mut Serving { acyclic: self, records });
        if core::mem::take(&mut self.ext_prm_fault) {
            station.reject_prm();
        }
        self.follow(station);
        outcome
    }

    /// Time has passed.
    pub fn handle_timeout<A: Application>(
        &mut self,
        station: &mut Station<A>,
        now: Instant,
    ) -> Option<dp::Event> {
        while let Some(event) = self.connections.handle_timeout(now) {
            self.news.push(event);
        }
        let event = station.handle_timeout(now);
        self.follow(station);
        event
    }

    /// When to call [`Acyclic::handle_timeout`], besides [`Station::poll_timeout`].
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        self.connections.poll_timeout()
    }

    /// The oldest news not taken yet.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<Event> {
        self.news.pop()
    }

    /// Files what the application reports; in place of [`Station::file_diagnosis`].
    pub fn file_diagnosis<A: Application>(&mut self, station: &mut Station<A>, diagnosis: &ExtDiag) {
        self.diagnosis = *diagnosis;
        station.file_diagnosis(&self.reported());
    }

    /// Raises an alarm. The owner reads it with its next Slave_Diag and acknowledges it.
    ///
    /// # Errors
    /// [`NotRaised`]
    pub fn raise<A: Application>(
        &mut self,
        station: &mut Station<A>,
        kind: AlarmType,
        (slot, specifier, additional_ack): (u8, Specifier, bool),
        data: &[u8],
    ) -> Result<AlarmHead, NotRaised> {
        if station.slave().state() != State::DataExch {
            return Err(NotRaised::NoExchange);
        }
        fits(station.slave(), data)?;
        let status = dpv1_status::octets(station.slave().user_prm());
        let alarm = (kind, slot, specifier, additional_ack);
        let head = self.alarms.raise(&self.offer.alarms, status, alarm, data)?;
        self.put_in_front(station);
        Ok(head)
    }

    /// Forgets every alarm, as if none had been raised.
    pub(crate) fn forget_alarms<A: Application>(&mut self, station: &mut Station<A>) {
        self.alarms.forget();
        if matches!(self.front, Front::Alarm(_)) {
            self.front = Front::Nothing;
            self.put_in_front(station);
            station.replace_diagnosis(&self.reported());
        }
    }

    /// Sends a status message, which nobody acknowledges, with the next Slave_Diag of the owner.
    ///
    /// # Errors
    /// [`NotRaised::NoExchange`], [`NotRaised::NotEnabled`], [`NotRaised::TooLong`]; [`NotRaised::Limit`] if some wait already.
    pub fn send_status<A: Application>(
        &mut self,
        station: &mut Station<A>,
        kind: StatusType,
        slot: u8,
        specifier: Specifier,
        data: &[u8],
    ) -> Result<(), NotRaised> {
        let slave = station.slave();
        if slave.state() != State::DataExch {
            return Err(NotRaised::NoExchange);
        }
        if !is_enabled(slave) {
            return Err(NotRaised::NotEnabled);
        }
        fits(slave, data)?;
        let mut buf = [0; MAX_BLOCK_DATA + 3];
        let block = TypedBlock::Status { kind, slot, specifier, data };
        let octets = block.encode(&mut buf).and_then(|octets| Vec::from_slice(octets).ok());
        let octets = octets.ok_or(NotRaised::TooLong { got: data.len(), most: MAX_BLOCK_DATA })?;
        let waiting = super::queue::Many(self.messages.len());
        self.messages.push_back(octets).map_err(|_| NotRaised::Limit(waiting))?;
        self.put_in_front(station);
        Ok(())
    }

    /// What the telegram or the time did to the slave.
    fn follow<A: Application>(&mut self, station: &mut Station<A>) {
        let open = is_open(station.slave());
        if self.open && !open {
            self.ms1.reset();
            self.alarm_sap.reset();
            self.alarms.forget();
            self.messages.clear();
            self.front = Front::Nothing;
            station.replace_diagnosis(&self.reported());
        }
        self.open = open;
        if core::mem::take(&mut self.was_read) {
            match core::mem::replace(&mut self.front, Front::Nothing) {
                Front::Nothing => return,
                Front::Alarm(_) => {
                    if let (Some(alarm), Some(master)) = (self.alarms.deliver(), station.slave().owner()) {
                        self.news.push(Event::AlarmDelivered { master, alarm });
                    }
                }
                Front::Message => {
                    self.messages.pop_front();
                }
            }
            // What was read leaves the diagnosis without a word.
            station.replace_diagnosis(&self.reported());
            self.put_in_front(station);
        }
    }

    /// The next alarm or message goes in front of the diagnosis, if nothing is there.
    fn put_in_front<A: Application>(&mut self, station: &mut Station<A>) {
        if self.front != Front::Nothing {
            return;
        }
        self.front = match self.alarms.pending() {
            Some((head, _)) => Front::Alarm(head),
            None if self.messages.is_empty() => return,
            None => Front::Message,
        };
        station.file_diagnosis(&self.reported());
    }

    /// The diagnosis with what is in front of it.
    fn reported(&self) -> ExtDiag {
        let mut buf = [0; MAX_BLOCK_DATA + 3];
        let (block, fault) = match (self.front, self.alarms.pending()) {
            (Front::Alarm(head), Some((_, block))) => (block.encode(&mut buf), head.specifier.disturbs()),
            (Front::Message, _) => (self.messages.front().map(Vec::as_slice), false),
            (Front::Alarm(_), None) | (Front::Nothing, _) => (None, false),
        };
        block.and_then(|block| self.diagnosis.behind(block, fault).ok()).unwrap_or(self.diagnosis)
    }

    fn serve<A: Application, R: Records>(
        &mut self,
        now: Instant,
        slave: &Slave<A>,
        request: &Request<'_>,
        records: &mut R,
    ) -> Option<Reply<'_>> {
        let is_owner = slave.owner() == Some(request.sa);
        let sap = request.dsap?.number();
        if Service::of(request.dsap, request.ssap) == Some(Service::SlaveDiag) {
            self.was_read = is_owner && request.data.is_empty();
            return None;
        }
        let Offer { ms1, ms2, alarms } = self.offer;
        let channel = match sap {
            MS1_SAP if ms1.is_some() || alarms.types != 0 => Channel::Ms1,
            ALARM_SAP if alarms.extra_sap => Channel::Alarms,
            EXT_PRM_SAP if self.ext_prm => {
                if !is_owner || slave.state() != State::WaitCfg {
                    return None;
                }
                let wrong = match request.data {
                    [] => Some(0),
                    blocks => dpv1_status::first_wrong_block(blocks).and_then(|at| u8::try_from(at).ok()),
                };
                self.ext_prm_fault = wrong.is_some();
                let len = u8::try_from(request.data.len()).unwrap_or(u8::MAX);
                let event = Event::ExtPrm { master: request.sa, len, wrong };
                self.news.push(event);
                return Some(Reply::ShortAcknowledge);
            }
            RESOURCE_MANAGER_SAP => {
                let (reply, event) = self.connections.ask(now, &ms2?, request);
                self.news.extend(event);
                return Some(reply);
            }
            ..RESOURCE_MANAGER_SAP => {
                let (reply, event) = self.connections.serve(now, &ms2?, request, records)?;
                self.news.extend(event);
                return Some(reply);
            }
            _ => return None,
        };
        if !(is_owner && is_open(slave)) {
            return None;
        }
        let Self { ms1: server, alarm_sap, alarms: queue, news, .. } = self;
        let mut context = Context {
            master: request.sa,
            channel,
            max_data: ms1.unwrap_or(MAX_DATA),
            now,
            records,
            acknowledge: &mut |ack| queue.acknowledge(ack),
        };
        let server = if channel == Channel::Alarms { alarm_sap } else { server };
        let (fdl, event) = server.take(request.data, &mut context);
        news.extend(event);
        Some(server.reply(fdl))
    }
}

/// Set_Prm enabled DP-V1.
fn is_enabled<A: Application>(slave: &Slave<A>) -> bool {
    let [one, ..] = dpv1_status::octets(slave.user_prm());
    Status1::Enable.is_set(one)
}

/// The owner has its channel.
fn is_open<A: Application>(slave: &Slave<A>) -> bool {
    slave.state() == State::DataExch && is_enabled(slave)
}

/// Whether a block with this data fits in Slave_Diag.
fn fits<A: Application>(slave: &Slave<A>, data: &[u8]) -> Result<(), NotRaised> {
    let room = usize::from(slave.description().max_diag_len).saturating_sub(DIAG_HEAD + BLOCK_HEAD);
    let most = room.min(MAX_BLOCK_DATA);
    if data.len() > most { Err(NotRaised::TooLong { got: data.len(), most }) } else { Ok(()) }
}

/// Acyclic services and what is in the records, while a telegram is handled.
struct Serving<'a, R, const CONNECTIONS: usize, const ALARMS: usize> {
    acyclic: &'a mut Acyclic<CONNECTIONS, ALARMS>,
    records: &'a mut R,
}

impl<A: Application, R: Records, const CONNECTIONS: usize, const ALARMS: usize> Beside<A>
    for Serving<'_, R, CONNECTIONS, ALARMS>
{
    fn serve(&mut self, now: Instant, slave: &Slave<A>, request: &Request<'_>) -> Option<Reply<'_>> {
        self.acyclic.serve(now, slave, request, self.records)
    }
}
