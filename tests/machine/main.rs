//! Five-axis machines: kinematics, posts, programs read back, limits.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

mod faults;
mod figures;
mod kinematics;
mod limits;
mod programs;
mod round_trips;
mod times;
