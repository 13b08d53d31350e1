//! Plunge plans of real and random parts, and the stages of the planner.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

mod accessible;
mod assess;
mod blank;
mod channel;
mod channels;
mod disc;
mod drop_cutter;
mod edits;
mod floor;
mod free_of_contact;
mod goals;
mod inspect;
mod narrow_contact;
mod outline;
mod own_files;
mod plan;
mod probe;
mod program;
mod samples;
mod splitters;
mod standing;
mod tool_choice;
mod wall_axes;
