//! Set_Prm, octet by octet. `dp::set_prm` draws the octets.

use super::context::Learned;
use super::field::Field;
use super::service::{groups_of, raw_data};
use crate::devices::ag03::profibus::{APPLICATION, DESCRIPTION, IDENT_NUMBER};
use crate::profibus::dp::{Policy, PrmBit, PrmFault, SetPrm};

pub(super) fn explain(data: &[u8], at: usize, learned: &mut Learned) -> (String, Vec<Field>) {
    let (prm, octets) = match (SetPrm::parse(data), data) {
        (Ok(prm), &[a, b, c, d, e, f, g, ref user @ ..]) => (prm, ([a, b, c, d, e, f, g], user)),
        (Ok(_), _) => return (String::new(), raw_data(data, at)),
        (Err(fault), _) => {
            let fields = raw_data(data, at).into_iter().map(|field| field.mistaken(fault)).collect();
            return (format!("Set_Prm: {fault}"), fields);
        }
    };
    let ([status, wd_1, wd_2, min_tsdr, ident_high, ident_low, groups], user) = octets;
    let ident = u16::from_be_bytes([ident_high, ident_low]);
    learned.asked_ident = Some(ident);
    let watchdog =
        prm.watchdog().map_or("watchdog off".into(), |time| format!("watchdog {} ms", time.as_millis()));
    let lock = match (prm.lock_req(), prm.unlock_req()) {
        (_, true) => "unlock the slave for other masters",
        (true, false) => "lock the slave",
        (false, false) => "min T_SDR only",
    };
    let bits = (0..8).rev().map(|n| match PrmBit::at(n) {
        Some(bit) => Field::bit(bit.name(), at, n, status, bit.one(), bit.zero()),
        None => Field::bit("reserved", at, n, status, "1, must be 0", "0"),
    });
    let status_field = Field::octet("Station_Status", at, status, lock).with(bits.collect());
    let keeps = if min_tsdr == 0 { "as before".into() } else { format!("{min_tsdr} bit times") };
    let mut fields = Vec::from([
        status_field,
        Field::octet("WD_Fact_1", at + 1, wd_1, format!("{watchdog} (10 ms * factor 1 * factor 2)")),
        Field::octet("WD_Fact_2", at + 2, wd_2, format!("{wd_2}")),
        Field::octet("min T_SDR", at + 3, min_tsdr, keeps),
        Field::word("Ident_Number", at + 4, ident, ident_name(ident)),
        Field::octet(
            "Group_Ident",
            at + 6,
            groups,
            if groups == 0 { "no group".into() } else { format!("groups {}", groups_of(groups)) },
        ),
    ]);
    if !user.is_empty() {
        fields.push(Field::octets("User_Prm_Data", at + 7, user, "of the device, in its GSD"));
    }
    // Of other devices nothing is known. A release is not checked.
    let is_checked = prm.lock_req() && !prm.unlock_req();
    let ours = learned.own_ident == Some(IDENT_NUMBER) || ident == IDENT_NUMBER;
    if is_checked && let Err(fault) = prm.check(&DESCRIPTION, &APPLICATION, &Policy::PROPOSED) {
        let of_ident = matches!(fault, PrmFault::Ident { .. });
        let name = if of_ident { "Ident_Number" } else { "Station_Status" };
        let field = fields.iter_mut().find(|field| field.name == name);
        match (field, learned.own_ident) {
            (Some(field), _) if ours => {
                *field = field.clone().mistaken(format!("an AG03 refuses it: {fault}"));
            }
            // An AG03 might be there.
            (Some(field), None) if of_ident => {
                *field = field.clone().hinted(format!("an AG03 has {IDENT_NUMBER:04X} and refuses this"));
            }
            (_, _) => {}
        }
    }
    let reply = prm.min_tsdr().map_or(String::new(), |bits| format!(", reply after {bits} bit times"));
    (format!("Set_Prm: {lock}, {watchdog}{reply}"), fields)
}

/// Which device an ident number names, as far as this crate knows.
pub(super) fn ident_name(ident: u16) -> &'static str {
    if ident == IDENT_NUMBER { "SIKO AG03 and AG03/1" } else { "another device" }
}
