//! `profidrive demo`: profirust's DP master and an emulated drive on a bus in memory, told as a story.
//!
//! The steps stand here in the order in which they are played. `stage` has the bus and the words on the page,
//! `telegram` and `words` say what octets and bits mean, `chart` draws a travel.

mod chart;
mod stage;
mod telegram;
mod words;

use core::time::Duration;
use std::io::{self, BufWriter, Write};

use profidrive::device::Event;
use profidrive::drive::{Fault, FaultSet, Inputs};
use profidrive::ppo::JobId;

use super::Failure;
use stage::{Stage, Trouble};

/// Mask and value of the status word in some states (`ag03.md` 5).
const READY_TO_RUN: (u16, u16) = (0xAB6F, 0x2B23);
const READY_TO_TRAVEL: (u16, u16) = (0xEB7F, 0xAB37);
const TRAVEL_JOB_ACTIVE: (u16, u16) = (0xEA7F, 0x0A37);
/// Paused looks like ready to travel, but away from the target.
const PAUSED: (u16, u16) = (0xEF7F, 0xAB37);
/// Ready to travel again, with the target position reached.
const ARRIVED: (u16, u16) = (0xEF7F, 0xAF37);
const FAULT: (u16, u16) = (0x0008, 0x0008);
const TURN_ON_DISABLED: (u16, u16) = (0x0048, 0x0040);

/// Control words: a disabled drive, an enabled one, and one that may travel.
const OFF: u16 = 0x0000;
const ENABLE: u16 = 0x000B;
const MAY_TRAVEL: u16 = 0x003B;
/// Bits of the control word.
const ON: u16 = 1 << 0;
const NO_INTERMEDIATE_STOP: u16 = 1 << 5;
const START: u16 = 1 << 6;
const ACKNOWLEDGE: u16 = 1 << 7;

/// Two turns of the shaft from where the calibration puts it.
const TARGET: i32 = 13_200;
/// Beyond limit 1.
const TOO_FAR: i32 = 300_000;

/// Plays the demo to stdout. Nobody need read it to the end.
pub(super) fn demo() -> Result<(), Failure> {
    let mut out = BufWriter::new(io::stdout().lock());
    let played = play(&mut out);
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
    stage.title("That is all")?;
    stage.text(
        "The same drive on a terminal that any PROFIBUS-DP master can open: profidrive emulate. \
         Everything about it: profidrive emulate --help.",
    )
}

fn start_up(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    stage.title("Start-up: what master and drive say until data flow")?;
    stage.text(
        "The master asks for a diagnosis until the drive answers, sends parameters and configuration, and asks \
         again whether the drive agrees. (FDL status is asked of every address now and then, to find masters.)",
    )?;
    stage.start_up()
}

fn parameters(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    stage.title("Parameters: words 1 to 4 of the seven in each Data_Exchange")?;
    stage.text(
        "PKE (job and number), IND, PWE (value, two words). The reply stays until the job is taken back.",
    )?;
    stage.job(
        JobId::WriteDoubleWord,
        1018,
        10_000,
        "write calibration value = 10000",
        "23FA 0000 0000 2710",
    )?;
    stage.job(JobId::Read, 1018, 0, "read calibration value", "23FA 0000 0000 2710")?;
    stage.job(JobId::WriteDoubleWord, 1016, 250_000, "write limit 1 = 250000", "23F8 0000 0003 D090")?;
    stage.job(JobId::WriteWord, 970, 5, "calibrate: the position is 10000 now", "23CA 0000 0000 0000")?;
    stage.job(JobId::WriteWord, 1003, 101, "write acceleration = 101 %", "73EB 0000 0000 0002")?;
    stage.reason(|event| matches!(event, Event::JobRefused(_)))
}

fn enable(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    stage.title("Enabling: word 5 is control word STW out and status word ZSW in")?;
    stage.command("disabled", OFF, 0, READY_TO_RUN)?;
    stage.command("enable operation", ENABLE, 0, READY_TO_TRAVEL)
}

fn travel(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    stage.title("A travel job: words 6 and 7 are setpoint out and position in")?;
    stage.text("Each change of STW.6 starts a job. STW.5 = 0 pauses it, STW.5 = 1 goes on.")?;
    stage.begin_recording();
    stage.command("no stop, no intermediate stop", MAY_TRAVEL, TARGET, READY_TO_TRAVEL)?;
    stage.run_for(Duration::from_millis(400));
    stage.mark("start");
    stage.command("start to 13200, two turns further", MAY_TRAVEL | START, TARGET, TRAVEL_JOB_ACTIVE)?;
    stage.run_for(Duration::from_millis(1_800));
    stage.mark("pause");
    let paused = (MAY_TRAVEL | START) & !NO_INTERMEDIATE_STOP;
    stage.command("pause", paused, TARGET, PAUSED)?;
    stage.run_for(Duration::from_millis(1_200));
    stage.mark("resume");
    stage.command("resume", MAY_TRAVEL | START, TARGET, TRAVEL_JOB_ACTIVE)?;
    stage.observe("at the target", ARRIVED)?;
    stage.mark("there");
    stage.run_for(Duration::from_millis(600));
    stage.draw_recording()
}

fn refused_travel(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    stage.title("A travel job that does not start")?;
    stage.command("start to 300000 (STW.6 changes)", MAY_TRAVEL, TOO_FAR, READY_TO_TRAVEL)?;
    stage.text("A real drive says no more than this: ZSW.12 did not change. The emulated one knows why:")?;
    stage.reason(|event| matches!(event, Event::CommandRefused(_)))
}

fn fault_and_recovery(stage: &mut Stage<'_>) -> Result<(), Trouble> {
    stage.title("A fault, and the way back")?;
    stage.plant(Inputs { causes: FaultSet::EMPTY.with(Fault::F), ..Inputs::default() });
    stage.observe("internal error provoked", FAULT)?;
    stage.reason(|event| matches!(event, Event::Fault(_)))?;
    stage.command("acknowledge while it lasts", MAY_TRAVEL | ACKNOWLEDGE, TARGET, FAULT)?;
    stage.reason(|event| matches!(event, Event::CommandRefused(_)))?;
    stage.plant(Inputs::default());
    stage.command("cause gone, acknowledge off", MAY_TRAVEL, TARGET, FAULT)?;
    stage.command("acknowledge", MAY_TRAVEL | ACKNOWLEDGE, TARGET, TURN_ON_DISABLED)?;
    stage.command("acknowledge off", MAY_TRAVEL, TARGET, TURN_ON_DISABLED)?;
    stage.command("OFF1, as turning on is disabled", MAY_TRAVEL & !ON, TARGET, READY_TO_RUN)?;
    stage.command("enable again", MAY_TRAVEL, TARGET, READY_TO_TRAVEL)?;
    stage.command("disable", OFF, 0, READY_TO_RUN)
}
