//! Control and status words, alone and in a PPO.

use super::*;
use crate::explain::Context;

fn words(text: &str) -> Vec<u8> {
    text.split(' ').flat_map(|word| u16::from_str_radix(word, 16).unwrap().to_be_bytes()).collect()
}

fn explain(text: &str, mode: Mode) -> Explanation {
    Context::with_mode(mode).bare(&words(text), None).unwrap()
}

#[test]
fn the_process_data_of_the_reference_read_as_they_are_described() {
    // `ag03.md` 2.6, the three PZD rows, and words of 5.
    for (text, mode, line) in [
        ("000B 0000 1388", Mode::Positioning, "PZD: STW 000B (ON, no OFF2, enable operation); setpoint 5000"),
        (
            "007B FFFF EC78",
            Mode::Positioning,
            "PZD: STW 007B (ON, no OFF2, enable operation, no stop, no intermediate stop); setpoint -5000",
        ),
        (
            "004B FFFF FFB8",
            Mode::Velocity,
            "PZD: STW 004B (ON, no OFF2, enable operation, setpoint released); setpoint -72",
        ),
        ("2B23", Mode::Positioning, "ZSW 2B23 (ready to turn on, stands still)"),
        ("AB37", Mode::Positioning, "ZSW AB37 (enabled, ready to travel)"),
        ("1E37", Mode::Velocity, "ZSW 1E37 (enabled)"),
        (
            "820B",
            Mode::Positioning,
            "STW 820B (ON, no OFF2, enable operation, inching 2, negative direction)",
        ),
        (
            "13FA 0000 0000 0000 000B 0000 1388",
            Mode::Positioning,
            "PPO outputs: read PNU 1018 Calibration value; STW 000B (ON, no OFF2, enable operation); setpoint 5000",
        ),
        (
            "23FA 0000 0000 2710 AB37 0000 002A",
            Mode::Positioning,
            "PPO inputs: PNU 1018 Calibration value = 10000 inc or 0.01 mm; ZSW AB37 (enabled, ready to travel); actual value 42",
        ),
    ] {
        let explanation = explain(text, mode);
        assert_eq!(explanation.line(), line);
        crate::explain::frame::tests::check_cover(&explanation.fields, 0, words(text).len());
    }
}

#[test]
fn every_printed_word_of_the_flow_charts_tells_its_direction() {
    for stw in [0x0000_u16, 0x000B, 0x003B, 0x007B, 0x010B, 0x020B, 0x820B, 0x004B] {
        let explanation = Context::default().bare(&stw.to_be_bytes(), None).unwrap();
        assert_eq!(
            (explanation.sender, explanation.mark()),
            (Some(Sender::Master), Mark::Plain),
            "{stw:04X}"
        );
    }
    for zsw in [0x2B23_u16, 0x2B37, 0x0A37, 0xAB37, 0x3E23, 0x3E37, 0xBE37, 0x1E37] {
        let explanation = Context::default().bare(&zsw.to_be_bytes(), None).unwrap();
        assert_eq!((explanation.sender, explanation.mark()), (Some(Sender::Slave), Mark::Plain), "{zsw:04X}");
    }
}

#[test]
fn control_words_of_other_drives_are_commented() {
    for (text, mode, mark, hint) in [
        ("047F", Mode::Positioning, Mark::Plain, "bit 2 (OFF3) is not implemented and must be 0"),
        ("047E", Mode::Positioning, Mark::Plain, "bit 10, control by PLC, is not needed"),
        ("0B00", Mode::Positioning, Mark::Mistake, "with its octets exchanged it is 000B"),
        ("030B", Mode::Positioning, Mark::Mistake, "inching 1 and inching 2 exclude each other"),
        ("010B", Mode::Velocity, Mark::Plain, "inching needs the positioning mode"),
        ("004B 0000 00C9", Mode::Velocity, Mark::Mistake, "no gear turns faster than 200 rpm"),
    ] {
        let explanation = Context::with_mode(mode).bare(&words(text), Some(Sender::Master)).unwrap();
        assert!(
            explanation.hints().iter().any(|said| said.contains(hint)),
            "{text}: {:?}",
            explanation.hints()
        );
        assert_eq!(explanation.mark(), mark, "{text}");
    }
}

#[test]
fn a_status_word_with_a_fault_is_trouble_and_one_without_its_fixed_bits_none() {
    let of = |zsw: u16| Context::default().bare(&zsw.to_be_bytes(), Some(Sender::Slave)).unwrap().mark();
    assert_eq!(of(0x2B2B), Mark::Trouble);
    assert_eq!(of(0x2B63), Mark::Trouble);
    assert_eq!(of(0x237B), Mark::Mistake);
    assert_eq!(of(0x0000), Mark::Plain, "before the first cycle");
}

#[test]
fn other_lengths_are_not_taken() {
    for len in (0..40).filter(|len| ![2, 6, 8, 14].contains(len)) {
        assert_eq!(Context::default().bare(&vec![0xA5; len], None), None);
    }
}
