//! Vanecut plans the rough milling of centrifugal impellers.
//!
//! Modules, innermost first; each depends only on modules listed before it (`tests/layering.rs`):
//!
//! | module | contents |
//! |---|---|
//! | [`error`] | codes of the errors that a user sees |
//! | [`monitor`] | cancellation and progress of long work |
//! | [`palette`] | colours of pictures and window |
//! | [`geometry`] | curves, surfaces of revolution, solids of cutters, root finding, distances |
//! | [`part`] | impeller, channel, blade sides, blank, workpiece |
//! | [`setup`] | allowances, clearances, tools, machine, their defaults and faults |
//! | [`mesh`] | triangle meshes of a part, and parts from triangle meshes |
//! | [`toolpath`] | programs as data: tools, moves, sections, rows |
//! | [`machine`] | five-axis machines: chain of axes, rotary positions, links, time |
//! | [`cutting`] | a cutter against part and stock: shank, holder, drop-cutter depth, links, core contact |
//! | [`assess`] | machinability before any plan: twist, bow, depth, width, reach ([assessment paper]) |
//! | [`plunge`] | the plunge planner, one file per stage of the [plunge paper] |
//! | [`flank`] | the flank planner ([flank paper]): layers, regions, passes, and the cutter axes along them |
//! | [`stock`] | the heightfield of stock left on the channel floor, its CPU kernel; the stock as a solid |
//! | [`tradeoff`] | time against stock: which plunges of a plan are worth their time |
//! | [`verify`] | judges any program against a part |
//! | [`io`] | readers and writers of part, setup, program and plan files |
//! | [`job`] | planning jobs: request, progress, cancel, latest result |
//! | [`study`] | many plans: axes of variation, shards, results, merge, Pareto set |
//! | `gpu` | graphics device, compute kernel, renderer of meshes, lines and instances |
//! | `drawing` | parts, plans and stock as meshes, lines and instances |
//! | [`report`] | documents: setup sheet of a plan, page of an assessment |
//! | `app` | the window (egui) |
//! | `cli` | the command line (clap) |
//!
//! Lengths are mm, angles radians, times seconds, feed rates mm/min; files and user interfaces show degrees.
//! The axis of rotation is Z. `docs/REFERENCES.md` cites the papers.

#[cfg(feature = "window")]
pub mod app;
pub mod assess;
#[cfg(feature = "cli")]
pub mod cli;
pub mod cutting;
#[cfg(feature = "gpu")]
pub mod drawing;
pub mod error;
pub mod flank;
pub mod geometry;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod io;
pub mod job;
pub mod machine;
pub mod mesh;
pub mod monitor;
pub mod palette;
pub mod part;
pub mod plunge;
pub mod report;
pub mod setup;
pub mod stock;
pub mod study;
pub mod toolpath;
pub mod tradeoff;
pub mod verify;
