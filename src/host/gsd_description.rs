//! What a station from a GSD tells of itself: its modules octet by octet, and what its diagnosis reports.

use core::fmt;

use super::reported::InSlot;
use super::{GsdStation, OutputsAre};
use crate::face::description::{Amount, Exchange, ExchangeEntry};
use crate::face::surroundings::{Declined, Provocable};
use crate::face::{Acyclic, Description, Surroundings};
use crate::gsd::{ModuleState, PrmValue};
use crate::time::Instant;

impl OutputsAre {
    /// Why the outputs are what they are, in words.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::Unowned => "no master exchanges data",
            Self::Live => "Data_Exchange",
            Self::Cleared => "outputs cleared by the master",
            Self::FailSafe => "Fail_Safe: no outputs",
            Self::WatchdogExpired => "watchdog expired",
        }
    }
}

impl Surroundings for GsdStation {
    /// Its inputs belong to what moves them by itself.
    fn make_nominal(&mut self, _now: Instant) {
        self.release_all();
        self.plug_all();
    }

    /// Of a modular station each module can be missing or another one.
    fn each_fault(&self, tell: &mut dyn FnMut(Provocable<'_>)) {
        for placed in self.layout().iter().filter(|_| self.gsd().is_modular()) {
            let (slot, name) = (placed.slot.number, placed.name(self.gsd()));
            for (what, in_slot) in InSlot::NAMED {
                let (state, text) = match in_slot {
                    InSlot::Empty => (ModuleState::Missing, "the module is pulled"),
                    InSlot::Other | InSlot::Expected => (ModuleState::Wrong, "another module is plugged"),
                };
                let present = self.unlike().get(&slot) == Some(&state);
                tell(Provocable {
                    name: &format_args!("slot{slot}-{what}"),
                    text: &format_args!("slot {slot} '{name}': {text}"),
                    present,
                    provoked: present,
                });
            }
        }
    }

    fn provoke(&mut self, _now: Instant, fault: &str) -> Result<(), Declined> {
        let (slot, what) = self.fault(fault)?;
        self.plug(slot, what);
        Ok(())
    }

    fn take_back(&mut self, _now: Instant, fault: &str) -> Result<(), Declined> {
        let (slot, _) = self.fault(fault)?;
        self.plug(slot, InSlot::Expected);
        Ok(())
    }
}

/// A parameter of Set_Prm.
#[derive(Debug)]
pub(super) struct ShownPrm {
    name: String,
    place: String,
    value: i64,
    text: Option<String>,
}

impl GsdStation {
    /// The parameters of the Set_Prm in force.
    pub(super) fn shown_prm(&self) -> Vec<ShownPrm> {
        let slave = self.slave();
        let values = slave.application().prm_values(slave.configuration(), slave.user_prm());
        let shown = |value: PrmValue<'_>| {
            let slot = value.slot.map(|slot| format!("slot {slot}, ")).unwrap_or_default();
            ShownPrm {
                name: value.parameter.name.clone(),
                place: format!("{slot}octet {}", value.octet),
                value: value.value,
                text: value.text.map(str::to_owned),
            }
        };
        values.into_iter().map(shown).collect()
    }

    /// The slot of a fault, and what is in it then.
    fn fault(&self, name: &str) -> Result<(u16, InSlot), Declined> {
        let named = InSlot::named(name).filter(|(slot, _)| {
            self.gsd().is_modular() && self.layout().iter().any(|placed| placed.slot.number == *slot)
        });
        named.ok_or(Declined::Unknown)
    }
}

impl Description for GsdStation {
    fn acyclic(&self) -> Option<&dyn Acyclic> {
        self.services().is_some_and(|services| !services.offer().is_none()).then_some(self)
    }

    fn acyclic_mut(&mut self) -> Option<&mut dyn Acyclic> {
        if self.acyclic().is_some() { Some(self) } else { None }
    }

    fn say_state(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        say(&self.outputs_are().words());
    }

    fn tell_fault(&self, tell: &mut dyn FnMut(&dyn fmt::Display, &dyn fmt::Display)) {
        if !self.report_words().is_empty() {
            tell(&"diagnosis", &"raised");
        }
    }

    fn say_warning(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        match self.outputs_are() {
            OutputsAre::Unowned | OutputsAre::Live => {}
            warned @ (OutputsAre::Cleared | OutputsAre::FailSafe | OutputsAre::WatchdogExpired) => {
                say(&warned.words());
            }
        }
    }

    fn each_exchange(&self, tell: &mut dyn FnMut(Exchange<'_>)) {
        for placed in self.layout() {
            let number = placed.slot.number;
            let name = format!("Slot {number}: {}", placed.name(self.gsd()));
            let (inputs, outputs) = (self.inputs(&placed.slot), self.outputs(&placed.slot));
            let (of_inputs, of_outputs) = (format!("slot{number} inputs"), format!("slot{number} outputs"));
            let exchange = Exchange {
                key: &of_inputs,
                name: &name,
                from_master: false,
                octets: &inputs,
                forced: Some((number, self.forced(&placed.slot))),
                details: None,
                each_entry: &|_| {},
            };
            if !inputs.is_empty() || outputs.is_empty() {
                tell(exchange);
            }
            if !outputs.is_empty() {
                let forced = Some((number, &[][..]));
                tell(Exchange { key: &of_outputs, from_master: true, octets: outputs, forced, ..exchange });
            }
        }
        if self.prm().is_empty() {
            return;
        }
        let entries = |tell: &mut dyn FnMut(ExchangeEntry<'_>)| {
            for ShownPrm { name, place, value, text } in self.prm() {
                #[expect(clippy::cast_precision_loss, reason = "a parameter has 32 bits at most")]
                let number = Amount::Number(*value as f64);
                let amount = text.as_ref().map_or(number, |text| Amount::Text(text));
                tell(ExchangeEntry { name, place, amount, unit: "" });
            }
        };
        tell(Exchange {
            key: &"set_prm",
            name: &"User parameters (Set_Prm)",
            from_master: true,
            octets: self.slave().user_prm(),
            forced: None,
            details: None,
            each_entry: &entries,
        });
    }
}
