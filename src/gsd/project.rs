//! What a project of a master sends for modules: Chk_Cfg, and the user parameters of Set_Prm by parameter and text.

use thiserror::Error;

use super::{Gsd, Parameter, PrmPart, did_you_mean};

/// A parameter among the user parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrmValue<'a> {
    /// The slot of its module; `None`: it is one of the station.
    pub slot: Option<u16>,
    /// Its first octet of the user parameters, from 0.
    pub octet: usize,
    /// The parameter.
    pub parameter: &'a Parameter,
    /// Its value.
    pub value: i64,
    /// The text of the value.
    pub text: Option<&'a str>,
}

/// Why a parameter cannot be set.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct SettingError(String);

impl Gsd {
    /// The places of modules that are named one after the other, with commas between them; a name may have commas itself.
    ///
    /// # Errors
    /// The first name that the file does not have.
    pub(crate) fn modules_named(&self, names: &str) -> Result<Vec<usize>, SettingError> {
        let mut rest = names.trim();
        let mut places = Vec::new();
        while !rest.is_empty() {
            let begins = |(place, module): (usize, &super::Module)| {
                let behind = rest.strip_prefix(module.name.as_str())?.trim_start();
                (behind.is_empty() || behind.starts_with(',')).then_some((module.name.len(), place, behind))
            };
            // The longest; of several with one name the first.
            let found = self.modules.iter().enumerate().filter_map(begins);
            let found = found.max_by_key(|(len, place, _)| (*len, core::cmp::Reverse(*place)));
            let Some((_, place, behind)) = found else {
                let name = rest.split(',').next().unwrap_or(rest).trim();
                let known = || self.modules.iter().map(|module| module.name.as_str());
                let cure = did_you_mean(name, known()).map(|near| format!("; did you mean '{near}'?"));
                return Err(SettingError(format!("there is no module '{name}'{}", cure.unwrap_or_default())));
            };
            places.push(place);
            rest = behind.trim_start_matches(',').trim_start();
        }
        Ok(places)
    }

    /// The user parameters by parameter, for these modules slot by slot.
    pub(crate) fn prm_values(&self, modules: &[usize], user_prm: &[u8]) -> Vec<PrmValue<'_>> {
        let mut values = Vec::new();
        for (slot, start, part) in self.parts(modules) {
            for (offset, parameter) in part.fields(self) {
                if let Some(value) = parameter.field.read(user_prm, start + offset) {
                    let text = self.text_of(parameter, value);
                    values.push(PrmValue { slot, octet: start + offset, parameter, value, text });
                }
            }
        }
        values
    }

    /// Sets a parameter: `Parameter=Text`, `Parameter=5`, or with the slot `2:Parameter=Text`.
    ///
    /// # Errors
    /// [`SettingError`]; nothing is changed then.
    pub(crate) fn set_prm_value(
        &self,
        modules: &[usize],
        user_prm: &mut [u8],
        setting: &str,
    ) -> Result<(), SettingError> {
        let wrong = |words: String| Err(SettingError(words));
        let all = self.prm_values(modules, user_prm);
        let (slot, named) =
            match setting.split_once(':').map(|(slot, rest)| (slot.trim().parse::<u16>(), rest)) {
                Some((Ok(slot), rest)) => (Some(slot), rest),
                Some((Err(_), _)) | None => (None, setting),
            };
        let Some((name, wanted)) = named.rsplit_once('=').map(|(name, wanted)| (name.trim(), wanted.trim()))
        else {
            return wrong(format!(
                "'{setting}' sets nothing; expected 'Parameter=Text' or '2:Parameter=Text'"
            ));
        };
        let found: Vec<_> = all
            .iter()
            .filter(|value| value.parameter.name == name && (slot.is_none() || value.slot == slot))
            .collect();
        let found = match found[..] {
            [one] => one,
            [] => {
                let known = all.iter().map(|value| value.parameter.name.as_str());
                let cure = did_you_mean(name, known).map(|near| format!("; did you mean '{near}'?"));
                return wrong(format!("there is no parameter '{name}' here{}", cure.unwrap_or_default()));
            }
            [first, ..] => {
                let slot = first.slot.unwrap_or_default();
                return wrong(format!(
                    "several slots have '{name}'; name one of them: '{slot}:{name}={wanted}'"
                ));
            }
        };
        let parameter = found.parameter;
        let texts = parameter.text_ref.and_then(|texts| self.texts.get(&texts));
        let value = texts.and_then(|texts| texts.iter().find(|text| text.1 == wanted)).map(|text| text.0);
        let Some(value) =
            value.or_else(|| wanted.parse().ok()).filter(|value| parameter.allowed.contains(*value))
        else {
            let known: Vec<_> = texts.into_iter().flatten().map(|text| format!("'{}'", text.1)).collect();
            let texts = if known.is_empty() { String::new() } else { format!(": {}", known.join(", ")) };
            return wrong(format!("'{name}' cannot be '{wanted}'; expected {}{texts}", parameter.allowed));
        };
        parameter.field.write(user_prm, found.octet, value);
        Ok(())
    }

    /// The parts of the user parameters: slot, first octet.
    fn parts(&self, modules: &[usize]) -> Vec<(Option<u16>, usize, &PrmPart)> {
        let mut start = self.default_user_prm(&[]).len();
        let mut parts = Vec::new();
        if self.has_new_user_prm() {
            parts.push((None, 0, &self.user_prm));
        }
        for (module, slot) in modules.iter().zip(self.slot_offset..) {
            let Some(module) = self.modules.get(*module) else { continue };
            parts.push((Some(slot), start, &module.prm));
            start += module.prm.extent(self);
        }
        parts
    }
}
