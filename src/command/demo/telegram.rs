//! What the telegrams of a start-up mean, in words.

use profidrive::dp::{IoLengths, Service, SetPrm};
use profidrive::fdl::telegram::{Decoded, decode};
use profidrive::fdl::{self, Address, DataTelegram, Function, Telegram};
use profidrive::ppo::{Inputs, Outputs};

/// What a telegram between a master and `station` says; `None` for one that is not for this story: a token, or one
/// for another station.
pub(super) fn explain(octets: &[u8], station: u8) -> Option<String> {
    let data = match decode(octets) {
        Decoded::Telegram { telegram: Telegram::Data(data), .. } => data,
        Decoded::Telegram { telegram: Telegram::ShortAcknowledge, .. } => {
            return Some("short acknowledge: taken over".into());
        }
        Decoded::Telegram { telegram: Telegram::Token { .. }, .. }
        | Decoded::Incomplete
        | Decoded::Invalid { .. } => return None,
    };
    let of_station = |address: Address| address.number() == station;
    if !of_station(data.da) && !of_station(data.sa) && !data.da.is_broadcast() {
        return None;
    }
    Some(match data.fc.function() {
        Function::Request(fdl::Service::FdlStatus, _) => "FDL status: who is there?".into(),
        Function::Request(..) => request(&data),
        Function::Response(..) if data.data.is_empty() => "here, a slave".into(),
        Function::Response(..) => response(&data),
        Function::Reserved => "a reserved function code".into(),
    })
}

/// Whether the telegram carries the inputs of a drive.
pub(super) fn is_inputs(octets: &[u8]) -> bool {
    match decode(octets) {
        Decoded::Telegram { telegram: Telegram::Data(data), .. } => {
            let response = matches!(data.fc.function(), Function::Response(..));
            response && data.ssap.is_none() && Inputs::parse(data.data).is_ok()
        }
        Decoded::Telegram { telegram: Telegram::Token { .. } | Telegram::ShortAcknowledge, .. }
        | Decoded::Incomplete
        | Decoded::Invalid { .. } => false,
    }
}

fn request(telegram: &DataTelegram<'_>) -> String {
    let data = telegram.data;
    match Service::of(telegram.dsap, telegram.ssap) {
        Some(Service::SlaveDiag) => "Slave_Diag: how are you?".into(),
        Some(Service::SetPrm) => set_prm(data),
        Some(Service::ChkCfg) => match IoLengths::of(data) {
            Ok(IoLengths { outputs, inputs }) => {
                format!("Chk_Cfg: {outputs} octets of outputs and {inputs} of inputs, agreed?")
            }
            Err(error) => format!("Chk_Cfg: {error}"),
        },
        Some(Service::GlobalControl) => "Global_Control to all: the master is in Operate".into(),
        Some(Service::DataExchange) => match Outputs::parse(data) {
            Ok(outputs) => format!(
                "Data_Exchange: PKW {}, STW {}, setpoint {}",
                outputs.pkw(),
                outputs.stw(),
                outputs.hsw()
            ),
            Err(error) => format!("Data_Exchange: {error}"),
        },
        Some(other @ (Service::SetSlaveAdd | Service::RdInp | Service::RdOutp | Service::GetCfg)) => {
            format!("{other:?}")
        }
        None => "a service that no slave has".into(),
    }
}

fn response(telegram: &DataTelegram<'_>) -> String {
    let data = telegram.data;
    match Service::of(telegram.ssap, telegram.dsap) {
        Some(Service::SlaveDiag) => diagnosis(data),
        Some(Service::DataExchange) => match Inputs::parse(data) {
            Ok(inputs) => {
                format!("inputs: PKW {}, ZSW {}, actual value {}", inputs.pkw(), inputs.zsw(), inputs.hiw())
            }
            Err(error) => format!("inputs: {error}"),
        },
        Some(
            other @ (Service::SetSlaveAdd
            | Service::RdInp
            | Service::RdOutp
            | Service::GlobalControl
            | Service::GetCfg
            | Service::SetPrm
            | Service::ChkCfg),
        ) => format!("{other:?}"),
        None => "an answer to no service".into(),
    }
}

fn set_prm(data: &[u8]) -> String {
    match SetPrm::parse(data) {
        Ok(prm) => {
            let lock = if prm.lock_req() { "be mine" } else { "parameters" };
            let watchdog = prm
                .watchdog()
                .map_or("watchdog off".into(), |time| format!("watchdog {} ms", time.as_millis()));
            let min_tsdr = prm.min_tsdr().unwrap_or_default();
            format!("Set_Prm: {lock}, {watchdog}, reply after {min_tsdr} bit times")
        }
        Err(fault) => format!("Set_Prm: {fault}"),
    }
}

/// Slave_Diag as the wire has it: `profidrive::dp::slave_diag` draws the octets.
fn diagnosis(data: &[u8]) -> String {
    let &[first, second, _, master, ident_high, ident_low] = data else {
        return format!("diagnosis of {} octets", data.len());
    };
    let flags = [
        (first, 1, "not ready"),
        (first, 2, "configuration fault"),
        (first, 6, "parameter fault"),
        (second, 0, "wants parameters"),
        (second, 3, "watchdog on"),
    ];
    let set: Vec<&str> = flags.iter().filter(|row| row.0 >> row.1 & 1 != 0).map(|row| row.2).collect();
    let state = if first & 0x02 == 0 { "ready for data" } else { "" };
    let state: Vec<&str> = [state].into_iter().chain(set).filter(|word| !word.is_empty()).collect();
    let owner = if master == 0xFF { "no master".into() } else { format!("master {master}") };
    format!("diagnosis: {}, {owner}, ident {ident_high:02X}{ident_low:02X}", state.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn octets(hex: &str) -> Vec<u8> {
        hex.split(' ').map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect()
    }

    #[test]
    fn the_telegrams_of_a_start_up_in_words() {
        for (hex, words) in [
            ("10 05 02 49 50 16", Some("FDL status: who is there?")),
            ("10 02 05 00 07 16", Some("here, a slave")),
            ("68 05 05 68 85 82 6D 3C 3E EE 16", Some("Slave_Diag: how are you?")),
            (
                "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 0A C5 5E 16",
                Some("diagnosis: not ready, wants parameters, no master, ident 0AC5"),
            ),
            ("E5", Some("short acknowledge: taken over")),
            ("10 06 02 49 51 16", None),
            ("DC 02 02", None),
            ("10", None),
            ("FF", None),
        ] {
            assert_eq!(explain(&octets(hex), 5).as_deref(), words, "{hex}");
        }
    }

    #[test]
    fn parameters_are_named_and_a_short_set_prm_says_so() {
        let prm = set_prm(&[0xB8, 1, 20, 11, 0x0A, 0xC5, 0]);
        assert_eq!(prm, "Set_Prm: be mine, watchdog 200 ms, reply after 11 bit times");
        assert!(set_prm(&[0x80]).contains("7"), "{}", set_prm(&[0x80]));
        assert_eq!(diagnosis(&[1]), "diagnosis of 1 octets");
    }
}
