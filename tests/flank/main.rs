//! Flank plans of real and made parts: walls, floors, programs, and what `verify` says of them.

mod fixed_axis;
mod plan;
mod program;
mod verify;
mod wall;
mod wheels;
