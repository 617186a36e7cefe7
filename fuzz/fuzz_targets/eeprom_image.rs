//! See `invariants/eeprom_image.rs`.
#![no_main]

#[path = "../invariants/mod.rs"]
mod invariants;

libfuzzer_sys::fuzz_target!(|data: &[u8]| invariants::eeprom_image::check(data));
