//! What is done at the slave beside requests, and how its outputs and the effect of Global_Control are seen.

use core::time::Duration;

use super::{FREEZE, SYNC, Tester};
use crate::host::octets_of_hex;
use crate::judge::device::course::{Course, broken, inapplicable, missed};
use crate::judge::device::slave::answer::Answer;
use crate::profibus::dp::{DiagBit, Service};
use crate::profibus::fdl::{Address, ReplyStatus};

/// A device-related block of two octets, as `set-diag` takes it.
const DIAGNOSIS: &str = "set-diag 0201";
/// A command has its effect within so long.
const EFFECT: Duration = Duration::from_millis(20);

/// Commands of Global_Control.
pub(in super::super) const CLEAR: u8 = 0x02;
pub(in super::super) const UNFREEZE_COMMAND: u8 = 0x04;
pub(in super::super) const FREEZE_COMMAND: u8 = 0x08;
pub(in super::super) const UNSYNC_COMMAND: u8 = 0x10;
pub(in super::super) const SYNC_COMMAND: u8 = 0x20;

/// What shows that Global_Control was carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Effect {
    /// Sync_Mode of the diagnosis.
    Sync,
    /// Freeze_Mode of the diagnosis.
    Freeze,
    /// Outputs that are zero.
    Clear,
}

impl Effect {
    /// What Set_Prm asks for.
    pub(in super::super) const fn request_bits(self) -> u8 {
        match self {
            Self::Sync => SYNC,
            Self::Freeze => FREEZE,
            Self::Clear => 0,
        }
    }

    /// The command.
    pub(in super::super) const fn command(self) -> u8 {
        match self {
            Self::Sync => SYNC_COMMAND,
            Self::Freeze => FREEZE_COMMAND,
            Self::Clear => CLEAR,
        }
    }

    /// Whether a command, sent so, has its effect. In the end it has none any more.
    pub(in super::super) fn is_had(
        self,
        tester: &mut Tester,
        send: impl FnOnce(&mut Tester) -> Course,
    ) -> Course<bool> {
        let pattern = tester.pattern(0x55);
        if self == Self::Clear {
            tester.exchanged(&pattern)?;
        }
        send(tester)?;
        let had = match self {
            Self::Sync => tester.diag()?.is(DiagBit::SyncMode),
            Self::Freeze => tester.diag()?.is(DiagBit::FreezeMode),
            Self::Clear => tester.outputs()? != pattern,
        };
        match self {
            Self::Sync => tester.control(UNSYNC_COMMAND, 0)?,
            Self::Freeze => tester.control(UNFREEZE_COMMAND, 0)?,
            Self::Clear => {}
        }
        Ok(had)
    }

    /// The command to these groups has its effect, or must not.
    pub(in super::super) fn try_group(
        self,
        tester: &mut Tester,
        groups: u8,
        expected: bool,
        what: &str,
    ) -> Course {
        let command = self.command();
        self.must_be(tester, expected, what, |tester| tester.control(command, groups))
    }

    /// What is sent has the effect, or must not.
    pub(in super::super) fn must_be(
        self,
        tester: &mut Tester,
        expected: bool,
        what: &str,
        send: impl FnOnce(&mut Tester) -> Course,
    ) -> Course {
        let had = self.is_had(tester, send)?;
        match (had, expected) {
            (true, false) => broken(format!("{self:?} of {what} is carried out")),
            (false, true) => broken(format!("{self:?} of {what} is not carried out")),
            (true, true) | (false, false) => Ok(()),
        }
    }
}

impl Tester {
    /// To data exchange; that it does not come there is this row's failure.
    pub(in super::super) fn must_start(&mut self) -> Course {
        let prm = self.prm();
        self.start_with(&prm)
    }

    /// Says nothing for so long.
    pub(in super::super) fn pause(&mut self, time: Duration) -> Course {
        self.wire.pass(self.wire.now().saturating_add(time))
    }

    /// Switches the slave off and on.
    pub(in super::super) fn power_cycle(&mut self) -> Course {
        self.attend("power-cycle")?;
        self.look()?;
        for sa in [self.owner(), self.other()] {
            self.forget_count(sa);
        }
        self.min_tsdr = 11;
        Ok(())
    }

    /// It has this address now.
    pub(in super::super) fn move_to(&mut self, address: u8) {
        self.setup.address = Address::from_octet(address);
        self.forget_count(self.owner());
        self.forget_count(self.other());
    }

    /// Looks for it where it must be now.
    pub(in super::super) fn look_briefly(&mut self) -> Course {
        self.pause(EFFECT)?;
        self.look()
    }

    /// Waits until an action has its effect.
    pub(in super::super) fn effect(&mut self) -> Course {
        self.pause(EFFECT)
    }

    /// The slave has a diagnosis to tell.
    pub(in super::super) fn raise_diagnosis(&mut self) -> Course {
        self.attend(DIAGNOSIS)?;
        self.pause(EFFECT)
    }

    /// It has none any more.
    pub(in super::super) fn drop_diagnosis(&mut self) -> Course {
        self.attend("set-diag none")?;
        self.pause(EFFECT)
    }

    /// Whether outputs other than zero may be sent, and there are outputs.
    pub(in super::super) fn may_set_outputs(&self) -> Course {
        if self.lengths.outputs == 0 {
            return inapplicable("the slave has no outputs");
        }
        if !self.setup.moves_allowed {
            return inapplicable("needs --moves-allowed: outputs other than zero are sent");
        }
        Ok(())
    }

    /// Outputs that are told apart by `seed`.
    pub(in super::super) fn pattern(&self, seed: u8) -> Vec<u8> {
        vec![seed; self.lengths.outputs.into()]
    }

    /// The outputs as they are now: by RD_Outp, or as somebody at the slave reads them.
    pub(in super::super) fn outputs(&mut self) -> Course<Vec<u8>> {
        let expected = usize::from(self.lengths.outputs);
        let answer = self.serve(self.other(), Service::RdOutp, &[])?;
        if let Answer::Data(ReplyStatus::DataLow | ReplyStatus::DataHigh, outputs) = &answer
            && outputs.len() == expected
        {
            return Ok(outputs.clone());
        }
        if !self.is_attended() {
            return missed(format!(
                "its outputs cannot be seen: RD_Outp is answered with {}, and there is no --ask",
                answer.words()
            ));
        }
        let said = self.attend("read-output")?;
        match octets_of_hex(said.trim()) {
            Some(octets) if octets.len() == expected => Ok(octets),
            Some(_) | None => missed(format!("--ask read-output says '{}'", said.trim())),
        }
    }

    /// The outputs are these.
    pub(in super::super) fn outputs_are(&mut self, expected: &[u8], when: &str) -> Course {
        let outputs = self.outputs()?;
        if outputs == expected {
            return Ok(());
        }
        let hex = |octets: &[u8]| crate::explain::hex(octets);
        broken(format!("{when} its outputs are {}, expected {}", hex(&outputs), hex(expected)))
    }

    /// Whether the slave offers what these bits of Set_Prm ask for.
    pub(in super::super) fn offers(&mut self, bits: u8) -> Course<bool> {
        if let Some(gsd) = &self.setup.gsd {
            let offered = [(SYNC, gsd.flags.sync), (FREEZE, gsd.flags.freeze)];
            return Ok(offered.iter().all(|(bit, is_offered)| bits & bit == 0 || *is_offered));
        }
        let prm = self.prm().with(bits);
        self.set_prm(&prm)?;
        let diagnosis = self.diag()?;
        self.release()?;
        Ok(!diagnosis.is(DiagBit::NotSupported) && !diagnosis.is(DiagBit::PrmReq))
    }

    /// What shows that Global_Control is carried out.
    pub(in super::super) fn effect_of_control(&mut self) -> Course<Effect> {
        if self.offers(SYNC)? {
            Ok(Effect::Sync)
        } else if self.offers(FREEZE)? {
            Ok(Effect::Freeze)
        } else {
            self.may_set_outputs()?;
            Ok(Effect::Clear)
        }
    }
}
