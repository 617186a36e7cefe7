//! The whole drive, row by row of `ag03.md` section 8.

mod bus_and_faults;
mod fuzz;
mod load;
mod positioning;
mod quirks;
mod ramps;
mod table;
mod travels;
mod velocity;
mod words;

use core::time::Duration;

use super::settings::defaults;
use super::*;
use words::{command, zsw};

const MILLISECOND: Duration = Duration::from_millis(1);

/// A drive with its settings and the control word that is applied to it.
#[derive(Clone)]
struct Rig {
    drive: Drive,
    settings: Settings,
    connected: bool,
    stw: u16,
    /// The control word of the step before.
    before: u16,
    setpoint: i32,
}

impl Rig {
    /// Just powered on, in Data_Exchange, STW = 0.
    fn new(model: Model) -> Self {
        Self::with(model, defaults())
    }

    fn with(model: Model, settings: Settings) -> Self {
        Self::made(model, Gear::Ratio48, settings, Config::default())
    }

    fn made(model: Model, gear: Gear, settings: Settings, config: Config) -> Self {
        let drive = Drive::with(model, gear, &settings, config);
        Self { drive, settings, connected: true, stw: 0, before: 0, setpoint: 0 }
    }

    /// Operation enabled in positioning mode, prepared for jobs.
    fn enabled() -> Self {
        let mut rig = Self::new(Model::Ag03_1);
        rig.stw(0x003b);
        assert_eq!(rig.state(), State::OperationEnabled(Motor::InControl));
        rig
    }

    /// On its way to `setpoint` since 500 ms, at full speed.
    fn travelling(setpoint: i32) -> Self {
        let mut rig = Self::enabled();
        rig.travel(setpoint);
        rig.run(499);
        rig.drive.take_refusal();
        rig
    }

    fn in_fault(fault: Fault) -> Self {
        let mut rig = Self::travelling(100_000);
        rig.causes([fault]);
        rig
    }

    /// Applies a control word for one cycle.
    fn stw(&mut self, stw: u16) -> &mut Self {
        self.stw = stw;
        self.run(1)
    }

    /// Lets STW.6 change, with this setpoint.
    fn travel(&mut self, setpoint: i32) -> &mut Self {
        self.setpoint = setpoint;
        self.stw(self.stw ^ 0x0040)
    }

    fn run(&mut self, cycles: u32) -> &mut Self {
        for _ in 0..cycles {
            self.step(MILLISECOND);
        }
        self
    }

    fn step(&mut self, dt: Duration) {
        let stw = self.connected.then_some(self.stw);
        let command = command(self.before, stw, self.setpoint);
        self.before = stw.unwrap_or(0);
        self.drive.step(dt, &command, &self.settings);
    }

    fn until(&mut self, state: State) -> u32 {
        for cycle in 0..1_000_000 {
            if self.state() == state {
                return cycle;
            }
            self.run(1);
        }
        panic!("still {:?}, not {state:?}", self.state());
    }

    /// Changes the inputs, and runs one cycle.
    fn inputs(&mut self, change: impl FnOnce(&mut Inputs)) -> &mut Self {
        let mut inputs = self.drive.inputs();
        change(&mut inputs);
        self.drive.set_inputs(inputs);
        self.run(1)
    }

    /// Makes the causes of these faults and of no other, of those that follow at once.
    fn causes<const N: usize>(&mut self, faults: [Fault; N]) -> &mut Self {
        self.inputs(|inputs| {
            let nominal = Inputs::default();
            inputs.stage_temperature = None;
            inputs.dc_link = None;
            inputs.encoder_fault = false;
            inputs.internal_fault = false;
            inputs.battery = nominal.battery;
            for fault in faults {
                assert!(!matches!(fault, Fault::A | Fault::B | Fault::C), "{fault} needs motion");
                *inputs = inputs.provoking(fault);
            }
        })
    }

    fn output_stage(&mut self, live: bool) -> &mut Self {
        self.inputs(|inputs| *inputs = inputs.with_output_stage(live))
    }

    fn calibrated(mut self, position: i32) -> Self {
        self.drive.calibrate(position).unwrap();
        self
    }

    fn state(&self) -> State {
        self.drive.status().state
    }

    fn status(&self) -> Status {
        self.drive.status()
    }

    fn zsw(&self) -> u16 {
        zsw(&self.drive.status(), self.before)
    }

    fn position(&self) -> i32 {
        self.status().position
    }

    fn reasons(&mut self) -> Vec<Reason> {
        self.drive.take_refusal().map_or_else(Vec::new, |refusal| refusal.reasons().collect())
    }

    fn refusal_text(&mut self) -> String {
        self.drive.take_refusal().unwrap().to_string()
    }
}
