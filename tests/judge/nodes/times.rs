//! How long a judgement takes on a bus, in virtual time: what is waited for, with what an adapter adds to it.

use std::time::Duration;

use profidrive::can_bus::can::BitRate;
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::devices::{CanopenDevice, CanopenEvent};
use profidrive::eds::Eds;
use profidrive::host::Stop;
use profidrive::host::can::{Product, StoredNode};
use profidrive::host::list::Choices;
use profidrive::judge::device::node::{Live, Port, Row, Setup, live};
use profidrive::judge::{Outcome, Requirement as _};
use profidrive::time::Instant;

use super::{of_file, setup, sheet};

#[test]
fn a_node_takes_less_than_a_minute_and_quickly_a_quarter_of_that() {
    let asda = || -> Box<dyn CanopenDevice> {
        let product = Product::named("asda-a2").unwrap();
        product.make(super::node(), &Choices::default(), Eeprom::Internal, Instant::ZERO)
    };
    let asda_eds = Eds::read(Product::named("asda-a2").unwrap().eds().as_bytes()).unwrap();
    for (name, device, eds, limits) in [
        ("everything", of_file("complete.eds"), sheet("complete.eds"), [40, 13]),
        // Drives that have to come to rest again and again.
        ("every mode", of_file("drive.eds"), sheet("drive.eds"), [55, 25]),
        ("asda-a2", asda(), asda_eds, [75, 30]),
    ] {
        let port: Port<CanopenEvent> = Port::new(BitRate::K500);
        port.bus(|bus, now| bus.add(now, Box::new(StoredNode::new(device, now))));
        for (quick, most) in [false, true].into_iter().zip(limits) {
            let bus = Live {
                endpoint: Box::new(port.clone()),
                clock: Box::new(port.clone()),
                stop: Stop::new().unwrap(),
            };
            let setup = Setup { quick, ..setup(eds.clone()) };
            let report = live(setup, &Row::all(), bus, None, &mut |_| ());
            println!("{name} quick {quick}: {:?}", report.took);
            assert_eq!(report.outcome(), Outcome::Passed, "{name}: {report}");
            assert!(report.took <= Duration::from_secs(most), "{name}: {:?}\n{report}", report.took);
        }
    }
}
