//! Octets of telegrams, for the scripted masters of the tests.

use profidrive::devices::ag03::profibus::MAX_TELEGRAM_LEN;
use profidrive::profibus::fdl::{Address, DataTelegram, FunctionCode, Sap};

/// Octets of a text like "68 05 05".
pub(crate) fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace().map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect()
}

/// The octets of a telegram; with a DSAP the SSAP is 62, as masters use.
pub(crate) fn telegram(da: u8, sa: u8, fc: FunctionCode, dsap: Option<u8>, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = (dsap.and_then(Sap::new), dsap.and(Sap::new(62)));
    let telegram = DataTelegram {
        format: DataTelegram::customary_format(dsap, ssap, data),
        da: Address::from_octet(da),
        sa: Address::from_octet(sa),
        dsap,
        ssap,
        fc,
        data,
    };
    telegram.encode(&mut [0; MAX_TELEGRAM_LEN]).unwrap().to_vec()
}
