//! Flank plans of real and synthetic parts: walls, floors, programs, and their check by `verify`.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

mod channels;
mod fixed_axis;
mod holders;
mod mixed;
mod parts;
mod plan;
mod program;
mod splitters;
mod verify;
mod wall;
mod wheels;
