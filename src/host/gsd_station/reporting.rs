//! What the diagnosis of a station reports besides what its slave does, and what is plugged in its slots.

use std::collections::BTreeMap;

use super::{GsdStation, MAX_IO_LEN};
use crate::gsd::{ModuleState, RaiseError, Raised};
use crate::host::ByHand;
use crate::host::reported::{InSlot, Timed};
use crate::time::Instant;

impl GsdStation {
    /// The same station with a time line of its diagnosis, which begins at `now`.
    #[must_use]
    pub(crate) fn with_timed(mut self, now: Instant, timed: Vec<Timed>) -> Self {
        (self.reported.timed, self.began) = (timed, now);
        self.report(now);
        self
    }

    /// What is raised besides what the slave reports by itself.
    pub const fn raised(&self) -> &Raised {
        &self.reported.by_hand
    }

    /// The slots whose module is not that of the configuration, and how they differ.
    pub const fn unlike(&self) -> &BTreeMap<u16, ModuleState> {
        &self.unlike
    }

    /// What is raised by hand and on the time line and by modules that are not as configured, in the texts of the file.
    pub(crate) fn report_words(&self) -> Vec<String> {
        self.all_raised().words(self.gsd(), &self.layout)
    }

    /// Pulls or plugs the module of a slot.
    pub(in crate::host) fn plug(&mut self, slot: u16, what: InSlot) {
        self.reported.slots.insert(slot, what);
        self.report(self.now);
        self.tell(match what {
            InSlot::Expected => ByHand::Plugged { slot },
            InSlot::Other => ByHand::PluggedOther { slot },
            InSlot::Empty => ByHand::Pulled { slot },
        });
    }

    /// Every slot is as it was made.
    pub(in crate::host) fn plug_all(&mut self) {
        for slot in core::mem::take(&mut self.reported.slots).into_keys() {
            self.tell(ByHand::Plugged { slot });
        }
        self.report(self.now);
    }

    fn all_raised(&self) -> Raised {
        let (station, after) = (self.slave().application(), self.now.saturating_since(self.began));
        self.reported.all(station, &self.layout, after, &self.unlike)
    }

    /// Files what the diagnosis reports now.
    pub(super) fn report(&mut self, now: Instant) {
        self.now = now;
        let after = now.saturating_since(self.began);
        self.next_report = self.reported.next(after).map(|next| self.began.saturating_add(next));
        self.unlike = self.reported.unlike(self.slave().application(), &self.layout, after);
        self.live = [0xFF; MAX_IO_LEN];
        for slot in self.slots.iter().filter(|slot| self.unlike.contains_key(&slot.number)) {
            self.live.get_mut(slot.inputs.clone()).unwrap_or_default().fill(0);
        }
        match self.all_raised().blocks(self.gsd(), &self.layout) {
            Ok(blocks) => self.file(&blocks),
            Err(error) => {
                tracing::warn!(
                    "station {}: its diagnosis cannot be reported: {error}",
                    self.station.address()
                );
            }
        }
        self.offer();
    }

    /// Has the diagnosis report this and nothing else, until it is raised anew.
    ///
    /// # Errors
    /// [`RaiseError`] for what the configuration or the file does not have. Nothing is changed then.
    pub fn raise(&mut self, raised: Raised) -> Result<(), RaiseError> {
        raised.blocks(self.gsd(), &self.layout)?;
        if raised.is_empty() {
            self.tell(ByHand::Ended);
        } else {
            self.raises = self.raises.wrapping_add(1);
            let words = raised.words(self.gsd(), &self.layout).join(", ");
            self.refusals.raised(self.station.address(), self.raises, &words);
            self.tell(ByHand::Raised { number: self.raises });
        }
        self.reported.by_hand = raised;
        self.report(self.now);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use core::time::Duration;

    use super::*;
    use crate::gsd::{Gsd, Policy, Station};
    use crate::host::{Participant as _, Refusals};
    use crate::process::{Point, ValueType};
    use crate::profibus::fdl::Address;
    use crate::time::BaudRate;

    const FILE: &str = "#Profibus_DP\nIdent_Number=1\nModular_Station=1\nMax_Module=4\nModul_Offset=1\n\
        Max_Diag_Data_Len=30\nUnit_Diag_Bit(0)=\"supply\"\nUnitDiagType=130\nX_Unit_Diag_Area=24-25\nX_Value(2)=\"wrong\"\n\
        X_Unit_Diag_Area_End\nEndUnitDiagType\nModule=\"in\" 0x10\nEndModule\nModule=\"out\" 0x20\nEndModule\n\
        Module=\"two\" 0x11\nEndModule\n";

    /// In, empty slot, out.
    fn station(timed: Vec<Timed>) -> GsdStation {
        let station = Station::new(Gsd::read(FILE.as_bytes()).unwrap(), Policy::PROPOSED).unwrap();
        let station = station.with_slots(&[Some(0), None, Some(1)]).unwrap();
        let address = Address::station(7).unwrap();
        GsdStation::new(address, BaudRate::K500, station, Refusals::default())
            .with_timed(Instant::ZERO, timed)
    }

    fn blocks(station: &GsdStation) -> &[u8] {
        station.slave().ext_diag().octets()
    }

    #[test]
    fn a_module_that_is_pulled_has_no_inputs_and_is_reported_until_it_is_plugged() {
        let mut station = station(Vec::new());
        station.force(Point { slot: 1, offset: 0, kind: ValueType::Unsigned8 }, 5.0).unwrap();
        assert_eq!((station.slave().inputs()[0], blocks(&station)), (5, &[][..]));
        station.plug(1, InSlot::Empty);
        let reported = [0x42, 0x01, 0x05, 0x82, 0x00, 0x00, 0x03];
        assert_eq!((station.slave().inputs()[0], blocks(&station)), (0, &reported[..]));
        assert_eq!(station.report_words(), ["slot 1 'in': has a diagnosis", "slot 1 'in': no module"]);
        station.plug(1, InSlot::Other);
        station.plug(3, InSlot::Empty);
        assert_eq!(blocks(&station), [0x42, 0x05, 0x05, 0x82, 0x00, 0x00, 0x32]);
        station.plug(1, InSlot::Expected);
        station.plug(2, InSlot::Empty);
        assert_eq!(
            blocks(&station),
            [0x42, 0x04, 0x05, 0x82, 0x00, 0x00, 0x30],
            "an empty slot lacks nothing"
        );
        station.plug_all();
        assert_eq!((station.slave().inputs()[0], blocks(&station)), (5, &[][..]));
    }

    #[test]
    fn the_time_line_raises_and_ends_a_diagnosis_beside_what_is_raised_by_hand() {
        let (s, at) = (Duration::from_secs, |s: u64| Instant::from_micros(s * 1_000_000));
        let raised = Raised { bits: [0].into(), octets: vec![0xC1], ..Raised::default() };
        let none = BTreeMap::new;
        let timed = vec![
            Timed { from: s(5), until: Some(s(9)), raised, slots: none() },
            Timed { from: s(7), until: None, raised: Raised::default(), slots: [(3, InSlot::Empty)].into() },
        ];
        let mut station = station(timed);
        let pulled = [0x42, 0x04, 0x05, 0x82, 0x00, 0x00, 0x30];
        let both = [&[0x02, 0x01][..], &pulled, &[0xC1]].concat();
        for (now, expected) in
            [(4, &[][..]), (5, &[0x02, 0x01, 0xC1]), (7, &both), (8, &both), (9, &pulled), (60, &pulled)]
        {
            station.handle_timeout(at(now), &mut |_| {});
            assert_eq!(blocks(&station), expected, "{now}");
        }
        let revision = Raised { octets: vec![0xC2], ..Raised::default() };
        station.raise(revision).unwrap();
        assert_eq!(blocks(&station), [&pulled[..], &[0xC2]].concat());
        station.raise(Raised::default()).unwrap();
        assert_eq!(blocks(&station), pulled);
        let raised = Raised { bits: [0].into(), ..Raised::default() };
        let ahead = vec![Timed { from: s(5), until: None, raised, slots: none() }];
        assert_eq!(self::station(ahead).poll_timeout(), Some(at(5)));
    }
}
