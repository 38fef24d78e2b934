//! Compiles the shaders.
fn main() {}
