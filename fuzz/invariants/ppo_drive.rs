//! A table of a stranger and any process data: a table that is refused says its line; a drive answers in its PPO, shows one state,
//! and stays within its speed.
//!
//! ```text
//! bits 0 to 2 the PPO, bit 7 the table is TOML and not CSV
//! length (2), table
//! then   00..=9f  an exchange: words (20 octets at most), so many milliseconds
//!        a0..=bf  a write beside the bus: PNU (2), element, value (4)
//!        c0..=df  a fault, a warning or a load (2)
//!        e0..=ff  nothing for a second and a new start
//! ```

use profidrive::devices::BusDrive as _;
use profidrive::devices::ppo_drive::Quantity;
use profidrive::devices::ppo_drive::profibus::{CONFIGURATIONS, IDENT_NUMBER, PpoDrive, PpoOnly};
use profidrive::devices::ppo_drive::profile::ZswBit;
use profidrive::devices::ppo_drive::table::Table;
use profidrive::profibus::dp::{Description, Fixed, State};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, Sap, Service, Telegram,
};
use profidrive::profibus::pkw::Value;
use profidrive::profibus::ppo::PpoType;
use profidrive::time::{BaudRate, Instant};

const KINDS: [PpoType; 5] = [PpoType::Ppo1, PpoType::Ppo2, PpoType::Ppo3, PpoType::Ppo4, PpoType::Ppo5];

pub(crate) fn check(data: &[u8]) {
    let Some(([how, high, low], rest)) = data.split_first_chunk() else { return };
    let (text, steps) = rest.split_at(usize::from(u16::from_be_bytes([*high, *low])).min(rest.len()));
    let text = String::from_utf8_lossy(text);
    let read = if how & 0x80 == 0 { Table::from_csv(&text) } else { Table::from_toml(&text) };
    let table = match read {
        Ok(table) => table,
        Err(error) => {
            assert!(
                error.line > 0 && !error.what.is_empty() && !error.to_string().contains('\n'),
                "{error:?}"
            );
            Table::profile()
        }
    };
    let kind = KINDS[usize::from(how & 7) % KINDS.len()];
    let application = PpoOnly { inner: Fixed { configurations: CONFIGURATIONS, ..Fixed::PLAIN }, only: None };
    let description = Description { ident: IDENT_NUMBER, ..Description::PLAIN };
    let now = Instant::from_millis(1);
    // A default that the drive does not take is refused before.
    let Ok(drive) =
        PpoDrive::new(Address::from_octet(7), BaudRate::K500, (description, application), table, now)
    else {
        return;
    };
    let mut rig = Rig { drive, now, kind };
    rig.start();
    let mut rest = steps;
    for _ in 0..300 {
        let Some(behind) = rig.step(rest) else { break };
        rest = behind;
        rig.judge();
    }
}

struct Rig {
    drive: PpoDrive<PpoOnly<Fixed<'static>>>,
    now: Instant,
    kind: PpoType,
}

impl Rig {
    fn step<'a>(&mut self, octets: &'a [u8]) -> Option<&'a [u8]> {
        let (what, rest) = octets.split_first()?;
        match what {
            0x00..=0x9F => {
                let (words, rest) = rest.split_at(rest.len().min(self.kind.len()));
                let mut outputs = words.to_vec();
                outputs.resize(self.kind.len(), 0);
                let inputs = self.ask(None, &outputs);
                if self.drive.slave().state() == State::DataExch {
                    assert_eq!(inputs.len(), self.kind.len());
                }
                self.pass(u64::from(*what) * 1_000_000);
                Some(rest)
            }
            0xA0..=0xBF => {
                let ([a, b, element, value @ ..], rest) = rest.split_first_chunk::<7>()?;
                let pnu = u16::from_be_bytes([*a, *b]) & 0x7FF;
                let element = (*element != 0).then_some(*element);
                let bits = u32::from_be_bytes(*value);
                let value = if what & 1 == 0 {
                    Value::Double(bits)
                } else {
                    Value::Word(u16::from_be_bytes([value[2], value[3]]))
                };
                let before = self.drive.read_parameter(pnu, element);
                if self.drive.write_parameter(self.now, pnu, element, value).is_err() {
                    assert_eq!(
                        self.drive.read_parameter(pnu, element),
                        before,
                        "a refused write changes nothing"
                    );
                }
                Some(rest)
            }
            0xC0..=0xDF => {
                let ([a, b], rest) = rest.split_first_chunk()?;
                let number = u16::from_be_bytes([*a, *b]);
                match what & 3 {
                    0 => self.drive.raise_fault(self.now, number),
                    1 => self.drive.raise_warning(self.now, number),
                    _ => self.drive.set_load(self.now, f64::from(number)).expect("0 or more"),
                }
                Some(rest)
            }
            0xE0..=0xFF => {
                self.pass(1_000_000_000);
                self.start();
                Some(rest)
            }
        }
    }

    /// What holds whatever came.
    fn judge(&self) {
        let zsw = self.drive.zsw();
        let shown = [ZswBit::Fault, ZswBit::SwitchingOnInhibited, ZswBit::ReadyToSwitchOn];
        assert!(shown.iter().filter(|bit| bit.is_set(zsw)).count() == 1, "one state: {zsw}");
        let drive = self.drive.drive();
        for quantity in Quantity::ALL {
            assert!(drive.quantity(*quantity, 1).is_finite(), "{quantity}");
        }
        for row in self.drive.table().rows() {
            assert!(self.drive.read_parameter(row.pnu, row.elements.map(|_| 1)).is_ok(), "PNU {}", row.pnu);
        }
    }

    fn pass(&mut self, nanos: u64) {
        self.now = Instant::from_nanos(self.now.as_nanos() + nanos + 50_000);
        self.drive.handle_timeout(self.now, &mut |_| {});
    }

    fn start(&mut self) {
        let [high, low] = IDENT_NUMBER.to_be_bytes();
        self.ask(Some(61), &[0x88, 10, 10, 11, high, low, 0]);
        self.ask(Some(62), self.kind.configuration());
    }

    fn ask(&mut self, sap: Option<u8>, data: &[u8]) -> Vec<u8> {
        let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
        let request = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, data),
            da: self.drive.address(),
            sa: Address::from_octet(2),
            dsap,
            ssap,
            fc: FunctionCode::request(Service::SrdHigh, FrameCount::First),
            data,
        };
        let mut buf = [0; 255];
        let octets = request.encode(&mut buf).expect("it has room");
        let Decoded::Telegram { telegram, .. } = decode(octets) else { panic!("{octets:02X?}") };
        let mut news = |event: profidrive::devices::StationEvent| assert!(!event.to_string().contains('\n'));
        self.drive.handle_telegram(self.now, &telegram, &mut news);
        self.now = Instant::from_nanos(self.now.as_nanos() + 50_000);
        let mut reply = [0; MAX_TELEGRAM_LEN];
        let len = self.drive.poll_transmit(self.now, &mut reply, &mut news);
        match len.map(|len| decode(&reply[..len])) {
            Some(Decoded::Telegram { telegram: Telegram::Data(reply), .. }) => reply.data.to_vec(),
            _short_acknowledgement => Vec::new(),
        }
    }
}
