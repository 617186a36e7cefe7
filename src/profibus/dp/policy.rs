//! What the sources leave open, as switches (`dp-v0.md` 16).

use crate::profibus::fdl;

/// How the slave behaves where the sources are silent or contradict each other.
///
/// The default of every field is what `dp-v0.md` proposes and `docs/conformance.md` lists; with the others a
/// master is tested against the other readings. Numbers are the points of `dp-v0.md` 16.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Policy {
    /// 1: the reply to the Data_Exchange of wrong length that ends Data_Exchange.
    pub wrong_output_length: WrongOutputLength,
    /// 2: the reply to Set_Prm of another master while the slave is locked.
    pub foreign_set_prm: NoEffect,
    /// 3: the reply to Chk_Cfg in WAIT-PRM.
    pub chk_cfg_in_wait_prm: NoEffect,
    /// 3: the reply to Chk_Cfg of another master while the slave is locked.
    pub foreign_chk_cfg: NoEffect,
    /// 4: what an accepted Set_Prm of the owner does in DATA-EXCH.
    pub set_prm_in_data_exch: SetPrmInDataExch,
    /// 7: what a Set_Prm does that asks for Sync or Freeze which the slave lacks.
    pub sync_freeze_not_supported: NotSupported,
    /// 8: what WD_On with a factor of zero means.
    pub watchdog_factor_zero: WatchdogFactorZero,
    /// 8: what a min T_SDR of 1 to 10 T_bit means.
    pub short_min_tsdr: ShortMinTsdr,
    /// 9: which telegrams of the owner feed the watchdog.
    pub feeds_watchdog: FeedsWatchdog,
    /// 9: whether a broadcast Global_Control of the owner feeds the watchdog.
    pub broadcast_feeds_watchdog: bool,
    /// 9: whether a retry of the owner feeds the watchdog, if the request it repeats did.
    pub retry_feeds_watchdog: bool,
    /// 10: the reply to a Set_Slave_Add that is refused in WAIT-PRM.
    pub refused_set_slave_add: NoEffect,
    /// 10: the reply to Set_Slave_Add in WAIT-CFG and DATA-EXCH, where it never runs.
    pub late_set_slave_add: NoEffect,
    /// 12: the reply to RD_Inp and RD_Outp of a slave that has no such octets.
    pub empty_read: EmptyRead,
    /// What a slave at address 126 offers (`dp-v0.md` 2.1 and 4.1).
    pub default_address: DefaultAddress,
    /// Whether reserved bits in Set_Prm are a fault; if not, they are ignored (`dp-v0.md` 15).
    pub check_reserved_prm_bits: bool,
    /// Whether reserved bits make Global_Control ineffective; if not, they are ignored (`dp-v0.md` 15).
    pub check_reserved_control_bits: bool,
    /// Whether requests with a DSAP must come from SSAP 62, else RS (`dp-v0.md` 4).
    pub check_ssap: bool,
    /// When an accepted configuration leads to DATA-EXCH (`dp-v0.md` 7 rows 8 and 9).
    pub application_ready: ApplicationReady,
    /// 6 and 11: the station below: stored reply, Ident, LSAP status, SDA.
    pub fdl: fdl::station::Policy,
}

impl Policy {
    /// What `dp-v0.md` proposes.
    pub const PROPOSED: Self = Self {
        wrong_output_length: WrongOutputLength::NotActivated,
        foreign_set_prm: NoEffect::Acknowledged,
        chk_cfg_in_wait_prm: NoEffect::NotActivated,
        foreign_chk_cfg: NoEffect::NotActivated,
        set_prm_in_data_exch: SetPrmInDataExch::WaitCfg,
        sync_freeze_not_supported: NotSupported::GoOn,
        watchdog_factor_zero: WatchdogFactorZero::Fault,
        short_min_tsdr: ShortMinTsdr::Lengthen,
        feeds_watchdog: FeedsWatchdog::DpService,
        broadcast_feeds_watchdog: false,
        retry_feeds_watchdog: true,
        refused_set_slave_add: NoEffect::Acknowledged,
        late_set_slave_add: NoEffect::NotActivated,
        empty_read: EmptyRead::ShortAcknowledge,
        default_address: DefaultAddress::Addressing,
        check_reserved_prm_bits: true,
        check_reserved_control_bits: true,
        check_ssap: false,
        application_ready: ApplicationReady::AtOnce,
        fdl: fdl::station::Policy::PROPOSED,
    };
}

impl Default for Policy {
    fn default() -> Self {
        Self::PROPOSED
    }
}

/// The reply to a request that has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoEffect {
    /// SC: layer 2 acknowledges before DP looks.
    Acknowledged,
    /// RS: the service is closed now.
    NotActivated,
}

/// The reply to a Data_Exchange of wrong length. The slave waits for Set_Prm whichever it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WrongOutputLength {
    /// RS, like the replies to the exchanges that follow.
    NotActivated,
    /// RR: no resource for so many octets.
    NoResource,
    /// The inputs, which were ready before the outputs were seen; RS from the next one on.
    Inputs,
}

/// What an accepted Set_Prm of the owner does in DATA-EXCH.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetPrmInDataExch {
    /// The outputs are cleared and the slave waits for Chk_Cfg.
    WaitCfg,
    /// Data_Exchange goes on if the octets are those of the Set_Prm that was accepted last, else as above.
    StayIfIdentical,
}

/// What a Set_Prm does that asks for what the slave lacks. Not_Supported is set whichever it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotSupported {
    /// Everything else is taken over, the start-up goes on.
    GoOn,
    /// It is a parameter fault.
    Fault,
}

/// What WD_On with a factor of zero means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WatchdogFactorZero {
    /// A parameter fault.
    Fault,
    /// The watchdog is off.
    Off,
}

/// What a min T_SDR of 1 to 10 T_bit means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShortMinTsdr {
    /// 11 T_bit, the shortest the standard knows.
    Lengthen,
    /// A parameter fault.
    Fault,
}

/// Which telegrams of the owner feed the watchdog. It minds that the master goes on controlling the slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedsWatchdog {
    /// Services of DP that the slave carries out: Data_Exchange, Slave_Diag, Set_Prm, Chk_Cfg, reading, Global_Control
    /// to its own address. The default: the master station sends FDL status, and what nobody at the slave listens to,
    /// without its DP layer, so neither shows that the DP layer is alive. What the manuals of slave ASICs name as
    /// monitored are the services (`dp-v0.md` 8).
    DpService,
    /// Every telegram to the slave's own address, FDL status, Ident and refused requests too.
    AnyTelegram,
}

/// What a slave at address 126 offers, the address at which slaves are delivered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DefaultAddress {
    /// FDL status, Slave_Diag, Get_Cfg and Set_Slave_Add; RS to the other services. The default: 126 is for slaves
    /// that wait for an address and not for exchanging data (`dp-v0.md` 2.1), several of them may be on one line, and a
    /// master that parameterises 126 is told at once.
    Addressing,
    /// What it offers at every other address.
    Everything,
}

/// The reply to RD_Inp and RD_Outp without octets to read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmptyRead {
    /// SC.
    ShortAcknowledge,
    /// NR: no reply data ready.
    NoReplyData,
}

/// When an accepted configuration leads to DATA-EXCH.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ApplicationReady {
    /// With the acknowledge of Chk_Cfg.
    AtOnce,
    /// When the application has judged it ([`Station::judge_cfg`](super::Station::judge_cfg)). Until then
    /// Station_Not_Ready stays, and a newer Set_Prm or Chk_Cfg makes the judgement void.
    WhenJudged,
}
