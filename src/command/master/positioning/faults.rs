//! `faults` and `calibrate`: what PNU 970 commands beside the parameter sets.

use crate::devices::ag03::param::{
    CALIBRATE, CLEAR_FAULTS, LOAD_PARAMETER_SET, Parameter, Reading, Subindex, TABLE, Value,
};
use crate::explain::value::Lengths;
use crate::host::{Clock, Link};
use crate::master::Drive;
use serde_json::json;

use super::access::refusal;
use super::value::{Item, fits, lengths, number_of};
use crate::command::Failure;
use crate::command::args::Quantity;
use crate::command::master::say;

/// The fault buffer in words.
pub(super) fn faults<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    clear: bool,
    json: bool,
) -> Result<(), Failure> {
    if clear {
        command(drive, CLEAR_FAULTS)?;
    }
    let mut faults = Vec::new();
    let buffer = Reading::FaultBuffer.entry();
    let count = Item::read(drive, Reading::FaultCount.entry(), None)?.number();
    for element in 0..buffer.elements.unwrap_or_default() {
        let item = Item::read(drive, buffer, Some(Subindex(element)))?;
        if item.number() != 0 {
            faults.push(item);
        }
    }
    if json {
        let faults: Vec<_> = faults.iter().map(|item| item.json(Lengths::Unknown)).collect();
        return say(json!({ "count": count, "faults": faults }));
    }
    let cleared = if clear { "cleared; " } else { "" };
    let faults_of = if count == 1 { "fault" } else { "faults" };
    say(format_args!("{cleared}{count} {faults_of} since the buffer was cleared, newest first:"))?;
    if faults.is_empty() {
        return say("  none");
    }
    for item in faults {
        say(format_args!("  {:<6} {}", item.place(), item.text(Lengths::Unknown)))?;
    }
    Ok(())
}

/// Sets the position to the calibration value.
pub(super) fn calibrate<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    value: Option<Quantity>,
    json: bool,
) -> Result<(), Failure> {
    let calibration = Parameter::CalibrationValue.entry();
    let position = Reading::Position.entry();
    let before = drive.read(position.pnu, None, position.width)?.bits().cast_signed();
    if let Some(wanted) = value {
        fits(&wanted, lengths(drive)?)?;
        let number = number_of(&wanted, calibration)?;
        drive
            .write(calibration.pnu, Value::of(calibration.width, i32::try_from(number).unwrap_or(i32::MAX)))
            .map_err(|trouble| refusal(drive, trouble, calibration, Some(number)))?;
    }
    let wanted = drive.read(calibration.pnu, None, calibration.width)?.bits().cast_signed();
    command(drive, CALIBRATE)?;
    // The drive calibrates in one of its cycles and shows it in the next.
    drive.exchange()?;
    drive.exchange()?;
    let after = drive.read(position.pnu, None, position.width)?.bits().cast_signed();
    let lengths = lengths(drive)?;
    if json {
        return say(json!({ "before": before, "calibration_value": wanted, "position": after }));
    }
    let text = |position: i32| lengths.position(position.into());
    say(format_args!("calibrated: position {}, was {}", text(after), text(before)))
}

fn command<L: Link, C: Clock>(drive: &mut Drive<L, C>, command: u16) -> Result<(), Failure> {
    let entry = TABLE.iter().find(|entry| entry.pnu == LOAD_PARAMETER_SET);
    match (drive.write(LOAD_PARAMETER_SET, Value::Word(command)), entry) {
        (Ok(_), _) => Ok(()),
        (Err(trouble), Some(entry)) => Err(refusal(drive, trouble, entry, Some(command.into()))),
        (Err(trouble), None) => Err(trouble.into()),
    }
}
