//! The data of each service of DP in words: Set_Prm, Chk_Cfg, Slave_Diag and the others.

use super::context::Learned;
use super::field::Field;
use super::{Sender, acyclic, cfg, diag, ppo, set_prm};
use crate::devices::ag03::profibus::IDENT_NUMBER;
use crate::profibus::dp::Service;
use crate::profibus::dp::global_control::{ControlBit, GlobalControl, Latch};
use crate::profibus::dp::set_slave_add::{AddressFault, SetSlaveAdd};
use crate::profibus::fdl::Sap;
use crate::profibus::ppo::PPO_LEN;

/// The data of a telegram explained.
pub(super) struct Carried {
    pub(super) service: Option<Service>,
    pub(super) summary: String,
    pub(super) fields: Vec<Field>,
}

/// Number and use of a service access point at a slave.
pub(super) fn sap_name(sap: Sap) -> String {
    let of = acyclic::sap_use(sap)
        .unwrap_or_else(|| Service::of(Some(sap), None).map_or("none of DP-V0", Service::name));
    format!("SAP {sap}: {of}")
}

/// Data of which no more can be said than that they are there.
pub(super) fn raw_data(data: &[u8], at: usize) -> Vec<Field> {
    if data.is_empty() { Vec::new() } else { Vec::from([Field::octets("data", at, data, "")]) }
}

pub(super) fn request(service: Option<Service>, data: &[u8], at: usize, learned: &mut Learned) -> Carried {
    let (summary, fields) = match service {
        Some(Service::SlaveDiag) => no_data("Slave_Diag request", data, at),
        Some(Service::GetCfg) => no_data("Get_Cfg request", data, at),
        Some(Service::RdInp) => no_data("RD_Inp request", data, at),
        Some(Service::RdOutp) => no_data("RD_Outp request", data, at),
        Some(Service::SetPrm) => set_prm::explain(data, at, learned),
        Some(Service::ChkCfg) => {
            let (summary, fields) = cfg::explain(data, at, cfg::Said::Asked, learned.ident());
            (format!("Chk_Cfg: {summary}"), fields)
        }
        Some(Service::SetSlaveAdd) => set_slave_add(data, at, learned),
        Some(Service::GlobalControl) => global_control(data, at),
        Some(Service::DataExchange) => exchange(data, Sender::Master, at, learned),
        None => ("a service that no slave has".into(), raw_data(data, at)),
    };
    Carried { service, summary, fields }
}

pub(super) fn response(service: Option<Service>, data: &[u8], at: usize, learned: &mut Learned) -> Carried {
    let (summary, fields) = match service {
        Some(Service::SlaveDiag) => diag::explain(data, at, learned),
        Some(Service::GetCfg) => {
            let (summary, fields) = cfg::explain(data, at, cfg::Said::Answered, learned.ident());
            (format!("configuration: {summary}"), fields)
        }
        Some(Service::DataExchange | Service::RdInp) => exchange(data, Sender::Slave, at, learned),
        Some(Service::RdOutp) => {
            // A copy: a read of the outputs is no control word.
            let (summary, fields) = exchange(data, Sender::Master, at, &mut learned.clone());
            (summary.replacen("Data_Exchange", "outputs", 1), fields)
        }
        Some(
            service @ (Service::SetSlaveAdd | Service::GlobalControl | Service::SetPrm | Service::ChkCfg),
        ) => (format!("answer to {}", service.name()), raw_data(data, at)),
        None => ("an answer to no service".into(), raw_data(data, at)),
    };
    Carried { service, summary, fields }
}

/// A request that asks without data.
fn no_data(summary: &str, data: &[u8], at: usize) -> (String, Vec<Field>) {
    let mut fields = raw_data(data, at);
    if let Some(field) = fields.pop() {
        fields.push(field.mistaken("this request has no data; the slave refuses it with RR"));
    }
    (summary.into(), fields)
}

/// User data of Data_Exchange: a PPO of these drives, or what another slave exchanges. Who has said no Ident_Number is
/// taken for one of these drives by its 14 octets.
fn exchange(data: &[u8], sender: Sender, at: usize, learned: &mut Learned) -> (String, Vec<Field>) {
    let (head, what) = match sender {
        Sender::Master => ("Data_Exchange", "outputs"),
        Sender::Slave => ("inputs", "inputs"),
    };
    let ppo: Result<&[u8; PPO_LEN], _> = data.try_into();
    match ppo {
        // Another device means something else by them.
        Ok(_) if learned.ident().is_some_and(|ident| ident != IDENT_NUMBER) => {
            let text = format!("{} octets of {what} of another device", data.len());
            (format!("{head}: {text}"), Vec::from([Field::octets(what, at, data, text)]))
        }
        Ok(octets) => {
            let (fields, words) = ppo::ppo(octets, sender, at, learned);
            (format!("{head}: {words}"), fields)
        }
        Err(_) if data.is_empty() => (format!("{head}: no {what}"), Vec::new()),
        Err(_) if learned.ident().is_some_and(|ident| ident != IDENT_NUMBER) => {
            let text = format!("{} octets of {what}", data.len());
            (format!("{head}: {text}"), Vec::from([Field::octets(what, at, data, text)]))
        }
        Err(_) => {
            let text = format!("{} octets of {what}, not the 14 of these drives", data.len());
            let mut field = Field::octets(what, at, data, text.clone());
            if sender == Sender::Master && learned.ident() == Some(IDENT_NUMBER) {
                field = field.mistaken(format!("an AG03 refuses it: {} octets, expected 14", data.len()));
            }
            (format!("{head}: {text}"), Vec::from([field]))
        }
    }
}

/// `dp::global_control` draws the octets.
fn global_control(data: &[u8], at: usize) -> (String, Vec<Field>) {
    let (&[command, groups], Some(parsed)) = (data, GlobalControl::parse(data, false)) else {
        let fields = raw_data(data, at).into_iter();
        let text = format!("{} octets, expected 2: every slave ignores it", data.len());
        let fields = fields.map(|field| field.mistaken(&text)).collect();
        return (format!("Global_Control: {text}"), fields);
    };
    let latch = |latch, set: ControlBit, release: ControlBit| match latch {
        Latch::Keep => None,
        Latch::Set => Some(set.name()),
        Latch::Release => Some(release.name()),
    };
    let clear = parsed.clear_data.then_some("Clear_Data: outputs to zero");
    let freeze = latch(parsed.freeze, ControlBit::Freeze, ControlBit::Unfreeze);
    let sync = latch(parsed.sync, ControlBit::Sync, ControlBit::Unsync);
    let words: Vec<&str> = [clear, freeze, sync].into_iter().flatten().collect();
    let words =
        if words.is_empty() { "no command, the master is in Operate".into() } else { words.join(", ") };
    let whom = if groups == 0 { String::new() } else { format!(" to groups {}", groups_of(groups)) };
    let name = |n| ControlBit::at(n).map_or("reserved", ControlBit::name);
    let bits = (0..8).rev().map(|n| Field::bit(name(n), at, n, command, "1", "0"));
    let mut control = Field::octet("Control_Command", at, command, words.clone()).with(bits.collect());
    if command & ControlBit::RESERVED != 0 {
        control = control.mistaken("reserved bits are set: a slave ignores the command");
    }
    let select = if groups == 0 { "all slaves".into() } else { format!("groups {}", groups_of(groups)) };
    let fields = Vec::from([control, Field::octet("Group_Select", at + 1, groups, select)]);
    (format!("Global_Control{whom}: {words}"), fields)
}

/// `1, 4` for bits 0 and 3.
pub(super) fn groups_of(mask: u8) -> String {
    let groups: Vec<String> =
        (0..8).filter(|bit| mask >> bit & 1 != 0).map(|bit: u8| (bit + 1).to_string()).collect();
    groups.join(", ")
}

/// `dp::set_slave_add` draws the octets.
fn set_slave_add(data: &[u8], at: usize, learned: &Learned) -> (String, Vec<Field>) {
    let &[address, high, low, no_change, ref rest @ ..] = data else {
        let fault = AddressFault::Length { got: data.len() };
        let fields = raw_data(data, at).into_iter().map(|field| field.mistaken(fault)).collect();
        return (format!("Set_Slave_Add: {fault}"), fields);
    };
    let ident = u16::from_be_bytes([high, low]);
    let mut new = Field::octet("New_Slave_Add", at, address, format!("station {address}"));
    if let Err(fault) = SetSlaveAdd::parse(data, ident) {
        new = new.mistaken(fault);
    }
    if [learned.own_ident, Some(ident)].contains(&Some(IDENT_NUMBER)) {
        let text = "an AG03 refuses it with RS: its address is set with switches, not over the bus";
        new = new.mistaken(text);
    }
    let change = if no_change == 0 {
        "may be changed again"
    } else {
        "cannot be changed again until the hardware is reset"
    };
    let mut fields = Vec::from([
        new,
        Field::word("Ident_Number", at + 1, ident, "of the addressed slave"),
        Field::octet("No_Add_Chg", at + 3, no_change, change),
    ]);
    if !rest.is_empty() {
        fields.push(Field::octets("Rem_Slave_Data", at + 4, rest, "kept by the slave"));
    }
    (format!("Set_Slave_Add: new address {address}"), fields)
}
