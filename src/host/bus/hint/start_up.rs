//! What masters ask of the stations of a line beside Data_Exchange: what leads to none, or nowhere.

use super::{LineHint, Owned, is_due};
use crate::profibus::dp::{ControlBit, GlobalControl, Service, SetPrm};
use crate::profibus::fdl::DataTelegram;
use crate::time::Instant;

/// So many readings of the diagnosis and nothing else are no start-up.
const ONLY_DIAGNOSIS: u8 = 20;

/// Addresses of stations: 0 to 126.
const STATIONS: usize = 127;

/// What was asked of the stations. In steady exchange each look costs a comparison.
#[derive(Debug)]
pub(super) struct StartUp {
    /// Readings of the diagnosis of each station since it was asked for anything else.
    diagnoses: [u8; STATIONS],
    /// How many stations have such readings.
    read: u8,
    diagnosis_said: Option<Instant>,
    unlock_said: Option<Instant>,
    group_said: Option<Instant>,
    other_said: Option<Instant>,
    control_said: Option<Instant>,
}

impl StartUp {
    pub(super) const fn new() -> Self {
        Self {
            diagnoses: [0; STATIONS],
            read: 0,
            diagnosis_said: None,
            unlock_said: None,
            group_said: None,
            other_said: None,
            control_said: None,
        }
    }

    /// A request to a station of ours, or to all.
    #[inline]
    pub(super) fn asked(
        &mut self,
        now: Instant,
        request: &DataTelegram<'_>,
        alone: bool,
        owned: &mut Owned,
    ) -> Option<LineHint> {
        if request.dsap.is_none() && self.read == 0 && owned.holds_nothing() {
            return None;
        }
        self.looked_at(now, request, alone, owned)
    }

    /// `alone`: no station of others was heard on the line.
    #[cold]
    fn looked_at(
        &mut self,
        now: Instant,
        request: &DataTelegram<'_>,
        alone: bool,
        owned: &mut Owned,
    ) -> Option<LineHint> {
        let service = Service::of(request.dsap, request.ssap)?;
        if service == Service::GlobalControl {
            return self.control(now, request, alone, owned);
        }
        let station = request.da;
        let place = usize::from(station.number());
        if service == Service::SlaveDiag {
            return self.diagnosis(now, place, request);
        }
        let times = self.diagnoses.get_mut(place)?;
        self.read = self.read.saturating_sub(u8::from(*times > 0));
        *times = 0;
        if service == Service::DataExchange {
            return owned.exchanged(now, station);
        }
        if service != Service::SetPrm {
            return None;
        }
        let both = SetPrm::parse(request.data).is_ok_and(|prm| prm.lock_req() && prm.unlock_req());
        (both && is_due(&mut self.unlock_said, now))
            .then_some(LineHint::LockAndUnlock { master: request.sa, station })
    }

    fn diagnosis(&mut self, now: Instant, place: usize, request: &DataTelegram<'_>) -> Option<LineHint> {
        let times = self.diagnoses.get_mut(place)?;
        self.read = self.read.saturating_add(u8::from(*times == 0));
        *times = times.saturating_add(1);
        if *times != ONLY_DIAGNOSIS {
            return None;
        }
        let hint = LineHint::OnlyDiagnosis { master: request.sa, station: request.da };
        is_due(&mut self.diagnosis_said, now).then_some(hint)
    }

    fn control(
        &mut self,
        now: Instant,
        request: &DataTelegram<'_>,
        alone: bool,
        owned: &Owned,
    ) -> Option<LineHint> {
        let master = request.sa;
        let &[command, select] = request.data else {
            let hint = LineHint::ControlLength { master, got: request.data.len() };
            return is_due(&mut self.control_said, now).then_some(hint);
        };
        if command & ControlBit::RESERVED != 0 {
            let hint = LineHint::ControlReserved { master, command };
            return is_due(&mut self.control_said, now).then_some(hint);
        }
        let control = GlobalControl::parse(request.data, true)?;
        let hint = owned.in_vain(master, control, select).filter(|_| alone && control.asks_anything())?;
        let of_other = matches!(hint, LineHint::ControlOfOther { .. });
        is_due(if of_other { &mut self.other_said } else { &mut self.group_said }, now).then_some(hint)
    }
}
