//! The mistakes that the test master can make, and the rows that find each.

macro_rules! mistakes {
    ($($(#[$doc:meta])* $mistake:ident [$($row:literal),*])*) => {
        /// What the master does wrong. One at a time.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub(crate) enum Mistake { $($(#[$doc])* $mistake,)* }

        /// Each mistake, and the rows that may find it; the first must.
        pub(crate) const MISTAKES: &[(Mistake, &[&str])] = &[$((Mistake::$mistake, &[$($row),*]),)*];
    };
}

mistakes! {
    /// A wrong sum in every fiftieth telegram.
    WrongFcs ["M-F02"]
    /// Set_Prm as SDA.
    WrongFunction ["M-F05"]
    /// FCB = 1 in Global_Control.
    CountedControl ["M-C09"]
    /// The first request has FCV = 1.
    FirstCounted ["M-C01", "M-C07"]
    /// The FCB never toggles.
    NoToggle ["M-C02"]
    /// A retry toggles.
    RetryToggles ["M-C03", "M-C12", "M-E01", "M-E02", "M-E05", "M-E12", "M-E13", "M-E14", "M-E15"]
    /// A retry carries newer outputs.
    RetryChanges ["M-C04"]
    /// No retries.
    NoRetry ["M-C05", "M-C12"]
    /// Retries without end.
    EndlessRetries ["M-C06", "M-I02", "M-T08"]
    /// After the retries the FCB goes on.
    NoReset ["M-C07"]
    /// One FCB for all stations.
    CommonBit ["M-C08", "M-C02"]
    /// Replies with a wrong sum are believed.
    BelievesFcs ["M-E01"]
    /// Replies of other stations are believed.
    BelievesSource ["M-E05"]
    /// No diagnosis before Set_Prm.
    NoFirstDiag ["M-U01"]
    /// No diagnosis behind Chk_Cfg.
    NoSecondDiag ["M-U04"]
    /// Chk_Cfg before Set_Prm.
    CfgFirst ["M-U02"]
    /// Data_Exchange though Station_Not_Ready.
    IgnoresNotReady ["M-U05"]
    /// A new Set_Prm when the slave is not ready twice.
    Impatient ["M-U06"]
    /// RS to Set_Prm is taken for SC.
    IgnoresRefusal ["M-U08"]
    /// Stat_Diag is ignored.
    IgnoresStatDiag ["M-D03"]
    /// Prm_Fault is ignored.
    IgnoresPrmFault ["M-D04"]
    /// Cfg_Fault is ignored.
    IgnoresCfgFault ["M-D05"]
    /// Another owner is ignored.
    IgnoresOwner ["M-D07", "M-L05"]
    /// Short diagnoses are taken for good ones.
    TakesShortDiag ["M-D12"]
    /// No Lock_Req.
    NoLock ["M-P01"]
    /// A factor of the watchdog is 0.
    ZeroFactor ["M-P02"]
    /// Reserved bits of Set_Prm.
    ReservedPrm ["M-P04"]
    /// The ident number the other way round.
    SwappedIdent ["M-P05"]
    /// min T_SDR of 5.
    ShortTsdr ["M-P06"]
    /// min T_SDR above max T_SDR of the slaves.
    LongTsdr ["M-P06"]
    /// One octet of user parameters too many.
    LongPrm ["M-P07"]
    /// Other user parameters.
    OtherPrm ["M-P08"]
    /// Other groups.
    OtherGroups ["M-P09"]
    /// A watchdog ten times too short.
    ShortWatchdog ["M-P03"]
    /// An octet of outputs too many.
    LongOutputs ["M-X01", "M-G02"]
    /// The diagnosis is never read while data are exchanged.
    IgnoresHigh ["M-D01", "M-D13"]
    /// Prm_Req is ignored while data are exchanged.
    IgnoresPrmReq ["M-D02", "M-D15"]
    /// A diagnosis leads to a new start-up.
    RestartsOnDiag ["M-D06", "M-D08", "M-D09"]
    /// No Global_Control at all.
    NoControl ["M-O01"]
    /// OPERATE is announced to a group in which no station is.
    OneGroup ["M-O01"]
    /// Reserved bits in Global_Control.
    ReservedControl ["M-O05"]
    /// Global_Control with Clear_Data when a slave is lost.
    ClearsOnLoss ["M-O08", "M-O03"]
    /// Outputs while CLEAR is announced at the beginning.
    OutputsInClear ["M-U10"]
    /// A lost reply leads to a new start-up.
    RestartsOnLoss ["M-L08", "M-D06"]
    /// Data_Exchange goes on with a silent slave.
    StaysInExchange ["M-L01"]
    /// RS is ignored.
    IgnoresRs ["M-L03", "M-E07"]
    /// A lost slave is never asked again.
    Forgets ["M-L06", "M-L02", "M-E10"]
    /// A lost slave stops the others.
    StopsOthers ["M-I02", "M-T08", "M-C11", "M-C10", "M-I05"]
    /// Another slave's loss restarts every slave.
    RestartsAll ["M-L04"]
    /// SC for data is ignored.
    IgnoresSc ["M-E03"]
    /// Inputs of a wrong length are ignored.
    IgnoresLength ["M-E04"]
    /// It ends when RS comes.
    DiesOnRs ["M-E07", "M-L03"]
    /// It does not wait for replies.
    DoesNotWait ["M-T02"]
    /// It waits only for a third of the slot time.
    ShortSlot ["M-T03"]
    /// The second slave is asked every tenth time only.
    Unequal ["M-I04", "M-X03"]
    /// It asks stations that nobody configured.
    Strangers ["M-U12"]
    /// Set_Slave_Add that nobody asked for.
    SetsAddress ["M-U12"]
    /// SC, which only answers.
    SendsSc ["M-F01"]
    /// LE and LEr differ.
    BrokenLength ["M-F03"]
    /// A wrong end delimiter.
    WrongEnd ["M-F03"]
    /// An empty telegram as SD2.
    EmptySd2 ["M-F07"]
    /// Slave_Diag without SSAP.
    NoSsap ["M-F06"]
    /// A record is read though DP-V1 is not enabled.
    ReadsRecord ["M-V01", "M-D06", "M-D08", "M-L04"]
    /// A record is read with a length of 0.
    ReadsNothing ["M-V02", "M-V01", "M-D06", "M-D08", "M-L04"]
    // These are made at slaves of DP-V1.
    /// Another request before the response to the first was fetched.
    SecondRequest ["M-V03"]
    /// After a request it never polls.
    NeverPolls ["M-V04", "M-V12"]
    /// A job that takes long leads to a new start-up.
    RestartsOnSlowJob ["M-V05"]
    /// While a job runs it only polls, and exchanges data now and then.
    PollsOnly ["M-V06"]
    /// A job that is refused leads to a new start-up.
    RestartsOnRefusal ["M-V07", "M-D08"]
    /// A Write with more octets than C1_Max_Data_Len.
    LongWrite ["M-V08"]
    /// A job that does not end is polled for without end.
    PollsForEver ["M-V09"]
    /// After a new start-up the old job is polled for.
    PollsOldJob ["M-V10"]
    /// The sequence number of another alarm is acknowledged.
    AcknowledgesOther ["M-V11", "M-V12"]
    /// An alarm is acknowledged twice.
    AcknowledgesTwice ["M-V11"]
    /// No alarm is acknowledged.
    NeverAcknowledges ["M-V12"]
    /// Alarms are acknowledged at SAP 50 of a slave without it.
    AcknowledgesAtSap50 ["M-V13", "M-V12"]
    /// A reserved bit of DPV1_Status.
    ReservedStatus ["M-V14", "M-P08"]
    /// An alarm that the device file requires is not enabled.
    RequiredOff ["M-V15", "M-P08"]
    /// Alarms are enabled that the slave does not offer.
    EnablesEveryAlarm ["M-V16", "M-P08"]
    /// A block of parameters is longer than Set_Prm.
    LongBlock ["M-V17", "M-P08"]
    /// A SAP that the slave has not handed out is polled.
    AsksForeignSap ["M-V18"]
    /// A connection is kept without Idle.
    NoIdle ["M-V19"]
    /// Initiate does not ask for DPV1_RW.
    NoReadWrite ["M-V20"]
    /// It ends a connection whose job takes long. Seen only of a master of class 2: tests/judge/class_two.rs.
    AbortsSlowJob []
    /// Another record than that of the user. Seen if somebody operates the master.
    OtherIndex []
    /// Data_Exchange with SAPs.
    SapsForData ["M-F06", "M-D06", "M-D08", "M-L04"]
    /// A telegram with another source address.
    OtherSource ["M-F04"]
    /// FDL status of its own address.
    AsksItself ["M-F04"]
    /// FDL status of address 127.
    AsksEverybody ["M-F04"]
    /// FCB = 1 in FDL status.
    CountedPoll ["M-C09"]
    /// The token to a slave.
    TokenToSlave ["M-K02", "M-K08"]
    /// A GAP address that did not answer is asked again.
    GapRepeats ["M-K06"]
    /// Two GAP addresses between two tokens.
    GapTwice ["M-K03", "M-K04"]
    /// GAP addresses in falling order.
    GapFalls ["M-K04", "M-R02"]
    /// A GAP address above HSA.
    GapAboveHsa ["M-K04", "M-K06"]
    /// Global_Control of three octets.
    LongControl ["M-O04"]
    /// 20 bit times of idle line after a reply.
    ShortIdle ["M-T01", "M-T05"]
    /// T_SYN only after Global_Control.
    ShortAfterControl ["M-T06"]
    /// It sends at once when it is switched on.
    NoListening ["M-K07"]
    /// Forty slot times of silence after no reply.
    SlowAfterLoss ["M-T04", "M-I03"]
    /// Min_Slave_Interval is ignored.
    TooFast ["M-I01"]
    /// The watchdog is off.
    WatchdogOff ["M-P03"]
    /// Unlock_Req in a start-up.
    Unlocks ["M-P01"]
    /// Another identifier in Chk_Cfg.
    OtherCfg ["M-G01"]
    /// Other user parameters in a later start-up.
    ChangesPrm ["M-P12", "M-P08"]
    /// No Chk_Cfg.
    NoCfg ["M-U03", "M-U04"]
    /// Chk_Cfg though Set_Prm was not answered.
    IgnoresSilence ["M-U09"]
    /// An octet of outputs too few.
    ShortOutputs ["M-X01", "M-G02"]
    /// It ends when UE comes.
    DiesOnUserError ["M-E08"]
    /// It ends when a diagnosis has Master_Lock.
    DiesOnMasterBits ["M-D16"]
    /// It ends after 200 octets of noise.
    DiesOnFlood ["M-E16"]
    /// The second slave is asked in every third cycle only.
    SkipsCycles ["M-X03"]
    /// Fewer inputs than configured are taken over.
    IgnoresFewInputs ["M-E04"]
    /// A long diagnosis leads to a new start-up.
    RestartsOnLongDiag ["M-D08"]
    /// Ext_Diag_Overflow leads to a new start-up.
    RestartsOnOverflow ["M-D09"]
    /// A reply that comes twice is kept for the next request.
    KeepsReplies ["M-E06"]
    /// Replies as SD3 are not taken.
    RejectsSd3 ["M-X07"]
    /// A reply with a wrong sum makes it give the station up.
    GivesUpOnFcs ["M-C12"]
    /// The first request to a lost station is repeated at once.
    RepeatsFirst ["M-C11", "M-C10"]
    /// Later requests to a lost station are repeated at once.
    RepeatsLost ["M-C10"]
    /// A pause longer than the watchdog time in every hundredth cycle.
    Pauses ["M-T08"]
    /// The end of a fault is not read.
    IgnoresGone ["M-D13"]
    /// A slave without owner, or not ready, goes on while data are exchanged.
    IgnoresNoOwner ["M-D15"]
    /// A lost slave is not started anew.
    NoStartUp ["M-L02", "M-D02", "M-D15"]
    /// A slave that another master has taken is taken back.
    TakesBack ["M-L05", "M-D07"]
    /// What there is of a reply that was cut off is taken.
    BelievesTruncated ["M-E02"]
    /// Noise is taken for a reply.
    BelievesNoise ["M-E12"]
    /// Any function code is taken for that of a reply.
    BelievesFunction ["M-E13"]
    /// It ends when a diagnosis comes from another SAP.
    DiesOnSaps ["M-E14"]
    /// Wrong delimiters and lengths of a reply are not seen.
    BelievesDelimiters ["M-E15"]
    /// Forty slot times of silence after a station that was never there.
    SlowForAbsent ["M-I03"]
    /// A telegram with LE 250.
    HugeLength ["M-F08"]
    /// Four hundred octets that are no telegram.
    Babbles ["M-F11", "M-F01"]
    /// The slot time is shorter than max T_SDR of the slaves.
    TightSlot ["M-T07"]
    /// The watchdog time is shorter than three cycles.
    TightWatchdog ["M-T09"]
    /// It claims the token and never passes it again.
    NeverPasses ["M-K01"]
    /// OPERATE is announced once.
    AnnouncesOnce ["M-O01"]
    /// Another ident number in the diagnosis is ignored.
    IgnoresIdent ["M-U07"]
    /// It ends at the eighth start-up in a row.
    DiesOnManyStartUps ["M-U11"]
    /// Sync_Req and Freeze_Req for a slave whose device file does not offer them.
    AsksSync ["M-P10"]
    /// DPV1_Status for a slave without DPV1.
    Dpv1Octets ["M-P13", "M-P07"]
    /// Other identifiers of the special format.
    OtherSpecial ["M-G03", "M-G01"]
    /// Outputs to a slave with inputs only.
    OutputsToInputs ["M-X05", "M-X01", "M-G02"]
    /// SC of a slave with outputs only is no good reply.
    RejectsSc ["M-X06", "M-D06", "M-L04"]
    /// Replies of more than 200 octets are not taken.
    RejectsLong ["M-X08", "M-C02", "M-L04"]
    /// It ends when a diagnosis says Not_Supported.
    DiesOnUnsupported ["M-D10"]
    /// A reply of high priority without data is ignored.
    IgnoresEmptyHigh ["M-D11"]
    /// While a slave announces diagnoses it asks no other.
    StarvesAtDh ["M-D14"]
    /// Empty Data_Exchange in CLEAR to a slave without Fail_Safe.
    EmptyInClear ["M-O06"]
    /// Auto_Clear is configured, and CLEAR does not come.
    NoAutoClear ["M-O07"]
    /// A slave that comes back with its state kept is not taken.
    WaitsForPrmReq ["M-L07", "M-E16", "M-E10"]
    /// A slave that is not there at the beginning is forgotten.
    ForgetsAbsent ["M-L09", "M-B04", "M-L06"]
    /// It ends when a slave answers with data that says the request was not taken.
    DiesOnRdl ["M-E09"]
    /// The late reply of another station is taken.
    TakesLate ["M-E10", "M-E05"]
    /// It ends at the fourth reply with a wrong sum.
    DiesOnManyErrors ["M-E17"]
    /// While a slave is not ready it asks no other.
    WaitsForReady ["M-I05"]
    /// One of 32 stations is never asked.
    FewStations ["M-I06"]
    /// A station that is not there costs more than the watchdog time of the others.
    SleepsForAbsent ["M-I07", "M-T08", "M-I03", "M-I05"]
    /// One of class 2 parameterises a slave of another master. Seen only of such a one: tests/judge/class_two.rs.
    TakesOver []
    // These need somebody who operates the master: `ASKED` in tests/judge/operated.rs names their rows.
    /// The first exchange with new outputs has half of them.
    TornOutputs []
    /// The outputs of the user go to the other slave.
    OtherOutputs []
    /// After CLEAR the outputs stay zero.
    ZerosAfterClear []
    /// No Global_Control on the way to CLEAR.
    NoClearData []
    /// It goes on when it is stopped.
    DoesNotStop []
    /// It lets no slave go when it is stopped.
    NoRelease []
    /// It stops without CLEAR.
    StopsFromOperate []
    /// It begins with OPERATE.
    BeginsWithOperate []
    /// Set_Prm does not say that Sync and Freeze may come.
    SyncUntold []
    /// Sync and Freeze go to other groups.
    OtherGroup []
    /// The cyclic Global_Control undoes Sync.
    UndoesSync []
    /// It goes on when it is to begin anew.
    DoesNotRestart []
    /// After a new beginning it waits until the old watchdog time of its slaves is over, which it sets again itself.
    WaitsForWatchdog []
    /// It is ready for the ring before it has heard one. Seen if somebody restarts it: tests/judge/ring.rs.
    ReadyAtOnce []
    // These are seen only at two rates: tests/judge/rates.rs names their rows.
    /// It sends no Global_Control at 12 Mbit/s.
    NoControlAtTop []
    /// The idle time is that of 12 Mbit/s.
    IdleOfTop []
    /// The watchdog time is another one at 12 Mbit/s.
    WatchdogOfTop []
    /// It ends when a reply does not come.
    DiesOnSilence ["M-C03"]
    /// It ends when a reply has a wrong sum.
    DiesOnFcs ["M-E01"]
    /// It ends when another station answers.
    DiesOnSource ["M-E05"]
    /// It ends when a diagnosis is longer than 100 octets.
    DiesOnLongDiag ["M-D08"]
    /// It ends when a slave has another owner.
    DiesOnOwner ["M-D07", "M-L05"]
    /// It ends when inputs are longer than configured.
    DiesOnLength ["M-E04"]
    // These are seen only in a ring.
    /// It answers no FDL status request.
    NoStatusReply ["M-R01"]
    /// It answers an FDL status request as a slave.
    StatusAsSlave ["M-R01"]
    /// A master that is ready gets no token.
    IgnoresReady ["M-R02"]
    /// It sends while another master has the token.
    TalksWithoutToken ["M-R03"]
    /// A token for another master is taken.
    TakesForeignToken ["M-R03"]
    /// A token that was not taken is not passed again.
    PassesOnce ["M-R04"]
    /// A token that is not taken is passed without end.
    PassesForEver ["M-R04"]
    /// A token of a station that is not in the ring is taken at once.
    TakesFromStranger ["M-R05"]
    /// It stays in the ring when another one has its address.
    StaysDespiteDouble ["M-R06"]
    /// It never claims a token that was lost.
    NeverClaims ["M-R07", "M-R06"]
    /// T_TR is ignored.
    HoldsLong ["M-R08"]
    /// A slave that another master reads is started anew.
    RestartsOnForeign ["M-R09"]
    /// A master that is not ready gets the token.
    TokenToNotReady ["M-K02"]
    /// The GAP goes on behind the next master in the ring.
    GapBeyondNext ["M-K04"]
    /// Every second address of the GAP is left out.
    GapSkips ["M-K04"]
    /// The GAP is never asked.
    NeverAsksGap ["M-K08"]
    /// An address of the GAP is asked in every rotation, whatever the GAP factor.
    AlwaysAsksGap ["M-K05"]
    /// With Auto_Clear: OPERATE comes back when one station does.
    OperatesWithOne ["M-O09"]
}
