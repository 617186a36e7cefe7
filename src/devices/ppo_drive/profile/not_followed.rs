//! Control words that the drive does not follow.

use core::fmt;

use super::reasons::reasons;
use super::{StwBit, ZswBit};
use crate::face::{EventKind, Reason};
use crate::profibus::ppo::{Stw, Zsw};

/// A control word that asks for something that the drive does not do. `Display` is one line: what, why, what to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotFollowed {
    asked: Asked,
    stw: Stw,
    /// Behind the cycle in which it came.
    zsw: Zsw,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    /// Bit 10 is 0.
    NotByPlc,
    Enable,
    Inching,
    /// The octets of the word are exchanged.
    Exchanged,
}

impl NotFollowed {
    /// Of a word that came after `before`; `zsw` is the status word behind it. `None`: it asks for nothing new, or gets it.
    pub(crate) fn of(before: Stw, stw: Stw, zsw: Zsw) -> Option<Self> {
        if stw == before {
            return None;
        }
        let all = |word: Stw, bits: &[StwBit]| bits.iter().all(|bit| bit.is_set(word));
        let (offs, rest) =
            ([StwBit::NoOff2, StwBit::NoOff3], [StwBit::On, StwBit::EnableOperation, StwBit::ByPlc]);
        // Once when it is asked for, and once when OFF2 and OFF3 have gone.
        let asks = |word: Stw| all(word, &rest);
        let enables = |word: Stw| asks(word) && all(word, &offs);
        let enables_now = asks(stw) && !asks(before) || enables(stw) && !enables(before);
        let inches = |word: Stw| StwBit::Inching1.is_set(word) || StwBit::Inching2.is_set(word);
        let operates = ZswBit::OperationEnabled.is_set(zsw);
        let of = |asked| Self { asked, stw, zsw };
        if exchanged(stw) {
            return Some(of(Asked::Exchanged));
        }
        if !StwBit::ByPlc.is_set(stw) {
            // Outputs that are all 0 are those of a master in CLEAR, and no command.
            return (stw.raw() != 0 || operates).then_some(of(Asked::NotByPlc));
        }
        let asked = match () {
            () if inches(stw) && !inches(before) && !operates => Asked::Inching,
            () if enables_now && !operates => Asked::Enable,
            () => return None,
        };
        let not_followed = of(asked);
        not_followed.reasons().next().is_some().then_some(not_followed)
    }

    fn reasons(self) -> impl Iterator<Item = Reason<'static>> {
        reasons(self.stw, self.zsw).filter(move |reason| match reason.name {
            "NotByPlc" => self.asked == Asked::NotByPlc,
            "Fault" | "Off2" | "Off3" | "Inhibited" | "NotReadyToSwitchOn" => {
                matches!(self.asked, Asked::Enable | Asked::Inching)
            }
            "NotOn" | "NotEnabled" => self.asked == Asked::Inching,
            _ => false,
        })
    }

    /// Whether it is no mistake: a master whose outputs are all 0 is in CLEAR.
    pub(crate) const fn is_hint(&self) -> bool {
        matches!(self.asked, Asked::NotByPlc) && self.stw.raw() == 0
    }

    /// Its kind.
    pub(crate) const fn kind(&self) -> EventKind {
        if self.is_hint() { EventKind::Hint } else { EventKind::CommandRefused }
    }

    /// Each reason.
    pub(crate) fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        self.reasons().for_each(tell);
    }
}

impl fmt::Display for NotFollowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.asked {
            Asked::NotByPlc if self.is_hint() => {
                return write!(
                    f,
                    "hint: the drive goes on with what was commanded before: bit {} of STW is 0 ({}); give OFF1 ({:04X}) before \
                     the PLC stops",
                    StwBit::ByPlc.number(),
                    StwBit::ByPlc.name(),
                    (StwBit::ByPlc.mask() | 0x7F) & !StwBit::On.mask()
                );
            }
            Asked::NotByPlc => {
                return write!(
                    f,
                    "control word {:04X} not followed, what was commanded before holds: set STW bit {} ({})",
                    self.stw.raw(),
                    StwBit::ByPlc.number(),
                    StwBit::ByPlc.name()
                );
            }
            Asked::Exchanged => {
                return write!(
                    f,
                    "the octets of STW {:04X} seem to be exchanged: {:04X} was meant; send the high octet first",
                    self.stw.raw(),
                    self.stw.raw().swap_bytes()
                );
            }
            Asked::Enable => f.write_str("enabling operation refused")?,
            Asked::Inching => f.write_str("inching refused")?,
        }
        for (place, reason) in self.reasons().enumerate() {
            write!(f, "{}{reason}", if place == 0 { ": " } else { "; " })?;
        }
        if self.asked == Asked::Enable && self.reasons().all(|reason| reason.name == "Inhibited") {
            let (on, ready) = (self.stw.raw(), self.stw.raw() & !StwBit::On.mask());
            write!(f, "; next: send STW {ready:04X}, then {on:04X}")?;
        }
        Ok(())
    }
}

/// Whether a word has nothing of a low octet but OFF2 and OFF3, and would be one of a drive that is led with its octets exchanged.
fn exchanged(stw: Stw) -> bool {
    let low: u16 = [StwBit::NoOff2, StwBit::NoOff3].iter().map(|bit| bit.mask()).sum();
    let led = StwBit::ByPlc.mask() | low;
    stw.raw() & 0xFF & !low == 0 && stw.raw().swap_bytes() & led == led
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    fn said(before: u16, stw: u16, zsw: u16) -> Option<std::string::String> {
        let of = NotFollowed::of(Stw::from_raw(before), Stw::from_raw(stw), Zsw::from_raw(zsw));
        of.map(|not_followed| not_followed.to_string())
    }

    #[test]
    fn what_is_asked_and_not_done_is_told_with_its_reasons() {
        for (before, stw, zsw, text) in [
            (
                0,
                0x047F,
                0x0270,
                "enabling operation refused: switching on is inhibited: give OFF1 once (STW bit 0 = 0, bits 1 and 2 = 1); next: send STW 047E, then 047F",
            ),
            (
                0x047E,
                0x047F,
                0x0238,
                "enabling operation refused: a fault: remove its cause and acknowledge it (STW bit 7 from 0 to 1)",
            ),
            (
                0,
                0x007F,
                0x0231,
                "control word 007F not followed, what was commanded before holds: set STW bit 10 (control by PLC)",
            ),
            (
                0x047F,
                0,
                0x0337,
                "hint: the drive goes on with what was commanded before: bit 10 of STW is 0 (control by PLC); give OFF1 (047E) before the PLC stops",
            ),
            (
                0x040E,
                0x7E04,
                0x0231,
                "the octets of STW 7E04 seem to be exchanged: 047E was meant; send the high octet first",
            ),
            (
                0x047B,
                0x047F,
                0x0270,
                "enabling operation refused: switching on is inhibited: give OFF1 once (STW bit 0 = 0, bits 1 and 2 = 1); next: send STW 047E, then 047F",
            ),
            (0x040E, 0x050E, 0x0231, "inching refused: OFF1: set STW bit 0 (ON)"),
        ] {
            assert_eq!(said(before, stw, zsw).as_deref(), Some(text), "{stw:04X}");
        }
    }

    #[test]
    fn the_way_of_a_correct_master_and_one_in_clear_is_not() {
        for (before, stw, zsw) in [
            (0, 0x047E, 0x0231),
            (0x047E, 0x047F, 0x0233),
            (0x047F, 0x047F, 0x0238),
            (0x047F, 0x04FF, 0x0270),
            (0x047E, 0, 0x0231),
            (0x047F, 0x043F, 0x0337),
        ] {
            assert_eq!(said(before, stw, zsw), None, "{stw:04X}");
        }
    }
}
