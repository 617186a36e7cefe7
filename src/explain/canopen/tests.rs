use std::collections::BTreeSet;

use proptest::prelude::*;

use super::*;
use crate::can_bus::can::Frame;
use crate::devices::ag03;
use crate::devices::ap10;
use crate::devices::asda_a2;

/// Lines, with the highest mark of each in front.
fn told(network: &mut Network, lines: &[&str]) -> Vec<String> {
    let explain = |line: &&str| {
        let said = network.frame(&frame_in(line).unwrap().unwrap());
        check(&said);
        let mark = match said.mark() {
            Mark::Plain => "",
            Mark::Trouble => "! ",
            Mark::Mistake => "X ",
            Mark::Invalid => "# ",
        };
        format!("{mark}{}", said.line())
    };
    lines.iter().map(explain).collect()
}

fn ag03() -> Network {
    Network::of(&ag03::canopen::VOCABULARY)
}

/// Fields lie beside each other and leave no octet out, of a word no bit.
fn check(said: &Explanation) {
    fn cover(fields: &[Field], at: usize, len: usize) {
        let mut next = at;
        let mut lowest = None;
        for field in fields {
            match field.bits {
                Some(bits) => {
                    assert_eq!(lowest.unwrap_or(len * 8), usize::from(bits.high) + 1, "{field:?}");
                    lowest = Some(usize::from(bits.low));
                }
                None => {
                    assert_eq!(field.at, next, "{field:?}");
                    next += field.len;
                }
            }
            if !field.fields.is_empty() {
                cover(&field.fields, field.at, field.len);
            }
        }
        match lowest {
            Some(lowest) => assert_eq!(lowest, 0),
            None => assert_eq!(next, at + len),
        }
    }
    cover(&said.fields, 0, said.octets.len());
    assert!(!said.summary.contains('\n'));
    assert!(std::string::ToString::to_string(said).len() < 8000);
}

#[test]
fn the_start_up_of_an_ag03_1_in_words() {
    let lines = [
        "705#00",
        "605#4000100000000000",
        "585#4300100092010000",
        "605#2F10240500000000",
        "585#8010240530000906",
        "605#2F1024053C000000",
        "585#6010240500000000",
        "605#4010240500000000",
        "585#4F1024053C000000",
        "000#0105",
        "705#05",
        "185#7002",
        "205#0600",
        "405#0600401F0000",
        "385#3702401F0000",
        "085#2171210000000000",
        "085#0000000000000000",
        "080#",
        "705#R1",
        "705#85",
        "605#8000100000000008",
    ];
    let expected = [
        "705  boot-up of 5",
        "605  SDO to 5: read 1000h:00 Device type",
        "585  SDO from 5: 1000h:00 Device type = 00000192h",
        "X 605  SDO to 5: write 2410h:05 Controller parameters: v-Pos rpm = 0 rpm",
        "! 585  SDO from 5: write refused, 2410h:05 Controller parameters: v-Pos rpm: value range of the parameter exceeded (06090030h)",
        "605  SDO to 5: write 2410h:05 Controller parameters: v-Pos rpm = 60 rpm",
        "585  SDO from 5: 2410h:05 Controller parameters: v-Pos rpm written",
        "605  SDO to 5: read 2410h:05 Controller parameters: v-Pos rpm",
        "585  SDO from 5: 2410h:05 Controller parameters: v-Pos rpm = 60 rpm",
        "000  NMT to node 5: start: to OPERATIONAL",
        "705  heartbeat or guarding answer of 5: OPERATIONAL",
        "185  TPDO 1 of 5: 6041h:00 Statusword = 0270h, switch on disabled, voltage enabled, remote",
        "205  RPDO 1 to 5: 6040h:00 Controlword = 0006h, shutdown",
        "405  RPDO 3 to 5: 6040h:00 Controlword = 0006h, shutdown; 607Ah:00 Target position = 8000 inc or 0.01 mm",
        "385  TPDO 3 of 5: 6041h:00 Statusword = 0237h, operation enabled, voltage enabled, remote; 6064h:00 Position actual value = 8000 inc or 0.01 mm",
        "! 085  EMCY of 5: 7121h, shaft blocked (fault B); error register 21h, generic error, shaft blocked",
        "085  EMCY of 5: 0000h, no error; error register 00h, no error",
        "080  SYNC",
        "705  guarding request to 5",
        "705  guarding answer of 5: OPERATIONAL",
        "! 605  SDO to 5: the client aborts: general error (08000000h)",
    ];
    assert_eq!(told(&mut ag03(), &lines), expected);
}

#[test]
fn without_a_device_only_cia_301_and_402_are_used() {
    let lines = [
        "605#4010240500000000",
        "605#2F60600003000000",
        "205#0F00",
        "205#0F0000",
        "285#0102",
        "185#3702",
        "085#1023010000000000",
        "085#30FF810000000000",
        "123#00",
        "705#FE",
        "605#AA",
    ];
    let expected = [
        "605  SDO to 5: read 2410h:05",
        "605  SDO to 5: write 6060h:00 Modes of operation = 3 (profile velocity)",
        "205  RPDO 1 to 5: 6040h:00 Controlword = 000Fh, enable operation",
        "205  RPDO 1 to 5: 3 octets, mapping not known",
        "285  TPDO 2 of 5: 2 octets, mapping not known",
        "185  TPDO 1 of 5: 6041h:00 Statusword = 0237h, operation enabled, voltage enabled, remote",
        "! 085  EMCY of 5: 2310h, current; error register 01h, generic error",
        "! 085  EMCY of 5: FF30h, of the device; error register 81h, generic error, manufacturer",
        "123  no service of CiA 301 has this identifier",
        "# 705  guarding answer of 5: unknown state",
        "X 605  SDO to 5: not valid",
    ];
    assert_eq!(told(&mut Network::default(), &lines), expected);
}

#[test]
fn identifiers_and_mappings_are_learned_from_the_answers_to_sdo() {
    let mut network = Network::of(&asda_a2::canopen::VOCABULARY);
    let lines = [
        // The mapping of RPDO 1: 6040h and 607Ah; the identifier 210h; the second write is refused.
        "605#2F00160002000000",
        "585#6000160000000000",
        "605#2300160110004060",
        "585#6000160100000000",
        "605#2300160220007A60",
        "585#6000160200000000",
        "605#2300140110020000",
        "585#6000140100000000",
        "605#2300180111020000",
        "585#8000180122000008",
        "605#2F60600001000000",
        "585#6060600000000000",
        "210#1F00E8030000",
        "205#1F00",
        "185#",
        "211#00",
    ];
    let said = told(&mut network, &lines);
    let expected = [
        "210  RPDO 1 to 5: 6040h:00 Controlword = 001Fh, enable operation, new set-point; 607Ah:00 Target position = 1000",
        "205  no service of CiA 301 has this identifier",
        "185  TPDO 1 of 5: 0 octets, mapping not known",
        "211  RPDO 1 to 17: 1 octet, mapping not known",
    ];
    assert_eq!(said[12..], expected);
    assert_eq!(
        said[4],
        "605  SDO to 5: write 1600h:02 RPDO 1 mapping parameter: Mapping entry = 607Ah:00 Target position, 32 bits"
    );
    assert_eq!(said[6], "605  SDO to 5: write 1400h:01 RPDO 1 communication parameter: COB-ID = 210h");
    // A reset brings back what the memory has.
    assert_eq!(
        told(&mut network, &["000#8205", "205#1F00"])[1],
        "205  RPDO 1 to 5: 2 octets, mapping not known"
    );
}

#[test]
fn a_tpdo_that_another_node_listens_to_stays_that_of_its_sender() {
    let lines = ["606#2300140185010000", "586#6000140100000000", "185#7002", "206#0600"];
    let said = told(&mut ag03(), &lines);
    assert!(said[2].starts_with("185  TPDO 1 of 5: "), "{said:?}");
    assert_eq!(said[3], "206  no service of CiA 301 has this identifier");
}

#[test]
fn a_transfer_in_segments_is_put_together() {
    let lines = [
        "605#4008100000000000",
        "585#4108100006000000",
        "605#6000000000000000",
        "585#0341534441413200",
        "605#7000000000000000",
    ];
    let mut network = Network::of(&ap10::canopen::VOCABULARY);
    let said = told(&mut network, &lines);
    assert_eq!(said[1], "585  SDO from 5: 1008h:00 Manufacturer device name comes in segments, 6 octets");
    assert_eq!(said[2], "605  SDO to 5: read the next segment of 1008h:00 Manufacturer device name");
    assert_eq!(said[3], "585  SDO from 5: 1008h:00 Manufacturer device name = \"ASDAA2\"");
    assert_eq!(said[4], "X 605  SDO to 5: read the next segment", "there is none");
}

#[test]
fn mistakes_say_what_is_wrong() {
    for (lines, hint) in [
        (&["000#01"][..], "an NMT command is a data frame of 2 octets"),
        (&["000#0305"], "01h, 02h, 80h, 81h and 82h are commands"),
        (&["000#0180"], "nodes have the numbers 1 to 127"),
        (&["605#40001000"], "an SDO frame has 8 octets"),
        (&["605#R8"], "a remote request of an SDO identifier is ignored"),
        (&["605#4000200000000000"], "refuses: object does not exist in the object dictionary (06020000h)"),
        (&["605#4010240700000000"], "refuses: sub-index does not exist (06090011h)"),
        (&["605#4011100100000000"], "refuses: attempt to read a write-only object (06010001h)"),
        (&["605#2B41600000000000"], "refuses: attempt to write a read-only object (06010002h)"),
        (&["605#2B10240500000000"], "v-Pos rpm is an UNSIGNED8 of 1 octet, got 2 octets"),
        (&["605#C000100000000000"], "block transfer is optional"),
        (&["605#E000100000000000"], "no command of CiA 301"),
        (&["605#0000000000000000"], "no write in segments is under way"),
        (&["705#7F", "205#0600"], "last seen in PRE-OPERATIONAL"),
        (&["705#04", "605#4000100000000000"], "STOPPED: it answers no SDO"),
        (&["405#0600"], "it has 2 octets, the mapping 6: the node ignores it"),
        (&["405#R6"], "an RPDO is received: no node answers"),
        (&["185#7002", "205#0F00"], "send shutdown (0006h) first"),
        (&["185#3102", "205#0F00"], "send switch on (0007h) first"),
        (&["085#00"], "an emergency has 8 octets"),
        (&["705#0505"], "error control has 1 octet"),
        (&["080#R0"], "a remote request of SYNC is ignored"),
    ] {
        let mut network = ag03();
        let last = lines.iter().map(|line| network.frame(&frame_in(line).unwrap().unwrap())).last().unwrap();
        assert_eq!(last.mark(), Mark::Mistake, "{lines:?}");
        assert!(last.hints().iter().any(|said| said.contains(hint)), "{lines:?}: {:?}", last.hints());
    }
}

#[test]
fn words_of_other_devices() {
    let mut network = Network::default();
    network.know(NodeId::new(3).unwrap(), &ap10::canopen::VOCABULARY);
    network.know(NodeId::new(4).unwrap(), &asda_a2::canopen::VOCABULARY);
    let said = told(&mut network, &["183#E803000000002400", "084#0573201100000000", "084#1023020100000000"]);
    assert_eq!(
        said[0],
        "183  TPDO 1 of 3: 6004h:00 Position value = 1000; 5F1Dh:00 Dummy = 0; 5F19h:00 Status word = 0024h, set point 1 valid, in target window 1"
    );
    assert_eq!(said[1], "! 084  EMCY of 4: 7305h, encoder error; error register 20h, device profile");
    assert_eq!(said[2], "! 084  EMCY of 4: 2310h, overcurrent; error register 02h, current");
}

#[test]
fn a_tree_shows_every_bit() {
    let mut network = ag03();
    let said = network.frame(&frame_in("185#3702").unwrap().unwrap());
    let text = std::string::ToString::to_string(&said);
    for row in ["b15  ", "  b12  ", "setpoint acknowledged", "voltage enabled", "ready to travel", "37 02"] {
        assert!(text.contains(row), "{row}: {text}");
    }
}

#[test]
fn an_error_frame_is_trouble() {
    let said = Network::error_frame("bit error");
    assert_eq!((said.mark(), said.line()), (Mark::Trouble, "error frame: bit error".into()));
    let said = Network::no_frame(&[0x11, 0x22], "a frame of CAN FD");
    assert_eq!((said.mark(), said.line()), (Mark::Invalid, "invalid: a frame of CAN FD".into()));
    assert_eq!((said.fields[0].at, said.fields[0].len, said.fields[0].raw.as_str()), (0, 2, "11 22"));
}

proptest! {
    #[test]
    fn any_frames_are_explained_and_take_bounded_memory(
        frames in proptest::collection::vec((any::<bool>(), any::<bool>(), 0_u16..0x800, proptest::collection::vec(any::<u8>(), 0..=8)), 0..60),
        device in 0..4,
    ) {
        let mut network = match device {
            0 => Network::default(),
            1 => ag03(),
            2 => Network::of(&ap10::canopen::VOCABULARY),
            _ => Network::of(&asda_a2::canopen::VOCABULARY),
        };
        let mut nodes = BTreeSet::new();
        for (extended, remote, number, octets) in frames {
            let id = if extended { Id::extended(number.into()) } else { Id::base(number) }.unwrap();
            let frame = if remote { Frame::remote(id, octets.len().try_into().unwrap()) } else { Frame::data(id, &octets) };
            let said = network.frame(&frame.unwrap());
            check(&said);
            nodes.insert(number & 0x7F);
        }
        prop_assert!(network.nodes.len() <= nodes.len());
    }
}
