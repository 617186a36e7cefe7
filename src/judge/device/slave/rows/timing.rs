//! Times of replies.

use super::{row, softer};
use crate::judge::device::course::{Course, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::wire::Sight;
use crate::judge::requirement::Confidence::{B, C};

pub(super) const GROUP: Group<Tester> = Group {
    title: "Times",
    rows: &[
        row(
            "S-T01",
            "a reply begins within min T_SDR and max T_SDR",
            "the slave starts its reply at or after min T_SDR and at or before max T_SDR (1.1)",
            &[],
            By::Watching(t01),
        ),
        row(
            "S-T02",
            "nothing is sent late or without being asked",
            "after max T_SDR never send: a late reply is credited to another slave (2 rule 6, 9)",
            &[],
            By::Watching(t02),
        ),
        softer(
            row(
                "S-T03",
                "a reply comes within T_SL of the master",
                "a master waits T_SL; that is the only escape for a slow slave (1.1)",
                &[],
                By::Watching(t03),
            ),
            2,
            C,
        ),
        softer(
            row(
                "S-T04",
                "Data_Exchange as fast as the line allows is answered, with old inputs if need be",
                "Min_Slave_Intervall is the least time between two Data_Exchange with new inputs (9)",
                &["S-X01"],
                By::Trial(t04),
            ),
            2,
            B,
        ),
    ],
};

fn t01(tester: &mut Tester) -> Course {
    if tester.wire.sight == Sight::Untimed {
        return inapplicable("needs a real line or virtual time: no bit times are seen on this link");
    }
    tester.watched("S-T01", "nothing was answered")
}

fn t02(tester: &mut Tester) -> Course {
    tester.watched("S-T02", "nothing was answered")
}

fn t03(tester: &mut Tester) -> Course {
    if tester.wire.sight != Sight::Untimed {
        return inapplicable("S-T01 and S-T02 judge the times of this line");
    }
    tester.watched("S-T03", "nothing was answered")
}

/// How many in a row.
const FAST: u32 = 200;
const FAST_QUICKLY: u32 = 50;

fn t04(tester: &mut Tester) -> Course {
    tester.start()?;
    for _ in 0..if tester.setup.quick { FAST_QUICKLY } else { FAST } {
        tester.exchanged_zeros()?;
    }
    Ok(())
}
