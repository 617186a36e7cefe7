//! What keeps a device from moving whatever it is: reasons of every slave of PROFIBUS and of every node of CANopen.

use core::fmt;

use crate::can_bus::canopen::{AwaitsSync, NmtState};
use crate::can_bus::cia402::{Controlword, Mode};
use crate::face::Reason;
use crate::profibus::dp;
use crate::profibus::fdl::Address;

/// It has no control supply.
pub(super) const SWITCHED_OFF: Reason<'static> =
    Reason::new("SwitchedOff", &"the drive is switched off: switch its supply on");

/// 6060h is 0.
pub(crate) const NO_MODE: Reason<'static> =
    Reason::new("NoMode", &"no mode of operation is chosen: write 6060h");

/// Bit 8 of the controlword.
pub(crate) const HALT: Reason<'static> = Reason::new("Halt", &"bit 8 of 6040h is 1: halt");

/// Tells what of the slave in front of a drive keeps control words from it.
/// `cfg_advice` is what to do about a refused Chk_Cfg.
pub(super) fn of_slave<A: dp::Application>(
    slave: &dp::Slave<A>,
    cfg_advice: &'static str,
    tell: &mut dyn FnMut(Reason<'_>),
) {
    #[cfg(feature = "std")]
    let ended = slave.ended();
    #[cfg(not(feature = "std"))]
    let ended = None;
    of_parts(slave.state(), &slave.diagnosis(), ended, slave.outputs(), cfg_advice, tell);
}

/// The same of its parts. `ended` is what ended the last data exchange.
pub(super) fn of_parts(
    state: dp::State,
    diagnosis: &dp::Diagnosis,
    ended: Option<dp::Event>,
    outputs: &[u8],
    cfg_advice: &'static str,
    tell: &mut dyn FnMut(Reason<'_>),
) {
    let waits = |for_what: &dyn fmt::Display, tell: &mut dyn FnMut(Reason<'_>)| {
        tell(Reason::new(
            "NoDataExchange",
            &format_args!("no master exchanges data with the drive{for_what}"),
        ));
    };
    match (state, ended) {
        (dp::State::WaitPrm, _) if diagnosis.prm_fault => waits(
            &", the last Set_Prm was refused (Slave_Diag octet 1 bit 6, Prm_Fault): correct the master's project, the log \
              says what is wrong",
            tell,
        ),
        (dp::State::WaitPrm, _) if diagnosis.cfg_fault => waits(
            &format_args!(
                ", the last Chk_Cfg was refused (Slave_Diag octet 1 bit 2, Cfg_Fault): {cfg_advice}"
            ),
            tell,
        ),
        (dp::State::WaitPrm, Some(ended)) => waits(&format_args!(": {ended}"), tell),
        (dp::State::WaitPrm, None) => waits(
            &": it waits for Set_Prm; start the master, check its station list and the rate of the line",
            tell,
        ),
        (dp::State::WaitCfg, _) => match diagnosis.master {
            Some(master) => waits(
                &format_args!(
                    ": it was parameterised by master {master} and waits for its Chk_Cfg; send it, or let that master unlock \
                     the slave (Set_Prm with Unlock_Req)"
                ),
                tell,
            ),
            None => waits(&": it was parameterised and waits for Chk_Cfg", tell),
        },
        (dp::State::DataExch, _) if outputs.iter().all(|octet| *octet == 0) => {
            let master = diagnosis.master.map_or(255, Address::number);
            tell(Reason::new(
                "OutputsZero",
                &format_args!(
                    "all outputs of master {master} are 0: it is in CLEAR (a PLC in STOP), has sent Clear_Data, or writes nothing"
                ),
            ));
        }
        (dp::State::DataExch, _) => {}
    }
    if diagnosis.sync_mode {
        let text = "Sync holds the outputs, new control words do not reach the drive: send Global_Control with Unsync";
        tell(Reason::new("SyncHolds", &text));
    }
    if diagnosis.freeze_mode {
        let text = "Freeze holds the inputs, the master does not see that the status word changes: send Global_Control with \
                    Unfreeze";
        tell(Reason::new("FreezeHolds", &text));
    }
}

/// What an enabled drive of CiA 402 waits for where nothing keeps it from moving.
pub(crate) fn waits_for(mode: Option<Mode>, word: Controlword) -> &'static dyn fmt::Display {
    const START: &&str = &"it waits for the start: send 6040h = 000Fh, then 001Fh";
    match mode {
        None => &"it waits for a mode: write 6060h",
        Some(Mode::ProfilePosition) => {
            &"it waits for a set-point: write another target (607Ah), then send 6040h = 000Fh, then 001Fh"
        }
        Some(Mode::Velocity) => &"it waits for a target velocity: write another one (6042h = 0 or too small)",
        Some(Mode::ProfileVelocity | Mode::CyclicVelocity) => {
            &"it waits for a target velocity: write another one (60FFh = 0 or too small)"
        }
        Some(Mode::ProfileTorque | Mode::CyclicTorque) => {
            &"it waits for a target torque: write another one (6071h = 0 or too small)"
        }
        Some(Mode::Homing) => START,
        Some(Mode::InterpolatedPosition) if !word.has(Controlword::NEW_SET_POINT) => START,
        Some(Mode::InterpolatedPosition) => &"it waits for another set-point (60C1h) and SYNC (1005h)",
        Some(Mode::CyclicPosition) => &"it waits for another target (607Ah) and SYNC (1005h)",
    }
}

/// Tells in which NMT state a node does not carry out PDOs, and which of them waits for SYNC in vain.
pub(crate) fn of_node(state: NmtState, awaits: Option<AwaitsSync>, tell: &mut dyn FnMut(Reason<'_>)) {
    match (state, awaits) {
        (NmtState::Operational, Some(pdo @ AwaitsSync::Rpdo(_))) => tell(Reason::new(
            "SyncMissing",
            &format_args!("{pdo}, its control word does not reach the drive: {}", pdo.cure()),
        )),
        (NmtState::Operational, Some(pdo @ AwaitsSync::Tpdo(_))) => tell(Reason::new(
            "SyncMissing",
            &format_args!("{pdo}, the master does not see what the drive does: {}", pdo.cure()),
        )),
        (NmtState::Operational, None) => {}
        (NmtState::PreOperational | NmtState::Stopped, _) => {
            tell(Reason::new(
                "NmtState",
                &format_args!("NMT state {state}, PDOs are not carried out: send NMT start (01h)"),
            ));
        }
    }
}
