//! Flank plans of real and synthetic parts: walls, floors, programs, and their check by `verify`.

mod fixed_axis;
mod plan;
mod program;
mod verify;
mod wall;
mod wheels;
