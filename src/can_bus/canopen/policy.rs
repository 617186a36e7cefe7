//! Where devices and readings of CiA 301 differ, as data.

use super::abort::Abort;
use super::nmt::NmtState;
use super::pdo::PdoNumber;

/// How a node behaves where CiA 301 leaves a choice or a device deviates. [`Policy::CIA_301`] is the plain reading;
/// numbers are the doubts of `canopen-link.md` 16.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Policy {
    /// Whether segmented transfers are served; if not they are an unknown command.
    pub segmented: bool,
    /// Whether block transfers are served; if not they are an unknown command.
    pub block: bool,
    /// The answer to an unknown command and to a segment without transfer.
    pub unknown_command: Abort,
    /// The answer to a wrong number of octets.
    pub wrong_length: WrongLength,
    /// Whether an answer of four octets says their number (43h); if not its command is 42h.
    pub four_octets_say_size: bool,
    /// Whether the code of an EMCY frame has its high octet first.
    pub emcy_high_octet_first: bool,
    /// The answer to a value outside its range.
    pub out_of_range: OutOfRange,
    /// When the NMT state is checked of entries that can be written in PRE-OPERATIONAL only.
    pub state_check: StateCheck,
    /// The answer when it fails, and when a PDO has to be switched off first.
    pub wrong_state: Abort,
    /// The answer to a wrong signature in 1010h and 1011h.
    pub wrong_signature: Abort,
    /// The answer to reading 1003h beyond its count, `None` for the value 0.
    pub empty_history: Option<Abort>,
    /// What 1010h:n (save) and 1011h:n (load) read.
    pub store_reads: u32,
    /// Sub-indices of 1010h and 1011h that concern the communication objects.
    pub communication_groups: &'static [u8],
    /// When what is marked as stored is stored.
    pub storing: Storing,
    /// What 1011h does to the communication objects that are kept.
    pub load: LoadRule,
    /// Whether identifiers of 29 bits are supported.
    pub extended_ids: bool,
    /// The answer to another identifier for a PDO or EMCY that is on, `None` if that is accepted.
    pub change_while_valid: Option<Abort>,
    /// What bit 30 of 1005h (produce SYNC) does.
    pub sync_producer: SyncProducer,
    /// The types that an RPDO may map as a gap, bit n for type n.
    pub dummies: u8,
    /// 301: when a TPDO of type 0 is sent.
    pub type_0: TypeZero,
    /// 302: what sends a TPDO of type 254.
    pub type_254: EventRule,
    /// 302: what sends a TPDO of type 255.
    pub type_255: EventRule,
    /// Whether remote requests of TPDOs are answered where bit 30 allows it.
    pub tpdo_rtr: bool,
    /// What remote requests of RPDOs are answered with, if they are.
    pub rpdo_rtr: &'static [RtrAnswer],
    /// Whether values of RPDOs are held against the limits of their entry before the device sees them.
    pub rpdo_limits: bool,
    /// Whether EMCY 8210h is sent once for an RPDO that is too short.
    pub rpdo_short_emcy: bool,
    /// Whether guarding requests are answered while 100Ch or 100Dh is zero.
    pub guarding_without_times: bool,
    /// Whether guarding requests are answered while the node produces heartbeats.
    pub guarding_beside_heartbeat: bool,
    /// Whether the end of life guarding is a communication error: EMCY 8130h and 1029h. If not, only the device
    /// hears of it.
    pub life_guarding_error: ErrorControlRule,
    /// The same of the heartbeat consumer.
    pub heartbeat_error: ErrorControlRule,
    /// The reaction to a communication error of nodes without 1029h: PRE-OPERATIONAL acts in OPERATIONAL only.
    pub error_behaviour: Option<NmtState>,
}

impl Policy {
    /// CiA 301 as commonly read.
    pub const CIA_301: Self = Self {
        segmented: true,
        block: false,
        unknown_command: Abort::COMMAND,
        wrong_length: WrongLength::TooLongTooShort,
        four_octets_say_size: true,
        emcy_high_octet_first: false,
        out_of_range: OutOfRange::One(Abort::RANGE),
        state_check: StateCheck::Last,
        wrong_state: Abort::DEVICE_STATE,
        wrong_signature: Abort::TRANSFER,
        empty_history: Some(Abort::NO_DATA),
        store_reads: 1,
        communication_groups: &[1, 2],
        storing: Storing::OnCommand,
        load: LoadRule::Erase,
        extended_ids: true,
        change_while_valid: Some(Abort::DEVICE_STATE),
        sync_producer: SyncProducer::Refused,
        dummies: 0b1111_1100,
        type_0: TypeZero::OnChange,
        type_254: EventRule::CIA_301,
        type_255: EventRule::CIA_301,
        tpdo_rtr: true,
        rpdo_rtr: &[],
        rpdo_limits: true,
        rpdo_short_emcy: true,
        guarding_without_times: true,
        guarding_beside_heartbeat: false,
        life_guarding_error: ErrorControlRule { emcy: true, behaviour: true },
        heartbeat_error: ErrorControlRule { emcy: true, behaviour: true },
        error_behaviour: Some(NmtState::PreOperational),
    };
}

impl Default for Policy {
    fn default() -> Self {
        Self::CIA_301
    }
}

/// The answer to a wrong number of octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WrongLength {
    /// 06070012h or 06070013h.
    TooLongTooShort,
    /// One code for both.
    One(Abort),
}

/// The answer to a value outside its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutOfRange {
    /// 06090031h above, 06090032h below, 06090030h between two ranges.
    TooHighTooLow,
    /// One code for all.
    One(Abort),
}

/// What bit 30 of 1005h does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SyncProducer {
    /// It is refused: the node produces no SYNC.
    Refused,
    /// It is dropped.
    Dropped,
    /// The node produces SYNC with the period of 1006h. Bit 31 has no meaning.
    Produced,
}

/// When the NMT state is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateCheck {
    /// After access, before length and range.
    BeforeLength,
    /// After all other checks of the table.
    Last,
}

/// When values are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storing {
    /// With `save` to 1010h.
    OnCommand,
    /// With every write.
    OnWrite,
}

/// What 1011h does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadRule {
    /// What is kept is forgotten: the defaults come with every reset, until something is stored.
    Erase,
    /// The next reset takes the defaults; what is kept comes back with the one after it, unless stored anew.
    OnceAfterReset,
}

/// When a TPDO of type 0 is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TypeZero {
    /// After a SYNC if its data changed since it was sent last.
    OnChange,
    /// After every SYNC.
    EverySync,
}

/// What sends an event-driven TPDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EventRule {
    /// A change of its data.
    pub change: bool,
    /// Entering OPERATIONAL.
    pub on_start: bool,
    /// Whether the inhibit time holds.
    pub inhibit: bool,
}

impl EventRule {
    /// Both, under the inhibit time; the event timer besides.
    pub const CIA_301: Self = Self { change: true, on_start: true, inhibit: true };
    /// The event timer alone.
    pub const TIMER: Self = Self { change: false, on_start: false, inhibit: false };
}

/// What the failure of an error control service does besides its [`Notice`](super::Notice).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ErrorControlRule {
    /// EMCY 8130h, with bit 4 of the error register until the service is back.
    pub emcy: bool,
    /// The reaction of 1029h:1.
    pub behaviour: bool,
}

/// What a remote request of an RPDO is answered with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RtrAnswer {
    /// The RPDO.
    pub pdo: PdoNumber,
    /// Entries as in a mapping: index << 16 | sub-index << 8 | bits.
    pub mapping: &'static [u32],
}
