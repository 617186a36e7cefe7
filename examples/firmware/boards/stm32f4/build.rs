//! Tells the linker how a program lies in the memory of the chip, which `embassy-stm32` knows, and where the texts of `defmt` are.
fn main() {
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
}
