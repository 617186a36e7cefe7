//! The rows: what is required of a DP master, as data.
//!
//! One row of the table is one requirement (`docs/reference/dp-master.md`). [`Row`] names it in code, [`Row::about`] says
//! what it is.

use super::play::Ending;
pub use crate::judge::requirement::Confidence;
use crate::judge::requirement::Requirement;

/// Where a row can be judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    /// On any link.
    Pty,
    /// On any link, with a wide margin of time.
    Margin,
    /// On a real line that shows parity and pauses.
    Serial,
    /// In virtual time, to the bit time.
    Virtual,
    /// With somebody who operates the master.
    Ask,
}

/// What a row is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the titles say it")]
pub enum Group {
    Framing,
    Timing,
    Token,
    FrameCount,
    StartUp,
    Contents,
    DataExchange,
    Diagnosis,
    Modes,
    SyncFreeze,
    Loss,
    BadReplies,
    Several,
    SecondMaster,
    Rates,
    Stop,
    Acyclic,
}

impl Group {
    /// Its title.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Framing => "Framing",
            Self::Timing => "Timing",
            Self::Token => "Token and GAP",
            Self::FrameCount => "Frame count bit and retries",
            Self::StartUp => "Start-up of a slave",
            Self::Contents => "Set_Prm and Chk_Cfg",
            Self::DataExchange => "Data exchange",
            Self::Diagnosis => "Diagnosis",
            Self::Modes => "Operating modes, Global_Control",
            Self::SyncFreeze => "Sync, Freeze",
            Self::Loss => "Slave lost, returned, reset, taken by another master",
            Self::BadReplies => "Bad replies",
            Self::Several => "Several slaves",
            Self::SecondMaster => "Second master",
            Self::Rates => "Rates",
            Self::Stop => "Stop and power off",
            Self::Acyclic => "Services of DP-V1",
        }
    }
}

/// What is known of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct About {
    /// `M-C03`.
    pub id: &'static str,
    /// What it is about.
    pub group: Group,
    /// 1: mandatory, 2: expected of any master, 3: good practice.
    pub priority: u8,
    /// How sure the sources are.
    pub confidence: Confidence,
    /// Where it can be judged.
    pub places: &'static [Place],
    /// The requirement.
    pub text: &'static str,
}

macro_rules! rows {
    ($($row:ident $id:literal $group:ident $priority:literal $confidence:ident [$($place:ident),*] $text:literal)*) => {
        /// A requirement of the table.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[expect(missing_docs, reason = "`Row::about` says what each is")]
        pub enum Row { $($row,)* }

        impl Row {
            /// Every row, in the order of the table.
            pub const ALL: &'static [Self] = &[$(Self::$row,)*];

            /// What is known of it.
            pub const fn about(self) -> &'static About {
                match self {
                    $(Self::$row => &About {
                        id: $id,
                        group: Group::$group,
                        priority: $priority,
                        confidence: Confidence::$confidence,
                        places: &[$(Place::$place),*],
                        text: $text,
                    },)*
                }
            }
        }
    };
}

rows! {
    F01 "M-F01" Framing 1 B [Pty]
        "the stream consists of SD1, SD2, SD3, SD4 telegrams and nothing between; a master answers with SD1 (FDL status) and never sends SC as initiator"
    F02 "M-F02" Framing 1 B [Pty]
        "FCS right"
    F03 "M-F03" Framing 1 B [Pty]
        "SD2: LE = LEr, 4..249, second 68; ED 16; complete"
    F04 "M-F04" Framing 1 B [Pty]
        "SA is the master's one address 0..125 in every telegram; DA 0..126, 127 only with SDN; no request to itself (token to itself excepted)"
    F05 "M-F05" Framing 1 B [Pty]
        "SRD (0xC or 0xD) for MS0 services and Data_Exchange, SDN (4 or 6) for Global_Control, 9 for FDL status; b7 = 0, b6 = 1"
    F06 "M-F06" Framing 1 B [Pty]
        "SAPs: 62 to 60, 61, 62, 59, 58 (55, 56, 57 optional); both extension bits; Data_Exchange has none"
    F07 "M-F07" Framing 2 B [Pty]
        "no PDU: SD1 (LE = 3 does not exist); 8-octet PDU: SD2 or SD3, both are right"
    F08 "M-F08" Framing 1 B [Pty]
        "PDU at most 246 octets with SAPs, 244 user octets"
    F09 "M-F09" Framing 1 B [Serial, Virtual]
        "no pause between the characters of a telegram"
    F10 "M-F10" Framing 1 B [Serial]
        "even parity, one stop bit, rate within 0.3 %"
    F11 "M-F11" Framing 2 A [Pty, Serial]
        "never longer than 255 octets without a pause, line released after sending"
    T01 "M-T01" Timing 1 A [Serial, Virtual]
        "at least 33 T_bit (T_SYN) of idle line before every request and token"
    T02 "M-T02" Timing 1 A [Pty]
        "one request at a time: nothing is sent until the reply is complete or the slot time is over"
    T03 "M-T03" Timing 1 A [Margin, Virtual]
        "a reply that starts within the slot time is accepted"
    T04 "M-T04" Timing 2 A [Margin, Virtual]
        "after an unanswered request the master goes on soon after T_SL"
    T05 "M-T05" Timing 2 B [Virtual]
        "T_ID1 after a reply or token: max(T_QUI + 2 T_SET + 2 + T_SYN, min T_SDR)"
    T06 "M-T06" Timing 2 B [Serial, Virtual]
        "T_ID2 after SDN (Global_Control): the same with max T_SDR. 33 T_bit alone is too short when max T_SDR is longer"
    T07 "M-T07" Timing 1 B [Virtual]
        "T_SL >= max T_SDR of every slave + 15 T_bit"
    T08 "M-T08" Timing 1 B [Pty]
        "a slave in data exchange hears from its owner well before its watchdog ends"
    T09 "M-T09" Timing 2 U [Margin]
        "Set_Prm factors fit the cycle: T_WD at least 3 DP cycles"
    K01 "M-K01" Token 2 B [Pty]
        "a lone master claims the token (SD4 to itself, twice) and passes it to itself each rotation"
    K02 "M-K02" Token 1 A [Pty]
        "SD4 only to itself or to a station that reported 'ready' or 'in ring'"
    K03 "M-K03" Token 2 A [Pty]
        "at most one GAP address per token receipt"
    K04 "M-K04" Token 2 A [Pty]
        "GAP = addresses between own and next station; ascending; after HSA goes on at 0; nothing above HSA"
    K05 "M-K05" Token 2 A [Margin]
        "GAP cycles are spaced by the GAP factor (G x T_TR)"
    K06 "M-K06" Token 2 A [Pty]
        "an unanswered GAP poll is not repeated"
    K07 "M-K07" Token 1 B [Serial, Virtual]
        "before it sends anything a master listens for T_TO = T_SL (6 + 2 address)"
    K08 "M-K08" Token 1 A [Pty]
        "T_TH: data traffic and GAP do not block each other permanently"
    C01 "M-C01" FrameCount 1 A [Pty]
        "the first request to a station: FCV = 0, FCB = 1"
    C02 "M-C02" FrameCount 1 A [Pty]
        "then FCV = 1 and FCB toggles with each confirmed cycle, over all services of one station"
    C03 "M-C03" FrameCount 1 A [Pty]
        "a retry keeps the FCB"
    C04 "M-C04" FrameCount 1 A [Pty]
        "a retry repeats the telegram octet by octet (newer outputs under the old FCB are lost: a slave takes the frame for a repetition)"
    C05 "M-C05" FrameCount 2 B [Pty]
        "at least one retry before a slave counts as lost (max_retry_limit >= 1; some masters offer 0 for Data_Exchange)"
    C06 "M-C06" FrameCount 1 A [Pty]
        "retries end after max_retry_limit (1..15 in practice)"
    C07 "M-C07" FrameCount 1 A [Pty]
        "after that the station is 'non operational': the next request again FCV = 0, FCB = 1"
    C08 "M-C08" FrameCount 1 A [Pty]
        "one FCB per station"
    C09 "M-C09" FrameCount 1 B [Pty]
        "FCV = 0, FCB = 0 in SDN, FDL status"
    C10 "M-C10" FrameCount 2 A [Pty]
        "a non-operational station is asked once, without retries, until it answers"
    C11 "M-C11" FrameCount 2 A [Pty]
        "a first cycle (FCV = 0) is not repeated as a retry"
    C12 "M-C12" FrameCount 1 A [Pty]
        "a corrupt reply is answered with a retry, like a missing one"
    U01 "M-U01" StartUp 1 A [Pty]
        "Slave_Diag answered before Set_Prm (otherwise the master does not see Master_Lock)"
    U02 "M-U02" StartUp 1 B [Pty]
        "Chk_Cfg only after an acknowledged Set_Prm"
    U03 "M-U03" StartUp 1 B [Pty]
        "Data_Exchange only after an acknowledged Chk_Cfg since the last Set_Prm"
    U04 "M-U04" StartUp 1 B [Pty]
        "Slave_Diag answered between Chk_Cfg and the first Data_Exchange (SC says nothing about acceptance)"
    U05 "M-U05" StartUp 1 B [Pty]
        "Station_Not_Ready: Slave_Diag is repeated, no Data_Exchange"
    U06 "M-U06" StartUp 2 B [Pty, Virtual]
        "the master waits: no new Set_Prm only because the slave is not ready yet (up to some seconds)"
    U07 "M-U07" StartUp 2 U [Pty]
        "ident number in the diagnosis differs: no Data_Exchange, error to the user"
    U08 "M-U08" StartUp 1 B [Pty]
        "RS (or another negative answer) to Set_Prm or Chk_Cfg is no success: back to Slave_Diag"
    U09 "M-U09" StartUp 1 A [Pty]
        "a slave that does not answer Set_Prm or Chk_Cfg: retries, then from the start"
    U10 "M-U10" StartUp 1 A [Pty]
        "user outputs never reach a slave before OPERATE: zeros (or empty, Fail_Safe) in CLEAR at start"
    U11 "M-U11" StartUp 2 U [Pty]
        "each start-up is complete, also the tenth"
    U12 "M-U12" StartUp 1 A [Pty]
        "Set_Prm, Chk_Cfg, Data_Exchange only to configured stations"
    P01 "M-P01" Contents 1 A [Pty]
        "start-up: Lock_Req = 1, Unlock_Req = 0"
    P02 "M-P02" Contents 1 A [Pty]
        "WD_On: both factors 1..255"
    P03 "M-P03" Contents 1 A [Pty]
        "T_WD = 10 ms x f1 x f2 (1 ms base only with DPV1_Status_1.2) is what was configured, rounded up, by 30 % at most"
    P04 "M-P04" Contents 1 B [Pty]
        "reserved bits 2..0 of octet 1 are 0 (ASICs refuse otherwise)"
    P05 "M-P05" Contents 1 A [Pty]
        "Ident_Number as configured, high octet first"
    P06 "M-P06" Contents 1 A [Pty]
        "min T_SDR 0 (keep) or 11..max T_SDR"
    P07 "M-P07" Contents 1 A [Pty]
        "7 octets + exactly the User_Prm_Data of the GSD"
    P08 "M-P08" Contents 1 A [Pty]
        "their content as configured"
    P09 "M-P09" Contents 1 A [Pty]
        "Group_Ident as configured"
    P10 "M-P10" Contents 2 B [Pty]
        "Sync_Req, Freeze_Req only if the GSD offers them"
    P11 "M-P11" Contents 2 B [Pty]
        "watchdog on by default"
    P12 "M-P12" Contents 1 A [Pty]
        "the same content in each start-up (until the user changes it)"
    P13 "M-P13" Contents 2 B [Pty]
        "DPV1 octets only for DPV1_Slave = 1"
    G01 "M-G01" Contents 1 A [Pty]
        "Chk_Cfg: identifiers as configured, in slot order, nothing more"
    G02 "M-G02" Contents 1 B [Pty]
        "Data_Exchange lengths are those of the identifiers sent"
    G03 "M-G03" Contents 2 A [Pty]
        "special formats and 244 octets of configuration work"
    X01 "M-X01" DataExchange 1 B [Pty]
        "exactly the configured number of output octets (exception: M-O06)"
    X02 "M-X02" DataExchange 2 B [Pty]
        "SRD high; low is tolerated"
    X03 "M-X03" DataExchange 1 B [Pty]
        "every slave in data exchange is polled in every cycle as long as nothing is wrong"
    X04 "M-X04" DataExchange 1 A [Ask]
        "the outputs are those of the user, for this slave, all of the same time"
    X05 "M-X05" DataExchange 1 B [Pty]
        "input-only slave: SRD without PDU (SD1)"
    X06 "M-X06" DataExchange 1 B [Pty]
        "output-only slave: SC is a good reply"
    X07 "M-X07" DataExchange 2 B [Pty]
        "8-octet reply accepted as SD2 and as SD3"
    X08 "M-X08" DataExchange 1 B [Pty]
        "244 octets each way work"
    X09 "M-X09" DataExchange 2 A [Ask]
        "outputs consistent within an identifier at full rate"
    D01 "M-D01" Diagnosis 1 B [Pty]
        "a high-priority reply (DH) leads to Slave_Diag of that slave: next cycle as a rule"
    D02 "M-D02" Diagnosis 1 B [Pty]
        "Prm_Req in a diagnosis read during data exchange: new start-up, at latest after the next RS"
    D03 "M-D03" Diagnosis 1 B [Pty]
        "Stat_Diag: the diagnosis is read until the bit is cleared; before the first Data_Exchange that means waiting"
    D04 "M-D04" Diagnosis 1 B [Pty]
        "Prm_Fault: no Data_Exchange, start again, at least every few seconds"
    D05 "M-D05" Diagnosis 1 B [Pty]
        "Cfg_Fault: the same"
    D06 "M-D06" Diagnosis 1 B [Pty]
        "a diagnosis without faults is no reason to restart: Data_Exchange goes on"
    D07 "M-D07" Diagnosis 1 B [Pty]
        "Master_Add neither 255 nor own (the requester derives Master_Lock): no Set_Prm with lock, no Chk_Cfg, no Data_Exchange; read the diagnosis again later"
    D08 "M-D08" Diagnosis 1 B [Pty]
        "diagnosis up to 244 octets"
    D09 "M-D09" Diagnosis 2 B [Pty]
        "Ext_Diag_Overflow: accepted; the master sets it itself when its buffer is too small"
    D10 "M-D10" Diagnosis 2 B [Pty]
        "Not_Supported: reported to the user; no endless restart"
    D11 "M-D11" Diagnosis 2 C [Pty]
        "data-less DH (SD1 0x0A) of a slave without inputs counts as DH"
    D12 "M-D12" Diagnosis 1 B [Pty]
        "a diagnosis under 6 octets is invalid, not 'no fault'"
    D13 "M-D13" Diagnosis 2 C [Pty]
        "'fault gone' (DH with Ext_Diag = 0) is fetched as well"
    D14 "M-D14" Diagnosis 2 B [Pty]
        "DH in every reply: data exchange goes on between the diagnoses, other slaves are not affected"
    D15 "M-D15" Diagnosis 1 U [Pty]
        "Station_Not_Ready or Master_Add = 255 in a diagnosis during data exchange: start again"
    D16 "M-D16" Diagnosis 1 B [Pty]
        "master-only bits in a slave's diagnosis (1.0, 1.5, 1.7, 2.7) have no effect: taken as zero or as an invalid reply"
    O01 "M-O01" Modes 1 B [Pty]
        "OPERATE is announced by Global_Control without Clear_Data, then cyclically (Data_Control_Time, or three watchdog times)"
    O02 "M-O02" Modes 1 B [Ask]
        "on the way to CLEAR: Global_Control with Clear_Data at once"
    O03 "M-O03" Modes 1 A [Ask]
        "in CLEAR every output octet is 0 (Fail_Safe = 0)"
    O04 "M-O04" Modes 1 B [Pty]
        "SDN, DA 127 or one station, SAP 62 to 58, 2 octets, no reply awaited"
    O05 "M-O05" Modes 1 B [Pty]
        "reserved bits 0, 6, 7 are 0"
    O06 "M-O06" Modes 1 B [Ask]
        "empty Data_Exchange in CLEAR for Fail_Safe = 1 only; never in OPERATE"
    O07 "M-O07" Modes 1 A [Pty]
        "Auto_Clear (Error_Action_Flag) configured: data exchange with one active slave impossible for Data_Control_Time leads to CLEAR"
    O08 "M-O08" Modes 1 A [Pty]
        "not configured: OPERATE stays"
    O09 "M-O09" Modes 2 A [Pty]
        "with Auto_Clear: back to OPERATE only when all were in data exchange within Data_Control_Time"
    O10 "M-O10" Modes 1 B [Ask]
        "back to OPERATE: Global_Control without Clear_Data, user outputs again"
    O11 "M-O11" Modes 2 B [Ask]
        "OFFLINE/STOP: no requests to slaves"
    O12 "M-O12" Modes 2 B [Ask]
        "the transition STOP to OPERATE passes through CLEAR"
    S01 "M-S01" SyncFreeze 2 B [Ask]
        "command bits and Group_Select as the user asked; a command and its undo never together"
    S02 "M-S02" SyncFreeze 2 B [Ask]
        "only to slaves whose Set_Prm carried Sync_Req / Freeze_Req"
    S03 "M-S03" SyncFreeze 2 B [Ask]
        "the cyclic Operate Global_Control does not undo a mode (00 = no action)"
    S04 "M-S04" SyncFreeze 3 A []
        "Min_Slave_Interval between Global_Control and the next request is the responsibility of the user"
    L01 "M-L01" Loss 1 A [Pty]
        "a silent slave leaves data exchange after its retries; then Slave_Diag (or FDL status) only. Exception: a master that is configured to stay in data exchange"
    L02 "M-L02" Loss 1 A [Pty]
        "a slave that comes back unparameterised gets the full start-up"
    L03 "M-L03" Loss 1 B [Pty]
        "a slave that lost its state without silence (answers RS): Slave_Diag, then start-up"
    L04 "M-L04" Loss 1 A [Pty]
        "the other slaves are not affected, except that the cycle takes longer"
    L05 "M-L05" Loss 1 B [Pty]
        "a slave taken by another master (RS, Master_Add = other) is not taken back; its diagnosis is read again later"
    L06 "M-L06" Loss 2 A [Pty, Virtual]
        "a lost slave is asked again at least every few seconds, without end"
    L07 "M-L07" Loss 1 A [Pty]
        "slave back with its state kept (cable): start-up or data exchange, both are right; FCB as M-C07"
    L08 "M-L08" Loss 1 A [Pty]
        "one lost reply is no reason for a new start-up"
    L09 "M-L09" Loss 2 A [Pty]
        "a slave that was never there is handled like a lost one, and joins when it appears"
    E01 "M-E01" BadReplies 1 B [Pty]
        "reply: wrong FCS"
    E02 "M-E02" BadReplies 1 B [Pty]
        "reply: truncated, nothing follows"
    E03 "M-E03" BadReplies 1 B [Pty]
        "reply: SC where inputs are due, persistent"
    E04 "M-E04" BadReplies 1 B [Pty]
        "reply: wrong input length, persistent"
    E05 "M-E05" BadReplies 1 B [Pty]
        "reply: SA of another station; DA of another master"
    E06 "M-E06" BadReplies 1 B [Pty]
        "reply: duplicate: the reply twice in a row"
    E07 "M-E07" BadReplies 1 B [Pty]
        "reply: RS in Data_Exchange"
    E08 "M-E08" BadReplies 1 B [Pty]
        "reply: UE, RR, NR"
    E09 "M-E09" BadReplies 2 U [Pty]
        "reply: RDL, RDH (data, request not taken)"
    E10 "M-E10" BadReplies 1 B [Pty]
        "reply: late: the reply of a lost cycle arrives while another station, later the same one, is asked"
    E11 "M-E11" BadReplies 2 U [Pty, Virtual]
        "reply: late SC into another slave's Set_Prm or Chk_Cfg"
    E12 "M-E12" BadReplies 1 B [Pty]
        "reply: noise before or instead of the reply"
    E13 "M-E13" BadReplies 2 B [Pty]
        "reply: request bit set (b6 = 1), or station type 'master'"
    E14 "M-E14" BadReplies 1 B [Pty]
        "reply: Slave_Diag answered without SAPs, or from another SAP"
    E15 "M-E15" BadReplies 1 B [Pty]
        "reply: LE != LEr, LE 3, second 68 wrong, ED wrong"
    E16 "M-E16" BadReplies 2 A [Pty]
        "reply: endless octets on the line for 2 s"
    E17 "M-E17" BadReplies 1 U [Pty, Virtual]
        "1 % of random errors of all kinds for 10 000 cycles"
    I01 "M-I01" Several 1 A [Margin, Virtual]
        "between two requests to one slave at least Min_Slave_Interval, for every function except Global_Control; retries and FDL status (no DP function) excepted"
    I02 "M-I02" Several 1 A [Pty]
        "a silent slave does not stop the others"
    I03 "M-I03" Several 2 A [Margin, Virtual]
        "it costs one slot time per attempt (loss itself: 1 + retries)"
    I04 "M-I04" Several 2 B [Pty]
        "slaves are polled equally often (unless priorities are configured)"
    I05 "M-I05" Several 1 A [Pty]
        "a slave in start-up (or not ready) does not stop the others' data exchange"
    I06 "M-I06" Several 2 U [Pty, Virtual]
        "32 slaves; 125 where claimed; sum of cycle times as computed in the reference 1.1"
    I07 "M-I07" Several 2 B [Margin, Virtual]
        "half of the slaves silent: the cycle grows by at most one T_SL for each, the watchdogs of the others do not expire"
    R01 "M-R01" SecondMaster 1 A [Pty]
        "without the token it answers FDL status requests with station type master (1, 2 or 3)"
    R02 "M-R02" SecondMaster 1 A [Pty]
        "a station that says 'ready' to a GAP poll gets the token"
    R03 "M-R03" SecondMaster 1 A [Pty]
        "after passing the token: silence until it comes back"
    R04 "M-R04" SecondMaster 1 B [Pty]
        "a token that no station takes is passed again (twice more), then the station is dropped and the next one, or itself, gets it"
    R05 "M-R05" SecondMaster 1 C [Pty]
        "a token from an unknown predecessor is taken at the second attempt only"
    R06 "M-R06" SecondMaster 1 C [Pty]
        "hearing its own address as SA twice: leaves the ring"
    R07 "M-R07" SecondMaster 1 A [Margin, Virtual]
        "no activity for T_TO: claims the token"
    R08 "M-R08" SecondMaster 1 A [Pty]
        "the token is given back within the target rotation time; one high-priority cycle is always allowed"
    R09 "M-R09" SecondMaster 2 B [Pty]
        "a class-2 master's requests to its slaves (Slave_Diag, RD_Inp) have no effect on its operation"
    R10 "M-R10" SecondMaster 2 A [Virtual]
        "LAS built by listening to two rotations before 'ready'"
    B01 "M-B01" Rates 2 B [Serial, Virtual]
        "all rows at each claimed rate 9.6 k to 12 M"
    B02 "M-B02" Rates 1 B [Virtual]
        "T_SL, T_ID, T_TO, T_TR follow the rate (defaults 100/200/300/400/600/1000 T_bit)"
    B03 "M-B03" Rates 1 A [Pty]
        "watchdog independent of the rate"
    B04 "M-B04" Rates 3 C [Pty]
        "a slave that still searches for the rate (about 10 unanswered requests) is started"
    Z01 "M-Z01" Stop 2 U [Ask]
        "stop by command: Set_Prm with Unlock_Req (Lock = 0) to each slave it owns, so that another master does not wait for the watchdog"
    Z02 "M-Z02" Stop 1 B [Ask]
        "after STOP no request to any slave; token and FDL status may go on"
    Z03 "M-Z03" Stop 2 B [Ask]
        "OPERATE to STOP through CLEAR: outputs zero before silence"
    Z04 "M-Z04" Stop 1 A [Ask]
        "after STOP or power cycle: complete start-up, FCV = 0, FCB = 1"
    Z05 "M-Z05" Stop 1 B [Pty]
        "power off at any octet: no part of the telegram is sent later, nothing is sent without a command"
    Z06 "M-Z06" Stop 2 B [Pty]
        "a second start while its slaves still run with the old watchdog works at once"
    V01 "M-V01" Acyclic 1 B [Pty]
        "a request at SAP 51 or 50 goes only to a slave in data exchange whose Set_Prm enabled DP-V1"
    V02 "M-V02" Acyclic 1 B [Pty]
        "a request at SAP 0 to 51 is one of DP-V1: a function of that SAP, slot 0 to 254, a length that agrees with the data"
    V03 "M-V03" Acyclic 1 B [Pty]
        "one request at a time: no other one at a SAP before the response to the first was fetched"
    V04 "M-V04" Acyclic 1 B [Pty]
        "a request that was acknowledged is polled for: an empty request at the same SAPs, until the response comes"
    V05 "M-V05" Acyclic 1 B [Pty]
        "a response that takes long, but less than C1_Response_Timeout, is waited for: no Abort, no new start-up"
    V06 "M-V06" Acyclic 1 B [Pty]
        "data exchange with the slave goes on between the polls"
    V07 "M-V07" Acyclic 1 B [Pty]
        "a negative response is no reason for a new start-up"
    V08 "M-V08" Acyclic 1 B [Pty]
        "Write has at most C1_Max_Data_Len octets of data, on a connection Max_Len_Data_Unit"
    V09 "M-V09" Acyclic 2 C [Pty]
        "a response that does not come within C1_Response_Timeout is given up"
    V10 "M-V10" Acyclic 2 U [Pty]
        "a job of the owner ends with data exchange: after a new start-up it is not polled for"
    V11 "M-V11" Acyclic 1 B [Pty]
        "Alarm_Ack has the type, slot and sequence number of an alarm that a diagnosis has shown, and comes once"
    V12 "M-V12" Acyclic 1 B [Pty]
        "each alarm that a diagnosis has shown is acknowledged"
    V13 "M-V13" Acyclic 1 B [Pty]
        "SAP 50 is asked only if the slave has it (Extra_Alarm_SAP_supp)"
    V14 "M-V14" Acyclic 1 B [Pty]
        "DPV1_Status_1 to 3: reserved bits are 0, and so are those of what the device file does not offer"
    V15 "M-V15" Acyclic 2 C [Pty]
        "DPV1_Status_1 to 3: what the device file requires is enabled"
    V16 "M-V16" Acyclic 2 U [Pty]
        "DPV1_Status_2 enables only alarms that the device file offers"
    V17 "M-V17" Acyclic 1 B [Pty]
        "with Prm_Structure the user parameters are blocks whose lengths end with Set_Prm"
    V18 "M-V18" Acyclic 1 B [Pty]
        "SAP 0 to 48 is asked only while it is a connection of this master: from the RM that names it until Abort or RS"
    V19 "M-V19" Acyclic 1 B [Pty]
        "a connection gets Idle or a request at least once in Send_Timeout"
    V20 "M-V20" Acyclic 2 C [Pty]
        "Initiate asks for DPV1_RW, with a Send_Timeout that is not 0"
    V21 "M-V21" Acyclic 1 B [Ask]
        "Read and Write have the slot, index, length and data of the user"
}

impl Row {
    /// `M-C03`.
    pub const fn id(self) -> &'static str {
        self.about().id
    }

    /// Whether it is about a master of class 2, too, which reads slaves of another master.
    pub const fn is_of_class_2(self) -> bool {
        match self.about().group {
            Group::Framing | Group::Token | Group::SecondMaster => true,
            Group::Timing => !matches!(self, Self::T06 | Self::T08 | Self::T09),
            Group::FrameCount => !matches!(self, Self::C04 | Self::C08 | Self::C10 | Self::C11),
            Group::BadReplies => !matches!(self, Self::E03 | Self::E04 | Self::E11),
            Group::StartUp => matches!(self, Self::U12),
            Group::Diagnosis => matches!(self, Self::D08 | Self::D16),
            Group::Several => matches!(self, Self::I01 | Self::I03),
            Group::Stop => matches!(self, Self::Z05),
            Group::Contents
            | Group::DataExchange
            | Group::Modes
            | Group::SyncFreeze
            | Group::Loss
            | Group::Rates => false,
            Group::Acyclic => matches!(
                self,
                Self::V02
                    | Self::V03
                    | Self::V04
                    | Self::V05
                    | Self::V08
                    | Self::V18
                    | Self::V19
                    | Self::V20
                    | Self::V21
            ),
        }
    }

    /// Whether a breach is a warning and no failure: the sources are not sure of the rule or of what breaks it, or it is good
    /// practice only.
    pub(crate) const fn only_warns(self) -> bool {
        let about = self.about();
        let of_breach = matches!(self, Self::K05 | Self::O12 | Self::R05 | Self::R06 | Self::S02 | Self::Z03);
        of_breach || matches!(about.confidence, Confidence::U) || about.priority == 3
    }
}

impl Requirement for Row {
    type Ending = Ending;

    const SUBJECT: &'static str = "master";

    fn all() -> Vec<Self> {
        Self::ALL.to_vec()
    }

    fn id(self) -> &'static str {
        Self::id(self)
    }

    fn group(self) -> &'static str {
        self.about().group.title()
    }

    fn text(self) -> &'static str {
        self.about().text
    }

    fn only_warns(self) -> bool {
        Self::only_warns(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_found_by_its_name_and_by_its_group() {
        for row in Row::ALL {
            assert_eq!(Row::named(row.id()), Some(*row));
        }
        assert_eq!(Row::matching("M-E*").len(), 17);
        assert_eq!(Row::matching("m-c03"), [Row::C03]);
        assert_eq!(Row::matching("M-C").len(), 0);
        assert_eq!(Row::ALL.len(), 183);
    }
}
