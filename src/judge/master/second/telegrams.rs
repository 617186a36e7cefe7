//! What a second master sends.

use crate::profibus::dp;
use crate::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, Sap, Service, StationType, Telegram,
};

/// SD4.
pub(super) fn token(da: Address, sa: Address) -> Vec<u8> {
    octets(&Telegram::Token { da, sa })
}

/// FDL status request.
pub(super) fn status_request(da: Address, sa: Address) -> Vec<u8> {
    let fc = FunctionCode::request(Service::FdlStatus, FrameCount::Unused);
    data(da, sa, None, fc, &[])
}

/// The answer to one.
pub(super) fn status_response(da: Address, sa: Address, state: StationType) -> Vec<u8> {
    let fc = FunctionCode::from_octet(match state {
        StationType::Slave => 0x00,
        StationType::MasterNotReady => 0x10,
        StationType::MasterReady => 0x20,
        StationType::MasterInRing => 0x30,
    });
    data(da, sa, None, fc, &[])
}

/// Slave_Diag, as a class 2 master reads it.
pub(super) fn slave_diag(da: Address, sa: Address) -> Vec<u8> {
    request(da, sa, dp::Service::SlaveDiag, FrameCount::First, &[])
}

/// RD_Inp.
pub(super) fn rd_inp(da: Address, sa: Address) -> Vec<u8> {
    request(da, sa, dp::Service::RdInp, FrameCount::First, &[])
}

/// A request to a slave.
pub(super) fn request(
    da: Address,
    sa: Address,
    service: dp::Service,
    count: FrameCount,
    user: &[u8],
) -> Vec<u8> {
    data(da, sa, service.sap(), FunctionCode::request(Service::SrdHigh, count), user)
}

fn data(da: Address, sa: Address, dsap: Option<Sap>, fc: FunctionCode, data: &[u8]) -> Vec<u8> {
    let ssap = dsap.and(dp::MASTER_SAP);
    let format = DataTelegram::customary_format(dsap, ssap, data);
    octets(&Telegram::Data(DataTelegram { format, da, sa, dsap, ssap, fc, data }))
}

fn octets(telegram: &Telegram<'_>) -> Vec<u8> {
    let mut buf = [0; MAX_TELEGRAM_LEN];
    // Every telegram of this file fits.
    telegram.encode(&mut buf).map(<[u8]>::to_vec).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_telegrams_are_those_of_the_wire() {
        let (own, other) = (Address::from_octet(3), Address::from_octet(2));
        assert_eq!(token(other, own), [0xDC, 2, 3]);
        assert_eq!(status_request(other, own), [0x10, 2, 3, 0x49, 0x4E, 0x16]);
        assert_eq!(status_response(other, own, StationType::MasterReady), [0x10, 2, 3, 0x20, 0x25, 0x16]);
        assert_eq!(slave_diag(Address::from_octet(5), own)[4..9], [0x85, 0x83, 0x6D, 60, 62]);
    }
}
