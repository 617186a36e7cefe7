//! Extended diagnosis from the bus: announced, read, gone (`dp-v0.md` 13: D).

#[path = "../../examples/io_station.rs"]
mod io_station;
use profidrive::profibus::dp::ext_diag::{Block, Channel, ChannelError, Direction, ExtDiag, Width};
use profidrive::profibus::dp::{Description, Policy};

use crate::slave_line;
use crate::slave_line::{Answer, IO, MASTER, OTHER, PRM, SlaveLine, accepting};

fn short_circuit() -> ExtDiag {
    let mut diagnosis = ExtDiag::fault();
    diagnosis.push(Block::Modules(&[0b01])).unwrap();
    let channel = Channel {
        module: 0,
        direction: Direction::Output,
        channel: 3,
        width: Width::Bit,
        error: ChannelError::SHORT_CIRCUIT,
    };
    diagnosis.push(Block::Channel(channel)).unwrap();
    diagnosis
}

const SHORT_CIRCUIT: [u8; 5] = [0x42, 0x01, 0x80, 0x83, 0x21];

fn exchanging() -> SlaveLine {
    let mut line = SlaveLine::exchanging(IO, Policy::PROPOSED);
    line.station.set_inputs(&[1, 2, 3, 4]);
    assert_eq!(line.exchange(&[0; 4]), Answer::Low(vec![1, 2, 3, 4]));
    line
}

#[test]
fn d_03_a_filed_diagnosis_is_announced_with_the_inputs_until_it_is_read() {
    let mut line = exchanging();
    line.file(&short_circuit());
    for inputs in [[1, 2, 3, 4], [5, 6, 7, 8], [9, 10, 11, 12]] {
        line.station.set_inputs(&inputs);
        assert_eq!(line.exchange(&inputs), Answer::High(inputs.to_vec()));
        assert_eq!(line.outputs(), inputs, "outputs are taken as ever");
    }
    let expected = [&[0x08, 0x04, 0x00, MASTER, 0x12, 0x34], &SHORT_CIRCUIT[..]].concat();
    assert_eq!(line.diagnosis(MASTER), expected);
    assert_eq!(line.exchange(&[0; 4]), Answer::Low(vec![9, 10, 11, 12]));
    assert_eq!(line.diagnosis(MASTER), expected, "it stays until another one is filed");
}

#[test]
fn d_04_only_the_owners_reading_counts() {
    let mut line = exchanging();
    line.file(&short_circuit());
    assert_eq!(line.diagnosis(OTHER)[0], 0x08);
    assert!(matches!(line.exchange(&[0; 4]), Answer::High(_)));
    assert_eq!(line.diagnosis(MASTER)[0], 0x08);
    assert!(matches!(line.exchange(&[0; 4]), Answer::Low(_)));
}

#[test]
fn d_05_a_fault_that_has_gone_is_announced_too() {
    let mut line = exchanging();
    line.file(&short_circuit());
    line.diagnosis(MASTER);
    line.file(&ExtDiag::NONE);
    assert!(matches!(line.exchange(&[0; 4]), Answer::High(_)));
    assert_eq!(line.diagnosis(MASTER), [0x00, 0x04, 0x00, MASTER, 0x12, 0x34]);
    assert!(matches!(line.exchange(&[0; 4]), Answer::Low(_)));
    line.file(&ExtDiag::NONE);
    assert!(matches!(line.exchange(&[0; 4]), Answer::Low(_)), "the same again is no news");
}

#[test]
fn d_06_stat_diag_keeps_the_announcement_until_it_is_withdrawn() {
    let mut line = exchanging();
    line.file(&ExtDiag::NONE.with_stat_diag());
    for _ in 0..3 {
        assert!(matches!(line.exchange(&[0; 4]), Answer::High(_)));
        assert_eq!(line.diagnosis(MASTER)[..2], [0x00, 0x06], "Stat_Diag persists");
    }
    line.file(&ExtDiag::NONE);
    assert!(matches!(line.exchange(&[0; 4]), Answer::High(_)));
    assert_eq!(line.diagnosis(MASTER)[..2], [0x00, 0x04]);
    assert!(matches!(line.exchange(&[0; 4]), Answer::Low(_)));
}

#[test]
fn d_06_stat_diag_is_seen_in_the_start_up_as_real_stations_use_it() {
    let mut line = SlaveLine::new(IO);
    line.file(&ExtDiag::NONE.with_stat_diag());
    assert_eq!(line.diagnosis(MASTER)[..4], [0x02, 0x07, 0x00, 0xFF]);
    line.start_up();
    assert_eq!(line.diagnosis(MASTER)[..4], [0x00, 0x06, 0x00, MASTER]);
    line.file(&ExtDiag::NONE);
    assert_eq!(line.diagnosis(MASTER)[..4], [0x00, 0x04, 0x00, MASTER]);
    assert!(matches!(line.exchange(&[0; 4]), Answer::Low(_)));
}

#[test]
fn d_07_244_octets_of_diagnosis_reach_the_master_and_more_is_an_overflow() {
    let mut line = exchanging();
    let mut diagnosis = ExtDiag::fault();
    for len in [62, 62, 62, 48] {
        diagnosis.push(Block::Device(&[0xA5; 62][..len])).unwrap();
    }
    line.file(&diagnosis);
    let octets = line.diagnosis(MASTER);
    assert_eq!((octets.len(), octets[2]), (244, 0x00));
    assert_eq!(octets[6..], *diagnosis.octets());
    diagnosis.push(Block::Revision(1)).unwrap();
    line.file(&diagnosis);
    assert!(matches!(line.exchange(&[0; 4]), Answer::High(_)), "the overflow is news");
    let octets = line.diagnosis(MASTER);
    assert_eq!((octets.len(), octets[2]), (244, 0x80));
}

#[test]
fn d_07_what_exceeds_the_declared_maximum_is_an_overflow() {
    for (max_diag_len, len, overflow) in
        [(6, 6, 0x80), (8, 8, 0x80), (10, 8, 0x80), (11, 11, 0x00), (0, 6, 0x80)]
    {
        let mut line = SlaveLine::exchanging(Description { max_diag_len, ..IO }, Policy::PROPOSED);
        line.file(&short_circuit());
        let octets = line.diagnosis(MASTER);
        assert_eq!((octets.len(), octets[0], octets[2]), (len, 0x08, overflow), "{max_diag_len}");
    }
}

#[test]
fn d_10_a_slave_without_inputs_announces_with_sd1() {
    let mut line = SlaveLine::judged_by(accepting(&[&[0x23, 0x13], &[0x23]]), IO, Policy::PROPOSED);
    line.request(MASTER, Some(61), &PRM);
    line.request(MASTER, Some(62), &[0x23]);
    assert_eq!(line.exchange(&[0; 4]), Answer::Sc);
    line.file(&short_circuit());
    let octets = line.srd(5, MASTER, None, &[1, 2, 3, 4]);
    assert_eq!(line.send(&octets), Some(slave_line::hex("10 02 05 0A 11 16")));
    assert_eq!(line.outputs(), [1, 2, 3, 4]);
    line.diagnosis(MASTER);
    assert_eq!(line.exchange(&[0; 4]), Answer::Sc);
}

#[test]
fn c_04_a_retried_diagnosis_is_the_same_although_another_one_was_filed() {
    let mut line = exchanging();
    line.file(&short_circuit());
    let octets = line.srd(5, MASTER, Some(60), &[]);
    let first = line.send(&octets);
    line.file(&ExtDiag::NONE);
    assert_eq!(line.send(&octets), first, "the same octets");
    assert!(matches!(line.exchange(&[0; 4]), Answer::High(_)), "the second diagnosis is not lost");
    assert_eq!(line.diagnosis(MASTER)[0], 0x00);
}

#[test]
fn c_03_a_retried_exchange_repeats_the_announcement() {
    let mut line = exchanging();
    line.file(&short_circuit());
    let octets = line.srd(5, MASTER, None, &[0; 4]);
    let first = line.send(&octets);
    line.station.set_inputs(&[7; 4]);
    assert_eq!(line.send(&octets), first);
}

#[test]
fn what_is_filed_before_the_start_up_is_read_in_it() {
    let mut line = SlaveLine::new(IO);
    line.file(&short_circuit());
    line.start_up();
    assert_eq!(line.diagnosis(MASTER)[0], 0x08);
    assert!(matches!(line.exchange(&[0; 4]), Answer::Low(_)));
    // A master that skips the reading is told.
    let mut line = SlaveLine::new(IO);
    line.file(&short_circuit());
    line.start_up();
    assert!(matches!(line.exchange(&[0; 4]), Answer::High(_)));
}

#[test]
fn the_example_runs_from_power_on_to_a_diagnosis() {
    let mut printed = Vec::new();
    io_station::run(&mut printed).unwrap();
    let printed = String::from_utf8(printed).unwrap();
    let lines: Vec<&str> = printed.lines().collect();
    let expected = include_str!("../../examples/io_station.txt");
    assert_eq!(lines, expected.lines().collect::<Vec<_>>(), "{printed}");
}
