//! `profidrive demo`: profirust's DP master and an emulated drive on a bus in memory, explained step by step.
//!
//! The steps stand here in the order in which they are played. What octets and bits mean is known to
//! `crate::explain`.
//!
//! | file | holds |
//! | --- | --- |
//! | `stage` | the bus of this story |
//! | `nodes` | the stories of the devices on CANopen, another each |
//! | `node_stage` | the bus of those |
//! | `page` | the words on the page |
//! | `chart` | a travel as a picture |

mod chart;
mod node_stage;
mod nodes;
mod page;
mod stage;

use core::time::Duration;
use std::io::{self, BufWriter, Write};

use crate::client::ZswPattern;
use crate::devices::ag03::drive::{Fault, Inputs, Mode};
use crate::devices::ag03::profibus::bits::{StwBit, ZswBit};
use crate::devices::ag03::profibus::flow_charts;
use crate::face::EventKind;
use crate::profibus::ppo::{JobId, Stw};

use super::Failure;
use super::args::Demo;
use page::Trouble;
use stage::Stage;

/// What the status word looks like in some states.
const READY_TO_RUN: ZswPattern = ZswPattern::ready_to_run(Mode::Positioning);
const READY_TO_TRAVEL: ZswPattern = ZswPattern::ready_to_travel(Mode::Positioning);
/// A paused job looks like ready to travel, but away from the target.
const PAUSED: ZswPattern = READY_TO_TRAVEL.with(ZswBit::TargetReached, false);
/// Ready to travel again, with the target position reached.
const ARRIVED: ZswPattern = READY_TO_TRAVEL.with(ZswBit::TargetReached, true);
const FAULT: ZswPattern = ZswPattern::ANY.with(ZswBit::Fault, true);
const TURN_ON_DISABLED: ZswPattern =
    ZswPattern::ANY.with(ZswBit::Fault, false).with(ZswBit::TurnOnDisabled, true);

/// Control words: all off, an enabled drive, one that may travel, and one with the other start bit.
const OFF: Stw = Stw::from_raw(0);
const ENABLE: Stw = Stw::from_raw(flow_charts::ENABLED);
const MAY_TRAVEL: Stw = Stw::from_raw(flow_charts::TRAVEL);
const STARTED: Stw = Stw::from_raw(flow_charts::TRAVEL | flow_charts::START);

/// Two turns of the shaft from where the calibration puts it.
const TARGET: i32 = 13_200;
/// Beyond limit 1.
const TOO_FAR: i32 = 300_000;

/// Plays the demo to stdout. Nobody need read it to the end.
pub(super) fn demo(args: &Demo) -> Result<(), Failure> {
    let mut out = BufWriter::new(io::stdout().lock());
    let played = match args.device {
        Some(product) => nodes::play(product, &mut out),
        None => play(&mut out),
    };
    // What was seen before something went wrong belongs to the story.
    let written = out.flush();
    match played.and(written.map_err(Trouble::Out)) {
        Ok(()) => Ok(()),
        Err(Trouble::Out(error)) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        Err(Trouble::Out(error)) => Err(Failure::Other(format!("cannot write to stdout: {error}"))),
        Err(Trouble::Unexpected(line)) => Err(Failure::Other(line)),
    }
}

fn play(out: &mut dyn Write) -> Result<(), Trouble> {
    let mut stage = Stage::open(out)?;
    start_up(&mut stage)?;
    parameters(&mut stage)?;
    enable(&mut stage)?;
    travel(&mut stage)?;
    refused_travel(&mut stage)?;
    fault_and_recovery(&mut stage)?;
    stage.page.title("That is all")?;
    stage.page.text(
        "The same drive on a terminal that any PROFIBUS-DP master can open: profidrive emulate. \
         Everything about it: profidrive emulate --help.",
    )
}

fn start_up(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    stage.page.title("Start-up: the telegrams of master and drive until Data_Exchange")?;
    stage.page.text(
        "The master asks for a diagnosis until the drive answers, sends parameters and configuration, and asks \
         again whether the drive agrees. (FDL status is asked of every address now and then, to find masters.)",
    )?;
    stage.start_up()
}

fn parameters(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    stage.page.title("Parameters: words 1 to 4 of the seven in each Data_Exchange")?;
    stage.page.text(
        "PKE (job and number), IND, PWE (value, two words). The reply stays until the job is taken back.",
    )?;
    stage.job(
        JobId::WriteDoubleWord,
        1018,
        10_000,
        "write calibration value 10000",
        "23FA 0000 0000 2710",
    )?;
    stage.job(JobId::Read, 1018, 0, "read calibration value", "23FA 0000 0000 2710")?;
    stage.job(JobId::WriteDoubleWord, 1016, 250_000, "write limit 1 as 250000", "23F8 0000 0003 D090")?;
    stage.job(JobId::WriteWord, 970, 5, "calibrate, position is 10000", "23CA 0000 0000 0000")?;
    stage.job(JobId::WriteWord, 1003, 101, "write acceleration 101 %", "73EB 0000 0000 0002")?;
    stage.reason(EventKind::JobRefused)
}

fn enable(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    stage.page.title("Enabling: word 5 is control word STW out and status word ZSW in")?;
    stage.page.text("STW with what the master changes, ZSW with what the drive says and where it is.")?;
    stage.observe(READY_TO_RUN)?;
    stage.command("enable", ENABLE, 0, READY_TO_TRAVEL)
}

fn travel(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    stage.page.title("A travel job: words 6 and 7 are setpoint out and position in")?;
    stage.page.text("Each change of STW.6, the start bit, starts a job; STW.5 = 0 pauses it.")?;
    stage.begin_recording();
    stage.command("prepare", MAY_TRAVEL, TARGET, READY_TO_TRAVEL)?;
    stage.run_for(Duration::from_millis(400));
    stage.mark("start");
    stage.command("start to 13200", STARTED, TARGET, ZswPattern::TRAVEL_JOB)?;
    stage.run_for(Duration::from_millis(1_800));
    stage.mark("pause");
    stage.command("pause", Stw::from_raw(flow_charts::PAUSED | flow_charts::START), TARGET, PAUSED)?;
    stage.run_for(Duration::from_millis(1_200));
    stage.mark("resume");
    stage.command("resume", STARTED, TARGET, ZswPattern::TRAVEL_JOB)?;
    stage.observe(ARRIVED)?;
    stage.mark("there");
    stage.run_for(Duration::from_millis(600));
    stage.draw_recording()
}

fn refused_travel(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    stage.page.title("A travel job that does not start")?;
    stage.command("start to 300000", MAY_TRAVEL, TOO_FAR, READY_TO_TRAVEL)?;
    stage.page.text("A real drive shows only that no job was accepted. The emulated one says why:")?;
    stage.reason(EventKind::CommandRefused)
}

fn fault_and_recovery(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    let acknowledge = MAY_TRAVEL.with_bit(StwBit::Acknowledge.number(), true);
    stage.page.title("A fault, and how to leave it")?;
    stage.page.text("An internal error of the drive is simulated.")?;
    stage.surround(Inputs::default().provoking(Fault::F));
    stage.observe(FAULT)?;
    stage.reason(EventKind::Fault)?;
    stage.command("too early", acknowledge, TARGET, FAULT)?;
    stage.reason(EventKind::CommandRefused)?;
    stage.page.text("The cause is removed.")?;
    stage.surround(Inputs::default());
    stage.command("again", MAY_TRAVEL, TARGET, FAULT)?;
    stage.command("now", acknowledge, TARGET, TURN_ON_DISABLED)?;
    stage.command("turn off once", MAY_TRAVEL.with_bit(StwBit::On.number(), false), TARGET, READY_TO_RUN)?;
    stage.command("turn on", MAY_TRAVEL, TARGET, READY_TO_TRAVEL)?;
    stage.command("disable", OFF, 0, READY_TO_RUN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn story() -> String {
        let mut out = Vec::new();
        play(&mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn the_story_is_told_to_its_end_on_a_page_of_80_columns() {
        let story = story();
        assert!(story.lines().all(|line| line.chars().count() <= 80), "{story}");
        assert!(!story.contains('\u{1b}'), "plain text");
        let mut rest = &story[..];
        for part in [
            "Slave_Diag request",
            "68 0C 0C 68 85 82 5C 3D 3E B8 01 14 0B 0A C5 00",
            "Chk_Cfg: 14 octets of outputs and 14 of inputs",
            "diagnosis: ready for data",
            "13FA 0000 0000 0000",
            "23FA 0000 0000 2710",
            "33F8 0000 0003 D090",
            "23F8 0000 0003 D090",
            "error 2, value outside the limits",
            "enabled, ready to travel",
            "job accepted",
            "^start",
            "^there",
            "setpoint is above the upper",
            "fault F (internal error)",
            "turn-on disabled",
            "disable operation",
            "ready to turn on",
        ] {
            let found = rest.find(part).unwrap_or_else(|| panic!("no '{part}' in\n{rest}"));
            rest = &rest[found..];
        }
    }

    #[test]
    fn the_story_is_always_the_same() {
        assert_eq!(story(), story());
    }

    #[test]
    fn a_page_that_cannot_be_written_ends_the_story() {
        struct Full(usize);
        impl Write for Full {
            fn write(&mut self, buf: &[u8]) -> io::Result<usize> {
                self.0 = self.0.checked_sub(1).ok_or(io::ErrorKind::BrokenPipe)?;
                Ok(buf.len())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        for lines in [0, 1, 50, 200] {
            let ended = play(&mut Full(lines)).unwrap_err();
            assert!(matches!(ended, Trouble::Out(error) if error.kind() == io::ErrorKind::BrokenPipe));
        }
    }
}
