//! What is wrong with a drive, and what stands against a start.

use serde::Serialize;
use utoipa::ToSchema;

use super::seconds;
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::Fault;
use crate::devices::ag03::profibus::{Device, Refusal};
use crate::face::{Reason, Why};
use crate::time::Instant;

/// A fault by its letter; H and I exist only on CANopen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(in crate::panel) enum FaultName {
    A,
    B,
    C,
    D,
    E,
    F,
    G,
    H,
    I,
    J,
}

/// Warnings: they vanish by themselves (manual chapter 5.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(super) struct Warnings {
    battery_low: bool,
    current_out_of_range: bool,
    lag_error: bool,
}

/// Faults, latched and remembered.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Faults {
    /// The latched fault, of several the latest.
    latched: Option<FaultText>,
    /// The causes that are present now: they must go before a fault can be acknowledged.
    causes: Vec<FaultText>,
    /// What the inputs make as they are set, at once or as soon as the shaft is commanded to turn: acknowledged, it comes back.
    provoked: Vec<FaultText>,
    /// PNU 945: the last ten, in the order the drive lists them.
    buffer: Vec<FaultText>,
    /// PNU 952.
    count: u16,
}

/// A fault in words.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct FaultText {
    code: FaultName,
    text: String,
    /// How often the status LED blinks for it.
    blinks: u8,
}

/// What stands against a start (an edge of STW.6, in velocity mode its level).
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Start {
    /// A start with the newest outputs would be carried out.
    possible: bool,
    reasons: Vec<ReasonText>,
    /// The control words to send one after the other; `null`: none helps before the reasons are changed.
    next: Option<String>,
}

/// One condition that is not met.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct ReasonText {
    /// A name that stays, for programs.
    reason: String,
    /// A sentence with numbers.
    text: String,
}

/// A request that was refused.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(in crate::panel) struct LastRefusal {
    pub(in crate::panel) time_seconds: f64,
    /// One line: the request and every unmet condition.
    text: String,
    reasons: Vec<ReasonText>,
}

impl Warnings {
    pub(super) const fn of(status: &drive::Status) -> Self {
        Self {
            battery_low: status.battery_low,
            current_out_of_range: status.current_out_of_range,
            lag_error: status.lag_error,
        }
    }
}

impl Faults {
    pub(super) fn of(device: &Device) -> Self {
        let drive = device.drive();
        let of_code = |code: u8| Fault::ALL.into_iter().find(|fault| fault.code() == code);
        Self {
            latched: drive.status().fault.map(FaultText::from),
            causes: drive.causes().iter().map(FaultText::from).collect(),
            provoked: drive.provoked_by(device.inputs()).iter().map(FaultText::from).collect(),
            buffer: device.fault_codes().into_iter().filter_map(of_code).map(FaultText::from).collect(),
            count: drive.faults().count(),
        }
    }
}

impl Start {
    pub(super) fn of(device: &Device) -> Self {
        let reasons = ReasonText::all(|tell| device.each_against_start(tell));
        Self { possible: reasons.is_empty(), reasons, next: next_of(device) }
    }
}

/// The words to send, of whatever is asked why it does not move.
pub(in crate::panel) fn next_of(why: &dyn Why) -> Option<String> {
    let mut next = None;
    why.next(&mut |words| next = Some(words.to_string()));
    next
}

impl ReasonText {
    /// All that is told.
    pub(in crate::panel) fn all(each: impl FnOnce(&mut dyn FnMut(Reason<'_>))) -> Vec<Self> {
        let mut reasons = Vec::new();
        each(&mut |reason| reasons.push(Self { reason: reason.name.into(), text: reason.to_string() }));
        reasons
    }
}

impl LastRefusal {
    pub(in crate::panel) fn of(refusal: &Refusal, at: Instant) -> Self {
        Self { time_seconds: seconds(at), text: refusal.to_string(), reasons: reasons_of(refusal) }
    }
}

pub(in crate::panel) fn reasons_of(refusal: &Refusal) -> Vec<ReasonText> {
    ReasonText::all(|tell| refusal.each_reason(tell))
}

impl From<Fault> for FaultText {
    fn from(fault: Fault) -> Self {
        Self { code: fault.into(), text: fault.to_string(), blinks: fault.blinks() }
    }
}

impl From<Fault> for FaultName {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::A => Self::A,
            Fault::B => Self::B,
            Fault::C => Self::C,
            Fault::D => Self::D,
            Fault::E => Self::E,
            Fault::F => Self::F,
            Fault::G => Self::G,
            Fault::H => Self::H,
            Fault::I => Self::I,
            Fault::J => Self::J,
        }
    }
}
