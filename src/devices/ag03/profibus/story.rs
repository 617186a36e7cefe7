//! The story of the AG03 and AG03/1 on PROFIBUS.

use core::time::Duration;

use super::bits::{StwBit, ZswBit};
use super::flow_charts;
use crate::devices::ag03::drive::Mode;
use crate::devices::story::SlaveAct::{
    self, Command, Draw, Job, Mark, Observe, Pass, Provoke, Reason, Record, Repair, StartUp, Text, Title,
};
use crate::face::EventKind;
use crate::profibus::ppo::{JobId, Stw, ZswPattern};

/// What the status word looks like in some states.
const READY_TO_RUN: ZswPattern = flow_charts::ready_to_run(Mode::Positioning);
const READY_TO_TRAVEL: ZswPattern = flow_charts::ready_to_travel(Mode::Positioning);
/// A paused job looks like ready to travel, but away from the target.
const PAUSED: ZswPattern = READY_TO_TRAVEL.with(ZswBit::TargetReached.number(), false);
/// Ready to travel again, with the target position reached.
const ARRIVED: ZswPattern = READY_TO_TRAVEL.with(ZswBit::TargetReached.number(), true);
const FAULT: ZswPattern = ZswPattern::ANY.with(ZswBit::Fault.number(), true);
const TURN_ON_DISABLED: ZswPattern =
    ZswPattern::ANY.with(ZswBit::Fault.number(), false).with(ZswBit::TurnOnDisabled.number(), true);

/// Control words: all off, an enabled drive, one that may travel, and one with the other start bit.
const OFF: Stw = Stw::from_raw(0);
const ENABLE: Stw = Stw::from_raw(flow_charts::ENABLED);
const MAY_TRAVEL: Stw = Stw::from_raw(flow_charts::TRAVEL);
const STARTED: Stw = Stw::from_raw(flow_charts::TRAVEL | flow_charts::START);

const PAUSE: Stw = Stw::from_raw(flow_charts::PAUSED | flow_charts::START);
const ACKNOWLEDGE: Stw = MAY_TRAVEL.with_bit(StwBit::Acknowledge.number(), true);
const OFF1: Stw = MAY_TRAVEL.with_bit(StwBit::On.number(), false);

/// Two turns of the shaft from where the calibration puts it.
const TARGET: i32 = 13_200;
/// Beyond limit 1.
const TOO_FAR: i32 = 300_000;

/// Start-up, parameters, a travel job, one that does not start, a fault.
pub(crate) const STORY: &[SlaveAct] = &[
    Title("Start-up: the telegrams of master and drive until Data_Exchange"),
    Text(
        "The master asks for a diagnosis until the drive answers, sends parameters and configuration, and asks \
         again whether the drive agrees. (FDL status is asked of every address now and then, to find masters.)",
    ),
    StartUp,
    Title("Parameters: words 1 to 4 of the seven in each Data_Exchange"),
    Text("PKE (job and number), IND, PWE (value, two words). The reply stays until the job is taken back."),
    Job {
        job: JobId::WriteDoubleWord,
        pnu: 1018,
        value: 10_000,
        meaning: "write calibration value 10000",
        reply: "23FA 0000 0000 2710",
    },
    Job {
        job: JobId::Read,
        pnu: 1018,
        value: 0,
        meaning: "read calibration value",
        reply: "23FA 0000 0000 2710",
    },
    Job {
        job: JobId::WriteDoubleWord,
        pnu: 1016,
        value: 250_000,
        meaning: "write limit 1 as 250000",
        reply: "23F8 0000 0003 D090",
    },
    Job {
        job: JobId::WriteWord,
        pnu: 970,
        value: 5,
        meaning: "calibrate, position is 10000",
        reply: "23CA 0000 0000 0000",
    },
    Job {
        job: JobId::WriteWord,
        pnu: 1003,
        value: 101,
        meaning: "write acceleration 101 %",
        reply: "73EB 0000 0000 0002",
    },
    Reason(EventKind::JobRefused),
    Title("Enabling: word 5 is control word STW out and status word ZSW in"),
    Text("STW with what the master changes, ZSW with what the drive says and where it is."),
    Observe(READY_TO_RUN),
    Command("enable", ENABLE, 0, READY_TO_TRAVEL),
    Title("A travel job: words 6 and 7 are setpoint out and position in"),
    Text("Each change of STW.6, the start bit, starts a job; STW.5 = 0 pauses it."),
    Record,
    Command("prepare", MAY_TRAVEL, TARGET, READY_TO_TRAVEL),
    Pass(Duration::from_millis(400)),
    Mark("start"),
    Command("start to 13200", STARTED, TARGET, flow_charts::TRAVELS),
    Pass(Duration::from_millis(1_800)),
    Mark("pause"),
    Command("pause", PAUSE, TARGET, PAUSED),
    Pass(Duration::from_millis(1_200)),
    Mark("resume"),
    Command("resume", STARTED, TARGET, flow_charts::TRAVELS),
    Observe(ARRIVED),
    Mark("there"),
    Pass(Duration::from_millis(600)),
    Draw,
    Title("A travel job that does not start"),
    Command("start to 300000", MAY_TRAVEL, TOO_FAR, READY_TO_TRAVEL),
    Text("A real drive shows only that no job was accepted. The emulated one says why:"),
    Reason(EventKind::CommandRefused),
    Title("A fault, and how to leave it"),
    Text("An internal error of the drive is simulated."),
    Provoke("F"),
    Observe(FAULT),
    Reason(EventKind::Fault),
    Command("too early", ACKNOWLEDGE, TARGET, FAULT),
    Reason(EventKind::CommandRefused),
    Text("The cause is removed."),
    Repair,
    Command("again", MAY_TRAVEL, TARGET, FAULT),
    Command("now", ACKNOWLEDGE, TARGET, TURN_ON_DISABLED),
    Command("turn off once", OFF1, TARGET, READY_TO_RUN),
    Command("turn on", MAY_TRAVEL, TARGET, READY_TO_TRAVEL),
    Command("disable", OFF, 0, READY_TO_RUN),
];
