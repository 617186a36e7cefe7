//! An application for profirust, and its tests against an emulated drive: in this process, in virtual time.
//!
//! `cargo run --features master --example profirust_application` lets it work for a while and says what it did;
//! `cargo test --features master --example profirust_application` runs the tests at the end of the file. They take
//! milliseconds and no hardware, and try what nobody tries on a machine: a lost reply, a cable pulled out, a blocked shaft.

use core::time::Duration;

use profidrive::bench::Line;
use profidrive::client::{DriveClient, Goal, GoalOutcome};
use profidrive::devices::ag03::profibus::Config;
use profidrive::master::{Profirust, baudrate, peripheral};
use profidrive::profibus::fdl::Address;
use profidrive::profibus::ppo::Inputs;
use profidrive::time::{BaudRate, Instant};
use profirust::dp::{DpEvents, DpMaster, PeripheralEvent, PeripheralHandle};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};

/// The application: a carriage that goes to and fro between two positions, and goes on after every trouble.
struct Shuttle {
    drive: PeripheralHandle,
    client: DriveClient,
    ends: [i32; 2],
    trips: usize,
    troubles: Vec<String>,
}

impl Shuttle {
    fn new(drive: PeripheralHandle, ends: [i32; 2]) -> Self {
        Self { drive, client: DriveClient::default(), ends, trips: 0, troubles: Vec::new() }
    }

    /// To be called after every poll of profirust, on a real line as on an emulated one.
    fn handle(&mut self, now: Instant, dp: &mut DpMaster<'_>, events: &DpEvents) {
        let drive = dp.get_mut(self.drive);
        if !drive.is_running() {
            if self.client.zsw().is_some() {
                self.client.handle_data_exchange_lost();
            }
        } else if events.peripheral == Some((self.drive, PeripheralEvent::DataExchanged))
            && let Ok(inputs) = Inputs::parse(drive.pi_i())
        {
            self.client.handle_inputs(now, inputs);
            if self.client.zsw().is_some() && self.client.goal().is_none() {
                let next = self.next();
                self.client.pursue(now, next);
            }
        }
        self.client.handle_timeout(now);
        drive.pi_q_mut().copy_from_slice(&self.client.outputs());
    }

    /// What comes after the goal that is over.
    fn next(&mut self) -> Goal {
        match self.client.poll_outcome() {
            None | Some(GoalOutcome { goal: Goal::Acknowledge, result: Ok(_) }) => Goal::Enable,
            Some(GoalOutcome { goal, result: Ok(_) }) => {
                self.trips += usize::from(matches!(goal, Goal::MoveTo(_)));
                Goal::MoveTo(if self.trips.is_multiple_of(2) { self.ends[0] } else { self.ends[1] })
            }
            Some(GoalOutcome { result: Err(error), .. }) => {
                self.troubles.push(error.to_string());
                Goal::Acknowledge
            }
        }
    }
}

/// A master with the application, and an emulated AG03/1 as station 5.
fn machine() -> Result<(Line<Profirust<'static>>, Shuttle), Box<dyn core::error::Error>> {
    let mut dp = DpMaster::new(Vec::new());
    let drive = dp.add(peripheral(5, BaudRate::K1500));
    dp.enter_operate();
    let parameters = ParametersBuilder::new(2, baudrate(BaudRate::K1500))
        .watchdog_timeout(profirust::time::Duration::from_millis(100))
        .build_verified(&dp);
    let mut fdl = FdlActiveStation::new(parameters);
    fdl.set_online();
    let mut bus = Profirust::on_line(fdl, dp)?;
    bus.add_drive(Config::new(Address::station(5)?))?;
    Ok((bus, Shuttle::new(drive, [800, -800])))
}

/// Runs both until `done`, at most for 60 s of virtual time.
fn run(bus: &mut Line<Profirust<'_>>, shuttle: &mut Shuttle, done: impl Fn(&Shuttle) -> bool) -> bool {
    let outcome = bus.run_until(Duration::from_secs(60), |bus| {
        let events = bus.master.take_events();
        shuttle.handle(bus.now(), &mut bus.master.dp, &events);
        done(shuttle)
    });
    outcome.is_ok()
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let (mut bus, mut shuttle) = machine()?;
    let arrived = run(&mut bus, &mut shuttle, |shuttle| shuttle.trips == 10);
    println!("{} trips in {} of virtual time; all of them: {arrived}", shuttle.trips, bus.now());
    Ok(())
}

#[cfg(test)]
mod tests {
    use profidrive::devices::ag03::profibus::Device;

    use super::*;

    #[test]
    fn it_goes_to_and_fro() {
        let (mut bus, mut shuttle) = machine().unwrap();
        assert!(run(&mut bus, &mut shuttle, |shuttle| shuttle.trips == 4));
        let position = bus.device(5).unwrap().status().position;
        assert!((-810..=-790).contains(&position), "{position}");
        assert!(shuttle.troubles.is_empty(), "{:?}", shuttle.troubles);
    }

    #[test]
    fn lost_and_damaged_replies_do_not_stop_it() {
        let (mut bus, mut shuttle) = machine().unwrap();
        bus.inject(&["no-reply,rate=0.05".parse().unwrap(), "bit-errors,rate=0.05,seed=2".parse().unwrap()])
            .unwrap();
        assert!(run(&mut bus, &mut shuttle, |shuttle| shuttle.trips == 4));
    }

    #[test]
    fn it_goes_on_after_the_cable_was_pulled_out() {
        let (mut bus, mut shuttle) = machine().unwrap();
        assert!(run(&mut bus, &mut shuttle, |shuttle| shuttle.trips == 1));
        bus.inject(&["drop-request".parse().unwrap()]).unwrap();
        assert!(run(&mut bus, &mut shuttle, |shuttle| !shuttle.troubles.is_empty()
            || shuttle.client.zsw().is_none()));
        bus.run_for(Duration::from_millis(200));
        assert!(!bus.device(5).unwrap().status().operation_enabled, "its watchdog has switched it off");
        bus.inject(&[]).unwrap();
        assert!(run(&mut bus, &mut shuttle, |shuttle| shuttle.trips == 3));
    }

    #[test]
    fn it_acknowledges_the_fault_of_a_blocked_shaft_and_goes_on() {
        let (mut bus, mut shuttle) = machine().unwrap();
        assert!(run(&mut bus, &mut shuttle, |shuttle| shuttle.trips == 1));
        let block = |bus: &mut Line<Profirust<'_>>, blocked| {
            bus.with_station(5, |drive: &mut Device, now| {
                let inputs = profidrive::devices::ag03::drive::Inputs { blocked, ..*drive.inputs() };
                drive.set_inputs(now, inputs);
            })
            .unwrap();
        };
        block(&mut bus, true);
        assert!(run(&mut bus, &mut shuttle, |shuttle| !shuttle.troubles.is_empty()));
        assert!(shuttle.troubles[0].contains("fault"), "{:?}", shuttle.troubles);
        block(&mut bus, false);
        assert!(run(&mut bus, &mut shuttle, |shuttle| shuttle.trips == 3));
    }
}
