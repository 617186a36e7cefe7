//! What surrounds a drive, and what is seen of it, on either bus: its inputs, keys, and the faults that can be made.

use core::fmt;

use super::drive::{Drive, Fault, FaultSet, Inputs, StatusLed};
use super::param::Model;
use super::unit::{Power, Unit};
use crate::can_bus::canopen::Address;
use crate::face::surroundings::{Declined, Face, Glow, Input, InputKind, Level, Provocable, Surroundings};
use crate::face::{DriveState, Turning, Why};
use crate::time::Instant;

/// The unit behind a bus: what differs there.
pub(crate) trait BehindBus: Why + 'static {
    /// Whether both models are on this bus.
    const BOTH_MODELS: bool;

    /// The unit.
    fn unit(&self) -> &Unit;

    /// Which model it is.
    fn model(&self) -> Model;

    /// Changes what acts on it from outside.
    fn change_inputs(&mut self, now: Instant, inputs: Inputs);

    /// The bus LED of a unit that is on.
    fn bus_led(&self) -> Glow;

    /// The state of a drive that is on.
    fn state_on_bus(&self) -> DriveState;

    /// On CANopen the entries that are words of bits.
    fn word_entries(&self) -> &'static [Address] {
        &[]
    }

    /// On CANopen how a master turns it with a velocity, and inches.
    fn turning_on_bus(&self) -> Option<Turning> {
        None
    }

    /// The mode as the words of the bus count it.
    fn mode_on_bus(&self) -> i64 {
        0
    }
}

impl<T: BehindBus> Surroundings for T {
    fn each_fault(&self, tell: &mut dyn FnMut(Provocable<'_>)) {
        let drive = self.unit().drive();
        let causes = [drive.causes(), drive.provoked_by(self.unit().inputs())];
        each_fault(self.model(), causes, tell);
    }

    fn provoke(&mut self, now: Instant, name: &str) -> Result<(), Declined> {
        let fault = fault(self.model(), name)?;
        let inputs = self.unit().drive().provoking(self.unit().inputs(), fault);
        self.change_inputs(now, inputs);
        Ok(())
    }

    fn take_back(&mut self, now: Instant, name: &str) -> Result<(), Declined> {
        let fault = fault(self.model(), name)?;
        let inputs = self.unit().drive().relieved(self.unit().inputs(), fault);
        self.change_inputs(now, inputs);
        Ok(())
    }

    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        for row in ROWS.iter().filter(|row| row.is_of(self.model())) {
            tell(&row.input, (row.read)(self.unit().inputs()));
        }
    }

    fn set_input(&mut self, now: Instant, name: &str, level: Level) {
        let row = ROWS.iter().find(|row| row.input.name == name && row.is_of(self.model()));
        let mut inputs = *self.unit().inputs();
        if let Some(row) = row {
            (row.write)(&mut inputs, level);
            self.change_inputs(now, inputs);
        }
    }

    fn nominal(&self, name: &str) -> Option<Level> {
        let row = ROWS.iter().find(|row| row.input.name == name)?;
        Some((row.read)(&Inputs::default()))
    }

    fn calculated(&self, name: &str) -> Option<f64> {
        calculated(self.unit().drive(), name)
    }

    fn make_nominal(&mut self, now: Instant) {
        self.change_inputs(now, nominal(self.unit().inputs()));
    }

    fn each_lack(&self, name: &str, say: &mut dyn FnMut(&dyn fmt::Display)) {
        if T::BOTH_MODELS {
            each_lack(self.model(), name, say);
        }
    }

    fn each_key(&self, tell: &mut dyn FnMut(&'static str, bool)) {
        let ([one, two], inputs) = (KEYS, self.unit().inputs());
        tell(one, inputs.key_clockwise);
        tell(two, inputs.key_counter_clockwise);
    }

    fn press(&mut self, now: Instant, key: &str, down: bool) -> Result<(), Declined> {
        self.change_inputs(now, with_key(self.unit().inputs(), key, down)?);
        Ok(())
    }

    fn face(&self, _now: Instant) -> Face {
        let (status, bus) = match self.unit().power() {
            Power::Off => (Glow::Off, Glow::Off),
            Power::FactoryReset(_) => (Glow::Alternating, Glow::Alternating),
            Power::On => (glow(self.unit().status().led), self.bus_led()),
        };
        Face::default().led("status green", status).led("bus orange", bus)
    }

    fn words(&self) -> &'static [Address] {
        self.word_entries()
    }

    fn mode(&self) -> i64 {
        self.mode_on_bus()
    }

    fn turning(&self) -> Option<Turning> {
        self.turning_on_bus()
    }

    fn is_drive(&self) -> bool {
        true
    }

    fn drive_state(&self) -> Option<DriveState> {
        Some(self.state_on_bus())
    }

    fn why(&self) -> Option<&dyn Why> {
        Some(self)
    }
}

/// One input: what it is, and where the drive has it.
struct Row {
    input: Input,
    /// The one model that has it; `None`: both have.
    only: Option<Model>,
    read: fn(&Inputs) -> Level,
    write: fn(&mut Inputs, Level),
}

impl Row {
    const fn of(self, model: Model) -> Self {
        Self { only: Some(model), ..self }
    }

    fn is_of(&self, model: Model) -> bool {
        self.only.is_none_or(|only| only == model)
    }
}

/// A row of the table by the kind of its field.
macro_rules! row {
    (switch $name:literal, $about:literal, $field:ident) => {
        Row {
            input: Input { name: $name, about: $about, kind: InputKind::Switch },
            only: None,
            read: |inputs| Level::Switch(inputs.$field),
            write: |inputs, level| {
                if let Level::Switch(on) = level {
                    inputs.$field = on;
                }
            },
        }
    };
    (number $name:literal, $about:literal, $field:ident, $low:literal, $high:literal) => {
        Row {
            input: Input {
                name: $name,
                about: $about,
                kind: InputKind::Number { low: $low, high: $high, own: false },
            },
            only: None,
            read: |inputs| Level::Number(inputs.$field),
            write: |inputs, level| {
                if let Level::Number(number) = level {
                    inputs.$field = number;
                }
            },
        }
    };
    (own $name:literal, $about:literal, $field:ident, $low:literal, $high:literal) => {
        Row {
            input: Input {
                name: $name,
                about: $about,
                kind: InputKind::Number { low: $low, high: $high, own: true },
            },
            only: None,
            read: |inputs| inputs.$field.map_or(Level::Own, Level::Number),
            write: |inputs, level| match level {
                Level::Own => inputs.$field = None,
                Level::Number(number) => inputs.$field = Some(number),
                Level::Switch(_) => {}
            },
        }
    };
}

/// The inputs, as [`Inputs`] has them.
const ROWS: &[Row] = &[
    row!(number "control_supply_volts", "supply of the control", control_supply, 0.0, 60.0),
    row!(number "output_supply_volts", "supply of the output stage", output_supply, 0.0, 60.0)
        .of(Model::Ag03_1),
    row!(switch "enable", "the enable input", enable_input).of(Model::Ag03),
    row!(number "battery_volts", "battery of the encoder", battery, 0.0, 10.0),
    row!(number "load_torque_newton_metres", "load that pulls the shaft clockwise", load_torque, -1000.0, 1000.0),
    row!(number "friction_torque_newton_metres", "friction in both directions", friction_torque, 0.0, 1000.0),
    row!(switch "blocked", "the shaft is blocked", blocked),
    row!(number "ambient_temperature_celsius", "temperature of the air", ambient, -50.0, 200.0),
    row!(own "stage_temperature_celsius", "temperature of the output stage", stage_temperature, -50.0, 200.0),
    row!(own "dc_link_volts", "voltage of the intermediate circuit", dc_link, 0.0, 100.0),
    row!(switch "encoder_fault", "error of the SIN/COS monitoring", encoder_fault).of(Model::Ag03_1),
    row!(switch "internal_fault", "internal error", internal_fault),
];

/// The keys of the manual setup mode: clockwise, counter-clockwise.
const KEYS: [&str; 2] = ["key_1", "key_2"];

/// What follows for an input from everything else.
fn calculated(drive: &Drive, name: &str) -> Option<f64> {
    let measured = drive.measured();
    let tenths: f64 = match name {
        "stage_temperature_celsius" => measured.temperature.into(),
        "dc_link_volts" => measured.dc_link.into(),
        _ => return None,
    };
    Some(tenths / 10.0)
}

/// Everything as it should be; the keys stay as they are.
fn nominal(inputs: &Inputs) -> Inputs {
    let Inputs { key_clockwise, key_counter_clockwise, .. } = *inputs;
    Inputs { key_clockwise, key_counter_clockwise, ..Inputs::default() }
}

/// Says why a model does not have an input or a fault that the other one has.
fn each_lack(model: Model, name: &str, say: &mut dyn FnMut(&dyn fmt::Display)) {
    let lacks = ROWS.iter().any(|row| row.input.name == name && !row.is_of(model));
    match (model, name) {
        (Model::Ag03, "output_supply_volts") => {
            say(&"an AG03 has one supply only; set control_supply_volts");
        }
        (Model::Ag03, _) if lacks => {
            say(&"an AG03 has no SIN/COS monitoring of its encoder; an AG03/1 has");
        }
        (Model::Ag03_1, _) if lacks => {
            say(&"an AG03/1 has no enable input; set output_supply_volts to 0");
        }
        (Model::Ag03, _) => {
            let other = fault(Model::Ag03_1, name).ok().filter(|fault| !fault.exists_on(model));
            if let Some(fault) = other {
                say(&format_args!("an AG03 has no fault {fault}; an AG03/1 has"));
            }
        }
        (Model::Ag03_1, _) => {}
    }
}

/// Each fault of a model, with the causes that are there, and what the inputs make.
fn each_fault(model: Model, [causes, provoked]: [FaultSet; 2], tell: &mut dyn FnMut(Provocable<'_>)) {
    for fault in Fault::ALL.into_iter().filter(|fault| fault.exists_on(model)) {
        let name = char::from(fault.code());
        let provoked = provoked.contains(fault);
        tell(Provocable { name: &name, text: &fault, present: provoked || causes.contains(fault), provoked });
    }
}

/// The fault of a model by its letter.
fn fault(model: Model, name: &str) -> Result<Fault, Declined> {
    let named = |known: &Fault| *name.as_bytes() == [known.code()] && known.exists_on(model);
    Fault::ALL.into_iter().find(named).ok_or(Declined::Unknown)
}

/// The inputs with a key up or down.
fn with_key(inputs: &Inputs, key: &str, down: bool) -> Result<Inputs, Declined> {
    match KEYS.iter().position(|known| *known == key) {
        Some(0) => Ok(Inputs { key_clockwise: down, ..*inputs }),
        Some(_) => Ok(Inputs { key_counter_clockwise: down, ..*inputs }),
        None => Err(Declined::Unknown),
    }
}

/// What the status LED does.
fn glow(led: StatusLed) -> Glow {
    match led {
        StatusLed::Off => Glow::Off,
        StatusLed::On => Glow::On,
        StatusLed::Blinking(fault) => Glow::Code(fault.blinks()),
    }
}
