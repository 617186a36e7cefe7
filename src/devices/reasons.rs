//! What keeps a device from moving whatever it is: reasons of every slave of PROFIBUS and of every node of CANopen.

use core::fmt;

use crate::can_bus::canopen::NmtState;
use crate::face::Reason;
use crate::profibus::dp;

/// It has no control supply.
pub(super) const SWITCHED_OFF: Reason<'static> =
    Reason::new("SwitchedOff", &"the drive is switched off: switch its supply on");

/// 6060h is 0.
pub(crate) const NO_MODE: Reason<'static> =
    Reason::new("NoMode", &"no mode of operation is chosen: write 6060h");

/// Bit 8 of the controlword.
pub(crate) const HALT: Reason<'static> = Reason::new("Halt", &"bit 8 of 6040h is 1: halt");

/// Tells what of the slave in front of a drive keeps control words from it. `outputs` are what the master sends it;
/// `cfg_advice` is what to do about a refused Chk_Cfg.
pub(super) fn of_slave(
    state: dp::State,
    diagnosis: &dp::Diagnosis,
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
    match state {
        dp::State::WaitPrm if diagnosis.prm_fault => waits(
            &", the last Set_Prm was refused (Slave_Diag octet 1 bit 6, Prm_Fault): correct the master's project, the log \
              says what is wrong",
            tell,
        ),
        dp::State::WaitPrm if diagnosis.cfg_fault => waits(
            &format_args!(
                ", the last Chk_Cfg was refused (Slave_Diag octet 1 bit 2, Cfg_Fault): {cfg_advice}"
            ),
            tell,
        ),
        dp::State::WaitPrm => waits(
            &": it waits for Set_Prm; start the master, check its station list and the rate of the line",
            tell,
        ),
        dp::State::WaitCfg => waits(&": it was parameterised and waits for Chk_Cfg", tell),
        dp::State::DataExch if outputs.iter().all(|octet| *octet == 0) => {
            let text = "all outputs are 0: the master is in CLEAR (a PLC in STOP), has sent Clear_Data, or writes nothing";
            tell(Reason::new("OutputsZero", &text));
        }
        dp::State::DataExch => {}
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

/// Tells in which NMT state a node does not carry out PDOs.
pub(crate) fn of_node(state: NmtState, tell: &mut dyn FnMut(Reason<'_>)) {
    match state {
        NmtState::Operational => {}
        NmtState::PreOperational | NmtState::Stopped => {
            tell(Reason::new(
                "NmtState",
                &format_args!("NMT state {state}, PDOs are not carried out: send NMT start (01h)"),
            ));
        }
    }
}
