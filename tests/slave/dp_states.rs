//! The slave machine as a table: every state, service, caller and lock, with the reply and what became of the slave.
//!
//! The table is `docs/dp-states.txt`. After a change that is meant, `UPDATE_DP_STATES=1 cargo test --test slave dp_states`
//! writes it anew; the difference is then read in the commit.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use profidrive::profibus::dp::policy::ApplicationReady;
use profidrive::profibus::dp::{CfgTicket, Policy, State, Station, StoredAddress};
use profidrive::profibus::fdl::{Address, FrameCount, FunctionCode, Service};

use crate::slave_line::{
    ACCEPTS, Answer, BAUD, CFG, IO, MASTER, OTHER, PRM, SLAVE, SlaveLine, answer, telegram,
};

/// Lock with Sync and Freeze.
const LOCK: [u8; 7] = [0xB0, 1, 1, 11, 0x12, 0x34, 0];

/// A state of the slave and of its locks, and how it gets there.
type Situation = (&'static str, fn() -> SlaveLine);

const SITUATIONS: [Situation; 7] = [
    ("WAIT-PRM, nobody's, after power-on", || SlaveLine::new(IO)),
    ("WAIT-PRM, released by master 2", || {
        let mut line = exchanging();
        line.request(MASTER, Some(61), &[0x40, 1, 1, 11, 0x12, 0x34, 0]);
        line
    }),
    ("WAIT-PRM, nobody's, address locked by No_Add_Chg", || {
        let stored = StoredAddress { address: Address::station(SLAVE).unwrap(), no_add_chg: true };
        SlaveLine::of(Station::restored(stored, &[], BAUD, None, IO, ACCEPTS))
    }),
    ("WAIT-CFG, locked by master 2", || {
        let mut line = SlaveLine::new(IO);
        line.request(MASTER, Some(61), &LOCK);
        line
    }),
    ("WAIT-CFG, locked by master 2, the application judges", || {
        let policy = Policy { application_ready: ApplicationReady::WhenJudged, ..Policy::PROPOSED };
        let mut line = SlaveLine::with(IO, policy);
        line.request(MASTER, Some(61), &LOCK);
        line.request(MASTER, Some(62), &CFG);
        line
    }),
    ("DATA-EXCH, locked by master 2", exchanging),
    ("DATA-EXCH, locked by master 2, Sync and Freeze active", || {
        let mut line = exchanging();
        line.sdn(MASTER, 127, 58, &[0x28, 0]);
        line
    }),
];

fn exchanging() -> SlaveLine {
    let mut line = SlaveLine::new(IO);
    line.request(MASTER, Some(61), &LOCK);
    line.request(MASTER, Some(62), &CFG);
    line.station.set_inputs(&[1, 2, 3, 4]);
    line.exchange(&[9; 4]);
    line
}

/// Who asks: the first of these owns the slave, where anybody does.
const CALLERS: [(&str, u8, u8); 4] = [
    ("owner 2", MASTER, SLAVE),
    ("other 3", OTHER, SLAVE),
    ("owner 2 to all", MASTER, 127),
    ("other 3 to all", OTHER, 127),
];

/// A request: its name, FC service, DSAP and data.
type Ask = (&'static str, Service, Option<u8>, &'static [u8]);

const ASKS: [Ask; 38] = [
    ("FDL status", Service::FdlStatus, None, &[]),
    ("Ident", Service::Ident, None, &[]),
    ("LSAP status", Service::LsapStatus, None, &[]),
    ("SDA to SAP 60", Service::SdaHigh, Some(60), &[]),
    ("SAP 40", Service::SrdHigh, Some(40), &[]),
    ("Slave_Diag", Service::SrdHigh, Some(60), &[]),
    ("Slave_Diag, 1 octet", Service::SrdHigh, Some(60), &[0]),
    ("Slave_Diag as SDN", Service::SdnHigh, Some(60), &[]),
    ("Get_Cfg", Service::SrdHigh, Some(59), &[]),
    ("Get_Cfg, 1 octet", Service::SrdHigh, Some(59), &[0]),
    ("RD_Inp", Service::SrdHigh, Some(56), &[]),
    ("RD_Inp, 1 octet", Service::SrdHigh, Some(56), &[0]),
    ("RD_Outp", Service::SrdHigh, Some(57), &[]),
    ("RD_Outp, 1 octet", Service::SrdHigh, Some(57), &[0]),
    ("Set_Prm lock", Service::SrdHigh, Some(61), &PRM),
    ("Set_Prm lock, low", Service::SrdLow, Some(61), &PRM),
    ("Set_Prm unlock", Service::SrdHigh, Some(61), &[0x40, 1, 1, 11, 0x12, 0x34, 0]),
    ("Set_Prm lock+unlock", Service::SrdHigh, Some(61), &[0xC0, 1, 1, 11, 0x12, 0x34, 0]),
    ("Set_Prm neither", Service::SrdHigh, Some(61), &[0x00, 1, 1, 60, 0x99, 0x99, 0xFF]),
    ("Set_Prm wrong ident", Service::SrdHigh, Some(61), &[0x80, 1, 1, 11, 0x12, 0x35, 0]),
    ("Set_Prm 6 octets", Service::SrdHigh, Some(61), &[0x80, 1, 1, 11, 0x12, 0x34]),
    ("Set_Prm as SDN", Service::SdnHigh, Some(61), &[0x40, 1, 1, 11, 0x12, 0x34, 0]),
    ("Chk_Cfg good", Service::SrdHigh, Some(62), &CFG),
    ("Chk_Cfg other good", Service::SrdHigh, Some(62), &[0x21, 0x11]),
    ("Chk_Cfg bad", Service::SrdHigh, Some(62), &[0x23, 0x14]),
    ("Chk_Cfg empty", Service::SrdHigh, Some(62), &[]),
    ("Data_Exchange", Service::SrdHigh, None, &[7, 7, 7, 7]),
    ("Data_Exchange, low", Service::SrdLow, None, &[7, 7, 7, 7]),
    ("Data_Exchange, 0", Service::SrdHigh, None, &[]),
    ("Data_Exchange, 5", Service::SrdHigh, None, &[7; 5]),
    ("Global_Control clear", Service::SdnHigh, Some(58), &[0x02, 0]),
    ("Global_Control sync", Service::SdnLow, Some(58), &[0x28, 0]),
    ("Global_Control undo", Service::SdnHigh, Some(58), &[0x14, 0]),
    ("Global_Control group", Service::SdnHigh, Some(58), &[0x02, 1]),
    ("Global_Control as SRD", Service::SrdHigh, Some(58), &[0x02, 0]),
    ("Set_Slave_Add 7", Service::SrdHigh, Some(55), &[7, 0x12, 0x34, 0]),
    ("Set_Slave_Add 126", Service::SrdHigh, Some(55), &[126, 0x12, 0x34, 0]),
    ("Set_Slave_Add as SDN", Service::SdnHigh, Some(55), &[7, 0x12, 0x34, 0]),
];

#[test]
fn the_machine_is_the_table_in_docs() {
    let table = table();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/dp-states.txt");
    if std::env::var_os("UPDATE_DP_STATES").is_some() {
        fs::write(&path, &table).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap();
    for (number, (is, was)) in table.lines().zip(kept.lines()).enumerate() {
        assert_eq!(
            is,
            was,
            "docs/dp-states.txt line {}; see the head of tests/slave/dp_states.rs",
            number + 1
        );
    }
    assert_eq!(table.lines().count(), kept.lines().count());
}

fn table() -> String {
    let mut table = String::from(
        "The DP slave machine: every state x service x caller x lock. Written by tests/slave/dp_states.rs.\n\n\
         A cell is the reply, and what changed: the state, O the outputs (cleared, new), D the first two octets\n\
         of the diagnosis, A the address, J the configuration that the application judges. \"-\" is no reply,\n\
         RS = service not activated, RR = no resource, SC = acknowledge, DL n = n octets of data.\n",
    );
    for (situation, reach) in SITUATIONS {
        let owner = reach().station.slave().owner();
        assert_eq!(owner.is_some(), situation.contains(", locked by"), "{situation}");
        write!(table, "\n{situation}\n\n{:<22}", "").unwrap();
        for (caller, ..) in CALLERS {
            let caller = if owner.is_none() { caller.replace("owner", "master") } else { caller.to_owned() };
            write!(table, "| {caller:<42}").unwrap();
        }
        table.truncate(table.trim_end().len());
        table.push('\n');
        for (what, service, dsap, data) in ASKS {
            write!(table, "{what:<22}").unwrap();
            for (_, sa, da) in CALLERS {
                let cell = cell(reach(), sa, da, service, dsap, data);
                write!(table, "| {cell:<42}").unwrap();
            }
            table.truncate(table.trim_end().len());
            table.push('\n');
        }
    }
    table
}

/// What the slave looks like: state, outputs, diagnosis, address, what waits for the application.
fn look(line: &SlaveLine) -> (State, Vec<u8>, [u8; 6], u8, Option<CfgTicket>) {
    let slave = line.station.slave();
    let pending = slave.pending_configuration().map(|pending| pending.0);
    let address = line.station.address().number();
    (slave.state(), slave.outputs().to_vec(), slave.diagnosis().octets(), address, pending)
}

fn cell(mut line: SlaveLine, sa: u8, da: u8, service: Service, dsap: Option<u8>, data: &[u8]) -> String {
    let before = look(&line);
    // A counted request that repeats none, so that it is never taken for a retry.
    let count = match service {
        Service::SrdLow | Service::SrdHigh => FrameCount::First,
        _ => FrameCount::Unused,
    };
    let octets = telegram(da, sa, FunctionCode::request(service, count), dsap, data);
    let mut cell = match answer(line.send(&octets)) {
        Answer::Silence => "-".to_owned(),
        Answer::Sc => "SC".to_owned(),
        Answer::Sd1(0x00) => "OK".to_owned(),
        Answer::Sd1(0x02) => "RR".to_owned(),
        Answer::Sd1(0x03) => "RS".to_owned(),
        Answer::Sd1(fc) => format!("FC {fc:02X}"),
        Answer::Low(data) => format!("DL {}", data.len()),
        Answer::High(data) => format!("DH {}", data.len()),
    };
    let after = look(&line);
    if after.0 != before.0 {
        let state = match after.0 {
            State::WaitPrm => "WAIT-PRM",
            State::WaitCfg => "WAIT-CFG",
            State::DataExch => "DATA-EXCH",
        };
        write!(cell, " -> {state}").unwrap();
    }
    let zero = |outputs: &[u8]| outputs.iter().all(|octet| *octet == 0);
    if after.1 != before.1 && !(zero(&before.1) && zero(&after.1)) {
        let outputs = if zero(&after.1) { "cleared" } else { "new" };
        write!(cell, " O {outputs}").unwrap();
    }
    if after.2 != before.2 {
        write!(cell, " D {:02X} {:02X}", after.2[0], after.2[1]).unwrap();
        if after.2[3] != before.2[3] {
            write!(cell, " owner {}", after.2[3]).unwrap();
        }
    }
    if after.3 != before.3 {
        write!(cell, " A {}", after.3).unwrap();
    }
    match (before.4, after.4) {
        (Some(_), None) => cell.push_str(" J void"),
        (old, Some(new)) if old != Some(new) => cell.push_str(" J anew"),
        _ => {}
    }
    cell
}

#[test]
fn the_table_covers_every_service_state_and_caller() {
    let saps: Vec<Option<u8>> = ASKS.iter().map(|ask| ask.2).collect();
    for sap in (55..=62).map(Some).chain([None]) {
        assert!(saps.contains(&sap), "{sap:?}");
    }
    for state in State::ALL {
        assert!(SITUATIONS.iter().any(|(_, reach)| reach().station.slave().state() == state));
    }
}
