//! The EMCY code and the bits of the error register 1001h of each fault (`canopen-ag03.md` 7, CN-11).

use crate::can_bus::canopen::emcy::COMMUNICATION;
use crate::devices::ag03::drive::Fault;

/// CAN error passive outside positioning: no fault, not kept.
pub(crate) const ERROR_PASSIVE: u16 = 0x8120;
/// The bus works again after bus off: not kept, and no end is sent.
pub(crate) const BUS_OFF_RECOVERED: u16 = 0x8140;

/// The EMCY code of a fault, also in 1003h.
pub(crate) const fn code(fault: Fault) -> u16 {
    match fault {
        Fault::A => 0x3120,
        Fault::B => 0x7121,
        Fault::C => 0x2100,
        Fault::D => 0x4310,
        Fault::E => 0x7300,
        Fault::F => 0xFF01,
        Fault::G => 0x3210,
        Fault::H => 0xFF02,
        Fault::I => 0xFF03,
        Fault::J => 0xFF09,
    }
}

/// The bits of the error register of a fault, without bit 0, which goes with any of them.
pub(crate) const fn register(fault: Fault) -> u8 {
    match fault {
        Fault::C => 1 << 1,
        Fault::A | Fault::G | Fault::J => 1 << 2,
        Fault::D => 1 << 3,
        Fault::H | Fault::I => COMMUNICATION,
        Fault::B => 1 << 5,
        Fault::E | Fault::F => 1 << 7,
    }
}

/// What an EMCY code of this device means.
pub(crate) fn meaning(code: u16) -> Option<&'static str> {
    Some(match code {
        0x0000 => "no error",
        0x2100 => "motor current too high (fault C)",
        0x3120 => "supply voltage too low (fault A)",
        0x3210 => "intermediate circuit voltage too high (fault G)",
        0x4310 => "output stage too hot (fault D)",
        0x7121 => "shaft blocked (fault B)",
        0x7300 => "SIN/COS monitoring (fault E)",
        ERROR_PASSIVE => "CAN error passive",
        BUS_OFF_RECOVERED => "recovered from bus off",
        0xFF01 => "internal error (fault F)",
        0xFF02 => "CAN error passive while travelling (fault H)",
        0xFF03 => "CAN bus off (fault I)",
        0xFF09 => "battery empty (fault J)",
        _unknown => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_has_a_code_of_its_own_with_a_meaning_that_names_it() {
        for fault in Fault::ALL.into_iter().chain(Fault::OF_BUS) {
            let letter = char::from(fault.code());
            let text = meaning(code(fault)).unwrap();
            assert!(text.ends_with(&std::format!("(fault {letter})")), "{text}");
            assert!(register(fault) & 1 == 0 && register(fault) != 0);
        }
    }
}
