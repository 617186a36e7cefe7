//! The DIP switches: address and factory reset.

use super::*;
use crate::drive_line::of_unit;

#[test]
fn the_address_switches_act_when_it_is_switched_on() {
    let mut line = line(Eeprom::Internal);
    let switches = DipSwitches::from(Address::station(7).unwrap()).with_terminator(true);
    line.device.set_switches(switches);
    assert_eq!(line.device.address().number(), 5);
    exchange(&mut line, Pkw::ZERO, 0, 0);
    power_cycle(&mut line);
    assert_eq!(line.device.address().number(), 7);
    assert_eq!(line.request(MASTER, Some(60), &[]), Reply::Silence, "nobody is at 5");
    assert_eq!(of_unit(line.events.last().unwrap()), Some(&unit::Event::SwitchedOn(switches)));
    assert_eq!(switches.terminator(), Terminator::Active);
    assert_eq!(line.events.last().unwrap().to_string(), "switched on at address 7, bus terminator on");

    let device = Device::new(Config::new(DipSwitches::from_bits(0x7F)), line.now);
    assert_eq!(device.address().number(), 126, "127 acts as 126");
}

#[test]
fn the_factory_reset_of_manual_2_4_over_two_power_cycles() {
    for (number, set) in [(1, DefaultSet::All), (2, DefaultSet::Standard), (3, DefaultSet::Controller)] {
        let mut line = line(Eeprom::Host);
        job(&mut line, write_word(1004, 77));
        stored(&mut line, Ok(()));
        job(&mut line, write_word(1009, 500));
        stored(&mut line, Ok(()));
        fail_internally(&mut line);
        stored(&mut line, Ok(()));
        // 1. Off. 2. The switches. 3. On: it acknowledges by blinking.
        line.device.power_off(line.now);
        line.device.set_switches(DipSwitches::from_bits(number).with_reset(true));
        line.wait(MS);
        line.device.power_on(line.now);
        assert_eq!(line.device.power(), Power::FactoryReset(set));
        line.wait(MS);
        let image = stored(&mut line, Ok(()));
        assert_eq!(line.request(MASTER, Some(60), &[]), Reply::Silence);
        assert!(line.has_told(&unit::Event::FactoryReset(set)));
        // 4. Off. 5. and 6. The address, SW8 OFF. 7. On.
        line.device.power_off(line.now);
        line.device.set_switches(Address::station(5).unwrap().into());
        line.wait(MS);
        line.device.power_on(line.now);
        line.start_up();
        for mut line in [line, restored(config(Eeprom::Host), &image)] {
            if line.device.dp_state() == dp::State::WaitPrm {
                line.start_up();
            }
            let controller = if set == DefaultSet::Standard { 77 } else { 30 };
            let standard = if set == DefaultSet::Controller { 500 } else { 10 };
            assert_eq!(job(&mut line, read(1004)), is_word(1004, controller), "{set:?}");
            assert_eq!(job(&mut line, read(1009)), is_word(1009, standard), "{set:?}");
            assert_eq!(job(&mut line, read(952)), is_word(952, 1), "faults are no parameters");
        }
    }
}

#[test]
fn switch_8_without_a_pattern_resets_nothing() {
    let switches = DipSwitches::from_bits(5).with_reset(true);
    let mut line = Line::with(Config { switches, ..config(Eeprom::Internal) });
    assert_eq!(line.device.power(), Power::On);
    line.start_up();
}
