//! A diagnosis that is raised by hand.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::super::problem::Problem;
use crate::gsd::{ChannelFault, DiagArea, DiagBit, Gsd, ModuleState, Raised, Status};
use crate::profibus::dp;
use crate::profibus::dp::ext_diag::{ChannelError, Direction, ExtDiag, Width};

/// The diagnosis that is raised, besides what the slave reports by itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct Diagnosis {
    /// What was raised by hand.
    raised: RaisedDiagnosis,
    /// The same in the texts of the GSD.
    texts: Vec<String>,
    /// The octets of Slave_Diag, all of them.
    octets: Vec<u8>,
    /// Some blocks do not fit into Max_Diag_Data_Len and were left out.
    overflow: bool,
}

/// What the diagnosis of a station shall report; what is left out is not reported.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields, default)]
pub(in crate::panel) struct RaisedDiagnosis {
    /// Unit_Diag_Bit: the bits whose text applies.
    #[cfg_attr(test, schema(max_items = 496))]
    bits: Vec<u16>,
    /// Unit_Diag_Area.
    areas: Vec<RaisedArea>,
    /// Status blocks of the types that the file has texts for (UnitDiagType).
    statuses: Vec<RaisedStatus>,
    /// Slots of the identifier-related diagnosis.
    identifiers: Vec<u16>,
    /// The module status.
    modules: Vec<RaisedModule>,
    /// Channel-related diagnosis.
    channels: Vec<RaisedChannel>,
    /// Blocks as octets, behind the others; at most Max_Diag_Data_Len less 6.
    #[cfg_attr(test, schema(max_items = 238))]
    octets: Vec<u8>,
    /// Stat_Diag: the inputs are not valid.
    not_valid: bool,
}

/// A number in the diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
struct RaisedArea {
    /// The first bit of the area.
    first_bit: u16,
    value: u32,
}

/// A status block. Bits count from the octet behind its header: those of the block begin with 24.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
struct RaisedStatus {
    /// The number of the UnitDiagType.
    #[serde(rename = "type")]
    number: u8,
    /// X_Unit_Diag_Bit: the bits whose text applies.
    #[serde(default)]
    #[cfg_attr(test, schema(max_items = 496))]
    bits: Vec<u16>,
    /// X_Unit_Diag_Area.
    #[serde(default)]
    areas: Vec<RaisedArea>,
}

/// The module status of a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
struct RaisedModule {
    slot: u16,
    state: ModuleState,
}

/// A fault of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
struct RaisedChannel {
    slot: u16,
    #[cfg_attr(test, schema(maximum = 63))]
    channel: u8,
    direction: Direction,
    width: Width,
    /// 1 to 9 of the standard, 16 to 31 of the GSD.
    #[cfg_attr(test, schema(minimum = 1, maximum = 31))]
    error: u8,
}

impl RaisedDiagnosis {
    pub(super) fn of(raised: &Raised) -> Self {
        let channel = |fault: &ChannelFault| {
            let ChannelFault { slot, channel, direction, width, error } = *fault;
            RaisedChannel { slot, channel, direction, width, error: error.number() }
        };
        let module = |(slot, state): (&u16, &ModuleState)| RaisedModule { slot: *slot, state: *state };
        let area = |(first_bit, value): (&u16, &u32)| RaisedArea { first_bit: *first_bit, value: *value };
        let status = |(number, status): (&u8, &Status)| RaisedStatus {
            number: *number,
            bits: status.bits.iter().copied().collect(),
            areas: status.areas.iter().map(area).collect(),
        };
        Self {
            bits: raised.bits.iter().copied().collect(),
            areas: raised.areas.iter().map(area).collect(),
            statuses: raised.statuses.iter().map(status).collect(),
            identifiers: raised.identifiers.iter().copied().collect(),
            modules: raised.modules.iter().map(module).collect(),
            channels: raised.channels.iter().map(channel).collect(),
            octets: raised.octets.clone(),
            not_valid: raised.not_valid,
        }
    }

    /// As the station takes it.
    pub(super) fn raised(&self) -> Result<Raised, Problem> {
        let channel = |fault: &RaisedChannel| {
            let RaisedChannel { slot, channel, direction, width, error } = *fault;
            let error = ChannelError::numbered(error).ok_or_else(|| {
                Problem::value(format!(
                    "{error} is no error of a channel; expected 1 to 9 of the standard or 16 to 31 of the GSD"
                ))
            })?;
            Ok::<_, Problem>(ChannelFault { slot, channel, direction, width, error })
        };
        Ok(Raised {
            bits: self.bits.iter().copied().collect(),
            areas: values(&self.areas),
            statuses: self.statuses.iter().map(|status| (status.number, status.status())).collect(),
            identifiers: self.identifiers.iter().copied().collect(),
            modules: self.modules.iter().map(|module| (module.slot, module.state)).collect(),
            channels: self.channels.iter().map(channel).collect::<Result<_, _>>()?,
            octets: self.octets.clone(),
            not_valid: self.not_valid,
        })
    }
}

impl RaisedStatus {
    fn status(&self) -> Status {
        Status { bits: self.bits.iter().copied().collect(), areas: values(&self.areas) }
    }
}

fn values(areas: &[RaisedArea]) -> BTreeMap<u16, u32> {
    areas.iter().map(|area| (area.first_bit, area.value)).collect()
}

impl Diagnosis {
    /// What was raised, in the texts of the file, and what Slave_Diag reports.
    pub(in crate::panel) fn of(
        raised: &Raised,
        texts: Vec<String>,
        diag: dp::Diagnosis,
        ext: &ExtDiag,
    ) -> Self {
        let mut octets = diag.octets().to_vec();
        octets.extend_from_slice(ext.octets());
        Self { raised: RaisedDiagnosis::of(raised), texts, octets, overflow: ext.overflow() }
    }
}

/// The texts that a GSD has for a diagnosis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct Possible {
    bits: Vec<TextOf>,
    areas: Vec<TextsOfArea>,
    /// Status blocks of the types of the file (UnitDiagType).
    statuses: Vec<TextsOfStatus>,
    /// The errors of channels, those of the standard first.
    channel_errors: Vec<TextOf>,
}

/// A number and its text.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct TextOf {
    number: i64,
    text: String,
}

/// The texts of a number in the diagnosis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct TextsOfArea {
    first_bit: u16,
    last_bit: u16,
    values: Vec<TextOf>,
}

/// The texts of a status block.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
struct TextsOfStatus {
    #[serde(rename = "type")]
    number: u8,
    bits: Vec<TextOf>,
    areas: Vec<TextsOfArea>,
}

impl Possible {
    pub(super) fn of(gsd: &Gsd) -> Self {
        let text = |number: i64, text: &str| TextOf { number, text: text.into() };
        let standard = (1..=9).filter_map(ChannelError::numbered);
        let standard = standard.filter_map(|error| Some(text(error.number().into(), error.words()?)));
        let own = gsd.channel_diag.iter().map(|(number, words)| text((*number).into(), words));
        let bits = |bits: &[DiagBit]| bits.iter().map(|bit| text(bit.bit.into(), &bit.text)).collect();
        let area = |area: &DiagArea| TextsOfArea {
            first_bit: area.first,
            last_bit: area.last,
            values: area.values.iter().map(|(value, words)| text(*value, words)).collect(),
        };
        let areas = |areas: &[DiagArea]| areas.iter().map(area).collect();
        let statuses = gsd.diag_types.iter().map(|status| TextsOfStatus {
            number: status.number,
            bits: bits(&status.bits),
            areas: areas(&status.areas),
        });
        Self {
            bits: bits(&gsd.diag_bits),
            areas: areas(&gsd.diag_areas),
            statuses: statuses.collect(),
            channel_errors: standard.chain(own).collect(),
        }
    }
}
