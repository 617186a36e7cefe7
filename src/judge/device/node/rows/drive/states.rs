//! The state machine of a drive.

use core::time::Duration;

use super::*;
use crate::judge::requirement::Confidence::U;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Drives of CiA 402",
    rows: &[
        row(
            "N-D01",
            "after a reset of the node: SWITCH ON DISABLED",
            "power-up in SWITCH ON DISABLED: 6041h & 4Fh = 40h (eds E-53)",
            &["N-O01"],
            By::Trial(d01),
        ),
        row(
            "N-D02",
            "shutdown, switch on, enable operation, and back step by step",
            "06h 21h, 07h 23h, 0Fh 27h; and back (eds E-53)",
            &["N-D01"],
            By::Trial(d02),
        ),
        row(
            "N-D03",
            "disable voltage leads to SWITCH ON DISABLED from each state",
            "disable voltage (00h): 40h (eds E-53)",
            &["N-D02"],
            By::Trial(d03),
        ),
        row(
            "N-D04",
            "quick stop leaves OPERATION ENABLED",
            "quick stop (02h): 07h, or 40h by 605Ah (eds E-53)",
            &["N-D03"],
            By::Trial(d04),
        ),
        sure(
            row(
                "N-D09",
                "quick stop leads from READY TO SWITCH ON and SWITCHED ON to SWITCH ON DISABLED",
                "transitions 7 and 10: disable voltage or quick stop; some drives have them by disable voltage alone",
                &["N-D04"],
                By::Trial(d09),
            ),
            U,
        ),
        row(
            "N-D05",
            "in SWITCH ON DISABLED neither switch on nor enable operation does anything",
            "shutdown first (eds E-53)",
            &["N-D03"],
            By::Trial(d05),
        ),
    ],
};

fn d01(tester: &mut Tester) -> Course {
    a_drive(tester)?;
    tester.nmt(&[0x81, tester.node().number()])?;
    tester.boot_up("reset node")?;
    tester.collect(tester.silence())?;
    comes_to(tester, CORE, 0x40, "after a reset of the node")
}

fn d02(tester: &mut Tester) -> Course {
    may_enable(tester)?;
    let steps = enabled(tester).and_then(|()| {
        control(tester, 0x07)?;
        comes_to(tester, STATE, 0x23, "after disable operation")?;
        control(tester, 0x06)?;
        comes_to(tester, STATE, 0x21, "after shutdown")
    });
    // Whether that does anything is another row.
    control(tester, 0x0000)?;
    steps
}

fn d03(tester: &mut Tester) -> Course {
    may_enable(tester)?;
    for words in [&[0x06][..], &[0x06, 0x07], &[0x06, 0x07, 0x0F]] {
        for word in words {
            control(tester, *word)?;
            tester.collect(Duration::from_millis(50))?;
        }
        off(tester)?;
    }
    Ok(())
}

fn d04(tester: &mut Tester) -> Course {
    may_enable(tester)?;
    let steps = enabled(tester).and_then(|()| {
        control(tester, 0x02)?;
        let mut word = 0;
        let left = until(tester, PATIENCE, |tester| {
            word = tester.number(0x6041, 0)?;
            Ok(word & STATE == 0x07 || word & CORE == 0x40)
        })?;
        match left {
            Some(_) => Ok(()),
            None => broken(format!("after quick stop 6041h is {word:04X}h, expected 07h or 40h")),
        }
    });
    over(tester, steps)
}

fn d09(tester: &mut Tester) -> Course {
    may_enable(tester)?;
    for (words, state) in [(&[0x06][..], "READY TO SWITCH ON"), (&[0x06, 0x07], "SWITCHED ON")] {
        for word in words {
            control(tester, *word)?;
            tester.collect(Duration::from_millis(50))?;
        }
        control(tester, 0x02)?;
        let steps = comes_to(tester, CORE, 0x40, &format!("after quick stop in {state}"));
        over(tester, steps)?;
    }
    Ok(())
}

fn d05(tester: &mut Tester) -> Course {
    may_enable(tester)?;
    for word in [0x07, 0x0F, 0x80, 0x00] {
        control(tester, word)?;
        tester.collect(Duration::from_millis(100))?;
        let status = tester.number(0x6041, 0)?;
        if status & CORE != 0x40 {
            off(tester)?;
            return broken(format!("in SWITCH ON DISABLED after 6040h = {word:04X}h 6041h is {status:04X}h"));
        }
    }
    Ok(())
}
