//! Jobs and replies of the manuals, of the reference, and the mistakes that public texts spread.

use super::*;
use crate::explain::{Context, Sender};

fn words(text: &str) -> Vec<u8> {
    text.split(' ').flat_map(|word| u16::from_str_radix(word, 16).unwrap().to_be_bytes()).collect()
}

fn line(text: &str, sender: Option<Sender>) -> (String, Vec<String>, Mark) {
    let explanation = Context::default().bare(&words(text), sender).unwrap();
    let hints = explanation.hints().into_iter().map(String::from).collect();
    (explanation.line(), hints, explanation.mark())
}

#[test]
fn the_vectors_of_the_reference_read_as_they_are_described_and_tell_their_direction() {
    // `ag03.md` 2.5 and 2.6: job, reply.
    let refused = |name: &str, error: &str| format!("PKW reply: {name} refused: {error}");
    for (job, job_line, reply, reply_line) in [
        (
            "13FA 0000 0000 0000",
            "read PNU 1018 Calibration value",
            "23FA 0000 0000 2710",
            "PKW reply: PNU 1018 Calibration value = 10000 inc or 0.01 mm".into(),
        ),
        (
            "33F8 0000 0003 D090",
            "write PNU 1016 Limit 1 = 250000 inc or 0.01 mm",
            "23F8 0000 0003 D090",
            "PKW reply: PNU 1016 Limit 1 = 250000 inc or 0.01 mm".into(),
        ),
        (
            "13F9 0000 0000 0000",
            "read PNU 1017 Limit 2",
            "23F9 0000 FFF0 BDC0",
            "PKW reply: PNU 1017 Limit 2 = -1000000 inc or 0.01 mm".into(),
        ),
        (
            "33F9 0000 FF67 6981",
            "write PNU 1017 Limit 2 = -9999999 inc or 0.01 mm",
            "23F9 0000 FF67 6981",
            "PKW reply: PNU 1017 Limit 2 = -9999999 inc or 0.01 mm".into(),
        ),
        (
            "33FB 0000 FFFF F9C0",
            "write PNU 1019 Delta inch = -1600 inc or 0.01 mm",
            "23FB 0000 FFFF F9C0",
            "PKW reply: PNU 1019 Delta inch = -1600 inc or 0.01 mm".into(),
        ),
        (
            "23A2 0000 0000 0001",
            "write PNU 930 Operating mode = 1 (velocity mode)",
            "13A2 0000 0000 0001",
            "PKW reply: PNU 930 Operating mode = 1 (velocity mode)".into(),
        ),
        (
            "23EB 0000 0000 0065",
            "write PNU 1003 a-Pos = 101 % of 4 rev/s^2",
            "73EB 0000 0000 0002",
            refused("PNU 1003 a-Pos", "error 2, value outside the limits"),
        ),
        (
            "33E8 0000 0000 0064",
            "write PNU 1000 Controller parameter P = 100",
            "73E8 0000 0000 0005",
            refused("PNU 1000 Controller parameter P", "error 5, wrong data type"),
        ),
        (
            "2396 0000 0000 0005",
            "write PNU 918 Profibus address = 5",
            "7396 0000 0000 0001",
            refused("PNU 918 Profibus address", "error 1, value cannot be changed"),
        ),
        (
            "13E7 0000 0000 0000",
            "read PNU 999 (list of changed parameter numbers in the profile)",
            "73E7 0000 0000 0000",
            refused(
                "PNU 999 (list of changed parameter numbers in the profile)",
                "error 0, no such parameter number",
            ),
        ),
        (
            "63B1 0300 0000 0000",
            "read element 3 of PNU 945 Fault buffer",
            "43B1 0300 0000 0041",
            "PKW reply: element 3 of PNU 945 Fault buffer = fault A (supply voltage too low)".into(),
        ),
        (
            "93B1 0000 0000 0000",
            "read how many elements PNU 945 Fault buffer has",
            "63B1 0000 0000 000A",
            "PKW reply: PNU 945 Fault buffer has 10 elements".into(),
        ),
        (
            "23CA 0000 0000 0005",
            "write PNU 970 Load parameter data record = 5 (calibrate)",
            "13CA 0000 0000 0000",
            "PKW reply: PNU 970 Load parameter data record = 0 (carried out)".into(),
        ),
        (
            "23CA 0000 0000 0005",
            "write PNU 970 Load parameter data record = 5 (calibrate)",
            "23CA 0000 0000 0000",
            "PKW reply: PNU 970 Load parameter data record = 0 (carried out)".into(),
        ),
        (
            "23CA 0000 0000 0005",
            "write PNU 970 Load parameter data record = 5 (calibrate)",
            "73CA 0000 0000 0011",
            refused("PNU 970 Load parameter data record", "error 17, not possible in this operating state"),
        ),
    ] {
        // Nobody says which is which: the words must.
        let mut context = Context::default();
        let asked = context.bare(&words(job), None).unwrap();
        assert_eq!(asked.line(), format!("PKW job: {job_line}"));
        let answered = context.bare(&words(reply), None).unwrap();
        assert_eq!(answered.line(), reply_line);
        assert_eq!(answered.mark() == Mark::Trouble, reply.starts_with('7'), "{reply}");
        // What the drive refuses here is explained beforehand, except what depends on its state.
        let foreseen = asked.mark() == Mark::Mistake;
        assert_eq!(
            foreseen,
            reply.starts_with('7') && !reply.ends_with("0011"),
            "{job}: {:?}",
            asked.hints()
        );
    }
}

#[test]
fn mistakes_that_public_texts_spread_are_explained_as_wrong() {
    for (job, hint) in [
        // The calculator's example: a double word job for a word.
        (
            "33E8 0000 0000 0064",
            "error 5, wrong data type: the parameter is a word, got a double word; use job 2, write word: PKE 23E8",
        ),
        (
            "23F8 0000 0000 0064",
            "the parameter is a double word, got a word; use job 3, write double word: PKE 33F8",
        ),
        // PNU 947 taken for 3BBh.
        ("13BB 0000 0000 0000", "3BBh is 955; some documents write it for PNU 947, which is 3B3h"),
        // "For PNU 1000 to 1999 set bit 11."
        (
            "1BFA 0000 0000 0000",
            "bit 11 is the toggle bit of spontaneous messages (SPM), not part of the number",
        ),
        // Job 7 as "read array".
        ("73B1 0300 0000 0000", "Job 7 writes; to read an element use job 6, read array element: PKE 63B1"),
        // A job of another vendor.
        ("E3E8 0000 0000 0064", "The highest job is 9 here"),
        ("13B1 0000 0000 0000", "use job 6, read array element: PKE 63B1"),
        ("63FA 0100 0000 0000", "the parameter is no array; use job 1, read value: PKE 13FA"),
        ("73E8 0000 0000 0064", "the parameter is no array; use job 2, write word: PKE 23E8"),
        ("83F8 0000 0000 0064", "the parameter is no array; use job 3, write double word: PKE 33F8"),
        ("23EB 0000 0032 0000", "the value is in word 3; a word belongs in word 4"),
        ("23EB 0000 0001 0032", "word 3 is ignored"),
        (
            "63B1 0A00 0000 0000",
            "error 3, wrong sub-index: the array has 10 elements counted from 0, got sub-index 10",
        ),
        ("FA13 0000 0000 0000", "with its octets exchanged PKE is 13FA"),
        (
            "1018 0000 0000 0000",
            "1018 here are decimal digits: PNU 1018 is 3FAh, and reading Calibration value is PKE 13FA",
        ),
        ("1930 0000 0000 0000", "930 here are decimal digits: PNU 930 is 3A2h"),
        (
            "13B3 0000 0000 0000",
            "there is no parameter 947; near it: 945 Fault buffer, 952 Number of faults (in the profile it is 'fault number')",
        ),
        ("43E8 0200 0000 0000", "error 9"),
    ] {
        let (line, hints, mark) = line(job, Some(Sender::Master));
        assert!(hints.iter().any(|said| said.contains(hint)), "{job}: {line}: {hints:#?}");
        assert_eq!(mark, Mark::Mistake, "{job}");
    }
}

#[test]
fn replies_that_no_drive_of_these_gives_are_explained_as_wrong() {
    for (reply, hint) in [
        // Danfoss' example of a spontaneous message.
        ("AC1A 0000 0000 0001", "a manual prints AC1A for a message about PNU 538, which would be AA1A"),
        ("1C08 0000 0000 0001", "a manual prints 1C08 for PNU 520, which would be 1A08"),
        ("93FA 0000 0000 0001", "bit 11 is inverted with each spontaneous message"),
        ("1BE8 0000 0000 0001", "bit 11 (SPM) is set"),
        ("23E8 0000 0000 0001", "PNU 1000 Controller parameter P is a word"),
        ("13FA 0000 0000 0001", "PNU 1018 Calibration value is a double word"),
        ("73E8 0000 0000 0000", "would not answer error 0"),
        ("D3E8 0000 0000 0000", "no drive sends it"),
    ] {
        let (_, hints, mark) = line(reply, Some(Sender::Slave));
        assert!(hints.iter().any(|said| said.contains(hint)), "{reply}: {hints:#?}");
        assert_eq!(mark, Mark::Mistake, "{reply}");
    }
}

#[test]
fn jobs_in_order_have_no_mark() {
    for job in [
        "0000 0000 0000 0000",
        "13FA 0000 0000 0000",
        "63B1 0300 0000 0000",
        "23EC 0000 0000 00C8",
        "23A2 0000 0000 0002",
    ] {
        let (line, hints, mark) = line(job, Some(Sender::Master));
        assert_eq!((mark, hints.len()), (Mark::Plain, 0), "{line}: {hints:?}");
    }
    let (_, hints, mark) = line("63B1 0003 0000 0000", Some(Sender::Master));
    assert!(mark == Mark::Plain && hints[0].contains("low octet of IND"), "{hints:?}");
}

#[test]
fn a_reply_for_another_parameter_than_the_job_is_noticed() {
    let mut context = Context::default();
    context.bare(&words("13FA 0000 0000 0000"), Some(Sender::Master));
    let stale = |context: &mut Context| {
        let said = context.bare(&words("23F8 0000 0003 D090"), Some(Sender::Slave)).unwrap();
        (said.mark(), said.hints().concat())
    };
    let still =
        "still the previous reply; the one to the last job, for PNU 1018 Calibration value, comes later";
    for _ in 0..100 {
        assert_eq!(stale(&mut context), (Mark::Plain, still.into()));
        // The master repeats its job.
        context.bare(&words("13FA 0000 0000 0000"), Some(Sender::Master));
    }
    let lasts = "101 replies since the last job, which was for PNU 1018 Calibration value, and none to it";
    assert_eq!(stale(&mut context), (Mark::Trouble, lasts.into()));
    // Another job begins anew, and the reply to it is none of this.
    context.bare(&words("13F9 0000 0000 0000"), Some(Sender::Master));
    assert_eq!(stale(&mut context).0, Mark::Plain);
    let answer = context.bare(&words("23F9 0000 0003 D090"), Some(Sender::Slave)).unwrap();
    assert_eq!(answer.hints(), [""; 0]);
}

#[test]
fn the_spindle_pitch_and_the_operating_mode_heard_give_unit_and_bits() {
    let mut context = Context::default();
    let limit = |context: &mut Context| context.bare(&words("23F8 0000 0003 D090"), None).unwrap().line();
    assert!(limit(&mut context).ends_with("250000 inc or 0.01 mm"));
    context.bare(&words("13F4 0000 0000 00C8"), None);
    assert!(limit(&mut context).ends_with("= 2500.00 mm"));
    context.bare(&words("13F4 0000 0000 0000"), Some(Sender::Slave));
    assert!(limit(&mut context).ends_with("= 250000 inc"));

    let control = |context: &mut Context| context.bare(&words("004B 0000 0048"), None).unwrap().line();
    assert_eq!(control(&mut context), "PZD: STW 004B (ON, no OFF2, enable operation); setpoint 72");
    context.bare(&words("13A2 0000 0000 0001"), None);
    let line = control(&mut context);
    assert_eq!(line, "PZD: STW 004B (ON, no OFF2, enable operation, setpoint released); setpoint 72");
}

#[test]
fn the_status_words_among_the_parameters_are_shown_bit_by_bit() {
    let explanation = Context::default().bare(&words("13FC 0000 0000 2948"), None).unwrap();
    let mut names = Vec::new();
    explanation.walk(&mut |_, field| {
        if field.bits.is_some() && field.raw == "1" {
            names.push(field.name.clone());
        }
    });
    assert_eq!(names, ["motor current", "ready to travel", "fault", "lower limit", "in position"]);
}
