//! The SDO server, octet for octet (`canopen-link.md` 5, 13 and 14).

use profidrive::canopen::{Abort, Policy, Request};

use crate::canopen_device::rig::Rig;

fn abort(at: [u8; 3], code: Abort) -> [u8; 8] {
    let [d, e, f, g] = code.code().to_le_bytes();
    [0x80, at[0], at[1], at[2], d, e, f, g]
}

#[test]
fn the_golden_frames() {
    let mut rig = Rig::new(Policy::CIA_301);
    let frames: &[([u8; 8], [u8; 8])] = &[
        ([0x40, 0x00, 0x10, 0, 0, 0, 0, 0], [0x43, 0x00, 0x10, 0, 0x91, 0x01, 0x0F, 0x00]),
        ([0x40, 0x01, 0x10, 0, 0, 0, 0, 0], [0x4F, 0x01, 0x10, 0, 0, 0, 0, 0]),
        ([0x40, 0x99, 0x99, 0, 0, 0, 0, 0], [0x80, 0x99, 0x99, 0, 0, 0, 0x02, 0x06]),
        ([0x2F, 0x00, 0x10, 0, 0, 0, 0, 0], [0x80, 0x00, 0x10, 0, 0x02, 0, 0x01, 0x06]),
        ([0xE0, 0x00, 0x10, 0, 0, 0, 0, 0], [0x80, 0x00, 0x10, 0, 0x01, 0, 0x04, 0x05]),
        // Segmented upload of "Hello World".
        ([0x40, 0x00, 0x20, 0, 0, 0, 0, 0], [0x41, 0x00, 0x20, 0, 0x0B, 0, 0, 0]),
        ([0x60, 0, 0, 0, 0, 0, 0, 0], [0x00, 0x48, 0x65, 0x6C, 0x6C, 0x6F, 0x20, 0x57]),
        ([0x70, 0, 0, 0, 0, 0, 0, 0], [0x17, 0x6F, 0x72, 0x6C, 0x64, 0, 0, 0]),
        // Segmented download of the same.
        ([0x21, 0x00, 0x20, 0, 0x0B, 0, 0, 0], [0x60, 0x00, 0x20, 0, 0, 0, 0, 0]),
        ([0x00, 0x48, 0x65, 0x6C, 0x6C, 0x6F, 0x20, 0x57], [0x20, 0, 0, 0, 0, 0, 0, 0]),
        ([0x17, 0x6F, 0x72, 0x6C, 0x64, 0, 0, 0], [0x30, 0, 0, 0, 0, 0, 0, 0]),
        // Wrong toggle.
        ([0x40, 0x00, 0x20, 0, 0, 0, 0, 0], [0x41, 0x00, 0x20, 0, 0x0B, 0, 0, 0]),
        ([0x60, 0, 0, 0, 0, 0, 0, 0], [0x00, 0x48, 0x65, 0x6C, 0x6C, 0x6F, 0x20, 0x57]),
        ([0x60, 0, 0, 0, 0, 0, 0, 0], [0x80, 0x00, 0x20, 0, 0, 0, 0x03, 0x05]),
    ];
    for &(request, expected) in frames {
        assert_eq!(rig.sdo(request), expected, "{request:02X?}");
    }
}

#[test]
fn a_held_answer_comes_when_the_device_gives_it_and_a_new_request_drops_it() {
    let mut rig = Rig::new(Policy::CIA_301);
    let request = [0x2F, 0x0E, 0x20, 0, 9, 0, 0, 0];
    assert!(rig.sdo_frames(request).is_empty());
    rig.device.requests.push_back(Request::AnswerSdo(Ok(())));
    assert_eq!(rig.change(), ["585#60 0E 20 00 00 00 00 00"]);
    rig.device.requests.push_back(Request::AnswerSdo(Ok(())));
    assert!(rig.change().is_empty(), "answered once");

    assert!(rig.sdo_frames(request).is_empty());
    rig.device.requests.push_back(Request::AnswerSdo(Err(Abort::HARDWARE)));
    assert_eq!(rig.change(), ["585#80 0E 20 00 00 00 06 06"]);

    assert!(rig.sdo_frames(request).is_empty());
    assert_eq!(rig.read(0x1001, 0), Ok(0));
    rig.device.requests.push_back(Request::AnswerSdo(Ok(())));
    assert!(rig.change().is_empty(), "the client has given up");
    let _ = abort;
}
