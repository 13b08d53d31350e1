//! Five-axis machines: kinematics, posts, programs read back, limits.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

mod calls;
mod choice;
mod faults;
mod figures;
mod kinematics;
mod limits;
mod links;
mod placement;
mod planned;
mod programs;
mod retract;
mod round_trips;
mod table;
mod times;
