//! A master of DP-V1 that sends one telegram after the other over TCP.
#![allow(dead_code, reason = "each test file uses its part")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, DataTelegram, FrameCount, FunctionCode, Sap, Service, Telegram};

/// What came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Said {
    Sc,
    /// The low four bits of the function code, and the data.
    Data(u8, Vec<u8>),
}

pub(crate) struct RawMaster {
    line: TcpStream,
    address: u8,
    odd: bool,
}

impl RawMaster {
    /// At the link of an emulator.
    pub(crate) fn new(link: &str, address: u8) -> Self {
        let line = TcpStream::connect(link.strip_prefix("tcp:").unwrap()).unwrap();
        line.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        line.set_nodelay(true).unwrap();
        Self { line, address, odd: false }
    }

    /// One request and its reply.
    pub(crate) fn ask(&mut self, da: u8, saps: Option<(u8, u8)>, data: &[u8]) -> Said {
        self.odd = !self.odd;
        let count = if self.odd { FrameCount::Odd } else { FrameCount::Even };
        let (dsap, ssap) = saps.map(|(dsap, ssap)| (Sap::new(dsap), Sap::new(ssap))).unwrap_or_default();
        let telegram = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, data),
            da: Address::from_octet(da),
            sa: Address::from_octet(self.address),
            dsap,
            ssap,
            fc: FunctionCode::request(Service::SrdHigh, count),
            data,
        };
        self.line.write_all(telegram.encode(&mut [0; 255]).unwrap()).unwrap();
        let mut octets = Vec::new();
        loop {
            let mut octet = [0];
            self.line.read_exact(&mut octet).unwrap();
            octets.push(octet[0]);
            match decode(&octets) {
                Decoded::Telegram { telegram: Telegram::ShortAcknowledge, .. } => return Said::Sc,
                Decoded::Telegram { telegram: Telegram::Data(reply), .. } => {
                    return Said::Data(reply.fc.octet() & 0x0F, reply.data.to_vec());
                }
                _ => assert!(octets.len() < 256, "{octets:02X?}"),
            }
        }
    }

    /// Parameters and configuration, and one exchange.
    pub(crate) fn start(&mut self, da: u8, prm: &[u8], cfg: &[u8], outputs: &[u8]) {
        assert_eq!(self.ask(da, Some((61, 62)), prm), Said::Sc);
        assert_eq!(self.ask(da, Some((62, 62)), cfg), Said::Sc);
        assert!(matches!(self.ask(da, Some((60, 62)), &[]), Said::Data(..)));
        assert!(matches!(self.ask(da, None, outputs), Said::Data(8 | 10, _)));
    }

    /// A request at SAP 51 and its response, polled for.
    pub(crate) fn ms1(&mut self, da: u8, data: &[u8]) -> Vec<u8> {
        assert_eq!(self.ask(da, Some((51, 51)), data), Said::Sc);
        loop {
            match self.ask(da, Some((51, 51)), &[]) {
                Said::Sc => std::thread::yield_now(),
                Said::Data(_, octets) => return octets,
            }
        }
    }
}
