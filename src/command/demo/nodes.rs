//! The stories of the devices on CANopen.

use std::io::Write;

use crate::devices::story::PLACE;
use crate::host::can::Product;

use super::node_stage::NodeStage;
use super::page::Trouble;

/// Plays the story of a device.
pub(super) fn play(product: &'static Product, out: &mut dyn Write) -> Result<(), Trouble> {
    let mut stage = NodeStage::open(product, out)?;
    stage.page.title("Start-up: the boot-up of the device, then its identity")?;
    stage.wait("boot-up")?;
    product.story.iter().try_for_each(|act| stage.play(act))?;
    stage.page.title("That is all")?;
    stage.page.text(&format!(
        "The same device for any CANopen master that speaks slcan: profidrive emulate --node {PLACE},device={} \
         --link slcan-tcp:127.0.0.1:0. Everything about it: profidrive emulate --help.",
        product.name
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn story(product: &'static Product) -> String {
        let mut out = Vec::new();
        let played = play(product, &mut out);
        let text = String::from_utf8(out).unwrap();
        assert!(played.is_ok(), "{}: {played:?}\n{text}", product.name);
        text
    }

    #[test]
    fn every_device_has_a_story_on_a_page_of_80_columns_that_is_always_the_same() {
        for product in Product::all() {
            assert!(!product.story.is_empty(), "{}", product.name);
            let told = story(product);
            assert!(told.lines().all(|line| line.chars().count() <= 80), "{told}");
            assert!(!told.contains('\u{1b}'), "plain text");
            assert_eq!(told, story(product));
        }
    }
}
