use super::*;
use crate::gsd::Policy;
use crate::process::ValueType;

#[test]
fn a_station_that_is_removed_while_its_input_is_forced_turns_its_switches_off() {
    let gsd = Gsd::read(include_bytes!("../../../tests/gsd/remote_io.gsd")).unwrap();
    let station = Station::new(gsd, Policy::PROPOSED).unwrap();
    let address = Address::station(7).unwrap();
    let mut station = GsdStation::new(address, BaudRate::K500, station, Refusals::default());
    let (point, switch) = (Point { slot: 1, offset: 0, kind: ValueType::Bit(0) }, Switch::default());
    station.watch(point, Condition::Is(1.0), switch.clone());
    station.force(point, 1.0).unwrap();
    assert!(switch.is_on());
    drop(station);
    assert!(!switch.is_on(), "a fault that waits for the input would act for ever");
}
