//! The `vanecut` binary.
fn main() {}
