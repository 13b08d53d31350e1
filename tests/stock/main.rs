//! The stock as a solid: by itself, and on a sample wheel.

mod solid;
mod wheel;
