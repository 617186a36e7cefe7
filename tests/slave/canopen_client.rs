//! The SDO client against a node of ours, with and without faults.

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::sdo::client::{SdoClient, Step};
use profidrive::can_bus::canopen::{Abort, Address, NmtState, NodeId, Policy, nmt};
use profidrive::time::Instant;

use crate::canopen_device::rig::Rig;

#[derive(Debug, PartialEq, Eq)]
enum Outcome {
    Read(Vec<u8>),
    Written,
    Refused(Abort),
}

fn client() -> SdoClient {
    SdoClient::new(NodeId::new(5).unwrap(), Duration::from_millis(300))
}

fn run(rig: &mut Rig, client: &mut SdoClient, mut request: Frame) -> Outcome {
    loop {
        rig.node.handle_frame(rig.now, &request, &mut rig.device);
        let answer = rig.node.poll_transmit().expect("an answer");
        assert_eq!(
            client.handle_frame(rig.now, &Frame::with(Id::base(0x586).unwrap(), [0x60; 8])),
            Step::Wait
        );
        match client.handle_frame(rig.now, &answer) {
            Step::Send(next) => request = next,
            Step::Read(octets) => return Outcome::Read(octets.to_vec()),
            Step::Written => return Outcome::Written,
            Step::Refused(code) => return Outcome::Refused(code),
            step => panic!("{answer} led to {step:?}"),
        }
    }
}

#[test]
fn values_of_every_length_come_back_as_they_were_written() {
    let mut rig = Rig::new(Policy::CIA_301);
    let mut client = client();
    let at = Address::new(0x2001, 0);
    for len in 1..=200 {
        let value: Vec<u8> = (0..len).map(|place| (place * 3) as u8).collect();
        let request = client.write(rig.now, at, &value).unwrap();
        assert_eq!(run(&mut rig, &mut client, request), Outcome::Written);
        assert!(client.is_idle() && client.poll_timeout().is_none());
        let request = client.read(rig.now, at);
        assert_eq!(run(&mut rig, &mut client, request), Outcome::Read(value));
    }
    assert!(client.write(rig.now, at, &[]).is_none());
    assert!(client.write(rig.now, at, &[0; 257]).is_none());
}

#[test]
fn refusals_name_their_code() {
    let mut rig = Rig::new(Policy::CIA_301);
    let mut client = client();
    let request = client.read(rig.now, Address::new(0x9999, 0));
    assert_eq!(run(&mut rig, &mut client, request), Outcome::Refused(Abort::NO_OBJECT));
    let request = client.write(rig.now, Address::new(0x1000, 0), &[0; 9]).unwrap();
    assert_eq!(run(&mut rig, &mut client, request), Outcome::Refused(Abort::READ_ONLY));
}

#[test]
fn silence_ends_with_a_timeout_and_a_late_answer_is_ignored() {
    let mut rig = Rig::new(Policy::CIA_301);
    let mut client = client();
    let request = client.read(rig.now, Address::new(0x1001, 0));
    let due = rig.now.saturating_add(Duration::from_millis(300));
    assert_eq!(client.poll_timeout(), Some(due));
    assert_eq!(client.handle_timeout(rig.now), Step::Wait);
    let Step::Failed { code: Abort::TIMEOUT, tell } = client.handle_timeout(due) else {
        panic!("no timeout")
    };
    assert_eq!(tell.to_string(), "605#80 01 10 00 00 00 04 05");
    rig.node.handle_frame(rig.now, &request, &mut rig.device);
    let late = rig.node.poll_transmit().unwrap();
    assert_eq!(client.handle_frame(due, &late), Step::Wait);
    let request = client.read(due, Address::new(0x1017, 0));
    assert_eq!(client.handle_frame(due, &late), Step::Wait, "about another entry");
    assert_eq!(run(&mut rig, &mut client, request), Outcome::Read(vec![0, 0]));
}

#[test]
fn wrong_toggles_and_lengths_end_the_transfer() {
    let id = Id::base(0x585).unwrap();
    let at = Address::new(0x2000, 0);
    for (segment, expected) in
        [([0x10, 0, 0, 0, 0, 0, 0, 0], Abort::TOGGLE), ([0x0F, 0, 0, 0, 0, 0, 0, 0], Abort::LENGTH)]
    {
        let mut client = client();
        client.read(Instant::ZERO, at);
        let begin = Frame::with(id, [0x41, 0x00, 0x20, 0, 11, 0, 0, 0]);
        assert!(matches!(client.handle_frame(Instant::ZERO, &begin), Step::Send(_)));
        let step = client.handle_frame(Instant::ZERO, &Frame::with(id, segment));
        assert!(matches!(step, Step::Failed { code, .. } if code == expected), "{step:?}");
    }
}

#[test]
fn nmt_commands_as_frames() {
    let frame = nmt::Command::Enter(NmtState::Operational).frame(Some(NodeId::new(5).unwrap()));
    assert_eq!(frame.to_string(), "000#01 05");
    assert_eq!(
        nmt::Command::Reset(profidrive::can_bus::canopen::Reset::Node).frame(None).to_string(),
        "000#81 00"
    );
}
