//! Global_Control (SAP 58): one command to many slaves.
//!
//! ```text
//! octet 1   b1 Clear_Data  b2 Unfreeze  b3 Freeze  b4 Unsync  b5 Sync  b0, b6, b7 reserved, 0
//! octet 2   Group_Select: 0 = all slaves, else those with one of these groups in Group_Ident
//! ```
//!
//! Source: `dp-v0.md` 6.3.

use super::octet_bits::octet_bits;

octet_bits! {
    /// A bit of octet 1, Control_Command.
    ControlBit {
        Sync = 5: "Sync", "the outputs are held, now and until Unsync", "no Sync";
        Unsync = 4: "Unsync", "Sync ends", "no Unsync";
        Freeze = 3: "Freeze", "the inputs are held, now and until Unfreeze", "no Freeze";
        Unfreeze = 2: "Unfreeze", "Freeze ends", "no Unfreeze";
        ClearData = 1: "Clear_Data", "outputs to zero", "no Clear_Data";
    }
}

/// A Global_Control command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GlobalControl {
    /// Outputs to zero.
    pub clear_data: bool,
    /// What to do about Freeze.
    pub freeze: Latch,
    /// What to do about Sync.
    pub sync: Latch,
    group_select: u8,
}

/// A pair of command bits: do and undo, of which undo wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Latch {
    /// No action.
    Keep,
    /// Do it now, and from now on.
    Set,
    /// End it.
    Release,
}

impl GlobalControl {
    /// Reads a command. `None` if there are not two octets, or if reserved bits are set and `check_reserved`: it is
    /// then ignored (S-08).
    pub(crate) fn parse(octets: &[u8], check_reserved: bool) -> Option<Self> {
        let &[command, group_select] = octets else {
            return None;
        };
        if check_reserved && command & ControlBit::RESERVED != 0 {
            return None;
        }
        let latch = |set: ControlBit, release: ControlBit| {
            if release.is_set(command) {
                Latch::Release
            } else if set.is_set(command) {
                Latch::Set
            } else {
                Latch::Keep
            }
        };
        Some(Self {
            clear_data: ControlBit::ClearData.is_set(command),
            freeze: latch(ControlBit::Freeze, ControlBit::Unfreeze),
            sync: latch(ControlBit::Sync, ControlBit::Unsync),
            group_select,
        })
    }

    /// Whether it asks for anything: a master in Operate may send one that does not.
    pub(crate) fn asks_anything(self) -> bool {
        self.clear_data || self.sync != Latch::Keep || self.freeze != Latch::Keep
    }

    /// Whether a slave of these groups obeys.
    pub(crate) const fn addresses(self, group_ident: u8) -> bool {
        self.group_select == 0 || self.group_select & group_ident != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn s_03_undo_wins() {
        let both = GlobalControl::parse(&[0x3C, 0], true).unwrap();
        assert_eq!((both.sync, both.freeze), (Latch::Release, Latch::Release));
        let none = GlobalControl::parse(&[0, 0], true).unwrap();
        assert_eq!((none.sync, none.freeze, none.clear_data), (Latch::Keep, Latch::Keep, false));
    }

    #[test]
    fn s_08_reserved_bits_and_wrong_lengths_are_no_command() {
        for octets in [&[0x01, 0][..], &[0x40, 0], &[0x80, 0], &[0x20], &[0x20, 0, 0], &[]] {
            assert_eq!(GlobalControl::parse(octets, true), None, "{octets:02X?}");
            let unchecked = GlobalControl::parse(octets, false);
            assert_eq!(unchecked.is_some(), octets.len() == 2, "{octets:02X?}");
        }
    }

    #[test]
    fn s_05_groups_select_by_common_bits_and_zero_selects_all() {
        for (select, ident, obeys) in [(0, 0, true), (0, 3, true), (2, 3, true), (4, 3, false), (1, 0, false)]
        {
            assert_eq!(GlobalControl::parse(&[0, select], true).unwrap().addresses(ident), obeys);
        }
    }
}
