//! Why data exchange with a station is not reached.

use super::Observer;
use super::view::View;
use crate::explain::hex;
use crate::judge::master::setup::Slave;
use crate::profibus::dp::set_prm::FIXED_LEN;
use crate::profibus::fdl::Address;

/// Lock_Req and Unlock_Req of the first octet of Set_Prm.
const LOCKS: u8 = 0xC0;
const LOCK_REQ: u8 = 0x80;

impl Observer {
    /// Why data exchange with a station was not reached, as far as the telegrams say.
    pub(in crate::judge) fn why_no_exchange(&self, station: Address) -> String {
        let view = self.views.get(&station.number()).filter(|view| view.asked.is_some());
        let (Some(view), Some(slave)) = (view, self.setup.slave(station)) else {
            return self.why_not_asked(station);
        };
        let Some(prm) = view.prm_data.as_deref() else {
            return match view.diag {
                Some(diag) if self.is_owned_by_other(&diag) => {
                    "no Set_Prm came; the diagnosis says that another master owns the station".into()
                }
                Some(_) => "the diagnosis is read, and no Set_Prm comes".into(),
                None => "the master does not read the diagnosis to its end, and sends no Set_Prm".into(),
            };
        };
        if prm.first().is_some_and(|status| status & LOCKS != LOCK_REQ) {
            return format!("Set_Prm locks no slave: octets {}", hex(prm));
        }
        match (view.fault, view.cfg_data.as_deref()) {
            (Some((true, _)), _) => format!("Set_Prm refused: {}", wrong_prm(prm, slave)),
            (Some((_, true)), Some(cfg)) => format!("Chk_Cfg refused: {}", wrong_cfg(cfg, slave)),
            (_, None) => "Set_Prm was sent, and no Chk_Cfg comes".into(),
            (_, Some(_)) => why_no_outputs(view, slave),
        }
    }

    /// What a master of class 2 does that reads no station.
    pub(in crate::judge) fn why_not_read(&self) -> String {
        let asked: Vec<String> = self.strangers.iter().map(|number| format!("{number}")).collect();
        if self.views.values().any(|view| view.asked.is_some()) {
            "its requests get no good reply eight times in a row".into()
        } else if !asked.is_empty() {
            format!("the master asks {}, which was not given", asked.join(", "))
        } else if self.ring.seen() {
            "the master passes the token and asks no station".into()
        } else {
            "the master asks no station".into()
        }
    }

    fn why_not_asked(&self, station: Address) -> String {
        let asked: Vec<String> = self.strangers.iter().map(|number| format!("{number}")).collect();
        let others = self.views.values().any(|view| view.asked.is_some());
        if !asked.is_empty() {
            format!("the master never asks it; it asks {}", asked.join(", "))
        } else if self.ring.seen() && !others {
            "the master passes the token and asks no station".into()
        } else {
            format!("the master never asks station {station}")
        }
    }
}

fn wrong_prm(prm: &[u8], slave: &Slave) -> String {
    let &[_, _, _, _, high, low, _, ref user @ ..] = prm else {
        return format!("{} octets, expected at least {FIXED_LEN}", prm.len());
    };
    let ident = u16::from_be_bytes([high, low]);
    if ident != slave.ident {
        return format!("ident {ident:04X}, configured {:04X}", slave.ident);
    }
    match &slave.gsd {
        Some(gsd) => {
            let (least, most) = gsd.user_prm_lengths();
            if (usize::from(least)..=usize::from(most)).contains(&user.len()) {
                format!("octets {}", hex(prm))
            } else {
                format!("{} octets of user parameters, configured {least} to {most}", user.len())
            }
        }
        None => format!("octets {}", hex(prm)),
    }
}

fn wrong_cfg(cfg: &[u8], slave: &Slave) -> String {
    match &slave.cfg {
        Some(configured) if configured != cfg => format!("{}, configured {}", hex(cfg), hex(configured)),
        Some(_) | None => format!("{}, which the device file does not allow", hex(cfg)),
    }
}

fn why_no_outputs(view: &View, slave: &Slave) -> String {
    let outputs = slave.lengths().map(|lengths| usize::from(lengths.outputs));
    match (&view.last_outputs, outputs) {
        (Some(sent), Some(outputs)) if sent.len() != outputs => {
            format!("Data_Exchange has {} octets of outputs, configured {outputs}", sent.len())
        }
        (Some(_), _) => "Data_Exchange comes, and not eight good cycles in a row".into(),
        (None, _) => "Chk_Cfg was sent, and no Data_Exchange comes".into(),
    }
}
