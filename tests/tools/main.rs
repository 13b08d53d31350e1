//! Tools as shops have them: libraries, assemblies in setups, shank and holder against a part.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

mod assembly;
mod cutting_data;
mod fusion;
mod libraries;
mod moves;
mod random;
#[path = "../wheels/sampled_tool.rs"]
mod sampled_tool;
