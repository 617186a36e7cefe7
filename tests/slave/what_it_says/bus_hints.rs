//! What is odd on a bus of CANopen.

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::NodeId;
use profidrive::host::can::{NodeWatch, Numbers};
use profidrive::time::Instant;

use super::row;
use crate::sentences::compare;

#[test]
fn hints_of_a_bus() {
    let node = |number| NodeId::new(number).unwrap();
    let said = |watch: NodeWatch, id: u16, octets: &'static [u8], there: &'static [u8]| {
        move || {
            let mut watch = watch;
            let frame = Frame::data(Id::base(id).unwrap(), octets).unwrap();
            let there = || Numbers::of(there.iter().map(|number| node(*number)));
            // Many times the same.
            let hints = (0..100).filter_map(|_| watch.heard(Instant::from_millis(1), &frame, there));
            hints.map(|hint| hint.to_string()).collect()
        }
    };
    compare(
        "Hints of a CANopen bus",
        vec![
            row(
                "NB-01",
                "SDO requests to node 9, where 5 and 6 are",
                said(NodeWatch::inside(), 0x609, &[0x40, 0, 0x10, 0, 0, 0, 0, 0], &[5, 6]),
            ),
            row("NB-02", "NMT start of node 9", said(NodeWatch::inside(), 0, &[0x01, 9], &[5, 6])),
            row(
                "NB-03",
                "NMT reset of node 9 on a bus without nodes",
                said(NodeWatch::outside(), 0, &[0x81, 9], &[]),
            ),
            row(
                "NB-05",
                "an NMT command with its octets exchanged",
                said(NodeWatch::inside(), 0, &[5, 0x01], &[5]),
            ),
            row(
                "NB-06",
                "a master sends with the identifier of the SDO answers",
                said(NodeWatch::inside(), 0x585, &[0x40, 0, 0x10, 0, 0, 0, 0, 0], &[5]),
            ),
            row(
                "NB-07",
                "process data with the identifier of TPDO1",
                said(NodeWatch::inside(), 0x185, &[6, 0], &[5]),
            ),
            row("NB-04", "an SDO request to node 5 as a frame with an identifier of 29 bits", || {
                let wide =
                    Frame::data(Id::extended(0x605).unwrap(), &[0x40, 0, 0x10, 0, 0, 0, 0, 0]).unwrap();
                let there = || Numbers::of([node(5)]);
                let hint = NodeWatch::inside().heard(Instant::from_millis(1), &wide, there);
                hint.map(|hint| hint.to_string()).into_iter().collect()
            }),
            row("NB-08", "an NMT start of node 200", said(NodeWatch::inside(), 0, &[1, 200], &[5])),
            row(
                "NB-09",
                "an SDO request without a node number in its identifier",
                said(NodeWatch::inside(), 0x600, &[0x40, 0, 0x10, 0, 0, 0, 0, 0], &[5]),
            ),
        ],
    );
}
