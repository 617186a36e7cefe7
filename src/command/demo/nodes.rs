//! The stories of the devices on CANopen.

use core::time::Duration;
use std::io::Write;

use crate::can_bus::canopen::Address;
use crate::can_bus::canopen::cob_id::CobId;
use crate::host::can::Product;

use super::node_stage::{NODE, NodeStage};
use super::page::Trouble;

/// NMT commands to the device.
const NMT: u16 = 0x000;
const START: [u8; 2] = [0x01, NODE];
const RPDO_1: u16 = 0x200 + NODE as u16;
const RPDO_3: u16 = 0x400 + NODE as u16;
/// 180h plus the node number, the identifier of TPDO 1, and the same with bit 31: off.
const TPDO_1: u32 = 0x180 + NODE as u32;
const OFF: u32 = CobId::INVALID;

/// Plays the story of a device.
pub(super) fn play(product: &'static Product, out: &mut dyn Write) -> Result<(), Trouble> {
    let mut stage = NodeStage::open(product, out)?;
    stage.page.title("Start-up: the boot-up of the device, then its identity")?;
    stage.wait("boot-up")?;
    if let Some((_, tell)) = STORIES.iter().find(|(name, _)| *name == product.name) {
        tell(&mut stage)?;
    }
    stage.page.title("That is all")?;
    stage.page.text(&format!(
        "The same device for any CANopen master that speaks slcan: profidrive emulate --node {NODE},device={} \
         --link slcan-tcp:127.0.0.1:0. Everything about it: profidrive emulate --help.",
        product.name
    ))
}

/// What happens after the boot-up, of the devices that have a story.
type Story = fn(&mut NodeStage<'_>) -> Result<(), Trouble>;
const STORIES: &[(&str, Story)] = &[("ag03-1", positioning_drive), ("ap10", indicator), ("asda-a2", servo)];

fn positioning_drive(stage: &mut NodeStage<'_>) -> Result<(), Trouble> {
    stage.read(0x1000, 0, "1000h:00")?;
    stage.read(0x1008, 0, "AG03")?;

    stage.page.title("Parameters by SDO")?;
    stage.page.text("The calibration value becomes the position of the standing shaft.")?;
    stage.write(Address::new(0x607C, 0), &2_500_i32.to_le_bytes(), "written")?;
    stage.read(0x6064, 0, "2500")?;
    stage.page.text("A control word before the node is started is refused, with the code of the reason.")?;
    stage.write(Address::new(0x6040, 0), &[0x06, 0x01], "08000022h")?;

    stage.page.title("Enabling: control words by RPDO 1, the status word by TPDO 1")?;
    stage.send(NMT, &START)?;
    stage.wait("switch on disabled")?;
    stage.send(RPDO_1, &[0x06, 0x01])?;
    stage.wait("ready to switch on")?;
    stage.send(RPDO_1, &[0x07, 0x01])?;
    stage.wait("switched on")?;
    stage.send(RPDO_1, &[0x0F, 0x01])?;
    stage.wait("operation enabled")?;

    stage.page.title("A travel job: RPDO 3 is control word and target position")?;
    stage.send(RPDO_3, &[0x1F, 0x00, 0x88, 0x13, 0x00, 0x00])?;
    stage.wait("target reached")?;
    stage.read(0x6064, 0, "5000")?;

    stage.page.title("A fault, and how to leave it")?;
    stage.page.text("An internal error is simulated: EMCY, error register and state show it.")?;
    stage.provoke("F")?;
    stage.wait("EMCY")?;
    stage.wait("fault")?;
    stage.read(0x1003, 1, "1003h:01")?;
    stage.page.text("The cause is removed. Bit 7 of the control word resets the fault.")?;
    stage.repair();
    stage.send(RPDO_1, &[0x80, 0x00])?;
    stage.wait("switch on disabled")
}

fn indicator(stage: &mut NodeStage<'_>) -> Result<(), Trouble> {
    stage.read(0x1000, 0, "1000h:00")?;
    stage.read(0x1008, 0, "AP10")?;
    stage.page.text("Its display test is over.")?;
    stage.pass(Duration::from_millis(400))?;
    stage.look("[0]")?;

    stage.page.title("A set point: RPDO 1 is value and control word, row 2 shows it")?;
    stage.page.text("TPDO 1 is sent every 100 ms; only changes are shown here.")?;
    stage.write(Address::new(0x1800, 5), &100_u16.to_le_bytes(), "written")?;
    stage.send(NMT, &START)?;
    stage.send(RPDO_1, &[0x64, 0, 0, 0, 0, 0, 0x04, 0])?;
    stage.wait("set point 1 valid")?;
    stage.look("100")?;

    stage.page.title("A person turns the shaft in the direction of the arrow")?;
    stage.input("shaft_revolutions", 50.0 / 880.0);
    stage.wait("50")?;
    stage.look("[50]")?;
    stage.input("shaft_revolutions", 100.0 / 880.0);
    stage.wait("100")?;
    stage.look("[100]")?;

    stage.page.title("The battery becomes low")?;
    stage.provoke("battery-critical")?;
    stage.wait("EMCY")?;
    stage.wait("battery critical")?;
    stage.look("battery critical")?;
    stage.page.text("The battery is replaced.")?;
    stage.repair();
    stage.pass(Duration::from_millis(200))?;
    stage.look("[100]")
}

fn servo(stage: &mut NodeStage<'_>) -> Result<(), Trouble> {
    stage.read(0x1000, 0, "1000h:00")?;
    stage.read(0x1018, 2, "1018h:02")?;

    stage.page.title("Mapping: TPDO 1 is to be status word and position, after every SYNC")?;
    stage.write(Address::new(0x1800, 1), &(TPDO_1 | OFF).to_le_bytes(), "written")?;
    stage.write(Address::new(0x1A00, 0), &[0], "written")?;
    stage.write(Address::new(0x1A00, 1), &0x6041_0010_u32.to_le_bytes(), "written")?;
    stage.write(Address::new(0x1A00, 2), &0x6064_0020_u32.to_le_bytes(), "written")?;
    stage.write(Address::new(0x1A00, 0), &[2], "written")?;
    stage.write(Address::new(0x1800, 2), &[1], "written")?;
    stage.write(Address::new(0x1800, 1), &TPDO_1.to_le_bytes(), "written")?;
    stage.send(NMT, &START)?;

    stage.page.title("Enabling: the state machine of CiA 402, by SDO here")?;
    let controlword = Address::new(0x6040, 0);
    stage.write(Address::new(0x6060, 0), &[1], "written")?;
    stage.write(controlword, &[0x06, 0], "written")?;
    stage.sync_until("ready to switch on")?;
    stage.write(controlword, &[0x07, 0], "written")?;
    stage.sync_until("switched on")?;
    stage.write(controlword, &[0x0F, 0], "written")?;
    stage.sync_until("operation enabled")?;

    stage.page.title("Profile position: a target, then the rising edge of bit 4")?;
    stage.write(Address::new(0x6081, 0), &1_000_000_u32.to_le_bytes(), "written")?;
    stage.write(Address::new(0x607A, 0), &500_000_i32.to_le_bytes(), "written")?;
    stage.write(controlword, &[0x1F, 0], "written")?;
    stage.sync_until("set-point acknowledge")?;
    stage.write(controlword, &[0x0F, 0], "written")?;
    stage.sync_until("target reached")?;

    stage.page.title("An alarm, and how to leave it")?;
    stage.page.text("The encoder fails: EMCY says which alarm, the panel shows it, the servo is off.")?;
    stage.provoke("011")?;
    stage.wait("EMCY")?;
    stage.look("011")?;
    stage.sync_until("fault")?;
    stage.read(0x603F, 0, "7305h")?;
    stage.page.text("The cause is removed. Bit 7 of the control word resets the alarm.")?;
    stage.repair();
    stage.write(controlword, &[0x80, 0], "written")?;
    stage.sync_until("switch on disabled")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::list::Device;

    fn story(product: &'static Product) -> String {
        let mut out = Vec::new();
        let played = play(product, &mut out);
        let text = String::from_utf8(out).unwrap();
        assert!(played.is_ok(), "{}: {played:?}\n{text}", product.name);
        text
    }

    #[test]
    fn every_device_has_a_story_on_a_page_of_80_columns_that_is_always_the_same() {
        assert!(STORIES.iter().all(|(name, _)| Product::named(name).is_some()));
        for product in Device::products() {
            let told = story(product);
            assert!(told.lines().all(|line| line.chars().count() <= 80), "{told}");
            assert!(!told.contains('\u{1b}'), "plain text");
            assert_eq!(told, story(product));
        }
    }
}
