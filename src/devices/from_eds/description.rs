//! Values and inputs of a node from a file. Those that the device only tells are set from outside: what it measures is the
//! business of whoever tests a master.

use core::fmt;

use super::dictionary::{Dictionary, Role, Row};
use super::drive::Axis;
use super::names::{self, FaultName, OfAxis};
use super::{Behaviour, FromEds};
use crate::can_bus::canopen::value::{DataType, ValueKind};
use crate::can_bus::canopen::{Address, Value};
use crate::can_bus::cia402::Mode;
use crate::devices::cia402_drive::{Actual, Drive, Fault};
use crate::face::description::{self, Amount, Curve, Description, Group};
use crate::face::surroundings::{Declined, Input, Level, Provocable, Surroundings};
use crate::face::{AnyDeviceEvent, DriveState, Turning, Why};
use crate::time::Instant;

impl FromEds {
    fn number(&self, place: usize, row: &Row) -> Option<f64> {
        self.told(row).or_else(|| self.memory.read(place, row)).and_then(as_f64)
    }

    /// What comes from outside: the level at the terminals, steps of the shaft, or the value itself.
    fn outside(&self, place: usize, row: &Row) -> Option<f64> {
        match (row.role, &self.behaviour) {
            (Role::Encoder(_), Behaviour::Encoder(encoder)) => Some(encoder.shaft() as f64),
            (_, _) => self.shown(place, row),
        }
    }

    /// What people see: of digital outputs the level at the terminals.
    fn shown(&self, place: usize, row: &Row) -> Option<f64> {
        if let (Role::Io(point), Behaviour::Io(io)) = (row.role, &self.behaviour)
            && let Some(lines) = io.at_terminal(point)
        {
            return Some(lines as f64);
        }
        self.number(place, row)
    }

    fn set_outside(&mut self, now: Instant, place: usize, row: &Row, number: f64) {
        if let Some(value) = of_f64(row.table.data, number) {
            // A number is never too long.
            let _ = value.with_octets(|octets| self.memory.set(place, row, octets));
        }
        match row.role {
            Role::Io(point) => self.io_input(now, place, point, number),
            Role::Encoder(_) => self.turn_shaft(now, number),
            Role::Value | Role::Setting(..) | Role::Actual(..) => {}
        }
    }

    /// Every value from outside is as the file says.
    pub(super) fn make_inputs_nominal(&mut self, now: Instant) {
        for (place, row, _) in inputs(self.dictionary) {
            self.memory.make_default(place, row);
            if let Some(number) = self.memory.read(place, row).and_then(as_f64) {
                self.set_outside(now, place, row, number);
            }
        }
    }

    fn drive(&self) -> Option<&Drive> {
        Some(&self.driven()?.axes.first()?.drive)
    }

    /// Those of a drive.
    fn axes(&self) -> &[Axis] {
        self.driven().map_or(&[], |driven| &driven.axes)
    }
}

/// What is set from outside.
fn inputs(dictionary: &'static Dictionary) -> impl Iterator<Item = (usize, &'static Row, &'static Input)> {
    let rows = dictionary.rows.iter().enumerate();
    rows.filter_map(|(place, row)| Some((place, row, row.input.as_ref()?)))
}

impl Surroundings for FromEds {
    fn each_fault(&self, tell: &mut dyn FnMut(Provocable<'_>)) {
        for axis in self.axes() {
            for fault in Fault::all() {
                let present = axis.drive.fault() == Some(fault);
                tell(Provocable {
                    name: &FaultName(axis.number(), fault),
                    text: &OfAxis(axis.number(), fault.text()),
                    present,
                    provoked: present,
                });
            }
        }
    }

    fn provoke(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        let driven = self.driven_mut().ok_or(Declined::Unknown)?;
        let (axis, fault) = names::of_first(fault);
        let fault = Fault::named(fault).ok_or(Declined::Unknown)?;
        driven.axis(axis).ok_or(Declined::Unknown)?;
        if driven.nmt.is_none() {
            return Err(Declined::SwitchedOff);
        }
        driven.advance(now);
        if let Some(axis) = driven.axis_mut(axis) {
            axis.drive.raise(fault);
        }
        Ok(())
    }

    fn take_back(&mut self, _: Instant, fault: &str) -> Result<(), Declined> {
        // Only its reset ends a fault whose cause was a moment.
        let (axis, fault) = names::of_first(fault);
        let known = self.driven().and_then(|driven| driven.axis(axis)).and_then(|_| Fault::named(fault));
        known.map(|_| ()).ok_or(Declined::Unknown)
    }

    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        for (axis, names) in self.axes().iter().zip(&self.dictionary.axes) {
            axis.drive.each_input(&mut |input, level| tell(&names.input(input), level));
        }
        for (place, row, input) in inputs(self.dictionary) {
            let number = self.outside(place, row).unwrap_or_default();
            let is_switch = row.table.data == DataType::Boolean;
            tell(input, if is_switch { Level::Switch(number != 0.0) } else { Level::Number(number) });
        }
    }

    fn set_input(&mut self, now: Instant, name: &str, level: Level) {
        let (axis, of_axis) = names::of_first(name);
        let axis = self.driven_mut().and_then(|driven| driven.axis_mut(axis));
        if axis.is_some_and(|axis| axis.drive.set_input(of_axis, level)) {
            return;
        }
        let Some((place, row, _)) = inputs(self.dictionary).find(|(_, _, input)| input.name == name) else {
            return;
        };
        let number = match level {
            Level::Switch(on) => f64::from(u8::from(on)),
            Level::Number(number) => number,
            Level::Own => return,
        };
        self.set_outside(now, place, row, number);
    }

    fn nominal(&self, name: &str) -> Option<Level> {
        let (axis, of_axis) = names::of_first(name);
        let axis = self.driven().and_then(|driven| driven.axis(axis));
        if let Some(level) = axis.and_then(|_| Drive::nominal(of_axis)) {
            return Some(level);
        }
        let (_, row, _) = inputs(self.dictionary).find(|(_, _, input)| input.name == name)?;
        let octets = row.file.octets(self.node);
        let number = row.table.data.decode(&octets).and_then(as_f64)?;
        let is_switch = row.table.data == DataType::Boolean;
        Some(if is_switch { Level::Switch(number != 0.0) } else { Level::Number(number) })
    }

    fn make_nominal(&mut self, now: Instant) {
        if let Some(driven) = self.driven_mut() {
            driven.axes.iter_mut().for_each(|axis| axis.drive.make_nominal());
        }
        self.make_inputs_nominal(now);
    }

    fn words(&self) -> &'static [Address] {
        &self.dictionary.words
    }

    fn turning(&self) -> Option<Turning> {
        let offered = [(Mode::ProfileVelocity, 0x60FF), (Mode::Velocity, 0x6042)];
        let drive = self.drive()?;
        offered.into_iter().find_map(|(mode, index)| {
            let target = Address::new(index, 0);
            let row = self.dictionary.rows.get(self.dictionary.place(target)?)?;
            let (low, high) = row.table.data.range()?;
            let bound = |bound: i64| i32::try_from(bound).ok();
            let range = (bound(low)?, bound(high)?);
            drive.offers(mode.code().into()).then_some(Turning {
                mode,
                target,
                unit: "",
                range,
                inching: None,
            })
        })
    }

    fn is_drive(&self) -> bool {
        self.driven().is_some()
    }

    fn drive_state(&self) -> Option<DriveState> {
        let driven = self.driven()?;
        // The axis in a fault, or the first.
        let axis = driven.axes.iter().find(|axis| axis.drive.fault().is_some()).or(driven.axes.first())?;
        Some(driven.nmt.map_or(DriveState::Off, |_| axis.drive.state().into()))
    }

    fn why(&self) -> Option<&dyn Why> {
        Some(self.driven()?)
    }

    fn mode(&self) -> i64 {
        if let Some(drive) = self.drive() {
            return drive.mode().map_or(0, Mode::code).into();
        }
        let shown = self.dictionary.place(Address::new(0x6061, 0));
        let value = shown.and_then(|place| self.memory.read(place, self.dictionary.rows.get(place)?));
        value.and_then(Value::number).unwrap_or_default()
    }
}

impl Description for FromEds {
    fn poll_news(&mut self) -> Option<AnyDeviceEvent> {
        self.driven_mut()?.axes.iter_mut().find_map(|axis| {
            let news = axis.drive.poll_news()?;
            Some(match axis.number() {
                0 => AnyDeviceEvent::new(news),
                further => AnyDeviceEvent::new(OfAxis(further, news)),
            })
        })
    }

    fn say_state(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
        match self.axes() {
            [] => {}
            [only] => say(&only.drive.state()),
            several => {
                let states =
                    several.iter().map(|axis| format!("axis {}: {}", axis.number() + 1, axis.drive.state()));
                say(&states.collect::<Vec<_>>().join(", "));
            }
        }
    }

    fn tell_fault(&self, tell: &mut dyn FnMut(&dyn fmt::Display, &dyn fmt::Display)) {
        let fault = |axis: &Axis| Some((axis.number(), axis.drive.fault()?));
        if let Some((axis, fault)) = self.axes().iter().find_map(fault) {
            tell(&format_args!("{:04X}", fault.0), &OfAxis(axis, fault.text()));
        }
    }

    fn each_value(&self, tell: &mut dyn FnMut(description::Value<'_>)) {
        for (axis, names) in self.axes().iter().zip(&self.dictionary.axes) {
            axis.each_motion(&mut |value| tell(names.value(value)));
        }
        for (place, row) in self.dictionary.rows.iter().enumerate() {
            let Some(key) = row.key else { continue };
            let amount = Amount::from(self.shown(place, row));
            let value = description::Value::new(key, row.table.name, Group::Measured, amount);
            let curve = if row.curve { Curve::Own } else { Curve::None };
            tell(description::Value { headline: row.headline, ..value.curve(curve) });
        }
    }
}

impl Axis {
    /// Where the shaft is, how fast and how strong, whatever objects the file has for it. A list of devices shows the first axis.
    pub(super) fn each_motion(&self, tell: &mut dyn FnMut(description::Value<'_>)) {
        let (drive, headline) = (&self.drive, self.number() == 0);
        let value = |key, name, amount| {
            description::Value::new(key, name, Group::Motion, Amount::Number(amount)).curve(Curve::Own)
        };
        let units = |actual| drive.actual(actual) as f64;
        let position = value("position", "Position", units(Actual::Position));
        tell(description::Value { headline, ..position });
        let speed = value("speed", "Speed", drive.motor_rpm()).unit("rpm").digits(1);
        tell(description::Value { headline, ..speed });
        tell(value("torque", "Torque", drive.torque_percent()).unit("%").digits(1));
        let target = value("target", "Position demanded", units(Actual::PositionDemand));
        tell(target.curve(Curve::SetpointOf("position")));
        let error = value("following_error", "Following error", units(Actual::FollowingError));
        tell(error.curve(Curve::None));
    }
}

#[expect(clippy::cast_precision_loss, reason = "for people")]
pub(super) fn as_f64(value: Value<'_>) -> Option<f64> {
    if let Value::Real32(number) = value {
        Some(number.into())
    } else if let Value::Real64(number) = value {
        Some(number)
    } else if let Value::U64(number) = value {
        Some(number as f64)
    } else {
        value.number().map(|number| number as f64)
    }
}

/// The nearest value of a type.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "casts of numbers saturate")]
pub(super) fn of_f64(data: DataType, number: f64) -> Option<Value<'static>> {
    Some(match (data.kind(), data) {
        (ValueKind::Real, DataType::Real32) => Value::Real32(number as f32),
        (ValueKind::Real, _) => Value::Real64(number),
        (_, DataType::U64) => Value::U64(number.round() as u64),
        (ValueKind::Boolean | ValueKind::Signed | ValueKind::Unsigned, _) => {
            let (low, high) = data.range()?;
            Value::whole(data, (number.round() as i64).clamp(low, high))?
        }
        (ValueKind::Text | ValueKind::Octets, _) => return None,
    })
}
