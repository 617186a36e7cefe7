//! SDO requests in any order, eight octets each: one answer each, about what was asked; a refused write changes nothing;
//! what was written is read back.

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::sdo::SdoRequest;
use profidrive::can_bus::canopen::{Node, Policy};
use profidrive::time::Instant;

use super::canopen_device::{HELD, Plain};

const NODE: u8 = 5;

pub(crate) fn check(data: &[u8]) {
    let (requests, _) = data.as_chunks::<8>();
    let mut device = Plain::new(NODE);
    let mut node = Node::new(Policy::CIA_301);
    node.power_on(Instant::ZERO, &mut device);
    while node.poll_transmit().is_some() {}
    for request in requests.iter().take(500) {
        let before = device.ram.clone();
        let answers = ask(&mut node, &mut device, *request);
        let [command, a, b, c, ..] = *request;
        match (SdoRequest::decode(*request), answers.as_slice()) {
            (SdoRequest::Abort(_), answers) => assert!(answers.is_empty(), "an abort was answered"),
            (SdoRequest::Expedited { at, .. }, []) => assert_eq!(at, HELD, "{request:02X?} has no answer"),
            (SdoRequest::DownloadSegment { last, .. }, []) => assert!(last, "{request:02X?} has no answer"),
            (SdoRequest::UploadSegment { toggle }, [[answer, ..]]) => {
                let right = answer & 0xE0 == 0 && (answer & 0x10 != 0) == toggle;
                assert!(right || *answer == 0x80, "{request:02X?} got {answer:02X}");
            }
            (SdoRequest::DownloadSegment { toggle, .. }, [[answer, ..]]) => {
                let taken = 0x20 | u8::from(toggle) << 4;
                assert!(*answer == taken || *answer == 0x80, "{request:02X?} got {answer:02X}");
            }
            (_, [[answer, ra, rb, rc, ..]]) => {
                assert_eq!([*ra, *rb, *rc], [a, b, c], "{request:02X?} got another multiplexer");
                let expected = match command >> 5 {
                    1 => 0x60,
                    2 => 0x40,
                    _ => 0x80,
                };
                assert!(*answer == 0x80 || answer & 0xE0 == expected, "{request:02X?} got {answer:02X}");
            }
            (_, answers) => panic!("{request:02X?} got {} answers", answers.len()),
        }
        if let [[0x80, ..]] = answers.as_slice() {
            assert_eq!(before, device.ram, "a refused request changed something");
        }
        if let (SdoRequest::Expedited { at, octets, len: Some(len) }, [[0x60, ..]]) =
            (SdoRequest::decode(*request), answers.as_slice())
            && let Some(value) = device.ram.get(&at)
        {
            assert_eq!(value[..], octets[..usize::from(len)], "{at} does not hold what was written");
        }
    }
}

fn ask(node: &mut Node, device: &mut Plain, request: [u8; 8]) -> Vec<[u8; 8]> {
    let id = Id::base(0x600 + u16::from(NODE)).unwrap();
    node.handle_frame(Instant::ZERO, &Frame::with(id, request), device);
    let mut answers = Vec::new();
    while let Some(frame) = node.poll_transmit() {
        if frame.id().number() == 0x580 + u32::from(NODE) {
            answers.push(frame.octets().try_into().expect("every answer has eight octets"));
        }
    }
    answers
}
