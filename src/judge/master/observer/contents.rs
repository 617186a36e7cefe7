//! Rows P and G: what Set_Prm and Chk_Cfg say.

use core::time::Duration;

use super::Observer;
use super::cycle::Cycle;
use crate::explain::hex;
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::judge::master::setup::Slave;
use crate::profibus::dp;
use crate::profibus::dp::dpv1_status::Status1;
use crate::profibus::dp::set_prm::FIXED_LEN;

const LOCK_REQ: u8 = 0x80;
const UNLOCK_REQ: u8 = 0x40;
pub(super) const SYNC_REQ: u8 = 0x20;
pub(super) const FREEZE_REQ: u8 = 0x10;
const WD_ON: u8 = 0x08;
const RESERVED: u8 = 0x07;
/// The shortest min T_SDR.
const LEAST_TSDR: u8 = 11;
/// The longest configuration.
const LONGEST_CFG: usize = 244;

impl Observer {
    fn content(&mut self, cycle: &Cycle, row: Row, right: bool, reason: impl FnOnce() -> String) {
        if right {
            self.held(row);
        } else {
            self.broken(row, Weight::Once, cycle.serial, Some(cycle.to), reason());
        }
    }

    /// Whether a Set_Prm lets a slave go: at the stop of the master, or when it gives up. One that has never answered is
    /// let go as well as one that the master has locked.
    pub(super) fn is_release(&self, cycle: &Cycle) -> bool {
        let locks = |prm: &Vec<u8>| prm.first().is_some_and(|status| status & LOCK_REQ != 0);
        let view = self.views.get(&cycle.to.number());
        let locked = view.is_some_and(|view| view.prm_data.as_ref().is_some_and(locks));
        let silent = view.is_none_or(|view| !view.answered);
        let status = cycle.data().first().copied().unwrap_or_default();
        let unlocks = status & UNLOCK_REQ != 0 && status & LOCK_REQ == 0;
        cycle.service == Some(dp::Service::SetPrm) && unlocks && (locked || silent)
    }

    pub(super) fn judge_prm_contents(&mut self, cycle: &Cycle) {
        let data = cycle.data().to_vec();
        let &[status, first, second, min_tsdr, high, low, group, ref user @ ..] = &data[..] else {
            let reason = format!("Set_Prm has {} octets, expected at least {FIXED_LEN}", data.len());
            self.broken(Row::P07, Weight::Once, cycle.serial, Some(cycle.to), reason);
            return;
        };
        if self.is_release(cycle) {
            return;
        }
        self.findings.identify(cycle.to, u16::from_be_bytes([high, low]));
        let slave = self.setup.slave(cycle.to).cloned();
        self.content(cycle, Row::P01, status & (LOCK_REQ | UNLOCK_REQ) == LOCK_REQ, || {
            format!("octet 1 is 0x{status:02X}; expected Lock_Req = 1, Unlock_Req = 0")
        });
        if status & WD_ON != 0 {
            self.content(cycle, Row::P02, first != 0 && second != 0, || {
                format!("WD_On with factors {first} and {second}; expected 1 to 255 each")
            });
            self.held(Row::P11);
        } else if self.setup.watchdog(cycle.to).is_none() {
            let reason = "the watchdog is off; whether the user wants it on is said by --watchdog";
            self.findings.obstacle(Row::P11, reason);
        }
        self.content(cycle, Row::P04, status & RESERVED == 0, || {
            format!("octet 1 is 0x{status:02X}: bits 2 to 0 are reserved, expected 0")
        });
        let most = slave.as_ref().and_then(|slave| self.max_tsdr(slave));
        let short = (1..LEAST_TSDR).contains(&min_tsdr);
        let long = most.is_some_and(|most| u16::from(min_tsdr) > most);
        self.content(cycle, Row::P06, !short && !long, || match most {
            Some(most) => format!("min T_SDR is {min_tsdr} T_bit; expected 0 or 11 to {most}"),
            None => format!("min T_SDR is {min_tsdr} T_bit; expected 0 or 11 and more"),
        });
        let before = self.view(cycle.to).prm_data.replace(data.clone());
        if let Some(before) = before {
            self.content(cycle, Row::P12, before == data, || {
                format!("Set_Prm differs from that of the start-up before, which was {}", hex(&before))
            });
        }
        if let Some(slave) = slave {
            self.judge_prm_of(cycle, &slave, u16::from_be_bytes([high, low]), group, user);
            self.judge_watchdog(cycle, &slave, status, (first, second), user);
            self.judge_modes(cycle, &slave, status, user);
            self.judge_dpv1_status(cycle, &slave, user);
        }
    }

    /// The longest min T_SDR that makes sense: max T_SDR at the rate of the line.
    fn max_tsdr(&self, slave: &Slave) -> Option<u16> {
        let rate = match self.sight {
            super::Sight::Exact(rate) => rate,
            super::Sight::Untimed | super::Sight::Recorded => self.setup.baud?,
        };
        match &slave.gsd {
            Some(gsd) => gsd.rates.max_tsdr(rate),
            None => Some(rate.max_tsdr_bits()),
        }
    }

    fn judge_prm_of(&mut self, cycle: &Cycle, slave: &Slave, ident: u16, group: u8, user: &[u8]) {
        self.content(cycle, Row::P05, ident == slave.ident, || {
            format!("ident number 0x{ident:04X}, expected 0x{:04X}", slave.ident)
        });
        let lengths = match (&slave.prm, &slave.gsd) {
            (Some(prm), _) => Some((prm.len(), prm.len())),
            (None, Some(gsd)) => {
                let (least, most) = gsd.user_prm_lengths();
                Some((least.into(), most.into()))
            }
            (None, None) => None,
        };
        match lengths {
            Some((least, most)) => {
                self.content(cycle, Row::P07, (least..=most).contains(&user.len()), || {
                    format!("{} octets of user parameters, expected {least}", user.len())
                });
            }
            None => self.findings.obstacle(Row::P07, "needs prm=HEX or gsd=FILE of the station"),
        }
        match &slave.prm {
            Some(prm) if prm.len() == user.len() => self.content(cycle, Row::P08, prm == user, || {
                format!("user parameters {}, expected {}", hex(user), hex(prm))
            }),
            Some(_) => {}
            None => self.findings.obstacle(Row::P08, "needs prm=HEX of the station"),
        }
        match slave.groups {
            Some(groups) => self.content(cycle, Row::P09, group == groups, || {
                format!("Group_Ident is 0x{group:02X}, expected 0x{groups:02X}")
            }),
            None => self.findings.obstacle(Row::P09, "needs groups=HEX of the station"),
        }
    }

    fn judge_watchdog(&mut self, cycle: &Cycle, slave: &Slave, status: u8, factors: (u8, u8), user: &[u8]) {
        let Some(wanted) = self.setup.watchdog(slave.address) else {
            self.findings.obstacle(
                Row::P03,
                "needs --watchdog, or watchdog=MS of the station: as configured in the master",
            );
            return;
        };
        let dpv1 = slave.gsd.as_ref().is_some_and(|gsd| gsd.flags.dpv1);
        let short_base = dpv1 && user.first().is_some_and(|octet| Status1::WdBase1ms.is_set(*octet));
        let base = if short_base { Duration::from_millis(1) } else { Duration::from_millis(10) };
        let set = base * (u32::from(factors.0) * u32::from(factors.1));
        if status & WD_ON == 0 {
            let right = wanted.is_zero();
            self.content(cycle, Row::P03, right, || {
                format!("the watchdog is off, expected {} ms", wanted.as_millis())
            });
            return;
        }
        if set.is_zero() {
            return;
        }
        let most = rounded_up(wanted, base).max(wanted * 13 / 10);
        self.content(cycle, Row::P03, set >= wanted && set <= most, || {
            format!("the watchdog time is {} ms, expected {} ms", set.as_millis(), wanted.as_millis())
        });
    }

    fn judge_modes(&mut self, cycle: &Cycle, slave: &Slave, status: u8, user: &[u8]) {
        let Some(gsd) = &slave.gsd else {
            self.findings.obstacle(Row::P10, "needs gsd=FILE of the station");
            self.findings.obstacle(Row::P13, "needs gsd=FILE of the station");
            return;
        };
        let (sync, freeze) = (gsd.flags.sync, gsd.flags.freeze);
        let right = (sync || status & SYNC_REQ == 0) && (freeze || status & FREEZE_REQ == 0);
        self.content(cycle, Row::P10, right, || {
            format!("octet 1 is 0x{status:02X}: Sync_Req or Freeze_Req, which the device file does not offer")
        });
        let (_, most) = gsd.user_prm_lengths();
        let too_many = !gsd.flags.dpv1 && user.len() == usize::from(most) + 3;
        self.content(cycle, Row::P13, !too_many, || {
            "three octets too many: DPV1_Status for a slave without DPV1".into()
        });
    }

    pub(super) fn judge_cfg_contents(&mut self, cycle: &Cycle) {
        let data = cycle.data().to_vec();
        let Some(slave) = self.setup.slave(cycle.to).cloned() else {
            return;
        };
        match &slave.cfg {
            Some(cfg) => self.content(cycle, Row::G01, *cfg == data, || {
                format!("configuration {}, expected {}", hex(&data), hex(cfg))
            }),
            None => self.findings.obstacle(Row::G01, "needs cfg=HEX of the station"),
        }
        let special = |cfg: &[u8]| cfg.first().is_some_and(|octet| octet & 0x30 == 0);
        match &slave.cfg {
            Some(cfg) if special(cfg) || cfg.len() == LONGEST_CFG => {
                self.content(cycle, Row::G03, *cfg == data, || {
                    format!("configuration {}, expected {}", hex(&data), hex(cfg))
                });
            }
            Some(_) | None => self.findings.obstacle(
                Row::G03,
                "needs a station with identifiers of the special format, or with 244 octets of them",
            ),
        }
    }
}

/// The shortest time that two factors make and that is no shorter.
fn rounded_up(wanted: Duration, base: Duration) -> Duration {
    let units = u32::try_from(wanted.as_nanos().div_ceil(base.as_nanos().max(1))).unwrap_or(u32::MAX);
    let factors = (1..=255_u32).map(|first| (first, units.div_ceil(first)));
    let best = factors.filter(|(_, second)| *second <= 255).map(|(first, second)| first * second).min();
    base * best.unwrap_or(65_025)
}
