//! The command `profidrive`.
fn main() {}
