//! A slave of DP-V1 as masters of class 2 see it: connections (`dp-v1.md` 4 and 11).

use std::time::Duration;

use profidrive::profibus::dp::State;
use profidrive::profibus::dpv1::Offer;
use profidrive::profibus::fdl::Service;

use crate::dpv1_line::{CFG, FULL, OTHER, OWNER, PRM, V1Line};
use crate::slave_line::{Answer, RR, RS};
use crate::telegrams::hex;

const INITIATE: [u8; 20] = [0x57, 0, 0, 0, 0, 100, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];
const READ: [u8; 4] = [0x5E, 1, 10, 240];
const DATA: [u8; 8] = [0x5E, 1, 10, 4, 0x11, 0x22, 0x33, 0x44];

/// A connection of this master, and its SAP.
pub(crate) fn open(line: &mut V1Line, master: u8) -> u8 {
    let rm = line.ask_ms2(master, 49, &INITIATE);
    assert_eq!((rm[0], &rm[2..]), (0x56, &[0, 10][..]));
    let accepted = match line.ms2(master, rm[1], &[]) {
        Answer::Low(octets) => octets,
        answer => panic!("Initiate: {answer:?}"),
    };
    assert_eq!(accepted, [0x57, 240, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0]);
    rm[1]
}

#[test]
fn v1_r69_v1_r70_v1_r72_v1_r73_the_telegrams_are_those_of_the_reference() {
    let mut line = V1Line::new(FULL);
    for (request, reply) in [
        (
            "68 19 19 68 87 83 6D 31 32 57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00 9A 16",
            "E5",
        ),
        ("68 05 05 68 87 83 5D 31 32 CA 16", "68 09 09 68 83 87 08 32 31 56 30 00 0A 05 16"),
        (
            "68 05 05 68 87 83 7D 30 32 E9 16",
            "68 15 15 68 83 87 08 32 30 57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00 00 C0 16",
        ),
        ("68 06 06 68 87 83 5D 30 32 48 11 16", "E5"),
        ("68 05 05 68 87 83 7D 30 32 E9 16", "68 06 06 68 83 87 08 32 30 48 BC 16"),
        ("68 08 08 68 87 83 5D 30 32 58 00 20 41 16", "E5"),
        ("68 05 05 68 87 83 7D 30 32 E9 16", "10 03 07 03 0D 16"),
    ] {
        assert_eq!(line.send(&hex(request)), Some(hex(reply)), "{request}");
    }
    let words: Vec<_> = line.events.iter().map(ToString::to_string).collect();
    assert_eq!(words[0], "opened a connection for master 3 at SAP 48");
    assert_eq!(words[1], "the connection of master 3 at SAP 48 has ended: the master closed it");
    assert_eq!(open(&mut line, OTHER), 48, "it can be had again");
}

#[test]
fn v1_r68_v1_r81_without_connections_and_at_saps_that_nobody_was_given() {
    let mut line = V1Line::new(Offer { ms2: None, ..FULL });
    assert_eq!(line.ms2(OTHER, 49, &INITIATE), RS);
    let mut line = V1Line::new(FULL);
    for sap in 0..49 {
        assert_eq!(line.ms2(OTHER, sap, &[]), RS, "SAP {sap}");
    }
}

#[test]
fn v1_r71_v1_r80_v1_r83_records_and_identification_over_a_connection() {
    let mut line = V1Line::new(FULL);
    let sap = open(&mut line, OTHER);
    assert_eq!(line.ask_ms2(OTHER, sap, &READ), DATA);
    assert_eq!(line.ask_ms2(OTHER, sap, &[0x5F, 1, 10, 4, 4, 3, 2, 1]), [0x5F, 1, 10, 4]);
    assert_eq!(line.ask_ms2(OTHER, sap, &READ)[4..], [4, 3, 2, 1]);
    assert_eq!(line.ask_ms2(OTHER, sap, &[0x5E, 1, 99, 4]), [0xDE, 0x80, 0xB0, 0]);
    assert_eq!(line.ask_ms2(OTHER, sap, &[0x5F, 1, 10, 1, 4]), [0xDF, 0x80, 0xB1, 0]);
    assert_eq!(line.ask_ms2(OTHER, sap, &[0x51, 0, 0, 1, 4]), [0xD1, 0x80, 0xA9, 0]);
    assert_eq!(line.ask_ms2(OTHER, sap, &[0x5C, 1, 2, 1]), [0xDC, 0x80, 0xA9, 0], "no alarms here");
    assert_eq!(line.ask_ms2(OTHER, sap, &[0x5F, 0, 255, 4, 8, 0, 0xFD, 0xE8]), [0x5F, 0, 255, 4]);
    assert_eq!(line.ask_ms2(OTHER, sap, &[0x5E, 0, 255, 240]).len(), 72);
    assert_eq!(line.ms2(OTHER, sap, &READ), Answer::Sc);
    assert_eq!(line.ms2(OTHER, sap, &READ), RR, "one job at a time (O-19)");
}

#[test]
fn v1_r74_a_silent_master_loses_its_connection_and_idle_keeps_it() {
    let mut line = V1Line::new(FULL);
    let sap = open(&mut line, OTHER);
    for _ in 0..6 {
        line.wait(Duration::from_millis(2500));
        assert_eq!(line.ask_ms2(OTHER, sap, &[0x48]), [0x48]);
    }
    line.wait(Duration::from_secs(1));
    assert_eq!(line.ms2(OTHER, sap, &[]), Answer::Sc, "alive after 1 x");
    line.wait(Duration::from_secs(4));
    assert_eq!(line.ms2(OTHER, sap, &[]), RS, "gone after 5 x");
    assert_eq!(
        line.events.last().unwrap().to_string(),
        "the connection of master 3 at SAP 48 has ended: nothing from the master for three times its Send_Timeout"
    );
    // Polls alone keep nothing.
    let sap = open(&mut line, OTHER);
    for _ in 0..30 {
        line.wait(Duration::from_millis(100));
        line.ms2(OTHER, sap, &[]);
    }
    assert_eq!(line.ms2(OTHER, sap, &[]), RS);
}

#[test]
fn an_answer_that_nobody_fetches_frees_its_place() {
    let mut line = V1Line::new(FULL);
    assert_eq!(line.ms2(OTHER, 49, &INITIATE), Answer::Sc);
    assert_eq!(line.ms2(4, 49, &INITIATE), RR, "one at a time");
    assert_eq!(line.ms2(4, 49, &[]), Answer::Sc, "not its answer");
    line.wait(Duration::from_millis(310));
    assert_eq!(open(&mut line, 4), 48);
    assert_eq!(line.ask_ms2(OTHER, 49, &INITIATE)[1], 47);
    line.wait(Duration::from_millis(310));
    assert_eq!(line.ms2(OTHER, 47, &[]), RS);
}

#[test]
fn v1_r73_abort_ends_a_connection_whose_initiate_is_not_answered_yet() {
    for initiate in [&INITIATE[..], &INITIATE[..19]] {
        let mut line = V1Line::new(FULL);
        assert_eq!(line.ask_ms2(OTHER, 49, initiate)[1], 48);
        assert_eq!(line.ms2(OTHER, 48, &[0x58, 0, 0x20]), Answer::Sc);
        assert_eq!(line.ms2(OTHER, 48, &[]), RS);
        assert_eq!(
            line.events.last().unwrap().to_string(),
            "the connection of master 3 at SAP 48 has ended: the master closed it"
        );
        assert_eq!(open(&mut line, 4), 48, "it can be had again");
    }
}

#[test]
fn v1_r75_v1_r76_as_many_connections_as_there_are_each_for_its_master() {
    let mut line = V1Line::new(FULL);
    assert_eq!((open(&mut line, OTHER), open(&mut line, 4)), (48, 47));
    assert_eq!(line.ms2(9, 49, &INITIATE), RS);
    assert_eq!(
        line.events.last().unwrap().to_string(),
        "refused a connection of master 9: all 2 are open; end another one first"
    );
    assert_eq!(line.ms2(4, 48, &READ), RS, "another's");
    assert_eq!(line.srd(OTHER, Some((48, 51)), Service::SrdLow, &READ), RS, "from another SAP");
    assert_eq!(line.ms2(OTHER, 48, &READ), Answer::Sc);
    assert_eq!(line.ms2(4, 47, &READ), Answer::Sc);
    assert_eq!(line.ms2(OTHER, 48, &[]), Answer::Low(DATA.to_vec()));
    assert_eq!(line.ms2(4, 47, &[]), Answer::Low(DATA.to_vec()));
    assert_eq!(line.acyclic.links().map(|link| link.sap).collect::<Vec<_>>(), [48, 47]);
}

#[test]
fn v1_r77_v1_r82_a_connection_knows_nothing_of_the_data_exchange() {
    let mut line = V1Line::new(FULL);
    let sap = open(&mut line, OTHER);
    line.start(OWNER, &PRM);
    assert_eq!(line.ms2(OTHER, sap, &READ), Answer::Sc);
    assert_eq!(line.ms1(&[0x5F, 1, 10, 4, 1, 1, 1, 1]), Answer::Sc);
    assert_eq!(line.ms2(OTHER, sap, &[]), Answer::Low(DATA.to_vec()));
    assert_eq!(line.ms1(&[]), Answer::Low(vec![0x5F, 1, 10, 4]));
    assert_eq!(line.ms2(OTHER, sap, &READ), Answer::Sc);
    let mut unlock = PRM;
    unlock[0] = 0x40;
    assert_eq!(line.dp(OWNER, 61, &unlock), Answer::Sc);
    line.start(OWNER, &PRM);
    assert_eq!(line.ms2(OTHER, sap, &[]), Answer::Low(vec![0x5E, 1, 10, 4, 1, 1, 1, 1]));
    line.wait(Duration::from_millis(1100));
    assert_eq!(line.station.slave().state(), State::WaitPrm, "the watchdog of the owner");
    assert_eq!(line.ask_ms2(OTHER, sap, &[0x48]), [0x48]);
    assert_eq!(line.dp(OWNER, 61, &PRM), Answer::Sc);
    assert_eq!(line.dp(OWNER, 62, &CFG), Answer::Sc);
}

#[test]
fn v1_r78_v1_r79_an_initiate_that_cannot_be_is_answered_with_abort() {
    let with = |change: &dyn Fn(&mut [u8; 20])| {
        let mut octets = INITIATE;
        change(&mut octets);
        octets.to_vec()
    };
    for (initiate, abort) in [
        (with(&|octets| octets[5] = 9), [0x58, 1, 0x16]),
        (with(&|octets| octets[5] = 0), [0x58, 1, 0x16]),
        (with(&|octets| octets[6] = 0), [0x58, 1, 0x12]),
        (with(&|octets| octets[12] = 1), [0x58, 1, 0x17]),
        (with(&|octets| octets[18] = 1), [0x58, 1, 0x17]),
        (INITIATE[..19].to_vec(), [0x58, 1, 0x12]),
        (vec![0x57], [0x58, 1, 0x12]),
        (READ.to_vec(), [0x58, 1, 0x12]),
    ] {
        let mut line = V1Line::new(FULL);
        let rm = line.ask_ms2(OTHER, 49, &initiate);
        assert_eq!(rm[..2], [0x56, 48], "{initiate:02X?}");
        assert_eq!(line.ms2(OTHER, 48, &[]), Answer::Low(abort.to_vec()), "{initiate:02X?}");
        assert_eq!(line.ms2(OTHER, 48, &[]), RS);
        assert_eq!(open(&mut line, OTHER), 48);
    }
    let mut line = V1Line::new(FULL);
    assert_eq!(line.ms2(OTHER, 49, &[0x57; 53]), RR, "longer than Max_Initiate_PDU_Length");
}
