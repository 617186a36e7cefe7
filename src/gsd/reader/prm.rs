//! Reads the user parameters of a GSD: constants, references and definitions (`Ext_User_Prm_Data_...`), and the older
//! `User_Prm_Data`.

use super::{DIAG_BIT, DIAG_FIXED_LEN, Reader};
use crate::gsd::hint::Place;
use crate::gsd::parameter::{Allowed, FieldType, MAX_USER_PRM_LEN, Parameter, PrmPart, Reference};
use crate::gsd::statement::Statement;

impl Reader {
    pub(super) fn end_old_user_prm(&mut self) {
        let data = self.old_data.take();
        self.gsd.old_user_prm = match (self.old_len, data) {
            (None, data) => data,
            (Some((place, len)), data) => {
                let mut data = data.unwrap_or_else(|| {
                    if len > 0 && self.gsd.user_prm.is_empty() {
                        self.warn(place, "User_Prm_Data_Len without User_Prm_Data; read as zeros".into());
                    }
                    Vec::new()
                });
                if !data.is_empty() && data.len() != len {
                    let text = format!(
                        "User_Prm_Data_Len is {len}, User_Prm_Data has {} octets; the length is used",
                        data.len()
                    );
                    self.warn(place, text);
                }
                data.resize(len, 0);
                Some(data)
            }
        };
        if let Some(data) = &mut self.gsd.old_user_prm {
            data.truncate(MAX_USER_PRM_LEN);
        }
    }

    pub(super) fn end_references(&mut self) {
        for (place, number) in core::mem::take(&mut self.references) {
            if number & DIAG_BIT != 0 {
                let octets = u32::from(DIAG_FIXED_LEN) + 2 + (number & !DIAG_BIT) / 8;
                let most = self.gsd.max_diag_len;
                if octets > u32::from(most) {
                    let text = format!(
                        "bit {} needs a diagnosis of {octets} octets, Max_Diag_Data_Len is {most}: raise it",
                        number & !DIAG_BIT
                    );
                    self.warn(place, text);
                }
            } else if !self.gsd.parameters.contains_key(&number) {
                self.warn(place, format!("no ExtUserPrmData {number}; the reference is ignored"));
            }
        }
        let dangling = |parameter: &&Parameter| {
            parameter.text_ref.is_some_and(|text| !self.gsd.texts.contains_key(&text))
        };
        let without_text: Vec<_> =
            self.gsd.parameters.values().filter(dangling).map(|parameter| parameter.name.clone()).collect();
        for name in without_text {
            self.warn(self.header, format!("the Prm_Text_Ref of parameter '{name}' names no PrmText"));
        }
    }
}

/// A constant or a reference of a part of the user parameters.
pub(super) fn part(
    part: &mut PrmPart,
    line: &Statement<'_>,
    references: &mut Vec<(Place, u32)>,
) -> Result<(), String> {
    let offset = line.argument.unwrap_or_default();
    let offset = u8::try_from(offset).ok().filter(|offset| usize::from(*offset) < MAX_USER_PRM_LEN);
    let offset = offset.ok_or_else(|| format!("{} is behind octet 236; it is ignored", line.spelled))?;
    if line.keyword == "ext_user_prm_data_const" {
        let octets = line
            .octets()
            .ok_or_else(|| format!("{} has a value that is no octet; it is ignored", line.spelled))?;
        part.constants.push((offset, octets));
        return Ok(());
    }
    let id = line.first().and_then(|id| u32::try_from(id).ok()).filter(|id| id & DIAG_BIT == 0);
    let id = id.ok_or_else(|| format!("{} has no number; it is ignored", line.spelled))?;
    part.references.push(Reference { offset, id });
    references.push((line.place, id));
    Ok(())
}

/// The type of a parameter's definition; `None` if the line is something else.
pub(super) fn field_type(line: &Statement<'_>) -> Option<Result<FieldType, String>> {
    let bit = |number: Option<i64>| number.and_then(|bit| u8::try_from(bit).ok()).filter(|bit| *bit < 32);
    let (first, last) = (bit(line.argument), bit(line.argument_end));
    let wrong = || format!("{} names no bits of 0..31; the parameter is ignored", line.spelled);
    Some(match line.keyword.as_str() {
        "bit" => first.map(FieldType::Bit).ok_or_else(wrong),
        "bitarea" => match (first, last) {
            (Some(first), Some(last)) if first <= last => Ok(FieldType::BitArea(first, last)),
            (_, _) => Err(wrong()),
        },
        "unsigned8" => Ok(FieldType::Unsigned8),
        "unsigned16" => Ok(FieldType::Unsigned16),
        "unsigned32" => Ok(FieldType::Unsigned32),
        "signed8" => Ok(FieldType::Signed8),
        "signed16" => Ok(FieldType::Signed16),
        "signed32" => Ok(FieldType::Signed32),
        "changeable" | "visible" | "prm_text_ref" => {
            Err(format!("{} is before the type; it is ignored", line.spelled))
        }
        _other => return None,
    })
}

/// `Type default range-or-set`.
pub(super) fn definition(
    name: String,
    field: FieldType,
    line: &Statement<'_>,
) -> (Parameter, Option<String>) {
    let numbers = line.definition();
    let mut odd = None;
    if numbers.default.is_none() {
        odd = Some(format!("parameter '{name}' has no default; read as 0"));
    }
    let default = numbers.default.unwrap_or_default();
    let allowed = match (numbers.range, numbers.set) {
        (Some((least, most)), _) => Allowed::Range(least, most),
        (None, set) if set.is_empty() => Allowed::Any,
        (None, set) => Allowed::Set(set),
    };
    if let Allowed::Range(least, most) = allowed
        && least > most
    {
        odd = Some(format!("parameter '{name}': no value lies between the limits {least} and {most}"));
    } else if numbers.default.is_some() && !allowed.contains(default) {
        odd = Some(format!("parameter '{name}': the default {default} is not among {allowed}"));
    }
    if matches!(field, FieldType::Bit(last) | FieldType::BitArea(_, last) if last > 7) {
        odd = Some(format!("parameter '{name}': bits above 7, read in a word with bit 0 in its last octet"));
    }
    (Parameter { name, field, default, allowed, text_ref: None, changeable: true, visible: true }, odd)
}

impl Statement<'_> {
    /// A length in octets of user parameters.
    pub(super) fn prm_len(&self) -> Option<u8> {
        let most = u8::try_from(MAX_USER_PRM_LEN).unwrap_or(u8::MAX);
        self.first().map(|len| u8::try_from(len).map_or(most, |len| len.min(most)))
    }
}
