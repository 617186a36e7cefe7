//! Reactions to the services that lead to Data_Exchange: Set_Prm, Chk_Cfg and Set_Slave_Add.

use super::{CfgTicket, Handled, Pending, Slave};
use crate::profibus::dp::buffer::Buffer;
use crate::profibus::dp::policy::{ApplicationReady, SetPrmInDataExch};
use crate::profibus::dp::watchdog::Watchdog;
use crate::profibus::dp::{
    AddressFault, Application, CfgFault, Configuration, Event, IoLengths, PrmFault, SetPrm, SetSlaveAdd,
    State, Stimulus,
};
use crate::profibus::fdl::{Address, Request};
use crate::time::Instant;

impl<A: Application> Slave<A> {
    /// `dp-v0.md` 5.2; the numbers are its steps.
    pub(super) fn set_prm(&mut self, now: Instant, request: &Request<'_>) -> Handled<'static> {
        let master = request.sa;
        // 2: locked by another master.
        if let Some(owner) = self.owner.filter(|owner| *owner != master) {
            self.state = self.state.on(Stimulus::ForeignPrm);
            let event = Some(Event::PrmForeign { master, owner });
            return Handled { event, ..Handled::reply(self.policy.foreign_set_prm.into()) };
        }
        Handled::acknowledge(self.own_prm(now, request))
    }

    fn own_prm(&mut self, now: Instant, request: &Request<'_>) -> Option<Event> {
        let master = request.sa;
        let prm = match SetPrm::parse(request.data) {
            Ok(prm) => prm,
            // 1
            Err(fault) => return Some(self.refuse_prm(master, fault)),
        };
        // 4
        if prm.unlock_req() {
            let released = self.owner.is_some();
            self.leave_master(Stimulus::Unlocked);
            return released.then(|| self.ends_with(Event::Released { master }));
        }
        // 3: carried out even when the ident number is another one.
        if !prm.lock_req() {
            self.min_tsdr = prm.min_tsdr().or(self.min_tsdr);
            self.state = self.state.on(Stimulus::MinTsdrOnly);
            return Some(Event::MinTsdrOnly { master, min_tsdr: prm.min_tsdr() });
        }
        match self.policy.set_prm_in_data_exch {
            SetPrmInDataExch::StayIfIdentical
                if self.state == State::DataExch && self.accepted_prm.octets() == request.data =>
            {
                self.min_tsdr = prm.min_tsdr().or(self.min_tsdr);
                self.state = self.state.on(Stimulus::PrmRepeated);
                return None;
            }
            SetPrmInDataExch::StayIfIdentical | SetPrmInDataExch::WaitCfg => {}
        }
        // 5, 6, 7, 8, 9
        if let Err(fault) = prm.check(&self.description, &self.application, &self.policy) {
            return Some(self.refuse_prm(master, fault));
        }
        // 10
        self.leave_master(Stimulus::PrmAccepted);
        let watchdog =
            if self.description.dpv1_status.is_some() { prm.dpv1_watchdog() } else { prm.watchdog() };
        self.owner = Some(master);
        self.watchdog = watchdog.map(|time| Watchdog { time, heard: now });
        self.min_tsdr = prm.min_tsdr().or(self.min_tsdr);
        self.group_ident = prm.group_ident();
        self.prm_fault = false;
        // 7: shown, and the start-up goes on.
        self.not_supported = prm.not_supported(&self.description);
        self.process_data.enable(prm, &self.description);
        self.accepted_prm.keep([request.data, &[]]);
        Some(Event::Parameterised {
            master,
            watchdog,
            min_tsdr: prm.min_tsdr(),
            groups: self.group_ident,
            not_supported: self.not_supported,
        })
    }

    fn refuse_prm(&mut self, master: Address, fault: PrmFault) -> Event {
        self.prm_fault = true;
        self.not_supported |= matches!(fault, PrmFault::NotSupported { .. });
        self.leave_master(Stimulus::PrmRejected);
        Event::PrmRejected { master, fault }
    }

    /// Parameters beside those of Set_Prm are wrong.
    pub(crate) fn reject_prm(&mut self) {
        self.prm_fault = true;
        self.leave_master(Stimulus::PrmRejected);
    }

    pub(super) fn chk_cfg(&mut self, now: Instant, request: &Request<'_>) -> Option<Event> {
        let master = request.sa;
        let lengths = match self.judged_cfg(request.data) {
            Ok(lengths) => lengths,
            Err(fault) => return Some(self.refuse_cfg(master, fault)),
        };
        let mut configuration = Buffer::EMPTY;
        configuration.keep([request.data, &[]]);
        match self.policy.application_ready {
            // What is exchanged already needs no second judgement.
            ApplicationReady::WhenJudged
                if self.state != State::DataExch || self.accepted_configuration() != Some(request.data) =>
            {
                Some(self.ask_application(master, configuration, lengths))
            }
            ApplicationReady::WhenJudged | ApplicationReady::AtOnce => {
                self.accept_cfg(now, master, configuration, lengths)
            }
        }
    }

    /// The application sees a configuration first: it says better than the format what is wrong.
    fn judged_cfg(&self, configuration: &[u8]) -> Result<IoLengths, CfgFault> {
        self.application.judge_cfg(configuration, self.user_prm()).map_err(CfgFault::Refused)?;
        IoLengths::of(configuration).map_err(CfgFault::Impossible)
    }

    /// `dp-v0.md` 7 row 9. What was to be judged before is void.
    fn ask_application(&mut self, master: Address, configuration: Buffer, lengths: IoLengths) -> Event {
        let ticket = CfgTicket(self.last_ticket.0.wrapping_add(1));
        self.last_ticket = ticket;
        self.pending = Some(Pending { ticket, configuration, lengths });
        if self.state == State::DataExch {
            self.process_data.clear();
            self.safe_state = false;
            self.user_watchdog = None;
        }
        self.state = self.state.on(Stimulus::CfgPending);
        Event::CfgToJudge { master, ticket }
    }

    pub(super) fn accept_cfg(
        &mut self,
        now: Instant,
        master: Address,
        configuration: Buffer,
        lengths: IoLengths,
    ) -> Option<Event> {
        self.pending = None;
        self.cfg_fault = false;
        let told = Configuration::new(configuration.octets(), lengths);
        self.accepted_cfg = Some(configuration);
        self.process_data.measure(lengths);
        let entered = self.state != State::DataExch;
        self.state = self.state.on(Stimulus::CfgAccepted);
        if !entered {
            return None;
        }
        self.user_watchdog = self.description.user_watchdog.map(|time| Watchdog { time, heard: now });
        Some(Event::DataExchange { master, configuration: told })
    }

    pub(super) fn refuse_cfg(&mut self, master: Address, fault: CfgFault) -> Event {
        self.cfg_fault = true;
        self.leave_master(Stimulus::CfgRejected);
        Event::CfgRejected { master, fault }
    }

    pub(super) fn set_slave_add(&mut self, request: &Request<'_>) -> Handled<'static> {
        let master = request.sa;
        let parsed = match SetSlaveAdd::parse(request.data, self.description.ident) {
            Ok(_) if self.no_add_chg => Err(AddressFault::Locked),
            parsed @ (Ok(_) | Err(_)) => parsed,
        };
        let SetSlaveAdd { stored, rem_slave_data } = match parsed {
            Ok(parsed) => parsed,
            Err(fault) => {
                let event = Some(Event::AddressRefused { master, fault });
                return Handled { event, ..Handled::reply(self.policy.refused_set_slave_add.into()) };
            }
        };
        self.no_add_chg = stored.no_add_chg;
        self.rem_slave_data.keep([rem_slave_data, &[]]);
        // A fresh start at the new address (`docs/reference/dp-v0.md` 7 row 2).
        self.prm_fault = false;
        self.cfg_fault = false;
        self.not_supported = false;
        Handled::acknowledge(Some(Event::AddressSet { master, stored }))
    }
}
