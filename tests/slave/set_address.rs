//! Set_Slave_Add: a master gives a slave its address (`dp-v0.md` 6.4 and 13: A, N-03, C-05).

use profidrive::profibus::dp::{AddressFault, Description, Event, Policy, State, Station, StoredAddress};
use profidrive::profibus::fdl::Address;

use crate::slave_line;
use crate::slave_line::{ACCEPTS, Answer, BAUD, IO, MASTER, OTHER, PRM, RS, SLAVE, SlaveLine, answer};

fn address(number: u8) -> Address {
    Address::station(number).unwrap()
}

/// As delivered: at 126.
fn delivered() -> SlaveLine {
    restored(StoredAddress::DELIVERED, &[])
}

fn restored(stored: StoredAddress, rem_slave_data: &[u8]) -> SlaveLine {
    SlaveLine::of(Station::restored(stored, rem_slave_data, BAUD, Some(BAUD.max_tsdr_bits()), IO, ACCEPTS))
}

/// Set_Slave_Add to `new` with the right ident number.
fn new_address(new: u8, no_add_chg: u8) -> [u8; 4] {
    [new, 0x12, 0x34, no_add_chg]
}

fn diagnosis(line: &mut SlaveLine, da: u8) -> Answer {
    line.request_to(da, MASTER, Some(60), &[])
}

const POWER_ON: [u8; 6] = [0x02, 0x05, 0x00, 0xFF, 0x12, 0x34];

#[test]
fn a_01_the_slave_acknowledges_at_126_and_answers_at_7_from_then_on() {
    let mut line = delivered();
    // The telegrams of the worked example, dp-v0.md 10.
    assert_eq!(line.send(&slave_line::hex("68 09 09 68 FE 82 6D 37 3E 07 12 34 00 AF 16")), Some(vec![0xE5]));
    assert_eq!(diagnosis(&mut line, 126), Answer::Silence);
    assert_eq!(diagnosis(&mut line, 7), Answer::Low(POWER_ON.to_vec()));
    let stored = StoredAddress { address: address(7), no_add_chg: false };
    assert_eq!(line.events, [Event::AddressSet { master: address(MASTER), stored }]);
    assert_eq!(line.station.stored_address(), stored);
    assert_eq!(line.request_to(7, MASTER, Some(61), &PRM), Answer::Sc);
    assert_eq!(line.request_to(7, MASTER, Some(62), &slave_line::CFG), Answer::Sc);
    assert_eq!(line.request_to(7, MASTER, None, &[0; 4]), Answer::Low(vec![0; 4]));
}

#[test]
fn a_02_what_is_wrong_is_acknowledged_and_changes_nothing() {
    for (data, fault) in [
        (&[7, 0x12, 0x35, 0][..], AddressFault::Ident { expected: 0x1234, got: 0x1235 }),
        (&new_address(126, 0), AddressFault::Address { got: 126 }),
        (&new_address(127, 0), AddressFault::Address { got: 127 }),
        (&[7, 0x12, 0x34], AddressFault::Length { got: 3 }),
    ] {
        let mut line = delivered();
        assert_eq!(line.request_to(126, MASTER, Some(55), data), Answer::Sc);
        assert_eq!(line.events, [Event::AddressRefused { master: address(MASTER), fault }]);
        assert_eq!(diagnosis(&mut line, 126), Answer::Low(POWER_ON.to_vec()));
        assert_eq!(diagnosis(&mut line, 7), Answer::Silence);
    }
}

#[test]
fn a_02_only_a_slave_that_waits_for_parameters_takes_an_address() {
    let mut line = SlaveLine::new(IO);
    line.request(MASTER, Some(61), &PRM);
    assert_eq!(line.request(MASTER, Some(55), &new_address(7, 0)), RS, "WAIT-CFG");
    line.request(MASTER, Some(62), &slave_line::CFG);
    assert_eq!(line.request(MASTER, Some(55), &new_address(7, 0)), RS, "DATA-EXCH");
    assert_eq!(line.station.address(), address(SLAVE));
    assert_eq!(line.station.slave().state(), State::DataExch);
}

#[test]
fn a_03_no_add_chg_rules_out_a_second_change_over_a_power_cycle_too() {
    let mut line = delivered();
    assert_eq!(line.request_to(126, MASTER, Some(55), &new_address(7, 0xFF)), Answer::Sc);
    assert_eq!(line.request_to(7, MASTER, Some(55), &new_address(8, 0)), Answer::Sc);
    assert_eq!(diagnosis(&mut line, 8), Answer::Silence);
    let mut line = restored(line.station.stored_address(), &[]);
    assert_eq!(line.request_to(7, MASTER, Some(55), &new_address(8, 0)), Answer::Sc);
    let refused = Event::AddressRefused { master: address(MASTER), fault: AddressFault::Locked };
    assert_eq!(line.events, [refused]);
    assert_eq!(diagnosis(&mut line, 7), Answer::Low(POWER_ON.to_vec()));
}

#[test]
fn a_04_a_slave_without_the_service_refuses() {
    let mut line = SlaveLine::new(Description { set_slave_add: false, ..IO });
    assert_eq!(line.request(MASTER, Some(55), &new_address(7, 0)), RS);
    assert_eq!(line.station.address(), address(SLAVE));
}

#[test]
fn a_05_the_address_and_what_came_with_it_survive_a_power_cycle() {
    let mut line = delivered();
    let request = [&new_address(99, 0)[..], &[0xAB; 240]].concat();
    assert_eq!(line.request_to(126, MASTER, Some(55), &request), Answer::Sc);
    assert_eq!(line.station.slave().rem_slave_data(), [0xAB; 240]);
    let slave = line.station.slave();
    let mut line = restored(line.station.stored_address(), slave.rem_slave_data());
    assert_eq!(line.station.slave().rem_slave_data(), [0xAB; 240]);
    assert_eq!(diagnosis(&mut line, 99), Answer::Low(POWER_ON.to_vec()));
    assert_eq!(diagnosis(&mut line, 126), Answer::Silence);
}

#[test]
fn a_06_every_address_from_0_to_125() {
    let mut line = delivered();
    let mut at = 126;
    for new in 0..=125 {
        let master = [100, 101, 102].into_iter().find(|master| ![at, new].contains(master)).unwrap();
        assert_eq!(line.request_to(at, master, Some(55), &new_address(new, 0)), Answer::Sc, "{new}");
        assert_eq!(line.request_to(new, master, Some(60), &[]), Answer::Low(POWER_ON.to_vec()), "{new}");
        assert_eq!(line.request_to(at, master, Some(60), &[]), Answer::Silence, "{at}");
        at = new;
    }
}

#[test]
fn c_05_a_retried_set_slave_add_gets_the_same_acknowledge_and_is_not_carried_out_twice() {
    let mut line = delivered();
    diagnosis(&mut line, 126);
    let octets = line.srd(126, MASTER, Some(55), &new_address(7, 0));
    assert_eq!(line.send(&octets), Some(vec![0xE5]));
    // The master has not heard it, and knows the slave at its old address only.
    assert_eq!(line.send(&octets), Some(vec![0xE5]));
    assert_eq!(line.send(&octets), Some(vec![0xE5]));
    assert_eq!(line.events.len(), 1);
    assert_eq!(diagnosis(&mut line, 7), Answer::Low(POWER_ON.to_vec()));
    assert_eq!(line.send(&octets), None, "no retry any more: the slave was asked for something else");
}

#[test]
fn c_05_another_request_to_the_old_address_is_for_somebody_else() {
    let mut line = delivered();
    diagnosis(&mut line, 126);
    let octets = line.srd(126, MASTER, Some(55), &new_address(7, 0));
    assert_eq!(line.send(&octets), Some(vec![0xE5]));
    assert_eq!(line.request_to(126, MASTER, Some(55), &new_address(8, 0)), Answer::Silence);
    assert_eq!(line.send(&octets), None);
    assert_eq!(line.request_to(126, OTHER, Some(55), &new_address(8, 0)), Answer::Silence);
    assert_eq!(line.station.address(), address(7));
}

#[test]
fn n_03_units_as_delivered_get_their_addresses_one_at_a_time() {
    // Two units at 126 take the same address from one telegram and would answer together: the user connects one
    // after the other, as the manuals of such devices ask.
    let mut units = [delivered(), delivered()];
    let octets = units[0].srd(126, MASTER, Some(55), &new_address(10, 0));
    let answers: Vec<Answer> = units.iter_mut().map(|unit| answer(unit.send(&octets))).collect();
    assert_eq!(answers, [Answer::Sc, Answer::Sc], "both spoke at once");
    assert!(units.iter().all(|unit| unit.station.address() == address(10)));

    let mut connected: Vec<SlaveLine> = Vec::new();
    for new in 10..15 {
        connected.push(delivered());
        let octets = connected[0].srd(126, MASTER, Some(55), &new_address(new, 0));
        let answers: Vec<Answer> = connected.iter_mut().map(|unit| answer(unit.send(&octets))).collect();
        let answered = answers.iter().filter(|answer| **answer == Answer::Sc).count();
        assert_eq!(answered, 1, "only the unit still at 126: {answers:?}");
    }
    let addresses: Vec<u8> = connected.iter().map(|unit| unit.station.address().number()).collect();
    assert_eq!(addresses, [10, 11, 12, 13, 14]);
}

#[test]
fn a_new_address_is_a_fresh_start() {
    let mut line = delivered();
    assert_eq!(line.request_to(126, MASTER, Some(55), &new_address(8, 0)), Answer::Sc);
    assert_eq!(line.request_to(8, MASTER, Some(61), &[]), Answer::Sc);
    assert!(line.station.slave().diagnosis().prm_fault);
    assert_eq!(line.request_to(8, OTHER, Some(55), &new_address(7, 0)), Answer::Sc);
    assert_eq!(diagnosis(&mut line, 7), Answer::Low(POWER_ON.to_vec()));
    assert_eq!(*line.station.slave().policy(), Policy::PROPOSED);
}
