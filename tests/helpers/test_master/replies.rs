//! What the test master makes of replies.

use profidrive::profibus::dp::Diagnosis;
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, FrameError, Function, ReplyStatus, StationType, Telegram};
use profidrive::time::Instant;

use super::acyclic::Services;
use super::mistakes::Mistake;
use super::slave::{Slave, State};
use super::{Stop, TestMaster, Wait};

impl TestMaster {
    /// A whole reply to the request that is open.
    pub(super) fn take_reply(&mut self, now: Instant, octets: &[u8]) {
        let Some(Wait { slave: turn, .. }) = self.waits else { return };
        let expected = self.slaves[turn].configured.address;
        let data = self.slaves[turn].state == State::Exchange && !self.slaves[turn].wants_diag;
        let long = octets.len() > 200 && data && self.does(Mistake::RejectsLong);
        if long || octets[0] == 0xA2 && self.does(Mistake::RejectsSd3) {
            return;
        }
        let reply = match decode(octets) {
            Decoded::Telegram { telegram, .. } => telegram,
            Decoded::Incomplete => return,
            Decoded::Invalid { .. } if self.does(Mistake::DiesOnFcs) && octets.len() > 5 => {
                self.dead = true;
                return;
            }
            Decoded::Invalid { .. } if self.does(Mistake::BelievesFcs) && octets.len() > 5 => {
                self.waits = None;
                self.confirm(turn);
                self.turn += 1;
                self.next = now + self.syn();
                return;
            }
            Decoded::Invalid { .. } if self.does(Mistake::GivesUpOnFcs) && octets.len() > 5 => {
                let slave = &mut self.slaves[turn];
                (slave.open, slave.operational, slave.retries) = (None, false, 0);
                slave.reads += 1;
                slave.restart(self.mistake);
                self.waits = None;
                self.turn += 1;
                self.next = now + self.syn();
                return;
            }
            Decoded::Invalid { .. } => {
                self.errors += u32::from(octets.len() > 5);
                self.dead |= self.errors >= 4 && self.does(Mistake::DiesOnManyErrors);
                return;
            }
        };
        let answer = match reply {
            Telegram::ShortAcknowledge => Some((None, Vec::new())),
            Telegram::Token { .. } => None,
            Telegram::Data(data) if data.sa.number() != expected && self.does(Mistake::DiesOnSource) => {
                self.dead = true;
                None
            }
            Telegram::Data(data) => match data.fc.function() {
                Function::Response(StationType::Slave, status)
                    if data.da == self.address()
                        && (data.sa.number() == expected
                            || self.does(Mistake::BelievesSource)
                            || self.is_late_of_other(data.sa.number())) =>
                {
                    let asked = self.slaves[turn].open.as_deref().map(decode);
                    let saps = match asked {
                        Some(Decoded::Telegram { telegram: Telegram::Data(asked), .. }) => {
                            data.data.is_empty() || (asked.dsap, asked.ssap) == (data.ssap, data.dsap)
                        }
                        _ => false,
                    };
                    self.dead |= !saps && self.does(Mistake::DiesOnSaps);
                    saps.then(|| (Some(status), data.data.to_vec()))
                }
                _ if (data.da, data.sa.number()) == (self.address(), expected)
                    && self.does(Mistake::BelievesFunction) =>
                {
                    Some((Some(ReplyStatus::DataLow), data.data.to_vec()))
                }
                _ => None,
            },
        };
        // What is no reply to this request does not end the waiting.
        let Some((status, data)) = answer else { return };
        self.waits = None;
        if core::mem::take(&mut self.slaves[turn].asks_status) {
            let slave = &mut self.slaves[turn];
            (slave.is_there, slave.open) = (true, None);
            self.turn += 1;
            self.next = now + self.syn();
            return;
        }
        self.confirm(turn);
        let asked_diag = self.slaves[turn].wants_diag;
        let was_service = self.slaves[turn].services.as_ref().is_some_and(Services::is_asking);
        if !was_service && self.slaves[turn].state == State::Exchange && status.is_some() {
            self.slaves[turn].exchanged = now;
        }
        let exchanges = self.slaves[turn].state == State::Exchange;
        if was_service {
            self.serviced(turn, status, &data);
        } else {
            self.react(turn, status, &data);
        }
        // Behind each reply comes a telegram of a service, if there is one; for the owner only in data exchange.
        let serves = !was_service && self.stop == Stop::No && !self.settings.class_2;
        let mistake = self.mistake;
        let Slave { services, turns, state, .. } = &mut self.slaves[turn];
        let owns = exchanges && *state == State::Exchange;
        let services = services.as_mut().filter(|_| serves);
        let serves = services.is_some_and(|services| services.prepare(now, (*turns, owns), mistake));
        let slave = &self.slaves[turn];
        let stays = match self.mistake {
            Some(Mistake::StarvesAtDh) => asked_diag || slave.wants_diag,
            Some(Mistake::WaitsForReady) => slave.state == State::Diag2 && slave.not_ready > 0,
            _ => false,
        };
        let stays = stays || serves;
        self.turn += usize::from(!stays);
        self.next =
            now + if self.does(Mistake::ShortIdle) { self.settings.baud.bit_times(20) } else { self.syn() };
    }

    /// Whether it takes octets that begin so for a reply, whatever they are.
    pub(super) fn believes(&self, first: u8) -> bool {
        match self.mistake {
            Some(Mistake::BelievesNoise) => self.junk == 0 && ![0x10, 0x68, 0xA2, 0xDC].contains(&first),
            Some(Mistake::BelievesDelimiters) => {
                first == 0x68
                    && !matches!(
                        decode(&self.heard),
                        Decoded::Invalid { error: FrameError::Checksum { .. }, .. }
                    )
            }
            _ => false,
        }
    }

    /// Takes what came for a good reply.
    pub(super) fn take_anything(&mut self, now: Instant) {
        let Some(Wait { slave: turn, .. }) = self.waits.take() else { return };
        self.confirm(turn);
        self.turn += 1;
        self.next = now + self.syn();
    }

    fn is_late_of_other(&self, source: u8) -> bool {
        self.does(Mistake::TakesLate) && self.slaves.iter().any(|slave| slave.configured.address == source)
    }

    /// A request whose reply it believes to have already.
    pub(super) fn take_kept(&mut self, now: Instant) {
        let Some(Wait { slave: turn, .. }) = self.waits else { return };
        if core::mem::take(&mut self.slaves[turn].kept) {
            self.waits = None;
            self.confirm(turn);
            self.turn += 1;
            self.next = now + self.syn();
        }
    }

    /// The request was answered.
    pub(super) fn confirm(&mut self, turn: usize) {
        let stuck = self.does(Mistake::NoToggle);
        let slave = &mut self.slaves[turn];
        slave.open = None;
        slave.retries = 0;
        slave.first_asks = 0;
        slave.count = Some(match slave.count {
            None => false,
            Some(_) if !slave.operational => false,
            Some(bit) => bit ^ !stuck,
        });
        slave.operational = true;
    }

    fn react(&mut self, turn: usize, status: Option<ReplyStatus>, data: &[u8]) {
        let own = self.settings.address;
        let mistake = self.mistake;
        if self.settings.class_2 {
            return self.read(turn, status, data);
        }
        if self.takes_of_habit(turn) {
            return;
        }
        let slave = &mut self.slaves[turn];
        if self.stop == Stop::Releasing {
            return slave.restart(mistake);
        }
        match slave.state {
            State::Diag1 | State::Diag2 => {
                let diag = Diagnosis::parse(data).or((mistake == Some(Mistake::TakesShortDiag)).then(|| {
                    Diagnosis {
                        ident: slave.configured.ident,
                        master: Address::station(own).ok(),
                        ..Diagnosis::default()
                    }
                }));
                let Some(diag) = diag else { return };
                if mistake == Some(Mistake::DiesOnMasterBits) && data[0] & 0x80 != 0 {
                    self.dead = true;
                }
                let owned = diag.master.is_some_and(|owner| owner.number() != own);
                self.dead |= owned && mistake == Some(Mistake::DiesOnOwner);
                self.dead |= diag.not_supported && mistake == Some(Mistake::DiesOnUnsupported);
                slave.faulty = diag.ext_diag;
                let takes_back = slave.refused && mistake == Some(Mistake::TakesBack);
                let waits = !diag.prm_req && slave.state == State::Diag1;
                let waits = waits
                    && (slave.lost && mistake == Some(Mistake::WaitsForPrmReq)
                        || slave.start_ups == 0 && mistake == Some(Mistake::WaitsForWatchdog));
                if waits || owned && mistake != Some(Mistake::IgnoresOwner) && !takes_back {
                    slave.state = State::Diag1;
                } else if slave.lost && mistake == Some(Mistake::NoStartUp) {
                    slave.state = State::Exchange;
                } else if slave.state == State::Diag1 {
                    slave.state = if mistake == Some(Mistake::CfgFirst) { State::Cfg } else { State::Prm };
                    slave.not_ready = 0;
                } else {
                    slave.judge_second(diag, mistake);
                    self.dead |= slave.plain >= 8 && mistake == Some(Mistake::DiesOnManyStartUps);
                }
            }
            State::Prm if status.is_none() || mistake == Some(Mistake::IgnoresRefusal) => {
                slave.state = State::Cfg;
                slave.start_ups += 1;
                if mistake == Some(Mistake::CfgFirst) {
                    slave.state = State::Diag2;
                } else if mistake == Some(Mistake::NoCfg) {
                    slave.state = State::Exchange;
                }
            }
            State::Cfg if mistake == Some(Mistake::CfgFirst) => slave.state = State::Prm,
            State::Cfg if status.is_none() => {
                let next = mistake == Some(Mistake::NoSecondDiag);
                slave.state = if next { State::Exchange } else { State::Diag2 };
            }
            State::Prm | State::Cfg => {
                slave.plain = 0;
                slave.restart(mistake);
            }
            State::Exchange if slave.wants_diag => {
                slave.wants_diag = false;
                slave.plain = 0;
                if mistake == Some(Mistake::DiesOnMasterBits)
                    && data.first().is_some_and(|octet| octet & 0x80 != 0)
                {
                    self.dead = true;
                }
                self.dead |= data.len() > 100 && mistake == Some(Mistake::DiesOnLongDiag);
                let Some(diag) = Diagnosis::parse(data) else { return };
                if let Some(services) = &mut slave.services {
                    services.note(data, mistake);
                }
                slave.faulty = diag.ext_diag;
                let owned = diag.master.is_none_or(|owner| owner.number() != own);
                let gone = (diag.station_not_ready || owned) && mistake != Some(Mistake::IgnoresNoOwner);
                let asks = diag.prm_req || diag.prm_fault || diag.cfg_fault || gone;
                let needless = (data.len() > 100 && mistake == Some(Mistake::RestartsOnLongDiag))
                    || (diag.ext_diag_overflow && mistake == Some(Mistake::RestartsOnOverflow));
                if needless
                    || asks && mistake != Some(Mistake::IgnoresPrmReq)
                    || mistake == Some(Mistake::RestartsOnDiag)
                {
                    slave.restart(mistake);
                }
            }
            State::Exchange => self.exchanged(turn, status, data.len()),
        }
    }

    /// What came of a service of DP-V1.
    fn serviced(&mut self, turn: usize, status: Option<ReplyStatus>, data: &[u8]) {
        let (now, mistake) = (self.now, self.mistake);
        let slave = &mut self.slaves[turn];
        let Some(services) = &mut slave.services else { return };
        if services.take(now, status, data, mistake) && slave.state == State::Exchange {
            slave.restart(mistake);
        }
    }

    /// A master of class 2 takes whatever the slave says.
    fn read(&mut self, turn: usize, status: Option<ReplyStatus>, data: &[u8]) {
        self.slaves[turn].reads += 1;
        self.dead |= match (self.mistake, status) {
            (Some(Mistake::DiesOnLongDiag), _) => data.len() > 100,
            (Some(Mistake::DiesOnMasterBits), _) => data.first().is_some_and(|octet| octet & 0x80 != 0),
            (Some(Mistake::DiesOnUserError), Some(ReplyStatus::UserError)) => true,
            (Some(Mistake::DiesOnRdl), Some(status)) => {
                matches!(status, ReplyStatus::NoResourceDataLow | ReplyStatus::NoResourceDataHigh)
            }
            _ => false,
        };
    }

    fn exchanged(&mut self, turn: usize, status: Option<ReplyStatus>, len: usize) {
        let mistake = self.mistake;
        let slave = &mut self.slaves[turn];
        if core::mem::take(&mut slave.restarts) {
            return slave.restart(mistake);
        }
        let inputs = usize::from(slave.lengths.inputs);
        match status {
            Some(ReplyStatus::UserError) if mistake == Some(Mistake::DiesOnUserError) => self.dead = true,
            Some(ReplyStatus::NotActivated) if mistake == Some(Mistake::DiesOnRs) => self.dead = true,
            Some(ReplyStatus::NotActivated) if mistake == Some(Mistake::IgnoresRs) => {}
            Some(ReplyStatus::NoResourceDataLow | ReplyStatus::NoResourceDataHigh)
                if mistake == Some(Mistake::DiesOnRdl) =>
            {
                self.dead = true;
            }
            // Not even one RS tells it that the slave has lost everything.
            Some(ReplyStatus::NotActivated) if slave.lost && mistake == Some(Mistake::NoStartUp) => {
                slave.lost = false;
            }
            Some(ReplyStatus::NotActivated | ReplyStatus::UserError | ReplyStatus::NoResource) => {
                slave.refused = true;
                slave.restart(mistake);
            }
            Some(ReplyStatus::DataHigh | ReplyStatus::NoResourceDataHigh) if len == inputs => {
                slave.wants_diag = match mistake {
                    Some(Mistake::IgnoresHigh) => false,
                    Some(Mistake::IgnoresGone) => !slave.faulty,
                    Some(Mistake::IgnoresEmptyHigh) => len > 0,
                    _ => true,
                };
                slave.wrong_replies = 0;
            }
            None if inputs == 0 && mistake == Some(Mistake::RejectsSc) => slave.restart(mistake),
            None if inputs == 0 => slave.wrong_replies = 0,
            None if mistake == Some(Mistake::IgnoresSc) => {}
            None => slave.count_wrong_reply(),
            Some(_) if len == inputs => slave.wrong_replies = 0,
            Some(_) if len < inputs && mistake == Some(Mistake::IgnoresFewInputs) => {}
            Some(_) if mistake == Some(Mistake::DiesOnLength) => self.dead = true,
            Some(_) if mistake == Some(Mistake::IgnoresLength) => {}
            Some(_) => slave.count_wrong_reply(),
        }
    }
}
