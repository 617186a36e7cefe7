//! The words against a unit: every bit, and both values of each quirk of the words.

use core::time::Duration;

use proptest::prelude::*;

use super::super::Refusal;
use super::*;
use crate::devices::ag03::drive::Inputs;
use crate::devices::ag03::param::{Gear, Model};
use crate::devices::ag03::profibus::bits::Word;
use crate::devices::ag03::unit::{Config, Event, Unit};

fn command(stw: u16) -> Command {
    Words::default().command(Some((Stw::from_raw(stw), 7)))
}

#[test]
fn bits_without_a_meaning_ask_for_nothing_and_every_other_bit_for_something() {
    let without_meaning = Word::Stw.without_meaning(Mode::Positioning);
    for stw in 0..=u16::MAX {
        assert_eq!(command(stw), command(stw & !without_meaning), "{stw:04X}");
    }
    for (bit, others) in [(0, 0x000A), (1, 0x0009), (3, 0x0003), (15, 0x0200)] {
        assert_ne!(command(others | 1 << bit), command(others), "STW.{bit}");
    }
    for bit in [0, 3, 4, 5, 6, 7, 8, 9] {
        assert_ne!(command(1 << bit), command(0), "STW.{bit}");
    }
}

#[test]
fn outside_data_exchange_everything_is_0_and_the_keys_are_free() {
    let mut words = Words::default();
    words.command(Some((Stw::from_raw(0x007B), 7)));
    assert_eq!(words.command(None), Command { setpoint: 0, keys: true, ..command(0) });
    assert_eq!(words.stw(), Stw::default());
}

const MILLISECOND: Duration = Duration::from_millis(1);
const READY: State = State::ReadyToRun(Motor::Released);
const ENABLED: State = State::OperationEnabled(Motor::InControl);

/// A unit and its words, cycle by cycle.
struct Rig {
    unit: Unit,
    words: Words,
    connected: bool,
    stw: u16,
    setpoint: i32,
}

impl Rig {
    fn new(quirks: WordQuirks) -> Self {
        let unit = Unit::new(Config::new(Model::Ag03_1, Gear::Ratio48));
        Self { unit, words: Words::new(quirks), connected: true, stw: 0, setpoint: 0 }
    }

    fn travelling(quirks: WordQuirks) -> Self {
        let mut rig = Self::new(quirks);
        rig.stw(0x003B).travel(16_000).run(499);
        rig
    }

    fn run(&mut self, cycles: u32) -> &mut Self {
        for _ in 0..cycles {
            let outputs = (Stw::from_raw(self.stw), self.setpoint);
            let command = self.words.command(self.connected.then_some(outputs));
            self.unit.step(Duration::from_millis(1), &command);
            self.words.accept(self.unit.status());
        }
        self
    }

    fn stw(&mut self, stw: u16) -> &mut Self {
        self.stw = stw;
        self.run(1)
    }

    /// Lets STW.6 change, with this setpoint.
    fn travel(&mut self, setpoint: i32) -> &mut Self {
        self.setpoint = setpoint;
        self.stw(self.stw ^ 0x0040)
    }

    fn fails(&mut self, fails: bool) -> &mut Self {
        let _ = self.unit.set_inputs(Inputs { internal_fault: fails, ..Inputs::default() });
        self.run(1)
    }

    fn until(&mut self, state: State) {
        while self.state() != state {
            self.run(1);
        }
    }

    fn status(&self) -> &Status {
        self.unit.status()
    }

    fn state(&self) -> State {
        self.status().state
    }

    fn zsw(&self) -> u16 {
        self.words.zsw(self.status()).raw()
    }

    /// The newest refusal since this was asked last.
    fn refusal(&mut self) -> Option<Refusal> {
        let mut newest = None;
        while let Some(event) = self.unit.poll_event() {
            if let Event::CommandRefused(refusal) = event {
                newest = Refusal::told(refusal, &self.words).or(newest);
            }
        }
        newest
    }
}

/// With and without the quirk that `set` sets.
fn both(set: impl FnOnce(&mut WordQuirks)) -> [WordQuirks; 2] {
    let mut quirks = WordQuirks::default();
    set(&mut quirks);
    [WordQuirks::default(), quirks]
}

#[test]
fn a_refusal_names_the_bits_that_are_not_given() {
    for (stw, text) in [
        (
            0x0008,
            "enabling operation refused: OFF2 is given (STW.1 = 0); OFF1 is given (STW.0 = 0); next: send STW 000B",
        ),
        (0x0009, "enabling operation refused: OFF2 is given (STW.1 = 0); next: send STW 000B"),
        (0x000A, "enabling operation refused: OFF1 is given (STW.0 = 0); next: send STW 000B"),
        (
            0x0040,
            "travel to 0 inc refused: OFF2 is given (STW.1 = 0); OFF1 is given (STW.0 = 0); operation is not enabled \
             (STW.3 = 0); stop is given (STW.4 = 0); intermediate stop is given (STW.5 = 0); next: send STW 007B, wait for ZSW.2 = 1, then 003B",
        ),
        (
            0x0073,
            "travel to 0 inc refused: operation is not enabled (STW.3 = 0); next: send STW 007B, wait for ZSW.2 = 1, then 003B",
        ),
    ] {
        assert_eq!(
            Rig::new(WordQuirks::default()).stw(stw).refusal().unwrap().to_string(),
            text,
            "{stw:04X}"
        );
    }
    let mut rig = Rig::new(WordQuirks::default());
    rig.fails(true).fails(false).stw(0x0081);
    let text = rig.stw(0x000B).refusal().unwrap().to_string();
    assert_eq!(
        text,
        "enabling operation refused: turning on is disabled after a fault: give OFF1 once (STW.0 = 0); next: send STW \
         000A, then 000B"
    );
}

#[test]
fn off1_as_masters_of_the_profile_give_it_asks_for_nothing() {
    let mut rig = Rig::new(WordQuirks::default());
    assert_eq!(rig.stw(0x043E).refusal(), None);
    assert_eq!(rig.stw(0x043F).refusal(), None);
    assert_eq!(rig.zsw() & 0x0004, 0x0004, "operation is enabled");
    rig.fails(true).stw(0x043E);
    assert_eq!(rig.refusal(), None);
    let text = rig.stw(0x043F).refusal().unwrap().to_string();
    assert!(text.starts_with("enabling operation refused: fault"), "{text}");
}

#[test]
fn quirk_c05_a_paused_job_is_ready_or_still_active() {
    let [proposed, other] = both(|quirks| quirks.paused_is_active = true);
    for (quirks, zsw, ssw) in [(proposed, 0xA000, 0), (other, 0x2000, 0x4000)] {
        let mut rig = Rig::travelling(quirks);
        rig.stw(0x005B).run(1000);
        assert_eq!(rig.zsw() & 0xE000, zsw);
        assert_eq!(rig.words.system_status(rig.status()) & 0x4000, ssw);
        assert_eq!(rig.stw(0x007B).state(), State::TravelActive);
    }
}

#[test]
fn quirk_c06_turn_on_disabled_is_left_by_the_level_or_by_the_edge_of_off1() {
    let [proposed, other] = both(|quirks| quirks.off1_needs_edge = true);
    for (quirks, next) in [(proposed, READY), (other, State::TurnOnDisabled)] {
        let mut rig = Rig::new(quirks);
        rig.fails(true).fails(false).stw(0x0080).stw(0x0000);
        assert_eq!(rig.state(), next, "level");
        assert_eq!(rig.stw(0x0001).stw(0x0000).state(), READY, "edge");
    }
}

#[test]
fn quirk_c07_the_acknowledge_bit_toggles_or_takes_the_level_of_start() {
    let [proposed, other] = both(|quirks| quirks.acknowledge_mirrors_start = true);
    for (quirks, acknowledge) in [(proposed, 0x1000), (other, 0)] {
        let mut rig = Rig::new(quirks);
        // The rising edge is refused, the falling one accepted.
        rig.stw(0x003B).travel(2_000_000).travel(100);
        assert_eq!((rig.state(), rig.zsw() & 0x1000), (State::TravelActive, acknowledge));
    }
}

#[test]
fn quirk_c09_a_drive_in_fault_is_ready_to_turn_on_or_not() {
    let [proposed, other] = both(|quirks| quirks.not_ready_in_fault = true);
    for (quirks, bits) in [(proposed, 3), (other, 0)] {
        let mut rig = Rig::new(quirks);
        rig.fails(true);
        assert_eq!(rig.zsw() & 0x000B, 0x0008 | bits);
        rig.fails(false).stw(0x0080);
        assert_eq!(rig.zsw() & 0x0043, 0x0040 | bits);
        assert_eq!(rig.stw(0x0000).zsw() & 3, 3);
    }
}

#[test]
fn quirk_c23_off1_releases_at_once_or_after_braking() {
    let [proposed, other] = both(|quirks| quirks.off1_brakes = true);
    for (quirks, next) in [(proposed, READY), (other, State::Disabling)] {
        let mut rig = Rig::travelling(quirks);
        assert_eq!(rig.stw(0x007A).state(), next);
        rig.run(1000);
        assert_eq!((rig.state(), rig.status().moving), (READY, false));
        let mut rig = Rig::travelling(quirks);
        assert_eq!(rig.stw(0x0079).state(), READY, "OFF2 releases in any case");
    }
}

#[test]
fn quirk_c24_all_zero_outputs_let_the_shaft_run_out_or_brake_it() {
    let [proposed, other] = both(|quirks| quirks.all_zero_brakes = true);
    for (quirks, next, time) in [(proposed, READY, 499), (other, State::Disabling, 124)] {
        for connected in [true, false] {
            let mut rig = Rig::travelling(quirks);
            rig.connected = connected;
            assert_eq!(rig.stw(0x0000).state(), next);
            let mut cycles = 0;
            while rig.status().moving {
                rig.run(1);
                cycles += 1;
            }
            assert_eq!(cycles, time);
            assert_eq!(rig.run(2).state(), READY);
        }
    }
}

#[test]
fn quirk_c32_both_edges_of_start_start_or_only_the_rising_one() {
    let [proposed, other] = both(|quirks| quirks.start_needs_rising_edge = true);
    for (quirks, next) in [(proposed, State::TravelActive), (other, ENABLED)] {
        let mut rig = Rig::new(quirks);
        rig.stw(0x003B).travel(100);
        rig.until(ENABLED);
        assert_eq!(rig.travel(0).state(), next);
        assert_eq!(rig.refusal(), None, "a falling edge is no request then");
    }
}

#[test]
fn quirk_c35_target_reached_waits_for_the_end_of_the_job_or_is_live() {
    let [proposed, other] = both(|quirks| quirks.target_reached_live = true);
    for (quirks, reached) in [(proposed, 0), (other, 0x0400)] {
        let mut rig = Rig::new(quirks);
        rig.stw(0x003B).travel(5);
        assert_eq!((rig.state(), rig.zsw() & 0x0400), (State::TravelActive, reached));
        rig.until(ENABLED);
        assert_eq!(rig.zsw() & 0x0400, 0x0400);
    }
}

#[test]
fn quirk_c36_the_first_telegram_may_enable_or_off1_must_be_seen() {
    let [proposed, other] = both(|quirks| quirks.off1_must_be_seen = true);
    for (quirks, next) in [(proposed, ENABLED), (other, READY)] {
        let mut rig = Rig::new(quirks);
        assert_eq!(rig.stw(0x000B).state(), next);
        if next == READY {
            assert_eq!(
                rig.refusal().unwrap().to_string(),
                "enabling operation refused: OFF1 must be given once in Data_Exchange first (STW.0 = 0); next: send \
                 STW 000A, then 000B"
            );
        }
        assert_eq!(rig.stw(0x000A).stw(0x000B).state(), ENABLED);
        rig.connected = false;
        rig.run(1);
        rig.connected = true;
        assert_eq!(rig.run(1).state(), next, "each Data_Exchange anew");
    }
}

proptest! {
    /// What a device spares in its cycles: a held command is not composed, of the status of a travelling drive only what its
    /// shaft changes, and no status word while nothing else has changed.
    #[test]
    fn a_held_command_does_what_the_same_command_does(
        off1_needs_edge: bool, target_reached_live: bool,
        outputs in proptest::collection::vec((
            proptest::option::weighted(0.95, (
                prop_oneof![
                    4 => Just(0x003B), 4 => Just(0x007B), 1 => Just(0x005B), 1 => Just(0x006B), 1 => Just(0x000A),
                    1 => Just(0x0000), 1 => Just(0x013B), 1 => Just(0x023B), 1 => Just(0x00BB), 1 => any::<u16>(),
                ],
                prop_oneof![-300..300i32, -3000..3000i32],
            )),
            proptest::option::weighted(0.1, (0.0..8.0f64, any::<bool>(), 0.0..30.0f64)),
            1..300u32,
        ), 1..30),
    ) {
        let quirks = WordQuirks { off1_needs_edge, target_reached_live, ..WordQuirks::default() };
        let mut unit = Unit::new(Config::new(Model::Ag03_1, Gear::Ratio48));
        let mut whole = unit.clone();
        let (mut words, mut whole_words) = (Words::new(quirks), Words::new(quirks));
        let mut shown = None;
        for (asked, inputs, cycles) in outputs {
            let asked = asked.map(|(stw, setpoint)| (Stw::from_raw(stw), setpoint));
            if let Some((load_torque, blocked, output_supply)) = inputs {
                let inputs = Inputs { load_torque, blocked, output_supply, ..Inputs::default() };
                prop_assert_eq!(unit.set_inputs(inputs), whole.set_inputs(inputs));
            }
            for _ in 0..cycles {
                let held = words.is_held(asked);
                if held {
                    unit.hold(MILLISECOND);
                } else {
                    let command = words.command(asked);
                    unit.step(MILLISECOND, &command);
                }
                let command = whole_words.command(asked);
                whole.step(MILLISECOND, &command);
                words.accept(unit.status());
                whole_words.accept(whole.status());

                prop_assert_eq!(*unit.status(), whole.drive().status());
                let zsw = whole_words.zsw(whole.status());
                prop_assert_eq!(words.zsw(unit.status()), zsw);
                if held && let Some((changes, before)) = shown && changes == unit.changes() {
                    prop_assert_eq!(before, zsw);
                }
                shown = Some((unit.changes(), zsw));
                prop_assert_eq!(unit.is_at_rest(), whole.is_at_rest());
                loop {
                    let event = unit.poll_event();
                    prop_assert_eq!(&event, &whole.poll_event());
                    if event.is_none() {
                        break;
                    }
                }
            }
        }
    }
}
