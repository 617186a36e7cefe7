//! What a node keeps (`canopen-link.md` 7; page `docs/canopen-conformance.md`).

use profidrive::can_bus::canopen::node::storage::{Eeprom, ImageError, NotStored};
use profidrive::can_bus::canopen::policy::{LoadRule, Storing};
use profidrive::can_bus::canopen::{Abort, Emergency, Node, NodeId, Policy, Request};

use crate::canopen_device::Plain;
use crate::canopen_device::rig::Rig;

const SAVE: u32 = 0x6576_6173;
const LOAD: u32 = 0x6461_6F6C;

fn host(policy: Policy) -> Rig {
    let mut rig = Rig::off(policy, Plain::new(5));
    rig.node = Node::new(policy).with_memory(Eeprom::Host);
    rig.power_on();
    rig
}

fn image(rig: &mut Rig) -> Option<(profidrive::can_bus::canopen::node::storage::Generation, Vec<u8>)> {
    let mut room = [0; 2000];
    let request = rig.node.poll_image(&rig.device, &mut room).unwrap()?;
    Some((request.generation, request.octets.to_vec()))
}

/// Another unit of the same kind that starts with this image.
fn restarted(policy: Policy, image: &[u8]) -> Rig {
    let mut rig = Rig::off(policy, Plain::new(5));
    rig.node.recall(rig.now, image, &mut rig.device).unwrap();
    rig.power_on();
    rig
}

#[test]
fn r_01_what_is_saved_survives_a_restart_and_nothing_else_does() {
    for (group, communication, application) in
        [(None, 0, 1000), (Some(1), 100, 2000), (Some(2), 100, 1000), (Some(3), 0, 2000)]
    {
        let mut rig = Rig::new(Policy::CIA_301);
        rig.write(0x1017, 0, 100, 2).unwrap();
        rig.write(0x200A, 0, 2000, 2).unwrap();
        rig.write(0x2008, 0, 5, 4).unwrap();
        if let Some(group) = group {
            rig.write(0x1010, group, SAVE, 4).unwrap();
        }
        let mut octets = [0; 2000];
        let len = rig.node.image(&rig.device, &mut octets).unwrap();
        rig.data(0x000, &[0x81, 5]);
        let mut again = restarted(Policy::CIA_301, &octets[..len]);
        for rig in [&mut rig, &mut again] {
            assert_eq!(rig.read(0x1017, 0), Ok(communication), "{group:?}");
            assert_eq!(rig.read(0x200A, 0), Ok(application), "{group:?}");
            assert_eq!(rig.read(0x2008, 0), Ok((-70_000_i32).cast_unsigned()), "never stored");
        }
    }
}

#[test]
fn r_01_a_device_that_stores_with_every_write() {
    let policy = Policy { storing: Storing::OnWrite, ..Policy::CIA_301 };
    let mut rig = Rig::new(policy);
    rig.write(0x1017, 0, 100, 2).unwrap();
    rig.data(0x000, &[0x81, 5]);
    assert_eq!(rig.read(0x1017, 0), Ok(100));
}

#[test]
fn r_02_load_brings_the_defaults_with_the_next_restart() {
    for (load, later) in [(LoadRule::Erase, 0), (LoadRule::OnceAfterReset, 100)] {
        let mut rig = Rig::new(Policy { load, ..Policy::CIA_301 });
        rig.write(0x1017, 0, 100, 2).unwrap();
        rig.write(0x200A, 0, 2000, 2).unwrap();
        rig.write(0x1010, 1, SAVE, 4).unwrap();
        rig.write(0x1011, 1, LOAD, 4).unwrap();
        assert_eq!(rig.read(0x1017, 0), Ok(100), "not before");
        rig.data(0x000, &[0x81, 5]);
        assert_eq!(rig.read(0x1017, 0), Ok(0));
        assert_eq!(rig.read(0x200A, 0), Ok(1000));
        rig.data(0x000, &[0x81, 5]);
        assert_eq!(rig.read(0x1017, 0), Ok(later), "{load:?}");
    }
}

#[test]
fn r_03_a_wrong_signature_stores_nothing() {
    for wrong_signature in [Abort::TRANSFER, Abort::RANGE] {
        let mut rig = Rig::new(Policy { wrong_signature, ..Policy::CIA_301 });
        rig.write(0x1017, 0, 100, 2).unwrap();
        for (index, value) in [(0x1010, 0), (0x1010, LOAD), (0x1010, SAVE + 1), (0x1011, 0), (0x1011, SAVE)] {
            assert_eq!(rig.write(index, 1, value, 4), Err(wrong_signature.code()));
        }
        assert_eq!(rig.read(0x1010, 1), Ok(1));
        rig.data(0x000, &[0x81, 5]);
        assert_eq!(rig.read(0x1017, 0), Ok(0));
    }
    let mut rig = Rig::new(Policy::CIA_301);
    rig.device.store_fault = Some(Abort::HARDWARE);
    rig.write(0x1017, 0, 100, 2).unwrap();
    assert_eq!(rig.write(0x1010, 1, SAVE, 4), Err(Abort::HARDWARE.code()));
    rig.data(0x000, &[0x81, 5]);
    assert_eq!(rig.read(0x1017, 0), Ok(0), "the device refused, so nothing is stored");
}

#[test]
fn r_04_device_type_and_identity() {
    let mut rig = Rig::new(Policy::CIA_301);
    assert_eq!(rig.read(0x1000, 0), Ok(0x000F_0191));
    let identity: Vec<_> = (0..=4).map(|sub| rig.read(0x1018, sub)).collect();
    assert_eq!(identity, [Ok(4), Ok(0), Ok(0x401), Ok(0x0001_0002), Ok(4711)]);
}

#[test]
fn save_is_answered_only_when_the_host_keeps_the_image() {
    let mut rig = host(Policy::CIA_301);
    assert!(image(&mut rig).is_none());
    rig.write(0x1017, 0, 100, 2).unwrap();
    assert!(image(&mut rig).is_none(), "nothing is stored yet");
    let save = [0x23, 0x10, 0x10, 1, 0x73, 0x61, 0x76, 0x65];
    assert!(rig.sdo_frames(save).is_empty());
    let (generation, octets) = image(&mut rig).expect("an image is offered");
    assert!(image(&mut rig).is_none(), "once");
    assert!(rig.change().is_empty());
    rig.node.handle_stored(rig.now, generation, Ok(()), &mut rig.device);
    assert_eq!(rig.drain(), ["585#60 10 10 01 00 00 00 00"]);
    let mut again = restarted(Policy::CIA_301, &octets);
    assert_eq!(again.read(0x1017, 0), Ok(100), "what was acknowledged is in the image");
}

#[test]
fn what_the_host_could_not_keep_is_refused_and_is_not_kept() {
    let mut rig = host(Policy::CIA_301);
    rig.write(0x1017, 0, 100, 2).unwrap();
    assert!(rig.sdo_frames([0x23, 0x10, 0x10, 2, 0x73, 0x61, 0x76, 0x65]).is_empty());
    let (generation, _) = image(&mut rig).unwrap();
    rig.node.handle_stored(rig.now, generation, Err(NotStored), &mut rig.device);
    assert_eq!(rig.drain(), ["585#80 10 10 02 00 00 06 06"]);
    rig.data(0x000, &[0x81, 5]);
    assert_eq!(rig.read(0x1017, 0), Ok(0));
}

#[test]
fn a_write_that_stores_itself_waits_for_the_image_and_for_the_device() {
    let mut rig = host(Policy { storing: Storing::OnWrite, ..Policy::CIA_301 });
    assert!(rig.sdo_frames([0x2B, 0x0A, 0x20, 0, 0xD0, 0x07, 0, 0]).is_empty(), "of the device");
    let (generation, _) = image(&mut rig).unwrap();
    rig.node.handle_stored(rig.now, generation, Ok(()), &mut rig.device);
    assert_eq!(rig.drain(), ["585#60 0A 20 00 00 00 00 00"]);
    assert!(rig.sdo_frames([0x2B, 0x17, 0x10, 0, 100, 0, 0, 0]).is_empty(), "of the node");
    rig.node.handle_stored(rig.now, generation, Ok(()), &mut rig.device);
    assert!(rig.drain().is_empty(), "an older image does not count");
    let (generation, _) = image(&mut rig).unwrap();
    rig.node.handle_stored(rig.now, generation, Ok(()), &mut rig.device);
    assert_eq!(rig.drain(), ["585#60 17 10 00 00 00 00 00"]);
    // A write of an object that is not stored is answered at once.
    rig.write(0x2008, 0, 5, 4).unwrap();
    assert!(image(&mut rig).is_none());
}

#[test]
fn the_history_is_kept_and_a_fault_offers_an_image() {
    let mut rig = host(Policy::CIA_301);
    for code in [0x2310, 0x4310] {
        rig.device.requests.push_back(Request::Emergency(Emergency::new(code, 1)));
    }
    rig.change();
    let (_, octets) = image(&mut rig).expect("the history changed");
    let mut again = restarted(Policy::CIA_301, &octets);
    assert_eq!(again.read(0x1003, 0), Ok(2));
    assert_eq!(again.read(0x1003, 1), Ok(0x4310));
    assert_eq!(again.read(0x1003, 2), Ok(0x2310));
}

#[test]
fn cob_ids_that_were_defaults_follow_the_node_number_and_others_stay() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x1801, 1, 0x8000_0285, 4).unwrap();
    rig.write(0x1801, 1, 0x333, 4).unwrap();
    rig.write(0x1010, 1, SAVE, 4).unwrap();
    rig.device.node_id = NodeId::new(9).unwrap();
    rig.data(0x000, &[0x81, 5]);
    assert_eq!(rig.read(0x1800, 1), Ok(0x189));
    assert_eq!(rig.read(0x1801, 1), Ok(0x333));
}

#[test]
fn damaged_images_are_refused_and_change_nothing() {
    let mut rig = Rig::new(Policy::CIA_301);
    rig.write(0x1017, 0, 100, 2).unwrap();
    rig.write(0x1010, 1, SAVE, 4).unwrap();
    let mut octets = [0; 2000];
    let len = rig.node.image(&rig.device, &mut octets).unwrap();
    let image = &octets[..len];
    for cut in 0..len {
        assert!(rig.node.recall(rig.now, &image[..cut], &mut rig.device).is_err(), "{cut} octets");
    }
    for bit in 0..len * 8 {
        let mut damaged = image.to_vec();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(rig.node.recall(rig.now, &damaged, &mut rig.device).is_err(), "bit {bit}");
    }
    for room in [0, 10, len - 1] {
        let mut short = vec![0; room];
        assert_eq!(rig.node.image(&rig.device, &mut short), Err(ImageError::NoRoom { got: room }));
    }
}
