//! LSS (CiA 305): a master finds a node by its identity and gives it another number.
//!
//! ```text
//! 7E5h ▶ 04 mode | 40..43 identity | 11 number | 13 table rate | 17 | 5A..5D | 5E | 46..4B identity
//! 7E4h ◀           44                11 error    13 error        17 error  5A..5D value  5E number  4F
//! ```

use super::Node;
use crate::can_bus::can::{BaseId, Frame, Id};
use crate::can_bus::canopen::address::{Address, NodeId};
use crate::can_bus::canopen::application::Application;
use crate::can_bus::canopen::cob_id;
use crate::can_bus::canopen::event::{Event, LssRefusal};

/// Octets of every frame.
const FRAME_LEN: usize = 8;

/// What the master has said so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lss {
    /// It can be configured.
    configures: bool,
    /// Parts of the identity in a row that were its own: to be selected, to be identified.
    selected: u8,
    identified: u8,
}

impl Lss {
    pub(super) const NONE: Self = Self { configures: false, selected: 0, identified: 0 };
}

/// What a node answers to a request to configure.
const OK: u8 = 0;
const REFUSED: u8 = 1;

impl Node {
    /// A data frame on 7E5h, for nodes that offer LSS.
    pub(super) fn lss_request(&mut self, frame: &Frame, app: &mut dyn Application) {
        let Ok([command, a, b, c, d, ..]) = <[u8; FRAME_LEN]>::try_from(frame.octets()) else { return };
        let Some(rates) = app.lss_rates() else { return };
        let number = u32::from_le_bytes([a, b, c, d]);
        match command {
            0x04 => self.lss = Lss { configures: a == 1, ..Lss::NONE },
            0x40..=0x43 => {
                let part = command & 3;
                let goes_on = part == 0 || part == self.lss.selected;
                let is_own = goes_on && self.identity(part, app) == Some(number);
                self.lss.selected = if is_own { part + 1 } else { 0 };
                if is_own && part == 3 {
                    self.lss = Lss { configures: true, ..Lss::NONE };
                    self.lss_answer([0x44, 0, 0, 0, 0]);
                }
            }
            0x46..=0x4B => {
                let (step, own) = (command - 0x46, |part| self.identity(part, app));
                let is_own = match step {
                    0 | 1 => own(step) == Some(number),
                    2 | 4 => own(step / 2 + 1).is_some_and(|own| own >= number),
                    _highest => own(step / 2 + 1).is_some_and(|own| own <= number),
                };
                let goes_on = step == 0 || step == self.lss.identified;
                self.lss.identified = if is_own && goes_on { step + 1 } else { 0 };
                if self.lss.identified == 6 {
                    self.lss.identified = 0;
                    self.lss_answer([0x4F, 0, 0, 0, 0]);
                }
            }
            _ if !self.lss.configures => {}
            0x11 => {
                let taken = NodeId::new(a).is_ok_and(|node| app.change_node_id(node));
                self.lss_outcome(0x11, taken, LssRefusal::Node { got: a });
            }
            0x13 => {
                let is_known = a == 0 && rates.get(usize::from(b)).is_some_and(|known| *known);
                let bit = |(place, known): (usize, &bool)| u16::from(*known) << place;
                let known = rates.iter().enumerate().map(bit).sum();
                self.lss_outcome(0x13, is_known, LssRefusal::Rate { table: a, place: b, known });
            }
            0x17 => {
                app.keep_node_id();
                self.offer_image();
                self.lss_answer([0x17, OK, 0, 0, 0]);
            }
            0x5A..=0x5D => {
                let [a, b, c, d] = self.identity(command - 0x5A, app).unwrap_or_default().to_le_bytes();
                self.lss_answer([command, a, b, c, d]);
            }
            0x5E => self.lss_answer([0x5E, self.node_id.number(), 0, 0, 0]),
            0x00..=0xFF => {}
        }
    }

    /// Vendor, product, revision and serial number: 1018h:1 to 4.
    fn identity(&self, part: u8, app: &dyn Application) -> Option<u32> {
        let at = Address::new(0x1018, part + 1);
        let Ok(entry) = self.entry(at) else { return Some(0) };
        let read = self.value_with(at, entry, app, |octets| Ok(<[u8; 4]>::try_from(octets).ok()));
        read.ok().flatten().map(u32::from_le_bytes)
    }

    /// Answers a request to configure, and tells of one that is refused.
    fn lss_outcome(&mut self, command: u8, taken: bool, refusal: LssRefusal) {
        if !taken {
            self.tell(Event::LssRefused(refusal));
        }
        self.lss_answer([command, if taken { OK } else { REFUSED }, 0, 0, 0]);
    }

    fn lss_answer(&mut self, [command, a, b, c, d]: [u8; 5]) {
        // 7E4h has 11 bits.
        let id = Id::Base(BaseId::new(cob_id::LSS_SLAVE).unwrap_or(BaseId::MAX));
        self.send(Frame::with(id, [command, a, b, c, d, 0, 0, 0]));
    }
}
