//! Drives of PROFIDRIVE version 2: a right one of each PPO, and mistakes in the parameter channel and the states.

use profidrive::bench::Port;
use profidrive::devices::ppo_drive::profibus::{CONFIGURATIONS, IDENT_NUMBER, PpoDrive, PpoOnly};
use profidrive::devices::ppo_drive::table::Table;
use profidrive::host::{HostedPpoDrive, PpoJudge, Refusals};
use profidrive::judge::Requirement as _;
use profidrive::judge::device::slave::{Report, Row, Setup, simulated};
use profidrive::profibus::dp::{Description, Fixed};
use profidrive::profibus::fdl::Address;
use profidrive::profibus::ppo::PpoType;
use profidrive::time::{BaudRate, Instant};

use super::broken;
use super::changed::{Change, Changed};

const BAUD: BaudRate = BaudRate::K500;
const KINDS: [PpoType; 5] = [PpoType::Ppo1, PpoType::Ppo2, PpoType::Ppo3, PpoType::Ppo4, PpoType::Ppo5];

fn judged(kind: PpoType, change: Change) -> Report {
    let fixed = Fixed { configurations: CONFIGURATIONS, ..Fixed::PLAIN };
    let application = PpoOnly { inner: PpoJudge::Profile(fixed), only: None };
    let description = Description { ident: IDENT_NUMBER, ..Description::PLAIN };
    let address = Address::station(5).unwrap();
    let parts = (description, application);
    let drive = PpoDrive::new(address, BAUD, parts, Table::profile(), Instant::ZERO).unwrap();
    let drive = HostedPpoDrive::new(drive, Refusals::default());
    let port = Port::new(BAUD);
    port.line(|line| line.add(Changed::new(drive, None, change)).unwrap());
    let setup =
        Setup { profile: Some(kind), moves_allowed: true, writes_allowed: true, ..Setup::new(address) };
    let rows: Vec<Row> = ["P-*", "S-P01", "S-G01", "S-X01"].into_iter().flat_map(Row::matching).collect();
    simulated(&port, setup, &rows, None).unwrap()
}

#[test]
fn a_drive_of_each_ppo_is_right() {
    for kind in KINDS {
        let report = judged(kind, |_, _| ());
        assert!(broken(&report).is_empty(), "{kind}: {report}");
        assert_eq!(report.outcome().status(), 0, "{kind}: {report}");
        let judged = report.judgements.iter().filter(|row| row.row.id().starts_with("P-") && row.applies);
        assert_eq!(judged.count(), if kind.has_pkw() { 16 } else { 5 }, "{kind}: {report}");
    }
}

/// AK of the job and of the reply, and PNU of the reply.
fn aks(outputs: &[u8], inputs: &[u8]) -> (u8, u8, u16) {
    (outputs[0] >> 4, inputs[0] >> 4, u16::from_be_bytes([inputs[0], inputs[1]]) & 0x07FF)
}

const MISTAKES: &[(&str, &[&str], Change)] = &[
    ("no job is replied to", &["P-K01"], |outputs, inputs| {
        if outputs[0] >> 4 == 0 {
            inputs[0] = 0x10;
        }
    }),
    ("the reply has another PNU", &["P-K02", "P-K03"], |outputs, inputs| {
        if aks(outputs, inputs).1 != 0 {
            inputs[1] ^= 1;
        }
    }),
    ("an unknown PNU is refused with error 18", &["P-K03"], |outputs, inputs| {
        if aks(outputs, inputs) == (1, 7, 2046) {
            inputs[7] = 18;
        }
    }),
    ("an unknown PNU is read as zero", &["P-K03"], |outputs, inputs| {
        if aks(outputs, inputs) == (1, 7, 2046) {
            inputs[0] = 0x17;
            inputs[7] = 0;
        }
    }),
    ("the reply is there once only", &["P-K04"], |outputs, inputs| {
        // Every third exchange of a job that stays.
        if aks(outputs, inputs).1 == 1 && outputs.iter().all(|octet| *octet != 0xEE) {
            let counted = COUNT.with(|count| {
                count.set(count.get() + 1);
                count.get()
            });
            if counted.is_multiple_of(16) {
                inputs[..8].fill(0);
            }
        }
    }),
    ("an element too many is refused with error 2", &["P-K05"], |outputs, inputs| {
        if aks(outputs, inputs) == (6, 7, 980) {
            inputs[7] = 2;
        }
    }),
    ("the number of elements is a word", &["P-K05", "P-K06"], |outputs, inputs| {
        if aks(outputs, inputs).1 == 6 {
            inputs[0] = inputs[0] & 0x0F | 0x10;
        }
    }),
    ("a parameter to be read is written", &["P-K07", "P-K10"], |outputs, inputs| {
        if aks(outputs, inputs).0 == 2 && aks(outputs, inputs).1 == 7 {
            inputs[0] = inputs[0] & 0x0F | 0x10;
        }
    }),
    ("a listed parameter is not there", &["P-K08"], |outputs, inputs| {
        if aks(outputs, inputs).0 == 1 && aks(outputs, inputs).2 == 967 {
            inputs[0] = inputs[0] & 0x0F | 0x70;
            inputs[4..8].fill(0);
        }
    }),
    ("reserved jobs are read", &["P-K09"], |outputs, inputs| {
        if aks(outputs, inputs).0 >= 10 && aks(outputs, inputs).1 == 7 {
            inputs[0] = inputs[0] & 0x0F | 0x10;
        }
    }),
    ("a write is answered with another value", &["P-K10"], |outputs, inputs| {
        if matches!(aks(outputs, inputs), (2 | 3, 1 | 2, _)) {
            inputs[7] ^= 1;
        }
    }),
    ("a description is a word", &["P-K11"], |outputs, inputs| {
        if aks(outputs, inputs).0 == 4 && aks(outputs, inputs).1 != 0 {
            inputs[0] = inputs[0] & 0x0F | 0x10;
        }
    }),
    ("ready without ON", &["P-S01"], |outputs, inputs| {
        if outputs[9] & 0x01 == 0 {
            inputs[9] |= 0x02;
        }
    }),
    ("ON at once switches on", &["P-S02"], |outputs, inputs| {
        if outputs[9] == 0x7F && inputs[9] & 0x40 != 0 {
            inputs[9] = inputs[9] & !0x40 | 0x07;
        }
    }),
    ("switched on is not told", &["P-S03"], |_, inputs| {
        if inputs[9] & 0x07 == 0x03 {
            inputs[9] &= !0x02;
        }
    }),
    ("OFF2 leaves it ready to switch on", &["P-S04"], |outputs, inputs| {
        if outputs[9] == 0x7D {
            inputs[9] = inputs[9] & !0x40 | 0x01;
        }
    }),
];

std::thread_local! {
    static COUNT: core::cell::Cell<u32> = const { core::cell::Cell::new(0) };
}

#[test]
fn each_mistake_in_the_profile_is_found_by_its_rows_and_by_no_other() {
    let mut wrong = Vec::new();
    for (name, rows, change) in MISTAKES {
        let report = judged(PpoType::Ppo1, *change);
        if broken(&report) != *rows {
            wrong.push(format!("{name}: {:?}, expected {rows:?}", broken(&report)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The length is that of the other end: a drive of PPO 1, and the judge was told PPO 2 with its own configuration.
#[test]
fn another_ppo_is_told() {
    let fixed = Fixed { configurations: &[&[0xF3, 0xF1]], ..Fixed::PLAIN };
    let description = Description { ident: IDENT_NUMBER, ..Description::PLAIN };
    let station =
        profidrive::profibus::dp::Station::new(Address::station(5).unwrap(), BAUD, None, description, fixed);
    let port = Port::new(BAUD);
    port.line(|line| line.add(station).unwrap());
    let setup = Setup {
        profile: Some(PpoType::Ppo2),
        cfg: Some(vec![0xF3, 0xF1]),
        ..Setup::new(Address::station(5).unwrap())
    };
    let rows: Vec<Row> = ["P-L01", "S-X01"].into_iter().flat_map(Row::matching).collect();
    let report = simulated(&port, setup, &rows, None).unwrap();
    assert_eq!(broken(&report), ["P-L01"], "{report}");
}
