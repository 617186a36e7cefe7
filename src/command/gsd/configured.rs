//! `gsd FILE --modules`: Chk_Cfg and the user parameters of Set_Prm for a master's configuration.

use std::io::{self, Write};

use crate::gsd::{Gsd, Policy, Station};
use crate::profibus::dp::IoLengths;
use serde_json::{Value, json};

use super::hex;
use crate::command::Failure;

/// Modules in their slots, and how they are parameterised.
pub(super) struct Configured {
    gsd: Gsd,
    modules: Vec<usize>,
    chk_cfg: Vec<u8>,
    user_prm: Vec<u8>,
    lengths: IoLengths,
}

impl Configured {
    pub(super) fn of(gsd: Gsd, names: &str, settings: &[String]) -> Result<Self, Failure> {
        let usage = |error: &dyn core::fmt::Display| Failure::Usage(error.to_string());
        let modules = gsd.modules_named(names).map_err(|error| usage(&error))?;
        let station = Station::new(gsd.clone(), Policy::PROPOSED).map_err(|error| usage(&error))?;
        station.plugged(&modules).map_err(|error| usage(&error))?;
        let mut user_prm = gsd.default_user_prm(&modules);
        for setting in settings {
            gsd.set_prm_value(&modules, &mut user_prm, setting).map_err(|error| usage(&error))?;
        }
        let own = modules.iter().filter_map(|module| gsd.modules.get(*module));
        let chk_cfg: Vec<u8> = own.flat_map(|module| module.identifiers.clone()).collect();
        let lengths = IoLengths::of(&chk_cfg).unwrap_or_default();
        Ok(Self { gsd, modules, chk_cfg, user_prm, lengths })
    }

    pub(super) fn say(&self, out: &mut dyn Write) -> io::Result<()> {
        let Self { gsd, modules, chk_cfg, user_prm, lengths } = self;
        writeln!(out, "Ident number     {:04X}", gsd.ident)?;
        writeln!(out, "Chk_Cfg          {}", hex(chk_cfg))?;
        if user_prm.is_empty() {
            writeln!(out, "User parameters  none")?;
        } else {
            writeln!(out, "User parameters  {}", hex(user_prm))?;
            writeln!(out, "                 {} octets, in Set_Prm behind Group_Ident", user_prm.len())?;
        }
        writeln!(out, "Data_Exchange    {} octets out, {} in", lengths.outputs, lengths.inputs)?;
        let values = gsd.prm_values(modules, user_prm);
        let say = |out: &mut dyn Write, slot: Option<u16>| {
            for value in values.iter().filter(|value| value.slot == slot) {
                let text = value.text.map(|text| format!(" ({text})")).unwrap_or_default();
                writeln!(out, "  octet {}: {} = {}{text}", value.octet, value.parameter.name, value.value)?;
            }
            Ok::<_, io::Error>(())
        };
        if values.iter().any(|value| value.slot.is_none()) {
            writeln!(out, "Station")?;
            say(out, None)?;
        }
        for (module, slot) in modules.iter().zip(gsd.slot_offset..) {
            let name = gsd.modules.get(*module).map(|module| module.name.as_str()).unwrap_or_default();
            writeln!(out, "Slot {slot}: {name}")?;
            say(out, Some(slot))?;
        }
        Ok(())
    }

    pub(super) fn json(&self) -> Value {
        let Self { gsd, modules, chk_cfg, user_prm, lengths } = self;
        let slots = modules.iter().zip(gsd.slot_offset..).map(|(module, slot)| {
            json!({ "slot": slot, "module": gsd.modules.get(*module).map(|module| &module.name) })
        });
        let values = gsd.prm_values(modules, user_prm).into_iter().map(|value| {
            json!({
                "slot": value.slot,
                "octet": value.octet,
                "name": value.parameter.name,
                "value": value.value,
                "text": value.text,
            })
        });
        json!({
            "ident": gsd.ident,
            "chk_cfg": chk_cfg,
            "user_prm": user_prm,
            "outputs": lengths.outputs,
            "inputs": lengths.inputs,
            "slots": slots.collect::<Vec<_>>(),
            "parameters": values.collect::<Vec<_>>(),
        })
    }
}
