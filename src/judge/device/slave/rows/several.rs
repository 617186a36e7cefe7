//! Several slaves in one device: not seen of one slave.

use super::{row, softer};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::requirement::Confidence::C;

const WHY: &str = "one slave is judged";

pub(super) const GROUP: Group<Tester> = Group {
    title: "Several slaves in one device",
    rows: &[
        softer(
            row(
                "S-N01",
                "125 slaves, two masters: independent states",
                "each slave has its own state",
                &[],
                By::Nothing(WHY),
            ),
            1,
            C,
        ),
        row(
            "S-N02",
            "a broadcast Global_Control: each slave by its own group",
            "Group_Select AND Group_Ident of each (6.3)",
            &[],
            By::Nothing(WHY),
        ),
        row(
            "S-N03",
            "Set_Slave_Add at 126: only one slave at a time",
            "126 is for one slave at a time (2.1)",
            &[],
            By::Nothing(WHY),
        ),
        softer(
            row(
                "S-N04",
                "its address is live already: it stays silent",
                "an address is used once (2.1)",
                &[],
                By::Nothing("it would need two devices with one address"),
            ),
            1,
            C,
        ),
        softer(
            row(
                "S-N05",
                "one slave comes or goes: the others do not notice",
                "each slave has its own state",
                &[],
                By::Nothing(WHY),
            ),
            2,
            C,
        ),
    ],
};
