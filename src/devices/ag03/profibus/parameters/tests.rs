mod every_number_and_job;

use proptest::prelude::*;

use super::*;
use crate::devices::ag03::param::live::live;
use crate::devices::ag03::param::{Effect, Gear, Parameter, Reading};
use crate::profibus::pkw::{Config, Engine, ErrorNumber, Refusal, SubindexOctet};
use crate::profibus::ppo::{Ind, JobId, Pke, Pkw, ReplyId};

const STILL: WriteContext = WriteContext { moving: false, job_active: false };
const TRAVELLING: WriteContext = WriteContext { moving: true, job_active: true };

/// A PKW of four words, as the manuals print it.
fn words(pke: u16, ind: u16, pwe_high: u16, pwe_low: u16) -> Pkw {
    Pkw { pke: Pke::from_raw(pke), ind: Ind::from_raw(ind), pwe_high, pwe_low }
}

/// The parameters of a drive that does what the test says, and what the last job did.
struct Table {
    store: Store,
    context: WriteContext,
    quirks: JobQuirks,
    position: i32,
    newest_fault: u8,
    /// Writes wait for the EEPROM.
    waits: bool,
    effect: Effect,
    stores: bool,
}

impl Parameters for Table {
    fn read(&self, pnu: u16, element: Option<u8>) -> Result<pkw::Value, JobError> {
        let pnu = Pnu::from_low_bits(pnu);
        let show = |reading, element| match (reading, element) {
            (Reading::Position, _) => self.position,
            (Reading::FaultBuffer, Subindex(0)) => self.newest_fault.into(),
            (reading, element) => live(reading, element),
        };
        let value = self.store.read(pnu, element.map(Subindex), show)?;
        self.quirks.check_read(&self.store, pnu)?;
        Ok(value.into())
    }

    fn write(&mut self, pnu: u16, element: Option<u8>, value: pkw::Value) -> Result<pkw::Written, JobError> {
        let write = self.store.meaning(Pnu::from_low_bits(pnu), element.map(Subindex), value.into())?;
        self.effect = self.store.apply(write, &self.context)?;
        self.stores = write.is_kept();
        let shown = self.quirks.confirmation(self.store.model(), write, value);
        Ok(pkw::Written { shown, waits: self.waits && self.stores })
    }

    fn elements(&self, pnu: u16) -> Result<Option<u8>, JobError> {
        self.store.elements(pnu)
    }
}

/// What a cycle made of the parameter channel and of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Outcome {
    reply: Pkw,
    effect: Effect,
    stores: bool,
    refusal: Option<Refusal>,
}

const fn unchanged(reply: Pkw) -> Outcome {
    Outcome { reply, effect: Effect::None, stores: false, refusal: None }
}

/// One drive with its parameter channel.
struct Rig {
    engine: Engine,
    table: Table,
}

impl Rig {
    fn new(model: Model, gear: Gear) -> Self {
        Self::with(Config::default(), model, gear)
    }

    fn with(config: Config, model: Model, gear: Gear) -> Self {
        let table = Table {
            store: Store::new(model, gear),
            context: STILL,
            quirks: JobQuirks::default(),
            position: -5000,
            newest_fault: b'G',
            waits: false,
            effect: Effect::None,
            stores: false,
        };
        Self { engine: Engine::new(config), table }
    }

    fn with_latency(latency: u16) -> Self {
        Self::with(Config { latency, ..Config::default() }, Model::Ag03_1, Gear::Ratio48)
    }

    fn cycle(&mut self, request: Pkw) -> Outcome {
        (self.table.effect, self.table.stores) = (Effect::None, false);
        let pkw::Outcome { reply, refusal } = self.engine.cycle(request, &mut self.table);
        Outcome { reply, effect: self.table.effect, stores: self.table.stores, refusal }
    }

    fn reply(&mut self, request: Pkw) -> Pkw {
        self.cycle(request).reply
    }
}

const CLEAR_FAULTS: Pkw = Pkw::new(Pke::from_raw(0x23CA), Ind::from_raw(0), 4);
const FAULTS_CLEARED: Pkw = Pkw::new(Pke::from_raw(0x23CA), Ind::from_raw(0), 0);
const READ_P: Pkw = Pkw::new(Pke::from_raw(0x13E8), Ind::from_raw(0), 0);
const P_IS_100: Pkw = Pkw::new(Pke::from_raw(0x13E8), Ind::from_raw(0), 100);

#[test]
fn the_telegrams_printed_in_the_manual() {
    // Chapters 7.6.1 and 7.6.2; `ag03.md` 2.5.
    let mut rig = Rig::new(Model::Ag03_1, Gear::Ratio48);
    rig.table.store.set(Parameter::CalibrationValue, 10_000).unwrap();
    let reply = rig.reply(Pkw::from_octets([0x13, 0xFA, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00]));
    assert_eq!(reply.to_octets(), [0x23, 0xFA, 0x00, 0x00, 0x00, 0x00, 0x27, 0x10]);
    let reply = rig.reply(Pkw::from_octets([0x33, 0xF8, 0x00, 0x00, 0x00, 0x03, 0xD0, 0x90]));
    assert_eq!(reply.to_octets(), [0x23, 0xF8, 0x00, 0x00, 0x00, 0x03, 0xD0, 0x90]);
    assert_eq!(rig.table.store.value(Parameter::Limit1), 250_000);
    // The further values of `ag03.md` 2.5.
    for (pke, pwe_high, pwe_low) in [
        (0x13FC, 0x0000, 0x2948), // system status word
        (0x2409, 0x0012, 0xD687), // serial number 1234567
        (0x240A, 0x1507, 0x2009), // date of production
        (0x13C5, 0x0000, 0x0101), // software version
    ] {
        let request = words(0x1000 | pke & 0x07FF, 0, 0, 0);
        assert_eq!(rig.reply(request), words(pke, 0, pwe_high, pwe_low));
    }
    rig.table.newest_fault = 0x41;
    assert_eq!(rig.reply(words(0x63B1, 0, 0, 0)), words(0x43B1, 0, 0, 0x41));
}

#[test]
fn the_derived_vectors() {
    // `ag03.md` 2.6 in its order.
    let rows = [
        (words(0x13F9, 0, 0, 0), words(0x23F9, 0, 0xFFF0, 0xBDC0)),
        (words(0x33F9, 0, 0xFF67, 0x6981), words(0x23F9, 0, 0xFF67, 0x6981)),
        (words(0x33FB, 0, 0xFFFF, 0xF9C0), words(0x23FB, 0, 0xFFFF, 0xF9C0)),
        (words(0x23A2, 0, 0, 1), words(0x13A2, 0, 0, 1)),
        (words(0x23EB, 0, 0, 0x65), words(0x73EB, 0, 0, 2)),
        (words(0x33E8, 0, 0, 0x64), words(0x73E8, 0, 0, 5)),
        (words(0x2396, 0, 0, 5), words(0x7396, 0, 0, 1)),
        (words(0x13E7, 0, 0, 0), words(0x73E7, 0, 0, 0)),
        (words(0x63B1, 0x0300, 0, 0), words(0x43B1, 0x0300, 0, 0x41)),
        (words(0x93B1, 0, 0, 0), words(0x63B1, 0, 0, 0x0A)),
    ];
    for model in Model::ALL {
        let mut rig = Rig::new(model, Gear::Ratio48);
        for (request, reply) in rows {
            assert_eq!(rig.reply(request).to_octets(), reply.to_octets(), "{model}: {request}");
        }
        assert_eq!(rig.table.store.value(Parameter::Limit2), -9_999_999);
        assert_eq!(rig.table.store.value(Parameter::DeltaInch), -1600);
        assert_eq!(rig.table.store.value(Parameter::OperatingMode), 1);
    }
    for (model, reply) in [(Model::Ag03, 0x13CA), (Model::Ag03_1, 0x23CA)] {
        let mut rig = Rig::new(model, Gear::Ratio48);
        let outcome = rig.cycle(words(0x23CA, 0, 0, 5));
        assert_eq!((outcome.reply, outcome.effect), (words(reply, 0, 0, 0), Effect::Calibrate));
        rig.reply(Pkw::ZERO);
        rig.table.context = TRAVELLING;
        let outcome = rig.cycle(words(0x23CA, 0, 0, 5));
        assert_eq!((outcome.reply, outcome.effect), (words(0x73CA, 0, 0, 0x11), Effect::None));
    }
}

#[test]
fn a_refusal_says_what_was_asked_and_what_is_wrong_once() {
    let mut rig = Rig::new(Model::Ag03, Gear::Ratio48);
    rig.table.context = TRAVELLING;
    let job = words(0x23F0, 0, 0, 50);
    let refusal = Refusal {
        job,
        pnu: job.pke.pnu(),
        number: ErrorNumber::OperatingState,
        cause: JobError::NotNow("the shaft is moving"),
    };
    assert_eq!(rig.cycle(job).refusal, Some(refusal));
    assert_eq!(rig.cycle(job), unchanged(words(0x73F0, 0, 0, 17)));

    // A refused read is not tried again either.
    let job = words(0x1400, 0, 0, 0);
    assert_eq!(rig.cycle(job).refusal.unwrap().number, ErrorNumber::IllegalParameterNumber);
    assert_eq!(rig.cycle(job), unchanged(words(0x7400, 0, 0, 0)));
}

#[test]
fn a_write_can_be_repeated_after_job_0_or_another_job() {
    let mut rig = Rig::with_latency(0);
    assert_eq!(rig.cycle(CLEAR_FAULTS).effect, Effect::ClearFaults);
    assert_eq!(rig.cycle(CLEAR_FAULTS).effect, Effect::None);
    assert_eq!(rig.reply(Pkw::ZERO), Pkw::ZERO);
    assert_eq!(rig.cycle(CLEAR_FAULTS).effect, Effect::ClearFaults);
    assert_eq!(rig.reply(READ_P), P_IS_100);
    assert_eq!(rig.cycle(CLEAR_FAULTS).effect, Effect::ClearFaults);
    // The toggle bit does not make a new job; a word the job does not use does.
    let toggled = Pkw { pke: Pke::from_raw(CLEAR_FAULTS.pke.raw() | 0x0800), ..CLEAR_FAULTS };
    assert_eq!(rig.cycle(toggled).effect, Effect::None);
    assert_eq!(rig.cycle(Pkw { pwe_high: 1, ..CLEAR_FAULTS }).effect, Effect::ClearFaults);
}

#[test]
fn a_held_read_shows_the_newest_value() {
    let mut rig = Rig::with_latency(2);
    let read_position = words(0x140C, 0, 0, 0);
    assert_eq!(rig.reply(read_position), Pkw::ZERO);
    assert_eq!(rig.reply(read_position), Pkw::ZERO);
    for position in [10, -10] {
        rig.table.position = position;
        assert_eq!(rig.reply(read_position).double_word().cast_signed(), position);
    }
    let read_fault = words(0x63B1, 0, 0, 0);
    for _ in 0..3 {
        rig.reply(read_fault);
    }
    rig.table.newest_fault = b'J';
    assert_eq!(rig.reply(read_fault), words(0x43B1, 0, 0, 0x4A));
}

#[test]
fn job_0_is_answered_with_zeros_whatever_else_it_says() {
    let mut rig = Rig::with_latency(0);
    rig.reply(READ_P);
    assert_eq!(rig.reply(words(0x03E8, 0x1234, 0x5678, 0x9ABC)), Pkw::ZERO);
}

#[test]
fn the_old_reply_stands_until_the_job_has_run() {
    let mut rig = Rig::with_latency(3);
    let replies: Vec<Pkw> = (0..5).map(|_| rig.reply(READ_P)).collect();
    assert_eq!(replies, [Pkw::ZERO, Pkw::ZERO, Pkw::ZERO, P_IS_100, P_IS_100]);
    let outcomes: Vec<Outcome> = (0..5).map(|_| rig.cycle(CLEAR_FAULTS)).collect();
    let old = unchanged(P_IS_100);
    let done = Outcome { effect: Effect::ClearFaults, stores: true, ..unchanged(FAULTS_CLEARED) };
    assert_eq!(outcomes, [old, old, old, done, unchanged(FAULTS_CLEARED)]);
}

#[test]
fn a_request_that_changes_while_a_job_waits_is_looked_at_after_its_reply() {
    let mut rig = Rig::with_latency(2);
    let replies: Vec<Pkw> = [CLEAR_FAULTS, READ_P, READ_P, READ_P, READ_P, READ_P]
        .into_iter()
        .map(|job| rig.reply(job))
        .collect();
    // Taken, waiting, done and shown; then the read is taken, waiting, done.
    assert_eq!(replies, [Pkw::ZERO, Pkw::ZERO, FAULTS_CLEARED, FAULTS_CLEARED, FAULTS_CLEARED, P_IS_100]);

    // A change the master takes back in time was never there.
    let mut rig = Rig::with_latency(2);
    let effects: Vec<Effect> = [CLEAR_FAULTS, READ_P, CLEAR_FAULTS, CLEAR_FAULTS, CLEAR_FAULTS, CLEAR_FAULTS]
        .into_iter()
        .map(|job| rig.cycle(job).effect)
        .collect();
    assert_eq!(effects.iter().filter(|&&effect| effect == Effect::ClearFaults).count(), 1);
}

#[test]
fn a_reset_forgets_the_reply_and_a_waiting_job() {
    let mut rig = Rig::with_latency(0);
    rig.reply(READ_P);
    rig.engine.reset();
    assert_eq!(rig.reply(Pkw::ZERO), Pkw::ZERO);
    rig.reply(READ_P);
    rig.engine.reset();
    assert_eq!(rig.reply(READ_P), P_IS_100);

    let mut rig = Rig::with_latency(1);
    rig.reply(CLEAR_FAULTS);
    rig.engine.reset();
    assert_eq!(rig.cycle(Pkw::ZERO), unchanged(Pkw::ZERO));
    assert_eq!(rig.cycle(Pkw::ZERO), unchanged(Pkw::ZERO));
}

#[test]
fn there_is_work_until_the_job_is_done() {
    let mut rig = Rig::with_latency(1);
    assert!(!rig.engine.has_work(Pkw::ZERO));
    assert!(rig.engine.has_work(READ_P));
    rig.reply(READ_P);
    assert!(rig.engine.has_work(READ_P));
    rig.reply(READ_P);
    assert!(!rig.engine.has_work(READ_P));
    assert!(rig.engine.has_work(Pkw::ZERO));
}

#[test]
fn the_sub_index_is_found_where_the_configuration_says() {
    // IND, and the element read: high else low, high, low. 0x47 = 'G' is element 0, 0x46 = 'F' element 1.
    for (ind, codes) in
        [(0x0100, [0x46, 0x46, 0x47]), (0x0001, [0x46, 0x47, 0x46]), (0x0102, [0x46, 0x46, 0x45])]
    {
        let modes = [SubindexOctet::HighElseLow, SubindexOctet::High, SubindexOctet::Low];
        for (subindex, code) in modes.into_iter().zip(codes) {
            let config = Config { subindex, ..Config::default() };
            let mut rig = Rig::with(config, Model::Ag03_1, Gear::Ratio48);
            assert_eq!(rig.reply(words(0x63B1, ind, 0, 0)), words(0x43B1, ind, 0, code), "{subindex:?}");
        }
    }
}

#[test]
fn the_open_points_can_be_decided_the_other_way() {
    let config = Config { read_element_by_plain_job: true, ..Config::default() };
    let mut rig = Rig::with(config, Model::Ag03_1, Gear::Ratio48);
    rig.table.quirks.refuse_command_read = true;
    assert_eq!(rig.reply(words(0x13B1, 0x0300, 0, 0)), words(0x43B1, 0x0300, 0, 0x41));
    assert_eq!(rig.reply(words(0x13E8, 0x0300, 0, 0)), words(0x13E8, 0x0300, 0, 100));
    let outcome = rig.cycle(words(0x13CA, 0, 0, 0));
    assert_eq!(
        (outcome.reply, outcome.refusal.unwrap().cause),
        (words(0x73CA, 0, 0, 18), JobError::WriteOnly)
    );
}

/// Requests that often name real parameters, often repeat, and sometimes are noise.
fn request() -> impl Strategy<Value = Pkw> {
    let number = prop_oneof![930_u16..=975, 1000_u16..=1045, 0_u16..=2047];
    let value = prop_oneof![0_u32..120, any::<u32>()];
    let likely = (0_u16..16, number, 0_u16..3, value)
        .prop_map(|(job, pnu, ind, pwe)| Pkw::new(Pke::from_raw(job << 12 | pnu), Ind::from_raw(ind), pwe));
    prop_oneof![
        4 => likely,
        1 => any::<[u8; 8]>().prop_map(Pkw::from_octets),
        1 => Just(Pkw::ZERO),
        1 => Just(CLEAR_FAULTS),
    ]
}

proptest! {
    #[test]
    fn a_held_write_is_executed_once(latency in 0_u16..20, held in 1_u16..50) {
        let mut rig = Rig::with_latency(latency);
        let outcomes: Vec<Outcome> = (0..latency + held).map(|_| rig.cycle(CLEAR_FAULTS)).collect();
        let executed: Vec<usize> =
            (0..outcomes.len()).filter(|&n| outcomes[n].effect == Effect::ClearFaults).collect();
        prop_assert_eq!(executed, [usize::from(latency)]);
        for (n, outcome) in (0..).zip(outcomes) {
            prop_assert_eq!(outcome.reply, if n < latency { Pkw::ZERO } else { FAULTS_CLEARED });
        }
    }

    #[test]
    fn without_latency_every_change_is_answered_at_once(
        requests in proptest::collection::vec((request(), 1_usize..4, any::<bool>(), any::<bool>()), 1..40),
    ) {
        let mut rig = Rig::with_latency(0);
        let mut last = Pkw::ZERO;
        for (request, times, moving, job_active) in requests {
            rig.table.context = WriteContext { moving, job_active };
            for _ in 0..times {
                let without_spm = |pkw: Pkw| Pkw { pke: pkw.pke.without_spm(), ..pkw };
                let new = without_spm(request) != without_spm(last);
                prop_assert_eq!(rig.engine.has_work(request), new);
                let before = rig.table.store.clone();
                let outcome = rig.cycle(request);
                prop_assert!(outcome.reply.pke.ak() <= 8 && !outcome.reply.pke.spm());
                if request.pke.job() == JobId::NoJob {
                    prop_assert_eq!(outcome.reply, Pkw::ZERO);
                } else {
                    prop_assert_eq!(outcome.reply.pke.pnu(), request.pke.pnu());
                }
                let refused = outcome.reply.pke.reply() == ReplyId::NotExecutable;
                prop_assert_eq!(outcome.refusal.map(|refusal| refusal.job), (new && refused).then_some(request));
                if !new || refused {
                    prop_assert_eq!(outcome.effect, Effect::None);
                    prop_assert!(rig.table.store == before);
                }
                last = request;
            }
        }
    }

    #[test]
    fn with_latency_every_reply_belongs_to_a_job_that_was_asked(
        latency in 0_u16..4,
        requests in proptest::collection::vec((request(), 1_usize..6), 1..40),
    ) {
        let mut rig = Rig::with_latency(latency);
        let mut asked = std::vec![];
        let (mut changes, mut executions) = (0, 0);
        for (request, times) in requests {
            changes += 1;
            asked.push(request.pke.pnu());
            for _ in 0..times {
                let outcome = rig.cycle(request);
                prop_assert!(outcome.reply.pke.ak() <= 8);
                prop_assert!(outcome.reply == Pkw::ZERO || asked.contains(&outcome.reply.pke.pnu()));
                executions += usize::from(outcome.effect != Effect::None || outcome.refusal.is_some());
            }
        }
        prop_assert!(executions <= changes);
    }
}

const P_IS_70: Pkw = Pkw::new(Pke::from_raw(0x13E8), Ind::from_raw(0), 70);

#[test]
fn a_held_write_is_answered_after_it_is_stored_and_executed_once() {
    let write = words(0x23E8, 0, 0, 70);
    for failed in [false, true] {
        let mut rig = Rig::with_latency(0);
        assert!(!rig.engine.stored(), "nothing is held");
        assert_eq!(rig.engine.store_failed(), None);
        rig.reply(CLEAR_FAULTS);

        rig.table.waits = true;
        let held = rig.cycle(write);
        assert_eq!((held.reply, held.stores), (FAULTS_CLEARED, true));
        assert!(!rig.engine.has_work(READ_P));
        // Whatever the master says meanwhile.
        assert_eq!([write, READ_P, Pkw::ZERO].map(|job| rig.cycle(job)), [unchanged(FAULTS_CLEARED); 3]);
        let reply = if failed {
            let refusal = rig.engine.store_failed().unwrap();
            assert_eq!((refusal.number.number(), refusal.cause), (18, JobError::NotStored));
            words(0x73E8, 0, 0, 18)
        } else {
            assert!(rig.engine.stored());
            P_IS_70
        };
        assert!(rig.engine.has_work(write));
        assert_eq!(rig.cycle(READ_P), unchanged(reply), "the answer of one cycle");
        assert!(!rig.engine.has_work(write));
        assert_eq!(rig.reply(READ_P), P_IS_70, "to undo the write is not the engine's business");
    }
}

#[test]
fn only_what_the_eeprom_keeps_is_to_be_stored() {
    let mut rig = Rig::with_latency(0);
    for (job, stores) in [
        (words(0x23E8, 0, 0, 70), true),
        (words(0x23E8, 0, 0, 71), true),
        (words(0x23CA, 0, 0, 4), true),
        (words(0x240B, 0, 0, 50), false),
        (words(0x13E8, 0, 0, 0), false),
        (words(0x23E8, 0, 0, 501), false),
        (Pkw::ZERO, false),
    ] {
        assert_eq!(rig.cycle(job).stores, stores, "{job}");
    }
}
