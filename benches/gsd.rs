//! Stations from GSDs: 125 of 244 octets each way on one simulated line at 12 Mbit/s, one of them alone, and how long the
//! largest file takes to load. `cargo bench --bench gsd`.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_precision_loss,
    clippy::std_instead_of_core,
    reason = "a bench may panic, and has std"
)]

use core::fmt::Write;
use core::time::Duration;
use std::time;

use profidrive::bench::{Answer, Line, ScriptedMaster as Master};
use profidrive::devices::ag03::profibus::{MAX_TELEGRAM_LEN, Timing};
use profidrive::gsd::{Gsd, Policy, Station};
use profidrive::host::{Bus, GsdStation, Refusals, ValueBoard};
use profidrive::process::{Input, Origin, Point, Signal, Source, ValueType};
use profidrive::profibus::dp::Application;
use profidrive::profibus::fdl::{Address, DataTelegram, FunctionCode, Sap};
use profidrive::time::{BaudRate, Instant};

const BAUD: BaudRate = BaudRate::K12000;
const FULL: u8 = 125;
const LONGEST: usize = 244;

fn address(number: u8) -> Address {
    Address::station(number).unwrap()
}

/// 244 octets each way, with an input that mirrors an output.
fn station(number: u8) -> GsdStation {
    let inputs = "0x5F,0x5F,0x5F,0x5F,0x5F,0x5F,0x5F,0x59";
    let outputs = "0x6F,0x6F,0x6F,0x6F,0x6F,0x6F,0x6F,0x69";
    let file = format!(
        "#Profibus_DP\nIdent_Number=0x0ABC\n12M_supp=1\nModule=\"long\" {inputs},{outputs}\nEndModule\n"
    );
    let station = Station::new(Gsd::read(file.as_bytes()).unwrap(), Policy::PROPOSED).unwrap();
    let mut station = GsdStation::new(address(number), BAUD, station, Refusals::default());
    let word = |offset| Point { slot: 1, offset, kind: ValueType::Unsigned16 };
    let mirror = Source::Follow { of: Origin::Output(word(0)), delay: Duration::ZERO };
    station.connect(Input::new(word(242), Signal::new(mirror).unwrap()));
    station.on_board(ValueBoard::default())
}

fn configuration() -> Vec<u8> {
    let station = station(1);
    station.slave().application().configuration(None).to_vec()
}

fn prm() -> [u8; 7] {
    [0x80, 0, 0, 11, 0x0A, 0xBC, 0]
}

/// Rounds of a line: ns for one exchange of one station, master and rules of the line included, and how many times faster than
/// the bus that is.
fn rounds(stations: u8) -> (f64, f64) {
    let mut bus = Bus::on(BAUD, Timing::True);
    (1..=stations).for_each(|number| bus.add(station(number)).unwrap());
    let mut line = Line::new(BAUD);
    line.connect(bus);
    let mut master = Master::new(address(0));
    let cfg = configuration();
    for number in 1..=stations {
        for (sap, data) in [(61, &prm()[..]), (62, &cfg)] {
            let answer = master.srd(&mut line, address(number), Sap::new(sap), data).unwrap();
            assert_eq!(answer, Answer::ShortAcknowledge, "station {number}");
        }
    }
    let mut round = |outputs: &[u8]| {
        for number in 1..=stations {
            let answer = master.srd(&mut line, address(number), None, outputs).unwrap();
            assert!(matches!(answer, Answer::Data(_, inputs) if inputs.len() == LONGEST), "station {number}");
        }
        while line.bus_mut(0).unwrap().poll_event().is_some() {}
        line.now()
    };
    let mut ratios = Vec::new();
    let mut before = round(&[0; LONGEST]);
    for n in 0..51_u8 {
        let outputs = [n; LONGEST];
        let start = time::Instant::now();
        let begun = before;
        for _ in 0..u32::from(FULL / stations) {
            before = round(&outputs);
        }
        let here = start.elapsed().as_secs_f64();
        let exchanges = f64::from(FULL / stations) * f64::from(stations);
        let there = before.saturating_since(begun).as_secs_f64();
        ratios.push((here / exchanges * 1e9, there / here));
    }
    ratios.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    ratios[ratios.len() / 2]
}

/// ns from the octets of a Data_Exchange to the octets of its reply on a bus of 125: median, 99 % and 99.9 %.
fn turnaround() -> [f64; 3] {
    let mut bus = Bus::on(BAUD, Timing::Untrue);
    (1..=FULL).for_each(|number| bus.add(station(number)).unwrap());
    let mut buf = [0; MAX_TELEGRAM_LEN];
    let telegram = |number: u8, fc: u8, sap: Option<u8>, data: &[u8]| -> Vec<u8> {
        let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
        let telegram = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, data),
            da: address(number),
            sa: address(0),
            dsap,
            ssap,
            fc: FunctionCode::from_octet(fc),
            data,
        };
        telegram.encode(&mut [0; MAX_TELEGRAM_LEN]).unwrap().to_vec()
    };
    let mut now = Instant::ZERO;
    let mut say = |bus: &mut Bus, octets: &[u8]| {
        now = now.saturating_add(core::time::Duration::from_micros(400));
        bus.handle_timeout(now);
        let start = time::Instant::now();
        bus.handle_bytes(now, octets);
        let due = now.saturating_add(BAUD.bit_times(11));
        let replied = bus.poll_transmit(due, &mut buf).map(<[u8]>::len);
        let taken = start.elapsed();
        while bus.poll_event().is_some() {}
        (replied, taken)
    };
    let cfg = configuration();
    for number in 1..=FULL {
        say(&mut bus, &telegram(number, 0x6D, Some(61), &prm()));
        say(&mut bus, &telegram(number, 0x5D, Some(62), &cfg));
    }
    let mut taken = Vec::new();
    for n in 0..800_u32 {
        let fc = if n % 2 == 0 { 0x7D } else { 0x5D };
        for number in 1..=FULL {
            let [.., low] = n.to_be_bytes();
            let (replied, time) = say(&mut bus, &telegram(number, fc, None, &[low; LONGEST]));
            assert_eq!(replied, Some(253), "station {number}");
            taken.push(time.as_secs_f64() * 1e9);
        }
    }
    taken.sort_unstable_by(f64::total_cmp);
    [500, 990, 999].map(|part| taken[taken.len() * part / 1000])
}

/// As large as real files get: 302 modules with parameters of their own, 679 definitions, 256 kB.
fn largest() -> String {
    let mut text = String::from(
        "#Profibus_DP\nGSD_Revision=5\nIdent_Number=0x0ABC\nModular_Station=1\nMax_Module=63\n\
        Max_Input_Len=244\nMax_Output_Len=244\nMax_Data_Len=488\nMax_Diag_Data_Len=244\nMax_User_Prm_Data_Len=237\n",
    );
    for n in 1..=679 {
        let _ = write!(
            text,
            "PrmText={n}\nText(0)=\"channel group {n} is switched off\"\nText(1)=\"channel group {n} is switched on\"\n\
             EndPrmText\nExtUserPrmData={n} \"mode of the channel group {n}\"\nBitArea({}-{}) 1 0-1\nPrm_Text_Ref={n}\n\
             EndExtUserPrmData\n",
            n % 4,
            n % 4 + 2
        );
    }
    for n in 1..=302 {
        let _ = write!(
            text,
            "Module=\"electronic module number {n}\" 0x41,0x0{:X},0x{:02X}\n{n}\nExt_Module_Prm_Data_Len=20\n",
            n % 8,
            n % 200
        );
        for place in 0..8 {
            let _ = writeln!(text, "Ext_User_Prm_Data_Ref({place})={}", n * 2 + place);
        }
        text += "EndModule\n";
    }
    while text.len() < 256_000 {
        text += "; what a manufacturer has to say about it, line by line, in the language of the file\n";
    }
    text
}

fn main() {
    if !std::env::args().any(|argument| argument == "--bench") {
        // `cargo test --benches` only wants to know that it runs.
        return;
    }
    println!("stations of 244/244   ns for an exchange with master and line   bus time / time here");
    for stations in [1, 5, 25, FULL] {
        let (nanos, factor) = rounds(stations);
        println!("{stations:>19} {nanos:>42.0} {factor:>22.1}");
    }
    let [median, most, nearly_all] = turnaround();
    println!(
        "octets in, octets of the reply out, one of 125: median {median:.0} ns, 99 % {most:.0} ns, 99.9 % {nearly_all:.0} ns"
    );
    let text = largest();
    let mut loads: Vec<f64> = (0..21)
        .map(|_| {
            let start = time::Instant::now();
            let station = Station::new(Gsd::read(text.as_bytes()).unwrap(), Policy::PROPOSED).unwrap();
            assert_eq!((station.gsd().modules.len(), station.gsd().parameters.len()), (302, 679));
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    loads.sort_unstable_by(f64::total_cmp);
    println!(
        "a file of {} kB, 302 modules, 679 parameters: loaded in {:.1} ms",
        text.len() / 1000,
        loads[10]
    );
}
